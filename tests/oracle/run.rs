//! Compiles a batch of programs once, runs it over all inputs, and asks the linter about the same text.

use std::fmt::Write as _;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::process::Command;

use serde_json::Value;

use crate::program::Program;
use crate::support::program::report_file;
use crate::support::root;

/// The text that stands above the programs, and the crate root that runs them.
const PRELUDE: &str = include_str!("template/prelude.rs");
const RUNTIME: &str = include_str!("template/runtime.rs");

/// How many filters the runtime counts for a program.
const FILTERS: usize = 8;

/// What was counted for one filter on the iterations of one loop. Bits: 1 not updated, 2 once, 4 more often, 8 not
/// updated but reset.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Seen {
    /// On iterations that reached the next one.
    pub(crate) completing: u8,
    /// On iterations that left the loop.
    pub(crate) exiting: u8,
}

/// A pair as the linter's report gives it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Pair {
    /// The line of the cycle's head.
    pub(crate) line: usize,
    /// `loop`, `while`, `for`, `closure` or `function`.
    pub(crate) kind: String,
    /// The instance as the source spells it.
    pub(crate) name: String,
    /// The verdict's word.
    pub(crate) verdict: String,
    /// The kind of gate.
    pub(crate) gate: Option<String>,
    /// The counts on completing paths, 2 for 'many'.
    pub(crate) counts: Vec<u64>,
    /// What could not be seen.
    pub(crate) cause: Option<String>,
    /// Whether the name is that of an element of a collection that a loop around the cycle takes one by one: the pair is about the
    /// round in which it is at hand.
    pub(crate) is_at_hand: bool,
}

/// Both sides of one program.
#[derive(Clone, Debug)]
pub(crate) struct Outcome {
    /// Whether all paths were taken, or only some of too many.
    pub(crate) is_complete: bool,
    /// By loop and filter.
    pub(crate) seen: Vec<[Seen; FILTERS]>,
    /// What the linter says; the lines are replaced by the number of the loop where there is one.
    pub(crate) pairs: Vec<(Option<usize>, Pair)>,
}

impl Outcome {
    /// Whether a loop had an iteration in any run.
    pub(crate) fn is_reached(&self, cycle: usize) -> bool {
        self.seen[cycle][0] != Seen::default()
    }
}

/// Runs a batch; `None` for a program that does not compile.
pub(crate) fn batch(directory: &Path, programs: &[Program]) -> Vec<Option<Outcome>> {
    if !directory.join("libceid_core.rlib").exists() {
        build_core(directory);
    }
    let mut accepted: Vec<usize> = (0..programs.len()).collect();
    loop {
        let batch = Batch::write(directory, programs, &accepted);
        let mut rejected = batch.compile();
        if rejected.is_empty() {
            let mut outcomes = batch.blank(programs);
            rejected.extend(batch.observe(&mut outcomes));
            if rejected.is_empty() {
                batch.ask(&mut outcomes);
                let mut all = vec![None; programs.len()];
                accepted.into_iter().zip(outcomes).for_each(|(index, outcome)| all[index] = Some(outcome));
                return all;
            }
        }
        accepted = accepted.into_iter().enumerate().filter(|(at, _)| !rejected.contains(at)).map(|(_, i)| i).collect();
    }
}

fn compiler() -> Command {
    Command::new(std::env::var_os("RUSTC").unwrap_or_else(|| "rustc".into()))
}

/// Builds the library with the guards, once for all batches.
fn build_core(directory: &Path) {
    std::fs::create_dir_all(directory).expect("the batch's directory can be made");
    let status = compiler()
        .current_dir(directory)
        .args(["--edition", "2024", "--crate-type", "rlib", "--crate-name", "ceid_core", "--cap-lints", "allow"])
        .arg(root().join("ceid-core/src/lib.rs"))
        .status()
        .expect("rustc starts");
    assert!(status.success(), "ceid-core does not compile on its own");
}

struct Batch {
    directory: PathBuf,
    /// The index of each program among those given.
    indices: Vec<usize>,
    /// The first line of each program, in order.
    starts: Vec<usize>,
    /// Line, position of the program, and number of each counted loop.
    loops: Vec<(usize, usize, usize)>,
    text: String,
}

impl Batch {
    fn write(directory: &Path, programs: &[Program], accepted: &[usize]) -> Self {
        let mut text = PRELUDE.to_owned();
        let mut line = text.lines().count();
        let mut table = "pub const ALL: &[(fn(&dyn super::programs::Io), usize, bool)] = &[\n".to_owned();
        let (mut starts, mut loops) = (Vec::new(), Vec::new());
        for (at, &index) in accepted.iter().enumerate() {
            let program = &programs[index];
            let printed = program.print(&format!("p{at}"), line);
            starts.push(line + 1);
            line += printed.text.lines().count();
            text.push_str(&printed.text);
            loops.extend(printed.loops.iter().map(|&(line, cycle)| (line, at, cycle)));
            writeln!(table, "(super::programs::p{at}::run, {}, {}),", program.loops, program.is_stateful)
                .expect("a String takes all text");
        }
        table.push_str("];\n");
        for (name, content) in [("programs.rs", text.as_str()), ("table.rs", &table), ("main.rs", RUNTIME)] {
            std::fs::write(directory.join(name), content).expect("the batch can be written");
        }
        Self { directory: directory.to_owned(), indices: accepted.to_vec(), starts, loops, text }
    }

