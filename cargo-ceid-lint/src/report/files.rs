//! The read files as codespan-reporting wants to see them.

use std::borrow::Cow;
use std::ops::Range;

use codespan_reporting::files::{Error, Files};

use crate::source::{FileId, SourceFile, SourceMap, Span, file_url};

/// A view of the source map.
#[derive(Clone, Copy, Debug)]
pub(super) struct View<'a> {
    pub(super) sources: &'a SourceMap,
    /// Whether names are links to their files, in the escape sequences of terminals (OSC 8).
    pub(super) hyperlinks: bool,
}

impl<'a> View<'a> {
    fn file(self, id: FileId) -> Result<&'a SourceFile, Error> {
        self.sources.get(id).ok_or(Error::FileMissing)
    }
}

impl<'a> Files<'a> for View<'a> {
    type FileId = FileId;
    type Name = Cow<'a, str>;
    type Source = &'a str;

    fn name(&'a self, id: FileId) -> Result<Cow<'a, str>, Error> {
        let file = self.file(id)?;
        if !self.hyperlinks || !file.path.is_absolute() {
            return Ok(Cow::Borrowed(&file.name));
        }
        let (name, url) = (&file.name, file_url(&file.path));
        Ok(Cow::Owned(format!("\x1b]8;;{url}\x1b\\{name}\x1b]8;;\x1b\\")))
    }

    fn source(&'a self, id: FileId) -> Result<&'a str, Error> {
        Ok(&self.file(id)?.text)
    }

    fn line_index(&'a self, id: FileId, byte_index: usize) -> Result<usize, Error> {
        let file = self.file(id)?;
        let offset = u32::try_from(byte_index).unwrap_or(u32::MAX);
        Ok(file.lines.line_column(&file.text, offset).line as usize - 1)
    }

    fn line_range(&'a self, id: FileId, line_index: usize) -> Result<Range<usize>, Error> {
        let file = self.file(id)?;
        let line = u32::try_from(line_index).unwrap_or(u32::MAX).saturating_add(1);
        if line > file.lines.count(&file.text) {
            return Err(Error::LineTooLarge { given: line_index, max: file.lines.count(&file.text) as usize });
        }
        let start = file.lines.line_range(&file.text, line).start;
        let end = if line == file.lines.count(&file.text) {
            file.text.len()
        } else {
            file.lines.line_range(&file.text, line + 1).start
        };
        Ok(start..end)
    }
}

/// The bytes of a place, kept inside the text and between characters.
pub(super) fn bytes(file: &SourceFile, span: Span) -> Range<usize> {
    let inside = |offset: u32| {
        let offset = (offset as usize).min(file.text.len());
        (0..=offset).rev().find(|at| file.text.is_char_boundary(*at)).unwrap_or(0)
    };
    let start = inside(span.start);
    start..inside(span.end).max(start)
}

/// Whether a line of the place is too long to be shown.
pub(super) fn is_on_a_long_line(sources: &SourceMap, span: Span) -> bool {
    const LONGEST: usize = 2_000;
    let file = sources.file(span.file);
    file.lines.line_range(&file.text, sources.line(span)).len() > LONGEST
}
