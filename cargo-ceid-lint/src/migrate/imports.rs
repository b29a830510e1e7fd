//! Imports of a filter's trait that were there for calls of its law, in files whose loops have a guard.

use std::collections::BTreeSet;
use std::ops::Range;

use super::text::{begins_line, has_word, line_stop, removal, without_comments, words};
use crate::count::{Cycle, Verdict};
use crate::flow::Program;
use crate::index::{FunctionId, Owner, TraitDef};
use crate::source::{FileId, Span};
use crate::syntax::Outline;
use crate::syntax::tree::{ExprId, ExprKind, MacroKind};
use crate::types::Callee;

/// The edits that remove each of these imports.
#[must_use]
pub fn idle_imports(program: &Program<'_>, cycles: &[Cycle]) -> Vec<Vec<(Span, String)>> {
    let has_guard = |cycle: &&Cycle| cycle.filters.iter().any(|pair| pair.verdict == Verdict::Guarded);
    let files: BTreeSet<FileId> = cycles.iter().filter(has_guard).map(|cycle| cycle.head.file).collect();
    let files: BTreeSet<FileId> = files.into_iter().filter(|file| has_ceid(program, *file)).collect();
    let traits = || program.index.traits.iter().filter(|def| !def.methods.is_empty());
    let mut found = Vec::new();
    for file in files {
        let text = &*program.sources.file(file).text;
        let outline = Outline::of(text);
        for def in traits() {
            let scope = Scope { program, file, text, outline: &outline, def };
            found.extend(words(text, &def.name).filter_map(|at| scope.import(at)));
        }
    }
    found
}

/// Whether a guard of free variables stands in the file: what a migration writes.
fn has_ceid(program: &Program<'_>, file: FileId) -> bool {
    let bodies = program.index.functions.iter().filter_map(|def| def.function.body.as_ref());
    let mut exprs = bodies.filter(|body| body.expr(body.root).span.file == file).flat_map(|body| &body.exprs);
    exprs.any(|expr| matches!(&expr.kind, ExprKind::Macro(call) if matches!(call.kind, MacroKind::Ceid { .. })))
}

fn to_u32(at: usize) -> u32 {
    u32::try_from(at).unwrap_or(u32::MAX)
}

/// A file that may import a trait.
struct Scope<'a> {
    program: &'a Program<'a>,
    file: FileId,
    text: &'a str,
    outline: &'a Outline,
    def: &'a TraitDef,
}

impl Scope<'_> {
    /// What removes the import whose name stands at a byte, if nothing in the block or module around it needs it.
    fn import(&self, at: usize) -> Option<Vec<(Span, String)>> {
        let Self { program, file, text, def, .. } = *self;
        let import = Import::of(text, at, &def.name)?;
        // A trait of ceid-core may have the same name.
        if text[import.stmt.clone()].contains("ceid_core")
            || program.index.crate_of(def.module).package_name == "ceid_core"
        {
            return None;
        }
        let around = self.outline.around(import.stmt.start).next();
        let scope = around.map_or(0..text.len(), |around| around.brackets.clone());
        let is_outside = |at: &usize| scope.contains(at) && !import.stmt.contains(at);
        let bound = import.alias.unwrap_or(&def.name);
        if bound != "_" && words(text, bound).any(|at| is_outside(&at))
            || def.methods.keys().any(|method| self.is_called(method, &scope))
            || around.is_none() && is_handed_on(program, file, text)
        {
            return None;
        }
        let (range, new) = import.without(text)?;
        Some(vec![(Span::new(file, to_u32(range.start), to_u32(range.end)), new)])
    }

    /// Whether a method of the trait may be called in a part of the file: each call of that name is known, or is one.
    fn is_called(&self, method: &str, scope: &Range<usize>) -> bool {
        let part = &self.text[scope.clone()];
        let count = |call: String| part.matches(&call).count();
        let written = count(format!(".{method}(")) + count(format!(".{method}::")) + count(format!("::{method}"));
        let index = self.program.index;
        // A method of the type itself needs no import, and one of a trait may stand for that of another one.
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
                    && matches!(&body.expr(*call).kind, ExprKind::MethodCall { method: own, .. } if own == method)
            };
            let others = typed.callees.iter().filter(|(call, callee)| {
                matches!(callee, Callee::Resolved(resolved) if !resolved.targets.is_empty() && resolved.targets.iter().all(is_inherent))
                    && is_here(call)
            });
            others.count()
        };
        written > 0 && written != index.function_ids().map(is_other).sum::<usize>()
    }
}

/// Whether another file may get the import from this one.
fn is_handed_on(program: &Program<'_>, file: FileId, text: &str) -> bool {
    let others = program.sources.files().filter(|(id, _)| *id != file);
    let mut globs = others.filter(|(_, other)| other.text.contains("super::*"));
    // Modules of this file that look up from here call its names as well; their calls were looked for above.
    has_word(text, "mod") && globs.next().is_some()
}

/// A private `use` that names a trait.
struct Import<'t> {
    stmt: Range<usize>,
    /// What it is called, and how it is written in the innermost list: `filter::Step as Other`.
    alias: Option<&'t str>,
    entry: Range<usize>,
    /// The innermost list around it, with its braces.
    list: Option<Range<usize>>,
}

