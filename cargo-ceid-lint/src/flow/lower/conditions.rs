//! Conditions: `if`, `&&`, `||`, `!`, comparisons, patterns in conditions, each leaf a branch of its own.

use super::orders::{ORDERS, orders_asked};
use super::subjects::Pure;
use super::values::Join;
use super::{Builder, Value};
use crate::flow::{About, Head, NodeId, Place};
use crate::index::Ty;
use crate::syntax::tree::{ExprId, ExprKind, Literal, MacroKind, PatId, PatKind};
use crate::types::Callee;

/// What filters are asked that come to rest by themselves until they are given a new target, and the answer at rest: an update
/// would change nothing then.
const RESTS: &[(&str, bool)] = &[
    ("is_smoothing", false),
    ("is_ramping", false),
    ("is_gliding", false),
    ("need_ramp", false),
    ("needs_ramp", false),
    ("is_done", true),
    ("is_finished", true),
    ("has_finished", true),
    ("is_settled", true),
    ("has_settled", true),
    ("is_at_rest", true),
    ("is_resting", true),
];

/// Methods that ask the opposite of others.
const OPPOSITES: &[(&str, &str)] = &[("is_sign_positive", "is_sign_negative")];

/// What a comparison asks about, and all heads that it can have.
pub(super) type Compared = (Pure, Option<Vec<Head>>);