    /// The positions of programs that the compiler refuses.
    fn compile(&self) -> Vec<usize> {
        let output = compiler()
            .current_dir(&self.directory)
            .args(["--edition", "2024", "--cap-lints", "allow", "-C", "debuginfo=0", "--error-format", "json"])
            .args(["--extern", "ceid_core=libceid_core.rlib", "-o", "batch", "main.rs"])
            .output()
            .expect("rustc starts");
        let messages = String::from_utf8_lossy(&output.stderr);
        let errors = messages.lines().filter_map(|line| serde_json::from_str::<Value>(line).ok());
        let errors: Vec<Value> = errors.filter(|message| message["level"] == "error").collect();
        let spans = errors.iter().flat_map(|error| error["spans"].as_array().into_iter().flatten());
        let rejected: Vec<usize> = spans.filter_map(|span| self.program_of(span)).collect();
        let first = errors.iter().find_map(|error| error["rendered"].as_str()).unwrap_or_default();
        assert!(output.status.success() || !rejected.is_empty(), "the batch does not compile:\n{first}");
        rejected
    }

    fn program_of(&self, span: &Value) -> Option<usize> {
        let line = span["line_start"].as_u64()? as usize;
        match span["file_name"].as_str()? {
            "programs.rs" => self.program_at(line),
            "table.rs" => line.checked_sub(2).filter(|&at| at < self.indices.len()),
            _ => None,
        }
    }

    fn program_at(&self, line: usize) -> Option<usize> {
        self.starts.partition_point(|&start| start <= line).checked_sub(1)
    }

    /// Runs the programs; the position of one that does not end.
    fn observe(&self, outcomes: &mut [Outcome]) -> Option<usize> {
        let output = Command::new(self.directory.join("batch")).output().expect("the batch starts");
        let text = String::from_utf8_lossy(&output.stdout);
        assert!(output.status.success(), "the batch failed:\n{}", String::from_utf8_lossy(&output.stderr));
        let mut current = 0;
        for line in text.lines() {
            let words: Vec<&str> = line.split(' ').collect();
            let number = |at: usize| words[at].parse::<usize>().expect("the runtime prints numbers");
            match words[0] {
                "endless" => return Some(number(1)),
                "program" => {
                    current = number(1);
                    outcomes[current].is_complete = words[2] == "complete";
                }
                _ => {
                    let seen = Seen { completing: number(3) as u8, exiting: number(4) as u8 };
                    outcomes[current].seen[number(1)][number(2)] = seen;
                }
            }
        }
        None
    }

    fn blank(&self, programs: &[Program]) -> Vec<Outcome> {
        let blank = |&index: &usize| Outcome {
            is_complete: true,
            seen: vec![[Seen::default(); FILTERS]; programs[index].loops],
            pairs: Vec::new(),
        };
        self.indices.iter().map(blank).collect()
    }

    /// Adds what the linter says.
    fn ask(&self, outcomes: &mut [Outcome]) {
        let text = report_file(&self.directory.join("programs.rs"));
        let report: Value = serde_json::from_str(&text.stdout)
            .unwrap_or_else(|error| panic!("no report ({error}) of {}:\n{}", self.directory.display(), text.stderr));
        for cycle in report["cycles"].as_array().into_iter().flatten() {
            let line = cycle["line"].as_u64().unwrap_or_default() as usize;
            let Some(at) = self.program_at(line) else { continue };
            let number = self.loops.iter().find(|&&(own, ..)| own == line).map(|&(_, _, number)| number);
            for filter in cycle["filters"].as_array().into_iter().flatten() {
                let mut pair = pair(line - self.starts[at] + 1, cycle, filter);
                pair.is_at_hand = self.is_at_hand(self.starts[at]..line, &pair.name);
                outcomes[at].pairs.push((number, pair));
            }
        }
    }

    /// Whether a `for` over a collection stands around the last of some lines, whose elements or what they refer to have the name:
    /// `for f in &mut self.fs {` for `self.fs[*]` and `self.fs[0]`, `for f in v {` behind `v.push(&mut self.a);` for `self.a`, and
    /// behind `let v: Vec<_> = self.fs.iter_mut().collect();` for `self.fs[0]`.
    fn is_at_hand(&self, range: Range<usize>, name: &str) -> bool {
        let indent = |line: &str| line.len() - line.trim_start().len();
        let before: Vec<&str> = self.text.lines().take(range.end).skip(range.start).collect();
        let has_word =
            |line: &str, word: &str| line.split(|char: char| !char.is_ascii_alphanumeric()).any(|w| w == word);
        let all = name.rsplit_once('[').map(|(collection, _)| format!("{collection}.iter_mut()"));
        let is_named = |line: &str| line.contains(name) || all.as_ref().is_some_and(|all| line.contains(all));
        let is_gathered = |row: &str| before.iter().any(|line| has_word(line, row) && is_named(line));
        let is_over = |head: &str| match name.rsplit_once('[') {
            Some((collection, _)) if head.contains(collection) => true,
            _ => {
                let row: String = head.chars().take_while(char::is_ascii_alphanumeric).collect();
                row.starts_with('v') && is_gathered(&row)
            }
        };
        let mut lines = before.iter().rev();
        let mut inner = lines.next().map_or(0, |line| indent(line));
        lines.any(|line| {
            let is_around = indent(line) < inner;
            inner = inner.min(indent(line));
            is_around && line.contains("for ") && line.split_once(" in ").is_some_and(|(_, head)| is_over(head))
        })
    }
}

fn pair(line: usize, cycle: &Value, filter: &Value) -> Pair {
    let text = |value: &Value| value.as_str().map(str::to_owned);
    Pair {
        line,
        kind: text(&cycle["kind"]).unwrap_or_default(),
        name: text(&filter["name"]).unwrap_or_default(),
        verdict: text(&filter["verdict"]).unwrap_or_default(),
        gate: text(&filter["gate"]),
        counts: filter["counts"].as_array().into_iter().flatten().filter_map(Value::as_u64).collect(),
        cause: text(&filter["cause"]),
        is_at_hand: false,
    }
}
