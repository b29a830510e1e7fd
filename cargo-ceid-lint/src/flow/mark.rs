//! Steps of a path that a reader wants to see, though nothing happens there.

/// A step that changes nothing but where control goes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mark {
    /// `continue`
    Continue,
    /// `break`
    Break,
    /// `return`
    Return,
    /// An arm of a `match`.
    Arm,
    /// A call of a closure that is written elsewhere.
    ClosureCall,
}

/// What decides which of several functions or closures runs at a call.
pub(super) const ONE_OF_SEVERAL: &str = "the first of several functions is called";

/// Questions that no code asks, each with what is said where the answer is no.
const UNWRITTEN: [(&str, &str); 5] = [
    (ONE_OF_SEVERAL, "another one of several functions is called"),
    ("the item is there", "there is no item"),
    ("the item is of this iterator", "the item is of another iterator"),
    ("the item passes the filter", "the item does not pass the filter"),
    ("the item is not skipped", "the item is skipped"),
];

/// A question that is no code, in words, with its answer.
#[must_use]
pub fn in_words(text: &str, holds: bool) -> Option<&'static str> {
    let (yes, no) = UNWRITTEN.iter().find(|(yes, _)| *yes == text)?;
    Some(if holds { yes } else { no })
}
