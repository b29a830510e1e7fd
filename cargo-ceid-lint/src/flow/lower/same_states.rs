//! Variables that hold what a state was: as long as that is not changed, a condition on the one is a condition on the other.

use std::collections::BTreeSet;

use rustc_hash::{FxHashMap, FxHashSet};

use super::Builder;
use super::subjects::{Pure, pure_place};
use crate::flow::OTHER_HEADS;
use crate::flow::{ControlFlowGraph, Effect, NodeId, Place, SubjectId, Test, Transfer, Var};
use crate::index::Ty;

/// A variable that is given a state at one node and nothing else anywhere: `let mode = self.mode;`
struct Held {
    at: NodeId,
    var: Var,
    state: Place,
    asked: SubjectId,
}

/// How often a state may be handed on from value to value until one is asked for it.
const MAX_HOPS: usize = 6;

/// A part of a value that was given a state.
struct HeldPart {
    asked: SubjectId,
    /// What holds the state, the part that is asked for first, and where each was given it.
    hops: Vec<(NodeId, Place)>,
    state: Place,
}

/// Where a graph asks for its subjects, and the ways that lead there.
pub(super) struct Questions {
    asking: FxHashMap<SubjectId, Vec<NodeId>>,
    before: Vec<Vec<NodeId>>,
}

impl Builder<'_> {
    /// Conditions on variables that hold a state, or a part of a value, ask for what they hold.
    pub(super) fn settle_held(&mut self) {
        let mut questions = Questions::of(&self.graph);
        self.settle_held_parts(&mut questions);
        self.settle_held_states(&mut questions);
        self.settle_held_values(&mut questions);
    }

    /// Conditions on a part of a value ask for the state that the part was given, where neither has changed since:
    /// `let t = (armed, hot); match t { (true, _) => … }`.
    fn settle_held_parts(&mut self, questions: &mut Questions) {
        let parts = held_parts(&self.graph);
        let is_asked_again = |part: &HeldPart, graph: &ControlFlowGraph| {
            let is_it = |state: &Place| *state == part.state;
            graph.subjects.iter().filter_map(|subject| subject.whole.as_ref()).any(is_it)
                || parts.iter().filter(|other| is_it(&other.state)).count() > 1
        };
        for part in &parts {
            if !is_asked_again(part, &self.graph) {
                continue;
            }
            let Some(asking) = questions.asking.get(&part.asked) else { continue };
            let mut at = asking.clone();
            let is_kept = part.hops.iter().all(|(given, place)| {
                let is_same = questions.is_same(&self.graph, &at, *given, std::slice::from_ref(place));
                at = vec![*given];
                is_same
            });
            let Some((first, _)) = part.hops.last().filter(|_| is_kept) else { continue };
            let value = pure_place(part.state.clone());
            self.ask_where(questions, part.asked, *first, std::slice::from_ref(&part.state), value);
        }
    }

    /// Conditions on a variable that holds a state ask for the state itself, where it is still what it was at each of them.
    fn settle_held_states(&mut self, questions: &mut Questions) {
        let held = held_states(&self.graph);
        let mut holders: FxHashMap<&Place, BTreeSet<Var>> = FxHashMap::default();
        for one in &held {
            holders.entry(&one.state).or_default().insert(one.var);
        }
        let asked: FxHashSet<Place> = self.graph.subjects.iter().filter_map(|subject| subject.whole.clone()).collect();
        for one in &held {
            if asked.contains(&one.state) || holders[&one.state].len() > 1 {
                let value = pure_place(one.state.clone());
                self.ask_where(questions, one.asked, one.at, std::slice::from_ref(&one.state), value);
            }
        }
    }

    /// Lets all that asks for a subject ask for another value with the same heads, if none of the places that it depends on has
    /// changed since a node at any of them; answers the subject that is asked then.
    pub(super) fn ask_where(
        &mut self,
        questions: &mut Questions,
        asked: SubjectId,
        since: NodeId,
        depends_on: &[Place],
        value: Pure,
    ) -> Option<SubjectId> {
        let graph = &self.graph;
        let asking = questions.asking.get(&asked)?;
        let is_exact = |id: &NodeId| match &graph.node(*id).effect {
            Effect::Branch(test) => test.fails == !test.holds || test.fails == u32::MAX,
            _ => false,
        };
        if !asking.iter().all(is_exact) || !questions.is_same(graph, asking, since, depends_on) {
            return None;
        }
        let subject = &graph.subjects[asked.0 as usize];
        let (heads, total) = (subject.heads.clone(), subject.total.clone());
        let other = self.subject(value, total);
        let bits: Vec<u32> = heads.iter().map(|head| self.head_bit(other, head)).collect::<Option<_>>()?;
        let asking = questions.asking.remove(&asked).unwrap_or_default();
        for id in &asking {
            let Effect::Branch(test) = &mut self.graph.nodes[id.0 as usize].effect else { continue };
            let own = (0u32..).zip(&bits).filter(|(number, _)| test.holds & (1 << number) != 0);
            let holds = own.fold(test.holds & OTHER_HEADS, |all, (_, bit)| all | bit);
            if test.fails != u32::MAX {
                test.fails = !holds;
            }
            (test.subject, test.holds) = (Some(other), holds);
        }
        questions.asking.entry(other).or_default().extend(asking);
        Some(other)
    }
}

