//! A `poll` that is not ready yet: whether it may answer so, and whether it may have run a law before.

use crate::flow::lower::Builder;
use crate::index::{FunctionId, Ty};
use crate::syntax::tree::{Arm, Body, ExprId, ExprKind, PatId, PatKind, StmtKind};
use crate::types::{Callee, TypedBody};

/// How deep a `poll` is looked into that another one calls.
const MAX_DEPTH: u32 = 4;

/// The ways through a `poll`, as it is written.
struct Ways<'a> {
    body: &'a Body,
    typed: &'a TypedBody,
    depth: u32,
    /// Whether one of them may answer that it is not ready, after a law has run.
    is_pending: bool,
}

impl Builder<'_> {
    /// Whether a `poll` may answer that it is not ready yet.
    pub(super) fn may_be_pending(&self, poll: FunctionId) -> bool {
        let Some(body) = &self.program.index.function(poll).function.body else { return true };
        let is_other = |kind: &ExprKind| match kind {
            ExprKind::Return(value) => !value.is_some_and(|value| is_ready(body, value)),
            ExprKind::Opaque(_) | ExprKind::Unknown { .. } => true,
            _ => false,
        };
        !is_ready(body, body.root) || body.exprs.iter().any(|expr| is_other(&expr.kind))
    }

    /// Whether a `poll` that is not ready may leave something else for the next one: it assigns, or calls what does.
    pub(super) fn remembers(&self, function: FunctionId, depth: u32) -> bool {
        let body = self.program.index.function(function).function.body.as_ref();
        let (Some(body), Some(typed)) = (body, self.program.typed(function)) else { return false };
        let calls = (0u32..).map(ExprId).take(body.exprs.len()).filter_map(|id| typed.callees.get(&id));
        let mut own = calls.filter_map(|callee| match callee {
            Callee::Resolved(call) if call.law.is_none() => Some(&call.targets),
            _ => None,
        });
        let assigns = |kind: &ExprKind| matches!(kind, ExprKind::Assign { .. } | ExprKind::AssignOp { .. });
        depth > MAX_DEPTH
            || body.exprs.iter().any(|expr| assigns(&expr.kind))
            || own.any(|targets| targets.iter().any(|target| self.remembers(*target, depth + 1)))
    }

    /// Whether a law may have run where a `poll` answers that it is not ready yet: then it runs in cycles of its own.
    pub(super) fn updates_while_pending(&self, poll: FunctionId, depth: u32) -> bool {
        let body = self.program.index.function(poll).function.body.as_ref();
        let (Some(body), Some(typed)) = (body, self.program.typed(poll)) else { return true };
        let mut ways = Ways { body, typed, depth, is_pending: depth > MAX_DEPTH };
        self.follow(&mut ways, body.root, false);
        ways.is_pending
    }

    /// Whether a law may have run behind an expression, if one may have before it.
    fn follow(&self, ways: &mut Ways<'_>, id: ExprId, has_run: bool) -> bool {
        if ways.is_pending {
            return has_run;
        }
        let body = ways.body;
        match &body.expr(id).kind {
            ExprKind::If { condition, then, otherwise } => {
                let asked = self.follow(ways, *condition, has_run);
                let (by_then, by_other) = match &body.expr(*condition).kind {
                    ExprKind::Let { pat, value } if is_answer(ways, *value) => match says_pending(body, *pat) {
                        true => (has_run, asked),
                        false => (asked, has_run),
                    },
                    _ => (asked, asked),
                };
                let by_then = self.follow(ways, *then, by_then);
                otherwise.map_or(by_other, |other| self.follow(ways, other, by_other)) || by_then
            }
            ExprKind::Match { scrutinee, arms } => {
                let asked = self.follow(ways, *scrutinee, has_run);
                let tells = is_answer(ways, *scrutinee);
                let is_rest = |arm: &Arm| {
                    matches!(body.pat(arm.pat).kind, PatKind::Wild) && arms.iter().any(|arm| says_ready(body, arm.pat))
                };
                arms.iter().fold(false, |behind, arm| {
                    let is_pending = tells && (says_pending(body, arm.pat) || is_rest(arm));
                    let before = if is_pending { has_run } else { asked };
                    let before = arm.guard.map_or(before, |guard| self.follow(ways, guard, before));
                    self.follow(ways, arm.body, before) || behind
                })
            }
            ExprKind::Block(block) => {
                let behind = block.stmts.iter().fold(has_run, |has_run, stmt| match &stmt.kind {
                    StmtKind::Let { init, otherwise, .. } => {
                        let given = init.map_or(has_run, |init| self.follow(ways, init, has_run));
                        let tells = init.is_some_and(|init| is_answer(ways, init));
                        if let Some(otherwise) = otherwise {
                            self.follow(ways, *otherwise, if tells { has_run } else { given });
                        }
                        given
                    }
                    StmtKind::Expr { expr, .. } => self.follow(ways, *expr, has_run),
                });
                block.tail.map_or(behind, |tail| self.follow(ways, tail, behind))
            }
            ExprKind::Loop { .. } | ExprKind::While { .. } | ExprKind::For { .. } => {
                let after_one = self.follow_parts(ways, id, has_run);
                self.follow_parts(ways, id, after_one)
            }
            ExprKind::Return(_) => {
                self.follow_parts(ways, id, has_run);
                false
            }
            ExprKind::Path(path) => {
                ways.is_pending |=
                    has_run && (path.last() == "Pending" || path.last() != "Ready" && is_answer(ways, id));
                has_run
            }
            ExprKind::Opaque(_) | ExprKind::Unknown { .. } => {
                ways.is_pending = true;
                has_run
            }
            // What is done with an answer does not turn one that is ready into one that is not.
            ExprKind::MethodCall { receiver, .. } if is_answer(ways, *receiver) => self.follow_parts(ways, id, has_run),
            ExprKind::Call { .. } | ExprKind::MethodCall { .. } => {
                let before = self.follow_parts(ways, id, has_run);
                ways.is_pending |= before && is_answer(ways, id) && !is_ready(body, id);
                before || self.runs_law(ways, id)
            }
            _ => self.follow_parts(ways, id, has_run),
        }
    }

    fn follow_parts(&self, ways: &mut Ways<'_>, id: ExprId, has_run: bool) -> bool {
        ways.body.children(id).into_iter().fold(has_run, |has_run, part| self.follow(ways, part, has_run))
    }

    /// Whether an expression is a call that may run a law. One of another `poll` may do so and not be ready.
    fn runs_law(&self, ways: &mut Ways<'_>, id: ExprId) -> bool {
        match ways.typed.callees.get(&id) {
            Some(Callee::Resolved(call)) => {
                if is_answer(ways, id) {
                    let depth = ways.depth + 1;
                    ways.is_pending |= call.targets.iter().any(|target| self.updates_while_pending(*target, depth));
                }
                self.may_run_law(call, 0)
            }
            Some(Callee::Parameter(_)) => true,
            Some(Callee::External(path)) if path.starts_with("std::") => false,
            Some(Callee::Builtin | Callee::Constructor(_)) => false,
            Some(Callee::Unknown | Callee::Closure(_) | Callee::External(_)) | None => {
                let holds = |ty: &Ty| *ty != Ty::Unknown && self.may_hold_filter(ty);
                ways.body.children(id).into_iter().any(|part| holds(ways.typed.ty(part)))
            }
        }
    }
}

