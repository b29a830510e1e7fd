//! How long collections are: what methods do to that, and what conditions ask of it.

use super::Place;

/// What a method does to the length of a collection.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Resized {
    /// It is as long as before.
    Kept,
    /// It is longer by one.
    Grows,
    /// It is shorter by so many, as far as there were as many.
    Shrinks(u64),
    /// It is no longer than this.
    HeldAt(u64),
    /// Nothing is left in it.
    Emptied,
}

/// A comparison with the length of a collection: `self.window.len() < 8`.
#[derive(Clone, Debug)]
pub struct AskedLength {
    /// The collection.
    pub of: Place,
    /// The operator, with the length on its left.
    pub op: &'static str,
    /// What stands on its right.
    pub bound: LengthBound,
}

/// What a length is compared with.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum LengthBound {
    /// A number.
    Number(u64),
    /// A constant of which the number is not known.
    Constant(String),
    /// What a place holds.
    Held(Place),
}

/// The name of the part of a collection of filters that its length is: no field has it.
const LENGTH: &str = "len()";

impl Place {
    /// The length of the collection at this place.
    #[must_use]
    pub fn length(&self) -> Self {
        self.field(LENGTH)
    }
}

impl Resized {
    /// What a method of that name does to what it is called on, whatever it is given; `None` if that is not known.
    #[must_use]
    pub fn by(method: &str) -> Option<Self> {
        Some(match method {
            "push" | "push_back" | "push_front" => Self::Grows,
            "pop" | "pop_front" | "pop_back" | "remove" | "swap_remove" | "dequeue" => Self::Shrinks(1),
            "clear" => Self::Emptied,
            "iter_mut" | "get_mut" | "first_mut" | "last_mut" | "front_mut" | "back_mut" | "reverse" | "fill"
            | "swap" | "rotate_left" | "rotate_right" | "copy_from_slice" => Self::Kept,
            _ if method.starts_with("sort") => Self::Kept,
            _ => return None,
        })
    }
}
