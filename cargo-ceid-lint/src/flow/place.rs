//! Places: where an instance of a filter lives.

use std::sync::Arc;

use super::Var;
use crate::index::ValueId;

/// A variable or static, and the way from it to a part.
#[derive(Clone, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Place {
    /// Where it begins.
    pub base: Base,
    /// The steps. References, pointers, options and locks add none.
    pub steps: Vec<Projection>,
}

/// Where a place begins.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Base {
    /// A variable.
    Var(Var),
    /// A static.
    Static(ValueId),
}

impl Base {
    /// The static that it is.
    #[must_use]
    pub fn value(self) -> Option<ValueId> {
        match self {
            Self::Static(id) => Some(id),
            Self::Var(_) => None,
        }
    }
}

/// A step into a place.
#[derive(Clone, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Projection {
    /// A field, a tuple's number, or a variant of an enum.
    Field(Arc<str>),
    /// An element of a collection.
    Index(IndexKey),
    /// A channel of a filter that a key argument of its law selects.
    Channel(IndexKey),
}

impl Projection {
    /// The key of an element or channel.
    #[must_use]
    pub fn key(&self) -> Option<&IndexKey> {
        match self {
            Self::Field(_) => None,
            Self::Index(key) | Self::Channel(key) => Some(key),
        }
    }

    /// The element or channel with another key.
    #[must_use]
    pub fn with_key(&self, key: IndexKey) -> Self {
        match self {
            Self::Field(_) => self.clone(),
            Self::Index(_) => Self::Index(key),
            Self::Channel(_) => Self::Channel(key),
        }
    }
}

/// Which element.
#[derive(Clone, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum IndexKey {
    /// A number.
    Number(u64),
    /// A constant expression by its spelling, or the number of a variant: `Axis::Roll`.
    Named(Arc<str>),
    /// A literal that is no such number, in the one way in which it is spelled: `'x'`, `-1`, `true`.
    Literal(Arc<str>),
    /// The value of a variable.
    Var(Var),
    /// The value of a parameter of the function that a summary is about.
    Param(usize),
    /// Each one: the element stands for all.
    Each,
    /// One that depends on data, by its spelling.
    Data(Arc<str>),
    /// Not one element but a slice of the collection.
    Slice(Section),
    /// Each element of a slice of the collection.
    EachIn(Section),
}

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
    fn element(&self, key: &IndexKey) -> IndexKey {
        match key {
            IndexKey::Each => IndexKey::EachIn(self.clone()),
            IndexKey::Number(number) if self.is_exact => IndexKey::Number(self.from + number),
            IndexKey::Slice(inner) => IndexKey::Slice(self.within(inner)),
            IndexKey::EachIn(inner) => IndexKey::EachIn(self.within(inner)),
            _ => IndexKey::Data(Arc::from(self.kind.text())),
        }
    }
}

/// How an access relates to an instance.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Relation {
    /// The access is the instance, or the instance lies in it by these steps.
    Holds(Vec<Projection>),
    /// It may be; the spelling of the index that decides.
    MayHold(Arc<str>, Vec<Projection>),
    /// The access is a part of the instance.
    Part,
    /// They have nothing to do with each other.
    Apart,
}

impl Place {
    /// The whole of a variable.
    #[must_use]
    pub fn var(var: Var) -> Self {
        Self { base: Base::Var(var), steps: Vec::new() }
    }

    /// The whole of a static.
    #[must_use]
    pub fn of_static(id: ValueId) -> Self {
        Self { base: Base::Static(id), steps: Vec::new() }
    }

    /// A part of this place.
    #[must_use]
    pub fn field(&self, name: &str) -> Self {
        self.step(Projection::Field(Arc::from(name)))
    }

    /// An element of this place.
    #[must_use]
    pub fn element(&self, key: IndexKey) -> Self {
        self.step(Projection::Index(key))
    }

    /// A channel of the filter at this place.
    #[must_use]
    pub fn channel(&self, key: IndexKey) -> Self {
        self.step(Projection::Channel(key))
    }

