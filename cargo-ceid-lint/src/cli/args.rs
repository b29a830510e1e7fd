//! Every argument of the program, in one place. Never acts on them.

use std::path::PathBuf;

use super::baseline::args::{AFTER_BASELINE_HELP, BaselineArgs, Legacy};
use super::migrate;
use crate::project::Partition;

use clap::{ArgAction, Args, Parser, Subcommand, ValueEnum};

const ABOUT: &str = "Proves or refutes that every sampled-time filter is updated exactly once per control cycle.";

const AFTER_HELP: &str = "\
Exit codes:
    0  nothing found at `deny`
  100  findings at `deny`
  101  the run could not be made, or a file could not be read or parsed (the rest is checked all the same)
    2  wrong usage

Accepted and ignored, because editors pass them to `cargo check` (the network is never used, and nothing is built):
  --keep-going, --target-dir, --no-deps, -j, --locked, --offline, --frozen, --ignore-rust-version,
  --future-incompat-report, --lockfile-path

`cargo ceid-lint explain missed_update` explains a rule; `cargo ceid-lint rules` lists all of them.";

const AFTER_INIT_HELP: &str = "\
Filters that are certain are turned on. All others stand in the file behind `#`, each with the reason why it looks like
a filter and the number of its uses: remove the `#` of those that are, and run `cargo ceid-lint`.

  cargo ceid-lint init                     look at the file before the first check
  cargo ceid-lint init --accept            turn on everything that was found and is called
  cargo ceid-lint init --accept Pid Ramp   turn on these two
  cargo ceid-lint init --stdout            look, and write nothing

Exit codes: 0 the file is written, 101 it is not, or a file could not be read or parsed, 2 wrong usage.";

const AFTER_FIX_HELP: &str = "\
Without `--unsafe-fixes` only those fixes are applied that are what was meant. The changed files are checked again before
they are written and after, and a fix that would bring a new finding is taken back. Each file is written in full or not at
all. The working directory must have no uncommitted changes, as for `cargo fix`.

Exit codes: 0 nothing is left at `deny`, 100 findings at `deny` are left, 101 something could not be read or written, 2 wrong
usage. With `--diff`: 0 nothing would be changed, 100 something would be.";

/// The command line.
#[derive(Debug, Parser)]
#[command(
    name = "cargo-ceid-lint",
    bin_name = "cargo ceid-lint",
    version,
    about = ABOUT,
    after_help = AFTER_HELP,
    args_conflicts_with_subcommands = true,
    max_term_width = 120,
)]
pub(super) struct Cli {
    #[command(subcommand)]
    pub(super) command: Option<Command>,
    #[command(flatten)]
    pub(super) check: CheckArgs,
}

#[derive(Debug, Subcommand)]
pub(super) enum Command {
    /// Check the filters of every control cycle (what happens without a subcommand).
    #[command(after_help = AFTER_HELP)]
    Check(Box<CheckArgs>),
    /// Apply the fixes that the findings offer, and check again.
    #[command(after_help = AFTER_FIX_HELP)]
    Fix(Box<CheckArgs>),
    /// Print the proof report: every cycle and filter with its verdict.
    #[command(after_help = "Exit codes: 0 the report is complete, 101 it is not. A report has no findings of its own.")]
    Report(Box<ReportArgs>),
    /// Write, extend or prune the list of findings that are known, so that only new ones fail.
    #[command(after_help = AFTER_BASELINE_HELP)]
    Baseline(Box<BaselineArgs>),
    /// Print the long text of a rule.
    Explain(ExplainArgs),
    /// Print the table of rules, their groups and default levels.
    Rules(RulesArgs),
    /// Write a first `ceid-lint.toml` with the filters and cycles that were found.
    #[command(after_help = AFTER_INIT_HELP)]
    Init(Box<InitArgs>),
    /// Put a guard of `ceid-core` into loops that update their filters by hand.
    #[command(after_help = migrate::AFTER_HELP)]
    Migrate(Box<migrate::MigrateArgs>),
    /// Serve an editor: a language server on stdin and stdout.
    #[command(
        after_help = "Settings for editors: docs/editors.md. Exit codes: 0 after `shutdown` and `exit`, 1 without."
    )]
    Lsp(LspArgs),
    /// Print the completions for a shell.
    Completions(CompletionsArgs),
    /// Print the manual page, in roff.
    Man,
}

