//! Figures about a run beyond the summary, for `--stats`.

use std::collections::BTreeMap;

use crate::pipeline::Report;
use crate::project::Project;

/// Lines of `name: number`, in a fixed order.
#[must_use]
pub fn stats(project: &Project, report: &Report) -> String {
    let reported = project.packages.iter().filter(|package| package.is_reported).count();
    let targets =
        project.packages.iter().flat_map(|package| &package.targets).filter(|target| target.is_reported).count();
    let lines: u64 = report.sources.files().map(|(_, file)| u64::from(file.line_count())).sum();
    let bytes: usize = report.sources.files().map(|(_, file)| file.byte_count()).sum();
    let mut rows = vec![
        ("packages".to_owned(), reported as u64),
        ("packages read for types only".to_owned(), (project.packages.len() - reported) as u64),
        ("targets".to_owned(), targets as u64),
        ("files read".to_owned(), report.sources.files().count() as u64),
        ("lines read".to_owned(), lines),
        ("bytes read".to_owned(), bytes as u64),
        ("filter types".to_owned(), report.filter_types as u64),
        ("cycles".to_owned(), report.cycles.len() as u64),
    ];
    let mut kinds = BTreeMap::new();
    let mut verdicts = BTreeMap::new();
    let mut gates = BTreeMap::new();
    for cycle in &report.cycles {
        *kinds.entry(cycle.kind).or_insert(0) += 1;
        for pair in &cycle.filters {
            *verdicts.entry(pair.verdict).or_insert(0) += 1;
            if let Some(gate) = pair.gate {
                *gates.entry(gate).or_insert(0) += 1;
            }
        }
    }
    rows.extend(kinds.into_iter().map(|(kind, number)| (format!("cycles: {}", kind.name()), number)));
    rows.extend(verdicts.into_iter().map(|(verdict, number)| (format!("filters: {}", verdict.name()), number)));
    rows.extend(gates.into_iter().map(|(gate, number)| (format!("gates: {}", gate.name()), number)));
    let width = rows.iter().map(|(name, _)| name.len()).max().unwrap_or(0);
    rows.into_iter().map(|(name, number)| format!("{name:width$}  {number}\n")).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::sample;

    #[test]
    fn everything_is_counted() {
        let (project, report) = sample::report();
        insta::assert_snapshot!(stats(&project, &report));
    }
}
