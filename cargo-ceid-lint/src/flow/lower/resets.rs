//! Resets that are known by their names: whether their bodies write the whole state.

use std::collections::BTreeSet;

use super::written::{clears_all, written_fields, written_fields_of};
use super::{Builder, Value};
use crate::flow::{Effect, Head, Place, Program};
use crate::index::{Def, FunctionId, Owner, Shape, Ty};
use crate::source::Span;
use crate::syntax::tree::{ExprId, ExprKind, PatId, PatKind, StmtKind};
use crate::types::{Callee, Resolved};

impl<'a> Builder<'a> {
    /// Whether a reset known by its name writes the whole state: every field that the law writes, or `*self`. The heads are those of
    /// its arguments.
    pub(super) fn is_full_reset(&self, reset: FunctionId, self_ty: &Ty, heads: &[Option<Head>]) -> bool {
        let index = self.program.index;
        // Behind a trait the type is that of the impl.
        let self_ty = match index.function(reset).owner {
            Owner::Impl(of) if !matches!(self_ty.peel(), Ty::Adt(..)) => &index.impl_def(of).self_ty,
            _ => self_ty,
        };
        clears_all(self.program, reset, self_ty, heads).unwrap_or(true)
    }

    /// The filter that a function resets by what its entry says, and whether it resets all of it.
    pub(super) fn reset_by_function(&self, resolved: &Resolved, values: &[Value]) -> Option<(Place, bool)> {
        let [target] = resolved.targets.as_slice() else { return None };
        let reset = self.program.index.reset_by(&Def::Function(self.program.index.origin(*target)))?;
        Some((values.get(reset.parameter?)?.place.clone()?, reset.is_full))
    }

    /// The same for a function whose code is not read: it resets the first value that it is lent.
    pub(super) fn reset_outside(&mut self, path: &str, args: &[ExprId], span: Span) -> bool {
        let Some(is_full) = self.program.index.reset_by(&Def::External(path.to_owned())).map(|reset| reset.is_full)
        else {
            return false;
        };
        let values = self.values(args);
        let lent = args.iter().position(|arg| matches!(self.ty(*arg), Ty::Ref(true, _)));
        if let Some(place) = values.into_iter().nth(lent.unwrap_or_default()).and_then(|value| value.place) {
            self.emit(Effect::Reset { place, full: is_full }, span);
        }
        true
    }

    /// The fields that the laws of a filter type write; none if that cannot be seen.
    pub(super) fn state_fields(&self, ty: &Ty) -> BTreeSet<String> {
        state_fields(self.program, ty)
    }

    /// Whether what a filter is assigned is made of its own state, so that the assignment is no full reset:
    /// `filter = Filter { gain: 0.5, ..filter }`.
    pub(super) fn keeps_state(&mut self, target: ExprId, value: ExprId) -> bool {
        let ty = self.ty(target).peel().clone();
        if self.program.index.filter_spec(&ty).is_none() {
            return false;
        }
        let Some(old) = self.static_place(target) else { return false };
        let body = self.body();
        match &body.expr(value).kind {
            ExprKind::Path(_) | ExprKind::Field { .. } => self.static_place(value) == Some(old),
            ExprKind::Struct { fields, rest, .. } => {
                let is_rest = rest.is_some_and(|rest| self.static_place(self.cloned(rest)).as_ref() == Some(&old));
                let kept = |this: &mut Self, name: &String| match fields.iter().find(|(field, _)| field == name) {
                    Some((_, value)) => {
                        let from = this.computed_from(*value).places;
                        from.contains(&old.field(name)) || from.contains(&old)
                    }
                    None => is_rest,
                };
                let state = self.state_fields(&ty);
                if state.is_empty() { is_rest } else { state.iter().any(|name| kept(self, name)) }
            }
            _ => self.is_made_of(value, &old, &ty),
        }
    }

    /// Whether a value is a filter that a method or function makes of another one, or of a clone of it. A copy under a name is followed
    /// by itself.
    fn is_made_of(&mut self, value: ExprId, old: &Place, ty: &Ty) -> bool {
        let body = self.body();
        if self.ty(value).peel() != ty {
            return false;
        }
        match &body.expr(value).kind {
            ExprKind::MethodCall { receiver, method, .. } => {
                let is_of = self.static_place(*receiver).as_ref() == Some(old) || self.is_made_of(*receiver, old, ty);
                is_of && (method == "clone" || self.gives_itself_back(value, ty))
            }
            ExprKind::Call { args, .. } => {
                args.iter().any(|arg| self.is_made_of(self.made_as(*arg).unwrap_or(*arg), old, ty))
            }
            _ => false,
        }
    }

