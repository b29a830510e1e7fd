//! Which methods are called on one and the same value, one beside the other.

use std::collections::{BTreeMap, BTreeSet};

use super::uses::{is_test, takes_state};
use crate::flow::Program;
use crate::index::FunctionId;
use crate::syntax::tree::{Body, ExprId, ExprKind, StmtKind};
use crate::types::{Callee, TypedBody};

/// A call that may run more bodies than this says little of each.
const MOST_TARGETS: usize = 4;

/// What functions do with one value by several calls.
#[derive(Debug, Default)]
pub(super) struct Together {
    /// Methods both of which one way through a function may call on the same value.
    beside: BTreeSet<(FunctionId, FunctionId)>,
    /// Methods that are called once, and then again for as long as what they gave back says so: a sum that is drawn off.
    pub(super) drained: BTreeSet<FunctionId>,
}

impl Together {
    pub(super) fn read(program: &Program<'_>) -> Self {
        let index = program.index;
        let mut together = Self::default();
        for caller in index.function_ids() {
            let def = index.function(caller);
            let (Some(body), Some(typed)) = (&def.function.body, program.typed(caller)) else { continue };
            if is_test(index, def) {
                continue;
            }
            let mut called: BTreeMap<String, Vec<(ExprId, FunctionId)>> = BTreeMap::new();
            for (at, callee) in &typed.callees {
                if let (Callee::Resolved(resolved), ExprKind::MethodCall { receiver, .. }) =
                    (callee, &body.expr(*at).kind)
                    && resolved.targets.len() <= MOST_TARGETS
                {
                    let methods = resolved.targets.iter().filter(|target| takes_state(index.function(**target)));
                    called.entry(name(body, *receiver)).or_default().extend(methods.map(|target| (*at, *target)));
                }
            }
            let parents = called.values().any(|calls| calls.len() > 1).then(|| body.parents());
            let Some(parents) = parents else { continue };
            called.values().for_each(|calls| together.add(body, typed, &parents, calls));
        }
        together
    }

    fn add(&mut self, body: &Body, typed: &TypedBody, parents: &[Option<ExprId>], calls: &[(ExprId, FunctionId)]) {
        for (number, (at, method)) in calls.iter().enumerate() {
            for (other_at, other) in &calls[number + 1..] {
                let pairs = [(*method, *other), (*other, *method)];
                if at != other_at && method != other && are_on_one_way(body, parents, *at, *other_at) {
                    self.beside.extend(pairs);
                }
                let again = || {
                    let draws = |call: ExprId, first: ExprId| draws_off(body, typed, parents, call, first);
                    draws(*at, *other_at) || draws(*other_at, *at)
                };
                if at != other_at && method == other && again() {
                    self.drained.insert(*method);
                }
            }
        }
    }

    /// Whether one way through some function may call both of them on the same value.
    pub(super) fn are_beside(&self, one: FunctionId, other: FunctionId) -> bool {
        self.beside.contains(&(one, other))
    }
}

/// What a receiver is called, as far as it has a name.
fn name(body: &Body, receiver: ExprId) -> String {
    let mut name = String::new();
    let mut open = vec![receiver];
    while let Some(id) = open.pop() {
        match &body.expr(id).kind {
            ExprKind::Path(path) => name.insert_str(0, &path.text()),
            ExprKind::Field { base, name: field } => {
                name.insert_str(0, &format!(".{field}"));
                open.push(*base);
            }
            ExprKind::Index { base, .. } => {
                name.insert_str(0, "[]");
                open.push(*base);
            }
            ExprKind::Deref(inner) | ExprKind::Reference { value: inner, .. } => open.push(*inner),
            _ => name.insert(0, '_'),
        }
    }
    name
}

/// What lies around an expression, from itself outwards.
fn around(parents: &[Option<ExprId>], at: ExprId) -> impl Iterator<Item = ExprId> {
    std::iter::successors(Some(at), |at| parents[at.0 as usize])
}

/// Whether one way through the body may come to both expressions: they lie in different arms of nothing, and the first of them lies in
/// nothing that leaves before the second one.
fn are_on_one_way(body: &Body, parents: &[Option<ExprId>], one: ExprId, other: ExprId) -> bool {
    let of_other: Vec<ExprId> = around(parents, other).collect();
    let Some(common) = around(parents, one).find(|at| of_other.contains(at)) else { return true };
    let below = |from: ExprId| around(parents, from).take_while(|at| *at != common).collect::<Vec<_>>();
    let [of_one, of_other] = [below(one), below(other)];
    let arms: Vec<ExprId> = match &body.expr(common).kind {
        ExprKind::If { then, otherwise, .. } => [*then].into_iter().chain(*otherwise).collect(),
        ExprKind::Match { arms, .. } => arms.iter().map(|arm| arm.body).collect(),
        _ => Vec::new(),
    };
    let arm = |below: &[ExprId]| below.last().and_then(|last| arms.iter().position(|arm| arm == last));
    let are_apart = arm(&of_one).is_some() && arm(&of_other).is_some() && arm(&of_one) != arm(&of_other);
    let first = if one < other { &of_one } else { &of_other };
    !are_apart && !first.iter().any(|at| leaves(body, *at))
}

/// Whether an expression ends by leaving the loop or the function.
fn leaves(body: &Body, at: ExprId) -> bool {
    match &body.expr(at).kind {
        ExprKind::Return(_) | ExprKind::Break { .. } | ExprKind::Continue { .. } => true,
        ExprKind::Block(block) => {
            let last = block.tail.or_else(|| match block.stmts.last().map(|stmt| &stmt.kind) {
                Some(StmtKind::Expr { expr, .. }) => Some(*expr),
                _ => None,
            });
            last.is_some_and(|last| leaves(body, last))
        }
        _ => false,
    }
}

/// Whether a call lies in a `while` that goes on for as long as what it gives back says so, and another one of the same method on the
/// same value stands before that loop.
fn draws_off(body: &Body, typed: &TypedBody, parents: &[Option<ExprId>], call: ExprId, first: ExprId) -> bool {
    let mut given: Vec<ExprId> = Vec::new();
    for at in around(parents, call) {
        match &body.expr(at).kind {
            ExprKind::Assign { place, value } if body.within(*value).any(|id| id == call) => {
                given.extend(body.assigned_places(*place));
            }
            ExprKind::While { condition, body: round, .. } => {
                let is_asked = body.within(*condition).any(|asked| {
                    let local = typed.expr_local.get(&asked);
                    local.is_some() && given.iter().any(|place| typed.expr_local.get(place) == local)
                });
                let is_before = !body.within(*round).chain(body.within(*condition)).any(|id| id == first);
                return is_asked && is_before && first < at;
            }
            ExprKind::Closure(_) | ExprKind::Loop { .. } | ExprKind::For { .. } => return false,
            _ => {}
        }
    }
    false
}
