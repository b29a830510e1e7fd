//! Plans by what tells them apart from round to round.

use std::collections::{BTreeMap, BTreeSet};

use crate::count::CycleKind;
use crate::migrate::{Plan, quoted};
use crate::pipeline::Report;
use crate::source::Span;

/// The file and the title of a plan's fix. Lines move, and the loops of a function keep their order.
pub(super) type Key = (String, String);

/// A plan of a report.
pub(super) struct Keyed<'r> {
    pub(super) key: Key,
    pub(super) plan: &'r Plan,
}

/// The plans of a report, in their order.
pub(super) fn keyed(report: &Report) -> Vec<Keyed<'_>> {
    let mut loops: BTreeMap<_, BTreeSet<Span>> = BTreeMap::new();
    for cycle in report.cycles.iter().filter(|cycle| cycle.kind != CycleKind::Function) {
        loops.entry((cycle.head.file, cycle.function.as_str())).or_default().insert(cycle.head);
    }
    let of = |plan: &'_ Plan| {
        let heads = loops.get(&(plan.head.file, plan.function.as_str()));
        let number = heads.map_or(0, |heads| heads.range(..plan.head).count()) + 1;
        let title = format!("{} updated by a guard in loop {number} of `{}`", quoted(&plan.filters), plan.function);
        (report.sources.file(plan.head.file).name.clone(), title)
    };
    report.plans.iter().map(|plan| Keyed { key: of(plan), plan }).collect()
}
