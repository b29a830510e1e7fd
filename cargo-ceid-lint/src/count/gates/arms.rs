//! Guards of arms that are of no matter for the filter: `Reply::Fix(sats) if sats >= 4 => …, Reply::Speed(v) => filter.update(v)`.

use super::{Gates, MAX_ORIGINS, Way};
use crate::count::verdict::Gate;
use crate::flow::{Effect, NodeId, Test};

impl Gates<'_, '_> {
    /// Why a way skips that goes on behind the guard of an arm, if no update is for what the pattern of that arm takes: the value was
    /// something else, whatever the guard says.
    pub(super) fn of_arm(&self, test: &Test, at: NodeId, way: &Way, origins: u32) -> Option<Gate> {
        if !test.about.is_guard || origins >= MAX_ORIGINS {
            return None;
        }
        let graph = self.search.graph;
        let before = way.nodes.iter().position(|node| *node == at)?;
        let (asked, asked_at) = way.nodes[..before].iter().rev().find_map(|id| match &graph.node(*id).effect {
            Effect::Branch(asked) if !asked.about.is_guard => Some((asked, *id)),
            _ => None,
        })?;
        let taken = graph.node(asked_at).next.first().copied();
        if taken.is_none() || way.after(asked_at) != taken || self.may_update(asked, taken?) {
            return None;
        }
        let gate = self.of_condition(asked, asked_at, way, origins + 1);
        gate.filter(|gate| matches!(gate, Gate::Event | Gate::Sample))
    }

    /// Whether an update is reached from a node as long as what was asked is what the pattern takes.
    fn may_update(&self, asked: &Test, from: NodeId) -> bool {
        let reached = self.reached_from(from, |node, edge| match &self.search.graph.node(node).effect {
            Effect::Branch(other) if other.subject == asked.subject => {
                let heads = if edge == 0 { other.holds } else { other.fails };
                heads & asked.holds != 0
            }
            _ => true,
        });
        asked.subject.is_none() || self.search.updating().iter().any(|node| reached[node.0 as usize])
    }
}
