//! wip
pub mod glob;
pub mod spelling;
