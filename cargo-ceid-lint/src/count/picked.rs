//! Loops over the same elements that each pick some of them: whether one of them is picked twice is not known.

use super::counts::Count;
use super::cycles::picks_round;
use super::decide::changes;
use super::search::{End, Exploration, Region, Search};
use crate::flow::{Cause, Effect, IndexKey, LoopId, NodeId, Place, Projection, Test, Var};
use crate::index::Ty;

/// Why an element is updated in a round: the answers to what was asked of it, and whether the loop itself leaves some out.
struct Picked<'a> {
    within: LoopId,
    answers: Vec<(&'a str, bool)>,
    leaves_out: bool,
}

/// The states of a way that an update leaves.
fn updates(exploration: &Exploration, end: &End) -> Vec<usize> {
    let changed = changes(exploration, end)
        .filter(|(at, after)| exploration.states[*at].count != *after && *after != Count::Zero);
    changed.map(|(at, _)| at).collect()
}

/// Whether each update of a way stands in another loop over the elements, and is for some of these only:
/// `for m in motors.iter_mut().filter(|m| m.is_left()) { … } for m in motors.iter_mut().filter(|m| !m.is_left()) { … }`.
fn are_picked_apart(search: &Search<'_>, exploration: &Exploration, end: &End) -> bool {
    let updates = updates(exploration, end);
    let picked: Option<Vec<Picked<'_>>> = updates.iter().map(|at| picked(search, exploration, *at)).collect();
    let Some(picked) = picked.filter(|picked| picked.len() > 1) else { return false };
    let is_apart = |(number, one): (usize, &Picked<'_>)| {
        picked[number + 1..].iter().all(|other| {
            // Two loops that leave out the same have the same.
            let leaves_out = (one.leaves_out || other.leaves_out)
                && search.graph.loop_info(one.within).text != search.graph.loop_info(other.within).text;
            one.within != other.within && (leaves_out || one.answers != other.answers)
        })
    };
    picked.iter().enumerate().all(is_apart)
}

/// Whether each update of a way behind the first one is run again by a table whose rows choose it: `for slot in SLOTS { match slot.filter {
/// … } }`. Rows that the code spells out are known, and each may be for another filter.
fn are_chosen_by_rows(search: &Search<'_>, exploration: &Exploration, end: &End) -> bool {
    let graph = search.graph;
    let updates: Vec<NodeId> = updates(exploration, end).into_iter().map(|at| exploration.states[at].node).collect();
    let asks_row = |node: NodeId, table: LoopId| {
        search.branches_before([node]).into_iter().any(|branch| match &graph.node(branch).effect {
            Effect::Branch(test) => {
                let mut reads = test.about.reads.iter().filter_map(Place::base_var);
                graph.is_within(graph.node(branch).in_loop, table)
                    && reads.any(|var| search.aliases.is_derived(var, &graph.loop_info(table).bound))
            }
            _ => false,
        })
    };
    let is_chosen = |node: &NodeId| {
        let mut tables = graph.loops_around(*node).filter(|id| graph.loop_info(*id).is_table);
        tables.any(|table| asks_row(*node, table))
    };
    updates.len() > 1 && updates.iter().skip(1).all(is_chosen)
}

/// Why it is not certain that a way with several updates is there, where each of them is for some of the elements or rows of its loop.
pub(super) fn doubt_of_several(search: &Search<'_>, exploration: &Exploration, end: &End) -> Option<Cause> {
    if end.state.count != Count::Many {
        return None;
    }
    if may_be_apart(search, exploration, end) {
        return Some(Cause::Index(search.graph.place_name(search.program.index, search.instance)));
    }
    may_be_of_rows(search, exploration, end).then(rows_not_followed)
}

/// Whether the updates of a way may be for a row each.
pub(super) fn may_be_of_rows(search: &Search<'_>, exploration: &Exploration, end: &End) -> bool {
    are_chosen_by_rows(search, exploration, end) || is_chosen_again(search, exploration, end)
}

