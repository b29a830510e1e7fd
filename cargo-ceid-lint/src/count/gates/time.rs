//! Gates of time: clocks, deadlines and timers.

use std::collections::BTreeSet;

use super::sources::Sources;
use super::{Gates, Way};
use crate::config::TimeBase;
use crate::count::fed::named;
use crate::count::given::{Given, given, place_of};
use crate::count::outcome::Outcome;
use crate::count::search::Search;
use crate::count::summary::Summary;
use crate::count::verdict::Gate;
use crate::flow::{ChangeKind, Computed, Effect, NodeId, Place, StepUnit, Test, is_time_name, step_unit};
use crate::index::{FunctionId, Ty};

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

/// Names of methods that ask a timer, or wait for it.
const POLLS: &[&str] = &["wait", "poll", "poll_unpin", "poll_tick", "tick"];

/// Last words of the names of methods that ask a timer whether its time is up: `is_pending`, `just_finished`.
const TIMER_STATES: &[&str] =
    &["pending", "ready", "expired", "elapsed", "fired", "finished", "done", "due", "overflowed", "wrapped"];

/// Names of the flags of registers that nothing but a timer has: "update interrupt flag".
const TIMER_FLAGS: &[&str] = &["uif"];

/// Types of points and spans of time.
const TIMES: &[&str] = &["Instant", "Duration", "CuDuration", "CuTime", "SystemTime"];

pub(super) fn is_clock(name: &str) -> bool {
    CLOCKS.contains(&name)
}

impl Gates<'_, '_> {
    pub(super) fn tells_time(&self, test: &Test) -> bool {
        let asked = self.asked_of_times(test);
        let names_clock = || asked.calls.iter().any(|name| is_clock(name));
        if names_clock() || self.is_timer_poll(test) || self.is_told_by_clock(&asked) {
            return true;
        }
        if !test.about.is_comparison {
            return self.asks_whether_clock_moved(test);
        }
        if self.is_since_clock(&asked) || self.put_off(test).is_some() || self.begun_again(test).is_some() {
            return true;
        }
        asked.places.iter().any(|place| {
            let source = Computed { places: vec![place.clone()], calls: Vec::new() };
            let is_told = place.steps.is_empty() && self.tells(&self.assignments().behind(&source));
            is_told || self.is_time(place) || self.is_accumulated_time(place)
        })
    }

    /// `if now != self.last { self.last = now; … }`: whether a clock has gone on since it was read the last time.
    fn asks_whether_clock_moved(&self, test: &Test) -> bool {
        let about = &test.about;
        let [left, right] = named(&about.reads)[..] else { return false };
        let is_reading = |place: &Place| {
            let sources = Computed { places: vec![place.clone()], calls: Vec::new() };
            !self.outlives(place) && self.tells(&self.assignments().behind(&sources))
        };
        let is_last = |place: &Place| self.outlives(place) && self.is_kept_time(place);
        let is_plain = |place: &Place| self.is_number(place) || self.is_time(place);
        about.is_combined
            && !about.is_presence
            && !about.is_masked
            && !about.is_remainder
            && is_plain(left)
            && is_plain(right)
            && (is_reading(left) && is_last(right) || is_last(left) && is_reading(right))
    }

    /// A comparison with what is named as a point of time: `now < self.deadline`.
    pub(super) fn asks_moment(&self, test: &Test) -> bool {
        test.about.is_comparison && test.about.reads.iter().any(|place| is_moment_name(&self.last_name(place)))
    }

    /// `let dt = now - self.last; if dt >= PERIOD { self.last = now; … }`: the time since a clock that is kept here, as far as the
    /// names of what is asked or of what it is computed from tell.
    fn is_since_clock(&self, asked: &Computed) -> bool {
        let is_step = |place: &Place| matches!(step_unit(&self.last_name(place)), Some(StepUnit::Time(_)));
        let is_moment = |place: &Place| {
            let name = self.last_name(place);
            is_moment_name(&name) || is_clock(&name)
        };
        let sources = self.assignments().behind(asked);
        (asked.places.iter().any(is_step) || sources.places.iter().any(is_moment))
            && self.clocks(&sources).next().is_some()
    }

