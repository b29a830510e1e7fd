//! Counters and times by which a helper knows when it is due: what it left in them must still be there when it is called again.

use std::collections::BTreeSet;

use super::rate::COUNTERS;
use super::{Gates, Way, contains_any};
use crate::count::given::{Given, given, place_of};
use crate::count::outcome::Outcome;
use crate::count::search::{End, Exploration};
use crate::count::verdict::Gate;
use crate::flow::{CallSite, ChangeKind, Computed, Effect, Head, NodeId, Place};

impl Gates<'_, '_> {
    /// What a helper keeps from call to call in the places of its callers for a gate of rate or time, itself or by what it calls.
    pub(in crate::count) fn recalled(&self, exploration: &Exploration, end: &End, gate: Option<Gate>) -> Vec<Given> {
        let graph = self.search.graph;
        let Some(at) = end.state.skipped_at.filter(|_| matches!(gate, Some(Gate::Rate | Gate::Time))) else {
            return Vec::new();
        };
        match &graph.node(at).effect {
            Effect::Branch(test) => {
                let way = Way::to(exploration, end, at);
                let origin = self.origin(test, at, &way).map_or(test, |(origin, ..)| origin);
                let asked = self.behind(origin).places.into_iter();
                let kept = asked.filter(|place| self.outlives(place) && self.assigning(place).next().is_some());
                kept.filter_map(|place| given(graph, &place)).collect()
            }
            Effect::Call(site) => {
                let inner: BTreeSet<&Given> = self.recalled_by(site, gate).collect();
                inner.into_iter().filter_map(|inner| given(graph, &place_of(inner, site)?)).collect()
            }
            _ => Vec::new(),
        }
    }

    fn recalled_by<'b>(&'b self, site: &'b CallSite, gate: Option<Gate>) -> impl Iterator<Item = &'b Given> {
        let summaries = site.targets.iter().filter_map(|target| self.search.summaries.get(*target));
        let outcomes = summaries.flat_map(|summary| summary.outcomes(self.search.law));
        let own = outcomes.filter(|(given, _)| place_of(given, site).is_some_and(|place| self.is_instance(&place)));
        let ways = own.flat_map(|(_, ways)| ways).filter(move |way: &&Outcome| way.gate == gate);
        ways.flat_map(|way| &way.recalled)
    }

    /// Whether what a helper left in its counters and times for this gate can still be there when the cycle calls it again.
    pub(super) fn leaves_recalled(&self, site: &CallSite, at: NodeId, gate: Option<Gate>) -> bool {
        let places: BTreeSet<Place> = self.recalled_by(site, gate).filter_map(|given| place_of(given, site)).collect();
        places.iter().all(|place| self.is_carried(at, |node| self.gives_anew(node, place)))
    }

    /// Whether a value that is there at a node can be there when an iteration comes to the node again: not each of them gives another
    /// one in between.
    fn is_carried(&self, at: NodeId, gives: impl Fn(NodeId) -> bool) -> bool {
        let stays = |node: NodeId, _: usize| node == at || !gives(node);
        let goes_on = self.search.graph.node(at).next.iter().any(|next| self.completes(*next, stays));
        goes_on && self.reached(stays)[at.0 as usize]
    }

    /// Whether a counter is set back where it was found to have run out, here or in a call, not only where something else happens.
    pub(super) fn runs_out(&self, place: &Place) -> bool {
        let before = self.before_asking(place);
        let is_set_back = |id: NodeId| match &self.search.graph.node(id).effect {
            Effect::Call(site) => {
                let is_constant = |(head, change): (&Option<Head>, _)| head.is_some() || change == ChangeKind::Constant;
                self.sets_by(site, place).any(is_constant)
            }
            _ => self.assigns(id, place) && self.is_set_back(id, place),
        };
        self.nodes().any(|id| !before[id.0 as usize] && is_set_back(id) && !self.names_element(id))
    }

    /// Whether each iteration sets a number back, so that it never counts.
    pub(super) fn is_always_set_back(&self, place: &Place, at: NodeId) -> bool {
        self.assigning(place).any(|id| self.is_set_back(id, place))
            && !self.is_carried(at, |node| self.is_set_back(node, place))
    }

    /// Whether a number that is asked for at a node counts, or comes from what counts; a reading or a constant does not.
    pub(super) fn is_counted_to(&self, place: &Place, at: NodeId) -> bool {
        let computed = Computed { places: vec![place.clone()], calls: Vec::new() };
        let calls = self.assignments().behind(&computed).calls;
        let is_told = |name: &String| contains_any(name, COUNTERS) || name.starts_with("fetch_");
        !self.is_always_set_back(place, at) && !self.is_given_anew(place, at)
            || calls.iter().any(is_told)
            || contains_any(&self.last_name(place), COUNTERS) && !calls.is_empty()
    }

    /// Whether a node surely gives a place a value that has nothing to do with the one before.
    fn gives_anew(&self, node: NodeId, place: &Place) -> bool {
        let graph = self.search.graph;
        match &graph.node(node).effect {
            Effect::Write(write) | Effect::Set(write) if write.place == *place && !self.names_element(node) => {
                match graph.changes.get(&node) {
                    Some(change) => {
                        let is_new = matches!(change.kind, ChangeKind::Constant | ChangeKind::Other);
                        is_new && !change.computed.places.iter().any(|from| from.overlaps(place))
                    }
                    None => write.head.is_some(),
                }
            }
            Effect::Call(site) => {
                let [target] = site.targets.as_slice() else { return false };
                let heads = self.search.summaries.get(*target).into_iter().flat_map(|summary| &summary.given_heads);
                let mut surely = heads.filter(|(_, heads)| heads.surely);
                surely.any(|(given, _)| place_of(given, site).as_ref() == Some(place))
            }
            _ => false,
        }
    }
}
