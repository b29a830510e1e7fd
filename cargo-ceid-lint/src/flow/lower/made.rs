//! Guards that are made and not bound yet: what they were given, and where they go.

use super::{Builder, Value};
use crate::flow::{Cause, Effect, LoopId, Place, Var};
use crate::index::Ty;
use crate::source::Span;

/// What a guard was given.
#[derive(Clone, Debug)]
pub(super) struct Lent {
    /// Its name, for messages.
    pub(super) name: String,
    /// Where it is.
    pub(super) place: Place,
    /// The variable that the guard knows it by.
    pub(super) held: Var,
    pub(super) ty: Ty,
}

/// A guard that no name holds yet.
#[derive(Clone, Debug)]
pub(super) struct Made {
    /// Where it is.
    pub(super) place: Place,
    pub(super) lent: Vec<Lent>,
    pub(super) span: Span,
    in_loop: Option<LoopId>,
    /// How many nodes there were when it came to be there.
    born: usize,
    /// Whether it went into something else by value: it does not end with its statement.
    is_moved: bool,
    /// Whether it is the value of a branch, and the branches have not met yet.
    is_arriving: bool,
}

impl Builder<'_> {
    /// A guard over places comes about.
    pub(super) fn note_made(&mut self, place: Place, given: Vec<(String, Place, Ty)>, span: Span) {
        let mut lent = Vec::new();
        for (name, place, ty) in given {
            let held = self.temporary(Ty::Unknown, span);
            self.set(held, &Value { place: Some(place.clone()), ..Value::default() }, span);
            lent.push(Lent { name, place, held, ty });
        }
        self.add_made(place, lent, span);
    }

    pub(super) fn add_made(&mut self, place: Place, lent: Vec<Lent>, span: Span) {
        let (in_loop, born) = (self.loops.last().copied(), self.graph.nodes.len());
        self.made.push(Made { place, lent, span, in_loop, born, is_moved: false, is_arriving: false });
    }

    /// Whether a guard that no name holds is at a place, or in what holds that.
    pub(super) fn is_made(&self, place: &Place) -> bool {
        self.made.iter().any(|made| place.lies_at(&made.place))
    }

    /// Takes the guards that are or lie at a place.
    pub(super) fn take_made(&mut self, place: &Place) -> Vec<Made> {
        let (found, others) = std::mem::take(&mut self.made).into_iter().partition(|made| made.place.lies_at(place));
        self.made = others;
        found
    }

    /// A value goes to another place, and the guards that it holds with it.
    pub(super) fn move_made(&mut self, from: Option<&Place>, to: &Place) {
        let Some(from) = from else { return };
        for made in self.made.iter_mut().filter(|made| made.place.lies_at(from)) {
            made.place = to.join(&made.place.steps[from.steps.len()..]);
            made.is_moved = true;
        }
    }

    /// A value goes where it is not followed.
    pub(super) fn lose_made(&mut self, value: &Value) {
        if let Some(place) = &value.place {
            for made in self.made.iter_mut().filter(|made| made.place.lies_at(place)) {
                made.is_moved = true;
            }
        }
    }

    /// A branch ends with its value: a guard there is, where the branches meet, over what each of them gave it.
    pub(super) fn join_made(&mut self, value: &Value, join: Var, span: Span) {
        let Some(from) = value.place.clone().filter(|place| *place != Place::var(join)) else { return };
        for made in self.take_made(&from) {
            let place = Place::var(join).join(&made.place.steps[from.steps.len()..]);
            let known = self.made.iter().position(|own| own.place == place);
            let mut lent = known.map(|at| self.made.remove(at).lent).unwrap_or_default();
            let mut used = vec![false; lent.len()];
            for own in made.lent {
                let slot = (0..used.len()).find(|at| !used[*at] && lent[*at].ty == own.ty);
                let given = Value { place: Some(Place::var(own.held)), ..Value::default() };
                match slot {
                    Some(at) => {
                        used[at] = true;
                        self.set(lent[at].held, &given, span);
                    }
                    None => {
                        let held = self.temporary(Ty::Unknown, span);
                        self.set(held, &given, span);
                        lent.push(Lent { place: Place::var(held), held, ..own });
                    }
                }
            }
            self.add_made(place, lent, made.span);
            if let Some(joined) = self.made.last_mut() {
                joined.is_arriving = true;
            }
        }
    }

    /// The branches have met.
    pub(super) fn joined_made(&mut self, join: Var) {
        let born = self.graph.nodes.len();
        for made in self.made.iter_mut().filter(|made| made.place.base_var() == Some(join)) {
            (made.is_arriving, made.born) = (false, born);
        }
    }

    /// The end of a statement: a guard that is still without a name is dropped there, or was moved where it is not followed.
    pub(super) fn settle_made(&mut self, first: usize, span: Span) {
        if self.at.is_none() {
            return;
        }
        let in_loop = self.loops.last().copied();
        let is_left = |made: &Made| made.born >= first && made.in_loop == in_loop && !made.is_arriving;
        let (left, others) = std::mem::take(&mut self.made).into_iter().partition::<Vec<Made>, _>(is_left);
        self.made = others;
        for made in left {
            if made.is_moved {
                let places = made.lent.iter().map(|lent| Place::var(lent.held)).collect();
                let cause = Cause::Code("where its guard goes".to_owned());
                self.emit(Effect::Unknown { places, cause }, span);
            } else {
                let at = made.span;
                let guard = self.guard_from(made);
                self.drop_early(guard, at, "no name holds it, so that its statement drops it");
            }
        }
    }
}
