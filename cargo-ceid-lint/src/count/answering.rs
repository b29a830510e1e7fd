//! Of which functions it matters what they answer: those that run, at any depth, in a function that is searched for the updates of a
//! filter. In the rest of a program, which is nearly all of it in most, no way is followed.

use std::sync::atomic::{AtomicBool, Ordering};

use super::callgraph::callees;
use super::declared::base_ty;
use super::instances::is_generic;
use crate::flow::{ControlFlowGraph, Effect, Place, Program};
use crate::index::{FunctionId, Index, Ty};

/// The functions whose answers matter.
#[derive(Debug, Default)]
pub(super) struct Answering {
    /// By their numbers; all if none are told.
    asked: Option<Vec<bool>>,
    /// Whether one was searched that is not among them.
    is_too_few: AtomicBool,
}

impl Answering {
    /// Those below a function that has to do with filters, or that calls one which does.
    pub(super) fn of(program: &Program<'_>, graphs: &[Option<ControlFlowGraph>]) -> Self {
        let calls: Vec<Vec<usize>> =
            graphs.iter().map(|graph| graph.as_ref().map(callees).unwrap_or_default()).collect();
        let mut callers: Vec<Vec<usize>> = vec![Vec::new(); graphs.len()];
        for (caller, callees) in calls.iter().enumerate() {
            callees.iter().for_each(|callee| callers[*callee].push(caller));
        }
        let concerned = program
            .cores
            .deeply(graphs.len(), |at| graphs[at].as_ref().is_some_and(|graph| has_filters(program.index, graph)));
        let searched = reached(&concerned, &callers);
        Self { asked: Some(reached(&searched, &calls)), is_too_few: AtomicBool::new(false) }
    }

    /// Whether what a function answers matters.
    pub(super) fn matters(&self, id: FunctionId) -> bool {
        self.asked.as_ref().is_none_or(|asked| asked.get(id.0 as usize).copied().unwrap_or(true))
    }

    /// A function is searched.
    pub(super) fn note_search(&self, id: FunctionId) {
        if !self.matters(id) {
            self.is_too_few.store(true, Ordering::Relaxed);
        }
    }

    /// Whether a function was searched after all that was not thought to be.
    pub(super) fn is_too_few(&self) -> bool {
        self.is_too_few.load(Ordering::Relaxed)
    }
}

/// The functions that can be reached from some, which are among them.
fn reached(from: &[bool], next: &[Vec<usize>]) -> Vec<bool> {
    let mut reached = vec![false; from.len()];
    let mut open: Vec<usize> = (0..from.len()).filter(|at| from[*at]).collect();
    while let Some(at) = open.pop() {
        if !std::mem::replace(&mut reached[at], true) {
            open.extend(&next[at]);
        }
    }
    reached
}

/// Whether there is, or may be, a filter in what a function has to do with by itself.
fn has_filters(index: &Index, graph: &ControlFlowGraph) -> bool {
    let leads_there =
        |place: &Place| place.base_var().is_none() && leads_to_filter(index, &base_ty(index, graph, place.base));
    graph.vars.iter().any(|info| leads_to_filter(index, &info.ty))
        || graph.nodes.iter().any(|node| match &node.effect {
            Effect::Update(_)
            | Effect::Advance(_)
            | Effect::Reset { .. }
            | Effect::GuardStart(_)
            | Effect::GuardEnd(_) => true,
            Effect::Write(write) => is_generic(graph, &write.place) || leads_there(&write.place),
            Effect::Set(set) => leads_there(&set.place) || set.from.as_ref().is_some_and(leads_there),
            Effect::Use { place } => leads_there(place),
            Effect::Unknown { places, .. } => places.iter().any(leads_there),
            Effect::Call(site) => site.args.iter().filter_map(|arg| arg.place.as_ref()).any(leads_there),
            _ => false,
        })
}

/// Whether a filter may be in a value of a type, or behind it.
fn leads_to_filter(index: &Index, ty: &Ty) -> bool {
    index.holds_filter(ty) || index.types_behind(ty.peel()).iter().any(|behind| index.holds_filter(behind))
}
