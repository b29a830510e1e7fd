//! Loops over names, each of which selects something else: `for axis in [Axis::Roll, Axis::Pitch] { match axis { … } }` is its rounds
//! one behind another.

use super::constants::{Constants, in_constant};
use super::{Builder, ClosureRef, MAX_INLINE, Value};
use crate::flow::{Effect, Head};
use crate::index::{Def, FunctionId, Ty};
use crate::source::Span;
use crate::syntax::tree::{Body, ExprId, ExprKind, Literal, PatId, PatKind};
use crate::types::{Callee, LocalId};

/// How many rounds are written out.
const MAX_ROUNDS: u64 = 8;

/// What a round binds: each part with its name, if it has one, and what it is computed from.
type Round = Vec<(PatId, Option<Head>, ExprId)>;

impl Builder<'_> {
    /// Writes out a loop whose rounds have names, or numbers, by which its body selects what it works on; answers whether it is one.
    pub(super) fn unrolled(
        &mut self,
        label: Option<&String>,
        keyword: Span,
        pat: PatId,
        iterable: ExprId,
        inside: ExprId,
    ) -> bool {
        let Some(rounds) = self.written_rounds(pat, iterable, inside) else { return false };
        self.expr(iterable);
        let after = self.add_node(Effect::Nothing, keyword);
        self.graph.written_out.push(self.span(inside));
        for parts in rounds {
            let again = self.add_node(Effect::Nothing, keyword);
            self.push_loop_scope(label, after, again, keyword);
            for (pat, head, from) in parts {
                self.bind_pattern(pat, &Value { head, ..Value::default() });
                self.derive_pattern(pat, from);
            }
            self.expr(inside);
            self.pop_loop_scope();
            self.jump(again);
            self.resume_if_reached(again);
        }
        self.jump(after);
        self.resume_if_reached(after);
        true
    }

    /// The same for a closure that gets each name: `[Axis::Roll, Axis::Pitch].map(|axis| match axis { … })`. Answers whether it is one.
    pub(super) fn unrolled_closure(&mut self, id: ExprId, receiver: ExprId, method: &str, args: &[ExprId]) -> bool {
        let body = self.body();
        let [closure] = args else { return false };
        let ExprKind::Closure(code) = &body.expr(*closure).kind else { return false };
        let ([(pat, _)], "map" | "for_each") = (code.params.as_slice(), method) else { return false };
        if code.is_async || self.depth >= MAX_INLINE {
            return false;
        }
        let Some(rounds) = self.written_rounds(*pat, receiver, code.body) else { return false };
        self.expr(receiver);
        for parts in rounds {
            if let [(_, head, _)] = parts.as_slice() {
                let given = Value { head: head.clone(), ..Value::default() };
                self.inline_closure(ClosureRef { frame: self.frame, expr: *closure }, &[given], self.span(id));
            }
        }
        true
    }

    /// What each round of such a loop binds.
    fn written_rounds(&mut self, pat: PatId, iterable: ExprId, inside: ExprId) -> Option<Vec<Round>> {
        let locals = self.locals_of(pat);
        if let [local] = locals.as_slice() {
            let heads = match self.names(iterable) {
                Some(heads) => Some(heads).filter(|_| self.selects(inside, *local)),
                None => self.numbers_of(iterable).filter(|numbers| self.chooses_by(inside, *local, numbers)),
            };
            return Some(heads?.into_iter().map(|head| vec![(pat, Some(head), iterable)]).collect());
        }
        let body = self.body();
        let (PatKind::Tuple(pats), [first, _]) = (&body.pat(pat).kind, locals.as_slice()) else { return None };
        let [number, item] = pats.as_slice() else { return None };
        if let ExprKind::MethodCall { receiver, method, .. } = &body.expr(iterable).kind
            && method == "enumerate"
            && let Ty::Array(of, length) = self.ty(plain_items(body, *receiver)).peel()
        {
            let length = length.value.filter(|length| *length <= MAX_ROUNDS && !self.may_hold_filter(of))?;
            let numbers: Vec<Head> = (0..length).map(|at| at.to_string()).collect();
            let is_chosen = self.chooses_by(inside, *first, &numbers);
            let round = |at| vec![(*number, Some(at), iterable), (*item, None, iterable)];
            return is_chosen.then(|| numbers.into_iter().map(round).collect());
        }
        let ExprKind::Array { elements, is_vec: false } = &body.expr(plain_items(body, iterable)).kind else {
            return None;
        };
        let round = |element: &ExprId| match &body.expr(*element).kind {
            ExprKind::Tuple(parts)
                if parts.len() == pats.len() && !parts.iter().any(|part| self.may_hold_filter(self.ty(*part))) =>
            {
                let head = |part: ExprId| self.constants().head(part).filter(|_| self.names_one(part));
                Some(pats.iter().zip(parts).map(|(pat, part)| (*pat, head(*part), *part)).collect::<Round>())
            }
            _ => None,
        };
        let rounds: Vec<Round> = elements.iter().map(round).collect::<Option<_>>()?;
        let is_short = u64::try_from(rounds.len()).is_ok_and(|len| len <= MAX_ROUNDS);
        let is_named = |at: usize| {
            let local = self.typed().pat_local.get(&pats[at]);
            local.is_some_and(|local| self.selects(inside, *local)) && rounds.iter().all(|round| round[at].1.is_some())
        };
        (is_short && (0..pats.len()).any(is_named)).then_some(rounds)
    }

    /// Whether an expression is a variant or a text that is written out.
    fn names_one(&self, id: ExprId) -> bool {
        matches!(self.typed().expr_def.get(&id), Some(Def::Variant(..)))
            || matches!(self.body().expr(id).kind, ExprKind::Literal(Literal::Str(_) | Literal::Char(_)))
    }

    /// The names that a loop goes over: variants of an enum, written there or in a constant.
    fn names(&self, iterable: ExprId) -> Option<Vec<Head>> {
        let own = self.constants();
        let items = plain_items(own.body, iterable);
        if let Some(Def::Value(value)) = own.typed.expr_def.get(&items) {
            let is_static = self.program.index.value(*value).item.is_static;
            let written = |own: Constants<'_>| names_in(own, plain_items(own.body, own.body.root));
            return in_constant(self.program, *value, written).flatten().filter(|_| !is_static);
        }
        names_in(own, items)
    }

    /// The first number and how many there are, if a loop goes over variants, written there or in a constant, whose numbers are in a
    /// row: `for axis in Axis::ALL { self.pids[axis as usize].update() }` counts as a range does.
    pub(super) fn row_of_variants(&self, iterable: ExprId) -> Option<(u64, u64)> {
        let own = self.constants();
        let items = plain_items(own.body, iterable);
        let Some(Def::Value(value)) = own.typed.expr_def.get(&items) else { return row_in(own, items) };
        let is_static = self.program.index.value(*value).item.is_static;
        let written = |own: Constants<'_>| row_in(own, plain_items(own.body, own.body.root));
        in_constant(self.program, *value, written).flatten().filter(|_| !is_static)
    }

    /// The numbers of a range, or of an array of literals, as heads.
    fn numbers_of(&mut self, iterable: ExprId) -> Option<Vec<Head>> {
        let body = self.body();
        if let ExprKind::Array { elements, is_vec: false } = &body.expr(plain_items(body, iterable)).kind {
            let number = |id: &ExprId| match &body.expr(*id).kind {
                ExprKind::Literal(Literal::Int(Some(number), _)) => Some(number.to_string()),
                _ => None,
            };
            let is_short = u64::try_from(elements.len()).is_ok_and(|len| len <= MAX_ROUNDS);
            return elements.iter().map(number).collect::<Option<Vec<Head>>>().filter(|_| is_short);
        }
        let ExprKind::Range { start: Some(start), end: Some(end), inclusive } = self.body().expr(iterable).kind else {
            return None;
        };
        let (first, end) = (self.number(start)?, self.number(end)?);
        let numbers = first..end.checked_add(u64::from(inclusive))?;
        let is_short = numbers.end.saturating_sub(numbers.start) <= MAX_ROUNDS;
        is_short.then(|| numbers.map(|number| number.to_string()).collect())
    }

    /// Whether a body asks which name it has, or calls what asks it, and takes no element by it.
    fn selects(&self, inside: ExprId, local: LocalId) -> bool {
        let body = self.body();
        let all: Vec<ExprId> = body.within(inside).collect();
        let is_it = |id: &ExprId| self.typed().expr_local.get(&plain(body, *id)) == Some(&local);
        let is_index = |id: &ExprId| match &body.expr(*id).kind {
            ExprKind::Index { index, .. } => body.within(*index).any(|id| is_it(&id)),
            _ => false,
        };
        let asks = |id: &ExprId| match &body.expr(*id).kind {
            ExprKind::Match { scrutinee: asked, .. } | ExprKind::Let { value: asked, .. } => is_it(asked),
            ExprKind::Binary { op: "==" | "!=", lhs, rhs } => is_it(lhs) || is_it(rhs),
            ExprKind::MethodCall { args, .. } | ExprKind::Call { args, .. } => args.iter().any(|arg| {
                let Some(Callee::Resolved(resolved)) = self.typed().callees.get(id) else { return false };
                is_it(arg) && resolved.targets.iter().any(|target| self.asks_for(*target, self.ty(*arg)))
            }),
            _ => false,
        };
        !all.iter().any(is_index) && all.iter().any(asks)
    }

    /// Whether a function asks which of its names a parameter of this type is, and takes no element by one.
    fn asks_for(&self, target: FunctionId, ty: &Ty) -> bool {
        let (Some(body), Some(typed)) =
            (&self.program.index.function(target).function.body, self.program.typed(target))
        else {
            return false;
        };
        let is_it = |id: &ExprId| typed.expr_local.contains_key(id) && typed.ty(*id).peel() == ty.peel();
        let asks =
            |kind: &ExprKind| matches!(kind, ExprKind::Match { scrutinee, .. } if is_it(&plain(body, *scrutinee)));
        let takes =
            |kind: &ExprKind| matches!(kind, ExprKind::Index { index, .. } if body.within(*index).any(|id| is_it(&id)));
        body.exprs.iter().any(|expr| asks(&expr.kind)) && !body.exprs.iter().any(|expr| takes(&expr.kind))
    }
}

