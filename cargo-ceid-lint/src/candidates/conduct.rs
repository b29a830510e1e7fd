//! What a method does with the fields of its type: which it writes, which of those it computes from their old values.

use std::collections::{BTreeMap, BTreeSet};

use super::measured::is_measured;
use super::uses::loops;
use super::words::is_among;
use crate::flow::{Program, is_time_name};
use crate::index::{FunctionId, Index, Ty};
use crate::syntax::tree::{BlockKind, Body, ExprId, ExprKind, PatId, PatKind, Receiver, StmtKind};
use crate::types::{Callee, TypedBody};

/// How deep helpers of the same type are followed.
const MOST_HELPERS: u32 = 4;

/// What a method does with the fields of `self`.
#[derive(Clone, Debug, Default)]
pub(super) struct Conduct {
    /// The fields that it reads.
    pub(super) read: BTreeSet<String>,
    /// The fields that it writes.
    pub(super) written: BTreeSet<String>,
    /// Whether it writes `*self` as a whole.
    pub(super) writes_all: bool,
    /// Whether it reads `*self` as a whole.
    pub(super) reads_all: bool,
    /// How many sums and products of numbers that are not counts it computes.
    pub(super) sums: usize,
    /// The fields to which something is added that is not constant.
    pub(super) accumulated: BTreeSet<String>,
    /// The fields that say which element of another one is meant.
    pub(super) positions: BTreeSet<String>,
    /// Methods called on fields.
    pub(super) calls: Vec<FieldCall>,
    /// The methods of `self` that it calls.
    pub(super) helpers: BTreeSet<FunctionId>,
    /// Those that it calls in a loop.
    pub(super) rounds: BTreeSet<FunctionId>,
    /// Those that each call of it calls.
    pub(super) always: BTreeSet<FunctionId>,
    /// Whether it awaits, or reads text.
    pub(super) is_foreign: bool,
    /// Whether it reads a clock.
    pub(super) reads_clock: bool,
}

/// A method called on a field.
#[derive(Clone, Debug)]
pub(super) struct FieldCall {
    pub(super) field: String,
    /// The type behind references of what it is called on.
    pub(super) ty: Ty,
    pub(super) method: String,
    /// The bodies that may run.
    pub(super) targets: Vec<FunctionId>,
    /// Whether it is given a time step that lies in a parameter: `input.iteration_time`.
    pub(super) is_told_step: bool,
}

impl Conduct {
    fn merge(&mut self, other: Self) {
        self.read.extend(other.read);
        self.written.extend(other.written);
        self.writes_all |= other.writes_all;
        self.sums += other.sums;
        self.accumulated.extend(other.accumulated);
        self.positions.extend(other.positions);
        self.calls.extend(other.calls);
        self.is_foreign |= other.is_foreign;
        self.reads_clock |= other.reads_clock;
    }

    /// The fields that it writes and whose old values it reads.
    pub(super) fn carried(&self) -> impl Iterator<Item = &String> {
        self.written.intersection(&self.read)
    }
}

/// What a function does with the fields behind one of its variables.
pub(super) fn conduct_on(program: &Program<'_>, id: FunctionId, local: u32) -> Conduct {
    let def = program.index.function(id);
    let (Some(body), Some(typed)) = (&def.function.body, program.typed(id)) else { return Conduct::default() };
    Reader::new(program.index, body, typed, Some(local)).read()
}

/// What a method does, its helpers included.
pub(super) fn conduct(program: &Program<'_>, id: FunctionId) -> Conduct {
    let mut open = BTreeSet::new();
    with_helpers(program, id, 0, &mut open)
}

