//! One search at work: its states, what each effect does to them, and how ways end.

use std::collections::{BTreeSet, VecDeque};

use rustc_hash::{FxHashMap, FxHashSet};

use super::copies::Copies;
use super::entry::Known;
use super::interner::Interner;
use super::live::MANY_STATES;
use super::versions::Versions;
use super::{End, EndKind, Entry, Exploration, MAX_STATES, Region, Search, State};
use crate::count::counts::Count;
use crate::count::returned;
use crate::count::samples::over_filters;
use crate::count::slice::Tracked;
use crate::flow::{Cause, Effect, IndexKey, LoopId, NodeId, Place, Relation, RunBy, Update, Var};

/// The round of a loop whose counter has passed every number that is asked for.
pub(super) const BEYOND: u64 = u64::MAX;

/// How far each loop that is counted has come.
pub(super) type RoundsDone = Vec<(LoopId, u64)>;

pub(super) struct Run<'s, 'a> {
    pub(super) search: &'s Search<'a>,
    pub(super) region: Region,
    pub(super) tracked: Tracked,
    pub(super) names: Interner<Vec<Place>>,
    pub(super) versions: Interner<Versions>,
    pub(super) copies: Interner<Copies>,
    pub(super) masks: Interner<Vec<u32>>,
    pub(super) rounds: Interner<RoundsDone>,
    pub(super) exploration: Exploration,
    /// The nodes from which an update can still be reached in the iteration.
    pub(super) reach: Vec<bool>,
    /// The same for a way on which a copy must not be put back.
    reach_of_copies: Vec<bool>,
    /// Why the instance may have names that are not known, from before the region on.
    pub(super) doubt: Option<u16>,
    /// Loops that count as one run of a cycle of their own, however many rounds they have.
    own: BTreeSet<LoopId>,
    /// Whether nothing updates the instance outside such loops.
    is_all_own: bool,
    pub(super) seen: FxHashSet<State>,
    pub(super) queue: VecDeque<usize>,
    /// The mode that is asked about, if one is.
    pub(super) mode: Option<super::Mode>,
    /// Whether callers are to know if a reset is behind the last update.
    pub(super) tells_renewal: bool,
    /// What is still needed at each node, once there are many states.
    pub(super) needed: Option<super::live::Needed>,
    /// What is left of what is known, by that and by what is needed.
    pub(super) reduced: FxHashMap<(u32, u32), u32>,
    /// Which of the tracked subjects callers know, where they are to know what is assumed of them.
    pub(super) of_caller: Vec<super::shared::OfCaller>,
    /// What each state asks for that comes by.
    pub(super) recurring: super::recurring::Recurring,
    /// The states of the element that the instance is or lies in, which several branches ask for by names of their own.
    pub(super) of_element: Vec<super::known::OfElement>,
}

impl<'s, 'a> Run<'s, 'a> {
    pub(super) fn new(search: &'s Search<'a>, region: Region, tracked: Tracked, reach: [Vec<bool>; 2]) -> Self {
        let [reach, of_copies] = reach;
        let reach_of_copies = if of_copies.is_empty() { reach.clone() } else { of_copies };
        Self {
            search,
            region,
            tracked,
            names: Interner::default(),
            versions: Interner::default(),
            copies: Interner::default(),
            masks: Interner::default(),
            rounds: Interner::default(),
            exploration: Exploration::default(),
            reach,
            reach_of_copies,
            doubt: None,
            own: BTreeSet::new(),
            is_all_own: false,
            seen: FxHashSet::default(),
            queue: VecDeque::new(),
            mode: None,
            tells_renewal: false,
            needed: None,
            reduced: FxHashMap::default(),
            of_caller: Vec::new(),
            recurring: super::recurring::Recurring::default(),
            of_element: search.of_element(region),
        }
    }

    /// Follows all ways to their ends.
    pub(super) fn finish(mut self, starts: &[(NodeId, Option<Entry>)]) -> Exploration {
        self.start_at(starts);
        while let Some(at) = self.queue.pop_front() {
            if self.needed.is_none() && self.exploration.states.len() > MANY_STATES {
                self.forget_what_nothing_asks();
                self.exploration = Exploration::default();
                self.seen.clear();
                self.queue.clear();
                self.start_at(starts);
                continue;
            }
            let state = self.exploration.states[at].clone();
            self.step(at, &state);
        }
        self.forget_other_names();
        self.exploration.dropped = self.untracked();
        self.skip_where_known();
        self.skip_where_chosen();
        self.doubt_unread();
        self.exploration
    }

    fn start_at(&mut self, starts: &[(NodeId, Option<Entry>)]) {
        for (node, entry) in starts {
            self.start(*node, entry.as_ref());
        }
    }

