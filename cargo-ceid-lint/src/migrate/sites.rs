//! Where a loop updates a filter by hand: the statements that go away when a guard does it.

use std::ops::Range;

use super::Reason;
use super::body::LoopBody;
use super::exits::diverges;
use super::iteration::{
    Elements, Inner, all_at_once, binding_loop, elements, inner_loop, is_closure_of_a_loop, is_lone,
};
use super::locks::locked;
use super::mentions::held;
use super::passed::passed_on;
use super::text::{with_attributes, without_comments};
use super::turbofish::behind_the_name;
use super::unfit::unfit;
use crate::count::Pair;
use crate::index::{Def, FunctionId, Ty};
use crate::syntax::tree::{ExprId, ExprKind, Literal, MacroKind};
use crate::types::{Callee, LocalId};

/// A variable, and the fields that lead from it to a filter or to what holds filters.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Place {
    pub(super) local: LocalId,
    pub(super) fields: Vec<String>,
    /// The element of the array that lies there, if it is guarded by itself.
    pub(super) element: Option<u64>,
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
    /// Each element for which an inner loop has something else.
    Paired,
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
    /// The function that is its law, if its source is read and no other one can be meant.
    pub(super) law: Option<FunctionId>,
    /// The functions that may be its law.
    pub(super) targets: Vec<FunctionId>,
    /// The name of the law, and which half of it this is.
    pub(super) method: String,
    pub(super) half: usize,
    /// The call, and the expression in it that is the filter.
    pub(super) call: ExprId,
    pub(super) receiver: ExprId,
    /// What the law is given beside its filter.
    pub(super) inputs: Vec<ExprId>,
    /// The inner loop over the elements.
    pub(super) inner: Option<ExprId>,
    /// What goes away: the call, or the whole inner loop; only the filter where the call is one that feeds it.
    pub(super) gone: ExprId,
    /// The text of its statement, if all of it goes away.
    pub(super) stmt: Option<Range<usize>>,
    /// What stands in the place of that text, if it is a branch that does nothing else.
    pub(super) emptied: Option<&'static str>,
    /// What is written behind the call and goes with it: `.unwrap()`.
    pub(super) tail: String,
    /// The call with its tail.
    pub(super) outer: ExprId,
    /// Whether something uses what the law gives back.
    pub(super) is_used: bool,
}

impl Site {
    /// What has run when the filter is updated today.
    pub(super) fn done(&self) -> ExprId {
        if Some(self.gone) == self.inner { self.gone } else { self.outer }
    }

    /// Whether what goes with the call panics where the law fails: `kf.update().unwrap()`.
    pub(super) fn is_unwrapped(&self) -> bool {
        [".unwrap(", ".expect("].iter().any(|opens| self.tail.contains(opens))
    }
}

/// The statements that update the filter of a pair.
pub(super) fn sites(of: &LoopBody<'_>, pair: &Pair) -> Result<Vec<Site>, Reason> {
    pair.updates.iter().map(|span| site(of, pair, *span)).collect()
}

/// The place of a filter that the loop uses and never updates, with an expression that is it and the law that it owes.
pub(super) fn owed(of: &LoopBody<'_>, pair: &Pair) -> Option<(Place, ExprId, Option<FunctionId>)> {
    let at = of.inside.iter().copied().find(|id| of.written(*id) == pair.name && place_of(of, *id).is_some())?;
    let filter = held(of.typed.ty(at)).filter(|held| matches!(held, Ty::Adt(..)))?;
    let law = of.program.index.methods(filter, &pair.law).first()?.function()?;
    Some((place_of(of, at)?, at, Some(law)))
}

