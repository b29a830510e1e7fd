//! Pauses that a flag remembers: `if enabled() { if !self.active { f.reset(); self.active = true; } f.update(); } else { self.active =
//! false; }`. The condition is no state, but a state tells at the end of each iteration whether the filter runs.

use std::collections::BTreeSet;

use super::{Gates, Way};
use crate::count::given::place_of;
use crate::count::search::Mode;
use crate::count::verdict::Gate;
use crate::flow::{Effect, Head, NodeId, Place, Subject, SubjectId};

/// A state, and the heads of it with which an iteration ends that has paused.
#[derive(Clone, Copy)]
struct Memory<'a> {
    id: SubjectId,
    place: &'a Place,
    idle: u32,
    running: u32,
}

impl Gates<'_, '_> {
    /// A way whose pause a state remembers, with a reset of the filter where it begins to run again, or where it stops.
    pub(super) fn of_remembered(&self, way: &Way) -> Option<Gate> {
        let mut memories = self.memories().iter().filter_map(|id| {
            let subject = &self.search.graph.subjects[id.0 as usize];
            let idle = self.heads_after(*id, way);
            let running = subject.anything() & !idle;
            let place = subject.whole.as_ref()?;
            (idle != 0 && running != 0).then_some(Memory { id: *id, place, idle, running })
        });
        memories.any(|memory| self.is_kept_in(memory)).then_some(Gate::Mode)
    }

    /// The states that the cycle gives several heads in so many words, and keeps. There are few of them, and many ways.
    fn memories(&self) -> &[SubjectId] {
        self.memories.get_or_init(|| {
            let graph = self.search.graph;
            let subjects = (0u32..).map(SubjectId).zip(&graph.subjects);
            let is_memory = |(id, subject): &(SubjectId, &Subject)| {
                let Some(place) = subject.whole.as_ref() else { return false };
                // Whether the filter is there is no memory of it.
                let may_tell = place.base_var().is_some() && self.outlives(place) && !self.is_instance(place);
                let writers = self.search.writers_of(*id);
                let inside = writers.iter().filter(|node| self.is_inside(**node));
                let heads = || -> BTreeSet<&Head> { inside.flat_map(|node| self.heads_given(place, *node)).collect() };
                may_tell && !self.comes_anew(place) && heads().len() > 1
            };
            subjects.filter(is_memory).map(|(id, _)| id).collect()
        })
    }

    fn is_kept_in(&self, memory: Memory<'_>) -> bool {
        let Memory { id, place, idle, running } = memory;
        if let Some(known) = self.remembered.borrow().get(&(id, idle)) {
            return *known;
        }
        let subject = &self.search.graph.subjects[id.0 as usize];
        let is_given = |heads: u32| {
            let mut given = self.giving(memory, heads).into_iter().flat_map(|node| self.heads_given(place, node));
            given.any(|head| subject.bit(head) & heads != 0)
        };
        let is_switched = is_given(idle) && is_given(running);
        // What others may give it leads to a reset.
        let bears = match is_switched {
            true if self.resets_before_running(memory) => Some(idle),
            true if self.resets_behind_running(memory) => Some(running),
            // What helpers say of it is told from way to way, and nobody else may say anything.
            true if self.search.resets_in_pauses(self.region, Mode::new(id, running)) => Some(0),
            _ => None,
        };
        let bears = bears.filter(|bears| !self.is_resumed_elsewhere(id, subject.anything() & !bears));
        if let Some(bears) = bears {
            self.own_states.borrow_mut().insert(place.clone(), subject.names(bears));
        }
        self.remembered.borrow_mut().insert((id, idle), bears.is_some());
        bears.is_some()
    }

