//! States that laws give back: how far each is ahead of the one in the instance's place, until it takes that place.

use std::borrow::Cow;

use super::run::Run;
use super::{Region, Search, State};
use crate::count::counts::Count;
use crate::count::instances::place_ty;
use crate::count::outcome::Outcome;
use crate::count::returned;
use crate::flow::{Advance, Assignment, CallSite, Cause, Effect, NodeId, Place, Relation, Returned, Transfer, Var};
use crate::index::handed;

/// Places that hold other states of the instance than its own place, each with how far it is ahead.
pub(super) type Versions = Vec<(Place, Count)>;

/// How far a state is ahead that a function gives back, in which a law may have run: that is not followed.
const UNTOLD: Count = Count::PerSample;

/// More of them tell nothing: what is forgotten is a new value where it is put back.
const MAX_VERSIONS: usize = 16;

/// Functions and methods of the standard library in which no law runs.
const KEEPS_STATE: &[&str] = &[
    "abs",
    "ceil",
    "clamp",
    "clone",
    "cloned",
    "copied",
    "exp",
    "expect",
    "floor",
    "from",
    "into",
    "is_err",
    "is_finite",
    "is_nan",
    "is_none",
    "is_ok",
    "is_some",
    "ln",
    "max",
    "min",
    "mul_add",
    "powf",
    "powi",
    "read",
    "recip",
    "rem_euclid",
    "round",
    "signum",
    "sqrt",
    "to_owned",
    "trunc",
    "unwrap",
    "unwrap_or",
    "unwrap_or_default",
];

/// The ways through a function for what it gets by value: what it does to it is done to what it gives back.
pub(super) fn by_value<'o>(outcomes: &'o [Outcome], place: &Place, site: &CallSite) -> Cow<'o, [Outcome]> {
    let is_given = site.handed().is_some_and(|(_, before)| before == place);
    let is_moved = site.hands.as_ref().is_some_and(|(number, _)| site.args[*number].is_moved);
    // Most calls hand no state on, and are looked at for each state of a search.
    if !is_given || !is_moved {
        return Cow::Borrowed(outcomes);
    }
    let mut outcomes = outcomes.to_vec();
    for outcome in &mut outcomes {
        outcome.ahead = outcome.total();
        outcome.count = Count::Zero;
    }
    Cow::Owned(outcomes)
}

/// What is left of a way when the state before it is forgotten.
fn rebased(ahead: Count, by: Count) -> Option<Count> {
    match (ahead, by) {
        (UNTOLD, _) => Some(UNTOLD),
        (ahead, Count::Zero) => Some(ahead),
        (Count::One, Count::One) => Some(Count::Zero),
        _ => None,
    }
}

impl Search<'_> {
    /// The law that gives back its next state here, as the source calls it.
    pub(in crate::count) fn method_of_advance(&self) -> Option<String> {
        self.near().find_map(|id| match &self.graph.node(id).effect {
            Effect::Advance(advance) if advance.law == self.law && self.may_be(&advance.before, true) => {
                Some(advance.method.clone())
            }
            _ => None,
        })
    }

    /// Whether its next state is given back, here or by what is called, wherever it goes.
    pub(in crate::count) fn is_advanced(&self) -> bool {
        self.method_of_advance().is_some()
            || self.near().any(|id| match &self.graph.node(id).effect {
                Effect::Call(site) => {
                    self.summaries.advanced(site).any(|law| law == self.law)
                        && site.handed().is_some_and(|(_, before)| self.may_be(before, true))
                }
                _ => false,
            })
    }
}

impl Run<'_, '_> {
    /// A law ran that leaves the filter as it was where its result is an `Err`.
    pub(super) fn attempt(&mut self, at: usize, before: &State, after: &State, result: Var) {
        let masks = self.with_heads(after.masks, result, returned::PRESENT | returned::OTHER);
        self.everywhere(at, &State { masks, ..after.clone() });
        let masks = self.with_heads(before.masks, result, returned::ABSENT);
        let attempted = before.count == Count::Zero;
        self.everywhere(at, &State { masks, attempted, direct: after.direct, ..before.clone() });
    }

