//! `cfg_if!`: the branch that is certain, or all that may be there, under keys that exclude each other.

use proc_macro2::TokenStream;
use syn::parse::{Parse, ParseStream};
use syn::{Attribute, Token};

use super::parse;
use crate::syntax::cfg_eval::{Presence, evaluate};
use crate::syntax::lower::Lowerer;
use crate::syntax::tree::Item;

/// A branch that may be there.
pub(in crate::syntax) struct CfgBranch {
    pub(in crate::syntax) presence: Presence,
    pub(in crate::syntax) tokens: TokenStream,
}

/// `if #[cfg(a)] { … } else if #[cfg(b)] { … } else { … }`; the last condition may be missing.
struct Branches(Vec<(Option<TokenStream>, TokenStream)>);

impl Parse for Branches {
    fn parse(input: ParseStream<'_>) -> syn::Result<Self> {
        let mut branches = Vec::new();
        loop {
            let mut condition = None;
            if input.parse::<Option<Token![if]>>()?.is_some() {
                let attributes = input.call(Attribute::parse_outer)?;
                let [attribute] = attributes.as_slice() else { return Err(input.error("expected `#[cfg(…)]`")) };
                condition = Some(attribute.meta.require_list()?.tokens.clone());
            }
            let is_last = condition.is_none();
            let content;
            syn::braced!(content in input);
            branches.push((condition, content.parse()?));
            if input.is_empty() {
                return Ok(Self(branches));
            }
            if is_last {
                return Err(input.error("expected the end of the macro"));
            }
            input.parse::<Token![else]>()?;
        }
    }
}

impl Lowerer<'_, '_> {
    /// The branches that may be there; `None` if this is not a `cfg_if!`.
    pub(in crate::syntax) fn cfg_if_branches(&self, mac: &syn::Macro) -> Option<Vec<CfgBranch>> {
        if self.known_name(mac)? != "cfg_if" {
            return None;
        }
        let mut none_before = Presence::Present;
        let mut branches = Vec::new();
        for (condition, tokens) in parse::<Branches>(mac)?.0 {
            let value = condition.map_or(Presence::Present, |condition| evaluate(&condition, self.cfg()));
            let presence = none_before.clone().and(value.clone());
            none_before = none_before.and(value.not());
            if presence != Presence::Absent {
                branches.push(CfgBranch { presence, tokens });
            }
        }
        Some(branches)
    }

    pub(super) fn cfg_if_items(&mut self, mac: &syn::Macro, out: &mut Vec<Item>) -> bool {
        let Some(branches) = self.cfg_if_branches(mac) else { return false };
        // What a branch that is not taken declares is there in another build.
        for (_, tokens) in parse::<Branches>(mac).into_iter().flat_map(|all| all.0) {
            for item in syn::parse2::<syn::File>(tokens).into_iter().flat_map(|file| file.items) {
                self.note_removed(&item);
            }
        }
        let files: Option<Vec<(Presence, syn::File)>> = branches
            .into_iter()
            .map(|branch| Some((branch.presence, syn::parse2::<syn::File>(branch.tokens).ok()?)))
            .collect();
        let Some(files) = files else { return false };
        for (presence, file) in files {
            self.given(presence, |low| low.items(&file.items, out));
        }
        true
    }
}
