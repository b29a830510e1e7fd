//! Update laws: where the instance is in a call of one, and which channel of it is meant.

use super::{Builder, Value};
use crate::config::{InstancePlace, OnErr, Receiver};
use crate::flow::{Cause, Computed, Effect, IndexKey, Place, RunBy, Update, Var};
use crate::index::{Def, FilterSpec, FunctionId, Ty};
use crate::syntax::tree::{ExprId, ExprKind, PatId};
use crate::types::{Callee, Resolved};

/// Up to how many bodies of a law are followed, where types decide which one runs.
pub(super) const MAX_DISPATCHED: usize = 8;

/// A law that is called.
#[derive(Clone, Copy)]
pub(super) struct Law<'a> {
    pub(super) spec: &'a FilterSpec,
    /// Which half runs.
    pub(super) group: usize,
    /// The bodies that may run, if they are analysed.
    pub(super) targets: &'a [FunctionId],
    /// Whether the first of the values is `self`.
    pub(super) has_receiver: bool,
}

impl<'a> Builder<'a> {
    /// A law runs; `exprs` and `values` begin with `self` if there is one.
    pub(super) fn law_call(&mut self, id: ExprId, law: Law<'_>, exprs: &[ExprId], values: &[Value]) -> Value {
        let skip = usize::from(law.has_receiver);
        let at = match law.spec.instance {
            InstancePlace::Receiver => law.has_receiver.then_some(0),
            InstancePlace::Argument(number) => Some(number as usize + skip),
            InstancePlace::Returned => None,
        };
        let place = at.and_then(|at| values.get(at)).and_then(|value| value.place.clone());
        let mut fed = Vec::new();
        let mut from = Computed::default();
        for arg in exprs.iter().enumerate().filter(|(number, _)| Some(*number) != at).map(|(_, arg)| *arg) {
            fed.extend(self.reads_of(arg));
            let computed = self.computed_from(arg);
            from.places.extend(computed.places);
            from.calls.extend(computed.calls);
        }
        let into = self.targets.clone();
        let keys: Vec<(ExprId, &Value)> = law
            .spec
            .key
            .iter()
            .map(|key| *key as usize + skip)
            .filter_map(|key| Some((*exprs.get(key)?, values.get(key)?)))
            .collect();
        let place =
            place.map(|place| keys.into_iter().fold(place, |place, (key, value)| self.channel(place, key, value)));
        // What lies inside a composite filter is updated by its law's body.
        let targets = self.followed(law.targets, at, exprs, values, id);
        let result = self.emit_call(id, targets, exprs, values, at);
        if law.spec.instance == InstancePlace::Returned {
            self.advanced.insert(result, (law.group, self.called_name(id).to_owned()));
        }
        if let Some(place) = place {
            let attempt = (law.spec.on_err == OnErr::Untouched).then_some(result);
            let is_typed = law.spec.instance == InstancePlace::Receiver;
            // A function may have another name where it is called.
            let target = law.targets.first().map(|target| self.program.index.function(*target).name.clone());
            let method = target.unwrap_or_else(|| self.called_name(id).to_owned());
            let update =
                Update { place, law: law.group, method, run_by: RunBy::Code, is_typed, attempt, fed, into, from };
            self.emit(Effect::Update(update), self.span(id));
        }
        let is_owned = !matches!(self.ty(id), Ty::Ref(..));
        Value { place: Some(Place::var(result)), is_owned, same_as: Some(result), ..Value::default() }
    }

