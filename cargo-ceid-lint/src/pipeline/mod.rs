//! From a project to a report: the one function to read first.

mod configured;
mod entries;
mod known;
mod left_out;
mod macros;
mod manifests;
mod memory;
mod parse;
mod prospect;
mod report;
mod since;
mod steps;
mod timings;
mod too_large;
mod views;

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::sync::{Arc, Mutex};

pub use configured::{Again, Configured, Options, Purpose, check_again, check_configured, check_read_ahead};
pub use known::{BaselineChoice, CheckedCrate};
pub use manifests::dependencies;
pub use memory::Memory;
pub use prospect::{Prospect, prospect};
pub use report::Report;
use report::sort;
pub use since::Unchanged;
pub use steps::Steps;
pub use timings::{Clock, Stage, Stopwatch, Timings};

use self::entries::Ledger;
use self::memory::{Judged, KnownManners};
use self::parse::Part;
use crate::config::{self, Config, ConfigError, Preset};
use crate::count::{Cycle, Pair, analyse, monomorphise};
use crate::diagnostic::{Diagnostic, Level};
use crate::flow::{Inferred, lower_function};
use crate::index::{CrateInput, FunctionId, Index};
use crate::migrate::{self, IdleImports, Plan};
use crate::parallel::{Cores, biggest_first, with_large_stack};
use crate::project::{Manners, Package, Project};
use crate::relevance::{self, Names, ReadAhead};
use crate::rules::{self, Known, RULES};
use crate::source::{DiskSource, ReadSource, SourceMap, Span};
use crate::suggest;
use crate::suppress::{Crate, Suppressions};
use crate::syntax::Directives;

/// Which packages are parsed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Gate {
    /// Those that can have to do with a filter.
    #[default]
    On,
    /// All, so that what is broken elsewhere is told as well.
    Off,
    /// All, and they are analysed as if each could have to do with every other: what the others are held against.
    Whole,
}

/// Checks a project whose files lie on the disk.
///
/// # Errors
/// If the configuration names what is not there.
pub fn check(project: &Project, config: &Config) -> Result<Report, ConfigError> {
    check_with(project, config, Box::new(DiskSource), Gate::On)
}

/// Checks a project whose files are read from `source`.
///
/// # Errors
/// If the configuration names what is not there.
pub fn check_with(
    project: &Project,
    config: &Config,
    source: Box<dyn ReadSource>,
    gate: Gate,
) -> Result<Report, ConfigError> {
    Ok(judge(project, config, source, gate, Earlier::default())?.together(project))
}

/// What was found out before a run, and how it is watched.
#[derive(Default)]
struct Earlier<'a> {
    ahead: Option<&'a ReadAhead>,
    memory: Option<&'a mut Memory>,
    clock: Option<Clock>,
    steps: Steps,
    purpose: Purpose,
}

/// What was found, before it is put together.
enum Found {
    /// By packages that have nothing to do with each other, with the time that was not spent on one of them.
    Parts(Vec<Arc<Judged>>, Timings),
    /// In all packages at once.
    Whole(Box<Report>),
    /// Nothing yet: cargo has to be asked first what is analysed.
    Unresolved,
}

impl Found {
    fn together(self, project: &Project) -> Report {
        let (parts, timings) = match self {
            Self::Parts(parts, timings) => (parts, timings),
            Self::Whole(report) => return *report,
            Self::Unresolved => return Report::default(),
        };
        let parsed: BTreeSet<usize> = parts.iter().flat_map(|own| own.packages.iter().copied()).collect();
        let report_of =
            |own: Arc<Judged>| Arc::try_unwrap(own).map_or_else(|own| Arc::clone(&own.report), |own| own.report);
        let mut report = Report::of_parts(parts.into_iter().map(report_of), project.root.clone());
        report.timings.add(&timings);
        report.unparsed = (0..project.packages.len()).filter(|package| !parsed.contains(package)).collect();
        report
    }
}

fn judge(
    project: &Project,
    config: &Config,
    source: Box<dyn ReadSource>,
    gate: Gate,
    earlier: Earlier<'_>,
) -> Result<Found, ConfigError> {
    let source: Arc<dyn ReadSource> = source.into();
    let mut whole: Option<Report> = None;
    for (project, config) in views::of(project, config) {
        let earlier = Earlier { steps: earlier.steps.clone(), memory: None, ..earlier };
        // Parsed as a whole, each file has the same number in all of them.
        let found = match judge_alike(&project, &config, &source, Gate::Whole, earlier)? {
            Found::Unresolved => return Ok(Found::Unresolved),
            found => found.together(&project),
        };
        match &mut whole {
            Some(whole) => whole.add(found),
            None => whole = Some(found),
        }
    }
    let Some(mut whole) = whole else { return judge_alike(project, config, &source, gate, earlier) };
    whole.sort();
    Ok(Found::Whole(Box::new(whole)))
}