fn site(of: &LoopBody<'_>, pair: &Pair, span: crate::source::Span) -> Result<Site, Reason> {
    let refuse = |text: String| Reason { span, text };
    let name = &pair.name;
    let calls = of.inside.iter().copied().filter(|id| of.span(*id) == span);
    let mut calls = calls.filter(|id| matches!(of.typed.callees.get(id), Some(Callee::Resolved(_))));
    let is_no_call = || {
        let advice = format!("the update of `{name}` is not a plain call here: write it as a statement of its own");
        let of_all = "in a loop over the filters, `for filter in …`";
        let is_each = name.ends_with("[*]");
        refuse(if is_each { format!("{advice}, {of_all}") } else { advice })
    };
    let Some(call) = calls.next() else { return passed_on(of, pair, span).ok_or_else(is_no_call) };
    let Some(Callee::Resolved(callee)) = of.typed.callees.get(&call) else { return Err(is_no_call()) };
    let is_function = |target: &FunctionId| of.program.index.function_spec(&Def::Function(*target)).is_some();
    if callee.law.is_none() && callee.targets.iter().any(is_function) {
        return Err(refuse(format!(
            "the law of `{name}` is a function, and a guard runs the law of a type: make it a method of a type that keeps its state"
        )));
    }
    let Some(half) = callee.law else {
        return Err(refuse(format!(
            "`{name}` is updated inside the function that is called here, not in the loop itself: write its body here, or make what owns \
             `{name}` a filter whose law runs this one, with `then` of ceid-core"
        )));
    };
    if of.program.index.filter_spec(&callee.self_ty).is_some_and(|spec| !spec.key.is_empty()) {
        return Err(refuse(format!(
            "`{name}` is one channel of a filter, and a guard runs a law once for all of its filter: keep a filter for each channel"
        )));
    }
    if let Some(text) = unfit(of, call, callee, name) {
        return Err(refuse(text));
    }
    let (receiver, given, inputs, method) = match of.kind(call) {
        ExprKind::MethodCall { receiver, args, method, .. } => {
            (unborrowed(of, *receiver), *receiver, args.clone(), method.clone())
        }
        ExprKind::Call { callee: function, args } if callee.has_receiver && !args.is_empty() => {
            match of.kind(*function) {
                ExprKind::Path(path) => (unborrowed(of, args[0]), args[0], args[1..].to_vec(), path.last().to_owned()),
                _ => return Err(is_no_call()),
            }
        }
        _ => return Err(is_no_call()),
    };
    if !is_written_out(of, call, &method) {
        return Err(refuse(format!(
            "the update of `{name}` is written by a macro: write the call itself here, and migrate the loop then"
        )));
    }
    if without_comments(of.written(call)) != of.written(call) {
        return Err(refuse(format!("a comment stands in the update of `{name}`, and would be lost: put it above")));
    }
    let outer = opened(of, call);
    // What feeds a law gives something back, which an arm would have to throw away.
    let arm = lone_arm(of, outer).filter(|_| inputs.is_empty());
    let is_used = of.statement(outer).is_none() && arm.is_none() && !is_closure_of_a_loop(of, outer);
    let outer = if is_used { call } else { outer };
    let tail = of.text[of.span(call).end as usize..of.span(outer).end as usize].to_owned();
    let stays = is_used || !inputs.is_empty();
    let targets = callee.targets.clone();
    let law = if let [law] = targets.as_slice() { Some(*law) } else { None };
    let of_all = all_at_once(of, receiver, outer, name).filter(|_| !stays);
    let is_of_all = of_all.is_some();
    let (place, part, at, inner) = of_all
        .or_else(|| target(of, receiver))
        .ok_or_else(|| refuse(unreachable_text(of, receiver, !inputs.is_empty())))?;
    // A path may spell the arguments of a type that the variable has, or leave them out.
    let filter = match (&callee.self_ty, held(of.typed.ty(at))) {
        (Ty::Adt(own, _), Some(held @ Ty::Adt(other, _))) if own == other => held.clone(),
        (own, _) => own.clone(),
    };
    let lone = inner.filter(|inner| !stays && (is_of_all || is_lone(of, *inner, outer)));
    if lone.is_some_and(|inner| without_comments(of.written(inner)) != of.written(inner)) {
        let text = format!(
            "a comment stands in the inner loop that updates `{name}`, and would be lost: put it above the loop"
        );
        return Err(refuse(text));
    }
    let (gone, stmt, emptied) = match (lone, arm) {
        _ if stays => (given, None, None),
        (Some(inner), _) => (inner, Some(statement(of, inner, name)?), None),
        (None, Some(arm)) => (outer, Some(arm), Some("{}")),
        (None, None) => match lone_branch(of, outer) {
            Some((branch, left)) => (outer, Some(branch), Some(left)),
            None => (outer, Some(statement(of, outer, name)?), None),
        },
    };
    let site = Site {
        place,
        part,
        at,
        filter,
        law,
        targets,
        method,
        half,
        call,
        receiver,
        inputs,
        inner,
        gone,
        stmt,
        emptied,
        tail,
        outer,
        is_used,
    };
    let is_repeated = |at: &ExprId| {
        Some(*at) != site.inner
            && !(is_of_all && inner.is_some_and(|inner| of.span(inner).contains(of.span(*at))))
            && matches!(of.kind(*at), ExprKind::Loop { .. } | ExprKind::While { .. } | ExprKind::For { .. })
            // What leaves the inner loop at once runs once in it.
            && !of.ancestors_inside(call).take_while(|around| around != at).any(|around| diverges(of, around))
    };
    let is_later = |at: &ExprId| match of.kind(*at) {
        // The closure of the inner loop runs at once.
        ExprKind::Closure(_) => site.inner.is_none() || of.parent(*at) != site.inner,
        // What a macro prints is evaluated where it stands.
        ExprKind::Macro(call) => !matches!(call.kind, MacroKind::All(_)),
        _ => false,
    };
    if of.ancestors_inside(call).any(|at| is_repeated(&at)) {
        let is_part = inner.is_none() && binding_loop(of, receiver, site.place.local).is_some();
        let text = match is_part && !site.place.fields.is_empty() {
            true => format!(
                "`{name}` is a part of each element, of which a guard would borrow the whole: keep the filters in a collection of their own"
            ),
            false => format!("`{name}` is updated in an inner loop"),
        };
        return Err(refuse(text));
    }
    if let Some(around) = of.ancestors_inside(call).find(is_later) {
        return Err(refuse(elsewhere(of, name, around)));
    }
    Ok(site)
}