    pub(super) fn push(&mut self, state: State, parent: Option<usize>) {
        // What only names a gate may take a part of the effort.
        let limit = if self.mode.is_some() { MAX_STATES / 4 } else { MAX_STATES };
        if self.exploration.states.len() >= limit {
            self.exploration.limit |= !self.seen.contains(&state);
            return;
        }
        if !self.seen.insert(state.clone()) {
            return;
        }
        let at = self.exploration.states.len();
        self.exploration.states.push(state);
        self.exploration.parents.push(parent);
        self.exploration.depths.push(parent.map_or(0, |parent| self.exploration.depths[parent] + 1));
        self.queue.push_back(at);
    }

    /// Follows an edge: the way may end with it.
    pub(super) fn follow(&mut self, at: usize, state: State, to: NodeId) {
        let graph = self.search.graph;
        if graph.node(to).debug_only.is_some() || self.search.is_of_another(self.names.get(state.names), to) {
            return;
        }
        let mut state = state;
        let ends = matches!(self.region, Region::Loop(id) if to == graph.loop_info(id).head);
        let reach = if self.loses_copy(&state) { &self.reach_of_copies } else { &self.reach };
        if state.count == Count::Zero
            && state.skipped_at.is_none()
            && reach[state.node.0 as usize]
            && (ends || !reach[to.0 as usize])
            && !self.is_other_element(&state)
        {
            state.skipped_at = Some(state.node);
        }
        if let Region::Loop(id) = self.region {
            let is_left = !graph.is_within(graph.node(to).in_loop, id);
            if self.awaits_copy(&state) && (is_left || to == graph.loop_info(id).head) {
                self.exploration.leaves_out_copies = true;
                return;
            }
            if to == graph.loop_info(id).head {
                self.end(EndKind::Completes, at, &state, returned::ANY);
                // What is known at the end of an iteration is known at the beginning of the next.
                let age = self.age_after(&state);
                let State { names, masks, rounds, unknown, is_supposed, .. } = self.still_known(state, to);
                let doubt = unknown.filter(|_| is_supposed);
                let names = self.names_in_next(names);
                self.begin(Known { node: to, age, names, masks, rounds, doubt });
                return;
            }
            if is_left {
                self.end(EndKind::Exits, at, &state, returned::ANY);
                return;
            }
        }
        let in_sample = state.in_sample
            && graph
                .loops_around(to)
                .any(|id| self.search.sample_loops.contains(&id) && self.region != Region::Loop(id));
        let state = self.still_known(state, to);
        self.push(State { node: to, in_sample, ..state }, Some(at));
    }

    fn end(&mut self, kind: EndKind, at: usize, state: &State, returned: returned::Heads) {
        let (assumed, left) = self.assumed(state);
        let has_left = self.region == Region::Function && self.search.has_left(self.names.get(state.names));
        let state = state.clone();
        let is_copy_lost = self.loses_copy(&state);
        self.exploration.ends.push(End {
            kind,
            state,
            at,
            returned,
            ahead: Count::Zero,
            has_left,
            is_copy_lost,
            assumed,
            left,
        });
    }

    pub(super) fn everywhere(&mut self, at: usize, state: &State) {
        let graph = self.search.graph;
        let by_other_name = self.written_by_other_name(state);
        for to in &graph.node(state.node).next {
            self.follow(at, state.clone(), *to);
            if let Some(state) = &by_other_name {
                self.follow(at, state.clone(), *to);
            }
        }
    }

