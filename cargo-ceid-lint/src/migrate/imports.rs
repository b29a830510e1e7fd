//! Imports of filters and their traits that were there for calls of a law, in files whose loops have a guard.

use std::collections::BTreeSet;
use std::ops::Range;

use super::globs;
use super::import::{Import, Text, either};
use super::macros::Macros;
use super::takers::{FOR_TESTS, Takers, inline_modules, looks_outside};
use super::text::{code_only, has_word, with_attributes, without_comments, words};
use crate::count::{Cycle, Verdict};
use crate::flow::Program;
use crate::index::{Def, FunctionId, ModuleId, Namespace, Owner, TraitId, TraitName, Ty};
use crate::source::{FileId, Span};
use crate::syntax::Outline;
use crate::syntax::tree::{ExprId, ExprKind, MacroKind};
use crate::types::{Callee, Resolved};

/// The imports that were there for calls of a law.
#[derive(Clone, Debug, Default)]
pub struct IdleImports {
    /// The edits that remove each of those that nothing needs.
    pub removals: Vec<Vec<(Span, String)>>,
    /// Those that hand on to other modules what nothing needs.
    pub handed_on: Vec<HandedOn>,
    /// Those that stay though perhaps nothing needs them.
    pub doubtful: Vec<Doubtful>,
}

/// An import that stays though perhaps nothing needs it.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Doubtful {
    /// Where it stands.
    pub span: Span,
    /// What it imports.
    pub name: String,
    /// Whether code under a condition may need it.
    pub is_conditional: bool,
}

/// An import that hands on what nothing needs.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct HandedOn {
    /// What removes it.
    pub edits: Vec<(Span, String)>,
    /// What it imports.
    pub name: String,
    /// The methods that can be called because of it.
    pub methods: Vec<String>,
}

impl HandedOn {
    /// Whether the text of a file has less that needs it than before.
    #[must_use]
    pub fn is_said_less(&self, before: &str, now: &str) -> bool {
        let calls = |text: &str, method: &str| {
            let is_call = |at: &usize| {
                let args = text[at + method.len()..].trim_start().strip_prefix('(');
                // What hands a law on to the one that was there is no call that a loop had.
                args.is_some_and(|args| !args.starts_with("self)")) && !text[..*at].trim_end().ends_with("fn")
            };
            words(text, method).filter(is_call).count()
        };
        let said = |text: &str| match self.methods.as_slice() {
            [] => words(text, &self.name).count(),
            methods => methods.iter().map(|method| calls(text, method)).sum(),
        };
        said(now) < said(before)
    }
}

