//! How fast the linter is, as ratios: against the least that reading and parsing can cost, and against other tools.
//!
//! `cargo bench -p cargo-ceid-lint --bench speed` makes corpora of the sources in cargo's registry, runs everything in turn,
//! and prints medians and ranges of the ratios, for only ratios of one run can be compared. Ratios of processor time hold on a
//! machine that has other work; ratios of wall time want a quiet one. `-- --rounds 7` runs longer, `-- --lines 20000` takes one
//! corpus of about that size, `-- --compiled` only the workspace that compiles, `-- --edits 10000` gives the language server more
//! to do, and `-- --install-peers` installs those tools that are missing below the target directory.

#![expect(clippy::print_stdout, reason = "a benchmark shows its results")]

mod compiled;
mod corpus;
mod editor;
mod floor;
mod peers;
mod runs;
mod table;

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use corpus::Corpus;
use runs::Row;
use table::Figures;

const LINTER: &str = env!("CARGO_BIN_EXE_cargo-ceid-lint");

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
    let number = |args: &mut Vec<String>, flag| take(args, flag).and_then(|text| text.parse::<usize>().ok());
    let rounds = number(&mut args, "--rounds").unwrap_or(5);
    let edits = number(&mut args, "--edits").unwrap_or(200);
    let lines = number(&mut args, "--lines");
    let is_compiled = args.iter().any(|arg| arg == "--compiled");
    let sizes = match lines {
        Some(lines) => vec![lines],
        None if is_compiled => Vec::new(),
        None => vec![100_000, 500_000, 2_000_000],
    };
    let install = args.iter().any(|arg| arg == "--install-peers");
    let home = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("speed");
    println!("{} cores, {rounds} rounds; wall and processor seconds: median [least-most]", cores());
    let mut measured: Vec<(Corpus, Figures)> = Vec::new();
    for lines in sizes {
        let corpus = corpus::build(&home.join(lines.to_string()), lines);
        let mut rows = rows(&corpus);
        rows.extend(peers::rows(&corpus.root, &home, install));
        let figures = measure(&corpus, rows, rounds);
        table::ratios(&figures, lines >= 2_000_000);
        peaks(&corpus, &figures);
        edited(&corpus, edits);
        measured.push((corpus, figures));
    }
    if lines.is_none() {
        match compiled::build(&home.join("compiled")) {
            Ok(corpus) => {
                let mut rows = rows(&corpus);
                rows.extend(peers::rows(&corpus.root, &home, install));
                rows.extend(compiled::rows(&corpus));
                table::ratios(&measure(&corpus, rows, rounds), false);
            }
            Err(reason) => println!("\nthere is no workspace that compiles: {reason}"),
        }
    }
    if let [(small, first), .., (large, last)] = &measured[..] {
        table::growth(small, first, large, last);
    }
    ExitCode::SUCCESS
}

/// The linter, and the least that there is to do.
fn rows(corpus: &Corpus) -> Vec<Row> {
    let own = std::env::current_exe().expect("a program knows where it lies");
    let (own, manifest) = (own.display(), corpus.root.join("Cargo.toml"));
    let (root, manifest) = (corpus.root.display(), manifest.display());
    let mut rows = vec![
        Row::new("default", format!("{LINTER} check --workspace --manifest-path {manifest}")),
        Row::new("full", format!("{LINTER} check --workspace --no-gate --manifest-path {manifest}")),
        Row::new("parse floor", format!("{own} --floor-parse {root}")),
        Row::new("gate floor", format!("{own} --floor-gate {root}")),
        Row::new("cargo metadata", format!("cargo metadata --no-deps --format-version 1 --manifest-path {manifest}")),
    ];
    if cores() > 1 && peers::answers("taskset --version") {
        let command = format!("taskset -c 0 {LINTER} check --workspace --no-gate --manifest-path {manifest}");
        rows.push(Row::new("full, one core", command));
    }
    rows
}

fn measure(corpus: &Corpus, rows: Vec<Row>, rounds: usize) -> Figures {
    let Corpus { lines, files, packages, .. } = corpus;
    println!("\n{lines} lines in {files} files of {packages} packages");
    let runs = runs::in_turn(&rows, rounds);
    let figures = Figures { rows, runs };
    figures.print();
    figures
}

fn peaks(corpus: &Corpus, figures: &Figures) {
    println!("\n| peak memory, {} lines | MiB | target |\n| --- | --- | --- |", corpus.lines);
    for (name, target) in [("default", "40 at 2 M lines"), ("full", "64 at 2 M lines"), ("parse floor", "-")] {
        let row = figures.rows.iter().find(|row| row.name == name);
        let peaks: Vec<f64> = row.map(|row| (0..3).filter_map(|_| runs::peak(row)).collect()).unwrap_or_default();
        println!("| {name} | {} | {target} |", runs::spread(&peaks, 1));
    }
}

fn edited(corpus: &Corpus, edits: usize) {
    let Some(session) = editor::session(LINTER, Path::new(&corpus.root), edits) else {
        println!("\nthe language server could not be measured");
        return;
    };
    let milliseconds = |seconds: f64| format!("{:.1}", seconds * 1_000.0);
    let (median, late) = (runs::median(&session.latencies), runs::percentile(&session.latencies, 0.99));
    println!("\n| language server, {} lines, {edits} edits | measured | target |\n| --- | --- | --- |", corpus.lines);
    println!("| processor for an edit, ms, mean | {} | 2 |", milliseconds(session.cpu));
    println!("| edit to findings but for the pause, ms, median | {} | 2 |", milliseconds(median));
    println!("| the same, 99th percentile | {} | 15 |", milliseconds(late));
    println!("| growth after a tenth of the edits, MiB | {:.1} | 10 over 10,000 |", session.growth);
}

fn cores() -> usize {
    std::thread::available_parallelism().map_or(1, usize::from)
}
