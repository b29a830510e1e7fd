//! Statements of a loop that are compiled under a condition, and so perhaps not read: whether they have anything to do with a guard.

use super::body::LoopBody;
use super::imports::to_u32;
use super::mentions::Guarded;
use super::text::{has_word, without_comments, words};
use crate::count::Pair;
use crate::index::Ty;
use crate::source::Span;
use crate::syntax::tree::{ExprId, ExprKind};
use crate::syntax::{Lexer, TokenKind};

/// Words after which a statement may do more than go on, or nobody can tell.
const WAYS_OUT: [&str; 6] = ["return", "break", "continue", "await", "unsafe", "macro_rules"];

/// Macros that go on behind what they print or ask.
const GOING_ON: [&str; 11] =
    ["print", "println", "eprint", "eprintln", "dbg", "trace", "debug", "info", "warn", "error", "cfg"];

/// Where something is compiled under a condition that may matter to the guard.
pub(super) fn unread(of: &LoopBody<'_>, pairs: &[&Pair], guarded: &[Guarded]) -> Option<Span> {
    let is_filter = |ty: &Ty| guarded.iter().any(|own| *ty.peel() == own.filter);
    let locals = of.typed.locals.iter().filter(|local| is_filter(&local.ty)).map(|local| local.name.as_str());
    let sites = guarded.iter().flat_map(|own| &own.sites).map(|site| of.written(site.receiver));
    let names = pairs.iter().map(|pair| pair.name.as_str()).chain(guarded.iter().map(|own| own.spelled.as_str()));
    let filters: Vec<&str> = names.chain(locals).chain(sites).collect();
    let start = of.span(of.block).start;
    let only_chooses = |at: usize| is_choice_apart(of, start + to_u32(at), &filters);
    let start = start + to_u32(mattering(of.written(of.block), &filters, &only_chooses)?);
    Some(Span::new(of.file(), start, start + to_u32("cfg".len())))
}

/// Whether the `cfg!` there does nothing but choose between branches which always go on and do not name these filters.
fn is_choice_apart(of: &LoopBody<'_>, at: u32, filters: &[&str]) -> bool {
    // Both of its values are an expression of the tree, so that only what depends on them can be otherwise in another build.
    let begins_there = of.inside.iter().copied().filter(|id| of.span(*id).start == at);
    let Some(flag) = begins_there.min_by_key(|id| of.span(*id).end) else { return false };
    let is_part = |id: &ExprId| matches!(of.kind(*id), ExprKind::Not(_) | ExprKind::Binary { .. });
    let around = of.ancestors_inside(flag).find(|id| !is_part(id));
    let Some(ExprKind::If { then, otherwise, .. }) = around.map(|id| of.kind(id)) else { return false };
    let is_apart = |branch: ExprId| {
        let text = without_comments(of.written(branch));
        goes_on(&text) && filters.iter().all(|own| !names(&text, own))
    };
    std::iter::once(*then).chain(*otherwise).all(is_apart)
}

/// Where the first condition stands under which more is compiled than statements of blocks which always go on and do not name these
/// filters, or which does more than choose.
fn mattering(code: &str, filters: &[&str], only_chooses: &dyn Fn(usize) -> bool) -> Option<usize> {
    let code = without_comments(code);
    let flags = code.match_indices("cfg!(").map(|(at, _)| at).filter(|at| !only_chooses(*at));
    if let Some(at) = code.find("cfg_attr(").into_iter().chain(flags).min() {
        return Some(at);
    }
    let is_apart = |at: usize| {
        // A field or variable may have that name.
        let Some(open) = code[..at].trim_end().strip_suffix('[').map(str::trim_end) else { return true };
        let Some(before) = open.strip_suffix('#').map(str::trim_end) else { return !open.ends_with('!') };
        before.ends_with(['{', '}', ';'])
            && statement(&code[at..]).is_some_and(|stmt| goes_on(stmt) && filters.iter().all(|own| !names(stmt, own)))
    };
    words(&code, "cfg").find(|at| !is_apart(*at))
}