    /// What a variable that stays as it is was declared as.
    fn made_as(&self, variable: ExprId) -> Option<ExprId> {
        let typed = self.typed();
        let local = typed.expr_local.get(&variable)?;
        let is_it = |pat: PatId| {
            typed.pat_local.get(&pat) == Some(local)
                && matches!(self.body().pat(pat).kind, PatKind::Bind { mutable: false, .. })
        };
        self.body().stmts().find_map(|stmt| match stmt.kind {
            StmtKind::Let { pat, init, .. } if is_it(pat) => init,
            _ => None,
        })
    }

    /// The new fields of a filter that is assigned with the rest of itself: `filter = Filter { gain: 0.5, ..filter }`.
    pub(super) fn own_rest(&mut self, target: ExprId, value: ExprId) -> Option<&'a [(String, ExprId)]> {
        let body = self.body();
        let ExprKind::Struct { fields, rest: Some(rest), .. } = &body.expr(value).kind else { return None };
        let is_filter = self.program.index.filter_spec(self.ty(target).peel()).is_some();
        let own = self.static_place(target).filter(|_| is_filter)?;
        (self.static_place(self.cloned(*rest)) == Some(own)).then_some(fields.as_slice())
    }

    /// What an expression clones, or itself.
    fn cloned(&self, id: ExprId) -> ExprId {
        match &self.body().expr(id).kind {
            ExprKind::MethodCall { receiver, method, args, .. } if method == "clone" && args.is_empty() => *receiver,
            _ => id,
        }
    }

    /// Whether a method gives a filter with some of the state of its own: `fn with_gain(self, gain: f32) -> Self`, `clone`.
    fn gives_itself_back(&self, call: ExprId, ty: &Ty) -> bool {
        let targets = match self.typed().callees.get(&call) {
            Some(Callee::Resolved(resolved)) if !resolved.targets.is_empty() => &resolved.targets,
            _ => return true,
        };
        let state = self.state_fields(ty);
        targets.iter().any(|target| {
            let function = &self.program.index.function(*target).function;
            let (Some(body), Some(typed)) = (&function.body, self.program.typed(*target)) else { return true };
            let is_self = |expr: ExprId| {
                typed.expr_local.get(&expr).is_some_and(|local| typed.locals[local.0 as usize].name == "self")
            };
            let tail = match &body.expr(body.root).kind {
                ExprKind::Block(block) => block.tail,
                _ => Some(body.root),
            };
            // What it writes first may be all of it.
            if tail.is_some_and(is_self) {
                return !written_fields(self.program, *target).is_none_or(|written| state.is_subset(&written));
            }
            let is_given = |name: &str| {
                let is_it = |(own, _): &(String, ExprId)| own == name;
                tail.is_some_and(
                    |tail| matches!(&body.expr(tail).kind, ExprKind::Struct { fields, .. } if fields.iter().any(is_it)),
                )
            };
            let reads = |expr: ExprId| match &body.expr(expr).kind {
                ExprKind::Field { base, name } => is_self(*base) && (state.is_empty() || state.contains(name)),
                ExprKind::MethodCall { receiver, method, .. } => method == "clone" && is_self(*receiver),
                ExprKind::Struct { rest: Some(rest), .. } => {
                    is_self(*rest) && (state.is_empty() || !state.iter().all(|name| is_given(name)))
                }
                ExprKind::Deref(inner) => is_self(*inner),
                _ => false,
            };
            (0u32..).map(ExprId).take(body.exprs.len()).any(reads)
        })
    }
}

/// The fields that the laws of a filter type write; none if that cannot be seen.
pub(super) fn state_fields(program: &Program<'_>, ty: &Ty) -> BTreeSet<String> {
    let index = program.index;
    let Some(spec) = index.receiver_spec(ty) else { return fields_of_state(program, ty) };
    let methods = spec.law.iter().flat_map(|group| &group.methods).flat_map(|name| index.methods(ty, name));
    let laws = methods.filter_map(|owner| owner.function());
    let mut state = BTreeSet::new();
    for law in laws {
        match written_fields(program, law) {
            Some(fields) => state.extend(fields),
            None => return BTreeSet::new(),
        }
    }
    state
}

/// The fields that laws write of a state that they have as an argument; all that it has, if one of them is not read.
fn fields_of_state(program: &Program<'_>, ty: &Ty) -> BTreeSet<String> {
    let index = program.index;
    let Ty::Adt(id, _) = ty else { return BTreeSet::new() };
    let Shape::Struct(shape) = &index.type_def(*id).shape else { return BTreeSet::new() };
    let mut state = BTreeSet::new();
    for law in index.bodies_of_state(ty) {
        let written = index.state_parameter(law).and_then(|number| written_fields_of(program, law, number));
        match written.filter(|written| !written.is_empty()) {
            Some(written) => state.extend(written),
            None => return shape.fields.iter().map(|field| field.name.clone()).collect(),
        }
    }
    state
}