    /// How far what a place holds is ahead of the instance; `None` if it is none of its states.
    pub(super) fn ahead_at(&self, state: &State, place: &Place) -> Option<Count> {
        let versions = self.versions.get(state.versions);
        if let Some((_, ahead)) = versions.iter().find(|(own, _)| own == place) {
            return Some(*ahead);
        }
        let is_it = |relation: &Relation| matches!(relation, Relation::Holds(rest) if rest.is_empty());
        self.relations(state, place).iter().any(is_it).then_some(Count::Zero)
    }

    pub(super) fn with_version(&mut self, versions: u32, place: &Place, ahead: Count) -> u32 {
        let mut all = self.versions.get(versions).clone();
        all.retain(|(own, _)| own != place);
        if all.len() < MAX_VERSIONS {
            all.push((place.clone(), ahead));
        }
        all.sort();
        self.versions.intern(all)
    }

    /// A law gives back the next state.
    pub(super) fn advance(&mut self, at: usize, state: &State, advance: &Advance) {
        let mut next = state.clone();
        let Some(before) = self.ahead_at(state, &advance.before) else {
            let relations = self.relations(state, &advance.before);
            if let Some(cause) = self.doubt(state, &advance.before, &relations) {
                next.unknown = Some(self.cause(&cause));
            }
            return self.everywhere(at, &next);
        };
        let by = if advance.law == self.search.law { Count::One } else { Count::Zero };
        let after = if before == UNTOLD { UNTOLD } else { before.then(by) };
        next.versions = self.with_version(next.versions, &advance.after, after);
        if let Some(result) = advance.attempt.filter(|_| by == Count::One) {
            let failed = self.with_heads(next.masks, result, returned::ABSENT);
            let given = self.with_heads(next.masks, result, returned::PRESENT | returned::OTHER);
            if failed != given {
                // Without a fallback the attempt counts.
                let attempted = next.count == Count::Zero && before == Count::Zero;
                let versions = state.versions;
                self.everywhere(at, &State { masks: failed, versions, attempted, direct: true, ..next.clone() });
                next.masks = given;
            }
        }
        self.everywhere(at, &next);
    }

    /// What laws gave back takes the place of the instance: as many of them ran.
    pub(super) fn taken_over(&mut self, state: &State, place: &Place, given: &Place) -> State {
        let mut next = state.clone();
        let relations = self.relations(state, place);
        let is_exact = relations.iter().any(|relation| matches!(relation, Relation::Holds(rest) if rest.is_empty()))
            || place == self.search.instance;
        match self.ahead_at(state, given) {
            // It is told where it takes the place.
            Some(UNTOLD) => {}
            Some(ahead) if is_exact => {
                self.add(&mut next, ahead);
                next.direct |= ahead != Count::Zero;
            }
            Some(ahead) if ahead != Count::Zero => {
                if let Some(cause) = self.doubt(state, place, &relations) {
                    next.unknown = Some(self.cause(&cause));
                }
            }
            _ => {}
        }
        next
    }

    /// Whether a law has given back a state that is not in the instance's place yet.
    pub(super) fn is_ahead(&self, state: &State) -> bool {
        self.versions.get(state.versions).iter().any(|(_, ahead)| *ahead != Count::Zero)
    }

    /// What a new value is made of, where there is a next state, is not known.
    pub(super) fn made_of_next(&mut self) -> u16 {
        self.cause(&Cause::Code("what is made of its next state".to_owned()))
    }

