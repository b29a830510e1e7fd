//! Gates of input: samples that are not there.

use std::collections::BTreeSet;

use super::{Gates, Sources, Way};
use crate::count::fed::named;
use crate::count::given::{Given, given, place_of};
use crate::count::search::{Region, Search};
use crate::flow::{About, CallSite, Computed, Effect, LoopId, NodeId, Place, Test, Var};
use crate::index::Ty;

/// How many filters are followed that stand before another one: `b.update(a.value())`.
const MAX_CHAIN: usize = 16;

/// The parameters of a function from which its filter is fed, and the objects in them.
pub(in crate::count) fn fed_from(search: &Search<'_>) -> (BTreeSet<usize>, BTreeSet<Given>) {
    let gates = Gates::new(search, Region::Function);
    let places = &gates.fed().places;
    let params = places.iter().filter_map(Place::base_var).filter_map(|var| search.graph.var(var).param);
    let is_object = |place: &Place| {
        !place.steps.is_empty() && !matches!(gates.ty(place), Some(Ty::Bool | Ty::Int | Ty::Float | Ty::Char))
    };
    let objects = places.iter().cloned().chain(gates.fed_in_helpers()).filter(is_object);
    (params.collect(), objects.filter_map(|place| given(search.graph, &place)).collect())
}

impl Gates<'_, '_> {
    /// What is fed to the instance is computed from: by its law, by another method of it, or by writing its fields. What another
    /// filter gives is computed from what that one is fed with.
    pub(super) fn fed(&self) -> &Sources {
        self.fed.get_or_init(|| {
            let index = self.search.program.index;
            let mut fed = Computed::default();
            let mut chain = vec![self.search.instance.clone()];
            let mut at = 0;
            loop {
                while let Some(filter) = chain.get(at) {
                    self.add_fed(filter, &mut fed);
                    at += 1;
                }
                let sources = self.sources_of_fed(&mut fed);
                let is_filter =
                    |place: &&Place| self.ty(place).is_some_and(|ty| index.filter_spec(ty.peel()).is_some());
                let roots = sources.places.iter().flat_map(|place| self.search.aliases.roots(place));
                let before: Vec<Place> = roots.filter(|place| is_filter(&place) && !chain.contains(place)).collect();
                if before.is_empty() || chain.len() > MAX_CHAIN {
                    return sources;
                }
                chain.extend(before);
            }
        })
    }

    /// What all that is fed is computed from, also where a method of the owner keeps it: `self.keep(z); f.update(self.kept)`.
    fn sources_of_fed(&self, fed: &mut Computed) -> Sources {
        let writing = |id: NodeId| match &self.search.graph.node(id).effect {
            Effect::Call(site) => Some((site, self.written_by(site).collect::<Vec<Place>>())),
            _ => None,
        };
        let mut open: Vec<_> = self.nodes().filter_map(writing).filter(|(_, written)| !written.is_empty()).collect();
        loop {
            let sources = self.assignments().behind(fed);
            // What is read of an owner is the part that is named.
            let read = named(&sources.places);
            let keeps = |written: &Vec<Place>| read.iter().any(|place| written.iter().any(|to| place.overlaps(to)));
            let (mut keeping, others): (Vec<_>, Vec<_>) = open.into_iter().partition(|(_, written)| keeps(written));
            keeping.retain(|(site, _)| self.leaves_alone(site, self.search.instance));
            if keeping.is_empty() {
                return sources;
            }
            keeping.iter().flat_map(|(site, _)| &site.args).for_each(|arg| extend(fed, &arg.from));
            open = others;
        }
    }

    /// Whether a call gets what a filter is a part of, or only a look at the filter, and neither updates nor writes it.
    fn leaves_alone(&self, site: &CallSite, filter: &Place) -> bool {
        let aliases = self.search.aliases;
        let is_owner =
            |place: &Place| aliases.shared_roots(place).iter().all(|root| root.steps.len() < filter.steps.len());
        // A payload or an element has a name of its own here.
        let writes = |place: &Place| {
            let roots = aliases.shared_roots(place);
            roots.iter().any(|root| root.overlaps(filter) && root.steps.len() >= filter.steps.len())
        };
        site.law_of.is_none()
            && !site.targets.is_empty()
            && site.targets.iter().all(|target| self.search.summaries.get(*target).is_some())
            && site
                .args
                .iter()
                .filter_map(|arg| Some((arg.is_shared, arg.place.as_ref()?)))
                .filter(|(_, place)| self.is_of(filter, place))
                .all(|(is_shared, place)| is_shared || is_owner(place))
            && !self.search.summaries.updates(site).any(|place| self.is_of(filter, &place))
            && !self.written_by(site).any(|place| writes(&place))
    }

