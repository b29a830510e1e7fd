//! Fields that lead to filters, wherever a value of their types lives: whether some other code updates the filter at a place, as far
//! as the fields on the way there tell.

use std::collections::{BTreeMap, BTreeSet};

use super::analyse::FunctionFacts;
use super::functions::FunctionKind;
use super::instances::{leaves, place_ty};
use crate::flow::{ControlFlowGraph, Effect, Place, Projection};
use crate::index::{FunctionId, Index, Ty, TypeId};

/// A field of a type, or a field of a field.
pub(super) type FieldKey = (TypeId, Vec<String>);

/// Places by their fields, each with halves of laws.
#[derive(Debug, Default)]
pub(super) struct Fields {
    /// By all fields that are known of them.
    whole: BTreeMap<FieldKey, BTreeSet<usize>>,
    /// By the last ones, of each type on the way.
    inner: BTreeMap<FieldKey, BTreeSet<usize>>,
}

impl Fields {
    /// Adds a place, with a half of its law.
    pub(super) fn add(&mut self, index: &Index, graph: &ControlFlowGraph, place: &Place, law: usize) {
        let mut keys = keys(index, graph, place).into_iter();
        if let Some(whole) = keys.next() {
            self.whole.entry(whole).or_default().insert(law);
        }
        for inner in keys {
            self.inner.entry(inner).or_default().insert(law);
        }
    }

    /// The halves that were added for what may be the same place: one knows of no other field on the way than the other one does.
    pub(super) fn laws(&self, index: &Index, graph: &ControlFlowGraph, place: &Place) -> BTreeSet<usize> {
        let keys = keys(index, graph, place);
        let whole = keys.iter().filter_map(|key| self.whole.get(key));
        let inner = keys.first().and_then(|key| self.inner.get(key));
        whole.chain(inner).flatten().copied().collect()
    }
}

/// The field that holds a place, and the type it is a field of.
pub(super) fn field_key(index: &Index, graph: &ControlFlowGraph, place: &Place) -> Option<FieldKey> {
    keys(index, graph, place).pop()
}

/// The fields that lead to a place: from each type on the way, the outermost first.
fn keys(index: &Index, graph: &ControlFlowGraph, place: &Place) -> Vec<FieldKey> {
    let mut keys = Vec::new();
    let mut fields = Vec::new();
    for (at, step) in place.steps.iter().enumerate().rev() {
        let Projection::Field(name) = step else {
            // An element is the collection's, and what lies in an element is a value of the element's type.
            if fields.is_empty() {
                continue;
            }
            break;
        };
        let owner = Place { base: place.base, steps: place.steps[..at].to_vec() };
        let Some(owner @ Ty::Adt(id, _)) = place_ty(index, graph, &owner) else { break };
        // What lies behind a reference belongs to something else.
        if !fields.is_empty() && matches!(index.field_ty(&owner, None, name), Some(Ty::Ref(..))) {
            break;
        }
        fields.insert(0, name.to_string());
        let declaring = index.declares_fields(id);
        keys.insert(0, (declaring, fields.clone()));
        // A task's resources are those of all tasks.
        if declaring != id {
            break;
        }
    }
    keys
}

/// The fields of types that some cycle updates, with the halves of the law.
pub(super) fn updated_fields(index: &Index, facts: &[FunctionFacts<'_>], in_cycle: &BTreeSet<FunctionId>) -> Fields {
    let mut found = Fields::default();
    for function in facts {
        let whole = in_cycle.contains(&function.graph.function);
        for instance in &function.updated {
            if (whole && instance.is_updated) || instance.function || !instance.loops.is_empty() {
                found.add(index, function.graph, &instance.place, instance.law);
            }
        }
    }
    found
}

/// The fields of types that some code updates or hands to something unseen.
pub(super) fn touched_fields(index: &Index, facts: &[FunctionFacts<'_>]) -> Fields {
    let mut found = Fields::default();
    for function in facts.iter().filter(|function| function.kind != FunctionKind::Outside) {
        let unknown = function.graph.nodes.iter().flat_map(|node| match &node.effect {
            Effect::Unknown { places, .. } => places.as_slice(),
            _ => &[],
        });
        for place in unknown.chain(&function.graph.cloned) {
            for root in function.aliases.roots(place) {
                for leaf in place_ty(index, function.graph, &root).map(|ty| leaves(index, &ty)).unwrap_or_default() {
                    found.add(index, function.graph, &root.join(&leaf.steps), 0);
                }
            }
        }
    }
    found
}
