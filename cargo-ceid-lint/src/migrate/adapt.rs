//! Filters whose laws have another form than the guard's: with inputs, of another crate, in halves. They are lent to ceid-core's
//! `Adapted`, above the loop, with a closure for a law; in the loop they are fed where they were updated.

use super::Reason;
use super::alternatives::has_alternatives;
use super::ambiguous::ambiguous;
use super::body::LoopBody;
use super::closure::Closure;
use super::core_items::{CoreItems, core_name};
use super::each::{each, has_vec};
use super::halves::{halves, kept};
use super::holding::out_of_reach;
use super::in_head::named_in_head;
use super::in_scope::named_in_the_loop;
use super::inputs::{Input, are_lengths_chosen, input, is_generic};
use super::law::delegation;
use super::loops::Loops;
use super::mentions::Guarded;
use super::outputs::instead;
use super::path::path_of_law;
use super::sites::{Part, Site};
use super::text::has_word;
use super::turbofish::{says_inputs, turbofish, unsayable};
use crate::index::{FunctionId, Ty};
use crate::source::Span;
use crate::syntax::tree::{BlockKind, ExprId, ExprKind, Pat, PatKind, Receiver, TypeRef};

/// How a filter is lent to its guard.
#[derive(Clone, Debug)]
pub(super) struct Adaptation {
    /// The variable that lends it: `fed_pid`.
    pub(super) name: String,
    /// What that variable is.
    pub(super) law: Closure,
    /// What the calls of the law become.
    pub(super) edits: Vec<(Span, String)>,
    /// Whether the law runs only in iterations that feed it.
    pub(super) is_fed: bool,
    /// What keeps the inputs of a half that some iterations leave out: the statements that make it.
    pub(super) cells: Vec<String>,
    /// What the program does otherwise.
    pub(super) changes: Vec<Reason>,
    /// What a person should know.
    pub(super) note: String,
}

/// How a filter has to be lent; `None` if the guard can have it as it is. `gone` are the calls of laws that go.
///
/// # Errors
/// Why that cannot be done.
pub(super) fn adaptation(
    loops: &Loops<'_>,
    of: &LoopBody<'_>,
    own: &Guarded,
    gone: &[ExprId],
) -> Result<Option<Adaptation>, Reason> {
    let index = of.program.index;
    let is_ours = |site: &Site| {
        site.law.is_some_and(|law| index.crate_of(index.function(law).module).is_reported)
            && matches!(site.filter, Ty::Adt(..))
            && site.inputs.is_empty()
            && !site.is_used
            && !site.is_unwrapped()
            && site.half == 0
            && turbofish(of, site.call).is_empty()
    };
    let mut two_meanings = None;
    let is_plain = own.sites.iter().all(is_ours)
        && own.is_held()
        && own.law.is_some_and(|law| match delegation(loops, &own.filter, law) {
            Ok(None) => true,
            Ok(Some(new)) => {
                two_meanings = ambiguous(loops, of, gone, law);
                two_meanings.is_none()
                    && !loops.is_left_alone(new.span.file)
                    && !has_alternatives(loops, of, &own.filter, law)
            }
            Err(_) => false,
        });
    if is_plain {
        // An element is lent by the statement that takes its array apart.
        return match own.place.element.map(|_| named_in_head(of, own)) {
            Some(Err(reason)) => Err(reason),
            _ => Ok(None),
        };
    }
    lending(loops, of, own).map_err(|reason| two_meanings.unwrap_or(reason))
}

