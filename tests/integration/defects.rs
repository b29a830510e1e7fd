//! The robot with one human error planted in it: the linter or the compiler stops every one.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::{env, fs};

use serde_json::Value;

use crate::support::{program, root, workspace};

/// Two robots without a defect, each with its variants in the folder of its name.
const ROBOTS: [(&str, &str); 2] = [("legacy", "by hand"), ("guarded", "with `ceid-core`")];

struct Variant {
    robot: &'static str,
    path: PathBuf,
    text: String,
}

impl Variant {
    fn name(&self) -> String {
        let stem = self.path.file_stem().expect("a variant has a name");
        format!("{}_{}", self.robot, stem.to_string_lossy())
    }

    fn read(robot: &'static str, path: PathBuf) -> Self {
        let text = fs::read_to_string(&path).expect("the fixtures are readable");
        Self { robot, path, text }
    }

    /// What its first line says.
    fn defect(&self) -> &str {
        let line = self.text.lines().next().and_then(|line| line.strip_prefix("//! "));
        line.unwrap_or_else(|| panic!("{} does not say what its defect is", self.name()))
    }

    /// Who stops it, and as what: `linter missed_update`, `compiler E0061`.
    fn stopped_by(&self) -> (&str, &str) {
        let line = self.text.lines().nth(1).and_then(|line| line.strip_prefix("//@ stopped-by: "));
        let words = line.and_then(|words| words.split_once(' '));
        words.unwrap_or_else(|| panic!("{} does not say who stops it", self.name()))
    }
}

fn intact() -> Vec<Variant> {
    ROBOTS.map(|(robot, _)| Variant::read(robot, directory().join(robot).with_extension("rs"))).into()
}

fn variants() -> Vec<Variant> {
    let mut variants = Vec::new();
    for (robot, _) in ROBOTS {
        let entries = fs::read_dir(directory().join(robot)).expect("the fixtures are readable");
        let mut paths: Vec<_> = entries.map(|entry| entry.expect("the fixtures are readable").path()).collect();
        paths.sort();
        variants.extend(paths.into_iter().map(|path| Variant::read(robot, path)));
    }
    variants
}

fn directory() -> PathBuf {
    root().join("fixtures/defects")
}

/// What the compiler says first of each that it rejects: code and message.
fn compile(name: &str, variants: &[Variant]) -> BTreeMap<String, (String, String)> {
    let core = root().join("ceid-core");
    let mut manifest = format!(
        "[workspace]\n\n[package]\nname = \"defects\"\nversion = \"0.0.0\"\nedition = \"2024\"\n\n[dependencies]\n\
         ceid-core = {{ path = {core:?} }}\n"
    );
    for variant in variants {
        let (name, path) = (variant.name(), &variant.path);
        write!(manifest, "\n[[example]]\nname = \"{name}\"\npath = {path:?}\ncrate-type = [\"lib\"]\n")
            .expect("a String");
    }
    let directory = workspace::temporary(name);
    workspace::write(&directory, "Cargo.toml", manifest.as_bytes());
    workspace::write(&directory, "src/lib.rs", b"");
    fs::copy(root().join("Cargo.lock"), directory.join("Cargo.lock")).expect("the workspace has a lock file");
    let output = Command::new(env::var_os("CARGO").unwrap_or_else(|| "cargo".into()))
        .args(["check", "--offline", "--quiet", "--examples", "--keep-going", "--message-format", "json"])
        .arg("--manifest-path")
        .arg(directory.join("Cargo.toml"))
        .arg("--target-dir")
        .arg(Path::new(env!("CARGO_TARGET_TMPDIR")).join("fixtures_compile_target"))
        .env("RUSTFLAGS", "-Awarnings")
        .output()
        .expect("cargo is installed");
    let stdout = String::from_utf8(output.stdout).expect("cargo prints UTF-8");
    let mut errors = BTreeMap::new();
    for message in stdout.lines().filter_map(|line| serde_json::from_str::<Value>(line).ok()) {
        let text = |pointer| message.pointer(pointer).and_then(Value::as_str).map(str::to_owned);
        if text("/message/level").as_deref() != Some("error") {
            continue;
        }
        if let (Some(target), Some(code), Some(said)) =
            (text("/target/name"), text("/message/code/code"), text("/message/message"))
        {
            errors.entry(target).or_insert((code, said));
        }
    }
    // Nothing but a variant may be what fails.
    assert_eq!(output.status.success(), errors.is_empty(), "{}", String::from_utf8_lossy(&output.stderr));
    errors
}

/// The rules that find something in it, each with its message.
fn lint(variant: &Variant) -> Vec<(String, String)> {
    let run = program::check_file(&variant.path, &["time_in_cycle".to_owned()]);
    let findings = run.findings().unwrap_or_else(|error| panic!("{}: {error}", variant.name()));
    findings.into_iter().map(|finding| (finding.rule, finding.message)).collect()
}

#[test]
fn the_robots_without_a_defect_pass() {
    let intact = intact();
    assert_eq!(compile("defects_intact", &intact), BTreeMap::new());
    for robot in &intact {
        assert_eq!(lint(robot), [], "{}", robot.name());
    }
}

#[test]
fn each_variant_has_one_human_error() {
    let intact = intact();
    for variant in variants() {
        let robot = intact.iter().find(|robot| robot.robot == variant.robot).expect("it is a variant of one");
        let without = |one: &Variant, other: &Variant| {
            let mut others: Vec<&str> = other.text.lines().collect();
            // Each line of the other one stands for one line of this.
            let is_taken = |line: &str| others.iter().position(|it| *it == line).map(|at| others.swap_remove(at));
            let new = one.text.lines().map(is_taken).zip(one.text.lines()).filter(|(taken, _)| taken.is_none());
            new.filter(|(_, line)| !line.starts_with("//")).count()
        };
        let changed = without(&variant, robot).max(without(robot, &variant));
        assert!((1..=12).contains(&changed), "{} differs in {changed} lines", variant.name());
    }
}

/// The table of the documentation is what the linter and the compiler say.
#[test]
fn each_defect_is_stopped_as_the_documentation_says() {
    let variants = variants();
    let errors = compile("defects", &variants);
    let mut table = "| defect | written | stopped by | message |\n| --- | --- | --- | --- |\n".to_owned();
    for (_, written) in ROBOTS {
        for variant in variants.iter().filter(|variant| ROBOTS.contains(&(variant.robot, written))) {
            let (who, what) = variant.stopped_by();
            let found = lint(variant);
            let error = errors.get(&variant.name());
            let message = match (who, error, found.as_slice()) {
                ("linter", None, [(rule, message)]) if rule == what => message,
                ("compiler", Some((code, message)), _) if code == what => message,
                _ => panic!("{}: stopped by {who} {what}? {error:?} {found:?}", variant.name()),
            };
            writeln!(table, "| {} | {written} | {who}, `{what}` | {message} |", variant.defect()).expect("a String");
        }
    }
    table.push('\n');
    let readme = fs::read_to_string(root().join("ceid-core/README.md")).expect("the crate has a README");
    assert!(readme.contains(&table), "ceid-core/README.md does not hold this table:\n\n{table}");
}

/// The robot itself, as the example has it.
#[test]
fn every_filter_of_the_example_is_proved() {
    let args = ["report", "--offline", "-p", "ceid-core", "--example", "subsumption", "--message-format", "json"];
    let pairs = program::run(&root(), args).pairs().expect("the run succeeds");
    assert_eq!(pairs.len(), 14, "{pairs:?}");
    assert!(pairs.iter().all(|pair| pair.verdict == "guarded" && pair.counts == [1]), "{pairs:?}");
}
