//! Every way through a region, for one instance: how often it is updated, and what else happens to it.
//!
//! The ways are those of the control-flow graph, told apart by the count so far, the names that the instance has, and what is
//! known of the conditions that matter. A breadth-first search makes the first way that is found the shortest witness.

use std::collections::{BTreeSet, HashMap, VecDeque};

use super::aliases::Aliases;
use super::counts::Count;
use super::slice::{ControlDependence, Tracked, tracked};
use super::summary::{Outcome, Summaries, place_of, returned};
use super::verdict::Gate;
use crate::flow::{
    Assignment, Base, CallSite, Cause, ControlFlowGraph, Effect, IndexKey, LoopId, NodeId, OTHER_HEADS, Place, Program,
    Projection, Relation, Rounds, Test, Var,
};

/// What is searched.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Region {
    /// The whole function: one call is one iteration.
    Function,
    /// One iteration of a loop.
    Loop(LoopId),
}

/// How many states a search may have before it gives up.
const MAX_STATES: usize = 60_000;

/// Constant trip counts up to this are followed round by round.
const MAX_ROUNDS: u64 = 16;

/// Where a way is, and what happened on it.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(super) struct State {
    pub(super) node: NodeId,
    pub(super) count: Count,
    pub(super) in_sample: bool,
    pub(super) reset: bool,
    pub(super) partly_reset: bool,
    pub(super) direct: bool,
    /// The number of the cause for which nothing is certain any more.
    pub(super) unknown: Option<u16>,
    /// The node behind which no update can be reached any more on this way, without one before it.
    pub(super) skipped_at: Option<NodeId>,
    /// Why the helper called there skips, if it does so on purpose.
    pub(super) helper_gate: Option<Gate>,
    names: u32,
    masks: u32,
    rounds: u32,
}

/// How a way ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum EndKind {
    /// The next iteration follows.
    Completes,
    /// The loop or function is left for good.
    Exits,
}

/// A way's end.
#[derive(Clone, Debug)]
pub(super) struct End {
    pub(super) kind: EndKind,
    pub(super) state: State,
    /// The number of the state in [`Exploration::states`].
    pub(super) at: usize,
    pub(super) returned: u8,
}

/// All ways through a region.
#[derive(Debug)]
pub(super) struct Exploration {
    pub(super) states: Vec<State>,
    parents: Vec<Option<usize>>,
    pub(super) ends: Vec<End>,
    pub(super) causes: Vec<Cause>,
    /// Set if the search gave up.
    pub(super) limit: bool,
    /// Conditions that could not be told apart, because there are too many.
    pub(super) dropped: BTreeSet<crate::flow::SubjectId>,
}

impl Exploration {
    /// The states of the way to one, in order.
    pub(super) fn path(&self, at: usize) -> Vec<usize> {
        let mut path = vec![at];
        let mut at = at;
        while let Some(parent) = self.parents[at] {
            path.push(parent);
            at = parent;
        }
        path.reverse();
        path
    }
}

/// What is searched for.
pub(super) struct Search<'a> {
    pub(super) program: &'a Program<'a>,
    pub(super) graph: &'a ControlFlowGraph,
    pub(super) aliases: &'a Aliases,
    pub(super) summaries: &'a Summaries,
    pub(super) instance: &'a Place,
    pub(super) law: usize,
    /// Loops whose updates count once for each of their rounds.
    pub(super) sample_loops: BTreeSet<LoopId>,
    /// Loops that visit each element of the collection that the instance is an element of.
    covering: BTreeSet<LoopId>,
    dependence: std::rc::Rc<ControlDependence>,
}

#[derive(Default)]
struct Interner<T> {
    values: Vec<T>,
    known: HashMap<T, u32>,
}

impl<T: Clone + Eq + std::hash::Hash> Interner<T> {
    fn intern(&mut self, value: T) -> u32 {
        if let Some(id) = self.known.get(&value) {
            return *id;
        }
        let id = u32::try_from(self.values.len()).unwrap_or(u32::MAX);
        self.values.push(value.clone());
        self.known.insert(value, id);
        id
    }

    fn get(&self, id: u32) -> &T {
        &self.values[id as usize]
    }
}

/// How far each loop that is counted has come.
type RoundsDone = Vec<(LoopId, u64)>;

struct Run<'s, 'a> {
    search: &'s Search<'a>,
    region: Region,
    tracked: Tracked,
    names: Interner<Vec<Place>>,
    masks: Interner<Vec<u32>>,
    rounds: Interner<RoundsDone>,
    exploration: Exploration,
    /// The nodes from which an update can still be reached in the iteration.
    reach: Vec<bool>,
    seen: HashMap<State, usize>,
    queue: VecDeque<usize>,
}

impl<'a> Search<'a> {
    pub(super) fn with_dependence(
        program: &'a Program<'a>,
        graph: &'a ControlFlowGraph,
        aliases: &'a Aliases,
        summaries: &'a Summaries,
        instance: &'a Place,
        law: usize,
        dependence: std::rc::Rc<ControlDependence>,
    ) -> Self {
        let covering = covering_loops(graph, aliases, instance);
        let mut search = Self {
            program,
            graph,
            aliases,
            summaries,
            instance,
            law,
            sample_loops: BTreeSet::new(),
            covering,
            dependence,
        };
        search.sample_loops = search.own_cycles();
        search
    }

    /// Whether a loop visits each element once, the instance among them.
    pub(super) fn covers(&self, id: LoopId) -> bool {
        self.covering.contains(&id)
    }

    /// Whether a loop binds the instance or its index, so that it is no cycle of it.
    pub(super) fn binds(&self, id: LoopId) -> bool {
        self.covers(id) || indexes_instance(self.aliases, self.graph.loop_info(id), self.instance)
    }

