//! Proves or refutes that every sampled-time filter of a workspace is updated exactly once per control cycle.
//!
//! The program `cargo ceid-lint` is the product; this library exists for it and for its tests, and its API is unstable, but for
//! [`snapshot`], with which a test suite keeps what the linter says of its own crate.
//! Data flows from the first module of this list to the last; a module imports only from those above it.
#![forbid(unsafe_code)]

pub mod parallel;

pub mod source;

pub mod diagnostic;

pub mod config;

pub mod project;

pub mod relevance;

pub mod syntax;

pub mod index;

pub mod types;

pub mod flow;

pub mod count;

pub mod suppress;

pub mod rules;

pub mod suggest;

pub mod migrate;

pub mod candidates;

pub mod baseline;

pub mod pipeline;

pub mod fix;

pub mod report;

pub mod draft;

mod snapshot;

pub use snapshot::{Subject, snapshot};

pub mod lsp;

pub mod cli;
