//! Which loops are the cycles of an instance.

use std::collections::BTreeSet;

use super::aliases::Aliases;
use super::by_way::feeds_by_way;
use super::derived::Derived;
use super::fed::{
    is_drained_by_count, is_lent_with_sample, is_mixed_with, lasts, named, passed_on, puts_aside, writes_fed,
};
use super::functions::FunctionKind;
use super::given_away::is_given_away;
use super::search::{Region, Search};
use super::summary::Summaries;
use super::waits;
use crate::flow::{
    CallSite, Caller, Computed, ControlFlowGraph, Effect, IndexKey, LoopId, NodeId, OTHER_HEADS, Place, Projection,
    Rounds, Var,
};
use crate::index::{FunctionId, Ty};
use crate::syntax::CycleDirective;

/// An instance that a function updates, with its cycles.
pub(super) struct Instance {
    pub(super) place: Place,
    /// The half of its law that this is about.
    pub(super) law: usize,
    /// Whether something in the function updates it, or may do so unseen.
    pub(super) is_updated: bool,
    /// Whether only something unseen may update it.
    pub(super) is_unseen: bool,
    /// The loops that are its cycles.
    pub(super) loops: BTreeSet<LoopId>,
    /// Whether the function itself is one.
    pub(super) function: bool,
    /// Loops that are cycles of their own inside its cycles.
    pub(super) sample_loops: BTreeSet<LoopId>,
    /// Loops that only wait until it can be updated.
    pub(super) waits: BTreeSet<LoopId>,
}

