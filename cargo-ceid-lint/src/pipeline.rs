//! From a project to a report: the one function to read first.

use std::collections::{BTreeMap, BTreeSet};

use crate::config::{Config, FilterEntry, FilterKind, Scope, Section};
use crate::count::{Cycle, analyse};
use crate::diagnostic::{Diagnostic, Level, Problem};
use crate::flow::{Program, lower_function};
use crate::index::{CrateInput, Index, ModuleId};
use crate::project::{Project, TargetKind};
use crate::rules::{self, Known, RULES};
use crate::source::{DiskSource, FileSet, ReadSource, SourceMap, Span};
use crate::suppress::{Crate, Suppressions};
use crate::syntax::{Directives, parse_crate, with_large_stack};

/// What a run found out.
#[derive(Debug, Default)]
pub struct Report {
    /// Every text that was read.
    pub sources: SourceMap,
    /// The findings at `warn` or above, suppressed ones included, sorted by file, place and rule.
    pub diagnostics: Vec<Diagnostic>,
    /// Every cycle with its filters and their verdicts, sorted by file and place.
    pub cycles: Vec<Cycle>,
    /// What could not be read or parsed.
    pub problems: Vec<Problem>,
    /// How many filter types were found.
    pub filter_types: usize,
}

impl Report {
    /// The findings that nothing suppresses: those that people see and that decide how a run ends.
    pub fn shown(&self) -> impl Iterator<Item = &Diagnostic> {
        self.diagnostics.iter().filter(|finding| finding.suppressed.is_none())
    }
}

/// Checks a project whose files lie on the disk.
#[must_use]
pub fn check(project: &Project, config: &Config) -> Report {
    check_with(project, config, Box::new(DiskSource))
}

/// Checks a project whose files are read from `source`.
#[must_use]
pub fn check_with(project: &Project, config: &Config, source: Box<dyn ReadSource>) -> Report {
    let mut files = FileSet::new(SourceMap::new(project.root.clone()), source);
    let mut problems = Vec::new();
    let inputs = parse_all(project, &mut files, &mut problems);
    let sources = files.into_map();
    // Expressions nest as deep as the parser allows, and the walks over them with them.
    let mut report = with_large_stack(|| analyse_all(project, config, inputs, sources));
    let mut seen = BTreeSet::new();
    problems.retain(|problem: &Problem| seen.insert((problem.file.clone(), problem.span, problem.message.clone())));
    report.problems = problems;
    report
}

/// Parses every crate root with its modules.
fn parse_all(project: &Project, files: &mut FileSet, problems: &mut Vec<Problem>) -> Vec<CrateInput> {
    let mut inputs: Vec<CrateInput> = Vec::new();
    let mut libs: BTreeMap<usize, usize> = BTreeMap::new();
    for (package_number, package) in project.packages.iter().enumerate() {
        for (target_number, target) in package.targets.iter().enumerate() {
            let mut cfg = package.cfg.clone();
            if target.cfg_test {
                cfg.flags.insert("test".to_owned());
            }
            if target.kind == TargetKind::Lib {
                libs.insert(package_number, inputs.len());
            }
            inputs.push(CrateInput {
                package: package_number,
                target: target_number,
                name: target.crate_name.clone(),
                externs: BTreeMap::new(),
                is_reported: target.is_reported && package.is_reported,
                is_test: matches!(target.kind, TargetKind::Test | TargetKind::Bench),
                items: parse_crate(&target.src_path, &target.edition, &cfg, files, problems),
            });
        }
    }
    for input in &mut inputs {
        let package = &project.packages[input.package];
        for dependency in &package.dependencies {
            let krate = dependency.package.and_then(|package| libs.get(&package)).copied();
            input.externs.insert(dependency.extern_name.clone(), (krate, dependency.package_name.clone()));
        }
        let target = &package.targets[input.target];
        if target.kind != TargetKind::Lib
            && let Some(own) = libs.get(&input.package)
        {
            let name = package.targets.iter().find(|target| target.kind == TargetKind::Lib);
            if let Some(lib) = name {
                input.externs.insert(lib.crate_name.clone(), (Some(*own), package.name.clone()));
            }
        }
    }
    inputs
}

