//! What a call of a function does to the places it gets: callees first, recursion to a fixpoint.

use std::collections::{BTreeMap, BTreeSet};

use rustc_hash::FxHashMap;

use super::aliases::Aliases;
use super::answering::Answering;
use super::answers::{Answers, answers};
use super::between::Between;
use super::bottom_up::{most_states, too_many_ways};
use super::chosen_returns::{self, Borrow, ChosenReturns};
use super::counts::Count;
use super::debug_only::{self, DebugOnly};
use super::finished;
use super::given::{
    Given, GivenBase, MAX_NUMBERS, MAX_PLACES, bound, given, instance_of, is_moved, is_put_in_place, note,
    note_unknown, place_of, steps_at, with_wholes,
};
use super::given_heads::{self, GivenHeads};
use super::instances::{counted_elements, holds_filter_at, is_generic, is_of_any_type, replaces_generic};
use super::only_with;
use super::outcome::Outcome;
use super::own_cycles;
use super::returned;
use super::search::{Region, Search};
use super::shown::Shown;
use super::slice::ControlDependence;
use super::stand_ins;
use super::turns;
use super::uneven;
use super::{assigned, carried_over, chosen_resets, handed, kept, moves, referred};
use crate::flow::{
    CallSite, Cause, ChangeKind, ControlFlowGraph, Effect, Head, Place, Program, Projection, Steps, Transfer, Var,
};
use crate::index::FunctionId;

/// What a function does.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct Summary {
    /// The ways through it, by the half of the law and the place; a place that is not listed is left alone.
    pub(super) halves: Vec<BTreeMap<Given, Vec<Outcome>>>,
    /// The parts of its parameters that its result may borrow.
    pub(super) returns: BTreeSet<Borrow>,
    /// The same by the value of a parameter, if one decides.
    pub(super) chosen: Option<ChosenReturns>,
    /// The filters of its parameters of which its result may hold copies.
    pub(super) copies: BTreeSet<Borrow>,
    /// The filters that it resets where data chooses them.
    pub(super) chosen_resets: BTreeSet<Given>,
    /// What it writes, for conditions that read it.
    pub(super) writes: BTreeSet<Given>,
    /// The call in it of something that cannot be seen and may write cells that its callers read.
    pub(super) unseen: Option<String>,
    /// The same without what laws write of their own filters.
    pub(super) alters: BTreeSet<Given>,
    /// What of it it leaves alone where it gives back `None` or `Err`.
    pub(super) writes_if_present: BTreeSet<Given>,
    /// With which heads, where they are known, and how these values go on from those before.
    pub(super) sets: BTreeSet<(Given, Option<Head>, Option<ChangeKind>)>,
    /// What it gives no other heads than these.
    pub(super) given_heads: BTreeMap<Given, GivenHeads>,
    /// What of it goes without a reset of a filter that it resets on other ways.
    pub(super) unreset: BTreeSet<(Given, Option<Head>, Given)>,
    /// The states that decide over its updates of each place and that it goes on with by itself.
    pub(super) turns: BTreeMap<Given, BTreeSet<Given>>,
    /// The heads that its result may have.
    pub(super) heads: returned::Heads,
    /// The same, where it depends on what its callers know.
    pub(super) answers: Answers,
    /// The first elements of a collection that are all it has ways for, where the place is each of them: `bank.iter_mut().take(2)`.
    pub(super) taken: BTreeMap<Given, Given>,
    /// The places behind a trait, where what it does is joined over several types.
    pub(super) mixed: BTreeSet<Given>,
    /// The places that stand for each element, where not all elements are treated alike.
    pub(super) uneven: BTreeSet<Given>,
    /// The parameters from which the filters at its places are fed.
    pub(super) feeds: BTreeMap<Given, BTreeSet<usize>>,
    /// The objects in what it was lent from which they are fed.
    pub(super) feeds_from: BTreeMap<Given, BTreeSet<Given>>,
    /// The times that it keeps and computes the steps of the filters at its places from.
    pub(super) measures: BTreeMap<Given, BTreeSet<Given>>,
    /// The times that it keeps for those that wait for one.
    pub(super) paced: BTreeMap<Given, BTreeSet<Given>>,
    /// What it reads or feeds without updating it.
    pub(super) uses: BTreeSet<Given>,
    /// How it updates filters twice, and how it skips them.
    pub(super) shown: Shown,
    /// The parameters that it puts into what another one of them leads to.
    pub(super) keeps: BTreeSet<usize>,
    /// The filters that it takes out of what it was lent.
    pub(super) takes_out: BTreeSet<Given>,
    /// Where it puts what it is given: the place, and what is there from then on.
    pub(super) puts: BTreeSet<(Given, Given)>,
    /// The places that it gives copies of filters: `self.saved = self.lag`.
    pub(super) assigns: BTreeSet<assigned::Assigned>,
    /// The parameters that a type parameter stands for.
    pub(super) generic: BTreeSet<usize>,
    /// The functions that it calls.
    pub(super) calls: BTreeSet<FunctionId>,
    /// Whether a law that gives back the next state runs in it, whoever has the state.
    pub(super) gives_next: bool,
    /// The parts of its result that its own cycles have updated.
    pub(super) finished: BTreeSet<Steps>,
    /// What it updates without ever coming back.
    pub(super) endless: BTreeSet<Given>,
    /// What loops of its own update.
    pub(super) looped: BTreeSet<Given>,
    /// What nothing updates but loops that are cycles of their own.
    pub(super) cycles: BTreeSet<Given>,
    /// What it advances otherwise than by its law, with the half of the law and how.
    pub(super) stand_ins: BTreeMap<(Given, usize), Cause>,
    /// What only a debug build updates, with the half of the law.
    pub(super) debug_only: BTreeMap<(Given, usize), DebugOnly>,
}

