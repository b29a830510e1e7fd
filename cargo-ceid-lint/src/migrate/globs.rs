//! Imports of all that a module has that were there for calls of a law, in files whose loops have a guard.

use std::collections::BTreeSet;

use super::import::Import;
use super::imports::{Doubtful, IdleImports, Scope, Sought, modules_in, segment_before, to_u32};
use super::macros::Macros;
use super::takers::Takers;
use super::text::{code_only, without_comments, words};
use crate::flow::Program;
use crate::index::{FunctionId, Globbed, Owner, TraitId};
use crate::source::{FileId, Span};
use crate::syntax::Outline;

/// Finds those that brought a trait into scope that nothing needs: those that go, or those that perhaps nothing needs.
pub(super) fn idle(
    program: &Program<'_>,
    file: FileId,
    text: &str,
    outline: &Outline,
    functions: &[FunctionId],
    macros: &Macros<'_>,
    found: &mut IdleImports,
) {
    let index = program.index;
    let declared = index.functions.iter().filter(|def| def.function.keyword.file == file);
    let crates: BTreeSet<_> = declared.map(|def| index.module(def.module).krate).collect();
    let (code, written) = (without_comments(text), code_only(text));
    for (at, _) in code.match_indices("::*") {
        let Some(glob) = Glob::of(&code, at) else { continue };
        let brought = index.globbed(&crates, &glob.path);
        let traits = Traits::of(program, &brought);
        if traits.0.iter().all(|(_, members)| members.is_empty()) || glob.path.iter().any(|name| name == "ceid_core") {
            continue;
        }
        let stmt = glob.import.stmt.clone();
        let around = outline.around(stmt.start).next();
        let range = around.map_or(0..text.len(), |around| around.brackets.clone());
        let scopes = traits.0.iter().map(|(id, members)| {
            let def = index.trait_def(*id);
            let (name, module, trait_id) = (def.name.as_str(), def.module, Some(*id));
            Scope {
                program,
                file,
                functions,
                text,
                code: &written,
                outline,
                name,
                module,
                trait_id,
                methods: members,
                macros,
            }
        });
        let scopes: Vec<Scope<'_>> = scopes.collect();
        let is_needed = |names: &str, calls: &str| {
            let parts = [&names[range.start..stmt.start.max(range.start)], &names[stmt.end..range.end]];
            let is_looked_up = |part: &str, name: &str| {
                let is_bare = |at| segment_before(part, at).is_none_or(|before| matches!(before, "super" | "self"));
                words(part, name).any(is_bare)
            };
            brought.names.iter().any(|name| parts.iter().any(|part| is_looked_up(part, name)))
                || scopes.iter().any(|scope| scope.methods.iter().any(|method| scope.is_called(method, calls, &range)))
        };
        let Some(any) = scopes.first() else { continue };
        let sight = |without_tests, sought| any.in_sight(&range, without_tests, sought);
        let names: BTreeSet<&str> = brought.names.iter().map(String::as_str).collect();
        let methods = scopes.iter().flat_map(|scope| scope.methods.iter().map(|method| method.as_str()));
        let wanted = names.iter().copied().chain(methods);
        let unconditional = any.unconditional(&sight(true, Sought::Names));
        // Code that is compiled under a condition only was perhaps not read, and what it imports is not known.
        let is_in_macro = outline.around(stmt.start).any(|around| around.is_macro);
        if is_in_macro || !unconditional[stmt.start..].starts_with("use") {
            continue;
        }
        let takers = || Takers::of(program, macros, modules_in(program, file), &names, &(file, stmt.clone()));
        let is_handed_on = around.is_none() && takers().need(wanted, macros, false);
        if !glob.is_conditional
            && !brought.has_unknown
            && !is_handed_on
            && !is_needed(&sight(false, Sought::Names), &sight(false, Sought::Calls))
            && let Some((gone, left)) = glob.import.without(text)
        {
            found.removals.push(vec![(Span::new(file, to_u32(gone.start), to_u32(gone.end)), left)]);
            continue;
        }
        if !is_needed(&unconditional, &unconditional) {
            let span = Span::new(file, to_u32(stmt.start), to_u32(stmt.end));
            let is_conditional = is_needed(&sight(false, Sought::Names), &sight(false, Sought::Calls));
            found.doubtful.push(Doubtful { span, name: text[glob.import.entry].to_owned(), is_conditional });
        }
    }
}

/// The traits that a glob brings, with what can be called because of them.
struct Traits<'a>(Vec<(TraitId, Vec<&'a String>)>);

impl<'a> Traits<'a> {
    fn of(program: &Program<'a>, brought: &Globbed) -> Self {
        let index = program.index;
        let of = |id| {
            let def = index.trait_def(id);
            // The constant of a type may be that of any trait that it implements.
            let of_trait = |owner| matches!(owner, Owner::Impl(id) if index.impl_def(id).trait_path.is_some());
            let constants = index.values.iter().filter(|value| of_trait(value.owner)).map(|value| &value.name);
            (id, def.methods.keys().chain(constants).collect())
        };
        Self(brought.traits.iter().map(|id| of(*id)).collect())
    }
}

/// A private `use` of all that a module has.
struct Glob<'t> {
    import: Import<'t>,
    /// The path of the module.
    path: Vec<String>,
    /// Whether an attribute stands above it.
    is_conditional: bool,
}

impl<'t> Glob<'t> {
    /// The import whose `::*` stands at a byte of code without comments.
    fn of(code: &'t str, at: usize) -> Option<Self> {
        let is_path = |sign: char| sign.is_alphanumeric() || "_:".contains(sign);
        let start = words(&code[..at], "use").last()?;
        let entry = code[..at].rfind(|sign| !is_path(sign)).map_or(0, |before| before + 1)..at + "::*".len();
        let end = start + code[start..].find(';')? + 1;
        let before = code[..start].trim_end();
        if end < entry.end || !(before.is_empty() || before.ends_with([';', '}', '{', ']'])) {
            return None;
        }
        let head = code[start + "use".len()..entry.start].trim();
        let (list, prefix) = match head.find('{') {
            None if head.is_empty() => (None, ""),
            Some(length) => {
                let open = start + code[start..entry.start].find('{')?;
                let close = code[entry.end..end].find('}')? + entry.end + 1;
                let is_flat = !code[open + 1..close - 1].contains(['{', '}']) && code[close..end].trim() == ";";
                (is_flat.then_some(Some(open..close))?, head[..length].trim())
            }
            None => return None,
        };
        let names = format!("{prefix}{}", &code[entry.start..at]);
        let path = names.split("::").map(|name| name.trim().to_owned()).collect();
        let import = Import { stmt: start..end, visibility: "", alias: None, entry, list };
        Some(Self { import, path, is_conditional: before.ends_with(']') })
    }
}