/// The cycles of an instance among the loops around its updates.
pub(super) fn choose_cycles(
    graph: &ControlFlowGraph,
    aliases: &Aliases,
    summaries: &Summaries,
    search: &Search<'_>,
    kind: FunctionKind,
    in_cycle: &BTreeSet<FunctionId>,
    of_siblings: &[LoopId],
) -> Instance {
    let declared = search.instance.base_var().and_then(|var| graph.var(var).in_loop);
    // What is made here no caller sees: no cycle around the call counts its updates.
    let made_here = declared.is_some() || search.instance.base_var().is_some_and(|var| graph.var(var).param.is_none());
    let is_helper = in_cycle.contains(&graph.function) && !made_here;
    let counts_as = if made_here && kind == FunctionKind::Cycle { FunctionKind::Helper } else { kind };
    let mut chosen: Vec<(NodeId, Option<LoopId>)> = Vec::new();
    let mut sample_loops = BTreeSet::new();
    let mut nodes = search.updating();
    let none_seen = nodes.is_empty();
    // Where only something unseen may run the updates, the code here is a cycle of which nothing is known.
    let is_unseen = |node: &NodeId| graph.loops_around(*node).any(|id| graph.loop_info(id).is_unseen());
    if nodes.iter().all(is_unseen) {
        nodes.extend(search.unknown());
    }
    let is_updated = !nodes.is_empty();
    if nodes.is_empty() {
        nodes = search.debug_only();
    }
    let waits = waits::find(graph, aliases, summaries, search, &nodes);
    // A cycle that runs the law and drops what it gives back owes the update, where no other cycle has it.
    if nodes.iter().all(|node| graph.loops_around(*node).next().is_none()) {
        nodes.extend(search.dropped());
    }
    for node in nodes {
        let mut around: Vec<LoopId> = Vec::new();
        // What is started in a loop and runs once belongs to that loop.
        let starts = graph.forks_before(node).last();
        let started = starts.into_iter().flat_map(|fork| graph.loops_around(fork));
        for id in graph.loops_around(node).chain(started) {
            // A loop in whose body the instance is made is no cycle of it, nor is one around that.
            if Some(id) == declared {
                break;
            }
            around.push(id);
        }
        around.retain(|id| {
            let directive = graph.loop_info(*id).directive;
            let is_wait = waits.contains(id) && directive != Some(CycleDirective::Cycle);
            !search.binds(*id) && directive != Some(CycleDirective::NotACycle) && !is_wait
        });
        // `while is_ready() { …; break; }` is an `if`, where something around it goes round.
        let going = around.iter().rposition(|id| graph.loop_info(*id).goes_round);
        let inner = if kind == FunctionKind::Cycle { around.len() } else { going.unwrap_or(0) };
        let mut at = 0..;
        around.retain(|id| at.next().is_none_or(|at| at >= inner) || graph.loop_info(*id).goes_round);
        chosen.push((node, choose(graph, aliases, search, node, &around, counts_as, is_helper, &mut sample_loops)));
    }
    // A loop over the samples of its siblings is one over samples: a control rate inside it is a rate of samples.
    if kind == FunctionKind::Cycle {
        let around = chosen.iter().flat_map(|(node, _)| graph.loops_around(*node));
        sample_loops.extend(around.filter(|id| of_siblings.contains(id) && !search.binds(*id)));
    }
    // What else updates the instance for a sample belongs to the sample's cycle, by whatever name.
    for (node, cycle) in &mut chosen {
        let mut sampled = graph.loops_around(*node).filter(|id| sample_loops.contains(id));
        if let Some(inner) = sampled.find(|id| cycle.is_none_or(|cycle| graph.is_within(Some(*id), cycle))) {
            *cycle = Some(inner);
        }
    }
    let loops: BTreeSet<LoopId> = chosen.iter().filter_map(|(_, id)| *id).collect();
    // Where updates sit at two depths, the cycle is the innermost loop that holds them all.
    let outer: BTreeSet<LoopId> = loops
        .iter()
        .filter(|id| {
            !loops.iter().any(|other| {
                other != *id
                    && graph.is_within(Some(**id), *other)
                    && chosen
                        .iter()
                        .any(|(node, own)| *own == Some(*other) && !graph.is_within(graph.node(*node).in_loop, **id))
            })
        })
        .copied()
        .collect();
    // Whoever takes the loop around an update out of the cycles of a function that is only presumed to be one says that it is none.
    let is_taken_out = |node: NodeId| {
        let directives = graph.loops_around(node).map(|id| graph.loop_info(id).directive);
        kind == FunctionKind::Presumed && directives.into_iter().any(|own| own == Some(CycleDirective::NotACycle))
    };
    let outside = chosen.iter().any(|(node, id)| id.is_none() && !is_taken_out(*node));
    let function = match kind {
        FunctionKind::Cycle => outside && !made_here,
        FunctionKind::Presumed => outside && !made_here && !is_given_away(search, graph, search.instance),
        _ => false,
    };
    let is_unseen = is_updated && none_seen;
    Instance {
        place: search.instance.clone(),
        law: search.law,
        is_updated,
        is_unseen,
        loops: outer,
        function,
        sample_loops,
        waits,
    }
}

