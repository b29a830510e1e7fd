//! Which branches matter for an instance: those on which something that happens to it depends. The others are not told apart.

use std::cell::{OnceCell, RefCell};
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use rustc_hash::FxHashMap;

use super::aliases::Aliases;
use super::search::ByOtherNames;
use crate::flow::{Base, ControlFlowGraph, Effect, LoopId, NodeId, Place, SubjectId};

/// Which nodes each branch decides over, and what else all searches of a graph ask of it.
#[derive(Debug)]
pub(super) struct ControlDependence {
    /// For each node the branches it depends on.
    branches: Vec<Vec<u32>>,
    /// For each node those that it follows.
    before: Vec<Vec<NodeId>>,
    /// The nodes that give a subject a head that is known.
    pub(super) assigned: BTreeMap<SubjectId, Vec<NodeId>>,
    /// The nodes that give a subject any head.
    pub(super) overwritten: BTreeMap<SubjectId, Vec<NodeId>>,
    /// The branches on a subject.
    asking: BTreeMap<SubjectId, Vec<NodeId>>,
    /// The heads with which a subject that never changes comes to a node, as far as it was asked: it is the same for all filters.
    arriving: RefCell<FxHashMap<(NodeId, SubjectId), u32>>,
    /// The nodes that may need what is known of a subject, as far as it was asked.
    needing: RefCell<FxHashMap<SubjectId, Arc<Vec<bool>>>>,
    /// The nodes that may change what a subject reads, as far as it was asked.
    writing: RefCell<FxHashMap<SubjectId, Arc<Vec<NodeId>>>>,
    /// The heads that a subject can have where a loop begins, as far as it was asked.
    before_loop: RefCell<FxHashMap<(LoopId, SubjectId), u32>>,
    /// The nodes that may change what a subject reads by a name that is not known for one of the same cell.
    by_other_names: OnceCell<ByOtherNames>,
    by_tasks: OnceCell<BTreeSet<SubjectId>>,
    /// The subjects that read something of a base.
    readers: OnceCell<FxHashMap<Base, Vec<SubjectId>>>,
    /// The subjects of which a node may change what they read, as far as it was asked.
    changed_at: RefCell<FxHashMap<NodeId, Arc<Vec<SubjectId>>>>,
}

/// What was found for a key, or is found now.
fn found_once<K: Eq + std::hash::Hash, V: Clone>(
    known: &RefCell<FxHashMap<K, V>>,
    key: K,
    find: impl FnOnce() -> V,
) -> V {
    let found = known.borrow().get(&key).cloned();
    found.unwrap_or_else(|| {
        let found = find();
        known.borrow_mut().insert(key, found.clone());
        found
    })
}

impl ControlDependence {
    pub(super) fn of(graph: &ControlFlowGraph, aliases: &Aliases) -> Self {
        let endless = endless_heads(graph);
        let exit = exit_of(graph);
        let after = post_dominators(graph, &endless);
        let mut branches: Vec<Vec<u32>> = vec![Vec::new(); graph.nodes.len()];
        for (number, node) in (0u32..).zip(&graph.nodes) {
            if node.next.len() < 2 && !endless.contains(&number) {
                continue;
            }
            let stop = after[number as usize];
            let mut open: Vec<u32> = node.next.iter().map(|next| next.0).collect();
            while let Some(node) = open.pop() {
                if Some(node) == stop || branches[node as usize].contains(&number) {
                    continue;
                }
                branches[node as usize].push(number);
                match after[node as usize] {
                    Some(next) if next == exit => {}
                    Some(next) => open.push(next),
                    // All ways from here diverge, and all that lies on them depends on the branch.
                    None => open.extend(graph.nodes[node as usize].next.iter().map(|next| next.0)),
                }
            }
        }
        let mut before: Vec<Vec<NodeId>> = vec![Vec::new(); graph.nodes.len()];
        for id in graph.node_ids() {
            for next in &graph.node(id).next {
                before[next.0 as usize].push(id);
            }
        }
        let mut asking: BTreeMap<SubjectId, Vec<NodeId>> = BTreeMap::new();
        for id in graph.node_ids() {
            if let Effect::Branch(test) = &graph.node(id).effect
                && let Some(subject) = test.subject
            {
                asking.entry(subject).or_default().push(id);
            }
        }
        let (assigned, overwritten) = assignments(graph, aliases);
        Self {
            branches,
            before,
            assigned,
            overwritten,
            asking,
            arriving: RefCell::default(),
            needing: RefCell::default(),
            writing: RefCell::default(),
            before_loop: RefCell::default(),
            by_other_names: OnceCell::new(),
            by_tasks: OnceCell::new(),
            readers: OnceCell::new(),
            changed_at: RefCell::default(),
        }
    }

