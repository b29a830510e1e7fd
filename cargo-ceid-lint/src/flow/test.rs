//! What branches ask: a subject, and which of its heads take the branch. Branches on the same subject are correlated.

use super::{AskedLength, Cause, ControlFlowGraph, Effect, Place, Var, is_receiving};
use crate::index::Ty;
use crate::source::Span;

/// Something that branches ask about: a variable, a pure expression, the result of a call.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct SubjectId(pub u32);

/// The head of a value: a variant, a literal, a truth value. `Some` and `Ok` are `+`, `None` and `Err` are `-`, because methods
/// such as `ok()` turn one into the other.
pub type Head = String;

/// The bit for every head that is not in a subject's list.
pub const OTHER_HEADS: u32 = 1 << 31;

/// The head of a comparison of a loop's number that has held in an earlier round of the loop, and holds no more.
pub const PAST: &str = "past";

/// How many heads of a subject are told apart; the others are one.
pub(super) const MAX_HEADS: usize = 31;

/// What branches ask about.
#[derive(Clone, Debug)]
pub struct Subject {
    /// What tells subjects apart.
    pub key: String,
    /// The places that its value depends on; when one is written, nothing is known of the subject any more.
    pub reads: Vec<Place>,
    /// The place whose value it is, if it is one.
    pub whole: Option<Place>,
    /// The question about a place that it is to callers, if some of them may ask for the same.
    pub question: Option<Place>,
    /// Whether nothing but callers asks for it.
    pub is_of_callers: bool,
    /// The heads that something asks for or assigns, in the order of their bits.
    pub heads: Vec<Head>,
    /// Whether the heads are all there are (once they are all listed).
    pub total: Option<Vec<Head>>,
}

impl Subject {
    /// The heads that the subject can have when nothing is known of it.
    #[must_use]
    pub fn anything(&self) -> u32 {
        let listed = bits(self.heads.len());
        match &self.total {
            Some(all) if all.iter().all(|head| self.heads.contains(head)) => listed,
            _ => listed | OTHER_HEADS,
        }
    }

    /// The two places of which it asks whether they are equal.
    #[must_use]
    pub fn equals(&self) -> Option<(&Place, &Place)> {
        match self.reads.as_slice() {
            [left, right] if self.whole.is_none() && self.key.contains(" == ") => Some((left, right)),
            _ => None,
        }
    }

    /// The heads of another subject with the same value, of which the list is given, as this one's.
    #[must_use]
    pub fn translate(&self, mask: u32, source: &[Head]) -> u32 {
        let mut bits = if mask & OTHER_HEADS != 0 { OTHER_HEADS } else { 0 };
        for (number, head) in source.iter().enumerate() {
            if mask & (1 << number) != 0 {
                bits |= self.bit(head);
            }
        }
        // Heads that only this one tells apart are among the source's others.
        if mask & OTHER_HEADS != 0 {
            for (number, head) in self.heads.iter().enumerate() {
                if !source.contains(head) {
                    bits |= 1 << number;
                }
            }
        }
        bits & self.anything()
    }

    /// The heads of a mask by their names, those included that nothing asks for.
    #[must_use]
    pub fn names(&self, mask: u32) -> Vec<Head> {
        let others = self.total.iter().flatten().filter(|head| !self.heads.contains(head));
        self.heads.iter().chain(others).filter(|head| mask & self.bit(head) != 0).cloned().collect()
    }

    /// Lists these heads as well, as far as there are bits for them.
    pub fn tell_apart(&mut self, heads: &[Head]) {
        for head in heads {
            let is_possible = self.total.as_ref().is_none_or(|total| total.contains(head));
            if is_possible && self.heads.len() < MAX_HEADS && !self.heads.contains(head) {
                self.heads.push(head.clone());
            }
        }
    }

    /// The bits of some heads.
    #[must_use]
    pub fn bits(&self, heads: &[Head]) -> u32 {
        heads.iter().fold(0, |bits, head| bits | self.bit(head))
    }

    /// The bit of a head.
    #[must_use]
    pub fn bit(&self, head: &str) -> u32 {
        match self.heads.iter().position(|known| known == head) {
            Some(at) => 1 << at,
            None => OTHER_HEADS,
        }
    }
}

fn bits(count: usize) -> u32 {
    if count >= MAX_HEADS { !OTHER_HEADS } else { (1 << count) - 1 }
}

impl ControlFlowGraph {
    /// Lists these heads of a subject as well: an answer that all others have is theirs too.
    pub fn tell_apart(&mut self, id: SubjectId, heads: &[Head]) {
        let subject = &mut self.subjects[id.0 as usize];
        let before = subject.heads.len();
        subject.tell_apart(heads);
        let new = bits(subject.heads.len()) & !bits(before);
        let with_new = |mask: u32| if mask & OTHER_HEADS == 0 { mask } else { mask | new };
        for node in &mut self.nodes {
            if let Effect::Branch(test) = &mut node.effect
                && test.subject == Some(id)
            {
                (test.holds, test.fails) = (with_new(test.holds), with_new(test.fails));
            }
        }
    }
}

/// A question with two answers.
#[derive(Clone, Debug)]
pub struct Test {
    /// What is asked about; `None` if nothing is known of it.
    pub subject: Option<SubjectId>,
    /// The heads with which the test can hold.
    pub holds: u32,
    /// The heads with which it can fail.
    pub fails: u32,
    /// The condition or pattern.
    pub span: Span,
    /// The condition as a reader reads it: `armed`, `let Some(z) = gps.read()`.
    pub text: String,
    /// What kind of question it is, and what it is asked of.
    pub about: About,
}

