//! Instructions and assembly of guarded loops against calls written by hand, and the paper's C++ guard beside them.
//!
//! ```text
//! cargo bench -p ceid-core --bench guard            # sets of 1, 2, 4, 8, 16, 32 and 64 filters
//! cargo bench -p ceid-core --bench guard -- --all   # sets of 1 to 64
//! ```
//!
//! Counts are callgrind's, so that other load on the machine does not change them. Each side is a program of its own,
//! because identical functions of one program are merged. Fails if a bar is not met; says what to install if a tool is
//! missing.

#![expect(clippy::print_stdout, reason = "a benchmark shows its results")]

use std::fs;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

#[path = "../bars/row.rs"]
mod row;
mod source;
mod tools;

use row::{TITLES, line};
use source::{Body, Form};

/// At most so much more than by hand, under unwinding, where a guard needs a landing pad.
const UNWINDING_BAR: f64 = 1.03;

fn main() -> ExitCode {
    let missing: Vec<_> = [tools::VALGRIND, tools::OBJDUMP]
        .iter()
        .filter(|tool| tool.is_missing())
        .map(tools::Tool::how_to_install)
        .collect();
    if !missing.is_empty() {
        println!("{}", missing.join("\n"));
        return ExitCode::FAILURE;
    }
    let sizes: Vec<usize> = match std::env::args().any(|argument| argument == "--all") {
        true => (1..=64).collect(),
        false => vec![1, 2, 4, 8, 16, 32, 64],
    };
    match compare(&sizes) {
        Ok(failures) if failures.is_empty() => {
            println!("\nAll bars are met.");
            ExitCode::SUCCESS
        }
        Ok(failures) => {
            println!("\nNot met:\n{}", failures.join("\n"));
            ExitCode::FAILURE
        }
        Err(error) => {
            println!("{error}");
            ExitCode::FAILURE
        }
    }
}

fn compare(sizes: &[usize]) -> Result<Vec<String>, String> {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("guard");
    fs::create_dir_all(&folder).map_err(|error| error.to_string())?;
    println!("Instructions per cycle (callgrind), {}, {}", std::env::consts::ARCH, tools::rustc_version());
    println!("\"same\": the assembly of the loop is the same as by hand\n");

    let mut failures = Vec::new();
    let mut summary = Vec::new();
    for (panic, body, title) in [
        ("abort", Body::Straight, "panic = \"abort\", a body with one end"),
        ("abort", Body::Early, "panic = \"abort\", a body with a `continue`"),
        ("abort", Body::Opaque, "panic = \"abort\", a body with a `continue` and an opaque call"),
        ("unwind", Body::Opaque, "panic = \"unwind\", a body with a `continue` and an opaque call"),
    ] {
        let library = tools::library(&folder, panic)?;
        println!("{title}");
        println!(
            "| filters | by hand | by hand, before each `continue` too | `each_cycle!` | `run` | `ceid!` to a last `continue` | `ceid!` |"
        );
        println!("| ---: | ---: | ---: | ---: | ---: | ---: | ---: |");
        let mut ratios = [Form::EachCycle, Form::Run, Form::ListToContinue, Form::List]
            .map(|form| Ratios { form, ..Ratios::default() });
        for &filters in sizes {
            let loops = Loops { folder: &folder, library: &library, panic, body, filters };
            let hand = loops.measure(Form::Hand)?;
            let twice = loops.measure(Form::HandTwice)?;
            let mut row = format!("| {filters} | {:.1} | {} |", hand.instructions, twice.against(&hand)?);
            for ratios in &mut ratios {
                let form = loops.measure(ratios.form)?;
                row += &format!(" {} |", form.against(&hand)?);
                let (ratio, same) = (form.instructions / hand.instructions, form.assembly == hand.assembly);
                ratios.add(ratio, same);
                if !bar(ratios.form, body, panic).is_met(ratio, same) {
                    failures.push(format!("{}: {ratio:.3}, same assembly: {same}", form.program.display()));
                }
            }
            println!("{row}");
        }
        println!();
        summary.extend(ratios.iter().flat_map(|ratios| ratios.lines(title, bar(ratios.form, body, panic))));
    }
    println!("instructions per cycle, guard / by hand, {} sets of 1 to 64 filters\n\n{TITLES}", sizes.len());
    println!("{}\n", summary.join("\n"));
    paper(&folder, sizes)?;
    Ok(failures)
}

/// What all sizes of one form have in common.
#[derive(Default)]
struct Ratios {
    form: Form,
    largest: f64,
    same: u32,
    sizes: u32,
}

impl Ratios {
    fn add(&mut self, ratio: f64, same: bool) {
        self.largest = self.largest.max(ratio);
        self.same += u32::from(same);
        self.sizes += 1;
    }

