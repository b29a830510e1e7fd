//! What a method gives a new value, whatever happens: the part of its state that a reset sets back.

use std::collections::BTreeSet;

use super::Method;
use super::places::{Part, covers, written_parts};
use super::stand_ins::on_parameter;
use crate::flow::{Head, Program};
use crate::index::{FunctionId, MethodOwner, Shape, Ty};
use crate::syntax::tree::{ExprId, ExprKind, MacroKind, StmtKind};
use crate::types::{Callee, LocalId};

/// Methods of the standard library that give all of a value anew.
const CLEARING: &[&str] = &[
    "clear",
    "fill",
    "fill_with",
    "take",
    "set",
    "store",
    "replace",
    "insert",
    "swap",
    "copy_from_slice",
    "clone_from_slice",
    "clone_from",
];

/// Methods of collections everywhere that leave a part of them as it is.
const CHANGING: &[&str] = &[
    "append",
    "as_mut",
    "dequeue",
    "enqueue",
    "entry",
    "extend",
    "extend_from_slice",
    "first_mut",
    "get_mut",
    "get_or_insert",
    "get_or_insert_with",
    "iter_mut",
    "last_mut",
    "peek_mut",
    "pop",
    "pop_back",
    "pop_front",
    "push",
    "push_back",
    "push_front",
    "remove",
    "resize",
    "retain",
    "reverse",
    "rotate_left",
    "rotate_right",
    "sort",
    "swap_remove",
    "truncate",
    "write",
];

/// Whether a reset with arguments of these heads gives all a new value that the laws of a type write; `None` if it gives itself one,
/// or cannot be seen.
pub(in crate::flow::lower) fn clears_all(
    program: &Program<'_>,
    reset: FunctionId,
    ty: &Ty,
    heads: &[Option<Head>],
) -> Option<bool> {
    let Cleared::Parts(cleared) = Method::new(program, reset, heads, 0)?.cleared() else { return None };
    let laws = program.index.methods(ty, "update");
    let mut state = BTreeSet::new();
    for law in laws.iter().filter_map(MethodOwner::function) {
        match written_parts(program, law) {
            Some(parts) => state.extend(parts),
            None => return Some(!cleared.is_empty()),
        }
    }
    Some(state.iter().all(|part| covers(program, &cleared, part, ty.peel())))
}

/// What has a new value.
#[derive(Clone)]
pub(super) enum Cleared {
    Everything,
    Parts(BTreeSet<Part>),
}

impl Cleared {
    const fn nothing() -> Self {
        Self::Parts(BTreeSet::new())
    }

    fn part(part: Part) -> Self {
        if part.is_empty() { Self::Everything } else { Self::Parts(BTreeSet::from([part])) }
    }

    fn add(&mut self, more: Self) {
        match (self, more) {
            (Self::Everything, _) => {}
            (Self::Parts(parts), Self::Parts(more)) => parts.extend(more),
            (own, Self::Everything) => *own = Self::Everything,
        }
    }

    /// What both have cleared.
    fn common(self, other: Self) -> Self {
        match (self, other) {
            (Self::Everything, one) | (one, Self::Everything) => one,
            (Self::Parts(one), Self::Parts(other)) => {
                let inside = |parts: &BTreeSet<Part>, part: &Part| parts.iter().any(|own| part.starts_with(own));
                let both = one.iter().filter(|part| inside(&other, part));
                Self::Parts(both.chain(other.iter().filter(|part| inside(&one, part))).cloned().collect())
            }
        }
    }

    /// The same of a part of something.
    fn below(self, part: &Part) -> Self {
        match self {
            Self::Everything => Self::part(part.clone()),
            Self::Parts(parts) => {
                Self::Parts(parts.into_iter().map(|own| part.iter().cloned().chain(own).collect()).collect())
            }
        }
    }
}

