//! Futures of the analysed code: types with a `poll` of their own, and those that become one where they are awaited.

use super::Callee;
use super::infer::Infer;
use crate::index::{FunctionId, Index, TraitName, TraitRef, Ty};
use crate::syntax::tree::{ExprId, ExprKind};

/// What awaiting a value runs.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Awaited {
    /// The `poll` of its type, until that is ready.
    Poll(Vec<FunctionId>),
    /// Its `into_future`, and what that gives.
    IntoFuture(FunctionId),
    /// The `poll` of a type that only whoever made the value knows.
    Unseen,
}

/// What awaiting a value of a type runs, and the type behind pointers that has it; `None` if the type does not tell.
#[must_use]
pub fn awaited(index: &Index, ty: &Ty) -> Option<(Awaited, Ty)> {
    let bounds: &[TraitRef] = match ty {
        Ty::Param(param) => &param.bounds,
        Ty::Opaque(bounds) => bounds,
        _ => &[],
    };
    if bounds.iter().any(|bound| is_of(&bound.name, "Future")) {
        return Some((Awaited::Unseen, ty.clone()));
    }
    // Only a reference to it may be one: `impl Future for &mut Channel`.
    let lent = Ty::Ref(true, Box::new(ty.clone()));
    let own = |method: &str, of_trait: &str| -> Vec<FunctionId> {
        let owners = [ty, &lent].into_iter().flat_map(|ty| index.methods(ty, method));
        let meant = owners.filter(|owner| owner.of_trait().is_some_and(|name| is_of(name, of_trait)));
        meant.filter_map(|owner| owner.function()).collect()
    };
    if let Ty::Adt(..) | Ty::Ref(..) = ty {
        let polls = own("poll", "Future");
        if !polls.is_empty() {
            return Some((Awaited::Poll(polls), ty.clone()));
        }
        if let Some(function) = own("into_future", "IntoFuture").first() {
            return Some((Awaited::IntoFuture(*function), ty.clone()));
        }
    }
    awaited(index, pointed_to(ty)?)
}

/// The type behind references and what owns a value alone: `Pin<&mut Read>`, `Box<Read>`.
#[must_use]
pub fn future_behind(ty: &Ty) -> &Ty {
    pointed_to(ty).map_or(ty, future_behind)
}

fn pointed_to(ty: &Ty) -> Option<&Ty> {
    match ty {
        Ty::Ref(_, inner) => Some(inner),
        Ty::External(_, args) if matches!(ty.external_name(), Some("Box" | "Pin")) => args.first(),
        _ => None,
    }
}

fn is_of(name: &TraitName, of_trait: &str) -> bool {
    matches!(name, TraitName::External(path) if path.rsplit("::").next() == Some(of_trait))
}

impl Infer<'_> {
    /// The type of what awaiting a value gives. A call of an `async fn` has the type of what that gives already.
    pub(super) fn awaited_ty(&self, value: ExprId, ty: &Ty) -> Ty {
        let is_async = match (&self.body.expr(value).kind, self.typed.callees.get(&value)) {
            (ExprKind::Block(_), _) => true,
            (_, Some(Callee::Resolved(resolved))) => {
                resolved.targets.iter().any(|target| self.index.function(*target).function.is_async)
            }
            _ => false,
        };
        let ty = self.shallow_deep(ty);
        let future = awaited(self.index, &ty).filter(|_| !is_async);
        let output = future.map(|(_, future)| self.index.project(&future, "Output"));
        output.filter(|output| *output != Ty::Unknown).unwrap_or(ty)
    }
}
