//! Whole numbers by the types that they are declared with: some are never less than zero, and some go round early.

use rustc_hash::FxHashMap;

use super::Builder;
use crate::index::{MethodOwner, Shape, Ty};
use crate::syntax::tree::{ExprId, ExprKind, Literal, PatId, StmtKind, TypeRef};
use crate::types::{Callee, LocalId};

impl Builder<'_> {
    /// The name of the type that a variable or field is declared with, if it is a whole number: `u8`.
    pub(super) fn int_of(&self, id: ExprId) -> Option<String> {
        match &self.body().expr(id).kind {
            ExprKind::Deref(inner) => self.int_of(*inner),
            ExprKind::Field { .. } | ExprKind::Index { .. } => int_named(self.written_type(id)?).map(str::to_owned),
            ExprKind::Path(_) => {
                let local = self.typed().expr_local.get(&id)?;
                self.frames[self.frame].ints.get_or_init(|| self.declared_ints()).get(local).cloned()
            }
            _ => None,
        }
    }

    /// Whether a number is of a type that has none below zero, or reckoned from one that is.
    pub(super) fn is_unsigned(&self, id: ExprId) -> bool {
        match &self.body().expr(id).kind {
            ExprKind::Binary { op: "<<" | ">>", lhs, .. } => self.is_unsigned(*lhs),
            ExprKind::Binary { lhs, rhs, .. } => self.is_unsigned(*lhs) || self.is_unsigned(*rhs),
            ExprKind::Cast { ty, .. } => int_named(ty).is_some_and(|name| name.starts_with('u')),
            ExprKind::Literal(Literal::Int(_, suffix)) => is_int(suffix) && suffix.starts_with('u'),
            _ => self.int_of(id).is_some_and(|name| name.starts_with('u')),
        }
    }

    /// The type that a field was declared with, or the elements of an array that is one.
    fn written_type(&self, id: ExprId) -> Option<&TypeRef> {
        match &self.body().expr(id).kind {
            ExprKind::Field { base, name } => {
                let Ty::Adt(owner, _) = self.ty(*base).peel() else { return None };
                let Shape::Struct(fields) = &self.program.index.type_def(*owner).shape else { return None };
                fields.fields.iter().find(|field| field.name == *name).map(|field| &field.ty)
            }
            ExprKind::Index { base, .. } => match self.written_type(*base)? {
                TypeRef::Array(element, _) | TypeRef::Slice(element) => Some(&**element),
                _ => None,
            },
            _ => None,
        }
    }

    /// The variables of a body that are declared as whole numbers, with the names of their types.
    fn declared_ints(&self) -> FxHashMap<LocalId, String> {
        let (body, typed) = (self.body(), self.typed());
        let named = |pat: &PatId, name: Option<&str>| Some((typed.pat_local.get(pat).copied()?, name?.to_owned()));
        let function = &self.program.index.function(self.frames[self.frame].function).function;
        // `self` has no type of its own.
        let own = body.params.iter().skip(usize::from(function.receiver.is_some()));
        let params = own.zip(&function.params).filter_map(|(pat, ty)| named(pat, int_named(ty)));
        let of_init = |init: ExprId| match &body.expr(init).kind {
            ExprKind::Literal(Literal::Int(_, suffix)) if is_int(suffix) => Some(suffix.as_str()),
            ExprKind::Cast { ty, .. } => int_named(ty),
            ExprKind::MethodCall { .. } | ExprKind::Call { .. } => match typed.callees.get(&init)? {
                Callee::Resolved(call) => {
                    let declared = call.owner.as_ref().and_then(MethodOwner::function);
                    let id = declared.or_else(|| call.targets.first().copied())?;
                    int_named(&self.program.index.function(id).function.output)
                }
                _ => None,
            },
            _ => None,
        };
        let declared = body.stmts().filter_map(|stmt| match &stmt.kind {
            StmtKind::Let { pat, ty: Some(ty), .. } => named(pat, int_named(ty)),
            StmtKind::Let { pat, init: Some(init), .. } => named(pat, of_init(*init)),
            _ => None,
        });
        params.chain(declared).collect()
    }
}

/// The whole number that a type is, or refers to.
fn int_named(ty: &TypeRef) -> Option<&str> {
    match ty {
        TypeRef::Reference { inner, .. } => int_named(inner),
        TypeRef::Path(path) => path.ident().filter(|name| is_int(name)),
        _ => None,
    }
}

fn is_int(name: &str) -> bool {
    let size = name.strip_prefix(['u', 'i']);
    size.is_some_and(|size| matches!(size, "8" | "16" | "32" | "64" | "128" | "size"))
}
