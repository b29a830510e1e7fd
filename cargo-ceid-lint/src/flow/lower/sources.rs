//! What an iterator gives in each round, and what a chain of adaptors makes of it. Lowers nothing.

use super::ClosureRef;
use crate::flow::{Computed, IndexKey, Limit, LoopId, Place, Rounds, Section, Var};
use crate::index::{Length, Ty};

/// What an iterator gives in each round.
#[derive(Clone, Debug)]
pub(super) enum Item {
    /// Something that is no filter's place.
    Opaque,
    /// The same, from what it is known to be computed from.
    Drawn(Vec<Var>, Computed),
    /// What closures make of it.
    Staged(Box<Self>, Vec<Stage>),
    /// An element of a collection.
    Element(Place),
    /// An element of a collection without filters, which goes along with one of a collection of filters.
    Beside(Place, Box<Self>),
    /// A part of a collection: the element is in exactly one of them.
    Chunk(Place),
    /// The number of the round, from a first value that may be known.
    Counter(Option<u64>),
    /// A value made in the round.
    Made,
    /// The one thing at a place.
    Same(Place),
    /// An option of which only what is there gets a round.
    Present(Box<Self>),
    /// One of these, those of the first kind before those of the next.
    OneOf(Vec<Self>),
    /// One of these, each with its own shape and closures.
    Chained(Vec<Self>),
    /// Several at once.
    Tuple(Vec<Self>),
}

impl Item {
    /// The places of which it is one in each round.
    pub(super) fn lends(&self, found: &mut Vec<Place>) {
        match self {
            Self::Element(place) => found.push(place.element(IndexKey::Each)),
            Self::Chunk(place) => found.push(place.slice(Section::chunk())),
            Self::Same(place) => found.push(place.clone()),
            Self::OneOf(items) | Self::Chained(items) => items.iter().for_each(|item| item.lends(found)),
            Self::Staged(item, _) | Self::Present(item) => item.lends(found),
            Self::Opaque | Self::Drawn(..) | Self::Beside(..) | Self::Counter(_) | Self::Made | Self::Tuple(_) => {}
        }
    }

    /// What a map gives: a key, and an element.
    pub(super) fn entry(place: Place) -> Self {
        Self::Tuple(vec![Self::Opaque, Self::Element(place)])
    }

    /// The values of such pairs.
    pub(super) fn values(&self) -> Self {
        match self {
            Self::Tuple(parts) => parts.last().cloned().unwrap_or(Self::Opaque),
            other => other.clone(),
        }
    }

    /// One or the other; `None` if they have different shapes.
    pub(super) fn or(&self, other: &Self) -> Option<Self> {
        match (self, other) {
            (Self::Tuple(left), Self::Tuple(right)) if left.len() == right.len() => {
                let parts = left.iter().zip(right).map(|(left, right)| left.or(right));
                Some(Self::Tuple(parts.collect::<Option<_>>()?))
            }
            (Self::Tuple(_) | Self::Staged(..) | Self::Chained(_), _)
            | (_, Self::Tuple(_) | Self::Staged(..) | Self::Chained(_)) => None,
            (Self::Counter(_), Self::Counter(_)) => Some(Self::Opaque),
            _ => Some(Self::OneOf(vec![self.clone(), other.clone()])),
        }
    }

    /// Whether it has a counter in it.
    pub(super) fn has_counter(&self) -> bool {
        match self {
            Self::Counter(_) => true,
            Self::Tuple(items) => items.iter().any(Self::has_counter),
            Self::Staged(item, _) | Self::Present(item) => item.has_counter(),
            _ => false,
        }
    }

    /// The same, its numbers not known.
    fn unnumbered(&self) -> Self {
        match self {
            Self::Counter(_) => Self::Counter(None),
            Self::Tuple(items) => Self::Tuple(items.iter().map(Self::unnumbered).collect()),
            Self::Staged(item, stages) => Self::Staged(Box::new(item.unnumbered()), stages.clone()),
            Self::Present(item) => Self::Present(Box::new(item.unnumbered())),
            other => other.clone(),
        }
    }

    /// The same of a slice only; `None` if that cannot be said of it.
    fn cut(&self, section: &Section) -> Option<Self> {
        match self {
            Self::Element(place) => Some(Self::Element(place.slice(section.clone()))),
            Self::Counter(Some(first)) if section.is_exact => Some(Self::Counter(Some(first + section.from))),
            Self::Beside(place, item) => Some(Self::Beside(place.slice(section.clone()), item.clone())),
            Self::Counter(_) => Some(Self::Opaque),
            Self::Tuple(items) => Some(Self::Tuple(items.iter().map(|item| item.cut(section)).collect::<Option<_>>()?)),
            Self::Opaque | Self::Drawn(..) => Some(self.clone()),
            _ => None,
        }
    }

    /// Whether it is such a place, or has one in it.
    pub(super) fn has_lent(&self) -> bool {
        match self {
            Self::Tuple(items) | Self::Chained(items) => items.iter().any(Self::has_lent),
            Self::Staged(item, _) => item.has_lent(),
            item => item.is_lent(),
        }
    }

