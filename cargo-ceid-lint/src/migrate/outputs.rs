//! What the calls of a law become where it is fed: whether its result is used, and what stands in its place.

use super::Reason;
use super::body::LoopBody;
use super::inputs::{Input, closed};
use super::iteration::is_closure_of_a_loop;
use super::mentions::Guarded;
use super::sites::{Part, Site};
use crate::index::{Index, TraitName, Ty};
use crate::source::Span;
use crate::syntax::tree::ExprKind;

/// The edits that turn a call of the law into one that feeds it, with what other halves are fed with before its own inputs, and
/// what changes by that.
///
/// # Errors
/// Why that cannot be done.
#[expect(clippy::type_complexity, reason = "the edits, and what changes")]
pub(super) fn instead(
    of: &LoopBody<'_>,
    own: &Guarded,
    site: &Site,
    (inputs, before): (&[Input], &[String]),
    cell: Option<&str>,
    has_halves: bool,
) -> Result<(Vec<(Span, String)>, Option<Reason>), Reason> {
    let call = of.span(site.call);
    if inputs.is_empty() && (!site.is_used || has_halves) {
        return Ok((Vec::new(), None));
    }
    let is_arm = is_idle_arm(of, site);
    let is_used = site.is_used && !is_arm;
    let (rest, change) = if is_used { used(of, own, site)? } else { (String::new(), None) };
    // An element has the name that an inner loop gives it, or its number.
    let name = match of.kind(site.receiver) {
        _ if site.part == Part::Whole => own.name.clone(),
        ExprKind::Index { index, .. } => format!("{}[{}]", own.name, of.written(*index)),
        _ => of.written(site.receiver).to_owned(),
    };
    let (Some(first), Some(last)) = (inputs.first(), inputs.last()) else {
        return Ok((vec![(call, format!("{name}.last_output(){rest}"))], change));
    };
    let is_alone = is_arm || !is_used && is_closure_of_a_loop(of, site.outer);
    // What feeds a law gives something back, also where the law itself does not.
    let discarded = if cell.is_none() && !is_used && of.has_to_use_results { "let _ = " } else { "" };
    let (begin, end) = match () {
        () if is_alone => ("{ ", "; }"),
        () if !is_used && of.is_tail(site.outer) => ("", ";"),
        () => ("", ""),
    };
    let (open, close) = if inputs.len() + before.len() > 1 { ("(", ")") } else { ("", "") };
    let before: String = before.iter().map(|value| format!("{value}, ")).collect();
    let (open, close) = match cell {
        Some(cell) => (format!("{begin}{cell}.set(Some({open}"), format!("{close}))")),
        None => (format!("{begin}{discarded}{name}.feed({open}"), format!("{close})")),
    };
    let start = of.discarded_at(site.outer).filter(|_| !is_used).unwrap_or(call.start);
    let stop = of.span(site.outer).end;
    // Behind braces, an arm has no comma.
    let stop = stop + u32::from(is_arm && of.text[stop as usize..].starts_with(','));
    let mut edits = vec![
        (Span { start, end: first.before.end, ..call }, format!("{open}{before}{}", first.instead)),
        (Span { start: last.end, end: stop, ..of.span(site.outer) }, format!("{close}{rest}{end}")),
    ];
    let others =
        inputs.iter().skip(1).filter(|input| input.before.start < input.before.end || !input.instead.is_empty());
    edits.extend(others.map(|input| (input.before, input.instead.to_owned())));
    edits.extend(closed(inputs));
    Ok((edits, change))
}

/// Whether an update is an arm of a `match` whose value is nothing, and that nothing uses.
fn is_idle_arm(of: &LoopBody<'_>, site: &Site) -> bool {
    let Some(ExprKind::Match { arms, .. }) = of.parent(site.outer).map(|around| of.kind(around)) else { return false };
    let is_idle = *of.typed.ty(site.call) == Ty::unit() && !site.inputs.is_empty() && of.is_discarded(site.outer);
    is_idle && arms.iter().any(|arm| arm.body == site.outer)
}

