//! The ways through a whole function, as its callers see them.

use std::collections::{BTreeMap, BTreeSet};

use super::super::assumed::merged;
use super::super::counts::Count;
use super::super::gates::Asks;
use super::super::outcome::Outcome;
use super::super::picked::doubt_of_several;
use super::super::returned;
use super::super::verdict::{Evidence, Gate};
use super::{End, Region, Search, too_many_conditions};
use crate::flow::Cause;
use crate::source::Span;

/// What those who call a function need to know of the ways through it.
pub(in crate::count) struct Ways {
    /// Without those on which there is no such filter.
    pub(in crate::count) outcomes: Vec<Outcome>,
    /// What is given back on any of them.
    pub(in crate::count) heads: returned::Heads,
    /// How many states it took to find them.
    pub(in crate::count) states: usize,
    /// How one of them comes to a second update.
    pub(in crate::count) repeat: Option<Evidence>,
    /// How one of them skips what others update.
    pub(in crate::count) skip: Option<Evidence>,
}

impl Search<'_> {
    /// The ways through the whole function, as its callers see them.
    pub(in crate::count) fn ways(&self, region: Region) -> Ways {
        let starts = self.starts(region);
        let explore = |tells_renewal: bool| {
            self.explored(region, &starts, &|run| {
                run.count_own_loops();
                run.tell_assumed();
                run.tells_renewal = tells_renewal;
            })
        };
        let mut exploration = explore(false);
        // Whether a reset is behind the last update is asked only where a way has both, for it takes more states.
        if exploration.ends.iter().any(|end| end.state.reset && end.state.count != Count::Zero) {
            exploration = explore(true);
        }
        let gates = super::super::gates::Gates::of_helper(self);
        let mut outcomes: BTreeSet<Outcome> = BTreeSet::new();
        // A number of updates that only ways have which may not exist.
        let all: BTreeSet<Count> = exploration.ends.iter().map(|end| end.state.count).collect();
        let certain: BTreeSet<Count> = match all.len() {
            0 | 1 => all,
            _ => {
                let exists = |end: &&End| !self.asks_dropped(&exploration, end);
                exploration.ends.iter().filter(exists).map(|end| end.state.count).collect()
            }
        };
        let mut heads = 0;
        // Where each reason not to update is asked for first: of nested ones the outer comes before the inner, also for callers.
        let mut asked_at: BTreeMap<(Option<Gate>, Option<Asks>), Span> = BTreeMap::new();
        for end in &exploration.ends {
            let returned = returned::of_function(self.program, self.graph.function, end.returned);
            if end.state.count == Count::Zero && super::super::skips::is_of_nothing(self, &exploration, end) {
                heads |= returned;
                continue;
            }
            let gate = gates.of_end(&exploration, end);
            let unknown = end.state.unknown.map(|cause| exploration.causes[cause as usize].clone());
            let asks = gates.asks(&exploration, end);
            let is_explained = gate.is_some() || asks.is_some();
            if let Some(at) = end.state.skipped_at.filter(|_| is_explained) {
                let span = self.graph.node(at).span;
                let first = asked_at.entry((gate, asks.clone())).or_insert(span);
                *first = span.min(*first);
            }
            if end.state.is_supposed || !certain.contains(&end.state.count) && gate.is_none() {
                let cause = unknown.filter(|_| end.state.is_supposed).unwrap_or_else(too_many_conditions);
                outcomes.insert(Outcome { returned, ..Outcome::unknown(cause) });
                continue;
            }
            if let Some(cause) = doubt_of_several(self, &exploration, end).filter(|_| unknown.is_none()) {
                outcomes.insert(Outcome { returned, ..Outcome::unknown(cause) });
                continue;
            }
            let is_passed = super::super::skips::is_passed_by_search(self, region, end)
                || !is_explained && super::super::skips::is_behind_number(self, &exploration, end);
            let unknown = unknown
                .or_else(|| is_passed.then(|| Cause::Index(self.graph.place_name(self.program.index, self.instance))));
            let unknown = unknown.or_else(|| if is_explained { None } else { gates.doubt(end) });
            let moved = || Cause::Moved(self.program.index.function(self.graph.function).name.clone());
            outcomes.insert(Outcome {
                count: end.state.count,
                ahead: end.ahead,
                reset: end.state.reset,
                renewed: end.state.count != Count::Zero && end.state.reset && end.state.is_renewed(),
                unknown: if end.has_left { Some(moved()) } else { unknown },
                direct: end.state.direct,
                returned,
                gate,
                modes: gates.kept_modes(end, gate),
                recalled: gates.recalled(&exploration, end, gate),
                attempted: end.state.attempted,
                asks,
                assumed: end.assumed.clone(),
                left: end.left.clone(),
            });
        }
        if exploration.limit {
            outcomes.insert(Outcome::unknown(Cause::Limit("the function has too many paths".to_owned())));
        }
        outcomes.extend(self.aliases.limit().map(Outcome::unknown));
        let mut all = merged(&outcomes);
        all.sort_by_cached_key(|way| asked_at.get(&(way.gate, way.asks.clone())).copied());
        Ways {
            outcomes: all,
            heads: outcomes.iter().fold(heads, |heads, way| heads | way.returned),
            states: exploration.states.len(),
            repeat: super::super::decide::repeat_of(self, &exploration),
            skip: super::super::decide::skip_of(self, &gates, &exploration),
        }
    }
}
