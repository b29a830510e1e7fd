//! What keeps a condition from being the gate that it looks like: said where a skip is told, so that a user sees what to change.

use super::{Gates, Way};
use crate::count::search::{End, Exploration};
use crate::count::witness::{GOES_ON, NO_RESET};
use crate::diagnostic::WitnessStep;
use crate::flow::{Effect, NodeId, Place, SubjectId};

impl Gates<'_, '_> {
    /// The place that turns a gate back into a skip: a clock that goes on without the filter, or a change of the state that does not
    /// reset it where another one does.
    pub(in crate::count) fn near_miss(&self, exploration: &Exploration, end: &End) -> Option<WitnessStep> {
        let at = end.state.skipped_at?;
        let way = Way::to(exploration, end, at);
        let gate = self.opening(end, at, &way);
        if gate.is_some_and(|gate| self.loses_time(gate, &way)) {
            return self.clock_set(&way);
        }
        let Effect::Branch(test) = &self.search.graph.node(at).effect else { return None };
        test.subject.filter(|_| gate.is_none()).and_then(|subject| self.change_without_reset(subject))
    }

    /// Where a way sets the clock that the filter's step is computed from.
    fn clock_set(&self, way: &Way) -> Option<WitnessStep> {
        let graph = self.search.graph;
        let id = way.nodes.iter().find(|id| self.goes_on(&Way { nodes: vec![**id], ..*way }))?;
        let name = match &graph.node(*id).effect {
            Effect::Write(write) | Effect::Set(write) => self.name(&write.place),
            _ => "its clock".to_owned(),
        };
        Some(WitnessStep { span: graph.node(*id).span, message: format!("{name}{GOES_ON}") })
    }

    /// Where a state becomes one in which the filter is updated and nothing resets it, if something resets it at another change.
    fn change_without_reset(&self, subject: SubjectId) -> Option<WitnessStep> {
        let graph = self.search.graph;
        let asked = &graph.subjects[subject.0 as usize];
        let updating = self.updating(subject)?;
        let becomes = |id: NodeId| {
            let (Effect::Write(set) | Effect::Set(set)) = &graph.node(id).effect else { return None };
            let heads = set.head.as_ref().map(|head| asked.bit(head))?;
            (Some(&set.place) == asked.whole.as_ref() && heads & updating != 0).then_some(&set.place)
        };
        let resets: Vec<NodeId> = self.nodes().filter(|id| self.resets(*id)).collect();
        let behind: Vec<_> = resets.iter().map(|reset| self.reached_from(*reset, |_, _| true)).collect();
        let is_plain = |id: NodeId| {
            let reached = self.reached_from(id, |_, _| true);
            !behind.iter().any(|behind| behind[id.0 as usize]) && !resets.iter().any(|reset| reached[reset.0 as usize])
        };
        let changes = self.nodes().filter_map(|id| Some((id, becomes(id)?, is_plain(id))));
        let (plain, reset): (Vec<_>, Vec<_>) = changes.partition(|(_, _, is_plain)| *is_plain);
        let (at, place, _) = *plain.first().filter(|_| !reset.is_empty())?;
        let message = format!("{} changes{NO_RESET}", self.name(place));
        Some(WitnessStep { span: graph.node(at).span, message })
    }

    fn name(&self, place: &Place) -> String {
        format!("`{}`", self.search.graph.place_name(self.search.program.index, place))
    }
}
