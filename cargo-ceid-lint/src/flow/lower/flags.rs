//! Flags that are shared with interrupts and other threads: `AtomicBool`, `Cell<bool>`.

use super::{Builder, Value};
use crate::flow::{Assignment, Effect, Head, Transfer};
use crate::index::Ty;
use crate::source::Span;
use crate::syntax::tree::ExprId;

/// Whether a type is a truth value that is changed through a shared reference.
pub fn is_flag(ty: &Ty) -> bool {
    match ty.peel() {
        Ty::External(path, args) => match path.rsplit("::").next().unwrap_or("") {
            "AtomicBool" => true,
            "Cell" => args.first() == Some(&Ty::Bool),
            name => crate::types::is_transparent(name) && args.first().is_some_and(is_flag),
        },
        _ => false,
    }
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
    /// A method that changes a flag: an assignment of a truth value.
    pub(super) fn flag_method(
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
        self.values(args);
        if reads {
            return Some(Value::default());
        }
        let given = |at: usize| args.get(at).and_then(|arg| self.constant_head(*arg));
        let head: Option<Head> = match method {
            "store" | "set" | "swap" | "replace" => given(0),
            "compare_exchange" | "compare_exchange_weak" => given(1),
            "take" => Some("false".to_owned()),
            "fetch_and" => given(0).filter(|head| head == "false"),
            _ => None,
        };
        if self.at.is_some() {
            let assignment =
                Assignment { place, from: None, transfer: Transfer::Move, rebinds: false, head, same_as: None };
            self.emit(Effect::Write(Box::new(assignment)), span);
        }
        Some(Value::default())
    }
}
