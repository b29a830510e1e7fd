//! What a round of a loop feeds to a law otherwise than by the law's arguments: memory that it writes, and what is set with what it
//! gives.

use std::collections::BTreeSet;

use super::aliases::Aliases;
use super::cycles::receives;
use super::derived::Derived;
use super::instances::{may_hold_filter, place_ty};
use super::search::Search;
use crate::flow::{CallSite, Computed, ControlFlowGraph, Effect, IndexKey, LoopId, NodeId, Place, Var};
use crate::index::Ty;
use crate::source::Span;

/// Whether a round writes something into memory that the law reads: what the loop binds, or a value that comes from that.
pub(super) fn writes_fed(
    graph: &ControlFlowGraph,
    aliases: &Aliases,
    search: &Search<'_>,
    id: LoopId,
    from: &Computed,
    (from_bound, sampled): (&Derived<'_>, &[&Place]),
) -> bool {
    let index = search.program.index;
    let is_memory = |place: &Place| {
        let var = place.base_var().filter(|_| place.steps.is_empty());
        !place.overlaps(search.instance) && var.is_none_or(|var| !may_hold_filter(index, &graph.var(var).ty))
    };
    let read: Vec<Place> =
        named(&from.places).into_iter().flat_map(|place| aliases.roots(place)).filter(|root| is_memory(root)).collect();
    let feeds = |root: &Place| read.iter().any(|read| read.overlaps(root) && read.steps.len() <= root.steps.len());
    // Of what has a sample in one of its parts, the other parts are none.
    let is_sample = |place: &&Place| {
        let is_in = |part: &&Place| {
            let mut inside = part.steps.iter().skip(place.steps.len());
            part.overlaps(place) && inside.all(|step| step.key().is_some())
        };
        let is_owner = sampled.iter().any(|part| part.base == place.base);
        sampled.iter().any(is_in) || !is_owner && place.base_var().is_some_and(|var| from_bound.contains(var))
    };
    let gives_sample = |computed: &Computed| named(&computed.places).iter().any(is_sample);
    let is_inside = |node: NodeId| graph.is_within(graph.node(node).in_loop, id);
    let writes = |node: NodeId| {
        let Effect::Write(write) = &graph.node(node).effect else { return false };
        let var = write.place.base_var();
        let is_bound = var.is_some_and(|var| from_bound.contains(var));
        if !is_bound && !graph.changes.get(&node).is_some_and(|change| gives_sample(&change.computed)) {
            return false;
        }
        // What a loop binds lies in what it runs over.
        let loops = graph.loops_around(node).map(|id| graph.loop_info(id));
        let binding = loops.filter(|info| var.is_some_and(|var| info.bound.contains(&var)));
        let over = binding.flat_map(|info| info.over.iter().chain(&info.filled));
        let over = over.flat_map(|place| aliases.roots(place)).map(|root| root.element(IndexKey::Each));
        aliases.roots(&write.place).iter().any(feeds) || over.into_iter().any(|root| feeds(&root))
    };
    // What is put to what was there before is no sample alone.
    let is_emptied = |place: &Place| graph.emptied.iter().any(|(node, emptied)| is_inside(*node) && emptied == place);
    let fills = |(node, place, from): &(NodeId, Place, Computed)| {
        is_inside(*node) && is_emptied(place) && gives_sample(from) && aliases.roots(place).iter().any(feeds)
    };
    graph.node_ids().any(|node| is_inside(node) && writes(node)) || graph.filled.iter().any(fills)
}

/// The places without what is only named on the way to the one before it: `frame` in `frame.speed`.
pub(super) fn named(places: &[Place]) -> Vec<&Place> {
    let is_on_way = |at: usize| {
        let before = at.checked_sub(1).map(|before| &places[before]);
        before.is_some_and(|before| {
            before.base == places[at].base
                && before.steps.split_last().is_some_and(|(_, way)| *way == *places[at].steps)
        })
    };
    (0..places.len()).filter(|at| !is_on_way(*at)).map(|at| &places[at]).collect()
}

/// Whether something is computed in one step or several, by variables of a round, from what is looked for.
pub(super) fn is_computed_from(
    graph: &ControlFlowGraph,
    id: LoopId,
    computed: &Computed,
    is_it: &dyn Fn(&Computed) -> bool,
) -> bool {
    let mut seen = BTreeSet::new();
    let mut open = vec![computed];
    while let Some(computed) = open.pop() {
        if is_it(computed) {
            return true;
        }
        let vars = computed.places.iter().filter_map(Place::base_var);
        let of_round = vars.filter(|var| graph.is_within(graph.var(*var).in_loop, id) && seen.insert(*var));
        open.extend(of_round.filter_map(|var| graph.computed.get(&var)));
    }
    false
}

/// Whether an update is fed with what its round takes from what says how many rounds there are: `for _ in 0..fifo.available()`.
pub(super) fn is_drained_by_count(search: &Search<'_>, node: NodeId, id: LoopId) -> bool {
    let Search { graph, aliases, .. } = *search;
    let is_inside = |in_loop: Option<LoopId>| graph.is_within(in_loop, id);
    let is_own = |place: &Place| aliases.shared_roots(place).iter().any(|root| root.overlaps(search.instance));
    let taken = &graph.loop_info(id).taken_by_count;
    let taken: Vec<&(Place, String)> = taken.iter().filter(|(place, _)| !is_own(place)).collect();
    let is_taken = |computed: &Computed| {
        taken.iter().any(|(place, method)| computed.calls.contains(method) && computed.places.contains(place))
    };
    let comes_from_taken = |computed: &Computed| is_computed_from(graph, id, computed, &is_taken);
    let is_part = |place: &Place| place.steps.len() > search.instance.steps.len() && is_own(place);
    let is_fed_before = || {
        graph.node_ids().any(|other| match &graph.node(other).effect {
            Effect::Write(write) if is_part(&write.place) && is_inside(graph.node(other).in_loop) => {
                graph.changes.get(&other).is_some_and(|change| comes_from_taken(&change.computed))
            }
            _ => false,
        })
    };
    !taken.is_empty()
        && match &graph.node(node).effect {
            Effect::Update(update) => comes_from_taken(&update.from) || is_fed_before(),
            Effect::Call(site) => comes_from_taken(&site.from) || is_fed_before(),
            _ => false,
        }
}

/// Whether each round of a loop makes a sample of its own, and puts what the law gives for it behind those of the rounds before:
/// `block.push(lowpass.update(noise()))`.
pub(super) fn puts_aside(
    graph: &ControlFlowGraph,
    aliases: &Aliases,
    search: &Search<'_>,
    update: NodeId,
    id: LoopId,
    from_given: &Derived<'_>,
) -> bool {
    let is_inside = |in_loop: Option<LoopId>| graph.is_within(in_loop, id);
    let (from, fed) = match &graph.node(update).effect {
        Effect::Update(update) => (&update.from, &update.fed),
        Effect::Call(site) => (&site.from, &site.fed),
        _ => return false,
    };
    let is_made = !from.calls.is_empty() || fed.iter().any(|var| is_inside(graph.var(*var).in_loop));
    let is_given = |place: &Place| {
        let is_own = || aliases.roots(place).iter().any(|root| root.overlaps(search.instance));
        place.base_var().is_some_and(|var| from_given.contains(var)) || is_own()
    };
    let keeps = |place: &Place| place.base_var().is_none_or(|var| !is_inside(graph.var(var).in_loop));
    is_made
        && graph.filled.iter().any(|(at, place, from)| {
            is_inside(graph.node(*at).in_loop) && keeps(place) && from.places.iter().any(is_given)
        })
}

/// Whether what an update gives is combined with the sample of the round, in a variable or in what a call gets: `out.push(x * gain)`.
pub(super) fn is_mixed_with(search: &Search<'_>, update: NodeId, id: LoopId, from_bound: &Derived<'_>) -> bool {
    let Search { graph, aliases, program, .. } = *search;
    // Rounds of other filters bring no samples of this one, and neither do constants.
    let info = graph.loop_info(id);
    let holds = |place: &Place| {
        let ty = place_ty(program.index, graph, place);
        ty.is_some_and(|ty| program.index.holds_filter(ty.peel()))
    };
    let is_literal = info.text.starts_with('[');
    if is_literal || info.items.iter().map(|(_, element)| element).chain(&info.indexes).any(holds) {
        return false;
    }
    let given = match &graph.node(update).effect {
        Effect::Update(update) => update.into.as_slice(),
        Effect::Call(site) => site.into.as_slice(),
        _ => &[],
    };
    let from_given = aliases.derived_from(given);
    let of_both = |span: Span, computed: &Computed| {
        let mut vars = computed.places.iter().filter_map(Place::base_var);
        // What a macro writes all stands where it is called.
        let at = graph.node(update).span;
        let is_given = span != at && span.contains(at) || vars.clone().any(|var| from_given.contains(var));
        is_given && vars.any(|var| from_bound.contains(var))
    };
    let is_inside = |around: Option<LoopId>| graph.is_within(around, id);
    let variables = graph.computed.iter().filter(|(var, _)| is_inside(graph.var(**var).in_loop));
    let mut named = variables.filter_map(|(var, computed)| Some((*graph.read_at.get(var)?, computed)));
    let mut mixed = graph.mixed.iter().filter(|(at, ..)| is_inside(graph.node(*at).in_loop));
    named.any(|(span, computed)| of_both(span, computed)) || mixed.any(|(_, span, computed)| of_both(*span, computed))
}

/// Whether a helper that updates the instance is lent something else that another call of the round gives the sample:
/// `self.engine.start(&mut frame); frame.read(*sample);`
pub(super) fn is_lent_with_sample(search: &Search<'_>, update: NodeId, id: LoopId, from_bound: &Derived<'_>) -> bool {
    let Search { graph, aliases, program, .. } = *search;
    let Effect::Call(site) = &graph.node(update).effect else { return false };
    let is_context = |place: &Place| {
        let ty = place_ty(program.index, graph, place);
        ty.is_some_and(|ty| matches!(ty.peel(), Ty::Adt(..)) && !program.index.holds_filter(ty.peel()))
    };
    let lent = site.args.iter().skip(1).filter(|arg| !arg.is_shared && !arg.is_copy && !arg.is_moved);
    let lent: Vec<Place> = lent
        .filter_map(|arg| arg.value_of.as_ref().or(arg.place.as_ref()))
        .flat_map(|place| aliases.roots(place))
        .filter(is_context)
        .collect();
    let is_lent = |place: &Place| aliases.roots(place).iter().any(|root| lent.iter().any(|lent| lent.overlaps(root)));
    let is_inside = |node: &NodeId| graph.is_within(graph.node(*node).in_loop, id);
    site.law_of.is_none()
        && graph.node_ids().filter(is_inside).any(|node| match &graph.node(node).effect {
            Effect::Call(other) => {
                let receiver = other.args.first().and_then(|arg| arg.value_of.as_ref().or(arg.place.as_ref()));
                receiver.is_some_and(is_lent) && other.fed.iter().any(|var| from_bound.contains(*var))
            }
            _ => false,
        })
}

/// What some variables give in a round of a loop, and what comes out of what is set with that: `delay.set_time(lfo.update(rate));
/// *sample = delay.run(*sample);`
pub(super) fn passed_on(
    graph: &ControlFlowGraph,
    aliases: &Aliases,
    search: &Search<'_>,
    given: &[Var],
    id: LoopId,
) -> Vec<Var> {
    let from_given = aliases.derived_from(given);
    let nodes = || graph.node_ids().filter(|node| graph.is_within(graph.node(*node).in_loop, id));
    let calls = || {
        nodes().filter_map(|node| match &graph.node(node).effect {
            Effect::Call(site) if !receives(aliases, search, site) => {
                Some((&**site, site.args.first().and_then(|arg| arg.place.as_ref())?))
            }
            _ => None,
        })
    };
    let is_set = |(site, _): &(&CallSite, &Place)| site.fed.iter().any(|var| from_given.contains(*var));
    let mut set: Vec<Place> = calls().filter(is_set).flat_map(|(_, place)| aliases.roots(place)).collect();
    set.extend(nodes().filter_map(|node| match &graph.node(node).effect {
        Effect::Write(write) => {
            let mut read = graph.changes.get(&node)?.computed.places.iter().filter_map(Place::base_var);
            let (_, owner) = write.place.steps.split_last().filter(|_| read.any(|var| from_given.contains(var)))?;
            Some(Place { base: write.place.base, steps: owner.into() })
        }
        _ => None,
    }));
    // Of what the function was lent, the one part says nothing of the others.
    let is_part =
        |place: &Place| !place.steps.is_empty() || place.base_var().is_some_and(|var| graph.var(var).param.is_none());
    let is_of_set = |place: &Place| {
        let roots = aliases.roots(place);
        roots.iter().filter(|root| is_part(root)).any(|root| set.iter().any(|own| is_part(own) && own.overlaps(root)))
    };
    let given_by = calls().filter(|(_, place)| is_of_set(place)).flat_map(|(site, _)| &site.into);
    let given: Vec<Var> = given.iter().chain(given_by).copied().collect();
    let filled = filled_from(graph, aliases, &given, id);
    given.into_iter().chain(filled).collect()
}

/// Whether a variable is a number, or a struct, from before a loop that no round of it sets or calls.
pub(super) fn lasts(graph: &ControlFlowGraph, var: Var, id: LoopId) -> bool {
    let info = graph.var(var);
    if graph.is_within(info.in_loop, id) || !(is_one_number(&info.ty) || matches!(info.ty, Ty::Adt(..))) {
        return false;
    }
    let sets = |effect: &Effect| match effect {
        Effect::Set(set) | Effect::Write(set) => set.place.base_var() == Some(var),
        Effect::Call(site) => {
            site.into.contains(&var)
                || site.args.iter().any(|arg| arg.place.as_ref().and_then(Place::base_var) == Some(var))
        }
        _ => false,
    };
    !graph.nodes.iter().any(|node| graph.is_within(node.in_loop, id) && sets(&node.effect))
}

fn is_one_number(ty: &Ty) -> bool {
    matches!(ty.peel(), Ty::Bool | Ty::Char | Ty::Int | Ty::Float)
}

/// The variables of a round into which it puts what some variables give: a part of one is written, or a function that reads what they
/// give gets one to write: `frame[0] = level;`, `voice.render(level, &mut frame);`
fn filled_from(graph: &ControlFlowGraph, aliases: &Aliases, given: &[Var], id: LoopId) -> Vec<Var> {
    let is_of_round = |var: &Var| {
        let info = graph.var(*var);
        graph.is_within(info.in_loop, id) && !is_one_number(&info.ty)
    };
    let nodes = || graph.node_ids().filter(|node| graph.is_within(graph.node(*node).in_loop, id));
    let put_in = |known: &[Var]| -> Vec<Var> {
        let from_known = aliases.derived_from(known);
        let mut found: Vec<Var> = Vec::new();
        for node in nodes() {
            match &graph.node(node).effect {
                Effect::Write(set) | Effect::Set(set) if !set.place.steps.is_empty() => {
                    let computed = graph.changes.get(&node).map(|change| &change.computed);
                    let mut read = computed.into_iter().flat_map(|from| &from.places).filter_map(Place::base_var);
                    found.extend(set.place.base_var().filter(|_| read.any(|var| from_known.contains(var))));
                }
                Effect::Call(site) if site.fed.iter().any(|var| from_known.contains(*var)) => {
                    let lent = site.args.iter().filter(|arg| !arg.is_shared && !arg.is_moved);
                    let places = lent.flat_map(|arg| arg.place.iter().chain(&arg.value_of).chain(&arg.from.places));
                    found.extend(places.filter_map(Place::base_var));
                }
                _ => {}
            }
        }
        found.retain(|var| is_of_round(var) && !from_known.contains(*var));
        found
    };
    let mut known = given.to_vec();
    loop {
        let found = put_in(&known);
        if found.is_empty() {
            return known.split_off(given.len());
        }
        known.extend(found);
    }
}
