//! The fields of `self` that a method writes: those that it may write, and those that it clears whatever happens.

mod stand_ins;

use std::collections::{BTreeMap, BTreeSet};

use super::constants::Constants;
use crate::flow::{Head, Program};
use crate::index::{Def, FunctionId, Shape, Ty};
use crate::syntax::tree::{Arm, Body, ExprId, ExprKind, MacroKind, PatId, PatKind, Receiver, StmtKind};
use crate::types::{Callee, LocalId, TypedBody};

pub use stand_ins::{stands_in, stands_in_for_states};

/// How deep calls are followed.
const MOST_CALLS: u32 = 4;

/// The fields of `self` that a function may write; `None` if it writes all of it, or hands it to something else.
pub(super) fn written_fields(program: &Program<'_>, id: FunctionId) -> Option<BTreeSet<String>> {
    Method::new(program, id, &[], 0)?.written()
}

/// The fields of `self` that a function gives a new value on every path that arguments with these heads leave open; `None` if it
/// does so with all of them, or cannot be seen.
pub(super) fn cleared_fields(
    program: &Program<'_>,
    id: FunctionId,
    heads: &[Option<Head>],
) -> Option<BTreeSet<String>> {
    match Method::new(program, id, heads, 0)?.cleared() {
        Cleared::Everything => None,
        Cleared::Fields(fields) => Some(fields),
    }
}

/// What has a new value.
#[derive(Clone)]
enum Cleared {
    Everything,
    Fields(BTreeSet<String>),
}

impl Cleared {
    fn add(&mut self, more: Self) {
        match (self, more) {
            (Self::Everything, _) => {}
            (Self::Fields(fields), Self::Fields(more)) => fields.extend(more),
            (own, Self::Everything) => *own = Self::Everything,
        }
    }

    /// What both have cleared.
    fn common(self, other: Self) -> Self {
        match (self, other) {
            (Self::Everything, one) | (one, Self::Everything) => one,
            (Self::Fields(one), Self::Fields(other)) => Self::Fields(one.intersection(&other).cloned().collect()),
        }
    }
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
        let (fields, exits) = (BTreeMap::new(), Vec::new());
        let mut method = Self { program, body, typed, itself, fields, given, depth, exits };
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
                    let parts = match &self.body.expr(*place).kind {
                        ExprKind::Tuple(parts) => parts.as_slice(),
                        _ => std::slice::from_ref(place),
                    };
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

    fn cleared(&mut self) -> Cleared {
        let end = self.walk(self.body.root, Cleared::Fields(BTreeSet::new()));
        let ways = std::mem::take(&mut self.exits).into_iter().chain(end);
        // What never comes back leaves nothing behind.
        ways.reduce(Cleared::common).unwrap_or(Cleared::Everything)
    }

    /// What is cleared behind an expression; nothing if no path leads behind it.
    fn walk(&mut self, id: ExprId, before: Cleared) -> Option<Cleared> {
        let body = self.body;
        match &body.expr(id).kind {
            // Ways that leave it by its label are not told apart.
            ExprKind::Block(block) if block.label.is_some() => self.walk_children(id, before.clone()).and(Some(before)),
            ExprKind::Block(block) => {
                let mut now = before;
                for stmt in &block.stmts {
                    now = match &stmt.kind {
                        StmtKind::Let { init: Some(init), otherwise, .. } => {
                            let now = self.walk(*init, now)?;
                            if let Some(otherwise) = otherwise {
                                self.walk(*otherwise, now.clone());
                            }
                            now
                        }
                        StmtKind::Let { init: None, .. } => now,
                        StmtKind::Expr { expr, .. } => self.walk(*expr, now)?,
                    };
                }
                block.tail.map_or(Some(now.clone()), |tail| self.walk(tail, now))
            }
            ExprKind::If { condition, then, otherwise } => {
                let now = self.walk(*condition, before)?;
                let known = self.truth(*condition);
                let then = if known == Some(false) { None } else { self.walk(*then, now.clone()) };
                let otherwise = match otherwise {
                    _ if known == Some(true) => None,
                    Some(otherwise) => self.walk(*otherwise, now),
                    None => Some(now),
                };
                then.into_iter().chain(otherwise).reduce(Cleared::common)
            }
            ExprKind::Match { scrutinee, arms } => {
                let now = self.walk(*scrutinee, before)?;
                let open = self.open_arms(*scrutinee, arms);
                open.iter().filter_map(|arm| self.walk(arm.body, now.clone())).reduce(Cleared::common)
            }
            // Arrays and buffers are cleared in loops, of which it is taken that they do not end early.
            ExprKind::For { iterable, body, .. } | ExprKind::While { condition: iterable, body, .. } => {
                let now = self.walk(*iterable, before)?;
                Some(self.walk(*body, now.clone()).unwrap_or(now))
            }
            ExprKind::Loop { body, .. } => {
                self.walk(*body, before.clone());
                Some(before)
            }
            ExprKind::Return(value) => {
                let now = value.map_or(Some(before.clone()), |value| self.walk(value, before))?;
                self.exits.push(now);
                None
            }
            ExprKind::Break { .. } | ExprKind::Continue { .. } => None,
            ExprKind::Try(value) => {
                let now = self.walk(*value, before)?;
                self.exits.push(now.clone());
                Some(now)
            }
            ExprKind::Binary { op: "&&" | "||", lhs, rhs } => {
                let now = self.walk(*lhs, before)?;
                self.walk(*rhs, now.clone());
                Some(now)
            }
            ExprKind::Closure(_) => Some(before),
            ExprKind::Macro(call) => match &call.kind {
                MacroKind::DebugOnly(..) | MacroKind::Logging(_) => Some(before),
                MacroKind::Diverges(_) => None,
                MacroKind::ReturnsErr(_) => {
                    self.exits.push(before);
                    None
                }
                MacroKind::Ensure(..) => {
                    self.exits.push(before.clone());
                    self.walk_children(id, before)
                }
                _ => self.walk_children(id, before),
            },
            _ => {
                let mut now = self.walk_children(id, before)?;
                now.add(self.cleared_by(id));
                Some(now)
            }
        }
    }

