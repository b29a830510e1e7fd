//! Samples that the rounds of a loop take by their number, and what they fill at it.

use std::collections::BTreeSet;

use super::Builder;
use crate::flow::{Computed, LoopId, Place, Var};
use crate::index::Ty;
use crate::syntax::tree::{Body, ExprId, ExprKind, StmtKind};

impl Builder<'_> {
    /// Notes what is asked for something by the counter of a loop, `input.at(i)`, `input[first + i]`, `level_at(input, i)`.
    pub(super) fn note_sampled(&mut self, this_loop: LoopId, inside: ExprId) {
        let Some((counter, _)) = self.graph.loop_info(this_loop).counter else { return };
        let tree = self.body();
        // What only tells something the number asks for nothing, and fills nothing.
        let told: BTreeSet<ExprId> = tree
            .stmts()
            .filter_map(|stmt| match &stmt.kind {
                StmtKind::Expr { expr, .. } => Some(*expr),
                StmtKind::Let { .. } => None,
            })
            .filter(|expr| self.filling(*expr).is_none())
            .collect();
        for id in tree.within(inside).rev() {
            let (asked, numbers) = match &tree.expr(id).kind {
                ExprKind::MethodCall { .. } | ExprKind::Call { .. } if told.contains(&id) => continue,
                ExprKind::MethodCall { receiver, args, .. } => (std::slice::from_ref(receiver), &args[..]),
                ExprKind::Call { args, .. } => (&args[..], &args[..]),
                ExprKind::Index { base, index } => (std::slice::from_ref(base), std::slice::from_ref(index)),
                _ => continue,
            };
            if !numbers.iter().any(|number| self.is_numbered_by(*number, counter)) {
                continue;
            }
            for asked in asked {
                let is_plain = matches!(self.ty(*asked).peel(), Ty::Int | Ty::Float | Ty::Bool);
                if let Some(place) = self.static_place(*asked).filter(|_| !is_plain) {
                    let owners = self.owners_of_item(*asked, inside);
                    self.graph.loops[this_loop.0 as usize].sampled.extend(owners.into_iter().chain([place]));
                }
            }
        }
    }

    /// What a statement fills at the number of a round, and with what: `out.write(i, gain * level)`, `put(&mut out, i, level)`.
    fn filling(&self, statement: ExprId) -> Option<(ExprId, Vec<ExprId>)> {
        let (receiver, args) = match &self.body().expr(statement).kind {
            ExprKind::MethodCall { receiver, args, .. } => (receiver, &args[..]),
            ExprKind::Call { args, .. } => {
                let is_lent = |arg: &ExprId| matches!(self.ty(*arg), Ty::Ref(true, _));
                let lent = args.iter().position(is_lent)?;
                let filled = match &self.body().expr(args[lent]).kind {
                    ExprKind::Reference { value, .. } => value,
                    _ => &args[lent],
                };
                (filled, &args[lent + 1..])
            }
            _ => return None,
        };
        // Where each round has an item, its number is that of the item.
        let counters = || self.graph.loops.iter().filter(|info| info.items.is_empty()).filter_map(|info| info.counter);
        let (numbers, values): (Vec<ExprId>, Vec<ExprId>) =
            args.iter().partition(|arg| counters().any(|(counter, _)| self.counts_with(**arg, counter)));
        (!numbers.is_empty() && !values.is_empty()).then_some((*receiver, values))
    }

    /// The variables that a statement fills at the number of a round; they are noted as computed from what they are filled with.
    pub(super) fn filled_by(&mut self, statement: ExprId) -> Vec<Var> {
        let Some((receiver, values)) = self.filling(statement) else { return Vec::new() };
        let filled = self.assigned_vars(receiver);
        for value in values {
            self.derive(&filled, value);
        }
        filled
    }

    /// Notes the collections whose elements the rounds of a loop get to write.
    pub(super) fn note_lent_to_rounds(&mut self, this_loop: LoopId, iterable: ExprId) {
        let tree = self.body();
        for id in tree.within(iterable).rev() {
            let lent = match &tree.expr(id).kind {
                ExprKind::MethodCall { receiver, method, .. } if method == "iter_mut" => *receiver,
                ExprKind::Reference { value, mutable: true, .. } => *value,
                _ => continue,
            };
            let place = self.static_place(lent);
            self.graph.loops[this_loop.0 as usize].filled.extend(place);
        }
    }

    /// Notes that a method puts values into a collection, or takes all out of it: `self.frame.push(channel[i])`.
    pub(super) fn note_put_into(&mut self, method: &str, collection: ExprId, values: &[ExprId]) {
        let overwrites = method == "copy_from_slice";
        let fills = overwrites || matches!(method, "push" | "push_back" | "extend" | "extend_from_slice");
        let empties = overwrites || method == "clear";
        let Some((place, node)) =
            self.at.filter(|_| fills || empties).and_then(|at| Some((self.static_place(collection)?, at)))
        else {
            return;
        };
        if empties {
            self.graph.emptied.push((node, place.clone()));
        }
        if fills {
            let mut from = Computed::default();
            for value in values {
                let computed = self.computed_from(*value);
                from.places.extend(computed.places);
                from.calls.extend(computed.calls);
            }
            self.graph.filled.push((node, place, from));
        }
    }

    /// Notes what is computed for a call, or for whoever calls a closure, from several things: `out.push(x * gain)`.
    pub(super) fn note_mixed(&mut self, id: ExprId) {
        if let Some(at) = self.at.filter(|_| is_mixed(self.body(), id, 0)) {
            let computed = self.computed_from(id);
            self.graph.mixed.push((at, self.span(id), computed));
        }
    }

    /// Notes what a call gets with the memory of samples that it is lent to write: `frame.fill(level)`, `put(sample, level)`.
    pub(super) fn note_put_into_sample(&mut self, id: ExprId, given: &[ExprId]) {
        let Some(at) = self.at.filter(|_| given.len() > 1) else { return };
        if !given.iter().any(|expr| matches!(self.ty(*expr), Ty::Ref(true, memory) if holds_numbers(memory))) {
            return;
        }
        let mut all = Computed::default();
        for expr in given {
            let computed = self.computed_from(*expr);
            all.places.extend(computed.places);
            all.calls.extend(computed.calls);
        }
        self.graph.mixed.push((at, self.span(id), all));
    }

    /// What an item that a closure gets is one of: the channels in `channels.iter().map(|channel| channel[i])`.
    fn owners_of_item(&mut self, item: ExprId, inside: ExprId) -> Vec<Place> {
        let tree = self.body();
        let mut owners = Vec::new();
        let mut open: Vec<ExprId> = self.receiver_of_closure(item, inside).into_iter().collect();
        while let Some(at) = open.pop() {
            match (&tree.expr(at).kind, self.static_place(at)) {
                (_, Some(place)) => {
                    owners
                        .extend(Some(place).filter(|_| !matches!(self.ty(at).peel(), Ty::Int | Ty::Float | Ty::Bool)));
                    open.extend(self.receiver_of_closure(at, inside));
                }
                (ExprKind::MethodCall { receiver, args, .. }, None) => open.extend(args.iter().chain([receiver])),
                _ => {}
            }
        }
        owners
    }

    /// What the method is called on that gets the closure to whose parameters a name belongs.
    fn receiver_of_closure(&self, named: ExprId, inside: ExprId) -> Option<ExprId> {
        let tree = self.body();
        let mut at = named;
        while let ExprKind::Field { base: inner, .. }
        | ExprKind::Index { base: inner, .. }
        | ExprKind::Deref(inner)
        | ExprKind::Reference { value: inner, .. } = &tree.expr(at).kind
        {
            at = *inner;
        }
        let declared = self.typed().local(*self.typed().expr_local.get(&at)?).span;
        let binds = |arg: &ExprId| match &tree.expr(*arg).kind {
            ExprKind::Closure(code) => code.params.iter().any(|(pat, _)| tree.pat(*pat).span.contains(declared)),
            _ => false,
        };
        tree.within(inside).rev().find_map(|id| match &tree.expr(id).kind {
            ExprKind::MethodCall { receiver, args, .. } if args.iter().any(binds) => Some(*receiver),
            _ => None,
        })
    }

    /// Whether an expression is a number that a counter gives, turned round, by a name, or among those of several channels:
    /// `let behind = -((LAST - i) as isize);`, `frame * channels + channel`.
    fn is_numbered_by(&self, id: ExprId, counter: Var) -> bool {
        let given = match &self.body().expr(id).kind {
            ExprKind::Negate(value) | ExprKind::Cast { value, .. } => vec![*value],
            ExprKind::Binary { op: "+" | "-" | "*" | "<<", lhs, rhs } => vec![*lhs, *rhs],
            ExprKind::Path(_) if *self.ty(id) == Ty::Int => self.constants().initial(id).into_iter().collect(),
            _ => Vec::new(),
        };
        self.counts_with(id, counter) || given.into_iter().any(|given| self.is_numbered_by(given, counter))
    }

    /// Whether an expression is a counter, a number away from it, or a window that begins or ends so: `frame[i..i + 4]`.
    pub(super) fn counts_with(&self, id: ExprId, counter: Var) -> bool {
        match &self.body().expr(id).kind {
            ExprKind::Path(_) => {
                let local = self.typed().expr_local.get(&id);
                local.and_then(|local| self.frames[self.frame].vars.get(local)) == Some(&counter)
            }
            ExprKind::Cast { value, .. } | ExprKind::Reference { value, .. } => self.counts_with(*value, counter),
            ExprKind::Binary { op: "+" | "-", lhs, rhs } => {
                self.counts_with(*lhs, counter) || self.counts_with(*rhs, counter)
            }
            ExprKind::Range { start, end, .. } => start.iter().chain(end).any(|end| self.counts_with(*end, counter)),
            _ => false,
        }
    }
}

