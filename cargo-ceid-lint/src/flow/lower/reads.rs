//! What an expression reads and calls, anywhere in it, and what a closure names of its surroundings.

use std::collections::{BTreeMap, BTreeSet};

use super::Builder;
use super::closures::ClosureRef;
use super::received::received_by;
use crate::flow::{Computed, Place, Var};
use crate::index::{FunctionId, MethodOwner, Ty};
use crate::syntax::tree::{ExprId, ExprKind, PatId, PatKind, Receiver, TypeRef};
use crate::types::{Callee, LocalId, TypedBody, is_lock};

impl Builder<'_> {
    /// Whether an argument is what a field of a filter holds whose code is not read: the filter stays where it is.
    pub(super) fn is_value_of_filter(&self, expr: ExprId) -> bool {
        let ExprKind::Field { base, .. } = &self.body().expr(expr).kind else { return false };
        let of = self.ty(*base).peel();
        *self.ty(expr) == Ty::Unknown && matches!(of, Ty::External(..)) && self.program.index.filter_spec(of).is_some()
    }

    /// The variables that an expression reads anywhere in it, but for those that it binds itself.
    pub(super) fn reads_of(&mut self, id: ExprId) -> Vec<Var> {
        let body = self.body();
        let span = body.expr(id).span;
        let mut vars = Vec::new();
        for expr in body.within(id) {
            if let Some(place) = self.stand_in(expr) {
                vars.extend(place.base_var());
            } else if let Some(local) = self.typed().expr_local.get(&expr).copied() {
                // What a macro writes all stands where it is called, in it and around it.
                let declared = self.typed().local(local).span;
                if declared == span || !span.contains(declared) {
                    vars.push(self.var_of(local));
                }
            }
        }
        vars
    }

    /// Notes that variables are computed from what an expression reads.
    pub(super) fn derive(&mut self, vars: &[Var], from: ExprId) {
        for read in self.reads_of(from) {
            self.graph.derived.extend(vars.iter().map(|var| (*var, read)));
        }
        if self.receives(from) {
            self.graph.received.extend(vars);
        }
        let computed = self.computed_from(from);
        let span = self.span(from);
        self.graph.read_at.extend(vars.iter().map(|var| (*var, span)));
        for var in vars {
            let all = self.graph.computed.entry(*var).or_default();
            all.places.extend(computed.places.iter().cloned());
            all.calls.extend(computed.calls.iter().cloned());
        }
    }

    /// Notes that a collection of the iteration is computed from what is put into it: `frame.push(input[i])`. What lives longer keeps
    /// what was there before.
    pub(super) fn derive_scratch(&mut self, collection: ExprId, given: &[ExprId]) {
        let mut vars = self.assigned_vars(collection);
        vars.retain(|var| self.graph.var(*var).in_loop.is_some());
        for given in given {
            let (read, computed) = (self.reads_of(*given), self.computed_from(*given));
            for var in &vars {
                self.graph.derived.extend(read.iter().map(|read| (*var, *read)));
                let all = self.graph.computed.entry(*var).or_default();
                all.places.extend(computed.places.iter().cloned());
                all.calls.extend(computed.calls.iter().cloned());
            }
        }
    }

    /// Notes what the names of a pattern are computed from: where a tuple is written out, each part from its own.
    pub(super) fn derive_pattern(&mut self, pat: PatId, from: ExprId) {
        let body = self.body();
        match (&body.pat(pat).kind, &body.expr(from).kind) {
            (PatKind::Or(pats), _) => {
                for pat in pats {
                    self.derive_pattern(*pat, from);
                }
            }
            (PatKind::Tuple(pats), ExprKind::Tuple(parts)) if !pats.iter().any(|pat| body.is_rest(*pat)) => {
                for (pat, part) in pats.iter().zip(parts) {
                    self.derive_pattern(*pat, *part);
                }
            }
            _ => {
                let bound = self.vars_of(pat);
                self.derive(&bound, from);
            }
        }
    }

    /// Whether an expression takes something out of a source that it changes, and gives it nothing to compute with:
    /// `radio.wait()`, `next_packet(&mut port)`.
    pub(super) fn receives(&self, id: ExprId) -> bool {
        let body = self.body();
        let given = match &body.expr(id).kind {
            ExprKind::Try(inner) | ExprKind::Await(inner) => return self.receives(*inner),
            ExprKind::MethodCall { args, .. } => args.len() + 1,
            ExprKind::Call { args, .. } => args.len(),
            _ => return false,
        };
        let Some(Callee::Resolved(called)) = self.typed().callees.get(&id) else { return false };
        let declared = called.owner.as_ref().and_then(MethodOwner::function);
        let Some(function) = called.targets.first().copied().or(declared) else { return false };
        let function = &self.program.index.function(function).function;
        let is_exclusive = match (&function.receiver, function.params.as_slice()) {
            (Some(receiver), []) => *receiver == Receiver::Exclusive,
            (None, [TypeRef::Reference { mutable, .. }]) => *mutable,
            _ => false,
        };
        given == 1 && is_exclusive && called.law.is_none()
    }

    /// The places that an expression reads and the functions it calls, anywhere in it.
    pub(super) fn computed_from(&mut self, id: ExprId) -> Computed {
        let body = self.body();
        let mut computed = Computed::default();
        let (mut limits, mut asked) = (BTreeSet::<ExprId>::new(), BTreeSet::<ExprId>::new());
        for expr in body.within(id) {
            if limits.contains(&expr) {
                continue;
            }
            limits.extend(self.limits_of_wait(expr).flat_map(|limit| body.within(limit)));
            computed.calls.extend(received_by(self.constants(), expr).map(str::to_owned));
            match &body.expr(expr).kind {
                ExprKind::MethodCall { receiver, method, args, .. } => {
                    computed.calls.push(method.clone());
                    match (method.as_str(), args.as_slice()) {
                        // What decides whether there is a value has no part in it.
                        ("and", [_]) => limits.extend(body.within(*receiver)),
                        ("filter", [arg]) => asked.extend(body.within(*arg)),
                        _ => {}
                    }
                }
                ExprKind::Await(_) => computed.calls.push("await".to_owned()),
                ExprKind::Path(path) if path.segments.len() > 1 => computed.calls.push(path.last().to_owned()),
                ExprKind::Call { callee, .. } => {
                    let is_handed =
                        !asked.contains(&expr) && matches!(self.typed().callees.get(&expr), Some(Callee::Parameter(_)));
                    if let ExprKind::Path(path) = &body.expr(*callee).kind
                        && path.segments.len() == 1
                        && (is_handed || !self.typed().expr_local.contains_key(callee))
                    {
                        computed.calls.push(path.last().to_owned());
                    }
                }
                ExprKind::Field { .. } | ExprKind::Path(_) => computed.places.extend(self.static_place(expr)),
                _ => {}
            }
        }
        computed
    }

    /// How long a call waits at most for what it gives, which has no part in that: `rx.recv_timeout(left)`.
    fn limits_of_wait(&self, id: ExprId) -> impl Iterator<Item = ExprId> {
        let body = self.body();
        let waits = |id: ExprId| matches!(self.ty(id).external_name(), Some("Option" | "Result"));
        let is_time =
            |id: ExprId| matches!(self.ty(id).peel().external_name(), Some("Duration" | "Instant" | "SystemTime"));
        let args = match &body.expr(id).kind {
            ExprKind::MethodCall { method, args, .. } if method.ends_with("_timeout") => args.clone(),
            ExprKind::MethodCall { receiver, args, .. } if waits(id) && !is_time(*receiver) => {
                args.iter().copied().filter(|arg| is_time(*arg)).collect()
            }
            _ => Vec::new(),
        };
        args.into_iter()
    }

    /// What of its surroundings a closure names that may hold a filter, by itself or through the closures that it names.
    pub(super) fn captured(&self, closure: ClosureRef) -> Vec<Place> {
        let mut places = BTreeSet::new();
        let mut seen = BTreeSet::new();
        let mut open = vec![closure];
        while let Some(closure) = open.pop() {
            if !seen.insert((closure.frame, closure.expr)) {
                continue;
            }
            if let Some(given) = self.given_to_future(closure) {
                places.extend(given);
                continue;
            }
            let named = self.captured_locals(closure).into_iter();
            places.extend(named.map(|(local, var)| Place::var(self.own_copy(closure, local).unwrap_or(var))));
            open.extend(self.named_locals(closure).filter_map(|(_, var)| self.closures.get(&var)));
        }
        places.into_iter().collect()
    }

    /// The places of its surroundings that a closure names and may update: parts of them where it names no more than these, and
    /// not those of which it only asks something.
    pub(super) fn captured_to_update(&self, closure: ClosureRef) -> Vec<Place> {
        let whole = self.captured(closure);
        if self.given_to_future(closure).is_some()
            || self.named_locals(closure).any(|(_, var)| self.closures.contains_key(&var))
        {
            return whole;
        }
        let frame = &self.frames[closure.frame];
        let inside: BTreeMap<ExprId, ExprId> = self.uses_inside(closure).collect();
        let mut places = BTreeSet::new();
        for (mention, local, var) in self.mentions(closure) {
            let mut place = Place::var(self.own_copy(closure, local).unwrap_or(var));
            let mut at = mention;
            while let Some(user) = inside.get(&at)
                && let ExprKind::Field { name, .. } = &frame.body.expr(*user).kind
                && self.program.index.field_ty(frame.typed.ty(at).peel(), None, name).is_some()
            {
                place = place.field(name);
                at = *user;
            }
            let ty = frame.typed.ty(at);
            let is_asked = inside.get(&at).is_some_and(|user| match &frame.body.expr(*user).kind {
                ExprKind::Reference { mutable, raw, .. } => !mutable && !raw,
                ExprKind::MethodCall { .. } => self.takes_shared(frame.typed, *user),
                _ => false,
            });
            let is_shared = is_asked || matches!(ty, Ty::Ref(false, _));
            let is_beside_law = inside.get(&at).is_some_and(|user| self.is_beside_law(closure.frame, *user));
            if self.may_hold_filter(ty)
                && !is_beside_law
                && !(is_shared && self.program.index.shares_no_filter(ty, is_lock))
            {
                places.insert(place);
            }
        }
        places.into_iter().collect()
    }

    /// The copy that a closure has of a local.
    fn own_copy(&self, closure: ClosureRef, local: LocalId) -> Option<Var> {
        let copies = self.captures.get(&(closure.frame, closure.expr))?;
        copies.iter().find(|(own, _)| *own == local).map(|(_, copy)| *copy)
    }

    /// Whether a call is a method of a filter whose code is not read that neither runs its law nor resets it: its entry names all
    /// that do.
    fn is_beside_law(&self, frame: usize, call: ExprId) -> bool {
        let frame = &self.frames[frame];
        let (ExprKind::MethodCall { method, .. }, Some(Callee::Resolved(resolved))) =
            (&frame.body.expr(call).kind, frame.typed.callees.get(&call))
        else {
            return false;
        };
        let spec = self.program.index.law_spec(&resolved.self_ty).filter(|_| resolved.targets.is_empty());
        spec.is_some_and(|spec| {
            resolved.law.is_none() && !spec.resets.contains(method) && !spec.partial_resets.contains(method)
        })
    }

    /// Whether all that a call may run takes `&self`.
    fn takes_shared(&self, typed: &TypedBody, call: ExprId) -> bool {
        let Some(Callee::Resolved(resolved)) = typed.callees.get(&call) else { return false };
        let receiver = |id: &FunctionId| self.program.index.function(*id).function.receiver.as_ref();
        !resolved.targets.is_empty() && resolved.targets.iter().all(|id| receiver(id) == Some(&Receiver::Shared))
    }

    /// What each place inside of a closure is named for: its field, a reference to it, a call of its method.
    fn uses_inside(&self, closure: ClosureRef) -> impl Iterator<Item = (ExprId, ExprId)> {
        let body = &self.frames[closure.frame].body;
        body.within(closure.expr).rev().filter_map(|id| match &body.expr(id).kind {
            ExprKind::Field { base, .. } => Some((*base, id)),
            ExprKind::Reference { value, .. } => Some((*value, id)),
            ExprKind::MethodCall { receiver, .. } => Some((*receiver, id)),
            _ => None,
        })
    }

    /// The locals of its surroundings that a closure names and that may hold a filter, with their variables.
    pub(super) fn captured_locals(&self, closure: ClosureRef) -> BTreeSet<(LocalId, Var)> {
        self.named_locals(closure).filter(|(_, var)| self.may_hold_filter(&self.graph.var(*var).ty)).collect()
    }

    /// The variables of its surroundings that a closure names.
    pub(super) fn captured_vars(&self, closure: ClosureRef) -> BTreeSet<Var> {
        self.named_locals(closure).map(|(_, var)| var).collect()
    }

    /// The locals of its surroundings that a closure names, with their variables.
    fn named_locals(&self, closure: ClosureRef) -> impl Iterator<Item = (LocalId, Var)> {
        self.mentions(closure).map(|(_, local, var)| (local, var))
    }

    /// Where a closure names which locals of its surroundings, with their variables.
    pub(super) fn mentions(&self, closure: ClosureRef) -> impl Iterator<Item = (ExprId, LocalId, Var)> {
        let frame = &self.frames[closure.frame];
        let span = frame.body.expr(closure.expr).span;
        frame.body.within(closure.expr).rev().filter_map(move |id| {
            let local = frame.typed.expr_local.get(&id)?;
            let is_own = span.contains(frame.typed.local(*local).span);
            let var = frame.vars.get(local).filter(|_| !is_own)?;
            Some((id, *local, *var))
        })
    }
}
