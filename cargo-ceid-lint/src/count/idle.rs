//! Closures that something unseen gets and that do nothing to a filter, however often they run: `panel.show(|ui| gains(ui, &mut pid))`.

use super::aliases::Aliases;
use super::called_place::CalledPlace;
use super::counts::Count;
use super::given::is_moved;
use super::outcome::Outcome;
use super::summary::Summaries;
use crate::flow::{ControlFlowGraph, Effect, LoopId, LoopInfo, NodeId, Place, Relation};

impl Summaries {
    /// Whether the closures that may run unseen at a node are all known, and none of them runs a law of what lies in a place.
    pub(super) fn leaves_alone(
        &self,
        graph: &ControlFlowGraph,
        aliases: &Aliases,
        node: NodeId,
        place: &Place,
    ) -> bool {
        let mut closures = handed_at(graph, node).peekable();
        closures.peek().is_some() && closures.all(|id| !self.runs_law_in(graph, aliases, id, place))
    }

    /// Whether all that is done to what lies in a place, of which a trait alone is known, are calls that update nothing: `stage.reset()`.
    pub(super) fn only_resets(&self, graph: &ControlFlowGraph, aliases: &Aliases, instance: &Place) -> bool {
        let does_nothing = |way: &Outcome| way.count == Count::Zero && way.unknown.is_none();
        let holds =
            |root: &Place| matches!(root.relate(instance, &|_| None), Relation::Holds(_) | Relation::MayHold(..));
        let is_it = |place: &Place| aliases.shared_roots(place).iter().any(holds);
        let mut is_called = false;
        let is_still = graph.nodes.iter().all(|node| match &node.effect {
            Effect::Update(update) => !is_it(&update.place),
            Effect::Advance(advance) => !is_it(&advance.before),
            Effect::Unknown { places, .. } => !places.iter().any(is_it),
            Effect::Call(site) => {
                let called = aliases.called_places(site, self);
                let mut own = called.iter().filter(|called| called.roots().iter().any(holds)).peekable();
                is_called |= own.peek().is_some();
                own.all(|called| called.outcomes(self).iter().all(does_nothing))
            }
            _ => true,
        });
        is_called && is_still && !is_moved(graph, instance)
    }

    fn runs_law_in(&self, graph: &ControlFlowGraph, aliases: &Aliases, id: LoopId, place: &Place) -> bool {
        let own = aliases.shared_roots(place);
        let is_it =
            |other: &Place| aliases.shared_roots(other).iter().any(|root| own.iter().any(|own| own.overlaps(root)));
        let is_inside = |node: &NodeId| graph.is_within(graph.node(*node).in_loop, id);
        let does_nothing = |way: &Outcome| way.count == Count::Zero && way.unknown.is_none();
        graph.node_ids().filter(is_inside).any(|node| match &graph.node(node).effect {
            Effect::Update(update) => is_it(&update.place),
            Effect::Advance(advance) => is_it(&advance.before),
            Effect::GuardEnd(_) => true,
            // What runs elsewhere from there on is no closure that something unseen gets.
            Effect::Fork => !leads_to_closure(graph, node),
            Effect::Unknown { places, .. } if places.iter().any(is_it) => {
                // A closure in the closure.
                let mut nested = handed_at(graph, node).peekable();
                nested.peek().is_none()
                    || nested
                        .any(|inner| !is_begun_in(graph, inner, id) || self.runs_law_in(graph, aliases, inner, place))
            }
            Effect::Call(site) => {
                let acts = |called: &CalledPlace| {
                    called.roots().iter().any(|root| own.iter().any(|own| own.overlaps(root)))
                        && !called.outcomes(self).iter().all(does_nothing)
                };
                aliases.called_places(site, self).iter().any(acts)
            }
            _ => false,
        })
    }
}

/// Whether what a fork lets run elsewhere is a closure that something unseen gets.
fn leads_to_closure(graph: &ControlFlowGraph, fork: NodeId) -> bool {
    let mut at = graph.node(fork).next.get(1).copied();
    while let Some(node) = at.map(|at| graph.node(at)) {
        match (&node.effect, node.next.as_slice()) {
            (Effect::LoopEnter(id), _) => return graph.loop_info(*id).is_unseen(),
            (Effect::Nothing, [next]) => at = Some(*next),
            _ => return false,
        }
    }
    false
}

/// Whether a closure is made in another one, at any depth.
fn is_begun_in(graph: &ControlFlowGraph, inner: LoopId, outer: LoopId) -> bool {
    let begun_in = |id: LoopId| graph.loop_info(id).begun_in;
    std::iter::successors(begun_in(inner), |id| begun_in(*id)).any(|id| id == outer)
}

/// The loops that stand for the closures which may run at a node.
fn handed_at(graph: &ControlFlowGraph, node: NodeId) -> impl Iterator<Item = LoopId> {
    let is_handed = move |(_, info): &(u32, &LoopInfo)| info.handed.contains(&node);
    (0u32..).zip(&graph.loops).filter(is_handed).map(|(number, _)| LoopId(number))
}
