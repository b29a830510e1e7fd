//! Gates of events: what was received in this iteration, and flags that are raised elsewhere.

use std::collections::BTreeSet;

use super::{Gates, contains_any};
use crate::count::instances::inner;
use crate::count::search::Region;
use crate::flow::{
    Base, CallSite, Effect, LoopId, NodeId, Place, Rounds, Test, Var, VarInfo, asks_state, is_receiving,
    is_receiving_something, is_waiting,
};
use crate::index::{Shape, Ty};

/// Parts of the names of parameters and types that are events.
const EVENT_WORDS: &[&str] = &["event", "evt", "message", "msg", "packet", "request", "notification", "telegram"];

/// Parts of the names of what is an event, or the device that brings one, or a wish that lasts.
const DOUBTFUL_WORDS: &[&str] = &["command", "cmd", "signal", "action", "key", "button", "note", "edge", "trigger"];

/// What looks into an option or a result without getting something new.
const LOOKING: &[&str] = &[
    "as_ref",
    "as_mut",
    "as_deref",
    "as_deref_mut",
    "clone",
    "cloned",
    "copied",
    "get",
    "get_mut",
    "borrow",
    "borrow_mut",
    "lock",
    "read",
    "write",
    "load",
    "take",
    "replace",
    "unwrap",
    "expect",
    "ok",
    "first",
    "last",
    "peek",
    "filter",
    "map",
];

/// What is asked of a line of text, and what is made of it before.
const TEXT_QUESTIONS: &[&str] = &[
    "trim",
    "trim_start",
    "trim_end",
    "as_str",
    "is_empty",
    "starts_with",
    "ends_with",
    "contains",
    "eq_ignore_ascii_case",
];

/// Whether what one thing answers is compared with something constant: `frame.id() == WHEEL_SPEED`.
fn compares_answer(test: &Test) -> bool {
    let about = &test.about;
    let asked = about.reads.iter().filter(|place| place.base_var().is_some());
    let answers = about.names.iter().filter(|name| !is_constant(name));
    about.is_combined && !about.is_remainder && answers.count() == 1 && asked.count() == 1
}

/// Whether what is named in a condition is a constant or a variant, not something that is called.
fn is_constant(name: &str) -> bool {
    name.starts_with(char::is_uppercase)
}

/// Whether a parameter of a type that is not read is an event, by its name or that of the type.
fn is_event_of_others(ty: &Ty, name: &str) -> bool {
    let of_type = match ty {
        Ty::External(path, _) => path.rsplit("::").next().unwrap_or(path),
        Ty::Unknown => "",
        _ => return false,
    };
    contains_any(of_type, EVENT_WORDS) || contains_any(name, EVENT_WORDS)
}

/// Whether what is called may give something new, by its name.
fn gives(name: &str) -> bool {
    !is_constant(name) && !asks_state(name) && !LOOKING.contains(&name)
}

/// Whether a name says that something is an event, or is short for one.
fn says_event(name: &str) -> bool {
    name.eq_ignore_ascii_case("ev") || contains_any(name, EVENT_WORDS) || contains_any(name, DOUBTFUL_WORDS)
}

/// Methods that take down a flag and answer whether it was up.
pub(super) const TAKES: &[&str] =
    &["swap", "take", "replace", "compare_exchange", "compare_exchange_weak", "fetch_and"];

impl Gates<'_, '_> {
    /// A choice on a value that was received in this iteration, or on the event that a handler is called with.
    pub(super) fn is_event(&self, test: &Test) -> bool {
        let is_choice = test.about.is_choice() || test.about.asks_elements;
        if test.about.is_presence && !is_choice {
            return false;
        }
        // `if let Event::Tick = rx.recv()?`, `match queue.pop_front() { Some(Event::Tick) => …, … }`
        let brings =
            |name: &String| is_receiving(name) || is_choice && (is_receiving_something(name) || is_waiting(name));
        let is_kind = test.about.is_choice() && !test.about.is_event;
        if (test.about.is_presence || is_kind) && test.about.names.iter().any(brings) {
            return true;
        }
        test.about.asks_received()
            || self.is_event_of(&test.about.reads, self.tells_apart(test))
            || (is_choice && (self.asks_message(test) || self.asks_frame(test)))
            || self.asks_derived(test)
    }