impl Questions {
    pub(super) fn of(graph: &ControlFlowGraph) -> Self {
        let mut found = Self { asking: FxHashMap::default(), before: vec![Vec::new(); graph.nodes.len()] };
        for id in graph.node_ids() {
            let node = graph.node(id);
            if let Effect::Branch(Test { subject: Some(subject), .. }) = &node.effect {
                found.asking.entry(*subject).or_default().push(id);
            }
            for next in &node.next {
                found.before[next.0 as usize].push(id);
            }
        }
        found
    }

    /// Whether what was held at a node is certainly the same at all of these: on no way to them has one of the places changed that it
    /// depends on.
    fn is_same(&self, graph: &ControlFlowGraph, asking: &[NodeId], since: NodeId, places: &[Place]) -> bool {
        let mut open = asking.to_vec();
        let mut seen: FxHashSet<NodeId> = open.iter().copied().collect();
        while let Some(id) = open.pop() {
            if id == NodeId(0) {
                return false;
            }
            for before in &self.before[id.0 as usize] {
                if changes(graph, *before, since, places) {
                    return false;
                }
                if *before != since && seen.insert(*before) {
                    open.push(*before);
                }
            }
        }
        true
    }
}

/// The variables that hold a state, if no reference to the state is made that something may be written through.
fn held_states(graph: &ControlFlowGraph) -> Vec<Held> {
    let mut asked: FxHashMap<&Place, SubjectId> = FxHashMap::default();
    for (number, subject) in (0u32..).zip(&graph.subjects) {
        if let Some(place) = &subject.whole {
            asked.entry(place).or_insert(SubjectId(number));
        }
    }
    let given = times_given(graph);
    let mut handed_on: FxHashMap<Place, Vec<NodeId>> = FxHashMap::default();
    let mut returned: FxHashSet<Var> = FxHashSet::default();
    let lent = writable_loans(graph);
    for id in graph.node_ids() {
        if let Some(from) = graph.copied(id) {
            handed_on.entry(from).or_default().push(id);
        }
        if let Effect::Return(value) = &graph.node(id).effect {
            returned.extend(value.same_as);
        }
    }
    let mut held = Vec::new();
    for (at, state) in &graph.copies {
        let Effect::Set(set) = &graph.node(*at).effect else { continue };
        let Some(var) = set.place.base_var().filter(|_| set.place.steps.is_empty()) else { continue };
        let place = Place::var(var);
        let Some(asked) = asked.get(&place).copied() else { continue };
        let is_handed_on = handed_on.get(&place).is_some_and(|nodes| nodes.iter().any(|id| id != at));
        let is_simple = given.get(&var) == Some(&1)
            && !is_handed_on
            && !returned.contains(&var)
            && !lent.iter().any(|from| from.overlaps(state))
            && state.base_var().is_some();
        if is_simple {
            held.push(Held { at: *at, var, state: state.clone(), asked });
        }
    }
    held.sort_by_key(|held| held.at);
    held
}

