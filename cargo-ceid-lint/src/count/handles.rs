//! Handles whose clones lead to one filter (`Rc`, `Arc`): what has another name in a cycle may be the same filter.

use std::collections::{BTreeMap, BTreeSet};

use super::analyse::{Context, CycleId, FunctionFacts};
use super::given::{Given, GivenBase, may_match, place_of, steps_at};
use super::instances::{leaves, leaves_and_payloads, place_ty};
use super::summary::Summaries;
use super::verdict::{Pair, Verdict};
use crate::flow::{
    Base, CallSite, Cause, ControlFlowGraph, Effect, IndexKey, NodeId, Place, Projection, Steps, Transfer, Var,
};
use crate::index::{Index, Ty, TypeId};

/// How many names are looked at for one place, and how many steps one may have.
const MAX_NAMES: usize = 200;
const MAX_STEPS: usize = 24;

/// Where the handles of a function come from, whether they are moved or cloned.
#[derive(Debug, Default)]
pub(super) struct Handles {
    sources: BTreeMap<Var, Vec<Source>>,
}

/// What a variable, or a part of it, is given.
#[derive(Debug)]
struct Source {
    steps: Steps,
    from: Place,
    at: Option<NodeId>,
}

/// Parts of what is made somewhere that lead to one filter there, wherever it is used.
#[derive(Debug, Default)]
pub(super) struct Joined {
    /// The steps to the two parts of a value.
    parts: Vec<(Made, Steps, Steps)>,
    /// The steps into the elements of a collection of which several have the same.
    elements: Vec<(Made, Steps)>,
    /// The filters whose handles are cloned somewhere, and those whose handles are put together with others.
    pub(super) cloned: Vec<Ty>,
    mixed: Vec<Ty>,
    /// Those to which weak handles lead that are used.
    pub(super) upgraded: Vec<Ty>,
}

/// What is made of parts: its type, if that has a name, and the type of the filter.
type Made = (Option<TypeId>, Option<Ty>);

/// The type of the filter that a handle leads to.
pub(super) fn filter_at(index: &Index, graph: &ControlFlowGraph, place: &Place) -> Option<Ty> {
    let ty = place_ty(index, graph, place)?;
    leaves(index, &ty).into_iter().find(|leaf| leaf.steps.is_empty()).map(|leaf| leaf.ty)
}

/// Whether what is made may be of these types. What a filter is generic over is not always known where it is made.
fn may_be_of((name, made): &Made, (owner, filter): (Option<TypeId>, &Option<Ty>)) -> bool {
    *name == owner
        && match (made, filter) {
            (Some(Ty::Adt(made, _)), Some(Ty::Adt(filter, _))) => made == filter,
            (Some(Ty::External(made, _)), Some(Ty::External(filter, _))) => made == filter,
            (Some(Ty::Adt(..)), Some(Ty::External(..))) | (Some(Ty::External(..)), Some(Ty::Adt(..))) => false,
            _ => true,
        }
}

/// The name of the type of a value.
fn name_of(ty: &Ty) -> Option<TypeId> {
    if let Ty::Adt(id, _) = ty.peel() { Some(*id) } else { None }
}

/// Whether a function has to do with handles of filters at all.
pub(super) fn has_handles(index: &Index, graph: &ControlFlowGraph) -> bool {
    graph.vars.iter().any(|info| index.may_share_filter(&info.ty))
}

/// Whether a filter lies behind a handle, as far as the type of what holds it tells.
pub(super) fn is_shared(index: &Index, graph: &ControlFlowGraph, place: &Place) -> bool {
    let ty = match place.base {
        Base::Var(var) => Some(graph.var(var).ty.clone()),
        Base::Static(_) => place_ty(index, graph, &Place::from(place.base)),
    };
    let is_it = |steps: &[Projection]| steps.len() >= place.steps.len() && may_match(steps, &place.steps);
    // Without a handle on the way there, the filters need not be told one by one.
    let ty = ty.filter(|ty| index.may_share_filter(ty));
    let leaves = ty.map(|ty| leaves_and_payloads(index, &ty)).unwrap_or_default();
    leaves.iter().any(|leaf| leaf.is_shared && is_it(&leaf.steps))
}

/// The place of an argument, or a name of its own for what has none.
fn argument(site: &CallSite, param: usize) -> Place {
    let place = site.args.get(param).and_then(|arg| arg.place.clone());
    place.unwrap_or_else(|| Place::var(site.result).field(&format!("#{param}")))
}

