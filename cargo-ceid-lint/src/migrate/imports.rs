//! Imports of a filter's trait that were there for calls of its law, in files whose loops have a guard.

use std::collections::BTreeSet;
use std::ops::Range;

use super::text::{has_word, removal, words};
use crate::count::{Cycle, Verdict};
use crate::flow::Program;
use crate::index::TraitDef;
use crate::source::{FileId, Span};
use crate::syntax::tree::{ExprKind, MacroKind};

/// The edits that remove each of these imports.
#[must_use]
pub fn idle_imports(program: &Program<'_>, cycles: &[Cycle]) -> Vec<Vec<(Span, String)>> {
    let has_guard = |cycle: &&Cycle| cycle.filters.iter().any(|pair| pair.verdict == Verdict::Guarded);
    let files: BTreeSet<FileId> = cycles.iter().filter(has_guard).map(|cycle| cycle.head.file).collect();
    let files: BTreeSet<FileId> = files.into_iter().filter(|file| has_ceid(program, *file)).collect();
    let traits = || program.index.traits.iter().filter(|def| !def.methods.is_empty());
    let pairs = files.iter().flat_map(|file| traits().map(move |def| (*file, def)));
    pairs.filter_map(|(file, def)| import(program, file, def)).collect()
}

/// Whether a guard of free variables stands in the file: what a migration writes.
fn has_ceid(program: &Program<'_>, file: FileId) -> bool {
    let bodies = program.index.functions.iter().filter_map(|def| def.function.body.as_ref());
    let mut exprs = bodies.filter(|body| body.expr(body.root).span.file == file).flat_map(|body| &body.exprs);
    exprs.any(|expr| matches!(&expr.kind, ExprKind::Macro(call) if matches!(call.kind, MacroKind::Ceid { .. })))
}

/// The import of a trait in a file, if it is the only mention of it there and no method of it is called.
fn import(program: &Program<'_>, file: FileId, def: &TraitDef) -> Option<Vec<(Span, String)>> {
    let text = &*program.sources.file(file).text;
    // ceid-core's trait is told from a trait of that name by what is imported, which is why a trait of another file is looked for.
    if def.span.file == file || program.index.crate_of(def.module).package_name == "ceid_core" {
        return None;
    }
    let mut mentions = words(text, &def.name);
    let (at, None) = (mentions.next()?, mentions.next()) else { return None };
    let calls = |method: &String| {
        [format!(".{method}("), format!(".{method}::"), format!("::{method}")].iter().any(|call| text.contains(call))
    };
    if def.methods.keys().any(calls) || is_handed_on(program, file, text) {
        return None;
    }
    let to_u32 = |at: usize| u32::try_from(at).unwrap_or(u32::MAX);
    let (range, new) = without(text, at, &def.name)?;
    Some(vec![(Span::new(file, to_u32(range.start), to_u32(range.end)), new)])
}

/// Whether another file may get the import from this one.
fn is_handed_on(program: &Program<'_>, file: FileId, text: &str) -> bool {
    let others = program.sources.files().filter(|(id, _)| *id != file);
    let mut globs = others.filter(|(_, other)| other.text.contains("super::*"));
    // Modules of this file that look up from here call its names as well; their calls were looked for above.
    has_word(text, "mod") && globs.next().is_some()
}

/// What to replace, and by what, so that the `use` around the name at `at` is without it.
fn without(text: &str, at: usize, name: &str) -> Option<(Range<usize>, String)> {
    let start = text[..at].rfind([';', '}']).map_or(0, |end| end + 1);
    let head = &text[start..at];
    let word = words(head, "use").last()?;
    let own = start + word;
    let is_alone_before = text[own..at].chars().all(|c| c.is_alphanumeric() || "_: {},\n\r\t".contains(c));
    if !is_alone_before || head[..word].trim_end().ends_with("pub") || head[..word].trim_end().ends_with(')') {
        return None;
    }
    let end = at + name.len();
    let stop = end + text[end..].find(';')?;
    let Some(open) = text[own..at].rfind('{').map(|open| own + open) else {
        return text[end..stop].trim().is_empty().then(|| (removal(text, own..stop + 1), String::new()));
    };
    // One list without lists in it.
    let close = end + text[end..].find('}')?;
    let list = &text[open + 1..close];
    if list.contains('{') || text[own..open].contains('{') || close > stop || text[close + 1..stop].contains('}') {
        return None;
    }
    let names: Vec<&str> = list.split(',').map(str::trim).filter(|entry| !entry.is_empty()).collect();
    let left: Vec<&str> = names.iter().copied().filter(|entry| *entry != name).collect();
    if left.len() + 1 != names.len() {
        return None;
    }
    match left.as_slice() {
        [] => Some((removal(text, own..stop + 1), String::new())),
        [one] if *one != "self" => Some((open..close + 1, (*one).to_owned())),
        _ if !list.contains('\n') => Some((open + 1..close, left.join(", "))),
        _ => {
            let comma = end + text[end..].find(',').filter(|comma| end + comma < close)?;
            Some((removal(text, at..comma + 1), String::new()))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[track_caller]
    fn check(text: &str, expected: Option<&str>) {
        let at = words(text, "Step").next().expect("it is there");
        let changed = without(text, at, "Step").map(|(range, new)| {
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
    }

    #[test]
    fn what_is_more_than_an_import_stays() {
        check("pub use crate::b::Step;\n", None);
        check("pub(crate) use crate::b::Step;\n", None);
        check("use crate::{b::{Step, Kf}, c};\n", None);
        check("use crate::b::Step as Other;\n", None);
        check("fn f<T: Step>() {}\n", None);
    }
}