/// How a filter is lent that the guard cannot have as it is; `None` where something else says why it cannot be lent either.
fn lending(loops: &Loops<'_>, of: &LoopBody<'_>, own: &Guarded) -> Result<Option<Adaptation>, Reason> {
    let refuse = |text: String| Reason { span: of.span(own.sites.first().map_or(own.at, |site| site.call)), text };
    let each = each(of, own);
    if each.is_none() && (own.sites.is_empty() || own.sites.iter().any(|site| site.part != Part::Whole)) {
        // What a guard cannot have as it is, and cannot be lent, says so by itself.
        return match own.sites.iter().find(|site| !site.inputs.is_empty() || site.is_used || site.is_unwrapped()) {
            Some(site) if !site.inputs.is_empty() => Err(refuse(format!(
                "the law of the elements of `{}` takes an input: let each filter keep its input, as in ceid-core's `Sample`, and \
                     its law take none",
                own.spelled
            ))),
            Some(_) => Err(refuse(format!(
                "what the update of `{}` gives back is used here, and a guard runs it only at the end of the cycle",
                own.spelled
            ))),
            None if let (Ty::Adt(..), Some(law)) = (&own.filter, own.law) => {
                let is_written = matches!(delegation(loops, &own.filter, law), Ok(Some(_)));
                if is_written && has_alternatives(loops, of, &own.filter, law) {
                    let text = format!(
                        "the type of `{}` or its law is there under a condition, and other builds may have others: implement \
                         ceid-core's `SampledFilter` for all of them",
                        own.spelled
                    );
                    return Err(Reason { span: of.span(own.at), text });
                }
                Ok(None)
            }
            None => Err(Reason {
                span: of.span(own.at),
                text: format!(
                    "only the trait of `{}` is known, or its type belongs to another crate: guard each under a name of its own",
                    own.spelled
                ),
            }),
        };
    }
    if let Some(verdict) = own.deviates.filter(|_| own.sites.iter().any(|site| !site.inputs.is_empty())) {
        return Err(refuse(format!(
            "`{}` is {} today, and a guard can run a law that takes an input only on the one input of its cycle",
            own.spelled,
            verdict.name()
        )));
    }
    let takes_value = |law: &FunctionId| of.program.index.function(*law).function.receiver == Some(Receiver::Value);
    if own.laws().iter().any(takes_value) {
        return Err(refuse(format!(
            "the law takes `{}` by value, and a guard runs one that takes `&mut self`: write a method that does, and call that here",
            own.spelled
        )));
    }
    if each.as_ref().is_some_and(|each| each.is_vec && (of.is_function || !has_vec(of))) {
        let advice = match own.sites.iter().all(|site| site.inputs.is_empty()) {
            true => "implement ceid-core's `SampledFilter` for what they are, or let their trait be that",
            false => "let each filter keep its input, as in ceid-core's `Sample`, and its law take none",
        };
        return Err(refuse(format!(
            "the filters of `{}` would be lent in a vector, which cannot be made here: {advice}",
            own.spelled
        )));
    }
    let filter = each.as_ref().map_or(&own.name, |each| &each.name);
    let Some(lent) = each.as_ref().map(|each| each.lent.clone()).or_else(|| lent(own)) else {
        return Err(refuse(out_of_reach(of, own)));
    };
    let in_condition = named_in_head(of, own)?;
    if let Some(at) = in_condition.first().filter(|_| each.is_some()) {
        let text = format!("`{}` is used in the head of the loop, where it is lent to the guard", own.spelled);
        return Err(Reason { span: of.span(*at), text });
    }
    if let Some(reason) = named_in_the_loop(of, own) {
        return Err(reason);
    }
    let halves = halves(of, own)?;
    // A half that some iterations leave out does not decide whether the others run.
    let is_apart = |site: &Site| halves.len() > 1 && own.rare.contains(&site.half);
    if each.is_some() && halves.iter().any(|half| is_apart(half)) {
        return Err(refuse(format!(
            "some iterations leave out a half of the law of the elements of `{}`",
            own.spelled
        )));
    }
    let fed: Vec<&Site> =
        own.sites.iter().filter(|site| halves.len() > 1 && !site.inputs.is_empty() && !is_apart(site)).collect();
    let mut edits = Vec::new();
    let mut changes = Vec::new();
    let mut taken: Vec<String> = vec![filter.clone()];
    let mut inputs: Vec<Vec<Input>> = Vec::new();
    for site in &own.sites {
        let mut of_site = Vec::new();
        for number in 0..site.inputs.len() {
            of_site.push(input(of, own, site, number)?);
        }
        inputs.push(of_site);
    }
    // All calls of one law have inputs of one form, because the closure is one.
    for half in &halves {
        if let Some(text) = unsayable(of, own, half, &inputs) {
            return Err(refuse(text));
        }
        let same: Vec<&Vec<Input>> =
            own.sites.iter().zip(&inputs).filter(|(site, _)| site.half == half.half).map(|(_, own)| own).collect();
        let form = |inputs: &[Input]| -> Vec<(bool, Option<String>)> {
            inputs.iter().map(|input| (input.is_lent(), input.annotation.clone())).collect()
        };
        if same.iter().any(|other| form(other) != form(same[0])) {
            return Err(refuse(format!("`{}` is given inputs of several forms", own.spelled)));
        }
        let is_chosen =
            |number: usize| is_generic(of, half, number) || are_lengths_chosen(of, &own.sites, half, number);
        if same.len() > 1 && !says_inputs(of, half) && (0..half.inputs.len()).any(is_chosen) {
            return Err(refuse(format!(
                "each call of `{}` may give `{}` an input of another type, and a guard is fed with one type: give all of them \
                 the same, and let the law take that",
                half.method, own.spelled
            )));
        }
    }
    let mut params = Vec::new();
    let mut body = Vec::new();
    let by_path = match halves.as_slice() {
        [half] => {
            let at = own.sites.iter().position(|site| std::ptr::eq(site, *half)).unwrap_or(0);
            path_of_law(loops, of, half, &inputs[at]).filter(|_| is_value(of, own))
        }
        _ => None,
    };
    let mut cells: Vec<(usize, String, String)> = Vec::new();
    for half in &halves {
        let at = own.sites.iter().position(|site| std::ptr::eq(site, *half)).unwrap_or(0);
        let mut given = Vec::new();
        let mut of_half = Vec::new();
        for input in &inputs[at] {
            let name = free(&input.name, &taken);
            taken.push(name.clone());
            given.push(if input.is_lent() { format!("&{name}") } else { name.clone() });
            of_half.push((name, input.annotation.clone()));
        }
        let call = call(of, half, filter, &given);
        if given.is_empty() || !is_apart(half) {
            params.append(&mut of_half);
            // The value of a law alone is that of the closure.
            let is_alone = halves.len() == 1 && is_value(of, own);
            let discarded = if is_alone { "" } else { discarded(of, half) };
            body.push((0, format!("{discarded}{call}")));
        } else {
            let (cell, made) = cell(of, own, &of_half).map_err(refuse)?;
            // What is thrown away by name may have to be.
            let discarded = discarded(of, half);
            body.extend([
                (
                    0,
                    format!("if let Some({}) = {cell}.take() {{", tuple(of_half.iter().map(|(name, _)| name.as_str()))),
                ),
                (1, format!("{discarded}{call};")),
                (0, "}".to_owned()),
            ]);
            cells.push((half.half, cell, made));
        }
    }
    let is_fed = !params.is_empty();
    // The last half that takes an input gets those of the others as well.
    let mut before = Vec::new();
    for (site, inputs) in own.sites.iter().zip(&inputs) {
        let later = fed.iter().skip_while(|other| !std::ptr::eq(**other, site)).nth(1);
        if let Some(later) = later {
            let kept = kept(of, own, (site, inputs), later)?;
            edits.extend(kept.edits);
            before.extend(kept.values);
            continue;
        }
        let before = if fed.last().is_some_and(|last| std::ptr::eq(*last, site)) { &before[..] } else { &[] };
        let cell = cells.iter().find(|(half, ..)| *half == site.half).map(|(_, cell, _)| cell.as_str());
        let (edit, change) = instead(of, own, site, (inputs, before), cell, halves.len() > 1)?;
        edits.extend(edit);
        changes.extend(change);
    }
    let is_value = body.len() == 1 && is_value(of, own);
    for (_, line) in body.iter_mut().filter(|(_, line)| !is_value && line.ends_with(')')) {
        line.push(';');
    }
    let adapted = CoreItems::of(of.program, of.function).name("Adapted");
    let verb = if is_fed { "fed" } else { "adapted" };
    let constructor = if is_fed { "fed" } else { "new" };
    let params = parameters(filter, &params);
    let laws = halves.iter().map(|half| format!("`{}`", half.method)).collect::<Vec<_>>().join(" and ");
    let note = if is_fed {
        let fed = each.as_ref().map_or(own.name.clone(), |_| format!("{}[…]", own.name));
        format!("`{fed}.feed` keeps what {laws} will be given until then")
    } else {
        let place = if by_path.is_some() { "in the line" } else { "in the closure" };
        format!("the law of `{}` is {laws}, {place} above the loop", own.name)
    };
    let name = variable(of, &format!("{verb}_{}", own.name))
        .ok_or_else(|| refuse(format!("`{verb}_{}` means something else in this function", own.name)))?;
    edits.extend(in_condition.into_iter().map(|at| (of.span(at), name.clone())));
    Ok(Some(Adaptation {
        name,
        law: Closure { call: (format!("{adapted}::{constructor}"), lent), params, body, is_value, path: by_path, each },
        edits,
        is_fed,
        cells: cells.into_iter().map(|(_, _, made)| made).collect(),
        changes,
        note,
    }))
}

