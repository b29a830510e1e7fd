//! Truth values that a call sets beside an update of its own: what is asked of one behind the call tells whether the update ran.

use std::collections::BTreeMap;

use super::exploration::Exploration;
use super::{Search, State};
use crate::count::counts::Count;
use crate::count::given::{Given, place_of};
use crate::count::instances::place_ty;
use crate::flow::{CallSite, Effect, Head, Place};
use crate::index::Ty;

impl Search<'_> {
    /// Whether a way comes to its second update only where a truth value is not what the call with the first one sets it to:
    /// `self.poll(); if !self.done { f.update(x); }`.
    pub(in crate::count) fn asks_what_a_call_sets(&self, exploration: &Exploration, end: usize) -> bool {
        let path = exploration.path(end);
        let states: Vec<&State> = path.iter().map(|at| &exploration.states[*at]).collect();
        let mut flags: Vec<(Place, Vec<Head>)> = Vec::new();
        for (state, next) in states.iter().zip(states.iter().skip(1)) {
            let node = self.graph.node(state.node);
            match &node.effect {
                Effect::Call(site) if state.count == Count::Zero && next.count == Count::One => {
                    flags = self.flags_of(site);
                }
                Effect::Branch(test) if state.count == Count::One => {
                    let Some(id) = test.subject else { continue };
                    let (subject, reads) = (&self.graph.subjects[id.0 as usize], self.read_by(id));
                    let taken = if node.next.first() == Some(&next.node) { test.holds } else { test.fails };
                    let is_other = |(flag, heads): &(Place, Vec<Head>)| {
                        reads.is_changed_with(flag) && heads.iter().all(|head| subject.bit(head) & taken == 0)
                    };
                    if flags.iter().any(is_other) {
                        return true;
                    }
                }
                _ => {}
            }
        }
        false
    }

    /// The truth values that a call sets to nothing but constants, with these.
    fn flags_of(&self, site: &CallSite) -> Vec<(Place, Vec<Head>)> {
        let mut found = Vec::new();
        for summary in site.targets.iter().filter_map(|target| self.summaries.get(*target)) {
            let mut sets: BTreeMap<&Given, Vec<Option<&Head>>> = BTreeMap::new();
            for (given, head, _) in &summary.sets {
                sets.entry(given).or_default().push(head.as_ref());
            }
            for (given, heads) in sets {
                let heads: Option<Vec<Head>> = heads.into_iter().map(Option::<&Head>::cloned).collect();
                let (Some(place), Some(heads)) = (place_of(given, site), heads) else { continue };
                if place_ty(self.program.index, self.graph, &place) == Some(Ty::Bool) {
                    found.extend(self.aliases.shared_roots(&place).iter().map(|root| (root.clone(), heads.clone())));
                }
            }
        }
        found
    }
}
