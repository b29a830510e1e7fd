//! A loop with what is known of its code: which expressions lie in it, in which order they run, and which exclude each other.

use super::exits::diverges;
use super::iteration::is_closure_of_a_loop;
use super::loops::{Loops, Parents};
use super::text::{Style, words};
use crate::flow::Program;
use crate::index::{FunctionDef, FunctionId};
use crate::source::{FileId, Span};
use crate::syntax::tree::{Block, Body, ExprId, ExprKind, PatId, PatKind, Stmt, StmtKind, TypeRef};
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
    /// The form of its lines.
    pub(super) style: Style,
    /// Whether the cycle is no loop, but a function that is called once per cycle.
    pub(super) is_function: bool,
    /// Whether the crate, or one that links it, catches panics.
    pub(super) are_panics_caught: bool,
    /// Whether the crate asks for a use of each result.
    pub(super) has_to_use_results: bool,
    parents: Parents,
}

impl<'a> LoopBody<'a> {
    /// The loop or function whose keyword stands at `head`, if it is one.
    pub(super) fn find(loops: &Loops<'a>, head: Span) -> Option<Self> {
        let program = loops.program;
        let (function, whole, block) = loops.at(head)?;
        let body = program.index.function(function).function.body.as_ref()?;
        let typed = program.typed(function)?;
        let inside: Vec<ExprId> = body.within(block).collect();
        let parents = loops.parents(function);
        let text = &program.sources.file(head.file).text;
        let span = body.expr(block).span;
        let style = loops.style(head.file).inside(text, span.start as usize..span.end as usize);
        let is_function = whole == block;
        let are_panics_caught = loops.are_panics_caught(function);
        let has_to_use_results = loops.has_to_use_results(head.file);
        Some(Self {
            program,
            function,
            body,
            typed,
            whole,
            block,
            inside,
            text,
            style,
            is_function,
            are_panics_caught,
            has_to_use_results,
            parents,
        })
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

    /// The whole statement that the loop is or lies in.
    pub(super) fn loop_statement(&self) -> ExprId {
        let is_outside = |at: &ExprId| !matches!(self.kind(*at), ExprKind::Block(_));
        self.ancestors(self.whole).take_while(is_outside).last().unwrap_or(self.whole)
    }

    /// The block in which an expression is a statement of its own, with that statement; without one if it stands at the end.
    pub(super) fn statement(&self, id: ExprId) -> Option<(&'a Block, Option<&'a Stmt>)> {
        let id = self.thrown_away(id).unwrap_or(id);
        let ExprKind::Block(block) = self.kind(self.parent(id)?) else { return None };
        let stmt = self.stmt_of(block, id);
        (stmt.is_some() || self.is_discarded(id)).then_some((block, stmt))
    }

    /// The assignment `_ = value` around a value.
    fn thrown_away(&self, value: ExprId) -> Option<ExprId> {
        let parent = self.parent(value)?;
        match self.kind(parent) {
            ExprKind::Assign { place, value: own } if *own == value && self.written(*place) == "_" => Some(parent),
            _ => None,
        }
    }

    /// Where the statement begins that throws the value of an expression away by name: `let _ = …`, `_ = …`.
    pub(super) fn discarded_at(&self, id: ExprId) -> Option<u32> {
        if let Some(assignment) = self.thrown_away(id) {
            return Some(self.span(assignment).start);
        }
        match self.statement(id)?.1? {
            Stmt { kind: StmtKind::Let { .. }, span, .. } => Some(span.start),
            _ => None,
        }
    }

    fn stmt_of(&self, block: &'a Block, id: ExprId) -> Option<&'a Stmt> {
        block.stmts.iter().find(|stmt| match &stmt.kind {
            StmtKind::Expr { expr, .. } => *expr == id,
            // What is thrown away is not used.
            StmtKind::Let { pat, init, otherwise: None, .. } => *init == Some(id) && self.is_unread(*pat),
            StmtKind::Let { .. } => false,
        })
    }

    /// Whether a pattern gives its value no name, or one that says so and that nothing uses.
    fn is_unread(&self, pat: PatId) -> bool {
        match &self.body.pat(pat).kind {
            PatKind::Wild => true,
            PatKind::Bind { name, by_ref: false, sub: None, .. } if name.starts_with('_') => {
                words(self.program.sources.snippet(self.span(self.body.root)), name).nth(1).is_none()
            }
            _ => false,
        }
    }

    /// Whether nothing uses the value of an expression.
    pub(super) fn is_discarded(&self, id: ExprId) -> bool {
        let Some(parent) = self.parent(id) else { return false };
        match self.kind(parent) {
            ExprKind::Block(block) if block.tail != Some(id) => self.stmt_of(block, id).is_some(),
            ExprKind::Block(_) if parent == self.block => {
                !self.is_function || self.def().function.output == TypeRef::unit()
            }
            ExprKind::Block(_) => self.is_discarded(parent),
            ExprKind::If { condition, .. } => *condition != id && self.is_discarded(parent),
            ExprKind::Match { scrutinee, .. } => *scrutinee != id && self.is_discarded(parent),
            ExprKind::Loop { body, .. } | ExprKind::While { body, .. } | ExprKind::For { body, .. } => *body == id,
            ExprKind::Closure(_) => is_closure_of_a_loop(self, id),
            _ => false,
        }
    }

    /// Whether a block ends with an expression, whose type is that of the block.
    pub(super) fn is_tail(&self, id: ExprId) -> bool {
        matches!(self.parent(id).map(|parent| self.kind(parent)), Some(ExprKind::Block(block)) if block.tail == Some(id))
    }

    /// Whether `later` may run behind `earlier` in the same iteration.
    pub(super) fn may_follow(&self, earlier: ExprId, later: ExprId) -> bool {
        self.span(later).start >= self.span(earlier).end
            && !self.is_exclusive(earlier, later)
            && !self.is_cut_off(earlier, later)
    }

    /// Whether `earlier` stands in a block that always leaves the iteration at its end, and `later` behind that block.
    fn is_cut_off(&self, earlier: ExprId, later: ExprId) -> bool {
        let is_around = |id: ExprId| self.span(id).contains(self.span(later));
        std::iter::once(earlier)
            .chain(self.ancestors_inside(earlier))
            .take_while(|id| !is_around(*id))
            .any(|id| diverges(self, id))
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