fn with_helpers(program: &Program<'_>, id: FunctionId, depth: u32, open: &mut BTreeSet<FunctionId>) -> Conduct {
    let def = program.index.function(id);
    let (Some(body), Some(typed)) = (&def.function.body, program.typed(id)) else { return Conduct::default() };
    if depth > MOST_HELPERS || !open.insert(id) {
        return Conduct::default();
    }
    let is_self = |local: &crate::types::Local| local.name == "self";
    let receiver = typed.locals.iter().position(is_self).and_then(|at| u32::try_from(at).ok());
    let mut conduct = Reader::new(program.index, body, typed, receiver).read();
    for helper in conduct.helpers.clone() {
        conduct.merge(with_helpers(program, helper, depth + 1, open));
    }
    conduct
}

pub(super) struct Reader<'a> {
    index: &'a Index,
    pub(super) body: &'a Body,
    pub(super) typed: &'a TypedBody,
    self_local: Option<u32>,
    /// Variables that are a part of a field: `let z = &mut self.z`, `for tap in &mut self.taps`.
    pub(super) aliases: BTreeMap<u32, String>,
    /// What each of them was bound to as a whole, or element by element; the field itself where `self` was taken apart. Of those that
    /// are parts, nothing.
    pub(super) alias_of: BTreeMap<u32, Option<ExprId>>,
}

impl<'a> Reader<'a> {
    /// The reader of a method.
    pub(super) fn of(program: &'a Program<'a>, id: FunctionId) -> Option<Self> {
        let body = program.index.function(id).function.body.as_ref()?;
        let typed = program.typed(id)?;
        let receiver = typed.locals.iter().position(|local| local.name == "self");
        Some(Self::new(program.index, body, typed, receiver.and_then(|at| u32::try_from(at).ok())))
    }

    fn new(index: &'a Index, body: &'a Body, typed: &'a TypedBody, self_local: Option<u32>) -> Self {
        let mut reader = Self { index, body, typed, self_local, aliases: BTreeMap::new(), alias_of: BTreeMap::new() };
        reader.find_aliases();
        reader
    }

    pub(super) fn is_self(&self, expr: ExprId) -> bool {
        let local = self.typed.expr_local.get(&expr).map(|local| local.0);
        let is_self = local.is_some() && local == self.self_local;
        is_self || matches!(&self.body.expr(expr).kind, ExprKind::Deref(inner) if self.is_self(*inner))
    }

    /// The field of `self` that a place lies in.
    pub(super) fn field(&self, expr: ExprId) -> Option<String> {
        let mut at = expr;
        loop {
            if let Some(alias) = self.typed.expr_local.get(&at).and_then(|local| self.aliases.get(&local.0)) {
                return Some(alias.clone());
            }
            match &self.body.expr(at).kind {
                ExprKind::Field { base, name } if self.is_self(*base) => return Some(name.clone()),
                ExprKind::Field { base, .. } | ExprKind::Index { base, .. } => at = *base,
                ExprKind::Deref(inner) | ExprKind::Reference { value: inner, .. } | ExprKind::Try(inner) => at = *inner,
                ExprKind::MethodCall { receiver, .. } => at = *receiver,
                _ => return None,
            }
        }
    }

    fn find_aliases(&mut self) {
        let body = self.body;
        for _ in 0..2 {
            for expr in &body.exprs {
                match &expr.kind {
                    ExprKind::Block(block) => {
                        for stmt in &block.stmts {
                            if let StmtKind::Let { pat, init: Some(init), .. } = &stmt.kind {
                                self.add_alias(*pat, *init);
                            }
                        }
                    }
                    ExprKind::Let { pat, value } => self.add_alias(*pat, *value),
                    ExprKind::For { pat, iterable, .. } => self.add_alias(*pat, *iterable),
                    ExprKind::Match { scrutinee, arms } => {
                        arms.iter().for_each(|arm| self.add_alias(arm.pat, *scrutinee));
                    }
                    ExprKind::MethodCall { receiver, args, .. } => {
                        for arg in args {
                            if let ExprKind::Closure(closure) = &body.expr(*arg).kind
                                && is_handing_on(self.body, *receiver)
                            {
                                closure.params.iter().for_each(|(pat, _)| self.add_alias(*pat, *receiver));
                            }
                        }
                    }
                    _ => {}
                }
            }
        }
    }

