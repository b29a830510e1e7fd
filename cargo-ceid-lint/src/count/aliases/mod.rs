//! Which places a place may be another name of, whatever the path. Knows no counts.

mod near;
mod shrinking;

use std::cell::{Cell, OnceCell, RefCell};
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use rustc_hash::FxHashMap;

use self::shrinking::{comes_from_itself, without_numbers};
use super::called_place::CalledPlace;
use super::given::{Given, may_match, place_of};
use super::instances::{lends, may_hold_filter};
use super::moves;
use super::referred;
use super::search::Called;
use super::shared_handles::shared_handles;
use super::summary::Summaries;
use crate::flow::{
    Assignment, Base, CallSite, Cause, ControlFlowGraph, Effect, IndexKey, LoopId, LoopInfo, NodeId, Place, Relation,
    Steps, Transfer, Update, Var,
};
use crate::index::{Index, Ty};

/// The names of a function's places.
#[derive(Debug, Default)]
pub(super) struct Aliases {
    /// What a variable, or a part of it, was given: the steps into the variable, and the place.
    sources: BTreeMap<Var, Vec<(Steps, Place)>>,
    unnamed: BTreeSet<Var>,
    /// Handles of which there are others.
    handles: BTreeSet<Var>,
    /// Variables that hold no filter and refer to none.
    plain: BTreeSet<Var>,
    /// Variables that hold a value of their own.
    owning: BTreeSet<Var>,
    /// Parameters that outlive the function under whatever name: handles, and what is given back.
    handed: BTreeSet<Var>,
    /// Which variables were computed from which.
    pub(super) derived: BTreeMap<Var, BTreeSet<Var>>,
    /// Places that may hold a state that is not in the place of the one before yet, with the halves of the laws that gave it.
    advanced: BTreeMap<Place, BTreeSet<usize>>,
    /// Collections of which a call is told the number of an element by a variable.
    indexed: Vec<(Var, Place)>,
    /// The roots of the places that were asked for.
    known: RefCell<FxHashMap<Place, Arc<[Place]>>>,
    /// What the calls that were asked for have to do with, by their results.
    calls: RefCell<FxHashMap<Var, Arc<[CalledPlace]>>>,
    /// What calls mean to an instance that they have nothing to do with, by their results.
    beside: RefCell<FxHashMap<Var, Arc<Called>>>,
    /// The nodes at which something happens to what a base has.
    near: OnceCell<FxHashMap<Base, Vec<NodeId>>>,
    /// Whether there were more names than are followed, so that a place may be one of another that is not known.
    is_cut_off: Cell<bool>,
}

/// The places that a place may be a name of.
#[derive(Debug)]
pub(super) enum Roots<'a> {
    /// It is a name of nothing else.
    Itself(&'a Place),
    Others(Arc<[Place]>),
}

impl std::ops::Deref for Roots<'_> {
    type Target = [Place];

    fn deref(&self) -> &[Place] {
        match self {
            Self::Itself(place) => std::slice::from_ref(place),
            Self::Others(places) => places,
        }
    }
}

/// How many names are looked at for one place: variables that are given parts of each other have more with each link.
const MAX_NAMES: usize = 1_000;

/// How many steps a name may have: a reference that runs through a list has one more with each link, and names nothing there.
const MAX_STEPS: usize = 24;

/// How many places are asked for the one that keeps what was moved.
const MAX_MOVES: usize = 64;

