//! How far a loop counts: which collections its counter goes to the end of.

use super::Builder;
use super::constants::Constants;
use super::loops::WhileRounds;
use crate::flow::{Limit, Rounds, Var};
use crate::index::{Def, Ty};
use crate::source::Span;
use crate::syntax::tree::{ConstText, ExprId, ExprKind, StmtKind};
use crate::types::LocalId;

/// How deep names are followed.
const MAX_DEPTH: u32 = 8;

/// What changes the numbers of the elements of a collection.
const MOVING: &[&str] = &["remove", "swap_remove", "insert", "swap", "drain"];

/// The statement of a loop that counts its rounds.
struct Count {
    span: Span,
    goes_up: bool,
    /// By how much; none for a constant that is not known.
    step: Option<u64>,
    /// Whether a round begins with it.
    comes_first: bool,
    /// Whether nothing else in the function changes the counter.
    is_only_change: bool,
}

impl Builder<'_> {
    /// `while i < n { …; i += 1 }` counts, and so does `while n > 0 { n -= 1; … }`; any other `while` is unbounded.
    pub(super) fn rounds_of_while(&mut self, label: Option<&String>, condition: ExprId, body: ExprId) -> WhileRounds {
        match &self.body().expr(condition).kind {
            // What else is asked can only end it earlier.
            ExprKind::Binary { op: "&&", lhs, rhs } => {
                let mut parts = [*lhs, *rhs].into_iter().map(|part| self.rounds_of_while(label, part, body));
                let counts = parts.find(|found| found.rounds != Rounds::Unbounded);
                counts.map_or_else(WhileRounds::unbounded, WhileRounds::at_most)
            }
            ExprKind::Binary { op, .. } => self.rounds_while(label, op, condition, body),
            _ => WhileRounds::unbounded(),
        }
    }

    /// The same for a comparison by another operator than the one that is written: `loop { if i >= n { break; } … }`.
    pub(super) fn rounds_while(
        &mut self,
        label: Option<&String>,
        op: &str,
        condition: ExprId,
        body: ExprId,
    ) -> WhileRounds {
        let ExprKind::Binary { lhs, rhs, .. } = &self.body().expr(condition).kind else {
            return WhileRounds::unbounded();
        };
        // What is compared, with what, and whether it is to be the less of the two.
        let sides = match op {
            "<" | "<=" => [(*lhs, *rhs, Some(true)), (*rhs, *lhs, Some(false))],
            ">" | ">=" => [(*rhs, *lhs, Some(true)), (*lhs, *rhs, Some(false))],
            "!=" => [(*lhs, *rhs, None), (*rhs, *lhs, None)],
            _ => return WhileRounds::unbounded(),
        };
        for (counter, limit, is_less) in sides {
            let Some(local) = self.typed().expr_local.get(&counter).copied() else { continue };
            if is_less != Some(false)
                && matches!(op, "<" | ">" | "!=")
                && let Some(counted) = self.rounds_of_pool(label, (local, limit), condition, body)
            {
                return counted;
            }
        }
        let counted = sides.into_iter().find_map(|(counter, limit, is_less)| {
            let local = self.typed().expr_local.get(&counter).copied()?;
            let count = self.counts_by(local, body)?;
            is_less.is_none_or(|is_less| is_less == count.goes_up).then_some((local, limit, count))
        });
        let Some((local, limit, count)) = counted else { return WhileRounds::unbounded() };
        if self.may_repeat_round(label, body, count.span) {
            return WhileRounds::unbounded();
        }
        let var = self.var_of(local);
        if self.moves_elements(var, body) {
            return WhileRounds::unbounded();
        }
        // What is declared outside the loop around is where it was left when that comes round again.
        let is_fresh = count.is_only_change && self.graph.var(var).in_loop == self.loops.last().copied();
        let first = self.initials.get(&var).copied().filter(|_| is_fresh);
        let is_last = matches!(op, "<=" | ">=");
        let end = self.number(limit);
        let rounds = match (first, end, count.step) {
            (Some(first), Some(end), Some(step)) => {
                let (from, to) = if count.goes_up { (first, end) } else { (end, first) };
                let distance = (to + u64::from(is_last)).saturating_sub(from);
                // What asks for one number only passes by it.
                if op == "!=" && (to < from || distance % step > 0) {
                    return WhileRounds::unbounded();
                }
                Rounds::Constant(distance.div_ceil(step))
            }
            _ => Rounds::Bounded,
        };
        let (first, limits) = match count.goes_up {
            // Not every number below the limit has a round.
            _ if count.step != Some(1) => (None, vec![Limit::Unknown]),
            true => (first, self.limits(limit, is_last)),
            // The rounds have the numbers below the one that it begins with.
            false if count.comes_first && end == Some(0) && !is_last => {
                let begins_with = self.declared_as(local).filter(|_| is_fresh);
                let limits = begins_with.map_or_else(|| vec![Limit::Unknown], |begin| self.limits(begin, false));
                (Some(0), limits)
            }
            false => (None, vec![Limit::Unknown]),
        };
        let in_order = count.goes_up && first.is_some() && !self.goes_on_in(label, body, 0..count.span.start);
        let counter = Some((var, first));
        WhileRounds { rounds, counter, limits, counts_down: !count.goes_up, in_order, takes_out: None }
    }

    /// The value that a variable is declared with.
    fn declared_as(&self, local: LocalId) -> Option<ExprId> {
        self.body().stmts().find_map(|stmt| match &stmt.kind {
            StmtKind::Let { pat, init, .. } if self.typed().pat_local.get(pat) == Some(&local) => *init,
            _ => None,
        })
    }

    /// How a loop counts, if the only thing in it that changes a local is one `+= 1`, `-= STEP` or the like as a statement of its own
    /// block.
    fn counts_by(&mut self, local: LocalId, body: ExprId) -> Option<Count> {
        let tree = self.body();
        let typed = self.typed();
        let is_counter = |id: &ExprId| typed.expr_local.get(id) == Some(&local);
        let writes = tree.exprs.iter().filter(|expr| match &expr.kind {
            ExprKind::Assign { place, .. } | ExprKind::AssignOp { place, .. } => is_counter(place),
            ExprKind::Reference { mutable: true, value, .. } => is_counter(value),
            _ => false,
        });
        let writes: Vec<Span> = writes.map(|expr| expr.span).collect();
        if writes.iter().filter(|write| tree.expr(body).span.contains(**write)).count() != 1 {
            return None;
        }
        let ExprKind::Block(block) = &tree.expr(body).kind else { return None };
        // Whether it goes up, and by what.
        let counts = |expr: ExprId| match &tree.expr(expr).kind {
            ExprKind::AssignOp { op: op @ ("+" | "-"), place, value } if is_counter(place) => {
                Some((*op == "+", *value))
            }
            ExprKind::Assign { place, value } if is_counter(place) => match &tree.expr(*value).kind {
                ExprKind::Binary { op: op @ ("+" | "-"), lhs, rhs } if is_counter(lhs) => Some((*op == "+", *rhs)),
                ExprKind::Binary { op: "+", lhs, rhs } if is_counter(rhs) => Some((true, *lhs)),
                ExprKind::MethodCall { receiver, method, args, .. } if is_counter(receiver) => {
                    let [by] = args.as_slice() else { return None };
                    match method.as_str() {
                        "wrapping_add" | "saturating_add" => Some((true, *by)),
                        "wrapping_sub" | "saturating_sub" => Some((false, *by)),
                        _ => None,
                    }
                }
                _ => None,
            },
            _ => None,
        };
        let found = block.stmts.iter().enumerate().find_map(|(number, stmt)| match &stmt.kind {
            StmtKind::Expr { expr, .. } => Some((number, *expr, counts(*expr)?)),
            StmtKind::Let { .. } => None,
        });
        let (number, expr, (goes_up, by)) = found?;
        Some(Count {
            span: tree.expr(expr).span,
            goes_up,
            step: self.step_of_count(by)?,
            comes_first: number == 0,
            is_only_change: writes.len() == 1,
        })
    }

    /// The number that a counter goes on by, if it is certain that it goes on: the inner one is none where that is not known.
    fn step_of_count(&mut self, by: ExprId) -> Option<Option<u64>> {
        // What counts the seconds is a clock, and its rounds are cycles.
        if *self.ty(by) == Ty::Float {
            return None;
        }
        if let Some(number) = self.number(by) {
            return (number > 0).then_some(Some(number));
        }
        match &self.body().expr(by).kind {
            // Nobody counts by a constant that is zero.
            ExprKind::Path(_) => match self.typed().expr_def.get(&by) {
                Some(Def::Value(value)) if !self.program.index.value(*value).item.is_static => Some(None),
                _ => None,
            },
            _ => None,
        }
    }

    /// Whether a `continue` before the count starts the same round again, after something was done with a filter.
    fn may_repeat_round(&self, label: Option<&String>, body: ExprId, count: Span) -> bool {
        let tree = self.body();
        let is_filter = |id: &ExprId| self.program.index.holds_filter(self.ty(*id));
        let ends = tree.within(body).filter(is_filter).map(|id| tree.expr(id).span.end);
        ends.min().is_some_and(|first_use| self.goes_on_in(label, body, first_use..count.start))
    }

    /// Whether a `continue` of a loop stands in a part of its text.
    fn goes_on_in(&self, label: Option<&String>, body: ExprId, part: std::ops::Range<u32>) -> bool {
        let tree = self.body();
        let mut open = vec![(body, false)];
        while let Some((id, is_inner)) = open.pop() {
            let expr = tree.expr(id);
            let is_inner = match &expr.kind {
                ExprKind::Continue { label: to } => {
                    let is_own = to.as_ref().map_or(!is_inner, |to| Some(to) == label);
                    if is_own && part.contains(&expr.span.start) {
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
        tree.within(body).any(|id| match &tree.expr(id).kind {
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
                None => found.push(self.held_and_with_it(end)),
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
                let text = ConstText { text: path.text(), value: None, sides: None };
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

    fn held_and_with_it(&mut self, id: ExprId) -> Limit {
        match (&self.body().expr(id).kind, self.held(id)) {
            (ExprKind::Cast { value, .. }, _) => self.held_and_with_it(*value),
            (_, Limit::Held(place)) => Limit::UpTo(place),
            (_, other) => other,
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