    /// Loops of a called function that are cycles of their own: those whose number of rounds is not known.
    fn own_cycles(&self) -> BTreeSet<LoopId> {
        (0u32..)
            .zip(&self.graph.loops)
            .filter(|(number, info)| !matches!(info.rounds, Rounds::Constant(_)) && !self.covers(LoopId(*number)))
            .map(|(number, _)| LoopId(number))
            .collect()
    }

    /// The nodes at which something may happen to the instance, whatever its names.
    pub(super) fn touching(&self) -> BTreeSet<NodeId> {
        self.graph.node_ids().filter(|id| self.touches(*id, true)).collect()
    }

    /// The nodes that may update it.
    pub(super) fn updating(&self) -> BTreeSet<NodeId> {
        self.graph.node_ids().filter(|id| self.touches(*id, false)).collect()
    }

    /// The nodes behind which nothing is known of it.
    pub(super) fn unknown(&self) -> BTreeSet<NodeId> {
        let is_unknown = |id: &NodeId| match &self.graph.node(*id).effect {
            Effect::Unknown { places, .. } => places.iter().any(|place| self.may_be(place, false)),
            Effect::Call(site) => site.targets.iter().any(|target| {
                self.summaries.get(*target).is_some_and(|summary| {
                    summary.outcomes.iter().any(|(given, outcomes)| {
                        outcomes.iter().any(|outcome| outcome.unknown.is_some())
                            && place_of(given, site).is_some_and(|place| self.may_be(&place, false))
                    })
                })
            }),
            _ => false,
        };
        self.graph.node_ids().filter(is_unknown).collect()
    }

    /// Why nothing is known of the instance, where something unseen gets it.
    pub(super) fn unknown_cause(&self) -> Option<Cause> {
        let node = self.unknown().into_iter().next()?;
        match &self.graph.node(node).effect {
            Effect::Unknown { cause, .. } => Some(cause.clone()),
            Effect::Call(site) => site.targets.iter().find_map(|target| {
                let outcomes = self.summaries.get(*target)?.outcomes.values();
                outcomes.flatten().find_map(|outcome| outcome.unknown.clone())
            }),
            _ => None,
        }
    }

    fn touches(&self, id: NodeId, any: bool) -> bool {
        match &self.graph.node(id).effect {
            Effect::Update(update) => self.may_be(&update.place, true),
            Effect::Call(site) => self.call_touches(site, any),
            Effect::Reset { place, .. } => any && self.may_be(place, false),
            Effect::Unknown { places, .. } => any && places.iter().any(|place| self.may_be(place, false)),
            Effect::Write(write) => any && !write.rebinds && self.may_be(&write.place, false),
            Effect::Set(set) => any && set.from.as_ref().is_some_and(|from| self.may_be(from, false)),
            Effect::Return(_) => any,
            _ => false,
        }
    }

    fn call_touches(&self, site: &CallSite, any: bool) -> bool {
        site.targets.iter().any(|target| {
            self.summaries.get(*target).is_some_and(|summary| {
                summary.outcomes.iter().any(|(given, outcomes)| {
                    !(site.is_law && given.is_self())
                        && (any || outcomes.iter().any(|outcome| outcome.count != Count::Zero))
                        && place_of(given, site).is_some_and(|place| self.may_be(&place, true))
                })
            })
        })
    }

    /// Whether a place may be the instance, or hold it unless it must be exact.
    fn may_be(&self, place: &Place, exact: bool) -> bool {
        self.aliases.roots(place).iter().any(|root| match root.relate(self.instance, &|_| None) {
            Relation::Holds(rest) | Relation::MayHold(_, rest) => !exact || rest.is_empty(),
            Relation::Part | Relation::Apart => false,
        })
    }

    /// The ways through the whole function, as its callers see them.
    pub(super) fn outcomes(&self, region: Region) -> Vec<Outcome> {
        let exploration = self.explore(region, &[(NodeId(0), None)]);
        let mut outcomes: BTreeSet<Outcome> = BTreeSet::new();
        for end in &exploration.ends {
            outcomes.insert(Outcome {
                count: end.state.count,
                reset: end.state.reset,
                partly_reset: end.state.partly_reset,
                unknown: end.state.unknown.map(|cause| exploration.causes[cause as usize].clone()),
                direct: end.state.direct,
                returned: end.returned,
                gate: super::gates::of_end(self, region, &exploration, end),
            });
        }
        if exploration.limit {
            outcomes.insert(Outcome::unknown(Cause::Limit("the function has too many paths".to_owned())));
        }
        merge(outcomes)
    }

    /// Searches a region. Each start is a node with the names that the instance has there, or its own name.
    pub(super) fn explore(&self, region: Region, starts: &[(NodeId, Option<Entry>)]) -> Exploration {
        let touching = self.touching();
        let inside = |node: NodeId| match region {
            Region::Function => true,
            Region::Loop(id) => self.graph.is_within(self.graph.node(node).in_loop, id),
        };
        let mut touching_inside: BTreeSet<NodeId> = touching.into_iter().filter(|node| inside(*node)).collect();
        // A filter that is updated when its guard ends is touched there.
        touching_inside.extend(self.graph.node_ids().filter(|id| {
            inside(*id)
                && matches!(&self.graph.node(*id).effect, Effect::Update(update) if self.may_be(&update.place, true))
        }));
        let tracked = tracked(self.graph, &self.dependence, &touching_inside, &inside);
        let mut run = Run {
            search: self,
            region,
            tracked,
            names: Interner { values: Vec::new(), known: HashMap::new() },
            masks: Interner { values: Vec::new(), known: HashMap::new() },
            rounds: Interner { values: Vec::new(), known: HashMap::new() },
            exploration: Exploration {
                states: Vec::new(),
                parents: Vec::new(),
                ends: Vec::new(),
                causes: Vec::new(),
                limit: false,
                dropped: BTreeSet::new(),
            },
            reach: self.reach(region),
            seen: HashMap::new(),
            queue: VecDeque::new(),
        };
        for (node, entry) in starts {
            run.start(*node, entry.as_ref());
        }
        run.go();
        run.exploration.dropped.clone_from(&run.tracked.dropped);
        run.exploration
    }

