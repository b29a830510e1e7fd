//! The files that have a name from the imports of another one.

use std::collections::{BTreeMap, BTreeSet};

use super::imports::segment_before;
use super::text::{has_word, words};
use crate::flow::Program;
use crate::index::ModuleId;
use crate::source::FileId;

/// Files whose modules import from those of one file what is imported there.
pub(super) struct Takers<'a> {
    /// Their texts, each with whether it is compiled for tests only.
    texts: Vec<(&'a str, bool)>,
    /// Whether there may be more of them, in modules that are compiled under a condition.
    is_partial: bool,
}

impl<'a> Takers<'a> {
    /// Those that have one of the names from the imports at the top of a file.
    pub(super) fn of(program: &Program<'a>, file: FileId, names: &BTreeSet<&str>) -> Self {
        let index = program.index;
        let mut files: BTreeMap<ModuleId, FileId> = BTreeMap::new();
        for def in &index.functions {
            let mut at = Some(def.module);
            // A module without functions of its own lies where those of its modules are, as far as is known.
            while let Some(module) = at
                && !files.contains_key(&module)
            {
                files.insert(module, def.function.keyword.file);
                at = index.module(module).parent;
            }
        }
        for def in &index.functions {
            files.insert(def.module, def.function.keyword.file);
        }
        let mut from: BTreeSet<ModuleId> =
            files.iter().filter(|(_, own)| **own == file).map(|(module, _)| *module).collect();
        let mut found: BTreeMap<FileId, bool> = BTreeMap::new();
        loop {
            let others = files.iter().filter(|(module, _)| !from.contains(module));
            let is_named = |module: ModuleId, own: FileId| {
                let text = &program.sources.file(own).text;
                let modules: Vec<&str> = from.iter().map(|module| index.module(*module).name.as_str()).collect();
                let is_by_path = |at: &usize| match segment_before(text, *at) {
                    Some("super") => index.module(module).parent.is_some_and(|up| from.contains(&up)),
                    Some("crate") => modules.contains(&""),
                    Some(before) => !before.is_empty() && modules.contains(&before),
                    None => false,
                };
                names.iter().any(|name| words(text, name).any(|at| is_by_path(&at)))
            };
            let takes = |module: ModuleId, own: FileId| {
                let is_near = from.iter().any(|taken| index.module(*taken).krate == index.module(module).krate);
                is_near && (index.imports_from(module, &from, names) || is_named(module, own))
            };
            let new: Vec<_> = others.filter(|(module, own)| takes(**module, **own)).map(|(a, b)| (*a, *b)).collect();
            if new.is_empty() {
                break;
            }
            for (module, own) in new {
                from.insert(module);
                let is_test = index.module(module).is_test;
                found.entry(own).and_modify(|all| *all &= is_test).or_insert(is_test);
            }
        }
        found.remove(&file);
        let read = |own: &FileId| &*program.sources.file(*own).text;
        let is_partial = found.keys().chain([&file]).any(|own| has_conditional_modules(read(own)));
        let text = |(own, is_test): (FileId, bool)| (read(&own), is_test);
        Self { texts: found.into_iter().map(text).collect(), is_partial }
    }

    /// Whether one of the names or methods may be used there.
    pub(super) fn need<'n>(&self, words: impl Iterator<Item = &'n str> + Clone, without_tests: bool) -> bool {
        let mut texts = self.texts.iter().filter(|(_, is_test)| !(without_tests && *is_test));
        self.is_partial || texts.any(|(text, _)| words.clone().any(|word| has_word(text, word)))
    }
}

/// Whether modules in other files stand under a condition, and perhaps were not read.
fn has_conditional_modules(text: &str) -> bool {
    words(text, "mod").any(|at| {
        let before = text[..at].rfind([';', '}', '{']).map_or(0, |end| end + 1);
        let rest = &text[at + "mod".len()..];
        let is_elsewhere = rest.find([';', '{']).is_some_and(|end| rest[end..].starts_with(';'));
        is_elsewhere && text[before..at].contains("#[cfg(")
    })
}
