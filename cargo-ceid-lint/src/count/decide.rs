//! From all ways through a cycle to a verdict, with the shortest way that shows it.

use super::counts::Count;
use super::entered;
use super::functions::own_affair;
use super::gates::Gates;
use super::instances;
use super::missed::{missed, missed_or_off};
use super::oversampled::runs_by_samples;
use super::own_cycles;
use super::picked::{may_be_apart, may_be_of_rows, rows_not_followed};
use super::returned;
use super::samples;
use super::search::{End, EndKind, Exploration, Region, Search, Start, too_many_conditions, which_variant};
use super::skips::{
    ends_early, is_behind_number, is_by_key, is_of_nothing, is_passed_by_search, is_passed_over, loop_left, skip_place,
    trades_places,
};
use super::taken_out;
use super::verdict::{Evidence, Gate, Verdict};
use super::warm_ups::is_run_in;
use super::witness::{is_closure_call, steps, steps_inside};
use crate::diagnostic::WitnessStep;
use crate::flow::{Cause, Effect, IndexKey, Place};
use crate::index::{FunctionId, Index};
use crate::source::Span;

/// How many places are kept at which a filter is skipped, for the case that some of them are known to the user.
const MOST_PLACES: usize = 16;

/// What was decided for a pair.
#[derive(Clone, Debug)]
pub(super) struct Decision {
    pub(super) verdict: Verdict,
    pub(super) counts: Vec<u8>,
    pub(super) gate: Option<Gate>,
    pub(super) cause: Option<Cause>,
    pub(super) witness: Vec<WitnessStep>,
    pub(super) primary: Option<Span>,
    /// The call through which the finding is shown in another function.
    pub(super) through: Option<Span>,
    pub(super) others: Vec<Evidence>,
    /// Whether a way skips as well, where another one repeats.
    pub(super) skips: bool,
    pub(super) law: Option<String>,
}

impl Decision {
    /// Nothing is said of the pair, for this cause.
    pub(super) fn unproved(cause: Cause) -> Self {
        Self {
            verdict: Verdict::Unproved,
            counts: Vec::new(),
            gate: None,
            cause: Some(cause),
            witness: Vec::new(),
            primary: None,
            through: None,
            others: Vec::new(),
            skips: false,
            law: None,
        }
    }

    /// How the crate that brings the filters of a preset runs the parts of its own laws is not for the preset to judge.
    pub(super) fn unless_own_affair(self, index: &Index, function: FunctionId) -> Self {
        if !matches!(self.verdict, Verdict::Missed | Verdict::Repeated | Verdict::Skipped) {
            return self;
        }
        let Some(cause) = own_affair(index, function) else { return self };
        Self { primary: self.primary, counts: self.counts, ..Self::unproved(Cause::Limit(cause)) }
    }
}

/// How the ways through a function come to a second update, if one does.
pub(super) fn repeat_of(search: &Search<'_>, exploration: &Exploration) -> Option<Evidence> {
    let is_many = |end: &&End| end.state.count == Count::Many && !end.state.is_supposed;
    let end = shortest(exploration, exploration.ends.iter().filter(is_many))?;
    if search.asks_dropped(exploration, end) {
        return None;
    }
    let witness = steps_inside(search, exploration, end);
    if let Some(inner) = changes(exploration, end).find_map(|(at, after)| inner_repeat(search, exploration, at, after))
    {
        return Some(Evidence { primary: inner.primary, witness });
    }
    let primary = changes(exploration, end).find_map(|(at, after)| second_update(search, exploration, at, after))?;
    Some(Evidence { primary, witness })
}

