//! Whether it matters when a law runs: one that touches nothing but its own filter may run at the end of the cycle as well.

use std::collections::BTreeSet;

use super::loops::Loops;
use super::owned::is_dropped_in_silence;
use super::shared::{inner, shared_by_owner, shared_outside};
use super::unread::{calls_unread, is_address, reaches_memory};
use crate::flow::Program;
use crate::index::{Def, FunctionId, Index, Owner, TraitName, TraitRef, Ty, TypeId, ValueDef};
use crate::syntax::tree::{Body, ExprId, ExprKind, MacroKind};
use crate::types::{Callee, Resolved, TypedBody};

/// What a law does beside advancing its filter, as far as it is known; a function whose code is not read does nothing else.
pub(super) fn side_effect(loops: &Loops<'_>, law: FunctionId) -> Option<String> {
    effect_on_the_way(loops, law, &mut BTreeSet::new())
}

/// The functions that a law may run, itself included, if it does nothing beside advancing its filter.
pub(super) fn reached(loops: &Loops<'_>, law: FunctionId) -> BTreeSet<FunctionId> {
    let mut seen = BTreeSet::new();
    effect_on_the_way(loops, law, &mut seen);
    seen
}

fn effect_on_the_way(loops: &Loops<'_>, law: FunctionId, seen: &mut BTreeSet<FunctionId>) -> Option<String> {
    let program = loops.program;
    let mut dropped = BTreeSet::new();
    let mut open = vec![law];
    while let Some(id) = open.pop() {
        if !seen.insert(id) {
            continue;
        }
        let (Some(body), Some(typed)) = (&program.index.function(id).function.body, program.typed(id)) else {
            continue;
        };
        for (call, callee) in &typed.callees {
            match callee {
                Callee::Resolved(resolved) if is_unseen(program, body, typed, *call, resolved) => {
                    return Some(format!("calls {}, whose code is not known here", called(program, body, *call)));
                }
                Callee::Resolved(resolved) => {
                    if let Some(part) = shared_outside(program.index, &resolved.targets) {
                        return Some(format!("calls {}, which may be that of {part}", called(program, body, *call)));
                    }
                    // Of a parameter, which type it is only its caller knows.
                    if (is_of_a_value(body, typed, *call) || is_open(&resolved.self_ty))
                        && let Some(part) = shared_by_owner(program.index, &resolved.targets)
                    {
                        let text = "which may be that of a type that shares";
                        return Some(format!("calls {}, {text} {part} with others", called(program, body, *call)));
                    }
                    // The impls that are known need not be all.
                    if is_open(&resolved.self_ty) && lends_open(body, typed, *call) {
                        return Some(format!("calls {}, whose code is not known here", called(program, body, *call)));
                    }
                    open.extend(&resolved.targets);
                }
                Callee::External(path) if is_outside_world(path) => return Some(format!("calls `{path}`")),
                _ if reaches_memory(body, typed, *call) => {
                    let called = called(program, body, *call);
                    return Some(format!("calls {called}, which reaches memory that others may have"));
                }
                _ if calls_unread(body, typed, *call, callee) => {
                    return Some(format!("calls {}, whose code is not known here", called(program, body, *call)));
                }
                Callee::Parameter(_) if id != law => {}
                Callee::Parameter(_) | Callee::Unknown | Callee::Builtin if is_of_a_value(body, typed, *call) => {
                    return Some(format!("calls {}, whose code is not known here", called(program, body, *call)));
                }
                _ if reads_clock(body, typed, *call) => return Some("reads a clock".to_owned()),
                _ => {}
            }
        }
        if let Some(part) = loops.shared_by_parameters(id) {
            return Some(format!("calculates with what may be of a type that shares {part} with others"));
        }
        open.extend(loops.implicit(id).iter());
        // What a law has by value, it may drop.
        open.extend(typed.expr_ty.iter().flat_map(|ty| destructors(program.index, ty, &mut dropped)));
        for expr in &body.exprs {
            match &expr.kind {
                ExprKind::Macro(call) if is_output(&call.path, &call.kind) => {
                    return Some(format!("prints with `{}!`", call.path));
                }
                ExprKind::Macro(call) if writes_out(typed, &call.path, &call.kind) => {
                    return Some(format!("writes with `{}!`", call.path));
                }
                ExprKind::Deref(pointer) if is_address(body, typed, *pointer) => {
                    return Some("reaches memory that others may have".to_owned());
                }
                ExprKind::Opaque(call) => return Some(format!("calls the macro `{}!`, which is not read", call.path)),
                ExprKind::Unknown { what, .. } => return Some(format!("has {what}")),
                _ => {}
            }
        }
        let value = |id: u32| match typed.expr_def.get(&ExprId(id)) {
            Some(Def::Value(id)) => Some(program.index.value(*id)),
            _ => None,
        };
        let mut values = (0u32..).take(body.exprs.len()).filter_map(value);
        let is_table = |value: &ValueDef| {
            let scope = program.index.scope(value.module, value.owner, None);
            !value.item.is_mutable && program.index.is_plain(&program.index.lower(&value.item.ty, &scope))
        };
        if let Some(own) = values.find(|value| value.item.is_static && !is_table(value)) {
            return Some(format!("uses the static `{}`", own.name));
        }
    }
    None
}

