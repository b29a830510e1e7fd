//! Which variables were computed from which.

use std::cell::RefCell;

use rustc_hash::FxHashSet;

use super::aliases::Aliases;
use crate::flow::Var;

impl Aliases {
    /// Whether a variable was computed from one of these, by any number of steps.
    pub(super) fn is_derived(&self, var: Var, from: &[Var]) -> bool {
        self.derived_from(from).contains(var)
    }

    /// The variables that were computed from one of these, by any number of steps, and these.
    pub(super) fn derived_from<'a>(&'a self, from: &'a [Var]) -> Derived<'a> {
        Derived { aliases: self, from, others: RefCell::default() }
    }

    /// What these variables were computed from, by any number of steps, and these.
    pub(super) fn origins(&self, of: &[Var]) -> FxHashSet<Var> {
        let mut seen = FxHashSet::default();
        let mut open = of.to_vec();
        while let Some(at) = open.pop() {
            if seen.insert(at) {
                open.extend(self.derived.get(&at).into_iter().flatten().copied());
            }
        }
        seen
    }
}

/// The variables that were computed from some, asked one by one: what was found on the way to one answer is known for the next.
pub(super) struct Derived<'a> {
    aliases: &'a Aliases,
    from: &'a [Var],
    /// Those that were not.
    others: RefCell<FxHashSet<Var>>,
}

impl Derived<'_> {
    pub(super) fn contains(&self, var: Var) -> bool {
        let mut others = self.others.borrow_mut();
        let mut seen = FxHashSet::default();
        let mut open = vec![var];
        while let Some(at) = open.pop() {
            if self.from.contains(&at) {
                return true;
            }
            if !others.contains(&at) && seen.insert(at) {
                open.extend(self.aliases.derived.get(&at).into_iter().flatten().copied());
            }
        }
        others.extend(seen);
        false
    }
}
