//! The robot of the paper: it reaches its goal past an obstacle, and how strongly avoiding interferes with reaching is
//! its intensity. The same robot runs in simulated, soft and hard real time.
//!
//! ```text
//! cargo run -p ceid-core --release --example subsumption -- --plot figure-11.svg
//! ```

mod arguments;
mod output;
mod plot;
mod robot;
mod worlds;

use arguments::Arguments;
use output::Curve;
use robot::Trip;
use robot::vector::Vector;
use robot::world::CYCLES_PER_POINT;
use std::env;
use std::io;
use std::process::ExitCode;
use std::time::Duration;

fn main() -> ExitCode {
    let arguments = match arguments::parse(env::args().skip(1)) {
        Ok(Some(arguments)) => arguments,
        Ok(None) => return tell(io::stdout(), arguments::HELP, ExitCode::SUCCESS),
        Err(sentence) => return tell(io::stderr(), &sentence, ExitCode::from(2)),
    };
    match run(&arguments) {
        Ok(table) => tell(io::stdout(), &table, ExitCode::SUCCESS),
        Err(sentence) => tell(io::stderr(), &sentence, ExitCode::FAILURE),
    }
}

/// Where nobody reads, there is nobody to tell.
fn tell(mut to: impl io::Write, text: &str, code: ExitCode) -> ExitCode {
    let _ = writeln!(to, "{text}");
    code
}

/// Returns the table for the terminal.
fn run(arguments: &Arguments) -> Result<String, String> {
    let mut curves = Vec::new();
    for intensity in &arguments.intensities {
        let duration = Duration::from_secs(arguments.seconds);
        let fault = arguments.fault.clone();
        let trip = Trip { seed: arguments.seed, duration, fault, ..Trip::new(*intensity) };
        let points = arguments.seconds * 1000 / CYCLES_PER_POINT + 1;
        let mut path: Vec<Vector> = (0..points).map(|_| Vector::default()).collect();
        let journey = worlds::drive(arguments.world, &trip, &mut path)?;
        path.truncate(journey.points);
        if !journey.report.is_empty() {
            tell(io::stderr(), &journey.report, ExitCode::SUCCESS);
        }
        curves.push(Curve { intensity: *intensity, path, journey });
    }
    if let Some(file) = &arguments.csv {
        output::write(file, &output::csv(&curves))?;
    }
    if let Some(file) = &arguments.plot {
        output::write(file, &plot::svg(&curves, &arguments.title()))?;
    }
    Ok(output::table(&curves))
}
