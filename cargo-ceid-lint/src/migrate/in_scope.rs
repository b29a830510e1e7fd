//! Names by which the loop calls a law: what runs the law stands above the loop, and has no name that is declared in there.

use super::Reason;
use super::body::LoopBody;
use super::mentions::Guarded;
use super::sites::Site;
use super::text::{has_word, without_comments};
use super::turbofish::turbofish;
use crate::index::{BodyOwner, Def, FunctionId, Index, ModuleId, Namespace, Owner, TraitName};
use crate::syntax::tree::{ExprId, ExprKind};

/// Why the call of a law cannot be written above the loop: something in it has its name only in the loop.
pub(super) fn named_in_the_loop(of: &LoopBody<'_>, own: &Guarded) -> Option<Reason> {
    own.sites.iter().find_map(|site| {
        let text = of_site(of, site)?;
        Some(Reason { span: of.span(site.call), text })
    })
}

fn of_site(of: &LoopBody<'_>, site: &Site) -> Option<String> {
    if let ExprKind::Call { callee, .. } = of.kind(site.call)
        && of.typed.expr_local.contains_key(callee)
    {
        let (filter, name) = (of.written(site.receiver), of.written(*callee));
        let text = format!(
            "the law of `{}` is called by the variable `{name}`: call it by its own name",
            filter.trim_start_matches("&mut ")
        );
        return Some(text);
    }
    let index = of.program.index;
    // What a function declares is there in all of it.
    let outer = module_at(of, if of.is_function { of.block } else { of.whole });
    let inner = module_at(of, site.call);
    if inner == outer {
        return None;
    }
    let place = if of.is_function { "at the head of the function" } else { "above the loop" };
    let path = match of.kind(site.call) {
        ExprKind::Call { callee, .. } => of.written(*callee),
        _ => "",
    };
    let said = [path, turbofish(of, site.call)].concat();
    let means = |module: ModuleId, name: &str| index.resolve(module, &[name.to_owned()], Namespace::Type);
    let is_declared = |name: &&str| means(inner, name) != means(outer, name);
    if let Some(name) = first_names(&said).into_iter().find(is_declared) {
        return Some(format!(
            "`{name}` has its name from the block that updates `{}`, and what runs the law stands {place}: declare or import \
             it there",
            of.written(site.receiver).trim_start_matches("&mut ")
        ));
    }
    if !matches!(of.kind(site.call), ExprKind::MethodCall { .. }) {
        return None;
    }
    let of_trait = site.targets.iter().find_map(|law| trait_of(index, *law))?;
    let (name, def) = match &of_trait {
        TraitName::Local(id) => (index.trait_def(*id).name.clone(), Def::Trait(*id)),
        TraitName::External(path) => (path.rsplit("::").next()?.to_owned(), Def::External(path.clone())),
    };
    let is_there = |module: ModuleId| means(module, &name).as_ref() == Some(&def);
    let is_renamed = || {
        let code = without_comments(of.program.sources.snippet(of.span(of.block)));
        has_word(&code, "use") && code.contains(&format!("{name} as "))
    };
    (!is_there(outer) && (is_there(inner) || is_renamed())).then(|| {
        format!(
            "`{name}`, whose law `{}` this is, is imported in the block that updates `{}`, and what runs the law stands {place}: import \
             it there",
            site.method,
            of.written(site.receiver).trim_start_matches("&mut ")
        )
    })
}

/// The module of the innermost block around an expression that has items, or of the function.
fn module_at(of: &LoopBody<'_>, id: ExprId) -> ModuleId {
    let mut blocks = std::iter::once(id).chain(of.ancestors(id));
    let with_items = |at: ExprId| of.program.index.blocks.get(&(BodyOwner::Function(of.function), at)).copied();
    blocks.find_map(with_items).unwrap_or(of.def().module)
}

/// The names in a path or in its arguments that no other one leads to.
fn first_names(text: &str) -> Vec<&str> {
    let is_other = |sign: char| !(sign.is_alphanumeric() || sign == '_');
    let mut found = Vec::new();
    let mut at = 0;
    for piece in text.split_inclusive(is_other) {
        let name = piece.trim_end_matches(is_other);
        if !name.is_empty() && !text[..at].ends_with("::") {
            found.push(name);
        }
        at += piece.len();
    }
    found
}

fn trait_of(index: &Index, law: FunctionId) -> Option<TraitName> {
    match index.function(law).owner {
        Owner::Trait(id) => Some(TraitName::Local(id)),
        Owner::Impl(id) => index.impl_def(id).implements.clone(),
        Owner::Module => None,
    }
}
