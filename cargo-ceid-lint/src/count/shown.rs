//! What a reader is shown of a function that is called.

use std::collections::BTreeMap;

use super::given::Given;
use super::verdict::Evidence;

/// What a reader is shown of filters, with the half of the law. It decides nothing, so that it keeps no recursion from settling.
#[derive(Clone, Debug, Default)]
pub(super) struct Shown {
    /// Second updates.
    pub(super) repeats: BTreeMap<(Given, usize), Evidence>,
    /// Ways that skip what others update.
    pub(super) skips: BTreeMap<(Given, usize), Evidence>,
}

impl PartialEq for Shown {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

impl Eq for Shown {}