/// Whether the updates of a way are one that a loop comes to again in another round, in each of which what the round is for tells which
/// of several filters it updates: `for i in 0..3 { match ROWS[i].side { Left => left.update(x), Right => right.update(x) } }`. That two
/// rounds are for the same one is not known.
fn is_chosen_again(search: &Search<'_>, exploration: &Exploration, end: &End) -> bool {
    let graph = search.graph;
    let updates = updates(exploration, end);
    let (Some(first), Some(last)) = (updates.first(), updates.last()) else { return false };
    let node = exploration.states[*first].node;
    if updates.len() < 2 || updates.iter().any(|at| exploration.states[*at].node != node) {
        return false;
    }
    let path = exploration.path(*last);
    let comes_again = |id: LoopId| {
        let head = graph.loop_info(id).head;
        updates.windows(2).all(|two| {
            let between = path.iter().skip_while(|at| **at != two[0]).take_while(|at| **at != two[1]);
            between.into_iter().any(|at| exploration.states[*at].node == head)
        })
    };
    graph.loops_around(node).any(|id| comes_again(id) && is_one_of_several(search, node, id))
}

/// Whether a round of a loop asks what it is for, and goes to an update or to one of another filter.
fn is_one_of_several(search: &Search<'_>, node: NodeId, within: LoopId) -> bool {
    let graph = search.graph;
    let info = graph.loop_info(within);
    let counter = info.counter.map(|(counter, _)| counter);
    // A number of the round itself is followed.
    let is_number = |var: Var| {
        *graph.var(var).ty.peel() == Ty::Int
            && counter.is_some_and(|counter| search.aliases.is_derived(var, &[counter]))
    };
    let is_for = |place: &Place| {
        let by_number = place.steps.iter().filter_map(Projection::key).any(|key| match key {
            IndexKey::Var(var) => counter.is_some_and(|counter| search.aliases.is_derived(*var, &[counter])),
            _ => false,
        });
        let own = place.base_var().filter(|var| !is_number(*var) || !place.steps.is_empty());
        by_number || own.is_some_and(|var| search.aliases.is_derived(var, &info.bound))
    };
    let is_of_another = |id: NodeId| match &graph.node(id).effect {
        Effect::Update(update) => {
            !search.aliases.shared_roots(&update.place).iter().any(|root| root.overlaps(search.instance))
        }
        _ => false,
    };
    search.branches_before([node]).into_iter().any(|branch| {
        let Effect::Branch(test) = &graph.node(branch).effect else { return false };
        if !graph.is_within(graph.node(branch).in_loop, within) || !test.about.reads.iter().any(is_for) {
            return false;
        }
        let reached = |edge: usize| {
            let next = graph.node(branch).next.get(edge)?;
            Some(search.reached_from(Region::Loop(within), *next, |from, _| from != branch))
        };
        let (Some(yes), Some(no)) = (reached(0), reached(1)) else { return false };
        let (own, other) = if yes[node.0 as usize] { (yes, no) } else { (no, yes) };
        let leads_apart = own[node.0 as usize] && !other[node.0 as usize];
        leads_apart && graph.node_ids().any(|id| other[id.0 as usize] && is_of_another(id))
    })
}

