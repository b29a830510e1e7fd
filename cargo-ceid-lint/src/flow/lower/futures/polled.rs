//! Futures of types of the analysed code: `.await` runs their `poll` until that is ready.

use crate::flow::lower::{Builder, Value};
use crate::flow::{About, Cause, CycleKind, Effect, LoopId, LoopInfo, Place, Projection, Rounds};
use crate::index::{FunctionId, Ty};
use crate::source::Span;
use crate::types::{Awaited, awaited, future_behind};

/// How many values are gone through that are each made into another one where they are awaited.
const MAX_MADE: u32 = 4;

impl Builder<'_> {
    /// What a value gives where it is awaited: what it does happens here.
    pub(in crate::flow::lower) fn run_to_end(&mut self, value: Value, span: Span) -> Value {
        if self.is_future(&value) { self.awaited(value, span) } else { self.polled(value, span, 0) }
    }

    /// Whether the type of a value tells what awaiting it runs.
    pub(in crate::flow::lower) fn is_polled(&self, value: &Value) -> bool {
        value.place.is_some() && self.ty_of_future(value).is_some_and(|ty| awaited(self.program.index, &ty).is_some())
    }

    fn polled(&mut self, value: Value, span: Span, depth: u32) -> Value {
        let (Some(place), Some(ty)) = (value.place.clone(), self.ty_of_future(&value)) else { return value };
        let Some((runs, ty)) = awaited(self.program.index, &ty).filter(|_| self.at.is_some()) else { return value };
        let text = crate::flow::lower::patterns::shorten(self.program.sources.snippet(span));
        match runs {
            Awaited::Poll(polls) => self.poll_until_ready(polls, place, &ty, (text, span)),
            Awaited::IntoFuture(function) if depth < MAX_MADE => {
                let made = self.program.index.project(&ty, "IntoFuture");
                let future =
                    self.run_one_on((vec![function], self.types_of(&[function], &ty)), place, made, text, span);
                let future = Value { place: Some(Place::var(future)), is_owned: true, ..Value::default() };
                self.polled(future, span, depth + 1)
            }
            Awaited::Unseen | Awaited::IntoFuture(_) => {
                let cause = Cause::Code(format!("what `{text}` runs"));
                self.emit(Effect::Unknown { places: vec![place], cause }, span);
                Value::default()
            }
        }
    }

    /// A future is polled until it is ready.
    fn poll_until_ready(
        &mut self,
        polls: Vec<FunctionId>,
        place: Place,
        ty: &Ty,
        (text, span): (String, Span),
    ) -> Value {
        let output = self.program.index.project(ty, "Output");
        let run = (polls.clone(), self.types_of(&polls, ty));
        let result = if polls.iter().any(|poll| self.updates_while_pending(*poll, 0)) {
            let cause = Cause::Code(format!("how often `{text}` polls"));
            self.emit(Effect::Unknown { places: vec![place.clone()], cause }, span);
            self.run_one_on(run, place, output.clone(), text, span)
        } else if !polls.iter().any(|poll| self.may_be_pending(*poll)) {
            self.run_one_on(run, place, output.clone(), text, span)
        } else {
            // What is not ready has done nothing yet, unless it remembers how far it came.
            let remembers = polls.iter().any(|poll| self.remembers(*poll, 0));
            let rounds = remembers.then(|| self.begin_polling(&text, span));
            let result = self.run_one_on(run, place, output.clone(), text.clone(), span);
            let answer = Value { same_as: Some(result), ..Value::default() };
            let about = About { is_awaited: true, ..About::default() };
            let (ready, pending) = self.branch_on_head(&answer, "-", "+", span, text, about);
            self.resume(pending);
            match rounds {
                Some(rounds) => {
                    self.jump(self.graph.loop_info(rounds).head);
                    self.loops.pop();
                }
                None => self.diverge(span),
            }
            let after = self.add_node(Effect::Nothing, span);
            self.link(ready, after);
            self.resume(after);
            result
        };
        // Whether it is ready says nothing of what it is ready with.
        let is_owned = !matches!(output, Ty::Ref(..));
        let value = Value { place: Some(Place::var(result)), is_owned, ..Value::default() };
        let given = self.temporary(output, span);
        self.set(given, &value, span);
        Value { place: Some(Place::var(given)), same_as: Some(given), ..value }
    }

    /// The rounds of a future that is polled again.
    fn begin_polling(&mut self, text: &str, span: Span) -> LoopId {
        let rounds = self.plain_loop(CycleKind::Loop, span, Rounds::Bounded, text.to_owned());
        let id = self.add_loop(LoopInfo { is_foreign: true, goes_round: true, ..rounds });
        self.emit(Effect::LoopEnter(id), span);
        self.loops.push(id);
        let head = self.emit(Effect::LoopHead(id), span);
        self.graph.loops[id.0 as usize].head = head;
        id
    }

    fn types_of(&self, targets: &[FunctionId], ty: &Ty) -> Vec<Ty> {
        let is_told = targets.len() > 1 || targets.iter().any(|target| self.program.index.is_generic(*target));
        if is_told { vec![ty.clone()] } else { Vec::new() }
    }

    /// The type of what is awaited, behind pointers.
    fn ty_of_future(&self, value: &Value) -> Option<Ty> {
        let place = value.place.as_ref()?;
        let mut ty = self.graph.var(place.base_var()?).ty.clone();
        for step in place.steps.iter() {
            let Projection::Field(name) = step else { return None };
            ty = match future_behind(&ty) {
                Ty::Tuple(parts) => parts.get(name.parse::<usize>().ok()?)?.clone(),
                owner => self.program.index.field_ty(owner, None, name)?,
            };
        }
        Some(ty)
    }
}
