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

    /// Their names.
    pub(super) fn names(&self) -> impl Iterator<Item = &'a str> {
        self.all.iter().map(|(name, _)| *name)
    }

    /// Whether code may call a method through one of them.
    pub(super) fn call(&self, method: &str, code: &str) -> bool {
        let mut left = self.all.clone();
        let mut open = vec![code];
        while let Some(code) = open.pop() {
            let is_used =
                |name: &str| words(code, name).any(|at| code[at + name.len()..].trim_start().starts_with('!'));
            let (used, others): (Vec<_>, Vec<_>) = left.into_iter().partition(|(name, _)| is_used(name));
            if used.iter().any(|(_, body)| has_word(body, method)) {
                return true;
            }
            open.extend(used.iter().map(|(_, body)| *body));
            left = others;
        }
        false
    }
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
}
