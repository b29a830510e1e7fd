//! The words of a directive. Prose that only mentions one is none; what is nearly one says what it should be.

use std::ops::Range;

use super::{CycleDirective, DirectiveKind, NearMiss, Suppression};
use crate::config::spelling::nearest;
use crate::source::Span;

/// What a text says, with places in it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Said {
    what: What,
    /// Where it ends in the text; another comment may follow.
    pub(super) end: usize,
}

#[derive(Clone, Debug, PartialEq, Eq)]
enum What {
    Cycle(CycleDirective),
    Suppression { is_expected: bool, arguments: Arguments },
    NearMiss { message: String, correction: Option<(Range<usize>, String)>, is_certain: bool },
}

#[derive(Clone, Debug, Default, PartialEq, Eq)]
struct Arguments {
    rules: Vec<(String, Range<usize>)>,
    reason: Option<String>,
}

impl Said {
    /// The same with places in a file.
    pub(super) fn kind(self, place: impl Fn(Range<usize>) -> Span) -> DirectiveKind {
        match self.what {
            What::Cycle(said) => DirectiveKind::Cycle(said),
            What::Suppression { is_expected, arguments: Arguments { rules, reason } } => {
                let rules = rules.into_iter().map(|(name, range)| (name, place(range))).collect();
                DirectiveKind::Suppression(Suppression { is_expected, rules, reason })
            }
            What::NearMiss { message, correction, is_certain } => {
                let correction = correction.map(|(range, text)| (place(range), text));
                DirectiveKind::NearMiss(NearMiss { message, correction, is_certain })
            }
        }
    }
}

/// What a line comment says, its `//` included. Documentation says nothing.
pub(super) fn line_comment(text: &str) -> Option<Said> {
    let body = text.get(2..)?;
    if body.starts_with(['/', '!']) { None } else { comment(&mut Cursor { text, at: 2 }) }
}

/// What a block comment says, its delimiters included: at most that it is the wrong kind of comment.
pub(super) fn block_comment(text: &str) -> Option<Said> {
    let body = text.strip_suffix("*/")?;
    if body.contains('\n') || body.get(2..)?.starts_with(['*', '!']) {
        return None;
    }
    match comment(&mut Cursor { text: body, at: 2 })?.what {
        What::NearMiss { .. } => None,
        What::Cycle(_) | What::Suppression { .. } => {
            let message = "a directive is a line comment: `// ceid: …`".to_owned();
            let what = What::NearMiss { message, correction: None, is_certain: false };
            Some(Said { what, end: text.len() })
        }
    }
}

/// What an attribute says behind `ceid::`.
pub(super) fn attribute(text: &str) -> Option<Said> {
    verb(&mut Cursor { text, at: 0 })
}

/// What an attribute says that is spelt as the compiler's own: `allow(ceid::rule)`, which is `ceid::allow(rule)`.
pub(super) fn compilers_attribute(text: &str) -> Option<Said> {
    let mut cursor = Cursor { text, at: 0 };
    let word = cursor.word();
    if !matches!(word, "allow" | "expect") || !cursor.rest().starts_with('(') {
        return None;
    }
    let Arguments { rules, reason } = arguments(&mut cursor).ok()?;
    let names: Vec<&str> = rules.iter().filter_map(|(name, _)| name.strip_prefix("ceid::")).collect();
    if names.is_empty() || !cursor.is_at_end() {
        return None;
    }
    let are_all = names.len() == rules.len();
    let reason = reason.map(|reason| format!(", reason = {reason:?}")).unwrap_or_default();
    let right = format!("ceid::{word}({}{reason})", names.join(", "));
    let message = format!("the prefix stands before `{word}`: `ceid::{word}(…)`");
    cursor.near_miss(message, are_all.then_some((0..text.len(), right)), true)
}

/// Whether a word can be what a directive begins with, or nearly.
pub(super) fn is_prefix(word: &[u8]) -> bool {
    word.eq_ignore_ascii_case(b"ceid") || word.eq_ignore_ascii_case(b"cied")
}

/// The words that other tools have for `allow`.
const SYNONYMS: &[&str] = &["ignore", "disable", "suppress", "skip", "silence", "noqa", "nolint"];

