//! Where a way goes past the updates: the statement, the call or the loop that skips.

use std::collections::BTreeSet;

use super::counts::Count;
use super::fed::named;
use super::gates::Asks;
use super::given::place_of;
use super::search::{End, Exploration, Region, Search};
use super::verdict::Evidence;
use super::witness::ENDS_EARLY;
use crate::diagnostic::WitnessStep;
use crate::flow::{Effect, IndexKey, LoopId, Mark, NodeId, Place, Projection, Relation, Subject, Transfer};
use crate::source::Span;

/// The statement that skips: the way out that is taken, the arm, or the condition that fails. Where it is in a function that is
/// called, the call as well.
pub(super) fn skip_place(search: &Search<'_>, exploration: &Exploration, end: &End) -> Option<(Span, Option<Span>)> {
    if let Some(at) = skips_in_round(search, exploration, end) {
        let node = exploration.states[at].node;
        return skip_inside(search, node).map(|inner| (inner.primary, Some(search.graph.node(node).span)));
    }
    let Some(decided) = end.state.skipped_at else {
        return way_out_of_rounds(search, exploration, end).map(|out| (search.graph.node(out).span, None));
    };
    let nodes: Vec<NodeId> = exploration.path(end.at).iter().map(|at| exploration.states[*at].node).collect();
    let from = nodes.iter().position(|node| *node == decided)?;
    let behind = &nodes[from..];
    let way_out = (0..behind.len()).rev().find(|at| {
        matches!(search.graph.node(behind[*at]).effect, Effect::Mark(Mark::Continue | Mark::Return | Mark::Break))
            && !stays_beside(search, &behind[*at..])
            && !is_decided_behind(search, end, &behind[..=*at])
    });
    let way_out = way_out.map(|at| &behind[at]);
    let arm = behind.iter().find(|node| matches!(search.graph.node(**node).effect, Effect::Mark(Mark::Arm)));
    let is_match = matches!(&search.graph.node(decided).effect, Effect::Branch(test)
        if test.text.contains(" is ") || test.about.is_guard);
    let shown = match skips_by_itself(search, exploration, end) {
        true => decided,
        false => *way_out.or(arm.filter(|_| is_match)).unwrap_or(&decided),
    };
    let span = search.graph.node(shown).span;
    let inner = skip_inside(search, shown);
    Some(inner.map_or((span, None), |inner| (inner.primary, Some(span))))
}

/// Whether the way out at the end of a path is taken for a reason of its own, which was asked for when no update could follow any
/// more: another `continue` would have skipped no less.
pub(super) fn is_decided_behind(search: &Search<'_>, end: &End, path: &[NodeId]) -> bool {
    let Some((way_out, before)) = path.split_last() else { return false };
    let Some(decided) = end.state.skipped_at else { return false };
    let mut behind = before.iter().skip_while(|node| **node != decided).skip(1);
    behind.any(|node| *node != decided && search.decides(*node, *way_out))
}

/// Whether a way does not update because the collection is empty that holds the instances: there is none to update.
pub(super) fn is_of_nothing(search: &Search<'_>, exploration: &Exploration, end: &End) -> bool {
    let graph = search.graph;
    let Some(at) = end.state.skipped_at else { return false };
    let Effect::Branch(test) = &graph.node(at).effect else { return false };
    let Some(subject) = test.subject.map(|id| &graph.subjects[id.0 as usize]) else { return false };
    let [asked] = subject.reads.as_slice() else { return false };
    let mut path = exploration.path(end.at).into_iter().map(|at| exploration.states[at].node);
    if !path.any(|node| node == at) {
        return false;
    }
    let taken = if graph.node(at).next.first() == path.next().as_ref() { test.holds } else { test.fails };
    let instance = search.instance;
    let is_around = |root: &Place| {
        root.base == instance.base
            && instance.steps.starts_with(&root.steps)
            && instance.steps.get(root.steps.len()).is_some_and(|step| step.key().is_some())
    };
    let is_told = |key: &str, collection: &Place| {
        is_empty_head(key, subject, taken) && search.aliases.shared_roots(collection).iter().any(is_around)
    };
    is_told(&subject.key, asked)
        || length_asked_before(search, asked, at).is_some_and(|(name, collection)| {
            let key =
                format!(".{name}(){}", subject.key.trim_start_matches(|of: char| of == '(' || of.is_alphanumeric()));
            is_told(&key, collection)
        })
}

