//! What a helper waits for, as its caller has to know it: the caller may end the wait, or begin another one.

use std::collections::BTreeSet;

use super::Gates;
use crate::count::given::{Given, given, given_subject, place_of};
use crate::count::search::{End, Mode};
use crate::count::verdict::Gate;
use crate::flow::{CallSite, Effect, Head, NodeId, Place, Subject, SubjectId};

/// How many heads are looked at in pairs.
const MAX_TOGETHER: usize = 8;

/// A state of the caller's for which a helper pauses, with a reset before it updates again.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(in crate::count) struct KeptMode {
    place: Given,
    /// The heads that others may give it, so that each pause still goes with a reset. Where some end the pauses that others of them
    /// begin, each of several choices does without the ones or the others.
    bears: Vec<Vec<Head>>,
    /// Whether others may give it whatever they like.
    bears_all: bool,
    /// With how many of the first choices a start that the helper waits for comes once.
    starts: usize,
}

impl KeptMode {
    pub(super) const fn place(&self) -> &Given {
        &self.place
    }

    /// The questions, one for each choice, whether the helper bears with a head.
    fn choices(&self) -> impl Iterator<Item = impl Fn(Option<&Head>) -> bool> {
        self.bears.iter().map(|bears| |head: Option<&Head>| head.map_or(self.bears_all, |head| bears.contains(head)))
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
        if let Some(at) = end.state.skipped_at
            && let Effect::Call(site) = &graph.node(at).effect
        {
            let passed_on = self.modes_of(site).into_iter().filter_map(|mode| {
                let own = place_of(&mode.place, site)?;
                // What was given here already says with what else the helper bears.
                let left: Vec<bool> = mode.choices().map(|bears| self.leaves_mode(site, at, &own, &bears)).collect();
                let own_bears = mode.bears.iter().zip(&left).filter(|(_, left)| **left).map(|(bears, _)| bears.clone());
                let starts = left.iter().take(mode.starts).filter(|left| **left).count();
                Some(KeptMode { place: given(graph, &own)?, bears: own_bears.collect(), starts, ..mode.clone() })
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
            let (bears, bears_all) = self.borne_heads(*id, updating, element.is_some());
            Some(KeptMode { place, starts: bears.len(), bears, bears_all })
        });
        // Whoever changes a filter's own state otherwise ends the pause without a reset, and who closes a latch begins one.
        let own_states = self.own_states.borrow();
        let own = own_states.iter().filter_map(|(place, bears)| Some((given(graph, place)?, bears)));
        let own = own.map(|(place, bears)| KeptMode { place, bears: vec![bears.clone()], bears_all: false, starts: 1 });
        kept.chain(own).chain(start).collect()
    }

    /// The heads that others may give a state, so that each pause still goes with a reset, and whether they may give it anything.
    fn borne_heads(&self, id: SubjectId, updating: u32, is_of_element: bool) -> (Vec<Vec<Head>>, bool) {
        let subject = &self.search.graph.subjects[id.0 as usize];
        let bears_with = |foreign: u32| match is_of_element {
            true => foreign & updating == 0,
            false => self.search.resets_in_pauses(self.region, Mode { foreign, ..Mode::new(id, updating) }),
        };
        let heads = subject.names(subject.anything());
        let mut bears: Vec<Head> = heads.iter().filter(|head| bears_with(subject.bit(head))).cloned().collect();
        bears.sort_by_key(|head| subject.bit(head) & updating != 0);
        let bears_all = bears.len() == heads.len() && bears_with(subject.anything());
        let choices = if bears_all { vec![bears] } else { choices(&bears, |heads| bears_with(subject.bits(heads))) };
        (choices, bears_all)
    }

    /// What a helper waits for at its start, as its caller knows it: it bears nothing from others but what opens it, or what it stays
    /// in for good, unless it resets the filter whenever it opens.
    fn kept_start(&self, at: NodeId) -> Option<KeptMode> {
        let graph = self.search.graph;
        let Effect::Branch(test) = &graph.node(at).effect else { return None };
        let [asked] = test.about.reads.as_slice() else { return None };
        let place = given(graph, &self.copied_from(asked))?;
        let Some(id) = test.subject else {
            return Some(KeptMode { place, bears: vec![Vec::new()], bears_all: false, starts: 1 });
        };
        let subject = &graph.subjects[id.0 as usize];
        let (updating, is_whole) = (self.updating(id), subject.whole.is_some());
        let mut opening = self.opening_heads(test, at);
        opening.retain(|head| updating.is_none_or(|updating| subject.bit(head) & updating != 0));
        let (writers, updates) = (self.search.writers_of(id), self.search.updating());
        let stays = |head: &Head| {
            let reached = self.reached_in_pause(id, !subject.bit(head));
            !writers.iter().chain(&updates).any(|node| reached[node.0 as usize])
        };
        let heads = if is_whole { subject.names(subject.anything()) } else { Vec::new() };
        let (opens, others): (Vec<Head>, Vec<Head>) = heads.into_iter().partition(|head| opening.contains(head));
        let mut bears = vec![opens, others.into_iter().filter(stays).collect()];
        let starts = bears.len();
        if let Some(updating) = updating.filter(|_| is_whole && self.judge_mode(id, None)) {
            bears.extend(self.borne_heads(id, updating, false).0);
        }
        Some(KeptMode { place, bears, bears_all: false, starts })
    }

    /// The states for which a helper pauses.
    pub(super) fn modes_of(&self, site: &CallSite) -> BTreeSet<&KeptMode> {
        let summaries = site.targets.iter().filter_map(|target| self.search.summaries.get(*target));
        let outcomes = summaries.flat_map(|summary| summary.outcomes(self.search.law)).flat_map(|(_, ways)| ways);
        outcomes.flat_map(|outcome| &outcome.modes).collect()
    }

    /// What a helper waits for where the cycle leaves the states alone for which it pauses, as far as that can do harm: it gives them
    /// only heads that the helper bears with, or resets the filter as well. A start that the cycle begins again is a mode.
    pub(super) fn gate_left(&self, site: &CallSite, at: NodeId, gate: Gate) -> Option<Gate> {
        let mut left = gate;
        for mode in self.modes_of(site) {
            let place = place_of(&mode.place, site)?;
            let number = mode.choices().position(|bears| self.leaves_mode(site, at, &place, &bears))?;
            if number >= mode.starts {
                left = Gate::Mode;
            }
        }
        Some(left)
    }

    /// Whether the cycle leaves one state alone, for one choice of the heads that the helper bears with.
    fn leaves_mode(&self, site: &CallSite, at: NodeId, place: &Place, bears: &dyn Fn(Option<&Head>) -> bool) -> bool {
        let ends = |head: Option<&Head>| !bears(head);
        if self.is_run_again() && self.is_written_elsewhere(place, &ends) {
            return false;
        }
        let mut others = self.nodes().filter(|id| *id != at);
        others.all(|id| match &self.search.graph.node(id).effect {
            Effect::Write(write) | Effect::Set(write) if write.place.overlaps(place) => {
                (write.place == *place && bears(write.head.as_ref())) || self.resets_around(id, place, &ends)
            }
            Effect::Call(other) if self.written_by(other).any(|written| self.is_at(place, &written)) => {
                let is_same = other.targets.iter().all(|target| site.targets.contains(target));
                is_same || self.sets_only(other, place, bears) || self.resets_around(id, place, &ends)
            }
            _ => true,
        }) || self.leaves_elements(place, at, &ends)
    }

    /// Whether a place may be another one, by any of the names of both.
    fn is_at(&self, place: &Place, written: &Place) -> bool {
        written.overlaps(place) || self.search.aliases.shared_roots(place).iter().any(|root| self.is_of(root, written))
    }

    /// Whether a call gives a state only heads that a helper bears with.
    fn sets_only(&self, site: &CallSite, place: &Place, bears: &dyn Fn(Option<&Head>) -> bool) -> bool {
        let mut summaries = site.targets.iter().filter_map(|target| self.search.summaries.get(*target));
        summaries.all(|summary| {
            let is_it = |given: &Given| place_of(given, site).is_some_and(|written| self.is_at(place, &written));
            summary.writes.iter().filter(|given| is_it(given)).all(|given| {
                let mut heads = summary.sets.iter().filter(|(set, ..)| set == given).peekable();
                heads.peek().is_some() && heads.all(|(_, head, _)| bears(head.as_ref()))
            })
        })
    }
}

/// The heads that can be borne with together, of those that each can be by itself, in order: without those that begin a pause which
/// others end, or without these others.
fn choices(bears: &[Head], together: impl Fn(&[Head]) -> bool) -> Vec<Vec<Head>> {
    if together(bears) {
        return vec![bears.to_vec()];
    }
    if bears.len() > MAX_TOGETHER {
        return Vec::new();
    }
    let mut clashing: [Vec<&Head>; 2] = Default::default();
    for (number, one) in bears.iter().enumerate() {
        for other in bears[number + 1..].iter().filter(|other| !together(&[one.clone(), (*other).clone()])) {
            clashing[0].push(one);
            clashing[1].push(other);
        }
    }
    let without = |left_out: Vec<&Head>| bears.iter().filter(|head| !left_out.contains(head)).cloned().collect();
    clashing.map(without).into()
}
