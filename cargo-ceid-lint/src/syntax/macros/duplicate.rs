//! `#[duplicate_item(…)]` and `duplicate! { […] … }` of the crate `duplicate`: code that is there several times, each time with other
//! tokens in the place of some names. What stands in the place of a name has its place in the text.

use std::collections::BTreeMap;

use proc_macro2::{Delimiter, Group, Ident, Span, TokenStream, TokenTree};

/// What stands in the place of a name: `refs(T) [&mut T]`.
#[derive(Clone)]
struct Substitute {
    name: String,
    params: Vec<String>,
    tokens: TokenStream,
}

/// How many tokens all duplicates have at most.
const MAX_TOKENS: usize = 50_000;

/// What `duplicate! { [how] code }` stands for; `None` if that is not understood.
pub(super) fn duplicated(tokens: &TokenStream) -> Option<TokenStream> {
    let mut tokens = tokens.clone().into_iter();
    match tokens.next()? {
        TokenTree::Group(how) if how.delimiter() == Delimiter::Bracket => {
            duplicates(&how.stream(), &tokens.collect::<TokenStream>())
        }
        _ => None,
    }
}

/// What the code stands for that is to be duplicated like this; `None` if that is not understood.
pub(super) fn duplicates(how: &TokenStream, code: &TokenStream) -> Option<TokenStream> {
    let how: Vec<TokenTree> = nested(how)?.into_iter().collect();
    let (global, rest) = globals(&how)?;
    let groups = if rest.is_empty() { vec![Vec::new()] } else { verbose(rest).or_else(|| short(rest))? };
    let mut made = Vec::new();
    for (number, own) in groups.iter().enumerate() {
        let all: BTreeMap<&str, &Substitute> =
            global.iter().chain(own).map(|substitute| (substitute.name.as_str(), substitute)).collect();
        let suffix = (groups.len() > 1).then(|| suffix(&groups, number));
        made.extend(apart(substituted(code, &all)?, code, suffix.as_deref()));
        if made.len() > MAX_TOKENS {
            return None;
        }
    }
    Some(made.into_iter().collect())
}

/// The tokens with the calls among them that duplicate in turn.
fn nested(tokens: &TokenStream) -> Option<TokenStream> {
    let tokens: Vec<TokenTree> = tokens.clone().into_iter().collect();
    let mut found = Vec::new();
    let mut rest = tokens.as_slice();
    while let [first, behind @ ..] = rest {
        rest = behind;
        match (first, behind) {
            (TokenTree::Ident(name), [TokenTree::Punct(bang), TokenTree::Group(call), behind @ ..])
                if bang.as_char() == '!' && (name == "duplicate" || name == "substitute") =>
            {
                found.extend(duplicated(&call.stream())?);
                rest = behind;
            }
            _ => found.push(first.clone()),
        }
    }
    Some(found.into_iter().collect())
}

/// `name [tokens]; other(param) [tokens];` in front of the rest: what all duplicates have.
fn globals(mut tokens: &[TokenTree]) -> Option<(Vec<Substitute>, &[TokenTree])> {
    let mut found = Vec::new();
    while let Some((substitute, behind)) = substitute(tokens) {
        found.push(substitute);
        tokens = past_semicolon(behind);
    }
    Some((found, tokens))
}

/// `[name [tokens] other [tokens]] […]`
fn verbose(tokens: &[TokenTree]) -> Option<Vec<Vec<Substitute>>> {
    let mut groups = Vec::new();
    for token in tokens {
        let TokenTree::Group(group) = token else { return None };
        let inner: Vec<TokenTree> = group.stream().into_iter().collect();
        match globals(&inner)? {
            (own, []) if group.delimiter() == Delimiter::Bracket => groups.push(own),
            _ => return None,
        }
    }
    Some(groups)
}

/// `name other(param); [tokens] [tokens]; […] […]`
fn short(mut tokens: &[TokenTree]) -> Option<Vec<Vec<Substitute>>> {
    let mut heads = Vec::new();
    while let Some((name, params, behind)) = head(tokens) {
        heads.push((name, params));
        tokens = behind;
    }
    if heads.is_empty() || !is_punct(tokens.first(), ';') {
        return None;
    }
    let mut groups = Vec::new();
    tokens = past_semicolon(tokens);
    while !tokens.is_empty() {
        let mut own = Vec::new();
        for (name, params) in &heads {
            let (inner, behind) = bracketed(tokens)?;
            own.push(Substitute { name: name.clone(), params: params.clone(), tokens: inner });
            tokens = behind;
        }
        if !tokens.is_empty() && !is_punct(tokens.first(), ';') {
            return None;
        }
        groups.push(own);
        tokens = past_semicolon(tokens);
    }
    (!groups.is_empty()).then_some(groups)
}

/// `name [tokens]` or `name(param) [tokens]`, and what is behind it.
fn substitute(tokens: &[TokenTree]) -> Option<(Substitute, &[TokenTree])> {
    let (name, params, behind) = head(tokens)?;
    let (tokens, behind) = bracketed(behind)?;
    Some((Substitute { name, params, tokens }, behind))
}

