//! The text that goes with the updates: whole statements with their lines, and what is hollow without them.

use std::ops::Range;

use super::body::LoopBody;
use super::hollow::{Cut, cuts};
use super::mentions::Guarded;
use super::sites::Site;
use super::text::removal;
use crate::source::Span;

/// Adds the edits that take the updates away, and takes out those of code that goes; statements that follow each other go together.
pub(super) fn take_away(of: &LoopBody<'_>, guarded: &[Guarded], edits: &mut Vec<(Span, String)>) {
    let cuts = cuts(of, guarded);
    let is_cut = |range: &Range<usize>| cuts.iter().any(|cut| cut.swallows(range));
    edits.retain(|(span, _)| !is_cut(&(span.start as usize..span.end as usize)) || span.file != of.file());
    let sites = guarded.iter().flat_map(|own| &own.sites);
    let sites = sites.filter(|site| site.stmt.as_ref().is_some_and(|stmt| !is_cut(stmt)));
    let (emptied, sites): (Vec<&Site>, Vec<&Site>) = sites.partition(|site| site.emptied.is_some());
    let (statements, parts): (Vec<&Cut>, Vec<&Cut>) = cuts.iter().partition(|cut| cut.is_statement);
    let mut stmts: Vec<Range<usize>> = sites.into_iter().filter_map(|site| site.stmt.clone()).collect();
    stmts.extend(statements.into_iter().map(|cut| cut.range.clone()));
    stmts.sort_by_key(|stmt| stmt.start);
    let mut joined: Vec<Range<usize>> = Vec::new();
    for stmt in stmts {
        match joined.last_mut() {
            Some(last) if of.text[last.end.min(stmt.start)..stmt.start].trim().is_empty() => last.end = stmt.end,
            _ => joined.push(stmt),
        }
    }
    edits.extend(joined.into_iter().map(|stmt| (span(of, &removal(of.text, stmt)), String::new())));
    edits
        .extend(emptied.into_iter().filter_map(|site| Some((span(of, site.stmt.as_ref()?), site.emptied?.to_owned()))));
    edits.extend(parts.into_iter().map(|cut| (span(of, &cut.range), cut.instead.clone())));
}

fn span(of: &LoopBody<'_>, range: &Range<usize>) -> Span {
    let to_u32 = |at: usize| u32::try_from(at).unwrap_or(u32::MAX);
    Span::new(of.file(), to_u32(range.start), to_u32(range.end))
}
