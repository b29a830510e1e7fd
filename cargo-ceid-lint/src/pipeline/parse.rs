//! From packages to parsed crates, side by side. Never keeps what cannot matter: of such packages only the problems are told.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::macros::{Macros, Order, neighbours};
use super::{CheckedCrate, Gate, Memory, Steps};
use crate::diagnostic::Problem;
use crate::index::CrateInput;
use crate::parallel::biggest_first;
use crate::project::{CfgValues, Project, TargetKind};
use crate::relevance::{Component, Names, Sets, exports_macros};
use crate::source::{FileId, FileSet, ReadSource, SourceMap};
use crate::syntax::tree::{Item, ItemKind};
use crate::syntax::{Neighbours, RootModule, parse_root, survey_root};

/// How much code without any filter is parsed all the same, in bytes: as long as that takes less time than to start cargo, what
/// is broken in it is told.
const ALWAYS_PARSED: u64 = 256 * 1024;

/// Packages that were parsed, and are analysed together.
#[derive(Clone, Debug, Default)]
pub(super) struct Part {
    /// Indices into the project's packages.
    pub(super) packages: Vec<usize>,
    /// Their crates.
    pub(super) inputs: Vec<CrateInput>,
    /// Their texts.
    pub(super) sources: SourceMap,
    /// What could not be read or parsed, and what was left unread.
    pub(super) problems: Vec<Problem>,
    /// See [`Report::left_out`](super::Report::left_out).
    pub(super) left_out: BTreeSet<PathBuf>,
    /// See [`Report::checked`](super::Report::checked).
    pub(super) checked: Vec<CheckedCrate>,
    /// The files that were read.
    pub(super) read: BTreeSet<PathBuf>,
    /// The macros that the libraries of its packages give to others.
    exports: Macros,
    /// The macros that others gave to them.
    given: Macros,
    /// Whether it is to be analysed.
    pub(super) can_matter: bool,
}

impl Part {
    /// How much there is to analyse.
    pub(super) fn bytes(&self) -> u64 {
        if self.can_matter { self.bytes_read() } else { 0 }
    }

    pub(super) fn bytes_read(&self) -> u64 {
        self.sources.files().map(|(_, file)| file.byte_count() as u64).sum()
    }

    /// Forgets the texts of which nothing will be shown.
    fn drop_texts(&mut self) {
        let shown: BTreeSet<FileId> = self.problems.iter().filter_map(|problem| Some(problem.span?.file)).collect();
        self.sources.drop_texts(|file| !shown.contains(&file));
    }
}

/// The components that are looked at: of one in which nothing is reported, nothing would be told.
pub(super) fn looked_at<'a>(
    project: &'a Project,
    components: &'a [Component],
    gate: Gate,
) -> impl Iterator<Item = &'a Component> {
    let unnamed: u64 = components.iter().filter(|own| !own.can_matter).map(Component::bytes).sum();
    let is_parsed = move |own: &&Component| own.can_matter || gate == Gate::Off || unnamed <= ALWAYS_PARSED;
    let is_reported = |own: &&Component| own.packages.iter().any(|package| project.packages[*package].is_reported);
    components.iter().filter(is_parsed).filter(is_reported)
}

