//! Variables that hold what a pattern took out of a value: as long as that is not changed, a condition on one of them is a condition on
//! what the others hold.

use std::collections::{BTreeMap, BTreeSet};

use aho_corasick::AhoCorasick;
use rustc_hash::{FxHashMap, FxHashSet};

use super::Builder;
use super::same_states::{Questions, times_given, writable_loans};
use super::subjects::{Pure, place_key, pure_place};
use crate::flow::{Effect, NodeId, Place, Subject, SubjectId, Var};
use crate::index::{Def, Ty};
use crate::syntax::tree::{ExprId, ExprKind, PatId, PatKind};

/// A variable that a pattern binds to a part of a value.
#[derive(Clone, Debug)]
pub(super) struct Held {
    at: NodeId,
    var: Var,
    part: Pure,
}

impl Builder<'_> {
    /// Notes what the names of a pattern that has just been bound hold of a value.
    pub(super) fn note_held(&mut self, pat: PatId, value: &Pure) {
        let Some(at) = self.at else { return };
        match &self.body().pat(pat).kind {
            PatKind::Bind { sub: None, .. } => {
                let Some(local) = self.typed().pat_local.get(&pat).copied() else { return };
                let var = self.var_of(local);
                // Of a place of states, the variable is a copy.
                let is_number = matches!(self.graph.var(var).ty, Ty::Int | Ty::Float | Ty::Char);
                if !self.is_assigned(var) && (value.whole.is_none() || is_number) {
                    self.held.push(Held { at, var, part: value.clone() });
                }
            }
            PatKind::Reference(inner) => self.note_held(*inner, value),
            PatKind::TupleStruct(_, pats) => {
                let is_transparent = matches!(self.typed().pat_def.get(&pat), Some(Def::External(_)));
                for (number, inner) in pats.iter().enumerate() {
                    let step = if is_transparent { format!("{number}!") } else { number.to_string() };
                    self.note_held(*inner, &value.part(&step));
                }
            }
            PatKind::Tuple(pats) => {
                for (number, inner) in pats.iter().enumerate() {
                    self.note_held(*inner, &value.part(&number.to_string()));
                }
            }
            PatKind::Struct(_, fields) => {
                for (name, inner) in fields {
                    self.note_held(*inner, &value.part(name));
                }
            }
            _ => {}
        }
    }

    /// The same for a pattern of several values that are matched at once: `match (level, limit) { (low, _) if low < 5 => … }`.
    pub(super) fn note_held_parts(&mut self, pat: PatId, tuple: ExprId) -> bool {
        let (PatKind::Tuple(pats), ExprKind::Tuple(parts)) =
            (&self.body().pat(pat).kind, &self.body().expr(tuple).kind)
        else {
            return false;
        };
        if pats.len() != parts.len() || pats.iter().any(|pat| matches!(self.body().pat(*pat).kind, PatKind::Rest)) {
            return false;
        }
        for (pat, part) in pats.iter().zip(parts) {
            if let Some(part) = self.pure_option(*part) {
                self.note_held(*pat, &part);
            }
        }
        true
    }

    /// Conditions on what several variables hold, or that are asked of the value itself too, ask for the value.
    pub(super) fn settle_held_values(&mut self, questions: &mut Questions) {
        self.settle_held_numbers(questions);
        let held = std::mem::take(&mut self.held);
        let given = times_given(&self.graph);
        let mut reading: FxHashMap<Var, Vec<SubjectId>> = FxHashMap::default();
        for (number, subject) in (0u32..).zip(&self.graph.subjects) {
            for place in subject.reads.iter().filter(|place| place.steps.is_empty()) {
                if let Some(var) = place.base_var() {
                    reading.entry(var).or_default().push(SubjectId(number));
                }
            }
        }
        let is_plain = |one: &&Held| {
            let lent = |place: &Place| writable_loans(&self.graph).iter().any(|other| other.overlaps(place));
            reading.contains_key(&one.var)
                && one.part.whole.as_ref().is_none_or(|place| place.base_var().is_some() && !lent(place))
        };
        let asked: Vec<&Held> = held.iter().filter(is_plain).collect();
        let asked_again = asked_again(&asked, &self.graph.subjects);
        for one in asked {
            if given.get(&one.var) != Some(&1) || !asked_again.contains(one.part.key.as_str()) {
                continue;
            }
            for id in &reading[&one.var] {
                self.ask_for_part(questions, *id, one);
            }
        }
    }

    /// Conditions on a variable that holds a number ask for what it was given, where that is asked for too: `x if x < 5` and `k < 5`.
    fn settle_held_numbers(&mut self, questions: &mut Questions) {
        let given = times_given(&self.graph);
        let lent = writable_loans(&self.graph);
        let is_lent = |place: &Place| lent.iter().any(|other| other.overlaps(place));
        let mut held: Vec<Held> = Vec::new();
        for at in self.graph.node_ids() {
            let Effect::Set(set) = &self.graph.node(at).effect else { continue };
            let Some(var) = set.place.base_var().filter(|var| set.place.steps.is_empty() && given.get(var) == Some(&1))
            else {
                continue;
            };
            if matches!(self.graph.var(var).ty, Ty::Int | Ty::Float | Ty::Char)
                && let Some(from) = self.graph.copied(at).filter(|from| from.base_var().is_some())
                && !is_lent(&from)
                && !is_lent(&set.place)
            {
                held.push(Held { at, var, part: pure_place(from) });
            }
        }
        // What holds what another one holds comes before that.
        while let Some(one) = held.pop() {
            let reads = |subject: &Subject, place: &Place| subject.reads.contains(place);
            let (own, from) = (Place::var(one.var), one.part.reads[0].clone());
            let is_held_again = held.iter().any(|other| other.part.key == one.part.key);
            let is_named = from.base_var().is_some_and(|var| !self.graph.var(var).name.is_empty());
            let is_asked = is_named && self.graph.subjects.iter().any(|subject| reads(subject, &from));
            if !is_held_again && !is_asked {
                continue;
            }
            let asking: Vec<SubjectId> = (0u32..)
                .zip(&self.graph.subjects)
                .filter(|(_, subject)| reads(subject, &own))
                .map(|(number, _)| SubjectId(number))
                .collect();
            for id in asking {
                self.ask_for_part(questions, id, &one);
            }
        }
    }

    fn ask_for_part(&mut self, questions: &mut Questions, id: SubjectId, held: &Held) {
        let var = Place::var(held.var);
        let depends_on: Vec<Place> = held.part.reads.iter().chain([&var]).cloned().collect();
        let own = self.graph.subjects[id.0 as usize].clone();
        let name = |key: &str| renamed(key, &place_key(&var), &held.part.key);
        let others = own.reads.iter().filter(|place| **place != var).cloned();
        let reads: BTreeSet<Place> = others.chain(held.part.reads.iter().cloned()).collect();
        let whole = held.part.whole.clone().filter(|_| own.whole.as_ref() == Some(&var));
        let pure = Pure { key: name(&own.key), reads: reads.into_iter().collect(), whole, filled: None };
        let Some(other) = self.ask_where(questions, id, held.at, &depends_on, pure) else { return };
        let reads = self.graph.subjects[other.0 as usize].reads.clone();
        if let Some(bound) = self.bounds.remove(&id) {
            let whole = held.part.whole.clone().filter(|_| bound.is_about(&var));
            let value = Pure { key: name(bound.key()), reads: reads.clone(), whole, filled: None };
            self.bounds.entry(other).or_insert_with(|| bound.of(value));
        }
        if let Some(order) = self.orders.remove(&id) {
            self.orders.entry(other).or_insert_with(|| order.renamed(name, reads));
        }
    }
}