/// The place as a reference to the filter in it, if it is one filter that can be borrowed.
pub(super) fn lent(own: &Guarded) -> Option<String> {
    let is_box = |ty: &Ty| matches!(ty, Ty::External(path, args) if path == "std::boxed::Box" && args.first() == Some(&own.filter));
    let spelled = &own.spelled;
    if own.place.element.is_some() {
        return (own.ty == own.filter).then(|| own.name.clone());
    }
    match &own.ty {
        ty if *ty == own.filter => Some(format!("&mut {spelled}")),
        ty if is_box(ty) => Some(format!("&mut *{spelled}")),
        Ty::Ref(true, inner) if **inner == own.filter && own.is_lock_guard => Some(format!("&mut *{spelled}")),
        Ty::Ref(true, inner) if **inner == own.filter => Some(spelled.clone()),
        Ty::Ref(true, inner) if is_box(inner) => Some(format!("&mut **{spelled}")),
        _ => None,
    }
}

/// Why what a guard borrows mutably cannot be: a law that takes `&self` does without, and so does what no law has been run on.
pub(super) fn is_not_mutable(of: &LoopBody<'_>, own: &Guarded) -> Option<Reason> {
    let around = |at: &ExprId| match of.kind(*at) {
        ExprKind::Field { base, .. } | ExprKind::Index { base, .. } => Some(*base),
        _ => None,
    };
    // What lies behind a reference is as mutable as that one says.
    let is_ref = |at: ExprId| matches!(of.typed.ty(at), Ty::Ref(..));
    let is_own =
        own.is_lock_guard || !matches!(own.ty, Ty::Ref(..)) && !std::iter::successors(Some(own.at), around).any(is_ref);
    let local = of.typed.local(own.place.local);
    let binds =
        |pat: &Pat| pat.span == local.span && matches!(pat.kind, PatKind::Bind { mutable: false, by_ref: false, .. });
    let is_fixed = is_own && of.body.pats.iter().any(binds);
    let name = &local.name;
    let text = || match own.sites.is_empty() {
        true => format!("nothing updates `{name}` in the cycle: if a guard should, write `mut {name}` here"),
        false => format!("`{name}` is lent to the guard mutably, and is not declared so: write `mut {name}` here"),
    };
    is_fixed.then(|| Reason { span: local.span, text: text() })
}