    /// The nodes from which an update can be reached without leaving the iteration.
    pub(super) fn reach(&self, region: Region) -> Vec<bool> {
        let graph = self.graph;
        let mut before: Vec<Vec<NodeId>> = vec![Vec::new(); graph.nodes.len()];
        for id in graph.node_ids() {
            if let Region::Loop(own) = region
                && !graph.is_within(graph.node(id).in_loop, own)
            {
                continue;
            }
            for next in &graph.node(id).next {
                let ends = matches!(region, Region::Loop(own) if *next == graph.loop_info(own).head);
                // The next round of a loop over the elements is another element's.
                let others = matches!(&graph.node(*next).effect, Effect::LoopHead(inner)
                    if self.covers(*inner) && graph.is_within(graph.node(id).in_loop, *inner));
                if !ends && !others {
                    before[next.0 as usize].push(id);
                }
            }
        }
        let mut reach = vec![false; graph.nodes.len()];
        let mut open: Vec<NodeId> = self.updating().into_iter().collect();
        while let Some(id) = open.pop() {
            if !std::mem::replace(&mut reach[id.0 as usize], true) {
                open.extend(before[id.0 as usize].iter().copied());
            }
        }
        reach
    }

    /// The heads that a subject can have where a loop is entered: those of the constants that a variable is given outside it.
    fn known_before(&self, region: Region, id: crate::flow::SubjectId) -> u32 {
        let graph = self.graph;
        let subject = &graph.subjects[id.0 as usize];
        let (Region::Loop(own), Some(place)) = (region, &subject.whole) else { return subject.anything() };
        let is_local = place.steps.is_empty() && place.base_var().is_some_and(|var| graph.var(var).param.is_none());
        if !is_local {
            return subject.anything();
        }
        let mut heads = 0;
        for node in graph.nodes.iter().filter(|node| !graph.is_within(node.in_loop, own)) {
            let written = match &node.effect {
                Effect::Set(set) | Effect::Write(set) if set.place == *place => match &set.head {
                    Some(head) => {
                        heads |= subject.bit(head);
                        false
                    }
                    None => true,
                },
                Effect::Set(set) | Effect::Write(set) => set.place.overlaps(place),
                Effect::Unknown { places, .. } => places.iter().any(|other| other.overlaps(place)),
                Effect::Call(site) => site.args.iter().any(|arg| {
                    !arg.is_shared
                        && arg
                            .place
                            .as_ref()
                            .is_some_and(|other| self.aliases.roots(other).iter().any(|root| root.overlaps(place)))
                }),
                _ => false,
            };
            if written {
                return subject.anything();
            }
        }
        if heads == 0 { subject.anything() } else { heads }
    }

    /// The names that the instance can have, and what is known, where control reaches a loop's head from outside.
    pub(super) fn entries(&self, id: LoopId) -> Vec<Entry> {
        let head = self.graph.loop_info(id).head;
        let starts = self.declarations();
        let mut found = Vec::new();
        let mut seen_names: BTreeSet<Vec<Place>> = BTreeSet::new();
        let reaching = self.explore_to(head, &starts);
        for names in reaching {
            if seen_names.insert(names.clone()) {
                found.push(Entry { names });
            }
        }
        if found.is_empty() {
            found.push(Entry { names: vec![self.instance.clone()] });
        }
        found
    }

    /// Where the instance begins to exist: the function's entry, or the nodes that give its variable a value.
    fn declarations(&self) -> Vec<NodeId> {
        let Base::Var(var) = self.instance.base else { return vec![NodeId(0)] };
        if self.graph.var(var).param.is_some() {
            return vec![NodeId(0)];
        }
        let nodes: Vec<NodeId> = self
            .graph
            .node_ids()
            .filter(|id| {
                matches!(&self.graph.node(*id).effect, Effect::Set(set)
                    if set.place.steps.is_empty() && set.place.base_var() == Some(var))
            })
            .collect();
        if nodes.is_empty() { vec![NodeId(0)] } else { nodes }
    }

    /// The names of the instance at a node, over all ways that lead there; conditions are not told apart.
    fn explore_to(&self, target: NodeId, starts: &[NodeId]) -> Vec<Vec<Place>> {
        let mut seen: BTreeSet<(NodeId, Vec<Place>)> = BTreeSet::new();
        let mut open: Vec<(NodeId, Vec<Place>)> = Vec::new();
        for start in starts {
            let names = vec![self.instance.clone()];
            for next in &self.graph.node(*start).next {
                open.push((*next, names.clone()));
            }
            if *start == target {
                return vec![names];
            }
        }
        let mut found = Vec::new();
        while let Some((node, names)) = open.pop() {
            if node == target {
                found.push(names);
                continue;
            }
            if seen.len() > MAX_STATES / 4 || !seen.insert((node, names.clone())) {
                continue;
            }
            let info = self.graph.node(node);
            let all = match &info.effect {
                Effect::Set(set) => vec![self.renamed(&names, set, &|_| None).0],
                Effect::Write(write) => vec![self.renamed(&names, write, &|_| None).0],
                Effect::Call(site) => self.borrowed(&names, site),
                Effect::LoopHead(id) => {
                    let mut all = vec![self.without_items(&names, *id)];
                    if self.covers(*id) {
                        all.push(self.with_items(&all[0], *id));
                    }
                    all
                }
                _ => vec![names],
            };
            for names in all {
                for next in &info.next {
                    open.push((*next, names.clone()));
                }
            }
        }
        found
    }

