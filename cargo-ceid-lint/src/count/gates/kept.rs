//! What a helper waits for, as its caller has to know it: the caller may end the wait, or begin another one.

use std::collections::BTreeSet;

use super::Gates;
use crate::count::given::{Given, given, given_subject, place_of};
use crate::count::search::{End, Mode};
use crate::count::verdict::Gate;
use crate::flow::{CallSite, Effect, Head, NodeId, Subject, SubjectId};

/// A state of the caller's for which a helper pauses, with a reset before it updates again.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(in crate::count) struct KeptMode {
    place: Given,
    /// The heads that others may give it, so that each pause still goes with a reset.
    bears: Vec<Head>,
    /// Whether others may give it whatever they like.
    bears_all: bool,
}

impl KeptMode {
    pub(super) const fn place(&self) -> &Given {
        &self.place
    }

    pub(super) fn bears_with(&self, head: Option<&Head>) -> bool {
        head.map_or(self.bears_all, |head| self.bears.contains(head))
    }
}

impl Gates<'_, '_> {
    /// The states of the caller's for which a helper was found to pause, itself or in what it calls.
    pub(in crate::count) fn kept_modes(&self, end: &End, gate: Option<Gate>) -> Vec<KeptMode> {
        if !matches!(gate, Some(Gate::Mode | Gate::Startup)) {
            return Vec::new();
        }
        let graph = self.search.graph;
        let start = end.state.skipped_at.filter(|_| gate == Some(Gate::Startup)).and_then(|at| self.kept_start(at));
        if let Some(Effect::Call(site)) = end.state.skipped_at.map(|at| &graph.node(at).effect) {
            let passed_on = self.modes_of(site).into_iter().filter_map(|mode| {
                Some(KeptMode { place: given(graph, &place_of(&mode.place, site)?)?, ..mode.clone() })
            });
            return passed_on.collect();
        }
        let modes = self.modes.borrow();
        let is_kept = |((_, asked_by), is_mode): &(&(SubjectId, Option<NodeId>), &bool)| {
            **is_mode && asked_by.is_none() && gate == Some(Gate::Mode)
        };
        // What each call brings anew is nobody's to keep.
        let is_kept_between = |subject: &Subject| subject.whole.as_ref().is_none_or(|whole| !self.comes_anew(whole));
        let kept = modes.iter().filter(is_kept).filter_map(|((id, _), _)| {
            let subject = Some(&graph.subjects[id.0 as usize]).filter(|subject| is_kept_between(subject))?;
            let element = self.element_state(*id).filter(|_| self.is_mode_of_element(*id));
            let place = match &element {
                Some(state) => given(graph, &state.place)?,
                None => given_subject(graph, subject).filter(|_| subject.whole.is_some())?,
            };
            let updating = self.updating(*id)?;
            let bears_with = |foreign: u32| {
                if element.is_some() {
                    return foreign & updating == 0;
                }
                let mode = Mode { foreign, ..Mode::new(*id, updating) };
                self.search.resets_in_pauses(self.region, mode)
            };
            let heads = subject.names(subject.anything());
            let bears: Vec<Head> = heads.iter().filter(|head| bears_with(subject.bit(head))).cloned().collect();
            let bears_all = bears.len() == heads.len() && bears_with(subject.anything());
            Some(KeptMode { place, bears, bears_all })
        });
        // Whoever changes a filter's own state otherwise ends the pause without a reset, and who closes a latch begins one.
        let own_states = self.own_states.borrow();
        let own = own_states.iter().filter_map(|(place, bears)| Some((given(graph, place)?, bears)));
        let own = own.map(|(place, bears)| KeptMode { place, bears: bears.clone(), bears_all: false });
        kept.chain(own).chain(start).collect()
    }

    /// What a helper waits for at its start, as its caller knows it: it bears nothing from others but what opens it, and what it stays
    /// in until others end it.
    fn kept_start(&self, at: NodeId) -> Option<KeptMode> {
        let graph = self.search.graph;
        let Effect::Branch(test) = &graph.node(at).effect else { return None };
        let [asked] = test.about.reads.as_slice() else { return None };
        let place = given(graph, &self.copied_from(asked))?;
        let bears = test.subject.map(|id| {
            let subject = &graph.subjects[id.0 as usize];
            let opening = self.opening_heads(test, at);
            let (writers, updating) = (self.search.writers_of(id), self.search.updating());
            let stays = |head: &Head| {
                let reached = self.reached_in_pause(id, !subject.bit(head));
                !writers.iter().chain(&updating).any(|node| reached[node.0 as usize])
            };
            let mut bears = if subject.whole.is_some() { subject.names(subject.anything()) } else { Vec::new() };
            bears.retain(|head| opening.contains(head) || stays(head));
            bears
        });
        Some(KeptMode { place, bears: bears.unwrap_or_default(), bears_all: false })
    }

    /// The states for which a helper pauses.
    pub(super) fn modes_of(&self, site: &CallSite) -> BTreeSet<&KeptMode> {
        let summaries = site.targets.iter().filter_map(|target| self.search.summaries.get(*target));
        let outcomes = summaries.flat_map(|summary| summary.outcomes(self.search.law)).flat_map(|(_, ways)| ways);
        outcomes.flat_map(|outcome| &outcome.modes).collect()
    }
}
