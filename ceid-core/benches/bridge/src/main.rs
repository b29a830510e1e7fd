//! Threads and exchanges of ceid-core against what else there is, as ratios: both sides in alternation in one run.
//!
//! ```text
//! cargo run --release --manifest-path ceid-core/benches/bridge/Cargo.toml
//! ```
//!
//! takes about five minutes on Linux, and wants a machine with nothing else to do. Real-time rows need root or the
//! limits that they name. `-- exchange`, `-- threads` and `-- simulated` run one part.

mod exchange;
mod instructions;
#[path = "../../../tests/exchange/inversion.rs"]
mod inversion;
#[path = "../../bars/row.rs"]
mod row;
mod simulated;
mod wake_up;

pub(crate) use row::Bar;
use row::{TITLES, line};
use std::process::{Command, Output};

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
    match arguments[..] {
        [] => ["exchange", "threads", "simulated"].map(part).into_iter().for_each(drop),
        // What this program starts itself for: a process each, so that they do not disturb each other.
        ["instructions", what, count] => instructions::run(what, count.parse().expect("a number of operations")),
        ["wake-up", world, seconds] => wake_up::run(world, seconds.parse().expect("a number of seconds")),
        ["hog", seconds] => wake_up::hog(seconds.parse().expect("a number of seconds")),
        [name] => part(name),
        _ => panic!("see the head of main.rs for the arguments"),
    }
}

fn part(name: &str) {
    match name {
        "exchange" => {
            instructions::table();
            exchange::table();
            inversion_row();
        }
        "threads" => wake_up::table(),
        "simulated" => simulated::table(),
        _ => panic!("no part is called {name}"),
    }
}

fn inversion_row() {
    use ceid_core::exchange::{PriorityInheriting, StdMutex};
    heading("priority inversion, longest wait");
    let inherited = inversion::longest_wait::<PriorityInheriting>();
    let inverted = inversion::longest_wait::<StdMutex>();
    if let (Some(inherited), Some(inverted)) = (inherited, inverted) {
        let ratio = inherited.as_secs_f64() / inverted.as_secs_f64();
        row(
            "longest wait under priority inversion: `PriorityInheriting` / std `Mutex`",
            &format!("{inherited:.1?} / {inverted:.1?}"),
            ratio,
            Bar::AtMost(0.10),
        );
    }
}

pub(crate) fn heading(text: &str) {
    println!("\n{text}\n\n{TITLES}");
}

/// Prints one line of a table.
pub(crate) fn row(what: &str, figures: &str, ratio: f64, bar: Bar) {
    println!("{}", line(what, figures, ratio, &bar));
}

pub(crate) fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

/// Runs a tool, or says how to install it.
pub(crate) fn tool(name: &str, package: &str, arguments: &[&str]) -> Option<Output> {
    match Command::new(name).args(arguments).output() {
        Ok(output) => Some(output),
        Err(_) => {
            println!("  {name} is missing: apt-get install --no-install-recommends {package}");
            None
        }
    }
}

pub(crate) fn this_program() -> Command {
    Command::new(std::env::current_exe().expect("a program knows its own path"))
}
