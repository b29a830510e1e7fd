//! `cfg` in three values. Never guesses: a name that a build script may set stays uncertain, under one spelling.

use proc_macro2::TokenStream;
use syn::ext::IdentExt as _;
use syn::parse::{ParseStream, Parser as _};

use super::text::tokens_text;
use super::tree::CfgKey;
use crate::project::CfgValues;

/// Whether something is there.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Presence {
    /// It is.
    Present,
    /// It is not.
    Absent,
    /// It depends on something that is not known.
    Maybe(Predicate),
}

impl Presence {
    /// There if both are.
    pub(super) fn and(self, other: Self) -> Self {
        match (self, other) {
            (Self::Absent, _) | (_, Self::Absent) => Self::Absent,
            (Self::Present, other) | (other, Self::Present) => other,
            (Self::Maybe(one), Self::Maybe(other)) => Self::Maybe(join(vec![one, other])),
        }
    }

    /// There if this is not.
    pub(super) fn not(self) -> Self {
        match self {
            Self::Present => Self::Absent,
            Self::Absent => Self::Present,
            Self::Maybe(predicate) => Self::Maybe(negate(predicate)),
        }
    }

    /// `None` if it is absent; else the key if it is uncertain. What only a debug build has is told apart from what a
    /// release build has, too: that one is judged.
    pub(super) fn key(self) -> Option<Option<CfgKey>> {
        match self.clone().in_build(false) {
            Self::Absent if self.in_build(true) == Self::Absent => None,
            Self::Absent => Some(Some(CfgKey { key: DEBUG_BUILD.to_owned(), negated: false })),
            Self::Present => Some(None),
            Self::Maybe(Predicate::Not(inner)) => Some(Some(CfgKey { key: inner.spelling(), negated: true })),
            Self::Maybe(predicate) => Some(Some(CfgKey { key: predicate.spelling(), negated: false })),
        }
    }

    /// Whether it is there in a build with or without `debug_assertions`.
    pub(super) fn in_build(self, is_debug: bool) -> Self {
        match self {
            Self::Maybe(predicate) => predicate.in_build(is_debug),
            certain => certain,
        }
    }
}

/// The flag that tells a debug build from a release build.
pub(super) const DEBUG_BUILD: &str = "debug_assertions";

/// A predicate without the parts that are certain.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Predicate {
    /// A flag, `key = "value"`, or what is not understood, as text.
    Leaf(String),
    /// `not`
    Not(Box<Predicate>),
    /// `all`, flattened and sorted by spelling; `any` is written with `not`.
    All(Vec<Predicate>),
}

impl Predicate {
    fn in_build(self, is_debug: bool) -> Presence {
        match self {
            Self::Leaf(name) if name == DEBUG_BUILD && is_debug => Presence::Present,
            Self::Leaf(name) if name == DEBUG_BUILD => Presence::Absent,
            Self::Leaf(_) => Presence::Maybe(self),
            Self::Not(inner) => inner.in_build(is_debug).not(),
            Self::All(parts) => all(parts.into_iter().map(|part| part.in_build(is_debug)).collect()),
        }
    }

    fn spelling(&self) -> String {
        match self {
            Self::Leaf(text) => text.clone(),
            Self::Not(inner) => format!("not({})", inner.spelling()),
            Self::All(parts) => {
                let parts: Vec<String> = parts.iter().map(Self::spelling).collect();
                format!("all({})", parts.join(", "))
            }
        }
    }
}

/// The value of what stands between the parentheses of `cfg(…)`.
pub(super) fn evaluate(tokens: &TokenStream, cfg: &CfgValues) -> Presence {
    (|input: ParseStream<'_>| {
        let value = predicate(input, cfg)?;
        let _: Option<syn::Token![,]> = input.parse()?;
        Ok(value)
    })
    .parse2(tokens.clone())
    .unwrap_or_else(|_| Presence::Maybe(Predicate::Leaf(tokens_text(tokens))))
}

/// Reads one predicate; what follows it is left, as `cfg_attr` needs it.
pub(super) fn predicate(input: ParseStream<'_>, cfg: &CfgValues) -> syn::Result<Presence> {
    if let Some(literal) = input.parse::<Option<syn::LitBool>>()? {
        return Ok(if literal.value { Presence::Present } else { Presence::Absent });
    }
    let name = input.call(syn::Ident::parse_any)?.unraw().to_string();
    if input.peek(syn::Token![=]) {
        input.parse::<syn::Token![=]>()?;
        let value: syn::LitStr = input.parse()?;
        return Ok(key_value(&name, &value.value(), cfg));
    }
    if !input.peek(syn::token::Paren) {
        return Ok(flag(&name, cfg));
    }
    let content;
    syn::parenthesized!(content in input);
    if !matches!(name.as_str(), "all" | "any" | "not") {
        let tokens: TokenStream = content.parse()?;
        return Ok(Presence::Maybe(Predicate::Leaf(format!("{name}({})", tokens_text(&tokens)))));
    }
    let mut parts = Vec::new();
    while !content.is_empty() {
        parts.push(predicate(&content, cfg)?);
        if content.is_empty() {
            break;
        }
        content.parse::<syn::Token![,]>()?;
    }
    Ok(match name.as_str() {
        "not" => all(parts).not(),
        "any" => all(parts.into_iter().map(Presence::not).collect()).not(),
        _ => all(parts),
    })
}