#[derive(Debug, Args)]
pub(super) struct CheckArgs {
    #[command(flatten)]
    pub(super) input: Input,
    #[command(flatten)]
    pub(super) levels: LevelArgs,
    #[command(flatten)]
    pub(super) legacy: Legacy,
    #[command(flatten)]
    pub(super) talk: Talk,
    /// How findings are printed.
    #[arg(long, value_name = "FORMAT", value_enum, value_delimiter = ',', help_heading = "Output")]
    pub(super) message_format: Vec<MessageFormat>,
    /// Write the chosen format, or the one named before `=`, to a file as well (`-` is stdout); may be given several times.
    #[arg(long, value_name = "[FORMAT=]FILE", help_heading = "Output")]
    pub(super) output: Vec<String>,
    /// Run this command of cargo first, with the same flags, and pass on what it says: for editors that have room for one
    /// checker.
    #[arg(long = "with", value_name = "COMMAND", value_enum, help_heading = "Output")]
    pub(super) beside: Option<CargoCommand>,
    #[command(flatten)]
    pub(super) fixes: FixArgs,
    /// Levels again, as for clippy: `-- -W ceid::gated_update`.
    #[arg(last = true, value_name = "LEVELS", help_heading = "Levels")]
    pub(super) rest: Vec<String>,
}

/// What is done about the findings.
#[derive(Debug, Args)]
#[command(next_help_heading = "Fixes")]
pub(super) struct FixArgs {
    /// Apply the fixes that the findings offer, as `cargo ceid-lint fix` does.
    #[arg(long)]
    pub(super) fix: bool,
    /// Apply also the fixes that may not be what was meant: look at what they did.
    #[arg(long)]
    pub(super) unsafe_fixes: bool,
    /// Print what the fixes would change as a unified diff on stdout, write nothing, and fail if there is something.
    #[arg(long)]
    pub(super) diff: bool,
    /// Fix code even if the working directory is dirty or has staged changes.
    #[arg(long)]
    pub(super) allow_dirty: bool,
    /// Fix code even if the working directory has staged changes.
    #[arg(long)]
    pub(super) allow_staged: bool,
    /// Fix code even if a VCS was not detected.
    #[arg(long)]
    pub(super) allow_no_vcs: bool,
}

#[derive(Debug, Args)]
pub(super) struct ReportArgs {
    #[command(flatten)]
    pub(super) input: Input,
    #[command(flatten)]
    pub(super) levels: LevelArgs,
    #[command(flatten)]
    pub(super) legacy: Legacy,
    #[command(flatten)]
    pub(super) talk: Talk,
    /// How the report is printed.
    #[arg(long, value_name = "FORMAT", value_enum, default_value = "human", help_heading = "Output")]
    pub(super) message_format: ReportFormat,
    /// Write the chosen format, or the one named before `=`, to a file as well (`-` is stdout); may be given several times.
    #[arg(long, value_name = "[FORMAT=]FILE", help_heading = "Output")]
    pub(super) output: Vec<String>,
    /// Say what has changed since this report, which was written with `--message-format json`.
    #[arg(long, value_name = "FILE", conflicts_with = "since", help_heading = "Output")]
    pub(super) compare_with: Option<PathBuf>,
    #[arg(last = true, value_name = "LEVELS", hide = true)]
    pub(super) rest: Vec<String>,
}

#[derive(Debug, Args)]
pub(super) struct ExplainArgs {
    /// A rule or a group, with or without `ceid::`.
    #[arg(value_name = "RULE")]
    pub(super) rule: String,
}

#[derive(Debug, Args)]
pub(super) struct RulesArgs {
    /// How the table is printed.
    #[arg(long, value_name = "FORMAT", value_enum, default_value = "human")]
    pub(super) message_format: DataFormat,
    /// Whether colours are used.
    #[arg(long, value_name = "WHEN", value_enum)]
    pub(super) color: Option<ColorChoice>,
}

#[derive(Debug, Args)]
pub(super) struct InitArgs {
    /// Look in these directories, for a directory that holds several packages and no manifest of its own.
    #[arg(value_name = "PATH")]
    pub(super) paths: Vec<PathBuf>,
    #[command(flatten)]
    pub(super) scope: Scope,
    #[command(flatten)]
    pub(super) build: Build,
    #[command(flatten)]
    pub(super) ignored: Ignored,
    /// Turn on what was found: all of it that some code calls, or these, by name or path.
    #[arg(
        long,
        value_name = "NAME",
        num_args = 0..,
        value_delimiter = ',',
        default_missing_value = "all",
        help_heading = "What is written"
    )]
    pub(super) accept: Option<Vec<String>>,
    /// Write over a file that is there; what was changed in it by hand is lost.
    #[arg(long, help_heading = "What is written")]
    pub(super) force: bool,
    /// Print the file instead of writing it.
    #[arg(long, help_heading = "What is written")]
    pub(super) stdout: bool,
    #[command(flatten)]
    pub(super) talk: Talk,
}