/// The imports that calls of a law needed, in files whose loops have a guard.
#[must_use]
pub fn idle_imports(program: &Program<'_>, cycles: &[Cycle]) -> IdleImports {
    let has_guard = |cycle: &&Cycle| cycle.filters.iter().any(|pair| pair.verdict == Verdict::Guarded);
    let files: BTreeSet<FileId> = cycles.iter().filter(has_guard).map(|cycle| cycle.head.file).collect();
    let files: BTreeSet<FileId> = files.into_iter().filter(|file| has_ceid(program, *file)).collect();
    let mut found = IdleImports::default();
    if files.is_empty() {
        return found;
    }
    let index = program.index;
    let own = (0..).map(TraitId).zip(&index.traits).map(|(id, def)| (def.name.as_str(), id));
    let has_methods = |(_, id): &(&str, TraitId)| !index.trait_def(*id).methods.is_empty();
    let traits = own.chain(index.renamed_traits()).filter(has_methods).map(|(name, id)| {
        let def = index.trait_def(id);
        let is_of_trait = |owner: &Owner| match owner {
            Owner::Module => false,
            Owner::Impl(id) => index.impl_def(*id).trait_path.as_ref().is_some_and(|path| path.last() == def.name),
            Owner::Trait(id) => index.trait_def(*id).name == def.name,
        };
        let constants = index.values.iter().filter(|value| is_of_trait(&value.owner)).map(|value| &value.name);
        (name, def.module, Some(id), def.methods.keys().chain(constants).collect::<Vec<_>>())
    });
    let filters = index.filter_types().map(|def| (def.name.as_str(), def.module, None, Vec::new()));
    let traits: Vec<_> = traits.collect();
    // A law may have been called by the path of a module: `filter::Step::step(&mut kf)`.
    let homes: BTreeSet<ModuleId> = traits.iter().map(|(_, module, ..)| *module).collect();
    let homes = homes.into_iter().filter_map(|home| Some((index.module(home), index.module(home).parent?)));
    let homes = homes.filter(|(home, _)| !home.is_block && !home.name.is_empty());
    let homes = homes.map(|(home, parent)| (home.name.as_str(), parent, None, Vec::new()));
    let named: Vec<_> = traits.iter().cloned().chain(filters).chain(homes).collect();
    let macros = Macros::of(program);
    for file in handing_on(program, &files) {
        let text = &*program.sources.file(file).text;
        let code = &*code_only(text);
        let outline = Outline::of(text);
        let functions = written_in(program, file);
        let has_guard = files.contains(&file);
        for (name, module, trait_id, methods) in &named {
            let (outline, functions, macros, trait_id) = (&outline, &functions[..], &macros, *trait_id);
            let module = *module;
            let scope =
                Scope { program, file, functions, text, code, outline, name, module, trait_id, methods, macros };
            for at in words(code, name) {
                if let Some(edits) = scope.import(at, true) {
                    let methods = methods.iter().map(|method| (*method).clone()).collect();
                    found.handed_on.push(HandedOn { edits, name: (*name).to_owned(), methods });
                } else if has_guard {
                    match scope.import(at, false) {
                        Some(edits) => found.removals.push(edits),
                        None => found.doubtful.extend(scope.doubt(at)),
                    }
                }
            }
        }
        if has_guard {
            globs::idle(program, file, text, &outline, &functions, &macros, &mut found);
        }
    }
    found
}

/// These files and those of their crates in which imports may hand something on.
fn handing_on(program: &Program<'_>, files: &BTreeSet<FileId>) -> BTreeSet<FileId> {
    let index = program.index;
    let modules: Vec<_> = index.modules_in_files().map(|(module, file)| (index.module(module).krate, file)).collect();
    let crates: BTreeSet<_> =
        modules.iter().filter(|(_, file)| files.contains(file)).map(|(krate, _)| *krate).collect();
    let own = modules.into_iter().filter(|(krate, _)| crates.contains(krate)).map(|(_, file)| file);
    own.filter(|file| has_word(&program.sources.file(*file).text, "pub")).chain(files.iter().copied()).collect()
}

/// Whether a guard of free variables stands in the file: what a migration writes.
fn has_ceid(program: &Program<'_>, file: FileId) -> bool {
    let bodies = program.index.functions.iter().filter_map(|def| def.function.body.as_ref());
    let mut exprs = bodies.filter(|body| body.expr(body.root).span.file == file).flat_map(|body| &body.exprs);
    exprs.any(|expr| matches!(&expr.kind, ExprKind::Macro(call) if matches!(call.kind, MacroKind::Ceid { .. })))
}

/// The functions whose bodies stand in a file.
fn written_in(program: &Program<'_>, file: FileId) -> Vec<FunctionId> {
    let index = program.index;
    let body = |id: &FunctionId| index.function(*id).function.body.as_ref();
    index.function_ids().filter(|id| body(id).is_some_and(|body| body.expr(body.root).span.file == file)).collect()
}

pub(super) fn to_u32(at: usize) -> u32 {
    u32::try_from(at).unwrap_or(u32::MAX)
}

/// What an import may be there for.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Sought {
    Names,
    Calls,
}

