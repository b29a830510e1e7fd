//! What keeps a condition from being the gate that it looks like: said where a skip is told, so that a user sees what to change.

use super::{Gates, Way};
use crate::config::TimeBase;
use crate::count::given::place_of;
use crate::count::search::{End, Exploration, Mode};
use crate::count::witness::{GOES_ON, NO_RESET};
use crate::diagnostic::WitnessStep;
use crate::flow::{Effect, Head, NodeId, Place, SubjectId};

impl Gates<'_, '_> {
    /// The places that turn a gate back into a skip: a clock that goes on without the filter, or a change of the state that does not
    /// reset it, with what clears only a part of it.
    pub(in crate::count) fn near_miss(&self, exploration: &Exploration, end: &End) -> Vec<WitnessStep> {
        let Some(at) = end.state.skipped_at else { return Vec::new() };
        let way = Way::to(exploration, end, at);
        let gate = self.opening(end, at, &way);
        if gate.is_some_and(|gate| self.loses_time(gate, &way)) {
            return self.clock_set(&way).into_iter().collect();
        }
        if gate.is_some() {
            return Vec::new();
        }
        let subject = match &self.search.graph.node(at).effect {
            Effect::Branch(test) => test.subject,
            _ => None,
        };
        let change = subject.and_then(|subject| self.change_without_reset(subject));
        let told: Vec<WitnessStep> = match change {
            Some(step) => vec![step],
            None => subject.map(|subject| self.resumed_without_reset(subject)).unwrap_or_default(),
        };
        match told.is_empty() && self.time_base() == TimeBase::Passed && self.goes_on(&way) {
            true => self.clock_set(&way).into_iter().collect(),
            false => told,
        }
    }

    /// Where a state changes in a pause at whose end the filter goes on as it was, if something in the cycle resets it, or a part of it:
    /// the change, and what clears only a part.
    fn resumed_without_reset(&self, subject: SubjectId) -> Vec<WitnessStep> {
        let search = self.search;
        let partly: Vec<NodeId> = self.nodes().filter(|id| search.clears_partly(*id).is_some()).collect();
        let may_reset = |id: NodeId| self.resets(id) || self.resets_on_some_way(id);
        if partly.is_empty() && !self.nodes().any(may_reset) {
            return Vec::new();
        }
        let Some(updating) = self.updating(subject) else { return Vec::new() };
        let changes = |id: NodeId| self.may_become(subject, updating, id);
        let Some(way) = search.way_to_resume(self.region, Mode::new(subject, updating), &changes) else {
            return Vec::new();
        };
        let Some(change) = way.iter().rfind(|id| changes(**id)) else { return Vec::new() };
        let graph = search.graph;
        let name = graph.subjects[subject.0 as usize].whole.as_ref().map_or("the state".to_owned(), |it| self.name(it));
        let message = match &graph.node(*change).effect {
            Effect::Call(site) => format!("`{}` changes {name}{NO_RESET}", site.text),
            _ => format!("{name} changes{NO_RESET}"),
        };
        let step = WitnessStep { span: graph.node(*change).span, message };
        let cleared = way.iter().filter(|id| partly.contains(id)).find_map(|id| search.clears_partly(*id));
        cleared.into_iter().chain([step]).collect()
    }

    /// Whether a node may give a state a head with which the filter runs.
    fn may_become(&self, subject: SubjectId, updating: u32, id: NodeId) -> bool {
        let graph = self.search.graph;
        let asked = &graph.subjects[subject.0 as usize];
        let Some(whole) = &asked.whole else { return false };
        let is_updating = |head: Option<&Head>| head.is_none_or(|head| asked.bit(head) & updating != 0);
        match &graph.node(id).effect {
            Effect::Write(set) | Effect::Set(set) => set.place == *whole && is_updating(set.head.as_ref()),
            Effect::Call(site) => {
                let summaries = site.targets.iter().filter_map(|target| self.search.summaries.get(*target));
                summaries.flat_map(|summary| &summary.sets).any(|(given, head, _)| {
                    is_updating(head.as_ref()) && place_of(given, site).is_some_and(|place| place == *whole)
                })
            }
            _ => false,
        }
    }

    /// Whether a node calls a function that resets the filter on some ways.
    fn resets_on_some_way(&self, id: NodeId) -> bool {
        let Effect::Call(site) = &self.search.graph.node(id).effect else { return false };
        let summaries = site.targets.iter().filter_map(|target| self.search.summaries.get(*target));
        let mut ways = summaries.flat_map(|summary| summary.outcomes(self.search.law));
        ways.any(|(given, ways)| {
            ways.iter().any(|way| way.reset) && place_of(given, site).is_some_and(|place| self.is_instance(&place))
        })
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
