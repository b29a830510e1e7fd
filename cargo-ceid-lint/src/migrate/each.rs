//! Collections whose filters are lent one by one, because their laws have another form than the guard's: what the collection
//! becomes, and which of its uses mean the same with elements that are lent.

use std::path::Path;

use super::body::LoopBody;
use super::formats::is_shown_otherwise;
use super::import::{Import, Text};
use super::iteration::zipped;
use super::mentions::{Guarded, is_format_operand, is_hidden};
use super::shadowed::is_for_references;
use super::sites::Part;
use super::text::{code_only, is_no_std, words};
use crate::index::Ty;
use crate::source::Span;
use crate::syntax::tree::{ExprId, ExprKind, MacroKind, PatId, PatKind};
use crate::types::LocalId;

/// How the filters of a collection are lent.
#[derive(Clone, Debug)]
pub(super) struct Each {
    /// The iterator over the collection: `self.axes.each_mut()`.
    pub(super) elements: (String, &'static str),
    /// What the closure calls a filter.
    pub(super) name: String,
    /// The filter as a reference.
    pub(super) lent: String,
    /// Whether what lends them is kept in a vector.
    pub(super) is_vec: bool,
}

/// How the filters of a place are lent, if it is a collection whose elements are updated one by one.
pub(super) fn each(of: &LoopBody<'_>, own: &Guarded) -> Option<Each> {
    let is_fed = own.sites.iter().all(|site| !site.inputs.is_empty());
    let is_element = |part: &Part| match part {
        Part::All => true,
        // Without an input, no law runs.
        Part::Paired | Part::Element(_) => is_fed,
        Part::Whole => false,
    };
    if own.sites.is_empty() || own.locked.is_some() || !own.sites.iter().all(|site| is_element(&site.part)) {
        return None;
    }
    let (element, is_array) = match own.ty.peel() {
        Ty::Array(element, _) => (&**element, true),
        Ty::Slice(element) => (&**element, false),
        Ty::External(path, args) if path == "std::vec::Vec" => (args.first()?, false),
        _ => return None,
    };
    if matches!(own.ty, Ty::Ref(false, _)) {
        return None;
    }
    let is_box = |ty: &Ty| matches!(ty, Ty::External(path, args) if path == "std::boxed::Box" && args.first() == Some(&own.filter));
    let mut names = own.sites.iter().filter_map(|site| match of.kind(site.receiver) {
        ExprKind::Path(path) => Some(path.last().to_owned()),
        _ => None,
    });
    let name = names.next().unwrap_or_else(|| "filter".to_owned());
    let lent = match element {
        element if *element == own.filter => name.clone(),
        element if is_box(element) => format!("&mut **{name}"),
        _ => return None,
    };
    let method = if is_array { "each_mut" } else { "iter_mut" };
    Some(Each { elements: (own.spelled.clone(), method), name, lent, is_vec: !is_array })
}

/// Whether a vector can be made where the loop stands: in a crate that does without the standard library only where `Vec` is imported.
pub(super) fn has_vec(of: &LoopBody<'_>) -> bool {
    let sources = of.program.sources;
    let import = of.program.index.import_of(of.def().module, "Vec");
    let is_vec = import.is_some_and(|path| matches!(path, [.., module, name] if module == "vec" && name == "Vec"));
    let code = if is_vec { code_only(of.text) } else { String::new() };
    let text = Text { text: of.text, code: &code };
    let is_import = |at: usize| Import::at(text, at, "Vec").is_some_and(|import| import.alias.is_none());
    if words(&code, "Vec").any(is_import) {
        return true;
    }
    let own = &sources.file(of.file()).path;
    let is_above = |path: &Path| path.parent().is_some_and(|above| own.starts_with(above));
    !sources.files().any(|(_, file)| is_above(&file.path) && is_no_std(&file.text))
}

/// What stands before the name of the collection where `at` stood; `None` if its filters are used there in a way that is not
/// known to be the same for what lends them.
pub(super) fn prefix(of: &LoopBody<'_>, own: &Guarded, at: ExprId) -> Option<&'static str> {
    let parent = of.parent(at)?;
    match of.kind(parent) {
        ExprKind::Index { base, .. } if *base == at => is_looked_into(of, own, parent).then_some(""),
        ExprKind::MethodCall { receiver, method, args, .. } if *receiver == at && args.is_empty() => {
            let is_fine = match method.as_str() {
                "len" | "is_empty" => true,
                "iter" | "iter_mut" => are_items_looked_into(of, own, parent),
                _ => false,
            };
            is_fine.then_some("")
        }
        ExprKind::Reference { raw: false, .. } => are_items_looked_into(of, own, parent).then_some("*"),
        ExprKind::Deref(_) => {
            let around = of.parent(parent)?;
            let is_borrowed = matches!(of.kind(around), ExprKind::Reference { raw: false, .. });
            (is_borrowed && are_items_looked_into(of, own, around)).then_some("")
        }
        _ => None,
    }
}

/// The method by which a vector of filters gets or loses elements here.
pub(super) fn resizing<'a>(of: &LoopBody<'a>, own: &Guarded, at: ExprId) -> Option<&'a str> {
    let is_vec = matches!(own.ty.peel(), Ty::External(path, _) if path == "std::vec::Vec");
    match of.kind(of.parent(at)?) {
        ExprKind::MethodCall { receiver, method, .. } if *receiver == at && is_vec => {
            let is_one = matches!(
                method.as_str(),
                "append"
                    | "clear"
                    | "drain"
                    | "extend"
                    | "insert"
                    | "pop"
                    | "push"
                    | "remove"
                    | "retain"
                    | "swap_remove"
                    | "truncate"
            );
            is_one.then_some(method.as_str())
        }
        _ => None,
    }
}

