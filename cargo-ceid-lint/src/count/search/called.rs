//! What a call means to one instance: many targets come down to few different effects.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use super::Search;
use crate::count::answers::Answers;
use crate::count::called_place::CalledPlace;
use crate::count::given::{Given, place_of};
use crate::count::given_heads::GivenHeads;
use crate::count::instances::place_ty;
use crate::count::outcome::Outcome;
use crate::count::returned;
use crate::flow::{CallSite, Cause, IndexKey, Place, Steps, SubjectId};
use crate::index::{FunctionId, Owner, Ty};

/// What a call does, whatever the way that leads to it.
#[derive(Debug, Default)]
pub(in crate::count) struct Called {
    /// What it writes, by each of its names, for conditions that read it; with the heads that it gives it, if they are all known.
    pub(super) writes: BTreeMap<Place, Option<GivenHeads>>,
    /// What one of its targets does, each different effect once.
    pub(super) effects: Vec<Effect>,
    /// The caller's subjects of which its ways assume something.
    pub(super) asked: BTreeMap<Given, SubjectId>,
    /// What its result may borrow: the place, and the steps into the result.
    pub(super) borrows: BTreeSet<(Steps, Place)>,
}

/// What a target of a call does.
#[derive(Debug, PartialEq, Eq)]
pub(super) struct Effect {
    /// The ways through it, by the places that may be the instance or hold it.
    pub(super) outcomes: Vec<(Place, Vec<Outcome>)>,
    /// The heads that its result may have; none if that is not known.
    pub(super) heads: returned::Heads,
    /// The same, where it depends on what is known here.
    pub(super) answers: Answers,
    /// Whether it is the body of another type than that of the instance's owner, which runs only where the receiver is something else.
    pub(super) is_of_others: bool,
}

