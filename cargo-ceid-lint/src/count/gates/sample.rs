//! Gates of input: samples that are not there.

use std::collections::BTreeSet;

use super::{Gates, Sources};
use crate::count::given::place_of;
use crate::count::search::{Region, Search};
use crate::flow::{CallSite, Computed, Effect, Place, Test, Var};

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

/// The parameters of a function from which its filter is fed.
pub(in crate::count) fn fed_params(search: &Search<'_>) -> BTreeSet<usize> {
    let gates = Gates::new(search, Region::Function);
    let places = &gates.fed().places;
    let params = places.iter().filter_map(Place::base_var).filter_map(|var| search.graph.var(var).param);
    params.collect()
}

impl Gates<'_, '_> {
    /// What is fed to the instance is computed from: by its law, by another method of it, or by writing its fields.
    pub(super) fn fed(&self) -> &Sources {
        self.fed.get_or_init(|| {
            let mut fed = Computed::default();
            for id in self.nodes() {
                match &self.search.graph.node(id).effect {
                    Effect::Update(update) if self.is_instance(&update.place) => extend(&mut fed, &update.from),
                    Effect::Call(site) if self.concerns(site) => self.add_fed_arguments(site, &mut fed),
                    Effect::Write(write) if self.is_part(&write.place) => {
                        if let Some(change) = self.search.graph.changes.get(&id) {
                            extend(&mut fed, &change.computed);
                        }
                    }
                    _ => {}
                }
            }
            self.assignments().behind(&fed)
        })
    }

    /// The arguments of a call that reach the filter there.
    fn add_fed_arguments(&self, site: &CallSite, fed: &mut Computed) {
        let summaries = site.targets.iter().map(|target| self.search.summaries.get(*target));
        let known: Option<Vec<&BTreeSet<usize>>> = summaries
            .map(|summary| {
                let mut feeds = summary?.feeds.iter();
                feeds.find_map(|(given, params)| {
                    place_of(given, site).is_some_and(|place| self.is_instance(&place)).then_some(params)
                })
            })
            .collect();
        let known = known.filter(|params| !params.is_empty() && site.law_of.is_none());
        for (number, arg) in site.args.iter().enumerate() {
            if known.as_ref().is_none_or(|all| all.iter().any(|params| params.contains(&number))) {
                extend(fed, &arg.from);
            }
        }
    }

    /// Whether something that is fed is computed from one of these variables.
    pub(super) fn feeds_any(&self, vars: &[Var]) -> bool {
        vars.iter().any(|var| self.fed().has_var(*var))
    }

    /// A question to nothing but the filter itself, or to its siblings: `if smoother.is_smoothing() { smoother.next() }`.
    pub(super) fn asks_only_filter(&self, test: &Test) -> bool {
        let index = self.search.program.index;
        let reads = &test.about.reads;
        let is_filter = |place: &Place| self.ty(place).is_some_and(|ty| index.filter_spec(ty.peel()).is_some());
        !test.about.is_presence
            && reads.iter().any(|place| self.lies_in_instance(place))
            && reads.iter().all(|place| self.lies_in_instance(place) || is_filter(place))
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
        let graph = self.search.graph;
        let about = &test.about;
        // What a variant of a kept state holds is no sample of this iteration.
        let is_option = about.heads.is_empty() || about.heads.iter().any(|head| head == "+" || head == "-");
        if !is_option && about.names.is_empty() && about.reads.iter().any(|place| self.outlives(place)) {
            return false;
        }
        let is_asked = |name: &String| !is_question(name);
        let direct = self.nodes().any(|id| match &graph.node(id).effect {
            // `f.update(imu.read()?)`
            Effect::Update(update) if self.is_instance(&update.place) => {
                !about.names.is_empty()
                    && about.names.iter().filter(|name| is_asked(name)).all(|name| update.from.calls.contains(name))
            }
            _ => false,
        });
        if direct {
            return true;
        }
        if !about.binds.is_empty() {
            return self.feeds_any(&about.binds);
        }
        // `x.is_some()`, `x?`: the variable that is asked, or what the call's result goes into.
        let into = graph.computed.iter().filter(|(_, computed)| {
            !computed.calls.is_empty()
                && about.names.iter().filter(|name| is_asked(name)).all(|name| computed.calls.contains(name))
                && about.reads.iter().all(|place| computed.places.contains(place))
                && !about.reads.is_empty()
        });
        let into: Vec<Var> = into.map(|(var, _)| *var).collect();
        if !into.is_empty() {
            return self.feeds_any(&into);
        }
        // What another method of the same object gives is not what is fed.
        !about.names.iter().any(is_asked)
            && about.reads.iter().any(|place| {
                let is_value =
                    !place.steps.is_empty() || place.base_var().is_some_and(|var| graph.var(var).name != "self");
                is_value && self.fed().places.contains(place)
            })
    }

    /// A readiness test of the very object that the fed sample is read from.
    pub(super) fn is_readiness(&self, test: &Test) -> bool {
        let asks = |parts: &[&str]| test.about.names.iter().any(|name| parts.iter().any(|part| name.contains(part)));
        let asks_amount = asks(&["is_empty", "len", "is_full"]);
        if test.about.is_presence || !(asks_amount || (asks(READINESS) && !test.about.is_comparison)) {
            return false;
        }
        test.about.reads.iter().any(|place| {
            let whole_self =
                place.steps.is_empty() && place.base_var().is_some_and(|var| self.search.graph.var(var).name == "self");
            !whole_self && self.fed().places.contains(place)
        })
    }
}

pub(super) fn extend(all: &mut Computed, more: &Computed) {
    all.places.extend(more.places.iter().cloned());
    all.calls.extend(more.calls.iter().cloned());
}

fn is_question(name: &str) -> bool {
    matches!(name, "is_some" | "is_ok" | "is_none" | "is_err" | "ok" | "as_ref" | "as_mut" | "map_err" | "await")
}
