//! Gates of time and rate: clocks, timers, counters, and steps that are measured.

use super::Gates;
use crate::count::search::{End, Exploration, Region};
use crate::count::verdict::Gate;
use crate::flow::{Effect, NodeId, Place, Test, Var};

/// Names of methods and fields that tell the time.
const CLOCKS: &[&str] = &[
    "now",
    "elapsed",
    "millis",
    "micros",
    "duration_since",
    "checked_duration_since",
    "as_millis",
    "as_micros",
    "as_secs_f32",
    "as_secs_f64",
    "as_secs",
    "ticks",
    "as_ticks",
    "timestamp",
    "time",
    "uptime",
    "get_time",
    "now_ms",
    "now_us",
    "is_due",
    "has_elapsed",
    "deadline",
    "saturating_duration_since",
    "monotonic",
    "timer_count",
    "clock",
    "seconds",
    "secs",
    "time_us",
    "time_ms",
    "get_ticks",
    "tick_count",
    "current_time",
];

impl Gates<'_, '_> {
    /// `timer.wait().is_ok()`, `sleep.poll(cx).is_pending()`: a question to something that is named as a timer.
    fn is_timer_poll(&self, test: &Test) -> bool {
        let polls = test.about.names.iter().any(|name| {
            matches!(
                name.as_str(),
                "wait" | "poll" | "is_pending" | "is_ready" | "is_expired" | "expired" | "tick" | "fired" | "done"
            )
        });
        polls
            && test.about.reads.iter().any(|place| {
                let name = self.last_name(place).to_lowercase();
                ["timer", "sleep", "delay", "ticker", "interval", "alarm", "countdown", "period"]
                    .iter()
                    .any(|part| name.contains(part))
            })
    }

    pub(super) fn tells_time(&self, test: &Test) -> bool {
        let graph = self.search.graph;
        let is_clock = |name: &str| CLOCKS.contains(&name);
        if test.about.names.iter().any(|name| is_clock(name)) || self.is_timer_poll(test) {
            return true;
        }
        if !test.about.is_comparison {
            return false;
        }
        test.about.reads.iter().any(|place| {
            let typed = crate::count::instances::place_ty(self.search.program.index, graph, place);
            let by_type = typed.is_some_and(|ty| {
                matches!(ty.external_name(), Some("Instant" | "Duration" | "CuDuration" | "CuTime" | "SystemTime"))
            });
            by_type || self.calls_behind(place).iter().any(|name| is_clock(name))
        })
    }

    /// The functions that a variable was computed with, by any number of steps.
    fn calls_behind(&self, place: &Place) -> Vec<String> {
        let graph = self.search.graph;
        let mut calls = Vec::new();
        let mut seen: Vec<Var> = Vec::new();
        let mut open: Vec<Var> = place.base_var().filter(|_| place.steps.is_empty()).into_iter().collect();
        while let Some(var) = open.pop() {
            if seen.contains(&var) || seen.len() > 32 {
                continue;
            }
            seen.push(var);
            if let Some(computed) = graph.computed.get(&var) {
                calls.extend(computed.calls.iter().cloned());
                open.extend(computed.places.iter().filter(|place| place.steps.is_empty()).filter_map(Place::base_var));
            }
        }
        calls
    }

    /// A counter that is compared: set back or wrapped, it decimates; never set back, it counts a warm-up.
    pub(super) fn counter(&self, test: &Test) -> Option<Gate> {
        test.about.reads.iter().find_map(|place| {
            let steps = self.count_steps(place)?;
            if steps.wraps || (steps.counts && (steps.set_back || test.about.is_masked)) {
                return Some(Gate::Rate);
            }
            (steps.counts && !steps.other && test.about.is_comparison).then_some(Gate::Startup)
        })
    }

