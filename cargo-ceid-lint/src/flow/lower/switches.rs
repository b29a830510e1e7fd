//! Small functions that are read where they are called: those that ask for a state, and those that switch it.

use rustc_hash::FxHashSet;

use super::reading::is_pure_function;
use super::told::has_one_answer;
use super::{Builder, Frame, MAX_INLINE, Value};
use crate::flow::{Head, NodeId, Place};
use crate::index::{FunctionId, Owner, Shape, Ty};
use crate::syntax::tree::{Body, ExprId, ExprKind, PatId};
use crate::types::{Callee, Resolved, TypedBody};

/// How many expressions a function may have to be read where it is called.
const MAX_EXPRESSIONS: usize = 96;

/// The same for one that answers whether it is time: what it does besides, such as taking a statistic, may be long.
const MAX_ANSWERING: usize = 256;

/// How many functions deep a switch may lie in the one that is read where it is called.
const MAX_DEPTH: u32 = 2;

impl Builder<'_> {
    /// `if self.is_armed()`: a condition that is a function's only expression asks what that asks. Answers whether it is one.
    pub(super) fn spoken_condition(&mut self, id: ExprId, receiver: ExprId, args: &[ExprId], no: NodeId) -> bool {
        let Some(target) = self.only_target(id) else { return false };
        let def = self.program.index.function(target);
        let (Some(body), Some(typed)) = (&def.function.body, self.program.typed(target)) else { return false };
        if *typed.ty(body.root) != Ty::Bool
            || self.depth >= MAX_INLINE
            || self.inlining.contains(&target)
            || !(is_pure_function(self.program, target, 0) || self.takes_flag(body, typed) || self.asks_clock(target))
            || self.stands_in(id)
            || self.static_place(receiver).is_none()
            || args.iter().any(|arg| self.is_constant(*arg) && self.mask_within(*arg).is_none())
        {
            return false;
        }
        let mut exprs = vec![receiver];
        exprs.extend_from_slice(args);
        let values = self.values(&exprs);
        if self.at.is_none() {
            return true;
        }
        let outer_spoken = self.spoken.clone();
        if self.spoken.is_none() {
            self.spoken = Some((self.span(id), self.text(id)));
        }
        let places: Vec<Option<Place>> = exprs.iter().map(|expr| self.static_place(*expr)).collect();
        let (span, text, about) = (self.span(id), self.text(id), self.about(id));
        self.read_in_place(target, &exprs, &places, &values, |this, body| {
            if !super::optional::leaves(body, body.root) {
                return this.condition(body.root, no);
            }
            // What returns early gives its answer, and does not leave the code that asks.
            let answer = this.inline_body(Ty::Bool, span, true, |this| this.expr(body.root));
            if this.at.is_some() {
                let (yes, failed) = this.branch_on_head(&answer, "true", "false", span, text, about);
                this.link(failed, no);
                this.resume(yes);
            }
        });
        self.spoken = outer_spoken;
        true
    }

    /// A call of a small function that switches a state, or tells one: it is read here, so that what it sets and asks is seen.
    pub(super) fn switch_call(
        &mut self,
        resolved: &Resolved,
        exprs: &[ExprId],
        values: &[Value],
        id: ExprId,
    ) -> Option<Value> {
        let [target] = resolved.targets.as_slice() else { return None };
        if self.depth >= MAX_INLINE || !(self.switches_state(resolved, false, 0) || self.tells_state(*target, exprs)) {
            return None;
        }
        let typed = self.program.typed(*target)?;
        let def = &self.program.index.function(*target).function;
        let (body, is_const) = (def.body.as_ref()?, def.is_const);
        let is_reference =
            |pat: &PatId| typed.pat_local.get(pat).is_some_and(|local| matches!(typed.local(*local).ty, Ty::Ref(..)));
        let places: Vec<Option<Place>> = body
            .params
            .iter()
            .zip(exprs)
            .zip(values)
            .map(|((pat, expr), value)| self.static_place(*expr).or(value.place.clone()).filter(|_| is_reference(pat)))
            .collect();
        let (ty, span) = (typed.ty(body.root).clone(), self.span(id));
        let mut result = Value::default();
        self.read_in_place(*target, exprs, &places, values, |this, body| {
            result = this.inline_body(ty.clone(), span, true, |this| this.expr(body.root));
        });
        if !is_const && has_one_answer(body) {
            let var = self.temporary(ty, span);
            result = Value { place: Some(Place::var(var)), is_owned: true, same_as: Some(var), ..Value::default() };
        }
        Some(result)
    }

    /// Reads the body of a function where it is called; parameters stand for these places, or are bound to the values.
    fn read_in_place(
        &mut self,
        target: FunctionId,
        exprs: &[ExprId],
        places: &[Option<Place>],
        values: &[Value],
        read: impl FnOnce(&mut Self, &Body),
    ) {
        let def = self.program.index.function(target);
        let (Some(body), Some(typed)) = (&def.function.body, self.program.typed(target)) else { return };
        let masks: Vec<Option<u32>> = exprs.iter().map(|expr| self.mask_within(*expr)).collect();
        let known: Vec<Option<Head>> = exprs.iter().map(|expr| self.written_state(*expr)).collect();
        self.frames.push(Frame::new(target, body, typed));
        let outer = std::mem::replace(&mut self.frame, self.frames.len() - 1);
        self.depth += 1;
        self.graph.read_here.insert(target);
        self.inlining.push(target);
        for (number, pat) in body.params.iter().enumerate() {
            if let (Some(Some(mask)), Some(local)) = (masks.get(number), typed.pat_local.get(pat)) {
                let frame = &mut self.frames[self.frame];
                frame.masks.extend((!frame.mutated.contains(local)).then_some((*local, *mask)));
            }
            match (places.get(number).cloned().flatten(), typed.pat_local.get(pat)) {
                (Some(place), Some(local)) => {
                    self.frames[self.frame].stand_ins.insert(*local, place);
                }
                _ => self.bind_pattern(*pat, &values.get(number).cloned().unwrap_or_default()),
            }
            if let (Some(head), Some(local)) = (known.get(number).cloned().flatten(), typed.pat_local.get(pat))
                && !self.frames[self.frame].mutated.contains(local)
            {
                let var = self.var_of(*local);
                self.known.insert(var, head);
            }
        }
        read(self, body);
        self.inlining.pop();
        self.depth -= 1;
        self.frame = outer;
    }

    /// The place of the caller that a local stands for.
    pub(super) fn stand_in(&self, id: ExprId) -> Option<Place> {
        let local = self.typed().expr_local.get(&id)?;
        self.frames[self.frame].stand_ins.get(local).cloned()
    }

    /// Whether an argument is a constant, so that the call asks about its receiver alone.
    fn is_constant(&mut self, arg: ExprId) -> bool {
        self.static_place(arg).is_none() && self.pure(arg).is_some_and(|pure| pure.reads.is_empty())
    }

    /// Whether a function compares times and does nothing else: `fn due(&self) -> bool { self.last.elapsed() >= PERIOD }`.
    fn asks_clock(&self, id: FunctionId) -> bool {
        let def = self.program.index.function(id);
        let (Some(body), Some(typed)) = (&def.function.body, self.program.typed(id)) else { return false };
        let mut at = body.root;
        while let ExprKind::Block(block) = &body.expr(at).kind {
            match block.tail {
                Some(tail) if block.stmts.is_empty() => at = tail,
                _ => return false,
            }
        }
        let compares = matches!(&body.expr(at).kind, ExprKind::Binary { op: "<" | "<=" | ">" | ">=", .. });
        let is_shared = def.function.receiver == Some(crate::syntax::tree::Receiver::Shared);
        compares
            && is_shared
            && body.exprs.iter().enumerate().all(|(number, expr)| match &expr.kind {
                ExprKind::Path(_)
                | ExprKind::Literal(_)
                | ExprKind::Field { .. }
                | ExprKind::Binary { .. }
                | ExprKind::Block(_)
                | ExprKind::Deref(_)
                | ExprKind::Cast { .. }
                | ExprKind::Reference { mutable: false, .. } => true,
                ExprKind::MethodCall { .. } | ExprKind::Call { .. } => {
                    let id = ExprId(u32::try_from(number).unwrap_or(u32::MAX));
                    !matches!(typed.callees.get(&id), Some(Callee::Resolved(_)))
                }
                _ => false,
            })
    }

    /// Whether a function does nothing but take a flag down: `DUE.swap(false, Ordering::AcqRel)`.
    fn takes_flag(&self, body: &Body, typed: &TypedBody) -> bool {
        let mut id = body.root;
        while let ExprKind::Block(block) = &body.expr(id).kind {
            match block.tail {
                Some(tail) if block.stmts.is_empty() => id = tail,
                _ => return false,
            }
        }
        matches!(&body.expr(id).kind, ExprKind::MethodCall { receiver, method, .. }
            if super::flags::is_flag(typed.ty(*receiver)) && super::flags::changes_flag(method))
    }

    /// Whether a call asks a function that answers without a look at anything: it stands in for something that is not written yet.
    pub(super) fn stands_in(&self, id: ExprId) -> bool {
        let Some(target) = self.only_target(id) else { return false };
        let def = &self.program.index.function(target).function;
        let reads_nothing = || self.program.typed(target).is_some_and(|typed| typed.expr_local.is_empty());
        !def.is_const && def.body.as_ref().is_some_and(has_one_answer) && reads_nothing()
    }

    pub(super) fn only_target(&self, id: ExprId) -> Option<FunctionId> {
        match self.typed().callees.get(&id) {
            Some(Callee::Resolved(resolved)) if resolved.law.is_none() => match resolved.targets.as_slice() {
                [target] => Some(*target),
                _ => None,
            },
            _ => None,
        }
    }

    /// The types of the arguments of a call, where they decide what runs.
    pub(super) fn deciding_types(&self, id: ExprId, targets: &[FunctionId], exprs: &[ExprId]) -> Vec<Ty> {
        if targets.len() < 2 && !targets.iter().any(|target| self.program.index.is_generic(*target)) {
            return Vec::new();
        }
        let mut types: Vec<Ty> = exprs.iter().map(|expr| self.ty(*expr).clone()).collect();
        if let (Some(Callee::Resolved(resolved)), Some(first)) = (self.typed().callees.get(&id), types.first_mut())
            && resolved.has_receiver
        {
            *first = resolved.self_ty.clone();
        }
        types
    }

    /// Whether a function is a small one that switches a state, itself or by another one, and runs no law: what it sets must be seen
    /// by its callers. One that `answers` is called by a function that gives a truth value.
    fn switches_state(&self, resolved: &Resolved, answers: bool, depth: u32) -> bool {
        let [target] = resolved.targets.as_slice() else { return false };
        let index = self.program.index;
        let def = index.function(*target);
        let (Some(body), Some(typed)) = (&def.function.body, self.program.typed(*target)) else { return false };
        // What is called by its bounds may be the law of a type that has it by a trait which makes no filters.
        if let Owner::Impl(of) = def.owner
            && index.law_run_by(&index.impl_def(of).self_ty, *target).is_some()
        {
            return false;
        }
        // A divider or timer of the code's own answers whether it is time.
        let is_truth = *typed.ty(body.root).peel() == Ty::Bool;
        let answers = (answers || is_truth || self.is_answer(typed.ty(body.root))) && !has_one_answer(body);
        if body.exprs.len() > if is_truth { MAX_ANSWERING } else { MAX_EXPRESSIONS } || self.inlining.contains(target) {
            return false;
        }
        let is_choice = |ty: &Ty| matches!(ty, Ty::Adt(..)) && self.is_state(ty);
        // What a function does for a state that it is given, its callers know by that state.
        let mut params = body.params.iter().filter_map(|pat| typed.pat_local.get(pat));
        let gives = typed.ty(body.root);
        let is_told = is_choice(gives) || *gives == Ty::Tuple(Vec::new());
        let mut switches = is_told && params.any(|local| is_choice(&typed.local(*local).ty));
        let (mut closures, mut run_here) = (Vec::new(), FxHashSet::<ExprId>::default());
        for (number, expr) in body.exprs.iter().enumerate() {
            let id = ExprId(u32::try_from(number).unwrap_or(u32::MAX));
            match &expr.kind {
                ExprKind::Assign { place, .. } => {
                    switches |= (answers || self.is_state(typed.ty(*place))) && !is_local(body, *place);
                }
                ExprKind::AssignOp { op, place, .. } => {
                    let is_of_bits = matches!(*op, "|" | "&") && *typed.ty(*place).peel() == Ty::Int;
                    let sets_flag = is_of_bits && !self.may_hold_filter(&resolved.self_ty);
                    switches |= (answers || sets_flag) && !is_local(body, *place);
                }
                ExprKind::MethodCall { receiver, method, args, .. } => {
                    switches |= super::flags::is_flag(typed.ty(*receiver)) && super::flags::changes_flag(method);
                    // What is taken is gone for whoever looks next.
                    switches |= method == "take" && args.is_empty() && self.is_plain_option(typed.ty(*receiver));
                    let is_for_each = method == "for_each" && self.program.index.holds_filter(typed.ty(*receiver));
                    // `self.is_due().then(|| self.last)`
                    let is_answer = method == "then" && *typed.ty(*receiver).peel() == Ty::Bool;
                    run_here.extend(args.iter().filter(|_| is_for_each || is_answer));
                }
                // What it does to each filter of a collection: `for pid in &mut self.pids { pid.reset(); }`.
                ExprKind::For { iterable, .. } if self.program.index.holds_filter(typed.ty(*iterable)) => {}
                ExprKind::Closure(_) => closures.push(id),
                ExprKind::Loop { .. }
                | ExprKind::While { .. }
                | ExprKind::For { .. }
                | ExprKind::Try(_)
                | ExprKind::Await(_)
                | ExprKind::Opaque(_)
                | ExprKind::Unknown { .. } => return false,
                _ => {}
            }
            if let Some(Callee::Resolved(inner)) = typed.callees.get(&id) {
                if inner.targets.len() > 1 || inner.targets.contains(target) || self.may_run_law(inner, 0) {
                    return false;
                }
                switches = switches || depth < MAX_DEPTH && self.switches_state(inner, answers, depth + 1);
            }
        }
        switches && closures.iter().all(|id| run_here.contains(id))
    }

    /// Whether a function does nothing but tell a state from what its receiver holds: read where it is called, it tells the same
    /// as long as that is the same. Of several states that it tells at once, each is known by the others.
    fn tells_state(&mut self, id: FunctionId, exprs: &[ExprId]) -> bool {
        let def = self.program.index.function(id);
        let (Some(body), Some(typed)) = (&def.function.body, self.program.typed(id)) else { return false };
        let ty = typed.ty(body.root);
        let [receiver, args @ ..] = exprs else { return false };
        let is_asked_again =
            |this: &mut Self| this.static_place(*receiver).is_some() && !args.iter().any(|arg| this.is_constant(*arg));
        let has_several = self.has_states(ty);
        body.exprs.len() <= MAX_EXPRESSIONS
            && !matches!(ty, Ty::Ref(..))
            && (has_several || self.is_state(ty))
            && !self.inlining.contains(&id)
            && is_pure_function(self.program, id, 0)
            && (has_several || is_asked_again(self))
    }

    /// Whether a value of the type has several states in it.
    fn has_states(&self, ty: &Ty) -> bool {
        let states = match ty {
            Ty::Tuple(parts) => parts.iter().filter(|part| self.is_state(part)).count(),
            Ty::Adt(id, _) => match &self.program.index.type_def(*id).shape {
                Shape::Struct(fields) => {
                    let index = self.program.index;
                    let field_ty = |name: &String| index.field_ty(ty, None, name);
                    let tys = fields.fields.iter().filter_map(|field| field_ty(&field.name));
                    tys.filter(|ty| self.is_state(ty)).count()
                }
                Shape::Enum(_) => 0,
            },
            _ => 0,
        };
        states > 1
    }

    /// Whether a call may run a law, as far as it is followed.
    pub(super) fn may_run_law(&self, call: &Resolved, depth: u32) -> bool {
        if call.law.is_some() || depth > 4 {
            return true;
        }
        call.targets.iter().any(|target| {
            let def = self.program.index.function(*target);
            let (Some(body), Some(typed)) = (&def.function.body, self.program.typed(*target)) else { return false };
            body.exprs.len() > MAX_ANSWERING
                || (0u32..).map(ExprId).take(body.exprs.len()).any(|id| {
                    matches!(typed.callees.get(&id), Some(Callee::Resolved(inner)) if self.may_run_law(inner, depth + 1))
                })
        })
    }

    /// Whether a value of the type says no more than whether it is time, and when: `Option<()>`, `Result<f32, NotYet>`. What is made of
    /// several parts is a sample.
    fn is_answer(&self, ty: &Ty) -> bool {
        let given = match ty {
            Ty::External(_, given) => given,
            Ty::Adt(id, _) => match &self.program.index.type_def(*id).shape {
                Shape::Enum(variants) => return variants.iter().all(|variant| variant.fields.fields.is_empty()),
                Shape::Struct(_) => return false,
            },
            _ => return false,
        };
        let is_moment = |given: &Ty| match given {
            Ty::Int | Ty::Float | Ty::Bool => true,
            Ty::Tuple(parts) => parts.is_empty(),
            Ty::External(path, _) => matches!(path.rsplit("::").next(), Some("Instant" | "Duration")),
            _ => false,
        };
        self.is_plain_option(ty) && given.first().is_some_and(is_moment)
    }

    /// Whether a value of the type is there or not, and holds no filter.
    pub(super) fn is_plain_option(&self, ty: &Ty) -> bool {
        matches!(ty.peel().external_name(), Some("Option" | "Result")) && !self.may_hold_filter(ty)
    }

    /// Whether a value of the type is one of a few states: a truth value, or a variant.
    pub(super) fn is_state(&self, ty: &Ty) -> bool {
        match ty.peel() {
            Ty::Bool => true,
            Ty::Adt(id, _) => matches!(self.program.index.type_def(*id).shape, Shape::Enum(_)),
            _ => false,
        }
    }
}

/// Whether an assignment's target is a variable of the function itself.
fn is_local(body: &Body, place: ExprId) -> bool {
    matches!(body.expr(place).kind, ExprKind::Path(_))
}