    /// Whether it is such a place.
    pub(super) fn is_lent(&self) -> bool {
        let mut found = Vec::new();
        self.lends(&mut found);
        !found.is_empty()
    }
}

/// What a chain of adaptors runs over.
#[derive(Clone, Debug)]
pub(super) struct Source {
    pub(super) item: Item,
    pub(super) rounds: Rounds,
    pub(super) passes_over: bool,
    /// Whether a closure that it begins with leaves some of the elements out.
    pub(super) leaves_out: bool,
    pub(super) in_order: bool,
    /// Whether its counter begins with the last number.
    pub(super) counts_down: bool,
    /// Whether it takes what is there from a queue.
    pub(super) drains: bool,
    /// Whether it lends its elements by shared references, through which no filter is updated.
    pub(super) is_shared: bool,
    /// What happens in each round before the item is there: `map`, `filter`, `inspect`.
    pub(super) stages: Vec<Stage>,
    /// Whether it is one of several, and which one is not known.
    pub(super) is_choice: bool,
    /// Whether some of its items were taken before, and which ones are left is not known.
    pub(super) is_advanced: bool,
    /// Whether it gives one item at least.
    pub(super) is_filled: bool,
    /// The innermost loop in which it was made.
    pub(super) made_in: Option<LoopId>,
    pub(super) text: String,
    /// The variables that the items are computed from.
    pub(super) reads: Vec<Var>,
    /// The collection that it begins with, if it has a name.
    pub(super) over: Option<Place>,
    /// What its counter ends at.
    pub(super) limits: Vec<Limit>,
    /// The length of the array that it begins with.
    pub(super) length: Option<Length>,
}

/// What an adaptor does with each item, most of them by a closure.
#[derive(Clone, Copy, Debug)]
pub(super) enum Stage {
    Map(ClosureRef),
    /// Gives an iterator for each item.
    Flatten(ClosureRef),
    Filter(ClosureRef),
    Inspect(ClosureRef),
    /// As a map, with a state before the item that may hold filters; the first item that is missing ends the iteration.
    Scan(ClosureRef, Option<Var>),
    /// As a map; the first item that is missing ends the iteration.
    While(ClosureRef),
    /// Makes the item from nothing.
    Make(ClosureRef),
    /// Puts the number of the item before it.
    Number,
    /// Drops some items, whatever they are: what was done to them before is done.
    Skip,
}

/// The item behind stages that end with its number, where that is the number of the round: no stage leaves out a round, or gives
/// several items for one.
pub(super) fn numbered_item(stages: &[Stage]) -> Option<Item> {
    let is_one_for_one = |stage: &Stage| matches!(stage, Stage::Map(_) | Stage::Inspect(_));
    let (last, before) = stages.split_last()?;
    let is_numbered = matches!(last, Stage::Number) && before.iter().all(is_one_for_one);
    is_numbered.then(|| Item::Tuple(vec![Item::Counter(Some(0)), Item::Opaque]))
}

impl Stage {
    pub(super) fn closure(self) -> Option<ClosureRef> {
        match self {
            Self::Map(closure)
            | Self::Flatten(closure)
            | Self::Filter(closure)
            | Self::Inspect(closure)
            | Self::Scan(closure, _)
            | Self::While(closure)
            | Self::Make(closure) => Some(closure),
            Self::Number | Self::Skip => None,
        }
    }

    /// What it carries from item to item.
    pub(super) fn state(self) -> Option<Var> {
        match self {
            Self::Scan(_, state) => state,
            _ => None,
        }
    }
}

impl Source {
    /// Whether its adaptors only look at the items, or leave some out.
    pub(super) fn keeps_items(&self) -> bool {
        self.stages.iter().all(|stage| matches!(stage, Stage::Filter(_) | Stage::Inspect(_)))
    }

    /// Its item together with its closures, which are its own where several iterators go side by side.
    pub(super) fn staged(self) -> Item {
        if self.stages.is_empty() { self.item } else { Item::Staged(Box::new(self.item), self.stages) }
    }

    /// What is left of it beside another one that ends first: the elements behind get no round.
    pub(super) fn shortened(mut self, rounds: &Rounds) -> Self {
        if let (Rounds::Constant(all), Rounds::Constant(count), Item::Element(place)) =
            (&self.rounds, rounds, &self.item)
            && count < all
        {
            // Which ones these are is known where they come in order.
            if self.in_order {
                let section = Section::known(0, Some(*count), &format!("..{count}"));
                self.item = Item::Element(place.slice(section));
            } else {
                self.passes_over = true;
            }
        }
        self
    }

    /// Whether its array and that of another one may have different lengths, of which one is not known.
    pub(super) fn may_outlast(&self, other: &Self) -> bool {
        match (&self.length, &other.length) {
            (Some(own), Some(other)) => own != other && (own.value.is_none() || other.value.is_none()),
            _ => false,
        }
    }