/// Whether an expression may say that something is not ready: its type is `Poll`.
fn is_answer(ways: &Ways<'_>, id: ExprId) -> bool {
    ways.typed.ty(id).external_name() == Some("Poll")
}

fn says_pending(body: &Body, pat: PatId) -> bool {
    match &body.pat(pat).kind {
        PatKind::Path(path) => path.last() == "Pending",
        PatKind::Bind { name, .. } => name == "Pending",
        _ => false,
    }
}

/// Whether a pattern is all that is ready.
fn says_ready(body: &Body, pat: PatId) -> bool {
    let PatKind::TupleStruct(path, parts) = &body.pat(pat).kind else { return false };
    let is_name = |part: &PatId| matches!(body.pat(*part).kind, PatKind::Bind { sub: None, .. } | PatKind::Wild);
    path.last() == "Ready" && parts.iter().all(is_name)
}

/// Whether an expression can be nothing but `Poll::Ready`.
fn is_ready(body: &Body, id: ExprId) -> bool {
    match &body.expr(id).kind {
        ExprKind::Block(block) => block.tail.is_some_and(|tail| is_ready(body, tail)),
        ExprKind::Return(_) => true,
        ExprKind::If { then, otherwise, .. } => {
            is_ready(body, *then) && otherwise.is_some_and(|otherwise| is_ready(body, otherwise))
        }
        ExprKind::Match { arms, .. } => arms.iter().all(|arm| is_ready(body, arm.body)),
        ExprKind::Call { callee, .. } => {
            matches!(&body.expr(*callee).kind, ExprKind::Path(path) if path.last() == "Ready")
        }
        _ => false,
    }
}
