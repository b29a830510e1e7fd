//! Crates that name `ceid-core` because they did not use it when another one of their package came to depend on it, and use it now.

use super::files::text_of;
use super::fix_of;
use crate::fix::{Edit, Fix};
use crate::migrate::needless_name;
use crate::pipeline::Report;
use crate::source::Span;

/// The fixes that take such names away; those that were there before the first round stay.
pub(super) fn needless_names(report: &Report, first: &Report) -> Vec<Fix> {
    let of_file = |(id, file): (_, &crate::source::SourceFile)| {
        let range = needless_name(&file.text)?;
        let is_new =
            !text_of(&first.sources, &file.path).is_some_and(|before| before.contains(&file.text[range.clone()]));
        let edit = Edit { path: file.path.clone(), start: range.start, end: range.end, text: String::new() };
        let at = u32::try_from(range.start).ok()?;
        let title = "a name of `ceid-core` removed from a crate that uses it".to_owned();
        is_new.then(|| fix_of(report, Span::new(id, at, at), title, vec![edit]))
    };
    report.sources.files().filter_map(of_file).collect()
}
