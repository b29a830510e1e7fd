//! Assignments: how the value goes on from the one before, and whether they write the whole state of a filter.

use std::collections::BTreeSet;

use super::{Builder, Value};
use crate::flow::{Change, ChangeKind, Effect, NodeId, Place, Var};
use crate::index::Ty;
use crate::source::Span;
use crate::syntax::tree::{ExprId, ExprKind, PatKind};
use crate::types::{Callee, LocalId};

/// The fields of a filter that a block has written so far.
pub(super) type WrittenFields = Vec<(Place, BTreeSet<String>)>;

/// What holds a value before an assignment, and the name that an arm gives it: `match n { 3 => 0, last => last + 1 }`.
#[derive(Clone, Copy)]
struct Before<'p> {
    place: Option<&'p Place>,
    name: Option<LocalId>,
}

impl Builder<'_> {
    /// Notes what the assignment at the last node does.
    pub(super) fn note_change(&mut self, target: ExprId, value: ExprId, op: Option<&str>) {
        let Some(at) = self.at else { return };
        if !matches!(self.graph.node(at).effect, Effect::Set(_) | Effect::Write(_)) {
            return;
        }
        let computed = self.computed_from(value);
        self.note_copy(value);
        let kind = match op {
            None => {
                let place = self.static_place(target);
                self.change_kind(place.as_ref(), value)
            }
            Some("%") => ChangeKind::Wraps,
            Some(op @ ("+" | "-")) => self.added(target, value, op == "+"),
            Some("^") if matches!(self.constant_head(value).as_deref(), Some("true" | "1")) => ChangeKind::Toggles,
            Some("|") if *self.ty(target).peel() == Ty::Int => ChangeKind::Raises,
            Some("&") if *self.ty(target).peel() == Ty::Int => ChangeKind::Lowers,
            Some(_) => ChangeKind::Other,
        };
        let is_asked = op.is_none() && *self.ty(target).peel() == Ty::Bool && self.constant_head(value).is_none();
        let about = is_asked.then(|| Box::new(self.about(value)));
        let goes_round = match kind {
            ChangeKind::CountsUp => self.goes_round(target, value),
            // Nobody takes one from nothing but to come round.
            ChangeKind::CountsDown => self.is_wrapped(value) && self.goes_round(target, value),
            _ => false,
        };
        let tally = self.tally(target, value, op);
        self.graph.changes.insert(at, Change { computed, kind, goes_round, about, tally });
    }

    /// `flag &= value`, `flag |= value`: the flag stays what it is, or is taken down or raised.
    pub(super) fn assign_if(&mut self, id: ExprId, op: &str, target: ExprId, value: ExprId) -> Value {
        let bases = self.assigned_vars(target);
        self.derive(&bases, value);
        self.derive_owner(target, value);
        let span = self.span(id);
        let (no, after) = (self.add_node(Effect::Nothing, span), self.add_node(Effect::Nothing, span));
        self.condition(value, no);
        let raises = op == "|";
        if !raises {
            self.jump(after);
            self.resume_if_reached(no);
        }
        let head = if raises { "true" } else { "false" };
        self.assign_to(target, &Value { head: Some(head.to_owned()), ..Value::default() }, value, span);
        self.note_change(target, value, Some(op));
        self.jump(after);
        if raises {
            self.resume_if_reached(no);
            self.jump(after);
        }
        self.resume_if_reached(after);
        Value::default()
    }

    /// `flag = flag || value`: the flag is raised, or stays down.
    pub(super) fn assign_raised(&mut self, id: ExprId, target: ExprId, value: ExprId) -> bool {
        let ExprKind::Binary { op: "||", lhs, rhs } = self.body().expr(value).kind else { return false };
        let Some(place) = self.static_place(target).filter(|_| *self.ty(target) == Ty::Bool) else { return false };
        let other = match [lhs, rhs].map(|side| self.static_place(side).as_ref() == Some(&place)) {
            [true, false] => rhs,
            [false, true] => lhs,
            _ => return false,
        };
        // What is asked beside it may change the flag by itself.
        if self.computed_from(other).places.iter().any(|read| read.overlaps(&place)) {
            return false;
        }
        let bases = self.assigned_vars(target);
        self.derive(&bases, value);
        self.derive_owner(target, value);
        let span = self.span(id);
        let no = self.add_node(Effect::Nothing, span);
        self.condition(value, no);
        if self.at.is_some() {
            self.assign_to(target, &Value { head: Some("true".to_owned()), ..Value::default() }, value, span);
            self.note_change(target, value, Some("|"));
        }
        self.jump(no);
        self.resume_if_reached(no);
        true
    }

    /// `flag ^= true`: the flag is turned round.
    pub(super) fn assign_opposite(&mut self, id: ExprId, target: ExprId, value: ExprId) -> Value {
        let opposite = self.opposite_value(target);
        if self.at.is_some() {
            self.assign_to(target, &opposite, value, self.span(id));
            self.note_change(target, value, Some("^"));
        }
        Value::default()
    }

    /// Whether a count that goes up in a small number is not held where that ends.
    fn goes_round(&self, target: ExprId, value: ExprId) -> bool {
        let is_small = |int: String| matches!(int.trim_start_matches(['u', 'i']), "8" | "16");
        let is_method = matches!(self.body().expr(value).kind, ExprKind::MethodCall { .. });
        (!is_method || self.is_wrapped(value)) && self.int_of(target).is_some_and(is_small)
    }

    fn is_wrapped(&self, value: ExprId) -> bool {
        matches!(&self.body().expr(value).kind, ExprKind::MethodCall { method, .. } if method.starts_with("wrapping"))
    }

    /// Notes that the last node gives a place the value of an expression: `mem::replace(&mut last, now)`.
    pub(super) fn note_given(&mut self, place: &Place, value: ExprId) {
        let Some(at) = self.at else { return };
        let (computed, kind) = (self.computed_from(value), self.change_kind(Some(place), value));
        self.graph.changes.insert(at, Change { computed, kind, goes_round: false, about: None, tally: None });
    }

    /// Notes that the last node puts the value of an expression into an option.
    pub(super) fn note_filled(&mut self, value: ExprId) {
        let Some(at) = self.at else { return };
        let (computed, kind) = (self.computed_from(value), ChangeKind::Fills);
        let change = Change { computed, kind, goes_round: false, about: None, tally: None };
        self.graph.changes.insert(at, change);
    }

    /// Notes that the last node gives a copy of what a place holds: `let state = self.state`.
    pub(super) fn note_copy(&mut self, value: ExprId) {
        // A number is a state where it is asked which one it is, as is found out at the end.
        let is_number = |this: &Self, at: NodeId| {
            matches!(this.ty(value), Ty::Int | Ty::Float | Ty::Char)
                && matches!(&this.graph.node(at).effect, Effect::Set(set) if set.same_as.is_none())
        };
        if let Some(at) = self.at
            && matches!(self.graph.node(at).effect, Effect::Set(_) | Effect::Write(_))
            && (self.is_state(self.ty(value)) || self.is_plain_option(self.ty(value)) || is_number(self, at))
            && !matches!(self.ty(value), Ty::Ref(..))
            && let Some(place) = self.state_named(value)
        {
            self.graph.copies.insert(at, place);
        }
    }

    /// The place of a state that is read by its name or by a getter: `self.state`, `self.state()`.
    fn state_named(&mut self, value: ExprId) -> Option<Place> {
        match &self.body().expr(value).kind {
            ExprKind::Field { .. } => self.static_place(value),
            // A copy of a variable: `let before = armed;`
            ExprKind::Path(_) => self.static_place(value).filter(|place| place.base_var().is_some()),
            ExprKind::MethodCall { .. } => self.state_behind(value).or_else(|| self.state_in_cell(value)),
            ExprKind::Deref(_) => self.state_in_cell(value),
            _ => None,
        }
    }

    /// Notes that the last node gives a variable the state that a part of a value holds.
    pub(super) fn note_copied_part(&mut self, var: Var, value: &Value) {
        if value.place.as_ref().is_some_and(|place| !place.steps.is_empty()) {
            self.note_taken(var, value);
        }
    }

    /// The same for what was taken out of a place as a whole: `mem::replace(&mut state, State::Idle)`.
    pub(super) fn note_taken(&mut self, var: Var, value: &Value) {
        let ty = self.graph.var(var).ty.clone();
        let is_state = self.is_state(&ty) && !matches!(ty, Ty::Ref(true, _));
        let is_known = is_state || self.is_option_of_references(&ty);
        if let (Some(at), Some(place)) = (self.at.filter(|_| is_known), &value.place) {
            self.may_be_asked(place, var);
            self.graph.copies.insert(at, place.clone());
        }
    }

    /// What adding a value to a place, or taking it away, does.
    pub(super) fn added(&self, target: ExprId, value: ExprId, up: bool) -> ChangeKind {
        let is_number = matches!(self.ty(target).peel(), Ty::Int | Ty::Float);
        let counts = is_number && self.constant_head(value).is_some();
        match (counts, up) {
            (true, true) => ChangeKind::CountsUp,
            (true, false) => ChangeKind::CountsDown,
            (false, true) => ChangeKind::Accumulates,
            (false, false) => ChangeKind::Spends,
        }
    }

    fn change_kind(&mut self, place: Option<&Place>, value: ExprId) -> ChangeKind {
        self.change_kind_at(Before { place, name: None }, value, 0)
    }

    fn change_kind_at(&mut self, before: Before<'_>, value: ExprId, depth: u32) -> ChangeKind {
        let body = self.body();
        // The head of `Some(now)` is constant, and `now` is not.
        let is_made = matches!(&body.expr(value).kind, ExprKind::Call { args, .. }
            if args.iter().any(|arg| self.constant_head(*arg).is_none()));
        if !is_made && self.constant_head(value).is_some() {
            return ChangeKind::Constant;
        }
        if depth > 8 {
            return ChangeKind::Other;
        }
        let is_same = |this: &mut Self, expr: ExprId| this.is_value_before(before, expr);
        match &body.expr(value).kind {
            ExprKind::Not(inner) if is_same(self, *inner) => ChangeKind::Toggles,
            ExprKind::Cast { value, .. } => self.change_kind_at(before, *value, depth + 1),
            ExprKind::Block(block) => match block.tail {
                Some(tail) => self.change_kind_at(before, tail, depth + 1),
                None => ChangeKind::Other,
            },
            // What starts anew where something else says so is no number that comes round.
            ExprKind::If { condition, then, otherwise: Some(otherwise) } => {
                let [then, otherwise] = [*then, *otherwise].map(|value| self.change_kind_at(before, value, depth + 1));
                let asks_it = before.place.is_some_and(|place| self.asks(*condition, place));
                if then == otherwise || asks_it { then.or(otherwise) } else { ChangeKind::Other }
            }
            ExprKind::Match { scrutinee, arms } if is_same(self, *scrutinee) => {
                let kinds = arms.iter().map(|arm| {
                    let is_name = matches!(body.pat(arm.pat).kind, PatKind::Bind { .. });
                    let name = self.typed().pat_local.get(&arm.pat).copied().filter(|_| is_name);
                    self.change_kind_at(Before { name, ..before }, arm.body, depth + 1)
                });
                kinds.reduce(ChangeKind::or).unwrap_or(ChangeKind::Other)
            }
            ExprKind::Binary { op: "%", lhs, .. } => {
                let inner = self.change_kind_at(before, *lhs, depth + 1);
                if inner.counts() { ChangeKind::Wraps } else { ChangeKind::Other }
            }
            // The low bits of a count come round.
            ExprKind::Binary { op: "&", lhs, rhs } => {
                let inner = self.change_kind_at(before, *lhs, depth + 1);
                let is_low = self.number(*rhs).and_then(|mask| mask.checked_add(1)).is_some_and(u64::is_power_of_two);
                if inner.counts() && is_low { ChangeKind::Wraps } else { inner }
            }
            ExprKind::Binary { op: "+", lhs, rhs } if is_same(self, *rhs) => self.added(*rhs, *lhs, true),
            ExprKind::Binary { op: op @ ("+" | "-"), lhs, rhs } if is_same(self, *lhs) => {
                self.added(*lhs, *rhs, *op == "+")
            }
            ExprKind::MethodCall { receiver, method, args, .. } => match (method.as_str(), args.as_slice()) {
                ("rem_euclid", [_]) => {
                    let inner = self.change_kind_at(before, *receiver, depth + 1);
                    if inner.counts() { ChangeKind::Wraps } else { ChangeKind::Other }
                }
                (
                    "wrapping_add" | "wrapping_sub" | "saturating_add" | "saturating_sub" | "checked_add"
                    | "checked_sub",
                    [step],
                ) if is_same(self, *receiver) => self.added(*receiver, *step, method.ends_with("_add")),
                ("unwrap" | "expect" | "unwrap_or" | "unwrap_or_default", _) => {
                    self.change_kind_at(before, *receiver, depth + 1)
                }
                // A count that is held at a bound is one.
                ("min" | "max" | "clamp", bounds) if bounds.iter().all(|bound| self.is_limit(before, *bound)) => {
                    self.held_count(before, *receiver, depth)
                }
                _ => ChangeKind::Other,
            },
            ExprKind::Call { callee, args } => match (&body.expr(*callee).kind, args.as_slice()) {
                (ExprKind::Path(path), [one, other])
                    if matches!(path.last(), "min" | "max")
                        && !matches!(self.typed().callees.get(&value), Some(Callee::Resolved(_))) =>
                {
                    let [is_first, is_second] = [*one, *other].map(|side| self.is_limit(before, side));
                    match (is_first, is_second) {
                        (false, true) => self.held_count(before, *one, depth),
                        (true, false) => self.held_count(before, *other, depth),
                        _ => ChangeKind::Other,
                    }
                }
                _ => ChangeKind::Other,
            },
            _ => ChangeKind::Other,
        }
    }

    /// How a value counts that is held at a bound, if it does.
    fn held_count(&mut self, before: Before<'_>, value: ExprId, depth: u32) -> ChangeKind {
        match self.change_kind_at(before, value, depth + 1) {
            ChangeKind::CountsUp => ChangeKind::CountsUpTo,
            ChangeKind::CountsDown => ChangeKind::CountsDownTo,
            _ => ChangeKind::Other,
        }
    }

    /// Whether a count may be held at a value: a constant, or another place.
    fn is_limit(&mut self, before: Before<'_>, value: ExprId) -> bool {
        let place = self.static_place(value);
        self.constant_head(value).is_some() || place.is_some_and(|place| Some(&place) != before.place)
    }

    /// Whether a condition is on a place, or a truth value that was computed from it.
    fn asks(&mut self, condition: ExprId, place: &Place) -> bool {
        let reads = self.computed_from(condition).places;
        let from = |var: Var| self.graph.computed.get(&var);
        let is_from = |read: &Place| read.base_var().and_then(from).is_some_and(|from| from.places.contains(place));
        reads.contains(place) || reads.iter().any(is_from)
    }

    /// Whether an expression is the value before, as it was.
    fn is_value_before(&mut self, before: Before<'_>, expr: ExprId) -> bool {
        let name = self.typed().expr_local.get(&expr);
        let is_named = before.name.is_some() && name == before.name.as_ref();
        is_named
            || before
                .place
                .is_some_and(|place| self.static_place(expr).as_ref() == Some(place) || self.reads_shared(expr, place))
    }

    /// Whether an expression is what a shared number holds, read there or into a variable: `COUNT.load(Relaxed)`, `self.count.get()`.
    fn reads_shared(&mut self, expr: ExprId, place: &Place) -> bool {
        let read = match self.body().expr(expr).kind {
            ExprKind::MethodCall { .. } => Some(self.computed_from(expr)),
            _ => self.static_place(expr).and_then(|read| self.graph.computed.get(&read.base_var()?).cloned()),
        };
        read.is_some_and(|read| {
            !read.calls.is_empty()
                && read.calls.iter().all(|name| super::flags::reads_shared_number(name))
                && read.places.contains(place)
        })
    }

    /// Takes note of a field of a filter that a statement writes. Once all of its state is written, that is a reset.
    pub(super) fn note_written_field(&mut self, statement: ExprId, written: &mut WrittenFields, span: Span) {
        let body = self.body();
        let ExprKind::Assign { place, .. } = &body.expr(statement).kind else { return };
        let ExprKind::Field { base, name } = &body.expr(*place).kind else { return };
        if self.at.is_none() {
            return;
        }
        let ty = self.ty(*base).peel();
        if self.program.index.filter_spec(ty).is_none() {
            return;
        }
        let Some(filter) = self.static_place(*base) else { return };
        let at = written.iter().position(|(known, _)| *known == filter).unwrap_or_else(|| {
            written.push((filter.clone(), BTreeSet::new()));
            written.len() - 1
        });
        let is_new = written[at].1.insert(name.clone());
        let state = self.state_fields(ty);
        if is_new && !state.is_empty() && state.contains(name) && state.is_subset(&written[at].1) {
            self.emit(Effect::Reset { place: filter, full: true }, span);
        }
    }
}
