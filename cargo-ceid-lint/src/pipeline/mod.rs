//! From a project to a report: the one function to read first.

mod configured;
mod known;
mod prospect;
mod since;

use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;
use std::sync::Arc;

pub use configured::{Configured, Options, check_configured};
pub use known::{BaselineChoice, CheckedCrate};
pub use prospect::{Prospect, prospect};
pub use since::Unchanged;

use crate::baseline::Comparison;
use crate::config::{self, Config, ConfigError, Preset, Scope, Section};
use crate::count::{Cycle, Pair, analyse};
use crate::diagnostic::{Diagnostic, Level, Problem};
use crate::flow::{Program, lower_function};
use crate::index::{CrateId, CrateInput, EntryScope, FunctionPlaces, Index};
use crate::migrate::{self, Plan};
use crate::project::{Project, TargetKind};
use crate::rules::{self, Known, RULES};
use crate::source::{DiskSource, FileSet, ReadSource, SourceMap, Span};
use crate::suggest;
use crate::suppress::{Crate, Suppressions};
use crate::syntax::{Directives, parse_root, with_large_stack};

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
    /// What was not looked at, though nothing is wrong with it.
    pub unread: Vec<Problem>,
    /// The files and directories of modules that are declared, and not there under this `cfg`.
    pub left_out: BTreeSet<PathBuf>,
    /// The crates that were looked at.
    pub checked: Vec<CheckedCrate>,
    /// The functions of all code that was read; none if there is no filter.
    pub functions: FunctionPlaces,
    /// The baselines that the findings were compared with.
    pub baselines: Vec<Comparison>,
    /// What was left out, if only changed lines are looked at.
    pub unchanged: Option<Unchanged>,
    /// How many filter types were found.
    pub filter_types: usize,
    /// How many functions were only searched for repetitions, as nothing calls them, and have none.
    pub presumed: usize,
    /// What can be done about each loop that updates filters by hand.
    pub plans: Vec<Plan>,
    /// The edits that remove each import of a filter's trait that nothing needs beside a guard.
    pub idle_imports: Vec<Vec<(Span, String)>>,
    /// The manifests of the packages that these plans change, and of their workspaces.
    pub manifests: BTreeMap<PathBuf, Arc<str>>,
}

impl Report {
    /// The findings that nothing suppresses and no baseline knows: those that people see and that decide how a run ends.
    pub fn shown(&self) -> impl Iterator<Item = &Diagnostic> {
        self.diagnostics.iter().filter(|finding| finding.is_shown())
    }
}

/// Checks a project whose files lie on the disk.
///
/// # Errors
/// If the configuration names what is not there.
pub fn check(project: &Project, config: &Config) -> Result<Report, ConfigError> {
    check_with(project, config, Box::new(DiskSource))
}

/// Checks a project whose files are read from `source`.
///
/// # Errors
/// If the configuration names what is not there.
pub fn check_with(project: &Project, config: &Config, source: Box<dyn ReadSource>) -> Result<Report, ConfigError> {
    let mut files = FileSet::new(SourceMap::new(project.root.clone()), source);
    let mut problems = Vec::new();
    let mut left_out = BTreeSet::new();
    let mut checked = Vec::new();
    let inputs = parse_all(project, &mut files, &mut problems, &mut left_out, &mut checked);
    let (sources, source) = files.into_parts();
    // Expressions nest as deep as the parser allows, and the walks over them with them.
    let is_partial = !problems.is_empty() || !project.problems.is_empty();
    let mut report = with_large_stack(|| analyse_all(project, config, inputs, sources, is_partial))?;
    let mut seen = BTreeSet::new();
    problems.retain(|problem: &Problem| seen.insert((problem.file.clone(), problem.span, problem.message.clone())));
    (report.problems, report.unread) = problems.into_iter().partition(|problem| problem.is_error);
    (report.left_out, report.checked) = (left_out, checked);
    report.manifests = manifests(project, &report.plans, &*source);
    Ok(report)
}

/// The manifests that plans are about.
fn manifests(project: &Project, plans: &[Plan], source: &dyn ReadSource) -> BTreeMap<PathBuf, Arc<str>> {
    let rewrites = plans.iter().filter_map(|plan| plan.outcome.as_ref().ok());
    let packages: BTreeSet<usize> = rewrites.flat_map(|rewrite| rewrite.packages.iter().copied()).collect();
    let packages = packages.iter().map(|package| &project.packages[*package]);
    let paths = packages.flat_map(|package| [package.manifest_path.clone(), package.workspace_root.join("Cargo.toml")]);
    paths.filter_map(|path| Some((path.clone(), source.read(&path).ok()?))).collect()
}

