//! Tokens as text, and the names among them. Never keeps a token.

use std::ops::Range;

use rustc_hash::FxHashSet;

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

/// The fields that the tokens name, each with what it is a field of: those of identifiers that never stand without a field. What is
/// called is no field, and what stands in front of it stands alone.
pub(super) fn fields(tokens: &TokenStream) -> Vec<Vec<String>> {
    let mut found = Fields::default();
    found.tokens(tokens);
    let Fields { mut paths, alone } = found;
    paths.retain(|path| !alone.contains(&path[0]));
    paths
}

#[derive(Default)]
struct Fields {
    paths: Vec<Vec<String>>,
    alone: FxHashSet<String>,
}

impl Fields {
    fn tokens(&mut self, tokens: &TokenStream) {
        let tokens: Vec<TokenTree> = tokens.clone().into_iter().collect();
        let is_dot = |at: usize| matches!(tokens.get(at), Some(TokenTree::Punct(punct)) if punct.as_char() == '.' && punct.spacing() == Spacing::Alone);
        let is_called = |at: usize| match tokens.get(at) {
            Some(TokenTree::Group(group)) => group.delimiter() == Delimiter::Parenthesis,
            Some(TokenTree::Punct(punct)) => matches!(punct.as_char(), ':' | '!'),
            _ => false,
        };
        let name = |at: usize| match tokens.get(at) {
            Some(TokenTree::Ident(ident)) => {
                let name = ident.to_string();
                Some(name.strip_prefix("r#").map_or(name.clone(), str::to_owned))
            }
            _ => None,
        };
        let mut at = 0;
        while at < tokens.len() {
            match &tokens[at] {
                TokenTree::Group(group) => self.tokens(&group.stream()),
                TokenTree::Literal(literal) => {
                    let text = literal.to_string();
                    self.alone.extend(captures(&text).into_iter().map(|name| text[name].to_owned()));
                }
                TokenTree::Ident(_) => {
                    let mut path = Vec::new();
                    while let Some(part) = name(at).filter(|_| path.is_empty() || !is_called(at + 1)) {
                        path.push(part);
                        at += 1;
                        if !is_dot(at) {
                            break;
                        }
                        at += 1;
                    }
                    if path.len() > 1 {
                        self.paths.push(path);
                    } else {
                        self.alone.extend(path);
                    }
                    continue;
                }
                TokenTree::Punct(_) => {}
            }
            at += 1;
        }
    }
}

#[derive(Default)]
struct Mentions {
    names: Vec<String>,
    seen: FxHashSet<String>,
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

    fn literal(&mut self, text: &str) {
        for name in captures(text) {
            self.name(&text[name]);
        }
    }
}

/// Where the names stand in `{name}`, `{name:?}`, `{:width$}` of a string, as it is written.
pub(super) fn captures(literal: &str) -> Vec<Range<usize>> {
    let mut found = Vec::new();
    let is_raw = literal.starts_with("r\"") || literal.starts_with("r#");
    if !is_raw && !literal.starts_with('"') {
        return found;
    }
    let is_of_word = |c: char| c.is_alphanumeric() || c == '_';
    let mut at = 0;
    while let Some(open) = literal[at..].find('{').map(|open| at + open) {
        at = open + 1;
        if literal[at..].starts_with('{') {
            at += 1;
            continue;
        }
        let Some(close) = literal[at..].find('}').map(|close| at + close) else { break };
        // `\u{41}` is a character.
        if is_raw || !literal[..open].ends_with("\\u") {
            let colon = literal[at..close].find(':').map_or(close, |colon| at + colon);
            let argument = literal[at..colon].trim();
            let start = at + (literal[at..colon].len() - literal[at..colon].trim_start().len());
            let widths = literal[colon..close].match_indices('$').map(|(dollar, _)| {
                let end = colon + dollar;
                literal[..end].trim_end_matches(is_of_word).len()..end
            });
            let is_name = |name: &Range<usize>| {
                let name = &literal[name.clone()];
                name.starts_with(|c: char| c.is_alphabetic() || c == '_') && name.chars().all(is_of_word)
            };
            found.extend(std::iter::once(start..start + argument.len()).chain(widths).filter(is_name));
        }
        at = close + 1;
    }
    found
}

/// Whether a word is one of the language.
pub(crate) fn is_keyword(word: &str) -> bool {
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
    fn fields_are_those_of_names_that_never_stand_alone() {
        let check = |tokens: &str, expected: &[&[&str]]| {
            assert_eq!(fields(&tokens.parse().unwrap()), expected, "{tokens}");
        };
        check("unsafe: self.count < self.buffer.len()", &[&["self", "count"], &["self", "buffer"]]);
        check("(self.tail.gain, a[self.at])", &[&["self", "tail", "gain"], &["self", "at"]]);
        check("self.count, self", &[]);
        check("self.count, self.reset()", &[]);
        check("self.count..kf.x", &[&["self", "count"], &["kf", "x"]]);
        check(r#"self.count, "{self}""#, &[]);
        check("self.update::<f32>(), self.0, *self", &[]);
    }

    #[test]
    fn lifetimes_are_not_names() {
        check("'outer: loop { break 'outer x }", &["x"]);
    }

    #[test]
    fn inline_format_arguments_are_names() {
        check(r#""{kf} {{no}} {x:?} {:w$.p$} {0} \u{ab}""#, &["kf", "x", "w", "p"]);
    }

    #[test]
    fn words_are_kept_apart_in_text() {
        assert_eq!(tokens_text(&"a as usize + { N :: M }".parse().unwrap()), "a as usize+{N::M}");
    }
}
