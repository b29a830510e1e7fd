//! cargo's own messages, one JSON object a line, so that editors and every other reader of cargo's output work unchanged.

mod fixes;
mod message;
mod span;

use std::path::Path;

pub use fixes::{FixOutcome, fixes};

use serde::Serialize;
use serde_json::Value;

use crate::diagnostic::Problem;
use crate::pipeline::Report;
use crate::project::{Package, Project};

/// What the field `rendered` holds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Rendered {
    /// The human form without colours.
    #[default]
    Plain,
    /// The human form with ANSI colours.
    Ansi,
    /// One line.
    Short,
}

/// What is written.
#[derive(Clone, Copy, Debug, Default)]
pub struct Options {
    /// What the field `rendered` holds.
    pub rendered: Rendered,
    /// Whether findings are left to the human form: `json-render-diagnostics`.
    pub without_diagnostics: bool,
    /// Whether nothing is said to be clean, because nothing was checked.
    pub without_artifacts: bool,
    /// Whether the run succeeded.
    pub success: bool,
}

#[derive(Serialize)]
struct CompilerMessage<'a> {
    reason: &'static str,
    package_id: &'a str,
    manifest_path: &'a Path,
    target: &'a Value,
    message: message::Message,
}

#[derive(Serialize)]
struct CompilerArtifact<'a> {
    reason: &'static str,
    package_id: &'a str,
    manifest_path: &'a Path,
    target: &'a Value,
    profile: Profile,
    features: Vec<&'a str>,
    filenames: [&'static str; 0],
    executable: Option<&'static str>,
    fresh: bool,
}

#[derive(Serialize)]
struct Profile {
    opt_level: &'static str,
    debuginfo: u32,
    debug_assertions: bool,
    overflow_checks: bool,
    test: bool,
}

#[derive(Serialize)]
struct BuildFinished {
    reason: &'static str,
    success: bool,
}

/// All messages of a run: findings, problems, an artifact for every clean target, and the end.
///
/// Findings come before artifacts: an artifact makes an editor forget what it knew about the package before this run.
#[must_use]
pub fn messages(project: &Project, report: &Report, options: Options) -> String {
    let mut text = String::new();
    let mut unclean = std::collections::BTreeSet::new();
    let fingerprints = super::fingerprint::fingerprints(&report.sources, &report.diagnostics);
    for (diagnostic, fingerprint) in report.diagnostics.iter().zip(fingerprints) {
        let at = (diagnostic.package, diagnostic.target);
        // A target with nothing but suppressed and known findings is clean, and its artifact follows.
        if diagnostic.is_shown() {
            unclean.insert(at);
        }
        let message = message::of_diagnostic(&report.sources, diagnostic, fingerprint, options.rendered);
        push_message(&mut text, project, at, message, options);
    }
    for problem in &report.problems {
        let at = owner(project, report, problem);
        unclean.insert(at);
        let message = message::of_problem(&report.sources, problem, options.rendered);
        push_message(&mut text, project, at, message, options);
    }
    for (package_at, package) in project.packages.iter().enumerate() {
        for (target_at, target) in package.targets.iter().enumerate() {
            if target.is_reported && !options.without_artifacts && !unclean.contains(&(package_at, target_at)) {
                push(&mut text, &artifact(package, &target.cargo));
            }
        }
    }
    push(&mut text, &BuildFinished { reason: "build-finished", success: options.success });
    text
}

fn push_message(
    text: &mut String,
    project: &Project,
    (package, target): (usize, usize),
    message: message::Message,
    options: Options,
) {
    if options.without_diagnostics {
        return;
    }
    let Some(package) = project.packages.get(package) else { return };
    let cargo = package.targets.get(target).map_or(&Value::Null, |target| &target.cargo);
    push(
        text,
        &CompilerMessage {
            reason: "compiler-message",
            package_id: &package.id,
            manifest_path: &package.manifest_path,
            target: cargo,
            message,
        },
    );
}

fn artifact<'a>(package: &'a Package, target: &'a Value) -> CompilerArtifact<'a> {
    let is_debug = package.cfg.flags.contains("debug_assertions");
    CompilerArtifact {
        reason: "compiler-artifact",
        package_id: &package.id,
        manifest_path: &package.manifest_path,
        target,
        profile: Profile {
            opt_level: if is_debug { "0" } else { "3" },
            debuginfo: if is_debug { 2 } else { 0 },
            debug_assertions: is_debug,
            overflow_checks: is_debug,
            test: false,
        },
        features: package.cfg.values.get("feature").into_iter().flatten().map(String::as_str).collect(),
        filenames: [],
        executable: None,
        fresh: false,
    }
}

fn push(text: &mut String, message: &impl Serialize) {
    text.push_str(&serde_json::to_string(message).expect("paths were read as text, the rest is text and numbers"));
    text.push('\n');
}

/// The package and target that a problem is reported for: the one whose root it is, or whose directory it lies in.
fn owner(project: &Project, report: &Report, problem: &Problem) -> (usize, usize) {
    let path = match problem.span {
        Some(span) => report.sources.file(span.file).path.clone(),
        None => project.root.join(&problem.file),
    };
    let reported = || project.packages.iter().enumerate().filter(|(_, package)| package.is_reported);
    let directory = |package: &Package| package.manifest_path.parent().map(Path::to_owned).unwrap_or_default();
    for (at, package) in reported() {
        if let Some(target) = package.targets.iter().position(|target| target.src_path == path) {
            return (at, target);
        }
    }
    let around = reported().filter(|(_, package)| path.starts_with(directory(package)));
    let package =
        around.max_by_key(|(_, package)| directory(package).components().count()).or_else(|| reported().next());
    package
        .map_or((0, 0), |(at, package)| (at, package.targets.iter().position(|target| target.is_reported).unwrap_or(0)))
}

#[cfg(test)]
mod tests;
