//! What a guard is made from: the places that it borrows as long as it is alive, and the token that it takes.

use super::site::Site;
use crate::syntax::tree::{ExprId, ExprKind, MacroKind};

/// A place that is borrowed: a variable, or a field of one.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Loan {
    pub(super) root: String,
    /// The first field, if it is a field.
    pub(super) field: Option<String>,
}

/// What an expression that makes a guard needs.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct Needs {
    pub(super) loans: Vec<Loan>,
    /// The variable with the token of the cycle, which is moved into the guard.
    pub(super) token: Option<String>,
    /// The variable that is lent as it is, if it is the only filter of a guard of `ceid-core`.
    pub(super) filter: Option<String>,
}

/// What making a guard needs; `None` if it is made in a way that is not known.
pub(super) fn needs(site: &Site<'_>, id: ExprId) -> Option<Needs> {
    match &site.body.expr(id).kind {
        ExprKind::MethodCall { receiver, method, args, .. } => match (method.as_str(), args.as_slice()) {
            ("unwrap", []) => needs(site, *receiver),
            ("expect", [text]) if is_literal(site, *text) => needs(site, *receiver),
            ("cycle", []) => Some(Needs { loans: vec![place(site, *receiver)?], ..Needs::default() }),
            ("guard", [arg]) => {
                let loan = lent(site, *arg)?;
                let filter = loan.field.is_none().then(|| loan.root.clone());
                let Needs { token, mut loans, .. } = cycle(site, *receiver)?;
                loans.push(loan);
                Some(Needs { token, filter, loans })
            }
            _ => None,
        },
        ExprKind::Try(inner) => needs(site, *inner),
        ExprKind::Call { callee, args } if matches!(site.body.expr(*callee).kind, ExprKind::Path(_)) => {
            let lent: Option<Vec<Loan>> =
                args.iter().filter(|arg| !is_literal(site, **arg)).map(|arg| lent(site, *arg)).collect();
            Some(Needs { loans: lent?, ..Needs::default() })
        }
        ExprKind::Macro(own) => match &own.kind {
            MacroKind::Ceid { token, filters, .. } => {
                let Needs { token, mut loans, .. } = cycle(site, (*token)?)?;
                for (_, filter) in filters {
                    loans.push(place(site, *filter)?);
                }
                Some(Needs { token, loans, filter: None })
            }
            _ => None,
        },
        _ => None,
    }
}

/// What the token of a cycle needs: the variable that has it, or the clock that is asked for it where the guard is made.
fn cycle(site: &Site<'_>, id: ExprId) -> Option<Needs> {
    match &site.body.expr(id).kind {
        ExprKind::MethodCall { receiver, method, args, .. } if method == "begin_cycle" && args.is_empty() => {
            Some(Needs { loans: vec![place(site, *receiver)?], ..Needs::default() })
        }
        _ => Some(Needs { token: Some(variable(site, id)?), ..Needs::default() }),
    }
}

fn is_literal(site: &Site<'_>, id: ExprId) -> bool {
    matches!(site.body.expr(id).kind, ExprKind::Literal(_))
}

/// An argument that is lent: `&mut place`, `&place`, or a variable that is a reference.
fn lent(site: &Site<'_>, id: ExprId) -> Option<Loan> {
    match &site.body.expr(id).kind {
        ExprKind::Reference { raw: false, value, .. } => place(site, *value),
        ExprKind::Path(_) if matches!(site.typed.ty(id), crate::index::Ty::Ref(..)) => place(site, id),
        _ => None,
    }
}

/// A variable, or a field of one, however deep.
pub(super) fn place(site: &Site<'_>, id: ExprId) -> Option<Loan> {
    match &site.body.expr(id).kind {
        ExprKind::Field { base, name } => {
            let base = place(site, *base)?;
            Some(Loan { field: base.field.or_else(|| Some(name.clone())), ..base })
        }
        ExprKind::Path(_) => Some(Loan { root: variable(site, id)?, field: None }),
        _ => None,
    }
}

fn variable(site: &Site<'_>, id: ExprId) -> Option<String> {
    let local = site.typed.expr_local.get(&id)?;
    Some(site.typed.local(*local).name.clone())
}
