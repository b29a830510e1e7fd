//! What a lock or cell holds: it is there in the next iteration, although the name under which an iteration has locked it is not.

use super::{Gates, MAX_ORIGINS};
use crate::count::declared::declared_ty;
use crate::count::instances::inner;
use crate::flow::{Computed, Place, Test};
use crate::index::Ty;
use crate::types::{is_lock, opens_cell};

impl Gates<'_, '_> {
    /// Whether a place is in what was there before the iteration, which has a name of its own for it while it is locked:
    /// `let mut state = shared.lock().unwrap(); state.count += 1;`.
    pub(super) fn is_locked(&self, place: &Place) -> bool {
        self.is_locked_by(place, 0)
    }

    fn is_locked_by(&self, place: &Place, names: u32) -> bool {
        let graph = self.search.graph;
        let Some(var) = place.base_var().filter(|_| names < MAX_ORIGINS) else { return false };
        let ty = &graph.var(var).ty;
        if !matches!(ty, Ty::Ref(..)) && ty.external_name() != Some("LockResult") {
            return false;
        }
        // Which element an index names may be another one in each iteration.
        let is_old = |place: &Place| {
            place.base_var() != Some(var)
                && place.steps.iter().all(|step| step.key().is_none())
                && (self.search.outlives(self.region, place) || self.is_locked_by(place, names + 1))
        };
        if self.search.aliases.shared_roots(place).iter().all(is_old) {
            return true;
        }
        let Some(from) = graph.computed.get(&var) else { return false };
        let held = inner(ty);
        let holds = |place: &Place| self.ty(place).is_some_and(|ty| inner(&ty) == held);
        from.calls.iter().any(|call| opens_cell(call))
            && from.calls.iter().all(|call| opens_cell(call) || is_unwrapping(call))
            && from.places.iter().any(|place| holds(place) && is_old(place))
    }

    /// Whether a place is the same part of what is locked under another name.
    pub(super) fn is_locked_again(&self, place: &Place, other: &Place) -> bool {
        let computed = |place: &Place| self.search.graph.computed.get(&place.base_var()?);
        let is_same = |left: &Computed, right: &Computed| left.places == right.places && left.calls == right.calls;
        place.base != other.base
            && place.steps == other.steps
            && computed(place).zip(computed(other)).is_some_and(|(left, right)| is_same(left, right))
            && self.is_locked(place)
    }

    /// Whether a lock is asked for that is waited for: it fails for good, where a thread has panicked that held it.
    pub(super) fn asks_poison(&self, test: &Test) -> bool {
        let about = &test.about;
        let ([place], [name]) = (about.reads.as_slice(), about.names.as_slice()) else { return false };
        about.is_presence
            && matches!(name.as_str(), "lock" | "read" | "write")
            && self.declared(place).is_some_and(|ty| is_lock(&ty))
    }

    /// The type that a place was declared with, with the locks in it.
    pub(super) fn declared(&self, place: &Place) -> Option<Ty> {
        declared_ty(self.search.program.index, self.search.graph, place)
    }
}

/// Methods between a lock and what it holds.
fn is_unwrapping(name: &str) -> bool {
    matches!(name, "unwrap" | "expect" | "unwrap_or_else" | "into_inner" | "await" | "as_mut" | "deref_mut")
}
