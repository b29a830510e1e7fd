//! Questions to the filter itself: what they read is a setting, or a state that nothing but its own updates and resets change.

use super::signals::{OF_NUMBERS, may_be_time};
use super::{Gates, Way};
use crate::count::verdict::Gate;
use crate::flow::{Argument, CallSite, Effect, NodeId, Place, Test};
use crate::index::{FunctionId, Ty};

impl Gates<'_, '_> {
    /// Why a filter skips that is asked itself. What nothing in the cycle changes is a setting; what only updates and resets change
    /// stays as it is while the filter pauses. What the cycle feeds is neither, but for a filter that says that it is at rest.
    pub(super) fn own_state(&self, test: &Test, at: NodeId, way: &Way) -> Option<Gate> {
        if !self.asks_only_filter(test) {
            return None;
        }
        if test.about.rest.is_some() {
            return self.is_at_rest(test, at, way).then_some(Gate::Mode);
        }
        let subject = &self.search.graph.subjects[test.subject?.0 as usize];
        // What a helper finds as it is may be changed by its caller, who is asked.
        let gate = self.changed_by(&subject.reads, way).filter(|gate| !self.is_helper || *gate == Gate::Mode)?;
        let changes = |outer: &&Self| outer.changed_by(&subject.reads, way) != Some(Gate::Config);
        if gate == Gate::Config
            && let Some(outer) = self.around().iter().find(changes)
        {
            return outer.own_state(test, at, &outer.way_through(at, way));
        }
        if gate == Gate::Mode {
            if self.may_resume(way) || self.locks_itself_out(test) {
                return None;
            }
            self.own_states.borrow_mut().extend(subject.reads.iter().map(|place| (place.clone(), Vec::new())));
        }
        Some(gate)
    }

    /// Whether the answer on the way is that a filter is at rest, where an update would change nothing.
    fn is_at_rest(&self, test: &Test, at: NodeId, way: &Way) -> bool {
        let holds = way.after(at) == self.search.graph.node(at).next.first().copied();
        test.about.rest == Some(holds)
    }

    /// Whether something else than filters is asked before, and another answer leads to an update: the pause may end with that.
    fn may_resume(&self, way: &Way) -> bool {
        let graph = self.search.graph;
        let of_filters = |test: &Test| {
            let reads = &test.about.reads;
            !reads.is_empty() && reads.iter().all(|place| self.is_in_filter(place))
        };
        let asked = way.nodes.iter().take_while(|node| **node != way.at);
        asked.zip(way.nodes.iter().skip(1)).any(|(node, taken)| match &graph.node(*node).effect {
            Effect::Branch(test) if !of_filters(test) => {
                graph.node(*node).next.iter().any(|next| next != taken && self.reach()[next.0 as usize])
            }
            _ => false,
        })
    }

    /// Whether a filter that is fed with readings is left out because of a number that only its updates change: while the readings go on,
    /// it stands still for ever. What nobody feeds, as a ramp, has come to its end.
    pub(super) fn locks_itself_out(&self, test: &Test) -> bool {
        let is_number =
            |place: &Place| matches!(self.ty(place), Some(Ty::Float)) || self.is_of_filter_as_a_whole(place);
        let brings = |name: &String| !may_be_time(name) && !OF_NUMBERS.contains(&name.as_str());
        self.asks_only_filter(test)
            && (test.about.is_comparison || self.hands_reading_on(test))
            && test.subject.is_some_and(|id| self.search.graph.subjects[id.0 as usize].reads.iter().all(is_number))
            && self.fed().calls.iter().any(brings)
    }

    /// Whether a condition gives what it reads of the filter to a function, which compares it: `if is_allowed(lag.level()) { … }`.
    pub(super) fn hands_reading_on(&self, test: &Test) -> bool {
        let is_free = |target: &FunctionId| {
            let function = &self.search.program.index.function(*target).function;
            function.receiver.is_none()
        };
        let is_reading = |arg: &Argument| arg.place.as_ref().is_none_or(|place| !self.is_of_filter_as_a_whole(place));
        self.asked_helpers(test).any(|(site, _)| site.targets.iter().all(is_free) && site.args.iter().all(is_reading))
    }

    /// Whether a condition asks for what updates of the filter change, or something else does.
    pub(super) fn asks_changed_state(&self, test: &Test, way: &Way) -> bool {
        let subject = test.subject.map(|id| &self.search.graph.subjects[id.0 as usize]);
        let reads = subject.map_or(&test.about.reads, |subject| &subject.reads);
        reads.iter().any(|place| self.lies_in_instance(place)) && self.changed_by(reads, way) != Some(Gate::Config)
    }

    /// Whether a place is a filter: a getter of which the fields are not known that it reads.
    fn is_of_filter_as_a_whole(&self, place: &Place) -> bool {
        self.ty(place).is_some_and(|ty| self.search.program.index.filter_spec(ty.peel()).is_some())
    }

    /// What the values at these places of filters wait for: `None` if something else than an update or a reset changes one of them,
    /// or one of these does so on the way.
    fn changed_by(&self, reads: &[Place], way: &Way) -> Option<Gate> {
        let index = self.search.program.index;
        let is_handed = |place: &Place| self.ty(place).is_some_and(|ty| index.returned_spec(ty.peel()).is_some());
        if reads.is_empty() || reads.iter().any(is_handed) || is_handed(self.search.instance) {
            return None;
        }
        let roots: Vec<Place> = reads.iter().flat_map(|place| self.search.aliases.roots(place)).collect();
        let is_read = |place: &Place| {
            self.search.aliases.shared_roots(place).iter().any(|root| roots.iter().any(|read| read.overlaps(root)))
        };
        let mut gate = Gate::Config;
        for id in self.nodes() {
            match self.change_at(id, &is_read) {
                Some(OwnChange::Other) => return None,
                Some(OwnChange::Law) if way.nodes.contains(&id) => return None,
                Some(OwnChange::Law | OwnChange::Reset) => gate = Gate::Mode,
                None => {}
            }
        }
        Some(gate)
    }