/// The collection whose length a variable is, and how it was asked, if nothing stands between that and a condition:
/// `let count = self.filters.len(); if count == 0 { … }`.
fn length_asked_before<'a>(search: &Search<'a>, asked: &Place, at: NodeId) -> Option<(&'a str, &'a Place)> {
    let graph = search.graph;
    let computed = graph.computed.get(&asked.base_var().filter(|_| asked.steps.is_empty())?)?;
    let places = named(&computed.places);
    let ([name], [collection]) = (computed.calls.as_slice(), places.as_slice()) else { return None };
    let is_given = |id: &NodeId| match &graph.node(*id).effect {
        Effect::Write(write) | Effect::Set(write) => write.place == *asked,
        _ => false,
    };
    let mut given = graph.node_ids().filter(is_given);
    let (Some(given), None) = (given.next(), given.next()) else { return None };
    let (from, to) = (graph.node(given).span, graph.node(at).span);
    let between = (from.file == to.file && from.end <= to.start).then(|| Span::new(from.file, from.end, to.start))?;
    // Behind the end of the statement there is nothing but the word for the condition.
    let (_, behind) = search.program.sources.snippet(between).split_once(';')?;
    let is_plain = behind.split(['!', '(']).all(|word| matches!(word.trim(), "" | "if"));
    (matches!(name.as_str(), "len" | "is_empty") && is_plain).then_some((name.as_str(), *collection))
}

/// Whether what is left of the answers says that a collection is empty: `is_empty()`, `len() == 0`, `len() > 0`, no `first_mut()`.
fn is_empty_head(key: &str, subject: &Subject, taken: u32) -> bool {
    let empty = match key.trim_end_matches([')', '(']) {
        key if key.ends_with(".is_empty") => "true",
        key if key.ends_with(".len") => "0",
        key if key.ends_with(".len() <= 0") => "true",
        key if key.ends_with(".len() < 1") => "true",
        key if key.contains(".len() among [0.0") => "At(0)",
        key if [".first_mut", ".last_mut", "split_first_mut", "split_last_mut"]
            .iter()
            .any(|end| key.ends_with(end)) =>
        {
            "-"
        }
        _ => return false,
    };
    subject.heads.iter().any(|head| head == empty) && taken & subject.anything() == subject.bit(empty)
}

/// Whether the way out at the beginning of a path leads out of nothing but rounds or loops in which the instance is not updated, so
/// that it skips nothing.
pub(super) fn stays_beside(search: &Search<'_>, path: &[NodeId]) -> bool {
    let graph = search.graph;
    let Some((at, behind)) = path.split_first() else { return false };
    let updating = search.updating();
    let updates = |id: LoopId| updating.iter().any(|node| graph.is_within(graph.node(*node).in_loop, id));
    let around: Vec<LoopId> = graph.loops_around(*at).collect();
    let head = behind.iter().find_map(|node| match graph.node(*node).effect {
        Effect::LoopHead(id) => Some(id),
        _ => None,
    });
    if matches!(graph.node(*at).effect, Effect::Mark(Mark::Break)) {
        let inner = around.first().copied();
        let left = behind
            .iter()
            .map(|node| graph.node(*node).in_loop)
            .find(|id| !inner.is_some_and(|inner| graph.is_within(*id, inner)));
        let Some(left) = left else { return false };
        let ended: Vec<LoopId> = around.into_iter().take_while(|id| left != Some(*id)).collect();
        return !ended.is_empty() && !ended.into_iter().any(updates);
    }
    head.is_some_and(|id| around.contains(&id) && !updates(id))
}

/// Whether a way skips inside what it calls, and the way out that follows is not why: nothing asks for it, or other ways that skip
/// there go on in another one.
pub(super) fn skips_by_itself(search: &Search<'_>, exploration: &Exploration, end: &End) -> bool {
    let Some(decided) = end.state.skipped_at.filter(|decided| skip_inside(search, *decided).is_some()) else {
        return false;
    };
    let effect = |node: &NodeId| &search.graph.node(*node).effect;
    let behind = |end: &End| -> Vec<NodeId> {
        let nodes = exploration.path(end.at).into_iter().map(|at| exploration.states[at].node);
        nodes.skip_while(|node| *node != decided).collect()
    };
    let way_out = |end: &End| behind(end).into_iter().find(|node| matches!(effect(node), Effect::Mark(_)));
    let until_out = behind(end).into_iter().take_while(|node| !matches!(effect(node), Effect::Mark(_)));
    let is_asked = until_out.filter(|node| matches!(effect(node), Effect::Branch(_))).count() > 0;
    let alike = exploration.ends.iter().filter(|other| other.state.skipped_at == Some(decided));
    !is_asked || alike.map(way_out).collect::<BTreeSet<_>>().len() > 1
}