    /// The names after a value is given to a place, and whether the instance itself is replaced.
    fn renamed(&self, names: &[Place], set: &Assignment, value: &dyn Fn(Var) -> Option<u64>) -> (Vec<Place>, bool) {
        let mut gained: Vec<Place> = Vec::new();
        let mut lost: Vec<Place> = Vec::new();
        if let Some(from) = &set.from {
            for name in names {
                if let Relation::Holds(rest) = from.relate(name, value) {
                    gained.push(set.place.join(&rest));
                    if set.by_move && *from != set.place {
                        lost.push(name.clone());
                    }
                }
            }
        }
        let mut replaced = false;
        let mut kept: Vec<Place> = Vec::new();
        for name in names {
            if lost.contains(name) && !gained.contains(name) {
                continue;
            }
            match set.place.relate(name, value) {
                Relation::Holds(_) if !gained.contains(name) => {
                    if set.rebinds {
                        continue;
                    }
                    replaced = gained.is_empty();
                    kept.push(name.clone());
                }
                _ => kept.push(name.clone()),
            }
        }
        kept.extend(gained);
        kept.sort();
        kept.dedup();
        (kept, replaced)
    }

    /// The names after a call that may give back a borrow; one for each part that it may be.
    fn borrowed(&self, names: &[Place], site: &CallSite) -> Vec<Vec<Place>> {
        let result = Place::var(site.result);
        let base: Vec<Place> = names.iter().filter(|name| name.base != result.base).cloned().collect();
        // Borrows of one part of the result exclude each other; those of several parts are there together.
        let mut all = vec![base.clone()];
        let mut parts: Vec<(&[Projection], Vec<Vec<Place>>)> = Vec::new();
        for target in &site.targets {
            for borrow in self.summaries.returns(*target) {
                let Some(place) = site.args.get(borrow.param).and_then(|arg| arg.place.as_ref()) else { continue };
                let from = place.join(&borrow.steps);
                let part = result.join(&borrow.part);
                let gained: Vec<Place> = base
                    .iter()
                    .filter_map(|name| match from.relate(name, &|_| None) {
                        Relation::Holds(rest) => Some(part.join(&rest)),
                        _ => None,
                    })
                    .collect();
                match parts.iter_mut().find(|(own, _)| *own == borrow.part.as_slice()) {
                    Some((_, ways)) if ways.contains(&gained) => {}
                    Some((_, ways)) => ways.push(gained),
                    None => parts.push((&borrow.part, vec![gained])),
                }
            }
        }
        for (_, ways) in parts {
            let before = std::mem::take(&mut all);
            for names in before {
                for gained in &ways {
                    let mut names = names.clone();
                    names.extend(gained.iter().cloned());
                    names.sort();
                    names.dedup();
                    if !all.contains(&names) && all.len() < 16 {
                        all.push(names);
                    }
                }
            }
        }
        all
    }

    /// The names without those that last for one round of a loop.
    fn without_items(&self, names: &[Place], id: LoopId) -> Vec<Place> {
        let info = self.graph.loop_info(id);
        names
            .iter()
            .filter(|name| {
                let is_item = name.base_var().is_some_and(|var| info.items.iter().any(|(item, _)| *item == var));
                let is_indexed = info.counter.is_some_and(|(counter, _)| {
                    name.steps.iter().any(|step| *step == Projection::Index(IndexKey::Var(counter)))
                });
                (!is_item && !is_indexed) || **name == *self.instance
            })
            .cloned()
            .collect()
    }

    /// The names in the round that is the instance's own.
    fn with_items(&self, names: &[Place], id: LoopId) -> Vec<Place> {
        let info = self.graph.loop_info(id);
        let mut all = names.to_vec();
        for (item, source) in &info.items {
            for name in names {
                if let Some(rest) = element_rest(source, name) {
                    all.push(Place::var(*item).join(&rest));
                }
            }
        }
        if let Some((counter, _)) = info.counter {
            for name in names {
                for (at, step) in name.steps.iter().enumerate() {
                    if matches!(step, Projection::Index(IndexKey::Each | IndexKey::Number(_) | IndexKey::Named(_))) {
                        let mut indexed = name.clone();
                        indexed.steps[at] = Projection::Index(IndexKey::Var(counter));
                        all.push(indexed);
                    }
                }
            }
        }
        all.sort();
        all.dedup();
        all
    }
}

/// What is known where a search begins.
#[derive(Clone, Debug)]
pub(super) struct Entry {
    pub(super) names: Vec<Place>,
}

/// The steps of a name behind an element of a collection; a whole collection is handed out by chunks.
fn element_rest(source: &Place, name: &Place) -> Option<Vec<Projection>> {
    if source.base != name.base || source.steps.len() > name.steps.len() {
        return None;
    }
    let matches = source.steps.iter().zip(&name.steps).all(|(left, right)| match (left, right) {
        (Projection::Index(IndexKey::Each), Projection::Index(_)) => true,
        (left, right) => left == right,
    });
    matches.then(|| name.steps[source.steps.len()..].to_vec())
}

/// Whether a loop's counter is the index of the instance.
fn indexes_instance(aliases: &Aliases, info: &crate::flow::LoopInfo, instance: &Place) -> bool {
    info.indexes.iter().flat_map(|collection| aliases.roots(collection)).any(|root| {
        root.base == instance.base
            && root.steps.len() < instance.steps.len()
            && root.steps[..] == instance.steps[..root.steps.len()]
            && matches!(instance.steps[root.steps.len()], Projection::Index(_))
    })
}

