//! Steps that are gathered while the filter pauses: `elapsed += dt; if is_due { filter.update(x, elapsed); elapsed = 0.0; }`.
//! The next step covers the gap, whatever the clock does in between.

use super::{Gates, Way};
use crate::config::TimeBase;
use crate::count::fed::named;
use crate::flow::{ChangeKind, Effect, NodeId, Place};

/// How many names are followed from the argument of a law to the sum that it is.
const MAX_NAMES: u32 = 4;

impl Gates<'_, '_> {
    /// Whether the way adds to the sum that the filter's step is wherever the clock goes on, and takes nothing away from it.
    pub(super) fn gathers_step(&self, way: &Way) -> bool {
        if self.time_base() != TimeBase::Passed {
            return false;
        }
        let sums = self.sums_for_step();
        let is_kept = |sum: &Place| {
            let on_way: Vec<NodeId> = self.assigning(sum).filter(|id| way.nodes.contains(id)).collect();
            !on_way.is_empty() && on_way.into_iter().all(|id| self.adds(id)) && !self.is_written_in_calls(sum, way)
        };
        !sums.is_empty() && sums.iter().all(is_kept)
    }

    /// The sums that the steps of all updates are.
    fn sums_for_step(&self) -> Vec<Place> {
        let mut sums: Vec<Place> = Vec::new();
        for id in self.nodes() {
            let Effect::Call(site) = &self.search.graph.node(id).effect else { continue };
            if !self.concerns(site) {
                continue;
            }
            for (number, arg) in site.args.iter().enumerate().filter(|(number, _)| self.takes_step(site, *number)) {
                let [only] = named(&arg.from.places)[..] else { return Vec::new() };
                match self.sum_behind(only) {
                    Some(sum) if number > 0 => sums.extend((!sums.contains(&sum)).then_some(sum)),
                    _ => return Vec::new(),
                }
            }
        }
        sums
    }

    /// The sum that a place is, or was copied from in the iteration: something is added to it, and it is set back.
    fn sum_behind(&self, place: &Place) -> Option<Place> {
        let graph = self.search.graph;
        let mut at = place.clone();
        for _ in 0..MAX_NAMES {
            if self.outlives(&at) {
                break;
            }
            let computed = at.base_var().filter(|_| at.steps.is_empty()).and_then(|var| graph.computed.get(&var))?;
            let [from] = named(&computed.places)[..] else { return None };
            at = from.clone();
        }
        let (adding, others): (Vec<NodeId>, Vec<NodeId>) = self.assigning(&at).partition(|id| self.adds(*id));
        let is_set_back = |id: &NodeId| match &graph.node(*id).effect {
            Effect::Write(write) | Effect::Set(write) => {
                write.head.as_deref().and_then(|head| head.parse::<f64>().ok()) == Some(0.0)
                    || graph.changes.get(id).is_some_and(|change| change.kind == ChangeKind::Constant)
            }
            _ => false,
        };
        let is_sum = self.outlives(&at) && !adding.is_empty() && !others.is_empty() && others.iter().all(is_set_back);
        is_sum.then_some(at)
    }

    fn adds(&self, id: NodeId) -> bool {
        self.search.graph.changes.get(&id).is_some_and(|change| change.kind == ChangeKind::Accumulates)
    }

    /// Whether something that the way calls writes a place.
    fn is_written_in_calls(&self, place: &Place, way: &Way) -> bool {
        way.nodes.iter().any(|id| match &self.search.graph.node(*id).effect {
            Effect::Call(site) => self.call_writes(site, place),
            Effect::Unknown { places, .. } => places.iter().any(|other| other.overlaps(place)),
            _ => false,
        })
    }
}
