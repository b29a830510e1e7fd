//! Whether a value can be kept beyond the iteration that makes it: it can if its type has no room for a reference.

use crate::index::{Index, Ty, TyScope};

/// Crates of numbers and vectors of them: nothing in these borrows.
const NUMBERS: [&str; 9] =
    ["fixed", "fugit", "glam", "half", "micromath", "num_complex", "ordered_float", "typenum", "uom"];

/// Whether no value of a type of the scope can hold a reference that ends with the iteration. A type that is not known may.
pub(super) fn is_owned(index: &Index, scope: &TyScope<'_>, ty: &Ty) -> bool {
    let all = |parts: &[Ty]| parts.iter().all(|part| is_owned(index, scope, part));
    match ty {
        Ty::Int | Ty::Float | Ty::Bool | Ty::Char | Ty::Never | Ty::FunctionItem(_) => true,
        Ty::Tuple(parts) => all(parts),
        Ty::Array(inner, _) => is_owned(index, scope, inner),
        Ty::Function(params, output) => all(params) && is_owned(index, scope, output),
        // A type without a lifetime has none in its fields but `'static`.
        Ty::Adt(id, args) => {
            let generics = &index.type_def(*id).generics;
            // A length borrows nothing, whatever it is.
            let mut types = generics.params.iter().enumerate().filter(|(_, param)| !param.is_const);
            !generics.has_lifetimes && types.all(|(at, _)| args.get(at).is_some_and(|arg| is_owned(index, scope, arg)))
        }
        Ty::External(path, args) => is_owned_outside(path, args) && all(args),
        // What the caller of the function has chosen is there before the function runs.
        Ty::Param(param) => {
            scope.generics.iter().flat_map(|generics| &generics.params).any(|other| other.name == param.name)
        }
        _ => false,
    }
}

/// Whether a type of another crate is known to have no lifetime.
fn is_owned_outside(path: &str, args: &[Ty]) -> bool {
    let name = path.rsplit("::").next().unwrap_or(path);
    match path.split("::").next() {
        Some("std") => match name {
            "String" | "Duration" | "Instant" | "SystemTime" | "PathBuf" | "Ordering" => true,
            "Option" | "Vec" | "VecDeque" | "Box" | "Result" | "Wrapping" | "Saturating" | "Range" | "Reverse" => {
                !args.is_empty()
            }
            _ => name.starts_with("NonZero"),
        },
        Some("nalgebra") => is_fixed_algebra(name),
        Some(krate) => NUMBERS.contains(&krate),
        None => false,
    }
}

/// Whether nothing happens where a value of a type of another crate is dropped, beside what its parts do: no lock is given back, and
/// no file is closed.
pub(super) fn is_dropped_in_silence(path: &str) -> bool {
    let name = path.rsplit("::").next().unwrap_or(path);
    match path.split("::").next() {
        Some("std") => !name.ends_with("Guard") && !matches!(name, "Ref" | "RefMut" | "File" | "Sender" | "SyncSender"),
        Some("nalgebra") => true,
        Some(krate) => NUMBERS.contains(&krate),
        None => false,
    }
}

/// Types of nalgebra with a fixed size, which are `Copy`.
pub(super) fn is_fixed_algebra(name: &str) -> bool {
    let sizes = name.trim_start_matches("Vector").trim_start_matches("Matrix").trim_start_matches("Point");
    let is_sized = sizes.len() < name.len() && !sizes.is_empty();
    is_sized && sizes.chars().all(|sign| sign.is_ascii_digit() || sign == 'x')
        || matches!(name, "Quaternion" | "UnitQuaternion")
}
