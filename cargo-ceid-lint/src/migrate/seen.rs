//! The code that may need an import: not that which imports the same by itself.

use std::ops::Range;

use super::import::Import;
use super::imports::{Scope, Sought, blanked, segment_before};
use super::text::words;

impl Scope<'_> {
    /// What is in sight of an import, without the modules and blocks that import the same by themselves.
    pub(super) fn seen(
        &self,
        import: &Import<'_>,
        scope: &Range<usize>,
        without_tests: bool,
        sought: Sought,
    ) -> String {
        let text = self.text;
        let has_own = |at: usize| {
            let own = Import::at(self.written(), at, self.name).filter(|own| own.stmt != import.stmt)?;
            let around = self.outline.around(own.stmt.start).next().map(|around| around.brackets.clone())?;
            let path = text[own.stmt.clone()].split_once("use").map(|(_, path)| path.trim_start())?;
            let leads_there = ["super", "self", "{", "Self"].iter().any(|begin| path.starts_with(begin));
            // Under another name, it leaves its own one to the import.
            let is_named = |at: usize| {
                !own.stmt.contains(&(around.start + at))
                    && (own.alias.is_some() || segment_before(&text[around.clone()], at) == Some("super"))
            };
            let is_inside = scope.contains(&around.start) && around.len() < scope.len();
            let is_own = is_inside && !leads_there && path.contains("::") && !self.is_of_other(&own);
            (is_own && !words(&text[around.clone()], self.name).any(is_named)).then_some(around)
        };
        let own: Vec<_> = words(self.code, self.name).filter_map(has_own).collect();
        blanked(&self.in_sight(scope, without_tests, sought), own.into_iter())
    }
}
