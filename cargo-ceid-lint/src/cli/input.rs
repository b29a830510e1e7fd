//! From arguments to a project, its configuration and a report.

use super::Console;
use super::args::{Build, Input, NoLoops, Scope};
use super::console::Stream;
use super::exit::ExitStatus;
use super::unread;
use crate::config::{self, Config, ConfigError, LevelOverrides};
use crate::diagnostic::Problem;
use crate::pipeline::{self, Report};
use crate::project::{self, Features, Names, Project, Selection, TargetFilter};
use crate::report::{self, Summary, text};
use crate::rules;
use crate::source::{SourceMap, Span};

/// What a run came to.
pub(super) struct Checked {
    pub(super) project: Project,
    pub(super) report: Report,
    pub(super) summary: Summary,
    /// Whether the configuration was wrong, so that nothing was checked.
    pub(super) is_config_wrong: bool,
}

/// Loads and checks; `None` if there is nothing to load, which was told.
pub(super) fn check(input: &Input, overrides: LevelOverrides, console: Console, with_stats: bool) -> Option<Checked> {
    let selection = selection(input);
    let mut project = match project::load(&selection) {
        Ok(project) => project,
        Err(error) => {
            console.error(&error.message, error.help.as_deref());
            return None;
        }
    };
    for notice in &project.notices {
        if !console.is_quiet() {
            console.warn(notice);
        }
    }
    for package in project.packages.iter().filter(|package| package.is_reported) {
        let targets = package.targets.iter().filter(|target| target.is_reported);
        let targets: Vec<String> = targets.map(|target| format!("{} `{}`", target.kind.name(), target.name)).collect();
        console.say_if_verbose(&format!("checking `{}` {}: {}", package.name, package.version, targets.join(", ")));
    }
    let mut checked = run(&project, &overrides);
    if let Ok((_, report)) = &checked {
        let alone = unread::files_of_no_target(&project, report);
        if !alone.is_empty() {
            project = match project::with_files(project, &alone, &selection) {
                Ok(project) => project,
                Err(error) => {
                    console.error(&error.message, error.help.as_deref());
                    return None;
                }
            };
            checked = run(&project, &overrides);
        }
    }
    let (report, is_config_wrong) = match checked {
        Ok((config, report)) => (unread::with_unread(&project, &config, report), false),
        Err(error) => (of_wrong_configuration(&project, &error), true),
    };
    if with_stats {
        console.show(&report::stats(&project, &report));
    }
    let summary = Summary::of(&report);
    Some(Checked { project, report, summary, is_config_wrong })
}

impl Checked {
    /// How the run ends, telling loudly when nothing was checked.
    pub(super) fn status(&self, no_loops: NoLoops, console: Console) -> ExitStatus {
        if self.is_config_wrong || self.summary.problems > 0 {
            return ExitStatus::Incomplete;
        }
        if self.summary.is_nothing() {
            let packages = self.project.packages.iter().filter(|package| package.is_reported).count();
            let what =
                format!("nothing to check: there is no cycle and no filter in {}", report::count(packages, "package"));
            let help =
                "a filter is a type with `impl SampledFilter`, or one that a `[[filter]]` of `ceid-lint.toml` names";
            match no_loops {
                NoLoops::Fail => {
                    console.error(&what, Some(help));
                    return ExitStatus::Findings;
                }
                NoLoops::Warn => console.warn(&format!("{what}; {help}")),
                NoLoops::Pass => {}
            }
        }
        if self.summary.errors > 0 { ExitStatus::Findings } else { ExitStatus::Clean }
    }

    /// Prints what could not be read, for people.
    pub(super) fn show_problems(&self, console: Console) {
        for problem in self.report.errors() {
            console.show(&text::problem(&self.report.sources, problem, console.style(Stream::Err)));
        }
    }

    /// Prints what was left unread, and the summary, unless there is nothing to sum up.
    pub(super) fn say_summary(&self, console: Console) {
        if let Some(unread) = report::unread(&self.report)
            && !console.is_quiet()
        {
            console.warn(&unread);
        }
        if !self.summary.is_nothing() && !self.is_config_wrong {
            console.say(&self.summary.line());
        }
    }
}

fn run(project: &Project, overrides: &LevelOverrides) -> Result<(Config, Report), ConfigError> {
    let config = configuration(project, overrides)?;
    let report = pipeline::check(project, &config)?;
    Ok((config, report))
}

fn configuration(project: &Project, overrides: &LevelOverrides) -> Result<Config, ConfigError> {
    let reported = || project.packages.iter().filter(|package| package.is_reported);
    let roots = reported().map(|package| package.workspace_root.as_path());
    let manifests =
        reported().filter(|package| package.metadata.is_some()).map(|package| package.manifest_path.as_path());
    let mut config = config::load(roots, manifests)?;
    config.overrides = overrides.clone();
    rules::validate(&config)?;
    Ok(config)
}

/// A wrong configuration is reported like a file that cannot be parsed, so that editors show its place.
fn of_wrong_configuration(project: &Project, error: &ConfigError) -> Report {
    let mut sources = SourceMap::new(project.root.clone());
    let mut problem = Problem {
        file: String::new(),
        span: None,
        message: error.message.clone(),
        help: error.help.clone(),
        is_error: true,
    };
    if let Some(place) = &error.place {
        problem.file = sources.display_name(&place.path);
        if let Some(text) = &error.text {
            let offset = |at: usize| u32::try_from(at).unwrap_or(u32::MAX);
            let file = sources.add(&place.path, text.clone());
            problem.span = Some(Span::new(file, offset(place.range.start), offset(place.range.end)));
        }
    }
    Report { sources, problems: vec![problem], ..Report::default() }
}

fn selection(input: &Input) -> Selection {
    let Input { paths, scope, build, .. } = input;
    Selection {
        current_dir: std::env::current_dir().unwrap_or_default(),
        manifest_path: scope.manifest_path.clone(),
        paths: paths.clone(),
        packages: scope.package.clone(),
        workspace: scope.workspace,
        exclude: scope.exclude.clone(),
        targets: targets(scope),
        features: features(build),
        target: build.target.first().cloned(),
        is_release: build.release || build.profile.as_deref().is_some_and(|name| name == "release" || name == "bench"),
        cargo_options: cargo_options(build),
    }
}

fn targets(scope: &Scope) -> TargetFilter {
    let names = |all: bool, named: &[String]| Names { all, named: named.to_vec() };
    TargetFilter {
        lib: scope.lib,
        bins: names(scope.bins, &scope.bin),
        examples: names(scope.examples, &scope.example),
        tests: names(scope.tests, &scope.test),
        benches: names(scope.benches, &scope.bench),
        all: scope.all_targets,
    }
}

fn features(build: &Build) -> Features {
    let named = build.features.iter().flat_map(|list| list.split([' ', ','])).filter(|name| !name.is_empty());
    Features {
        named: named.map(str::to_owned).collect(),
        all: build.all_features,
        no_default: build.no_default_features,
    }
}

fn cargo_options(build: &Build) -> Vec<String> {
    let config = build.config.iter().flat_map(|value| ["--config".to_owned(), value.clone()]);
    config.chain(build.unstable.iter().flat_map(|flag| ["-Z".to_owned(), flag.clone()])).collect()
}