    /// What `skip` or `step_by` leaves of it.
    pub(super) fn thinned(mut self, method: &str, number: Option<u64>) -> Self {
        let is_step = method == "step_by";
        let rounds = match (&self.rounds, number) {
            (Rounds::Unbounded, _) => Rounds::Unbounded,
            (Rounds::Constant(all), Some(step)) if is_step && step > 0 => Rounds::Constant(all.div_ceil(step)),
            (Rounds::Constant(all), Some(skipped)) if !is_step => Rounds::Constant(all.saturating_sub(skipped)),
            _ => Rounds::Bounded,
        };
        self.rounds = rounds;
        if !self.stages.is_empty() {
            self.stages.push(Stage::Skip);
            self.in_order = false;
            return self;
        }
        let is_plain = !self.passes() && !is_step;
        let rest = match (&self.item, &self.rounds) {
            // Of a row whose elements are told apart, it is not followed which ones these are.
            (Item::Element(place), Rounds::Constant(_)) if is_step && number != Some(1) => {
                self.item = Item::Element(place.slice(Section::unknown(method)));
                self.in_order = false;
                return self;
            }
            _ if self.in_order => self.item.cut(&Section::skipped(number)),
            // The rounds are those that are left.
            (Item::Element(place), Rounds::Constant(left)) if self.counts_down && number.is_some() => {
                Some(Item::Element(place.slice(Section::known(0, Some(*left), &format!("..{left}")))))
            }
            _ => None,
        };
        match rest.filter(|_| is_plain) {
            Some(item) => self.item = item,
            None => {
                self.passes_over |= self.item.has_lent();
                self.in_order = false;
                if matches!(self.item, Item::Counter(_)) {
                    self.item = Item::Opaque;
                }
            }
        }
        self
    }

    /// What `rev` makes of it.
    pub(super) fn reversed(self) -> Self {
        let counts_down = !self.counts_down && (self.in_order || self.item.has_counter());
        Self { in_order: false, counts_down, ..self }
    }

    /// Whether the number of an item is that of its round: nothing else counts, and no part begins anew.
    pub(super) fn counts_items(&self) -> bool {
        let is_one = !matches!(self.item, Item::Chained(_) | Item::OneOf(_));
        self.in_order && is_one && !self.item.has_counter() && !self.passes()
    }

    /// The item with the number of its round, if the chain ends with that.
    pub(super) fn numbered(&self) -> Option<Item> {
        numbered_item(&self.stages).filter(|_| self.counts_items())
    }

    /// The same where it is not known any more in which round its counter has which number.
    pub(super) fn uncounted(self) -> Self {
        match self.counts_down {
            true => Self { item: self.item.unnumbered(), counts_down: false, ..self },
            false => self,
        }
    }

    /// What `take` leaves of it.
    pub(super) fn headed(mut self, number: Option<u64>) -> Self {
        if self.counts_down {
            return self.headed_from_the_end(number);
        }
        if let Item::Element(place) = &self.item
            && self.in_order
            && self.stages.is_empty()
            && !self.passes()
        {
            self.item = Item::Element(place.slice(Section::taken(number)));
        }
        self
    }

    fn headed_from_the_end(self, number: Option<u64>) -> Self {
        match (&self.item, &self.rounds, number) {
            (Item::Counter(Some(first)), Rounds::Constant(all), Some(number)) => {
                let left_out = all.saturating_sub(number);
                Self { item: Item::Counter(Some(first + left_out)), ..self }
            }
            (Item::Element(_), ..) if !self.stages.is_empty() || self.passes() => self,
            (Item::Element(place), Rounds::Constant(all), Some(number)) => {
                let first = all.saturating_sub(number);
                let last = Section::known(first, Some(*all), &format!("{first}..{all}"));
                Self { item: Item::Element(place.slice(last)), ..self }
            }
            // Which ones the last are, is not known.
            (Item::Element(place), ..) => {
                Self { item: Item::Element(place.slice(Section::unknown("the last"))), counts_down: false, ..self }
            }
            _ => self.uncounted(),
        }
    }

    /// Whether an item may be passed over.
    pub(super) fn passes(&self) -> bool {
        self.passes_over || self.leaves_out
    }

    /// Some of its elements, and which ones is not known.
    pub(super) fn cut_somewhere(self, text: &str) -> Self {
        match &self.item {
            Item::Element(place) => Self { item: Item::Element(place.slice(Section::unknown(text))), ..self },
            _ => self,
        }
    }

    pub(super) fn bounded() -> Self {
        Self {
            item: Item::Opaque,
            rounds: Rounds::Bounded,
            passes_over: false,
            leaves_out: false,
            in_order: true,
            counts_down: false,
            drains: false,
            is_shared: false,
            stages: Vec::new(),
            is_choice: false,
            is_advanced: false,
            is_filled: false,
            made_in: None,
            text: String::new(),
            reads: Vec::new(),
            over: None,
            limits: Vec::new(),
            length: None,
        }
    }
}

/// Whether a type is a map: what it gives are pairs, and which one a key names depends on data.
pub(super) fn is_map(ty: &Ty) -> bool {
    ty.external_name().is_some_and(|name| name.ends_with("Map"))
}