impl Handles {
    pub(super) fn of(index: &Index, graph: &ControlFlowGraph, summaries: &Summaries) -> Self {
        let mut handles = Self::default();
        if !has_handles(index, graph) {
            return handles;
        }
        for (id, node) in graph.node_ids().zip(&graph.nodes) {
            match &node.effect {
                Effect::Set(set) | Effect::Write(set) => {
                    let shares = |var: Var| index.may_share_filter(&graph.var(var).ty);
                    // A copy of what has handles in it leads to the same.
                    let goes_on = set.transfer != Transfer::Copy || set.place.base_var().is_some_and(shares);
                    if let Some(from) = set.from.as_ref().filter(|_| goes_on) {
                        handles.add(&set.place, from.clone(), Some(id));
                    }
                }
                Effect::Call(site) => {
                    for callee in site.targets.iter().filter_map(|target| summaries.get(*target)) {
                        for borrow in callee.returns_at(site) {
                            let from = argument(site, borrow.param).join(&steps_at(&borrow.steps, site));
                            handles.add(&Place::var(site.result).join(&borrow.part), from, Some(id));
                        }
                        let at = |given: &Given| match given.base {
                            GivenBase::Param(param) => argument(site, param).join(&steps_at(&given.steps, site)),
                            GivenBase::Static(id) => {
                                Place { base: Base::Static(id), steps: steps_at(&given.steps, site) }
                            }
                        };
                        for (to, from) in &callee.puts {
                            handles.add(&place_of(to, site).unwrap_or_else(|| at(to)), at(from), Some(id));
                        }
                    }
                }
                _ => {}
            }
        }
        for (var, place) in graph.loops.iter().flat_map(|info| &info.items) {
            handles.add(&Place::var(*var), place.clone(), None);
        }
        handles
    }

    fn add(&mut self, to: &Place, from: Place, at: Option<NodeId>) {
        if let Some(var) = to.base_var()
            && to.steps.len() <= MAX_STEPS
        {
            self.sources.entry(var).or_default().push(Source { steps: to.steps.clone(), from, at });
        }
    }

    /// Where what lies at a place comes from, and the places on the way there; with what lies in it, if that is asked for.
    fn origins(&self, place: &Place, with_parts: bool) -> Origins {
        let mut found = Origins::default();
        let mut open = vec![place.clone()];
        while let Some(place) = open.pop() {
            if found.on_the_way.len() > MAX_NAMES
                || place.steps.len() > MAX_STEPS
                || !found.on_the_way.insert(place.clone())
            {
                continue;
            }
            let mut is_first = true;
            for source in place.base_var().and_then(|var| self.sources.get(&var)).into_iter().flatten() {
                let is_part = source.steps.len() > place.steps.len();
                if may_match(&source.steps, &place.steps) && (with_parts || !is_part) {
                    is_first &= is_part;
                    open.push(source.from.join(place.steps.get(source.steps.len()..).unwrap_or_default()));
                }
            }
            if is_first {
                found.first.insert(place);
            }
        }
        found
    }

    /// Where what lies at a place comes from, and all places on the way there.
    pub(super) fn ways_to(&self, place: &Place) -> [BTreeSet<Place>; 2] {
        let found = self.origins(place, false);
        [found.first, found.on_the_way]
    }