    /// Whether each way to an update, and to where the state begins to say that the filter runs, comes by a reset, or finds the state
    /// saying so.
    fn resets_before_running(&self, memory: Memory<'_>) -> bool {
        let unreset = self.reached(|node, edge| !self.resets(node) && !self.finds(memory, memory.running, node, edge));
        let updating = self.search.updating();
        // `self.active = true; f.reset();`
        let is_reset_behind = |node: NodeId| {
            let free = |node: NodeId, _: usize| !self.resets(node);
            let reached = self.reached_from(node, free);
            !updating.iter().any(|update| reached[update.0 as usize]) && !self.completes(node, free)
        };
        let mut starting = self.giving(memory, memory.running).into_iter();
        !updating.iter().any(|node| unreset[node.0 as usize])
            && starting.all(|node| !unreset[node.0 as usize] || is_reset_behind(node))
    }

    /// Whether the state says after each update that the filter runs, and where it says that it does not, the filter was reset.
    fn resets_behind_running(&self, memory: Memory<'_>) -> bool {
        let Memory { idle, running, .. } = memory;
        let stopping = self.giving(memory, idle);
        let mut starting = self.giving(memory, running);
        starting.retain(|node| !stopping.contains(node));
        let updating = self.search.updating();
        let unsaid = |node: NodeId, edge: usize| !starting.contains(&node) && !self.finds(memory, running, node, edge);
        let before = self.reached(unsaid);
        let is_said = |node: &NodeId| !before[node.0 as usize] || !self.completes(*node, unsaid);
        let free = |node: NodeId, _: usize| !self.resets(node);
        let unreset = self.reached(|node, edge| free(node, edge) && !self.finds(memory, idle, node, edge));
        let is_reset = |stop: NodeId| {
            let is_behind = |node: &NodeId| self.reached_from(*node, free)[stop.0 as usize];
            !(unreset[stop.0 as usize] || updating.iter().any(is_behind)) || !self.completes(stop, free)
        };
        let goes_on = |stop: NodeId| {
            let reached = self.reached_from(stop, |node, _| !starting.contains(&node));
            updating.iter().any(|node| reached[node.0 as usize])
        };
        updating.iter().all(is_said) && stopping.into_iter().all(|stop| is_reset(stop) && !goes_on(stop))
    }

    /// The nodes that may give the state one of these heads.
    fn giving(&self, memory: Memory<'_>, heads: u32) -> Vec<NodeId> {
        let graph = self.search.graph;
        let subject = &graph.subjects[memory.id.0 as usize];
        let gives = |node: &NodeId| match self.head_given(memory.place, *node) {
            Some(head) => subject.bit(head) & heads != 0,
            None => true,
        };
        let writers = self.search.writers_of(memory.id);
        writers.iter().copied().filter(|node| self.is_inside(*node)).filter(gives).collect()
    }

    /// The head that a node gives the state, if it is always the same one.
    fn head_given(&self, place: &Place, node: NodeId) -> Option<&Head> {
        match &self.search.graph.node(node).effect {
            Effect::Set(set) | Effect::Write(set) if set.place == *place => set.head.as_ref(),
            _ => None,
        }
    }

    /// The heads that a node may give the state, as far as they are known.
    fn heads_given(&self, place: &Place, node: NodeId) -> Vec<&Head> {
        let Effect::Call(site) = &self.search.graph.node(node).effect else {
            return self.head_given(place, node).into_iter().collect();
        };
        let summaries = site.targets.iter().filter_map(|target| self.search.summaries.get(*target));
        let sets = summaries.flat_map(|summary| &summary.sets);
        let own = sets.filter(|(set, ..)| place_of(set, site).is_some_and(|set| set == *place));
        own.filter_map(|(_, head, _)| head.as_ref()).collect()
    }

    /// Whether an edge is taken only where the state has one of these heads.
    fn finds(&self, memory: Memory<'_>, heads: u32, node: NodeId, edge: usize) -> bool {
        let graph = self.search.graph;
        let Effect::Branch(test) = &graph.node(node).effect else { return false };
        let found = if edge == 0 { test.holds } else { test.fails };
        test.subject == Some(memory.id) && found & graph.subjects[memory.id.0 as usize].anything() & !heads == 0
    }
}
