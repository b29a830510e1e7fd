//! Runs the built program and reads what it prints. Nothing else in the tests starts it.

use std::ffi::OsStr;
use std::fmt;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use serde_json::Value;

/// A finding as the JSON form gives it.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Finding {
    /// The file of the primary span, as printed.
    pub(crate) file: String,
    /// The line of the primary span.
    pub(crate) line: usize,
    /// The rule without its prefix.
    pub(crate) rule: String,
    /// The message.
    pub(crate) message: String,
    /// Whether it comes with a change of the text.
    pub(crate) is_fixable: bool,
}

/// A cycle and one of its filters, as the proof report gives them.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Pair {
    /// The file that it lies in, as printed.
    pub(crate) file: String,
    /// The function that the cycle lies in.
    pub(crate) function: String,
    /// The line of the cycle's head.
    pub(crate) line: usize,
    /// `loop`, `while`, `for`, `closure` or `function`.
    pub(crate) kind: String,
    /// The instance as the source spells it.
    pub(crate) name: String,
    /// The verdict's word.
    pub(crate) verdict: String,
    /// The counts on completing paths.
    pub(crate) counts: Vec<u64>,
    /// The gate's word.
    pub(crate) gate: Option<String>,
}

impl fmt::Display for Pair {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { function, line, kind, name, verdict, counts, gate, .. } = self;
        write!(f, "line {line} in {function}, {kind} {name} {verdict} {counts:?}")?;
        gate.as_ref().map_or(Ok(()), |gate| write!(f, " by {gate}"))
    }
}

/// What a run printed and how it ended.
#[derive(Clone, Debug)]
pub(crate) struct Run {
    /// The exit code; `None` when a signal ended it.
    pub(crate) code: Option<i32>,
    /// What went to stdout.
    pub(crate) stdout: String,
    /// What went to stderr.
    pub(crate) stderr: String,
}

/// The path of the program.
pub(crate) fn program() -> PathBuf {
    PathBuf::from(env!("CARGO_BIN_EXE_cargo-ceid-lint"))
}

/// Runs `cargo-ceid-lint ceid-lint ARGS` in a directory.
pub(crate) fn run<S: AsRef<OsStr>>(directory: &Path, args: impl IntoIterator<Item = S>) -> Run {
    run_command(Command::new(program()).arg("ceid-lint").args(args).current_dir(directory))
}

/// Runs a command that ends in the program, without colours and without the caller's settings.
pub(crate) fn run_command(command: &mut Command) -> Run {
    let quiet =
        ["CARGO_TERM_COLOR", "CARGO_BUILD_TARGET", "CLICOLOR", "CLICOLOR_FORCE", "GITHUB_STEP_SUMMARY", "RUSTFLAGS"];
    for name in quiet {
        command.env_remove(name);
    }
    let Output { status, stdout, stderr } =
        command.env("NO_COLOR", "1").output().expect("the program was built and starts");
    Run {
        code: status.code(),
        stdout: String::from_utf8(stdout).expect("stdout is UTF-8"),
        stderr: String::from_utf8_lossy(&stderr).into_owned(),
    }
}

/// Checks one file on its own, with these rules switched on.
pub(crate) fn check_file(path: &Path, warned: &[String]) -> Run {
    check_files(path.parent().expect("a file lies in a directory"), &[path], warned)
}

/// Checks files, each on its own, in one run.
pub(crate) fn check_files(directory: &Path, paths: &[&Path], warned: &[String]) -> Run {
    let mut args = vec![OsStr::new("--message-format"), OsStr::new("json")];
    args.extend(paths.iter().map(|path| path.as_os_str()));
    for rule in warned {
        args.extend([OsStr::new("-W"), OsStr::new(rule)]);
    }
    run(directory, args)
}

/// The proof report of one file on its own.
pub(crate) fn report_file(path: &Path) -> Run {
    report_files(path.parent().expect("a file lies in a directory"), &[path])
}

/// The proof report of files, each on its own, in one run.
pub(crate) fn report_files(directory: &Path, paths: &[&Path]) -> Run {
    let mut args = vec![OsStr::new("report"), OsStr::new("--message-format"), OsStr::new("json")];
    args.extend(paths.iter().map(|path| path.as_os_str()));
    run(directory, args)
}

