//! The arguments about what was there before.

use std::path::PathBuf;

use clap::Args;

use crate::cli::args::{Input, LevelArgs, Talk};

pub(in crate::cli) const AFTER_BASELINE_HELP: &str = "\
The list counts findings by file, function, rule and filter, and holds no line numbers: it survives `cargo fmt`, moved
functions and new loops. Without flags the first list is written; one that is there is compared, and nothing is changed.

  cargo ceid-lint baseline               write the first list
  cargo ceid-lint baseline --prune       take out what is fixed
  cargo ceid-lint baseline --accept-new  add what is new

Exit codes: 0 the list holds all that was found, 100 there is more, 101 the run could not be made, something could not be
read, or the list could not be written, 2 wrong usage.";

#[derive(Debug, Args)]
pub(in crate::cli) struct BaselineArgs {
    #[command(flatten)]
    pub(in crate::cli) input: Input,
    #[command(flatten)]
    pub(in crate::cli) levels: LevelArgs,
    /// The file, instead of `ceid-baseline.toml` beside the manifest of the workspace.
    #[arg(long, value_name = "FILE", help_heading = "What is written")]
    pub(in crate::cli) baseline: Option<PathBuf>,
    /// Add the findings that are new.
    #[arg(long, help_heading = "What is written")]
    pub(in crate::cli) accept_new: bool,
    /// Take out the findings that are fixed, as far as this run has looked for them.
    #[arg(long, help_heading = "What is written")]
    pub(in crate::cli) prune: bool,
    #[command(flatten)]
    pub(in crate::cli) talk: Talk,
    #[arg(last = true, value_name = "LEVELS", hide = true)]
    pub(in crate::cli) rest: Vec<String>,
}

/// What keeps old findings apart from new ones.
#[derive(Debug, Default, Args)]
#[command(next_help_heading = "Legacy code")]
pub(in crate::cli) struct Legacy {
    /// The list of known findings, instead of `ceid-baseline.toml` beside the manifest of the workspace.
    #[arg(long, value_name = "FILE", conflicts_with = "no_baseline")]
    pub(in crate::cli) baseline: Option<PathBuf>,
    /// Show known findings as well.
    #[arg(long)]
    pub(in crate::cli) no_baseline: bool,
    /// Report only what touches lines that were changed since this git revision.
    #[arg(long, value_name = "REV", conflicts_with = "stdin_filename")]
    pub(in crate::cli) since: Option<String>,
}
