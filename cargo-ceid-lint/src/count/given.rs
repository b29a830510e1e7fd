//! Places across calls: what a function is given, and what that is where it is called.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use super::aliases::Aliases;
use crate::flow::{
    Argument, Assignment, Base, CallSite, Cause, ControlFlowGraph, Effect, IndexKey, Place, Projection, Section, Steps,
    Subject, Transfer,
};
use crate::index::{Index, ValueId};
use crate::syntax::tree::{Receiver, TypeRef};

/// A place that a function is given: the parameter or static, and the steps into it.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(super) struct Given {
    pub(super) base: GivenBase,
    pub(super) steps: Steps,
}

impl Given {
    /// The elements that it stands for one by one, where it is each of a slice with known ends.
    pub(super) fn numbered(self) -> Vec<Self> {
        const MOST: u64 = 16;
        if let Some(at) = self.steps.iter().position(
            |step| matches!(step.key(), Some(IndexKey::EachIn(section)) if section.is_taken() || section.is_rest()),
        ) {
            let mut given = self;
            Arc::make_mut(&mut given.steps)[at] = given.steps[at].with_key(IndexKey::Each);
            return vec![given];
        }
        let section = self.steps.iter().enumerate().find_map(|(at, step)| match step.key() {
            Some(IndexKey::EachIn(section)) if section.is_exact => {
                Some((at, section.from..section.to.filter(|to| to - section.from.min(*to) <= MOST)?))
            }
            _ => None,
        });
        let Some((at, numbers)) = section else { return vec![self] };
        let with_number = |number| {
            let mut given = self.clone();
            Arc::make_mut(&mut given.steps)[at] = given.steps[at].with_key(IndexKey::Number(number));
            given
        };
        numbers.map(with_number).collect()
    }

    /// Whether it is each of the first elements of a collection, of which it is known how many, or each but these.
    pub(super) fn is_known_part(&self) -> bool {
        let mut keys = self.steps.iter().filter_map(Projection::key);
        let is_first_few = |own: &Section| own.is_taken() && own.is_exact && own.to.is_some();
        keys.any(|key| matches!(key, IndexKey::EachIn(own) if is_first_few(own) || own.is_rest()))
    }

    /// The parameter or static that it is a part of.
    fn whole(&self) -> Self {
        Self { base: self.base, steps: Steps::default() }
    }

    /// Whether it is a question about a place.
    pub(super) fn is_question(&self) -> bool {
        self.steps.last().is_some_and(Projection::is_question)
    }

