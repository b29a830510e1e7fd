//! The files that have a name from the imports of a module.

use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;

use super::imports::{blanked, segment_before};
use super::macros::Macros;
use super::text::{has_word, words};
use crate::flow::Program;
use crate::index::ModuleId;
use crate::source::FileId;
use crate::syntax::Outline;

/// Modules that import what other modules import, each of them what some of these have.
pub(super) struct Takers {
    /// The texts of their files without other modules in these, each with whether it is compiled for tests only.
    texts: Vec<(String, bool)>,
    /// Whether there may be more of them, in modules that are compiled under a condition.
    is_partial: bool,
}

impl Takers {
    /// Those that have one of the names from the imports of some modules. Nothing is told by the statements at `except`.
    pub(super) fn of(
        program: &Program<'_>,
        mut from: BTreeSet<ModuleId>,
        names: &BTreeSet<&str>,
        except: &(FileId, Range<usize>),
    ) -> Self {
        let index = program.index;
        let read = |file: FileId| &*program.sources.file(file).text;
        let files: BTreeMap<ModuleId, FileId> = index.modules_in_files().collect();
        let mut found: BTreeMap<FileId, BTreeSet<ModuleId>> = BTreeMap::new();
        let own: BTreeSet<FileId> = from.iter().filter_map(|module| index.module(*module).file).collect();
        loop {
            let others = files.iter().filter(|(module, _)| !from.contains(module));
            let is_named = |module: ModuleId, file: FileId| {
                let text = read(file);
                let modules: Vec<&str> = from.iter().map(|module| index.module(*module).name.as_str()).collect();
                let is_by_path = |at: &usize| match segment_before(text, *at) {
                    Some("super") => index.module(module).parent.is_some_and(|up| from.contains(&up)),
                    Some("crate") => modules.contains(&""),
                    Some(before) => !before.is_empty() && modules.contains(&before),
                    None => false,
                };
                names.iter().any(|name| words(text, name).any(|at| is_by_path(&at)))
            };
            let takes = |module: ModuleId, file: FileId| {
                let is_near = from.iter().any(|taken| index.module(*taken).krate == index.module(module).krate);
                is_near && (index.imports_from(module, &from, names) || is_named(module, file))
            };
            let new: Vec<_> = others.filter(|(module, file)| takes(**module, **file)).map(|(a, b)| (*a, *b)).collect();
            if new.is_empty() {
                break;
            }
            for (module, file) in new {
                from.insert(module);
                found.entry(file).or_default().insert(module);
            }
        }
        let is_partial = found.keys().chain(&own).any(|file| has_conditional_modules(read(*file)));
        let text = |(file, modules): (FileId, BTreeSet<ModuleId>)| {
            let is_test = modules.iter().all(|module| index.module(*module).is_test);
            let text = read(file);
            let around = modules.iter().flat_map(|module| {
                std::iter::successors(Some(index.module(*module)), |module| Some(index.module(module.parent?)))
            });
            let kept: BTreeSet<&str> = around.map(|module| module.name.as_str()).collect();
            let others = inline_modules(text).into_iter().filter(|(name, _)| !kept.contains(name));
            let but = Some(&except.1).filter(|_| except.0 == file).cloned();
            (blanked(text, others.map(|(_, range)| range).chain(but)), is_test)
        };
        Self { texts: found.into_iter().map(text).collect(), is_partial }
    }

    /// Whether one of the names or methods may be used there.
    pub(super) fn need<'n>(
        &self,
        words: impl Iterator<Item = &'n str> + Clone,
        macros: &Macros<'_>,
        without_tests: bool,
    ) -> bool {
        let mut texts = self.texts.iter().filter(|(_, is_test)| !(without_tests && *is_test));
        let is_used = |text: &str| words.clone().any(|word| has_word(text, word) || macros.call(word, text));
        self.is_partial || texts.any(|(text, _)| is_used(text))
    }

    /// Whether one of them may hand on to all what a module of that name has.
    pub(super) fn publish(&self, module: &str) -> bool {
        let is_in = |use_: &str| use_.split(';').next().is_some_and(|path| has_word(path, module));
        self.is_partial || self.texts.iter().any(|(text, _)| text.split("pub use ").skip(1).any(is_in))
    }
}

/// The modules that are written out in a text: their names, and where their bodies are.
fn inline_modules(text: &str) -> Vec<(&str, Range<usize>)> {
    let outline = Outline::of(text);
    let module = |at: usize| {
        let open = at + text[at..].find(['{', ';'])?;
        let own = outline.around(open + 1).next().filter(|own| own.brackets.start == open)?;
        Some((text[at + "mod".len()..open].trim(), own.brackets.clone()))
    };
    words(text, "mod").filter_map(module).collect()
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
