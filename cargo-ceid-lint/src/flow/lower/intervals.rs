//! Values that are compared with several numbers: which of the intervals between these a comparison holds for, so that those that
//! exclude one another are told to.

use std::cmp::Ordering;

use super::Builder;
use super::closures::is_named;
use super::questions::grouped;
use super::subjects::Pure;
use crate::flow::test::MAX_HEADS;
use crate::flow::{About, Effect, Head, NodeId, Place, SubjectId, Var};
use crate::index::Ty;
use crate::source::Span;
use crate::syntax::tree::{ExprId, ExprKind};
use crate::types::Callee;

/// A question about a value that numbers answer.
#[derive(Clone, Debug)]
pub(super) struct Bound {
    value: Pure,
    is_float: bool,
    /// Whether it is never less than zero.
    is_natural: bool,
    asks: Asks,
}

/// What is asked about a value.
#[derive(Clone, Debug)]
enum Asks {
    /// How it stands to a number.
    Order {
        number: f64,
        /// Whether the number stands on the left.
        is_turned: bool,
        /// Whether a comparison of whole numbers holds where they are equal.
        is_closed: bool,
    },
    /// Whether it lies between two numbers, or is the last one.
    Range { first: Option<f64>, last: Option<f64>, is_closed: bool },
    /// Which of these numbers it is.
    Number(Vec<f64>),
}

/// What a value may be: less than all numbers, one of them, more than one and less than the next, or no number.
#[derive(Clone, Copy, Debug)]
enum Part {
    Below,
    At(usize),
    Above(usize),
    Unordered,
}