    /// `timer.wait().is_ok()`, `sleep.poll(cx).is_pending()`: a question to something that is a timer by its name or its type.
    fn is_timer_poll(&self, test: &Test) -> bool {
        let polls = |name: &String| {
            let end = name.rsplit('_').next().unwrap_or(name);
            POLLS.contains(&name.as_str()) || TIMER_STATES.contains(&end)
        };
        test.about.names.iter().any(|name| TIMER_FLAGS.contains(&name.as_str()))
            || test.about.names.iter().any(polls)
                && test.about.reads.iter().any(|place| {
                    names_timer(&self.last_name(place)) || self.ty(place).is_some_and(|ty| self.is_timer(&ty))
                })
    }

    /// Whether a type is called as timers are: `hal::timer::Timer`, `Pin<Box<Sleep>>`.
    fn is_timer(&self, ty: &Ty) -> bool {
        match ty.peel() {
            Ty::Adt(id, _) => is_timer_type(&self.search.program.index.type_def(*id).name),
            Ty::External(path, args) => {
                let name = path.rsplit("::").next().unwrap_or(path);
                is_timer_type(name)
                    || matches!(name, "Pin" | "Box" | "Option") && args.iter().any(|arg| self.is_timer(arg))
            }
            _ => false,
        }
    }

    /// Whether a value comes from a clock.
    pub(super) fn tells(&self, sources: &Sources) -> bool {
        sources.calls.iter().any(|name| is_clock(name)) || sources.places.iter().any(|place| self.is_time(place))
    }

    pub(super) fn is_time(&self, place: &Place) -> bool {
        let is_time = |ty: &Ty| ty.external_name().is_some_and(|name| TIMES.contains(&name));
        match self.ty(place) {
            // The time of the last step, of which there is none in the first one.
            Some(Ty::External(path, args)) if path.ends_with("::Option") => args.first().is_some_and(is_time),
            ty => ty.as_ref().is_some_and(is_time),
        }
    }

    /// `since += dt`, `left -= dt`: a place to which a span of time is added.
    fn is_accumulated_time(&self, place: &Place) -> bool {
        self.outlives(place)
            && self.assigning(place).any(|id| {
                self.search.graph.changes.get(&id).is_some_and(|change| {
                    matches!(change.kind, ChangeKind::Accumulates | ChangeKind::Spends)
                        && !named(&change.computed.places).into_iter().any(|from| self.is_signal(from))
                        && (change.computed.places.iter().any(|step| is_time_name(&self.last_name(step)))
                            || self.tells(&self.assignments().behind(&change.computed)))
                })
            })
    }

    /// `elapsed += now - last; if elapsed < PERIOD { continue; } elapsed -= PERIOD;`: what is counted up to a limit is time, so that the
    /// gate is one of time. Whether it loses any is asked before.
    pub(super) fn sums_up_time(&self, at: NodeId) -> bool {
        let Effect::Branch(test) = &self.search.graph.node(at).effect else { return false };
        let is_counter = !self.is_helper && test.about.is_comparison && !test.about.is_remainder;
        // The same step in each round counts rounds.
        let is_measured = |place: &Place| !self.assigning(place).any(|id| self.goes_on_by_setting(id));
        is_counter && self.asked(test).iter().any(|place| self.is_accumulated_time(place) && is_measured(place))
    }

    pub(super) fn assigns(&self, id: NodeId, place: &Place) -> bool {
        match &self.search.graph.node(id).effect {
            Effect::Write(write) | Effect::Set(write) => write.place == *place,
            _ => false,
        }
    }

