//! What ends a pause without a reset of the filter that paused: it goes on with the state from before.

use super::Gates;
use crate::count::given::{Given, given, place_of};
use crate::count::outcome::Outcome;
use crate::count::search::{Region, Search};
use crate::count::summary::Summary;
use crate::flow::{CallSite, Effect, Head, NodeId, OTHER_HEADS, Place, Relation, Transfer};

/// How many nodes that set something are looked at in one function. What is beyond goes with a reset, as far as is known.
const MAX_SETTING: usize = 64;

/// What a function sets on some way on which it does not reset the filter, though it does on another: `if is_cold { osc.reset(); }
/// self.is_on = true;`.
pub(in crate::count) fn set_without_reset(search: &Search<'_>, ways: &[Outcome]) -> Vec<(Given, Option<Head>)> {
    if ways.iter().all(|way| way.reset) || !ways.iter().any(|way| way.reset) {
        return Vec::new();
    }
    let gates = Gates::new(search, Region::Function);
    let graph = search.graph;
    let sets = |node: NodeId| -> Vec<(Place, Option<Head>)> {
        match &graph.node(node).effect {
            Effect::Write(write) => vec![(write.place.clone(), write.head.clone())],
            Effect::Call(site) => {
                let summaries = site.targets.iter().filter_map(|target| search.summaries.get(*target));
                let sets = summaries.flat_map(|summary| &summary.sets);
                sets.filter_map(|(set, head, _)| Some((place_of(set, site)?, head.clone()))).collect()
            }
            _ => Vec::new(),
        }
    };
    let setting = gates.nodes().map(|node| (node, sets(node))).filter(|(_, set)| !set.is_empty());
    let mut found = Vec::new();
    for (node, set) in setting.take(MAX_SETTING) {
        for (place, head) in set {
            let roots = search.aliases.shared_roots(&place);
            for head in gates.heads_without_reset(node, &place, head) {
                found.extend(roots.iter().filter_map(|root| Some((given(graph, root)?, head.clone()))));
            }
        }
    }
    found
}

/// Whether a function that resets a filter on some way does so on each on which it gives a state a head of which the question holds.
pub(super) fn resets_with(summary: &Summary, set: &Given, filter: &Given, of: &dyn Fn(Option<&Head>) -> bool) -> bool {
    !summary.unreset.iter().any(|(own, head, own_filter)| own == set && own_filter == filter && of(head.as_ref()))
}

impl Gates<'_, '_> {
    /// The heads that a node gives a place, without a reset of the filter around it: those of the value that it copies, if that is asked.
    fn heads_without_reset(&self, at: NodeId, place: &Place, head: Option<Head>) -> Vec<Option<Head>> {
        let graph = self.search.graph;
        let copied = graph.copied(at).filter(|from| head.is_none() && self.is_given_once(from));
        let Some(id) = copied.and_then(|from| graph.subject_of(&from)) else {
            let is_reset = self.resets_around(at, place, &|own| own == head.as_ref());
            return if is_reset { Vec::new() } else { vec![head] };
        };
        let subject = &graph.subjects[id.0 as usize];
        let heads = subject.heads.iter().cloned().map(Some).chain([None]);
        let bit = |head: &Option<Head>| head.as_ref().map_or(OTHER_HEADS, |head| subject.bit(head));
        let is_unreset = |head: &Option<Head>| {
            let follows = |node: NodeId, edge: usize| match &graph.node(node).effect {
                Effect::Branch(test) if test.subject == Some(id) => {
                    (if edge == 0 { test.holds } else { test.fails }) & bit(head) != 0
                }
                _ => true,
            };
            !self.resets_around_on(at, place, &|own| own == head.as_ref(), &follows)
        };
        heads.filter(|head| subject.anything() & bit(head) != 0 && is_unreset(head)).collect()
    }

    /// Whether each iteration that comes by a node resets the filter there, before or behind it, unless it gives a place the head that
    /// it has. A call may do so itself wherever it gives the place a head of which the question holds.
    pub(super) fn resets_around(&self, at: NodeId, place: &Place, of: &dyn Fn(Option<&Head>) -> bool) -> bool {
        self.resets_around_on(at, place, of, &|_, _| true)
    }

