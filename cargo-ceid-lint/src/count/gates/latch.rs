//! Latches: what is set once and opens the way to the update from then on.

use super::passed::TakenBack;
use super::{Gates, Way};
use crate::count::given::place_of;
use crate::count::verdict::Gate;
use crate::flow::{Assignment, ChangeKind, Effect, Head, NodeId, Place, SubjectId, Test};

impl Gates<'_, '_> {
    /// A truth value or option that is set once and never taken back.
    pub(super) fn is_latch(&self, test: &Test, at: NodeId, way: &Way) -> bool {
        let graph = self.search.graph;
        let Some(place) = &self.latch_asked(test) else { return false };
        // What others fill, the iteration does not open.
        if !self.outlives(place) || test.subject.is_some_and(|id| graph.cells.filled.contains_key(&id)) {
            return false;
        }
        let Some(given) = self.heads_by_calls(place) else { return false };
        let mut heads: Vec<&str> = given.into_iter().map(String::as_str).collect();
        let mut computed: Vec<NodeId> = Vec::new();
        // A number is replaced with all its bits.
        let is_owned = |write: &Assignment| self.is_number(&write.place);
        let replaces_owner = |write: &Assignment| {
            (!write.rebinds || is_owned(write))
                && write.place.base == place.base
                && place.steps.starts_with(&write.place.steps)
        };
        // What is set opens the way to the update; a latch that closes it for good is no start-up.
        let opens = self.heads_past(test, at, way);
        let mut opens_bit = false;
        for id in self.nodes() {
            let effect = &graph.node(id).effect;
            if let Effect::Write(write) | Effect::Set(write) = effect
                && (write.place == *place
                    || self.renews(id, place)
                    || matches!(effect, Effect::Write(_)) && replaces_owner(write)
                    || write.place.steps.len() < place.steps.len() && replaces_owner(write))
            {
                match &write.head {
                    Some(head) => heads.push(head),
                    None if self.only_opens_bit(id, place, &opens) => opens_bit = true,
                    None => computed.push(id),
                }
            }
        }
        let is_opened = match (heads.first(), opens.as_slice()) {
            (Some(first), _) => heads.iter().all(|head| head == first) && opens.iter().any(|head| head == first),
            (None, [_]) => !computed.is_empty() || opens_bit,
            (None, _) => false,
        };
        is_opened
            && (computed.is_empty() || !self.reaches_with(test, heads.first().unwrap_or(&opens[0].as_str()), &computed))
    }

    /// Whether a node changes a number of which a place is a bit, and leaves that as it is or opens the way by it:
    /// `ready |= self.poll(); if ready & GPS != 0 { … }`.
    fn only_opens_bit(&self, id: NodeId, place: &Place, opens: &[String]) -> bool {
        let is_number_around = match &self.search.graph.node(id).effect {
            Effect::Write(write) | Effect::Set(write) => {
                write.place.steps.len() + 1 == place.steps.len() && place.lies_at(&write.place)
            }
            _ => false,
        };
        let opened = match self.change(id) {
            Some(ChangeKind::Raises) => "true",
            Some(ChangeKind::Lowers) => "false",
            _ => return false,
        };
        is_number_around && opens == [opened]
    }

    /// The heads that calls give a place, as in `None => self.search(x)`; `None` if one of them may write something else there.
    fn heads_by_calls(&self, place: &Place) -> Option<Vec<&Head>> {
        let mut heads = Vec::new();
        for id in self.nodes() {
            let site = match &self.search.graph.node(id).effect {
                Effect::Call(site) if self.call_writes(site, place) => site,
                Effect::Unknown { places, .. } if places.iter().any(|other| other.overlaps(place)) => return None,
                _ => continue,
            };
            for target in &site.targets {
                let summary = self.search.summaries.get(*target)?;
                for given in &summary.writes {
                    match place_of(given, site) {
                        Some(written) if written == *place => {}
                        Some(written) if written.overlaps(place) => return None,
                        _ => continue,
                    }
                    let mut sets = summary.sets.iter().filter(|(set, ..)| set == given).peekable();
                    sets.peek()?;
                    for (_, head, _) in sets {
                        heads.push(head.as_ref()?);
                    }
                }
            }
        }
        Some(heads)
    }

    /// The place whose value is asked for: also the one that a helper gives which is read here,
    /// `fn is_started(&mut self, x: f32) -> bool { if x > 1.0 { self.started = true; } self.started }`.
    fn latch_asked(&self, test: &Test) -> Option<Place> {
        let whole = test.subject.and_then(|id| self.search.graph.subjects[id.0 as usize].whole.as_ref());
        let asked = match test.about.reads.as_slice() {
            [asked] => asked,
            _ => whole?,
        };
        let given = self.copied_from(asked);
        // Of an object that is asked by a method, the field that this gives.
        let is_field = |field: &Place| field.lies_at(&given);
        let field = whole.map(|whole| self.copied_from(whole)).filter(is_field);
        Some(field.unwrap_or(given))
    }

    /// What a latch waits for: it is a mode where something else closes it and resets the filter, and neither where that does not.
    pub(super) fn of_latch(&self, test: &Test, at: NodeId, way: &Way) -> Option<Gate> {
        let graph = self.search.graph;
        let (Some(id), Some(place)) = (test.subject, self.latch_asked(test)) else { return Some(Gate::Startup) };
        let subject = &graph.subjects[id.0 as usize];
        let open = self.heads_past(test, at, way).iter().fold(0, |open, head| open | subject.bit(head));
        match self.taken_back_elsewhere(subject, &place, open) {
            TakenBack::Never => Some(Gate::Startup),
            TakenBack::WithReset => Some(Gate::Mode),
            // Who opens it again resets the filter there.
            TakenBack::Kept if self.opens_with_reset(id, &place, open) => Some(Gate::Mode),
            TakenBack::Kept => {
                self.modes.borrow_mut().insert((id, None), false);
                None
            }
        }
    }

    /// Whether the filter is reset wherever a latch is opened, here or elsewhere.
    fn opens_with_reset(&self, id: SubjectId, place: &Place, open: u32) -> bool {
        let subject = &self.search.graph.subjects[id.0 as usize];
        let opens = |head: Option<&Head>| head.is_none_or(|head| subject.bit(head) & open != 0);
        let mut opening = self.assigning(place);
        opening.all(|node| self.resets_around(node, place, &opens)) && !self.is_resumed_elsewhere(id, open)
    }
}
