//! How a loop names the filters that a guard is to hold, and what each name becomes where the guard has them.

use std::collections::BTreeSet;
use std::fmt::Write;

use super::Reason;
use super::adapt::Adaptation;
use super::body::LoopBody;
use super::boxed::{self, is_for_box, needless_star};
use super::each;
use super::formats::is_shown_otherwise;
use super::loops::Loops;
use super::owned::is_owned;
use super::shadowed::{is_by_value, is_of_pointee, is_shadowed};
use super::sites::{Place, Site, number};
use crate::count::Verdict;
use crate::index::{FunctionId, Index, Ty};
use crate::source::Span;
use crate::syntax::tree::{BlockKind, ExprId, ExprKind, Literal, MacroKind, Receiver, TypeRef};
use crate::types::Callee;

/// A place that a guard is to hold.
#[derive(Clone, Debug)]
pub(super) struct Guarded {
    pub(super) place: Place,
    /// What it is called in the source.
    pub(super) spelled: String,
    /// What it is called in the body of the loop.
    pub(super) name: String,
    /// An expression that is the place.
    pub(super) at: ExprId,
    /// Its type.
    pub(super) ty: Ty,
    /// The type of the filter that lies there, and its law.
    pub(super) filter: Ty,
    pub(super) law: Option<FunctionId>,
    /// Where it is updated by hand; nowhere if that is what is wrong.
    pub(super) sites: Vec<Site>,
    /// The halves of its law that some iterations leave out, as their law allows.
    pub(super) rare: BTreeSet<usize>,
    /// The statement of the loop that locks it, if that has to come before the guard.
    pub(super) locked: Option<Span>,
    /// Whether its variable is what a lock gives, and only looks like a reference.
    pub(super) is_lock_guard: bool,
    /// What it is today, if it is not updated exactly once.
    pub(super) deviates: Option<Verdict>,
    /// How it is lent, if its law has another form than the guard's.
    pub(super) adaptation: Option<Adaptation>,
}

impl Guarded {
    /// Whether the variable or field is a reference already, as the name behind the guard is.
    fn is_reference(&self) -> bool {
        self.locked.is_some() || matches!(self.ty, Ty::Ref(..))
    }

    /// Whether a guard can hold it as it is, or its elements.
    pub(super) fn is_held(&self) -> bool {
        held(&self.ty) == Some(&self.filter) || self.locked.is_some() || self.stars().is_some()
    }

    /// Whether a variable above the loop has it lent.
    pub(super) fn is_lent_above(&self) -> bool {
        self.adaptation.is_some() || self.place.element.is_some()
    }

    /// The functions that may be its law.
    pub(super) fn laws(&self) -> Vec<FunctionId> {
        self.sites.iter().flat_map(|site| &site.targets).copied().chain(self.law).collect()
    }
}

/// An expression that is a guarded place, and stays.
#[derive(Clone, Debug)]
pub(super) struct Mention {
    /// The expression.
    pub(super) at: ExprId,
    /// What has to be written there instead.
    pub(super) edit: Option<(Span, String)>,
    /// What has to be written for elements that the code reaches from there.
    pub(super) elements: Vec<(Span, String)>,
}

