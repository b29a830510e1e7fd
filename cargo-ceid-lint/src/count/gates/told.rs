//! What functions of the analysed code answer that a condition asks: how old something is, or how far it has counted.

use super::event::TAKES;
use super::sources::Sources;
use super::time::is_clock;
use super::{Gates, Way};
use crate::count::given::place_of;
use crate::flow::{CallSite, Computed, Effect, Head, NodeId, Place, Test, Told, told};
use crate::index::{FunctionId, Ty};
use crate::syntax::tree::Receiver;

/// How long a function may be that is asked how it comes to its answer.
const MAX_EXPRESSIONS: usize = 256;

impl Gates<'_, '_> {
    /// `if self.stamp.age() > PERIOD { … }`: a function that answers what it computes from a clock.
    pub(super) fn is_told_by_clock(&self, asked: &Computed) -> bool {
        self.answers(asked).into_iter().any(|(site, told)| {
            let index = self.search.program.index;
            let is_exclusive = |receiver: &Receiver| matches!(receiver, Receiver::Exclusive);
            let changes = |target| index.function(target).function.receiver.as_ref().is_some_and(is_exclusive);
            let is_told = match self.search.graph.var(site.result).ty {
                Ty::Bool => true,
                Ty::Int | Ty::Float => !told.scales,
                _ => false,
            };
            is_told && !site.targets.iter().copied().any(changes) && told.calls.iter().any(|name| is_clock(name))
        })
    }

    /// `if self.cycles.next() % 4 == 0 { … }`: a method that answers what it or another one counts.
    pub(super) fn is_told_by_counter(&self, test: &Test) -> bool {
        let asked = Computed { places: test.about.reads.clone(), calls: test.about.names.clone() };
        self.answers(&asked).into_iter().any(|(site, told)| {
            let owner = site.args.first().and_then(|arg| arg.place.as_ref());
            let is_counted = |place: Place| self.is_number(&place) && self.nodes().any(|id| self.counts_at(id, &place));
            owner.is_some_and(|owner| told.fields.iter().any(|name| is_counted(owner.field(name))))
        })
    }

    /// `if self.slot() == 2 { … }`: a function that answers the remainder of what each cycle counts that waits for it.
    pub(super) fn asks_told_remainder(&self, test: &Test, at: NodeId, way: &Way) -> bool {
        let is_counted = |place: &Place| {
            self.is_number(place) && self.outlives(place) && self.nodes().any(|id| self.counts_at(id, place))
        };
        let mut counted = self.behind_told_remainder(test).into_iter().filter(is_counted);
        counted.any(|place| self.counts_while_closed(&place, at, way))
    }

    /// What functions of which the remainder is asked that they answer compute it from.
    pub(super) fn behind_told_remainder(&self, test: &Test) -> Vec<Place> {
        let asked = Computed { places: test.about.reads.clone(), calls: test.about.names.clone() };
        // `let slot = self.slot(); if slot == 2 { … }`
        let is_answer = |place: &Place| self.is_number(place) && !self.outlives(place);
        let is_kept = || asked.places.iter().all(is_answer);
        if test.about.is_comparison || test.about.is_presence || (asked.calls.is_empty() && !is_kept()) {
            return Vec::new();
        }
        let answers = self.answers(&asked).into_iter().filter(|(_, told)| told.is_remainder);
        let places = answers.flat_map(|(site, told)| {
            let owner = site.args.first().and_then(|arg| arg.place.as_ref());
            let fields = owner.into_iter().flat_map(|owner| told.fields.iter().map(|name| owner.field(name)));
            fields.chain(site.args.iter().flat_map(|arg| arg.from.places.iter().cloned()))
        });
        places.collect()
    }

    pub(super) fn all_told(&self) -> &[(NodeId, Told)] {
        self.told.get_or_init(|| self.nodes().filter_map(|id| Some((id, self.told_at(id)?))).collect())
    }

    /// What the methods behind a value read of what they are called on and leave alone: `let dt = self.clock.since_last(now);`
    pub(super) fn fields_told(&self, sources: &Sources) -> Vec<Place> {
        self.fields_given(sources, |receiver| receiver == Some(&Receiver::Shared))
    }

    /// Whether a method takes what is fed out of a field in which all that is asked lies:
    /// `if self.parts.ready() { f.update(self.take_parts()) }`.
    pub(super) fn is_taken_by_helper(&self, asked: &[Place]) -> bool {
        let taken = self.fields_given(self.fed(), |receiver| receiver.is_some());
        let is_in = |place: &Place, field: &Place| place.lies_at(field);
        !asked.is_empty() && asked.iter().all(|place| taken.iter().any(|field| is_in(place, field)))
    }

