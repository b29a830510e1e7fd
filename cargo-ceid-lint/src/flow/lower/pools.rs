//! Loops that go over a collection and take elements out of it on the way: `if pool[i].update(x) { i += 1 } else { pool.swap_remove(i); }`.
//! A round either goes on to the next number or puts another element, which had no round yet, where its own was.

use super::loops::WhileRounds;
use super::{Builder, Value};
use crate::flow::{Effect, IndexKey, Limit, LoopId, Place, Rounds, Var};
use crate::syntax::tree::{Block, ExprId, ExprKind, Literal, StmtKind};
use crate::types::LocalId;

/// What a round has done about its number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Turn {
    /// Nothing yet.
    Open,
    /// It has gone on, or taken the element out.
    Done,
    /// It is left, or comes to its end, from inside.
    Left,
}

impl Turn {
    /// What two ways have done where they meet; `None` if only one of them has gone on.
    fn meet(self, other: Self) -> Option<Self> {
        match (self, other) {
            (Self::Left, turn) | (turn, Self::Left) => Some(turn),
            (own, other) => (own == other).then_some(own),
        }
    }
}

/// Such a loop.
struct Pool<'l> {
    label: Option<&'l String>,
    counter: LocalId,
    collection: Place,
    /// The number of elements in use, where that is a variable or a field, and no `len`.
    used: Option<Place>,
}

