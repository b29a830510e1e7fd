//! Options that are left empty on purpose: `let chosen = if is_armed() { filter.as_mut() } else { None };`

use std::collections::{BTreeMap, BTreeSet};

use super::{Gates, MAX_ORIGINS, Way};
use crate::count::verdict::Gate;
use crate::flow::{Effect, NodeId, Place, Test};
use crate::index::Ty;

/// Why an option may be empty.
#[derive(Debug, Default)]
struct Choices {
    /// The branches at which that is decided, each with its successor.
    made: BTreeSet<(NodeId, NodeId)>,
    /// Whether a value is taken over that may be absent itself.
    takes_over: bool,
}

impl Gates<'_, '_> {
    /// What a question waits for whose option may be empty by choice: each choice has to wait for something. `None` if there is no
    /// choice.
    pub(super) fn of_choices(&self, test: &Test, at: NodeId, way: &Way, origins: u32) -> Option<Option<Gate>> {
        let graph = self.search.graph;
        let asked = graph.subjects[test.subject?.0 as usize].whole.as_ref().filter(|_| test.about.is_presence)?;
        let mut choices = Choices::default();
        self.add_choices(asked, at, 0, &|head| head == "-", &mut choices)?;
        self.of_made(choices, test, at, way, origins)
    }

    /// The same for a truth value that the iteration makes: `let mut fresh = false; if let Some(z) = read() { fix = z; fresh = true; }`.
    pub(super) fn of_flag(&self, test: &Test, at: NodeId, way: &Way, origins: u32) -> Option<Gate> {
        let graph = self.search.graph;
        let asked = graph.subjects[test.subject?.0 as usize].whole.as_ref()?;
        if self.ty(asked) != Some(Ty::Bool) || origins >= MAX_ORIGINS {
            return None;
        }
        let opens = self.heads_past(test, at, way);
        let mut choices = Choices::default();
        self.add_choices(asked, at, 0, &|head| !opens.iter().any(|open| open == head), &mut choices)?;
        self.of_made(choices, test, at, way, origins).flatten().filter(|_| !opens.is_empty())
    }

    /// What all of some choices wait for.
    fn of_made(&self, choices: Choices, test: &Test, at: NodeId, way: &Way, origins: u32) -> Option<Option<Gate>> {
        let graph = self.search.graph;
        if choices.made.is_empty() {
            return None;
        }
        // What may be absent for another reason is no pause there.
        let is_only = choices.made.len() == 1 && !choices.takes_over;
        let mut found = choices.takes_over.then(|| self.of_test(test, at, way));
        for (branch, next) in choices.made {
            let Effect::Branch(origin) = &graph.node(branch).effect else { return None };
            let own = self.way_by(branch, next, at, way);
            let way = if is_only { Way { left_at: way.left_at, ..own } } else { own };
            // A filter on the sample itself lets pass what is one.
            let is_of_sample = || {
                // A function has its reasons to give none, or not to fill what it is lent.
                (self.asks_only_sample(origin) || self.is_read_in_place(branch)) && self.lacks_sample(test, at, &way)
            };
            let gate = self.of_condition(origin, branch, &way, origins + 1);
            let gate = gate.or_else(|| is_of_sample().then_some(Gate::Sample));
            // Of what is zipped, each part has to be fed.
            let is_zipped = || test.about.names.iter().any(|name| name == "zip");
            let gate = gate.filter(|gate| *gate != Gate::Sample || !is_zipped() || self.feeds_sample(test));
            // What is always so tells less than what waits.
            found = match found {
                None | Some(Some(Gate::Config)) => Some(gate),
                Some(found) => Some(found.filter(|_| gate.is_some())),
            };
        }
        found
    }

