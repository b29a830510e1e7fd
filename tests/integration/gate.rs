//! Packages without any filter are not parsed: what is found is the same, whoever is linked with whom and by what.

use std::path::Path;

use cargo_ceid_lint::pipeline::{Gate, Options, Report, check_configured};
use cargo_ceid_lint::project::{self, Selection};
use cargo_ceid_lint::report::text;
use cargo_ceid_lint::source::DiskSource;

use crate::support::program::run;
use crate::support::workspace::{GUILTY, temporary, write};

/// More code than is parsed in any case.
fn padding() -> String {
    (0..6_000).map(|number| format!("pub fn nothing_{number}() -> u8 {{ 0 }} // There is nothing to see.\n")).collect()
}

fn package(directory: &Path, name: &str, dependencies: &[&str], text: &str) {
    let dependencies: String =
        dependencies.iter().map(|other| format!("{other} = {{ path = \"../{other}\" }}\n")).collect();
    let manifest = format!(
        "[package]\nname = \"{name}\"\nversion = \"0.1.0\"\nedition = \"2024\"\n[dependencies]\n{dependencies}"
    );
    write(directory, &format!("{name}/Cargo.toml"), manifest.as_bytes());
    write(directory, &format!("{name}/src/lib.rs"), text.as_bytes());
}

fn workspace(name: &str) -> std::path::PathBuf {
    let directory = temporary(name);
    write(&directory, "Cargo.toml", b"[workspace]\nresolver = \"3\"\nmembers = [\"*\"]\nexclude = [\"loose\"]\n");
    package(&directory, "padding", &[], &padding());
    directory
}

fn check(directory: &Path, gate: Gate) -> (String, Report) {
    let selection = Selection {
        current_dir: directory.to_owned(),
        manifest_path: Some(directory.join("Cargo.toml")),
        workspace: true,
        ..Selection::default()
    };
    let project = project::load(&selection).expect("the workspace can be loaded");
    let checked = check_configured(&project, &Options { gate, ..Options::default() }, Box::new(DiskSource));
    let report = checked.report;
    let findings: Vec<String> = report
        .diagnostics
        .iter()
        .map(|finding| {
            format!("{} {} {:?}\n", finding.rule, finding.message, report.sources.position(finding.primary.span))
        })
        .collect();
    let counts = format!("{} filter types, {} presumed\n", report.filter_types, report.presumed);
    (text::report(&report) + &counts + &findings.concat(), report)
}

/// Numbers that are the same in every run.
pub(crate) struct Choices(pub(crate) u64);

impl Choices {
    pub(crate) fn below(&mut self, end: u64) -> u64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 33) % end
    }

    pub(crate) fn one<'a>(&mut self, of: &[&'a str]) -> &'a str {
        of[usize::try_from(self.below(of.len() as u64)).expect("it is small")]
    }
}

/// A workspace in which an application reaches filters by way of others, each time in another way.
pub(crate) fn generated(name: &str, seed: u64) -> std::path::PathBuf {
    let mut choices = Choices(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15));
    let directory = workspace(name);
    let filter = "pub struct Kf(pub f64);
        impl SampledFilter for Kf { fn update(&mut self) { self.0 += 1.0; } }
        pub trait SampledFilter { fn update(&mut self); }
        pub fn step(kf: &mut impl SampledFilter) { kf.update(); }
        #[macro_export] macro_rules! stepped { ($kf:expr) => { $crate::step(&mut $kf) } }\n";
    let middle = choices.one(&[
        "pub use filters::*; pub struct Robot { pub kf: Kf }",
        "use filters::Kf as Estimator; pub type Alias = Estimator; pub struct Robot { pub kf: Alias }",
        "pub mod parts { pub use filters::{Kf as Part, step as tick_part}; } pub struct Robot { pub kf: parts::Part }",
    ]);
    let body = choices.one(&[
        "filters::step(&mut self.kf);",
        "use filters::SampledFilter; self.kf.update(); self.kf.update();",
        "use filters::SampledFilter as _; if self.kf.0 > 1.0 { self.kf.update(); }",
        "twice!(filters::step(&mut self.kf));",
        "filters::stepped!(self.kf);",
    ]);
    let tick = format!(
        "{middle}\nmacro_rules! twice {{ ($e:expr) => {{ $e; $e; }} }}
        impl Robot {{ pub fn tick(&mut self) {{ {body} }} pub fn idle(&self) {{}} }}
        pub trait Task {{ fn run(&mut self); }} impl Task for Robot {{ fn run(&mut self) {{ self.tick(); }} }}\n"
    );
    let application = choices.one(&[
        "pub fn run(mut robot: middle::Robot) { loop { robot.tick(); robot.idle(); } }",
        "pub fn run(mut robot: middle::Robot) { for n in 0.. { if n % 2 == 0 { continue; } robot.tick(); } }",
        "pub fn run(task: &mut dyn middle::Task) { loop { task.run(); } }",
        "use middle::Task as _; pub fn run(mut robot: middle::Robot) { loop { robot.run(); robot.run(); } }",
    ]);
    package(&directory, "filters", &[], filter);
    package(&directory, "middle", &["filters"], &tick);
    package(&directory, "application", &["middle", "helper"], application);
    package(&directory, "helper", &[], "pub fn wait() {}");
    // A package whose module lies in no package, or in another one.
    let place = choices.one(&["../../loose/guilty.rs", "../../spare/src/guilty.rs", "guilty.rs", "guilty.inc"]);
    let link = match choices.below(3) {
        0 => format!("#[path = \"{place}\"] pub mod guilty;"),
        1 => format!("#[cfg_attr(all(), path = \"{place}\")] pub mod guilty;"),
        _ => format!("include!(\"{place}\");"),
    };
    package(&directory, "linking", &[], &link);
    package(&directory, "spare", &[], "pub fn spare() {}");
    write(&directory, &Path::new("linking/src").join(place).display().to_string(), GUILTY.as_bytes());
    // A filter that only the configuration names, behind a re-export.
    package(
        &directory,
        "named",
        &[],
        "mod pid { pub struct Pid; impl Pid { pub fn calc(&mut self) {} } }\npub use pid::*;",
    );
    package(&directory, "user", &["named"], "pub fn run(mut pid: named::Pid) { loop { pid.calc(); pid.calc(); } }");
    let path = choices.one(&["crate::Pid", "crate::pid::Pid", "named::Pid"]);
    write(&directory, "ceid-lint.toml", format!("[[filter]]\ntype = \"{path}\"\nlaw = \"calc\"\n").as_bytes());
    // Packages of the same names of methods, that have nothing to do with any of it.
    package(&directory, "alike", &["other"], "pub fn run(mut kf: other::Kf) { loop { kf.update(); kf.update(); } }");
    package(
        &directory,
        "other",
        &[],
        "pub struct Kf; impl Kf { pub fn update(&mut self) {} pub fn calc(&mut self) {} }",
    );
    directory
}

