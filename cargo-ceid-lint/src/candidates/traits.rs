//! Traits whose types look like filters: one entry for all of them.

use std::collections::{BTreeMap, BTreeSet};

use super::judge::{Judged, LEAST_WEIGHT};
use super::laws::{Draft, Finder, Found};
use super::uses::owner_type;
use super::words::{law_strength, type_strength};
use super::{Reason, Subject, Uses};
use crate::config::{InstancePlace, Multiplicity, Receiver as Taken, TimeBase};
use crate::flow::{takes_moment, takes_step};
use crate::index::{FunctionId, Namespace, Owner, TraitId, TraitName, Ty, TypeDef, TypeId};
use crate::syntax::tree::{Receiver, TypeRef};

/// From so many types on that look like filters, one entry for their trait says more than one for each.
const MANY_TYPES: usize = 8;

impl Finder<'_> {
    /// Proposes a trait if enough of its types look like filters, by the weights of their methods.
    pub(super) fn find_traits(&mut self, judged: &BTreeMap<FunctionId, Judged>) -> BTreeSet<FunctionId> {
        let index = self.program.index;
        let mut covered = BTreeSet::new();
        for (number, def) in (0u32..).zip(&index.traits) {
            let id = TraitId(number);
            let name = TraitName::Local(id);
            if !self.is_in_scope(def.module) || index.is_filter_trait(&name) || index.module(def.module).is_test {
                continue;
            }
            let strength = type_strength(&def.name);
            if strength < 0 {
                continue;
            }
            let mut laws: Vec<(String, Vec<&Judged>, usize)> = Vec::new();
            for (method, declared) in &def.methods {
                if index.function(*declared).function.receiver != Some(Receiver::Exclusive) || law_strength(method) < 0
                {
                    continue;
                }
                let bodies = self.bodies(id, method);
                let good: Vec<&Judged> = bodies
                    .iter()
                    .filter_map(|body| judged.get(body))
                    // What many types have in common needs less to speak for each of them.
                    .filter(|judged| {
                        judged.weight + 2 * i32::from(strength == 2 || law_strength(method) == 2) >= LEAST_WEIGHT
                    })
                    .collect();
                let is_said = strength == 2 && law_strength(method) == 2 && takes_step(index, *declared);
                // A whole library of blocks has some that are gains, sums and switches.
                let least = if strength > 0 || good.len() >= MANY_TYPES { 4 } else { 2 };
                let is_enough = is_said || good.len() * least >= bodies.len();
                if (!good.is_empty() || (is_said && !bodies.is_empty()))
                    && is_enough
                    && !self.are_laws_by_type(method, &bodies)
                {
                    laws.push((method.clone(), good, bodies.len()));
                }
            }
            if let Some(draft) = self.by_receiver(id, strength, &mut laws) {
                for (method, ..) in &laws {
                    covered.extend(self.bodies(id, method));
                    covered.extend(def.methods.get(method));
                }
                self.found.push(draft);
            }
        }
        covered
    }

    /// The types that have laws by several of the proposed traits which say different things: an entry for the type stands over
    /// those of its traits, without which nobody could see which of them holds.
    pub(super) fn types_of_several_traits(&self) -> Vec<Found> {
        let index = self.program.index;
        let of_trait = |found: &&Found| found.draft.subject == Subject::Trait;
        let traits: Vec<(TraitName, &Found)> = (0u32..)
            .zip(&index.traits)
            .flat_map(|(number, def)| {
                let proposed = self.found.iter().filter(of_trait).filter(|found| found.place == def.span);
                proposed.map(move |found| (TraitName::Local(TraitId(number)), found))
            })
            .collect();
        let of_type = |(number, def): (u32, &TypeDef)| {
            let bare = Ty::Adt(TypeId(number), vec![Ty::Unknown; def.generics.params.len()]);
            let has = |(name, _): &&(TraitName, &Found)| index.implements(&bare, name);
            let mut own: Vec<&Found> = traits.iter().filter(has).map(|(_, found)| *found).collect();
            own.sort_by_key(|found| (std::cmp::Reverse(found.draft.weight), found.place));
            let (first, others) = own.split_first()?;
            others.iter().any(|other| !says_the_same(&first.draft, &other.draft)).then(|| self.of_several(def, &own))
        };
        (0u32..).zip(&index.types).filter_map(of_type).collect()
    }

    /// The entry for a type with several traits that look like filters, the surest of them first.
    fn of_several(&self, def: &TypeDef, own: &[&Found]) -> Found {
        let first = &own[0].draft;
        let alike = || own.iter().filter(|found| found.draft.instance == first.instance);
        let mut names: Vec<String> =
            alike().flat_map(|found| &found.draft.law).flat_map(|(methods, _)| methods).cloned().collect();
        names.sort();
        names.dedup();
        let ids: Vec<FunctionId> = alike().flat_map(|found| found.laws.iter().copied()).collect();
        let whole = self.whole_steps(&ids);
        let bases = || alike().map(|found| found.draft.time_base);
        let time_base =
            bases().find(|base| *base == TimeBase::Inside).or_else(|| bases().find(|base| *base == TimeBase::Passed));
        let mut resets: Vec<String> = alike().flat_map(|found| &found.draft.resets).cloned().collect();
        resets.sort();
        resets.dedup();
        let says = |reason: &&Reason| !matches!(reason, Reason::Implemented(_));
        Found {
            name: def.name.clone(),
            place: def.span,
            path: self.path_to(def.module, &def.name, def.span, Namespace::Type),
            draft: Draft {
                subject: Subject::Type,
                law: super::halves::groups(&names, &whole),
                instance: first.instance,
                receiver: first.receiver,
                resets,
                partial_resets: Vec::new(),
                key: None,
                time_base: time_base.unwrap_or(TimeBase::Fixed),
                reasons: first.reasons.iter().filter(says).cloned().collect(),
                uses: alike().fold(Uses::default(), |uses, found| uses.and(found.draft.uses)),
                weight: first.weight,
                is_plain: false,
            },
            laws: Vec::new(),
        }
    }

    /// Proposes traits whose methods get the state as an argument.
    pub(super) fn find_argument_traits(&mut self) {
        let index = self.program.index;
        for (number, def) in (0u32..).zip(&index.traits) {
            let id = TraitId(number);
            if self.is_in_scope(def.module)
                && !index.is_filter_trait(&TraitName::Local(id))
                && !index.module(def.module).is_test
            {
                self.found.extend(self.by_argument(id));
            }
        }
    }

    /// Whether all types with such bodies also have the law without the trait: an entry for each then says more.
    fn are_laws_by_type(&self, method: &str, bodies: &[FunctionId]) -> bool {
        let index = self.program.index;
        bodies.iter().all(|body| {
            let Owner::Impl(owner) = index.function(*body).owner else { return false };
            let methods = index.methods(&index.impl_def(owner).self_ty, method);
            methods.iter().any(|owner| matches!(owner, crate::index::MethodOwner::Inherent(_)))
        })
    }

    /// The bodies of a trait's method, one for each place in the source.
    fn bodies(&self, id: TraitId, method: &str) -> Vec<FunctionId> {
        let index = self.program.index;
        let mut seen = BTreeSet::new();
        let mut bodies = index.implementations(&TraitName::Local(id), method);
        bodies.retain(|body| {
            let def = index.function(*body);
            !super::uses::is_test(index, def) && seen.insert(def.function.keyword) && !self.hands_on(*body)
        });
        bodies
    }

    /// Whether a body is that of a wrapper: `impl Filter for Box<F>`, `impl Filter for &mut F`, or for every `F`.
    fn hands_on(&self, id: FunctionId) -> bool {
        let index = self.program.index;
        match index.function(id).owner {
            Owner::Impl(owner) => !matches!(index.impl_def(owner).self_ty, Ty::Adt(..)),
            _ => false,
        }
    }

    fn by_receiver(&self, id: TraitId, strength: i32, laws: &mut Vec<(String, Vec<&Judged>, usize)>) -> Option<Found> {
        let index = self.program.index;
        let def = index.trait_def(id);
        laws.sort_by_key(|(method, good, _)| {
            (std::cmp::Reverse(good.iter().map(|judged| judged.weight).max()), method.clone())
        });
        let (method, good, bodies) = laws.first()?;
        let best = good.iter().map(|judged| judged.weight).max().unwrap_or(LEAST_WEIGHT - 2);
        let methods: Vec<String> = laws.iter().map(|(method, ..)| method.clone()).collect();
        let declared = def.methods.get(method)?;
        let mut reasons = vec![Reason::Implemented(good.len().max(1))];
        reasons.extend(good.iter().max_by_key(|judged| judged.weight).map(|judged| judged.reason()));
        let is_timed = takes_step(index, *declared) || good.iter().any(|judged| takes_step(index, judged.id));
        if is_timed {
            reasons.push(Reason::Timed(method.clone()));
        }
        let told = [*declared].into_iter().chain(good.iter().map(|judged| judged.id));
        let time_base = match told.into_iter().any(|law| takes_moment(index, law)) {
            true => TimeBase::Inside,
            false if is_timed => TimeBase::Passed,
            false => TimeBase::Fixed,
        };
        let mut uses = Uses::default();
        for (method, ..) in laws.iter() {
            uses = uses.and(def.methods.get(method).map(|id| self.calls.uses(*id)).unwrap_or_default());
        }
        let (resets, partial_resets) = self.resets_of_trait(id, laws);
        let place = def.span;
        let path = self.path_to(def.module, &def.name, place, Namespace::Type);
        let weight = best + strength.max(0) + i32::from(good.len() > 2) - i32::from(good.len() * 2 < *bodies);
        Some(Found {
            name: def.name.clone(),
            place,
            path,
            draft: Draft {
                subject: Subject::Trait,
                law: super::halves::groups(&methods, &[]),
                instance: InstancePlace::Receiver,
                receiver: Taken::Exclusive,
                resets,
                partial_resets,
                key: None,
                time_base,
                reasons,
                uses,
                weight,
                is_plain: false,
            },
            laws: laws.iter().flat_map(|(_, good, _)| good.iter().map(|judged| judged.id)).collect(),
        })
    }

    /// Whether the `reset` of a trait sets the whole state of each type of which that was seen, or leaves a part of one.
    fn resets_of_trait(&self, id: TraitId, laws: &[(String, Vec<&Judged>, usize)]) -> (Vec<String>, Vec<String>) {
        let index = self.program.index;
        let Some(name) = index.trait_def(id).methods.keys().find(|name| *name == "reset") else {
            return (Vec::new(), Vec::new());
        };
        let of = |id: FunctionId| owner_type(index, id);
        let is_partial = self.bodies(id, name).into_iter().any(|reset| {
            let own = laws.iter().flat_map(|(_, good, _)| good).map(|judged| judged.id);
            let own: Vec<FunctionId> = own.filter(|law| of(*law) == of(reset)).collect();
            !own.is_empty() && self.clears(reset, &own, 0) != Some(true)
        });
        let name = vec![name.clone()];
        if is_partial { (Vec::new(), name) } else { (name, Vec::new()) }
    }

    /// A trait whose method gets the state as its first argument: `fn process(&self, state: &mut S, x: X) -> Y`.
    fn by_argument(&self, id: TraitId) -> Option<Found> {
        let index = self.program.index;
        let def = index.trait_def(id);
        let is_law = |(method, declared): &(&String, &FunctionId)| {
            let function = &index.function(**declared).function;
            let is_parameter = |ty: &TypeRef| {
                matches!(ty, TypeRef::Path(path) if path.ident().is_some_and(|name| {
                    def.generics.params.iter().any(|param| param.name == name && !param.is_const)
                }))
            };
            let first = function.params.first();
            function.receiver == Some(Receiver::Shared)
                && law_strength(method) == 2
                && function.params.len() > 1
                && matches!(first, Some(TypeRef::Reference { mutable: true, inner }) if is_parameter(inner))
        };
        let laws: Vec<(String, FunctionId)> =
            def.methods.iter().filter(is_law).map(|(method, id)| (method.clone(), *id)).collect();
        let bodies: Vec<FunctionId> = laws.iter().flat_map(|(method, _)| self.bodies(id, method)).collect();
        if bodies.is_empty() {
            return None;
        }
        let place = def.span;
        let methods: Vec<String> = laws.iter().map(|(method, _)| method.clone()).collect();
        let uses = laws.iter().fold(Uses::default(), |uses, (_, id)| uses.and(self.calls.uses(*id)));
        Some(Found {
            name: def.name.clone(),
            place,
            path: self.path_to(def.module, &def.name, place, Namespace::Type),
            draft: Draft {
                subject: Subject::Trait,
                law: vec![(methods, Multiplicity::Once)],
                instance: InstancePlace::Argument(0),
                receiver: Taken::Exclusive,
                resets: Vec::new(),
                partial_resets: Vec::new(),
                key: None,
                time_base: TimeBase::Fixed,
                reasons: vec![Reason::Implemented(bodies.len())],
                uses,
                weight: LEAST_WEIGHT + i32::from(bodies.len() > 2) * 2,
                is_plain: false,
            },
            laws: bodies,
        })
    }
}

/// Whether entries for two traits would say the same of a type that has both.
fn says_the_same(one: &Draft, other: &Draft) -> bool {
    let told = |draft: &Draft| (draft.law.clone(), draft.instance, draft.receiver, draft.time_base);
    told(one) == told(other) && one.resets == other.resets && one.partial_resets == other.partial_resets
}
