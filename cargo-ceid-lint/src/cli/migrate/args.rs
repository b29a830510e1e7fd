//! The arguments of `migrate`.

use std::path::PathBuf;

use clap::Args;
use clap::builder::Resettable;

use crate::cli::args::{Build, Ignored, Scope, Talk};

pub(in crate::cli) const AFTER_HELP: &str = "\
A guard updates its filters at the end of each cycle, on every way out of it. A loop is migrated if the program does the same
with the guard as it did by hand, and refused with the reason if not: the state of a filter is used after its update, the loop
is left before it, a helper updates it, … A law with inputs and a filter of another crate are lent to `ceid_core::Adapted` above
the loop, and fed where the law was called. With `--unsafe-fixes`, loops are migrated as well that compile with a guard and do
something else than before; what, is told. Nothing is built, and `Cargo.lock` is not touched.

  cargo ceid-lint migrate                  tell which loops can be migrated, and why the others cannot
  cargo ceid-lint migrate src/main.rs:12   migrate the loop at that line
  cargo ceid-lint migrate --all            migrate all that can be
  cargo ceid-lint migrate --all --diff     show what that would change

Exit codes: 0 done, 100 a loop that was named is refused, 101 something could not be read or written, 2 wrong usage. With
`--diff`: 0 nothing would be changed, 100 something would be.";

// Elsewhere `--all` is cargo's old name of `--workspace`, which only says where to look; here it says what to do.
#[derive(Debug, Args)]
#[command(mut_arg("workspace", |arg| arg.alias(Resettable::Reset)))]
pub(in crate::cli) struct MigrateArgs {
    /// The loops to migrate: a file, and a line of the loop. Without any, and without `--all`, nothing is written.
    #[arg(value_name = "FILE:LINE")]
    pub(in crate::cli) places: Vec<String>,
    #[command(flatten)]
    pub(in crate::cli) scope: Scope,
    #[command(flatten)]
    pub(in crate::cli) build: Build,
    #[command(flatten)]
    pub(in crate::cli) ignored: Ignored,
    /// Migrate all loops that can be, of the packages and targets that are looked at: the whole workspace, if none are named.
    #[arg(long, help_heading = "Migration")]
    pub(in crate::cli) all: bool,
    /// Where `ceid-core` lies, for packages that do not depend on it yet; without it, they ask for its version.
    #[arg(long, value_name = "DIR", help_heading = "Migration")]
    pub(in crate::cli) ceid_core_path: Option<PathBuf>,
    /// Migrate also where the program then does something else: look at what is told.
    #[arg(long, help_heading = "Migration")]
    pub(in crate::cli) unsafe_fixes: bool,
    /// Print what would change as a unified diff on stdout, and write nothing.
    #[arg(long, help_heading = "Migration")]
    pub(in crate::cli) diff: bool,
    /// Migrate even if the working directory is dirty or has staged changes.
    #[arg(long, help_heading = "Migration")]
    pub(in crate::cli) allow_dirty: bool,
    /// Migrate even if the working directory has staged changes.
    #[arg(long, help_heading = "Migration")]
    pub(in crate::cli) allow_staged: bool,
    /// Migrate even if a VCS was not detected.
    #[arg(long, help_heading = "Migration")]
    pub(in crate::cli) allow_no_vcs: bool,
    #[command(flatten)]
    pub(in crate::cli) talk: Talk,
}

/// What is to be migrated.
pub(super) enum Asked {
    /// Nothing yet: tell what could be.
    Nothing,
    All,
    /// Files, each with a line of a loop.
    At(Vec<(PathBuf, u32)>),
}

impl MigrateArgs {
    /// What they ask for.
    pub(super) fn asked(&self) -> Result<Asked, String> {
        if self.places.is_empty() {
            return Ok(if self.all { Asked::All } else { Asked::Nothing });
        }
        if self.all {
            return Err("`--all` migrates every loop: leave out the places".to_owned());
        }
        let place = |text: &String| {
            let mut parts: Vec<&str> = text.split(':').collect();
            let mut numbers = Vec::new();
            while let Some(number) = parts.last().and_then(|part| part.parse::<u32>().ok()) {
                numbers.push(number);
                parts.pop();
            }
            let line = numbers.last().copied().filter(|_| numbers.len() <= 2 && !parts.is_empty());
            let line = line.ok_or_else(|| format!("`{text}` is not FILE:LINE, such as `src/main.rs:12`"))?;
            let path = std::env::current_dir().unwrap_or_default().join(parts.join(":"));
            if !path.is_file() {
                return Err(format!("there is no file `{}`", parts.join(":")));
            }
            Ok((path, line))
        };
        self.places.iter().map(place).collect::<Result<_, String>>().map(Asked::At)
    }
}
