//! What a law is given beside its filter: whether it can be kept until the end of the cycle, and in which form.

use super::Reason;
use super::body::LoopBody;
use super::lasting::{is_lasting, is_lasting_item, is_slice};
use super::locks::lock_behind;
use super::mentions::Guarded;
use super::owned::{is_fixed_algebra, is_owned};
use super::purity::acts_when_dropped;
use super::shared::shared_part;
use super::sites::Site;
use super::turbofish::said_of;
use crate::index::{Index, Owner, Ty};
use crate::source::Span;
use crate::syntax::is_keyword;
use crate::syntax::tree::{ExprId, ExprKind, Literal, PatKind, TypeRef};
use crate::types::LocalId;

/// An input, as it is fed.
#[derive(Clone, Debug)]
pub(super) struct Input {
    /// What the closure calls it.
    pub(super) name: String,
    /// The text that goes away before the value that is kept: `&` or nothing.
    pub(super) before: Span,
    /// What stands there instead.
    pub(super) instead: &'static str,
    /// Where the value ends.
    pub(super) end: u32,
    /// The text that goes away behind it: the bracket of `&(a + b)`, or nothing.
    pub(super) after: Span,
    /// Its type, where a reference to it becomes another one.
    pub(super) annotation: Option<String>,
    is_lent: bool,
}

impl Input {
    /// The expression whose value is kept, of the one that is given.
    pub(super) fn value(&self, of: &LoopBody<'_>, given: ExprId) -> ExprId {
        match of.kind(given) {
            ExprKind::Reference { value, .. } if self.is_lent => *value,
            _ => given,
        }
    }

    /// Whether the law gets a reference to what is kept.
    pub(super) fn is_lent(&self) -> bool {
        self.is_lent
    }
}

/// The edits behind inputs; those behind the last one are made with the end of the call.
pub(super) fn closed(inputs: &[Input]) -> impl Iterator<Item = (Span, String)> + '_ {
    let all_but_last = inputs.iter().rev().skip(1);
    all_but_last.filter(|input| input.after.start < input.after.end).map(|input| (input.after, String::new()))
}

