//! What the closures are given that are passed to methods of the standard library.

use super::builtin::{arg, family, is_cell, reference};
use crate::index::Ty;

/// What the first parameter of a closure is that is passed to a method of a known type.
pub(super) fn closure_params(receiver: &Ty, method: &str, args: &[Ty]) -> Vec<Ty> {
    let Ty::External(path, params) = receiver else {
        return match receiver {
            Ty::Array(inner, _) | Ty::Slice(inner) => vec![(**inner).clone()],
            Ty::Tuple(parts) if method == "lock" => {
                parts.iter().flat_map(|part| closure_params(part.peel(), method, args)).collect()
            }
            _ => Vec::new(),
        };
    };
    let name = family(path.rsplit("::").next().unwrap_or(""));
    let inner = arg(params, 0);
    if path.starts_with("ceid_core::") {
        return if method == "run" { vec![reference(inner)] } else { Vec::new() };
    }
    if is_cell(name) {
        return vec![reference(inner)];
    }
    match (name, method) {
        ("LocalKey", "with") => vec![Ty::Ref(false, Box::new(inner))],
        ("LocalKey", "with_borrow" | "with_borrow_mut") => closure_params(&inner, method, args),
        ("Iterator" | "Range", "fold" | "rfold" | "try_fold" | "scan" | "for_each_init" | "for_each_with") => {
            vec![args.first().cloned().unwrap_or(Ty::Unknown), inner]
        }
        (
            "Iterator" | "Range",
            "filter" | "inspect" | "take_while" | "skip_while" | "find" | "max_by_key" | "min_by_key" | "partition",
        ) => {
            vec![Ty::Ref(false, Box::new(inner))]
        }
        ("Iterator" | "Range", _) => vec![inner],
        ("Option", "filter") => vec![Ty::Ref(false, Box::new(inner))],
        ("Option" | "Poll", "map" | "and_then" | "map_or" | "map_or_else" | "is_some_and" | "inspect") => vec![inner],
        ("Result" | "LockResult", "map" | "and_then" | "map_or" | "is_ok_and" | "inspect") => vec![inner],
        ("Result", "map_err" | "or_else" | "unwrap_or_else" | "inspect_err") => vec![arg(params, 1)],
        ("Vec" | "VecDeque", "retain" | "retain_mut" | "sort_by_key" | "drain_filter") => vec![reference(inner)],
        ("HashMap" | "BTreeMap", "retain") => vec![reference(inner), reference(arg(params, 1))],
        _ => Vec::new(),
    }
}