    /// What is fed to a filter, by any of its names.
    fn add_fed(&self, filter: &Place, fed: &mut Computed) {
        let is_it = |place: &Place| self.is_of(filter, place);
        for id in self.nodes() {
            match &self.search.graph.node(id).effect {
                Effect::Update(update) if is_it(&update.place) => extend(fed, &update.from),
                Effect::Call(site)
                    if site.args.iter().filter_map(|arg| arg.place.as_ref()).any(is_it)
                        && !self.leaves_alone(site, filter) =>
                {
                    self.add_fed_arguments(site, &is_it, fed);
                }
                Effect::Write(write) if self.is_part_of(filter, &write.place) => {
                    if let Some(change) = self.search.graph.changes.get(&id) {
                        extend(fed, &change.computed);
                    }
                }
                _ => {}
            }
        }
    }

    /// The arguments of a call that reach a filter there.
    fn add_fed_arguments(&self, site: &CallSite, is_it: &dyn Fn(&Place) -> bool, fed: &mut Computed) {
        let summaries = site.targets.iter().map(|target| self.search.summaries.get(*target));
        let known: Option<Vec<&BTreeSet<usize>>> = summaries
            .map(|summary| {
                let mut feeds = summary?.feeds.iter();
                feeds.find_map(|(given, params)| {
                    place_of(given, site).is_some_and(|place| is_it(&place)).then_some(params)
                })
            })
            .collect();
        let known = known.filter(|params| !params.is_empty() && site.law_of.is_none());
        for (number, arg) in site.args.iter().enumerate() {
            if known.as_ref().is_none_or(|all| all.iter().any(|params| params.contains(&number))) {
                extend(fed, &arg.from);
            }
        }
        // What another filter of the owner gives there: `fn steer(&mut self) { self.pid.update(self.goal - self.estimate.value()); }`
        let index = self.search.program.index;
        let is_filter = |place: &Place| self.ty(place).is_some_and(|ty| index.filter_spec(ty.peel()).is_some());
        fed.places.extend(self.objects_fed_from(site, is_it).into_iter().filter(is_filter));
    }

    /// The objects from which a call feeds a filter that it gets together with them.
    fn objects_fed_from(&self, site: &CallSite, is_it: &dyn Fn(&Place) -> bool) -> Vec<Place> {
        let summaries = site.targets.iter().filter_map(|target| self.search.summaries.get(*target));
        let own = |filter: &Given| place_of(filter, site).is_some_and(|place| is_it(&place));
        let fed = summaries.flat_map(|summary| summary.feeds_from.iter()).filter(|(filter, _)| own(filter));
        fed.flat_map(|(_, from)| from).filter_map(|from| place_of(from, site)).collect()
    }

    /// The objects from which functions feed the filter that get it together with them: `self.service()`.
    pub(super) fn fed_in_helpers(&self) -> Vec<Place> {
        let mut objects = Vec::new();
        for id in self.nodes() {
            let Effect::Call(site) = &self.search.graph.node(id).effect else { continue };
            if site.law_of.is_some() || !self.concerns(site) {
                continue;
            }
            objects.extend(self.objects_fed_from(site, &|place| self.is_instance(place)));
        }
        objects
    }

    /// Whether something that is fed is computed from one of these variables.
    pub(super) fn feeds_any(&self, vars: &[Var]) -> bool {
        vars.iter().any(|var| self.fed().has_var(*var))
    }

    /// Whether what is present or absent is the filter itself.
    pub(super) fn is_presence_of_filter(&self, test: &Test) -> bool {
        let by_name = test.about.binds.iter().any(|var| self.is_instance(&Place::var(*var)));
        (by_name && !self.is_narrowed(test)) || self.asks_own_presence(test)
    }