impl Builder<'_> {
    /// The rounds of a loop that goes over each element of a collection once, and takes some of them out; `None` if it is no such loop.
    pub(super) fn rounds_of_pool(
        &mut self,
        label: Option<&String>,
        (counter, limit): (LocalId, ExprId),
        condition: ExprId,
        body: ExprId,
    ) -> Option<WhileRounds> {
        let pool = self.pool(label, counter, limit, body)?;
        let ExprKind::Block(block) = &self.body().expr(body).kind else { return None };
        // What takes nothing out counts as any other loop.
        if !self.body().within(body).any(|id| self.takes_out(&pool, id)) {
            return None;
        }
        let is_kept = self.leaves_alone(&pool, condition, body);
        let turn = if is_kept { self.turn_of_block(&pool, block) } else { None };
        if turn? == Turn::Open {
            return None;
        }
        let limits = match &pool.used {
            // The elements behind those in use are none of the collection's.
            Some(_) => Vec::new(),
            None => vec![Limit::Elements(pool.collection.clone())],
        };
        let var = self.var_of(counter);
        let first = self.first_of_pool(var, counter, body);
        let takes_out = Some(pool.collection);
        Some(WhileRounds {
            rounds: Rounds::Bounded,
            counter: Some((var, first)),
            limits,
            takes_out,
            ..WhileRounds::unbounded()
        })
    }

    /// An element that is taken out of what a loop goes over, or put behind those in use, owes nothing in its round any more.
    pub(super) fn leaves_pool(&mut self, id: ExprId, method: &str, collection: &Value, args: &[ExprId]) {
        let is_own = |id: &LoopId| {
            let own = self.graph.loop_info(*id).takes_out.as_ref();
            own.is_some() && own == collection.place.as_ref()
        };
        let (Some(place), ([number], "remove" | "swap_remove") | ([number, _], "swap")) =
            (&collection.place, (args, method))
        else {
            return;
        };
        if self.at.is_none() || !self.loops.iter().any(is_own) {
            return;
        }
        if let Some(key @ IndexKey::Var(_)) = self.index_key(*number) {
            self.emit(Effect::Reset { place: place.element(key), full: true }, self.span(id));
        }
    }

    fn pool<'l>(
        &mut self,
        label: Option<&'l String>,
        counter: LocalId,
        limit: ExprId,
        body: ExprId,
    ) -> Option<Pool<'l>> {
        let tree = self.body();
        if let ExprKind::MethodCall { receiver, method, args, .. } = &tree.expr(limit).kind {
            let is_len = method == "len" && args.is_empty();
            let collection = self.static_place(*receiver).filter(|_| is_len)?;
            return Some(Pool { label, counter, collection, used: None });
        }
        let used = self.static_place(limit)?;
        let swapped = tree.within(body).find_map(|id| match &tree.expr(id).kind {
            ExprKind::MethodCall { receiver, method, .. } if method == "swap" => Some(*receiver),
            _ => None,
        });
        let collection = self.static_place(swapped?)?;
        Some(Pool { label, counter, collection, used: Some(used) })
    }

    /// Whether nothing in a loop but what the idiom is made of can change which elements there are, or their order.
    fn leaves_alone(&mut self, pool: &Pool<'_>, condition: ExprId, body: ExprId) -> bool {
        let tree = self.body();
        let all: Vec<ExprId> = [condition, body].into_iter().flat_map(|id| tree.within(id)).collect();
        let mut plain: Vec<ExprId> = Vec::new();
        for id in &all {
            match &tree.expr(*id).kind {
                ExprKind::Field { base, .. } => plain.push(*base),
                ExprKind::Index { base, .. } => plain.push(*base),
                ExprKind::MethodCall { receiver, method, .. }
                    if matches!(
                        method.as_str(),
                        "len" | "is_empty" | "get" | "get_mut" | "swap" | "swap_remove" | "remove"
                    ) =>
                {
                    plain.push(*receiver);
                }
                ExprKind::Binary { lhs, rhs, .. } => plain.extend([*lhs, *rhs]),
                ExprKind::AssignOp { place, .. } => plain.push(*place),
                ExprKind::Opaque(_) | ExprKind::Unknown { .. } => return false,
                ExprKind::Reference { mutable: true, value, .. }
                    if self.is_number_of(pool, *value) || self.is_used(pool, *value) =>
                {
                    return false;
                }
                _ => {}
            }
        }
        let used = pool.used.clone();
        all.into_iter().filter(|id| !plain.contains(id)).all(|id| {
            let Some(place) = self.static_place(id) else { return true };
            // An argument of the idiom's own `swap`.
            if used.as_ref() == Some(&place) {
                return true;
            }
            let holds = |own: &Place| own.lies_at(&place);
            !holds(&pool.collection) && !used.as_ref().is_some_and(holds)
        })
    }

    fn turn_of_block(&mut self, pool: &Pool<'_>, block: &Block) -> Option<Turn> {
        let mut turn = Turn::Open;
        let mut is_shrunk = false;
        let tails = block.tail.iter().map(|tail| (*tail, None));
        let parts = block.stmts.iter().filter_map(|stmt| match &stmt.kind {
            StmtKind::Expr { expr, .. } => Some((*expr, stmt.cfg.as_ref())),
            StmtKind::Let { init, .. } => init.map(|init| (init, stmt.cfg.as_ref())),
        });
        for (part, cfg) in parts.chain(tails).collect::<Vec<_>>() {
            if turn != Turn::Open {
                // By now the number is that of another element.
                if turn == Turn::Done && self.mentions_number(pool, part) {
                    return None;
                }
                if self.begins_next(pool, part) {
                    turn = Turn::Left;
                    continue;
                }
                match self.turn_of(pool, part, &mut false)? {
                    Turn::Open => continue,
                    Turn::Left if turn == Turn::Done => turn = Turn::Left,
                    _ => return None,
                }
                continue;
            }
            turn = self.turn_of(pool, part, &mut is_shrunk)?;
            if turn != Turn::Open && cfg.is_some() {
                return None;
            }
        }
        // What has one element less has to have moved that out of the way.
        (!is_shrunk || turn != Turn::Open).then_some(turn)
    }

    /// What an expression does about the number of its round, if that can be told.
    fn turn_of(&mut self, pool: &Pool<'_>, id: ExprId, is_shrunk: &mut bool) -> Option<Turn> {
        let tree = self.body();
        match &tree.expr(id).kind {
            ExprKind::Block(block) if block.label.is_none() => return self.turn_of_block(pool, block),
            ExprKind::If { condition, then, otherwise } => {
                self.is_quiet(pool, *condition).then_some(())?;
                let then = self.turn_of(pool, *then, &mut false)?;
                let otherwise = match otherwise {
                    Some(otherwise) => self.turn_of(pool, *otherwise, &mut false)?,
                    None => Turn::Open,
                };
                return then.meet(otherwise);
            }
            ExprKind::Match { scrutinee, arms } => {
                self.is_quiet(pool, *scrutinee).then_some(())?;
                let mut turn = Turn::Left;
                for arm in arms {
                    arm.guard.is_none_or(|guard| self.is_quiet(pool, guard)).then_some(())?;
                    turn = turn.meet(self.turn_of(pool, arm.body, &mut false)?)?;
                }
                return Some(turn);
            }
            ExprKind::Break { .. } | ExprKind::Return(_) => return self.is_quiet(pool, id).then_some(Turn::Left),
            _ => {}
        }
        if self.goes_on(pool, id) {
            return Some(Turn::Done);
        }
        if self.shrinks(pool, id) {
            return (!std::mem::replace(is_shrunk, true)).then_some(Turn::Open);
        }
        let removals = tree.within(id).filter(|id| self.takes_out(pool, *id)).count();
        match removals {
            0 => self.is_quiet(pool, id).then_some(Turn::Open),
            // It runs once where nothing in the expression decides whether it does.
            1 if self.is_straight(id) && (pool.used.is_none() || *is_shrunk) => Some(Turn::Done),
            _ => None,
        }
    }

    /// `continue`
    fn begins_next(&self, pool: &Pool<'_>, id: ExprId) -> bool {
        let ExprKind::Continue { label } = &self.body().expr(id).kind else { return false };
        label.is_none() || label.as_ref() == pool.label
    }

    /// `i += 1`
    fn goes_on(&self, pool: &Pool<'_>, id: ExprId) -> bool {
        let tree = self.body();
        let is_one = |id: ExprId| matches!(tree.expr(id).kind, ExprKind::Literal(Literal::Int(Some(1), _)));
        match &tree.expr(id).kind {
            ExprKind::AssignOp { op: "+", place, value } => self.is_number_of(pool, *place) && is_one(*value),
            ExprKind::Assign { place, value } if self.is_number_of(pool, *place) => match &tree.expr(*value).kind {
                ExprKind::Binary { op: "+", lhs, rhs } => self.is_number_of(pool, *lhs) && is_one(*rhs),
                _ => false,
            },
            _ => false,
        }
    }

    /// `n -= 1`
    fn shrinks(&mut self, pool: &Pool<'_>, id: ExprId) -> bool {
        let tree = self.body();
        let ExprKind::AssignOp { op: "-", place, value } = &tree.expr(id).kind else { return false };
        let is_one = matches!(tree.expr(*value).kind, ExprKind::Literal(Literal::Int(Some(1), _)));
        is_one && pool.used.is_some() && self.static_place(*place) == pool.used
    }

    /// `pool.swap_remove(i)`, or `pool.swap(i, n)` where there is one less in use.
    fn takes_out(&mut self, pool: &Pool<'_>, id: ExprId) -> bool {
        let tree = self.body();
        let ExprKind::MethodCall { receiver, method, args, .. } = &tree.expr(id).kind else { return false };
        if self.static_place(*receiver).as_ref() != Some(&pool.collection) {
            return false;
        }
        match (method.as_str(), args.as_slice(), &pool.used) {
            ("swap_remove" | "remove", [number], None) => self.is_number_of(pool, *number),
            ("swap", [number, last], Some(used)) => {
                self.is_number_of(pool, *number) && self.static_place(*last).as_ref() == Some(used)
            }
            _ => false,
        }
    }

    /// Whether an expression neither changes the number nor the collection, and does not begin the next round.
    fn is_quiet(&mut self, pool: &Pool<'_>, id: ExprId) -> bool {
        let tree = self.body();
        tree.within(id).all(|id| match &tree.expr(id).kind {
            ExprKind::Assign { place, .. } => !self.is_number_of(pool, *place) && !self.is_used(pool, *place),
            ExprKind::AssignOp { place, .. } => !self.is_number_of(pool, *place) && !self.is_used(pool, *place),
            ExprKind::MethodCall { receiver, method, .. } => {
                !matches!(method.as_str(), "swap" | "swap_remove" | "remove")
                    || self.static_place(*receiver).as_ref() != Some(&pool.collection)
            }
            // That of a loop inside is another matter, and is not told apart.
            ExprKind::Continue { label } => label.is_some() && label.as_ref() != pool.label,
            _ => true,
        })
    }

    /// Whether nothing in an expression decides whether a part of it runs.
    fn is_straight(&self, id: ExprId) -> bool {
        let tree = self.body();
        tree.within(id).all(|id| match &tree.expr(id).kind {
            ExprKind::If { .. }
            | ExprKind::Match { .. }
            | ExprKind::Closure(_)
            | ExprKind::Loop { .. }
            | ExprKind::While { .. }
            | ExprKind::For { .. }
            | ExprKind::Continue { .. }
            | ExprKind::Assign { .. }
            | ExprKind::AssignOp { .. } => false,
            ExprKind::Binary { op, .. } => !matches!(*op, "&&" | "||"),
            ExprKind::Block(block) => block.label.is_none(),
            _ => true,
        })
    }

    fn is_number_of(&self, pool: &Pool<'_>, id: ExprId) -> bool {
        self.typed().expr_local.get(&id) == Some(&pool.counter)
    }

    fn is_used(&mut self, pool: &Pool<'_>, id: ExprId) -> bool {
        pool.used.is_some() && self.static_place(id) == pool.used
    }

    fn mentions_number(&self, pool: &Pool<'_>, id: ExprId) -> bool {
        self.body().within(id).any(|id| self.is_number_of(pool, id))
    }

    /// Whether everything in the function that changes a local stands in a loop, but its declaration.
    pub(super) fn is_changed_only_in(&self, local: LocalId, body: ExprId) -> bool {
        let tree = self.body();
        let is_it = |id: &ExprId| self.typed().expr_local.get(id) == Some(&local);
        let within = tree.expr(body).span;
        tree.exprs.iter().all(|expr| match &expr.kind {
            ExprKind::Assign { place, .. } | ExprKind::AssignOp { place, .. } => {
                !is_it(place) || within.contains(expr.span)
            }
            ExprKind::Reference { mutable: true, value, .. } => !is_it(value),
            _ => true,
        })
    }

    /// The first number of such a loop's counter, if that is known.
    pub(super) fn first_of_pool(&self, var: Var, local: LocalId, body: ExprId) -> Option<u64> {
        let is_fresh =
            self.is_changed_only_in(local, body) && self.graph.var(var).in_loop == self.loops.last().copied();
        self.initials.get(&var).copied().filter(|_| is_fresh)
    }
}
