//! Runs the program on every case under `fixtures/rules` and compares what it finds with the markers in the case.

#[path = "support/mod.rs"]
mod support;

use std::fmt::Write as _;
use std::path::Path;

use support::case::{Case, difference};
use support::program::{check_file, report_file};

datatest_stable::harness! {
    { test = case_holds, root = "../fixtures/rules", pattern = r"\.rs$" },
}

fn case_holds(path: &Path) -> datatest_stable::Result<()> {
    let path = path.canonicalize()?;
    let text = std::fs::read_to_string(&path)?;
    let case = Case::parse(&text)?;

    let run = check_file(&path);
    let mut failures = difference(&case, &run.findings()?);
    if !case.reports.is_empty() {
        let pairs = report_file(&path).pairs()?;
        for expected in case.reports.iter().filter(|expected| !pairs.iter().any(|pair| expected.matches(pair))) {
            writeln!(failures, "  missing in the report: {expected}")?;
            for pair in pairs.iter().filter(|pair| expected.is_about(pair)) {
                writeln!(failures, "    but there is: {pair}")?;
            }
        }
    }

    if failures.is_empty() { Ok(()) } else { Err(format!("{}\n{failures}", path.display()).into()) }
}
