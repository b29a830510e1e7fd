//! Functions that are passed by name: what runs where they are called.

use super::{Builder, ClosureRef, Value};
use crate::config::{InstancePlace, OnErr};
use crate::flow::{Argument, CallSite, Computed, Effect, Place, RunBy, Update, Var};
use crate::index::{FunctionId, Ty};
use crate::source::Span;
use crate::syntax::tree::{ExprKind, Receiver};

impl Builder<'_> {
    /// Whether what is called is a function by its name, and no closure.
    pub(super) fn is_item(&self, closure: ClosureRef) -> bool {
        matches!(self.frames[closure.frame].body.expr(closure.expr).kind, ExprKind::Path(_))
    }

    /// Runs a function that was passed by name.
    pub(super) fn call_item(&mut self, item: ClosureRef, args: &[Value], span: Span) -> Value {
        let frame = &self.frames[item.frame];
        let (ExprKind::Path(path), Some(resolved)) =
            (&frame.body.expr(item.expr).kind, frame.typed.items.get(&item.expr))
        else {
            return Value::default();
        };
        let name = path.last();
        let law = self.law_of(resolved);
        let skip = usize::from(resolved.has_receiver);
        let at = law.and_then(|(spec, _)| match spec.instance {
            InstancePlace::Receiver => resolved.has_receiver.then_some(0),
            InstancePlace::Argument(number) => Some(number as usize + skip),
            InstancePlace::Returned => None,
        });
        let place_at = |at: usize| args.get(at).and_then(|value| value.place.clone());
        if law.is_none()
            && let Some(place) = place_at(0).filter(|_| resolved.has_receiver)
            && let Some(full) = self.resets(name, resolved, &[])
        {
            self.emit(Effect::Reset { place, full }, span);
            return Value::default();
        }
        if let Some((place, full)) = self.reset_by_function(resolved, args).filter(|_| law.is_none()) {
            self.emit(Effect::Reset { place, full }, span);
            return Value::default();
        }
        let reads_self =
            |target: &FunctionId| self.program.index.function(*target).function.receiver == Some(Receiver::Shared);
        let is_shared = resolved.has_receiver && resolved.targets.iter().all(reads_self);
        let given = args.iter().enumerate().map(|(number, value)| Argument {
            place: value.place.clone(),
            is_shared: is_shared && number == 0,
            ..Argument::default()
        });
        let fed: Vec<Var> = (0..args.len())
            .filter(|number| Some(*number) != at)
            .filter_map(place_at)
            .filter_map(|place| place.base_var())
            .collect();
        let is_followed = law.is_none() || resolved.targets.len() <= super::laws::MAX_DISPATCHED;
        let site = CallSite {
            targets: if is_followed { resolved.targets.clone() } else { Vec::new() },
            args: given.collect(),
            result: Var(0),
            hands: None,
            types: Vec::new(),
            text: path.text(),
            law_of: at,
            is_dispatched: false,
            fed: fed.clone(),
            into: self.targets.clone(),
            from: Computed::default(),
        };
        let result = self.temporary(Ty::Unknown, span);
        self.emit(Effect::Call(Box::new(CallSite { result, ..site })), span);
        if let (Some((spec, group)), Some(place)) = (law, at.and_then(place_at)) {
            let update = Update {
                place,
                law: group,
                method: name.to_owned(),
                run_by: RunBy::Code,
                is_typed: spec.instance == InstancePlace::Receiver,
                given: None,
                attempt: (spec.on_err == OnErr::Untouched).then_some(result),
                fed,
                into: self.targets.clone(),
                from: Computed::default(),
            };
            self.emit(Effect::Update(update), span);
        }
        Value { place: Some(Place::var(result)), is_owned: true, same_as: Some(result), ..Value::default() }
    }
}
