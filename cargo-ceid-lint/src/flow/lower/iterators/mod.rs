//! Iterators: what a chain of adaptors runs over, and what it does when it is consumed.

mod arrays;
mod chains;

use super::carried::State;
use super::sources::{Item, Source, Stage, is_map, numbered_item};
use super::{Builder, ClosureRef, Value};
use crate::flow::{
    Cause, Computed, CycleKind, Effect, IndexKey, Limit, LoopId, LoopInfo, NodeId, Place, Rounds, Test, Transfer, Var,
};
use crate::index::{FunctionId, Ty};
use crate::source::Span;
use crate::syntax::tree::{ExprId, ExprKind, Literal, PatId, PatKind};
use crate::types::Callee;

/// What a consumer does with the items.
#[derive(Clone, Copy, Debug)]
struct Consumer {
    state: State,
    stops: Stops,
    /// It gives them back, or some of them.
    gathers: bool,
}

/// Whether a consumer may stop before the last item.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Stops {
    Never,
    Anywhere,
    /// This result of it is missing if it did.
    AndTells(Var),
}

/// A loop whose round begins.
#[derive(Clone, Copy, Debug)]
pub(super) struct Begun {
    pub(super) id: LoopId,
    pub(super) kind: CycleKind,
    pub(super) head: NodeId,
    /// The first node of the round.
    pub(super) round: NodeId,
    pub(super) keyword: Span,
    /// Whether the number of an item is that of its round.
    pub(super) counts_items: bool,
}