    /// What the conditions wait for that gave a truth value which is asked for: each of several has to wait for something, as in
    /// `let due = n % 10 == 0 && is_armed;`.
    pub(super) fn of_origin(
        &self,
        (origin, chosen_at, given_at): (&Test, NodeId, NodeId),
        at: NodeId,
        way: &Way,
        origins: u32,
    ) -> Option<Gate> {
        let graph = self.search.graph;
        // `fn warm(&mut self) -> bool { self.rounds += 1; self.rounds > 100 }`
        let is_warm_up = |origin, by: &Way| self.is_told_warm_up(origin, at, by).then_some(Gate::Startup);
        let gate = self.of_condition(origin, chosen_at, way, origins + 1);
        let gate = gate.or_else(|| is_warm_up((origin, chosen_at), way))?;
        let mut leading = self.leading_to(given_at).unwrap_or_default();
        let is_of_caller = |branch: &NodeId| match &graph.node(*branch).effect {
            Effect::Branch(test) => self.asks_caller(&test.about.reads),
            _ => false,
        };
        // What is always so is no reason where something else decides whether it is asked: `x > 3.0 || settings.is_on`.
        if gate == Gate::Config {
            let steps = way.steps();
            let asked_for_it = steps.filter(|(id, _)| {
                let decides = |node| self.search.decides(**id, node);
                matches!(graph.node(**id).effect, Effect::Branch(_)) && decides(chosen_at) && !decides(at)
            });
            leading.extend(asked_for_it.map(|(id, next)| (*id, *next)));
        }
        leading.retain(|(branch, _)| *branch != chosen_at && !is_of_caller(branch));
        let others = leading.into_iter().map(|(branch, next)| match &graph.node(branch).effect {
            Effect::Branch(test) => {
                let by = self.way_by(branch, next, at, way);
                let gate = self.of_condition(test, branch, &by, origins + 1);
                gate.or_else(|| is_warm_up((test, branch), &by))
            }
            _ => None,
        });
        let others: Vec<Gate> = others.collect::<Option<_>>()?;
        // What is always so tells less than what waits.
        others.into_iter().find(|_| gate == Gate::Config).or(Some(gate))
    }

    /// Whether a gate explains the skip alone. What is always so does not where something else decides whether it is asked, behind
    /// which the filter runs otherwise: `if x > 3.0 || self.is_on { filter.update(x); }`.
    pub(super) fn is_reason(&self, gate: Gate, at: NodeId, way: &Way) -> bool {
        if gate != Gate::Config {
            return true;
        }
        let graph = self.search.graph;
        let updating = self.search.updating();
        let runs_behind = |id: NodeId| {
            let reached =
                self.search.reached_from(self.region, id, |from, edge| graph.node(from).next.get(edge) != Some(&at));
            updating.iter().any(|update| *update == id || reached[update.0 as usize])
        };
        let runs_otherwise = |id: NodeId, next: NodeId| {
            let others = graph.node(id).next.iter().filter(|other| **other != next);
            others.into_iter().any(|other| self.is_inside(*other) && runs_behind(*other))
        };
        // A filter that is not there is owed nothing, whatever asks for it.
        let own = self.search.instance;
        let is_absent = || match &graph.node(at).effect {
            Effect::Branch(test) => test.subject.is_some_and(|id| {
                let whole = graph.subjects[id.0 as usize].whole.as_ref();
                whole.is_some_and(|whole| own.lies_at(whole))
            }),
            _ => false,
        };
        is_absent()
            || way.steps().take_while(|(id, _)| **id != at).all(|(id, next)| match &graph.node(*id).effect {
                Effect::Branch(test) if self.search.decides(*id, at) && runs_otherwise(*id, *next) => {
                    self.of_condition(test, *id, &self.way_by(*id, *next, at, way), 1).is_some()
                }
                _ => true,
            })
    }

    /// Whether a helper asks for a state that only its caller changes: whether that pauses the filter on purpose is not told here.
    pub(super) fn asks_caller(&self, reads: &[Place]) -> bool {
        self.is_helper && reads.iter().any(|place| self.outlives(place) && self.is_left_alone(place))
    }

    /// Finds out why an option may be empty, or a truth value closed; `None` if it may be so for a reason that is not known.
    fn add_choices(
        &self,
        asked: &Place,
        at: NodeId,
        copies: u32,
        closes: &dyn Fn(&str) -> bool,
        found: &mut Choices,
    ) -> Option<()> {
        if self.outlives(asked) || copies > MAX_ORIGINS || !asked.steps.is_empty() || self.calls_write(asked) {
            return None;
        }
        let given: Vec<NodeId> = self.assigning(asked).collect();
        for id in &given {
            // What is taken out behind the question is there again when it is asked the next time: `for slot in slots.iter_mut()`.
            let lasts = self.reached_from(*id, |node, _| node == *id || !given.contains(&node));
            if !lasts[at.0 as usize] {
                continue;
            }
            let (Effect::Set(set) | Effect::Write(set)) = &self.search.graph.node(*id).effect else { return None };
            match (set.head.as_deref(), set.same_as) {
                (Some(head), _) if closes(head) => found.made.extend(self.deciding(*id, &given, at)?),
                (Some(_), _) => {}
                (None, Some(from)) if self.assigning(&Place::var(from)).next().is_some() => {
                    self.add_choices(&Place::var(from), *id, copies + 1, closes, found)?;
                }
                (None, _) => found.takes_over = true,
            }
        }
        Some(())
    }

