//! What is known of the code before any of it is a graph.

mod callables;
mod endless;
mod variants;

use callables::Callables;
use rustc_hash::FxHashSet;

use crate::index::{BodyOwner, FunctionId, Index};
use crate::parallel::Cores;
use crate::source::{SourceMap, Span};
use crate::syntax::{CycleDirective, Directives};
use crate::types::{Resolved, TypedBody};

pub(super) use endless::is_exit;
pub use variants::{MAX_VARIANTS, VariantNumbers, small_number};

/// What the lowering may ask.
#[derive(Clone, Copy, Debug)]
pub struct Program<'a> {
    /// The items.
    pub index: &'a Index,
    /// The typed bodies of all functions, by number.
    pub bodies: &'a [Option<TypedBody>],
    /// What may stand behind values that are only called.
    pub callables: &'a Callables,
    /// The functions that never come back.
    endless: &'a FxHashSet<FunctionId>,
    /// What tells the variants of each enum apart.
    pub variants: &'a VariantNumbers,
    /// The text of the sources, for messages.
    pub sources: &'a SourceMap,
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

    /// Whether no way leads back out of what a call runs.
    #[must_use]
    pub fn never_returns(&self, resolved: &Resolved) -> bool {
        endless::runs_endless(self.index, self.endless, resolved)
    }

    /// What a comment says of the cycle or gate at a place.
    #[must_use]
    pub fn directive(&self, place: Span) -> Option<CycleDirective> {
        self.directives.of_cycle(self.sources, place)
    }
}

/// What is inferred of all bodies, which a [`Program`] lends.
#[derive(Debug)]
pub struct Inferred {
    bodies: Vec<Option<TypedBody>>,
    callables: Callables,
    endless: FxHashSet<FunctionId>,
    variants: VariantNumbers,
}

impl Inferred {
    /// Infers the types of all functions of an index.
    #[must_use]
    pub fn of(index: &Index, sources: &SourceMap, cores: Cores) -> Self {
        let functions: Vec<FunctionId> = index.function_ids().collect();
        let infer = |at: usize| crate::types::infer(index, BodyOwner::Function(functions[at]));
        let bodies = cores.deeply(functions.len(), infer);
        let callables = Callables::of(index, &bodies, sources);
        let endless = endless::endless(index, &bodies);
        Self { bodies, callables, endless, variants: VariantNumbers::of(index) }
    }

    /// What the lowering may ask of these bodies.
    #[must_use]
    pub fn program<'a>(
        &'a self,
        index: &'a Index,
        sources: &'a SourceMap,
        directives: &'a Directives,
        cores: Cores,
    ) -> Program<'a> {
        Program {
            index,
            bodies: &self.bodies,
            callables: &self.callables,
            endless: &self.endless,
            variants: &self.variants,
            sources,
            directives,
            cores,
        }
    }
}
