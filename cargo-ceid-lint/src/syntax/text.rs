//! Tokens as text, and the names among them. Never keeps a token.

use std::collections::HashSet;

use proc_macro2::{Delimiter, Spacing, TokenStream, TokenTree};

/// The tokens without spaces, but for one between two words.
pub(super) fn tokens_text(tokens: &TokenStream) -> String {
    let mut text = String::new();
    write_tokens(tokens, &mut text);
    text
}

fn write_tokens(tokens: &TokenStream, text: &mut String) {
    let mut after_word = false;
    for token in tokens.clone() {
        match token {
            TokenTree::Group(group) => {
                let (open, close) = match group.delimiter() {
                    Delimiter::Parenthesis => ("(", ")"),
                    Delimiter::Brace => ("{", "}"),
                    Delimiter::Bracket => ("[", "]"),
                    Delimiter::None => ("", ""),
                };
                text.push_str(open);
                write_tokens(&group.stream(), text);
                text.push_str(close);
                after_word = false;
            }
            TokenTree::Punct(punct) => {
                text.push(punct.as_char());
                after_word = false;
            }
            word @ (TokenTree::Ident(_) | TokenTree::Literal(_)) => {
                if after_word {
                    text.push(' ');
                }
                text.push_str(&word.to_string());
                after_word = true;
            }
        }
    }
}

/// Every identifier among the tokens and in `{name}` of their strings, once each, in order of first appearance.
/// Keywords are not identifiers, `self` excepted; neither are lifetimes.
pub(super) fn mentions(tokens: &TokenStream) -> Vec<String> {
    let mut found = Mentions::default();
    found.tokens(tokens);
    found.names
}

#[derive(Default)]
struct Mentions {
    names: Vec<String>,
    seen: HashSet<String>,
}

impl Mentions {
    fn tokens(&mut self, tokens: &TokenStream) {
        let mut after_quote = false;
        for token in tokens.clone() {
            let quote = matches!(&token, TokenTree::Punct(punct) if punct.as_char() == '\'' && punct.spacing() == Spacing::Joint);
            match token {
                TokenTree::Group(group) => self.tokens(&group.stream()),
                TokenTree::Ident(ident) if !after_quote => self.name(&ident.to_string()),
                TokenTree::Literal(literal) => self.literal(&literal.to_string()),
                TokenTree::Ident(_) | TokenTree::Punct(_) => {}
            }
            after_quote = quote;
        }
    }

    fn name(&mut self, name: &str) {
        let name = name.strip_prefix("r#").map_or_else(|| (!is_keyword(name)).then_some(name), Some);
        if let Some(name) = name
            && self.seen.insert(name.to_owned())
        {
            self.names.push(name.to_owned());
        }
    }

    /// The names in `{name}`, `{name:?}`, `{:width$}` of a string.
    fn literal(&mut self, text: &str) {
        let is_string = text.starts_with('"') || text.starts_with("r\"") || text.starts_with("r#");
        if !is_string || !text.contains('{') {
            return;
        }
        let mut rest = text;
        while let Some(open) = rest.find('{') {
            rest = &rest[open + 1..];
            if let Some(escaped) = rest.strip_prefix('{') {
                rest = escaped;
                continue;
            }
            let Some(close) = rest.find('}') else { return };
            let (argument, format) = rest[..close].split_once(':').unwrap_or((&rest[..close], ""));
            let widths = format.split('$').rev().skip(1).map(|part| {
                let start = part.rfind(|c: char| !c.is_alphanumeric() && c != '_').map_or(0, |at| at + 1);
                part.get(start..).unwrap_or("")
            });
            for name in std::iter::once(argument.trim()).chain(widths) {
                if name.starts_with(|c: char| c.is_alphabetic() || c == '_')
                    && name.chars().all(|c| c.is_alphanumeric() || c == '_')
                {
                    self.name(name);
                }
            }
            rest = &rest[close + 1..];
        }
    }
}

fn is_keyword(word: &str) -> bool {
    matches!(
        word,
        "as" | "async"
            | "await"
            | "become"
            | "box"
            | "break"
            | "const"
            | "continue"
            | "dyn"
            | "else"
            | "enum"
            | "extern"
            | "false"
            | "fn"
            | "for"
            | "if"
            | "impl"
            | "in"
            | "let"
            | "loop"
            | "macro"
            | "match"
            | "mod"
            | "move"
            | "mut"
            | "pub"
            | "ref"
            | "return"
            | "static"
            | "struct"
            | "trait"
            | "true"
            | "type"
            | "unsafe"
            | "use"
            | "where"
            | "while"
            | "yield"
            | "_"
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[track_caller]
    fn check(tokens: &str, expected: &[&str]) {
        assert_eq!(mentions(&tokens.parse().unwrap()), expected);
    }

    #[test]
    fn names_are_found_once_at_any_depth() {
        check("a (b [a { c }]) let mut self.r#type", &["a", "b", "c", "self", "type"]);
    }

    #[test]
    fn lifetimes_are_not_names() {
        check("'outer: loop { break 'outer x }", &["x"]);
    }

    #[test]
    fn inline_format_arguments_are_names() {
        check(r#""{kf} {{no}} {x:?} {:w$.p$} {0}""#, &["kf", "x", "p", "w"]);
    }

    #[test]
    fn words_are_kept_apart_in_text() {
        assert_eq!(tokens_text(&"a as usize + { N :: M }".parse().unwrap()), "a as usize+{N::M}");
    }
}
