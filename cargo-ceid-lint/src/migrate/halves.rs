//! Laws of several halves: one closure runs them all, with all that they take, and the last one that takes an input feeds it.

use super::Reason;
use super::adapt::{tuple, variable};
use super::body::LoopBody;
use super::inputs::{Input, closed};
use super::mentions::Guarded;
use super::sites::Site;
use super::text::removal;
use crate::source::Span;
use crate::syntax::tree::{ExprId, ExprKind};

/// What becomes of a half that a later one is fed together with.
pub(super) struct Kept {
    /// What the later one is given for it.
    pub(super) values: Vec<String>,
    pub(super) edits: Vec<(Span, String)>,
}

/// One call for each half of the law, in the order in which they run.
pub(super) fn halves<'s>(of: &LoopBody<'_>, own: &'s Guarded) -> Result<Vec<&'s Site>, Reason> {
    let mut halves: Vec<&Site> = Vec::new();
    for site in &own.sites {
        if !halves.iter().any(|half| half.half == site.half) {
            halves.push(site);
        }
    }
    if halves.len() > 1 {
        let refuse = |text: String| Err(Reason { span: of.span(own.sites[0].call), text });
        if own.sites.len() > halves.len() {
            return refuse(format!("a half of the law of `{}` is called in several places", own.spelled));
        }
        if let Some(used) = own.sites.iter().find(|site| site.is_used) {
            let text = format!(
                "what `{}` of `{}` gives back is used here, and a guard runs all of the law when the iteration has ended: let the \
                 filter keep it, and look at it in the next iteration",
                used.method, own.spelled
            );
            return Err(Reason { span: of.span(used.call), text });
        }
    }
    Ok(halves)
}

/// Keeps the inputs of a half until the half after it: in a variable, or by writing them there if nothing stands between.
///
/// # Errors
/// If the later half does not always come after it.
pub(super) fn kept(
    of: &LoopBody<'_>,
    own: &Guarded,
    (site, inputs): (&Site, &[Input]),
    later: &Site,
) -> Result<Kept, Reason> {
    let call = of.span(site.call);
    let refuse = |text: String| Reason { span: call, text };
    let apart = || {
        refuse(format!(
            "several halves of the law of `{}` take inputs, and not one behind the other: make one method of them, which takes all",
            own.spelled
        ))
    };
    let Some((block, Some(stmt))) = of.statement(site.outer) else { return Err(apart()) };
    if !of.ancestors(later.outer).any(|at| Some(at) == of.parent(site.outer)) {
        return Err(apart());
    }
    let outer = of.span(site.outer);
    let is_plain = |input: &Input| {
        let given = site.inputs.iter().find(|id| of.span(**id).end == input.after.end);
        given.map(|given| of.kind(input.value(of, *given))).is_some_and(|kind| match kind {
            ExprKind::Deref(value) => matches!(of.kind(*value), ExprKind::Path(_)),
            ExprKind::Path(_) | ExprKind::Literal(_) => true,
            _ => false,
        })
    };
    let is_constant = |id: &ExprId| match of.kind(*id) {
        ExprKind::Negate(value) => matches!(of.kind(*value), ExprKind::Literal(_)),
        kind => matches!(kind, ExprKind::Literal(_)),
    };
    let is_next = of.statement(later.outer).is_some_and(|(other, later_stmt)| {
        let start = later_stmt.map_or(of.span(later.outer), |stmt| stmt.span).start;
        let between = of.text.get(stmt.span.end as usize..start as usize).unwrap_or(" ");
        std::ptr::eq(other, block) && between.trim().is_empty() && between.matches('\n').count() < 2
    });
    if site.inputs.iter().all(is_constant) || is_next && inputs.iter().all(is_plain) {
        let value =
            |input: &Input| format!("{}{}", input.instead, &of.text[input.before.end as usize..input.end as usize]);
        let gone = removal(of.text, stmt.span.start as usize..stmt.span.end as usize);
        let at = |byte: usize| u32::try_from(byte).unwrap_or(u32::MAX);
        let edits = vec![(Span::new(call.file, at(gone.start), at(gone.end)), String::new())];
        return Ok(Kept { values: inputs.iter().map(value).collect(), edits });
    }
    let mut values: Vec<String> = Vec::new();
    for input in inputs {
        let name = format!("{}_{}", own.name, input.name);
        let name = variable(of, &name).filter(|name| !values.contains(name));
        values.push(
            name.ok_or_else(|| refuse(format!("`{}_{}` means something else in this function", own.name, input.name)))?,
        );
    }
    let (Some(first), Some(last)) = (inputs.first(), inputs.last()) else { return Err(apart()) };
    let (open, close) = if inputs.len() > 1 { ("(", ")") } else { ("", "") };
    // What is thrown away explicitly is a `let` already.
    let start = of.discarded_at(site.outer).unwrap_or(call.start);
    let names = tuple(values.iter().map(String::as_str));
    let mut edits = vec![
        (Span { start, end: first.before.end, ..call }, format!("let {names} = {open}{}", first.instead)),
        (Span { start: last.end, ..outer }, close.to_owned()),
    ];
    let others =
        inputs.iter().skip(1).filter(|input| input.before.start < input.before.end || !input.instead.is_empty());
    edits.extend(others.map(|input| (input.before, input.instead.to_owned())));
    edits.extend(closed(inputs));
    Ok(Kept { values, edits })
}
