//! Matches the tokens of a call against a matcher. Never goes back into a fragment that was read.

use std::collections::BTreeMap;

use proc_macro2::{Delimiter, TokenStream, TokenTree};
use syn::Token;
use syn::parse::{ParseStream, Parser as _};

use super::rules::{Fragment, Node, Op, Repeat, is_punct, list, token_len};

/// What the variables of a matcher took.
pub(super) type Bindings = BTreeMap<String, Binding>;

/// What a variable took: once, or once in each round of a repetition.
#[derive(Debug)]
pub(super) enum Binding {
    One(Fragment, Vec<TokenTree>),
    Many(Vec<Binding>),
}

/// What the variables take if all tokens are matched.
pub(super) fn match_all(nodes: &[Node], tokens: &[TokenTree]) -> Option<Bindings> {
    let mut bindings = Bindings::new();
    match_nodes(nodes, tokens, &mut bindings)?.is_empty().then_some(bindings)
}

/// The tokens behind those that are matched.
fn match_nodes<'t>(nodes: &[Node], tokens: &'t [TokenTree], bindings: &mut Bindings) -> Option<&'t [TokenTree]> {
    let mut rest = tokens;
    for node in nodes {
        rest = match node {
            Node::Token(expected) => match_token(expected, rest)?,
            Node::Group(delimiter, inner) => {
                let (TokenTree::Group(group), behind) = rest.split_first()? else { return None };
                if group.delimiter() != *delimiter {
                    return None;
                }
                let tokens = list(&group.stream());
                if !match_nodes(inner, &tokens, bindings)?.is_empty() {
                    return None;
                }
                behind
            }
            Node::Fragment(name, fragment) => {
                let len = fragment_len(*fragment, rest)?;
                bindings.insert(name.clone(), Binding::One(*fragment, rest[..len].to_vec()));
                &rest[len..]
            }
            Node::Repeat(repeat) => match_repeat(repeat, rest, bindings)?,
            Node::Crate | Node::Variable(_) => return None,
        };
    }
    Some(rest)
}

fn match_token<'t>(expected: &[TokenTree], tokens: &'t [TokenTree]) -> Option<&'t [TokenTree]> {
    let len = token_len(tokens);
    let same = len == expected.len() && expected.iter().zip(tokens).all(|(left, right)| same_token(left, right));
    (len > 0 && same).then(|| &tokens[len..])
}

fn same_token(left: &TokenTree, right: &TokenTree) -> bool {
    match (left, right) {
        (TokenTree::Punct(left), TokenTree::Punct(right)) => left.as_char() == right.as_char(),
        (TokenTree::Ident(left), TokenTree::Ident(right)) => left == right,
        (TokenTree::Literal(left), TokenTree::Literal(right)) => left.to_string() == right.to_string(),
        _ => false,
    }
}

/// Takes as many rounds as there are. A separator that no round follows is left where it stands.
fn match_repeat<'t>(repeat: &Repeat, tokens: &'t [TokenTree], bindings: &mut Bindings) -> Option<&'t [TokenTree]> {
    let mut rounds: Vec<Bindings> = Vec::new();
    let mut rest = tokens;
    while repeat.op != Op::AtMostOne || rounds.is_empty() {
        let start = match (rounds.is_empty(), repeat.separator.as_slice()) {
            (true, _) | (_, []) => Some(rest),
            (false, separator) => match_token(separator, rest),
        };
        let mut round = Bindings::new();
        let Some(behind) = start.and_then(|start| match_nodes(&repeat.body, start, &mut round)) else { break };
        // A round that takes nothing would go on for ever.
        if behind.len() == rest.len() {
            break;
        }
        rounds.push(round);
        rest = behind;
    }
    if repeat.op == Op::AtLeastOne && rounds.is_empty() {
        return None;
    }
    let mut names = Vec::new();
    variables(&repeat.body, &mut names);
    for name in names {
        let all = rounds.iter_mut().filter_map(|round| round.remove(&name)).collect();
        bindings.insert(name, Binding::Many(all));
    }
    Some(rest)
}