/// Parses every crate root with its modules.
fn parse_all(
    project: &Project,
    files: &mut FileSet,
    problems: &mut Vec<Problem>,
    left_out: &mut BTreeSet<PathBuf>,
    checked: &mut Vec<CheckedCrate>,
) -> Vec<CrateInput> {
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
            let root = parse_root(&target.src_path, &target.edition, &cfg, files, problems);
            left_out.extend(root.left_out);
            let is_reported = target.is_reported && package.is_reported;
            if is_reported {
                let removed = root.removed.clone();
                checked.push(CheckedCrate { package: package_number, files: root.files, removed });
            }
            inputs.push(CrateInput {
                package: package_number,
                target: target_number,
                name: target.crate_name.clone(),
                package_name: package.name.replace('-', "_"),
                removed: root.removed,
                externs: BTreeMap::new(),
                is_reported,
                is_test: matches!(target.kind, TargetKind::Test | TargetKind::Bench),
                items: root.items,
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

fn analyse_all(
    project: &Project,
    config: &Config,
    inputs: Vec<CrateInput>,
    sources: SourceMap,
    is_partial: bool,
) -> Result<Report, ConfigError> {
    let directives = Directives::read(&sources);
    let reported = project.packages.iter().filter(|package| package.is_reported);
    let sections =
        reported.map(|package| config.sections_of(&package.workspace_root, &package.manifest_path).collect());
    let presets = config::active_presets(config, sections, |name| project.graph.contains(name))?;
    // Without the trait there is no filter, and without a filter there is nothing to count.
    let is_configured = !presets.is_empty()
        || config.sections.iter().any(|section| !section.filters.is_empty() || !section.cycles.is_empty());
    if !is_configured && directives.is_empty() && !sources.files().any(|(_, file)| file.text.contains("SampledFilter"))
    {
        return Ok(Report { sources, ..Report::default() });
    }
    // A file of several crates belongs to one that is reported, if there is such a one.
    let (reported, others): (Vec<_>, Vec<_>) = inputs.iter().partition(|input| input.is_reported);
    let crates: Vec<Crate<'_>> = [reported, others]
        .into_iter()
        .flatten()
        .map(|input| Crate { package: input.package, target: input.target, items: &input.items })
        .collect();
    let suppressions = Suppressions::place(&directives, &sources, &crates);
    let mut index = Index::build(inputs, paths_outside(config, &presets));
    add_entries(project, config, &presets, &mut index, is_partial)?;
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
    analysis.presumed.retain(|function| is_shown(function.package, function.target, function.head));
    analysis.unregistered.retain(|filter| is_shown(filter.package, filter.target, filter.span));
    analysis.guards.retain(|guard| is_shown(guard.package, guard.target, guard.span));
    analysis.remarks.retain(|remark| is_shown(remark.package, remark.target, remark.span));
    // A file that belongs to several targets is judged once.
    let mut seen = BTreeSet::new();
    analysis.cycles.retain(|cycle| seen.insert((cycle.head, cycle.function.clone())));
    let edition = |cycle: &Cycle| project.packages[cycle.package].targets[cycle.target].edition.clone();
    let plans = migrate::plans(&program, &analysis.cycles, edition);
    let idle_imports = migrate::idle_imports(&program, &analysis.cycles);
    let mut findings = rules::findings(&analysis, &known);
    suggest::add(&program, &analysis, &mut findings);
    findings.extend(hygiene);
    suggest_guards(&mut findings, &plans);
    mark_suppressed(&mut analysis.cycles, &findings);
    let diagnostics = with_levels(project, config, findings);
    let filter_types = index.filter_type_count();
    let presumed = analysis.presumed.iter().map(|function| function.head).collect::<BTreeSet<_>>().len();
    let functions = index.function_places(&sources);
    let cycles = analysis.cycles;
    Ok(Report {
        diagnostics,
        cycles,
        filter_types,
        presumed,
        functions,
        sources,
        plans,
        idle_imports,
        ..Report::default()
    })
}

/// Adds to each finding about the updates of a loop that a guard could make them.
fn suggest_guards(findings: &mut [Diagnostic], plans: &[Plan]) {
    let is_about_updates =
        |rule: &str| matches!(rule, "missed_update" | "repeated_update" | "skipped_update" | "unguarded_update");
    for finding in findings.iter_mut().filter(|finding| is_about_updates(finding.rule)) {
        let plan = plans.iter().find(|plan| finding.facts.cycle == Some(plan.head));
        finding.suggestions.extend(plan.and_then(Plan::suggestion));
    }
}

/// The paths that entries name in crates whose sources are perhaps not read.
fn paths_outside(config: &Config, presets: &[Preset]) -> Vec<String> {
    let filters = config.sections.iter().flat_map(|section| &section.filters);
    let cycles = config.sections.iter().flat_map(|section| &section.cycles);
    let guards = config.sections.iter().flat_map(|section| &section.guards);
    let filters = filters.chain(presets.iter().flat_map(|preset| &preset.filters));
    let cycles = cycles.chain(presets.iter().flat_map(|preset| &preset.cycles));
    let methods = cycles.map(|entry| entry.target.path().text.as_str());
    let methods = methods.map(|path| path.rsplit_once("::").map_or(path, |(of, _)| of));
    filters
        .map(|entry| entry.target.path().text.as_str())
        .chain(guards.map(|entry| entry.guard_type.text.as_str()))
        .chain(methods)
        .filter(|path| !path.starts_with("crate::"))
        .map(str::to_owned)
        .collect()
}

/// Makes filters, cycles and guards of what the entries name; the configuration goes before the presets.
fn add_entries(
    project: &Project,
    config: &Config,
    presets: &[Preset],
    index: &mut Index,
    is_partial: bool,
) -> Result<(), ConfigError> {
    for section in &config.sections {
        let in_scope = |package: usize| {
            let package = &project.packages[package];
            match &section.scope {
                Scope::Workspace(root) => package.workspace_root == *root,
                Scope::Package(manifest) => package.manifest_path == *manifest,
            }
        };
        let is_partial =
            is_partial || (0..project.packages.len()).any(|at| in_scope(at) && project.packages[at].is_partly_read);
        let scope = scope_of(project, index, is_partial, in_scope);
        let added = add_section(index, &scope, section);
        added.map_err(|error| ConfigError { text: Some(section.text.clone()), ..error })?;
    }
    let scope = scope_of(project, index, true, |_| true);
    for preset in presets {
        for entry in &preset.filters {
            index.add_preset_filter(&scope, entry);
        }
        for entry in &preset.cycles {
            index.add_cycle(&scope, entry)?;
        }
    }
    index.find_holders();
    Ok(())
}

fn scope_of<'a>(
    project: &'a Project,
    index: &Index,
    is_partial: bool,
    in_scope: impl Fn(usize) -> bool,
) -> EntryScope<'a> {
    let crates = (0u32..).zip(&index.crates).filter(|(_, krate)| in_scope(krate.package));
    EntryScope { crates: crates.map(|(number, _)| CrateId(number)).collect(), graph: &project.graph, is_partial }
}

fn add_section(index: &mut Index, scope: &EntryScope<'_>, section: &Section) -> Result<(), ConfigError> {
    for entry in &section.filters {
        index.add_filter(scope, entry)?;
    }
    for entry in &section.cycles {
        index.add_cycle(scope, entry)?;
    }
    for entry in &section.guards {
        index.add_guard(scope, entry)?;
    }
    Ok(())
}

/// The rules that are at `forbid`, by package.
fn forbidden(project: &Project, config: &Config) -> BTreeSet<(usize, &'static str)> {
    let pairs = project.packages.iter().enumerate().flat_map(|package| RULES.iter().map(move |rule| (package, rule)));
    let is_forbidden = |package, rule| rules::level_of(rule, config, package).level == Level::Forbid;
    pairs.filter(|((_, package), rule)| is_forbidden(package, rule)).map(|((at, _), rule)| (at, rule.name)).collect()
}

/// Whether a finding is about a filter of a cycle.
#[must_use]
pub fn is_about(finding: &Diagnostic, cycle: &Cycle, pair: &Pair) -> bool {
    finding.facts.cycle == Some(cycle.head) && names(finding, pair)
}

fn names(finding: &Diagnostic, pair: &Pair) -> bool {
    finding.facts.filters.contains(&pair.name) && pair.rules.contains(&finding.rule)
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
            let about = found.iter().filter(|finding| names(finding, pair));
            let reasons: Option<Vec<&String>> = about.map(|finding| finding.suppressed.as_ref()).collect();
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
