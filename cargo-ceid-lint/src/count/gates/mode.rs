//! Gates of state: modes that are entered or left with a reset, latches, and conditions that never change.

use super::Gates;
use crate::count::search::{End, Exploration, Region};
use crate::count::verdict::Gate;
use crate::flow::{Effect, NodeId, Place, Test};

impl Gates<'_, '_> {
    /// A truth value or option that is set once and never taken back.
    pub(super) fn is_latch(&self, test: &Test, at: NodeId) -> bool {
        let graph = self.search.graph;
        let [place] = test.about.reads.as_slice() else { return false };
        let mut heads: Vec<&str> = Vec::new();
        for id in self.nodes() {
            if let Effect::Write(write) | Effect::Set(write) = &graph.node(id).effect
                && write.place == *place
            {
                match &write.head {
                    Some(head) => heads.push(head),
                    None => return false,
                }
            }
        }
        let written_elsewhere = self.calls_write(place);
        // What is set opens the way to the update; a latch that closes it for good is no start-up.
        let opens = self.updating_heads(test, at);
        !heads.is_empty()
            && heads.iter().all(|head| *head == heads[0])
            && opens.iter().any(|head| head == heads[0])
            && !written_elsewhere
    }

    /// Whether nothing in the cycle changes what the condition reads.
    pub(super) fn is_unchanging(&self, test: &Test, at: NodeId) -> bool {
        let graph = self.search.graph;
        let _ = at;
        // What a call gave back may be another value every time.
        let is_named = |place: &Place| place.base_var().is_none_or(|var| !graph.var(var).name.is_empty());
        let subject = test.subject.map(|id| &graph.subjects[id.0 as usize]);
        subject.is_none_or(|subject| subject.reads.iter().all(is_named))
            && !test.about.reads.is_empty()
            && test.about.reads.iter().all(|place| {
                let declared_inside = match (self.region, place.base_var()) {
                    (Region::Loop(own), Some(var)) => graph.is_within(graph.var(var).in_loop, own),
                    (Region::Function, Some(var)) => graph.var(var).param.is_none() || place.steps.is_empty(),
                    (_, None) => true,
                };
                let written = self.nodes().any(|id| match &graph.node(id).effect {
                    Effect::Write(write) | Effect::Set(write) => write.place.overlaps(place),
                    _ => false,
                });
                let is_param = place.steps.is_empty()
                    && place.base_var().is_some_and(|var| graph.var(var).param.is_some())
                    && self.region == Region::Function;
                !declared_inside && !written && !is_param && !self.calls_write(place) && !self.written_by_others(place)
            })
    }

    /// A state every transition into which, or out of which, goes with a reset of the filter.
    pub(super) fn is_mode(&self, test: &Test, at: NodeId) -> bool {
        let graph = self.search.graph;
        let Some(subject) = test.subject.map(|id| &graph.subjects[id.0 as usize]) else { return false };
        let Some(place) = &subject.whole else { return false };
        let heads = self.updating_heads(test, at);
        let before = self.before_updates();
        let mut enters: Vec<NodeId> = Vec::new();
        let mut leaves: Vec<NodeId> = Vec::new();
        for id in self.nodes() {
            match &graph.node(id).effect {
                Effect::Write(write) | Effect::Set(write) if write.place == *place => {
                    for (node, head) in self.values_of(id, write, 0) {
                        // A state that is given once more is no transition.
                        let is_before = before[node.0 as usize];
                        match head {
                            Some(head) if heads.contains(&head) => enters.extend(is_before.then_some(node)),
                            Some(_) => leaves.extend((!is_before).then_some(node)),
                            None => return false,
                        }
                    }
                }
                // A helper that switches the state may do so either way.
                Effect::Call(site) if self.call_writes(site, place) => {
                    enters.push(id);
                    leaves.push(id);
                }
                Effect::Unknown { places, .. } if places.iter().any(|other| other.overlaps(place)) => return false,
                _ => {}
            }
        }
        let with_reset = |nodes: &[NodeId]| !nodes.is_empty() && nodes.iter().all(|node| self.is_reset_beside(*node));
        with_reset(&enters) || with_reset(&leaves)
    }

    /// The nodes that an iteration can reach without an update.
    fn before_updates(&self) -> Vec<bool> {
        let graph = self.search.graph;
        let updating = self.search.updating();
        let start = match self.region {
            Region::Function => NodeId(0),
            Region::Loop(own) => graph.loop_info(own).head,
        };
        let mut reached = vec![false; graph.nodes.len()];
        let mut open = vec![start];
        while let Some(id) = open.pop() {
            if std::mem::replace(&mut reached[id.0 as usize], true) || updating.contains(&id) {
                continue;
            }
            open.extend(graph.node(id).next.iter().filter(|next| **next != start).copied());
        }
        reached
    }

    /// The constants that an assignment may give, with the nodes at which they are chosen; `None` for one that is not constant.
    fn values_of(&self, node: NodeId, set: &crate::flow::Assignment, links: u32) -> Vec<(NodeId, Option<String>)> {
        if set.head.is_some() || links > 8 {
            return vec![(node, set.head.clone())];
        }
        let Some(from) = set.same_as else { return vec![(node, None)] };
        let graph = self.search.graph;
        let mut values = Vec::new();
        for id in self.nodes() {
            if let Effect::Set(inner) = &graph.node(id).effect
                && inner.place == Place::var(from)
            {
                values.extend(self.values_of(id, inner, links + 1));
            }
        }
        // A state that is given to itself is no transition.
        if values.is_empty() { vec![(node, None)] } else { values }
    }