/// What is called, as the source spells it.
fn called(program: &Program<'_>, body: &Body, call: ExprId) -> String {
    let spelled = match &body.expr(call).kind {
        ExprKind::Call { callee, .. } => program.sources.snippet(body.expr(*callee).span),
        ExprKind::MethodCall { method, .. } => method,
        _ => "",
    };
    format!("`{spelled}`")
}

/// Whether a function runs that the analysed code only declares: a foreign one, or a method of a parameter or an object.
fn is_unseen(program: &Program<'_>, body: &Body, typed: &TypedBody, call: ExprId, resolved: &Resolved) -> bool {
    let has_code = |target: &FunctionId| program.index.function(*target).function.body.is_some();
    let is_foreign = |target: &FunctionId| program.index.function(*target).owner == Owner::Module;
    resolved.law.is_none()
        && !resolved.targets.iter().any(has_code)
        && (resolved.targets.iter().any(is_foreign) || is_of_a_value(body, typed, call) || is_open(&resolved.self_ty))
}

/// Whether a function is lent what only the type that it belongs to knows: `S::read(&self.port)`.
fn lends_open(body: &Body, typed: &TypedBody, call: ExprId) -> bool {
    let ExprKind::Call { args, .. } = &body.expr(call).kind else { return false };
    args.iter().any(|arg| matches!(typed.ty(*arg).peel(), Ty::Param(_) | Ty::Opaque(_)))
}

/// What runs where values of a type are dropped.
pub(super) fn destructors(index: &Index, ty: &Ty, seen: &mut BTreeSet<TypeId>) -> Vec<FunctionId> {
    let mut of_parts = |parts: &[Ty]| parts.iter().flat_map(|part| destructors(index, part, seen)).collect::<Vec<_>>();
    match ty {
        Ty::Tuple(parts) | Ty::External(_, parts) => of_parts(parts),
        Ty::Array(inner, _) => of_parts(std::slice::from_ref(inner)),
        Ty::Adt(id, args) => {
            let mut found = of_parts(args);
            if seen.insert(*id) {
                let drop = TraitName::External("std::ops::Drop".to_owned());
                let impls = index.impls_of(ty).into_iter().map(|id| index.impl_def(id));
                let own = impls.filter(|def| def.implements.as_ref() == Some(&drop));
                found.extend(own.filter_map(|def| def.methods.get("drop").copied()));
                found.extend(index.field_types(ty).iter().flat_map(|field| destructors(index, field, seen)));
            }
            found
        }
        _ => Vec::new(),
    }
}

