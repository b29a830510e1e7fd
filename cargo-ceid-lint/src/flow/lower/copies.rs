//! Values of `Copy` types: each name that one is given is another instance, unless it is put back where it came from.

use std::collections::BTreeSet;

use super::{Builder, ClosureRef, Value};
use crate::flow::{Assignment, Cause, Effect, IndexKey, Node, NodeId, Place, Projection, Rounds, Transfer, Var};
use crate::index::Ty;
use crate::source::Span;
use crate::syntax::tree::{ExprId, ExprKind};

/// How many nodes, with what holds the copy there, are looked at for one copy; beyond that it is not sure to go back.
const MAX_HOLDING: usize = 10_000;

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

    /// Tells copies that are put back, or stand in for what is not asked for again, from those that are instances of their own.
    pub(super) fn settle_copies(&mut self) {
        self.settle_parts_of_params();
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
        let mut origins = BTreeSet::new();
        for (id, var, from) in &copies {
            let way = self.way_back(*id, *var, from);
            let is_changed = |this: &mut Self, way: &BTreeSet<Var>| {
                this.is_changed(way) || this.lends_elements(way) && !this.loses_elements(way, from)
            };
            let way = way.filter(|way| is_changed(self, way));
            if way.is_some() {
                origins.insert(from.base);
            }
            on_the_way.extend(way.into_iter().flatten());
        }
        for (id, number, result, from) in calls {
            let way = self.way_back(id, result, &from);
            let way = way.filter(|way| self.surely_goes_back(id, way, &from));
            if way.is_some() {
                origins.insert(from.base);
            }
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
    }

    /// Whether what is taken out of its place would be copied by every other name: `let mut lag = self.lag.take().unwrap();`
    fn takes_copied(&self, set: &Assignment) -> bool {
        let into = set.place.base_var().filter(|_| set.place.steps.is_empty() && set.transfer == Transfer::Move);
        into.is_some_and(|var| self.program.index.copies_filter(&self.graph.var(var).ty))
    }

    /// What is copied out of a parameter that was passed by value is moved if nothing asks for the parameter's own again:
    /// `let Estimator { mut lag, pi } = self; …; Estimator { lag, pi }`.
    fn settle_parts_of_params(&mut self) {
        let is_owned = |var: &Var| matches!(self.graph.var(*var).ty, Ty::Adt(..) | Ty::Tuple(_));
        let mut holding: BTreeSet<Var> = self.graph.params.iter().copied().filter(is_owned).collect();
        let mut has_moved = true;
        while std::mem::take(&mut has_moved) {
            for id in self.graph.node_ids() {
                let Some(into) = self.part_left_behind(id, &holding) else { continue };
                if let Effect::Set(set) | Effect::Write(set) = &mut self.graph.nodes[id.0 as usize].effect {
                    set.transfer = Transfer::Move;
                }
                has_moved |= holding.insert(into);
            }
        }
    }

    /// The variable that a node gives a copy of a part of one of these, if nothing asks for the part again.
    fn part_left_behind(&self, id: NodeId, holding: &BTreeSet<Var>) -> Option<Var> {
        let (Effect::Set(set) | Effect::Write(set)) = &self.graph.node(id).effect else { return None };
        let from = set.from.as_ref().filter(|from| from.base_var().is_some_and(|var| holding.contains(&var)))?;
        let into = set.place.base_var().filter(|_| set.transfer == Transfer::Copy)?;
        (self.lies_inside(from) && self.is_left_behind(id, from)).then_some(into)
    }

    /// Whether a place is a variable or lies in one, and not behind a reference or handle in it.
    fn lies_inside(&self, place: &Place) -> bool {
        let Some(var) = place.base_var() else { return false };
        let mut steps = place.steps.iter().map(|step| match step {
            Projection::Field(name) => Some(&**name),
            _ => None,
        });
        let ty = steps.try_fold(self.graph.var(var).ty.clone(), |ty, name| match ty {
            Ty::Tuple(parts) => parts.get(name?.parse::<usize>().ok()?).cloned(),
            owner => self.program.index.field_ty(&owner, None, name?),
        });
        matches!(ty, Some(Ty::Adt(..) | Ty::Tuple(_)))
    }

    /// Whether nothing behind a node that reads a place has to do with that place again, and nothing refers to it.
    fn is_left_behind(&self, read_at: NodeId, place: &Place) -> bool {
        let is_it = |other: &Place| other.overlaps(place);
        let refers = |set: &Assignment| set.transfer == Transfer::Borrow && set.from.as_ref().is_some_and(is_it);
        let is_lent = |node: &Node| matches!(&node.effect, Effect::Set(set) | Effect::Write(set) if refers(set));
        let concerns = |node: &Node| match &node.effect {
            Effect::Use { place } | Effect::Reset { place, .. } => is_it(place),
            Effect::Update(update) => is_it(&update.place),
            Effect::Advance(advance) => is_it(&advance.before) || is_it(&advance.after),
            Effect::Set(set) | Effect::Write(set) => is_it(&set.place) || set.from.as_ref().is_some_and(is_it),
            Effect::Call(site) => site.args.iter().filter_map(|arg| arg.place.as_ref()).any(is_it),
            Effect::Unknown { places, .. } => places.iter().any(is_it),
            Effect::Return(value) => value.place.as_ref().is_some_and(is_it),
            _ => false,
        };
        if self.graph.nodes.iter().any(is_lent) {
            return false;
        }
        let mut seen = BTreeSet::new();
        let mut open = self.graph.node(read_at).next.clone();
        while let Some(id) = open.pop().filter(|_| seen.len() < MAX_HOLDING) {
            if !seen.insert(id) {
                continue;
            }
            if concerns(self.graph.node(id)) {
                return false;
            }
            open.extend(&self.graph.node(id).next);
        }
        seen.len() < MAX_HOLDING
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
                        if set.place.overlaps(origin) || self.is_element_of(&set.place, origin) {
                            steps.extend(is_after(node).then_some((from, None)));
                        } else if set.place.base != origin.base {
                            // Another part of the same owner is a place of its own.
                            steps.extend(set.place.base_var().map(|to| (from, Some(to))));
                        }
                    }
                    Effect::Call(site) => {
                        let copied = site.args.iter().filter(|arg| arg.is_copy).filter_map(|arg| arg.place.as_ref());
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

    /// Whether each way from a call on puts back to a place what the call gave, by one of the variables, before the copy is made
    /// again. Notes where it is put back if only some do.
    fn surely_goes_back(&mut self, call: NodeId, vars: &BTreeSet<Var>, origin: &Place) -> bool {
        let Effect::Call(site) = &self.graph.node(call).effect else { return false };
        let var_of = |place: &Place| place.base_var().filter(|var| vars.contains(var));
        let goes_back = |node: &Node| match &node.effect {
            Effect::Set(set) | Effect::Write(set) => {
                set.place.overlaps(origin) && set.from.as_ref().and_then(var_of).is_some()
            }
            _ => false,
        };
        let back: Vec<NodeId> = self.graph.node_ids().filter(|id| goes_back(self.graph.node(*id))).collect();
        let mut seen = BTreeSet::new();
        let mut open: Vec<_> =
            self.graph.node(call).next.iter().map(|id| (*id, BTreeSet::from([site.result]))).collect();
        let mut is_sure = true;
        while let Some((id, mut holding)) = open.pop() {
            let node = self.graph.node(id);
            if !seen.insert((id, holding.clone())) {
                continue;
            }
            let (given, taken) = match &node.effect {
                Effect::Set(set) | Effect::Write(set) => {
                    let is_given = set.from.as_ref().and_then(var_of).is_some_and(|var| holding.contains(&var));
                    if is_given && set.place.overlaps(origin) {
                        continue;
                    }
                    (is_given, var_of(&set.place))
                }
                Effect::Call(site) => {
                    let copied = site.args.iter().filter(|arg| arg.is_copy).filter_map(|arg| arg.place.as_ref());
                    let mut copied = copied.filter_map(var_of);
                    (copied.any(|var| holding.contains(&var)), Some(site.result).filter(|var| vars.contains(var)))
                }
                _ => (false, None),
            };
            if let Some(taken) = taken {
                if given {
                    holding.insert(taken)
                } else {
                    holding.remove(&taken)
                };
            }
            is_sure &= id != call && !matches!(node.effect, Effect::Return(_)) && seen.len() < MAX_HOLDING;
            if !is_sure {
                break;
            }
            open.extend(node.next.iter().map(|next| (*next, holding.clone())));
        }
        for id in back.into_iter().filter(|_| !is_sure) {
            self.lose_put_back(id, "a copy that a call gets, and that only some paths put back");
        }
        is_sure
    }

    /// What is put back at a node is not followed.
    fn lose_put_back(&mut self, id: NodeId, what: &str) {
        let node = &mut self.graph.nodes[id.0 as usize];
        let (Effect::Set(set) | Effect::Write(set)) = &node.effect else { return };
        let places = std::iter::once(&set.place).chain(&set.from).cloned().collect();
        node.effect = Effect::Unknown { places, cause: Cause::Code(what.to_owned()) };
    }

    /// Whether a place is what a loop binds of a place.
    fn is_element_of(&self, place: &Place, origin: &Place) -> bool {
        let mut items = self.graph.loops.iter().flat_map(|info| &info.items);
        items.any(|(item, source)| place.base_var() == Some(*item) && source.overlaps(origin))
    }

    /// Whether a loop lends the elements of what one of the variables holds.
    fn lends_elements(&self, vars: &BTreeSet<Var>) -> bool {
        let mut sources = self.graph.loops.iter().flat_map(|info| &info.items).map(|(_, source)| source);
        sources.any(|source| source.base_var().is_some_and(|var| vars.contains(&var)))
    }

    /// Notes where single elements are put back of a copy whose elements a loop updates: which ones are, is not followed.
    fn loses_elements(&mut self, vars: &BTreeSet<Var>, origin: &Place) -> bool {
        let nodes = self.put_back_singly(vars, origin);
        for id in &nodes {
            self.lose_put_back(*id, "a copy of which single elements are put back");
        }
        !nodes.is_empty()
    }

    /// Where single elements of what one of the variables holds go back to where they are from, and not each in its own round.
    fn put_back_singly(&self, vars: &BTreeSet<Var>, origin: &Place) -> Vec<NodeId> {
        let is_one = |place: &Place| place.base_var().is_some_and(|var| vars.contains(&var));
        let is_counted = |place: &Place| matches!(place.steps.last().and_then(Projection::key), Some(IndexKey::Var(_)));
        let is_part = |id: &NodeId| match &self.graph.node(*id).effect {
            Effect::Set(set) | Effect::Write(set) => {
                set.place.overlaps(origin)
                    && set.place.steps.len() > origin.steps.len()
                    && set
                        .from
                        .as_ref()
                        .is_some_and(|from| is_one(from) && !(is_counted(from) && is_counted(&set.place)))
            }
            _ => false,
        };
        self.graph.node_ids().filter(is_part).collect()
    }
}