    /// Whether a readiness test and what is fed come from one object, of which a helper asks or reads:
    /// `if self.imu.ready() { let rate = self.rate(); f.update(rate) }`, `if self.is_ready() { f.update(self.imu.read()) }`,
    /// `if self.imu.ready() { self.service(); }`.
    pub(super) fn is_asked_by_helper(&self, asked: &Computed) -> bool {
        let mut given = self.fields_given(self.fed(), |receiver| receiver.is_some());
        given.extend(self.fed_in_helpers());
        let is_read = |place: &Place| given.contains(place) || self.fed().places.contains(place);
        let owner = |site: &CallSite| site.args.first().and_then(|arg| arg.place.clone());
        let mut told = self.answers(asked).into_iter().filter_map(|(site, told)| Some((owner(site)?, told)));
        asked.places.iter().any(|place| given.contains(place))
            || told.any(|(owner, told)| told.fields.iter().any(|name| is_read(&owner.field(name))))
    }

    /// `fn is_due(&self) -> bool { DUE.swap(false, Ordering::AcqRel) }`: a function answers whether a flag was up that it takes down, and
    /// that nothing raises in the cycle.
    pub(super) fn takes_flag_in_helper(&self, sources: &Sources) -> bool {
        let (graph, index) = (self.search.graph, self.search.program.index);
        let takes = |target: FunctionId| {
            let def = index.function(target);
            let body = def.function.body.as_ref().filter(|body| body.exprs.len() <= MAX_EXPRESSIONS);
            let takes = |body| told(body).calls.iter().any(|name| TAKES.contains(&name.as_str()));
            body.filter(|body| sources.calls.contains(&def.name) && takes(body))
        };
        let writes = |id: NodeId| match &graph.node(id).effect {
            Effect::Write(write) if self.is_flag(&write.place) => Some((write.place.clone(), write.head.clone())),
            _ => None,
        };
        let is_raised = |flag: &Place| {
            let mut written = self.nodes().filter_map(writes);
            written.any(|(place, head)| place == *flag && head.as_deref() != Some("false"))
        };
        let are_taken = |flags: Vec<(Place, Option<Head>)>| {
            let is_down = |(flag, head): &(Place, Option<Head>)| head.as_deref() == Some("false") && !is_raised(flag);
            !flags.is_empty() && flags.iter().all(is_down)
        };
        // A small function is read where it is called.
        let is_read = graph.read_here.iter().filter_map(|target| takes(*target)).any(|body| {
            let whole = body.expr(body.root).span;
            are_taken(self.nodes().filter(|id| whole.contains(graph.node(*id).span)).filter_map(writes).collect())
        });
        is_read
            || self.nodes().any(|id| {
                let Effect::Call(site) = &graph.node(id).effect else { return false };
                let [target] = site.targets.as_slice() else { return false };
                let Some(summary) = self.search.summaries.get(*target).filter(|_| takes(*target).is_some()) else {
                    return false;
                };
                let sets =
                    summary.sets.iter().filter_map(|(given, head, _)| Some((place_of(given, site)?, head.clone())));
                are_taken(sets.filter(|(place, _)| self.is_flag(place)).collect())
            })
    }

    fn fields_given(&self, sources: &Sources, is_asked: impl Fn(Option<&Receiver>) -> bool) -> Vec<Place> {
        let index = self.search.program.index;
        let mut fields = Vec::new();
        for (id, told) in self.all_told() {
            let Effect::Call(site) = &self.search.graph.node(*id).effect else { continue };
            let Some(owner) = site.args.first().and_then(|arg| arg.place.as_ref()) else { continue };
            let gives = |target: &FunctionId| {
                let function = index.function(*target);
                is_asked(function.function.receiver.as_ref()) && sources.calls.contains(&function.name)
            };
            if sources.places.contains(owner) && site.targets.iter().any(gives) {
                fields.extend(told.fields.iter().map(|name| owner.field(name)));
            }
        }
        fields
    }

    /// The calls that a condition makes or is computed from, with what they answer.
    fn answers(&self, asked: &Computed) -> Vec<(&CallSite, &Told)> {
        let told = self.all_told();
        if told.is_empty() {
            return Vec::new();
        }
        let sources = self.assignments().behind(asked);
        let is_read = |place: &Place| sources.places.iter().any(|read| read.overlaps(place));
        let answers = told.iter().filter_map(|(id, told)| {
            let Effect::Call(site) = &self.search.graph.node(*id).effect else { return None };
            let is_asked = site.args.first().and_then(|arg| arg.place.as_ref()).is_none_or(is_read);
            let name = |target: &FunctionId| &self.search.program.index.function(*target).name;
            let is_named = site.targets.iter().any(|target| sources.calls.contains(name(target)));
            (is_asked && is_named).then_some((&**site, told))
        });
        answers.collect()
    }

    /// What the function answers that a node calls; `None` if it says nothing of a clock, nor of what it keeps.
    fn told_at(&self, id: NodeId) -> Option<Told> {
        let Effect::Call(site) = &self.search.graph.node(id).effect else { return None };
        let [target] = site.targets.as_slice() else { return None };
        let body = self.search.program.index.function(*target).function.body.as_ref()?;
        let told = Some(body).filter(|body| body.exprs.len() <= MAX_EXPRESSIONS).map(told)?;
        (told.is_remainder || !told.fields.is_empty() || told.calls.iter().any(|name| is_clock(name))).then_some(told)
    }
}