/// The variable that keeps what a half is given until the law runs, and the statement that makes it.
fn cell(of: &LoopBody<'_>, own: &Guarded, inputs: &[(String, Option<String>)]) -> Result<(String, String), String> {
    let is_async = |at: ExprId| match of.kind(at) {
        ExprKind::Closure(closure) => closure.is_async,
        ExprKind::Block(block) => block.kind == BlockKind::Async,
        _ => false,
    };
    if of.def().function.is_async || of.ancestors(of.whole).any(is_async) {
        return Err(format!(
            "some iterations leave out a half of the law of `{}`, and its input cannot be shared across an `.await`",
            own.spelled
        ));
    }
    let of_input = match inputs {
        [(name, _)] => name.as_str(),
        _ => "inputs",
    };
    let name = format!("{}_{of_input}", own.name);
    let name = variable(of, &name).ok_or_else(|| format!("`{name}` means something else in this function"))?;
    let is_annotated = inputs.iter().any(|(_, ty)| ty.is_some());
    let types = tuple(inputs.iter().map(|(_, ty)| ty.as_deref().unwrap_or("_")));
    let ty = if is_annotated { format!("::<{types}>") } else { String::new() };
    let core = core_name(of.program.index, of.function);
    let made = format!("let {name} = {core}::cell::Cell::new(None{ty});");
    Ok((name, made))
}