/// `name` or `name(param)`, and what is behind it.
fn head(tokens: &[TokenTree]) -> Option<(String, Vec<String>, &[TokenTree])> {
    match tokens {
        [TokenTree::Ident(name), TokenTree::Group(params), behind @ ..]
            if params.delimiter() == Delimiter::Parenthesis =>
        {
            let params = params.stream().into_iter().filter_map(|token| match token {
                TokenTree::Ident(param) => Some(param.to_string()),
                _ => None,
            });
            Some((name.to_string(), params.collect(), behind))
        }
        [TokenTree::Ident(name), behind @ ..] => Some((name.to_string(), Vec::new(), behind)),
        _ => None,
    }
}

fn bracketed(tokens: &[TokenTree]) -> Option<(TokenStream, &[TokenTree])> {
    match tokens {
        [TokenTree::Group(group), behind @ ..] if group.delimiter() == Delimiter::Bracket => {
            Some((group.stream(), behind))
        }
        _ => None,
    }
}

fn is_punct(token: Option<&TokenTree>, char: char) -> bool {
    matches!(token, Some(TokenTree::Punct(punct)) if punct.as_char() == char)
}

fn past_semicolon(tokens: &[TokenTree]) -> &[TokenTree] {
    match tokens {
        [first, behind @ ..] if is_punct(Some(first), ';') => behind,
        _ => tokens,
    }
}

/// The code with what stands in the place of the names.
fn substituted(code: &TokenStream, all: &BTreeMap<&str, &Substitute>) -> Option<Vec<TokenTree>> {
    let code: Vec<TokenTree> = code.clone().into_iter().collect();
    let mut found = Vec::new();
    let mut rest = code.as_slice();
    while let [first, behind @ ..] = rest {
        rest = behind;
        match first {
            TokenTree::Ident(name) => match all.get(name.to_string().as_str()) {
                Some(own) if own.params.is_empty() => found.extend(at(&own.tokens, name.span())),
                Some(own) => {
                    let [TokenTree::Group(given), behind @ ..] = behind else { return None };
                    rest = behind;
                    let given = arguments(&substituted(&given.stream(), all)?, &own.params)?;
                    let given = given.iter().map(|own| (own.name.as_str(), own)).collect();
                    let tokens = substituted(&own.tokens, &given)?.into_iter().collect();
                    found.extend(at(&tokens, name.span()));
                }
                None => found.push(first.clone()),
            },
            TokenTree::Group(group) => {
                let mut inner = Group::new(group.delimiter(), substituted(&group.stream(), all)?.into_iter().collect());
                inner.set_span(group.span());
                found.push(TokenTree::Group(inner));
            }
            token => found.push(token.clone()),
        }
    }
    Some(found)
}

/// `([Self], [f32])`: what the parameters of a substitute stand for.
fn arguments(given: &[TokenTree], params: &[String]) -> Option<Vec<Substitute>> {
    let mut given = given.split(|token| is_punct(Some(token), ',')).filter(|argument| !argument.is_empty());
    let mut found = Vec::new();
    for name in params {
        let (tokens, []) = bracketed(given.next()?)? else { return None };
        found.push(Substitute { name: name.clone(), params: Vec::new(), tokens });
    }
    given.next().is_none().then_some(found)
}

/// The tokens, all in one place.
fn at(tokens: &TokenStream, place: Span) -> Vec<TokenTree> {
    let moved = tokens.clone().into_iter().map(|token| match token {
        TokenTree::Group(group) => {
            let mut inner = Group::new(group.delimiter(), at(&group.stream(), place).into_iter().collect());
            inner.set_span(place);
            TokenTree::Group(inner)
        }
        mut token => {
            token.set_span(place);
            token
        }
    });
    moved.collect()
}

/// What tells the modules of one duplicate from those of the others: the first name that stands for one name in each, as in
/// `filter_lag` and `filter_lead`, or its number.
fn suffix(groups: &[Vec<Substitute>], number: usize) -> String {
    let one_name = |own: &Substitute| {
        let mut tokens = own.tokens.clone().into_iter();
        match (tokens.next(), tokens.next()) {
            (Some(TokenTree::Ident(name)), None) => Some(name.to_string()),
            _ => None,
        }
    };
    let named_in = |group: &Vec<Substitute>, name: &str| group.iter().find(|own| own.name == name).and_then(one_name);
    let first = groups.first().into_iter().flatten().map(|own| own.name.as_str());
    let mut usable = first.filter(|name| groups.iter().all(|group| named_in(group, name).is_some()));
    let name = usable.next().and_then(|name| named_in(&groups[number], name));
    name.map_or_else(|| number.to_string(), |name| snake_case(&name))
}

fn snake_case(name: &str) -> String {
    let mut made = String::new();
    for char in name.chars() {
        if char.is_uppercase() && !made.is_empty() {
            made.push('_');
        }
        made.extend(char.to_lowercase());
    }
    made
}

/// Gives the modules of a duplicate names that the others do not have, unless the duplicates give them names themselves.
fn apart(mut tokens: Vec<TokenTree>, code: &TokenStream, suffix: Option<&str>) -> Vec<TokenTree> {
    let Some(suffix) = suffix else { return tokens };
    let own: Vec<String> = code.clone().into_iter().map(|token| token.to_string()).collect();
    for at in 1..tokens.len() {
        let is_mod = matches!(&tokens[at - 1], TokenTree::Ident(keyword) if keyword == "mod");
        if let TokenTree::Ident(name) = &tokens[at]
            && is_mod
            && own.contains(&name.to_string())
        {
            let made = Ident::new(&format!("{name}_{suffix}"), name.span());
            tokens[at] = TokenTree::Ident(made);
        }
    }
    tokens
}
