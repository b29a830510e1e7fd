//! Methods of the standard library that hand out, test, replace or visit what a wrapper holds.

use super::sources::{Item, Source};
use super::{Builder, ClosureRef, Value};
use crate::flow::{Cause, Effect, IndexKey, NodeId};
use crate::index::Ty;
use crate::source::Span;
use crate::syntax::tree::ExprId;

impl Builder<'_> {
    pub(super) fn builtin_method(&mut self, id: ExprId, receiver: ExprId, method: &str, args: &[ExprId]) -> Value {
        if let Some(value) = self.lock_each(receiver, method, args, self.span(id)) {
            return value;
        }
        let value = self.expr(receiver);
        if self.at.is_none() {
            return Value::default();
        }
        self.note_foreign_iterator(id, receiver, method, &value);
        if let Some(found) = self.method_by_name(id, receiver, method, args, &value) {
            return found;
        }
        if let Some(found) = self.leaves_collection(id, receiver, method, args, &value) {
            return found;
        }
        let values = self.values(args);
        let span = self.span(id);
        if self.is_future(&value) {
            self.keep_closure(&value, span);
        }
        if let Some(value) = self.runs_given(id, &values) {
            return value;
        }
        self.keep_iterator(&value, &Cause::Call(self.text(id)), span);
        match &value.place {
            Some(owner) => self.put_away(id, owner, args, &values),
            None => self.give_away(id, &[], args, &values),
        }
        self.note_put_into(method, receiver, args);
        self.note_taken_out(method, &value);
        self.leaves_pool(id, method, &value, args);
        match method {
            // `push(value)`, `map.insert(key, value)`, `bank.resize(4, value)`
            "push" | "push_back" | "push_front" | "insert" | "resize" => {
                self.derive_scratch(receiver, args);
                self.moves_others(id, receiver, method, args, &value);
                if let (Some(place), Some(given), Some(arg)) = (&value.place, values.last(), args.last()) {
                    let part = place.element(self.new_key(receiver, method));
                    let clones = if method == "resize" { self.keep_clones(given, *arg) } else { None };
                    match clones.map(|clones| clones.element(IndexKey::Each)) {
                        Some(clone) => {
                            let clone = Value { place: Some(clone), is_owned: true, ..Value::default() };
                            self.place_part(part, &clone, *arg);
                        }
                        None => self.place_part(part, given, *arg),
                    }
                }
                Value::default()
            }
            "fill" => {
                if let ([given], [arg]) = (values.as_slice(), args) {
                    self.hand_clones(given, *arg);
                }
                Value::default()
            }
            "extend" if self.extend_references(id, receiver, &value, &values) => Value::default(),
            "extend" | "extend_from_slice" if values.iter().any(|value| value.iterator.is_some()) => {
                for (value, arg) in values.into_iter().zip(args) {
                    if let Some(source) = value.iterator {
                        self.gather(*arg, &source);
                    }
                }
                Value::default()
            }
            "extend" | "extend_from_slice" | "append" => {
                if let (Some(place), [given], [arg]) = (&value.place, values.as_slice(), args)
                    && let Some(from) = &given.place
                {
                    let part = place.element(IndexKey::Data("the new elements".into()));
                    let each = Value { place: Some(from.element(IndexKey::Each)), ..given.clone() };
                    let each = self.put_in_each(method, each, *arg);
                    self.place_part(part, &each, *arg);
                }
                Value::default()
            }
            // A closure that the standard library calls is run where it stands.
            _ => {
                for value in &values {
                    self.keep_iterator(value, &Cause::Call(self.text(id)), span);
                }
                for value in values.iter().filter(|value| self.is_future(value)).cloned().collect::<Vec<_>>() {
                    self.keep_closure(&value, span);
                }
                let is_run = |closure: &ClosureRef| !self.is_of_future(*closure);
                if let Some(closure) = values.iter().filter_map(|value| value.closure).find(is_run) {
                    self.closure_loop(closure, Source::bounded(), span);
                }
                Value::default()
            }
        }
    }

    /// Methods that are told by their names, whatever the type: they hand out what the receiver holds.
    pub(super) fn method_by_name(
        &mut self,
        id: ExprId,
        receiver: ExprId,
        method: &str,
        args: &[ExprId],
        value: &Value,
    ) -> Option<Value> {
        let span = self.span(id);
        if self.is_future(value) && super::futures::keeps_future(method) {
            return Some(value.clone());
        }
        if self.is_future(value) && super::futures::blocks_on(method) {
            return Some(self.awaited(value.clone(), span));
        }
        if let Some(found) = self.shared_method(receiver, method, args, value, span) {
            return Some(found);
        }
        Some(match method {
            "iter_mut" | "iter" | "into_iter" | "values_mut" | "values" | "into_values" | "par_iter_mut"
            | "par_iter"
                if value.place.is_some() && super::sources::is_map(self.ty(receiver).peel()) =>
            {
                self.map_items(method, value)
            }
            "chunks_mut" | "chunks_exact_mut" if value.place.is_some() => {
                let item = value.place.clone().map_or(Item::Opaque, Item::Element);
                let length = match self.ty(receiver).peel() {
                    Ty::Array(_, length) => Some(length.clone()),
                    _ => None,
                };
                let source = self.chunked(id, method, args, Source { item, length, ..Source::bounded() });
                self.iterator_value(source)
            }
            "unwrap" | "expect" | "unwrap_unchecked" => {
                for arg in args {
                    self.expr(*arg);
                }
                self.assume_present(value, receiver, span);
                self.copied_out(id, receiver, Value { head: None, same_as: None, ..value.clone() })
            }
            "upgrade" | "into_inner" if args.is_empty() && self.hands_out(receiver, method) => {
                Value { is_owned: false, head: None, same_as: None, ..value.clone() }
            }
            "as_mut" | "as_ref" | "as_deref_mut" | "as_deref" | "as_pin_mut" | "iter_mut" | "iter" | "as_mut_slice"
            | "as_slice" | "borrow_mut" | "borrow" | "try_borrow_mut" | "by_ref" | "deref_mut" | "deref"
            | "get_mut" | "lock" | "try_lock" | "write" | "read" | "try_write" | "get_unchecked_mut"
            | "assume_init_mut" | "leak" | "into_iter" | "each_mut" | "each_ref" | "par_iter_mut" | "par_iter"
                if args.is_empty() =>
            {
                if method.ends_with("_mut") {
                    self.note_lent_away(receiver, value);
                }
                let keeps_head =
                    !matches!(method, "lock" | "try_lock" | "write" | "read" | "iter" | "iter_mut" | "into_iter");
                let same_as = value.same_as.filter(|_| keeps_head);
                Value { is_owned: false, head: None, same_as, ..value.clone() }
            }
            "ok" | "map_err" | "inspect_err" | "context" | "with_context" | "ok_or" | "ok_or_else" | "or_default"
            | "wrap_err" | "err_into" => {
                for arg in args {
                    let given = self.expr(*arg);
                    if let Some(closure) = given.closure {
                        self.on_absent(value, receiver, span, |this| {
                            this.inline_closure(closure, &[Value::default()], span);
                        });
                    }
                }
                Value { closure: None, iterator: None, ..value.clone() }
            }
            // What a `Cell` gives is a copy, and may be put back with `set`.
            "get" if args.is_empty() => {
                let is_copy = self.program.index.copies_filter(self.ty(id));
                let content = Value { is_owned: is_copy, head: None, same_as: None, ..value.clone() };
                if is_copy { self.copy_of(&content, self.ty(id).clone(), span) } else { content }
            }
            "replace"
                if args.len() == 1
                    && (self.is_cell(receiver)
                        || self.is_optional(receiver) && self.program.index.refers_to_filters(self.ty(id))) =>
            {
                self.replace_content(id, value, args)
            }
            "set" if args.len() == 1 && self.is_cell(receiver) => {
                let given = self.expr(args[0]);
                if let Some(place) = value.place.clone() {
                    self.take_over_in(self.ty(args[0]).peel(), &place, &given, args[0]);
                }
                // A filter of longer standing goes on beside its copy.
                match given.place.as_ref().is_some_and(|place| self.is_older(place)) {
                    true if self.program.index.copies_filter(self.ty(args[0])) => self.write_copy(value, &given, span),
                    _ => self.write_whole(value, &given, span),
                }
                self.note_put_in_cell(&given, args[0]);
                Value::default()
            }
            "clear" | "fill" if self.makes_anew(receiver, method) => {
                for arg in args {
                    let given = self.expr(*arg);
                    self.hand_clones(&given, *arg);
                }
                self.write_whole(value, &Value::default(), span);
                self.note_pointed(self.ty(receiver).peel());
                Value::default()
            }
            "take" if args.is_empty() && self.drops_content(id, receiver) => self.drop_content(receiver, value, span),
            "take" if args.is_empty() && self.is_optional(receiver) && value.place.is_some() => {
                self.taken_out(id, value)
            }
            "take" | "into_boxed_slice" if args.is_empty() => Value { is_owned: true, head: None, ..value.clone() },
            "replace" | "insert" if args.len() == 1 && value.place.is_some() => {
                let mut given = self.expr(args[0]);
                if self.is_optional(receiver) {
                    given.head = Some("+".to_owned());
                }
                self.write_whole(value, &given, span);
                self.note_pointed(self.ty(receiver).peel());
                match &value.place {
                    Some(_) if self.is_optional(receiver) => self.note_filled(args[0]),
                    Some(place) => self.note_given(place, args[0]),
                    None => {}
                }
                Value { is_owned: false, ..value.clone() }
            }
            "copy_from_slice" | "clone_from_slice" if args.len() == 1 && self.may_hold_filter(self.ty(receiver)) => {
                let given = self.expr(args[0]);
                self.write_copy(value, &given, span);
                Value::default()
            }
            "clone_from" if args.len() == 1 => self.cloned_from(value, args[0], span),
            "get_or_insert_with" | "or_insert_with" | "get_or_insert" | "or_insert" | "get_or_init" => {
                self.get_or_insert(id, receiver, args, value)
            }
            "or" | "xor" if args.len() == 1 && self.is_optional(receiver) && self.may_hold_filter(self.ty(id)) => {
                self.either_option(id, receiver, args[0], value, method == "xor")
            }
            "unwrap_or" | "unwrap_or_else" | "unwrap_or_default" | "or_else" | "or" => {
                let given = args.first().map(|arg| self.expr(*arg)).unwrap_or_default();
                if let Some(closure) = given.closure {
                    self.on_absent(value, receiver, span, |this| {
                        this.inline_closure(closure, &[Value::default()], span);
                    });
                }
                self.copied_out(id, receiver, Value { head: None, same_as: None, ..value.clone() })
            }
            "flatten" if args.is_empty() && self.is_optional(receiver) => {
                Value { head: None, same_as: None, ..value.clone() }
            }
            "take_if" if args.len() == 1 && self.is_optional(receiver) && !self.may_hold_filter(self.ty(id)) => {
                self.filter_payload(id, receiver, args[0], value)
            }
            "take_if" if args.len() == 1 && self.is_optional(receiver) && value.place.is_some() => {
                let cause = Cause::Call(self.text(id));
                self.emit(Effect::Unknown { places: value.place.iter().cloned().collect(), cause }, span);
                self.values(args);
                Value::default()
            }
            "filter" if args.len() == 1 && self.is_optional(receiver) => {
                self.filter_payload(id, receiver, args[0], value)
            }
            "zip" if args.len() == 1 && self.is_optional(receiver) => self.zip_options(id, receiver, args[0], value),
            "map" | "and_then" | "map_or" | "is_some_and" | "is_ok_and" | "is_none_or" | "map_or_else" | "inspect"
                if self.is_optional(receiver) =>
            {
                self.map_payload(id, receiver, method, args, value)
            }
            "then" | "then_some" if *self.ty(receiver).peel() == Ty::Bool => {
                let given = args.first().map(|arg| self.expr(*arg)).unwrap_or_default();
                if let Some(closure) = given.closure.filter(|_| self.is_guard(id)) {
                    return Some(self.guard_if_true(id, value, receiver, closure));
                }
                self.then_value(id, receiver, value, given)
            }
            "lock" | "with" | "with_mut" | "with_borrow" | "with_borrow_mut" | "lock_mut" | "with_lock"
            | "lock_ref_mut" | "access"
                if args.len() == 1 =>
            {
                let given = self.expr(args[0]);
                match given.closure {
                    Some(closure) => self.run_locked(closure, receiver, value, span),
                    // `MUTEX.borrow(cs)` and its kin take a token.
                    None => Value { is_owned: false, ..value.clone() },
                }
            }
            "borrow" | "borrow_ref_mut" | "borrow_ref" | "borrow_mut" if args.len() == 1 => {
                self.expr(args[0]);
                Value { is_owned: false, ..value.clone() }
            }
            "get_mut" | "get" | "get_unchecked_mut" | "get_unchecked" if args.len() == 1 => {
                self.expr(args[0]);
                let is_map = super::sources::is_map(self.ty(receiver).peel());
                let key = if is_map { self.map_key(args[0]) } else { self.index_key(args[0]) };
                let key = key.unwrap_or_else(|| IndexKey::Data(self.text(args[0]).into()));
                let place = value.place.as_ref().map(|place| {
                    self.note_indexing(&key, place);
                    place.element(self.certain_key(&key))
                });
                Value { place, ..Value::default() }
            }
            "split_at_mut" | "split_first_mut" | "split_last_mut" => self.split(id, receiver, method, args, value),
            "split_at_mut_unchecked" | "get_disjoint_mut" => {
                for arg in args {
                    self.expr(*arg);
                }
                if method == "get_disjoint_mut"
                    && self.may_hold_filter(self.ty(receiver))
                    && let Some(lent) = self.lent_disjoint(id, args, value)
                {
                    return Some(lent);
                }
                if let Some(place) = &value.place
                    && self.may_hold_filter(self.ty(receiver))
                {
                    let cause = Cause::Index(self.text(id));
                    self.emit(Effect::Unknown { places: vec![place.clone()], cause }, span);
                }
                Value::default()
            }
            "first_mut" | "first" | "front_mut" if args.is_empty() => Value {
                place: value.place.as_ref().map(|place| place.element(IndexKey::Number(0))),
                head: self.has_elements(receiver).then(|| "+".to_owned()),
                ..Value::default()
            },
            "last_mut" | "last" | "back_mut" | "back" | "peek_mut" if args.is_empty() => {
                let count = match self.ty(receiver).peel() {
                    Ty::Array(_, length) => length.value,
                    _ => self.next_number(receiver),
                };
                let last = count.and_then(|count| count.checked_sub(1));
                let key = last.map_or_else(|| IndexKey::Data(format!("{method}()").into()), IndexKey::Number);
                let head = self.has_elements(receiver).then(|| "+".to_owned());
                Value { place: value.place.as_ref().map(|place| place.element(key)), head, ..Value::default() }
            }
            "peek" if self.may_look_ahead(receiver, value) => self.look_ahead(id, value),
            "next" | "next_back" | "nth"
                if self.iterates(self.ty(receiver))
                    && (value.iterator.is_some() || self.may_hold_filter(self.ty(id))) =>
            {
                for arg in args {
                    self.expr(*arg);
                }
                let item = self.next_item(id, value);
                self.note_advanced(receiver);
                item
            }
            "entry" => {
                for arg in args {
                    self.expr(*arg);
                }
                let key = self.entry_key(args);
                let place = value.place.as_ref().map(|place| place.element(key));
                Value { place, ..Value::default() }
            }
            // A clone of a handle is another name of what it shares.
            // A condition variable gives back the guard that it is handed.
            "wait" | "wait_while" if self.ty(receiver).peel().external_name() == Some("Condvar") => {
                let values: Vec<Value> = args.iter().map(|arg| self.expr(*arg)).collect();
                values.into_iter().next().unwrap_or_default()
            }
            "clone" if self.clones_name(receiver) => {
                if super::flags::leads_to_cell(self.ty(receiver)) {
                    self.note_lent_cell(receiver, value);
                }
                Value { is_owned: false, ..value.clone() }
            }
            "fill_with" if args.len() == 1 => self.fill_with(receiver, args[0], value, span),
            _ if super::exchanges::reorders(method, args.len())
                && self.may_hold_filter(self.ty(receiver))
                && self.reordered(id, receiver, method, args, value) =>
            {
                Value::default()
            }
            "clone" if super::flags::leads_to_cell(self.ty(receiver)) => {
                self.note_lent_cell(receiver, value);
                value.clone()
            }
            "clone" | "to_vec" if self.is_cloned_state(self.ty(id)) => self.copy_of(value, self.ty(id).clone(), span),
            name if super::threads::is_spawn(name) => {
                let is_given = name == "spawn_scoped";
                let scope = args.first().copied().filter(|_| is_given).or((!is_given).then_some(receiver));
                self.spawn(id, name, scope, args)
            }
            _ => return None,
        })
    }

    /// Whether a clone is another name of what is there. What a guard of a cell is cloned by is what it opens: a guard has no clones.
    fn clones_name(&self, receiver: ExprId) -> bool {
        let index = self.program.index;
        let ty = match self.ty(receiver).peel() {
            Ty::External(path, args) if path.ends_with("::LockResult") => args.first().map_or(&Ty::Unknown, Ty::peel),
            ty => ty,
        };
        ty.is_shared_pointer() || index.is_handle(ty) || index.refers_to_filters(ty)
    }

    /// Whether a clone of the type is another filter, or has the state of one.
    fn is_cloned_state(&self, ty: &Ty) -> bool {
        let index = self.program.index;
        index.holds_filter(ty) && !matches!(ty, Ty::Ref(..)) || index.returned_spec(ty).is_some()
    }

    fn certain_key(&self, key: &IndexKey) -> IndexKey {
        match key {
            IndexKey::Var(var) => {
                let is_param = self.graph.var(*var).param.is_some() && !self.is_assigned(*var);
                if self.is_counter(*var) || is_param {
                    key.clone()
                } else {
                    IndexKey::Data(self.graph.var(*var).name.clone().into())
                }
            }
            other => other.clone(),
        }
    }

    pub(super) fn is_optional(&self, id: ExprId) -> bool {
        matches!(self.ty(id).peel().external_name(), Some("Option" | "Result" | "LockResult" | "Poll"))
    }

    pub(super) fn is_cell(&self, id: ExprId) -> bool {
        matches!(self.ty(id).peel().external_name(), Some("Cell" | "RefCell"))
            || matches!(self.ty(id).peel(), Ty::External(path, args)
                if path.ends_with("::LockResult") && args.first().and_then(|inner| inner.peel().external_name()) == Some("Cell"))
    }

    /// `option.map(|x| …)`: the closure runs where the value is there.
    fn map_payload(&mut self, id: ExprId, receiver: ExprId, method: &str, args: &[ExprId], value: &Value) -> Value {
        let span = self.span(id);
        let values: Vec<Value> = args.iter().map(|arg| self.expr(*arg)).collect();
        let closures: Vec<_> = values.iter().filter_map(|value| value.closure).collect();
        let Some(closure) = closures.last().copied() else { return Value::default() };
        if self.at.is_none() {
            return Value::default();
        }
        self.derive_payload(closure, receiver);
        let payload = Value { head: None, same_as: None, ..value.clone() };
        let on_payload = |this: &mut Self| {
            let result = this.inline_closure(closure, std::slice::from_ref(&payload), span);
            match method {
                // The closure says what there is.
                "and_then" | "map_or" | "map_or_else" | "is_some_and" | "is_ok_and" | "is_none_or" => result,
                _ => Value { head: Some("+".to_owned()), same_as: None, ..result },
            }
        };
        if value.head.as_deref() == Some("+") {
            return on_payload(self);
        }
        let (present, absent) = self.branch_on_payload(receiver, closure, value, span);
        let join = self.new_join(self.ty(id).clone(), span);
        self.resume(present);
        let result = on_payload(self);
        self.end_branch(&join, &result, span);
        self.resume(absent);
        let head = |head: &str| Value { head: Some(head.to_owned()), ..Value::default() };
        let instead = match (method, closures.as_slice()) {
            ("map_or", _) => values.into_iter().next().unwrap_or_default(),
            ("map_or_else", [first, _]) => self.inline_closure(*first, &[Value::default()], span),
            ("is_some_and" | "is_ok_and", _) => head("false"),
            ("is_none_or", _) => head("true"),
            _ => head("-"),
        };
        self.end_branch(&join, &instead, span);
        self.close_join(&join)
    }

    /// Asks whether an option or result holds the value that a closure then gets.
    pub(super) fn branch_on_payload(
        &mut self,
        receiver: ExprId,
        closure: ClosureRef,
        value: &Value,
        span: Span,
    ) -> (NodeId, NodeId) {
        let binds = self.closure_vars(closure);
        let about = self.about_presence(receiver, binds);
        match self.pure_option(receiver) {
            Some(pure) => {
                let subject = self.subject(pure, Some(vec!["+".to_owned(), "-".to_owned()]));
                self.head_bit(subject, "+");
                self.head_bit(subject, "-");
                self.branch_on_subject(subject, &["+".to_owned()], true, span, self.presence_text(receiver), about)
            }
            None => self.branch_on_head(value, "+", "-", span, self.presence_text(receiver), about),
        }
    }
}
