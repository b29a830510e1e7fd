//! The programs that compile, count and disassemble, and what to do when one is missing.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// A program that the benchmark calls, and the package of Debian and Ubuntu that has it.
pub(crate) struct Tool {
    pub(crate) program: &'static str,
    package: &'static str,
}

pub(crate) const VALGRIND: Tool = Tool { program: "valgrind", package: "valgrind" };
pub(crate) const OBJDUMP: Tool = Tool { program: "objdump", package: "binutils" };
pub(crate) const CPP: Tool = Tool { program: "g++", package: "g++" };

impl Tool {
    pub(crate) fn is_missing(&self) -> bool {
        Command::new(self.program).arg("--version").output().is_err()
    }

    pub(crate) fn how_to_install(&self) -> String {
        format!("{} is missing: sudo apt-get install -y {}", self.program, self.package)
    }

    /// The first line of what it says about its version.
    pub(crate) fn version(&self) -> String {
        version(self.program)
    }
}

fn rustc_program() -> String {
    std::env::var("RUSTC").unwrap_or_else(|_| "rustc".to_owned())
}

pub(crate) fn rustc_version() -> String {
    version(&rustc_program())
}

fn version(program: &str) -> String {
    let output = run(Command::new(program).arg("--version")).unwrap_or_default();
    output.lines().next().unwrap_or_default().to_owned()
}

/// Runs a program to its end, and returns what it wrote to both outputs.
fn run(command: &mut Command) -> Result<String, String> {
    let output = command.output().map_err(|error| format!("{command:?}: {error}"))?;
    let text = String::from_utf8_lossy(&[output.stdout, output.stderr].concat()).into_owned();
    if output.status.success() { Ok(text) } else { Err(format!("{command:?}\n{text}")) }
}

/// Compiles the library for one panic strategy; it has no dependencies, so that one call is enough.
pub(crate) fn library(folder: &Path, panic: &str) -> Result<PathBuf, String> {
    let library = folder.join(format!("libceid_core-{panic}.rlib"));
    run(Command::new(rustc_program())
        .args(["--edition=2024", "--crate-type=lib", "--crate-name=ceid_core", "-Copt-level=3"])
        .arg(format!("-Cpanic={panic}"))
        .arg("-o")
        .args([&library, &Path::new(env!("CARGO_MANIFEST_DIR")).join("src/lib.rs")]))?;
    Ok(library)
}

pub(crate) fn rust(folder: &Path, name: &str, source: &str, library: &Path, panic: &str) -> Result<PathBuf, String> {
    let (file, program) = (folder.join(format!("{name}.rs")), folder.join(name));
    fs::write(&file, source).map_err(|error| error.to_string())?;
    run(Command::new(rustc_program())
        .args(["--edition=2024", "--crate-name=measured", "-Copt-level=3", "-Ccodegen-units=1"])
        .args([format!("-Cpanic={panic}"), format!("--extern=ceid_core={}", library.display()), "-o".to_owned()])
        .args([&program, &file]))?;
    Ok(program)
}

pub(crate) fn cpp(folder: &Path, name: &str, source: &str, options: &[&str]) -> Result<PathBuf, String> {
    let (file, program) = (folder.join(format!("{name}.cpp")), folder.join(name));
    fs::write(&file, source).map_err(|error| error.to_string())?;
    let headers = Path::new(env!("CARGO_MANIFEST_DIR")).join("benches/guard");
    run(Command::new(CPP.program).args(options).arg("-I").arg(headers).arg("-o").args([&program, &file]))?;
    Ok(program)
}

/// What the program computes: two programs that do the same say the same.
pub(crate) fn result(program: &Path) -> Result<String, String> {
    run(Command::new(program).arg("1000"))
}

/// Instructions per cycle: the difference of two runs, so that start and end do not count.
pub(crate) fn instructions_per_cycle(program: &Path) -> Result<f64, String> {
    const CYCLES: u64 = 1_000;
    let count = |cycles: u64| -> Result<f64, String> {
        let text = run(Command::new(VALGRIND.program)
            .args(["--tool=callgrind", "--callgrind-out-file=/dev/null"])
            .arg(program)
            .arg(cycles.to_string()))?;
        let collected = text.split("Collected :").nth(1).and_then(|rest| rest.split_whitespace().next());
        collected.and_then(|count| count.parse().ok()).ok_or(format!("no count in\n{text}"))
    };
    Ok((count(2 * CYCLES)? - count(CYCLES)?) / CYCLES as f64)
}

/// The instructions of `control_loop`, without addresses: two loops that are the same give the same text.
pub(crate) fn assembly(program: &Path) -> Result<String, String> {
    let text = run(Command::new(OBJDUMP.program)
        .args(["--disassemble=control_loop", "--no-show-raw-insn", "--no-addresses"])
        .arg(program))?;
    let lines: Vec<_> = text
        .lines()
        .filter(|line| line.starts_with('\t'))
        .map(|line| match line.split_once("(%rip)") {
            // Where a constant lies is the linker's affair.
            Some((before, _)) => before.rsplit_once(' ').map_or(before, |(instruction, _)| instruction).to_owned(),
            None => line.to_owned(),
        })
        .collect();
    if lines.is_empty() { Err(format!("no `control_loop` in {}", program.display())) } else { Ok(lines.join("\n")) }
}
