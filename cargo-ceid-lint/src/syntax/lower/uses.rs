//! `use` trees, one entry a name. Never resolves them.

use super::{Lowerer, name};
use crate::source::Span;
use crate::syntax::tree::UseName;

impl Lowerer<'_, '_> {
    pub(super) fn use_names(&self, item: &syn::ItemUse) -> Vec<UseName> {
        let mut prefix = Vec::new();
        if item.leading_colon.is_some() || self.begins_at_crate_root(&item.tree) {
            prefix.push(String::new());
        }
        let mut names = Vec::new();
        self.use_tree(&item.tree, &mut prefix, &mut names);
        names
    }

    /// In the 2015 edition, every `use` begins at the crate root.
    fn begins_at_crate_root(&self, tree: &syn::UseTree) -> bool {
        let first = match tree {
            syn::UseTree::Path(path) => Some(&path.ident),
            syn::UseTree::Name(tree) => Some(&tree.ident),
            syn::UseTree::Rename(tree) => Some(&tree.ident),
            _ => None,
        };
        self.loader.edition == "2015"
            && first.is_none_or(|first| !["crate", "self", "super"].iter().any(|word| first == word))
    }

    fn use_tree(&self, tree: &syn::UseTree, prefix: &mut Vec<String>, names: &mut Vec<UseName>) {
        match tree {
            syn::UseTree::Path(path) => {
                prefix.push(name(&path.ident));
                self.use_tree(&path.tree, prefix, names);
                prefix.pop();
            }
            syn::UseTree::Name(tree) => {
                let bound = name(&tree.ident);
                names.push(self.use_name(prefix, &tree.ident, bound, self.span(tree.ident.span())));
            }
            syn::UseTree::Rename(tree) => {
                let span = self.span(tree.ident.span()).to(self.span(tree.rename.span()));
                names.push(self.use_name(prefix, &tree.ident, name(&tree.rename), span));
            }
            syn::UseTree::Glob(glob) => {
                let span = self.span(glob.star_token.span);
                names.push(UseName { path: prefix.clone(), name: None, span });
            }
            syn::UseTree::Group(group) => {
                for tree in &group.items {
                    self.use_tree(tree, prefix, names);
                }
            }
        }
    }

    fn use_name(&self, prefix: &[String], last: &syn::Ident, bound: String, span: Span) -> UseName {
        let mut path = prefix.to_vec();
        let mut bound = bound;
        if last == "self" && !path.is_empty() {
            if bound == "self" {
                bound = path.last().cloned().unwrap_or_default();
            }
        } else {
            path.push(name(last));
        }
        UseName { path, name: Some(bound), span }
    }
}
