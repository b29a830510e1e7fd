//! A law that a closure would do nothing but call, by its path: `Adapted::new(&mut pid, Pid::update)`.

use super::body::LoopBody;
use super::inputs::Input;
use super::loops::Loops;
use super::sites::Site;
use crate::index::{Def, Namespace, Ty};
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
    let Ty::Adt(id, _) = &site.filter else { return None };
    let name = &index.type_def(*id).name;
    let found = index.resolve(of.def().module, std::slice::from_ref(name), Namespace::Type);
    let is_named = found == Some(Def::Type(*id)) && loops.asks_for_paths(of.file());
    is_named.then(|| format!("{name}::{}", site.method))
}
