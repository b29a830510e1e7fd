//! Handles to filters that a function duplicates, and where it puts several of them together.

use crate::index::{Index, Ty};
use crate::syntax::tree::{Body, ExprId, ExprKind};
use crate::types::TypedBody;

/// The types of what is duplicated or put together, if it has handles to filters in it.
#[derive(Clone, Debug, Default)]
pub struct Duplicated {
    /// Of what is cloned.
    pub cloned: Vec<Ty>,
    /// Of what goes on with other elements than it had, or with some of them several times.
    pub mixed: Vec<Ty>,
    /// Of what weak handles lead to.
    pub upgraded: Vec<Ty>,
}

impl Duplicated {
    pub(super) fn of(index: &Index, body: &Body, typed: &TypedBody) -> Self {
        let mut found = Self::default();
        let names_clone = |id: &ExprId| matches!(&body.expr(*id).kind, ExprKind::Path(path) if clones(path.last()));
        let names =
            |id: &ExprId, name: &str| matches!(&body.expr(*id).kind, ExprKind::Path(path) if path.last() == name);
        // What is made where it is written is no other element.
        let is_there_already = |within: ExprId| {
            body.within(within).any(|id| {
                let expr = body.expr(id);
                let is_place = matches!(expr.kind, ExprKind::Path(_) | ExprKind::Field { .. } | ExprKind::Index { .. });
                is_place && index.may_share_filter(typed.ty(id))
            })
        };
        for (number, expr) in (0u32..).zip(&body.exprs) {
            let (name, receiver, args) = match &expr.kind {
                ExprKind::MethodCall { receiver, method, args, .. } => (&**method, Some(*receiver), args),
                ExprKind::Call { callee, args } => match &body.expr(*callee).kind {
                    ExprKind::Path(path) => (path.last(), None, args),
                    _ => continue,
                },
                _ => continue,
            };
            // `all.iter().map(Rc::clone)` clones as well.
            let is_cloning = clones(name) || args.iter().any(names_clone);
            let is_upgrading = name == "upgrade" || args.iter().any(|arg| names(arg, "upgrade"));
            // `BTreeMap::from([(FRONT, wheel.clone()), (BACK, wheel)])`
            let lists = || name == "from" && args.iter().any(|arg| matches!(typed.ty(*arg), Ty::Array(..)));
            let is_mixing = mixes(name) || lists();
            if !is_cloning && !is_mixing && !is_upgrading {
                continue;
            }
            let parts = receiver.into_iter().chain(args.iter().copied()).chain([ExprId(number)]);
            let shared: Vec<&Ty> = parts.map(|part| typed.ty(part)).filter(|ty| index.may_share_filter(ty)).collect();
            if shared.is_empty() {
                continue;
            }
            let mut mixed = receiver.filter(|_| !adds(name)).into_iter().chain(args.iter().copied());
            let is_mixing = is_mixing && mixed.any(is_there_already);
            for ty in shared {
                found.cloned.extend(is_cloning.then(|| ty.clone()));
                found.upgraded.extend(is_upgrading.then(|| ty.clone()));
                found.mixed.extend(is_mixing.then(|| ty.clone()));
            }
        }
        found
    }
}

/// Whether what a function of this name gives leads to where its argument leads.
fn clones(name: &str) -> bool {
    matches!(
        name,
        "clone"
            | "cloned"
            | "to_vec"
            | "to_owned"
            | "clone_from"
            | "clone_from_slice"
            | "clone_into"
            | "repeat"
            | "repeat_n"
            | "extend_from_slice"
            | "extend_from_within"
            | "upgrade"
            | "successors"
    )
}

/// Whether a function of this name puts elements of several collections together, or some of one several times.
fn mixes(name: &str) -> bool {
    matches!(
        name,
        "chain"
            | "cycle"
            | "concat"
            | "repeat"
            | "repeat_n"
            | "extend"
            | "append"
            | "extend_from_slice"
            | "extend_from_within"
            | "flat_map"
            | "windows"
            | "successors"
            | "splice"
            | "unzip"
            | "from_iter"
    )
}

/// Whether a method of this name adds to its receiver what it is given.
fn adds(name: &str) -> bool {
    matches!(name, "extend" | "append" | "extend_from_slice" | "splice")
}
