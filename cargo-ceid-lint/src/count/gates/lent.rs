//! Filters that a helper lends or says to be absent: `if let Some(f) = self.active() { f.update(x); }`. What decides over that may be
//! something else than whether there is a filter.

use super::Gates;
use crate::count::verdict::Gate;
use crate::flow::{CallSite, ChangeKind, Effect, Place, Test, deciding, told};
use crate::index::{FunctionId, Ty};
use crate::syntax::tree::Body;

impl Gates<'_, '_> {
    /// What a test waits for that asks whether the filter is there; `None` if it asks for something else.
    pub(super) fn of_presence(&self, test: &Test) -> Option<Option<Gate>> {
        if !test.about.is_presence || self.is_tried(test) || !self.is_presence_of_filter(test) {
            return None;
        }
        let changing = self.deciding_over(test);
        if changing.is_empty() {
            let is_mode = self.changes_owner() || self.drops_filter();
            return Some(Some(if is_mode { Gate::Mode } else { Gate::Config }));
        }
        let is_mode = changing.iter().all(|place| {
            let mut assigning = self.assigning(place).peekable();
            assigning.peek().is_some()
                && assigning.all(|node| self.resets_around(node, place, &|_| true))
                && !self.calls_write(place)
        });
        Some(is_mode.then_some(Gate::Mode))
    }

    /// Whether the cycle gives the filter up, here or in a helper: another one begins anew. `self.lp = None;`
    fn drops_filter(&self) -> bool {
        let graph = self.search.graph;
        let instance = self.search.instance;
        self.nodes().any(|id| match &graph.node(id).effect {
            Effect::Write(write) | Effect::Set(write) => {
                let is_taken = self.change(id) == Some(ChangeKind::Empties);
                write.head.as_deref() == Some("-") && !write.rebinds && !is_taken && instance.lies_at(&write.place)
            }
            Effect::Call(site) => self
                .sets_by(site, instance)
                .any(|(head, change)| head.as_deref() == Some("-") && change != ChangeKind::Empties),
            _ => false,
        })
    }

    /// Whether a lock is asked for that is not waited for, which fails while another holds it: that is no setting.
    pub(super) fn is_tried(&self, test: &Test) -> bool {
        let tries = |name: &String| name.starts_with("try_");
        test.about.names.iter().any(tries)
            || self.asked_helpers(test).any(|(_, body)| told(body).calls.iter().any(tries))
    }

    /// What changes in the cycle and decides over whether the helper that a test asks gives the filter, beside the filter itself.
    fn deciding_over(&self, test: &Test) -> Vec<Place> {
        let mut found = Vec::new();
        for (site, body) in self.asked_helpers(test) {
            for (number, fields) in deciding(body) {
                let Some(arg) = site.args.get(number) else { continue };
                let owner = arg.value_of.as_ref().or(arg.place.as_ref());
                let places: Vec<Place> = match owner {
                    Some(owner) => vec![fields.iter().fold(owner.clone(), |place, name| place.field(name))],
                    None if fields.is_empty() => arg.from.places.clone(),
                    None => Vec::new(),
                };
                found.extend(places.into_iter().filter(|place| self.decides_anew(place)));
            }
        }
        found
    }

    /// Whether a place is no filter and has another value in another iteration.
    fn decides_anew(&self, place: &Place) -> bool {
        let is_plain = match self.ty(place).as_ref().map(Ty::peel) {
            Some(Ty::Bool | Ty::Int | Ty::Float | Ty::Char) => true,
            Some(Ty::Adt(..)) => !place.steps.is_empty(),
            _ => false,
        };
        let changes = || {
            !self.outlives(place) && !self.is_invariant(place, 0)
                || self.assigning(place).next().is_some()
                || self.calls_write(place)
        };
        is_plain && !self.is_instance(place) && changes()
    }

    /// The calls of functions with a body by whose name a test asks.
    pub(super) fn asked_helpers<'b>(&'b self, test: &'b Test) -> impl Iterator<Item = (&'b CallSite, &'b Body)> {
        let index = self.search.program.index;
        let is_named = |target: &FunctionId| test.about.names.contains(&index.function(*target).name);
        self.nodes().filter_map(move |id| {
            let Effect::Call(site) = &self.search.graph.node(id).effect else { return None };
            let [target] = site.targets.as_slice() else { return None };
            let owner = site.args.first().and_then(|arg| arg.place.as_ref());
            let is_asked = owner.is_none_or(|owner| test.about.reads.iter().any(|read| read.overlaps(owner)));
            let body = index.function(*target).function.body.as_ref()?;
            (is_named(target) && is_asked).then_some((&**site, body))
        })
    }
}
