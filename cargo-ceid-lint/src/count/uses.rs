//! What a function does with an instance that it never updates.

use super::analyse::{Context, FunctionFacts};
use super::instances;
use crate::flow::{Assignment, CallSite, ControlFlowGraph, Effect, Place, Transfer};
use crate::index::{FunctionId, Index};
use crate::syntax::tree::{Receiver, TypeRef};

/// What a function does with an instance.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Uses {
    /// It is moved, returned or handed to something unseen.
    pub(super) leaves: bool,
    /// Copies are made of it.
    pub(super) copied: bool,
    /// It is reset, or its state is written.
    pub(super) written: bool,
    /// It is handed to a method that may change it.
    pub(super) fed: bool,
    /// It is read.
    pub(super) read: bool,
    /// A part of it is read, or a method of its own.
    pub(super) looked_into: bool,
    /// It is given the state that another one has: it shows what that one was.
    pub(super) is_snapshot: bool,
}

impl Context<'_> {
    /// What the function does with an instance that it never updates.
    pub(super) fn uses(&self, facts: &FunctionFacts<'_>, place: &Place) -> Uses {
        let index = self.program.index;
        let mut uses = Uses::default();
        let mut is_assigned = false;
        let mut is_emptied = false;
        let is_lent = instances::is_lent(self.program.index, facts.graph, place);
        let holds = |other: &Place| facts.aliases.shared_roots(other).iter().any(|root| root.overlaps(place));
        // What a filter computed may leave without it: `return kf.value();`
        let gives_filter = {
            let (index, function) = (self.program.index, facts.graph.function);
            let output = &index.function(function).function.output;
            instances::may_hold_filter(index, &index.lower(output, &index.scope_of(function)))
        };
        for node in &facts.graph.nodes {
            match &node.effect {
                Effect::Unknown { places, .. } => uses.leaves |= places.iter().any(&holds),
                Effect::Reset { place, .. } => uses.written |= holds(place),
                Effect::Write(write) => {
                    uses.written |= holds(&write.place);
                    let from = write.from.as_ref().filter(|from| !is_plain(index, facts.graph, from));
                    let leaves = from.is_some_and(&holds) && write.transfer != Transfer::Borrow;
                    uses.leaves |= leaves && write.transfer != Transfer::Copy;
                    uses.copied |= leaves;
                    is_assigned |= leaves;
                    is_emptied |= write.head.as_deref() == Some("-") && holds(&write.place);
                    uses.is_snapshot |= write.place == *place && self.is_copy(facts, write);
                }
                Effect::Set(set) => {
                    let leaves = set.transfer != Transfer::Borrow
                        && !is_lent
                        && set.from.as_ref().filter(|from| !is_plain(index, facts.graph, from)).is_some_and(|from| {
                            facts.aliases.shared_roots(from).iter().any(|root| {
                                root.base == place.base && root.steps.len() <= place.steps.len() && root.overlaps(place)
                            })
                        })
                        && set.place.base != place.base
                        && self.is_real_move(facts, &set.place);
                    uses.leaves |= leaves && set.transfer != Transfer::Copy;
                    uses.copied |= leaves;
                }
                Effect::Return(value) => {
                    let given = value.place.as_ref().map(|place| originals(facts.graph, place));
                    uses.leaves |= gives_filter && given.iter().flatten().any(&holds);
                }
                Effect::Use { place: used } => {
                    uses.read |= holds(used);
                    let is_part = |root: &Place| root.overlaps(place) && root.steps.len() > place.steps.len();
                    uses.looked_into |= facts.aliases.shared_roots(used).iter().any(is_part);
                }
                Effect::Call(site) => {
                    for (number, arg) in site.args.iter().enumerate() {
                        // A copy goes on in what is made of it.
                        let makes = || {
                            let made = &facts.graph.var(site.result).ty;
                            arg.is_copy && instances::may_hold_filter(self.program.index, made)
                        };
                        uses.leaves |= arg.value_of.as_ref().is_some_and(&holds) && makes();
                        let Some(own) = &arg.place else { continue };
                        if !holds(own) {
                            continue;
                        }
                        let keeps = |target: &FunctionId| {
                            self.summaries.get(*target).is_some_and(|callee| callee.keeps.contains(&number))
                        };
                        if (!is_lent && self.takes_by_value(site, number)) || site.targets.iter().any(keeps) {
                            uses.leaves = true;
                        } else if arg.is_shared || self.reads_only(site, number) {
                            uses.read = true;
                            uses.looked_into |= !self.is_clone(site);
                        } else {
                            uses.fed = true;
                        }
                    }
                }
                _ => {}
            }
        }
        uses.fed |= facts.graph.lent.iter().any(&holds);
        // A copy that leaves nothing behind is a move.
        uses.leaves |= uses.copied && is_emptied;
        // A template lives on in its clones, and in what its state is assigned to.
        let is_template = !uses.looked_into && !uses.fed;
        uses.leaves |= is_template && (is_assigned || facts.graph.cloned.iter().any(holds));
        uses
    }

    /// Whether what is assigned is a copy of what has a name.
    fn is_copy(&self, facts: &FunctionFacts<'_>, write: &Assignment) -> bool {
        let copies = |set: &Assignment| matches!(set.transfer, Transfer::Copy | Transfer::RoundTrip);
        let is_made = |from: &Place| {
            facts.graph.nodes.iter().any(
                |node| matches!(&node.effect, Effect::Set(set) if set.place == *from && copies(set) && set.from.is_some()),
            )
        };
        write.from.as_ref().is_some_and(|from| copies(write) || is_made(from))
    }

    fn is_clone(&self, site: &CallSite) -> bool {
        site.targets.iter().all(|target| self.program.index.function(*target).name == "clone")
    }

    /// Whether a variable that something is moved into has a name, or is a part of a new value. What is put into `_old` is
    /// dropped there.
    fn is_real_move(&self, facts: &FunctionFacts<'_>, place: &Place) -> bool {
        let is_name = |name: &str| !name.is_empty() && !name.starts_with('_');
        place.base_var().is_none_or(|var| is_name(&facts.graph.var(var).name) || !place.steps.is_empty())
    }

    /// Whether every target of a call takes an argument by value.
    fn takes_by_value(&self, site: &CallSite, number: usize) -> bool {
        site.targets.iter().any(|target| {
            let function = &self.program.index.function(*target).function;
            match (&function.receiver, number) {
                (Some(Receiver::Value), 0) => true,
                (Some(_), 0) => false,
                (receiver, number) => {
                    let at = number - usize::from(receiver.is_some());
                    function.params.get(at).is_some_and(|ty| !matches!(ty, TypeRef::Reference { .. }))
                }
            }
        })
    }

    fn reads_only(&self, site: &CallSite, number: usize) -> bool {
        number == 0
            && site
                .targets
                .iter()
                .all(|target| self.program.index.function(*target).function.receiver == Some(Receiver::Shared))
    }
}

/// Whether a place holds a plain value of a `Copy` type: whoever takes that leaves the filter that it lies in where it is.
pub(super) fn is_plain(index: &Index, graph: &ControlFlowGraph, place: &Place) -> bool {
    instances::place_ty(index, graph, place)
        .is_some_and(|ty| index.is_copy(&ty) && !instances::may_hold_filter(index, &ty))
}

/// A place, and those whose values are copied into it on the way to where a function gives it back.
fn originals(graph: &ControlFlowGraph, place: &Place) -> Vec<Place> {
    let mut found = vec![place.clone()];
    let mut seen = 0;
    while let Some(base) = found.get(seen).map(|place| place.base) {
        seen += 1;
        for node in &graph.nodes {
            let Effect::Set(set) = &node.effect else { continue };
            if let (true, Transfer::Copy | Transfer::RoundTrip, Some(from)) =
                (set.place.base == base, set.transfer, &set.from)
                && !found.contains(from)
            {
                found.push(from.clone());
            }
        }
    }
    found
}
