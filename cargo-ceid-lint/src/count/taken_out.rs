//! Filters that a call takes out of their place to give them back, `self.state = self.next_state();`, or gives back advanced.

use super::analyse::{Context, FunctionFacts};
use super::instances;
use super::search::{Region, Search};
use crate::flow::{CallSite, Cause, Effect, Node, Place, Var};
use crate::index::FunctionId;
use crate::syntax::tree::TypeRef;

/// Why it cannot be said that nothing updates the filter: a call gives it back by value, or what takes its place, and what it has
/// done with it before is not told of its place.
pub(super) fn of(search: &Search<'_>, region: Region) -> Option<Cause> {
    let nodes: Vec<&Node> = search.graph.nodes.iter().filter(|node| region.holds(search.graph, node.in_loop)).collect();
    nodes.iter().find_map(|node| match &node.effect {
        Effect::Call(site) if gives_filters(search, site) => {
            let had = |is_shared: bool| {
                site.args.iter().filter(move |arg| arg.is_shared == is_shared).filter_map(|arg| arg.place.as_ref())
            };
            let is_taken = had(false).any(|place| holds(search, place));
            // `self.kf = predict(&self.kf, z)`
            let is_read = || had(true).any(|place| is_it(search, place));
            let is_moved = is_taken && gives_instance(search, site);
            (is_moved || (is_taken || is_read()) && is_put_back(search, &nodes, site))
                .then(|| Cause::Moved(site.text.clone()))
        }
        _ => None,
    })
}

/// Whether an element is taken out of the collection that the instance lies in, updated under another name, and put back there: the
/// instance may be the one.
pub(super) fn goes_back(search: &Search<'_>, region: Region) -> bool {
    let Search { graph, aliases, summaries, .. } = *search;
    let lies_in = |place: &Place| {
        let is_beside = |root: &Place| root.base == search.instance.base && root.overlaps(search.instance);
        aliases.shared_roots(place).iter().any(is_beside)
    };
    if search.instance.steps.is_empty() || !graph.taken_out.iter().any(lies_in) {
        return false;
    }
    let nodes: Vec<&Node> = graph.nodes.iter().filter(|node| region.holds(search.graph, node.in_loop)).collect();
    let is_taken = |var: &Var| {
        let computed = graph.computed.get(var);
        computed.is_some_and(|computed| computed.places.iter().any(lies_in))
    };
    let is_named =
        |place: &Place, var: Var| aliases.shared_roots(place).iter().any(|root| root.base_var() == Some(var));
    let is_updated = |var: Var| {
        nodes.iter().any(|node| match &node.effect {
            Effect::Update(update) => is_named(&update.place, var),
            Effect::Call(site) => summaries.updates(site).any(|place| is_named(&place, var)),
            _ => false,
        })
    };
    nodes.iter().any(|node| match &node.effect {
        Effect::Set(set) | Effect::Write(set) if lies_in(&set.place) => {
            let from = set.from.as_ref().and_then(Place::base_var);
            from.is_some_and(|var| Some(var) != search.instance.base_var() && is_taken(&var) && is_updated(var))
        }
        _ => false,
    })
}

/// Whether a call gives back filters themselves, not mere references to them.
fn gives_filters(search: &Search<'_>, site: &CallSite) -> bool {
    let index = search.program.index;
    let given = &search.graph.var(site.result).ty;
    // `bank[Axis::Roll]` names what a function lends.
    let lends = |target: &FunctionId| matches!(index.function(*target).function.output, TypeRef::Reference { .. });
    let lends_all = !site.targets.is_empty() && site.targets.iter().all(lends);
    !lends_all && index.holds_filter(given) && !index.refers_to_filters(given)
}

/// Whether the instance is a place or lies in it.
fn holds(search: &Search<'_>, place: &Place) -> bool {
    let roots = search.aliases.shared_roots(place);
    roots.iter().any(|root| search.instance.lies_at(root))
}

/// Whether the instance itself may be a part of what a call gives back.
fn gives_instance(search: &Search<'_>, site: &CallSite) -> bool {
    search.summaries.borrows(site).any(|(_, from)| is_it(search, &from))
}

fn is_it(search: &Search<'_>, place: &Place) -> bool {
    search.aliases.shared_roots(place).iter().any(|root| root == search.instance)
}

/// Whether what holds the instance is given what a call gives back that had it.
fn is_put_back(search: &Search<'_>, nodes: &[&Node], site: &CallSite) -> bool {
    let sets = || {
        nodes.iter().filter_map(|node| match &node.effect {
            Effect::Set(set) | Effect::Write(set) => Some(&**set),
            _ => None,
        })
    };
    let mut names = vec![Place::var(site.result)];
    let mut next = 0;
    while let Some(name) = names.get(next).cloned() {
        let given = sets().filter(|set| set.from.as_ref() == Some(&name) && set.place.steps.is_empty());
        let new: Vec<Place> = given.map(|set| set.place.clone()).filter(|place| !names.contains(place)).collect();
        names.extend(new);
        next += 1;
    }
    let is_named = |place: &Option<Place>| place.as_ref().is_some_and(|place| names.contains(place));
    // `rig.store(state)`
    let is_handed_back = |site: &CallSite| {
        let takes_back = site.args.iter().any(|arg| arg.is_copy && is_named(&arg.place));
        takes_back && site.args.iter().any(|arg| arg.place.as_ref().is_some_and(|place| holds(search, place)))
    };
    sets().any(|set| is_named(&set.from) && holds(search, &set.place))
        || nodes.iter().any(|node| matches!(&node.effect, Effect::Call(site) if is_handed_back(site)))
}

/// Whether a function that is called takes the filter at a place, where none need be, out of it, whatever it does with it then:
/// `while let Some(mut job) = self.queue.pop() { … }`.
pub(super) fn by_callees(context: &Context<'_>, facts: &FunctionFacts<'_>, place: &Place) -> bool {
    let whole = Place::from(place.base);
    if instances::is_always_in(context.program.index, facts.graph, &whole, &place.steps) {
        return false;
    }
    let leads_to = |taken: &Place| {
        let roots = facts.aliases.shared_roots(taken);
        roots.iter().any(|root| root.overlaps(place) && root.steps.len() <= place.steps.len())
    };
    facts.graph.nodes.iter().any(|node| match &node.effect {
        Effect::Call(site) => context.summaries.places(site, |callee| &callee.takes_out).any(|taken| leads_to(&taken)),
        _ => false,
    })
}