    fn walk_children(&mut self, id: ExprId, before: Cleared) -> Option<Cleared> {
        self.body.children(id).into_iter().try_fold(before, |now, child| self.walk(child, now))
    }

    /// What an expression clears by itself.
    fn cleared_by(&self, id: ExprId) -> Cleared {
        let field = |place: ExprId| Cleared::Fields(self.field(place).map(str::to_owned).into_iter().collect());
        match &self.body.expr(id).kind {
            ExprKind::Assign { place, value } if self.is_self(*place) => match &self.body.expr(*value).kind {
                ExprKind::Struct { fields, rest, .. } => self.made_anew(*value, fields, *rest),
                ExprKind::MethodCall { receiver, method, .. } if method == "clone" && self.is_self(*receiver) => {
                    Cleared::Fields(BTreeSet::new())
                }
                _ => Cleared::Everything,
            },
            ExprKind::Assign { place, value } if let ExprKind::Tuple(places) = &self.body.expr(*place).kind => {
                let given = match &self.body.expr(*value).kind {
                    ExprKind::Tuple(parts) if parts.len() == places.len() => parts.clone(),
                    _ => vec![*value; places.len()],
                };
                let own = places.iter().zip(given).filter_map(|(place, value)| Some((self.field(*place)?, value)));
                Cleared::Fields(
                    own.filter(|(name, value)| !self.keeps(*value, name)).map(|(name, _)| name.to_owned()).collect(),
                )
            }
            ExprKind::Assign { place, value } if self.field(*place).is_some_and(|name| !self.keeps(*value, name)) => {
                field(*place)
            }
            ExprKind::Reference { mutable: true, value, .. } => field(*value),
            ExprKind::MethodCall { receiver, args, .. } if self.is_self(*receiver) => self.cleared_by_call(id, args),
            // `Lag::reset(self)`
            ExprKind::Call { args, .. }
                if let [receiver, args @ ..] = args.as_slice()
                    && self.is_self(*receiver) =>
            {
                self.cleared_by_call(id, args)
            }
            ExprKind::MethodCall { receiver, .. } if self.writes(id, *receiver) => field(*receiver),
            _ => Cleared::Fields(BTreeSet::new()),
        }
    }

    /// What a method clears that is called on `self` with these other arguments.
    fn cleared_by_call(&self, id: ExprId, args: &[ExprId]) -> Cleared {
        let heads: Vec<Option<Head>> = [None].into_iter().chain(args.iter().map(|arg| self.head(*arg))).collect();
        let of = |target: &FunctionId| Some(Self::new(self.program, *target, &heads, self.depth + 1)?.cleared());
        let called = self.targets(id).unwrap_or_default().iter().filter_map(of);
        called.reduce(Cleared::common).unwrap_or(Cleared::Fields(BTreeSet::new()))
    }

    /// What `*self = Self { … }` clears: not the fields that it takes over.
    fn made_anew(&self, value: ExprId, fields: &[(String, ExprId)], rest: Option<ExprId>) -> Cleared {
        let (kept, new): (Vec<_>, Vec<_>) = fields.iter().partition(|(name, value)| self.keeps(*value, name));
        let keeps_rest = rest.is_some_and(|rest| match &self.body.expr(rest).kind {
            ExprKind::MethodCall { receiver, method, .. } => method == "clone" && self.is_self(*receiver),
            _ => self.is_self(rest),
        });
        if kept.is_empty() && !keeps_rest {
            return Cleared::Everything;
        }
        let mut cleared: BTreeSet<String> = new.into_iter().map(|(name, _)| name.clone()).collect();
        if let Ty::Adt(id, _) = self.typed.ty(value).peel()
            && let Shape::Struct(all) = &self.program.index.type_def(*id).shape
            && !keeps_rest
        {
            let is_other = |name: &&String| !kept.iter().any(|(own, _)| own == *name);
            cleared.extend(all.fields.iter().map(|field| &field.name).filter(is_other).cloned());
        }
        Cleared::Fields(cleared)
    }

    /// Whether a value is made of what a field was: `self.low * 0.9`.
    fn keeps(&self, value: ExprId, name: &str) -> bool {
        match &self.body.expr(value).kind {
            ExprKind::Field { base, name: own } => own == name && self.is_self(*base),
            ExprKind::Binary { lhs, rhs, .. } => self.keeps(*lhs, name) || self.keeps(*rhs, name),
            ExprKind::Negate(value) | ExprKind::Cast { value, .. } => self.keeps(*value, name),
            ExprKind::MethodCall { receiver, method, .. } => {
                let is_number = matches!(self.typed.ty(*receiver).peel(), Ty::Int | Ty::Float);
                (is_number || method == "clone") && self.keeps(*receiver, name)
            }
            _ => false,
        }
    }
}

fn is_truth(head: &str) -> bool {
    matches!(head, "true" | "false")
}