/// Parses the packages of all components that are looked at, and about which nothing is remembered.
pub(super) fn parts(
    project: &Project,
    source: &Arc<dyn ReadSource>,
    components: &[Component],
    names: &Names,
    gate: Gate,
    memory: Option<&mut Memory>,
    steps: &Steps,
) -> Vec<Part> {
    let known = memory.as_deref();
    let is_judged = |component: &&Component| known.is_some_and(|known| known.has_judged(component.packages[0]));
    let components: Vec<&Component> = looked_at(project, components, gate).filter(|own| !is_judged(own)).collect();
    for component in &components {
        steps.expect(component.bytes(), component.can_matter);
    }
    let packages = components.iter().flat_map(|own| own.packages.iter().zip(&own.sizes).map(move |of| (of, *own)));
    let packages: BTreeMap<usize, (u64, &Component)> =
        packages.map(|((package, size), own)| (*package, (*size, own))).collect();
    let held = source.held().into_iter().filter(|file| source.read(file).is_ok_and(|it| exports_macros(it.as_bytes())));
    let held: BTreeSet<usize> = held.filter_map(|file| project.owner(&file)).collect();
    let exports = |package: usize| {
        held.contains(&package) || packages.get(&package).is_some_and(|(_, own)| own.exporters.contains(&package))
    };
    let order = Order::of(project);
    let mut parsed: BTreeMap<usize, Part> = BTreeMap::new();
    for round in order.rounds(packages.keys().copied(), exports) {
        let sizes: Vec<u64> = round.iter().map(|package| packages[package].0).collect();
        let known_macros: Macros = parsed.values().flat_map(|part| part.exports.clone()).collect();
        let parts = biggest_first(&sizes, |at| {
            let (package, component) = (round[at], packages[&round[at]].1);
            let given = order.given_to(package, &known_macros);
            let tree = known.filter(|_| component.is_named).and_then(|known| known.tree(package));
            if let Some(part) = tree.filter(|part| part.given == given) {
                steps.add(sizes[at]);
                return part;
            }
            let mut part = parse_as(project, &order, source, &[package], given, parser_of(component));
            if !component.can_matter {
                part.drop_texts();
            }
            steps.add(sizes[at]);
            part
        });
        parsed.extend(round.into_iter().zip(parts));
    }
    if let Some(memory) = memory {
        let owners: Vec<usize> = source.held().iter().filter_map(|file| project.owner(file)).collect();
        let is_open =
            |component: &Component| component.is_named && owners.iter().any(|owner| component.packages.contains(owner));
        for (package, part) in parsed.iter().filter(|(package, _)| is_open(packages[package].1)) {
            memory.learn_tree(*package, part);
        }
    }
    let mut parts: Vec<Part> = Vec::new();
    for component in components {
        let own = component.packages.iter().filter_map(|package| parsed.remove(package)).collect();
        let mut part = together(project, source, own, parser_of(component));
        part.can_matter = component.can_matter
            && (component.packages.iter().any(|package| names.are_linked_to(&project.packages[*package]))
                || names.are_in(part.sources.files().map(|(_, file)| file.text.as_bytes())));
        if !part.can_matter {
            part.inputs.clear();
        } else if !component.is_named {
            // A name was written where nobody had looked for it.
            part = Part { can_matter: true, ..parse(project, source, &component.packages) };
        }
        parts.push(part);
    }
    join(project, source, parts)
}

/// Joins the parts that read the same file, by way of a link in the file system.
fn join(project: &Project, source: &Arc<dyn ReadSource>, parts: Vec<Part>) -> Vec<Part> {
    let (parts, others): (Vec<Part>, Vec<Part>) = parts.into_iter().partition(|part| part.can_matter);
    let mut sets = Sets::new(parts.len());
    let mut first: BTreeMap<&PathBuf, usize> = BTreeMap::new();
    for (number, part) in parts.iter().enumerate() {
        for file in &part.read {
            sets.join(*first.entry(file).or_insert(number), number);
        }
    }
    let mut joined: BTreeMap<usize, Vec<Part>> = BTreeMap::new();
    for (number, part) in parts.into_iter().enumerate() {
        joined.entry(sets.root(number)).or_default().push(part);
    }
    let joined =
        joined.into_values().map(|parts| Part { can_matter: true, ..together(project, source, parts, parse_root) });
    joined.chain(others).collect()
}

/// Puts the parts of a component together. A file that several of its packages read is one file.
fn together(project: &Project, source: &Arc<dyn ReadSource>, parts: Vec<Part>, parse_root: ParseRoot) -> Part {
    let mut packages: Vec<usize> = parts.iter().flat_map(|part| part.packages.iter().copied()).collect();
    packages.sort_unstable();
    let files: usize = parts.iter().map(|part| part.read.len()).sum();
    let different: BTreeSet<&PathBuf> = parts.iter().flat_map(|part| &part.read).collect();
    if different.len() < files {
        return parse_as(project, &Order::of(project), source, &packages, Macros::new(), parse_root);
    }
    let mut whole = Part { packages, sources: SourceMap::new(project.root.clone()), ..Part::default() };
    for part in parts {
        whole.inputs.extend(part.inputs);
        whole.sources.extend(part.sources);
        whole.problems.extend(part.problems);
        whole.left_out.extend(part.left_out);
        whole.checked.extend(part.checked);
        whole.read.extend(part.read);
        whole.exports.extend(part.exports);
    }
    whole
}

/// Reads a crate with its modules.
type ParseRoot = fn(&Path, &str, &CfgValues, &Neighbours, &mut FileSet, &mut Vec<Problem>) -> RootModule;

/// Parses the crates of some packages with their modules, one after the other.
pub(super) fn parse(project: &Project, source: &Arc<dyn ReadSource>, packages: &[usize]) -> Part {
    parse_as(project, &Order::of(project), source, packages, Macros::new(), parse_root)
}

/// Only where a filter may be are the items of use.
fn parser_of(component: &Component) -> ParseRoot {
    if component.is_named { parse_root } else { survey_root }
}