/// What stands for the result of a law until it has run, and that this is another one.
fn used(of: &LoopBody<'_>, own: &Guarded, site: &Site) -> Result<(String, Option<Reason>), Reason> {
    let span = of.span(site.call);
    let output = of.typed.ty(site.call);
    if *output == Ty::unit() {
        return match site.inputs.is_empty() {
            true => Err(Reason { span, text: format!("the update of `{}` is no statement of its own", own.spelled) }),
            false => Ok((".unwrap_or_default()".to_owned(), None)),
        };
    }
    if of.is_function {
        let text = format!(
            "what the update of `{}` gives back is used here; a function that is called once per cycle keeps nothing of the cycle before",
            own.spelled
        );
        return Err(Reason { span, text });
    }
    if lends(of, site) {
        let text = format!(
            "what the update of `{}` gives back is used here, and may be a part of the filter, which its guard has up to the end of the \
             cycle: let it be a copy",
            own.spelled
        );
        return Err(Reason { span, text });
    }
    let Some((rest, first)) = before_the_first(of.program.index, output) else {
        let text = format!(
            "what the update of `{}` gives back is used here, where the guard has only that of the cycle before, and in the first \
             cycle nothing that could stand for it",
            own.spelled
        );
        return Err(Reason { span, text });
    };
    let text = format!(
        "what `{}` of `{}` gives back is used here; with the guard, it is that of the cycle before, and {first} in the first cycle",
        site.method, own.spelled
    );
    Ok((rest.to_owned(), Some(Reason { span, text })))
}

/// Whether what a law gives back may be a part of its filter.
fn lends(of: &LoopBody<'_>, site: &Site) -> bool {
    let index = of.program.index;
    site.targets.iter().any(|law| {
        let function = &index.function(*law).function;
        let output = index.lower(&function.output, &index.scope_of(*law));
        let written = of.program.sources.snippet(function.head).rsplit_once("->").map_or("", |(_, output)| output);
        let has_own = written.matches('&').count() > written.matches("&'static ").count();
        let has_lifetime = |ty: &Ty| matches!(ty, Ty::Adt(id, _) if index.type_def(*id).generics.has_lifetimes);
        output.has_part(&mut |part| matches!(part, Ty::Ref(..)) && has_own || has_lifetime(part))
    })
}

/// How a result is asked for that may not be there yet, and what that gives.
fn before_the_first(index: &Index, ty: &Ty) -> Option<(&'static str, &'static str)> {
    match ty {
        Ty::Int | Ty::Float => Some((".unwrap_or_default()", "0")),
        Ty::Bool => Some((".unwrap_or_default()", "`false`")),
        Ty::External(path, _) if path == "std::option::Option" => Some((".unwrap_or_default()", "`None`")),
        Ty::External(path, args) if path == "std::result::Result" && args.first() == Some(&Ty::unit()) => {
            Some((".unwrap_or(Ok(()))", "`Ok(())`"))
        }
        Ty::External(path, args) if path == "std::result::Result" => {
            let is_default = args.first().is_some_and(|ok| has_default(index, ok));
            is_default.then_some((".unwrap_or_else(|| Ok(Default::default()))", "`Ok` of the default"))
        }
        _ => has_default(index, ty).then_some((".unwrap_or_default()", "the default of its type")),
    }
}

fn has_default(index: &Index, ty: &Ty) -> bool {
    match ty {
        Ty::Int | Ty::Float | Ty::Bool | Ty::Char => true,
        Ty::Tuple(parts) => parts.len() <= 12 && parts.iter().all(|part| has_default(index, part)),
        Ty::Array(inner, length) => length.value.is_some_and(|length| length <= 32) && has_default(index, inner),
        Ty::Adt(id, _) => {
            let def = index.type_def(*id);
            let is_derived = def.attributes.iter().any(|attribute| attribute.derives("Default"));
            let is_written = index.impls_of(ty).iter().any(|id| {
                let implemented = &index.impl_def(*id).implements;
                matches!(implemented, Some(TraitName::External(path)) if path == "std::default::Default")
            });
            is_derived || is_written
        }
        _ => false,
    }
}
