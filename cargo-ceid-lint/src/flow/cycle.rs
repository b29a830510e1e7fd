//! Loops: what a cycle can be made of.

use super::{LoopId, NodeId, Place, Var};
use crate::index::Length;
use crate::source::Span;
use crate::syntax::CycleDirective;

/// How many samples a block has at least, where a loop is told apart from one over the steps of a sample by its number of rounds.
const LEAST_BLOCK: u64 = 16;

/// What a cycle is in the source.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum CycleKind {
    /// `loop`, and `each_cycle!`
    Loop,
    /// `while`
    While,
    /// `for`
    For,
    /// A closure that is called once per cycle or per item.
    Closure,
    /// A cycle function.
    Function,
}

impl CycleKind {
    /// The word in the proof report.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Loop => "loop",
            Self::While => "while",
            Self::For => "for",
            Self::Closure => "closure",
            Self::Function => "function",
        }
    }
}

/// How often a loop runs.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Rounds {
    /// Until something in it ends it.
    Unbounded,
    /// A number of times that is known.
    Constant(u64),
    /// Once for each item of something finite.
    Bounded,
}

/// What a loop counts up to.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Limit {
    /// The number of elements of a collection.
    Elements(Place),
    /// A number that is known.
    Number(u64),
    /// A length that arrays may have.
    Length(Length),
    /// A number that a place has.
    Held(Place),
    /// A number that a place has, and that one as well: `0..=n`.
    UpTo(Place),
    /// Something else.
    Unknown,
}

/// Who runs the rounds of a loop.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Caller {
    /// The code that it stands in.
    Code,
    /// A device or timer, which calls a closure once per cycle.
    Framework,
    /// Something unseen that gets a closure, and may call it once per cycle.
    Unseen,
    /// The code that keeps a closure and calls it by another name: each call belongs to the cycle that it stands in.
    Keeper,
    /// Another function that calls a closure in several places, with something else in each: one of these calls. It is a cycle for
    /// what is fed with that.
    Helper,
}

/// A loop.
#[derive(Clone, Debug)]
pub struct LoopInfo {
    /// What it is in the source.
    pub kind: CycleKind,
    /// Its keyword, or the closure's `|`.
    pub keyword: Span,
    /// The loop around it.
    pub parent: Option<LoopId>,
    /// The loop each of whose rounds begins it anew: the one around it, or around what lets it run elsewhere.
    pub begun_in: Option<LoopId>,
    /// Its head.
    pub head: NodeId,
    /// How often it runs.
    pub rounds: Rounds,
    /// Variables that name an element in each round, and the collection's elements.
    pub items: Vec<(Var, Place)>,
    /// Where the ways begin of items that are of one of several iterators, with the variables that name those of this one.
    pub chained: Vec<(NodeId, Vec<Var>)>,
    /// The variable that counts the rounds or elements, and its first value if that is known.
    pub counter: Option<(Var, Option<u64>)>,
    /// Whether it counts from its last number down to the first one.
    pub counts_down: bool,
    /// Whether only the distance of the counter from its last number is asked for: `2 - i` in a loop over `0..3`. Then that is
    /// what counts.
    pub is_mirrored: bool,
    /// What it counts up to: the least of these.
    pub limits: Vec<Limit>,
    /// Every variable that its head binds.
    pub bound: Vec<Var>,
    /// The collection that it goes over by its counter and takes elements out of, each of which has one round all the same.
    pub takes_out: Option<Place>,
    /// Collections that are indexed with the counter.
    pub indexes: Vec<Place>,
    /// The collection that it runs over, if it has a name.
    pub over: Option<Place>,
    /// What is asked for something by the counter: `input.at(i)`, `input[first + i]`.
    pub sampled: Vec<Place>,
    /// What its rounds take from what says how many of them there are, and by which method: `for _ in 0..fifo.len() { fifo.read() }`.
    pub taken_by_count: Vec<(Place, String)>,
    /// The collections whose elements a round gets to write: `for (slot, sample) in frame.iter_mut().zip(input)`.
    pub filled: Vec<Place>,
    /// Whether an item may be passed over (`filter`), so that its round does not take place.
    pub passes_over: bool,
    /// The method that runs it and may end it before the last item: `any`, `try_for_each`.
    pub stops_by: Option<String>,
    /// Whether its items are the rows of a table that the code spells out.
    pub is_table: bool,
    /// Whether its items are the elements of a collection from the first one on, none left out, or its numbers follow one another.
    pub in_order: bool,
    /// Whether it has one round at least.
    pub is_entered: bool,
    /// Whether it is a `while let` or `for` that takes what is there from a queue.
    pub drains: bool,
    /// Whether it takes its items from an iterator that the caller lends, and nothing else in the function does.
    pub is_lent: bool,
    /// Whether it can begin another round.
    pub goes_round: bool,
    /// Whether it stands in another function that was inlined here, so that it is that function's own.
    pub is_foreign: bool,
    /// The `|` of the closure of this function that a foreign loop calls.
    pub closure: Option<Span>,
    /// Who runs its rounds.
    pub caller: Caller,
    /// The nodes at which something unseen gets its closure, or may run it.
    pub handed: Vec<NodeId>,
    /// The source text of what it runs over, for messages.
    pub text: String,
    /// What a comment above it says.
    pub directive: Option<CycleDirective>,
}

