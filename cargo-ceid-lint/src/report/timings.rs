//! Where the time of a run went, for `--timings`.

use std::time::Duration;

use crate::pipeline::Timings;

/// A line for each part, and one for the whole. Parts of packages that were looked at side by side add up to more than that.
#[must_use]
pub fn timings(timings: &Timings, total: Duration) -> String {
    let rows = timings.iter().map(|(stage, time)| (stage.name(), time)).chain([("total", total)]);
    rows.map(|(name, time)| format!("{name:8}  {:8.1} ms\n", time.as_secs_f64() * 1_000.0)).collect()
}