/// Loops that visit each element of the collection that the instance is an element of.
fn covering_loops(graph: &ControlFlowGraph, aliases: &Aliases, instance: &Place) -> BTreeSet<LoopId> {
    let mut found = BTreeSet::new();
    for (number, info) in (0u32..).zip(&graph.loops) {
        let of_items = info
            .items
            .iter()
            .any(|(_, source)| aliases.roots(source).iter().any(|root| element_rest(root, instance).is_some()));
        // A loop that counts to a constant and does not stand for each element is followed round by round.
        let exact = matches!(info.rounds, Rounds::Constant(count) if count <= MAX_ROUNDS)
            && info.counter.is_some_and(|(_, first)| first.is_some())
            && !instance.stands_for_each();
        let of_index = !exact && indexes_instance(aliases, info, instance);
        if (of_items || of_index) && info.rounds != Rounds::Unbounded {
            found.insert(LoopId(number));
        }
    }
    found
}

/// Ways that differ only in what they give back are one.
fn merge(outcomes: BTreeSet<Outcome>) -> Vec<Outcome> {
    let mut merged: Vec<Outcome> = Vec::new();
    for outcome in outcomes {
        let same = merged
            .iter_mut()
            .find(|other| Outcome { returned: 0, ..(*other).clone() } == Outcome { returned: 0, ..outcome.clone() });
        match same {
            Some(other) => other.returned |= outcome.returned,
            None => merged.push(outcome),
        }
    }
    merged
}

impl Run<'_, '_> {
    fn start(&mut self, node: NodeId, entry: Option<&Entry>) {
        let names = entry.map_or_else(|| vec![self.search.instance.clone()], |entry| entry.names.clone());
        let names = self.names.intern(names);
        let all: Vec<u32> = self.tracked.subjects.iter().map(|id| self.search.known_before(self.region, *id)).collect();
        let masks = self.masks.intern(all);
        let rounds = self.rounds.intern(Vec::new());
        let state = State {
            node,
            count: Count::Zero,
            in_sample: false,
            reset: false,
            partly_reset: false,
            direct: false,
            unknown: None,
            skipped_at: None,
            helper_gate: None,
            names,
            masks,
            rounds,
        };
        self.push(state, None);
    }

    fn push(&mut self, state: State, parent: Option<usize>) {
        if self.seen.contains_key(&state) {
            return;
        }
        if self.exploration.states.len() >= MAX_STATES {
            self.exploration.limit = true;
            return;
        }
        let at = self.exploration.states.len();
        self.exploration.states.push(state.clone());
        self.exploration.parents.push(parent);
        self.seen.insert(state, at);
        self.queue.push_back(at);
    }

    fn go(&mut self) {
        while let Some(at) = self.queue.pop_front() {
            let state = self.exploration.states[at].clone();
            self.step(at, &state);
        }
    }

    /// Follows an edge: the way may end with it.
    fn follow(&mut self, at: usize, state: State, to: NodeId) {
        let graph = self.search.graph;
        let mut state = state;
        let ends = matches!(self.region, Region::Loop(id) if to == graph.loop_info(id).head);
        if state.count == Count::Zero
            && state.skipped_at.is_none()
            && self.reach[state.node.0 as usize]
            && (ends || !self.reach[to.0 as usize])
        {
            state.skipped_at = Some(state.node);
        }
        if let Region::Loop(id) = self.region {
            if to == graph.loop_info(id).head {
                self.end(EndKind::Completes, at, &state, returned::ANY);
                // What is known at the end of an iteration is known at the beginning of the next.
                let next = State {
                    node: to,
                    count: Count::Zero,
                    in_sample: false,
                    reset: false,
                    partly_reset: false,
                    direct: false,
                    unknown: None,
                    skipped_at: None,
                    helper_gate: None,
                    ..state
                };
                self.push(next, None);
                return;
            }
            if !graph.is_within(graph.node(to).in_loop, id) {
                self.end(EndKind::Exits, at, &state, returned::ANY);
                return;
            }
        }
        let in_sample = state.in_sample
            && graph
                .loops_around(to)
                .any(|id| self.search.sample_loops.contains(&id) && self.region != Region::Loop(id));
        self.push(State { node: to, in_sample, ..state }, Some(at));
    }

    fn end(&mut self, kind: EndKind, at: usize, state: &State, returned: u8) {
        self.exploration.ends.push(End { kind, state: state.clone(), at, returned });
    }

    fn everywhere(&mut self, at: usize, state: &State) {
        let next = self.search.graph.node(state.node).next.clone();
        for to in next {
            self.follow(at, state.clone(), to);
        }
    }

    fn step(&mut self, at: usize, state: &State) {
        let graph = self.search.graph;
        let node = graph.node(state.node);
        match &node.effect {
            Effect::Nothing | Effect::Mark(_) | Effect::Use { .. } | Effect::GuardStart(_) | Effect::GuardEnd(_) => {
                self.everywhere(at, state)
            }
            Effect::Update(update) if update.law == self.search.law => {
                let next = self.updated(state, &update.place, update.by_guard);
                self.everywhere(at, &next);
            }
            Effect::Update(_) => self.everywhere(at, state),
            Effect::Reset { place, full } => {
                let mut next = state.clone();
                if self.holds(state, place) {
                    next.reset |= *full;
                    next.partly_reset |= !*full;
                }
                self.everywhere(at, &next);
            }
            Effect::Call(site) => self.call(at, state, site),
            Effect::Set(set) => self.assign(at, state, set),
            Effect::Write(write) => self.assign(at, state, write),
            Effect::Unknown { places, cause } => {
                let mut next = state.clone();
                if places.iter().any(|place| self.may_hold(state, place)) {
                    next.unknown = Some(self.cause(cause));
                }
                for place in places {
                    next.masks = self.killed(next.masks, place);
                }
                self.everywhere(at, &next);
            }
            Effect::Branch(test) => self.branch(at, state, test),
            Effect::LoopEnter(id) => {
                let mut rounds = self.rounds.get(state.rounds).clone();
                rounds.retain(|(open, _)| open != id);
                let rounds = self.rounds.intern(rounds);
                self.everywhere(at, &State { rounds, ..state.clone() });
            }
            Effect::LoopHead(id) => self.head(at, state, *id),
            Effect::Fork => {
                if let Some(here) = node.next.first().copied() {
                    self.follow(at, state.clone(), here);
                }
            }
            Effect::Return(value) => {
                let heads = match (&value.head, value.same_as) {
                    (Some(head), _) => returned::bit(head),
                    (None, Some(var)) => self.heads_of(state, var),
                    (None, None) => returned::ANY,
                };
                let kind = if self.region == Region::Function { EndKind::Completes } else { EndKind::Exits };
                self.end(kind, at, state, heads);
            }
            Effect::Diverge | Effect::End => {}
        }
    }