impl Run {
    /// Asserts how the run ended, showing what it printed otherwise.
    #[track_caller]
    pub(crate) fn assert_code(&self, code: i32) -> &Self {
        assert_eq!(self.code, Some(code), "stdout:\n{}\nstderr:\n{}", self.stdout, self.stderr);
        self
    }

    /// Asserts that stderr holds a text.
    #[track_caller]
    pub(crate) fn assert_stderr(&self, text: &str) -> &Self {
        assert!(self.stderr.contains(text), "`{text}` is not in stderr:\n{}", self.stderr);
        self
    }

    /// Asserts that nothing that was printed looks like a crash.
    #[track_caller]
    pub(crate) fn assert_no_panic(&self) -> &Self {
        for text in [&self.stdout, &self.stderr] {
            assert!(!text.contains("panicked at") && !text.contains("RUST_BACKTRACE"), "{text}");
            assert!(!text.contains("has overflowed its stack"), "{text}");
        }
        assert!(self.code.is_some(), "ended by a signal:\n{}", self.stderr);
        self
    }

    /// The findings of a run with `--message-format json`, suppressed ones left out, in the order printed.
    ///
    /// # Errors
    ///
    /// A line that is not JSON, a run without the closing `build-finished`, or one that could not read everything.
    pub(crate) fn findings(&self) -> Result<Vec<Finding>, String> {
        if !matches!(self.code, Some(0 | 100)) {
            return Err(format!("the run ended with {:?}:\n{}", self.code, self.stderr));
        }
        self.findings_in_spite_of_problems()
    }

    /// The same, whatever the exit code was.
    ///
    /// # Errors
    ///
    /// A line that is not JSON, or a run without the closing `build-finished`.
    pub(crate) fn findings_in_spite_of_problems(&self) -> Result<Vec<Finding>, String> {
        let mut findings = Vec::new();
        let mut is_finished = false;
        for line in self.stdout.lines() {
            let message: Value = serde_json::from_str(line).map_err(|error| format!("not JSON ({error}): {line}"))?;
            match message["reason"].as_str() {
                Some("compiler-message") => findings.extend(finding(&message["message"])),
                Some("build-finished") => is_finished = true,
                _ => {}
            }
        }
        if is_finished { Ok(findings) } else { Err(format!("the run printed no `build-finished`:\n{}", self.stderr)) }
    }

    /// All pairs of a run of `report --message-format json`.
    ///
    /// # Errors
    ///
    /// Output that is not the report's JSON form.
    pub(crate) fn pairs(&self) -> Result<Vec<Pair>, String> {
        let report: Value =
            serde_json::from_str(&self.stdout).map_err(|error| format!("no report ({error}):\n{}", self.stderr))?;
        let list = |value: &Value| value.as_array().cloned().unwrap_or_default();
        let text = |value: &Value| value.as_str().unwrap_or_default().to_owned();
        let mut pairs = Vec::new();
        for cycle in list(&report["cycles"]) {
            for filter in list(&cycle["filters"]) {
                pairs.push(Pair {
                    file: text(&cycle["file"]),
                    function: text(&cycle["function"]),
                    line: cycle["line"].as_u64().unwrap_or_default() as usize,
                    kind: text(&cycle["kind"]),
                    name: text(&filter["name"]),
                    verdict: text(&filter["verdict"]),
                    counts: list(&filter["counts"]).iter().filter_map(Value::as_u64).collect(),
                    gate: filter["gate"].as_str().map(str::to_owned),
                });
            }
        }
        Ok(pairs)
    }
}

/// A message that is a finding of ours and is not suppressed.
fn finding(message: &Value) -> Option<Finding> {
    let rule = message["code"]["code"].as_str()?.strip_prefix("ceid::")?.to_owned();
    if !message["ceid"]["suppressed"].is_null() {
        return None;
    }
    let spans = message["spans"].as_array()?;
    let primary = spans.iter().find(|span| span["is_primary"] == true)?;
    Some(Finding {
        file: primary["file_name"].as_str()?.replace('\\', "/"),
        line: primary["line_start"].as_u64()? as usize,
        rule,
        message: message["message"].as_str().unwrap_or_default().to_owned(),
        is_fixable: message["children"].as_array()?.iter().any(|child| {
            let mut spans = child["spans"].as_array().into_iter().flatten();
            spans.any(|span| span["suggested_replacement"].is_string())
        }),
    })
}
