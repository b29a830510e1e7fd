//! Conditions that skip an update on purpose, and what tells them from defects.

mod absent;
mod arms;
mod around;
mod by_laws;
mod carried;
mod checked;
mod chosen;
mod counted;
mod elapsed;
mod elements;
mod event;
mod gathered;
mod helper;
mod kept;
mod keys;
mod latch;
mod lent;
mod locked;
mod mode;
mod near_miss;
mod other_part;
mod own;
mod parallel;
mod passed;
mod per_element;
mod rate;
mod reach;
mod reading;
mod ready;
mod recalled;
mod remembered;
mod resumed;
mod rotation;
mod rounds;
mod sample;
mod signals;
mod sources;
mod state;
mod step;
mod text;
mod time;
mod told;
mod warm_up;
mod way;
mod window;
mod writes;

use std::cell::{Cell, OnceCell, RefCell};
use std::collections::{BTreeMap, BTreeSet};

pub(super) use helper::Asks;
pub(super) use kept::KeptMode;
pub(super) use reading::is_received;
pub(super) use resumed::set_without_reset;
pub(super) use sample::fed_from;
use signals::Signals;
use sources::{Assignments, Sources, contains_any};
pub(super) use step::measured_by;
use time::TimeGate;
pub(super) use time::paced_by;
use way::Way;

use super::search::{End, Exploration, Region, Search};
use super::skips::counted_past;
use super::verdict::Gate;
use crate::config::TimeBase;
use crate::flow::{CallSite, Cause, Computed, Effect, Head, NodeId, Place, SubjectId, Test, Told};
use crate::syntax::CycleDirective;

/// What is asked of one filter in one cycle.
pub(super) struct Gates<'s, 'a> {
    pub(super) search: &'s Search<'a>,
    region: Region,
    assignments: OnceCell<Assignments<'a>>,
    fed: OnceCell<Sources>,
    step: OnceCell<Option<Sources>>,
    time_base: OnceCell<TimeBase>,
    /// See [`Self::is_mode_asked_by`].
    modes: RefCell<BTreeMap<(SubjectId, Option<NodeId>), bool>>,
    /// What was asked of filters that only their updates and resets change, and latches, with the heads that others may give those.
    own_states: RefCell<BTreeMap<Place, Vec<Head>>>,
    /// See [`Self::memories`].
    memories: OnceCell<Vec<SubjectId>>,
    /// See [`Self::of_remembered`].
    remembered: RefCell<BTreeMap<(SubjectId, u32), bool>>,
    /// Whether the cycle keeps a time in a place.
    kept_times: RefCell<BTreeMap<Place, bool>>,
    signals: Signals,
    /// See [`Self::updating`].
    updating: RefCell<BTreeMap<SubjectId, Option<u32>>>,
    inside: OnceCell<Vec<NodeId>>,
    /// See [`Self::calls_write`].
    written: OnceCell<BTreeSet<Place>>,
    reach: OnceCell<Vec<bool>>,
    /// See [`Self::around`].
    around: OnceCell<Vec<Self>>,
    /// Why what was taken for a setting is none, see [`Self::is_written_between`].
    between: RefCell<Option<Cause>>,
    /// Whether a cycle around it loses its name, see [`Self::of_setting`].
    is_lost: Cell<bool>,
    /// See [`Self::resets`].
    resetting: RefCell<BTreeMap<NodeId, bool>>,
    time_gates: OnceCell<Vec<TimeGate>>,
    /// What the calls of the region answer, if that can be told.
    told: OnceCell<Vec<(NodeId, Told)>>,
    /// Whether the region is a function that a cycle calls, not one that is a cycle.
    is_helper: bool,
    /// Whether the region is a loop over elements, each of whose rounds stands for an iteration of its own element.
    is_of_element: bool,
}

/// How many truth values in between are followed to the condition that gave them.
const MAX_ORIGINS: u32 = 4;

