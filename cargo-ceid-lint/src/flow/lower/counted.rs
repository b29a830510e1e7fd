//! Comparisons of the counter of a loop whose rounds are known: which of its numbers they hold for.

use super::{Builder, Value};
use crate::flow::{CycleKind, Effect, Head, IndexKey, LoopId, NodeId, PAST, Place, Rounds, SubjectId, Var};
use crate::syntax::tree::{Body, ExprId, ExprKind, PatId, Stmt, StmtKind};

/// How many rounds are told apart.
const MAX_ROUNDS: u64 = 16;

impl Builder<'_> {
    /// The counter that a comparison asks about and nothing else that changes, with the numbers for which it holds.
    pub(super) fn counted(&mut self, op: &str, lhs: ExprId, rhs: ExprId) -> Option<(Var, Vec<Head>)> {
        // What is compared with a number is told by its head.
        let is_plain = |id: ExprId| matches!(self.body().expr(id).kind, ExprKind::Path(_) | ExprKind::Literal(_));
        if matches!(op, "==" | "!=") && is_plain(lhs) && is_plain(rhs) {
            return None;
        }
        let counter = self.counter_in(lhs).or_else(|| self.counter_in(rhs))?;
        let mut heads = Vec::new();
        for number in self.counted_numbers(counter)? {
            let (left, right) =
                (self.number_with(lhs, &[(counter, number)])?, self.number_with(rhs, &[(counter, number)])?);
            heads.extend(compares(op, left, right)?.then(|| number.to_string()));
        }
        Some((counter, heads))
    }

    /// A comparison of the counters of two loops whose rounds are known: which pairs of their numbers it holds for is asked one number
    /// after the other, `for i in 0..3 { for j in 0..3 { if i == j { … } } }`. Answers whether it is one.
    pub(super) fn counters_compared(&mut self, id: ExprId, op: &str, [lhs, rhs]: [ExprId; 2], no: NodeId) -> bool {
        if let Some(parts) = self.compared_in_parts(op, lhs, rhs) {
            for (lhs, rhs) in parts {
                self.comparison(id, op, lhs, rhs, no);
            }
            return true;
        }
        let mut counters = Vec::new();
        self.counters_in(lhs, &mut counters);
        self.counters_in(rhs, &mut counters);
        // What is asked last tells which round of the inner loop it is.
        counters.sort_by_key(|counter| self.depth_of_counter(*counter));
        counters.dedup();
        let [outer, inner] = *counters.as_slice() else { return false };
        let (Some(outers), Some(inners)) = (self.counted_numbers(outer), self.counted_numbers(inner)) else {
            return false;
        };
        // The numbers of the outer counter that have the same of the inner one.
        let mut asked: Vec<(Vec<Head>, Vec<Head>)> = Vec::new();
        for own in outers {
            let mut heads = Vec::new();
            for other in &inners {
                let numbers = [(outer, own), (inner, *other)];
                let sides = (self.number_with(lhs, &numbers), self.number_with(rhs, &numbers));
                let (Some(left), Some(right)) = sides else { return false };
                let Some(holds) = compares(op, left, right) else { return false };
                heads.extend(holds.then(|| other.to_string()));
            }
            match asked.iter_mut().find(|(_, known)| *known == heads) {
                Some((owns, _)) => owns.push(own.to_string()),
                None => asked.push((vec![own.to_string()], heads)),
            }
        }
        asked.sort_by_key(|(_, heads)| heads.len().min(1));
        let Some(last) = asked.len().checked_sub(1) else { return false };
        let (span, text, about) = (self.span(id), self.text(id), self.about(id));
        let holds = self.add_node(Effect::Nothing, span);
        for (at, (owns, heads)) in asked.into_iter().enumerate() {
            let mut others = None;
            if at < last {
                let (is_own, rest) = self.branch_on_number(outer, &owns, span, text.clone(), about.clone());
                others = Some(rest);
                self.resume(is_own);
            }
            match heads.len() {
                0 => self.jump(no),
                all if all == inners.len() => self.jump(holds),
                _ => {
                    let (yes, failed) = self.branch_on_number(inner, &heads, span, text.clone(), about.clone());
                    self.link(yes, holds);
                    self.link(failed, no);
                }
            }
            if let Some(others) = others {
                self.resume(others);
            }
        }
        self.resume_if_reached(holds);
        true
    }

    /// How many loops are around the one that has this counter.
    fn depth_of_counter(&self, counter: Var) -> Option<usize> {
        let is_own = |id: &LoopId| self.graph.loop_info(*id).counter.is_some_and(|(own, _)| own == counter);
        self.loops.iter().position(is_own)
    }

    /// What is compared part by part: `(row, column) == (0, 2)`.
    fn compared_in_parts(&self, op: &str, lhs: ExprId, rhs: ExprId) -> Option<Vec<(ExprId, ExprId)>> {
        let body = self.body();
        let (ExprKind::Tuple(left), ExprKind::Tuple(right)) = (&body.expr(lhs).kind, &body.expr(rhs).kind) else {
            return None;
        };
        let counts = left.iter().chain(right).any(|part| self.counter_in(*part).is_some());
        (op == "==" && counts && left.len() == right.len())
            .then(|| left.iter().copied().zip(right.iter().copied()).collect())
    }

    /// The numbers that a counter has in the rounds of its loop, if they are known and few.
    fn counted_numbers(&self, counter: Var) -> Option<Vec<u64>> {
        let info = self.graph.loops.iter().find(|info| info.counter.is_some_and(|(var, _)| var == counter))?;
        let Rounds::Constant(count @ ..=MAX_ROUNDS) = info.rounds else { return None };
        (1..=count).map(|round| info.number_in(round)).collect()
    }

    /// The key of an element by the counter of the loop furthest out that has its number. Of a place with two keys each has its own.
    pub(super) fn by_outer_counter(&self, key: IndexKey, element: ExprId) -> IndexKey {
        let IndexKey::Var(var) = key else { return key };
        let span = self.span(element);
        let is_of_two = self.body().exprs.iter().any(|expr| match &expr.kind {
            ExprKind::Index { base, .. } => {
                let base = self.span(*base);
                base.contains(span) || expr.span != span && span.contains(expr.span) && span.start == expr.span.start
            }
            _ => false,
        });
        match self.equal_counter(element, var) {
            Some(other) if !is_of_two => IndexKey::Var(other),
            _ => key,
        }
    }

    /// The counter of a loop further out that has the same number wherever control comes to an expression: behind `if row == column`.
    fn equal_counter(&self, id: ExprId, counter: Var) -> Option<Var> {
        let body = self.body();
        let own = self.depth_of_counter(counter).filter(|depth| *depth > 0)?;
        let span = body.expr(id).span;
        let other = |lhs: ExprId, rhs: ExprId| {
            let (left, right) = (self.counter_named(lhs)?, self.counter_named(rhs)?);
            let other = if left == counter { right } else { left };
            let is_it = (left == counter) != (right == counter);
            (is_it && self.depth_of_counter(other)? < own).then_some(other)
        };
        body.exprs.iter().find_map(|expr| match &expr.kind {
            ExprKind::If { condition, then, .. } if body.expr(*then).span.contains(span) => {
                sides_of(body, *condition, "&&", "==").into_iter().find_map(|(lhs, rhs)| other(lhs, rhs))
            }
            ExprKind::Block(block) if expr.span.contains(span) => {
                let leaves = |stmt: &Stmt| match stmt.kind {
                    StmtKind::Expr { expr, .. } if body.expr(expr).span.end <= span.start => left_unless(body, expr),
                    _ => None,
                };
                let conditions = block.stmts.iter().filter_map(leaves);
                conditions
                    .flat_map(|condition| sides_of(body, condition, "||", "!="))
                    .find_map(|(lhs, rhs)| other(lhs, rhs))
            }
            _ => None,
        })
    }

    /// The counter of a loop around that an expression is the name of.
    fn counter_named(&self, id: ExprId) -> Option<Var> {
        let is_name = matches!(self.body().expr(id).kind, ExprKind::Path(_));
        self.counter_in(id).filter(|counter| is_name && !self.is_assigned(*counter))
    }

    /// Whether a comparison holds in one round at most of a loop around: the number of the round is asked for one that stays the
    /// same, `i + 1 == n`.
    pub(super) fn holds_in_one_round(&self, op: &str, lhs: ExprId, rhs: ExprId) -> bool {
        let counters = self.loops.iter().filter_map(|id| {
            let info = self.graph.loop_info(*id);
            let (counter, _) = info.counter?;
            (info.kind == CycleKind::For && info.in_order).then_some(counter)
        });
        let asks = |counter: Var, own: ExprId, other: ExprId| {
            let mut read = self.body().within(other);
            self.counts_with(own, counter) && !read.any(|id| self.counts_with(id, counter))
        };
        matches!(op, "==" | "!=")
            && counters.into_iter().any(|counter| asks(counter, lhs, rhs) || asks(counter, rhs, lhs))
    }

    /// Notes that a comparison holds in one round at most.
    pub(super) fn note_one_round(&mut self, subject: SubjectId) {
        let heads = ["true", "false", PAST].map(str::to_owned);
        for head in &heads {
            self.head_bit(subject, head);
        }
        self.graph.subjects[subject.0 as usize].total = Some(heads.to_vec());
    }

    /// A parameter that gets the number of the round asks for that number under another name.
    pub(super) fn note_counter(&mut self, pat: PatId, value: &Value) {
        let Some(local) = self.typed().pat_local.get(&pat).copied() else { return };
        let counts = |var: &Var| {
            let is_it = |id: &LoopId| self.graph.loop_info(*id).counter.is_some_and(|(counter, _)| counter == *var);
            self.loops.iter().any(is_it)
        };
        let counter = value.same_as.filter(counts);
        let frame = &mut self.frames[self.frame];
        match counter.filter(|_| !frame.mutated.contains(&local)) {
            Some(counter) => frame.stand_ins.insert(local, Place::var(counter)),
            None => frame.stand_ins.remove(&local),
        };
    }

    /// The first counter of a loop around that an expression names.
    fn counter_in(&self, id: ExprId) -> Option<Var> {
        let mut found = Vec::new();
        self.counters_in(id, &mut found);
        found.first().copied()
    }

    fn counters_in(&self, id: ExprId, found: &mut Vec<Var>) {
        let body = self.body();
        match &body.expr(id).kind {
            ExprKind::Path(_) => {
                let local = self.typed().expr_local.get(&id);
                let var = local.and_then(|local| self.frames[self.frame].vars.get(local));
                let var = var.map(|var| self.number_behind(*var));
                found.extend(var.filter(|var| self.depth_of_counter(*var).is_some()));
            }
            ExprKind::Binary { lhs, rhs, .. } => {
                self.counters_in(*lhs, found);
                self.counters_in(*rhs, found);
            }
            ExprKind::Cast { value, .. } | ExprKind::Deref(value) => self.counters_in(*value, found),
            _ => {}
        }
    }

    /// The whole number that an expression is in the round in which counters have these numbers.
    fn number_with(&mut self, id: ExprId, numbers: &[(Var, u64)]) -> Option<u64> {
        let Some(counter) = self.counter_in(id) else { return self.number(id) };
        let body = self.body();
        match &body.expr(id).kind {
            ExprKind::Path(_) => numbers.iter().find(|(own, _)| *own == counter).map(|(_, number)| *number),
            ExprKind::Cast { value, .. } | ExprKind::Deref(value) => self.number_with(*value, numbers),
            ExprKind::Binary { op, lhs, rhs } => {
                let (left, right) = (self.number_with(*lhs, numbers)?, self.number_with(*rhs, numbers)?);
                match *op {
                    "+" => left.checked_add(right),
                    "-" => left.checked_sub(right),
                    "*" => left.checked_mul(right),
                    "/" => left.checked_div(right),
                    "%" => left.checked_rem(right),
                    "&" => Some(left & right),
                    _ => None,
                }
            }
            _ => None,
        }
    }
}

