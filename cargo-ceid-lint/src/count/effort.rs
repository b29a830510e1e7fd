//! How much is looked at for the pairs of one function: many filters in much code are the product of both.

use std::cell::Cell;

use super::analyse::{Context, FunctionFacts};
use crate::flow::Cause;

/// How many states are looked at for all pairs of a function, about as many as are looked at in a few seconds: a thousand filters
/// in one loop stay below.
const MAX_EFFORT: usize = 16_000_000;

/// How much was looked at for the pairs of a function.
#[derive(Debug, Default)]
pub(super) struct Effort(Cell<usize>);

impl Effort {
    pub(super) fn add(&self, amount: usize) {
        self.0.set(self.0.get().saturating_add(amount));
    }

    fn limit(&self) -> Option<Cause> {
        let limit = || Cause::Limit("the function has too many filters for its length".to_owned());
        (self.0.get() > MAX_EFFORT).then(limit)
    }
}

impl Context<'_> {
    /// Why the pairs of a function are not told apart any more, if they are not.
    pub(super) fn limit(&self, facts: &FunctionFacts<'_>) -> Option<Cause> {
        facts.aliases.limit().or_else(|| self.effort.limit())
    }
}
