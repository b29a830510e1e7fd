//! Notes closures and futures where they are made, and takes them off where they run: what is left is told to those who take it for
//! an update.

use super::Builder;
use super::closures::ClosureRef;
use crate::flow::{Place, Unrun, UnrunKind};

impl Builder<'_> {
    /// Notes what is made here and has not run yet.
    pub(super) fn note_unrun(&mut self, closure: ClosureRef, what: UnrunKind, places: Vec<Place>) {
        if self.at.is_none() || places.is_empty() {
            return;
        }
        self.note_run(closure);
        let span = self.frames[closure.frame].body.expr(closure.expr).span;
        let in_loop = self.loops.last().copied();
        self.graph.unrun.push(Unrun { span, in_loop, what, places, key: key(closure) });
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
    }
}

fn key(closure: ClosureRef) -> (usize, u32) {
    (closure.frame, closure.expr.0)
}
