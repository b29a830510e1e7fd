//! From arguments to a project, its configuration and a report.

use std::io::{self, Read};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;

use clap::CommandFactory as _;

use super::Console;
use super::args::{Build, Cli, Input, NoLoops, Scope, Talk};
use super::baseline::args::Legacy;
use super::console::Stream;
use super::exit::ExitStatus;
use super::progress::Progress;
use super::{interrupted, timings, unread};
use crate::config::spelling::nearest;
use crate::pipeline::{self, BaselineChoice, Configured, Gate, Options, Report, Stage, Steps, Stopwatch};
use crate::project::{self, Changes, Features, LoadError, Names, Project, Selection, TargetFilter};
use crate::relevance::{ReadAhead, Reader};
use crate::report::{self, Summary, text};
use crate::source::{DiskSource, MAX_FILE_BYTES, MemorySource, ReadError, ReadSource};

/// What a run came to.
pub(super) struct Checked {
    pub(super) project: Project,
    pub(super) report: Report,
    pub(super) summary: Summary,
    /// Whether nothing was checked, because there was nothing to load or the configuration was wrong.
    pub(super) is_unchecked: bool,
}

/// Since when lines count as changed, and what is left out for it.
#[derive(Clone, Copy)]
pub(super) struct Since<'a> {
    pub(super) revision: &'a str,
    /// Whether cycles are left out as well as findings.
    pub(super) is_about_cycles: bool,
}

/// Loads and checks.
///
/// # Errors
/// Why nothing could be loaded, which was told.
pub(super) fn check(
    input: &Input,
    options: &Options,
    since: Option<Since<'_>>,
    console: Console,
    talk: &Talk,
) -> Result<Checked, Box<Failed>> {
    let Loaded { project, mut first } = load(input, options, console).map_err(Failed::of_load)?;
    if let Some(since) = since.filter(|_| !first.is_config_wrong)
        && let Err(error) = keep_changed(&mut first.report, since, &project)
    {
        console.error(&error.message, error.help.as_deref());
        return Err(Box::new(Failed { project, error }));
    }
    interrupted::tell(&project, console);
    Ok(Checked::of(project, first, console, talk))
}

/// Why nothing was checked, which was told, and for which project.
pub(super) struct Failed {
    project: Project,
    error: LoadError,
}

impl Failed {
    /// The project could not be loaded.
    pub(super) fn of_load(error: LoadError) -> Box<Self> {
        Box::new(Self { project: Project { root: current_dir(), ..Project::default() }, error })
    }
}

/// A project, and the first check of it.
pub(super) struct Loaded {
    pub(super) project: Project,
    pub(super) first: Configured,
}

/// Loads what the arguments select, and checks it.
///
/// # Errors
/// Why nothing could be loaded, which was told.
pub(super) fn load(input: &Input, options: &Options, console: Console) -> Result<Loaded, LoadError> {
    let begun = Instant::now();
    let mut watch = Stopwatch::start(options.clock);
    let paths = if input.paths.is_empty() { input.stdin_filename.as_slice() } else { &input.paths };
    let mut selection = selection(paths, &input.scope, &input.build);
    selection.unsaved.clone_from(&input.stdin_filename);
    mistyped_subcommand(&input.paths).inspect_err(|error| console.error(&error.message, error.help.as_deref()))?;
    let reader = selection.likely_root().filter(|_| options.gate == Gate::On).map(Reader::start);
    // How dependencies are resolved takes cargo long to tell, and matters only if there is something to analyse.
    let unresolved = || (options.gate == Gate::On).then(|| project::load_unresolved(&selection)).flatten();
    let whole = || project(&selection, console, begun);
    let loaded = unsaved_text(input)
        .inspect_err(|error| console.error(&error.message, error.help.as_deref()))
        .and_then(|text| Ok((text, unresolved().map_or_else(whole, Ok)?)));
    let ahead = reader.map(Reader::stop).unwrap_or_default();
    let (unsaved, mut project) = loaded?;
    watch.lap(Stage::Project);
    let check = |project: &Project, ahead: &ReadAhead| {
        let _progress = Progress::start(console, &options.steps, begun);
        pipeline::check_read_ahead(project, options, source(unsaved.as_ref()), ahead)
    };
    let mut first = check(&project, &ahead);
    if first.is_unresolved {
        project = whole()?;
        watch.lap(Stage::Project);
        first = check(&project, &ahead);
    }
    for package in project.packages.iter().filter(|package| package.is_reported) {
        let targets = package.targets.iter().filter(|target| target.is_reported);
        let targets: Vec<String> = targets.map(|target| format!("{} `{}`", target.kind.name(), target.name)).collect();
        console.say_if_verbose(&format!("checking `{}` {}: {}", package.name, package.version, targets.join(", ")));
    }
    let alone = unread::files_of_no_target(&project, &first.report);
    if !alone.is_empty() && !first.is_config_wrong {
        project = project::with_files(project, &alone, &selection)?;
        first = check(&project, &ahead);
    }
    first.report.timings.add(&watch.stop());
    Ok(Loaded { project, first })
}

