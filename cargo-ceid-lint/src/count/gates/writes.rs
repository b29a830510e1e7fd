//! What the calls of an iteration write.

use super::Gates;
use crate::flow::{CallSite, Effect, NodeId, Place};
use crate::index::Ty;

impl Gates<'_, '_> {
    /// Whether a call in the region writes a place.
    pub(super) fn calls_write(&self, place: &Place) -> bool {
        let written = self.written.get_or_init(|| {
            let of = |id: NodeId| match &self.search.graph.node(id).effect {
                Effect::Call(site) => self.written_by(site).collect(),
                Effect::Unknown { places, .. } => places.clone(),
                _ => Vec::new(),
            };
            // What updates a filter by another name changes what it shows, and not whether it is there.
            let index = self.search.program.index;
            let is_of_filter = |root: &&Place| {
                let owners = (0..=root.steps.len())
                    .map(|count| Place { base: root.base, steps: root.steps[..count].to_vec() })
                    .filter_map(|owner| self.ty(&owner));
                let is_filter = |ty: &Ty| index.filter_spec(ty).is_some();
                let known: Vec<Ty> =
                    owners.map(|ty| ty.peel().clone()).take_while(|ty| matches!(ty, Ty::Adt(..))).collect();
                root.steps.iter().all(|step| step.key().is_none()) && known.iter().any(is_filter)
            };
            let with_roots = |place: Place| {
                let roots = self.search.aliases.shared_roots(&place);
                let others: Vec<Place> = roots.iter().filter(is_of_filter).cloned().collect();
                [others, vec![place]].concat()
            };
            self.nodes().flat_map(of).flat_map(with_roots).collect()
        });
        written.iter().any(|other| other.overlaps(place))
    }

    pub(super) fn call_writes(&self, site: &CallSite, place: &Place) -> bool {
        self.written_by(site).any(|written| written.overlaps(place))
    }

    /// The places that a call writes.
    pub(super) fn written_by<'b>(&'b self, site: &'b CallSite) -> impl Iterator<Item = Place> + 'b {
        self.search.summaries.places(site, |summary| &summary.writes)
    }
}
