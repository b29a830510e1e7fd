//! Guards: where they are made, what they hold, and how they end.

use super::{Builder, Value};
use crate::flow::{Effect, GuardId, GuardInfo, Place, Update, Var};
use crate::index::{Ty, is_guard_type};
use crate::source::Span;
use crate::syntax::tree::{ExprId, PatId, PatKind};

impl Builder<'_> {
    /// Whether an expression gives a guard that is bound to a name: ceid-core's `CycleGuard`.
    pub(super) fn is_guard(&self, id: ExprId) -> bool {
        self.is_guard_ty(self.ty(id))
    }

    fn is_guard_ty(&self, ty: &Ty) -> bool {
        match ty {
            Ty::External(path, args) => {
                is_guard_type(path)
                    || (matches!(ty.external_name(), Some("Option" | "Result" | "ManuallyDrop" | "Box" | "Rc" | "Arc"))
                        && args.first().is_some_and(|inner| self.is_guard_ty(inner)))
            }
            Ty::Adt(id, _) => {
                let def = self.program.index.type_def(*id);
                def.name == "CycleGuard" && self.program.index.crate_of(def.module).name == "ceid_core"
            }
            _ => false,
        }
    }

    fn add_guard(&mut self, span: Span, holds: Vec<Var>, names: Vec<String>) -> GuardId {
        let id = GuardId(u32::try_from(self.graph.guards.len()).expect("fewer than 2^32 guards"));
        let in_loop = self.loops.last().copied();
        self.graph.guards.push(GuardInfo { span, holds, in_loop, names, dropped: None, forgotten: None, name: None });
        id
    }

    /// A guard over places, alive to the end of the innermost block.
    pub(super) fn guard_scope(&mut self, span: Span, places: &[(String, Place)]) {
        let mut holds = Vec::new();
        for (name, place) in places {
            let var = self.temporary(Ty::Unknown, span);
            self.graph.vars[var.0 as usize].name.clone_from(name);
            self.set(var, &Value { place: Some(place.clone()), ..Value::default() }, span);
            holds.push(var);
        }
        let names = places.iter().map(|(name, _)| name.clone()).collect();
        let id = self.add_guard(span, holds, names);
        self.emit(Effect::GuardStart(id), span);
        if let Some(scope) = self.scopes.last_mut() {
            scope.guards.push(id);
        }
    }

    /// A named guard that a `let` binds.
    pub(super) fn bind_guard(&mut self, pat: PatId, init: ExprId, value: &Value) {
        let span = self.span(init);
        let known = value.place.as_ref().and_then(Place::base_var).and_then(|var| self.guards_of.get(&var)).copied();
        let id = known.unwrap_or_else(|| self.add_guard(span, Vec::new(), Vec::new()));
        if let PatKind::Bind { name, .. } = &self.body().pat(pat).kind {
            self.graph.guards[id.0 as usize].name = Some(name.clone());
        }
        for local in self.locals_of(pat) {
            let var = self.var_of(local);
            self.guards_of.insert(var, id);
        }
        if known.is_none() {
            self.emit(Effect::GuardStart(id), span);
            if let Some(scope) = self.scopes.last_mut() {
                scope.guards.push(id);
            }
        }
    }

    /// The end of a guard: what it holds is updated.
    pub(super) fn end_guard(&mut self, guard: GuardId, span: Span) {
        let holds = self.graph.guards[guard.0 as usize].holds.clone();
        for var in holds {
            let update = Update {
                place: Place::var(var),
                law: 0,
                method: "update".to_owned(),
                by_guard: true,
                fed: Vec::new(),
                into: Vec::new(),
                from: crate::flow::Computed::default(),
            };
            self.emit(Effect::Update(update), span);
        }
        self.emit(Effect::GuardEnd(guard), span);
    }

    /// A value that a statement drops at once.
    pub(super) fn discard(&mut self, expr: ExprId, _value: &Value, span: Span) {
        if self.at.is_some() && self.is_guard(expr) {
            let id = self.add_guard(self.span(expr), Vec::new(), Vec::new());
            self.graph.guards[id.0 as usize].dropped = Some((span, "it is never bound to a name".to_owned()));
        }
    }

    /// `let _ = value;`
    pub(super) fn discard_wild(&mut self, expr: ExprId, value: &Value, span: Span) {
        if self.is_guard(expr) && value.place.as_ref().and_then(Place::base_var).and_then(|var| self.guards_of.get(&var)).is_none() {
            let id = self.add_guard(self.span(expr), Vec::new(), Vec::new());
            self.graph.guards[id.0 as usize].dropped = Some((span, "`let _` drops it at once".to_owned()));
        }
    }

    fn guard_of(&self, value: &Value) -> Option<GuardId> {
        let var = value.place.as_ref().and_then(Place::base_var)?;
        self.guards_of.get(&var).copied()
    }

    /// `drop(value)`
    pub(super) fn drop_value(&mut self, value: &Value, span: Span) {
        let Some(guard) = self.guard_of(value) else { return };
        if self.at.is_some() && self.graph.guards[guard.0 as usize].dropped.is_none() {
            self.graph.guards[guard.0 as usize].dropped = Some((span, "`drop` ends it here".to_owned()));
            self.end_guard(guard, span);
        }
    }

    /// A value whose destructor will never run.
    pub(super) fn forget_value(&mut self, value: &Value, span: Span, how: &str) {
        let Some(guard) = self.guard_of(value) else { return };
        self.graph.guards[guard.0 as usize].forgotten = Some((span, how.to_owned()));
    }

    /// `ManuallyDrop::new(guard)` keeps the destructor from running.
    pub(super) fn wrap_guard(&mut self, value: &Value, owner: &str, span: Span) {
        if owner == "ManuallyDrop" {
            self.forget_value(value, span, "ManuallyDrop");
        }
    }
}
