//! A check that remembers the one before it finds what a fresh one finds, whatever was typed in between.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use cargo_ceid_lint::pipeline::{Memory, Options, Report, check_again, check_configured};
use cargo_ceid_lint::project::{self, Project, Selection};
use cargo_ceid_lint::report::text;
use cargo_ceid_lint::source::{DiskSource, MemorySource, ReadSource};

use crate::gate::{Choices, generated};
use crate::support::workspace::committed;

/// The files that are open.
const OPEN: [&str; 4] = ["filters/src/lib.rs", "middle/src/lib.rs", "application/src/lib.rs", "alike/src/lib.rs"];

/// What is typed.
const LINES: [&str; 16] = [
    "",
    "// ceid: cycle",
    "pub struct Other(pub f64);",
    "pub fn again(kf: &mut filters::Kf) { use filters::SampledFilter; loop { kf.update(); kf.update(); } }",
    "pub fn never(kf: &mut filters::Kf) { loop { if kf.0 > 0.0 { continue; } filters::step(kf); } }",
    "impl SampledFilter for u8 { fn update(&mut self) {} }",
    "pub fn broken( {",
    "#[path = \"../../spare/src/lib.rs\"] pub mod spare;",
    "include!(\"../../filters/src/lib.rs\");",
    "pub mod gone;",
    "macro_rules! twice { ($e:expr) => { $e; $e; } }",
    "#[macro_export] macro_rules! again { ($e:expr) => { $crate::step($e); $crate::step($e); } }",
    "pub fn by_macro(kf: &mut filters::Kf) { loop { filters::again!(kf); } }",
    "#![cfg(test)]",
    "/* ",
    "pub trait SampledFilter { fn update(&mut self, x: f64); }",
];

fn source(texts: &[(PathBuf, String)]) -> Box<dyn ReadSource> {
    let mut source = MemorySource::over(Box::new(DiskSource));
    for (path, text) in texts {
        source.insert(path, Arc::from(text.as_str()));
    }
    Box::new(source)
}

/// Everything that a report tells.
fn told(report: &Report) -> String {
    let files: Vec<String> = report.sources.files().map(|(id, file)| format!("{id:?} {}", file.name)).collect();
    format!(
        "{}\n{:#?}\n{:?}\n{:?}\n{:?}\n{:?}\n{} {}\n{files:?}",
        text::report(report),
        report.diagnostics,
        report.cycles,
        report.problems,
        report.unread,
        report.left_out,
        report.filter_types,
        report.presumed,
    )
}

fn loaded(directory: &Path) -> Project {
    let manifest_path = Some(directory.join("Cargo.toml"));
    let selection =
        Selection { current_dir: directory.to_owned(), manifest_path, workspace: true, ..Selection::default() };
    project::load(&selection).expect("the workspace can be loaded")
}

#[test]
fn what_is_remembered_is_what_a_fresh_check_finds() {
    let (mut kept, mut taken_over) = (0, 0);
    for seed in 0..3 {
        let directory = generated(&format!("again_{seed}"), seed);
        let project = loaded(&directory);
        let open = OPEN.map(|name| directory.join(name).canonicalize().expect("it was written"));
        let original = open.map(|path| (path.clone(), std::fs::read_to_string(&path).expect("it was written")));
        let mut texts = original.to_vec();
        let (mut choices, mut memory) = (Choices(seed), Memory::default());
        let mut before = Vec::new();
        for step in 0..40 {
            let at = usize::try_from(choices.below(4)).expect("it is small");
            let mut lines: Vec<&str> = texts[at].1.lines().collect();
            let line = usize::try_from(choices.below(lines.len() as u64 + 1)).expect("it is small");
            match choices.below(4) {
                0 => lines.clone_from(&original[at].1.lines().collect()),
                1 if line < lines.len() => drop(lines.remove(line)),
                _ => lines.insert(line, choices.one(&LINES)),
            }
            texts[at].1 = lines.join("\n");
            let again = check_again(&project, &Options::default(), source(&texts), &mut memory);
            taken_over += again.parts.iter().filter(|part| before.iter().any(|old| Arc::ptr_eq(old, part))).count();
            before.clone_from(&again.parts);
            let fresh = check_configured(&project, &Options::default(), source(&texts));
            assert_eq!(
                told(&Report::of_parts(again.parts, project.root.clone())),
                told(&fresh.report),
                "seed {seed}, step {step}: {texts:#?}"
            );
            kept += usize::from(!again.is_config_wrong);
        }
    }
    assert!(kept > 50, "most of what is typed can be checked");
    assert!(taken_over > 50, "parts in which nothing was typed stay as they are: {taken_over}");
}

#[test]
fn what_calls_a_macro_of_another_crate_changes_with_it() {
    let directory = committed("macros_between_crates");
    let project = loaded(&directory);
    let path = |name: &str| directory.join(name).canonicalize().expect("it is there");
    let opened = [path("control/src/macros.rs"), path("plant/src/imported.rs")];
    let mut texts = opened.map(|path| (path.clone(), std::fs::read_to_string(&path).expect("it is there")));
    let law = "$crate::within(|| $crate::SampledFilter::update(&mut $filter, $z))";
    let macros = texts[0].1.clone();
    let mut memory = Memory::default();
    let mut told_of = |macros: String| {
        texts[0].1 = macros;
        let again = check_again(&project, &Options::default(), source(&texts), &mut memory);
        let fresh = check_configured(&project, &Options::default(), source(&texts));
        let report = Report::of_parts(again.parts, project.root.clone());
        assert_eq!(told(&report), told(&fresh.report));
        let imported = report
            .diagnostics
            .iter()
            .filter(|finding| report.sources.file(finding.primary.span.file).name.ends_with("imported.rs"));
        imported.map(|finding| finding.rule).collect::<Vec<_>>()
    };
    assert_eq!(told_of(macros.clone()), ["repeated_update"; 2]);
    let nothing = macros.replace(law, "{ let _ = (&$filter, $z); }");
    assert_eq!(told_of(nothing), ["missed_update"; 3]);
    assert_eq!(told_of(macros), ["repeated_update"; 2]);
}
