//! Functions that are too large to be followed to their end: a filter behind that end is in no pair, and nobody is to think that
//! there was none.

use crate::diagnostic::Problem;
use crate::flow::{ControlFlowGraph, Program};
use crate::source::{SourceMap, Span};

/// A function that is followed in part.
pub(super) struct TooLarge {
    /// Index into the project's packages.
    pub(super) package: usize,
    /// Index into the package's targets.
    pub(super) target: usize,
    /// Its `fn`.
    pub(super) head: Span,
    why: String,
}

/// The functions with a graph that was given up, each as it is written.
pub(super) fn functions(program: &Program<'_>, graphs: &[Option<ControlFlowGraph>]) -> Vec<TooLarge> {
    let index = program.index;
    let cut = graphs.iter().flatten().filter(|graph| index.origin(graph.function) == graph.function);
    cut.filter_map(|graph| {
        let def = index.function(graph.function);
        let krate = index.crate_of(def.module);
        let why = format!("`{}` is not followed to its end: {}", def.name, graph.truncated.as_ref()?);
        Some(TooLarge { package: krate.package, target: krate.target, head: def.function.head, why })
    })
    .collect()
}

impl TooLarge {
    pub(super) fn problem(self, sources: &SourceMap) -> Problem {
        Problem {
            file: sources.file(self.head.file).name.clone(),
            span: Some(self.head),
            message: self.why,
            help: Some("split it: a filter or a cycle behind that limit is not checked".to_owned()),
            is_error: false,
        }
    }
}
