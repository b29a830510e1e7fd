//! `cargo ceid-lint completions` and `cargo ceid-lint man`: what shells and `man` want to know about the command line.

use clap::CommandFactory;

use super::args::{Cli, CompletionsArgs, Talk};
use super::{Console, ExitStatus};

/// The name under which shells know the program; completions of `cargo ceid-lint` are cargo's own.
const PROGRAM: &str = "cargo-ceid-lint";

/// Prints the completions for a shell.
///
/// # Errors
/// Never; all subcommands have the same form.
pub(super) fn completions(args: &CompletionsArgs) -> Result<ExitStatus, String> {
    let mut text = Vec::new();
    clap_complete::generate(args.shell, &mut Cli::command().bin_name(PROGRAM), PROGRAM, &mut text);
    print(&text)
}

/// Prints the manual page.
///
/// # Errors
/// If the page cannot be made.
pub(super) fn manual() -> Result<ExitStatus, String> {
    let mut text = Vec::new();
    let page = clap_mangen::Man::new(Cli::command().name(PROGRAM));
    page.render(&mut text).map_err(|error| format!("cannot make the manual page: {error}"))?;
    print(&text)
}

fn print(text: &[u8]) -> Result<ExitStatus, String> {
    Console::new(&Talk::default()).print(&String::from_utf8_lossy(text));
    Ok(ExitStatus::Clean)
}