    /// The branches on a subject.
    pub(super) fn asking(&self, subject: SubjectId) -> &[NodeId] {
        self.asking.get(&subject).map_or(&[], Vec::as_slice)
    }

    /// The heads with which a subject that never changes comes to a node.
    pub(super) fn arriving(&self, node: NodeId, subject: SubjectId, find: impl FnOnce() -> u32) -> u32 {
        found_once(&self.arriving, (node, subject), find)
    }

    /// The nodes that may need what is known of a subject.
    pub(super) fn needing(&self, subject: SubjectId, find: impl FnOnce() -> Vec<bool>) -> Arc<Vec<bool>> {
        found_once(&self.needing, subject, || Arc::new(find()))
    }

    /// The nodes that may change what a subject reads.
    pub(super) fn writing(&self, subject: SubjectId, find: impl FnOnce() -> Vec<NodeId>) -> Arc<Vec<NodeId>> {
        found_once(&self.writing, subject, || Arc::new(find()))
    }

    /// The nodes that may change what subjects read by names that are not known for those of the same cells.
    pub(super) fn by_other_names(&self, find: impl FnOnce() -> ByOtherNames) -> &ByOtherNames {
        self.by_other_names.get_or_init(find)
    }

    /// The subjects that may be others where other tasks have run.
    pub(super) fn by_tasks(&self, find: impl FnOnce() -> BTreeSet<SubjectId>) -> &BTreeSet<SubjectId> {
        self.by_tasks.get_or_init(find)
    }

    /// The subjects that read something of a base.
    pub(super) fn readers(
        &self,
        find: impl FnOnce() -> FxHashMap<Base, Vec<SubjectId>>,
    ) -> &FxHashMap<Base, Vec<SubjectId>> {
        self.readers.get_or_init(find)
    }

    /// The subjects of which a node may change what they read.
    pub(super) fn changed_at(&self, node: NodeId, find: impl FnOnce() -> Vec<SubjectId>) -> Arc<Vec<SubjectId>> {
        found_once(&self.changed_at, node, || Arc::new(find()))
    }

    /// The heads that a subject can have where a loop begins.
    pub(super) fn before_loop(&self, id: LoopId, subject: SubjectId, find: impl FnOnce() -> u32) -> u32 {
        found_once(&self.before_loop, (id, subject), find)
    }

    /// The nodes that a node follows.
    pub(super) fn before(&self, node: NodeId) -> &[NodeId] {
        &self.before[node.0 as usize]
    }

    /// The branches that decide whether a node is reached.
    pub(super) fn of_node(&self, node: NodeId) -> &[u32] {
        &self.branches[node.0 as usize]
    }
}

/// The heads of loops from which no exit can be reached.
fn endless_heads(graph: &ControlFlowGraph) -> BTreeSet<u32> {
    let mut before: Vec<Vec<u32>> = vec![Vec::new(); graph.nodes.len()];
    let mut open = Vec::new();
    for (number, node) in (0u32..).zip(&graph.nodes) {
        for next in &node.next {
            before[next.0 as usize].push(number);
        }
        if node.next.is_empty() && !matches!(node.effect, Effect::Diverge | Effect::End) {
            open.push(number);
        }
    }
    let mut ends = vec![false; graph.nodes.len()];
    while let Some(node) = open.pop() {
        if !std::mem::replace(&mut ends[node as usize], true) {
            open.extend(before[node as usize].iter().copied());
        }
    }
    let heads = (0u32..).zip(&graph.nodes).filter(|(_, node)| matches!(node.effect, Effect::LoopHead(_)));
    heads.filter(|(number, _)| !ends[*number as usize]).map(|(number, _)| number).collect()
}

