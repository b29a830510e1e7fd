//! From judged methods to candidates: which methods of a type are one law, its halves, its resets and its time base.

use std::collections::{BTreeMap, BTreeSet};

use super::conduct::{Conduct, conduct};
use super::halves::groups;
use super::judge::{Judged, LEAST_WEIGHT, LIKELY_WEIGHT};
use super::together::Together;
use super::twins::sets_up;
use super::uses::{Calls, is_test};
use super::words::{Half, half, type_strength};
use super::{Candidates, Certainty, CycleCandidate, FilterCandidate, Nameless, Reason, Subject, Uses};
use crate::config::{InstancePlace, Multiplicity, Receiver as Taken, TimeBase};
use crate::flow::{Program, takes_moment, takes_step};
use crate::index::{EntryScope, FunctionId, ModuleId, Namespace, Owner, Ty, TypeId};
use crate::source::Span;
use crate::syntax::tree::{Receiver, TypeRef};

/// The search for candidates, and what it has found so far.
pub(super) struct Finder<'a> {
    pub(super) program: &'a Program<'a>,
    pub(super) scope: &'a EntryScope<'a>,
    /// Whether there is one package only, so that `crate` means it.
    pub(super) is_alone: bool,
    pub(super) calls: Calls,
    pub(super) together: Together,
    conducts: BTreeMap<FunctionId, Conduct>,
    pub(super) found: Vec<Found>,
}

/// A candidate, and what it stands for in the analysed code.
pub(super) struct Found {
    pub(super) name: String,
    pub(super) place: Span,
    /// `None` if no path means it alone.
    pub(super) path: Option<String>,
    pub(super) draft: Draft,
    /// The bodies of its laws.
    pub(super) laws: Vec<FunctionId>,
}

/// What an entry would say, and why.
pub(super) struct Draft {
    pub(super) subject: Subject,
    pub(super) law: Vec<(Vec<String>, Multiplicity)>,
    pub(super) instance: InstancePlace,
    pub(super) receiver: Taken,
    pub(super) resets: Vec<String>,
    pub(super) partial_resets: Vec<String>,
    pub(super) key: Option<u32>,
    pub(super) time_base: TimeBase,
    pub(super) reasons: Vec<Reason>,
    pub(super) uses: Uses,
    pub(super) weight: i32,
    pub(super) is_plain: bool,
}

impl Uses {
    pub(super) fn and(self, other: Self) -> Self {
        Self {
            calls: self.calls + other.calls,
            in_cycles: self.in_cycles + other.in_cycles,
            by_trait: self.by_trait + other.by_trait,
        }
    }
}

impl<'a> Finder<'a> {
    pub(super) fn new(program: &'a Program<'a>, scope: &'a EntryScope<'a>, is_alone: bool) -> Self {
        let conducts = program.index.function_ids().map(|id| (id, conduct(program, id))).collect();
        let (calls, together) = (Calls::read(program), Together::read(program));
        Self { program, scope, is_alone, calls, together, conducts, found: Vec::new() }
    }

    pub(super) fn conduct(&self, id: FunctionId) -> &Conduct {
        &self.conducts[&id]
    }

    /// Whether a module belongs to the packages that the entries are for.
    pub(super) fn is_in_scope(&self, module: ModuleId) -> bool {
        self.scope.crates.contains(&self.program.index.module(module).krate)
    }

    /// The types whose methods may be laws, with those methods.
    pub(super) fn types(&self) -> Vec<(TypeId, Vec<FunctionId>)> {
        let index = self.program.index;
        let mut methods: BTreeMap<TypeId, Vec<FunctionId>> = BTreeMap::new();
        for id in index.function_ids() {
            let def = index.function(id);
            let Owner::Impl(owner) = def.owner else { continue };
            let of = index.impl_def(owner);
            let Ty::Adt(ty, _) = &of.self_ty else { continue };
            let declared = index.type_def(*ty);
            let is_std = of.implements.as_ref().is_some_and(
                |name| matches!(name, crate::index::TraitName::External(path) if path.starts_with("std::")),
            ) || (of.implements.is_none() && of.trait_path.is_some());
            let bare = Ty::Adt(*ty, vec![Ty::Unknown; declared.generics.params.len()]);
            if !is_std
                && !is_test(index, def)
                && !index.module(declared.module).is_test
                && self.is_in_scope(declared.module)
                && index.law_spec(&bare).is_none()
                && def.function.body.is_some()
            {
                methods.entry(*ty).or_default().push(id);
            }
        }
        methods.into_iter().collect()
    }

