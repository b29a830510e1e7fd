//! Gates by states of the elements of a collection, each of which has its own: `for channel in &mut bank { channel.count += 1; if
//! channel.count == 10 { channel.count = 0; channel.filter.update(x); } }`. What an iteration is to other filters is the round to an
//! element's, so that the round is judged as one.

use super::{Gates, Way};
use crate::count::fed::named;
use crate::count::given::place_of;
use crate::count::search::{End, Region, Search};
use crate::count::verdict::Gate;
use crate::flow::{CallSite, Cause, Effect, IndexKey, LoopId, NodeId, Place, Projection, Var};
use crate::index::Ty;

/// How many copies are followed to the value that they are of.
const MAX_COPIES: u32 = 4;

impl Gates<'_, '_> {
    /// Why a way skips that is decided in a loop over the elements, by a state of the element or by the clock of its step.
    pub(super) fn of_element(&self, end: &End, way: &Way) -> Option<Gate> {
        let graph = self.search.graph;
        let is_over_elements = |id: &LoopId| self.search.covers(*id) && self.region != Region::Loop(*id);
        let id = graph.loops_around(way.at).find(is_over_elements).filter(|id| !self.is_left_early(*id))?;
        let own = Self { is_of_element: true, is_helper: self.is_helper, ..Self::new(self.search, Region::Loop(id)) };
        let at = way.nodes.iter().position(|node| *node == way.at)?;
        let is_head = |node: &NodeId| *node == graph.loop_info(id).head;
        let begins = way.nodes[..at].iter().rposition(is_head)?;
        let ends = way.nodes[at..].iter().position(is_head).map_or(way.nodes.len(), |behind| at + behind + 1);
        let round = Way { nodes: way.nodes[begins..ends].to_vec(), at: way.at, left_at: way.left_at };
        let gate = match &graph.node(way.at).effect {
            Effect::Branch(test) => {
                let gate = own.of_branch(test, way.at, &round);
                let gate = gate.filter(|gate| self.asks_element(&own, &test.about.reads, *gate));
                match gate.and_then(|gate| self.changes_elements(&own, &test.about.reads, gate)) {
                    Some(outer) => test.subject.filter(|id| outer.is_mode_of_element(*id)).map(|_| Gate::Mode),
                    None => gate,
                }
            }
            Effect::Call(site) => self.of_call_in_round(&own, site, end, &round),
            _ => None,
        };
        let whole = || {
            let steps = &self.search.instance.steps;
            let each = steps.iter().rposition(|step| step.key().is_some())?;
            Some(Place { base: self.search.instance.base, steps: steps[..=each].into() })
        };
        let is_measured =
            || own.is_measured(&round) && whole().is_some_and(|element| !self.is_written_beside(&own, &element));
        // What a helper finds as it is may be changed by its caller, who is not asked for elements.
        gate.filter(|gate| !self.is_helper || matches!(gate, Gate::Rate | Gate::Time))
            .filter(|gate| !own.loses_time(*gate, &round))
            .or_else(|| is_measured().then_some(Gate::Measured))
    }

    /// The same for a helper that does not update.
    fn of_call_in_round(&self, own: &Self, site: &CallSite, end: &End, round: &Way) -> Option<Gate> {
        match end.state.helper_gate {
            Some(gate @ (Gate::Mode | Gate::Startup)) => {
                let is_left = |place: Place| !self.is_written_beside(own, &place);
                let mut kept =
                    own.modes_of(site).into_iter().map(|mode| place_of(mode.place(), site).is_some_and(is_left));
                kept.all(|is_kept| is_kept).then(|| own.gate_left(site, round.at, gate))?
            }
            Some(_) => None,
            None => {
                let asked = own.asked_in(site, round)?;
                let gate = own.of_call(site, round.at, round, false);
                let gate = gate.filter(|gate| self.asks_element(own, &asked, *gate))?;
                if self.changes_elements(own, &asked, gate).is_some() {
                    let what = "how their states change between two blocks of samples".to_owned();
                    self.between.replace(Some(Cause::Code(what)));
                    return None;
                }
                Some(gate)
            }
        }
    }

