//! Calls of what cannot be seen: what they get may be updated any number of times.

use super::calls::path_tail;
use super::stored::Holder;
use super::values::is_plain;
use super::{Builder, Value};
use crate::flow::{Caller, Cause, Effect};
use crate::index::Ty;
use crate::syntax::tree::ExprId;

impl Builder<'_> {
    /// A call of something that cannot be seen: what it gets by value or `&mut` may be updated any number of times.
    pub(super) fn unknown_call(&mut self, id: ExprId, text: String, exprs: &[ExprId], values: &[Value]) -> Value {
        if self.at.is_none() {
            return Value::default();
        }
        let span = self.span(id);
        if let Some(value) = self.runs_given(id, values) {
            return value;
        }
        self.lends_kept(id, &[], exprs, values);
        let mut takes_callback = self.takes_callback(id);
        let (mut places, mut moved) = (Vec::new(), Vec::new());
        for (expr, value) in exprs.iter().zip(values) {
            if let Some(closure) = value.closure {
                let is_future = self.is_of_future(closure);
                self.lose_captured(id, closure);
                if !is_future && !self.is_item(closure) && std::mem::take(&mut takes_callback) {
                    self.callback(closure, Caller::Framework, span);
                } else {
                    self.closure_for_unseen(closure, Holder::Unseen, Cause::Closure(path_tail(&text)), span);
                }
                continue;
            }
            self.keep_iterator(value, &Cause::Call(text.clone()), span);
            // What gives a state for the one that it looks at may be its law: `estimate = (self.step)(&estimate)`.
            let ty = self.ty(id).peel();
            if self.ty(*expr).peel() == ty && self.program.index.returned_spec(ty).is_some() {
                places.extend(value.place.clone());
            }
            // Of a copy, nothing comes back in a number: `f64::from(kf)`.
            let is_copy = self.program.index.copies_filter(self.ty(*expr)) && !self.is_receiver(id, *expr);
            let is_number = || is_plain(self.ty(id)) || *self.ty(id) == Ty::unit() || is_of_number(&text);
            let is_gone = is_copy && is_number();
            if let Some(place) = value.place.as_ref().filter(|_| is_gone || self.is_value_of_filter(*expr)) {
                self.note_use(place, *expr);
                // `sink(filter)`: the copy goes on where that leads.
                if is_gone && *self.ty(id) == Ty::unit() {
                    self.keep(value, *expr);
                }
            } else if let Some(place) = &value.place
                && (!self.is_shared(*expr)
                    || !self.program.index.shares_no_filter(self.ty(*expr), crate::types::is_lock))
                && !self.is_taken_shared(id, *expr)
            {
                if self.may_hold_filter(self.ty(*expr)) {
                    let is_kept = self.is_collection_of_references(self.ty(*expr).peel()) || self.stores_pointer(id);
                    if is_kept || self.is_shared_handle(*expr) {
                        self.graph.kept.push((place.clone(), Cause::Call(text.clone())));
                    }
                    let is_moved = !matches!(self.ty(*expr), Ty::Ref(..)) && !self.is_receiver(id, *expr);
                    moved.extend(is_moved.then(|| place.clone()));
                    places.push(place.clone());
                } else if !self.is_given_as_value(id, *expr) {
                    self.written_unseen(place.clone(), span);
                }
            }
        }
        if !places.is_empty() {
            let node = self.emit(Effect::Unknown { places: places.clone(), cause: Cause::Call(text.clone()) }, span);
            self.graph.given_away.extend(moved.into_iter().map(|place| (node, place)));
        }
        self.give_away(id, &[], exprs, values);
        self.may_write_cells(id, &text, exprs, span);
        if *self.ty(id) == Ty::Never && self.never_returns(id) {
            self.diverge(span);
        }
        // What comes back may be a borrow of what went in, but which part is not known.
        Value::default()
    }

    /// Whether a value of the type can be the state of a law that takes it as an argument, and holds no filter.
    pub(super) fn is_state_apart(&self, ty: &Ty) -> bool {
        let index = self.program.index;
        matches!(ty, Ty::External(path, args)
            if !path.starts_with("?::")
                && index.has_states_apart()
                && index.law_spec(ty).is_none()
                && args.iter().all(|arg| !index.holds_filter(arg)))
    }

    /// A method of a type that is not known, or that the type does not have in the analysed code.
    pub(super) fn unseen_method(&mut self, id: ExprId, receiver: ExprId, method: &str, args: &[ExprId]) -> Value {
        let value = self.expr(receiver);
        if let Some(converted) = self.converted(id, receiver, method, &value) {
            return converted;
        }
        if let Some(found) = self.method_by_name(id, receiver, method, args, &value) {
            return found;
        }
        if let Some(found) = self.leaves_collection(id, receiver, method, args, &value) {
            return found;
        }
        // `#[derive(Clone)] struct Handle(Arc<..>)`
        if method == "clone" && args.is_empty() && self.is_shared_handle(receiver) {
            return Value { is_owned: false, ..value };
        }
        let values = self.values(args);
        let ty = self.ty(receiver).peel();
        // What takes a mutable reference may write through it.
        let converts = matches!(method, "into" | "try_into") && matches!(self.ty(receiver), Ty::Ref(true, _));
        // What takes a value that is copied leaves the place as it is.
        let reads_only = super::borrowed::only_reads(method)
            || super::reading::asks(self.constants(), receiver, method)
            || matches!(method, "max" | "min" | "clamp") && self.program.index.copies_filter(ty);
        let index = self.program.index;
        let is_seen = index.opaque_items.is_empty() && !index.has_blanket_method(method);
        let is_own =
            matches!(ty, Ty::Adt(..)) && is_seen && !self.draws_by_itself(ty) && !index.implements_what_is_not_read(ty);
        // What a state hands out when it is asked for nothing is no update of it: its law is known, and takes it as an argument.
        let reads_only = reads_only || (args.is_empty() && self.is_state_apart(ty));
        if matches!(method, "into" | "try_into") && value.is_owned {
            // What it becomes cannot be seen, but it is there no more.
            self.keep(&value, receiver);
        }
        let mut exprs = Vec::new();
        let mut all = Vec::new();
        if converts || !reads_only && !is_own {
            exprs.push(receiver);
            all.push(value.clone());
        }
        exprs.extend_from_slice(args);
        all.extend(values);
        let text = self.text(id);
        self.unknown_call(id, text, &exprs, &all);
        match method {
            "map_err" | "inspect_err" | "context" | "with_context" | "wrap_err" | "ok" | "await" => value,
            _ => Value::default(),
        }
    }
}

/// Whether a function belongs to a type of numbers.
fn is_of_number(path: &str) -> bool {
    let owner = path.split("::").next().unwrap_or_default();
    let is_size = |size: &str| matches!(size, "8" | "16" | "32" | "64" | "128" | "size");
    path.contains("::") && (owner == "bool" || owner.strip_prefix(['f', 'i', 'u']).is_some_and(is_size))
}