    /// The bodies of a law that are followed. Where a type parameter or a trait object decides which of many it is, what lies
    /// inside the filter has no name here, and what else the law gets is said to be unknown.
    fn followed<'t>(
        &mut self,
        targets: &'t [FunctionId],
        of: Option<usize>,
        exprs: &[ExprId],
        values: &[Value],
        id: ExprId,
    ) -> &'t [FunctionId] {
        if targets.len() <= MAX_DISPATCHED {
            return targets;
        }
        let others = exprs.iter().zip(values).enumerate().filter(|(at, _)| Some(*at) != of);
        let places: Vec<Place> = others
            .filter(|(_, (expr, _))| !self.is_shared(**expr) && self.may_hold_filter(self.ty(**expr)))
            .filter_map(|(_, (_, value))| value.place.clone())
            .collect();
        if !places.is_empty() {
            let cause = Cause::Call(self.text(id));
            self.emit(Effect::Unknown { places, cause }, self.span(id));
        }
        &[]
    }

    /// The channel of a filter that a key argument selects.
    fn channel(&mut self, place: Place, key: ExprId, value: &Value) -> Place {
        let found = self.argument_index(key, value);
        let index = found.unwrap_or_else(|| IndexKey::Data(self.text(key).into()));
        self.note_indexing(&index, &place);
        place.channel(index)
    }

    /// The name of the function or method that a call names.
    pub(super) fn called_name(&self, id: ExprId) -> &'a str {
        let body = self.body();
        match &body.expr(id).kind {
            ExprKind::MethodCall { method, .. } => method,
            ExprKind::Call { callee, .. } => match &body.expr(*callee).kind {
                ExprKind::Path(path) => path.last(),
                _ => "",
            },
            _ => "",
        }
    }

    /// The law whose result an expression is, where the new state is what the law returns: half and method.
    fn returned_law(&self, id: ExprId) -> Option<(usize, String)> {
        let body = self.body();
        match self.typed().callees.get(&id) {
            Some(Callee::Resolved(resolved)) => {
                if let Some((spec, group)) = self.law_of(resolved)
                    && spec.instance == InstancePlace::Returned
                {
                    return Some((group, self.called_name(id).to_owned()));
                }
            }
            Some(Callee::External(path)) => {
                let spec = self.program.index.function_spec(&Def::External(path.clone()));
                if spec.is_some_and(|spec| spec.instance == InstancePlace::Returned) {
                    return Some((0, self.called_name(id).to_owned()));
                }
            }
            _ => {}
        }
        match &body.expr(id).kind {
            ExprKind::Try(inner) | ExprKind::Await(inner) => self.returned_law(*inner),
            ExprKind::MethodCall { receiver, method, .. }
                if matches!(method.as_str(), "unwrap" | "expect" | "unwrap_or" | "unwrap_or_else" | "clone") =>
            {
                self.returned_law(*receiver)
            }
            ExprKind::Path(_) => {
                let local = self.typed().expr_local.get(&id).copied()?;
                self.advanced.get(self.frames[self.frame].vars.get(&local)?).cloned()
            }
            _ => None,
        }
    }

    /// A state that a law returned gets a name of its own.
    pub(super) fn note_advanced(&mut self, pat: PatId, value: ExprId) {
        if let Some(law) = self.returned_law(value)
            && let [local] = self.locals_of(pat).as_slice()
        {
            let var = self.var_of(*local);
            self.advanced.insert(var, law);
        }
    }

    /// A name for what a law returned, or for the payload of it.
    pub(super) fn bind_advanced(&mut self, var: Var, value: &Value) {
        let from = value.place.as_ref().filter(|place| place.steps.is_empty()).and_then(Place::base_var);
        if let Some(law) = from.and_then(|from| self.advanced.get(&from)).cloned() {
            self.advanced.insert(var, law);
        }
    }

    /// A state that a law returned takes the place of the one before: that is the update. Answers whether it is one.
    pub(super) fn advance(&mut self, target: ExprId, value: ExprId) -> bool {
        let Some(law) = self.returned_law(value) else { return false };
        let Some(place) = self.expr(target).place else { return false };
        let computed = self.computed_from(value);
        let update = Update {
            place,
            law: law.0,
            method: law.1,
            run_by: RunBy::Code,
            is_typed: false,
            attempt: None,
            fed: self.reads_of(value),
            into: Vec::new(),
            from: computed,
        };
        self.emit(Effect::Update(update), self.span(value));
        true
    }

    /// What is known of a call as a law, and which half it runs.
    pub(super) fn law_of(&self, resolved: &Resolved) -> Option<(&'a FilterSpec, usize)> {
        let index = self.program.index;
        match (resolved.law, resolved.targets.as_slice()) {
            (Some(group), _) => Some((index.law_spec(&resolved.self_ty).unwrap_or(index.trait_spec()), group)),
            (None, [target]) => Some((index.function_spec(&Def::Function(*target))?, 0)),
            _ => None,
        }
    }

    /// Whether a method resets its receiver, a filter: `true` if it resets all of it.
    pub(super) fn resets(&self, name: &str, resolved: &Resolved) -> Option<bool> {
        let spec = self.program.index.filter_spec(&resolved.self_ty)?;
        let is_in = |names: &[String]| names.iter().any(|own| own == name);
        if is_in(&spec.partial_resets) {
            return Some(false);
        }
        if !is_in(&spec.resets) {
            return None;
        }
        // An entry says which resets are full; what is known by trait alone is judged by its body.
        let is_judged = spec.time_base.is_none();
        Some(!is_judged || resolved.targets.iter().all(|target| self.is_full_reset(*target, &resolved.self_ty)))
    }

    /// The state that a method of a type resets whose laws have their state in an argument, and whether it resets all of it.
    pub(super) fn resets_state(
        &self,
        name: &str,
        resolved: &Resolved,
        exprs: &[ExprId],
        values: &[Value],
    ) -> Option<(Place, bool)> {
        let index = self.program.index;
        let spec = index.law_spec(&resolved.self_ty)?;
        let InstancePlace::Argument(number) = spec.instance else { return None };
        let full = spec.resets.iter().any(|own| own == name);
        if !full && !spec.partial_resets.iter().any(|own| own == name) {
            return None;
        }
        let args = usize::from(resolved.has_receiver)..exprs.len();
        let is_state = |at: &usize| index.state_spec(self.ty(exprs[*at]).peel()).is_some();
        // What is no state by its type is where the law has it.
        let at = args
            .clone()
            .find(is_state)
            .or_else(|| args.clone().nth(number as usize))
            .or_else(|| args.clone().last())?;
        Some((values.get(at)?.place.clone()?, full))
    }

    /// Whether a law of the type takes `&self`, so that a shared reference may update it.
    pub(super) fn updates_shared(&self, ty: &Ty) -> bool {
        self.program.index.filter_spec(ty.peel()).is_some_and(|spec| spec.receiver == Receiver::Shared)
    }
}