    /// The variables that are given what another one has, or a part of it.
    pub(super) fn given_from(&self, var: Var) -> impl Iterator<Item = Var> + '_ {
        let gets = move |sources: &Vec<Source>| sources.iter().any(|source| source.from.base_var() == Some(var));
        self.sources.iter().filter(move |(_, sources)| gets(sources)).map(|(to, _)| *to)
    }

    /// Whether two different places may lead to one filter.
    fn may_be_one(&self, left: &Place, right: &Place) -> bool {
        self.origins(left, false).overlaps(&self.origins(right, false))
    }

    /// The same with what is known of the values that they are parts of.
    pub(super) fn are_one(
        &self,
        context: &Context<'_>,
        graph: &ControlFlowGraph,
        (left, right): (&Place, &Place),
        filter: &Option<Ty>,
    ) -> bool {
        let has = |pair: (&Place, &Place)| context.joined.has(context.program.index, graph, pair, filter);
        let [of_left, of_right] = [left, right].map(|place| self.origins(place, false));
        of_left.overlaps(&of_right)
            || has((left, right))
            || of_left.first.iter().any(|left| of_right.first.iter().any(|right| has((left, right))))
    }

    /// Where the elements of collections come from that something is done to.
    fn elements_in_use(&self, graph: &ControlFlowGraph) -> Vec<Origins> {
        let used = graph.nodes.iter().flat_map(|node| match &node.effect {
            Effect::Update(update) => vec![&update.place],
            Effect::Call(site) => site.args.iter().filter_map(|arg| arg.place.as_ref()).collect(),
            _ => Vec::new(),
        });
        used.map(|place| self.origins(place, false)).filter(Origins::has_element).collect()
    }

    /// Whether a place is one of these elements, by whatever name.
    fn is_element(&self, place: &Place, in_use: &[Origins]) -> bool {
        let own = self.origins(place, false);
        own.has_element() || in_use.iter().any(|element| element.overlaps(&own))
    }

    /// The elements that a variable is given, or what is moved into it as a whole, each with where the steps into it begin.
    fn elements_of(&self, var: Var) -> Vec<(&Source, usize)> {
        let (mut found, mut seen, mut open) = (Vec::new(), BTreeSet::new(), vec![var]);
        while let Some(var) = open.pop().filter(|_| seen.len() < MAX_NAMES) {
            if !seen.insert(var) {
                continue;
            }
            for source in self.sources.get(&var).into_iter().flatten() {
                match source.steps.iter().position(|step| matches!(step, Projection::Index(_))) {
                    Some(at) => found.push((source, at)),
                    None if source.steps.is_empty() && source.from.steps.is_empty() => {
                        open.extend(source.from.base_var());
                    }
                    None => {}
                }
            }
        }
        found
    }

    /// Whether a filter lies in several elements of a collection, through which something is updated.
    fn is_repeated_in_a_collection(&self, index: &Index, graph: &ControlFlowGraph, place: &Place) -> bool {
        let own = self.origins(place, false);
        self.sources.keys().any(|var| {
            let elements = self.elements_of(*var);
            // What lies in the elements themselves is another filter in each.
            let mut holding = elements.iter().filter(|(source, _)| {
                is_shared(index, graph, &source.from) && self.origins(&source.from, true).overlaps(&own)
            });
            let (Some((first, _)), Some((second, _))) = (holding.next(), holding.next()) else { return false };
            let is_used =
                |place: &Place| self.origins(place, false).on_the_way.iter().any(|on| on.base_var() == Some(*var));
            first.at != second.at
                && graph.nodes.iter().any(|node| match &node.effect {
                    Effect::Update(update) => is_used(&update.place),
                    Effect::Call(site) => site.args.iter().filter_map(|arg| arg.place.as_ref()).any(is_used),
                    _ => false,
                })
        })
    }
}

/// Where something comes from.
#[derive(Default)]
struct Origins {
    /// What comes from nowhere else.
    first: BTreeSet<Place>,
    on_the_way: BTreeSet<Place>,
}

impl Origins {
    fn has_element(&self) -> bool {
        self.on_the_way.iter().any(|place| place.steps.iter().any(|step| step.key().is_some()))
    }

    fn overlaps(&self, other: &Self) -> bool {
        self.first.iter().any(|place| other.first.iter().any(|other| place.overlaps(other)))
    }
}