/// Judges packages that see other crates in the same way.
fn judge_alike(
    project: &Project,
    config: &Config,
    source: &Arc<dyn ReadSource>,
    gate: Gate,
    earlier: Earlier<'_>,
) -> Result<Found, ConfigError> {
    let Earlier { ahead, mut memory, clock, steps, purpose } = earlier;
    let mut watch = Stopwatch::start(clock);
    let presets = presets_of(project, config)?;
    let manners = memory.as_ref().map(|memory| memory.manners()).unwrap_or_default();
    let run = Run { project, config, presets: &presets, manners: &manners, clock, steps: &steps, purpose };
    let is_unresolved = |package: &usize| project.packages[*package].is_unresolved;
    let whole = || {
        if (0..project.packages.len()).any(|package| is_unresolved(&package)) {
            return Ok(Found::Unresolved);
        }
        Ok(Found::Whole(Box::new(run.whole(source)?)))
    };
    if gate == Gate::Whole {
        return whole();
    }
    let names = Names::new(config, &presets);
    // What the user looks at is parsed in any case.
    let mut named = source.held();
    named.extend(project.only.iter().filter(|path| path.is_file()).cloned());
    if let Some(memory) = memory.as_deref_mut() {
        memory.prepare(&**source);
    }
    let mut components = memory
        .as_deref_mut()
        .and_then(Memory::take_components)
        .unwrap_or_else(|| relevance::components(project, &names, ahead.unwrap_or(&ReadAhead::default())));
    relevance::look_at(&mut components, project, &named);
    watch.lap(Stage::Gate);
    if parse::looked_at(project, &components, gate).flat_map(|own| &own.packages).any(is_unresolved) {
        return Ok(Found::Unresolved);
    }
    let mut parts = parse::parts(project, source, &components, &names, gate, memory.as_deref_mut(), &steps);
    if let Some(memory) = memory.as_deref_mut().filter(|memory| memory.have_read(&parts)) {
        memory.forget();
        parts = parse::parts(project, source, &components, &names, gate, None, &steps);
    }
    watch.lap(Stage::Parse);
    let sizes: Vec<u64> = parts.iter().map(Part::bytes).collect();
    let parts: Vec<Mutex<Option<Part>>> = parts.into_iter().map(|part| Mutex::new(Some(part))).collect();
    let total: u64 = sizes.iter().sum();
    let judged = biggest_first(&sizes, |at| {
        let part = parts[at].lock().ok().and_then(|mut part| part.take()).unwrap_or_default();
        // What is more than half of all would be alone at work in the end.
        let cores = if sizes[at] > total / 2 { Cores::all() } else { Cores::OWN };
        run.part(part, source, cores)
    });
    let Ok(judged) = judged.into_iter().collect::<Result<Vec<Judged>, ConfigError>>() else {
        return whole();
    };
    let mut judged: Vec<Arc<Judged>> = judged.into_iter().map(Arc::new).collect();
    if let Some(memory) = memory {
        judged.extend(memory.judged().iter().cloned());
        memory.learn_judged(judged.clone());
        memory.learn_components(components);
    }
    // What cannot matter comes after the rest.
    judged.sort_by_key(|own| (!own.can_matter, own.packages.first().copied()));
    let mut ledger = Ledger::of(config);
    for own in &judged {
        ledger.add(&own.named);
    }
    // An entry that named nothing may be an error, whose words depend on all that is there.
    if !ledger.is_complete() {
        return whole();
    }
    Ok(Found::Parts(judged, watch.stop()))
}

/// The presets that are active.
fn presets_of(project: &Project, config: &Config) -> Result<Vec<Preset>, ConfigError> {
    let reported = project.packages.iter().filter(|package| package.is_reported);
    let sections =
        reported.map(|package| config.sections_of(&package.workspace_root, &package.manifest_path).collect());
    config::active_presets(config, sections, |name| project.graph.contains(name))
}

/// What all parts of a run have in common.
struct Run<'a> {
    project: &'a Project,
    config: &'a Config,
    presets: &'a [Preset],
    manners: &'a KnownManners,
    clock: Option<Clock>,
    steps: &'a Steps,
    purpose: Purpose,
}

/// Which entries of which sections named something.
type Named = Vec<(usize, Vec<bool>)>;

