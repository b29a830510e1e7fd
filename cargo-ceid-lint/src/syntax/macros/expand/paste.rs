//! `paste! { fn [<set_ $name>]() { … } }`: names that are put together, and all else as it stands.

use proc_macro2::{Delimiter, Group, Ident, TokenStream, TokenTree};

use super::hygiene::spelled;

/// What the macro stands for; `None` if one of its names is not understood.
pub(super) fn pasted(tokens: &TokenStream) -> Option<TokenStream> {
    let mut found = Vec::new();
    let mut tokens = tokens.clone().into_iter().peekable();
    while let Some(token) = tokens.next() {
        match token {
            TokenTree::Punct(punct) if punct.as_char() == '#' => {
                // Documentation may be put together as well.
                let is_text = |next: &TokenTree| matches!(next, TokenTree::Group(group) if is_doc(group));
                if tokens.next_if(is_text).is_none() {
                    found.push(TokenTree::Punct(punct));
                }
            }
            TokenTree::Group(group) if is_name(&group) => found.push(TokenTree::Ident(name(&group)?)),
            TokenTree::Group(group) => {
                let mut inner = Group::new(group.delimiter(), pasted(&group.stream())?);
                inner.set_span(group.span());
                found.push(TokenTree::Group(inner));
            }
            token => found.push(token),
        }
    }
    Some(found.into_iter().collect())
}

fn is_doc(group: &Group) -> bool {
    group.stream().into_iter().next().is_some_and(|token| token.to_string() == "doc")
}

/// Whether brackets hold a name that is put together: `[<set_ $name>]`.
fn is_name(group: &Group) -> bool {
    let tokens: Vec<TokenTree> = group.stream().into_iter().collect();
    let is = |token: &TokenTree, char: char| matches!(token, TokenTree::Punct(punct) if punct.as_char() == char);
    group.delimiter() == Delimiter::Bracket
        && matches!(tokens.as_slice(), [first, _, .., last] if is(first, '<') && is(last, '>'))
}

fn name(group: &Group) -> Option<Ident> {
    let tokens: Vec<TokenTree> = group.stream().into_iter().collect();
    let inner = tokens.get(1..tokens.len() - 1)?;
    let mut parts = Vec::new();
    collect(inner, &mut parts)?;
    let place = inner.first().map_or(group.span(), TokenTree::span);
    syn::parse_str::<Ident>(&parts.concat()).ok().map(|ident| Ident::new(&ident.to_string(), place))
}

fn collect(tokens: &[TokenTree], parts: &mut Vec<String>) -> Option<()> {
    let mut tokens = tokens.iter();
    while let Some(token) = tokens.next() {
        match token {
            TokenTree::Ident(ident) => {
                let text = ident.to_string();
                parts.push(spelled(text.trim_start_matches("r#")).to_owned());
            }
            TokenTree::Literal(literal) => parts.push(literal.to_string().trim_matches('"').to_owned()),
            TokenTree::Group(group) if group.delimiter() == Delimiter::None => {
                collect(&group.stream().into_iter().collect::<Vec<_>>(), parts)?;
            }
            TokenTree::Punct(punct) if punct.as_char() == ':' => {
                let last = parts.last_mut()?;
                *last = in_case(last, &tokens.next()?.to_string())?;
            }
            _ => return None,
        }
    }
    Some(())
}

/// A part of a name as `:snake` and its kin make it.
fn in_case(text: &str, case: &str) -> Option<String> {
    let mut words: Vec<String> = Vec::new();
    for char in text.chars() {
        match words.last_mut() {
            Some(_) if char == '_' => words.push(String::new()),
            Some(word) if !char.is_uppercase() || word.is_empty() => word.push(char),
            _ => words.push(char.to_string()),
        }
    }
    let capital = |word: &String| word.get(..1).unwrap_or_default().to_uppercase() + word.get(1..).unwrap_or_default();
    match case {
        "snake" => Some(words.join("_").to_lowercase()),
        "camel" => Some(words.iter().map(capital).collect()),
        "upper" => Some(text.to_uppercase()),
        "lower" => Some(text.to_lowercase()),
        _ => None,
    }
}
