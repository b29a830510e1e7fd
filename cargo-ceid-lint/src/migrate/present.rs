//! Loops that have a guard already: its list gets the filters that are still updated by hand, before those that are there.

use super::Reason;
use super::body::LoopBody;
use super::exits::{Exits, diverges};
use super::mentions::{Guarded, is_about};
use super::text::{begins_line, indentation, without_comments};
use crate::source::Span;
use crate::syntax::tree::{ExprId, ExprKind, MacroKind, StmtKind};

/// How many filters one list may have.
const MOST: usize = 16;

/// The `ceid!` that a loop has.
#[derive(Clone, Debug)]
pub(super) struct Present {
    /// Its statement, behind which the guard stands.
    pub(super) stmt: Span,
    /// The call of the macro.
    call: ExprId,
    /// What is in its list: from the name or the place to the end of the place.
    entries: Vec<Span>,
}

impl Present {
    /// The guard of a loop, if there is one.
    ///
    /// # Errors
    /// Why a guard that is there cannot have one filter more.
    pub(super) fn of(of: &LoopBody<'_>) -> Result<Option<Self>, String> {
        let is_guard = |id: &ExprId| match of.kind(*id) {
            ExprKind::Macro(call) => matches!(call.kind, MacroKind::Ceid { .. } | MacroKind::EachCycle { .. }),
            _ => false,
        };
        // A guard of an inner loop ends with that one's iterations.
        let is_inner = |id: &ExprId| {
            of.ancestors_inside(*id)
                .any(|at| matches!(of.kind(at), ExprKind::Loop { .. } | ExprKind::While { .. } | ExprKind::For { .. }))
        };
        let guards: Vec<ExprId> = of.inside.iter().copied().filter(|id| is_guard(id) && !is_inner(id)).collect();
        let Some(call) = guards.first().copied() else { return Ok(None) };
        let by_hand = |why: &str| {
            format!("a guard is there already, {why}: add the filter to its list, and delete the call of its law")
        };
        let ExprKind::Macro(kind) = of.kind(call) else { return Ok(None) };
        let MacroKind::Ceid { filters, names, token: Some(_) } = &kind.kind else {
            return Err("a guard is there already, whose filters a `Cyclic` owns: make the filter one of its set, and delete the call of \
                        its law"
                .to_owned());
        };
        let ExprKind::Block(block) = of.kind(of.block) else { return Ok(None) };
        let is_it = |kind: &StmtKind| matches!(kind, StmtKind::Expr { expr, .. } if *expr == call);
        let stmt = block.stmts.iter().find(|stmt| stmt.cfg.is_none() && is_it(&stmt.kind));
        let Some(stmt) = stmt.filter(|_| guards.len() == 1 && !filters.is_empty()) else {
            return Err(by_hand("which is no statement of this loop"));
        };
        let entry = |(_, place): &(String, ExprId)| {
            let name = names.iter().find(|(_, of_name)| of_name == place);
            name.map_or(of.span(*place), |(name, _)| of.body.pat(*name).span.to(of.span(*place)))
        };
        Ok(Some(Self { stmt: stmt.span, call, entries: filters.iter().map(entry).collect() }))
    }

