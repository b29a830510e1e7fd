//! Laws that advance one of several channels, and which argument selects it.

use super::laws::Finder;
use crate::index::FunctionId;
use crate::syntax::tree::{ExprId, ExprKind, PatKind, StmtKind};
use crate::types::LocalId;

impl Finder<'_> {
    /// The argument, counted without the receiver, with which a law indexes every field that it writes: `self.filters[i].run(x)`.
    pub(super) fn selector(&self, law: FunctionId) -> Option<u32> {
        let def = self.program.index.function(law);
        let (body, typed) = (def.function.body.as_ref()?, self.program.typed(law)?);
        let conduct = self.conduct(law);
        let is_self =
            |base: ExprId| typed.expr_local.get(&base).is_some_and(|local| typed.local(*local).name == "self");
        let written = |id: ExprId| match &body.expr(id).kind {
            ExprKind::Field { base, name } if is_self(*base) => conduct.written.get(name),
            _ => None,
        };
        // `let band = index;`
        let renamed = |local: &LocalId| {
            let blocks = body.exprs.iter().filter_map(|expr| match &expr.kind {
                ExprKind::Block(block) => Some(&block.stmts),
                _ => None,
            });
            blocks.flatten().find_map(|stmt| match &stmt.kind {
                StmtKind::Let { pat, init: Some(init), .. } if typed.pat_local.get(pat) == Some(local) => {
                    let is_fixed = matches!(body.pat(*pat).kind, PatKind::Bind { mutable: false, .. });
                    typed.expr_local.get(init).filter(|_| is_fixed)
                }
                _ => None,
            })
        };
        let local = |mut at: ExprId| {
            while let ExprKind::Cast { value, .. } = &body.expr(at).kind {
                at = *value;
            }
            let local = typed.expr_local.get(&at)?;
            Some(renamed(local).unwrap_or(local))
        };
        let ids = || (0u32..).map(ExprId).take(body.exprs.len());
        let indexed: Vec<(ExprId, ExprId)> = ids()
            .filter_map(|id| match &body.expr(id).kind {
                ExprKind::Index { base, index } => Some((*base, *index)),
                _ => None,
            })
            .filter(|(base, _)| written(*base).is_some())
            .collect();
        let selector = local(indexed.first()?.1)?;
        let is_selected =
            |id: ExprId| indexed.iter().any(|(base, index)| *base == id && local(*index) == Some(selector));
        let is_all = ids().filter(|id| written(*id).is_some()).all(is_selected)
            && conduct.written.iter().all(|field| indexed.iter().any(|(base, _)| written(*base) == Some(field)));
        let is_param = |pat: &crate::syntax::tree::PatId| {
            matches!(body.pat(*pat).kind, PatKind::Bind { .. }) && typed.pat_local.get(pat) == Some(selector)
        };
        let params = body.params.iter().skip(usize::from(def.function.receiver.is_some()));
        let at = params.into_iter().position(is_param).filter(|_| is_all && !conduct.writes_all)?;
        u32::try_from(at).ok()
    }
}
