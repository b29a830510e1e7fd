//! The executable oracle: random control loops are compiled, run over all their inputs and counted, and what really
//! happened is held against what the linter says.
//!
//! `cargo test --test oracle` runs the programs of `fixtures/oracle` and a small fixed batch. Any number with any seed,
//! with every disagreement shrunk to a small program:
//!
//! ```text
//! cargo test -p cargo-ceid-lint --test oracle -- --programs 100000 --seed 7
//! ```
//!
//! A shrunk program is printed in the form of `fixtures/oracle`, so that it can be kept as a file there. `--show INDEX`
//! prints a program of the seed, `--first INDEX` begins with it, `--kept N` shrinks more of a kind than three, `--no-shrink` none.

#![expect(clippy::print_stdout, reason = "the figures and the disagreements are what it is run for")]

#[path = "../support/mod.rs"]
mod support;

mod compare;
mod generate;
mod program;
mod rng;
mod run;
mod shrink;

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use compare::{Disagreement, Figures, compare};
use program::{Program, size};
use support::root;

/// Programs of one compilation.
const BATCH: u64 = 250;
/// How many smaller programs are tried at once for one disagreement.
const CANDIDATES: usize = 16;

fn main() -> ExitCode {
    let Some(options) = Options::read() else {
        println!("usage: oracle [--programs N] [--seed N] [--first INDEX] [--show INDEX] [--kept N] [--no-shrink]");
        return ExitCode::SUCCESS;
    };
    if let Some(index) = options.shown {
        print!("{}", generate::program(options.seed, index).fixture());
        return ExitCode::SUCCESS;
    }
    let mut figures = Figures::default();
    let kept = kept_programs();
    let mut open = judged(&options.directory, &kept, &mut figures);
    assert_eq!(figures.programs, kept.len(), "a program of fixtures/oracle does not compile");
    let are_kept_good = open.is_empty();
    let last = options.first.saturating_add(options.programs);
    for first in (options.first..last).step_by(BATCH as usize) {
        let indices = first..(first + BATCH).min(last);
        let programs: Vec<Program> = indices.map(|index| generate::program(options.seed, index)).collect();
        for case in judged(&options.directory, &programs, &mut figures) {
            if open.iter().filter(|other| other.found.is_like(&case.found)).count() < options.kept {
                // A long run that is stopped has told where it can go on.
                println!("{:?} from program {first} on: {}", case.found.kind, case.found.text);
                open.push(case);
            }
        }
        if options.programs > BATCH {
            println!("{}", figures.short());
        }
    }
    if options.shrinks {
        shrink_all(&options.directory, &mut open);
    }
    for Case { program, found } in &open {
        println!("--- {:?}: {}\n{}", found.kind, found.text, program.fixture());
    }
    println!("{figures}");
    std::fs::remove_dir_all(&options.directory).expect("the batch's directory is ours");
    if are_kept_good && figures.are_good() { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

struct Options {
    programs: u64,
    first: u64,
    seed: u64,
    shown: Option<u64>,
    shrinks: bool,
    /// How many disagreements of one kind and verdict are kept.
    kept: usize,
    directory: PathBuf,
}

impl Options {
    fn read() -> Option<Self> {
        let directory = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("oracle-{}", std::process::id()));
        let mut options = Self { programs: 60, first: 0, seed: 1, shown: None, shrinks: true, kept: 3, directory };
        let mut arguments = std::env::args().skip(1);
        while let Some(argument) = arguments.next() {
            let mut number = || arguments.next()?.parse::<u64>().ok();
            match argument.as_str() {
                "--programs" => options.programs = number()?,
                "--first" => options.first = number()?,
                "--seed" => options.seed = number()?,
                "--show" => options.shown = Some(number()?),
                "--kept" => options.kept = number()? as usize,
                "--no-shrink" => options.shrinks = false,
                _ => return None,
            }
        }
        Some(options)
    }
}

/// Programs that the linter once got wrong.
fn kept_programs() -> Vec<Program> {
    let directory = std::fs::read_dir(root().join("fixtures/oracle")).expect("the kept programs are there");
    let mut paths: Vec<PathBuf> = directory.map(|entry| entry.expect("the folder is readable").path()).collect();
    paths.sort();
    paths.iter().map(|path| Program::kept(&std::fs::read_to_string(path).expect("a program is UTF-8"))).collect()
}

/// A program with a disagreement.
#[derive(Clone, Debug)]
struct Case {
    program: Program,
    found: Disagreement,
}

fn judged(directory: &Path, programs: &[Program], figures: &mut Figures) -> Vec<Case> {
    let mut cases = Vec::new();
    for (program, outcome) in programs.iter().zip(run::batch(directory, programs)) {
        let Some(outcome) = outcome else { continue };
        let found = compare(program, &outcome, figures);
        cases.extend(found.into_iter().map(|found| Case { program: program.clone(), found }));
    }
    cases
}

/// Makes all cases smaller at once, until no step keeps any disagreement; the worst and smallest come first.
fn shrink_all(directory: &Path, cases: &mut Vec<Case>) {
    let mut offsets = vec![0; cases.len()];
    loop {
        let mut tried = Vec::new();
        for (at, case) in cases.iter().enumerate() {
            let candidates = shrink::candidates(&case.program);
            tried.extend(candidates.into_iter().skip(offsets[at]).take(CANDIDATES).map(|program| (at, program)));
        }
        if tried.is_empty() {
            break;
        }
        let programs: Vec<Program> = tried.iter().map(|(_, program)| program.clone()).collect();
        let mut is_smaller = vec![false; cases.len()];
        for ((at, program), outcome) in tried.into_iter().zip(run::batch(directory, &programs)) {
            let found = outcome.map(|outcome| compare(&program, &outcome, &mut Figures::default())).unwrap_or_default();
            let alike = found.into_iter().find(|found| found.is_like(&cases[at].found));
            if let (Some(found), false) = (alike, is_smaller[at]) {
                is_smaller[at] = true;
                cases[at] = Case { program, found };
            }
        }
        for (offset, is_smaller) in offsets.iter_mut().zip(is_smaller) {
            *offset = if is_smaller { 0 } else { *offset + CANDIDATES };
        }
    }
    cases.sort_by_key(|case| (case.found.kind, case.found.verdict.clone(), size(&case.program.items)));
    cases.dedup_by(|one, other| one.program.items == other.program.items);
}