/// A file that may import a trait or type.
pub(super) struct Scope<'a> {
    pub(super) program: &'a Program<'a>,
    pub(super) file: FileId,
    /// The functions in it.
    pub(super) functions: &'a [FunctionId],
    pub(super) text: &'a str,
    /// What of it is code.
    pub(super) code: &'a str,
    pub(super) outline: &'a Outline,
    pub(super) name: &'a str,
    pub(super) module: ModuleId,
    /// Set for a trait.
    pub(super) trait_id: Option<TraitId>,
    /// The methods that can be called because of the import, and the constants that can be named.
    pub(super) methods: &'a [&'a String],
    pub(super) macros: &'a Macros<'a>,
}

impl Scope<'_> {
    pub(super) fn written(&self) -> Text<'_> {
        Text { text: self.text, code: self.code }
    }

    /// What removes the import whose name stands at a byte, if nothing in the block or module around it needs it, and nothing that
    /// has the name from there.
    fn import(&self, at: usize, hands_on: bool) -> Option<Vec<(Span, String)>> {
        let Self { program, file, text, name, macros, .. } = *self;
        let import = Import::at(self.written(), at, name)
            .or_else(|| Import::of_itself(self.written(), at, name))
            .or_else(|| Import::conditional(self.written(), at, name))?;
        if self.is_of_core(&import) || import.visibility.is_empty() == hands_on {
            return None;
        }
        let bound = import.alias.unwrap_or(name);
        let is_of_tests = || self.tests(&without_comments(text)).any(|test| test.contains(&import.stmt.start));
        if self.is_of_other(&import) || is_of_tests() {
            return None;
        }
        let around = self.outline.around(import.stmt.start).next();
        let scope = around.map_or(0..text.len(), |around| around.brackets.clone());
        let names: BTreeSet<&str> = Some(bound).into_iter().filter(|bound| *bound != "_").collect();
        let from = match hands_on {
            true => self.importing(&import, bound),
            false => modules_in(program, file),
        };
        if hands_on && from.is_empty() {
            return None;
        }
        let takers = (hands_on || around.is_none())
            .then(|| Takers::of(program, macros, from.clone(), &names, &(file, import.stmt.clone())));
        if import.visibility == "pub" && !takers.as_ref().is_some_and(|takers| self.is_inside(&from, takers)) {
            return None;
        }
        let taken = |without_tests: bool| {
            takers.as_ref().filter(|takers| takers.need(self.wanted(&names), macros, without_tests))
        };
        let is_used = |without_tests: bool| {
            let sight = |of| without_comments(&self.seen(&import, &scope, without_tests, of));
            self.is_used(&import, &sight(Sought::Names), &sight(Sought::Calls), &scope)
        };
        let is_needed = |without_tests: bool| taken(without_tests).is_some() || is_used(without_tests);
        let edits = if is_needed(true) {
            let of_takers = |takers: &Takers| takers.only_condition(self.wanted(&names), macros).map(str::to_owned);
            let own = || self.only_condition(&import, &scope);
            let condition = match taken(false) {
                Some(takers) if !is_used(false) => of_takers(takers),
                Some(takers) => either(&[&own()?, &of_takers(takers)?]),
                None => own(),
            };
            import.under(text, &condition?)?
        } else if is_needed(false) {
            import.under(text, if self.is_linked(bound) { "#[cfg(any(doc, test))]" } else { FOR_TESTS })?
        } else if self.is_linked(bound) {
            import.under(text, "#[cfg(doc)]")?
        } else {
            vec![import.without(text)?]
        };
        let placed =
            |(range, new): (Range<usize>, String)| (Span::new(file, to_u32(range.start), to_u32(range.end)), new);
        Some(edits.into_iter().map(placed).collect())
    }

    /// The modules in which an import may stand: of those of its file that import something by that name.
    fn importing(&self, import: &Import<'_>, bound: &str) -> BTreeSet<ModuleId> {
        let index = self.program.index;
        let around = self.outline.around(import.stmt.start).next();
        let head = around.map(|around| self.text[around.head.start..around.brackets.start].trim());
        let is_around = |id: &ModuleId| {
            let module = index.module(*id);
            match head.map(|head| head.rsplit_once(char::is_whitespace)) {
                None => module.parent.is_none_or(|parent| index.module(parent).file != module.file),
                Some(Some((before, name))) => name == module.name && before.ends_with("mod"),
                Some(None) => false,
            }
        };
        index.importing(self.file, bound).into_iter().filter(is_around).collect()
    }

    /// Whether an import is known to mean something else of that name.
    pub(super) fn is_of_other(&self, import: &Import<'_>) -> bool {
        let index = self.program.index;
        let Some(path) = import.path(self.text) else { return false };
        let is_other = |def: Def| match def {
            Def::Trait(id) => index.trait_def(id).module != self.module,
            Def::Type(id) => index.type_def(id).module != self.module,
            Def::Module(id) => index.module(id).parent != Some(self.module),
            _ => false,
        };
        let homes = self.homes(import.stmt.start).filter_map(|home| index.resolve(home, &path, Namespace::Type));
        let mut homes = homes.peekable();
        homes.peek().is_some() && homes.all(is_other)
    }

    /// The modules that a byte of the file may lie in.
    pub(super) fn homes(&self, at: usize) -> impl Iterator<Item = ModuleId> {
        let index = self.program.index;
        let name = self.outline.around(at).find_map(|around| {
            let head = self.text[around.head.start..around.brackets.start].trim();
            head.rsplit_once(char::is_whitespace).filter(|(before, _)| before.ends_with("mod")).map(|(_, name)| name)
        });
        let is_home = move |id: &ModuleId| {
            let module = index.module(*id);
            let is_inline = module.parent.is_some_and(|parent| index.module(parent).file == module.file);
            !module.is_block && name.map_or(!is_inline, |name| is_inline && module.name == name)
        };
        let own = self.file;
        index.modules_in_files().filter(move |(_, file)| *file == own).map(|(id, _)| id).filter(is_home)
    }

    /// Whether other crates cannot have what these modules hand on.
    fn is_inside(&self, from: &BTreeSet<ModuleId>, takers: &Takers) -> bool {
        let module = |id: ModuleId| self.program.index.module(id);
        let around = |id: ModuleId| std::iter::successors(Some(module(id)), |inner| inner.parent.map(module));
        let is_inside = |id: &ModuleId| around(*id).any(|around| around.is_private);
        from.iter().all(|id| is_inside(id) && !takers.publish(&module(*id).name))
    }

    /// What code says that needs the import.
    pub(super) fn wanted<'n>(&'n self, names: &'n BTreeSet<&str>) -> impl Iterator<Item = &'n str> + Clone {
        names.iter().copied().chain(self.methods.iter().map(|method| method.as_str()))
    }

    /// Whether code around an import has its name, or calls what it is there for.
    pub(super) fn is_used(&self, import: &Import<'_>, code: &str, calls: &str, scope: &Range<usize>) -> bool {
        let is_outside = |at: usize| scope.contains(&at) && !import.stmt.contains(&at);
        let bound = import.alias.unwrap_or(self.name);
        bound != "_" && words(code, bound).any(|at| is_outside(at) && self.may_be_imported(import, code, at))
            || self.methods.iter().any(|method| self.is_called(method, calls, scope))
    }

    /// Whether documentation links to something by a name, for which it may have to be imported.
    fn is_linked(&self, bound: &str) -> bool {
        [format!("[`{bound}`]"), format!("[{bound}]")].iter().any(|link| self.text.contains(link))
    }

    /// The attribute under which an import is needed: the one that stands above all code that needs it, or one that holds where any of
    /// those does. None if other code needs it, too.
    fn only_condition(&self, import: &Import<'_>, scope: &Range<usize>) -> Option<String> {
        let [code, calls] =
            [Sought::Names, Sought::Calls].map(|of| without_comments(&self.seen(import, scope, false, of)));
        let mut items = self.conditional(&code);
        // What the import stands in has its condition already.
        items.retain(|(item, _)| !item.contains(&import.stmt.start));
        let is_used_without = |is_hidden: &dyn Fn(&str) -> bool| {
            let hidden = || items.iter().filter(|(_, own)| is_hidden(own)).map(|(item, _)| item.clone());
            self.is_used(import, &blanked(&code, hidden()), &blanked(&calls, hidden()), scope)
        };
        let conditions: BTreeSet<&str> = items.iter().map(|(_, condition)| condition.as_str()).collect();
        if let Some(only) = conditions.iter().find(|own| !is_used_without(&|other| other == **own)) {
            return Some((*only).to_owned());
        }
        let asks = |own: &&str| is_used_without(&|other| other != *own);
        let asking: Vec<&str> = conditions.into_iter().filter(asks).collect();
        if is_used_without(&|own| asking.contains(&own)) {
            return None;
        }
        either(&asking)
    }

    /// Whether an import may mean ceid-core, whose trait may have the same name.
    pub(super) fn is_of_core(&self, import: &Import<'_>) -> bool {
        self.text[import.stmt.clone()].contains("ceid_core")
            || self.program.index.crate_of(self.module).package_name == "ceid_core"
    }

    /// Code with blanks for its comments and for the items that are compiled under a condition.
    pub(super) fn unconditional(&self, code: &str) -> String {
        let code = without_comments(code);
        blanked(&code, self.conditional(&code).into_iter().map(|(item, _)| item))
    }

    /// What is compiled under a condition in code without comments, with the attribute that says so.
    fn conditional(&self, code: &str) -> Vec<(Range<usize>, String)> {
        attributed(self.outline, code, "#[cfg(")
    }

    /// What is compiled for tests only in code without comments.
    fn tests(&self, code: &str) -> impl Iterator<Item = Range<usize>> {
        let begins = ["#[test]", FOR_TESTS].into_iter();
        begins.flat_map(move |begin| attributed(self.outline, code, begin)).map(|(test, _)| test)
    }

    /// The text with blanks for the modules in a part of it that do not see what is imported there, and for those of tests where that is asked.
    pub(super) fn in_sight(&self, scope: &Range<usize>, without_tests: bool, sought: Sought) -> String {
        let text = self.text;
        let code = without_comments(text);
        let mut hidden = Vec::new();
        for (keyword, own) in inline_modules(self.outline, text).filter(|(keyword, _)| scope.contains(keyword)) {
            let attributes = &text[with_attributes(text, own.head.start)..keyword];
            let is_test = attributes.replace(' ', "").contains("#[cfg(test)]");
            let looks_up = looks_outside(self.outline, &code, &own.brackets, sought);
            if !looks_up || is_test && without_tests {
                hidden.push(own.brackets.clone());
            }
        }
        if without_tests {
            // A test may also stand beside what it tests, and what it needs beside what others need.
            hidden.extend(self.tests(&code));
        }
        blanked(text, hidden.into_iter())
    }

    /// Whether a name may be that of the import: by another path than that of its module, it is not.
    fn may_be_imported(&self, import: &Import<'_>, code: &str, at: usize) -> bool {
        let index = self.program.index;
        let own = &index.module(self.module).name;
        // The root of a crate has no name of its own.
        let own = if own.is_empty() { "crate" } else { own };
        match segment_before(code, at) {
            Some(before) if before == own => false,
            None | Some("" | "self" | "super" | "crate") => true,
            Some(before) => self.homes(import.stmt.start).any(|home| index.module(home).name == before),
        }
    }

    /// Whether a call runs what another trait has. Where a type has several traits, one of them may stand for another.
    fn is_of_another_trait(&self, call: &Resolved) -> bool {
        let Some(own) = self.trait_id else { return false };
        let index = self.program.index;
        let is_other = |target: &FunctionId| match index.function(*target).owner {
            Owner::Impl(id) => {
                matches!(&index.impl_def(id).implements, Some(TraitName::Local(other)) if *other != own)
            }
            Owner::Trait(id) => id != own,
            Owner::Module => false,
        };
        matches!(call.self_ty, Ty::Adt(..))
            && !call.targets.is_empty()
            && call.targets.iter().all(is_other)
            && !index.implements(&call.self_ty, &TraitName::Local(own))
    }

    /// Whether a method of the trait may be called in a part of the code: each call of that name is known, or is one.
    pub(super) fn is_called(&self, method: &str, code: &str, scope: &Range<usize>) -> bool {
        let part = &code[scope.clone()];
        let count = |call: String| part.matches(&call).count();
        // A call by the path of the trait names it, and is looked for by that name.
        let is_by_trait = |at: &usize| segment_before(part, *at) == Some(self.name);
        let by_path =
            words(part, method).filter(|at| segment_before(part, *at).is_some()).filter(|at| !is_by_trait(at));
        let written = count(format!(".{method}(")) + count(format!(".{method}::")) + by_path.count();
        let index = self.program.index;
        // A method of the type itself needs no import.
        let is_inherent = |target: &FunctionId| match index.function(*target).owner {
            Owner::Impl(id) => index.impl_def(id).implements.is_none() && index.impl_def(id).trait_path.is_none(),
            _ => false,
        };
        let is_other = |id: FunctionId| {
            let (Some(body), Some(typed)) = (&index.function(id).function.body, self.program.typed(id)) else {
                return 0;
            };
            let is_here = |call: &ExprId| {
                let span = body.expr(*call).span;
                span.file == self.file
                    && scope.contains(&(span.start as usize))
                    && code[span.start as usize..].starts_with(|first: char| first != ' ')
                    && matches!(&body.expr(*call).kind, ExprKind::MethodCall { method: own, .. } if own == method)
            };
            let others = typed.callees.iter().filter(|(call, callee)| {
                let Callee::Resolved(resolved) = callee else { return false };
                let is_own = !resolved.targets.is_empty() && resolved.targets.iter().all(is_inherent);
                (is_own || self.is_of_another_trait(resolved)) && is_here(call)
            });
            others.count()
        };
        written > 0 && written != self.functions.iter().copied().map(is_other).sum::<usize>()
            || self.macros.call(method, part)
    }
}