    /// `port.read_exact(&mut frame)?; match frame[0] { … }`: what was read into a buffer in this iteration.
    fn asks_frame(&self, test: &Test) -> bool {
        let reads = |name: &String| is_receiving(name) || is_receiving_something(name) || name.starts_with("read");
        let is_filled = |place: &Place| {
            self.nodes().any(|id| match &self.search.graph.node(id).effect {
                Effect::Branch(read) => {
                    read.about.is_presence
                        && read.about.names.iter().any(reads)
                        && read.about.lent.iter().any(|buffer| buffer.overlaps(place))
                }
                _ => false,
            })
        };
        test.about.reads.iter().filter(|place| place.base_var().is_some()).any(is_filled)
    }

    /// Whether it is asked which of several things a value is that is computed from nothing but what was received in this iteration:
    /// `match line.trim() { … }`. A number may be a reading, which says nothing of whether there is one.
    fn asks_derived(&self, test: &Test) -> bool {
        let about = &test.about;
        let asks_text = !about.names.is_empty()
            && !about.is_combined
            && about.names.iter().all(|name| TEXT_QUESTIONS.contains(&name.as_str()));
        let tells = about.is_choice() || (!about.is_presence && (self.asks_kind(test) || asks_text));
        let is_reading = |place: &Place| matches!(self.ty(place).as_ref().map(Ty::peel), Some(Ty::Float | Ty::Bool));
        let is_derived = |place: &Place| place.base_var().is_some_and(|var| self.is_derived(var, 0));
        let reads = &about.reads;
        tells && !reads.is_empty() && reads.iter().all(|place| !is_reading(place) && is_derived(place))
    }

    fn is_derived(&self, var: Var, depth: u32) -> bool {
        const MAX_DEPTH: u32 = 8;
        let is_from = |place: &Place| {
            place.base_var().is_some_and(|from| from != var && depth < MAX_DEPTH && self.is_derived(from, depth + 1))
        };
        let is_computed = || {
            let computed = self.search.graph.computed.get(&var);
            computed.is_some_and(|computed| !computed.places.is_empty() && computed.places.iter().all(is_from))
        };
        self.is_within(var) && (self.is_message(var) || is_computed())
    }

    /// Whether a variable begins anew in each iteration.
    pub(super) fn is_within(&self, var: Var) -> bool {
        let info = self.search.graph.var(var);
        match self.region {
            Region::Loop(own) => self.search.graph.is_within(info.in_loop, own),
            Region::Function => info.param.is_none(),
        }
    }

    /// Whether a test asks what something is that was received in this iteration, which may have no name: `match next(&events)`.
    pub(super) fn asks_message(&self, test: &Test) -> bool {
        let asked = test.subject.and_then(|id| self.search.graph.subjects[id.0 as usize].whole.as_ref());
        asked.into_iter().chain(&test.about.reads).any(|place| self.holds_message(place))
    }

    /// Whether a condition that reads these places is one on what was received in this iteration.
    pub(super) fn is_event_of(&self, reads: &[Place], is_choice: bool) -> bool {
        (is_choice || self.is_guard_of_event(reads)) && reads.iter().any(|place| self.is_received(place))
    }

    /// Whether a condition tells several things apart: what a message is about is not asked by whether it is there.
    pub(super) fn tells_apart(&self, test: &Test) -> bool {
        let about = &test.about;
        about.is_choice()
            || (!about.is_presence && (about.is_comparison || compares_answer(test) || self.asks_kind(test)))
    }

    /// Whether a number is asked that came with something in this iteration: `for msg in receiver { if msg.seq % 4 == 0 { … } }`.
    pub(super) fn asks_part_of_received(&self, test: &Test) -> bool {
        let graph = self.search.graph;
        let is_item = |place: &Place| {
            let Region::Loop(own) = self.region else { return false };
            let info = graph.loop_info(own);
            let comes = info.rounds == Rounds::Unbounded || info.drains;
            comes && place.base_var().is_some_and(|var| info.bound.contains(&var))
        };
        let mut parts = test.about.reads.iter().filter(|place| !place.steps.is_empty());
        parts.any(|place| is_item(place) || self.is_received(place))
    }

