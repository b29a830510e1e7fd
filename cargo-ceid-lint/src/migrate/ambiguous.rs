//! Calls of a law that stay and would have two meanings, once its type is a filter of ceid-core as well.

use super::Reason;
use super::body::LoopBody;
use super::mentions::Guarded;
use super::text::{without_comments, words};
use crate::index::{Def, FunctionId, Index, ModuleId, Namespace, Owner, TraitName, Ty, is_sampled_filter_path};
use crate::source::FileId;
use crate::syntax::tree::{Body, ExprId, ExprKind, Path};
use crate::types::{Callee, TypedBody};

/// The name of the law of ceid-core's trait.
const LAW: &str = "update";

/// A call of a trait's law that stands where ceid-core's trait is in scope as well, whose law has the same name.
pub(super) fn ambiguous(of: &LoopBody<'_>, guarded: &[Guarded], law: FunctionId) -> Option<Reason> {
    let index = of.program.index;
    let def = index.function(law);
    let is_of_trait = matches!(def.owner, Owner::Impl(id) if index.impl_def(id).trait_path.is_some());
    if def.name != LAW || !is_of_trait {
        return None;
    }
    let is_gone = |id: ExprId| guarded.iter().flat_map(|own| &own.sites).any(|site| site.call == id);
    let found = index.function_ids().find_map(|caller| {
        let (body, typed) = (index.function(caller).function.body.as_ref()?, of.program.typed(caller)?);
        let mut calls = typed.callees.keys().copied().filter(|id| is_by_its_name(body, typed, *id, law));
        let call = calls.find(|id| caller != of.function || !is_gone(*id))?;
        is_core_in_scope(of, index.function(caller).module, body.expr(call).span.file).then(|| body.expr(call).span)
    })?;
    let text = format!(
        "`{LAW}` of `{}` is called here, where ceid-core's `SampledFilter` is in scope as well and would be meant as well as its own: \
         import the names of ceid-core one by one, or name the trait in the call",
        index.type_name(index_owner(index, law))
    );
    Some(Reason { span: found, text })
}

fn index_owner(index: &Index, law: FunctionId) -> &Ty {
    match index.function(law).owner {
        Owner::Impl(id) => &index.impl_def(id).self_ty,
        _ => &Ty::Unknown,
    }
}

/// Whether a call finds the law by its name and the type of its receiver alone.
fn is_by_its_name(body: &Body, typed: &TypedBody, call: ExprId, law: FunctionId) -> bool {
    let is_call = match &body.expr(call).kind {
        ExprKind::MethodCall { method, .. } => method == LAW,
        ExprKind::Call { callee, .. } => match &body.expr(*callee).kind {
            ExprKind::Path(path) => path.trait_segments == 0 && path.last() == LAW && names_a_type(path),
            _ => false,
        },
        _ => false,
    };
    let is_it = |callee: &Callee| match callee {
        Callee::Resolved(resolved) => resolved.targets.contains(&law) && matches!(resolved.self_ty, Ty::Adt(..)),
        _ => false,
    };
    is_call && typed.callees.get(&call).is_some_and(is_it)
}

fn names_a_type(path: &Path) -> bool {
    path.self_ty.is_some() || matches!(path.segments.as_slice(), [owner, _] if owner.name == "Self")
}

/// Whether ceid-core's trait is in scope in a module.
fn is_core_in_scope(of: &LoopBody<'_>, module: ModuleId, file: FileId) -> bool {
    let index = of.program.index;
    let named = match index.resolve(module, &["SampledFilter".to_owned()], Namespace::Type) {
        Some(Def::Trait(id)) => index.is_of_core(&TraitName::Local(id)),
        Some(Def::External(path)) => is_sampled_filter_path(&path),
        _ => false,
    };
    let text = &of.program.sources.file(file).text;
    let is_nameless = |stmt: &str| {
        let import = words(stmt, "use").last().map_or("", |at| &stmt[at..]);
        import.contains("ceid_core") && import.contains("SampledFilter as _")
    };
    named || text.contains("ceid_core") && without_comments(text).split(';').any(is_nameless)
}
