//! What forbids a guard in a loop or function as a whole, whatever its filters are.

use super::body::LoopBody;
use super::text::without_comments;
use super::{Plan, Reason};
use crate::count::{Cycle, Pair, Verdict};
use crate::flow::Program;
use crate::index::Owner;
use crate::syntax::Outline;
use crate::syntax::tree::{ExprId, ExprKind};

/// Why the loop as a whole cannot be rewritten.
pub(super) fn whole_loop(of: &LoopBody<'_>, outline: &Outline, edition: &str) -> Result<(), String> {
    let span = of.span(of.block);
    if edition == "2015" {
        return Err("the crate has edition 2015, and the macros of `ceid_core` need a later one: run `cargo fix --edition`, and set \
                    `edition = \"2018\"` in the manifest"
            .to_owned());
    }
    if !of.program.sources.snippet(span).starts_with('{')
        || outline.around(span.start as usize).any(|around| around.is_macro)
    {
        return Err("the loop is written in a macro".to_owned());
    }
    if is_evaluated_by_compiler(of) {
        return Err(
            "the compiler may run it, in a `const fn` or where a constant is made, and can make no guard: take `const` away, or keep the loop as it is"
                .to_owned(),
        );
    }
    let code = without_comments(of.program.sources.snippet(span));
    if code[1..].trim_start().starts_with("#!") {
        return Err(
            "its block begins with an attribute `#![…]`, which has to stay the first: write `#[…]` above the block"
                .to_owned(),
        );
    }
    Ok(())
}

/// Whether the compiler may run the loop: in a `const fn`, in `const { … }`, or for the length of an array.
fn is_evaluated_by_compiler(of: &LoopBody<'_>) -> bool {
    let is_length = |id: ExprId| {
        let len = of.parent(id).map(|around| of.kind(around));
        matches!(len, Some(ExprKind::Repeat { len, is_vec: false, .. }) if *len == id)
    };
    let is_const = |id: ExprId| matches!(of.kind(id), ExprKind::Block(_)) && of.written(id).starts_with("const");
    of.def().function.is_const || of.ancestors(of.whole).any(|id| is_length(id) || is_const(id))
}

/// Why a function that is called once per cycle cannot have a guard of its own.
pub(super) fn whole_function(of: &LoopBody<'_>) -> Result<(), String> {
    let def = of.def();
    if def.function.is_async {
        return Err("the function is `async`: what waits for it may drop it in the middle of a cycle".to_owned());
    }
    let index = of.program.index;
    let own = match def.owner {
        Owner::Impl(id) => Some(&index.impl_def(id).self_ty),
        _ => None,
    };
    let is_law = own.and_then(|ty| index.law_spec(ty)).is_some_and(|spec| spec.group(&def.name).is_some());
    if is_law {
        return Err(format!(
            "`{}` is the law of a filter itself: implement ceid-core's `SampledFilter` for it, and hand its tick on with `then`",
            def.name
        ));
    }
    Ok(())
}

/// Why the law of a filter that chooses which of its parts it runs gets no guard; nothing where all are left for good reasons.
pub(super) fn plan_of_a_law(of: &LoopBody<'_>, cycle: &Cycle) -> Option<Plan> {
    let text = Some(of).filter(|of| of.is_function).and_then(|of| whole_function(of).err())?;
    let is_chosen = |pair: &&Pair| matches!(pair.verdict, Verdict::Gated | Verdict::OnceOrReset);
    let filters: Vec<String> = cycle.filters.iter().filter(is_chosen).map(|pair| pair.name.clone()).collect();
    (!filters.is_empty()).then(|| Plan {
        head: cycle.head,
        whole: of.span(of.whole).to(cycle.head),
        function: cycle.function.clone(),
        is_helper: false,
        filters,
        missed: Vec::new(),
        outcome: Err(vec![Reason { span: cycle.head, text }]),
        partly: None,
    })
}

/// Why a closure gets no guard.
pub(super) fn of_a_closure(program: &Program<'_>, cycle: &Cycle) -> String {
    let before = &program.sources.file(cycle.head.file).text[..cycle.head.start as usize];
    if before.trim_end().ends_with(".for_each(") {
        return "a guard lives in a loop: write `for … in …` instead of `for_each`".to_owned();
    }
    "the cycle is a closure that other code calls: give its owner a `Cyclic` with the filters, and begin with `cycle()`"
        .to_owned()
}
