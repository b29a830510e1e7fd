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

/// A row of a table: the name of each part, if it has one, and where it is written.
type Row = Vec<(Option<Head>, ExprId)>;

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
        let references = self.same_references(iterable);
        let is_lent = references.is_some();
        let lent = |elements: Vec<ExprId>| elements.into_iter().map(|element| vec![(pat, None, element)]).collect();
        let rounds: Option<Vec<Round>> = references.map(lent);
        let Some(rounds) = rounds.or_else(|| self.written_rounds(pat, iterable, inside)) else { return false };
        // A reference is made in its round.
        if !is_lent {
            self.expr(iterable);
        }
        self.write_out(label, keyword, inside, rounds, |this, parts: Round| {
            for (pat, head, from) in parts {
                let is_written = head.is_some();
                let value = if is_lent { this.expr(from) } else { Value { head, ..Value::default() } };
                this.bind_pattern(pat, &value);
                if is_written {
                    let vars = this.vars_of(pat);
                    this.graph.written_rows.extend(vars);
                }
                this.derive_pattern(pat, from);
            }
        });
        true
    }

    /// The rounds of a loop one behind another, each of which begins with what it binds.
    pub(super) fn write_out<T>(
        &mut self,
        label: Option<&String>,
        keyword: Span,
        inside: ExprId,
        rounds: impl IntoIterator<Item = T>,
        bind: impl Fn(&mut Self, T),
    ) {
        let after = self.add_node(Effect::Nothing, keyword);
        self.graph.written_out.push((keyword, self.span(inside)));
        for round in rounds {
            let again = self.add_node(Effect::Nothing, keyword);
            self.push_loop_scope(label, after, again, keyword);
            bind(self, round);
            self.expr(inside);
            self.pop_loop_scope();
            self.jump(again);
            self.resume_if_reached(again);
        }
        self.jump(after);
        self.resume_if_reached(after);
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

    /// The shared references in an array that is written where a loop goes over it, if two of them lead to one place: each round of
    /// that place is one more. `for port in [&self.bus, &self.bus] { port.borrow_mut().update(); }`
    fn same_references(&mut self, iterable: ExprId) -> Option<Vec<ExprId>> {
        let body = self.body();
        let elements = elements_in(self.constants(), plain_items(body, iterable))?.to_vec();
        let mut places = Vec::new();
        for element in &elements {
            let ExprKind::Reference { mutable: false, raw: false, value } = body.expr(*element).kind else {
                return None;
            };
            places.push(self.static_place(value).filter(|_| self.may_hold_filter(self.ty(value)))?);
        }
        let is_again = (1..places.len()).any(|at| places[..at].contains(&places[at]));
        is_again.then_some(elements)
    }

    /// What each round of such a loop binds.
    fn written_rounds(&mut self, pat: PatId, iterable: ExprId, inside: ExprId) -> Option<Vec<Round>> {
        if let PatKind::Reference(pat) = self.body().pat(pat).kind {
            return self.written_rounds(pat, iterable, inside);
        }
        if let (PatKind::Bind { .. }, [local]) = (&self.body().pat(pat).kind, self.locals_of(pat).as_slice()) {
            let heads = match self.names(iterable) {
                Some(heads) => Some(heads).filter(|_| self.selects(inside, *local)),
                None => self.numbers_of(iterable).filter(|numbers| self.chooses_by(inside, *local, numbers)),
            };
            return Some(heads?.into_iter().map(|head| vec![(pat, Some(head), iterable)]).collect());
        }
        let body = self.body();
        let PatKind::Tuple(pats) = &body.pat(pat).kind else { return None };
        if let ([left, right], ExprKind::MethodCall { receiver, method, args, .. }) =
            (pats.as_slice(), &body.expr(iterable).kind)
            && matches!(method.as_str(), "enumerate" | "zip")
        {
            return self.paired_rounds([*left, *right], iterable, *receiver, args.first().copied(), inside);
        }
        let rows = self.rows(iterable, pats.len())?;
        let round = |row: Row| pats.iter().zip(row).map(|(pat, (head, from))| (*pat, head, from)).collect::<Round>();
        let rounds: Vec<Round> = rows.into_iter().map(round).collect();
        let is_named = |at: usize| {
            let local = self.typed().pat_local.get(&pats[at]);
            local.is_some_and(|local| self.selects(inside, *local)) && rounds.iter().all(|round| round[at].1.is_some())
        };
        (0..pats.len()).any(is_named).then_some(rounds)
    }

    /// The same where each round has one of some names and its number, `for (i, axis) in Axis::ALL.iter().enumerate()`, or what stands
    /// beside the name: `Axis::ALL.iter().zip(readings)`.
    fn paired_rounds(
        &mut self,
        [left, right]: [PatId; 2],
        iterable: ExprId,
        items: ExprId,
        beside: Option<ExprId>,
        inside: ExprId,
    ) -> Option<Vec<Round>> {
        let body = self.body();
        let length = |this: &Self, id| match this.ty(plain_items(body, id)).peel() {
            Ty::Array(of, length) if !this.may_hold_filter(of) => length.value,
            _ => None,
        };
        let names = self.names(items);
        let count = match &names {
            Some(names) => u64::try_from(names.len()).ok(),
            None => length(self, items),
        };
        let count = count.filter(|count| *count <= MAX_ROUNDS)?;
        // What ends earlier ends the loop.
        let count = match beside {
            Some(beside) => length(self, beside)?.min(count),
            None => count,
        };
        let numbers: Vec<Head> = (0..count).map(|at| at.to_string()).collect();
        let (named, other) = if beside.is_some() { (left, right) } else { (right, left) };
        let local = |this: &Self, pat| match this.locals_of(pat).as_slice() {
            [local] => Some(*local),
            _ => None,
        };
        let by_name = names.is_some() && local(self, named).is_some_and(|local| self.selects(inside, local));
        let is_chosen = by_name
            || beside.is_none() && local(self, other).is_some_and(|local| self.chooses_by(inside, local, &numbers));
        let names = names.filter(|_| by_name);
        let name = |at: usize| names.as_ref().and_then(|names| names.get(at).cloned());
        let number = |number: Head| beside.is_none().then_some(number);
        let named = match self.body().pat(named).kind {
            PatKind::Reference(inner) => inner,
            _ => named,
        };
        let round = |(at, head): (usize, Head)| vec![(other, number(head), iterable), (named, name(at), iterable)];
        is_chosen.then(|| numbers.into_iter().enumerate().map(round).collect())
    }

    /// The rows of a table of so many columns without filters, written there, in a constant or in a static.
    fn rows(&self, iterable: ExprId, columns: usize) -> Option<Vec<Row>> {
        let own = self.constants();
        let items = plain_items(own.body, iterable);
        if let Some(Def::Value(value)) = own.typed.expr_def.get(&items) {
            let may_change = self.program.index.value(*value).item.is_mutable;
            let written = |own: Constants<'_>| rows_in(own, plain_items(own.body, own.body.root), columns);
            let mut rows = in_constant(self.program, *value, written).flatten().filter(|_| !may_change)?;
            // Where it is written is no place of this function.
            rows.iter_mut().flatten().for_each(|(_, part)| *part = iterable);
            return Some(rows);
        }
        let is_data = |(_, part): &(Option<Head>, ExprId)| !self.may_hold_filter(self.ty(*part));
        rows_in(own, items, columns).filter(|rows| rows.iter().flatten().all(is_data))
    }

    /// The names that a loop goes over: variants of an enum, texts or truth values, written there or in a constant.
    fn names(&self, iterable: ExprId) -> Option<Vec<Head>> {
        let own = self.constants();
        let items = plain_items(own.body, iterable);
        if let Some(Def::Value(value)) = own.typed.expr_def.get(&items) {
            let may_change = self.program.index.value(*value).item.is_mutable;
            let written = |own: Constants<'_>| names_in(own, plain_items(own.body, own.body.root));
            return in_constant(self.program, *value, written).flatten().filter(|_| !may_change);
        }
        let is_data = |elements: &&[ExprId]| !elements.iter().any(|element| self.may_hold_filter(self.ty(*element)));
        elements_in(own, items).filter(is_data).and_then(|_| names_in(own, items))
    }

    /// Whether a loop goes over a table without filters that is written there or in a constant: its rows are known, and followed where
    /// their parts have names.
    pub(super) fn is_table(&self, iterable: ExprId) -> bool {
        let own = self.constants();
        let items = plain_items(own.body, iterable);
        let is_written = match own.typed.expr_def.get(&items) {
            Some(Def::Value(value)) => !self.program.index.value(*value).item.is_mutable,
            _ => matches!(own.body.expr(items).kind, ExprKind::Array { is_vec: false, .. }),
        };
        is_written && !self.may_hold_filter(self.ty(items))
    }

    /// The first number and how many there are, if a loop goes over variants, written there or in a constant, whose numbers are in a
    /// row: `for axis in Axis::ALL { self.pids[axis as usize].update() }` counts as a range does.
    pub(super) fn row_of_variants(&self, iterable: ExprId) -> Option<(u64, u64)> {
        let own = self.constants();
        let items = plain_items(own.body, iterable);
        let Some(Def::Value(value)) = own.typed.expr_def.get(&items) else { return row_in(own, items) };
        let may_change = self.program.index.value(*value).item.is_mutable;
        let written = |own: Constants<'_>| row_in(own, plain_items(own.body, own.body.root));
        in_constant(self.program, *value, written).flatten().filter(|_| !may_change)
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
        let asks_truth = |condition: ExprId| match &body.expr(condition).kind {
            ExprKind::Not(value) => is_it(value),
            ExprKind::Binary { op: "&&" | "||", lhs, rhs } => is_it(lhs) || is_it(rhs),
            _ => is_it(&condition),
        };
        let asks = |id: &ExprId| match &body.expr(*id).kind {
            ExprKind::Match { scrutinee: asked, .. } | ExprKind::Let { value: asked, .. } => is_it(asked),
            ExprKind::Binary { op: "==" | "!=", lhs, rhs } => is_it(lhs) || is_it(rhs),
            ExprKind::If { condition, .. } => asks_truth(*condition),
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

/// The names in an array, if they are all variants, texts or truth values. Numbers are names only where each is asked for.
fn names_in(own: Constants<'_>, items: ExprId) -> Option<Vec<Head>> {
    let is_number = |id: &ExprId| matches!(own.body.expr(*id).kind, ExprKind::Literal(Literal::Int(..)));
    let name = |id: &ExprId| own.head(*id).filter(|_| names_one(own, *id) && !is_number(id));
    let elements = elements_in(own, items)?;
    elements.iter().map(name).collect::<Option<Vec<Head>>>().filter(|names| !names.is_empty())
}

/// The rows in an array of tuples of so many parts: the name of each part, if it has one.
fn rows_in(own: Constants<'_>, items: ExprId, columns: usize) -> Option<Vec<Row>> {
    let row = |element: &ExprId| match &own.body.expr(*element).kind {
        ExprKind::Tuple(parts) if parts.len() == columns => {
            let head = |part: ExprId| own.head(part).filter(|_| names_one(own, part));
            Some(parts.iter().map(|part| (head(*part), *part)).collect())
        }
        _ => None,
    };
    elements_in(own, items)?.iter().map(row).collect()
}

/// The elements of an array that is written out, if they are few.
fn elements_in<'a>(own: Constants<'a>, items: ExprId) -> Option<&'a [ExprId]> {
    let ExprKind::Array { elements, is_vec: false } = &own.body.expr(items).kind else { return None };
    u64::try_from(elements.len()).is_ok_and(|len| len <= MAX_ROUNDS).then_some(elements.as_slice())
}

/// Whether an expression is a variant, a number, a text or a truth value that is written out.
fn names_one(own: Constants<'_>, id: ExprId) -> bool {
    match &own.body.expr(id).kind {
        ExprKind::Literal(literal) => {
            matches!(literal, Literal::Str(_) | Literal::Char(_) | Literal::Bool(_) | Literal::Int(..))
        }
        ExprKind::Call { callee, .. } => names_one(own, *callee),
        _ => match own.typed.expr_def.get(&id) {
            Some(Def::Variant(..)) => true,
            Some(Def::External(path)) => matches!(path.rsplit("::").next(), Some("Some" | "None")),
            _ => false,
        },
    }
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
