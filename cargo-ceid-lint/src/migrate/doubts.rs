//! Imports that stay though perhaps nothing needs them: a person is told of these.

use std::collections::BTreeSet;

use super::import::Import;
use super::imports::{Doubtful, Scope, Sought, to_u32};
use super::takers::Takers;
use super::text::without_comments;
use crate::source::Span;

impl Scope<'_> {
    /// The import whose name stands at a byte, if only code that is compiled under a condition needs it, or a comment, or nothing.
    pub(super) fn doubt(&self, at: usize) -> Option<Doubtful> {
        let import = Import::at(self.written(), at, self.name)
            .filter(|import| import.visibility.is_empty() && !self.is_of_core(import) && !self.is_of_other(import))?;
        let around = self.outline.around(import.stmt.start).next();
        let scope = around.map_or(0..self.text.len(), |around| around.brackets.clone());
        let code = self.unconditional(&self.seen(&import, &(0..self.text.len()), true, Sought::Names));
        if !code[import.stmt.start..].starts_with("use") {
            return None;
        }
        if self.is_used(&import, &code, &code, &scope) || around.is_none() && self.is_surely_taken(&import) {
            return None;
        }
        let [code, calls] =
            [Sought::Names, Sought::Calls].map(|of| without_comments(&self.seen(&import, &scope, false, of)));
        let is_conditional = self.is_used(&import, &code, &calls, &scope);
        let span = Span::new(self.file, to_u32(import.stmt.start), to_u32(import.stmt.end));
        Some(Doubtful { span, name: self.name.to_owned(), is_conditional })
    }

    /// Whether code of other modules needs what it has from there, and is under no condition.
    fn is_surely_taken(&self, import: &Import<'_>) -> bool {
        let bound = import.alias.unwrap_or(self.name);
        let names: BTreeSet<&str> = Some(bound).into_iter().filter(|bound| *bound != "_").collect();
        let from: BTreeSet<_> = self.homes(import.stmt.start).collect();
        let takers = Takers::of(self.program, self.macros, from, &names, &(self.file, import.stmt.clone()));
        takers.surely_need(self.wanted(&names), self.macros)
    }
}
