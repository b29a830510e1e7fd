//! The macros of the analysed code, as far as the calls in them need what is imported where they are used.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::rc::Rc;

use super::takers::Code;
use super::text::{has_word, words};
use crate::flow::Program;
use crate::source::FileId;

pub(super) struct Macros<'a> {
    /// Each with its name and its text.
    all: Vec<(&'a str, &'a str)>,
    /// The code of the files, as far as it was asked for.
    codes: RefCell<BTreeMap<FileId, Rc<Code>>>,
}

impl<'a> Macros<'a> {
    /// Those that are read.
    pub(super) fn of(program: &Program<'a>) -> Self {
        let defined = program.sources.files().flat_map(|(_, file)| {
            let text: &'a str = &file.text;
            words(text, "macro_rules").filter_map(|at| {
                let head = text[at..].strip_prefix("macro_rules")?.trim_start().strip_prefix('!')?.trim_start();
                let name = head.split(|sign: char| !(sign.is_alphanumeric() || sign == '_')).next()?;
                Some((name, block(&head[name.len()..])))
            })
        });
        Self::of_texts(defined.collect())
    }

    fn of_texts(all: Vec<(&'a str, &'a str)>) -> Self {
        Self { all, codes: RefCell::default() }
    }

    /// The code of a file, in which they may be called.
    pub(super) fn code(&self, program: &Program<'_>, file: FileId) -> Rc<Code> {
        let find = || Rc::new(Code::of(&program.sources.file(file).text));
        Rc::clone(self.codes.borrow_mut().entry(file).or_insert_with(find))
    }

    /// Their names, and whether an expression that each is given may be written in another way.
    pub(super) fn names(&self) -> impl Iterator<Item = (&'a str, bool)> + '_ {
        self.all.iter().map(|(name, body)| {
            let tells = |body: &str| TELLING.iter().any(|word| has_word(body, word)) || !takes_expressions(body);
            let same_name = self.all.iter().filter(|(other, _)| other == name);
            (
                *name,
                !tells(body) && !same_name.map(|(_, body)| *body).any(|body| tells(body) || self.any_in(body, tells)),
            )
        })
    }

    /// Whether code may call a method through one of them.
    pub(super) fn call(&self, method: &str, code: &str) -> bool {
        self.any_in(code, |body| has_word(body, method))
    }

    /// Whether one that code calls, or one that these call, is such.
    fn any_in(&self, code: &str, is_such: impl Fn(&str) -> bool) -> bool {
        let mut left = self.all.clone();
        let mut open = vec![code];
        while let Some(code) = open.pop() {
            let is_used =
                |name: &str| words(code, name).any(|at| code[at + name.len()..].trim_start().starts_with('!'));
            let (used, others): (Vec<_>, Vec<_>) = left.into_iter().partition(|(name, _)| is_used(name));
            if used.iter().any(|(_, body)| is_such(body)) {
                return true;
            }
            open.extend(used.iter().map(|(_, body)| *body));
            left = others;
        }
        false
    }
}

/// Macros of the standard library that show how what they are given is written.
const TELLING: [&str; 4] = ["stringify", "dbg", "assert", "debug_assert"];

/// Whether all that the patterns of a macro name is an expression, or stands alone between commas, so that another expression fits as
/// well.
fn takes_expressions(body: &str) -> bool {
    let is_word = |sign: char| sign.is_alphanumeric() || sign == '_';
    let word = |text: &str| text.find(|sign| !is_word(sign)).unwrap_or(text.len());
    body.match_indices('$').all(|(at, _)| {
        let name = &body[at + 1..];
        let Some(kind) = name[word(name)..].trim_start().strip_prefix(':').map(str::trim_start) else { return true };
        let (kind, rest) = kind.split_at(word(kind));
        let (before, rest) = (body[..at].trim_end(), rest.trim_start());
        let is_alone = match rest.strip_prefix(')') {
            // What separates repeated parts must not be a sign of an expression.
            Some(behind) if before.ends_with("$(") => behind.trim_start().starts_with(['*', '+', '?', ',', ';']),
            _ => rest.starts_with([',', ';', ')', ']', '}']),
        };
        matches!(kind, "expr" | "expr_2021" | "literal") || is_alone && before.ends_with(['(', '[', '{', ',', ';'])
    })
}

/// The brackets that a text begins with; all of it, where they are not closed as far as can be counted.
fn block(text: &str) -> &str {
    let mut depth = 0usize;
    let end = text.char_indices().find(|(_, sign)| {
        match sign {
            '{' | '(' | '[' => depth += 1,
            '}' | ')' | ']' => depth = depth.saturating_sub(1),
            _ => return false,
        }
        depth == 0
    });
    end.map_or(text, |(end, _)| &text[..end])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn macros_call_what_they_and_those_in_them_name() {
        let macros = Macros::of_texts(vec![
            ("step", "{ ($a:expr) => { $a.update() }; }"),
            ("twice", "{ ($a:expr) => { step!($a) } }"),
        ]);
        assert!(macros.call("update", "step!(kf)"));
        assert!(macros.call("update", "twice! { kf }"));
        assert!(!macros.call("update", "step(kf); other!(kf);"));
        assert!(!macros.call("reset", "step!(kf)"));
        assert_eq!(block("{ a(b) } c"), "{ a(b) ");
    }

    #[test]
    fn expressions_are_handed_on_by_what_neither_takes_them_apart_nor_shows_their_text() {
        let macros = Macros::of_texts(vec![
            ("log", "{ ($($arg:tt)*) => { println!($($arg)*) }; }"),
            ("at", "{ ($level:ident, $($arg : expr),+ $(,)?) => { if ON { log!($($arg),+) } }; }"),
            ("field", "{ ($owner:ident . $field:ident) => { $owner.$field }; }"),
            ("path", "{ ($($part:ident).+) => { $($part).+ }; }"),
            ("shown", "{ ($x:expr) => { log!(\"{} {}\", stringify!($x), $x) }; }"),
            ("outer", "{ ($x:expr) => { shown!($x) }; }"),
            ("twice", "{ ($x:expr) => { log!($x) }; }"),
            ("twice", "{ ($x:expr) => { dbg!($x) }; }"),
        ]);
        let handing_on: Vec<&str> = macros.names().filter(|(_, hands_on)| *hands_on).map(|(name, _)| name).collect();
        assert_eq!(handing_on, ["log", "at"]);
    }
}
