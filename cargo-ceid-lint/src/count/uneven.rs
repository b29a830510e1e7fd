//! Helpers that treat the elements of a collection differently: what they do to each of them tells nothing of one by its number.

use std::collections::BTreeMap;

use super::gates::Gates;
use super::given::Given;
use super::search::Search;
use crate::flow::{Effect, IndexKey, LoopId, NodeId, Place};

/// Whether a function may update some elements otherwise than others, where its callers know them as each of a collection:
/// `for i in first..filters.len() { filters[i].update(x) }`, `for filter in filters.iter_mut().step_by(2)`.
///
/// Those that are known to be the first ones, or those behind them, are `taken` alone.
pub(super) fn is_uneven(search: &Search<'_>, given: &Given, taken: &BTreeMap<Given, Given>) -> bool {
    let stands_for_each = given.steps.iter().any(|step| step.key() == Some(&IndexKey::Each));
    stands_for_each
        && !taken.contains_key(given)
        && (search.updating().into_iter().any(|node| !is_for_each(search, node))
            || Gates::of_helper(search).tells_elements_apart()
            || search.graph.node_ids().any(|node| is_split(search, node)))
}

/// Whether a node that may update does so for each element: in a loop over all of them, or in a function that is given all.
fn is_for_each(search: &Search<'_>, node: NodeId) -> bool {
    let graph = search.graph;
    let is_part = |place: &Place| place.steps.iter().any(|step| matches!(step.key(), Some(IndexKey::EachIn(_))));
    let covers = |id: LoopId| {
        let mut lent = graph.loop_info(id).items.iter().flat_map(|(_, source)| search.aliases.parts(source));
        search.covers(id)
            && (!search.passes_over(id) || search.counts_to_number(id))
            && !lent.any(|(_, root)| is_part(&root) && root.overlaps(search.instance))
    };
    let mut loops = graph.loops_around(node).filter(|id| search.binds(*id)).peekable();
    let is_each = |place: &Place| search.aliases.shared_roots(place).iter().all(Place::stands_for_each);
    match loops.peek() {
        Some(_) => loops.all(covers),
        None => match &graph.node(node).effect {
            Effect::Update(update) => is_each(&update.place),
            Effect::Call(site) => search.aliases.called_places(site, search.summaries).iter().all(|called| {
                !search.may_reach(called, false)
                    || called.roots().iter().all(Place::stands_for_each)
                        && called.taken.is_empty()
                        && !called.is_uneven_for_each(search.summaries)
            }),
            _ => false,
        },
    }
}

/// Whether a node is the choice in which part of a split collection an element is.
fn is_split(search: &Search<'_>, node: NodeId) -> bool {
    let graph = search.graph;
    let first_step = |next: &NodeId| {
        let mut steps = std::iter::successors(Some(*next), |at| graph.node(*at).next.first().copied());
        steps.find(|at| !matches!(graph.node(*at).effect, Effect::Nothing)).map(|at| &graph.node(at).effect)
    };
    let lends = |next: &NodeId| match first_step(next) {
        Some(Effect::Set(set)) if set.rebinds => set.from.as_ref().is_some_and(|from| {
            let whole = |root: &Place| search.instance.lies_at(root);
            search.aliases.shared_roots(from).iter().any(|root| whole(root) || *root == *search.instance)
        }),
        _ => false,
    };
    let next = &graph.node(node).next;
    matches!(&graph.node(node).effect, Effect::Branch(test) if test.about.is_constant)
        && next.len() == 2
        && next.iter().all(lends)
}
