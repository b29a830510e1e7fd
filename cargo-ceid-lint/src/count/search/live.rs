//! What nothing behind a node asks for any more tells no ways apart: conditions before they change, and names that are out of scope.

use std::sync::Arc;

use rustc_hash::FxHashMap;

use super::run::Run;
use super::{Search, State};
use crate::flow::{Base, CallSite, ControlFlowGraph, Effect, LoopId, NodeId, Place, SubjectId, Var};

/// How many states a search may have before it forgets what is asked for no more: most searches have fewer.
pub(super) const MANY_STATES: usize = 4_000;

/// What is still needed at each node.
pub(super) struct Needed {
    /// The tracked subjects, by their bits.
    subjects: Vec<u32>,
    /// The loops in whose rounds variables are declared, where nothing outside speaks of them.
    scopes: FxHashMap<Var, LoopId>,
}

/// Whether a node lies in a round of a loop. What a round has declared is over at the head.
fn is_inside(graph: &ControlFlowGraph, node: NodeId, id: LoopId) -> bool {
    node != graph.loop_info(id).head && graph.is_within(graph.node(node).in_loop, id)
}

impl Search<'_> {
    /// The loops in whose rounds variables are declared, but for those that something outside speaks of, as what a `break` gives.
    fn scopes(&self) -> FxHashMap<Var, LoopId> {
        let graph = self.graph;
        // A guard may hold what it is given until it is dropped.
        if !graph.guards.is_empty() {
            return FxHashMap::default();
        }
        let vars = (0u32..).map(Var).zip(&graph.vars);
        let mut scopes: FxHashMap<Var, LoopId> = vars.filter_map(|(var, info)| Some((var, info.in_loop?))).collect();
        for node in graph.node_ids() {
            let mut speak_of = |place: &Place| {
                let var = place.base_var();
                if let Some((var, id)) = var.and_then(|var| Some((var, *scopes.get(&var)?)))
                    && !is_inside(graph, node, id)
                {
                    scopes.remove(&var);
                }
            };
            match &graph.node(node).effect {
                Effect::Update(update) => {
                    [&update.place].into_iter().chain(&update.given).for_each(speak_of);
                }
                Effect::Advance(advance) => [&advance.before, &advance.after].into_iter().for_each(speak_of),
                Effect::Reset { place, .. } | Effect::Use { place } => speak_of(place),
                Effect::Unknown { places, .. } => places.iter().for_each(speak_of),
                Effect::Set(set) | Effect::Write(set) => {
                    let of_value = set.from.iter().chain([&set.place]);
                    of_value.for_each(&mut speak_of);
                    set.same_as.into_iter().for_each(|var| speak_of(&Place::var(var)));
                }
                Effect::Call(site) => {
                    speak_of(&Place::var(site.result));
                    site.args.iter().flat_map(|arg| arg.place.iter().chain(&arg.value_of)).for_each(&mut speak_of);
                }
                Effect::Return(value) => {
                    value.place.iter().for_each(&mut speak_of);
                    value.same_as.into_iter().for_each(|var| speak_of(&Place::var(var)));
                }
                Effect::LoopHead(id) | Effect::LoopEnter(id) => {
                    let info = graph.loop_info(*id);
                    info.items.iter().map(|(_, source)| source).chain(&info.indexes).for_each(speak_of);
                }
                _ => {}
            }
        }
        scopes
    }

    /// Which nodes may still need what was known of a subject before them, in this iteration or a later one.
    fn needing(&self, id: SubjectId) -> Arc<Vec<bool>> {
        self.dependence.needing(id, || {
            let graph = self.graph;
            let changing = self.writers_of(id);
            // What a call changes it may have asked for before; only its result is surely a new one.
            let forgets = |node: NodeId| match &graph.node(node).effect {
                Effect::Set(_) | Effect::Write(_) => changing.binary_search(&node).is_ok(),
                Effect::Call(site) => {
                    self.read_by(id).is_changed_with(&Place::var(site.result)) && !self.may_ask(site, id)
                }
                _ => false,
            };
            let returns = || graph.node_ids().filter(|node| matches!(graph.node(*node).effect, Effect::Return(_)));
            let mut needing = vec![false; graph.nodes.len()];
            let mut open: Vec<NodeId> = graph.node_ids().filter(|node| self.asks_for(*node, id)).collect();
            while let Some(node) = open.pop() {
                if std::mem::replace(&mut needing[node.0 as usize], true) {
                    continue;
                }
                open.extend(self.dependence.before(node).iter().copied().filter(|before| !forgets(*before)));
                if node == NodeId(0) {
                    // A function that is a cycle is called again.
                    open.extend(returns());
                }
            }
            needing
        })
    }

    /// Whether a node asks what a subject is, or hands that on.
    fn asks_for(&self, node: NodeId, id: SubjectId) -> bool {
        let graph = self.graph;
        let whole = graph.subjects[id.0 as usize].whole.as_ref();
        let is_whole = |place: &Place| whole == Some(place);
        match &graph.node(node).effect {
            Effect::Branch(test) => test.subject.is_some_and(|asked| {
                let equals = graph.subjects[asked.0 as usize].equals();
                asked == id || equals.is_some_and(|(left, right)| is_whole(left) || is_whole(right))
            }),
            Effect::Set(_) | Effect::Write(_) => graph.copied(node).is_some_and(|place| is_whole(&place)),
            Effect::Return(value) => value.same_as.is_some_and(|var| is_whole(&Place::var(var))),
            Effect::Call(site) => self.may_ask(site, id),
            _ => false,
        }
    }

    /// Whether what is called may ask for a subject.
    fn may_ask(&self, site: &CallSite, id: SubjectId) -> bool {
        let reads = self.read_by(id);
        let whole = self.graph.subjects[id.0 as usize].whole.as_ref();
        let is_static = whole.is_some_and(|place| matches!(place.base, Base::Static(_)));
        let leads_there =
            |place: &Place| self.aliases.shared_roots(place).iter().any(|root| reads.is_changed_with(root));
        let mut given = site.args.iter().flat_map(|arg| arg.place.iter().chain(&arg.value_of));
        !site.targets.is_empty() && (is_static || given.any(|place| reads.is_changed_with(place) || leads_there(place)))
    }
}