/// Whether only fields and methods of an element are used.
fn is_looked_into(of: &LoopBody<'_>, own: &Guarded, element: ExprId) -> bool {
    if own.sites.iter().any(|site| site.gone == element) {
        return true;
    }
    let Some(parent) = of.parent(element) else { return false };
    match of.kind(parent) {
        ExprKind::Field { .. } => true,
        ExprKind::MethodCall { receiver, method, .. } if *receiver == element => {
            !is_for_any_reference(of, parent, method)
        }
        ExprKind::Macro(_) => is_format_operand(of, element) && !is_shown_otherwise(of, element),
        _ => false,
    }
}

/// What is written for the elements reached from a name of the collection on which a method is called that what lends them has as
/// well: `(**filter).feed(…)`.
pub(super) fn unhidden(of: &LoopBody<'_>, own: &Guarded, at: ExprId) -> Vec<(Span, String)> {
    if own.adaptation.as_ref().is_none_or(|adaptation| adaptation.law.each.is_none()) {
        return Vec::new();
    }
    let is_called = |element: &ExprId| {
        let is_site = |call: ExprId| own.sites.iter().any(|site| site.call == call);
        of.parent(*element).is_some_and(|call| is_hidden(of, call, *element) && !is_site(call))
    };
    match elements(of, at) {
        Reached::One(element) if is_called(&element) => {
            let Span { file, start, end } = of.span(element);
            vec![(Span::new(file, start, start), "(*".to_owned()), (Span::new(file, end, end), ")".to_owned())]
        }
        Reached::One(_) | Reached::Nothing => Vec::new(),
        Reached::Each(names) => {
            let called = names.into_iter().filter(is_called);
            called.map(|id| (of.span(id), format!("(**{})", of.written(id)))).collect()
        }
    }
}

/// Elements that are reached from a name of their collection.
pub(super) enum Reached {
    /// One, by its index.
    One(ExprId),
    /// All, one by one, by these names of a variable.
    Each(Vec<ExprId>),
    /// None that could be told.
    Nothing,
}