    /// The branches that decide whether a place has the value at a question that a node gives it, each with its successor;
    /// `None` if none does.
    fn deciding(&self, id: NodeId, given: &[NodeId], at: NodeId) -> Option<Vec<(NodeId, NodeId)>> {
        let graph = self.search.graph;
        let stays = |node: NodeId| node != at && (node == id || !given.contains(&node));
        let kept = self.reached_from(id, |node, _| stays(node));
        let is_other = |node: &NodeId| *node != id && kept[node.0 as usize];
        if given.iter().any(is_other) {
            // `let mut chosen = None; if is_armed() { chosen = read(); }`
            let changes = |next: NodeId| {
                let reached = self.reached_from(next, |node, _| stays(node));
                given.iter().any(|other| other != &id && reached[other.0 as usize])
            };
            let asks = |node: &NodeId| matches!(graph.node(*node).effect, Effect::Branch(_)) && *node != at;
            let mut found = Vec::new();
            for branch in self.nodes().filter(|node| kept[node.0 as usize] && asks(node)) {
                let (changing, keeping): (Vec<NodeId>, Vec<NodeId>) =
                    graph.node(branch).next.iter().copied().partition(|next| changes(*next));
                if !changing.is_empty() {
                    found.extend(keeping.into_iter().map(|next| (branch, next)));
                }
            }
            return (!found.is_empty()).then_some(found);
        }
        self.leading_to(id)
    }

    /// The branches from which no other one lies before a node, each with its successor; `None` if an iteration comes there by none.
    pub(super) fn leading_to(&self, id: NodeId) -> Option<Vec<(NodeId, NodeId)>> {
        let graph = self.search.graph;
        let mut leading: BTreeMap<NodeId, Vec<NodeId>> = BTreeMap::new();
        for node in self.nodes() {
            for next in &graph.node(node).next {
                leading.entry(*next).or_default().push(node);
            }
        }
        let mut found = Vec::new();
        let mut seen = BTreeSet::from([id]);
        let mut open = vec![id];
        while let Some(node) = open.pop() {
            if node == self.start() {
                return None;
            }
            for before in leading.get(&node).into_iter().flatten() {
                match &graph.node(*before).effect {
                    Effect::Branch(_) => found.push((*before, node)),
                    _ => open.extend(seen.insert(*before).then_some(*before)),
                }
            }
        }
        (!found.is_empty()).then_some(found)
    }

    /// A way that takes a branch, and goes on from a later node as another way does.
    fn way_by(&self, branch: NodeId, next: NodeId, at: NodeId, way: &Way) -> Way {
        let mut nodes = self.path(self.start(), branch);
        nodes.extend(self.path(next, at));
        nodes.extend(way.nodes.iter().skip_while(|node| **node != at).skip(1));
        Way { nodes, at: branch, left_at: branch }
    }

    /// The shortest path between two nodes, with both; nothing but these if there is none.
    fn path(&self, from: NodeId, to: NodeId) -> Vec<NodeId> {
        let graph = self.search.graph;
        let mut before: BTreeMap<NodeId, NodeId> = BTreeMap::new();
        let mut open = std::collections::VecDeque::from([from]);
        while let Some(node) = open.pop_front().filter(|node| *node != to) {
            for next in graph.node(node).next.iter().filter(|next| self.is_inside(**next) && **next != from) {
                if !before.contains_key(next) {
                    before.insert(*next, node);
                    open.push_back(*next);
                }
            }
        }
        let mut path: Vec<NodeId> = std::iter::successors(Some(to), |node| before.get(node).copied()).collect();
        path.reverse();
        path
    }
}
