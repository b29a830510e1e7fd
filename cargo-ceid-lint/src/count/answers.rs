//! What a function gives back where that depends on conditions which its callers know: a caller that has asked for `self.armed`
//! learns nothing new from a helper that gives `true` while it holds. Knows no filters.

use std::collections::BTreeMap;

use super::aliases::Aliases;
use super::assumed::Assumed;
use super::given::given_subject;
use super::returned::Heads;
use super::search::{Region, Search};
use super::slice::ControlDependence;
use super::summary::Summaries;
use crate::flow::{ControlFlowGraph, Effect, Program, SubjectId};

/// What a function does for its callers on some of its ways.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Answer {
    /// With which conditions of the caller's these are taken.
    pub(super) assumed: Assumed,
    /// What is known at their ends of those that they write.
    pub(super) left: Assumed,
    /// The heads of the result.
    pub(super) returned: Heads,
}

/// What a function answers, for each of the things that may be assumed of callers.
pub(super) type Answers = Vec<Answer>;

/// The answers of a function; none where they do not depend on what its callers know, or where that cannot be told.
pub(super) fn answers(
    program: &Program<'_>,
    graph: &ControlFlowGraph,
    aliases: &Aliases,
    summaries: &Summaries,
) -> Answers {
    let is_callers = |id: &SubjectId| given_subject(graph, &graph.subjects[id.0 as usize]).is_some();
    let tells = |effect: &Effect| match effect {
        Effect::Return(value) => value.head.is_some() || value.same_as.is_some(),
        // A state that goes on from what it was is known behind the call by what was known before.
        Effect::Write(write) => graph.subject_of(&write.place).is_some_and(|id| is_callers(&id)),
        _ => false,
    };
    if !graph.nodes.iter().any(|node| tells(&node.effect)) {
        return Answers::new();
    }
    let of_branches = graph.nodes.iter().filter_map(|node| match &node.effect {
        Effect::Branch(test) => test.subject,
        _ => None,
    });
    // What is taken out and given back is asked for by the caller: `fn pop(&mut self) -> Option<f32> { self.slot.take() }`.
    let of_copies = graph.copies.values().filter_map(|from| graph.subject_of(from));
    let mut asked = of_branches.chain(of_copies).filter(is_callers);
    let Some(first) = asked.next() else { return Answers::new() };
    let dependence = ControlDependence::of(graph, aliases);
    for id in std::iter::once(first).chain(asked) {
        let Some(known_as) = graph.subjects[id.0 as usize].known_as() else { continue };
        let place = &known_as.asked().map_or_else(|| known_as.clone(), |(asked, _)| asked);
        // What is asked for is followed as an instance that nothing happens to: its ways are all there are.
        let search = Search::with_dependence(program, graph, aliases, summaries, place, 0, &dependence);
        if search.of_caller(id).is_some() {
            return by_assumption(&search);
        }
    }
    Answers::new()
}

fn by_assumption(search: &Search<'_>) -> Answers {
    let mut found: BTreeMap<(Assumed, Assumed), Heads> = BTreeMap::new();
    for way in search.ways(Region::Function).outcomes {
        if way.unknown.is_some() {
            return Answers::new();
        }
        *found.entry((way.assumed, way.left)).or_default() |= way.returned;
    }
    let mut all = found.iter();
    let first = all.next();
    if all.all(|((_, left), heads)| first.is_some_and(|((_, other), first)| (left, heads) == (other, first)))
        && first.is_some_and(|((_, left), _)| left.is_empty())
    {
        return Answers::new();
    }
    found.into_iter().map(|((assumed, left), returned)| Answer { assumed, left, returned }).collect()
}