    /// A slice of this place.
    #[must_use]
    pub fn slice(&self, section: Section) -> Self {
        self.step(Projection::Index(IndexKey::Slice(section)))
    }

    fn step(&self, step: Projection) -> Self {
        self.join(&[step])
    }

    /// This place with more steps behind it. An element of a slice is an element of the whole.
    #[must_use]
    pub fn join(&self, more: &[Projection]) -> Self {
        // There are very many places, most of them with a step or two.
        let mut steps = Vec::with_capacity(self.steps.len() + more.len());
        steps.extend_from_slice(&self.steps);
        for step in more {
            match (steps.last(), step) {
                (Some(Projection::Index(IndexKey::Slice(section))), Projection::Index(key)) => {
                    let key = section.element(key);
                    steps.pop();
                    steps.push(Projection::Index(key));
                }
                _ => steps.push(step.clone()),
            }
        }
        Self { base: self.base, steps }
    }

    /// The variable it begins with.
    #[must_use]
    pub fn base_var(&self) -> Option<Var> {
        match self.base {
            Base::Var(var) => Some(var),
            Base::Static(_) => None,
        }
    }

    /// How an access of this place relates to an instance with that name. `value` tells the number that a variable has now.
    #[must_use]
    pub fn relate(&self, instance: &Self, value: &dyn Fn(Var) -> Option<u64>) -> Relation {
        if self.base != instance.base {
            return Relation::Apart;
        }
        let mut doubt: Option<Arc<str>> = None;
        for (at, (step, own)) in self.steps.iter().zip(&instance.steps).enumerate() {
            match (step, own) {
                // A slice holds the elements that it has, under other numbers.
                (Projection::Index(IndexKey::Slice(section)), Projection::Index(IndexKey::Number(number)))
                    if section.is_exact && at + 1 == self.steps.len() && doubt.is_none() =>
                {
                    if section.has(*number) == Some(false) {
                        return Relation::Apart;
                    }
                    let mut rest = instance.steps[at..].to_vec();
                    rest[0] = Projection::Index(IndexKey::Number(number - section.from));
                    return Relation::Holds(rest);
                }
                (Projection::Field(left), Projection::Field(right)) if left == right => {}
                (Projection::Index(left), Projection::Index(right))
                | (Projection::Channel(left), Projection::Channel(right)) => match left.relate(right, value) {
                    Some(true) => {}
                    Some(false) => return Relation::Apart,
                    None => doubt = Some(doubt.unwrap_or_else(|| left.spelling(&|_| String::from("i")).into())),
                },
                _ => return Relation::Apart,
            }
        }
        if self.steps.len() > instance.steps.len() {
            return Relation::Part;
        }
        let rest = instance.steps[self.steps.len()..].to_vec();
        match doubt {
            None => Relation::Holds(rest),
            Some(text) => Relation::MayHold(text, rest),
        }
    }

    /// Whether it is another place or lies in it.
    #[must_use]
    pub fn lies_at(&self, whole: &Self) -> bool {
        self.base == whole.base && self.steps.starts_with(&whole.steps)
    }

    /// Whether one of the two places lies in the other, as far as can be known.
    #[must_use]
    pub fn overlaps(&self, other: &Self) -> bool {
        self.base == other.base
            && self.steps.iter().zip(&other.steps).all(|(left, right)| match (left, right) {
                (Projection::Field(left), Projection::Field(right)) => left == right,
                (Projection::Index(left), Projection::Index(right))
                | (Projection::Channel(left), Projection::Channel(right)) => {
                    left.relate(right, &|_| None) != Some(false)
                }
                _ => false,
            })
    }

    /// The place as the source spells it.
    #[must_use]
    pub fn spell(&self, var: &dyn Fn(Var) -> String, of_static: &dyn Fn(ValueId) -> String) -> String {
        let mut text = match self.base {
            Base::Var(id) => var(id),
            Base::Static(id) => of_static(id),
        };
        for step in &self.steps {
            match step {
                Projection::Field(name) => {
                    text.push('.');
                    text.push_str(name);
                }
                Projection::Index(key) => {
                    text.push('[');
                    text.push_str(&key.spelling(var));
                    text.push(']');
                }
                // Several key arguments are written as in a call: `tilt(0, 1)`.
                Projection::Channel(key) if text.ends_with(')') => {
                    text.pop();
                    text.push_str(", ");
                    text.push_str(&key.spelling(var));
                    text.push(')');
                }
                Projection::Channel(key) => {
                    text.push('(');
                    text.push_str(&key.spelling(var));
                    text.push(')');
                }
            }
        }
        text
    }

