//! Values that filters give or that are reckoned with readings: a time step that went into them does not make them times.

use std::cell::{OnceCell, RefCell};
use std::collections::{BTreeMap, BTreeSet};

use super::time::{is_clock, is_moment_name};
use super::{Gates, contains_any};
use crate::count::fed::named;
use crate::flow::{Computed, Effect, NodeId, Place, Test, Told, Var, is_time_name};
use crate::index::Ty;

/// Parts of the names of functions whose answer may be a time, whatever they multiply.
const TIMES: &[&str] =
    &["time", "tick", "clock", "sec", "milli", "micro", "nano", "elapsed", "since", "until", "period", "age", "due"];

/// Methods of numbers, whose answer is what they are asked of.
pub(super) const OF_NUMBERS: &[&str] = &[
    "from", "into", "unwrap", "clone", "abs", "min", "max", "clamp", "signum", "sqrt", "powi", "powf", "exp", "ln",
    "sin", "cos", "floor", "ceil", "round", "trunc", "fract", "mul_add", "hypot", "recip",
];

/// What is known of the values of a cycle.
#[derive(Default)]
pub(super) struct Signals {
    /// See [`Gates::is_signal`].
    known: RefCell<BTreeMap<Place, bool>>,
    /// See [`Gates::given_by_laws`].
    given_by_laws: OnceCell<(BTreeSet<Var>, Vec<NodeId>)>,
}

/// Whether a name may be that of a time.
pub(super) fn may_be_time(name: &str) -> bool {
    is_clock(name)
        || is_time_name(name)
        || is_moment_name(name)
        || matches!(name.rsplit('_').next(), Some("ms" | "us" | "ns"))
        || contains_any(name, TIMES)
}

impl Gates<'_, '_> {
    /// What a condition asks apart from readings and from what is reckoned with them: of that, a comparison of times is made.
    pub(super) fn asked_of_times(&self, test: &Test) -> Computed {
        if self.asks_law(test) {
            return Computed::default();
        }
        let places = test.about.reads.iter().filter(|place| !self.is_signal(place)).cloned().collect();
        Computed { places, calls: test.about.names.clone() }
    }

    /// `if f.update(x, step.as_secs_f32()) > LIMIT { … }`: the value is what the filter gives.
    fn asks_law(&self, test: &Test) -> bool {
        let is_inside = |id: NodeId| test.span.contains(self.search.graph.node(id).span);
        test.about.is_comparison && self.given_by_laws().1.iter().any(|id| is_inside(*id))
    }

    /// Whether a number is what a filter gives, a reading, or reckoned with one: `y = x * dt`; or a truth value that asks for nothing
    /// but such.
    pub(super) fn is_signal(&self, place: &Place) -> bool {
        if let Some(known) = self.signals.known.borrow().get(place) {
            return *known;
        }
        // What is computed from itself is what it is otherwise computed from.
        self.signals.known.borrow_mut().insert(place.clone(), false);
        let is_signal = match self.ty(place).as_ref().map(Ty::peel) {
            Some(Ty::Int | Ty::Float) => !may_be_time(&self.last_name(place)) && self.is_reckoned_with_signal(place),
            Some(Ty::Bool) => {
                let mut made = self.makings(place).peekable();
                made.peek().is_some() && made.all(|computed| self.asks_signals(computed))
            }
            _ => false,
        };
        self.signals.known.borrow_mut().insert(place.clone(), is_signal);
        is_signal
    }

    fn is_reckoned_with_signal(&self, place: &Place) -> bool {
        let var = place.base_var().filter(|_| place.steps.is_empty());
        if var.is_some_and(|var| self.given_by_laws().0.contains(&var) || self.is_scaled_answer(var)) {
            return true;
        }
        let mut made = self.makings(place).peekable();
        if made.peek().is_none() {
            // What comes from outside is a sample if it is fed as one.
            let is_step = self.told_step().is_some_and(|step| step.places.contains(place));
            return !self.outlives(place) && !is_step && self.fed().places.contains(place);
        }
        let is_float = self.ty(place).is_some_and(|ty| *ty.peel() == Ty::Float);
        made.any(|computed| {
            named(&computed.places).into_iter().any(|from| self.is_signal(from)) || is_float && self.reads(computed)
        })
    }

    /// Whether a truth value is computed from readings, and from nothing that may be a time.
    fn asks_signals(&self, computed: &Computed) -> bool {
        let mut is_any = false;
        named(&computed.places).into_iter().all(|place| {
            let is_signal = self.is_signal(place);
            is_any |= is_signal;
            is_signal || self.is_left_alone(place) && !self.is_time(place) && !may_be_time(&self.last_name(place))
        }) && is_any
            && !computed.calls.iter().any(|name| may_be_time(name))
    }

    /// Whether a value is got by calls none of which has to do with times: `sensor.read()`.
    fn reads(&self, computed: &Computed) -> bool {
        let is_plain = |name: &String| !name.contains(char::is_lowercase) || OF_NUMBERS.contains(&name.as_str());
        computed.calls.iter().any(|name| !is_plain(name))
            && !computed.calls.iter().any(|name| may_be_time(name))
            && !named(&computed.places).into_iter().any(|place| {
                self.is_time(place)
                    || may_be_time(&self.last_name(place))
                    || self
                        .tells(&self.assignments().behind(&Computed { places: vec![place.clone()], calls: Vec::new() }))
            })
    }

    /// What a place is computed from, wherever it is given a value.
    fn makings<'p>(&'p self, place: &'p Place) -> impl Iterator<Item = &'p Computed> + 'p {
        let graph = self.search.graph;
        let changes = self.assigning(place).filter_map(|id| graph.changes.get(&id)).map(|change| &change.computed);
        let whole = place.base_var().filter(|_| place.steps.is_empty()).and_then(|var| graph.computed.get(&var));
        changes.chain(whole).filter(|computed| !computed.places.is_empty() || !computed.calls.is_empty())
    }

    /// The variables that hold what laws give, also those of helpers that update filters; and where these run.
    fn given_by_laws(&self) -> &(BTreeSet<Var>, Vec<NodeId>) {
        self.signals.given_by_laws.get_or_init(|| {
            let mut given = (BTreeSet::new(), Vec::new());
            for id in self.nodes() {
                match &self.search.graph.node(id).effect {
                    Effect::Update(update) => {
                        given.0.extend(&update.into);
                        given.1.push(id);
                    }
                    Effect::Call(site) if self.search.summaries.updates(site).next().is_some() => {
                        given.0.extend(site.into.iter().chain([&site.result]));
                    }
                    _ => {}
                }
            }
            given
        })
    }

    /// `let y = model.speed_at(dt);`: a method that multiplies what it is given by what it has, and is not named as one that tells a time.
    fn is_scaled_answer(&self, var: Var) -> bool {
        let index = self.search.program.index;
        let is_scaled = |(id, told): &(NodeId, Told)| {
            let Effect::Call(site) = &self.search.graph.node(*id).effect else { return false };
            let is_its = site.result == var || site.into.contains(&var);
            is_its
                && told.scales
                && site.args.len() > 1
                && !told.calls.iter().any(|name| is_clock(name))
                && self.clocks(&self.assignments().behind(&site.from)).next().is_none()
                && !site.targets.iter().any(|target| may_be_time(&index.function(*target).name))
        };
        self.all_told().iter().any(is_scaled)
    }
}
