//! What the analysis cannot follow, and how it is told.

/// Why something cannot be known.
#[derive(Clone, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Cause {
    /// A macro whose tokens mention the filter.
    Macro(String),
    /// A macro whose tokens hold a way out of the code around it.
    WayOut(String),
    /// A call of something that cannot be seen, with the filter.
    Call(String),
    /// A closure that is handed to something that cannot be seen.
    Closure(String),
    /// An index or key that depends on data.
    Index(String),
    /// A call that puts it in another place, which has another name.
    Moved(String),
    /// A call that puts the elements of its collection in another order, so that each is told by another index.
    Reordered(String),
    /// Something that is not read: inline assembly, a raw pointer.
    Code(String),
    /// A limit of the analysis.
    Limit(String),
}

impl Cause {
    /// Whether only the order of elements is not known: each of them is as it was.
    #[must_use]
    pub fn is_order(&self) -> bool {
        matches!(self, Self::Reordered(_))
    }
}

impl std::fmt::Display for Cause {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Macro(name) => write!(f, "the macro `{name}!` mentions it and cannot be expanded"),
            Self::WayOut(name) => write!(f, "the macro `{name}!` may leave it out and cannot be expanded"),
            Self::Call(name) => write!(f, "`{name}` gets it and its source cannot be seen"),
            Self::Closure(name) => {
                write!(f, "a closure that updates it is handed to `{name}`, whose source cannot be seen")
            }
            Self::Index(text) => write!(f, "only data tells which element `{text}` is"),
            Self::Moved(name) | Self::Reordered(name) => write!(f, "`{name}` puts it in another place"),
            Self::Code(what) => write!(f, "{what} cannot be followed"),
            Self::Limit(what) => write!(f, "{what}"),
        }
    }
}