    /// A choice on a message that was taken out of something in this iteration, by whatever name.
    pub(super) fn is_taken(&self, test: &Test) -> bool {
        let graph = self.search.graph;
        let asked = test.subject.and_then(|subject| graph.subjects[subject.0 as usize].whole.as_ref());
        test.about.is_choice()
            && asked.and_then(Place::base_var).is_some_and(|var| {
                let is_taken = graph.received.contains(&var) || self.is_item(var) || self.is_got(var);
                is_taken && self.search.program.index.is_message(&graph.var(var).ty)
            })
    }

    /// Whether a variable is bound where a call had something to give in this iteration: `if let Some(message) = link.poll()`. What
    /// only looks into an option finds what it keeps.
    fn is_got(&self, var: Var) -> bool {
        self.is_within(var)
            && self.nodes().any(|id| match &self.search.graph.node(id).effect {
                Effect::Branch(test) => {
                    let about = &test.about;
                    about.asks_presence()
                        && about.binds.contains(&var)
                        && about.names.iter().any(|name| gives(name))
                        && !about.names.iter().any(|name| asks_state(name))
                }
                _ => false,
            })
    }

    /// Whether nothing is asked but what a call gave in this iteration, kept by a name: `let c = link.poll(); match c { … }`. What is
    /// lent may be there already.
    pub(super) fn asks_given(&self, test: &Test) -> bool {
        let is_owned = |var: Var| !matches!(self.search.graph.var(var).ty, Ty::Ref(..));
        let is_within = |place: &Place| {
            !self.outlives(place) && place.base_var().is_some_and(|var| self.is_within(var) && is_owned(var))
        };
        let reads = &test.about.reads;
        !reads.is_empty() && reads.iter().all(is_within) && self.behind(test).calls.iter().any(|name| gives(name))
    }

    /// Whether the loop that is the cycle binds a variable to the element of its round: `for event in batch`.
    fn is_item(&self, var: Var) -> bool {
        matches!(self.region, Region::Loop(own) if self.search.graph.loop_info(own).bound.contains(&var))
    }

    /// Whether it is asked which variant the element of this round is, or what was got: `for event in batch { match event { … } }`.
    pub(super) fn asks_item(&self, test: &Test) -> bool {
        let asked = test.subject.and_then(|id| self.search.graph.subjects[id.0 as usize].whole.as_ref());
        let asked = asked.filter(|place| place.steps.is_empty()).and_then(Place::base_var);
        asked.is_some_and(|var| self.is_item(var) || self.is_got(var))
    }

    /// Whether it is asked whose the sample is that came with the element of this round: `if record.sensor == Sensor::Gyro`, `for (id, z)
    /// in frames { match id { … } }`. What is fed is another part of the same element.
    pub(super) fn asks_tag(&self, test: &Test) -> bool {
        let [tag] = test.about.reads.as_slice() else { return false };
        let is_number = matches!(self.ty(tag), Some(Ty::Bool | Ty::Float));
        let is_beside = |other: &Place| other.base == tag.base && !other.steps.is_empty() && !other.overlaps(tag);
        let of_item = || tag.base_var().is_some_and(|var| self.is_item(var)) && self.fed().places.iter().any(is_beside);
        test.about.is_choice()
            && !test.about.is_comparison
            && test.about.names.iter().all(|name| is_constant(name))
            && !is_number
            && if tag.steps.is_empty() {
                test.about.binds.is_empty() && self.is_bound_beside_sample(tag)
            } else {
                of_item()
            }
    }

    /// Whether a loop that does not run over filters binds a variable together with what is fed, and does not count with it.
    pub(super) fn is_bound_beside_sample(&self, tag: &Place) -> bool {
        let Some(var) = tag.base_var() else { return false };
        let graph = self.search.graph;
        (0u32..).map(LoopId).zip(&graph.loops).any(|(id, info)| {
            let others = || info.bound.iter().filter(|other| **other != var);
            let counts = info.counter.is_some_and(|(counter, _)| counter == var);
            info.bound.contains(&var)
                && !counts
                && !self.search.binds(id)
                && others().any(|other| self.feeds_any(&[*other]))
        })
    }

