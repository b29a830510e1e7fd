//! By what values of a type share state with others.

use std::collections::BTreeSet;

use super::loops::Loops;
use super::purity::reached;
use crate::index::{FunctionId, Index, Owner, TraitName, Ty, TypeId};
use crate::syntax::tree::{ExprId, ExprKind};
use crate::types::Callee;

/// What leads to its value also where others have a reference to it, or a pointer of their own.
const SHARED: [&str; 16] = [
    "Rc",
    "Arc",
    "Weak",
    "Cell",
    "RefCell",
    "UnsafeCell",
    "SyncUnsafeCell",
    "OnceCell",
    "OnceLock",
    "LazyCell",
    "LazyLock",
    "NonNull",
    "Mutex",
    "RwLock",
    "SyncSender",
    "Receiver",
];

/// The types for which a function is written: those of all impls, if it is the default of a trait.
fn owners(index: &Index, function: FunctionId) -> Vec<&Ty> {
    match index.function(function).owner {
        Owner::Impl(id) => vec![&index.impl_def(id).self_ty],
        Owner::Trait(id) => {
            let of = TraitName::Local(id);
            index.impls.iter().filter(|def| def.implements.as_ref() == Some(&of)).map(|def| &def.self_ty).collect()
        }
        Owner::Module => Vec::new(),
    }
}

/// What one of the types shares with others for which these functions are written.
pub(super) fn shared_by_owner(index: &Index, functions: &[FunctionId]) -> Option<String> {
    let mut owners = functions.iter().flat_map(|id| owners(index, *id));
    // Nobody else has what a `&mut` leads to, as long as that is there.
    owners.find_map(|owner| shared_part(index, inner(owner)))
}

/// What one of the types of other crates shares with others for which these functions are written.
pub(super) fn shared_outside(index: &Index, functions: &[FunctionId]) -> Option<String> {
    functions.iter().find_map(|id| {
        let Owner::Impl(id) = index.function(*id).owner else { return None };
        let owner = index.impl_def(id).self_ty.peel();
        matches!(owner, Ty::External(..)).then(|| shared_part(index, owner)).flatten()
    })
}

/// The type behind references and boxes.
pub(super) fn inner(ty: &Ty) -> &Ty {
    match ty.peel() {
        Ty::External(path, args) if path == "std::boxed::Box" => args.first().map_or(ty, inner),
        peeled => peeled,
    }
}

/// Whether values of a type reach what is outside of the program: files, sockets, standard output.
fn is_way_out(path: &str) -> bool {
    let Some((module, name)) = path.rsplit_once("::") else { return false };
    match module {
        "std::fs" => name == "File",
        "std::io" => name.starts_with("Std"),
        "std::process" => name.starts_with("Child") || name == "Command",
        _ => module.starts_with("std::") && ["Stream", "Listener", "Socket"].iter().any(|end| name.ends_with(end)),
    }
}

/// Whether a law may touch what a value shares with others: whether code that it runs does more with what has such a part than name
/// another part of it, or run code that is known.
pub(super) fn touches_shared(loops: &Loops<'_>, law: FunctionId) -> bool {
    let program = loops.program;
    let index = program.index;
    reached(loops, law).into_iter().any(|id| {
        let (Some(body), Some(typed)) = (&index.function(id).function.body, program.typed(id)) else { return true };
        let is_known = |call: u32| matches!(typed.callees.get(&ExprId(call)), Some(Callee::Resolved(_)));
        let asked = (0u32..).zip(&body.exprs).filter_map(|(at, expr)| match &expr.kind {
            ExprKind::Field { base: asked, .. } | ExprKind::Deref(asked) => Some(*asked),
            ExprKind::MethodCall { receiver, .. } if is_known(at) => Some(*receiver),
            _ => None,
        });
        let asked: BTreeSet<ExprId> = asked.collect();
        (0u32..).take(body.exprs.len()).map(ExprId).any(|at| {
            let own = match typed.ty(at) {
                // What a variable refers to is what it leads to: `self`.
                Ty::Ref(_, inner) if typed.expr_local.contains_key(&at) => inner,
                own => own,
            };
            let is_whole = matches!(own, Ty::Adt(..)) && asked.contains(&at);
            !is_whole && shared_part(index, own).is_some()
        })
    })
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
            // What nobody can change is the same whoever else has it.
            if matches!(name, "Rc" | "Arc" | "Weak") && args.iter().all(|arg| index.is_plain(arg)) {
                return None;
            }
            let is_shared =
                SHARED.contains(&name) || name == "Sender" || name.starts_with("Atomic") || is_way_out(path);
            if is_shared { Some(format!("`{name}`")) } else { args.iter().find_map(|arg| shared(index, arg, seen)) }
        }
        Ty::Adt(id, args) => {
            if let Some(part) = args.iter().find_map(|arg| shared(index, arg, seen)) {
                return Some(part);
            }
            if !seen.insert(*id) {
                return None;
            }
            index.field_types(ty).iter().find_map(|field| shared(index, field, seen))
        }
        _ => None,
    }
}
