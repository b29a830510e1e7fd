//! What the branches on the way to a loop tell of conditions that never change.

use std::collections::BTreeSet;
use std::rc::Rc;
use std::sync::Arc;

use rustc_hash::FxHashSet;

use super::{Region, Search};
use crate::flow::{Effect, LoopId, NodeId, Place, SubjectId};
use crate::index::Ty;

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

    /// The heads that a subject can have where a loop is entered, for the branches on the way there, whatever becomes of it inside:
    /// `if armed { loop { if !armed { armed = ask(); … } } }`.
    pub(super) fn entering(&self, own: LoopId, id: SubjectId) -> u32 {
        let graph = self.graph;
        let is_outside = |node: NodeId| !graph.is_within(graph.node(node).in_loop, own);
        if !self.is_asked(id, &is_outside) {
            return graph.subjects[id.0 as usize].anything();
        }
        let before = self.dependence.before(graph.loop_info(own).head).iter();
        let from: Vec<NodeId> = before.copied().filter(|node| is_outside(*node)).collect();
        self.arriving_from(&from, id, &|node| !is_outside(node))
    }

    /// Whether a subject is a value of the function's, and asked for at one of some nodes.
    fn is_asked(&self, id: SubjectId, is_there: &dyn Fn(NodeId) -> bool) -> bool {
        let whole = self.graph.subjects[id.0 as usize].whole.as_ref();
        whole.and_then(Place::base_var).is_some() && self.dependence.asking(id).iter().any(|node| is_there(*node))
    }

    /// The same for any node and a subject that never changes, where only what `is_outside` is asked on the way there.
    fn arriving(&self, target: NodeId, id: SubjectId, is_outside: &dyn Fn(NodeId) -> bool) -> u32 {
        let is_left = || self.writers_of(id).iter().copied().chain(self.writers_by_other_names(id)).all(is_outside);
        if self.is_asked(id, is_outside) && is_left() {
            self.arriving_from(&[target], id, &|_| false)
        } else {
            self.graph.subjects[id.0 as usize].anything()
        }
    }

    /// The heads with which a subject comes to one of some nodes, where it may have any behind those that write it or `begins` names.
    fn arriving_from(&self, targets: &[NodeId], id: SubjectId, begins: &dyn Fn(NodeId) -> bool) -> u32 {
        let graph = self.graph;
        let subject = &graph.subjects[id.0 as usize];
        let asks = |node: NodeId| match &graph.node(node).effect {
            Effect::Branch(test) if test.subject == Some(id) => Some((test.holds, test.fails)),
            _ => None,
        };
        let mut starts: FxHashSet<NodeId> = self.writers_of(id).iter().copied().collect();
        starts.extend(self.writers_by_other_names(id));
        starts.insert(NodeId(0));
        // Backwards, for what gave it its value is mostly near.
        let arrives_with = |bit: u32| {
            let mut seen: FxHashSet<NodeId> = FxHashSet::default();
            let mut open = targets.to_vec();
            while let Some(node) = open.pop() {
                if starts.contains(&node) || begins(node) {
                    return true;
                }
                if !seen.insert(node) {
                    continue;
                }
                open.extend(self.dependence.before(node).iter().filter(|before| {
                    asks(**before).is_none_or(|(holds, fails)| {
                        let next = graph.node(**before).next.iter().enumerate();
                        let mut heads =
                            next.filter(|(_, next)| **next == node).map(|(edge, _)| [holds, fails][edge.min(1)]);
                        heads.any(|heads| heads & bit != 0)
                    })
                }));
            }
            false
        };
        let bits = (0..u32::BITS).map(|number| 1 << number).filter(|bit| subject.anything() & bit != 0);
        bits.filter(|bit| arrives_with(*bit)).sum()
    }

    /// What a subject reads.
    pub(super) fn read_by(&self, id: SubjectId) -> Rc<Reads> {
        if let Some(known) = self.reads.borrow().get(&id) {
            return Rc::clone(known);
        }
        let subject = &self.graph.subjects[id.0 as usize];
        // What was taken out of a place is there or not whatever is put in its stead.
        let is_taken_out = |read: &&Place| {
            let unnamed = read.base_var().map(|var| self.graph.var(var)).filter(|var| var.name.is_empty());
            read.steps.is_empty() && unnamed.is_some_and(|var| var.ty.external_name() == Some("Option"))
        };
        // A name for a copy keeps its value, whatever becomes of the place that was copied.
        let is_copy = |read: &&Place| {
            let named = read.base_var().map(|var| self.graph.var(var)).filter(|var| !var.name.is_empty());
            named.is_some_and(|var| {
                !matches!(var.ty, Ty::Ref(..) | Ty::Pointer(_)) && self.program.index.is_copy(&var.ty)
            })
        };
        let shared = subject.reads.iter().filter(|read| !is_taken_out(read) && !is_copy(read));
        let is_presence = subject.whole.is_some() && subject.heads.iter().all(|head| head == "+" || head == "-");
        // Whether there is a reference does not change with what becomes of the filter that it leads to.
        let names = |read: &Place| {
            let mut roots = self.aliases.shared_roots(read).to_vec();
            if is_presence && roots.as_slice() != std::slice::from_ref(read) && self.refers(read) {
                roots.retain(|root| self.refers(root));
            }
            roots
        };
        let roots = shared.flat_map(names);
        let places: BTreeSet<Place> = subject.reads.iter().cloned().chain(roots).collect();
        let places = places.into_iter().collect();
        let reads = Rc::new(Reads { places, is_presence });
        self.reads.borrow_mut().insert(id, Rc::clone(&reads));
        reads
    }

    /// The nodes that may change what a subject reads.
    pub(in crate::count) fn writers_of(&self, id: SubjectId) -> Arc<Vec<NodeId>> {
        let find = || {
            let reads = self.read_by(id);
            self.graph.node_ids().filter(|node| self.writes(*node, id, &reads)).collect()
        };
        // What is called for an instance behind a trait may be less than for others.
        if self.behind.is_empty() { self.dependence.writing(id, find) } else { Arc::new(find()) }
    }

    fn writes(&self, node: NodeId, id: SubjectId, reads: &Reads) -> bool {
        let is_one = |place: &Place| reads.is_changed_with(place);
        match &self.graph.node(node).effect {
            Effect::Set(set) | Effect::Write(set) => {
                is_one(&set.place) || (!set.rebinds && self.aliases.shared_roots(&set.place).iter().any(is_one))
            }
            Effect::Unknown { places, .. } => places.iter().any(is_one),
            Effect::Suspend => self.changed_by_tasks().contains(&id),
            // A state that is a number is the value that a condition asks for.
            Effect::Update(update) => !update.is_typed && !reads.is_presence && is_one(&update.place),
            Effect::Call(site) => is_one(&Place::var(site.result)) || self.called(site).writes.keys().any(is_one),
            _ => false,
        }
    }
}

/// What the value of a subject depends on.
#[derive(Debug)]
pub(super) struct Reads {
    /// The places, by each of their names, in their order.
    places: Vec<Place>,
    /// Whether it is asked only whether something is there.
    is_presence: bool,
}

impl Reads {
    /// The places, by each of their names.
    pub(super) fn places(&self) -> impl Iterator<Item = &Place> {
        self.places.iter()
    }

    /// Whether the value may be another one when a place is written: whether an option holds something does not change with what it
    /// holds. What a constant stands for does.
    pub(super) fn is_changed_with(&self, place: &Place) -> bool {
        let is_inside = |read: &Place| self.is_presence && place.steps.len() > read.steps.len();
        let first = self.places.partition_point(|read| read.base < place.base);
        let near = self.places[first..].iter();
        near.take_while(|read| read.base == place.base).any(|read| read.overlaps(place) && !is_inside(read))
    }
}
