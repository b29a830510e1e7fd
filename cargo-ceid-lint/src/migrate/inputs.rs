//! What a law is given beside its filter: whether it can be kept until the end of the cycle, and in which form.

use std::collections::BTreeSet;

use super::Reason;
use super::body::LoopBody;
use super::mentions::Guarded;
use super::purity::{fields, shared_part};
use super::sites::Site;
use crate::index::{Index, Ty, TypeId};
use crate::source::Span;
use crate::syntax::tree::{ExprId, ExprKind, PatKind, TypeRef};

/// An input, as it is fed.
#[derive(Clone, Debug)]
pub(super) struct Input {
    /// What the closure calls it.
    pub(super) name: String,
    /// The text that goes away before the value that is kept: `&` or nothing.
    pub(super) before: Span,
    /// What stands there instead.
    pub(super) instead: &'static str,
    /// Where the input ends.
    pub(super) end: u32,
    /// Its type, where a reference to it becomes another one.
    pub(super) annotation: Option<String>,
    is_lent: bool,
}

impl Input {
    /// Whether the law gets a reference to what is kept.
    pub(super) fn is_lent(&self) -> bool {
        self.is_lent
    }
}

/// The input of a law, by its number.
///
/// # Errors
/// Why it cannot be kept.
pub(super) fn input(of: &LoopBody<'_>, own: &Guarded, site: &Site, number: usize) -> Result<Input, Reason> {
    let id = site.inputs[number];
    let span = of.span(id);
    let refuse = |text: String| Err(Reason { span, text });
    let what = || format!("the input `{}` of `{}`", of.written(id), own.spelled);
    if of.program.sources.snippet(of.span(of.block)).contains("//") && has_comment(of, site) {
        return refuse(format!("a comment stands among the inputs of `{}`", own.spelled));
    }
    if matches!(of.kind(id), ExprKind::Closure(_)) {
        return refuse(format!("{} is a closure, which cannot be kept until the end of the cycle", what()));
    }
    let index = of.program.index;
    let param = site.law.and_then(|law| index.function(law).function.params.get(number));
    let name = name(of, site, number);
    let ty = of.typed.ty(id);
    let by_reference = match param {
        Some(TypeRef::Reference { mutable: true, .. } | TypeRef::Pointer(_)) => {
            return refuse(format!("{} is lent to the law, which may change it", what()));
        }
        Some(TypeRef::Reference { inner, .. }) if matches!(**inner, TypeRef::DynTrait(_)) || is_str(inner) => {
            return refuse(format!("{} is borrowed, and cannot be kept until the end of the cycle", what()));
        }
        Some(TypeRef::Reference { .. }) => true,
        Some(TypeRef::ImplTrait(_) | TypeRef::FnPointer(..)) => {
            return refuse(format!("the type of {} is chosen by its caller", what()));
        }
        Some(_) if !matches!(ty, Ty::Ref(..)) && !matches!(of.kind(id), ExprKind::Reference { .. }) => false,
        // What is generic may be a reference as well.
        _ => matches!(ty, Ty::Ref(..)) || matches!(of.kind(id), ExprKind::Reference { .. }),
    };
    if let Some(part) = shared_part(index, ty.peel()) {
        return refuse(format!("{} holds {part}, which may change until the end of the cycle", what()));
    }
    let end = span.end;
    if !by_reference {
        if may_borrow(index, ty) {
            return refuse(format!("{} may borrow from the iteration, and cannot be kept until its end", what()));
        }
        let before = Span { end: span.start, ..span };
        return Ok(Input { name, before, instead: "", end, annotation: None, is_lent: false });
    }
    if let ExprKind::Reference { mutable: false, raw: false, value } = of.kind(id) {
        let held = of.typed.ty(*value);
        let is_made = !is_place(of, *value);
        let is_array = matches!(held, Ty::Array(_, length) if length.value.is_none());
        if matches!(held, Ty::Slice(_)) || is_array || may_borrow(index, held) || !is_made && !is_kept(index, held) {
            return refuse(format!("{} is borrowed, and it is not known whether it can be copied", what()));
        }
        let before = Span { end: of.span(*value).start, ..span };
        return Ok(Input { name, before, instead: "", end, annotation: annotation(held), is_lent: true });
    }
    match ty {
        Ty::Ref(false, inner)
            if is_kept(index, inner) && matches!(of.kind(id), ExprKind::Path(_) | ExprKind::Field { .. }) =>
        {
            let before = Span { end: span.start, ..span };
            Ok(Input { name, before, instead: "*", end, annotation: annotation(inner), is_lent: true })
        }
        _ => refuse(format!("{} is borrowed, and it is not known whether it can be copied", what())),
    }
}

