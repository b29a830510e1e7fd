//! References that functions put into what they are lent: `fn add(&mut self, filter: &'a mut Lag) { self.filters.push(filter) }`. Each
//! call of such a function does so where it stands, so that what is updated by them is followed there as if it were written there.

use std::collections::{BTreeMap, BTreeSet};

use super::aliases::Aliases;
use super::callgraph;
use super::declared::declared_ty;
use super::given::{Given, GivenBase, given, place_of};
use super::referred;
use super::summary::Summaries;
use crate::flow::{
    About, Assignment, CallSite, Cause, ControlFlowGraph, Effect, Head, Node, NodeId, Place, Projection, Steps, Test,
    Transfer, Var,
};
use crate::index::{Index, Ty};

/// How many such places of a function are told apart, and how many ways to give one of them a reference.
const MOST: usize = 16;

/// What a function does to a place that refers to filters of its caller's, or is to refer to some.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Put {
    to: Given,
    /// What may be there from then on.
    ways: Vec<Way>,
    /// Whether every way through the function puts something there.
    is_certain: bool,
}

/// What is in such a place from then on: the steps into it, and what of the caller's it refers to there. What it referred to before, it
/// refers to no more.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Way {
    parts: Vec<(Steps, Given)>,
    head: Option<Head>,
    /// Whether something was there before, so that this is a change.
    is_change: bool,
}

/// Adds to each function what those that it calls put into what it lends them, callees first.
pub(super) fn hand_up(index: &Index, graphs: &mut [Option<ControlFlowGraph>]) {
    let mut puts: Vec<BTreeSet<Put>> = vec![BTreeSet::new(); graphs.len()];
    for id in callgraph::components(graphs).into_iter().flatten() {
        let Some(graph) = &mut graphs[id.0 as usize] else { continue };
        take_over(graph, &puts);
        if takes_references(index, graph) {
            puts[id.0 as usize] = puts_of(index, graph);
        }
    }
}

/// Whether a function could put a reference into something that it is lent, or take one out.
fn takes_references(index: &Index, graph: &ControlFlowGraph) -> bool {
    let is_lent = |var: &Var| matches!(&graph.var(*var).ty, Ty::Ref(true, inner) if has_room(index, inner));
    let is_reference = |var: &Var| may_refer(index, &graph.var(*var).ty);
    let is_given = |to: &Var| graph.params.iter().any(|from| from != to && is_reference(from));
    graph.params.iter().any(|to| is_lent(to) && (!graph.pointed.is_empty() || is_given(to)))
}

/// Whether a value of the type may be a reference to a filter, or is made of some.
fn may_refer(index: &Index, ty: &Ty) -> bool {
    matches!(ty, Ty::Param(_)) || index.refers_to_filters(ty)
}

/// Whether there may be a reference to a filter in a value of the type.
fn has_room(index: &Index, ty: &Ty) -> bool {
    may_refer(index, ty)
        || ty.has_part(&mut |part| matches!(part, Ty::Ref(..)))
        || matches!(ty, Ty::Adt(..)) && index.holds_filter(ty)
}

fn puts_of(index: &Index, graph: &ControlFlowGraph) -> BTreeSet<Put> {
    let aliases = Aliases::of(index, graph, &Summaries::default());
    let mut found: BTreeMap<Given, BTreeMap<NodeId, Vec<Way>>> = BTreeMap::new();
    let mut uncertain: BTreeSet<Given> = BTreeSet::new();
    for id in graph.node_ids() {
        let (Effect::Set(set) | Effect::Write(set)) = &graph.node(id).effect else { continue };
        let is_change = graph.pointed.contains(&id);
        let parts = set.from.as_ref().map(|from| aliases.parts(from)).unwrap_or_default();
        if parts.is_empty() && !is_change
            || set.from.as_ref() == Some(&set.place)
            || referred::is_of_variables(index, graph, id, set)
        {
            continue;
        }
        let to = lent_places(index, graph, &aliases, id, &parts);
        for place in &to {
            let ways = ways_of(index, graph, (place, &parts), set.head.as_ref(), is_change);
            if !ways.is_empty() && (found.len() < MOST || found.contains_key(place)) {
                uncertain.extend((to.len() > 1).then(|| place.clone()));
                found.entry(place.clone()).or_default().insert(id, ways);
            }
        }
    }
    let overlaps = |one: &Given, other: &Given| {
        one != other
            && one.base == other.base
            && one.steps.iter().zip(other.steps.iter()).all(|(step, other)| step == other)
    };
    let beside: BTreeSet<&Given> = found.keys().filter(|to| found.keys().any(|other| overlaps(to, other))).collect();
    let put = |(to, nodes): (&Given, &BTreeMap<NodeId, Vec<Way>>)| {
        let all: BTreeSet<NodeId> = nodes.keys().copied().collect();
        let is_mixed = uncertain.contains(to) || beside.contains(to);
        // What is put there later is what is there in the end.
        let is_last = |id: &NodeId| is_mixed || ends_without(graph, &graph.node(*id).next, &all);
        let ways: BTreeSet<Way> =
            nodes.iter().filter(|(id, _)| is_last(id)).flat_map(|(_, ways)| ways.clone()).collect();
        let is_certain = !is_mixed && !ends_without(graph, &[NodeId(0)], &all);
        Put { to: to.clone(), ways: ways.into_iter().collect(), is_certain }
    };
    found.iter().map(put).collect()
}