/// The cycle of one update among the loops around it, innermost first.
#[expect(
    clippy::too_many_arguments,
    reason = "the choice depends on all of it, and a struct would be made for one call"
)]
fn choose(
    graph: &ControlFlowGraph,
    aliases: &Aliases,
    search: &Search<'_>,
    node: NodeId,
    around: &[LoopId],
    kind: FunctionKind,
    is_helper: bool,
    sample_loops: &mut BTreeSet<LoopId>,
) -> Option<LoopId> {
    // What something unseen calls is presumed to be a cycle, whatever it stands in.
    let is_unseen = around.last().is_some_and(|id| graph.loop_info(*id).is_unseen());
    let (kind, is_helper) = if is_unseen { (FunctionKind::Presumed, false) } else { (kind, is_helper) };
    let declared = |id: &&LoopId| graph.loop_info(**id).directive == Some(CycleDirective::Cycle);
    if let Some(id) = around.iter().find(declared) {
        return Some(*id);
    }
    let unbounded = around.iter().position(|id| graph.loop_info(*id).rounds == Rounds::Unbounded);
    // A loop over samples that are fed to the instance is its cycle, inside whatever else is one.
    let inner = &around[..unbounded.unwrap_or(around.len())];
    for id in inner {
        if search.feeds(node, *id) || chooses(graph, aliases, search, node, *id) {
            let is_nested = around.iter().any(|other| other != id && graph.is_within(Some(*id), *other));
            if is_nested || is_helper || kind == FunctionKind::Cycle {
                sample_loops.insert(*id);
                return Some(*id);
            }
            // What is fed in a number of rounds is a setpoint for these: `for (goal, cycles) in plan { for _ in 0..cycles { … } }`.
            let only_counts = |first: &&LoopId| {
                let info = graph.loop_info(**first);
                let is_counter = |var: &Var| info.counter.is_some_and(|(counter, _)| counter == *var);
                info.over.is_none() && info.bound.iter().all(is_counter) && info.caller != Caller::Helper
            };
            let held = around.first().filter(only_counts).filter(|first| !graph.loop_info(**first).has_few_rounds());
            return Some(held.copied().unwrap_or(*id));
        }
    }
    // For anything else a call of a closure is none.
    let is_call = |id: &&LoopId| graph.loop_info(**id).caller == Caller::Helper;
    let around: Vec<LoopId> = around.iter().filter(|id| !is_call(id)).copied().collect();
    if let Some(id) = around.iter().find(|id| graph.loop_info(**id).rounds == Rounds::Unbounded) {
        return Some(*id);
    }
    if kind == FunctionKind::Cycle {
        // In a function that is a cycle, an inner loop multiplies.
        return None;
    }
    let first = around.first().copied()?;
    if is_helper {
        // In a helper a loop of a constant number of rounds multiplies; another one is a cycle of its own.
        let own = around.iter().find(|id| !graph.loop_info(**id).has_constant_rounds()).copied();
        if let Some(own) = own {
            sample_loops.insert(own);
        }
        return own;
    }
    Some(first)
}

/// Whether a place is one of these, or a variable that is computed from one: `let raw = BUFFER[i]; let level = gain * raw;`
fn comes_from(graph: &ControlFlowGraph, place: &Place, places: &[&Place]) -> bool {
    let mut seen = BTreeSet::new();
    let mut open = vec![place];
    while let Some(place) = open.pop() {
        if places.iter().any(|other| other.overlaps(place)) {
            return true;
        }
        let var = place.base_var().filter(|var| seen.insert(*var));
        open.extend(var.and_then(|var| graph.computed.get(&var)).into_iter().flat_map(|computed| &computed.places));
    }
    false
}

/// What a call is given, but for the filters that it is lent to run them: `while let Some(filter) = row.pop() { step(filter, io); }`
fn fed_besides(search: &Search<'_>, site: &CallSite) -> Vec<Var> {
    let Search { graph, program, .. } = *search;
    let is_run = |var: &Var| {
        let is_lent = |ty: &Ty| matches!(ty, Ty::Ref(true, of) if program.index.holds_filter(of));
        is_lent(&graph.var(*var).ty)
            && site.args.iter().any(|arg| arg.place.as_ref().is_some_and(|place| place.base_var() == Some(*var)))
    };
    site.fed.iter().copied().filter(|var| !is_run(var)).collect()
}

