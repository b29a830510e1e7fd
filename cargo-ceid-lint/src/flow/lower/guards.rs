//! Guards: where they are made, what they hold, and how they end.

use super::made::Made;
use super::{Builder, Value};
use crate::flow::{Effect, GuardId, GuardInfo, IndexKey, Place, RunBy, Update, Var};
use crate::index::{Ty, is_guard_type};
use crate::source::Span;
use crate::syntax::tree::{ExprId, ExprKind};
use crate::types::Callee;

/// Sets lie in sets; deeper ones are guarded as a whole.
const MAX_DEPTH: u32 = 6;

impl Builder<'_> {
    /// Whether an expression gives a guard that is bound to a name: ceid-core's `CycleGuard`, or one that an entry names.
    pub(super) fn is_guard(&self, id: ExprId) -> bool {
        self.is_guard_ty(self.ty(id))
    }

    /// Whether the value of an expression is a guard: by its type, or because one was made there.
    pub(super) fn is_guard_value(&self, id: ExprId, value: &Value) -> bool {
        self.is_guard(id) || value.place.as_ref().is_some_and(|place| self.is_made(place))
    }

    /// Whether an expression asks a clock of ceid-core for the next cycle: `None` says that there is none.
    pub(super) fn asks_for_cycle(&self, id: ExprId) -> bool {
        let ty = self.ty(id);
        let is_cycle = |ty: &Ty| self.is_ceid(ty, "Cycle") || self.is_ceid(ty, "CycleGuard");
        matches!(ty, Ty::External(_, args) if ty.external_name() == Some("Option") && args.first().is_some_and(is_cycle))
    }

    /// Whether a type is one of ceid-core's, read or not.
    pub(super) fn is_ceid(&self, ty: &Ty, name: &str) -> bool {
        match ty {
            Ty::External(path, _) => path == &format!("ceid_core::{name}"),
            Ty::Adt(id, _) => {
                let def = self.program.index.type_def(*id);
                def.name == name && self.program.index.crate_of(def.module).name == "ceid_core"
            }
            _ => false,
        }
    }

    pub(super) fn is_guard_ty(&self, ty: &Ty) -> bool {
        if self.program.index.guard_spec(ty).is_some() {
            return true;
        }
        match ty {
            Ty::External(path, args) => {
                is_guard_type(path)
                    || (matches!(ty.external_name(), Some("Option" | "Result" | "ManuallyDrop" | "Box" | "Rc" | "Arc"))
                        && args.first().is_some_and(|inner| self.is_guard_ty(inner)))
            }
            _ => self.is_ceid(ty, "CycleGuard"),
        }
    }

    pub(super) fn add_guard(
        &mut self,
        span: Span,
        holds: Vec<Var>,
        updates: Vec<Place>,
        names: Vec<String>,
    ) -> GuardId {
        let id = GuardId(u32::try_from(self.graph.guards.len()).expect("fewer than 2^32 guards"));
        let in_loop = self.loops.last().copied();
        self.graph.guards.push(GuardInfo {
            span,
            holds,
            updates,
            in_loop,
            names,
            dropped: None,
            forgotten: None,
            name: None,
            is_destructor: false,
        });
        id
    }

    /// A guard takes effect in a scope; whether it is still alive is known on each way.
    pub(super) fn start_guard(&mut self, id: GuardId, scope: usize, span: Span) {
        let alive = self.temporary(Ty::Bool, span);
        self.set(alive, &Value { head: Some("true".to_owned()), ..Value::default() }, span);
        self.alive.insert(id, alive);
        self.emit(Effect::GuardStart(id), span);
        if let Some(scope) = self.scopes.get_mut(scope) {
            scope.guards.push(id);
        }
    }

    /// The end of a scope: guards that are still alive end.
    pub(super) fn end_guards(&mut self, guards: &[GuardId], span: Span) {
        for guard in guards.iter().rev() {
            if self.at.is_none() {
                return;
            }
            let may_have_ended = self.ended.contains(guard);
            match self.alive.get(guard).copied().filter(|_| may_have_ended) {
                None if may_have_ended => {}
                None => self.end_guard(*guard, span),
                Some(alive) => {
                    let subject = self.subject(self.pure_var(alive), Some(vec!["true".to_owned(), "false".to_owned()]));
                    let heads = ["true".to_owned()];
                    let about = crate::flow::About::default();
                    let text = "the guard is alive".to_owned();
                    let (lives, gone) = self.branch_on_subject(subject, &heads, true, span, text, about);
                    let after = self.add_node(Effect::Nothing, span);
                    self.resume(lives);
                    self.end_guard(*guard, span);
                    self.jump(after);
                    self.resume(gone);
                    self.jump(after);
                    self.resume(after);
                }
            }
        }
    }

    /// A guard over places, alive to the end of the innermost block.
    pub(super) fn guard_scope(&mut self, span: Span, places: &[(String, Place, Ty)]) {
        let mut holds = Vec::new();
        let mut updates = Vec::new();
        for (name, place, ty) in places {
            let var = self.temporary(Ty::Unknown, span);
            self.graph.vars[var.0 as usize].name.clone_from(name);
            self.set(var, &Value { place: Some(place.clone()), ..Value::default() }, span);
            holds.push(var);
            self.filters_in(Place::var(var), ty, 0, &mut updates);
        }
        let names = places.iter().map(|(name, ..)| name.clone()).collect();
        let id = self.add_guard(span, holds, updates, names);
        for (_, place, ty) in places {
            self.admit(id, place, ty, span);
        }
        self.start_guard(id, self.innermost(), span);
    }

    /// What the guard of a place updates: the filter there, or each filter that the set, array or tuple there has.
    fn filters_in(&self, place: Place, ty: &Ty, depth: u32, found: &mut Vec<Place>) {
        let index = self.program.index;
        let ty = ty.peel();
        if super::adapted::is_adapted(ty) {
            return;
        }
        if depth > MAX_DEPTH || index.filter_spec(ty).is_some() || !index.holds_filter(ty) {
            found.push(place);
            return;
        }
        match ty {
            Ty::Array(inner, _) | Ty::Slice(inner) => {
                self.filters_in(place.element(IndexKey::Each), inner, depth + 1, found);
            }
            Ty::Tuple(parts) => {
                for (number, part) in parts.iter().enumerate().filter(|(_, part)| index.holds_filter(part)) {
                    self.filters_in(place.field(&number.to_string()), part, depth + 1, found);
                }
            }
            Ty::External(path, args) => match (path.rsplit("::").next(), args.first()) {
                (Some("Vec" | "ArrayVec" | "SmallVec"), Some(inner)) => {
                    self.filters_in(place.element(IndexKey::Each), inner, depth + 1, found);
                }
                (Some("Box" | "Option" | "OnlyInCeid"), Some(inner)) => self.filters_in(place, inner, depth + 1, found),
                _ => found.push(place),
            },
            Ty::Adt(..) => {
                for (field, ty) in self.filter_fields(ty) {
                    self.filters_in(place.field(&field), &ty, depth + 1, found);
                }
            }
            _ => found.push(place),
        }
    }

    /// The guard that a value is; one that was not seen before is made here.
    pub(super) fn guard_of(&mut self, expr: ExprId, value: &Value) -> Option<GuardId> {
        let var = value.place.as_ref().and_then(Place::base_var);
        if let Some(id) = var.and_then(|var| self.guards_of.get(&var)) {
            return Some(*id);
        }
        if !self.is_guard_value(expr, value) {
            return None;
        }
        let made = var.map(|var| self.take_made(&Place::var(var))).unwrap_or_default();
        let id = match made.into_iter().next() {
            Some(made) => self.guard_from(made),
            None => self.add_guard(self.span(expr), Vec::new(), Vec::new(), Vec::new()),
        };
        if let Some(var) = var {
            self.guards_of.insert(var, id);
        }
        Some(id)
    }

    /// A guard over what the call that made it was given.
    pub(super) fn guard_from(&mut self, made: Made) -> GuardId {
        let mut updates = Vec::new();
        for lent in &made.lent {
            self.filters_in(Place::var(lent.held), &lent.ty, 0, &mut updates);
        }
        let holds = made.lent.iter().map(|lent| lent.held).collect();
        let names = made.lent.iter().map(|lent| lent.name.clone()).collect();
        let id = self.add_guard(made.span, holds, updates, names);
        for lent in made.lent {
            self.admit(id, &lent.place, &lent.ty, made.span);
        }
        id
    }

    /// `Guard::new(&mut filter)`, where an entry names the type and the function: a guard that is not bound yet.
    pub(super) fn guard_made(&mut self, id: ExprId, args: &[ExprId]) -> Option<Value> {
        let index = self.program.index;
        let spec = index.guard_spec(self.ty(id))?;
        if self.called_name(id) != spec.register {
            return None;
        }
        let span = self.span(id);
        let (places, values) = self.registered(args);
        let var = match self.typed().callees.get(&id) {
            // What the guard hands out again is what it was given.
            Some(Callee::Resolved(resolved)) if self.at.is_some() && !resolved.targets.is_empty() => {
                let targets = resolved.targets.clone();
                self.emit_call(id, &targets, args, &values, None)
            }
            _ => self.temporary(self.ty(id).clone(), span),
        };
        self.note_made(Place::var(var), places, span);
        Some(Value { place: Some(Place::var(var)), is_owned: true, ..Value::default() })
    }

    /// `guard.register(&mut filter)`, on a guard that is bound or is being built.
    fn register(&mut self, id: ExprId, receiver: ExprId, args: &[ExprId]) -> Value {
        let value = self.expr(receiver);
        let (places, _) = self.registered(args);
        let span = self.span(id);
        let made = self.temporary(self.ty(id).clone(), span);
        self.note_made(Place::var(made), places, span);
        let var = value.place.as_ref().and_then(Place::base_var);
        if let Some(guard) = var.and_then(|var| self.guards_of.get(&var)).copied() {
            for lent in self.take_made(&Place::var(made)).into_iter().flat_map(|made| made.lent) {
                let mut updates = Vec::new();
                self.filters_in(Place::var(lent.held), &lent.ty, 0, &mut updates);
                let info = &mut self.graph.guards[guard.0 as usize];
                info.holds.push(lent.held);
                info.updates.extend(updates);
                info.names.push(lent.name);
            }
            return value;
        }
        let before = value.place.as_ref().map(|place| self.take_made(place)).unwrap_or_default();
        let all = before.into_iter().chain(self.take_made(&Place::var(made))).flat_map(|made| made.lent).collect();
        self.add_made(Place::var(made), all, span);
        Value { place: Some(Place::var(made)), is_owned: true, ..Value::default() }
    }

    /// The filters among the arguments of a registration, tuples and arrays of them taken apart; and the arguments.
    fn registered(&mut self, args: &[ExprId]) -> (Vec<(String, Place, Ty)>, Vec<Value>) {
        let body = self.body();
        let mut places = Vec::new();
        let mut values = Vec::new();
        for arg in args {
            let inner = match &body.expr(*arg).kind {
                ExprKind::Cast { value, .. } => *value,
                ExprKind::Reference { value, .. }
                    if matches!(body.expr(*value).kind, ExprKind::Tuple(_) | ExprKind::Array { .. }) =>
                {
                    *value
                }
                _ => *arg,
            };
            match &body.expr(inner).kind {
                ExprKind::Tuple(parts) | ExprKind::Array { elements: parts, .. } => {
                    let (own, given) = self.registered(parts);
                    places.extend(own);
                    values.push(self.gathered(inner, parts, &given));
                }
                _ if inner != *arg => {
                    let (own, inner) = self.registered(&[inner]);
                    places.extend(own);
                    values.extend(inner);
                }
                _ => {
                    let name = self.text(*arg).trim_start_matches("&mut ").to_owned();
                    let value = self.expr(*arg);
                    if let Some(place) = value.place.clone()
                        && self.may_hold_filter(self.ty(*arg))
                    {
                        places.push((name, place, self.ty(*arg).clone()));
                    }
                    values.push(value);
                }
            }
        }
        (places, values)
    }

    /// `cycle.guard(&mut filters)`: a guard that is not bound yet.
    pub(super) fn guard_call(&mut self, id: ExprId, receiver: ExprId, method: &str, args: &[ExprId]) -> Option<Value> {
        let ty = self.ty(receiver).peel().clone();
        if self.program.index.guard_spec(&ty).is_some_and(|spec| spec.register == method) {
            return Some(self.register(id, receiver, args));
        }
        match (method, args) {
            ("guard", [arg]) if self.is_ceid(&ty, "Cycle") => {
                self.expr(receiver);
                let name = self.text(*arg).trim_start_matches("&mut ").to_owned();
                let value = self.expr(*arg);
                let var = self.temporary(self.ty(id).clone(), self.span(id));
                if let Some(place) = value.place {
                    self.note_made(Place::var(var), vec![(name, place, self.ty(*arg).clone())], self.span(id));
                }
                Some(Value { place: Some(Place::var(var)), is_owned: true, ..Value::default() })
            }
            ("filters", []) if self.is_ceid(&ty, "CycleGuard") => {
                let value = self.expr(receiver);
                // `control.cycle()?.filters().input = x;`
                let is_made_here = value.place.as_ref().is_some_and(|place| self.is_made(place));
                if self.at.is_some() && is_made_here && !self.is_bound(&value) {
                    let how = "no name holds it, so that its statement drops it";
                    self.mark_dropped(receiver, &value, self.span(receiver), how);
                }
                let guard =
                    value.place.as_ref().and_then(Place::base_var).and_then(|var| self.guards_of.get(&var)).copied();
                let held = guard.and_then(|guard| self.graph.guards[guard.0 as usize].holds.first().copied());
                Some(held.map_or(value, |held| Value { place: Some(Place::var(held)), ..Value::default() }))
            }
            ("cycle", []) if self.is_ceid(&ty, "Cyclic") => {
                let value = self.expr(receiver);
                let name = self.text(receiver).trim_start_matches("&mut ").to_owned();
                let var = self.temporary(self.ty(id).clone(), self.span(id));
                if let Some(driver) = value.place {
                    let set = driver.field("filters");
                    self.note_made(Place::var(var), vec![(name, set, driven_set(&ty))], self.span(id));
                }
                Some(Value { place: Some(Place::var(var)), is_owned: true, ..Value::default() })
            }
            ("filters", []) if self.is_ceid(&ty, "Cyclic") => {
                let value = self.expr(receiver);
                let place = value.place.map(|driver| driver.field("filters"));
                Some(Value { place, ..Value::default() })
            }
            ("filter", []) if self.is_ceid(&ty, "OnlyInCeid") => {
                let place = self.expr(receiver).place;
                if let Some(place) = place.clone() {
                    self.emit(Effect::Use { place }, self.span(id));
                }
                Some(Value { place, ..Value::default() })
            }
            ("run", [arg]) if self.is_ceid(&ty, "Cyclic") => {
                self.expr(receiver);
                let closure = self.expr(*arg).closure?;
                let driver = self.text(receiver).trim_start_matches("&mut ").to_owned();
                self.guarded_closure(closure, &driver, &driven_set(&ty), self.span(id));
                Some(Value::default())
            }
            (_, args) if self.is_ceid(&ty, "Tick") => self.tick_call(id, receiver, method, args),
            _ => None,
        }
    }

    /// The end of a guard: what it holds is updated.
    pub(super) fn end_guard(&mut self, guard: GuardId, span: Span) {
        let info = &self.graph.guards[guard.0 as usize];
        if info.is_destructor {
            return self.destroy_held(guard, span);
        }
        for place in info.updates.clone() {
            let update = Update {
                given: None,
                place,
                law: 0,
                method: "update".to_owned(),
                run_by: RunBy::Guard,
                is_typed: true,
                attempt: None,
                fed: Vec::new(),
                into: Vec::new(),
                from: crate::flow::Computed::default(),
            };
            self.emit(Effect::Update(update), span);
        }
        self.run_adapted(guard, span);
        self.emit(Effect::GuardEnd(guard), span);
        self.let_go(guard, span);
    }
}

/// The set of filters that a `Cyclic` drives.
fn driven_set(driver: &Ty) -> Ty {
    match driver {
        Ty::Adt(_, params) | Ty::External(_, params) => params.first().cloned().unwrap_or(Ty::Unknown),
        _ => Ty::Unknown,
    }
}
