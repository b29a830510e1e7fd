//! Slices that are split: each element is in one of the parts.

use super::{Builder, Value};
use crate::flow::{About, Assignment, Cause, Effect, IndexKey, Place, Transfer, Var};
use crate::index::Ty;
use crate::syntax::tree::{ExprId, ExprKind};

/// Arrays up to this length are followed element by element.
const MAX_ELEMENTS: u64 = 64;

impl Builder<'_> {
    /// `split_at_mut`, `split_first_mut`, `split_last_mut`: the parts as a tuple.
    pub(super) fn split(
        &mut self,
        id: ExprId,
        receiver: ExprId,
        method: &str,
        args: &[ExprId],
        value: &Value,
    ) -> Value {
        for arg in args {
            self.expr(*arg);
        }
        let (Some(place), true) = (value.place.clone(), self.may_hold_filter(self.ty(receiver))) else {
            return Value::default();
        };
        let length = match self.ty(receiver).peel() {
            Ty::Array(_, length) => length.value.filter(|length| *length <= MAX_ELEMENTS),
            _ => None,
        };
        let single = method != "split_at_mut";
        let middle = match method {
            "split_first_mut" => Some(1),
            "split_last_mut" => length.and_then(|length| length.checked_sub(1)),
            _ => args.first().and_then(|arg| self.number(*arg)),
        };
        let span = self.span(id);
        let parts = self.temporary(self.ty(id).clone(), span);
        // What they were in an earlier round is forgotten.
        self.set(parts, &Value::default(), span);
        match (length, middle) {
            (Some(length), Some(middle)) if middle <= length => {
                for number in 0..length {
                    let is_low = number < middle;
                    // The single element stands first, whichever end it comes from.
                    let is_single = single && (is_low == (method == "split_first_mut"));
                    let part = if single { u64::from(!is_single) } else { u64::from(!is_low) };
                    let mut to = Place::var(parts).field(&part.to_string());
                    if !is_single {
                        to = to.element(IndexKey::Number(if is_low { number } else { number - middle }));
                    }
                    self.lend(to, place.element(IndexKey::Number(number)), id);
                }
            }
            // Which part an element is in is not known: it is in exactly one of them.
            _ if !(self.has_numbered_parts(id) || single && self.goes_on_with_rest(receiver)) => {
                let about = About { is_constant: true, ..About::default() };
                let (first, second) = self.opaque_branch(span, self.text(id), about);
                let after = self.add_node(Effect::Nothing, span);
                let low = if single { place.element(IndexKey::Each) } else { place.clone() };
                for (node, part, from) in [(first, "0", low), (second, "1", place)] {
                    self.resume(node);
                    self.lend(Place::var(parts).field(part), from, id);
                    self.jump(after);
                }
                self.resume(after);
            }
            _ => {
                let cause = Cause::Index(self.text(id));
                self.emit(Effect::Unknown { places: vec![place], cause }, span);
                return Value::default();
            }
        }
        Value { place: Some(Place::var(parts)), is_owned: true, ..Value::default() }
    }

    /// `bank.get_disjoint_mut([0, 2])`: the elements of these numbers; `None` if one of them is not written out.
    pub(super) fn lent_disjoint(&mut self, id: ExprId, args: &[ExprId], value: &Value) -> Option<Value> {
        let ([numbers], Some(bank)) = (args, value.place.clone()) else { return None };
        let ExprKind::Array { elements, is_vec: false } = &self.body().expr(*numbers).kind else { return None };
        let numbers: Vec<u64> = elements.iter().map(|number| self.number(*number)).collect::<Option<_>>()?;
        let span = self.span(id);
        let parts = self.temporary(self.ty(id).clone(), span);
        // What they were in an earlier round is forgotten.
        self.set(parts, &Value::default(), span);
        for (at, number) in (0u64..).zip(numbers) {
            let part = Place::var(parts).element(IndexKey::Number(at));
            self.lend(part, bank.element(IndexKey::Number(number)), id);
        }
        Some(Value { place: Some(Place::var(parts)), ..Value::default() })
    }

    fn lend(&mut self, place: Place, from: Place, at: ExprId) {
        let set = Assignment {
            place,
            from: Some(from),
            transfer: Transfer::Borrow,
            rebinds: true,
            head: None,
            same_as: None,
        };
        self.emit(Effect::Set(Box::new(set)), self.span(at));
    }

    /// Whether a loop goes through a slice by its rest: `while let Some((first, rest)) = all.split_first_mut() { …; all = rest; }`.
    fn goes_on_with_rest(&self, receiver: ExprId) -> bool {
        let typed = self.typed();
        let own = typed.expr_local.get(&receiver).filter(|_| !self.loops.is_empty());
        own.is_some_and(|own| {
            self.body().exprs.iter().any(
                |expr| matches!(&expr.kind, ExprKind::Assign { place, .. } if typed.expr_local.get(place) == Some(own)),
            )
        })
    }

    /// Whether an element of a part is named by its index somewhere, so that it matters where the parts begin.
    fn has_numbered_parts(&mut self, split: ExprId) -> bool {
        let targets: Vec<Var> = self.targets.clone();
        let body = self.body();
        let typed = self.typed();
        let indexed: Vec<_> = body
            .exprs
            .iter()
            .filter_map(|expr| match &expr.kind {
                ExprKind::Index { base, .. } => typed.expr_local.get(base).copied(),
                _ => None,
            })
            .collect();
        let is_named = indexed.into_iter().any(|local| targets.contains(&self.var_of(local)));
        // What is not bound by a `let` may be indexed under a name that is not known here.
        let is_indexed_at_once = body.exprs.iter().any(|expr| match &expr.kind {
            ExprKind::Index { base, .. } => body.expr(*base).span.contains(body.expr(split).span),
            _ => false,
        });
        is_named || is_indexed_at_once
    }
}
