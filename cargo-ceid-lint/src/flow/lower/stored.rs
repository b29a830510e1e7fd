//! Closures that the code puts somewhere and calls from there: what they may update, each such call may update.

use super::{Builder, Value};
use crate::flow::{Caller, Cause, Effect, LoopId, NodeId, Place, Var};
use crate::index::{FunctionId, Ty};
use crate::syntax::tree::{ExprId, ExprKind};

/// The closures that are put somewhere, and the calls that may run them from there.
#[derive(Default)]
pub(super) struct Stored {
    pub(super) closures: Vec<StoredClosure>,
    calls: Vec<StoredCall>,
}

/// A closure that is put somewhere.
pub(super) struct StoredClosure {
    /// The loop that stands for its calls.
    pub(super) id: LoopId,
    /// What it captures.
    pub(super) places: Vec<Place>,
    pub(super) holder: Holder,
}

/// Who has a closure.
#[derive(Clone, Copy)]
pub(super) enum Holder {
    /// The code, in this variable if that is known.
    Code(Option<Var>),
    /// Something unseen, which may hand it back in a value of its own.
    Unseen,
}

/// A call that may run a closure that is put somewhere.
struct StoredCall {
    node: NodeId,
    /// The variable by which it is reached.
    by: Option<Var>,
    /// Whether what is called is itself such a value, and does not only hold one.
    is_callee: bool,
}

impl Builder<'_> {
    /// A call of a value of which it is not known what stands behind it.
    pub(super) fn calls_kept(&mut self, callee: ExprId, value: &Value) {
        // What captures something is no function pointer.
        if !matches!(self.ty(callee).peel(), Ty::Function(..)) {
            let by = value.place.as_ref().and_then(Place::base_var);
            self.note_stored_call(by, true, self.span(callee));
        }
    }

    /// A call that lends what may hold a closure. What it is given for good is no affair of the code here any more, unless the
    /// next round gives it again.
    pub(super) fn lends_kept(&mut self, id: ExprId, targets: &[FunctionId], exprs: &[ExprId], values: &[Value]) {
        if !self.frames.iter().any(|frame| frame.has_closures) {
            return;
        }
        let receiver = match &self.body().expr(id).kind {
            ExprKind::MethodCall { receiver, .. } => Some(*receiver),
            _ => None,
        };
        for (expr, value) in exprs.iter().zip(values) {
            if let Some(by) = value.place.as_ref().and_then(Place::base_var)
                && !(self.loops.is_empty() && self.is_passed_by_value(*expr, value, receiver, targets))
                && self.program.index.leads_to_callable(self.ty(*expr))
            {
                self.note_stored_call(Some(by), false, self.span(id));
            }
        }
    }

    /// A function that makes something which can be called may put there the handles that it is given: `stepper(Arc::clone(&f))`.
    pub(super) fn keep_handles(&mut self, id: ExprId, exprs: &[ExprId], values: &[Value]) {
        if !self.ty(id).is_callable() {
            return;
        }
        for (expr, value) in exprs.iter().zip(values).filter(|(_, value)| !value.is_owned) {
            if let Some(place) = value.place.clone().filter(|_| self.is_shared_handle(*expr)) {
                self.graph.kept.push((place, Cause::Code("a closure that is kept for later".to_owned())));
            }
        }
    }

    fn note_stored_call(&mut self, by: Option<Var>, is_callee: bool, span: crate::source::Span) {
        if self.at.is_some() {
            let node = self.emit(Effect::Nothing, span);
            self.stored.calls.push(StoredCall { node, by, is_callee });
        }
    }

    /// Tells each call what the closures that it may run capture.
    pub(super) fn settle_stored(&mut self) {
        let Stored { closures, calls } = std::mem::take(&mut self.stored);
        for call in calls {
            let is_param = call.by.is_some_and(|by| self.graph.var(by).param.is_some());
            let within = self.graph.node(call.node).in_loop;
            let mut places = Vec::new();
            for closure in &closures {
                let may_be = match closure.holder {
                    Holder::Code(holder) => !is_param || (holder.is_some() && holder == call.by),
                    Holder::Unseen => call.is_callee && !is_param,
                };
                if may_be && !self.graph.is_within(within, closure.id) {
                    places.extend(closure.places.iter().cloned());
                    let info = &mut self.graph.loops[closure.id.0 as usize];
                    info.caller = Caller::Keeper;
                    info.handed.push(call.node);
                }
            }
            if !places.is_empty() {
                let cause = Cause::Code("a closure that is kept for later".to_owned());
                self.graph.nodes[call.node.0 as usize].effect = Effect::Unknown { places, cause };
            }
        }
    }
}