impl Builder<'_> {
    /// What a `for` loop or consumer runs over; evaluates what the chain begins with.
    pub(super) fn source(&mut self, id: ExprId) -> Source {
        self.source_of(id, false)
    }

    /// The same; a collection that is lent is not copied.
    fn source_of(&mut self, id: ExprId, is_lent: bool) -> Source {
        let body = self.body();
        let row = self.row_of_variants(id);
        let own = self.program.index.own_into_iter(self.ty(id));
        let mut source = match &body.expr(id).kind {
            _ if own.is_some() => self.own_collection(id, own),
            _ if row.is_some() => {
                let (first, count) = row.unwrap_or_default();
                Source { item: Item::Counter(Some(first)), rounds: Rounds::Constant(count), ..Source::bounded() }
            }
            ExprKind::MethodCall { receiver, method, args, .. } => self.adaptor(id, *receiver, method, args),
            ExprKind::Range { start, end, inclusive } => self.range(*start, *end, *inclusive),
            ExprKind::Reference { value, mutable, .. } => {
                let source = self.source_of(*value, true);
                if *mutable {
                    self.note_lent(*value);
                    self.note_advanced(*value);
                }
                source
            }
            // What is awaited of a lock is a guard, and no stream.
            ExprKind::Await(inner)
                if !self.is_deferred(*inner) && self.ty(*inner).external_name() != Some("LockResult") =>
            {
                let inner = self.source(*inner);
                Source { rounds: Rounds::Unbounded, ..inner }
            }
            ExprKind::Call { callee, args } => {
                // `Iterator::map(samples, scale)` is `samples.map(scale)`.
                let is_method = matches!(self.typed().callees.get(&id), Some(Callee::Builtin));
                match self.called_by_path(*callee, args).filter(|_| is_method) {
                    Some((receiver, method)) => self.adaptor(id, receiver, &method, &args[1..]),
                    None => self.generator(id, *callee, args),
                }
            }
            ExprKind::Array { elements, .. } => {
                let count = elements.len() as u64;
                let value = self.expr(id);
                let item = match value.place {
                    Some(place) if self.may_hold_filter(self.ty(id)) => Item::Element(place),
                    _ => self.first_of_row(elements).map_or(Item::Opaque, |first| Item::Counter(Some(first))),
                };
                Source { item, rounds: Rounds::Constant(count), ..Source::bounded() }
            }
            _ => self.collection(id, is_lent),
        };
        source.text = self.text(id);
        source.reads = self.reads_of(id);
        if matches!(source.item, Item::Opaque) {
            let mut computed = self.computed_from(id);
            // A table that is a constant.
            if computed.places.is_empty() && computed.calls.is_empty() {
                computed.calls.extend(self.constant_table(id));
            }
            source.item = Item::Drawn(source.reads.clone(), computed);
        }
        source
    }

    /// A value of a type of the analysed code that says itself what it is iterated over by.
    fn own_collection(&mut self, id: ExprId, into_iter: Option<FunctionId>) -> Source {
        let value = self.expr(id);
        let (Some(into_iter), Some(place)) = (into_iter.filter(|_| self.at.is_some()), value.place) else {
            return Source::bounded();
        };
        let index = self.program.index;
        let output = index.project(self.ty(id), "IntoIter");
        let text = format!("{}.into_iter()", self.text(id));
        let iterator = Place::var(self.run_on(into_iter, place, output.clone(), text, self.span(id)));
        let item = match &output {
            ty if self.draws_by_itself(ty) => {
                let cause = Cause::Call(self.text(id));
                self.emit(Effect::Unknown { places: vec![iterator.clone()], cause }, self.span(id));
                Item::Opaque
            }
            ty if self.may_hold_filter(ty) => Item::Element(iterator.clone()),
            _ => Item::Opaque,
        };
        Source { item, over: Some(iterator), ..Source::bounded() }
    }

    /// A place that is iterated over.
    fn collection(&mut self, id: ExprId, is_lent: bool) -> Source {
        let value = self.expr(id);
        if let Some(source) = &value.iterator {
            // What was made outside a loop is used up after the first of its rounds.
            let is_older = source.made_in != self.loops.last().copied();
            if source.is_choice || source.is_advanced || is_older {
                let which = match source.is_advanced {
                    _ if is_older => "is made outside the loop",
                    true => "has given some of its items",
                    false => "a condition chooses",
                };
                let cause = Cause::Code(format!("an iterator that {which}"));
                self.keep_iterator(&value, &cause, self.span(id));
                return Source::bounded();
            }
            return Source::clone(source);
        }
        let ty = self.ty(id).peel();
        let is_endless = is_endless_type(ty);
        let is_map = is_map(ty);
        let over = value.place.clone();
        let is_optional = matches!(ty.external_name(), Some("Option" | "Result"));
        let is_there = is_optional && value.head.as_deref() == Some("+");
        let item = match value.place.clone() {
            Some(place) if self.draws_by_itself(ty) => {
                let cause = Cause::Call(self.text(id));
                let node = self.emit(Effect::Unknown { places: vec![place.clone()], cause }, self.span(id));
                let is_moved = !matches!(self.ty(id), Ty::Ref(..));
                self.graph.given_away.extend(is_moved.then_some((node, place)));
                Item::Opaque
            }
            // The loop gets copies of them.
            Some(_) if !is_lent && self.program.index.copies_filter(self.ty(id)) => {
                let copies = self.copy_used(&value, self.ty(id).clone(), self.span(id));
                copies.place.map_or(Item::Made, Item::Element)
            }
            Some(place) if is_map && self.may_hold_filter(ty) => Item::entry(place),
            Some(place) if is_optional && self.may_hold_filter(ty) => Item::Present(Box::new(Item::Same(place))),
            Some(place) if self.may_hold_filter(ty) => Item::Element(place),
            _ if is_optional && !is_there => {
                Item::Present(Box::new(Item::Drawn(self.reads_of(id), self.computed_from(id))))
            }
            _ if is_receiver(ty) => {
                // Iterating over a receiver receives.
                let mut computed = self.computed_from(id);
                computed.calls.push("recv".to_owned());
                Item::Drawn(self.reads_of(id), computed)
            }
            _ => Item::Opaque,
        };
        let rounds = if is_endless {
            Rounds::Unbounded
        } else {
            match ty {
                Ty::Array(_, length) => length.value.map_or(Rounds::Bounded, Rounds::Constant),
                _ if is_optional => Rounds::Constant(1),
                _ => self.next_number(id).map_or(Rounds::Bounded, Rounds::Constant),
            }
        };
        let length = match ty {
            Ty::Array(_, length) => Some(length.clone()),
            _ => None,
        };
        Source { item, rounds, over, length, ..Source::bounded() }
    }

    /// Whether lines that are read from an expression come one by one.
    fn is_stream(&self, id: ExprId) -> bool {
        match &self.body().expr(id).kind {
            ExprKind::MethodCall { receiver, method, .. } if method == "lock" => self.is_stream(*receiver),
            _ => matches!(self.ty(id).peel().external_name(), Some("Stdin" | "StdinLock" | "BufReader")),
        }
    }

    /// The first of the whole numbers in a row that an array lists: `for axis in [ROLL, PITCH, YAW]` counts as a range does.
    fn first_of_row(&mut self, elements: &[ExprId]) -> Option<u64> {
        let numbers: Vec<u64> = elements.iter().map(|element| self.number(*element)).collect::<Option<_>>()?;
        let first = *numbers.first()?;
        (first..).zip(&numbers).all(|(next, number)| next == *number).then_some(first)
    }

    fn range(&mut self, start: Option<ExprId>, end: Option<ExprId>, inclusive: bool) -> Source {
        for bound in [start, end].into_iter().flatten() {
            self.expr(bound);
        }
        let first = start.and_then(|start| self.number(start));
        let rounds = match end {
            None => Rounds::Unbounded,
            Some(end) => match (first, self.number(end)) {
                (Some(first), Some(last)) => Rounds::Constant((last + u64::from(inclusive)).saturating_sub(first)),
                _ => Rounds::Bounded,
            },
        };
        let limits = end.map(|end| self.limits(end, inclusive)).unwrap_or_default();
        Source { item: Item::Counter(first), rounds, limits, ..Source::bounded() }
    }

    /// The whole number that an expression certainly is.
    pub(super) fn number(&mut self, id: ExprId) -> Option<u64> {
        let body = self.body();
        match &body.expr(id).kind {
            ExprKind::Literal(Literal::Int(value, _)) => *value,
            ExprKind::Cast { value, .. } => self.number(*value),
            ExprKind::Binary { op, lhs, rhs } => {
                let (left, right) = (self.number(*lhs)?, self.number(*rhs)?);
                match *op {
                    "+" => left.checked_add(right),
                    "-" => left.checked_sub(right),
                    "*" => left.checked_mul(right),
                    "/" => left.checked_div(right),
                    _ => None,
                }
            }
            ExprKind::Path(path) => match self.index_key(id)? {
                IndexKey::Number(number) => Some(number),
                _ => self.agreed_number(path),
            },
            ExprKind::MethodCall { receiver, method, .. } if method == "len" => match self.ty(*receiver).peel() {
                Ty::Array(_, length) => length.value,
                _ => None,
            },
            _ => None,
        }
    }

    /// `repeat_with(f)`, `from_fn(f)`, `repeat(x)`, and functions that give an iterator.
    fn generator(&mut self, id: ExprId, callee: ExprId, args: &[ExprId]) -> Source {
        let told = match self.typed().callees.get(&id) {
            Some(Callee::External(path)) => path.strip_prefix("std::iter::"),
            _ => None,
        };
        let is_std = told.is_some();
        let name = match (told, &self.body().expr(callee).kind) {
            // Whatever it is called where it is imported.
            (Some(name), _) => name.to_owned(),
            (None, ExprKind::Path(path)) => path.last().to_owned(),
            _ => String::new(),
        };
        match (name.as_str(), args) {
            ("zip", [first, second]) if is_std => return self.zip(*first, Some(*second)),
            ("once", [only]) if is_std => {
                let value = self.expr(*only);
                self.lose_iterated(*only, value.place.iter().filter(|_| value.is_owned).cloned().collect());
                // What a tuple lends is lent by what the iterator gives: `once((&name, &mut lag))`.
                let is_lent = !value.is_owned || matches!(self.ty(*only), Ty::Tuple(_));
                let item = match value.place {
                    Some(place) if is_lent && self.may_hold_filter(self.ty(*only)) => Item::Same(place),
                    _ => Item::Made,
                };
                return Source { item, rounds: Rounds::Constant(1), ..Source::bounded() };
            }
            ("repeat" | "repeat_n", [repeated, ..])
                if is_std && self.program.index.may_share_filter(self.ty(*repeated)) =>
            {
                let values = self.values(args);
                let clones = values.first().and_then(|value| self.keep_clones(value, *repeated));
                let rounds = if name == "repeat" { Rounds::Unbounded } else { Rounds::Bounded };
                return Source { item: clones.map_or(Item::Made, Item::Element), rounds, ..Source::bounded() };
            }
            _ => {}
        }
        if matches!(name.as_str(), "repeat_with" | "from_fn" | "repeat" | "successors") {
            let values: Vec<Value> = args.iter().map(|arg| self.expr(*arg)).collect();
            if let ("repeat", [value], [arg]) = (name.as_str(), values.as_slice(), args) {
                // What is repeated moves into the iterator, and its clones live on.
                let template = self.temporary(Ty::Unknown, self.span(*arg));
                self.place_part(Place::var(template).element(IndexKey::Each), value, *arg);
            }
            // What gives `None` ends the iterator.
            let may_end = matches!(name.as_str(), "from_fn" | "successors");
            let stage = |closure| if may_end { Stage::Scan(closure, None) } else { Stage::Make(closure) };
            let stages = values.iter().rev().find_map(|value| value.closure).map(stage);
            return Source {
                item: Item::Made,
                rounds: Rounds::Unbounded,
                stages: stages.into_iter().collect(),
                ..Source::bounded()
            };
        }
        self.collection(id, false)
    }

    fn zip(&mut self, first: ExprId, second: Option<ExprId>) -> Source {
        let begun = self.graph.nodes.len();
        let source = self.source(first);
        let other = second.map_or_else(Source::bounded, |second| self.source(second));
        let rounds = match (&source.rounds, &other.rounds) {
            (Rounds::Unbounded, rounds) | (rounds, Rounds::Unbounded) => rounds.clone(),
            (Rounds::Constant(a), Rounds::Constant(b)) => Rounds::Constant(*a.min(b)),
            _ => Rounds::Bounded,
        };
        let in_order = source.in_order && other.in_order;
        let may_end_first = source.may_outlast(&other);
        let [source, other] = [source, other].map(|source| match &rounds {
            // Of what is cut short, the last numbers are left out.
            Rounds::Constant(_) if source.rounds != rounds => source.uncounted(),
            _ => source,
        });
        let counts_down = match (source.item.has_counter(), other.item.has_counter()) {
            (true, _) => source.counts_down,
            (false, true) => other.counts_down,
            (false, false) => source.counts_down && other.counts_down,
        };
        let [source, other] = [source, other].map(|source| match may_end_first {
            true => source.cut_somewhere(".."),
            false => source.shortened(&rounds),
        });
        let passes_over = source.passes() || other.passes();
        let is_shared = source.is_shared && other.is_shared;
        let source = if other.item.has_lent() { self.beside(source, first, begun) } else { source };
        let other = match second {
            Some(second) if source.item.has_lent() => self.beside(other, second, begun),
            _ => other,
        };
        let limits = [source.limits.as_slice(), &other.limits].concat();
        let item = Item::Tuple(vec![source.staged(), other.staged()]);
        Source { item, rounds, passes_over, in_order, counts_down, is_shared, limits, ..Source::bounded() }
    }

    /// An iterator whose items go along with filters: each is a state of one of these, if it is no sample.
    fn beside(&mut self, source: Source, id: ExprId, begun: usize) -> Source {
        let of_iterator = match self.ty(id) {
            Ty::External(_, args) if self.iterates(self.ty(id)) => args.first().cloned(),
            ty => match ty.peel() {
                Ty::Array(element, _) | Ty::Slice(element) => Some(match ty {
                    Ty::Ref(is_exclusive, _) => Ty::Ref(*is_exclusive, element.clone()),
                    _ => Ty::clone(element),
                }),
                Ty::External(_, args) => args.first().cloned(),
                _ => None,
            },
        };
        let is_state = of_iterator.is_some_and(|ty| match ty.peel() {
            Ty::Bool | Ty::Adt(..) => true,
            Ty::Int => matches!(ty, Ty::Ref(true, _)),
            _ => false,
        });
        let is_received = |computed: &Computed| computed.calls.iter().any(|call| call == "recv");
        let is_plain = match &source.item {
            Item::Opaque => true,
            Item::Drawn(_, computed) => !is_received(computed),
            _ => false,
        };
        match &source.over {
            Some(over) if is_state && is_plain && source.in_order && source.stages.is_empty() => {
                // What is lent there is written by the names of the elements.
                for node in &mut self.graph.nodes[begun..] {
                    if matches!(&node.effect, Effect::Write(write) if write.place == *over && write.from.is_none()) {
                        node.effect = Effect::Nothing;
                    }
                }
                Source { item: Item::Beside(over.clone(), Box::new(source.item)), ..source }
            }
            _ => source,
        }
    }

    /// What `copied` or `cloned` gives of elements.
    fn copied_item(&mut self, item: Item, receiver: ExprId) -> Item {
        let of_iterator = match self.ty(receiver) {
            Ty::External(_, args) => args.first().map(|item| item.peel().clone()),
            _ => None,
        };
        match (item, of_iterator.filter(|ty| self.may_hold_filter(ty))) {
            (Item::Element(place), Some(ty)) => {
                let whole = Value { place: Some(place), is_owned: true, ..Value::default() };
                let copies = self.copy_of(&whole, Ty::std("std::vec::Vec", vec![ty]), self.span(receiver));
                copies.place.map_or(Item::Made, Item::Element)
            }
            (item, _) if item.is_lent() => Item::Made,
            (item, _) => item,
        }
    }

    fn adaptor(&mut self, id: ExprId, receiver: ExprId, method: &str, args: &[ExprId]) -> Source {
        self.note_lent_by(receiver, method);
        // A method of the analysed code is what it does, whatever its name.
        if matches!(self.typed().callees.get(&id), Some(Callee::Resolved(resolved)) if !resolved.targets.is_empty()) {
            return self.collection(id, false);
        }
        self.note_provided(receiver, method);
        match method {
            "rev" => self.source(receiver).reversed(),
            "into_iter" | "into_par_iter" | "par_bridge" | "peekable" | "fuse" | "unwrap" => self.source(receiver),
            "with_min_len" | "with_max_len" => {
                self.values(args);
                self.source(receiver)
            }
            "iter" | "par_iter" if self.lends_shared(receiver) => {
                Source { is_shared: true, ..self.source_of(receiver, true) }
            }
            "by_ref" if self.iterates(self.ty(receiver)) && !self.is_last_use(receiver) => self.part_of(id, receiver),
            "iter" | "iter_mut" | "by_ref" | "as_mut" | "as_mut_slice" | "as_slice" | "as_ref" | "each_mut"
            | "deref_mut" | "par_iter" | "par_iter_mut" | "into_iter_mut" => self.source_of(receiver, true),
            "copied" | "cloned" => {
                let source = self.unchained(receiver);
                let item = self.copied_item(source.item.clone(), receiver);
                Source { item, ..source }
            }
            "take" => {
                let source = self.source(receiver);
                let count = args.first().and_then(|arg| {
                    self.expr(*arg);
                    self.number(*arg)
                });
                let rounds = match (&source.rounds, &source.item) {
                    (Rounds::Unbounded, _) => count.map_or(Rounds::Bounded, Rounds::Constant),
                    (Rounds::Constant(all), _) => Rounds::Constant(count.map_or(*all, |count| count.min(*all))),
                    (Rounds::Bounded, _) => Rounds::Bounded,
                };
                let mut source = source;
                if matches!(source.item, Item::Counter(_)) && !source.counts_down {
                    source.limits.push(count.map_or(Limit::Unknown, Limit::Number));
                }
                if let (Some(arg), Item::Element(place)) = (args.first(), source.item.clone()) {
                    source.passes_over |= self.is_short_of(*arg, &place);
                }
                Source { rounds, ..source.headed(count) }
            }
            "chain" => self.chain(receiver, args),
            "skip" | "step_by" => {
                let source = self.source(receiver);
                let mut number = None;
                for arg in args {
                    self.expr(*arg);
                    number = self.number(*arg);
                }
                source.thinned(method, number)
            }
            "flatten" if self.gives_rows(receiver) => {
                let source = self.unchained(receiver);
                let item = match source.item {
                    Item::Element(place) => Item::Element(place.element(IndexKey::Each)),
                    _ => Item::Opaque,
                };
                Source { item, rounds: Rounds::Bounded, ..source }
            }
            "flatten" | "filter_map" | "flat_map" if self.gives_present(receiver, method, args) => {
                self.present(receiver)
            }
            "cycle" => Source { rounds: Rounds::Unbounded, in_order: false, ..self.source(receiver) },
            "enumerate" => {
                let begun = self.graph.nodes.len();
                let mut source = self.source(receiver).uncounted();
                if source.stages.is_empty() {
                    source = self.beside(source, receiver, begun);
                    source.item = Item::Tuple(vec![Item::Counter(Some(0)), source.item]);
                } else {
                    source.stages.push(Stage::Number);
                }
                source
            }
            "zip" => self.zip(receiver, args.first().copied()),
            "map" | "filter" | "inspect" | "filter_map" | "take_while" | "skip_while" | "map_while" | "flat_map"
            | "scan" => {
                let mut source = self.source(receiver);
                let values: Vec<Value> = args.iter().map(|arg| self.expr(*arg)).collect();
                let closure = values.iter().rev().find_map(|value| value.closure);
                let state = match (method, args, values.as_slice()) {
                    ("scan", [first, _], [value, _]) => self.carried(*first, value),
                    _ => None,
                };
                let has_lent = source.item.has_lent();
                let stage = |closure| match method {
                    "map" => Stage::Map(closure),
                    "scan" => Stage::Scan(closure, state),
                    "flat_map" => Stage::Flatten(closure),
                    "inspect" => Stage::Inspect(closure),
                    "map_while" if !has_lent => Stage::While(closure),
                    _ => Stage::Filter(closure),
                };
                // What a closure made may be left out when its work is done.
                let is_own = source.keeps_items();
                source.leaves_out |= matches!(method, "filter" | "filter_map") && is_own;
                let stops = matches!(method, "take_while" | "map_while") || method == "skip_while" && is_own;
                source.passes_over |= stops;
                source.stages.extend(closure.map(stage));
                source
            }
            "chunks_mut"
            | "chunks"
            | "chunks_exact_mut"
            | "chunks_exact"
            | "split_mut"
            | "par_chunks_mut"
            | "par_chunks"
            | "par_chunks_exact_mut"
            | "par_chunks_exact" => {
                let source = self.source_of(receiver, true);
                self.chunked(id, method, args, source)
            }
            "values_mut" | "values" | "into_values" if is_map(self.ty(receiver).peel()) => {
                let source = self.source_of(receiver, true);
                let item = source.item.values();
                Source { item, ..source }
            }
            "lines" if self.is_stream(receiver) => {
                self.expr(receiver);
                let mut computed = self.computed_from(id);
                computed.calls.push("recv".to_owned());
                Source { item: Item::Drawn(self.reads_of(id), computed), ..Source::bounded() }
            }
            "values_mut" | "values" | "drain" | "keys" | "windows" | "lines" | "chars" | "bytes" | "split" => {
                let collection = self.expr(receiver);
                if let ("drain", Some(place)) = (method, &collection.place)
                    && let Some(source) = self.drained(receiver, args, place, self.span(id))
                {
                    return source;
                }
                self.note_taken_out(method, &collection);
                for arg in args {
                    self.expr(*arg);
                }
                if method == "drain" {
                    let first = self.graph.nodes.len();
                    self.note_lent(receiver);
                    self.note_resized(first, receiver, method, args);
                }
                Source { drains: method == "drain", ..Source::bounded() }
            }
            "iter_from" | "incoming" | "try_iter" | "recv_iter" => {
                self.expr(receiver);
                let drains = method == "try_iter";
                let rounds = if drains { Rounds::Bounded } else { Rounds::Unbounded };
                Source { rounds, drains, ..Source::bounded() }
            }
            _ => self.collection(id, false),
        }
    }

    /// A method that consumes an iterator; `None` if the call is something else.
    pub(super) fn iterator_call(
        &mut self,
        id: ExprId,
        receiver: ExprId,
        method: &str,
        args: &[ExprId],
    ) -> Option<Value> {
        let consumes = matches!(
            method,
            "for_each"
                | "for_each_init"
                | "for_each_with"
                | "fold"
                | "sum"
                | "product"
                | "collect"
                | "collect_vec"
                | "count"
                | "last"
                | "all"
                | "any"
                | "max"
                | "min"
                | "try_for_each"
                | "try_fold"
                | "find"
                | "position"
                | "partition"
                | "unzip"
                | "reduce"
                | "min_by"
                | "max_by"
                | "min_by_key"
                | "max_by_key"
                | "nth"
                | "find_map"
                | "rfold"
        ) || compares(method);
        // `[&mut roll, &mut pitch].map(|axis| …)` takes each element at once.
        let maps_array = method == "map" && matches!(self.ty(receiver).peel(), Ty::Array(..));
        // `voices.retain(|voice| …)` asks each element, and keeps some.
        let is_collection = || crate::types::item_of(self.ty(receiver).peel()).is_some();
        let asks_each = matches!(method, "retain" | "retain_mut")
            && (self.may_hold_filter(self.ty(receiver)) || is_collection() && self.is_closure(args));
        if !(maps_array || asks_each || consumes && self.is_iterator(receiver, method))
            || matches!(self.typed().callees.get(&id), Some(Callee::Resolved(resolved)) if !resolved.targets.is_empty())
        {
            return None;
        }
        if self.at.is_some() && self.unrolled_closure(id, receiver, method, args) {
            return Some(Value::default());
        }
        let mut source = self.source(receiver);
        if self.at.is_none() {
            return Some(Value::default());
        }
        // The closure gets the key and the value.
        let is_keyed = asks_each && is_map(self.ty(receiver).peel());
        if is_keyed {
            source.item = source.item.values();
        }
        // One of the elements, data says which.
        let picked = match &source.item {
            Item::Element(place) if picks_one(method) => Some(place.element(IndexKey::Data(self.text(id).into()))),
            _ => None,
        };
        let picked = Value { place: picked, ..Value::default() };
        let values: Vec<Value> = args.iter().map(|arg| self.expr(*arg)).collect();
        for value in &values {
            self.keep_iterator(value, &Cause::Call(self.text(id)), self.span(id));
        }
        let closure = values.iter().rev().find_map(|value| value.closure);
        // What is put together of results or options ends with the first one that is missing, and says so.
        let tells = matches!(method, "try_for_each" | "try_fold" | "collect" | "sum" | "product")
            && matches!(self.ty(id).external_name(), Some("Option" | "Result"));
        let stops = if tells {
            let told = self.temporary(self.ty(id).clone(), self.span(id));
            Stops::AndTells(told)
        } else if stops_anywhere(method) {
            Stops::Anywhere
        } else {
            Stops::Never
        };
        if matches!(stops, Stops::Anywhere | Stops::AndTells(_)) {
            self.note_advanced(receiver);
        }
        let rebuilt = matches!(method, "collect" | "collect_vec").then(|| self.rebuilt(receiver, &source)).flatten();
        // Through the shared reference that is picked, no filter is updated.
        let gathers = matches!(method, "collect" | "collect_vec" | "partition" | "unzip") && rebuilt.is_none()
            || picks_one(method) && !self.iterates_shared(self.ty(receiver));
        if let (true, Item::Element(collection)) = (gathers, &source.item) {
            // The references to the elements go into another collection.
            self.graph.lent_away.insert(collection.clone());
        }
        if matches!(method, "collect" | "collect_vec")
            && let Some(collected) = self.collected_references(id, source.clone())
        {
            return Some(collected);
        }
        if closure.is_none() && !source.has_closures() {
            return Some(picked);
        }
        let state = match (method, args, values.as_slice()) {
            ("fold" | "rfold" | "try_fold", [first, _], [value, _]) => State::Carried(self.carried(*first, value)),
            ("fold" | "rfold" | "try_fold" | "reduce" | "for_each_init" | "for_each_with", ..) => State::Carried(None),
            _ if is_keyed => State::Carried(None),
            _ => State::None,
        };
        if method == "partition" && source.keeps_items() {
            // Which of the two collections has an element is not known.
            let all = self.iterator_value(Source { stages: Vec::new(), ..source.clone() });
            self.keep_iterator(&all, &Cause::Index(self.text(id)), self.span(id));
        }
        let mapped = args.first().filter(|_| maps_array).and_then(|closure| self.mapped_array(&source, *closure));
        let kept_some = source.over.clone().filter(|_| asks_each);
        let own = self.graph.loops.len();
        self.consume(id, source, closure, Consumer { state, stops, gathers });
        if let Some(info) = self.graph.loops.get_mut(own).filter(|_| !matches!(stops, Stops::Never)) {
            info.stops_by = Some(method.to_owned());
        }
        if let Some(collection) = kept_some.filter(|_| self.is_collection_of_references(self.ty(receiver).peel())) {
            self.lose_some(id, method, &collection);
        }
        let carried = state.var().map(Place::var);
        Some(match stops {
            Stops::AndTells(told) => {
                let place = carried.unwrap_or(Place::var(told));
                Value { place: Some(place), is_owned: true, same_as: Some(told), ..Value::default() }
            }
            _ if carried.is_some() => Value { place: carried, is_owned: true, ..Value::default() },
            _ => mapped.or(rebuilt).unwrap_or(picked),
        })
    }

    fn is_closure(&self, args: &[ExprId]) -> bool {
        args.iter().any(|arg| matches!(self.body().expr(*arg).kind, ExprKind::Closure(_)))
    }

    /// Whether an expression is an iterator, as far as its type or its shape tells.
    fn is_iterator(&self, id: ExprId, consumer: &str) -> bool {
        let ty = self.ty(id).peel();
        if matches!(ty.external_name(), Some("Iterator" | "Range")) {
            return true;
        }
        // A trait without a body of its own: a stream, as far as its method's name tells.
        if matches!(ty, Ty::Unknown | Ty::Param(_) | Ty::Opaque(_)) {
            let is_told = || !compares(consumer) && self.has_adaptor(id);
            return matches!(consumer, "for_each" | "fold" | "try_for_each") || is_told();
        }
        false
    }

    /// Whether each item of an iterator is an array, slice or vector.
    fn gives_rows(&self, id: ExprId) -> bool {
        matches!(self.ty(id), Ty::External(_, args) if args.first().map(Ty::peel).is_some_and(is_row))
    }

    fn has_adaptor(&self, id: ExprId) -> bool {
        match &self.body().expr(id).kind {
            ExprKind::MethodCall { method, .. } => matches!(
                method.as_str(),
                "map"
                    | "iter"
                    | "iter_mut"
                    | "into_iter"
                    | "par_iter"
                    | "par_iter_mut"
                    | "into_par_iter"
                    | "filter"
                    | "zip"
                    | "enumerate"
                    | "chunks"
                    | "chunks_mut"
                    | "rev"
                    | "take"
            ),
            _ => false,
        }
    }

    fn consume(&mut self, id: ExprId, source: Source, closure: Option<ClosureRef>, consumer: Consumer) {
        let span = self.span(id);
        let runs = closure.or_else(|| source.stages.iter().rev().find_map(|stage| stage.closure()));
        let bar = runs.map_or(span, |closure| self.bar(closure));
        let choosing = self.choosing(&source);
        let is_mapped = choosing.is_none();
        let kind = if is_mapped { source.numbered().unwrap_or(Item::Opaque) } else { source.item.clone() };
        let Consumer { state, stops, gathers } = consumer;
        let takes_state = state != State::None;
        let expr = id;
        self.tell(stops, "+", span);
        self.run_loop(CycleKind::Closure, bar, None, source, |this, item, id| {
            if gathers && this.at.is_some() {
                this.keep(&item, expr);
            }
            let mut answer = Value::default();
            if let Some(closure) = closure {
                let mut args = vec![item];
                if takes_state {
                    let carried = state.var().map(Place::var);
                    args.insert(0, Value { place: carried, is_owned: true, ..Value::default() });
                }
                this.note_given_item(id, closure, usize::from(takes_state), &kind);
                if let Some(pat) = this.param_of(closure).filter(|_| !takes_state) {
                    this.note_chosen(&choosing, (closure.frame, pat));
                }
                let value = this.inline_closure(closure, &args, span);
                if takes_state {
                    this.derive_begun(expr, closure);
                }
                match state.var() {
                    Some(state) => this.carry_on(state, &value, span),
                    None => {
                        this.keep_result(closure, &value);
                        this.awaited(value.clone(), span);
                    }
                }
                // What the closure gives back says whether the next item has a round.
                if let Stops::AndTells(_) = stops {
                    answer = value;
                }
            }
            if stops != Stops::Never && this.at.is_some() {
                let (text, about) = ("the iteration goes on".to_owned(), crate::flow::About::default());
                let (again, stop) = this.branch_on_head(&answer, "+", "-", span, text, about);
                this.resume(stop);
                this.tell(stops, "-", span);
                this.break_out(span);
                this.resume(again);
            }
        });
    }

    /// Notes whether what a consumer gives back is there.
    fn tell(&mut self, stops: Stops, head: &str, span: Span) {
        if let Stops::AndTells(told) = stops {
            self.set(told, &Value { head: Some(head.to_owned()), ..Value::default() }, span);
        }
    }

    /// A closure that runs once for each of a number of rounds.
    pub(super) fn closure_loop(&mut self, closure: ClosureRef, source: Source, span: Span) {
        let (bar, kind) = (self.bar(closure), source.item.clone());
        self.run_loop(CycleKind::Closure, bar, None, source, |this, item, id| {
            this.note_given_item(id, closure, 0, &kind);
            let value = this.inline_closure(closure, &[item], span);
            this.keep_result(closure, &value);
            this.awaited(value, span);
        });
    }

    /// A closure that gives a value to each element: what it computes goes into the round's item.
    pub(super) fn fill_loop(&mut self, closure: ClosureRef, span: Span) -> Option<Value> {
        let bar = self.bar(closure);
        let mut given = None;
        self.run_loop(CycleKind::Closure, bar, None, Source::bounded(), |this, item, _| {
            let filled = item.place.and_then(|place| place.base_var()).into_iter().collect();
            let outer = std::mem::replace(&mut this.targets, filled);
            let value = this.inline_closure(closure, &[], span);
            this.targets = outer;
            this.keep_result(closure, &value);
            given = Some(value);
        });
        given
    }

    /// What a closure is given in each round the loop binds; a counter keeps being one under its parameter's name.
    fn note_given_item(&mut self, id: LoopId, closure: ClosureRef, param: usize, item: &Item) {
        let body = self.frames[closure.frame].body;
        let ExprKind::Closure(code) = &body.expr(closure.expr).kind else { return };
        let Some((pat, _)) = code.params.get(param) else { return };
        let outer = std::mem::replace(&mut self.frame, closure.frame);
        let mut counters = Vec::new();
        self.counter_names(*pat, item, &mut counters);
        let given = self.vars_of(*pat);
        let info = &mut self.graph.loops[id.0 as usize];
        info.bound.extend(given);
        if let (Some((_, first)), Some(var)) = (info.counter, counters.first()) {
            info.counter = Some((*var, first));
        }
        self.note_sampled(id, code.body);
        self.frame = outer;
    }

    /// Runs an iterator whose items go into a collection.
    pub(super) fn gather(&mut self, id: ExprId, source: &Source) {
        let consumer = Consumer { state: State::None, stops: Stops::Never, gathers: true };
        if source.has_closures() && !source.is_choice {
            self.consume(id, source.clone(), None, consumer);
        }
    }

    /// The loop over a source: the rounds, their items, and the closures of the chain.
    pub(super) fn run_loop(
        &mut self,
        kind: CycleKind,
        keyword: Span,
        label: Option<&String>,
        source: Source,
        inside: impl FnOnce(&mut Self, Value, LoopId),
    ) {
        if self.at.is_none() {
            return;
        }
        let any = |is: fn(&Stage) -> bool| source.stages.iter().any(is);
        let is_filtered = any(|stage| matches!(stage, Stage::Filter(_)));
        let is_numbered = any(|stage| matches!(stage, Stage::Number));
        let is_flattened = any(|stage| matches!(stage, Stage::Flatten(_)));
        let rounds = match &source.rounds {
            // How many of the items pass, or come of each, is not known; of one it is one at most.
            Rounds::Constant(_) if is_flattened => Rounds::Bounded,
            Rounds::Constant(2..) if is_filtered && (!source.item.is_lent() || is_numbered) => Rounds::Bounded,
            rounds => rounds.clone(),
        };
        let info = LoopInfo {
            over: source.over.clone(),
            passes_over: source.passes(),
            in_order: source.in_order && !source.passes(),
            counts_down: source.counts_down,
            drains: source.drains,
            is_entered: source.is_filled,
            limits: source.limits.clone(),
            ..self.plain_loop(kind, keyword, rounds, source.text.clone())
        };
        let id = self.add_loop(info);
        self.emit(Effect::LoopEnter(id), keyword);
        let after = self.add_node(Effect::Nothing, keyword);
        self.loops.push(id);
        let head = self.emit(Effect::LoopHead(id), keyword);
        self.graph.loops[id.0 as usize].head = head;
        let round = self.add_node(Effect::Nothing, keyword);
        self.link(head, round);
        self.push_loop_scope(label, after, head, keyword);
        self.resume(round);
        let begun = Begun { id, kind, head, round, keyword, counts_items: source.counts_items() };
        let (item, acting, is_told) = match &source.item {
            Item::Chained(items) => {
                let (item, is_told) = self.one_behind_another(&begun, items, &source.reads);
                let (item, acting, _) = self.run_stages(&begun, &source.item, &source.stages, item);
                (item, acting, is_told)
            }
            kind => {
                let item = self.item_value(id, kind, &source.reads, keyword);
                self.run_stages(&begun, kind, &source.stages, item)
            }
        };
        if is_told && !source.passes_over {
            let info = &mut self.graph.loops[id.0 as usize];
            (info.passes_over, info.in_order) = (false, source.in_order);
        }
        if let Some(closure) = acting {
            self.graph.loops[id.0 as usize].keyword = self.bar(closure);
        }
        inside(self, item, id);
        self.pop_loop_scope();
        self.jump(head);
        let info = self.graph.loop_info(id);
        let has_round = (matches!(info.rounds, Rounds::Constant(1..)) || info.is_entered) && !info.passes_over;
        if self.is_left_at_its_head(head, has_round) {
            self.link(head, after);
        }
        self.loops.pop();
        self.resume_if_reached(after);
    }

    /// The stages of a chain in the round; with the item, the first closure that does something, and whether what a filter leaves
    /// out has a round all the same, since something is done to it or asked of it.
    pub(super) fn run_stages(
        &mut self,
        begun: &Begun,
        kind: &Item,
        stages: &[Stage],
        mut item: Value,
    ) -> (Value, Option<ClosureRef>, bool) {
        let Begun { id, head, keyword, .. } = *begun;
        let mut acting: Option<ClosureRef> = None;
        let mut is_round = false;
        let has_lent = kind.has_lent();
        let is_counted = begun.counts_items && self.graph.loop_info(id).counter.is_none();
        for (number, stage) in stages.iter().enumerate() {
            if let (0, Some(closure)) = (number, stage.closure()) {
                self.note_given_item(id, closure, 0, kind);
            }
            if let (true, Some(item), Some(closure)) = (is_counted, numbered_item(&stages[..number]), stage.closure()) {
                self.note_given_item(id, closure, 0, &item);
            }
            let first = self.graph.nodes.len();
            let acts_before = self.acts_since(begun.round.0 as usize);
            item = match stage {
                Stage::Skip if acts_before => self.skipped(id, item, head, keyword),
                _ => self.stage(id, *stage, item, head, keyword, has_lent),
            };
            if let Some(closure) = stage.closure() {
                let made_by = stages[..number].iter().rev().find_map(|before| match before {
                    Stage::Map(closure) => Some(*closure),
                    _ => None,
                });
                made_by.into_iter().for_each(|made_by| self.derive_made(made_by, closure));
            }
            // What a filter does to each element is done to those as well that it leaves out. So are its questions: they say why.
            let is_told = |test: &Test| test.about.rest.is_some() || (has_lent && !test.about.reads.is_empty());
            let asks = |this: &Self| {
                let mut nodes = this.graph.nodes[first..].iter();
                nodes.any(|node| matches!(&node.effect, Effect::Branch(test) if is_told(test)))
            };
            is_round |= matches!(stage, Stage::Filter(_)) && (self.acts_since(first) || asks(self));
            // The first closure that does something is what a reader takes for the cycle.
            if let (CycleKind::Closure, None, Some(closure)) = (begun.kind, acting, stage.closure())
                && self.acts_since(first)
            {
                acting = Some(closure);
            }
        }
        (item, acting, is_round)
    }

    /// A stage of the chain in the round.
    fn stage(&mut self, id: LoopId, stage: Stage, item: Value, head: NodeId, span: Span, is_lent: bool) -> Value {
        let first = self.graph.nodes.len();
        let Some(closure) = stage.closure() else { return self.numbered(id, item, span) };
        let makes_item = matches!(stage, Stage::Filter(_)) && self.makes_of_item(closure);
        if matches!(stage, Stage::Filter(_)) && !makes_item && self.at.is_some() {
            let skipped = self.add_node(Effect::Nothing, span);
            if self.inline_question(closure, &stage.args(&item), skipped) {
                let passes = self.at;
                self.resume_if_reached(skipped);
                self.leave_out(head, is_lent || self.acts_since(first), span);
                self.at = passes;
                return item;
            }
        }
        let mut made = self.inline_closure(closure, &stage.args(&item), span);
        if self.is_future(&made) {
            // Where it is awaited is not seen.
            self.keep_closure(&made, span);
            made.closure = None;
        }
        match stage {
            Stage::Map(_) | Stage::Make(_) => made,
            Stage::Scan(..) | Stage::While(_) => {
                if self.at.is_some() {
                    let (text, about) = ("the item is there".to_owned(), crate::flow::About::default());
                    let (goes_on, ends) = self.branch_on_head(&made, "+", "-", span, text, about);
                    self.resume(ends);
                    self.break_out(span);
                    self.resume(goes_on);
                }
                Value { head: None, same_as: None, ..made }
            }
            Stage::Flatten(closure) => self.flattened(closure, made, span),
            Stage::Inspect(_) | Stage::Number | Stage::Skip => item,
            Stage::Filter(_) => {
                if self.at.is_some() {
                    // What the closure answers is a condition like any other.
                    let is_truth = |var: &Var| self.graph.var(*var).ty == Ty::Bool;
                    let truth = Value { same_as: made.same_as.filter(is_truth), ..Value::default() };
                    let asked = item.place.as_ref().and_then(Place::base_var).filter(|_| makes_item);
                    let about = asked.map(crate::flow::About::presence_of).unwrap_or_default();
                    let text = "the item passes the filter".to_owned();
                    let (passes, skipped) = self.branch_on_head(&truth, "true", "false", span, text, about);
                    self.resume(skipped);
                    self.leave_out(head, is_lent || self.acts_since(first), span);
                    self.resume(passes);
                }
                item
            }
        }
    }

    /// Leaves an item out, which is a round of its own, or none: then the loop goes on with the next item.
    fn leave_out(&mut self, head: NodeId, is_round: bool, span: Span) {
        if is_round {
            self.jump(head);
        } else {
            self.emit(Effect::End, span);
        }
    }

    /// The closures of a chain that only choose among the items; `None` where one may make something else of them.
    pub(super) fn choosing(&self, source: &Source) -> Option<Vec<ClosureRef>> {
        let chooses = |stage: &Stage| match stage {
            Stage::Inspect(closure) => Some(*closure),
            Stage::Filter(closure) => Some(*closure).filter(|closure| self.output_of(*closure) == Some(&Ty::Bool)),
            _ => None,
        };
        source.stages.iter().map(chooses).collect()
    }

    /// Notes that the names of a pattern are of the item that closures have chosen.
    pub(super) fn note_chosen(&mut self, choosing: &Option<Vec<ClosureRef>>, pat: (usize, PatId)) {
        for closure in choosing.iter().flatten() {
            if let Some(asked) = self.param_of(*closure) {
                self.note_same((closure.frame, asked), pat);
            }
        }
    }

    /// The pattern of a closure's first parameter.
    pub(in crate::flow::lower) fn param_of(&self, closure: ClosureRef) -> Option<PatId> {
        match &self.frames[closure.frame].body.expr(closure.expr).kind {
            ExprKind::Closure(code) => code.params.first().map(|(pat, _)| *pat),
            _ => None,
        }
    }

    /// Notes that the names of two patterns are of the same value, part by part; each pattern comes with its frame.
    fn note_same(&mut self, asked: (usize, PatId), bound: (usize, PatId)) {
        let kind = |(frame, pat): (usize, PatId)| &self.frames[frame].body.pat(pat).kind;
        match (kind(asked), kind(bound)) {
            (PatKind::Reference(inner), _) => self.note_same((asked.0, *inner), bound),
            (_, PatKind::Reference(inner)) => self.note_same(asked, (bound.0, *inner)),
            (PatKind::Tuple(parts), PatKind::Tuple(others)) if parts.len() == others.len() => {
                for (part, other) in parts.iter().zip(others) {
                    self.note_same((asked.0, *part), (bound.0, *other));
                }
            }
            (PatKind::Bind { .. }, PatKind::Bind { .. }) => {
                let var = |(frame, pat): (usize, PatId)| {
                    let frame = &self.frames[frame];
                    frame.vars.get(frame.typed.pat_local.get(&pat)?).copied()
                };
                if let (Some(asked), Some(bound)) = (var(asked), var(bound)) {
                    self.graph.derived.push((bound, asked));
                    self.graph.computed.entry(bound).or_default().places.push(Place::var(asked));
                }
            }
            _ => {}
        }
    }

    /// An item of the iterator that a closure gives for each item: each element of a collection, and what may be there.
    fn flattened(&mut self, closure: ClosureRef, made: Value, span: Span) -> Value {
        let over = match made.iterator.as_deref() {
            Some(Source { item: Item::Element(place), stages, passes_over: false, leaves_out: false, .. })
                if stages.is_empty() =>
            {
                Some(place.clone())
            }
            Some(_) => None,
            None => made.place.clone().filter(|_| self.lends_collection(closure)),
        };
        if let Some(place) = over {
            return Value { place: Some(place.element(IndexKey::Each)), ..Value::default() };
        }
        let cause = Cause::Code("an iterator of iterators".to_owned());
        self.keep_iterator(&made, &cause, span);
        match &made.place {
            Some(place) if self.at.is_some() && self.output_of(closure).is_some_and(is_row) => {
                self.emit(Effect::Unknown { places: vec![place.clone()], cause }, span);
                Value::default()
            }
            _ => Value { iterator: None, ..made },
        }
    }

    /// Whether a closure lends a collection, or gives an iterator over one.
    fn lends_collection(&self, closure: ClosureRef) -> bool {
        self.output_of(closure).is_some_and(|ty| match ty {
            Ty::Ref(_, inner) => is_row(inner.peel()),
            ty => ty.external_name() == Some("Iterator"),
        })
    }

    /// The type of what a closure gives.
    fn output_of(&self, closure: ClosureRef) -> Option<&Ty> {
        let frame = &self.frames[closure.frame];
        match &frame.body.expr(closure.expr).kind {
            ExprKind::Closure(code) => Some(frame.typed.ty(code.body)),
            _ => None,
        }
    }

    /// Drops an item after its closures have run, or goes on with it.
    fn skipped(&mut self, id: LoopId, item: Value, head: NodeId, span: Span) -> Value {
        if self.at.is_some() {
            // As many rounds as there are items, not as there are results.
            self.graph.loops[id.0 as usize].rounds = Rounds::Bounded;
            let about = crate::flow::About::default();
            let (passes, skipped) = self.opaque_branch(span, "the item is not skipped".to_owned(), about);
            self.resume(skipped);
            self.jump(head);
            self.resume(passes);
        }
        item
    }

    /// Whether anything may have happened to a filter since a node.
    fn acts_since(&self, first: usize) -> bool {
        self.graph.nodes[first..].iter().any(|node| match &node.effect {
            Effect::Update(_) | Effect::Reset { .. } | Effect::Unknown { .. } | Effect::Write(_) => true,
            Effect::Call(site) => site.args.iter().any(|arg| arg.place.is_some() && !arg.is_shared),
            _ => false,
        })
    }

    /// The value of a round's item, and what its variables name.
    pub(super) fn item_value(&mut self, id: LoopId, item: &Item, reads: &[Var], span: Span) -> Value {
        match item {
            Item::Opaque | Item::Made | Item::Drawn(..) => {
                let var = self.temporary(Ty::Unknown, span);
                let reads = match item {
                    Item::Drawn(reads, computed) => {
                        self.graph.computed.insert(var, computed.clone());
                        reads
                    }
                    _ => reads,
                };
                self.graph.derived.extend(reads.iter().map(|read| (var, *read)));
                self.graph.loops[id.0 as usize].bound.push(var);
                Value { place: Some(Place::var(var)), is_owned: true, ..Value::default() }
            }
            Item::Element(_) | Item::Chunk(_) | Item::Same(_) | Item::OneOf(_) => {
                let var = self.temporary(Ty::Unknown, span);
                let mut lent = Vec::new();
                item.lends(&mut lent);
                self.graph.derived.extend(reads.iter().map(|read| (var, *read)));
                let info = &mut self.graph.loops[id.0 as usize];
                info.items.extend(lent.into_iter().map(|place| (var, place)));
                info.bound.push(var);
                if let Item::OneOf(items) = item {
                    for item in items {
                        self.name_beside(var, item, span);
                    }
                }
                Value { place: Some(Place::var(var)), is_owned: false, ..Value::default() }
            }
            Item::Beside(_, drawn) => {
                let value = self.item_value(id, drawn, reads, span);
                if let Some(var) = value.place.as_ref().and_then(Place::base_var) {
                    self.name_beside(var, item, span);
                }
                Value { is_owned: false, ..value }
            }
            Item::Present(inner) => {
                let value = self.item_value(id, inner, reads, span);
                self.skip_absent(id, &value, span);
                value
            }
            Item::Chained(items) => self.one_of_chained(id, items, reads, span),
            Item::Staged(inner, stages) => {
                let mut value = self.item_value(id, inner, reads, span);
                for stage in stages {
                    let Some(closure) = stage.closure() else {
                        if matches!(stage, Stage::Number) {
                            value = self.numbered(id, value, span);
                        }
                        continue;
                    };
                    let made = self.inline_closure(closure, &stage.args(&value), span);
                    self.note_made_from(id, &made, &value);
                    match stage {
                        Stage::Map(_) | Stage::Make(_) | Stage::Scan(..) | Stage::While(_) => value = made,
                        Stage::Flatten(closure) => value = self.flattened(*closure, made, span),
                        Stage::Inspect(_) | Stage::Filter(_) | Stage::Number | Stage::Skip => {}
                    }
                }
                value
            }
            Item::Counter(first) => {
                let var = self.temporary(Ty::Int, span);
                let info = &mut self.graph.loops[id.0 as usize];
                if info.counter.is_none() {
                    info.counter = Some((var, *first));
                }
                info.bound.push(var);
                Value { place: Some(Place::var(var)), is_owned: true, same_as: Some(var), ..Value::default() }
            }
            Item::Tuple(items) => {
                let values = items.iter().map(|item| self.item_value(id, item, reads, span)).collect();
                let whole = self.tuple_value(values, span);
                let var = whole.place.as_ref().and_then(Place::base_var);
                self.graph.derived.extend(var.iter().flat_map(|var| reads.iter().map(|read| (*var, *read))));
                whole
            }
        }
    }

    /// Gives an element that lies beside a filter its name in the round.
    fn name_beside(&mut self, var: Var, item: &Item, span: Span) {
        if let Item::Beside(place, _) = item {
            let element = Value { place: Some(place.element(IndexKey::Each)), ..Value::default() };
            self.set(var, &element, span);
        }
    }

    /// The number of the round, with its item.
    fn numbered(&mut self, id: LoopId, item: Value, span: Span) -> Value {
        let number = self.item_value(id, &Item::Counter(Some(0)), &[], span);
        self.tuple_value(vec![number, item], span)
    }

    fn tuple_value(&mut self, parts: Vec<Value>, span: Span) -> Value {
        let var = self.temporary(Ty::Unknown, span);
        for (number, value) in parts.into_iter().enumerate() {
            let assignment = crate::flow::Assignment {
                place: Place::var(var).field(&number.to_string()),
                from: value.place,
                transfer: if value.is_owned { Transfer::Move } else { Transfer::Borrow },
                rebinds: true,
                head: None,
                same_as: None,
            };
            self.emit(Effect::Set(Box::new(assignment)), span);
        }
        Value { place: Some(Place::var(var)), is_owned: true, ..Value::default() }
    }

    /// Notes that an item is computed from another one.
    fn note_made_from(&mut self, id: LoopId, made: &Value, from: &Value) {
        let Some(to) = made.place.as_ref().and_then(Place::base_var) else { return };
        self.graph.loops[id.0 as usize].bound.push(to);
        if let Some(from) = &from.place {
            self.graph.derived.extend(from.base_var().map(|from| (to, from)));
            self.graph.computed.entry(to).or_default().places.push(from.clone());
        }
    }

    /// Binds the pattern of a `for` loop; a counter keeps being one under its own name.
    pub(super) fn bind_item(&mut self, id: LoopId, pat: PatId, item: &Item, value: &Value) {
        let mut counters: Vec<Var> = Vec::new();
        self.counter_names(pat, item, &mut counters);
        self.bind_pattern(pat, value);
        let bound = self.vars_of(pat);
        let info = &mut self.graph.loops[id.0 as usize];
        info.bound.extend(bound);
        if let Some((_, first)) = info.counter
            && let Some(var) = counters.first()
        {
            info.counter = Some((*var, first));
        }
    }

    fn counter_names(&mut self, pat: PatId, item: &Item, found: &mut Vec<Var>) {
        let body = self.body();
        match (&body.pat(pat).kind, item) {
            (PatKind::Bind { .. }, Item::Counter(_)) => {
                if let Some(local) = self.typed().pat_local.get(&pat).copied() {
                    found.push(self.var_of(local));
                }
            }
            (PatKind::Tuple(pats), Item::Tuple(items)) => {
                for (pat, item) in pats.iter().zip(items) {
                    self.counter_names(*pat, item, found);
                }
            }
            (PatKind::Reference(inner), item) => self.counter_names(*inner, item, found),
            _ => {}
        }
    }
}

