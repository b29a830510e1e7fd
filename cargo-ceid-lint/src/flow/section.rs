//! Sections: which elements of a collection a slice of it has.

use std::sync::Arc;

use super::place::IndexKey;

/// Which elements a slice has.
#[derive(Clone, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Section {
    /// The number of the first one.
    pub from: u64,
    /// The number behind the last one; `None` if it reaches to the end of the collection.
    pub to: Option<u64>,
    /// Whether these numbers are known; otherwise it is some slice.
    pub is_exact: bool,
    /// How it comes about.
    pub kind: SectionKind,
}

/// How a slice of a collection comes about.
#[derive(Clone, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum SectionKind {
    /// It is written like this: `1..`.
    Written(Arc<str>),
    /// It is one of the slices that a collection is handed out in, each element in exactly one of them.
    Chunk,
    /// It is the first ones: as many as there are, or fewer.
    Taken,
    /// It is all but the first ones.
    Skipped,
}

impl SectionKind {
    /// Its spelling.
    #[must_use]
    pub fn text(&self) -> &str {
        match self {
            Self::Written(text) => text,
            Self::Chunk => "a chunk",
            Self::Taken => "the first",
            Self::Skipped => "behind the first",
        }
    }
}

impl Section {
    /// The elements with these numbers, as the code writes it.
    #[must_use]
    pub fn known(from: u64, to: Option<u64>, text: &str) -> Self {
        Self { from, to, is_exact: true, kind: SectionKind::Written(Arc::from(text)) }
    }

    /// A slice of which nothing is known but how the code writes it.
    #[must_use]
    pub fn unknown(text: &str) -> Self {
        Self::some(SectionKind::Written(Arc::from(text)))
    }

    fn some(kind: SectionKind) -> Self {
        Self { from: 0, to: None, is_exact: false, kind }
    }

    /// One of the slices that a collection is handed out in.
    #[must_use]
    pub fn chunk() -> Self {
        Self::some(SectionKind::Chunk)
    }

    /// The first ones of a collection: as many as there are, or fewer.
    #[must_use]
    pub fn taken(count: Option<u64>) -> Self {
        Self { from: 0, to: count, is_exact: count.is_some(), kind: SectionKind::Taken }
    }

    /// All elements of a collection but the first ones, if it is known how many these are.
    #[must_use]
    pub fn skipped(count: Option<u64>) -> Self {
        let from = count.unwrap_or_default();
        Self { from, to: None, is_exact: count.is_some(), kind: SectionKind::Skipped }
    }

    /// Whether it is one of the slices that a collection is handed out in.
    #[must_use]
    pub fn is_chunk(&self) -> bool {
        self.kind == SectionKind::Chunk
    }

    /// Whether it is the first ones of a collection, which may be all of them.
    #[must_use]
    pub fn is_taken(&self) -> bool {
        self.kind == SectionKind::Taken
    }

    /// Whether the element with that number is one of the slice as the code writes it: `&mut bank[..2]`.
    #[must_use]
    pub fn is_written_with(&self, number: u64) -> bool {
        matches!(self.kind, SectionKind::Written(_)) && self.has(number) == Some(true)
    }

    /// Whether it is all elements behind the first ones, of which it is known how many there are: `1..`.
    #[must_use]
    pub fn is_rest(&self) -> bool {
        self.is_exact && self.to.is_none() && !self.is_taken() && !self.is_chunk()
    }

    /// Whether it is all elements of a collection but the first ones.
    #[must_use]
    pub fn is_skipped(&self) -> bool {
        self.kind == SectionKind::Skipped
    }

    /// The slice of the whole collection that another one is of this slice.
    fn within(&self, inner: &Self) -> Self {
        // What an adaptor says of a slice does not hold of the whole.
        let kind = match (&self.kind, &inner.kind) {
            (_, SectionKind::Written(_)) | (SectionKind::Chunk, SectionKind::Chunk) => inner.kind.clone(),
            (SectionKind::Written(_), _) => self.kind.clone(),
            _ => SectionKind::Written(Arc::from("..")),
        };
        if !self.is_exact || !inner.is_exact {
            return Self::some(kind);
        }
        let to = inner.to.map(|to| self.from + to).or(self.to);
        Self { from: self.from + inner.from, to, is_exact: true, kind }
    }

    /// Whether it has the element with that number; `None` if that cannot be known.
    #[must_use]
    pub fn has(&self, number: u64) -> Option<bool> {
        self.is_exact.then(|| number >= self.from && self.to.is_none_or(|to| number < to))
    }

    /// The element of the whole collection that is this one of the slice.
    pub(super) fn element(&self, key: &IndexKey) -> IndexKey {
        match key {
            IndexKey::Each => IndexKey::EachIn(self.clone()),
            IndexKey::Number(number) if self.is_exact => IndexKey::Number(self.from + number),
            IndexKey::Slice(inner) => IndexKey::Slice(self.within(inner)),
            IndexKey::EachIn(inner) => IndexKey::EachIn(self.within(inner)),
            _ => IndexKey::Data(Arc::from(self.kind.text())),
        }
    }
}