fn parse_as(
    project: &Project,
    order: &Order<'_>,
    source: &Arc<dyn ReadSource>,
    packages: &[usize],
    given: Macros,
    parse_root: ParseRoot,
) -> Part {
    let mut files = FileSet::new(SourceMap::new(project.root.clone()), Arc::clone(source));
    let mut part = Part { packages: packages.to_vec(), ..Part::default() };
    // Each package has a range of numbers of its own.
    let stride = u32::MAX as usize / project.packages.len().max(1);
    let mut known_macros = given.clone();
    for number in order.rounds(packages.iter().copied(), |_| true).into_iter().flatten() {
        let package = &project.packages[number];
        files.begin(FileId(u32::try_from(number * stride).expect("it is smaller than the last number")));
        let mut known = neighbours(package, &order.given_to(number, &known_macros));
        // The other targets of a package may call the macros of its library.
        let (libs, others): (Vec<_>, Vec<_>) =
            package.targets.iter().enumerate().partition(|(_, target)| target.kind == TargetKind::Lib);
        for (target_number, target) in libs.into_iter().chain(others) {
            let mut cfg = package.cfg.clone();
            if target.cfg_test {
                cfg.flags.insert("test".to_owned());
            }
            let root = parse_root(&target.src_path, &target.edition, &cfg, &known, &mut files, &mut part.problems);
            if root.is_absent && package.is_reported && matches!(target.kind, TargetKind::Lib | TargetKind::Bin) {
                part.problems.push(absent(files.map().display_name(&target.src_path)));
            }
            part.left_out.extend(root.left_out);
            let is_reported = target.is_reported && package.is_reported;
            if is_reported {
                part.checked.push(CheckedCrate { package: number, files: root.files, removed: root.removed.clone() });
            }
            if target.kind == TargetKind::Lib && !root.exports.is_empty() {
                let exports = Arc::new(root.exports);
                known.exports.insert(target.crate_name.clone(), Arc::clone(&exports));
                known_macros.insert(number, Arc::clone(&exports));
                part.exports.insert(number, exports);
            }
            part.inputs.push(CrateInput {
                package: number,
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
    part.inputs.sort_by_key(|input| (input.package, input.target));
    part.given = given;
    (part.sources, part.read) = files.into_parts();
    part
}

/// A crate that is for another target than the one that is checked.
fn absent(file: String) -> Problem {
    let message = "the crate is not there under this `cfg`: that of its `#![cfg(…)]` does not hold".to_owned();
    let help = Some("check it with the `--target` or the `--features` that it is for".to_owned());
    Problem { file, span: None, message, help, is_error: false }
}

/// The names with which the imports of items begin, if a crate may have them.
fn imported(items: &[Item], names: &mut BTreeSet<String>) {
    let is_other =
        |name: &String| name.starts_with(char::is_lowercase) && !matches!(name.as_str(), "crate" | "self" | "super");
    for item in items {
        match &item.kind {
            ItemKind::Use(uses) => {
                names.extend(uses.iter().filter_map(|name| name.path.first()).filter(|name| is_other(name)).cloned());
            }
            ItemKind::Mod(items) => imported(items, names),
            _ => {}
        }
    }
}

/// Crates of which single functions are called by their full paths: `tokio::time::sleep(period).await`.
const NAMED_IN_PASSING: &[&str] = &["tokio", "async_std", "smol", "embassy_time", "spin_sleep", "parking_lot"];

/// Tells each crate which ones it can name.
pub(super) fn link(project: &Project, inputs: &mut [CrateInput]) {
    let is_lib = |input: &CrateInput| project.packages[input.package].targets[input.target].kind == TargetKind::Lib;
    let libs: BTreeMap<usize, usize> =
        inputs.iter().enumerate().filter(|(_, input)| is_lib(input)).map(|(at, input)| (input.package, at)).collect();
    for input in inputs {
        let package = &project.packages[input.package];
        for dependency in &package.dependencies {
            let krate = dependency.package.and_then(|package| libs.get(&package)).copied();
            input.externs.insert(dependency.extern_name.clone(), (krate, dependency.package_name.clone()));
        }
        if package.manifest_path.as_os_str().is_empty() {
            // What a file without a manifest depends on is told by what it imports.
            let mut names = BTreeSet::new();
            imported(&input.items, &mut names);
            // These are as often named by their full paths.
            names.extend(NAMED_IN_PASSING.iter().map(|&name| name.to_owned()));
            input.externs.extend(names.into_iter().map(|name| (name.clone(), (None, name))));
        }
        let target = &package.targets[input.target];
        if target.kind != TargetKind::Lib
            && let Some(own) = libs.get(&input.package)
            && let Some(lib) = package.targets.iter().find(|target| target.kind == TargetKind::Lib)
        {
            input.externs.insert(lib.crate_name.clone(), (Some(*own), package.name.clone()));
        }
    }
}