/// The words that go on a sentence about a directive; behind other words stands the reason of one.
const SPOKEN_OF: &[&str] = &[
    "above",
    "also",
    "and",
    "applies",
    "are",
    "as",
    "attribute",
    "attributes",
    "below",
    "can",
    "cannot",
    "comment",
    "comments",
    "could",
    "covers",
    "did",
    "directive",
    "directives",
    "disables",
    "does",
    "has",
    "here",
    "hides",
    "ignores",
    "in",
    "is",
    "lines",
    "makes",
    "marks",
    "may",
    "means",
    "must",
    "needs",
    "on",
    "only",
    "or",
    "says",
    "should",
    "silences",
    "stands",
    "stops",
    "suppresses",
    "suppression",
    "tells",
    "then",
    "turns",
    "was",
    "were",
    "will",
    "works",
    "would",
];

/// The words for other levels, which comments cannot set.
const LEVELS: &[&str] = &["warn", "deny", "forbid"];

struct Cursor<'a> {
    text: &'a str,
    at: usize,
}

impl<'a> Cursor<'a> {
    fn rest(&self) -> &'a str {
        &self.text[self.at..]
    }

    fn skip(&mut self, is_skipped: impl Fn(char) -> bool) -> &'a str {
        let rest = self.rest();
        let length = rest.find(|letter| !is_skipped(letter)).unwrap_or(rest.len());
        self.at += length;
        &rest[..length]
    }

    fn space(&mut self) {
        self.skip(char::is_whitespace);
    }

    fn word(&mut self) -> &'a str {
        self.skip(|letter| letter.is_alphanumeric() || matches!(letter, '_' | '-'))
    }

    fn eat(&mut self, letter: char) -> bool {
        let is_there = self.rest().starts_with(letter);
        self.at += if is_there { letter.len_utf8() } else { 0 };
        is_there
    }

    /// Whether nothing but another comment follows.
    fn is_at_end(&self) -> bool {
        let rest = self.rest().trim_start();
        rest.is_empty() || rest.starts_with("//")
    }

    /// What follows, up to another comment.
    fn tail(&self) -> &'a str {
        self.rest().split("//").next().unwrap_or("").trim_end()
    }

    fn said(&self, what: What) -> Option<Said> {
        Some(Said { what, end: self.at })
    }

    /// What is nearly a directive, with all that belongs to it.
    fn near_miss(
        &mut self,
        message: String,
        correction: Option<(Range<usize>, String)>,
        is_certain: bool,
    ) -> Option<Said> {
        // What would hide findings from then on is for a person to decide.
        let hides = |(range, right): &(Range<usize>, String)| {
            let corrected = [&self.text[..range.start], right, &self.text[range.end..]].concat();
            ["allow", "expect", "not-a-cycle"].iter().any(|word| corrected.contains(word))
        };
        let is_certain = is_certain && !correction.as_ref().is_some_and(hides);
        self.at += self.tail().len();
        self.said(What::NearMiss { message, correction, is_certain })
    }
}

fn comment(cursor: &mut Cursor<'_>) -> Option<Said> {
    cursor.space();
    let start = cursor.at;
    let head = cursor.word();
    if head == "ceid" && cursor.rest().starts_with(':') && !cursor.rest().starts_with("::") {
        cursor.at += 1;
        return verb(cursor);
    }
    let names = ["ceid", "cied", "ceid-lint", "ceid_lint", "cargo-ceid-lint"];
    let is_meant = names.iter().any(|name| head.eq_ignore_ascii_case(name));
    let between = cursor.skip(|letter| letter.is_whitespace() || letter == ':');
    if !is_meant || between.is_empty() {
        return None;
    }
    let prefix = start..cursor.at;
    let said = verb(cursor)?;
    let is_directive = match said.what {
        What::Suppression { arguments, .. } => !arguments.rules.is_empty(),
        What::Cycle(_) => between.contains(':'),
        What::NearMiss { .. } => false,
    };
    if !is_directive {
        return None;
    }
    let message = "a directive begins with `ceid:`".to_owned();
    cursor.near_miss(message, Some((prefix, "ceid: ".to_owned())), true)
}

