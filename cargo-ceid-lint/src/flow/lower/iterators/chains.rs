//! Iterators one behind another: `bank.iter_mut().chain(once(&mut spare).filter(|lag| lag.is_on))`. Each keeps its own closures.

use super::super::sources::{Item, Source, Stage};
use super::super::{Builder, Value};
use super::Begun;
use crate::flow::{About, Cause, LoopId, NodeId, Rounds, Var};
use crate::index::Ty;
use crate::source::Span;
use crate::syntax::tree::ExprId;

impl Builder<'_> {
    /// One iterator after the other.
    pub(super) fn chain(&mut self, receiver: ExprId, args: &[ExprId]) -> Source {
        let source = self.source(receiver);
        let other = args.first().map_or_else(Source::bounded, |arg| self.source(*arg));
        let rounds = match (&source.rounds, &other.rounds) {
            (Rounds::Unbounded, _) | (_, Rounds::Unbounded) => Rounds::Unbounded,
            (Rounds::Constant(a), Rounds::Constant(b)) => Rounds::Constant(a.saturating_add(*b)),
            _ => Rounds::Bounded,
        };
        let item = source.item.or(&other.item);
        if let Some(item) = item.filter(|_| source.stages.is_empty() && other.stages.is_empty()) {
            let passes_over = source.passes() || other.passes();
            return Source { item, rounds, passes_over, in_order: false, ..Source::bounded() };
        }
        if !source.goes_on_behind() || !other.goes_on_behind() {
            let passes_over = source.passes() || other.passes();
            for source in [source, other] {
                self.keep_chained(source, self.span(receiver));
            }
            return Source { rounds, passes_over, in_order: false, ..Source::bounded() };
        }
        let counts_items =
            |source: &Source| source.stages.iter().all(|stage| matches!(stage, Stage::Map(_) | Stage::Inspect(_)));
        let rounds = match rounds {
            Rounds::Constant(_) if !counts_items(&source) || !counts_items(&other) => Rounds::Bounded,
            rounds => rounds,
        };
        let passes_over = source.passes_over || other.passes_over;
        let leaves_out = source.leaves_out || other.leaves_out;
        let items = [source, other].into_iter().flat_map(Source::behind_others).collect();
        Source { item: Item::Chained(items), rounds, passes_over, leaves_out, in_order: false, ..Source::bounded() }
    }

    /// An iterator that is one behind another, and goes on where that cannot be followed.
    fn keep_chained(&mut self, source: Source, span: Span) {
        let value = Value { iterator: Some(std::rc::Rc::new(source)), ..Value::default() };
        self.keep_iterator(&value, &Cause::Code("a chain of iterators".to_owned()), span);
    }

    /// What an expression gives, where nothing is made of the items of several iterators one behind another.
    pub(super) fn unchained(&mut self, id: ExprId) -> Source {
        let source = self.source(id);
        if !matches!(source.item, Item::Chained(_)) {
            return source;
        }
        self.keep_chained(source.clone(), self.span(id));
        Source { item: Item::Opaque, stages: Vec::new(), ..source }
    }

    /// The item of a round that is one of those of several iterators, what its filters leave out without one; and whether all that is
    /// left out has a round all the same.
    pub(super) fn one_behind_another(&mut self, begun: &Begun, items: &[Item], reads: &[Var]) -> (Value, bool) {
        let mut are_rounds = true;
        let value = self.each_of_chained(begun.id, items, begun.keyword, |this, item| match item {
            Item::Staged(inner, stages) => {
                let value = this.item_value(begun.id, inner, reads, begun.keyword);
                let begun = Begun { counts_items: false, ..*begun };
                let (value, _, is_round) = this.run_stages(&begun, inner, stages, value);
                are_rounds &= is_round || !stages.iter().any(|stage| matches!(stage, Stage::Filter(_)));
                value
            }
            item => this.item_value(begun.id, item, reads, begun.keyword),
        });
        (value, are_rounds)
    }

    /// The same beside other items, where what is left out leaves a gap.
    pub(super) fn one_of_chained(&mut self, id: LoopId, items: &[Item], reads: &[Var], span: Span) -> Value {
        self.each_of_chained(id, items, span, |this, item| this.item_value(id, item, reads, span))
    }

    /// A way for each of the iterators of which the item may be.
    fn each_of_chained(
        &mut self,
        id: LoopId,
        items: &[Item],
        span: Span,
        mut made: impl FnMut(&mut Self, &Item) -> Value,
    ) -> Value {
        let join = self.new_join(Ty::Unknown, span);
        let last = items.len().saturating_sub(1);
        for (number, item) in items.iter().enumerate() {
            if self.at.is_none() {
                break;
            }
            let (begin, others): (Option<NodeId>, Option<NodeId>) = match number < last {
                true => {
                    let text = "the item is of this iterator".to_owned();
                    let (own, others) = self.opaque_branch(span, text, About::default());
                    (Some(own), Some(others))
                }
                false => (self.at, None),
            };
            self.at = begin;
            let before = self.graph.loop_info(id).items.len();
            let value = made(self, item);
            let info = &mut self.graph.loops[id.0 as usize];
            let own = info.items[before..].iter().map(|(var, _)| *var).collect();
            info.chained.extend(begin.map(|begin| (begin, own)));
            self.end_branch(&join, &value, span);
            self.at = others;
        }
        self.close_join(&join)
    }
}

impl Source {
    /// Whether it may be one of several that go one behind another: none of its closures ends the iteration or counts the items.
    fn goes_on_behind(&self) -> bool {
        let goes_on =
            |stage: &Stage| matches!(stage, Stage::Map(_) | Stage::Filter(_) | Stage::Inspect(_) | Stage::Flatten(_));
        !self.is_choice && !self.is_advanced && self.stages.iter().all(goes_on)
    }

    /// Its items among those of other iterators.
    fn behind_others(self) -> Vec<Item> {
        match self.item {
            Item::Chained(items) if self.stages.is_empty() => items,
            _ => vec![Self { item: self.item.uncounted(), ..self }.staged()],
        }
    }

    /// Whether closures run for its items.
    pub(super) fn has_closures(&self) -> bool {
        !self.stages.is_empty() || self.item.has_closures()
    }
}

impl Item {
    /// The same where the number of the round is not its own.
    fn uncounted(self) -> Self {
        match self {
            Self::Counter(_) => Self::Opaque,
            Self::Tuple(items) => Self::Tuple(items.into_iter().map(Self::uncounted).collect()),
            Self::Staged(item, stages) => Self::Staged(Box::new(item.uncounted()), stages),
            Self::Present(item) => Self::Present(Box::new(item.uncounted())),
            other => other,
        }
    }

    fn has_closures(&self) -> bool {
        match self {
            Self::Staged(..) => true,
            Self::Tuple(items) | Self::OneOf(items) | Self::Chained(items) => items.iter().any(Self::has_closures),
            Self::Present(item) => item.has_closures(),
            _ => false,
        }
    }
}
