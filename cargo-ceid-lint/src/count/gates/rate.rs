//! Gates of rate: counters that are compared and set back, and remainders.

use super::signals::may_be_time;
use super::sources::{counts_shared, is_arithmetic};
use super::{Gates, Way, contains_any};
use crate::count::fed::named;
use crate::count::given::place_of;
use crate::count::search::Region;
use crate::count::verdict::Gate;
use crate::flow::{CallSite, ChangeKind, Computed, Effect, Head, NodeId, Place, Test, is_shared_number};
use crate::index::{FunctionId, Ty};

/// Parts of the names of functions that give the number of a cycle.
pub(super) const COUNTERS: &[&str] = &[
    "tick", "count", "cycle", "index", "seq", "iter", "frame", "step", "number", "load", "now", "milli", "micro",
    "time",
];

/// Parts of the names of functions that give a measured value.
const READINGS: &[&str] = &["adc", "sens", "measur"];

/// How a counter changes.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct CountSteps {
    /// It goes up by one step.
    pub(super) up: bool,
    /// It goes down by one step.
    pub(super) down: bool,
    /// It is set to a constant.
    pub(super) set_back: bool,
    /// It goes up by so much as was dealt with: `used += block.len()`.
    pub(super) sums: bool,
    /// It goes up by a fraction of a step, the same in all iterations: `phase += ratio`.
    pub(super) glides: bool,
    /// It goes round by itself.
    pub(super) wraps: bool,
    /// It changes in another way.
    pub(super) other: bool,
}

impl CountSteps {
    fn add(&mut self, change: ChangeKind, is_constant: bool, is_number: bool) {
        match change {
            ChangeKind::CountsUp | ChangeKind::CountsUpTo => self.up = true,
            ChangeKind::CountsDown | ChangeKind::CountsDownTo => self.down = true,
            ChangeKind::Wraps => self.wraps = true,
            ChangeKind::Accumulates if is_number => self.sums = true,
            ChangeKind::Constant => self.set_back = true,
            _ if is_constant => self.set_back = true,
            _ => self.other = true,
        }
    }

    /// Whether it only goes up, or only down.
    pub(super) fn is_one_way(self) -> bool {
        !self.other && !self.sums && self.up != self.down
    }
}

impl Gates<'_, '_> {
    /// A counter that is compared: set back or wrapped, it decimates; never set back, it counts a warm-up.
    pub(super) fn counter(&self, test: &Test, at: NodeId, way: &Way) -> Option<Gate> {
        self.asked(test).iter().find_map(|place| {
            if !self.outlives(place) {
                return None;
            }
            if self.turns_each_time(place) {
                return Some(Gate::Rate);
            }
            let steps = self.count_steps(place)?;
            if steps.glides && self.is_used_up(place, at, way) {
                return Some(Gate::Rate);
            }
            let counts = steps.up || steps.down;
            // What goes round with something else than the cycles opens the gate with that.
            if steps.wraps || (counts && (test.about.is_masked || self.asks_held_remainder(test, true))) {
                return self.counts_while_closed(place, at, way).then_some(Gate::Rate);
            }
            if !counts && !steps.sums {
                return None;
            }
            if counts && self.goes_round(place, at) && self.counts_while_closed(place, at, way) {
                return Some(Gate::Rate);
            }
            if steps.set_back && self.is_begun_anew_while_closed(place, at, way) {
                return self.is_warmed_up(test, at, place, way, steps).then_some(Gate::Startup);
            }
            if steps.set_back {
                // A count that begins anew in each cycle, or is given up by the skip, is of something else than cycles.
                let is_carried = self.carries(place, at);
                let is_given_up = way.nodes.iter().any(|id| self.is_set_back(*id, place));
                // What counts errors, or the cycles in which something was received, opens the gate with these.
                let counts_on = self.adds_up_while_closed(place, at, way) && self.counts_no_reading(place);
                let is_rate = is_carried && !is_given_up && counts_on && self.runs_out(place);
                return (is_rate && !self.is_held_off(place)).then_some(Gate::Rate);
            }
            if (steps.up || steps.sums) && self.is_used_up(place, at, way) && self.counts_no_reading(place) {
                return Some(Gate::Rate);
            }
            if steps.up && self.is_deadline(test, place, at, way) {
                return Some(Gate::Rate);
            }
            if self.comes_round_to(test, at, place, way) {
                return self.counts_while_closed(place, at, way).then_some(Gate::Rate);
            }
            if self.is_counted_up_to(test, at, place, way) {
                return Some(Gate::Startup);
            }
            self.is_warmed_up(test, at, place, way, steps).then_some(Gate::Startup)
        })
    }

