//! The ratios that have a target, with it.

use super::corpus::Corpus;
use super::runs::{self, Row, Run};

/// What was measured on one corpus.
pub(crate) struct Figures {
    pub(crate) rows: Vec<Row>,
    pub(crate) runs: Vec<Vec<Run>>,
}

impl Figures {
    fn of(&self, name: &str) -> Option<&[Run]> {
        self.rows.iter().position(|row| row.name == name).map(|at| self.runs[at].as_slice())
    }

    pub(crate) fn print(&self) {
        runs::print(&self.rows, &self.runs);
    }

    /// The ratio of each round: what the first costs against what all others cost together.
    fn ratios(&self, above: &str, below: &[&str], value: fn(&Run) -> f64) -> Option<Vec<f64>> {
        let above = self.of(above)?;
        let below: Vec<&[Run]> = below.iter().map(|name| self.of(name)).collect::<Option<_>>()?;
        let sum = |round: usize| below.iter().map(|runs| value(&runs[round])).sum::<f64>().max(0.001);
        Some((0..above.len()).map(|round| value(&above[round]) / sum(round)).collect())
    }
}

/// Prints each ratio whose rows were run, and whether it holds.
pub(crate) fn ratios(figures: &Figures, is_large: bool) {
    let cpu: fn(&Run) -> f64 = |run| run.cpu;
    let wall: fn(&Run) -> f64 = |run| run.wall;
    let floor: &[&str] = &["gate floor", "cargo metadata"];
    println!("\n| ratio | measured | target | |\n| --- | --- | --- | --- |");
    let show = |what: &str, above: &str, below: &[&str], value, target: Option<f64>| {
        if let Some(ratios) = figures.ratios(above, below, value) {
            line(what, &ratios, target);
        }
    };
    show("full, processor / parse floor", "full", &["parse floor"], cpu, Some(1.15));
    show("default, wall / (gate floor + cargo metadata)", "default", floor, wall, Some(1.5));
    show("the same, processor", "default", floor, cpu, None);
    show("default, wall / ast-grep", "default", &["ast-grep"], wall, Some(if is_large { 0.06 } else { 0.2 }));
    show("the same, processor", "default", &["ast-grep"], cpu, None);
    show("default, wall / semgrep", "default", &["semgrep"], wall, is_large.then_some(0.01));
    show("default, wall / cargo check", "default", &["cargo check"], wall, Some(0.02));
    show("the same, processor", "default", &["cargo check"], cpu, None);
    show("default, wall / clippy", "default", &["clippy"], wall, Some(0.01));
    show("the same, processor", "default", &["clippy"], cpu, None);
    show("full, processor / ast-grep", "full", &["ast-grep"], cpu, Some(0.6));
    if let Some(ratios) = figures.ratios("full, one core", &["full"], wall) {
        let holds = if runs::median(&ratios) >= 1.85 { "held" } else { "missed" };
        println!("| full on one core, wall / on two | {} | at least 1.85 | {holds} |", runs::spread(&ratios, 2));
    }
}

fn line(what: &str, ratios: &[f64], target: Option<f64>) {
    let median = runs::median(ratios);
    let (target, holds) = match target {
        Some(target) if median <= target => (target.to_string(), "held".to_owned()),
        Some(target) => (target.to_string(), format!("missed by {:.2} times", median / target)),
        None => ("-".to_owned(), String::new()),
    };
    println!("| {what} | {} | {target} | {holds} |", runs::spread(ratios, 3));
}

/// How the processor time grows with the bytes, as an exponent.
pub(crate) fn growth(small: &Corpus, first: &Figures, large: &Corpus, last: &Figures) {
    let bytes = (large.bytes as f64 / small.bytes as f64).ln();
    println!("\n| growth of the processor time with the bytes | exponent | target | |\n| --- | --- | --- | --- |");
    for (name, target) in [("full", 1.05), ("default", 1.0), ("parse floor", 1.05)] {
        let median = |figures: &Figures| {
            let runs = figures.of(name)?;
            Some(runs::median(&runs.iter().map(|run| run.cpu).collect::<Vec<f64>>()))
        };
        if let (Some(early), Some(late)) = (median(first), median(last)) {
            line(name, &[(late / early).ln() / bytes], Some(target));
        }
    }
}