    /// What is known of the heads of a variable.
    fn heads_of(&self, state: &State, var: Var) -> u8 {
        let graph = self.search.graph;
        let place = Place::var(var);
        let tracked =
            self.tracked.subjects.iter().position(|id| graph.subjects[id.0 as usize].whole.as_ref() == Some(&place));
        let Some(tracked) = tracked else { return returned::ANY };
        let subject = &graph.subjects[self.tracked.subjects[tracked].0 as usize];
        let mask = self.masks.get(state.masks)[tracked];
        let mut heads = 0;
        for (number, head) in subject.heads.iter().enumerate() {
            if mask & (1 << number) != 0 {
                heads |= returned::bit(head);
            }
        }
        if mask & OTHER_HEADS != 0 {
            heads |= returned::OTHER;
        }
        heads
    }

    fn cause(&mut self, cause: &Cause) -> u16 {
        let at = match self.exploration.causes.iter().position(|known| known == cause) {
            Some(at) => at,
            None => {
                self.exploration.causes.push(cause.clone());
                self.exploration.causes.len() - 1
            }
        };
        u16::try_from(at).unwrap_or(u16::MAX)
    }

    /// The number that a counter has in the round at hand.
    fn number(&self, state: &State, var: Var) -> Option<u64> {
        let rounds = self.rounds.get(state.rounds);
        rounds.iter().find_map(|(id, done)| {
            let (counter, first) = self.search.graph.loop_info(*id).counter?;
            (counter == var && *done > 0).then_some(first? + done - 1)
        })
    }

    fn relations(&self, state: &State, place: &Place) -> Vec<Relation> {
        let names = self.names.get(state.names);
        names.iter().map(|name| place.relate(name, &|var| self.number(state, var))).collect()
    }

    /// As [`Self::relations`], where an element that stands for each is the one that the instance is.
    fn relations_to_each(&self, state: &State, place: &Place) -> Vec<Relation> {
        if !place.stands_for_each() {
            return self.relations(state, place);
        }
        let names = self.names.get(state.names);
        let own = |name: &Place| {
            let mut place = place.clone();
            for (step, of_name) in place.steps.iter_mut().zip(&name.steps) {
                if *step == Projection::Index(IndexKey::Each) && matches!(of_name, Projection::Index(_)) {
                    step.clone_from(of_name);
                }
            }
            place.relate(name, &|var| self.number(state, var))
        };
        names.iter().map(own).collect()
    }

    fn holds(&self, state: &State, place: &Place) -> bool {
        self.relations(state, place).iter().any(|relation| matches!(relation, Relation::Holds(_)))
    }

    fn may_hold(&self, state: &State, place: &Place) -> bool {
        self.relations(state, place)
            .iter()
            .any(|relation| matches!(relation, Relation::Holds(_) | Relation::MayHold(..)))
    }

    /// The state after a law ran at a place.
    fn updated(&mut self, state: &State, place: &Place, by_guard: bool) -> State {
        let mut next = state.clone();
        let relations = self.relations(state, place);
        let exact = relations.iter().any(|relation| matches!(relation, Relation::Holds(rest) if rest.is_empty()));
        if exact {
            self.add(&mut next, Count::One);
            next.direct |= !by_guard;
            return next;
        }
        let doubt = relations.into_iter().find_map(|relation| match relation {
            Relation::MayHold(text, rest) if rest.is_empty() => Some(text),
            _ => None,
        });
        if let Some(text) = doubt
            && !self.is_other_round(state, place)
        {
            let cause = Cause::Index(format!("{}", self.spell(place, &text)));
            next.unknown = Some(self.cause(&cause));
        }
        next
    }

    fn spell(&self, place: &Place, _text: &str) -> String {
        self.search.graph.place_name(self.search.program.index, place)
    }

    /// Whether a place is indexed with the counter of a loop that visits each element: in a round that is not the instance's own
    /// it names another element.
    fn is_other_round(&self, state: &State, place: &Place) -> bool {
        let graph = self.search.graph;
        place.steps.iter().any(|step| match step {
            Projection::Index(IndexKey::Var(var)) => graph.loops_around(state.node).any(|id| {
                self.search.covers(id) && graph.loop_info(id).counter.is_some_and(|(counter, _)| counter == *var)
            }),
            _ => false,
        })
    }

    /// Adds to the count; updates in a loop that is a cycle of its own count once for all its rounds.
    fn add(&self, state: &mut State, count: Count) {
        let graph = self.search.graph;
        let in_sample = graph
            .loops_around(state.node)
            .take_while(|id| self.region != Region::Loop(*id))
            .any(|id| self.search.sample_loops.contains(&id));
        if in_sample && count != Count::Zero {
            if state.in_sample && state.count == Count::PerSample {
                return;
            }
            state.in_sample = true;
            state.count = state.count.then(Count::PerSample);
            return;
        }
        state.count = state.count.then(count);
    }

