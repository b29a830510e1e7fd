//! Filters that go along with a state which is given on by value: `state = match state { Idle(filter) if go => Run(filter), … }`.
//! Of the variants between which a filter goes back and forth one is there at a time, and what lies in it is the same filter.

use super::{Region, Search};
use crate::count::instances::place_ty;
use crate::count::moves;
use crate::flow::{Effect, NodeId, Place, Projection};
use crate::index::{Shape, Ty};

impl Search<'_> {
    /// The places of the instance in other variants of the value that it lies in.
    pub(in crate::count) fn homes(&self) -> &[Place] {
        self.homes.get_or_init(|| {
            let owners: Vec<usize> = (0..self.instance.steps.len()).filter(|at| self.is_variant(*at)).collect();
            if owners.is_empty() {
                return Vec::new();
            }
            let is_beside = |place: &&Place| {
                place.base == self.instance.base
                    && owners.iter().any(|at| {
                        place.steps.get(..*at) == self.instance.steps.get(..*at)
                            && place.steps.get(*at).is_some_and(|step| *step != self.instance.steps[*at])
                    })
            };
            let reached = moves::reached(self.graph, self.summaries, self.instance, true);
            let beside = reached.iter().filter(is_beside);
            let comes_back =
                |place: &&Place| moves::reached(self.graph, self.summaries, place, true).contains(self.instance);
            beside.filter(comes_back).cloned().collect()
        })
    }

    /// Whether a function that takes the value as a whole runs the updates, so that it is not told in which variant the filter was.
    pub(in crate::count) fn is_chosen_by_callee(&self) -> bool {
        let holds = |root: &Place| {
            let is_in = |place: &Place| place.lies_at(root);
            is_in(self.instance) && self.homes().iter().all(is_in)
        };
        let takes_whole = |node: NodeId| match &self.graph.node(node).effect {
            Effect::Call(site) => {
                let moved = site.args.iter().filter(|arg| arg.is_moved).filter_map(|arg| arg.place.as_ref());
                moved.into_iter().any(|place| self.aliases.shared_roots(place).iter().any(holds))
            }
            _ => false,
        };
        !self.homes().is_empty() && self.updating().into_iter().any(takes_whole)
    }

    /// Whether the instance may be put in another place that lasts, and come back from there as it was.
    pub(in crate::count) fn is_parked(&self, region: Region) -> bool {
        let is_elsewhere = |place: &&Place| {
            self.outlives(region, place) && !place.overlaps(self.instance) && !self.homes().contains(place)
        };
        // What changes places is judged where it is at the beginning.
        let reached = |place: &Place| moves::reached(self.graph, self.summaries, place, false);
        reached(self.instance).iter().filter(is_elsewhere).any(|place| reached(place).contains(self.instance))
    }

    /// Whether a step of the instance's place names a variant.
    fn is_variant(&self, at: usize) -> bool {
        let owner = self.instance.up_to(at);
        matches!(self.instance.steps[at], Projection::Field(_))
            && matches!(place_ty(self.program.index, self.graph, &owner), Some(Ty::Adt(id, _))
                if matches!(self.program.index.type_def(id).shape, Shape::Enum(_)))
    }
}
