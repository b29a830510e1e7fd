//! Blocks of which a round of a loop writes several samples.

use super::Var;
use crate::source::Span;

/// `block[2 * i + 1] = value;`: an element whose number is computed from that of the round is written.
#[derive(Clone, Debug)]
pub struct SampleWrite {
    /// The variable that the block is, or lies in.
    pub block: Var,
    /// The variable that the number is computed from.
    pub counter: Var,
    /// What that is multiplied with.
    pub factor: u64,
    /// What is added.
    pub offset: u64,
    /// The value.
    pub value: Span,
    /// The variables that the value reads.
    pub from: Vec<Var>,
}

/// An element of a block that is read at a multiple of a number.
#[derive(Clone, Debug)]
pub struct SampleRead {
    /// The variable that the block is, or lies in.
    pub block: Var,
    /// The variable that the number is computed from.
    pub counter: Var,
    /// What that is multiplied with.
    pub factor: u64,
    /// What is added.
    pub offset: u64,
    /// Where it is read.
    pub span: Span,
    /// The variables that it goes into.
    pub into: Vec<Var>,
}
