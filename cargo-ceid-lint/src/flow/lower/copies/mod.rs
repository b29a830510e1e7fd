//! Values of `Copy` types: each name that one is given is another instance, unless it is put back where it came from.

mod left_behind;

use std::collections::BTreeSet;

use super::{Builder, ClosureRef, Value};
use crate::flow::{Assignment, Cause, Effect, Node, NodeId, Place, Rounds, Transfer, Var};
use crate::index::{FunctionId, Ty};
use crate::source::Span;
use crate::syntax::tree::{ExprId, ExprKind};
use crate::types::LocalId;

/// How many nodes, with what holds the copy there, are looked at for one copy; beyond that it is not sure to go back.
const MAX_HOLDING: usize = 10_000;

/// How many nodes lie at most between a call and where what it gives gets a name.
const MAX_BEHIND_CALL: usize = 64;

impl Builder<'_> {
    /// How the instances that a value of a type carries get to another place.
    pub(super) fn transfer(&self, value: &Value, ty: &Ty) -> Transfer {
        if !value.is_owned {
            return Transfer::Borrow;
        }
        // What a call gave back is there once, but not what it gave back a reference to.
        let is_result = || {
            let place = value.place.as_ref();
            place.is_some_and(|place| place.base_var().is_some_and(|var| self.is_result(var)) && !self.is_lent(place))
        };
        match value.leaves_by {
            Some(leaves_by) => leaves_by,
            None if is_result() => Transfer::Move,
            None if value.place.is_some() && self.program.index.copies_filter(ty) => Transfer::Copy,
            // Both lead to the same from then on.
            None if matches!(ty, Ty::Pointer(_)) => Transfer::Borrow,
            None if self.program.index.refers_to_filters(ty) && self.program.index.is_copy(ty) => Transfer::Borrow,
            None => Transfer::Move,
        }
    }

    /// Whether a variable holds what a law or another call gave back, and has no name.
    fn is_result(&self, var: Var) -> bool {
        let is_given = |node: &Node| matches!(&node.effect, Effect::Call(site) if site.result == var);
        let last = || self.graph.nodes.iter().rev().take(MAX_BEHIND_CALL);
        self.graph.var(var).name.is_empty() && (self.advanced.contains(&var) || last().any(is_given))
    }

    /// Whether a value is all of what has no name, so that nothing has to do with it where it has gone.
    pub(super) fn is_in_between(&self, value: &Value) -> bool {
        let var = value.place.as_ref().filter(|place| place.steps.is_empty()).and_then(Place::base_var);
        let info = var.map(|var| self.graph.var(var));
        info.is_some_and(|info| info.name.is_empty() && info.param.is_none() && is_value(&info.ty))
    }

    /// What a function gives back of what it was only lent, if that is copied: `fn level(&self) -> Pt1 { self.level }`.
    pub(super) fn given_as_copy(&mut self, value: Value, span: Span) -> Value {
        let Some(var) = value.place.as_ref().and_then(Place::base_var).filter(|_| self.at.is_some()) else {
            return value;
        };
        // What has been taken out has left its place.
        let is_lent = match &self.graph.var(var).ty {
            Ty::Adt(..) | Ty::Tuple(_) | Ty::Array(..) => false,
            ty => !matches!(ty.external_name(), Some("Option" | "Result" | "Poll" | "Box")),
        };
        if !is_lent || !value.is_owned || value.leaves_by.is_some() {
            return value;
        }
        let index = self.program.index;
        let ty =
            index.lower(&index.function(self.graph.function).function.output, &index.scope_of(self.graph.function));
        if !index.copies_filter(&ty) {
            return value;
        }
        Value { head: value.head.clone(), same_as: value.same_as, ..self.copy_used(&value, ty, span) }
    }

    /// Notes that a filter is a template: others that live on begin with its state.
    pub(super) fn note_clone(&mut self, id: ExprId, receiver: ExprId, method: &str, args: &[ExprId]) {
        let is_repeated = self.loops.iter().any(|id| self.graph.loop_info(*id).rounds == Rounds::Unbounded);
        let is_kept = || {
            self.body().exprs.iter().any(|expr| match &expr.kind {
                ExprKind::Assign { value, .. } => *value == id,
                ExprKind::MethodCall { method, args, .. } => method.starts_with("push") && args.contains(&id),
                _ => false,
            })
        };
        if method == "clone"
            && (!is_repeated || is_kept())
            && args.is_empty()
            && self.may_hold_filter(self.ty(receiver))
            && !self.is_shared_handle(receiver)
            && let Some(place) = self.static_place(receiver)
        {
            self.graph.cloned.push(place);
        }
    }

    /// The same where a filter is copied into what a collection is given for good: `self.voices.push(Voice { lag: self.lag, age: 0 })`.
    pub(super) fn note_copied_into(&mut self, receiver: ExprId, method: &str, args: &[ExprId]) {
        let fills = method.starts_with("push") || matches!(method, "insert" | "resize" | "fill" | "extend" | "enqueue");
        if !fills || !self.may_hold_filter(self.ty(receiver).peel()) {
            return;
        }
        let mut open = args.to_vec();
        while let Some(id) = open.pop() {
            let body = self.body();
            match &body.expr(id).kind {
                ExprKind::Struct { fields, .. } => open.extend(fields.iter().map(|(_, value)| *value)),
                ExprKind::Tuple(parts)
                | ExprKind::Array { elements: parts, .. }
                | ExprKind::Call { args: parts, .. } => {
                    open.extend(parts);
                }
                ExprKind::Repeat { value, .. } => open.push(*value),
                ExprKind::Path(_) | ExprKind::Field { .. } if self.program.index.copies_filter(self.ty(id)) => {
                    let copied = self.static_place(id);
                    self.graph.cloned.extend(copied);
                }
                _ => {}
            }
        }
    }

    /// Another instance with the same state.
    pub(super) fn copy_of(&mut self, value: &Value, ty: Ty, span: Span) -> Value {
        let copy = self.temporary(ty, span);
        if let (Some(from), true) = (value.place.clone(), self.at.is_some()) {
            let place = Place::var(copy);
            let transfer = Transfer::Copy;
            let set = Assignment { place, from: Some(from), transfer, rebinds: true, head: None, same_as: None };
            self.emit(Effect::Set(Box::new(set)), span);
        }
        Value { place: Some(Place::var(copy)), is_owned: true, ..Value::default() }
    }

    /// What a collection gets of each element of another one: the element itself, or a copy or clone of what is only lent.
    pub(super) fn put_in_each(&mut self, method: &str, each: Value, from: ExprId) -> Value {
        if method == "append" {
            return Value { is_owned: true, leaves_by: Some(Transfer::Move), ..each };
        }
        match self.ty(from).peel().element().cloned() {
            Some(ty) if !each.is_owned && !self.program.index.may_share_filter(&ty) => {
                self.copy_of(&each, ty, self.span(from))
            }
            _ => each,
        }
    }

    /// Whether a value is a copy of another one, which is followed.
    pub(super) fn is_copy(&self, value: &Value) -> bool {
        let is_made = |node: &Node| matches!(&node.effect, Effect::Set(set) if set.transfer == Transfer::Copy && Some(&set.place) == value.place.as_ref());
        value.place.is_some() && self.graph.nodes.iter().any(is_made)
    }

    /// Each element gets a copy of its counterpart.
    pub(super) fn write_copy(&mut self, to: &Value, from: &Value, span: Span) {
        let (Some(place), true) = (to.place.clone(), self.at.is_some()) else { return };
        let (from, transfer) = (from.place.clone(), Transfer::Copy);
        let write = Assignment { place, from, transfer, rebinds: false, head: None, same_as: None };
        self.emit(Effect::Write(Box::new(write)), span);
    }

    /// What is taken out of a wrapper that stays where it is: another instance, if the type is copied.
    pub(super) fn copied_out(&mut self, id: ExprId, wrapper: ExprId, content: Value) -> Value {
        let ty = self.ty(id).clone();
        let is_place = matches!(
            self.body().expr(wrapper).kind,
            ExprKind::Path(_) | ExprKind::Field { .. } | ExprKind::Index { .. } | ExprKind::Deref(_)
        );
        if !is_place || content.place.is_none() || self.at.is_none() || self.transfer(&content, &ty) != Transfer::Copy {
            return content;
        }
        self.copy_used(&content, ty, self.span(id))
    }

    /// Another instance with the state of one that is read for it.
    pub(super) fn copy_used(&mut self, value: &Value, ty: Ty, span: Span) -> Value {
        if let (Some(place), true) = (value.place.clone(), self.at.is_some()) {
            self.emit(Effect::Use { place }, span);
        }
        self.copy_of(value, ty, span)
    }

    /// What a getter gives of a filter by value, a copy or a clone of its field: `fn filter(&self) -> Pt1 { self.filter }`.
    pub(super) fn copy_given(&mut self, id: ExprId, owner: Option<&Place>) -> Option<Value> {
        let (owner, ty) = (owner?, self.ty(id).clone());
        if matches!(ty, Ty::Ref(..)) || self.program.index.law_spec(&ty).is_none() {
            return None;
        }
        let field = self.field_given(id).filter(|field| field.is_cloned || self.program.index.copies_filter(&ty))?;
        let place = field.names.iter().fold(owner.clone(), |place, name| place.field(name));
        let value = Value { place: Some(place), is_owned: true, ..Value::default() };
        let span = self.span(id);
        Some(if field.is_cloned { self.copy_of(&value, ty, span) } else { self.copy_used(&value, ty, span) })
    }

    /// What a function gives of a filter that it is lent, by value: a copy or a clone of it, on which it may have gone on:
    /// `fn stepped(&self) -> Pt1 { let mut next = *self; next.update(); next }`.
    pub(super) fn clone_given(
        &mut self,
        id: ExprId,
        targets: &[FunctionId],
        exprs: &[ExprId],
        values: &[Value],
    ) -> Option<Value> {
        let [target] = targets else { return None };
        let ty = self.ty(id).clone();
        self.program.index.filter_spec(&ty)?;
        let function = &self.program.index.function(*target).function;
        let (body, typed) = (function.body.as_ref()?, self.program.typed(*target)?);
        let is_lent = |(number, expr): &(usize, &ExprId)| {
            let param = body.params.get(*number).and_then(|param| typed.pat_local.get(param));
            let is_reference =
                |local: &LocalId| matches!(&typed.locals[local.0 as usize].ty, Ty::Ref(_, inner) if **inner == ty);
            param.is_some_and(is_reference) && self.ty(**expr).peel() == &ty && values[*number].place.is_some()
        };
        let (number, _) = exprs.iter().enumerate().find(is_lent)?;
        let param = typed.pat_local.get(&body.params[number])?;
        let is_it = |expr: ExprId| typed.expr_local.get(&expr) == Some(param);
        let is_copied = self.program.index.copies_filter(&ty);
        let is_clone = |expr: ExprId| match &body.expr(expr).kind {
            ExprKind::Deref(inner) => is_copied && is_it(*inner),
            ExprKind::MethodCall { receiver, method, args, .. } => {
                method == "clone" && args.is_empty() && is_it(*receiver)
            }
            _ => false,
        };
        // What is written behind the reference, or read there, is no copy.
        let is_place = |expr: ExprId| {
            body.exprs.iter().any(|around| match &around.kind {
                ExprKind::Assign { place, .. } | ExprKind::AssignOp { place, .. } => *place == expr,
                ExprKind::Field { base, .. } => *base == expr,
                ExprKind::MethodCall { receiver, .. } => *receiver == expr,
                ExprKind::Reference { value, .. } => *value == expr,
                _ => false,
            })
        };
        let all = || (0u32..).map(ExprId).take(body.exprs.len());
        if !all().any(|expr| is_clone(expr) && !is_place(expr)) {
            return None;
        }
        let goes_on = |expr: ExprId| {
            let (args, receiver) = match &body.expr(expr).kind {
                ExprKind::MethodCall { receiver, args, .. } => (args, Some(receiver)),
                ExprKind::Call { args, .. } => (args, None),
                _ => return false,
            };
            let others = receiver.into_iter().chain(args).filter(|arg| !is_it(**arg));
            !is_clone(expr) && others.into_iter().any(|arg| typed.ty(*arg).peel() == &ty)
        };
        let span = self.span(id);
        let copy = self.copy_of(&Value { is_owned: true, ..values[number].clone() }, ty.clone(), span);
        if let Some(place) = copy.place.clone().filter(|_| all().any(goes_on)) {
            let cause = Cause::Code(format!("what `{}` does to the copy that it gives back", self.text(id)));
            self.emit(Effect::Unknown { places: vec![place], cause }, span);
        }
        Some(copy)
    }

    /// The copies that a `move` closure takes of what it names: it goes on with them from call to call.
    pub(super) fn copy_captured(&mut self, closure: ClosureRef, span: Span) {
        let body = self.body();
        let ExprKind::Closure(code) = &body.expr(closure.expr).kind else { return };
        if !code.is_move || self.captures.contains_key(&(closure.frame, closure.expr)) {
            return;
        }
        let mut copies = Vec::new();
        for (local, var) in self.captured_locals(closure) {
            let info = self.graph.var(var);
            // What only the closure names goes along with it.
            let is_only_there = info.param.is_some() && info.in_loop == self.loops.last().copied();
            if !self.program.index.copies_filter(&info.ty) || is_only_there && self.is_only_named_in(local, closure) {
                continue;
            }
            let copy = self.new_var(info.name.clone(), info.ty.clone(), info.span);
            self.set(copy, &Value { place: Some(Place::var(var)), is_owned: true, ..Value::default() }, span);
            copies.push((local, copy));
        }
        self.captures.insert((closure.frame, closure.expr), copies);
    }

    /// Whether a local is named nowhere but in a closure of the same body.
    fn is_only_named_in(&self, local: LocalId, closure: ClosureRef) -> bool {
        let (body, around) = (self.body(), self.span(closure.expr));
        let mut named = self.typed().expr_local.iter().filter(|(_, named)| **named == local);
        named.all(|(id, _)| around.contains(body.expr(*id).span))
    }

    /// Tells copies that are put back, or stand in for what is not asked for again, from those that are instances of their own.
    pub(super) fn settle_copies(&mut self) {
        self.settle_left_behind();
        self.keep_saved();
        self.keep_parts();
        let copies: Vec<(NodeId, Var, Place)> = self
            .graph
            .node_ids()
            .filter_map(|id| match &self.graph.node(id).effect {
                Effect::Set(set) if set.transfer == Transfer::Copy || self.takes_copied(set) => {
                    Some((id, set.place.base_var()?, set.from.clone()?))
                }
                _ => None,
            })
            .collect();
        if copies.is_empty() {
            return;
        }
        let mut on_the_way = BTreeSet::new();
        let mut origins = BTreeSet::new();
        for (id, var, from) in &copies {
            let Some(way) = self.way_back(*id, *var, from) else { continue };
            if self.is_changed(&way) || self.lends_elements(&way) && !self.loses_elements(&way, from) {
                origins.insert(from.base);
                origins.extend(self.lent_again(from));
                on_the_way.extend(way);
            } else {
                self.keep_unchanged(*id, &way, from);
            }
        }
        for node in &mut self.graph.nodes {
            let (Effect::Set(set) | Effect::Write(set)) = &mut node.effect else { continue };
            if set.transfer != Transfer::Copy {
                continue;
            }
            // A copy that leaves the way is another instance.
            let is_on = |place: &Place| place.base_var().is_some_and(|var| on_the_way.contains(&var));
            let ends = [Some(&set.place), set.from.as_ref()].map(|end| end.is_some_and(is_on));
            let is_end = |place: &Place| is_on(place) || origins.contains(&place.base);
            if ends.contains(&true) && is_end(&set.place) && set.from.as_ref().is_some_and(is_end) {
                set.transfer = Transfer::RoundTrip;
            }
        }
        for node in &mut self.graph.nodes {
            let Effect::Call(site) = &mut node.effect else { continue };
            let handed = site.hands.as_ref().map(|(number, _)| *number);
            let given = site.args.iter_mut().enumerate().filter(|(number, arg)| arg.is_copy && Some(*number) != handed);
            for (_, arg) in given {
                // What a function does with a copy of its own is its own business.
                arg.place =
                    arg.place.take().filter(|place| place.base_var().is_some_and(|var| on_the_way.contains(&var)));
            }
        }
    }

    /// Whether what is taken out of its place would be copied by every other name: `let mut lag = self.lag.take().unwrap();`
    fn takes_copied(&self, set: &Assignment) -> bool {
        let into = set.place.base_var().filter(|_| set.place.steps.is_empty() && set.transfer == Transfer::Move);
        into.is_some_and(|var| self.program.index.copies_filter(&self.graph.var(var).ty))
    }

    /// Whether something may update what one of the variables holds.
    fn is_changed(&self, vars: &BTreeSet<Var>) -> bool {
        let is_one = |place: &Place| place.base_var().is_some_and(|var| vars.contains(&var));
        self.graph.nodes.iter().any(|node| match &node.effect {
            Effect::Update(update) => update.given.is_none() && is_one(&update.place),
            Effect::Call(site) => {
                let handed = site.hands.as_ref().map(|(number, _)| *number);
                let lent = site
                    .args
                    .iter()
                    .enumerate()
                    .filter(|(number, arg)| !(arg.is_shared || arg.is_moved && Some(*number) == handed));
                lent.filter_map(|(_, arg)| arg.place.as_ref()).any(is_one)
            }
            Effect::Unknown { places, .. } => places.iter().any(is_one),
            Effect::Set(set) => set.transfer == Transfer::Borrow && set.from.as_ref().is_some_and(is_one),
            _ => false,
        })
    }

    /// The variables through which what a variable holds gets back to a place; `None` if it does not.
    fn way_back(&self, copied_at: NodeId, start: Var, origin: &Place) -> Option<BTreeSet<Var>> {
        // What is copied in a loop is put back in it.
        let made_in = self.graph.node(copied_at).in_loop;
        let is_after = |node: &Node| made_in.is_none_or(|made_in| self.graph.is_within(node.in_loop, made_in));
        let mut reached = BTreeSet::from([start]);
        // From which variable to which other one, or to the origin.
        let mut steps: BTreeSet<(Var, Option<Var>)> = BTreeSet::new();
        loop {
            let before = steps.len();
            for node in &self.graph.nodes {
                match &node.effect {
                    Effect::Set(set) | Effect::Write(set) => {
                        let from = set.from.as_ref().and_then(Place::base_var);
                        let Some(from) = from.filter(|from| reached.contains(from)) else { continue };
                        if set.place.overlaps(origin)
                            || self.is_element_of(&set.place, origin)
                            || self.is_lent_again(&set.place, origin)
                        {
                            steps.extend(is_after(node).then_some((from, None)));
                        } else if set.place.base != origin.base {
                            // Another part of the same owner is a place of its own.
                            steps.extend(set.place.base_var().map(|to| (from, Some(to))));
                        }
                    }
                    Effect::Call(site) => {
                        let given = site.args.iter().filter(|arg| arg.is_copy || arg.is_moved);
                        let copied = given.filter_map(|arg| arg.place.as_ref());
                        let given = copied.filter_map(Place::base_var).filter(|var| reached.contains(var));
                        steps.extend(given.map(|from| (from, Some(site.result))));
                    }
                    _ => {}
                }
            }
            for (item, source) in self.graph.loops.iter().flat_map(|info| &info.items) {
                let from = source.base_var().filter(|from| reached.contains(from));
                steps.extend(from.map(|from| (from, Some(*item))));
            }
            reached.extend(steps.iter().filter_map(|(_, to)| *to));
            if steps.len() == before {
                break;
            }
        }
        let mut way: BTreeSet<Var> = BTreeSet::new();
        loop {
            let before = way.len();
            let leads_on = |(_, to): &&(Var, Option<Var>)| to.is_none_or(|to| way.contains(&to));
            let more: Vec<Var> = steps.iter().filter(leads_on).map(|(from, _)| *from).collect();
            way.extend(more);
            if way.len() == before {
                break;
            }
        }
        way.contains(&start).then_some(way)
    }
}

/// Whether a value of the type has in it what it holds, and is no way to something else.
fn is_value(ty: &Ty) -> bool {
    matches!(ty, Ty::Adt(..) | Ty::Tuple(_)) || ty.external_name() == Some("Option")
}
