//! `--with check` and `--with clippy`: a command of cargo that is run before, so that its findings are shown beside ours.

use std::ffi::OsString;
use std::io::{BufRead, BufReader};
use std::path::PathBuf;
use std::process::{Command, Stdio};

use clap::ValueEnum;

use super::Console;
use super::args::{CargoCommand, CheckArgs, MessageFormat};

/// Runs the command, and passes on what it says, but for the end of the build: that is not reached yet. Answers whether it ended
/// well.
pub(super) fn run(command: CargoCommand, args: &CheckArgs, console: Console) -> bool {
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let started =
        Command::new(cargo).args(arguments(command, args)).stdin(Stdio::null()).stdout(Stdio::piped()).spawn();
    let ended = started.and_then(|mut child| {
        for line in child.stdout.take().into_iter().flat_map(|output| BufReader::new(output).split(b'\n')) {
            let line = String::from_utf8_lossy(&line?).into_owned();
            if !is_end_of_build(&line) {
                console.print(&format!("{line}\n"));
            }
        }
        child.wait()
    });
    match ended {
        Ok(status) => status.success(),
        Err(error) => {
            console.error(&format!("cannot run `cargo {}`: {error}", name(command)), None);
            false
        }
    }
}

fn name(command: CargoCommand) -> &'static str {
    match command {
        CargoCommand::Check => "check",
        CargoCommand::Clippy => "clippy",
    }
}

fn is_end_of_build(line: &str) -> bool {
    let message: Option<serde_json::Value> = line.starts_with('{').then(|| serde_json::from_str(line).ok()).flatten();
    message.is_some_and(|message| message["reason"] == "build-finished")
}

/// The flags that cargo understands, as they were given.
fn arguments(command: CargoCommand, args: &CheckArgs) -> Vec<OsString> {
    let (scope, build, ignored) = (&args.input.scope, &args.input.build, &args.input.ignored);
    let mut flags = Flags(vec![name(command).into()]);
    flags.words(&formats(&args.message_format), "--message-format");
    flags.words(&scope.package, "--package");
    flags.words(&scope.exclude, "--exclude");
    for (names, flag) in
        [(&scope.bin, "--bin"), (&scope.example, "--example"), (&scope.test, "--test"), (&scope.bench, "--bench")]
    {
        flags.words(names, flag);
    }
    flags.path(scope.manifest_path.as_ref(), "--manifest-path");
    flags.words(&build.features, "--features");
    flags.words(&build.target, "--target");
    flags.words(build.profile.as_slice(), "--profile");
    flags.words(&build.config, "--config");
    flags.words(&build.unstable, "-Z");
    flags.path(ignored.target_dir.as_ref(), "--target-dir");
    flags.path(ignored.lockfile_path.as_ref(), "--lockfile-path");
    flags.words(ignored.jobs.as_slice(), "--jobs");
    let verbose = args.talk.verbose > 0;
    for (is_set, flag) in [
        (scope.workspace, "--workspace"),
        (scope.lib, "--lib"),
        (scope.bins, "--bins"),
        (scope.examples, "--examples"),
        (scope.tests, "--tests"),
        (scope.benches, "--benches"),
        (scope.all_targets, "--all-targets"),
        (build.all_features, "--all-features"),
        (build.no_default_features, "--no-default-features"),
        (build.release, "--release"),
        (ignored.keep_going, "--keep-going"),
        (ignored.locked, "--locked"),
        (ignored.offline, "--offline"),
        (ignored.frozen, "--frozen"),
        (ignored.ignore_rust_version, "--ignore-rust-version"),
        (ignored.future_incompat_report, "--future-incompat-report"),
        (ignored.no_deps && command == CargoCommand::Clippy, "--no-deps"),
        (args.talk.quiet, "--quiet"),
        (verbose, "--verbose"),
    ] {
        flags.0.extend(is_set.then(|| flag.into()));
    }
    flags.0
}

/// The formats that are cargo's own. Where findings go to a service, cargo talks to people.
fn formats(formats: &[MessageFormat]) -> Vec<String> {
    let is_cargos = |format: &&MessageFormat| {
        !matches!(format, MessageFormat::Sarif | MessageFormat::Github | MessageFormat::Gitlab | MessageFormat::Junit)
    };
    let values = formats.iter().filter(is_cargos).filter_map(ValueEnum::to_possible_value);
    let names: Vec<String> = values.map(|value| value.get_name().to_owned()).collect();
    if names.is_empty() { Vec::new() } else { vec![names.join(",")] }
}

struct Flags(Vec<OsString>);

impl Flags {
    fn words(&mut self, values: &[String], flag: &str) {
        self.0.extend(values.iter().flat_map(|value| [flag.into(), value.into()]));
    }

    fn path(&mut self, path: Option<&PathBuf>, flag: &str) {
        self.0.extend(path.into_iter().flat_map(|path| [flag.into(), path.into()]));
    }
}

#[cfg(test)]
mod tests {
    use clap::{CommandFactory, FromArgMatches};

    use super::super::args::Cli;
    use super::*;

    #[track_caller]
    fn check(line: &str, expected: &str) {
        let matches = Cli::command().try_get_matches_from(line.split(' ')).unwrap();
        let args = Cli::from_arg_matches(&matches).unwrap().check;
        let found = arguments(args.beside.unwrap(), &args);
        let found: Vec<&str> = found.iter().map(|word| word.to_str().unwrap()).collect();
        assert_eq!(found.join(" "), expected);
    }

    #[test]
    fn cargo_gets_what_it_knows() {
        check(
            "x --with clippy --workspace --message-format=json,json-diagnostic-rendered-ansi --all-targets --keep-going",
            "clippy --message-format json,json-diagnostic-rendered-ansi --workspace --all-targets --keep-going",
        );
        check(
            "x src/a.rs -D missed_update --with check -p a --message-format sarif -j 2",
            "check --package a --jobs 2",
        );
    }

    #[test]
    fn end_of_the_build_is_kept_back() {
        assert!(is_end_of_build(r#"{"reason":"build-finished","success":true}"#));
        assert!(!is_end_of_build(r#"{"reason":"compiler-message","message":{"message":"build-finished"}}"#));
        assert!(!is_end_of_build("build-finished"));
    }
}
