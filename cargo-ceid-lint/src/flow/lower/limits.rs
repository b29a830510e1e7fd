//! How far a loop counts: which collections its counter goes to the end of.

use super::Builder;
use super::constants::Constants;
use crate::flow::Limit;
use crate::index::Ty;
use crate::syntax::tree::{ConstText, ExprId, ExprKind};

/// How deep names are followed.
const MAX_DEPTH: u32 = 8;

impl Builder<'_> {
    /// What ends the count of a loop that has this behind it, or as its last number.
    pub(super) fn limits(&mut self, end: ExprId, inclusive: bool) -> Vec<Limit> {
        let mut found = Vec::new();
        match self.number(end) {
            Some(number) => found.push(Limit::Number(number.saturating_add(u64::from(inclusive)))),
            None if inclusive => match self.one_less(end) {
                Some(length) => self.limits_at(length, 0, &mut found),
                None => found.push(Limit::Unknown),
            },
            None => self.limits_at(end, 0, &mut found),
        }
        found
    }

    fn limits_at(&mut self, id: ExprId, depth: u32, found: &mut Vec<Limit>) {
        let body = self.body();
        if depth > MAX_DEPTH {
            found.push(Limit::Unknown);
            return;
        }
        match &body.expr(id).kind {
            ExprKind::Cast { value, .. } => self.limits_at(*value, depth + 1, found),
            ExprKind::MethodCall { receiver, method, args, .. } => match (method.as_str(), args.as_slice()) {
                ("len", []) if self.is_collection(*receiver) => {
                    let place = self.static_place(*receiver);
                    found.push(place.map_or(Limit::Unknown, Limit::Elements));
                }
                ("min", [other]) => {
                    self.limits_at(*receiver, depth + 1, found);
                    self.limits_at(*other, depth + 1, found);
                }
                _ => found.push(Limit::Unknown),
            },
            ExprKind::Path(path) => {
                let own = Constants { program: self.program, body, typed: self.typed() };
                if let Some(initial) = own.initial(id) {
                    return self.limits_at(initial, depth + 1, found);
                }
                if self.typed().expr_local.contains_key(&id) {
                    return found.push(Limit::Unknown);
                }
                let scope = self.program.index.scope_of(self.frames[self.frame].function);
                let text = ConstText { text: path.text(), value: None };
                let length = self.program.index.length(&text, &scope);
                found.push(Limit::Length(length));
            }
            _ => match self.number(id) {
                Some(number) => found.push(Limit::Number(number)),
                None => found.push(Limit::Unknown),
            },
        }
    }

    /// Whether `len` of it says how many elements it has.
    fn is_collection(&self, id: ExprId) -> bool {
        let ty = self.ty(id).peel();
        ty.element().is_some() || matches!(ty, Ty::External(..))
    }

    /// The `n` of `n - 1`.
    fn one_less(&mut self, id: ExprId) -> Option<ExprId> {
        match &self.body().expr(id).kind {
            ExprKind::Binary { op: "-", lhs, rhs } if self.number(*rhs) == Some(1) => Some(*lhs),
            _ => None,
        }
    }

    /// Whether a number is certainly less than that of the elements of a collection: `v.len() - 1`, `v.len() / 2`.
    pub(super) fn is_short_of(&mut self, id: ExprId, collection: &crate::flow::Place) -> bool {
        let (op, lhs, rhs) = match &self.body().expr(id).kind {
            ExprKind::Binary { op, lhs, rhs } => (*op, *lhs, *rhs),
            ExprKind::Path(_) => {
                let own = Constants { program: self.program, body: self.body(), typed: self.typed() };
                let Some(initial) = own.initial(id).filter(|initial| *initial != id) else { return false };
                return self.is_short_of(initial, collection);
            }
            _ => return false,
        };
        let by = self.number(rhs).unwrap_or_default();
        (op == "-" && by > 0 || op == "/" && by > 1) && self.limits(lhs, false) == [Limit::Elements(collection.clone())]
    }
}
