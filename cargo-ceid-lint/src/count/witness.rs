//! The way that shows a verdict, as labelled steps.

use std::collections::BTreeSet;

use super::counts::Count;
use super::decide::{changes, head_of, inner_repeat};
use super::search::{End, Exploration, Region, Search};
use super::skips::{is_decided_behind, skip_inside, skips_by_itself, skips_in_round, stays_beside, way_out_of_rounds};
use crate::diagnostic::WitnessStep;
use crate::flow::{ControlFlowGraph, Effect, GuardInfo, Mark, NodeId, Place, Test, Transfer, in_words};
use crate::source::Span;
use crate::syntax::CycleDirective;

/// What the last step of a cycle function is called.
const RETURNS: &str = "`return` ends the cycle";

/// How a way comes to a second update at the place of the first one.
pub const WAYS_AGAIN: [&str; 2] = [", in the next round of the inner loop", ", by the other guard"];

/// How a macro is told that writes what it is given more than once: its name stands between these.
const BY_MACRO: &str = ", for `";
const MORE_THAN_ONCE: &str = "` writes it more than once";

/// What is said of an update that a cycle gives to a copy of its filter.
pub const OF_COPY: &str = "only a copy of it is updated here, and what the copy learns is lost";

/// How a step begins that says which way of a condition is taken.
pub const TAKEN: &str = "taken when ";

/// How a loop within the cycle skips an update in it.
const NO_ROUND: &str = "this loop has no round";

/// The same for a loop with rounds.
const NO_ROUND_UPDATES: &str = "no round of this loop comes to the update";

/// What is said of a method of an iterator that ends at the first element which decides.
pub const ENDS_EARLY: &str = ", and the elements behind that one are not updated";

/// How a gate is told that opens in another one of so many cycles than is claimed for it.
pub const OTHER_RATE: &str = "this opens in one of ";

/// What is said of a clock that a skipping path sets.
pub const GOES_ON: &str = " goes on here without it, so that the next step does not cover the gap";

/// What is said of a change of state that keeps a pause from being a mode.
pub const NO_RESET: &str = " here, and no reset goes with it";

/// What is said of what resets a filter and leaves some of its state.
pub const PARTIAL: &str = " clears only a part of its state";

/// What is said of a swap behind which the filter goes on in the place of another one.
pub const TRADES: &str = "it changes places with another filter here";

/// How a call is told that updates the filter in a function.
pub const BY_CALL: &str = " updates it";

/// How the rest of it says that the function does so more than once.
pub const CALL_REPEATS: &str = " more than once";

/// What the update of a guard is called.
pub const BY_GUARD: &str = "the guard's update";

/// What is said of a loop within the cycle, whose next round comes to the same update again.
const GOES_ROUND: &str = "this inner loop goes round within the cycle";