/// The input of a law, by its number.
///
/// # Errors
/// Why it cannot be kept.
pub(super) fn input(of: &LoopBody<'_>, own: &Guarded, site: &Site, number: usize) -> Result<Input, Reason> {
    let id = site.inputs[number];
    let span = of.span(id);
    let nothing = Span { start: span.end, ..span };
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
    let ty = &input_type(of, site, number);
    // Text in the source is there for ever.
    if matches!(of.kind(id), ExprKind::Literal(Literal::Str(_)))
        && matches!(param, Some(TypeRef::Reference { inner, .. }) if is_str(inner))
    {
        let before = Span { end: span.start, ..span };
        return Ok(Input {
            name,
            before,
            instead: "",
            end: span.end,
            after: nothing,
            annotation: None,
            is_lent: false,
        });
    }
    if let Some(lock) = lent_by_a_lock(of, id) {
        return refuse(format!(
            "{} is lent by a `{lock}` until it is given back, and cannot be kept until the end of the cycle: give the law a copy of \
             the value",
            what()
        ));
    }
    let by_reference = match param {
        Some(TypeRef::Reference { mutable: true, .. } | TypeRef::Pointer(_)) => {
            return refuse(format!("{} is lent to the law, which may change it", what()));
        }
        Some(TypeRef::Reference { inner, .. }) if matches!(**inner, TypeRef::DynTrait(_)) || is_str(inner) => {
            return refuse(format!(
                "{} is borrowed, and it is not known whether it is still there at the end of the cycle, when the law would run",
                what()
            ));
        }
        Some(TypeRef::Reference { .. }) => true,
        Some(_) if !matches!(ty, Ty::Ref(..)) && !matches!(of.kind(id), ExprKind::Reference { .. }) => false,
        // What is generic may be a reference as well.
        _ => matches!(ty, Ty::Ref(..)) || matches!(of.kind(id), ExprKind::Reference { .. }),
    };
    // The law says what may be changed; the items of an iterator do not.
    let asked = declared(of, site, number);
    let declared = asked.as_ref().filter(|ty| !ty.has_part(&mut |part| matches!(part, Ty::Unknown)));
    if let Some(part) = shared_part(index, declared.unwrap_or(ty).peel()) {
        return refuse(format!("{} holds {part}, which may change until the end of the cycle", what()));
    }
    let end = span.end;
    if !by_reference {
        if matches!(ty, Ty::Unknown | Ty::Var(_)) {
            return refuse(format!(
                "the type of {} is not known, so that it may borrow from the iteration: give it one above, as in `let input: f32 = {};`",
                what(),
                of.written(id)
            ));
        }
        let scope = index.scope_of(of.function);
        // What a law takes by a type without a lifetime borrows nothing, however it is made.
        let is_owned_by_law = || declared.is_some_and(|ty| is_value(ty) && is_owned(index, &scope, ty));
        if !is_owned(index, &scope, ty) && !is_owned_by_law() {
            return refuse(match ty.external_name() {
                Some(name @ ("Rc" | "Arc")) => format!(
                    "{} is an `{name}`, which the law may count, and the iteration would give its own back before: give it what is in there",
                    what()
                ),
                _ => format!("{} may borrow from the iteration, and cannot be kept until its end", what()),
            });
        }
        let before = Span { end: span.start, ..span };
        return Ok(Input { name, before, instead: "", end, after: nothing, annotation: None, is_lent: false });
    }
    let as_it_is = Input {
        name: name.clone(),
        before: Span { end: span.start, ..span },
        instead: "",
        end,
        after: nothing,
        annotation: None,
        is_lent: false,
    };
    let kept = kept_reference(of, id, asked.as_ref()).map(|annotation| Input { annotation, ..as_it_is.clone() });
    // A reference that the filter may keep is no longer there where the law has got one to a copy.
    if is_of_filter(of, site, number) {
        return if is_lasting_item(of, id) { Ok(as_it_is) } else { kept.ok_or_else(|| unkept(span, &what())) };
    }
    if let ExprKind::Reference { mutable: false, raw: false, value } = of.kind(id) {
        if is_lasting_part(of, *value) {
            return Ok(as_it_is);
        }
        let held = match of.typed.ty(*value) {
            Ty::Unknown | Ty::Var(_) => ty.peel(),
            known => known,
        };
        let is_made = !is_place(of, *value) || is_given_away(of, site, *value);
        let is_array = matches!(held, Ty::Array(_, length) if length.value.is_none());
        let is_owned = is_owned(index, &index.scope_of(of.function), held);
        if is_array || !is_owned || !is_made && !is_kept(index, held) {
            return kept.ok_or_else(|| unkept(span, &what()));
        }
        let value = of.span(*value);
        let (before, after) = (Span { end: value.start, ..span }, Span { start: value.end, ..span });
        let annotation = annotation(held);
        return Ok(Input { name, before, instead: "", end: value.end, after, annotation, is_lent: true });
    }
    let is_item = is_lasting_item(of, id);
    if is_item && matches!(ty, Ty::Ref(_, inner) if matches!(**inner, Ty::Slice(_))) {
        return Ok(as_it_is);
    }
    let lent = match (ty, param) {
        // An iterator's items are not told apart by what may be changed in them; the law takes what may not.
        (Ty::Ref(_, inner), Some(TypeRef::Reference { .. })) | (Ty::Ref(false, inner), _) => Some(&**inner),
        _ => None,
    };
    match lent {
        Some(inner) if is_kept(index, inner) && matches!(of.kind(id), ExprKind::Path(_) | ExprKind::Field { .. }) => {
            let before = Span { end: span.start, ..span };
            Ok(Input { name, before, instead: "*", end, after: nothing, annotation: annotation(inner), is_lent: true })
        }
        _ if is_item => Ok(as_it_is),
        _ => kept.ok_or_else(|| unkept(span, &what())),
    }
}

fn unkept(span: Span, what: &str) -> Reason {
    let text = format!("{what} is borrowed, and it is not known whether it can be copied");
    Reason { span, text }
}

/// Whether a part of such a reference is taken: `row[..2]`.
fn is_lasting_part(of: &LoopBody<'_>, id: ExprId) -> bool {
    let ExprKind::Index { base, index } = of.kind(id) else { return false };
    let ty = of.typed.ty(*base);
    matches!(of.kind(*index), ExprKind::Range { .. })
        && matches!(ty, Ty::Ref(..))
        && is_slice(ty)
        && is_lasting_item(of, *base)
}

