//! What a law calls of crates whose code is not read.

use super::shared::inner;
use crate::index::{Def, Ty};
use crate::syntax::tree::{Body, ExprId, ExprKind};
use crate::types::{Callee, TypedBody};

/// Crates that only calculate, or only keep what they are given. The names of families of crates end with `*`.
const CALCULATE: &str = "\
    std core alloc libm micromath num num_* nalgebra simba ndarray glam cgmath euclid vek mint faer sprs matrixmultiply \
    uom dimensioned fixed fixed_* half ordered_float decorum approx float_* rust_decimal bigdecimal ndarray_* statrs \
    rustfft realfft microfft biquad idsp dasp dasp_* pid pid_* kalman* splines interp interpolation easer \
    arrayvec smallvec tinyvec heapless indexmap hashbrown fnv rustc_hash ahash slotmap slab bitvec bitflags bit_field \
    modular_bitfield typenum generic_array hybrid_array itertools either bytemuck byteorder zerocopy bytes crc crc32fast \
    serde serde_json anyhow thiserror eyre fugit embedded_time chrono palette rgb petgraph semver strum";

/// Parts of such crates by which others are reached all the same.
const REACH_OTHERS: [&str; 3] = ["heapless::spsc::", "heapless::mpmc::", "heapless::pool::"];

/// Whether all code of a path only calculates.
fn calculates(path: &str) -> bool {
    let krate = path.split("::").next().unwrap_or(path);
    let is_it = |known: &str| known.strip_suffix('*').map_or(known == krate, |family| krate.starts_with(family));
    CALCULATE.split_whitespace().any(is_it) && !REACH_OTHERS.iter().any(|part| path.starts_with(part))
}

/// Whether a call runs code that is not read, and that may have to do with anything: a method of a value of another crate, or what
/// such a value is lent to, or a function that gives something though it is given nothing.
pub(super) fn calls_unread(body: &Body, typed: &TypedBody, call: ExprId, callee: &Callee) -> bool {
    match &body.expr(call).kind {
        ExprKind::MethodCall { receiver, .. } if !matches!(callee, Callee::Resolved(_)) => {
            is_of_unread(body, typed, *receiver)
        }
        ExprKind::Call { args, .. } => match callee {
            Callee::External(path) if !calculates(path) => {
                let is_lent = |arg: &ExprId| {
                    let is_reference = matches!(typed.ty(*arg), Ty::Ref(..))
                        || matches!(body.expr(*arg).kind, ExprKind::Reference { .. });
                    is_reference && is_of_unread(body, typed, *arg)
                };
                // `Scale::new()` makes something; `clock::ticks()` asks somebody.
                let owner = path.rsplit("::").nth(1).unwrap_or_default();
                let is_asked = args.is_empty() && owner.starts_with(|sign: char| !sign.is_uppercase());
                is_asked || args.iter().any(is_lent)
            }
            _ => false,
        },
        _ => false,
    }
}

/// Whether a value is one of a crate whose code is not read, or a part of such a value, or made by one.
fn is_of_unread(body: &Body, typed: &TypedBody, mut of: ExprId) -> bool {
    loop {
        match inner(typed.ty(of)) {
            Ty::External(path, _) => return path.contains("::") && !calculates(path),
            Ty::Unknown | Ty::Var(_) => {}
            _ => return false,
        }
        of = match &body.expr(of).kind {
            ExprKind::Field { base, .. } | ExprKind::Index { base, .. } => *base,
            ExprKind::MethodCall { receiver, .. } => *receiver,
            ExprKind::Deref(value) | ExprKind::Reference { value, .. } | ExprKind::Try(value) => *value,
            _ => return false,
        };
    }
}

/// Whether a call reads or writes memory that may change by itself, or by the code of others.
pub(super) fn reaches_memory(body: &Body, typed: &TypedBody, call: ExprId) -> bool {
    let is_volatile = |name: &str| matches!(name, "read_volatile" | "write_volatile");
    let is_access = |name: &str| matches!(name, "read" | "write" | "read_unaligned" | "write_unaligned" | "replace");
    match &body.expr(call).kind {
        ExprKind::MethodCall { receiver, method, .. } => {
            is_volatile(method) || is_access(method) && is_address(body, typed, *receiver)
        }
        ExprKind::Call { callee, args } => match &body.expr(*callee).kind {
            ExprKind::Path(path) => path.segments.last().is_some_and(|last| {
                is_volatile(&last.name)
                    || is_access(&last.name) && args.first().is_some_and(|arg| is_address(body, typed, *arg))
            }),
            _ => false,
        },
        _ => false,
    }
}

/// Whether an expression is a pointer to memory that the analysed code gives no name: a constant, or a number.
pub(super) fn is_address(body: &Body, typed: &TypedBody, mut of: ExprId) -> bool {
    let mut is_pointer = false;
    loop {
        is_pointer |= matches!(typed.ty(of), Ty::Pointer(_));
        of = match &body.expr(of).kind {
            ExprKind::MethodCall { receiver, .. } => *receiver,
            ExprKind::Cast { value, .. } => *value,
            ExprKind::Path(_) => {
                let is_value = matches!(typed.expr_def.get(&of), Some(Def::Value(_) | Def::External(_)));
                return is_pointer && (is_value || matches!(typed.ty(of), Ty::Int));
            }
            _ => return is_pointer && matches!(typed.ty(of), Ty::Int),
        };
    }
}

#[cfg(test)]
mod tests {
    use super::calculates;

    #[test]
    fn crates_of_numbers_and_collections_meet_nobody() {
        for path in ["nalgebra::Vector2", "num_traits::Float", "libm::sqrt", "heapless::Vec", "std::vec::Vec"] {
            assert!(calculates(path), "{path}");
        }
        for path in ["triple_buffer::Output", "heapless::spsc::Consumer", "volatile_register::RW", "numbers::Bus"] {
            assert!(!calculates(path), "{path}");
        }
    }
}
