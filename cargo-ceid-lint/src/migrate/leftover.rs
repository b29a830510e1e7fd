//! Names that nothing uses any more once the updates are gone: the length in the head of an inner loop.

use super::Reason;
use super::body::LoopBody;
use super::imports::to_u32;
use super::loops::Loops;
use super::mentions::Guarded;
use super::text::{without_comments, words};
use crate::index::{Def, Ty};
use crate::source::Span;
use crate::syntax::tree::{ExprId, ExprKind, PatId, PatKind};
use crate::types::{Callee, LocalId};

/// A name with where it is declared.
pub(super) struct Leftover {
    pub(super) name: String,
    pub(super) span: Span,
    /// Whether a `_` before the name where it is declared is all that it takes for nobody to ask for a use of it.
    is_renamed: bool,
}

impl Leftover {
    /// What to write so that nobody asks for a use of it.
    pub(super) fn edit(&self) -> Option<(Span, String)> {
        self.is_renamed.then(|| (Span { end: self.span.start, ..self.span }, "_".to_owned()))
    }

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
                let is_renamed = is_unused && can_be_renamed(of, *local, &gone);
                is_unused.then(|| Leftover { name: own.name.clone(), span: own.span, is_renamed })
            }
            (None, Some(Def::Value(value))) => {
                let value = of.program.index.value(*value);
                let is_used = loops.program.sources.files().any(|(_, file)| is_used(&file.text, &value.name));
                (!is_used).then(|| Leftover { name: value.name.clone(), span: of.span(*id), is_renamed: false })
            }
            _ => None,
        };
        if let Some(left) = left.filter(|left| found.iter().all(|other| other.name != left.name)) {
            found.push(left);
        }
    }
    found
}

/// Whether a variable may have another name where it is declared: nothing but that and what goes spells it, be it in a text or in code
/// that is left out, and it is neither `mut` nor named as a field is.
fn can_be_renamed(of: &LoopBody<'_>, local: LocalId, gone: &[ExprId]) -> bool {
    let own = of.typed.local(local);
    let is_of_field = |(_, pat): &(String, PatId)| of.typed.pat_local.get(pat) == Some(&local);
    let is_field = of.body.pats.iter().any(|pat| match &pat.kind {
        PatKind::Struct(_, fields) => fields.iter().any(is_of_field),
        _ => false,
    });
    let body = of.span(of.body.root);
    let sources = of.program.sources;
    let code = without_comments(sources.snippet(body));
    let is_known = |at: usize| {
        // A method or field.
        if code[..at].ends_with('.') && !code[..at].ends_with("..") {
            return true;
        }
        let at = Span { start: body.start + to_u32(at), end: body.start + to_u32(at + own.name.len()), ..body };
        own.span.contains(at) || gone.iter().any(|id| of.span(*id).contains(at))
    };
    !is_field && sources.snippet(own.span) == own.name && words(&code, &own.name).all(is_known)
}

/// What to delete so that no variable stays `mut` of which only an update has borrowed the variable itself: `update(&mut pid)` of a
/// reference `let mut pid = &mut self.pid;`.
///
/// # Errors
/// Where something else still may need it that will not once it is migrated.
pub(super) fn idle_muts(of: &LoopBody<'_>, guarded: &[Guarded]) -> Result<Vec<Span>, Reason> {
    let is_lent_itself = |at: ExprId| {
        let parent = of.parent(at).map(|parent| of.kind(parent));
        matches!(parent, Some(ExprKind::Reference { mutable: true, .. }))
    };
    let is_gone = |at: ExprId| guarded.iter().flat_map(|own| &own.sites).any(|site| site.receiver == at);
    let mut found = Vec::new();
    for own in guarded.iter().filter(|own| own.place.fields.is_empty() && !own.is_lock_guard) {
        let local = of.typed.local(own.place.local);
        let declared = of.program.sources.snippet(local.span);
        let Some(name) = declared.strip_prefix("mut").map(str::trim_start).filter(|name| name.len() < declared.len())
        else {
            continue;
        };
        if !matches!(local.ty, Ty::Ref(true, _)) || !own.sites.iter().any(|site| is_lent_itself(site.receiver)) {
            continue;
        }
        let names = of.typed.expr_local.iter().filter(|(_, other)| **other == own.place.local).map(|(at, _)| *at);
        let stays: Vec<ExprId> = names.filter(|at| !is_gone(*at)).collect();
        let is_unread = of.body.exprs.iter().any(|expr| match &expr.kind {
            ExprKind::Opaque(call) => call.mentions.contains(&local.name),
            ExprKind::Unknown { mentions, .. } => mentions.contains(&local.name),
            _ => false,
        });
        let needing: Vec<ExprId> = stays.into_iter().filter(|at| needs_mut(of, *at)).collect();
        let is_update = |at: &ExprId| {
            let call = of.parent(*at).and_then(|reference| of.parent(reference));
            let callee = call.and_then(|call| of.typed.callees.get(&call));
            is_lent_itself(*at) && matches!(callee, Some(Callee::Resolved(callee)) if callee.law.is_some())
        };
        if needing.is_empty() && !is_unread {
            let end = local.span.end - to_u32(name.len());
            found.push(Span { end, ..local.span });
        } else if !is_unread && needing.iter().all(is_update) {
            let text = format!(
                "`{0}` is a reference, and `mut` only for `&mut {0}` in its updates: write `{0}` there, and no `mut` here",
                local.name
            );
            return Err(Reason { span: local.span, text });
        }
    }
    Ok(found)
}

/// Whether the variable that is named there may have to be `mut` for that, if it is a reference.
fn needs_mut(of: &LoopBody<'_>, at: ExprId) -> bool {
    let Some(parent) = of.parent(at) else { return true };
    match of.kind(parent) {
        ExprKind::Field { .. } | ExprKind::Deref(_) | ExprKind::Index { .. } | ExprKind::Block(_) => false,
        ExprKind::Reference { mutable, .. } => *mutable,
        ExprKind::Assign { place, .. } => *place == at,
        ExprKind::Call { callee, .. } => *callee == at,
        ExprKind::MethodCall { receiver, .. } => {
            let is_known = matches!(of.typed.callees.get(&parent), Some(Callee::Resolved(_)));
            *receiver == at && !is_known
        }
        ExprKind::Macro(_) => false,
        _ => true,
    }
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