    /// The names in a pattern stand for the field that the value is a part of, if they can write it.
    fn add_alias(&mut self, pat: PatId, value: ExprId) {
        if self.is_self(value) {
            if let PatKind::Struct(_, fields) = &self.body.pat(pat).kind {
                for (field, own) in fields {
                    self.bind(*own, field, Some(None));
                }
            }
            return;
        }
        if is_handing_on(self.body, value)
            && let Some(field) = self.field(value)
        {
            self.bind(pat, &field, Some(Some(value)));
        }
    }

    /// Binds the names in a pattern to a field, and to the value that they are all of, if they are.
    fn bind(&mut self, pat: PatId, field: &str, value: Option<Option<ExprId>>) {
        match &self.body.pat(pat).kind {
            PatKind::Bind { sub, .. } => {
                if let Some(local) = self.typed.pat_local.get(&pat) {
                    self.aliases.insert(local.0, field.to_owned());
                    self.alias_of.extend(value.map(|value| (local.0, value)));
                }
                if let Some(sub) = sub {
                    self.bind(*sub, field, value);
                }
            }
            PatKind::Tuple(parts) => {
                let is_numbered = matches!(value, Some(Some(value)) if self.is_enumerated(value));
                parts.iter().for_each(|part| self.bind(*part, field, value.filter(|_| is_numbered)));
            }
            PatKind::TupleStruct(_, parts) if parts.len() == 1 => self.bind(parts[0], field, value),
            PatKind::Or(parts) => parts.iter().for_each(|part| self.bind(*part, field, value)),
            PatKind::TupleStruct(_, parts) | PatKind::Slice(parts) => {
                parts.iter().for_each(|part| self.bind(*part, field, None));
            }
            PatKind::Struct(_, parts) => parts.iter().for_each(|(_, part)| self.bind(*part, field, None)),
            PatKind::Reference(inner) => self.bind(*inner, field, value),
            _ => {}
        }
    }

    fn is_enumerated(&self, value: ExprId) -> bool {
        matches!(&self.body.expr(value).kind, ExprKind::MethodCall { method, .. } if method == "enumerate")
    }

    fn read(&self) -> Conduct {
        let mut conduct = Conduct::default();
        // What is assigned to is written, and not read, by that mention of it.
        let mut only_written: BTreeSet<ExprId> = BTreeSet::new();
        for expr in &self.body.exprs {
            if let ExprKind::Assign { place, .. } = &expr.kind {
                self.place_parts(*place, &mut only_written);
            }
        }
        for (number, expr) in (0u32..).zip(&self.body.exprs) {
            let id = ExprId(number);
            match &expr.kind {
                ExprKind::Field { base, name } if self.is_self(*base) && !only_written.contains(&id) => {
                    conduct.read.insert(name.clone());
                }
                ExprKind::Deref(inner) if self.is_self(*inner) && !only_written.contains(&id) => {
                    conduct.reads_all = true;
                }
                ExprKind::Index { index, .. } => {
                    conduct.positions.extend(self.body.within(*index).filter_map(|id| self.field(id)));
                }
                ExprKind::Path(_) if !only_written.contains(&id) => {
                    conduct.read.extend(self.field(id));
                }
                ExprKind::Assign { place, value } => {
                    self.assign(*place, &mut conduct);
                    conduct.sums += usize::from(self.is_kept_in_line(*place, *value));
                    conduct.accumulated.extend(self.field(*place).filter(|field| self.adds_to(field, *value)));
                }
                ExprKind::AssignOp { op, place, value } => {
                    self.assign(*place, &mut conduct);
                    if is_sum(op) && !self.is_constant(*value) {
                        conduct.sums += usize::from(self.is_measured(*place));
                        conduct.accumulated.extend(self.field(*place));
                    }
                }
                ExprKind::Binary { op, lhs, rhs }
                    if is_sum(op) && (self.is_measured(*lhs) || self.is_measured(*rhs)) =>
                {
                    conduct.sums += 1;
                }
                ExprKind::Reference { mutable: true, value, .. } => {
                    conduct.written.extend(self.field(*value));
                }
                ExprKind::MethodCall { receiver, method, args, .. } => {
                    self.method(id, *receiver, method, args, &mut conduct);
                }
                ExprKind::Call { .. } => {
                    if let Some(Callee::External(path)) = self.typed.callees.get(&id)
                        && path.ends_with("Instant::now")
                    {
                        conduct.reads_clock = true;
                    }
                }
                ExprKind::Await(_) => conduct.is_foreign = true,
                ExprKind::Block(block) if block.kind == BlockKind::Async => conduct.is_foreign = true,
                _ => {}
            }
        }
        conduct
    }

