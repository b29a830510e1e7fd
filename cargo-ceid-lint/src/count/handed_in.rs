//! References that functions put into what they are lent: `fn add(&mut self, filter: &'a mut Lag) { self.filters.push(filter) }`. Each
//! call of such a function does so where it stands, so that what is updated by them is followed there as if it were written there.

use std::collections::BTreeSet;

use super::aliases::Aliases;
use super::callgraph;
use super::declared::declared_ty;
use super::given::{Given, GivenBase, given, place_of};
use super::summary::Summaries;
use crate::flow::{About, Assignment, CallSite, ControlFlowGraph, Effect, Node, NodeId, Place, Test, Transfer, Var};
use crate::index::{FunctionId, Index, Ty};

/// How many such places of a function are told apart.
const MOST: usize = 16;

/// A reference that a function puts somewhere.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Put {
    to: Given,
    from: Given,
    /// Whether every way through the function does so.
    is_certain: bool,
}

/// Adds to each function what those that it calls put into what it lends them, callees first.
pub(super) fn hand_up(index: &Index, graphs: &mut [Option<ControlFlowGraph>]) {
    let mut puts: Vec<BTreeSet<Put>> = vec![BTreeSet::new(); graphs.len()];
    for id in callgraph::components(graphs).into_iter().flatten() {
        let Some(graph) = &mut graphs[id.0 as usize] else { continue };
        take_over(graph, &puts);
        if takes_references(index, graph) {
            puts[id.0 as usize] = puts_of(index, graph);
        }
    }
}

/// Whether a function could put a reference that it is given into something that it is lent.
fn takes_references(index: &Index, graph: &ControlFlowGraph) -> bool {
    let is_lent = |var: &Var| matches!(&graph.var(*var).ty, Ty::Ref(true, inner) if has_room(index, inner));
    let is_reference = |var: &Var| may_refer(index, &graph.var(*var).ty);
    graph.params.iter().any(|to| is_lent(to) && graph.params.iter().any(|from| from != to && is_reference(from)))
}

/// Whether a value of the type may be a reference to a filter, or is made of some.
fn may_refer(index: &Index, ty: &Ty) -> bool {
    matches!(ty, Ty::Param(_)) || index.refers_to_filters(ty)
}

/// Whether there may be a reference to a filter in a value of the type.
fn has_room(index: &Index, ty: &Ty) -> bool {
    may_refer(index, ty)
        || ty.has_part(&mut |part| matches!(part, Ty::Ref(..)))
        || matches!(ty, Ty::Adt(..)) && index.holds_filter(ty)
}

fn puts_of(index: &Index, graph: &ControlFlowGraph) -> BTreeSet<Put> {
    let aliases = Aliases::of(index, graph, &Summaries::default());
    let lent = |given: &Given| match given.base {
        GivenBase::Param(param) => matches!(graph.var(graph.params[param]).ty, Ty::Ref(true, _)),
        GivenBase::Static(_) => false,
    };
    let writes_through = |var: Var| matches!(&graph.var(var).ty, Ty::Ref(true, inner) if may_refer(index, inner));
    let refers = |place: &Place| declared_ty(index, graph, place).is_some_and(|ty| may_refer(index, &ty));
    let mut found = BTreeSet::new();
    for id in graph.node_ids() {
        let (Effect::Set(set) | Effect::Write(set)) = &graph.node(id).effect else { continue };
        let Some(from) = &set.from else { continue };
        let given_parts = aliases.parts(from);
        let to = match (set.place.steps.split_last(), &graph.node(id).effect) {
            (Some((last, owner)), _) => {
                let owner = aliases.roots(&Place { base: set.place.base, steps: owner.to_vec() });
                owner.into_iter().map(|owner| owner.join(std::slice::from_ref(last))).collect()
            }
            // A variable that refers to something else says nothing of what it referred to.
            (None, Effect::Set(_)) => Vec::new(),
            (None, _) if !set.place.base_var().is_some_and(writes_through) => Vec::new(),
            // From here on the place is a name of what it is given as well.
            (None, _) => {
                let mut to = aliases.roots(&set.place);
                to.retain(|root| given_parts.iter().all(|(_, given)| given != root));
                to
            }
        };
        let is_only = to.len() == 1 && is_on_every_way(graph, id);
        let to: Vec<Given> = to.iter().filter_map(|root| given(graph, root)).filter(&lent).collect();
        if to.is_empty() {
            continue;
        }
        for (part, root) in given_parts {
            let Some(from) = given(graph, &root).filter(|_| refers(&root)) else { continue };
            for to in &to {
                let to = Given { base: to.base, steps: [to.steps.as_slice(), &part].concat() };
                if to.base != from.base && matches!(from.base, GivenBase::Param(_)) && found.len() < MOST {
                    found.insert(Put { to, from: from.clone(), is_certain: is_only });
                }
            }
        }
    }
    found
}

