//! Questions to what gives the sample: whether it is complete, filled, or there at all.

use super::sample::has_word;
use super::{Gates, Way};
use crate::flow::{ChangeKind, Effect, NodeId, Place, Test};
use crate::index::Ty;

/// Words in the names of methods that are fed with parts of a message, and answer whether it is complete.
const PARSING: &[&str] =
    &["push", "feed", "parse", "decode", "consume", "accept", "process", "put", "ingest", "digest", "add", "receive"];

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
        let owner = Place { base: first.base, steps: owner.to_vec() };
        let fed = &self.fed().places;
        let is_in = |place: &&Place| place.base == owner.base && place.steps.starts_with(&owner.steps);
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
        let holds = way.after(at) == self.search.graph.node(at).next.first().copied();
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
        let owners = more.iter().take_while(|place| place.base == first.base && place.steps.starts_with(&first.steps));
        let object = if kept.is_some() { owners.last().unwrap_or(first) } else { first };
        !about.is_combined
            && PARSING.iter().any(|word| has_word(name, word))
            && !self.is_self(object)
            && !matches!(self.ty(object), Some(Ty::Bool | Ty::Int | Ty::Float | Ty::Char))
            && self.fed().places.iter().any(|place| place.base == object.base && place.steps.starts_with(&object.steps))
    }

    /// `if adc.read_into(&mut sample) { f.update(sample) }`: what the call writes is the sample.
    pub(super) fn fills_sample(&self, test: &Test) -> bool {
        let graph = self.search.graph;
        let about = &test.about;
        let is_filled = |place: &Place| {
            let is_unseen = |id: NodeId| {
                let is_foreign = !graph.changes.contains_key(&id) || self.is_read_in_place(id);
                is_foreign && matches!(&graph.node(id).effect, Effect::Write(write) if write.head.is_none())
            };
            let mut filled = self.assigning(place).filter(|id| !self.is_set_back(*id, place)).peekable();
            let is_filled = filled.peek().is_some() && filled.all(is_unseen);
            (is_filled || self.calls_write(place)) && self.fed().places.iter().any(|other| other.overlaps(place))
        };
        if let Some(computed) = self.kept_answer(test) {
            let is_plain = |place: &&Place| matches!(self.ty(place), Some(Ty::Int | Ty::Float));
            let mut plain = computed.places.iter().filter(is_plain).peekable();
            return plain.peek().is_some() && plain.all(is_filled);
        }
        !about.is_combined && !about.lent.is_empty() && about.lent.iter().all(is_filled)
    }
}
