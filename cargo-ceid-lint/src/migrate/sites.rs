//! Where a loop updates a filter by hand: the statements that go away when a guard does it.

use std::ops::Range;

use super::Reason;
use super::body::LoopBody;
use super::mentions::held;
use crate::count::Pair;
use crate::index::{FunctionId, Ty};
use crate::syntax::tree::{ExprId, ExprKind, Literal, PatId, PatKind};
use crate::types::{Callee, LocalId};

/// A variable, and the fields that lead from it to a filter or to what holds filters.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Place {
    pub(super) local: LocalId,
    pub(super) fields: Vec<String>,
}

/// Which elements of what lies at a place are updated.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Part {
    /// It is a filter itself.
    Whole,
    /// One element.
    Element(u64),
    /// Each element once, in an inner loop.
    All,
}

/// A statement that updates a filter.
#[derive(Clone, Debug)]
pub(super) struct Site {
    pub(super) place: Place,
    pub(super) part: Part,
    /// An expression that is the place.
    pub(super) at: ExprId,
    /// The type of the filter.
    pub(super) filter: Ty,
    /// The function that is its law.
    pub(super) law: FunctionId,
    /// The call.
    pub(super) call: ExprId,
    /// The inner loop over the elements.
    pub(super) inner: Option<ExprId>,
    /// What goes away: the call, or the whole inner loop.
    pub(super) gone: ExprId,
    /// The text of its statement.
    pub(super) stmt: Range<usize>,
}

/// The statements that update the filter of a pair.
pub(super) fn sites(of: &LoopBody<'_>, pair: &Pair) -> Result<Vec<Site>, Reason> {
    pair.updates.iter().map(|span| site(of, pair, *span)).collect()
}

/// The place of a filter that the loop uses and never updates, with an expression that is it and the law that it owes.
pub(super) fn owed(of: &LoopBody<'_>, pair: &Pair) -> Option<(Place, ExprId, FunctionId)> {
    let at = of.inside.iter().copied().find(|id| of.written(*id) == pair.name && place_of(of, *id).is_some())?;
    let filter = held(of.typed.ty(at)).filter(|held| matches!(held, Ty::Adt(..)))?;
    let law = of.program.index.methods(filter, &pair.law).first()?.function()?;
    Some((place_of(of, at)?, at, law))
}

fn site(of: &LoopBody<'_>, pair: &Pair, span: crate::source::Span) -> Result<Site, Reason> {
    let refuse = |text: String| Reason { span, text };
    let name = &pair.name;
    let calls = of.inside.iter().copied().filter(|id| of.span(*id) == span);
    let mut calls = calls.filter(|id| matches!(of.typed.callees.get(id), Some(Callee::Resolved(_))));
    let Some(call) = calls.next() else {
        return Err(refuse(format!("the update of `{name}` is not a plain call here")));
    };
    let Some(Callee::Resolved(callee)) = of.typed.callees.get(&call) else {
        return Err(refuse(format!("the update of `{name}` is not a plain call here")));
    };
    let (1, Some(0), Some(law)) = (callee.targets.len(), callee.law, callee.targets.first()) else {
        return Err(refuse(match callee.law {
            None => format!("`{name}` is updated inside the function that is called here, not in the loop itself"),
            Some(0) => format!("which law of `{name}` runs here is decided at run time"),
            Some(_) => format!("the law of `{name}` has several halves"),
        }));
    };
    let (receiver, arguments) = match of.kind(call) {
        ExprKind::MethodCall { receiver, args, .. } => (*receiver, args.as_slice()),
        ExprKind::Call { args, .. } if callee.has_receiver && !args.is_empty() => (unborrowed(of, args[0]), &args[1..]),
        _ => return Err(refuse(format!("the update of `{name}` is not a plain call here"))),
    };
    if !arguments.is_empty() {
        return Err(refuse(format!(
            "the law of `{name}` takes an input: give the filter a method that only keeps the input, and let the law use it"
        )));
    }
    let stmt = statement(of, call, name)?;
    let filter = callee.self_ty.clone();
    let (place, part, at, inner) = target(of, receiver).ok_or_else(|| {
        refuse(format!(
            "`{}` is neither a variable nor a field: it is not known what it leads to",
            of.written(receiver)
        ))
    })?;
    let mut site = Site { place, part, at, filter, law: *law, call, inner, gone: call, stmt };
    if let Some(inner) = inner {
        let ExprKind::For { body, .. } = of.kind(inner) else { return Err(refuse("not a loop".to_owned())) };
        if let ExprKind::Block(block) = of.kind(*body)
            && block.stmts.len() + usize::from(block.tail.is_some()) == 1
            && block.items.is_empty()
            && !of.written(*body).contains("//")
        {
            (site.stmt, site.gone) = (statement(of, inner, name)?, inner);
        }
    }
    let is_repeated = |at: &ExprId| {
        Some(*at) != site.inner
            && matches!(of.kind(*at), ExprKind::Loop { .. } | ExprKind::While { .. } | ExprKind::For { .. })
    };
    let is_later = |at: &ExprId| matches!(of.kind(*at), ExprKind::Closure(_) | ExprKind::Macro(_));
    if of.ancestors_inside(call).any(|at| is_repeated(&at)) {
        return Err(refuse(format!("`{name}` is updated in an inner loop")));
    }
    if of.ancestors_inside(call).any(|at| is_later(&at)) {
        return Err(refuse(format!("`{name}` is updated in a closure or macro")));
    }
    Ok(site)
}

