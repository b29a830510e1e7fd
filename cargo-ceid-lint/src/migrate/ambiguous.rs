//! Calls of a law that stay and would have two meanings, once its type is a filter of ceid-core as well.

use rustc_hash::FxHashMap;

use super::Reason;
use super::body::LoopBody;
use super::loops::Loops;
use super::mentions::Guarded;
use super::text::{without_comments, words};
use crate::flow::Program;
use crate::index::{Def, FunctionId, Index, ModuleId, Namespace, Owner, TraitName, Ty, is_sampled_filter_path};
use crate::source::{FileId, Span};
use crate::syntax::tree::{Body, ExprId, ExprKind, Path};
use crate::types::Callee;

/// The name of the law of ceid-core's trait.
const LAW: &str = "update";

/// A call that finds its law by the name alone.
pub(super) struct CallByName {
    caller: FunctionId,
    call: ExprId,
    span: Span,
}

/// Such calls by their laws, where ceid-core's trait is in scope.
pub(super) type CallsBesideCore = FxHashMap<FunctionId, Vec<CallByName>>;

/// Finds the calls that stand where ceid-core's trait is in scope.
pub(super) fn calls_beside_core(program: &Program<'_>) -> CallsBesideCore {
    let index = program.index;
    let mut scopes: FxHashMap<(ModuleId, FileId), bool> = FxHashMap::default();
    let mut found = CallsBesideCore::default();
    for caller in index.function_ids() {
        let def = index.function(caller);
        let (Some(body), Some(typed)) = (&def.function.body, program.typed(caller)) else { continue };
        for (call, callee) in &typed.callees {
            let span = body.expr(*call).span;
            let Callee::Resolved(resolved) = callee else { continue };
            let is_by_name = matches!(resolved.self_ty, Ty::Adt(..)) && is_by_its_name(body, *call);
            let mut in_scope = || {
                let scope = scopes.entry((def.module, span.file));
                *scope.or_insert_with(|| is_core_in_scope(program, def.module, span.file))
            };
            if is_by_name && in_scope() {
                for target in &resolved.targets {
                    found.entry(*target).or_default().push(CallByName { caller, call: *call, span });
                }
            }
        }
    }
    found.values_mut().for_each(|calls| calls.sort_by_key(|own| own.span));
    found
}

/// The calls of laws that go.
pub(super) fn calls_that_go(guarded: &[Guarded]) -> Vec<ExprId> {
    guarded.iter().flat_map(|own| &own.sites).map(|site| site.call).collect()
}

/// A call of a trait's law that stands where ceid-core's trait is in scope as well, whose law has the same name, and is not among those
/// that go.
pub(super) fn ambiguous(loops: &Loops<'_>, of: &LoopBody<'_>, gone: &[ExprId], law: FunctionId) -> Option<Reason> {
    let index = loops.program.index;
    let def = index.function(law);
    let is_of_trait = matches!(def.owner, Owner::Impl(id) if index.impl_def(id).trait_path.is_some());
    if def.name != LAW || !is_of_trait {
        return None;
    }
    let calls = loops.calls_beside_core().get(&law)?;
    let found = calls.iter().find(|own| own.caller != of.function || !gone.contains(&own.call))?.span;
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

/// Whether a call names the law by its name and the type of its receiver alone.
fn is_by_its_name(body: &Body, call: ExprId) -> bool {
    match &body.expr(call).kind {
        ExprKind::MethodCall { method, .. } => method == LAW,
        ExprKind::Call { callee, .. } => match &body.expr(*callee).kind {
            ExprKind::Path(path) => path.trait_segments == 0 && path.last() == LAW && names_a_type(path),
            _ => false,
        },
        _ => false,
    }
}

fn names_a_type(path: &Path) -> bool {
    path.self_ty.is_some() || matches!(path.segments.as_slice(), [owner, _] if owner.name == "Self")
}

/// Whether ceid-core's trait is in scope in a module.
fn is_core_in_scope(program: &Program<'_>, module: ModuleId, file: FileId) -> bool {
    let index = program.index;
    let named = match index.resolve(module, &["SampledFilter".to_owned()], Namespace::Type) {
        Some(Def::Trait(id)) => index.is_of_core(&TraitName::Local(id)),
        Some(Def::External(path)) => is_sampled_filter_path(&path),
        _ => false,
    };
    let text = &program.sources.file(file).text;
    let is_nameless = |stmt: &str| {
        let import = words(stmt, "use").last().map_or("", |at| &stmt[at..]);
        import.contains("ceid_core") && import.contains("SampledFilter as _")
    };
    named || text.contains("ceid_core") && without_comments(text).split(';').any(is_nameless)
}
