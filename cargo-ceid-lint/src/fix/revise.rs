//! Which of the offered fixes are made: in rounds, as rustfix does, and only those after which the check finds nothing new.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use super::diff::{line_before, line_before_edits};
use super::{Change, Edit, Fix, News, Texts, news};
use crate::pipeline::Report;
use crate::source::{ReadSource, SourceMap};

/// A fix that was removed may stand where the next one begins, so that further rounds find more. Nobody needs as many as this; the
/// bound is for fixes that would undo each other.
const MOST_ROUNDS: usize = 20;

/// The rule about suppressions that hide nothing.
pub const UNUSED_SUPPRESSION: &str = "unused_suppression";

/// A fix that is not made, and why.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Refused {
    /// The fix.
    pub fix: Fix,
    /// Why, in words.
    pub why: String,
    /// Whether it is a file that cannot be written, and not the check, that forbids it.
    pub is_unwritable: bool,
}

/// What the fixes come to.
#[derive(Debug)]
pub struct Revision {
    /// The files that change, by path.
    pub changes: Vec<Change>,
    /// The fixes that are made, in their order; the lines are those before all rounds.
    pub made: Vec<Fix>,
    /// Those that were still offered at the end; the lines are those after the last round.
    pub refused: Vec<Refused>,
}

impl Revision {
    /// Gives what is refused the lines before all rounds, for those who write nothing.
    pub fn refuse_in_old_lines(&mut self, names: &SourceMap) {
        for Refused { fix, .. } in &mut self.refused {
            if let Some(change) = self.changes.iter().find(|change| names.display_name(&change.path) == fix.file) {
                fix.line = line_before(change, fix.line);
            }
        }
    }
}

/// The line of a fix before all these rounds: the texts of each, and what was made of them.
fn first_line(fix: &Fix, rounds: &[(Texts, Vec<Fix>)], names: &SourceMap) -> u32 {
    let Some(path) = fix.edits.iter().map(|edit| &edit.path).find(|path| names.display_name(path) == fix.file) else {
        return fix.line;
    };
    rounds.iter().rev().fold(fix.line, |line, (texts, made)| {
        let edits: BTreeSet<&Edit> = made.iter().flat_map(|fix| &fix.edits).filter(|edit| edit.path == *path).collect();
        texts.text(path, names).map_or(line, |text| line_before_edits(&text, edits.into_iter(), line))
    })
}

/// Makes the fixes that `offer` finds in a report, round by round, in memory.
///
/// `first` is the report of the texts on the disk, and `check` makes that of other ones. `may_write` says which file a path stands
/// for, or why it cannot be written.
#[must_use]
pub fn revise(
    first: &Report,
    offer: impl Fn(&Report) -> Vec<Fix>,
    may_write: impl Fn(&Path) -> Result<PathBuf, String>,
    check: impl Fn(Box<dyn ReadSource>) -> Report,
) -> Revision {
    let mut texts = Texts::default();
    let mut latest: Option<Report> = None;
    let mut made: Vec<Fix> = Vec::new();
    let mut rounds: Vec<(Texts, Vec<Fix>)> = Vec::new();
    let mut refused = Vec::new();
    for _ in 0..MOST_ROUNDS {
        refused.clear();
        let report = latest.as_ref().unwrap_or(first);
        let mut chosen: Vec<Fix> = Vec::new();
        for mut fix in offer(report) {
            if let Err(why) = find_files(&mut fix, &may_write) {
                refused.push(Refused { fix, why, is_unwritable: true });
            } else if fix.edits.is_empty() || fix.is_against_itself() {
                refused.push(Refused { fix, why: "its own changes overlap".to_owned(), is_unwritable: false });
            } else if !chosen.iter().any(|other| other.is_against(&fix) || other.edits == fix.edits) {
                // What overlaps waits for the next round; two packages that share a file find the same in it.
                chosen.push(fix);
            }
        }
        let mut round = Round {
            texts: &texts,
            before: report,
            check: &check,
            offer: &offer,
            made: Vec::new(),
            after: None,
            refused: Vec::new(),
        };
        round.make(&chosen);
        let Round { made: of_round, after, refused: of_check, .. } = round;
        refused.extend(of_check);
        let Some((new_texts, report)) = after else { break };
        let in_old_lines =
            of_round.iter().map(|fix| Fix { line: first_line(fix, &rounds, &first.sources), ..fix.clone() });
        made.extend(in_old_lines);
        rounds.push((std::mem::replace(&mut texts, new_texts), of_round));
        latest = Some(report);
    }
    Revision { changes: texts.changes(), made, refused }
}

