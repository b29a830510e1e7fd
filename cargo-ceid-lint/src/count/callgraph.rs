//! Who may run whom, and in which order functions are looked at: callees first.

use std::collections::{BTreeSet, VecDeque};

use rustc_hash::{FxHashMap, FxHashSet};

use crate::flow::{ControlFlowGraph, Effect, NodeId};
use crate::index::FunctionId;

/// The functions that call each other in a circle, or themselves.
pub(super) fn recursive(graphs: &[Option<ControlFlowGraph>]) -> BTreeSet<FunctionId> {
    let calls_itself = |id: &FunctionId| {
        let graph = graphs[id.0 as usize].as_ref();
        graph.is_some_and(|graph| callees(graph).contains(&(id.0 as usize)))
    };
    let circles = components(graphs).into_iter();
    circles.filter(|circle| circle.len() > 1 || circle.iter().any(calls_itself)).flatten().collect()
}

/// The strongly connected components of the call graph, callees first (Tarjan's algorithm without recursion).
pub(super) fn components(graphs: &[Option<ControlFlowGraph>]) -> Vec<Vec<FunctionId>> {
    let calls: Vec<Vec<usize>> = graphs.iter().map(|graph| graph.as_ref().map(callees).unwrap_or_default()).collect();
    let mut state = Tarjan {
        calls: &calls,
        index: vec![None; graphs.len()],
        low: vec![0; graphs.len()],
        on_stack: vec![false; graphs.len()],
        stack: Vec::new(),
        next: 0,
        found: Vec::new(),
    };
    for (start, graph) in graphs.iter().enumerate() {
        if graph.is_some() && state.index[start].is_none() {
            state.visit(start);
        }
    }
    state.found
}

/// The components by levels: what one of a level calls is in itself or on a level before.
pub(super) fn levels(graphs: &[Option<ControlFlowGraph>]) -> Vec<Vec<Vec<FunctionId>>> {
    let mut levels: Vec<Vec<Vec<FunctionId>>> = Vec::new();
    // One more than the level of each function that was placed.
    let mut above = vec![0; graphs.len()];
    for component in components(graphs) {
        let called = component.iter().flat_map(|id| graphs[id.0 as usize].iter().flat_map(callees));
        let level = called.map(|callee| above[callee]).max().unwrap_or(0);
        for id in &component {
            above[id.0 as usize] = level + 1;
        }
        if levels.len() <= level {
            levels.resize_with(level + 1, Vec::new);
        }
        levels[level].push(component);
    }
    levels
}

/// The functions that a graph calls.
pub(super) fn callees(graph: &ControlFlowGraph) -> Vec<usize> {
    let mut found: Vec<usize> = graph
        .nodes
        .iter()
        .filter_map(|node| match &node.effect {
            Effect::Call(site) => Some(site.targets.iter().map(|target| target.0 as usize)),
            _ => None,
        })
        .flatten()
        .collect();
    found.sort_unstable();
    found.dedup();
    found
}

/// Functions that call each other, in the order in which each can return when those before it do; at the end those that never do.
pub(super) fn by_return(graphs: &[Option<ControlFlowGraph>], component: Vec<FunctionId>) -> Vec<FunctionId> {
    if component.len() < 2 {
        return component;
    }
    let mut waiting: FxHashMap<FunctionId, Vec<FunctionId>> = FxHashMap::default();
    for id in &component {
        for callee in graphs[id.0 as usize].iter().flat_map(callees) {
            waiting.entry(FunctionId(u32::try_from(callee).unwrap_or(u32::MAX))).or_default().push(*id);
        }
    }
    let own: FxHashSet<FunctionId> = component.iter().copied().collect();
    let mut returning: FxHashSet<FunctionId> = FxHashSet::default();
    let mut ordered = Vec::new();
    let mut open: VecDeque<FunctionId> = component.iter().copied().collect();
    while let Some(id) = open.pop_front() {
        let Some(graph) = &graphs[id.0 as usize] else { continue };
        if returning.contains(&id) || !can_return(graph, |target| !own.contains(&target) || returning.contains(&target))
        {
            continue;
        }
        returning.insert(id);
        ordered.push(id);
        open.extend(waiting.get(&id).into_iter().flatten().copied().filter(|caller| own.contains(caller)));
    }
    ordered.extend(component.into_iter().filter(|id| !returning.contains(id)));
    ordered
}

/// Whether a way leads from the head of a function to its end on which each call has a target that returns.
fn can_return(graph: &ControlFlowGraph, returns: impl Fn(FunctionId) -> bool) -> bool {
    let mut seen = vec![false; graph.nodes.len()];
    let mut open = vec![NodeId(0)];
    while let Some(id) = open.pop() {
        if std::mem::replace(&mut seen[id.0 as usize], true) {
            continue;
        }
        match &graph.node(id).effect {
            Effect::Return(_) => return true,
            Effect::Call(site) if !site.targets.is_empty() && !site.targets.iter().any(|target| returns(*target)) => {}
            _ => open.extend(graph.node(id).next.iter().copied()),
        }
    }
    false
}

struct Tarjan<'a> {
    calls: &'a [Vec<usize>],
    index: Vec<Option<usize>>,
    low: Vec<usize>,
    on_stack: Vec<bool>,
    stack: Vec<usize>,
    next: usize,
    found: Vec<Vec<FunctionId>>,
}

impl Tarjan<'_> {
    fn open(&mut self, at: usize) {
        self.index[at] = Some(self.next);
        self.low[at] = self.next;
        self.next += 1;
        self.stack.push(at);
        self.on_stack[at] = true;
    }

    fn visit(&mut self, start: usize) {
        let mut path: Vec<(usize, usize)> = vec![(start, 0)];
        self.open(start);
        while let Some((at, edge)) = path.last_mut() {
            let at = *at;
            if let Some(next) = self.calls[at].get(*edge).copied() {
                *edge += 1;
                match self.index[next] {
                    None => {
                        self.open(next);
                        path.push((next, 0));
                    }
                    Some(index) if self.on_stack[next] => self.low[at] = self.low[at].min(index),
                    Some(_) => {}
                }
            } else {
                path.pop();
                if let Some((parent, _)) = path.last() {
                    self.low[*parent] = self.low[*parent].min(self.low[at]);
                }
                if Some(self.low[at]) == self.index[at] {
                    self.close(at);
                }
            }
        }
    }

    fn close(&mut self, root: usize) {
        let mut component = Vec::new();
        while let Some(member) = self.stack.pop() {
            self.on_stack[member] = false;
            component.push(FunctionId(u32::try_from(member).unwrap_or(u32::MAX)));
            if member == root {
                break;
            }
        }
        component.sort_unstable();
        self.found.push(component);
    }
}

pub(super) fn calls_itself(graphs: &[Option<ControlFlowGraph>], id: FunctionId) -> bool {
    graphs[id.0 as usize].as_ref().is_some_and(|graph| {
        graph.nodes.iter().any(|node| matches!(&node.effect, Effect::Call(site) if site.targets.contains(&id)))
    })
}
