//! Places that a call does something to, as the calling function knows them.

use std::collections::BTreeSet;
use std::sync::Arc;

use super::counts::Count;
use super::given::{Given, GivenBase};
use super::outcome::Outcome;
use super::summary::{Summaries, Summary};
use crate::flow::{CallSite, IndexKey, Place, Projection, Relation};
use crate::index::FunctionId;

/// A place that a target of a call has ways for.
#[derive(Debug)]
pub(super) struct CalledPlace {
    pub(super) target: FunctionId,
    pub(super) law: usize,
    /// Its number among the places for which the target has ways.
    pub(super) number: usize,
    /// The place here.
    pub(super) place: Place,
    /// The places that it may be a name of, unless that is only itself.
    pub(super) others: Option<Arc<[Place]>>,
    /// The first elements, or those behind them, that are all the target has ways for, where the place is each of them.
    pub(super) taken: Vec<Place>,
}

impl CalledPlace {
    /// The places that it may be a name of.
    pub(super) fn roots(&self) -> &[Place] {
        self.others.as_deref().unwrap_or(std::slice::from_ref(&self.place))
    }

    /// Whether an instance is none of the elements that the target has ways for.
    pub(super) fn stops_before(&self, instance: &Place) -> bool {
        let is_apart = |place: &Place| matches!(place.relate(instance, &|_| None), Relation::Apart);
        !self.taken.is_empty() && self.taken.iter().all(is_apart)
    }

    /// Whether the target joins there what it does to each of several types.
    pub(super) fn is_mixed(&self, summaries: &Summaries) -> bool {
        self.is_among(summaries, |summary| &summary.mixed)
    }

    /// Whether the target treats the elements that the place stands for differently, and the instance is one of them by its number.
    pub(super) fn is_uneven(&self, summaries: &Summaries, instance: &Place) -> bool {
        let tells_apart = |root: &Place| {
            let mut keys = root.steps.iter().zip(instance.steps.iter()).map(|(step, own)| (step.key(), own.key()));
            keys.any(|keys| matches!(keys, (Some(IndexKey::Each), Some(own)) if *own != IndexKey::Each))
        };
        self.roots().iter().any(tells_apart) && self.is_uneven_for_each(summaries)
    }

    /// Whether the target treats the elements that the place stands for differently.
    pub(super) fn is_uneven_for_each(&self, summaries: &Summaries) -> bool {
        self.is_among(summaries, |summary| &summary.uneven)
    }

    /// Whether the target updates the place in nothing but cycles of its own.
    pub(super) fn runs_own_cycles(&self, summaries: &Summaries) -> bool {
        self.is_among(summaries, |summary| &summary.cycles)
    }

    /// Whether the target tells this of the place.
    fn is_among(&self, summaries: &Summaries, told: impl Fn(&Summary) -> &BTreeSet<Given>) -> bool {
        summaries.get(self.target).is_some_and(|summary| {
            let place = summary.outcomes(self.law).nth(self.number);
            place.is_some_and(|(given, _)| told(summary).contains(given))
        })
    }

    /// Whether the target goes past the first elements and may do another thing with each of the others.
    pub(super) fn passes_over(&self) -> bool {
        let is_skipped =
            |step: &Projection| matches!(step.key(), Some(IndexKey::EachIn(section)) if section.is_skipped());
        self.taken.iter().flat_map(|place| place.steps.iter()).any(is_skipped)
    }

    /// The ways through the target.
    pub(super) fn outcomes<'a>(&self, summaries: &'a Summaries) -> &'a [Outcome] {
        let summary = summaries.get(self.target);
        let ways = summary.and_then(|summary| summary.outcomes(self.law).nth(self.number));
        ways.map_or(&[], |(_, outcomes)| outcomes.as_slice())
    }
}

impl Summary {
    /// Whether all that happens to a place is that it gets another value, and a call lends a reference there: `*slot = value`.
    pub(super) fn only_points(&self, given: &Given, outcomes: &[Outcome], site: &CallSite) -> bool {
        let GivenBase::Param(number) = given.base else { return false };
        let is_whole = given.steps.is_empty() && self.generic.contains(&number);
        is_whole
            && site.args.get(number).is_some_and(|arg| arg.lends_references)
            && outcomes.iter().all(|outcome| outcome.count == Count::Zero && outcome.unknown.is_none())
    }
}
