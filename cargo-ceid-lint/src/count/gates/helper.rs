//! Conditions in a helper on what its caller has: only the caller can say what they wait for.

use super::{Gates, Way};
use crate::count::assumed::is_open_to;
use crate::count::counts::Count;
use crate::count::given::{Given, GivenBase, asked_at, given, place_of};
use crate::count::outcome::Outcome;
use crate::count::returned;
use crate::count::search::{End, Exploration, Mode, Region};
use crate::count::skips::counted_past;
use crate::count::verdict::Gate;
use crate::flow::{
    CallSite, Computed, ControlFlowGraph, Effect, Head, IndexKey, Limit, LoopId, NodeId, Place, Projection, Subject,
    SubjectId, Transfer, is_receiving, is_receiving_something, is_waiting,
};
use crate::index::{FunctionId, Ty};

/// Something of the caller's that a function asks for before it updates.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(in crate::count) struct Asks {
    /// What the condition reads.
    reads: Vec<Given>,
    /// Whether it comes out the same as long as they do.
    is_pure: bool,
    /// Whether it asks for nothing but whether something is there.
    is_presence: bool,
    /// Whether it tells several things apart.
    is_choice: bool,
    /// Whether it asks for a remainder.
    is_remainder: bool,
    /// Whether it is the number that a loop over elements counts to.
    is_number: bool,
    /// The place whose value it is, if it is one.
    whole: Option<Given>,
    /// The heads with which the function may update.
    updating: Vec<Head>,
}

impl Asks {
    /// A number that a loop over elements counts to.
    const fn number(reads: Vec<Given>) -> Self {
        Self {
            reads,
            is_pure: true,
            is_presence: false,
            is_choice: false,
            is_remainder: false,
            is_number: true,
            whole: None,
            updating: Vec::new(),
        }
    }

    /// Whether nothing decides but such a number.
    pub(in crate::count) fn is_number(&self) -> bool {
        self.is_number
    }

    /// The subject of the caller's that the function asks for.
    pub(in crate::count) fn subject(&self, graph: &ControlFlowGraph, site: &CallSite) -> Option<SubjectId> {
        graph.subject_of(&asked_at(self.whole.as_ref()?, site)?)
    }
}

impl Gates<'_, '_> {
    /// What a way through a helper does not update for, if its caller has to judge that.
    pub(in crate::count) fn asks(&self, exploration: &Exploration, end: &End) -> Option<Asks> {
        if end.state.count != Count::Zero || end.state.reset {
            return None;
        }
        let graph = self.search.graph;
        let known = |place: Place| given(graph, &place).filter(|_| self.is_left_alone(&place));
        let readable = |place: Place| known(place.clone()).or_else(|| self.known_element(&place));
        // What is read through a reference is what the place holds by then.
        let is_reference = |place: &Place| {
            let var = place.base_var().filter(|_| place.steps.is_empty());
            var.is_some_and(|var| matches!(graph.var(var).ty, Ty::Ref(..)))
        };
        let is_copy = |place: &Place| is_reference(place) || self.copied_from(place) == self.taken_from(place);
        let Some(at) = end.state.skipped_at else {
            let info = graph.loop_info(counted_past(self.search, exploration, end)?);
            let held = info.limits.iter().filter_map(|limit| match limit {
                Limit::Held(place) | Limit::UpTo(place) => Some(readable(self.taken_from(place))),
                _ => None,
            });
            let reads: Option<Vec<Given>> = held.collect();
            return Some(Asks::number(reads.filter(|reads| !reads.is_empty())?));
        };
        match &graph.node(at).effect {
            Effect::Branch(test) => {
                let subject = test.subject.map(|id| &graph.subjects[id.0 as usize]);
                let mut told = self.behind_told_remainder(test);
                told.retain(|place| self.is_number(place));
                let is_remainder = test.about.is_remainder || !told.is_empty();
                let reads = match told.is_empty() {
                    true => subject.map_or(&test.about.reads, |subject| &subject.reads),
                    false => &told,
                };
                let reads: Vec<Place> = reads.iter().map(|place| self.asked_of(test, place)).collect();
                let is_kept = |place: &Place| readable(self.taken_from(place)).is_some();
                let is_pure = subject.is_some() && reads.iter().all(is_copy) && reads.iter().all(is_kept);
                // What counts may be changed here as well.
                let read = |place: &Place| match is_remainder {
                    true => given(graph, &self.taken_from(place)),
                    false => readable(self.taken_from(place)),
                };
                let told_to: Vec<Option<Given>> = reads.iter().map(read).collect();
                // A message is compared with what the helper kept of the one before: `if seq > self.seen { self.seen = seq; … }`
                let is_handed = |given: &Given| match given.base {
                    GivenBase::Param(number) => !matches!(graph.var(graph.params[number]).ty, Ty::Ref(..)),
                    GivenBase::Static(_) => false,
                };
                let is_of_message = test.about.is_comparison && told_to.iter().flatten().any(is_handed);
                let reads: Option<Vec<Given>> = match is_of_message {
                    true => Some(told_to.into_iter().flatten().collect()),
                    false => told_to.into_iter().collect(),
                };
                let mask = test.subject.and_then(|id| self.updating(id)).unwrap_or(0);
                Some(Asks {
                    reads: reads.filter(|reads| !reads.is_empty())?,
                    is_pure,
                    is_presence: test.about.is_presence && !test.about.is_choice(),
                    is_choice: self.tells_apart(test),
                    is_remainder,
                    is_number: false,
                    whole: subject.and_then(|subject| known(self.copied_from(subject.whole.as_ref()?))),
                    updating: subject.map(|subject| subject.names(mask)).unwrap_or_default(),
                })
            }
            Effect::Call(site) => {
                let heads = self.answer(site, &Way::to(exploration, end, at));
                let [asks] = self.asked_by(site, heads, None)?.try_into().ok()?;
                let read = read_by(asks, site)?;
                let is_pure = asks.is_pure && !read.is_computed && read.places.iter().all(is_copy);
                let reads: Option<Vec<Given>> =
                    read.places.iter().map(|place| readable(self.taken_from(place))).collect();
                let whole = asks.whole.as_ref().and_then(|given| known(self.copied_from(&asked_at(given, site)?)));
                Some(Asks { reads: reads?, is_pure, whole, ..asks.clone() })
            }
            _ => None,
        }
    }

