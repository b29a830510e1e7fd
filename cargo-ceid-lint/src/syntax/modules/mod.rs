//! The module tree, followed as rustc follows it. Never stops at a module that is missing, broken, or its own ancestor.

mod include;

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use memchr::memmem;
use proc_macro2::{TokenStream, TokenTree};
use syn::parse::{ParseStream, Parser as _};

use super::RootModule;
use super::bare_closures::with_dyn;
use super::depth::{Excess, MAX_LINKS, MAX_NESTING, check_depth};
use super::edition::of_2015;
use super::lex::{Lexer, Token, TokenKind};
use super::lower::Lowerer;
use super::lower::attrs::Attrs;
use super::lower::silent;
use super::macros::{Exports, Imported, Neighbours, OwnMacros};
use super::tree::Item;
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
    /// What it knows of the crates that it depends on.
    pub(super) neighbours: &'a Neighbours,
    /// What the files import from crates whose macros are known.
    pub(super) imported: Imported,
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
    /// The files and directories of modules that are not there under this `cfg`.
    left_out: BTreeSet<PathBuf>,
    /// The files that were read.
    read: BTreeSet<FileId>,
    /// Whether items are kept, or dropped one by one.
    pub(super) keeps_items: bool,
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
        neighbours: &'a Neighbours,
        files: &'a mut FileSet,
        problems: &'a mut Vec<Problem>,
    ) -> Self {
        Self {
            cfg,
            edition,
            neighbours,
            imported: Imported::default(),
            files,
            problems,
            open: Vec::new(),
            loads: 0,
            own_macros: BTreeSet::new(),
            own: OwnMacros::default(),
            removed: BTreeSet::new(),
            left_out: BTreeSet::new(),
            read: BTreeSet::new(),
            keeps_items: true,
        }
    }

    /// The same for a crate of which only its files and problems are asked for.
    pub(super) fn without_items(self) -> Self {
        Self { keeps_items: false, ..self }
    }

    pub(super) fn root(mut self, path: &Path) -> RootModule {
        let loaded = self.load(path, ModuleDir::of_file(path, None), None);
        let (removed, left_out) = (std::mem::take(&mut self.removed), std::mem::take(&mut self.left_out));
        let files = std::mem::take(&mut self.read);
        match loaded {
            Some(LoadedFile { attrs, items }) => {
                let exports = Exports::of(&items, self.files.map());
                RootModule {
                    is_absent: !attrs.is_there(),
                    attributes: attrs.kept,
                    items,
                    exports,
                    removed,
                    left_out,
                    files,
                }
            }
            None => RootModule { left_out, files, ..RootModule::default() },
        }
    }

    /// Keeps where a module lies that is declared, and not followed.
    pub(super) fn leave_out<'p>(&mut self, name: &str, paths: impl Iterator<Item = &'p str>, dir: &ModuleDir) {
        let children = dir.children();
        self.left_out.extend([children.join(format!("{name}.rs")), children.join(name)]);
        self.left_out.extend(paths.map(|path| dir.dir.join(path)));
    }

    /// The same for all `mod name;` among the tokens of a macro that is not understood.
    pub(super) fn leave_out_declared(&mut self, tokens: &TokenStream, dir: &ModuleDir) {
        let mut after_mod = false;
        for token in tokens.clone() {
            match &token {
                TokenTree::Group(group) => self.leave_out_declared(&group.stream(), dir),
                TokenTree::Ident(ident) if after_mod => self.leave_out(&ident.to_string(), std::iter::empty(), dir),
                _ => {}
            }
            after_mod = matches!(&token, TokenTree::Ident(ident) if ident == "mod");
        }
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
                if let Some(directory) = [&flat, &nested].into_iter().find(|path| self.is_directory(path)) {
                    self.is_a_directory(&format!("module `{name}`"), directory, place);
                    return None;
                }
                if attrs.leaves_out_path {
                    let message = format!("no `cfg_attr` that holds chooses the file of module `{name}`");
                    self.leave_unread(place, message, "check it with a feature that does");
                    return None;
                }
                let message = format!("file not found for module `{name}`");
                let lower = name.to_lowercase();
                let similar = [children.join(format!("{lower}.rs")), children.join(&lower).join("mod.rs")];
                let help = match similar.iter().find(|path| lower != name && self.files.exists(path)) {
                    Some(path) => format!("`{}` differs in case", self.files.map().display_name(path)),
                    None => format!("create {} or {}, or remove the declaration", shown[0], shown[1]),
                };
                self.problem(Some(place), message, Some(help));
                None
            }
        }
    }

    /// Whether a directory has the name of a file.
    fn is_directory(&mut self, path: &Path) -> bool {
        !self.files.exists(path) && self.files.open(path) == Err(ReadError::Directory)
    }

    /// Tells that the file of `what` is a directory.
    fn is_a_directory(&mut self, what: &str, path: &Path, place: Span) {
        let message = format!("file not found for {what}: `{}` is a directory", self.files.map().display_name(path));
        let help = "give the directory another name, or remove the declaration".to_owned();
        self.problem(Some(place), message, Some(help));
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
        self.read.insert(file);
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
            let tokens = if self.edition == "2015" { of_2015(tokens) } else { tokens };
            collect_macro_names(code, &mut self.own_macros);
            // Only what cannot be read as it stands is read again, so that nothing else pays for it.
            let again = matches!(self.edition, "2015" | "2018").then(|| tokens.clone());
            let parse = |input: ParseStream<'_>| self.tree(input, declares_macro(code));
            let first = parse.parse2(tokens);
            first.or_else(|error| again.and_then(|tokens| parse.parse2(with_dyn(tokens)).ok()).ok_or(error))
        });
        match parsed {
            Ok(tree) => {
                self.imported.note(&tree.items, self.neighbours);
                Some(Lowerer::new(self, file, text, base, dir).file(&tree))
            }
            Err(_) if conflict(code).is_some() => {
                let at = to_u32(base + conflict(code).unwrap_or_default());
                let help = "the file is skipped; resolve the merge, and remove the markers".to_owned();
                self.problem(
                    Some(Span::new(file, at, at + 7)),
                    "a merge conflict is not resolved".to_owned(),
                    Some(help),
                );
                None
            }
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

    /// The tree of a file. Where no items are kept, those of which nothing would be left are dropped one by one: the tree of a large
    /// file takes more memory than all else. Which macros a file declares is not known before it is lowered.
    fn tree(&self, input: ParseStream<'_>, declares_macro: bool) -> syn::Result<syn::File> {
        let attrs = input.call(syn::Attribute::parse_inner)?;
        let keeps_all = self.keeps_items || declares_macro || !silent::are_silent(self, &attrs);
        let mut items = Vec::new();
        while !input.is_empty() {
            let item: syn::Item = input.parse()?;
            let imports = matches!(item, syn::Item::Use(_) | syn::Item::ExternCrate(_));
            if keeps_all || imports || !silent::is_silent(self, &item) {
                items.push(item);
            }
        }
        Ok(syn::File { shebang: None, frontmatter: None, attrs, items })
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
                help: Some(format!("the file is skipped; {}", error.remedy())),
                is_error: true,
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
        self.problems.push(Problem { file, span, message, help, is_error: true });
    }
}