/// What is written as an array, where it is borrowed or made an iterator of.
fn plain_items(body: &Body, id: ExprId) -> ExprId {
    match &body.expr(id).kind {
        ExprKind::Reference { value, .. } => plain_items(body, *value),
        ExprKind::MethodCall { receiver, method, args, .. }
            if args.is_empty() && matches!(method.as_str(), "iter" | "into_iter" | "copied" | "cloned") =>
        {
            plain_items(body, *receiver)
        }
        _ => id,
    }
}

/// An expression without what only reads it.
pub(super) fn plain(body: &Body, id: ExprId) -> ExprId {
    match &body.expr(id).kind {
        ExprKind::Reference { value, .. } | ExprKind::Deref(value) => plain(body, *value),
        _ => id,
    }
}

/// The names in an array, if they are all variants.
fn names_in(own: Constants<'_>, items: ExprId) -> Option<Vec<Head>> {
    let ExprKind::Array { elements, is_vec: false } = &own.body.expr(items).kind else { return None };
    let name = |id: &ExprId| {
        let is_variant = matches!(own.typed.expr_def.get(id), Some(Def::Variant(..)));
        own.head(*id).filter(|_| is_variant)
    };
    let is_short = u64::try_from(elements.len()).is_ok_and(|len| len <= MAX_ROUNDS);
    elements.iter().map(name).collect::<Option<Vec<Head>>>().filter(|names| is_short && !names.is_empty())
}

/// The first number of the variants in an array, and how many they are, if each has the next number.
fn row_in(own: Constants<'_>, items: ExprId) -> Option<(u64, u64)> {
    let ExprKind::Array { elements, is_vec: false } = &own.body.expr(items).kind else { return None };
    let number = |id: &ExprId| match own.typed.expr_def.get(id)? {
        Def::Variant(ty, at) => own.program.index.variant_number(*ty, *at),
        _ => None,
    };
    let numbers: Vec<u64> = elements.iter().map(number).collect::<Option<_>>()?;
    let first = *numbers.first()?;
    let is_row = (first..).zip(&numbers).all(|(next, number)| next == *number);
    is_row.then_some((first, numbers.len() as u64))
}