    /// A part of an element over which the helper goes, as its caller knows it, if the helper leaves it alone in all of them.
    fn known_element(&self, place: &Place) -> Option<Given> {
        let graph = self.search.graph;
        let roots = self.search.aliases.shared_roots(place);
        let [root] = &*roots else { return None };
        let is_it =
            |written: &Place| self.search.aliases.shared_roots(written).iter().any(|written| written.overlaps(root));
        let is_written = self.nodes().any(|id| match &graph.node(id).effect {
            // An element that gets a name is not written, but what is written through the name is.
            Effect::Write(write) if !write.rebinds && write.place.steps.is_empty() => {
                write.transfer != Transfer::Borrow && is_it(&write.place)
            }
            Effect::Write(write) | Effect::Set(write) => !write.place.steps.is_empty() && is_it(&write.place),
            Effect::Call(site) => self.written_by(site).any(|written| !written.steps.is_empty() && is_it(&written)),
            Effect::Unknown { places, .. } => places.iter().any(|place| !place.steps.is_empty() && is_it(place)),
            _ => false,
        });
        let mut keys = root.steps.iter().filter_map(Projection::key).peekable();
        let is_each = keys.peek().is_some() && keys.all(|key| *key == IndexKey::Each);
        given(graph, root).filter(|_| is_each && !is_written && place.steps.len() < root.steps.len())
    }

    /// Whether a call ends the round of an element for a reason that only its caller knows, while others have theirs before them.
    pub(super) fn ends_round(&self, end: &End, at: NodeId) -> bool {
        let graph = self.search.graph;
        let is_call = matches!(graph.node(at).effect, Effect::Call(_)) && end.state.helper_gate.is_none();
        let is_covering = |id: LoopId| self.search.covers(id) && self.region != Region::Loop(id);
        is_call
            && graph.loops_around(at).any(is_covering)
            && graph.node(at).next.iter().any(|next| self.reach()[next.0 as usize])
    }

