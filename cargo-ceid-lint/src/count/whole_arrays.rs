//! Elements of an array that are never named while others are: each is an instance as well, and is owed what those are.

use std::collections::BTreeSet;

use crate::flow::IndexKey;
use crate::index::{Index, TypeId};

/// The keys of all elements of an array of that length, some of which are named by these; `None` if none is, or one of the names may be
/// that of any element. Where variants name elements (`bank[Axis::Roll as usize]`), they do so for the others, too.
pub(super) fn all_keys(index: &Index, named: &BTreeSet<IndexKey>, length: u64) -> Option<BTreeSet<IndexKey>> {
    let mut numbers = BTreeSet::new();
    let mut owners = BTreeSet::new();
    for key in named {
        numbers.insert(match key {
            IndexKey::Number(number) => *number,
            IndexKey::Named(name) => {
                let (owner, variant) = name.rsplit_once("::")?;
                owners.insert(owner);
                agreed(index, owner, |id| number_of(index, id, variant))?
            }
            _ => return None,
        });
    }
    if numbers.is_empty() {
        return None;
    }
    let mut keys = named.clone();
    for number in (0..length).filter(|number| !numbers.contains(number)) {
        let variant = match owners.first() {
            Some(owner) if owners.len() == 1 => {
                let variant = agreed(index, owner, |id| index.variant_numbered(id, number).map(str::to_owned));
                variant.map(|variant| IndexKey::Named(format!("{owner}::{variant}").into()))
            }
            _ => None,
        };
        keys.insert(variant.unwrap_or(IndexKey::Number(number)));
    }
    Some(keys)
}

/// The number of a variant.
fn number_of(index: &Index, id: TypeId, variant: &str) -> Option<u64> {
    let at = index.variants_of(id)?.iter().position(|own| own.name == variant)?;
    index.variant_number(id, at)
}

/// What all enums of a name answer alike.
fn agreed<T: PartialEq>(index: &Index, name: &str, asked: impl Fn(TypeId) -> Option<T>) -> Option<T> {
    let mut answers = index.enums_named(name).map(asked);
    let first = answers.next()??;
    answers.all(|answer| answer.as_ref() == Some(&first)).then_some(first)
}