    /// The heads of the subject with which an update can still be reached behind a branch.
    fn updating_heads(&self, test: &Test, at: NodeId) -> Vec<String> {
        let graph = self.search.graph;
        let reach = self.search.reach(self.region);
        let Some(subject) = test.subject.map(|id| &graph.subjects[id.0 as usize]) else { return Vec::new() };
        let holds = graph.node(at).next.first().is_some_and(|next| reach[next.0 as usize]);
        let mask = if holds { test.holds } else { test.fails };
        let listed = subject.heads.iter().enumerate().filter(|(number, _)| mask & (1 << number) != 0);
        listed.map(|(_, head)| head.clone()).collect()
    }

    /// Whether a full reset of the instance runs on every way through a node: in the straight line before or behind it.
    fn is_reset_beside(&self, node: NodeId) -> bool {
        let graph = self.search.graph;
        let resets = |id: NodeId| match &graph.node(id).effect {
            Effect::Reset { place, full } => *full && self.is_instance(place),
            Effect::Write(write) if !write.rebinds => self.search.aliases.roots(&write.place).iter().any(|root| {
                root.base == self.search.instance.base
                    && root.steps.len() <= self.search.instance.steps.len()
                    && root.overlaps(self.search.instance)
            }),
            Effect::Call(site) => {
                site.targets.iter().all(|target| {
                    self.search.summaries.get(*target).is_some_and(|summary| {
                        summary.outcomes(0).any(|(given, outcomes)| {
                            outcomes.iter().all(|outcome| outcome.reset)
                                && crate::count::summary::place_of(given, site)
                                    .is_some_and(|place| self.is_instance(&place))
                        })
                    })
                }) && !site.targets.is_empty()
            }
            _ => false,
        };
        if resets(node) {
            return true;
        }
        let mut parts: Vec<Place> = Vec::new();
        let mut at = node;
        for _ in 0..64 {
            let [next] = graph.node(at).next.as_slice() else { break };
            if resets(*next) {
                return true;
            }
            parts.extend(self.written_part(*next));
            at = *next;
        }
        let mut at = node;
        for _ in 0..64 {
            let before: Vec<NodeId> = graph.node_ids().filter(|id| graph.node(*id).next.contains(&at)).collect();
            let [only] = before.as_slice() else { break };
            if graph.node(*only).next.len() > 1 {
                break;
            }
            if resets(*only) {
                return true;
            }
            parts.extend(self.written_part(*only));
            at = *only;
        }
        self.is_whole_state(&parts)
    }

    /// The part of the instance's state that a node writes.
    fn written_part(&self, node: NodeId) -> Option<Place> {
        match &self.search.graph.node(node).effect {
            Effect::Write(write) | Effect::Set(write) if self.is_part(&write.place) => {
                self.search.aliases.roots(&write.place).into_iter().find(|root| root.overlaps(self.search.instance))
            }
            _ => None,
        }
    }

    /// Whether these parts are everything that the law changes.
    fn is_whole_state(&self, parts: &[Place]) -> bool {
        let instance = self.search.instance;
        let laws = self.nodes().filter_map(|id| match &self.search.graph.node(id).effect {
            Effect::Call(site) if site.law_of.is_some() && self.concerns(site) => Some(&site.targets),
            _ => None,
        });
        let mut state: Vec<crate::flow::Projection> = Vec::new();
        for summary in laws.flatten().filter_map(|target| self.search.summaries.get(*target)) {
            for given in &summary.writes {
                if given.base == crate::count::summary::GivenBase::Param(0) {
                    state.extend(given.steps.first().cloned());
                }
            }
        }
        !state.is_empty()
            && state.iter().all(|step| parts.iter().any(|part| part.steps.get(instance.steps.len()) == Some(step)))
    }

    /// Whether another function writes the same field: a mode that is switched elsewhere.
    fn written_by_others(&self, place: &Place) -> bool {
        let is_field =
            !place.steps.is_empty() && place.base_var().is_some_and(|var| self.search.graph.var(var).param.is_some());
        is_field && self.region == Region::Function
    }

    /// A filter that lies in a variant is there only while the enum is that variant.
    pub(super) fn of_payload(&self, exploration: &Exploration, end: &End) -> Option<Gate> {
        let graph = self.search.graph;
        let instance = self.search.instance;
        let asked = exploration.path(end.at).iter().find_map(|at| {
            let Effect::Branch(test) = &graph.node(exploration.states[*at].node).effect else { return None };
            test.about.reads.iter().flat_map(|place| self.search.aliases.roots(place)).find(|root| {
                root.base == instance.base
                    && root.steps.len() < instance.steps.len()
                    && root.steps[..] == instance.steps[..root.steps.len()]
                    && self.is_variant_step(root)
            })
        })?;
        let changes = self.nodes().any(|id| match &graph.node(id).effect {
            Effect::Write(write) | Effect::Set(write) => write.place == asked,
            _ => false,
        });
        Some(if changes { Gate::Mode } else { Gate::Config })
    }

    /// Whether the step of the instance behind a place names a variant.
    fn is_variant_step(&self, place: &Place) -> bool {
        let index = self.search.program.index;
        match crate::count::instances::place_ty(index, self.search.graph, place) {
            Some(crate::index::Ty::Adt(id, _)) => matches!(index.type_def(id).shape, crate::index::Shape::Enum(_)),
            _ => false,
        }
    }
}
