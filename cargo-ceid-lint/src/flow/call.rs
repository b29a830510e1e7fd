//! Calls of functions whose bodies are read, and what they are given.

use super::{Computed, Head, IndexKey, Place, Var};
use crate::index::{FunctionId, Ty};

/// A call of analysed code.
#[derive(Clone, Debug)]
pub struct CallSite {
    /// What may run.
    pub targets: Vec<FunctionId>,
    /// The arguments, `self` first.
    pub args: Vec<Argument>,
    /// The types of the arguments, that of `self` behind references, where they decide what runs.
    pub types: Vec<Ty>,
    /// The variable that holds the result.
    pub result: Var,
    /// The argument whose state the function hands through, and where its result has it.
    pub hands: Option<(usize, Place)>,
    /// The call as the source spells it, for messages: `self.step()`.
    pub text: String,
    /// Set if it is a filter's own law: the number of the argument that is the filter. Only what lies inside the filter is
    /// looked at.
    pub law_of: Option<usize>,
    /// Whether a type parameter or a trait object decides which of many bodies runs.
    pub is_dispatched: bool,
    /// The variables that its arguments read, `self` left out.
    pub fed: Vec<Var>,
    /// The variables that its result goes into.
    pub into: Vec<Var>,
    /// What its arguments read and call, `self` left out.
    pub from: Computed,
}

/// What the call of a destructor is spelt as that runs where the source has no call.
pub(crate) const DESTRUCTOR: &str = "drop";

impl CallSite {
    /// Whether no call in the source runs it, but the end of a value.
    #[must_use]
    pub fn is_destructor(&self) -> bool {
        self.text == DESTRUCTOR
    }

    /// Where the result has the state that is handed through, and where it was before.
    #[must_use]
    pub fn handed(&self) -> Option<(&Place, &Place)> {
        let (number, after) = self.hands.as_ref()?;
        Some((after, self.args.get(*number)?.place.as_ref()?))
    }
}

/// An argument of a call.
#[derive(Clone, Debug, Default)]
pub struct Argument {
    /// The place whose instances it carries.
    pub place: Option<Place>,
    /// A constant index that it is.
    pub index: Option<IndexKey>,
    /// The place whose value it is, or refers to: a condition of the function on the argument is one on that place.
    pub value_of: Option<Place>,
    /// Its head, if that is constant.
    pub head: Option<Head>,
    /// Whether it is a constant with a name: a setting, which another build may have otherwise.
    pub is_setting: bool,
    /// Whether it is a shared reference, through which nothing is updated.
    pub is_shared: bool,
    /// Whether it is passed by value, so that it is in what the function makes of it from then on.
    pub is_moved: bool,
    /// Whether all that it has of filters are references to them.
    pub is_reference: bool,
    /// Whether it is a number or the like, so that it leads to nothing.
    pub is_plain: bool,
    /// Whether what it lends are such references, so that another value there is no other filter.
    pub lends_references: bool,
    /// Whether the result of the call takes its place: `state = step(state)`.
    pub is_back: bool,
    /// Whether it is passed by value and its type is `Copy`: what is done to it is done to another instance.
    pub is_copy: bool,
    /// What it reads and calls; nothing for `self`.
    pub from: Computed,
}