/// Whether a key may decide that a way goes past an element of a map: no loop over all of them runs the updates, or what it binds
/// is asked for.
pub(super) fn is_by_key(search: &Search<'_>, end: &End) -> bool {
    let graph = search.graph;
    // A key that is the same in each iteration means one entry, which is there or not.
    let is_fixed =
        |key: &IndexKey| !matches!(key, IndexKey::Each | IndexKey::Data(_) | IndexKey::Slice(_) | IndexKey::EachIn(_));
    if search.instance.steps.iter().filter_map(Projection::key).all(is_fixed) {
        return false;
    }
    let over_all = |node: NodeId| graph.loops_around(node).find(|id| search.covers(*id));
    let Some(decided) = end.state.skipped_at.filter(|_| search.updating().into_iter().all(|at| over_all(at).is_some()))
    else {
        return true;
    };
    match (&graph.node(decided).effect, over_all(decided)) {
        (Effect::Branch(test), Some(id)) => {
            let bound = &graph.loop_info(id).bound;
            let mut reads = test.about.reads.iter().filter_map(Place::base_var);
            reads.any(|var| search.aliases.is_derived(var, bound))
        }
        (_, over_all) => over_all.is_some(),
    }
}

/// Whether a way goes past the element that the instance is because a loop over all of them updates one at most, and something in the
/// loop chooses which: `for lag in &mut lags { if lag.is_due() { lag.update(x); break; } }`
pub(super) fn is_passed_by_search(search: &Search<'_>, region: Region, end: &End) -> bool {
    let graph = search.graph;
    if end.state.count != Count::Zero || end.state.reset {
        return false;
    }
    let updating = search.updating();
    let is_covering = |id: &LoopId| search.covers(*id) && region != Region::Loop(*id);
    let over_all = |node: NodeId| graph.loops_around(node).find(is_covering);
    let Some(id) = updating.first().and_then(|node| over_all(*node)) else { return false };
    let head = graph.loop_info(id).head;
    let leads_on = |node: &NodeId| search.reached_from(region, *node, |_, _| true)[head.0 as usize];
    let is_within = |node: NodeId| node == head || graph.is_within(graph.node(node).in_loop, id);
    let is_chosen = || {
        let round = graph.node(head).next.first();
        round.is_some_and(|round| {
            search.reached_from(region, *round, |node, _| !updating.contains(&node))[head.0 as usize]
        })
    };
    end.state.skipped_at.is_none_or(is_within)
        && updating.iter().all(|node| over_all(*node) == Some(id) && !leads_on(node))
        && is_chosen()
}

/// The loop that a way goes past because the number of the element may be behind the last one that it counts to.
pub(super) fn counted_past(search: &Search<'_>, exploration: &Exploration, end: &End) -> Option<LoopId> {
    let is_decided = end.state.skipped_at.is_some() || end.state.count != Count::Zero || end.state.reset;
    let passed = if is_decided { None } else { loop_passed(search, exploration, end) };
    passed.filter(|id| search.counts_to_number(*id))
}

/// Whether a way goes past the element that the instance is for nothing but its number, in a loop here or in a helper.
pub(super) fn is_behind_number(search: &Search<'_>, exploration: &Exploration, end: &End) -> bool {
    if end.state.count != Count::Zero || end.state.reset {
        return false;
    }
    let Some(at) = end.state.skipped_at else { return counted_past(search, exploration, end).is_some() };
    match &search.graph.node(at).effect {
        Effect::Call(site) => {
            let summaries = site.targets.iter().filter_map(|target| search.summaries.get(*target));
            let mut outcomes = summaries.flat_map(|summary| summary.outcomes(search.law));
            outcomes.any(|(given, outcomes)| {
                let is_number = outcomes.iter().filter_map(|outcome| outcome.asks.as_ref()).any(Asks::is_number);
                is_number
                    && place_of(given, site).is_some_and(|place| {
                        search.aliases.shared_roots(&place).iter().any(|root| root.overlaps(search.instance))
                    })
            })
        }
        _ => false,
    }
}

/// The loop over the elements that a way goes past without a round for this one, where no statement skips.
pub(super) fn loop_left(search: &Search<'_>, exploration: &Exploration, end: &End) -> Option<Span> {
    loop_passed(search, exploration, end).map(|id| search.graph.loop_info(id).keyword)
}

fn loop_passed(search: &Search<'_>, exploration: &Exploration, end: &End) -> Option<LoopId> {
    let graph = search.graph;
    let updating = search.updating();
    let updates = |id: LoopId| updating.iter().any(|node| graph.is_within(graph.node(*node).in_loop, id));
    exploration.path(end.at).into_iter().rev().find_map(|at| match &graph.node(exploration.states[at].node).effect {
        Effect::LoopHead(id) if search.covers(*id) && updates(*id) => Some(*id),
        _ => None,
    })
}

