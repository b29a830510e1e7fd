//! Loops: how often they run, and what their heads bind.

mod counting;
mod drained;
mod filled;
mod once_or_never;

use rustc_hash::FxHashMap;

use super::exits::{Scope, ScopeKind};
use super::sources::Item;
use super::{Builder, Value};
use crate::flow::{Caller, CycleKind, Effect, Limit, LoopId, LoopInfo, NodeId, Place, Rounds, Var};
use crate::index::Ty;
use crate::source::Span;
use crate::syntax::tree::{Arm, ExprId, ExprKind, PatId, PatKind, StmtKind};

/// How often a `while` runs, what counts its rounds from which number on, and up to what.
pub(super) struct WhileRounds {
    pub(super) rounds: Rounds,
    pub(super) counter: Option<(Var, Option<u64>)>,
    pub(super) limits: Vec<Limit>,
    pub(super) counts_down: bool,
    /// Whether each round has the number that follows that of the one before.
    pub(super) in_order: bool,
    /// The collection out of which the rounds take elements.
    pub(super) takes_out: Option<Place>,
}

impl WhileRounds {
    pub(super) fn unbounded() -> Self {
        Self {
            rounds: Rounds::Unbounded,
            counter: None,
            limits: Vec::new(),
            counts_down: false,
            in_order: false,
            takes_out: None,
        }
    }

    /// The same where something else may end it earlier.
    pub(super) fn at_most(self) -> Self {
        Self {
            rounds: Rounds::Bounded,
            counter: None,
            limits: vec![Limit::Unknown],
            in_order: false,
            takes_out: None,
            ..self
        }
    }

    /// Tells a loop what is known of its rounds.
    pub(super) fn tell(self, info: &mut LoopInfo) {
        info.bound.extend(self.counter.map(|(var, _)| var));
        (info.rounds, info.counter, info.limits) = (self.rounds, self.counter, self.limits);
        (info.counts_down, info.in_order, info.takes_out) = (self.counts_down, self.in_order, self.takes_out);
    }
}

