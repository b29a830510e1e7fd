//! Expressions: what they do, in the order in which it happens.

use super::conditions::presence_head;
use super::flags::leads_to_cell;
use super::{Builder, ClosureRef, Value};
use crate::flow::{Cause, Effect, IndexKey, Place, Projection, UnrunKind, Var};
use crate::index::{Def, SHARED_RESOURCE, Shape, Ty};
use crate::syntax::tree::{ExprId, ExprKind, TypeRef};
use crate::types::Callee;

impl Builder<'_> {
    /// Lowers an expression and answers its value. Code that is never reached is not lowered.
    pub(super) fn expr(&mut self, id: ExprId) -> Value {
        let value = self.own_value(id);
        self.coerced(id, value)
    }

    /// The value of an expression before it is lent as something else.
    fn own_value(&mut self, id: ExprId) -> Value {
        if self.at.is_none() {
            return Value::default();
        }
        if let Some(cause) = self.graph.truncated.clone() {
            self.pass_over(id, cause);
            return Value::default();
        }
        let body = self.body();
        match &body.expr(id).kind {
            ExprKind::Path(_) => self.path_value(id),
            ExprKind::Literal(_) => Value { head: self.constant_head(id), ..Value::default() },
            ExprKind::Block(block) => self.block(id, block),
            ExprKind::If { condition, then, otherwise } => self.if_expr(id, *condition, *then, *otherwise),
            ExprKind::Let { .. } => self.condition_value(id),
            ExprKind::Match { scrutinee, arms } => self.match_expr(id, *scrutinee, arms),
            ExprKind::Loop { label, keyword, body } => self.loop_expr(id, label.as_ref(), *keyword, *body),
            ExprKind::While { label, keyword, condition, body } => {
                self.while_expr(id, label.as_ref(), *keyword, *condition, *body)
            }
            ExprKind::For { label, keyword, pat, iterable, body } => {
                self.for_expr(label.as_ref(), *keyword, *pat, *iterable, *body)
            }
            ExprKind::Break { label, value } => self.break_expr(id, label.as_ref(), *value),
            ExprKind::Continue { label } => self.continue_expr(id, label.as_ref()),
            ExprKind::Return(value) => self.return_expr(id, *value),
            _ if self.truth_of(id).is_some() => self.truth_as_number(id),
            ExprKind::Call { callee, args } => self.call_expr(id, *callee, args),
            ExprKind::MethodCall { method, .. }
                if method == "is_multiple_of" && matches!(self.typed().callees.get(&id), Some(Callee::Builtin)) =>
            {
                self.condition_value(id)
            }
            // Whether something is there is a truth value that later conditions ask for.
            ExprKind::MethodCall { receiver, method, args, .. }
                if args.is_empty() && presence_head(method).is_some() && self.is_optional(*receiver) =>
            {
                self.condition_value(id)
            }
            ExprKind::MethodCall { receiver, method, args, .. }
                if self.is_payload_question(*receiver, method, args) =>
            {
                self.condition_value(id)
            }
            // So is what only reads: `feed(&mut f, queue.is_empty()); feed(&mut f, !queue.is_empty());`
            ExprKind::MethodCall { .. } if *self.ty(id) == Ty::Bool && self.pure(id).is_some() => {
                self.condition_value(id)
            }
            ExprKind::MethodCall { receiver, method, args, .. } => self.method_expr(id, *receiver, method, args),
            ExprKind::Field { base, name } => {
                let value = self.expr(*base);
                self.drop_unnamed(*base, &value);
                let place = value.place.map(|place| self.read_field(*base, place, name));
                if let Some(place) = &place
                    && self.may_hold_filter(self.ty(*base))
                {
                    self.note_use(place, id);
                }
                // What stands for an RTIC resource can be moved; the resource stays where it is.
                let is_handle = matches!(self.ty(id), Ty::External(path, _) if path == SHARED_RESOURCE);
                Value { place, is_owned: !is_handle, ..Value::default() }
            }
            ExprKind::Index { base, index } => self.index_expr(id, *base, *index),
            ExprKind::Reference { raw, mutable, value } => {
                let inner = *value;
                let value = self.expr(inner);
                self.drop_unnamed(inner, &value);
                self.note_lent_cell(inner, &value);
                self.note_lent_away(inner, &value);
                if *mutable && !self.frames[self.frame].passed.contains(&id) {
                    self.note_lent(inner);
                }
                if *raw && let Some(place) = &value.place {
                    let cause = Cause::Code("a raw pointer".to_owned());
                    self.emit(Effect::Unknown { places: vec![place.clone()], cause }, self.span(id));
                }
                Value { is_owned: false, ..value }
            }
            // `&mut *(&raw mut FILTER)` is a reference to what it names.
            ExprKind::Deref(inner)
                if let ExprKind::Reference { raw: true, value, .. } = &self.body().expr(*inner).kind =>
            {
                let value = self.expr(*value);
                Value { is_owned: true, ..value }
            }
            ExprKind::Deref(inner) => {
                let value = self.expr(*inner);
                let place = match self.field_lent(*inner) {
                    Some(field) => Some(field),
                    None => value.place.map(|place| self.deref_place(*inner, place)),
                };
                // What is called behind a box or a reference is what was put there: `(*step)(x)`, `run(&mut *step)`.
                let closure = value.closure.filter(|closure| !self.is_of_future(*closure));
                Value { place, closure, is_owned: true, ..Value::default() }
            }
            ExprKind::Not(inner) if self.program.index.holds_filter(self.ty(*inner)) => {
                let value = self.expr(*inner);
                self.operands(id, "!", &[*inner], &[value])
            }
            ExprKind::Not(_) => self.condition_value(id),
            ExprKind::Negate(inner) => {
                let value = self.expr(*inner);
                let value = self.operands(id, "-", &[*inner], &[value]);
                Value { head: self.constant_head(id), ..value }
            }
            ExprKind::Binary { op: "&&" | "||" | "==" | "!=" | "<" | "<=" | ">" | ">=", .. } => {
                self.condition_value(id)
            }
            ExprKind::Binary { op, lhs, rhs } => {
                let values = [self.expr(*lhs), self.expr(*rhs)];
                self.operands(id, op, &[*lhs, *rhs], &values)
            }
            ExprKind::Assign { place, value } => self.assign(id, *place, *value),
            ExprKind::AssignOp { op, place, value } => self.assign_op(id, op, *place, *value),
            ExprKind::Range { start, end, .. } => {
                for bound in [start, end].into_iter().flatten() {
                    self.expr(*bound);
                }
                Value::default()
            }
            ExprKind::Closure(code) => {
                let closure = ClosureRef { frame: self.frame, expr: id };
                if code.is_move {
                    let taken = self.captured_locals(closure).into_iter().map(|(_, var)| var);
                    self.graph.moved_along.extend(taken.collect::<Vec<_>>());
                }
                self.copy_captured(closure, self.span(id));
                self.note_unrun(closure, UnrunKind::Closure, self.captured_to_update(closure));
                Value { closure: Some(closure), ..Value::default() }
            }
            ExprKind::Struct { fields, rest, .. } => self.struct_value(id, fields, *rest),
            ExprKind::Tuple(parts) => self.aggregate(id, parts),
            ExprKind::Array { elements, .. } => self.array_value(id, elements),
            ExprKind::Repeat { value, len, .. } => {
                let repeated = self.expr(*value);
                // `[&bus; 2]`
                if matches!(self.ty(*value), Ty::Ref(..)) && self.may_hold_filter(self.ty(*value)) {
                    let all = Place::var(self.temporary(self.ty(id).clone(), self.span(id)));
                    self.place_part(all.element(IndexKey::Each), &repeated, *value);
                    self.expr(*len);
                    return Value { place: Some(all), is_owned: true, ..Value::default() };
                }
                if self.keep_clones(&repeated, *value).is_none() {
                    self.keep(&repeated, *value);
                }
                self.expr(*len);
                Value::default()
            }
            ExprKind::Cast { value: inner, .. } => {
                let value = self.expr(*inner);
                if let Some(place) = value.place.as_ref().filter(|_| self.loses_type(id, *inner)) {
                    let cause = Cause::Code("a pointer without the filter's type".to_owned());
                    self.emit(Effect::Unknown { places: vec![place.clone()], cause }, self.span(id));
                    self.keep_pointed(*inner, &value);
                    return Value::default();
                }
                if self.is_reinterpreted(id, *inner) {
                    let var = self.temporary(self.ty(id).clone(), self.span(id));
                    return Value { place: Some(Place::var(var)), ..Value::default() };
                }
                if !self.keeps_value(id) {
                    if matches!(self.ty(*inner), Ty::Pointer(_)) {
                        self.keep_pointed(*inner, &value);
                    }
                    return Value::default();
                }
                // `Box::new(|x| f.update(x)) as Box<dyn FnMut(f64)>` is that closure.
                let is_called = self.ty(id).called_as().is_some();
                let closure = value.closure.filter(|closure| is_called || self.is_of_future(*closure));
                Value { closure, iterator: None, ..value }
            }
            ExprKind::Try(inner) => self.try_expr(id, *inner),
            ExprKind::Await(inner) => {
                let value = self.expr(*inner);
                let value = self.run_to_end(value, self.span(id));
                if self.at.is_some() && self.is_of_never(*inner) {
                    self.diverge(self.span(id));
                    return Value::default();
                }
                if self.may_suspend(*inner) {
                    self.suspend(self.span(id));
                }
                value
            }
            ExprKind::Macro(macro_expr) => self.macro_expr(id, macro_expr),
            ExprKind::Opaque(call) => {
                self.unknown_mentions(&call.mentions, &call.fields, Cause::Macro(call.path.clone()), call.span);
                self.may_leave(call);
                Value::default()
            }
            ExprKind::Unknown { what, mentions } => {
                self.unknown_mentions(mentions, &[], Cause::Code(what.clone()), self.span(id));
                Value::default()
            }
        }
    }

    /// An operator of another type than a number's takes a filter by value: where it is from then on is not known, unless its impl
    /// is analysed code.
    fn operands(&mut self, id: ExprId, op: &str, operands: &[ExprId], values: &[Value]) -> Value {
        if let Some(value) = self.operator_call(id, op, operands, values) {
            return value;
        }
        let copy = self.lose_operands(id, operands, values);
        // What comes back may be what it took, run or not.
        copy.filter(|_| *self.ty(id) == Ty::Unknown || self.may_hold_filter(self.ty(id))).unwrap_or_default()
    }

    /// What an operator takes that is not seen. Of a value that is copied, it is the copy, which is given back.
    pub(super) fn lose_operands(&mut self, id: ExprId, operands: &[ExprId], values: &[Value]) -> Option<Value> {
        self.at?;
        let (mut places, mut copied) = (Vec::new(), None);
        for (operand, value) in operands.iter().zip(values) {
            let ty = self.ty(*operand).clone();
            if value.place.is_none() || matches!(ty, Ty::Ref(..)) || !self.program.index.holds_filter(&ty) {
                continue;
            }
            if self.program.index.copies_filter(&ty) {
                let copy = self.copy_of(value, ty, self.span(*operand));
                places.extend(copy.place.clone());
                copied.get_or_insert(copy);
            } else {
                places.extend(value.place.clone());
            }
        }
        if !places.is_empty() {
            self.emit(Effect::Unknown { places, cause: Cause::Call(self.text(id)) }, self.span(id));
        }
        copied
    }

    fn path_value(&mut self, id: ExprId) -> Value {
        if let Some(place) = self.stand_in(id) {
            return Value { place: Some(place), is_owned: true, ..Value::default() };
        }
        if let Some(local) = self.typed().expr_local.get(&id).copied() {
            let var = self.var_of(local);
            let closure = self.closures.get(&var).copied();
            let is_owned = !matches!(self.ty(id), Ty::Ref(..));
            let head = self.numbers.get(&var).map(u64::to_string);
            let iterator = self.iterators.get(&var).cloned();
            let place = Some(Place::var(var));
            return Value { place, is_owned, same_as: Some(var), closure, head, iterator, ..Value::default() };
        }
        if let Some(place) = self.path_place(id) {
            return Value { place: Some(place), is_owned: true, ..Value::default() };
        }
        let item = self.typed().items.contains_key(&id).then_some(ClosureRef { frame: self.frame, expr: id });
        Value { head: self.constant_head(id), closure: item, ..Value::default() }
    }

    /// What `*expr` names: the same place, through the `Deref` impl of a newtype.
    fn deref_place(&mut self, inner: ExprId, place: Place) -> Place {
        let ty = self.ty(inner);
        if matches!(ty, Ty::Adt(..))
            && let Some(through) = self.deref_function(ty)
        {
            return self.dereferenced(place, through, self.span(inner));
        }
        place
    }

    fn deref_function(&self, ty: &Ty) -> Option<crate::index::FunctionId> {
        let index = self.program.index;
        index.methods(ty, "deref_mut").into_iter().chain(index.methods(ty, "deref")).next()?.function()
    }

    /// A struct literal: what its fields are given moves into the new value.
    pub(super) fn struct_value(&mut self, id: ExprId, fields: &[(String, ExprId)], rest: Option<ExprId>) -> Value {
        let span = self.span(id);
        let variant = match self.typed().expr_def.get(&id) {
            Some(Def::Variant(ty, at)) => Some(super::constants::variant_head(self.program, *ty, *at)),
            _ => None,
        };
        let var = self.temporary(self.ty(id).clone(), span);
        let ty = self.ty(id).clone();
        self.note_field_step(var, &ty, fields);
        for (name, field) in fields {
            let value = self.expr(*field);
            let mut place = Place::var(var);
            if let Some(variant) = &variant {
                place = place.field(variant);
            }
            self.place_part(place.field(name), &value, *field);
        }
        if let Some(rest) = rest {
            let value = self.expr(rest);
            self.place_rest(var, fields, &value, rest);
        }
        let value = Value { place: Some(Place::var(var)), is_owned: true, head: variant, ..Value::default() };
        self.note_literal(id, &value);
        value
    }

    /// `S { f: new, ..rest }`: what is not given anew comes from the rest. What is a filter itself goes on as a whole.
    fn place_rest(&mut self, var: Var, given: &[(String, ExprId)], value: &Value, rest: ExprId) {
        let index = self.program.index;
        let ty = self.graph.var(var).ty.clone();
        let is_whole = index.filter_spec(&ty).is_some() || index.may_be_state(&ty);
        let shape = match &ty {
            Ty::Adt(id, _) if !is_whole => &index.type_def(*id).shape,
            _ => return self.place_part(Place::var(var), value, rest),
        };
        let Shape::Struct(shape) = shape else { return };
        let is_given = |name: &String| given.iter().any(|(given, _)| given == name);
        for field in shape.fields.iter().filter(|field| !is_given(&field.name)) {
            if index.field_ty(&ty, None, &field.name).is_some_and(|ty| self.is_state(&ty))
                && let Some(from) = &value.place
            {
                self.part_of_state(Place::var(var).field(&field.name), from.field(&field.name), self.span(rest));
            }
            if index.field_ty(&ty, None, &field.name).is_none_or(|ty| self.may_hold_filter(&ty)) {
                let place = value.place.as_ref().map(|place| place.field(&field.name));
                let part = Value { place, head: None, same_as: None, ..value.clone() };
                self.place_part(Place::var(var).field(&field.name), &part, rest);
            }
        }
    }

    pub(super) fn aggregate(&mut self, id: ExprId, parts: &[ExprId]) -> Value {
        let span = self.span(id);
        let var = self.temporary(self.ty(id).clone(), span);
        for (number, part) in parts.iter().enumerate() {
            let value = self.expr(*part);
            self.place_part(Place::var(var).field(&number.to_string()), &value, *part);
        }
        Value { place: Some(Place::var(var)), is_owned: true, ..Value::default() }
    }

    /// A tuple or array whose parts are known already.
    pub(super) fn gathered(&mut self, id: ExprId, parts: &[ExprId], values: &[Value]) -> Value {
        let is_array = matches!(self.body().expr(id).kind, ExprKind::Array { .. });
        let var = self.temporary(self.ty(id).clone(), self.span(id));
        for (number, (part, value)) in parts.iter().zip(values).enumerate() {
            let whole = Place::var(var);
            let place = match is_array {
                true => whole.element(IndexKey::Number(number as u64)),
                false => whole.field(&number.to_string()),
            };
            self.place_part(place, value, *part);
        }
        Value { place: Some(Place::var(var)), is_owned: true, ..Value::default() }
    }

    pub(super) fn array_value(&mut self, id: ExprId, elements: &[ExprId]) -> Value {
        let span = self.span(id);
        let var = self.temporary(self.ty(id).clone(), span);
        for (number, element) in elements.iter().enumerate() {
            let value = self.expr(*element);
            let key = IndexKey::Number(number as u64);
            self.place_part(Place::var(var).element(key), &value, *element);
        }
        Value { place: Some(Place::var(var)), is_owned: true, ..Value::default() }
    }

    /// A value goes into a collection that is not followed element by element.
    pub(super) fn keep(&mut self, value: &Value, expr: ExprId) -> Place {
        let collection = self.temporary(Ty::Unknown, self.span(expr));
        // What a closure gives back goes on as a value of its own, unless it is a reference.
        let base = value.place.as_ref().and_then(Place::base_var);
        let is_value = base.is_some_and(|var| matches!(self.graph.var(var).ty, Ty::Adt(..) | Ty::External(..)));
        let value = Value { is_owned: value.is_owned || is_value, ..value.clone() };
        self.place_part(Place::var(collection).element(IndexKey::Each), &value, expr);
        Place::var(collection)
    }

    /// Each element is a clone of one value, whose handles lead to the same: the collection of them, if it has such handles.
    pub(super) fn keep_clones(&mut self, value: &Value, expr: ExprId) -> Option<Place> {
        if value.head.as_deref() == Some("-") || !self.program.index.may_share_filter(self.ty(expr)) {
            return None;
        }
        let original = Place::var(self.temporary(self.ty(expr).clone(), self.span(expr)));
        self.place_part(original.clone(), value, expr);
        let original = Value { place: Some(original), is_owned: true, ..Value::default() };
        let collection = self.keep(&original, expr);
        self.place_part(collection.element(IndexKey::Each), &original, expr);
        Some(collection)
    }

    /// The same for what may have no handles: it is handed over, and is no filter of its own any more.
    pub(super) fn hand_clones(&mut self, value: &Value, expr: ExprId) {
        let clones = self.keep_clones(value, expr);
        if clones.is_none() && value.place.is_some() && self.may_hold_filter(self.ty(expr)) {
            self.keep(value, expr);
        }
    }

    /// What a closure gives for each element may be a handle to the same each time.
    pub(super) fn keep_result(&mut self, closure: ClosureRef, value: &Value) {
        let body = self.frames[closure.frame].body;
        let ExprKind::Closure(code) = &body.expr(closure.expr).kind else { return };
        let outer = std::mem::replace(&mut self.frame, closure.frame);
        let ty = self.ty(code.body);
        if self.at.is_some() && !matches!(ty, Ty::Ref(..)) && self.program.index.may_share_filter(ty) {
            self.keep(value, code.body);
        }
        self.frame = outer;
    }

    /// Notes that a reference to a place with filters was made.
    pub(super) fn note_lent_away(&mut self, id: ExprId, value: &Value) {
        if let Some(place) = value.place.as_ref().filter(|_| self.at.is_some() && self.may_hold_filter(self.ty(id))) {
            self.graph.lent_away.insert(place.clone());
        }
    }

    /// A part of a new value.
    pub(super) fn place_part(&mut self, part: Place, value: &Value, expr: ExprId) {
        self.note_lent_on(expr);
        self.keep_closure_in(part.base_var(), value, self.span(expr));
        self.move_made(value.place.as_ref(), &part);
        if let (Some(guard), Some(var)) = (self.moved_guard(value), part.base_var()) {
            self.guards_of.insert(var, guard);
        }
        self.state_part(&part, value, expr);
        if self.is_option_of_references(self.ty(expr)) {
            return self.option_part(part, value, expr);
        }
        let is_named = self.may_hold_filter(self.ty(expr)) || leads_to_cell(self.ty(expr));
        if self.at.is_none() || value.place.is_none() || !is_named {
            return;
        }
        let assignment = crate::flow::Assignment {
            place: part,
            from: value.place.clone(),
            transfer: self.transfer(value, self.ty(expr)),
            rebinds: true,
            head: None,
            same_as: None,
        };
        self.emit(Effect::Set(Box::new(assignment)), self.span(expr));
    }

    /// Notes that a filter is read or fed.
    pub(super) fn note_use(&mut self, place: &Place, id: ExprId) {
        if self.at.is_some() && place.steps.iter().any(|step| matches!(step, Projection::Field(_))) {
            self.emit(Effect::Use { place: place.clone() }, self.span(id));
        }
    }

    /// Whether a call runs something that never returns.
    pub(super) fn never_returns(&self, id: ExprId) -> bool {
        let index = self.program.index;
        match self.typed().callees.get(&id) {
            // What an `async fn` gives is a future: it never returns where it is awaited.
            Some(Callee::Resolved(resolved)) => {
                let is_async = resolved.targets.iter().any(|target| index.function(*target).function.is_async);
                !is_async && (self.is_of_never(id) || self.program.never_returns(resolved))
            }
            Some(Callee::External(path)) => crate::flow::program::is_exit(path),
            _ => false,
        }
    }

    /// Whether the function that is called is declared to give `!`.
    fn is_of_never(&self, id: ExprId) -> bool {
        let index = self.program.index;
        let is_never = |target: &crate::index::FunctionId| index.function(*target).function.output == TypeRef::Never;
        matches!(self.typed().callees.get(&id), Some(Callee::Resolved(resolved)) if resolved.targets.iter().any(is_never))
    }
}
