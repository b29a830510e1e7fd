//! A check with the configuration that lies beside the project's manifests.

use std::path::Path;
use std::sync::Arc;

use super::{BaselineChoice, Clock, Earlier, Found, Gate, Memory, Report, Steps, judge, known};
use crate::config::{self, Config, ConfigError, LevelOverrides};
use crate::diagnostic::Problem;
use crate::project::{Package, Project};
use crate::relevance::ReadAhead;
use crate::rules;
use crate::source::{FileId, ReadSource, SourceMap, Span};

/// What the user asked for beyond what lies beside the code.
#[derive(Clone, Debug, Default)]
pub struct Options {
    /// The levels of the command line.
    pub overrides: LevelOverrides,
    /// Which baseline the findings are compared with.
    pub baseline: BaselineChoice,
    /// Which packages are parsed.
    pub gate: Gate,
    /// What measures where the time goes.
    pub clock: Option<Clock>,
    /// What tells how far the check has come.
    pub steps: Steps,
    /// What the plans are for.
    pub purpose: Purpose,
}

/// What the plans to hand filters to guards are made for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Purpose {
    /// To suggest them where something was found.
    #[default]
    Findings,
    /// To make those suggestions, so that imports are looked for that nothing needs any more.
    Fixes,
    /// To offer them for all loops.
    Offers,
    /// To follow them, so that imports are looked for that nothing needs any more.
    Migration,
}

/// What a check found out, or what is wrong with its configuration.
#[derive(Debug)]
pub struct Configured {
    /// What was found out; nothing but the problem if the configuration is wrong.
    pub report: Report,
    /// Whether the configuration was wrong, so that nothing was checked.
    pub is_config_wrong: bool,
    /// Whether nothing was checked, because the project is not resolved and would have to be.
    pub is_unresolved: bool,
    /// The configuration.
    pub config: Config,
}

/// Checks a project with its own configuration, and compares what is found with its baseline. What could not be loaded is among the problems.
#[must_use]
pub fn check_configured(project: &Project, options: &Options, source: Box<dyn ReadSource>) -> Configured {
    check_after(project, options, source, Earlier::default())
}

/// What was found out again, after some texts have changed.
#[derive(Debug)]
pub struct Again {
    /// What was found out, by parts of the project that have nothing to do with each other. A part is the one of the check before
    /// if nothing in it has changed.
    pub parts: Vec<Arc<Report>>,
    /// Whether the configuration was wrong, so that nothing was checked.
    pub is_config_wrong: bool,
}

/// The same, where only texts that `source` holds have changed since the check that `memory` is of.
#[must_use]
pub fn check_again(project: &Project, options: &Options, source: Box<dyn ReadSource>, memory: &mut Memory) -> Again {
    let config = memory
        .config(&*source)
        .map_or_else(|| Ok(Arc::new(configuration(project, options.overrides.clone(), &*source)?)), Ok);
    let checked = config.and_then(|config| {
        memory.learn_config(&config);
        let earlier = Earlier { memory: Some(memory), purpose: options.purpose, ..Earlier::default() };
        let found = judge(project, &config, source, options.gate, earlier)?;
        // What a baseline knows is counted over all parts.
        if let Found::Parts(parts, _) = &found
            && !known::is_there(project, &options.baseline)?
        {
            return Ok(parts.iter().map(|own| Arc::clone(&own.report)).collect());
        }
        let mut report = found.together(project);
        known::compare(project, &config, &options.baseline, &mut report)?;
        Ok(vec![Arc::new(report)])
    });
    let is_config_wrong = checked.is_err();
    let mut parts: Vec<Arc<Report>> =
        checked.unwrap_or_else(|error| vec![Arc::new(of_wrong_configuration(project, &error))]);
    parts.push(Arc::new(not_loaded(project)));
    Again { parts, is_config_wrong }
}

/// The same, where some files were read while the project was loaded.
#[must_use]
pub fn check_read_ahead(
    project: &Project,
    options: &Options,
    source: Box<dyn ReadSource>,
    ahead: &ReadAhead,
) -> Configured {
    check_after(project, options, source, Earlier { ahead: Some(ahead), ..Earlier::default() })
}

fn check_after(project: &Project, options: &Options, source: Box<dyn ReadSource>, earlier: Earlier<'_>) -> Configured {
    let earlier = Earlier { clock: options.clock, steps: options.steps.clone(), purpose: options.purpose, ..earlier };
    let checked = configuration(project, options.overrides.clone(), &*source).and_then(|config| {
        let found = judge(project, &config, source, options.gate, earlier)?;
        let is_unresolved = matches!(found, Found::Unresolved);
        let mut report = found.together(project);
        if !is_unresolved {
            known::compare(project, &config, &options.baseline, &mut report)?;
        }
        Ok(Configured { report, is_config_wrong: false, is_unresolved, config })
    });
    let mut checked = checked.unwrap_or_else(|error| Configured {
        report: of_wrong_configuration(project, &error),
        is_config_wrong: true,
        is_unresolved: false,
        config: Config::default(),
    });
    checked.report.add(not_loaded(project));
    checked
}

/// What could not be loaded.
fn not_loaded(project: &Project) -> Report {
    let mut report = Report { sources: SourceMap::new(project.root.clone()), ..Report::default() };
    let file = |problem: &Problem| report.sources.display_name(problem.file.as_ref());
    let problems = project.problems.iter().map(|problem| Problem { file: file(problem), ..problem.clone() }).collect();
    report.add_problems(problems);
    report
}

fn configuration(project: &Project, overrides: LevelOverrides, source: &dyn ReadSource) -> Result<Config, ConfigError> {
    let reported = || project.packages.iter().filter(|package| package.is_reported);
    let roots = reported().map(|package| package.workspace_root.as_path());
    // What cargo has not seen may stand in the text that an editor holds. To ask the disk about each manifest costs more than
    // to check a file, so that this is done only if one may be open.
    let held: Vec<_> = source.held().into_iter().filter(|path| path.extension().is_none_or(|it| it != "rs")).collect();
    let is_held = |path: &Path| !held.is_empty() && held.contains(&source.identity(path));
    let has_metadata = |package: &Package| package.metadata.is_some() || is_held(&package.manifest_path);
    let manifests = reported().filter(|package| has_metadata(package)).map(|package| package.manifest_path.as_path());
    let mut config = config::load(roots, manifests, source)?;
    config.overrides = overrides;
    rules::validate(&config)?;
    Ok(config)
}

/// A wrong configuration is reported like a file that cannot be parsed, so that editors show its place.
fn of_wrong_configuration(project: &Project, error: &ConfigError) -> Report {
    let mut sources = SourceMap::new(project.root.clone());
    let mut files: Vec<(&Path, FileId)> = Vec::new();
    let mut problems = Vec::new();
    for error in error.each() {
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
                let known = files.iter().find(|(path, _)| *path == place.path).map(|(_, file)| *file);
                let file = known.unwrap_or_else(|| sources.add(&place.path, text.clone()));
                files.push((&place.path, file));
                problem.span = Some(Span::new(file, offset(place.range.start), offset(place.range.end)));
            }
        }
        problems.push(problem);
    }
    Report { sources, problems, ..Report::default() }
}