    /// How a place changes in the region, if it is a counter; `None` if nothing changes it.
    fn count_steps(&self, place: &Place) -> Option<CountSteps> {
        let sources = self.search.program.sources;
        let mut steps = CountSteps::default();
        let mut changes = false;
        for id in self.nodes() {
            let node = self.search.graph.node(id);
            let (Effect::Write(write) | Effect::Set(write)) = &node.effect else { continue };
            if write.place != *place {
                continue;
            }
            changes = true;
            let text = sources.snippet(node.span);
            if write.head.as_deref().is_some_and(|head| head.parse::<i64>().is_ok()) || text.contains("= 0") {
                steps.set_back = true;
            } else if text.contains('%') || text.contains("rem_euclid") {
                steps.wraps = true;
            } else if ["+= 1", "-= 1", "+ 1", "- 1", "_add(1)", "_sub(1)"].iter().any(|step| text.contains(step)) {
                steps.counts = true;
            } else if write.head.is_none() && text.contains("= ") && is_plain_number(text) {
                steps.set_back = true;
            } else {
                steps.other = true;
            }
        }
        changes.then_some(steps)
    }

    /// The clock that the filter's step is computed from stands still on the way, so that the next step covers the gap.
    pub(super) fn measured(&self, exploration: &Exploration, end: &End) -> Option<Gate> {
        let graph = self.search.graph;
        let path: Vec<NodeId> = exploration.path(end.at).iter().map(|at| exploration.states[*at].node).collect();
        let steps = self.fed_places();
        let tells_time = steps.iter().any(|place| {
            self.calls_behind(place).iter().any(|name| CLOCKS.contains(&name.as_str()))
                || matches!(
                    crate::count::instances::place_ty(self.search.program.index, graph, place)
                        .as_ref()
                        .and_then(crate::index::Ty::external_name),
                    Some("Instant" | "Duration" | "SystemTime")
                )
        });
        if !tells_time {
            return None;
        }
        let writes = |id: NodeId, place: &Place| match &graph.node(id).effect {
            Effect::Write(write) | Effect::Set(write) => write.place == *place,
            _ => false,
        };
        let stands = steps.iter().any(|place| {
            self.outlives(place)
                && self.is_clock_name(place)
                && self.nodes().any(|id| writes(id, place))
                && !path.iter().any(|id| writes(*id, place))
        });
        stands.then_some(Gate::Measured)
    }

    /// Whether a place is there before and after the iteration.
    pub(super) fn outlives(&self, place: &Place) -> bool {
        let graph = self.search.graph;
        match (self.region, place.base_var()) {
            (Region::Loop(own), Some(var)) => !graph.is_within(graph.var(var).in_loop, own),
            (Region::Function, Some(var)) => graph.var(var).param.is_some(),
            (_, None) => true,
        }
    }

    /// Whether the way advances a clock that the gate or the filter's step is measured with.
    pub(super) fn advances_clock(&self, exploration: &Exploration, end: &End, _at: NodeId) -> bool {
        let graph = self.search.graph;
        let steps = self.fed_places();
        exploration.path(end.at).iter().any(|at| {
            let node = graph.node(exploration.states[*at].node);
            let (Effect::Write(write) | Effect::Set(write)) = &node.effect else { return false };
            self.outlives(&write.place) && self.is_clock_name(&write.place) && steps.contains(&write.place)
        })
    }

    /// Whether a place is named as the time of the last step.
    fn is_clock_name(&self, place: &Place) -> bool {
        let name = self.last_name(place);
        ["last", "prev", "time", "stamp", "t0", "then", "previous", "tick"].iter().any(|part| name.contains(part))
    }
}

/// How a counter changes.
#[derive(Clone, Copy, Debug, Default)]
struct CountSteps {
    /// It goes up or down by one.
    counts: bool,
    /// It is set to a constant.
    set_back: bool,
    /// It goes round by itself.
    wraps: bool,
    /// It changes in another way.
    other: bool,
}

/// Whether an assignment gives a constant by its name: `n = PERIOD`.
fn is_plain_number(text: &str) -> bool {
    text.rsplit("= ").next().is_some_and(|value| {
        value.chars().all(|character| {
            character.is_ascii_uppercase() || character == '_' || character.is_ascii_digit() || character == ':'
        })
    })
}
