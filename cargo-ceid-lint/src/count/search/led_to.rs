//! Collections whose elements are references: several of them may lead to one filter.

use std::collections::{BTreeMap, BTreeSet};

use super::Search;
use crate::count::declared::declared_ty;
use crate::flow::{Base, Effect, IndexKey, NodeId, Place, Projection, Var};
use crate::index::Ty;

impl Search<'_> {
    /// Whether something updates the instance through each of the elements of a collection that does not hold it, several of which may
    /// lead to it: `for port in [&bus, &bus] { port.borrow_mut().update(); }`
    pub(in crate::count) fn is_led_to_by_elements(&self) -> bool {
        let is_some = |key: &IndexKey| !matches!(key, IndexKey::Number(_) | IndexKey::Named(_) | IndexKey::Literal(_));
        let is_each = |node: NodeId, place: &Place| {
            let is_item = || self.graph.loops_around(node).any(|id| !self.graph.loop_info(id).items.is_empty());
            place.base != self.instance.base
                && (place.steps.iter().filter_map(Projection::key).any(is_some) || is_item())
                && self.may_be(place, true)
        };
        let is_through_each = self.updating().into_iter().any(|node| match &self.graph.node(node).effect {
            Effect::Update(update) => is_each(node, &update.place),
            Effect::Call(site) => self.summaries.updates(site).any(|place| is_each(node, &place)),
            _ => false,
        });
        is_through_each && self.has_several_elements()
    }

    /// Whether a value is a name of the instance, or something in it is.
    fn is_part_led_to(&self, from: &Place) -> bool {
        self.aliases.parts(from).iter().any(|(_, root)| self.is_among(std::slice::from_ref(root), false))
    }

    /// Whether the instance is what the shared references in a collection of this function lead to, or in the elements of one, so that
    /// two of them may lead to one filter: `let users: Vec<&Chip> = (0..2).map(|_| &chip).collect();`
    pub(in crate::count) fn is_behind_shared_references(&self) -> bool {
        let place = self.instance;
        let is_own = place.base_var().is_some_and(|var| self.graph.var(var).param.is_none());
        let first = place.steps.iter().position(|step| step.key().is_some()).filter(|_| is_own);
        let is_shared = |at: usize| {
            let part = place.up_to(at + 1);
            matches!(declared_ty(self.program.index, self.graph, &part), Some(Ty::Ref(false, _)))
        };
        first.is_some_and(|first| (first..place.steps.len()).any(is_shared))
    }

    /// Whether elements that lead to the instance are put into a collection at several places, or in the rounds of a loop that is
    /// no other one's for each of them: `for _ in 0..n { ports.push(&bus); }`
    fn is_put_several_times(&self) -> bool {
        let graph = self.graph;
        let mut collections: BTreeMap<Place, usize> = BTreeMap::new();
        for id in graph.node_ids() {
            let (Effect::Set(set) | Effect::Write(set)) = &graph.node(id).effect else { continue };
            let key = set.place.steps.iter().position(|step| matches!(step.key(), Some(IndexKey::Data(_))));
            let (Some(at), Some(from), Some(var)) = (key, &set.from, set.place.base_var()) else { continue };
            if Base::Var(var) == self.instance.base || !self.is_part_led_to(from) || self.is_put_back(id, var) {
                continue;
            }
            let is_again =
                graph.loops_around(id).any(|id| !graph.is_within(graph.var(var).in_loop, id) && !self.covers(id));
            let collection = set.place.up_to(at);
            *collections.entry(collection).or_default() += if is_again { 2 } else { 1 };
        }
        collections.into_values().any(|times| times > 1)
    }

    /// Whether a node puts into a collection what was taken out of it as a whole: in another order, its elements are there once.
    fn is_put_back(&self, node: NodeId, collection: Var) -> bool {
        let mut around = self.graph.loops_around(node).flat_map(|id| &self.graph.loop_info(id).items);
        around.any(|(_, source)| self.comes_from(source, collection))
    }

    /// Whether a place holds, without a name, what was taken out of a collection.
    fn comes_from(&self, place: &Place, collection: Var) -> bool {
        let mut seen: BTreeSet<Var> = BTreeSet::new();
        let mut open: Vec<Var> = place.base_var().into_iter().collect();
        while let Some(taken) = open.pop() {
            if !self.graph.var(taken).name.is_empty() || !seen.insert(taken) {
                continue;
            }
            let given = self.aliases.given().filter(|(var, _)| *var == taken).flat_map(|(_, given)| given);
            let from: Vec<Var> = given.filter_map(|(_, from)| from.base_var()).collect();
            if from.contains(&collection) {
                return true;
            }
            open.extend(from);
        }
        false
    }

    /// Whether several elements of a collection, or each of them, are names of the instance.
    fn has_several_elements(&self) -> bool {
        // What changes places in the collection that holds it is still there once.
        let is_other = |(var, _): &(Var, &[_])| Base::Var(*var) != self.instance.base;
        self.is_put_several_times()
            || self.aliases.given().filter(is_other).any(|(var, given)| {
                let is_new = |from: &Place| from.base != Base::Var(var) && !self.comes_from(from, var);
                let of_instance = given.iter().filter(|(_, from)| is_new(from) && self.is_part_led_to(from));
                let keys: BTreeSet<&IndexKey> =
                    of_instance.filter_map(|(steps, _)| steps.iter().find_map(Projection::key)).collect();
                keys.len() > 1 || keys.contains(&IndexKey::Each)
            })
    }
}