impl Search<'_> {
    /// What a call does, as far as the instance is concerned.
    pub(super) fn called(&self, site: &CallSite) -> Arc<Called> {
        if let Some(known) = self.called.borrow().get(&site.result) {
            return Arc::clone(known);
        }
        let places = self.aliases.called_places(site, self.summaries);
        let is_own = |called: &CalledPlace| self.may_reach(called, false);
        // Most calls have nothing to do with most instances, and mean the same to all of those.
        if !places.iter().any(is_own) {
            return self.aliases.call_beside(site, || self.called_with(site, &[]));
        }
        let own: Vec<&CalledPlace> = places.iter().filter(|called| is_own(called)).collect();
        let called = Arc::new(self.called_with(site, &own));
        self.called.borrow_mut().insert(site.result, Arc::clone(&called));
        called
    }

    /// Whether a place that a call has ways for may be the instance, or hold it unless it must be exact.
    pub(in crate::count) fn may_reach(&self, called: &CalledPlace, exact: bool) -> bool {
        called.law == self.law && self.is_among(called.roots(), exact) && !called.stops_before(self.instance)
    }

    /// The bodies that may run where the instance lies behind a trait: those of its types, or those that all types share.
    fn targets_behind(&self, site: &CallSite, types: &[Ty]) -> Vec<FunctionId> {
        let index = self.program.index;
        let owner = |target: &FunctionId| match index.function(*target).owner {
            Owner::Impl(id) => match index.impl_def(id).self_ty {
                Ty::Adt(id, _) => Some(id),
                _ => None,
            },
            _ => None,
        };
        if types.is_empty() || site.targets.len() < 2 {
            return site.targets.clone();
        }
        let mut found = BTreeSet::new();
        for ty in types {
            let is_own = |target: &&FunctionId| matches!(ty, Ty::Adt(id, _) if owner(target) == Some(*id));
            let own: Vec<FunctionId> = site.targets.iter().filter(is_own).copied().collect();
            match own.is_empty() {
                true => found.extend(site.targets.iter().filter(|target| owner(target).is_none())),
                false => found.extend(own),
            }
        }
        // The bodies are those of something else that gets it.
        if found.is_empty() { site.targets.clone() } else { found.into_iter().collect() }
    }

    /// The type of what a call has for its receiver where that is the instance or holds it, if only a trait decides which of several
    /// bodies runs: `let stage: &mut dyn Stage = &mut self.pump; stage.run(x)`.
    fn receiver_type(&self, site: &CallSite) -> Option<Ty> {
        let index = self.program.index;
        let has_receiver = |target: &FunctionId| index.function(*target).function.receiver.is_some();
        if site.targets.len() < 2 || !site.targets.iter().all(has_receiver) {
            return None;
        }
        // What a pointer or lock does by an impl of its own is not told from what it holds.
        let is_of_wrapper = |target: &FunctionId| match index.function(*target).owner {
            Owner::Impl(id) => !matches!(index.impl_def(id).self_ty, Ty::Adt(..) | Ty::Param(_)),
            _ => false,
        };
        if site.targets.iter().any(is_of_wrapper) {
            return None;
        }
        let receiver = site.args.get(site.law_of.unwrap_or(0))?.place.as_ref()?;
        let owners = self.aliases.shared_roots(receiver);
        let owners = owners.iter().filter(|root| root.overlaps(self.instance));
        let mut types = owners.map(|root| {
            let steps = self.instance.steps.get(..root.steps.len())?.into();
            place_ty(index, self.graph, &Place { base: self.instance.base, steps })
        });
        let first = types.next()??;
        let is_certain = matches!(first, Ty::Adt(..)) && types.all(|ty| ty.as_ref() == Some(&first));
        is_certain.then_some(first)
    }

    /// The filters among the types of whose methods one runs where a type parameter without a bound is the instance: `f(&mut self.one)`
    /// where `f` updates what a trait tells nothing of. What is no filter is owed nothing.
    fn filters_called(&self, site: &CallSite) -> Vec<Ty> {
        let index = self.program.index;
        let receiver = site.args.get(site.law_of.unwrap_or(0)).and_then(|arg| arg.place.as_ref());
        let is_instance = |place: &Place| self.aliases.shared_roots(place).iter().any(|root| root == self.instance);
        let is_open = || matches!(place_ty(index, self.graph, self.instance), Some(Ty::Param(_)));
        if site.targets.len() < 2 || !receiver.is_some_and(is_instance) || !is_open() {
            return Vec::new();
        }
        let owners = site.targets.iter().filter_map(|target| match index.function(*target).owner {
            Owner::Impl(id) => Some(index.impl_def(id).self_ty.clone()),
            _ => None,
        });
        owners.filter(|ty| matches!(ty, Ty::Adt(..)) && index.filter_spec(ty).is_some()).collect()
    }

    /// The same, where these of the places that it has to do with may be the instance or hold it.
    fn called_with(&self, site: &CallSite, own: &[&CalledPlace]) -> Called {
        let mut called = Called::default();
        let targets = match own {
            [] => site.targets.clone(),
            _ if self.behind.is_empty() => self.targets_behind(site, &self.filters_called(site)),
            _ => self.targets_behind(site, &self.behind),
        };
        let receiver = if own.is_empty() || !self.behind.is_empty() { None } else { self.receiver_type(site) };
        let of_receiver = receiver.map(|ty| self.targets_behind(site, &[ty]));
        // A function that many types share may do another thing with each.
        let is_shared = self.is_one_of_many && site.targets.len() == 1;
        for target in &targets {
            let is_of_others = of_receiver.as_ref().is_some_and(|own| !own.contains(target));
            let Some(summary) = self.summaries.get(*target) else {
                // A recursion that was not gone through yet adds nothing.
                if !self.summaries.is_open(*target) {
                    called.add(Effect { outcomes: Vec::new(), heads: 0, answers: Answers::new(), is_of_others });
                }
                continue;
            };
            for written in &summary.writes {
                let Some(place) = place_of(written, site) else { continue };
                let roots = self.aliases.shared_roots(&place);
                let is_certain = targets.len() == 1 && roots.len() == 1 && !place.stands_for_several();
                let given = summary.given_heads.get(written).cloned();
                let given = given.map(|given| GivenHeads { surely: given.surely && is_certain, ..given });
                for name in roots.iter().chain([&place]) {
                    called.note_write(name, given.as_ref());
                }
            }
            let outcomes = own.iter().filter(|called| called.target == *target);
            let outcomes = outcomes.map(|called| {
                let ways = called.outcomes(self.summaries);
                let is_same = ways.iter().all(|way| (way.count, way.reset) == (ways[0].count, ways[0].reset));
                let is_shared = is_shared || self.behind.is_empty() && called.is_mixed(self.summaries);
                let ways = match is_same {
                    false if is_shared => vec![Outcome::unknown(not_told())],
                    // Which of the elements a way is that of, is not told.
                    _ if called.is_uneven(self.summaries, self.instance) => {
                        vec![Outcome::unknown(Cause::Index(site.text.clone()))]
                    }
                    false if called.passes_over() || is_each_of_slice(&called.place) => {
                        vec![Outcome::unknown(Cause::Index(site.text.clone()))]
                    }
                    _ => ways.to_vec(),
                };
                (called.place.clone(), ways)
            });
            let (outcomes, answers) = (outcomes.collect(), summary.answers.clone());
            called.add(Effect { outcomes, heads: summary.heads, answers, is_of_others });
        }
        let outcomes = called.effects.iter().flat_map(|effect| &effect.outcomes).flat_map(|(_, outcomes)| outcomes);
        let answers = called.effects.iter().flat_map(|effect| &effect.answers);
        let answers = answers.flat_map(|answer| [&answer.assumed, &answer.left]);
        let assumed = outcomes.flat_map(|outcome| [&outcome.assumed, &outcome.left]).chain(answers);
        let assumed: BTreeSet<&Given> = assumed.flat_map(BTreeMap::keys).collect();
        let asked = assumed.into_iter().filter_map(|given| Some((given.clone(), self.asked_subject(given, site)?)));
        called.asked = asked.collect();
        called.borrows.extend(self.summaries.borrows(site).map(|(part, place)| (part.into(), place)));
        called
    }
}

/// Whether a place is each element of a slice of a collection.
fn is_each_of_slice(place: &Place) -> bool {
    place.steps.iter().any(|step| matches!(step.key(), Some(IndexKey::EachIn(section)) if section.is_exact))
}

/// Why it is not known what a function does that is one for many types.
pub(in crate::count) fn not_told() -> Cause {
    Cause::Limit("which type is behind the trait in the functions called is not known".to_owned())
}

/// Why it is not known what a function does that treats the variants differently between which a filter goes back and forth.
pub(in crate::count) fn which_variant() -> Cause {
    Cause::Limit("in which variant a called function finds it is not followed".to_owned())
}

impl Called {
    fn note_write(&mut self, place: &Place, given: Option<&GivenHeads>) {
        match (self.writes.get_mut(place), given) {
            (Some(Some(known)), Some(given)) => {
                known.heads.extend(given.heads.iter().cloned());
                known.surely |= given.surely;
            }
            (Some(known), _) => *known = None,
            (None, given) => {
                self.writes.insert(place.clone(), given.cloned());
            }
        }
    }

    fn add(&mut self, effect: Effect) {
        if !self.effects.contains(&effect) {
            self.effects.push(effect);
        }
    }
}