/// How the ways through a function come to skip what others of them update, if they do without a reason that is known and are all
/// the same to those who call it.
pub(super) fn skip_of(search: &Search<'_>, gates: &Gates<'_, '_>, exploration: &Exploration) -> Option<Evidence> {
    let (skipping, updating): (Vec<&End>, Vec<&End>) =
        exploration.ends.iter().partition(|end| end.state.count == Count::Zero);
    let is_unexplained = |end: &&&End| {
        !end.state.reset && !end.state.attempted && !end.state.is_supposed && gates.of_end(exploration, end).is_none()
    };
    // What those who call it know may explain a way to them.
    let (asking, plain): (Vec<&End>, Vec<&End>) =
        skipping.iter().filter(is_unexplained).partition(|end| gates.asks(exploration, end).is_some());
    let unexplained = if plain.is_empty() { asking } else { plain };
    let end = shortest(exploration, unexplained.iter().copied())?;
    let is_one = unexplained.iter().all(|other| other.returned == end.returned);
    if updating.is_empty() || !is_one || search.asks_dropped(exploration, end) {
        return None;
    }
    // `bank.iter_mut().try_for_each(|lag| …)` has no statement that skips.
    let early = loop_left(search, exploration, end).and_then(|place| ends_early(search, exploration, end, place));
    let place = skip_place(search, exploration, end).map(|(primary, _)| primary);
    let primary = place.or_else(|| early.as_ref().map(|step| step.span))?;
    let mut witness = steps_inside(search, exploration, end);
    witness.extend(gates.near_miss(exploration, end).into_iter().chain(early.filter(|_| place.is_none())));
    Some(Evidence { primary, witness })
}

/// The states of a way, each with the count behind it.
pub(super) fn changes<'e>(exploration: &'e Exploration, end: &'e End) -> impl Iterator<Item = (usize, Count)> + 'e {
    let path = exploration.path(end.at);
    let behind = path.iter().skip(1).map(|at| exploration.states[*at].count).chain([end.state.count]);
    let changes: Vec<(usize, Count)> = path.iter().copied().zip(behind).collect();
    changes.into_iter()
}

/// How a call comes to both updates, where a state has seen none and the one behind it two.
pub(super) fn inner_repeat<'s>(
    search: &'s Search<'_>,
    exploration: &Exploration,
    at: usize,
    after: Count,
) -> Option<&'s Evidence> {
    let before = &exploration.states[at];
    if before.count != Count::Zero || after != Count::Many {
        return None;
    }
    match &search.graph.node(before.node).effect {
        Effect::Call(site) => search.repeat_in(site),
        _ => None,
    }
}

/// Whether only guards and destructors would update the filter, and each of them that was to do it never ends.
fn is_let_go(search: &Search<'_>) -> bool {
    let updating = search.updating();
    !updating.is_empty()
        && updating.into_iter().all(|at| match &search.graph.node(at).effect {
            Effect::Update(update) => update.run_by.is_guard(),
            Effect::GuardEnd(_) => true,
            Effect::Call(site) => site.is_destructor(),
            _ => false,
        })
}

/// Decides a pair of a cycle and an instance that some path of it updates.
pub(super) fn decide(search: &Search<'_>, region: Region, by_framework: bool) -> Decision {
    let starts = search.starts(region);
    let decision = decide_from(search, region, by_framework, &starts);
    let is_skipped = decision.verdict == Verdict::Skipped;
    let own = is_skipped.then(|| entered::with_its_name(search, region, by_framework, &starts, &decision)).flatten();
    let decision = own.unwrap_or(decision);
    // What a way puts in its place may have been updated there before, and have paused since.
    let pauses = decision.verdict == Verdict::OnceOrReset
        || matches!((decision.verdict, decision.gate), (Verdict::Gated, Some(Gate::Config | Gate::Mode)));
    if pauses && search.is_parked(region) {
        return Decision { primary: decision.primary, ..Decision::unproved(in_its_place(search)) };
    }
    if decision.verdict.is_proved() && taken_out::goes_back(search, region) {
        return Decision { primary: decision.primary, ..Decision::unproved(in_its_place(search)) };
    }
    if decision.verdict != Verdict::Repeated && (search.is_led_to_by_elements() || search.is_behind_shared_references())
    {
        let cause = Cause::Limit("several elements of a collection may be references to it".to_owned());
        return Decision { primary: decision.primary, counts: decision.counts, ..Decision::unproved(cause) };
    }
    if decision.verdict.is_proved() && search.is_chosen_by_callee() {
        return Decision { primary: decision.primary, ..Decision::unproved(which_variant()) };
    }
    decision
}

