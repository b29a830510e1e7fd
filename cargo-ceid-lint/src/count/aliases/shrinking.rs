//! Slices that get shorter in each round of a loop: `rest = &mut rest[8..];`

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use crate::flow::{IndexKey, Place, Projection, Section};

/// In how many rounds the elements are told apart by their numbers.
const MAX_SHIFTS: usize = 4;

/// The place without the numbers of its elements and slices, if it has some.
pub(super) fn without_numbers(place: &Place) -> Option<Place> {
    let unnumbered = |step: &Projection| {
        let key = match step.key()? {
            IndexKey::Number(_) => IndexKey::Data(Arc::from("..")),
            IndexKey::Slice(section) if section.is_exact => IndexKey::Slice(Section::unknown("..")),
            IndexKey::EachIn(section) if section.is_exact => IndexKey::EachIn(Section::unknown("..")),
            _ => return None,
        };
        Some(step.with_key(key))
    };
    let steps = place.steps.iter().map(|step| unnumbered(step).unwrap_or_else(|| step.clone())).collect();
    let found = Place { base: place.base, steps };
    (found != *place).then_some(found)
}

/// Whether what a place is a name of is followed from several other parts of the same variable, each of which began before the next one: the
/// variable is given a part of itself again and again. What is still followed has no names yet.
pub(super) fn comes_from_itself(seen: &BTreeMap<Place, BTreeSet<Place>>, place: &Place) -> bool {
    let Some(number) = first_number(place) else { return false };
    let whole = Place::from(place.base);
    let of_variable = seen.range(whole..).take_while(|(other, _)| other.base == place.base);
    let is_before = |other: &Place| {
        other.steps.len() == place.steps.len() && first_number(other).is_some_and(|before| before < number)
    };
    of_variable.filter(|(other, names)| names.is_empty() && is_before(other)).nth(MAX_SHIFTS).is_some()
}

/// The number of the first element of what a place leads to, if it is known.
fn first_number(place: &Place) -> Option<u64> {
    place.steps.iter().rev().find_map(|step| match step.key()? {
        IndexKey::Number(number) => Some(*number),
        IndexKey::Slice(section) | IndexKey::EachIn(section) if section.is_exact => Some(section.from),
        _ => None,
    })
}
