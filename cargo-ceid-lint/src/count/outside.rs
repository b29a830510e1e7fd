//! Filters that are updated, but in no cycle: before the loop or behind it.

use std::collections::BTreeMap;

use super::analyse::{Context, CycleId, FunctionFacts};
use super::counts::Count;
use super::cycles::Instance;
use super::given::{Given, place_of};
use super::search::Region;
use super::verdict::{Pair, Verdict};
use crate::flow::{Effect, LoopId, NodeId, Place, Rounds};

impl Context<'_> {
    /// An instance that is updated, but in no cycle, is owed an update by the cycle that uses it, or that updates a sibling.
    pub(super) fn owed_after_all(
        &self,
        facts: &FunctionFacts<'_>,
        place: &Place,
        pairs: &mut BTreeMap<CycleId, Vec<Pair>>,
    ) {
        let graph = facts.graph;
        let is_in_cycle = facts
            .updated
            .iter()
            .any(|instance| instance.place.overlaps(place) && (!instance.loops.is_empty() || instance.function));
        let elsewhere = !self.fields.laws(self.program.index, graph, place).is_empty();
        if is_in_cycle || elsewhere || self.is_updated_in_loop_of_callee(facts, place) {
            return;
        }
        // What is made inside the iteration owes nothing.
        let is_outside = |id: LoopId| {
            let declared = place.base_var().and_then(|var| graph.var(var).in_loop);
            declared.is_none_or(|declared| declared != id && graph.is_within(Some(id), declared))
        };
        // Nor does what only waits until it can be updated.
        let waits = |id: LoopId| {
            let mut own = facts.updated.iter().filter(|instance| instance.place.overlaps(place));
            own.any(|instance| instance.waits.contains(&id))
        };
        let owes = |id: &LoopId| is_outside(*id) && !waits(*id);
        let using = self.using_loop(facts, place).filter(owes);
        let owing = using.or_else(|| self.loop_beside(facts, place, pairs).filter(owes));
        if let Some(id) = owing.filter(|id| !is_given_before(facts, place, *id)) {
            self.push_missed(facts, place, 0, CycleId::Loop(id), pairs);
        }
    }

    /// The loop that updates a sibling of an instance that itself is updated at one point only, before that loop or behind it:
    /// one step is no use of a filter, whereas several of them in a row may be a calibration that is written out.
    fn loop_beside(
        &self,
        facts: &FunctionFacts<'_>,
        place: &Place,
        pairs: &BTreeMap<CycleId, Vec<Pair>>,
    ) -> Option<LoopId> {
        let graph = facts.graph;
        let var = place.base_var()?;
        let is_param = graph.var(var).param.is_some();
        // Callers may do with what they lend whatever they like, as often as they like.
        let is_lent =
            is_param && (facts.is_in_cycle || super::fields::field_key(self.program.index, graph, place).is_none());
        let own: Vec<&Instance> = facts.updated.iter().filter(|instance| instance.place == *place).collect();
        let [instance] = own.as_slice() else { return None };
        let search = self.search(facts, instance);
        let updating = search.updating();
        let update = updating.first().filter(|_| updating.len() == 1 && search.unknown().is_empty())?;
        let uses = self.uses(facts, place);
        let span = graph.node(*update).span;
        let is_shown =
            graph.node_ids().any(|id| !span.contains(graph.node(id).span) && self.node_uses(facts, id, place));
        if is_lent || uses.leaves || uses.copied || uses.written || is_shown {
            return None;
        }
        let leads = |from, to: NodeId| search.reached_from(Region::Function, from, |_, _| true)[to.0 as usize];
        pairs.iter().find_map(|(id, filters)| {
            let CycleId::Loop(at) = *id else { return None };
            let info = graph.loop_info(at);
            let is_on_way = leads(*update, info.head) || leads(info.head, *update);
            let owes = info.rounds == Rounds::Unbounded
                && !info.is_foreign
                && is_on_way
                && self.is_declared_before(graph, var, at)
                && filters.iter().any(|pair| pair.verdict != Verdict::Missed)
                && self.is_sibling(facts, place, *id);
            owes.then_some(at)
        })
    }

    /// Whether a function that is called updates an instance in a loop of its own: `calibrate(&mut gyro);`
    fn is_updated_in_loop_of_callee(&self, facts: &FunctionFacts<'_>, place: &Place) -> bool {
        let is_it = |other: &Place| facts.aliases.shared_roots(other).iter().any(|root| root.overlaps(place));
        facts.graph.nodes.iter().any(|node| {
            let Effect::Call(site) = &node.effect else { return false };
            let mut callees = site.targets.iter().filter_map(|target| self.summaries.get(*target));
            callees.any(|callee| {
                let is_cycle = |given: &Given, count: Count| match count {
                    Count::Zero | Count::One => false,
                    Count::PerSample => true,
                    Count::Many => callee.looped.contains(given),
                };
                callee.all_outcomes().any(|(given, outcomes)| {
                    outcomes.iter().any(|outcome| is_cycle(given, outcome.count))
                        && place_of(given, site).is_some_and(|place| is_it(&place))
                })
            })
        })
    }
}

/// Whether what holds an instance is given to something else for good before a loop begins: what the loop still reads is a part of
/// it that others have as well.
fn is_given_before(facts: &FunctionFacts<'_>, place: &Place, id: LoopId) -> bool {
    let graph = facts.graph;
    let holds = |given: &Place| {
        let roots = facts.aliases.shared_roots(given);
        roots.iter().any(|root| place.lies_at(root))
    };
    let is_given = |node: NodeId| match &graph.node(node).effect {
        Effect::Call(site) => {
            site.args.iter().filter(|arg| arg.is_moved).filter_map(|arg| arg.place.as_ref()).any(holds)
        }
        _ => graph.given_away.iter().any(|(at, given)| *at == node && holds(given)),
    };
    graph.node_ids().take_while(|node| *node < graph.loop_info(id).head).any(is_given)
}
