//! Values that are compared with several numbers: which of the intervals between these a comparison holds for, so that those that
//! exclude one another are told to.

use std::cmp::Ordering;
use std::collections::BTreeSet;

use super::Builder;
use super::numbers::{limit_of_type, limits_of, number_of_head};
use super::questions::grouped;
use super::subjects::Pure;
use super::told::has_one_answer;
use crate::flow::test::MAX_HEADS;
use crate::flow::{About, Assignment, ChangeKind, Effect, Head, NodeId, Place, Program, SubjectId, Var};
use crate::index::{FunctionId, Ty};
use crate::source::Span;
use crate::syntax::tree::{Body, ExprId, ExprKind, StmtKind};
use crate::types::{Callee, TypedBody};

/// How many calls are followed to the number that a function gives.
const MAX_CALLS: u32 = 2;

/// How many answers of questions about one value are compared.
const MAX_ANSWERS: usize = 1 << 18;

/// A question about a value that numbers answer.
#[derive(Clone, Debug)]
pub(super) struct Bound {
    value: Pure,
    is_float: bool,
    /// The least and the greatest number that it can be, as far as its type is known.
    ends: Ends,
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
    /// Which of these numbers it is, with their heads.
    Number(Vec<(f64, Head)>),
}

/// The least and the greatest number of a type.
pub(super) type Ends = [Option<f64>; 2];

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
        let numbers = [lhs, rhs].map(|id| self.constants().asked_number(id));
        let (value, number, is_turned) = match numbers {
            [None, Some(number)] => (lhs, number, false),
            [Some(number), None] => (rhs, number, true),
            _ => return,
        };
        let is_float = match self.ty(value).peel() {
            Ty::Float => true,
            Ty::Int | Ty::Char => false,
            _ => return,
        };
        if !self.is_plain_number(value) {
            return;
        }
        let ends = self.ends_of(value, &[lhs, rhs]);
        let Some(value) = self.pure(value).filter(|value| !value.reads.is_empty()) else { return };
        // `a > b` is asked as `a <= b`.
        let is_closed = matches!(op, "<=" | ">");
        let asks = Asks::Order { number, is_turned, is_closed };
        self.bounds.insert(subject, Bound { value, is_float, ends, asks });
    }

    /// Notes which numbers a value can be that is asked which one it is.
    pub(super) fn note_ends(&mut self, value: ExprId) {
        if *self.ty(value).peel() == Ty::Int
            && let Some(int) = self.int_of(value)
            && let Some(pure) = self.pure(value)
        {
            self.ends.insert(pure.key, ends_of_type(&int));
        }
    }

    /// The least and the greatest number that a value can be by its type, or by the one whose ends it is compared with.
    fn ends_of(&self, value: ExprId, compared: &[ExprId]) -> Ends {
        if self.is_length(value) {
            return [Some(0.0), None];
        }
        let of_limit = |id: &ExprId| match &self.body().expr(*id).kind {
            ExprKind::Path(path) => ends_of_limit(&path.text()),
            _ => None,
        };
        let declared = || self.int_of(value).map(|int| ends_of_type(&int));
        compared.iter().find_map(of_limit).or_else(declared).unwrap_or_default()
    }

    /// `(50..80).contains(&level)`: asks for the range as a pattern does. Answers whether it is such a question.
    pub(super) fn range_condition(&mut self, id: ExprId, receiver: ExprId, args: &[ExprId], no: NodeId) -> bool {
        let ExprKind::Range { start, end, inclusive } = self.body().expr(receiver).kind else { return false };
        let [arg] = args else { return false };
        let ExprKind::Reference { value, .. } = self.body().expr(*arg).kind else { return false };
        let ends = [start, end];
        let is_written = ends.iter().flatten().all(|end| self.constants().asked_number(*end).is_some());
        if !is_written || !self.is_plain_number(value) {
            return false;
        }
        let Some(pure) = self.pure(value) else { return false };
        let (span, text, about) = (self.span(id), self.text(id), self.about(value));
        self.expr(value);
        self.ask_range((ends, inclusive), &pure, Some(value), &about, (span, &text), no);
        true
    }

    /// Asks whether a value lies between two ends, and may be the last one.
    pub(super) fn ask_range(
        &mut self,
        (ends, is_closed): ([Option<ExprId>; 2], bool),
        value: &Pure,
        expr: Option<ExprId>,
        about: &About,
        (span, text): (Span, &str),
        no: NodeId,
    ) {
        if self.at.is_none() {
            return;
        }
        let heads = ["true", "false"].map(str::to_owned);
        let numbers = ends.map(|end| end.map(|end| self.constants().asked_number(end)));
        let [first, last] = [0, 1].map(|at| match (numbers[at].flatten(), ends[at]) {
            (Some(number), _) => number.to_string(),
            (None, Some(end)) => self.text(end),
            (None, None) => String::new(),
        });
        let dots = if is_closed { "..=" } else { ".." };
        let key = format!("({} in {first}{dots}{last})", value.key);
        let asked = Pure { key, reads: value.reads.clone(), ..Pure::default() };
        let id = self.subject(asked, Some(heads.to_vec()));
        for head in &heads {
            self.head_bit(id, head);
        }
        let (yes, failed) = self.branch_on_subject(id, &heads[..1], true, span, text.to_owned(), about.clone());
        self.link(failed, no);
        self.resume(yes);
        let is_float = ends.iter().flatten().any(|end| !self.constants().is_whole(*end));
        if numbers.iter().all(|end| *end != Some(None)) {
            let [first, last] = numbers.map(Option::flatten);
            let asks = Asks::Range { first, last, is_closed };
            let compared: Vec<ExprId> = ends.into_iter().flatten().collect();
            let of_type = expr.or(compared.first().copied()).map(|value| self.ends_of(value, &compared));
            let ends = of_type.unwrap_or_default();
            self.bounds.insert(id, Bound { value: value.clone(), is_float, ends, asks });
        }
    }

    /// Whether an expression is a number that no cast may have made another one.
    fn is_plain_number(&self, id: ExprId) -> bool {
        // Of another element, or behind another number, it is another value: what it reads says so.
        !self.body().within(id).any(|id| matches!(self.body().expr(id).kind, ExprKind::Cast { .. }))
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
            bounds.extend(self.asked_for_numbers(&value, is_float));
            let Some(numbers) = several_numbers(&bounds, is_float) else { continue };
            let of_type = self.ends.get(&value.key).copied().unwrap_or_default();
            let known = |at: usize| bounds.iter().find_map(|(_, bound)| bound.ends[at]).or(of_type[at]);
            let parts = parts(&numbers, is_float, [known(0), known(1)]);
            let asked: usize = bounds.iter().map(|(_, bound)| bound.numbers().len()).sum();
            if parts.len().saturating_mul(asked) > MAX_ANSWERS {
                continue;
            }
            let answers_to =
                |part: Part| -> Vec<Head> { bounds.iter().map(|(_, bound)| bound.head(&numbers, part)).collect() };
            // The heads of a question are the same wherever it is asked, as long as there are not too many.
            let mut answers: Vec<Vec<Head>> = parts.iter().map(|part| answers_to(*part)).collect();
            let is_joined = answers.len() > MAX_HEADS;
            if is_joined {
                answers.sort();
                answers.dedup();
            }
            if answers.len() > MAX_HEADS {
                continue;
            }
            let (heads, joined): (Vec<Head>, String) = match is_joined {
                true => ((0..answers.len()).map(|at| format!("part {at}")).collect(), format!("{answers:?}")),
                false => (parts.iter().map(|part| format!("{part:?}")).collect(), String::new()),
            };
            let key = format!("({} among {numbers:?} {parts:?}{joined})", value.key);
            let among = Pure { key, reads: value.reads, ..Pure::default() };
            let asked: Vec<(SubjectId, usize)> = bounds.iter().zip(0..).map(|((id, _), at)| (*id, at)).collect();
            self.ask_as_one(among, &heads, &asked, |bound, at| answers[at][*bound].clone());
        }
    }

    /// The question which of several numbers a value is, where nothing gives it one of them.
    fn asked_for_numbers(&self, value: &Pure, is_float: bool) -> Option<(SubjectId, Bound)> {
        let id = *self.subjects.get(&value.key)?;
        let heads = &self.graph.subjects[id.0 as usize].heads;
        let number = |head: &Head| Some((number_of_head(head)?, head.clone()));
        let mut numbers: Vec<(f64, Head)> = heads.iter().map(number).collect::<Option<_>>()?;
        numbers.sort_by(|(left, _), (right, _)| left.total_cmp(right));
        // Zero with a minus is zero.
        let is_twice = numbers.windows(2).any(|pair| pair[0].0 == pair[1].0);
        let asks = Asks::Number(numbers);
        let bound = Bound { value: value.clone(), is_float, ends: Ends::default(), asks };
        (!heads.is_empty() && !is_twice && !self.is_given_number(value)).then_some((id, bound))
    }

    /// Whether something gives a value a number that is known, or lets it count.
    fn is_given_number(&self, value: &Pure) -> bool {
        let Some(whole) = &value.whole else { return false };
        let given = |id: &NodeId| match &self.graph.node(*id).effect {
            Effect::Set(set) | Effect::Write(set) if set.place.overlaps(whole) => Some(&**set),
            _ => None,
        };
        let is_told = |set: &Assignment| set.head.is_some() || set.same_as.is_some_and(|from| self.gives_number(from));
        let counts = |id: &NodeId, set: &Assignment| {
            !set.rebinds
                && self.graph.changes.get(id).is_some_and(|change| {
                    !matches!(change.kind, ChangeKind::Other | ChangeKind::Raises | ChangeKind::Lowers)
                })
        };
        // What it begins with is gone where a round gives it another value.
        let is_begun = |id: &NodeId| self.graph.node(*id).in_loop.is_none();
        let is_renewed = self.graph.node_ids().any(|id| {
            !is_begun(&id) && given(&id).is_some_and(|set| set.place == *whole && !is_told(set) && !counts(&id, set))
        });
        let is_counter = whole.base_var().is_some_and(|var| self.is_counter(var));
        let gives = |id: NodeId| {
            given(&id).is_some_and(|set| is_told(set) && !(is_renewed && is_begun(&id)) || counts(&id, set))
        };
        is_counter || self.graph.node_ids().any(gives)
    }

    /// Whether a variable may hold a number that the code around it knows.
    fn gives_number(&self, var: Var) -> bool {
        self.graph.nodes.iter().any(|node| match &node.effect {
            Effect::Set(set) | Effect::Write(set) => set.place.base_var() == Some(var) && set.head.is_some(),
            Effect::Call(site) => {
                site.result == var && site.targets.iter().any(|target| gives_number(self.program, *target, 0))
            }
            _ => false,
        })
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
        !self.is_float && self.is_about(place)
    }

    /// Whether the value of a place is asked about.
    pub(super) fn is_about(&self, place: &Place) -> bool {
        self.value.whole.as_ref() == Some(place)
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
        let below = (self.ends[0] != Some(0.0)).then_some(Part::Below);
        below.into_iter().chain([Part::Above(numbers.len() - 1)]).map(|part| self.head(&numbers, part)).collect()
    }

    /// The numbers that the answer depends on.
    fn numbers(&self) -> Vec<f64> {
        match &self.asks {
            Asks::Order { number, .. } => vec![*number],
            Asks::Range { first, last, .. } => first.iter().chain(last).copied().collect(),
            Asks::Number(numbers) => numbers.iter().map(|(number, _)| *number).collect(),
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
                let is_it = |(number, _): &&(f64, Head)| order(*number) == Some(Ordering::Equal);
                own.iter().find(is_it).map_or_else(String::new, |(_, head)| head.clone())
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

/// The numbers that a value is compared with, in their order, where several questions ask about it. What
/// differs by less than a small float can tell is not put in order.
fn several_numbers(bounds: &[(SubjectId, Bound)], is_float: bool) -> Option<Vec<f64>> {
    let mut numbers: Vec<f64> = bounds.iter().flat_map(|(_, bound)| bound.numbers()).collect();
    numbers.sort_by(f64::total_cmp);
    numbers.dedup();
    let is_apart = |pair: &[f64]| !is_float || pair[1] - pair[0] > 1e-6 * pair[0].abs().max(pair[1].abs());
    (bounds.len() > 1 && numbers.windows(2).all(is_apart)).then_some(numbers)
}

/// The parts into which numbers divide all that a value can be.
fn parts(numbers: &[f64], is_float: bool, [least, greatest]: Ends) -> Vec<Part> {
    let is_within = |number: &f64| {
        least.is_none_or(|least| least <= *number) && greatest.is_none_or(|greatest| *number <= greatest)
    };
    let is_first = numbers.first().is_some_and(|first| least.is_some_and(|least| *first <= least));
    let mut parts: Vec<Part> = (!is_first).then_some(Part::Below).into_iter().collect();
    for (at, number) in numbers.iter().enumerate() {
        if is_within(number) {
            parts.push(Part::At(at));
        }
        // There is no whole number between two that follow one another, and none beyond the ends.
        let next = numbers.get(at + 1);
        let is_empty = !is_float && next.is_some_and(|next| *next == number + 1.0);
        let is_beyond = next.is_some_and(|next| least.is_some_and(|least| *next <= least))
            || greatest.is_some_and(|greatest| greatest <= *number);
        if !is_empty && !is_beyond {
            parts.push(Part::Above(at));
        }
    }
    if is_float {
        parts.push(Part::Unordered);
    }
    parts
}

/// The ends of a type of whole numbers, as far as every machine has the same.
fn ends_of_type(name: &str) -> Ends {
    let limits = limits_of(name);
    let least = if name.starts_with('u') { Some(0.0) } else { limits.map(|[least, _]| least) };
    [least, limits.map(|[_, greatest]| greatest)]
}

/// The ends of the type of which a path names the least or greatest number: `i32::MIN`.
fn ends_of_limit(path: &str) -> Option<Ends> {
    limit_of_type(path)?;
    let (name, _) = path.rsplit_once("::")?;
    limits_of(name.rsplit("::").next()?).map(|ends| ends.map(Some))
}

/// Whether a function may give a number that is written in it.
fn gives_number(program: &Program<'_>, id: FunctionId, depth: u32) -> bool {
    let function = &program.index.function(id).function;
    let (Some(body), Some(typed)) = (&function.body, program.typed(id)) else { return false };
    // What stands in for another function decides nothing.
    if !function.is_const && has_one_answer(body) {
        return false;
    }
    let mut open = vec![body.root];
    open.extend(body.exprs.iter().filter_map(|expr| match &expr.kind {
        ExprKind::Return(value) => *value,
        _ => None,
    }));
    let mut seen: BTreeSet<ExprId> = BTreeSet::new();
    while let Some(id) = open.pop() {
        if !seen.insert(id) {
            continue;
        }
        match &body.expr(id).kind {
            ExprKind::Literal(_) | ExprKind::Negate(_) => return true,
            ExprKind::Path(_) if typed.expr_def.contains_key(&id) => return true,
            ExprKind::Path(_) => open.extend(given_to(body, typed, id)),
            ExprKind::Block(block) => open.extend(block.tail),
            ExprKind::If { then, otherwise, .. } => open.extend([*then].into_iter().chain(*otherwise)),
            ExprKind::Match { arms, .. } => open.extend(arms.iter().map(|arm| arm.body)),
            ExprKind::Loop { .. } | ExprKind::Macro(_) => return true,
            ExprKind::Call { .. } | ExprKind::MethodCall { .. } => match typed.callees.get(&id) {
                Some(Callee::Resolved(call))
                    if depth >= MAX_CALLS
                        || call.targets.iter().any(|target| gives_number(program, *target, depth + 1)) =>
                {
                    return true;
                }
                _ => {}
            },
            _ => {}
        }
    }
    false
}

/// What a body gives to the variable that an expression names.
fn given_to(body: &Body, typed: &TypedBody, id: ExprId) -> Vec<ExprId> {
    let Some(local) = typed.expr_local.get(&id) else { return Vec::new() };
    let declared = body.stmts().filter_map(|stmt| match &stmt.kind {
        StmtKind::Let { pat, init, .. } if typed.pat_local.get(pat) == Some(local) => *init,
        _ => None,
    });
    let assigned = body.exprs.iter().filter_map(|expr| match &expr.kind {
        ExprKind::Assign { place, value } if typed.expr_local.get(place) == Some(local) => Some(*value),
        _ => None,
    });
    declared.chain(assigned).collect()
}
