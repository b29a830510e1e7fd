//! References to filters that are kept in options, fields and collections: what is given to such a place moves no filter, and nothing
//! of what it referred to before is written. What such a collection is made of is followed element by element.

use super::sources::{Item, Source, is_map};
use super::{Builder, Value};
use crate::flow::{Cause, CycleKind, Effect, IndexKey, Place, Rounds, Transfer, Var};
use crate::index::Ty;
use crate::source::Span;
use crate::syntax::tree::{ExprId, ExprKind, PatId, PatKind};

/// How many references are told apart by their numbers in what they are gathered in.
const MOST_NUMBERED: u64 = 16;

/// How many rounds over them are written out one behind the other.
const MOST_WRITTEN_OUT: u64 = 8;

impl Builder<'_> {
    /// Notes that the last node gives a place of that type another value, if all that it has of filters are references to them.
    pub(super) fn note_pointed(&mut self, ty: &Ty) {
        let Some(at) = self.at.filter(|_| self.program.index.refers_to_filters(ty)) else { return };
        if let Effect::Write(write) = &mut self.graph.nodes[at.0 as usize].effect {
            write.transfer = Transfer::Borrow;
            self.graph.pointed.insert(at);
        }
    }

    /// The collection of references that an iterator gives: `bank.iter_mut().collect()`.
    pub(super) fn collected_references(&mut self, id: ExprId, source: Source) -> Option<Value> {
        if !self.is_collection_of_references(self.ty(id)) || source.is_choice || source.is_advanced {
            return None;
        }
        let collection = Place::var(self.temporary(self.ty(id).clone(), self.span(id)));
        self.pour(id, id, source, (&collection, Some(0)));
        Some(Value { place: Some(collection), is_owned: true, ..Value::default() })
    }

    /// The collection of references that another one is made into: `VecDeque::from([&mut roll, &mut pitch])`.
    pub(super) fn converted_references(&mut self, id: ExprId, given: &Value) -> Option<Value> {
        let source = match &given.iterator {
            Some(source) => Source::clone(source),
            None => self.elements_at(given.place.clone()?),
        };
        self.collected_references(id, source)
    }

    /// The elements of a collection, from the first to the last one.
    fn elements_at(&self, place: Place) -> Source {
        let rounds = match self.ty_of_variable(&place) {
            Some(Ty::Array(_, length)) => length.value.map_or(Rounds::Bounded, Rounds::Constant),
            _ => Rounds::Bounded,
        };
        Source { item: Item::Element(place), rounds, ..Source::bounded() }
    }

    /// `filters.extend([&mut roll, &mut pitch])`
    pub(super) fn extend_references(
        &mut self,
        id: ExprId,
        receiver: ExprId,
        collection: &Value,
        given: &[Value],
    ) -> bool {
        let (Some(collection), [given]) = (&collection.place, given) else { return false };
        let ty = self.ty(receiver).peel();
        let is_such = self.is_collection_of_references(ty);
        let source = match (&given.iterator, &given.place) {
            _ if !is_such => return false,
            (Some(source), _) if source.is_choice || source.is_advanced => return false,
            (Some(source), _) => Source::clone(source),
            (None, Some(place)) => self.elements_at(place.clone()),
            (None, None) => return false,
        };
        let first = self.next_number(receiver);
        self.pour(id, receiver, source, (collection, first));
        true
    }

    /// Puts what a source gives into a collection, whose type is that of an expression; with the number that the first one of them has
    /// there, if that is known.
    fn pour(&mut self, id: ExprId, typed: ExprId, source: Source, (collection, first): (&Place, Option<u64>)) {
        let is_keyed = is_map(self.ty(typed).peel());
        if let (Item::Element(place), Rounds::Constant(count @ ..=MOST_NUMBERED), Some(first)) =
            (&source.item, &source.rounds, first.filter(|_| !is_keyed))
            && source.stages.is_empty()
            && !source.passes()
            && source.in_order != source.counts_down
            && (self.ty_of_variable(place).is_some_and(|ty| self.is_collection_of_references(ty))
                || self.is_left_in_a_round(id))
        {
            for number in 0..*count {
                let from = if source.counts_down { count - 1 - number } else { number };
                let value = Value { place: Some(place.element(IndexKey::Number(from))), ..Value::default() };
                self.place_part(collection.element(IndexKey::Number(first + number)), &value, typed);
            }
            return;
        }
        let new = collection.element(IndexKey::Data("the new element".into()));
        self.run_loop(CycleKind::Closure, self.span(id), None, source, |this, item, _| {
            let place = if is_keyed { item.place.as_ref().map(|pair| pair.field("1")) } else { item.place.clone() };
            this.place_part(new.clone(), &Value { place, ..item }, typed);
        });
    }

    /// The type of a place that is a variable as a whole.
    fn ty_of_variable(&self, place: &Place) -> Option<&Ty> {
        place.base_var().filter(|_| place.steps.is_empty()).map(|var| &self.graph.var(var).ty)
    }

    /// What becomes of the references in a collection where a method takes some of them out, or puts them in another order. Answers
    /// what the method gives.
    pub(super) fn leaves_collection(
        &mut self,
        id: ExprId,
        receiver: ExprId,
        method: &str,
        args: &[ExprId],
        collection: &Value,
    ) -> Option<Value> {
        let place = collection.place.clone().filter(|_| self.at.is_some())?;
        if !self.is_collection_of_references(self.ty(receiver).peel()) {
            return None;
        }
        let span = self.span(id);
        match method {
            "into" if self.is_collection_of_references(self.ty(id)) => self.converted_references(id, collection),
            "into_vec" if args.is_empty() => Some(Value { head: None, ..collection.clone() }),
            "drain" if let Some(source) = self.drained(receiver, args, &place, span) => {
                Some(self.iterator_value(source))
            }
            "pop"
            | "pop_front"
            | "pop_back"
            | "remove"
            | "swap_remove"
            | "drain"
            | "split_off"
            | "truncate"
            | "retain"
            | "retain_mut"
            | "dedup_by_key"
            | "pop_if"
            | "extract_if"
            | "split_first_chunk_mut"
            | "into"
            | "append"
            | "splice"
            | "concat"
            | "as_mut_slices"
            | "as_chunks_mut"
            | "choose_mut"
            | "iter_many_mut" => {
                for value in self.values(args) {
                    self.keep_closure(&value, span);
                }
                let element = self.lose_some(id, method, &place);
                let is_one = self.may_hold_filter(self.ty(id)) && !matches!(method, "split_off" | "drain" | "into");
                Some(Value { place: is_one.then_some(element), ..Value::default() })
            }
            _ => None,
        }
    }

    /// Some of the references in a collection are no longer there, or another one is in their place: data says which.
    pub(super) fn lose_some(&mut self, id: ExprId, method: &str, collection: &Place) -> Place {
        let element = collection.element(IndexKey::Data(method.into()));
        let cause = Cause::Index(self.text(id));
        self.emit(Effect::Unknown { places: vec![element.clone()], cause: cause.clone() }, self.span(id));
        self.graph.kept.push((element.clone(), cause));
        element
    }

    /// What a method puts before others gives these another number.
    pub(super) fn moves_others(
        &mut self,
        id: ExprId,
        receiver: ExprId,
        method: &str,
        args: &[ExprId],
        collection: &Value,
    ) {
        let Some(place) = &collection.place else { return };
        let ty = self.ty(receiver).peel();
        let is_before = method == "push_front" || method == "insert" && args.len() == 2;
        if self.at.is_some() && is_before && !is_map(ty) && self.is_collection_of_references(ty) {
            self.shuffle_references(id, receiver, place);
        }
    }

    /// The references in a collection change places: which of them is where is not known, and all of them are there.
    pub(super) fn shuffle_references(&mut self, id: ExprId, receiver: ExprId, collection: &Place) -> bool {
        let ty = self.ty(receiver).peel().clone();
        let is_such = self.at.is_some() && self.is_collection_of_references(&ty);
        if is_such {
            let taken = self.emptied_place(collection.clone(), ty, self.span(id));
            let source = Source { item: Item::Element(taken), ..Source::bounded() };
            self.pour(id, receiver, source, (collection, None));
        }
        is_such
    }

    /// A place is empty from here on, a collection or an element of one: what was in it has another name.
    fn emptied_place(&mut self, place: Place, ty: Ty, span: Span) -> Place {
        let taken = self.temporary(ty, span);
        let leaving = Value { place: Some(place), is_owned: true, leaves_by: Some(Transfer::Move), ..Value::default() };
        self.set(taken, &leaving, span);
        Place::var(taken)
    }

    /// `filters.drain(..)`
    pub(super) fn drained(&mut self, receiver: ExprId, args: &[ExprId], place: &Place, span: Span) -> Option<Source> {
        let ty = self.ty(receiver).peel().clone();
        if self.at.is_none() || is_map(&ty) || !self.is_full_range(args) || !self.is_collection_of_references(&ty) {
            return None;
        }
        let rounds = self.next_number(receiver).map_or(Rounds::Bounded, Rounds::Constant);
        let drained = self.emptied_place(place.clone(), ty, span);
        Some(Source { item: Item::Element(drained), rounds, ..Source::bounded() })
    }

    pub(super) fn is_full_range(&self, args: &[ExprId]) -> bool {
        let kind = |arg: &ExprId| &self.body().expr(*arg).kind;
        matches!(args, [arg] if matches!(kind(arg), ExprKind::Range { start: None, end: None, .. }))
    }

    /// `while let Some(filter) = filters.pop() { … }`: each of the references in a collection that was filled in the same round has a
    /// round, and none is left. Answers whether it is one.
    pub(super) fn loop_over_popped(
        &mut self,
        label: Option<&String>,
        keyword: Span,
        (pat, popped): (PatId, ExprId),
        body: ExprId,
    ) -> bool {
        let tree = self.body();
        let (ExprKind::MethodCall { receiver, method, args, .. }, PatKind::TupleStruct(_, parts)) =
            (&tree.expr(popped).kind, &tree.pat(pat).kind)
        else {
            return false;
        };
        let ([inner], true) = (parts.as_slice(), matches!(method.as_str(), "pop" | "pop_front" | "pop_back")) else {
            return false;
        };
        let ty = self.ty(*receiver).peel().clone();
        let Some(local) = self.typed().expr_local.get(receiver).copied() else { return false };
        if self.at.is_none() || !args.is_empty() || is_map(&ty) || !self.is_collection_of_references(&ty) {
            return false;
        }
        // What leaves a loop around this one leaves the collection as well.
        let is_outer = |other: &Option<String>| other.is_some() && other.as_ref() != label;
        let is_named = tree.within(body).any(|id| self.typed().expr_local.get(&id) == Some(&local));
        let is_stopped = tree
            .within(body)
            .any(|id| matches!(&tree.expr(id).kind, ExprKind::Break { label, .. } if !is_outer(label)));
        let is_left = tree.within(body).any(|id| match &tree.expr(id).kind {
            ExprKind::Return(_) | ExprKind::Try(_) => true,
            ExprKind::Break { label, .. } | ExprKind::Continue { label } => is_outer(label),
            _ => false,
        });
        let var = self.var_of(local);
        let info = self.graph.var(var);
        if is_named || info.param.is_some() || info.in_loop != self.loops.last().copied() {
            return false;
        }
        // Which of them were taken before the others tells how many there are.
        let count = self.next_number(*receiver);
        if (is_left || is_stopped) && count.is_none() {
            return false;
        }
        let from_the_end = method != "pop_front";
        let inner = *inner;
        if is_stopped {
            let is_plain = tree.within(body).all(|id| !tree.expr(id).kind.may_repeat());
            let count = count.filter(|count| is_plain && from_the_end && *count <= MOST_WRITTEN_OUT);
            let Some(count) = count else { return false };
            self.pop_one_by_one(label, keyword, (Place::var(var), count), (inner, popped), body);
            return true;
        }
        let drained = self.emptied_place(Place::var(var), ty, self.span(popped));
        let item = Item::Element(drained);
        let (is_filled, text) = (self.is_surely_entered(popped), self.text(popped));
        let rounds = count.map_or(Rounds::Bounded, Rounds::Constant);
        let source = Source { item: item.clone(), rounds, is_filled, text, ..Source::bounded() };
        let source = if from_the_end { source.reversed() } else { source };
        self.run_loop(CycleKind::While, keyword, label, source, |this, value, this_loop| {
            this.bind_item(this_loop, inner, &item, &value);
            this.expr(body);
        });
        true
    }

    /// The rounds of such a loop one behind the other, each with the last of the references that are left: where the loop is left, those
    /// before it are still there.
    fn pop_one_by_one(
        &mut self,
        label: Option<&String>,
        keyword: Span,
        (collection, count): (Place, u64),
        (pat, popped): (PatId, ExprId),
        body: ExprId,
    ) {
        let ty = match self.ty(popped) {
            Ty::External(_, args) => args.first().cloned().unwrap_or(Ty::Unknown),
            _ => Ty::Unknown,
        };
        let span = self.span(popped);
        self.write_out(label, keyword, body, (0..count).rev(), |this, number| {
            let last = this.emptied_place(collection.element(IndexKey::Number(number)), ty.clone(), span);
            this.bind_pattern(pat, &Value { place: Some(last), ..Value::default() });
        });
    }

    /// Whether a variable refers to what refers to filters itself: `let slot = &mut self.slots[0];`
    pub(super) fn refers_to_references(&self, var: Var) -> bool {
        matches!(&self.graph.var(var).ty, Ty::Ref(true, inner) if self.program.index.refers_to_filters(inner))
    }

    /// Whether a value of the type is an option that refers to a filter, if there is one.
    pub(super) fn is_option_of_references(&self, ty: &Ty) -> bool {
        ty.external_name() == Some("Option") && self.program.index.refers_to_filters(ty)
    }

    /// Whether a value of the type is a collection whose elements refer to filters.
    pub(super) fn is_collection_of_references(&self, ty: &Ty) -> bool {
        let index = self.program.index;
        match ty {
            Ty::Array(element, _) | Ty::Slice(element) => index.refers_to_filters(element),
            Ty::External(_, args) if ty.external_name() == Some("Box") => {
                args.first().is_some_and(|inner| self.is_collection_of_references(inner))
            }
            Ty::External(_, args) => {
                let holds_many = |name: &str| {
                    name.ends_with("Map")
                        || matches!(name, "Vec" | "VecDeque" | "LinkedList" | "ArrayVec" | "SmallVec" | "BinaryHeap")
                };
                ty.external_name().is_some_and(holds_many)
                    && args.iter().any(|element| index.refers_to_filters(element))
            }
            _ => false,
        }
    }
}