    /// The same where nothing else is asked than the place of the filter, which is one among others in no collection.
    pub(in crate::count) fn asks_own_presence(&self, test: &Test) -> bool {
        let is_it =
            |place: &Place| self.search.aliases.shared_roots(place).iter().any(|root| root == self.search.instance);
        // `dac.write(filter.value())?` asks the converter; the number of an element is asked for nothing.
        let is_number = |place: &Place| matches!(self.ty(place), Some(Ty::Int));
        let reads = &test.about.reads;
        let by_place = reads.iter().any(is_it) && reads.iter().all(|place| is_it(place) || is_number(place));
        // What the law gives back is asked, not whether the filter is there.
        let is_law = || {
            self.nodes().any(|id| match &self.search.graph.node(id).effect {
                Effect::Update(update) => self.is_instance(&update.place) && test.about.names.contains(&update.method),
                _ => false,
            })
        };
        by_place && !is_law() && !self.is_narrowed(test) && !self.hands_reading_on(test)
    }

    /// Whether what is present or absent are filters, from which this one may be fed: what they give is there as long as they are.
    pub(super) fn binds_filters(&self, test: &Test) -> bool {
        let index = self.search.program.index;
        let is_filter = |var: &Var| index.filter_spec(self.search.graph.var(*var).ty.peel()).is_some();
        !test.about.binds.is_empty() && test.about.binds.iter().all(is_filter)
    }

    /// `pid.as_mut().filter(|_| is_armed())`: what is left on a condition may be gone although the filter is there, unless the
    /// condition is a setting.
    fn is_narrowed(&self, test: &Test) -> bool {
        let narrows = |name: &String| matches!(name.as_str(), "filter" | "take_if" | "xor");
        if !test.about.names.iter().any(narrows) {
            return false;
        }
        let sources = self.behind(test);
        let is_it = |place: &Place| self.search.aliases.shared_roots(place).iter().any(|root| self.is_instance(root));
        // What is computed in the iteration is told by what it is computed from, and a whole by its parts.
        let is_told = |place: &Place| {
            let is_part = |other: &Place| other.base == place.base && other.steps.len() > place.steps.len();
            !self.outlives(place)
                || sources.places.iter().any(|other| is_part(other) && other.steps.starts_with(&place.steps))
        };
        sources.calls.iter().any(|name| !narrows(name) && !is_question(name))
            || sources.places.iter().any(|place| !is_it(place) && !is_told(place) && !self.is_setting(place))
    }

    /// Whether a way does without an update because a sample is not there. What is fed where none came is no sample of this
    /// iteration, even if an earlier one left it: `if let Some(z) = read() { last = z; } else { f.update(last); }`.
    pub(super) fn lacks_sample(&self, test: &Test, at: NodeId, way: &Way) -> bool {
        let holds = way.after(at) == self.search.graph.node(at).next.first().copied();
        // What a future is ready with has the head of an absent value, because it ends the future.
        let asked = test.subject.and_then(|id| self.search.graph.subjects[id.0 as usize].whole.as_ref());
        let asked = asked.filter(|place| place.steps.is_empty()).and_then(Place::base_var);
        let is_poll = asked.is_some_and(|var| self.search.graph.var(var).ty.external_name() == Some("Poll"));
        // Nothing but `Ready` has that head and brings what is fed.
        let is_poll = is_poll || (test.about.heads.iter().all(|head| head == "-") && self.feeds_any(&test.about.binds));
        let is_present = |head: &str| ((head == "+") != is_poll) == holds;
        let is_there = test.about.asks_presence() && test.about.heads.iter().all(|head| is_present(head));
        !is_there && self.feeds_sample(test)
    }

    /// The same for a reading that is one of several things, in whatever order these are asked for:
    /// `match port.read() { Reading::Stale => …, Reading::Fresh(sample) => … }`.
    pub(super) fn lacks_reading(&self, test: &Test, at: NodeId, way: &Way) -> bool {
        let about = &test.about;
        if about.heads.is_empty() || (about.names.is_empty() && !self.asks_given(test)) {
            return false;
        }
        if !about.binds.is_empty() {
            return self.lacks_sample(test, at, way);
        }
        // What is told by being there or not is asked for that.
        let is_kind = |about: &About| about.heads.iter().all(|head| head != "+" && head != "-");
        let is_taken = way.after(at) == self.search.graph.node(at).next.first().copied();
        if test.subject.is_none() || !is_taken || !is_kind(about) {
            return false;
        }
        let bringing = |id: NodeId| match &self.search.graph.node(id).effect {
            Effect::Branch(other) if other.subject == test.subject && !other.about.binds.is_empty() => Some(other),
            _ => None,
        };
        let mut bringing = self.nodes().filter_map(bringing).peekable();
        bringing.peek().is_some() && bringing.all(|other| other.about.heads != about.heads && self.feeds_sample(other))
    }

