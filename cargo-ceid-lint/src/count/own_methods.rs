//! What the laws and resets of filters are to those who call them by a trait that makes no filters: which type is meant such a call
//! does not tell, so that the function itself has to say what it does to its receiver.

use super::counts::Count;
use super::given::{Given, GivenBase};
use super::instances::inner;
use super::outcome::Outcome;
use super::returned;
use super::search::not_told;
use super::summary::Summary;
use crate::config::OnErr;
use crate::flow::{ControlFlowGraph, IndexKey, Projection, Steps};
use crate::index::{FilterSpec, FunctionId, Index, MethodOwner, Ty};

/// What a function is to the filter that it is called on.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Own<'a> {
    /// A half of its law.
    Law(&'a FilterSpec, usize),
    /// A reset that an entry names, of all its state or of some.
    Reset(bool),
}

/// Says of a function that is a law or a reset what that means for its receiver.
pub(super) fn add(index: &Index, graph: &ControlFlowGraph, summary: &mut Summary) {
    let id = index.origin(graph.function);
    let def = index.function(id);
    let Some(receiver) = graph.params.first().filter(|_| def.function.receiver.is_some()) else { return };
    let ty = inner(&graph.var(*receiver).ty);
    // A function that a trait provides is one for all types that have no other.
    let is_of = |ty: &Ty| index.methods(ty, &def.name).first().and_then(MethodOwner::function) == Some(id);
    let is_open = matches!(ty, Ty::Param(_) | Ty::Opaque(_)) && index.filter_spec(&ty).is_none();
    let types: Vec<Ty> =
        if is_open { index.types_behind(&ty).iter().filter(|ty| is_of(ty)).cloned().collect() } else { vec![ty] };
    let own: Vec<Option<Own<'_>>> = types.iter().map(|ty| own(index, ty, id)).collect();
    let Some(known) = own.iter().flatten().next() else { return };
    let is_told = own.iter().all(|other| other.as_ref() == Some(known));
    let whole = Given { base: GivenBase::Param(0), steps: Steps::default() };
    let heads = summary.heads;
    let plain = Outcome { returned: heads, unknown: None, ..Outcome::unknown(not_told()) };
    let unknown = || Outcome { returned: heads, ..Outcome::unknown(not_told()) };
    match known {
        Own::Law(spec, half) => {
            summary.alters.retain(|given| !is_told || given.base != whole.base);
            let channel = |key: &u32| Projection::Channel(IndexKey::Param(*key as usize + 1));
            let given = Given { steps: spec.key.iter().map(channel).collect(), ..whole };
            let fails = spec.on_err == OnErr::Untouched && heads & returned::ABSENT != 0;
            let failed = Outcome { returned: heads & returned::ABSENT, attempted: true, ..plain.clone() };
            let passed = if fails { heads & !returned::ABSENT } else { heads };
            let once = Outcome { count: Count::One, returned: passed, ..plain };
            let ways =
                if is_told { [once].into_iter().chain(fails.then_some(failed)).collect() } else { vec![unknown()] };
            // What stands in several parts of the law runs all of them.
            let further = (half + 1..spec.law.len()).filter(|part| spec.law[*part].methods.contains(&def.name));
            for part in std::iter::once(*half).chain(further) {
                if let Some(of_half) = summary.halves.get_mut(part) {
                    of_half.insert(given.clone(), ways.clone());
                }
            }
        }
        Own::Reset(full) => {
            let reset = Outcome { reset: *full, ..plain };
            let way = if is_told { reset } else { unknown() };
            summary.insert(&whole, &[way]);
        }
    }
}

fn own<'a>(index: &'a Index, ty: &Ty, id: FunctionId) -> Option<Own<'a>> {
    if let Some((spec, half)) = index.law_run_by(ty, id) {
        return Some(Own::Law(spec, half));
    }
    // What is known by trait alone is judged by the body.
    let spec = index.receiver_spec(ty).filter(|spec| spec.time_base.is_some())?;
    let name = &index.function(id).name;
    let is_in = |names: &[String]| names.contains(name);
    let full = is_in(&spec.resets);
    (full || is_in(&spec.partial_resets)).then_some(Own::Reset(full))
}
