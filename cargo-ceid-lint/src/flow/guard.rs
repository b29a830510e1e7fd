//! Guards, which update what they hold when they are dropped.

use super::{LoopId, Place, Var};
use crate::source::Span;

/// How a guard comes about and ends.
#[derive(Clone, Debug)]
pub struct GuardInfo {
    /// Where it is made.
    pub span: Span,
    /// What it updates when it is dropped, captured when it is made.
    pub holds: Vec<Var>,
    /// The filters that are or lie in what it holds.
    pub updates: Vec<Place>,
    /// The innermost loop in which it is made.
    pub in_loop: Option<LoopId>,
    /// The names of what it holds, for messages.
    pub names: Vec<String>,
    /// Set if it is dropped before the end of its cycle: where, and how.
    pub dropped: Option<(Span, String)>,
    /// Set if it is never dropped: where, and how.
    pub forgotten: Option<(Span, String)>,
    /// The name it is bound to, if it has one.
    pub name: Option<String>,
    /// Whether it is a value of another type, with destructors that run where it ends.
    pub is_destructor: bool,
}
