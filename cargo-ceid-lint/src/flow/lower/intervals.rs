//! Values that are compared with several numbers: which of the intervals between these a comparison holds for, so that those that
//! exclude one another are told to.

use std::cmp::Ordering;
use std::collections::BTreeMap;

use super::Builder;
use super::closures::is_named;
use super::subjects::Pure;
use crate::flow::test::MAX_HEADS;
use crate::flow::{Effect, Head, SubjectId};
use crate::index::Ty;
use crate::syntax::tree::{ExprId, ExprKind};

/// A comparison of a value with a number.
#[derive(Clone, Debug)]
pub(super) struct Bound {
    value: Pure,
    is_float: bool,
    number: f64,
    /// Whether the number stands on the left.
    is_turned: bool,
    /// Whether a comparison of whole numbers holds where they are equal.
    is_closed: bool,
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
        let Some(value) = self.pure(value).filter(|value| !value.reads.is_empty()) else { return };
        // `a > b` is asked as `a <= b`.
        let is_closed = matches!(op, "<=" | ">");
        self.bounds.insert(subject, Bound { value, is_float, number, is_turned, is_closed });
    }

    /// Whether an expression is a variable, a field or how far that is from zero: a cast may give another number.
    fn is_plain_number(&self, id: ExprId) -> bool {
        match &self.body().expr(id).kind {
            ExprKind::MethodCall { receiver, method, args, .. } => {
                method == "abs" && args.is_empty() && self.is_plain_number(*receiver)
            }
            _ => is_named(self.body(), id),
        }
    }

    /// Asks all comparisons of one value with several numbers in which of the intervals it is.
    pub(super) fn settle_bounds(&mut self) {
        let mut of_value: BTreeMap<String, Vec<(SubjectId, Bound)>> = BTreeMap::new();
        for (id, bound) in std::mem::take(&mut self.bounds) {
            of_value.entry(bound.value.key.clone()).or_default().push((id, bound));
        }
        for bounds in of_value.into_values() {
            let Some(numbers) = several_numbers(&bounds) else { continue };
            let Some((_, Bound { value, is_float, .. })) = bounds.first() else { continue };
            let parts = parts(&numbers, *is_float);
            if parts.len() > MAX_HEADS {
                continue;
            }
            let heads: Vec<Head> = parts.iter().map(|part| format!("{part:?}")).collect();
            let key = format!("({} among {numbers:?})", value.key);
            let among = self.subject(Pure { key, reads: value.reads.clone(), whole: None }, Some(heads.clone()));
            for head in &heads {
                self.head_bit(among, head);
            }
            for (id, bound) in &bounds {
                let own = self.graph.subjects[id.0 as usize].clone();
                let of_parts: Vec<u32> = parts.iter().map(|part| own.bit(bound.head(&numbers, *part))).collect();
                self.ask_instead(*id, among, &of_parts);
            }
        }
    }

    /// Lets all that asks for a subject ask for another one, of which each head stands for one of these of its own.
    pub(super) fn ask_instead(&mut self, id: SubjectId, other: SubjectId, own: &[u32]) {
        let translated = |mask: u32| -> u32 {
            own.iter().enumerate().filter(|(_, own)| mask & **own != 0).map(|(at, _)| 1_u32 << at).sum()
        };
        for node in &mut self.graph.nodes {
            if let Effect::Branch(test) = &mut node.effect
                && test.subject == Some(id)
            {
                test.subject = Some(other);
                (test.holds, test.fails) = (translated(test.holds), translated(test.fails));
            }
        }
    }
}

impl Bound {
    /// The head that the subject of the comparison has where the value is in a part of the numbers.
    fn head(&self, numbers: &[f64], part: Part) -> &'static str {
        let own = numbers.iter().position(|number| *number == self.number).unwrap_or_default();
        let order = match part {
            Part::Below => Ordering::Less,
            Part::At(at) => at.cmp(&own),
            Part::Above(at) if at >= own => Ordering::Greater,
            Part::Above(_) => Ordering::Less,
            Part::Unordered => return "unordered",
        };
        let order = if self.is_turned { order.reverse() } else { order };
        match (self.is_float, order) {
            (true, Ordering::Less) => "less",
            (true, Ordering::Equal) => "equal",
            (true, Ordering::Greater) => "greater",
            (false, Ordering::Less) => "true",
            (false, Ordering::Equal) if self.is_closed => "true",
            (false, _) => "false",
        }
    }
}

/// The numbers that a value is compared with, in their order, where there are several. What differs by less than a small float can
/// tell is not put in order.
fn several_numbers(bounds: &[(SubjectId, Bound)]) -> Option<Vec<f64>> {
    let mut numbers: Vec<f64> = bounds.iter().map(|(_, bound)| bound.number).collect();
    numbers.sort_by(f64::total_cmp);
    numbers.dedup();
    let is_apart = |pair: &[f64]| pair[1] - pair[0] > 1e-6 * pair[0].abs().max(pair[1].abs());
    (numbers.len() > 1 && numbers.windows(2).all(is_apart)).then_some(numbers)
}

/// The parts into which numbers divide all that a value can be.
fn parts(numbers: &[f64], is_float: bool) -> Vec<Part> {
    let mut parts = vec![Part::Below];
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
