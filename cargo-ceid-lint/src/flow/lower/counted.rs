//! Comparisons of the counter of a loop whose rounds are known: which of its numbers they hold for.

use super::{Builder, Value};
use crate::flow::{CycleKind, Head, LoopId, PAST, Place, Rounds, SubjectId, Var};
use crate::syntax::tree::{ExprId, ExprKind, PatId};

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
        let info = self.graph.loops.iter().find(|info| info.counter.is_some_and(|(var, _)| var == counter))?;
        let Rounds::Constant(count @ ..=MAX_ROUNDS) = info.rounds else { return None };
        let numbers: Option<Vec<u64>> = (1..=count).map(|round| info.number_in(round)).collect();
        let mut heads = Vec::new();
        for number in numbers? {
            let (left, right) = (self.number_with(lhs, counter, number)?, self.number_with(rhs, counter, number)?);
            let holds = match op {
                "==" => left == right,
                "!=" => left != right,
                "<" => left < right,
                "<=" => left <= right,
                ">" => left > right,
                ">=" => left >= right,
                _ => return None,
            };
            heads.extend(holds.then(|| number.to_string()));
        }
        Some((counter, heads))
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

    /// The counter of a loop around that an expression names.
    fn counter_in(&self, id: ExprId) -> Option<Var> {
        let body = self.body();
        match &body.expr(id).kind {
            ExprKind::Path(_) => {
                let local = self.typed().expr_local.get(&id)?;
                let var = self.number_behind(*self.frames[self.frame].vars.get(local)?);
                let counts = |info: &crate::flow::LoopInfo| info.counter.is_some_and(|(counter, _)| counter == var);
                self.loops.iter().any(|id| counts(self.graph.loop_info(*id))).then_some(var)
            }
            ExprKind::Binary { lhs, rhs, .. } => self.counter_in(*lhs).or_else(|| self.counter_in(*rhs)),
            ExprKind::Cast { value, .. } | ExprKind::Deref(value) => self.counter_in(*value),
            _ => None,
        }
    }

    /// The whole number that an expression is in the round in which a counter has that number.
    fn number_with(&mut self, id: ExprId, counter: Var, number: u64) -> Option<u64> {
        if self.counter_in(id) != Some(counter) {
            return self.number(id);
        }
        let body = self.body();
        match &body.expr(id).kind {
            ExprKind::Path(_) => Some(number),
            ExprKind::Cast { value, .. } | ExprKind::Deref(value) => self.number_with(*value, counter, number),
            ExprKind::Binary { op, lhs, rhs } => {
                let (left, right) =
                    (self.number_with(*lhs, counter, number)?, self.number_with(*rhs, counter, number)?);
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