/// Whether something happens, or may happen, where a value of a type is dropped, beside giving its memory back.
pub(super) fn acts_when_dropped(index: &Index, ty: &Ty) -> bool {
    let any = |parts: &[Ty]| parts.iter().any(|part| acts_when_dropped(index, part));
    match ty {
        Ty::Adt(..) => !destructors(index, ty, &mut BTreeSet::new()).is_empty(),
        Ty::Tuple(parts) => any(parts),
        Ty::Array(inner, _) => acts_when_dropped(index, inner),
        Ty::External(path, args) => !is_dropped_in_silence(path) || any(args),
        Ty::Param(_) | Ty::Opaque(_) => !index.is_copy(ty),
        _ => false,
    }
}

/// Whether a call runs what a value has brought with it: a field or variable that is called, a method of an unknown type.
fn is_of_a_value(body: &Body, typed: &TypedBody, call: ExprId) -> bool {
    match &body.expr(call).kind {
        ExprKind::Call { callee, .. } => match body.expr(*callee).kind {
            ExprKind::Path(_) => typed.expr_local.contains_key(callee),
            _ => true,
        },
        ExprKind::MethodCall { receiver, .. } => is_open(typed.ty(*receiver)),
        _ => false,
    }
}

/// Whether methods of a value may be any code: those of a parameter or an object, and of readers and iterators over such.
pub(super) fn is_open(ty: &Ty) -> bool {
    match inner(ty) {
        Ty::Param(param) => !param.bounds.iter().all(is_pure),
        Ty::Opaque(bounds) => !bounds.iter().all(is_pure),
        Ty::External(path, args) => {
            let asks_its_parts = path.starts_with("std::io::") || path.starts_with("std::iter::");
            asks_its_parts && args.iter().any(is_open)
        }
        _ => false,
    }
}

/// Whether the methods of a trait only calculate.
fn is_pure(bound: &TraitRef) -> bool {
    let TraitName::External(path) = &bound.name else { return false };
    let std = ["clone", "cmp", "convert", "default", "fmt", "hash", "marker", "ops"];
    let mut parts = path.split("::");
    match parts.next() {
        Some("std" | "core") => parts.next().is_some_and(|module| std.contains(&module)) && !path.contains("::Fn"),
        Some("num" | "num_traits" | "nalgebra" | "simba" | "num_complex" | "fixed" | "ordered_float" | "uom") => true,
        _ => false,
    }
}

fn reads_clock(body: &Body, typed: &TypedBody, call: ExprId) -> bool {
    let is_time = |ty: &Ty| matches!(ty.peel(), Ty::External(path, _) if path == "std::time::Instant" || path == "std::time::SystemTime");
    matches!(&body.expr(call).kind, ExprKind::MethodCall { receiver, method, .. } if method == "elapsed" && is_time(typed.ty(*receiver)))
}

fn is_output(path: &str, kind: &MacroKind) -> bool {
    let name = path.rsplit("::").next().unwrap_or(path);
    matches!(kind, MacroKind::Logging(_)) || matches!(name, "println" | "print" | "eprintln" | "eprint" | "dbg")
}

/// Whether a macro writes into something else than a text or bytes in memory: `writeln!(self.port, "{y}")`.
fn writes_out(typed: &TypedBody, path: &str, kind: &MacroKind) -> bool {
    let MacroKind::All(operands) = kind else { return false };
    let into = operands.first().filter(|_| matches!(path.rsplit("::").next(), Some("write" | "writeln")));
    into.is_some_and(|into| match inner(typed.ty(*into)) {
        Ty::External(path, _) => !matches!(path.rsplit("::").next(), Some("String" | "Vec" | "Formatter")),
        // What code of the program does with it is read as code.
        ty => !matches!(ty, Ty::Adt(..)),
    })
}

fn is_outside_world(path: &str) -> bool {
    let worlds =
        ["std::time::", "std::thread::", "std::fs::", "std::net::", "std::io::", "std::process::", "std::env::"];
    let is_clock = path.ends_with("::now");
    is_clock
        || path.contains("rand::")
        || worlds.iter().any(|world| path.starts_with(world) && !path.contains("Duration"))
}
