//! Subjects whose values come together, as by copies and comparisons: each tells the heads apart that the other one does.

use super::{Builder, subjects};
use crate::flow::{Effect, Head, NodeId, Place, SubjectId};
use crate::index::Ty;

impl Builder<'_> {
    /// Gives every variable whose value flows into a subject a subject of its own, with the same heads.
    pub(super) fn copy_subjects(&mut self) {
        self.drop_counts();
        let copies: Vec<(Place, Place)> = self
            .graph
            .node_ids()
            .filter_map(|id| match &self.graph.node(id).effect {
                Effect::Set(set) | Effect::Write(set) => Some((set.place.clone(), self.graph.copied(id)?)),
                _ => None,
            })
            .collect();
        for _ in 0..8 {
            let mut changed = false;
            for (to, from) in &copies {
                let Some(to) = self.subjects.get(&subjects::place_key(to)).copied() else { continue };
                let subject = self.graph.subjects[to.0 as usize].clone();
                let known = self.subjects.contains_key(&subjects::place_key(from));
                let source = self.subject(subjects::pure_place(from.clone()), subject.total.clone());
                changed |= !known;
                for head in &subject.heads {
                    self.head_bit(source, head);
                }
            }
            changed |= self.share_compared_heads();
            if !changed {
                break;
            }
        }
    }

    /// Forgets the copies of numbers that nothing asks which ones they are, not even where they are copied to in turn.
    fn drop_counts(&mut self) {
        let graph = &self.graph;
        let is_asked = |place: &Place| {
            let asked = self.subjects.get(&subjects::place_key(place));
            asked.is_some_and(|id| !graph.subjects[id.0 as usize].heads.is_empty())
        };
        let counts = graph.copies.iter().filter_map(|(id, from)| match &graph.node(*id).effect {
            Effect::Set(set) => {
                let var = set.place.base_var()?;
                let is_number = matches!(graph.var(var).ty, Ty::Int | Ty::Float | Ty::Char);
                (is_number && !is_asked(&set.place)).then(|| (*id, set.place.clone(), from.clone()))
            }
            _ => None,
        });
        let mut counts: Vec<(NodeId, Place, Place)> = counts.collect();
        let copied = graph.node_ids().filter_map(|id| match &graph.node(id).effect {
            Effect::Set(set) | Effect::Write(set) => Some((set.place.clone(), graph.copied(id)?)),
            _ => None,
        });
        let (mut copied, mut others): (Vec<_>, Vec<_>) = copied.partition(|(to, _)| is_asked(to));
        while let Some((_, from)) = copied.pop() {
            counts.retain(|(_, to, _)| *to != from);
            let (more, rest): (Vec<_>, Vec<_>) = others.into_iter().partition(|(to, _)| *to == from);
            copied.extend(more);
            others = rest;
        }
        for (id, ..) in counts {
            self.graph.copies.remove(&id);
        }
    }

    /// States that are asked whether they are equal are told apart by the same heads: `if now != last { … last = now; }`
    fn share_compared_heads(&mut self) -> bool {
        let compared: Vec<[Place; 2]> = self
            .graph
            .subjects
            .iter()
            .filter_map(|subject| subject.equals().map(|(left, right)| [left.clone(), right.clone()]))
            .collect();
        let mut changed = false;
        for places in compared {
            let known = places.each_ref().map(|place| self.subjects.get(&subjects::place_key(place)).copied());
            let subject_of = |id: &SubjectId| &self.graph.subjects[id.0 as usize];
            let heads: Vec<Head> = known
                .iter()
                .flatten()
                .flat_map(|id| &subject_of(id).heads)
                .filter(|head| *head != "+" && *head != "-")
                .cloned()
                .collect();
            let total = known.iter().flatten().find_map(|id| subject_of(id).total.clone());
            if heads.is_empty() {
                continue;
            }
            for place in places {
                let own = self.subject(subjects::pure_place(place), total.clone());
                let before = self.graph.subjects[own.0 as usize].heads.len();
                for head in &heads {
                    self.head_bit(own, head);
                }
                changed |= self.graph.subjects[own.0 as usize].heads.len() > before;
            }
        }
        changed
    }
}
