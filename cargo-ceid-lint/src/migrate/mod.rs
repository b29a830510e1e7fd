//! From a loop that updates its filters by hand to the same loop with a guard of `ceid-core`: the edits, or why there are none.
//!
//! A loop is rewritten only if every filter that it updates exactly once can be handed to a guard so that the program does what it
//! did before; where it would do something else, the plan says so, and is followed only if that was asked for.
//! Reads no file and writes none.

mod adapt;
mod alternatives;
mod ambiguous;
mod body;
mod boxed;
mod called;
mod calm;
mod captures;
mod closure;
mod conditional;
mod core_items;
mod doubts;
mod each;
mod effects;
mod elements;
mod exits;
mod formats;
mod globs;
mod gone;
mod halves;
mod head;
mod holding;
mod hollow;
mod implicit;
mod import;
mod imports;
mod in_head;
mod in_scope;
mod inputs;
mod iteration;
mod lasting;
mod law;
mod leaving;
mod leftover;
mod locks;
mod loops;
mod lost;
mod macros;
mod manifest;
mod mentions;
mod named;
mod narrowed;
mod not_shipped;
mod observed;
mod outputs;
mod owned;
mod panics;
mod partly;
mod passed;
mod path;
mod plan;
mod present;
mod purity;
mod said;
mod seen;
mod shadowed;
mod shared;
mod signs;
mod sites;
mod survivors;
mod tails;
mod takers;
mod text;
mod turbofish;
mod twice;
mod unfit;
mod unread;
mod whole;
mod worded;

use std::collections::BTreeSet;

use crate::diagnostic::{Applicability, Suggestion};
use crate::index::{FunctionId, Ty};
use crate::source::Span;

pub use imports::{Doubtful, HandedOn, IdleImports, idle_imports};
pub use manifest::{Wanted, dependency, is_ceid_core};
pub use named::{asks_for_names, name_in_root, needless_name};
pub use plan::plans;
pub use text::is_no_std;

/// What can be done about one loop.
#[derive(Clone, Debug)]
pub struct Plan {
    /// The head of the cycle.
    pub head: Span,
    /// The whole cycle, as far as it is a loop.
    pub whole: Span,
    /// The function it lies in.
    pub function: String,
    /// Whether it is a function that gets its filters lent, and nothing says that it is called once per cycle.
    pub is_helper: bool,
    /// The filters that it updates by hand, as the source spells them.
    pub filters: Vec<String>,
    /// Those of them that it never updates.
    pub missed: Vec<String>,
    /// The rewriting, or why there is none.
    pub outcome: Result<Rewrite, Vec<Reason>>,
    /// Where they cannot all go without a change, those that can while the others stay.
    pub partly: Option<Partly>,
}

/// What can be done about some of the filters of a loop.
#[derive(Clone, Debug)]
pub struct Partly {
    /// These, as the source spells them.
    pub filters: Vec<String>,
    /// The rewriting, by which the program does the same.
    pub rewrite: Rewrite,
    /// Why the others stay, or what the program would do otherwise if they went.
    pub reasons: Vec<Reason>,
}

impl Plan {
    /// The rewritings, with what each does: of some of the filters, by which the program does the same, and of all.
    #[must_use]
    pub fn rewrites(&self) -> Vec<(String, &Rewrite)> {
        let partly = self.partly.as_ref().map(|partly| {
            let staying: Vec<String> =
                self.filters.iter().filter(|name| !partly.filters.contains(name)).cloned().collect();
            let title = format!("let a guard update {}; {}", quoted(&partly.filters), self.stay(&staying));
            (title, &partly.rewrite)
        });
        let all = self.outcome.as_ref().ok().map(|rewrite| {
            let changes = if rewrite.changes.is_empty() { "" } else { ", which changes what the program does" };
            (format!("let a guard update {}{changes}", quoted(&self.filters)), rewrite)
        });
        partly.into_iter().chain(all).collect()
    }

    /// That these filters stay by hand, or as they are where one of them is never updated.
    #[must_use]
    pub fn stay(&self, staying: &[String]) -> String {
        let verb = if staying.len() == 1 { "stays" } else { "stay" };
        let how = match staying {
            _ if !staying.iter().any(|name| self.missed.contains(name)) => "by hand",
            [_] => "as it is",
            _ => "as they are",
        };
        format!("{} {verb} {how}", quoted(staying))
    }

    /// The rewriting of all filters as a suggestion, if there is one and no manifest has to change for it.
    #[must_use]
    pub fn suggestion(&self) -> Option<Suggestion> {
        self.outcome.as_ref().ok().filter(|rewrite| rewrite.is_dependency)?;
        let (message, rewrite) = self.rewrites().pop()?;
        Some(Suggestion { message, edits: rewrite.edits.clone(), applicability: Applicability::MaybeIncorrect })
    }
}

/// Names as a sentence has them.
#[must_use]
pub fn quoted(names: &[String]) -> String {
    names.iter().map(|name| format!("`{name}`")).collect::<Vec<_>>().join(", ")
}

impl Rewrite {
    /// The packages that have to depend on `ceid-core`, as indices into those of the project.
    #[must_use]
    pub fn packages(&self) -> BTreeSet<usize> {
        self.targets.iter().map(|(package, _)| *package).collect()
    }
}

/// How a loop is rewritten.
#[derive(Clone, Debug)]
pub struct Rewrite {
    /// Places and what to write there instead.
    pub edits: Vec<(Span, String)>,
    /// The types that become filters of ceid-core, each with the law that guards run.
    pub laws: Vec<(Ty, FunctionId)>,
    /// The targets whose code names `ceid-core` then: the package, as an index into those of the project, and the target, as one into
    /// those of the package.
    pub targets: BTreeSet<(usize, usize)>,
    /// Whether they do already.
    pub is_dependency: bool,
    /// Whether `ceid-core` has to know `Vec`.
    pub needs_alloc: bool,
    /// What the program does otherwise than before; empty if it does the same.
    pub changes: Vec<Reason>,
    /// What a person should know of it.
    pub notes: Vec<String>,
}

/// Why something is not done, or what changes by it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Reason {
    /// Where.
    pub span: Span,
    /// What; lower case, no full stop.
    pub text: String,
}
