//! Where a way is decided: behind which branch no update can follow any more, by all that the way has found by then.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use rustc_hash::{FxHashMap, FxHashSet};

use super::Search;
use super::run::Run;
use crate::count::counts::Count;
use crate::flow::{Base, Effect, NodeId, Place, SubjectId};

/// How often it is looked ahead; beyond that, ways stay decided where nothing but the graph decides them.
const MAX_LOOKS: usize = 64;

/// Which heads each subject may have, by the answers that were taken.
type Answers = BTreeMap<SubjectId, u32>;

impl Run<'_, '_> {
    /// Moves the point at which each way skips up to the branch whose answer leaves no update: `match message { Ping if loud => …,
    /// Ping => {}, Level(z) => f.update(z) }` is decided by `Ping`, not by `loud`.
    pub(super) fn skip_where_known(&mut self) {
        let mut looks: FxHashMap<(NodeId, Answers), bool> = FxHashMap::default();
        for number in 0..self.exploration.ends.len() {
            let end = &self.exploration.ends[number];
            let is_skipped = end.state.count == Count::Zero && !end.is_copy_lost;
            let Some(skipped_at) = end.state.skipped_at.filter(|_| is_skipped) else { continue };
            // A filter that is not there owes nothing, whatever was asked before.
            if self.search.asks_for_filter(self.region, skipped_at) {
                continue;
            }
            let nodes: Vec<NodeId> =
                self.exploration.path(end.at).iter().map(|at| self.exploration.states[*at].node).collect();
            let Some(last) = nodes.iter().rposition(|node| *node == skipped_at) else { continue };
            let nodes = &nodes[..=last];
            let is_branch = |at: &usize| matches!(self.search.graph.node(nodes[*at]).effect, Effect::Branch(_));
            if !is_branch(&last) {
                continue;
            }
            for at in (0..=last).rev().filter(is_branch) {
                let asked = (nodes[at], self.answers_before(nodes, at));
                if looks.len() >= MAX_LOOKS && !looks.contains_key(&asked) {
                    break;
                }
                let node = asked.0;
                if *looks.entry(asked).or_insert_with_key(|(node, answers)| self.can_update_from(*node, answers)) {
                    // Where the same is asked again, the last one is about the update: among the arms of one `match`, and in
                    // `if fault { warn(); } … if !fault { f.update(); }`, and so in `if !on && cold { on = true; } … if on { … }`.
                    let mut earlier = (0..=at).filter(is_branch).map(|at| nodes[at]);
                    if !earlier.any(|earlier| self.ask_alike(earlier, skipped_at)) {
                        self.exploration.ends[number].state.skipped_at = Some(node);
                    }
                    break;
                }
            }
        }
    }

    /// Whether two branches ask the same.
    fn ask_alike(&self, first: NodeId, second: NodeId) -> bool {
        let graph = self.search.graph;
        let (Effect::Branch(first), Effect::Branch(second)) = (&graph.node(first).effect, &graph.node(second).effect)
        else {
            return false;
        };
        let matched = |text: &str| text.split_once(" is ").map(|(matched, _)| matched.to_owned());
        first.subject.is_some() && first.subject == second.subject
            || matched(&first.text).is_some_and(|text| matched(&second.text) == Some(text))
    }

    /// What the branches on a way have found where it comes to one of its nodes.
    fn answers_before(&self, nodes: &[NodeId], end: usize) -> Answers {
        let graph = self.search.graph;
        let mut answers = Answers::new();
        for (at, node) in nodes[..end].iter().enumerate() {
            let Effect::Branch(test) = &graph.node(*node).effect else {
                for subject in self.search.may_change_at(*node).iter() {
                    answers.remove(subject);
                }
                continue;
            };
            let edges = &graph.node(*node).next;
            if let (Some(subject), Some(next)) = (test.subject, nodes.get(at + 1))
                && edges.iter().filter(|edge| *edge == next).count() == 1
            {
                let heads = if edges.first() == Some(next) { test.holds } else { test.fails };
                *answers.entry(subject).or_insert(u32::MAX) &= heads;
            }
        }
        answers
    }

    /// Whether an update may follow a branch in the iteration, by what was found before it.
    fn can_update_from(&self, node: NodeId, answers: &Answers) -> bool {
        let search = self.search;
        let behind = |reached: Vec<bool>| search.graph.node_ids().filter(move |id| reached[id.0 as usize]);
        let all: Vec<NodeId> = behind(search.reached_from(self.region, node, |_, _| true)).collect();
        // What may change on the way is not known there any more.
        let mut changed: FxHashSet<SubjectId> = FxHashSet::default();
        for node in &all {
            changed.extend(search.may_change_at(*node).iter());
        }
        let is_kept = |subject: &SubjectId| !changed.contains(subject);
        let known: Answers =
            answers.iter().filter(|(subject, _)| is_kept(subject)).map(|(id, own)| (*id, *own)).collect();
        let follows = |node: NodeId, edge: usize| {
            let Effect::Branch(test) = &search.graph.node(node).effect else { return true };
            let heads = if edge == 0 { test.holds } else { test.fails };
            test.subject.and_then(|subject| known.get(&subject)).is_none_or(|found| found & heads != 0)
        };
        let updating = search.updating();
        behind(search.reached_from(self.region, node, follows)).any(|node| updating.contains(&node))
    }
}

impl Search<'_> {
    /// The subjects of which a node may change what they read.
    fn may_change_at(&self, node: NodeId) -> Arc<Vec<SubjectId>> {
        self.dependence.changed_at(node, || {
            let graph = self.graph;
            if matches!(graph.node(node).effect, Effect::Suspend) {
                return self.changed_by_tasks().iter().copied().collect();
            }
            let places: Vec<&Place> = match &graph.node(node).effect {
                Effect::Set(set) | Effect::Write(set) => vec![&set.place],
                Effect::Call(site) => site.args.iter().filter_map(|arg| arg.place.as_ref()).collect(),
                Effect::Unknown { places, .. } => places.iter().collect(),
                Effect::Update(update) => vec![&update.place],
                Effect::Reset { place, .. } => vec![place],
                _ => Vec::new(),
            };
            let readers = self.dependence.readers(|| self.find_readers());
            let mut found = BTreeSet::new();
            for place in places {
                let roots = self.aliases.shared_roots(place);
                for changed in roots.iter().chain([place]) {
                    let near = readers.get(&changed.base).into_iter().flatten();
                    found.extend(near.filter(|subject| self.read_by(**subject).is_changed_with(changed)));
                }
            }
            found.into_iter().collect()
        })
    }

    /// The subjects that read something of each base.
    fn find_readers(&self) -> FxHashMap<Base, Vec<SubjectId>> {
        let mut readers: FxHashMap<Base, Vec<SubjectId>> = FxHashMap::default();
        for id in (0u32..).map(SubjectId).take(self.graph.subjects.len()) {
            let bases: BTreeSet<Base> = self.read_by(id).places().map(|place| place.base).collect();
            for base in bases {
                readers.entry(base).or_default().push(id);
            }
        }
        readers
    }
}