/// Whether what a loop binds is fed to the instance at an update in it, or its result is combined with that.
pub(super) fn feeds(search: &Search<'_>, node: NodeId, id: LoopId) -> bool {
    let Search { graph, aliases, summaries, .. } = *search;
    let info = graph.loop_info(id);
    if info.rounds == Rounds::Unbounded || picks_round(graph, search, node, id) {
        return false;
    }
    if is_drained_by_count(search, node, id) {
        return true;
    }
    if info.bound.is_empty() {
        return false;
    }
    // A counter is no sample, but what it indexes is one.
    let mut bound = info.bound.clone();
    let mut sampled: Vec<&Place> = Vec::new();
    if let Some((counter, _)) = info.counter {
        bound.retain(|var| *var != counter && !aliases.is_derived(counter, &[*var]));
        let data = info.indexes.iter().chain(&info.sampled).filter(|collection| {
            !aliases
                .roots(collection)
                .iter()
                .any(|root| root.base == search.instance.base && root.overlaps(search.instance))
        });
        // Of what has the data in one of its parts, the other parts stay the same in all rounds.
        let (parts, whole): (Vec<&Place>, Vec<&Place>) = data.partition(|collection| !collection.steps.is_empty());
        sampled.clone_from(&parts);
        let from = match &graph.node(node).effect {
            Effect::Update(update) => update.from.places.as_slice(),
            Effect::Call(site) => site.from.places.as_slice(),
            _ => &[],
        };
        // A buffer that an interrupt fills is no variable.
        let statics: Vec<&Place> = whole.iter().copied().filter(|place| place.base_var().is_none()).collect();
        if from.iter().any(|place| comes_from(graph, place, &statics)) {
            return true;
        }
        bound.extend(whole.into_iter().filter_map(Place::base_var));
        bound.extend(parts.into_iter().filter(|part| reads_of(graph, from, part, id)).filter_map(Place::base_var));
    }
    let inside = |other: &NodeId| graph.is_within(graph.node(*other).in_loop, id);
    let (from_bound, origins) = (aliases.derived_from(&bound), aliases.origins(&bound));
    // What is combined with the result for each sample of a loop around it is no sample.
    let is_inner = is_gone_through_for_samples(search, node, id);
    let is_sample = |var: Var| from_bound.contains(var) && (bound.contains(&var) || !lasts(graph, var, id));
    let is_fed = |fed: &[Var], into: &[Var]| {
        fed.iter().copied().any(is_sample) || !is_inner && into.iter().any(|var| origins.contains(var))
    };
    let is_written = |from: &Computed| writes_fed(graph, aliases, search, id, from, (&from_bound, &sampled));
    let at_update = match &graph.node(node).effect {
        Effect::Update(update) => is_fed(&update.fed, &update.into) || is_written(&update.from),
        Effect::Call(site) => is_fed(&fed_besides(search, site), &site.into) || is_written(&site.from),
        _ => false,
    };
    if at_update || feeds_by_way(search, node, id, &is_sample) {
        return true;
    }
    // What the instance gives in a round, by its law or another method of it.
    let updated = match &graph.node(node).effect {
        Effect::Update(update) => Some(&update.place),
        Effect::Call(site) => site.args.first().and_then(|arg| arg.place.as_ref()),
        _ => None,
    };
    // A name that may be another filter's says nothing of this one, unless the update goes by the same name.
    let is_certain = |place: &Place| aliases.shared_roots(place).iter().all(|root| root.overlaps(search.instance));
    let is_same = |site: &CallSite| {
        let fed = site.args.first().and_then(|arg| arg.place.as_ref());
        fed.zip(updated).is_none_or(|(fed, updated)| {
            fed.base_var() == updated.base_var() || (is_certain(fed) && is_certain(updated))
        })
    };
    let given: Vec<Var> = graph
        .node_ids()
        .filter(inside)
        .flat_map(|other| match &graph.node(other).effect {
            Effect::Update(update) if concerns(aliases, search, &update.place) => update.into.as_slice(),
            Effect::Call(site) if receives(aliases, search, site) => site.into.as_slice(),
            _ => &[],
        })
        .copied()
        .collect();
    if !info.has_few_rounds()
        && !is_inner
        && (is_mixed_with(search, node, id, &from_bound) || is_lent_with_sample(search, node, id, &from_bound))
    {
        return true;
    }
    let passed_on = passed_on(graph, aliases, search, &given, id);
    let from_given = aliases.derived_from(&passed_on);
    let is_its_name =
        |place: &Place| is_certain(place) || updated.is_some_and(|updated| updated.base_var() == place.base_var());
    // What it gives is used for the samples that the round writes, if only to set something else that runs over them.
    // Of a buffer that is not read, the counter takes the sample: `let sample = &mut buffer.channel_mut(0)[at];`
    let is_taken = |var: Var| {
        matches!(graph.var(var).ty, Ty::Ref(true, _))
            && graph.is_within(graph.var(var).in_loop, id)
            && info.counter.is_some_and(|(counter, _)| aliases.is_derived(var, &[counter]))
    };
    let writes_sample = |other: NodeId| match &graph.node(other).effect {
        Effect::Write(write) => write.place.base_var().is_some_and(|var| from_bound.contains(var) || is_taken(var)),
        _ => false,
    };
    let is_over_block = info.counter.is_some() && !info.has_few_rounds() && !is_inner;
    if is_over_block && !given.is_empty() && graph.node_ids().filter(inside).any(writes_sample) {
        return true;
    }
    if !info.has_few_rounds()
        && !is_inner
        && (puts_aside(graph, aliases, search, node, id, &from_given)
            || graph.node_ids().filter(inside).any(|other| fills(search, other, &sampled, &from_given)))
    {
        return true;
    }
    graph.node_ids().filter(inside).any(|other| match &graph.node(other).effect {
        Effect::Call(site) => {
            is_fed(&fed_besides(search, site), &[])
                && receives(aliases, search, site)
                && is_same(site)
                && site.targets.iter().any(|target| summaries.get(*target).is_some())
        }
        Effect::Write(write) => {
            let is_part = || {
                let roots = aliases.roots(&write.place);
                let is_inside = |root: &Place| root.steps.len() > search.instance.steps.len();
                roots.iter().any(|root| root.overlaps(search.instance) && is_inside(root))
            };
            // What is written is a part of the instance and comes from the sample, or the other way round.
            let written = write.place.base_var().filter(|var| from_bound.contains(*var));
            written.is_some_and(|var| is_part() || from_given.contains(var) && !is_inner)
                || is_part() && is_its_name(&write.place) && is_given(graph, other, node, &from_bound)
        }
        _ => false,
    })
}