/// Every place where the loop names what the guard is to hold, but for the updates that go away and for what stands above the guard.
pub(super) fn mentions(
    of: &LoopBody<'_>,
    guarded: &[Guarded],
    at: usize,
    behind: Option<Span>,
) -> Result<Vec<Mention>, Reason> {
    let own = &guarded[at];
    let place = &own.place;
    let is_gone = |id: ExprId| {
        let mut around = std::iter::once(id).chain(of.ancestors_inside(id));
        around.any(|at| guarded.iter().flat_map(|other| &other.sites).any(|site| site.gone == at))
    };
    let mut found = Vec::new();
    let is_above = |id: ExprId| behind.is_some_and(|before| of.span(id).end <= before.end);
    for id in of.names(own.place.local).filter(|id| !is_gone(*id) && !is_above(*id)) {
        let chain = chain(of, id);
        if !is_about(of, place, id) {
            continue;
        }
        let Some((at, _)) = chain.get(own.place.fields.len()) else {
            let whole = of.written(chain.last().map_or(id, |(at, _)| *at));
            let mut text = format!("all of `{whole}` is used here, and a guard holds `{}`", own.spelled);
            if whole == "self" {
                let field = own.place.fields.first().map_or("", String::as_str);
                let place = if of.is_function { "at its head" } else { "above the loop" };
                let _ = write!(
                    text,
                    ": take it apart {place}, as in `let Self {{ {field}, .. }} = self;`, and let what is called here take \
                     the other fields"
                );
            }
            return Err(Reason { span: of.span(id), text });
        };
        let at = match own.place.element {
            None => *at,
            Some(number) => match element(of, *at) {
                Some((element, other)) if other == number => element,
                Some((_, other))
                    if guarded.iter().any(|own| own.place == Place { element: Some(other), ..place.clone() }) =>
                {
                    continue;
                }
                _ => {
                    let text = format!(
                        "all of `{}` is used here, and its elements are guarded one by one, because their laws take inputs",
                        of.written(*at)
                    );
                    return Err(Reason { span: of.span(*at), text });
                }
            },
        };
        found.push(Mention { at, edit: edit(of, own, at)?, elements: each::unhidden(of, own, at) });
    }
    Ok(found)
}

/// The element that an expression of the array leads to, if it is one by a number.
fn element(of: &LoopBody<'_>, array: ExprId) -> Option<(ExprId, u64)> {
    let parent = of.parent(array)?;
    match of.kind(parent) {
        ExprKind::Index { base, index } if *base == array => Some((parent, number(of, *index)?)),
        _ => None,
    }
}

/// Whether an expression names the variable of a place, and not another field of it.
pub(super) fn is_about(of: &LoopBody<'_>, place: &Place, id: ExprId) -> bool {
    let chain = chain(of, id);
    let is_it = |(own, (_, field)): (&String, &(ExprId, &str))| own == field;
    of.typed.expr_local.get(&id) == Some(&place.local) && place.fields.iter().zip(chain.iter().skip(1)).all(is_it)
}

/// Whether an expression names a variable or field that holds the place among other things: `self` in `self.limit()`.
pub(super) fn is_about_owner(of: &LoopBody<'_>, place: &Place, id: ExprId) -> bool {
    is_about(of, place, id) && chain(of, id).len() <= place.fields.len()
}

/// Whether nothing keeps a part of what an expression names: `self.kf.estimate()`, `self.kf.input = z`, `self.limit()`.
pub(super) fn is_glance(of: &LoopBody<'_>, id: ExprId) -> bool {
    let index = of.program.index;
    let scope = index.scope_of(of.function);
    let is_plain = |id: &ExprId| is_owned(index, &scope, of.typed.ty(*id));
    let asks_for_plain = |call: ExprId, number: usize| {
        let Some(Callee::Resolved(callee)) = of.typed.callees.get(&call) else { return false };
        let is_asked = |target: &FunctionId| {
            let scope = index.scope_of(*target);
            let param = index.function(*target).function.params.get(number);
            param.is_some_and(|param| is_owned(index, &scope, &index.lower(param, &scope)))
        };
        !callee.targets.is_empty() && callee.targets.iter().all(is_asked)
    };
    let mut at = id;
    while let Some(parent) = of.parent(at) {
        match of.kind(parent) {
            ExprKind::Field { base, .. } if *base == at => at = parent,
            ExprKind::MethodCall { receiver, args, .. } if *receiver == at => {
                let is_fine = |(number, arg)| is_plain(arg) || asks_for_plain(parent, number);
                return is_plain(&parent) && args.iter().enumerate().all(is_fine);
            }
            ExprKind::Assign { place, .. } | ExprKind::AssignOp { place, .. } if *place == at => return is_plain(&at),
            ExprKind::Reference { .. } => return false,
            _ => return matches!(of.typed.ty(at), Ty::Int | Ty::Float | Ty::Bool | Ty::Char),
        }
    }
    false
}