/// Gives the edits the real paths of their files.
fn find_files(fix: &mut Fix, may_write: &impl Fn(&Path) -> Result<PathBuf, String>) -> Result<(), String> {
    for edit in &mut fix.edits {
        edit.path = may_write(&edit.path)?;
    }
    Ok(())
}

/// One round: fixes that do not overlap, all from the same texts.
struct Round<'a, C, O> {
    texts: &'a Texts,
    before: &'a Report,
    check: &'a C,
    offer: &'a O,
    made: Vec<Fix>,
    after: Option<(Texts, Report)>,
    refused: Vec<Refused>,
}

impl<C: Fn(Box<dyn ReadSource>) -> Report, O: Fn(&Report) -> Vec<Fix>> Round<'_, C, O> {
    /// Makes these fixes together. Where that brings something new, those are refused that are alone in the file where it is found,
    /// and the others are made one half after the other, down to the fix that brings it.
    fn make(&mut self, fixes: &[Fix]) {
        if fixes.is_empty() {
            return;
        }
        let together = [&self.made, fixes].concat();
        let news = match self.texts.with(&together, &self.before.sources) {
            Err(words) => vec![News { file: String::new(), rule: None, words }],
            Ok(texts) => {
                let report = (self.check)(texts.source());
                let news = self.lasting(news(self.before, &report), &report);
                if news.is_empty() {
                    self.made = together;
                    self.after = Some((texts, report));
                    return;
                }
                news
            }
        };
        if let [fix] = fixes {
            return self.refuse(fix, &news[0].words);
        }
        let mut left: Vec<Fix> = Vec::new();
        for fix in fixes {
            let is_alone = fixes.iter().filter(|other| other.file == fix.file).count() == 1;
            match news.iter().find(|new| is_alone && new.file == fix.file) {
                Some(new) => self.refuse(fix, &new.words),
                None => left.push(fix.clone()),
            }
        }
        if left.len() < fixes.len() {
            return self.make(&left);
        }
        let (guilty, innocent): (Vec<Fix>, Vec<Fix>) =
            left.into_iter().partition(|fix| news.iter().any(|new| new.file == fix.file));
        let (first, second) = match (guilty.as_slice(), innocent.as_slice()) {
            (all, []) | ([], all) => all.split_at(all.len() / 2),
            (guilty, innocent) => (innocent, guilty),
        };
        self.make(first);
        self.make(second);
    }

    /// What is new and is not taken away in the next round: a suppression of what is put right hides nothing any more.
    fn lasting(&self, news: Vec<News>, after: &Report) -> Vec<News> {
        let is_hygiene = |new: &News| new.rule == Some(UNUSED_SUPPRESSION);
        if !news.iter().any(is_hygiene) {
            return news;
        }
        let next = (self.offer)(after);
        let goes = |new: &News| {
            is_hygiene(new) && next.iter().any(|fix| fix.rule == UNUSED_SUPPRESSION && fix.file == new.file)
        };
        news.into_iter().filter(|new| !goes(new)).collect()
    }

    fn refuse(&mut self, fix: &Fix, why: &str) {
        self.refused.push(Refused { fix: fix.clone(), why: why.to_owned(), is_unwritable: false });
    }
}
