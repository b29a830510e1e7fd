//! Code that what is shipped does not have: it stands behind a branch that is never taken, and its nodes are marked.

use super::Builder;
use crate::flow::{About, Effect, Node, NodeId};
use crate::source::Span;
use crate::syntax::CycleDirective;
use crate::syntax::tree::ExprId;

impl Builder<'_> {
    /// Operands that only a debug build or a log level runs: what is shipped does not have them.
    pub(super) fn debug_only(&mut self, id: ExprId, operands: &[ExprId], path: &str) {
        if self.at.is_none() || operands.is_empty() {
            return;
        }
        let span = self.span(id);
        let (runs, skipped) = self.debug_branch(span, format!("{path}!"));
        let after = self.add_node(Effect::Nothing, span);
        self.resume(runs);
        for operand in operands {
            self.expr(*operand);
        }
        self.jump(after);
        self.resume(skipped);
        self.jump(after);
        self.resume(after);
    }

    /// A branch whose first side is not there in what is shipped.
    pub(super) fn debug_branch(&mut self, span: Span, text: String) -> (NodeId, NodeId) {
        self.opaque_branch(span, text, About { is_constant: true, is_debug: true, ..About::default() })
    }

    /// Tells the nodes to which only the debug side of a branch leads.
    pub(super) fn mark_debug_only(&mut self) {
        self.take_out_unbuilt();
        let nodes = &mut self.graph.nodes;
        let is_debug = |node: &Node| matches!(&node.effect, Effect::Branch(test) if test.about.is_debug);
        let branches: Vec<NodeId> =
            (0u32..).map(NodeId).zip(nodes.iter()).filter(|(_, node)| is_debug(node)).map(|(id, _)| id).collect();
        if branches.is_empty() {
            return;
        }
        let mut shipped = vec![false; nodes.len()];
        let mut open = vec![NodeId(0)];
        while let Some(id) = open.pop() {
            if std::mem::replace(&mut shipped[id.0 as usize], true) {
                continue;
            }
            let node = &nodes[id.0 as usize];
            open.extend(node.next.iter().skip(usize::from(is_debug(node))).copied());
        }
        for branch in branches {
            let mut open = vec![nodes[branch.0 as usize].next[0]];
            while let Some(id) = open.pop() {
                let node = &mut nodes[id.0 as usize];
                if !shipped[id.0 as usize] && node.debug_only.is_none() {
                    node.debug_only = Some(branch);
                    open.extend(node.next.iter().copied());
                }
            }
        }
    }

    /// Takes the loops out that the build which is judged does not come to: they are no cycles.
    fn take_out_unbuilt(&mut self) {
        let nodes = &self.graph.nodes;
        let built = |node: &Node| match &node.effect {
            Effect::Branch(test) => test.about.built,
            _ => None,
        };
        if !nodes.iter().any(|node| built(node).is_some()) {
            return;
        }
        let mut reached = vec![false; nodes.len()];
        let mut open = vec![NodeId(0)];
        while let Some(id) = open.pop() {
            if std::mem::replace(&mut reached[id.0 as usize], true) {
                continue;
            }
            let node = &nodes[id.0 as usize];
            match built(node) {
                Some(answer) => open.extend(node.next.get(usize::from(!answer))),
                None => open.extend(&node.next),
            }
        }
        for info in self.graph.loops.iter_mut().filter(|info| !reached[info.head.0 as usize]) {
            info.directive = Some(CycleDirective::NotACycle);
        }
    }
}