/// One name as it is, several as a tuple.
pub(super) fn tuple<'a>(parts: impl Iterator<Item = &'a str>) -> String {
    match parts.collect::<Vec<_>>().as_slice() {
        [one] => (*one).to_owned(),
        all => format!("({})", all.join(", ")),
    }
}

/// The parameters of the closure, with their types as far as the compiler would not find them.
fn parameters(filter: &str, inputs: &[(String, Option<String>)]) -> String {
    let names: Vec<&str> = inputs.iter().map(|(name, _)| name.as_str()).collect();
    let types: Vec<&str> = inputs.iter().map(|(_, ty)| ty.as_deref().unwrap_or("_")).collect();
    let is_annotated = inputs.iter().any(|(_, ty)| ty.is_some());
    match (inputs, is_annotated) {
        ([], _) => filter.to_owned(),
        ([_], false) => format!("{filter}, {}", names[0]),
        ([_], true) => format!("{filter}, {}: {}", names[0], types[0]),
        (_, false) => format!("{filter}, ({})", names.join(", ")),
        (_, true) => format!("{filter}, ({}): ({})", names.join(", "), types.join(", ")),
    }
}

/// The call of a law on what the closure gets.
fn call(of: &LoopBody<'_>, site: &Site, filter: &str, given: &[String]) -> String {
    let call = match of.kind(site.call) {
        ExprKind::Call { callee, .. } => {
            let all: Vec<&str> = std::iter::once(filter).chain(given.iter().map(String::as_str)).collect();
            format!("{}({})", of.written(*callee), all.join(", "))
        }
        _ => format!("{filter}.{}{}({})", site.method, turbofish(of, site.call), given.join(", ")),
    };
    format!("{call}{}", site.tail)
}

/// What stands before the call of a law whose result is thrown away by name.
fn discarded(of: &LoopBody<'_>, site: &Site) -> &'static str {
    if of.discarded_at(site.outer).is_some() { "let _ = " } else { "" }
}

/// Whether the value of the closure is what the law gives back.
fn is_value(of: &LoopBody<'_>, own: &Guarded) -> bool {
    own.sites.iter().any(|site| site.is_used) || is_number_or_unit(of, own)
}

/// Whether what a law gives back is a plain value, which may as well be kept.
fn is_number_or_unit(of: &LoopBody<'_>, own: &Guarded) -> bool {
    let is_plain = |law: &FunctionId| {
        let output = &of.program.index.function(*law).function.output;
        *output == TypeRef::unit() || matches!(output, TypeRef::Path(path) if is_number(path.last()))
    };
    let laws = own.laws();
    !laws.is_empty() && laws.iter().all(is_plain) && own.sites.iter().all(|site| site.tail.is_empty())
}

fn is_number(name: &str) -> bool {
    matches!(
        name,
        "f32" | "f64" | "bool" | "usize" | "isize" | "u8" | "u16" | "u32" | "u64" | "i8" | "i16" | "i32" | "i64"
    )
}

/// A name that the closure does not use yet.
fn free(name: &str, taken: &[String]) -> String {
    let mut found = name.to_owned();
    let mut number = 2;
    while taken.contains(&found) {
        found = format!("{name}_{number}");
        number += 1;
    }
    found
}

/// The name, or with a number the first one that means nothing in the function.
pub(super) fn variable(of: &LoopBody<'_>, name: &str) -> Option<String> {
    let body = of.program.sources.snippet(of.span(of.body.root));
    let is_taken = |name: &str| has_word(body, name) || of.typed.locals.iter().any(|local| local.name == name);
    let numbered = (2..10).map(|number| format!("{name}_{number}"));
    std::iter::once(name.to_owned()).chain(numbered).find(|name| !is_taken(name))
}