impl<'t> Import<'t> {
    /// The import whose name stands at a byte.
    fn of(text: &'t str, at: usize, name: &str) -> Option<Self> {
        let start = text[..at].rfind([';', '}']).map_or(0, |end| end + 1);
        let head = &text[start..at];
        let word = words(head, "use").last()?;
        let own = start + word;
        let mut before = head[..word].lines().map(str::trim);
        // Attributes and a visibility belong to it; a block begins with a brace.
        let before = before.rfind(|line| !line.starts_with("//") && !line.is_empty());
        if before.is_some_and(|line| !line.ends_with('{')) {
            return None;
        }
        let is_path = |c: char| c.is_alphanumeric() || "_:".contains(c);
        let stop = at + text[at..].find(';')? + 1;
        let code = without_comments(&text[own..stop]);
        if !code.chars().all(|c| is_path(c) || " {},;\n\r\t".contains(c)) {
            return None;
        }
        let end = at + name.len();
        let rest = code[end - own..].trim_start();
        let alias = rest.strip_prefix("as ").map(str::trim_start);
        let alias = alias.map(|alias| &alias[..alias.find(|c| !is_path(c)).unwrap_or(alias.len())]);
        let entry_end = own + code[end - own..].find([',', '}', ';'])? + end - own;
        let first = text[..at].rfind(|c| !is_path(c)).map_or(0, |before| before + 1);
        let mut depth = 0;
        let open = code[..at - own].rfind(|sign| {
            depth += match sign {
                '}' => 1,
                '{' => -1,
                _ => 0,
            };
            depth < 0
        });
        let list = match open {
            Some(open) => Some(own + open..own + code[end - own..].find('}')? + end - own + 1),
            None => None,
        };
        let alias = alias.and_then(|alias| {
            text[end..entry_end].contains(alias).then(|| {
                let at = end + text[end..entry_end].rfind(alias).unwrap_or(0);
                &text[at..at + alias.len()]
            })
        });
        Some(Self { stmt: own..stop, alias, entry: first..entry_end, list })
    }

    /// What to replace, and by what, so that the `use` is without the name.
    fn without(&self, text: &str) -> Option<(Range<usize>, String)> {
        let Some(list) = self.list.clone() else {
            return Some((removal(text, self.stmt.clone()), String::new()));
        };
        let inner = &text[list.start + 1..list.end - 1];
        if without_comments(inner).contains('{') {
            return None;
        }
        let is_nested = text[self.stmt.start..list.start].contains('{');
        let code = without_comments(inner);
        let entries = code.split(',').map(str::trim).filter(|entry| !entry.is_empty());
        let own = text[self.entry.clone()].trim();
        let left: Vec<&str> = entries.filter(|entry| *entry != own).collect();
        let has_comments = code != inner;
        match left.as_slice() {
            [] if is_nested || has_comments => None,
            [] => Some((removal(text, self.stmt.clone()), String::new())),
            [one] if *one != "self" && !has_comments => Some((list, (*one).to_owned())),
            _ if !inner.contains('\n') && !has_comments => Some((list.start + 1..list.end - 1, left.join(", "))),
            _ => {
                let comma = if text[self.entry.end..].starts_with(',') { 1 } else { 0 };
                let end = self.entry.end + comma;
                let stop = line_stop(text, end);
                let rest = text[end..stop].trim();
                // What is said of the name goes with it.
                let is_alone = begins_line(text, self.entry.start) && (rest.is_empty() || rest.starts_with("//"));
                let end = if rest.starts_with("//") { end + text[end..stop].trim_end().len() } else { end };
                is_alone.then(|| (removal(text, self.entry.start..end), String::new()))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[track_caller]
    fn check(text: &str, expected: Option<&str>) {
        let at = words(text, "Step").next().expect("it is there");
        let changed = Import::of(text, at, "Step").and_then(|import| import.without(text)).map(|(range, new)| {
            let mut text = text.to_owned();
            text.replace_range(range, &new);
            text
        });
        assert_eq!(changed.as_deref(), expected);
    }

    #[test]
    fn an_import_goes_alone() {
        check("use a;\nuse crate::b::Step;\nuse c;\n", Some("use a;\nuse c;\n"));
        check("use crate::b::{Pid, Step};\n", Some("use crate::b::Pid;\n"));
        check("use crate::b::{Kf, Pid, Step};\n", Some("use crate::b::{Kf, Pid};\n"));
        check("use crate::b::{\n    Kf,\n    Step,\n    Pid,\n};\n", Some("use crate::b::{\n    Kf,\n    Pid,\n};\n"));
        check("use crate::b::{Step};\nfn f() {}\n", Some("fn f() {}\n"));
        check("use crate::b::Step as Other;\n", Some(""));
        check(
            "mod a {\n    // c\n    use crate::b::{Kf, Step as _};\n}\n",
            Some("mod a {\n    // c\n    use crate::b::Kf;\n}\n"),
        );
        check("use crate::{b::{Step, Kf}, c};\n", Some("use crate::{b::Kf, c};\n"));
        check("use crate::{b::Step, c, d};\n", Some("use crate::{c, d};\n"));
        check(
            "use a::{\n    Kf,   // the filter\n    Step, // its trait\n};\n",
            Some("use a::{\n    Kf,   // the filter\n};\n"),
        );
    }

    #[test]
    fn what_is_more_than_an_import_stays() {
        check("pub use crate::b::Step;\n", None);
        check("pub(crate) use crate::b::Step;\n", None);
        check("#[cfg(x)]\nuse crate::b::Step;\n", None);
        check("use crate::{b::{Step}, c};\n", None);
        check("fn f<T: Step>() {}\n", None);
    }
}
