//! Iterators that are made in one place and consumed in another, or nowhere: nothing of them runs before.

use std::rc::Rc;

use super::sources::{Item, Source};
use super::stored::Holder;
use super::{Builder, Value};
use crate::flow::{Cause, Effect, IndexKey, Place, Rounds, UnrunKind, Var};
use crate::index::{TraitName, Ty};
use crate::source::Span;
use crate::syntax::tree::ExprId;
use crate::types::is_lock;

impl Builder<'_> {
    /// An adaptor of an iterator: what it runs over is known, and nothing runs yet. `None` if the call is something else.
    pub(super) fn lazy_call(&mut self, id: ExprId, receiver: ExprId, method: &str) -> Option<Value> {
        if !is_adaptor(method) || !self.iterates(self.ty(receiver)) {
            return None;
        }
        let source = self.source(id);
        self.note_lent_elements(&source, receiver, method);
        Some(self.iterator_value(source))
    }

    /// Whoever consumes the iterator would do something to each element; where nobody does, they are in use all the same.
    fn note_lent_elements(&mut self, source: &Source, receiver: ExprId, method: &str) {
        if source.stages.is_empty() || self.at.is_none() {
            return;
        }
        let Ty::External(_, args) = self.ty(receiver) else { return };
        let mut lent = Vec::new();
        if let Some(ty) = args.first() {
            self.add_lent_elements(&source.item, ty, &mut lent);
        }
        if let Some(closure) = source.stages.last().and_then(|stage| stage.closure()) {
            let places = lent.iter().cloned().chain(self.captured_to_update(closure)).collect();
            self.note_unrun(closure, UnrunKind::Iterator(method.to_owned()), places);
        }
        for element in lent {
            self.graph.lent.push(element.clone());
            self.emit(Effect::Use { place: element }, self.span(receiver));
        }
    }

    /// Finds the elements that an item of this type lends, also beside others: `bank.iter_mut().zip(samples)`.
    fn add_lent_elements(&self, item: &Item, ty: &Ty, found: &mut Vec<Place>) {
        match (item, ty) {
            (Item::Element(place), Ty::Ref(true, own)) if self.may_hold_filter(own) => {
                found.push(place.element(IndexKey::Each));
            }
            (Item::Tuple(items), Ty::Tuple(tys)) => {
                for (item, ty) in items.iter().zip(tys) {
                    self.add_lent_elements(item, ty, found);
                }
            }
            _ => {}
        }
    }

    /// An iterator that is made here.
    pub(super) fn iterator_value(&self, source: Source) -> Value {
        let made_in = self.loops.last().copied();
        Value { iterator: Some(Rc::new(Source { made_in, ..source })), ..Value::default() }
    }

    /// An iterator over all elements of a collection stands for the collection where it is given back.
    pub(super) fn lent_on(&self, value: Value) -> Value {
        match value.iterator.as_deref() {
            Some(Source { item: Item::Element(place), stages, passes_over: false, is_choice: false, .. })
                if stages.is_empty() =>
            {
                Value { place: Some(place.clone()), ..Value::default() }
            }
            _ => value,
        }
    }

    /// A value that is one iterator on this way and another one on a way before.
    pub(super) fn note_choice(&mut self, var: Var, before: Option<Rc<Source>>) {
        let Some(before) = before else { return };
        let mut both = Source { is_choice: true, ..Source::clone(&before) };
        if let Some(now) = self.iterators.get(&var) {
            both.item = Item::OneOf(vec![before.item.clone(), now.item.clone()]);
            both.stages.extend(now.stages.iter().copied());
        }
        self.iterators.insert(var, Rc::new(both));
    }

    /// What the entries or values of a map are as an iterator.
    pub(super) fn map_items(&self, method: &str, value: &Value) -> Value {
        let item = value.place.clone().map_or(Item::Opaque, Item::entry);
        let item = if method.contains("values") { item.values() } else { item };
        self.iterator_value(Source { item, ..Source::bounded() })
    }

    /// An iterator that goes on elsewhere: which of its elements are left is not known.
    pub(super) fn part_of(&mut self, id: ExprId, receiver: ExprId) -> Source {
        let source = self.source(receiver);
        let value = self.iterator_value(source.clone());
        self.keep_iterator(&value, &Cause::Index(self.text(id)), self.span(id));
        let item = if source.item.is_lent() { Item::Opaque } else { source.item };
        Source { item, stages: Vec::new(), ..source }
    }

    /// What `next` gives: one of the elements, and which one is not known.
    pub(super) fn next_item(&mut self, id: ExprId, value: &Value) -> Value {
        let key = IndexKey::Data(self.text(id).into());
        let place = match value.iterator.as_deref() {
            Some(Source { item: Item::Element(place), stages, .. }) if stages.is_empty() => Some(place.clone()),
            Some(_) => {
                self.keep_iterator(value, &Cause::Index(self.text(id)), self.span(id));
                None
            }
            None => value.place.clone(),
        };
        Value { place: place.map(|place| place.element(key)), ..Value::default() }
    }

    /// What an iterator does that the function was lent is not seen: it may write cells that others know.
    pub(super) fn note_foreign_iterator(&mut self, id: ExprId, receiver: ExprId, method: &str, value: &Value) {
        let base = value.place.as_ref().and_then(Place::base_var);
        let is_given = value.iterator.is_none() && base.is_some_and(|var| self.graph.var(var).param.is_some());
        if method.starts_with("next") && is_given && self.iterates(self.ty(receiver)) {
            self.emit(Effect::Unknown { places: Vec::new(), cause: Cause::Call(self.text(id)) }, self.span(id));
        }
    }

    /// Whether the adaptors of an iterator only look at its items.
    pub(super) fn may_look_ahead(&self, receiver: ExprId, value: &Value) -> bool {
        self.iterates(self.ty(receiver)) && value.iterator.as_deref().is_none_or(Source::keeps_items)
    }

    /// `peek` on such an iterator. What it runs for the next item, the consumer does not run again.
    pub(super) fn look_ahead(&mut self, id: ExprId, value: &Value) -> Value {
        let stages = value.iterator.iter().flat_map(|source| &source.stages);
        for closure in stages.filter_map(|stage| stage.closure()).collect::<Vec<_>>() {
            self.closure_for_unseen(closure, Holder::Code(None), Cause::Call(self.text(id)), self.span(id));
        }
        Value::default()
    }

    /// Notes that some items are taken of an iterator that has a name.
    pub(super) fn note_advanced(&mut self, id: ExprId) {
        let Some(local) = self.typed().expr_local.get(&id).copied() else { return };
        let var = self.var_of(local);
        let source = match self.iterators.get(&var) {
            Some(source) => Source::clone(source),
            // An iterator over a whole collection goes by the collection's name.
            None if self.iterates(self.ty(id)) && self.may_hold_filter(self.ty(id)) => Source {
                item: Item::Element(Place::var(var)),
                made_in: self.loops.last().copied(),
                ..Source::bounded()
            },
            None => return,
        };
        self.iterators.insert(var, Rc::new(Source { is_advanced: true, ..source }));
    }

    /// Whether the body of a loop over an iterator that has a name takes items of it by itself.
    pub(super) fn is_advanced_in(&self, id: ExprId, body: ExprId) -> bool {
        let Some(local) = self.typed().expr_local.get(&id) else { return false };
        self.body().within(body).any(|at| self.typed().expr_local.get(&at) == Some(local))
    }

    /// Whether an iterator that has a name is named nowhere else, so that nothing gets what is left of it.
    pub(super) fn is_last_use(&self, id: ExprId) -> bool {
        let typed = self.typed();
        typed
            .expr_local
            .get(&id)
            .is_some_and(|local| typed.expr_local.values().filter(|own| *own == local).count() == 1)
    }

    /// The chunks of what an iterator runs over. What is left behind chunks of one size is in none of them.
    pub(super) fn chunked(&mut self, id: ExprId, method: &str, args: &[ExprId], source: Source) -> Source {
        let size = args.first().and_then(|arg| {
            self.expr(*arg);
            self.number(*arg)
        });
        let is_exact = method.contains("exact");
        let rounds = match (&source.rounds, size.filter(|size| *size > 0)) {
            (Rounds::Unbounded, _) => Rounds::Unbounded,
            (Rounds::Constant(all), Some(size)) if is_exact => Rounds::Constant(all / size),
            (Rounds::Constant(all), Some(size)) => Rounds::Constant(all.div_ceil(size)),
            _ => Rounds::Bounded,
        };
        let Item::Element(place) = source.item.clone() else { return Source { rounds, ..source } };
        let source = Source { item: Item::Chunk(place), rounds, ..source };
        if !is_exact {
            return source;
        }
        let length = source.length.as_ref().and_then(|length| length.value);
        match length.zip(size.filter(|size| *size > 0)) {
            Some((length, size)) => Source { passes_over: source.passes_over || length % size > 0, ..source },
            None => {
                let value = self.iterator_value(source);
                self.keep_iterator(&value, &Cause::Index(self.text(id)), self.span(id));
                Source::bounded()
            }
        }
    }

    /// Whether a type of the analysed code is an iterator, and a filter in it may be updated for each of its items.
    pub(super) fn draws_by_itself(&self, ty: &Ty) -> bool {
        let index = self.program.index;
        let is_std = |name: &TraitName| matches!(name, TraitName::External(path) if path.ends_with("::Iterator"));
        matches!(ty.peel(), Ty::Adt(..))
            && index.holds_filter(ty.peel())
            && index.methods(ty.peel(), "next").iter().any(|owner| owner.of_trait().is_some_and(is_std))
    }

    /// Whether a value of the type is an iterator.
    pub(super) fn iterates(&self, ty: &Ty) -> bool {
        let bounds = match ty.peel() {
            Ty::Param(param) => &param.bounds,
            Ty::Opaque(bounds) => bounds.as_ref(),
            ty => return matches!(ty.external_name(), Some("Iterator" | "Range")),
        };
        bounds.iter().any(|bound| matches!(&bound.name, TraitName::External(path) if path.ends_with("::Iterator")))
    }

    /// Whether an iterator over a collection by shared references updates none of its filters.
    pub(super) fn lends_shared(&self, collection: ExprId) -> bool {
        let (index, ty) = (self.program.index, self.ty(collection).peel());
        index.holds_filter(ty) && index.shares_no_filter(ty, is_lock)
    }

    /// Whether a value of the type is an iterator over references through which no filter is updated.
    pub(super) fn iterates_shared(&self, ty: &Ty) -> bool {
        let is_shared = |item: &Ty| match item {
            Ty::Ref(false, inner) => self.program.index.shares_no_filter(inner, is_lock),
            item => matches!(item, Ty::Int | Ty::Float | Ty::Bool),
        };
        match ty.peel() {
            Ty::External(path, args) if path.ends_with("::Iterator") => match args.as_slice() {
                [Ty::Tuple(parts)] => parts.iter().all(is_shared),
                items => items.iter().all(is_shared),
            },
            _ => false,
        }
    }

    /// An iterator that is put or handed somewhere, from where it may be consumed or not.
    pub(super) fn keep_iterator(&mut self, value: &Value, cause: &Cause, span: Span) {
        let Some(source) = value.iterator.clone() else { return };
        let (mut places, mut closures) = (Vec::new(), Vec::new());
        lent_places(&source.item, &mut places, &mut closures);
        closures.extend(source.stages.iter().filter_map(|stage| stage.closure()));
        places.extend(source.stages.iter().filter_map(|stage| stage.state()).map(Place::var));
        if !places.is_empty() && !source.is_shared && self.at.is_some() {
            self.emit(Effect::Unknown { places, cause: cause.clone() }, span);
        }
        for closure in closures {
            self.closure_for_unseen(closure, Holder::Code(None), cause.clone(), span);
        }
    }
}

