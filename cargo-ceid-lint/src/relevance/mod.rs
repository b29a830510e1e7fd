//! Which packages can have a filter in them, decided from their bytes before anything is parsed. Never decides that a package
//! cannot matter when it is unsure: what is not understood matters.
//!
//! Packages that no dependency links cannot have to do with each other, so that each set of linked packages, a *component*, is
//! judged by itself. Without a filter there is nothing to count, and a filter needs a name: the trait's, that of a
//! `ceid:` comment or of `ceid-core`, or what an entry of the configuration or of a preset names. A component in which no such
//! name is written has no cycle and no finding.

mod ahead;
mod files;
mod links;
mod names;

use std::collections::BTreeSet;
use std::path::PathBuf;

pub use ahead::{ReadAhead, Reader, exports_macros};
pub use names::Names;

use self::ahead::FileFacts;
use self::files::{Listing, list};
use self::links::Link;
use crate::parallel::in_parallel;
use crate::project::Project;

/// Packages that dependencies or common files link.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Component {
    /// Indices into the project's packages, in their order.
    pub packages: Vec<usize>,
    /// Whether something in it can be a filter.
    pub can_matter: bool,
    /// Whether that is so because of what is written in the files that were read, and not because others may be read.
    pub is_named: bool,
    /// How many bytes of code each of them has.
    pub sizes: Vec<u64>,
    /// Those that may give macros to other crates.
    pub exporters: BTreeSet<usize>,
}

impl Component {
    /// How many bytes of code there are.
    #[must_use]
    pub fn bytes(&self) -> u64 {
        self.sizes.iter().sum()
    }
}

/// What the files of one package say.
#[derive(Clone, Debug, Default)]
struct Facts {
    /// Which needles were found.
    found: Vec<bool>,
    /// Other packages whose files it uses.
    uses: Vec<usize>,
    /// Whether it may read files that were not looked at.
    is_open: bool,
    exports: bool,
    bytes: u64,
}

/// Marks the components that the user looks at: they matter whatever is in them.
pub fn look_at(components: &mut [Component], project: &Project, files: &[PathBuf]) {
    for owner in files.iter().filter_map(|file| project.owner(file)) {
        let around = components.iter_mut().filter(|component| component.packages.contains(&owner));
        around.for_each(|component| component.can_matter = true);
    }
}

/// The components of a project, in the order of their first packages. What was read ahead is not read again.
#[must_use]
pub fn components(project: &Project, names: &Names, ahead: &ReadAhead) -> Vec<Component> {
    let facts = scan(project, names, ahead);
    let mut sets = Sets::new(facts.len());
    for (number, package) in project.packages.iter().enumerate() {
        for other in package.dependencies.iter().filter_map(|dependency| dependency.package) {
            sets.join(number, other);
        }
        for other in &facts[number].uses {
            sets.join(number, *other);
        }
    }
    let mut components: Vec<Component> = Vec::new();
    let mut place = vec![usize::MAX; project.packages.len()];
    let mut found: Vec<Vec<bool>> = Vec::new();
    for (number, facts) in facts.iter().enumerate() {
        let root = sets.root(number);
        if place[root] == usize::MAX {
            place[root] = components.len();
            components.push(Component::default());
            found.push(vec![false; names.needles.len()]);
        }
        let at = place[root];
        components[at].packages.push(number);
        components[at].can_matter |= facts.is_open;
        components[at].sizes.push(facts.bytes);
        components[at].exporters.extend(facts.exports.then_some(number));
        for (whole, own) in found[at].iter_mut().zip(&facts.found) {
            *whole |= own;
        }
    }
    for (component, found) in components.iter_mut().zip(&found) {
        let is_linked = |number: &usize| names.are_linked_to(&project.packages[*number]);
        component.is_named = names.are_written(found) || component.packages.iter().any(is_linked);
        component.can_matter |= component.is_named;
    }
    components
}

/// Reads all files of all packages on all cores, and what these include.
fn scan(project: &Project, names: &Names, ahead: &ReadAhead) -> Vec<Facts> {
    let others = files::directories(project);
    let listings: Vec<Listing> =
        in_parallel(project.packages.len(), |number| list(&project.packages[number], number, &others));
    let nothing_found = || vec![false; names.needles.len()];
    let mut facts = Vec::with_capacity(listings.len());
    let mut open: Vec<(usize, PathBuf)> = Vec::new();
    for (number, own) in listings.into_iter().enumerate() {
        facts.push(Facts { found: nothing_found(), is_open: own.is_open, ..Facts::default() });
        open.extend(own.files.into_iter().map(|file| (number, file)));
    }
    const AT_ONCE: usize = 32;
    let mut included: BTreeSet<(usize, PathBuf)> = BTreeSet::new();
    while !open.is_empty() {
        let pieces: Vec<&[(usize, PathBuf)]> = open.chunks(AT_ONCE).collect();
        let scanned = in_parallel(pieces.len(), |at| {
            let mut text = Vec::new();
            let of_file = |(number, path): &(usize, PathBuf)| {
                let mut facts = Facts { found: nothing_found(), ..Facts::default() };
                let known = ahead.get(path).filter(|_| names.are_words());
                let own = known.cloned().unwrap_or_else(|| {
                    // What cannot be read is told by the parser, if it is a part of anything.
                    facts.is_open = files::read(path, &mut text).is_err();
                    names.find(&text, &mut facts.found);
                    FileFacts::of(path, &text, facts.found[0])
                });
                facts.bytes = own.bytes;
                facts.exports = own.exports;
                facts.found[0] = own.has_word;
                let mut includes = Vec::new();
                for link in own.links {
                    let Link::To(file) = link else {
                        facts.is_open = true;
                        continue;
                    };
                    match project.owner(&file) {
                        Some(other) if other == *number => {}
                        Some(other) => facts.uses.push(other),
                        None => facts.is_open = true,
                    }
                    if !files::is_code(&file) {
                        includes.push((*number, file));
                    }
                }
                (*number, facts, includes)
            };
            pieces[at].iter().map(of_file).collect::<Vec<_>>()
        });
        open.clear();
        for (number, own, includes) in scanned.into_iter().flatten() {
            let package: &mut Facts = &mut facts[number];
            package.is_open |= own.is_open;
            package.bytes += own.bytes;
            package.exports |= own.exports;
            package.uses.extend(own.uses);
            for (whole, own) in package.found.iter_mut().zip(&own.found) {
                *whole |= own;
            }
            open.extend(includes.into_iter().filter(|include| included.insert(include.clone())));
        }
    }
    facts
}

/// Numbers that were joined to sets.
#[derive(Debug)]
pub struct Sets(Vec<usize>);

impl Sets {
    /// Each of the numbers below `count` alone.
    #[must_use]
    pub fn new(count: usize) -> Self {
        Self((0..count).collect())
    }

    /// The least number of a set.
    pub fn root(&mut self, mut number: usize) -> usize {
        while self.0[number] != number {
            self.0[number] = self.0[self.0[number]];
            number = self.0[number];
        }
        number
    }

    /// Makes one set of two.
    pub fn join(&mut self, left: usize, right: usize) {
        let (left, right) = (self.root(left), self.root(right));
        let (first, second) = (left.min(right), left.max(right));
        self.0[second] = first;
    }
}