/// What to do by hand where the update stands in code that other code runs.
fn elsewhere(of: &LoopBody<'_>, name: &str, around: ExprId) -> String {
    if let ExprKind::Macro(call) = of.kind(around) {
        return format!("`{name}` is updated in what `{}!` is given: write the call above it", call.path);
    }
    let taker = of.parent(around).and_then(|parent| match of.kind(parent) {
        ExprKind::MethodCall { receiver, method, .. } if *receiver != around => Some(method.as_str()),
        ExprKind::Call { callee, .. } if *callee != around => Some(of.written(*callee)),
        _ => None,
    });
    match taker {
        Some(taker) => format!(
            "`{name}` is updated in the closure that `{taker}` runs, and a guard lives in one block: if `{taker}` runs it once, write \
             the guard into the closure, as its first statement"
        ),
        None => format!("`{name}` is updated in a closure: write what that does where it is called"),
    }
}

/// Why a guard cannot hold what a receiver leads to, and what to do by hand.
fn unreachable_text(of: &LoopBody<'_>, receiver: ExprId, has_inputs: bool) -> String {
    let written = of.written(receiver);
    let is_in_section = || of.ancestors_inside(receiver).any(|at| matches!(of.kind(at), ExprKind::Closure(_)));
    let is_borrowed = matches!(of.kind(receiver), ExprKind::MethodCall { .. });
    if locked(of, receiver).is_some() && !has_inputs && !is_in_section() {
        return format!(
            "the filter is locked for its update only: lock it for the whole iteration, with `let mut filter = {written};` as its \
             first statement, and migrate the loop then"
        );
    }
    if locked(of, receiver).is_some() || is_borrowed && is_in_section() {
        return "the filter is locked for its update only, and a guard needs it to the end of the cycle: let the loop own the filter, \
                and put a copy of its state behind the lock"
            .to_owned();
    }
    let inner = of.typed.expr_local.get(&receiver).and_then(|local| binding_loop(of, receiver, *local));
    if let Some(Inner { iterable, .. }) = inner.and_then(|inner| inner_loop(of, inner)) {
        let advice = match has_inputs {
            true => "let the filter keep its input, as in ceid-core's `Sample`, and its law take none",
            false => "keep the filters in one array or `Vec` and run over that alone, or update each by its own name",
        };
        return format!(
            "`{written}` comes from `{}`, and a guard updates all elements of one collection: {advice}",
            of.written(iterable)
        );
    }
    if let Some(text) = in_an_element(of, receiver) {
        return text;
    }
    if let ExprKind::Index { index, .. } = of.kind(receiver) {
        let is_outside = |local: &LocalId| of.typed.local(*local).span.start < of.span(of.whole).start;
        if of.typed.expr_local.get(index).is_some_and(is_outside) {
            return format!(
                "`{written}` may be another element in each iteration: if it is not, put `let filter = &mut {written};` above the loop, \
                 and update `filter`"
            );
        }
    }
    if let ExprKind::Index { base, .. } = of.kind(receiver) {
        return format!(
            "nobody can tell which elements of `{0}` are updated as `{written}`: update all of them, in `for filter in &mut {0}`",
            of.written(*base)
        );
    }
    if matches!(of.typed.expr_def.get(&receiver), Some(Def::Value(_))) {
        return format!("`{written}` is a `static`, which all code has: let one variable or field own the filter");
    }
    format!("`{written}` is neither a variable nor a field: it is not known what it leads to")
}

