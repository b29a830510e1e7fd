//! Commands that are run in turn, and what they cost.

use std::process::Command;
use std::time::Duration;

/// A command with its name in the table.
pub(crate) struct Row {
    pub(crate) name: &'static str,
    command: String,
}

impl Row {
    pub(crate) fn new(name: &'static str, command: String) -> Self {
        Self { name, command }
    }
}

/// What one run cost, in seconds.
pub(crate) struct Run {
    pub(crate) wall: f64,
    pub(crate) cpu: f64,
}

/// Runs all commands in turn, so often and once before; the runs of each.
pub(crate) fn in_turn(rows: &[Row], rounds: usize) -> Vec<Vec<Run>> {
    let mut runs: Vec<Vec<Run>> = rows.iter().map(|_| Vec::new()).collect();
    for round in 0..=rounds {
        for (row, runs) in rows.iter().zip(&mut runs) {
            let run = run(&row.command);
            if round > 0 {
                runs.push(run);
            }
        }
    }
    runs
}

/// The shell measures a process with its children.
fn run(command: &str) -> Run {
    let script = format!("TIMEFORMAT='%3R %3U %3S'; time {{ {command} >/dev/null 2>&1; }}");
    let output = Command::new("bash").args(["-c", &script]).output().expect("bash can be run");
    let text = String::from_utf8_lossy(&output.stderr).into_owned();
    let last = text.trim().lines().last().unwrap_or_default();
    let numbers: Vec<f64> = last.split(' ').filter_map(|number| number.parse().ok()).collect();
    let [wall, user, system] = numbers[..] else { panic!("the shell does not tell the time: {text}") };
    Run { wall, cpu: user + system }
}

/// The most MiB that a command has in memory at once, without what it starts; looked at every few milliseconds.
pub(crate) fn peak(row: &Row) -> Option<f64> {
    let mut shell = Command::new("bash");
    shell.args(["-c", &format!("exec {} >/dev/null 2>&1", row.command)]);
    let mut child = shell.spawn().ok()?;
    let mut peak = None;
    while child.try_wait().ok()?.is_none() {
        peak = memory(child.id(), "VmHWM:").or(peak);
        std::thread::sleep(Duration::from_millis(2));
    }
    peak
}

/// What the kernel says of the memory of a process, in MiB.
pub(crate) fn memory(process: u32, field: &str) -> Option<f64> {
    let text = std::fs::read_to_string(format!("/proc/{process}/status")).ok()?;
    let kilobytes = text.lines().find_map(|line| line.strip_prefix(field))?;
    Some(kilobytes.trim().strip_suffix("kB")?.trim().parse::<f64>().ok()? / 1024.0)
}

/// The middle one.
pub(crate) fn median(values: &[f64]) -> f64 {
    percentile(values, 0.5)
}

/// The one that so large a part is not above.
pub(crate) fn percentile(values: &[f64], part: f64) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let at = ((sorted.len() as f64 * part) as usize).min(sorted.len().saturating_sub(1));
    sorted.get(at).copied().unwrap_or(f64::NAN)
}

pub(crate) fn print(rows: &[Row], runs: &[Vec<Run>]) {
    println!("\n| command | wall | processor |\n| --- | --- | --- |");
    for (row, runs) in rows.iter().zip(runs) {
        let wall: Vec<f64> = runs.iter().map(|run| run.wall).collect();
        let cpu: Vec<f64> = runs.iter().map(|run| run.cpu).collect();
        println!("| {} | {} | {} |", row.name, spread(&wall, 3), spread(&cpu, 3));
    }
}

/// The median with the range: `1.02 [0.98-1.10]`.
pub(crate) fn spread(values: &[f64], digits: usize) -> String {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    match (sorted.first(), sorted.get(sorted.len() / 2), sorted.last()) {
        (Some(least), Some(median), Some(most)) => format!("{median:.digits$} [{least:.digits$}-{most:.digits$}]"),
        _ => "-".to_owned(),
    }
}
