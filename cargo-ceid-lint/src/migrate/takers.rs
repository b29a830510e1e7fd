//! The files that have a name from the imports of a module.

use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;

use super::imports::{Sought, attributed, blanked, segment_before};
use super::macros::Macros;
use super::text::{has_word, without_comments, words};
use crate::flow::Program;
use crate::index::{Index, ModuleId};
use crate::source::FileId;
use crate::syntax::{Enclosure, Outline};

/// The condition of what is compiled for tests only.
pub(super) const FOR_TESTS: &str = "#[cfg(test)]";

/// Modules that import what other modules import, each of them what some of these have.
pub(super) struct Takers {
    /// The texts of their files without other modules in these, each with the condition under which it is compiled.
    texts: Vec<(String, Option<String>)>,
    /// Whether there may be more of them, in modules that are compiled under a condition.
    is_partial: bool,
    /// Whether there may be more of them among the tests.
    has_tests: bool,
}

impl Takers {
    /// Those that have one of the names from the imports of some modules. Nothing is told by the statements at `except`.
    pub(super) fn of(
        program: &Program<'_>,
        macros: &Macros<'_>,
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
            let modules: Vec<&str> = from.iter().map(|module| index.module(*module).name.as_str()).collect();
            let is_named = |module: ModuleId, file: FileId| {
                let code = macros.code(program, file);
                let text = &*code.text;
                let is_by_path = |at: &usize| match segment_before(text, *at) {
                    Some("super") => index.module(module).parent.is_some_and(|up| from.contains(&up)),
                    Some("crate") => modules.contains(&""),
                    Some(before) => !before.is_empty() && modules.contains(&before),
                    None => false,
                };
                let is_its = |at: &usize| is_by_path(at) && code.is_of(index, module, *at);
                names.iter().any(|name| words(text, name).any(|at| is_its(&at)))
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
        let files_among: Vec<&str> = found.keys().chain(&own).map(|file| read(*file)).collect();
        let is_partial = files_among
            .iter()
            .any(|text| has_modules_elsewhere(text, |attributes| attributes.replace(FOR_TESTS, "").contains("#[cfg(")));
        let has_tests =
            files_among.iter().any(|text| has_modules_elsewhere(text, |attributes| attributes.contains(FOR_TESTS)));
        let near: BTreeSet<_> = from.iter().map(|module| index.module(*module).krate).collect();
        let of_crate = files.iter().filter(|(module, _)| near.contains(&index.module(**module).krate));
        let of_crate: BTreeSet<FileId> = of_crate.map(|(_, file)| *file).collect();
        let names: BTreeSet<&str> = from.iter().map(|module| index.module(*module).name.as_str()).collect();
        let mut texts = Vec::new();
        for file in of_crate {
            let own_code = macros.code(program, file);
            let (code, items) = (&*own_code.text, &own_code.items);
            let is_among = own.contains(&file) || found.contains_key(&file);
            // What is compiled under a condition was perhaps not read, and is told by its words.
            let is_module = |item: &str| words(item, "mod").next().is_some_and(|at| !item[..at].contains(['{', ';']));
            let takes = |item: &str| {
                let is_named = |name: &&str| leads_to(item, if name.is_empty() { "crate" } else { name });
                is_among && (!is_module(item) || has_word(item, "super")) || names.iter().any(is_named)
            };
            // Around an import of the file itself, its own code is looked at word by word.
            let is_told = file == except.0 && !own_code.inline.iter().any(|(_, own)| own.contains(&except.1.start));
            let taking = items.iter().filter(|(item, _)| !is_told && takes(&code[item.clone()]));
            // The name that a module has itself is none that it uses.
            let inside = |item: &str| match item.find('{').filter(|_| is_module(item)) {
                Some(open) => item[open..].to_owned(),
                None => item.to_owned(),
            };
            texts.extend(taking.map(|(item, condition)| (inside(&code[item.clone()]), Some(condition.clone()))));
            if let Some(modules) = found.get(&file) {
                let is_test = modules.iter().all(|module| index.module(*module).is_test);
                let around = modules.iter().flat_map(|module| {
                    std::iter::successors(Some(index.module(*module)), |module| Some(index.module(module.parent?)))
                });
                let kept: BTreeSet<&str> = around.map(|module| module.name.as_str()).collect();
                let others = own_code.inline.iter().filter(|(name, _)| !kept.contains(&**name));
                let but = Some(&except.1).filter(|_| except.0 == file).cloned();
                let conditional = items.iter().map(|(item, _)| item.clone());
                let hidden = others.map(|(_, range)| range.clone()).chain(conditional).chain(but);
                texts.push((blanked(code, hidden), is_test.then(|| FOR_TESTS.to_owned())));
            }
        }
        Self { texts, is_partial, has_tests }
    }

    /// Whether one of the names or methods may be used there.
    pub(super) fn need<'n>(
        &self,
        words: impl Iterator<Item = &'n str> + Clone,
        macros: &Macros<'_>,
        without_tests: bool,
    ) -> bool {
        let is_for_tests = |condition: &Option<&str>| *condition == Some(FOR_TESTS);
        self.is_partial
            || self.has_tests && !without_tests
            || self.conditions(words, macros).any(|condition| !(without_tests && is_for_tests(&condition)))
    }