/// The expressions from a variable through its fields, as far as they are written: `self`, `self.axes`, `self.axes.roll`.
fn chain<'a>(of: &LoopBody<'a>, id: ExprId) -> Vec<(ExprId, &'a str)> {
    let mut chain = vec![(id, "")];
    let mut at = id;
    while let Some(parent) = of.parent(at)
        && let ExprKind::Field { base, name } = of.kind(parent)
        && *base == at
    {
        chain.push((parent, name));
        at = parent;
    }
    chain
}

fn edit(of: &LoopBody<'_>, own: &Guarded, at: ExprId) -> Result<Option<(Span, String)>, Reason> {
    let span = of.span(at);
    let refuse = |text: String| Err(Reason { span, text });
    let spelled = &own.spelled;
    if !of.span(of.block).contains(span) {
        return refuse(format!("`{spelled}` is used here by code that is written elsewhere"));
    }
    let Some(prefix) = prefix(of, own, at) else {
        let is_each = own.adaptation.as_ref().is_some_and(|adaptation| adaptation.law.each.is_some());
        return refuse(match is_each {
            true => format!(
                "`{spelled}` is used here as a whole, or by a method that any reference has as well, and its elements are lent one by one: \
                 take what is needed of each by `[…]` or in a `for`, or do this outside of the loop"
            ),
            false if let Some(method) = each::resizing(of, own, at) => format!(
                "`{method}` changes which elements `{spelled}` has, and a guard holds those that are there from the head of the loop to the \
                 end of the cycle: do this outside of the loop"
            ),
            false if is_moved_into_closure(of, at) => format!(
                "`{spelled}` is used here as a whole, and a guard holds it: read what the closure needs of it into a variable above"
            ),
            false => format!(
                "`{spelled}` is used here as a whole, and a guard holds it: name the fields or methods that are meant, or do this \
                 outside of the loop"
            ),
        });
    };
    if is_captured(of, at) && !(prefix.is_empty() && of.typed.local(own.place.local).name == own.name) {
        return refuse(format!("`{spelled}` is named in a format string: write it behind the string as an argument"));
    }
    let is_pointer = own.is_reference() || own.is_box();
    let is_hidden = own.adaptation.is_some() && of.parent(at).is_some_and(|parent| is_hidden(of, parent, at));
    let is_opened = own.adaptation.is_some() || own.is_unboxed();
    let is_of_pointer = is_pointer && is_shadowed(of, at) && !is_of_pointee(of, at, &own.ty);
    // What a lock gives is no reference.
    let is_of_pointer =
        is_of_pointer && (is_opened || own.is_lock_guard || own.locked.is_some()) || is_for_box(of, own, at);
    if is_of_pointer {
        let text = format!("what is called here on `{spelled}` is called on a pointer, which the guard does not have");
        return refuse(text);
    }
    let name = match is_shadowed(of, at) {
        _ if is_hidden => format!("(**{})", own.name),
        true if own.adaptation.is_none() && own.is_reference() => own.name.clone(),
        true if own.adaptation.is_none() => format!("(*{})", own.name),
        true => format!("(**{})", own.name),
        false => format!("{prefix}{}", own.name),
    };
    if let Some(star) = needless_star(of, own, at) {
        return Ok(Some((star, name)));
    }
    let written = of.written(at);
    if written == name || is_captured(of, at) {
        return Ok(None);
    }
    let is_deeper = own.adaptation.is_some();
    let parent = of.parent(at).filter(|_| prefix == if is_deeper { "**" } else { "*" });
    if let Some(parent) = parent.filter(|parent| is_borrowed_for_parameter(of, *parent, is_deeper)) {
        return Ok(Some((of.span(parent), own.name.clone())));
    }
    // An element may have the name of a constant for its number.
    let is_element = own.place.element.is_some() && written.ends_with(']');
    if !is_element && written.split_whitespace().collect::<String>() != *spelled {
        return refuse(format!("`{spelled}` is used here by code that is written elsewhere"));
    }
    let field = shorthand(of, at).map_or(String::new(), |field| format!("{field}: "));
    Ok(Some((span, format!("{field}{name}"))))
}