    fn place_parts(&self, place: ExprId, parts: &mut BTreeSet<ExprId>) {
        let mut at = place;
        loop {
            parts.insert(at);
            at = match &self.body.expr(at).kind {
                ExprKind::Field { base, .. } => *base,
                ExprKind::Deref(inner) => *inner,
                ExprKind::Index { base, .. } => *base,
                ExprKind::Tuple(all) => {
                    all.iter().for_each(|part| self.place_parts(*part, parts));
                    return;
                }
                _ => return,
            };
        }
    }

    fn assign(&self, place: ExprId, conduct: &mut Conduct) {
        if let ExprKind::Tuple(parts) = &self.body.expr(place).kind {
            parts.iter().for_each(|part| self.assign(*part, conduct));
            return;
        }
        if matches!(&self.body.expr(place).kind, ExprKind::Deref(inner) if self.is_self(*inner)) {
            conduct.writes_all = true;
        }
        conduct.written.extend(self.field(place));
    }

    fn method(&self, id: ExprId, receiver: ExprId, method: &str, args: &[ExprId], conduct: &mut Conduct) {
        let resolved = match self.typed.callees.get(&id) {
            Some(Callee::Resolved(resolved)) => Some(resolved),
            _ => None,
        };
        let is_exclusive = resolved.map(|resolved| {
            let takes = |id: &FunctionId| self.index.function(*id).function.receiver == Some(Receiver::Exclusive);
            resolved.targets.iter().any(takes)
        });
        if self.is_self(receiver) {
            if let Some(resolved) = resolved.filter(|resolved| resolved.targets.len() == 1) {
                conduct.helpers.extend(resolved.targets.iter().copied());
                let span = self.body.expr(id).span;
                if loops(self.body).iter().any(|own| own.contains(span)) {
                    conduct.rounds.extend(resolved.targets.iter().copied());
                }
                if self.is_always_run(id) {
                    conduct.always.extend(resolved.targets.iter().copied());
                }
            }
            return;
        }
        let Some(field) = self.field(receiver) else { return };
        let writes = is_exclusive.unwrap_or_else(|| is_among(MUTATING, method));
        if writes {
            conduct.written.insert(field.clone());
        }
        if is_among(KEEPING, method) && !args.is_empty() {
            // A line of old samples: what is pushed now is read in a later call.
            conduct.sums += usize::from(args.iter().any(|arg| self.is_measured(*arg)));
        }
        if method == "elapsed" || method == "now" {
            conduct.reads_clock = true;
        }
        let ty = self.typed.ty(receiver).peel().clone();
        let targets = resolved.map(|resolved| resolved.targets.clone()).unwrap_or_default();
        let is_told_step = args.iter().any(|arg| self.is_step_of_parameter(*arg));
        conduct.calls.push(FieldCall { field, ty, method: method.to_owned(), targets, is_told_step });
    }

    /// Whether each call of the function comes to an expression: nothing chooses whether it is run, and nothing leaves before.
    fn is_always_run(&self, id: ExprId) -> bool {
        let leaves = |kind: &ExprKind| matches!(kind, ExprKind::Return(_) | ExprKind::Try(_));
        if self.body.exprs.iter().any(|expr| leaves(&expr.kind)) {
            return false;
        }
        let mut open = vec![self.body.root];
        while let Some(at) = open.pop() {
            match &self.body.expr(at).kind {
                _ if at == id => return true,
                ExprKind::Block(_) | ExprKind::MethodCall { .. } | ExprKind::Call { .. } | ExprKind::Assign { .. } => {
                    open.extend(self.body.children(at));
                }
                _ => {}
            }
        }
        false
    }

