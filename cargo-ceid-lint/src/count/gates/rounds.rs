//! Gates of inner loops: those that may have no round, and those whose rounds all end without an update.

use super::sources::is_arithmetic;
use super::{Gates, Way};
use crate::count::fed::named;
use crate::count::search::Region;
use crate::count::verdict::Gate;
use crate::flow::{Computed, Effect, Limit, LoopId, NodeId, Place, Test};
use crate::index::Ty;

impl Gates<'_, '_> {
    /// `if n > 0 { n -= 1; continue; } if f.update(x) > LIMIT { n = 50; }`: an iteration may update and leave the count as it is, so
    /// that something else than the count decides when it begins anew.
    pub(super) fn is_held_off(&self, place: &Place) -> bool {
        let goes_by = |node: NodeId, _: usize| match &self.search.graph.node(node).effect {
            Effect::Call(site) => !self.call_writes(site, place),
            Effect::Unknown { places, .. } => !places.iter().any(|other| other.overlaps(place)),
            _ => !self.is_set_back(node, place),
        };
        // A gate whose count has run out begins anew, whatever is asked beside that.
        let is_armed =
            |id: NodeId| self.branch_before(id).is_some_and(|(test, _)| !self.behind(test).places.contains(place));
        let mut set_back = self.assigning(place).filter(|id| self.is_set_back(*id, place));
        // A filter that starts anew after the pause is in a mode.
        if !set_back.all(is_armed) || self.nodes().any(|id| self.resets(id)) {
            return false;
        }
        let reached = self.reached(goes_by);
        let updating = self.search.updating();
        updating.iter().any(|id| self.is_inside(*id) && reached[id.0 as usize] && self.completes(*id, goes_by))
    }

    /// Whether what a condition reads tells which round of a loop over samples it is, and another filter gets the sample on the way:
    /// `for (channel, x) in frame.iter_mut().enumerate() { if channel == 0 { *x = left.update(*x); } else { *x = right.update(*x); } }`.
    pub(super) fn shares_rounds(&self, reads: &[Place], way: &Way) -> bool {
        let graph = self.search.graph;
        let Region::Loop(id) = self.region else { return false };
        let info = graph.loop_info(id);
        let Some((counter, _)) = info.counter else { return false };
        let is_number = |place: &Place| self.ty(place) == Some(Ty::Int);
        // A sample that is found by the number tells no round, nor does what is asked of it.
        let is_of_numbers = |place: &Place| match (self.ty(place), place.base_var()) {
            (Some(Ty::Bool), Some(var)) => {
                let computed = graph.computed.get(&var);
                computed.is_some_and(|computed| named(&computed.places).into_iter().all(is_number))
            }
            (ty, _) => ty != Some(Ty::Float),
        };
        let is_round = |place: &Place| {
            place.steps.is_empty()
                && place.base_var().is_some_and(|var| self.search.aliases.is_derived(var, &[counter]))
                && is_of_numbers(place)
        };
        let from_round = self.search.aliases.derived_from(&info.bound);
        let updates_other = |node: &NodeId| match &graph.node(*node).effect {
            Effect::Update(update) => {
                !self.is_instance(&update.place) && update.fed.iter().any(|var| from_round.contains(*var))
            }
            Effect::Call(site) => {
                site.fed.iter().any(|var| from_round.contains(*var))
                    && self.search.summaries.updates(site).any(|place| !self.is_instance(&place))
            }
            _ => false,
        };
        !reads.is_empty() && reads.iter().all(is_round) && way.nodes.iter().any(updates_other)
    }

    /// Whether places tell what a round of the loop is about: which one of few things, or whose value it is that comes with it.
    /// `for number in 0..4 { if let Some(value) = changed[number].take() { self.set(number, value); } }`
    pub(super) fn tells_rounds(&self, places: &[Place]) -> bool {
        let Region::Loop(id) = self.region else { return false };
        let info = self.search.graph.loop_info(id);
        let is_counter = |place: &Place| {
            let var = place.base_var().filter(|_| place.steps.is_empty());
            info.has_few_rounds() && info.counter.is_some_and(|(counter, _)| var == Some(counter))
        };
        let is_tag = |place: &Place| {
            let is_reading = matches!(self.ty(place).as_ref().map(Ty::peel), Some(Ty::Bool | Ty::Float));
            place.steps.is_empty() && !is_reading && self.is_bound_beside_sample(place)
        };
        !places.is_empty() && places.iter().all(|place| is_counter(place) || is_tag(place))
    }

    /// Whether a remainder or mask is asked of nothing but the number that an element has, counted anew in each iteration:
    /// `for (i, f) in bank.iter_mut().enumerate().filter(|(i, _)| i % 2 == 0)`. It is the same in all iterations.
    pub(super) fn asks_which_element(&self, test: &Test) -> bool {
        let about = &test.about;
        if !about.is_remainder && !about.is_masked {
            return false;
        }
        let graph = self.search.graph;
        let sources = self.behind(test);
        let is_covered = |id: LoopId| self.region != Region::Loop(id) && self.search.covers(id);
        let covered: Vec<LoopId> = (0u32..).map(LoopId).take(graph.loops.len()).filter(|id| is_covered(*id)).collect();
        let is_within = |node: NodeId| graph.loops_around(node).any(|id| covered.contains(&id));
        let is_of_element = |place: &&Place| {
            self.is_own_number(place)
                || covered
                    .iter()
                    .any(|id| place.base_var().is_some_and(|var| graph.loop_info(*id).bound.contains(&var)))
                || graph.node_ids().any(|node| is_within(node) && self.counts_at(node, place))
        };
        let numbers: Vec<&Place> = sources.places.iter().filter(|place| self.ty(place) == Some(Ty::Int)).collect();
        sources.calls.iter().all(|name| is_arithmetic(name))
            && !numbers.iter().any(|place| self.outlives(place))
            && numbers.iter().any(is_of_element)
    }

