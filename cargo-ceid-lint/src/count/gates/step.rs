//! The time step of a filter: where it comes from, and whether the next one covers a pause.

use std::collections::BTreeSet;

use super::sample::extend;
use super::sources::Sources;
use super::{Gates, Way};
use crate::config::TimeBase;
use crate::count::given::{Given, given, place_of};
use crate::count::search::Search;
use crate::flow::{CallSite, Computed, Effect, Place, is_time_name};
use crate::index::MethodOwner;
use crate::syntax::tree::{PatKind, TypeRef};

/// Whether a parameter is named as a point of time, from which the law reckons the step by itself.
fn is_moment_name(name: &str) -> bool {
    let name = name.trim_start_matches('_');
    name == "now" || name.starts_with("now_") || name.contains("timestamp")
}

/// The times that a function keeps and from which it computes the step of its filter, as its callers know them.
pub(in crate::count) fn measured_by(search: &Search<'_>) -> BTreeSet<Given> {
    let gates = Gates::of_helper(search);
    if gates.time_base() != TimeBase::Passed {
        return BTreeSet::new();
    }
    let told = gates.told_step();
    let own = told.into_iter().flat_map(|step| gates.clocks(step)).cloned();
    let lapped = told.into_iter().flat_map(|step| gates.nodes().flat_map(|id| gates.lapped(id, step)));
    own.chain(lapped).chain(gates.lent_clocks()).filter_map(|clock| given(search.graph, &clock)).collect()
}

impl Gates<'_, '_> {
    /// Where the filter's time step comes from.
    pub(super) fn time_base(&self) -> TimeBase {
        *self.time_base.get_or_init(|| {
            let index = self.search.program.index;
            let Some(ty) = self.ty(self.search.instance) else { return TimeBase::Passed };
            let Some(spec) = index.filter_spec(&ty) else { return TimeBase::Passed };
            if let Some(time_base) = spec.time_base {
                return self.told_by_name().unwrap_or(time_base);
            }
            let mut base = TimeBase::Fixed;
            let laws = index.methods(&ty, "update").into_iter().flat_map(|owner| match owner {
                // Behind a trait every known law counts.
                MethodOwner::Declared(of, own) => index.implementations(&of, "update").into_iter().chain(own).collect(),
                owner => owner.function().into_iter().collect::<Vec<_>>(),
            });
            for id in laws {
                let function = &index.function(id).function;
                let names = function.body.iter().flat_map(|body| {
                    body.params.iter().filter_map(|pat| match &body.pat(*pat).kind {
                        PatKind::Bind { name, .. } => Some(name.as_str()),
                        _ => None,
                    })
                });
                let types = function.params.iter().filter_map(|ty| match ty {
                    TypeRef::Path(path) => Some(path.last()),
                    _ => None,
                });
                for name in names {
                    if is_moment_name(name) {
                        return TimeBase::Inside;
                    }
                    if is_time_name(name) {
                        base = TimeBase::Passed;
                    }
                }
                for name in types {
                    if matches!(name, "Instant" | "SystemTime") {
                        return TimeBase::Inside;
                    }
                    if name.ends_with("Duration") {
                        base = TimeBase::Passed;
                    }
                }
            }
            if base == TimeBase::Fixed && self.sets_step() { TimeBase::Passed } else { base }
        })
    }

    /// Where the step comes from, if the names of the laws that run here say it: of one type, `update` may read the clock, and
    /// `update_elapsed` be told how long it was.
    fn told_by_name(&self) -> Option<TimeBase> {
        let told = |method: &str| {
            let is_span = ["elapsed", "duration", "delta"].iter().any(|word| method.contains(word));
            match (is_span, method.contains("timestamp")) {
                (true, false) => Some(TimeBase::Passed),
                (false, true) => Some(TimeBase::Inside),
                _ => None,
            }
        };
        let mut bases = self.search.updating().into_iter().filter(|id| self.is_inside(*id)).map(|id| {
            match &self.search.graph.node(id).effect {
                Effect::Update(update) => told(&update.method),
                _ => None,
            }
        });
        let first = bases.next()??;
        bases.all(|base| base == Some(first)).then_some(first)
    }

    /// Whether the step is set before the law is called: `filter.dt = dt`, `filter.set_dt(dt)`.
    fn sets_step(&self) -> bool {
        self.nodes().any(|id| match &self.search.graph.node(id).effect {
            Effect::Write(write) => self.is_part(&write.place) && is_time_name(&self.last_name(&write.place)),
            Effect::Call(site) if site.law_of.is_none() && self.concerns(site) => site.targets.iter().any(|target| {
                let name = &self.search.program.index.function(*target).name;
                is_time_name(name.trim_start_matches("set_").trim_start_matches("with_"))
            }),
            _ => false,
        })
    }

