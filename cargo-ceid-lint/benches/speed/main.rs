//! How fast the linter is, as ratios: against the least that reading and parsing can cost, and against other tools.
//!
//! `cargo bench -p cargo-ceid-lint --bench speed` makes corpora of the sources in cargo's registry, runs everything in turn,
//! and prints medians and ranges of the ratios, for only ratios of one run can be compared. `-- --rounds 7` runs longer,
//! `-- --lines 20000` takes one corpus of about that size, and `-- --install-peers` installs those tools that are missing below the
//! target directory.

#![expect(clippy::print_stdout, reason = "a benchmark shows its results")]

mod corpus;
mod floor;
mod peers;
mod runs;

use std::path::PathBuf;
use std::process::ExitCode;

use runs::{Row, Run};

fn main() -> ExitCode {
    let mut args: Vec<String> = std::env::args().skip(1).filter(|arg| arg != "--bench").collect();
    let take = |args: &mut Vec<String>, flag: &str| {
        let at = args.iter().position(|arg| arg == flag)?;
        args.remove(at);
        Some(if at < args.len() { args.remove(at) } else { String::new() })
    };
    if let Some(directory) = take(&mut args, "--floor-parse") {
        floor::parse(&PathBuf::from(directory));
        return ExitCode::SUCCESS;
    }
    if let Some(directory) = take(&mut args, "--floor-gate") {
        floor::gate(&PathBuf::from(directory));
        return ExitCode::SUCCESS;
    }
    let rounds = take(&mut args, "--rounds").and_then(|rounds| rounds.parse().ok()).unwrap_or(5);
    let lines: Option<usize> = take(&mut args, "--lines").and_then(|lines| lines.parse().ok());
    let sizes = lines.map_or_else(|| vec![100_000, 2_000_000], |lines| vec![lines]);
    let install = args.iter().any(|arg| arg == "--install-peers");
    let home = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("speed");
    let own = std::env::current_exe().expect("a program knows where it lies");
    println!("{} cores, {rounds} rounds; wall and processor seconds: median [least-most]", cores());
    for lines in sizes {
        let name = lines.to_string();
        let corpus = corpus::build(&home.join(&name), lines);
        println!("\n{name}: {} lines in {} files of {} packages", corpus.lines, corpus.files, corpus.packages);
        let (root, linter) = (corpus.root.display(), env!("CARGO_BIN_EXE_cargo-ceid-lint"));
        let mut rows = vec![
            Row::new("default", format!("{linter} check --workspace --manifest-path {root}/Cargo.toml")),
            Row::new("full", format!("{linter} check --workspace --no-gate --manifest-path {root}/Cargo.toml")),
            Row::new("parse floor", format!("{} --floor-parse {root}", own.display())),
            Row::new("gate floor", format!("{} --floor-gate {root}", own.display())),
            Row::new(
                "cargo metadata",
                format!("cargo metadata --no-deps --format-version 1 --manifest-path {root}/Cargo.toml"),
            ),
        ];
        rows.extend(peers::rows(&corpus.root, &home, install));
        let runs = runs::in_turn(&rows, rounds);
        runs::print(&rows, &runs);
        ratios(&rows, &runs);
    }
    ExitCode::SUCCESS
}

/// The ratios that have a target, with it.
fn ratios(rows: &[Row], runs: &[Vec<Run>]) {
    let of = |name: &str| rows.iter().position(|row| row.name == name).map(|at| runs[at].as_slice());
    let cpu = |run: &Run| run.cpu;
    let wall = |run: &Run| run.wall;
    println!("\n| ratio | measured | target |\n| --- | --- | --- |");
    let show = |what: &str, above: &str, below: &[&str], value: &dyn Fn(&Run) -> f64, target: &str| {
        let Some(above) = of(above) else { return };
        let Some(below) = below.iter().map(|name| of(name)).collect::<Option<Vec<_>>>() else { return };
        let ratios: Vec<f64> = (0..above.len())
            .map(|round| value(&above[round]) / below.iter().map(|runs| value(&runs[round])).sum::<f64>().max(0.001))
            .collect();
        println!("| {what} | {} | {target} |", runs::spread(&ratios, 3));
    };
    show("full, processor / parse floor", "full", &["parse floor"], &cpu, "1.15");
    show("default, wall / (gate floor + cargo metadata)", "default", &["gate floor", "cargo metadata"], &wall, "1.5");
    show("default, processor / parse floor", "default", &["parse floor"], &cpu, "-");
    show("default, wall / ast-grep", "default", &["ast-grep"], &wall, "0.06 at 2 M lines");
    show("default, wall / semgrep", "default", &["semgrep"], &wall, "0.01 at 2 M lines");
    show("full, processor / ast-grep", "full", &["ast-grep"], &cpu, "0.6");
}

fn cores() -> usize {
    std::thread::available_parallelism().map_or(1, usize::from)
}
