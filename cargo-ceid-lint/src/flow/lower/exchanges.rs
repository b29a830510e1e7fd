//! Values that change places: `mem::swap`, and what puts the elements of a collection in another order.

use super::parts::given_to;
use super::{Builder, Value};
use crate::flow::{Assignment, Cause, Effect, IndexKey, Place, Transfer};
use crate::index::Ty;
use crate::source::Span;
use crate::syntax::tree::{ExprId, ExprKind};

impl Builder<'_> {
    /// `mem::swap(&mut a, &mut b)`: the instances change places.
    pub(super) fn swap(&mut self, id: ExprId, args: &[ExprId]) -> Value {
        let values = self.values(args);
        let span = self.span(id);
        if let [left, right] = values.as_slice()
            && let (Some(a), Some(b)) = (left.place.clone(), right.place.clone())
        {
            if [&a, &b].into_iter().any(|place| self.is_lent_by_call(place)) {
                // Which place that is, the names of its value do not tell: they would stay where they are.
                let cause = Cause::Code(format!("what changes places by `{}`", self.text(id)));
                self.emit(Effect::Unknown { places: vec![a.clone(), b.clone()], cause }, span);
                self.written_unseen(a, span);
                self.written_unseen(b, span);
                return Value::default();
            }
            let given = [args[1], args[0]].map(Some);
            self.exchange([&a, &b], given, self.ty(args[0]).peel().clone(), span);
        } else {
            // What has no name gives a new value.
            for place in values.into_iter().filter_map(|value| value.place) {
                self.written_unseen(place, span);
            }
        }
        Value::default()
    }

    /// Whether a place is what a call or an index of the analysed code leads to: `mem::swap(&mut self.pool[key], &mut self.spare)`.
    fn is_lent_by_call(&self, place: &Place) -> bool {
        let info = place.base_var().map(|var| self.graph.var(var));
        info.is_some_and(|info| info.name.is_empty() && info.param.is_none())
    }

    /// `(a, b) = (b, a)` is the same. Answers whether an assignment is one.
    pub(super) fn swap_by_tuples(&mut self, id: ExprId, target: ExprId, value: ExprId) -> bool {
        let body = self.body();
        let (ExprKind::Tuple(places), ExprKind::Tuple(parts)) = (&body.expr(target).kind, &body.expr(value).kind)
        else {
            return false;
        };
        let ([first, second], [left, right]) = (places.as_slice(), parts.as_slice()) else { return false };
        if self.at.is_none() || !self.may_hold_filter(self.ty(*first)) {
            return false;
        }
        let [to_first, to_second, from_left, from_right] =
            [first, second, left, right].map(|id| self.static_place(*id));
        let (Some(a), Some(b)) = (to_first, to_second) else { return false };
        let is_swap = from_right.as_ref() == Some(&a) && from_left.as_ref() == Some(&b) && !a.overlaps(&b);
        if is_swap {
            self.exchange([&a, &b], [Some(*left), Some(*right)], self.ty(*left).clone(), self.span(id));
        }
        is_swap
    }

    /// Two places change their values; what is given to each is noted where it is an expression.
    fn exchange(&mut self, [a, b]: [&Place; 2], [to_a, to_b]: [Option<ExprId>; 2], ty: Ty, span: Span) {
        let is_option = self.is_option_of_references(&ty);
        let between = self.temporary(ty, span);
        if is_option {
            self.may_be_asked(a, between);
            self.may_be_asked(b, between);
        }
        let between = Place::var(between);
        for (place, from, given) in [(&between, a, None), (a, b, to_a), (b, &between, to_b)] {
            let assignment = Assignment { from: Some(from.clone()), ..given_to(place.clone(), None) };
            let at = self.emit(Effect::Set(Box::new(assignment)), span);
            if is_option {
                self.graph.copies.insert(at, from.clone());
            }
            if place.base_var().is_some_and(|var| self.refers_to_references(var)) {
                self.graph.pointed.insert(at);
            }
            if let Some(given) = given {
                self.note_given(place, given);
            }
        }
    }

    /// `bank.swap(0, 1)`, `bank.reverse()` and their kin: the elements change places. Answers whether it is one.
    pub(super) fn reordered(
        &mut self,
        id: ExprId,
        receiver: ExprId,
        method: &str,
        args: &[ExprId],
        value: &Value,
    ) -> bool {
        let Some(place) = value.place.clone() else { return false };
        let span = self.span(id);
        self.values(args);
        self.leaves_pool(id, method, value, args);
        let key = |this: &mut Self, arg: &ExprId| match this.index_key(*arg)? {
            IndexKey::Number(number) => Some(place.element(IndexKey::Number(number))),
            _ => None,
        };
        let keys: Vec<Option<Place>> = args.iter().map(|arg| key(self, arg)).collect();
        match keys.as_slice() {
            [Some(a), Some(b)] if method == "swap" => self.exchange([a, b], [None, None], Ty::Unknown, span),
            _ if self.shuffle_references(id, receiver, &place) => {}
            _ => {
                let element = place.element(IndexKey::Data("…".into()));
                let cause = Cause::Reordered(self.text(id));
                self.emit(Effect::Unknown { places: vec![element], cause }, span);
            }
        }
        true
    }

    /// The whole content of a wrapper is replaced.
    pub(super) fn write_whole(&mut self, value: &Value, given: &Value, span: Span) {
        self.keep_closure(given, span);
        self.lose_made(given);
        let Some(place) = &value.place else { return };
        if self.at.is_none() {
            return;
        }
        let assignment = Assignment {
            place: Place::clone(place),
            from: given.place.clone(),
            transfer: Transfer::Move,
            rebinds: false,
            head: given.head.clone(),
            same_as: None,
        };
        self.emit(Effect::Write(Box::new(assignment)), span);
    }

    /// `settings.clone_from(&other)`
    pub(super) fn cloned_from(&mut self, value: &Value, given: ExprId, span: Span) -> Value {
        let from = self.expr(given);
        let ty = self.ty(given).peel().clone();
        // What is put there is what `other.clone()` gives.
        let from = match self.may_hold_filter(&ty) {
            true => self.copy_of(&from, ty, span),
            false => Value { place: None, ..from },
        };
        self.write_whole(value, &from, span);
        if let Some(place) = &value.place {
            self.note_given(place, given);
        }
        Value::default()
    }

    /// `bank.fill_with(Lag::new)`: each element is what the closure gives, a new one unless that is moved out of somewhere.
    pub(super) fn fill_with(&mut self, receiver: ExprId, given: ExprId, value: &Value, span: Span) -> Value {
        let filled = self.expr(given).closure.and_then(|closure| self.fill_loop(closure, span));
        let is_new = match filled {
            Some(filled) => {
                let from = filled.place.as_ref().and_then(Place::base_var).map(|var| self.graph.var(var));
                from.is_none_or(|info| info.name.is_empty() || self.program.index.copies_filter(&info.ty))
            }
            // `Default::default`
            None => matches!(self.body().expr(given).kind, ExprKind::Path(_)) && self.static_place(given).is_none(),
        };
        let has_destructor = self.program.index.leads_to_destructor(self.ty(receiver));
        if is_new && !has_destructor && self.makes_anew(receiver, "fill_with") {
            self.write_whole(value, &Value::default(), span);
            self.note_pointed(self.ty(receiver).peel());
        }
        Value::default()
    }

    /// Whether a method makes a collection of filters anew: one without elements is a new one, and so is one of which each element is.
    pub(super) fn makes_anew(&mut self, receiver: ExprId, method: &str) -> bool {
        let is_named = matches!(self.body().expr(receiver).kind, ExprKind::Path(_) | ExprKind::Field { .. });
        match &self.ty(receiver).peel().clone() {
            Ty::Array(element, _) => method != "clear" && is_named && self.may_hold_filter(element),
            // Another slice may be a part of what it was made of.
            Ty::Slice(element) => method != "clear" && self.may_hold_filter(element) && self.is_given_slice(receiver),
            _ => (method == "clear" || is_named) && self.is_collection_of_filters(receiver),
        }
    }

    /// Whether a slice is all of what the function was lent.
    fn is_given_slice(&mut self, slice: ExprId) -> bool {
        let is_whole = matches!(self.ty(slice), Ty::Ref(true, _));
        let var = self.static_place(slice).filter(|place| is_whole && place.steps.is_empty());
        let var = var.and_then(|place| place.base_var());
        var.is_some_and(|var| self.graph.var(var).param.is_some() && !self.is_assigned(var))
    }

    fn is_collection_of_filters(&self, id: ExprId) -> bool {
        let ty = self.ty(id).peel();
        matches!(ty, Ty::External(..)) && self.may_hold_filter(ty) && self.program.index.law_spec(ty).is_none()
    }
}

/// Whether a method of a slice puts its elements in another order, and none of them elsewhere.
pub(super) fn reorders(method: &str, args: usize) -> bool {
    match method {
        "swap" => args == 2,
        "reverse" | "sort" | "sort_unstable" => args == 0,
        "rotate_left"
        | "rotate_right"
        | "sort_by"
        | "sort_by_key"
        | "sort_by_cached_key"
        | "sort_unstable_by"
        | "sort_unstable_by_key"
        | "select_nth_unstable" => args == 1,
        _ => false,
    }
}