    /// What a condition reads, and what the numbers of the iteration that it reads are reckoned from:
    /// `let left = self.next - self.count; if left <= 0 { … }`.
    pub(super) fn asked(&self, test: &Test) -> Vec<Place> {
        let mut asked = test.about.reads.clone();
        for place in &test.about.reads {
            let computed = place.base_var().and_then(|var| self.search.graph.computed.get(&var));
            let is_of_round = |_: &&Computed| place.steps.is_empty() && !self.outlives(place);
            let Some(computed) = computed.filter(is_of_round) else { continue };
            // A truth value has conditions behind it, each of which is asked for itself.
            if self.ty(place) == Some(Ty::Bool) && !self.asks_caller(&computed.places) {
                continue;
            }
            let mut given = self.assigning(place);
            let reads = |name: &String| is_arithmetic(name) || counts_shared(name);
            // A reading that is taken out of a buffer is no count, and neither is its number.
            let is_buffer = |place: &Place| self.ty(place).is_some_and(|ty| crate::types::item_of(ty.peel()).is_some());
            let is_reading = self.ty(place) == Some(Ty::Float) && computed.places.iter().any(is_buffer);
            if computed.calls.iter().all(reads) && given.next().is_some() && given.next().is_none() && !is_reading {
                asked.extend(named(&computed.places).into_iter().cloned());
            }
        }
        asked
    }

    /// Whether a count begins anew where its type ends, for it goes on whatever it has come to.
    pub(super) fn comes_round(&self, place: &Place) -> bool {
        let before = self.before_asking(place);
        let graph = self.search.graph;
        let goes_round = |id: &NodeId| graph.changes.get(id).is_some_and(|change| change.goes_round);
        self.assigning(place).filter(goes_round).any(|id| before[id.0 as usize])
    }

    /// Whether a comparison leads to no update where a number is below what it is compared with; `None` if the number is on
    /// neither side by itself.
    pub(super) fn waits_below(&self, test: &Test, at: NodeId, place: &Place) -> Option<bool> {
        let side = test.about.compared.iter().position(|side| side.as_ref() == Some(place))?;
        // A comparison of whole numbers is turned so that it asks for less, if anything is known of both sides.
        test.subject.filter(|_| self.is_number(place))?;
        let below = self.search.graph.node(at).next.get(side)?;
        Some(!self.reach()[below.0 as usize])
    }

    /// `for tick in 0.. { if tick & 7 == 0 { … } }`: the low bits of the number of the round are its remainder.
    pub(super) fn masks_rounds(&self, test: &Test) -> bool {
        let Region::Loop(own) = self.region else { return false };
        let info = self.search.graph.loop_info(own);
        let counter = info.counter.map(|(counter, _)| Place::var(counter));
        let is_low = test.about.ratio.is_some_and(u64::is_power_of_two);
        test.about.is_masked && is_low && counter.is_some_and(|counter| test.about.reads == [counter])
    }

