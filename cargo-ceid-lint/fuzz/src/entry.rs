//! The whole pipeline over one text, as the fuzzer and the default tests run it: from parsing to every format.

use std::path::Path;
use std::sync::Arc;

use cargo_ceid_lint::config::Config;
use cargo_ceid_lint::pipeline::{Gate, check_with};
use cargo_ceid_lint::project::{CfgValues, Package, Project, Target, TargetKind};
use cargo_ceid_lint::report::{self, Style, Summary, html, json, proof, short, text};
use cargo_ceid_lint::source::MemorySource;

/// A trait that makes the pipeline look at bodies, whatever the text says.
const FILTERS: &str = "\npub trait SampledFilter { fn update(&mut self); }\n";

/// Checks a library of this text, and of this text with a filter trait, and writes every format.
///
/// # Panics
/// If the linter has a bug.
pub(crate) fn check(source: &str) {
    check_edition(source, "2024");
    check_edition(&format!("{source}{FILTERS}"), if source.len().is_multiple_of(2) { "2015" } else { "2021" });
}

fn check_edition(source: &str, edition: &str) {
    let path = Path::new("/demo/src/lib.rs");
    let mut memory = MemorySource::default();
    memory.insert(path, Arc::from(source));
    let project = project(path, edition);
    let Ok(report) = check_with(&project, &Config::default(), Box::new(memory), Gate::On) else { return };
    let style = Style { color: true, hyperlinks: true, full_trace: true };
    let mut written = 0;
    for diagnostic in &report.diagnostics {
        written += text::diagnostic(&report.sources, diagnostic, style).len();
        written += short::diagnostic(&report.sources, diagnostic).len();
    }
    for problem in &report.problems {
        written += text::problem(&report.sources, problem, style).len();
    }
    written += json::messages(&project, &report, json::Options::default()).len();
    written += proof::json(&project, &report, None).len() + proof::human(&project, &report, None, style).len();
    written += html::page(&project, &report, None).len();
    written += report::stats(&project, &report).len() + Summary::of(&report).line().len();
    assert!(written > 0);
}

fn project(path: &Path, edition: &str) -> Project {
    let target = Target {
        name: "demo".to_owned(),
        crate_name: "demo".to_owned(),
        kind: TargetKind::Lib,
        src_path: path.to_owned(),
        edition: edition.to_owned(),
        is_reported: true,
        cfg_test: false,
        cargo: Default::default(),
    };
    let package = Package {
        name: "demo".to_owned(),
        id: "path+file:///demo#0.1.0".to_owned(),
        version: "0.1.0".to_owned(),
        manifest_path: "/demo/Cargo.toml".into(),
        workspace_root: "/demo".into(),
        is_reported: true,
        is_unresolved: false,
        dependencies: Vec::new(),
        targets: vec![target],
        roots_left_out: Vec::new(),
        is_member: true,
        is_default: true,
        is_partly_read: false,
        cfg: CfgValues::default(),
        metadata: None,
    };
    Project { root: "/demo".into(), packages: vec![package], ..Project::default() }
}
