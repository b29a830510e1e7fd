//! Parsed files: the module tree of a crate as our own [`tree`], `cfg` in three values, macros read as code. Never fails:
//! what cannot be read or parsed becomes a [`Problem`](crate::diagnostic::Problem), and the rest goes on.

pub mod tree;

use tree::Item;

/// A crate whose module tree was followed from its root.
#[derive(Clone, Debug)]
pub struct ParsedCrate {
    /// Index into the project's packages.
    pub package: usize,
    /// Index into the package's targets.
    pub target: usize,
    /// The items of the root module.
    pub items: Vec<Item>,
}
