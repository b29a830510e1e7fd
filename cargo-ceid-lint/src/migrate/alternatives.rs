//! Laws and types that are there under a condition, in whose place other builds may have others: an `impl` for guards, which would
//! be there in this build only, does not do for a loop that is in all of them.

use std::collections::{BTreeMap, BTreeSet};

use super::body::LoopBody;
use super::loops::Loops;
use super::text::{conditions_above, inner_attributes, without_comments, words};
use crate::index::{FunctionId, ModuleId, Ty};
use crate::source::FileId;
use crate::syntax::{Lexer, TokenKind};

/// Whether builds that have the loop may have another law or another type there.
pub(super) fn has_alternatives(loops: &Loops<'_>, of: &LoopBody<'_>, filter: &Ty, law: FunctionId) -> bool {
    let index = of.program.index;
    let def = index.function(law);
    let file = def.function.keyword.file;
    let Some(body) = &def.function.body else { return false };
    let inside = |start: u32| start as usize + 1;
    let of_law = conditions(loops, def.module, file, inside(body.expr(body.root).span.start));
    let is_apart = || {
        let of_loop = conditions(loops, of.def().module, of.file(), inside(of.span(of.block).start));
        of_law.iter().any(|condition| !of_loop.contains(condition))
    };
    if !of_law.is_empty() && is_apart() {
        return true;
    }
    let Ty::Adt(id, _) = filter else { return false };
    let def = index.type_def(*id);
    let modules = std::iter::successors(Some(def.module), |at| index.module(*at).parent);
    let mut names = modules.map(|at| &index.module(at).name).chain([&def.name]);
    names.any(|name| loops.chosen_names().contains(name))
}

/// The conditions under which what stands in a module, at a byte of its file, is compiled.
fn conditions(loops: &Loops<'_>, module: ModuleId, file: FileId, at: usize) -> BTreeSet<String> {
    let sources = loops.program.sources;
    let index = loops.program.index;
    let text = &sources.file(file).text;
    let mut found: BTreeSet<String> = BTreeSet::new();
    for around in loops.outline(file).around(at) {
        found.extend(conditions_above(text, around.head.start).into_iter().map(str::to_owned));
    }
    let of_file = inner_attributes(text).into_iter().map(|range| &text[range]);
    found.extend(of_file.filter(|own| own.starts_with("#![cfg(")).map(|own| own.replacen("#!", "#", 1)));
    // The `mod` of the file stands in that of a module around it.
    let mut modules = std::iter::successors(Some(module), |at| index.module(*at).parent);
    let outer = modules.find_map(|at| {
        let parent = index.module(at).parent?;
        let other = index.module(parent).file.filter(|other| *other != file)?;
        Some((parent, other, &index.module(at).name))
    });
    if let Some((parent, other, name)) = outer {
        let text = &sources.file(other).text;
        let is_declared = |at: &usize| {
            let before = text[..*at].trim_end();
            before.ends_with("mod") && text[*at + name.len()..].trim_start().starts_with(';')
        };
        if let Some(at) = words(text, name).find(is_declared) {
            let start = text[..at].trim_end_matches(|sign: char| !matches!(sign, ';' | '{' | '}' | ']')).len();
            found.extend(conditions_above(text, start).into_iter().map(str::to_owned));
            found.extend(conditions(loops, parent, other, at));
        }
    }
    found
}

/// The names in what a text has several times under different conditions, so that one build has this and another one that: types by another
/// name, imports, fields, variables, and functions with what they give back.
pub(super) fn chosen_names(text: &str) -> BTreeSet<String> {
    let code = without_comments(text);
    let mut heads: BTreeMap<String, BTreeMap<&str, &str>> = BTreeMap::new();
    for (at, _) in code.match_indices("#[cfg(") {
        let mut rest = &code[at..];
        let condition = attribute(rest);
        while rest.starts_with("#[") {
            rest = rest[attribute(rest).len()..].trim_start();
        }
        if condition == "#[cfg(test)]" || condition.is_empty() {
            continue;
        }
        for (name, head) in declared(rest) {
            heads.entry(name).or_default().insert(condition, head);
        }
    }
    let chosen = heads.into_values().filter(|heads| heads.len() > 1).flat_map(BTreeMap::into_values);
    let is_sign = |sign: char| !(sign.is_alphanumeric() || sign == '_');
    chosen.flat_map(|head| head.split(is_sign)).filter(|word| !word.is_empty()).map(str::to_owned).collect()
}