    /// Finds types and traits. What runs the laws of others is judged again when those are known.
    pub(super) fn find_types(&mut self) {
        let types = self.types();
        self.find_argument_traits();
        let by_argument: BTreeSet<FunctionId> = self.laws().into_keys().collect();
        let mut laws = by_argument.clone();
        let mut judged: BTreeMap<FunctionId, Judged> = BTreeMap::new();
        for _ in 0..4 {
            judged = types
                .iter()
                .flat_map(|(ty, methods)| methods.iter().map(move |method| (*ty, *method)))
                .filter_map(|(ty, method)| Some((method, self.judge(ty, method, &laws)?)))
                .collect();
            // What is tuned by a method beside the law does not run the law of what it holds.
            let now: BTreeSet<FunctionId> = types
                .iter()
                .flat_map(|(_, methods)| self.one_law(&self.likely(methods, &judged)))
                .map(|judged| judged.id)
                .chain(by_argument.iter().copied())
                .collect();
            if now == laws {
                break;
            }
            laws = now;
        }
        let of_proposed_traits = self.find_traits(&judged);
        let mut covered = of_proposed_traits.clone();
        covered.extend(self.parts_of(&covered));
        covered.extend(self.parts_of(&self.items_of_iterators()));
        let mut seen: BTreeMap<Span, usize> = BTreeMap::new();
        let of_traits = self.types_of_several_traits();
        for (ty, methods) in types {
            let mut own = self.likely(&methods, &judged);
            own.retain(|judged| !covered.contains(&judged.id));
            let Some(mut found) = self.by_type(ty, &methods, &own) else { continue };
            // An entry for the type stands over that of its trait, and says what that one does as well.
            let is_other = |id: &&FunctionId| {
                let is_apart = |law: &FunctionId| !self.reaches(**id, *law) && !self.reaches(*law, **id);
                of_proposed_traits.contains(id) && found.laws.iter().all(is_apart)
            };
            let more: Vec<FunctionId> = methods.iter().filter(is_other).copied().collect();
            self.add_laws(&mut found, &more);
            // A file that belongs to several crates declares its types once in each.
            if let Some(at) = seen.get(&found.place) {
                let first = &mut self.found[*at];
                first.draft.uses = first.draft.uses.max(found.draft.uses);
                first.draft.weight = first.draft.weight.max(found.draft.weight);
                first.laws.extend(found.laws);
                continue;
            }
            seen.insert(found.place, self.found.len());
            self.found.push(found);
        }
        for found in of_traits {
            if let std::collections::btree_map::Entry::Vacant(place) = seen.entry(found.place) {
                place.insert(self.found.len());
                self.found.push(found);
            }
        }
    }

    /// The bodies of `Iterator::next`: as often as somebody likes they are asked for an item, and so is what they run.
    fn items_of_iterators(&self) -> BTreeSet<FunctionId> {
        let index = self.program.index;
        let iterators = index.function_ids().filter(|id| {
            let def = index.function(*id);
            let Owner::Impl(owner) = def.owner else { return false };
            let implemented = index.impl_def(owner).implements.as_ref();
            def.name == "next" && implemented.is_some_and(|name| index.trait_text(name) == "Iterator")
        });
        iterators.collect()
    }