/// Where git has marked a conflict.
fn conflict(code: &str) -> Option<usize> {
    let mut at = 0;
    code.split_inclusive('\n').find_map(|line| {
        let start = at;
        at += line.len();
        (line.starts_with("<<<<<<< ") || line.starts_with(">>>>>>> ")).then_some(start)
    })
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

/// Whether a text may declare macros by `macro_rules!`. Most do not.
fn declares_macro(text: &str) -> bool {
    memmem::find(text.as_bytes(), b"macro_rules").is_some()
}

/// Adds the names of all macros that the text declares by `macro_rules!`.
fn collect_macro_names(text: &str, names: &mut BTreeSet<String>) {
    if !declares_macro(text) {
        return;
    }
    let mut before = ["", ""];
    for Token { kind, start, end } in Lexer::new(text) {
        let word = match kind {
            TokenKind::Space | TokenKind::LineComment | TokenKind::BlockComment => continue,
            TokenKind::Word | TokenKind::Sign => &text[start..end],
            TokenKind::Literal | TokenKind::Open | TokenKind::Close => "",
        };
        if before == ["macro_rules", "!"] && kind == TokenKind::Word {
            // The name of `r#name` comes after a sign.
            let raw = text[end..].strip_prefix('#').filter(|_| word == "r");
            let raw = raw.and_then(|rest| rest.get(..Lexer::new(rest).next()?.end));
            names.insert(raw.unwrap_or(word).to_owned());
        }
        before = [before[1], word];
    }
}

fn first_lower(message: &str) -> String {
    let mut chars = message.chars();
    chars.next().map(|first| first.to_lowercase().chain(chars).collect()).unwrap_or_default()
}

fn to_u32(value: usize) -> u32 {
    u32::try_from(value).unwrap_or(u32::MAX)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn macros_are_known_by_their_declarations() {
        let text = "macro_rules! a { () => { macro_rules ! /* b */ r#try {} macro_rules! $c {} } }
            // macro_rules! d
            const E: &str = \"macro_rules! e\"; macro_rules!(f) macro_rules g macro_rules! r { }";
        let mut names = BTreeSet::new();
        collect_macro_names(text, &mut names);
        assert_eq!(names.into_iter().collect::<Vec<_>>(), ["a", "r", "try"]);
    }
}