#[derive(Debug, Args)]
pub(super) struct LspArgs {
    /// What editors add to say how they talk to the server; there is no other way.
    #[arg(long, hide = true)]
    stdio: bool,
}

#[derive(Debug, Args)]
pub(super) struct CompletionsArgs {
    /// The shell.
    #[arg(value_name = "SHELL", value_enum)]
    pub(super) shell: clap_complete::Shell,
}

/// What is checked.
#[derive(Debug, Args)]
pub(super) struct Input {
    /// Report only what lies in these files and directories; a `.rs` file outside any package is checked on its own.
    #[arg(value_name = "PATH")]
    pub(super) paths: Vec<PathBuf>,
    /// Read the text of this file from stdin. Without paths, only what lies in it is reported.
    #[arg(long, value_name = "FILE")]
    pub(super) stdin_filename: Option<PathBuf>,
    #[command(flatten)]
    pub(super) scope: Scope,
    #[command(flatten)]
    pub(super) build: Build,
    #[command(flatten)]
    pub(super) ignored: Ignored,
    /// What it means when there is no cycle and no filter.
    #[arg(long, value_name = "MEANING", value_enum, default_value = "warn", help_heading = "Levels")]
    pub(super) no_loops: NoLoops,
    /// Parse all packages, those without any filter as well, so that what is broken in them is told.
    #[arg(long)]
    pub(super) no_gate: bool,
}

#[derive(Debug, Args)]
#[command(next_help_heading = "Packages and targets")]
pub(super) struct Scope {
    /// Check this package: a name, `name@version`, a pattern, or a package id.
    #[arg(short, long, value_name = "SPEC")]
    pub(super) package: Vec<String>,
    /// Check all packages of the workspace.
    #[arg(long, alias = "all", overrides_with = "workspace")]
    pub(super) workspace: bool,
    /// Leave this package out; needs `--workspace`.
    #[arg(long, value_name = "SPEC")]
    pub(super) exclude: Vec<String>,
    /// Check the library.
    #[arg(long)]
    pub(super) lib: bool,
    /// Check all binaries.
    #[arg(long)]
    pub(super) bins: bool,
    /// Check this binary.
    #[arg(long, value_name = "NAME")]
    pub(super) bin: Vec<String>,
    /// Check all examples.
    #[arg(long)]
    pub(super) examples: bool,
    /// Check this example.
    #[arg(long, value_name = "NAME")]
    pub(super) example: Vec<String>,
    /// Check all integration tests, the library and the binaries.
    #[arg(long)]
    pub(super) tests: bool,
    /// Check this integration test.
    #[arg(long, value_name = "NAME")]
    pub(super) test: Vec<String>,
    /// Check all benchmarks, the library and the binaries.
    #[arg(long)]
    pub(super) benches: bool,
    /// Check this benchmark.
    #[arg(long, value_name = "NAME")]
    pub(super) bench: Vec<String>,
    /// Check all targets (without target flags: library, binaries and examples).
    #[arg(long)]
    pub(super) all_targets: bool,
    /// Path of the `Cargo.toml`.
    #[arg(long, value_name = "PATH")]
    pub(super) manifest_path: Option<PathBuf>,
    /// Check one part of the selected packages, to share them among machines: `slice:1/3` takes every third package,
    /// `hash:1/3` a third that stays the same when packages are added.
    #[arg(long, value_name = "KIND:M/N")]
    pub(super) partition: Option<Partition>,
}

#[derive(Debug, Args)]
#[command(next_help_heading = "Build context")]
pub(super) struct Build {
    /// Features that are on, separated by spaces or commas. `-F RULE` with the name of a rule forbids that rule.
    #[arg(short = 'F', long, value_name = "FEATURES")]
    pub(super) features: Vec<String>,
    /// All features are on.
    #[arg(long)]
    pub(super) all_features: bool,
    /// The default features are off.
    #[arg(long)]
    pub(super) no_default_features: bool,
    /// The target that decides `cfg`, instead of `build.target` or the host.
    #[arg(long, value_name = "TRIPLE")]
    pub(super) target: Vec<String>,
    /// Without debug assertions, as a release build.
    #[arg(short, long, conflicts_with = "profile")]
    pub(super) release: bool,
    /// The profile: `release` and `bench` are without debug assertions.
    #[arg(long, value_name = "NAME", value_parser = super::input::profile_name)]
    pub(super) profile: Option<String>,
    /// Override a value of cargo's configuration.
    #[arg(long, value_name = "KEY=VALUE")]
    pub(super) config: Vec<String>,
    /// Unstable flags, handed to cargo.
    #[arg(short = 'Z', value_name = "FLAG")]
    pub(super) unstable: Vec<String>,
}

