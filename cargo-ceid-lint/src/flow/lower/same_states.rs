//! Variables that hold what a state was: as long as that is not changed, a condition on the one is a condition on the other.

use std::collections::BTreeSet;

use super::Builder;
use super::subjects::{Pure, pure_place};
use crate::flow::OTHER_HEADS;
use crate::flow::{ControlFlowGraph, Effect, NodeId, Place, SubjectId, Test, Transfer, Var};
use crate::index::Ty;

/// A variable that is given a state at one node and nothing else anywhere: `let mode = self.mode;`
struct Held {
    at: NodeId,
    var: Var,
    state: Place,
    asked: SubjectId,
}

impl Builder<'_> {
    /// Conditions on a variable that holds a state ask for the state itself, where it is still what it was at each of them.
    pub(super) fn settle_held_states(&mut self) {
        let held = held_states(&self.graph);
        for one in &held {
            let is_asked = self.graph.subjects.iter().any(|subject| subject.whole.as_ref() == Some(&one.state));
            let is_held_again = held.iter().any(|other| other.var != one.var && other.state == one.state);
            if is_asked || is_held_again {
                self.ask_for_state(one);
            }
        }
    }

    fn ask_for_state(&mut self, held: &Held) {
        let same = same_at(&self.graph, held.at, std::slice::from_ref(&held.state));
        self.ask_where(held.asked, &same, pure_place(held.state.clone()));
    }

    /// Lets all that asks for a subject ask for another value with the same heads, if that is so at each of the nodes; answers the
    /// subject that is asked then.
    pub(super) fn ask_where(&mut self, asked: SubjectId, same: &[bool], value: Pure) -> Option<SubjectId> {
        let graph = &self.graph;
        let asks = |test: &Test| test.subject == Some(asked);
        let asking: Vec<NodeId> = graph
            .node_ids()
            .filter(|id| matches!(&graph.node(*id).effect, Effect::Branch(test) if asks(test)))
            .collect();
        let is_exact = |id: &NodeId| match &graph.node(*id).effect {
            Effect::Branch(test) => test.fails == !test.holds || test.fails == u32::MAX,
            _ => false,
        };
        if asking.is_empty() || !asking.iter().all(|id| same[id.0 as usize] && is_exact(id)) {
            return None;
        }
        let subject = &graph.subjects[asked.0 as usize];
        let (heads, total) = (subject.heads.clone(), subject.total.clone());
        let other = self.subject(value, total);
        let bits: Vec<u32> = heads.iter().map(|head| self.head_bit(other, head)).collect::<Option<_>>()?;
        for id in asking {
            let Effect::Branch(test) = &mut self.graph.nodes[id.0 as usize].effect else { continue };
            let own = (0u32..).zip(&bits).filter(|(number, _)| test.holds & (1 << number) != 0);
            let holds = own.fold(test.holds & OTHER_HEADS, |all, (_, bit)| all | bit);
            if test.fails != u32::MAX {
                test.fails = !holds;
            }
            (test.subject, test.holds) = (Some(other), holds);
        }
        Some(other)
    }
}

/// The variables that hold a state, if no reference to the state is made that something may be written through.
fn held_states(graph: &ControlFlowGraph) -> Vec<Held> {
    let mut held = Vec::new();
    for (at, state) in &graph.copies {
        let Effect::Set(set) = &graph.node(*at).effect else { continue };
        let Some(var) = set.place.base_var().filter(|_| set.place.steps.is_empty()) else { continue };
        let gives = |id: &NodeId| match &graph.node(*id).effect {
            Effect::Set(other) | Effect::Write(other) => other.place.base_var() == Some(var),
            _ => false,
        };
        let hands_on = |id: &NodeId| *id != *at && graph.copied(*id) == Some(Place::var(var));
        let lends = |id: &NodeId| match &graph.node(*id).effect {
            Effect::Set(other) | Effect::Write(other) => {
                let is_lent = other.transfer == Transfer::Borrow
                    && matches!(other.place.base_var(), Some(to)
                    if matches!(graph.var(to).ty, Ty::Ref(true, _)));
                is_lent && other.from.as_ref().is_some_and(|from| from.overlaps(state))
            }
            Effect::Return(value) => value.same_as == Some(var),
            _ => false,
        };
        let is_simple = graph.node_ids().filter(gives).count() == 1
            && !graph.node_ids().any(|id| hands_on(&id) || lends(&id))
            && state.base_var().is_some();
        let asked = graph.subject_of(&Place::var(var));
        if let Some(asked) = asked.filter(|_| is_simple) {
            held.push(Held { at: *at, var, state: state.clone(), asked });
        }
    }
    held.sort_by_key(|held| held.at);
    held
}

/// The nodes at which what was held at a node is certainly the same, for none of the places that it depends on has changed.
pub(super) fn same_at(graph: &ControlFlowGraph, at: NodeId, places: &[Place]) -> Vec<bool> {
    let is_it = |place: &Place| places.iter().any(|held| place.overlaps(held));
    let changes = |id: NodeId| match &graph.node(id).effect {
        Effect::Set(set) | Effect::Write(set) => id != at && is_it(&set.place),
        Effect::Call(site) => {
            site.args.iter().filter(|arg| !arg.is_shared).filter_map(|arg| arg.place.as_ref()).any(is_it)
        }
        Effect::Unknown { places, .. } => places.iter().any(is_it),
        Effect::Update(update) => is_it(&update.place),
        Effect::Reset { place, .. } => is_it(place),
        Effect::Advance(_) | Effect::Fork => true,
        _ => false,
    };
    // Where it is not the same on one way, it is not the same: what may differ is spread along the edges.
    let mut differs: BTreeSet<NodeId> = BTreeSet::from([NodeId(0)]);
    let mut open: Vec<NodeId> = vec![NodeId(0)];
    open.extend(graph.node_ids().filter(|id| changes(*id)).flat_map(|id| graph.node(id).next.clone()));
    differs.extend(open.iter().copied());
    while let Some(id) = open.pop() {
        if id == at {
            continue;
        }
        for next in &graph.node(id).next {
            if differs.insert(*next) {
                open.push(*next);
            }
        }
    }
    graph.node_ids().map(|id| !differs.contains(&id)).collect()
}
