//! Macros that one crate gives to others. Never tells the rules of one that may not be there.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use crate::source::SourceMap;
use crate::syntax::tree::{Item, ItemKind};

/// The macros that a library gives to other crates, by name: the text of their rules, or `None` where these are not certain.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Exports(BTreeMap<String, Option<Arc<str>>>);

impl Exports {
    /// Those among the items of a crate.
    pub(in crate::syntax) fn of(items: &[Item], texts: &SourceMap) -> Self {
        let mut exports = Self::default();
        exports.add(items, true, texts);
        exports
    }

    fn add(&mut self, items: &[Item], is_certain: bool, texts: &SourceMap) {
        for item in items {
            let is_certain = is_certain && item.cfg.is_none();
            match &item.kind {
                ItemKind::Mod(items) => self.add(items, is_certain, texts),
                ItemKind::MacroRules { rules, exported: true } => {
                    // Rules that a macro puts together are nowhere in the text.
                    let text = &texts.file(rules.file).text;
                    let written = text.get(rules.start as usize..rules.end as usize).filter(|_| is_certain);
                    let own = written.map(Arc::from);
                    self.0.entry(item.name.clone()).and_modify(|known| *known = None).or_insert(own);
                }
                _ => {}
            }
        }
    }

    /// Whether there are none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    pub(in crate::syntax) fn has(&self, name: &str) -> bool {
        self.0.contains_key(name)
    }

    pub(super) fn rules(&self, name: &str) -> Option<&str> {
        self.0.get(name)?.as_deref()
    }
}

/// What a crate can know of the crates that it depends on, by the names that it has for them.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Neighbours {
    /// Those whose macros are known by another name.
    pub renamed: BTreeSet<String>,
    /// The macros that others give to it.
    pub exports: BTreeMap<String, Arc<Exports>>,
}
