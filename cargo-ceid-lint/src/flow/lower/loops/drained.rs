//! Queues that the rounds of a loop empty, until nothing is left or by their count: `while let Some(x) = queue.pop() { … }`,
//! `for _ in 0..fifo.available() { filter.update(fifo.read()) }`.

use std::collections::BTreeSet;

use super::super::Builder;
use super::super::borrowed::only_reads;
use crate::flow::{LoopId, Place, Rounds};
use crate::index::Ty;
use crate::syntax::tree::{ExprId, ExprKind, Receiver};
use crate::types::Callee;

impl Builder<'_> {
    /// `while let Some(x) = queue.pop()` takes what is there.
    pub(super) fn is_drain(&self, condition: ExprId) -> bool {
        let tree = self.body();
        let ExprKind::Let { value, .. } = &tree.expr(condition).kind else { return false };
        let mut at = *value;
        loop {
            match &tree.expr(at).kind {
                ExprKind::MethodCall { receiver, method, .. } => match method.as_str() {
                    "ok" | "unwrap" | "as_mut" | "map" | "flatten" | "borrow_mut" | "lock" => at = *receiver,
                    name => return takes_one(name),
                },
                _ => return false,
            }
        }
    }

    /// Notes what the rounds of a loop take from what says how many rounds there are, and by which methods.
    pub(super) fn note_drained(&mut self, this_loop: LoopId, limit: ExprId, inside: ExprId) {
        if self.graph.loop_info(this_loop).rounds != Rounds::Bounded {
            return;
        }
        let (owners, asked_by) = self.counted_by(limit);
        if owners.is_empty() {
            return;
        }
        let tree = self.body();
        let mut taken = Vec::new();
        for id in tree.within(inside) {
            let ExprKind::MethodCall { receiver, method, .. } = &tree.expr(id).kind else { continue };
            let is_owner = |place: &Place| owners.contains(place);
            if !asked_by.contains(method)
                && self.takes_from(id, *receiver, method)
                && let Some(place) = self.static_place(*receiver).filter(is_owner)
            {
                taken.push((place, method.clone()));
            }
        }
        self.graph.loops[this_loop.0 as usize].taken_by_count = taken;
    }

    /// What is asked, and by which methods, for a number: `n` with `let n = fifo.available().min(32);`
    fn counted_by(&mut self, number: ExprId) -> (BTreeSet<Place>, BTreeSet<String>) {
        let (mut owners, mut asked_by) = (BTreeSet::new(), BTreeSet::new());
        let mut seen = BTreeSet::new();
        let mut open = vec![self.computed_from(number)];
        while let Some(computed) = open.pop() {
            let vars = computed.places.iter().filter(|place| place.steps.is_empty()).filter_map(Place::base_var);
            let new = vars.filter(|var| seen.insert(*var));
            open.extend(new.filter_map(|var| self.graph.computed.get(&var).cloned()));
            if !computed.calls.is_empty() {
                owners.extend(computed.places);
                asked_by.extend(computed.calls);
            }
        }
        (owners, asked_by)
    }

    /// Whether a method may take something from what it is called on.
    fn takes_from(&self, call: ExprId, receiver: ExprId, method: &str) -> bool {
        let is_known = matches!(self.ty(receiver).peel(), Ty::External(path, _) if path.starts_with("std::"));
        match self.typed().callees.get(&call) {
            Some(Callee::Resolved(resolved)) => {
                let receiver = |target| self.program.index.function(target).function.receiver.as_ref();
                resolved.targets.iter().any(|target| receiver(*target) == Some(&Receiver::Exclusive))
            }
            _ => takes_one(method) || !is_known && !only_reads(method),
        }
    }
}

/// Whether a method of that name takes one item out of a queue.
fn takes_one(method: &str) -> bool {
    matches!(
        method,
        "pop"
            | "pop_front"
            | "pop_back"
            | "try_recv"
            | "dequeue"
            | "try_pop"
            | "try_next"
            | "poll_next"
            | "next"
            | "try_dequeue"
            | "try_receive"
            | "take"
            | "pop_first"
            | "pop_last"
            | "try_iter"
            | "try_pop_front"
    )
}