impl Aliases {
    pub(super) fn of(index: &Index, graph: &ControlFlowGraph, summaries: &Summaries) -> Self {
        let given_back = moves::given_back(index, graph, summaries);
        let mut aliases = Self {
            handles: shared_handles(index, graph, summaries),
            handed: given_back.iter().map(|borrow| graph.params[borrow.param]).collect(),
            ..Self::default()
        };
        for (number, info) in (0u32..).zip(&graph.vars) {
            if info.name.is_empty() && info.param.is_none() {
                aliases.unnamed.insert(Var(number));
            }
            if !may_hold_filter(index, &info.ty) {
                aliases.plain.insert(Var(number));
            }
            // What a function is given has its own value until it is given another one.
            if info.param.is_some() {
                aliases.owning.insert(Var(number));
                aliases.handed.extend(index.is_handle(&info.ty).then_some(Var(number)));
            }
        }
        for (id, node) in graph.node_ids().zip(&graph.nodes) {
            match &node.effect {
                // What was copied out of a place stays as it was when that is given another value.
                Effect::Set(set) if graph.copies.contains_key(&id) && aliases.is_plain_variable(graph, set) => {}
                Effect::Set(set) => {
                    let Some(var) = set.place.base_var() else { continue };
                    match &set.from {
                        Some(_) if moves::is_given_another(graph, set, node.in_loop) => {
                            aliases.owning.insert(var);
                        }
                        _ => {}
                    }
                    match &set.from {
                        Some(from) => aliases.add(index, graph, &set.place, from, set.transfer, node.in_loop),
                        None if index.refers_to_filters(&graph.var(var).ty) => {}
                        None => {
                            aliases.owning.insert(var);
                        }
                    }
                }
                Effect::Write(write) if write.rebinds || graph.pointed.contains(&id) => {
                    if let Some(from) = &write.from {
                        aliases.add(index, graph, &write.place, from, write.transfer, node.in_loop);
                        let others = graph.pointed.contains(&id).then(|| referred::led_to(index, graph, &write.place));
                        for other in others.into_iter().flatten() {
                            aliases.add(index, graph, &other, from, write.transfer, node.in_loop);
                        }
                    }
                }
                Effect::Call(site) => {
                    aliases.index_through(site, summaries);
                    if let Some((after, before)) = site.handed() {
                        aliases.name(after, before);
                    }
                    for (part, from, transfer) in summaries.gives(site) {
                        let to = Place::var(site.result).join(part);
                        aliases.add(index, graph, &to, &from, transfer, node.in_loop);
                    }
                }
                Effect::Advance(advance) => aliases.name(&advance.after, &advance.before),
                _ => {}
            }
        }
        aliases.find_advanced(graph, summaries);
        for info in &graph.loops {
            for (var, place) in &info.items {
                aliases.name(&Place::var(*var), place);
            }
        }
        for (to, from) in &graph.derived {
            aliases.derived.entry(*to).or_default().insert(*from);
        }
        aliases
    }

    /// Whether a whole variable is assigned that holds no filter, and is no reference.
    fn is_plain_variable(&self, graph: &ControlFlowGraph, set: &Assignment) -> bool {
        let own = set.place.base_var().filter(|_| set.place.steps.is_empty());
        own.is_some_and(|var| self.plain.contains(&var) && !matches!(graph.var(var).ty, Ty::Ref(..)))
    }

    /// A place in a value in between is another name.
    fn name(&mut self, to: &Place, from: &Place) {
        // What is given to itself only gets to be known better.
        let Some(var) = to.base_var().filter(|_| to != from) else { return };
        let sources = self.sources.entry(var).or_default();
        let entry = (to.steps.clone(), from.clone());
        if !sources.contains(&entry) {
            sources.push(entry);
        }
    }

    /// Finds what holds the states that laws give back.
    fn find_advanced(&mut self, graph: &ControlFlowGraph, summaries: &Summaries) {
        let mut changed = true;
        while std::mem::take(&mut changed) {
            for node in &graph.nodes {
                let found = match &node.effect {
                    Effect::Advance(advance) => {
                        let mut laws = self.laws_before(&advance.before);
                        laws.insert(advance.law);
                        vec![(advance.after.clone(), laws)]
                    }
                    Effect::Call(site) => {
                        let Some((after, before)) = site.handed() else { continue };
                        let mut laws = self.laws_before(before);
                        laws.extend(summaries.advanced(site));
                        vec![(after.clone(), laws)]
                    }
                    Effect::Set(set) if !self.advanced.is_empty() => {
                        let Some(from) = &set.from else { continue };
                        let inside =
                            self.advanced.iter().filter_map(|(place, laws)| match from.relate(place, &|_| None) {
                                Relation::Holds(rest) => Some((set.place.join(&rest), laws.clone())),
                                _ => None,
                            });
                        inside.filter(|(place, _)| place.steps.len() <= MAX_STEPS).collect()
                    }
                    _ => continue,
                };
                for (place, laws) in found.into_iter().filter(|(_, laws)| !laws.is_empty()) {
                    let known = self.advanced.entry(place).or_default();
                    let before = known.len();
                    known.extend(laws);
                    changed |= known.len() > before;
                }
            }
        }
    }

    fn laws_before(&self, place: &Place) -> BTreeSet<usize> {
        self.advanced.get(place).cloned().unwrap_or_default()
    }

    /// Whether a place may hold a state that a half of a law gave back.
    pub(super) fn is_advanced(&self, place: &Place, law: usize) -> bool {
        self.advanced.get(place).is_some_and(|laws| laws.contains(&law))
    }

    /// The same for any half.
    pub(super) fn has_advanced(&self, place: &Place) -> bool {
        self.advanced.contains_key(place)
    }

    /// The halves that an update runs: those that gave what takes a state's place, or its own.
    pub(super) fn runs(&self, update: &Update, law: usize) -> bool {
        update.given.as_ref().map_or(update.law == law, |given| self.is_advanced(given, law))
    }