/// The parts of values that are asked for and hold a state that has a name, if no reference is made through which one of them may be
/// written.
fn held_parts(graph: &ControlFlowGraph) -> Vec<HeldPart> {
    let asked = (0u32..).zip(&graph.subjects).filter_map(|(number, subject)| {
        let place = subject.whole.as_ref().filter(|place| !place.steps.is_empty() && place.base_var().is_some())?;
        Some((SubjectId(number), place))
    });
    let asked: Vec<(SubjectId, &Place)> = asked.collect();
    if asked.is_empty() {
        return Vec::new();
    }
    let mut given: FxHashMap<&Place, Vec<(NodeId, Place)>> = FxHashMap::default();
    for at in graph.node_ids() {
        if let (Effect::Set(set), Some(from)) = (&graph.node(at).effect, graph.copied(at))
            && !set.place.steps.is_empty()
        {
            given.entry(&set.place).or_default().push((at, from));
        }
    }
    let lent = writable_loans(graph);
    let is_lent = |place: &Place| lent.iter().any(|from| from.overlaps(place));
    let mut found = Vec::new();
    for (asked, place) in asked {
        let (mut state, mut hops) = (place, Vec::new());
        let is_named = |place: &Place| place.base_var().is_some_and(|var| !graph.var(var).name.is_empty());
        while let Some([(at, from)]) = given.get(state).map(Vec::as_slice)
            && (hops.is_empty() || !is_named(state))
            && hops.len() < MAX_HOPS
            && !is_lent(state)
        {
            hops.push((*at, state.clone()));
            state = from;
        }
        if !hops.is_empty() && is_named(state) && !is_lent(state) {
            found.push(HeldPart { asked, hops, state: state.clone() });
        }
    }
    found
}

/// The places to which references are made that something may be written through.
pub(super) fn writable_loans(graph: &ControlFlowGraph) -> Vec<&Place> {
    let is_writable = |to: Var| matches!(graph.var(to).ty, Ty::Ref(true, _));
    let lent = graph.nodes.iter().filter_map(|node| match &node.effect {
        Effect::Set(set) | Effect::Write(set) if set.transfer == Transfer::Borrow => {
            set.from.as_ref().filter(|_| set.place.base_var().is_some_and(is_writable))
        }
        _ => None,
    });
    lent.collect()
}

/// How many nodes give something to each variable or a part of it.
pub(super) fn times_given(graph: &ControlFlowGraph) -> FxHashMap<Var, usize> {
    let mut given = FxHashMap::default();
    for node in &graph.nodes {
        if let Effect::Set(set) | Effect::Write(set) = &node.effect
            && let Some(var) = set.place.base_var()
        {
            *given.entry(var).or_default() += 1;
        }
    }
    given
}

/// Whether what was held at a node may be another one behind this node.
fn changes(graph: &ControlFlowGraph, id: NodeId, since: NodeId, places: &[Place]) -> bool {
    let is_it = |place: &Place| places.iter().any(|held| place.overlaps(held));
    // What a cell holds is written by whoever has a reference to it, under whatever name.
    let is_in_cell = || graph.cells.read.iter().any(is_it);
    match &graph.node(id).effect {
        Effect::Call(_) | Effect::Unknown { .. } if is_in_cell() => true,
        Effect::Write(write) if !write.rebinds && is_in_cell() => true,
        Effect::Suspend => is_in_cell(),
        Effect::Set(set) | Effect::Write(set) => id != since && is_it(&set.place),
        Effect::Call(site) => {
            site.args.iter().filter(|arg| !arg.is_shared).filter_map(|arg| arg.place.as_ref()).any(is_it)
        }
        Effect::Unknown { places, .. } => places.iter().any(is_it),
        Effect::Update(update) => is_it(&update.place),
        Effect::Reset { place, .. } => is_it(place),
        Effect::Advance(_) | Effect::Fork => true,
        _ => false,
    }
}