impl Summary {
    /// The ways through it for one half of the law.
    pub(super) fn outcomes(&self, law: usize) -> impl Iterator<Item = (&Given, &Vec<Outcome>)> {
        self.halves.get(law).into_iter().flatten()
    }

    /// The elements that a place of it stands for.
    pub(super) fn reached<'a>(&'a self, given: &'a Given) -> &'a Given {
        self.taken.get(given).unwrap_or(given)
    }

    /// How many halves of a law it has ways for.
    pub(super) fn laws(&self) -> usize {
        self.halves.len()
    }

    /// The places that it has ways for.
    pub(super) fn given_places(&self) -> impl Iterator<Item = &Given> {
        self.halves.iter().flat_map(BTreeMap::keys)
    }

    /// The same ways for all halves.
    pub(super) fn insert(&mut self, given: &Given, outcomes: &[Outcome]) {
        for half in &mut self.halves {
            half.insert(given.clone(), outcomes.to_vec());
        }
    }

    /// The ways through it, with the half of the law that they are for.
    pub(super) fn outcomes_by_half(&self) -> impl Iterator<Item = (usize, &Given, &Vec<Outcome>)> {
        self.halves.iter().enumerate().flat_map(|(law, half)| half.iter().map(move |(given, ways)| (law, given, ways)))
    }

    /// The ways through it for all halves.
    pub(super) fn all_outcomes(&self) -> impl Iterator<Item = (&Given, &Vec<Outcome>)> {
        self.halves.iter().flatten()
    }
}

/// The summaries of all functions.
#[derive(Debug, Default)]
pub(super) struct Summaries {
    pub(super) of: FxHashMap<FunctionId, Summary>,
    /// The functions that call each other and are summarised at the moment.
    pub(super) open: BTreeSet<FunctionId>,
    /// Whether they call each other at all, or themselves.
    pub(super) is_recursion: bool,
    /// Of which functions it matters what they answer.
    pub(super) answering: Answering,
    /// What changes between two calls, once all functions are known.
    pub(super) between: Between,
}

impl Summaries {
    pub(super) fn get(&self, id: FunctionId) -> Option<&Summary> {
        self.of.get(&id)
    }

