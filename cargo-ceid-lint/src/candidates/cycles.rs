//! Functions that look like control cycles: they run laws, and something that was not read calls them.

use std::collections::{BTreeMap, BTreeSet};

use super::laws::Finder;
use super::uses::{is_test, loops, takes_state};
use super::words::is_cycle_attribute;
use super::{CycleCandidate, CycleReason, CycleTarget};
use crate::count::is_cycle_function;
use crate::index::{FunctionId, Namespace, Owner, TraitName, Ty};
use crate::types::Callee;

/// How deep helpers are followed.
const MOST_HELPERS: u32 = 4;

/// Finds functions that look like cycles and are none yet.
pub(super) fn find(finder: &Finder<'_>, laws: &BTreeMap<FunctionId, String>) -> Vec<CycleCandidate> {
    let index = finder.program.index;
    let mut by_target: BTreeMap<CycleTarget, CycleCandidate> = BTreeMap::new();
    let mut seen = BTreeSet::new();
    for id in index.function_ids() {
        let def = index.function(id);
        if is_test(index, def)
            || !finder.is_in_scope(def.module)
            || def.function.body.is_none()
            || def.function.is_async
            || def.name == "main"
            || laws.contains_key(&id)
            || is_cycle_function(index, id)
            || !seen.insert(def.function.keyword)
        {
            continue;
        }
        let Some(reason) = reason(finder, id) else { continue };
        let run = laws_run(finder, laws, id, 0, &mut BTreeSet::new());
        if run == 0 {
            continue;
        }
        let Some(target) = target(finder, id, reason) else { continue };
        let place = def.function.keyword;
        let candidate =
            by_target.entry(target.clone()).or_insert(CycleCandidate { target, place, functions: 0, laws: 0, reason });
        candidate.functions += 1;
        candidate.laws += run;
    }
    let mut found: Vec<CycleCandidate> = by_target.into_values().collect();
    found.sort_by(|left, right| {
        let key = |one: &CycleCandidate| (one.reason, std::cmp::Reverse(one.laws));
        key(left).cmp(&key(right)).then_with(|| left.target.cmp(&right.target))
    });
    found
}

/// What says that the function is called once per cycle.
fn reason(finder: &Finder<'_>, id: FunctionId) -> Option<CycleReason> {
    let index = finder.program.index;
    let def = index.function(id);
    if def.attributes.iter().any(|attribute| is_cycle_attribute(&attribute.path)) {
        return Some(CycleReason::Attribute);
    }
    let is_exported = |path: &str, arguments: &str| {
        path == "no_mangle" || path == "export_name" || (path == "unsafe" && arguments.contains("no_mangle"))
    };
    if def.attributes.iter().any(|attribute| is_exported(&attribute.path, &attribute.arguments)) && def.name != "main" {
        return Some(CycleReason::Exported);
    }
    if finder.calls.handed_over.contains(&id) {
        return Some(CycleReason::HandedOver);
    }
    if finder.calls.is_called(id) || !takes_state(def) || is_set_up(&def.name) {
        return None;
    }
    if let Owner::Impl(owner) = def.owner {
        let of = index.impl_def(owner);
        let is_std = matches!(&of.implements, Some(TraitName::External(path)) if path.starts_with("std::"));
        if of.trait_path.is_some() {
            return (!is_std).then_some(CycleReason::Framework);
        }
    }
    Some(CycleReason::NotCalled)
}

fn is_set_up(name: &str) -> bool {
    super::words::is_other_verb(name) && !name.starts_with("on_") && !name.starts_with("handle")
}

/// The entry that names the function.
fn target(finder: &Finder<'_>, id: FunctionId, reason: CycleReason) -> Option<CycleTarget> {
    let index = finder.program.index;
    let def = index.function(id);
    if reason == CycleReason::Attribute {
        let attribute = def.attributes.iter().find(|attribute| is_cycle_attribute(&attribute.path))?;
        return Some(CycleTarget::Attribute(attribute.path.clone()));
    }
    let keyword = def.function.keyword;
    match def.owner {
        Owner::Module => finder.path_to(def.module, &def.name, keyword, Namespace::Value).map(CycleTarget::Function),
        Owner::Impl(owner) => {
            let of = index.impl_def(owner);
            if reason == CycleReason::Framework {
                let path = match of.implements.as_ref()? {
                    TraitName::External(path) => Some(path.clone()),
                    TraitName::Local(id) => {
                        let of = index.trait_def(*id);
                        finder.path_to(of.module, &of.name, of.span, Namespace::Type)
                    }
                };
                return path
                    .filter(|path| path.contains("::"))
                    .map(|path| CycleTarget::Method(format!("{path}::{}", def.name)));
            }
            let Ty::Adt(ty, _) = &of.self_ty else { return None };
            let ty = index.type_def(*ty);
            let path = finder.path_to(ty.module, &ty.name, ty.span, Namespace::Type)?;
            Some(CycleTarget::Function(format!("{path}::{}", def.name)))
        }
        Owner::Trait(_) => None,
    }
}

/// How many laws a function runs outside its own loops, in itself and in what it calls.
fn laws_run(
    finder: &Finder<'_>,
    laws: &BTreeMap<FunctionId, String>,
    id: FunctionId,
    depth: u32,
    open: &mut BTreeSet<FunctionId>,
) -> usize {
    let index = finder.program.index;
    let def = index.function(id);
    let (Some(body), Some(typed)) = (&def.function.body, finder.program.typed(id)) else { return 0 };
    if depth > MOST_HELPERS || !open.insert(id) {
        return 0;
    }
    let loops = loops(body);
    let mut run = 0;
    for (at, callee) in &typed.callees {
        let Callee::Resolved(resolved) = callee else { continue };
        if depth == 0 && loops.iter().any(|own| own.contains(body.expr(*at).span)) {
            continue;
        }
        if resolved.law.is_some() || resolved.targets.iter().any(|target| laws.contains_key(target)) {
            run += 1;
        } else if let [target] = resolved.targets.as_slice() {
            run += laws_run(finder, laws, *target, depth + 1, open);
        }
    }
    run
}