    fn by_type(&self, ty: TypeId, methods: &[FunctionId], judged: &[&Judged]) -> Option<Found> {
        let index = self.program.index;
        let def = index.type_def(ty);
        let laws = self.one_law(judged);
        let best = laws.iter().max_by_key(|judged| judged.weight)?;
        let mut names: Vec<String> = laws.iter().map(|judged| judged.name.clone()).collect();
        names.sort();
        names.dedup();
        let ids: Vec<FunctionId> = laws.iter().map(|judged| judged.id).collect();
        // A sum that is filled here and drawn off there is no signal.
        let is_of_state = |id: &FunctionId| self.others_change_state(*id, &ids) || ids.contains(id);
        if methods.iter().any(|id| self.together.drained.contains(id) && is_of_state(id)) {
            return None;
        }
        let (resets, partial_resets) = self.resets(methods, &ids);
        let mut reasons = vec![best.reason()];
        let timed = laws.iter().find(|judged| takes_step(index, judged.id) || self.hands_step_on(judged));
        if let Some(timed) = timed {
            reasons.push(Reason::Timed(timed.name.clone()));
        }
        if type_strength(&def.name) == 2 {
            reasons.push(Reason::Named(def.name.clone()));
        }
        let is_state = |field: &String| ids.iter().any(|id| self.conduct(*id).written.contains(field));
        let tuned: Vec<String> = self.tuned_fields(ty).into_iter().filter(|field| !is_state(field)).collect();
        if !tuned.is_empty() {
            reasons.push(Reason::Tuned(tuned));
        }
        let time_base = if ids.iter().any(|id| takes_moment(index, *id)) {
            TimeBase::Inside
        } else if timed.is_some() {
            TimeBase::Passed
        } else if ids.iter().any(|id| self.conduct(*id).reads_clock) {
            TimeBase::Inside
        } else {
            TimeBase::Fixed
        };
        // One argument means the same in all methods of the law.
        let mut selectors = ids.iter().map(|id| self.selector(*id));
        let key = selectors.next().flatten().filter(|key| selectors.all(|other| other == Some(*key)));
        let mut law = self.independent(&laws).unwrap_or_else(|| groups(&names, &self.whole_steps(&ids)));
        // Both halves of a law, each seen at work in a cycle, say as much as a law of one method.
        let are_at_work = laws.iter().all(|judged| !judged.carried.is_empty() && judged.uses.in_cycles > 0);
        let is_one = names.len() == 1 || (names.len() == 2 && law.len() == 2 && are_at_work);
        let uses = laws.iter().fold(Uses::default(), |uses, judged| uses.and(judged.uses));
        if let [(group, _)] = law.as_mut_slice() {
            group.extend(self.twins(methods, &ids));
        }
        let is_shared = laws.iter().all(|judged| judged.is_shared);
        // Whoever advances the state by another method as well may owe no law.
        let named = |name: &String| law.iter().any(|(group, _)| group.contains(name));
        let advances = |id: &FunctionId| {
            !named(&index.function(*id).name)
                && self.others_change_state(*id, &ids)
                && self.calls.uses(*id).in_cycles > 0
        };
        let has_others = methods.iter().any(advances);
        Some(Found {
            name: def.name.clone(),
            place: def.span,
            path: self.path_to(def.module, &def.name, def.span, Namespace::Type),
            draft: Draft {
                subject: Subject::Type,
                law,
                instance: InstancePlace::Receiver,
                receiver: if is_shared { Taken::Shared } else { Taken::Exclusive },
                resets,
                partial_resets,
                key,
                time_base,
                reasons,
                uses,
                weight: best.weight,
                is_plain: best.is_plain && is_one && !is_shared && !has_others,
            },
            laws: ids,
        })
    }

    /// Whether a method that is fed advances the state of these laws otherwise than by them, and does not set it up or anew.
    fn others_change_state(&self, id: FunctionId, laws: &[FunctionId]) -> bool {
        let (def, conduct) = (self.program.index.function(id), self.conduct(id));
        let mut state = laws.iter().flat_map(|law| self.conduct(*law).carried());
        !laws.contains(&id)
            && def.function.receiver == Some(Receiver::Exclusive)
            && !def.function.params.is_empty()
            && !is_reset(&def.name)
            && !sets_up(&def.name)
            && laws.iter().all(|law| !self.reaches(id, *law) && !self.reaches(*law, id))
            && state.any(|field| conduct.carried().any(|own| own == field))
    }

    /// Adds other methods that run the law of a candidate.
    fn add_laws(&self, found: &mut Found, more: &[FunctionId]) {
        if more.is_empty() {
            return;
        }
        found.laws.extend(more);
        let mut names: Vec<String> =
            found.laws.iter().map(|id| self.program.index.function(*id).name.clone()).collect();
        names.sort();
        names.dedup();
        found.draft.law = groups(&names, &self.whole_steps(&found.laws));
        found.draft.is_plain = false;
    }

