//! Operators of the analysed code: `filter + 1.0` runs what its impl says.

use super::{Builder, Value};
use crate::index::{FunctionId, TraitName, Ty};
use crate::syntax::tree::ExprId;
use crate::types::Resolved;

impl Builder<'_> {
    /// Runs the impls that an operator on the first operand may mean; `None` if there is none, or one gives a filter back.
    pub(super) fn operator_call(
        &mut self,
        id: ExprId,
        op: &str,
        operands: &[ExprId],
        values: &[Value],
    ) -> Option<Value> {
        let (of_trait, method) = operator(op, operands.len())?;
        let written = self.ty(*operands.first()?).clone();
        let self_ty = written.peel().clone();
        let index = self.program.index;
        // What the second operand is lent to is no number.
        let lent = operands.get(1).map(|operand| self.ty(*operand).clone());
        let lent = lent.filter(|ty| matches!(ty, Ty::Ref(true, inner) if index.holds_filter(inner.peel())));
        if self.at.is_none() || lent.is_none() && !index.holds_filter(&self_ty) {
            return None;
        }
        let is_operator = |name: &TraitName| matches!(name, TraitName::External(path) if path.ends_with(of_trait));
        let of_reference = Some(&written).filter(|ty| matches!(ty, Ty::Ref(..)));
        let own = of_reference.into_iter().chain([&self_ty]).flat_map(|ty| index.methods(ty, method));
        let own = own.chain(index.extension_methods(&self_ty, method));
        let own = own.filter(|owner| owner.of_trait().is_some_and(is_operator));
        let mut targets: Vec<FunctionId> = own.filter_map(|owner| owner.function()).collect();
        if let Some(lent) = &lent {
            let takes = |target: &FunctionId| {
                let param = index.function(*target).function.params.first();
                param.is_some_and(|param| index.lower(param, &index.scope_of(*target)).admits(lent))
            };
            targets.retain(takes);
            if targets.is_empty() {
                return Some(self.unknown_call(id, self.text(id), operands, values));
            }
        }
        let gives_filter = |target: &FunctionId| {
            let output = index.lower(&index.function(*target).function.output, &index.scope_of(*target));
            self.may_hold_filter(&output)
        };
        if targets.is_empty() || targets.iter().any(gives_filter) {
            return None;
        }
        let resolved = Resolved { targets, owner: None, law: None, self_ty, has_receiver: true, derefs: Vec::new() };
        Some(self.resolved_call(id, &resolved, operands, values))
    }
}

/// The trait of an operator with so many operands, and its method.
fn operator(op: &str, operands: usize) -> Option<(&'static str, &'static str)> {
    Some(match (op, operands) {
        ("-", 1) => ("ops::Neg", "neg"),
        ("!", 1) => ("ops::Not", "not"),
        ("+", 2) => ("ops::Add", "add"),
        ("-", 2) => ("ops::Sub", "sub"),
        ("*", 2) => ("ops::Mul", "mul"),
        ("/", 2) => ("ops::Div", "div"),
        ("%", 2) => ("ops::Rem", "rem"),
        ("&", 2) => ("ops::BitAnd", "bitand"),
        ("|", 2) => ("ops::BitOr", "bitor"),
        ("^", 2) => ("ops::BitXor", "bitxor"),
        ("<<", 2) => ("ops::Shl", "shl"),
        (">>", 2) => ("ops::Shr", "shr"),
        ("+=", 2) => ("ops::AddAssign", "add_assign"),
        ("-=", 2) => ("ops::SubAssign", "sub_assign"),
        ("*=", 2) => ("ops::MulAssign", "mul_assign"),
        ("/=", 2) => ("ops::DivAssign", "div_assign"),
        ("%=", 2) => ("ops::RemAssign", "rem_assign"),
        ("|=", 2) => ("ops::BitOrAssign", "bitor_assign"),
        ("&=", 2) => ("ops::BitAndAssign", "bitand_assign"),
        ("^=", 2) => ("ops::BitXorAssign", "bitxor_assign"),
        ("<<=", 2) => ("ops::ShlAssign", "shl_assign"),
        (">>=", 2) => ("ops::ShrAssign", "shr_assign"),
        _ => return None,
    })
}