/// The attribute that a text begins with.
fn attribute(text: &str) -> &str {
    let mut depth = 0;
    for token in Lexer::new(text) {
        match token.kind {
            TokenKind::Open => depth += 1,
            TokenKind::Close if depth == 1 => return &text[..token.end],
            TokenKind::Close => depth -= 1,
            _ => {}
        }
    }
    ""
}

/// What the declaration that a text begins with gives names to, with its text.
fn declared(text: &str) -> Vec<(String, &str)> {
    let until = |signs: &[char]| &text[..text.find(signs).unwrap_or(text.len())];
    let is_sign = |sign: char| !(sign.is_alphanumeric() || sign == '_');
    let is_qualifier =
        |word: &str| matches!(word, "pub" | "crate" | "super" | "in" | "const" | "async" | "unsafe" | "extern" | "mut");
    let mut of_text = until(&[';', '{', '=']).split(is_sign).filter(|word| !word.is_empty() && !is_qualifier(word));
    let Some(first) = of_text.next() else { return Vec::new() };
    match first {
        "use" => {
            let whole = until(&[';']);
            let is_path = |word: &str, at: usize| whole[at + word.len()..].trim_start().starts_with("::");
            let mut found: Vec<(String, &str)> = Vec::new();
            for word in whole.split(is_sign).filter(|word| !word.is_empty() && !matches!(*word, "use" | "as" | "pub")) {
                let at = word.as_ptr() as usize - whole.as_ptr() as usize;
                if !is_path(word, at) {
                    found.push((format!("use {word}"), whole));
                }
            }
            found.extend(whole.contains('*').then(|| ("use *".to_owned(), whole)));
            found
        }
        "type" | "let" | "static" => {
            of_text.next().map(|name| (format!("{first} {name}"), until(&[';']))).into_iter().collect()
        }
        "fn" => {
            let given = until(&[';', '{']).split_once("->").map(|(_, given)| given);
            of_text.next().zip(given).map(|(name, given)| (format!("fn {name}"), given)).into_iter().collect()
        }
        _ => {
            // A field, of a type or of a value.
            let whole = until(&[',', ';', '{', '}']);
            let is_field = whole
                .split_once(':')
                .is_some_and(|(name, ty)| name.trim_end().ends_with(first) && !ty.starts_with(':'));
            is_field.then(|| (format!("field {first}"), whole)).into_iter().collect()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[track_caller]
    fn check(text: &str, expected: &[&str]) {
        let found = chosen_names(text);
        for name in ["Fast", "Slow", "Other"] {
            assert_eq!(found.contains(name), expected.contains(&name), "{name} in {text}");
        }
    }

    #[test]
    fn what_is_there_twice_is_chosen() {
        check("#[cfg(a)] type F = Fast;\n#[cfg(not(a))]\npub(crate) type F = Slow;", &["Fast", "Slow"]);
        check("#[cfg(a)] pub use x::Fast as F;\n#[cfg(b)] pub use {y::{Slow as F}};", &["Fast", "Slow"]);
        check("#[cfg(a)] pub use Fast::*;\n#[cfg(b)] pub use Slow::*;", &["Fast", "Slow"]);
        check("struct R { #[cfg(a)] pub f: Fast, #[cfg(b)] pub f: Slow<f32>, other: Other }", &["Fast", "Slow"]);
        check("#[cfg(a)] let mut f = Fast::new(); #[cfg(b)] let mut f = Slow { x: 1 };", &["Fast", "Slow"]);
        check("#[cfg(a)] fn f() -> Fast { 0 } #[cfg(b)] #[inline] const fn f() -> Slow { 1 }", &["Fast", "Slow"]);
    }

    #[test]
    fn what_is_there_once_or_not_is_not() {
        check("#[cfg(a)] type F = Fast;\n#[cfg(b)] type S = Slow;", &[]);
        check("#[cfg(a)] use x::Fast;\n#[cfg(b)] use x::Slow;", &[]);
        check("struct R { #[cfg(a)] fast: Fast, #[cfg(b)] slow: Slow }", &[]);
        check("#[cfg(test)] use x::Fast;\n#[cfg(test)] use y::Fast;", &[]);
        check("struct R { #[cfg(a)] f: Fast } fn f() -> R { R { #[cfg(a)] f: Fast::new() } }", &[]);
        check("#[cfg(a)] fn f(fast: Fast) -> u8 { 0 } #[cfg(b)] fn f(slow: &Slow) {}", &[]);
        check("#[cfg(a)] impl Fast {} #[cfg(b)] impl Fast {}", &[]);
    }
}
