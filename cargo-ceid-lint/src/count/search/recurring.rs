//! What each state of a search asks for that comes by a node, and that is the same for all of them.

use std::cell::OnceCell;
use std::collections::BTreeMap;
use std::rc::Rc;

use rustc_hash::FxHashMap;

use super::Called;
use super::run::Run;
use crate::count::given::Given;
use crate::flow::{CallSite, NodeId, Place, SubjectId, Var};

/// What was found for earlier states.
#[derive(Debug, Default)]
pub(super) struct Recurring {
    /// Which of the tracked subjects may change where a place is written.
    changing: FxHashMap<Place, Rc<[usize]>>,
    /// What is known behind the writes of the call at a node, by what was known before it.
    behind_writes: FxHashMap<(NodeId, u32), u32>,
    /// What calls ask for of what is tracked, by their results.
    asked_of: FxHashMap<Var, Rc<AskedOf>>,
}

/// What a call asks for of what is tracked, by the place that its callee knows it by.
pub(super) type AskedOf = BTreeMap<Given, Asked>;

/// A tracked subject of which ways through a call assume something.
#[derive(Debug)]
pub(super) struct Asked {
    /// Which one it is.
    pub(super) at: usize,
    /// See [`Run::is_written_by`].
    is_written: OnceCell<bool>,
    /// See [`Run::is_lent_once`].
    is_lent_once: OnceCell<bool>,
}

impl Run<'_, '_> {
    /// Which of the tracked subjects may change where a place is written. Each state that comes by asks for the same places.
    pub(super) fn changed_with(&mut self, place: &Place) -> Rc<[usize]> {
        if let Some(known) = self.recurring.changing.get(place) {
            return Rc::clone(known);
        }
        let reads = |id: &SubjectId| self.search.read_by(*id).is_changed_with(place);
        let all = self.tracked.subjects.iter().enumerate();
        let changing: Rc<[usize]> = all.filter(|(_, id)| reads(id)).map(|(at, _)| at).collect();
        self.recurring.changing.insert(place.clone(), Rc::clone(&changing));
        changing
    }

    /// What is known behind the writes of a call.
    pub(super) fn behind_writes(&mut self, at: NodeId, masks: u32, called: &Called, site: &CallSite) -> u32 {
        if let Some(known) = self.recurring.behind_writes.get(&(at, masks)) {
            return *known;
        }
        let mut after = masks;
        for (place, given) in &called.writes {
            after = self.written(after, place, given.as_ref());
        }
        after = self.killed(after, &Place::var(site.result));
        self.recurring.behind_writes.insert((at, masks), after);
        after
    }

    /// What a call asks for of what is tracked: each state that comes by asks for the same.
    pub(super) fn asked_of(&mut self, site: &CallSite) -> Rc<AskedOf> {
        if let Some(known) = self.recurring.asked_of.get(&site.result) {
            return Rc::clone(known);
        }
        let called = self.search.called(site);
        let at = |id: &SubjectId| self.tracked.subjects.iter().position(|tracked| tracked == id);
        let asked = called.asked.iter().filter_map(|(given, id)| {
            let asked = Asked { at: at(id)?, is_written: OnceCell::new(), is_lent_once: OnceCell::new() };
            Some((given.clone(), asked))
        });
        let asked = Rc::new(asked.collect::<AskedOf>());
        self.recurring.asked_of.insert(site.result, Rc::clone(&asked));
        asked
    }

    /// Whether a call may write what a tracked subject reads.
    pub(super) fn is_written_by(&self, asked: &Asked, site: &CallSite) -> bool {
        *asked.is_written.get_or_init(|| {
            let reads = self.search.read_by(self.tracked.subjects[asked.at]);
            self.search.called(site).writes.keys().any(|place| reads.is_changed_with(place))
        })
    }

    /// Whether a call gets what a condition asks for by one argument only, so that no other one changes it unseen.
    pub(super) fn is_lent_once(&self, asked: &Asked, site: &CallSite) -> bool {
        *asked.is_lent_once.get_or_init(|| {
            let search = self.search;
            let reads = search.read_by(self.tracked.subjects[asked.at]);
            let lends =
                |place: &Place| search.aliases.shared_roots(place).iter().any(|root| reads.is_changed_with(root));
            site.args.iter().filter_map(|arg| arg.place.as_ref()).filter(|place| lends(place)).count() <= 1
        })
    }
}
