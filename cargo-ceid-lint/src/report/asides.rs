//! What is said beside the summary: how many findings are known, how many of those are fixed, and what `--since` left out.

use super::count;
use crate::pipeline::Report;

/// One line each.
#[must_use]
pub fn asides(report: &Report) -> Vec<String> {
    let mut lines = Vec::new();
    for comparison in &report.baselines {
        let path = report.sources.display_name(&comparison.path);
        if comparison.known > 0 {
            let are = if comparison.known == 1 { "is" } else { "are" };
            lines.push(format!("{} {are} in `{path}`", count(comparison.known, "known finding")));
        }
        lines.extend(stale(comparison.stale(), &path));
    }
    if let Some(unchanged) = &report.unchanged {
        let mut parts = Vec::new();
        if unchanged.cycles > 0 {
            parts.push(count(unchanged.cycles, "cycle"));
        }
        if !unchanged.findings.is_empty() || parts.is_empty() {
            parts.push(count(unchanged.findings.len(), "finding"));
        }
        let touch =
            if parts.len() == 1 && unchanged.cycles + unchanged.findings.len() == 1 { "touches" } else { "touch" };
        let parts = parts.join(" and ");
        lines.push(format!("left out {parts} that {touch} no line changed since `{}`", unchanged.revision));
    }
    lines
}

/// How to take what is fixed out of a baseline, if something is.
#[must_use]
pub fn stale(number: u32, path: &str) -> Option<String> {
    let (are, them) = if number == 1 { ("is", "it") } else { ("are", "them") };
    let findings = count(number as usize, "finding");
    (number > 0).then(|| {
        format!("{findings} of `{path}` {are} no longer reported: `cargo ceid-lint baseline --prune` takes {them} out")
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::baseline::{Comparison, Key};
    use crate::pipeline::Unchanged;

    #[test]
    fn what_is_known_fixed_and_left_out_is_told_in_a_line_each() {
        let key =
            Key { file: "a.rs".to_owned(), function: String::new(), rule: "missed_update", filter: String::new() };
        let comparison = Comparison {
            path: "ceid-baseline.toml".into(),
            old: Some([(key.clone(), 2)].into()),
            checked: [key].into(),
            known: 1,
            ..Comparison::default()
        };
        let unchanged = Unchanged { revision: "main".to_owned(), ..Unchanged::default() };
        let report = Report { baselines: vec![comparison], unchanged: Some(unchanged), ..Report::default() };
        let expected = [
            "1 known finding is in `ceid-baseline.toml`",
            "2 findings of `ceid-baseline.toml` are no longer reported: `cargo ceid-lint baseline --prune` takes them out",
            "left out 0 findings that touch no line changed since `main`",
        ];
        assert_eq!(asides(&report), expected);
        assert_eq!(asides(&Report::default()), [""; 0]);
    }
}