/// What to do with a filter that is a field of an element: `self.legs[0].hip`.
fn in_an_element(of: &LoopBody<'_>, receiver: ExprId) -> Option<String> {
    let mut element = receiver;
    while let ExprKind::Field { base, .. } = of.kind(element) {
        element = *base;
    }
    let (ExprKind::Index { base, index }, true) = (of.kind(element), element != receiver) else { return None };
    let (written, array) = (of.written(receiver), of.written(*base));
    let name = array.rsplit('.').next().unwrap_or(array);
    let length = match of.typed.ty(*base).peel() {
        Ty::Array(_, length) => length.value.filter(|length| *length <= 4),
        _ => None,
    };
    let advice = match (number(of, *index), length) {
        (Some(number), Some(length)) => {
            let names: Vec<String> = (0..length).map(|number| format!("{name}_{number}")).collect();
            let field = &written[of.written(element).len()..];
            format!("`let [{}] = &mut {array};` above the loop, and update `{name}_{number}{field}`", names.join(", "))
        }
        _ => format!("`let element = &mut {};` above the loop, if it is always the same one", of.written(element)),
    };
    Some(format!(
        "`{written}` is a part of an element, and a guard cannot borrow parts of several elements: put {advice}"
    ))
}

/// A call with what only opens its result: `kf.update(z).unwrap()`.
fn opened(of: &LoopBody<'_>, call: ExprId) -> ExprId {
    let mut at = call;
    while let Some(parent) = of.parent(at)
        && let ExprKind::MethodCall { receiver, method, args, .. } = of.kind(parent)
        && *receiver == at
        && matches!((method.as_str(), args.as_slice()), ("unwrap" | "ok" | "unwrap_or_default", []) | ("expect", [_]))
        && args.iter().all(|arg| matches!(of.kind(*arg), ExprKind::Literal(_)))
    {
        at = parent;
    }
    at
}

/// Whether a call stands in the source as a call of that function: what a macro makes stands where the macro is called.
fn is_written_out(of: &LoopBody<'_>, call: ExprId, law: &str) -> bool {
    let text = without_comments(of.written(call));
    let begins = of.span(call).start as usize;
    let parts = |first: ExprId| {
        let span = of.span(first);
        let (before, after) = ((span.start as usize).checked_sub(begins)?, (span.end as usize).checked_sub(begins)?);
        Some((text.get(..before)?.trim_end(), text.get(after..)?.trim_start()))
    };
    match of.kind(call) {
        // The receiver may stand in brackets.
        ExprKind::MethodCall { receiver, .. } => parts(*receiver).is_some_and(|(before, rest)| {
            let rest = rest.trim_start_matches(|sign: char| sign == ')' || sign.is_whitespace());
            let rest = rest.strip_prefix('.').map(|rest| rest.trim_start().trim_start_matches("r#"));
            before.chars().all(|sign| sign == '(' || sign.is_whitespace())
                && rest.is_some_and(|rest| rest.starts_with(law))
        }),
        ExprKind::Call { callee, .. } => {
            let written = of.written(*callee);
            written.strip_suffix(behind_the_name(written)).is_some_and(|path| path.ends_with(law))
                && parts(*callee).is_some_and(|(before, _)| before.is_empty())
        }
        _ => false,
    }
}

/// The text of the statement that an expression is, if nothing uses its value.
pub(super) fn statement(of: &LoopBody<'_>, id: ExprId, name: &str) -> Result<Range<usize>, Reason> {
    let span = of.span(id);
    let refuse = |text: String| Err(Reason { span, text });
    let Some((_, stmt)) = of.statement(id) else {
        return refuse(format!(
            "what the update of `{name}` gives back is used here, and a guard runs it only at the end of the cycle"
        ));
    };
    let range = match stmt {
        Some(stmt) if stmt.cfg.is_some() => {
            return refuse(format!(
                "the update of `{name}` is compiled under a condition, and a guard would always run it"
            ));
        }
        Some(stmt) => with_attributes(of.text, stmt.span.start as usize)..stmt.span.end as usize,
        None => with_attributes(of.text, span.start as usize)..span.end as usize,
    };
    if of.text.get(range.clone()).is_none_or(|text| !text.contains(of.written(id))) {
        return refuse(format!("the update of `{name}` is not written where it runs"));
    }
    Ok(range)
}

/// The arm of a `match` that is an update and nothing else, with its comma.
fn lone_arm(of: &LoopBody<'_>, id: ExprId) -> Option<Range<usize>> {
    let ExprKind::Match { arms, .. } = of.kind(of.parent(id)?) else { return None };
    let is_arm = arms.iter().any(|arm| arm.body == id) && *of.typed.ty(id) == Ty::unit() && of.is_discarded(id);
    let span = of.span(id);
    let rest = &of.text[span.end as usize..];
    let comma = rest.strip_prefix(',').map_or(0, |_| 1);
    is_arm.then_some(span.start as usize..span.end as usize + comma)
}

