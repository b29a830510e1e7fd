//! A value that a function is given and gives back takes the place that it came from: `state = step(state, &mut filter)` does to the state
//! what `step(&mut state, &mut filter)` does.

use super::Builder;
use super::subjects::pure_place;
use crate::flow::Argument;
use crate::index::{Shape, Ty};
use crate::syntax::tree::{ExprId, ExprKind};
use crate::types::Callee;

/// The call whose result takes the place of one of its arguments: the frame that it is in, and the argument.
#[derive(Clone, Copy)]
pub(super) struct HandedBack {
    frame: usize,
    call: ExprId,
    argument: usize,
}

impl Builder<'_> {
    /// The argument of a call that comes back from it, where that is assigned to the place which it was given from.
    pub(super) fn handed_back(&mut self, target: ExprId, call: ExprId) -> Option<HandedBack> {
        let function = self.only_target(call)?;
        let given: Vec<ExprId> = match &self.body().expr(call).kind {
            ExprKind::Call { args, .. } => args.clone(),
            ExprKind::MethodCall { receiver, args, .. } => [vec![*receiver], args.clone()].concat(),
            _ => return None,
        };
        let ty = self.ty(target).clone();
        if !matches!(ty, Ty::Adt(..)) || self.may_hold_filter(&ty) {
            return None;
        }
        let place = self.static_place(target)?;
        let argument =
            given.iter().position(|arg| *self.ty(*arg) == ty && self.static_place(*arg).as_ref() == Some(&place))?;
        let (body, typed) =
            (self.program.index.function(function).function.body.as_ref()?, self.program.typed(function)?);
        let own = typed.pat_local.get(body.params.get(argument)?)?;
        let is_it = |value: ExprId| typed.expr_local.get(&value) == Some(own);
        let mut end = body.root;
        while let ExprKind::Block(block) = &body.expr(end).kind {
            end = block.tail?;
        }
        // What is put in its place as a whole is not the same state. What is called with it is followed there.
        let is_called = |id: usize| {
            let id = u32::try_from(id).map(ExprId);
            id.is_ok_and(|id| matches!(typed.callees.get(&id), Some(Callee::Resolved(_))))
        };
        let lent = |arg: &ExprId| match &body.expr(*arg).kind {
            ExprKind::Reference { value, raw: false, .. } => Some(*value),
            _ => None,
        };
        let mut followed = vec![end];
        for (id, expr) in body.exprs.iter().enumerate() {
            match &expr.kind {
                ExprKind::Return(Some(value)) if is_it(*value) => followed.push(*value),
                ExprKind::Return(_) | ExprKind::Try(_) => return None,
                ExprKind::Field { base, .. } => followed.push(*base),
                ExprKind::MethodCall { receiver, args, .. } if is_called(id) => {
                    followed.push(*receiver);
                    followed.extend(args.iter().filter_map(lent));
                }
                ExprKind::Call { args, .. } if is_called(id) => followed.extend(args.iter().filter_map(lent)),
                _ => {}
            }
        }
        let mut named = (0u32..).map(ExprId).take(body.exprs.len()).filter(|id| is_it(*id));
        let is_same = is_it(end) && named.all(|id| followed.contains(&id));
        is_same.then_some(HandedBack { frame: self.frame, call, argument })
    }

    /// Notes which argument of a call its result takes the place of; what is called may ask for the states in it.
    pub(super) fn note_handed_back(&mut self, call: ExprId, args: &mut [Argument]) {
        let is_it = |own: &mut HandedBack| (own.frame, own.call) == (self.frame, call);
        let Some(HandedBack { argument, .. }) = self.handed_back.take_if(is_it) else { return };
        args[argument].is_back = true;
        args[argument].is_moved = false;
        let (Some(place), ty) = (args[argument].place.clone(), self.ty(call).clone()) else { return };
        let Ty::Adt(id, _) = &ty else { return };
        let Shape::Struct(shape) = &self.program.index.type_def(*id).shape else { return };
        for field in &shape.fields {
            let Some(of_field) = self.program.index.field_ty(&ty, None, &field.name) else { continue };
            if self.is_state(&of_field) {
                let total = self.total_heads(&of_field);
                let subject = self.subject(pure_place(place.field(&field.name)), total.clone());
                for head in total.iter().flatten() {
                    self.head_bit(subject, head);
                }
            }
        }
    }
}
