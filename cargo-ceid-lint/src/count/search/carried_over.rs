//! Whether a filter gets its own state back from where that was kept.

use std::collections::BTreeSet;

use super::run::Run;
use super::{Region, Search};
use crate::count::carried_over::{copies, is_back};
use crate::flow::{Assignment, Place};

impl Run<'_, '_> {
    /// Whether what the instance's place gets is what was there before, or a copy of it.
    pub(super) fn is_carried_over(&self, set: &Assignment) -> bool {
        let copies = || self.copies_of.get_or_init(|| self.search.copies(self.region));
        is_back(self.search.aliases, self.search.instance, set, |part| copies().contains(part))
    }
}

impl Search<'_> {
    /// The same for a region, once.
    pub(in crate::count) fn is_carried_over(&self, region: Region, set: &Assignment) -> bool {
        is_back(self.aliases, self.instance, set, |part| self.copies(region).contains(part))
    }

    /// Where the instance or a copy of it may lie in a region.
    pub(in crate::count) fn copies(&self, region: Region) -> BTreeSet<Place> {
        let within = match region {
            Region::Loop(id) => Some(id),
            Region::Function => None,
        };
        copies(self.graph, self.summaries, self.instance, within)
    }
}
