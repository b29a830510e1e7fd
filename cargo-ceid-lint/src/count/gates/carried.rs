//! Flags that one round leaves for the next: `if due { … } n += 1; due = n % 10 == 0;`

use std::borrow::Cow;

use super::{Gates, MAX_ORIGINS, Way};
use crate::count::verdict::Gate;
use crate::flow::{Effect, NodeId, Place, Test};

impl Gates<'_, '_> {
    /// What a flag waits for that was set in the round before, if every round that skips asks for it again.
    pub(super) fn of_carried(&self, test: &Test, at: NodeId, way: &Way) -> Option<Gate> {
        let flag = self.search.graph.subjects[test.subject?.0 as usize].whole.as_ref()?;
        if !self.outlives(flag) || self.calls_write(flag) {
            return None;
        }
        let opens = self.opening_heads(test, at);
        let skips = way.after(at)?;
        if self.stays_open(flag, at, skips) {
            return None;
        }
        // What follows in this round is of the next one.
        let asked_at = way.nodes.iter().position(|node| *node == at)?;
        let before = Way { nodes: way.nodes[..=asked_at].to_vec(), at, left_at: at };
        let mut found: Option<Gate> = None;
        for id in self.setting(flag, &opens, 0)? {
            let (asked, node) = self.asked_for(id)?;
            let gate = self.of_test(&asked, node, &before)?;
            // A sample that this round has asked for was not there: `if let Some(z) = read() { self.fresh = true; }`
            let is_asked = match gate {
                Gate::Rate | Gate::Time => !self.completes(skips, |other, _| other != node),
                Gate::Sample => before.nodes.contains(&node),
                _ => false,
            };
            if !is_asked || *found.get_or_insert(gate) != gate {
                return None;
            }
        }
        found
    }

    /// Whether a round that finds a flag open may update and leave the flag as it is: that is a state, which something else ends.
    fn stays_open(&self, flag: &Place, at: NodeId, skips: NodeId) -> bool {
        let keeps = |node: NodeId, _: usize| !self.assigns(node, flag);
        let before = self.reached(keeps);
        self.search.graph.node(at).next.iter().filter(|next| **next != skips && before[at.0 as usize]).any(|open| {
            let reached = self.reached_from(*open, keeps);
            let updating = self.search.updating();
            updating.iter().any(|node| reached[node.0 as usize] && self.completes(*node, keeps))
        })
    }

    /// Whether a way that finds its flag closed opens it for the next round.
    pub(super) fn opens_next(&self, test: &Test, way: &Way) -> bool {
        let flag = test.subject.and_then(|id| self.search.graph.subjects[id.0 as usize].whole.as_ref());
        let behind = || way.nodes.iter().skip_while(|node| **node != way.at);
        let opens = || self.opening_heads(test, way.at);
        flag.filter(|flag| self.outlives(flag))
            .and_then(|flag| self.setting(flag, &opens(), 0))
            .is_some_and(|setting| behind().any(|node| setting.contains(node)))
    }

    /// The nodes that may give a flag one of these heads; `None` if it may get one elsewhere.
    fn setting(&self, flag: &Place, heads: &[String], origins: u32) -> Option<Vec<NodeId>> {
        let mut nodes = Vec::new();
        for id in self.assigning(flag) {
            let (Effect::Set(set) | Effect::Write(set)) = &self.search.graph.node(id).effect else { return None };
            match (&set.head, set.same_as) {
                (Some(head), _) if !heads.contains(head) => {}
                (None, Some(from)) if origins < MAX_ORIGINS && self.assigning(&Place::var(from)).next().is_some() => {
                    nodes.extend(self.setting(&Place::var(from), heads, origins + 1)?);
                }
                _ => nodes.push(id),
            }
        }
        Some(nodes)
    }

    /// What was asked for the value that a node gives a flag, and where.
    fn asked_for(&self, id: NodeId) -> Option<(Cow<'_, Test>, NodeId)> {
        let graph = self.search.graph;
        let node = graph.node(id);
        if let (Effect::Set(set) | Effect::Write(set), Some(change)) = (&node.effect, graph.changes.get(&id))
            && set.head.is_none()
        {
            let about = change.about.as_deref()?.clone();
            let asked = Test { subject: None, holds: 0, fails: 0, span: node.span, text: String::new(), about };
            return Some((Cow::Owned(asked), id));
        }
        self.branch_before(id).map(|(test, at)| (Cow::Borrowed(test), at))
    }

    /// The branch that decides whether a node is run, if nothing but it leads there.
    pub(super) fn branch_before(&self, id: NodeId) -> Option<(&Test, NodeId)> {
        let graph = self.search.graph;
        let mut at = id;
        loop {
            let mut leading = self.nodes().filter(|node| graph.node(*node).next.contains(&at));
            let (Some(only), None) = (leading.next(), leading.next()) else { return None };
            match &graph.node(only).effect {
                Effect::Branch(test) => return Some((test, only)),
                _ if only == self.start() => return None,
                _ => at = only,
            }
        }
    }
}