/// How deep operators and arrays are looked into.
const MAX_OPERATORS: u32 = 8;

/// Whether a type is a number, or several of them in a row.
fn holds_numbers(ty: &Ty) -> bool {
    match ty {
        Ty::Int | Ty::Float => true,
        Ty::Array(each, _) | Ty::Slice(each) => holds_numbers(each),
        _ => false,
    }
}

/// Whether something is computed by an operator, or by what is called on a number.
fn is_mixed(body: &Body, id: ExprId, depth: u32) -> bool {
    let next = |id: ExprId| depth < MAX_OPERATORS && is_mixed(body, id, depth + 1);
    match &body.expr(id).kind {
        ExprKind::Binary { op, .. } => matches!(*op, "+" | "-" | "*" | "/"),
        ExprKind::MethodCall { receiver, method, args, .. } => {
            matches!(method.as_str(), "mul_add" | "mul" | "add" | "sub") && !args.is_empty() || next(*receiver)
        }
        ExprKind::Reference { value, .. } | ExprKind::Cast { value, .. } => next(*value),
        ExprKind::Negate(value) => next(*value),
        ExprKind::Array { elements, .. } => elements.iter().any(|element| next(*element)),
        ExprKind::Tuple(parts) => parts.iter().any(|part| next(*part)),
        ExprKind::Block(block) => block.tail.is_some_and(next),
        _ => false,
    }
}
