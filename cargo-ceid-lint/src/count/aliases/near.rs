//! What calls and nodes have to do with the places of a function, found once for all who ask.

use std::collections::BTreeSet;
use std::sync::Arc;

use rustc_hash::FxHashMap;

use super::{Aliases, Roots};
use crate::count::called_place::CalledPlace;
use crate::count::given::place_of;
use crate::count::search::Called;
use crate::count::summary::Summaries;
use crate::flow::{Base, CallSite, ControlFlowGraph, Effect, NodeId, Place};

impl Aliases {
    /// The places that the targets of a call have ways for, by target: each search asks for them anew.
    pub(in crate::count) fn called_places(&self, site: &CallSite, summaries: &Summaries) -> Arc<[CalledPlace]> {
        if let Some(known) = self.calls.borrow().get(&site.result) {
            return Arc::clone(known);
        }
        let mut places = Vec::new();
        for (target, summary) in site.targets.iter().filter_map(|target| Some((*target, summaries.get(*target)?))) {
            for law in 0..summary.laws() {
                for (number, (given, outcomes)) in summary.outcomes(law).enumerate() {
                    if summary.only_points(given, outcomes, site) {
                        continue;
                    }
                    if let Some(place) = place_of(given, site) {
                        let taken = summary.taken.get(given).and_then(|taken| place_of(taken, site));
                        let taken = taken.map(|taken| self.shared_roots(&taken).to_vec()).unwrap_or_default();
                        let others = match self.shared_roots(&place) {
                            Roots::Itself(_) => None,
                            Roots::Others(others) => Some(others),
                        };
                        places.push(CalledPlace { target, law, number, place, others, taken });
                    }
                }
            }
        }
        let places: Arc<[CalledPlace]> = places.into();
        self.calls.borrow_mut().insert(site.result, Arc::clone(&places));
        places
    }

    /// The nodes at which something happens to what a base has, under whatever name, in their order: the others need not be
    /// looked at.
    pub(in crate::count) fn near<'a>(
        &'a self,
        graph: &ControlFlowGraph,
        summaries: &Summaries,
        base: Base,
    ) -> &'a [NodeId] {
        let find = || {
            let mut near: FxHashMap<Base, Vec<NodeId>> = FxHashMap::default();
            for id in graph.node_ids() {
                let mut bases = BTreeSet::new();
                let mut add = |place: &Place| bases.extend(self.shared_roots(place).iter().map(|root| root.base));
                match &graph.node(id).effect {
                    Effect::Update(update) => add(&update.place),
                    Effect::Advance(advance) => add(&advance.before),
                    Effect::Reset { place, .. } => add(place),
                    Effect::Unknown { places, .. } => places.iter().for_each(add),
                    Effect::Set(set) | Effect::Write(set) => {
                        add(&set.place);
                        set.from.iter().for_each(add);
                    }
                    Effect::Call(site) => {
                        let called = self.called_places(site, summaries);
                        bases.extend(called.iter().flat_map(CalledPlace::roots).map(|root| root.base));
                    }
                    _ => {}
                }
                for base in bases {
                    near.entry(base).or_default().push(id);
                }
            }
            near
        };
        self.near.get_or_init(find).get(&base).map_or(&[], Vec::as_slice)
    }

    /// What a call means to an instance that it has nothing to do with: each search asks for that anew.
    pub(in crate::count) fn call_beside(&self, site: &CallSite, find: impl FnOnce() -> Called) -> Arc<Called> {
        if let Some(known) = self.beside.borrow().get(&site.result) {
            return Arc::clone(known);
        }
        let called = Arc::new(find());
        self.beside.borrow_mut().insert(site.result, Arc::clone(&called));
        called
    }
}
