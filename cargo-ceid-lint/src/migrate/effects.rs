//! What else a law does beside advancing its filter, and what is seen of it when it runs at the end of the cycle.

use std::collections::BTreeSet;

use super::Reason;
use super::body::LoopBody;
use super::exits::Exits;
use super::loops::Loops;
use super::mentions::Guarded;
use super::observed::outlives_panic;
use super::panics::{Panics, may_panic, panics, panics_when_dropped};
use super::purity::{acts_when_dropped, side_effect};
use super::shared::{shared_by_owner, shared_part, touches_shared};
use super::sites::{Part, Site};
use crate::index::{FunctionId, Ty};
use crate::source::Span;
use crate::syntax::tree::{ExprId, ExprKind, PatKind, Stmt, StmtKind};

/// A loop with what its guard is to hold.
pub(super) struct Effects<'a> {
    pub(super) loops: &'a Loops<'a>,
    pub(super) of: &'a LoopBody<'a>,
    pub(super) exits: &'a Exits,
    pub(super) guarded: &'a [Guarded],
    /// The statement behind which the guard stands, if that is not the head of the loop.
    pub(super) behind: Option<Span>,
}

impl Effects<'_> {
    /// What else changes when the law runs at another time.
    pub(super) fn effect_of(&self, own: &Guarded) -> Option<Reason> {
        let program = self.of.program;
        let dropped = if self.is_last() { Some(self.dropped_before(own)?) } else { None };
        let when = dropped.map_or("at the end of the cycle".to_owned(), |name| format!("after `{name}` is dropped"));
        let effect = own.laws().into_iter().find_map(|law| Some((law, side_effect(self.loops, law)?)));
        let text = if let Some((law, effect)) = effect {
            let law = &program.index.function(law).name;
            format!("`{law}` of `{}` {effect}, which then happens {when}", own.spelled)
        } else {
            // Which filter a parameter or an object is, only its caller knows.
            let is_any = own.filter.has_part(&mut |part| matches!(part, Ty::Param(_) | Ty::Opaque(_)));
            let of_impls = || is_any.then(|| shared_by_owner(program.index, &own.laws())).flatten();
            let part = shared_part(program.index, &own.filter).or_else(of_impls)?;
            if !is_any && !own.laws().into_iter().any(|law| touches_shared(self.loops, law)) {
                return None;
            }
            let other = dropped.map_or("the rest of the iteration".to_owned(), |name| format!("dropping `{name}`"));
            format!("`{}` holds {part}, so that its law may meet what {other} does there", own.spelled)
        };
        let span = self.of.span(own.sites.first().map_or(own.at, |site| site.call));
        Some(Reason { span, text })
    }

    /// A variable of the iteration that is dropped before its guard is, and does something then.
    fn dropped_before(&self, own: &Guarded) -> Option<&str> {
        let of = self.of;
        let is_before = |stmt: &&Stmt| {
            self.behind.is_none_or(|behind| stmt.span.start > behind.start)
                && own.sites.iter().any(|site| stmt.span.end <= of.span(site.call).start)
        };
        let around = own.sites.iter().flat_map(|site| of.ancestors_inside(site.call));
        let blocks = around.filter_map(|at| if let ExprKind::Block(block) = of.kind(at) { Some(block) } else { None });
        let bound = blocks.flat_map(|block| &block.stmts).filter(is_before).filter_map(|stmt| match &stmt.kind {
            StmtKind::Let { pat, .. } => Some(of.body.pat(*pat).span),
            StmtKind::Expr { .. } => None,
        });
        let bound: Vec<Span> = bound.collect();
        let mut locals = of.typed.locals.iter().filter(|local| bound.iter().any(|pat| pat.contains(local.span)));
        let found = locals.find(|local| !local.by_ref && acts_when_dropped(of.program.index, &local.ty));
        found.map(|local| local.name.as_str())
    }

    /// Whether nothing runs behind the updates today, so that the laws keep their time and their order.
    fn is_last(&self) -> bool {
        let one = |own: &Guarded| matches!(own.sites.as_slice(), [site] if site.part == Part::Whole);
        self.exits.left_at.is_empty()
            && self.exits.unread.is_empty()
            && self.guarded.iter().all(|own| one(own) && !self.has_rest(own))
    }

    /// Whether more than other updates may run in an iteration once a filter is updated, or part of it.
    fn is_followed(&self, own: &Guarded) -> bool {
        let is_repeated = |at: ExprId| self.of.kind(at).may_repeat();
        let is_one = |site: &Site| site.part == Part::Whole && !self.of.ancestors_inside(site.call).any(is_repeated);
        // The laws keep their order where each has one place.
        let is_ordered = own.sites.len() == 1 || self.guarded.len() == 1;
        !self.exits.unread.is_empty() || !is_ordered || !own.sites.iter().all(is_one) || self.has_rest(own)
    }

    /// Whether anything that stays may run behind the updates of a filter.
    fn has_rest(&self, own: &Guarded) -> bool {
        let of = self.of;
        let gone: BTreeSet<ExprId> = self.guarded.iter().flat_map(|own| &own.sites).map(|site| site.outer).collect();
        let is_gone = |id: ExprId| gone.contains(&id) || of.ancestors_inside(id).any(|at| gone.contains(&at));
        let is_block = |id: ExprId| matches!(of.kind(id), ExprKind::Block(_));
        let follows = |id: &ExprId| own.sites.iter().any(|site| of.may_follow(site.outer, *id));
        of.inside.iter().any(|id| !is_block(*id) && !is_gone(*id) && follows(id))
    }

    /// What is otherwise where an iteration panics: what changes if somebody catches that, and what is only told.
    pub(super) fn panics_of(&self, own: &Guarded) -> (Vec<Reason>, Vec<String>) {
        let of = self.of;
        let is_fed = own.adaptation.as_ref().is_some_and(|adaptation| adaptation.is_fed);
        let is_thread_outlived = self.loops.are_threads_outlived(of.function) && may_run_in_thread(of);
        let is_caught = of.are_panics_caught || is_thread_outlived && outlives_panic(of, own);
        let who = match of.are_panics_caught {
            true => "the program catches panics",
            false => "others go on where its thread has panicked",
        };
        let line = |at: ExprId| of.program.sources.line(of.span(at));
        let changed =
            |(at, text): (ExprId, String), who: &str| Reason { span: of.span(at), text: format!("{text}, and {who}") };
        let told = |(at, text): (ExprId, String)| format!("{text} (line {})", line(at));
        let which = |is_seen: bool| if is_seen { Panics::Seen } else { Panics::OnPurpose };
        let mut changes = Vec::new();
        let mut notes = Vec::new();
        // What the rest of the iteration does is seen by who goes on, whether the filter is there then or not.
        let goes_on = of.are_panics_caught || is_thread_outlived;
        let site = own.sites.first();
        let fails = |law: &FunctionId| may_panic(self.loops, *law, which(goes_on));
        let failing = match own.sites.iter().find(|site| site.is_unwrapped()) {
            Some(site) => Some((
                site.call,
                format!("the result of `{}` of `{}` is unwrapped and panics", site.method, own.spelled),
            )),
            None => own.laws().into_iter().find(fails).map(|law| {
                let law = &of.program.index.function(law).name;
                (site.map_or(own.at, |site| site.call), format!("`{law}` of `{}` panics", own.spelled))
            }),
        };
        if let Some((at, what)) = failing {
            // A lock that is dropped by a panic is poisoned, and one that was dropped before it is not.
            let dropped = || self.dropped_before(own).filter(|_| goes_on).map(|name| format!("`{name}` was dropped"));
            let rest = self.is_followed(own).then(|| "the rest of the iteration has run".to_owned());
            if let Some(rest) = rest.or_else(dropped) {
                let found = (at, format!("where {what}, {rest}"));
                if goes_on { changes.push(changed(found, who)) } else { notes.push(told(found)) }
            }
        }
        // Without its input, no law runs.
        let is_before = |id: &&ExprId| {
            // Who goes on sees what a closure panics of, wherever it is called.
            let is_later = |at: &ExprId| !is_caught && matches!(of.kind(*at), ExprKind::Closure(_));
            own.sites.iter().any(|site| of.may_follow(**id, site.call))
                && !of.ancestors_inside(**id).any(|at| is_later(&at))
        };
        // Above the guard, nothing runs it.
        let is_above = |id: ExprId| self.behind.is_some_and(|before| of.span(id).end <= before.end);
        let fails_when_dropped = |id: ExprId| {
            is_caught && !self.outlives_updates(own, id) && panics_when_dropped(self.loops, of.function, id)
        };
        let fails = |id: ExprId| panics(self.loops, of.function, id, which(is_caught)) || fails_when_dropped(id);
        let first = of.inside.iter().filter(|id| !is_fed && !is_above(**id)).filter(is_before).filter(|id| fails(**id));
        if let Some(first) = first.min_by_key(|id| of.span(**id)) {
            let found = (*first, format!("the law of `{}` runs as well where the iteration panics", own.spelled));
            if is_caught { changes.push(changed(found, who)) } else { notes.push(told(found)) }
        }
        if is_caught {
            return (changes, notes);
        }
        match self.second_panic(own, &is_above) {
            Some(second) if self.loops.are_panics_expected(of.function) => {
                changes.push(changed(second, "tests expect panics"));
            }
            second => notes.extend(second.map(told)),
        }
        (changes, notes)
    }

    /// Whether a value is that of a variable which is there until the filter is updated.
    fn outlives_updates(&self, own: &Guarded, value: ExprId) -> bool {
        let of = self.of;
        let Some(block) = of.parent(value) else { return false };
        let ExprKind::Block(inner) = of.kind(block) else { return false };
        let binds = |stmt: &Stmt| match &stmt.kind {
            StmtKind::Let { pat, init: Some(init), .. } => {
                *init == value && matches!(of.body.pat(*pat).kind, PatKind::Bind { .. })
            }
            _ => false,
        };
        let is_around = |site: &Site| of.ancestors(site.call).any(|at| at == block);
        inner.stmts.iter().any(binds) && own.sites.iter().all(is_around)
    }

    /// Where an iteration may panic whose guard then runs a law that may panic as well, which ends the program.
    fn second_panic(&self, own: &Guarded, is_above: &dyn Fn(ExprId) -> bool) -> Option<(ExprId, String)> {
        let of = self.of;
        let law = own.laws().into_iter().find(|law| may_panic(self.loops, *law, Panics::Any))?;
        let calls: Vec<Span> = own.sites.iter().map(|site| of.span(site.call)).collect();
        let is_another = |id: &&ExprId| {
            !is_above(**id)
                && !calls.iter().any(|call| call.contains(of.span(**id)))
                && panics(self.loops, of.function, **id, Panics::Any)
        };
        let first = of.inside.iter().filter(is_another).min_by_key(|id| of.span(**id))?;
        let law = &of.program.index.function(law).name;
        let spelled = &own.spelled;
        Some((
            *first,
            format!(
                "where the iteration panics, `{law}` of `{spelled}` runs as well, and may panic a second time, which ends the program"
            ),
        ))
    }
}

/// Whether a loop may run in a thread other than that of `main`.
fn may_run_in_thread(of: &LoopBody<'_>) -> bool {
    let is_closure = |at: ExprId| matches!(of.kind(at), ExprKind::Closure(_));
    of.program.index.function(of.function).name != "main" || of.ancestors(of.whole).any(is_closure)
}
