//! Notes closures and futures where they are made, and takes them off where they run: what is left is told to those who take it for
//! an update.

use rustc_hash::FxHashSet;

use super::closures::ClosureRef;
use super::{Builder, Frame};
use crate::flow::{Place, Unrun, UnrunKind};
use crate::syntax::tree::{ExprId, ExprKind, PatKind, StmtKind};

impl Builder<'_> {
    /// Notes what is made here and has not run yet.
    pub(super) fn note_unrun(&mut self, closure: ClosureRef, what: UnrunKind, places: Vec<Place>) {
        if self.at.is_none() || places.is_empty() {
            return;
        }
        self.note_run(closure);
        let span = self.frames[closure.frame].body.expr(closure.expr).span;
        let in_loop = self.loops.last().copied();
        self.graph.unrun.push(Unrun { span, in_loop, what, places, is_named_again: false, key: key(closure) });
    }

    /// Notes that something runs it.
    pub(super) fn note_run(&mut self, closure: ClosureRef) {
        let key = key(closure);
        self.graph.unrun.retain(|unrun| unrun.key != key);
    }

    /// Takes off what was read without being run as a whole.
    pub(super) fn settle_unrun(&mut self) {
        let graph = &mut self.graph;
        let nodes = &graph.nodes;
        graph.unrun.retain(|unrun| {
            let is_read = |span| unrun.span.contains(span) && span != unrun.span;
            unrun.what == UnrunKind::Future || !nodes.iter().any(|node| is_read(node.span))
        });
        let named: Vec<(usize, u32)> = self.graph.unrun.iter().map(|unrun| unrun.key).collect();
        let is_named: Vec<bool> =
            named.into_iter().map(|(frame, expr)| self.is_named_again(frame, ExprId(expr))).collect();
        for (unrun, is_named_again) in self.graph.unrun.iter_mut().zip(is_named) {
            unrun.is_named_again = is_named_again && unrun.what == UnrunKind::Closure;
        }
    }

    /// Whether a `let` puts what is made there into a variable that is named somewhere, but to drop it or to do nothing with it.
    fn is_named_again(&self, frame: usize, made: ExprId) -> bool {
        let Frame { body, typed, .. } = &self.frames[frame];
        let span = body.expr(made).span;
        let holders: Vec<_> = body
            .stmts()
            .filter_map(|stmt| match &stmt.kind {
                StmtKind::Let { pat, init: Some(init), .. } if body.expr(*init).span.contains(span) => {
                    typed.pat_local.get(pat).copied()
                }
                _ => None,
            })
            .collect();
        let dropped: FxHashSet<ExprId> = (body.exprs.iter())
            .flat_map(|expr| match &expr.kind {
                ExprKind::Call { callee, args } => match &body.expr(*callee).kind {
                    ExprKind::Path(path) if path.last() == "drop" => args.clone(),
                    _ => Vec::new(),
                },
                _ => Vec::new(),
            })
            .collect();
        // `let _ = step;` does nothing with it.
        let named_only: FxHashSet<ExprId> = (body.stmts())
            .filter_map(|stmt| match &stmt.kind {
                StmtKind::Let { pat, init, .. } if matches!(body.pat(*pat).kind, PatKind::Wild) => *init,
                _ => None,
            })
            .collect();
        let goes_on = |id: &ExprId| !dropped.contains(id) && !named_only.contains(id);
        typed.expr_local.iter().any(|(id, local)| holders.contains(local) && goes_on(id))
    }
}

fn key(closure: ClosureRef) -> (usize, u32) {
    (closure.frame, closure.expr.0)
}
