//! Flags and counters that are shared with interrupts and other threads: `AtomicBool`, `Cell<bool>`, `AtomicU32`, `Cell<u32>`.

mod cells;
mod once_set;

pub(super) use cells::{is_borrowed_from, leads_to_cell};

use super::parts::given_to;
use super::{Builder, Value};
use crate::flow::{Assignment, Change, ChangeKind, Effect, Head, Place};
use crate::index::Ty;
use crate::source::Span;
use crate::syntax::tree::ExprId;

/// Whether a type is a truth value that is changed through a shared reference.
pub fn is_flag(ty: &Ty) -> bool {
    is_shared(ty, &Ty::Bool, |name| name == "AtomicBool")
}

/// Whether a type is a whole number that is changed through a shared reference.
pub fn is_shared_number(ty: &Ty) -> bool {
    is_shared(ty, &Ty::Int, |name| name.starts_with("AtomicU") || name.starts_with("AtomicI"))
}

/// Whether a type is a cell with such a value, or an atomic of such a name.
fn is_shared(ty: &Ty, value: &Ty, is_atomic: fn(&str) -> bool) -> bool {
    match ty.peel() {
        Ty::External(path, args) => match path.rsplit("::").next().unwrap_or("") {
            "Cell" => args.first() == Some(value),
            name if is_atomic(name) => true,
            name => {
                crate::types::is_transparent(name) && args.first().is_some_and(|ty| is_shared(ty, value, is_atomic))
            }
        },
        _ => false,
    }
}

/// Whether a method, or the ordering that it is given, only reads such a number: `COUNT.load(Ordering::Relaxed)`.
pub fn reads_shared_number(name: &str) -> bool {
    matches!(name, "load" | "get" | "Relaxed" | "Acquire" | "Release" | "AcqRel" | "SeqCst")
}

/// Whether a method of a flag changes it.
pub(super) fn changes_flag(method: &str) -> bool {
    matches!(
        method,
        "store"
            | "set"
            | "swap"
            | "replace"
            | "take"
            | "compare_exchange"
            | "compare_exchange_weak"
            | "fetch_and"
            | "fetch_or"
            | "fetch_xor"
            | "fetch_not"
            | "fetch_nand"
    )
}

impl Builder<'_> {
    /// A method that changes a flag or number, or reads a flag.
    pub(super) fn shared_method(
        &mut self,
        receiver: ExprId,
        method: &str,
        args: &[ExprId],
        value: &Value,
        span: Span,
    ) -> Option<Value> {
        let flag = self.flag_method(receiver, method, args, value, span);
        flag.or_else(|| self.number_method(receiver, method, args, value, span))
    }

    /// A method that changes a flag: an assignment of a truth value.
    fn flag_method(
        &mut self,
        receiver: ExprId,
        method: &str,
        args: &[ExprId],
        value: &Value,
        span: Span,
    ) -> Option<Value> {
        let reads = matches!(method, "load" | "get");
        if !is_flag(self.ty(receiver)) || !(changes_flag(method) || reads) {
            return None;
        }
        let place = value.place.clone()?;
        let values = self.values(args);
        if reads {
            return Some(Value::default());
        }
        let is_taken = matches!(method, "swap" | "replace" | "take") && self.at.is_some();
        let taken = (is_taken && (self.is_cell(receiver) || self.is_exclusive(receiver)))
            .then(|| self.taken_from_cell(&place, Ty::Bool, span));
        let given = |at: usize| args.get(at).and_then(|arg| self.constant_head(*arg));
        let head: Option<Head> = match method {
            "store" | "set" | "swap" | "replace" => given(0),
            "compare_exchange" | "compare_exchange_weak" => given(1),
            "take" => Some("false".to_owned()),
            "fetch_and" => given(0).filter(|head| head == "false"),
            _ => None,
        };
        if self.at.is_some() {
            let assignment = Assignment { rebinds: false, ..given_to(place, head) };
            self.emit(Effect::Write(Box::new(assignment)), span);
            if let (Some(value), [arg, ..], "store" | "set" | "swap" | "replace") = (values.first(), args, method) {
                self.note_put_in_cell(value, *arg);
            }
        }
        let old = |var| Value { place: Some(Place::var(var)), is_owned: true, same_as: Some(var), ..Value::default() };
        Some(taken.map_or_else(Value::default, old))
    }

    /// A method that changes a shared number: an assignment, which may count.
    fn number_method(
        &mut self,
        receiver: ExprId,
        method: &str,
        args: &[ExprId],
        value: &Value,
        span: Span,
    ) -> Option<Value> {
        let is_given = matches!(method, "store" | "set" | "swap");
        if !is_given
            && !matches!(
                method,
                "fetch_add" | "fetch_sub" | "fetch_max" | "fetch_min" | "fetch_and" | "fetch_or" | "fetch_xor"
            )
        {
            return None;
        }
        let given = *args.first().filter(|_| is_shared_number(self.ty(receiver)))?;
        let place = value.place.clone()?;
        self.values(args);
        if self.at.is_none() {
            return Some(Value::default());
        }
        let head = self.constant_head(given).filter(|_| is_given);
        let assignment = Assignment { rebinds: false, ..given_to(place.clone(), head) };
        self.emit(Effect::Write(Box::new(assignment)), span);
        if is_given {
            // `let n = COUNT.get() + 1; COUNT.set(n);`
            self.note_given(&place, self.constants().initial(given).unwrap_or(given));
        } else if let Some(at) = self.at {
            let kind = match method {
                "fetch_add" => self.added(given, given, true),
                "fetch_sub" => self.added(given, given, false),
                _ => ChangeKind::Other,
            };
            let computed = self.computed_from(given);
            self.graph.changes.insert(at, Change { computed, kind, goes_round: false, about: None, tally: None });
        }
        Some(Value::default())
    }
}