    /// Whether every update is for a sample that a loop takes out of an iterator of the caller's, and a way comes by none of these
    /// loops: what it did not take is taken the next time.
    pub(super) fn leaves_samples(&self, way: &Way) -> bool {
        let graph = self.search.graph;
        let takes = |id: &LoopId| self.search.sample_loops.contains(id) && graph.loop_info(*id).is_lent;
        let comes_by = |id: LoopId| way.nodes.contains(&graph.loop_info(id).head);
        let updating = self.search.updating();
        let mut taking = updating.into_iter().filter(|node| self.is_inside(*node)).peekable();
        taking.peek().is_some()
            && taking.all(|node| graph.loops_around(node).find(takes).is_some_and(|id| !comes_by(id)))
    }

    /// Whether a condition is asked only where a sample is not there, why or for how long: `Err(Bus::Nack) => continue`,
    /// `Err(_) if errors < 5 => held`.
    pub(super) fn asks_for_reason(&self, test: &Test, at: NodeId, way: &Way) -> bool {
        let graph = self.search.graph;
        let asked = test.subject.map(|id| &graph.subjects[id.0 as usize]);
        // What is asked for is a part of what is there or not.
        let is_part_of =
            |whole: &Place| asked.is_some_and(|asked| asked.whole.is_none() && asked.reads == [whole.clone()]);
        way.nodes.iter().take_while(|id| **id != at).any(|id| {
            let Effect::Branch(before) = &graph.node(*id).effect else { return false };
            let whole = before.subject.and_then(|id| graph.subjects[id.0 as usize].whole.as_ref());
            before.about.asks_presence()
                && (whole.is_some_and(is_part_of) || (self.search.decides(*id, at) && self.asks_count(test)))
                && self.lacks_sample(before, *id, way)
        })
    }

    /// Whether a condition asks for something that the cycle counts.
    fn asks_count(&self, test: &Test) -> bool {
        let counts = |id: NodeId| self.search.graph.changes.get(&id).is_some_and(|change| change.kind.counts());
        test.about.reads.iter().any(|place| self.outlives(place) && self.assigning(place).any(counts))
    }

