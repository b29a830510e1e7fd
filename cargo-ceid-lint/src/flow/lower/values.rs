//! Blocks, statements, and values that come from several branches.

use super::{Builder, ClosureRef, Value};
use crate::flow::{Assignment, Effect, Head, NodeId, Place, Transfer, Var};
use crate::index::{FunctionId, Ty};
use crate::source::Span;
use crate::syntax::tree::{
    Block, BlockKind, CfgKey, ExprId, ExprKind, Literal, PatId, PatKind, Receiver, Stmt, StmtKind,
};
use crate::types::Callee;

/// Branches that meet again, with the variable that holds the value.
pub(super) struct Join {
    pub(super) after: NodeId,
    pub(super) value: Var,
    /// The expression whose branches they are, if its value may be a function or closure.
    pub(super) chooses: Option<ExprId>,
}

impl Builder<'_> {
    /// A point where branches meet again.
    pub(super) fn new_join(&mut self, ty: Ty, span: Span) -> Join {
        let value = self.temporary(ty, span);
        let after = self.add_node(Effect::Nothing, span);
        Join { after, value, chooses: None }
    }

    /// Ends a branch with its value.
    pub(super) fn end_branch(&mut self, join: &Join, value: &Value, span: Span) {
        self.end_branch_of(join, value, None, span);
    }

    /// The same with the expression that gives the value, which may be a state: `_ => self.state`.
    pub(super) fn end_branch_of(&mut self, join: &Join, value: &Value, given: Option<ExprId>, span: Span) {
        if self.at.is_none() {
            return;
        }
        let before = self.iterators.get(&join.value).cloned();
        self.join_made(value, join.value, span);
        self.set(join.value, value, span);
        if let Some(given) = given {
            let mut last = given;
            while let ExprKind::Block(block) = &self.body().expr(last).kind
                && let Some(tail) = block.tail
            {
                last = tail;
            }
            self.note_copy(last);
        } else if self.graph.var(join.value).ty == Ty::Bool {
            self.note_copied_part(join.value, value);
        }
        self.join_parts(value, join.value, span);
        self.note_choice(join.value, before);
        self.arrived.entry(join.value).or_default().push(value.closure);
        self.jump(join.after);
    }

    /// Goes on where branches met; nothing follows if none arrived.
    pub(super) fn close_join(&mut self, join: &Join) -> Value {
        self.resume_if_reached(join.after);
        self.numbers.remove(&join.value);
        self.joined_made(join.value);
        let closure = self.one_of_arrived(join);
        let iterator = self.iterators.get(&join.value).cloned();
        Value { place: Some(Place::var(join.value)), same_as: Some(join.value), closure, iterator, ..Value::default() }
    }

    /// The closure that a value from several branches is: one of those that they gave.
    fn one_of_arrived(&mut self, join: &Join) -> Option<ClosureRef> {
        let mut all = self.arrived.remove(&join.value)?;
        all.dedup();
        if let [one] = all.as_slice() {
            return *one;
        }
        self.closures.remove(&join.value);
        let known: Option<Vec<ClosureRef>> = all.iter().copied().collect();
        if let (Some(expr), Some(known)) = (join.chooses, known) {
            let choice = ClosureRef { frame: self.frame, expr };
            self.choices.insert((choice.frame, choice.expr), known);
            self.closures.insert(join.value, choice);
            return Some(choice);
        }
        let span = self.graph.var(join.value).span;
        for closure in all.into_iter().flatten() {
            self.keep_closure(&Value { closure: Some(closure), ..Value::default() }, span);
        }
        None
    }

    /// A place that something unseen may write.
    pub(super) fn written_unseen(&mut self, place: Place, span: Span) {
        let assignment =
            Assignment { place, from: None, transfer: Transfer::Move, rebinds: false, head: None, same_as: None };
        self.emit(Effect::Write(Box::new(assignment)), span);
    }

    pub(super) fn block(&mut self, id: ExprId, block: &Block) -> Value {
        let span = self.span(id);
        if block.kind == BlockKind::Async {
            return self.future(id);
        }
        if block.kind == BlockKind::Try {
            return self.inline_body(self.ty(id).clone(), span, false, |this| this.plain_block(block, span));
        }
        match &block.label {
            Some(label) => self.labelled_block(id, label.clone(), block),
            None => {
                let value = self.plain_block(block, span);
                // What a block gives is a value, and not the place that it comes from.
                let is_copy = value.place.is_some() && self.transfer(&value, self.ty(id)) == Transfer::Copy;
                let is_copy = is_copy && !self.is_in_between(&value);
                if is_copy { self.copy_of(&value, self.ty(id).clone(), span) } else { value }
            }
        }
    }

    pub(super) fn plain_block(&mut self, block: &Block, span: Span) -> Value {
        self.open_block();
        let mut written = super::changes::WrittenFields::new();
        for stmt in &block.stmts {
            self.stmt(stmt);
            if let (None, StmtKind::Expr { expr, .. }) = (&stmt.cfg, &stmt.kind) {
                self.note_written_field(*expr, &mut written, stmt.span);
            }
        }
        let value = block.tail.map(|tail| self.expr(tail)).unwrap_or_default();
        if let Some(tail) = block.tail {
            self.note_written_field(tail, &mut written, self.span(tail));
        }
        let end = Span::new(span.file, span.end.saturating_sub(1), span.end);
        let moved = self.moved_guard(&value);
        self.close_block_without(moved, end);
        value
    }

    fn stmt(&mut self, stmt: &Stmt) {
        match &stmt.cfg {
            None => self.stmt_inner(stmt),
            Some(key) => {
                let span = stmt.span;
                self.if_cfg(key, span, |this| this.stmt_inner(stmt));
            }
        }
    }

    /// Code that is there or not: the two ways are correlated with every other use of the same `#[cfg]`.
    pub(super) fn if_cfg(&mut self, key: &CfgKey, span: Span, inside: impl FnOnce(&mut Self)) {
        let (present, absent) = self.branch_on_cfg(key, span);
        let after = self.add_node(Effect::Nothing, span);
        self.resume(present);
        inside(self);
        self.jump(after);
        self.resume(absent);
        self.jump(after);
        self.resume(after);
    }

    fn stmt_inner(&mut self, stmt: &Stmt) {
        let first = self.graph.nodes.len();
        match &stmt.kind {
            StmtKind::Let { pat, init, otherwise, .. } => match (init, otherwise) {
                (Some(init), Some(otherwise)) => self.let_else(*pat, *init, *otherwise),
                (Some(init), None) => self.let_stmt(*pat, *init, stmt.span),
                (None, _) => {
                    for local in self.locals_of(*pat) {
                        let var = self.var_of(local);
                        self.guard_scopes.insert(var, self.innermost());
                    }
                }
            },
            StmtKind::Expr { expr, .. } => {
                self.graph.dropped.push(self.span(*expr));
                let filled = self.filled_by(*expr);
                let value = if filled.is_empty() { self.expr(*expr) } else { self.expr_into(filled, *expr) };
                self.discard(*expr, &value, stmt.span);
            }
        }
        self.settle_made(first, stmt.span);
    }

    /// The truth value that a block ends with, if that is written there.
    pub(super) fn constant_tail(&self, block: &Block) -> Option<bool> {
        match self.body().expr(block.tail?).kind {
            ExprKind::Literal(Literal::Bool(answer)) => Some(answer),
            _ => None,
        }
    }

    /// An expression whose value goes into variables.
    pub(super) fn expr_into(&mut self, targets: Vec<Var>, id: ExprId) -> Value {
        let outer = std::mem::replace(&mut self.targets, targets);
        let outer_value = self.target_value.replace((self.frame, id));
        let value = self.expr(id);
        (self.targets, self.target_value) = (outer, outer_value);
        value
    }

    fn let_stmt(&mut self, pat: PatId, init: ExprId, span: Span) {
        let bound = self.vars_of(pat);
        self.derive_pattern(pat, init);
        self.note_lent_names(pat, init);
        self.note_own_cell(&bound, init);
        if bound.is_empty() {
            self.graph.dropped.push(self.span(init));
        }
        let value = self.expr_into(bound.clone(), init);
        if self.at.is_none() {
            // The names are still bound, so that what follows can be read.
            for local in self.locals_of(pat) {
                self.var_of(local);
            }
            return;
        }
        if matches!(self.body().pat(pat).kind, PatKind::Wild) {
            self.discard_wild(init, &value, span);
            return;
        }
        self.bind_pattern(pat, &value);
        self.leave_by_let(pat, init, &value, span);
        if self.is_presumed_filter(init) {
            self.note_handed(pat);
        }
        if self.is_taken_from_elsewhere(init) {
            self.graph.taken.extend(bound.iter().copied());
        }
        if matches!(self.body().pat(pat).kind, PatKind::Bind { .. }) {
            self.note_copy(init);
            if let [var] = bound.as_slice() {
                self.copy_parts(&value, &Place::var(*var), span);
                self.made_options(*var, init, span);
                let is_fixed = matches!(self.body().pat(pat).kind, PatKind::Bind { mutable: false, .. });
                if is_fixed && self.pure(init).is_some_and(|pure| pure.reads.is_empty()) {
                    self.graph.constants.insert(*var);
                }
            }
            if let Some(is_masked) = self.remainder(init) {
                let held: Vec<Var> = self.vars_of(pat).into_iter().filter(|var| !self.is_mutated(*var)).collect();
                self.graph.remainders.extend(held.into_iter().map(|var| (var, is_masked)));
            }
        }
    }

    /// Whether an expression is a remainder that is the low bits of a number; `None` if it is no remainder.
    fn remainder(&mut self, id: ExprId) -> Option<bool> {
        match &self.body().expr(id).kind {
            ExprKind::Binary { op: "%", .. } => Some(false),
            ExprKind::Binary { op: "&", rhs, .. } => {
                let is_low = self.number(*rhs).and_then(|mask| mask.checked_add(1)).is_some_and(u64::is_power_of_two);
                is_low.then_some(true)
            }
            ExprKind::MethodCall { method, .. } if method == "rem_euclid" => Some(false),
            ExprKind::Cast { value, .. } => self.remainder(*value),
            _ => None,
        }
    }

    /// Whether unseen code gives a value out of one that holds filters: `bank.remove(0)`, `mem::take(&mut self.filter)`,
    /// `receiver.recv().unwrap()`.
    fn is_taken_from_elsewhere(&self, id: ExprId) -> bool {
        let is_unseen = || {
            let callee = self.typed().callees.get(&id);
            !matches!(callee, Some(Callee::Resolved(_) | Callee::Constructor(_) | Callee::Closure(_)))
        };
        match &self.body().expr(id).kind {
            // A clone is a filter of its own, as its use tells.
            ExprKind::MethodCall { method, .. } if method == "clone" => false,
            ExprKind::MethodCall { receiver, .. } => is_unseen() && self.leads_to_holder(*receiver),
            ExprKind::Call { args, .. } => is_unseen() && args.iter().any(|arg| self.leads_to_holder(*arg)),
            ExprKind::Try(value) | ExprKind::Await(value) => self.is_taken_from_elsewhere(*value),
            _ => false,
        }
    }

    /// Whether an expression is a place that holds filters, or what unseen code gives out of one.
    fn leads_to_holder(&self, id: ExprId) -> bool {
        match &self.body().expr(id).kind {
            ExprKind::Reference { value, .. } | ExprKind::Deref(value) => self.leads_to_holder(*value),
            ExprKind::Path(_) | ExprKind::Field { .. } | ExprKind::Index { .. } => {
                self.program.index.holds_filter(self.ty(id))
            }
            _ => self.is_taken_from_elsewhere(id),
        }
    }

    /// Whether only what is done with a value can tell that it is a filter: any function of a type that is not read may have
    /// given it.
    fn is_presumed_filter(&self, init: ExprId) -> bool {
        let Some(Callee::External(path)) = self.typed().callees.get(&init) else { return false };
        let name = path.rsplit("::").next().unwrap_or("");
        !path.starts_with("std::")
            && !crate::types::names_constructor(name)
            && self.program.index.made_by(path).is_none()
            && matches!(self.ty(init), Ty::External(..))
            && self.program.index.law_spec(self.ty(init)).is_some()
    }

    fn let_else(&mut self, pat: PatId, init: ExprId, otherwise: ExprId) {
        self.derive_pattern(pat, init);
        let value = self.asked_value(init);
        let span = self.body().pat(pat).span.to(self.span(init));
        let failed = self.add_node(Effect::Nothing, self.span(otherwise));
        let before = self.scopes.last().map_or(0, |scope| scope.guards.len());
        self.match_pattern(pat, init, &value, span, failed);
        let matched = self.at;
        // A guard that the pattern binds is not there where it does not match.
        let bound = self.scopes.last_mut().map(|scope| scope.guards.split_off(before)).unwrap_or_default();
        self.resume_if_reached(failed);
        self.expr(otherwise);
        if self.at.is_some() {
            self.emit(Effect::Diverge, span);
        }
        if let Some(scope) = self.scopes.last_mut() {
            scope.guards.extend(bound);
        }
        self.at = matched;
    }

    /// Notes which variant a variable that never changes is from here on.
    pub(super) fn note_name(&mut self, var: Var, value: &Value) {
        let is_told = matches!(self.graph.var(var).ty.peel(), Ty::Adt(..)) && !self.is_mutated(var);
        match value.head.as_ref().filter(|_| is_told && !self.is_changed_by_method(var)) {
            Some(head) => self.names.insert(var, head.clone()),
            None => self.names.remove(&var),
        };
    }

    /// Whether a method that may change it is called on the local that a variable stands for.
    fn is_changed_by_method(&self, var: Var) -> bool {
        if self.graph.var(var).name.is_empty() {
            return false;
        }
        let frame = &self.frames[self.frame];
        let is_it = |expr: &ExprId| {
            let local = self.typed().expr_local.get(expr);
            local.and_then(|local| frame.vars.get(local)) == Some(&var)
        };
        let leaves = |target: &FunctionId| {
            let receiver = &self.program.index.function(*target).function.receiver;
            matches!(receiver, Some(Receiver::Shared | Receiver::Value))
        };
        let mut exprs = (0u32..).map(ExprId).zip(&self.body().exprs);
        exprs.any(|(id, expr)| match &expr.kind {
            ExprKind::MethodCall { receiver, method, .. } if is_it(receiver) => match self.typed().callees.get(&id) {
                Some(Callee::Resolved(resolved)) if !resolved.targets.is_empty() => {
                    !resolved.targets.iter().all(leaves)
                }
                _ => !super::borrowed::only_reads(method),
            },
            _ => false,
        })
    }

    /// The variable that holds a truth value or an option which is made for an argument: `step(now >= deadline)`.
    pub(super) fn state_given(&mut self, id: ExprId, value: &Value) -> Option<Place> {
        let is_made = *self.ty(id) == Ty::Bool || self.is_plain_option(self.ty(id));
        let var = value.same_as.filter(|_| is_made)?;
        let pure = self.pure_var(var);
        self.state_subject(pure, id);
        Some(Place::var(var))
    }

    /// The variant that a variable stands for: `for side in [Side::Left, Side::Right] { self.wheel(side).update(); }`
    pub(super) fn name_behind(&self, id: ExprId) -> Option<Head> {
        match &self.body().expr(id).kind {
            ExprKind::Reference { value, .. } | ExprKind::Deref(value) => self.name_behind(*value),
            ExprKind::Path(_) => {
                let local = self.typed().expr_local.get(&id)?;
                self.names.get(self.frames[self.frame].vars.get(local)?).cloned()
            }
            _ => None,
        }
    }
}