/// The branch of a choice that does nothing but update a filter, and what is left of it: `{}`, or nothing of an `else`.
fn lone_branch(of: &LoopBody<'_>, id: ExprId) -> Option<(Range<usize>, &'static str)> {
    let (block, _) = of.statement(id)?;
    let around = of.ancestors_inside(id).find(|at| matches!(of.kind(*at), ExprKind::Block(_)))?;
    let own = of.span(around);
    let is_alone = block.stmts.len() + usize::from(block.tail.is_some()) == 1 && block.items.is_empty();
    let has_cfg = block.stmts.iter().any(|stmt| stmt.cfg.is_some());
    let written = of.written(around);
    if !is_alone || has_cfg || without_comments(written) != written || !written.starts_with('{') {
        return None;
    }
    match of.kind(of.parent(around)?) {
        ExprKind::If { then, otherwise: Some(otherwise), .. } if *otherwise == around => {
            let start = of.span(*then).end as usize;
            let between = of.text.get(start..own.start as usize)?;
            (between.trim() == "else").then_some((start..own.end as usize, ""))
        }
        ExprKind::If { then, .. } if *then == around => Some((own.start as usize..own.end as usize, "{}")),
        ExprKind::Match { arms, .. } if arms.iter().any(|arm| arm.body == around) => {
            Some((own.start as usize..own.end as usize, "{}"))
        }
        _ => None,
    }
}

fn unborrowed(of: &LoopBody<'_>, id: ExprId) -> ExprId {
    let id = if let ExprKind::Reference { value, raw: false, .. } = of.kind(id) { *value } else { id };
    let is_pointer = |ty: &Ty| matches!(ty, Ty::Ref(true, _)) || ty.external_name() == Some("Box");
    match of.kind(id) {
        // `*pid` leads to what the name leads to.
        ExprKind::Deref(inner) if matches!(of.kind(*inner), ExprKind::Path(_)) && is_pointer(of.typed.ty(*inner)) => {
            *inner
        }
        _ => id,
    }
}

/// The place that an expression is.
pub(super) fn place_of(of: &LoopBody<'_>, id: ExprId) -> Option<Place> {
    match of.kind(id) {
        ExprKind::Path(_) => Some(Place { local: *of.typed.expr_local.get(&id)?, fields: Vec::new(), element: None }),
        ExprKind::Field { base, name } => {
            let mut place = place_of(of, *base)?;
            place.fields.push(name.clone());
            Some(place)
        }
        _ => None,
    }
}

/// The number that an index is: a literal, or a constant.
pub(super) fn number(of: &LoopBody<'_>, index: ExprId) -> Option<u64> {
    match of.kind(index) {
        ExprKind::Literal(Literal::Int(number, _)) => *number,
        ExprKind::Path(path) if matches!(of.typed.expr_def.get(&index), Some(Def::Value(_))) => {
            let names: Vec<String> = path.segments.iter().map(|segment| segment.name.clone()).collect();
            of.program.index.const_value(&of.program.index.scope_of(of.function), &names)
        }
        _ => None,
    }
}

/// Which place a receiver means, with the inner loop over its elements if there is one.
fn target(of: &LoopBody<'_>, receiver: ExprId) -> Option<(Place, Part, ExprId, Option<ExprId>)> {
    let of_inner = |elements: &Elements| if elements.is_each { Part::All } else { Part::Paired };
    if let ExprKind::Index { base, index } = of.kind(receiver) {
        let place = place_of(of, *base)?;
        if let Some(number) = number(of, *index) {
            return Some((place, Part::Element(number), *base, None));
        }
        return match of.kind(*index) {
            ExprKind::Path(_) => {
                let elements = elements(of, receiver, *of.typed.expr_local.get(index)?)?;
                let is_number = elements.collection.is_none();
                is_number.then(|| (place, of_inner(&elements), *base, Some(elements.inner)))
            }
            _ => None,
        };
    }
    let place = place_of(of, receiver)?;
    if !place.fields.is_empty() || binding_loop(of, receiver, place.local).is_none() {
        return Some((place, Part::Whole, receiver, None));
    }
    let elements = elements(of, receiver, place.local)?;
    let held = elements.collection?;
    Some((place_of(of, held)?, of_inner(&elements), held, Some(elements.inner)))
}