/// The way as labelled steps.
pub(super) fn steps(search: &Search<'_>, region: Region, exploration: &Exploration, end: &End) -> Vec<WitnessStep> {
    let graph = search.graph;
    let mut steps = Vec::new();
    let listed_at = head_of(search, region);
    // The loop of a function that is given a closure is listed at the closure, and begins where it stands.
    let head = match region {
        Region::Loop(id) => graph.loop_info(id).keyword,
        Region::Function => listed_at,
    };
    steps.push(WitnessStep { span: head, message: "one control cycle begins here".to_owned() });
    if head != listed_at {
        steps.push(WitnessStep { span: listed_at, message: "this closure runs in that cycle".to_owned() });
    }
    let path = exploration.path(end.at);
    let nodes: Vec<NodeId> = path.iter().map(|at| exploration.states[*at].node).collect();
    let updating = search.updating();
    let told: Vec<NodeId> = changes(exploration, end)
        .filter(|(at, after)| exploration.states[*at].count != *after)
        .map(|(at, _)| exploration.states[at].node)
        .collect();
    let deciding = search.branches_before(told);
    let mut updates = 0;
    let in_round = skips_in_round(search, exploration, end);
    let out_of_rounds = way_out_of_rounds(search, exploration, end);
    // What the last step asks, if it is a condition.
    let mut asked: Option<Span> = None;
    for (number, at) in path.iter().enumerate() {
        let state = &exploration.states[*at];
        let node = graph.node(state.node);
        // Behind the second update only those show something that follow it at once.
        if state.count == Count::Many && matches!(node.effect, Effect::Branch(_) | Effect::Mark(_)) {
            break;
        }
        let next = path.get(number + 1).map(|next| &exploration.states[*next]);
        let after = next.map_or(end.state.count, |next| next.count);
        let said = steps.len();
        match &node.effect {
            Effect::Update(update)
                if after != state.count
                    || (state.count == Count::Many && next.is_some() && updating.contains(&state.node)) =>
            {
                updates += 1;
                let is_by_guard = update.run_by.is_guard();
                let is_shown = steps.iter().any(|step| step.span == node.span && step.message == BY_GUARD);
                if let Some(made) = guard_made(graph, &nodes[number..]).filter(|_| is_by_guard) {
                    insert_in_order(&mut steps, made);
                }
                let how = match is_by_guard {
                    true if is_shown => format!("{} update{}", ordinal(updates), WAYS_AGAIN[1]),
                    true => BY_GUARD.to_owned(),
                    false => format!("{} update{}", ordinal(updates), again(graph, &nodes[..number], state.node)),
                };
                steps.push(WitnessStep { span: node.span, message: how });
            }
            Effect::Update(_) | Effect::Call(_)
                if end.is_copy_lost
                    && updating.contains(&state.node)
                    && after == state.count
                    && !steps.iter().any(|step| step.message == OF_COPY) =>
            {
                steps.push(WitnessStep { span: node.span, message: OF_COPY.to_owned() });
            }
            Effect::Call(site) if after != state.count => {
                updates += 1;
                let more = after == Count::Many && state.count == Count::Zero;
                let often = format!("{BY_CALL}{}", if more { CALL_REPEATS } else { "" });
                let inner = inner_repeat(search, exploration, *at, after);
                let message = match inner {
                    Some(_) => format!("`{}`{often}", site.text),
                    None => {
                        let again = again(graph, &nodes[..number], state.node);
                        format!("{} update: `{}`{often}{again}", ordinal(updates), site.text)
                    }
                };
                steps.push(WitnessStep { span: node.span, message });
                steps.extend(inner.iter().flat_map(|repeat| repeat.witness.iter().cloned()));
            }
            Effect::Call(site)
                if in_round == Some(*at) || state.skipped_at.is_none() && end.state.skipped_at == Some(state.node) =>
            {
                let message = format!("`{}` may return without the update", site.text);
                steps.push(WitnessStep { span: node.span, message });
                let inner = skip_inside(search, state.node);
                steps.extend(inner.iter().flat_map(|skip| skip.witness.iter().cloned()));
                if skips_by_itself(search, exploration, end) {
                    break;
                }
            }
            // A swap has no name for what it keeps in between.
            Effect::Set(set)
                if state.count == Count::One
                    && end.state.count == Count::Many
                    && set.transfer == Transfer::Move
                    && next.is_some_and(|next| next.names != state.names)
                    && is_swap(graph, node.span)
                    && !steps.iter().any(|step| step.span == node.span && step.message == TRADES) =>
            {
                steps.push(WitnessStep { span: node.span, message: TRADES.to_owned() });
            }
            Effect::Branch(test) => {
                let holds = next.is_none_or(|next| node.next.first() == Some(&next.node)) != test.about.is_turned;
                let is_reason = || deciding.contains(&state.node) || switches(search, state.node, &deciding);
                let leads_out = || out_of_rounds.is_some_and(|out| search.decides(state.node, out));
                let decides = end.state.skipped_at == Some(state.node)
                    || end.state.count == Count::Many && is_reason()
                    || leads_out();
                // Which of several futures ends first is no question of the code.
                let is_choice = test.about.is_event && test.subject.is_none() && !test.text.contains(" is ");
                // A pattern in the rules of a macro is not to be seen where it is called.
                let is_of_macro = test.text.split_once(" is ").is_some_and(|(_, pattern)| pattern.contains("!("));
                // That what is shipped does not run a macro is no condition of the code.
                let is_macro = test.about.is_debug && test.text.ends_with('!');
                let is_shown = !test.text.is_empty() && !is_choice && !is_of_macro && !is_macro;
                if decides && is_shown && has_choice(search, state.node) {
                    // A pattern of several parts asks for each of them, and the last answer is that of the whole.
                    steps.pop_if(|last| asked == Some(last.span) && last.span == test.span);
                    let of_rate = other_rate(search, region, test).filter(|_| end.state.count == Count::Zero);
                    let message = of_rate.unwrap_or_else(|| condition_text(&test.text, holds));
                    steps.push(WitnessStep { span: test.span, message });
                    asked = Some(test.span);
                    continue;
                }
            }
            // A loop that is gone over leaves the condition to its rounds.
            Effect::LoopHead(id) if end.state.skipped_at == Some(state.node) && region != Region::Loop(*id) => {
                let is_first = !nodes[..number].contains(&state.node);
                let message = format!("{TAKEN}{}", if is_first { NO_ROUND } else { NO_ROUND_UPDATES });
                steps.push(WitnessStep { span: node.span, message });
            }
            Effect::Mark(Mark::ClosureCall) => {
                let mut behind = path[number + 1..].iter().map(|at| &exploration.states[*at]);
                let next_call = behind.find(|state| is_closure_call(search, state.node));
                if next_call.map_or(end.state.count, |next| next.count) != state.count {
                    steps.push(WitnessStep { span: node.span, message: "the closure runs here".to_owned() });
                }
            }
            Effect::Mark(Mark::Continue)
                if !stays_beside(search, &nodes[number..]) && !is_decided_behind(search, end, &nodes[..=number]) =>
            {
                let message = match end.state.count {
                    Count::Zero => "`continue` ends the iteration without an update".to_owned(),
                    _ => "`continue` ends the iteration".to_owned(),
                };
                steps.push(WitnessStep { span: node.span, message });
            }
            Effect::Mark(Mark::Return) if region == Region::Function => {
                steps.push(WitnessStep { span: node.span, message: RETURNS.to_owned() });
            }
            _ => {}
        }
        asked = asked.filter(|_| steps.len() == said);
    }
    let again = steps.iter().find(|step| step.message.ends_with(WAYS_AGAIN[0])).map(|step| step.span);
    if let Some(span) = again.and_then(|place| keyword_around(search, region, &nodes, place)) {
        insert_in_order(&mut steps, WitnessStep { span, message: GOES_ROUND.to_owned() });
    }
    steps
}