#[test]
fn included_files_of_any_name_are_looked_into() {
    let directory = workspace("gate_included");
    package(&directory, "linking", &[], "include!(\"outer.in\");");
    write(&directory, "linking/src/outer.in", b"pub mod parts { include!(\"parts/inner.tpl\"); }");
    write(&directory, "linking/src/parts/inner.tpl", GUILTY.as_bytes());
    let text = "pub const TEXT: &str = \"\n#[path = \\\"../../x.rs\\\"] mod x; include!($file);\n\";";
    package(&directory, "tool", &[], text);
    let (gated, report) = check(&directory, Gate::On);
    let (full, _) = check(&directory, Gate::Off);
    assert_eq!(gated, full);
    assert!(gated.contains("repeated_update"), "{gated}");
    assert_eq!(report.unparsed.len(), 2, "`padding` and `tool`: a text in a string is no code");
}

#[test]
fn what_is_found_is_the_same_with_and_without_the_gate() {
    for seed in 0..5 {
        let directory = generated(&format!("gate_{seed}"), seed);
        let (gated, report) = check(&directory, Gate::On);
        let (full, _) = check(&directory, Gate::Off);
        let (whole, _) = check(&directory, Gate::Whole);
        assert_eq!(gated, full, "seed {seed}");
        assert_eq!(gated, whole, "seed {seed}");
        assert!(!report.unparsed.is_empty(), "seed {seed}: everything was parsed");
        assert!(report.cycles.len() >= 2, "seed {seed}: {gated}");
        assert!(report.problems.is_empty(), "seed {seed}: {:?}", report.problems);
    }
}

#[test]
fn what_is_broken_where_no_filter_is_can_be_asked_for() {
    let directory = workspace("gate_broken");
    package(&directory, "guilty", &[], GUILTY);
    package(&directory, "broken", &[], "pub fn broken( {");
    run(&directory, ["--workspace"]).assert_no_panic().assert_code(100);
    run(&directory, ["--workspace", "--no-gate"]).assert_code(101).assert_stderr("broken/src/lib.rs");
    run(&directory, ["broken/src/lib.rs"]).assert_code(101).assert_stderr("broken/src/lib.rs");
}

#[test]
fn an_entry_that_names_nothing_is_still_an_error() {
    let directory = workspace("gate_entry");
    package(&directory, "guilty", &[], GUILTY);
    write(&directory, "ceid-lint.toml", b"[[filter]]\ntype = \"crate::Kalmann\"\nlaw = \"update\"\n");
    run(&directory, ["--workspace"]).assert_code(101).assert_stderr("did you mean").assert_stderr("Kalman");
}

#[test]
fn features_are_those_that_cargo_turns_on() {
    let directory = workspace("gate_features");
    package(&directory, "guilty", &[], GUILTY);
    for (default, expected) in [("[\"trial\"]", 2), ("[]", 1)] {
        let manifest = format!(
            "[package]\nname = \"pilot\"\nversion = \"0.1.0\"\nedition = \"2024\"\n[features]\ndefault = {default}\ntrial = []\n"
        );
        write(&directory, "pilot/Cargo.toml", manifest.as_bytes());
        write(&directory, "pilot/src/lib.rs", b"#[cfg(feature = \"trial\")]\nmod trial;\n");
        write(&directory, "pilot/src/trial.rs", GUILTY.as_bytes());
        let entry = |name: &str| format!("\n[[package]]\nname = \"{name}\"\nversion = \"0.1.0\"\n");
        let lock: String = ["guilty", "padding", "pilot"].map(entry).concat();
        write(&directory, "Cargo.lock", format!("version = 4\n{lock}").as_bytes());
        let found = run(&directory, ["--workspace", "--message-format", "json"]).assert_code(100).findings();
        assert_eq!(found.expect("it can be read").len(), expected, "{default}");
    }
}
