//! What the tests share: the parser of case files, and the only code that runs the program.

// Each test program uses its own part of this module.
#![allow(dead_code, clippy::allow_attributes)]

pub(crate) mod case;
pub(crate) mod program;
pub(crate) mod workspace;

/// Every rule that the program knows, by its name without prefix.
pub(crate) const RULES: &[&str] = &[
    "blanket_suppression",
    "debug_only_update",
    "forgotten_guard",
    "gated_update",
    "guard_dropped_early",
    "guard_outside_cycle",
    "missed_update",
    "multi_event_update",
    "rate_mismatch",
    "repeated_update",
    "skipped_update",
    "time_in_cycle",
    "unguarded_update",
    "unknown_rule",
    "unproved_update",
    "unregistered_filter",
    "unused_suppression",
];

/// The root of the repository.
pub(crate) fn root() -> std::path::PathBuf {
    let root = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    root.canonicalize().expect("the crate lies in the repository")
}
