//! Elements that change places within their collection: what is so of each of them is so in any order, unless a loop is going over
//! them.

use std::borrow::Cow;

use super::run::Run;
use super::{Region, State};
use crate::count::outcome::Outcome;
use crate::flow::{Cause, Place, Projection};

impl Run<'_, '_> {
    /// Whether the instance is each of the elements that have got another order, and nothing is said of one of them alone.
    pub(super) fn has_no_order(&self, state: &State, place: &Place) -> bool {
        self.names.get(state.names).iter().any(Place::has_no_order) && !self.is_amid_pass(state, place)
    }

    /// The ways through a function that puts elements in another order, where that says nothing of the instance.
    pub(super) fn in_any_order<'a>(&self, state: &State, place: &Place, outcomes: &'a [Outcome]) -> Cow<'a, [Outcome]> {
        if !outcomes.iter().any(Outcome::is_reordered) || !self.has_no_order(state, place) {
            return Cow::Borrowed(outcomes);
        }
        let mut settled = outcomes.to_vec();
        for outcome in settled.iter_mut().filter(|outcome| outcome.is_reordered()) {
            outcome.unknown = None;
        }
        Cow::Owned(settled)
    }

    /// Whether a loop that goes over the elements of the same collection has a round in which they get another order: one that it has
    /// updated may come again then, and one that it has not may be left out.
    fn is_amid_pass(&self, state: &State, place: &Place) -> bool {
        let graph = self.search.graph;
        let own = |id| self.region == Region::Loop(id);
        // A loop that takes elements out of what it goes over knows where the others go.
        let takes_out = |id| {
            let pool = graph.loop_info(id).takes_out.as_ref();
            pool.is_some_and(|pool| {
                pool.base == place.base && place.steps.split_last().map(|(_, rest)| rest) == Some(&pool.steps)
            })
        };
        let around: Vec<_> =
            graph.loops_around(state.node).take_while(|id| !own(*id)).filter(|id| !takes_out(*id)).collect();
        // Each collection around has a loop of its own that goes over it.
        let roots = self.search.aliases.shared_roots(place);
        let collections = |root: &Place| root.steps.iter().filter_map(Projection::key).count();
        let collections = roots.iter().map(collections).min().unwrap_or(1).max(1);
        self.search.updating().into_iter().any(|update| {
            let update = graph.node(update).in_loop;
            around.iter().filter(|id| graph.is_within(update, **id)).count() >= collections
        })
    }
}

impl Outcome {
    /// Whether a function puts it in another order, and does nothing else that is not known.
    pub(super) fn is_reordered(&self) -> bool {
        self.unknown.as_ref().is_some_and(Cause::is_order)
    }
}