    /// Whether an expression is a field of a parameter that is named as a time step.
    fn is_step_of_parameter(&self, expr: ExprId) -> bool {
        let ExprKind::Field { name, base } = &self.body.expr(expr).kind else { return false };
        let mut at = *base;
        while let ExprKind::Field { base, .. } | ExprKind::Deref(base) = &self.body.expr(at).kind {
            at = *base;
        }
        let local = self.typed.expr_local.get(&at);
        let is_parameter = self.body.params.iter().any(|pat| self.typed.pat_local.get(pat) == local);
        is_time_name(name) && local.is_some() && is_parameter && !self.is_self(at)
    }

    /// Whether a sample is put where the line of old samples is written now: `self.line[self.head] = x`.
    fn is_kept_in_line(&self, place: ExprId, value: ExprId) -> bool {
        let ExprKind::Index { base, index } = &self.body.expr(place).kind else { return false };
        self.field(*base).is_some() && self.is_own_field(*index) && self.is_measured(place) && !self.is_constant(value)
    }

    /// Whether an expression is a field with something added that is not constant: `self.sum + x - self.oldest`.
    fn adds_to(&self, field: &String, expr: ExprId) -> bool {
        let ExprKind::Binary { op, lhs, rhs } = &self.body.expr(expr).kind else { return false };
        let is_it = self.field(*lhs).as_ref() == Some(field) && self.is_own_field(*lhs);
        is_sum(op) && ((is_it && !self.is_constant(*rhs)) || self.adds_to(field, *lhs))
    }

    fn is_own_field(&self, expr: ExprId) -> bool {
        matches!(&self.body.expr(expr).kind, ExprKind::Field { base, .. } if self.is_self(*base))
    }

    /// Whether an expression is a number that is no count: a float, a vector, a value of a generic type.
    fn is_measured(&self, expr: ExprId) -> bool {
        is_measured(self.index, self.typed.ty(expr), 0)
    }

    fn is_constant(&self, expr: ExprId) -> bool {
        matches!(self.body.expr(expr).kind, ExprKind::Literal(_))
    }
}

fn is_sum(op: &str) -> bool {
    matches!(op, "+" | "-" | "*" | "/")
}

/// Whether an expression hands on a part of what it is made of: `&mut x`, `x.iter_mut()`, `x.as_mut()`.
fn is_handing_on(body: &Body, expr: ExprId) -> bool {
    match &body.expr(expr).kind {
        ExprKind::Reference { mutable, .. } => *mutable,
        ExprKind::MethodCall { receiver, method, .. } => {
            method.ends_with("_mut") || method == "borrow" || method == "lock" || is_handing_on(body, *receiver)
        }
        ExprKind::Try(inner) | ExprKind::Deref(inner) => is_handing_on(body, *inner),
        // A `match` or `if let` on a field of `&mut self` binds by reference.
        ExprKind::Field { .. } => true,
        _ => false,
    }
}

/// Methods of containers and cells that keep what they are given for a later call.
const KEEPING: &str = "\
    push push_back push_front push_overwrite push_back_overwriting write insert rotate_left rotate_right \
    copy_within enqueue replace";

/// Methods of the standard library and of other containers that write their receiver. `get_or_insert` is none of them: what it has
/// put there once it leaves alone, unless the place that it gives is written.
const MUTATING: &str = "\
    push push_back push_front push_overwrite pop pop_front pop_back insert remove clear rotate_left \
    rotate_right swap fill take replace copy_from copy_from_slice copy_within set store fetch_add fetch_sub truncate \
    resize write enqueue dequeue extend retain update next";
