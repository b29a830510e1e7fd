//! What a run found out, put together from its parts.

use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;
use std::sync::Arc;

use super::{CheckedCrate, Timings, Unchanged};
use crate::baseline::Comparison;
use crate::count::Cycle;
use crate::diagnostic::{Diagnostic, Problem};
use crate::index::FunctionPlaces;
use crate::migrate::{IdleImports, Plan};
use crate::source::{SourceMap, Span};

/// What a run found out.
#[derive(Clone, Debug, Default)]
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
    /// The functions of all code that was analysed.
    pub functions: FunctionPlaces,
    /// The baselines that the findings were compared with.
    pub baselines: Vec<Comparison>,
    /// What was left out, if only changed lines are looked at.
    pub unchanged: Option<Unchanged>,
    /// The packages that were not parsed, because nothing in them can be a filter: indices into the project's packages.
    pub unparsed: BTreeSet<usize>,
    /// The packages with cycles that are no members of the workspace: indices into the project's packages.
    pub beside: BTreeSet<usize>,
    /// How many filter types were found.
    pub filter_types: usize,
    /// How many functions were only searched for repetitions, as nothing calls them, and have none.
    pub presumed: usize,
    /// What can be done about each loop that updates filters by hand.
    pub plans: Vec<Plan>,
    /// The edits that remove each import of a filter's trait that nothing needs beside a guard.
    pub idle_imports: IdleImports,
    /// The manifests of the packages that these plans change, and of their workspaces.
    pub manifests: BTreeMap<PathBuf, Arc<str>>,
    /// Where the time went, if there was a clock.
    pub timings: Timings,
}

impl Report {
    /// The findings that nothing suppresses and no baseline knows: those that people see and that decide how a run ends.
    pub fn shown(&self) -> impl Iterator<Item = &Diagnostic> {
        self.diagnostics.iter().filter(|finding| finding.is_shown())
    }

    /// What was found in several parts of a project.
    #[must_use]
    pub fn of_parts(parts: impl IntoIterator<Item = Arc<Self>>, root: PathBuf) -> Self {
        let mut whole = Self { sources: SourceMap::new(root), ..Self::default() };
        for part in parts {
            let mut part = Arc::unwrap_or_clone(part);
            whole.sources.extend(std::mem::take(&mut part.sources));
            whole.add(part);
        }
        whole.sort();
        whole
    }

    /// Adds what was found in another part of the project, but for its texts.
    pub(super) fn add(&mut self, other: Self) {
        self.diagnostics.extend(other.diagnostics);
        self.cycles.extend(other.cycles);
        self.problems.extend(other.problems);
        self.unread.extend(other.unread);
        self.left_out.extend(other.left_out);
        self.checked.extend(other.checked);
        self.functions.extend(other.functions);
        self.plans.extend(other.plans);
        self.idle_imports.removals.extend(other.idle_imports.removals);
        self.idle_imports.handed_on.extend(other.idle_imports.handed_on);
        self.idle_imports.doubtful.extend(other.idle_imports.doubtful);
        self.manifests.extend(other.manifests);
        self.beside.extend(other.beside);
        self.filter_types += other.filter_types;
        self.presumed += other.presumed;
        self.timings.add(&other.timings);
    }

    pub(super) fn add_problems(&mut self, problems: Vec<Problem>) {
        let (errors, unread): (Vec<_>, Vec<_>) = problems.into_iter().partition(|problem| problem.is_error);
        self.problems.extend(errors);
        self.unread.extend(unread);
    }

    /// Puts what the parts found into one order.
    pub(super) fn sort(&mut self) {
        sort(&mut self.diagnostics);
        self.cycles.sort_by_key(|cycle| (cycle.head, cycle.package, cycle.target));
        self.checked.sort_by_key(|krate| krate.package);
        self.plans.sort_by_key(|plan| plan.head);
        self.idle_imports.removals.sort();
        self.idle_imports.handed_on.sort();
        self.idle_imports.doubtful.sort();
        for list in [&mut self.problems, &mut self.unread] {
            let mut seen = BTreeSet::new();
            let place = |span: Span| (span.start, span.end);
            list.retain(|problem| {
                seen.insert((problem.file.clone(), problem.span.map(place), problem.message.clone()))
            });
        }
    }
}

pub(super) fn sort(findings: &mut [Diagnostic]) {
    findings.sort_by(|left, right| {
        (left.primary.span, left.rule, &left.message).cmp(&(right.primary.span, right.rule, &right.message))
    });
}
