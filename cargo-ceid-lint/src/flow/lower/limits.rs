//! How far a loop counts: which collections its counter goes to the end of.

use super::Builder;
use super::constants::Constants;
use super::loops::WhileRounds;
use crate::flow::{Limit, Rounds, Var};
use crate::index::Ty;
use crate::source::Span;
use crate::syntax::tree::{ConstText, ExprId, ExprKind, Literal, Stmt, StmtKind};
use crate::types::LocalId;

/// How deep names are followed.
const MAX_DEPTH: u32 = 8;

/// What changes the numbers of the elements of a collection.
const MOVING: &[&str] = &["remove", "swap_remove", "insert", "swap", "drain"];

impl Builder<'_> {
    /// `while i < n { …; i += 1 }` counts; any other `while` is unbounded.
    pub(super) fn rounds_of_while(&mut self, label: Option<&String>, condition: ExprId, body: ExprId) -> WhileRounds {
        let unbounded = (Rounds::Unbounded, None, Vec::new());
        let tree = self.body();
        let ExprKind::Binary { op, lhs, rhs } = &tree.expr(condition).kind else { return unbounded };
        let (counter, limit) = match *op {
            "<" | "<=" | "!=" => (*lhs, *rhs),
            ">" | ">=" => (*rhs, *lhs),
            _ => return unbounded,
        };
        let Some(local) = self.typed().expr_local.get(&counter).copied() else { return unbounded };
        let Some(count) = self.counts_by_one(local, body) else { return unbounded };
        if self.may_repeat_round(label, body, count) {
            return unbounded;
        }
        let var = self.var_of(local);
        if self.moves_elements(var, body) {
            return unbounded;
        }
        let first = self.initials.get(&var).copied();
        let is_last = matches!(*op, "<=" | ">=");
        let rounds = match (first, self.number(limit)) {
            (Some(first), Some(limit)) => Rounds::Constant((limit + u64::from(is_last)).saturating_sub(first)),
            _ => Rounds::Bounded,
        };
        let limits = self.limits(limit, is_last);
        (rounds, Some((var, first)), limits)
    }

    /// The statement that counts, if the only thing that changes a local is one `+= 1` as a statement of the loop's own block.
    fn counts_by_one(&self, local: LocalId, body: ExprId) -> Option<Span> {
        let tree = self.body();
        let typed = self.typed();
        let writes = tree.exprs.iter().filter(|expr| match &expr.kind {
            ExprKind::Assign { place, .. } | ExprKind::AssignOp { place, .. } => {
                typed.expr_local.get(place) == Some(&local)
            }
            ExprKind::Reference { mutable: true, value, .. } => typed.expr_local.get(value) == Some(&local),
            _ => false,
        });
        if writes.count() != 1 {
            return None;
        }
        let ExprKind::Block(block) = &tree.expr(body).kind else { return None };
        let counts = |stmt: &Stmt| match &stmt.kind {
            StmtKind::Expr { expr, .. } => match &tree.expr(*expr).kind {
                ExprKind::AssignOp { op: "+", place, value } => {
                    typed.expr_local.get(place) == Some(&local)
                        && matches!(&tree.expr(*value).kind, ExprKind::Literal(Literal::Int(Some(1), _)))
                }
                _ => false,
            },
            StmtKind::Let { .. } => false,
        };
        block.stmts.iter().find(|stmt| counts(stmt)).and_then(|stmt| match &stmt.kind {
            StmtKind::Expr { expr, .. } => Some(tree.expr(*expr).span),
            StmtKind::Let { .. } => None,
        })
    }

    /// Whether a `continue` before the count starts the same round again, after something was done with a filter.
    fn may_repeat_round(&self, label: Option<&String>, body: ExprId, count: Span) -> bool {
        let tree = self.body();
        let is_filter = |id: &ExprId| self.program.index.holds_filter(self.ty(*id));
        let all = tree.within(body);
        let ends = all.iter().filter(|id| is_filter(id)).map(|id| tree.expr(*id).span.end);
        let Some(first_use) = ends.min() else { return false };
        let mut open = vec![(body, false)];
        while let Some((id, is_inner)) = open.pop() {
            let expr = tree.expr(id);
            let is_inner = match &expr.kind {
                ExprKind::Continue { label: to } => {
                    let is_own = to.as_ref().map_or(!is_inner, |to| Some(to) == label);
                    if is_own && (first_use..count.start).contains(&expr.span.start) {
                        return true;
                    }
                    continue;
                }
                ExprKind::Closure(_) => continue,
                ExprKind::Loop { .. } | ExprKind::While { .. } | ExprKind::For { .. } => true,
                _ => is_inner,
            };
            open.extend(tree.children(id).into_iter().map(|child| (child, is_inner)));
        }
        false
    }

    /// Whether elements change their numbers while a loop counts: the one behind a removed element is passed over.
    fn moves_elements(&self, counter: Var, body: ExprId) -> bool {
        let tree = self.body();
        tree.within(body).into_iter().any(|id| match &tree.expr(id).kind {
            ExprKind::MethodCall { receiver, method, args, .. } => {
                MOVING.contains(&method.as_str())
                    && self.program.index.holds_filter(self.ty(*receiver))
                    && args.iter().any(|arg| self.counts_with(*arg, counter))
            }
            _ => false,
        })
    }

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
                    let mut limits = Vec::new();
                    self.limits_at(initial, depth + 1, &mut limits);
                    // Whatever it was made from, it has that number.
                    if limits.contains(&Limit::Unknown) {
                        limits = vec![self.held(id)];
                    }
                    return found.append(&mut limits);
                }
                if self.typed().expr_local.contains_key(&id) {
                    let limit = self.held(id);
                    return found.push(limit);
                }
                let scope = self.program.index.scope_of(self.frames[self.frame].function);
                let text = ConstText { text: path.text(), value: None };
                let length = self.program.index.length(&text, &scope);
                found.push(Limit::Length(length));
            }
            _ => {
                let limit = self.number(id).map_or_else(|| self.held(id), Limit::Number);
                found.push(limit);
            }
        }
    }

    /// The number that a variable or a field has.
    fn held(&mut self, id: ExprId) -> Limit {
        self.static_place(id).map_or(Limit::Unknown, Limit::Held)
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