impl Builder<'_> {
    pub(super) fn if_expr(&mut self, id: ExprId, condition: ExprId, then: ExprId, otherwise: Option<ExprId>) -> Value {
        let span = self.span(id);
        let join = Join { chooses: Some(id), ..self.new_join(self.ty(id).clone(), span) };
        let no = self.add_node(crate::flow::Effect::Nothing, self.span(condition));
        self.open_block();
        self.condition(condition, no);
        let value = self.expr(then);
        let moved = self.moved_guard(&value);
        self.close_block_without(moved, self.span(then));
        self.end_branch_of(&join, &value, Some(then), self.span(then));
        self.resume_if_reached(no);
        let value = otherwise.map(|otherwise| self.expr(otherwise)).unwrap_or_default();
        self.end_branch_of(&join, &value, otherwise, otherwise.map_or(span, |otherwise| self.span(otherwise)));
        let value = self.close_join(&join);
        let number = self.taken_by_build(condition, then, otherwise).and_then(|taken| self.number(taken));
        Value { head: number.map(|number| number.to_string()).or(value.head), ..value }
    }

    /// What a branch gives that the build chooses: `if cfg!(feature = "fine") { 4 } else { 1 }`.
    fn taken_by_build(&self, condition: ExprId, then: ExprId, otherwise: Option<ExprId>) -> Option<ExprId> {
        let body = self.body();
        let answer = match &body.expr(condition).kind {
            ExprKind::Macro(call) => call.kind.built()?,
            _ => return None,
        };
        match &body.expr(if answer { then } else { otherwise? }).kind {
            ExprKind::Block(block) if block.stmts.is_empty() => block.tail,
            _ => None,
        }
    }

    /// Goes on from a node if something leads to it.
    pub(super) fn resume_if_reached(&mut self, node: NodeId) {
        self.at = self.reached[node.0 as usize].then_some(node);
    }

    /// Lowers a condition; control goes on where it holds, and leads to `no` where it does not.
    pub(super) fn condition(&mut self, id: ExprId, no: NodeId) {
        if self.at.is_none() {
            return;
        }
        let body = self.body();
        let connective = self.connective(id);
        match &body.expr(id).kind {
            ExprKind::Binary { lhs, rhs, .. } if connective == Some("&&") => {
                self.condition(*lhs, no);
                self.condition(*rhs, no);
            }
            ExprKind::Binary { lhs, rhs, .. } if connective == Some("||") => {
                let span = self.span(id);
                let holds = self.add_node(crate::flow::Effect::Nothing, span);
                let second = self.add_node(crate::flow::Effect::Nothing, self.span(*rhs));
                self.condition(*lhs, second);
                self.jump(holds);
                self.resume_if_reached(second);
                self.condition(*rhs, no);
                self.jump(holds);
                self.resume_if_reached(holds);
            }
            ExprKind::Not(inner) => {
                let holds = self.add_node(crate::flow::Effect::Nothing, self.span(id));
                self.condition(*inner, holds);
                self.jump(no);
                self.resume_if_reached(holds);
            }
            ExprKind::Let { pat, value } if self.asks_for_yes(*pat, *value) => {
                let (span, text, about) = (self.span(id), self.text(id), self.about(*value));
                self.expr(*value);
                if self.at.is_some() {
                    let (yes, failed) = self.opaque_branch(span, text, about);
                    self.link(failed, no);
                    self.resume(yes);
                }
            }
            ExprKind::Let { pat, value } => {
                let given = self.asked_value(*value);
                let span = self.body().pat(*pat).span.to(self.span(*value));
                self.note_handed(*pat);
                self.match_pattern(*pat, *value, &given, span, no);
            }
            ExprKind::Block(block) if block.stmts.is_empty() && block.label.is_none() && block.tail.is_some() => {
                if let Some(tail) = block.tail {
                    self.condition(tail, no);
                }
            }
            // `ready() && { f.update(x); true }`
            ExprKind::Block(block)
                if block.label.is_none()
                    && let Some(answer) = self.constant_tail(block) =>
            {
                self.expr(id);
                if !answer {
                    self.jump(no);
                }
            }
            ExprKind::Literal(Literal::Bool(value)) => {
                if !value {
                    self.jump(no);
                }
            }
            ExprKind::Macro(_) | ExprKind::Path(_) if self.constants().asks_for_debug_build(id, 0) => {
                // The name of a constant, or of a macro around it, does not tell what is asked.
                let text = Some(self.text(id)).filter(|text| text.contains("debug_assertions"));
                let text = text.unwrap_or_else(|| "cfg!(debug_assertions)".to_owned());
                let (holds, failed) = self.debug_branch(self.span(id), text);
                self.link(failed, no);
                self.resume(holds);
            }
            ExprKind::Macro(call) if let MacroKind::Build(flag) = &call.kind => {
                let (holds, failed) = self.branch_on_build(flag, self.span(id), self.text(id));
                self.link(failed, no);
                self.resume(holds);
            }
            ExprKind::Macro(_) | ExprKind::Path(_) | ExprKind::Field { .. } | ExprKind::Deref(_) => self.truth(id, no),
            // `for (every, task) in [(1, Task::Fast), (10, Task::Slow)] { if cycle % every == 0 { … } }`
            ExprKind::Binary { op: op @ ("==" | "!="), lhs, rhs } if self.is_whole_multiple(*lhs, *rhs) => {
                self.expr(*lhs);
                if *op == "!=" {
                    self.jump(no);
                }
            }
            ExprKind::Binary { op, lhs, rhs } if matches!(*op, "==" | "!=" | "<" | "<=" | ">" | ">=") => {
                self.comparison(id, op, *lhs, *rhs, no);
            }
            ExprKind::Binary { lhs, rhs, .. } if connective == Some("!=") => self.comparison(id, "!=", *lhs, *rhs, no),
            ExprKind::MethodCall { receiver, method, args, .. }
                if args.is_empty() && presence_head(method).is_some() =>
            {
                self.presence(id, *receiver, method, no);
            }
            ExprKind::MethodCall { receiver, method, args, .. }
                if self.spelled_comparison(id, *receiver, method, args, no) => {}
            ExprKind::MethodCall { receiver, method, args, .. }
                if self.payload_condition(id, *receiver, method, args, no) => {}
            ExprKind::MethodCall { receiver, method, args, .. }
                if method == "contains" && self.range_condition(id, *receiver, args, no) => {}
            ExprKind::MethodCall { receiver, args, .. }
                if self.answer_at_rest(id).is_none() && self.spoken_condition(id, *receiver, args, no) => {}
            ExprKind::Call { args, .. }
                if args.split_first().is_some_and(|(first, more)| self.spoken_condition(id, *first, more, no)) => {}
            _ => self.truth(id, no),
        }
    }

    /// Whether two numbers are the same in any case, since all are multiples of one: `n % 1` and `0`.
    fn is_whole_multiple(&mut self, remainder: ExprId, none: ExprId) -> bool {
        match self.body().expr(remainder).kind {
            ExprKind::Binary { op: "%", rhs, .. } => self.number(rhs) == Some(1) && self.number(none) == Some(0),
            _ => false,
        }
    }

    /// How an operator connects two conditions: `a & b` is `a && b` where nothing happens in `b`.
    fn connective(&mut self, id: ExprId) -> Option<&'static str> {
        let ExprKind::Binary { op, lhs, rhs } = &self.body().expr(id).kind else { return None };
        let are_conditions = [*lhs, *rhs].iter().all(|side| *self.ty(*side) == Ty::Bool);
        match *op {
            "&&" | "||" => Some(op),
            "^" if are_conditions => Some("!="),
            "&" if are_conditions && self.pure(*rhs).is_some() => Some("&&"),
            "|" if are_conditions && self.pure(*rhs).is_some() => Some("||"),
            _ => None,
        }
    }

    /// `if let Ok(true) = imu.data_ready()`: the call is asked for a yes, whatever else it may give.
    fn asks_for_yes(&mut self, pat: PatId, value: ExprId) -> bool {
        let body = self.body();
        let PatKind::TupleStruct(path, inner) = &body.pat(pat).kind else { return false };
        let [inner] = inner.as_slice() else { return false };
        matches!(path.last(), "Ok" | "Some")
            && matches!(&body.pat(*inner).kind, PatKind::Literal(text) if text == "true")
            && matches!(body.expr(value).kind, ExprKind::MethodCall { .. } | ExprKind::Call { .. })
            && self.is_optional(value)
            && self.pure(value).is_none()
    }

    /// A condition that is one value: a variable, a field, a call.
    fn truth(&mut self, id: ExprId, no: NodeId) {
        let told = self.told_length(id).map(|length| (length, "0")).or_else(|| Some((self.opposite(id)?, "false")));
        let (pure, head) = match told {
            Some((pure, head)) => (Some(pure), head),
            None => (self.pure(id), "true"),
        };
        let about = About { rest: self.answer_at_rest(id), stands_in: self.stands_in(id), ..self.about(id) };
        let about = About { stands_in: about.stands_in && !about.is_constant, ..about };
        let value = match &self.body().expr(id).kind {
            // What is a condition as a value is not asked for twice.
            ExprKind::MethodCall { receiver, method, args, .. } => self.method_expr(id, *receiver, method, args),
            _ => self.expr(id),
        };
        if self.at.is_none() {
            return;
        }
        let span = self.span(id);
        let text = self.text(id);
        let total = (head != "0").then(|| vec!["true".to_owned(), "false".to_owned()]);
        // The result of a call is a variable of its own, whose head the callee may know.
        let pure = pure.or_else(|| value.same_as.map(|var| self.pure_var(var)));
        let (yes, failed) = match pure {
            Some(pure) => {
                // A row of a table that is written out says the same for ever.
                let of_row = pure.whole.as_ref().filter(|whole| whole.steps.is_empty()).and_then(Place::base_var);
                let is_written = of_row.is_some_and(|var| self.graph.written_rows.contains(&var));
                let about = About { is_constant: about.is_constant || is_written || pure.reads.is_empty(), ..about };
                let id = self.subject(pure, total.clone());
                for head in total.iter().flatten() {
                    self.head_bit(id, head);
                }
                self.branch_on_subject(id, &[head.to_owned()], true, span, text, about)
            }
            None => self.opaque_branch(span, text, about),
        };
        self.link(failed, no);
        self.resume(yes);
    }

    /// The length that is asked whether it is zero: `frame.is_empty()`.
    fn told_length(&mut self, id: ExprId) -> Option<Pure> {
        let ExprKind::MethodCall { method, .. } = &self.body().expr(id).kind else { return None };
        let is_known = matches!(self.typed().callees.get(&id), Some(Callee::Builtin));
        let empty = self.pure(id).filter(|_| method == "is_empty" && is_known)?;
        let key = format!("{}.len()", empty.key.strip_suffix(".is_empty()")?);
        Some(Pure { key, ..empty })
    }

    /// The question of which a method asks the opposite.
    fn opposite(&mut self, id: ExprId) -> Option<Pure> {
        let ExprKind::MethodCall { method, args, .. } = &self.body().expr(id).kind else { return None };
        let is_own = matches!(self.typed().callees.get(&id), Some(Callee::Resolved(_)));
        let (_, other) = OPPOSITES.iter().find(|(name, _)| name == method && args.is_empty() && !is_own)?;
        let pure = self.pure(id)?;
        let key = format!("{}{other}()", pure.key.strip_suffix(&format!("{method}()"))?);
        Some(Pure { key, ..pure })
    }

    /// The answer that says that a filter is at rest, if that is what an expression asks it.
    fn answer_at_rest(&self, id: ExprId) -> Option<bool> {
        let ExprKind::MethodCall { receiver, method, .. } = &self.body().expr(id).kind else { return None };
        let (_, answer) = RESTS.iter().find(|(name, _)| name == method)?;
        let is_filter = self.program.index.filter_spec(self.ty(*receiver).peel()).is_some();
        is_filter.then_some(*answer)
    }

    /// The truth value that is made a number: `ready as u8`, `u8::from(ready)`.
    pub(super) fn truth_of(&self, id: ExprId) -> Option<ExprId> {
        let truth = match &self.body().expr(id).kind {
            ExprKind::Cast { value, .. } if *self.ty(id) == Ty::Int => *value,
            ExprKind::Call { callee, args } => match (&self.body().expr(*callee).kind, args.as_slice()) {
                (ExprKind::Path(path), [value]) if makes_number(&path.text()) => *value,
                _ => return None,
            },
            _ => return None,
        };
        (*self.ty(truth).peel() == Ty::Bool).then_some(truth)
    }

    /// The number that stands for a truth value: it is one where that holds.
    pub(super) fn truth_as_number(&mut self, id: ExprId) -> Value {
        let Some(truth) = self.truth_of(id) else { return Value::default() };
        self.chosen_by(id, truth, Ty::Int, ["1", "0"])
    }

    /// `ready as u8 == 1` asks whether it is ready. Answers whether it is such a comparison.
    fn truth_compared(&mut self, id: ExprId, op: &str, lhs: ExprId, rhs: ExprId, no: NodeId) -> bool {
        let Some(value) = self.truth_of(lhs) else { return false };
        let holds = match (op, self.number(rhs)) {
            ("==" | ">=", Some(1)) | ("!=" | ">", Some(0)) => true,
            ("==" | "<=", Some(0)) | ("!=" | "<", Some(1)) => false,
            _ => return false,
        };
        if holds {
            self.condition(value, no);
        } else {
            let otherwise = self.add_node(crate::flow::Effect::Nothing, self.span(id));
            self.condition(value, otherwise);
            self.jump(no);
            self.resume_if_reached(otherwise);
        }
        true
    }

    pub(super) fn comparison(&mut self, id: ExprId, op: &str, lhs: ExprId, rhs: ExprId, no: NodeId) {
        if let Some((op, [lhs, rhs])) = self.compared_order(op, [lhs, rhs]) {
            return self.comparison(id, op, lhs, rhs, no);
        }
        if self.truth_compared(id, op, lhs, rhs, no)
            || self.bit_asked(id, op, [lhs, rhs], no)
            || self.counters_compared(id, op, [lhs, rhs], no)
        {
            return;
        }
        let span = self.span(id);
        let text = self.text(id);
        let about = self.about(id);
        let counted = self.counted(op, lhs, rhs);
        let (subject, heads, negated) = self.compared(op, lhs, rhs);
        let sides = [(lhs, self.expr(lhs)), (rhs, self.expr(rhs))];
        if self.at.is_none() {
            return;
        }
        let differs = self.other_outcome(op, &sides, span, &text, &about);
        let (subject, heads, negated) = match subject {
            None => self.compared_result(op, &sides),
            Some(subject) => (Some(subject), heads, negated),
        };
        if let Some((counter, numbers)) = counted {
            let (yes, failed) = self.branch_on_number(counter, &numbers, span, text, about);
            self.link(failed, no);
            self.resume(yes);
            return;
        }
        let (yes, failed) = match subject {
            Some((pure, total)) => {
                let about = About { is_constant: pure.reads.is_empty(), is_turned: negated, ..about };
                let variants = self.told_variants(&pure, total.as_deref());
                let subject = self.subject(pure, total);
                for head in heads.iter().chain(&variants) {
                    self.head_bit(subject, head);
                }
                if self.holds_in_one_round(op, lhs, rhs) {
                    self.note_one_round(subject);
                } else {
                    self.note_ends(lhs);
                    self.note_number(subject, op, lhs, rhs);
                    self.note_order(subject, op, lhs, rhs);
                }
                self.branch_on_subject(subject, &heads, true, span, text, about)
            }
            None => self.opaque_branch(span, text, about),
        };
        let (yes, failed) = if negated { (failed, yes) } else { (yes, failed) };
        if let Some(differs) = differs {
            self.link(differs, if op == "==" { failed } else { yes });
        }
        self.link(failed, no);
        self.resume(yes);
    }

    /// What a comparison asks about, in one spelling: `a != X` is `a == X` turned round, `a >= b` is `a < b` turned round.
    fn compared(&mut self, op: &str, lhs: ExprId, rhs: ExprId) -> (Option<Compared>, Vec<Head>, bool) {
        let negated = matches!(op, "!=" | ">=" | ">");
        // Which variant two states are is asked of the states.
        let told = self.told_variant(lhs).zip(self.told_variant(rhs)).filter(|_| matches!(op, "==" | "!="));
        let (lhs, rhs) = told.unwrap_or((lhs, rhs));
        if matches!(op, "==" | "!=") {
            for (subject, constant) in [(lhs, rhs), (rhs, lhs)] {
                if self.constants().is_exact(constant)
                    && let Some(head) = self.constant_head(constant)
                    && !matches!(self.body().expr(subject).kind, ExprKind::Literal(_))
                    && let Some(pure) = self.pure(subject)
                {
                    let total = self.all_heads(subject);
                    return (Some((pure, total)), vec![head], negated);
                }
            }
        }
        let (Some(left), Some(right)) = (self.pure(lhs), self.pure(rhs)) else {
            return (None, Vec::new(), false);
        };
        let is_float = *self.ty(lhs) == Ty::Float || *self.ty(rhs) == Ty::Float;
        if let Some(orders) = orders_asked(op).filter(|_| is_float) {
            let key = format!("({} <=> {})", left.key, right.key);
            let reads = [left.reads, right.reads].concat();
            let to_heads = |orders: &[&str]| orders.iter().map(|order| (*order).to_owned()).collect();
            return (Some((Pure { key, reads, ..Pure::default() }, Some(to_heads(&ORDERS)))), to_heads(orders), false);
        }
        let (symbol, negated) = match op {
            "==" | "!=" => ("==", op == "!="),
            ">=" => ("<", true),
            ">" => ("<=", true),
            other => (other, false),
        };
        if symbol == "==" && self.is_state(self.ty(lhs)) {
            // What is known of one side is known of the other where they are equal.
            for side in [&left, &right] {
                if side.whole.is_some() {
                    self.state_subject(side.clone(), lhs);
                }
            }
        }
        let mut reads = left.reads;
        reads.extend(right.reads);
        let variant = if told.is_some() { "the variant of " } else { "" };
        let key = format!("({variant}{} {symbol} {})", left.key, right.key);
        let total = Some(vec!["true".to_owned(), "false".to_owned()]);
        (Some((Pure { key, reads, ..Pure::default() }, total)), vec!["true".to_owned()], negated)
    }

    /// The value whose variant an expression tells: `mem::discriminant(&mode)`.
    pub(super) fn told_variant(&self, id: ExprId) -> Option<ExprId> {
        match (&self.body().expr(id).kind, self.typed().callees.get(&id)) {
            (ExprKind::Call { args, .. }, Some(Callee::External(path))) if path == "std::mem::discriminant" => {
                args.first().copied()
            }
            _ => None,
        }
    }

    /// `x.is_some()` and its kin.
    fn presence(&mut self, id: ExprId, receiver: ExprId, method: &str, no: NodeId) {
        let Some(head) = presence_head(method) else { return };
        let pure = self.pure_option(receiver);
        let mut about = self.about(id);
        about.is_presence = true;
        let value = self.expr(receiver);
        if self.at.is_none() {
            return;
        }
        self.discard_asked(receiver, &value);
        let span = self.span(id);
        let text = self.text(id);
        let pure = pure.or_else(|| value.same_as.map(|var| self.pure_var(var)));
        let (yes, failed) = match pure {
            Some(pure) => {
                let id = self.subject(pure, Some(vec!["+".to_owned(), "-".to_owned()]));
                self.head_bit(id, "+");
                self.head_bit(id, "-");
                self.branch_on_subject(id, &[head.to_owned()], true, span, text, about)
            }
            None => self.opaque_branch(span, text, about),
        };
        self.link(failed, no);
        self.resume(yes);
    }

    /// A condition whose truth is a value: `let ready = a && b;`
    pub(super) fn condition_value(&mut self, id: ExprId) -> Value {
        self.chosen_by(id, id, Ty::Bool, ["true", "false"])
    }

    /// The same turned round.
    pub(super) fn opposite_value(&mut self, id: ExprId) -> Value {
        self.chosen_by(id, id, Ty::Bool, ["false", "true"])
    }

    /// One of two values, by whether a condition holds.
    fn chosen_by(&mut self, id: ExprId, condition: ExprId, ty: Ty, heads: [&str; 2]) -> Value {
        let span = self.span(id);
        let join = self.new_join(ty, span);
        let no = self.add_node(crate::flow::Effect::Nothing, span);
        self.condition(condition, no);
        let [holds, fails] = heads.map(|head| Value { head: Some(head.to_owned()), ..Value::default() });
        self.end_branch(&join, &holds, span);
        self.resume_if_reached(no);
        self.end_branch(&join, &fails, span);
        self.close_join(&join)
    }
}

/// Whether a path is the conversion into a whole number: `u8::from`.
fn makes_number(path: &str) -> bool {
    let number = path.strip_suffix("::from").and_then(|number| number.strip_prefix(['u', 'i']));
    number.is_some_and(|size| matches!(size, "8" | "16" | "32" | "64" | "128" | "size"))
}

/// What a method asks of an option or result.
pub(super) fn presence_head(method: &str) -> Option<&'static str> {
    match method {
        "is_some" | "is_ok" | "is_continue" => Some("+"),
        "is_none" | "is_err" | "is_break" => Some("-"),
        _ => None,
    }
}
