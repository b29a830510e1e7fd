//! A law that a closure would do nothing but call, by its path: `Adapted::new(&mut pid, Pid::update)`.

use super::body::LoopBody;
use super::inputs::Input;
use super::loops::Loops;
use super::sites::Site;
use super::turbofish::turbofish;
use crate::index::{Def, FunctionId, Index, Namespace, Owner, TraitName, Ty};
use crate::syntax::tree::{ExprKind, Receiver};

/// The path of a law that takes its filter by `&mut` and its input as it is fed: as the update has it, or by its type where such
/// paths are asked for.
pub(super) fn path_of_law(loops: &Loops<'_>, of: &LoopBody<'_>, site: &Site, inputs: &[Input]) -> Option<String> {
    let index = of.program.index;
    let is_as_fed = |input: &Input| !input.is_lent() && input.annotation.is_none();
    let takes_filter = |law| index.function(law).function.receiver == Some(Receiver::Exclusive);
    let is_plain = site.tail.is_empty() && inputs.len() < 2 && inputs.iter().all(is_as_fed);
    if !is_plain || site.targets.is_empty() || !site.targets.iter().all(|law| takes_filter(*law)) {
        return None;
    }
    if let ExprKind::Call { callee, .. } = of.kind(site.call) {
        return Some(of.written(*callee).to_owned());
    }
    if !loops.asks_for_paths(of.file()) {
        return None;
    }
    let (name, def) = match &site.filter {
        Ty::Adt(id, _) => (index.type_def(*id).name.clone(), Def::Type(*id)),
        // Where no more is known than the trait, the law has its path.
        Ty::Param(_) | Ty::Opaque(_) => match trait_of(index, &site.targets)? {
            TraitName::Local(id) => (index.trait_def(id).name.clone(), Def::Trait(id)),
            TraitName::External(path) => (path.rsplit("::").next()?.to_owned(), Def::External(path)),
        },
        _ => return None,
    };
    let found = index.resolve(of.def().module, std::slice::from_ref(&name), Namespace::Type);
    (found == Some(def)).then(|| format!("{name}::{}{}", site.method, turbofish(of, site.call)))
}

/// The trait that all of some functions are methods of.
fn trait_of(index: &Index, functions: &[FunctionId]) -> Option<TraitName> {
    let of_function = |function: &FunctionId| match index.function(*function).owner {
        Owner::Trait(id) => Some(TraitName::Local(id)),
        Owner::Impl(id) => index.impl_def(id).implements.clone(),
        Owner::Module => None,
    };
    let (first, others) = functions.split_first()?;
    let found = of_function(first)?;
    others.iter().all(|other| of_function(other).as_ref() == Some(&found)).then_some(found)
}
