//! Which code each suppression stands for. Decides no finding, and does not know which rules there are.

mod ranges;
mod reach;

use self::ranges::Ranges;
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
    /// The numbers of the suppressions, by the code that they stand for.
    ranges: Ranges,
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
    pub reach: Vec<Reach>,
    /// Whether it is certain which code it stands for: code that `cfg` removes is not known.
    pub is_placed: bool,
}

/// A piece of code that a directive stands for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Reach {
    /// The piece.
    pub span: Span,
    /// Whether it has no block in it: what is said of it is said of the call that it is.
    pub is_plain: bool,
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
            let (spans, is_placed) = code.reach(sources, directive);
            let reach: Vec<Reach> =
                spans.into_iter().map(|span| Reach { span, is_plain: !sources.snippet(span).contains('{') }).collect();
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
        found.ranges = Ranges::of(&found.list);
        found
    }

    /// The innermost suppression that names a rule and stands for one of these places, or for one of these calls alone: its
    /// number, and that of the name.
    #[must_use]
    pub fn of(&self, rule: &str, places: &[Span], calls: &[Span]) -> Option<(usize, usize)> {
        let named = self.ranges.around(places.iter().chain(calls)).into_iter().filter_map(|number| {
            let placed = &self.list[number];
            let is_rule = |(name, _): &(String, Span)| name.strip_prefix("ceid::").unwrap_or(name) == rule;
            let name = placed.said.rules.iter().position(is_rule)?;
            let here = placed.reach.iter().filter(|reach| {
                places.iter().any(|place| reach.begins(*place))
                    || (reach.is_plain && calls.iter().any(|call| reach.begins(*call)))
            });
            let size = here.map(|reach| reach.span.end - reach.span.start).min()?;
            Some((size, std::cmp::Reverse(number), number, name))
        });
        named.min().map(|(_, _, number, name)| (number, name))
    }
}

impl Reach {
    /// Whether a place begins in it.
    fn begins(&self, place: Span) -> bool {
        self.span.file == place.file && (self.span.start..self.span.end).contains(&place.start)
    }
}
