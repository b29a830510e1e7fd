//! `include!`: which file it names, and what is said of one that is not read.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use proc_macro2::{TokenStream, TokenTree};
use syn::punctuated::Punctuated;

use super::{Loader, ModuleDir};
use crate::diagnostic::Problem;
use crate::source::Span;
use crate::syntax::tree::Item;

impl Loader<'_> {
    /// The items of the file that `include!(tokens)` names; `None` if they are not read, which is told.
    pub(in crate::syntax) fn include(&mut self, tokens: &TokenStream, place: Span) -> Option<Vec<Item>> {
        let Some(path) = self.named_by(tokens, place) else {
            self.not_included(tokens, place);
            return None;
        };
        if self.is_directory(&path) {
            self.is_a_directory("`include!`", &path, place);
            return None;
        }
        if !self.files.exists(&path) {
            if syn::parse2::<syn::LitStr>(tokens.clone()).is_err() {
                // What builds a path may be meant for a file that is made before it is compiled.
                self.not_included(tokens, place);
                return None;
            }
            let shown = self.files.map().display_name(&path);
            let help = format!("create `{shown}`, or remove the `include!`");
            self.problem(Some(place), format!("file not found for `include!`: `{shown}`"), Some(help));
            return None;
        }
        let owner = ModuleDir::of_file(&path, None);
        let loaded = self.load(&path, owner, Some((place, "")));
        Some(loaded.map(|file| file.items).unwrap_or_default())
    }

    /// The file that an `include!` at `place` names by strings and the directory of the manifest; `None` if by more.
    fn named_by(&self, tokens: &TokenStream, place: Span) -> Option<PathBuf> {
        let including = &self.files.map().file(place.file).path;
        let has_manifest = |dir: &&Path| dir.is_absolute() && self.files.exists(&dir.join("Cargo.toml"));
        let manifest_dir = including.ancestors().skip(1).find(has_manifest);
        let named = text_of(&syn::parse2(tokens.clone()).ok()?, manifest_dir)?;
        Some(including.parent()?.join(named))
    }

    /// The words of a file that is included where an expression stands, where its code may use every variable in scope. Where the
    /// file is not known, it may be each variable that the including one has.
    pub(in crate::syntax) fn included_words(&mut self, tokens: &TokenStream, place: Span) -> Vec<String> {
        let named = self.named_by(tokens, place);
        let path = named.filter(|path| self.files.exists(path) && !self.is_directory(path));
        let file = path.and_then(|path| self.files.open(&path).ok()).unwrap_or(place.file);
        let text = &self.files.map().file(file).text;
        let words: BTreeSet<&str> = text.split(|letter: char| letter != '_' && !letter.is_alphanumeric()).collect();
        words.into_iter().map(str::to_owned).collect()
    }

    /// Tells that the code which `include!` stands for at `place` is not read, though nothing is wrong with it.
    pub(in crate::syntax) fn not_included(&mut self, tokens: &TokenStream, place: Span) {
        let file = last_literal(tokens).map(|path| path.trim_start_matches('/').to_owned());
        let file = file.map_or_else(|| "the included file".to_owned(), |file| format!("`{file}`"));
        let (message, help) = if names_out_dir(tokens) {
            let message = format!("{file} is written by a build script, and none is run");
            (message, "a law or a cycle in it has to be checked where it is generated from")
        } else {
            let message = format!("{file} is not read: its code is included in a body, or its path is computed");
            (message, "use `mod` instead")
        };
        self.leave_unread(place, message, help);
    }

    /// Tells what is not read, though nothing is wrong with it.
    pub(in crate::syntax) fn leave_unread(&mut self, place: Span, message: String, help: &str) {
        let file = self.files.map().file(place.file).name.clone();
        let help = Some(help.to_owned());
        self.problems.push(Problem { file, span: Some(place), message, help, is_error: false });
    }
}

/// What an expression of strings, `concat!` and `env!("CARGO_MANIFEST_DIR")` comes to.
fn text_of(expr: &syn::Expr, manifest_dir: Option<&Path>) -> Option<String> {
    match expr {
        syn::Expr::Lit(literal) => match &literal.lit {
            syn::Lit::Str(text) => Some(text.value()),
            syn::Lit::Char(letter) => Some(letter.value().to_string()),
            syn::Lit::Int(number) => Some(number.base10_digits().to_owned()),
            _ => None,
        },
        syn::Expr::Macro(call) if call.mac.path.is_ident("concat") => {
            let parts = call.mac.parse_body_with(Punctuated::<syn::Expr, syn::Token![,]>::parse_terminated).ok()?;
            parts.iter().map(|part| text_of(part, manifest_dir)).collect()
        }
        syn::Expr::Macro(call) if call.mac.path.is_ident("env") => {
            let name = call.mac.parse_body::<syn::LitStr>().ok()?;
            let dir = manifest_dir.filter(|_| name.value() == "CARGO_MANIFEST_DIR")?;
            dir.to_str().map(str::to_owned)
        }
        _ => None,
    }
}

/// Whether the tokens say `env!("OUT_DIR")`, the directory that build scripts write to.
fn names_out_dir(tokens: &TokenStream) -> bool {
    tokens.clone().into_iter().any(|token| match token {
        TokenTree::Group(group) => names_out_dir(&group.stream()),
        TokenTree::Literal(literal) => literal.to_string() == "\"OUT_DIR\"",
        TokenTree::Ident(_) | TokenTree::Punct(_) => false,
    })
}

/// The last string among the tokens: where a path is put together, it names the file.
fn last_literal(tokens: &TokenStream) -> Option<String> {
    tokens
        .clone()
        .into_iter()
        .filter_map(|token| match token {
            TokenTree::Group(group) => last_literal(&group.stream()),
            TokenTree::Literal(literal) => Some(literal.to_string().trim_matches('"').to_owned()),
            TokenTree::Ident(_) | TokenTree::Punct(_) => None,
        })
        .last()
}
