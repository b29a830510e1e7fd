//! The module tree, followed as rustc follows it. Never stops at a module that is missing, broken, or its own ancestor.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use proc_macro2::{TokenStream, TokenTree};

use super::depth::{Excess, MAX_LINKS, MAX_NESTING, check_depth};
use super::lower::Lowerer;
use super::lower::attrs::Attrs;
use super::macros::OwnMacros;
use super::tree::Item;
use super::{RootModule, cfg_eval::Presence};
use crate::diagnostic::Problem;
use crate::project::CfgValues;
use crate::source::{FileId, FileSet, ReadError, Span};

/// How many files a crate may load: files that include each other twice would double with each step.
const MAX_LOADS: usize = 20_000;

/// How deep files may load files.
const MAX_FILE_DEPTH: usize = 200;

/// Reads the files of one crate.
pub(super) struct Loader<'a> {
    pub(super) cfg: &'a CfgValues,
    pub(super) edition: &'a str,
    files: &'a mut FileSet,
    problems: &'a mut Vec<Problem>,
    /// The files that are being read, outermost first.
    open: Vec<FileId>,
    loads: usize,
    /// Names of the crate's own macros seen so far: they hide the known ones.
    pub(super) own_macros: BTreeSet<String>,
    /// The rules of those that were lowered so far.
    pub(super) own: OwnMacros,
    /// The names of items and methods that are not there under this `cfg`.
    pub(super) removed: BTreeSet<String>,
}

/// Where the modules of a module are looked for.
#[derive(Clone, Debug)]
pub(super) struct ModuleDir {
    /// The directory `#[path]` is relative to.
    dir: PathBuf,
    /// The name of a file that is not `mod.rs`, whose modules lie in a directory of that name.
    relative: Option<String>,
    /// Whether modules are declared in a block, where rustc wants a `#[path]`.
    in_block: bool,
}

impl ModuleDir {
    fn of_file(path: &Path, relative: Option<String>) -> Self {
        Self { dir: path.parent().map(Path::to_owned).unwrap_or_default(), relative, in_block: false }
    }

    /// Where the modules of the inline module `name` are looked for.
    pub(super) fn inline(&self, name: &str, path: Option<&str>) -> Self {
        let dir = match path {
            Some(path) => self.dir.join(path),
            None => self.children().join(name),
        };
        Self { dir, relative: None, in_block: self.in_block }
    }

    /// Where the modules of a block are looked for.
    pub(super) fn block(&self) -> Self {
        Self { in_block: true, ..self.clone() }
    }

    fn children(&self) -> PathBuf {
        match &self.relative {
            Some(name) => self.dir.join(name),
            None => self.dir.clone(),
        }
    }
}

/// A file's items with what its inner attributes say.
pub(super) struct LoadedFile {
    pub(super) attrs: Attrs,
    pub(super) items: Vec<Item>,
}

impl<'a> Loader<'a> {
    pub(super) fn new(
        cfg: &'a CfgValues,
        edition: &'a str,
        files: &'a mut FileSet,
        problems: &'a mut Vec<Problem>,
    ) -> Self {
        Self {
            cfg,
            edition,
            files,
            problems,
            open: Vec::new(),
            loads: 0,
            own_macros: BTreeSet::new(),
            own: OwnMacros::default(),
            removed: BTreeSet::new(),
        }
    }

    pub(super) fn root(mut self, path: &Path) -> RootModule {
        let loaded = self.load(path, ModuleDir::of_file(path, None), None);
        let removed = std::mem::take(&mut self.removed);
        loaded.map_or_else(RootModule::default, |file| match file.attrs.presence {
            Presence::Absent => RootModule::default(),
            Presence::Present | Presence::Maybe(_) => {
                RootModule { attributes: file.attrs.kept, items: file.items, removed }
            }
        })
    }