    /// What a call that does not update waits for, where the helper asks for something that is known here.
    pub(super) fn of_call(&self, site: &CallSite, at: NodeId, way: &Way, ends_round: bool) -> Option<Gate> {
        // A way with another answer than any of those may stand for one that is told apart from it by nothing else.
        let all = self.asked_by(site, self.answer(site, way), None);
        let all = all.or_else(|| self.asked_by(site, returned::ANY, None))?;
        let mut found = None;
        for asks in all {
            let read = read_by(asks, site)?;
            let is_setting = |place: &Place| self.is_invariant(place, 0);
            let is_config = asks.is_pure && !read.is_computed && read.places.iter().all(is_setting);
            let other = |outer: &&Self| !read.places.iter().all(|place| outer.is_invariant(place, 0));
            let gate = if is_config {
                match self.around().iter().find(other) {
                    None if read.places.iter().any(|place| self.is_written_between(place)) => return None,
                    None => Gate::Config,
                    Some(outer) => outer.of_call(site, at, &outer.way_through(at, way), false)?,
                }
            } else if let Some(gate) = self.of_given(asks, site, at, way) {
                gate
            } else if self.shares_rounds(&read.places, way) {
                Gate::Rate
            } else if asks.is_choice && self.tells_rounds(&read.places) {
                Gate::Event
            } else if ends_round {
                // What else becomes of the states of elements has other names.
                self.mode_of_element(asks, site, at)?
            } else if asks.is_remainder && read.places.iter().any(|place| self.counts_for(place, at)) {
                Gate::Rate
            } else if !asks.is_presence && (self.is_event_of(&read.places, asks.is_choice) || read.is_received(asks)) {
                Gate::Event
            } else {
                self.mode_of_call(asks, site, at, None).or_else(|| self.mode_of_element(asks, site, at))?
            };
            found = found.or(Some(gate));
        }
        found
    }

    /// Whether the type that callers choose decides whether a call updates: some of the bodies always do, and the others never.
    pub(super) fn is_chosen_by_type(&self, site: &CallSite) -> bool {
        let receiver = site.args.first().and_then(|arg| arg.place.as_ref());
        let is_of_callers = receiver.is_some_and(|place| matches!(self.ty(place), Some(Ty::Param(_))));
        let updates = |target: &FunctionId| {
            let summary = self.search.summaries.get(*target)?;
            let is_own = |given: &Given| place_of(given, site).is_some_and(|place| self.is_instance(&place));
            let own = summary.outcomes(self.search.law).filter(|(given, _)| is_own(given));
            let counts: Vec<Option<Count>> = own
                .flat_map(|(_, outcomes)| outcomes)
                .map(|outcome| Some(outcome.count).filter(|_| outcome.unknown.is_none()))
                .collect();
            let is_never = counts.iter().all(|count| *count == Some(Count::Zero));
            let is_always = counts.iter().all(|count| count.is_some_and(|count| count != Count::Zero));
            (is_never || is_always).then_some(!is_never)
        };
        let all: Option<Vec<bool>> = site.targets.iter().map(updates).collect();
        is_of_callers && all.is_some_and(|all| all.contains(&true) && all.contains(&false))
    }

    /// Whether a number changes between the calls of a helper that asks for its remainder, and not to one that was read just now.
    fn counts_for(&self, place: &Place, at: NodeId) -> bool {
        self.changes_in(place, |id| id != at) && (!self.is_number(place) || self.is_counted_to(place, at))
    }

    /// What the ways through a helper read here that do not update.
    pub(super) fn asked_in(&self, site: &CallSite, way: &Way) -> Option<Vec<Place>> {
        let all = self.asked_by(site, self.answer(site, way), None)?;
        let read = all.into_iter().map(|asks| Some(read_by(asks, site)?.places));
        Some(read.collect::<Option<Vec<_>>>()?.concat())
    }

    /// What a condition waits for whose result a helper is given and asks for: `slow(&mut pid, n % 10 == 0)`.
    fn of_given(&self, asks: &Asks, site: &CallSite, at: NodeId, way: &Way) -> Option<Gate> {
        let asked = asked_at(asks.whole.as_ref()?, site)?;
        self.of_origin(self.origin_of(asked, at, way)?, at, way, 0)
    }

    /// Whether a helper that takes its parameter for a message is given a state, and what changes that resets the filter.
    pub(super) fn mode_of_kept(&self, site: &CallSite, at: NodeId) -> Option<Gate> {
        let gate = Some(Gate::Event);
        let all = self.asked_by(site, returned::ANY, gate)?;
        all.into_iter().all(|asks| self.mode_of_call(asks, site, at, gate).is_some()).then_some(Gate::Mode)
    }

    fn mode_of_call(&self, asks: &Asks, site: &CallSite, at: NodeId, gate: Option<Gate>) -> Option<Gate> {
        let graph = self.search.graph;
        let id = asks.subject(graph, site)?;
        let subject = &graph.subjects[id.0 as usize];
        let updating = asks.updating.iter().fold(0, |mask, head| mask | subject.bit(head));
        let mode = Mode { asked_by: Some(at), gate, ..Mode::new(id, updating) };
        (updating != 0 && self.resets_in_pauses(mode)).then_some(Gate::Mode)
    }

