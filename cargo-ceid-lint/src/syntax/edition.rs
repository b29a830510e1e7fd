//! Edition 2015 as tokens that the parser of today reads: names that have become keywords, and parameters without a name.
//! Never changes what the code means.

use proc_macro2::{Delimiter, Group, Ident, Punct, Spacing, TokenStream, TokenTree};

/// The tokens of a text of edition 2015.
pub(super) fn of_2015(tokens: TokenStream) -> TokenStream {
    let tokens: Vec<TokenTree> = tokens.into_iter().collect();
    let mut result = Vec::with_capacity(tokens.len());
    // Whether a `trait` was read whose braces are still to come.
    let mut in_trait_head = false;
    for (at, token) in tokens.iter().enumerate() {
        result.push(match token {
            TokenTree::Group(group) => {
                let mut inner = of_2015(group.stream());
                if group.delimiter() == Delimiter::Brace && std::mem::take(&mut in_trait_head) {
                    inner = with_named_parameters(inner);
                }
                with_stream(group, inner)
            }
            TokenTree::Ident(ident) => {
                in_trait_head |= ident == "trait";
                let is_name = ident == "async" || ident == "await" || ident == "try";
                if is_name || (ident == "dyn" && !begins_a_type(tokens.get(at + 1))) {
                    TokenTree::Ident(Ident::new_raw(&ident.to_string(), ident.span()))
                } else {
                    token.clone()
                }
            }
            TokenTree::Punct(punct) => {
                in_trait_head &= punct.as_char() != ';';
                token.clone()
            }
            TokenTree::Literal(_) => token.clone(),
        });
    }
    result.into_iter().collect()
}

/// Whether a `dyn` before this token is the keyword.
fn begins_a_type(next: Option<&TokenTree>) -> bool {
    match next {
        Some(TokenTree::Ident(ident)) => ident != "as" && ident != "in",
        Some(TokenTree::Punct(punct)) => matches!(punct.as_char(), '\'' | '?'),
        _ => false,
    }
}

/// The content of a trait, with `_: ` before each parameter that is only a type.
fn with_named_parameters(content: TokenStream) -> TokenStream {
    let mut is_signature = false;
    let mut angles = Angles::default();
    let named = content.into_iter().map(|token| {
        angles.pass(&token);
        match token {
            // Parentheses among the generics are those of a bound.
            TokenTree::Group(group)
                if group.delimiter() == Delimiter::Parenthesis && is_signature && angles.depth == 0 =>
            {
                is_signature = false;
                let inner = parameters(&group.stream().into_iter().collect::<Vec<_>>());
                with_stream(&group, inner)
            }
            token => {
                match &token {
                    TokenTree::Ident(ident) if ident == "fn" && !is_signature => {
                        is_signature = true;
                        angles = Angles::default();
                    }
                    TokenTree::Punct(punct) if punct.as_char() == ';' => is_signature = false,
                    _ => {}
                }
                token
            }
        }
    });
    named.collect()
}

/// How many `<` are open.
#[derive(Default)]
pub(super) struct Angles {
    pub(super) depth: usize,
    after_minus: bool,
}

impl Angles {
    pub(super) fn pass(&mut self, token: &TokenTree) {
        let sign = if let TokenTree::Punct(punct) = token { punct.as_char() } else { ' ' };
        match sign {
            '<' => self.depth += 1,
            '>' if !self.after_minus => self.depth = self.depth.saturating_sub(1),
            _ => {}
        }
        self.after_minus = sign == '-';
    }
}

fn parameters(tokens: &[TokenTree]) -> TokenStream {
    let mut result = Vec::new();
    let mut start = 0;
    let mut angles = Angles::default();
    for (at, token) in tokens.iter().enumerate() {
        angles.pass(token);
        if angles.depth == 0 && is_punct(token, ',') {
            parameter(&tokens[start..at], &mut result);
            result.push(token.clone());
            start = at + 1;
        }
    }
    parameter(&tokens[start..], &mut result);
    result.into_iter().collect()
}

fn parameter(tokens: &[TokenTree], result: &mut Vec<TokenTree>) {
    let mut before_is_colon = false;
    let has_name = tokens.iter().any(|token| {
        let is_single = is_punct(token, ':')
            && !before_is_colon
            && matches!(token, TokenTree::Punct(punct) if punct.spacing() == Spacing::Alone);
        before_is_colon = is_punct(token, ':');
        is_single
    });
    let is_self = tokens.iter().any(|token| matches!(token, TokenTree::Ident(ident) if ident == "self"));
    let is_attributed = tokens.first().is_some_and(|token| is_punct(token, '#'));
    let is_variadic = tokens.first().is_some_and(|token| is_punct(token, '.'));
    if let Some(first) = tokens.first()
        && !(has_name || is_self || is_attributed || is_variadic)
    {
        let mut colon = Punct::new(':', Spacing::Alone);
        colon.set_span(first.span());
        result.push(TokenTree::Ident(Ident::new("_", first.span())));
        result.push(TokenTree::Punct(colon));
    }
    result.extend_from_slice(tokens);
}

pub(super) fn is_punct(token: &TokenTree, sign: char) -> bool {
    matches!(token, TokenTree::Punct(punct) if punct.as_char() == sign)
}

pub(super) fn with_stream(group: &Group, inner: TokenStream) -> TokenTree {
    let mut own = Group::new(group.delimiter(), inner);
    own.set_span(group.span());
    TokenTree::Group(own)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[track_caller]
    fn check(text: &str, expected: &str) {
        let rewritten = of_2015(text.parse().unwrap());
        assert_eq!(rewritten.to_string(), expected.parse::<TokenStream>().unwrap().to_string());
        syn::parse2::<syn::File>(rewritten).unwrap();
    }

    #[test]
    fn later_keywords_are_names() {
        check("fn async(try: u8) -> u8 { try + await }", "fn r#async(r#try: u8) -> u8 { r#try + r#await }");
        check("fn dyn(x: &dyn T) { dyn::f(dyn, x as dyn) }", "fn r#dyn(x: &dyn T) { r#dyn::f(r#dyn, x as r#dyn) }");
    }

    #[test]
    fn parameters_of_trait_methods_get_a_name() {
        check(
            "trait T: A { fn f(&self, u8, &mut a::B<C, D>) -> E; }",
            "trait T: A { fn f(&self, _: u8, _: &mut a::B<C, D>) -> E; }",
        );
        check("trait T { fn g<F: Fn(u8) -> u8>(F, u8); }", "trait T { fn g<F: Fn(u8) -> u8>(_: F, _: u8); }");
        check("trait T { fn h(self: Self, x: B<C, u8>); }", "trait T { fn h(self: Self, x: B<C, u8>); }");
    }

    #[test]
    fn nothing_else_is_changed() {
        let text = "fn f(x: fn(u8)) { g(1, 2) } impl T for U { fn f(&self, x: u8) { h(x) } } trait V {}";
        check(text, text);
    }
}
