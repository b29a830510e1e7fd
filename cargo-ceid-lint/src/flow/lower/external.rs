//! Calls of functions outside the analysed code that are known: what they do to the places they get.

use super::calls::path_tail;
use super::laws::Law;
use super::parts::given_to;
use super::threads::{is_spawn, is_thread_scope};
use super::{Builder, Value};
use crate::flow::{Assignment, Cause, Effect, Place, Rounds, Transfer};
use crate::index::{Def, Shape, Ty};
use crate::syntax::tree::{ExprId, ExprKind, StmtKind};
use crate::types::LocalId;

impl Builder<'_> {
    pub(super) fn external_call(&mut self, id: ExprId, path: &str, args: &[ExprId]) -> Value {
        let last = path.rsplit("::").next().unwrap_or("");
        let span = self.span(id);
        self.note_function_wait(id, path, args);
        if self.never_returns(id) {
            self.values(args);
            self.diverge(span);
            return Value::default();
        }
        if let Some(function) = path.strip_prefix(crate::types::ADAPTED).and_then(|rest| rest.strip_prefix("::")) {
            return self.adapt(id, function, args);
        }
        if path == "std::clone::Clone::clone"
            && let [cloned] = args
        {
            self.note_clone(id, *cloned, "clone", &[]);
        }
        match path {
            "std::mem::swap" => return self.swap(id, args),
            "std::mem::replace" | "std::mem::take" => return self.replace(id, args),
            // A collection whose only element is what is lent.
            "std::slice::from_mut" => return self.array_value(id, args),
            "std::mem::drop" => {
                if let Some(arg) = args.first() {
                    let value = self.expr(*arg);
                    self.drop_value(id, *arg, &value, "`drop` ends it here");
                }
                return Value::default();
            }
            "std::mem::ManuallyDrop::drop" => {
                for (arg, value) in args.iter().zip(self.values(args)) {
                    self.drop_by_hand(*arg, &value, span);
                }
                return Value::default();
            }
            "std::mem::forget" => {
                if let Some(arg) = args.first() {
                    let value = self.expr(*arg);
                    self.forget_value(*arg, &value, span, "`mem::forget`");
                }
                return Value::default();
            }
            _ => {}
        }
        let def = Def::External(path.to_owned());
        if let Some(spec) = self.program.index.function_spec(&def) {
            let (values, group) = (self.values(args), self.program.index.group_of(spec, &def));
            return self.law_call(id, Law { spec, group, targets: &[], has_receiver: false }, args, &values);
        }
        if self.reset_outside(path, args, span) {
            return Value::default();
        }
        if is_spawn(last) {
            return self.spawn(id, path, None, args);
        }
        if matches!(path_tail(path).as_str(), "rayon::join" | "rayon_core::join") {
            for closure in self.values(args).into_iter().filter_map(|value| value.closure) {
                self.run_beside(closure, span);
            }
            return Value::default();
        }
        if is_thread_scope(last)
            || matches!(last, "with" | "free" | "without_interrupts" | "interrupt_free" | "catch_unwind" | "block_on")
            || matches!(last, "block_in_place" | "assert_no_alloc" | "permit_alloc")
        {
            let values = self.values(args);
            if let Some(closure) = values.iter().rev().find_map(|value| value.closure) {
                return match last {
                    name if is_thread_scope(name) => self.thread_scope(closure, span),
                    "catch_unwind" => {
                        let run = |this: &mut Self| this.inline_closure(closure, &[Value::default()], span);
                        let value = match self.is_raised_again(id) {
                            true => run(self),
                            false => self.swallow_panics(closure, span, run),
                        };
                        self.in_a_result(value)
                    }
                    _ => self.inline_closure(closure, &[Value::default()], span),
                };
            }
            let value = values.into_iter().next().unwrap_or_default();
            return if last == "block_on" { self.run_to_end(value, span) } else { value };
        }
        if path == "std::array::from_fn" {
            let values = self.values(args);
            if let Some(closure) = values.first().and_then(|value| value.closure) {
                let rounds = match self.ty(id) {
                    Ty::Array(_, length) => length.value.map_or(Rounds::Bounded, Rounds::Constant),
                    _ => Rounds::Bounded,
                };
                let item = super::sources::Item::Counter(Some(0));
                let source = super::sources::Source { item, rounds, ..super::sources::Source::bounded() };
                self.closure_loop(closure, source, span);
            }
            return Value::default();
        }
        if matches!(
            path,
            "std::iter::once"
                | "std::iter::zip"
                | "std::iter::from_fn"
                | "std::iter::repeat_with"
                | "std::iter::successors"
        ) || (matches!(path, "std::iter::repeat" | "std::iter::repeat_n")
            && args.first().is_some_and(|repeated| self.program.index.may_share_filter(self.ty(*repeated))))
        {
            let source = self.source(id);
            return self.iterator_value(source);
        }
        let values = self.values(args);
        if matches!(path, "std::iter::repeat" | "std::iter::repeat_n")
            && let ([repeated, ..], [arg, ..]) = (values.as_slice(), args)
        {
            self.hand_clones(repeated, *arg);
        }
        if let ("from" | "from_iter", [given]) = (last, values.as_slice())
            && let Some(found) = self.converted_references(id, given)
        {
            return found;
        }
        if last == "from_iter"
            && let Some(source) = values.first().and_then(|value| value.iterator.clone())
        {
            self.gather(id, &source);
            return Value::default();
        }
        let owner = path.rsplit("::").nth(1).unwrap_or("");
        let wraps = crate::types::is_transparent(owner)
            && matches!(
                last,
                "new"
                    | "pin"
                    | "from"
                    | "clone"
                    | "const_new"
                    | "new_unchecked"
                    | "init"
                    | "as_mut"
                    | "get_mut"
                    | "make_mut"
                    | "downgrade"
            )
            || path == "std::cell::Cell::from_mut";
        if wraps
            || matches!(
                path,
                "std::hint::black_box"
                    | "std::convert::identity"
                    | "std::borrow::BorrowMut::borrow_mut"
                    | "std::panic::AssertUnwindSafe"
            )
        {
            let value = values.into_iter().next_back().unwrap_or_default();
            if matches!(owner, "ManuallyDrop" | "MaybeUninit")
                && let Some(arg) = args.last()
            {
                self.forget_value(*arg, &value, span, &format!("`{owner}`"));
            }
            // What a box or cell is made of is a copy of what is still there.
            let is_copy = args.last().is_some_and(|arg| self.program.index.copies_filter(self.ty(*arg)));
            let leaves_by = value.leaves_by.or(is_copy.then_some(Transfer::Copy));
            return Value { leaves_by, ..value };
        }
        if let Some(how) = never_drops(path) {
            let value = values.into_iter().next().unwrap_or_default();
            if let Some(arg) = args.first() {
                self.forget_value(*arg, &value, span, how);
            }
            return value;
        }
        // What is written through a pointer may be another state.
        let is_raw = path.starts_with("std::ptr::") || path.starts_with("core::ptr::");
        if path.starts_with("std::") && !is_raw && values.iter().all(|value| value.closure.is_none()) {
            for (arg, value) in args.iter().zip(&values) {
                self.keep_iterator(value, &Cause::Call(path_tail(path)), span);
                self.give_away(id, &[], &[*arg], std::slice::from_ref(value));
                // `Vec::push(&mut queue, sample)`
                if matches!(self.ty(*arg), Ty::Ref(true, _)) {
                    self.note_lent(*arg);
                }
            }
            if *self.ty(id) == Ty::Unknown && !tells_of_handle(last) {
                self.may_lend(path, args, &values, span);
            }
            return Value::default();
        }
        if matches!(self.ty(id), Ty::Pointer(_)) || path.starts_with("std::ptr::NonNull::") {
            args.iter().zip(&values).for_each(|(arg, value)| self.keep_pointed(*arg, value));
        }
        self.unknown_call(id, path_tail(path), args, &values)
    }

    /// What a function of the standard library gives back may be a way to write what it was lent.
    fn may_lend(&mut self, path: &str, args: &[ExprId], values: &[Value], span: crate::source::Span) {
        let is_writable = |ty: &Ty| matches!(ty, Ty::Ref(true, _)) || crate::types::is_lock(ty);
        let lent = args.iter().zip(values).filter(|(arg, _)| {
            let ty = self.ty(**arg);
            is_writable(ty) && self.may_hold_filter(ty)
        });
        let places: Vec<Place> = lent.filter_map(|(_, value)| value.place.clone()).collect();
        if !places.is_empty() {
            self.emit(Effect::Unknown { places, cause: Cause::Call(path_tail(path)) }, span);
        }
    }

    /// What is known of a result that holds a value: the filter that it is, but not its head.
    fn in_a_result(&self, value: Value) -> Value {
        let base = value.place.as_ref().and_then(Place::base_var);
        let is_filter = base.is_some_and(|var| self.program.index.holds_filter(&self.graph.var(var).ty));
        if is_filter { Value { head: None, same_as: None, ..value } } else { Value::default() }
    }

    /// `Mutex::lock(&lpf)` is `lpf.lock()`.
    pub(super) fn path_method(&mut self, id: ExprId, callee: ExprId, args: &[ExprId]) -> Value {
        match self.called_by_path(callee, args) {
            Some((receiver, method)) => self.method_expr(id, receiver, &method, &args[1..]),
            None => Value::default(),
        }
    }

    /// The receiver of such a call, and the method.
    pub(super) fn called_by_path(&self, callee: ExprId, args: &[ExprId]) -> Option<(ExprId, String)> {
        let body = self.body();
        let (ExprKind::Path(path), Some(first)) = (&body.expr(callee).kind, args.first()) else { return None };
        let receiver = match &body.expr(*first).kind {
            ExprKind::Reference { value, .. } => *value,
            _ => *first,
        };
        Some((receiver, path.last().to_owned()))
    }

    /// `mem::replace(&mut a, new)`, `mem::take(&mut a)`: a new value.
    fn replace(&mut self, id: ExprId, args: &[ExprId]) -> Value {
        let values = self.values(args);
        let Some((content, new)) = values.split_first() else { return Value::default() };
        if content.place.is_some() && self.option_taken(id).is_some() {
            return self.taken_out(id, content);
        }
        self.replace_by(id, content, args.get(1).copied(), new.first())
    }

    /// `cell.replace(new)`
    pub(super) fn replace_content(&mut self, id: ExprId, content: &Value, args: &[ExprId]) -> Value {
        let mut values = self.values(args);
        if matches!(&self.body().expr(id).kind, ExprKind::MethodCall { receiver, .. } if self.is_optional(*receiver)) {
            values.iter_mut().for_each(|value| value.head = Some("+".to_owned()));
        }
        self.replace_by(id, content, args.first().copied(), values.first())
    }

    fn replace_by(&mut self, id: ExprId, content: &Value, given: Option<ExprId>, new: Option<&Value>) -> Value {
        let span = self.span(id);
        let Some(place) = content.place.clone() else { return Value::default() };
        if new.is_none() && self.is_option_of_references(self.ty(id)) {
            return self.taken_out(id, content);
        }
        if let (Some(given), Some(new)) = (given, new) {
            self.put_away(id, &place, &[given], std::slice::from_ref(new));
        }
        if let Some(new) = new.and_then(|new| new.place.clone()).filter(|new| self.is_older_filter(id, new)) {
            return self.put_in_place(id, &place, new);
        }
        // What was there has another name now, and may come back; the place holds a new instance.
        let taken = self.temporary(self.ty(id).clone(), span);
        let is_truth = *self.ty(id) == Ty::Bool;
        let is_state = self.is_state(self.ty(id)) && !self.may_hold_filter(self.ty(id));
        let same_as = content.same_as.filter(|_| is_truth);
        // What is put back where it was is the same instance all the time.
        let mut is_put_back = self.is_put_back(id, &place);
        if is_put_back && self.has_several_homes(self.ty(id)) {
            // It may come back as another variant, and a filter of one may be that of another from then on.
            let cause = Cause::Code("a state that is taken out and put back".to_owned());
            self.emit(Effect::Unknown { places: vec![place.clone()], cause }, span);
            is_put_back = false;
        }
        let leaves_by = is_put_back.then_some(Transfer::Move);
        let old = Value { place: Some(place.clone()), same_as, is_owned: is_put_back, leaves_by, ..Value::default() };
        self.set(taken, &old, span);
        self.note_taken(taken, &old);
        let is_option = self.is_option_of_references(self.ty(id));
        let taken_out = Value { head: is_truth.then(|| "false".to_owned()), ..Value::default() };
        let new = new.cloned().unwrap_or(taken_out);
        if let Some(given) = given {
            self.take_over_in(self.ty(given).peel(), &place, &new, given);
        }
        let writes = Assignment {
            place: place.clone(),
            from: new.place,
            transfer: Transfer::Move,
            rebinds: false,
            head: new.head,
            same_as: new.same_as.filter(|_| is_state),
        };
        self.emit(Effect::Write(Box::new(writes)), span);
        self.note_pointed(self.ty(id));
        if let Some(given) = given {
            self.note_given(&place, given);
        }
        let same_as = (is_state || is_put_back || is_option).then_some(taken);
        Value { place: Some(Place::var(taken)), is_owned: true, same_as, ..Value::default() }
    }

    /// Whether a filter is moved out of a variable from before the innermost loop, so that it is none that the iteration makes.
    fn is_older_filter(&self, id: ExprId, place: &Place) -> bool {
        let ty = self.ty(id);
        let is_moved = self.may_hold_filter(ty)
            && !matches!(ty, Ty::Ref(..))
            && !self.is_option_of_references(ty)
            && !self.program.index.copies_filter(ty);
        is_moved && self.is_older(place)
    }

    /// Whether a place is a variable from before the innermost loop.
    pub(super) fn is_older(&self, place: &Place) -> bool {
        let info = place.base_var().map(|var| self.graph.var(var)).filter(|_| place.steps.is_empty());
        info.is_some_and(|info| !info.name.is_empty() && info.in_loop != self.loops.last().copied())
    }

    /// `let old = mem::replace(&mut a, b);`: both filters have another name from here on.
    fn put_in_place(&mut self, id: ExprId, place: &Place, new: Place) -> Value {
        let span = self.span(id);
        let taken = Place::var(self.temporary(self.ty(id).clone(), span));
        for (to, from) in [(&taken, place.clone()), (place, new)] {
            let assignment = Assignment { from: Some(from), ..given_to(to.clone(), None) };
            self.emit(Effect::Set(Box::new(assignment)), span);
        }
        Value { place: Some(taken), is_owned: true, ..Value::default() }
    }

    /// Whether several variants of an enum hold filters.
    fn has_several_homes(&self, ty: &Ty) -> bool {
        let Ty::Adt(id, _) = ty else { return false };
        let Shape::Enum(variants) = &self.program.index.type_def(*id).shape else { return false };
        let holds = |number: &usize| {
            let fields = variants[*number].fields.fields.iter();
            fields
                .filter_map(|field| self.program.index.field_ty(ty, Some(*number), &field.name))
                .any(|ty| self.may_hold_filter(&ty))
        };
        (0..variants.len()).filter(holds).count() > 1
    }

    /// Whether what is taken out of a place by a call is given to that place again, by itself or under the names that it gets.
    fn is_put_back(&mut self, taken: ExprId, place: &Place) -> bool {
        let (body, typed) = (self.body(), self.typed());
        let lets = body.stmts().filter_map(|stmt| match &stmt.kind {
            StmtKind::Let { pat, init, .. } if *init == Some(taken) => Some(vec![*pat]),
            _ => None,
        });
        let matches = body.exprs.iter().filter_map(|expr| match &expr.kind {
            ExprKind::Let { pat, value } if *value == taken => Some(vec![*pat]),
            ExprKind::Match { scrutinee, arms } if *scrutinee == taken => {
                Some(arms.iter().map(|arm| arm.pat).collect())
            }
            _ => None,
        });
        let mut names: Vec<LocalId> = lets.chain(matches).flatten().flat_map(|pat| self.locals_of(pat)).collect();
        let comes_from = |value: ExprId, names: &[LocalId]| {
            let span = body.expr(value).span;
            let is_named = || {
                let mut named = typed.expr_local.iter().filter(|(_, local)| names.contains(local));
                named.any(|(expr, _)| span.contains(body.expr(*expr).span))
            };
            span.contains(body.expr(taken).span) || is_named()
        };
        // Where it goes from there as a whole: `let filter = fed(taken, sample);`, and not `Filter { gain: taken.gain, state: 0.0 }`.
        let ty = self.ty(taken).peel();
        let is_split = |named: ExprId| {
            body.exprs.iter().zip((0u32..).map(ExprId)).any(|(expr, id)| match &expr.kind {
                ExprKind::Field { base, .. } => *base == named,
                ExprKind::MethodCall { receiver, .. } => *receiver == named && self.ty(id).peel() != ty,
                _ => false,
            })
        };
        let is_whole = |value: ExprId, names: &[LocalId]| {
            let mut named = typed.expr_local.iter().filter(|(_, local)| names.contains(local)).map(|(expr, _)| *expr);
            named.any(|named| body.expr(value).span.contains(body.expr(named).span) && !is_split(named))
        };
        for stmt in body.stmts() {
            if let StmtKind::Let { pat, init: Some(init), .. } = &stmt.kind
                && self.ty(*init).peel() == ty
                && is_whole(*init, &names)
            {
                names.extend(self.locals_of(*pat));
            }
        }
        let given = body.exprs.iter().filter_map(|expr| match &expr.kind {
            ExprKind::Assign { place, value } if comes_from(*value, &names) => Some(*place),
            _ => None,
        });
        given.collect::<Vec<ExprId>>().into_iter().any(|target| self.static_place(target).as_ref() == Some(place))
    }
}

/// Whether a function tells something of a handle or of memory, and nothing of what is there.
fn tells_of_handle(function: &str) -> bool {
    matches!(function, "strong_count" | "weak_count" | "ptr_eq" | "size_of_val" | "align_of_val" | "type_name_of_val")
}

/// What takes a value out of the hands of its destructor, as messages name it.
fn never_drops(path: &str) -> Option<&'static str> {
    Some(match path {
        "std::boxed::Box::leak" => "`Box::leak`",
        "std::boxed::Box::into_raw" => "`Box::into_raw`",
        "std::rc::Rc::into_raw" => "`Rc::into_raw`",
        "std::sync::Arc::into_raw" => "`Arc::into_raw`",
        _ => return None,
    })
}