    fn step(&mut self, at: usize, state: &State) {
        let graph = self.search.graph;
        let node = graph.node(state.node);
        match &node.effect {
            Effect::Nothing | Effect::Mark(_) | Effect::Use { .. } | Effect::GuardStart(_) | Effect::GuardEnd(_) => {
                self.everywhere(at, state);
            }
            Effect::Advance(advance) => self.advance(at, state, advance),
            Effect::Update(Update { place, given: Some(given), .. }) => {
                let next = self.taken_over(state, place, given);
                self.everywhere(at, &next);
            }
            Effect::Update(update) if update.law == self.search.law => {
                let state = &self.with_new_value(state, update);
                let next = self.updated(state, &update.place, update.run_by);
                match update.attempt {
                    Some(result) if next.count != state.count => self.attempt(at, state, &next, result),
                    _ => self.everywhere(at, &next),
                }
            }
            Effect::Update(update) => {
                let next = self.with_new_value(state, update);
                self.everywhere(at, &next);
            }
            Effect::Reset { place, full } => {
                let mut next = state.clone();
                if *full && self.holds(state, place) {
                    next.reset = true;
                    self.rejuvenate(&mut next);
                }
                self.everywhere(at, &next);
            }
            Effect::Call(site) => self.call(at, state, site),
            Effect::Set(set) => self.assign(at, state, set),
            Effect::Write(write) => self.assign(at, state, write),
            Effect::Unknown { places, cause } if cause.is_order() => {
                let mut next = state.clone();
                let is_told = |place: &Place| self.may_hold(state, place) && !self.has_no_order(state, place);
                if places.iter().any(is_told) {
                    next.unknown = Some(self.cause(cause));
                    next.names = self.names.intern(Vec::new());
                }
                self.everywhere(at, &next);
            }
            Effect::Unknown { places, cause } => {
                let mut next = state.clone();
                let may_hold = || places.iter().any(|place| self.may_hold(state, place));
                if may_hold() && !self.search.is_told(state.node) {
                    next.unknown = Some(self.cause(cause));
                }
                for place in places {
                    next.masks = self.killed(next.masks, place);
                }
                self.everywhere(at, &next);
            }
            Effect::Branch(test) => self.branch(at, state, test),
            Effect::LoopEnter(id) => {
                let mut rounds = self.rounds.get(state.rounds).clone();
                rounds.retain(|(open, _)| open != id);
                let rounds = self.rounds.intern(rounds);
                let mut next = State { rounds, masks: self.begun_anew(state.masks, *id), ..state.clone() };
                if let Some(cause) = self.own.contains(id).then(|| over_filters(self.search, *id)).flatten() {
                    next.unknown = Some(self.cause(&cause));
                }
                if self.own.contains(id) && !next.in_sample {
                    self.begin_samples(&mut next);
                    self.wake(&mut next);
                }
                self.everywhere(at, &next);
            }
            Effect::LoopHead(id) => self.head(at, state, *id),
            Effect::Suspend => {
                let masks = self.behind_tasks(state.masks);
                self.everywhere(at, &State { masks, ..state.clone() });
            }
            Effect::Fork => {
                let mut next = state.clone();
                if self.search.updates_elsewhere(state.node) {
                    let what = "what a thread or task that is started here has done by then";
                    next.unknown = Some(self.cause(&Cause::Code(what.to_owned())));
                }
                if let Some(here) = node.next.first().copied() {
                    self.follow(at, next, here);
                }
            }
            Effect::Return(_) if self.awaits_copy(state) => {}
            Effect::Return(value) => {
                let heads = match (&value.head, value.same_as) {
                    (Some(head), _) => returned::bit(self.search.program.variants, head),
                    (None, Some(var)) => self.heads_of(state, var),
                    (None, None) => returned::ANY,
                };
                let kind = if self.region == Region::Function { EndKind::Completes } else { EndKind::Exits };
                let (state, ahead) = &self.given_back(state, value);
                self.end(kind, at, state, heads);
                if let Some(end) = self.exploration.ends.last_mut() {
                    end.ahead = *ahead;
                }
                if self.region == Region::Function {
                    self.again(state);
                }
            }
            Effect::Diverge | Effect::End => {}
        }
    }

    pub(super) fn cause(&mut self, cause: &Cause) -> u16 {
        let at = match self.exploration.causes.iter().position(|known| known == cause) {
            Some(at) => at,
            None => {
                self.exploration.causes.push(cause.clone());
                self.exploration.causes.len() - 1
            }
        };
        u16::try_from(at).unwrap_or(u16::MAX)
    }

    /// The number that a counter has in the round at hand.
    pub(super) fn number(&self, state: &State, var: Var) -> Option<u64> {
        let rounds = self.rounds.get(state.rounds);
        rounds.iter().find_map(|(id, done)| {
            let info = self.search.graph.loop_info(*id);
            let (counter, _) = info.counter?;
            (counter == var && *done != BEYOND).then(|| info.number_in(*done))?
        })
    }

    fn holds(&self, state: &State, place: &Place) -> bool {
        self.relations(state, place).iter().any(|relation| matches!(relation, Relation::Holds(_)))
    }

    fn may_hold(&self, state: &State, place: &Place) -> bool {
        self.relations(state, place)
            .iter()
            .any(|relation| matches!(relation, Relation::Holds(_) | Relation::MayHold(..)))
    }