fn verb(cursor: &mut Cursor<'_>) -> Option<Said> {
    cursor.space();
    let start = cursor.at;
    let word = cursor.word();
    match word {
        "allow" | "expect" => suppression(cursor, start, word),
        "cycle" if cursor.is_at_end() => cursor.said(What::Cycle(CycleDirective::Cycle)),
        "not-a-cycle" if cursor.is_at_end() => cursor.said(What::Cycle(CycleDirective::NotACycle)),
        "every" => every(cursor, start),
        _ if cursor.rest().starts_with('(') => unknown_call(cursor, start, word),
        _ => unknown_words(cursor, start),
    }
}

fn suppression(cursor: &mut Cursor<'_>, start: usize, word: &str) -> Option<Said> {
    let is_expected = word == "expect";
    if cursor.is_at_end() {
        return cursor.said(What::Suppression { is_expected, arguments: Arguments::default() });
    }
    let behind = cursor.at;
    cursor.space();
    let is_apart = cursor.at > behind;
    if !cursor.rest().starts_with('(') {
        cursor.at = behind;
        return listed_without_brackets(cursor, start, word);
    }
    let open = cursor.at;
    let message = match arguments(cursor) {
        Ok(arguments) if cursor.is_at_end() => {
            return cursor.said(What::Suppression { is_expected, arguments });
        }
        Ok(arguments) => {
            let tail = cursor.tail().trim_start();
            let first = tail.split(|letter: char| !letter.is_alphanumeric()).next().unwrap_or_default();
            let is_sentence = tail.starts_with(char::is_alphanumeric);
            if is_sentence && SPOKEN_OF.contains(&first.to_lowercase().as_str()) {
                return None;
            }
            let reason = tail.trim_start_matches(|letter: char| !letter.is_alphanumeric());
            let list = cursor.text[start..cursor.at - 1].trim_end_matches([' ', ',']);
            let right = format!("{list}, reason = \"{}\")", reason.replace('\\', "\\\\").replace('"', "\\\""));
            let whole = start..cursor.at + cursor.tail().len();
            let is_sure = arguments.reason.is_none() && !arguments.rules.is_empty() && !reason.is_empty();
            let message = "the reason stands in the brackets: `reason = \"…\"`".to_owned();
            return cursor.near_miss(message, is_sure.then_some((whole, right)), !is_sentence);
        }
        Err(message) => message,
    };
    let behind = cursor.text[open..].find(')').map_or("", |close| cursor.text[open + close + 1..].trim_start());
    if is_apart || behind.starts_with(char::is_alphanumeric) {
        return None;
    }
    cursor.near_miss(message, None, false)
}

/// `allow skipped_update`, `allow: skipped_update`
fn listed_without_brackets(cursor: &mut Cursor<'_>, start: usize, word: &str) -> Option<Said> {
    let tail = cursor.tail();
    let names: Vec<&str> =
        tail.split(|letter: char| " ,:=[]{}".contains(letter)).filter(|name| !name.is_empty()).collect();
    let is_rule =
        |name: &&str| name.contains('_') && name.chars().all(|letter| letter == '_' || letter.is_ascii_lowercase());
    if names.is_empty() || !names.iter().all(is_rule) {
        return None;
    }
    let right = format!("{word}({})", names.join(", "));
    let whole = start..cursor.at + tail.len();
    cursor.near_miss("the rules stand in brackets".to_owned(), Some((whole, right)), true)
}

/// `(rule, rule, reason = "…")`
fn arguments(cursor: &mut Cursor<'_>) -> Result<Arguments, String> {
    let mut found = Arguments::default();
    cursor.eat('(');
    loop {
        cursor.space();
        if cursor.eat(')') {
            return Ok(found);
        }
        let start = cursor.at;
        let name = cursor.skip(|letter| letter.is_alphanumeric() || matches!(letter, '_' | '-' | ':'));
        let range = start..cursor.at;
        cursor.space();
        match name {
            "" if cursor.rest().is_empty() => return Err("the bracket is not closed on its line".to_owned()),
            "" if cursor.rest().starts_with('"') => return Err("a reason is written `reason = \"…\"`".to_owned()),
            "" => return Err("expected the name of a rule".to_owned()),
            "reason" if cursor.eat('=') => {
                cursor.space();
                found.reason = Some(string(cursor)?);
            }
            _ if cursor.rest().starts_with('=') => return Err(format!("unknown key `{name}`: there is only `reason`")),
            _ => found.rules.push((name.to_owned(), range)),
        }
        cursor.space();
        if !cursor.eat(',') && !cursor.rest().starts_with(')') {
            return Err("expected `,` or `)`".to_owned());
        }
    }
}

