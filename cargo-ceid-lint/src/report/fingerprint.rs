//! A name for a finding that stays the same when lines move: rule, file, function and filters, and which of several alike.

use std::collections::BTreeMap;

use crate::diagnostic::Diagnostic;
use crate::source::SourceMap;

/// One fingerprint for each finding, in their order.
pub(super) fn fingerprints(sources: &SourceMap, diagnostics: &[Diagnostic]) -> Vec<String> {
    let mut seen: BTreeMap<String, u32> = BTreeMap::new();
    let mut fingerprints = Vec::new();
    for diagnostic in diagnostics {
        let file = &sources.file(diagnostic.primary.span.file).name;
        let facts = &diagnostic.facts;
        let key = [diagnostic.rule, file, &facts.function, &facts.filters.join("\u{1f}")].join("\u{1e}");
        let ordinal = seen.entry(key.clone()).or_default();
        fingerprints.push(format!("{:016x}", fnv1a(format!("{key}\u{1e}{ordinal}").as_bytes())));
        *ordinal += 1;
    }
    fingerprints
}

/// The 64-bit FNV-1a hash, which is the same on every machine and in every version.
fn fnv1a(bytes: &[u8]) -> u64 {
    bytes.iter().fold(0xcbf2_9ce4_8422_2325, |hash, byte| (hash ^ u64::from(*byte)).wrapping_mul(0x0100_0000_01b3))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::sample;

    #[test]
    fn the_hash_is_the_published_one() {
        assert_eq!(fnv1a(b""), 0xcbf2_9ce4_8422_2325);
        assert_eq!(fnv1a(b"foobar"), 0x8594_4171_f739_67e8);
    }

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
