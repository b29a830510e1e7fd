//! Samples that come to a filter by way of something else that keeps them: `window.push(sample); filter.update(window.mean())`.

use super::fed::{is_computed_from, named};
use super::search::Search;
use crate::flow::{Computed, Effect, LoopId, NodeId, Place, Var};

/// Whether a round gives its sample to something that is no part of the instance, and an update is fed with what that gives. The owner
/// of the instance that is called with the sample in one of its own fields is fed with it as well: `self.x = sample; self.step();`
pub(super) fn feeds_by_way(search: &Search<'_>, node: NodeId, id: LoopId, is_sample: &dyn Fn(Var) -> bool) -> bool {
    let Search { graph, aliases, .. } = *search;
    let keeping = keeping(search, id, is_sample);
    let reads_kept = |computed: &Computed| {
        let roots = named(&computed.places).into_iter().flat_map(|place| aliases.roots(place));
        roots.into_iter().any(|root| keeping.iter().any(|(at, kept)| *at != node && kept.overlaps(&root)))
    };
    let comes_from_kept = |computed: &Computed| is_computed_from(graph, id, computed, &reads_kept);
    let is_behind = |at: NodeId| graph.node(at).span.start < graph.node(node).span.start;
    let holds_kept = |owner: &Place| {
        keeping.iter().any(|(at, kept)| {
            let is_field = kept.steps.len() > owner.steps.len() && kept.lies_at(owner);
            is_field && is_behind(*at) && matches!(graph.node(*at).effect, Effect::Write(_))
        })
    };
    !keeping.is_empty()
        && match &graph.node(node).effect {
            Effect::Update(update) => comes_from_kept(&update.from),
            Effect::Call(site) => {
                let owner = site.args.first().and_then(|arg| arg.place.as_ref());
                comes_from_kept(&site.from) || owner.is_some_and(|owner| aliases.roots(owner).iter().any(holds_kept))
            }
            _ => false,
        }
}

/// What gets the sample of a round and is no part of the instance, with where it does.
fn keeping(search: &Search<'_>, id: LoopId, is_sample: &dyn Fn(Var) -> bool) -> Vec<(NodeId, Place)> {
    let Search { graph, aliases, .. } = *search;
    let gives = |computed: &Computed| named(&computed.places).into_iter().filter_map(Place::base_var).any(is_sample);
    let is_inside = |node: &NodeId| graph.is_within(graph.node(*node).in_loop, id);
    let kept_at = |node: NodeId| match &graph.node(node).effect {
        Effect::Update(update) if update.fed.iter().copied().any(is_sample) => Some(&update.place),
        Effect::Call(site) if site.fed.iter().copied().any(is_sample) => {
            let receiver = site.args.first().filter(|arg| !arg.is_shared && !arg.is_copy && !arg.is_moved)?;
            receiver.place.as_ref()
        }
        Effect::Write(write) if gives(&graph.changes.get(&node)?.computed) => Some(&write.place),
        _ => None,
    };
    let by_node = graph.node_ids().filter(is_inside).filter_map(|node| Some((node, kept_at(node)?)));
    let filled = graph.filled.iter().filter(|(node, _, from)| is_inside(node) && gives(from));
    let places = by_node.chain(filled.map(|(node, place, _)| (*node, place)));
    let roots = places.flat_map(|(node, place)| aliases.roots(place).into_iter().map(move |root| (node, root)));
    let is_own = |place: &Place| aliases.shared_roots(place).iter().any(|root| root.overlaps(search.instance));
    // What lasts for a round only is followed by itself.
    let lasts = |place: &Place| place.base_var().is_none_or(|var| !graph.is_within(graph.var(var).in_loop, id));
    roots.filter(|(_, place)| lasts(place) && !is_own(place)).collect()
}