/// The keys of those parts that several variables hold, or that a subject asks for by itself.
fn asked_again<'a>(held: &[&'a Held], subjects: &[Subject]) -> FxHashSet<&'a str> {
    let mut holders: BTreeMap<&str, BTreeSet<Var>> = BTreeMap::new();
    for one in held {
        holders.entry(&one.part.key).or_default().insert(one.var);
    }
    // Most functions have none, and what searches for nothing takes long to be made too.
    if holders.is_empty() {
        return FxHashSet::default();
    }
    let keys: Vec<&str> = holders.keys().copied().collect();
    let mut found: FxHashSet<&str> = holders.iter().filter(|(_, vars)| vars.len() > 1).map(|(key, _)| *key).collect();
    // One pass over each subject finds all the parts that it names.
    if let Ok(named) = AhoCorasick::new(&keys) {
        for subject in subjects {
            found.extend(named.find_overlapping_iter(&subject.key).map(|part| keys[part.pattern().as_usize()]));
        }
        for key in &keys {
            let parts = named.find_overlapping_iter(key).map(|part| keys[part.pattern().as_usize()]);
            found.extend(parts.filter(|part| part != key));
        }
    }
    found
}

/// A key with another name for a variable.
fn renamed(key: &str, var: &str, part: &str) -> String {
    let mut found = String::new();
    let mut rest = key;
    while let Some(at) = rest.find(var) {
        let (before, behind) = (&rest[..at], &rest[at + var.len()..]);
        let is_word = |letter: char| letter.is_ascii_alphanumeric() || letter == '_';
        let is_whole = !before.ends_with(is_word) && !behind.starts_with(is_word);
        found.push_str(before);
        found.push_str(if is_whole { part } else { var });
        rest = behind;
    }
    found + rest
}
