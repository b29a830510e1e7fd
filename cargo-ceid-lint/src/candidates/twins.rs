//! Methods that advance the state of a law without being called by it: `insert` of a delay line beside `process`, where a caller that
//! reads the line by itself needs nothing else.

use std::collections::{BTreeMap, BTreeSet};

use super::laws::{Finder, is_reset};
use crate::index::FunctionId;
use crate::syntax::tree::{ExprKind, Receiver};
use crate::types::Callee;

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
        let are_alternatives = !found.is_empty() && !self.meet(&found, laws);
        let mut names: Vec<String> = found.iter().map(|id| index.function(*id).name.clone()).collect();
        names.retain(|_| are_alternatives);
        names.sort();
        names.dedup();
        names
    }

    /// Whether a function calls methods of both kinds on what it has by the same name.
    fn meet(&self, twins: &[FunctionId], laws: &[FunctionId]) -> bool {
        let index = self.program.index;
        index.function_ids().any(|caller| {
            let (Some(body), Some(typed)) = (&index.function(caller).function.body, self.program.typed(caller)) else {
                return false;
            };
            let mut called: BTreeMap<String, [bool; 2]> = BTreeMap::new();
            for (at, callee) in &typed.callees {
                let (Callee::Resolved(resolved), ExprKind::MethodCall { receiver, .. }) =
                    (callee, &body.expr(*at).kind)
                else {
                    continue;
                };
                let calls = [laws, twins].map(|of| resolved.targets.iter().any(|target| of.contains(target)));
                if calls == [false, false] {
                    continue;
                }
                let mut name = String::new();
                let mut open = vec![*receiver];
                while let Some(id) = open.pop() {
                    match &body.expr(id).kind {
                        ExprKind::Path(path) => name.insert_str(0, &path.text()),
                        ExprKind::Field { base, name: field } => {
                            name.insert_str(0, &format!(".{field}"));
                            open.push(*base);
                        }
                        ExprKind::Index { base, .. } => {
                            name.insert_str(0, "[]");
                            open.push(*base);
                        }
                        ExprKind::Deref(inner) | ExprKind::Reference { value: inner, .. } => open.push(*inner),
                        _ => name.insert(0, '_'),
                    }
                }
                let own = called.entry(name).or_default();
                *own = [own[0] | calls[0], own[1] | calls[1]];
            }
            called.values().any(|calls| *calls == [true, true])
        })
    }
}

/// Whether a method's name says that it sets the state, wherever that was.
fn sets_up(name: &str) -> bool {
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
