//! Small counters: whole numbers that go on by a constant and are compared with a few small ones. Which number they have is told apart
//! one by one, so that what asks for them again knows how far they have come.

use std::collections::BTreeSet;

use super::Builder;
use super::intervals::Bound;
use super::subjects::{Pure, place_key, pure_place};
use crate::flow::{Effect, Head, NodeId, OTHER_HEADS, Place, SubjectId, Tally};
use crate::index::Ty;
use crate::syntax::tree::{ExprId, ExprKind};

/// The greatest number that is told apart.
const MAX_COUNTED: u64 = 4;

impl Builder<'_> {
    /// How an assignment counts, where it does so by a constant.
    pub(super) fn tally(&mut self, target: ExprId, value: ExprId, op: Option<&str>) -> Option<Tally> {
        if *self.ty(target).peel() != Ty::Int {
            return None;
        }
        let may_be_less = !self.int_of(target).is_some_and(|int| int.starts_with('u'));
        let by = |up: bool, step: u64| Tally { up, step, around: None, held_at: None, saturates: false, may_be_less };
        match op {
            Some(op @ ("+" | "-")) => Some(by(op == "+", self.number(value)?)),
            Some(_) => None,
            None => {
                let place = self.static_place(target)?;
                self.tallied(&place, value, &by)
            }
        }
    }

    fn tallied(&mut self, before: &Place, value: ExprId, by: &dyn Fn(bool, u64) -> Tally) -> Option<Tally> {
        let body = self.body();
        match &body.expr(value).kind {
            ExprKind::Binary { op: op @ ("+" | "-"), lhs, rhs } if self.is_place(*lhs, before) => {
                Some(by(*op == "+", self.number(*rhs)?))
            }
            ExprKind::Binary { op: "+", lhs, rhs } if self.is_place(*rhs, before) => Some(by(true, self.number(*lhs)?)),
            ExprKind::Binary { op: "%", lhs, rhs } => {
                let around = self.number(*rhs).filter(|around| *around > 0)?;
                let inner = self.tallied(before, *lhs, by).filter(|inner| inner.up && !inner.may_be_less)?;
                Some(Tally { around: Some(around), ..inner })
            }
            ExprKind::MethodCall { receiver, method, args, .. } if method == "min" => {
                let [bound] = args.as_slice() else { return None };
                let bound = self.number(*bound)?;
                let inner = self.tallied(before, *receiver, by)?;
                let is_plain = inner.up && !inner.may_be_less && inner.around.is_none() && inner.held_at.is_none();
                is_plain.then_some(Tally { held_at: Some(bound), ..inner })
            }
            ExprKind::MethodCall { receiver, method, args, .. } if self.is_place(*receiver, before) => {
                let [step] = args.as_slice() else { return None };
                let step = self.number(*step)?;
                match method.as_str() {
                    "wrapping_add" => Some(Tally { may_be_less: true, ..by(true, step) }),
                    "wrapping_sub" => Some(Tally { may_be_less: true, ..by(false, step) }),
                    "saturating_add" => Some(by(true, step)),
                    "saturating_sub" => {
                        let tally = by(false, step);
                        Some(Tally { saturates: !tally.may_be_less, ..tally })
                    }
                    _ => None,
                }
            }
            _ => None,
        }
    }

    fn is_place(&mut self, id: ExprId, place: &Place) -> bool {
        self.static_place(id).as_ref() == Some(place)
    }

    /// Asks all comparisons of a counter with small numbers which number it has.
    pub(super) fn settle_tallies(&mut self) {
        let counted: BTreeSet<Place> = self
            .graph
            .changes
            .iter()
            .filter(|(_, change)| change.tally.is_some())
            .filter_map(|(id, _)| self.assigned_at(*id).cloned())
            .filter(|place| !place.base_var().is_some_and(|var| place.steps.is_empty() && self.is_counter(var)))
            .collect();
        for place in counted {
            self.settle_tally(place);
        }
    }

    fn assigned_at(&self, id: NodeId) -> Option<&Place> {
        match &self.graph.node(id).effect {
            Effect::Set(set) | Effect::Write(set) => Some(&set.place),
            _ => None,
        }
    }

    /// The numbers that a counter is given, and the last one before it comes round.
    fn given_numbers(&self, place: &Place) -> impl Iterator<Item = u64> {
        let at = self.graph.node_ids().filter(move |id| self.assigned_at(*id) == Some(place));
        at.flat_map(|id| {
            let head = match &self.graph.node(id).effect {
                Effect::Set(set) | Effect::Write(set) => set.head.as_ref().and_then(|head| head.parse().ok()),
                _ => None,
            };
            let tally = self.graph.changes.get(&id).and_then(|change| change.tally);
            head.into_iter().chain(tally.and_then(|tally| tally.around?.checked_sub(1)))
        })
    }

    fn settle_tally(&mut self, place: Place) {
        let bounds: Vec<(SubjectId, Bound)> = self
            .bounds
            .iter()
            .filter(|(_, bound)| bound.is_of(&place))
            .map(|(id, bound)| (*id, bound.clone()))
            .collect();
        let own = self.subjects.get(&place_key(&place));
        let heads: Vec<Head> = own.map(|id| self.graph.subjects[id.0 as usize].heads.clone()).unwrap_or_default();
        let asked: Option<Vec<u64>> = heads.iter().map(|head| head.parse().ok()).collect();
        let compared: Option<Vec<u64>> = bounds.iter().flat_map(|(_, bound)| bound.whole_numbers()).collect();
        let (Some(asked), Some(compared)) = (asked, compared) else { return };
        let Some(last) = asked.into_iter().chain(compared).max().filter(|last| *last <= MAX_COUNTED) else { return };
        let last = self.given_numbers(&place).filter(|given| *given <= MAX_COUNTED).fold(last, u64::max);
        let pure: Pure = pure_place(place);
        let other = self.subject(pure, None);
        let bits: Option<Vec<u32>> = (0..=last).map(|number| self.head_bit(other, &number.to_string())).collect();
        let Some(bits) = bits else { return };
        for (id, bound) in bounds {
            self.bounds.remove(&id);
            let subject = &self.graph.subjects[id.0 as usize];
            let told = bits.iter().zip(0..).map(|(bit, number)| (subject.bit(&bound.at(last, number)), *bit));
            let beyond = bound.beyond(last).into_iter().map(|head| (subject.bit(&head), OTHER_HEADS));
            let own: Vec<(u32, u32)> = told.chain(beyond).collect();
            self.ask_instead(id, other, &own);
        }
    }
}