    /// Follows the states of the instance through an assignment. Answers whether one takes the instance's own place.
    pub(super) fn versions_after(&mut self, next: &mut State, set: &Assignment) -> bool {
        let versions = self.versions.get(next.versions).clone();
        let mut gained: Versions = Vec::new();
        if let Some(from) = &set.from {
            for (own, ahead) in &versions {
                match from.relate(own, &|_| None) {
                    Relation::Holds(rest) => gained.push((set.place.join(&rest), *ahead)),
                    // A part of it may be the state: `advanced(y)?`.
                    _ if *ahead == UNTOLD && matches!(own.relate(from, &|_| None), Relation::Holds(_)) => {
                        gained.push((set.place.clone(), UNTOLD));
                    }
                    _ => {}
                }
            }
            if gained.is_empty() && set.transfer == Transfer::Copy && self.is_given_back() {
                gained.extend(self.ahead_at(next, from).map(|ahead| (set.place.clone(), ahead)));
            }
        }
        if gained.is_empty() && versions.is_empty() {
            return false;
        }
        let is_over = |own: &Place| matches!(set.place.relate(own, &|_| None), Relation::Holds(_));
        let mut names = self.names.get(next.names).clone();
        let is_own = |place: &Place| names.contains(place) || place == self.search.instance;
        let is_around = |place: &Place| {
            names
                .iter()
                .chain([self.search.instance])
                .any(|name| matches!(place.relate(name, &|_| None), Relation::Holds(_)))
        };
        let is_untold = gained.iter().any(|(place, ahead)| *ahead == UNTOLD && is_around(place));
        if is_untold {
            next.unknown = Some(self.made_by_some_call());
            gained.retain(|(_, ahead)| *ahead != UNTOLD);
        }
        let taken = gained.iter().find(|(place, _)| is_own(place)).map(|(_, ahead)| *ahead);
        if let Some(by) = taken.filter(|by| *by != Count::Zero && !self.is_counted(set)) {
            self.add(next, by);
            next.direct = true;
        }
        if taken.is_some() && !names.contains(&set.place) {
            // It was moved out of its place before, and is back.
            names.push(set.place.clone());
            names.sort();
            next.names = self.names.intern(names);
        }
        let mut after: Versions = versions.into_iter().filter(|(own, _)| !is_over(own)).collect();
        if let Some(by) = taken {
            after = after.into_iter().filter_map(|(own, ahead)| Some((own, rebased(ahead, by)?))).collect();
        } else {
            after.extend(gained);
        }
        after.sort();
        after.dedup();
        after.truncate(MAX_VERSIONS);
        next.versions = self.versions.intern(after);
        taken.is_some() || is_untold
    }

    /// Whether that a next state takes its place is told by an update before it. What is swapped or cloned there is not.
    fn is_counted(&self, set: &Assignment) -> bool {
        self.search.graph.nodes.iter().any(|node| match &node.effect {
            Effect::Update(update) => update.given.is_some() && update.given == set.from,
            _ => false,
        })
    }

    /// What a call gives back is a state of which it is not known how far it is ahead, if a law may have run in it that had the instance.
    pub(super) fn untold_after(&mut self, state: &State, site: &CallSite) -> u32 {
        if self.is_untold_step(state, site) {
            self.with_version(state.versions, &Place::var(site.result), UNTOLD)
        } else {
            state.versions
        }
    }

    pub(super) fn is_untold_step(&self, state: &State, site: &CallSite) -> bool {
        let steps = || self.search.summaries.gives_next(site);
        if site.law_of.is_some() || site.hands.is_some() || !steps() || !self.is_given_back() {
            return false;
        }
        let names = self.names.get(state.names);
        let versions = self.versions.get(state.versions).iter().map(|(place, _)| place);
        let states: Vec<&Place> = names.iter().chain([self.search.instance]).chain(versions).collect();
        let read = site.args.iter().flat_map(|arg| arg.place.iter().chain(&arg.value_of).chain(&arg.from.places));
        read.into_iter().any(|place| {
            let roots = self.search.aliases.shared_roots(place);
            states.iter().any(|state| state.overlaps(place) || roots.iter().any(|root| root.overlaps(state)))
        })
    }

    fn made_by_some_call(&mut self) -> u16 {
        let steps = |site: &&CallSite| site.law_of.is_none() && self.search.summaries.gives_next(site);
        let calls = self.search.graph.nodes.iter().filter_map(|node| match &node.effect {
            Effect::Call(site) => Some(&**site),
            _ => None,
        });
        let text = calls.into_iter().find(steps).map_or_else(String::new, |site| site.text.clone());
        self.cause(&Cause::Code(format!("what `{text}` makes of its state")))
    }

