//! Code that says nothing of other code: it brings in no file, declares no macro, and has no part that `cfg` could remove. Where
//! no item is kept, it is not lowered. Never says so when unsure.

use proc_macro2::{TokenStream, TokenTree};
use syn::visit::{self, Visit};

use super::{Lowerer, name};
use crate::syntax::cfg_eval::Presence;
use crate::syntax::modules::Loader;

/// The names without which tokens bring in no file, declare no macro and depend on no `cfg`.
const TELLING: [&str; 6] = ["cfg", "cfg_attr", "cfg_if", "include", "macro_rules", "mod"];

/// Whether nothing would be left of an item of a file that is there.
pub(in crate::syntax) fn is_silent(loader: &Loader<'_>, item: &syn::Item) -> bool {
    looks_silent(loader, |search| search.visit_item(item))
}

/// Whether the attributes of a file neither depend on a `cfg` nor give it a part.
pub(in crate::syntax) fn are_silent(loader: &Loader<'_>, attributes: &[syn::Attribute]) -> bool {
    looks_silent(loader, |search| attributes.iter().for_each(|attribute| search.visit_attribute(attribute)))
}

fn looks_silent(loader: &Loader<'_>, look: impl FnOnce(&mut Search<'_, '_>)) -> bool {
    let mut search = Search { loader, found: false };
    look(&mut search);
    !search.found
}

impl Lowerer<'_, '_> {
    /// Whether nothing would be left of an item.
    pub(super) fn is_silent_item(&self, item: &syn::Item) -> bool {
        self.is_silent(|search| search.visit_item(item))
    }

    /// Whether nothing would be left of a body.
    pub(super) fn is_silent_block(&self, block: &syn::Block) -> bool {
        self.is_silent(|search| search.visit_block(block))
    }

    fn is_silent(&self, look: impl FnOnce(&mut Search<'_, '_>)) -> bool {
        // What is not there for a reason outside of it is noted as removed.
        if self.loader.keeps_items || self.given != Presence::Present {
            return false;
        }
        looks_silent(self.loader, look)
    }
}

/// Every name among the tokens, without `r#`.
pub(in crate::syntax) fn names_in(tokens: &TokenStream, found: &mut impl FnMut(String)) {
    for token in tokens.clone() {
        match token {
            TokenTree::Group(group) => names_in(&group.stream(), found),
            TokenTree::Ident(ident) => found(name(&ident)),
            TokenTree::Punct(_) | TokenTree::Literal(_) => {}
        }
    }
}

/// Looks for what says something.
struct Search<'s, 'a> {
    loader: &'s Loader<'a>,
    found: bool,
}

impl Search<'_, '_> {
    /// Whether tokens with this name in them may stand for something that says something.
    fn tells(&self, name: &str) -> bool {
        let is_own = |name: &str| self.loader.own_macros.contains(name);
        TELLING.contains(&name) || is_own(name) && self.loader.own.tell(name, &is_own, &|word| TELLING.contains(&word))
    }
}

impl<'e> Visit<'e> for Search<'_, '_> {
    fn visit_item(&mut self, item: &'e syn::Item) {
        match item {
            syn::Item::Mod(_) => self.found = true,
            syn::Item::Macro(item) if item.ident.is_some() => self.found = true,
            syn::Item::Impl(item) if item.modifiers.polarity.is_some() => self.found = true,
            _ if self.found => {}
            _ => visit::visit_item(self, item),
        }
    }

    fn visit_attribute(&mut self, attribute: &'e syn::Attribute) {
        let segments = &attribute.path().segments;
        self.found |= segments.iter().any(|segment| TELLING.contains(&name(&segment.ident).as_str()));
    }

    fn visit_macro(&mut self, mac: &'e syn::Macro) {
        for segment in &mac.path.segments {
            self.found |= self.tells(&name(&segment.ident));
        }
        if !self.found {
            let mut found = false;
            names_in(&mac.tokens, &mut |name| found |= self.tells(&name));
            self.found = found;
        }
    }

    fn visit_expr(&mut self, expr: &'e syn::Expr) {
        if !self.found {
            visit::visit_expr(self, expr);
        }
    }

    // No code is lowered out of types, and of patterns only the conditions of match arms.
    fn visit_type(&mut self, _: &'e syn::Type) {}

    fn visit_path(&mut self, _: &'e syn::Path) {}

    fn visit_generics(&mut self, _: &'e syn::Generics) {}

    fn visit_signature(&mut self, _: &'e syn::Signature) {}

    fn visit_pat(&mut self, pat: &'e syn::Pat) {
        if let syn::Pat::Guard(guarded) = pat {
            self.visit_expr(&guarded.guard);
        }
    }
}
