//! Values of `Copy` types: each name that one is given is another instance, unless it is put back where it came from.

use std::collections::BTreeSet;

use super::{Builder, ClosureRef, Value};
use crate::flow::{Assignment, Effect, NodeId, Place, Rounds, Transfer, Var};
use crate::index::Ty;
use crate::source::Span;
use crate::syntax::tree::{ExprId, ExprKind};

impl Builder<'_> {
    /// How the instances that a value of a type carries get to another place.
    pub(super) fn transfer(&self, value: &Value, ty: &Ty) -> Transfer {
        if !value.is_owned {
            return Transfer::Borrow;
        }
        // What a call gave back is there once.
        let is_result = || value.place.as_ref().and_then(Place::base_var).is_some_and(|var| self.is_result(var));
        match value.leaves_by {
            Some(leaves_by) => leaves_by,
            None if is_result() => Transfer::Move,
            None if value.place.is_some() && self.program.index.copies_filter(ty) => Transfer::Copy,
            None => Transfer::Move,
        }
    }

    /// Whether a variable holds what a law gave back, and has no name.
    fn is_result(&self, var: Var) -> bool {
        self.advanced.contains(&var) && self.graph.var(var).name.is_empty()
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
            if !self.program.index.copies_filter(&info.ty) {
                continue;
            }
            let copy = self.new_var(info.name.clone(), info.ty.clone(), info.span);
            self.set(copy, &Value { place: Some(Place::var(var)), is_owned: true, ..Value::default() }, span);
            copies.push((local, copy));
        }
        self.captures.insert((closure.frame, closure.expr), copies);
    }

    /// Tells copies that are put back from those that are instances of their own.
    pub(super) fn settle_copies(&mut self) {
        let copies: Vec<(NodeId, Var, Place)> = self
            .graph
            .node_ids()
            .filter_map(|id| match &self.graph.node(id).effect {
                Effect::Set(set) if set.transfer == Transfer::Copy => {
                    Some((id, set.place.base_var()?, set.from.clone()?))
                }
                _ => None,
            })
            .collect();
        let calls: Vec<(NodeId, usize, Var, Place)> = self
            .graph
            .node_ids()
            .filter_map(|id| match &self.graph.node(id).effect {
                Effect::Call(site) => Some((id, site)),
                _ => None,
            })
            .flat_map(|(id, site)| {
                // What is handed through goes on in the result.
                let handed = site.hands.as_ref().map(|(number, _)| *number);
                let copied =
                    site.args.iter().enumerate().filter(move |(number, arg)| arg.is_copy && Some(*number) != handed);
                copied.filter_map(move |(number, arg)| Some((id, number, site.result, arg.place.clone()?)))
            })
            .collect();
        if copies.is_empty() && calls.is_empty() {
            return;
        }
        let mut on_the_way = BTreeSet::new();
        for (_, var, from) in &copies {
            let way = self.way_back(*var, from);
            on_the_way.extend(way.filter(|way| self.is_changed(way)).into_iter().flatten());
        }
        for (id, number, result, from) in calls {
            let way = self.way_back(result, &from);
            if way.is_none()
                && let Effect::Call(site) = &mut self.graph.nodes[id.0 as usize].effect
            {
                // The function has a copy, and what it does with it is its own business.
                site.args[number].place = None;
            }
            on_the_way.extend(way.into_iter().flatten());
        }
        for node in &mut self.graph.nodes {
            let (Effect::Set(set) | Effect::Write(set)) = &mut node.effect else { continue };
            let ends = [set.place.base_var(), set.from.as_ref().and_then(Place::base_var)];
            if set.transfer == Transfer::Copy && ends.into_iter().flatten().any(|var| on_the_way.contains(&var)) {
                set.transfer = Transfer::RoundTrip;
            }
        }
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
    fn way_back(&self, start: Var, origin: &Place) -> Option<BTreeSet<Var>> {
        let mut way = BTreeSet::from([start]);
        let mut returns = false;
        loop {
            let before = way.len();
            for node in &self.graph.nodes {
                match &node.effect {
                    Effect::Set(set) | Effect::Write(set) => {
                        let from = set.from.as_ref().and_then(Place::base_var);
                        if !from.is_some_and(|from| way.contains(&from)) {
                            continue;
                        }
                        let is_origin = set.place.overlaps(origin);
                        returns |= is_origin;
                        // Another part of the same owner is a place of its own.
                        let is_beside = set.place.base == origin.base;
                        way.extend(set.place.base_var().filter(|_| !is_origin && !is_beside));
                    }
                    Effect::Call(site) => {
                        let gets = |arg: &crate::flow::Argument| {
                            let var = arg.place.as_ref().and_then(Place::base_var);
                            arg.is_copy && var.is_some_and(|var| way.contains(&var))
                        };
                        if site.args.iter().any(gets) {
                            way.insert(site.result);
                        }
                    }
                    _ => {}
                }
            }
            if way.len() == before {
                break;
            }
        }
        returns.then_some(way)
    }
}