    /// Why a new value in the place of the instance may be its next state: it is made of the one before by a call that is not read.
    pub(super) fn made_by_unread(&self, node: NodeId) -> Option<Cause> {
        if !self.is_given_back() {
            return None;
        }
        let graph = self.search.graph;
        let computed = &graph.changes.get(&node)?.computed;
        let is_of_it = |place: &Place| {
            self.search.aliases.shared_roots(place).iter().any(|root| root.overlaps(self.search.instance))
        };
        let index = self.search.program.index;
        let is_unread = |name: &&String| {
            !KEEPS_STATE.contains(&name.as_str())
                && !self.search.summaries.of.keys().any(|id| index.function(*id).name == **name)
        };
        let call = computed.calls.iter().find(is_unread).filter(|_| computed.places.iter().any(is_of_it))?;
        Some(Cause::Code(format!("what `{call}` makes of its state")))
    }

    /// A function hands through a state that is not in the instance's own place.
    pub(super) fn handed_through(
        &mut self,
        states: Vec<(State, returned::Heads)>,
        site: &CallSite,
    ) -> Vec<(State, returned::Heads)> {
        let Some((result, given)) = site.handed() else { return states };
        let handed = self.search.summaries.handed(site, self.search.law);
        let outcomes = by_value(&handed, given, site);
        let mut after = Vec::new();
        for (state, heads) in states {
            let Some(base) = self.ahead_at(&state, given) else {
                after.push((state, heads));
                continue;
            };
            let mut add = |next: State, heads| {
                if heads != 0 && !after.contains(&(next.clone(), heads)) {
                    after.push((next, heads));
                }
            };
            if outcomes.is_empty() {
                // What a law does to a type parameter is told of none of its types.
                let ahead = if self.search.summaries.gives_next(site) { UNTOLD } else { base };
                let versions = self.with_version(state.versions, result, ahead);
                add(State { versions, ..state.clone() }, heads);
            }
            for outcome in outcomes.iter() {
                let ahead = if base == UNTOLD { UNTOLD } else { base.then(outcome.ahead) };
                let versions = self.with_version(state.versions, result, ahead);
                let unknown = outcome.unknown.as_ref().map(|cause| self.cause(cause)).or(state.unknown);
                add(State { versions, unknown, ..state.clone() }, heads & outcome.returned);
            }
        }
        after
    }

    /// How far the state that a function gives back is ahead; what is made of it in another way is not known.
    pub(super) fn given_back(&mut self, state: &State, value: &Returned) -> (State, Count) {
        let versions = self.versions.get(state.versions).clone();
        if !self.is_ahead(state)
            || value.head.as_deref() == Some("-")
            || self.region != Region::Function
            || !self.gives_state()
        {
            return (state.clone(), Count::Zero);
        }
        let is_it = |own: &Place, place: &Place| matches!(place.relate(own, &|_| None), Relation::Holds(_));
        let is_in = |own: &Place| value.place.as_ref().is_some_and(|place| is_it(own, place));
        let inside: Vec<Count> = versions.iter().filter(|(own, _)| is_in(own)).map(|(_, ahead)| *ahead).collect();
        match inside.as_slice() {
            [ahead] => (state.clone(), *ahead),
            [] if value.place.as_ref().is_some_and(|place| self.ahead_at(state, place).is_some()) => {
                (state.clone(), Count::Zero)
            }
            _ => (State { unknown: Some(self.made_of_next()), ..state.clone() }, Count::One),
        }
    }

    /// Whether the instance is the state of a law that gives back the next one.
    fn is_given_back(&self) -> bool {
        let Search { program, graph, instance, .. } = self.search;
        place_ty(program.index, graph, instance).is_some_and(|ty| program.index.returned_spec(&ty).is_some())
    }

    /// Whether the function gives back a state of the instance's type.
    fn gives_state(&self) -> bool {
        let Search { program, graph, instance, .. } = self.search;
        let index = program.index;
        let output = &index.function(graph.function).function.output;
        let output = index.lower(output, &index.scope_of(graph.function));
        place_ty(index, graph, instance).is_some_and(|ty| handed(&output, &ty).is_some())
    }
}
