//! Instances that are only known by what refers to them: `self.active` is whatever that refers to. Another reference there is no reset, and
//! the one before is updated by that name no more.

use super::run::Run;
use super::{Region, Search, State};
use crate::count::counts::Count;
use crate::count::declared::declared_ty;
use crate::count::referred;
use crate::flow::{Assignment, Cause, Effect, NodeId, Place, Relation, Transfer, Var};

/// How many references are followed that lead to one another.
const MOST: usize = 8;

impl Search<'_> {
    /// The other places that a node gives another reference, where it does so through what refers to them: `*slot = Some(&mut lag)`; none
    /// if several may be meant.
    pub(super) fn led_to_by(&self, set: &Assignment, node: NodeId) -> Option<Vec<Place>> {
        if !self.graph.pointed.contains(&node) {
            return Some(Vec::new());
        }
        let mut found = Vec::new();
        let mut place = set.place.clone();
        loop {
            match referred::led_to(self.program.index, self.graph, &place).as_slice() {
                [] => return Some(found),
                [from] if !from.stands_for_several() && found.len() < MOST => place = from.clone(),
                _ => return None,
            }
            found.push(place.clone());
        }
    }

    /// Whether a place holds nothing but references to filters, if any.
    pub(super) fn refers(&self, place: &Place) -> bool {
        let ty = declared_ty(self.program.index, self.graph, place);
        ty.is_some_and(|ty| self.program.index.refers_to_filters(&ty))
    }

    /// Why what is given to a place may be the instance or not: it is one of several references, and data says which.
    pub(super) fn chosen_of(
        &self,
        names: &[Place],
        set: &Assignment,
        value: &dyn Fn(Var) -> Option<u64>,
    ) -> Option<Cause> {
        self.chosen_from(names, set.from.as_ref().filter(|_| set.transfer != Transfer::Copy)?, value)
    }

    /// The same of a place.
    pub(super) fn chosen_from(
        &self,
        names: &[Place],
        from: &Place,
        value: &dyn Fn(Var) -> Option<u64>,
    ) -> Option<Cause> {
        let is_reference =
            |name: &Place| name.base != self.instance.base && name.steps.iter().any(|step| step.key().is_some());
        let relation = |name: &Place| from.relate(name, value);
        let is_chosen = |name: &&Place| is_reference(name) && matches!(relation(name), Relation::MayHold(..));
        let is_told = names.iter().any(|name| matches!(relation(name), Relation::Holds(_)));
        (!is_told && names.iter().any(|name| is_chosen(&name)))
            .then(|| Cause::Index(self.graph.place_name(self.program.index, from)))
    }

    /// Why another reference may be in the place of one to the instance, or in that of another: data says which.
    pub(super) fn pointed_somewhere(
        &self,
        names: &[Place],
        set: &Assignment,
        node: NodeId,
        value: &dyn Fn(Var) -> Option<u64>,
    ) -> Option<Cause> {
        let may_hold = |name: &Place| matches!(set.place.relate(name, value), Relation::MayHold(..));
        let is_some = self.graph.pointed.contains(&node) && names.iter().any(may_hold);
        let holds = |name: &Place| set.place.relate(name, value) != Relation::Apart;
        let holds_given =
            |name: &Place| set.from.as_ref().is_some_and(|from| from.relate(name, value) != Relation::Apart);
        let is_any =
            || self.led_to_by(set, node).is_none() && names.iter().any(|name| holds(name) || holds_given(name));
        (is_some || is_any()).then(|| Cause::Index(self.graph.place_name(self.program.index, &set.place)))
    }

    /// Whether a node gives what refers to the instance another reference.
    fn points_elsewhere(&self, node: NodeId, set: &Assignment) -> bool {
        self.graph.pointed.contains(&node) && matches!(set.place.relate(self.instance, &|_| None), Relation::Holds(_))
    }

    /// The names before a cycle begins: what the instance's own name refers to by then is the instance.
    pub(super) fn pointed_before(&self, names: &[Place], set: &Assignment, node: NodeId) -> Vec<Place> {
        let mut renamed = self.renamed(names, set, node, &|_| None).0;
        if names.contains(self.instance) && !renamed.contains(self.instance) && self.points_elsewhere(node, set) {
            renamed.push(self.instance.clone());
            renamed.sort();
        }
        renamed
    }

    /// Whether some node does so.
    fn is_pointed_elsewhere(&self) -> bool {
        self.graph.pointed.iter().any(|id| match &self.graph.node(*id).effect {
            Effect::Set(set) | Effect::Write(set) => self.points_elsewhere(*id, set),
            _ => false,
        })
    }
}

impl Run<'_, '_> {
    /// Why the instance may be updated all the same where what refers to it refers to another one from here on:
    /// `loop { self.active = self.pool.next(); self.active.update(); }`
    pub(super) fn gone_from(&self, state: &State, set: &Assignment, renamed: &[Place]) -> Option<Cause> {
        let search = self.search;
        let is_gone = renamed.is_empty() && self.names.get(state.names).contains(search.instance);
        // Where there was none, or nothing would have updated it any more, nothing is lost.
        let is_open = state.count == Count::Zero && !state.reset && state.skipped_at.is_none();
        let is_cycle = self.region != Region::Function && is_open;
        (is_gone && is_cycle && search.points_elsewhere(state.node, set)).then(|| {
            let name = search.graph.place_name(search.program.index, search.instance);
            Cause::Code(format!("what `{name}` refers to"))
        })
    }

    /// The names with which the next iteration begins: the instance's own is that of whatever it refers to by then.
    pub(super) fn names_in_next(&mut self, names: u32) -> u32 {
        if !self.names.get(names).is_empty() || !self.search.is_pointed_elsewhere() {
            return names;
        }
        self.names.intern(vec![self.search.instance.clone()])
    }
}
