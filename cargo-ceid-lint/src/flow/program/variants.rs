//! Numbers of the variants of all enums by their names, none the same for two of one enum.

use rustc_hash::{FxHashMap, FxHashSet};

use crate::index::Index;

/// How many variants of one enum are told apart.
pub const MAX_VARIANTS: u32 = 60;

/// Whole numbers that are less than this have a number of their own.
const MAX_SMALL: u32 = 30;

/// A whole number by its spelling, if no other number and no name shares what tells it apart.
#[must_use]
pub fn small_number(name: &str) -> Option<u32> {
    name.parse().ok().filter(|number| *number < MAX_SMALL)
}

/// The numbers of names of variants, each less than [`MAX_VARIANTS`].
#[derive(Debug, Default)]
pub struct VariantNumbers {
    of: FxHashMap<String, u32>,
}

impl VariantNumbers {
    /// Numbers the variants of an index.
    #[must_use]
    pub(super) fn of(index: &Index) -> Self {
        let enums: Vec<Vec<&str>> =
            index.variants_of_enums().filter(|names| names.len() <= MAX_VARIANTS as usize).collect();
        let mut owners: FxHashMap<&str, Vec<usize>> = FxHashMap::default();
        for (at, names) in enums.iter().enumerate() {
            names.iter().for_each(|name| owners.entry(name).or_default().push(at));
        }
        let mut of: FxHashMap<String, u32> = FxHashMap::default();
        for name in enums.iter().flatten() {
            if of.contains_key(*name) {
                continue;
            }
            // A name that several enums have needs a number that is free in each of them.
            let beside = owners[name].iter().flat_map(|at| &enums[*at]);
            let taken: FxHashSet<u32> = beside.filter_map(|other| of.get(*other).copied()).collect();
            if let Some(free) = (0..MAX_VARIANTS).find(|number| !taken.contains(number)) {
                of.insert((*name).to_owned(), free);
            }
        }
        Self { of }
    }

    /// The number of a name, or of a whole number that is spelled out; larger ones, names of no variant, and of enums with very many of
    /// them, may share theirs with any other, but with no small number.
    #[must_use]
    pub fn number(&self, name: &str) -> u32 {
        self.of.get(name).copied().or_else(|| small_number(name)).unwrap_or_else(|| {
            let hash = name.bytes().fold(0u32, |hash, byte| (hash ^ u32::from(byte)).wrapping_mul(16_777_619));
            MAX_SMALL + hash % (MAX_VARIANTS - MAX_SMALL)
        })
    }
}