/// Whether a type is an array, slice or vector.
pub(super) fn is_row(ty: &Ty) -> bool {
    matches!(ty, Ty::Array(..) | Ty::Slice(_)) || matches!(ty.external_name(), Some("Vec" | "ArrayVec" | "SmallVec"))
}

impl Stage {
    /// What its closure gets for an item.
    fn args(self, item: &Value) -> Vec<Value> {
        match self {
            Self::Make(_) => Vec::new(),
            Self::Scan(_, state) => {
                vec![Value { place: state.map(Place::var), ..Value::default() }, item.clone()]
            }
            _ => vec![item.clone()],
        }
    }
}

/// Whether a consumer gives back one of the elements.
fn picks_one(method: &str) -> bool {
    ["min", "max"].iter().any(|name| method.starts_with(name)) || matches!(method, "find" | "last" | "nth" | "reduce")
}

/// Whether a consumer may stop before the last element: where one decides, or where another iterator ends.
fn stops_anywhere(method: &str) -> bool {
    compares(method)
        || matches!(method, "all" | "any" | "find" | "find_map" | "position" | "nth" | "try_for_each" | "try_fold")
}

/// Whether a consumer compares with another iterator.
fn compares(method: &str) -> bool {
    matches!(method, "eq" | "ne" | "lt" | "le" | "gt" | "ge" | "cmp" | "partial_cmp")
}

/// Whether a value of the type is the end of a channel at which messages arrive.
fn is_receiver(ty: &Ty) -> bool {
    matches!(ty.external_name(), Some("Receiver" | "UnboundedReceiver" | "Subscriber"))
}

/// Whether iterating over a value of the type only ends when the other side does.
fn is_endless_type(ty: &Ty) -> bool {
    ty.external_name().is_some_and(|name| {
        matches!(
            name,
            "Receiver"
                | "UnboundedReceiver"
                | "Incoming"
                | "Ticker"
                | "Interval"
                | "Subscriber"
                | "IntoIter"
                | "Repeat"
        ) && name != "IntoIter"
    })
}
