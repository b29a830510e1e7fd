//! Questions to what gives the sample: whether it is complete, filled, or there at all.

use std::collections::BTreeSet;

use super::sample::has_word;
use super::{Gates, MAX_ORIGINS, Way};
use crate::count::fed::named;
use crate::flow::{About, ChangeKind, Computed, Effect, NodeId, Place, Test};
use crate::index::Ty;

/// Words in the names of methods that ask whether a sample is there: `data_ready`, `has_new`.
const READINESS: &[&str] = &[
    "ready",
    "dataready",
    "available",
    "has",
    "drdy",
    "can_read",
    "poll",
    "fresh",
    "conversion_done",
    "new",
    "pending",
    "updated",
    "valid",
    "stale",
    "data",
];

/// Words in the names of methods that tell how much is there to be read.
const AMOUNTS: &[&str] = &[
    "is_empty",
    "len",
    "is_full",
    "pending",
    "available",
    "avail",
    "queued",
    "unread",
    "fifo_empty",
    "fifo_level",
    "fifo_count",
    "fifo_len",
];

/// Words in the names of methods that give the state of a device, of which a bit is asked.
const STATUS: &[&str] = &["status", "flags", "state", "isr"];

/// Words in the names of registers that tell the state of a peripheral: `adc.isr.read().eoc().bit_is_set()`.
const STATUS_REGISTERS: &[&str] = &["sr", "isr", "csr", "status", "stat", "flags", "events", "ris", "mis"];

/// How many of them no measured value is called by.
const CERTAIN: usize = 9;

/// Words in the names of methods that are fed with parts of a message, and answer whether it is complete.
const PARSING: &[&str] =
    &["push", "feed", "parse", "decode", "consume", "accept", "process", "put", "ingest", "digest", "add", "receive"];

/// Words in the names of truth values that come with a sample and are orders or states of the machine, not marks of the sample.
const ORDERS: &[&str] = &[
    "arm",
    "armed",
    "disarm",
    "disarmed",
    "enable",
    "enabled",
    "engage",
    "engaged",
    "estop",
    "e_stop",
    "emergency",
    "kill",
    "pause",
    "paused",
    "manual",
    "obstacle",
    "bypass",
    "mute",
    "muted",
    "brake",
];

/// Words in the names of what numbers the samples, or tells when they were taken.
const STAMPS: &[&str] = &[
    "seq",
    "sequence",
    "stamp",
    "timestamp",
    "time",
    "ts",
    "t",
    "tick",
    "ticks",
    "counter",
    "count",
    "epoch",
    "tow",
    "itow",
    "generation",
    "id",
    "number",
    "index",
];

/// Whether one of these words stands in a name.
fn is_named(name: &str, words: &[&str]) -> bool {
    words.iter().any(|word| has_word(name, word))
}

impl Gates<'_, '_> {
    /// `if ring.write != ring.read { f.update(ring.take()) }`: two numbers that count what is put into a buffer and what is taken
    /// from it, and the sample comes from there.
    pub(super) fn asks_ring(&self, test: &Test) -> bool {
        let graph = self.search.graph;
        let Some(subject) = test.subject.map(|id| &graph.subjects[id.0 as usize]) else { return false };
        let [first, second] = subject.reads.as_slice() else { return false };
        let (Some((_, owner)), Some((_, other))) = (first.steps.split_last(), second.steps.split_last()) else {
            return false;
        };
        let asked = [first, second];
        let counts = |place: &Place| {
            let is_counted = |id: NodeId| {
                let kind = graph.changes.get(&id).map(|change| change.kind);
                kind.is_some_and(|kind| kind.counts() || kind == ChangeKind::Wraps)
            };
            self.is_number(place) && (self.assigning(place).any(is_counted) || self.calls_write(place))
        };
        if first.base != second.base || owner != other || first == second || !asked.iter().any(|place| counts(place)) {
            return false;
        }
        let owner = Place { base: first.base, steps: owner.into() };
        let fed = &self.fed().places;
        let is_in = |place: &&Place| place.lies_at(&owner);
        // A field of `self` beside the numbers is its buffer if one of them is the index.
        let is_indexed = !self.is_self(&owner) || asked.iter().any(|place| fed.contains(place));
        asked.iter().all(|place| self.is_number(place))
            && is_indexed
            && fed.iter().filter(is_in).any(|place| !asked.contains(&place) && !self.is_self(place))
    }