impl Joined {
    /// Finds them in everything that is made of parts.
    pub(super) fn of(index: &Index, facts: &[FunctionFacts<'_>]) -> Self {
        let mut found = Self::default();
        for FunctionFacts { graph, handles, .. } in facts {
            let duplicated = &graph.duplicated;
            let noted = [&duplicated.cloned, &duplicated.mixed, &duplicated.upgraded];
            for (types, found) in noted.iter().zip([&mut found.cloned, &mut found.mixed, &mut found.upgraded]) {
                types.iter().for_each(|ty| add_filters(index, ty, found));
            }
            for var in handles.sources.keys() {
                let ty = graph.var(*var).ty.peel();
                if matches!(ty, Ty::Adt(..) | Ty::Tuple(_)) {
                    found.note_parts(index, handles, (*var, ty));
                }
                found.note_elements(index, graph, handles, *var);
            }
        }
        found
    }

    fn note_parts(&mut self, index: &Index, handles: &Handles, (var, ty): (Var, &Ty)) {
        let mut shared = leaves(index, ty);
        shared.retain(|leaf| leaf.is_shared);
        for (at, left) in shared.iter().enumerate() {
            for right in shared[at + 1..].iter().filter(|right| right.ty == left.ty) {
                let [one, other] = [left, right].map(|leaf| Place::var(var).join(&leaf.steps));
                if handles.may_be_one(&one, &other) {
                    self.parts.push(((name_of(ty), Some(left.ty.clone())), left.steps.clone(), right.steps.clone()));
                }
            }
        }
    }

    /// Notes what several elements of a collection get.
    fn note_elements(&mut self, index: &Index, graph: &ControlFlowGraph, handles: &Handles, var: Var) {
        // What the elements are given, by their collections.
        let mut elements: BTreeMap<&[Projection], Vec<(&Source, usize)>> = BTreeMap::new();
        for (source, at) in handles.elements_of(var) {
            elements.entry(&source.steps[..at]).or_default().push((source, at + 1));
        }
        for given in elements.values() {
            // What a collection is, is not always known, but what comes into it is.
            let ty = given.iter().find_map(|(source, at)| {
                let is_whole = source.steps.len() == *at;
                let element = Place::var(var).join(&source.steps[..*at]);
                place_ty(index, graph, if is_whole { &source.from } else { &element })
            });
            let Some(ty) = ty else { continue };
            let are_handles = given.iter().any(|(source, _)| is_shared(index, graph, &source.from));
            for leaf in leaves(index, &ty).into_iter().filter(|leaf| leaf.is_shared || are_handles) {
                let from = given.iter().filter_map(|(source, at)| {
                    let rest = leaf.steps.strip_prefix(&source.steps[*at..])?;
                    Some((source.at, handles.origins(&source.from.join(rest), false)))
                });
                let from: Vec<(Option<NodeId>, Origins)> = from.collect();
                let is_again = |(at, origins): &(Option<NodeId>, Origins)| {
                    at.is_some_and(|at| origins.first.iter().any(|place| outlasts_round(graph, place, at)))
                        || from.iter().any(|(other, others)| other != at && others.overlaps(origins))
                };
                if from.iter().any(is_again) {
                    // A tuple may have been made to be taken apart: `unzip`.
                    if let (Ty::Tuple(parts), [Projection::Field(number), rest @ ..]) = (&ty, &*leaf.steps)
                        && let Some(part) = number.parse::<usize>().ok().and_then(|number| parts.get(number))
                    {
                        self.elements.push(((name_of(part), Some(leaf.ty.clone())), rest.into()));
                    }
                    self.elements.push(((name_of(&ty), Some(leaf.ty)), leaf.steps));
                }
            }
        }
    }

    /// Whether two places are parts of one value that some code makes lead to one filter.
    fn has(
        &self,
        index: &Index,
        graph: &ControlFlowGraph,
        (left, right): (&Place, &Place),
        filter: &Option<Ty>,
    ) -> bool {
        let common = left.steps.iter().zip(right.steps.iter()).take_while(|(left, right)| left == right).count();
        left.base == right.base
            && !self.parts.is_empty()
            && (0..=common).any(|at| {
                let owner = left.up_to(at);
                let Some(ty) = place_ty(index, graph, &owner) else { return false };
                let made = (name_of(&ty), filter);
                let [one, other] = [left, right].map(|place| &place.steps[at..]);
                let are_these = |left: &[Projection], right: &[Projection]| left == one && right == other;
                let is_it = |(own, left, right): &(Made, Steps, Steps)| {
                    may_be_of(own, made) && (are_these(left, right) || are_these(right, left))
                };
                self.parts.iter().any(is_it)
            })
    }

    /// Whether a place lies in the elements of a collection, several of which some code gives the same filter.
    fn has_elements(&self, index: &Index, graph: &ControlFlowGraph, place: &Place, filter: &Option<Ty>) -> bool {
        !self.elements.is_empty()
            && (0..place.steps.len()).filter(|at| matches!(place.steps[*at], Projection::Index(_))).any(|at| {
                let element = place.up_to(at + 1);
                let Some(ty) = place_ty(index, graph, &element) else { return false };
                let made = (name_of(&ty), filter);
                self.elements.iter().any(|(own, steps)| may_be_of(own, made) && **steps == place.steps[at + 1..])
            })
    }
}

/// Notes the filters behind the handles in a type.
fn add_filters(index: &Index, ty: &Ty, found: &mut Vec<Ty>) {
    ty.has_part(&mut |part| {
        for leaf in leaves_and_payloads(index, part) {
            if !found.contains(&leaf.ty) {
                found.push(leaf.ty);
            }
        }
        false
    });
}

/// Whether a filter is one of some types. What it is generic over is not always known.
pub(super) fn is_among(filters: &[Ty], filter: &Option<Ty>) -> bool {
    filters.iter().any(|own| may_be_of(&(None, Some(own.clone())), (None, filter)))
}

/// Whether two places lie in the same collection.
fn are_side_by_side(left: &Place, right: &Place) -> bool {
    let owner = |place: &Place| {
        let at = place.steps.iter().position(|step| step.key().is_some())?;
        Some(place.up_to(at))
    };
    owner(left).is_some_and(|own| owner(right) == Some(own))
}

/// Whether a place has the same in each round of the loop around a node, or may have it in several.
fn outlasts_round(graph: &ControlFlowGraph, place: &Place, at: NodeId) -> bool {
    let Some(inner) = graph.node(at).in_loop else { return false };
    if place.steps.iter().any(|step| matches!(step.key(), Some(IndexKey::Data(_)))) {
        return true;
    }
    let is_element = place.steps.iter().any(|step| matches!(step, Projection::Index(_)));
    let Some(var) = place.base_var() else { return !is_element };
    let declared = graph.var(var).in_loop;
    // What a closure is lent is somewhere else, and nothing tells where.
    let is_in_round = declared == Some(inner) || graph.is_within(declared, inner);
    if is_in_round && matches!(graph.var(var).ty, Ty::Ref(..)) {
        return true;
    }
    let is_given_anew = graph.nodes.iter().any(|node| match &node.effect {
        Effect::Set(set) => set.place.base_var() == Some(var) && graph.is_within(node.in_loop, inner),
        _ => false,
    });
    !is_element && !is_given_anew && declared != Some(inner) && !graph.is_within(declared, inner)
}

/// What may be the same filter as another one that the cycle updates is not proved to be updated once.
pub(super) fn settle(context: &Context<'_>, facts: &FunctionFacts<'_>, pairs: &mut BTreeMap<CycleId, Vec<Pair>>) {
    let (index, graph) = (context.program.index, facts.graph);
    let shared: BTreeMap<String, &Place> = facts
        .updated
        .iter()
        .filter(|instance| is_shared(index, graph, &instance.place))
        .map(|instance| (graph.place_name(index, &instance.place), &instance.place))
        .collect();
    if shared.is_empty() {
        return;
    }
    let handles = &facts.handles;
    // Only of what is cloned it is asked which are elements.
    let elements: BTreeSet<&Place> = if context.joined.cloned.is_empty() {
        BTreeSet::new()
    } else {
        let in_use = handles.elements_in_use(graph);
        shared.values().copied().filter(|place| handles.is_element(place, &in_use)).collect()
    };
    for filters in pairs.values_mut() {
        let doubts: Vec<Option<Cause>> = filters
            .iter()
            .map(|pair| {
                let place = shared.get(&pair.name).filter(|_| pair.verdict != Verdict::Repeated)?;
                let filter = &filter_at(index, graph, place);
                let is_cloned = is_among(&context.joined.cloned, filter);
                let is_own_element = is_cloned && elements.contains(*place);
                let is_same = |other: &&Pair| {
                    let is_alike = other.half == pair.half && other.filter_type == pair.filter_type;
                    let other = shared.get(&other.name).filter(|other| is_alike && *other != place);
                    other.is_some_and(|other| {
                        // Of what is cloned, an element may be any other one.
                        let is_it_too = is_own_element || is_cloned && elements.contains(*other);
                        is_it_too && !are_side_by_side(place, other)
                            || handles.are_one(context, graph, (place, other), filter)
                    })
                };
                if let Some(other) = filters.iter().find(is_same) {
                    return Some(Cause::Limit(format!("`{}` may be another handle to it", other.name)));
                }
                // What was taken out of a collection is still one of its elements.
                let is_element = |place: &Place| context.joined.has_elements(index, graph, place, filter);
                let is_repeated = is_own_element && is_among(&context.joined.mixed, filter)
                    || handles.is_repeated_in_a_collection(index, graph, place)
                    || is_element(place)
                    || handles.origins(place, false).first.iter().any(is_element);
                is_repeated.then(|| Cause::Limit("several elements of a collection are handles to it".to_owned()))
            })
            .collect();
        for (pair, doubt) in filters.iter_mut().zip(doubts) {
            if let Some(cause) = doubt {
                *pair = pair.in_doubt(&cause);
            }
        }
    }
}