/// The nearest node through which every way from a node to an exit leads; none where all ways diverge. Ways that never end or that diverge do not count: a
/// loop without an exit is taken to have one at its head.
fn post_dominators(graph: &ControlFlowGraph, endless: &BTreeSet<u32>) -> Vec<Option<u32>> {
    let count = graph.nodes.len();
    let exit = exit_of(graph);
    let mut before: Vec<Vec<u32>> = vec![Vec::new(); count + 1];
    for (number, node) in (0u32..).zip(&graph.nodes) {
        if matches!(node.effect, Effect::Diverge | Effect::End) {
            continue;
        }
        for next in &node.next {
            before[next.0 as usize].push(number);
        }
        if node.next.is_empty() || endless.contains(&number) {
            before[exit as usize].push(number);
        }
    }
    // Cooper, Harvey and Kennedy's algorithm on the reversed graph.
    let order = reverse_postorder(&before, exit);
    let mut position = vec![usize::MAX; count + 1];
    for (at, node) in order.iter().enumerate() {
        position[*node as usize] = at;
    }
    let mut after: Vec<Option<u32>> = vec![None; count + 1];
    after[exit as usize] = Some(exit);
    let mut changed = true;
    while changed {
        changed = false;
        for node in order.iter().skip(1) {
            let mut successors: Vec<u32> = match graph.nodes.get(*node as usize) {
                Some(info) => info.next.iter().map(|next| next.0).collect(),
                None => Vec::new(),
            };
            if graph.nodes.get(*node as usize).is_some_and(|info| info.next.is_empty()) || endless.contains(node) {
                successors.push(exit);
            }
            let mut nearest: Option<u32> = None;
            for successor in successors {
                if after[successor as usize].is_none() || position[successor as usize] == usize::MAX {
                    continue;
                }
                nearest = Some(match nearest {
                    None => successor,
                    Some(other) => meet(&after, &position, other, successor),
                });
            }
            if nearest.is_some() && after[*node as usize] != nearest {
                after[*node as usize] = nearest;
                changed = true;
            }
        }
    }
    after.truncate(count);
    after
}

/// The number of the node behind all exits.
fn exit_of(graph: &ControlFlowGraph) -> u32 {
    u32::try_from(graph.nodes.len()).unwrap_or(u32::MAX)
}

fn meet(after: &[Option<u32>], position: &[usize], left: u32, right: u32) -> u32 {
    let (mut left, mut right) = (left, right);
    while left != right {
        while position[left as usize] > position[right as usize] {
            left = after[left as usize].unwrap_or(left);
        }
        while position[right as usize] > position[left as usize] {
            right = after[right as usize].unwrap_or(right);
        }
    }
    left
}

fn reverse_postorder(next: &[Vec<u32>], start: u32) -> Vec<u32> {
    let mut seen = vec![false; next.len()];
    let mut order = Vec::new();
    let mut path: Vec<(u32, usize)> = vec![(start, 0)];
    seen[start as usize] = true;
    while let Some((node, edge)) = path.last_mut() {
        if let Some(child) = next[*node as usize].get(*edge).copied() {
            *edge += 1;
            if !seen[child as usize] {
                seen[child as usize] = true;
                path.push((child, 0));
            }
        } else {
            order.push(*node);
            path.pop();
        }
    }
    order.reverse();
    order
}

/// How many subjects are tracked at once; the rest is not told apart.
pub(super) const MAX_TRACKED: usize = 10;

/// How many are where there are too many ways to tell so many apart.
pub(super) const FEW_TRACKED: usize = 3;

/// The subjects whose heads must be known to tell the ways of an instance apart.
#[derive(Clone, Debug, Default)]
pub(super) struct Tracked {
    pub(super) subjects: Vec<SubjectId>,
    /// Those that are asked for more than once.
    pub(super) often: BTreeSet<SubjectId>,
    /// Those that are asked for once, and that callers may ask for as well.
    pub(super) once: BTreeSet<SubjectId>,
    /// Subjects that would have to be tracked, beyond the limit.
    pub(super) dropped: BTreeSet<SubjectId>,
}

/// Up to how many subjects those are tracked that only tell whether a way completes.
const MAX_WITH_EXITS: usize = 6;

