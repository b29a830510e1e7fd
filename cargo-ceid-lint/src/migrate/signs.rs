//! Which integers have a sign: a subtraction of two that have none panics below zero.

use super::loops::Loops;
use crate::index::{Def, Shape, Ty};
use crate::syntax::tree::{Body, ExprId, ExprKind, GenericArg, Literal, PatId, PatKind, Stmt, StmtKind, TypeRef};
use crate::types::{Callee, LocalId, TypedBody};

/// The code in which something is asked for.
pub(super) struct Code<'a> {
    pub(super) loops: &'a Loops<'a>,
    pub(super) body: &'a Body,
    pub(super) typed: &'a TypedBody,
}

impl<'a> Code<'a> {
    /// Whether a difference may have no value: of integers that are not known to have a sign, and of durations.
    pub(super) fn may_go_below(&self, from: ExprId, what: ExprId) -> bool {
        match self.typed.ty(from).peel() {
            Ty::Int => !(self.has_sign(from) || self.has_sign(what)),
            Ty::External(path, _) => path == "std::time::Duration",
            _ => false,
        }
    }

    /// Whether what is written says that an integer has a sign.
    fn has_sign(&self, id: ExprId) -> bool {
        match &self.body.expr(id).kind {
            ExprKind::Negate(_) => true,
            ExprKind::Literal(Literal::Int(_, suffix)) => is_signed(suffix),
            ExprKind::Binary { op, lhs, rhs } => {
                // What shifts has a type of its own.
                self.has_sign(*lhs) || !matches!(*op, "<<" | ">>") && self.has_sign(*rhs)
            }
            ExprKind::MethodCall { receiver, method, .. } if !self.typed.callees.get(&id).is_some_and(is_resolved) => {
                let is_same = matches!(method.as_str(), "abs" | "clamp" | "clone" | "max" | "min" | "pow" | "signum")
                    || ["saturating_", "wrapping_", "rem_", "div_"].iter().any(|begin| method.starts_with(begin));
                is_same && self.has_sign(*receiver)
            }
            _ => self.spelled(id, 0).is_some_and(is_signed_type),
        }
    }

    /// The type of a value as the source spells it, without references.
    fn spelled(&self, id: ExprId, depth: u32) -> Option<&'a TypeRef> {
        if depth > 8 {
            return None;
        }
        let index = self.loops.program.index;
        let found = match &self.body.expr(id).kind {
            ExprKind::Cast { ty, .. } => ty,
            ExprKind::Field { base, name } => match self.typed.ty(*base).peel() {
                Ty::Adt(id, _) => match &index.type_def(*id).shape {
                    Shape::Struct(fields) => &fields.fields.iter().find(|field| field.name == *name)?.ty,
                    Shape::Enum(_) => return None,
                },
                _ => return None,
            },
            ExprKind::Index { base, .. } => match self.spelled(*base, depth + 1)? {
                TypeRef::Array(inner, _) | TypeRef::Slice(inner) => inner,
                TypeRef::Path(path) if matches!(path.last(), "Vec" | "VecDeque") => {
                    match path.segments.last()?.args.first()? {
                        GenericArg::Type(inner) => inner,
                        _ => return None,
                    }
                }
                _ => return None,
            },
            ExprKind::Deref(inner) | ExprKind::Reference { value: inner, .. } => self.spelled(*inner, depth + 1)?,
            ExprKind::Path(_) => match (self.typed.expr_local.get(&id), self.typed.expr_def.get(&id)) {
                (Some(local), _) => return self.declared(*local, depth),
                (None, Some(Def::Value(value))) => &index.value(*value).item.ty,
                _ => return None,
            },
            ExprKind::Call { .. } | ExprKind::MethodCall { .. } => match self.typed.callees.get(&id)? {
                Callee::Resolved(resolved) => match resolved.targets.as_slice() {
                    [target] => &index.function(*target).function.output,
                    _ => return None,
                },
                _ => return None,
            },
            _ => return None,
        };
        Some(without_references(found))
    }

    /// The type that a variable is declared with, or that of its first value.
    fn declared(&self, local: LocalId, depth: u32) -> Option<&'a TypeRef> {
        let is_it = |pat: PatId| {
            let is_name = matches!(self.body.pat(pat).kind, PatKind::Bind { .. });
            is_name && self.typed.pat_local.get(&pat) == Some(&local)
        };
        let stmt_of = |stmt: &'a Stmt| match &stmt.kind {
            StmtKind::Let { pat, ty, init, .. } if is_it(*pat) => Some((ty.as_ref(), *init)),
            _ => None,
        };
        let blocks = self.body.exprs.iter().filter_map(|expr| match &expr.kind {
            ExprKind::Block(block) => Some(block),
            _ => None,
        });
        let (ty, init) = blocks.flat_map(|block| &block.stmts).find_map(stmt_of)?;
        match (ty, init) {
            (Some(ty), _) => Some(without_references(ty)),
            (None, Some(init)) => self.spelled(init, depth + 1),
            (None, None) => None,
        }
    }
}

fn is_resolved(callee: &Callee) -> bool {
    matches!(callee, Callee::Resolved(_))
}

fn without_references(ty: &TypeRef) -> &TypeRef {
    match ty {
        TypeRef::Reference { inner, .. } => without_references(inner),
        _ => ty,
    }
}

fn is_signed_type(ty: &TypeRef) -> bool {
    matches!(ty, TypeRef::Path(path) if path.ident().is_some_and(is_signed))
}

fn is_signed(name: &str) -> bool {
    matches!(name, "i8" | "i16" | "i32" | "i64" | "i128" | "isize")
}
