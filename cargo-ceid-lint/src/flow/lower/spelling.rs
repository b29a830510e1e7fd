//! Code as messages spell it.

use super::{Builder, patterns};
use crate::syntax::tree::{ExprId, ExprKind};

impl Builder<'_> {
    /// An expression as the source spells it.
    pub(super) fn text(&self, id: ExprId) -> String {
        let put_together = self.put_together(id);
        patterns::shorten(put_together.as_deref().unwrap_or_else(|| self.program.sources.snippet(self.span(id))))
    }

    /// An operation that a macro makes of its arguments: they stand apart in the source, and the operator is not between them. `$e < $lo`
    fn put_together(&self, id: ExprId) -> Option<String> {
        let ExprKind::Binary { op, lhs, rhs } = &self.body().expr(id).kind else { return None };
        let (whole, left, right) = (self.span(id), self.span(*lhs), self.span(*rhs));
        let between = |text: &str| text.contains(op);
        let is_written = left.end <= right.start
            && between(self.program.sources.snippet(crate::source::Span { start: left.end, end: right.start, ..left }));
        let side = |side: ExprId| match &self.body().expr(side).kind {
            kind if self.span(side) == whole => match kind {
                ExprKind::Literal(literal) => Some(literal.spelling()),
                _ => None,
            },
            _ => Some(self.text(side)),
        };
        if is_written { None } else { Some(format!("{} {op} {}", side(*lhs)?, side(*rhs)?)) }
    }

    /// Notes what macros write more than once, here and in the functions that are read here.
    pub(super) fn note_written_again(&mut self) {
        let index = self.program.index;
        let functions = [self.graph.function].into_iter().chain(self.graph.read_here.iter().copied());
        let bodies = functions.filter_map(|id| index.function(id).function.body.as_ref());
        self.graph.written_again = bodies.flat_map(|body| body.written_again.iter().cloned()).collect();
    }
}