    /// Notes of which collections a callee takes the element that an argument numbers.
    fn index_through(&mut self, site: &CallSite, summaries: &Summaries) {
        let targets = site.targets.iter().filter_map(|target| summaries.get(*target));
        for given in targets.flat_map(|summary| summary.given_places().cloned().chain(summary.lent_places(site))) {
            for (at, step) in given.steps.iter().enumerate() {
                let Some(IndexKey::Param(param)) = step.key() else { continue };
                let Some(IndexKey::Var(var)) = site.args.get(*param).and_then(|arg| arg.index.as_ref()) else {
                    continue;
                };
                let collection = Given { base: given.base, steps: given.steps[..at].into() };
                if let Some(place) = place_of(&collection, site) {
                    let entry = (*var, place);
                    if !self.indexed.contains(&entry) {
                        self.indexed.push(entry);
                    }
                }
            }
        }
    }

    /// The collections that are indexed with the counter of a loop, here or in what is called.
    pub(super) fn indexed_by<'a>(&'a self, info: &'a LoopInfo) -> impl Iterator<Item = &'a Place> {
        let counter = info.counter.map(|(counter, _)| counter);
        let through = self.indexed.iter().filter(move |(var, _)| Some(*var) == counter).map(|(_, place)| place);
        info.indexes.iter().chain(through)
    }

    fn add(
        &mut self,
        index: &Index,
        graph: &ControlFlowGraph,
        to: &Place,
        from: &Place,
        transfer: Transfer,
        at: Option<LoopId>,
    ) {
        let (Some(var), steps) = (to.base_var(), &to.steps) else { return };
        let is_reference = matches!(graph.var(var).ty, Ty::Ref(..)) || lends(index, graph, from);
        // What is moved into a variable or a new value lives there from now on, and so does a copy that is not put back.
        let is_moved = transfer == Transfer::Move && !is_reference;
        let is_value = |var: Var| matches!(graph.var(var).ty, Ty::Adt(..) | Ty::External(..) | Ty::Opaque(_));
        let is_part = !steps.is_empty() && from.steps.is_empty() && from.base_var().is_some_and(is_value);
        let has_own = !self.unnamed.contains(&var) || is_part;
        let is_shared = from.steps.is_empty() && from.base_var().is_some_and(|var| self.handles.contains(&var));
        let is_copied = transfer == Transfer::Copy && !is_reference;
        if is_copied || (is_moved && has_own && !is_shared && !self.keeps_moved(graph, from, at)) {
            if steps.is_empty() {
                self.owning.insert(var);
            }
            return;
        }
        self.name(to, from);
    }

    /// Whether what is moved out of a place is still that place's instance, or one's from which it was moved there.
    fn keeps_moved(&self, graph: &ControlFlowGraph, from: &Place, at: Option<LoopId>) -> bool {
        self.keeps_itself(graph, from, at) || self.is_moved_on(graph, from, at, &mut BTreeSet::new())
    }

    /// Whether a place keeps its instance: a parameter's or static's outlives the function, and others the loop that takes it.
    fn keeps_itself(&self, graph: &ControlFlowGraph, from: &Place, at: Option<LoopId>) -> bool {
        let Some(var) = from.base_var() else { return true };
        let info = graph.var(var);
        let is_callers = info.param.is_some() && (!from.steps.is_empty() || matches!(info.ty, Ty::Ref(..)));
        if is_callers || self.unnamed.contains(&var) || self.handed.contains(&var) {
            return true;
        }
        match at {
            None => false,
            Some(inner) => match info.in_loop {
                None => true,
                Some(declared) => declared != inner && graph.is_within(Some(inner), declared),
            },
        }
    }

    /// Whether what is moved out of a place was moved there from one that keeps it. Moves may go in a circle.
    fn is_moved_on(
        &self,
        graph: &ControlFlowGraph,
        from: &Place,
        at: Option<LoopId>,
        seen: &mut BTreeSet<Place>,
    ) -> bool {
        if seen.len() >= MAX_MOVES || !seen.insert(from.clone()) {
            return false;
        }
        let sources = from.base_var().and_then(|var| self.sources.get(&var));
        sources.into_iter().flatten().any(|(steps, source)| {
            // What a function has by value ends with it, under whatever name.
            let outlives = source.base_var().is_none_or(|var| {
                !self.unnamed.contains(&var) && (at.is_some() || matches!(graph.var(var).ty, Ty::Ref(..)))
            });
            let rest = from.steps.get(steps.len()..).unwrap_or_default();
            let source = source.join(rest);
            may_match(steps, &from.steps)
                && (outlives && self.keeps_itself(graph, &source, at) || self.is_moved_on(graph, &source, at, seen))
        })
    }