    /// How a place changes in the region, if it is a counter; `None` if nothing changes it.
    pub(super) fn count_steps(&self, place: &Place) -> Option<CountSteps> {
        let mut steps = CountSteps::default();
        let mut changes = false;
        let is_number = self.is_number(place);
        for id in self.nodes() {
            match &self.search.graph.node(id).effect {
                Effect::Write(write) | Effect::Set(write) if write.place == *place && !self.names_element(id) => {
                    changes = true;
                    steps.glides |= !is_number && self.goes_on_by_setting(id);
                    match self.change(id) {
                        None if write.head.is_some() => steps.set_back = true,
                        Some(ChangeKind::Other) if self.is_set_back(id, place) => steps.set_back = true,
                        change => steps.add(change.unwrap_or(ChangeKind::Other), write.head.is_some(), is_number),
                    }
                }
                Effect::Call(site) if self.call_writes(site, place) => {
                    changes = true;
                    let mut sets = self.sets_by(site, place).filter(|_| is_number).peekable();
                    // A helper that changes the counter in a way that is not seen counts.
                    steps.up |= sets.peek().is_none() && is_number;
                    sets.for_each(|(head, change)| steps.add(change, head.is_some(), is_number));
                }
                _ => {}
            }
        }
        changes.then_some(steps)
    }

    /// Whether nothing is added to a count but steps, times, and how much there was of something: a reading is none of these.
    fn counts_no_reading(&self, place: &Place) -> bool {
        let graph = self.search.graph;
        let gives_float = |name: &String| {
            self.nodes().any(|id| match &graph.node(id).effect {
                Effect::Call(site) => {
                    let is_it = |target: &FunctionId| self.search.program.index.function(*target).name == *name;
                    matches!(graph.var(site.result).ty, Ty::Float) && site.targets.iter().any(is_it)
                }
                _ => false,
            })
        };
        let is_reading = |name: &String| !may_be_time(name) && (contains_any(name, READINGS) || gives_float(name));
        self.assigning(place).all(|id| {
            let change = graph.changes.get(&id).filter(|change| change.kind == ChangeKind::Accumulates);
            change.is_none_or(|change| !self.assignments().behind(&change.computed).calls.iter().any(is_reading))
        })
    }

    /// Whether an assignment adds what is the same in all iterations.
    pub(super) fn goes_on_by_setting(&self, id: NodeId) -> bool {
        let change = self.search.graph.changes.get(&id);
        change.is_some_and(|change| change.kind == ChangeKind::Accumulates && self.is_of_settings(&change.computed))
    }

