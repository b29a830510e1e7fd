//! Cells that other tasks may write while this one waits: what is read of them is asked anew behind an `.await`.

use std::collections::BTreeSet;

use super::other_names::{Home, OnWay};
use super::run::Run;
use super::{Region, Search};
use crate::flow::{Base, Effect, Flag, Place, SubjectId};

impl Search<'_> {
    /// The subjects that read a cell which others have as well.
    pub(super) fn changed_by_tasks(&self) -> &BTreeSet<SubjectId> {
        self.dependence.by_tasks(|| {
            if !self.graph.nodes.iter().any(|node| matches!(node.effect, Effect::Suspend)) {
                return BTreeSet::new();
            }
            let ids = (0u32..).map(SubjectId).zip(&self.graph.subjects);
            let changes = |place: &Place| {
                let roots = self.aliases.shared_roots(place);
                self.is_cell_of_others(place)
                    && !self.is_held_open(place)
                    && roots.iter().all(|root| root == place || self.is_cell_of_others(root))
            };
            ids.filter(|(_, subject)| subject.reads.iter().any(changes)).map(|(id, _)| id).collect()
        })
    }

    /// Whether a region waits somewhere while other code may write the cell that a place leads through.
    pub(in crate::count) fn is_switched_by_tasks(&self, region: Region, place: &Place) -> bool {
        let graph = self.graph;
        let mut waiting = graph.nodes.iter().filter(|node| matches!(node.effect, Effect::Suspend));
        if !waiting.any(|node| region.holds(graph, node.in_loop)) {
            return false;
        }
        let is_written = |cell: Flag<'_>| self.program.is_written_by_others(cell, graph.function);
        OnWay::to(self.program.index, graph, place).is_some_and(|cell| {
            cell.is_of_others
                && match &cell.home {
                    Home::Static(id) => is_written(Flag::Static(*id)),
                    Home::Field(owner, name) => is_written(Flag::Field(*owner, name)),
                    // Whoever gave the reference has another one.
                    Home::Anywhere => true,
                    Home::Variable(_) => false,
                }
        })
    }

    /// Whether a place is what a cell in a static holds, which interrupts and other threads see as well.
    pub(super) fn is_cell_of_static(&self, place: &Place) -> bool {
        let Base::Static(id) = place.base else { return false };
        !self.program.index.value(id).item.is_of_thread() && OnWay::to(self.program.index, self.graph, place).is_some()
    }

    /// Whether a place is a name for what a cell lends: nobody can write it meanwhile.
    fn is_held_open(&self, place: &Place) -> bool {
        let computed = place.base_var().and_then(|var| self.graph.computed.get(&var));
        computed.is_some_and(|from| from.calls.iter().any(|call| matches!(call.as_str(), "borrow" | "borrow_mut")))
    }

    fn is_cell_of_others(&self, place: &Place) -> bool {
        OnWay::to(self.program.index, self.graph, place).is_some_and(|cell| cell.is_of_others)
    }
}

impl Run<'_, '_> {
    /// What is left of what is known of conditions where other tasks have run.
    pub(super) fn behind_tasks(&mut self, masks: u32) -> u32 {
        let changed = self.search.changed_by_tasks();
        if changed.is_empty() {
            return masks;
        }
        let mut all = self.masks.get(masks).clone();
        for at in 0..self.tracked.subjects.len() {
            let id = self.tracked.subjects[at];
            if changed.contains(&id) {
                self.keep_assumed(&mut all, at);
                all[at] = self.search.graph.subjects[id.0 as usize].anything();
            }
        }
        self.masks.intern(all)
    }
}
