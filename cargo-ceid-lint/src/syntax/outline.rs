//! Which brackets a place in a text lies in, and what stands before each of them. Never parses.

use std::ops::Range;

use super::lex::{Lexer, TokenKind};

/// A pair of brackets with what belongs to them.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Enclosure {
    /// From the first word or sign behind the statement, item or bracket before, to the opening bracket.
    pub head: Range<usize>,
    /// From the opening bracket to behind the closing one.
    pub brackets: Range<usize>,
    /// Whether the brackets are those of a macro call or of `macro_rules!`.
    pub is_macro: bool,
}

/// All brackets of a text that have a partner.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Outline {
    /// In the order in which they end.
    enclosures: Vec<Enclosure>,
    /// The number of the brackets right around each.
    parents: Vec<Option<usize>>,
}

impl Outline {
    /// Finds the brackets of a text.
    #[must_use]
    pub fn of(text: &str) -> Self {
        let enclosures = enclosures(text);
        let mut parents = vec![None; enclosures.len()];
        let mut open: Vec<usize> = Vec::new();
        // From the last to the first, what is around comes before what is inside.
        for (at, own) in enclosures.iter().enumerate().rev() {
            while open.last().is_some_and(|other| enclosures[*other].brackets.start > own.brackets.start) {
                open.pop();
            }
            parents[at] = open.last().copied();
            open.push(at);
        }
        Self { enclosures, parents }
    }

    /// The brackets around the byte at `offset`, the innermost first.
    pub fn around(&self, offset: usize) -> impl Iterator<Item = &Enclosure> {
        let first = self.enclosures.partition_point(|own| own.brackets.end <= offset);
        let first = Some(first).filter(|first| *first < self.enclosures.len());
        let outwards = std::iter::successors(first, |at| self.parents[*at]).map(|at| &self.enclosures[at]);
        outwards.filter(move |own| own.brackets.start < offset)
    }
}

fn enclosures(text: &str) -> Vec<Enclosure> {
    let mut open: Vec<Enclosure> = Vec::new();
    let mut found = Vec::new();
    let mut starts = vec![None];
    let mut before: [&str; 3] = [""; 3];
    let mut is_attribute = Vec::new();
    for token in Lexer::new(text) {
        let word = &text[token.start..token.end];
        match token.kind {
            TokenKind::Space | TokenKind::LineComment | TokenKind::BlockComment => continue,
            TokenKind::Open => {
                let is_call = before[2] == "!" && is_name(before[1]);
                let is_macro = is_call || before[1] == "!" && before[0] == "macro_rules";
                let head = starts.last().copied().flatten().unwrap_or(token.start)..token.start;
                is_attribute.push(word == "[" && (before[2] == "#" || before[1..] == ["#", "!"]));
                open.push(Enclosure { head, brackets: token.start..text.len(), is_macro });
                starts.push(None);
            }
            TokenKind::Close => {
                starts.truncate(starts.len().max(2) - 1);
                let ends_attribute = is_attribute.pop().unwrap_or_default();
                if let Some(mut enclosure) = open.pop() {
                    enclosure.brackets.end = token.end;
                    found.push(enclosure);
                }
                if (word == "}" || ends_attribute)
                    && let Some(start) = starts.last_mut()
                {
                    *start = None;
                }
            }
            _ => {
                let start = starts.last_mut().expect("the outermost one stays");
                match word {
                    ";" => *start = None,
                    "#" => {}
                    _ => *start = start.or(Some(token.start)),
                }
            }
        }
        before = [before[1], before[2], word];
    }
    found
}

/// Whether a macro may be called so.
fn is_name(word: &str) -> bool {
    word.starts_with(|first: char| first.is_alphabetic() || first == '_')
        && !matches!(word, "if" | "while" | "match" | "return" | "in" | "break" | "else" | "move")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[track_caller]
    fn check(text: &str, expected: &[(&str, bool)]) {
        let offset = text.find('$').expect("the place is marked");
        let outline = Outline::of(text);
        let found: Vec<(&str, bool)> = outline
            .around(offset)
            .map(|enclosure| (text[enclosure.head.clone()].trim_end(), enclosure.is_macro))
            .collect();
        assert_eq!(found, expected);
    }

    #[test]
    fn heads_begin_behind_what_stands_before() {
        check(
            "struct A; #[cfg(x)] impl<T> B for A<T> /* { */ { fn f() { \"{\"; loop { $ } } }",
            &[("loop", false), ("fn f()", false), ("impl<T> B for A<T> /* { */", false)],
        );
        check(
            "use a::{b, c};\n#![x]\n// d\npub mod e { fn f(x: [u8; 3]) { $ } }",
            &[("fn f(x: [u8; 3])", false), ("pub mod e", false)],
        );
    }

    #[test]
    fn macros_are_told_apart() {
        check("macro_rules! m { () => { $ } }", &[("=>", false), ("macro_rules! m", true)]);
        check("fn f() { m!(a, $) }", &[("m!", true), ("fn f()", false)]);
        check("fn f() { m!(a); $ n!(b) }", &[("fn f()", false)]);
        check("fn f() { if a != (b $) { } }", &[("if a !=", false), ("fn f()", false)]);
        check("fn f() { if !(b $) { } }", &[("if !", false), ("fn f()", false)]);
    }

    #[test]
    fn brackets_without_a_partner_do_no_harm() {
        check("} ) fn f() { $ }", &[("fn f()", false)]);
        assert_eq!(enclosures("{ a"), []);
    }
}