/// A comparison with a number: `ticks >= 10`.
#[derive(Clone, Debug)]
pub struct AskedNumber {
    /// What is compared.
    pub of: Place,
    /// The operator, with that on its left, of what holds on the first edge.
    pub op: &'static str,
    /// The number on its right.
    pub number: u64,
}

impl AskedNumber {
    /// Whether it holds for a number.
    #[must_use]
    pub fn holds(&self, number: u64) -> bool {
        match self.op {
            "==" => number == self.number,
            "!=" => number != self.number,
            "<" => number < self.number,
            "<=" => number <= self.number,
            ">" => number > self.number,
            _ => number >= self.number,
        }
    }
}

/// What a test is about, for telling gates.
#[derive(Clone, Debug, Default)]
pub struct About {
    /// The places that the condition reads.
    pub reads: Vec<Place>,
    /// The variables that a pattern binds when it matches.
    pub binds: Vec<Var>,
    /// Whether it takes an `Option` or `Result` apart, or asks which it is; `?` included.
    pub is_presence: bool,
    /// The names of functions and methods called in it.
    pub names: Vec<String>,
    /// Whether it compares with `<`, `<=`, `>`, `>=`.
    pub is_comparison: bool,
    /// The places that it compares so, on the left and on the right.
    pub compared: [Option<Place>; 2],
    /// The number that it compares a place with, if it asks for nothing else.
    pub number: Option<Box<AskedNumber>>,
    /// Whether an operator with two operands is in it.
    pub is_combined: bool,
    /// Whether it contains `%` or `is_multiple_of`.
    pub is_remainder: bool,
    /// What a remainder is compared with for being equal, if that is a place.
    pub remainder_is: Option<Place>,
    /// The number that it divides by, or the mask plus one.
    pub ratio: Option<u64>,
    /// The whole numbers in it.
    pub numbers: Vec<u64>,
    /// Whether it masks bits.
    pub is_masked: bool,
    /// Whether what is asked was awaited.
    pub is_awaited: bool,
    /// Whether it is an arm of a choice between events.
    pub is_event: bool,
    /// Whether it is the guard of an arm: where it fails, another arm is taken.
    pub is_guard: bool,
    /// Whether it is a constant expression, or asks for `#[cfg]`.
    pub is_constant: bool,
    /// What the build that is judged answers, if that is asked and known.
    pub built: Option<bool>,
    /// Whether a function is asked that answers without a look at anything, and so for one that is not written yet.
    pub stands_in: bool,
    /// What it is, if it is a constant whose value is written out.
    pub constant: Option<bool>,
    /// The type whose associated constant it is, and the constant's name, if the type is a parameter: `C::TWICE`.
    pub constant_of: Option<Box<(Ty, String)>>,
    /// The places that a call in it gets by `&mut`, to write what it reads.
    pub lent: Vec<Place>,
    /// Whether it holds in a debug build, or while a log level is on, and never in what is shipped.
    pub is_debug: bool,
    /// The heads asked for, if it is a pattern or comparison with a constant.
    pub heads: Vec<Head>,
    /// Whether it is a pattern that writes elements out: `[0xA5, value, ..]`.
    pub asks_elements: bool,
    /// Whether it holds where the text does not: `a >= b` is asked as `a < b`.
    pub is_turned: bool,
    /// Why it is not known whether it holds in any iteration, if that is so.
    pub unread: Option<Cause>,
    /// Whether it holds or fails where a filter says that it is at rest, if that is what is asked.
    pub rest: Option<bool>,
    /// The length that it compares, if it asks for nothing else.
    pub length: Option<Box<AskedLength>>,
}

impl About {
    /// Whether what a variable is to hold is there.
    #[must_use]
    pub fn presence_of(var: Var) -> Self {
        Self { is_presence: true, binds: vec![var], reads: vec![Place::var(var)], ..Self::default() }
    }

    /// Whether nothing is asked but whether an `Option` or `Result` holds something.
    #[must_use]
    pub fn asks_presence(&self) -> bool {
        !self.heads.is_empty() && self.heads.iter().all(|head| is_presence(head))
    }

    /// Whether what is received is compared at once, under no name: `if commands.recv() == Ok(Command::Stop) { … }`.
    #[must_use]
    pub fn asks_received(&self) -> bool {
        let unpacks = |name: &String| matches!(name.as_str(), "expect" | "unwrap" | "unwrap_or" | "unwrap_or_default");
        let is_known = |name: &String| {
            is_receiving(name)
                || name.starts_with(char::is_uppercase)
                || unpacks(name)
                || matches!(name.as_str(), "await" | "ok")
        };
        // An arm asks for what may say that nothing was there.
        !self.is_presence
            && self.lent.is_empty()
            && (self.is_combined || self.names.iter().any(unpacks))
            && self.names.iter().any(|name| is_receiving(name))
            && self.names.iter().all(is_known)
    }

    /// Whether it is asked which of several things a value is.
    #[must_use]
    pub fn is_choice(&self) -> bool {
        !self.heads.is_empty() && !self.heads.iter().any(|head| is_presence(head))
    }
}

fn is_presence(head: &str) -> bool {
    matches!(head, "+" | "-")
}
