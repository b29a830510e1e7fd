//! Conditions that skip an update on purpose, and what tells them from defects.

mod mode;
mod sample;
mod time;

use super::search::{End, Exploration, Region, Search};
use super::verdict::Gate;
use crate::flow::{About, Effect, LoopId, NodeId, Place, Test};
use crate::syntax::CycleDirective;

/// Why a way does not update, if it does so on purpose; `None` for a way that updates, or that nothing explains.
pub(super) fn of_end(search: &Search<'_>, region: Region, exploration: &Exploration, end: &End) -> Option<Gate> {
    if end.state.count != crate::count::counts::Count::Zero || end.state.reset {
        return None;
    }
    let at = end.state.skipped_at?;
    let gates = Gates { search, region };
    let gate = match &search.graph.node(at).effect {
        Effect::Branch(test) => gates.of_test(test, at),
        Effect::Call(_) => end.state.helper_gate,
        Effect::LoopHead(id) => gates.of_loop(*id),
        _ => None,
    };
    let gate = gate.or_else(|| gates.of_payload(exploration, end)).or_else(|| gates.measured(exploration, end))?;
    if gate == Gate::Measured {
        return Some(gate);
    }
    // A clock that runs on while the filter stands still loses time, whatever the gate.
    if !matches!(gate, Gate::Time | Gate::Config | Gate::Startup) && gates.advances_clock(exploration, end, at) {
        return None;
    }
    Some(gate)
}

/// Whether a test asks about something that was received in this iteration.
pub(super) fn is_received(search: &Search<'_>, region: Region, test: &Test) -> bool {
    let gates = Gates { search, region };
    test.about.reads.iter().filter_map(Place::base_var).any(|var| gates.is_received(var))
}

struct Gates<'s, 'a> {
    search: &'s Search<'a>,
    region: Region,
}

impl Gates<'_, '_> {
    fn of_test(&self, test: &Test, at: NodeId) -> Option<Gate> {
        let gate = self.of_condition(test, at);
        let at_gate = match self.search.program.directive(test.span) {
            Some(CycleDirective::Every(ratio)) => Some(ratio),
            _ => None,
        };
        let at_loop = match self.region {
            Region::Loop(id) => self.search.graph.loop_info(id).directive,
            Region::Function => None,
        };
        match (at_gate, at_loop, gate) {
            (Some(ratio), _, _) | (None, Some(CycleDirective::Every(ratio)), Some(Gate::Rate)) => {
                (gate == Some(Gate::Rate) && has_ratio(&test.about, ratio)).then_some(Gate::Rate)
            }
            _ => gate,
        }
    }

    fn of_condition(&self, test: &Test, at: NodeId) -> Option<Gate> {
        let about = &test.about;
        if about.is_constant {
            return Some(Gate::Config);
        }
        if about.is_event {
            return Some(Gate::Event);
        }
        if about.is_remainder {
            return Some(Gate::Rate);
        }
        // A lock that is not waited for fails while another holds it: that is no setting.
        let is_tried = about.names.iter().any(|name| name.starts_with("try_"));
        if about.is_presence && !is_tried && self.is_presence_of_filter(test) {
            return Some(Gate::Config);
        }
        if about.is_presence && self.feeds_sample(test) {
            return Some(Gate::Sample);
        }
        if self.is_event(test) {
            return Some(Gate::Event);
        }
        if !about.is_presence
            && let Some(gate) = self.counter(test)
        {
            return Some(gate);
        }
        if self.tells_time(test) {
            return Some(Gate::Time);
        }
        if self.is_readiness(test) {
            return Some(Gate::Sample);
        }
        if self.is_latch(test, at) {
            return Some(Gate::Startup);
        }
        if test.subject.is_some() && self.is_unchanging(test, at) {
            return Some(Gate::Config);
        }
        if self.is_mode(test, at) {
            return Some(Gate::Mode);
        }
        None
    }

    /// An inner loop that may have no round: over samples that are there or not.
    fn of_loop(&self, id: LoopId) -> Option<Gate> {
        let info = self.search.graph.loop_info(id);
        let feeds = self.fed().any(|var| self.search.aliases.is_derived(var, &info.bound));
        // A helper's own loop over samples has no round where there is no sample.
        (info.drains || feeds || self.search.sample_loops.contains(&id)).then_some(Gate::Sample)
    }

    /// The nodes of the region.
    fn nodes(&self) -> impl Iterator<Item = NodeId> + '_ {
        let graph = self.search.graph;
        graph.node_ids().filter(move |id| match self.region {
            Region::Function => true,
            Region::Loop(own) => graph.is_within(graph.node(*id).in_loop, own),
        })
    }

    /// The places that what is fed to the instance is computed from.
    fn fed_places(&self) -> Vec<Place> {
        let graph = self.search.graph;
        let mut places = Vec::new();
        for id in self.nodes() {
            match &graph.node(id).effect {
                Effect::Update(update) if self.is_instance(&update.place) => {
                    places.extend(update.from.places.iter().cloned());
                }
                Effect::Call(site) if self.concerns(site) => places.extend(site.from.places.iter().cloned()),
                _ => {}
            }
        }
        let mut at = 0;
        while at < places.len() && places.len() < 256 {
            if let Some(var) = places[at].base_var()
                && places[at].steps.is_empty()
                && let Some(computed) = graph.computed.get(&var)
            {
                for place in &computed.places {
                    if !places.contains(place) {
                        places.push(place.clone());
                    }
                }
            }
            at += 1;
        }
        places
    }

    fn is_instance(&self, place: &Place) -> bool {
        self.search.aliases.roots(place).iter().any(|root| root.overlaps(self.search.instance))
    }

    fn is_part(&self, place: &Place) -> bool {
        self.search
            .aliases
            .roots(place)
            .iter()
            .any(|root| root.overlaps(self.search.instance) && root.steps.len() > self.search.instance.steps.len())
    }

    fn concerns(&self, site: &crate::flow::CallSite) -> bool {
        site.args.iter().filter_map(|arg| arg.place.as_ref()).any(|place| self.is_instance(place))
    }

    fn calls_write(&self, place: &Place) -> bool {
        let graph = self.search.graph;
        self.nodes().any(|id| match &graph.node(id).effect {
            Effect::Call(site) => self.call_writes(site, place),
            Effect::Unknown { places, .. } => places.iter().any(|other| other.overlaps(place)),
            _ => false,
        })
    }

    fn call_writes(&self, site: &crate::flow::CallSite, place: &Place) -> bool {
        site.targets.iter().any(|target| {
            self.search.summaries.get(*target).is_some_and(|summary| {
                summary.writes.iter().any(|given| {
                    crate::count::summary::place_of(given, site).is_some_and(|written| written.overlaps(place))
                })
            })
        })
    }

    /// The last name of a place.
    fn last_name(&self, place: &Place) -> String {
        match place.steps.last() {
            Some(crate::flow::Projection::Field(name)) => name.to_string(),
            Some(crate::flow::Projection::Index(_) | crate::flow::Projection::Channel(_)) => String::new(),
            None => place.base_var().map(|var| self.search.graph.var(var).name.clone()).unwrap_or_default(),
        }
    }
}

/// Whether a rate gate opens in one of so many cycles, as far as its condition tells: a counter is compared with the ratio, or
/// with its last number.
fn has_ratio(about: &About, ratio: u64) -> bool {
    match about.ratio {
        Some(own) => own == ratio,
        None => {
            let known: Vec<u64> = about.numbers.iter().copied().filter(|number| *number > 0).collect();
            known.is_empty() || known.iter().any(|number| *number == ratio || number + 1 == ratio)
        }
    }
}