    /// The file of `mod name;`, declared at `place`. `None` if it could not be read: the problem is recorded.
    pub(super) fn module(&mut self, name: &str, place: Span, attrs: &Attrs, dir: &ModuleDir) -> Option<LoadedFile> {
        if let Some(path) = attrs.module_path(|path| self.files.exists(&dir.dir.join(path))) {
            let path = dir.dir.join(path);
            let owner = ModuleDir::of_file(&path, None);
            return self.load(&path, owner, Some((place, name)));
        }
        if dir.in_block {
            let message = format!("module `{name}` is declared in a block without a `#[path]`");
            let help = "move the declaration out of the block, or give it a `#[path = \"…\"]`".to_owned();
            self.problem(Some(place), message, Some(help));
            return None;
        }
        let children = dir.children();
        let flat = children.join(format!("{name}.rs"));
        let nested = children.join(name).join("mod.rs");
        let shown = [&flat, &nested].map(|path| format!("`{}`", self.files.map().display_name(path)));
        match (self.files.exists(&flat), self.files.exists(&nested)) {
            (true, true) => {
                let message = format!("module `{name}` has two files: {} and {}", shown[0], shown[1]);
                self.problem(Some(place), message, Some("remove one of the two files".to_owned()));
                None
            }
            (true, false) => {
                let owner = ModuleDir::of_file(&flat, Some(name.to_owned()));
                self.load(&flat, owner, Some((place, name)))
            }
            (false, true) => {
                let owner = ModuleDir::of_file(&nested, None);
                self.load(&nested, owner, Some((place, name)))
            }
            (false, false) => {
                let message = format!("file not found for module `{name}`");
                let help = format!("create {} or {}, or remove the declaration", shown[0], shown[1]);
                self.problem(Some(place), message, Some(help));
                None
            }
        }
    }

    /// The items of `include!("path")` in the file of `place`; `None` if there is no such file.
    pub(super) fn include(&mut self, path: &str, place: Span) -> Option<Vec<Item>> {
        let including = self.files.map().file(place.file).path.clone();
        let path = including.parent().map(|dir| dir.join(path))?;
        if !self.files.exists(&path) {
            return None;
        }
        let owner = ModuleDir::of_file(&path, None);
        let loaded = self.load(&path, owner, Some((place, "")));
        Some(loaded.map(|file| file.items).unwrap_or_default())
    }

    fn load(&mut self, path: &Path, dir: ModuleDir, declared: Option<(Span, &str)>) -> Option<LoadedFile> {
        let file = match self.files.open(path) {
            Ok(file) => file,
            Err(error) => {
                self.unreadable(path, declared, &error);
                return None;
            }
        };
        self.loads += 1;
        if let Some((place, _)) = declared
            && (self.open.contains(&file) || self.open.len() >= MAX_FILE_DEPTH || self.loads > MAX_LOADS)
        {
            self.endless(file, place);
            return None;
        }
        self.open.push(file);
        let loaded = self.parse(file, dir);
        self.open.pop();
        loaded
    }

    fn parse(&mut self, file: FileId, dir: ModuleDir) -> Option<LoadedFile> {
        let text = std::sync::Arc::clone(&self.files.map().file(file).text);
        let base = code_start(&text);
        let code = &text[base..];
        let help = "the file is skipped; check it with `cargo check`".to_owned();
        if let Err(error) = check_depth(code) {
            let at = to_u32(base + error.offset);
            let message = match error.what {
                Excess::Brackets(levels) => format!("nested too deeply ({levels} levels, limit {MAX_NESTING})"),
                Excess::Links => format!("expression too long (more than {MAX_LINKS} links in a row)"),
            };
            let help = "the file is skipped; split the expression".to_owned();
            self.problem(Some(Span::new(file, at, at + 1)), message, Some(help));
            return None;
        }
        let unreadable =
            |error: proc_macro2::LexError| syn::Error::new(error.span(), "unbalanced bracket or invalid token");
        let parsed = code.parse::<TokenStream>().map_err(unreadable).and_then(|tokens| {
            collect_macro_names(&tokens, &mut self.own_macros);
            syn::parse2::<syn::File>(tokens)
        });
        match parsed {
            Ok(tree) => Some(Lowerer::new(self, file, text, base, dir).file(&tree)),
            Err(error) => {
                // Errors at the end of the input have no place of their own.
                let range = error.span().byte_range();
                let range = if range.end == 0 { code.trim_end().len()..code.trim_end().len() } else { range };
                let span = Span::new(file, to_u32(base + range.start), to_u32(base + range.end));
                self.problem(Some(span), first_lower(&error.to_string()), Some(help));
                None
            }
        }
    }