    /// The same on the ways that take certain edges.
    fn resets_around_on(
        &self,
        at: NodeId,
        place: &Place,
        of: &dyn Fn(Option<&Head>) -> bool,
        follows: &dyn Fn(NodeId, usize) -> bool,
    ) -> bool {
        let graph = self.search.graph;
        let does_both = |site: &CallSite| {
            site.targets.iter().all(|target| {
                let summary = self.search.summaries.get(*target);
                summary.is_some_and(|summary| self.resets_where_set(summary, site, place, of))
            })
        };
        let is_free = |node: NodeId| !self.resets(node);
        matches!(&graph.node(at).effect, Effect::Call(site) if does_both(site))
            || !is_free(at)
            || !self.reached(|node, edge| is_free(node) && follows(node, edge) && !self.has_head(node, edge, place, of))
                [at.0 as usize]
            || !self.completes(at, |node, edge| is_free(node) && follows(node, edge))
    }

    /// Whether the state at a place is known at an edge to have a head of which the question holds: what gives it that one again ends no
    /// pause. `if !self.is_on { osc.reset(); } self.is_on = true;`
    pub(super) fn has_head(
        &self,
        node: NodeId,
        edge: usize,
        place: &Place,
        of: &dyn Fn(Option<&Head>) -> bool,
    ) -> bool {
        let graph = self.search.graph;
        let Effect::Branch(test) = &graph.node(node).effect else { return false };
        test.subject.is_some_and(|id| {
            let subject = &graph.subjects[id.0 as usize];
            let heads = if edge == 0 { test.holds } else { test.fails } & subject.anything();
            let mut had = subject.heads.iter().filter(|head| subject.bit(head) & heads != 0).peekable();
            let is_asked = heads & OTHER_HEADS == 0 && self.asks_place(test, place);
            is_asked && had.peek().is_some() && had.all(|head| of(Some(head)))
        })
    }

    /// Whether a function that is called resets the filter on each way on which it gives a place such a head.
    fn resets_where_set(
        &self,
        summary: &Summary,
        site: &CallSite,
        place: &Place,
        of: &dyn Fn(Option<&Head>) -> bool,
    ) -> bool {
        let is_it = |set: &&Given| place_of(set, site).is_some_and(|written| written.overlaps(place));
        summary.outcomes(self.search.law).any(|(filter, ways)| {
            ways.iter().any(|way| way.reset)
                && place_of(filter, site).is_some_and(|place| self.is_held_by(&place))
                && summary.writes.iter().filter(is_it).all(|set| resets_with(summary, set, filter, of))
        })
    }

    /// Whether the instance is at a place or in it.
    fn is_held_by(&self, place: &Place) -> bool {
        let is_whole = |root: &Place| matches!(root.relate(self.search.instance, &|_| None), Relation::Holds(_));
        self.search.aliases.shared_roots(place).iter().any(is_whole)
    }

    /// Whether a node resets the filter, or calls a function each of whose ways does.
    pub(super) fn resets(&self, node: NodeId) -> bool {
        let known = self.resetting.borrow().get(&node).copied();
        known.unwrap_or_else(|| {
            let resets = self.finds_reset(node);
            self.resetting.borrow_mut().insert(node, resets);
            resets
        })
    }

    fn finds_reset(&self, node: NodeId) -> bool {
        match &self.search.graph.node(node).effect {
            Effect::Reset { place, full } => *full && self.is_held_by(place),
            // A name that is given to the filter replaces nothing: `for voice in &mut voices`.
            Effect::Write(write) | Effect::Set(write) => {
                write.transfer != Transfer::Borrow
                    && self.is_held_by(&write.place)
                    && !self.search.is_carried_over(self.region, write)
            }
            Effect::Call(site) => {
                let summaries = site.targets.iter().filter_map(|target| self.search.summaries.get(*target));
                let mut ways = summaries.flat_map(|summary| summary.outcomes(self.search.law));
                ways.any(|(given, ways)| {
                    ways.iter().all(|way| way.reset)
                        && place_of(given, site).is_some_and(|place| self.is_held_by(&place))
                })
            }
            _ => false,
        }
    }

    /// The nodes that update the filter, without those that update another one with which it changes places: `mem::swap(&mut self.now,
    /// &mut self.next)`.
    pub(super) fn updating_by_name(&self) -> Vec<NodeId> {
        let instance = self.search.instance;
        let is_other = |id: &NodeId| match &self.search.graph.node(*id).effect {
            Effect::Update(update) => update.place.base == instance.base && !update.place.overlaps(instance),
            _ => false,
        };
        let all: Vec<NodeId> = self.search.updating().into_iter().collect();
        let own: Vec<NodeId> = all.iter().copied().filter(|id| !is_other(id)).collect();
        if own.is_empty() { all } else { own }
    }
}
