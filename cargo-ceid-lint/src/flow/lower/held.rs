//! Variables that hold what a pattern took out of a value: as long as that is not changed, a condition on one of them is a condition on
//! what the others hold.

use std::collections::BTreeSet;

use super::Builder;
use super::same_states::same_at;
use super::subjects::{Pure, place_key};
use crate::flow::{Effect, NodeId, Place, SubjectId, Var};
use crate::index::Def;
use crate::syntax::tree::{PatId, PatKind};

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
                if !self.is_assigned(var) && value.whole.is_none() {
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

    /// Conditions on what several variables hold, or that are asked of the value itself too, ask for the value.
    pub(super) fn settle_held_values(&mut self) {
        let held = std::mem::take(&mut self.held);
        let reads = |this: &Self, id: usize, var: Var| this.graph.subjects[id].reads.contains(&Place::var(var));
        let asked: Vec<(SubjectId, &Held)> = held
            .iter()
            .flat_map(|one| (0u32..).map(SubjectId).take(self.graph.subjects.len()).map(move |id| (id, one)))
            .filter(|(id, one)| reads(self, id.0 as usize, one.var))
            .collect();
        for (id, one) in &asked {
            let is_held_again = asked.iter().any(|(_, other)| other.var != one.var && other.part.key == one.part.key);
            let is_named = self.graph.subjects.iter().any(|subject| subject.key.contains(&one.part.key));
            if is_held_again || is_named {
                self.ask_for_part(*id, one);
            }
        }
    }

    fn ask_for_part(&mut self, id: SubjectId, held: &Held) {
        let var = Place::var(held.var);
        let sets = |effect: &Effect| match effect {
            Effect::Set(set) | Effect::Write(set) => set.place.base_var() == Some(held.var),
            _ => false,
        };
        if self.graph.nodes.iter().filter(|node| sets(&node.effect)).count() != 1 {
            return;
        }
        let depends_on: Vec<Place> = held.part.reads.iter().chain([&var]).cloned().collect();
        let same = same_at(&self.graph, held.at, &depends_on);
        let own = self.graph.subjects[id.0 as usize].clone();
        let name = |key: &str| renamed(key, &place_key(&var), &held.part.key);
        let others = own.reads.iter().filter(|place| **place != var).cloned();
        let reads: BTreeSet<Place> = others.chain(held.part.reads.iter().cloned()).collect();
        let pure = Pure { key: name(&own.key), reads: reads.into_iter().collect(), whole: None };
        let Some(other) = self.ask_where(id, &same, pure) else { return };
        if let Some(bound) = self.bounds.remove(&id) {
            let reads = self.graph.subjects[other.0 as usize].reads.clone();
            self.bounds.entry(other).or_insert_with(|| bound.of(Pure { key: name(bound.key()), reads, whole: None }));
        }
    }
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