    /// Whether a way goes past the update because the sample is there: `if !imu.data_ready() { f.update(imu.read()) }`.
    pub(super) fn skips_ready(&self, test: &Test, at: NodeId, way: &Way) -> bool {
        let says_ready = |name: &String| {
            let mut words = name.split('_');
            let is_certain = words.clone().any(|word| matches!(word, "ready" | "available" | "drdy"));
            is_certain
                && words.all(|word| matches!(word, "is" | "data" | "sample" | "new" | "ready" | "available" | "drdy"))
        };
        let says_late = |name: &String| has_word(name, "stale");
        let holds = way.after(at) == self.search.graph.node(at).next.first().copied();
        if !holds && !test.about.is_combined && matches!(test.about.names.as_slice(), [name] if says_late(name)) {
            return true;
        }
        holds && !test.about.is_combined && matches!(test.about.names.as_slice(), [name] if says_ready(name))
    }

    fn is_self(&self, place: &Place) -> bool {
        place.steps.is_empty() && place.base_var().is_some_and(|var| self.search.graph.var(var).name == "self")
    }

    /// `if parser.push(byte) { f.update(parser.value()) }`: the object that is fed says whether the sample is complete that is then
    /// read from it.
    pub(super) fn is_complete(&self, test: &Test) -> bool {
        let about = &test.about;
        let kept = self.kept_answer(test);
        let (names, reads) = match kept {
            // Children stand before their parents, and the last comes first.
            Some(computed) => (&computed.calls, computed.places.iter().rev().collect::<Vec<_>>()),
            None => (&about.names, about.reads.iter().collect()),
        };
        let (Some(name), Some((first, more))) = (names.first(), reads.split_first()) else { return false };
        let owners = more.iter().take_while(|place| place.lies_at(first));
        let object = if kept.is_some() { owners.last().unwrap_or(first) } else { first };
        !about.is_combined
            && PARSING.iter().any(|word| has_word(name, word))
            && !self.is_self(object)
            && !matches!(self.ty(object), Some(Ty::Bool | Ty::Int | Ty::Float | Ty::Char))
            && self.fed().places.iter().any(|place| place.lies_at(object))
    }

    /// `if adc.read_into(&mut sample) { f.update(sample) }`: what the call writes is the sample.
    pub(super) fn fills_sample(&self, test: &Test) -> bool {
        let about = &test.about;
        if let Some(computed) = self.kept_answer(test) {
            let is_plain = |place: &&Place| matches!(self.ty(place), Some(Ty::Int | Ty::Float));
            let mut plain = computed.places.iter().filter(is_plain).peekable();
            return plain.peek().is_some() && plain.all(|place| self.is_filled_to_feed(place));
        }
        !about.is_combined && !about.lent.is_empty() && about.lent.iter().all(|place| self.is_filled_to_feed(place))
            || self.fills_by_number(test)
    }

    /// Whether what a place holds is written by what it is lent to, and fed.
    fn is_filled_to_feed(&self, place: &Place) -> bool {
        let graph = self.search.graph;
        let is_unseen = |id: NodeId| {
            let is_foreign = !graph.changes.contains_key(&id) || self.is_read_in_place(id);
            is_foreign && matches!(&graph.node(id).effect, Effect::Write(write) if write.head.is_none())
        };
        // `let mut buffer = [0; 4];`
        let is_declared =
            |id: &NodeId| matches!(&graph.node(*id).effect, Effect::Set(_)) && !graph.changes.contains_key(id);
        let filled = self.assigning(place).filter(|id| !self.is_set_back(*id, place) && !is_declared(id));
        let mut filled = filled.peekable();
        let is_filled = filled.peek().is_some() && filled.all(is_unseen);
        (is_filled || self.calls_write(place)) && self.fed().places.iter().any(|other| other.overlaps(place))
    }

