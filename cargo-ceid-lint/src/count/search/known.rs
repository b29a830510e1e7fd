//! What a way knows of conditions: what branches find, and what writes leave of it.

use std::collections::BTreeMap;

use super::names::{in_each_round, is_of_round};
use super::run::Run;
use super::{Region, Search, State};
use crate::count::counts::Count;
use crate::count::given_heads::GivenHeads;
use crate::flow::{ControlFlowGraph, Effect, LoopInfo, NodeId, PAST, Place, Subject, SubjectId, Test};

/// A state of the element that the instance is or lies in, for which several subjects ask, each by the name that it has in another
/// loop: `for o in &mut orbits { if o.is_wet { … } } for o in &mut orbits { if !o.is_wet { … } }`.
#[derive(Debug)]
pub(super) struct OfElement {
    /// Its place, with the key of the instance.
    state: Place,
    /// Those that ask for it; what is known has the heads of the first.
    subjects: Vec<SubjectId>,
}

impl OfElement {
    fn subject<'g>(&self, graph: &'g ControlFlowGraph) -> &'g Subject {
        &graph.subjects[self.subjects[0].0 as usize]
    }

    pub(super) fn anything(&self, graph: &ControlFlowGraph) -> u32 {
        self.subject(graph).anything()
    }
}

impl Search<'_> {
    /// The states of the element that the instance is or lies in, which several branches ask for by names of their own.
    pub(super) fn of_element(&self, region: Region) -> Vec<OfElement> {
        let graph = self.graph;
        if self.covering.len() < 2 || !self.instance.stands_for_each() {
            return Vec::new();
        }
        let mut found: BTreeMap<Place, Vec<SubjectId>> = BTreeMap::new();
        for id in graph.node_ids() {
            let Effect::Branch(Test { subject: Some(subject), .. }) = &graph.node(id).effect else { continue };
            if let Some(state) = self.element_state(region, id, *subject) {
                let all = found.entry(state).or_default();
                if !all.contains(subject) {
                    all.push(*subject);
                }
            }
        }
        let several = found.into_iter().filter(|(_, subjects)| subjects.len() > 1);
        several.map(|(state, subjects)| OfElement { state, subjects }).collect()
    }

    /// The place of the state of our element that a branch asks for, if it lies in a loop that goes over the elements.
    fn element_state(&self, region: Region, at: NodeId, subject: SubjectId) -> Option<Place> {
        let graph = self.graph;
        let whole = graph.subjects[subject.0 as usize].whole.as_ref()?;
        let roots = self.aliases.shared_roots(whole);
        let [root] = &*roots else { return None };
        let is_bound = |info: &LoopInfo| whole.base_var().is_some_and(|var| info.bound.contains(&var));
        let mut around = graph.loops_around(at).take_while(|id| region != Region::Loop(*id));
        let is_ours = around.any(|id| {
            let info = graph.loop_info(id);
            self.covers(id) && (is_bound(info) || is_of_round(info, root))
        });
        let state = in_each_round(graph, root, self.instance);
        let owner = state.steps.iter().rposition(|step| step.key().is_some())? + 1;
        let is_same = state.base == self.instance.base && self.instance.steps.get(..owner) == state.steps.get(..owner);
        (is_ours && is_same && state.steps.len() > owner).then_some(state)
    }
}

impl Run<'_, '_> {
    /// Where what is known of the states of the element begins.
    fn first_of_element(&self) -> usize {
        self.tracked.subjects.len() + self.of_caller.len()
    }

    /// What is known behind a branch that asks for a state of the element, in its own round; nothing if it cannot be taken so.
    fn agreed_of_element(&mut self, state: &State, test: &Test, heads: u32) -> Option<u32> {
        let graph = self.search.graph;
        let asks = |own: &OfElement| test.subject.is_some_and(|id| own.subjects.contains(&id));
        let Some((number, id)) = self.of_element.iter().position(asks).zip(test.subject) else {
            return Some(state.masks);
        };
        if self.is_other_element(state) {
            return Some(state.masks);
        }
        let asked = &graph.subjects[id.0 as usize];
        let allowed = self.of_element[number].subject(graph).translate(heads, &asked.heads);
        let at = self.first_of_element() + number;
        let mut all = self.masks.get(state.masks).clone();
        all[at] &= allowed;
        (all[at] != 0).then(|| self.masks.intern(all))
    }

    /// A branch is taken, as far as what is known lets it be.
    pub(super) fn branch(&mut self, at: usize, state: &State, test: &Test) {
        let graph = self.search.graph;
        let tracked = test.subject.and_then(|subject| self.tracked.subjects.iter().position(|id| *id == subject));
        for (number, to) in graph.node(state.node).next.iter().copied().enumerate() {
            // A constant that is written out is known. Before the update it is still a setting, which another build may have otherwise.
            if test.about.constant.is_some_and(|holds| holds != (number == 0)) && state.count != Count::Zero {
                continue;
            }
            let heads = if number == 0 { test.holds } else { test.fails };
            if test.subject.is_some_and(|subject| heads & self.search.settled(self.region, subject) == 0) {
                continue;
            }
            let mut after = state.clone();
            if let Some(tracked) = tracked {
                let mut all = self.masks.get(state.masks).clone();
                all[tracked] &= heads;
                if all[tracked] == 0 {
                    continue;
                }
                after.masks = self.masks.intern(all);
            }
            let Some(masks) = self.agreed_of_element(&after, test, heads) else { continue };
            after.masks = masks;
            if after.count == Count::Zero && !after.reset && self.search.lacks_filter(self.region, state.node, number) {
                after.skipped_at = Some(state.node);
            }
            for masks in self.compared(after.masks, test, number == 0) {
                self.follow(at, State { masks, ..after.clone() }, to);
            }
        }
    }

    /// Nothing is known any more of what reads a place.
    pub(super) fn killed(&mut self, masks: u32, place: &Place) -> u32 {
        self.written(masks, place, None)
    }

    /// A place may have been written, with one of these heads if they are known.
    pub(super) fn written(&mut self, masks: u32, place: &Place, given: Option<&GivenHeads>) -> u32 {
        let graph = self.search.graph;
        let changing = self.changed_with(place);
        if changing.is_empty() && self.of_element.is_empty() {
            return masks;
        }
        let mut all = self.masks.get(masks).clone();
        let mut changed = !changing.is_empty();
        for at in changing.iter().copied() {
            self.keep_assumed(&mut all, at);
            let subject = &graph.subjects[self.tracked.subjects[at].0 as usize];
            let is_past = all[at] & !(subject.bit("true") | subject.bit(PAST)) == 0;
            let goes_on = self.counts_once(subject, place);
            all[at] = match given.filter(|_| subject.whole.as_ref() == Some(place)) {
                Some(given) => {
                    let before = if given.surely { 0 } else { all[at] };
                    given.heads.iter().fold(before, |mask, head| mask | subject.bit(head))
                }
                None if goes_on && is_past => subject.bit(PAST),
                None => subject.anything(),
            };
        }
        for (at, own) in (self.first_of_element()..).zip(&self.of_element) {
            if own.state.overlaps(place) {
                all[at] = own.anything(graph);
                changed = true;
            }
        }
        if changed { self.masks.intern(all) } else { masks }
    }

    /// Whether a subject holds for one number at most of the loop that a place counts.
    fn counts_once(&self, subject: &Subject, place: &Place) -> bool {
        let counts = |info: &LoopInfo| info.counter.is_some_and(|(counter, _)| Place::var(counter) == *place);
        subject.heads.iter().any(|head| head == PAST) && self.search.graph.loops.iter().any(counts)
    }
}
