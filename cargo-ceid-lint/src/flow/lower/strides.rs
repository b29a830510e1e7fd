//! Elements of blocks whose numbers are computed from that of the round.

use super::Builder;
use crate::flow::{SampleRead, SampleWrite, Var};
use crate::syntax::tree::{ExprId, ExprKind};

/// A number that is computed from a variable, if from any: what that is multiplied with, and what is added.
#[derive(Clone, Copy)]
struct Affine {
    var: Option<Var>,
    factor: u64,
    offset: u64,
}

impl Builder<'_> {
    /// Takes note of `block[2 * i + 1] = value`.
    pub(super) fn note_sample_write(&mut self, target: ExprId, value: ExprId) {
        let ExprKind::Index { base, index } = self.body().expr(target).kind else { return };
        if let Some(Affine { var: Some(counter), factor: factor @ 2.., offset }) = self.affine(index)
            && let [block] = self.reads_of(base)[..]
        {
            let (value, from) = (self.span(value), self.reads_of(value));
            self.graph.sample_writes.push(SampleWrite { block, counter, factor, offset, value, from });
        }
    }

    /// Takes note of `block[2 * i + 1]` as a value.
    pub(super) fn note_sample_read(&mut self, id: ExprId, base: ExprId, index: ExprId) {
        if let Some(Affine { var: Some(counter), factor: factor @ 2.., offset }) = self.affine(index)
            && let [block] = self.reads_of(base)[..]
        {
            let (span, into) = (self.span(id), self.targets.clone());
            self.graph.sample_reads.push(SampleRead { block, counter, factor, offset, span, into });
        }
    }

    fn affine(&mut self, id: ExprId) -> Option<Affine> {
        if let Some(offset) = self.number(id) {
            return Some(Affine { var: None, factor: 0, offset });
        }
        match self.body().expr(id).kind {
            ExprKind::Path(_) => {
                let local = self.typed().expr_local.get(&id).copied()?;
                Some(Affine { var: Some(self.var_of(local)), factor: 1, offset: 0 })
            }
            ExprKind::Binary { op: "+", lhs, rhs } => {
                let (left, right) = (self.affine(lhs)?, self.affine(rhs)?);
                let var = left.var.xor(right.var);
                let offset = left.offset.checked_add(right.offset)?;
                (var.is_some()).then_some(Affine { var, factor: left.factor + right.factor, offset })
            }
            ExprKind::Binary { op: "*", lhs, rhs } => {
                let (left, right) = (self.affine(lhs)?, self.affine(rhs)?);
                let (of, by) = if right.var.is_none() { (left, right.offset) } else { (right, left.offset) };
                let (factor, offset) = (of.factor.checked_mul(by)?, of.offset.checked_mul(by)?);
                left.var.xor(right.var).map(|var| Affine { var: Some(var), factor, offset })
            }
            _ => None,
        }
    }
}
