//! Copies that come back to the place that they were made of.

use std::collections::BTreeSet;

use super::Builder;
use crate::flow::{Assignment, Cause, Effect, IndexKey, NodeId, Place, Projection, Transfer, Var};

/// How many nodes before an assignment are looked at for the parts of a literal.
const MAX_PARTS: usize = 64;

impl Builder<'_> {
    /// A filter that gets a copy of itself back, on which nothing went on, has no new state.
    pub(super) fn keep_unchanged(&mut self, copied_at: NodeId, vars: &BTreeSet<Var>, origin: &Place) {
        let is_filter = |var: &Var| self.program.index.filter_spec(&self.graph.var(*var).ty).is_some();
        let is_one = |place: &Place| place.steps.is_empty() && place.base_var().is_some_and(|var| vars.contains(&var));
        let is_from = |set: &Assignment| set.from.as_ref().is_some_and(is_one);
        let is_other = |id: NodeId| match &self.graph.node(id).effect {
            Effect::Set(set) | Effect::Write(set) => id != copied_at && is_one(&set.place) && !is_from(set),
            _ => false,
        };
        if !vars.iter().all(is_filter) || self.graph.node_ids().any(is_other) || self.is_given_owner(origin) {
            return;
        }
        // What was taken before the loop is what the filter began with.
        let made_in = self.graph.node(copied_at).in_loop;
        let back = self.graph.node_ids().filter_map(|id| match &self.graph.node(id).effect {
            Effect::Write(set) if set.place == *origin && is_from(set) => Some((id, set.from.clone()?)),
            _ => None,
        });
        let back: Vec<(NodeId, Place)> = back.filter(|(id, _)| self.graph.node(*id).in_loop == made_in).collect();
        for (id, copy) in back {
            self.graph.nodes[id.0 as usize].effect = Effect::Reset { place: origin.clone(), full: false };
            self.graph.given_away.insert((id, copy));
        }
    }

    /// Whether what holds a place is given as a whole, and what was in that place is gone.
    fn is_given_owner(&self, place: &Place) -> bool {
        let holds = |owner: &Place| owner.steps.len() < place.steps.len() && owner.overlaps(place);
        self.graph.nodes.iter().any(|node| match &node.effect {
            Effect::Set(set) | Effect::Write(set) => !set.rebinds && holds(&set.place),
            _ => false,
        })
    }

    /// The same for what is kept in another place in between: `self.saved = self.lag; …; self.lag = self.saved;`
    pub(super) fn keep_saved(&mut self) {
        let writes = self.graph.node_ids().filter_map(|id| match &self.graph.node(id).effect {
            Effect::Write(set) if set.transfer == Transfer::Copy => Some((id, &set.place, set.from.as_ref()?)),
            _ => None,
        });
        let writes: Vec<(NodeId, &Place, &Place)> = writes.collect();
        let loop_of = |id: NodeId| self.graph.node(id).in_loop;
        let is_updated = |place: &Place| {
            self.graph.nodes.iter().any(|node| match &node.effect {
                Effect::Update(update) => update.place == *place,
                Effect::Call(site) => {
                    let filter = site.law_of.and_then(|number| site.args.get(number)?.place.as_ref());
                    filter == Some(place)
                }
                _ => false,
            })
        };
        let is_saved = |(id, place, from): &&(NodeId, &Place, &Place)| {
            let saves = |(other, to, what): &(NodeId, &Place, &Place)| {
                to == from && what == place && loop_of(*other) == loop_of(*id)
            };
            writes.iter().any(saves) && is_updated(place) && !is_updated(from) && !self.is_given_owner(place)
        };
        let back: Vec<(NodeId, Place)> =
            writes.iter().filter(is_saved).map(|(id, place, _)| (*id, (*place).clone())).collect();
        for (id, place) in back {
            self.graph.nodes[id.0 as usize].effect = Effect::Reset { place, full: false };
        }
    }

    /// A part of a place that a literal gets a copy of, and that goes back to that place with the literal, has been there all the time:
    /// `state = State { gain: 0.5, lag: state.lag };`
    pub(super) fn keep_parts(&mut self) {
        let mut kept: BTreeSet<NodeId> = BTreeSet::new();
        for id in self.graph.node_ids() {
            let (Effect::Set(whole) | Effect::Write(whole)) = &self.graph.node(id).effect else { continue };
            let literal = whole.from.as_ref().filter(|from| from.steps.is_empty()).and_then(Place::base_var);
            let Some(literal) = literal.filter(|var| self.graph.var(*var).name.is_empty()) else { continue };
            let is_own = |part: &Assignment| {
                part.transfer == Transfer::Copy
                    && part.place.base_var() == Some(literal)
                    && !part.place.steps.is_empty()
                    && part.from == Some(whole.place.join(&part.place.steps))
            };
            let parts: Vec<NodeId> = (0..id.0)
                .rev()
                .map(NodeId)
                .take(MAX_PARTS)
                .filter(|at| match &self.graph.node(*at).effect {
                    Effect::Set(part) | Effect::Write(part) => is_own(part),
                    _ => false,
                })
                .collect();
            // What the literal asks for in between may have gone on with the part.
            let from = parts.last().map_or(id.0, |first| first.0);
            let is_plain = (from..id.0)
                .map(NodeId)
                .all(|at| matches!(self.graph.node(at).effect, Effect::Set(_) | Effect::Nothing | Effect::Use { .. }));
            if is_plain && !parts.is_empty() {
                kept.extend(parts.into_iter().chain([id]));
            }
        }
        for id in kept {
            if let Effect::Set(set) | Effect::Write(set) = &mut self.graph.nodes[id.0 as usize].effect {
                set.transfer = Transfer::Move;
            }
        }
    }

    /// What is put back at a node is not followed.
    pub(super) fn lose_put_back(&mut self, id: NodeId, what: &str) {
        let node = &mut self.graph.nodes[id.0 as usize];
        let (Effect::Set(set) | Effect::Write(set)) = &node.effect else { return };
        let places = std::iter::once(&set.place).chain(&set.from).cloned().collect();
        node.effect = Effect::Unknown { places, cause: Cause::Code(what.to_owned()) };
    }

    /// Whether a place is what a loop binds of a place.
    pub(super) fn is_element_of(&self, place: &Place, origin: &Place) -> bool {
        let mut items = self.graph.loops.iter().flat_map(|info| &info.items);
        items.any(|(item, source)| place.base_var() == Some(*item) && source.overlaps(origin))
    }

    /// Whether a loop lends the elements of what one of the variables holds.
    pub(super) fn lends_elements(&self, vars: &BTreeSet<Var>) -> bool {
        let mut sources = self.graph.loops.iter().flat_map(|info| &info.items).map(|(_, source)| source);
        sources.any(|source| source.base_var().is_some_and(|var| vars.contains(&var)))
    }

    /// Notes where single elements are put back of a copy whose elements a loop updates: which ones are, is not followed.
    pub(super) fn loses_elements(&mut self, vars: &BTreeSet<Var>, origin: &Place) -> bool {
        let nodes = self.put_back_singly(vars, origin);
        for id in &nodes {
            self.lose_put_back(*id, "a copy of which single elements are put back");
        }
        !nodes.is_empty()
    }

    /// Where single elements of what one of the variables holds go back to where they are from, and not each in its own round.
    pub(super) fn put_back_singly(&self, vars: &BTreeSet<Var>, origin: &Place) -> Vec<NodeId> {
        let is_one = |place: &Place| place.base_var().is_some_and(|var| vars.contains(&var));
        let is_counted = |place: &Place| matches!(place.steps.last().and_then(Projection::key), Some(IndexKey::Var(_)));
        let is_part = |id: &NodeId| match &self.graph.node(*id).effect {
            Effect::Set(set) | Effect::Write(set) => {
                set.place.overlaps(origin)
                    && set.place.steps.len() > origin.steps.len()
                    && set
                        .from
                        .as_ref()
                        .is_some_and(|from| is_one(from) && !(is_counted(from) && is_counted(&set.place)))
            }
            _ => false,
        };
        self.graph.node_ids().filter(is_part).collect()
    }
}