/// What a comparison of two numbers gives.
fn compares(op: &str, left: u64, right: u64) -> Option<bool> {
    Some(match op {
        "==" => left == right,
        "!=" => left != right,
        "<" => left < right,
        "<=" => left <= right,
        ">" => left > right,
        ">=" => left >= right,
        _ => return None,
    })
}

/// The sides of the comparisons by one operator that others connect into a condition.
fn sides_of(body: &Body, condition: ExprId, connective: &str, comparison: &str) -> Vec<(ExprId, ExprId)> {
    match &body.expr(condition).kind {
        ExprKind::Binary { op, lhs, rhs } if *op == connective => {
            let mut sides = sides_of(body, *lhs, connective, comparison);
            sides.extend(sides_of(body, *rhs, connective, comparison));
            sides
        }
        ExprKind::Binary { op, lhs, rhs } if *op == comparison => vec![(*lhs, *rhs)],
        _ => Vec::new(),
    }
}

/// The condition under which a statement leaves what it stands in, and does nothing else: `if row != column { continue; }`.
fn left_unless(body: &Body, id: ExprId) -> Option<ExprId> {
    let ExprKind::If { condition, then, otherwise: None } = &body.expr(id).kind else { return None };
    let ExprKind::Block(block) = &body.expr(*then).kind else { return None };
    let last = block.tail.or_else(|| match block.stmts.last()?.kind {
        StmtKind::Expr { expr, .. } => Some(expr),
        StmtKind::Let { .. } => None,
    })?;
    let leaves =
        matches!(body.expr(last).kind, ExprKind::Continue { .. } | ExprKind::Break { .. } | ExprKind::Return(_));
    leaves.then_some(*condition)
}