impl<'s, 'a> Gates<'s, 'a> {
    pub(super) fn new(search: &'s Search<'a>, region: Region) -> Self {
        Self {
            search,
            region,
            assignments: OnceCell::new(),
            fed: OnceCell::new(),
            step: OnceCell::new(),
            time_base: OnceCell::new(),
            modes: RefCell::default(),
            own_states: RefCell::default(),
            memories: OnceCell::new(),
            remembered: RefCell::default(),
            kept_times: RefCell::default(),
            signals: Signals::default(),
            updating: RefCell::default(),
            inside: OnceCell::new(),
            written: OnceCell::new(),
            reach: OnceCell::new(),
            around: OnceCell::new(),
            between: RefCell::default(),
            is_lost: Cell::default(),
            resetting: RefCell::default(),
            time_gates: OnceCell::new(),
            told: OnceCell::new(),
            is_helper: false,
            is_of_element: false,
        }
    }

    /// Most conditions are judged without them.
    fn assignments(&self) -> &Assignments<'a> {
        self.assignments.get_or_init(|| Assignments::new(self.search.graph))
    }

    /// The same for a function that a cycle calls.
    pub(super) fn of_helper(search: &'s Search<'a>) -> Self {
        Self { is_helper: true, ..Self::new(search, Region::Function) }
    }

    /// Why a way does not update, if it does so on purpose; `None` for a way that updates, or that nothing explains.
    pub(super) fn of_end(&self, exploration: &Exploration, end: &End) -> Option<Gate> {
        if end.state.count != crate::count::counts::Count::Zero || end.state.reset {
            return None;
        }
        self.between.replace(None);
        let Some(at) = end.state.skipped_at else {
            return self.of_number(counted_past(self.search, exploration, end)?);
        };
        let way = Way::to(exploration, end, at);
        let gate = self.opening(end, at, &way);
        let waits = gate.filter(|gate| !self.loses_time(*gate, &way)).or_else(|| self.of_element(end, &way));
        if waits.is_some() {
            let is_rate = waits == gate && waits == Some(Gate::Rate);
            return if is_rate && self.sums_up_time(at) { Some(Gate::Time) } else { waits };
        }
        // Another gate that opened on the way is no reason why this one should not stay closed.
        let is_other = gate.is_none_or(|gate| gate == Gate::Time);
        if is_other && self.is_before_closed_gate(&way) {
            return Some(Gate::Time);
        }
        self.is_measured(&way).then_some(Gate::Measured)
    }

    /// What the way waits for at the node where it leaves the update, whatever becomes of the filter's time until then.
    fn opening(&self, end: &End, at: NodeId, way: &Way) -> Option<Gate> {
        let ends_round = self.ends_round(end, at);
        let gate = match &self.search.graph.node(at).effect {
            Effect::Branch(test) => self.of_branch(test, at, way).filter(|gate| self.is_reason(*gate, at, way)),
            Effect::Call(site) => match end.state.helper_gate {
                // The variant that a helper finds may be one of many that its caller makes.
                Some(Gate::Config) if self.changes_owner() => Some(Gate::Mode),
                Some(gate @ (Gate::Mode | Gate::Startup)) => self.gate_left(site, at, gate),
                Some(Gate::Rate | Gate::Time) if !self.leaves_recalled(site, at, end.state.helper_gate) => None,
                Some(Gate::Event) if self.keeps_message(site, at) => self.mode_of_kept(site, at),
                gate => gate
                    .or_else(|| self.of_call(site, at, way, ends_round))
                    .or_else(|| self.is_chosen_by_type(site).then_some(Gate::Config)),
            },
            Effect::LoopHead(id) => self.of_loop(*id).or_else(|| self.of_rounds(*id, way)),
            _ => None,
        };
        match ends_round {
            true => gate,
            false => gate
                .or_else(|| self.of_payload(way))
                .or_else(|| self.of_pause(way))
                .or_else(|| self.leaves_samples(way).then_some(Gate::Sample))
                .or_else(|| self.of_remembered(way)),
        }
    }

    /// What a condition waits for; a claimed rate gate must be one of that rate.
    fn of_branch(&self, test: &Test, at: NodeId, way: &Way) -> Option<Gate> {
        let gate = self.of_condition(test, at, way, 0);
        let at_gate = match self.search.program.directive(test.span) {
            Some(CycleDirective::Every(ratio)) => Some(ratio),
            _ => None,
        };
        let at_loop = match self.region {
            Region::Loop(id) => self.search.graph.loop_info(id).directive,
            Region::Function => None,
        };
        match (at_gate, at_loop, gate) {
            (Some(ratio), _, _) | (None, Some(CycleDirective::Every(ratio)), Some(Gate::Rate)) => {
                (gate == Some(Gate::Rate) && self.has_ratio(test, at, ratio)).then_some(Gate::Rate)
            }
            _ => gate,
        }
    }

    /// What a condition waits for, or the condition whose result it asks for: `let due = n % 10 == 0; if due { … }`.
    fn of_condition(&self, test: &Test, at: NodeId, way: &Way, origins: u32) -> Option<Gate> {
        if origins < MAX_ORIGINS
            && let Some(gate) = self.of_choices(test, at, way, origins)
        {
            return gate;
        }
        let gate = self.of_test(test, at, way);
        // What a name tells of a time is worth less than the code that gave the answer: `fn is_due(&mut self)` may count.
        if gate.is_some_and(|gate| !matches!(gate, Gate::Time | Gate::Mode)) {
            return gate;
        }
        match self.origin(test, at, way).filter(|_| origins < MAX_ORIGINS) {
            // A state that has a name is a start if it comes once.
            Some((origin, chosen_at, _)) if gate == Some(Gate::Mode) => {
                let is_start = self.of_condition(origin, chosen_at, way, origins + 1) == Some(Gate::Startup)
                    || self.is_told_warm_up((origin, chosen_at), at, way);
                if is_start { Some(Gate::Startup) } else { gate }
            }
            Some(origin) => match self.of_origin(origin, at, way, origins).or(gate) {
                Some(Gate::Mode) if self.is_told_warm_up((origin.0, origin.1), at, way) => Some(Gate::Startup),
                gate => gate,
            },
            None => gate
                .or_else(|| self.of_carried(test, at, way))
                .or_else(|| self.of_flag(test, at, way, origins))
                .or_else(|| self.of_arm(test, at, way, origins)),
        }
    }

    fn of_test(&self, test: &Test, at: NodeId, way: &Way) -> Option<Gate> {
        let about = &test.about;
        if about.is_constant && !about.stands_in {
            return Some(Gate::Config);
        }
        // What something else may switch by another name is neither a setting nor a mode that is known.
        let is_left = |gate: &Gate| {
            let is_left = || !about.stands_in && self.written_by_other_name(test).is_none();
            !matches!(gate, Gate::Config | Gate::Mode | Gate::Startup) || is_left()
        };
        self.of_named_test(test, at, way).filter(is_left)
    }

    /// The same, as far as nothing has another name for what is asked.
    fn of_named_test(&self, test: &Test, at: NodeId, way: &Way) -> Option<Gate> {
        let about = &test.about;
        // Which number an element has is no reason why it should stand still.
        if self.asks_own_number(test) || self.asks_which_element(test) {
            return None;
        }
        // A function that does not call its closure in this round begins no cycle of the closure.
        if self.is_around_closure(at) {
            return Some(Gate::Event);
        }
        if about.is_event {
            // `match receiver.try_recv() { Ok(sample) => …, Err(_) => … }` asks only whether there is one.
            if about.asks_presence() && self.lacks_sample(test, at, way) {
                return Some(Gate::Sample);
            }
            if !self.is_absent(test, at, way) && !self.waits_for_none(test, at, way) {
                return Some(Gate::Event);
            }
        }
        if self.awaits_kind(test, at, way) {
            return Some(Gate::Event);
        }
        let is_kept = self.is_kept_flag(test);
        let is_remainder = about.is_remainder || self.asks_held_remainder(test, false);
        if about.is_remainder && self.asks_part_of_received(test) {
            return Some(Gate::Event);
        }
        let is_decimated = || {
            self.remainder_counts(test, at) && self.goes_on_counting(test, at, way) && !self.stands_still(test, at, way)
        };
        let is_masked = is_remainder || self.masks_rounds(test);
        if self.shares_rounds(&about.reads, way) || (is_masked && !is_kept && is_decimated()) {
            return Some(Gate::Rate);
        }
        if self.asks_told_remainder(test, at, way) {
            return Some(Gate::Rate);
        }
        if let Some(gate) = self.of_presence(test) {
            return gate;
        }
        if let Some(gate) = self.own_state(test, at, way).or_else(|| self.asks_sibling_too(test, at, way)) {
            return Some(gate);
        }
        if let Some(gate) = self.of_window(test, at, way) {
            return Some(gate);
        }
        if self.is_latch(test, at, way) {
            return self.of_latch(test, at, way);
        }
        if self.is_start(test, at, way) {
            return Some(Gate::Startup);
        }
        if self.is_event(test) || self.asks_tag(test) || self.asks_text(test) {
            return Some(Gate::Event);
        }
        if self.has_no_samples(test, at, way) || self.lacks_word(test) {
            return Some(Gate::Sample);
        }
        if self.asks_kept_option(test) || self.asks_kept_part(test) {
            return self.of_setting(test, at, way);
        }
        if about.is_presence && self.lacks_sample(test, at, way) || self.asks_for_reason(test, at, way) {
            return if self.binds_filters(test) {
                (!self.is_tried(test)).then_some(Gate::Config)
            } else {
                Some(Gate::Sample)
            };
        }
        if self.asks_whether_event(test) || self.is_flag_of_others(test) {
            return Some(Gate::Event);
        }
        if self.lacks_reading(test, at, way) || self.rejects_sample(test) {
            return Some(Gate::Sample);
        }
        if self.is_taken(test) {
            return Some(Gate::Event);
        }
        if self.asks_item(test) && !about.binds.is_empty() && self.lacks_sample(test, at, way) {
            return Some(Gate::Sample);
        }
        if self.asks_moment(test) {
            return Some(Gate::Time);
        }
        if self.is_used_up_again(test, way) {
            return Some(Gate::Rate);
        }
        if !about.is_presence
            && let Some(gate) = self.counter(test, at, way)
        {
            return Some(gate);
        }
        if self.tells_time(test) {
            return Some(Gate::Time);
        }
        if self.asks_whether_new(test, way) || (self.is_readiness(test) && !self.skips_ready(test, at, way)) {
            return Some(Gate::Sample);
        }
        let is_setting = || (is_kept || self.is_unchanging(test)) && !self.asks_changed_state(test, way);
        if test.subject.is_some() && is_setting() {
            return self.of_setting(test, at, way);
        }
        if self.asks_poison(test) {
            return Some(Gate::Config);
        }
        if self.rotates(test) || self.draws_in_turn(test) {
            return Some(Gate::Rate);
        }
        // A remainder is no state that anything is in.
        let left_at = way.left_at;
        let asks_by_name = left_at != at && matches!(self.search.graph.node(left_at).effect, Effect::Branch(_));
        let is_mode = |id| self.is_mode_asked_by(id, asks_by_name.then_some(left_at));
        (!is_remainder && is_mode(test.subject?) && !self.locks_itself_out(test)).then_some(Gate::Mode)
    }

    /// The condition that gave a truth value which is asked for: the last one on the way that decides that the value is given.
    fn origin(&self, test: &Test, at: NodeId, way: &Way) -> Option<(&'a Test, NodeId, NodeId)> {
        let asked = self.search.graph.subjects[test.subject?.0 as usize].whole.clone()?;
        self.origin_of(asked, at, way)
    }

    /// The same for a place that a node asks for; with the node that gives it the value.
    fn origin_of(&self, mut asked: Place, at: NodeId, way: &Way) -> Option<(&'a Test, NodeId, NodeId)> {
        let graph = self.search.graph;
        let asks_at = way.nodes.iter().position(|node| *node == at)?;
        for number in (0..asks_at).rev() {
            let node = graph.node(way.nodes[number]);
            let (Effect::Set(set) | Effect::Write(set)) = &node.effect else { continue };
            if set.place != asked {
                continue;
            }
            if let Some(from) = set.same_as {
                asked = Place::var(from);
                continue;
            }
            set.head.as_ref()?;
            let is_why = |id: &&NodeId| self.search.decides(**id, way.nodes[number]);
            return way.nodes[..number].iter().rev().filter(is_why).find_map(|id| match &graph.node(*id).effect {
                Effect::Branch(test) => Some((test, *id, way.nodes[number])),
                _ => None,
            });
        }
        None
    }

    /// The nodes of the region.
    fn nodes(&self) -> impl Iterator<Item = NodeId> + '_ {
        let inside = || self.search.graph.node_ids().filter(|id| self.is_inside(*id)).collect();
        self.inside.get_or_init(inside).iter().copied()
    }

    /// The nodes of the region that assign to a place.
    fn assigning<'b>(&'b self, place: &'b Place) -> impl Iterator<Item = NodeId> + 'b {
        self.assignments()
            .of(place)
            .iter()
            .copied()
            .filter(|id| self.is_inside(*id) && self.assigns(*id, place) && !self.names_element(*id))
    }

    /// From which nodes an update can still be reached in the iteration.
    fn reach(&self) -> &[bool] {
        self.reach.get_or_init(|| self.search.reach(self.region))
    }

    fn is_inside(&self, id: NodeId) -> bool {
        let graph = self.search.graph;
        matches!(self.region, Region::Loop(own) if graph.is_within(graph.node(id).in_loop, own))
            || matches!(self.region, Region::Function)
    }

    /// Whether a node belongs to the function that calls the closure whose cycle this is, not to the closure.
    fn is_around_closure(&self, at: NodeId) -> bool {
        let graph = self.search.graph;
        let Region::Loop(own) = self.region else { return false };
        graph.loop_info(own).is_foreign && self.is_read_in_place(at)
    }

    fn is_instance(&self, place: &Place) -> bool {
        self.is_of(self.search.instance, place)
    }

    fn is_part(&self, place: &Place) -> bool {
        self.is_part_of(self.search.instance, place)
    }

    /// Whether a place may be a filter, a part of it, or what it is a part of.
    fn is_of(&self, filter: &Place, place: &Place) -> bool {
        self.search.aliases.shared_roots(place).iter().any(|root| root.overlaps(filter))
    }

    /// Whether a place may be a part of a filter.
    fn is_part_of(&self, filter: &Place, place: &Place) -> bool {
        let roots = self.search.aliases.shared_roots(place);
        roots.iter().any(|root| root.overlaps(filter) && root.steps.len() > filter.steps.len())
    }

    /// Whether a place is the instance or a part of it, not what it is a part of.
    fn lies_in_instance(&self, place: &Place) -> bool {
        let instance = self.search.instance;
        let roots = self.search.aliases.roots(place);
        roots.iter().any(|root| root.overlaps(instance) && root.steps.len() >= instance.steps.len())
    }

    fn concerns(&self, site: &CallSite) -> bool {
        site.args.iter().filter_map(|arg| arg.place.as_ref()).any(|place| self.is_instance(place))
    }

    /// Whether a place is there before and after the iteration.
    fn outlives(&self, place: &Place) -> bool {
        self.search.outlives(self.region, place)
            || self.is_locked(place)
            || (self.is_of_element && self.is_state_of_element(place))
    }

    /// What the places that a condition reads are computed from.
    fn behind(&self, test: &Test) -> Sources {
        let asked = Computed { places: test.about.reads.clone(), calls: test.about.names.clone() };
        self.assignments().behind(&asked)
    }

    fn ty(&self, place: &Place) -> Option<crate::index::Ty> {
        super::instances::place_ty(self.search.program.index, self.search.graph, place)
    }
}
