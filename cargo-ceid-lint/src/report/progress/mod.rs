//! How far a code base has come: the share of cycles that are proved, by package and file, and what stands in the way of the rest.

mod blockers;
mod trend;

use std::collections::BTreeMap;

use serde::Serialize;

pub use blockers::{Blocker, blockers};
pub use trend::{Previous, Trend};

use crate::count::{Cycle, Pair, Verdict, is_guard_rule};
use crate::pipeline::Report;
use crate::project::Project;

/// How a filter or a cycle stands, the worst first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Standing {
    /// Wrong.
    Violated,
    /// Not decided.
    Unproved,
    /// Right.
    Proved,
    /// Right, and it cannot go wrong.
    Guarded,
}

impl Standing {
    /// All of them, the best first.
    pub const ALL: [Self; 4] = [Self::Guarded, Self::Proved, Self::Unproved, Self::Violated];

    /// The word for it.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Violated => "violated",
            Self::Unproved => "unproved",
            Self::Proved => "proved",
            Self::Guarded => "guarded",
        }
    }

    /// How a filter stands.
    #[must_use]
    pub fn of_pair(pair: &Pair) -> Self {
        Self::of(pair.verdict, pair.rules.iter().copied())
    }

    /// How a filter stands of which a verdict and rules are told.
    pub(super) fn of<'r>(verdict: Verdict, mut rules: impl Iterator<Item = &'r str>) -> Self {
        match Self::of_verdict(verdict) {
            Self::Proved | Self::Guarded if rules.any(is_guard_rule) => Self::Violated,
            standing => standing,
        }
    }

    /// How a filter stands by its counts alone.
    #[must_use]
    fn of_verdict(verdict: Verdict) -> Self {
        match verdict {
            Verdict::Guarded => Self::Guarded,
            Verdict::Unproved => Self::Unproved,
            verdict if verdict.is_proved() => Self::Proved,
            _ => Self::Violated,
        }
    }

    /// How a cycle stands: as the worst of its filters; `None` if it has none.
    #[must_use]
    pub fn of_cycle(cycle: &Cycle) -> Option<Self> {
        cycle.filters.iter().map(Self::of_pair).min()
    }
}

/// How many stand how.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Share {
    /// All that have a standing.
    pub total: usize,
    /// See [`Standing::Proved`].
    pub proved: usize,
    /// See [`Standing::Guarded`].
    pub guarded: usize,
    /// See [`Standing::Violated`].
    pub violated: usize,
    /// See [`Standing::Unproved`].
    pub unproved: usize,
}

impl Share {
    /// Counts one more.
    pub fn add(&mut self, standing: Standing) {
        self.total += 1;
        match standing {
            Standing::Violated => self.violated += 1,
            Standing::Unproved => self.unproved += 1,
            Standing::Proved => self.proved += 1,
            Standing::Guarded => self.guarded += 1,
        }
    }

    /// How many stand so.
    #[must_use]
    pub fn number(&self, standing: Standing) -> usize {
        match standing {
            Standing::Violated => self.violated,
            Standing::Unproved => self.unproved,
            Standing::Proved => self.proved,
            Standing::Guarded => self.guarded,
        }
    }

    /// The part of them in percent, never rounded up; `None` if there are none at all.
    #[must_use]
    pub fn percent(&self, number: usize) -> Option<usize> {
        (number * 100).checked_div(self.total)
    }
}

/// The shares of a file, a package or all.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Shares {
    /// The cycles that have a filter.
    pub cycles: Share,
    /// Their filters.
    pub filters: Share,
}

impl Shares {
    fn add(&mut self, cycle: &Cycle) {
        if let Some(standing) = Standing::of_cycle(cycle) {
            self.cycles.add(standing);
        }
        cycle.filters.iter().for_each(|pair| self.filters.add(Standing::of_pair(pair)));
    }
}

/// A package with its files.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PackageShares<'a> {
    /// Its name.
    pub name: &'a str,
    /// Of all its files.
    pub shares: Shares,
    /// By file, sorted.
    pub files: BTreeMap<&'a str, Shares>,
}

/// The shares of everything, and of each package that has a cycle, sorted by name.
#[must_use]
pub fn shares<'a>(project: &'a Project, report: &'a Report) -> (Shares, Vec<PackageShares<'a>>) {
    let mut all = Shares::default();
    let mut packages: BTreeMap<(&str, usize), PackageShares<'a>> = BTreeMap::new();
    for cycle in &report.cycles {
        let name = project.packages.get(cycle.package).map_or("", |package| &package.name);
        let package = packages.entry((name, cycle.package));
        let package =
            package.or_insert_with(|| PackageShares { name, shares: Shares::default(), files: BTreeMap::new() });
        all.add(cycle);
        package.shares.add(cycle);
        package.files.entry(&report.sources.file(cycle.head.file).name).or_default().add(cycle);
    }
    (all, packages.into_values().collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::sample;

    #[test]
    fn a_cycle_stands_as_its_worst_filter() {
        let (project, report) = sample::report();
        let (all, packages) = shares(&project, &report);
        assert_eq!(all.cycles, Share { total: 2, violated: 2, ..Share::default() });
        assert_eq!(all.filters, Share { total: 5, proved: 2, violated: 2, unproved: 1, guarded: 0 });
        let sum: usize = packages.iter().flat_map(|package| package.files.values()).map(|it| it.filters.total).sum();
        assert_eq!(sum, all.filters.total);
        assert_eq!(shares(&Project::default(), &Report::default()).0.cycles.percent(0), None);
    }

    #[test]
    fn a_percentage_is_not_rounded_up() {
        let share = Share { total: 1000, proved: 999, violated: 1, ..Share::default() };
        assert_eq!((share.percent(999), share.percent(1000)), (Some(99), Some(100)));
    }
}