/// The elements that are reached from a name of the collection.
pub(super) fn elements(of: &LoopBody<'_>, at: ExprId) -> Reached {
    let Some(parent) = of.parent(at) else { return Reached::Nothing };
    let iterator = match of.kind(parent) {
        ExprKind::Index { base, .. } if *base == at => return Reached::One(parent),
        ExprKind::Deref(_) => of.parent(parent).unwrap_or(parent),
        _ => parent,
    };
    match item_of(of, iterator) {
        Some(Some(local)) => Reached::Each(of.names(local).collect()),
        _ => Reached::Nothing,
    }
}

/// Whether only fields and methods of the elements are used that an iterator gives.
fn are_items_looked_into(of: &LoopBody<'_>, own: &Guarded, iterator: ExprId) -> bool {
    item_of(of, iterator).is_some_and(|local| local.is_none_or(|local| is_only_looked_into(of, own, local)))
}

/// The variable that has the elements which an iterator gives, one by one; `Some(None)` if they get none.
fn item_of(of: &LoopBody<'_>, iterator: ExprId) -> Option<Option<LocalId>> {
    let mut at = iterator;
    // Where the element lies in what the iterators around it give.
    let mut steps: Vec<usize> = Vec::new();
    while let Some(parent) = of.parent(at) {
        let pat = match of.kind(parent) {
            ExprKind::For { iterable, pat, .. } if *iterable == at => *pat,
            ExprKind::MethodCall { receiver, method, args, .. } if *receiver == at => {
                match (method.as_str(), &args[..]) {
                    ("rev", []) => {
                        at = parent;
                        continue;
                    }
                    ("enumerate", []) => {
                        steps.push(1);
                        at = parent;
                        continue;
                    }
                    ("map" | "for_each" | "all" | "any", [closure]) | ("fold", [_, closure]) => {
                        let ExprKind::Closure(closure) = of.kind(*closure) else { return None };
                        let (pat, _) = closure.params.last()?;
                        *pat
                    }
                    ("zip", _) => {
                        steps.push(0);
                        at = parent;
                        continue;
                    }
                    _ => return None,
                }
            }
            _ => match zipped(of, parent) {
                Some((one, other)) if one == at || other == at => {
                    steps.push(usize::from(other == at));
                    at = parent;
                    continue;
                }
                _ => return None,
            },
        };
        return item(of, pat, &steps);
    }
    None
}

/// The variable that a pattern gives an item, which lies in tuples; `Some(None)` if it gives it none.
fn item(of: &LoopBody<'_>, pat: PatId, steps: &[usize]) -> Option<Option<LocalId>> {
    match (&of.body.pat(pat).kind, steps.split_last()) {
        (PatKind::Wild, _) => Some(None),
        (PatKind::Tuple(parts), Some((step, steps))) if parts.len() == 2 => item(of, parts[*step], steps),
        (PatKind::Bind { by_ref: false, sub: None, .. }, None) => Some(Some(*of.typed.pat_local.get(&pat)?)),
        _ => None,
    }
}

fn is_only_looked_into(of: &LoopBody<'_>, own: &Guarded, local: LocalId) -> bool {
    let name = &of.typed.local(local).name;
    let is_unread = |id: &ExprId| match of.kind(*id) {
        ExprKind::Opaque(call) => call.mentions.contains(name),
        ExprKind::Unknown { mentions, .. } => mentions.contains(name),
        ExprKind::Macro(call) => matches!(call.kind, MacroKind::Ceid { .. }),
        _ => false,
    };
    of.names(local).all(|id| is_looked_into(of, own, id)) && !of.inside.iter().any(is_unread)
}

/// Methods of the standard library that any reference has as well, and then for itself.
fn is_for_any_reference(of: &LoopBody<'_>, call: ExprId, method: &str) -> bool {
    is_for_references(of, call) || matches!(method, "clone" | "to_owned" | "as_ref" | "as_mut" | "hash")
}

/// Whether filters lie in a `Vec`, which ceid-core knows only with its feature.
pub(super) fn is_vec(ty: &Ty) -> bool {
    match ty {
        Ty::Ref(_, inner) => is_vec(inner),
        Ty::External(path, _) => path == "std::vec::Vec",
        _ => false,
    }
}
