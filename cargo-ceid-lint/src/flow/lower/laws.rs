//! Update laws: where the instance is in a call of one, and which channel of it is meant.

use super::{Builder, Value};
use crate::config::{InstancePlace, OnErr, Receiver};
use crate::flow::{Advance, Cause, Computed, Effect, Head, IndexKey, Place, RunBy, Update, Var};
use crate::index::{Def, FilterSpec, FunctionId, LawGroup, MethodOwner, TraitName, Ty, handed, is_number};
use crate::syntax::tree::{ExprId, ExprKind};
use crate::types::Resolved;

/// Up to how many bodies of a law are followed, where types decide which one runs.
pub(crate) const MAX_DISPATCHED: usize = 8;

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
        let receiver = place.clone().filter(|_| at == Some(0) && law.has_receiver && law.targets.is_empty());
        let mut fed = Vec::new();
        let mut from = Computed::default();
        for arg in exprs.iter().enumerate().filter(|(number, _)| Some(*number) != at).map(|(_, arg)| *arg) {
            fed.extend(self.reads_of(arg));
            let computed = self.computed_from(arg);
            from.places.extend(computed.places);
            from.calls.extend(computed.calls);
        }
        let mut into = self.targets.clone();
        into.extend(exprs.iter().filter_map(|arg| self.result_lent(*arg)).collect::<Vec<_>>());
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
            self.law_advances(id, &law, exprs, values, result);
        }
        if let Some(place) = place {
            let attempt = (law.spec.on_err == OnErr::Untouched).then_some(result);
            let is_typed = law.spec.instance == InstancePlace::Receiver;
            // A function may have another name where it is called.
            let target = law.targets.first().map(|target| self.program.index.function(*target).name.clone());
            let method = target.unwrap_or_else(|| self.called_name(id).to_owned());
            let update = Update {
                place,
                law: law.group,
                method,
                run_by: RunBy::Code,
                is_typed,
                given: None,
                attempt,
                fed,
                into,
                from,
            };
            // What stands in several parts of the law runs all of them.
            let further = law.spec.law.iter().enumerate().skip(law.group + 1);
            let runs = |part: &(usize, &LawGroup)| part.1.methods.contains(&update.method);
            let updates: Vec<Update> =
                further.filter(runs).map(|(half, _)| Update { law: half, ..update.clone() }).collect();
            for update in std::iter::once(update).chain(updates) {
                self.emit(Effect::Update(update), self.span(id));
            }
        }
        if let Some(given) = receiver.and_then(|place| self.chained_law(id, &law, exprs[0], &place)) {
            return given;
        }
        let is_owned = !matches!(self.ty(id), Ty::Ref(..));
        Value { place: Some(Place::var(result)), is_owned, same_as: Some(result), ..Value::default() }
    }

    /// The variable that a law is lent for its result: `gen.tick(&mut frame)`.
    fn result_lent(&mut self, arg: ExprId) -> Option<Var> {
        let ExprKind::Reference { mutable: true, value, .. } = self.body().expr(arg).kind else { return None };
        let var = self.static_place(value)?.base_var()?;
        let is_own = self.graph.var(var).param.is_none() && !self.program.index.holds_filter(self.ty(value));
        is_own.then_some(var)
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
        self.lose_others(of, exprs, values, id);
        // Which body a type parameter means is known where the function is called for one type.
        let receiver = of.and_then(|at| exprs.get(at));
        let is_open = receiver.is_some_and(|first| matches!(self.ty(*first).peel(), Ty::Param(_) | Ty::Opaque(_)));
        if is_open { targets } else { &[] }
    }

    /// What a call gets besides one argument is unknown from there on.
    fn lose_others(&mut self, of: Option<usize>, exprs: &[ExprId], values: &[Value], id: ExprId) {
        let others = exprs.iter().zip(values).enumerate().filter(|(at, _)| Some(*at) != of);
        let places: Vec<Place> = others
            .filter(|(_, (expr, _))| !self.is_shared(**expr) && self.may_hold_filter(self.ty(**expr)))
            .filter_map(|(_, (_, value))| value.place.clone())
            .collect();
        if !places.is_empty() {
            let cause = Cause::Call(self.text(id));
            self.emit(Effect::Unknown { places, cause }, self.span(id));
        }
    }

    /// Whether a trait that is not read declares what is called: other crates may have bodies of it.
    pub(super) fn is_of_foreign_trait(resolved: &Resolved) -> bool {
        matches!(resolved.owner, Some(MethodOwner::Declared(TraitName::External(_), None)))
    }

    /// What a method of such a trait does with its receiver is what one of the bodies that are read does, for other crates do not know
    /// the type. What it does with everything else is not known.
    pub(super) fn lose_to_foreign(&mut self, resolved: &Resolved, exprs: &[ExprId], values: &[Value], id: ExprId) {
        if Self::is_of_foreign_trait(resolved) {
            self.lose_others(Some(0), exprs, values, id);
        }
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

    /// The argument whose state a call hands on, `self` first, and where its result has it: the one of that type. Where types do
    /// not tell, it is the first one behind the receiver.
    pub(super) fn hands(
        &mut self,
        id: ExprId,
        law: Option<&Law<'_>>,
        exprs: &[ExprId],
    ) -> Option<(usize, Option<usize>)> {
        let output = self.ty(id);
        let skip = law.map_or(0, |law| usize::from(law.has_receiver));
        let is_state = |ty: &Ty| self.program.index.returned_spec(ty).is_some();
        let part = |at: usize| {
            let ty = self.ty(exprs[at]).peel();
            let is_known = is_state(ty) && (law.is_some() || matches!(ty, Ty::Adt(..)));
            is_known.then(|| handed(output, ty)).flatten().map(|part| (at, part))
        };
        // A state that has the law itself is the receiver: `estimate = estimate.step(z)`.
        if let Some(own) = (skip > 0).then(|| part(0)).flatten() {
            return Some(own);
        }
        let mut found: Vec<_> = (skip..exprs.len()).filter_map(part).collect();
        if law.is_none() {
            return (found.len() == 1).then(|| found[0]);
        }
        // Of several numbers, it is the one that the result takes the place of.
        let targets = self.targets.clone();
        found.sort_by_key(|(at, _)| {
            let is_target = self.reads_of(exprs[*at]).iter().any(|var| targets.contains(var));
            (is_number(self.ty(exprs[*at]).peel()), !is_target)
        });
        found.first().copied().or_else(|| (skip < exprs.len()).then_some((skip, None)))
    }

    /// A law runs that gives back the next state.
    fn law_advances(&mut self, id: ExprId, law: &Law<'_>, exprs: &[ExprId], values: &[Value], result: Var) {
        self.graph.gives_next = true;
        let Some((at, part)) = self.hands(id, Some(law), exprs) else { return };
        let Some(before) = values[at].place.clone() else { return };
        let key = |number: &u32| {
            let at = *number as usize + usize::from(law.has_receiver);
            Some((*exprs.get(at)?, values.get(at)?))
        };
        let keys: Vec<(ExprId, &Value)> = law.spec.key.iter().filter_map(key).collect();
        let before = keys.into_iter().fold(before, |place, (key, value)| self.channel(place, key, value));
        let after = part.map_or_else(|| Place::var(result), |part| Place::var(result).field(&part.to_string()));
        let may_fail = matches!(self.ty(id), Ty::External(path, _) if path.ends_with("Result"));
        let advance = Advance {
            before,
            after,
            law: law.group,
            method: self.called_name(id).to_owned(),
            attempt: may_fail.then_some(result),
            is_dropped: false,
        };
        self.advanced.insert(result);
        self.emit(Effect::Advance(Box::new(advance)), self.span(id));
    }

    /// A state that laws gave back may take the place of the one before: that is the update. Answers whether it may.
    pub(super) fn take_over(&mut self, target: ExprId, place: &Place, value: &Value, source: ExprId) -> bool {
        self.take_over_part(target, source);
        self.take_over_in(self.ty(target).peel(), place, value, source)
    }

    /// A part of a state may get what a law gave back: how far it is ahead then, nothing tells.
    fn take_over_part(&mut self, target: ExprId, source: ExprId) {
        let ExprKind::Field { base, .. } = self.body().expr(target).kind else { return };
        if self.program.index.returned_spec(self.ty(base).peel()).is_none() {
            return;
        }
        let Some(place) = self.static_place(base) else { return };
        let reads = self.reads_of(source);
        if reads.into_iter().any(|var| Some(var) != place.base_var() && self.advanced.contains(&var)) {
            let cause = Cause::Code("what a law gives back, put in its place part by part,".to_owned());
            self.emit(Effect::Unknown { places: vec![place], cause }, self.span(target));
        }
    }

    /// The same for what is no assignment, as `mem::replace(&mut state, next)`: the type of the state tells.
    pub(super) fn take_over_in(&mut self, ty: &Ty, place: &Place, value: &Value, source: ExprId) -> bool {
        let Some(given) = value.place.clone() else { return false };
        let is_advanced = given.base_var().is_some_and(|var| self.advanced.contains(&var));
        if !is_advanced && self.program.index.returned_spec(ty).is_none() {
            return false;
        }
        let update = Update {
            place: place.clone(),
            law: 0,
            method: String::new(),
            run_by: RunBy::Code,
            is_typed: false,
            given: Some(given),
            attempt: None,
            fed: self.reads_of(source),
            into: Vec::new(),
            from: self.computed_from(source),
        };
        self.emit(Effect::Update(update), self.span(source));
        true
    }

    /// What is known of a call as a law, and which half it runs.
    pub(super) fn law_of(&self, resolved: &Resolved) -> Option<(&'a FilterSpec, usize)> {
        let index = self.program.index;
        match (resolved.law, resolved.targets.as_slice()) {
            (Some(group), _) => Some((index.law_spec(&resolved.self_ty).unwrap_or(index.trait_spec()), group)),
            (None, [target]) => {
                let def = Def::Function(*target);
                let spec = index.function_spec(&def)?;
                Some((spec, index.group_of(spec, &def)))
            }
            _ => None,
        }
    }

    /// Whether a method resets its receiver, a filter: `true` if it resets all of it with these arguments.
    pub(super) fn resets(&self, name: &str, resolved: &Resolved, args: &[ExprId]) -> Option<bool> {
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
        let heads: Vec<Option<Head>> = args.iter().map(|arg| self.constant_head(*arg)).collect();
        let is_full = |target: &FunctionId| self.is_full_reset(*target, &resolved.self_ty, &heads);
        Some(!is_judged || resolved.targets.iter().all(is_full))
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