impl Run<'_, '_> {
    /// From now on, states forget what is asked for no more.
    pub(super) fn forget_what_nothing_asks(&mut self) {
        let (search, told) = (self.search, self.tracked.subjects.len());
        let is_kept = |at: usize, id: SubjectId| {
            told > u32::BITS as usize
                || self.is_told(at)
                || self.mode.is_some_and(|mode| mode.subject == id)
                // What a counter's number is stands for the round as well.
                || search.graph.loops.iter().any(|info| {
                    let whole = search.graph.subjects[id.0 as usize].whole.as_ref();
                    info.counter.is_some_and(|(counter, _)| whole == Some(&Place::var(counter)))
                })
        };
        let mut needed = vec![0; search.graph.nodes.len()];
        for (at, id) in self.tracked.subjects.iter().enumerate().take(u32::BITS as usize) {
            let needing = (!is_kept(at, *id)).then(|| search.needing(*id));
            for (node, bits) in needed.iter_mut().enumerate() {
                *bits |= u32::from(needing.as_ref().is_none_or(|needing| needing[node])) << at;
            }
        }
        self.needed = Some(Needed { subjects: needed, scopes: search.scopes() });
    }

    /// A state without what nothing at a node asks for any more.
    pub(super) fn still_known(&mut self, state: State, at: NodeId) -> State {
        let names = self.still_named(state.names, at);
        let masks = self.still_needed(state.masks, at);
        let rounds = self.still_open(state.rounds, at);
        State { names, masks, rounds, ..state }
    }

    /// The names that can still be meant at a node.
    fn still_named(&mut self, names: u32, at: NodeId) -> u32 {
        let (search, Some(needed)) = (self.search, &self.needed) else { return names };
        let is_over = |name: &&Place| {
            let scope = name.base_var().and_then(|var| needed.scopes.get(&var));
            *name != search.instance && scope.is_some_and(|id| !is_inside(search.graph, at, *id))
        };
        let known = self.names.get(names);
        let over = known.iter().filter(is_over).count();
        // One that is in nothing else has gone with it.
        if over == 0 || over == known.len() {
            return names;
        }
        let left = known.iter().filter(|name| !is_over(name)).cloned().collect();
        self.names.intern(left)
    }

    /// What is still to be known of conditions at a node.
    fn still_needed(&mut self, masks: u32, at: NodeId) -> u32 {
        let Some(needed) = self.needed.as_ref().map(|needed| needed.subjects[at.0 as usize]) else { return masks };
        if let Some(known) = self.reduced.get(&(masks, needed)) {
            return *known;
        }
        let mut all = self.masks.get(masks).clone();
        for (at, id) in self.tracked.subjects.iter().enumerate().take(u32::BITS as usize) {
            if needed & (1 << at) == 0 {
                all[at] = self.search.graph.subjects[id.0 as usize].anything();
            }
        }
        let reduced = self.masks.intern(all);
        self.reduced.insert((masks, needed), reduced);
        reduced
    }
}