/// Whether each update of a way behind the first one is for the element that an inner loop comes to in one of its rounds, which the
/// counter of a loop further out chooses: `for i in 1..5 { for j in 0..4 { if i == j + 1 { bank.get_mut(j) … } } }`. Each round of the
/// outer loop may choose another element.
fn are_chosen_by_rounds(search: &Search<'_>, exploration: &Exploration, end: &End) -> bool {
    let graph = search.graph;
    let updates: Vec<NodeId> = updates(exploration, end).into_iter().map(|at| exploration.states[at].node).collect();
    let counter = |id: LoopId| graph.loop_info(id).counter.map(|(counter, _)| counter);
    let asks = |node: NodeId, counter: Var| {
        search.branches_before([node]).into_iter().any(|branch| match &graph.node(branch).effect {
            Effect::Branch(test) => {
                let mut reads = test.about.reads.iter().filter_map(Place::base_var);
                reads.any(|var| search.aliases.is_derived(var, &[counter]))
            }
            _ => false,
        })
    };
    let is_chosen = |node: &NodeId| {
        let around: Vec<LoopId> = graph.loops_around(*node).collect();
        around.iter().enumerate().any(|(at, inner)| {
            search.covers(*inner)
                && picks_round(graph, search, *node, *inner)
                && around[at + 1..].iter().filter_map(|outer| counter(*outer)).any(|outer| asks(*node, outer))
        })
    };
    updates.len() > 1 && updates.iter().skip(1).all(is_chosen)
}

/// Whether the updates of a way may be for an element each.
pub(super) fn may_be_apart(search: &Search<'_>, exploration: &Exploration, end: &End) -> bool {
    are_picked_apart(search, exploration, end) || are_chosen_by_rounds(search, exploration, end)
}

/// What is said where the rows of a table are not followed.
pub(super) fn rows_not_followed() -> Cause {
    Cause::Limit("which rows of a table lead to the update is not followed".to_owned())
}

/// How the element was picked that a state updates; `None` if all are updated there.
fn picked<'a>(search: &'a Search<'_>, exploration: &Exploration, at: usize) -> Option<Picked<'a>> {
    let graph = search.graph;
    let loops = |at: usize| {
        std::iter::successors(graph.node(exploration.states[at].node).in_loop, |id| graph.loop_info(*id).parent)
    };
    let within = loops(at).filter(|id| search.covers(*id)).last()?;
    let path = exploration.path(at);
    let round =
        path.iter().rposition(|state| !graph.is_within(graph.node(exploration.states[*state].node).in_loop, within));
    let round = &path[round.map_or(0, |before| before + 1)..];
    let answers = round.iter().zip(round.iter().skip(1)).filter_map(|(state, next)| {
        let id = exploration.states[*state].node;
        let Effect::Branch(test) = &graph.node(id).effect else { return None };
        let holds = graph.node(id).next.first() == Some(&exploration.states[*next].node);
        asks_element(search, test, within).then_some((test.text.as_str(), holds))
    });
    let answers: Vec<(&str, bool)> = answers.collect();
    let leaves_out = search.passes_over(within);
    (leaves_out || !answers.is_empty()).then_some(Picked { within, answers, leaves_out })
}

/// Whether a condition is on what a round of a loop has, but for whether there is something in it at all, and for what lies beside
/// the filter in the element, which is followed from loop to loop.
fn asks_element(search: &Search<'_>, test: &Test, within: LoopId) -> bool {
    let graph = search.graph;
    let instance = search.instance;
    let each = instance.steps.iter().rposition(|step| step.key().is_some());
    let is_in_element = |root: &Place| {
        let is_same =
            |(step, own): (&Projection, &Projection)| step == own || step.key().is_some() && own.key().is_some();
        each.is_some_and(|at| root.steps.len() > at && root.steps[..=at].iter().zip(instance.steps.iter()).all(is_same))
    };
    // What lies in another collection is not followed.
    let is_beside = |root: &Place| {
        let is_element = root.steps.iter().any(|step| step.key().is_some());
        root.base == instance.base && (!is_element || is_in_element(root)) && !root.steps.starts_with(&instance.steps)
    };
    let is_of_round = |place: &Place| {
        let keys = place.steps.iter().filter_map(|step| match step.key() {
            Some(IndexKey::Var(var)) => Some(*var),
            _ => None,
        });
        place.base_var().into_iter().chain(keys).any(|var| graph.is_within(graph.var(var).in_loop, within))
            && !search.aliases.shared_roots(place).iter().any(is_beside)
    };
    !test.about.is_presence && test.about.reads.iter().any(is_of_round)
}