/// The type of what is kept, where a reference to it becomes one to a slice.
fn annotation(ty: &Ty) -> Option<String> {
    match ty {
        Ty::Array(_, length) => length.value.map(|length| format!("[_; {length}]")),
        Ty::External(path, _) if path == "std::vec::Vec" => Some("Vec<_>".to_owned()),
        _ => None,
    }
}

/// Whether a comment stands in the call, so that its parts cannot be written anew.
fn has_comment(of: &LoopBody<'_>, site: &Site) -> bool {
    let text = of.written(site.call);
    text.contains("//") || text.contains("/*")
}

fn is_str(ty: &TypeRef) -> bool {
    matches!(ty, TypeRef::Path(path) if path.last() == "str")
}

/// Whether a copy of a value can be kept without asking for `Clone`.
fn is_kept(index: &Index, ty: &Ty) -> bool {
    match ty {
        Ty::External(path, _) => is_known_copy(path) || index.is_copy(ty),
        Ty::Array(inner, _) => is_kept(index, inner),
        Ty::Tuple(parts) => parts.iter().all(|part| is_kept(index, part)),
        Ty::Ref(..) | Ty::Param(_) | Ty::Opaque(_) => false,
        _ => index.is_copy(ty),
    }
}

/// Types of other crates that are `Copy`: vectors and matrices of fixed sizes, times.
fn is_known_copy(path: &str) -> bool {
    let name = path.rsplit("::").next().unwrap_or(path);
    let is_fixed = |name: &str| {
        let sizes = name.trim_start_matches("Vector").trim_start_matches("Matrix").trim_start_matches("Point");
        sizes.len() < name.len() && !sizes.is_empty() && sizes.chars().all(|sign| sign.is_ascii_digit() || sign == 'x')
    };
    match path.split("::").next() {
        Some("nalgebra") => is_fixed(name) || matches!(name, "Quaternion" | "UnitQuaternion"),
        Some("std") => matches!(path, "std::time::Duration" | "std::time::Instant"),
        _ => false,
    }
}

/// Whether a value of the type may hold a reference.
fn may_borrow(index: &Index, ty: &Ty) -> bool {
    borrows(index, ty, &mut BTreeSet::new())
}

fn borrows(index: &Index, ty: &Ty, seen: &mut BTreeSet<TypeId>) -> bool {
    match ty {
        Ty::Ref(..) | Ty::Pointer(_) | Ty::Slice(_) | Ty::Str | Ty::Opaque(_) | Ty::Closure(_) => true,
        Ty::Tuple(parts) | Ty::External(_, parts) => parts.iter().any(|part| borrows(index, part, seen)),
        Ty::Array(inner, _) => borrows(index, inner, seen),
        Ty::Adt(id, _) if seen.insert(*id) => fields(index, ty).iter().any(|field| borrows(index, field, seen)),
        _ => false,
    }
}

/// Whether an expression names a value that stays where it is.
fn is_place(of: &LoopBody<'_>, id: ExprId) -> bool {
    matches!(of.kind(id), ExprKind::Path(_) | ExprKind::Field { .. } | ExprKind::Index { .. } | ExprKind::Deref(_))
}

/// What an input is called: as in the law, or as where it is given.
fn name(of: &LoopBody<'_>, site: &Site, number: usize) -> String {
    let index = of.program.index;
    let of_law = site.law.and_then(|law| {
        let body = index.function(law).function.body.as_ref()?;
        let skip = usize::from(body.params.len() > site.inputs.len());
        match &body.pat(*body.params.get(number + skip)?).kind {
            PatKind::Bind { name, .. } => Some(name.clone()),
            _ => None,
        }
    });
    let given = || {
        let text = of.written(site.inputs[number]).trim_start_matches('&');
        let text = text.rsplit('.').next().unwrap_or(text);
        let is_name = text.chars().all(|sign| sign.is_alphanumeric() || sign == '_');
        let is_lower = text.starts_with(|first: char| first.is_lowercase());
        (is_name && is_lower && !matches!(text, "true" | "false" | "self")).then(|| text.to_owned())
    };
    of_law.filter(|name| !name.starts_with('_')).or_else(given).unwrap_or_else(|| "input".to_owned())
}
