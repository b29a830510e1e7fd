//! Closure traits that stand for a type, as editions 2015 and 2018 write them (`Box<Fn(u8) -> u8>`), with the `dyn` without which
//! the parser of today takes their parentheses for something else. Never changes what the code means.

use proc_macro2::{Delimiter, Ident, TokenStream, TokenTree};

use super::edition::{Angles, is_punct, with_stream};

/// The tokens with a `dyn` before each closure trait that stands where a type has to.
pub(super) fn with_dyn(tokens: TokenStream) -> TokenStream {
    rewrite(tokens, false)
}

/// `is_type` tells whether a type begins with the first token.
fn rewrite(tokens: TokenStream, is_type: bool) -> TokenStream {
    let tokens: Vec<TokenTree> = tokens.into_iter().collect();
    let mut places = Vec::new();
    let mut inner = Vec::with_capacity(tokens.len());
    let mut around = Surroundings { is_type, ..Surroundings::default() };
    for (at, token) in tokens.iter().enumerate() {
        if is_closure_trait(token) && is_parenthesis(tokens.get(at + 1)) {
            let start = start_of_bound(&tokens, at);
            if around.expect_type(&tokens[..start]) {
                places.push(start);
            }
        }
        inner.push(match token {
            TokenTree::Group(group) => {
                let is_type = group.delimiter() == Delimiter::Parenthesis && around.expect_type(&tokens[..at]);
                with_stream(group, rewrite(group.stream(), is_type))
            }
            token => token.clone(),
        });
        around.pass(token);
    }
    let mut places = places.into_iter().peekable();
    let mut result = Vec::with_capacity(inner.len());
    for (at, token) in inner.into_iter().enumerate() {
        if places.next_if_eq(&at).is_some() {
            result.push(TokenTree::Ident(Ident::new("dyn", token.span())));
        }
        result.push(token);
    }
    result.into_iter().collect()
}

/// What is open at a token among its neighbours.
#[derive(Default)]
struct Surroundings {
    is_type: bool,
    angles: Angles,
    /// Whether it belongs to a `type …;`.
    in_alias: bool,
}

impl Surroundings {
    fn pass(&mut self, token: &TokenTree) {
        self.angles.pass(token);
        match token {
            TokenTree::Ident(ident) if ident == "type" => self.in_alias = true,
            TokenTree::Group(group) if group.delimiter() != Delimiter::Brace => {}
            TokenTree::Group(_) => *self = Self::default(),
            token if is_punct(token, ';') => *self = Self::default(),
            _ => {}
        }
        self.is_type = false;
    }

    /// Whether what comes after these tokens is a type, and neither a bound, which has no `dyn`, nor a call of something that is
    /// only named as the trait.
    fn expect_type(&self, before: &[TokenTree]) -> bool {
        let (last, rest) = match before {
            [] => return self.is_type,
            [rest @ .., last] => (last, rest),
        };
        match last {
            TokenTree::Punct(punct) => match punct.as_char() {
                '<' | '&' => true,
                ',' => self.angles.depth > 0,
                '=' => self.angles.depth > 0 || self.in_alias,
                _ => false,
            },
            TokenTree::Ident(ident) if ident == "for" => true,
            TokenTree::Ident(ident) if ident == "const" => ends_with(rest, '*'),
            TokenTree::Ident(ident) if ident == "mut" => match rest {
                [rest @ .., quote, TokenTree::Ident(_)] if is_punct(quote, '\'') => ends_with(rest, '&'),
                rest => ends_with(rest, '&') || ends_with(rest, '*'),
            },
            TokenTree::Ident(_) => {
                matches!(rest, [rest @ .., quote] if is_punct(quote, '\'') && ends_with(rest, '&'))
            }
            _ => false,
        }
    }
}

/// Where the bound begins whose trait is named at `end`: before the path, and before `for<'a>`.
fn start_of_bound(tokens: &[TokenTree], end: usize) -> usize {
    let mut start = end;
    while start >= 2 && is_punct(&tokens[start - 1], ':') && is_punct(&tokens[start - 2], ':') {
        start -= 2;
        match tokens[..start].last() {
            Some(TokenTree::Ident(ident)) if ["std", "core", "ops"].iter().any(|name| ident == name) => start -= 1,
            _ => break,
        }
    }
    if start > 0 && is_punct(&tokens[start - 1], '>') {
        let open = tokens[..start].iter().rposition(|token| is_punct(token, '<'));
        if let Some(open) = open
            && let Some(before) = open.checked_sub(1)
            && matches!(&tokens[before], TokenTree::Ident(ident) if ident == "for")
        {
            start = before;
        }
    }
    start
}

fn is_closure_trait(token: &TokenTree) -> bool {
    matches!(token, TokenTree::Ident(ident) if ["Fn", "FnMut", "FnOnce"].iter().any(|name| ident == name))
}

fn is_parenthesis(token: Option<&TokenTree>) -> bool {
    matches!(token, Some(TokenTree::Group(group)) if group.delimiter() == Delimiter::Parenthesis)
}

fn ends_with(tokens: &[TokenTree], sign: char) -> bool {
    tokens.last().is_some_and(|token| is_punct(token, sign))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[track_caller]
    fn check(text: &str, expected: &str) {
        let rewritten = with_dyn(text.parse().unwrap());
        assert_eq!(rewritten.to_string(), expected.parse::<TokenStream>().unwrap().to_string());
        syn::parse2::<syn::File>(rewritten).unwrap();
    }

    #[test]
    fn closure_traits_that_are_types_get_dyn() {
        check("type A = Fn(&u8) + Send;", "type A = dyn Fn(&u8) + Send;");
        check("struct A(Box<Fn(u8) -> u8>, B<u8, FnMut()>);", "struct A(Box<dyn Fn(u8) -> u8>, B<u8, dyn FnMut()>);");
        check("static A: &'static (Fn() + Sync) = &f;", "static A: &'static (dyn Fn() + Sync) = &f;");
        check(
            "fn f(a: &Fn(), b: &'a mut ::std::ops::FnMut(), c: *const Fn(), d: Box<for<'b> Fn(&'b u8)>) {}",
            "fn f(a: &dyn Fn(), b: &'a mut dyn ::std::ops::FnMut(), c: *const dyn Fn(), d: Box<dyn for<'b> Fn(&'b u8)>) {}",
        );
        check("impl A for Fn(u8) {} fn f() { x as Rc<Fn()> }", "impl A for dyn Fn(u8) {} fn f() { x as Rc<dyn Fn()> }");
        check("fn f<F: Fn() -> Box<Fn()>>(f: F) {}", "fn f<F: Fn() -> Box<dyn Fn()>>(f: F) {}");
    }

    #[test]
    fn bounds_variants_and_what_has_dyn_stay_as_they_are() {
        for text in [
            "fn f<F: Fn(u8), G>(f: F) -> impl Fn(u8) + Send where G: for<'a> FnMut(&'a u8) + Fn() {}",
            "enum Item { Fn(Box<dyn Fn()>), FnOnce(u8) }",
            "fn f(item: Item) -> Item { match item { Item::Fn(x) => g(&Item::Fn(x), Fn(x)), Fn(x) | FnMut(x) => { let a = Fn(x); a } } }",
            "type A = Box<dyn Fn()>; fn f(a: &'a dyn Fn(u8), b: &mut (dyn FnMut() + 'a)) {}",
        ] {
            check(text, text);
        }
    }
}
