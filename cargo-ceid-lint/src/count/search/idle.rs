//! Parts of the code in which nothing happens that tells ways apart: once there are many states, a way passes each in one step, and
//! those that come to an end get their nodes back.

use std::collections::{BTreeSet, VecDeque};

use rustc_hash::{FxHashMap, FxHashSet};

use super::run::Run;
use super::{Region, Search, Start, State};
use crate::flow::{CallSite, Effect, LoopId, NodeId, Place, SubjectId, Var};

/// How many states a search may have before it looks for such parts: most searches have fewer.
pub(super) const SOME_STATES: usize = 400;

/// Where such parts lie.
pub(super) struct Idle {
    /// Whether nothing happens at a node that tells ways apart.
    nodes: Vec<bool>,
    /// The nodes at which such a part begins, as far as they were asked for: where it ends, and how many nodes lie between.
    parts: FxHashMap<NodeId, Option<(NodeId, u32)>>,
}

/// The places that may have to do with the instance, whatever it is called there.
struct Kin<'s, 'a> {
    search: &'s Search<'a>,
    /// Those that begin where the instance does, or hold it from the beginning on.
    places: Vec<Place>,
    /// Variables that were given one of them.
    vars: FxHashSet<Var>,
}

impl<'s, 'a> Kin<'s, 'a> {
    fn of(search: &'s Search<'a>, known: Vec<Place>) -> Self {
        let mut kin = Self { search, places: known, vars: FxHashSet::default() };
        kin.places.push(search.instance.clone());
        kin.places.extend_from_slice(search.homes());
        while kin.spreads() {}
        kin
    }

    fn has(&self, place: &Place) -> bool {
        let is_one = |place: &Place| {
            place.base_var().is_some_and(|var| self.vars.contains(&var))
                || self.places.iter().any(|own| own.overlaps(place))
        };
        is_one(place) || self.search.aliases.shared_roots(place).iter().any(is_one)
    }

    /// Adds what is given one of them. Answers whether there was anything new.
    fn spreads(&mut self) -> bool {
        let graph = self.search.graph;
        let mut given: Vec<&Place> = Vec::new();
        let mut bound: Vec<Var> = Vec::new();
        for node in &graph.nodes {
            match &node.effect {
                Effect::Set(set) | Effect::Write(set) if set.from.as_ref().is_some_and(|from| self.has(from)) => {
                    given.push(&set.place);
                }
                Effect::Advance(advance) if self.has(&advance.before) => given.push(&advance.after),
                Effect::Call(site) if self.has_argument(site) => bound.push(site.result),
                _ => {}
            }
        }
        for info in &graph.loops {
            bound.extend(info.items.iter().filter(|(_, source)| self.has(source)).map(|(item, _)| *item));
        }
        let before = (self.places.len(), self.vars.len());
        for place in given {
            match place.base_var().filter(|var| self.search.instance.base_var() != Some(*var)) {
                Some(var) => bound.push(var),
                None if self.places.contains(place) => {}
                None => self.places.push(place.clone()),
            }
        }
        self.vars.extend(bound);
        before != (self.places.len(), self.vars.len())
    }

    fn has_argument(&self, site: &CallSite) -> bool {
        let given = site.args.iter().flat_map(|arg| arg.place.iter().chain(&arg.value_of));
        given.into_iter().any(|place| self.has(place))
    }
}

impl Run<'_, '_> {
    /// From now on, ways pass parts of the code in which nothing happens to the instance, nor to what is known of conditions.
    pub(super) fn find_idle_parts(&mut self, starts: &[Start]) {
        let search = self.search;
        let mut known: Vec<Place> =
            starts.iter().flat_map(|(_, entry)| entry).flat_map(|it| it.names.clone()).collect();
        known.extend(self.of_element.iter().map(|own| own.place().clone()));
        let kin = Kin::of(search, known);
        let mut told: BTreeSet<SubjectId> = self.tracked.subjects.iter().copied().collect();
        told.extend(self.untracked().subjects());
        told.extend(self.of_element.iter().flat_map(|own| own.subjects()));
        told.extend(self.mode.map(|mode| mode.subject));
        let mut concerned = vec![false; search.graph.nodes.len()];
        for id in &told {
            let (writers, askers) = (search.writers_of(*id), search.askers(*id));
            let given = [&search.dependence.assigned, &search.dependence.overwritten].map(|all| all.get(id));
            for node in writers.iter().chain(&*askers).chain(given.into_iter().flatten().flatten()) {
                concerned[node.0 as usize] = true;
            }
        }
        let is_idle = |node: NodeId| {
            !concerned[node.0 as usize] && search.graph.node(node).debug_only.is_none() && self.does_nothing(&kin, node)
        };
        let nodes = search.graph.node_ids().map(is_idle).collect();
        self.idle = Some(Idle { nodes, parts: FxHashMap::default() });
    }

