//! What a call means to one instance: many targets come down to few different effects.

use std::collections::{BTreeMap, BTreeSet};
use std::rc::Rc;

use super::Search;
use crate::count::aliases::CalledPlace;
use crate::count::answers::Answers;
use crate::count::given::{Given, place_of};
use crate::count::returned;
use crate::count::summary::Outcome;
use crate::flow::{CallSite, Place, Projection, SubjectId};

/// What a call does, whatever the way that leads to it.
#[derive(Debug, Default)]
pub(in crate::count) struct Called {
    /// What it writes, by each of its names, for conditions that read it.
    pub(super) writes: BTreeSet<Place>,
    /// What one of its targets does, each different effect once.
    pub(super) effects: Vec<Effect>,
    /// The caller's subjects of which its ways assume something.
    pub(super) asked: BTreeMap<Given, SubjectId>,
    /// What its result may borrow: the place, and the steps into the result.
    pub(super) borrows: BTreeSet<(Vec<Projection>, Place)>,
}

/// What a target of a call does.
#[derive(Debug, PartialEq, Eq)]
pub(super) struct Effect {
    /// The ways through it, by the places that may be the instance or hold it.
    pub(super) outcomes: Vec<(Place, Vec<Outcome>)>,
    /// The heads that its result may have; none if that is not known.
    pub(super) heads: returned::Heads,
    /// The same, where it depends on what is known here.
    pub(super) answers: Answers,
}

impl Search<'_> {
    /// What a call does, as far as the instance is concerned.
    pub(super) fn called(&self, site: &CallSite) -> Rc<Called> {
        if let Some(known) = self.called.borrow().get(&site.result) {
            return Rc::clone(known);
        }
        let places = self.aliases.called_places(site, self.summaries);
        let is_own = |called: &CalledPlace| called.law == self.law && self.is_among(called.roots(), false);
        // Most calls have nothing to do with most instances, and mean the same to all of those.
        if !places.iter().any(is_own) {
            return self.aliases.call_beside(site, || self.called_with(site, &[]));
        }
        let own: Vec<&CalledPlace> = places.iter().filter(|called| is_own(called)).collect();
        let called = Rc::new(self.called_with(site, &own));
        self.called.borrow_mut().insert(site.result, Rc::clone(&called));
        called
    }

    /// The same, where these of the places that it has to do with may be the instance or hold it.
    fn called_with(&self, site: &CallSite, own: &[&CalledPlace]) -> Called {
        let mut called = Called::default();
        for target in &site.targets {
            let Some(summary) = self.summaries.get(*target) else {
                // A recursion that was not gone through yet adds nothing.
                if !self.summaries.is_open(*target) {
                    called.add(Effect { outcomes: Vec::new(), heads: 0, answers: Answers::new() });
                }
                continue;
            };
            for place in summary.writes.iter().filter_map(|given| place_of(given, site)) {
                called.writes.extend(self.aliases.shared_roots(&place).iter().cloned());
                called.writes.insert(place);
            }
            let outcomes = own.iter().filter(|called| called.target == *target);
            let outcomes = outcomes.map(|called| (called.place.clone(), called.outcomes(self.summaries).to_vec()));
            called.add(Effect { outcomes: outcomes.collect(), heads: summary.heads, answers: summary.answers.clone() });
        }
        let outcomes = called.effects.iter().flat_map(|effect| &effect.outcomes).flat_map(|(_, outcomes)| outcomes);
        let answers = called.effects.iter().flat_map(|effect| &effect.answers).map(|(assumed, _)| assumed);
        let assumed = outcomes.map(|outcome| &outcome.assumed).chain(answers);
        let assumed: BTreeSet<&Given> = assumed.flat_map(BTreeMap::keys).collect();
        let asked = assumed.into_iter().filter_map(|given| Some((given.clone(), self.asked_subject(given, site)?)));
        called.asked = asked.collect();
        called.borrows.extend(self.summaries.borrows(site).map(|(part, place)| (part.to_vec(), place)));
        called
    }
}

impl Called {
    fn add(&mut self, effect: Effect) {
        if !self.effects.contains(&effect) {
            self.effects.push(effect);
        }
    }
}