/// Why it is not known which filter a name stands for.
fn in_its_place(search: &Search<'_>) -> Cause {
    let name = search.graph.place_name(search.program.index, search.instance);
    Cause::Code(format!("what stands in the place of `{name}` by then"))
}

/// The same where the region is entered in these ways only.
pub(super) fn decide_from(search: &Search<'_>, region: Region, by_framework: bool, starts: &[Start]) -> Decision {
    let exploration = search.explore(region, starts);
    let mut ends: Vec<End> = exploration.ends.clone();
    if region == Region::Function && by_framework {
        // An error, `None` or `Ready` ends the run of a cycle function, and so does `Flow::Stop`.
        let stop = returned::stop(search.program, search.graph.function);
        for end in &mut ends {
            if end.returned == returned::ABSENT || Some(end.returned) == stop {
                end.kind = EndKind::Exits;
            }
        }
    }
    // Without a fallback the attempt itself counts as the update.
    for end in ends.iter_mut().filter(|end| end.state.attempted) {
        end.state.count = end.state.count.then(Count::One);
    }
    let is_there = |end: &&End| end.state.count != Count::Zero || !is_of_nothing(search, &exploration, end);
    let completing: Vec<&End> = ends.iter().filter(|end| end.kind == EndKind::Completes).filter(is_there).collect();
    let mut counts: Vec<u8> = completing.iter().map(|end| end.state.count.number()).collect();
    counts.sort_unstable();
    counts.dedup();
    let base = Decision {
        verdict: Verdict::Once,
        counts,
        gate: None,
        cause: None,
        witness: Vec::new(),
        primary: None,
        through: None,
        others: Vec::new(),
        skips: false,
        law: super::laws::law_name(search),
    };
    let is_certain = ends.iter().all(|end| end.state.unknown.is_none()) && !exploration.limit;
    if is_certain && base.counts == [Count::Many.number()] && runs_by_samples(search, region) {
        return Decision { verdict: Verdict::PerSample, counts: vec![1], ..base };
    }
    let many: Vec<&End> = ends.iter().filter(|end| end.state.count == Count::Many && !end.state.is_supposed).collect();
    let (doubtful, certain): (Vec<&End>, Vec<&End>) =
        many.into_iter().partition(|end| search.asks_what_a_call_sets(&exploration, end));
    if !doubtful.is_empty() && certain.is_empty() {
        let cause = Cause::Limit(
            "whether a call updates it shows in what it sets or gives back, which is not followed".to_owned(),
        );
        return Decision { verdict: Verdict::Unproved, cause: Some(cause), ..base };
    }
    if !certain.is_empty() {
        // Phases one after another, each with a loop that is its cycle: there is no cycle of both.
        if own_cycles::are_called(search, region) {
            return Decision { verdict: Verdict::PerSample, counts: vec![1], ..base };
        }
        if is_run_in(search, region, &exploration) {
            let cause = Cause::Limit("a loop runs it in behind its reset, and may belong to that".to_owned());
            return Decision { verdict: Verdict::Unproved, cause: Some(cause), ..base };
        }
        let exists = |end: &&End| !search.asks_dropped(&exploration, end);
        let (apart, existing): (Vec<&End>, Vec<&End>) =
            certain.into_iter().filter(exists).partition(|end| may_be_apart(search, &exploration, end));
        let (by_rows, existing): (Vec<&End>, Vec<&End>) =
            existing.into_iter().partition(|end| may_be_of_rows(search, &exploration, end));
        if existing.is_empty() && !by_rows.is_empty() {
            return Decision { verdict: Verdict::Unproved, cause: Some(rows_not_followed()), ..base };
        }
        let Some(end) = shortest(&exploration, existing.into_iter()) else {
            let name = || search.graph.place_name(search.program.index, search.instance);
            let cause = if apart.is_empty() { too_many_conditions() } else { Cause::Index(name()) };
            return Decision { verdict: Verdict::Unproved, cause: Some(cause), ..base };
        };
        let base = Decision { skips: skips_without_reason(search, region, &exploration, &completing), ..base };
        return repeated(search, region, &exploration, end, base);
    }
    // How many samples there are is not known, whatever the other ways do, and wherever they lead.
    let has_samples = ends.iter().any(|end| end.state.count == Count::PerSample);
    if let Some(decision) = has_samples.then(|| samples::repeating(search, region)).flatten() {
        return decision;
    }
    if exploration.limit {
        let cause = Cause::Limit("the cycle has too many paths".to_owned());
        return Decision { verdict: Verdict::Unproved, cause: Some(cause), ..base };
    }
    if completing.is_empty() && exploration.leaves_out_copies {
        let cause = Cause::Code("which of several copies of it goes on in its place".to_owned());
        return Decision { verdict: Verdict::Unproved, cause: Some(cause), ..base };
    }
    if let Some(cause) = &search.graph.truncated {
        return Decision { verdict: Verdict::Unproved, cause: Some(cause.clone()), ..base };
    }
    if let Some(end) = ends.iter().find(|end| end.state.unknown.is_some()) {
        let cause = end.state.unknown.map(|cause| exploration.causes[cause as usize].clone());
        return Decision { verdict: Verdict::Unproved, cause, ..base };
    }
    if let Some(cause) = kept_elsewhere(search) {
        return Decision { verdict: Verdict::Unproved, cause: Some(cause.clone()), ..base };
    }
    // The updates that are there are another element's, or dead.
    let is_untouched = ends.iter().all(|end| end.state.count == Count::Zero && !end.state.reset);
    let is_element = search.instance.steps.iter().any(|step| matches!(step.key(), Some(IndexKey::Number(_))));
    if is_untouched && (is_element || is_let_go(search)) && !completing.is_empty() {
        return missed_or_off(search, region, &exploration, &completing, base);
    }
    // Which element of a map is passed over depends on its key.
    if instances::is_in_map(search.program.index, search.graph, search.instance)
        && completing.iter().any(|end| end.state.count == Count::Zero && !end.state.reset && is_by_key(search, end))
    {
        let name = search.graph.place_name(search.program.index, search.instance);
        return Decision { verdict: Verdict::Unproved, cause: Some(Cause::Index(name)), ..base };
    }
    let skipping: Vec<&End> =
        completing.iter().copied().filter(|end| end.state.count == Count::Zero && !end.state.reset).collect();
    if skipping.is_empty() {
        let resets = completing.iter().any(|end| end.state.count == Count::Zero);
        let updates = ends.iter().filter(|end| end.state.count != Count::Zero);
        let direct = updates.clone().any(|end| end.state.direct);
        if let Some(decision) = has_samples.then(|| samples::skipping(search, region, by_framework)).flatten() {
            return decision;
        }
        let verdict = match (resets, direct) {
            _ if has_samples => Verdict::PerSample,
            (true, _) => Verdict::OnceOrReset,
            (false, true) => Verdict::Once,
            (false, false) if updates.count() > 0 => Verdict::Guarded,
            (false, false) => Verdict::Once,
        };
        return Decision { verdict, ..base };
    }
    // Which element a search finds depends on data.
    let gates = Gates::new(search, region);
    let (found, skipping): (Vec<&End>, Vec<&End>) = skipping.into_iter().partition(|end| {
        is_passed_by_search(search, region, end)
            || is_behind_number(search, &exploration, end) && gates.of_end(&exploration, end).is_none()
    });
    if !found.is_empty() {
        let name = search.graph.place_name(search.program.index, search.instance);
        let chosen = Decision { verdict: Verdict::Unproved, cause: Some(Cause::Index(name)), ..base.clone() };
        let decision = skipped(&gates, region, &exploration, &skipping, base);
        return if decision.verdict == Verdict::Skipped { decision } else { chosen };
    }
    // An update that no way reaches is one of an element of a collection in a collection: which one is not known.
    let is_nested = search.instance.steps.iter().filter(|step| step.key().is_some()).count() > 1;
    if is_untouched && is_nested {
        let name = search.graph.place_name(search.program.index, search.instance);
        return Decision { verdict: Verdict::Unproved, cause: Some(Cause::Index(name)), ..base };
    }
    // What updates it under another name only, as after a swap, may do so in another iteration.
    if is_untouched && !search.is_updated_by_name() || trades_places(search, region) {
        let cause = search.unknown_cause().unwrap_or_else(|| in_its_place(search));
        return Decision { verdict: Verdict::Unproved, cause: Some(cause), ..base };
    }
    // Elements that are passed over have no samples in this round; those of the others are counted where their loop is.
    let mut updating = ends.iter().filter(|end| end.state.count != Count::Zero);
    if updating.all(|end| end.state.count == Count::PerSample)
        && skipping.iter().all(|end| is_passed_over(search, &exploration, end))
    {
        return Decision { verdict: Verdict::PerSample, ..base };
    }
    let decision = skipped(&gates, region, &exploration, &skipping, base.clone());
    // What a called function does in cycles of its own is owed nothing where it is not called.
    if decision.verdict == Verdict::Skipped && own_cycles::are_called(search, region) {
        return Decision { verdict: Verdict::PerSample, ..base };
    }
    // A counter that never comes to its gate is no rate, and a state that never comes to its update no mode.
    let never_opens = decision.verdict == Verdict::Skipped || matches!(decision.gate, Some(Gate::Rate | Gate::Mode));
    if is_untouched && never_opens {
        return missed(search, region, head_of(search, region), Decision { gate: None, ..decision });
    }
    decision
}