/// The places of a caller's that a node gives a value that is made of these parts.
fn lent_places(
    index: &Index,
    graph: &ControlFlowGraph,
    aliases: &Aliases,
    id: NodeId,
    parts: &[(Steps, Place)],
) -> BTreeSet<Given> {
    let (Effect::Set(set) | Effect::Write(set)) = &graph.node(id).effect else { return BTreeSet::new() };
    let lent = |given: &Given| match given.base {
        GivenBase::Param(param) => matches!(graph.var(graph.params[param]).ty, Ty::Ref(true, _)),
        GivenBase::Static(_) => false,
    };
    let writes_through = |var: Var| matches!(&graph.var(var).ty, Ty::Ref(true, inner) if may_refer(index, inner));
    let roots: Vec<Place> = match (set.place.steps.split_last(), &graph.node(id).effect) {
        (Some((last, owner)), _) => {
            let owner = aliases.roots(&Place { base: set.place.base, steps: owner.into() });
            owner.into_iter().map(|owner| owner.join(std::slice::from_ref(last))).collect()
        }
        // A variable that refers to something else says nothing of what it referred to.
        (None, Effect::Set(_)) => Vec::new(),
        (None, _) if !set.place.base_var().is_some_and(writes_through) => Vec::new(),
        // From here on the place is a name of what it is given as well.
        (None, _) => {
            let mut roots = aliases.roots(&set.place);
            roots.retain(|root| parts.iter().all(|(_, given)| given != root));
            roots
        }
    };
    roots.iter().filter_map(|root| given(graph, root)).filter(lent).collect()
}

/// What a place may refer to that is given a value that is made of these parts.
fn ways_of(
    index: &Index,
    graph: &ControlFlowGraph,
    (to, parts): (&Given, &[(Steps, Place)]),
    head: Option<&Head>,
    is_change: bool,
) -> Vec<Way> {
    let refers = |place: &Place| declared_ty(index, graph, place).is_some_and(|ty| may_refer(index, &ty));
    let callers = |root: &Place| {
        let from = given(graph, root).filter(|_| refers(root))?;
        (to.base != from.base && matches!(from.base, GivenBase::Param(_))).then_some(from)
    };
    // One of several things is there in each part.
    let mut choices: BTreeMap<&[Projection], BTreeSet<Option<Given>>> = BTreeMap::new();
    for (part, root) in parts {
        let from = callers(root);
        if from.is_some() || is_change {
            choices.entry(part).or_default().insert(from);
        }
    }
    let mut ways = vec![Way { parts: Vec::new(), head: head.cloned(), is_change }];
    for (part, choice) in choices {
        let with = |way: &Way| {
            let more = choice.iter().map(|from| {
                let mut way = way.clone();
                way.parts.extend(from.clone().map(|from| (part.into(), from)));
                way
            });
            more.collect::<Vec<Way>>()
        };
        ways = ways.iter().flat_map(with).take(MOST).collect();
    }
    ways.retain(|way| is_change || !way.parts.is_empty());
    // What was taken out is put back.
    let is_same = |(part, root): &(Steps, Place)| part.is_empty() && given(graph, root).as_ref() == Some(to);
    if is_change && parts.iter().any(is_same) {
        let is_other = |way: &Way| !way.parts.is_empty();
        ways.retain(is_other);
        ways.push(Way { parts: Vec::new(), head: None, is_change: false });
    }
    ways
}

/// Whether a way leads from some nodes to the end of a function without any of others.
fn ends_without(graph: &ControlFlowGraph, from: &[NodeId], others: &BTreeSet<NodeId>) -> bool {
    let mut seen = others.clone();
    let mut open = from.to_vec();
    while let Some(id) = open.pop() {
        if !seen.insert(id) {
            continue;
        }
        let node = graph.node(id);
        if matches!(node.effect, Effect::Return(_)) {
            return true;
        }
        open.extend(&node.next);
    }
    false
}

/// What is in a place of the caller's behind a call: the parts of it, with what each of them refers to.
struct Behind {
    parts: Vec<(Place, Place)>,
    head: Option<Head>,
    is_change: bool,
}

