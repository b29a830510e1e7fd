//! Which code each suppression stands for. Decides no finding, and does not know which rules there are.

mod reach;

use crate::source::{SourceMap, Span};
use crate::syntax::tree::Item;
use crate::syntax::{Directive, DirectiveKind, Directives, NearMiss, Suppression};

/// A crate whose code may be suppressed.
#[derive(Clone, Copy, Debug)]
pub struct Crate<'a> {
    /// Index into the project's packages.
    pub package: usize,
    /// Index into the package's targets.
    pub target: usize,
    /// The items of its root.
    pub items: &'a [Item],
}

/// What comments and attributes say of findings.
#[derive(Clone, Debug, Default)]
pub struct Suppressions {
    /// Those of code that was analysed, by file and place.
    pub list: Vec<Placed<Suppression>>,
    /// What was meant as a directive and is none.
    pub near_misses: Vec<Placed<NearMiss>>,
}

/// A directive with the code that it stands for.
#[derive(Clone, Debug)]
pub struct Placed<T> {
    /// What it says.
    pub said: T,
    /// Where it stands.
    pub span: Span,
    /// What goes when it is removed.
    pub removal: Span,
    /// Index into the project's packages.
    pub package: usize,
    /// Index into the package's targets.
    pub target: usize,
    /// The code; empty if there is none.
    pub reach: Vec<Span>,
    /// Whether it is certain which code it stands for: code that `cfg` removes is not known.
    pub is_placed: bool,
}

impl Suppressions {
    /// Places the directives of all files that belong to a crate.
    #[must_use]
    pub fn place(directives: &Directives, sources: &SourceMap, crates: &[Crate<'_>]) -> Self {
        let mut found = Self::default();
        if directives.iter().all(|directive| matches!(directive.kind, DirectiveKind::Cycle(_))) {
            return found;
        }
        let code = reach::Code::of(crates);
        for directive in directives.iter() {
            let Some((package, target)) = code.owner(directive.span.file) else { continue };
            let (reach, is_placed) = code.reach(sources, directive);
            let Directive { span, removal, .. } = *directive;
            match &directive.kind {
                DirectiveKind::Cycle(_) => {}
                DirectiveKind::Suppression(said) => {
                    let said = said.clone();
                    found.list.push(Placed { said, span, removal, package, target, reach, is_placed });
                }
                DirectiveKind::NearMiss(said) => {
                    let said = said.clone();
                    found.near_misses.push(Placed { said, span, removal, package, target, reach, is_placed });
                }
            }
        }
        found
    }

    /// The innermost suppression that names a rule and stands for one of these places: its number, and that of the name.
    #[must_use]
    pub fn of(&self, rule: &str, places: &[Span]) -> Option<(usize, usize)> {
        let named = self.list.iter().enumerate().filter_map(|(number, placed)| {
            let is_rule = |(name, _): &(String, Span)| name.strip_prefix("ceid::").unwrap_or(name) == rule;
            let name = placed.said.rules.iter().position(is_rule)?;
            let size = placed.size_around(places)?;
            Some((size, std::cmp::Reverse(number), number, name))
        });
        named.min().map(|(_, _, number, name)| (number, name))
    }
}

impl<T> Placed<T> {
    /// The size of the smallest part of its code that one of the places begins in.
    fn size_around(&self, places: &[Span]) -> Option<u32> {
        let is_inside = |reach: &Span| {
            places.iter().any(|place| reach.contains(Span { end: place.start, ..*place }) && place.start < reach.end)
        };
        self.reach.iter().filter(|reach| is_inside(reach)).map(|reach| reach.end - reach.start).min()
    }
}
