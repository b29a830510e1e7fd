//! Runs the program on every case under `fixtures/rules` and compares what it finds with the markers in the case.

#[path = "support/mod.rs"]
mod support;

use std::fmt::{self, Write as _};
use std::path::Path;

use support::batch::judged;
use support::case::{Case, difference};

datatest_stable::harness! {
    { test = case_holds, root = "../fixtures/rules", pattern = r"\.rs$" },
}

fn case_holds(path: &Path) -> datatest_stable::Result<()> {
    let path = path.canonicalize()?;
    match compare(&path) {
        Ok(failures) if failures.is_empty() => Ok(()),
        Ok(failures) | Err(failures) => Err(Failure(format!("{}\n{failures}", path.display())).into()),
    }
}

/// What is missing and what is too much, one line each.
fn compare(path: &Path) -> Result<String, String> {
    let text = std::fs::read_to_string(path).map_err(|error| error.to_string())?;
    let case = Case::parse(&text)?;
    let judged = judged(path)?;
    let mut failures = difference(&case, &judged.findings);
    let pairs = judged.pairs;
    for expected in case.reports.iter().filter(|expected| !pairs.iter().any(|pair| expected.matches(pair))) {
        let nearest = pairs.iter().filter(|pair| expected.is_about(pair)).map(|pair| format!("    there is: {pair}\n"));
        let nearest: String = nearest.collect();
        write!(failures, "  missing in the report: {expected}\n{nearest}").expect("a String takes all text");
    }
    Ok(failures)
}

/// An error whose debug form, which the harness prints, keeps its line breaks.
struct Failure(String);

impl fmt::Debug for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl std::error::Error for Failure {}
