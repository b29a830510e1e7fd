//! What is known of the code before any of it is a graph.

mod callables;

pub use callables::Callables;

use crate::index::{BodyOwner, FunctionId, Index};
use crate::parallel::Cores;
use crate::source::Span;
use crate::syntax::{CycleDirective, Directives};
use crate::types::TypedBody;

/// What the lowering may ask.
#[derive(Clone, Copy, Debug)]
pub struct Program<'a> {
    /// The items.
    pub index: &'a Index,
    /// The typed bodies of all functions, by number.
    pub bodies: &'a [Option<TypedBody>],
    /// What may stand behind values that are only called.
    pub callables: &'a Callables,
    /// The text of the sources, for messages.
    pub sources: &'a crate::source::SourceMap,
    /// What comments say of loops, functions and gates.
    pub directives: &'a Directives,
    /// How many cores the analysis may take.
    pub cores: Cores,
}

impl<'a> Program<'a> {
    /// The types of a function's body.
    #[must_use]
    pub fn typed(&self, id: FunctionId) -> Option<&'a TypedBody> {
        self.bodies.get(self.index.origin(id).0 as usize)?.as_ref()
    }

    /// What a comment says of the cycle or gate at a place.
    #[must_use]
    pub fn directive(&self, place: Span) -> Option<CycleDirective> {
        self.directives.of_cycle(self.sources, place)
    }

    /// Infers the types of all functions of an index.
    #[must_use]
    pub fn infer_all(index: &Index, cores: Cores) -> Vec<Option<TypedBody>> {
        let functions: Vec<FunctionId> = index.function_ids().collect();
        cores.deeply(functions.len(), |at| crate::types::infer(index, BodyOwner::Function(functions[at])))
    }
}
