//! Every figure that the documentation promises, measured, with its bar, in one table:
//!
//! ```text
//! cargo bench -p ceid-core --bench bars
//! ```
//!
//! takes twenty minutes on Linux, and wants a machine with nothing else to do and the rights of real-time threads.
//! Runs the benchmarks `guard` and `bridge` and the check of AVR, shows all that they print, and repeats the lines that
//! have a bar. Fails if one is missed or could not be measured; each part says what to install if a tool is missing.

#![expect(clippy::print_stdout, reason = "a benchmark shows its results")]

use std::fs;
use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Command, ExitCode, Stdio};

mod row;

use row::{Bar, TITLES, line};

fn main() -> ExitCode {
    let mut table = Vec::new();
    let mut failures = Vec::new();
    for (name, command) in parts() {
        println!("\n=== {name}");
        match lines_with_a_bar(command) {
            Ok(lines) => table.extend(lines),
            Err(error) => failures.push(format!("{name}: {error}")),
        }
    }
    match dependencies() {
        Ok(line) => table.push(line),
        Err(error) => failures.push(format!("dependencies: {error}")),
    }
    println!("\n=== all bars\n\n{}\n\n{TITLES}\n{}", machine(), table.join("\n"));
    failures.extend(table.into_iter().filter(|line| line.ends_with(": MISSED |")));
    if failures.is_empty() {
        println!("\nAll bars are met.");
        return ExitCode::SUCCESS;
    }
    println!("\nNot met:\n{}", failures.join("\n"));
    ExitCode::FAILURE
}

fn parts() -> [(&'static str, Command); 3] {
    let part = |program: &str, arguments: &[&str]| {
        let mut command = Command::new(program);
        command.args(arguments).current_dir(env!("CARGO_MANIFEST_DIR"));
        command
    };
    let cargo = |arguments: &[&str]| part(env!("CARGO"), arguments);
    [
        ("guard", cargo(&["bench", "--quiet", "-p", "ceid-core", "--bench", "guard"])),
        ("AVR", part("bash", &["portability/check.sh", "avr"])),
        ("bridge", cargo(&["run", "--quiet", "--release", "--manifest-path", "benches/bridge/Cargo.toml"])),
    ]
}

/// Shows what a part prints, and returns its lines that have a bar. That one is missed is seen from the line.
fn lines_with_a_bar(mut command: Command) -> Result<Vec<String>, String> {
    let mut part = command.stdout(Stdio::piped()).spawn().map_err(|error| error.to_string())?;
    let output = part.stdout.take().ok_or("it has no output")?;
    let mut found = Vec::new();
    for line in BufReader::new(output).lines() {
        let line = line.map_err(|error| error.to_string())?;
        println!("{line}");
        if line.ends_with(": met |") || line.ends_with(": MISSED |") {
            found.push(line);
        }
    }
    part.wait().map_err(|error| error.to_string())?;
    if found.is_empty() { Err("it has measured nothing".to_owned()) } else { Ok(found) }
}

/// What every user of the library has to build beside it.
fn dependencies() -> Result<String, String> {
    let arguments = ["tree", "-p", "ceid-core", "--edges", "normal", "--prefix", "none"];
    let output = Command::new(env!("CARGO"))
        .args(arguments)
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .output()
        .map_err(|error| error.to_string())?;
    let crates = String::from_utf8_lossy(&output.stdout).lines().count().checked_sub(1).ok_or("no tree")?;
    Ok(line("mandatory dependencies", &format!("{crates} crates"), crates as f64, &Bar::AtMost(0.0)))
}

fn machine() -> String {
    let file = |path: &str| fs::read_to_string(Path::new(path)).unwrap_or_default();
    let processors = file("/proc/cpuinfo");
    let models: Vec<_> = processors.lines().filter_map(|line| line.strip_prefix("model name\t: ")).collect();
    let kernel = file("/proc/sys/kernel/osrelease");
    let rustc = Command::new(std::env::var_os("RUSTC").unwrap_or_else(|| "rustc".into())).arg("--version").output();
    let rustc = rustc.map(|output| String::from_utf8_lossy(&output.stdout).into_owned()).unwrap_or_default();
    format!(
        "{} processors ({}), {} {}, {}",
        models.len(),
        models.first().unwrap_or(&"unknown"),
        std::env::consts::OS,
        kernel.trim(),
        rustc.trim()
    )
}