impl Run<'_> {
    /// Analyses all packages together.
    fn whole(&self, source: &Arc<dyn ReadSource>) -> Result<Report, ConfigError> {
        let mut watch = Stopwatch::start(self.clock);
        let packages: Vec<usize> = (0..self.project.packages.len()).collect();
        let part = parse::parse(self.project, source, &packages);
        watch.lap(Stage::Parse);
        let (mut report, _) = self.analysed(part, Cores::all(), |index, is_partial| {
            entries::add_all(self.project, self.config, index, is_partial, &**source)?;
            entries::add_presets(self.presets, &self.project.graph, index)?;
            Ok(Vec::new())
        })?;
        report.timings.add(&watch.stop());
        report.sort();
        report.manifests = manifests::of_plans(self.project, &report.plans, &**source);
        Ok(report)
    }

    /// Analyses packages that are linked.
    fn part(&self, mut part: Part, source: &Arc<dyn ReadSource>, cores: Cores) -> Result<Judged, ConfigError> {
        let (packages, mut read, can_matter) = (part.packages.clone(), std::mem::take(&mut part.read), part.can_matter);
        let (mut report, named) = if can_matter {
            let graph = entries::graph_around(self.project, &packages);
            self.analysed(part, cores, |index, is_partial| {
                let named = entries::add_some(self.project, self.config, &graph, index, is_partial)?;
                entries::add_presets(self.presets, &graph, index)?;
                Ok(named)
            })?
        } else {
            let mut report =
                Report { sources: part.sources, left_out: part.left_out, checked: part.checked, ..Report::default() };
            report.add_problems(part.problems);
            (report, Named::new())
        };
        report.sort();
        report.manifests = manifests::of_plans(self.project, &report.plans, &**source);
        read.extend(report.manifests.keys().cloned());
        Ok(Judged { packages, read, can_matter, report: Arc::new(report), named })
    }

    fn analysed(
        &self,
        part: Part,
        cores: Cores,
        add_entries: impl FnOnce(&mut Index, bool) -> Result<Named, ConfigError> + Send,
    ) -> Result<(Report, Named), ConfigError> {
        let Part { packages, mut inputs, sources, problems, left_out, checked, .. } = part;
        parse::link(self.project, &mut inputs);
        let is_partial = !problems.is_empty() || !self.project.problems.is_empty();
        let add = |index: &mut Index| add_entries(index, is_partial);
        // Expressions nest as deep as the parser allows, and the walks over them with them.
        let (mut report, named) = with_large_stack(|| self.analyse(&packages, inputs, sources, cores, add))?;
        report.add_problems(problems);
        report.left_out = left_out;
        report.checked = checked;
        Ok((report, named))
    }

    fn analyse(
        &self,
        packages: &[usize],
        inputs: Vec<CrateInput>,
        sources: SourceMap,
        cores: Cores,
        add_entries: impl FnOnce(&mut Index) -> Result<Named, ConfigError>,
    ) -> Result<(Report, Named), ConfigError> {
        let (project, config) = (self.project, self.config);
        let mut watch = Stopwatch::start(self.clock);
        let bytes: u64 = sources.files().map(|(_, file)| file.byte_count() as u64).sum();
        let mut lap = |stage| {
            watch.lap(stage);
            self.steps.add(bytes);
        };
        let directives = Directives::read(&sources);
        // A file of several crates belongs to one that is reported, if there is such a one.
        let (reported, others): (Vec<_>, Vec<_>) = inputs.iter().partition(|input| input.is_reported);
        let crates: Vec<Crate<'_>> = [reported, others]
            .into_iter()
            .flatten()
            .map(|input| Crate { package: input.package, target: input.target, items: &input.items })
            .collect();
        let suppressions = Suppressions::place(&directives, &sources, &crates);
        let mut index = Index::build(inputs, entries::paths_outside(config, self.presets));
        let named = add_entries(&mut index)?;
        lap(Stage::Index);
        let inferred = Inferred::of(&index, &sources, cores);
        lap(Stage::Types);
        let program = inferred.program(&index, &sources, &directives, cores);
        let functions: Vec<FunctionId> = index.function_ids().collect();
        let mut graphs = cores.deeply(functions.len(), |at| lower_function(&program, functions[at]));
        index.instances = monomorphise(&program, &mut graphs);
        let program = inferred.program(&index, &sources, &directives, cores);
        lap(Stage::Flow);
        let mut too_large = too_large::functions(&program, &graphs);
        let mut analysis = analyse(&program, &mut graphs);
        lap(Stage::Count);
        let is_shown = |package: usize, target: usize, span: Span| {
            let package = &project.packages[package];
            let path = &sources.file(span.file).path;
            package.is_reported
                && package.targets[target].is_reported
                && project.is_wanted(path)
                && !config.is_excluded(path)
        };
        let known = Known::new(&suppressions, forbidden(project, config, packages));
        // A suppression in a file that is reported may hide what is found in one that is not.
        known.prepare(&mut analysis, &|span| is_own(project, config, &sources, span));
        let mut hygiene = rules::hygiene(&known);
        hygiene.retain(|finding| is_shown(finding.package, finding.target, finding.primary.span));
        let is_beside = |package: &usize| !project.packages[*package].is_member;
        let beside = analysis.cycles.iter().map(|cycle| cycle.package).filter(is_beside).collect();
        analysis.cycles.retain(|cycle| is_shown(cycle.package, cycle.target, cycle.head));
        analysis.presumed.retain(|function| is_shown(function.package, function.target, function.head));
        analysis.unregistered.retain(|filter| is_shown(filter.package, filter.target, filter.span));
        analysis.guards.retain(|guard| is_shown(guard.package, guard.target, guard.span));
        analysis.remarks.retain(|remark| is_shown(remark.package, remark.target, remark.span));
        too_large.retain(|function| is_shown(function.package, function.target, function.head));
        // A file that belongs to several targets is judged once.
        let mut seen = BTreeSet::new();
        analysis.cycles.retain(|cycle| seen.insert((cycle.head, cycle.function.clone())));
        let edition = |cycle: &Cycle| project.packages[cycle.package].targets[cycle.target].edition.clone();
        let mut findings = rules::findings(&analysis, &known);
        suggest::add(&program, &analysis, &mut findings);
        findings.extend(hygiene);
        let guardable: BTreeSet<Span> = findings.iter().filter_map(guardable).collect();
        // What is suggested leaves the manifests as they are.
        let is_core = |name: &str| name == "ceid-core";
        let has_core = |package: &Package| {
            is_core(&package.name) || package.dependencies.iter().any(|own| is_core(&own.package_name))
        };
        let is_planned = |cycle: &&Cycle| {
            !matches!(self.purpose, Purpose::Findings | Purpose::Fixes)
                || guardable.contains(&cycle.head) && has_core(&project.packages[cycle.package])
        };
        let planned = analysis.cycles.iter().filter(is_planned);
        let manners =
            |path: &Path| Manners { is_left_alone: config.is_excluded(path), ..self.manners.of(project, path) };
        let plans = migrate::plans(&program, planned, edition, &manners);
        let idle_imports = match self.purpose {
            Purpose::Migration | Purpose::Fixes => migrate::idle_imports(&program, &analysis.cycles),
            Purpose::Findings | Purpose::Offers => IdleImports::default(),
        };
        suggest_guards(&mut findings, &plans);
        mark_suppressed(&mut analysis.cycles, &findings);
        let diagnostics = with_levels(project, config, findings);
        let filter_types = index.filter_type_count();
        let presumed = analysis.presumed.iter().map(|function| function.head).collect::<BTreeSet<_>>().len();
        let functions = index.function_places(&sources);
        let cycles = analysis.cycles;
        let unread = too_large.into_iter().map(|function| function.problem(&sources)).collect();
        lap(Stage::Findings);
        let report = Report {
            diagnostics,
            cycles,
            unread,
            filter_types,
            presumed,
            beside,
            functions,
            sources,
            plans,
            idle_imports,
            timings: watch.stop(),
            ..Report::default()
        };
        Ok((report, named))
    }
}

