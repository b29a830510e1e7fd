//! Loops over samples inside another cycle: what stays as it is within one block may change from one block to the next, and is no
//! setting then: `loop { let is_on = button.is_up(); for x in adc.read() { if is_on { filter.update(x); } } }`.

use super::{Gates, Way};
use crate::count::functions::is_run_as_cycle;
use crate::count::search::{Mode, Region};
use crate::count::verdict::Gate;
use crate::flow::{Cause, Effect, LoopId, NodeId, Place, Rounds, Test};
use crate::index::Ty;

impl Gates<'_, '_> {
    /// The cycles around this one through which the filter lasts, the innermost first.
    pub(super) fn around(&self) -> &[Self] {
        self.around
            .get_or_init(|| self.regions_around().into_iter().map(|region| Self::new(self.search, region)).collect())
    }

    fn regions_around(&self) -> Vec<Region> {
        let search = self.search;
        let graph = search.graph;
        // The rounds of a loop over elements are judged with the iteration that they belong to.
        let Region::Loop(own) = self.region else { return Vec::new() };
        if self.is_of_element {
            return Vec::new();
        }
        let is_cycle = |id: &LoopId| graph.loop_info(*id).may_be_cycle();
        let loops = std::iter::successors(graph.loop_info(own).parent, |id| graph.loop_info(*id).parent);
        let mut regions: Vec<Region> = loops.filter(is_cycle).map(Region::Loop).collect();
        if regions.is_empty() && is_run_as_cycle(search.program, graph.function) {
            regions.push(Region::Function);
        }
        // What an iteration only lends a name to was there before, and so was what a loop goes over.
        let is_lent = || {
            search.instance.base_var().is_some_and(|var| match graph.var(var).ty {
                Ty::Ref(..) => true,
                Ty::Unknown => graph.loops.iter().any(|info| info.bound.contains(&var)),
                _ => false,
            })
        };
        regions.retain(|region| search.outlives(*region, search.instance) || is_lent());
        regions
    }

    /// Whether the filter has another name in each round of a cycle around this one, so that it is not followed from one block to the
    /// next: `for (channel, block) in channels.iter_mut().zip(blocks)`.
    fn loses_name(&self, outer: &Self) -> bool {
        !self.search.outlives(outer.region, self.search.instance)
    }

    /// What a condition waits for that has one value for all iterations: nothing, as far as it has the same one in the next block.
    pub(super) fn of_setting(&self, test: &Test, at: NodeId, way: &Way) -> Option<Gate> {
        let subject = test.subject.map(|id| &self.search.graph.subjects[id.0 as usize]);
        let asked = subject.map_or(&test.about.reads, |subject| &subject.reads);
        // A part of what a loop goes over is the same one in the next block.
        let is_part_left_alone = |outer: &Self, place: &Place| {
            let is_lent = place.base_var().is_some_and(|var| matches!(self.search.graph.var(var).ty, Ty::Ref(..)));
            let writes = |id: NodeId| match &self.search.graph.node(id).effect {
                Effect::Write(write) | Effect::Set(write) => !write.rebinds && write.place.overlaps(place),
                _ => false,
            };
            is_lent && !place.steps.is_empty() && !outer.nodes().any(writes) && !outer.calls_write(place)
        };
        let is_setting = |outer: &&Self| {
            outer.is_kept_flag(test)
                || outer.is_unchanging(test)
                || outer.asks_whether_set(test)
                || self.loses_name(outer) && asked.iter().all(|place| is_part_left_alone(outer, place))
        };
        match self.around().iter().find(|outer| !is_setting(outer)) {
            None => {
                let behind = self.behind(test).places;
                let mut places = test.about.reads.iter().chain(asked).chain(&behind);
                (!places.any(|place| self.is_written_between(place))).then_some(Gate::Config)
            }
            Some(outer) => {
                let gate = outer.of_condition(test, at, &outer.way_through(at, way), 0);
                let is_followed = !self.loses_name(outer) || !matches!(gate, None | Some(Gate::Mode));
                self.is_lost.set(self.is_lost.get() || !is_followed);
                gate.filter(|_| is_followed)
            }
        }
    }

    /// Why it is not known whether what changes between two blocks of samples resets the filter.
    pub(super) fn doubt_between(&self) -> Option<Cause> {
        let name = || self.search.graph.place_name(self.search.program.index, self.search.instance);
        let lost = || Cause::Code(format!("what becomes of `{}` between two blocks of samples", name()));
        self.between.take().or_else(|| self.is_lost.get().then(lost))
    }

    /// Whether the cycle that brings the samples over which this loop goes writes a place between two blocks, which is noted as a doubt.
    pub(super) fn is_written_between(&self, place: &Place) -> bool {
        let search = self.search;
        let (index, graph) = (search.program.index, search.graph);
        let is_of_samples =
            matches!(self.region, Region::Loop(own) if graph.loop_info(own).rounds != Rounds::Unbounded);
        if !is_of_samples || self.is_helper || self.is_of_element || self.lies_in_instance(place) {
            return false;
        }
        let places = [vec![place.clone()], search.aliases.roots(place)].concat();
        let writer = places.iter().find_map(|place| search.summaries.between.writer(index, graph, place));
        if let Some(writer) = writer {
            let (name, by) = (graph.place_name(index, place), index.function_name(writer));
            let what = format!("how `{by}` changes `{name}` between two blocks of samples");
            self.between.replace(Some(Cause::Code(what)));
        }
        writer.is_some()
    }

    /// Whether the filter is reset in each pause that a mode makes, also in one that lasts to the end of the block.
    pub(super) fn resets_in_pauses(&self, mode: Mode) -> bool {
        let search = self.search;
        let in_all = || {
            self.around().iter().all(|outer| {
                let is_lost = self.loses_name(outer);
                self.is_lost.set(self.is_lost.get() || is_lost);
                !is_lost && search.resets_in_pauses(outer.region, mode)
            })
        };
        search.resets_in_pauses(self.region, mode)
            && (self.around().is_empty() || search.begins_anew(self.region, mode) || in_all())
    }

    /// A way through this cycle on which a condition is answered as on a way through one inside it, and which goes on as that does.
    pub(super) fn way_through(&self, at: NodeId, way: &Way) -> Way {
        let exploration = self.search.explore(self.region, &self.search.starts(self.region));
        let node = |state: usize| exploration.states[state].node;
        let behind = way.nodes.iter().position(|id| *id == at).map_or(0, |asked| asked + 1);
        let is_answered = |state: &usize| {
            Some(&node(*state)) == way.nodes.get(behind)
                && exploration.parent(*state).is_some_and(|asked| node(asked) == at)
        };
        let found = (0..exploration.states.len()).find(is_answered);
        let mut nodes: Vec<NodeId> =
            found.map(|state| exploration.path(state).into_iter().map(node).collect()).unwrap_or_default();
        let rest = if found.is_some() { behind + 1 } else { 0 };
        nodes.extend(&way.nodes[rest.min(way.nodes.len())..]);
        Way { nodes, ..*way }
    }
}
