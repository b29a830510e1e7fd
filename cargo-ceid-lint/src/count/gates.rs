//! Conditions that skip an update on purpose, and what tells them from defects.

use super::search::{End, Exploration, Region, Search};
use super::verdict::Gate;
use crate::flow::{Effect, LoopId, NodeId, Place, Test, Var};

/// Why a way does not update, if it does so on purpose; `None` for a way that updates, or that nothing explains.
pub(super) fn of_end(search: &Search<'_>, region: Region, exploration: &Exploration, end: &End) -> Option<Gate> {
    if end.state.count != super::counts::Count::Zero || end.state.reset {
        return None;
    }
    let at = end.state.skipped_at?;
    let gates = Gates { search, region };
    let gate = match &search.graph.node(at).effect {
        Effect::Branch(test) => gates.of_test(test, at),
        Effect::Call(_) => end.state.helper_gate,
        Effect::LoopHead(id) => gates.of_loop(*id),
        _ => None,
    };
    let gate = gate.or_else(|| gates.of_payload(exploration, end)).or_else(|| gates.measured(exploration, end))?;
    if gate == Gate::Measured {
        return Some(gate);
    }
    // A clock that runs on while the filter stands still loses time, whatever the gate.
    if !matches!(gate, Gate::Time | Gate::Config | Gate::Startup) && gates.advances_clock(exploration, end, at) {
        return None;
    }
    Some(gate)
}

struct Gates<'s, 'a> {
    search: &'s Search<'a>,
    region: Region,
}

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

/// Parts of the names of methods that ask whether a sample is there.
const READINESS: &[&str] = &[
    "ready",
    "available",
    "has_",
    "is_new",
    "pending",
    "fresh",
    "new_",
    "updated",
    "data",
    "drdy",
    "can_read",
    "poll",
];

/// Names of methods that receive a message or an event.
const EVENTS: &[&str] = &[
    "recv",
    "receive",
    "try_recv",
    "try_receive",
    "recv_timeout",
    "next_event",
    "wait_event",
    "poll_event",
    "pop",
    "pop_front",
    "dequeue",
    "select",
    "select3",
    "select4",
    "next_message",
    "read_event",
    "get_event",
    "try_next",
];

impl Gates<'_, '_> {
    fn of_test(&self, test: &Test, at: NodeId) -> Option<Gate> {
        let about = &test.about;
        if about.is_constant {
            return Some(Gate::Config);
        }
        if about.is_event {
            return Some(Gate::Event);
        }
        if about.is_remainder {
            return Some(Gate::Rate);
        }
        if about.is_presence && self.is_presence_of_filter(test) {
            return Some(Gate::Config);
        }
        if about.is_presence && self.feeds_sample(test) {
            return Some(Gate::Sample);
        }
        if self.is_event(test) {
            return Some(Gate::Event);
        }
        if !about.is_presence
            && let Some(gate) = self.counter(test)
        {
            return Some(gate);
        }
        if self.tells_time(test) {
            return Some(Gate::Time);
        }
        if self.is_readiness(test) {
            return Some(Gate::Sample);
        }
        if self.is_latch(test, at) {
            return Some(Gate::Startup);
        }
        if test.subject.is_some() && self.is_unchanging(test, at) {
            return Some(Gate::Config);
        }
        if self.is_mode(test, at) {
            return Some(Gate::Mode);
        }
        None
    }

    /// An inner loop that may have no round: over samples that are there or not.
    fn of_loop(&self, id: LoopId) -> Option<Gate> {
        let info = self.search.graph.loop_info(id);
        let feeds = self.fed().any(|var| self.search.aliases.is_derived(var, &info.bound));
        (info.drains || feeds).then_some(Gate::Sample)
    }