    /// A question of a message about itself: `if key.is_pressed()`.
    fn asks_kind(&self, test: &Test) -> bool {
        let ([place], [name]) = (test.about.reads.as_slice(), test.about.names.as_slice()) else { return false };
        name.starts_with("is_")
            && !matches!(self.ty(place).as_ref().map(Ty::peel), Some(Ty::Float | Ty::Int | Ty::Bool))
    }

    /// Whether a place holds what was received in this iteration, or what a handler is called with.
    fn is_received(&self, place: &Place) -> bool {
        let Some(var) = place.base_var() else { return false };
        let info = self.search.graph.var(var);
        let is_parameter = self.region == Region::Function && info.param.is_some() && info.name != "self";
        (is_parameter && self.is_event_parameter(info)) || self.holds_message(place)
    }

    /// Whether a place holds what was received in this iteration, or a part of it. What a caller has for it is a state, unless each
    /// iteration that asks for it gives it anew before.
    fn holds_message(&self, place: &Place) -> bool {
        let graph = self.search.graph;
        let Some(var) = place.base_var() else { return false };
        if self.region != Region::Function || graph.var(var).param.is_none() {
            return self.is_message(var);
        }
        let giving: Vec<NodeId> = self.assigning(place).collect();
        let brings = |id: &NodeId| match &graph.node(*id).effect {
            Effect::Set(set) | Effect::Write(set) => {
                set.from.as_ref().and_then(Place::base_var).is_some_and(|from| self.is_message(from))
            }
            _ => false,
        };
        if giving.is_empty() || !giving.iter().all(brings) {
            return false;
        }
        let before = self.reached(|node, _| !giving.contains(&node));
        let asks = |id: NodeId| match &graph.node(id).effect {
            Effect::Branch(test) => test.about.reads.contains(place),
            _ => false,
        };
        !self.nodes().any(|id| before[id.0 as usize] && asks(id))
    }

    /// Whether a parameter is the event that a handler is called with: an enum, or what its name or that of its type says so of.
    /// Readings that come in a struct are none.
    fn is_event_parameter(&self, info: &VarInfo) -> bool {
        let def = match info.ty.peel() {
            Ty::Adt(id, _) => self.search.program.index.type_def(*id),
            ty => return !self.is_helper && is_event_of_others(ty, &info.name),
        };
        // A helper may be given a state as well, which its caller knows better.
        let is_told = !self.is_helper || self.search.program.index.is_message(&info.ty);
        // What a helper is lent may be the button itself.
        let is_lent = self.is_helper && matches!(info.ty, Ty::Ref(..));
        let says_so = |name: &str| if is_lent { contains_any(name, EVENT_WORDS) } else { says_event(name) };
        (matches!(def.shape, Shape::Enum(_)) && is_told) || says_so(&def.name) || says_so(&info.name)
    }

    /// Whether a helper is called with a message that the cycle has kept since an earlier iteration: that is a state by now.
    pub(super) fn keeps_message(&self, site: &CallSite, at: NodeId) -> bool {
        let graph = self.search.graph;
        let is_kept = |place: &Place| {
            let is_own = place.base_var().is_some_and(|var| graph.var(var).param.is_none() && !self.is_within(var));
            let giving: Vec<NodeId> = self.assigning(place).collect();
            is_own
                && matches!(self.region, Region::Loop(_))
                && self.is_choice(place)
                && self.reached(|node, _| !giving.contains(&node))[at.0 as usize]
        };
        site.args.iter().filter_map(|arg| arg.value_of.as_ref()).any(is_kept)
    }

    /// Whether it is asked if a handler was called with an event, or with none because it is time: `event: Option<Event>`.
    pub(super) fn asks_whether_event(&self, test: &Test) -> bool {
        let graph = self.search.graph;
        let subject = test.subject.and_then(|id| graph.subjects[id.0 as usize].whole.as_ref());
        let Some(Place { base: Base::Var(var), steps }) = subject else { return false };
        let info = graph.var(*var);
        let is_handler = self.region == Region::Function && !self.is_helper;
        let held = match info.ty.peel() {
            Ty::External(path, args) if path == "std::option::Option" => args.first(),
            _ => None,
        };
        is_handler
            && test.about.asks_presence()
            && steps.is_empty()
            && info.param.is_some()
            && held.is_some_and(|held| {
                says_event(&info.name) || self.is_event_parameter(&VarInfo { ty: held.clone(), ..info.clone() })
            })
    }

