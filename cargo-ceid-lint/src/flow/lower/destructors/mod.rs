//! Values with a destructor of the analysed code in them: where it runs, and where it does not.

mod unbound;

use super::{Builder, Value};
use crate::flow::{Argument, CallSite, Cause, DESTRUCTOR, Effect, GuardId, IndexKey, Place, Var};
use crate::index::{FunctionId, Shape, Ty};
use crate::source::Span;
use crate::syntax::tree::{ExprId, ExprKind, Receiver};

/// How deep a destructor is looked for in what owns it.
const MAX_DEPTH: u32 = 4;

/// How the names of collections end.
const COLLECTIONS: [&str; 6] = ["Vec", "Deque", "Map", "Set", "List", "Heap"];

/// A destructor that runs where a value is dropped.
struct Destructor {
    function: FunctionId,
    place: Place,
    /// Its parts that may refer to filters.
    refers: Vec<Place>,
    /// Whether it runs once for each such value: what a collection or a shared handle holds may be dropped any number of times,
    /// and what an option or a variant would hold may not be there.
    is_certain: bool,
}

impl Builder<'_> {
    /// The destructor of a type of the analysed code that may hold filters or references to them.
    fn own_destructor(&self, ty: &Ty) -> Option<FunctionId> {
        let index = self.program.index;
        if !matches!(ty, Ty::Adt(..)) || !self.may_hold_filter(ty) {
            return None;
        }
        let owners = index.methods(ty, "drop");
        let of_drop = owners.iter().find(|owner| owner.of_trait().is_some_and(|name| index.trait_text(name) == "Drop"));
        of_drop?.function()
    }

    /// What runs where a value of a type is dropped: its own destructor, and those of its parts.
    fn destructors(&self, ty: &Ty, place: &Place, depth: u32, found: &mut Vec<Destructor>) {
        if depth > MAX_DEPTH || !self.program.index.leads_to_destructor(ty) || self.is_guard_ty(ty) {
            return;
        }
        let first = found.len();
        let mut is_certain = true;
        match ty {
            Ty::Adt(id, _) => {
                if let Some(function) = self.own_destructor(ty) {
                    let refers = self.filter_fields(ty).into_iter().map(|(name, _)| place.field(&name)).collect();
                    found.push(Destructor { function, place: place.clone(), refers, is_certain: true });
                }
                let index = self.program.index;
                let part = |variant: Option<usize>, name: &str| index.field_ty(ty, variant, name);
                match &index.type_def(*id).shape {
                    Shape::Struct(fields) => {
                        for field in &fields.fields {
                            if let Some(inner) = part(None, &field.name) {
                                self.destructors(&inner, &place.field(&field.name), depth + 1, found);
                            }
                        }
                    }
                    Shape::Enum(variants) => {
                        for (number, variant) in variants.iter().enumerate() {
                            let head = super::constants::variant_head(self.program, *id, number);
                            for field in &variant.fields.fields {
                                if let Some(inner) = part(Some(number), &field.name) {
                                    let (first, place) = (found.len(), place.field(&head).field(&field.name));
                                    self.destructors(&inner, &place, depth + 1, found);
                                    found[first..].iter_mut().for_each(|own| own.is_certain = false);
                                }
                            }
                        }
                    }
                }
            }
            Ty::Tuple(parts) => {
                for (number, part) in parts.iter().enumerate() {
                    self.destructors(part, &place.field(&number.to_string()), depth + 1, found);
                }
            }
            Ty::Array(inner, _) | Ty::Slice(inner) => {
                self.destructors(inner, &place.element(IndexKey::Each), depth + 1, found);
                is_certain = false;
            }
            Ty::External(_, args) => {
                let name = ty.external_name().unwrap_or("");
                is_certain = matches!(name, "Box" | "Cell" | "RefCell" | "Mutex" | "RwLock");
                let is_collection = COLLECTIONS.iter().any(|end| name.ends_with(end));
                let owns = is_certain || matches!(name, "Option" | "Result" | "Rc" | "Arc" | "Pin") || is_collection;
                let place = if is_collection { &place.element(IndexKey::Each) } else { place };
                for inner in args.iter().filter(|_| owns) {
                    self.destructors(inner, place, depth + 1, found);
                }
            }
            _ => {}
        }
        for own in &mut found[first..] {
            own.is_certain &= is_certain;
        }
    }

    fn has_destructor(&self, ty: &Ty) -> bool {
        let mut found = Vec::new();
        self.destructors(ty, &Place::var(Var(0)), 0, &mut found);
        !found.is_empty()
    }

    /// A value is dropped.
    pub(super) fn drop_parts(&mut self, ty: &Ty, place: &Place, span: Span) {
        if let (Ty::External(_, args), Some(var)) = (ty, place.base_var())
            && ty.external_name() == Some("Option")
            && let Some(content) = args.first().filter(|_| place.steps.is_empty() && self.at.is_some())
        {
            let value = Value { same_as: Some(var), ..Value::default() };
            let about = crate::flow::About::default();
            let text = "there is something to drop".to_owned();
            let (present, absent) = self.branch_on_head(&value, "+", "-", span, text, about);
            let after = self.add_node(Effect::Nothing, span);
            self.resume(present);
            self.drop_parts(content, place, span);
            self.jump(after);
            self.resume(absent);
            self.jump(after);
            return self.resume_if_reached(after);
        }
        let mut found = Vec::new();
        self.destructors(ty, place, 0, &mut found);
        for own in found {
            if own.is_certain {
                self.run_on(own.function, own.place, Ty::unit(), DESTRUCTOR.to_owned(), span);
            } else {
                self.unseen([own.place].into_iter().chain(own.refers).collect(), span);
            }
        }
    }

    /// When a destructor runs is not known.
    fn drop_unseen(&mut self, ty: &Ty, place: Place, span: Span) {
        let mut found = Vec::new();
        self.destructors(ty, &place, 0, &mut found);
        let refers = found.into_iter().flat_map(|own| own.refers);
        self.unseen([place].into_iter().chain(refers).collect(), span);
    }

    fn unseen(&mut self, places: Vec<Place>, span: Span) {
        let cause = Cause::Code("when its destructor runs".to_owned());
        self.emit(Effect::Unknown { places, cause }, span);
    }

    /// `ManuallyDrop::drop(&mut slot)`
    pub(super) fn drop_by_hand(&mut self, expr: ExprId, value: &Value, span: Span) {
        if let (Ty::External(_, args), Some(place)) = (self.ty(expr).peel().clone(), value.place.clone())
            && self.at.is_some()
        {
            args.first().into_iter().for_each(|content| self.drop_unseen(content, place.clone(), span));
        }
    }

    /// A function of the analysed code runs on a place, without a call in the source.
    pub(super) fn run_on(&mut self, function: FunctionId, place: Place, ty: Ty, text: String, span: Span) -> Var {
        self.run_one_on((vec![function], Vec::new()), place, ty, text, span)
    }

    /// The same of one of several functions, with the type of the place where that decides what runs.
    pub(super) fn run_one_on(
        &mut self,
        (targets, types): (Vec<FunctionId>, Vec<Ty>),
        place: Place,
        ty: Ty,
        text: String,
        span: Span,
    ) -> Var {
        let result = self.temporary(ty, span);
        let is_shared = targets
            .iter()
            .all(|target| self.program.index.function(*target).function.receiver == Some(Receiver::Shared));
        let site = CallSite {
            hands: None,
            targets,
            args: vec![Argument { place: Some(place), is_shared, ..Argument::default() }],
            result,
            types,
            text,
            law_of: None,
            is_dispatched: false,
            fed: Vec::new(),
            into: Vec::new(),
            from: crate::flow::Computed::default(),
        };
        self.emit(Effect::Call(Box::new(site)), span);
        result
    }

    /// Whether nothing but the value itself has what is in it: what a branch or a call gives has no other name.
    fn owns(&self, value: &Value, ty: &Ty) -> bool {
        let whole = value.place.as_ref().filter(|place| place.steps.is_empty()).and_then(Place::base_var);
        let whole = whole.map(|whole| self.graph.var(whole));
        value.is_owned || whole.is_some_and(|whole| whole.name.is_empty() && whole.ty == *ty)
    }

    /// A value that is dropped where its scope ends.
    pub(super) fn bind_destructor(&mut self, var: Var, value: &Value, span: Span) {
        let ty = self.graph.var(var).ty.clone();
        if !self.owns(value, &ty) || !self.has_destructor(&ty) {
            return;
        }
        let of_same = |guard: &GuardId| {
            self.graph.guards[guard.0 as usize].holds.iter().any(|held| self.graph.var(*held).ty == ty)
        };
        let before = self.destroyed_by(value);
        if let Some(before) = before.filter(of_same) {
            // It is dropped by the name that it had before.
            self.guards_of.insert(var, before);
            self.graph.guards[before.0 as usize].holds.push(var);
            return;
        }
        if let Some(whole) = before {
            self.release(whole, span);
        }
        let id = self.add_guard(span, vec![var], Vec::new(), Vec::new());
        self.graph.guards[id.0 as usize].is_destructor = true;
        self.guards_of.insert(var, id);
        self.start_guard(id, self.innermost(), span);
    }

    /// The end of the scope in which a value with a destructor has a name.
    pub(super) fn destroy_held(&mut self, guard: GuardId, span: Span) {
        for var in self.graph.guards[guard.0 as usize].holds.clone() {
            let ty = self.graph.var(var).ty.clone();
            self.drop_parts(&ty, &Place::var(var), span);
        }
    }

    /// What drops a value at the end of a scope, if something does. What was taken out of one that has a name has none of its own.
    pub(super) fn destroyed_by(&self, value: &Value) -> Option<GuardId> {
        let var = value.place.as_ref()?.base_var().filter(|_| value.is_owned)?;
        let id = self.guards_of.get(&var).copied()?;
        let guard = &self.graph.guards[id.0 as usize];
        (guard.is_destructor && guard.holds.contains(&var)).then_some(id)
    }

    /// The end of its scope does not drop a value any more.
    pub(super) fn release(&mut self, guard: GuardId, span: Span) {
        self.ended.insert(guard);
        if let Some(alive) = self.alive.get(&guard).copied().filter(|_| self.at.is_some()) {
            self.set(alive, &Value { head: Some("false".to_owned()), ..Value::default() }, span);
        }
    }

    /// A value that a statement, or a call that does nothing else, drops at once.
    pub(super) fn drop_now(&mut self, expr: ExprId, value: &Value, span: Span) {
        if self.at.is_none() || !self.has_destructor(self.ty(expr)) {
            return;
        }
        let Some(place) = value.place.clone() else {
            // What is taken out of something has no name here: `slot.take();`
            if let ExprKind::MethodCall { receiver, .. } = self.body().expr(expr).kind
                && let Some(owner) = self.static_place(receiver)
            {
                self.drop_unseen(&self.ty(expr).clone(), owner, span);
            }
            return;
        };
        if !self.owns(value, self.ty(expr)) {
            return;
        }
        match self.destroyed_by(value) {
            Some(guard) if value.leaves_by.is_some() || place.steps.is_empty() => self.end_now(guard, span),
            // Its owner is still dropped at the end of the scope, without it.
            Some(_) => self.drop_unseen(&self.ty(expr).clone(), place, span),
            None => match self.ty(expr).clone() {
                Ty::External(_, args) if value.head.as_deref() == Some("+") && self.is_optional(expr) => {
                    args.first().into_iter().for_each(|content| self.drop_parts(content, &place, span));
                }
                ty => self.drop_parts(&ty, &place, span),
            },
        }
    }

    /// What a variable holds is dropped where it is given another value.
    pub(super) fn drop_overwritten(&mut self, target: ExprId, span: Span) {
        let Some(place) = self.static_place(target).filter(|place| place.steps.is_empty()) else { return };
        let guard = place.base_var().and_then(|var| self.guards_of.get(&var));
        if guard.is_some_and(|guard| self.graph.guards[guard.0 as usize].is_destructor) {
            self.drop_parts(&self.ty(target).clone(), &place, span);
        }
    }

    /// A value that has no name, and of which only a part or a reference is used: its statement drops it.
    pub(super) fn drop_unnamed(&mut self, expr: ExprId, value: &Value) {
        let is_made = matches!(
            self.body().expr(expr).kind,
            ExprKind::Call { .. } | ExprKind::MethodCall { .. } | ExprKind::Struct { .. } | ExprKind::Tuple(_)
        );
        if is_made && self.owns(value, self.ty(expr)) && self.destroyed_by(value).is_none() {
            self.drop_now(expr, value, self.span(expr));
        }
    }

    /// The same, where it is lent to its own method.
    pub(super) fn drop_lent(&mut self, targets: &[FunctionId], receiver: ExprId, value: &Value) {
        let takes =
            |target: &FunctionId| self.program.index.function(*target).function.receiver == Some(Receiver::Value);
        if !targets.iter().any(takes) {
            self.drop_unnamed(receiver, value);
        }
    }

    /// A call has got values with destructors: analysed code drops them by itself, as far as their types tell.
    pub(super) fn give_destructors(&mut self, targets: &[FunctionId], exprs: &[ExprId], values: &[Value], span: Span) {
        for (number, (expr, value)) in exprs.iter().zip(values).enumerate() {
            if self.at.is_none() || !value.is_owned || !self.has_destructor(self.ty(*expr)) {
                continue;
            }
            let is_lent = |target: &FunctionId| {
                let receiver = &self.program.index.function(*target).function.receiver;
                number == 0 && matches!(receiver, Some(Receiver::Shared | Receiver::Exclusive))
            };
            if targets.iter().any(is_lent) {
                continue;
            }
            let drops = |target: &FunctionId| self.has_destructor(&self.declared_param(*target, number));
            if !targets.iter().all(drops)
                && let Some(place) = value.place.clone()
            {
                self.drop_unseen(&self.ty(*expr).clone(), place, span);
            }
            if let Some(guard) = self.destroyed_by(value) {
                self.release(guard, span);
            }
        }
    }

    /// A value goes where something else drops it at some time.
    pub(super) fn keep_destructor(&mut self, expr: ExprId, value: &Value) {
        if self.at.is_some()
            && self.has_destructor(self.ty(expr))
            && let Some(place) = value.place.clone().filter(|_| value.is_owned)
        {
            self.drop_unseen(&self.ty(expr).clone(), place, self.span(expr));
        }
    }

    /// The type that a function declares for a parameter, `self` first.
    pub(super) fn declared_param(&self, function: FunctionId, number: usize) -> Ty {
        let index = self.program.index;
        let def = index.function(function);
        let scope = index.scope_of(function);
        let number = match &def.function.receiver {
            Some(receiver) if number == 0 => {
                let of_value = Some(()).filter(|()| *receiver == Receiver::Value).and(scope.self_ty.clone());
                return of_value.unwrap_or(Ty::Unknown);
            }
            Some(_) => number - 1,
            None => number,
        };
        def.function.params.get(number).map_or(Ty::Unknown, |ty| index.lower(ty, &scope))
    }

    /// The parameters that a function gets by value are dropped at its end.
    pub(super) fn bind_parameters(&mut self, function: FunctionId, span: Span) {
        for (number, var) in self.graph.params.clone().into_iter().enumerate() {
            let ty = self.declared_param(function, number);
            if self.has_destructor(&ty) {
                let info = &mut self.graph.vars[var.0 as usize];
                info.ty = ty;
                if info.name.is_empty() {
                    "_".clone_into(&mut info.name);
                }
                self.bind_destructor(var, &Value { is_owned: true, ..Value::default() }, span);
            }
        }
    }
}