/// Why a place cannot be written in another way that a macro of the code's own is given: what it makes of that is not seen.
pub(super) fn given_to_macro(loops: &Loops<'_>, of: &LoopBody<'_>, own: &Guarded, mention: &Mention) -> Option<Reason> {
    if mention.edit.is_none() && mention.elements.is_empty() {
        return None;
    }
    let (span, block) = (of.span(mention.at), of.span(of.block));
    let outline = loops.outline(of.file());
    let around = outline.around(span.start as usize + 1);
    let around = around.filter(|around| around.is_macro && around.head.start >= block.start as usize);
    let calls = around.map(|around| of.text[around.head.start..around.brackets.start].trim_end_matches([' ', '!']));
    let mut calls = calls.filter_map(|call| call.rsplit(|sign: char| !(sign.is_alphanumeric() || sign == '_')).next());
    // A name in the place of an expression is one expression as well; what stands around it may be the macro's.
    let is_name =
        mention.elements.is_empty() && mention.edit.as_ref().is_some_and(|(at, text)| *at == span && *text == own.name);
    let call = calls.find(|call| loops.hands_on_expressions(call).is_some_and(|hands_on| !(hands_on && is_name)))?;
    let text = format!("`{}` is given to the macro `{call}!` here: write out what that does", own.spelled);
    Some(Reason { span, text })
}

/// Whether `&mut kf` is an argument for a parameter that is a reference, so that a reference can be given as it is; `is_deeper` if that
/// is one to what leads to the filter, which only a reference to one type turns into a reference to the filter.
fn is_borrowed_for_parameter(of: &LoopBody<'_>, id: ExprId, is_deeper: bool) -> bool {
    let (ExprKind::Reference { raw: false, .. }, Some(call)) = (of.kind(id), of.parent(id)) else { return false };
    let Some(Callee::Resolved(callee)) = of.typed.callees.get(&call) else { return false };
    let (args, skipped) = match of.kind(call) {
        ExprKind::MethodCall { args, .. } => (args, 0),
        ExprKind::Call { args, .. } => (args, usize::from(callee.has_receiver)),
        _ => return false,
    };
    let number = args.iter().position(|arg| *arg == id).and_then(|at| at.checked_sub(skipped));
    let index = of.program.index;
    let is_reference = |target: &FunctionId| {
        let param = number.and_then(|number| index.function(*target).function.params.get(number));
        let is_of_one_type = |param| matches!(index.lower(param, &index.scope_of(*target)), Ty::Ref(_, to) if matches!(*to, Ty::Adt(..)));
        param.is_some_and(|param| matches!(param, TypeRef::Reference { .. }) && (!is_deeper || is_of_one_type(param)))
    };
    !callee.targets.is_empty() && callee.targets.iter().all(is_reference)
}

/// Whether a name stands in the text of a format string: `{kf:?}`.
fn is_captured(of: &LoopBody<'_>, at: ExprId) -> bool {
    let is_around = |text: &ExprId| {
        matches!(of.kind(*text), ExprKind::Literal(Literal::Str(_))) && of.span(*text).contains(of.span(at))
    };
    let beside = of.parent(at).map(|parent| of.body.children(parent)).unwrap_or_default();
    matches!(of.kind(at), ExprKind::Path(_)) && beside.iter().any(is_around)
}

