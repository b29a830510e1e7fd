//! Tests of the whole program, by topic.

#[path = "../support/mod.rs"]
mod support;

mod again;
mod baseline;
mod ci_formats;
mod cli;
mod configuration;
mod defects;
mod documents;
mod exit_status;
mod explain;
mod fix;
mod fixtures_compile;
mod gate;
mod init;
mod init_laws;
mod init_traits;
mod lsp;
mod messages;
mod migrate;
mod migration_report;
mod mutations;
mod presets;
mod repositories;
mod robustness;
mod schema;
mod since;
mod snapshot_tests;
mod stress;
mod suppressions;
mod terminal;
mod tidy;
mod time_domain;
mod workspaces;