    /// Whether it is a parameter or a part of it.
    fn is_inside(&self, number: usize) -> bool {
        self.base == GivenBase::Param(number)
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(super) enum GivenBase {
    Param(usize),
    Static(ValueId),
}

/// How many steps a place of a summary may have; a longer one comes from recursion.
const MAX_STEPS: usize = 8;

/// How many places a summary tells apart; beyond that they are taken together.
pub(super) const MAX_PLACES: usize = 64;

/// The same for numbers that were passed on by value, of which there are more.
pub(super) const MAX_NUMBERS: usize = 512;

/// Takes places together where there are too many: those that lie deepest by what they lie in, and so on up to the parameters.
pub(super) fn bound(places: &mut BTreeSet<Given>) {
    while places.len() > MAX_PLACES {
        let deepest = places.iter().map(|given| given.steps.len()).max().unwrap_or_default();
        if deepest == 0 {
            return;
        }
        let taken = std::mem::take(places).into_iter().map(|mut given| {
            given.steps = given.steps.iter().take(deepest - 1).cloned().collect();
            given
        });
        *places = taken.collect();
        // What lies in one of them is told with it.
        let is_part = |given: &Given| {
            (0..given.steps.len())
                .any(|at| places.contains(&Given { base: given.base, steps: given.steps[..at].into() }))
        };
        let parts: Vec<Given> = places.iter().filter(|given| is_part(given)).cloned().collect();
        places.retain(|given| !parts.contains(given));
    }
}

/// The same for what is told of each place: what holds for the whole is told of none of its parts.
pub(super) fn with_wholes<T>(mut places: BTreeMap<Given, T>, most: usize) -> BTreeMap<Given, T> {
    if places.len() > most {
        places = places.into_iter().rev().map(|(given, told)| (given.whole(), told)).collect();
    }
    let is_part = |given: &&Given| !given.steps.is_empty() && places.contains_key(&given.whole());
    let parts: BTreeSet<Given> = places.keys().filter(is_part).cloned().collect();
    places.retain(|given, _| !parts.contains(given));
    places
}

/// A place of a function as its callers know it; `None` if it is the function's own.
pub(super) fn given(graph: &ControlFlowGraph, place: &Place) -> Option<Given> {
    if place.steps.len() > MAX_STEPS {
        return None;
    }
    let base = match place.base {
        Base::Var(var) => GivenBase::Param(graph.var(var).param?),
        Base::Static(id) => GivenBase::Static(id),
    };
    // An index that is a parameter is known to the caller by the parameter's number.
    let steps = place
        .steps
        .iter()
        .map(|step| match step.key() {
            Some(IndexKey::Var(var)) => step.with_key(graph.var(*var).param.map_or(IndexKey::Each, IndexKey::Param)),
            _ => step.clone(),
        })
        .collect();
    Some(Given { base, steps })
}

/// Whether steps may lead to the same part: an element that stands for each may be any, and so may one that data chooses.
pub(super) fn may_match(steps: &[Projection], place: &[Projection]) -> bool {
    let may_be = |left: &IndexKey, right: &IndexKey| left.relate(right, &|_| None) != Some(false);
    steps.iter().zip(place).all(|(left, right)| {
        left == right || matches!((left.key(), right.key()), (Some(left), Some(right)) if may_be(left, right))
    })
}

/// Notes what the callers of a function know a place by.
pub(super) fn note(graph: &ControlFlowGraph, aliases: &Aliases, place: &Place, into: &mut BTreeSet<Given>) {
    into.extend(aliases.shared_roots(place).iter().filter_map(|root| given(graph, root)));
}

/// The same with the cause why it is not known what happens there.
pub(super) fn note_unknown(
    graph: &ControlFlowGraph,
    aliases: &Aliases,
    place: &Place,
    cause: &Cause,
    into: &mut BTreeMap<Given, Cause>,
) {
    // What a tuple lends goes where the tuple goes: `unseen((name, &mut self.lag))`.
    for (_, root) in aliases.parts(place) {
        if let Some(given) = given(graph, &root) {
            into.entry(given).or_insert_with(|| cause.clone());
        }
    }
}

/// Whether a place of the caller's gets what was in another one: `mem::swap(&mut self.front, &mut self.back)`.
pub(super) fn is_put_in_place(graph: &ControlFlowGraph, set: &Assignment) -> bool {
    set.rebinds && set.transfer == Transfer::Move && set.from.is_some() && given(graph, &set.place).is_some()
}

/// Whether something else is put in a place of the caller's.
pub(super) fn is_moved(graph: &ControlFlowGraph, place: &Place) -> bool {
    graph.nodes.iter().any(|node| match &node.effect {
        Effect::Set(set) => is_put_in_place(graph, set) && set.place == *place,
        _ => false,
    })
}

/// The place that callers know a subject of a function by; `None` if it is the function's own or a static.
pub(super) fn given_subject(graph: &ControlFlowGraph, subject: &Subject) -> Option<Given> {
    given(graph, subject.known_as()?).filter(|given| matches!(given.base, GivenBase::Param(_)))
}

/// The place inside the function that callers know as given.
pub(super) fn instance_of(graph: &ControlFlowGraph, given: &Given) -> Place {
    let steps: Steps = given
        .steps
        .iter()
        .map(|step| match step.key() {
            Some(IndexKey::Param(param)) => match graph.params.get(*param) {
                Some(var) => step.with_key(IndexKey::Var(*var)),
                None => step.clone(),
            },
            _ => step.clone(),
        })
        .collect();
    match given.base {
        GivenBase::Param(param) => Place { base: Base::Var(graph.params[param]), steps },
        GivenBase::Static(id) => Place { base: Base::Static(id), steps },
    }
}

/// The steps of a callee's place at a call of it: an index that is a parameter is the argument.
pub(super) fn steps_at(steps: &[Projection], site: &CallSite) -> Steps {
    let at_call = |step: &Projection| match step.key() {
        Some(IndexKey::Param(param)) => {
            let key = site.args.get(*param).and_then(|arg| arg.index.clone());
            step.with_key(key.unwrap_or_else(|| IndexKey::Data("the argument".into())))
        }
        _ => step.clone(),
    };
    steps.iter().map(at_call).collect()
}

/// The place at a call whose value a condition of the callee asks for.
pub(super) fn asked_at(given: &Given, site: &CallSite) -> Option<Place> {
    if let Some((question, steps)) = given.steps.split_last().filter(|(last, _)| last.is_question()) {
        let asked = asked_at(&Given { base: given.base, steps: steps.into() }, site)?;
        return Some(asked.join(std::slice::from_ref(question)));
    }
    match argument(given, site) {
        Some(argument) => argument.value_of.clone(),
        None => place_of(given, site),
    }
}

/// What a call gives for a whole parameter.
pub(super) fn argument<'a>(given: &Given, site: &'a CallSite) -> Option<&'a Argument> {
    match given.base {
        GivenBase::Param(param) if given.steps.is_empty() => site.args.get(param),
        _ => None,
    }
}

/// The place at a call that a callee knows as given.
pub(super) fn place_of(given: &Given, site: &CallSite) -> Option<Place> {
    // A law that hands on to another one of the same filter is one update, and what lies inside a filter whose type is not known
    // has no name here.
    let is_first = given.is_inside(site.law_of.unwrap_or(0));
    let is_filter = || given.steps.iter().all(|step| matches!(step, Projection::Channel(_)));
    if is_first && (site.is_dispatched && !given.steps.is_empty() || site.law_of.is_some() && is_filter()) {
        return None;
    }
    let steps = steps_at(&given.steps, site);
    match given.base {
        GivenBase::Param(param) => Some(site.args.get(param)?.place.as_ref()?.join(&steps)),
        GivenBase::Static(id) => Some(Place { base: Base::Static(id), steps }),
    }
}

/// Whether some target of a call takes an argument by value.
pub(super) fn takes_by_value(index: &Index, site: &CallSite, number: usize) -> bool {
    site.targets.iter().any(|target| {
        let function = &index.function(*target).function;
        match (&function.receiver, number) {
            (Some(Receiver::Value), 0) => true,
            (Some(_), 0) => false,
            (receiver, number) => {
                let at = number - usize::from(receiver.is_some());
                function.params.get(at).is_some_and(|ty| !matches!(ty, TypeRef::Reference { .. }))
            }
        }
    })
}

/// Whether what a callee leaves in what it is given is in the caller's place afterwards: what it gets by value is its own, unless its
/// result takes that place.
pub(super) fn is_left_there(index: &Index, given: &Given, site: &CallSite) -> bool {
    let GivenBase::Param(number) = given.base else { return true };
    site.args.get(number).is_some_and(|arg| arg.is_back) || !takes_by_value(index, site, number)
}
