//! The arms of `select!` as tokio, futures and crossbeam write them. Never says which arm runs.

use syn::parse::{Parse, ParseStream};
use syn::punctuated::Punctuated;
use syn::{Expr, ExprMethodCall, Ident, Pat, Token, parenthesized, token};

use super::parse;
use crate::syntax::lower::BodyLowerer;
use crate::syntax::tree::SelectArm;

/// `biased; pat = future, if condition => body, else => body`
struct Arms(Vec<Arm>);

struct Arm {
    pat: Option<Pat>,
    future: Option<Expr>,
    condition: Option<Expr>,
    body: Expr,
}

impl Parse for Arms {
    fn parse(input: ParseStream<'_>) -> syn::Result<Self> {
        if input.peek(Ident) && input.peek2(Token![;]) {
            input.parse::<Ident>()?;
            input.parse::<Token![;]>()?;
        }
        let mut arms = Vec::new();
        while !input.is_empty() {
            arms.push(input.parse()?);
        }
        Ok(Self(arms))
    }
}

impl Parse for Arm {
    fn parse(input: ParseStream<'_>) -> syn::Result<Self> {
        let is_default = input.peek(Ident) && input.peek2(Token![=>]);
        if input.parse::<Option<Token![else]>>()?.is_some() {
            return Self::rest(None, None, None, input);
        }
        if is_default {
            let word: Ident = input.parse()?;
            if word != "complete" && word != "default" {
                return Err(syn::Error::new(word.span(), "expected `complete` or `default`"));
            }
            return Self::rest(None, None, None, input);
        }
        if let Some(arm) = Self::of_channel(input)? {
            return Ok(arm);
        }
        let pat = Pat::parse_multi_with_leading_vert(input)?;
        input.parse::<Token![=]>()?;
        let future = input.parse()?;
        let mut condition = None;
        if input.parse::<Option<Token![,]>>()?.is_some() {
            input.parse::<Token![if]>()?;
            condition = Some(input.parse()?);
        }
        Self::rest(Some(pat), Some(future), condition, input)
    }
}

impl Arm {
    /// `recv(channel) -> received => body`, `send(channel, value) -> sent => body` or `default(timeout) => body`.
    fn of_channel(input: ParseStream<'_>) -> syn::Result<Option<Self>> {
        let ahead = input.fork();
        let word = ahead.parse::<Ident>().map(|word| word.to_string()).unwrap_or_default();
        if !matches!(word.as_str(), "recv" | "send" | "default") || !ahead.peek(token::Paren) {
            return Ok(None);
        }
        let operands;
        parenthesized!(operands in ahead);
        if !ahead.peek(Token![->]) && !ahead.peek(Token![=>]) {
            return Ok(None);
        }
        let method: Ident = input.parse()?;
        let content;
        let paren_token = parenthesized!(content in input);
        let mut args = Punctuated::<Expr, Token![,]>::parse_terminated(&content)?.into_iter();
        let Some(channel) = args.next() else { return Err(content.error("expected a channel or a timeout")) };
        if word == "default" {
            return Self::rest(None, Some(channel), None, input).map(Some);
        }
        input.parse::<Token![->]>()?;
        let pat = Pat::parse_multi_with_leading_vert(input)?;
        let call = ExprMethodCall {
            attrs: Vec::new(),
            receiver: Box::new(channel),
            dot_token: Token![.](method.span()),
            method,
            turbofish: None,
            paren_token,
            args: args.collect(),
        };
        Self::rest(Some(pat), Some(Expr::MethodCall(call)), None, input).map(Some)
    }

    fn rest(
        pat: Option<Pat>,
        future: Option<Expr>,
        condition: Option<Expr>,
        input: ParseStream<'_>,
    ) -> syn::Result<Self> {
        input.parse::<Token![=>]>()?;
        let body = Expr::parse_with_earlier_boundary_rule(input)?;
        input.parse::<Option<Token![,]>>()?;
        Ok(Self { pat, future, condition, body })
    }
}

impl BodyLowerer<'_, '_, '_> {
    pub(super) fn select_arms(&mut self, mac: &syn::Macro) -> Option<Vec<SelectArm>> {
        let arms = parse::<Arms>(mac)?;
        Some(arms.0.iter().map(|arm| self.select_arm(arm)).collect())
    }

    fn select_arm(&mut self, arm: &Arm) -> SelectArm {
        let condition = arm.condition.as_ref().map(|condition| self.expr(condition));
        let future = arm.future.as_ref().map(|future| self.expr(future));
        let pat = arm.pat.as_ref().map(|pat| self.pat(pat));
        SelectArm { pat, future, condition, body: self.expr(&arm.body) }
    }
}