    fn call(&mut self, at: usize, state: &State, site: &CallSite) {
        let search = self.search;
        let mut masks = state.masks;
        for target in &site.targets {
            let Some(summary) = search.summaries.get(*target) else { continue };
            for given in &summary.writes {
                if let Some(place) = place_of(given, site) {
                    masks = self.killed(masks, &place);
                }
            }
        }
        masks = self.killed(masks, &Place::var(site.result));
        let state = State { masks, ..state.clone() };
        let mut after: Vec<State> = Vec::new();
        for target in &site.targets {
            let Some(summary) = search.summaries.get(*target) else {
                after.push(state.clone());
                continue;
            };
            let mut states = vec![(state.clone(), returned::ANY)];
            let mut applied = false;
            for (given, outcomes) in &summary.outcomes {
                // A law that hands on to another one of the same filter is one update.
                if site.is_law && given.is_self() {
                    continue;
                }
                let Some(place) = place_of(given, site) else { continue };
                let relations = self.relations_to_each(&state, &place);
                let exact =
                    relations.iter().any(|relation| matches!(relation, Relation::Holds(rest) if rest.is_empty()));
                let owner =
                    relations.iter().any(|relation| matches!(relation, Relation::Holds(rest) if !rest.is_empty()));
                let doubt = relations.iter().find_map(|relation| match relation {
                    Relation::MayHold(text, rest) if rest.is_empty() => Some(text.clone()),
                    _ => None,
                });
                if exact {
                    applied = true;
                    states = self.apply(&states, outcomes);
                } else if owner {
                    states = self.apply_to_owner(&states, outcomes);
                } else if let Some(text) = doubt
                    && outcomes.iter().any(|outcome| outcome.count != Count::Zero)
                    && !self.is_other_round(&state, &place)
                {
                    let cause = Cause::Index(self.spell(&place, &text));
                    let cause = self.cause(&cause);
                    for (state, _) in &mut states {
                        state.unknown = Some(cause);
                    }
                }
            }
            if !applied && summary.heads != 0 {
                for (_, heads) in &mut states {
                    *heads &= summary.heads;
                }
            }
            for (next, heads) in states {
                let masks = self.with_heads(next.masks, site.result, heads);
                after.push(State { masks, ..next });
            }
        }
        if site.targets.is_empty() {
            after.push(state);
        }
        for next in after {
            let names = self.names.get(next.names).clone();
            for names in search.borrowed(&names, site) {
                let names = self.names.intern(names);
                self.everywhere(at, &State { names, ..next.clone() });
            }
        }
    }

    fn apply(&mut self, states: &[(State, u8)], outcomes: &[Outcome]) -> Vec<(State, u8)> {
        let mut after = Vec::new();
        for (state, heads) in states {
            for outcome in outcomes {
                let mut next = state.clone();
                if outcome.count == Count::PerSample {
                    next.count = next.count.then(Count::PerSample);
                } else {
                    self.add(&mut next, outcome.count);
                    if outcome.count == Count::Many {
                        next.count = Count::Many;
                    }
                }
                next.reset |= outcome.reset;
                next.partly_reset |= outcome.partly_reset;
                next.direct |= outcome.direct && outcome.count != Count::Zero;
                if let Some(cause) = &outcome.unknown {
                    next.unknown = Some(self.cause(cause));
                }
                if outcome.count == Count::Zero {
                    next.helper_gate = outcome.gate;
                }
                after.push((next, heads & outcome.returned));
            }
        }
        after.retain(|(_, heads)| *heads != 0);
        after
    }

    /// What happens to the owner of the instance: a reset, or something unknown.
    fn apply_to_owner(&mut self, states: &[(State, u8)], outcomes: &[Outcome]) -> Vec<(State, u8)> {
        let mut after: Vec<(State, u8)> = Vec::new();
        for (state, heads) in states {
            for outcome in outcomes {
                let mut next = state.clone();
                next.reset |= outcome.reset;
                if let Some(cause) = &outcome.unknown {
                    next.unknown = Some(self.cause(cause));
                }
                let entry = (next, heads & outcome.returned);
                if entry.1 != 0 && !after.contains(&entry) {
                    after.push(entry);
                }
            }
        }
        after
    }

    /// Nothing is known any more of what reads a place.
    fn killed(&mut self, masks: u32, place: &Place) -> u32 {
        let graph = self.search.graph;
        let mut all = self.masks.get(masks).clone();
        let mut changed = false;
        for (at, id) in self.tracked.subjects.iter().enumerate() {
            let subject = &graph.subjects[id.0 as usize];
            if subject.reads.iter().any(|read| read.overlaps(place)) {
                all[at] = subject.anything();
                changed = true;
            }
        }
        if changed { self.masks.intern(all) } else { masks }
    }

    /// The result of a call has one of these heads.
    fn with_heads(&mut self, masks: u32, result: Var, heads: u8) -> u32 {
        let graph = self.search.graph;
        let place = Place::var(result);
        let Some(at) =
            self.tracked.subjects.iter().position(|id| graph.subjects[id.0 as usize].whole.as_ref() == Some(&place))
        else {
            return masks;
        };
        let subject = &graph.subjects[self.tracked.subjects[at].0 as usize];
        let mut mask = if heads & returned::OTHER != 0 { OTHER_HEADS } else { 0 };
        for (number, head) in subject.heads.iter().enumerate() {
            if heads & returned::bit(head) != 0 {
                mask |= 1 << number;
            }
        }
        let mut all = self.masks.get(masks).clone();
        all[at] = mask & subject.anything();
        self.masks.intern(all)
    }

