//! Elements of an array that are guarded one by one, because their laws take inputs: the array is taken apart above the loop.

use std::collections::BTreeSet;

use super::body::LoopBody;
use super::holding::Found;
use super::mentions::Guarded;
use super::sites::{Part, Place, Site, number, place_of};
use crate::index::Ty;
use crate::syntax::tree::{ExprId, ExprKind};

/// Gives the elements places of their own where a guard cannot have the array as it is.
pub(super) fn take_apart(of: &LoopBody<'_>, found: &mut [Found<'_>]) {
    let arrays: BTreeSet<Place> = found.iter().map(|(_, (place, ..), _)| place.clone()).collect();
    for array in arrays {
        let sites = || found.iter().filter(|(_, (place, ..), _)| *place == array).flat_map(|(_, _, sites)| sites);
        let is_outside = |site: &Site| !matches!(site.filter, Ty::Adt(..));
        // A guard of the array would update all elements.
        let numbers: BTreeSet<u64> = sites().filter_map(|site| number_of(&site.part)).collect();
        let lengths = sites().filter_map(|site| length(of, site.at));
        let is_partial = lengths.min().is_some_and(|length| (numbers.len() as u64) < length);
        let needs_it = is_partial
            || sites().any(|site| !site.inputs.is_empty() || site.is_used || site.half > 0 || is_outside(site));
        let is_literal = |site: &Site| {
            number_of(&site.part).is_some_and(|number| length(of, site.at).is_some_and(|length| number < length))
        };
        // Where the array is used as a whole, its elements are lent without taking it apart, as long as their laws are fed.
        let is_fed = sites().all(|site| !site.inputs.is_empty());
        let has_other_use = (is_fed || is_partial) && is_used_as_a_whole(of, &array);
        if !needs_it || !sites().all(is_literal) || has_other_use {
            continue;
        }
        for (_, (place, at, _), sites) in found.iter_mut().filter(|(_, (place, ..), _)| *place == array) {
            for site in sites {
                let Some(number) = number_of(&site.part) else { continue };
                site.place.element = Some(number);
                site.part = Part::Whole;
                site.at = of.parent(site.at).unwrap_or(site.at);
                (place.element, *at) = (Some(number), site.at);
            }
        }
    }
}

/// The number of the element, if the part is one.
fn number_of(part: &Part) -> Option<u64> {
    match part {
        Part::Element(number) => Some(*number),
        _ => None,
    }
}

/// Whether the loop uses an array otherwise than by its numbered elements.
fn is_used_as_a_whole(of: &LoopBody<'_>, array: &Place) -> bool {
    of.names(array.local).any(|name| {
        let place = std::iter::once(name).chain(of.ancestors_inside(name));
        let place =
            place.take_while(|at| place_of(of, *at).is_some_and(|place| array.fields.starts_with(&place.fields)));
        let Some(at) = place.last().filter(|at| place_of(of, *at).as_ref() == Some(array)) else { return false };
        let parent = of.parent(at).map(|parent| of.kind(parent));
        !matches!(parent, Some(ExprKind::Index { base, index }) if *base == at && number(of, *index).is_some())
    })
}

/// The length of an array that can be taken apart.
fn length(of: &LoopBody<'_>, array: ExprId) -> Option<u64> {
    match of.typed.ty(array) {
        Ty::Array(_, length) => length.value,
        Ty::Ref(true, inner) => match &**inner {
            Ty::Array(_, length) => length.value,
            _ => None,
        },
        _ => None,
    }
}

/// The statements that take the arrays apart.
pub(super) fn statements(of: &LoopBody<'_>, guarded: &[Guarded]) -> Vec<String> {
    let mut seen = BTreeSet::new();
    let mut statements = Vec::new();
    for own in guarded.iter().filter(|own| own.place.element.is_some()) {
        let array = Place { element: None, ..own.place.clone() };
        let ExprKind::Index { base, .. } = of.kind(own.at) else { continue };
        let Some(length) = length(of, *base).filter(|_| seen.insert(array.clone())) else { continue };
        let mut names: Vec<String> = Vec::new();
        for number in 0..length {
            let is_it = |other: &&Guarded| other.place == Place { element: Some(number), ..array.clone() };
            let is_last = |other: &Guarded| {
                Place { element: None, ..other.place.clone() } == array && other.place.element >= Some(number)
            };
            match guarded.iter().find(is_it) {
                Some(other) => names.push(other.name.clone()),
                None if guarded.iter().any(is_last) => names.push("_".to_owned()),
                None => {
                    names.push("..".to_owned());
                    break;
                }
            }
        }
        let through = if matches!(of.typed.ty(*base), Ty::Ref(..)) { "*" } else { "" };
        statements.push(format!("let [{}] = &mut {through}{};", names.join(", "), of.written(*base)));
    }
    statements
}