    fn mode_of_element(&self, asks: &Asks, site: &CallSite, at: NodeId) -> Option<Gate> {
        let place = asked_at(asks.whole.as_ref()?, site)?;
        self.is_asked_of_element(&place, at, &asks.updating).then_some(Gate::Mode)
    }

    /// The heads that the result of the call which decided a way can have, for what the way asks of it from there on: `step()?`.
    fn answer(&self, site: &CallSite, way: &Way) -> returned::Heads {
        let graph = self.search.graph;
        let mut names = vec![Place::var(site.result)];
        let mut heads = returned::ANY;
        let called = way.nodes.iter().rposition(|id| *id == way.at).unwrap_or_default();
        for (id, next) in way.nodes[called..].iter().zip(&way.nodes[called + 1..]) {
            match &graph.node(*id).effect {
                Effect::Set(set) if set.same_as.is_some_and(|from| names.contains(&Place::var(from))) => {
                    names.push(set.place.clone());
                }
                Effect::Branch(test) => {
                    let subject = test.subject.map(|id| &graph.subjects[id.0 as usize]);
                    let holds = graph.node(*id).next.first() == Some(next);
                    let is_asked = |subject: &&Subject| subject.whole.as_ref().is_some_and(|it| names.contains(it));
                    if let Some(subject) = subject.filter(is_asked) {
                        heads &= returned::of_mask(
                            self.search.program.variants,
                            subject,
                            if holds { test.holds } else { test.fails },
                        );
                    }
                }
                _ => {}
            }
        }
        heads
    }

    /// What the ways through a call with one of these results ask for that do not update, each of them that has this gate; `None` if
    /// one of them asks for nothing.
    fn asked_by(&self, site: &CallSite, heads: returned::Heads, gate: Option<Gate>) -> Option<Vec<&Asks>> {
        let mut all = Vec::new();
        for summary in site.targets.iter().filter_map(|target| self.search.summaries.get(*target)) {
            for (given, outcomes) in summary.outcomes(self.search.law) {
                if place_of(given, site).is_some_and(|place| self.is_instance(&place)) {
                    let skips = |outcome: &&Outcome| {
                        let skips = outcome.count == Count::Zero && !outcome.reset;
                        let is_asked = outcome.gate == gate && outcome.returned & heads != 0;
                        skips && is_asked && !outcome.attempted && is_open_to(&outcome.assumed, site)
                    };
                    for outcome in outcomes.iter().filter(skips) {
                        let asks = outcome.asks.as_ref()?;
                        // A composite filter and those that lie in it wait for the same.
                        if !all.contains(&asks) {
                            all.push(asks);
                        }
                    }
                }
            }
        }
        (!all.is_empty()).then_some(all)
    }
}

/// What a helper's condition reads where the helper is called.
#[derive(Default)]
struct Read {
    places: Vec<Place>,
    /// Whether something is called for it.
    is_computed: bool,
    /// Whether that receives something.
    brings: bool,
}

impl Read {
    /// Whether a choice is made on what was received for the call: `self.handle(link.try_recv())`.
    fn is_received(&self, asks: &Asks) -> bool {
        asks.is_choice && self.brings
    }
}

fn read_by(asks: &Asks, site: &CallSite) -> Option<Read> {
    let mut read = Read::default();
    for given in &asks.reads {
        if let GivenBase::Param(number) = given.base
            && let Some(argument) = site.args.get(number)
        {
            let brings = |name: &String| is_receiving(name) || is_receiving_something(name) || is_waiting(name);
            read.brings |= argument.from.calls.iter().any(brings);
        }
        if let Some(place) = asked_at(given, site).or_else(|| place_of(given, site)) {
            read.places.push(place);
            continue;
        }
        let GivenBase::Param(number) = given.base else { return None };
        let argument = site.args.get(number)?;
        if let Some(whole) = &argument.value_of {
            read.places.push(whole.join(&given.steps));
            continue;
        }
        // What is given is made up for the call.
        let Computed { places, calls } = &argument.from;
        if places.is_empty() && !argument.is_setting {
            return None;
        }
        read.places.extend_from_slice(places);
        read.is_computed |= !calls.is_empty();
    }
    Some(read)
}