/// A reference to what stays, as it is given; none where its type may become another one on the way to the law.
fn kept_reference(of: &LoopBody<'_>, id: ExprId, asked: Option<&Ty>) -> Option<Option<String>> {
    if !is_lasting(of, id) {
        return None;
    }
    let given = match of.kind(id) {
        ExprKind::Reference { value, .. } => of.typed.ty(*value),
        _ => match of.typed.ty(id) {
            Ty::Ref(_, inner) => &**inner,
            _ => return None,
        },
    };
    let Some(Ty::Ref(_, asked)) = asked else { return None };
    match (given, &**asked) {
        (Ty::Slice(_), Ty::Slice(_)) | (Ty::Array(..), Ty::Array(..)) => Some(None),
        (Ty::Array(..) | Ty::External(..), Ty::Slice(_)) => Some(Some(format!("&{}", annotation(given)?))),
        (Ty::Adt(one, _), Ty::Adt(other, _)) => (one == other).then_some(None),
        (Ty::External(one, _), Ty::External(other, _)) => (one == other).then_some(None),
        _ => None,
    }
}

/// Whether a value belongs to the iteration, and nothing in it needs the value behind the call, so that it can be given away.
fn is_given_away(of: &LoopBody<'_>, site: &Site, value: ExprId) -> bool {
    let index = of.program.index;
    let Some(local) = of.typed.expr_local.get(&value).copied() else { return false };
    let own = of.typed.local(local);
    let scope = index.scope_of(of.function);
    // An inner loop would give it away for each element.
    if site.inner.is_some()
        || own.by_ref
        || own.span.start < of.span(of.whole).start
        || !of.text[own.span.start as usize..].starts_with(&own.name)
        || matches!(own.ty, Ty::Ref(..))
        || !is_owned(index, &scope, &own.ty)
        || acts_when_dropped(index, &own.ty)
    {
        return false;
    }
    let call = of.span(site.call);
    let is_harmless = |at: ExprId| {
        let span = of.span(at);
        let around = of.ancestors_inside(site.call).find(|around| of.span(*around).contains(span));
        let is_let = |id: &ExprId| matches!(of.kind(*id), ExprKind::Let { .. });
        // What is looked into around the call is borrowed there.
        let is_apart = match around.map(|around| of.kind(around)) {
            None | Some(ExprKind::Block(_)) => true,
            Some(ExprKind::If { condition, .. }) => !of.body.within(*condition).any(|id| is_let(&id)),
            _ => false,
        };
        is_apart && !call.contains(span) && !of.may_follow(site.call, at)
    };
    // A loan that lives on has a name in the iteration.
    let may_borrow = |other: &LocalId| {
        let local = of.typed.local(*other);
        let is_of_iteration = (of.span(of.whole).start..call.start).contains(&local.span.start);
        is_of_iteration && (local.by_ref || !is_owned(index, &scope, &local.ty))
    };
    let is_loan = |at: &ExprId| of.typed.expr_local.get(at).is_some_and(may_borrow) && of.may_follow(site.call, *at);
    of.names(local).filter(|at| *at != value).all(is_harmless) && !of.inside.iter().any(is_loan)
}

/// The type of what is kept, where a reference to it becomes one to a slice.
fn annotation(ty: &Ty) -> Option<String> {
    match ty {
        Ty::Array(_, length) => length.value.map(|length| format!("[_; {length}]")),
        Ty::External(path, _) if path == "std::vec::Vec" => Some("Vec<_>".to_owned()),
        _ => None,
    }
}

/// The lock that lends an input: `RefCell` for `shared.borrow()`.
fn lent_by_a_lock<'a>(of: &LoopBody<'a>, id: ExprId) -> Option<&'a str> {
    let ExprKind::MethodCall { receiver, method, .. } = of.kind(id) else { return None };
    match method.as_str() {
        "unwrap" | "expect" => lent_by_a_lock(of, *receiver),
        "borrow" | "borrow_mut" | "lock" | "read" | "write" => lock_behind(of.typed.ty(*receiver)),
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
    match path.split("::").next() {
        Some("nalgebra") => is_fixed_algebra(name),
        Some("std") => matches!(path, "std::time::Duration" | "std::time::Instant"),
        _ => false,
    }
}

/// The type of an input: that of the expression, or the one that its law asks for where that is the same for every caller.
fn input_type(of: &LoopBody<'_>, site: &Site, number: usize) -> Ty {
    let own = of.typed.ty(site.inputs[number]);
    match (own.peel(), declared(of, site, number)) {
        (Ty::Unknown | Ty::Var(_), Some(declared)) => declared,
        // No reference becomes a value on the way to the law.
        (_, Some(declared)) if matches!(own, Ty::Ref(..)) && is_value(&declared) => declared,
        _ => own.clone(),
    }
}

/// Whether a type is known, and no reference.
fn is_value(ty: &Ty) -> bool {
    !matches!(ty, Ty::Ref(..) | Ty::Unknown | Ty::Var(_) | Ty::Param(_) | Ty::Opaque(_))
}