/// Whether a loop goes through the same values for each sample of a loop around it: `for s in out { for voice in &voices { … } }`.
fn is_gone_through_for_samples(search: &Search<'_>, node: NodeId, id: LoopId) -> bool {
    let Search { graph, aliases, .. } = *search;
    let info = graph.loop_info(id);
    let bases = info.indexes.iter().chain(&info.sampled).chain(&info.over);
    let keys = bases.clone().flat_map(|place| place.steps.iter().filter_map(Projection::key));
    let keys = keys.filter_map(|key| if let IndexKey::Var(var) = key { Some(*var) } else { None });
    let own: Vec<Var> = info.bound.iter().copied().chain(bases.filter_map(Place::base_var)).chain(keys).collect();
    let mut around = std::iter::successors(info.parent, |outer| graph.loop_info(*outer).parent);
    around.any(|outer| {
        let of_sample = &graph.loop_info(outer).bound;
        !own.iter().any(|var| aliases.is_derived(*var, of_sample)) && search.feeds(node, outer)
    })
}

/// Whether a round puts what a law gives to its number in a block that the filter's owner has: `self.block[i] = gain * level`.
fn fills(search: &Search<'_>, node: NodeId, blocks: &[&Place], from_given: &Derived<'_>) -> bool {
    let graph = search.graph;
    let Effect::Write(write) = &graph.node(node).effect else { return false };
    let is_in = |block: &&Place| {
        write.place.base == block.base
            && write.place.steps.len() > block.steps.len()
            && write.place.steps.starts_with(&block.steps)
    };
    let Some(change) = graph.changes.get(&node).filter(|_| blocks.iter().any(is_in)) else { return false };
    let is_own = |place: &Place| search.aliases.roots(place).iter().any(|root| root.overlaps(search.instance));
    let is_given = |place: &Place| place.base_var().is_some_and(|var| from_given.contains(var)) || is_own(place);
    named(&change.computed.places).into_iter().any(is_given)
}

/// Whether what a write above an update gives comes from one of some variables: `kf.z = *z; kf.update()`.
fn is_given(graph: &ControlFlowGraph, write: NodeId, update: NodeId, from: &Derived<'_>) -> bool {
    let is_before = graph.node(write).span.start < graph.node(update).span.start;
    let computed = graph.changes.get(&write).filter(|_| is_before).map(|change| &change.computed);
    computed.is_some_and(|computed| computed.places.iter().filter_map(Place::base_var).any(|var| from.contains(var)))
}

