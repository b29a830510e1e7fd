//! Calls: of analysed code, of the standard library, and of what cannot be seen.

use super::laws::Law;
use super::{Builder, Value};
use crate::flow::{Argument, CallSite, Computed, Effect, IndexKey, Place, Transfer, Var};
use crate::index::{Def, FunctionId, Owner, Ty};
use crate::syntax::tree::{ExprId, ExprKind};
use crate::types::{Callee, Resolved};

impl Builder<'_> {
    pub(super) fn call_expr(&mut self, id: ExprId, callee: ExprId, args: &[ExprId]) -> Value {
        if let Some(guard) = self.guard_made(id, args) {
            return guard;
        }
        self.note_put_into_sample(id, args);
        match self.typed().callees.get(&id) {
            Some(Callee::Constructor(def)) => self.constructor(id, def.clone().as_ref(), args),
            Some(Callee::Resolved(_)) if let Some(lent) = self.static_lent(id) => {
                Value { place: Some(lent), is_owned: false, ..Value::default() }
            }
            Some(Callee::Resolved(resolved)) => {
                let resolved = resolved.clone();
                let values = self.values(args);
                match self.deferred_call(id, &resolved, args, &values) {
                    Some(future) => future,
                    None => self.resolved_call(id, &resolved, args, &values),
                }
            }
            Some(Callee::External(path)) => {
                let path = path.clone();
                self.external_call(id, &path, args)
            }
            Some(Callee::Builtin) => self.path_method(id, callee, args),
            Some(Callee::Closure(_) | Callee::Parameter(_) | Callee::Unknown) | None => {
                let value = self.expr(callee);
                let values = self.values(args);
                if let Some(closure) = value.closure {
                    return self.call_closure(id, closure, values);
                }
                self.calls_kept(callee, &value);
                match self.call_one_of_all(id, callee, args, &values) {
                    Some(value) => value,
                    None => self.unknown_call(id, self.text(callee), args, &values),
                }
            }
        }
    }

    pub(super) fn values(&mut self, args: &[ExprId]) -> Vec<Value> {
        let values: Vec<Value> = args.iter().map(|arg| self.expr(*arg)).collect();
        for (value, arg) in values.iter().zip(args) {
            self.note_mixed(*arg);
            if !matches!(self.ty(*arg), Ty::Ref(..)) {
                self.lose_made(value);
            }
        }
        values
    }

    fn constructor(&mut self, id: ExprId, def: Option<&Def>, args: &[ExprId]) -> Value {
        match def {
            Some(Def::External(path)) => {
                let value = args.first().map(|arg| self.expr(*arg)).unwrap_or_default();
                let head = super::subjects::external_head(path);
                Value { head: Some(head), same_as: None, ..value }
            }
            Some(Def::Variant(ty, at)) => {
                let variant = super::constants::variant_head(self.program, *ty, *at);
                let span = self.span(id);
                let var = self.temporary(self.ty(id).clone(), span);
                for (number, arg) in args.iter().enumerate() {
                    let value = self.expr(*arg);
                    self.place_part(Place::var(var).field(&variant).field(&number.to_string()), &value, *arg);
                }
                Value { place: Some(Place::var(var)), is_owned: true, head: Some(variant), ..Value::default() }
            }
            _ => {
                let value = self.aggregate(id, args);
                self.note_literal(id, &value);
                value
            }
        }
    }

    pub(super) fn method_expr(&mut self, id: ExprId, receiver: ExprId, method: &str, args: &[ExprId]) -> Value {
        let first = self.graph.nodes.len();
        let value = self.method_value(id, receiver, method, args);
        self.note_filled_by(receiver, method, args);
        if !matches!(self.typed().callees.get(&id), Some(Callee::Resolved(_))) {
            self.note_provided(receiver, method);
        }
        if value.same_as.is_some() && self.option_taken(id).is_some() {
            return value;
        }
        self.note_filters_resized(id, receiver, method);
        if super::borrowed::changes_receiver(method)
            && !matches!(self.typed().callees.get(&id), Some(Callee::Resolved(_)))
            && !self.may_hold_filter(self.ty(receiver))
            && !super::flags::is_flag(self.ty(receiver))
            && (method != "replace" || !self.is_cell(receiver))
        {
            // What is put in was noted.
            let is_filled = method.starts_with("get_or_insert") && self.is_optional(receiver) && value.place.is_some();
            if !(args.len() == 1 && matches!(method, "replace" | "insert" | "clone_from") || is_filled) {
                self.note_lent(receiver);
                self.note_resized(first, receiver, method, args);
            }
            // What was taken out is no longer what is asked for by the receiver's name.
            return Value { place: None, same_as: None, head: None, ..value };
        }
        value
    }

    /// What an object writes into a variable that it is lent comes from the object: `imu.read(&mut sample)`.
    fn note_filled_by(&mut self, receiver: ExprId, method: &str, args: &[ExprId]) {
        let is_filter = self.program.index.filter_spec(self.ty(receiver).peel()).is_some();
        let Some(from) = self.static_place(receiver).filter(|_| !is_filter) else { return };
        for arg in args {
            let ExprKind::Reference { mutable: true, value, .. } = self.body().expr(*arg).kind else { continue };
            let filled = self.static_place(value).and_then(|place| place.base_var());
            if let Some(var) = filled.filter(|_| self.program.index.is_plain(self.ty(value))) {
                let computed = self.graph.computed.entry(var).or_default();
                computed.places.push(from.clone());
                computed.calls.push(method.to_owned());
            }
        }
    }

    fn method_value(&mut self, id: ExprId, receiver: ExprId, method: &str, args: &[ExprId]) -> Value {
        self.note_method_wait(id, receiver, method, args);
        self.note_lent_by(receiver, method);
        self.note_clone(id, receiver, method, args);
        self.note_copied_into(receiver, method, args);
        self.note_put_into_sample(id, &[&[receiver], args].concat());
        if let Some(value) = self.guard_call(id, receiver, method, args) {
            return value;
        }
        if let Some(value) = self.adapted_call(id, receiver, method, args) {
            return value;
        }
        if let Some(value) = self.adapt_each(id, receiver, method, args) {
            return value;
        }
        if let Some(value) = self.iterator_call(id, receiver, method, args) {
            return value;
        }
        if let Some(value) = self.lazy_call(id, receiver, method) {
            return value;
        }
        match self.typed().callees.get(&id) {
            Some(Callee::Resolved(resolved)) => {
                let resolved = resolved.clone();
                let value = self.expr(receiver);
                self.drop_lent(&resolved.targets, receiver, &value);
                let place = value.place.map(|place| {
                    resolved
                        .derefs
                        .iter()
                        .fold(place, |place, through| self.dereferenced(place, *through, self.span(id)))
                });
                let mut values = vec![Value { place, ..value }];
                values.extend(self.values(args));
                let mut exprs = vec![receiver];
                exprs.extend_from_slice(args);
                match self.deferred_call(id, &resolved, &exprs, &values) {
                    Some(future) => future,
                    None => self.resolved_call(id, &resolved, &exprs, &values),
                }
            }
            Some(Callee::Builtin) => self.builtin_method(id, receiver, method, args),
            _ => self.unseen_method(id, receiver, method, args),
        }
    }

    /// A call of analysed code; `exprs` and `values` begin with `self` if there is one.
    pub(super) fn resolved_call(
        &mut self,
        id: ExprId,
        resolved: &Resolved,
        exprs: &[ExprId],
        values: &[Value],
    ) -> Value {
        if self.at.is_none() {
            return Value::default();
        }
        let span = self.span(id);
        let self_place = values.first().filter(|_| resolved.has_receiver).and_then(|value| value.place.clone());
        if let Some((spec, group)) = self.law_of(resolved) {
            let law = Law { spec, group, targets: &resolved.targets, has_receiver: resolved.has_receiver };
            return self.law_call(id, law, exprs, values);
        }
        if let Some(place) = &self_place
            && let Some(full) = self.resets(self.called_name(id), resolved, exprs)
        {
            self.emit(Effect::Reset { place: place.clone(), full }, span);
            // What a partial reset leaves may all be the owner's own, and its parts be reset in full.
            if !full && self.program.index.has_filters_inside(&resolved.self_ty) {
                self.emit_call(id, &resolved.targets, exprs, values, None);
            }
            return self.chained(id, resolved, place);
        }
        if let Some((place, full)) = self.reset_by_function(resolved, values) {
            self.emit(Effect::Reset { place, full }, span);
            return Value::default();
        }
        if let Some((place, full)) = self.resets_state(self.called_name(id), resolved, exprs, values) {
            self.emit(Effect::Reset { place, full }, span);
            return Value::default();
        }
        self.lends_kept(id, &resolved.targets, exprs, values);
        if values.iter().any(|value| value.closure.is_some() || value.iterator.is_some()) {
            if let Some(value) = self.runs_given(id, values) {
                return value;
            }
            let is_foreign = Self::is_of_foreign_trait(resolved);
            let keeps = |target: &FunctionId| {
                is_foreign || self.keeps_callback(id, *target, values) || self.polls(*target, values)
            };
            if let [target] = resolved.targets.as_slice()
                && !keeps(target)
                && let Some(value) = self.inline_function(*target, values, span)
            {
                return value;
            }
            return self.unknown_call(id, self.text(id), exprs, values);
        }
        if values.iter().any(|value| self.is_polled(value)) {
            if let Some(value) = self.runs_given(id, values) {
                return value;
            }
            if resolved.targets.iter().any(|target| self.polls(*target, values)) {
                return self.unknown_call(id, self.text(id), exprs, values);
            }
        }
        let is_declared = |target: &FunctionId| self.program.index.function(*target).function.body.is_none();
        if resolved.owner.is_none() && !resolved.targets.is_empty() && resolved.targets.iter().all(is_declared) {
            return self.extern_call(id, &resolved.targets, exprs, values);
        }
        if resolved.targets.is_empty() {
            // Nothing implements it here: what a filter's own trait declares beside the law does not run the law, and what
            // takes `&self` changes nothing.
            let of_filter = match &resolved.owner {
                Some(owner) => owner.of_trait().is_some_and(|name| self.program.index.is_filter_trait(name)),
                None => true,
            };
            let reads = resolved.owner.as_ref().and_then(crate::index::MethodOwner::function).is_some_and(|function| {
                self.program.index.function(function).function.receiver == Some(crate::syntax::tree::Receiver::Shared)
            });
            let skip = usize::from(resolved.has_receiver && (of_filter || reads));
            if let Some(place) = &self_place {
                self.emit(Effect::Use { place: place.clone() }, span);
            }
            let value = self.unknown_call(id, self.text(id), &exprs[skip..], &values[skip..]);
            return match &self_place {
                Some(place) if skip == 1 => self.chained_unread(id, resolved, place, exprs.len() > 1),
                _ => value,
            };
        }
        if let Some(copy) = self.copy_given(id, self_place.as_ref()) {
            return copy;
        }
        if let Some(value) = self.switch_call(resolved, exprs, values, id) {
            return value;
        }
        if let Some(closure) = self.closure_made(id, resolved, values) {
            return closure;
        }
        if self.is_guard(id) {
            return self.guard_from_call(id, resolved, exprs, values);
        }
        self.lose_to_foreign(resolved, exprs, values, id);
        let result = self.emit_call(id, &resolved.targets, exprs, values, None);
        self.note_lent_for_longer(id, &resolved.targets, exprs);
        self.keep_handles(id, exprs, values);
        self.give_away(id, &resolved.targets, exprs, values);
        self.give_destructors(&resolved.targets, exprs, values, span);
        if self.never_returns(id) {
            self.diverge(span);
            return Value::default();
        }
        if let Some(copy) = self.clone_given(id, &resolved.targets, exprs, values) {
            return copy;
        }
        let is_owned = !matches!(self.ty(id), Ty::Ref(..));
        Value { place: Some(Place::var(result)), is_owned, same_as: Some(result), ..Value::default() }
    }

    /// A call of analysed code; `law_of` is the number of the argument whose law it is.
    pub(super) fn emit_call(
        &mut self,
        id: ExprId,
        targets: &[FunctionId],
        exprs: &[ExprId],
        values: &[Value],
        law_of: Option<usize>,
    ) -> Var {
        let span = self.span(id);
        let result = self.temporary(self.ty(id).clone(), span);
        let receiver = match &self.body().expr(id).kind {
            ExprKind::MethodCall { receiver, .. }
            | ExprKind::AssignOp { place: receiver, .. }
            | ExprKind::Index { base: receiver, .. } => Some(*receiver),
            _ => None,
        };
        // `flag.flip()` of a trait of the analysed code.
        let is_lent = |expr: ExprId| {
            use crate::syntax::tree::Receiver::Exclusive;
            let of = |target: &FunctionId| self.program.index.function(*target).function.receiver == Some(Exclusive);
            receiver == Some(expr) && targets.iter().any(of)
        };
        let lent: Vec<bool> = exprs.iter().map(|expr| is_lent(*expr)).collect();
        let hands = self.hands(id, None, exprs);
        let mut args: Vec<Argument> = Vec::new();
        for (number, ((expr, value), is_lent)) in exprs.iter().zip(values).zip(lent).enumerate() {
            let is_moved = self.is_passed_by_value(*expr, value, receiver, targets);
            let is_copy = law_of.is_none()
                && is_moved
                && (value.leaves_by == Some(Transfer::Copy) || self.program.index.copies_filter(self.ty(*expr)));
            // What is handed through goes on in the result.
            let is_handed = hands.is_some_and(|(handed, _)| handed == number);
            let place = value.place.clone().filter(|_| !super::values::is_plain(self.ty(*expr)) || is_lent);
            let place = match place {
                Some(_) if is_copy && !is_handed => self.copy_of(value, self.ty(*expr).clone(), span).place,
                place => place,
            };
            args.push(Argument {
                place,
                index: self.argument_index(*expr, value),
                value_of: self.value_of(*expr).or_else(|| self.state_given(*expr, value)),
                head: value.head.clone().or_else(|| self.name_behind(*expr)),
                is_setting: self.is_setting(*expr),
                is_shared: self.is_shared(*expr),
                is_moved,
                is_reference: self.program.index.refers_to_filters(self.ty(*expr)),
                is_plain: super::values::is_plain(self.ty(*expr)),
                lends_references: matches!(self.ty(*expr), Ty::Ref(true, inner) if self.program.index.refers_to_filters(inner)),
                is_back: false,
                is_copy,
                from: if receiver == Some(*expr) { Computed::default() } else { self.computed_from(*expr) },
            });
        }
        self.note_handed_back(id, &mut args);
        let text = self.text(id);
        let (mut fed, mut from) = (Vec::new(), Computed::default());
        for arg in exprs.iter().skip(1) {
            fed.extend(self.reads_of(*arg));
            let computed = self.computed_from(*arg);
            from.places.extend(computed.places);
            from.calls.extend(computed.calls);
        }
        if !matches!(self.body().expr(id).kind, ExprKind::MethodCall { .. })
            && let Some(first) = exprs.first()
        {
            fed.extend(self.reads_of(*first));
        }
        let into = self.targets.clone();
        if let [target] = targets {
            let ty = self.ty(id).clone();
            self.note_given_step(*target, result, &ty, exprs);
        }
        // Many bodies tell nothing of what lies inside the one receiver that is meant, and what lies inside a filter is its own
        // law's business.
        let is_known = match law_of {
            Some(_) => targets.len() == 1 && targets[0] != self.graph.function,
            None => targets.len() <= super::laws::MAX_DISPATCHED,
        };
        let is_dispatched = !is_known
            && exprs
                .get(law_of.unwrap_or(0))
                .is_some_and(|first| matches!(self.ty(*first).peel(), Ty::Param(_) | Ty::Opaque(_)));
        let hands = hands.map(|(at, part)| {
            let whole = Place::var(result);
            (at, part.map_or(whole.clone(), |part| whole.field(&part.to_string())))
        });
        let types = self.deciding_types(id, targets, exprs);
        let targets = targets.to_vec();
        let site = CallSite { targets, args, types, result, hands, text, law_of, is_dispatched, fed, into, from };
        self.emit(Effect::Call(Box::new(site)), span);
        result
    }

    /// Whether a function gets what an argument names, or a copy of it, and not a reference to it.
    pub(super) fn is_passed_by_value(
        &self,
        expr: ExprId,
        value: &Value,
        receiver: Option<ExprId>,
        targets: &[FunctionId],
    ) -> bool {
        // What is converted is the argument of a function without a receiver.
        let by_value = |target: &FunctionId| {
            let def = self.program.index.function(*target);
            // `impl Step for &mut Rig` is lent a rig.
            let is_of_reference =
                matches!(def.owner, Owner::Impl(of) if matches!(self.program.index.impl_def(of).self_ty, Ty::Ref(..)));
            matches!(def.function.receiver, None | Some(crate::syntax::tree::Receiver::Value)) && !is_of_reference
        };
        let is_reference = matches!(self.ty(expr), Ty::Ref(..));
        value.is_owned && !is_reference && (receiver != Some(expr) || targets.iter().all(by_value))
    }

    /// The index that an argument is; `None` if it is a range. A parameter that is given another number is one that data decides.
    pub(super) fn argument_index(&mut self, expr: ExprId, value: &Value) -> Option<IndexKey> {
        let told = value.head.as_deref().and_then(IndexKey::of_head);
        let key = told.or_else(|| self.index_key(expr))?;
        let IndexKey::Var(var) = key else { return Some(key) };
        let is_changed = self.graph.var(var).param.is_some() && self.is_assigned(var);
        Some(if is_changed { IndexKey::Data(self.graph.var(var).name.clone().into()) } else { key })
    }

    /// The place whose value an argument is. What is cast has other heads.
    fn value_of(&mut self, expr: ExprId) -> Option<Place> {
        let mut at = expr;
        while let ExprKind::Reference { value, .. } | ExprKind::Deref(value) = &self.body().expr(at).kind {
            at = *value;
        }
        if matches!(self.body().expr(at).kind, ExprKind::Cast { .. }) {
            return None;
        }
        let pure = self.pure(at)?;
        if pure.whole.is_some() && self.is_state(self.ty(at)) {
            // What is called may ask for it.
            self.state_subject(pure.clone(), at);
        }
        pure.whole
    }

    /// Whether an argument is a shared reference or a plain value, through which nothing is updated.
    pub(super) fn is_shared(&self, expr: ExprId) -> bool {
        if self.updates_shared(self.ty(expr)) {
            return false;
        }
        match &self.body().expr(expr).kind {
            ExprKind::Reference { mutable: false, raw: false, .. } => !matches!(self.ty(expr), Ty::Ref(true, _)),
            _ => matches!(self.ty(expr), Ty::Ref(false, _)) || self.iterates_shared(self.ty(expr)),
        }
    }
}

/// The last two names of a path.
pub(super) fn path_tail(path: &str) -> String {
    let parts: Vec<&str> = path.split("::").collect();
    parts[parts.len().saturating_sub(2)..].join("::")
}
