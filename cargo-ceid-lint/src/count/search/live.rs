//! Conditions that nothing behind a node asks for any more, before they change: what is known of them tells no ways apart.

use std::sync::Arc;

use super::Search;
use super::run::Run;
use crate::flow::{Base, CallSite, Effect, NodeId, Place, SubjectId};

/// How many states a search may have before it forgets what is asked for no more: most searches have fewer.
pub(super) const MANY_STATES: usize = 4_000;

impl Search<'_> {
    /// Which nodes may still need what was known of a subject before them, in this iteration or a later one.
    fn needing(&self, id: SubjectId) -> Arc<Vec<bool>> {
        self.dependence.needing(id, || {
            let graph = self.graph;
            let changing = self.writers_of(id);
            // What a call changes it may have asked for before; only its result is surely a new one.
            let forgets = |node: NodeId| match &graph.node(node).effect {
                Effect::Set(_) | Effect::Write(_) => changing.binary_search(&node).is_ok(),
                Effect::Call(site) => {
                    self.read_by(id).is_changed_with(&Place::var(site.result)) && !self.may_ask(site, id)
                }
                _ => false,
            };
            let returns = || graph.node_ids().filter(|node| matches!(graph.node(*node).effect, Effect::Return(_)));
            let mut needing = vec![false; graph.nodes.len()];
            let mut open: Vec<NodeId> = graph.node_ids().filter(|node| self.asks_for(*node, id)).collect();
            while let Some(node) = open.pop() {
                if std::mem::replace(&mut needing[node.0 as usize], true) {
                    continue;
                }
                open.extend(self.dependence.before(node).iter().copied().filter(|before| !forgets(*before)));
                if node == NodeId(0) {
                    // A function that is a cycle is called again.
                    open.extend(returns());
                }
            }
            needing
        })
    }

    /// Whether a node asks what a subject is, or hands that on.
    fn asks_for(&self, node: NodeId, id: SubjectId) -> bool {
        let graph = self.graph;
        let whole = graph.subjects[id.0 as usize].whole.as_ref();
        let is_whole = |place: &Place| whole == Some(place);
        match &graph.node(node).effect {
            Effect::Branch(test) => test.subject.is_some_and(|asked| {
                let equals = graph.subjects[asked.0 as usize].equals();
                asked == id || equals.is_some_and(|(left, right)| is_whole(left) || is_whole(right))
            }),
            Effect::Set(_) | Effect::Write(_) => graph.copied(node).is_some_and(|place| is_whole(&place)),
            Effect::Return(value) => value.same_as.is_some_and(|var| is_whole(&Place::var(var))),
            Effect::Call(site) => self.may_ask(site, id),
            _ => false,
        }
    }

    /// Whether what is called may ask for a subject.
    fn may_ask(&self, site: &CallSite, id: SubjectId) -> bool {
        let reads = self.read_by(id);
        let whole = self.graph.subjects[id.0 as usize].whole.as_ref();
        let is_static = whole.is_some_and(|place| matches!(place.base, Base::Static(_)));
        let leads_there =
            |place: &Place| self.aliases.shared_roots(place).iter().any(|root| reads.is_changed_with(root));
        let mut given = site.args.iter().flat_map(|arg| arg.place.iter().chain(&arg.value_of));
        !site.targets.is_empty() && (is_static || given.any(|place| reads.is_changed_with(place) || leads_there(place)))
    }
}

impl Run<'_, '_> {
    /// From now on, states forget what is asked for no more.
    pub(super) fn forget_what_nothing_asks(&mut self) {
        let (search, told) = (self.search, self.tracked.subjects.len());
        let is_kept = |at: usize, id: SubjectId| {
            told > u32::BITS as usize
                || self.is_told(at)
                || self.mode.is_some_and(|mode| mode.subject == id)
                // What a counter's number is stands for the round as well.
                || search.graph.loops.iter().any(|info| {
                    let whole = search.graph.subjects[id.0 as usize].whole.as_ref();
                    info.counter.is_some_and(|(counter, _)| whole == Some(&Place::var(counter)))
                })
        };
        let mut needed = vec![0; search.graph.nodes.len()];
        for (at, id) in self.tracked.subjects.iter().enumerate().take(u32::BITS as usize) {
            let needing = (!is_kept(at, *id)).then(|| search.needing(*id));
            for (node, bits) in needed.iter_mut().enumerate() {
                *bits |= u32::from(needing.as_ref().is_none_or(|needing| needing[node])) << at;
            }
        }
        self.needed = Some(needed);
    }

    /// What is still to be known of conditions at a node.
    pub(super) fn still_needed(&mut self, masks: u32, at: NodeId) -> u32 {
        let Some(needed) = self.needed.as_ref().map(|needed| needed[at.0 as usize]) else { return masks };
        if let Some(known) = self.reduced.get(&(masks, needed)) {
            return *known;
        }
        let mut all = self.masks.get(masks).clone();
        for (at, id) in self.tracked.subjects.iter().enumerate().take(u32::BITS as usize) {
            if needed & (1 << at) == 0 {
                all[at] = self.search.graph.subjects[id.0 as usize].anything();
            }
        }
        let reduced = self.masks.intern(all);
        self.reduced.insert((masks, needed), reduced);
        reduced
    }
}
