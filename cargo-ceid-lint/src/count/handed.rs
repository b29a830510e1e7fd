//! States that are no receivers: which places hold them, and what calls make of those that they hand through.

use rustc_hash::FxHashSet;

use super::aliases::Aliases;
use super::counts::Count;
use super::given::place_of;
use super::outcome::Outcome;
use super::summary::{Summaries, Summary};
use crate::flow::{CallSite, ControlFlowGraph, Effect, Place, Update};

impl Summaries {
    /// The ways through the targets of a call for the state that it hands through.
    pub(super) fn handed(&self, site: &CallSite, law: usize) -> Vec<Outcome> {
        let before = site.handed().map(|(_, before)| before);
        let outcomes = site.targets.iter().filter_map(|target| self.get(*target)).flat_map(|known| known.outcomes(law));
        let of_state = outcomes.filter(|(given, _)| place_of(given, site).as_ref() == before);
        of_state.flat_map(|(_, outcomes)| outcomes.iter().cloned()).collect()
    }

    /// Whether a law that gives back the next state may run in a call.
    pub(super) fn gives_next(&self, site: &CallSite) -> bool {
        site.targets.iter().filter_map(|target| self.get(*target)).any(|callee| callee.gives_next)
    }

    /// The halves of laws by which the state that a call hands through may be ahead of the one before.
    pub(super) fn advanced<'a>(&'a self, site: &'a CallSite) -> impl Iterator<Item = usize> + 'a {
        let before = site.handed().map(|(_, before)| before);
        let summaries = site.targets.iter().filter_map(|target| self.get(*target));
        summaries.flat_map(Summary::outcomes_by_half).filter_map(move |(law, given, outcomes)| {
            let advances = outcomes.iter().any(|outcome| outcome.total() != Count::Zero);
            (advances && place_of(given, site).as_ref() == before).then_some(law)
        })
    }

    /// The places that are the states of laws that have them in an argument, here or in what is called.
    pub(super) fn states_of(&self, graph: &ControlFlowGraph, aliases: &Aliases) -> FxHashSet<Place> {
        let mut states = FxHashSet::default();
        for node in &graph.nodes {
            match &node.effect {
                Effect::Update(update) if !update.is_typed && !is_idle(aliases, update) => {
                    states.extend(aliases.roots(&update.place));
                }
                Effect::Advance(advance) => states.extend(aliases.roots(&advance.before)),
                Effect::Call(site) => states.extend(self.updates(site).flat_map(|place| aliases.roots(&place))),
                _ => {}
            }
        }
        states
    }

    /// The places that a call updates on some way.
    pub(super) fn updates<'a>(&'a self, site: &'a CallSite) -> impl Iterator<Item = Place> + 'a {
        let summaries = site.targets.iter().filter_map(|target| self.get(*target));
        summaries.flat_map(Summary::all_outcomes).filter_map(|(given, outcomes)| {
            let updates = outcomes.iter().any(|outcome| outcome.total() != Count::Zero || outcome.attempted);
            updates.then(|| place_of(given, site)).flatten()
        })
    }
}

/// Whether what takes a state's place comes from no law.
pub(super) fn is_idle(aliases: &Aliases, update: &Update) -> bool {
    update.given.as_ref().is_some_and(|given| !aliases.has_advanced(given))
}
