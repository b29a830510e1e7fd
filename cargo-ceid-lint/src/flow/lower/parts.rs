//! States that lie in what a literal makes: `let settings = Settings { is_on: self.is_on, gain: adc.read() }`. What is asked of such a
//! part is asked of what the literal was given for it.

use super::{Builder, Value};
use crate::flow::{Assignment, Effect, Head, Node, Place, Projection, Steps, Transfer, Var};
use crate::index::Ty;
use crate::source::Span;
use crate::syntax::tree::ExprId;

/// How many states one value may have for each to be followed.
const MAX_PARTS: usize = 16;

/// The steps to a state in what a literal has made, and its head where that is constant.
pub(super) type StatePart = (Steps, Option<Head>);

impl Builder<'_> {
    /// A part of what a literal makes is a state that is known here, or a value with such parts.
    pub(super) fn state_part(&mut self, part: &Place, value: &Value, expr: ExprId) {
        if self.at.is_none() {
            return;
        }
        let span = self.span(expr);
        if !self.is_state(self.ty(expr)) {
            self.copy_parts(value, part, span);
            // Whether there is something in an answer, a pattern of the whole may ask.
            let is_known = value.same_as.is_some() || value.head.is_some();
            if is_known && self.is_plain_option(self.ty(expr)) {
                let head = value.head.clone().filter(|_| value.same_as.is_none());
                self.note_part(part, head.clone());
                let given = Assignment { same_as: value.same_as, ..given_to(part.clone(), head) };
                self.emit(Effect::Set(Box::new(given)), span);
            }
            return;
        }
        let is_field = matches!(part.steps.last(), Some(Projection::Field(_)));
        let head = value.head.clone().filter(|_| is_field);
        // Which element an index names, may change.
        let is_named = |place: &Place| place.steps.iter().all(|step| step.key().is_none());
        let named = self.static_place(expr).filter(is_named);
        let named = named.filter(|_| is_field && value.same_as.is_none() && head.is_none());
        if value.same_as.is_none() && head.is_none() && named.is_none() {
            // What was known of the one that was made here before says nothing of this one.
            if is_field {
                self.emit(Effect::Set(Box::new(given_to(part.clone(), None))), span);
            }
            return;
        }
        self.note_part(part, head.clone());
        let given = Assignment { same_as: value.same_as, ..given_to(part.clone(), head) };
        let at = self.emit(Effect::Set(Box::new(given)), span);
        self.graph.copies.extend(named.map(|from| (at, from)));
    }

    /// A part of what a literal makes is an option of a reference: whether something is there is known as far as it is of the value.
    pub(super) fn option_part(&mut self, part: Place, value: &Value, expr: ExprId) {
        if self.at.is_none() {
            return;
        }
        self.note_part(&part, value.head.clone());
        let transfer = self.transfer(value, self.ty(expr));
        let (head, same_as) = (value.head.clone(), value.same_as);
        let given = Assignment { from: value.place.clone(), transfer, same_as, ..given_to(part, head) };
        let at = self.emit(Effect::Set(Box::new(given)), self.span(expr));
        let is_copied = value.head.is_none() && same_as.is_none();
        self.graph.copies.extend(value.place.clone().filter(|_| is_copied).map(|from| (at, from)));
    }

    /// A part of what a literal makes has the state that another place has.
    pub(super) fn part_of_state(&mut self, part: Place, from: Place, span: Span) {
        if self.at.is_some() {
            self.note_part(&part, None);
            let at = self.emit(Effect::Set(Box::new(given_to(part, None))), span);
            self.graph.copies.insert(at, from);
        }
    }

    /// The states in what a literal has made are those in the place that gets it.
    pub(super) fn copy_parts(&mut self, value: &Value, to: &Place, span: Span) {
        let Some(var) = value.place.as_ref().filter(|place| place.steps.is_empty()).and_then(Place::base_var) else {
            return;
        };
        for (steps, head) in self.state_parts.get(&var).cloned().unwrap_or_default() {
            if self.at.is_none() {
                return;
            }
            let (part, is_copy) = (to.join(&steps), head.is_none());
            self.note_part(&part, head.clone());
            let is_new = to.base_var().is_some_and(|var| self.is_made_here(var));
            let mut given = Box::new(Assignment { rebinds: is_new, ..given_to(part, head) });
            if self.refers_in(&Place::var(var).join(&steps)) {
                // What it refers to has come with the whole.
                (given.from, given.transfer) = (Some(given.place.clone()), Transfer::Borrow);
            }
            let at = self.emit(if is_new { Effect::Set(given) } else { Effect::Write(given) }, span);
            if is_copy {
                self.graph.copies.insert(at, Place::var(var).join(&steps));
            }
        }
    }

    /// The same where several branches each make a value: which states are in it shows on the way.
    pub(super) fn join_parts(&mut self, value: &Value, join: Var, span: Span) {
        let Some(var) = value.place.as_ref().filter(|place| place.steps.is_empty()).and_then(Place::base_var) else {
            return;
        };
        for (steps, head) in self.state_parts.get(&var).cloned().unwrap_or_default() {
            if self.at.is_none() {
                return;
            }
            let (part, is_copy) = (Place::var(join).join(&steps), head.is_none());
            self.note_part(&part, None);
            let mut given = given_to(part, head);
            if self.refers_in(&Place::var(var).join(&steps)) {
                (given.from, given.transfer) = (Some(given.place.clone()), Transfer::Borrow);
            }
            let at = self.emit(Effect::Set(Box::new(given)), span);
            if is_copy {
                self.graph.copies.insert(at, Place::var(var).join(&steps));
            }
        }
    }

    /// Whether a part of what a literal has made is an option of a reference.
    fn refers_in(&self, part: &Place) -> bool {
        let is_given = |node: &Node| match &node.effect {
            Effect::Set(set) if set.place == *part => Some(set.from.is_some()),
            _ => None,
        };
        self.graph.nodes.iter().rev().find_map(is_given) == Some(true)
    }

    /// Whether a variable holds what is made and is no name of something else.
    fn is_made_here(&self, var: Var) -> bool {
        let info = self.graph.var(var);
        info.param.is_none() && !matches!(info.ty, Ty::Ref(..) | Ty::Pointer(_))
    }

    /// The answer of a call that a part of what was just made is: `match (nav.ingest(z), is_slow()) { … }`.
    pub(super) fn answer_in(&self, part: &Place) -> Option<Var> {
        self.graph.nodes.iter().rev().find_map(|node| match &node.effect {
            Effect::Set(set) if set.place == *part => set.same_as,
            _ => None,
        })
    }

    fn note_part(&mut self, part: &Place, head: Option<Head>) {
        // What has a name may be given another state.
        let made = part.base_var().filter(|var| self.graph.var(*var).name.is_empty());
        let Some(parts) = made.map(|var| self.state_parts.entry(var).or_default()) else { return };
        if parts.len() < MAX_PARTS && parts.iter().all(|(steps, _)| *steps != part.steps) {
            parts.push((part.steps.clone(), head));
        }
    }
}

/// A place is given a value of its own, of which no more is known than its head.
pub(super) fn given_to(place: Place, head: Option<Head>) -> Assignment {
    Assignment { place, from: None, transfer: Transfer::Move, rebinds: true, head, same_as: None }
}