/// The way out of a loop over the elements that is taken in the round of another one: `for lag in &mut lags { if full { break; } … }`.
pub(super) fn way_out_of_rounds(search: &Search<'_>, exploration: &Exploration, end: &End) -> Option<NodeId> {
    let graph = search.graph;
    if end.state.skipped_at.is_some() || end.state.count != Count::Zero {
        return None;
    }
    let id = loop_passed(search, exploration, end)?;
    let nodes: Vec<NodeId> = exploration.path(end.at).iter().map(|at| exploration.states[*at].node).collect();
    let leaves = |at: usize| {
        let node = graph.node(nodes[at]);
        let is_inside = graph.loops_around(nodes[at]).any(|around| around == id);
        let is_out = matches!(node.effect, Effect::Mark(Mark::Return | Mark::Break));
        is_inside && is_out && !stays_beside(search, &nodes[at..])
    };
    (0..nodes.len()).rev().find(|at| leaves(*at)).map(|at| nodes[at])
}

/// What is said where a way goes past elements because the method that runs the updates ends before them.
pub(super) fn ends_early(
    search: &Search<'_>,
    exploration: &Exploration,
    end: &End,
    place: Span,
) -> Option<WitnessStep> {
    let graph = search.graph;
    let updating = search.updating();
    let is_around = |id: &LoopId| {
        let info = graph.loop_info(*id);
        info.stops_by.is_some()
            && search.covers(*id)
            && updating.iter().any(|at| graph.is_within(graph.node(*at).in_loop, *id))
    };
    let decided = end.state.skipped_at.and_then(|at| graph.loops_around(at).find(is_around));
    let id = decided.or_else(|| loop_passed(search, exploration, end).filter(is_around))?;
    let method = graph.loop_info(id).stops_by.as_ref()?;
    let is_tried = method.starts_with("try_") || matches!(method.as_str(), "collect" | "sum" | "product");
    let which = if is_tried { "fails" } else { "decides" };
    Some(WitnessStep { span: place, message: format!("`{method}` ends at the first element that {which}{ENDS_EARLY}") })
}

/// The call at which a way skips without an edge that leaves the update behind: that of the last round of a loop over the elements,
/// by its state.
pub(super) fn skips_in_round(search: &Search<'_>, exploration: &Exploration, end: &End) -> Option<usize> {
    let is_in_round = |node: NodeId| search.graph.loops_around(node).any(|id| search.covers(id));
    let is_call = |at: &usize| {
        let node = exploration.states[*at].node;
        is_in_round(node) && skip_inside(search, node).is_some()
    };
    let is_unplaced = end.state.skipped_at.is_none() && end.state.count == Count::Zero;
    exploration.path(end.at).into_iter().rev().find(|at| is_unplaced && is_call(at))
}

/// How a call skips, if it does.
pub(super) fn skip_inside<'s>(search: &'s Search<'_>, node: NodeId) -> Option<&'s Evidence> {
    match &search.graph.node(node).effect {
        Effect::Call(site) => search.skip_in(site),
        _ => None,
    }
}

/// Whether some iterations of a loop let the instance change places with another one, so that the next one finds it there:
/// `if turned() { mem::swap(&mut front, &mut back); }`. Where each does, each filter runs every other time.
pub(super) fn trades_places(search: &Search<'_>, region: Region) -> bool {
    let graph = search.graph;
    let Region::Loop(own) = region else { return false };
    let inside = |id: &NodeId| graph.is_within(graph.node(*id).in_loop, own);
    let is_choice = |id: NodeId| inside(&id) && matches!(graph.node(id).effect, Effect::Branch(_));
    let moved = |id: NodeId| match &graph.node(id).effect {
        Effect::Set(set) if set.transfer == Transfer::Move && set.rebinds => Some((&set.place, set.from.as_ref()?)),
        _ => None,
    };
    let chosen = graph.node_ids().filter(|id| inside(id) && search.conditions_of(*id).any(is_choice));
    let moves: Vec<(&Place, &Place)> = chosen.filter_map(moved).collect();
    let is_held = |place: &Place| matches!(place.relate(search.instance, &|_| None), Relation::Holds(_));
    // What is taken out of one place is put where the value of the other one was.
    moves.iter().any(|(between, one)| {
        let back = moves.iter().filter(|(_, from)| from == between).map(|(to, _)| *to);
        back.into_iter()
            .any(|other| other != *one && moves.contains(&(*one, other)) && (is_held(one) || is_held(other)))
    })
}

/// Whether a way skips where an element is passed over: `for voice in voices.iter_mut().filter(|voice| voice.is_playing())`.
pub(super) fn is_passed_over(search: &Search<'_>, exploration: &Exploration, end: &End) -> bool {
    let passes = |id: LoopId| search.covers(id) && search.graph.loop_info(id).passes_over;
    match end.state.skipped_at {
        Some(at) => search.graph.loops_around(at).any(passes),
        None => exploration.path(end.at).iter().any(
            |at| matches!(search.graph.node(exploration.states[*at].node).effect, Effect::LoopHead(id) if passes(id)),
        ),
    }
}