    /// `let n = port.read(&mut frame); if n == 0 { continue; }`, `if adc.read_into(&mut sample) != 0 { continue; }`: the call that
    /// fills the sample tells by a number how much of it there is, or whether there is any.
    fn fills_by_number(&self, test: &Test) -> bool {
        let graph = self.search.graph;
        let about = &test.about;
        let is_constant = |name: &String| !name.chars().any(char::is_lowercase);
        let is_plain = |place: &Place| matches!(self.ty(place), Some(Ty::Bool | Ty::Int | Ty::Float | Ty::Char));
        if about.numbers.len() != 1 || about.is_masked || about.is_remainder {
            return false;
        }
        if !about.lent.is_empty() {
            let is_asked = |place: &Place| !is_plain(place) || about.lent.contains(place);
            return about.reads.iter().all(is_asked) && about.lent.iter().all(|place| self.is_filled_to_feed(place));
        }
        let [number] = about.reads.as_slice() else { return false };
        let is_number = matches!(self.ty(number), None | Some(Ty::Int | Ty::Unknown));
        let var = number.base_var().filter(|_| number.steps.is_empty() && is_number && !self.outlives(number));
        let Some(computed) = var.and_then(|var| graph.computed.get(&var)) else { return false };
        let wraps = |name: &String| name.starts_with("unwrap") || matches!(name.as_str(), "expect" | "ok" | "map_err");
        let calls: BTreeSet<&String> = computed.calls.iter().filter(|name| !wraps(name)).collect();
        // What the standard library fills, as `read` does, is computed from what it is called on.
        let is_from_call = |place: &Place| {
            let made = place.base_var().and_then(|var| graph.computed.get(&var));
            let is_made = made.is_some_and(|made| made.calls.iter().any(|name| calls.contains(name)));
            is_made && self.fed().places.iter().any(|other| other.overlaps(place))
        };
        // The device itself is asked for more than samples.
        let is_buffer = |place: &Place| {
            let ty = self.ty(place);
            let ty = ty.as_ref().map(Ty::peel);
            ty.is_some_and(|ty| matches!(ty, Ty::Int | Ty::Float) || crate::types::item_of(ty).is_some())
        };
        let is_filled = |place: &Place| {
            place != number && is_buffer(place) && (self.is_filled_to_feed(place) || is_from_call(place))
        };
        about.names.iter().all(is_constant) && calls.len() == 1 && named(&computed.places).into_iter().any(is_filled)
    }

    /// A readiness test of the very object that the fed sample is read from.
    pub(super) fn is_readiness(&self, test: &Test) -> bool {
        // `let ready = imu.is_ready(); if ready { … }`
        let kept = self.kept_answer(test);
        let (names, reads) =
            kept.map_or((&test.about.names, &test.about.reads), |computed| (&computed.calls, &computed.places));
        let is_masked = test.about.is_masked;
        let is_flag = |place: &&Place| {
            !place.steps.is_empty() && (self.ty(place) == Some(Ty::Bool) || is_masked && self.is_number(place))
        };
        let flags: Vec<String> = reads.iter().filter(is_flag).map(|place| self.last_name(place)).collect();
        let asks_register = names.iter().any(|name| matches!(name.as_str(), "bit_is_set" | "bit_is_clear" | "bit"))
            && names
                .iter()
                .cloned()
                .chain(reads.iter().map(|place| self.last_name(place)))
                .any(|name| STATUS_REGISTERS.iter().any(|word| has_word(&name, word)));
        let asks =
            |words: &[&str]| names.iter().chain(&flags).any(|name| words.iter().any(|word| has_word(name, word)));
        if test.about.is_presence {
            return false;
        }
        if self.is_marked(test) || self.is_complete(test) || self.fills_sample(test) || self.asks_ring(test) {
            return true;
        }
        let asks_amount = asks(AMOUNTS);
        // A bit of a status register.
        let made_by = |place: &Place| place.base_var().and_then(|var| self.search.graph.computed.get(&var));
        let says_status = |name: &String| STATUS.iter().any(|word| has_word(name, word));
        let asks_bit = is_masked
            && (asks(STATUS) || reads.iter().filter_map(made_by).flat_map(|made| &made.calls).any(says_status));
        // How it was compared before it was kept is not known.
        let readiness = if kept.is_some() { &READINESS[..CERTAIN] } else { READINESS };
        if !(asks_amount || ((asks_bit || asks_register || asks(readiness)) && !test.about.is_comparison)) {
            return false;
        }
        if self.asks_other_part(names, reads) {
            return false;
        }
        let is_self = |place: &Place| {
            place.steps.is_empty() && place.base_var().is_some_and(|var| self.search.graph.var(var).name == "self")
        };
        let fed = &self.fed().places;
        // A getter asks a part of the object.
        let is_read_from = |place: &Place| {
            let is_part = asks_amount || asks_register || is_flag(&place);
            let Some((_, owner)) = place.steps.split_last().filter(|_| is_part) else { return false };
            let owner = Place { base: place.base, steps: owner.into() };
            let is_in = |other: &&Place| other.lies_at(&owner);
            // The bits that come with a sample that a helper is given are a part of it.
            let is_sample = is_masked
                && self.is_helper
                && owner.base_var().is_some_and(|var| !matches!(self.search.graph.var(var).ty, Ty::Ref(..)));
            !(is_self(&owner) || is_sample) && fed.iter().filter(is_in).any(|other| other != place)
        };
        // `let status = imu.status(); if !status.drdy { … }`, `if !status.gyro_ready() { … }`
        let is_answered = |place: &&Place| {
            let is_plain = || matches!(self.ty(place), Some(Ty::Bool | Ty::Int | Ty::Float | Ty::Char));
            let is_object = || place.steps.is_empty() && kept.is_none() && !is_plain();
            (is_flag(place) || is_object())
                && (asks_bit || asks(&READINESS[..CERTAIN]))
                && made_by(place)
                    .is_some_and(|made| made.places.iter().any(|from| !is_self(from) && fed.contains(from)))
        };
        reads.iter().any(|place| !is_self(place) && fed.contains(place) || is_read_from(place))
            || reads.iter().any(|place| is_answered(&place) || self.is_mailbox(place))
            || self.is_asked_by_helper(&Computed { places: reads.clone(), calls: names.clone() })
    }