/// Puts a step before the first one that stands behind it in the source, the head of the cycle apart.
fn insert_in_order(steps: &mut Vec<WitnessStep>, step: WitnessStep) {
    let at = steps.iter().skip(1).position(|other| other.span > step.span);
    if !steps.contains(&step) {
        steps.insert(at.map_or(steps.len(), |at| at + 1), step);
    }
}

/// The keyword of the loop within a region whose rounds come to a place again and again.
fn keyword_around(search: &Search<'_>, region: Region, nodes: &[NodeId], place: Span) -> Option<Span> {
    let graph = search.graph;
    let written_out = graph.written_out.iter().filter(|(_, body)| body.contains(place));
    let innermost = written_out.min_by_key(|(_, body)| body.end - body.start).map(|(keyword, _)| *keyword);
    let around = || {
        let node = nodes.iter().find(|id| graph.node(**id).span == place)?;
        let id = graph.loops_around(*node).next().filter(|id| Region::Loop(*id) != region)?;
        Some(graph.loop_info(id).keyword)
    };
    innermost.or_else(around)
}

/// Where the guard is made whose updates begin a way.
fn guard_made(graph: &ControlFlowGraph, way: &[NodeId]) -> Option<WitnessStep> {
    let guard = way.iter().find_map(|id| match &graph.node(*id).effect {
        Effect::GuardEnd(guard) => Some(*guard),
        _ => None,
    })?;
    let GuardInfo { span, is_destructor, .. } = &graph.guards[guard.0 as usize];
    let message = "this guard updates it where it ends".to_owned();
    (!is_destructor).then_some(WitnessStep { span: *span, message })
}

/// Whether a branch chooses a value that one of some others asks for: `if is_hot { done = true; }`. The parts of an expression choose
/// nothing that is not asked for where its value is: `let is_hot = level > 3;`
fn switches(search: &Search<'_>, at: NodeId, others: &BTreeSet<NodeId>) -> bool {
    let graph = search.graph;
    let is_asked = |place: &Place| {
        others.iter().any(|id| match &graph.node(*id).effect {
            Effect::Branch(test) => test.about.reads.iter().any(|read| read.overlaps(place)),
            _ => false,
        })
    };
    let is_chosen = |id: NodeId| match &graph.node(id).effect {
        Effect::Set(set) | Effect::Write(set) => set.head.is_some() && is_asked(&set.place),
        _ => false,
    };
    let is_value = || graph.node(at).next.iter().all(|next| is_chosen(behind_nothing(graph, *next)));
    graph.node_ids().any(|id| search.decides(at, id) && is_chosen(id)) && !is_value()
}

/// The first node from one on at which something happens.
fn behind_nothing(graph: &ControlFlowGraph, mut at: NodeId) -> NodeId {
    while let (Effect::Nothing, [next]) = (&graph.node(at).effect, graph.node(at).next.as_slice()) {
        at = *next;
    }
    at
}