    /// Whether a variable holds what was received in this iteration, or a part of it.
    fn is_message(&self, var: Var) -> bool {
        let graph = self.search.graph;
        let mut seen = BTreeSet::new();
        let mut open = vec![var];
        while let Some(var) = open.pop() {
            if !self.is_within(var) || !seen.insert(var) {
                continue;
            }
            let is_received = graph.computed.get(&var).is_some_and(|computed| {
                let is_awaited = computed.calls.iter().any(|name| name == "await");
                let is_answer = computed.calls.iter().any(|name| asks_state(name));
                let awaits = is_awaited && !is_answer && self.is_choice(&Place::var(var));
                let brings = |name: &String| {
                    is_receiving(name)
                        || (is_receiving_something(name) && self.may_choose(var))
                        || (is_waiting(name) && self.is_choice(&Place::var(var)))
                };
                awaits || computed.calls.iter().any(brings)
            });
            if is_received || self.is_bound_by_event(var) {
                return true;
            }
            // What it was given as it was.
            open.extend(self.assignments().of(&Place::var(var)).iter().filter_map(
                |id| match &graph.node(*id).effect {
                    Effect::Set(set) | Effect::Write(set) => set.from.as_ref().and_then(Place::base_var),
                    _ => None,
                },
            ));
        }
        false
    }

    /// Whether an arm of a choice between events binds a variable.
    fn is_bound_by_event(&self, var: Var) -> bool {
        self.nodes().any(|id| match &self.search.graph.node(id).effect {
            Effect::Branch(test) => test.about.is_event && test.about.binds.contains(&var),
            _ => false,
        })
    }

    /// A further question about nothing but what an event brought: `Event::Gyro(rate) if rate.is_finite() => …`.
    fn is_guard_of_event(&self, reads: &[Place]) -> bool {
        let mut vars = reads.iter().map(Place::base_var);
        !reads.is_empty() && vars.all(|var| var.is_some_and(|var| self.is_bound_by_event(var)))
    }

    /// Whether a variable holds an enum of the analysed code, as far as is known.
    fn may_choose(&self, var: Var) -> bool {
        self.is_choice(&Place::var(var)) || self.search.graph.var(var).ty == Ty::Unknown
    }

    /// Whether a place holds an enum of the analysed code.
    pub(super) fn is_choice(&self, place: &Place) -> bool {
        matches!(self.ty(place).as_ref().map(Ty::peel), Some(Ty::Adt(id, _))
            if matches!(self.search.program.index.type_def(*id).shape, Shape::Enum(_)))
    }

    /// A flag that the cycle only takes down: an interrupt or another thread raises it.
    pub(super) fn is_flag_of_others(&self, test: &Test) -> bool {
        let graph = self.search.graph;
        let sources = self.behind(test);
        let asks = |name: &str| sources.calls.iter().any(|call| call == name);
        let is_truth = |place: &Place| self.ty(place).is_some_and(|ty| inner(&ty) == Ty::Bool);
        let is_locked = |place: &Place| self.is_locked(place) && is_truth(place);
        let looks = asks("load") || asks("get") || test.about.reads.iter().any(is_locked);
        if self.takes_flag_in_helper(&sources) {
            return true;
        }
        if !looks && !TAKES.iter().any(|name| asks(name)) {
            return false;
        }
        sources.places.iter().any(|place| {
            let mut taken_down = false;
            for id in self.nodes() {
                match &graph.node(id).effect {
                    Effect::Write(write)
                        if (write.place == *place || self.is_locked_again(&write.place, place))
                            && write.from.is_none() =>
                    {
                        match &write.head {
                            Some(head) if head == "false" => taken_down = true,
                            _ => return false,
                        }
                    }
                    _ => {}
                }
            }
            taken_down && self.outlives(place) && (self.is_flag(place) || is_locked(place)) && !self.calls_write(place)
        })
    }

    /// Whether a place is a truth value that others may change while the cycle runs.
    pub(super) fn is_flag(&self, place: &Place) -> bool {
        self.declared(place).as_ref().is_some_and(crate::flow::is_flag)
    }
}
