//! The fields of `self` that a method writes: those that it may write, and those that it clears whatever happens.

mod cleared;
mod places;
mod settings;
mod stand_ins;

use std::collections::{BTreeMap, BTreeSet};

use super::constants::Constants;
use crate::flow::{Head, Program};
use crate::index::{Def, FunctionId, Shape, Ty};
use crate::syntax::tree::{Arm, Body, ExprId, ExprKind, PatId, PatKind, Receiver, StmtKind};
use crate::types::{Callee, LocalId, TypedBody};

use cleared::Cleared;
pub(super) use cleared::clears_all;
use places::Part;
pub use settings::{is_state_field, works_out_of_settings};
use stand_ins::on_parameter;
pub use stand_ins::{stands_in, stands_in_for_states};

/// How deep calls are followed.
const MOST_CALLS: u32 = 4;

/// The fields of `self` that a function may write; `None` if it writes all of it, or hands it to something else.
pub(super) fn written_fields(program: &Program<'_>, id: FunctionId) -> Option<BTreeSet<String>> {
    Method::new(program, id, &[], 0)?.written()
}

/// The same of a parameter that a function is lent, where only its fields are named.
pub(super) fn written_fields_of(program: &Program<'_>, id: FunctionId, number: usize) -> Option<BTreeSet<String>> {
    let function = on_parameter(program, id, number, 0)?;
    let bases: BTreeSet<ExprId> = function.body.exprs.iter().filter_map(|expr| field_base(&expr.kind)).collect();
    let mut named = (0u32..).map(ExprId).take(function.body.exprs.len());
    let is_whole = |id: ExprId| function.typed.expr_local.get(&id) == Some(&function.itself) && !bases.contains(&id);
    if named.any(is_whole) { None } else { function.written() }
}

/// A method's body.
struct Method<'p, 'a> {
    program: &'p Program<'a>,
    body: &'a Body,
    typed: &'a TypedBody,
    itself: LocalId,
    /// The variables that stand for fields: `let Self { low, .. } = self;`.
    fields: BTreeMap<LocalId, String>,
    /// The parameters that keep a constant.
    given: BTreeMap<LocalId, Head>,
    depth: u32,
    /// The variables that stand for parts of it where the walk is: `for z in &mut self.delay`.
    parts: BTreeMap<LocalId, Part>,
    /// The variables that count all numbers up to an end where the walk is.
    counters: BTreeMap<LocalId, Option<ExprId>>,
    /// What is cleared where the body is left early.
    exits: Vec<Cleared>,
}

impl<'p, 'a> Method<'p, 'a> {
    fn new(program: &'p Program<'a>, id: FunctionId, heads: &[Option<Head>], depth: u32) -> Option<Self> {
        let typed = program.typed(id)?;
        let itself = typed.locals.iter().position(|local| local.name == "self")?;
        Self::of(program, id, heads, depth, LocalId(u32::try_from(itself).ok()?))
    }

    /// The body of a function with another variable in the place of `self`.
    fn of(
        program: &'p Program<'a>,
        id: FunctionId,
        heads: &[Option<Head>],
        depth: u32,
        itself: LocalId,
    ) -> Option<Self> {
        let body = program.index.function(id).function.body.as_ref()?;
        let typed = program.typed(id).filter(|_| depth <= MOST_CALLS)?;
        let is_kept =
            |pat| matches!(body.pat(pat).kind, PatKind::Bind { by_ref: false, mutable: false, sub: None, .. });
        let given = body.params.iter().zip(heads).filter(|(pat, _)| is_kept(**pat));
        let given = given.filter_map(|(pat, head)| Some((*typed.pat_local.get(pat)?, head.clone()?))).collect();
        let (fields, parts, counters) = (BTreeMap::new(), BTreeMap::new(), BTreeMap::new());
        let exits = Vec::new();
        let mut method = Self { program, body, typed, itself, fields, given, depth, parts, counters, exits };
        method.fields = method.taken_apart();
        Some(method)
    }

    fn taken_apart(&self) -> BTreeMap<LocalId, String> {
        let parts = self.body.stmts().filter_map(|stmt| match &stmt.kind {
            StmtKind::Let { pat, init: Some(init), .. } if self.is_self(*init) => match &self.body.pat(*pat).kind {
                PatKind::Struct(_, fields) => Some(fields),
                _ => None,
            },
            _ => None,
        });
        let local = |(name, pat): &(String, _)| Some((*self.typed.pat_local.get(pat)?, name.clone()));
        parts.flatten().filter_map(local).collect()
    }

    /// Whether an expression is `self`, `*self` or a reference to it.
    fn is_self(&self, expr: ExprId) -> bool {
        match &self.body.expr(expr).kind {
            ExprKind::Deref(inner) | ExprKind::Reference { value: inner, .. } => self.is_self(*inner),
            _ => self.typed.expr_local.get(&expr) == Some(&self.itself),
        }
    }

