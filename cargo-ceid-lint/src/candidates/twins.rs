//! Methods that advance the state of a law without being called by it: `insert` of a delay line beside `process`, where a caller that
//! reads the line by itself needs nothing else.

use std::collections::BTreeSet;

use super::laws::{Finder, is_reset};
use crate::index::FunctionId;
use crate::syntax::tree::Receiver;

impl Finder<'_> {
    /// The names of the methods that do to the state what these laws do.
    pub(super) fn twins(&self, methods: &[FunctionId], laws: &[FunctionId]) -> Vec<String> {
        let index = self.program.index;
        let state: BTreeSet<&String> = laws.iter().flat_map(|law| self.conduct(*law).carried()).collect();
        // Of a single field it cannot be told whether it is advanced or set.
        if state.len() < 2 {
            return Vec::new();
        }
        let is_twin = |id: &&FunctionId| {
            let (def, conduct) = (index.function(**id), self.conduct(**id));
            // It is fed as they are.
            let fed = |id: FunctionId| {
                let params = &index.function(id).function.params;
                params.iter().map(|ty| index.lower(ty, &index.scope_of(id))).collect::<Vec<_>>()
            };
            let is_apart = |law: &FunctionId| !self.reaches(**id, *law) && !self.reaches(*law, **id);
            !laws.contains(id)
                && def.function.receiver == Some(Receiver::Exclusive)
                && !def.function.is_async
                && !is_reset(&def.name)
                && !sets_up(&def.name)
                && self.calls.from_elsewhere.contains(id)
                && laws.iter().all(is_apart)
                && laws.iter().any(|law| fed(*law) == fed(**id) && !fed(*law).is_empty())
                && state.iter().all(|field| conduct.written.contains(*field))
                && conduct.carried().any(|field| state.contains(field))
        };
        let found: Vec<FunctionId> = methods.iter().filter(is_twin).copied().collect();
        // What is called on one filter beside the law is a part of the step.
        let meets = |twin: &FunctionId| laws.iter().any(|law| self.together.are_beside(*twin, *law));
        let are_alternatives = !found.iter().any(meets);
        let mut names: Vec<String> = found.iter().map(|id| index.function(*id).name.clone()).collect();
        names.retain(|_| are_alternatives);
        names.sort();
        names.dedup();
        names
    }
}

/// Whether a method's name says that it sets the state, wherever that was.
pub(super) fn sets_up(name: &str) -> bool {
    let first = name.split('_').next().unwrap_or_default();
    matches!(
        first,
        "set"
            | "seek"
            | "rewind"
            | "load"
            | "restore"
            | "init"
            | "initialize"
            | "initialise"
            | "prepare"
            | "configure"
            | "resize"
            | "start"
            | "stop"
            | "prime"
            | "fill"
    )
}
