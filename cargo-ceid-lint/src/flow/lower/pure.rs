//! Expressions that read places and do nothing else, in one spelling: they give the same as long as the places are not written.

use super::Builder;
use super::subjects::{Pure, lends_payload, pure_place};
use crate::flow::Place;
use crate::index::{Def, Ty};
use crate::syntax::tree::{ExprId, ExprKind, Path, StmtKind, TypeRef};
use crate::types::Callee;

/// The field that a getter gives a value of.
pub(super) struct FieldGiven {
    /// The steps to it, from `self` on.
    pub(super) names: Vec<String>,
    /// Whether it is cloned there.
    pub(super) is_cloned: bool,
}

impl Builder<'_> {
    /// The expression in one spelling, if it is pure: it reads places, and gives the same as long as they are not written.
    pub(super) fn pure(&mut self, id: ExprId) -> Option<Pure> {
        let body = self.body();
        match &body.expr(id).kind {
            ExprKind::Path(path) => self.pure_path(id, path),
            ExprKind::Literal(literal) => Some(Pure { key: literal.spelling(), ..Pure::default() }),
            ExprKind::Field { .. } | ExprKind::Index { .. } => {
                let Some(place) = self.static_place(id) else { return self.entry_of_constant(id) };
                let mut found = pure_place(place);
                // Another number is another element.
                let mut at = id;
                while let ExprKind::Field { base, .. } | ExprKind::Index { base, .. } = &body.expr(at).kind {
                    if let ExprKind::Index { index, .. } = &body.expr(at).kind {
                        found.reads.extend(self.pure(*index)?.reads);
                    }
                    at = *base;
                }
                Some(found)
            }
            ExprKind::Deref(inner) | ExprKind::Reference { value: inner, raw: false, .. } => self.pure(*inner),
            ExprKind::Cast { value, .. } if self.keeps_value(id) => self.pure(*value),
            // Another value, which is the same as long as that one is.
            ExprKind::Cast { value, ty } => {
                let from = self.pure(*value)?;
                Some(Pure { key: format!("({} as {ty:?})", from.key), reads: from.reads, whole: None })
            }
            ExprKind::Range { start, end, inclusive } => {
                let mut range = Pure { key: if *inclusive { "..=" } else { ".." }.to_owned(), ..Pure::default() };
                for (number, bound) in [start, end].into_iter().enumerate() {
                    let Some(bound) = bound else { continue };
                    let bound = self.pure(*bound)?;
                    range.key.insert_str(if number == 0 { 0 } else { range.key.len() }, &bound.key);
                    range.reads.extend(bound.reads);
                }
                Some(range)
            }
            ExprKind::Not(inner) => self.pure_unary("!", *inner),
            ExprKind::Negate(inner) => self.pure_unary("-", *inner),
            ExprKind::Binary { op, lhs, rhs } => {
                let left = self.pure(*lhs)?;
                let right = self.pure(*rhs)?;
                let mut reads = left.reads;
                reads.extend(right.reads);
                Some(Pure { key: format!("({} {op} {})", left.key, right.key), reads, whole: None })
            }
            // Lending what may be there asks about the same.
            ExprKind::MethodCall { receiver, method, .. }
                if lends_payload(method) && self.is_optional(*receiver)
                    || matches!(method.as_str(), "as_mut_slice" | "as_slice") =>
            {
                self.pure(*receiver)
            }
            ExprKind::MethodCall { receiver, method, args, .. } => {
                if let Some(place) = self.state_behind(id) {
                    return Some(pure_place(place));
                }
                if !self.is_pure_method(id, method) {
                    return None;
                }
                let base = self.pure(*receiver)?;
                let mut key = format!("{}.{method}(", base.key);
                let mut reads = base.reads;
                for arg in args {
                    let arg = self.pure(*arg)?;
                    key.push_str(&arg.key);
                    key.push(',');
                    reads.extend(arg.reads);
                }
                key.push(')');
                Some(Pure { key, reads, whole: None })
            }
            // What is made of pure parts is another value only where they are.
            ExprKind::Call { callee, args }
                if matches!(self.typed().callees.get(&id), Some(Callee::Constructor(_))) =>
            {
                let ExprKind::Path(path) = &body.expr(*callee).kind else { return None };
                let mut made = Pure { key: format!("{}(", path.last()), ..Pure::default() };
                for arg in args {
                    let arg = self.pure(*arg)?;
                    made.key.push_str(&arg.key);
                    made.key.push(',');
                    made.reads.extend(arg.reads);
                }
                made.key.push(')');
                Some(made)
            }
            _ => None,
        }
    }

    /// The place of the state that a getter gives: `self.mode()`.
    pub(super) fn state_behind(&mut self, id: ExprId) -> Option<Place> {
        let body = self.body();
        let ExprKind::MethodCall { receiver, args, .. } = &body.expr(id).kind else { return None };
        if !args.is_empty() || !self.is_state(self.ty(id)) || matches!(self.ty(id), Ty::Ref(..)) {
            return None;
        }
        let names = self.field_given(id)?.names;
        let place = self.static_place(*receiver)?;
        Some(names.iter().fold(place, |place, name| place.field(name)))
    }

    /// The field that a getter gives, if it does nothing else: `fn mode(&self) -> Mode { self.state.mode }`.
    pub(super) fn field_given(&self, id: ExprId) -> Option<FieldGiven> {
        let target = self.only_target(id)?;
        let getter = self.program.index.function(target).function.body.as_ref()?;
        let typed = self.program.typed(target)?;
        let [param] = getter.params.as_slice() else { return None };
        let owner = typed.pat_local.get(param)?;
        let mut at = getter.root;
        let mut names: Vec<String> = Vec::new();
        let mut is_cloned = false;
        loop {
            match &getter.expr(at).kind {
                ExprKind::Block(block) if block.stmts.is_empty() => at = block.tail?,
                ExprKind::MethodCall { receiver, method, args, .. } if method == "clone" && args.is_empty() => {
                    is_cloned = true;
                    at = *receiver;
                }
                ExprKind::Field { base, name } => {
                    names.push(name.clone());
                    at = *base;
                }
                ExprKind::Path(_) if typed.expr_local.get(&at) == Some(owner) && !names.is_empty() => break,
                _ => return None,
            }
        }
        names.reverse();
        Some(FieldGiven { names, is_cloned })
    }

    /// Whether a cast gives the value that it gets: `true as u8` is no `true`, and `300 as u8` no 300.
    pub(super) fn keeps_value(&self, id: ExprId) -> bool {
        let ExprKind::Cast { value, ty } = &self.body().expr(id).kind else { return true };
        let is_number = matches!(self.ty(id).peel(), Ty::Int | Ty::Float);
        match self.ty(*value).peel() {
            Ty::Bool | Ty::Char | Ty::Float => false,
            // No number of another type is too big for one of these.
            Ty::Int => {
                let is_wide = |name: &str| matches!(name, "u64" | "i64" | "u128" | "i128" | "usize" | "isize");
                matches!(ty, TypeRef::Path(path) if is_wide(path.last()))
            }
            _ => !is_number,
        }
    }

    fn pure_unary(&mut self, op: &str, inner: ExprId) -> Option<Pure> {
        let inner = self.pure(inner)?;
        Some(Pure { key: format!("{op}{}", inner.key), reads: inner.reads, whole: None })
    }

    fn pure_path(&mut self, id: ExprId, path: &Path) -> Option<Pure> {
        if let Some(place) = self.stand_in(id) {
            return Some(pure_place(place));
        }
        if let Some(local) = self.typed().expr_local.get(&id).copied() {
            let var = self.var_of(local);
            return Some(self.pure_var(var));
        }
        match self.typed().expr_def.get(&id) {
            Some(Def::Value(value)) => {
                let item = &self.program.index.value(*value).item;
                // A static may be changed by someone else, unless it holds nothing but a value.
                let is_fixed = !item.is_static || (!item.is_mutable && self.is_plain_value(self.ty(id)));
                is_fixed.then(|| Pure { key: path.text(), ..Pure::default() })
            }
            Some(Def::Variant(..) | Def::External(_) | Def::Type(_)) => {
                Some(Pure { key: path.text(), ..Pure::default() })
            }
            None if path.ident().is_some_and(|name| self.is_const_parameter(name)) => {
                Some(Pure { key: path.text(), ..Pure::default() })
            }
            // `P::HAS_INERTIA`, whatever `P` is.
            None if path.segments.len() > 1 && is_constant_name(path.last()) => {
                Some(Pure { key: path.text(), ..Pure::default() })
            }
            _ => None,
        }
    }

    fn is_plain_value(&self, ty: &Ty) -> bool {
        matches!(ty, Ty::Bool | Ty::Int | Ty::Float | Ty::Char | Ty::Str)
    }

    /// Whether a name is a constant parameter of the function at hand, or of its impl.
    fn is_const_parameter(&self, name: &str) -> bool {
        let index = self.program.index;
        let def = index.function(self.frames[self.frame].function);
        let of_impl = match def.owner {
            crate::index::Owner::Impl(id) => index.impl_def(id).generics.params.as_slice(),
            _ => &[],
        };
        def.function.generics.params.iter().chain(of_impl).any(|param| param.is_const && param.name == name)
    }

    /// Methods that read a value and nothing else.
    fn is_pure_method(&self, id: ExprId, method: &str) -> bool {
        let known = matches!(
            method,
            "is_some"
                | "is_none"
                | "is_ok"
                | "is_err"
                | "is_empty"
                | "len"
                | "abs"
                | "is_nan"
                | "is_finite"
                | "as_ref"
                | "is_positive"
                | "is_negative"
                | "min"
                | "max"
                | "is_multiple_of"
                | "as_deref"
                | "signum"
                | "get"
                | "clone"
                | "to_owned"
                | "is_sign_negative"
                | "is_sign_positive"
                | "rem_euclid"
                | "contains"
                | "contains_key"
                | "is_infinite"
                | "cmp"
                | "partial_cmp"
                | "total_cmp"
                | "starts_with"
                | "ends_with"
                | "first_mut"
                | "last_mut"
                | "split_first_mut"
                | "split_last_mut"
        );
        match self.typed().callees.get(&id) {
            Some(Callee::Builtin) => known,
            Some(Callee::Resolved(resolved)) => match resolved.targets.as_slice() {
                [target] => self.is_pure_function(*target, 0),
                _ => false,
            },
            _ => known && method != "get",
        }
    }

    /// Whether a function only reads what it is given: all that its body is made of is pure.
    pub(super) fn is_pure_function(&self, id: crate::index::FunctionId, depth: u32) -> bool {
        let def = self.program.index.function(id);
        use crate::syntax::tree::Receiver;
        if depth > 3 || def.function.receiver == Some(Receiver::Exclusive) {
            return false;
        }
        let (Some(body), Some(typed)) = (&def.function.body, self.program.typed(id)) else { return false };
        let is_static = |id: ExprId| match typed.expr_def.get(&id) {
            Some(Def::Value(value)) => self.program.index.value(*value).item.is_static,
            _ => false,
        };
        let at = |number: usize| ExprId(u32::try_from(number).unwrap_or(u32::MAX));
        body.exprs.iter().enumerate().all(|(number, expr)| match &expr.kind {
            ExprKind::Path(_) => !is_static(at(number)),
            ExprKind::Literal(_)
            | ExprKind::Field { .. }
            | ExprKind::Binary { .. }
            | ExprKind::Not(_)
            | ExprKind::Negate(_)
            | ExprKind::Deref(_)
            | ExprKind::Cast { .. }
            | ExprKind::Let { .. }
            | ExprKind::Match { .. }
            | ExprKind::If { .. }
            | ExprKind::Return(_)
            | ExprKind::Reference { mutable: false, .. } => true,
            ExprKind::Block(block) => {
                block.stmts.iter().all(|stmt| matches!(stmt.kind, StmtKind::Let { .. } | StmtKind::Expr { .. }))
            }
            ExprKind::MethodCall { method, .. } => match typed.callees.get(&at(number)) {
                Some(Callee::Resolved(resolved)) => match resolved.targets.as_slice() {
                    [target] => self.is_pure_function(*target, depth + 1),
                    _ => false,
                },
                Some(Callee::Builtin) => {
                    matches!(method.as_str(), "is_some" | "is_none" | "is_ok" | "is_err" | "abs" | "is_empty" | "len")
                }
                _ => false,
            },
            _ => false,
        })
    }
}

/// Whether a name is written as constants are.
fn is_constant_name(name: &str) -> bool {
    name.chars().all(|letter| letter.is_ascii_uppercase() || letter.is_ascii_digit() || letter == '_')
}