/// Whether no way leads through a function without a node.
fn is_on_every_way(graph: &ControlFlowGraph, through: NodeId) -> bool {
    let mut seen = BTreeSet::from([through]);
    let mut open = vec![NodeId(0)];
    while let Some(id) = open.pop() {
        if !seen.insert(id) {
            continue;
        }
        let node = graph.node(id);
        if matches!(node.effect, Effect::Return(_)) {
            return false;
        }
        open.extend(&node.next);
    }
    true
}

/// Puts behind each call what the function that is called does with references.
fn take_over(graph: &mut ControlFlowGraph, puts: &[BTreeSet<Put>]) {
    for id in graph.node_ids() {
        let Effect::Call(site) = &graph.node(id).effect else { continue };
        let has_some = |target: &FunctionId| puts.get(target.0 as usize).is_some_and(|puts| !puts.is_empty());
        if !site.targets.iter().any(has_some) {
            continue;
        }
        let is_only = site.targets.len() == 1;
        let found: BTreeSet<&Put> =
            site.targets.iter().filter_map(|target| puts.get(target.0 as usize)).flatten().collect();
        let given = found.into_iter().filter(|put| is_given_reference(site, &put.from));
        let mut all = given
            .filter_map(|put| {
                let (to, from) = (place_of(&put.to, site)?, place_of(&put.from, site)?);
                (to != from).then_some((to, from, put.is_certain && is_only))
            })
            .collect::<Vec<_>>();
        all.dedup();
        let text = site.text.clone();
        for (to, from, is_certain) in all {
            insert_behind(graph, id, (to, from), is_certain, &text);
        }
    }
}

/// Whether what a call gives for a parameter is a reference, where that may be anything.
fn is_given_reference(site: &CallSite, from: &Given) -> bool {
    let GivenBase::Param(param) = from.base else { return false };
    site.args.get(param).is_some_and(|arg| arg.is_reference)
}

fn insert_behind(
    graph: &mut ControlFlowGraph,
    at: NodeId,
    (place, from): (Place, Place),
    is_certain: bool,
    text: &str,
) {
    let Node { span, next, in_loop, debug_only, .. } = graph.node(at).clone();
    let mut add = |effect: Effect, next: Vec<NodeId>| {
        let id = NodeId(u32::try_from(graph.nodes.len()).expect("fewer than 2^32 nodes"));
        graph.nodes.push(Node { effect, span, next, in_loop, debug_only });
        id
    };
    let assignment =
        Assignment { place, from: Some(from), transfer: Transfer::Borrow, rebinds: true, head: None, same_as: None };
    let behind = add(Effect::Nothing, next);
    let put = add(Effect::Set(Box::new(assignment)), vec![behind]);
    let first = match is_certain {
        true => put,
        false => {
            let text = format!("`{text}` keeps it");
            let test = Test { subject: None, holds: u32::MAX, fails: u32::MAX, span, text, about: About::default() };
            add(Effect::Branch(test), vec![put, behind])
        }
    };
    graph.nodes[at.0 as usize].next = vec![first];
}