    /// The times that are kept from one iteration to the next, among the places that a value is computed from.
    pub(super) fn clocks<'s>(&'s self, sources: &'s Sources) -> impl Iterator<Item = &'s Place> + 's {
        sources.places.iter().filter(|place| self.outlives(place) && self.is_kept_time(place))
    }

    /// Whether the cycle keeps a time in a place.
    fn is_kept_time(&self, place: &Place) -> bool {
        if let Some(known) = self.kept_times.borrow().get(place) {
            return *known;
        }
        let is_time = self.is_time(place);
        // What another filter has kept of its input is no time: `self.last = x`.
        let is_clock = || is_clock_name(&self.last_name(place)) || self.is_subtracted_for_step(place);
        let is_named = is_time || (is_clock() && !self.is_in_other_filter(place));
        // A truth value that was asked of a clock is none.
        let is_kept = self.ty(place) != Some(Ty::Bool)
            && self.nodes().any(|id| {
                self.renews(id, place)
                    && match self.search.graph.changes.get(&id) {
                        Some(change) => {
                            change.kind != ChangeKind::Constant
                                && (is_named
                                    || !self.is_signal(place)
                                        && self.tells(&self.assignments().behind(&change.computed)))
                        }
                        // Without a step of its own, what is kept by a method may as well be the last sample.
                        None => is_time || (is_named && self.time_base() == TimeBase::Passed),
                    }
            });
        self.kept_times.borrow_mut().insert(place.clone(), is_kept);
        is_kept
    }

    /// Whether what an event brings is no time but the last sample for a filter without a step of its own: no iteration that updates
    /// the filter brings another one. `Hall(rpm) => last_rpm = rpm`
    fn brings_sample(&self, way: &Way) -> bool {
        let leads = |from: NodeId, to: NodeId| self.reached_from(from, |_, _| true)[to.0 as usize];
        let updating = self.search.updating();
        let is_beside = |id: NodeId| updating.iter().any(|update| leads(id, *update) || leads(*update, id));
        let is_time_read = |id: NodeId| {
            let change = self.search.graph.changes.get(&id);
            change.is_none_or(|change| self.tells(&self.assignments().behind(&change.computed)))
        };
        let is_sample = |place: &Place| {
            let mut renewed = self.nodes().filter(|id| self.renews(*id, place));
            !self.is_time(place) && renewed.all(|id| !is_beside(id) && !is_time_read(id))
        };
        let is_renewed = |clock: &&Place| way.nodes.iter().any(|id| self.renews(*id, clock));
        let mut clocks = self.clocks(self.step()).filter(is_renewed).peekable();
        self.time_base() == TimeBase::Fixed && clocks.peek().is_some() && clocks.all(is_sample)
    }

    /// `dt = now - t; t = now;`: whether the step that the filter is told is reckoned from a number that is kept and from the one that
    /// takes its place, whatever they are called.
    fn is_subtracted_for_step(&self, place: &Place) -> bool {
        let Some(step) = self.told_step().filter(|step| self.outlives(place) && step.places.contains(place)) else {
            return false;
        };
        let is_next = |id: NodeId| {
            let computed = self.search.graph.changes.get(&id).map(|change| &change.computed);
            let from = computed.filter(|computed| computed.calls.is_empty()).map(|computed| named(&computed.places));
            matches!(from.as_deref(), Some([from]) if *from != place && step.places.contains(from))
        };
        let mut given = self.assigning(place).peekable();
        self.is_number(place) && given.peek().is_some() && given.all(is_next)
    }

    /// Whether a node gives a place another value: by its name, by that of a reference to it, or in a method.
    pub(super) fn renews(&self, id: NodeId, place: &Place) -> bool {
        let graph = self.search.graph;
        match &graph.node(id).effect {
            Effect::Call(site) => {
                self.written_by(site).any(|own| own.overlaps(place) && own.steps.len() >= place.steps.len())
            }
            Effect::Write(write) if write.place != *place => {
                let by_reference = write.place.base_var().is_some_and(|var| matches!(graph.var(var).ty, Ty::Ref(..)));
                by_reference
                    && !write.rebinds
                    && graph.changes.contains_key(&id)
                    && self.search.aliases.shared_roots(&write.place).contains(place)
            }
            _ => self.assigns(id, place) && graph.changes.contains_key(&id),
        }
    }

    /// Whether a way sets one of these clocks.
    pub(super) fn sets_clock(&self, sources: &Sources, way: &Way) -> bool {
        let clocks: Vec<&Place> = self.clocks(sources).collect();
        way.nodes.iter().any(|id| {
            let goes_on = |place: &Place| !self.leaves_where_absent(*id, way, place);
            clocks.iter().any(|place| self.renews(*id, place) && goes_on(place))
                || self.lapped(*id, sources).iter().any(goes_on)
        })
    }

    /// Whether a call had nothing to give on a way, and writes a place only where it has: `fn fix(&mut self) -> Option<f32>` that
    /// notes when the last fix came.
    fn leaves_where_absent(&self, id: NodeId, way: &Way, place: &Place) -> bool {
        let graph = self.search.graph;
        let Effect::Call(site) = &graph.node(id).effect else { return false };
        let is_result = |asked: &Test| {
            let whole = asked.subject.and_then(|id| graph.subjects[id.0 as usize].whole.as_ref());
            let var = whole.filter(|whole| whole.steps.is_empty()).and_then(Place::base_var);
            var.is_some_and(|var| var == site.result || site.into.contains(&var))
        };
        let asked = way.nodes.iter().skip_while(|node| **node != id);
        let is_absent = asked.zip(way.nodes.iter().skip_while(|node| **node != id).skip(1)).any(|(node, next)| {
            let Effect::Branch(test) = &graph.node(*node).effect else { return false };
            let holds = graph.node(*node).next.first() == Some(next);
            test.about.asks_presence() && is_result(test) && test.about.heads.iter().all(|head| (head == "+") != holds)
        });
        let leaves = |summary: &Summary| {
            let written = summary.writes.difference(&summary.writes_if_present);
            !written.filter_map(|given| place_of(given, site)).any(|written| written.overlaps(place))
        };
        is_absent && site.targets.iter().all(|target| self.search.summaries.get(*target).is_some_and(leaves))
    }

    /// A helper that keeps the time, and whose result the value is computed from: `let dt = self.lap();`, `update(error, watch.lap())`
    pub(super) fn laps(&self, id: NodeId, sources: &Sources) -> bool {
        !self.lapped(id, sources).is_empty()
    }

    /// The times that such a helper keeps.
    pub(super) fn lapped(&self, id: NodeId, sources: &Sources) -> Vec<Place> {
        let Effect::Call(site) = &self.search.graph.node(id).effect else { return Vec::new() };
        let name = |target: &FunctionId| &self.search.program.index.function(*target).name;
        let asked = site.args.first().and_then(|arg| arg.place.as_ref());
        // What a method of the analysed code's own types gives may carry samples, and is no span of time.
        let is_own = matches!(self.ty(&Place::var(site.result)), Some(Ty::Adt(..)));
        let is_result = site.into.iter().any(|var| sources.has_var(*var))
            || asked.is_some_and(|place| sources.places.contains(place))
                && site.targets.iter().any(|target| sources.calls.contains(name(target)));
        let is_named = |place: &Place| is_clock_name(&self.last_name(place)) && !self.is_in_other_filter(place);
        let is_clock = |place: &Place| {
            self.outlives(place) && (self.is_time(place) || is_named(place) || self.is_told_since(site, id, place))
        };
        if is_result && !is_own { self.written_by(site).filter(is_clock).collect() } else { Vec::new() }
    }

    /// Whether the time goes on without the filter, so that a gate is no excuse.
    pub(super) fn loses_time(&self, gate: Gate, way: &Way) -> bool {
        match gate {
            // The filter starts anew, or never does.
            Gate::Config | Gate::Startup | Gate::Mode | Gate::Measured => false,
            Gate::Time => match &self.search.graph.node(way.at).effect {
                Effect::Branch(test) => {
                    let is_sum = test.about.reads.iter().any(|place| self.is_accumulated_time(place));
                    !is_sum && self.resets_deadline(test, way) && !self.opens_next(test, way)
                }
                _ => false,
            },
            Gate::Event if self.brings_sample(way) => false,
            _ => self.time_base() != TimeBase::Inside && self.goes_on(way) && !self.gathers_step(way),
        }
    }

    /// Whether a way that finds the gate closed begins its period anew, so that it never opens.
    fn resets_deadline(&self, test: &Test, way: &Way) -> bool {
        let sources = self.behind(test);
        let sets_anew = |id: NodeId, clock: &Place| {
            let change = self.search.graph.changes.get(&id);
            self.assigns(id, clock)
                && change.is_some_and(|change| matches!(change.kind, ChangeKind::Fills | ChangeKind::Other))
        };
        let told = self.begun_again(test);
        self.clocks(&sources).chain(&told).any(|clock| {
            self.nodes().filter(|id| sets_anew(*id, clock)).any(|id| {
                let before = self.branch_before(id).filter(|(_, at)| *at != way.at);
                let asks_clock = |test: &Test| self.behind(test).places.iter().any(|place| place.overlaps(clock));
                match before {
                    // A clock that has gone round is put right: `if now < last { last = now; }`
                    Some((test, _)) if asks_clock(test) => false,
                    // Each time that another period is over, which may be shorter.
                    Some((test, _)) if self.asks_moment(test) || self.tells_time(test) => {
                        self.reached_from(id, |_, _| true)[way.at.0 as usize]
                    }
                    _ => way.nodes.contains(&id),
                }
            })
        })
    }

    /// A way that leaves before a time gate is asked, or before its clock is set: the gate stays as it is.
    pub(super) fn is_before_closed_gate(&self, way: &Way) -> bool {
        let sets = |gate: &TimeGate| self.sets_clock(&gate.sources, way) || self.renews_one(&gate.clocks, way);
        self.time_gates().iter().any(|gate| !way.nodes.contains(&gate.at) && !sets(gate))
    }

    /// The time gates of the region that keep a clock, in it or in what it calls.
    fn time_gates(&self) -> &[TimeGate] {
        self.time_gates.get_or_init(|| {
            let graph = self.search.graph;
            let reach = self.reach();
            let gate = |at: NodeId| match &graph.node(at).effect {
                Effect::Branch(test) => {
                    let decides = graph.node(at).next.iter().filter(|next| reach[next.0 as usize]).count() == 1;
                    let waits = decides && (self.asks_moment(test) || self.tells_time(test));
                    let sources = waits.then(|| self.behind(test))?;
                    let told = self.put_off(test).or_else(|| self.begun_again(test));
                    let clocks: Vec<Place> = told.into_iter().collect();
                    let keeps_clock = !clocks.is_empty() || self.clocks(&sources).next().is_some();
                    keeps_clock.then_some(TimeGate { at, sources, clocks })
                }
                Effect::Call(site) if site.law_of.is_none() => {
                    let paced = site.targets.iter().filter_map(|target| self.search.summaries.get(*target));
                    let paced = paced.flat_map(|summary| &summary.paced);
                    let own = paced.filter(|(given, _)| place_of(given, site).is_some_and(|it| self.is_instance(&it)));
                    let clocks: Vec<Place> = own.flat_map(|(_, all)| all).filter_map(|it| place_of(it, site)).collect();
                    (!clocks.is_empty()).then(|| TimeGate { at, sources: Sources::default(), clocks })
                }
                _ => None,
            };
            self.nodes().filter_map(gate).collect()
        })
    }
}

