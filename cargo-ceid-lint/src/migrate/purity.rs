//! Whether it matters when a law runs: one that touches nothing but its own filter may run at the end of the cycle as well.

use std::collections::BTreeSet;

use crate::flow::Program;
use crate::index::{Def, FunctionId, Index, Shape, Ty, TypeId};
use crate::syntax::tree::{ExprKind, MacroKind};
use crate::types::Callee;

/// What a law does beside advancing its filter, as far as it is known; a function whose code is not read does nothing else.
pub(super) fn side_effect(program: &Program<'_>, law: FunctionId) -> Option<String> {
    let mut seen = BTreeSet::new();
    let mut open = vec![law];
    while let Some(id) = open.pop() {
        if !seen.insert(id) {
            continue;
        }
        let (Some(body), Some(typed)) = (&program.index.function(id).function.body, program.typed(id)) else {
            continue;
        };
        for callee in typed.callees.values() {
            match callee {
                Callee::Resolved(resolved) => open.extend(&resolved.targets),
                Callee::External(path) if is_outside_world(path) => return Some(format!("calls `{path}`")),
                _ => {}
            }
        }
        for expr in &body.exprs {
            match &expr.kind {
                ExprKind::Macro(call) if is_output(&call.path, &call.kind) => {
                    return Some(format!("prints with `{}!`", call.path));
                }
                ExprKind::Opaque(call) => return Some(format!("calls the macro `{}!`, which is not read", call.path)),
                ExprKind::Unknown { what, .. } => return Some(format!("has {what}")),
                _ => {}
            }
        }
        let is_static = |def: &&Def| matches!(def, Def::Value(id) if program.index.value(*id).item.is_static);
        if let Some(Def::Value(id)) = typed.expr_def.values().find(is_static) {
            return Some(format!("uses the static `{}`", program.index.value(*id).name));
        }
    }
    None
}

fn is_output(path: &str, kind: &MacroKind) -> bool {
    let name = path.rsplit("::").next().unwrap_or(path);
    matches!(kind, MacroKind::Logging(_)) || matches!(name, "println" | "print" | "eprintln" | "eprint" | "dbg")
}

fn is_outside_world(path: &str) -> bool {
    let worlds =
        ["std::time::", "std::thread::", "std::fs::", "std::net::", "std::io::", "std::process::", "std::env::"];
    let is_clock = path.ends_with("::now");
    is_clock
        || path.contains("rand::")
        || worlds.iter().any(|world| path.starts_with(world) && !path.contains("Duration"))
}

/// The first part of a type by which its values share state with others.
pub(super) fn shared_part(index: &Index, ty: &Ty) -> Option<String> {
    shared(index, ty, &mut BTreeSet::new())
}

fn shared(index: &Index, ty: &Ty, seen: &mut BTreeSet<TypeId>) -> Option<String> {
    match ty {
        Ty::Ref(true, _) => Some("a `&mut` reference".to_owned()),
        Ty::Ref(false, inner) | Ty::Array(inner, _) | Ty::Slice(inner) => shared(index, inner, seen),
        Ty::Pointer(_) => Some("a raw pointer".to_owned()),
        Ty::Tuple(parts) => parts.iter().find_map(|part| shared(index, part, seen)),
        Ty::External(path, args) => {
            let name = path.rsplit("::").next().unwrap_or(path);
            let is_shared = matches!(
                name,
                "Rc" | "Arc"
                    | "Cell"
                    | "RefCell"
                    | "Mutex"
                    | "RwLock"
                    | "OnceCell"
                    | "Sender"
                    | "SyncSender"
                    | "Receiver"
            ) || name.starts_with("Atomic");
            if is_shared { Some(format!("`{name}`")) } else { args.iter().find_map(|arg| shared(index, arg, seen)) }
        }
        Ty::Adt(id, _) => {
            if !seen.insert(*id) {
                return None;
            }
            fields(index, ty).iter().find_map(|field| shared(index, field, seen))
        }
        _ => None,
    }
}

/// The types of the fields of a type of the analysed code, of all its variants.
pub(super) fn fields(index: &Index, ty: &Ty) -> Vec<Ty> {
    let Ty::Adt(id, _) = ty else { return Vec::new() };
    let def = index.type_def(*id);
    let scope = index.scope(def.module, crate::index::Owner::Module, Some(&def.generics));
    let fields = match &def.shape {
        Shape::Struct(fields) => fields.fields.iter().collect::<Vec<_>>(),
        Shape::Enum(variants) => variants.iter().flat_map(|variant| &variant.fields.fields).collect(),
    };
    fields.iter().map(|field| index.lower(&field.ty, &scope)).collect()
}
