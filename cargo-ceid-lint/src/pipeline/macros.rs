//! Which package may call the macros of which other ones, and in what order they are parsed for that. Never asks what is written
//! in them: with the gate and without, the order is the same.

use std::collections::BTreeMap;
use std::sync::Arc;

use crate::project::{Dependency, Package, Project};
use crate::syntax::{Exports, Neighbours, has_known_macros};

/// The macros that libraries give to others, by the numbers of their packages.
pub(super) type Macros = BTreeMap<usize, Arc<Exports>>;

/// The packages of a project, each behind those that it depends on.
pub(super) struct Order<'p> {
    project: &'p Project,
    /// By package. One knows the macros of those with smaller numbers.
    ranks: Vec<usize>,
}

impl<'p> Order<'p> {
    pub(super) fn of(project: &'p Project) -> Self {
        let mut ranks = vec![usize::MAX; project.packages.len()];
        let mut open: Vec<usize> = (0..ranks.len()).collect();
        for rank in 0.. {
            let waits = |package: usize, for_tests: bool| {
                let dependencies = project.packages[package].dependencies.iter().filter(|own| for_tests || !own.is_dev);
                let mut libraries = dependencies.filter_map(|dependency| dependency.package);
                libraries.any(|library| library != package && ranks[library] == usize::MAX)
            };
            let ready = |for_tests| open.iter().copied().filter(|own| !waits(*own, for_tests)).collect::<Vec<usize>>();
            // Tests may need what needs the package. Nothing else does, if cargo is to build it.
            let found = [true, false].map(ready).into_iter().find(|ready| !ready.is_empty());
            let Some(round) = found.or_else(|| open.first().map(|first| vec![*first])) else { break };
            round.into_iter().for_each(|package| ranks[package] = rank);
            open.retain(|package| ranks[*package] == usize::MAX);
        }
        Self { project, ranks }
    }

    /// The packages whose macros a package may call.
    fn libraries(&self, package: usize) -> impl Iterator<Item = usize> {
        let all = self.project.packages[package].dependencies.iter().filter_map(|dependency| dependency.package);
        all.filter(move |library| self.ranks[*library] < self.ranks[package])
    }

    /// The macros that the crates of a package may call.
    pub(super) fn given_to(&self, package: usize, macros: &Macros) -> Macros {
        self.libraries(package).filter_map(|library| Some((library, Arc::clone(macros.get(&library)?)))).collect()
    }

    /// Packages in rounds, each behind those whose macros it may call.
    pub(super) fn rounds(
        &self,
        packages: impl Iterator<Item = usize>,
        exports: impl Fn(usize) -> bool,
    ) -> Vec<Vec<usize>> {
        let mut sorted: Vec<usize> = packages.collect();
        sorted.sort_by_key(|package| (self.ranks[*package], *package));
        let mut round_of: BTreeMap<usize, usize> = BTreeMap::new();
        let mut rounds: Vec<Vec<usize>> = Vec::new();
        for package in sorted {
            let behind = self.libraries(package).filter(|library| exports(*library));
            let round = behind.filter_map(|library| Some(round_of.get(&library)? + 1)).max().unwrap_or(0);
            round_of.insert(package, round);
            if round == rounds.len() {
                rounds.push(Vec::new());
            }
            rounds[round].push(package);
        }
        rounds
    }
}

/// What the crates of a package know of other crates: those whose macros are known by another name, and what is given to them. Known
/// macros are read by what they do, whatever their rules are.
pub(super) fn neighbours(package: &Package, given: &Macros) -> Neighbours {
    let own_name = |dependency: &Dependency| dependency.package_name.replace('-', "_");
    let (known, others): (Vec<&Dependency>, Vec<_>) =
        package.dependencies.iter().partition(|own| has_known_macros(&own_name(own)));
    let renamed = known.into_iter().filter(|own| own.extern_name != own_name(own)).map(|own| own.extern_name.clone());
    let exports = |own: &Dependency| Some((own.extern_name.clone(), Arc::clone(given.get(&own.package?)?)));
    Neighbours { renamed: renamed.collect(), exports: others.into_iter().filter_map(exports).collect() }
}
