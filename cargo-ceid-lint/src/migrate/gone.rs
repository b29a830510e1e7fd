//! The text that goes with the updates: whole statements with their lines, and what is hollow without them. What is said of an update
//! behind it in its line goes to the guard.

use std::collections::BTreeMap;
use std::ops::Range;

use super::body::LoopBody;
use super::hollow::{Cut, cuts};
use super::mentions::Guarded;
use super::sites::Site;
use super::text::{begins_line, line_stop, removal};
use crate::source::Span;

/// The comments that go with the updates, by the names of their filters in the guard.
pub(super) type Comments<'t> = BTreeMap<String, &'t str>;

/// What is said behind the one update of a filter in its line.
pub(super) fn comments<'t>(of: &LoopBody<'t>, guarded: &[Guarded]) -> Comments<'t> {
    let of_filter = |own: &Guarded| {
        let mut updates = own.sites.iter().filter(|site| site.emptied.is_none()).filter_map(|site| site.stmt.as_ref());
        let only = updates.next().filter(|_| updates.next().is_none())?;
        Some((own.name.clone(), comment_behind(of.text, only)?))
    };
    guarded.iter().filter_map(of_filter).collect()
}

/// The comment at the end of the line of a statement that has it for itself; not one that tells this tool something.
fn comment_behind<'t>(text: &'t str, stmt: &Range<usize>) -> Option<&'t str> {
    let rest = text[stmt.end..line_stop(text, stmt.end)].trim();
    (begins_line(text, stmt.start) && rest.starts_with("//") && !rest.contains("ceid:")).then_some(rest)
}

/// Adds the edits that take the updates away with these comments, and takes out those of code that goes; statements that follow each
/// other go together.
pub(super) fn take_away(
    of: &LoopBody<'_>,
    guarded: &[Guarded],
    comments: &Comments<'_>,
    edits: &mut Vec<(Span, String)>,
) {
    let cuts = cuts(of, guarded);
    let is_cut = |range: &Range<usize>| cuts.iter().any(|cut| cut.swallows(range));
    edits.retain(|(span, _)| !is_cut(&(span.start as usize..span.end as usize)) || span.file != of.file());
    let sites = guarded.iter().flat_map(|own| own.sites.iter().map(move |site| (own, site)));
    let sites = sites.filter(|(_, site)| site.stmt.as_ref().is_some_and(|stmt| !is_cut(stmt)));
    let (emptied, sites): (Vec<_>, Vec<_>) = sites.partition(|(_, site)| site.emptied.is_some());
    let (statements, parts): (Vec<&Cut>, Vec<&Cut>) = cuts.iter().partition(|cut| cut.is_statement);
    let whole = |(own, site): (&Guarded, &Site)| {
        let stmt = site.stmt.clone()?;
        let comment = comments.get(&own.name).filter(|_| comment_behind(of.text, &stmt).is_some());
        let stop = comment.map(|_| line_stop(of.text, stmt.end)).unwrap_or(stmt.end);
        Some(stmt.start..stmt.end + of.text[stmt.end..stop].trim_end().len())
    };
    let mut stmts: Vec<Range<usize>> = sites.into_iter().filter_map(whole).collect();
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
    edits.extend(
        emptied.into_iter().filter_map(|(_, site)| Some((span(of, site.stmt.as_ref()?), site.emptied?.to_owned()))),
    );
    edits.extend(parts.into_iter().map(|cut| (span(of, &cut.range), cut.instead.clone())));
}

fn span(of: &LoopBody<'_>, range: &Range<usize>) -> Span {
    let to_u32 = |at: usize| u32::try_from(at).unwrap_or(u32::MAX);
    Span::new(of.file(), to_u32(range.start), to_u32(range.end))
}
