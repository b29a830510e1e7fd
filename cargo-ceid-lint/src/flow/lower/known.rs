//! Parameters that are a constant where their function is read: `self.enter(Mode::Run)` takes the ways for `Mode::Run`, and no others.

use super::Builder;
use super::same_states::{times_given, writable_loans};
use crate::flow::{Effect, Head, Place, Var};
use crate::index::Def;
use crate::syntax::tree::{ExprId, ExprKind, Literal};

impl Builder<'_> {
    /// The state that an expression spells. What is spelled by the name of a constant is a setting, which another build may have
    /// otherwise.
    pub(super) fn written_state(&self, id: ExprId) -> Option<Head> {
        let is_variant = matches!(self.typed().expr_def.get(&id), Some(Def::Variant(..)));
        let is_truth = matches!(self.body().expr(id).kind, ExprKind::Literal(Literal::Bool(_)));
        if is_variant || is_truth { self.constant_head(id) } else { None }
    }

    /// Leaves of each choice that such a parameter decides the way that is taken, and says what is given on.
    pub(super) fn settle_known(&mut self) {
        if self.known.is_empty() {
            return;
        }
        let given = times_given(&self.graph);
        let lent: Vec<Var> = writable_loans(&self.graph).into_iter().filter_map(Place::base_var).collect();
        let is_kept = |var: &Var| given.get(var) == Some(&1) && !lent.contains(var);
        let mut known = std::mem::take(&mut self.known);
        known.retain(|var, _| is_kept(var));
        for at in self.graph.node_ids().collect::<Vec<_>>() {
            let from = self.graph.copied(at).filter(|from| from.steps.is_empty()).and_then(|from| from.base_var());
            let next = self.graph.node(at).next.clone();
            match &mut self.graph.nodes[at.0 as usize].effect {
                Effect::Set(set) | Effect::Write(set) if set.head.is_none() => {
                    let Some(head) = set.same_as.or(from).and_then(|var| known.get(&var)).cloned() else { continue };
                    set.head = Some(head.clone());
                    // What is handed on to another function is known there.
                    if let Some(var) = set.place.base_var().filter(|var| set.place.steps.is_empty() && is_kept(var)) {
                        known.insert(var, head);
                    }
                }
                Effect::Branch(test) => {
                    let Some(id) = test.subject else { continue };
                    let subject = &self.graph.subjects[id.0 as usize];
                    let asked = subject.whole.as_ref().filter(|whole| whole.steps.is_empty());
                    let Some(head) = asked.and_then(Place::base_var).and_then(|var| known.get(&var)) else { continue };
                    let bit = subject.bit(head);
                    let taken = match (test.holds & bit != 0, test.fails & bit != 0) {
                        (true, false) => next.first(),
                        (false, true) => next.get(1),
                        _ => None,
                    };
                    if let Some(taken) = taken.copied() {
                        let node = &mut self.graph.nodes[at.0 as usize];
                        (node.effect, node.next) = (Effect::Nothing, vec![taken]);
                    }
                }
                _ => {}
            }
        }
    }
}
