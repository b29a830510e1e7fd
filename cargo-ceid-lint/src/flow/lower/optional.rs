//! Options that are made of other values, there or not by what is asked for them: `filter`, `zip`, `then`.

use super::{Builder, ClosureRef, Value};
use crate::flow::{Assignment, Change, ChangeKind, Computed, Effect, NodeId, Place, Transfer, Var};
use crate::index::Ty;
use crate::source::Span;
use crate::syntax::tree::{Body, ExprId, ExprKind, PatKind, Stmt, StmtKind};
use crate::types::Callee;

impl Builder<'_> {
    /// `get_or_insert` and its kin: what they are given goes where nothing was, or is made only then.
    pub(super) fn get_or_insert(&mut self, id: ExprId, receiver: ExprId, args: &[ExprId], value: &Value) -> Value {
        let span = self.span(id);
        let given = args.first().map(|arg| self.expr(*arg)).unwrap_or_default();
        let is_filled = self.is_optional(receiver);
        if is_filled || given.closure.is_some() {
            self.on_absent(value, receiver, span, |this| {
                let made = match given.closure {
                    Some(closure) => this.inline_closure(closure, &[], span),
                    None => given.clone(),
                };
                if is_filled {
                    this.write_whole(value, &Value { head: Some("+".to_owned()), ..made }, span);
                    this.note_pointed(this.ty(receiver).peel());
                } else if made.place.is_some() && this.may_hold_filter(this.ty(id)) {
                    this.keep(&made, args[0]);
                }
            });
        } else if given.place.is_some() && self.may_hold_filter(self.ty(args[0])) {
            self.keep(&given, args[0]);
        }
        Value { is_owned: false, head: None, same_as: None, ..value.clone() }
    }

    /// `read().filter(|z| z.is_finite())`: what is there stays if the closure says so.
    pub(super) fn filter_payload(&mut self, id: ExprId, receiver: ExprId, asked: ExprId, value: &Value) -> Value {
        let span = self.span(id);
        let body = self.body();
        let written = match &body.expr(asked).kind {
            ExprKind::Closure(code) if !code.is_async && !leaves(body, code.body) => Some(code),
            _ => None,
        };
        let closure = match written {
            Some(_) => Some(ClosureRef { frame: self.frame, expr: asked }),
            None => self.expr(asked).closure,
        };
        let Some(closure) = closure.filter(|_| self.at.is_some() && self.depth < super::MAX_INLINE) else {
            return Value { head: None, same_as: None, ..value.clone() };
        };
        let vars = self.derive_payload(closure, receiver);
        let join = self.new_join(self.ty(id).clone(), span);
        let left_out = self.add_node(Effect::Nothing, span);
        let absent = self.add_node(Effect::Nothing, span);
        let payload = Value { head: None, same_as: None, ..value.clone() };
        if value.head.as_deref() != Some("+") {
            let (present, none) = self.branch_on_payload(receiver, closure, value, span);
            self.link(none, absent);
            self.resume(present);
        }
        match written {
            Some(code) => {
                self.depth += 1;
                if let Some((pat, _)) = code.params.first() {
                    self.bind_pattern(*pat, &payload);
                }
                self.condition(code.body, left_out);
                self.depth -= 1;
            }
            None => {
                let truth = self.inline_closure(closure, std::slice::from_ref(&payload), span);
                // A function is asked for nothing but what is there.
                let about = self.about_presence(receiver, vars);
                let (passes, fails) = self.branch_on_head(&truth, "true", "false", span, self.text(asked), about);
                self.link(fails, left_out);
                self.resume(passes);
            }
        }
        self.end_branch(&join, &Value { head: Some("+".to_owned()), ..payload }, span);
        self.resume_if_reached(left_out);
        self.drop_left_out(receiver, value, span);
        self.end_branch(&join, &nothing(), span);
        self.end_absent(&join, absent, span);
        self.close_join(&join)
    }

    /// What a closure leaves out is dropped, if it has no name.
    fn drop_left_out(&mut self, option: ExprId, value: &Value, span: Span) {
        let content = match self.ty(option) {
            Ty::External(_, args) => args.first().cloned(),
            _ => None,
        };
        if let (Some(ty), Some(place)) = (content, value.place.clone())
            && self.at.is_some()
            && value.is_owned
            && self.destroyed_by(value).is_none()
        {
            self.drop_parts(&ty, &place, span);
        }
    }

    /// A path on which the value is absent ends here.
    pub(super) fn assume_present(&mut self, value: &Value, receiver: ExprId, span: Span) {
        if self.at.is_none() || value.same_as.is_none() {
            return;
        }
        let about = self.about_presence(receiver, Vec::new());
        let (good, bad) = self.branch_on_head(value, "+", "-", span, self.presence_text(receiver), about);
        self.resume(bad);
        self.diverge(span);
        self.resume(good);
    }

    /// Code that runs only where the value is absent.
    pub(super) fn on_absent(&mut self, value: &Value, receiver: ExprId, span: Span, inside: impl FnOnce(&mut Self)) {
        if self.at.is_none() {
            return;
        }
        let about = self.about_presence(receiver, Vec::new());
        let asked = self.presence_text(receiver);
        let (present, absent) = self.branch_on_head(value, "+", "-", span, asked, about);
        let after = self.add_node(Effect::Nothing, span);
        self.resume(absent);
        inside(self);
        self.jump(after);
        self.resume(present);
        self.jump(after);
        self.resume_if_reached(after);
    }

    /// How it is told whether something is there or was successful: neither holds or does not hold.
    pub(super) fn presence_text(&self, asked: ExprId) -> String {
        let text = self.text(asked);
        match self.ty(asked).peel().external_name() {
            Some("Option") => format!("let Some(_) = {text}"),
            Some("Result" | "LockResult") => format!("{text}?"),
            _ => text,
        }
    }

    /// Notes what the names are computed from that a closure gives to what an option holds; answers these.
    pub(super) fn derive_payload(&mut self, closure: ClosureRef, receiver: ExprId) -> Vec<Var> {
        let vars = self.closure_vars(closure);
        self.derive(&vars, receiver);
        vars
    }

    /// The option out of which an expression takes what is there: `spare.take()`, `mem::take(&mut command)`.
    pub(super) fn option_taken(&self, id: ExprId) -> Option<ExprId> {
        match (&self.body().expr(id).kind, self.typed().callees.get(&id)) {
            (ExprKind::MethodCall { receiver, method, args, .. }, _) if method == "take" && args.is_empty() => {
                self.is_optional(*receiver).then_some(*receiver)
            }
            (ExprKind::Call { args, .. }, Some(Callee::External(path)))
                if self.is_optional(id) && !self.may_hold_filter(self.ty(id)) =>
            {
                match (path.as_str(), args.as_slice()) {
                    ("std::mem::take", [option]) => Some(*option),
                    ("std::mem::replace", [option, new]) => {
                        (self.constant_head(*new).as_deref() == Some("-")).then_some(*option)
                    }
                    _ => None,
                }
            }
            _ => None,
        }
    }

    /// `spare.take()`, `mem::take(&mut spare)`: what is there leaves its place, and there is something if there was.
    pub(super) fn taken_out(&mut self, id: ExprId, value: &Value) -> Value {
        let span = self.span(id);
        let Some(place) = value.place.clone().filter(|_| self.at.is_some()) else { return Value::default() };
        let taken = self.temporary(self.ty(id).clone(), span);
        self.may_be_asked(&place, taken);
        let leaving = Value { is_owned: true, leaves_by: Some(Transfer::Move), head: None, ..value.clone() };
        self.set(taken, &leaving, span);
        if let Some(at) = self.at.filter(|_| value.same_as.is_none()) {
            self.graph.copies.insert(at, place.clone());
        }
        self.emptied(place, span);
        self.note_pointed(self.ty(id));
        Value { place: Some(Place::var(taken)), same_as: Some(taken), ..leaving }
    }

    /// Whether a statement takes what an option or cell holds, and drops it: `spare.take();`
    pub(super) fn drops_content(&self, taken: ExprId, receiver: ExprId) -> bool {
        let content = self.ty(taken);
        let is_dropped = |stmt: &Stmt| match &stmt.kind {
            StmtKind::Expr { expr, semicolon: true } => *expr == taken,
            StmtKind::Let { pat, init: Some(init), .. } => {
                *init == taken && matches!(self.body().pat(*pat).kind, PatKind::Wild)
            }
            _ => false,
        };
        let mut holder = self.ty(receiver).peel();
        while let Ty::External(_, args) = holder
            && holder.is_shared_pointer()
        {
            holder = args.first().map_or(&Ty::Unknown, Ty::peel);
        }
        let is_cell = self.is_cell(receiver) || matches!(holder.external_name(), Some("Cell" | "RefCell"));
        (is_cell || self.is_optional(receiver))
            && self.may_hold_filter(content)
            && !self.program.index.refers_to_filters(content)
            && !self.program.index.leads_to_destructor(content)
            && !self.is_guard(taken)
            && (self.body().stmts().any(is_dropped) || self.is_given_to_drop(taken))
    }

    fn is_given_to_drop(&self, value: ExprId) -> bool {
        let body = self.body();
        let is_path = |callee: ExprId| matches!(&body.expr(callee).kind, ExprKind::Path(path) if path.last() == "drop");
        let calls = (0u32..).map(ExprId).take(body.exprs.len()).filter(|id| {
            matches!(&body.expr(*id).kind, ExprKind::Call { callee, args } if *args == [value] && is_path(*callee))
        });
        let is_std = |id: ExprId| matches!(self.typed().callees.get(&id), Some(Callee::External(path)) if path.starts_with("std::mem"));
        calls.into_iter().any(is_std)
    }

    /// An option is empty from here on, a cell holds what is made by default.
    pub(super) fn drop_content(&mut self, receiver: ExprId, value: &Value, span: Span) -> Value {
        match value.place.clone() {
            Some(place) if self.is_optional(receiver) => self.emptied(place, span),
            Some(_) => self.write_whole(value, &Value::default(), span),
            None => {}
        }
        Value::default()
    }

    /// From here on there is nothing in an option.
    pub(super) fn emptied(&mut self, place: Place, span: Span) {
        let head = Some("-".to_owned());
        let nothing = Assignment { place, from: None, transfer: Transfer::Move, rebinds: false, head, same_as: None };
        let at = self.emit(Effect::Write(Box::new(nothing)), span);
        let change = Change {
            computed: Computed::default(),
            kind: ChangeKind::Empties,
            goes_round: false,
            about: None,
            tally: None,
        };
        self.graph.changes.insert(at, change);
    }

    /// `filter.as_mut().zip(read())`: there where both are.
    pub(super) fn zip_options(&mut self, id: ExprId, receiver: ExprId, other: ExprId, value: &Value) -> Value {
        let span = self.span(id);
        let second = self.expr(other);
        if self.at.is_none() {
            return Value::default();
        }
        let join = self.new_join(self.ty(id).clone(), span);
        let parts = [(receiver, value), (other, &second)];
        for (expr, value) in parts {
            let (present, absent) = self.branch_on_presence(expr, value, span);
            self.end_absent(&join, absent, span);
            self.resume(present);
        }
        let payloads = parts.map(|(_, value)| Value { head: None, same_as: None, ..value.clone() });
        let both = self.gathered(id, &[receiver, other], &payloads);
        self.end_branch(&join, &Value { head: Some("+".to_owned()), ..both }, span);
        self.close_join(&join)
    }

    /// `fine.as_mut().or(coarse.as_mut())`: the first one that is there. With `xor` none of them where both are.
    pub(super) fn either_option(
        &mut self,
        id: ExprId,
        receiver: ExprId,
        other: ExprId,
        value: &Value,
        is_exclusive: bool,
    ) -> Value {
        let span = self.span(id);
        let second = self.expr(other);
        if self.at.is_none() {
            return Value::default();
        }
        let join = self.new_join(self.ty(id).clone(), span);
        let there = |value: &Value| Value { head: Some("+".to_owned()), same_as: None, ..value.clone() };
        let (present, absent) = self.branch_on_presence(receiver, value, span);
        self.resume(present);
        if is_exclusive {
            let (both, only) = self.branch_on_presence(other, &second, span);
            self.end_absent(&join, both, span);
            self.resume(only);
        }
        self.end_branch(&join, &there(value), span);
        self.resume(absent);
        let (present, absent) = self.branch_on_presence(other, &second, span);
        self.end_absent(&join, absent, span);
        self.resume(present);
        self.end_branch(&join, &there(&second), span);
        self.close_join(&join)
    }

    /// Asks whether an option is there.
    fn branch_on_presence(&mut self, expr: ExprId, value: &Value, span: Span) -> (NodeId, NodeId) {
        let about = self.about_presence(expr, Vec::new());
        match self.pure_option(expr) {
            Some(pure) => {
                let subject = self.subject(pure, Some(vec!["+".to_owned(), "-".to_owned()]));
                self.head_bit(subject, "+");
                self.head_bit(subject, "-");
                self.branch_on_subject(subject, &["+".to_owned()], true, span, self.presence_text(expr), about)
            }
            None => self.branch_on_head(value, "+", "-", span, self.presence_text(expr), about),
        }
    }

    /// `is_armed().then(|| read())`, `is_armed().then_some(sample)`: there where the truth value holds.
    pub(super) fn then_value(&mut self, id: ExprId, receiver: ExprId, value: &Value, given: Value) -> Value {
        if self.at.is_none() {
            return Value::default();
        }
        let span = self.span(id);
        let about = self.about(receiver);
        let (holds, fails) = self.branch_on_head(value, "true", "false", span, self.text(receiver), about);
        let join = self.new_join(self.ty(id).clone(), span);
        self.resume(holds);
        let made = match given.closure {
            Some(closure) => self.inline_closure(closure, &[], span),
            None => given,
        };
        self.end_branch(&join, &Value { head: Some("+".to_owned()), same_as: None, ..made }, span);
        self.end_absent(&join, fails, span);
        self.close_join(&join)
    }

    /// Whether a value is a handle whose clones share one instance, or is made of such.
    pub(super) fn is_shared_handle(&self, id: ExprId) -> bool {
        let ty = self.ty(id).peel();
        ty.is_shared_pointer() || self.program.index.is_handle(ty)
    }

    /// Whether a method hands out what a handle leads to, or what a lock holds where the one before panicked: that is there, too.
    pub(super) fn hands_out(&self, receiver: ExprId, method: &str) -> bool {
        match method {
            "upgrade" => self.is_shared_handle(receiver),
            _ => self.ty(receiver).peel().external_name() == Some("LockResult"),
        }
    }

    /// Ends a branch on which nothing is there.
    fn end_absent(&mut self, join: &super::values::Join, at: NodeId, span: Span) {
        self.resume_if_reached(at);
        self.end_branch(join, &nothing(), span);
    }
}

/// The value of an option in which there is nothing.
fn nothing() -> Value {
    Value { head: Some("-".to_owned()), ..Value::default() }
}

/// Whether a closure's code can be left before its end, or waits.
pub(super) fn leaves(body: &Body, code: ExprId) -> bool {
    let is_exit = |kind: &ExprKind| matches!(kind, ExprKind::Return(_) | ExprKind::Try(_) | ExprKind::Await(_));
    body.within(code).any(|id| is_exit(&body.expr(id).kind))
}
