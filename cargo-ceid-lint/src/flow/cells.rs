//! Cells, which are changed through shared references: who may have one, and which of them were read as states.

use std::collections::{BTreeMap, BTreeSet};

use super::{Place, SubjectId, Var};

/// What a function shows of its cells.
#[derive(Clone, Debug, Default)]
pub struct Cells {
    /// The variables with cells to which references were made, so that others may write what these hold.
    pub lent: BTreeSet<Var>,
    /// The variables with a handle to a cell that was made for them: `let mode = Rc::new(Cell::new(Mode::Off));`
    pub own: BTreeSet<Var>,
    /// The places of cells that were read as states.
    pub read: BTreeSet<Place>,
    /// What asks whether a cell is filled that others may fill at any time, and once.
    pub filled: BTreeMap<SubjectId, Place>,
}
