//! Comparisons of what calls give back: the callee may know which of several variants that is.

use super::conditions::Compared;
use super::subjects::Pure;
use super::{Builder, Value};
use crate::flow::{Head, Place};
use crate::syntax::tree::ExprId;

/// How many variants are told apart where only some of them are asked for: each may be a way of its own.
const MAX_VARIANTS: usize = 8;

impl Builder<'_> {
    /// The result of a call that is compared with a constant, as [`Builder::compared`] has it for what is pure.
    pub(super) fn compared_result(
        &self,
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
        (None, Vec::new(), false)
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
