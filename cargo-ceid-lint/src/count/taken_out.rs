//! Filters that a call takes out of their place to give them back: `self.state = self.next_state();`

use super::search::{Region, Search};
use crate::flow::{Assignment, CallSite, Cause, Effect, Node, Place, Var};

/// Why it cannot be said that nothing updates the filter: a call gives it back by value, or what takes its place, and what it has
/// done with it before is not told of its place.
pub(super) fn of(search: &Search<'_>, region: Region) -> Option<Cause> {
    let is_inside = |node: &&Node| match region {
        Region::Function => true,
        Region::Loop(own) => search.graph.is_within(node.in_loop, own),
    };
    let nodes: Vec<&Node> = search.graph.nodes.iter().filter(is_inside).collect();
    nodes.iter().find_map(|node| match &node.effect {
        Effect::Call(site) if gives_instance(search, site) || is_put_back(search, &nodes, site) => {
            Some(Cause::Moved(site.text.clone()))
        }
        _ => None,
    })
}

/// Whether the instance itself, and no reference to it, may be a part of what a call gives back.
fn gives_instance(search: &Search<'_>, site: &CallSite) -> bool {
    let is_it = |place: &Place| search.aliases.shared_roots(place).iter().any(|root| root == search.instance);
    gives_values(search, site) && search.summaries.borrows(site).any(|(_, from)| is_it(&from))
}

/// Whether a call gives back no mere reference to filters.
fn gives_values(search: &Search<'_>, site: &CallSite) -> bool {
    !search.program.index.refers_to_filters(&search.graph.var(site.result).ty)
}

/// Whether what holds the instance is given what a call gives back that had it.
fn is_put_back(search: &Search<'_>, nodes: &[&Node], site: &CallSite) -> bool {
    let holds = |place: &Place| {
        let roots = search.aliases.shared_roots(place);
        roots.iter().any(|root| root.base == search.instance.base && search.instance.steps.starts_with(&root.steps))
    };
    let sets = || {
        nodes.iter().filter_map(|node| match &node.effect {
            Effect::Set(set) | Effect::Write(set) => Some(&**set),
            _ => None,
        })
    };
    let is_from = |set: &Assignment, var: Var| set.from.as_ref().is_some_and(|from| *from == Place::var(var));
    let mut names = vec![site.result];
    names.extend(sets().filter(|set| is_from(set, site.result)).filter_map(|set| set.place.base_var()));
    let had = site.args.iter().filter(|arg| !arg.is_shared).filter_map(|arg| arg.place.as_ref()).any(holds);
    had && gives_values(search, site)
        && sets()
            .any(|set| !set.place.steps.is_empty() && holds(&set.place) && names.iter().any(|var| is_from(set, *var)))
}