impl<'a> Method<'_, 'a> {
    pub(super) fn cleared(&mut self) -> Cleared {
        let end = self.walk(self.body.root, Cleared::nothing());
        let ways = std::mem::take(&mut self.exits).into_iter().chain(end);
        // What never comes back leaves nothing behind.
        ways.reduce(Cleared::common).unwrap_or(Cleared::Everything)
    }

    /// What is cleared behind an expression; nothing if no path leads behind it.
    fn walk(&mut self, id: ExprId, before: Cleared) -> Option<Cleared> {
        let body: &'a crate::syntax::tree::Body = self.body;
        match &body.expr(id).kind {
            // Ways that leave it by its label are not told apart.
            ExprKind::Block(block) if block.label.is_some() => self.walk_children(id, before.clone()).and(Some(before)),
            ExprKind::Block(block) => {
                let mut now = before;
                for stmt in &block.stmts {
                    now = match &stmt.kind {
                        StmtKind::Let { pat, init: Some(init), otherwise, .. } => {
                            let now = self.walk(*init, now)?;
                            if let Some(otherwise) = otherwise {
                                self.walk(*otherwise, now.clone());
                            }
                            // `let low = &mut self.low;`
                            let is_lent = matches!(body.expr(*init).kind, ExprKind::Reference { mutable: true, .. });
                            let lent =
                                self.part(*init).filter(|(part, is_whole)| *is_whole && !part.is_empty() && is_lent);
                            self.parts.extend(self.element(*pat).zip(lent.map(|(part, _)| part)));
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
            ExprKind::For { pat, iterable, body: round, .. } => {
                let now = self.walk(*iterable, before)?;
                let element = self.each_of(*iterable).and_then(|part| Some((self.element(*pat)?, part)));
                let counter = self.counted_to(*iterable).and_then(|end| Some((self.element(*pat)?, end)));
                self.walk_rounds(*round, now, element, counter)
            }
            ExprKind::While { condition, body: round, .. } => {
                let now = self.walk(*condition, before)?;
                let counter = match body.expr(*condition).kind {
                    ExprKind::Binary { op: "<" | "!=", lhs, rhs } => {
                        self.typed.expr_local.get(&lhs).copied().zip(self.all_up_to(rhs))
                    }
                    _ => None,
                };
                self.walk_rounds(*round, now, None, counter)
            }
            ExprKind::Loop { body, .. } => {
                self.walk(*body, before.clone());
                Some(before)
            }
            // `self.delay.iter_mut().for_each(|z| *z = 0.0)`
            ExprKind::MethodCall { receiver, method, args, .. }
                if let ([closure], "for_each", Some(part)) =
                    (args.as_slice(), method.as_str(), self.each_of(*receiver))
                    && let ExprKind::Closure(closure) = &body.expr(*closure).kind
                    && let [(pat, _)] = closure.params.as_slice() =>
            {
                let element = self.element(*pat).map(|local| (local, part));
                self.walk_rounds(closure.body, before, element, None)
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

    /// What is cleared behind a loop that comes by each element, or each number, of something. One that ends early, or passes some
    /// over, clears none for certain.
    fn walk_rounds(
        &mut self,
        round: ExprId,
        before: Cleared,
        element: Option<(LocalId, Part)>,
        counter: Option<(LocalId, Option<ExprId>)>,
    ) -> Option<Cleared> {
        let is_left = self.leaves(round);
        let is_each = element.is_some() || counter.is_some();
        let (element_local, counter_local) = (element.as_ref().map(|own| own.0), counter.map(|own| own.0));
        self.parts.extend(element);
        self.counters.extend(counter);
        let now = self.walk(round, before.clone());
        element_local.and_then(|local| self.parts.remove(&local));
        counter_local.and_then(|local| self.counters.remove(&local));
        Some(now.filter(|_| is_each && !is_left).unwrap_or(before))
    }

    /// Whether a round may be left before its end.
    fn leaves(&self, round: ExprId) -> bool {
        let mut open = vec![round];
        while let Some(id) = open.pop() {
            let kind = &self.body.expr(id).kind;
            let is_left = matches!(
                kind,
                ExprKind::Break { .. } | ExprKind::Continue { .. } | ExprKind::Return(_) | ExprKind::Try(_)
            );
            if is_left {
                return true;
            }
            open.extend(self.body.children(id));
        }
        false
    }

    /// What an expression clears by itself.
    fn cleared_by(&self, id: ExprId) -> Cleared {
        match &self.body.expr(id).kind {
            ExprKind::Assign { place, value } if self.is_self(*place) => match &self.body.expr(*value).kind {
                ExprKind::Struct { fields, rest, .. } => self.made_anew(*value, fields, *rest),
                ExprKind::MethodCall { receiver, method, .. } if method == "clone" && self.is_self(*receiver) => {
                    Cleared::nothing()
                }
                _ => Cleared::Everything,
            },
            ExprKind::Assign { place, value } => {
                let places = match &self.body.expr(*place).kind {
                    ExprKind::Tuple(places) => places.as_slice(),
                    _ => std::slice::from_ref(place),
                };
                let given = match &self.body.expr(*value).kind {
                    ExprKind::Tuple(parts) if places.len() > 1 && parts.len() == places.len() => parts.clone(),
                    _ => vec![*value; places.len()],
                };
                let own = places.iter().zip(given).filter_map(|(place, value)| Some((self.whole(*place)?, value)));
                let mut found = Cleared::nothing();
                for (part, _) in own.filter(|(part, value)| !self.keeps(*value, part)) {
                    found.add(Cleared::part(part));
                }
                found
            }
            ExprKind::MethodCall { receiver, args, .. } if self.is_self(*receiver) => self.cleared_by_call(id, args),
            // `Lag::reset(self)`
            ExprKind::Call { args, .. }
                if let [receiver, args @ ..] = args.as_slice()
                    && self.is_self(*receiver)
                    && self.targets(id).is_some_and(|targets| !targets.is_empty()) =>
            {
                self.cleared_by_call(id, args)
            }
            ExprKind::Call { args, .. } => self.cleared_by_function(id, args),
            ExprKind::MethodCall { receiver, method, args, .. } if self.writes(id, *receiver) => {
                let Some(part) = self.whole(*receiver) else { return Cleared::nothing() };
                let is_known = match self.targets(id) {
                    Some(targets) if !targets.is_empty() => return self.cleared_by_call(id, args).below(&part),
                    _ => self.gives_anew(*receiver, method, args),
                };
                if is_known { Cleared::part(part) } else { Cleared::nothing() }
            }
            _ => Cleared::nothing(),
        }
    }

    /// The part that a place is all of.
    fn whole(&self, place: ExprId) -> Option<Part> {
        self.part(place).filter(|(_, is_whole)| *is_whole).map(|(part, _)| part)
    }

    /// Whether a method whose code is not read gives all of a value anew.
    fn gives_anew(&self, receiver: ExprId, method: &str, args: &[ExprId]) -> bool {
        let is_none = |arg: &ExprId| self.head(*arg).as_deref() == Some("0");
        let is_all = |arg: &ExprId| matches!(self.body.expr(*arg).kind, ExprKind::Range { start: None, end: None, .. });
        match (method, args) {
            ("truncate", [to]) => is_none(to),
            ("drain", [what]) => is_all(what),
            _ => match self.typed.ty(receiver).peel() {
                Ty::External(path, _) if !path.starts_with("std::") => !CHANGING.contains(&method),
                Ty::Unknown => !CHANGING.contains(&method),
                _ => CLEARING.contains(&method) && !(method == "insert" && args.len() > 1),
            },
        }
    }

    /// What a function clears that is lent parts of `self`: `mem::take(&mut self.low)`.
    fn cleared_by_function(&self, id: ExprId, args: &[ExprId]) -> Cleared {
        let ExprKind::Call { callee, .. } = &self.body.expr(id).kind else { return Cleared::nothing() };
        let name = match (self.typed.callees.get(&id), &self.body.expr(*callee).kind) {
            (Some(Callee::External(path)), _) => path.rsplit("::").next().unwrap_or_default(),
            (_, ExprKind::Path(path)) => path.last(),
            _ => "",
        };
        let is_lent = |arg: ExprId| {
            matches!(self.body.expr(arg).kind, ExprKind::Reference { mutable: true, .. })
                || matches!(self.typed.ty(arg), Ty::Ref(true, _))
        };
        let lent: Vec<(usize, Part)> = (0..)
            .zip(args)
            .filter_map(|(number, arg)| {
                let (part, is_whole) = self.part(*arg).filter(|_| is_lent(*arg))?;
                is_whole.then_some((number, part))
            })
            .collect();
        let mut found = Cleared::nothing();
        for (number, part) in &lent {
            let of = |target: &FunctionId| {
                let cleared = on_parameter(self.program, *target, *number, self.depth + 1)?.cleared();
                Some(cleared.below(part))
            };
            match self.targets(id).filter(|targets| !targets.is_empty()) {
                Some(targets) => {
                    found.add(targets.iter().filter_map(of).reduce(Cleared::common).unwrap_or(Cleared::nothing()));
                }
                None if name == "swap" && lent.len() > 1 => {}
                None if part.is_empty() && !matches!(name, "take" | "replace" | "swap") => {}
                None => found.add(Cleared::part(part.clone())),
            }
        }
        found
    }

    /// What a method clears that is called with these other arguments.
    fn cleared_by_call(&self, id: ExprId, args: &[ExprId]) -> Cleared {
        let heads: Vec<Option<Head>> = [None].into_iter().chain(args.iter().map(|arg| self.head(*arg))).collect();
        let of = |target: &FunctionId| Some(Self::new(self.program, *target, &heads, self.depth + 1)?.cleared());
        let called = self.targets(id).unwrap_or_default().iter().filter_map(of);
        called.reduce(Cleared::common).unwrap_or(Cleared::nothing())
    }

    /// What `*self = Self { … }` clears: not the fields that it takes over.
    fn made_anew(&self, value: ExprId, fields: &[(String, ExprId)], rest: Option<ExprId>) -> Cleared {
        let (kept, new): (Vec<_>, Vec<_>) =
            fields.iter().partition(|(name, value)| self.keeps(*value, std::slice::from_ref(name)));
        let keeps_rest = rest.is_some_and(|rest| match &self.body.expr(rest).kind {
            ExprKind::MethodCall { receiver, method, .. } => method == "clone" && self.is_self(*receiver),
            _ => self.is_self(rest),
        });
        if kept.is_empty() && !keeps_rest {
            return Cleared::Everything;
        }
        let mut cleared: BTreeSet<Part> = new.into_iter().map(|(name, _)| vec![name.clone()]).collect();
        if let Ty::Adt(id, _) = self.typed.ty(value).peel()
            && let Shape::Struct(all) = &self.program.index.type_def(*id).shape
            && !keeps_rest
        {
            let is_other = |name: &&String| !kept.iter().any(|(own, _)| own == *name);
            cleared.extend(all.fields.iter().map(|field| &field.name).filter(is_other).map(|name| vec![name.clone()]));
        }
        Cleared::Parts(cleared)
    }

    /// Whether a value is made of what a part was, or of what it lies in: `self.low * 0.9`.
    fn keeps(&self, value: ExprId, part: &[String]) -> bool {
        let any = |values: &[ExprId]| values.iter().any(|value| self.keeps(*value, part));
        match &self.body.expr(value).kind {
            ExprKind::Field { .. } | ExprKind::Index { .. } | ExprKind::Path(_) | ExprKind::Deref(_) => self
                .part(value)
                .is_some_and(|(own, _)| !own.is_empty() && (own.starts_with(part) || part.starts_with(&own))),
            ExprKind::Binary { lhs, rhs, .. } => any(&[*lhs, *rhs]),
            ExprKind::Negate(value) | ExprKind::Cast { value, .. } => self.keeps(*value, part),
            ExprKind::Struct { fields, rest, .. } => {
                fields.iter().any(|(_, value)| self.keeps(*value, part)) || any(rest.as_slice())
            }
            ExprKind::Tuple(values) | ExprKind::Call { args: values, .. } => any(values),
            ExprKind::MethodCall { receiver, method, .. } => {
                let is_number = matches!(self.typed.ty(*receiver).peel(), Ty::Int | Ty::Float);
                (is_number || method == "clone") && self.keeps(*receiver, part)
            }
            _ => false,
        }
    }
}
