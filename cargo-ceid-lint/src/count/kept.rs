//! What a function puts into what its callers lent it, and what it takes out of that.

use std::collections::{BTreeMap, BTreeSet};

use super::aliases::Aliases;
use super::given::{Given, GivenBase, MAX_PLACES, given, place_of};
use super::handles::{has_handles, is_shared};
use super::summary::Summaries;
use super::uses::is_plain;
use crate::flow::{Base, ControlFlowGraph, Effect, Place, Transfer};
use crate::index::{Index, Ty};

/// The parameters that a function puts into what another one of them leads to: `self.all.push(filter)`.
pub(super) fn params(
    index: &Index,
    graph: &ControlFlowGraph,
    aliases: &Aliases,
    summaries: &Summaries,
) -> BTreeSet<usize> {
    let params = |places: &mut dyn Iterator<Item = Place>| -> BTreeSet<usize> {
        let bases = places.filter_map(|place| given(graph, &place)).map(|given| given.base);
        bases.filter_map(|base| if let GivenBase::Param(param) = base { Some(param) } else { None }).collect()
    };
    let mut kept = BTreeSet::new();
    // What a new value has a copy of: `Channel { filter, gain }`.
    let mut copies: BTreeMap<Base, BTreeSet<usize>> = BTreeMap::new();
    for node in &graph.nodes {
        match &node.effect {
            Effect::Set(set) | Effect::Write(set) => {
                let Some(from) = set.from.as_ref().filter(|from| !is_plain(index, graph, from)) else { continue };
                let owner = Place::from(set.place.base);
                let owners = params(&mut aliases.roots(&owner).into_iter());
                let mut given = params(&mut aliases.parts(from).into_iter().map(|(_, root)| root));
                given.extend(copies.get(&from.base).into_iter().flatten());
                if owners.is_empty() {
                    if set.transfer != Transfer::Borrow {
                        copies.entry(set.place.base).or_default().extend(&given);
                    }
                } else if !set.place.steps.is_empty() {
                    kept.extend(given.difference(&owners));
                }
            }
            Effect::Call(site) => {
                let callees = site.targets.iter().filter_map(|target| summaries.get(*target));
                for number in callees.flat_map(|callee| &callee.keeps) {
                    let Some(arg) = site.args.get(*number) else { continue };
                    let copied = arg.value_of.iter().filter(|_| arg.is_copy);
                    let moved = arg.place.iter().chain(copied).filter(|place| !is_plain(index, graph, place));
                    let given: BTreeSet<usize> =
                        moved.flat_map(|place| params(&mut aliases.roots(place).into_iter())).collect();
                    // What stays in the same parameter, whichever argument the callee puts it into, has not gone anywhere.
                    let others = site.args.iter().enumerate().filter(|(other, arg)| other != number && !arg.is_shared);
                    let owners = others.filter_map(|(_, arg)| arg.place.as_ref());
                    let owners = owners.map(|place| params(&mut aliases.roots(place).into_iter()));
                    let common = owners.reduce(|common, own| &common & &own).unwrap_or_default();
                    kept.extend(given.difference(&common));
                }
            }
            _ => {}
        }
    }
    kept
}

/// The filters that a function takes out of what its callers lent it: `let mut job = self.queue.pop()?;`.
pub(super) fn taken_out(
    index: &Index,
    graph: &ControlFlowGraph,
    aliases: &Aliases,
    summaries: &Summaries,
) -> BTreeSet<Given> {
    let mut found = BTreeSet::new();
    let is_lent = |place: &Place| place.base_var().is_some_and(|var| matches!(graph.var(var).ty, Ty::Ref(true, _)));
    let has_name = |place: &Place| {
        let var = place.base_var().map(|var| graph.var(var));
        !place.steps.is_empty() || var.is_some_and(|var| !var.name.is_empty() && !var.name.starts_with('_'))
    };
    let mut add = |place: &Place| {
        let lent = aliases.roots(place).into_iter().filter(&is_lent);
        found.extend(lent.filter_map(|root| given(graph, &root)));
    };
    for node in &graph.nodes {
        match &node.effect {
            Effect::Set(set) | Effect::Write(set) if set.transfer == Transfer::Move && has_name(&set.place) => {
                set.from.iter().filter(|from| !is_plain(index, graph, from)).for_each(&mut add);
            }
            Effect::Call(site) => {
                summaries.places(site, |callee| &callee.takes_out).for_each(|place| add(&place));
            }
            _ => {}
        }
    }
    graph.taken_out.iter().for_each(&mut add);
    if found.len() > MAX_PLACES { BTreeSet::new() } else { found }
}

/// Where a function puts the handles of filters that it is given, itself or by a call.
pub(super) fn handles(
    index: &Index,
    graph: &ControlFlowGraph,
    aliases: &Aliases,
    summaries: &Summaries,
) -> BTreeSet<(Given, Given)> {
    let mut found = BTreeSet::new();
    if !has_handles(index, graph) {
        return found;
    }
    let mut add = |to: &Place, from: &Place| {
        for (part, root) in aliases.parts(from) {
            let Some(from) = given(graph, &root).filter(|_| is_shared(index, graph, &root)) else { continue };
            for to in aliases.roots(to).into_iter().filter_map(|to| given(graph, &to.join(&part))) {
                if to.base != from.base && matches!(from.base, GivenBase::Param(_)) {
                    found.insert((to, from.clone()));
                }
            }
        }
    };
    for node in &graph.nodes {
        match &node.effect {
            Effect::Set(set) | Effect::Write(set) => {
                if let Some(from) = &set.from {
                    add(&set.place, from);
                }
            }
            Effect::Call(site) => {
                let callees = site.targets.iter().filter_map(|target| summaries.get(*target));
                for (to, from) in callees.flat_map(|callee| &callee.puts) {
                    if let (Some(to), Some(from)) = (place_of(to, site), place_of(from, site)) {
                        add(&to, &from);
                    }
                }
            }
            _ => {}
        }
    }
    if found.len() > MAX_PLACES { BTreeSet::new() } else { found }
}