    /// The places that a place may be a name of, itself if it is a name of nothing else.
    pub(super) fn roots(&self, place: &Place) -> Vec<Place> {
        self.shared_roots(place).to_vec()
    }

    /// The same for those who only look.
    pub(super) fn shared_roots<'a>(&self, place: &'a Place) -> Roots<'a> {
        if place.base_var().is_none_or(|var| !self.sources.contains_key(&var)) {
            return Roots::Itself(place);
        }
        if let Some(known) = self.known.borrow().get(place) {
            return Roots::Others(Arc::clone(known));
        }
        let mut found = BTreeSet::new();
        let mut seen = BTreeMap::new();
        let is_cut_off = self.is_cut_off.get();
        self.follow(place, place.steps.len(), &mut seen, &mut found);
        // The names of what holds no filter do not matter.
        if place.base_var().is_some_and(|var| self.plain.contains(&var)) {
            self.is_cut_off.set(is_cut_off);
        }
        let roots: Arc<[Place]> = found.into_iter().collect();
        self.known.borrow_mut().insert(place.clone(), Arc::clone(&roots));
        Roots::Others(roots)
    }

    /// Why some place may be a name of another that is not known, if one may.
    pub(super) fn limit(&self) -> Option<Cause> {
        self.is_cut_off.get().then(|| Cause::Limit("the function has too many names for its filters".to_owned()))
    }

    /// The parts of a place that are names of other places, with those places; the whole if it is one.
    pub(super) fn parts(&self, place: &Place) -> Vec<(Steps, Place)> {
        let mut found: Vec<(Steps, Place)> =
            self.roots(place).into_iter().map(|root| (Steps::default(), root)).collect();
        let mut open = vec![(Steps::default(), place.clone(), 0)];
        while let Some((part, place, links)) = open.pop() {
            let Some(var) = place.base_var().filter(|_| links < 6) else { continue };
            for (steps, source) in self.sources.get(&var).into_iter().flatten() {
                if !may_match(steps, &place.steps) {
                    continue;
                }
                if steps.len() > place.steps.len() {
                    let inner: Steps = part.iter().chain(&steps[place.steps.len()..]).cloned().collect();
                    found.extend(self.roots(source).into_iter().map(|root| (inner.clone(), root)));
                    // What is put in a part may be made of parts itself: `(Port { chip: self }, Port { chip: self })`.
                    if source.steps.is_empty() {
                        open.push((inner, source.clone(), links + 1));
                    }
                } else {
                    open.push((part.clone(), source.join(&place.steps[steps.len()..]), links + 1));
                }
            }
        }
        found.sort();
        found.dedup();
        found
    }

    /// What the variables, or parts of them, were given: the steps into each, and the place.
    pub(super) fn given(&self) -> impl Iterator<Item = (Var, &[(Steps, Place)])> {
        self.sources.iter().map(|(var, given)| (*var, given.as_slice()))
    }

    /// `asked` is how many steps the place has of which the names are asked for; `seen` is what others turned out to be names of, two
    /// of which may lead to one.
    fn follow(
        &self,
        place: &Place,
        asked: usize,
        seen: &mut BTreeMap<Place, BTreeSet<Place>>,
        found: &mut BTreeSet<Place>,
    ) {
        if seen.len() > MAX_NAMES {
            let is_part = place.steps.len() > asked;
            self.is_cut_off.set(self.is_cut_off.get() || !is_part);
            return;
        }
        if let Some(known) = seen.get(place) {
            found.extend(known.iter().cloned());
            return;
        }
        let Base::Var(var) = place.base else {
            found.insert(place.clone());
            return;
        };
        if place.steps.len() > asked + MAX_STEPS {
            return;
        }
        let Some(sources) = self.sources.get(&var) else {
            found.insert(place.clone());
            return;
        };
        // A slice that gets shorter in each round has ever other elements of one collection.
        if comes_from_itself(seen, place)
            && let Some(any) = without_numbers(place)
        {
            self.follow(&any, asked, seen, found);
            return;
        }
        seen.insert(place.clone(), BTreeSet::new());
        let mut own = BTreeSet::new();
        let mut has_source = false;
        for (steps, source) in sources {
            if place.steps.len() >= steps.len() && may_match(steps, &place.steps) {
                has_source = true;
                self.follow(&source.join(&place.steps[steps.len()..]), asked, seen, &mut own);
            }
        }
        // A value in between is no place of its own where a name of the source holds it.
        let named = !self.unnamed.contains(&var);
        if named {
            own.retain(|root| root.base_var().is_none_or(|base| !self.unnamed.contains(&base)));
        }
        if own.is_empty() || !has_source || (named && self.owning.contains(&var)) {
            own.insert(place.clone());
        }
        seen.insert(place.clone(), own.clone());
        found.append(&mut own);
    }
}