impl Tracked {
    /// Tracks more, where there is room; what is usually told apart is missed where fewer are.
    pub(super) fn add(&mut self, more: Self, most: usize) {
        let room = MAX_WITH_EXITS.min(most).saturating_sub(self.subjects.len());
        let mut new: Vec<SubjectId> = Vec::new();
        for id in more.subjects {
            if self.subjects.contains(&id) || new.contains(&id) {
                continue;
            }
            if new.len() < room {
                new.push(id);
            } else if most < MAX_TRACKED {
                self.dropped.insert(id);
            }
        }
        self.subjects.extend(new);
        self.subjects.sort_unstable();
        self.often.extend(more.often);
    }
}

/// Finds what matters, beginning with the nodes at which something happens to the instance. `times` says how often a branch is
/// asked on one way: not at all outside the region, and more than once in a loop inside it. `asked` says what a call asks for, and `most` how
/// many there may be.
pub(super) fn tracked(
    graph: &ControlFlowGraph,
    dependence: &ControlDependence,
    touching: &BTreeSet<NodeId>,
    times: &dyn Fn(NodeId) -> u32,
    asked: &dyn Fn(NodeId) -> BTreeSet<SubjectId>,
    most: usize,
) -> Tracked {
    let assigned = &dependence.assigned;
    // What lies in a parameter a caller may ask for as well.
    let is_lent = |subject: SubjectId| {
        let known_as = graph.subjects[subject.0 as usize].known_as();
        known_as.and_then(Place::base_var).is_some_and(|var| graph.var(var).param.is_some())
    };
    let mut relevant: BTreeSet<NodeId> = touching.clone();
    let mut tests: BTreeMap<SubjectId, u32> = BTreeMap::new();
    let mut branches = BTreeSet::new();
    let mut follow = |mut open: Vec<NodeId>, relevant: &mut BTreeSet<NodeId>, tests: &mut BTreeMap<SubjectId, u32>| {
        while let Some(node) = open.pop() {
            let mut asked_for: Vec<(SubjectId, u32)> = Vec::new();
            for branch in &dependence.branches[node.0 as usize] {
                let branch = NodeId(*branch);
                if !branches.insert(branch) {
                    continue;
                }
                if let Effect::Branch(test) = &graph.node(branch).effect
                    && let Some(subject) = test.subject
                {
                    asked_for.push((subject, times(branch)));
                }
                if relevant.insert(branch) {
                    open.push(branch);
                }
            }
            // A value that is copied from another subject, or given back, matters as that subject does.
            let returned = match &graph.node(node).effect {
                Effect::Return(value) => value.same_as.map(Place::var),
                _ => None,
            };
            let copied = graph.copied(node).into_iter().chain(returned);
            asked_for.extend(copied.filter_map(|from| Some((graph.subject_of(&from)?, 1))));
            for (subject, times) in asked_for {
                let count = tests.entry(subject).or_default();
                *count += times;
                let assigned = assigned.get(&subject).into_iter().flatten();
                // Whether what is known of it is lost matters once it is told apart.
                let is_told = *count >= 2 || assigned.clone().next().is_some() || is_lent(subject);
                let overwritten = dependence.overwritten.get(&subject).filter(|_| is_told).into_iter().flatten();
                open.extend(assigned.chain(overwritten).filter(|writer| relevant.insert(**writer)));
            }
        }
    };
    follow(touching.iter().copied().collect(), &mut relevant, &mut tests);
    let mut wanted: Vec<SubjectId> = tests
        .iter()
        .filter(|(subject, count)| **count >= 2 || assigned.get(subject).is_some_and(|writers| !writers.is_empty()))
        .map(|(subject, _)| *subject)
        .collect();
    wanted.sort_by_key(|subject| std::cmp::Reverse(tests.get(subject).copied().unwrap_or(0)));
    let dropped = wanted.iter().skip(most).copied().collect();
    wanted.truncate(most);
    // What helpers ask for is told apart as far as there is room, where something else asks for it, too, or sets it.
    let asked: Vec<(SubjectId, u32)> =
        relevant.iter().flat_map(|node| asked(*node).into_iter().map(|subject| (subject, times(*node)))).collect();
    for (subject, times) in &asked {
        *tests.entry(*subject).or_default() += times;
    }
    // What an argument is made of: `slow(n % 2 == 0); slow(n % 2 != 0)`.
    let is_argument = |subject: &SubjectId| {
        let whole = graph.subjects[subject.0 as usize].whole.as_ref();
        whole.and_then(Place::base_var).is_some_and(|var| graph.var(var).name.is_empty())
    };
    let made_of = asked.iter().filter(|(subject, _)| is_argument(subject));
    let made_of = made_of.flat_map(|(subject, _)| assigned.get(subject).into_iter().flatten().copied());
    let made_of: Vec<NodeId> = made_of.filter(|writer| relevant.insert(*writer)).collect();
    follow(made_of, &mut relevant, &mut tests);
    // What a call gave back is known where the call tells it.
    let gives_result = |node: &NodeId| {
        let from = graph.copied(*node).and_then(|from| graph.subject_of(&from));
        let mut writers = from.and_then(|from| assigned.get(&from)).into_iter().flatten();
        writers.any(|writer| matches!(graph.node(*writer).effect, Effect::Call(_)))
    };
    let is_set = |node: &NodeId| match &graph.node(*node).effect {
        Effect::Set(set) | Effect::Write(set) => set.head.is_some() || gives_result(node),
        _ => false,
    };
    let is_known =
        |subject: &SubjectId, count: u32| count >= 2 || assigned.get(subject).into_iter().flatten().any(is_set);
    let again = tests.iter().filter(|(subject, count)| !wanted.contains(subject) && is_known(subject, **count));
    let mut again: Vec<SubjectId> = again.map(|(subject, _)| *subject).collect();
    // What these are copied from: `self.phase = !self.phase` between two calls.
    let copied = |subject: &SubjectId| {
        let writers = assigned.get(subject).into_iter().flatten();
        writers.filter_map(|node| graph.subject_of(&graph.copied(*node)?)).collect::<Vec<_>>()
    };
    again.extend(again.iter().flat_map(copied).collect::<Vec<_>>());
    let again = Tracked { subjects: again, ..Tracked::default() };
    let often = tests.iter().filter(|(_, count)| **count >= 2).map(|(subject, _)| *subject).collect();
    let once = tests.into_keys().filter(|subject| is_lent(*subject) && !wanted.contains(subject)).collect();
    let mut tracked = Tracked { subjects: wanted, often, once, dropped };
    tracked.add(again, most);
    tracked.subjects.sort_unstable();
    tracked
}

