//! States that are chosen by a number or key which changes: `if self.enabled[slot] { … }`.

use super::Gates;
use super::sources::is_arithmetic;
use super::state::is_pure;
use crate::count::fed::named;
use crate::count::search::Region;
use crate::flow::{Computed, Effect, IndexKey, Place, Projection, Var};

impl Gates<'_, '_> {
    /// Whether a place lies in an element of which the iteration changes the number or key.
    pub(super) fn is_at_another_number(&self, place: &Place) -> bool {
        let is_assigned = |name: &str| {
            self.nodes().any(|id| match &self.search.graph.node(id).effect {
                Effect::Write(write) | Effect::Set(write) => self.last_name(&write.place) == name,
                _ => false,
            })
        };
        let is_changed = |key: &IndexKey| match key {
            IndexKey::Var(number) => self.is_number_of_iteration(*number, place),
            IndexKey::Data(text) => {
                text.rsplit('.').next().is_some_and(is_assigned)
                    || words(text).any(|name| self.named_so(name).any(|var| self.is_number_of_iteration(var, place)))
            }
            _ => false,
        };
        place.steps.iter().filter_map(Projection::key).any(is_changed)
    }

    /// Whether a variable is counted on by the iteration, or computed from what it reads. What a loop over elements binds tells
    /// which of them is asked, and what the filter has as its own number is no other one's.
    fn is_number_of_iteration(&self, var: Var, asked: &Place) -> bool {
        let counts = |number: &Place| {
            self.outlives(number) && !self.is_own_number(number) && self.assigning(number).next().is_some()
        };
        let number = Place::var(var);
        if self.outlives(&number) {
            return counts(&number);
        }
        // The number of the round, which is the iteration: `for i in 0..frames { if input[i] == 0.0 { continue; } … }`.
        if !self.is_of_element && self.binds(var) {
            return true;
        }
        let is_key = |step: &Projection| step.key() == Some(&IndexKey::Var(var));
        let is_of_filter = |place: &Place| place.steps.iter().any(is_key);
        let updating = self.search.updating();
        let is_shared = || {
            updating.iter().any(|id| match &self.search.graph.node(*id).effect {
                Effect::Update(update) => is_of_filter(&update.place),
                Effect::Call(site) => site.args.iter().filter_map(|arg| arg.place.as_ref()).any(is_of_filter),
                _ => false,
            })
        };
        if is_of_filter(self.search.instance) || is_shared() || self.is_bound_inside(var) {
            return false;
        }
        let sources = self.assignments().behind(&Computed { places: vec![number], calls: Vec::new() });
        sources.places.iter().any(|place| {
            if self.outlives(place) {
                return !asked.overlaps(place) && counts(place);
            }
            place.base_var().is_some_and(|var| self.is_read_anew(var))
        })
    }

    /// Whether a variable of the iteration is what a call gave that asks for no setting, nor for what a loop over elements binds.
    fn is_read_anew(&self, var: Var) -> bool {
        let graph = self.search.graph;
        let is_fixed = |place: &Place| {
            self.is_invariant(place, 0) || place.base_var().is_some_and(|var| self.is_bound_inside(var))
        };
        !self.is_bound_inside(var)
            && graph.computed.get(&var).is_some_and(|computed| {
                let is_read = |name: &String| !is_pure(name) && !is_arithmetic(name);
                computed.calls.iter().any(is_read) && !named(&computed.places).into_iter().any(is_fixed)
            })
    }

    /// Whether a loop in the iteration binds a variable.
    fn is_bound_inside(&self, var: Var) -> bool {
        let graph = self.search.graph;
        (0u32..)
            .zip(&graph.loops)
            .any(|(number, info)| self.region != Region::Loop(crate::flow::LoopId(number)) && info.bound.contains(&var))
    }

    /// The variables with a name.
    fn named_so(&self, name: &str) -> impl Iterator<Item = Var> {
        let vars = self.search.graph.vars.iter().zip(0u32..);
        vars.filter(move |(info, _)| info.name == name).map(|(_, number)| Var(number)).collect::<Vec<_>>().into_iter()
    }
}

/// The names in the text of an index that stand for themselves: `x` and `shift` in `(x as usize + self.base + shift) % 3`.
fn words(text: &str) -> impl Iterator<Item = &str> {
    let is_letter = |letter: char| letter.is_alphanumeric() || letter == '_';
    let mut before = '\0';
    let mut found = Vec::new();
    let mut at = 0;
    while let Some(begin) = text[at..].find(is_letter).map(|to| at + to) {
        let end = text[begin..].find(|letter| !is_letter(letter)).map_or(text.len(), |to| begin + to);
        if begin > 0 {
            before = text[..begin].chars().next_back().unwrap_or(' ');
        }
        if before != '.' && !text[end..].starts_with(['(', '.', ':']) {
            found.push(&text[begin..end]);
        }
        at = end;
    }
    found.into_iter()
}