/// Why a filter may be updated at any time: a clone of its handle, or a pointer to it, is somewhere else.
pub(super) fn kept_elsewhere<'s>(search: &'s Search<'_>) -> Option<&'s Cause> {
    let is_kept = |place: &Place| search.aliases.shared_roots(place).iter().any(|root| root.overlaps(search.instance));
    search.graph.kept.iter().find(|(place, _)| is_kept(place)).map(|(_, cause)| cause)
}

fn skipped(
    gates: &Gates<'_, '_>,
    region: Region,
    exploration: &Exploration,
    skipping: &[&End],
    base: Decision,
) -> Decision {
    let search = gates.search;
    let mut kinds: Vec<(Span, Gate)> = Vec::new();
    let mut ends = skipping.to_vec();
    ends.sort_by_key(|end| length(exploration, end));
    let mut ends = ends.into_iter();
    let mut doubt = None;
    let unexplained = ends.find(|end| match gates.of_end(exploration, end) {
        Some(gate) => {
            let span = end.state.skipped_at.map(|at| search.graph.node(at).span);
            let span = span.or_else(|| loop_left(search, exploration, end));
            kinds.extend(span.map(|span| (span, gate)));
            false
        }
        None => match gates.doubt(end).or_else(|| search.asks_dropped(exploration, end).then(too_many_conditions)) {
            Some(cause) => {
                doubt.get_or_insert(cause);
                false
            }
            None => true,
        },
    });
    match unexplained {
        None if doubt.is_some() => Decision { verdict: Verdict::Unproved, cause: doubt, ..base },
        None => {
            // Of nested gates the outer one comes first.
            let gate = kinds.into_iter().min_by_key(|(span, _)| *span).map(|(_, gate)| gate);
            Decision { verdict: Verdict::Gated, gate, ..base }
        }
        Some(end) => {
            let mut witness = steps(search, region, exploration, end);
            witness.extend(gates.near_miss(exploration, end));
            let place = skip_place(search, exploration, end);
            let primary = place.map(|(primary, _)| primary).or_else(|| loop_left(search, exploration, end));
            let primary = primary.unwrap_or_else(|| head_of(search, region));
            witness.extend(ends_early(search, exploration, end, primary));
            let through = place.and_then(|(_, through)| through);
            let others = other_skips(gates, region, exploration, ends, primary);
            Decision { verdict: Verdict::Skipped, witness, primary: Some(primary), through, others, ..base }
        }
    }
}

