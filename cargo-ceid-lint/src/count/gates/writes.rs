//! What the calls of an iteration write.

use super::Gates;
use crate::flow::{CallSite, Effect, NodeId, Place};

impl Gates<'_, '_> {
    /// Whether a call in the region writes a place.
    pub(super) fn calls_write(&self, place: &Place) -> bool {
        let written = self.written.get_or_init(|| {
            let of = |id: NodeId| match &self.search.graph.node(id).effect {
                Effect::Call(site) => self.written_by(site).collect(),
                Effect::Unknown { places, .. } => places.clone(),
                _ => Vec::new(),
            };
            // What is written by another name is written.
            let with_roots = |place: Place| [self.search.aliases.shared_roots(&place).to_vec(), vec![place]].concat();
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