/// A condition that waits for a time.
pub(super) struct TimeGate {
    /// The node that asks.
    at: NodeId,
    /// What it asks for is computed from.
    sources: Sources,
    /// The times that are kept for it otherwise.
    clocks: Vec<Place>,
}

/// The times that a function keeps for the time gates of its filter, as its callers know them.
pub(in crate::count) fn paced_by(search: &Search<'_>, ways: &[Outcome]) -> BTreeSet<Given> {
    if !ways.iter().any(|way| way.gate == Some(Gate::Time)) {
        return BTreeSet::new();
    }
    let gates = Gates::of_helper(search);
    let clocks = |gate: &TimeGate| -> Vec<Place> { gates.clocks(&gate.sources).chain(&gate.clocks).cloned().collect() };
    gates.time_gates().iter().flat_map(clocks).filter_map(|clock| given(search.graph, &clock)).collect()
}

/// Whether a place is named as a timer.
pub(super) fn names_timer(name: &str) -> bool {
    let name = name.to_lowercase();
    let parts = ["timer", "sleep", "delay", "ticker", "interval", "alarm", "countdown", "period", "systick"];
    parts.iter().any(|part| name.contains(part)) || is_numbered_timer(&name)
}

/// Whether a name in small letters is that of a hardware timer: `tim`, `tim2`.
fn is_numbered_timer(name: &str) -> bool {
    name.strip_prefix("tim").is_some_and(|number| number.bytes().all(|byte| byte.is_ascii_digit()))
}

