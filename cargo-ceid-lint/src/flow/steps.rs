//! Which names stand for the step of a filter or the rate of its samples, and in which unit.

use crate::index::{FunctionId, Index};
use crate::source::Span;
use crate::syntax::tree::{Body, PatKind, TypeRef};

/// A constant step with which a filter is made.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Step {
    /// The time between two samples.
    pub seconds: f64,
    /// Whether its unit is certain: by its type or its name.
    pub has_unit: bool,
    /// Where it is given.
    pub span: Span,
}

/// What a number under such a name says.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum StepUnit {
    /// A time: this many seconds are one of it; `None` if only its type tells.
    Time(Option<f64>),
    /// Samples in a second: this many hertz are one of it.
    Rate(f64),
}

/// Names of a step, without their unit.
const STEPS: &[&str] = &[
    "dt",
    "delta_t",
    "delta_time",
    "time_step",
    "timestep",
    "step_time",
    "sample_time",
    "sample_period",
    "sampling_time",
    "sampling_period",
    "ts",
    "cycle_time",
    "loop_time",
    "cycle_period",
    "loop_period",
    "control_period",
    "update_period",
];

/// Names of a rate of samples, without their unit.
const RATES: &[&str] = &[
    "fs",
    "sample_rate",
    "sampling_rate",
    "sample_freq",
    "sampling_freq",
    "sample_frequency",
    "sampling_frequency",
    "update_rate",
    "loop_rate",
    "control_rate",
    "loop_frequency",
    "control_frequency",
];

/// Names that also tell a law how much time has passed.
const TIMES: &[&str] = &[
    "delta",
    "elapsed",
    "interval",
    "duration",
    "seconds",
    "period",
    "step",
    "time",
    "timestamp",
    "now",
    "t",
    "stamp",
    "h",
];

/// Suffixes of a name that say its unit.
const UNITS: &[(&str, f64)] = &[
    ("_s", 1.0),
    ("_sec", 1.0),
    ("_secs", 1.0),
    ("_seconds", 1.0),
    ("_ms", 1e-3),
    ("_millis", 1e-3),
    ("_us", 1e-6),
    ("_micros", 1e-6),
    ("_ns", 1e-9),
    ("_nanos", 1e-9),
];

/// What a name says of the step, if it is the name of one.
#[must_use]
pub fn step_unit(name: &str) -> Option<StepUnit> {
    let name = name.trim_start_matches('_');
    if STEPS.contains(&name) || name == "period" {
        return Some(StepUnit::Time(None));
    }
    if RATES.contains(&name) {
        return Some(StepUnit::Rate(1.0));
    }
    for (suffix, hertz) in [("_hz", 1.0), ("_khz", 1e3)] {
        if let Some(base) = name.strip_suffix(suffix)
            && (RATES.contains(&base) || matches!(base, "rate" | "sample" | "loop" | "update"))
        {
            return Some(StepUnit::Rate(hertz));
        }
    }
    UNITS.iter().find_map(|(suffix, seconds)| {
        let base = name.strip_suffix(suffix)?;
        (STEPS.contains(&base) || base == "period").then_some(StepUnit::Time(Some(*seconds)))
    })
}

/// Whether a function is told how much time has passed: by a `Duration`, or by a parameter that is named as a time.
#[must_use]
pub fn takes_step(index: &Index, id: FunctionId) -> bool {
    let function = &index.function(id).function;
    let by_type = function
        .params
        .iter()
        .any(|ty| matches!(behind(ty), TypeRef::Path(path) if path.last() == "Duration" || path.last() == "Instant"));
    by_type || function.body.iter().flat_map(parameter_names).any(is_time_name)
}

/// Whether a function is told the time that it is, from which it reckons by itself how much has passed.
#[must_use]
pub fn takes_moment(index: &Index, id: FunctionId) -> bool {
    index
        .function(id)
        .function
        .params
        .iter()
        .any(|ty| matches!(behind(ty), TypeRef::Path(path) if path.last() == "Instant" || path.last() == "SystemTime"))
}

/// Whether a name says that it tells a law how much time has passed.
#[must_use]
pub fn is_time_name(name: &str) -> bool {
    let name = name.trim_start_matches('_');
    let base = UNITS.iter().find_map(|(suffix, _)| name.strip_suffix(suffix)).unwrap_or(name);
    matches!(step_unit(name), Some(StepUnit::Time(_)))
        || TIMES.contains(&base)
        || is_time_of_round(base)
        || is_point(base)
}

/// Whether a name is put together of words for one round and for a time: `iteration_length`, `t_interval`. How long an attack or
/// a release takes is tuned, and no step.
fn is_time_of_round(name: &str) -> bool {
    let mut words = name.rsplit('_');
    let (last, before) = (words.next().unwrap_or_default(), words.next().unwrap_or_default());
    let is_round =
        ["iteration", "sample", "loop", "cycle", "frame", "update", "tick", "step", "last", "t"].contains(&before);
    is_round && ["time", "length", "interval", "period", "duration", "elapsed", "dt"].contains(&last)
}

/// Whether a name says that it is a point in time, with words around: `timestamp_now`, `sample_timestamp`, `current_time`.
fn is_point(name: &str) -> bool {
    let of = name.strip_suffix("_time").unwrap_or_default();
    matches!(of, "current" | "measurement") || name.split('_').any(|word| word == "timestamp" || word == "now")
}

fn behind(ty: &TypeRef) -> &TypeRef {
    match ty {
        TypeRef::Reference { inner, .. } => behind(inner),
        ty => ty,
    }
}

/// The names of the parameters, `self` included; empty for one that is a pattern.
pub(super) fn parameter_names(body: &Body) -> impl Iterator<Item = &str> {
    body.params.iter().map(|pat| match &body.pat(*pat).kind {
        PatKind::Bind { name, .. } => name.as_str(),
        _ => "",
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_say_what_they_count() {
        assert_eq!(step_unit("dt"), Some(StepUnit::Time(None)));
        assert_eq!(step_unit("_dt_ms"), Some(StepUnit::Time(Some(1e-3))));
        assert_eq!(step_unit("sample_rate_hz"), Some(StepUnit::Rate(1.0)));
        assert_eq!(step_unit("fs"), Some(StepUnit::Rate(1.0)));
        for other in ["cutoff_hz", "gain", "rate", "steps", "frequency", "time_constant", ""] {
            assert_eq!(step_unit(other), None, "{other}");
        }
    }
}
