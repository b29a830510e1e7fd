//! Counts of the findings that a legacy code base starts with. Knows no lines, so that what is counted may move; never runs a
//! check.

mod compare;
mod counts;
mod file;

pub use compare::Comparison;
pub use counts::{Counts, Key, keys};
pub use file::{FILE_NAME, read, text};
