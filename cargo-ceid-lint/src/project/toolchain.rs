//! Runs cargo and rustc, and finds ones that work when the toolchain asked for is not installed. Never installs anything.

use std::env;
use std::ffi::{OsStr, OsString};
use std::path::{Path, PathBuf};
use std::process::Command;

/// Why a program gave no answer.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Failure {
    /// It cannot be run here: not installed, or too old for this workspace.
    Tool(String),
    /// It ran, and refused with this text.
    Refused(String),
}

impl Failure {
    /// The text in one line: its error, before which cargo may have warned, or said what it waits for.
    pub(super) fn first_line(&self) -> String {
        let (Self::Tool(text) | Self::Refused(text)) = self;
        let lines = || text.lines().map(str::trim).filter(|line| !line.is_empty() && !line.starts_with("Caused by"));
        let error = lines().find_map(|line| line.strip_prefix("error: "));
        error.or_else(|| lines().next()).unwrap_or("no reason given").to_owned()
    }
}

/// Runs `cargo` with `args` in `directory`; with a cargo of another installed toolchain if the chosen one is missing.
pub(super) fn cargo(args: &[OsString], directory: &Path) -> Result<String, Failure> {
    run_or_substitute("CARGO", "cargo", args, directory)
}

/// Runs `rustc` with `args` in `directory`; with a rustc of another installed toolchain if the chosen one is missing.
pub(super) fn rustc(args: &[OsString], directory: &Path) -> Result<String, Failure> {
    run_or_substitute("RUSTC", "rustc", args, directory)
}

/// The host, as far as rustup's name of the toolchain tells it (`stable-x86_64-unknown-linux-gnu`), or the one for which the
/// linter was built. Only a guess: the toolchain may be a linked one.
pub(super) fn host() -> String {
    let named = env::var("RUSTUP_TOOLCHAIN").ok();
    named.and_then(|name| host_in(&name)).unwrap_or_else(|| env!("BUILT_FOR").to_owned())
}

fn host_in(toolchain: &str) -> Option<String> {
    let parts: Vec<&str> = toolchain.split('-').collect();
    // An architecture is the first part that no channel and no date is.
    let at = parts.iter().skip(1).position(|part| !part.starts_with(|letter: char| letter.is_ascii_digit()))? + 1;
    (parts.len() - at >= 3).then(|| parts[at..].join("-"))
}

fn run_or_substitute(variable: &str, name: &str, args: &[OsString], directory: &Path) -> Result<String, Failure> {
    let program = env::var_os(variable).filter(|value| !value.is_empty()).unwrap_or_else(|| name.into());
    let first = run(&mut command(&program, args, directory));
    let Err(Failure::Tool(_)) = &first else { return first };
    for bin in installed_toolchains() {
        let program = bin.join(format!("{name}{}", env::consts::EXE_SUFFIX));
        if program.is_file() {
            let mut command = command(program.as_os_str(), args, directory);
            command.env_remove("RUSTUP_TOOLCHAIN");
            if env::var_os("RUSTC").is_none() {
                command.env("RUSTC", bin.join(format!("rustc{}", env::consts::EXE_SUFFIX)));
            }
            let answer = run(&mut command);
            if !matches!(answer, Err(Failure::Tool(_))) {
                return answer;
            }
        }
    }
    first
}

fn command(program: &OsStr, args: &[OsString], directory: &Path) -> Command {
    let mut command = Command::new(program);
    command.args(args).current_dir(directory);
    // A missing toolchain must be an error, not a download; and no backtrace belongs in a message.
    command.env("RUSTUP_AUTO_INSTALL", "0").env("CARGO_NET_OFFLINE", "true").env_remove("RUST_BACKTRACE");
    command
}

fn run(command: &mut Command) -> Result<String, Failure> {
    let output = command
        .output()
        .map_err(|error| Failure::Tool(format!("cannot run `{}`: {error}", command.get_program().to_string_lossy())))?;
    if output.status.success() {
        return Ok(String::from_utf8_lossy(&output.stdout).into_owned());
    }
    let text = String::from_utf8_lossy(&output.stderr).trim().to_owned();
    if is_toolchain_trouble(&text) { Err(Failure::Tool(text)) } else { Err(Failure::Refused(text)) }
}

fn is_toolchain_trouble(text: &str) -> bool {
    const SIGNS: &[&str] = &[
        "is not installed",
        "is not applicable to",
        "override toolchain",
        "invalid toolchain",
        "could not parse override file",
        "invalid UTF-8 was detected in one or more arguments",
        "requires a nightly version of Cargo",
        "could not choose a version of",
        "no default is configured",
        "rustup could not",
        "not stabilized in this version of Cargo",
        "this version of Cargo is older than",
        "could not execute process",
        "unknown proxy name",
    ];
    SIGNS.iter().any(|sign| text.contains(sign))
}

/// The `bin` directories of the installed toolchains: the default one, then stable ones, then the rest.
fn installed_toolchains() -> Vec<PathBuf> {
    let Some(home) = env::var_os("RUSTUP_HOME").map(PathBuf::from).or_else(|| Some(env::home_dir()?.join(".rustup")))
    else {
        return Vec::new();
    };
    let default = std::fs::read_to_string(home.join("settings.toml"))
        .ok()
        .and_then(|text| text.parse::<toml::Table>().ok())
        .and_then(|table| Some(table.get("default_toolchain")?.as_str()?.to_owned()));
    let Ok(entries) = std::fs::read_dir(home.join("toolchains")) else { return Vec::new() };
    let mut names: Vec<String> =
        entries.flatten().map(|entry| entry.file_name().to_string_lossy().into_owned()).collect();
    names.sort_by_key(|name| (Some(name) != default.as_ref(), !name.starts_with("stable"), name.clone()));
    names.into_iter().map(|name| home.join("toolchains").join(name).join("bin")).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_missing_toolchain_is_told_from_a_wrong_manifest() {
        assert!(is_toolchain_trouble("error: toolchain '1.12.0' is not installed"));
        assert!(is_toolchain_trouble(
            "feature `edition2024` is required\n… is not stabilized in this version of Cargo (1.80.0)"
        ));
        assert!(!is_toolchain_trouble("error: failed to parse manifest at `/ws/Cargo.toml`"));
    }

    #[test]
    fn the_error_is_told_and_not_what_comes_before() {
        let text =
            "    Blocking waiting for file lock on package cache\nwarning: `config` is deprecated\nerror: no `x`\n";
        assert_eq!(Failure::Refused(text.to_owned()).first_line(), "no `x`");
        assert_eq!(Failure::Tool("cannot run `cargo`".to_owned()).first_line(), "cannot run `cargo`");
    }

    #[test]
    fn the_first_line_is_without_decoration() {
        let failure = Failure::Refused("error: failed to load\n\nCaused by:\n  x".to_owned());
        assert_eq!(failure.first_line(), "failed to load");
        assert_eq!(Failure::Tool(String::new()).first_line(), "no reason given");
    }
}