#[derive(Debug, Args)]
#[command(next_help_heading = "Levels")]
pub(super) struct LevelArgs {
    /// Do not show findings of this rule or group.
    #[arg(id = "allow", short = 'A', long = "allow", value_name = "RULE")]
    pub(super) allow: Vec<String>,
    /// Show them.
    #[arg(id = "warn", short = 'W', long = "warn", value_name = "RULE")]
    pub(super) warn: Vec<String>,
    /// Show them, and fail; `-D warnings` does so with all that are shown.
    #[arg(id = "deny", short = 'D', long = "deny", value_name = "RULE")]
    pub(super) deny: Vec<String>,
    /// Show them, and fail, whatever a suppression says.
    #[arg(id = "forbid", long = "forbid", value_name = "RULE")]
    pub(super) forbid: Vec<String>,
    /// Every gate and every filter that cannot be proved counts: denies `gated_update` and `unproved_update`.
    #[arg(long)]
    pub(super) strict: bool,
}

#[derive(Debug, Default, Args)]
#[command(next_help_heading = "Output")]
pub(super) struct Talk {
    /// Whether colours are used.
    #[arg(long, value_name = "WHEN", value_enum)]
    pub(super) color: Option<ColorChoice>,
    /// Print findings only.
    #[arg(short, long, conflicts_with = "verbose")]
    pub(super) quiet: bool,
    /// Print what is checked.
    #[arg(short, long, action = ArgAction::Count)]
    pub(super) verbose: u8,
    /// Show all steps of a path, not only the last ones.
    #[arg(long)]
    pub(super) full_trace: bool,
    /// Print figures about the run.
    #[arg(long)]
    pub(super) stats: bool,
    /// Print where the time goes; cargo's formats have no meaning here.
    #[arg(long, value_name = "FORMAT", num_args = 0..=1, require_equals = true)]
    pub(super) timings: Option<Option<String>>,
}

/// What `cargo check` takes and what has no meaning here.
#[derive(Debug, Args)]
pub(super) struct Ignored {
    #[arg(long, hide = true)]
    pub(super) keep_going: bool,
    #[arg(long, hide = true, value_name = "DIRECTORY")]
    pub(super) target_dir: Option<PathBuf>,
    #[arg(long, hide = true)]
    pub(super) no_deps: bool,
    #[arg(short = 'j', long = "jobs", hide = true, value_name = "N", allow_hyphen_values = true)]
    pub(super) jobs: Option<String>,
    #[arg(long, hide = true)]
    pub(super) locked: bool,
    #[arg(long, hide = true)]
    pub(super) offline: bool,
    #[arg(long, hide = true)]
    pub(super) frozen: bool,
    #[arg(long, hide = true)]
    pub(super) ignore_rust_version: bool,
    #[arg(long, hide = true)]
    pub(super) future_incompat_report: bool,
    #[arg(long, hide = true, value_name = "PATH")]
    pub(super) lockfile_path: Option<PathBuf>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(super) enum ColorChoice {
    /// On a terminal.
    Auto,
    /// Always.
    Always,
    /// Never.
    Never,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(super) enum CargoCommand {
    /// `cargo check`
    Check,
    /// `cargo clippy`
    Clippy,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(super) enum NoLoops {
    /// The run fails.
    Fail,
    /// A warning.
    Warn,
    /// Nothing.
    Pass,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(super) enum DataFormat {
    /// For people.
    Human,
    /// For programs.
    Json,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(super) enum ReportFormat {
    /// For people.
    Human,
    /// For programs.
    Json,
    /// One page for a browser, which needs nothing else.
    Html,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(super) enum MessageFormat {
    /// With the source, on stderr (the default).
    Human,
    /// One line each, on stderr.
    Short,
    /// cargo's JSON messages, on stdout.
    Json,
    /// The same, with `rendered` in one line.
    JsonDiagnosticShort,
    /// The same, with `rendered` in colours.
    JsonDiagnosticRenderedAnsi,
    /// cargo's JSON messages without findings, which are printed for people.
    JsonRenderDiagnostics,
    /// SARIF 2.1.0, for code scanning.
    Sarif,
    /// Annotations of GitHub Actions, and a table in the summary of the step.
    Github,
    /// GitLab's code quality report.
    Gitlab,
    /// JUnit's XML.
    Junit,
}

#[cfg(test)]
mod tests {
    use clap::CommandFactory;

    use super::*;

    #[test]
    fn the_definition_is_consistent() {
        Cli::command().debug_assert();
    }

    #[test]
    fn the_help_reads_well() {
        insta::assert_snapshot!(Cli::command().term_width(120).render_help());
    }
}