impl Builder<'_> {
    /// Notes that a comparison asks how a plain value stands to a number that is written out.
    pub(super) fn note_number(&mut self, subject: SubjectId, op: &str, lhs: ExprId, rhs: ExprId) {
        if !matches!(op, "<" | "<=" | ">" | ">=") {
            return;
        }
        let numbers = [lhs, rhs].map(|id| self.constants().written_number(id));
        let (value, number, is_turned) = match numbers {
            [None, Some(number)] => (lhs, number, false),
            [Some(number), None] => (rhs, number, true),
            _ => return,
        };
        let is_float = match self.ty(value) {
            Ty::Float => true,
            Ty::Int => false,
            _ => return,
        };
        if !self.is_plain_number(value) {
            return;
        }
        let is_natural = self.is_length(value) || self.int_of(value).is_some_and(|int| int.starts_with('u'));
        let Some(value) = self.pure(value).filter(|value| !value.reads.is_empty()) else { return };
        // `a > b` is asked as `a <= b`.
        let is_closed = matches!(op, "<=" | ">");
        let asks = Asks::Order { number, is_turned, is_closed };
        self.bounds.insert(subject, Bound { value, is_float, is_natural, asks });
    }

    /// `(50..80).contains(&level)`: asks for the range as a pattern does. Answers whether it is such a question.
    pub(super) fn range_condition(&mut self, id: ExprId, receiver: ExprId, args: &[ExprId], no: NodeId) -> bool {
        let ExprKind::Range { start, end, inclusive } = self.body().expr(receiver).kind else { return false };
        let [arg] = args else { return false };
        let ExprKind::Reference { value, .. } = self.body().expr(*arg).kind else { return false };
        let ends = [start, end];
        let is_written = ends.iter().flatten().all(|end| self.constants().written_number(*end).is_some());
        if !is_written || !self.is_plain_number(value) {
            return false;
        }
        let Some(pure) = self.pure(value) else { return false };
        let (span, text, about) = (self.span(id), self.text(id), self.about(value));
        self.expr(value);
        self.ask_range((ends, inclusive), &pure, &about, (span, &text), no);
        true
    }

    /// Asks whether a value lies between two ends, and may be the last one.
    pub(super) fn ask_range(
        &mut self,
        (ends, is_closed): ([Option<ExprId>; 2], bool),
        value: &Pure,
        about: &About,
        (span, text): (Span, &str),
        no: NodeId,
    ) {
        if self.at.is_none() {
            return;
        }
        let heads = ["true", "false"].map(str::to_owned);
        let numbers = ends.map(|end| end.map(|end| self.constants().written_number(end)));
        let [first, last] = [0, 1].map(|at| match (numbers[at].flatten(), ends[at]) {
            (Some(number), _) => number.to_string(),
            (None, Some(end)) => self.text(end),
            (None, None) => String::new(),
        });
        let dots = if is_closed { "..=" } else { ".." };
        let key = format!("({} in {first}{dots}{last})", value.key);
        let asked = Pure { key, reads: value.reads.clone(), whole: None };
        let id = self.subject(asked, Some(heads.to_vec()));
        for head in &heads {
            self.head_bit(id, head);
        }
        let (yes, failed) = self.branch_on_subject(id, &heads[..1], true, span, text.to_owned(), about.clone());
        self.link(failed, no);
        self.resume(yes);
        let is_float = ends.iter().flatten().any(|end| *self.ty(*end) == Ty::Float);
        if numbers.iter().all(|end| *end != Some(None)) {
            let [first, last] = numbers.map(Option::flatten);
            let asks = Asks::Range { first, last, is_closed };
            self.bounds.insert(id, Bound { value: value.clone(), is_float, is_natural: false, asks });
        }
    }

    /// Whether an expression is a variable, a field, an element, a length or how far a number is from zero: a cast may give another number.
    fn is_plain_number(&self, id: ExprId) -> bool {
        match &self.body().expr(id).kind {
            ExprKind::MethodCall { receiver, method, args, .. } if args.is_empty() => {
                method == "abs" && self.is_plain_number(*receiver) || self.is_length(id)
            }
            // Of another element, or behind another number, it is another value: what it reads says so.
            ExprKind::Field { base, .. } | ExprKind::Index { base, .. } => self.is_plain_number(*base),
            _ => is_named(self.body(), id),
        }
    }

    fn is_length(&self, id: ExprId) -> bool {
        matches!(&self.body().expr(id).kind, ExprKind::MethodCall { method, .. } if method == "len")
            && matches!(self.typed().callees.get(&id), Some(Callee::Builtin))
    }

    /// Asks all comparisons of one value with several numbers in which of the intervals it is.
    pub(super) fn settle_bounds(&mut self) {
        let asked = std::mem::take(&mut self.bounds);
        for mut bounds in grouped(asked, |bound| bound.value.key.clone()).into_values() {
            let Some((_, Bound { value, is_float, .. })) = bounds.first().cloned() else { continue };
            let is_natural = bounds.iter().any(|(_, bound)| bound.is_natural);
            bounds.extend(self.asked_for_numbers(&value).filter(|_| !is_float));
            let Some(numbers) = several_numbers(&bounds) else { continue };
            let parts = parts(&numbers, is_float, is_natural);
            if parts.len() > MAX_HEADS {
                continue;
            }
            let heads: Vec<Head> = parts.iter().map(|part| format!("{part:?}")).collect();
            let key = format!("({} among {numbers:?})", value.key);
            let among = Pure { key, reads: value.reads, whole: None };
            self.ask_as_one(among, &heads, &bounds, |bound, at| bound.head(&numbers, parts[at]));
        }
    }

    /// Whether a variable holds what something gave of which nothing is known.
    fn is_unread(&self, var: Var) -> bool {
        self.graph.nodes.iter().all(|node| match &node.effect {
            Effect::Set(set) | Effect::Write(set) => set.place.base_var() != Some(var),
            Effect::Call(site) => site.result != var || site.targets.is_empty(),
            _ => true,
        })
    }

    /// The question which of several numbers a value is, where nothing gives it one of them.
    fn asked_for_numbers(&self, value: &Pure) -> Option<(SubjectId, Bound)> {
        let id = *self.subjects.get(&value.key)?;
        let heads = &self.graph.subjects[id.0 as usize].heads;
        let numbers: Vec<f64> = heads.iter().map(|head| head.parse().ok()).collect::<Option<_>>()?;
        let gives = |effect: &Effect| match (effect, &value.whole) {
            (Effect::Set(set) | Effect::Write(set), Some(whole)) => {
                let is_told = set.head.is_some() || set.same_as.is_some_and(|from| !self.is_unread(from));
                set.place.overlaps(whole) && (is_told || !set.rebinds)
            }
            _ => false,
        };
        let is_counter = value.whole.as_ref().and_then(Place::base_var).is_some_and(|var| self.is_counter(var));
        let is_given = is_counter || self.graph.nodes.iter().any(|node| gives(&node.effect));
        let asks = Asks::Number(numbers);
        let bound = Bound { value: value.clone(), is_float: false, is_natural: false, asks };
        (!heads.is_empty() && !is_given).then_some((id, bound))
    }
}

impl Bound {
    /// The spelling of the value that is asked about.
    pub(super) fn key(&self) -> &str {
        &self.value.key
    }

    /// The same question about another value.
    pub(super) fn of(&self, value: Pure) -> Self {
        Self { value, ..self.clone() }
    }

    /// Whether a whole number is asked about that has this place.
    pub(super) fn is_of(&self, place: &Place) -> bool {
        !self.is_float && self.value.whole.as_ref() == Some(place)
    }

