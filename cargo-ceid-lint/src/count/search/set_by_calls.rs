//! Truth values that a call sets or gives back beside an update of its own: what is asked of one behind the call tells whether the
//! update ran.

use std::collections::BTreeMap;

use super::exploration::{End, Exploration};
use super::{Search, State};
use crate::count::counts::Count;
use crate::count::given::{Given, place_of};
use crate::count::instances::place_ty;
use crate::count::returned;
use crate::flow::{CallSite, Effect, Head, NodeId, Place, Test, Var, small_number};
use crate::index::{FunctionId, Shape, Ty};
use crate::source::Span;

impl Search<'_> {
    /// Whether a way comes to its second update only where a truth value is not what the call with the first one sets it to:
    /// `self.poll(); if !self.done { f.update(x); }`. The same for a truth value among others that the call gives back:
    /// `let (done, level) = self.poll();`
    pub(in crate::count) fn asks_what_a_call_sets(&self, exploration: &Exploration, end: &End) -> bool {
        let path = exploration.path(end.at);
        let states: Vec<&State> = path.iter().map(|at| &exploration.states[*at]).chain([&end.state]).collect();
        let mut flags: Vec<(Place, Vec<Head>)> = Vec::new();
        let mut given: Vec<Var> = Vec::new();
        let mut number: Option<(Var, Span)> = None;
        let mut asked: Vec<NodeId> = Vec::new();
        let mut turned: Vec<Place> = Vec::new();
        for (state, next) in states.iter().zip(states.iter().skip(1)) {
            let node = self.graph.node(state.node);
            if next.count == Count::Many && asked.iter().any(|branch| self.decides(*branch, state.node)) {
                return true;
            }
            match &node.effect {
                Effect::Call(site) if state.count == Count::Zero && next.count == Count::One => {
                    flags = self.flags_of(site);
                    given = self.parts_given(site);
                    number = self
                        .number_given(site)
                        .filter(|_| may_skip(exploration, state.node))
                        .map(|var| (var, node.span));
                    turned = self.turned_unknown_by(site);
                }
                Effect::Call(site)
                    if next.count == Count::Many && self.turned_by(site).iter().any(|place| turned.contains(place)) =>
                {
                    return true;
                }
                Effect::Branch(test) if state.count == Count::One => {
                    let is_asked = self.asks_truth_of(&given, test) || self.asks_number(number, test);
                    asked.extend(is_asked.then_some(state.node));
                    let Some(id) = test.subject else { continue };
                    let (subject, reads) = (&self.graph.subjects[id.0 as usize], self.read_by(id));
                    let taken = if node.next.first() == Some(&next.node) { test.holds } else { test.fails };
                    let is_other = |(flag, heads): &(Place, Vec<Head>)| {
                        reads.is_changed_with(flag) && heads.iter().all(|head| subject.bit(head) & taken == 0)
                    };
                    if flags.iter().any(is_other) {
                        return true;
                    }
                }
                _ => {}
            }
        }
        false
    }

    /// The variables into which a call gives several values together: what is known of one of them is not followed.
    fn parts_given(&self, site: &CallSite) -> Vec<Var> {
        let index = self.program.index;
        let is_optional = |ty: &Ty| matches!(ty.external_name(), Some("Option" | "Result"));
        let has_several = |ty: &Ty| matches!(ty, Ty::Tuple(parts) if parts.len() > 1);
        let has_parts = match self.graph.var(site.result).ty.peel() {
            ty @ Ty::Tuple(_) => has_several(ty),
            Ty::Adt(id, _) => matches!(index.type_def(*id).shape, Shape::Struct(_)),
            ty @ Ty::External(_, args) => {
                is_optional(ty) && args.first().is_some_and(|held| is_optional(held) || has_several(held))
            }
            _ => false,
        };
        let all = site.into.iter().copied().chain([site.result]);
        all.filter(|_| has_parts).collect()
    }

    /// The variable into which a call gives one of some numbers that are spelled out: `-1` where it has not updated, and `0` where it has.
    fn number_given(&self, site: &CallSite) -> Option<Var> {
        let is_number = *self.graph.var(site.result).ty.peel() == Ty::Int;
        let heads = |target: &FunctionId| self.summaries.get(*target).map_or(returned::ANY, |summary| summary.heads);
        let are_told = || !site.targets.is_empty() && site.targets.iter().all(|target| heads(target) != returned::ANY);
        (is_number && are_told()).then_some(site.result)
    }

    /// Whether a condition asks for such a number otherwise than whether it is a small one: `step(&mut pid) < 0`.
    fn asks_number(&self, number: Option<(Var, Span)>, test: &Test) -> bool {
        let Some((number, given_at)) = number else { return false };
        let subject = test.subject.map(|id| &self.graph.subjects[id.0 as usize]);
        let is_it = |place: &Place| {
            place.base_var().is_some_and(|var| var == number || self.aliases.is_derived(var, &[number]))
        };
        let is_followed = subject.is_some_and(|subject| {
            subject.whole.as_ref().is_some_and(is_it) && subject.heads.iter().all(|head| small_number(head).is_some())
        });
        let mut reads = test.about.reads.iter().chain(subject.into_iter().flat_map(|subject| &subject.reads));
        !is_followed && (reads.any(is_it) || test.span != given_at && test.span.contains(given_at))
    }

    /// Whether a condition asks one of some variables for a truth value in it, or whether something is there.
    fn asks_truth_of(&self, vars: &[Var], test: &Test) -> bool {
        let about = &test.about;
        let is_one = |place: &Place| {
            place.base_var().is_some_and(|var| vars.contains(&var) || self.aliases.is_derived(var, vars))
        };
        let is_truth = |place: &Place| place_ty(self.program.index, self.graph, place) == Some(Ty::Bool);
        let subject = test.subject.map(|id| &self.graph.subjects[id.0 as usize]);
        // What is known of the value as a whole is followed.
        let result = vars.last().map(|var| &self.graph.var(*var).ty);
        let whole = subject.and_then(|subject| subject.whole.as_ref()).filter(|place| place.steps.is_empty());
        let is_whole = whole.and_then(Place::base_var).is_some_and(|var| Some(&self.graph.var(var).ty) == result);
        let reads = about.reads.iter().chain(subject.into_iter().flat_map(|subject| &subject.reads));
        let mut reads = reads.filter(|place| is_one(place));
        !vars.is_empty()
            && !is_whole
            && reads.any(|place| about.asks_presence() || !about.is_comparison && is_truth(place))
    }

    /// The truth values that a call sets to nothing but constants, with these.
    fn flags_of(&self, site: &CallSite) -> Vec<(Place, Vec<Head>)> {
        let mut found = Vec::new();
        for summary in site.targets.iter().filter_map(|target| self.summaries.get(*target)) {
            let mut sets: BTreeMap<&Given, Vec<Option<&Head>>> = BTreeMap::new();
            for (given, head, _) in &summary.sets {
                sets.entry(given).or_default().push(head.as_ref());
            }
            for (given, heads) in sets {
                let heads: Option<Vec<Head>> = heads.into_iter().map(Option::<&Head>::cloned).collect();
                let (Some(place), Some(heads)) = (place_of(given, site), heads) else { continue };
                if place_ty(self.program.index, self.graph, &place) == Some(Ty::Bool) {
                    found.extend(self.aliases.shared_roots(&place).iter().map(|root| (root.clone(), heads.clone())));
                }
            }
        }
        found
    }
}

/// Whether a call may come back without an update.
fn may_skip(exploration: &Exploration, call: NodeId) -> bool {
    let states = &exploration.states;
    let is_before = |at: usize| states[at].node == call && states[at].count == Count::Zero;
    let mut skipping = (0..states.len()).filter(|at| states[*at].count == Count::Zero);
    skipping.any(|at| exploration.parent(at).is_some_and(is_before))
}