/// Whether what is computed from these places in a loop may have been computed from a part of something.
fn reads_of(graph: &ControlFlowGraph, from: &[Place], part: &Place, id: LoopId) -> bool {
    let mut open = named(from);
    let mut seen = BTreeSet::new();
    if open.is_empty() {
        return true;
    }
    while let Some(place) = open.pop() {
        if place.base == part.base {
            if place.steps.is_empty() || place.overlaps(part) {
                return true;
            }
        } else if seen.insert(place) {
            let var = place.base_var().filter(|var| !lasts(graph, *var, id));
            let computed = var.and_then(|var| graph.computed.get(&var));
            open.extend(computed.into_iter().flat_map(|computed| named(&computed.places)));
        }
    }
    false
}

/// Whether an update stands behind the question which round of a loop it is, and one round alone leads to it: `if channel == 0`.
pub(super) fn picks_round(graph: &ControlFlowGraph, search: &Search<'_>, node: NodeId, id: LoopId) -> bool {
    let info = graph.loop_info(id);
    let Some((counter, first)) = info.counter else { return false };
    let number = |head: &String| head.parse::<u64>().ok();
    let asked_last: BTreeSet<NodeId> = search.conditions_of(node).collect();
    search.branches_before([node]).into_iter().any(|branch| match &graph.node(branch).effect {
        Effect::Branch(test) => test.subject.is_some_and(|subject| {
            let subject = &graph.subjects[subject.0 as usize];
            let whole = subject.whole.as_ref().and_then(Place::base_var);
            let asks_round = whole.is_some_and(|var| search.aliases.is_derived(var, &[counter]))
                && subject.heads.iter().any(|head| number(head).is_some());
            let reaches = |edge: usize, again: bool| {
                let follows = |from: NodeId, _: usize| again || from != branch;
                let next = graph.node(branch).next.get(edge);
                next.is_some_and(|next| search.reached_from(Region::Loop(id), *next, follows)[node.0 as usize])
            };
            let leads = |edge: usize| reaches(edge, true);
            // In one round of this loop those inside it ask the same again, which is answered as before.
            let leads_alone = |edge: usize| asked_last.contains(&branch) || !reaches(1 - edge, false);
            let numbers = |is_asked: bool, heads: u32| {
                let asked = subject.heads.iter().filter(move |head| (heads & subject.bit(head) != 0) == is_asked);
                asked.filter_map(number)
            };
            let is_one_round = |heads: u32| match (info.rounds.clone(), first) {
                _ if heads & OTHER_HEADS == 0 => numbers(true, heads).count() == 1,
                (Rounds::Constant(rounds), Some(first)) => {
                    let is_round = |number: &u64| (first..first.saturating_add(rounds)).contains(number);
                    numbers(false, heads).filter(is_round).count() as u64 + 1 == rounds
                }
                _ => false,
            };
            asks_round
                && [(0, test.holds), (1, test.fails)]
                    .into_iter()
                    .any(|(edge, heads)| is_one_round(heads) && leads(edge) && leads_alone(edge))
        }),
        _ => false,
    })
}

/// Whether what a loop takes from a queue is an event that chooses whether an update runs: each event of its kind is one cycle.
fn chooses(graph: &ControlFlowGraph, aliases: &Aliases, search: &Search<'_>, node: NodeId, id: LoopId) -> bool {
    let info = graph.loop_info(id);
    info.drains
        && search.branches_before([node]).into_iter().any(|branch| match &graph.node(branch).effect {
            Effect::Branch(test) => {
                let mut reads = test.about.reads.iter().filter_map(Place::base_var);
                test.about.is_choice()
                    && graph.is_within(graph.node(branch).in_loop, id)
                    && reads.any(|var| aliases.is_derived(var, &info.bound))
            }
            _ => false,
        })
}

fn concerns(aliases: &Aliases, search: &Search<'_>, place: &Place) -> bool {
    aliases.shared_roots(place).iter().any(|root| root.overlaps(search.instance))
}

/// Whether the first argument of a call is the instance, a part of it, or its owner.
pub(super) fn receives(aliases: &Aliases, search: &Search<'_>, site: &CallSite) -> bool {
    site.args.first().and_then(|arg| arg.place.as_ref()).is_some_and(|place| concerns(aliases, search, place))
}
