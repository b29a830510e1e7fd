//! What methods of numbers, characters, texts and lengths of time give back.

use super::builtin;
use crate::index::Ty;

/// The type of what a method gives that is called on one of these.
pub(super) fn given_by(ty: &Ty, method: &str) -> Ty {
    let is_text = *ty == Ty::Str || ty.external_name() == Some("String");
    let option = |ty: Ty| Ty::std("std::option::Option", vec![ty]);
    match ty {
        Ty::Int | Ty::Float => match method {
            "partial_cmp" => option(Ty::Unknown),
            "eq" | "ne" | "lt" | "le" | "gt" | "ge" => Ty::Bool,
            _ if method.starts_with("checked_") => option(ty.clone()),
            _ if method.starts_with("overflowing_") => Ty::Tuple(vec![ty.clone(), Ty::Bool]),
            _ => ty.clone(),
        },
        _ if is_text => match method {
            "strip_prefix" | "strip_suffix" => option(Ty::Ref(false, Box::new(Ty::Str))),
            "find" | "rfind" => option(Ty::Int),
            "chars" => builtin::iterator(Ty::Char),
            "bytes" => builtin::iterator(Ty::Int),
            _ => Ty::Unknown,
        },
        Ty::Char if method == "to_digit" => option(Ty::Int),
        _ => match (ty.external_name(), method) {
            (Some("Duration"), "as_secs" | "as_millis" | "as_micros" | "as_nanos") => Ty::Int,
            (Some("Duration"), "subsec_millis" | "subsec_micros" | "subsec_nanos") => Ty::Int,
            (Some("Duration"), "is_zero") => Ty::Bool,
            (Some(name), "get") if name.starts_with("NonZero") => Ty::Int,
            _ => Ty::Unknown,
        },
    }
}