    /// The numbers that the answer depends on, as far as they are whole and not less than zero.
    pub(super) fn whole_numbers(&self) -> impl Iterator<Item = Option<u64>> {
        self.numbers().into_iter().map(|number| format!("{number}").parse().ok())
    }

    /// The head that the subject of the question has where the value is a number; `last` is the greatest that anything asks for.
    pub(super) fn at(&self, last: u64, number: usize) -> Head {
        self.head(&up_to(last), Part::At(number))
    }

    /// The same where it is none of these numbers.
    pub(super) fn beyond(&self, last: u64) -> Vec<Head> {
        let numbers = up_to(last);
        let below = (!self.is_natural).then_some(Part::Below);
        below.into_iter().chain([Part::Above(numbers.len() - 1)]).map(|part| self.head(&numbers, part)).collect()
    }

    /// The numbers that the answer depends on.
    fn numbers(&self) -> Vec<f64> {
        match &self.asks {
            Asks::Order { number, .. } => vec![*number],
            Asks::Range { first, last, .. } => first.iter().chain(last).copied().collect(),
            Asks::Number(numbers) => numbers.clone(),
        }
    }

    /// The head that the subject of the question has where the value is in a part of the numbers.
    fn head(&self, numbers: &[f64], part: Part) -> Head {
        let order = |number: f64| {
            let own = numbers.iter().position(|known| *known == number).unwrap_or_default();
            match part {
                Part::Below => Some(Ordering::Less),
                Part::At(at) => Some(at.cmp(&own)),
                Part::Above(at) if at >= own => Some(Ordering::Greater),
                Part::Above(_) => Some(Ordering::Less),
                Part::Unordered => None,
            }
        };
        match &self.asks {
            Asks::Order { number, is_turned, is_closed } => {
                let Some(order) = order(*number) else { return "unordered".to_owned() };
                let order = if *is_turned { order.reverse() } else { order };
                match (self.is_float, order) {
                    (true, Ordering::Less) => "less".to_owned(),
                    (true, Ordering::Equal) => "equal".to_owned(),
                    (true, Ordering::Greater) => "greater".to_owned(),
                    (false, Ordering::Less) => "true".to_owned(),
                    (false, Ordering::Equal) => is_closed.to_string(),
                    (false, Ordering::Greater) => "false".to_owned(),
                }
            }
            Asks::Range { first, last, is_closed } => {
                let begins = first.is_none_or(|first| order(first).is_some_and(Ordering::is_ge));
                let is_before = |order: Ordering| order.is_lt() || *is_closed && order.is_eq();
                (begins && last.is_none_or(|last| order(last).is_some_and(is_before))).to_string()
            }
            Asks::Number(own) => {
                let is_it = |number: &&f64| order(**number) == Some(Ordering::Equal);
                own.iter().find(is_it).map_or_else(String::new, f64::to_string)
            }
        }
    }
}

/// All whole numbers up to one.
fn up_to(last: u64) -> Vec<f64> {
    let mut numbers = vec![0.0];
    numbers.extend((0..last).scan(0.0, |number, _| {
        *number += 1.0;
        Some(*number)
    }));
    numbers
}

/// The numbers that a value is compared with, in their order, where there are several of them or several kinds of questions. What
/// differs by less than a small float can tell is not put in order.
fn several_numbers(bounds: &[(SubjectId, Bound)]) -> Option<Vec<f64>> {
    let mut numbers: Vec<f64> = bounds.iter().flat_map(|(_, bound)| bound.numbers()).collect();
    numbers.sort_by(f64::total_cmp);
    numbers.dedup();
    let is_apart = |pair: &[f64]| pair[1] - pair[0] > 1e-6 * pair[0].abs().max(pair[1].abs());
    let is_order = |(_, bound): &(SubjectId, Bound)| matches!(bound.asks, Asks::Order { .. });
    let are_several = bounds.len() > 1 && (numbers.len() > 1 || !bounds.iter().all(is_order));
    (are_several && numbers.windows(2).all(is_apart)).then_some(numbers)
}

/// The parts into which numbers divide all that a value can be.
fn parts(numbers: &[f64], is_float: bool, is_natural: bool) -> Vec<Part> {
    let is_least = is_natural && numbers.first().is_some_and(|first| *first == 0.0);
    let mut parts: Vec<Part> = (!is_least).then_some(Part::Below).into_iter().collect();
    for (at, number) in numbers.iter().enumerate() {
        parts.push(Part::At(at));
        // There is no whole number between two that follow one another.
        let is_empty = !is_float && numbers.get(at + 1).is_some_and(|next| *next == number + 1.0);
        if !is_empty {
            parts.push(Part::Above(at));
        }
    }
    if is_float {
        parts.push(Part::Unordered);
    }
    parts
}
