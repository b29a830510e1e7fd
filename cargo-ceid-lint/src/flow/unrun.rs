//! Code that is written in a function and that nothing in it runs.

use super::{LoopId, Place};
use crate::source::Span;

/// A closure or a future that nothing runs.
#[derive(Clone, Debug)]
pub struct Unrun {
    /// Where it is written.
    pub span: Span,
    /// The innermost loop in which it is made.
    pub in_loop: Option<LoopId>,
    /// Why nothing runs it.
    pub what: UnrunKind,
    /// What it would be lent, and what it names.
    pub places: Vec<Place>,
    /// Whether the variable that it is put into is named again, so that something may run it that is not followed.
    pub is_named_again: bool,
    /// What tells it from others: where it is read, and the number of its expression.
    pub key: (usize, u32),
}

/// What would have to run it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum UnrunKind {
    /// Whoever consumes the iterator that this adaptor gives.
    Iterator(String),
    /// A call.
    Closure,
    /// An `.await`.
    Future,
}