    /// Whether a law finds the time step in a parameter, and tells it the laws that it runs.
    fn hands_step_on(&self, judged: &Judged) -> bool {
        let is_told = |target: &FunctionId| takes_step(self.program.index, *target);
        let calls = self.conduct(judged.id).calls.iter().filter(|call| call.is_told_step);
        calls.filter(|call| judged.runs.contains(&call.field)).any(|call| call.targets.iter().any(is_told))
    }

    /// The methods of a type that may be its law, and those that compute the same by the same helpers under a name with the same
    /// first word: `update` beside `update_with_dt`.
    fn likely<'j>(&self, methods: &[FunctionId], judged: &'j BTreeMap<FunctionId, Judged>) -> Vec<&'j Judged> {
        let all = || methods.iter().filter_map(|method| judged.get(method));
        let is_likely = |one: &&Judged| one.weight >= LEAST_WEIGHT;
        let is_form_of = |one: &Judged, law: &Judged| {
            let helpers = |judged: &Judged| &self.conduct(judged.id).helpers;
            first(&one.name) == first(&law.name)
                && !law.carried.is_empty()
                && law.carried.iter().all(|field| one.carried.contains(field))
                && !helpers(one).is_disjoint(helpers(law))
        };
        all().filter(|one| is_likely(one) || all().filter(is_likely).any(|law| is_form_of(one, law))).collect()
    }

    /// Of the methods that look like laws, those that are the law: the best one, and what belongs to it.
    fn one_law<'j>(&self, judged: &[&'j Judged]) -> Vec<&'j Judged> {
        let is_inner = |one: &Judged| !self.calls.from_elsewhere.contains(&one.id);
        // What only other methods of the type call is a part of them, but for the law that a block runs for each of its samples.
        let is_part = |one: &Judged| {
            is_inner(one)
                && judged.iter().any(|other| {
                    other.id != one.id && self.reaches(other.id, one.id) && !self.is_block_of(other.id, one.id)
                })
        };
        let is_block = |one: &Judged| judged.iter().any(|other| is_inner(other) && self.is_block_of(one.id, other.id));
        // What each of its calls runs is the law, and it is read as the code that it is: no other form of the law.
        let is_around = |one: &Judged| {
            judged
                .iter()
                .any(|other| other.id != one.id && !is_inner(other) && self.conduct(one.id).always.contains(&other.id))
        };
        let is_whole = |one: &&Judged| !is_part(one) && !is_block(one) && !is_around(one);
        let whole: Vec<&Judged> = judged.iter().copied().filter(is_whole).collect();
        let Some(best) = whole
            .iter()
            .copied()
            .max_by_key(|judged| (judged.weight, judged.uses, std::cmp::Reverse(judged.name.clone())))
        else {
            return Vec::new();
        };
        let steps = self.whole_steps(&whole.iter().map(|judged| judged.id).collect::<Vec<_>>());
        let is_half = |name: &String| half(name).is_some() || steps.contains(name);
        let has_halves = whole.iter().any(|judged| half(&judged.name) == Some(Half::Predict)) && whole.len() > 1;
        whole
            .iter()
            .copied()
            .filter(|one| {
                one.id == best.id
                    || first(&one.name) == first(&best.name)
                    || self.reaches(one.id, best.id)
                    || self.reaches(best.id, one.id)
                    || (!has_halves && self.is_alternative(one, best))
                    || (has_halves && is_half(&one.name) && is_half(&best.name))
            })
            .collect()
    }

    /// Whether a method advances all that another one does, and no code calls both on one value: it is called instead.
    fn is_alternative(&self, one: &Judged, other: &Judged) -> bool {
        let state = |judged: &Judged| judged.carried.iter().chain(&judged.runs).cloned().collect::<BTreeSet<String>>();
        let (own, theirs) = (state(one), state(other));
        let is_called = |judged: &Judged| self.calls.from_elsewhere.contains(&judged.id);
        !own.is_empty()
            && (own.is_superset(&theirs) || theirs.is_superset(&own))
            && is_called(one)
            && is_called(other)
            && !self.together.are_beside(one.id, other.id)
    }

    /// Whether a method takes a block of samples, and runs another one for each of them.
    fn is_block_of(&self, block: FunctionId, sample: FunctionId) -> bool {
        let takes_block = |id: FunctionId| {
            let params = &self.program.index.function(id).function.params;
            params
                .iter()
                .any(|ty| matches!(ty, TypeRef::Reference { inner, .. } if matches!(**inner, TypeRef::Slice(_))))
        };
        self.conduct(block).rounds.contains(&sample) && takes_block(block) && !takes_block(sample)
    }

    /// The private methods that only laws run, and only of their own type: each is a part of such a law, and none itself.
    fn parts_of(&self, laws: &BTreeSet<FunctionId>) -> BTreeSet<FunctionId> {
        let mut parts = BTreeSet::new();
        let mut open: Vec<FunctionId> = laws.iter().copied().collect();
        while let Some(law) = open.pop() {
            for helper in &self.conduct(law).helpers {
                let is_offered =
                    self.program.index.function(*helper).is_pub_method || self.calls.from_elsewhere.contains(helper);
                if !is_offered && !laws.contains(helper) && parts.insert(*helper) {
                    open.push(*helper);
                }
            }
        }
        parts
    }

    /// Whether a method calls another one of its own type.
    pub(super) fn reaches(&self, from: FunctionId, to: FunctionId) -> bool {
        self.conduct(from).helpers.contains(&to)
    }

    /// The bodies of all laws, with the name of the filter.
    pub(super) fn laws(&self) -> BTreeMap<FunctionId, String> {
        self.found.iter().flat_map(|found| found.laws.iter().map(|id| (*id, found.name.clone()))).collect()
    }

    /// Puts what was found in order.
    pub(super) fn finish(self, cycles: Vec<CycleCandidate>) -> Candidates {
        let mut candidates = Candidates { cycles, known: self.known(), ..Candidates::default() };
        for found in self.found {
            let Found { name, place, path, draft, .. } = found;
            let is_outside = draft.reasons.iter().any(|reason| matches!(reason, Reason::Unread(..)));
            let Some(path) = path else {
                candidates.nameless.push(Nameless { name, place });
                continue;
            };
            let certainty = if draft.is_plain && draft.uses.in_cycles > 0 && draft.weight > LIKELY_WEIGHT {
                Certainty::Certain
            } else if draft.weight >= LIKELY_WEIGHT {
                Certainty::Likely
            } else {
                Certainty::Possible
            };
            candidates.filters.push(FilterCandidate {
                subject: draft.subject,
                path,
                place: (!is_outside).then_some(place),
                law: draft.law,
                instance: draft.instance,
                receiver: draft.receiver,
                resets: draft.resets,
                partial_resets: draft.partial_resets,
                key: draft.key,
                time_base: draft.time_base,
                reasons: draft.reasons,
                uses: draft.uses,
                certainty,
                weight: draft.weight,
            });
        }
        candidates.filters.sort_by(|left, right| {
            let key = |one: &FilterCandidate| {
                (one.certainty, std::cmp::Reverse((one.weight, one.uses.in_cycles, one.uses.calls)))
            };
            key(left).cmp(&key(right)).then_with(|| left.path.cmp(&right.path))
        });
        candidates.nameless.sort_by(|left, right| (&left.name, left.place).cmp(&(&right.name, right.place)));
        candidates
    }

    /// The names of types that are filters without an entry.
    fn known(&self) -> Vec<String> {
        let index = self.program.index;
        let names: BTreeSet<String> = (0u32..)
            .zip(&index.types)
            .filter(|(number, def)| {
                let args = vec![Ty::Unknown; def.generics.params.len()];
                self.is_in_scope(def.module)
                    && !index.module(def.module).is_test
                    && index.law_spec(&Ty::Adt(TypeId(*number), args)).is_some()
            })
            .map(|(_, def)| def.name.clone())
            .collect();
        names.into_iter().collect()
    }
}

pub(super) fn is_reset(name: &str) -> bool {
    matches!(first(name), "reset" | "clear" | "restart")
}

fn first(name: &str) -> &str {
    name.split('_').find(|word| !word.is_empty()).unwrap_or(name)
}