    /// Whether one of them is said in code that is under no condition.
    pub(super) fn surely_need<'n>(&self, words: impl Iterator<Item = &'n str> + Clone, macros: &Macros<'_>) -> bool {
        self.conditions(words, macros).any(|condition| condition.is_none())
    }

    /// The condition under which alone they may be used there.
    pub(super) fn only_condition<'n>(
        &self,
        words: impl Iterator<Item = &'n str> + Clone,
        macros: &Macros<'_>,
    ) -> Option<&str> {
        let tests = self.has_tests.then_some(Some(FOR_TESTS));
        let mut conditions = tests.into_iter().chain(self.conditions(words, macros));
        let first = conditions.next()??;
        conditions.all(|other| other == Some(first)).then_some(first).filter(|_| !self.is_partial)
    }

    /// The conditions under which they may be used there, nothing for none.
    fn conditions<'n>(
        &self,
        words: impl Iterator<Item = &'n str> + Clone,
        macros: &Macros<'_>,
    ) -> impl Iterator<Item = Option<&str>> {
        let is_used = move |text: &str| words.clone().any(|word| has_word(text, word) || macros.call(word, text));
        let using = self.texts.iter().filter(move |(text, _)| is_used(text));
        using.map(|(_, condition)| condition.as_deref())
    }

    /// Whether one of them may hand on to all what a module of that name has.
    pub(super) fn publish(&self, module: &str) -> bool {
        let is_in = |use_: &str| use_.split(';').next().is_some_and(|path| has_word(path, module));
        self.is_partial
            || self.has_tests
            || self.texts.iter().any(|(text, _)| text.split("pub use ").skip(1).any(is_in))
    }
}

/// The code of a file without comments.
pub(super) struct Code {
    text: String,
    /// What is compiled under a condition, and that.
    items: Vec<(Range<usize>, String)>,
    /// The modules that are written out in it.
    inline: Vec<(String, Range<usize>)>,
}

impl Code {
    pub(super) fn of(text: &str) -> Self {
        let text = without_comments(text);
        let outline = Outline::of(&text);
        let items = conditional(&outline, &text);
        let inline = inline_modules(&outline, &text).map(|(keyword, own)| {
            let name = text[keyword + "mod".len()..own.brackets.start].trim();
            (name.to_owned(), own.brackets.clone())
        });
        let inline = inline.collect();
        Self { items, inline, text }
    }

    /// Whether a byte belongs to the code of a module or of the one around a block, and not to that of another module or to what is
    /// compiled under a condition.
    fn is_of(&self, index: &Index, module: ModuleId, at: usize) -> bool {
        let mut module = index.module(module);
        while let Some(around) = module.parent.filter(|_| module.is_block) {
            module = index.module(around);
        }
        let is_inline = module.parent.is_some_and(|around| index.module(around).file == module.file);
        let innermost =
            self.inline.iter().filter(|(_, range)| range.contains(&at)).min_by_key(|(_, range)| range.len());
        let is_own = match innermost {
            Some((name, _)) => is_inline && *name == module.name,
            None => !is_inline,
        };
        is_own && !self.items.iter().any(|(item, _)| item.contains(&at))
    }
}

/// The modules that are written out in a text: where the keyword of each stands, and the brackets around its body.
pub(super) fn inline_modules<'t>(outline: &'t Outline, text: &'t str) -> impl Iterator<Item = (usize, &'t Enclosure)> {
    words(text, "mod").filter_map(move |keyword| {
        let open = keyword + text[keyword..].find(['{', ';'])?;
        let own = outline.around(open + 1).next().filter(|own| own.brackets.start == open)?;
        Some((keyword, own))
    })
}

/// Whether a path in some code leads to a module of that name, or an import may.
fn leads_to(code: &str, module: &str) -> bool {
    words(code, module).any(|at| {
        let is_imported = || has_word(code[..at].rsplit(';').next().unwrap_or_default(), "use");
        code[at + module.len()..].trim_start().starts_with("::") || is_imported()
    })
}