    /// Whether a node does nothing to the instance, whatever is known of conditions.
    fn does_nothing(&self, kin: &Kin<'_, '_>, node: NodeId) -> bool {
        let search = self.search;
        match &search.graph.node(node).effect {
            Effect::Nothing
            | Effect::Mark(_)
            | Effect::Use { .. }
            | Effect::GuardStart(_)
            | Effect::GuardEnd(_)
            | Effect::Diverge
            | Effect::End => true,
            Effect::Update(update) => !kin.has(&update.place) && !update.given.as_ref().is_some_and(|it| kin.has(it)),
            Effect::Advance(advance) => !kin.has(&advance.before) && !kin.has(&advance.after),
            Effect::Reset { place, .. } => !kin.has(place),
            Effect::Set(set) | Effect::Write(set) => {
                !kin.has(&set.place) && !set.from.as_ref().is_some_and(|from| kin.has(from))
            }
            Effect::Unknown { places, .. } => !places.iter().any(|place| kin.has(place)),
            Effect::Call(site) => {
                let called = search.called(site);
                let goes_on = site.targets.is_empty() || !called.effects.is_empty();
                goes_on && called.effects.iter().all(|effect| effect.outcomes.is_empty()) && !kin.has_argument(site)
            }
            Effect::Branch(test) => {
                test.about.constant.is_none() && (0..2).all(|edge| !search.lacks_filter(self.region, node, edge))
            }
            Effect::LoopEnter(id) | Effect::LoopHead(id) => {
                let info = search.graph.loop_info(*id);
                !search.covers(*id)
                    && !self.own.contains(id)
                    && !search.sample_loops.contains(id)
                    && !info.items.iter().any(|(_, source)| kin.has(source))
            }
            Effect::Fork | Effect::Return(_) => false,
        }
    }

    /// Where a way goes on that comes to a node, and how many nodes it has passed until then.
    pub(super) fn past_idle(&mut self, to: NodeId) -> (NodeId, u32) {
        let (mut at, mut passed) = (to, 0);
        while let Some((end, nodes)) = self.idle_part(at) {
            (at, passed) = (end, passed + nodes);
        }
        (at, passed)
    }

    /// Where the part ends that begins at a node, and how many nodes lie between.
    fn idle_part(&mut self, begin: NodeId) -> Option<(NodeId, u32)> {
        let idle = self.idle.as_ref()?;
        if let Some(known) = idle.parts.get(&begin) {
            return *known;
        }
        let found =
            self.shortest_through(begin).map(|(end, nodes)| (end, u32::try_from(nodes.len()).unwrap_or(u32::MAX)));
        self.idle.as_mut()?.parts.insert(begin, found);
        found
    }

    /// Where the part ends that begins at a node, with the shortest way through it.
    fn shortest_through(&self, begin: NodeId) -> Option<(NodeId, Vec<NodeId>)> {
        let (graph, idle) = (self.search.graph, self.idle.as_ref()?);
        let own = graph.node(begin);
        let end = match &own.effect {
            Effect::LoopHead(_) => return None,
            Effect::LoopEnter(id) => self.search.dependence.after(graph.loop_info(*id).head)?,
            _ => self.search.dependence.after(begin)?,
        };
        let is_around = |id: LoopId| own.in_loop.is_some_and(|around| graph.is_within(Some(around), id));
        let is_inside = |node: NodeId| {
            let is_head = matches!(graph.node(node).effect, Effect::LoopHead(id) if is_around(id));
            let is_within = own.in_loop.is_none_or(|around| graph.is_within(graph.node(node).in_loop, around));
            !is_head && is_within
        };
        if graph.node(end).in_loop != own.in_loop || !is_inside(end) || self.region_ends_at(end) {
            return None;
        }
        let mut before: FxHashMap<NodeId, NodeId> = FxHashMap::default();
        let mut seen: FxHashSet<NodeId> = FxHashSet::from_iter([begin]);
        let mut open: VecDeque<NodeId> = VecDeque::from([begin]);
        while let Some(node) = open.pop_front() {
            if !idle.nodes[node.0 as usize] || !is_inside(node) {
                return None;
            }
            for next in &graph.node(node).next {
                if seen.insert(*next) {
                    before.insert(*next, node);
                    if *next != end {
                        open.push_back(*next);
                    }
                }
            }
        }
        let mut nodes: Vec<NodeId> =
            std::iter::successors(before.get(&end), |node| before.get(*node)).copied().collect();
        nodes.reverse();
        Some((end, nodes))
    }

    fn region_ends_at(&self, node: NodeId) -> bool {
        matches!(self.region, Region::Loop(id) if self.search.graph.loop_info(id).head == node)
    }

    /// Gives the ways that have come to an end the nodes that they have passed.
    pub(super) fn unfold(&mut self) {
        let ends: Vec<usize> = self.exploration.ends.iter().map(|end| end.at).collect();
        let mut seen = FxHashSet::default();
        for end in ends {
            let mut at = end;
            while seen.insert(at) {
                let Some(parent) = self.exploration.parent(at) else { break };
                if let Some(first) = self.passages.remove(&at) {
                    self.unfold_one(at, parent, first);
                }
                at = parent;
            }
        }
    }

    fn unfold_one(&mut self, at: usize, mut parent: usize, first: NodeId) {
        let state = self.exploration.states[at].clone();
        let mut begin = first;
        while begin != state.node {
            let Some((end, nodes)) = self.shortest_through(begin) else { return };
            for node in nodes {
                parent = self.exploration.add(State { node, ..state.clone() }, Some(parent));
            }
            begin = end;
        }
        self.exploration.set_parent(at, parent);
    }
}
