//! Counts that run once, of rounds or of what is left, or that are counted down by what may fail.

use super::{Gates, Way};
use crate::count::search::Region;
use crate::flow::{NodeId, Place, Test};

impl Gates<'_, '_> {
    /// A count that runs once, of rounds or of what is left.
    pub(super) fn is_warm_up(&self, test: &Test, at: NodeId, way: &Way) -> bool {
        self.is_first_rounds(test, at) || self.is_used_up_once(test, way)
    }

    /// `for i in 0.. { if i < 100 { continue; } … }`: the number of the round itself is asked, and the first ones are passed.
    fn is_first_rounds(&self, test: &Test, at: NodeId) -> bool {
        let graph = self.search.graph;
        let Region::Loop(own) = self.region else { return false };
        let info = graph.loop_info(own);
        let goes_up = !info.counts_down && !info.is_mirrored;
        let Some((counter, first)) = info.counter.filter(|_| goes_up) else { return false };
        let counter = Place::var(counter);
        let reads = &test.about.reads;
        if !reads.contains(&counter) || !reads.iter().all(|place| *place == counter || self.is_setting(place)) {
            return false;
        }
        if test.about.is_comparison {
            return self.waits_below(test, at, &counter) == Some(true);
        }
        let asks_first =
            matches!((test.about.heads.as_slice(), first), ([head], Some(first)) if *head == first.to_string());
        asks_first && graph.node(at).next.first().is_some_and(|next| !self.reach()[next.0 as usize])
    }

    /// `if let Some(left) = skip.checked_sub(1) { skip = left; continue; }`: it is counted down until nothing is left.
    fn is_used_up_once(&self, test: &Test, way: &Way) -> bool {
        self.is_counted_down(test, way, false)
    }

    /// The same for one that begins anew where nothing is left.
    pub(super) fn is_used_up_again(&self, test: &Test, way: &Way) -> bool {
        self.is_counted_down(test, way, true)
    }

    fn is_counted_down(&self, test: &Test, way: &Way, begins_anew: bool) -> bool {
        let about = &test.about;
        let ([place], [name], [left]) = (about.reads.as_slice(), about.names.as_slice(), about.binds.as_slice()) else {
            return false;
        };
        let left = Some(Place::var(*left));
        let counts = |id: NodeId| self.assigns(id, place) && self.search.graph.copied(id) == left;
        // `match tick.checked_add(1) { Some(next) => tick = next, None => { tick = 0; … } }`
        let is_step = name == "checked_sub" || begins_anew && name == "checked_add";
        about.is_presence
            && is_step
            && self.outlives(place)
            && self.assigning(place).any(|id| !counts(id)) == begins_anew
            && self.assigning(place).all(|id| counts(id) || self.is_set_back(id, place) && !way.nodes.contains(&id))
            && way.nodes.iter().any(|id| counts(*id))
            && !self.calls_write(place)
    }
}