impl LoopInfo {
    /// The number that the counter has in a round; the first round is 1.
    #[must_use]
    pub fn number_in(&self, round: u64) -> Option<u64> {
        let first = self.counter?.1?;
        match self.rounds {
            Rounds::Constant(all) if self.counts_down => Some(first.saturating_add(all.checked_sub(round)?)),
            _ if self.counts_down => None,
            _ => Some(first.saturating_add(round.checked_sub(1)?)),
        }
    }

    /// Whether a round stands for all those behind it as well, where only so many are told apart.
    #[must_use]
    pub fn is_beyond(&self, round: u64, told: u64) -> bool {
        matches!(self.rounds, Rounds::Constant(count) if count > told) && round >= told
    }

    /// Whether its counter may have a number in some round.
    #[must_use]
    pub fn has_number(&self, number: u64) -> bool {
        let Some((_, Some(first))) = self.counter else { return true };
        match self.rounds {
            Rounds::Constant(all) => (first..first.saturating_add(all)).contains(&number),
            _ => number >= first,
        }
    }

    /// Whether it goes round until something in it ends it, and does not only empty a queue.
    #[must_use]
    pub fn may_be_cycle(&self) -> bool {
        self.rounds == Rounds::Unbounded && self.goes_round && !self.drains
    }

    /// Whether it counts to a constant that each type or build has its own of: `for _ in 0..C::ROUNDS`.
    #[must_use]
    pub fn has_untold_rounds(&self) -> bool {
        self.limits.iter().any(|limit| matches!(limit, Limit::Length(Length { value: None, .. })))
    }

    /// Whether a constant says how often it runs, known or not. One that each type has its own of, and that numbers what the rounds
    /// take or fill, is the length of a block of samples: `for i in 0..S::BLOCK { put(&mut out, i, tone.next()) }`.
    #[must_use]
    pub fn has_constant_rounds(&self) -> bool {
        let is_block = || !self.indexes.is_empty() || !self.sampled.is_empty();
        matches!(self.rounds, Rounds::Constant(_)) || self.has_untold_rounds() && !is_block()
    }

    /// The same, where that is not said to be as often as a block has samples: a few rounds are steps of one sample.
    #[must_use]
    pub fn has_few_rounds(&self) -> bool {
        self.has_constant_rounds() && !matches!(self.rounds, Rounds::Constant(rounds) if rounds >= LEAST_BLOCK)
    }

    /// Whether it is a closure of which only its own rounds are known, and nothing of who calls it.
    #[must_use]
    pub fn is_unseen(&self) -> bool {
        matches!(self.caller, Caller::Unseen | Caller::Keeper)
    }

    /// Where its cycle begins in this function, and what that is; `None` if it is only another function's.
    #[must_use]
    pub fn cycle_head(&self) -> Option<(Span, CycleKind)> {
        if self.is_foreign { Some((self.closure?, CycleKind::Closure)) } else { Some((self.keyword, self.kind)) }
    }

    /// Whether the function stays in it until something in it ends it.
    #[must_use]
    pub fn is_endless(&self) -> bool {
        self.rounds == Rounds::Unbounded && !self.is_foreign && self.caller == Caller::Code
    }
}
