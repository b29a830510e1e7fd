//! A name for a finding that stays the same when lines move: rule, file, function and filters, and which of several alike.

use std::collections::BTreeMap;

use crate::diagnostic::Diagnostic;
use crate::source::{SourceMap, stable_hash};

/// One fingerprint for each finding, in their order.
pub(super) fn fingerprints(sources: &SourceMap, diagnostics: &[Diagnostic]) -> Vec<String> {
    let mut seen: BTreeMap<String, u32> = BTreeMap::new();
    let mut fingerprints = Vec::new();
    for diagnostic in diagnostics {
        let file = &sources.file(diagnostic.primary.span.file).name;
        let facts = &diagnostic.facts;
        let key = [diagnostic.rule, file, &facts.function, &facts.filters.join("\u{1f}")].join("\u{1e}");
        let ordinal = seen.entry(key.clone()).or_default();
        fingerprints.push(of_text(&format!("{key}\u{1e}{ordinal}")));
        *ordinal += 1;
    }
    fingerprints
}

/// The fingerprint of whatever the text tells apart.
pub(super) fn of_text(text: &str) -> String {
    format!("{:016x}", stable_hash(text.as_bytes()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::sample;

    #[test]
    fn equal_findings_are_told_apart_and_lines_do_not_matter() {
        let (_, report) = sample::report();
        let twice = [report.diagnostics[0].clone(), report.diagnostics[0].clone()];
        let prints = fingerprints(&report.sources, &twice);
        assert_ne!(prints[0], prints[1]);
        let mut moved = report.diagnostics[0].clone();
        moved.primary.span.start += 1;
        assert_eq!(fingerprints(&report.sources, &[moved])[0], prints[0]);
    }
}