fn analyse_all(project: &Project, config: &Config, inputs: Vec<CrateInput>, sources: SourceMap) -> Report {
    let directives = Directives::read(&sources);
    // Without the trait there is no filter, and without a filter there is nothing to count.
    let is_configured = config.sections.iter().any(|section| !section.filters.is_empty());
    if !is_configured && directives.is_empty() && !sources.files().any(|(_, file)| file.text.contains("SampledFilter"))
    {
        return Report { sources, ..Report::default() };
    }
    let entries = config.sections.iter().flat_map(|section| &section.filters);
    let named_outside = entries.map(|entry| entry.target.path()).filter(|path| !path.starts_with("crate::"));
    // A file of several crates belongs to one that is reported, if there is such a one.
    let (reported, others): (Vec<_>, Vec<_>) = inputs.iter().partition(|input| input.is_reported);
    let crates: Vec<Crate<'_>> = [reported, others]
        .into_iter()
        .flatten()
        .map(|input| Crate { package: input.package, target: input.target, items: &input.items })
        .collect();
    let suppressions = Suppressions::place(&directives, &sources, &crates);
    let mut index = Index::build(inputs, named_outside.map(str::to_owned).collect());
    for section in &config.sections {
        for entry in &section.filters {
            add_entry(project, &mut index, section, entry);
        }
    }
    if is_configured {
        index.find_holders();
    }
    let bodies = Program::infer_all(&index);
    let program = Program { index: &index, bodies: &bodies, sources: &sources, directives: &directives };
    let graphs: Vec<_> = index.function_ids().map(|id| lower_function(&program, id)).collect();
    let mut analysis = analyse(&program, &graphs);
    let is_shown = |package: usize, target: usize, span: Span| {
        let package = &project.packages[package];
        let path = &sources.file(span.file).path;
        package.is_reported
            && package.targets[target].is_reported
            && project.is_wanted(path)
            && !config.is_excluded(path)
    };
    let known = Known::new(&suppressions, forbidden(project, config));
    // A suppression in a file that is reported may hide what is found in one that is not.
    known.prepare(&mut analysis);
    let mut hygiene = rules::hygiene(&known);
    hygiene.retain(|finding| is_shown(finding.package, finding.target, finding.primary.span));
    analysis.cycles.retain(|cycle| is_shown(cycle.package, cycle.target, cycle.head));
    analysis.unregistered.retain(|filter| is_shown(filter.package, filter.target, filter.span));
    analysis.guards.retain(|guard| is_shown(guard.package, guard.target, guard.span));
    analysis.remarks.retain(|remark| is_shown(remark.package, remark.target, remark.span));
    // A file that belongs to several targets is judged once.
    let mut seen = BTreeSet::new();
    analysis.cycles.retain(|cycle| seen.insert((cycle.head, cycle.function.clone())));
    let mut findings = rules::findings(&analysis, &known);
    findings.extend(hygiene);
    mark_suppressed(&mut analysis.cycles, &findings);
    let diagnostics = with_levels(project, config, findings);
    let filter_types = index.filter_type_count();
    Report { diagnostics, cycles: analysis.cycles, filter_types, problems: Vec::new(), sources }
}

/// Makes a filter of the type or trait that an entry of the configuration names.
fn add_entry(project: &Project, index: &mut Index, section: &Section, entry: &FilterEntry) {
    if entry.kind == FilterKind::Event {
        return;
    }
    let crates: Vec<ModuleId> = index
        .crates
        .iter()
        .filter(|krate| match &section.scope {
            Scope::Workspace(root) => project.packages[krate.package].workspace_root == *root,
            Scope::Package(manifest) => project.packages[krate.package].manifest_path == *manifest,
        })
        .map(|krate| krate.root)
        .collect();
    for root in crates {
        index.add_filter(root, entry);
    }
}

/// The rules that are at `forbid`, by package.
fn forbidden(project: &Project, config: &Config) -> BTreeSet<(usize, &'static str)> {
    let pairs = project.packages.iter().enumerate().flat_map(|package| RULES.iter().map(move |rule| (package, rule)));
    let is_forbidden = |package, rule| rules::level_of(rule, config, package).level == Level::Forbid;
    pairs.filter(|((_, package), rule)| is_forbidden(package, rule)).map(|((at, _), rule)| (at, rule.name)).collect()
}

/// Marks the pairs on which something was found that is suppressed, and nothing that is not.
fn mark_suppressed(cycles: &mut [Cycle], findings: &[Diagnostic]) {
    let mut by_cycle: BTreeMap<Span, Vec<&Diagnostic>> = BTreeMap::new();
    for finding in findings {
        if let Some(head) = finding.facts.cycle {
            by_cycle.entry(head).or_default().push(finding);
        }
    }
    for cycle in cycles {
        let found = by_cycle.get(&cycle.head).map_or(&[][..], Vec::as_slice);
        for pair in &mut cycle.filters {
            let is_about = |finding: &&&Diagnostic| {
                finding.facts.filters.contains(&pair.name) && pair.rules.contains(&finding.rule)
            };
            let reasons: Option<Vec<&String>> =
                found.iter().filter(is_about).map(|finding| finding.suppressed.as_ref()).collect();
            pair.suppressed = reasons.and_then(|reasons| reasons.first().map(|reason| (*reason).clone()));
        }
    }
}

/// The findings at `warn` or above, sorted.
fn with_levels(project: &Project, config: &Config, findings: Vec<Diagnostic>) -> Vec<Diagnostic> {
    let mut shown: Vec<Diagnostic> = findings
        .into_iter()
        .filter_map(|finding| {
            let rule = rules::find(finding.rule)?;
            let setting = rules::level_of(rule, config, &project.packages[finding.package]);
            let level_source = setting.source;
            (setting.level > Level::Allow).then_some(Diagnostic { level: setting.level, level_source, ..finding })
        })
        .collect();
    shown.sort_by(|left, right| {
        (left.primary.span, left.rule, &left.message).cmp(&(right.primary.span, right.rule, &right.message))
    });
    shown.dedup_by(|left, right| {
        left.primary == right.primary && left.rule == right.rule && left.message == right.message
    });
    shown
}
