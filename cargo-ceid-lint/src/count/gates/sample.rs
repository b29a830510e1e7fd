//! Gates of input: samples that are not there, events that choose what to do.

use super::Gates;
use crate::count::search::Region;
use crate::flow::{Effect, Place, Test, Var};

/// Parts of the names of methods that ask whether a sample is there.
const READINESS: &[&str] = &[
    "ready",
    "available",
    "has_",
    "is_new",
    "pending",
    "fresh",
    "new_",
    "updated",
    "data",
    "drdy",
    "can_read",
    "poll",
];

/// Names of methods that receive a message or an event.
const EVENTS: &[&str] = &[
    "recv",
    "receive",
    "try_recv",
    "try_receive",
    "recv_timeout",
    "next_event",
    "wait_event",
    "poll_event",
    "pop",
    "pop_front",
    "dequeue",
    "select",
    "select3",
    "select4",
    "next_message",
    "read_event",
    "get_event",
    "try_next",
];

impl Gates<'_, '_> {
    /// The variables that are fed to the instance: by its law, or by another method of it.
    pub(super) fn fed(&self) -> impl Iterator<Item = Var> + '_ {
        self.nodes().flat_map(move |id| match &self.search.graph.node(id).effect {
            Effect::Update(update) if self.is_instance(&update.place) => update.fed.clone(),
            Effect::Call(site) if self.concerns(site) => site.fed.clone(),
            Effect::Write(write) if self.is_part(&write.place) => {
                let computed = write.place.base_var().and_then(|var| self.search.graph.computed.get(&var));
                let places = computed.map(|computed| &computed.places[..]).unwrap_or_default();
                places.iter().filter_map(Place::base_var).filter(|var| Some(*var) != write.place.base_var()).collect()
            }
            _ => Vec::new(),
        })
    }

    /// A choice on a value that was received in this iteration, or on the event that a handler is called with.
    pub(super) fn is_event(&self, test: &Test) -> bool {
        let graph = self.search.graph;
        if test.about.heads.is_empty() || test.about.is_presence {
            return false;
        }
        test.about.reads.iter().any(|place| {
            let Some(var) = place.base_var() else { return false };
            let info = graph.var(var);
            let is_event_parameter = self.region == Region::Function
                && info.param.is_some()
                && info.name != "self"
                && matches!(info.ty.peel(), crate::index::Ty::Adt(..));
            self.is_received(var) || is_event_parameter
        })
    }

    /// Whether a variable holds what was received in this iteration.
    pub(super) fn is_received(&self, var: Var) -> bool {
        let graph = self.search.graph;
        let received = graph
            .computed
            .get(&var)
            .is_some_and(|computed| computed.calls.iter().any(|name| EVENTS.contains(&name.as_str())));
        let inside = match self.region {
            Region::Loop(own) => graph.is_within(graph.var(var).in_loop, own),
            Region::Function => true,
        };
        received && inside
    }

    /// Whether what is present or absent is the filter itself.
    pub(super) fn is_presence_of_filter(&self, test: &Test) -> bool {
        let by_name = test.about.binds.iter().any(|var| self.is_instance(&Place::var(*var)));
        let by_place = test
            .about
            .reads
            .iter()
            .any(|place| self.search.aliases.roots(place).iter().any(|root| root == self.search.instance));
        // What the law gives back is asked, not whether the filter is there.
        let is_law = self.nodes().any(|id| match &self.search.graph.node(id).effect {
            Effect::Update(update) => self.is_instance(&update.place) && test.about.names.contains(&update.method),
            _ => false,
        });
        by_name || (by_place && !is_law)
    }

    /// Whether every value that may be absent feeds this filter.
    pub(super) fn feeds_sample(&self, test: &Test) -> bool {
        let aliases = self.search.aliases;
        let fed: Vec<Var> = self.fed().collect();
        let binds: Vec<Var> = if test.about.binds.is_empty() {
            // `x.is_some()`, `x?`: the variable that is asked, or what the call's result goes into.
            let graph = self.search.graph;
            let asked: Vec<Var> =
                test.about.reads.iter().filter(|place| place.steps.is_empty()).filter_map(Place::base_var).collect();
            let into = graph.computed.iter().filter(|(_, computed)| {
                !computed.calls.is_empty()
                    && test.about.names.iter().all(|name| computed.calls.contains(name) || is_question(name))
                    && test.about.reads.iter().all(|place| computed.places.contains(place))
                    && !test.about.reads.is_empty()
            });
            let into: Vec<Var> = into.map(|(var, _)| *var).collect();
            if into.is_empty() { asked } else { into }
        } else {
            test.about.binds.clone()
        };
        let direct = self.nodes().any(|id| match &self.search.graph.node(id).effect {
            // `f.update(imu.read()?)`
            Effect::Update(update) if self.is_instance(&update.place) => {
                let names = &test.about.names;
                !names.is_empty() && names.iter().all(|name| update.from.calls.contains(name) || is_question(name))
            }
            _ => false,
        });
        direct || binds.iter().any(|bind| fed.iter().any(|var| aliases.is_derived(*var, &[*bind])))
    }

    /// A readiness test of the very object that the fed sample is read from.
    pub(super) fn is_readiness(&self, test: &Test) -> bool {
        let asks = test.about.names.iter().any(|name| READINESS.iter().any(|part| name.contains(part)));
        if test.about.is_comparison || test.about.is_presence || !asks {
            return false;
        }
        let fed = self.fed_places();
        test.about.reads.iter().any(|place| {
            let whole_self =
                place.steps.is_empty() && place.base_var().is_some_and(|var| self.search.graph.var(var).name == "self");
            !whole_self && fed.iter().any(|other| other == place)
        })
    }
}

fn is_question(name: &str) -> bool {
    matches!(name, "is_some" | "is_ok" | "is_none" | "is_err" | "ok" | "as_ref" | "as_mut" | "map_err" | "await")
}