/// A string in quotes, with its escapes resolved.
fn string(cursor: &mut Cursor<'_>) -> Result<String, String> {
    let unfinished = || "a reason stands in quotes: `reason = \"…\"`".to_owned();
    if !cursor.eat('"') {
        return Err(unfinished());
    }
    let mut text = String::new();
    let mut letters = cursor.rest().char_indices();
    while let Some((at, letter)) = letters.next() {
        match letter {
            '"' => {
                cursor.at += at + 1;
                return Ok(text);
            }
            '\\' => text.extend(letters.next().map(|(_, escaped)| escaped)),
            _ => text.push(letter),
        }
    }
    Err(unfinished())
}

fn every(cursor: &mut Cursor<'_>, start: usize) -> Option<Said> {
    let number = |text: &str| text.trim().replace('_', "").parse::<u64>().ok();
    let behind = cursor.at;
    if cursor.eat('(') {
        let inside = cursor.skip(|letter| letter != ')');
        let is_closed = cursor.eat(')');
        if !cursor.is_at_end() {
            return None;
        }
        return match number(inside) {
            Some(ratio) if is_closed => cursor.said(What::Cycle(CycleDirective::Every(ratio))),
            _ => cursor.near_miss("`every` takes a number of cycles: `every(10)`".to_owned(), None, false),
        };
    }
    cursor.skip(|letter| letter.is_whitespace() || matches!(letter, ':' | '='));
    let ratio = number(cursor.tail())?;
    let whole = start..cursor.at + cursor.tail().len();
    cursor.at = behind;
    cursor.near_miss(
        "the number of cycles stands in brackets".to_owned(),
        Some((whole, format!("every({ratio})"))),
        true,
    )
}

/// `alow(…)`
fn unknown_call(cursor: &mut Cursor<'_>, start: usize, word: &str) -> Option<Said> {
    let range = start..cursor.at;
    let near = nearest(word, ["allow", "expect"]);
    let message = format!("unknown directive `{word}`");
    let is_number = cursor.tail().trim_matches(['(', ')', ' ']).parse::<u64>().is_ok();
    let arguments = match arguments(cursor) {
        Ok(arguments) if cursor.is_at_end() => arguments,
        Err(_) if near.is_some() => return cursor.near_miss(message, None, false),
        _ => return None,
    };
    if is_number {
        let right = nearest(word, ["every"])?;
        return cursor.near_miss(message, Some((range, right.to_owned())), true);
    }
    if let Some(right) = near {
        return cursor.near_miss(message, Some((range, right.to_owned())), true);
    }
    if arguments.rules.is_empty() || !arguments.rules.iter().all(|(name, _)| name.contains('_')) {
        return None;
    }
    if LEVELS.contains(&word) {
        let message = format!("{message}: a level is set by a flag or under `[lints]` of `ceid-lint.toml`");
        return cursor.near_miss(message, None, false);
    }
    let right = SYNONYMS.contains(&word).then(|| (range, "allow".to_owned()))?;
    cursor.near_miss(message, Some(right), false)
}

/// `not a cycle`, `cylce`
fn unknown_words(cursor: &mut Cursor<'_>, start: usize) -> Option<Said> {
    cursor.at = start;
    let tail = cursor.tail();
    let plain = tail.trim_end_matches(['.', '!', ';', ',']).to_lowercase().replace([' ', '_'], "-");
    let known = ["cycle", "not-a-cycle"];
    let is_one_word = !tail.contains(char::is_whitespace);
    let message = format!("unknown directive `{tail}`");
    if let Some(right) = known.into_iter().find(|right| *right == plain) {
        return cursor.near_miss(message, Some((start..start + tail.len(), right.to_owned())), true);
    }
    match nearest(&plain, ["cycle", "not-a-cycle", "allow", "expect"]).filter(|_| is_one_word)? {
        right @ ("cycle" | "not-a-cycle") => {
            cursor.near_miss(message, Some((start..start + tail.len(), right.to_owned())), true)
        }
        right => {
            let message = format!("{message}; an `{right}` names its rules: `{right}(skipped_update, reason = \"…\")`");
            cursor.near_miss(message, None, false)
        }
    }
}