    /// The clock that the filter's step is computed from stands still on the way, so that the next step covers the gap.
    pub(super) fn is_measured(&self, way: &Way) -> bool {
        match self.time_base() {
            TimeBase::Inside => return true,
            TimeBase::Fixed => return false,
            TimeBase::Passed if self.gathers_step(way) => return true,
            TimeBase::Passed => {}
        }
        let step = self.step();
        let clocks = self.lent_clocks();
        let is_kept =
            !clocks.is_empty() || self.clocks(step).next().is_some() || self.nodes().any(|id| self.laps(id, step));
        is_kept && !self.sets_clock(step, way) && !self.renews_one(&clocks, way)
    }

    /// Whether the clock that the filter's step is computed from goes on along the way.
    pub(super) fn goes_on(&self, way: &Way) -> bool {
        // What the helper does to its own clock where it skips is judged there.
        let updating = self.search.updating();
        let nodes = way.nodes.iter().copied().filter(|id| !updating.contains(id)).collect();
        // A sample that is not there is no time, whatever it is called: `self.last = gps(); if let Some(z) = self.last { f.update(z); }`
        let mut step = self.step().clone();
        if let Effect::Branch(test) = &self.search.graph.node(way.at).effect
            && test.about.asks_presence()
            && test.about.names.is_empty()
        {
            step.places.retain(|place| !test.about.reads.contains(place));
        }
        self.sets_clock(&step, way) || self.renews_one(&self.lent_clocks(), &Way { nodes, ..*way })
    }

    pub(super) fn renews_one(&self, clocks: &[Place], way: &Way) -> bool {
        way.nodes.iter().any(|id| clocks.iter().any(|clock| self.renews(*id, clock)))
    }

    /// The clocks that helpers keep for the filter and compute its step from, if every update of it is measured so.
    fn lent_clocks(&self) -> Vec<Place> {
        let graph = self.search.graph;
        let mut clocks = Vec::new();
        for id in self.search.updating().into_iter().filter(|id| self.is_inside(*id)) {
            let Effect::Call(site) = &graph.node(id).effect else { return Vec::new() };
            for target in &site.targets {
                let measured = self.search.summaries.get(*target).into_iter().flat_map(|summary| &summary.measures);
                let known = clocks.len();
                let own = measured.filter(|(given, _)| place_of(given, site).is_some_and(|it| self.is_instance(&it)));
                clocks.extend(own.flat_map(|(_, clocks)| clocks).filter_map(|clock| place_of(clock, site)));
                if clocks.len() == known {
                    return Vec::new();
                }
            }
        }
        clocks
    }

    /// What the filter's time step is computed from, or all that is fed where the step cannot be told from the rest.
    pub(super) fn step(&self) -> &Sources {
        self.told_step().unwrap_or_else(|| self.fed())
    }

    /// What the filter's time step is computed from, if it is given one here.
    pub(super) fn told_step(&self) -> Option<&Sources> {
        let told = self.step.get_or_init(|| {
            let mut step = Computed::default();
            for id in self.nodes() {
                match &self.search.graph.node(id).effect {
                    Effect::Call(site) if self.concerns(site) => {
                        for (number, arg) in site.args.iter().enumerate() {
                            if self.takes_step(site, number) {
                                extend(&mut step, &arg.from);
                            }
                        }
                    }
                    Effect::Write(write)
                        if self.is_part(&write.place) && is_time_name(&self.last_name(&write.place)) =>
                    {
                        if let Some(change) = self.search.graph.changes.get(&id) {
                            extend(&mut step, &change.computed);
                        }
                    }
                    _ => {}
                }
            }
            let is_told = !step.places.is_empty() || !step.calls.is_empty();
            is_told.then(|| {
                let mut sources = self.assignments().behind(&step);
                let kept = self.fields_told(&sources);
                sources.places.extend(kept);
                sources
            })
        });
        told.as_ref()
    }

    /// Whether an argument of a call is the time step.
    pub(super) fn takes_step(&self, site: &CallSite, number: usize) -> bool {
        let index = self.search.program.index;
        site.targets.iter().any(|target| {
            let function = &index.function(*target).function;
            let is_setter = is_time_name(index.function(*target).name.trim_start_matches("set_"));
            let name = function.body.as_ref().and_then(|body| match &body.pat(*body.params.get(number)?).kind {
                PatKind::Bind { name, .. } => Some(name.as_str()),
                _ => None,
            });
            let typed =
                number.checked_sub(usize::from(function.receiver.is_some())).and_then(|at| function.params.get(at));
            let is_duration = matches!(typed, Some(TypeRef::Path(path)) if path.last().ends_with("Duration"));
            (is_setter && number > 0) || is_duration || name.is_some_and(is_time_name)
        }) && self.may_reach(site, number)
    }

    /// Whether what a call is given may be fed to the filter, and not only to others that it updates as well.
    fn may_reach(&self, site: &CallSite, number: usize) -> bool {
        let mut summaries = site.targets.iter().filter_map(|target| self.search.summaries.get(*target));
        summaries.all(|summary| {
            let is_own = |given: &Given| place_of(given, site).is_some_and(|place| self.is_instance(&place));
            let mut own = summary.feeds.iter().filter(|(given, _)| is_own(given)).peekable();
            own.peek().is_none() || own.any(|(_, params)| params.contains(&number))
        })
    }
}