/// A word in the place of a subcommand that is none, and no path either.
fn mistyped_subcommand(paths: &[PathBuf]) -> Result<(), LoadError> {
    let word = paths.first().filter(|path| !path.exists()).and_then(|path| path.to_str());
    let is_word = |word: &&str| word.chars().all(|letter| letter.is_ascii_alphabetic() || letter == '-');
    let Some(word) = word.filter(is_word) else { return Ok(()) };
    let cli = Cli::command();
    let help = match nearest(word, cli.get_subcommands().map(clap::Command::get_name)) {
        Some(name) => format!("did you mean the subcommand `{name}`?"),
        None => "`cargo ceid-lint --help` lists the subcommands".to_owned(),
    };
    Err(LoadError {
        message: format!("path `{word}` does not exist, nor does a subcommand `{word}`"),
        help: Some(help),
    })
}

/// Loads the project that is selected, and tells what there is to say of that.
///
/// # Errors
/// Why nothing could be loaded, which was told.
pub(super) fn project(selection: &Selection, console: Console, begun: Instant) -> Result<Project, LoadError> {
    let progress = Progress::of_cargo(console, begun);
    let loaded = project::load(selection);
    drop(progress);
    let project = loaded.inspect_err(|error| console.error(&error.message, error.help.as_deref()))?;
    for notice in project.notices.iter().filter(|_| !console.is_quiet()) {
        console.warn(notice);
    }
    Ok(project)
}

/// Checks a project that was loaded, with a bar of its own.
pub(super) fn checked(
    project: &Project,
    options: &Options,
    source: Box<dyn ReadSource>,
    console: Console,
) -> Configured {
    let options = Options { steps: Steps::default(), ..options.clone() };
    let _progress = Progress::start(console, &options.steps, Instant::now());
    pipeline::check_configured(project, &options, source)
}

/// Leaves out what was not changed since the revision.
fn keep_changed(report: &mut Report, since: Since<'_>, project: &Project) -> Result<(), LoadError> {
    let paths = report.sources.files().map(|(_, file)| file.path.as_path());
    let others: Vec<&Path> = paths.filter(|path| path.extension().is_none_or(|extension| extension != "rs")).collect();
    let changes = Changes::since(since.revision, &project.root, &others)?;
    report.keep_changed(since.revision, &changes);
    if since.is_about_cycles {
        report.keep_changed_cycles(&changes);
    }
    Ok(())
}

impl Checked {
    /// What a check came to.
    pub(super) fn of(project: Project, checked: Configured, console: Console, talk: &Talk) -> Self {
        let Configured { mut report, is_config_wrong: is_unchecked, config, .. } = checked;
        if !is_unchecked {
            unread::add_unread(&project, &config, &mut report);
        }
        if talk.stats {
            console.show(&report::stats(&project, &report));
        }
        if let Some(clock) = timings::clock(talk) {
            console.show(&report::timings(&report.timings, clock()));
        }
        let summary = Summary::of(&report);
        Self { project, report, summary, is_unchecked }
    }

    /// What a run came to that has checked nothing.
    pub(super) fn of_failed(failed: Failed) -> Self {
        let Failed { project, error } = failed;
        let report = Report { problems: vec![error.problem(Path::new("Cargo.toml"))], ..Report::default() };
        let summary = Summary::of(&report);
        Self { project, report, summary, is_unchecked: true }
    }

    /// How the run ends, telling loudly when nothing was checked.
    pub(super) fn status(&self, input: &Input, console: Console) -> ExitStatus {
        let status = self.status_of_run(input, console);
        if status == ExitStatus::Clean && self.summary.errors > 0 { ExitStatus::Findings } else { status }
    }

    /// The same, whatever was found.
    pub(super) fn status_of_run(&self, input: &Input, console: Console) -> ExitStatus {
        if self.is_unchecked {
            return ExitStatus::Incomplete;
        }
        if self.summary.problems > 0 {
            self.say_what_is_left_out(input, console);
            return ExitStatus::Incomplete;
        }
        let packages = self.project.packages.iter().filter(|package| package.is_reported).count();
        // The packages of a workspace may be fewer than the machines.
        if packages == 0 && input.scope.partition.is_some() {
            console.say("this part of the workspace holds no package");
            return ExitStatus::Clean;
        }
        if self.summary.is_nothing() {
            let what =
                format!("nothing to check: there is no cycle and no filter in {}", report::count(packages, "package"));
            let help = "a filter is a type with `impl SampledFilter`, or one that a `[[filter]]` of `ceid-lint.toml` names; `cargo ceid-lint init` looks for them";
            match input.no_loops {
                NoLoops::Fail => {
                    console.error(&what, Some(help));
                    return ExitStatus::Findings;
                }
                NoLoops::Warn => console.warn(&format!("{what}; {help}")),
                NoLoops::Pass => {}
            }
        }
        self.say_what_is_left_out(input, console);
        ExitStatus::Clean
    }