impl Builder<'_> {
    pub(super) fn param_ty(&self, pat: PatId) -> Ty {
        self.typed().pat_local.get(&pat).map_or(Ty::Unknown, |local| self.typed().local(*local).ty.clone())
    }

    pub(super) fn param_name(&self, pat: PatId) -> String {
        self.typed().pat_local.get(&pat).map_or_else(String::new, |local| self.typed().local(*local).name.clone())
    }

    /// Whether a call gets nothing through which it could write what an argument names: what is given by value is copied, or gone.
    pub(super) fn is_given_as_value(&self, call: ExprId, arg: ExprId) -> bool {
        let ty = self.ty(arg);
        let is_value = match ty {
            Ty::Adt(..) => true,
            Ty::External(path, _) => !path.starts_with("?::"),
            Ty::Tuple(parts) => parts.iter().all(is_plain),
            _ => false,
        };
        is_plain(ty) || (is_value && !self.is_receiver(call, arg))
    }
}

/// Whether a value of the type is a copy through which nothing is written.
pub(super) fn is_plain(ty: &Ty) -> bool {
    match ty {
        Ty::Int | Ty::Float | Ty::Bool | Ty::Str | Ty::Char | Ty::Never => true,
        Ty::Ref(mutable, inner) => !mutable && is_plain(inner),
        _ => false,
    }
}
