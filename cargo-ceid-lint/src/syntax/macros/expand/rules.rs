//! The rules of a `macro_rules!` macro as trees. Never matches anything.

use std::collections::BTreeSet;

use proc_macro2::{Delimiter, Spacing, TokenStream, TokenTree};

/// One arm: what it matches, and what it stands for.
#[derive(Debug)]
pub(super) struct Rule {
    pub(super) matcher: Vec<Node>,
    pub(super) transcriber: Vec<Node>,
}

/// A part of a matcher or transcriber.
#[derive(Debug)]
pub(super) enum Node {
    /// One token as rustc counts them: an operator of several characters is one.
    Token(Vec<TokenTree>),
    /// Brackets.
    Group(Delimiter, Vec<Node>),
    /// `$name:kind`, only in matchers.
    Fragment(String, Fragment),
    /// `$name`, only in transcribers.
    Variable(String),
    /// `$crate`
    Crate,
    /// `$( … ) separator op`
    Repeat(Repeat),
}

/// `$( … ) separator op`
#[derive(Debug)]
pub(super) struct Repeat {
    pub(super) body: Vec<Node>,
    pub(super) separator: Vec<TokenTree>,
    pub(super) op: Op,
}

/// How often.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Op {
    Any,
    AtLeastOne,
    AtMostOne,
}

/// What a variable takes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Fragment {
    Ident,
    Tt,
    Expr,
    Ty,
    Path,
    Pat,
    PatParam,
    Stmt,
    Block,
    Literal,
    Lifetime,
    Vis,
    Meta,
    Item,
}

impl Fragment {
    fn of(word: &str) -> Option<Self> {
        Some(match word {
            "ident" => Self::Ident,
            "tt" => Self::Tt,
            "expr" | "expr_2021" => Self::Expr,
            "ty" => Self::Ty,
            "path" => Self::Path,
            "pat" => Self::Pat,
            "pat_param" => Self::PatParam,
            "stmt" => Self::Stmt,
            "block" => Self::Block,
            "literal" => Self::Literal,
            "lifetime" => Self::Lifetime,
            "vis" => Self::Vis,
            "meta" => Self::Meta,
            "item" => Self::Item,
            _ => return None,
        })
    }
}

/// The rules between the outer delimiters; `None` if one of them is not understood.
pub(super) fn parse_rules(tokens: &TokenStream) -> Option<Vec<Rule>> {
    let tokens: Vec<TokenTree> = tokens.clone().into_iter().collect();
    let mut rest = tokens.as_slice();
    let mut rules = Vec::new();
    while !rest.is_empty() {
        let [TokenTree::Group(matcher), equals, greater, TokenTree::Group(transcriber), behind @ ..] = rest else {
            return None;
        };
        if !is_punct(equals, '=') || !is_punct(greater, '>') {
            return None;
        }
        let mut names = BTreeSet::new();
        rules.push(Rule {
            matcher: nodes(&list(&matcher.stream()), true, &mut names)?,
            transcriber: nodes(&list(&transcriber.stream()), false, &mut names)?,
        });
        rest = match behind {
            [semicolon, behind @ ..] if is_punct(semicolon, ';') => behind,
            [] => behind,
            _ => return None,
        };
    }
    Some(rules)
}

/// `names` are the variables of the matcher: in a transcriber, other names behind a `$` belong to a macro that it defines.
fn nodes(tokens: &[TokenTree], is_matcher: bool, names: &mut BTreeSet<String>) -> Option<Vec<Node>> {
    let mut nodes_of = Vec::new();
    let mut rest = tokens;
    while let Some(first) = rest.first() {
        if let TokenTree::Group(group) = first {
            let inner = nodes(&list(&group.stream()), is_matcher, names)?;
            nodes_of.push(Node::Group(group.delimiter(), inner));
            rest = &rest[1..];
            continue;
        }
        if !is_punct(first, '$') {
            let len = token_len(rest);
            nodes_of.push(Node::Token(rest[..len].to_vec()));
            rest = &rest[len..];
            continue;
        }
        let (node, behind) = dollar(&rest[1..], is_matcher, names)?;
        nodes_of.push(node);
        rest = behind;
    }
    Some(nodes_of)
}

