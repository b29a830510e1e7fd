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