/// What has an attribute that begins like this, in code without comments, with the attribute.
pub(super) fn attributed(outline: &Outline, code: &str, begin: &str) -> Vec<(Range<usize>, String)> {
    let of = |(at, _): (usize, &str)| {
        let attribute = outline.around(at + "#[".len()).next()?;
        let close = Some(attribute.brackets.end).filter(|_| attribute.brackets.start == at + 1)?;
        let mut behind = close;
        while let Some(length) = code[behind..].find(['{', ';', ',', '}', ')', ']', '(', '[']) {
            let sign = behind + length;
            let own = || outline.around(sign + 1).next().filter(|own| own.brackets.start == sign);
            behind = match code.as_bytes()[sign] {
                b'(' | b'[' => own()?.brackets.end,
                b'{' => return Some((at..own()?.brackets.end, code[at..close].to_owned())),
                b';' | b',' => return Some((at..sign + 1, code[at..close].to_owned())),
                _ => return Some((at..sign, code[at..close].to_owned())),
            };
        }
        None
    };
    code.match_indices(begin).filter_map(of).collect()
}

/// Code with blanks for parts of it.
pub(super) fn blanked(code: &str, parts: impl Iterator<Item = Range<usize>>) -> String {
    let mut left = code.as_bytes().to_vec();
    parts.for_each(|part| left[part].fill(b' '));
    String::from_utf8(left).unwrap_or_else(|_| code.to_owned())
}

/// The part of a path that stands before the name at a byte, if it is not the first one.
pub(super) fn segment_before(code: &str, at: usize) -> Option<&str> {
    let before = code[..at].trim_end().strip_suffix("::")?.trim_end();
    let start = before.rfind(|sign: char| !(sign.is_alphanumeric() || sign == '_')).map_or(0, |end| end + 1);
    Some(before.get(start..).unwrap_or_default())
}

/// The modules that stand in a file.
pub(super) fn modules_in(program: &Program<'_>, file: FileId) -> BTreeSet<ModuleId> {
    program.index.modules_in_files().filter(|(_, own)| *own == file).map(|(module, _)| module).collect()
}
