//! How the places of a graph relate to the instance under all of its names.

use std::sync::Arc;

use super::State;
use super::run::Run;
use crate::flow::{IndexKey, Place, Relation};

impl Run<'_, '_> {
    /// How an access of this place relates to each name of the instance.
    pub(super) fn relations(&self, state: &State, place: &Place) -> Vec<Relation> {
        let names = self.names.get(state.names);
        let relate = |name: &Place| match self.search.counts_behind(place, name) {
            true => Relation::Apart,
            false => place.relate(name, &|var| self.number(state, var)),
        };
        names.iter().map(relate).collect()
    }

    /// As [`Self::relations`], where an element that stands for each is the one that the instance is.
    pub(super) fn relations_to_each(&self, state: &State, place: &Place) -> Vec<Relation> {
        if !place.stands_for_several() {
            return self.relations(state, place);
        }
        let names = self.names.get(state.names);
        let own = |name: &Place| {
            if name.base != place.base {
                return Relation::Apart;
            }
            let (mut place, mut name) = (place.clone(), name.clone());
            for (step, of_name) in Arc::make_mut(&mut place.steps).iter_mut().zip(Arc::make_mut(&mut name.steps)) {
                let is_own = match (step.key(), of_name.key()) {
                    (Some(IndexKey::Each), Some(_)) => {
                        of_name.clone_from(step);
                        false
                    }
                    (Some(IndexKey::EachIn(section)), Some(IndexKey::Number(number))) => {
                        section.is_written_with(*number)
                    }
                    _ => false,
                };
                if is_own {
                    step.clone_from(of_name);
                }
            }
            place.relate(&name, &|var| self.number(state, var))
        };
        names.iter().map(own).collect()
    }
}
