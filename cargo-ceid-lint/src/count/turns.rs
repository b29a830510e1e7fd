//! States that decide over the updates in a function and that it goes on with by itself, such as counters and flags that it turns
//! round: the next call of it may find another answer.

use std::collections::{BTreeMap, BTreeSet};

use super::counts::Count;
use super::given::{Given, given, place_of};
use super::outcome::Outcome;
use super::search::Search;
use super::summary::Summary;
use crate::flow::{CallSite, ChangeKind, Effect, Place};
use crate::index::Ty;

/// Notes the states that decide over the updates of a place.
pub(super) fn note(search: &Search<'_>, of: &Given, summary: &mut Summary) {
    let turned = deciding(search, summary);
    summary.turns.entry(of.clone()).or_default().extend(turned);
}

/// The states that decide over the updates of an instance, of which nothing but the function says what they become.
fn deciding(search: &Search<'_>, summary: &Summary) -> BTreeSet<Given> {
    let (graph, aliases) = (search.graph, search.aliases);
    let mut kinds: BTreeMap<&Given, Vec<Option<ChangeKind>>> = BTreeMap::new();
    for (given, head, change) in &summary.sets {
        kinds.entry(given).or_default().push(if head.is_some() { Some(ChangeKind::Constant) } else { *change });
    }
    let is_own = |kind: &Option<ChangeKind>| {
        use ChangeKind::{Constant, CountsDown, CountsUp, Toggles, Wraps};
        matches!(kind, Some(Constant | CountsUp | CountsDown | Wraps | Toggles))
    };
    kinds.retain(|_, kinds| kinds.iter().all(is_own));
    if kinds.is_empty() {
        return BTreeSet::new();
    }
    let updating = search.updating();
    let mut found = BTreeSet::new();
    for branch in search.branches_before(updating.iter().copied()) {
        let Effect::Branch(test) = &graph.node(branch).effect else { continue };
        let subject = test.subject.map(|id| &graph.subjects[id.0 as usize]);
        let reads = test.about.reads.iter().chain(subject.into_iter().flat_map(|subject| &subject.reads));
        let roots = reads.flat_map(|place| aliases.shared_roots(place).to_vec());
        // What a parameter holds by value is another one than the caller's.
        let is_lent = |root: &Place| root.base_var().is_none_or(|var| matches!(graph.var(var).ty, Ty::Ref(..)));
        for asked in roots.filter(is_lent).filter_map(|root| given(graph, &root)) {
            let Some(kinds) = kinds.get(&asked) else { continue };
            // What only goes up stays above a limit.
            let is_one_way = kinds.iter().all(|kind| *kind == Some(ChangeKind::CountsUp))
                && !test.about.is_remainder
                && !test.about.is_masked;
            if !is_one_way {
                found.insert(asked);
            }
        }
    }
    for node in updating {
        let Effect::Call(site) = &graph.node(node).effect else { continue };
        let roots = search.turned_by(site).into_iter().filter_map(|root| given(graph, &root));
        found.extend(roots.filter(|given| kinds.contains_key(given)));
    }
    found
}

impl Search<'_> {
    /// The states that decide over what a call does to the instance, and that it goes on with by itself.
    pub(super) fn turned_by(&self, site: &CallSite) -> Vec<Place> {
        self.turned_where(site, &|_, _| true)
    }

    /// The same, but for those of which callers know how they go on.
    pub(super) fn turned_unknown_by(&self, site: &CallSite) -> Vec<Place> {
        self.turned_where(site, &|ways, turned| {
            let is_kept = |way: &Outcome| way.assumed.get(turned).is_some_and(|heads| heads.is_kept);
            !ways.iter().all(|way| way.count == Count::Zero || way.left.contains_key(turned) || is_kept(way))
        })
    }

    fn turned_where(&self, site: &CallSite, is_meant: &dyn Fn(&[Outcome], &Given) -> bool) -> Vec<Place> {
        let roots = |given: &Given| {
            let place = place_of(given, site);
            place.map(|place| self.aliases.shared_roots(&place).to_vec()).unwrap_or_default()
        };
        let mut found = Vec::new();
        for summary in site.targets.iter().filter_map(|target| self.summaries.get(*target)) {
            let own = summary.outcomes(self.law);
            for (given, ways) in own.filter(|(given, _)| roots(given).iter().any(|root| root.overlaps(self.instance))) {
                let turned = summary.turns.get(given).into_iter().flatten();
                found.extend(turned.filter(|turned| is_meant(ways, turned)).flat_map(roots));
            }
        }
        found
    }
}
