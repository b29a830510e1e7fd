//! Names that nothing uses any more once the updates are gone: the length in the head of an inner loop.

use super::Reason;
use super::body::LoopBody;
use super::loops::Loops;
use super::mentions::Guarded;
use super::text::{without_comments, words};
use crate::index::Def;
use crate::source::Span;
use crate::syntax::tree::{ExprId, ExprKind};

/// A name with where it is declared.
pub(super) struct Leftover {
    pub(super) name: String,
    pub(super) span: Span,
}

impl Leftover {
    /// Why that is nothing for a crate that denies it.
    pub(super) fn refusal(&self) -> Reason {
        let text = format!(
            "nothing but the updates uses `{}`, and the crate denies what has no use: take it out of the updates first, or allow that \
             here",
            self.name
        );
        Reason { span: self.span, text }
    }
}

/// The variables and constants that are named by code that goes, and by nothing that stays.
pub(super) fn leftovers(loops: &Loops<'_>, of: &LoopBody<'_>, guarded: &[Guarded]) -> Vec<Leftover> {
    let gone: Vec<ExprId> = guarded
        .iter()
        .flat_map(|own| &own.sites)
        .filter(|site| site.stmt.is_some())
        .flat_map(|site| of.body.within(if Some(site.gone) == site.inner { site.gone } else { site.outer }))
        .collect();
    let mut found: Vec<Leftover> = Vec::new();
    for id in &gone {
        let ExprKind::Path(_) = of.kind(*id) else { continue };
        let left = match (of.typed.expr_local.get(id), of.typed.expr_def.get(id)) {
            (Some(local), _) => {
                let is_held = guarded.iter().any(|own| own.place.local == *local);
                let own = of.typed.local(*local);
                let is_inside = gone.iter().any(|at| of.span(*at).contains(own.span));
                let is_named = of.typed.expr_local.iter().any(|(at, other)| other == local && !gone.contains(at));
                let is_unused = !is_held && !is_inside && !is_named && !own.name.starts_with('_');
                is_unused.then(|| Leftover { name: own.name.clone(), span: own.span })
            }
            (None, Some(Def::Value(value))) => {
                let value = of.program.index.value(*value);
                let is_used = loops.program.sources.files().any(|(_, file)| is_used(&file.text, &value.name));
                (!is_used).then(|| Leftover { name: value.name.clone(), span: of.span(*id) })
            }
            _ => None,
        };
        if let Some(left) = left.filter(|left| found.iter().all(|other| other.name != left.name)) {
            found.push(left);
        }
    }
    found
}

/// Whether a constant is named elsewhere than where it is declared and at the end of a range, as in the heads of loops that go.
fn is_used(text: &str, name: &str) -> bool {
    words(text, name).next().is_some() && {
        let code = without_comments(text);
        words(&code, name).any(|at| {
            let before = code[..at].trim_end();
            let is_declared = before.ends_with("const") || before.ends_with("static");
            let is_public = is_declared && before[..before.len() - 5].trim_end().ends_with("pub");
            is_public || !is_declared && !before.ends_with("..")
        })
    }
}