fn variables(nodes: &[Node], names: &mut Vec<String>) {
    for node in nodes {
        match node {
            Node::Fragment(name, _) => names.push(name.clone()),
            Node::Group(_, inner) => variables(inner, names),
            Node::Repeat(repeat) => variables(&repeat.body, names),
            Node::Token(_) | Node::Variable(_) | Node::Crate => {}
        }
    }
}

/// How many tokens the fragment takes from the front.
fn fragment_len(fragment: Fragment, tokens: &[TokenTree]) -> Option<usize> {
    match (fragment, tokens) {
        (Fragment::Vis, []) => Some(0),
        (_, []) => None,
        (Fragment::Ident, [TokenTree::Ident(word), ..]) => (word != "_").then_some(1),
        (Fragment::Tt, _) => Some(token_len(tokens)),
        (Fragment::Lifetime, [quote, TokenTree::Ident(_), ..]) => is_punct(quote, '\'').then_some(2),
        (Fragment::Literal, [TokenTree::Literal(_), ..]) => Some(1),
        (Fragment::Literal, [TokenTree::Ident(word), ..]) => (word == "true" || word == "false").then_some(1),
        (Fragment::Literal, [minus, TokenTree::Literal(_), ..]) => is_punct(minus, '-').then_some(2),
        (Fragment::Block, [TokenTree::Group(group), ..]) => (group.delimiter() == Delimiter::Brace).then_some(1),
        (Fragment::Ident | Fragment::Lifetime | Fragment::Literal | Fragment::Block, _) => None,
        (Fragment::Expr, _) => {
            let is_let = matches!(&tokens[0], TokenTree::Ident(word) if word == "let");
            if is_let { None } else { parsed_len(tokens, |input| input.parse::<syn::Expr>().map(drop)) }
        }
        (Fragment::Ty, _) => parsed_len(tokens, |input| input.parse::<syn::Type>().map(drop)),
        (Fragment::Path, _) => parsed_len(tokens, |input| input.parse::<syn::Path>().map(drop)),
        (Fragment::Pat, _) => parsed_len(tokens, |input| syn::Pat::parse_multi_with_leading_vert(input).map(drop)),
        (Fragment::PatParam, _) => parsed_len(tokens, |input| syn::Pat::parse_single(input).map(drop)),
        (Fragment::Stmt, _) => parsed_len(tokens, statement),
        (Fragment::Vis, _) => parsed_len(tokens, |input| input.parse::<syn::Visibility>().map(drop)),
        (Fragment::Meta, _) => parsed_len(tokens, |input| input.parse::<syn::Meta>().map(drop)),
        (Fragment::Item, _) => parsed_len(tokens, |input| input.parse::<syn::Item>().map(drop)),
    }
}

/// A statement without the semicolon that ends it.
fn statement(input: ParseStream<'_>) -> syn::Result<()> {
    if input.parse::<Option<Token![let]>>()?.is_some() {
        syn::Pat::parse_multi_with_leading_vert(input)?;
        if input.parse::<Option<Token![:]>>()?.is_some() {
            input.parse::<syn::Type>()?;
        }
        if input.parse::<Option<Token![=]>>()?.is_some() {
            input.parse::<syn::Expr>()?;
            if input.parse::<Option<Token![else]>>()?.is_some() {
                input.parse::<syn::Block>()?;
            }
        }
        return Ok(());
    }
    if input.fork().parse::<syn::Expr>().is_ok() {
        return input.parse::<syn::Expr>().map(drop);
    }
    input.parse::<syn::Item>().map(drop)
}

/// How many token trees a parser takes from the front.
fn parsed_len(tokens: &[TokenTree], parser: impl FnOnce(ParseStream<'_>) -> syn::Result<()>) -> Option<usize> {
    let stream: TokenStream = tokens.iter().cloned().collect();
    let rest = (|input: ParseStream<'_>| {
        parser(input)?;
        input.parse::<TokenStream>()
    })
    .parse2(stream)
    .ok()?;
    tokens.len().checked_sub(rest.into_iter().count())
}
