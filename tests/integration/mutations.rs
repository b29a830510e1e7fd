//! The whole pipeline on changed fixtures, through the functions that the fuzzer uses: no panic, no abort, no hang.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::sync::mpsc::channel;
use std::time::{Duration, Instant};

use crate::support::root;

#[path = "../../cargo-ceid-lint/fuzz/src/entry.rs"]
mod entry;
#[path = "../../cargo-ceid-lint/fuzz/src/mutate.rs"]
mod mutate;

/// How long one text may take, in a debug build on a busy machine.
const LIMIT: Duration = Duration::from_secs(120);

fn rust_files(directory: &Path, found: &mut Vec<PathBuf>) {
    let entries = std::fs::read_dir(directory).expect("the fixtures are readable");
    let mut paths: Vec<PathBuf> = entries.map(|entry| entry.expect("the fixtures are readable").path()).collect();
    paths.sort();
    for path in paths {
        if path.is_dir() {
            rust_files(&path, found);
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            found.push(path);
        }
    }
}

/// The fixtures; what is no UTF-8 is left to other tests.
fn texts() -> Vec<String> {
    let mut files = Vec::new();
    rust_files(&root().join("fixtures/rules"), &mut files);
    rust_files(&root().join("fixtures/oracle"), &mut files);
    files.iter().filter_map(|file| std::fs::read_to_string(file).ok()).collect()
}

/// Runs the pipeline on a text; gives what it panicked with.
fn check(text: &str) -> Result<(), String> {
    let (done, wait) = channel();
    let own = text.to_owned();
    std::thread::spawn(move || {
        let result = catch_unwind(AssertUnwindSafe(|| entry::check(&own)));
        let _ = done.send(result.map_err(|panic| match panic.downcast::<String>() {
            Ok(message) => *message,
            Err(panic) => panic.downcast::<&str>().map_or_else(|_| "no message".to_owned(), |text| (*text).to_owned()),
        }));
    });
    wait.recv_timeout(LIMIT).unwrap_or_else(|_| Err(format!("no end after {LIMIT:?}")))
}

/// Where texts are kept on which the pipeline failed.
fn keep(seed: u64, text: &str) -> PathBuf {
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("mutation-{seed}.rs"));
    std::fs::write(&path, text).expect("the target directory is writable");
    path
}

fn run(seeds: impl Iterator<Item = u64>, until: Instant) -> u64 {
    let texts = texts();
    let mut failures = Vec::new();
    let mut number = 0;
    for seed in seeds.take_while(|_| Instant::now() < until) {
        let pick = |seed: u64| &texts[usize::try_from(seed % texts.len() as u64).expect("it is an index")];
        let text = mutate::mutated(pick(seed), pick(seed.wrapping_mul(31) ^ (seed >> 7)), seed);
        // What ends the whole process leaves its text behind.
        let kept = keep(seed, &text);
        match check(&text) {
            Ok(()) => std::fs::remove_file(&kept).expect("it was just written"),
            Err(message) => failures.push(format!("{}: {message}", kept.display())),
        }
        number += 1;
    }
    assert!(failures.is_empty(), "{}", failures.join("\n"));
    number
}

#[test]
fn changed_fixtures_are_survived() {
    // A prime apart, so that the runs are spread over all fixtures.
    run((0..150).map(|at| at * 7_919), Instant::now() + Duration::from_secs(600));
}

/// `MUTATION_SECONDS=1200 cargo test -p cargo-ceid-lint --test integration -- --ignored --nocapture mutations::`
#[test]
#[ignore = "runs for as long as MUTATION_SECONDS says"]
fn many_changed_fixtures_are_survived() {
    let number = |name: &str, default: u64| std::env::var(name).ok().and_then(|it| it.parse().ok()).unwrap_or(default);
    let seconds = number("MUTATION_SECONDS", 60);
    let first = number("MUTATION_SEED", 1_000_000);
    let runs = run(first.., Instant::now() + Duration::from_secs(seconds));
    println!("{runs} texts in {seconds} s");
}

/// Texts on which the pipeline once failed.
#[test]
fn earlier_failures_are_survived() {
    let mut files = Vec::new();
    rust_files(&root().join("fixtures/mutations"), &mut files);
    for file in files {
        let text = std::fs::read_to_string(&file).expect("the fixtures are readable");
        check(&text).unwrap_or_else(|message| panic!("{}: {message}", file.display()));
    }
}