    /// The field of `self` in which a place lies.
    fn field(&self, expr: ExprId) -> Option<&str> {
        match &self.body.expr(expr).kind {
            ExprKind::Field { base, name } if self.is_self(*base) => Some(name),
            ExprKind::Field { base, .. } | ExprKind::Index { base, .. } => self.field(*base),
            ExprKind::Deref(inner) | ExprKind::Reference { value: inner, .. } => self.field(*inner),
            ExprKind::MethodCall { receiver, .. } => self.field(*receiver),
            _ => self.fields.get(self.typed.expr_local.get(&expr)?).map(String::as_str),
        }
    }

    /// The methods of the analysed code that a call may run.
    fn targets(&self, call: ExprId) -> Option<&'a [FunctionId]> {
        match self.typed.callees.get(&call) {
            Some(Callee::Resolved(resolved)) => Some(&resolved.targets),
            _ => None,
        }
    }

    /// Whether a method may write what it is called on.
    fn writes(&self, call: ExprId, receiver: ExprId) -> bool {
        let takes_it =
            |id: &FunctionId| self.program.index.function(*id).function.receiver == Some(Receiver::Exclusive);
        match self.targets(call) {
            Some(targets) => targets.iter().any(takes_it),
            None => !matches!(self.typed.ty(receiver).peel(), Ty::Int | Ty::Float | Ty::Bool),
        }
    }

    fn written(&self) -> Option<BTreeSet<String>> {
        let mut fields = BTreeSet::new();
        for id in (0u32..).map(ExprId).take(self.body.exprs.len()) {
            match &self.body.expr(id).kind {
                ExprKind::Assign { place, .. } | ExprKind::AssignOp { place, .. } => {
                    if self.is_self(*place) {
                        return None;
                    }
                    // `(self.x, self.y) = (x, y)`
                    let parts = self.body.assigned_places(*place);
                    fields.extend(parts.iter().filter_map(|part| self.field(*part)).map(str::to_owned));
                }
                ExprKind::Reference { mutable: true, value, .. } => {
                    fields.extend(self.field(*value).map(str::to_owned));
                }
                ExprKind::MethodCall { receiver, .. } if self.is_self(*receiver) => {
                    for target in self.targets(id).unwrap_or_default() {
                        fields.extend(Self::new(self.program, *target, &[], self.depth + 1)?.written()?);
                    }
                }
                ExprKind::MethodCall { receiver, .. } if self.writes(id, *receiver) => {
                    fields.extend(self.field(*receiver).map(str::to_owned));
                }
                _ => {}
            }
        }
        Some(fields)
    }

    /// The head of a parameter that keeps a constant, or of a constant.
    fn head(&self, id: ExprId) -> Option<Head> {
        let given = self.typed.expr_local.get(&id).and_then(|local| self.given.get(local));
        let constants = Constants { program: self.program, body: self.body, typed: self.typed };
        given.cloned().or_else(|| constants.head(id))
    }

    /// What a condition is, as far as the arguments tell.
    fn truth(&self, condition: ExprId) -> Option<bool> {
        match &self.body.expr(condition).kind {
            ExprKind::Not(inner) => self.truth(*inner).map(|truth| !truth),
            ExprKind::Binary { op: "&&", lhs, rhs } => match [self.truth(*lhs), self.truth(*rhs)] {
                [Some(false), _] | [_, Some(false)] => Some(false),
                [Some(true), rest] => rest,
                _ => None,
            },
            ExprKind::Binary { op: "||", lhs, rhs } => match [self.truth(*lhs), self.truth(*rhs)] {
                [Some(true), _] | [_, Some(true)] => Some(true),
                [Some(false), rest] => rest,
                _ => None,
            },
            _ => self.head(condition)?.parse().ok(),
        }
    }

    /// The arms that the arguments leave open.
    fn open_arms(&self, scrutinee: ExprId, arms: &'a [Arm]) -> Vec<&'a Arm> {
        let Some(head) = self.head(scrutinee) else { return arms.iter().collect() };
        let mut open = Vec::new();
        for arm in arms {
            match self.meets(arm.pat, &head) {
                Some(false) => continue,
                Some(true) if arm.guard.is_none() && arm.cfg.is_none() => {
                    open.push(arm);
                    break;
                }
                _ => open.push(arm),
            }
        }
        open
    }

    /// Whether what has a head meets a pattern, if that is certain.
    fn meets(&self, pat: PatId, head: &Head) -> Option<bool> {
        match (&self.body.pat(pat).kind, self.typed.pat_def.get(&pat)) {
            (PatKind::Literal(text), _) if is_truth(text) && is_truth(head) => Some(text == head),
            (kind, Some(Def::Variant(ty, at))) => {
                let Shape::Enum(variants) = &self.program.index.type_def(*ty).shape else { return None };
                let is_plain = matches!(kind, PatKind::Path(_) | PatKind::Bind { .. });
                let is_it = variants[*at].name == *head;
                // The head of a constant may be its own name.
                let is_told = variants.iter().any(|variant| variant.name == *head);
                (is_told && (is_plain || !is_it)).then_some(is_it)
            }
            _ => None,
        }
    }
}

fn field_base(kind: &ExprKind) -> Option<ExprId> {
    match kind {
        ExprKind::Field { base, .. } => Some(*base),
        _ => None,
    }
}

fn is_truth(head: &str) -> bool {
    matches!(head, "true" | "false")
}