    fn assign(&mut self, at: usize, state: &State, set: &Assignment) {
        let graph = self.search.graph;
        let names = self.names.get(state.names).clone();
        let (renamed, replaced) = self.search.renamed(&names, set, &|var| self.number(state, var));
        let mut next = state.clone();
        next.names = self.names.intern(renamed);
        next.reset |= replaced;
        if !set.rebinds && !replaced && names.iter().any(|name| set.place.relate(name, &|_| None) == Relation::Part) {
            next.partly_reset = true;
        }
        // A copy of a variable has its heads.
        let copied = set.same_as.and_then(|var| {
            let from = self
                .tracked
                .subjects
                .iter()
                .position(|id| graph.subjects[id.0 as usize].whole.as_ref() == Some(&Place::var(var)))?;
            Some((from, self.masks.get(state.masks)[from]))
        });
        next.masks = self.killed(next.masks, &set.place);
        let target = self
            .tracked
            .subjects
            .iter()
            .position(|id| graph.subjects[id.0 as usize].whole.as_ref() == Some(&set.place));
        if let Some(target) = target {
            let subject = &graph.subjects[self.tracked.subjects[target].0 as usize];
            let mask = match (&set.head, copied) {
                (Some(head), _) => Some(subject.bit(head)),
                (None, Some((from, mask))) => {
                    let source = &graph.subjects[self.tracked.subjects[from].0 as usize];
                    let mut bits = if mask & OTHER_HEADS != 0 { OTHER_HEADS } else { 0 };
                    for (number, head) in source.heads.iter().enumerate() {
                        if mask & (1 << number) != 0 {
                            bits |= subject.bit(head);
                        }
                    }
                    // Heads that only the copy tells apart are among the source's others.
                    if mask & OTHER_HEADS != 0 {
                        for (number, head) in subject.heads.iter().enumerate() {
                            if !source.heads.contains(head) {
                                bits |= 1 << number;
                            }
                        }
                    }
                    Some(bits & subject.anything())
                }
                (None, None) => None,
            };
            if let Some(mask) = mask {
                let mut all = self.masks.get(next.masks).clone();
                all[target] = mask;
                next.masks = self.masks.intern(all);
            }
        }
        self.everywhere(at, &next);
    }

    fn branch(&mut self, at: usize, state: &State, test: &Test) {
        let next = self.search.graph.node(state.node).next.clone();
        let tracked = test.subject.and_then(|subject| self.tracked.subjects.iter().position(|id| *id == subject));
        for (number, to) in next.into_iter().enumerate() {
            let heads = if number == 0 { test.holds } else { test.fails };
            let mut after = state.clone();
            if let Some(tracked) = tracked {
                let mut all = self.masks.get(state.masks).clone();
                all[tracked] &= heads;
                if all[tracked] == 0 {
                    continue;
                }
                after.masks = self.masks.intern(all);
            }
            self.follow(at, after, to);
        }
    }

    /// Another round of a loop, or no more.
    fn head(&mut self, at: usize, state: &State, id: LoopId) {
        let graph = self.search.graph;
        let info = graph.loop_info(id);
        let next = graph.node(state.node).next.clone();
        let [round, rest @ ..] = next.as_slice() else { return };
        let names = self.names.get(state.names).clone();
        let plain = self.search.without_items(&names, id);
        let plain_id = self.names.intern(plain.clone());
        let state = State { names: plain_id, ..state.clone() };
        let mut rounds = self.rounds.get(state.rounds).clone();
        let done = rounds.iter().find(|(open, _)| *open == id).map_or(0, |(_, done)| *done);
        let is_region = self.region == Region::Loop(id);
        if self.search.covers(id) && !is_region {
            let own = self.search.with_items(&plain, id);
            let own = self.names.intern(own);
            if done == 0 {
                rounds.push((id, 1));
                let visited = self.rounds.intern(rounds);
                self.follow(at, State { names: own, rounds: visited, ..state.clone() }, *round);
            }
            self.follow(at, state.clone(), *round);
            if done > 0 || info.passes_over {
                for to in rest {
                    self.follow(at, state.clone(), *to);
                }
            }
            return;
        }
        if let Rounds::Constant(count) = info.rounds
            && !is_region
        {
            let last = count.min(MAX_ROUNDS);
            if done < last || (count > MAX_ROUNDS && done == last) {
                let now = (done + 1).min(last);
                rounds.retain(|(open, _)| *open != id);
                rounds.push((id, now));
                let more = self.rounds.intern(rounds);
                let mut after = State { rounds: more, ..state.clone() };
                if let Some((counter, first)) = info.counter {
                    after.masks = self.killed(after.masks, &Place::var(counter));
                    if count <= MAX_ROUNDS
                        && let Some(first) = first
                    {
                        after.masks = self.with_number(after.masks, counter, first + now - 1);
                    }
                }
                self.follow(at, after, *round);
            }
            if done >= last || (info.passes_over) {
                for to in rest {
                    self.follow(at, state.clone(), *to);
                }
            }
            return;
        }
        let mut after = state.clone();
        if let Some((counter, _)) = info.counter {
            after.masks = self.killed(after.masks, &Place::var(counter));
        }
        self.follow(at, after, *round);
        for to in rest {
            self.follow(at, state.clone(), *to);
        }
    }

    /// A counter has a number.
    fn with_number(&mut self, masks: u32, counter: Var, number: u64) -> u32 {
        let graph = self.search.graph;
        let place = Place::var(counter);
        let Some(at) =
            self.tracked.subjects.iter().position(|id| graph.subjects[id.0 as usize].whole.as_ref() == Some(&place))
        else {
            return masks;
        };
        let subject = &graph.subjects[self.tracked.subjects[at].0 as usize];
        let mut all = self.masks.get(masks).clone();
        all[at] = subject.bit(&number.to_string());
        self.masks.intern(all)
    }
}