    /// A bit of the number that is there.
    #[must_use]
    pub fn bit(&self, bit: u32) -> Self {
        self.field(&format!("&{bit}"))
    }

    /// The bit of the number at another place that this is, if it is one.
    #[must_use]
    pub fn bit_of(&self, number: &Self) -> Option<u32> {
        match self.steps.split_last()? {
            (Projection::Field(name), steps) if self.base == number.base && *steps == number.steps => {
                name.strip_prefix('&')?.parse().ok()
            }
            _ => None,
        }
    }

    /// Whether some step stands for each element of a collection.
    #[must_use]
    pub fn stands_for_each(&self) -> bool {
        self.steps.iter().any(|step| step.key() == Some(&IndexKey::Each))
    }

    /// Whether it stands for each element of every collection that it lies in, so that their order says nothing of it.
    #[must_use]
    pub fn has_no_order(&self) -> bool {
        let mut keys = self.steps.iter().filter_map(Projection::key).peekable();
        keys.peek().is_some() && keys.all(|key| *key == IndexKey::Each)
    }

    /// The same as `stands_for_each`, where it may be each element of a slice.
    #[must_use]
    pub fn stands_for_several(&self) -> bool {
        self.steps.iter().any(|step| matches!(step.key(), Some(IndexKey::Each | IndexKey::EachIn(_))))
    }
}

impl IndexKey {
    /// The element that a constant names by its head, if that is the head of a literal.
    #[must_use]
    pub fn of_head(head: &str) -> Option<Self> {
        let negative = head.strip_prefix('-').and_then(|digits| digits.parse::<u64>().ok());
        let is_text = head.starts_with(['\'', '"']) || matches!(head, "true" | "false");
        match head.parse().ok().or(negative.filter(|number| *number == 0)) {
            Some(number) => Some(Self::Number(number)),
            None => (is_text || negative.is_some()).then(|| Self::Literal(head.into())),
        }
    }

    /// Whether two keys name the same element: `None` if that cannot be known.
    #[must_use]
    pub fn relate(&self, other: &Self, value: &dyn Fn(Var) -> Option<u64>) -> Option<bool> {
        let number = |key: &Self| match key {
            Self::Number(number) => Some(*number),
            Self::Var(var) => value(*var),
            _ => None,
        };
        if self == other {
            return match self {
                Self::Data(_) | Self::Slice(_) | Self::EachIn(_) => None,
                _ => Some(true),
            };
        }
        if let (Some(left), Some(right)) = (number(self), number(other)) {
            return Some(left == right);
        }
        let owner = |name: &str| name.rsplit_once("::").map(|(owner, _)| owner.to_owned());
        match (self, other) {
            // Those of two types may have one number.
            (Self::Named(own), Self::Named(other)) => (owner(own) == owner(other)).then_some(false),
            (Self::Literal(_), Self::Literal(_) | Self::Number(_)) | (Self::Number(_), Self::Literal(_)) => Some(false),
            (Self::Slice(section) | Self::EachIn(section), other)
            | (other, Self::Slice(section) | Self::EachIn(section)) => {
                number(other).and_then(|number| section.has(number)).filter(|has| !has)
            }
            _ => None,
        }
    }

    fn spelling(&self, var: &dyn Fn(Var) -> String) -> String {
        match self {
            Self::Number(number) => number.to_string(),
            Self::Named(text) | Self::Literal(text) | Self::Data(text) => text.to_string(),
            Self::Var(id) => var(*id),
            Self::Param(number) => format!("#{number}"),
            Self::Each => "*".to_owned(),
            Self::Slice(section) | Self::EachIn(section) => section.kind.text().to_owned(),
        }
    }
}