impl Builder<'_> {
    pub(super) fn add_loop(&mut self, info: LoopInfo) -> LoopId {
        let id = LoopId(u32::try_from(self.graph.loops.len()).expect("fewer than 2^32 loops"));
        self.graph.loops.push(info);
        id
    }

    /// Whether the code stands in another function than the one whose graph is built.
    pub(super) fn is_foreign(&self) -> bool {
        self.frames[self.frame].function != self.graph.function
    }

    pub(super) fn push_loop_scope(&mut self, label: Option<&String>, after: NodeId, again: NodeId, span: Span) {
        let value = self.temporary(Ty::Unknown, span);
        let kind = ScopeKind::Breakable {
            label: label.cloned(),
            is_loop: true,
            frame_depth: self.depth,
            after,
            again: Some(again),
            value,
        };
        self.scopes.push(Scope { kind, guards: Vec::new() });
    }

    pub(super) fn pop_loop_scope(&mut self) {
        self.scopes.pop();
    }

    /// The variable for what `break` gives in the innermost loop.
    pub(super) fn value_of_loop(&self) -> Option<Var> {
        match self.scopes.last().map(|scope| &scope.kind) {
            Some(ScopeKind::Breakable { value, .. }) => Some(*value),
            _ => None,
        }
    }

    /// Leaves the innermost loop.
    pub(super) fn break_out(&mut self, _span: Span) {
        let after = self.scopes.iter().rev().find_map(|scope| match &scope.kind {
            ScopeKind::Breakable { is_loop: true, after, .. } => Some(*after),
            _ => None,
        });
        if let Some(after) = after {
            self.jump(after);
        }
        self.at = None;
    }

    /// A loop of which only this much is known.
    pub(super) fn plain_loop(&self, kind: CycleKind, keyword: Span, rounds: Rounds, text: String) -> LoopInfo {
        LoopInfo {
            kind,
            keyword,
            parent: self.loops.last().copied(),
            begun_in: self.loops.last().copied().or(self.detached_in),
            head: NodeId(0),
            rounds,
            items: Vec::new(),
            chained: Vec::new(),
            takes_out: None,
            counter: None,
            counts_down: false,
            is_mirrored: false,
            limits: Vec::new(),
            bound: Vec::new(),
            indexes: Vec::new(),
            sampled: Vec::new(),
            taken_by_count: Vec::new(),
            filled: Vec::new(),
            over: None,
            passes_over: false,
            stops_by: None,
            is_table: false,
            in_order: false,
            drains: false,
            is_entered: false,
            is_lent: false,
            goes_round: self.is_foreign(),
            is_foreign: self.is_foreign(),
            closure: None,
            caller: Caller::Code,
            handed: Vec::new(),
            directive: self.program.directive(keyword),
            text,
        }
    }

    /// Finds the loops whose head something in them leads back to.
    pub(super) fn find_rounds(&mut self) {
        let heads: FxHashMap<NodeId, LoopId> =
            (0u32..).zip(&self.graph.loops).map(|(id, info)| (info.head, LoopId(id))).collect();
        for id in self.graph.node_ids() {
            let node = self.graph.node(id);
            let begun = node.next.iter().filter_map(|next| heads.get(next).copied());
            let again: Vec<LoopId> = begun.filter(|begun| self.graph.is_within(node.in_loop, *begun)).collect();
            for loop_id in again {
                self.graph.loops[loop_id.0 as usize].goes_round = true;
            }
        }
    }

    pub(super) fn begin_loop(&mut self, kind: CycleKind, keyword: Span, rounds: Rounds, text: String) -> LoopId {
        let info = self.plain_loop(kind, keyword, rounds, text);
        let id = self.add_loop(info);
        self.emit(Effect::LoopEnter(id), keyword);
        id
    }

    pub(super) fn loop_expr(&mut self, id: ExprId, label: Option<&String>, keyword: Span, body: ExprId) -> Value {
        if let Some((pat, asked, inside)) = self.next_or_break(body)
            && let Some(value) = self.loop_over_next(CycleKind::Loop, label, keyword, (pat, asked), inside)
        {
            return value;
        }
        if let Some(value) = self.counting_loop(id, label, keyword, body) {
            return value;
        }
        let this_loop = self.begin_loop(CycleKind::Loop, keyword, Rounds::Unbounded, "loop".to_owned());
        let after = self.add_node(Effect::Nothing, self.span(id));
        self.loops.push(this_loop);
        let head = self.emit(Effect::LoopHead(this_loop), keyword);
        self.graph.loops[this_loop.0 as usize].head = head;
        self.push_loop_scope(label, after, head, keyword);
        let value = self.value_of_loop();
        self.expr(body);
        self.pop_loop_scope();
        self.jump(head);
        self.loops.pop();
        self.resume_if_reached(after);
        Value { place: value.map(Place::var), same_as: value, ..Value::default() }
    }

    pub(super) fn while_expr(
        &mut self,
        id: ExprId,
        label: Option<&String>,
        keyword: Span,
        condition: ExprId,
        body: ExprId,
    ) -> Value {
        if let ExprKind::Let { pat, value } = &self.body().expr(condition).kind
            && let Some(value) = self.loop_over_next(CycleKind::While, label, keyword, (*pat, *value), body)
        {
            return value;
        }
        if let ExprKind::Let { pat, value } = &self.body().expr(condition).kind
            && self.loop_over_popped(label, keyword, (*pat, *value), body)
        {
            return Value::default();
        }
        let has_round = self.has_first_round(condition);
        let mut counted = self.rounds_of_while(label, condition, body);
        let is_counted = counted.counter.is_some();
        let text = self.text(condition);
        let drains = self.is_drain(condition);
        if drains {
            counted.rounds = Rounds::Bounded;
        }
        let this_loop = self.begin_loop(CycleKind::While, keyword, Rounds::Unbounded, text);
        let info = &mut self.graph.loops[this_loop.0 as usize];
        info.drains = drains;
        counted.tell(info);
        let after = self.add_node(Effect::Nothing, self.span(id));
        self.loops.push(this_loop);
        let head = self.emit(Effect::LoopHead(this_loop), keyword);
        self.graph.loops[this_loop.0 as usize].head = head;
        let done = self.add_node(Effect::Nothing, keyword);
        self.push_loop_scope(label, after, head, keyword);
        self.open_block();
        if is_counted {
            // The rounds are counted, so the condition says nothing more.
            let round = self.add_node(Effect::Nothing, keyword);
            self.link(head, round);
            self.link(head, done);
            self.resume(round);
        } else {
            self.condition(condition, done);
        }
        self.note_bound(this_loop, condition);
        self.note_sampled(this_loop, body);
        self.note_drained(this_loop, condition, body);
        self.expr(body);
        self.close_block(keyword);
        self.pop_loop_scope();
        self.jump(head);
        self.loops.pop();
        if self.is_left_at_its_head(head, has_round) {
            self.resume_if_reached(done);
            self.jump(after);
        }
        self.resume_if_reached(after);
        Value::default()
    }

    /// Whether a loop, all of whose round is there by now, may be left at its head: one that certainly has a round, and whose round never
    /// comes to its end, is not.
    pub(super) fn is_left_at_its_head(&self, head: NodeId, has_round: bool) -> bool {
        !has_round || self.graph.nodes[head.0 as usize..].iter().any(|node| node.next.contains(&head))
    }

    /// Whether a `while let` takes from what has something in it: `while let Some(filter) = filters.pop() { … }`.
    fn has_first_round(&mut self, condition: ExprId) -> bool {
        let tree = self.body();
        let ExprKind::Let { pat, value } = &tree.expr(condition).kind else { return false };
        let PatKind::TupleStruct(_, inner) = &tree.pat(*pat).kind else { return false };
        let value = *value;
        inner.iter().all(|inner| self.is_irrefutable(*inner)) && self.is_surely_entered(value)
    }

    /// The names that the head of a `while let` binds.
    fn note_bound(&mut self, this_loop: LoopId, condition: ExprId) {
        let body = self.body();
        let mut open = vec![condition];
        while let Some(at) = open.pop() {
            match &body.expr(at).kind {
                ExprKind::Let { pat, .. } => {
                    let vars = self.vars_of(*pat);
                    self.graph.loops[this_loop.0 as usize].bound.extend(vars);
                }
                ExprKind::Binary { op: "&&", lhs, rhs } => open.extend([*lhs, *rhs]),
                _ => {}
            }
        }
    }

    /// The pattern, the question and the arm of a body that is `match iter.next() { Some(x) => …, None => break }`.
    fn next_or_break(&self, body: ExprId) -> Option<(PatId, ExprId, ExprId)> {
        let tree = self.body();
        let ExprKind::Block(block) = &tree.expr(body).kind else { return None };
        let only = match (block.stmts.as_slice(), block.tail) {
            ([], Some(tail)) => tail,
            ([stmt], None) => match stmt.kind {
                StmtKind::Expr { expr, .. } => expr,
                StmtKind::Let { .. } => return None,
            },
            _ => return None,
        };
        let ExprKind::Match { scrutinee, arms } = &tree.expr(only).kind else { return None };
        let is_end = |arm: &Arm| {
            matches!(tree.expr(arm.body).kind, ExprKind::Break { label: None, value: None })
                && matches!(tree.pat(arm.pat).kind, PatKind::Path(_) | PatKind::Bind { .. } | PatKind::Wild)
        };
        let arm = match arms.as_slice() {
            [some, none] if is_end(none) => some,
            [none, some] if is_end(none) && !matches!(tree.pat(none.pat).kind, PatKind::Wild) => some,
            _ => return None,
        };
        let is_plain = arms.iter().all(|arm| arm.guard.is_none() && arm.cfg.is_none());
        is_plain.then_some((arm.pat, *scrutinee, arm.body))
    }

    /// `while let Some(x) = iter.next()` is a `for` loop.
    fn loop_over_next(
        &mut self,
        kind: CycleKind,
        label: Option<&String>,
        keyword: Span,
        (pat, asked): (PatId, ExprId),
        body: ExprId,
    ) -> Option<Value> {
        let tree = self.body();
        let ExprKind::MethodCall { receiver, method, args, .. } = &tree.expr(asked).kind else { return None };
        if method != "next" || !args.is_empty() || !self.iterates(self.ty(*receiver)) {
            return None;
        }
        let PatKind::TupleStruct(_, inner) = &tree.pat(pat).kind else { return None };
        // What an item may be besides ends the loop before the last one.
        let [inner] = inner.as_slice() else { return None };
        if !self.is_irrefutable(*inner) {
            return None;
        }
        let source = match self.is_advanced_in(*receiver, body) {
            true => self.part_of(asked, *receiver),
            false => self.source(*receiver),
        };
        self.note_advanced(*receiver);
        let item = source.item.clone();
        let inner = *inner;
        self.run_loop(kind, keyword, label, source, |this, value, this_loop| {
            this.bind_item(this_loop, inner, &item, &value);
            this.expr(body);
        });
        Some(Value::default())
    }

    pub(super) fn for_expr(
        &mut self,
        label: Option<&String>,
        keyword: Span,
        pat: PatId,
        iterable: ExprId,
        body: ExprId,
    ) -> Value {
        let is_dropped = self.is_dropped(self.ty(iterable));
        if self.at.is_some() && !is_dropped && self.unrolled(label, keyword, pat, iterable, body) {
            return Value::default();
        }
        let asked = self.asks_for_round(iterable).filter(|_| self.at.is_some());
        let never = asked.map(|var| self.ask_for_round(var, iterable));
        let is_filled = self.is_surely_entered(iterable);
        let mut source = self.source(iterable);
        source.is_filled = is_filled;
        let mut taken = Vec::new();
        source.item.lends(&mut taken);
        self.lose_iterated(iterable, taken);
        if asked.is_some() {
            (source.rounds, source.limits) = (Rounds::Constant(1), Vec::new());
        }
        let item = source.item.clone();
        let choosing = self.choosing(&source);
        let is_mapped = choosing.is_none();
        let numbered = source.numbered();
        self.run_loop(CycleKind::For, keyword, label, source, |this, value, this_loop| {
            let item = if is_mapped { numbered.unwrap_or(Item::Opaque) } else { item };
            this.bind_item(this_loop, pat, &item, &value);
            this.note_chosen(&choosing, (this.frame, pat));
            this.note_sampled(this_loop, body);
            this.note_drained(this_loop, iterable, body);
            this.note_lent_to_rounds(this_loop, iterable);
            this.note_mirrored(this_loop, body);
            this.graph.loops[this_loop.0 as usize].is_lent = this.is_lent_iterator(iterable);
            this.graph.loops[this_loop.0 as usize].is_table = this.is_table(iterable);
            if is_mapped {
                let names = this.vars_of(pat);
                this.derive(&names, iterable);
            }
            this.expr(body);
        });
        if let Some(never) = never {
            let after = self.add_node(Effect::Nothing, keyword);
            self.jump(after);
            self.link(never, after);
            self.resume(after);
        }
        Value::default()
    }

    /// Whether an expression is the only mention of an iterator that the function was lent: `audio: &mut impl Iterator<Item = f32>`.
    fn is_lent_iterator(&self, iterable: ExprId) -> bool {
        let typed = self.typed();
        let Some(local) = typed.expr_local.get(&iterable) else { return false };
        let is_param = self.body().params.iter().any(|pat| typed.pat_local.get(pat) == Some(local));
        is_param
            && matches!(self.ty(iterable), Ty::Ref(true, _))
            && self.iterates(self.ty(iterable))
            && typed.expr_local.values().filter(|other| *other == local).count() == 1
    }

    /// Notes whether the counter of a loop from zero is used in nothing but `a[last - i]`: that takes the same numbers the other way
    /// round.
    fn note_mirrored(&mut self, this_loop: LoopId, inside: ExprId) {
        let info = self.graph.loop_info(this_loop);
        let (Some((counter, Some(0))), limits) = (info.counter, info.limits.clone()) else { return };
        let tree = self.body();
        let indexes = tree.within(inside).filter_map(|id| match &tree.expr(id).kind {
            ExprKind::Index { index, .. } => Some(*index),
            _ => None,
        });
        let is_counter = |this: &Self, id: ExprId| {
            let local = this.typed().expr_local.get(&id);
            local.and_then(|local| this.frames[this.frame].vars.get(local)) == Some(&counter)
        };
        let used = tree.within(inside).filter(|id| is_counter(self, *id)).count();
        let lasts: Vec<ExprId> = indexes
            .filter_map(|index| match &tree.expr(index).kind {
                ExprKind::Binary { op: "-", lhs, rhs } if is_counter(self, *rhs) => Some(*lhs),
                _ => None,
            })
            .collect();
        let is_told = !limits.is_empty() && !limits.contains(&Limit::Unknown);
        let is_mirrored = used > 0 && used == lasts.len() && is_told;
        if is_mirrored && lasts.into_iter().all(|last| self.limits(last, true) == limits) {
            let info = &mut self.graph.loops[this_loop.0 as usize];
            (info.is_mirrored, info.counts_down) = (true, !info.counts_down);
        }
    }
}