/// Whether the code at a place lets two values change places: each gets what the other one was, by way of a value in between.
fn is_swap(graph: &ControlFlowGraph, span: Span) -> bool {
    let at_place = graph.nodes.iter().filter(|node| node.span == span);
    let moves = at_place.filter_map(|node| match &node.effect {
        Effect::Set(set) if set.transfer == Transfer::Move && set.rebinds => Some((&set.place, set.from.as_ref()?)),
        _ => None,
    });
    let moves: Vec<(&Place, &Place)> = moves.collect();
    moves.iter().any(|(between, one)| {
        moves.iter().any(|(other, from)| from == between && other != one && moves.contains(&(*one, *other)))
    })
}

/// What is said of a gate that is claimed to be a rate gate, if it has another ratio.
fn other_rate(search: &Search<'_>, region: Region, test: &Test) -> Option<String> {
    let of_loop = || match region {
        Region::Loop(id) => search.graph.loop_info(id).directive,
        Region::Function => None,
    };
    let Some(CycleDirective::Every(claimed)) = search.program.directive(test.span).or_else(of_loop) else {
        return None;
    };
    let numbers = || test.about.numbers.iter().copied().find(|number| *number > 0);
    let found =
        test.about.ratio.or_else(|| search.period(region, test)).or_else(numbers).filter(|found| *found != claimed)?;
    Some(format!("{OTHER_RATE}{found} cycles, and `every({claimed})` claims one of {claimed}"))
}

/// Whether both ways of a branch go on: what panics otherwise, as `unwrap` does, is no choice.
fn has_choice(search: &Search<'_>, at: NodeId) -> bool {
    let graph = search.graph;
    let is_end = |next: &NodeId| matches!(graph.node(behind_nothing(graph, *next)).effect, Effect::Diverge);
    !graph.node(at).next.iter().any(is_end)
}

/// Whether a closure that is written elsewhere is called at a node.
pub(super) fn is_closure_call(search: &Search<'_>, at: NodeId) -> bool {
    matches!(search.graph.node(at).effect, Effect::Mark(Mark::ClosureCall))
}

/// What to add to a step that the way has come through before: only a loop within the cycle leads there again, whose rounds may be
/// written out.
fn again(graph: &ControlFlowGraph, before: &[NodeId], node: NodeId) -> String {
    let span = graph.node(node).span;
    let is_written_out = graph.written_out.iter().any(|(_, body)| body.contains(span));
    let is_same = |id: &NodeId| {
        let own = graph.node(*id);
        *id == node || is_written_out && own.span == span && matches!(own.effect, Effect::Update(_) | Effect::Call(_))
    };
    let is_at_place = |id: &NodeId| {
        graph.node(*id).span == span && matches!(graph.node(*id).effect, Effect::Update(_) | Effect::Call(_))
    };
    if before.iter().any(is_same) {
        return WAYS_AGAIN[0].to_owned();
    }
    let by_macro = graph.written_again.iter().find(|(place, _)| *place == span && before.iter().any(is_at_place));
    by_macro.map(|(_, name)| format!("{BY_MACRO}{name}{MORE_THAN_ONCE}")).unwrap_or_default()
}

/// The macro that writes an update once more, by the step that tells of it.
#[must_use]
pub fn macro_again(message: &str) -> Option<&str> {
    let (_, name) = message.strip_suffix(MORE_THAN_ONCE)?.rsplit_once(BY_MACRO)?;
    Some(name)
}

fn condition_text(text: &str, holds: bool) -> String {
    if let Some(words) = in_words(text, holds) {
        return format!("{TAKEN}{words}");
    }
    if let Some(tried) = text.strip_suffix('?') {
        return format!("{TAKEN}`{tried}` {}", if holds { "succeeds" } else { "fails" });
    }
    match (text.strip_prefix("let "), holds) {
        (Some(_), true) => format!("{TAKEN}`{text}` matches"),
        (Some(_), false) => format!("{TAKEN}`{text}` does not match"),
        (None, true) => format!("{TAKEN}`{text}`"),
        (None, false) => format!("{TAKEN}`{text}` does not hold"),
    }
}

/// What the updates on a way are called that no guard runs; each from the fourth on has the last name.
pub const ORDINALS: [&str; 4] = ["first", "second", "third", "another"];

fn ordinal(number: u32) -> &'static str {
    let at = usize::try_from(number.saturating_sub(1)).unwrap_or(usize::MAX);
    ORDINALS[at.min(ORDINALS.len() - 1)]
}

/// The way through a function as those see it who call it.
pub(super) fn steps_inside(search: &Search<'_>, exploration: &Exploration, end: &End) -> Vec<WitnessStep> {
    let mut witness = steps(search, Region::Function, exploration, end);
    witness.remove(0);
    for step in witness.iter_mut().filter(|step| step.message == RETURNS) {
        "`return` leaves the function".clone_into(&mut step.message);
    }
    witness
}