/// Puts behind each call what the function that is called does with references.
fn take_over(graph: &mut ControlFlowGraph, puts: &[BTreeSet<Put>]) {
    for id in graph.node_ids() {
        let Effect::Call(site) = &graph.node(id).effect else { continue };
        let is_only = site.targets.len() == 1;
        let known = site.targets.iter().filter_map(|target| puts.get(target.0 as usize)).flatten();
        let known: Vec<&Put> = known.collect();
        let all: Vec<(Place, Vec<Behind>, bool)> = known
            .iter()
            .filter_map(|put| {
                let ways: Vec<Behind> = put.ways.iter().filter_map(|way| way_at(&put.to, way, site)).collect();
                let to = place_of(&put.to, site).filter(|_| !ways.is_empty())?;
                Some((to, ways, put.is_certain && is_only))
            })
            .collect();
        let (text, lost) = (site.text.clone(), puts_without_name(site, &known));
        for (to, ways, is_certain) in all {
            insert_behind(graph, id, (to, ways), is_certain, &text);
        }
        if !lost.is_empty() {
            let Node { span, next, in_loop, debug_only, .. } = graph.node(id).clone();
            let effect = Effect::Unknown { places: lost, cause: Cause::Moved(text) };
            let behind = NodeId(u32::try_from(graph.nodes.len()).expect("fewer than 2^32 nodes"));
            graph.nodes.push(Node { effect, span, next, in_loop, debug_only });
            graph.nodes[id.0 as usize].next = vec![behind];
        }
    }
}

/// What a call has to do with if one of its targets puts references into a part of a receiver whose type is not known.
fn puts_without_name(site: &CallSite, puts: &[&Put]) -> Vec<Place> {
    // A number leads to nothing where it is given.
    let may_refer = |from: &Given| match from.base {
        GivenBase::Param(param) => site.args.get(param).is_none_or(|arg| !arg.is_plain),
        GivenBase::Static(_) => true,
    };
    let puts_something =
        |put: &Put| put.ways.iter().any(|way| way.is_change || way.parts.iter().any(|(_, from)| may_refer(from)));
    let has_no_name = |put: &&&Put| place_of(&put.to, site).is_none() && puts_something(put);
    let mut places: Vec<Place> = Vec::new();
    for put in puts.iter().filter(has_no_name) {
        let from = put.ways.iter().flat_map(|way| &way.parts).map(|(_, from)| from);
        let params = from.chain([&put.to]).filter_map(|given| match given.base {
            GivenBase::Param(param) => site.args.get(param),
            GivenBase::Static(_) => None,
        });
        places.extend(params.filter_map(|arg| arg.place.clone()));
    }
    places.sort();
    places.dedup();
    places
}

/// What a call leaves in a place on one way; nothing where what it puts there is no reference.
fn way_at(to: &Given, way: &Way, site: &CallSite) -> Option<Behind> {
    let mut parts = Vec::new();
    for (part, from) in &way.parts {
        // A parameter may stand for anything.
        let GivenBase::Param(param) = from.base else { return None };
        site.args.get(param).filter(|arg| arg.is_reference)?;
        let (place, from) = (place_of(to, site)?.join(part), place_of(from, site)?);
        if place != from {
            parts.push((place, from));
        }
    }
    let is_way = !parts.is_empty() || way.is_change || way.parts.is_empty();
    is_way.then(|| Behind { parts, head: way.head.clone(), is_change: way.is_change })
}

fn insert_behind(
    graph: &mut ControlFlowGraph,
    at: NodeId,
    (to, ways): (Place, Vec<Behind>),
    is_certain: bool,
    text: &str,
) {
    let Node { span, next, in_loop, debug_only, .. } = graph.node(at).clone();
    let add = |graph: &mut ControlFlowGraph, effect: Effect, next: Vec<NodeId>| {
        let id = NodeId(u32::try_from(graph.nodes.len()).expect("fewer than 2^32 nodes"));
        graph.nodes.push(Node { effect, span, next, in_loop, debug_only });
        id
    };
    let behind = add(graph, Effect::Nothing, next);
    let mut firsts = if is_certain { Vec::new() } else { vec![behind] };
    let is_one_of_several = ways.len() > 1;
    for way in ways {
        let is_whole = matches!(way.parts.as_slice(), [(part, _)] if *part == to);
        let mut given: Vec<(Place, Option<Place>)> = Vec::new();
        if way.is_change && !is_whole {
            given.push((to.clone(), None));
        }
        let is_lost = (!is_certain || is_one_of_several) && way.is_change && way.parts.is_empty();
        given.extend(way.parts.into_iter().map(|(part, from)| (part, Some(from))));
        let mut first = behind;
        for (place, from) in given.into_iter().rev() {
            let head = way.head.clone().filter(|_| place == to);
            let transfer = Transfer::Borrow;
            let set = Box::new(Assignment { place, from, transfer, rebinds: true, head, same_as: None });
            first = match way.is_change {
                true => add(graph, Effect::Write(set), vec![first]),
                false => add(graph, Effect::Set(set), vec![first]),
            };
            if way.is_change {
                graph.pointed.insert(first);
            }
        }
        if is_lost {
            // Whether it is still there is known where it is asked, and not here.
            let (places, cause) = (vec![to.clone()], Cause::Moved(text.to_owned()));
            first = add(graph, Effect::Unknown { places, cause }, vec![first]);
        }
        firsts.push(first);
    }
    let Some(mut first) = firsts.pop() else { return };
    for other in firsts.into_iter().rev() {
        let text = format!("`{text}` keeps it");
        let test = Test { subject: None, holds: u32::MAX, fails: u32::MAX, span, text, about: About::default() };
        first = add(graph, Effect::Branch(test), vec![first, other]);
    }
    graph.nodes[at.0 as usize].next = vec![first];
}