/// Whether one of these ways neither updates nor resets, and no gate tells why.
fn skips_without_reason(search: &Search<'_>, region: Region, exploration: &Exploration, ends: &[&End]) -> bool {
    let gates = Gates::new(search, region);
    let mut skipping = ends.iter().filter(|end| end.state.count == Count::Zero && !end.state.reset);
    skipping.any(|end| gates.of_end(exploration, end).is_none())
}

/// The first few places besides one at which a way skips without a reason, each with its shortest way.
fn other_skips<'e>(
    gates: &Gates<'_, '_>,
    region: Region,
    exploration: &Exploration,
    ends: impl Iterator<Item = &'e End>,
    first: Span,
) -> Vec<Evidence> {
    let search = gates.search;
    let mut others: Vec<Evidence> = Vec::new();
    for end in ends {
        let Some((primary, _)) = skip_place(search, exploration, end) else { continue };
        let is_known = first == primary || others.iter().any(|other| other.primary == primary);
        // Why a way skips takes longer to find out than where.
        if !is_known && gates.of_end(exploration, end).is_none() && !search.asks_dropped(exploration, end) {
            others.push(Evidence { primary, witness: steps(search, region, exploration, end) });
        }
        if others.len() == MOST_PLACES {
            break;
        }
    }
    others
}