/// Whether a place lies in code that findings are shown in: not in what is left alone, and not in a package beside the workspace, which
/// is read only for what it does.
fn is_own(project: &Project, config: &Config, sources: &SourceMap, span: Span) -> bool {
    let path = &sources.file(span.file).path;
    let is_beside = || {
        let owner = project.owner(path).map(|number| &project.packages[number]);
        owner.is_some_and(|package| !package.is_member && !package.is_reported)
    };
    !config.is_excluded(path) && !is_beside()
}

/// The head of the loop whose updates a finding is about, so that a guard could make them.
fn guardable(finding: &Diagnostic) -> Option<Span> {
    let is_about_updates =
        matches!(finding.rule, "missed_update" | "repeated_update" | "skipped_update" | "unguarded_update");
    finding.facts.cycle.filter(|_| is_about_updates)
}

/// Adds to each finding about the updates of a loop that a guard could make them.
fn suggest_guards(findings: &mut [Diagnostic], plans: &[Plan]) {
    let mut by_head: BTreeMap<Span, &Plan> = BTreeMap::new();
    for plan in plans {
        by_head.entry(plan.head).or_insert(plan);
    }
    for finding in findings {
        let plan = guardable(finding).and_then(|head| by_head.get(&head));
        finding.suggestions.extend(plan.and_then(|plan| plan.suggestion()));
    }
}

/// The rules that are at `forbid`, by package.
fn forbidden(project: &Project, config: &Config, packages: &[usize]) -> BTreeSet<(usize, &'static str)> {
    let packages = packages.iter().map(|number| (*number, &project.packages[*number]));
    let pairs = packages.flat_map(|package| RULES.iter().map(move |rule| (package, rule)));
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
    sort(&mut shown);
    shown.dedup_by(|left, right| {
        left.primary == right.primary && left.rule == right.rule && left.message == right.message
    });
    shown
}
