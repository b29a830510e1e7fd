//! Bits of a number that stand for truth values: `if self.flags & ARMED != 0`, `self.flags |= ARMED`, also in a type of the code's
//! own (`self.flags.insert(Flags::ARMED)`). Each is a place inside of the
//! number, so that what changes one of them leaves the others as they were.

use super::Builder;
use super::closures::is_named;
use super::constants::{Constant, Constants, in_constant, whole};
use super::subjects::pure_place;
use crate::flow::{About, Assignment, Effect, NodeId, Place, Transfer};
use crate::index::{Def, Ty};
use crate::syntax::tree::{ExprId, ExprKind};
use crate::types::Callee;

/// How many bits one assignment may change for each to be told apart.
const MAX_BITS: u32 = 4;

impl Builder<'_> {
    /// Asks whether a bit is set, if that is what a comparison asks. Answers whether it is.
    pub(super) fn bit_asked(&mut self, id: ExprId, op: &str, [lhs, rhs]: [ExprId; 2], no: NodeId) -> bool {
        let sides = [(lhs, rhs), (rhs, lhs)];
        let Some((bit, where_set)) = sides.iter().find_map(|(masked, number)| self.asked_bit(op, *masked, *number))
        else {
            return false;
        };
        if self.at.is_none() {
            return true;
        }
        let about = About { is_turned: !where_set, ..self.about(id) };
        let heads = ["true", "false"].map(str::to_owned);
        let asked = self.subject(pure_place(bit), Some(heads.to_vec()));
        for head in &heads {
            self.head_bit(asked, head);
        }
        let (span, text) = (self.span(id), self.text(id));
        let (set, clear) = self.branch_on_subject(asked, &heads[..1], true, span, text, about);
        let (yes, failed) = if where_set { (set, clear) } else { (clear, set) };
        self.link(failed, no);
        self.resume(yes);
        true
    }

    /// The bit that is compared with a number, and whether the comparison holds where it is set.
    fn asked_bit(&mut self, op: &str, masked: ExprId, number: ExprId) -> Option<(Place, bool)> {
        let ExprKind::Binary { op: "&", lhs, rhs } = self.body().expr(masked).kind else { return None };
        let (flags, mask) = match self.mask(rhs) {
            Some(mask) => (lhs, mask),
            None => (rhs, self.mask(lhs)?),
        };
        let bit = Some(mask).filter(|mask| mask.is_power_of_two())?;
        let is_set = match self.mask(number)? {
            0 => false,
            number if number == bit => true,
            _ => return None,
        };
        let is_equal = match op {
            "==" => true,
            "!=" => false,
            _ => return None,
        };
        Some((self.flags(flags)?.bit(bit), is_set == is_equal))
    }

    /// `flags |= A`, `flags &= !A`: the bits are set or cleared, and the others stay. Answers whether it is such an assignment.
    pub(super) fn bits_assigned(&mut self, id: ExprId, op: &str, target: ExprId, value: ExprId) -> bool {
        let mask = match (op, &self.body().expr(value).kind) {
            ("|", _) => self.mask(value),
            ("&", ExprKind::Not(inner)) => self.mask(*inner),
            _ => None,
        };
        let Some(mask) = mask.filter(|mask| (1..=MAX_BITS).contains(&mask.count_ones())) else { return false };
        let Some(flags) = self.flags(target) else { return false };
        let head = if op == "|" { "true" } else { "false" };
        for bit in (0..u32::BITS).map(|number| 1 << number).filter(|bit| mask & bit != 0) {
            if self.at.is_none() {
                return true;
            }
            let (transfer, head) = (Transfer::Move, Some(head.to_owned()));
            let place = flags.bit(bit);
            let written = Assignment { place, from: None, transfer, rebinds: false, head, same_as: None };
            self.emit(Effect::Write(Box::new(written)), self.span(id));
            self.note_change(target, value, Some(op));
        }
        true
    }

    /// `flags = flags | A` is the same as `flags |= A`.
    pub(super) fn bits_reassigned(&mut self, id: ExprId, target: ExprId, value: ExprId) -> bool {
        let ExprKind::Binary { op: op @ ("|" | "&"), lhs, rhs } = self.body().expr(value).kind else { return false };
        let flags = self.flags(target);
        flags.is_some() && self.flags(lhs) == flags && self.bits_assigned(id, op, target, rhs)
    }

    /// The number whose bits are told apart: a variable or field that does not count.
    fn flags(&mut self, id: ExprId) -> Option<Place> {
        let body = self.body();
        if *self.ty(id).peel() != Ty::Int || !is_named(body, id) {
            return None;
        }
        let place = self.static_place(id)?;
        let text = self.text(id);
        let counts = body.exprs.iter().any(|expr| match &expr.kind {
            ExprKind::AssignOp { op, place, .. } => !matches!(*op, "|" | "&" | "^") && self.text(*place) == text,
            ExprKind::Assign { place, value } => {
                let is_arithmetic = match &body.expr(*value).kind {
                    ExprKind::Binary { op, .. } => !matches!(*op, "|" | "&" | "^"),
                    ExprKind::MethodCall { .. } => true,
                    _ => false,
                };
                is_arithmetic && self.text(*place) == text
            }
            _ => false,
        });
        (!counts).then_some(place)
    }

    /// The whole number that an expression is, where the source fixes it.
    fn mask(&self, id: ExprId) -> Option<u32> {
        if let ExprKind::Field { base, .. } = &self.body().expr(id).kind
            && let Some(mask) = self.mask_within(*base)
        {
            return Some(mask);
        }
        match self.constants().value(id)? {
            Constant::Number(number) => whole(number),
            Constant::Seconds(_) => None,
        }
    }

    /// The number in a constant of a type that holds nothing else: `const ARMED: Self = Self(1 << 0);`
    pub(super) fn mask_within(&self, id: ExprId) -> Option<u32> {
        if let ExprKind::Reference { value, .. } = &self.body().expr(id).kind {
            return self.mask_within(*value);
        }
        if let Some(local) = self.typed().expr_local.get(&id) {
            return self.frames[self.frame].masks.get(local).copied();
        }
        let Some(Def::Value(value)) = self.typed().expr_def.get(&id) else { return None };
        if self.program.index.value(*value).item.is_static {
            return None;
        }
        let held = |own: Constants<'_>| {
            let held = match &own.body.expr(own.body.root).kind {
                ExprKind::Call { args, .. }
                    if matches!(
                        own.typed.callees.get(&own.body.root),
                        Some(Callee::Constructor(Some(Def::Type(_))))
                    ) =>
                {
                    args.as_slice()
                }
                ExprKind::Struct { fields, rest: None, .. } => match fields.as_slice() {
                    [(_, field)] => std::slice::from_ref(field),
                    _ => return None,
                },
                _ => return None,
            };
            match held {
                [held] => match own.value(*held)? {
                    Constant::Number(number) => whole(number),
                    Constant::Seconds(_) => None,
                },
                _ => None,
            }
        };
        in_constant(self.program, *value, held)?
    }
}
