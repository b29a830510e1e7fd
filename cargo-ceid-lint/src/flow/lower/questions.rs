//! Questions about one value that are told to be one question, so that their answers exclude or follow from one another.

use std::collections::BTreeMap;

use super::Builder;
use super::subjects::Pure;
use crate::flow::{Effect, Head, SubjectId};

/// The questions that have something in common, in order.
pub(super) fn grouped<K: Ord, T>(
    asked: BTreeMap<SubjectId, T>,
    common: impl Fn(&T) -> K,
) -> BTreeMap<K, Vec<(SubjectId, T)>> {
    let mut groups: BTreeMap<K, Vec<(SubjectId, T)>> = BTreeMap::new();
    for (id, question) in asked {
        groups.entry(common(&question)).or_default().push((id, question));
    }
    groups
}

impl Builder<'_> {
    /// Lets several questions ask which of these heads a value has; `own` tells the head of a question's own subject that one of them
    /// stands for, by its number.
    pub(super) fn ask_as_one<T>(
        &mut self,
        value: Pure,
        heads: &[Head],
        asked: &[(SubjectId, T)],
        own: impl Fn(&T, usize) -> Head,
    ) {
        let other = self.subject(value, Some(heads.to_vec()));
        for head in heads {
            self.head_bit(other, head);
        }
        for (id, question) in asked {
            let subject = &self.graph.subjects[id.0 as usize];
            let bits: Vec<(u32, u32)> =
                (0..heads.len()).map(|at| (subject.bit(&own(question, at)), 1_u32 << at)).collect();
            self.ask_instead(*id, other, &bits);
        }
    }

    /// Lets all that asks for a subject ask for another one: with each head of its own the heads of the other one for which it stands.
    pub(super) fn ask_instead(&mut self, id: SubjectId, other: SubjectId, heads: &[(u32, u32)]) {
        let translated =
            |mask: u32| -> u32 { heads.iter().filter(|(own, _)| mask & *own != 0).fold(0, |all, (_, bit)| all | bit) };
        for node in &mut self.graph.nodes {
            if let Effect::Branch(test) = &mut node.effect
                && test.subject == Some(id)
            {
                test.subject = Some(other);
                (test.holds, test.fails) = (translated(test.holds), translated(test.fails));
            }
        }
    }
}