/// The nodes that give a subject a head that is known (constants, copies, results of calls), and those that give it any.
fn assignments(
    graph: &ControlFlowGraph,
    aliases: &Aliases,
) -> (BTreeMap<SubjectId, Vec<NodeId>>, BTreeMap<SubjectId, Vec<NodeId>>) {
    let mut whole: BTreeMap<&Place, SubjectId> = BTreeMap::new();
    for (number, subject) in (0u32..).zip(&graph.subjects) {
        if let Some(place) = &subject.whole {
            whole.insert(place, SubjectId(number));
        }
    }
    let mut known: BTreeMap<SubjectId, Vec<NodeId>> = BTreeMap::new();
    let mut unknown: BTreeMap<SubjectId, Vec<NodeId>> = BTreeMap::new();
    for id in graph.node_ids() {
        let (subject, found) = match &graph.node(id).effect {
            Effect::Set(set) | Effect::Write(set) if set.head.is_some() || graph.copied(id).is_some() => {
                (whole.get(&set.place), &mut known)
            }
            Effect::Set(set) | Effect::Write(set) => {
                // What is written through a reference is written where it points to.
                let roots = aliases.shared_roots(&set.place);
                let behind = roots.iter().filter(|root| !set.rebinds && **root != set.place);
                for subject in behind.filter_map(|root| whole.get(root)) {
                    unknown.entry(*subject).or_default().push(id);
                }
                (whole.get(&set.place), &mut unknown)
            }
            Effect::Call(site) => (whole.get(&Place::var(site.result)), &mut known),
            _ => continue,
        };
        if let Some(subject) = subject {
            found.entry(*subject).or_default().push(id);
        }
    }
    (known, unknown)
}