    fn unreadable(&mut self, path: &Path, declared: Option<(Span, &str)>, error: &ReadError) {
        let shown = self.files.map().display_name(path);
        match (declared, error) {
            (Some((place, name)), ReadError::NotFound) => {
                let message = format!("file not found for module `{name}`: `{shown}`");
                let help = format!("create `{shown}`, or remove the declaration");
                self.problem(Some(place), message, Some(help));
            }
            _ => self.problems.push(Problem {
                file: shown,
                span: None,
                message: error.to_string(),
                help: Some("the file is skipped".to_owned()),
            }),
        }
    }

    fn endless(&mut self, file: FileId, place: Span) {
        let shown = |id: FileId| format!("`{}`", self.files.map().file(id).name);
        if let Some(first) = self.open.iter().position(|open| *open == file) {
            let chain: Vec<String> = self.open[first..].iter().chain([&file]).map(|id| shown(*id)).collect();
            let message = format!("circular modules: {}", chain.join(" -> "));
            self.problem(Some(place), message, Some("the inner declaration is skipped".to_owned()));
        } else {
            let message = format!("too many modules load each other: {} is not read again", shown(file));
            let help = format!("a crate may load {MAX_LOADS} files, {MAX_FILE_DEPTH} deep");
            self.problem(Some(place), message, Some(help));
        }
    }

    fn problem(&mut self, span: Option<Span>, message: String, help: Option<String>) {
        let file = span.map(|span| self.files.map().file(span.file).name.clone()).unwrap_or_default();
        self.problems.push(Problem { file, span, message, help });
    }
}

/// Where the code begins: behind the byte order mark and the `#!` line, as rustc strips them.
pub(super) fn code_start(text: &str) -> usize {
    let start = if text.starts_with('\u{feff}') { '\u{feff}'.len_utf8() } else { 0 };
    let code = &text[start..];
    let Some(rest) = code.strip_prefix("#!") else { return start };
    // `#![` is an attribute, comments and spaces between the two included.
    if skip_trivia(rest).starts_with('[') {
        return start;
    }
    start + code.find('\n').unwrap_or(code.len())
}

fn skip_trivia(mut text: &str) -> &str {
    loop {
        text = text.trim_start();
        if let Some(comment) = text.strip_prefix("//") {
            text = comment.find('\n').map_or("", |end| &comment[end..]);
        } else if let Some(comment) = text.strip_prefix("/*") {
            text = comment.find("*/").map_or("", |end| &comment[end + 2..]);
        } else {
            return text;
        }
    }
}

/// Adds the names of all `macro_rules!` among the tokens.
fn collect_macro_names(tokens: &TokenStream, names: &mut BTreeSet<String>) {
    let mut before = [String::new(), String::new()];
    for token in tokens.clone() {
        let word = match token {
            TokenTree::Group(group) => {
                collect_macro_names(&group.stream(), names);
                String::new()
            }
            TokenTree::Ident(ident) => ident.to_string(),
            TokenTree::Punct(punct) if punct.as_char() == '!' => "!".to_owned(),
            TokenTree::Punct(_) | TokenTree::Literal(_) => String::new(),
        };
        if before[0] == "macro_rules" && before[1] == "!" && !word.is_empty() {
            names.insert(word.trim_start_matches("r#").to_owned());
        }
        before.rotate_left(1);
        before[1] = word;
    }
}

fn first_lower(message: &str) -> String {
    let mut chars = message.chars();
    chars.next().map(|first| first.to_lowercase().chain(chars).collect()).unwrap_or_default()
}

fn to_u32(value: usize) -> u32 {
    u32::try_from(value).unwrap_or(u32::MAX)
}
