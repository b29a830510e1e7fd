//! Comments in text that is taken away or written anew: what no edit writes down again would be lost.

use super::Reason;
use super::body::LoopBody;
use crate::source::Span;
use crate::syntax::{Lexer, TokenKind};

/// The first comment that is in what the edits take away, and not in what they write.
pub(super) fn lost_comment(of: &LoopBody<'_>, edits: &[(Span, String)]) -> Option<Reason> {
    let mut written: Vec<&str> =
        edits.iter().flat_map(|(_, text)| comments(text)).map(|(_, comment)| comment).collect();
    let own = edits.iter().filter(|(span, _)| span.file == of.file());
    let mut gone = own.flat_map(|(span, _)| {
        let inside = comments(&of.text[span.start as usize..span.end as usize]);
        inside.map(|(at, comment)| (span.start + at, comment))
    });
    let (start, comment) = gone.find(|(_, comment)| {
        let kept = written.iter().position(|other| other == comment);
        kept.map(|at| written.swap_remove(at)).is_none()
    })?;
    let end = start + u32::try_from(comment.len()).unwrap_or_default();
    let text =
        "this comment stands in code that goes or is written anew, and would be lost: put it above the statement";
    Some(Reason { span: Span::new(of.file(), start, end), text: text.to_owned() })
}

/// The comments of a text, with where they begin.
fn comments(text: &str) -> impl Iterator<Item = (u32, &str)> {
    let may_have = text.contains("//") || text.contains("/*");
    let tokens = may_have.then(|| Lexer::new(text)).into_iter().flatten();
    tokens.filter(|token| matches!(token.kind, TokenKind::LineComment | TokenKind::BlockComment)).map(|token| {
        let comment = text[token.start..token.end].trim_end();
        (u32::try_from(token.start).unwrap_or_default(), comment)
    })
}
