//! A `match` of which the last arm does nothing any more once the updates are gone: `if let` says the same, as clippy asks for.

use std::ops::Range;

use super::body::LoopBody;
use super::hollow::Cut;
use super::text::indentation;
use crate::source::Span;
use crate::syntax::tree::{Arm, ExprId, ExprKind};
use crate::syntax::{Lexer, TokenKind};

/// The edits that make `if let Some(z) = z { … }` of `match z { Some(z) => { … } None => {} }`; none where it stays as it is.
/// `does_nothing` says which arms do nothing.
pub(super) fn narrowed(of: &LoopBody<'_>, id: ExprId, does_nothing: &dyn Fn(ExprId) -> bool) -> Vec<Cut> {
    cuts(of, id, does_nothing).unwrap_or_default()
}

fn cuts(of: &LoopBody<'_>, id: ExprId, does_nothing: &dyn Fn(ExprId) -> bool) -> Option<Vec<Cut>> {
    let ExprKind::Match { scrutinee, arms } = of.kind(id) else { return None };
    let [Arm { cfg: None, pat, guard: None, body }, Arm { cfg: None, pat: other, guard: None, body: empty }] =
        arms.as_slice()
    else {
        return None;
    };
    // What is compared or chosen would have to stand in brackets behind `if let`.
    let is_simple = matches!(
        of.kind(*scrutinee),
        ExprKind::Path(_)
            | ExprKind::Field { .. }
            | ExprKind::Index { .. }
            | ExprKind::Call { .. }
            | ExprKind::MethodCall { .. }
            | ExprKind::Reference { .. }
            | ExprKind::Deref(_)
            | ExprKind::Tuple(_)
            | ExprKind::Await(_)
    );
    if !is_simple || does_nothing(*body) || !does_nothing(*empty) {
        return None;
    }
    let bytes = |span: Span| span.start as usize..span.end as usize;
    let whole = bytes(of.span(id));
    let [asked, block, last] = [*scrutinee, *body, *empty].map(|part| bytes(of.span(part)));
    let [first, rest] = [*pat, *other].map(|pat| bytes(of.body.pat(pat).span));
    let between = |start: usize, end: usize| of.text.get(start..end).map(str::trim);
    let is_written = between(whole.start, asked.start) == Some("match")
        && between(asked.end, first.start) == Some("{")
        && between(first.end, block.start) == Some("=>")
        && matches!(between(block.end, rest.start), Some("" | ","))
        && matches!(between(rest.start, rest.end), Some("_" | "None" | "Err(_)"))
        && between(rest.end, last.start) == Some("=>")
        && between(last.end, whole.end)
            .is_some_and(|end| matches!(end.split_whitespace().collect::<String>().as_str(), "}" | ",}"))
        && of.text.get(block.clone()).is_some_and(|block| block.starts_with('{'));
    if !is_written {
        return None;
    }
    let pattern = of.text.get(first.clone())?;
    let mut cuts = vec![
        Cut::text(whole.start..asked.start, &format!("if let {pattern} = ")),
        Cut::text(asked.end..block.start, " "),
        Cut::text(block.end..whole.end, ""),
    ];
    cuts.extend(moved_out(of.text, &block, indentation(of.text, first.start), indentation(of.text, whole.start))?);
    Some(cuts)
}

/// The edits that move the lines of a block from one indentation to a smaller one; none if that would change a text in it.
fn moved_out(text: &str, block: &Range<usize>, from: &str, to: &str) -> Option<Vec<Cut>> {
    let more = from.strip_prefix(to)?.len();
    let own = text.get(block.clone())?;
    let is_text = |kind| matches!(kind, TokenKind::Literal | TokenKind::BlockComment);
    if Lexer::new(own).any(|token| is_text(token.kind) && own[token.start..token.end].contains('\n')) {
        return None;
    }
    let lines = own.match_indices('\n').map(|(at, _)| block.start + at + 1);
    let lines = lines.filter(|at| !text[*at..].starts_with(['\n', '\r']));
    lines.map(|at| text[at..].starts_with(from).then(|| Cut::text(at..at + more, ""))).collect()
}