    /// Whether a condition asks for nothing but what came in this iteration and is fed, and settings: `z.is_finite()`.
    pub(super) fn asks_only_sample(&self, test: &Test) -> bool {
        let is_plain = |place: &Place| matches!(self.ty(place), Some(Ty::Bool | Ty::Int | Ty::Float | Ty::Char));
        let graph = self.search.graph;
        let computed = |place: &Place| place.base_var().and_then(|var| graph.computed.get(&var));
        // What is asked and what is fed are names of what one call gave.
        let is_of_fed = |asked: &Computed| {
            let has_all = |fed: &Computed| {
                asked.calls.iter().all(|name| fed.calls.contains(name))
                    && asked.places.iter().all(|place| fed.places.contains(place))
            };
            let mut fed = self.fed().places.iter().filter(|place| !self.outlives(place));
            !asked.calls.is_empty() && fed.any(|place| computed(place).is_some_and(has_all))
        };
        let is_sample = |place: &Place| {
            let is_fed = place.base_var().is_some_and(|var| self.feeds_any(&[var]));
            let is_value = !self.outlives(place) && self.ty(place) != Some(Ty::Bool);
            is_value && (is_fed || computed(place).is_some_and(is_of_fed))
        };
        let reads = &test.about.reads;
        reads.iter().any(is_sample)
            && reads.iter().all(|place| is_sample(place) || (is_plain(place) && self.is_setting(place)))
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
        let asks_name = about.names.iter().any(is_asked);
        let holds_names =
            |from: &Computed| about.names.iter().filter(|name| is_asked(name)).all(|name| from.calls.contains(name));
        let holds_all = |from: &Computed| {
            asks_name && holds_names(from) && about.reads.iter().all(|place| from.places.contains(place))
        };
        let direct = self.nodes().any(|id| match &graph.node(id).effect {
            // `f.update(imu.read()?)`, `f.update(g.update(imu.read()?))`
            Effect::Update(update) if self.is_instance(&update.place) || self.feeds_any(&update.into) => {
                let reads = |place: &Place| update.from.places.iter().any(|other| other.overlaps(place));
                asks_name && holds_names(&update.from) && about.reads.iter().all(reads)
            }
            // `f.feed(imu.read()?)`
            Effect::Call(site) if self.concerns(site) && !self.leaves_alone(site, self.search.instance) => {
                site.args.iter().any(|arg| holds_all(&arg.from))
            }
            // `f.input = imu.read()?`
            Effect::Write(write) if self.is_part(&write.place) => {
                graph.changes.get(&id).is_some_and(|change| holds_all(&change.computed))
            }
            _ => false,
        });
        if direct {
            return true;
        }
        // `bus.read(&mut buffer)`: what the call writes is the sample.
        let fed = &self.fed().places;
        if !about.lent.is_empty() && about.lent.iter().all(|place| fed.iter().any(|other| other.overlaps(place))) {
            return true;
        }
        let zips = about.names.iter().filter(|name| *name == "zip").count();
        if zips > 0 && !about.names.iter().any(|name| is_of_iterator(name)) {
            // `read().zip(radio())` is absent where either is.
            let has_part = |var: &Var| self.feeds_any(&[*var]) || self.is_instance(&Place::var(*var));
            return about.binds.len() > zips && about.binds.iter().all(has_part);
        }
        // `radio().and(read())` is absent where something is that feeds nothing, unless both are of one object.
        if about.names.iter().any(|name| name == "and") && about.reads.len() != 1 {
            return false;
        }
        if !about.binds.is_empty() {
            return self.feeds_any(&about.binds);
        }
        if self.is_taken_by_helper(&about.reads) {
            return true;
        }
        // `x.is_some()`, `x?`: the variable that is asked, or what the call's result goes into. `read()?` asks for nothing but a name.
        let is_only_called = |place: &Place| {
            self.ty(place).is_some_and(|ty| matches!(ty.peel(), Ty::Function(..)) || ty.called_as().is_some())
        };
        let into = graph.computed.iter().filter(|(_, computed)| {
            computed.calls.iter().any(|name| !is_question(name))
                && holds_names(computed)
                && about.reads.iter().all(|place| computed.places.contains(place))
                && (!about.reads.is_empty() || (asks_name && computed.places.iter().all(is_only_called)))
                // What the filter gave is not what feeds it, but for what it is zipped with.
                && (computed.calls.iter().any(|name| name == "zip") || !computed.places.iter().any(|place| self.lies_in_instance(place)))
        });
        let into: Vec<Var> = into.map(|(var, _)| *var).collect();
        if !into.is_empty() {
            return self.feeds_any(&into);
        }
        // What another method of the same object gives is not what is fed.
        !asks_name
            && about.reads.iter().any(|place| {
                let is_value =
                    !place.steps.is_empty() || place.base_var().is_some_and(|var| graph.var(var).name != "self");
                is_value && self.fed().places.contains(place)
            })
    }
}

pub(super) fn extend(all: &mut Computed, more: &Computed) {
    all.places.extend(more.places.iter().cloned());
    all.calls.extend(more.calls.iter().cloned());
}

fn is_of_iterator(name: &str) -> bool {
    matches!(name, "next" | "iter" | "into_iter" | "iter_mut" | "last" | "nth" | "find" | "next_back")
}

fn is_question(name: &str) -> bool {
    matches!(name, "is_some" | "is_ok" | "is_none" | "is_err" | "ok" | "as_ref" | "as_mut" | "map_err" | "await")
}

/// Whether a word, or several of them, stand in a name: `already` has no `ready` in it. A number may stand behind them.
pub(super) fn has_word(name: &str, word: &str) -> bool {
    let name = name.to_lowercase();
    name.match_indices(word).any(|(at, _)| {
        let (before, after) = (&name[..at], &name[at + word.len()..]);
        let after = after.trim_start_matches(|letter: char| letter.is_ascii_digit());
        (before.is_empty() || before.ends_with('_')) && (after.is_empty() || after.starts_with('_'))
    })
}

#[cfg(test)]
mod tests {
    use super::has_word;

    #[test]
    fn a_part_of_a_word_is_no_word() {
        for name in ["ready", "data_ready", "is_ready", "READY", "ready2", "ready_0"] {
            assert!(has_word(name, "ready"), "{name}");
        }
        for name in ["already_homed", "unready", "readying", "spready_x"] {
            assert!(!has_word(name, "ready"), "{name}");
        }
        assert!(has_word("rx_is_empty", "is_empty") && !has_word("is_emptying", "is_empty"));
        assert!(!has_word("silent", "len") && !has_word("lens_closed", "len"));
    }
}
