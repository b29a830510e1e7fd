//! Laws that no guard can run, whatever they belong to.

use super::body::LoopBody;
use super::text::words;
use super::turbofish::says_types;
use crate::index::{FunctionId, Owner, Ty};
use crate::syntax::tree::{ExprId, ExprKind};
use crate::types::Resolved;

/// Why a guard cannot run the law that is called there.
pub(super) fn unfit(of: &LoopBody<'_>, call: ExprId, callee: &Resolved, name: &str) -> Option<String> {
    let index = of.program.index;
    let is_any = |is_such: &dyn Fn(FunctionId) -> bool| callee.targets.iter().any(|target| is_such(*target));
    if is_any(&|law| is_unsafe(of, law)) {
        return Some(format!(
            "the law of `{name}` is `unsafe`, and a guard runs safe ones: make it safe, with an `unsafe` block inside that says why \
             it may"
        ));
    }
    if is_any(&|law| index.function(law).function.is_async) {
        return Some(format!(
            "the law of `{name}` is `async`, and a guard runs laws that are not: put what it waits for into the loop, and let the law take \
             that as an input"
        ));
    }
    if !says_types(of, call) && is_any(&|law| is_chosen_by_caller(of, law)) {
        return Some(format!(
            "the type of what the law of `{name}` gives back is chosen by its caller, and a guard chooses none: let the law give back one \
             type"
        ));
    }
    let is_method = matches!(of.kind(call), ExprKind::MethodCall { .. });
    if is_method && is_any(&|law| has_twins(of, &callee.self_ty, law)) {
        return Some(format!(
            "`{name}` has several laws by that name, and the call chooses by what it gives back: call it by its path, as in \
             `<… as …<…>>::update(&mut {name})`"
        ));
    }
    None
}

/// Whether a function is `unsafe`, by the words before its keyword.
fn is_unsafe(of: &LoopBody<'_>, function: FunctionId) -> bool {
    let keyword = of.program.index.function(function).function.keyword;
    let before = &of.program.sources.file(keyword.file).text[..keyword.start as usize];
    let is_qualifier = |word: &&str| matches!(*word, "unsafe" | "extern") || word.starts_with('"');
    before.split_whitespace().rev().take_while(is_qualifier).any(|word| word == "unsafe")
}

/// Whether nothing but the call tells the type of what a function gives back.
fn is_chosen_by_caller(of: &LoopBody<'_>, law: FunctionId) -> bool {
    let index = of.program.index;
    let function = &index.function(law).function;
    let scope = index.scope_of(law);
    let own = |name: &str| function.generics.params.iter().any(|param| param.name == name && !param.is_const);
    // The length of an array has its name in the types alone.
    let head = of.program.sources.snippet(function.head);
    let (before, output) = head.rsplit_once("->").unwrap_or((head, ""));
    let is_in_output = |name: &str| words(output, name).next().is_some() && words(before, name).nth(1).is_none();
    if function.generics.params.iter().any(|param| param.is_const && is_in_output(&param.name)) {
        return true;
    }
    let has_own = |ty: &Ty| ty.has_part(&mut |part| matches!(part, Ty::Param(param) if own(&param.name)));
    has_own(&index.lower(&function.output, &scope))
        && !function.params.iter().any(|param| has_own(&index.lower(param, &scope)))
}

/// Whether a type has the trait of a law several times, each time with other parameters.
fn has_twins(of: &LoopBody<'_>, filter: &Ty, law: FunctionId) -> bool {
    let index = of.program.index;
    let Owner::Impl(own) = index.function(law).owner else { return false };
    let Some(of_trait) = &index.impl_def(own).implements else { return false };
    let is_twin = |id| id != own && index.impl_def(id).implements.as_ref() == Some(of_trait);
    index.impls_of(filter).into_iter().any(|id| is_twin(id) && index.impl_def(id).self_ty.may_be(filter))
}