/// Whether a type is named as a timer: a `DelayLine` is none.
fn is_timer_type(name: &str) -> bool {
    name.contains("Timer")
        || is_numbered_timer(&name.to_lowercase())
        || matches!(
            name,
            "Sleep"
                | "Delay"
                | "Ticker"
                | "Interval"
                | "Alarm"
                | "CountDown"
                | "Countdown"
                | "Stopwatch"
                | "SysTick"
                | "SYST"
        )
}

/// Whether a place is named as a point of time.
pub(super) fn is_moment_name(name: &str) -> bool {
    let name = name.trim_start_matches('_').to_lowercase();
    let next = name.strip_prefix("next_").unwrap_or_default();
    matches!(name.as_str(), "now" | "deadline" | "due" | "elapsed")
        || matches!(next, "tick" | "time" | "ms" | "us" | "run" | "wake" | "wakeup" | "update" | "poll" | "cycle")
        || ["now_", "next_due", "due_", "elapsed_", "deadline_"].iter().any(|part| name.starts_with(part))
        || name.ends_with("_deadline")
}

/// Whether a place is named as the time of the last step.
fn is_clock_name(name: &str) -> bool {
    ["last", "prev", "time", "stamp", "t0", "then", "previous", "tick"].iter().any(|part| name.contains(part))
}
