//! Modes: states in which a filter pauses, with a reset before it runs again.

use std::collections::BTreeMap;

use super::{Gates, Way};
use crate::count::search::Mode;
use crate::count::verdict::Gate;
use crate::flow::{Effect, OTHER_HEADS, Place, Projection, Subject, SubjectId, Test};

impl Gates<'_, '_> {
    /// Whether a state decides over the updates, and every pause that it makes goes with a reset.
    pub(super) fn is_mode(&self, subject: SubjectId) -> bool {
        if let Some(known) = self.modes.borrow().get(&subject) {
            return *known;
        }
        let is_mode = self.judge_mode(subject);
        self.modes.borrow_mut().insert(subject, is_mode);
        is_mode
    }

    fn judge_mode(&self, subject: SubjectId) -> bool {
        // A state that nothing here switches is no mode of this cycle.
        let reads = &self.search.graph.subjects[subject.0 as usize].reads;
        if reads.iter().all(|place| self.is_left_alone(place)) {
            return false;
        }
        self.updating(subject).is_some_and(|updating| {
            self.search.resets_in_pauses(self.region, Mode { subject, updating, asked_by: None })
        })
    }

    /// A way on which a mode is left without an update.
    pub(super) fn leaves_mode(&self, way: &Way) -> Option<Gate> {
        let graph = self.search.graph;
        let mut last: BTreeMap<&Place, Option<&str>> = BTreeMap::new();
        for id in &way.nodes {
            if let Effect::Set(set) | Effect::Write(set) = &graph.node(*id).effect {
                last.insert(&set.place, set.head.as_deref());
            }
        }
        let left = (0u32..).zip(&graph.subjects).find(|(number, subject)| {
            let Some(place) = &subject.whole else { return false };
            let Some(Some(head)) = last.get(place) else { return false };
            self.outlives(place)
                && self.updating(SubjectId(*number)).is_some_and(|updating| updating & subject.bit(head) == 0)
                && self.is_mode(SubjectId(*number))
        });
        left.map(|_| Gate::Mode)
    }

    /// The heads of a state with which an iteration can reach an update; `None` if it can with each, or with none.
    pub(super) fn updating(&self, id: SubjectId) -> Option<u32> {
        // It is asked for each way, and walks the whole graph for each head.
        if let Some(known) = self.updating.borrow().get(&id) {
            return *known;
        }
        let updating = self.judge_updating(id);
        self.updating.borrow_mut().insert(id, updating);
        updating
    }

    fn judge_updating(&self, id: SubjectId) -> Option<u32> {
        let graph = self.search.graph;
        let subject = &graph.subjects[id.0 as usize];
        let updates = self.search.updating();
        let all = subject.anything();
        let bits = (0..u32::try_from(subject.heads.len()).unwrap_or(0)).map(|number| 1 << number);
        let mut updating = 0;
        for bit in bits.chain([OTHER_HEADS]).filter(|bit| all & bit != 0) {
            let reached = self.reached(|node, edge| match &graph.node(node).effect {
                Effect::Branch(test) if test.subject == Some(id) => {
                    let heads = if edge == 0 { test.holds } else { test.fails };
                    heads & bit != 0
                }
                _ => true,
            });
            if updates.iter().any(|node| reached[node.0 as usize]) {
                updating |= bit;
            }
        }
        (updating != 0 && updating != all).then_some(updating)
    }

    /// A filter that lies in a variant is there only while the enum is that variant: a way on which it is another one.
    pub(super) fn of_payload(&self, way: &Way) -> Option<Gate> {
        let graph = self.search.graph;
        let is_absent = way.nodes.iter().zip(way.nodes.iter().skip(1)).any(|(id, next)| {
            let Effect::Branch(test) = &graph.node(*id).effect else { return false };
            let heads = if graph.node(*id).next.first() == Some(next) { test.holds } else { test.fails };
            self.asked_owner(test).is_some_and(|(subject, variant)| heads & subject.bit(variant) == 0)
        });
        is_absent.then(|| if self.changes_owner() { Gate::Mode } else { Gate::Config })
    }

    /// The enum that a test asks for its variant, if the instance lies in one of them: that one.
    fn asked_owner(&self, test: &Test) -> Option<(&Subject, &str)> {
        let subject = &self.search.graph.subjects[test.subject?.0 as usize];
        let roots = self.search.aliases.roots(subject.whole.as_ref()?);
        let [root] = roots.as_slice() else { return None };
        let variant = self.owners().find(|(owner, _)| owner == root).map(|(_, variant)| variant)?;
        Some((subject, variant))
    }

    /// The enums that the instance lies in, each with the variant.
    fn owners(&self) -> impl Iterator<Item = (Place, &str)> + '_ {
        let instance = self.search.instance;
        instance.steps.iter().enumerate().filter_map(|(at, step)| {
            let Projection::Field(variant) = step else { return None };
            let owner = Place { base: instance.base, steps: instance.steps[..at].to_vec() };
            self.is_enum(&owner).then_some((owner, &**variant))
        })
    }

    /// Whether the cycle makes another variant of an enum that the instance lies in.
    pub(super) fn changes_owner(&self) -> bool {
        self.owners().any(|(owner, _)| {
            self.nodes().any(|id| match &self.search.graph.node(id).effect {
                Effect::Write(write) | Effect::Set(write) => write.place == owner,
                Effect::Call(site) => self.written_by(site).any(|written| written == owner),
                _ => false,
            })
        })
    }

    fn is_enum(&self, place: &Place) -> bool {
        match self.ty(place) {
            Some(crate::index::Ty::Adt(id, _)) => {
                matches!(self.search.program.index.type_def(id).shape, crate::index::Shape::Enum(_))
            }
            _ => false,
        }
    }
}