    /// How a node changes what a question reads, if it does.
    fn change_at(&self, id: NodeId, is_read: &dyn Fn(&Place) -> bool) -> Option<OwnChange> {
        match &self.search.graph.node(id).effect {
            Effect::Reset { place, .. } if is_read(place) => Some(OwnChange::Reset),
            // What a law does whose body is not known may be anything.
            Effect::Update(update) if is_read(&update.place) && !self.is_seen_law(id) => Some(OwnChange::Law),
            Effect::Call(site) if self.written_by(site).any(|place| is_read(&place)) => match site.law_of {
                Some(_) => Some(OwnChange::Law),
                // A helper may write there by the law alone.
                None if !self.alters(site, is_read) => Some(OwnChange::Law),
                None => Some(OwnChange::Other),
            },
            // A new reference leaves alone what it refers to.
            Effect::Write(write) | Effect::Set(write) if !write.rebinds && is_read(&write.place) => {
                let is_name = write.place.steps.is_empty()
                    && write.from.is_some()
                    && self.search.aliases.roots(&write.place) != [write.place.clone()];
                (!is_name).then_some(OwnChange::Other)
            }
            Effect::Unknown { places, .. } if places.iter().any(is_read) => Some(OwnChange::Other),
            _ => None,
        }
    }

    /// Whether a call writes one of these places otherwise than by the law of a filter there.
    fn alters(&self, site: &CallSite, is_one: &dyn Fn(&Place) -> bool) -> bool {
        self.search.summaries.places(site, |summary| &summary.alters).any(|place| is_one(&place))
    }

    /// Whether the body of the law is known that an update runs.
    fn is_seen_law(&self, id: NodeId) -> bool {
        let graph = self.search.graph;
        let span = graph.node(id).span;
        let is_it = |site: &CallSite| site.law_of.is_some() && !site.targets.is_empty();
        self.nodes().any(|other| {
            graph.node(other).span == span && matches!(&graph.node(other).effect, Effect::Call(site) if is_it(site))
        })
    }

    /// A question to nothing but the filter itself, or to its siblings: `if smoother.is_smoothing() { smoother.next() }`.
    fn asks_only_filter(&self, test: &Test) -> bool {
        let index = self.search.program.index;
        let reads = &test.about.reads;
        let is_filter = |place: &Place| self.ty(place).is_some_and(|ty| index.filter_spec(ty.peel()).is_some());
        // Where a filter is at rest, so are its parts.
        let is_whole = |place: &Place| {
            let roots = self.search.aliases.roots(place);
            test.about.rest.is_some() && roots.iter().any(|root| root.overlaps(self.search.instance))
        };
        let is_asked = |place: &Place| self.lies_in_instance(place) || is_whole(place);
        !test.about.is_presence
            && reads.iter().any(is_asked)
            && reads.iter().all(|place| is_asked(place) || is_filter(place))
    }

    /// The other half of such a question: `if a.is_smoothing() || b.is_smoothing() { a.next(); b.next() }`. What it asks says no, and
    /// no update on the way changes that.
    pub(super) fn asks_sibling_too(&self, test: &Test, at: NodeId, way: &Way) -> Option<Gate> {
        let graph = self.search.graph;
        let reads = &test.about.reads;
        if test.about.is_presence || reads.is_empty() || !reads.iter().all(|place| self.is_in_filter(place)) {
            return None;
        }
        let reach = self.reach();
        let asked_at = way.nodes.iter().position(|node| *node == at)?;
        // The filter itself was asked before, and would have been updated had it said yes.
        let was_asked = way.nodes[..asked_at].windows(2).any(|pair| match &graph.node(pair[0]).effect {
            Effect::Branch(before) => {
                let others = graph.node(pair[0]).next.iter().filter(|next| **next != pair[1]);
                self.asks_only_filter(before)
                    && self.own_state(before, pair[0], way).is_some()
                    && others.clone().count() > 0
                    && others.clone().all(|next| reach[next.0 as usize])
            }
            _ => false,
        });
        let gate = self.changed_by(reads, way).or_else(|| self.is_at_rest(test, at, way).then_some(Gate::Mode));
        gate.filter(|_| was_asked)
    }

    /// Whether a place is a filter, or lies in one: what a question is put to, or a field of it that its body reads.
    fn is_in_filter(&self, place: &Place) -> bool {
        self.has_filter(place, 0)
    }

    /// Whether a place lies in another filter than the instance and the one whose method this is.
    pub(super) fn is_in_other_filter(&self, place: &Place) -> bool {
        let is_own = place.base_var().is_some_and(|var| self.search.graph.var(var).name == "self");
        !self.is_instance(place) && self.has_filter(place, usize::from(is_own))
    }

    /// Whether a place, or what it is a part of by this many steps or more, is a filter.
    fn has_filter(&self, place: &Place, steps: usize) -> bool {
        let index = self.search.program.index;
        (steps..=place.steps.len()).any(|count| {
            let owner = place.up_to(count);
            self.ty(&owner).is_some_and(|ty| index.filter_spec(ty.peel()).is_some())
        })
    }
}

/// What changes a filter's own state.
enum OwnChange {
    /// An update of it, or of a sibling that is asked as well.
    Law,
    /// A reset.
    Reset,
    /// Anything else, as what it is fed with.
    Other,
}