/// The places whose elements an iterator gives, and the closures that make something of them.
fn lent_places(item: &Item, found: &mut Vec<Place>, closures: &mut Vec<super::ClosureRef>) {
    match item {
        Item::Element(place) | Item::Chunk(place) | Item::Same(place) | Item::Beside(place, _) => {
            found.push(place.clone());
        }
        Item::Tuple(items) | Item::OneOf(items) | Item::Chained(items) => {
            for item in items {
                lent_places(item, found, closures);
            }
        }
        Item::Present(item) => lent_places(item, found, closures),
        Item::Staged(item, stages) => {
            closures.extend(stages.iter().filter_map(|stage| stage.closure()));
            found.extend(stages.iter().filter_map(|stage| stage.state()).map(Place::var));
            lent_places(item, found, closures);
        }
        Item::Opaque | Item::Drawn(..) | Item::Counter(_) | Item::Made => {}
    }
}

/// Whether a method of an iterator gives another iterator and runs nothing.
fn is_adaptor(method: &str) -> bool {
    matches!(
        method,
        "map"
            | "filter"
            | "filter_map"
            | "flat_map"
            | "inspect"
            | "scan"
            | "take_while"
            | "skip_while"
            | "map_while"
            | "zip"
            | "chain"
            | "enumerate"
            | "rev"
            | "take"
            | "skip"
            | "step_by"
            | "cycle"
            | "copied"
            | "cloned"
            | "peekable"
            | "fuse"
            | "par_bridge"
            | "with_min_len"
            | "with_max_len"
    )
}
