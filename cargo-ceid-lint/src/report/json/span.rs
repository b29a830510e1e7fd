//! Places as rustc prints them: bytes from 0, lines and columns from 1, columns in characters, ends exclusive.

use serde::Serialize;

use crate::report::files::bytes;
use crate::source::{SourceMap, Span};

#[derive(Serialize)]
pub(super) struct JsonSpan {
    file_name: String,
    byte_start: usize,
    byte_end: usize,
    line_start: u32,
    line_end: u32,
    column_start: u32,
    column_end: u32,
    is_primary: bool,
    text: Vec<Line>,
    label: Option<String>,
    suggested_replacement: Option<String>,
    suggestion_applicability: Option<&'static str>,
    expansion: Option<()>,
}

#[derive(Serialize)]
struct Line {
    text: String,
    highlight_start: u32,
    highlight_end: u32,
}

impl JsonSpan {
    pub(super) fn suggesting(self, replacement: &str, applicability: &'static str) -> Self {
        Self {
            suggested_replacement: Some(replacement.to_owned()),
            suggestion_applicability: Some(applicability),
            ..self
        }
    }
}

pub(super) fn of_span(sources: &SourceMap, span: Span, is_primary: bool, label: Option<&str>) -> JsonSpan {
    let file = sources.file(span.file);
    let range = bytes(file, span);
    let position = |offset: usize| file.lines.line_column(&file.text, u32::try_from(offset).unwrap_or(u32::MAX));
    let (start, end) = (position(range.start), position(range.end));
    let text = (start.line..=end.line).map(|number| {
        let text = &file.text[file.lines.line_range(&file.text, number)];
        let width = u32::try_from(text.chars().count()).unwrap_or(u32::MAX);
        Line {
            text: text.to_owned(),
            highlight_start: if number == start.line { start.column } else { 1 },
            highlight_end: if number == end.line { end.column } else { width + 1 },
        }
    });
    JsonSpan {
        file_name: file.name.clone(),
        byte_start: range.start,
        byte_end: range.end,
        line_start: start.line,
        line_end: end.line,
        column_start: start.column,
        column_end: end.column,
        is_primary,
        text: text.collect(),
        label: label.filter(|label| !label.is_empty()).map(str::to_owned),
        suggested_replacement: None,
        suggestion_applicability: None,
        expansion: None,
    }
}

/// The first line of a file whose text is not known.
pub(super) fn at_start_of(file: &str) -> JsonSpan {
    JsonSpan {
        file_name: file.to_owned(),
        byte_start: 0,
        byte_end: 0,
        line_start: 1,
        line_end: 1,
        column_start: 1,
        column_end: 1,
        is_primary: true,
        text: Vec::new(),
        label: None,
        suggested_replacement: None,
        suggestion_applicability: None,
        expansion: None,
    }
}