    /// The nodes of the region.
    fn nodes(&self) -> impl Iterator<Item = NodeId> + '_ {
        let graph = self.search.graph;
        graph.node_ids().filter(move |id| match self.region {
            Region::Function => true,
            Region::Loop(own) => graph.is_within(graph.node(*id).in_loop, own),
        })
    }

    /// The variables that are fed to the instance: by its law, or by another method of it.
    fn fed(&self) -> impl Iterator<Item = Var> + '_ {
        self.nodes().flat_map(move |id| match &self.search.graph.node(id).effect {
            Effect::Update(update) if self.is_instance(&update.place) => update.fed.clone(),
            Effect::Call(site) if self.concerns(site) => site.fed.clone(),
            Effect::Write(write) if self.is_part(&write.place) => {
                let computed = write.place.base_var().and_then(|var| self.search.graph.computed.get(&var));
                let places = computed.map(|computed| &computed.places[..]).unwrap_or_default();
                places.iter().filter_map(Place::base_var).filter(|var| Some(*var) != write.place.base_var()).collect()
            }
            _ => Vec::new(),
        })
    }

    /// The places that what is fed to the instance is computed from.
    fn fed_places(&self) -> Vec<Place> {
        let graph = self.search.graph;
        let mut places = Vec::new();
        for id in self.nodes() {
            match &graph.node(id).effect {
                Effect::Update(update) if self.is_instance(&update.place) => {
                    places.extend(update.from.places.iter().cloned())
                }
                Effect::Call(site) if self.concerns(site) => places.extend(site.from.places.iter().cloned()),
                _ => {}
            }
        }
        let mut at = 0;
        while at < places.len() && places.len() < 256 {
            if let Some(var) = places[at].base_var()
                && places[at].steps.is_empty()
                && let Some(computed) = graph.computed.get(&var)
            {
                for place in &computed.places {
                    if !places.contains(place) {
                        places.push(place.clone());
                    }
                }
            }
            at += 1;
        }
        places
    }

    fn is_instance(&self, place: &Place) -> bool {
        self.search.aliases.roots(place).iter().any(|root| root.overlaps(self.search.instance))
    }

    fn is_part(&self, place: &Place) -> bool {
        self.search
            .aliases
            .roots(place)
            .iter()
            .any(|root| root.overlaps(self.search.instance) && root.steps.len() > self.search.instance.steps.len())
    }

    fn concerns(&self, site: &crate::flow::CallSite) -> bool {
        site.args.iter().filter_map(|arg| arg.place.as_ref()).any(|place| self.is_instance(place))
    }

    /// A choice on a value that was received in this iteration, or on the event that a handler is called with.
    fn is_event(&self, test: &Test) -> bool {
        let graph = self.search.graph;
        if test.about.heads.is_empty() || test.about.is_presence {
            return false;
        }
        test.about.reads.iter().any(|place| {
            let Some(var) = place.base_var() else { return false };
            let received = graph
                .computed
                .get(&var)
                .is_some_and(|computed| computed.calls.iter().any(|name| EVENTS.contains(&name.as_str())));
            let inside = match self.region {
                Region::Loop(own) => graph.is_within(graph.var(var).in_loop, own),
                Region::Function => true,
            };
            let info = graph.var(var);
            let is_event_parameter = self.region == Region::Function
                && info.param.is_some()
                && info.name != "self"
                && matches!(info.ty.peel(), crate::index::Ty::Adt(..));
            (received && inside) || is_event_parameter
        })
    }

    /// Whether what is present or absent is the filter itself.
    fn is_presence_of_filter(&self, test: &Test) -> bool {
        let by_name = test.about.binds.iter().any(|var| self.is_instance(&Place::var(*var)));
        let by_place = test
            .about
            .reads
            .iter()
            .any(|place| self.search.aliases.roots(place).iter().any(|root| root == self.search.instance));
        by_name || by_place
    }

    /// Whether every value that may be absent feeds this filter.
    fn feeds_sample(&self, test: &Test) -> bool {
        let aliases = self.search.aliases;
        let fed: Vec<Var> = self.fed().collect();
        let binds: Vec<Var> = if test.about.binds.is_empty() {
            // `x.is_some()`, `x?`: the variable that is asked, or what the call's result goes into.
            let graph = self.search.graph;
            let asked: Vec<Var> =
                test.about.reads.iter().filter(|place| place.steps.is_empty()).filter_map(Place::base_var).collect();
            let into = graph.computed.iter().filter(|(_, computed)| {
                !computed.calls.is_empty()
                    && test.about.names.iter().all(|name| computed.calls.contains(name) || is_question(name))
                    && test.about.reads.iter().all(|place| computed.places.contains(place))
                    && !test.about.reads.is_empty()
            });
            let into: Vec<Var> = into.map(|(var, _)| *var).collect();
            if into.is_empty() { asked } else { into }
        } else {
            test.about.binds.clone()
        };
        let direct = self.nodes().any(|id| match &self.search.graph.node(id).effect {
            // `f.update(imu.read()?)`
            Effect::Update(update) if self.is_instance(&update.place) => {
                let names = &test.about.names;
                !names.is_empty() && names.iter().all(|name| update.from.calls.contains(name) || is_question(name))
            }
            _ => false,
        });
        direct || binds.iter().any(|bind| fed.iter().any(|var| aliases.is_derived(*var, &[*bind])))
    }

    /// A readiness test of the very object that the fed sample is read from.
    fn is_readiness(&self, test: &Test) -> bool {
        let asks = test.about.names.iter().any(|name| READINESS.iter().any(|part| name.contains(part)));
        if test.about.is_comparison || test.about.is_presence || !asks {
            return false;
        }
        let fed = self.fed_places();
        test.about.reads.iter().any(|place| {
            let whole_self =
                place.steps.is_empty() && place.base_var().is_some_and(|var| self.search.graph.var(var).name == "self");
            !whole_self && fed.iter().any(|other| other == place)
        })
    }

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

    fn tells_time(&self, test: &Test) -> bool {
        let graph = self.search.graph;
        let is_clock = |name: &str| CLOCKS.contains(&name);
        if test.about.names.iter().any(|name| is_clock(name)) || self.is_timer_poll(test) {
            return true;
        }
        if !test.about.is_comparison {
            return false;
        }
        test.about.reads.iter().any(|place| {
            let typed = super::instances::place_ty(self.search.program.index, graph, place);
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
    fn counter(&self, test: &Test) -> Option<Gate> {
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

    /// A truth value or option that is set once and never taken back.
    fn is_latch(&self, test: &Test, at: NodeId) -> bool {
        let graph = self.search.graph;
        let [place] = test.about.reads.as_slice() else { return false };
        let mut heads: Vec<&str> = Vec::new();
        for id in self.nodes() {
            if let Effect::Write(write) | Effect::Set(write) = &graph.node(id).effect
                && write.place == *place
            {
                match &write.head {
                    Some(head) => heads.push(head),
                    None => return false,
                }
            }
        }
        let written_elsewhere = self.calls_write(place);
        // What is set opens the way to the update; a latch that closes it for good is no start-up.
        let opens = self.updating_heads(test, at);
        !heads.is_empty()
            && heads.iter().all(|head| *head == heads[0])
            && opens.iter().any(|head| head == heads[0])
            && !written_elsewhere
    }

    fn calls_write(&self, place: &Place) -> bool {
        let graph = self.search.graph;
        self.nodes().any(|id| match &graph.node(id).effect {
            Effect::Call(site) => self.call_writes(site, place),
            Effect::Unknown { places, .. } => places.iter().any(|other| other.overlaps(place)),
            _ => false,
        })
    }

    /// Whether nothing in the cycle changes what the condition reads.
    fn is_unchanging(&self, test: &Test, at: NodeId) -> bool {
        let graph = self.search.graph;
        let _ = at;
        !test.about.reads.is_empty()
            && test.about.reads.iter().all(|place| {
                let declared_inside = match (self.region, place.base_var()) {
                    (Region::Loop(own), Some(var)) => graph.is_within(graph.var(var).in_loop, own),
                    (Region::Function, Some(var)) => graph.var(var).param.is_none() || place.steps.is_empty(),
                    (_, None) => true,
                };
                let written = self.nodes().any(|id| match &graph.node(id).effect {
                    Effect::Write(write) | Effect::Set(write) => write.place.overlaps(place),
                    _ => false,
                });
                let is_param = place.steps.is_empty()
                    && place.base_var().is_some_and(|var| graph.var(var).param.is_some())
                    && self.region == Region::Function;
                !declared_inside && !written && !is_param && !self.calls_write(place) && !self.written_by_others(place)
            })
    }

    /// A state every transition into which, or out of which, goes with a reset of the filter.
    fn is_mode(&self, test: &Test, at: NodeId) -> bool {
        let graph = self.search.graph;
        let Some(subject) = test.subject.map(|id| &graph.subjects[id.0 as usize]) else { return false };
        let Some(place) = &subject.whole else { return false };
        let heads = self.updating_heads(test, at);
        let before = self.before_updates();
        let mut enters: Vec<NodeId> = Vec::new();
        let mut leaves: Vec<NodeId> = Vec::new();
        for id in self.nodes() {
            match &graph.node(id).effect {
                Effect::Write(write) | Effect::Set(write) if write.place == *place => {
                    for (node, head) in self.values_of(id, write, 0) {
                        // A state that is given once more is no transition.
                        let is_before = before[node.0 as usize];
                        match head {
                            Some(head) if heads.contains(&head) => enters.extend(is_before.then_some(node)),
                            Some(_) => leaves.extend((!is_before).then_some(node)),
                            None => return false,
                        }
                    }
                }
                // A helper that switches the state may do so either way.
                Effect::Call(site) if self.call_writes(site, place) => {
                    enters.push(id);
                    leaves.push(id);
                }
                Effect::Unknown { places, .. } if places.iter().any(|other| other.overlaps(place)) => return false,
                _ => {}
            }
        }
        let with_reset = |nodes: &[NodeId]| !nodes.is_empty() && nodes.iter().all(|node| self.is_reset_beside(*node));
        with_reset(&enters) || with_reset(&leaves)
    }

    /// The nodes that an iteration can reach without an update.
    fn before_updates(&self) -> Vec<bool> {
        let graph = self.search.graph;
        let updating = self.search.updating();
        let start = match self.region {
            Region::Function => NodeId(0),
            Region::Loop(own) => graph.loop_info(own).head,
        };
        let mut reached = vec![false; graph.nodes.len()];
        let mut open = vec![start];
        while let Some(id) = open.pop() {
            if std::mem::replace(&mut reached[id.0 as usize], true) || updating.contains(&id) {
                continue;
            }
            open.extend(graph.node(id).next.iter().filter(|next| **next != start).copied());
        }
        reached
    }

    /// The constants that an assignment may give, with the nodes at which they are chosen; `None` for one that is not constant.
    fn values_of(&self, node: NodeId, set: &crate::flow::Assignment, links: u32) -> Vec<(NodeId, Option<String>)> {
        if set.head.is_some() || links > 8 {
            return vec![(node, set.head.clone())];
        }
        let Some(from) = set.same_as else { return vec![(node, None)] };
        let graph = self.search.graph;
        let mut values = Vec::new();
        for id in self.nodes() {
            if let Effect::Set(inner) = &graph.node(id).effect
                && inner.place == Place::var(from)
            {
                values.extend(self.values_of(id, inner, links + 1));
            }
        }
        // A state that is given to itself is no transition.
        if values.is_empty() { vec![(node, None)] } else { values }
    }

    fn call_writes(&self, site: &crate::flow::CallSite, place: &Place) -> bool {
        site.targets.iter().any(|target| {
            self.search.summaries.get(*target).is_some_and(|summary| {
                summary
                    .writes
                    .iter()
                    .any(|given| super::summary::place_of(given, site).is_some_and(|written| written.overlaps(place)))
            })
        })
    }

    /// The heads of the subject with which an update can still be reached behind a branch.
    fn updating_heads(&self, test: &Test, at: NodeId) -> Vec<String> {
        let graph = self.search.graph;
        let reach = self.search.reach(self.region);
        let Some(subject) = test.subject.map(|id| &graph.subjects[id.0 as usize]) else { return Vec::new() };
        let holds = graph.node(at).next.first().is_some_and(|next| reach[next.0 as usize]);
        let mask = if holds { test.holds } else { test.fails };
        let listed = subject.heads.iter().enumerate().filter(|(number, _)| mask & (1 << number) != 0);
        listed.map(|(_, head)| head.clone()).collect()
    }

    /// Whether a full reset of the instance runs on every way through a node: in the straight line before or behind it.
    fn is_reset_beside(&self, node: NodeId) -> bool {
        let graph = self.search.graph;
        let resets = |id: NodeId| match &graph.node(id).effect {
            Effect::Reset { place, full } => *full && self.is_instance(place),
            Effect::Write(write) if !write.rebinds => self.search.aliases.roots(&write.place).iter().any(|root| {
                root.base == self.search.instance.base
                    && root.steps.len() <= self.search.instance.steps.len()
                    && root.overlaps(self.search.instance)
            }),
            Effect::Call(site) => {
                site.targets.iter().all(|target| {
                    self.search.summaries.get(*target).is_some_and(|summary| {
                        summary.outcomes.iter().any(|(given, outcomes)| {
                            outcomes.iter().all(|outcome| outcome.reset)
                                && super::summary::place_of(given, site).is_some_and(|place| self.is_instance(&place))
                        })
                    })
                }) && !site.targets.is_empty()
            }
            _ => false,
        };
        if resets(node) {
            return true;
        }
        let mut parts: Vec<Place> = Vec::new();
        let mut at = node;
        for _ in 0..64 {
            let [next] = graph.node(at).next.as_slice() else { break };
            if resets(*next) {
                return true;
            }
            parts.extend(self.written_part(*next));
            at = *next;
        }
        let mut at = node;
        for _ in 0..64 {
            let before: Vec<NodeId> = graph.node_ids().filter(|id| graph.node(*id).next.contains(&at)).collect();
            let [only] = before.as_slice() else { break };
            if graph.node(*only).next.len() > 1 {
                break;
            }
            if resets(*only) {
                return true;
            }
            parts.extend(self.written_part(*only));
            at = *only;
        }
        self.is_whole_state(&parts)
    }

    /// The part of the instance's state that a node writes.
    fn written_part(&self, node: NodeId) -> Option<Place> {
        match &self.search.graph.node(node).effect {
            Effect::Write(write) | Effect::Set(write) if self.is_part(&write.place) => {
                self.search.aliases.roots(&write.place).into_iter().find(|root| root.overlaps(self.search.instance))
            }
            _ => None,
        }
    }

    /// Whether these parts are everything that the law changes.
    fn is_whole_state(&self, parts: &[Place]) -> bool {
        let instance = self.search.instance;
        let laws = self.nodes().filter_map(|id| match &self.search.graph.node(id).effect {
            Effect::Call(site) if site.is_law && self.concerns(site) => Some(&site.targets),
            _ => None,
        });
        let mut state: Vec<crate::flow::Projection> = Vec::new();
        for summary in laws.flatten().filter_map(|target| self.search.summaries.get(*target)) {
            for given in &summary.writes {
                if given.base == super::summary::GivenBase::Param(0) {
                    state.extend(given.steps.first().cloned());
                }
            }
        }
        !state.is_empty()
            && state.iter().all(|step| parts.iter().any(|part| part.steps.get(instance.steps.len()) == Some(step)))
    }

    /// Whether another function writes the same field: a mode that is switched elsewhere.
    fn written_by_others(&self, place: &Place) -> bool {
        let is_field =
            !place.steps.is_empty() && place.base_var().is_some_and(|var| self.search.graph.var(var).param.is_some());
        is_field && self.region == Region::Function
    }

    /// A filter that lies in a variant is there only while the enum is that variant.
    fn of_payload(&self, exploration: &Exploration, end: &End) -> Option<Gate> {
        let graph = self.search.graph;
        let instance = self.search.instance;
        let asked = exploration.path(end.at).iter().find_map(|at| {
            let Effect::Branch(test) = &graph.node(exploration.states[*at].node).effect else { return None };
            test.about.reads.iter().flat_map(|place| self.search.aliases.roots(place)).find(|root| {
                root.base == instance.base
                    && root.steps.len() < instance.steps.len()
                    && root.steps[..] == instance.steps[..root.steps.len()]
                    && self.is_variant_step(root)
            })
        })?;
        let changes = self.nodes().any(|id| match &graph.node(id).effect {
            Effect::Write(write) | Effect::Set(write) => write.place == asked,
            _ => false,
        });
        Some(if changes { Gate::Mode } else { Gate::Config })
    }

    /// Whether the step of the instance behind a place names a variant.
    fn is_variant_step(&self, place: &Place) -> bool {
        let index = self.search.program.index;
        match super::instances::place_ty(index, self.search.graph, place) {
            Some(crate::index::Ty::Adt(id, _)) => matches!(index.type_def(id).shape, crate::index::Shape::Enum(_)),
            _ => false,
        }
    }

    /// The clock that the filter's step is computed from stands still on the way, so that the next step covers the gap.
    fn measured(&self, exploration: &Exploration, end: &End) -> Option<Gate> {
        let graph = self.search.graph;
        let path: Vec<NodeId> = exploration.path(end.at).iter().map(|at| exploration.states[*at].node).collect();
        let steps = self.fed_places();
        let tells_time = steps.iter().any(|place| {
            self.calls_behind(place).iter().any(|name| CLOCKS.contains(&name.as_str()))
                || matches!(
                    super::instances::place_ty(self.search.program.index, graph, place)
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
    fn outlives(&self, place: &Place) -> bool {
        let graph = self.search.graph;
        match (self.region, place.base_var()) {
            (Region::Loop(own), Some(var)) => !graph.is_within(graph.var(var).in_loop, own),
            (Region::Function, Some(var)) => graph.var(var).param.is_some(),
            (_, None) => true,
        }
    }

    /// Whether the way advances a clock that the gate or the filter's step is measured with.
    fn advances_clock(&self, exploration: &Exploration, end: &End, _at: NodeId) -> bool {
        let graph = self.search.graph;
        let steps = self.fed_places();
        exploration.path(end.at).iter().any(|at| {
            let node = graph.node(exploration.states[*at].node);
            let (Effect::Write(write) | Effect::Set(write)) = &node.effect else { return false };
            self.outlives(&write.place) && self.is_clock_name(&write.place) && steps.contains(&write.place)
        })
    }

    /// The last name of a place.
    fn last_name(&self, place: &Place) -> String {
        match place.steps.last() {
            Some(crate::flow::Projection::Field(name)) => name.to_string(),
            Some(crate::flow::Projection::Index(_)) => String::new(),
            None => place.base_var().map(|var| self.search.graph.var(var).name.clone()).unwrap_or_default(),
        }
    }

    /// Whether a place is named as the time of the last step.
    fn is_clock_name(&self, place: &Place) -> bool {
        let name = self.last_name(place);
        ["last", "prev", "time", "stamp", "t0", "then", "previous", "tick"].iter().any(|part| name.contains(part))
    }
}

fn is_question(name: &str) -> bool {
    matches!(name, "is_some" | "is_ok" | "is_none" | "is_err" | "ok" | "as_ref" | "as_mut" | "map_err" | "await")
}
