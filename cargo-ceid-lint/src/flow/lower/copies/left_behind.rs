//! Copies of what nothing asks for again: these are moves, as they would be if the type were not `Copy`.

use std::collections::BTreeSet;

use super::{MAX_HOLDING, is_value};
use crate::flow::lower::Builder;
use crate::flow::{Assignment, Effect, Node, NodeId, Place, Projection, Transfer, Var};
use crate::index::Ty;

impl Builder<'_> {
    /// What is copied out of a variable that holds it itself is moved if nothing asks for it there again:
    /// `let Estimator { mut lag, pi } = self; …; Estimator { lag, pi }`, `Imu { bias, rate }`, `spawner.spawn(task(rig.lag))`.
    pub(super) fn settle_left_behind(&mut self) {
        let is_owned = |var: &Var| is_value(&self.graph.var(*var).ty);
        let taken = self.graph.nodes.iter().filter_map(|node| match &node.effect {
            Effect::Set(set) if self.takes_copied(set) => set.place.base_var(),
            _ => None,
        });
        let locals =
            (0u32..).zip(&self.graph.vars).map(|(number, _)| Var(number)).filter(|var| self.is_own_local(*var));
        let holding = self.graph.params.iter().copied().chain(taken).chain(locals);
        let mut holding: BTreeSet<Var> = holding.filter(is_owned).collect();
        let mut has_moved = true;
        while std::mem::take(&mut has_moved) {
            for id in self.graph.node_ids() {
                let Some(into) = self.part_left_behind(id, &holding) else { continue };
                if let Effect::Set(set) | Effect::Write(set) = &mut self.graph.nodes[id.0 as usize].effect {
                    set.transfer = Transfer::Move;
                }
                has_moved |= holding.insert(into);
                self.leave_out_between(id, into);
            }
        }
    }

    /// Whether a variable has a name and is no other name of what lies elsewhere, such as of an element.
    fn is_own_local(&self, var: Var) -> bool {
        let info = self.graph.var(var);
        let is_item = || self.graph.loops.iter().any(|own| own.bound.contains(&var));
        let is_lent = |node: &Node| match &node.effect {
            Effect::Set(set) => {
                set.place.base_var() == Some(var) && set.from.is_some() && set.transfer == Transfer::Borrow
            }
            _ => false,
        };
        info.param.is_none() && !info.name.is_empty() && !is_item() && !self.graph.nodes.iter().any(is_lent)
    }

    /// Leaves out a variable in between that only hands on what was moved into it: what takes it from there takes it from where it was.
    fn leave_out_between(&mut self, moved_at: NodeId, between: Var) {
        let whole = Place::var(between);
        let is_it = |place: &Place| place.base == whole.base;
        let Effect::Set(moved) = &self.graph.node(moved_at).effect else { return };
        let Some(from) = moved.from.clone().filter(|_| moved.place == whole) else { return };
        let is_fixed = |id: NodeId| match &self.graph.node(id).effect {
            Effect::Set(set) | Effect::Write(set) => id != moved_at && is_it(&set.place),
            Effect::Call(site) => site.result == between || site.into.contains(&between),
            Effect::Use { place } | Effect::Reset { place, .. } => is_it(place),
            Effect::Update(update) => is_it(&update.place) || update.given.as_ref().is_some_and(is_it),
            Effect::Advance(advance) => is_it(&advance.before) || is_it(&advance.after),
            Effect::Unknown { places, .. } => places.iter().any(is_it),
            Effect::Return(value) => value.place.as_ref().is_some_and(is_it),
            _ => false,
        };
        let is_known = !self.graph.var(between).name.is_empty() || self.graph.params.contains(&between);
        if is_known || self.graph.node_ids().any(is_fixed) {
            return;
        }
        for node in &mut self.graph.nodes {
            match &mut node.effect {
                Effect::Set(set) | Effect::Write(set) => {
                    if let Some(source) = set.from.as_mut().filter(|source| is_it(source)) {
                        *source = from.join(&source.steps);
                    }
                }
                Effect::Call(site) => {
                    for arg in &mut site.args {
                        if let Some(place) = arg.place.as_mut().filter(|place| is_it(place)) {
                            *place = from.join(&place.steps);
                            arg.is_copy = false;
                        }
                    }
                }
                _ => {}
            }
        }
        self.graph.nodes[moved_at.0 as usize].effect = Effect::Nothing;
    }

    /// The variable that a node gives a copy of a part of one of these, if nothing asks for the part again.
    fn part_left_behind(&self, id: NodeId, holding: &BTreeSet<Var>) -> Option<Var> {
        let (Effect::Set(set) | Effect::Write(set)) = &self.graph.node(id).effect else { return None };
        let from = set.from.as_ref().filter(|from| from.base_var().is_some_and(|var| holding.contains(&var)))?;
        let into = set.place.base_var().filter(|_| set.transfer == Transfer::Copy)?;
        let is_left = |this: &Self| {
            // What takes the place of what has gone elsewhere for good is another filter, which is no business of this one's.
            let goes_round = || this.way_back(id, into, from).is_some() && this.is_left_behind(id, from, true);
            this.is_left_behind(id, from, false) || goes_round()
        };
        (self.lies_inside(from) && is_left(self)).then_some(into)
    }

    /// Whether a place is a variable or lies in one, and not behind a reference or handle in it.
    fn lies_inside(&self, place: &Place) -> bool {
        let Some(var) = place.base_var() else { return false };
        let mut steps = place.steps.iter().map(|step| match step {
            Projection::Field(name) => Some(&**name),
            _ => None,
        });
        let mut ty = Some(self.graph.var(var).ty.clone());
        while let Some(step) = steps.next() {
            ty = match (ty, step) {
                (Some(Ty::Tuple(parts)), Some(name)) => {
                    name.parse::<usize>().ok().and_then(|number| parts.get(number).cloned())
                }
                (Some(owner), Some(name)) => match self.program.index.variant_named(&owner, name) {
                    None => self.program.index.field_ty(&owner, None, name),
                    number => steps.next().flatten().and_then(|name| self.program.index.field_ty(&owner, number, name)),
                },
                _ => None,
            };
        }
        ty.is_some_and(|ty| is_value(&ty))
    }

    /// Whether nothing behind a node that reads a place has to do with that place again, and nothing refers to it; an assignment to it
    /// may be the end of that.
    fn is_left_behind(&self, read_at: NodeId, place: &Place, ends_by_write: bool) -> bool {
        let is_it = |other: &Place| other.overlaps(place);
        let refers = |set: &Assignment| set.transfer == Transfer::Borrow && set.from.as_ref().is_some_and(is_it);
        let is_lent = |node: &Node| matches!(&node.effect, Effect::Set(set) | Effect::Write(set) if refers(set));
        // What is given to the variable, or to a part around the place, as a whole is another one.
        let is_around = |other: &Place| other.base == place.base && place.steps.starts_with(&other.steps);
        let is_given_anew = |node: &Node| match &node.effect {
            Effect::Set(set) => {
                set.place.steps.is_empty() && is_around(&set.place) && !set.from.as_ref().is_some_and(is_it)
            }
            Effect::Write(set) => ends_by_write && is_around(&set.place) && !set.from.as_ref().is_some_and(is_it),
            _ => false,
        };
        let concerns = |node: &Node| match &node.effect {
            Effect::Use { place } | Effect::Reset { place, .. } => is_it(place),
            Effect::Update(update) => is_it(&update.place),
            Effect::Advance(advance) => is_it(&advance.before) || is_it(&advance.after),
            Effect::Set(set) | Effect::Write(set) => is_it(&set.place) || set.from.as_ref().is_some_and(is_it),
            Effect::Call(site) => site.args.iter().filter_map(|arg| arg.place.as_ref()).any(is_it),
            Effect::Unknown { places, .. } => places.iter().any(is_it),
            Effect::Return(value) => value.place.as_ref().is_some_and(is_it),
            _ => false,
        };
        if self.graph.nodes.iter().any(is_lent) {
            return false;
        }
        let mut seen = BTreeSet::new();
        // What runs elsewhere leaves the place to the code behind it as well.
        let outermost = self.graph.loops_around(read_at).last().map(|id| self.graph.loop_info(id).head);
        let begun_at = [Some(read_at), outermost].into_iter().flatten();
        let forks = begun_at.flat_map(|node| self.graph.forks_before(node));
        let behind = forks.filter_map(|fork| self.graph.node(fork).next.first());
        let mut open: Vec<NodeId> = self.graph.node(read_at).next.iter().chain(behind).copied().collect();
        while let Some(id) = open.pop().filter(|_| seen.len() < MAX_HOLDING) {
            if !seen.insert(id) {
                continue;
            }
            if is_given_anew(self.graph.node(id)) {
                continue;
            }
            if concerns(self.graph.node(id)) {
                return false;
            }
            open.extend(&self.graph.node(id).next);
        }
        seen.len() < MAX_HOLDING
    }
}