fn repeated(search: &Search<'_>, region: Region, exploration: &Exploration, end: &End, base: Decision) -> Decision {
    let witness = steps(search, region, exploration, end);
    let path = exploration.path(end.at);
    let second = changes(exploration, end).find_map(|(at, after)| second_update(search, exploration, at, after));
    let inner = changes(exploration, end).find_map(|(at, after)| inner_repeat(search, exploration, at, after));
    let through = inner.and(second);
    let second = inner.map(|repeat| repeat.primary).or(second);
    let primary = second.or_else(|| path.last().map(|at| search.graph.node(exploration.states[*at].node).span));
    let mut others: Vec<Evidence> = Vec::new();
    for at in 0..exploration.states.len() {
        let Some(before) = exploration.parent(at) else { continue };
        let Some(place) = second_update(search, exploration, before, exploration.states[at].count) else { continue };
        if primary != Some(place)
            && through != Some(place)
            && others.iter().all(|other| other.primary != place)
            && others.len() < MOST_PLACES
        {
            let end = End { at, state: exploration.states[at].clone(), ..end.clone() };
            others.push(Evidence { primary: place, witness: steps(search, region, exploration, &end) });
        }
    }
    Decision { verdict: Verdict::Repeated, witness, primary, through, others, ..base }
}

/// The place of the update behind which the count is two. Where a closure runs that has updated it before, that is its call.
fn second_update(search: &Search<'_>, exploration: &Exploration, before: usize, after: Count) -> Option<Span> {
    let count_of = |at: usize| exploration.states[at].count;
    let span_of = |at: usize| search.graph.node(exploration.states[at].node).span;
    if count_of(before) == Count::Many || after != Count::Many {
        return None;
    }
    let way = || std::iter::successors(Some(before), |at| exploration.parent(*at));
    let is_again = || {
        way().zip(way().skip(1)).any(|(after, at)| count_of(after) != count_of(at) && span_of(at) == span_of(before))
    };
    let call = way().find(|at| is_closure_call(search, exploration.states[*at].node));
    Some(span_of(call.filter(|_| is_again()).unwrap_or(before)))
}

/// The order of ways: by their length, and the one that was found first.
fn length(exploration: &Exploration, end: &End) -> (u32, usize) {
    (exploration.depth(end.at), end.at)
}

fn shortest<'e>(exploration: &Exploration, ends: impl Iterator<Item = &'e End>) -> Option<&'e End> {
    ends.min_by_key(|end| length(exploration, end))
}

/// The keyword at the head of a cycle.
pub(super) fn head_of(search: &Search<'_>, region: Region) -> Span {
    match region {
        Region::Loop(id) => {
            let info = search.graph.loop_info(id);
            info.cycle_head().map_or(info.keyword, |(head, _)| head)
        }
        Region::Function => search.program.index.function(search.graph.function).function.keyword,
    }
}
