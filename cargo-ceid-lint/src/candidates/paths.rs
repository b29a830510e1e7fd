//! How an entry names what was found: a path that means it, and nothing else that would make the entry wrong.

use super::laws::Finder;
use crate::index::{Def, ModuleId, Namespace};
use crate::source::Span;

impl Finder<'_> {
    /// The path of an item; `None` if every path to it names something else as well, or if it lies in a block.
    pub(super) fn path_to(&self, module: ModuleId, name: &str, place: Span, namespace: Namespace) -> Option<String> {
        let index = self.program.index;
        let mut parts = vec![name.to_owned()];
        let mut at = module;
        loop {
            let module = index.module(at);
            if module.is_block {
                return None;
            }
            let Some(parent) = module.parent else { break };
            parts.push(module.name.clone());
            at = parent;
        }
        parts.reverse();
        let rest = parts.join("::");
        let krate = index.crate_of(module);
        let (package, target) = (krate.package_name.as_str(), krate.name.as_str());
        // What a package depends on by a path is read as well, and its own.
        let is_own = self.is_alone && krate.is_reported;
        let firsts = if is_own { ["crate", package, target] } else { [package, target, "crate"] };
        firsts.into_iter().map(|first| format!("{first}::{rest}")).find(|path| {
            let found = index.named_by(self.scope, path, namespace);
            !found.is_empty() && found.iter().all(|def| self.place_of(def) == Some(place))
        })
    }

    /// Where an item is declared; a file that belongs to several crates declares its items once in each.
    fn place_of(&self, def: &Def) -> Option<Span> {
        let index = self.program.index;
        match def {
            Def::Type(id) => Some(index.type_def(*id).span),
            Def::Trait(id) => Some(index.trait_def(*id).span),
            Def::Function(id) => Some(index.function(*id).function.keyword),
            _ => None,
        }
    }
}