pub(super) fn is_format_operand(of: &LoopBody<'_>, at: ExprId) -> bool {
    let Some(ExprKind::Macro(call)) = of.parent(at).map(|parent| of.kind(parent)) else { return false };
    match &call.kind {
        MacroKind::All(_) => !call.path.ends_with("dbg") && !call.path.ends_with("vec"),
        MacroKind::Diverges(_) | MacroKind::Logging(_) => true,
        MacroKind::Assert(_, message)
        | MacroKind::AssertCompare(.., message)
        | MacroKind::DebugOnly(_, message)
        | MacroKind::Ensure(_, message) => message.contains(&at),
        _ => is_captured(of, at),
    }
}

/// What stands before the name where `at` stood, so that the code around it means what it meant; `None` if what is done with
/// it there cannot be done behind a guard.
fn prefix(of: &LoopBody<'_>, own: &Guarded, at: ExprId) -> Option<&'static str> {
    if is_moved_into_closure(of, at) {
        return None;
    }
    if own.adaptation.as_ref().is_some_and(|adaptation| adaptation.law.each.is_some()) {
        return each::prefix(of, own, at);
    }
    let index = of.program.index;
    let parent = of.parent(at)?;
    let is_adapted = own.adaptation.is_some();
    // What is locked may be unlocked by whoever gets it.
    let is_looked_into = match of.kind(parent) {
        ExprKind::MethodCall { receiver, .. } => *receiver == at,
        ExprKind::Field { .. } | ExprKind::Index { .. } | ExprKind::Macro(_) | ExprKind::Deref(_) => true,
        ExprKind::Reference { mutable, .. } => !mutable,
        _ => false,
    };
    if own.locked.is_some() && !is_looked_into {
        return None;
    }
    if is_adapted && is_format_operand(of, at) && is_shown_otherwise(of, at) {
        return Some("**");
    }
    let is_pointer = own.is_box();
    if own.is_unboxed() {
        return boxed::prefix(of, own, at, parent);
    }
    if own.is_reference() || is_pointer {
        return match of.kind(parent) {
            ExprKind::Reference { mutable: true, .. } if !is_pointer => None,
            ExprKind::Assign { place, .. } if *place == at => None,
            ExprKind::MethodCall { receiver, .. } if *receiver == at => Some(""),
            ExprKind::Field { .. } | ExprKind::Index { .. } | ExprKind::Macro(_) => Some(""),
            _ if !is_adapted => Some(""),
            // A reference to a `Box` leads to the filter in two steps, as the reference to what lends it does.
            ExprKind::Deref(_) if matches!(&own.ty, Ty::Ref(_, to) if **to != own.filter) => {
                let beyond = of.parent(parent).map(|beyond| of.kind(beyond));
                matches!(beyond, Some(ExprKind::Deref(_) | ExprKind::Field { .. })).then_some("")
            }
            ExprKind::Deref(_) => Some("*"),
            ExprKind::Reference { raw: false, .. } => Some("**"),
            ExprKind::Call { .. } | ExprKind::MethodCall { .. } if !is_pointer => Some("&mut **"),
            _ => None,
        };
    }
    let is_copy = is_copy(index, &own.ty);
    let through = if is_adapted { "**" } else { "*" };
    let by_value = || is_copy.then_some(through);
    match of.kind(parent) {
        ExprKind::MethodCall { receiver, method, .. } if *receiver == at => {
            let is_fine = match of.typed.callees.get(&parent) {
                Some(Callee::Resolved(callee)) => callee.targets.iter().all(|target| {
                    let receiver = &index.function(*target).function.receiver;
                    matches!(receiver, Some(Receiver::Shared | Receiver::Exclusive)) || is_copy
                }),
                _ => is_by_reference(method) || is_filter(&own.ty) && (is_copy || !is_by_value(method)),
            };
            is_fine.then_some("")
        }
        ExprKind::Field { .. } => Some(""),
        ExprKind::Index { base, .. } if *base == at => Some(""),
        ExprKind::Reference { raw: false, .. } | ExprKind::Deref(_) => Some(through),
        ExprKind::Assign { place, .. } | ExprKind::AssignOp { place, .. } if *place == at => Some(through),
        ExprKind::Match { .. } | ExprKind::Let { .. } | ExprKind::Binary { .. } => Some(through),
        ExprKind::Macro(_) if is_format_operand(of, at) => Some(""),
        // What is compared is borrowed.
        ExprKind::Macro(call) if matches!(call.kind, MacroKind::AssertCompare(..) | MacroKind::DebugOnly(..)) => {
            Some(through)
        }
        ExprKind::Macro(call) if call.path.ends_with("vec") => by_value(),
        ExprKind::For { iterable, .. } if *iterable == at => by_value(),
        ExprKind::Call { .. }
        | ExprKind::MethodCall { .. }
        | ExprKind::Block(_)
        | ExprKind::Assign { .. }
        | ExprKind::Struct { .. }
        | ExprKind::Tuple(_)
        | ExprKind::Array { .. }
        | ExprKind::Repeat { .. }
        | ExprKind::Return(_)
        | ExprKind::Break { .. }
        | ExprKind::Negate(_)
        | ExprKind::Not(_) => by_value(),
        _ => None,
    }
}

/// The name of the field, where it is that of the variable and written once: `Holder { kf }`.
fn shorthand(of: &LoopBody<'_>, at: ExprId) -> Option<String> {
    let ExprKind::Struct { fields, .. } = of.kind(of.parent(at)?) else { return None };
    fields.iter().find(|(_, value)| *value == at)?;
    let is_named = of.text[..of.span(at).start as usize].trim_end().ends_with(':');
    (!is_named && matches!(of.kind(at), ExprKind::Path(_))).then(|| of.written(at).to_owned())
}

/// Whether a method of the filter has the name of one that feeds it behind a guard.
pub(super) fn is_hidden(of: &LoopBody<'_>, parent: ExprId, at: ExprId) -> bool {
    matches!(of.kind(parent), ExprKind::MethodCall { receiver, method, .. }
        if *receiver == at && matches!(method.as_str(), "feed" | "last_output"))
}

fn is_filter(ty: &Ty) -> bool {
    matches!(ty, Ty::Adt(..)) || matches!(ty, Ty::External(path, _) if !path.starts_with("std::"))
}

/// Methods of arrays and vectors that a reference has as well, with the same result.
fn is_by_reference(method: &str) -> bool {
    matches!(
        method,
        "iter" | "iter_mut" | "len" | "is_empty" | "first" | "first_mut" | "last" | "last_mut" | "get" | "get_mut"
    )
}

fn is_copy(index: &Index, ty: &Ty) -> bool {
    match ty {
        Ty::Array(inner, _) => is_copy(index, inner),
        Ty::Adt(..) => index.is_copy(ty),
        _ => false,
    }
}

fn is_moved_into_closure(of: &LoopBody<'_>, at: ExprId) -> bool {
    of.ancestors_inside(at).any(|around| match of.kind(around) {
        ExprKind::Closure(closure) => closure.is_move || closure.is_async,
        ExprKind::Block(block) => block.kind == BlockKind::Async,
        _ => false,
    })
}

/// The filter type of what lies at a place, if a guard can hold it: itself, each element, or each element of each row.
pub(super) fn held(ty: &Ty) -> Option<&Ty> {
    let inner = match ty {
        Ty::Ref(true, inner) => inner,
        other => other,
    };
    if matches!(inner, Ty::Adt(..)) {
        return Some(inner);
    }
    // Arrays of arrays are filters as well.
    std::iter::successors(inner.element(), |row| if let Ty::Array(element, _) = row { Some(element) } else { None })
        .last()
}
