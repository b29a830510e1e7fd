//! What looks like a filter or a cycle and is not known as one: the evidence behind a first `ceid-lint.toml`, as plain data.
//!
//! A candidate is a proposal to a person, never a fact: nothing here has a part in a verdict.

mod cleared;
mod conduct;
mod cycles;
mod functional;
mod halves;
mod judge;
mod laws;
mod measured;
mod outside;
mod paths;
mod selected;
mod together;
mod traits;
mod twins;
mod uses;
mod words;

use std::collections::BTreeMap;

use crate::config::{InstancePlace, Multiplicity, Receiver, TimeBase};
use crate::flow::Program;
use crate::index::{EntryScope, FunctionId};
use crate::source::Span;

use laws::Finder;

/// What was found in the packages of one workspace.
#[derive(Clone, Debug, Default)]
pub struct Candidates {
    /// Filters, the most certain first.
    pub filters: Vec<FilterCandidate>,
    /// Cycle functions, those that update most first.
    pub cycles: Vec<CycleCandidate>,
    /// The names of types that are filters without an entry.
    pub known: Vec<String>,
    /// What looks like a filter and cannot be named: every path to it names something else as well.
    pub nameless: Vec<Nameless>,
}

/// A type, a trait or a function that looks like a filter.
#[derive(Clone, Debug)]
pub struct FilterCandidate {
    /// What it is.
    pub subject: Subject,
    /// The path by which an entry names it.
    pub path: String,
    /// Where it is declared; nowhere if it belongs to a crate whose sources are not read.
    pub place: Option<Span>,
    /// The groups of the law, each with its multiplicity.
    pub law: Vec<(Vec<String>, Multiplicity)>,
    /// Where the state is in a call of the law.
    pub instance: InstancePlace,
    /// How the law takes its receiver.
    pub receiver: Receiver,
    /// Methods that set the whole state.
    pub resets: Vec<String>,
    /// Methods that set a part of it.
    pub partial_resets: Vec<String>,
    /// The argument of the law that selects one of several states.
    pub key: Option<u32>,
    /// Where the time step comes from.
    pub time_base: TimeBase,
    /// Why it looks like a filter, the strongest reason first.
    pub reasons: Vec<Reason>,
    /// Where its law is called.
    pub uses: Uses,
    /// How sure that is.
    pub certainty: Certainty,
    /// The weight of the reasons, to compare candidates by.
    pub weight: i32,
}

/// What an entry is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Subject {
    /// A type.
    Type,
    /// Every type that implements a trait.
    Trait,
    /// A function, one of whose arguments is the state.
    Function,
}

/// Why something looks like a filter.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Reason {
    /// The law computes these fields from their own old values.
    Carries(String, Vec<String>),
    /// The law changes these fields.
    Changes(String, Vec<String>),
    /// The law takes a state of this type, and gives back the next one.
    GivesBack(String, String),
    /// The law runs the laws of filters in these fields.
    Runs(String, Vec<String>),
    /// So many types implement the trait with such a law.
    Implemented(usize),
    /// The name says so.
    Named(String),
    /// The law is told how much time has passed.
    Timed(String),
    /// It belongs to a crate whose sources are not read; these methods are called on it.
    Unread(String, Vec<String>),
    /// These fields are gains, coefficients or steps.
    Tuned(Vec<String>),
}

/// How sure it is that a candidate is what it looks like.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Certainty {
    /// Sure enough to be turned on without asking.
    Certain,
    /// Most likely.
    Likely,
    /// Worth a look.
    Possible,
}

/// Where something is called, tests apart.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub struct Uses {
    /// The calls that were read.
    pub calls: usize,
    /// Those of them that lie in a loop or a function that is called once per cycle.
    pub in_cycles: usize,
    /// The calls through a trait that may mean it or another type's.
    pub by_trait: usize,
}

/// A function that looks like a control cycle.
#[derive(Clone, Debug)]
pub struct CycleCandidate {
    /// The key of the entry, and what it names.
    pub target: CycleTarget,
    /// Where the first function is.
    pub place: Span,
    /// How many functions the entry is about.
    pub functions: usize,
    /// How many calls of laws they run.
    pub laws: usize,
    /// What says that it is called once per cycle.
    pub reason: CycleReason,
}

/// What a `[[cycle]]` names.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum CycleTarget {
    /// A function.
    Function(String),
    /// A method of a trait.
    Method(String),
    /// An attribute.
    Attribute(String),
}

impl CycleTarget {
    /// The path as an entry has it.
    #[must_use]
    pub fn path(&self) -> &str {
        match self {
            Self::Function(path) | Self::Method(path) | Self::Attribute(path) => path,
        }
    }
}

/// What says that a function is called once per cycle.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum CycleReason {
    /// Its attribute is that of a handler or task.
    Attribute,
    /// It is exported for an interrupt or a callback in C.
    Exported,
    /// It is handed to another function by its name.
    HandedOver,
    /// It implements a method of a framework's trait.
    Framework,
    /// It has the state in a parameter, and nothing that was read calls it.
    NotCalled,
}

/// What looks like a filter and cannot be named.
#[derive(Clone, Debug)]
pub struct Nameless {
    /// Its name.
    pub name: String,
    /// Where it is declared.
    pub place: Span,
}

/// Finds candidates in the crates of `scope`. Paths begin with `crate` if `is_alone`, else with the package.
#[must_use]
pub fn find(program: &Program<'_>, scope: &EntryScope<'_>, is_alone: bool) -> Candidates {
    let mut finder = Finder::new(program, scope, is_alone);
    finder.find_types();
    finder.find_functions();
    finder.find_functional();
    finder.find_outside();
    let laws: BTreeMap<FunctionId, String> = finder.laws();
    let cycles = cycles::find(&finder, &laws);
    finder.finish(cycles)
}