/// The statement behind the attribute in which the text begins, if it is one.
fn statement(text: &str) -> Option<&str> {
    let mut depth = 1;
    let mut start = None;
    for token in Lexer::new(text) {
        let part = &text[token.start..token.end];
        match (token.kind, part) {
            (TokenKind::Open, _) => depth += 1,
            (TokenKind::Close, _) => depth -= 1,
            _ => {}
        }
        match start {
            None if depth == 0 => {
                start = Some(token.end);
                continue;
            }
            None => continue,
            // The block ends: a value stands at its end, or nothing.
            Some(_) if depth < 0 => return None,
            Some(_) if depth > 0 => continue,
            Some(_) => {}
        }
        let start = start?;
        let rest = text[token.end..].trim_start();
        let is_value = rest.starts_with(['.', '?', ';', '=']) || rest.starts_with("else") || rest.starts_with("as ");
        match (token.kind, part) {
            (TokenKind::Sign, ",") => return None,
            (TokenKind::Sign, "=") if rest.starts_with('>') => return None,
            (TokenKind::Sign, ";") => return Some(&text[start..token.end]),
            (TokenKind::Close, "}") if !is_value => return Some(&text[start..token.end]),
            _ => {}
        }
    }
    None
}

/// Whether what follows a statement always runs, as far as its words say.
fn goes_on(stmt: &str) -> bool {
    let goes_on = |at: usize| {
        let before = &stmt[..at];
        let start = before.rfind(|sign: char| !(sign.is_alphanumeric() || sign == '_')).map_or(0, |before| before + 1);
        GOING_ON.contains(&&before[start..]) || stmt[at + 1..].starts_with('=') || before[start..].is_empty()
    };
    !stmt.contains('?')
        && !WAYS_OUT.iter().any(|word| has_word(stmt, word))
        && stmt.match_indices('!').all(|(at, _)| goes_on(at))
}

/// Whether a statement may name a filter: `self.kf` by all of `self`, or by its first field.
fn names(stmt: &str, filter: &str) -> bool {
    let mut parts = filter.split(['.', '[', '(']);
    let (Some(root), field) = (parts.next(), parts.next()) else { return true };
    words(stmt, root).any(|at| {
        let behind = stmt[at + root.len()..].trim_start().strip_prefix('.').map(str::trim_start);
        let end = |text: &str| text.find(|sign: char| !(sign.is_alphanumeric() || sign == '_')).unwrap_or(text.len());
        match (behind, field) {
            (Some(behind), Some(field)) => {
                let end = end(behind);
                &behind[..end] == field || behind[end..].trim_start().starts_with(['(', ':'])
            }
            _ => true,
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[track_caller]
    fn check(code: &str, expected: bool) {
        assert_eq!(mattering(code, &["self.kf", "pf"], &|_| false).is_none(), expected, "{code}");
    }

    #[test]
    fn what_only_prints_is_apart() {
        check("{ kf(); }", true);
        check("{ a(); #[cfg(feature = \"trace\")] println!(\"{z}\"); b(); }", true);
        check("{ #[cfg(x)] { self.log.push(z); } b(); }", true);
        check("{ #[cfg(not(x))] if a != b { c(); } else { d(); } b() }", true);
        check("{ #[cfg(x)] let a = S { b: 1, c }; b() } // cfg!(x)", true);
    }

    #[test]
    fn what_may_do_more_is_not() {
        check("{ #[cfg(x)] println!(\"{}\", self.kf.y); b(); }", false);
        check("{ #[cfg(x)] println!(\"{pf:?}\"); b(); }", false);
        check("{ #[cfg(x)] self.log(); b(); }", false);
        check("{ #[cfg(x)] log(self); b(); }", false);
        check("{ #[cfg(x)] if a { return; } b(); }", false);
        check("{ #[cfg(x)] send(z)?; b(); }", false);
        check("{ #[cfg(x)] leave!(); b(); }", false);
        check("{ match a { #[cfg(x)] A => b(), _ => c() } }", false);
        check("{ a(S { #[cfg(x)] b: 1, c: 2 }); }", false);
        check("{ if cfg!(x) { a(); } }", false);
        check("{ a(); #[cfg(x)] { b() } }", true);
        check("{ a(); #[cfg(x)] b() }", false);
    }
}