/// The type of an input that its law asks for, where that is the same for every caller.
fn declared(of: &LoopBody<'_>, site: &Site, number: usize) -> Option<Ty> {
    let index = of.program.index;
    site.law.and_then(|law| {
        let def = index.function(law);
        let written = index.lower(def.function.params.get(number)?, &index.scope_of(law));
        let own = match def.owner {
            Owner::Impl(id) => Some(&index.impl_def(id).self_ty),
            _ => None,
        };
        with_args(&written, &|name| {
            if let Some(said) = said_of(of, site.call, &def.function.generics, name) {
                return Some(said);
            }
            let (Some(Ty::Adt(_, names)), Ty::Adt(_, args)) = (own, &site.filter) else { return None };
            let is_it = |own: &Ty| matches!(own, Ty::Param(param) if param.name == name);
            names.iter().position(is_it).and_then(|at| args.get(at)).cloned()
        })
    })
}

/// Whether each call of the law chooses the type of an input.
pub(super) fn is_generic(of: &LoopBody<'_>, site: &Site, number: usize) -> bool {
    let index = of.program.index;
    site.law.is_some_and(|law| {
        let def = index.function(law);
        let Some(param) = def.function.params.get(number) else { return false };
        // Each function has a type of its own before it becomes a pointer.
        if matches!(param, TypeRef::FnPointer(..) | TypeRef::ImplTrait(_)) {
            return true;
        }
        let written = index.lower(param, &index.scope_of(law));
        let is_own = |name: &str| def.function.generics.params.iter().any(|own| own.name == name && !own.is_const);
        with_args(&written, &|name| if is_own(name) { None } else { Some(Ty::Unknown) }).is_none()
    })
}

/// Whether the calls of a law with a length of its own may give inputs of several lengths.
pub(super) fn are_lengths_chosen(of: &LoopBody<'_>, sites: &[Site], half: &Site, number: usize) -> bool {
    let index = of.program.index;
    let Some(law) = half.law else { return false };
    let def = index.function(law);
    let has_length = def.function.generics.params.iter().any(|param| param.is_const);
    let written = def.function.params.get(number).map(|param| index.lower(param, &index.scope_of(law)));
    if !has_length || written.is_none_or(|written| matches!(written, Ty::Int | Ty::Float | Ty::Bool | Ty::Char)) {
        return false;
    }
    let length = |site: &Site| match of.typed.ty(*site.inputs.get(number)?).peel() {
        Ty::Array(_, length) => length.value,
        _ => None,
    };
    let own = length(half);
    own.is_none() || sites.iter().filter(|site| site.half == half.half).any(|site| length(site) != own)
}

/// Whether the type of an input is chosen with the filter, so that it is the same for all calls.
fn is_of_filter(of: &LoopBody<'_>, site: &Site, number: usize) -> bool {
    let index = of.program.index;
    let written = site.law.and_then(|law| {
        let param = index.function(law).function.params.get(number)?;
        Some(index.lower(param, &index.scope_of(law)))
    });
    matches!(written, Some(Ty::Param(_))) && !is_generic(of, site, number)
}

/// A type with what its parameters stand for, if that is known of all of them.
fn with_args(ty: &Ty, arg: &impl Fn(&str) -> Option<Ty>) -> Option<Ty> {
    let inner = |ty: &Ty| with_args(ty, arg).map(Box::new);
    let all = |parts: &[Ty]| parts.iter().map(|part| with_args(part, arg)).collect::<Option<Vec<Ty>>>();
    Some(match ty {
        Ty::Param(param) => arg(&param.name)?,
        Ty::Opaque(_) => return None,
        Ty::Ref(mutable, of) => Ty::Ref(*mutable, inner(of)?),
        Ty::Array(of, length) => Ty::Array(inner(of)?, length.clone()),
        Ty::Slice(of) => Ty::Slice(inner(of)?),
        Ty::Tuple(parts) => Ty::Tuple(all(parts)?),
        Ty::Adt(id, parts) => Ty::Adt(*id, all(parts)?),
        Ty::External(path, parts) => Ty::External(path.clone(), all(parts)?),
        other => other.clone(),
    })
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
    // What is written `r#type` is a word of the language, or one that it keeps for itself.
    let kept = ["abstract", "do", "final", "gen", "override", "priv", "try", "typeof", "unsized", "virtual"];
    let is_plain = |name: &String| !(name.starts_with('_') || is_keyword(name) || kept.contains(&name.as_str()));
    of_law.filter(is_plain).or_else(given).unwrap_or_else(|| "input".to_owned())
}