    /// The state after a law ran at a place.
    fn updated(&mut self, state: &State, place: &Place, run_by: RunBy) -> State {
        let mut next = state.clone();
        let is_named = self.names.get(state.names).iter().any(|name| name.base == place.base);
        if !is_named && !self.search.is_near(state.node) {
            return next;
        }
        // A guard leaves no element out.
        let relations =
            if run_by.is_guard() { self.relations_to_each(state, place) } else { self.relations(state, place) };
        let exact = relations.iter().any(|relation| matches!(relation, Relation::Holds(rest) if rest.is_empty()));
        if exact {
            // An input takes the place of the one before, and the law runs once at the end.
            let is_refed = run_by == RunBy::GuardIfFed && !state.direct && state.count != Count::Zero;
            self.add(&mut next, if is_refed { Count::Zero } else { Count::One });
            next.direct |= !run_by.is_guard();
            return next;
        }
        if let Some(cause) = self.doubt(state, place, &relations) {
            next.unknown = Some(self.cause(&cause));
        }
        next
    }

    /// Why a place may be the instance or not, if that is so.
    pub(super) fn doubt(&self, state: &State, place: &Place, relations: &[Relation]) -> Option<Cause> {
        let is_doubt = |relation: &Relation| matches!(relation, Relation::MayHold(_, rest) if rest.is_empty());
        if relations.iter().any(is_doubt) {
            let cause = || Cause::Index(self.search.graph.place_name(self.search.program.index, place));
            return (!self.is_other_round(state, place)).then(cause);
        }
        // A name for an element that data decides, or for one of some, is no name of the instance, and may be one.
        let graph = self.search.graph;
        let lender = graph.loops_around(state.node).find(|id| !graph.loop_info(*id).items.is_empty());
        let is_covered = lender.is_some_and(|id| self.search.covers(id));
        let may_be = |key: &IndexKey| match key {
            IndexKey::EachIn(_) => !is_covered,
            IndexKey::Var(var) => graph.var(*var).param.is_none(),
            key => matches!(key, IndexKey::Data(_)),
        };
        let roots = self.search.aliases.shared_roots(place);
        let root = roots.iter().find(|root| {
            root.steps.iter().any(|step| step.key().is_some_and(may_be))
                && is_doubt(&root.relate(self.search.instance, &|var| self.number(state, var)))
                && !self.is_other_round(state, root)
                && !self.search.counts_behind(root, self.search.instance)
        })?;
        Some(Cause::Index(self.search.graph.place_name(self.search.program.index, root)))
    }

    /// Whether a place is indexed with the counter of a loop that visits each element: in a round that is not the instance's own
    /// it names another element.
    pub(super) fn is_other_round(&self, state: &State, place: &Place) -> bool {
        let graph = self.search.graph;
        place.steps.iter().any(|step| match step.key() {
            Some(IndexKey::Var(var)) => graph.loops_around(state.node).any(|id| {
                self.search.covers(id) && graph.loop_info(id).counter.is_some_and(|(counter, _)| counter == *var)
            }),
            _ => false,
        })
    }

    /// Adds to the count; updates in a loop that is a cycle of its own count once for all its rounds.
    pub(super) fn add(&self, state: &mut State, count: Count) {
        if count != Count::Zero {
            self.wake(state);
        }
        state.attempted &= count == Count::Zero;
        let graph = self.search.graph;
        let in_sample = graph
            .loops_around(state.node)
            .take_while(|id| self.region != Region::Loop(*id))
            .any(|id| self.search.sample_loops.contains(&id));
        if in_sample && count != Count::Zero {
            if !state.in_sample || state.count != Count::PerSample {
                self.begin_samples(state);
            }
            return;
        }
        state.count = state.count.then(count);
    }

    /// From now on, a loop that is a cycle of its own counts as one run of it, however many rounds it has. Where data decides which
    /// element a round updates, no round is known to be the instance's own.
    pub(super) fn count_own_loops(&mut self) {
        let Search { graph, sample_loops, .. } = self.search;
        let updating = self.search.updating();
        let certain: Vec<&NodeId> = updating.iter().filter(|node| !self.search.is_chosen_by_data(**node)).collect();
        let own = |node: &NodeId| graph.loops_around(*node).filter(|id| sample_loops.contains(id));
        // Rounds that count by elements with numbers are asked for that of the instance, one by one.
        let search = self.search;
        let is_told = |node: &&&NodeId| match &graph.node(***node).effect {
            Effect::Update(update) => {
                !search.aliases.shared_roots(&update.place).iter().any(|root| search.is_by_number(root))
            }
            _ => true,
        };
        self.own = certain.iter().filter(is_told).flat_map(|node| own(node)).collect();
        self.is_all_own = certain.iter().all(|node| own(node).next().is_some());
    }

    /// Counts a loop that is a cycle of its own. Where nothing but such loops updates the instance, one behind another takes what the
    /// one before it has left.
    fn begin_samples(&self, state: &mut State) {
        state.in_sample = true;
        if !self.is_all_own || state.count != Count::PerSample {
            state.count = state.count.then(Count::PerSample);
        }
    }
}
