//! The signatures of the methods that presets name, read from the sources of the crates: by the parser, and where a macro makes
//! them by their words.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use quote::ToTokens;
use syn::visit::{self, Visit};

use super::Named;

/// The items of a crate that have methods, by the last name of the type or trait.
#[derive(Default)]
pub(super) struct Crate {
    methods: BTreeMap<String, BTreeMap<String, BTreeSet<String>>>,
    functions: BTreeMap<String, BTreeSet<String>>,
    /// The traits that a type implements.
    implements: BTreeMap<String, BTreeSet<String>>,
    /// What an alias or a renamed import stands for.
    aliases: BTreeMap<String, BTreeSet<String>>,
    /// The signatures in the bodies of macros, which may belong to any type.
    in_macros: BTreeMap<String, BTreeSet<String>>,
    owner: Option<String>,
}

impl Crate {
    /// Reads all sources below the directory of a manifest.
    pub(super) fn read(manifest: &Path) -> Self {
        let mut found = Self::default();
        let directory = manifest.parent().expect("a manifest lies in a directory").join("src");
        let mut open = vec![directory];
        while let Some(path) = open.pop() {
            for entry in std::fs::read_dir(&path).into_iter().flatten().flatten() {
                let path: PathBuf = entry.path();
                if path.is_dir() {
                    open.push(path);
                } else if path.extension().is_some_and(|extension| extension == "rs") {
                    let text = std::fs::read_to_string(&path).unwrap_or_default();
                    if let Ok(file) = syn::parse_file(&text) {
                        found.visit_file(&file);
                    }
                }
            }
        }
        found
    }

    /// The signatures of a method of a type or trait, with those that it gets from traits of the crates it depends on.
    fn signatures<'d>(&self, owner: &str, method: &str, dependencies: &dyn Fn() -> &'d [Self]) -> BTreeSet<String> {
        let own = |name: &str| self.methods.get(name).and_then(|methods| methods.get(method)).cloned();
        let mut found = own(owner).unwrap_or_default();
        for target in self.aliases.get(owner).into_iter().flatten().filter(|target| *target != owner) {
            found.extend(self.signatures(target, method, dependencies));
        }
        if found.is_empty() {
            let of_traits = self.implements.get(owner).into_iter().flatten();
            for name in of_traits.map(String::as_str).chain([owner]) {
                let everywhere = dependencies().iter().chain([self]);
                found.extend(everywhere.filter_map(|of| of.methods.get(name)?.get(method)).flatten().cloned());
            }
        }
        let is_made_by_macro = !self.methods.contains_key(owner) && !self.implements.contains_key(owner);
        if found.is_empty() && is_made_by_macro {
            found.extend(self.in_macros.get(method).into_iter().flatten().cloned());
        }
        found
    }

    /// One line for each signature of what a preset names, sorted.
    pub(super) fn lines<'d>(&self, named: &[Named], dependencies: &dyn Fn() -> &'d [Self]) -> BTreeSet<String> {
        let mut lines = BTreeSet::new();
        for entry in named {
            let owner = entry.path.rsplit("::").next().unwrap_or(&entry.path);
            for method in &entry.methods {
                let signatures = match entry.is_function {
                    true => self.functions.get(method).cloned().unwrap_or_default(),
                    false => self.signatures(owner, method, dependencies),
                };
                lines.extend(signatures.into_iter().map(|signature| format!("{}::{signature}", entry.path)));
            }
        }
        lines
    }

    fn add(&mut self, signature: &syn::Signature) {
        let name = signature.ident.to_string();
        let text = spelled(signature);
        match &self.owner {
            Some(owner) => self.methods.entry(owner.clone()).or_default().entry(name).or_default().insert(text),
            None => self.functions.entry(name).or_default().insert(text),
        };
    }

    fn within(&mut self, owner: Option<String>, inside: impl FnOnce(&mut Self)) {
        let outer = std::mem::replace(&mut self.owner, owner);
        inside(self);
        self.owner = outer;
    }
}

