//! A loop with what is known of its code: which expressions lie in it, in which order they run, and which exclude each other.

use super::walk;
use crate::flow::Program;
use crate::index::{FunctionDef, FunctionId};
use crate::source::{FileId, Span};
use crate::syntax::tree::{Block, Body, ExprId, ExprKind, Stmt, StmtKind};
use crate::types::{LocalId, TypedBody};

/// A loop.
pub(super) struct LoopBody<'a> {
    pub(super) program: &'a Program<'a>,
    pub(super) function: FunctionId,
    pub(super) body: &'a Body,
    pub(super) typed: &'a TypedBody,
    /// The loop itself.
    pub(super) whole: ExprId,
    /// The block that is one iteration.
    pub(super) block: ExprId,
    /// All expressions of one iteration.
    pub(super) inside: Vec<ExprId>,
    /// The text of the file.
    pub(super) text: &'a str,
    parents: Vec<Option<ExprId>>,
}

impl<'a> LoopBody<'a> {
    /// The loop whose keyword stands at `head`, if it is one.
    pub(super) fn find(program: &'a Program<'a>, head: Span) -> Option<Self> {
        let index = program.index;
        let has_it = |id: &FunctionId| {
            let body = index.function(*id).function.body.as_ref();
            body.is_some_and(|body| body.expr(body.root).span.contains(head) && loop_at(body, head).is_some())
        };
        let function = index.function_ids().find(has_it)?;
        let body = index.function(function).function.body.as_ref()?;
        let (whole, block) = loop_at(body, head)?;
        let typed = program.typed(function)?;
        let inside = walk::within(body, block);
        let parents = walk::parents(body);
        let text = &program.sources.file(head.file).text;
        Some(Self { program, function, body, typed, whole, block, inside, text, parents })
    }

    pub(super) fn def(&self) -> &'a FunctionDef {
        self.program.index.function(self.function)
    }

    pub(super) fn file(&self) -> FileId {
        self.span(self.whole).file
    }

    pub(super) fn span(&self, id: ExprId) -> Span {
        self.body.expr(id).span
    }

    pub(super) fn kind(&self, id: ExprId) -> &'a ExprKind {
        &self.body.expr(id).kind
    }

    /// What the source has at the place of an expression.
    pub(super) fn written(&self, id: ExprId) -> &'a str {
        self.program.sources.snippet(self.span(id))
    }

    pub(super) fn parent(&self, id: ExprId) -> Option<ExprId> {
        self.parents[id.0 as usize]
    }

    /// What an expression lies in, from the innermost outwards; inside the loop only for what lies there.
    pub(super) fn ancestors(&self, id: ExprId) -> impl Iterator<Item = ExprId> + '_ {
        std::iter::successors(self.parent(id), |id| self.parent(*id))
    }

    /// What an expression of the loop lies in, up to the block that is one iteration.
    pub(super) fn ancestors_inside(&self, id: ExprId) -> impl Iterator<Item = ExprId> + '_ {
        self.ancestors(id).take_while(|at| *at != self.whole)
    }

    /// The block in which an expression is a statement of its own, with that statement; without one if it stands at the end.
    pub(super) fn statement(&self, id: ExprId) -> Option<(&'a Block, Option<&'a Stmt>)> {
        let ExprKind::Block(block) = self.kind(self.parent(id)?) else { return None };
        let is_it = |stmt: &&Stmt| matches!(stmt.kind, StmtKind::Expr { expr, .. } if expr == id);
        let stmt = block.stmts.iter().find(is_it);
        (stmt.is_some() || block.tail == Some(id)).then_some((block, stmt))
    }

    /// Whether `later` may run behind `earlier` in the same iteration.
    pub(super) fn may_follow(&self, earlier: ExprId, later: ExprId) -> bool {
        self.span(later).start >= self.span(earlier).end && !self.is_exclusive(earlier, later)
    }

    /// Whether the two lie in different branches of one choice.
    fn is_exclusive(&self, one: ExprId, other: ExprId) -> bool {
        let path = |id: ExprId| {
            let mut path: Vec<ExprId> = std::iter::once(id).chain(self.ancestors(id)).collect();
            path.reverse();
            path
        };
        let (one, other) = (path(one), path(other));
        let common = one.iter().zip(&other).take_while(|(one, other)| one == other).count();
        let (Some(at), Some(left), Some(right)) = (one.get(common.wrapping_sub(1)), one.get(common), other.get(common))
        else {
            return false;
        };
        match self.kind(*at) {
            ExprKind::If { then, otherwise, .. } => {
                let is_branch = |id: &ExprId| id == then || Some(*id) == *otherwise;
                is_branch(left) && is_branch(right)
            }
            ExprKind::Match { arms, .. } => {
                let arm_of = |id: &ExprId| arms.iter().position(|arm| arm.body == *id);
                arm_of(left).is_some() && arm_of(right).is_some()
            }
            _ => false,
        }
    }

    /// The expressions of the loop that name a variable.
    pub(super) fn names(&self, local: LocalId) -> impl Iterator<Item = ExprId> + '_ {
        self.inside.iter().copied().filter(move |id| self.typed.expr_local.get(id) == Some(&local))
    }
}

fn loop_at(body: &Body, head: Span) -> Option<(ExprId, ExprId)> {
    (0u32..).zip(&body.exprs).find_map(|(number, expr)| match &expr.kind {
        ExprKind::Loop { keyword, body, .. }
        | ExprKind::While { keyword, body, .. }
        | ExprKind::For { keyword, body, .. }
            if *keyword == head =>
        {
            Some((ExprId(number), *body))
        }
        _ => None,
    })
}