    /// Says that other members were not asked for, where a run without flags has found no cycle.
    fn say_what_is_left_out(&self, input: &Input, console: Console) {
        let scope = &input.scope;
        let is_chosen = !scope.package.is_empty() || scope.workspace || scope.partition.is_some();
        let packages = &self.project.packages;
        let others = packages.iter().filter(|package| package.is_member && !package.is_reported).count();
        if self.summary.cycles == 0 && others > 0 && !is_chosen && self.project.only.is_empty() {
            let others = report::count(others, "other package");
            console.say(&format!("note: left out: {others} of this workspace; `--workspace` checks all"));
        }
    }

    /// Prints what could not be read, for people.
    pub(super) fn show_problems(&self, console: Console) {
        for problem in &self.report.problems {
            console.show(&text::problem(&self.report.sources, problem, console.style(Stream::Err)));
        }
    }

    /// Prints what was left unread, and the summary, unless there is nothing to sum up.
    pub(super) fn say_summary(&self, console: Console) {
        if let Some(unread) = report::unread(&self.report) {
            console.say(&format!("note: {unread}"));
        }
        if !self.summary.is_nothing() && !self.is_unchecked {
            console.say(&self.summary.line());
        }
        for line in report::asides(&self.report) {
            console.say(&line);
        }
    }
}

/// The disk, with a text over it if there is one.
fn source(unsaved: Option<&(PathBuf, Arc<str>)>) -> Box<dyn ReadSource> {
    let Some((path, text)) = unsaved else { return Box::new(DiskSource) };
    let mut source = MemorySource::over(Box::new(DiskSource));
    source.insert(path, Arc::clone(text));
    Box::new(source)
}

/// The text on stdin, if it was said which file it is.
fn unsaved_text(input: &Input) -> Result<Option<(PathBuf, Arc<str>)>, LoadError> {
    let Some(name) = &input.stdin_filename else { return Ok(None) };
    let mut bytes = Vec::new();
    let unreadable = |what: String| LoadError {
        message: format!("cannot read the text of `{}` from stdin: {what}", name.display()),
        help: None,
    };
    io::stdin()
        .lock()
        .take(MAX_FILE_BYTES + 1)
        .read_to_end(&mut bytes)
        .map_err(|error| unreadable(error.to_string()))?;
    let length = bytes.len() as u64;
    if length > MAX_FILE_BYTES {
        return Err(unreadable(ReadError::TooLarge { bytes: length }.to_string()));
    }
    let text = String::from_utf8(bytes)
        .map_err(|error| unreadable(ReadError::NotUtf8 { byte: error.utf8_error().valid_up_to() }.to_string()))?;
    Ok(Some((current_dir().join(name), text.into())))
}

/// Which packages the arguments ask to be parsed.
pub(super) fn gate(input: &Input) -> Gate {
    if input.no_gate { Gate::Off } else { Gate::On }
}

/// The baseline that the arguments name.
pub(super) fn baseline(legacy: &Legacy) -> BaselineChoice {
    match &legacy.baseline {
        Some(path) => BaselineChoice::File(from_current_dir(path)),
        None if legacy.no_baseline => BaselineChoice::Ignored,
        None => BaselineChoice::Beside,
    }
}

/// A path of the command line, in full.
pub(super) fn from_current_dir(path: &Path) -> PathBuf {
    let path = current_dir().join(path);
    path.canonicalize().unwrap_or(path)
}

/// A path as the user would write it.
pub(super) fn shown(path: &Path) -> String {
    path.strip_prefix(current_dir()).unwrap_or(path).display().to_string()
}

fn current_dir() -> PathBuf {
    std::env::current_dir().unwrap_or_default()
}

/// What the arguments select.
pub(super) fn selection(paths: &[PathBuf], scope: &Scope, build: &Build) -> Selection {
    Selection {
        current_dir: current_dir(),
        manifest_path: scope.manifest_path.clone(),
        paths: paths.to_vec(),
        unsaved: None,
        packages: scope.package.clone(),
        workspace: scope.workspace,
        exclude: scope.exclude.clone(),
        partition: scope.partition,
        targets: targets(scope),
        features: features(build),
        target: build.target.first().cloned(),
        profile: build.release.then(|| "release".to_owned()).or_else(|| build.profile.clone()),
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

/// Reads the name of a profile, by cargo's rules.
pub(super) fn profile_name(name: &str) -> Result<String, String> {
    if name.is_empty() {
        return Err("the name of a profile is not empty".to_owned());
    }
    match name.chars().find(|letter| !(letter.is_alphanumeric() || matches!(letter, '_' | '-'))) {
        Some(letter) => {
            Err(format!("invalid character `{letter}`: allowed are letters, numbers, underscore, and hyphen"))
        }
        None => Ok(name.to_owned()),
    }
}

fn cargo_options(build: &Build) -> Vec<String> {
    let config = build.config.iter().flat_map(|value| ["--config".to_owned(), value.clone()]);
    config.chain(build.unstable.iter().flat_map(|flag| ["-Z".to_owned(), flag.clone()])).collect()
}