    /// Whether a condition reads nothing but states of the element, which the rest of the iteration leaves alone, and settings; for
    /// the time, whatever is the same for all elements. What pauses a filter may not be ended by another method of the owner.
    fn asks_element(&self, own: &Self, reads: &[Place], gate: Gate) -> bool {
        let is_kept = |place: &Place| self.search.aliases.shared_roots(place).iter().all(|root| self.outlives(root));
        let is_pause = matches!(gate, Gate::Mode | Gate::Startup);
        let is_state = |place: &Place| {
            own.is_state_of_element(place)
                && is_kept(place)
                && !self.is_written_beside(own, place)
                && !(is_pause && self.is_written_elsewhere(place, &|_| true))
                && !(gate == Gate::Config && self.is_changed_in_rounds(own, place))
        };
        let is_setting =
            |place: &Place| if gate == Gate::Time { own.is_setting(place) } else { self.is_setting(place) };
        // Of `bank[i].is_on` the bank is noted as well, and the number.
        let is_bound = |place: &Place| place.base_var().is_some_and(|var| own.binds(var));
        let is_number = |place: &Place| {
            let is_plain = place.steps.is_empty() && is_bound(place) && self.ty(place) == Some(Ty::Int);
            is_plain && !own.is_state_of_element(place)
        };
        let reads: Vec<&Place> = named(reads).into_iter().filter(|place| !is_number(place)).collect();
        reads.iter().any(|place| is_state(place)) && reads.into_iter().all(|place| is_state(place) || is_setting(place))
    }

    /// A cycle around this one that changes what is the same for an element in all iterations of this one.
    fn changes_elements(&self, own: &Self, reads: &[Place], gate: Gate) -> Option<&Self> {
        let keeps = |outer: &&Self| outer.asks_element(own, reads, gate);
        self.around().iter().filter(|_| gate == Gate::Config).find(|outer| !keeps(outer))
    }

    /// Whether a loop may be left in the midst of a round.
    fn is_left_early(&self, id: LoopId) -> bool {
        let graph = self.search.graph;
        let is_within = |node: NodeId| graph.is_within(graph.node(node).in_loop, id);
        let leaves = |node: NodeId| graph.node(node).next.iter().any(|next| !is_within(*next));
        graph.node_ids().any(|node| is_within(node) && node != graph.loop_info(id).head && leaves(node))
    }

    /// Whether something in the iteration writes a place of an element outside the loop over these.
    fn is_written_beside(&self, own: &Self, place: &Place) -> bool {
        let aliases = self.search.aliases;
        let roots = aliases.shared_roots(place);
        let is_it = |written: &Place| {
            aliases.shared_roots(written).iter().any(|written| roots.iter().any(|root| root.overlaps(written)))
        };
        self.nodes().filter(|node| !own.is_inside(*node)).any(|node| match &self.search.graph.node(node).effect {
            Effect::Write(write) | Effect::Set(write) => !write.rebinds && is_it(&write.place),
            Effect::Call(site) => self.written_by(site).any(|written| is_it(&written)),
            Effect::Unknown { places, .. } => places.iter().any(is_it),
            _ => false,
        })
    }

    /// Whether the rounds give a state of their elements what is the same for all of them, but not in each iteration:
    /// `for channel in &mut bank { channel.is_on = level > 1.0; … }`.
    fn is_changed_in_rounds(&self, own: &Self, place: &Place) -> bool {
        let graph = self.search.graph;
        let aliases = self.search.aliases;
        let roots = aliases.shared_roots(place);
        let is_it = |written: &Place| {
            aliases.shared_roots(written).iter().any(|written| roots.iter().any(|root| root.overlaps(written)))
        };
        own.nodes().any(|node| match &graph.node(node).effect {
            // An element that gets a name is not written.
            Effect::Write(write) | Effect::Set(write) => {
                !write.rebinds && is_it(&write.place) && !self.gives_setting(own, node, 0)
            }
            Effect::Call(site) => self.written_by(site).any(|written| is_it(&written)),
            Effect::Unknown { places, .. } => places.iter().any(is_it),
            _ => false,
        })
    }

