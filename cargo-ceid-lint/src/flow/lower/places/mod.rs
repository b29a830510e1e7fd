//! Expressions that are places: variables, fields, elements, through references, pointers, options and locks.

mod indexed;
mod lent;

use super::{Builder, Value};
use crate::flow::{Effect, IndexKey, Place, Section, Transfer, Var};
use crate::index::{Def, Ty, TypeId};
use crate::syntax::tree::{ExprId, ExprKind, Literal, Path};

impl Builder<'_> {
    /// The place of an expression that has no effects of its own; emits nothing.
    pub(super) fn static_place(&mut self, id: ExprId) -> Option<Place> {
        let body = self.body();
        match &body.expr(id).kind {
            ExprKind::Path(_) => self.path_place(id),
            ExprKind::Field { base, name } => {
                let place = self.static_place(*base)?;
                Some(self.field_place(*base, &place, name))
            }
            ExprKind::Index { base, index } => {
                let place = self.static_place(*base)?;
                let place = self.indexed_place(id, place)?;
                let key = self.index_key(*index)?;
                Some(place.element(key))
            }
            ExprKind::Deref(inner) | ExprKind::Reference { value: inner, .. } => self.static_place(*inner),
            _ => None,
        }
    }

    pub(super) fn path_place(&mut self, id: ExprId) -> Option<Place> {
        if let Some(place) = self.stand_in(id) {
            return Some(place);
        }
        if let Some(local) = self.typed().expr_local.get(&id).copied() {
            return Some(Place::var(self.var_of(local)));
        }
        match self.typed().expr_def.get(&id) {
            Some(Def::Value(value)) => {
                let named = super::constants::referred(self.program, *value);
                self.program.index.value(named).item.is_static.then(|| Place::of_static(named))
            }
            _ => None,
        }
    }

    /// Which element an index names; `None` for a range, which names the whole.
    pub(super) fn index_key(&mut self, id: ExprId) -> Option<IndexKey> {
        let body = self.body();
        match &body.expr(id).kind {
            ExprKind::Literal(Literal::Int(Some(value), _)) => Some(IndexKey::Number(*value)),
            ExprKind::Range { .. } => None,
            // A variant and its number name the same element.
            ExprKind::Cast { value, .. } | ExprKind::Reference { value, .. } | ExprKind::Deref(value) => {
                self.index_key(*value)
            }
            ExprKind::Path(path) => Some(self.index_path(id, path)),
            ExprKind::Binary { op: "-", rhs, .. } if self.is_mirrored(*rhs) => self.index_key(*rhs),
            // `bank[N + 1]`
            ExprKind::Binary { .. } if let Some(number) = self.number(id) => Some(IndexKey::Number(number)),
            _ => Some(IndexKey::Data(self.text(id).into())),
        }
    }

    /// Whether an expression is a counter of which only the distance from its last number counts.
    fn is_mirrored(&self, id: ExprId) -> bool {
        let local = self.typed().expr_local.get(&id);
        let var = local.and_then(|local| self.frames[self.frame].vars.get(local));
        let own = self.graph.loops.iter().filter(|info| info.is_mirrored);
        own.filter_map(|info| info.counter).any(|(counter, _)| Some(&counter) == var)
    }

    fn variant_key(&self, ty: TypeId, at: usize) -> IndexKey {
        let variant = super::constants::variant_head(self.program, ty, at);
        IndexKey::Named(format!("{}::{variant}", self.program.index.type_def(ty).name).into())
    }

    /// The key of an entry of a map, if no data decides which one it is: what is written there, or a parameter as it was given.
    pub(super) fn map_key(&mut self, id: ExprId) -> Option<IndexKey> {
        let body = self.body();
        match &body.expr(id).kind {
            ExprKind::Reference { value, .. } => self.map_key(*value),
            ExprKind::Literal(literal) => IndexKey::of_head(&literal.spelling()),
            _ => self.index_key(id).filter(|key| match key {
                IndexKey::Var(var) => self.graph.var(*var).param.is_some() && !self.is_assigned(*var),
                key => matches!(key, IndexKey::Number(_) | IndexKey::Named(_)),
            }),
        }
    }

    /// The key of the entry that a method of a map gets.
    pub(super) fn entry_key(&mut self, args: &[ExprId]) -> IndexKey {
        let key = args.first().and_then(|arg| self.map_key(*arg));
        key.unwrap_or_else(|| IndexKey::Data(args.first().map_or_else(String::new, |arg| self.text(*arg)).into()))
    }

    fn index_path(&mut self, id: ExprId, path: &Path) -> IndexKey {
        if let Some(local) = self.typed().expr_local.get(&id).copied() {
            let var = self.var_of(local);
            if let Some(number) = self.numbers.get(&var) {
                return IndexKey::Number(*number);
            }
            return IndexKey::Var(self.number_behind(var));
        }
        match self.typed().expr_def.get(&id) {
            Some(Def::Value(value)) if !self.program.index.value(*value).item.is_static => {
                let number = self.program.index.const_number(*value);
                let variant = || {
                    let (ty, at) = super::constants::variant_of(self.program, *value, 0)?;
                    Some(self.variant_key(ty, at))
                };
                number.map(IndexKey::Number).or_else(variant).unwrap_or_else(|| IndexKey::Named(path.text().into()))
            }
            // Under whatever name it is imported.
            Some(Def::Variant(ty, at)) => self.variant_key(*ty, *at),
            _ if path.segments.first().is_some_and(|first| first.name == "Self") => {
                let names: Vec<String> = path.segments.iter().map(|segment| segment.name.clone()).collect();
                let scope = self.program.index.scope_of(self.frames[self.frame].function);
                match self.program.index.const_value(&scope, &names) {
                    Some(number) => IndexKey::Number(number),
                    None => IndexKey::Named(path.text().into()),
                }
            }
            _ => IndexKey::Data(self.text(id).into()),
        }
    }

    /// `base[index]`, with the effects of both.
    pub(super) fn index_expr(&mut self, id: ExprId, base: ExprId, index: ExprId) -> Value {
        let value = self.expr(base);
        let index_value = self.expr(index);
        self.note_sample_read(id, base, index);
        let of_variant = self.cast_variant(index);
        let value = match self.indexed(id, base, index, value, &index_value) {
            Ok(given) => return given,
            Err(collection) => collection,
        };
        let Some(place) = value.place else { return Value::default() };
        let is_map = self.ty(base).peel().external_name().is_some_and(|name| name.ends_with("Map"));
        let key = match &self.body().expr(index).kind {
            _ if is_map => Some(IndexKey::Data(self.text(index).into())),
            ExprKind::Range { start, end, inclusive } => self.section(index, *start, *end, *inclusive),
            _ => self.index_key(index),
        };
        let place = match key {
            None => place,
            Some(key) => {
                let key = self.settle_key(key, of_variant.as_ref().or(index_value.place.as_ref()));
                let key = self.by_outer_counter(key, id);
                self.note_indexing(&key, &place);
                place.element(key)
            }
        };
        Value { place: Some(place), is_owned: true, ..Value::default() }
    }

    /// The slice that a range selects; `None` if it is the whole, or begins with its first element and is cut somewhere.
    fn section(&mut self, id: ExprId, start: Option<ExprId>, end: Option<ExprId>, inclusive: bool) -> Option<IndexKey> {
        let from = start.map_or(Some(0), |start| self.number(start));
        let to = end.map(|end| self.number(end));
        match (from, to) {
            (Some(0), None | Some(None)) => None,
            (Some(from), None | Some(Some(_))) => {
                let to = to.flatten().map(|to| to + u64::from(inclusive));
                Some(IndexKey::Slice(Section::known(from, to, &self.text(id))))
            }
            _ => Some(IndexKey::Slice(Section::unknown(&self.text(id)))),
        }
    }

    /// The variable whose variant gives an index its number: `axis as usize`.
    fn cast_variant(&mut self, index: ExprId) -> Option<Place> {
        let ExprKind::Cast { value, .. } = self.body().expr(index).kind else { return None };
        if matches!(self.ty(value), Ty::Adt(..)) { self.static_place(value) } else { None }
    }

    /// A variable names an element for certain if it counts a loop or is a parameter; otherwise it depends on data.
    fn settle_key(&self, key: IndexKey, value: Option<&Place>) -> IndexKey {
        match key {
            IndexKey::Var(var) => {
                // A parameter that is given another number names another element then.
                let is_param = self.graph.var(var).param.is_some() && !self.is_assigned(var);
                // A parameter of an inlined function or closure is what was passed for it.
                let is_bound = value.and_then(Place::base_var).is_some_and(|own| self.number_behind(own) == var);
                if self.is_counter(var) || (is_param && is_bound) {
                    key
                } else {
                    IndexKey::Data(self.graph.var(var).name.clone().into())
                }
            }
            other => other,
        }
    }

    pub(super) fn is_counter(&self, var: Var) -> bool {
        self.graph.loops.iter().any(|info| info.counter.is_some_and(|(counter, _)| counter == var))
    }

    /// Whether the local that a variable stands for is assigned or borrowed mutably somewhere, in whatever body it lies.
    pub(super) fn is_assigned(&self, var: Var) -> bool {
        let is_assigned = |frame: &super::Frame<'_>| {
            frame.vars.iter().any(|(local, own)| *own == var && frame.mutated.contains(local))
        };
        self.frames.iter().any(is_assigned)
    }

    /// The parameter or counter that a variable is another name of, or itself.
    pub(super) fn number_behind(&self, var: Var) -> Var {
        self.copies.get(&var).copied().unwrap_or(var)
    }

    /// Notes that a variable is another name of a parameter or counter.
    pub(super) fn note_copy_of_number(&mut self, var: Var, value: &Value) {
        self.copies.remove(&var);
        let from = value.place.as_ref().filter(|place| place.steps.is_empty()).and_then(Place::base_var);
        let Some(from) = from.map(|from| self.number_behind(from)) else { return };
        let is_named = [var, from].iter().all(|var| !self.graph.var(*var).name.is_empty());
        // A number in an option is no other name of it.
        let is_number = [var, from].iter().all(|var| self.graph.var(*var).ty.peel() == &Ty::Int);
        let lasts = is_number && (self.graph.var(from).param.is_some() || self.is_counter(from));
        if is_named && lasts && !self.is_assigned(var) && !self.is_assigned(from) {
            self.copies.insert(var, from);
        }
    }

    /// Notes that an open loop's counter is an index of the collection.
    pub(super) fn note_indexing(&mut self, key: &IndexKey, collection: &Place) {
        let IndexKey::Var(var) = key else { return };
        for info in &mut self.graph.loops {
            if info.counter.is_some_and(|(counter, _)| counter == *var) && !info.indexes.contains(collection) {
                info.indexes.push(collection.clone());
            }
        }
    }

    /// The variables that an assignment changes: a local, what it refers to, or its elements; not a field's owner.
    pub(super) fn assigned_vars(&mut self, target: ExprId) -> Vec<Var> {
        let body = self.body();
        let mut at = target;
        loop {
            match &body.expr(at).kind {
                ExprKind::Deref(inner) | ExprKind::Index { base: inner, .. } => at = *inner,
                ExprKind::Path(_) => break,
                ExprKind::Tuple(_) | ExprKind::Struct { .. } => {
                    let places = body.assigned_places(at);
                    return places.into_iter().flat_map(|place| self.assigned_vars(place)).collect();
                }
                _ => return Vec::new(),
            }
        }
        match self.typed().expr_local.get(&at).copied() {
            Some(local) => vec![self.var_of(local)],
            None => Vec::new(),
        }
    }

    /// Notes that a value of the iteration is computed from what one of its fields is given: `frame.left = filter.update(x)`. What
    /// lives longer keeps what its other fields had, and may hold filters.
    pub(super) fn derive_owner(&mut self, target: ExprId, value: ExprId) {
        let body = self.body();
        let ExprKind::Field { base, .. } = &body.expr(target).kind else { return };
        let Some(local) = self.typed().expr_local.get(base).copied() else { return };
        let owner = self.var_of(local);
        let info = self.graph.var(owner);
        if info.in_loop.is_some() && matches!(info.ty, Ty::Adt(..)) && !self.may_hold_filter(&info.ty.clone()) {
            let reads = self.reads_of(value);
            self.graph.derived.extend(reads.into_iter().map(|read| (owner, read)));
        }
    }

    /// `place = value` and destructuring assignments.
    pub(super) fn assign(&mut self, id: ExprId, target: ExprId, value: ExprId) -> Value {
        if self.swap_by_tuples(id, target, value)
            || self.bits_reassigned(id, target, value)
            || self.assign_raised(id, target, value)
        {
            return Value::default();
        }
        // What is assigned part by part comes from its part alone.
        let is_by_parts = matches!(self.body().expr(value).kind, ExprKind::Tuple(_));
        let bases = if is_by_parts { Vec::new() } else { self.assigned_vars(target) };
        self.derive(&bases, value);
        self.derive_owner(target, value);
        let handed_back = self.handed_back(target, value);
        let outer = std::mem::replace(&mut self.handed_back, handed_back);
        let given = match self.own_rest(target, value) {
            // What it keeps of itself goes nowhere.
            Some(fields) => self.struct_value(value, fields, None),
            None => self.expr_into(bases, value),
        };
        // What comes back to its place is there.
        let is_back = std::mem::replace(&mut self.handed_back, outer).is_none() && handed_back.is_some();
        if self.at.is_none() || is_back {
            return Value::default();
        }
        let span = self.span(id);
        self.drop_overwritten(target, span);
        if self.keeps_state(target, value)
            && !self.is_copy(&given)
            && let Some(place) = self.static_place(target)
        {
            self.emit(Effect::Reset { place, full: false }, span);
            return Value::default();
        }
        let body = self.body();
        if let (ExprKind::Tuple(places), ExprKind::Tuple(parts)) = (&body.expr(target).kind, &body.expr(value).kind) {
            for (number, (place, own)) in places.iter().zip(parts).enumerate() {
                let part = given.place.as_ref().map(|place| place.field(&number.to_string()));
                let part = Value { place: part, is_owned: true, ..Value::default() };
                let bases = self.assigned_vars(*place);
                self.derive(&bases, *own);
                let before = self.at;
                self.assign_to(*place, &part, *own, span);
                if self.at != before {
                    self.note_change(*place, *own, None);
                }
            }
            return Value::default();
        }
        self.keep_assigned_pointer(target, value, &given);
        self.assign_to(target, &given, value, span);
        self.renew_states(target, value, span);
        self.note_change(target, value, None);
        if let Some(place) = self.static_place(target) {
            self.copy_parts(&given, &place, span);
        }
        self.note_sample_write(target, value);
        Value::default()
    }

    pub(super) fn assign_to(&mut self, target: ExprId, value: &Value, source: ExprId, span: crate::source::Span) {
        let body = self.body();
        if let ExprKind::Path(path) = &body.expr(target).kind
            && path.ident() == Some("_")
        {
            return;
        }
        match &body.expr(target).kind {
            ExprKind::Tuple(places) => {
                for (number, place) in places.iter().enumerate() {
                    let part = value.place.as_ref().map(|place| place.field(&number.to_string()));
                    let part = Value { place: part, is_owned: true, ..Value::default() };
                    self.assign_to(*place, &part, source, span);
                }
                return;
            }
            ExprKind::Struct { fields, .. } => {
                let is_variant = matches!(self.typed().expr_def.get(&target), Some(Def::Variant(..)));
                for (name, field) in fields {
                    let part = value.place.as_ref().filter(|_| !is_variant).map(|place| place.field(name));
                    let part = Value { place: part, is_owned: true, ..Value::default() };
                    self.assign_to(*field, &part, source, span);
                }
                return;
            }
            ExprKind::Array { elements: places, .. } | ExprKind::Call { args: places, .. } => {
                for place in places {
                    self.assign_to(*place, &Value::default(), source, span);
                }
                return;
            }
            _ => {}
        }
        let is_path = matches!(body.expr(target).kind, ExprKind::Path(_));
        let is_reference = matches!(self.ty(target), Ty::Ref(..));
        let mut is_next = false;
        if is_path && let Some(local) = self.typed().expr_local.get(&target).copied() {
            let var = self.var_of(local);
            if self.assign_guard(var, value, span) {
                return;
            }
            self.put_away(target, &Place::var(var), &[source], std::slice::from_ref(value));
            let head = value.head.clone();
            is_next = !is_reference && self.take_over(target, &Place::var(var), value, source);
            if is_reference || (!is_next && !self.may_hold_filter(self.ty(target))) {
                self.set(var, &Value { head, ..value.clone() }, span);
                return;
            }
        }
        let place = self.expr(target).place;
        self.keep_closure_in(place.as_ref().and_then(Place::base_var), value, span);
        self.lose_made(value);
        let Some(place) = place else { return };
        self.put_away(target, &place, &[source], std::slice::from_ref(value));
        if !is_next {
            self.take_over(target, &place, value, source);
        }
        if let Some(var) = place.base_var()
            && place.steps.is_empty()
        {
            self.numbers.remove(&var);
        }
        if value.head.is_some() && (self.is_state(self.ty(target)) || self.is_plain_option(self.ty(target))) {
            // A helper may ask for it.
            self.state_subject(super::subjects::pure_place(place.clone()), target);
        }
        let assignment = crate::flow::Assignment {
            place,
            from: value.place.clone(),
            transfer: self.transfer(value, self.ty(target)),
            rebinds: is_reference,
            head: value.head.clone(),
            same_as: value.same_as,
        };
        self.emit(Effect::Write(Box::new(assignment)), span);
        self.note_pointed(self.ty(target));
    }

    /// `place += value`
    pub(super) fn assign_op(&mut self, id: ExprId, op: &str, target: ExprId, value: ExprId) -> Value {
        if *self.ty(target).peel() == Ty::Bool {
            match (op, self.constant_head(value).as_deref()) {
                ("|", Some("true")) | ("&", Some("false")) => return self.assign(id, target, value),
                ("|", Some("false")) | ("&", Some("true")) => return Value::default(),
                ("^", Some("true")) => return self.assign_opposite(id, target, value),
                _ => {}
            }
            if matches!(op, "|" | "&") {
                return self.assign_if(id, op, target, value);
            }
        }
        if self.bits_assigned(id, op, target, value) {
            return Value::default();
        }
        let bases = self.assigned_vars(target);
        self.derive(&bases, value);
        self.derive_owner(target, value);
        let given = self.expr_into(bases, value);
        let span = self.span(id);
        let changed = self.expr(target);
        let operands = [changed.clone(), given.clone()];
        if self.operator_call(id, &format!("{op}="), &[target, value], &operands).is_some() {
            return Value::default();
        }
        self.lose_operands(id, &[value], &[given]);
        let place = changed.place;
        if let Some(place) = place
            && self.at.is_some()
        {
            if let Some(var) = place.base_var() {
                self.numbers.remove(&var);
            }
            let assignment = crate::flow::Assignment {
                place,
                from: None,
                transfer: Transfer::Move,
                rebinds: false,
                head: None,
                same_as: None,
            };
            self.emit(Effect::Write(Box::new(assignment)), span);
            self.note_change(target, value, Some(op));
        }
        Value::default()
    }

    /// Whether a value of the type may hold or refer to a filter.
    pub(super) fn may_hold_filter(&self, ty: &Ty) -> bool {
        self.holds(ty, 0)
    }

    fn holds(&self, ty: &Ty, depth: u32) -> bool {
        if depth > 6 {
            return true;
        }
        match ty {
            _ if self.program.index.may_be_state(ty) => true,
            Ty::Int | Ty::Float | Ty::Bool | Ty::Str | Ty::Char | Ty::Never | Ty::FunctionItem(_) => false,
            Ty::Ref(_, inner) | Ty::Pointer(inner) | Ty::Array(inner, _) | Ty::Slice(inner) => {
                self.holds(inner, depth + 1)
            }
            Ty::Tuple(parts) => parts.iter().any(|part| self.holds(part, depth + 1)),
            Ty::External(path, args) => match path.rsplit("::").next().unwrap_or("") {
                "String" | "Duration" | "Instant" | "Range" => false,
                _ => {
                    path.starts_with("?::")
                        || (self.program.index.has_states_apart() && !path.starts_with("std::"))
                        || args.iter().any(|arg| self.holds(arg, depth + 1))
                        || self.program.index.filter_spec(ty).is_some()
                }
            },
            // What a type parameter stands for may be a filter.
            Ty::Adt(_, args) => {
                let is_open = |arg: &Ty| arg.is_open() && self.holds(arg, depth + 1);
                self.program.index.holds_filter(ty) || args.iter().any(is_open)
            }
            Ty::Unknown | Ty::Var(_) | Ty::Param(_) | Ty::Opaque(_) | Ty::Function(..) | Ty::Closure(_) => true,
        }
    }
}