    /// `if self.is_fresh { self.is_fresh = false; f.update(self.reading); }`: the cycle only takes the flag down, and leaves the fed
    /// value beside it as whoever raises the flag has put it there.
    fn is_mailbox(&self, flag: &Place) -> bool {
        let Some((_, owner)) = flag.steps.split_last() else { return false };
        let owner = Place { base: flag.base, steps: owner.into() };
        let writing: Vec<NodeId> = self.assigning(flag).collect();
        let takes_down = |id: &NodeId| match &self.search.graph.node(*id).effect {
            Effect::Set(set) | Effect::Write(set) => set.place == *flag && set.head.as_deref() == Some("false"),
            _ => false,
        };
        let is_left =
            |place: &Place| self.assigning(place).next().is_none() && !self.calls_write(place) && !self.is_self(place);
        let is_beside = |place: &&Place| {
            let is_reading = matches!(self.ty(place).as_ref().map(Ty::peel), Some(Ty::Int | Ty::Float | Ty::Array(..)));
            is_reading && place.base == owner.base && place.steps.len() == flag.steps.len()
        };
        let is_fed = |place: &Place| place.steps.starts_with(&owner.steps) && is_left(place);
        self.ty(flag) == Some(Ty::Bool)
            && self.is_self(&owner)
            && !writing.is_empty()
            && writing.iter().all(takes_down)
            && !self.calls_write(flag)
            && self.fed().places.iter().filter(is_beside).any(is_fed)
    }

    /// What a truth value was computed from that keeps the answer of the only call behind it, or is one of its answers:
    /// `let (has_gyro, has_accel) = imu.data_ready()?; match (has_gyro, has_accel) { … }`.
    pub(super) fn kept_answer(&self, test: &Test) -> Option<&Computed> {
        let [place] = test.about.reads.as_slice() else { return None };
        // Of a number, a bit is asked: `let status = imu.status(); if status & DRDY == 0 { … }`.
        let is_answer = self.ty(place) == Some(Ty::Bool) || test.about.is_masked && self.is_number(place);
        let is_constant = |name: &String| !name.chars().any(char::is_lowercase);
        let is_kept = place.steps.is_empty() && test.about.names.iter().all(is_constant) && is_answer;
        let computed = self.search.graph.computed.get(&place.base_var().filter(|_| is_kept)?)?;
        let mut calls = computed.calls.iter().filter(|name| !matches!(name.as_str(), "unwrap" | "expect"));
        let (Some(call), None) = (calls.next(), calls.next()) else { return None };
        (!self.is_given_otherwise(place, call, 0)).then_some(computed)
    }