fn all(parts: Vec<Presence>) -> Presence {
    parts.into_iter().fold(Presence::Present, Presence::and)
}

fn flag(name: &str, cfg: &CfgValues) -> Presence {
    // Whatever the profile, what is shipped is judged, and what only a debug build does is kept apart.
    if name == DEBUG_BUILD {
        return Presence::Maybe(Predicate::Leaf(name.to_owned()));
    }
    if cfg.flags.contains(name) {
        Presence::Present
    } else if cfg.closed.contains(name) {
        Presence::Absent
    } else {
        Presence::Maybe(Predicate::Leaf(name.to_owned()))
    }
}

fn key_value(key: &str, value: &str, cfg: &CfgValues) -> Presence {
    if cfg.values.get(key).is_some_and(|values| values.contains(value)) {
        Presence::Present
    } else if cfg.closed.contains(key) {
        Presence::Absent
    } else {
        Presence::Maybe(Predicate::Leaf(format!("{key} = {value:?}")))
    }
}

fn negate(predicate: Predicate) -> Predicate {
    match predicate {
        Predicate::Not(inner) => *inner,
        other => Predicate::Not(Box::new(other)),
    }
}

fn join(parts: Vec<Predicate>) -> Predicate {
    let mut flat: Vec<Predicate> = Vec::new();
    for part in parts {
        match part {
            Predicate::All(parts) => flat.extend(parts),
            part => flat.push(part),
        }
    }
    flat.sort_by_cached_key(Predicate::spelling);
    flat.dedup();
    match flat.len() {
        1 => flat.remove(0),
        _ => Predicate::All(flat),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn values() -> CfgValues {
        CfgValues {
            flags: ["unix".to_owned()].into(),
            values: [("feature".to_owned(), ["std".to_owned()].into())].into(),
            closed: ["unix", "windows", "test", "feature"].map(str::to_owned).into(),
        }
    }

    /// `expected` is "yes", "no", or the key with `!` before it if it is negated.
    #[track_caller]
    fn check(predicate: &str, expected: &str) {
        let tokens: TokenStream = predicate.parse().unwrap();
        let actual = match evaluate(&tokens, &values()).key() {
            None => "no".to_owned(),
            Some(None) => "yes".to_owned(),
            Some(Some(key)) => format!("{}{}", if key.negated { "!" } else { "" }, key.key),
        };
        assert_eq!(actual, expected);
    }

    #[test]
    fn closed_names_are_certain() {
        check("unix", "yes");
        check("test", "no");
        check("not(windows)", "yes");
        check("feature = \"std\"", "yes");
        check("feature = \"sim\"", "no");
        check("true", "yes");
        check("not(true)", "no");
    }

    #[test]
    fn open_names_are_uncertain() {
        check("has_fpu", "has_fpu");
        check("not(has_fpu)", "!has_fpu");
        check("not(not(has_fpu))", "has_fpu");
        check("board = \"v2\"", "board = \"v2\"");
        check("version(\"1.80\")", "version(\"1.80\")");
    }

    #[test]
    fn a_release_build_is_judged() {
        check("debug_assertions", "debug_assertions");
        check("not(debug_assertions)", "yes");
        check("all(debug_assertions, has_fpu)", "debug_assertions");
        check("any(debug_assertions, has_fpu)", "has_fpu");
        check("all(debug_assertions, test)", "no");
        check("all(not(debug_assertions), has_fpu)", "has_fpu");
    }

    #[test]
    fn certain_parts_decide_or_vanish() {
        check("all(unix, a)", "a");
        check("all(test, a)", "no");
        check("any(unix, a)", "yes");
        check("any(test, a)", "a");
        check("all()", "yes");
        check("any()", "no");
    }

    #[test]
    fn one_predicate_has_one_spelling() {
        check("all(b, a, b)", "all(a, b)");
        check("all(b, all(a))", "all(a, b)");
        check("not(any(a, b))", "all(not(a), not(b))");
        check("any(b, a)", "!all(not(a), not(b))");
    }

    #[test]
    fn nonsense_is_uncertain() {
        check("a b", "a b");
        check("= 3", "=3");
    }
}