/// `name(&mut self, input: T) -> T`, in one spelling.
fn spelled(signature: &syn::Signature) -> String {
    let inputs: Vec<String> = signature.inputs.iter().map(tokens).collect();
    let output = match &signature.output {
        syn::ReturnType::Default => String::new(),
        syn::ReturnType::Type(_, ty) => format!(" -> {}", tokens(ty)),
    };
    let asyncness = if signature.asyncness.is_some() { "async " } else { "" };
    format!("{}({}){output}", signature.ident, inputs.join(", ")).replacen("", asyncness, 1)
}

/// Tokens with no more spaces than are needed to read them.
fn tokens(of: &impl ToTokens) -> String {
    let mut text = of.to_token_stream().to_string();
    for (from, to) in [
        (" :: ", "::"),
        (":: ", "::"),
        (" ::", "::"),
        (" <", "<"),
        ("< ", "<"),
        (" >", ">"),
        ("& ", "&"),
        (" ,", ","),
        (" :", ":"),
        ("( ", "("),
        (" )", ")"),
        ("[ ", "["),
        (" ]", "]"),
        (" ;", ";"),
        (" (", "("),
    ] {
        text = text.replace(from, to);
    }
    text.replace("->", " -> ").replace("  ", " ")
}

fn last_name(ty: &syn::Type) -> Option<String> {
    match ty {
        syn::Type::Path(path) => path.path.segments.last().map(|segment| segment.ident.to_string()),
        syn::Type::Reference(reference) => last_name(&reference.elem),
        _ => None,
    }
}

impl<'ast> Visit<'ast> for Crate {
    fn visit_item_impl(&mut self, item: &'ast syn::ItemImpl) {
        let owner = last_name(&item.self_ty);
        if let (Some(owner), Some((path, _))) = (&owner, &item.trait_)
            && let Some(segment) = path.segments.last()
        {
            self.implements.entry(owner.clone()).or_default().insert(segment.ident.to_string());
        }
        self.within(owner, |this| visit::visit_item_impl(this, item));
    }

    fn visit_item_trait(&mut self, item: &'ast syn::ItemTrait) {
        let supertraits = item.supertraits.iter().filter_map(|bound| match bound {
            syn::TypeParamBound::Trait(bound) => Some(bound.path.segments.last()?.ident.to_string()),
            _ => None,
        });
        self.implements.entry(item.ident.to_string()).or_default().extend(supertraits);
        self.within(Some(item.ident.to_string()), |this| visit::visit_item_trait(this, item));
    }

    fn visit_impl_item_fn(&mut self, item: &'ast syn::ImplItemFn) {
        self.add(&item.sig);
    }

    fn visit_trait_item_fn(&mut self, item: &'ast syn::TraitItemFn) {
        self.add(&item.sig);
    }

    fn visit_item_fn(&mut self, item: &'ast syn::ItemFn) {
        self.within(None, |this| this.add(&item.sig));
    }

    fn visit_item_mod(&mut self, item: &'ast syn::ItemMod) {
        if item.ident != "tests" && item.ident != "test" {
            visit::visit_item_mod(self, item);
        }
    }

    fn visit_item_type(&mut self, item: &'ast syn::ItemType) {
        if let Some(target) = last_name(&item.ty) {
            self.aliases.entry(item.ident.to_string()).or_default().insert(target);
        }
    }

    fn visit_use_rename(&mut self, item: &'ast syn::UseRename) {
        self.aliases.entry(item.rename.to_string()).or_default().insert(item.ident.to_string());
    }

    fn visit_item_macro(&mut self, item: &'ast syn::ItemMacro) {
        let text = tokens(&item.mac.tokens);
        for part in text.split("fn ").skip(1) {
            let Some(end) = part.find('{') else { continue };
            let signature = part[..end].trim();
            let Some(open) = signature.find('(') else { continue };
            self.in_macros.entry(signature[..open].to_owned()).or_default().insert(signature.to_owned());
        }
    }
}
