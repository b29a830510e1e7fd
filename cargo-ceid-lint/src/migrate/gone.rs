//! The text that goes with the updates: whole statements with their lines, and what is hollow without them. What is said of an update
//! goes to the guard.

use std::collections::BTreeSet;
use std::ops::Range;

use super::body::LoopBody;
use super::hollow::{Cut, cuts};
use super::mentions::Guarded;
use super::said::{Comments, comment_behind};
use super::sites::Site;
use super::text::{line_stop, removal};
use crate::source::Span;

/// What goes.
pub(super) struct Gone<'a> {
    of: &'a LoopBody<'a>,
    guarded: &'a [Guarded],
    cuts: Vec<Cut>,
    comments: Comments,
}

/// Statements that follow each other and go together.
pub(super) struct Removed {
    pub(super) range: Range<usize>,
    /// The filters that they update, by their places in the guard.
    pub(super) owners: BTreeSet<usize>,
    /// Whether the first of them is an update, or a choice around some, and not a variable that only those have used.
    pub(super) begins_with_update: bool,
}

impl<'a> Gone<'a> {
    /// What goes when a guard has these filters. `has_own_line` says whether the guard is there to take over what is said of them.
    pub(super) fn of(of: &'a LoopBody<'a>, guarded: &'a [Guarded], has_own_line: bool) -> Self {
        let mut gone = Self { of, guarded, cuts: cuts(of, guarded), comments: Comments::default() };
        if has_own_line {
            gone.comments.find_behind(of.text, guarded);
            let removed = gone.removed();
            gone.comments.find_above(of, guarded, &removed);
        }
        gone
    }

    /// What goes to the guard.
    pub(super) fn comments(&self) -> &Comments {
        &self.comments
    }

    /// Adds the edits that take the updates away with what is said of them, and takes out those of code that goes.
    pub(super) fn take_away(&self, edits: &mut Vec<(Span, String)>) {
        let text = self.of.text;
        edits
            .retain(|(span, _)| !self.is_cut(&(span.start as usize..span.end as usize)) || span.file != self.of.file());
        let begins = |removed: &Removed| self.comments.start_above(&removed.range).unwrap_or(removed.range.start);
        let removed = self.removed().into_iter().map(|removed| begins(&removed)..removed.range.end);
        let removed: Vec<Range<usize>> = removed.map(|range| removal(text, range)).collect();
        edits.extend(removed.iter().map(|range| (self.span(range), String::new())));
        let emptied = self.sites().filter_map(|(_, site)| Some((site.stmt.clone()?, site.emptied?)));
        let emptied = emptied.filter(|(stmt, _)| !self.is_cut(stmt));
        edits.extend(emptied.map(|(stmt, left)| (self.span(&stmt), left.to_owned())));
        let goes = |part: &Range<usize>| removed.iter().any(|own| own.start <= part.start && part.end <= own.end);
        let parts = self.cuts.iter().filter(|cut| !cut.is_statement && !goes(&cut.range));
        edits.extend(parts.map(|cut| (self.span(&cut.range), cut.instead.clone())));
    }

    fn sites(&self) -> impl Iterator<Item = (usize, &Site)> {
        let guarded = self.guarded.iter().enumerate();
        guarded.flat_map(|(at, own)| own.sites.iter().map(move |site| (at, site)))
    }

    fn is_cut(&self, range: &Range<usize>) -> bool {
        self.cuts.iter().any(|cut| cut.swallows(range))
    }

    /// The statements that go as a whole.
    fn removed(&self) -> Vec<Removed> {
        let text = self.of.text;
        let of_site = |(at, site): (usize, &Site)| {
            let stmt = site.stmt.clone().filter(|stmt| site.emptied.is_none() && !self.is_cut(stmt))?;
            let has_said =
                self.comments.behind(&self.guarded[at].name).is_some() && comment_behind(text, &stmt).is_some();
            let stop = if has_said { line_stop(text, stmt.end) } else { stmt.end };
            let range = stmt.start..stmt.end + text[stmt.end..stop].trim_end().len();
            Some(Removed { range, owners: BTreeSet::from([at]), begins_with_update: true })
        };
        let of_cut = |cut: &Cut| {
            let is_in = |site: &Site| site.stmt.as_ref().is_some_and(|stmt| cut.range.contains(&stmt.start));
            let owners: BTreeSet<usize> = self.sites().filter(|(_, site)| is_in(site)).map(|(at, _)| at).collect();
            Removed { range: cut.range.clone(), begins_with_update: !owners.is_empty(), owners }
        };
        let statements = self.cuts.iter().filter(|cut| cut.is_statement);
        let mut all: Vec<Removed> = self.sites().filter_map(of_site).chain(statements.map(of_cut)).collect();
        all.sort_by_key(|removed| removed.range.start);
        let mut joined: Vec<Removed> = Vec::new();
        for removed in all {
            match joined.last_mut() {
                Some(last) if text[last.range.end.min(removed.range.start)..removed.range.start].trim().is_empty() => {
                    last.range.end = removed.range.end;
                    last.owners.extend(removed.owners);
                }
                _ => joined.push(removed),
            }
        }
        joined
    }

    fn span(&self, range: &Range<usize>) -> Span {
        let to_u32 = |at: usize| u32::try_from(at).unwrap_or(u32::MAX);
        Span::new(self.of.file(), to_u32(range.start), to_u32(range.end))
    }
}
