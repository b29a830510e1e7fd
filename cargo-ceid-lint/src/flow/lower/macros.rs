//! Macros that are read as code: which operands run, and how often.

use super::{Builder, Value};
use crate::flow::{Cause, CycleKind, Effect, Place, Rounds};
use crate::syntax::tree::{ExprId, MacroExpr, MacroKind, PatId, SelectArm};

impl Builder<'_> {
    pub(super) fn macro_expr(&mut self, id: ExprId, macro_expr: &MacroExpr) -> Value {
        let span = self.span(id);
        match &macro_expr.kind {
            MacroKind::All(operands) => {
                let mut last = Value::default();
                for (number, operand) in operands.iter().enumerate() {
                    last = self.expr(*operand);
                    if number == 0 && writes_into(&macro_expr.path) {
                        self.note_lent(*operand);
                        self.written_into(id, *operand, &last);
                    }
                }
                match macro_expr.path.rsplit("::").next().unwrap_or("") {
                    "dbg" | "block" | "pin" | "unwrap" | "expect" => last,
                    _ => Value::default(),
                }
            }
            MacroKind::Diverges(operands) => {
                for operand in operands {
                    self.expr(*operand);
                }
                if self.at.is_some() {
                    self.diverge(span);
                }
                Value::default()
            }
            // What the messages of assertions do is done where nothing follows.
            MacroKind::Assert(condition, _) => {
                let failed = self.add_node(Effect::Nothing, span);
                self.condition(*condition, failed);
                let holds = self.at;
                self.resume_if_reached(failed);
                if self.at.is_some() {
                    self.diverge(span);
                }
                self.at = holds;
                Value::default()
            }
            MacroKind::AssertCompare(left, right, _) => {
                self.expr(*left);
                self.expr(*right);
                Value::default()
            }
            MacroKind::DebugOnly(operands, _) | MacroKind::Logging(operands) => {
                self.debug_only(id, operands, &macro_expr.path);
                Value::default()
            }
            // What is shipped does not hold it.
            MacroKind::DebugBuild => Value { head: Some("false".to_owned()), ..Value::default() },
            MacroKind::Build(_) => {
                Value { head: macro_expr.kind.built().map(|answer| answer.to_string()), ..Value::default() }
            }
            MacroKind::ReturnsErr(operands) => {
                for operand in operands {
                    self.expr(*operand);
                }
                if self.at.is_some() {
                    self.emit(Effect::Nothing, span);
                    self.return_value(Value { head: Some("-".to_owned()), ..Value::default() }, span, true);
                }
                Value::default()
            }
            MacroKind::Ensure(condition, message) => {
                let failed = self.add_node(Effect::Nothing, span);
                self.condition(*condition, failed);
                let holds = self.at;
                self.resume_if_reached(failed);
                if self.at.is_some() {
                    for operand in message {
                        self.expr(*operand);
                    }
                }
                if self.at.is_some() {
                    self.return_value(Value { head: Some("-".to_owned()), ..Value::default() }, span, true);
                }
                self.at = holds;
                Value::default()
            }
            MacroKind::Join { operands, .. } => self.joined(id, operands),
            MacroKind::Select(arms) => self.select(id, arms),
            MacroKind::Ceid { token, filters, names } => {
                if let Some(token) = token {
                    self.expr(*token);
                }
                let mut places = Vec::new();
                for (name, expr) in filters {
                    let value = self.expr(*expr);
                    if let Some(place) = value.place.clone() {
                        places.push((name.clone(), place, self.ty(*expr).clone()));
                    }
                    if let Some((name, _)) = names.iter().find(|(_, place)| place == expr) {
                        self.bind_pattern(*name, &Value { is_owned: false, ..value });
                    }
                }
                if self.at.is_some() {
                    self.guard_scope(span, &places);
                }
                Value::default()
            }
            MacroKind::EachCycle { names, control, body } => self.each_cycle(id, names, *control, *body),
        }
    }

    /// `write!(log, …)` calls what the analysed code says of writing into it, for each piece of the text.
    fn written_into(&mut self, id: ExprId, writer: ExprId, value: &Value) {
        let index = self.program.index;
        let ty = self.ty(writer).peel();
        let Some(place) = value.place.as_ref().filter(|_| self.at.is_some() && index.holds_filter(ty)) else { return };
        let own = WRITING.iter().flat_map(|name| index.methods(ty, name)).filter(|owner| owner.of_trait().is_some());
        let mut places = Vec::new();
        for function in own.filter_map(|owner| owner.function()) {
            match super::written::written_fields(self.program, function) {
                Some(fields) => places.extend(fields.iter().map(|field| place.field(field))),
                None => places.push(place.clone()),
            }
        }
        if !places.is_empty() {
            self.emit(Effect::Unknown { places, cause: Cause::Call(self.text(id)) }, self.span(id));
        }
    }

    /// `select!`: one arm runs, beside what the futures of the others have done before they are dropped.
    fn select(&mut self, id: ExprId, arms: &[SelectArm]) -> Value {
        let span = self.span(id);
        let join = self.new_join(self.ty(id).clone(), span);
        let futures: Vec<Value> =
            arms.iter().map(|arm| arm.future.map(|future| self.expr(future)).unwrap_or_default()).collect();
        for (number, arm) in arms.iter().enumerate() {
            if self.at.is_none() {
                break;
            }
            let mut next = None;
            if number + 1 < arms.len() {
                let place = arm.future.unwrap_or(arm.body);
                let mut about = self.about(place);
                about.is_event = true;
                let (yes, no) = self.opaque_branch(self.span(place), self.text(place), about);
                next = Some(no);
                self.resume(yes);
            }
            let others = arms.iter().zip(&futures).enumerate().filter(|(other, _)| *other != number);
            for (_, (other, future)) in others {
                self.run_unfinished(other.future, future);
            }
            let value = self.run_to_end(futures[number].clone(), span);
            self.suspend(span);
            if let Some(pat) = arm.pat {
                // An arm awaits its future without the word for it.
                if let Some(future) = arm.future {
                    self.derive_pattern(pat, future);
                    for var in self.vars_of(pat) {
                        self.graph.computed.entry(var).or_default().calls.push("await".to_owned());
                    }
                }
                self.bind_pattern(pat, &value);
            }
            if let Some(condition) = arm.condition {
                self.expr(condition);
            }
            let value = self.expr(arm.body);
            self.end_branch(&join, &value, self.span(arm.body));
            self.at = next;
        }
        self.close_join(&join)
    }

    /// `each_cycle!(f in control => { … })`: a loop whose every round is guarded.
    fn each_cycle(&mut self, id: ExprId, names: &[PatId], control: ExprId, body: ExprId) -> Value {
        let span = self.span(id);
        self.expr(control);
        let source = super::sources::Source { rounds: Rounds::Unbounded, ..super::sources::Source::bounded() };
        let first = names.first().copied();
        self.run_loop(CycleKind::Loop, span, None, source, |this, _, _| {
            this.open_block();
            if let Some(pat) = first {
                this.guard_set(pat, span);
            }
            this.expr(body);
            this.close_block(span);
        });
        Value::default()
    }

    /// The filters of a set, updated when the round ends.
    fn guard_set(&mut self, pat: PatId, span: crate::source::Span) {
        let Some(local) = self.typed().pat_local.get(&pat).copied() else { return };
        let var = self.var_of(local);
        let ty = self.typed().local(local).ty.peel().clone();
        self.guard_driven(var, &ty, span);
    }

    /// Guards every filter that a variable is or holds, which outlives the round.
    fn guard_driven(&mut self, var: crate::flow::Var, ty: &crate::index::Ty, span: crate::source::Span) {
        let outer = self.loops.last().and_then(|id| self.graph.loop_info(*id).parent);
        self.graph.vars[var.0 as usize].in_loop = outer;
        let name = self.graph.var(var).name.clone();
        let ty = match ty.peel() {
            crate::index::Ty::External(path, args) if path.ends_with("::Box") && !args.is_empty() => args[0].peel(),
            ty => ty,
        };
        let fields = self.filter_fields(ty).into_iter();
        let mut places: Vec<_> =
            fields.map(|(field, ty)| (format!("{name}.{field}"), Place::var(var).field(&field), ty)).collect();
        // A set may be a single filter, or a tuple or an array of them.
        if places.is_empty() && self.program.index.holds_filter(ty) {
            places.push((name, Place::var(var), ty.clone()));
        }
        self.guard_scope(span, &places);
    }

    /// `control.run(|f, info| …)`: a loop whose every round is guarded.
    pub(super) fn guarded_closure(
        &mut self,
        closure: super::ClosureRef,
        driver: &str,
        set: &crate::index::Ty,
        span: crate::source::Span,
    ) {
        let body = self.frames[closure.frame].body;
        let crate::syntax::tree::ExprKind::Closure(code) = &body.expr(closure.expr).kind else { return };
        let name = match code.params.first().map(|(pat, _)| &body.pat(*pat).kind) {
            Some(crate::syntax::tree::PatKind::Bind { name, .. }) => name.clone(),
            _ => format!("{driver}.filters"),
        };
        let var = self.new_var(name, set.clone(), span);
        let source = super::sources::Source { rounds: Rounds::Unbounded, ..super::sources::Source::bounded() };
        self.run_loop(CycleKind::Closure, code.bar, None, source, |this, _, _| {
            this.open_block();
            this.guard_driven(var, set, span);
            let filters = Value { place: Some(Place::var(var)), ..Value::default() };
            this.inline_closure(closure, &[filters, Value::default()], span);
            this.close_block(span);
        });
    }

    /// The fields of a type that are or hold filters.
    pub(super) fn filter_fields(&self, ty: &crate::index::Ty) -> Vec<(String, crate::index::Ty)> {
        let crate::index::Ty::Adt(id, _) = ty else { return Vec::new() };
        let index = self.program.index;
        match &index.type_def(*id).shape {
            crate::index::Shape::Struct(fields) => fields
                .fields
                .iter()
                .filter_map(|field| Some((field.name.clone(), index.field_ty(ty, None, &field.name)?)))
                .filter(|(_, ty)| index.holds_filter(ty))
                .collect(),
            crate::index::Shape::Enum(_) => Vec::new(),
        }
    }
}

/// The methods of `fmt::Write`, `io::Write` and their like that formatted text goes through.
const WRITING: &[&str] = &["write_fmt", "write_str", "write_char", "write_all", "write"];

/// Whether a macro writes into what its first operand is.
fn writes_into(path: &str) -> bool {
    matches!(path.rsplit("::").next().unwrap_or(""), "write" | "writeln" | "uwrite" | "uwriteln")
}
