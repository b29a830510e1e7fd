//! Whole numbers by the types that they are declared with: some are never less than zero, and some go round early.

use super::Builder;
use crate::index::{Shape, Ty};
use crate::syntax::tree::{ExprId, ExprKind, Literal, StmtKind, TypeRef};

impl Builder<'_> {
    /// The name of the type that a variable or field is declared with, if it is a whole number: `u8`.
    pub(super) fn int_of(&self, id: ExprId) -> Option<String> {
        let body = self.body();
        let named = |ty: &TypeRef| int_named(ty).map(str::to_owned);
        match &body.expr(id).kind {
            ExprKind::Deref(inner) => self.int_of(*inner),
            ExprKind::Field { base, name } => {
                let Ty::Adt(owner, _) = self.ty(*base).peel() else { return None };
                let Shape::Struct(fields) = &self.program.index.type_def(*owner).shape else { return None };
                fields.fields.iter().find(|field| field.name == *name).and_then(|field| named(&field.ty))
            }
            ExprKind::Path(_) => {
                let local = self.typed().expr_local.get(&id)?;
                let is_it = |pat| self.typed().pat_local.get(pat) == Some(local);
                let function = &self.program.index.function(self.frames[self.frame].function).function;
                // `self` has no type of its own.
                let own = body.params.iter().skip(usize::from(function.receiver.is_some()));
                if let Some((_, ty)) = own.zip(&function.params).find(|(pat, _)| is_it(pat)) {
                    return named(ty);
                }
                let declared = body.stmts().find_map(|stmt| match &stmt.kind {
                    StmtKind::Let { pat, ty, init, .. } if is_it(pat) => Some((ty, init)),
                    _ => None,
                });
                match declared? {
                    (Some(ty), _) => named(ty),
                    (None, Some(init)) => match &body.expr(*init).kind {
                        ExprKind::Literal(Literal::Int(_, suffix)) if is_int(suffix) => Some(suffix.clone()),
                        ExprKind::Cast { ty, .. } => named(ty),
                        _ => None,
                    },
                    (None, None) => None,
                }
            }
            _ => None,
        }
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
