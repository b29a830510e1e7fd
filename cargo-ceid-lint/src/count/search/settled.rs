//! What the branches on the way to a loop tell of conditions that never change.

use std::collections::BTreeSet;
use std::rc::Rc;

use super::{Region, Search};
use crate::flow::{Effect, NodeId, Place, SubjectId};

impl Search<'_> {
    /// The heads that a subject which never changes can have in a loop, for the branches on the way there:
    /// `if !latch { loop { if latch { … } } }`.
    pub(super) fn settled(&self, region: Region, id: SubjectId) -> u32 {
        let graph = self.graph;
        let Region::Loop(own) = region else { return graph.subjects[id.0 as usize].anything() };
        let is_outside = |node: NodeId| !graph.is_within(graph.node(node).in_loop, own);
        let head = graph.loop_info(own).head;
        self.dependence.arriving(head, id, || self.arriving(head, id, &is_outside))
    }

    /// The heads that a subject which never changes can have at a branch on it, for the branches on the way there.
    pub(super) fn settled_at(&self, branch: NodeId, id: SubjectId) -> u32 {
        self.dependence.arriving(branch, id, || self.arriving(branch, id, &|node| node != branch))
    }

    /// The same for any node, where only what `is_outside` is asked on the way there.
    fn arriving(&self, target: NodeId, id: SubjectId, is_outside: &dyn Fn(NodeId) -> bool) -> u32 {
        let graph = self.graph;
        let subject = &graph.subjects[id.0 as usize];
        let Some(place) = &subject.whole else { return subject.anything() };
        let asks = |node: NodeId| match &graph.node(node).effect {
            Effect::Branch(test) if test.subject == Some(id) => Some((test.holds, test.fails)),
            _ => None,
        };
        if place.base_var().is_none() || !self.dependence.asking(id).iter().any(|node| is_outside(*node)) {
            return subject.anything();
        }
        let reads = self.reads_of(id);
        let mut starts: Vec<NodeId> = graph.node_ids().filter(|node| self.writes_any(*node, &reads)).collect();
        if !starts.iter().all(|writer| is_outside(*writer)) {
            return subject.anything();
        }
        starts.push(NodeId(0));
        let arrives_with = |bit: u32| {
            let mut seen = vec![false; graph.nodes.len()];
            let mut open = starts.clone();
            while let Some(node) = open.pop() {
                if node == target {
                    return true;
                }
                if std::mem::replace(&mut seen[node.0 as usize], true) {
                    continue;
                }
                let asked = asks(node);
                for (edge, next) in graph.node(node).next.iter().enumerate() {
                    let heads = asked.map_or(bit, |(holds, fails)| if edge == 0 { holds } else { fails });
                    if heads & bit != 0 {
                        open.push(*next);
                    }
                }
            }
            false
        };
        let bits = (0..u32::BITS).map(|number| 1 << number).filter(|bit| subject.anything() & bit != 0);
        bits.filter(|bit| arrives_with(*bit)).sum()
    }

    /// What a subject reads, by each of its names.
    pub(super) fn reads_of(&self, id: SubjectId) -> Rc<[Place]> {
        if let Some(known) = self.reads.borrow().get(&id) {
            return Rc::clone(known);
        }
        let reads = &self.graph.subjects[id.0 as usize].reads;
        let roots = reads.iter().flat_map(|read| self.aliases.shared_roots(read).to_vec());
        let reads: Rc<[Place]> = reads.iter().cloned().chain(roots).collect::<BTreeSet<_>>().into_iter().collect();
        self.reads.borrow_mut().insert(id, Rc::clone(&reads));
        reads
    }

    /// Whether a node may write one of these places.
    pub(super) fn writes_any(&self, node: NodeId, places: &[Place]) -> bool {
        let is_one = |other: &Place| places.iter().any(|place| other.overlaps(place));
        match &self.graph.node(node).effect {
            Effect::Set(set) | Effect::Write(set) => {
                is_one(&set.place) || (!set.rebinds && self.aliases.shared_roots(&set.place).iter().any(is_one))
            }
            Effect::Unknown { places, .. } => places.iter().any(is_one),
            Effect::Call(site) => is_one(&Place::var(site.result)) || self.called(site).writes.iter().any(is_one),
            _ => false,
        }
    }
}