/// What follows a `$`, and the tokens behind it.
fn dollar<'t>(
    tokens: &'t [TokenTree],
    is_matcher: bool,
    names: &mut BTreeSet<String>,
) -> Option<(Node, &'t [TokenTree])> {
    match tokens {
        [TokenTree::Group(group), behind @ ..] if group.delimiter() == Delimiter::Parenthesis => {
            let body = nodes(&list(&group.stream()), is_matcher, names)?;
            let (separator, op, behind) = repetition(behind)?;
            Some((Node::Repeat(Repeat { body, separator, op }), behind))
        }
        [TokenTree::Ident(word), behind @ ..] if word == "crate" => Some((Node::Crate, behind)),
        [TokenTree::Ident(name), colon, TokenTree::Ident(kind), behind @ ..] if is_matcher && is_punct(colon, ':') => {
            let name = plain(name);
            // A name that is bound twice is an error.
            if !names.insert(name.clone()) {
                return None;
            }
            Some((Node::Fragment(name, Fragment::of(&kind.to_string())?), behind))
        }
        [TokenTree::Ident(word), behind @ ..] if !is_matcher && names.contains(&plain(word)) => {
            Some((Node::Variable(plain(word)), behind))
        }
        [TokenTree::Ident(_), ..] if !is_matcher => {
            let dollar = TokenTree::Punct(proc_macro2::Punct::new('$', Spacing::Alone));
            Some((Node::Token(vec![dollar]), tokens))
        }
        _ => None,
    }
}

/// `separator op`
fn repetition(tokens: &[TokenTree]) -> Option<(Vec<TokenTree>, Op, &[TokenTree])> {
    if let Some((op, behind)) = tokens.split_first().and_then(|(first, behind)| Some((repeat_op(first)?, behind))) {
        return Some((Vec::new(), op, behind));
    }
    // The operator behind a separator may look as if it were a part of it.
    let glued = token_len(tokens);
    (1..=glued).rev().find_map(|len| {
        let op = repeat_op(tokens.get(len)?)?;
        let is_group = matches!(tokens.first(), Some(TokenTree::Group(_)));
        (!is_group).then(|| (tokens[..len].to_vec(), op, &tokens[len + 1..]))
    })
}

fn repeat_op(token: &TokenTree) -> Option<Op> {
    let TokenTree::Punct(punct) = token else { return None };
    match punct.as_char() {
        '*' => Some(Op::Any),
        '+' => Some(Op::AtLeastOne),
        '?' => Some(Op::AtMostOne),
        _ => None,
    }
}

/// How many token trees make the first token as rustc counts them: operators and lifetimes are one.
pub(super) fn token_len(tokens: &[TokenTree]) -> usize {
    const OPERATORS: &[&str] = &[
        "<<=", ">>=", "...", "..=", "::", "->", "<-", "=>", "==", "!=", "<=", ">=", "&&", "||", "+=", "-=", "*=", "/=",
        "%=", "^=", "&=", "|=", "<<", ">>", "..",
    ];
    let Some(TokenTree::Punct(first)) = tokens.first() else { return tokens.len().min(1) };
    if first.as_char() == '\'' {
        return if matches!(tokens.get(1), Some(TokenTree::Ident(_))) { 2 } else { 1 };
    }
    let mut text = String::new();
    for token in tokens.iter().take(3) {
        let TokenTree::Punct(punct) = token else { break };
        text.push(punct.as_char());
        if punct.spacing() == Spacing::Alone {
            break;
        }
    }
    OPERATORS.iter().find(|operator| text.starts_with(**operator)).map_or(1, |operator| operator.len())
}

pub(super) fn list(tokens: &TokenStream) -> Vec<TokenTree> {
    tokens.clone().into_iter().collect()
}

pub(super) fn is_punct(token: &TokenTree, expected: char) -> bool {
    matches!(token, TokenTree::Punct(punct) if punct.as_char() == expected)
}

fn plain(ident: &proc_macro2::Ident) -> String {
    ident.to_string().trim_start_matches("r#").to_owned()
}
