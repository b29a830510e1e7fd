//! Places: where an instance of a filter lives.

use std::sync::Arc;

use super::Var;
use super::section::Section;
use crate::index::ValueId;

/// The way from one place to a part of it.
pub type Steps = Arc<[Projection]>;

/// A variable or static, and the way from it to a part.
#[derive(Clone, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Place {
    /// Where it begins.
    pub base: Base,
    /// The steps. References, pointers, options and locks add none. Places are copied far more often than they are made,
    /// so that copies share them.
    pub steps: Steps,
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

/// How an access relates to an instance.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Relation {
    /// The access is the instance, or the instance lies in it by these steps.
    Holds(Steps),
    /// It may be; the spelling of the index that decides.
    MayHold(Arc<str>, Steps),
    /// The access is a part of the instance.
    Part,
    /// They have nothing to do with each other.
    Apart,
}

impl From<Base> for Place {
    fn from(base: Base) -> Self {
        Self { base, steps: Arc::default() }
    }
}

impl Place {
    /// The whole of a variable.
    #[must_use]
    pub fn var(var: Var) -> Self {
        Self::from(Base::Var(var))
    }

    /// The whole of a static.
    #[must_use]
    pub fn of_static(id: ValueId) -> Self {
        Self::from(Base::Static(id))
    }

    /// Where its first steps lead to, which is the place itself where it has no more.
    #[must_use]
    pub fn up_to(&self, count: usize) -> Self {
        match self.steps.get(..count) {
            Some(steps) if steps.len() < self.steps.len() => Self { base: self.base, steps: steps.into() },
            _ => self.clone(),
        }
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
        if more.is_empty() {
            return self.clone();
        }
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
        Self { base: self.base, steps: steps.into() }
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
        for (at, (step, own)) in self.steps.iter().zip(instance.steps.iter()).enumerate() {
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
                    return Relation::Holds(rest.into());
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
        let rest = instance.steps[self.steps.len()..].into();
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
            && self.steps.iter().zip(other.steps.iter()).all(|(left, right)| match (left, right) {
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
        for step in self.steps.iter() {
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
            (Projection::Field(name), steps) if self.base == number.base && *steps == *number.steps => {
                name.strip_prefix('&')?.parse().ok()
            }
            _ => None,
        }
    }

    /// The number of which this is a bit, if it is one.
    #[must_use]
    pub fn number_of_bit(&self) -> Option<Self> {
        let number = self.up_to(self.steps.len().checked_sub(1)?);
        self.bit_of(&number).map(|_| number)
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