/// The text of the statement that an expression is, if nothing uses its value and something is left beside it.
fn statement(of: &LoopBody<'_>, id: ExprId, name: &str) -> Result<Range<usize>, Reason> {
    let span = of.span(id);
    let refuse = |text: String| Err(Reason { span, text });
    let Some((block, stmt)) = of.statement(id) else {
        return refuse(format!("what the update of `{name}` gives back is used here, in the same iteration"));
    };
    let is_alone = block.stmts.len() + usize::from(block.tail.is_some()) == 1;
    if is_alone && of.parent(id) != Some(of.block) && !of.ancestors_inside(id).any(|at| is_for(of, at)) {
        return refuse(format!("the branch that updates `{name}` does nothing else, and would be empty"));
    }
    let range = match stmt {
        Some(stmt) if stmt.cfg.is_some() => return refuse(format!("the update of `{name}` is conditionally compiled")),
        Some(stmt) => stmt.span.start as usize..stmt.span.end as usize,
        None => span.start as usize..span.end as usize,
    };
    if of.text.get(range.clone()).is_none_or(|text| !text.starts_with(of.written(id))) {
        return refuse(format!("the update of `{name}` is not written where it runs"));
    }
    Ok(range)
}

fn is_for(of: &LoopBody<'_>, id: ExprId) -> bool {
    matches!(of.kind(id), ExprKind::For { .. })
}

fn unborrowed(of: &LoopBody<'_>, id: ExprId) -> ExprId {
    match of.kind(id) {
        ExprKind::Reference { value, raw: false, .. } => *value,
        _ => id,
    }
}

/// The place that an expression is.
pub(super) fn place_of(of: &LoopBody<'_>, id: ExprId) -> Option<Place> {
    match of.kind(id) {
        ExprKind::Path(_) => Some(Place { local: *of.typed.expr_local.get(&id)?, fields: Vec::new() }),
        ExprKind::Field { base, name } => {
            let mut place = place_of(of, *base)?;
            place.fields.push(name.clone());
            Some(place)
        }
        _ => None,
    }
}

/// Which place a receiver means, with the inner loop over its elements if there is one.
fn target(of: &LoopBody<'_>, receiver: ExprId) -> Option<(Place, Part, ExprId, Option<ExprId>)> {
    if let ExprKind::Index { base, index } = of.kind(receiver) {
        let place = place_of(of, *base)?;
        return match of.kind(*index) {
            ExprKind::Literal(Literal::Int(Some(number), _)) => Some((place, Part::Element(*number), *base, None)),
            ExprKind::Path(_) => {
                let local = of.typed.expr_local.get(index)?;
                let inner = binding_loop(of, receiver, *local)?;
                let ExprKind::For { iterable, .. } = of.kind(inner) else { return None };
                matches!(of.kind(*iterable), ExprKind::Range { .. }).then_some((place, Part::All, *base, Some(inner)))
            }
            _ => None,
        };
    }
    let place = place_of(of, receiver)?;
    if !place.fields.is_empty() {
        return Some((place, Part::Whole, receiver, None));
    }
    let Some(inner) = binding_loop(of, receiver, place.local) else {
        return Some((place, Part::Whole, receiver, None));
    };
    let ExprKind::For { iterable, .. } = of.kind(inner) else { return None };
    let held = match of.kind(*iterable) {
        ExprKind::Reference { mutable: true, raw: false, value } => *value,
        ExprKind::MethodCall { receiver, method, args, .. } if args.is_empty() => match (method.as_str(), receiver) {
            ("iter_mut", held) => *held,
            ("enumerate", inner) => match of.kind(*inner) {
                ExprKind::MethodCall { receiver, method, .. } if method == "iter_mut" => *receiver,
                _ => return None,
            },
            _ => return None,
        },
        _ => return None,
    };
    Some((place_of(of, held)?, Part::All, held, Some(inner)))
}

/// The inner `for` whose pattern binds a variable.
fn binding_loop(of: &LoopBody<'_>, id: ExprId, local: LocalId) -> Option<ExprId> {
    let binds = |at: &ExprId| match of.kind(*at) {
        ExprKind::For { pat, .. } => bound(of, *pat).any(|pat| of.typed.pat_local.get(&pat) == Some(&local)),
        _ => false,
    };
    of.ancestors_inside(id).find(|at| binds(at))
}

/// A pattern, and the parts of a tuple.
fn bound<'a>(of: &LoopBody<'a>, pat: PatId) -> impl Iterator<Item = PatId> + 'a {
    let parts: &'a [PatId] = match &of.body.pat(pat).kind {
        PatKind::Tuple(parts) => parts,
        _ => &[],
    };
    std::iter::once(pat).chain(parts.iter().copied())
}
