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

/// The heads of a result, for each of the things that may be assumed of callers.
pub(super) type Answers = Vec<(Assumed, Heads)>;

/// The answers of a function; none where they do not depend on what its callers know, or where that cannot be told.
pub(super) fn answers(
    program: &Program<'_>,
    graph: &ControlFlowGraph,
    aliases: &Aliases,
    summaries: &Summaries,
) -> Answers {
    let tells =
        |effect: &Effect| matches!(effect, Effect::Return(value) if value.head.is_some() || value.same_as.is_some());
    if !graph.nodes.iter().any(|node| tells(&node.effect)) {
        return Answers::new();
    }
    let is_callers = |id: &SubjectId| given_subject(graph, &graph.subjects[id.0 as usize]).is_some();
    let mut asked = graph.nodes.iter().filter_map(|node| match &node.effect {
        Effect::Branch(test) => test.subject.filter(is_callers),
        _ => None,
    });
    let Some(first) = asked.next() else { return Answers::new() };
    let dependence = ControlDependence::of(graph, aliases);
    for id in std::iter::once(first).chain(asked) {
        let Some(place) = &graph.subjects[id.0 as usize].whole else { continue };
        // What is asked for is followed as an instance that nothing happens to: its ways are all there are.
        let search = Search::with_dependence(program, graph, aliases, summaries, place, 0, &dependence);
        if search.of_caller(id).is_some() {
            return by_assumption(&search);
        }
    }
    Answers::new()
}

fn by_assumption(search: &Search<'_>) -> Answers {
    let mut found: BTreeMap<Assumed, Heads> = BTreeMap::new();
    for way in search.ways(Region::Function).outcomes {
        if way.unknown.is_some() {
            return Answers::new();
        }
        *found.entry(way.assumed).or_default() |= way.returned;
    }
    let is_same = found.values().all(|heads| Some(heads) == found.values().next());
    if is_same { Answers::new() } else { found.into_iter().collect() }
}