    /// Whether the list can have these filters as well, so that each law runs when it did but for the end of the iteration.
    /// `is_exact` says that each is updated exactly once today.
    ///
    /// # Errors
    /// Why not.
    pub(super) fn admits(
        &self,
        of: &LoopBody<'_>,
        guarded: &[Guarded],
        exits: &Exits,
        is_exact: bool,
    ) -> Result<(), Reason> {
        let refuse = |at: Span, text: String| Err(Reason { span: at, text });
        let all = self.entries.len() + guarded.len();
        if all > MOST {
            return refuse(
                self.stmt,
                format!("the guard would have {all} filters, and can have {MOST}: declare them with `filters!`"),
            );
        }
        // What leaves the loop is no iteration that owes an update; of a function, it is.
        let ends_above = |id: &ExprId| {
            let goes_on = match of.kind(*id) {
                ExprKind::Continue { .. } => diverges(of, *id) && !exits.left_at.contains(id),
                ExprKind::Opaque(_) | ExprKind::Unknown { .. } => true,
                _ => of.is_function,
            };
            goes_on && *id != of.block && of.span(*id).start < self.stmt.start
        };
        if !is_exact && of.inside.iter().any(ends_above) {
            return refuse(
                self.stmt,
                "an iteration may end above the guard that is there: let it begin with the guard".to_owned(),
            );
        }
        for own in guarded {
            let spelled = &own.spelled;
            let is_about = |id: &&ExprId| is_about(of, &own.place, **id);
            if let Some(at) = of.inside.iter().filter(|id| self.stmt.contains(of.span(**id))).find(is_about) {
                return refuse(
                    of.span(*at),
                    format!("the guard that is there has `{spelled}` in its hands: delete the call of its law"),
                );
            }
            if own.locked.is_some() {
                return refuse(self.stmt, format!("`{spelled}` is locked in the loop, and a guard is there already"));
            }
            let is_above = |at: Span| at.end <= self.stmt.start;
            if let Some(site) = own.sites.iter().find(|site| is_above(of.span(site.call))) {
                let text =
                    format!("`{spelled}` is updated above the guard that is there: let the loop begin with the guard");
                return refuse(of.span(site.call), text);
            }
            let named = of.inside.iter().filter(|id| is_above(of.span(**id))).find(is_about);
            if let Some(at) = named.filter(|_| own.is_lent_above()) {
                let text = format!(
                    "`{spelled}` is used above the guard that is there, where it is lent to it: let the loop begin with the guard"
                );
                return refuse(of.span(*at), text);
            }
        }
        Ok(())
    }

    /// The edit that puts the filters first in the list: their laws run before those that follow the end of the body today.
    pub(super) fn with(&self, of: &LoopBody<'_>, new: &[String]) -> (Span, String) {
        let text = of.text;
        let first = self.entries[0].start as usize;
        let end = of.style.end;
        let at = |from: usize, to: usize| {
            let number = |at: usize| u32::try_from(at).unwrap_or(u32::MAX);
            Span::new(of.file(), number(from), number(to))
        };
        if begins_line(text, first) {
            let indent = indentation(text, first);
            let lines: String = new.iter().map(|entry| format!("{entry},{end}{indent}")).collect();
            return (at(first, first), lines);
        }
        let inserted = format!("{}, ", new.join(", "));
        let call = of.span(self.call);
        let written = of.written(self.call);
        let line = text[..call.start as usize].rsplit('\n').next().unwrap_or_default().len();
        let is_plain = !written.contains('\n') && without_comments(written) == written && written.ends_with(')');
        let arrow = text[call.start as usize..first].rfind("=>").map(|at| call.start as usize + at);
        let open = written.find('(').map(|at| call.start as usize + at + 1);
        let (Some(arrow), Some(open)) = (arrow, open) else { return (at(first, first), inserted) };
        let is_too_long = line + written.len() + inserted.len() + 1 > of.style.width;
        if !is_plain || !is_too_long || !begins_line(text, call.start as usize) {
            return (at(first, first), inserted);
        }
        let indent = indentation(text, call.start as usize);
        let step = of.style.step;
        let old = self.entries.iter().map(|entry| of.program.sources.snippet(*entry).to_owned());
        let list: Vec<String> = new.iter().cloned().chain(old).collect();
        let list = list.join(&format!(",{end}{indent}{step}{step}"));
        let token = text[open..arrow].trim();
        let tokens = format!("{end}{indent}{step}{token} =>{end}{indent}{step}{step}{list}{end}{indent}");
        (at(open, call.end as usize - 1), tokens)
    }
}
