//! Whether a filter gets its own state back from where that was kept.

use std::collections::BTreeSet;
use std::rc::Rc;

use super::{Region, Search};
use crate::count::carried_over::{copies, is_back};
use crate::flow::{Assignment, Place};

impl Search<'_> {
    /// Whether what the instance's place gets in a region is what was there before, or a copy of it.
    pub(in crate::count) fn is_carried_over(&self, region: Region, set: &Assignment) -> bool {
        is_back(self.aliases, self.instance, set, |part| self.copies(region).contains(part))
    }

    /// Where the instance or a copy of it may lie in a region.
    pub(in crate::count) fn copies(&self, region: Region) -> Rc<BTreeSet<Place>> {
        let within = match region {
            Region::Loop(id) => Some(id),
            Region::Function => None,
        };
        let find = || Rc::new(copies(self.graph, self.summaries, self.instance, within));
        Rc::clone(self.copies.borrow_mut().entry(region).or_insert_with(find))
    }
}
