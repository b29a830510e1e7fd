//! Filters that are handed out by number, one for each round of a loop: `match axis { 0 => self.roll.update(x), … }`, there or in what
//! the loop calls.

use super::Builder;
use super::constants::Constants;
use super::unrolled::plain;
use crate::flow::Head;
use crate::index::Ty;
use crate::syntax::tree::{Arm, ExprId, ExprKind, Literal, PatKind, Receiver};
use crate::types::{Callee, LocalId, Resolved};

/// How many calls are followed to the choice.
const MAX_CALLS: u32 = 2;

impl Builder<'_> {
    /// Whether each of these numbers chooses a filter of its own in a body, which touches no filter beside that choice.
    pub(super) fn chooses_by(&self, inside: ExprId, number: LocalId, numbers: &[Head]) -> bool {
        numbers.len() > 1 && self.constants().chooses_by(inside, number, numbers, 0)
    }
}

impl Constants<'_> {
    fn chooses_by(self, inside: ExprId, number: LocalId, numbers: &[Head], calls: u32) -> bool {
        let all: Vec<ExprId> = self.body.within(inside).collect();
        let is_it = |id: ExprId| self.typed.expr_local.get(&plain(self.body, id)) == Some(&number);
        let mut chosen: Vec<ExprId> = Vec::new();
        for id in &all {
            match &self.body.expr(*id).kind {
                // What is lent by the number is touched behind the choice.
                ExprKind::Match { scrutinee, .. } if is_it(*scrutinee) && self.lends(*id) => return true,
                ExprKind::Match { scrutinee, arms } if is_it(*scrutinee) && self.has_each(arms, numbers) => {
                    chosen.extend(arms.iter().flat_map(|arm| self.body.within(arm.body)));
                }
                ExprKind::If { .. } if self.lends(*id) && self.asks_each(*id, &is_it, numbers) => return true,
                ExprKind::If { .. } if self.asks_each(*id, &is_it, numbers) => chosen.extend(self.body.within(*id)),
                ExprKind::MethodCall { args, .. } | ExprKind::Call { args, .. } if calls < MAX_CALLS => {
                    let at = args.iter().position(|arg| is_it(*arg));
                    if at.is_some_and(|at| self.callee_chooses(*id, at, numbers, calls)) {
                        chosen.push(*id);
                    }
                }
                _ => {}
            }
        }
        let touching: Vec<&ExprId> = all.iter().filter(|id| self.touches(**id)).collect();
        !touching.is_empty() && touching.into_iter().all(|id| chosen.contains(id))
    }

    /// Whether what a call runs hands filters out by one of its arguments.
    fn callee_chooses(self, call: ExprId, arg: usize, numbers: &[Head], calls: u32) -> bool {
        let Some(Callee::Resolved(Resolved { targets, .. })) = self.typed.callees.get(&call) else { return false };
        let [target] = targets.as_slice() else { return false };
        let is_method = matches!(self.body.expr(call).kind, ExprKind::MethodCall { .. });
        let body = self.program.index.function(*target).function.body.as_ref();
        let (Some(body), Some(typed)) = (body, self.program.typed(*target)) else { return false };
        let param = body.params.get(arg + usize::from(is_method)).and_then(|pat| typed.pat_local.get(pat));
        param.is_some_and(|param| Self { body, typed, ..self }.chooses_by(body.root, *param, numbers, calls + 1))
    }

    /// Whether each number has an arm of its own.
    fn has_each(self, arms: &[Arm], numbers: &[Head]) -> bool {
        let mut asked = Vec::new();
        for arm in arms {
            match &self.body.pat(arm.pat).kind {
                _ if arm.guard.is_some() => return false,
                PatKind::Literal(head) => asked.push(head.clone()),
                PatKind::Wild | PatKind::Bind { sub: None, .. } => {}
                _ => return false,
            }
        }
        is_each(&asked, numbers)
    }

    /// The same for `if axis == 0 { … } else if axis == 1 { … } else { … }`.
    fn asks_each(self, id: ExprId, is_it: &dyn Fn(ExprId) -> bool, numbers: &[Head]) -> bool {
        let mut asked = Vec::new();
        let mut next = Some(id);
        while let Some(id) = next {
            let ExprKind::If { condition, otherwise, .. } = &self.body.expr(id).kind else { break };
            match &self.body.expr(*condition).kind {
                ExprKind::Binary { op: "==", lhs, rhs } if is_it(*lhs) => match &self.body.expr(*rhs).kind {
                    ExprKind::Literal(Literal::Int(Some(number), _)) => asked.push(number.to_string()),
                    _ => return false,
                },
                _ => return false,
            }
            next = *otherwise;
        }
        is_each(&asked, numbers)
    }

    fn lends(self, id: ExprId) -> bool {
        matches!(self.typed.ty(id), Ty::Ref(..)) && self.holds_filter(id)
    }

    /// Whether a call may touch a filter.
    fn touches(self, id: ExprId) -> bool {
        let is_shared = |id: &ExprId| match self.typed.callees.get(id) {
            Some(Callee::Resolved(Resolved { targets, .. })) => targets
                .iter()
                .all(|target| self.program.index.function(*target).function.receiver == Some(Receiver::Shared)),
            _ => false,
        };
        match &self.body.expr(id).kind {
            ExprKind::MethodCall { receiver, args, .. } => {
                (self.holds_filter(*receiver) && !is_shared(&id)) || args.iter().any(|arg| self.holds_filter(*arg))
            }
            ExprKind::Call { args, .. } => args.iter().any(|arg| self.holds_filter(*arg)),
            ExprKind::Opaque(_) | ExprKind::Unknown { .. } => true,
            _ => false,
        }
    }

    fn holds_filter(self, id: ExprId) -> bool {
        let ty = self.typed.ty(id).peel();
        self.program.index.may_be_state(ty) || self.program.index.holds_filter(ty)
    }
}

/// Whether these are all of the numbers, or all but the one that is left.
fn is_each(asked: &[Head], numbers: &[Head]) -> bool {
    let is_left = |number: &&Head| !asked.contains(number);
    !asked.is_empty() && numbers.iter().filter(is_left).count() <= 1
}