    /// The places at a call that the summaries of its callees tell of.
    pub(super) fn places<'a>(
        &'a self,
        site: &'a CallSite,
        what: impl Fn(&'a Summary) -> &'a BTreeSet<Given> + 'a,
    ) -> impl Iterator<Item = Place> + 'a {
        let summaries = site.targets.iter().filter_map(|target| self.of.get(target));
        summaries.flat_map(what).filter_map(|given| place_of(given, site))
    }

    /// What the result of a call may borrow or be made of: the steps into the result, and the place.
    pub(super) fn borrows<'a>(&'a self, site: &'a CallSite) -> impl Iterator<Item = (&'a [Projection], Place)> + 'a {
        self.gives(site).map(|(part, place, _)| (part, place))
    }

    /// The same, with how each instance gets there.
    pub(super) fn gives<'a>(
        &'a self,
        site: &'a CallSite,
    ) -> impl Iterator<Item = (&'a [Projection], Place, Transfer)> + 'a {
        let summaries = site.targets.iter().filter_map(|target| self.of.get(target));
        let returns = summaries.flat_map(|summary| summary.returns_at(site));
        // What lies inside a receiver whose type is not known has no name here.
        returns.filter(|borrow| !site.is_dispatched || borrow.param > 0 || borrow.steps.is_empty()).filter_map(
            |borrow| {
                let arg = site.args.get(borrow.param)?;
                let transfer = if arg.is_moved { Transfer::Move } else { Transfer::Borrow };
                Some((&*borrow.part, arg.place.as_ref()?.join(&steps_at(&borrow.steps, site)), transfer))
            },
        )
    }

    pub(super) fn summarise(&self, program: &Program<'_>, graph: &ControlFlowGraph, searched: &mut usize) -> Summary {
        let aliases = Aliases::of(program.index, graph, self);
        let mut summary = Summary { halves: vec![BTreeMap::new(); program.index.halves()], ..Summary::default() };
        summary.calls.extend(&graph.read_here);
        summary.gives_next = graph.gives_next;
        let is_param = |var: &Var| is_generic(graph, &Place::var(*var));
        summary.generic =
            graph.params.iter().enumerate().filter(|(_, var)| is_param(var)).map(|(number, _)| number).collect();
        let mut touched: BTreeSet<Given> = BTreeSet::new();
        let mut unknown: BTreeMap<Given, Cause> = BTreeMap::new();
        for id in graph.node_ids() {
            super::alters::note_number(program.index, graph, &aliases, id, &mut summary.writes);
            match &graph.node(id).effect {
                Effect::Update(update) if !handed::is_idle(&aliases, update) => {
                    let places = counted_elements(program.index, graph, &update.place);
                    places.iter().for_each(|place| note(graph, &aliases, place, &mut touched));
                }
                Effect::Advance(advance) => note(graph, &aliases, &advance.before, &mut touched),
                Effect::Reset { place, .. } => note(graph, &aliases, place, &mut touched),
                Effect::Unknown { places, cause: Cause::Call(text) } if places.is_empty() => {
                    summary.unseen.get_or_insert_with(|| text.clone());
                }
                Effect::Unknown { places, cause } => {
                    for place in places.iter().filter(|place| !self.leaves_alone(graph, &aliases, id, place)) {
                        note_unknown(graph, &aliases, place, cause, &mut unknown);
                        // What a parameter of any type holds may be what conditions of the caller ask.
                        if is_of_any_type(graph, place) {
                            note(graph, &aliases, place, &mut summary.writes);
                        }
                    }
                }
                Effect::Call(site) => self.add_call(graph, &aliases, site, &mut summary, &mut touched, &mut unknown),
                Effect::Write(write) if referred::is_of_variables(program.index, graph, id, write) => {}
                Effect::Write(write) => {
                    note(graph, &aliases, &write.place, &mut summary.writes);
                    let written = aliases.shared_roots(&write.place);
                    let written = written.iter().filter_map(|root| given(graph, root));
                    let change = graph.changes.get(&id).map(|change| change.kind);
                    summary.sets.extend(written.map(|given| (given, write.head.clone(), change)));
                    if holds_filter_at(program.index, graph, &write.place) || is_generic(graph, &write.place) {
                        note(graph, &aliases, &write.place, &mut touched);
                    }
                }
                Effect::Set(set) if is_put_in_place(graph, set) => {
                    for place in set.from.iter().chain([&set.place]) {
                        note(graph, &aliases, place, &mut touched);
                    }
                }
                Effect::Use { place } => note(graph, &aliases, place, &mut summary.uses),
                Effect::Return(value) => {
                    if let Some(place) = &value.place {
                        for (part, root) in aliases.parts(place) {
                            if let Some(Given { base: GivenBase::Param(param), steps }) = given(graph, &root) {
                                summary.returns.insert(Borrow { part, param, steps });
                            }
                        }
                    }
                    let heads = value.head.as_ref().map_or(returned::ANY, |head| returned::bit(program.variants, head));
                    summary.heads |= returned::of_function(program, graph.function, heads);
                }
                _ => {}
            }
        }
        moves::copied_elements(program.index, graph).for_each(|place| note(graph, &aliases, &place, &mut summary.uses));
        let updates = !touched.is_empty();
        if !updates {
            summary.heads = returned::of_reader(program, graph.function, summary.heads);
        }
        summary.keeps = kept::params(program.index, graph, &aliases, self);
        summary.takes_out = kept::taken_out(program.index, graph, &aliases, self);
        summary.puts = kept::handles(program.index, graph, &aliases, self);
        summary.assigns = assigned::find(program.index, graph, &aliases, self);
        summary.uses.retain(|given| holds_filter_at(program.index, graph, &instance_of(graph, given)));
        summary.returns.extend(moves::given_back(program.index, graph, self));
        summary.copies = moves::copied_back(program.index, graph, self);
        if summary.returns.len() > MAX_PLACES {
            let whole =
                |borrow: &Borrow| Borrow { part: Steps::default(), param: borrow.param, steps: Steps::default() };
            summary.returns = summary.returns.iter().map(whole).collect();
        }
        summary.given_heads = given_heads::find(graph, &aliases, self);
        summary.chosen_resets = chosen_resets::find(program.index, graph, &aliases, self);
        summary.chosen = chosen_returns::find(program, graph, self, &summary.returns);
        bound(&mut summary.uses);
        bound(&mut summary.writes);
        summary.alters = super::alters::find(graph, &aliases, self);
        summary.writes_if_present = only_with::present(graph, &aliases, self, &summary.writes);
        if summary.sets.len() > MAX_PLACES {
            summary.sets = summary.writes.iter().map(|given| (given.clone(), None, None)).collect();
        }
        for update in debug_only::updates(graph, &aliases, self) {
            if let Some(given) = given(graph, &update.place)
                && debug_only::is_callers(graph, update.node)
                && summary.debug_only.len() < MAX_PLACES
            {
                summary.debug_only.entry((given, update.law)).or_insert(update.why);
            }
        }
        if let Some(cause) = aliases.limit() {
            for param in &graph.params {
                note_unknown(graph, &aliases, &Place::var(*param), &cause, &mut unknown);
            }
        }
        self.judge(program, graph, &aliases, (touched, unknown), &mut summary, searched);
        super::own_methods::add(program.index, graph, &mut summary);
        stand_ins::add(program, graph, &mut summary);
        finished::find(graph, &aliases, self, &mut summary);
        // Answers decide nothing that a recursion has to settle.
        if !self.is_recursion && self.answering.matters(graph.function) {
            summary.answers = answers(program, graph, &aliases, self);
            let given = summary.answers.iter().fold(0, |heads, answer| heads | answer.returned);
            if !updates && returned::of_reader(program, graph.function, given) != given {
                summary.answers.iter_mut().for_each(|answer| answer.returned = returned::ANY);
            }
        }
        summary
    }

    /// What a call passes on from its callees.
    fn add_call(
        &self,
        graph: &ControlFlowGraph,
        aliases: &Aliases,
        site: &CallSite,
        summary: &mut Summary,
        touched: &mut BTreeSet<Given>,
        unknown: &mut BTreeMap<Given, Cause>,
    ) {
        summary.calls.extend(&site.targets);
        summary.gives_next |= self.gives_next(site);
        for callee in site.targets.iter().filter_map(|target| self.get(*target)) {
            for (given, outcomes) in callee.all_outcomes() {
                let Some(place) = place_of(callee.reached(given), site) else { continue };
                match outcomes.as_slice() {
                    [Outcome { count: Count::Zero, reset: false, unknown: Some(cause), .. }] => {
                        note_unknown(graph, aliases, &place, cause, unknown);
                    }
                    _ => note(graph, aliases, &place, touched),
                }
            }
            for (set, head, change) in &callee.sets {
                let mut written = BTreeSet::new();
                if let Some(place) = place_of(set, site) {
                    note(graph, aliases, &place, &mut written);
                }
                summary.sets.extend(written.into_iter().map(|given| (given, head.clone(), *change)));
            }
            stand_ins::pass_on(graph, aliases, site, callee, summary);
            summary.unseen = summary.unseen.take().or_else(|| callee.unseen.clone());
            let Summary { writes, uses, endless, .. } = &mut *summary;
            for (from, into) in [(&callee.writes, writes), (&callee.uses, uses), (&callee.endless, endless)] {
                for place in from.iter().filter_map(|given| place_of(given, site)) {
                    note(graph, aliases, &place, into);
                }
            }
        }
    }

    /// Finds the ways through the function for each place that something happens to.
    fn judge(
        &self,
        program: &Program<'_>,
        graph: &ControlFlowGraph,
        aliases: &Aliases,
        (mut touched, mut unknown): (BTreeSet<Given>, BTreeMap<Given, Cause>),
        summary: &mut Summary,
        searched: &mut usize,
    ) {
        let ty_of = |given: &Given| super::instances::place_ty(program.index, graph, &instance_of(graph, given));
        let may_matter =
            |given: &Given| ty_of(given).is_none_or(|ty| super::instances::may_hold_filter(program.index, &ty));
        unknown.retain(|given, _| may_matter(given) && !touched.contains(given));
        // A recursion settles only if what was unknown in the round before is so for good.
        for (given, ways) in self.of.get(&graph.function).into_iter().flat_map(|before| before.outcomes(0)) {
            if let [Outcome { count: Count::Zero, reset: false, unknown: Some(cause), .. }] = ways.as_slice() {
                unknown.insert(given.clone(), cause.clone());
            }
        }
        // What may have happened to one of many numbers says nothing of the filters beside it.
        let is_number = |given: &Given| ty_of(given).is_some_and(|ty| crate::index::is_number(&ty));
        let (numbers, others): (BTreeMap<_, _>, BTreeMap<_, _>) =
            unknown.into_iter().partition(|(given, _)| is_number(given));
        for (given, cause) in with_wholes(others, MAX_PLACES).into_iter().chain(with_wholes(numbers, MAX_NUMBERS)) {
            if !touched.contains(&given) {
                summary.insert(&given, &[Outcome::unknown(cause)]);
            }
        }
        if touched.is_empty() {
            return;
        }
        let dependence = ControlDependence::of(graph, aliases);
        for given in touched.iter().filter(|given| given.is_known_part()) {
            for each in given.clone().numbered() {
                let is_only = |other: &Given| other == given || !other.clone().numbered().contains(&each);
                if touched.iter().all(is_only) {
                    summary.taken.insert(each, given.clone());
                }
            }
        }
        touched = carried_over::by_filters(program.index, graph, aliases, self, touched);
        touched = touched.into_iter().flat_map(Given::numbered).collect();
        // Where one element is named, each of the others is another instance.
        let places = touched.iter().map(|given| instance_of(graph, given)).collect();
        let elements = super::instances::settle_elements(program.index, graph, &places);
        touched.extend(elements.iter().filter_map(|place| given(graph, place)));
        if touched.len() > 4 * MAX_PLACES {
            let cause = Cause::Limit("a helper has too many places to do with".to_owned());
            bound(&mut touched);
            for given in touched {
                summary.insert(&given, &[Outcome::unknown(cause.clone())]);
            }
            return;
        }
        let states = self.states_of(graph, aliases);
        for given in touched {
            let instance = instance_of(graph, &given);
            if !may_matter(&given) && !states.contains(&instance) {
                continue;
            }
            // What is only passed on, and of a type that is not known, is not worth a search: it is said to be unknown.
            let is_direct = graph.node_ids().any(|id| match &graph.node(id).effect {
                Effect::Update(update) => aliases.shared_roots(&update.place).contains(&instance),
                Effect::Advance(advance) => aliases.shared_roots(&advance.before).contains(&instance),
                Effect::Write(write) => write.place == instance && replaces_generic(graph, id, &instance),
                _ => false,
            });
            let holds_filter =
                holds_filter_at(program.index, graph, &instance) || self.only_resets(graph, aliases, &instance);
            if !is_direct && !holds_filter && !states.contains(&instance) {
                let cause = if is_moved(graph, &instance) {
                    Cause::Moved(program.index.function(graph.function).name.clone())
                } else {
                    Cause::Limit("the type of what a helper passes on is not known".to_owned())
                };
                summary.insert(&given, &[Outcome::unknown(cause)]);
                continue;
            }
            let mut runs_cycles = None;
            for law in 0..program.index.halves() {
                let search = Search::with_dependence(program, graph, aliases, self, &instance, law, &dependence);
                let is_updated = !search.updating().is_empty();
                if !is_updated {
                    if let Some(cause) = search.unknown_cause() {
                        summary.halves[law].insert(given.clone(), vec![Outcome::unknown(cause)]);
                        continue;
                    }
                    if !holds_filter && !is_direct && !search.is_advanced() {
                        continue;
                    }
                }
                if is_updated {
                    runs_cycles = Some(runs_cycles != Some(false) && own_cycles::runs(&search));
                }
                let outcomes = if *searched > most_states(self.is_recursion) {
                    vec![Outcome::unknown(too_many_ways(self.is_recursion))]
                } else {
                    let ways = search.ways(Region::Function);
                    *searched += ways.states;
                    summary.shown.repeats.extend(ways.repeat.map(|repeat| ((given.clone(), law), repeat)));
                    summary.shown.skips.extend(ways.skip.map(|skip| ((given.clone(), law), skip)));
                    if !self.is_recursion && !ways.outcomes.is_empty() {
                        // A head that no way has is not given back, whatever a caller asks about.
                        summary.heads &= ways.heads;
                    }
                    ways.outcomes
                };
                let unreset = super::gates::set_without_reset(&search, &outcomes).into_iter();
                summary.unreset.extend(unreset.map(|(set, head)| (set, head, given.clone())));
                summary.endless.extend((is_updated && outcomes.is_empty()).then(|| given.clone()));
                summary.mixed.extend((search.behind.len() > 1).then(|| given.clone()));
                summary.uneven.extend(uneven::is_uneven(&search, &given, &summary.taken).then(|| given.clone()));
                summary.paced.entry(given.clone()).or_default().extend(super::gates::paced_by(&search, &outcomes));
                turns::note(&search, &given, summary);
                summary.halves[law].insert(given.clone(), outcomes);
                if !summary.feeds.contains_key(&given) {
                    let (params, objects) = super::gates::fed_from(&search);
                    summary.feeds.insert(given.clone(), params);
                    summary.feeds_from.insert(given.clone(), objects);
                }
                summary.measures.entry(given.clone()).or_default().extend(super::gates::measured_by(&search));
            }
            summary.cycles.extend((runs_cycles == Some(true)).then_some(given));
        }
    }
}