    /// What a call sets a place to, with how that goes on from the value before.
    pub(super) fn sets_by<'b>(
        &'b self,
        site: &'b CallSite,
        place: &'b Place,
    ) -> impl Iterator<Item = (&'b Option<Head>, ChangeKind)> + 'b {
        let summaries = site.targets.iter().filter_map(|target| self.search.summaries.get(*target));
        let sets = summaries.flat_map(|summary| &summary.sets);
        sets.filter(|(given, ..)| place_of(given, site).is_some_and(|written| written == *place))
            .filter_map(|(_, head, change)| Some((head, (*change)?)))
    }

    /// Whether a place is turned round in each cycle, and changes in no other way.
    fn turns_each_time(&self, place: &Place) -> bool {
        let turns = |id: NodeId| {
            self.search.graph.changes.get(&id).is_some_and(|change| change.kind == ChangeKind::Toggles)
                && self.assigns(id, place)
        };
        self.assigning(place).next().is_some()
            && self.assigning(place).all(turns)
            && !self.calls_write(place)
            && !self.completes(self.start(), |node, _| !turns(node))
    }

    pub(super) fn counts_at(&self, id: NodeId, place: &Place) -> bool {
        match &self.search.graph.node(id).effect {
            Effect::Call(site) => self.call_writes(site, place),
            _ => {
                self.assigns(id, place)
                    && self
                        .search
                        .graph
                        .changes
                        .get(&id)
                        .is_some_and(|change| change.kind.counts() || change.kind == ChangeKind::Wraps)
            }
        }
    }

    /// Whether every iteration counts that comes to a branch and goes on from there as a way does, or starts anew where the count
    /// has run out.
    pub(super) fn counts_while_closed(&self, place: &Place, at: NodeId, way: &Way) -> bool {
        self.goes_on_while_closed(place, at, way, &|node| self.counts_at(node, place))
    }

    /// The same for what may add up how much there was of something, or count the samples that feed the filter.
    fn adds_up_while_closed(&self, place: &Place, at: NodeId, way: &Way) -> bool {
        let adds = |node: NodeId| self.assigns(node, place) && self.change(node) == Some(ChangeKind::Accumulates);
        // A setting that stops the count for good is one that stops the filter.
        let lacks = |node: NodeId| match &self.search.graph.node(node).effect {
            Effect::Branch(test) => {
                let is_sample = test.about.asks_presence() && self.feeds_sample(test);
                is_sample || test.subject.is_some() && self.is_unchanging(test)
            }
            _ => false,
        };
        self.goes_on_while_closed(place, at, way, &|node| self.counts_at(node, place) || adds(node) || lacks(node))
    }

    fn goes_on_while_closed(&self, place: &Place, at: NodeId, way: &Way, counts: &dyn Fn(NodeId) -> bool) -> bool {
        let before = self.before_asking(place);
        let starts_anew = |node: NodeId| self.is_set_back(node, place) && !before[node.0 as usize];
        let goes_by = |node: NodeId, _: usize| !counts(node) && !starts_anew(node);
        !self.reached(goes_by)[at.0 as usize] || !way.after(at).is_some_and(|next| self.completes(next, goes_by))
    }

    /// The nodes that an iteration reaches without asking a place.
    pub(super) fn before_asking(&self, place: &Place) -> Vec<bool> {
        self.reached(|node, _| {
            !matches!(&self.search.graph.node(node).effect, Effect::Branch(test) if self.asked(test).contains(place))
        })
    }

    /// Whether what a counter has run up to is taken from it behind a branch, and nowhere else: `if n >= FULL { n -= FULL; … }`.
    fn is_used_up(&self, place: &Place, at: NodeId, way: &Way) -> bool {
        let lowers = |id: &NodeId| matches!(self.change(*id), Some(ChangeKind::CountsDown | ChangeKind::Spends));
        self.are_only_behind(self.assigning(place).filter(lowers), at, way)
    }

    /// Whether a count is compared with one that is put off behind the branch, and nowhere else: `if n >= next { next += FULL; … }`.
    fn is_deadline(&self, test: &Test, place: &Place, at: NodeId, way: &Way) -> bool {
        let puts_off = |id: NodeId| {
            matches!(self.change(id), Some(ChangeKind::CountsUp | ChangeKind::Accumulates | ChangeKind::Other))
        };
        test.about.compared.contains(&Some(place.clone()))
            && test.about.compared.iter().flatten().any(|other| {
                other != place
                    && self.outlives(other)
                    && self.assigning(other).all(puts_off)
                    && self.are_only_behind(self.assigning(other), at, way)
            })
    }

    /// Whether there are such nodes, and all are reached through a branch only, where the way does not go.
    fn are_only_behind(&self, nodes: impl Iterator<Item = NodeId>, at: NodeId, way: &Way) -> bool {
        let elsewhere = self.reached(|node, _| node != at);
        let mut nodes = nodes.peekable();
        nodes.peek().is_some() && nodes.all(|id| !elsewhere[id.0 as usize] && !way.nodes.contains(&id))
    }

    pub(super) fn change(&self, id: NodeId) -> Option<ChangeKind> {
        self.search.graph.changes.get(&id).map(|change| change.kind)
    }

    pub(super) fn is_number(&self, place: &Place) -> bool {
        self.ty(place).is_some_and(|ty| *ty.peel() == Ty::Int || is_shared_number(&ty))
    }

    /// Whether a place is set to a constant, or to what is the same in all iterations.
    pub(super) fn is_set_back(&self, id: NodeId, place: &Place) -> bool {
        match &self.search.graph.node(id).effect {
            Effect::Write(write) | Effect::Set(write) if write.place == *place => {
                let change = self.search.graph.changes.get(&id);
                write.head.is_some()
                    || change.is_some_and(|change| match change.kind {
                        ChangeKind::Constant => true,
                        ChangeKind::Other => self.is_number(place) && self.is_of_settings(&change.computed),
                        _ => false,
                    })
            }
            _ => false,
        }
    }

    /// Whether a value is computed from nothing but settings: `self.left = self.ratio - 1`.
    fn is_of_settings(&self, computed: &Computed) -> bool {
        let places = named(&computed.places);
        !places.is_empty()
            && places.into_iter().all(|place| self.is_setting(place))
            && computed.calls.iter().all(|name| is_arithmetic(name))
    }

    /// Whether the value of an iteration before can still be there at a node.
    fn carries(&self, place: &Place, at: NodeId) -> bool {
        self.reached(|node, _| !self.is_set_back(node, place))[at.0 as usize]
    }

    /// Whether all that a remainder is of are numbers which no way past the update changes: the gate never opens again.
    pub(super) fn stands_still(&self, test: &Test, at: NodeId, way: &Way) -> bool {
        let graph = self.search.graph;
        // What else a cycle function is called for may count, and so may an interrupt.
        if matches!(self.region, Region::Function) && !self.is_helper {
            return false;
        }
        let sources = self.behind(test);
        let may_change = |place: &Place| {
            let is_bound = place.base_var().is_none_or(|var| {
                let mut loops = graph.loops.iter();
                loops.any(|info| info.bound.contains(&var) || info.counter.is_some_and(|(counter, _)| counter == var))
            });
            // A number that a helper is called with is another one each time.
            is_bound || !self.outlives(place) || (self.is_helper && place.steps.is_empty())
        };
        let closed = || {
            self.reached(|node, edge| {
                let next = graph.node(node).next[edge];
                (node != at && node != way.at) || way.after(node).is_none_or(|after| after == next)
            })
        };
        let mut counters = sources.places.iter().filter(|place| self.is_number(place)).peekable();
        counters.peek().is_some() && sources.calls.iter().all(|name| is_arithmetic(name)) && {
            let closed = closed();
            counters.all(|place| !may_change(place) && !self.changes_in(place, |id| closed[id.0 as usize]))
        }
    }

    /// Whether one of these nodes may change a place.
    pub(super) fn changes_in(&self, place: &Place, is_asked: impl Fn(NodeId) -> bool) -> bool {
        let overlaps = |written: &Place| {
            written.overlaps(place) || self.search.aliases.shared_roots(written).iter().any(|root| root.overlaps(place))
        };
        self.nodes().filter(|id| is_asked(*id)).any(|id| match &self.search.graph.node(id).effect {
            Effect::Write(write) | Effect::Set(write) => overlaps(&write.place),
            Effect::Call(site) => self.call_writes(site, place),
            Effect::Unknown { places, .. } => places.iter().any(overlaps),
            _ => false,
        })
    }

    /// Whether what a remainder is of counts the cycles, as far as it is counted here: not the errors, nor the samples of another.
    pub(super) fn goes_on_counting(&self, test: &Test, at: NodeId, way: &Way) -> bool {
        let sources = self.behind(test);
        let is_counted = |place: &Place| self.nodes().any(|id| self.counts_at(id, place));
        let counters: Vec<&Place> =
            sources.places.iter().filter(|place| self.is_number(place) && self.outlives(place)).collect();
        // What each iteration sets counts nothing.
        if counters.iter().any(|place| self.is_always_set_back(place, at)) {
            return false;
        }
        let counters = counters.into_iter();
        let mut counted = counters.filter(|place| is_counted(place)).peekable();
        counted.peek().is_none() || counted.any(|place| self.counts_while_closed(place, at, way))
    }

    /// Whether the remainder that is compared is that of something that counts, or tells the time; not of a reading.
    pub(super) fn remainder_counts(&self, test: &Test, at: NodeId) -> bool {
        let graph = self.search.graph;
        let sources = self.behind(test);
        let counts = sources.places.iter().any(|place| {
            let is_counter = graph.loops.iter().any(|info| {
                info.counter.is_some_and(|(counter, _)| Some(counter) == place.base_var())
                    || place.base_var().is_some_and(|var| info.bound.contains(&var))
            });
            is_counter || (self.is_number(place) && self.outlives(place) && !self.is_given_anew(place, at))
        });
        let is_told =
            |name: &String| contains_any(name, COUNTERS) || matches!(name.as_str(), "fetch_add" | "fetch_sub");
        let is_reckoned = sources.calls.iter().all(|name| is_arithmetic(name))
            && !sources.places.iter().any(|place| self.is_number(place) && self.is_given_anew(place, at));
        // What it has to be is no number of a cycle: `n % 10 == reading`.
        let is_read = |place: &Place| {
            let computed = place.base_var().and_then(|var| graph.computed.get(&var));
            !self.outlives(place) && computed.is_some_and(|from| from.calls.iter().any(|name| !is_arithmetic(name)))
        };
        let is_drawn = |place: &Place| self.is_given_anew(place, at) || is_read(place);
        let is_drawn = test.about.remainder_is.as_ref().is_some_and(is_drawn);
        !is_drawn && (counts || sources.calls.iter().any(is_told) || is_reckoned || self.is_told_by_counter(test))
    }

    /// Whether a variable is asked that holds a remainder: `let slot = n % 10; if slot == 3 { … }`.
    pub(super) fn asks_held_remainder(&self, test: &Test, is_masked: bool) -> bool {
        let remainders = &self.search.graph.remainders;
        let is_held = |place: &Place| place.base_var().and_then(|var| remainders.get(&var)) == Some(&is_masked);
        let numbers = test.about.reads.iter().filter(|place| place.base_var().is_some());
        numbers.clone().next().is_some() && numbers.clone().all(is_held)
    }

    /// Whether a place has another value than that of the round before at a node, and not one that is counted from it.
    pub(super) fn is_given_anew(&self, place: &Place, at: NodeId) -> bool {
        let is_given = |id: NodeId| {
            match &self.search.graph.node(id).effect {
                // Where a helper has a number of cycles from, only its name tells.
                Effect::Call(site) => {
                    !contains_any(&self.last_name(place), COUNTERS)
                        && self.sets_by(site, place).any(|(_, change)| change == ChangeKind::Other)
                }
                _ => self.assigns(id, place) && self.change(id) == Some(ChangeKind::Other),
            }
        };
        !self.reached(|node, _| !is_given(node))[at.0 as usize]
    }

    /// Whether a rate gate opens in one of so many cycles, as far as its condition tells: a counter is compared with the ratio, or
    /// with its last number, where it counts behind the condition.
    pub(super) fn has_ratio(&self, test: &Test, at: NodeId, ratio: u64) -> bool {
        if let Some(own) = test.about.ratio {
            return own == ratio;
        }
        if let Some(period) = self.search.period(self.region, test) {
            return period == ratio;
        }
        let known: Vec<u64> = test.about.numbers.iter().copied().filter(|number| *number > 0).collect();
        let is_exact = || test.about.reads.iter().any(|place| self.counts_from_zero(place, at));
        known.is_empty() || known.contains(&ratio) || known.iter().any(|number| number + 1 == ratio) && !is_exact()
    }

    /// Whether a counter goes up before each question for it, and begins again with 0: then it is as high as there were cycles.
    fn counts_from_zero(&self, place: &Place, at: NodeId) -> bool {
        let begins = |id: NodeId| match &self.search.graph.node(id).effect {
            Effect::Write(write) | Effect::Set(write) => write.head.as_deref() == Some("0"),
            _ => false,
        };
        let counts = |id: &NodeId| self.change(*id) == Some(ChangeKind::CountsUp);
        let steps = self.count_steps(place).unwrap_or_default();
        let is_plain = steps.up && steps.set_back && !(steps.down || steps.wraps || steps.sums || steps.other);
        is_plain
            && self.assigning(place).all(|id| counts(&id) || begins(id))
            && !self.calls_write(place)
            && !self.reached(|node, _| !self.counts_at(node, place))[at.0 as usize]
    }
}