/// Whether the code in the brackets of a module may have something from around it: by `crate`, or by more `super`s than modules are in
/// between. A trait whose method is called has to be imported, by its name or with all others.
pub(super) fn looks_outside(outline: &Outline, code: &str, brackets: &Range<usize>, sought: Sought) -> bool {
    let inner = &code[brackets.clone()];
    let is_visibility = |at: usize| {
        let before = inner[..at].trim_end();
        let before = before.strip_suffix("in").unwrap_or(before).trim_end().strip_suffix('(');
        before.is_some_and(|before| before.trim_end().ends_with("pub"))
    };
    let modules_around = |at: usize| {
        let is_around = |own: &Enclosure| own.brackets.start > brackets.start && own.brackets.contains(&at);
        inline_modules(outline, code).filter(|(_, own)| is_around(own)).count()
    };
    let leads_out = |at: usize| {
        let (mut rest, mut supers) = (&inner[at..], 0);
        while let Some(behind) = rest.strip_prefix("super") {
            supers += 1;
            rest = behind.trim_start().trim_start_matches(':').trim_start();
        }
        let is_split = rest.starts_with('{') && rest.split(';').next().is_some_and(|list| has_word(list, "super"));
        is_split || supers > modules_around(brackets.start + at)
    };
    let is_wanted = |at: usize| {
        let path = inner[at..].split(';').next().unwrap_or_default();
        sought == Sought::Names || ["::*", "{*", ", *"].iter().any(|all| path.contains(all))
    };
    let from_super = |at: usize| segment_before(inner, at) != Some("super") && leads_out(at);
    let crates = words(inner, "crate");
    crates.chain(words(inner, "super").filter(|at| from_super(*at))).any(|at| !is_visibility(at) && is_wanted(at))
}

/// What is compiled under a condition in code without comments, and that.
fn conditional(outline: &Outline, code: &str) -> Vec<(Range<usize>, String)> {
    let found = ["#[cfg(", "#[test]"].into_iter().flat_map(|begin| attributed(outline, code, begin));
    let mut found: Vec<_> = found.collect();
    found.sort_by_key(|(item, _)| (item.start, std::cmp::Reverse(item.end)));
    let mut outer: Vec<(Range<usize>, String)> = Vec::new();
    for (item, attribute) in found {
        let is_test = matches!(attribute.replace(' ', "").as_str(), FOR_TESTS | "#[test]");
        if outer.last().is_none_or(|(last, _)| last.end <= item.start) {
            outer.push((item, if is_test { FOR_TESTS.to_owned() } else { attribute }));
        }
    }
    outer
}

/// Whether modules in other files stand under such attributes, and perhaps were not read.
fn has_modules_elsewhere(text: &str, is_such: impl Fn(&str) -> bool) -> bool {
    words(text, "mod").any(|at| {
        let before = text[..at].rfind([';', '}', '{']).map_or(0, |end| end + 1);
        let rest = &text[at + "mod".len()..];
        let is_elsewhere = rest.find([';', '{']).is_some_and(|end| rest[end..].starts_with(';'));
        is_elsewhere && is_such(&text[before..at])
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[track_caller]
    fn check(inner: &str, expected: bool) {
        check_for(Sought::Names, inner, expected);
    }

    #[track_caller]
    fn check_for(sought: Sought, inner: &str, expected: bool) {
        let code = format!("mod m {{ {inner} }} mod n {{ use super::x; }}");
        let outline = Outline::of(&code);
        let brackets = inline_modules(&outline, &code).next().expect("there is one").1.brackets.clone();
        assert_eq!(looks_outside(&outline, &code, &brackets, sought), expected, "{inner}");
    }

    #[test]
    fn paths_lead_out_of_a_module() {
        check("use super::a;", true);
        check("fn f() { crate::a(); }", true);
        check("mod p { use super::super::a; }", true);
        check("mod p { use super::{b, super::a}; }", true);
        check("mod p { mod q { super::super::super::a!(); } }", true);
    }

    #[test]
    fn visibilities_and_inner_paths_stay_in_it() {
        check("pub(crate) fn f() {} pub(super) fn g() {} pub(in crate::m) struct A;", false);
        check("mod p { use super::a; }", false);
        check("mod p { mod q { use super::super::a; } }", false);
    }

    #[test]
    fn a_variable_is_no_module_of_its_name() {
        assert!(leads_to("fn f() { pid::g(); }", "pid") && leads_to("mod t { use crate::{kf, pid}; }", "pid"));
        assert!(!leads_to("fn f() { use a::B; let mut pid = B::new(); pid.update(); }", "pid"));
    }

    #[test]
    fn methods_come_with_all_that_is_around() {
        check_for(Sought::Calls, "use super::*; fn f() { a.u(); }", true);
        check_for(Sought::Calls, "use crate::{b::A, *};", true);
        check_for(Sought::Calls, "use crate::b::A; mod p { use super::*; }", false);
        check_for(Sought::Calls, "use super::A;", false);
    }
}