    /// Whether a node in a round gives what is the same in every iteration.
    fn gives_setting(&self, own: &Self, node: NodeId, copies: u32) -> bool {
        let graph = self.search.graph;
        let (Effect::Set(set) | Effect::Write(set)) = &graph.node(node).effect else { return false };
        if set.head.is_some() {
            return own.nodes().filter(|branch| self.search.decides(*branch, node)).all(|branch| {
                match &graph.node(branch).effect {
                    Effect::Branch(test) => test.about.is_constant || self.is_unchanging(test),
                    _ => true,
                }
            });
        }
        if let Some(from) = graph.copied(node) {
            let mut given = self.assignments().of(&from).iter().copied().peekable();
            let is_made = copies < MAX_COPIES && !self.outlives(&from) && given.peek().is_some();
            return self.is_invariant(&from, 0) || (is_made && given.all(|id| self.gives_setting(own, id, copies + 1)));
        }
        graph.changes.get(&node).is_some_and(|change| {
            let places = named(&change.computed.places);
            !places.is_empty() && places.into_iter().all(|place| self.is_invariant(place, 0))
        })
    }

    /// Whether a place lies in the element of the round, by the name that the loop gives it or by its number.
    pub(super) fn is_state_of_element(&self, place: &Place) -> bool {
        let Region::Loop(id) = self.region else { return false };
        let graph = self.search.graph;
        let is_lent = |var: Var| matches!(graph.var(var).ty, Ty::Ref(..));
        let by_name = |var: Var| (!place.steps.is_empty() || is_lent(var)) && self.is_element_of(id, var);
        let is_number = |key: &IndexKey| matches!(key, IndexKey::Var(var) if self.binds(*var));
        place.base_var().is_some_and(by_name) || place.steps.iter().filter_map(Projection::key).any(is_number)
    }

    /// Whether the head of the loop binds a variable.
    pub(super) fn binds(&self, var: Var) -> bool {
        matches!(self.region, Region::Loop(id) if self.search.graph.loop_info(id).bound.contains(&var))
    }

    /// Whether a variable names the element of a loop in each round: `channel` in `for (number, channel) in bank.iter_mut().enumerate()`.
    pub(super) fn is_element_of(&self, id: LoopId, var: Var) -> bool {
        let Search { graph, aliases, .. } = self.search;
        let info = graph.loop_info(id);
        let is_named_after = |item: &Var| var == *item || aliases.is_derived(var, &[*item]);
        let is_element =
            |root: &Place| root.base_var() != Some(var) && root.steps.last().is_some_and(|step| step.key().is_some());
        let is_part = || {
            let roots = aliases.roots(&Place::var(var));
            info.bound.iter().any(is_named_after) && !roots.is_empty() && roots.iter().all(is_element)
        };
        info.items.iter().any(|(item, _)| is_named_after(item)) || is_part()
    }

    /// Whether a node gives the element of the round its name, and no value: `for (filter, count) in filters.iter_mut().zip(&mut counts)`.
    pub(super) fn names_element(&self, id: NodeId) -> bool {
        let graph = self.search.graph;
        let var = match &graph.node(id).effect {
            Effect::Set(set) if set.rebinds && set.from.is_some() && set.place.steps.is_empty() => set.place.base_var(),
            _ => None,
        };
        self.is_of_element && var.is_some_and(|var| self.binds(var) && matches!(graph.var(var).ty, Ty::Ref(..)))
    }

    /// The last name of a place.
    pub(super) fn last_name(&self, place: &Place) -> String {
        match place.steps.last() {
            Some(Projection::Field(name)) => name.to_string(),
            // Of `last[i]`, the collection has the name.
            Some(Projection::Index(_)) => self.last_name(&place.up_to(place.steps.len() - 1)),
            Some(Projection::Channel(_)) => String::new(),
            None => place.base_var().map(|var| self.search.graph.var(var).name.clone()).unwrap_or_default(),
        }
    }
}