    /// Whether a value may be one that another call gave, or whoever called the function: of `if 3 < pins.len() { pins[3] } else { false }`,
    /// the call tells nothing.
    fn is_given_otherwise(&self, place: &Place, call: &String, copies: u32) -> bool {
        let graph = self.search.graph;
        let is_of_call = |var| graph.computed.get(&var).is_some_and(|computed| computed.calls.contains(call));
        let is_about = |about: &About| {
            let read = about.reads.iter().filter_map(Place::base_var);
            about.is_presence || about.names.contains(call) || read.into_iter().any(is_of_call)
        };
        let asks_another = |(branch, _): (NodeId, NodeId)| matches!(&graph.node(branch).effect, Effect::Branch(test) if !is_about(&test.about));
        self.assigning(place).any(|id| match &graph.node(id).effect {
            // `!pins.is_empty() && pins[0]`
            Effect::Set(set) | Effect::Write(set) if set.head.is_some() => {
                self.leading_to(id).into_iter().flatten().any(asks_another)
            }
            Effect::Set(set) | Effect::Write(set) => {
                let from = set.same_as.map(Place::var).or_else(|| set.from.clone());
                from.is_some_and(|from| {
                    let var = from.base_var();
                    let is_named = var.is_some_and(|var| !graph.var(var).name.is_empty() && !is_of_call(var));
                    let is_copy = from.steps.is_empty() && copies < MAX_ORIGINS;
                    is_named || is_copy && self.is_given_otherwise(&from, call, copies + 1)
                })
            }
            _ => false,
        })
    }

    /// `if fix.seq != self.seq { self.seq = fix.seq; f.update(fix.x); }`: the sample is none if it is still the last one, whose number
    /// or time is kept where a new one is fed.
    pub(super) fn asks_whether_new(&self, test: &Test, way: &Way) -> bool {
        let [first, second] = test.about.reads.as_slice() else { return false };
        // `fix.seq()`, `last == Some(fix.seq)`
        let mut called = test.about.names.iter().filter(|name| *name != "Some");
        let called = (called.next(), called.next());
        let (method, None) = called else { return false };
        if !test.about.is_combined || test.about.is_remainder {
            return false;
        }
        let is_new = |new: &Place, kept: &Place| {
            let name = method.cloned().unwrap_or_else(|| self.last_name(new));
            let is_from_new = |id: NodeId| {
                let change = self.search.graph.changes.get(&id).map(|change| &change.computed);
                change.is_some_and(|computed| {
                    computed.places.contains(new)
                        && computed.places.iter().all(|place| place.base == new.base)
                        && computed.calls.iter().all(|call| call == "Some" || Some(call) == method)
                })
            };
            let mut keeping = self.assigning(kept).peekable();
            let is_kept = keeping.peek().is_some() && keeping.all(|id| is_from_new(id) && !way.nodes.contains(&id));
            let is_fed = |other: &Place| match method {
                Some(_) => other == new,
                None => other.base == new.base && !other.steps.is_empty() && !other.overlaps(new),
            };
            (method.is_some() || !self.outlives(new))
                && self.outlives(kept)
                && is_named(&name, STAMPS)
                && is_kept
                && self.fed().places.iter().any(is_fed)
        };
        is_new(first, second) || is_new(second, first)
    }

    /// A truth value that came with the sample and says whether it is one: `if !packet.valid { continue; }`.
    fn is_marked(&self, test: &Test) -> bool {
        let graph = self.search.graph;
        let [place] = test.about.reads.as_slice() else { return false };
        let Some(var) = place.base_var() else { return false };
        let is_truth = matches!(self.ty(place), Some(Ty::Bool)) && !is_named(&self.last_name(place), ORDERS);
        let made_by = graph.computed.get(&var).filter(|computed| !computed.calls.is_empty());
        let Some(made_by) = made_by.filter(|_| is_truth && test.about.names.is_empty() && !self.outlives(place)) else {
            return false;
        };
        let fed = &self.fed().places;
        if !place.steps.is_empty() {
            return fed.iter().any(|other| other.base == place.base && !other.steps.is_empty() && other != place);
        }
        // `let (is_valid, sample) = imu.read();`
        let is_beside = |other: &Place| {
            other.base_var().is_some_and(|other| {
                let computed = graph.computed.get(&other);
                other != var
                    && graph.read_at.get(&var) == graph.read_at.get(&other)
                    && computed.is_some_and(|own| own.calls == made_by.calls && own.places == made_by.places)
            })
        };
        fed.iter().any(is_beside) && !fed.contains(place)
    }
}
