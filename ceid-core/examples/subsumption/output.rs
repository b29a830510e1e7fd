//! What is told of a run: a table, and a file of points.

use crate::robot::vector::Vector;
use crate::robot::world::GOAL;
use crate::robot::{self, Journey};
use std::fmt::Write as _;
use std::fs;
use std::path::Path;

/// The path at one intensity.
pub(crate) struct Curve {
    pub(crate) intensity: f64,
    pub(crate) path: Vec<Vector>,
    pub(crate) journey: Journey<String>,
}

pub(crate) fn table(curves: &[Curve]) -> String {
    let mut table =
        "intensity  clearance [m]  obstacle  from the goal [m]  missed  latest [ms]              path".to_owned();
    for Curve { intensity, path, journey } in curves {
        let obstacle = if journey.clearance < 0.0 { "touched" } else { "avoided" };
        let rest = path.last().map_or(f64::NAN, |end| (GOAL - *end).length());
        let _ = write!(
            table,
            "\n{intensity:9.2}  {:13.3}  {obstacle:8}  {rest:17.3}  {:6}  {:11.1}  {:016x}",
            journey.clearance,
            journey.missed,
            journey.late.as_secs_f64() * 1000.0,
            robot::hash(path),
        );
    }
    table
}

pub(crate) fn csv(curves: &[Curve]) -> String {
    let mut csv = "intensity,time_s,x_m,y_m\n".to_owned();
    for Curve { intensity, path, .. } in curves {
        for (at, Vector { x, y }) in path.iter().enumerate() {
            let _ = writeln!(csv, "{intensity},{}.{},{x},{y}", at / 10, at % 10);
        }
    }
    csv
}

pub(crate) fn write(file: &Path, text: &str) -> Result<(), String> {
    fs::write(file, text).map_err(|error| format!("`{}` cannot be written: {error}.", file.display()))
}