    /// An inner loop that may have no round: over samples that are there or not.
    pub(super) fn of_loop(&self, id: LoopId) -> Option<Gate> {
        let info = self.search.graph.loop_info(id);
        // A helper's own loop over samples has no round where there is no sample.
        let is_own = self.search.sample_loops.contains(&id);
        (info.drains || is_own || self.feeds_any(&info.bound)).then_some(Gate::Sample)
    }

    /// Whether a way is taken where a number is zero that says how many samples there are: the loops over them would have no round.
    /// `let n = block.len(); if n == 0 { return; } for i in 0..n { out[i] = f.update(block[i]); }`
    pub(super) fn has_no_samples(&self, test: &Test, at: NodeId, way: &Way) -> bool {
        let graph = self.search.graph;
        let about = &test.about;
        let [number] = about.reads.as_slice() else { return false };
        let is_zero = about.heads == ["0"] && !about.is_comparison;
        let is_below_one =
            about.is_comparison && about.numbers == [1] && about.compared == [Some(number.clone()), None];
        let holds = way.after(at) == graph.node(at).next.first().copied();
        let is_asked =
            holds && (is_zero || is_below_one) && about.names.is_empty() && !about.is_remainder && !about.is_masked;
        if !is_asked || self.ty(number).is_some_and(|ty| ty != Ty::Int) || self.assigning(number).count() > 1 {
            return false;
        }
        // The collections of which it is the length.
        let computed = number.base_var().filter(|_| number.steps.is_empty()).and_then(|var| graph.computed.get(&var));
        let is_length = |computed: &&Computed| {
            let mut calls = computed.calls.iter().map(String::as_str);
            computed.calls.iter().any(|name| name == "len") && calls.all(|name| matches!(name, "len" | "min"))
        };
        let is_collection = |place: &&Place| self.ty(place) != Some(Ty::Int);
        let made = computed.filter(is_length).map(|made| named(&made.places)).unwrap_or_default();
        let counted: Vec<&Place> = made.into_iter().filter(is_collection).collect();
        let goes_over = |id: LoopId, place: &Place| {
            let info = graph.loop_info(id);
            info.over.as_ref() == Some(place) || info.limits.contains(&Limit::Elements(place.clone()))
        };
        let ends = |id: LoopId| {
            let is_up_to = graph.loop_info(id).limits.contains(&Limit::Held(number.clone()));
            is_up_to || !counted.is_empty() && counted.iter().all(|place| goes_over(id, place))
        };
        let is_inner = |id: &LoopId| self.region != Region::Loop(*id) && self.is_inside(graph.loop_info(*id).head);
        let has_none = |node: &NodeId| {
            let mut around = graph.loops_around(*node).filter(is_inner);
            around.any(|id| ends(id) && self.of_loop(id).is_some())
        };
        let is_of_all = || !counted.is_empty() && counted.iter().all(|place| self.fed().places.contains(place));
        let mut updating = self.search.updating().into_iter().filter(|id| self.is_inside(*id)).peekable();
        updating.peek().is_some() && updating.all(|node| has_none(&node) || is_of_all())
    }

    /// A loop over the elements that counts to a number: whether that is larger than the number of an element never changes, or it
    /// is no gate.
    pub(super) fn of_number(&self, id: LoopId) -> Option<Gate> {
        let is_settled = |limit: &Limit| match limit {
            Limit::Held(place) | Limit::UpTo(place) => self.is_invariant(place, 0),
            _ => true,
        };
        self.search.graph.loop_info(id).limits.iter().all(is_settled).then_some(Gate::Config)
    }

    /// An inner loop whose rounds all end without an update, or without what leads to it: `for _ in 0..3 { if let Ok(z) = imu.read() { …;
    /// break } }`. It skips for what every one of them waits for.
    pub(super) fn of_rounds(&self, id: LoopId, way: &Way) -> Option<Gate> {
        let graph = self.search.graph;
        let info = graph.loop_info(id);
        let is_within = |node: NodeId| graph.is_within(graph.node(node).in_loop, id);
        let inside = self.search.reach(Region::Loop(id));
        // What the loop is left with may lead to the update behind it: `for _ in 0..3 { if let Ok(z) = imu.read() { break 'read z } }`.
        let updating = self.search.updating();
        let behind = |node: NodeId| {
            let reached = self.reached_from(node, |from, edge| graph.node(from).next[edge] != info.head);
            updating.iter().any(|update| reached[update.0 as usize])
        };
        let is_behind = !updating.iter().any(|node| is_within(*node));
        let reach = |node: NodeId| if is_behind { behind(node) } else { inside[node.0 as usize] };
        let mut found: Option<Gate> = None;
        let mut is_decided = true;
        for (at, next) in way.steps() {
            if *at == info.head {
                // The round before it updated nothing, for no reason that is known.
                if !std::mem::replace(&mut is_decided, !is_within(*next)) {
                    return None;
                }
                continue;
            }
            if !is_within(*at) || is_decided || !reach(*at) || (is_within(*next) && reach(*next)) {
                continue;
            }
            let Effect::Branch(test) = &graph.node(*at).effect else { return None };
            let gate = self.of_branch(test, *at, way)?;
            if *found.get_or_insert(gate) != gate {
                return None;
            }
            is_decided = true;
        }
        found
    }
}