    fn lines(&self, title: &str, bar: Bar) -> Vec<String> {
        let what = format!("`{}`, {title}", self.form.name());
        let largest = |bar| line(&what, "largest ratio", self.largest, &bar);
        match bar {
            Bar::None => vec![largest(row::Bar::None)],
            Bar::Ratio(most) => vec![largest(row::Bar::AtMost(most))],
            Bar::SameAssembly => {
                let share = f64::from(self.same) / f64::from(self.sizes);
                let figures = format!("{} / {} sets", self.same, self.sizes);
                vec![
                    largest(row::Bar::AtMost(1.0)),
                    line(&format!("{what}, same assembly"), &figures, share, &row::Bar::AtLeast(1.0)),
                ]
            }
        }
    }
}

/// What a form has to reach against calls by hand.
#[derive(Clone, Copy)]
enum Bar {
    SameAssembly,
    Ratio(f64),
    /// Shown only.
    None,
}

impl Bar {
    fn is_met(self, ratio: f64, same: bool) -> bool {
        match self {
            Self::SameAssembly => same,
            Self::Ratio(most) => ratio <= most,
            Self::None => true,
        }
    }
}

fn bar(form: Form, body: Body, panic: &str) -> Bar {
    match (form, panic) {
        (Form::Hand | Form::HandTwice, _) => Bar::None,
        (_, "unwind") => Bar::Ratio(UNWINDING_BAR),
        (Form::Run, _) => Bar::Ratio(1.000_5),
        // The compiler copies the laws of a guard that it cannot see the end of the body of to each `continue`, as if
        // they were written there. Which is faster depends on how much of that it inlines.
        (Form::List, _) if body != Body::Straight => Bar::None,
        _ => Bar::SameAssembly,
    }
}

/// One program of the comparison.
struct Loops<'a> {
    folder: &'a Path,
    library: &'a Path,
    panic: &'a str,
    body: Body,
    filters: usize,
}

struct Measured {
    program: PathBuf,
    result: String,
    instructions: f64,
    assembly: String,
}

impl Measured {
    /// Its instructions, and their ratio to those of another program that has to compute the same.
    fn against(&self, other: &Self) -> Result<String, String> {
        if self.result != other.result {
            return Err(format!("{} and {} compute different things", self.program.display(), other.program.display()));
        }
        let same = if self.assembly == other.assembly { ", same" } else { "" };
        Ok(format!("{:.1} ({:.3}{same})", self.instructions, self.instructions / other.instructions))
    }
}

impl Loops<'_> {
    fn measure(&self, form: Form) -> Result<Measured, String> {
        let name = format!("{}-{}-{}-{}", form.name(), self.filters, self.body.name(), self.panic);
        let source = source::rust(form, self.filters, self.body);
        let program = tools::rust(self.folder, &name, &source, self.library, self.panic)?;
        Ok(Measured {
            result: tools::result(&program)?,
            instructions: tools::instructions_per_cycle(&program)?,
            assembly: tools::assembly(&program)?,
            program,
        })
    }
}

/// The guard of the paper against calls written by hand, both in C++.
fn paper(folder: &Path, sizes: &[usize]) -> Result<(), String> {
    if tools::CPP.is_missing() {
        println!("{}", tools::CPP.how_to_install());
        return Ok(());
    }
    println!("The paper's guard, rebuilt from its figures, {}", tools::CPP.version());
    println!("| filters | by hand, -O2 | guard | with -DNDEBUG: no check |");
    println!("| ---: | ---: | ---: | ---: |");
    // The check is about cubic in the number of filters.
    for &filters in sizes.iter().filter(|&&filters| filters <= 16) {
        let measure = |name: &str, guarded: bool, options: &[&str]| {
            let options = [&["-std=c++17", "-O2"], options].concat();
            let program =
                tools::cpp(folder, &format!("cpp-{name}-{filters}"), &source::cpp(guarded, filters), &options)?;
            Ok::<_, String>((tools::result(&program)?, tools::instructions_per_cycle(&program)?))
        };
        let (hand_result, hand) = measure("hand", false, &[])?;
        let (guard_result, guard) = measure("guard", true, &[])?;
        let (_, unchecked) = measure("unchecked", true, &["-DNDEBUG"])?;
        if hand_result != guard_result {
            return Err(format!("the C++ programs with {filters} filters compute different things"));
        }
        println!(
            "| {filters} | {hand:.1} | {guard:.1} ({:.3}) | {unchecked:.1} ({:.3}) |",
            guard / hand,
            unchecked / hand
        );
    }
    Ok(())
}
