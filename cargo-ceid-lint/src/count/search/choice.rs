//! Ways that update another filter than the instance, because a reference was pointed there: `let one = if high { &mut a } else
//! { &mut b }`. What decides such a way is the condition behind the choice, not the update.

use super::End;
use super::run::Run;
use crate::count::counts::Count;
use crate::flow::{Effect, NodeId, Place, Relation, Var};

impl Run<'_, '_> {
    /// Moves the point at which each way skips to the condition that chose another filter, where one did.
    pub(super) fn skip_where_chosen(&mut self) {
        let chosen: Vec<Option<NodeId>> = self.exploration.ends.iter().map(|end| self.choice(end)).collect();
        for (end, choice) in self.exploration.ends.iter_mut().zip(chosen) {
            end.state.skipped_at = choice.or(end.state.skipped_at);
        }
        let called: Vec<Option<NodeId>> = self.exploration.ends.iter().map(|end| self.skipping_call(end)).collect();
        for (end, call) in self.exploration.ends.iter_mut().zip(called) {
            end.state.skipped_at = end.state.skipped_at.or(call);
        }
    }

    /// The helper that did not update, where nothing else decided a way: that of one element among many, whose round is over when the
    /// way goes on. Where the helper leaves it to its caller why, no later question in the loop may be the reason.
    fn skipping_call(&self, end: &End) -> Option<NodeId> {
        if end.state.skipped_at.is_some() || end.state.count != Count::Zero {
            return None;
        }
        let graph = self.search.graph;
        let updating = self.search.updating();
        let is_call = |id: &NodeId| matches!(graph.node(*id).effect, Effect::Call(_));
        let way = self.exploration.path(end.at);
        let nodes: Vec<NodeId> = way.iter().rev().map(|number| self.exploration.states[*number].node).collect();
        let called = nodes.iter().position(|id| is_call(id) && updating.contains(id))?;
        let over_all = graph.loops_around(nodes[called]).find(|id| self.search.covers(*id));
        let asks = |id: &NodeId| {
            matches!(graph.node(*id).effect, Effect::Branch(_))
                && over_all.is_none_or(|over_all| graph.is_within(graph.node(*id).in_loop, over_all))
        };
        (end.state.helper_gate.is_some() || (over_all.is_some() && !nodes[..called].iter().any(asks)))
            .then_some(nodes[called])
    }

    /// The condition behind the last value that a reference got on the way, if the way ends with an update of what it points to.
    fn choice(&self, end: &End) -> Option<NodeId> {
        let (graph, exploration) = (self.search.graph, &self.exploration);
        let at = end.state.skipped_at?;
        let places: Vec<&Place> = match &graph.node(at).effect {
            Effect::Update(update) => vec![&update.place],
            Effect::Call(site) => site.args.iter().filter_map(|arg| arg.place.as_ref()).collect(),
            _ => return None,
        };
        let way = exploration.path(end.at);
        let number = way.iter().rposition(|number| exploration.states[*number].node == at)?;
        let state = &exploration.states[way[number]];
        let is_elsewhere =
            |place: &&Place| self.relations(state, place).iter().all(|relation| *relation == Relation::Apart);
        if !places.iter().all(is_elsewhere) {
            return None;
        }
        let nodes: Vec<NodeId> = way[..number].iter().map(|number| exploration.states[*number].node).collect();
        let of_place = |place: &&Place| self.choice_of(&nodes, place.base_var()?);
        places.iter().filter(|place| self.search.may_be(place, true)).find_map(of_place)
    }

    fn choice_of(&self, nodes: &[NodeId], reference: Var) -> Option<NodeId> {
        let graph = self.search.graph;
        let mut asked = reference;
        let mut given = None;
        for (number, node) in nodes.iter().enumerate().rev() {
            let Effect::Set(set) = &graph.node(*node).effect else { continue };
            if set.place != Place::var(asked) {
                continue;
            }
            given = Some(number);
            match set.from.as_ref().and_then(Place::base_var) {
                Some(from) => asked = from,
                None => break,
            }
        }
        let given = given?;
        let deciding = self.search.dependence.of_node(nodes[given]);
        nodes[..given].iter().rev().copied().find(|node| deciding.contains(&node.0))
    }
}
