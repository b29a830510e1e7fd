//! What comments say of updates that go: it goes to the guard, if it can only be about them.

use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;

use super::body::LoopBody;
use super::gone::Removed;
use super::mentions::Guarded;
use super::text::{begins_line, line_start, line_stop};

/// How words begin that speak of running a law.
const LAW_WORDS: [&str; 14] = [
    "advanc", "correct", "estimat", "evolv", "filter", "integrat", "law", "observ", "predict", "propagat", "sampl",
    "step", "tick", "updat",
];

/// The comments that go to the guard.
#[derive(Default)]
pub(super) struct Comments {
    /// What stands behind the one update of a filter in its line, by the name of the filter in the guard.
    behind: BTreeMap<String, String>,
    /// What stands in lines of its own above updates.
    above: Vec<Above>,
}

struct Above {
    /// From the first comment to the first update.
    range: Range<usize>,
    lines: Vec<String>,
    /// The one of several filters that it is about; nothing where it is about all that the guard has, or about some of them.
    name: Option<String>,
}

impl Comments {
    /// What is said behind the update of a filter.
    pub(super) fn behind(&self, name: &str) -> Option<&str> {
        self.behind.get(name).map(String::as_str)
    }

    /// The lines that are said above the update of a filter, or of the updates of several.
    pub(super) fn above<'s>(&'s self, name: Option<&'s str>) -> impl Iterator<Item = &'s str> {
        let own = self.above.iter().filter(move |above| above.name.as_deref() == name);
        own.flat_map(|above| above.lines.iter().map(String::as_str))
    }

    /// Whether something is said of one of several filters.
    pub(super) fn tell_apart(&self) -> bool {
        !self.behind.is_empty() || self.above.iter().any(|above| above.name.is_some())
    }

    /// Where what is said begins, if it is said above these statements.
    pub(super) fn start_above(&self, removed: &Range<usize>) -> Option<usize> {
        self.above.iter().find(|above| above.range.end == removed.start).map(|above| above.range.start)
    }

    /// Finds what is said behind the updates.
    pub(super) fn find_behind(&mut self, text: &str, guarded: &[Guarded]) {
        let of_filter = |own: &Guarded| {
            let mut updates =
                own.sites.iter().filter(|site| site.emptied.is_none()).filter_map(|site| site.stmt.as_ref());
            let only = updates.next().filter(|_| updates.next().is_none())?;
            Some((own.name.clone(), comment_behind(text, only)?.to_owned()))
        };
        self.behind = guarded.iter().filter_map(of_filter).collect();
    }

    /// Finds what is said above the statements that go.
    pub(super) fn find_above(&mut self, of: &LoopBody<'_>, guarded: &[Guarded], removed: &[Removed]) {
        let text = of.text;
        for removed in removed.iter().filter(|removed| removed.begins_with_update) {
            let range = &removed.range;
            let is_in = |own: &Guarded| {
                own.sites.iter().all(|site| site.stmt.as_ref().is_some_and(|stmt| range.contains(&stmt.start)))
            };
            let owners: Vec<&Guarded> = removed.owners.iter().map(|at| &guarded[*at]).collect();
            let rest = &text[range.end..line_stop(text, range.end)];
            if !owners.iter().all(|own| is_in(own)) || !rest.trim().is_empty() {
                continue;
            }
            let Some((start, lines)) = comment_above(text, range.start) else { continue };
            if speaks_of_nothing_else(text, range.end, &lines, &owners) {
                let name = match owners.as_slice() {
                    [own] if guarded.len() > 1 => Some(own.name.clone()),
                    _ => None,
                };
                let lines = lines.into_iter().map(str::to_owned).collect();
                self.above.push(Above { range: start..range.start, lines, name });
            }
        }
    }
}

/// The comment at the end of the line of a statement that has it for itself; not one that tells this tool something.
pub(super) fn comment_behind<'t>(text: &'t str, stmt: &Range<usize>) -> Option<&'t str> {
    let rest = text[stmt.end..line_stop(text, stmt.end)].trim();
    (begins_line(text, stmt.start) && rest.starts_with("//") && !rest.contains("ceid:")).then_some(rest)
}

/// The comments in the lines right above a statement, and where they begin; none that tell this tool something.
fn comment_above(text: &str, stmt: usize) -> Option<(usize, Vec<&str>)> {
    let mut start = line_start(text, stmt);
    let mut lines = Vec::new();
    while begins_line(text, stmt) && start > 0 {
        let before = line_start(text, start - 1);
        let line = text[before..start].trim();
        let is_block = line.starts_with("/*") && line.find("*/") == Some(line.len() - 2);
        if !(line.starts_with("//") || is_block) {
            break;
        }
        lines.insert(0, line);
        start = before;
    }
    let is_told = lines.iter().any(|line| line.contains("ceid:"));
    (!lines.is_empty() && !is_told).then_some((start, lines))
}

/// Whether a comment can be about nothing but the updates below it: they are all that it has below it, or it speaks of them and not
/// of what follows them.
fn speaks_of_nothing_else(text: &str, end: usize, lines: &[&str], owners: &[&Guarded]) -> bool {
    let below = text[line_stop(text, end)..].split('\n').map(str::trim);
    let followers: Vec<&str> = below.take_while(|line| !line.is_empty() && !line.starts_with('}')).collect();
    let said: BTreeSet<String> = lines.iter().flat_map(|line| words_of(line)).collect();
    let names: BTreeSet<String> = owners
        .iter()
        .flat_map(|own| own.sites.iter().map(|site| &site.method).chain([&own.spelled]))
        .flat_map(|name| words_of(name))
        .collect();
    let is_about_law = |word: &String| names.contains(word) || LAW_WORDS.iter().any(|begin| word.starts_with(begin));
    let mut of_followers = followers.iter().flat_map(|line| words_of(line));
    followers.is_empty() || said.iter().any(is_about_law) && !of_followers.any(|word| said.contains(&word))
}

/// The words of a text, and of the names in it, that are no short ones.
fn words_of(text: &str) -> Vec<String> {
    let words = text.split(|sign: char| !sign.is_alphanumeric());
    words.filter(|word| word.len() > 2).map(str::to_lowercase).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn comments_above_are_whole_lines() {
        let above = |text: &'static str| comment_above(text, text.find("f.u").expect("it is there"));
        assert_eq!(above("    a(); // b\n    // c\n    /* d */\n    f.u();"), Some((14, vec!["// c", "/* d */"])));
        assert_eq!(above("    // c\n\n    f.u();"), None);
        assert_eq!(above("    // ceid: allow(x)\n    f.u();"), None);
        assert_eq!(above("    // c\n    a(); f.u();"), None);
    }

    #[test]
    fn a_comment_may_be_about_what_follows() {
        let is_moved = |said: &str, below: &str| {
            let text = format!("f.u();\n{below}");
            speaks_of_nothing_else(&text, 6, &[said], &[])
        };
        assert!(
            is_moved("// Anything.", "")
                && is_moved("// Anything.", "\ndisplay.show();")
                && is_moved("// Anything.", "}")
        );
        assert!(is_moved("// Advance both.", "hardware.wait(period);\n"));
        assert!(!is_moved("// Anything.", "hardware.wait(period);\n"));
        assert!(!is_moved("// Update the display.", "display.show();\n"));
    }
}
