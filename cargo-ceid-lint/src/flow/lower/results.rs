//! Comparisons of what calls give back: the callee may know which of several variants that is.

use super::conditions::Compared;
use super::subjects::Pure;
use super::{Builder, Value};
use crate::flow::{About, Effect, Head, Node, NodeId, Place, Var};
use crate::index::Ty;
use crate::source::Span;
use crate::syntax::tree::ExprId;

/// How many variants are told apart where only some of them are asked for: each may be a way of its own.
const MAX_VARIANTS: usize = 8;

impl Builder<'_> {
    /// The result of a call that is compared with a constant, as [`Builder::compared`] has it for what is pure.
    pub(super) fn compared_result(
        &mut self,
        op: &str,
        sides: &[(ExprId, Value); 2],
    ) -> (Option<Compared>, Vec<Head>, bool) {
        let [left, right] = sides;
        for ((subject, value), (constant, _)) in [(left, right), (right, left)] {
            if matches!(op, "==" | "!=")
                && self.constants().is_exact(*constant)
                && let (Some(head), Some(var)) = (self.constant_head(*constant), value.same_as)
            {
                return (Some((self.pure_var(var), self.total_heads(self.ty(*subject)))), vec![head], op == "!=");
            }
        }
        for ((subject, value), (other, _)) in [(left, right), (right, left)] {
            if let Some(asked) = value.same_as.and_then(|var| self.compared_state(op, *subject, var, *other)) {
                return (Some(asked), vec!["true".to_owned()], op == "!=");
            }
        }
        (None, Vec::new(), false)
    }

    /// `attempt() == Err(Fault::Stale)`: what is equal to that has failed. Goes on where it has, and answers where it has not.
    pub(super) fn other_outcome(
        &mut self,
        op: &str,
        sides: &[(ExprId, Value); 2],
        span: Span,
        text: &str,
        about: &About,
    ) -> Option<NodeId> {
        let [left, right] = sides;
        let asked = [(left, right), (right, left)].into_iter().find_map(|((subject, value), (constant, _))| {
            let head = self.constant_head(*constant).filter(|head| matches!(head.as_str(), "+" | "-"))?;
            let is_result = matches!(self.ty(*subject), Ty::External(path, _) if path == "std::result::Result");
            (is_result && value.same_as.is_some()).then_some((value, head))
        });
        let is_attempt = |node: &Node| matches!(&node.effect, Effect::Update(update) if update.attempt.is_some());
        let is_asked = matches!(op, "==" | "!=") && self.graph.nodes.iter().any(is_attempt);
        let (value, head) = asked.filter(|_| is_asked)?;
        let other = if head == "-" { "+" } else { "-" };
        let (alike, differs) = self.branch_on_head(value, &head, other, span, text.to_owned(), about.clone());
        self.resume(alike);
        Some(differs)
    }

    /// A state that a call gave, compared with another one: `mem::replace(&mut self.mode, next) != next`.
    fn compared_state(&mut self, op: &str, id: ExprId, var: Var, other: ExprId) -> Option<Compared> {
        if !matches!(op, "==" | "!=") || !self.is_state(self.ty(id)) || self.pure(id).is_some() {
            return None;
        }
        let sides = [self.pure_var(var), self.pure(other).filter(|other| other.whole.is_some())?];
        for side in sides.clone() {
            self.state_subject(side, id);
        }
        let [left, right] = sides;
        let key = format!("({} == {})", left.key, right.key);
        let reads = [left.reads, right.reads].concat();
        Some((Pure { key, reads, ..Pure::default() }, Some(vec!["true".to_owned(), "false".to_owned()])))
    }

    /// All variants that the result of a call may be: of those that no condition asks for, the callee may give one.
    pub(super) fn told_variants(&self, pure: &Pure, total: Option<&[Head]>) -> Vec<Head> {
        let whole = pure.whole.as_ref().filter(|place| place.steps.is_empty()).and_then(Place::base_var);
        let is_result = whole.is_some_and(|var| {
            let computed = self.graph.computed.get(&var);
            self.graph.var(var).param.is_none() && computed.is_none_or(|computed| !computed.calls.is_empty())
        });
        let all = total.filter(|all| is_result && all.len() <= MAX_VARIANTS);
        all.map(<[Head]>::to_vec).unwrap_or_default()
    }
}
