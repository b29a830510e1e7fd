//! The ways out of the loop that come before an update: a guard runs the law on them as well.

use std::collections::BTreeSet;

use super::Reason;
use super::effects::Effects;
use super::mentions::Guarded;
use super::observed::{is_dropped_at, is_observed, outlives_future, read_later};
use super::panics::fails_anew;
use super::sites::Site;
use super::text::has_word;
use crate::syntax::tree::ExprId;

impl Effects<'_> {
    /// What changes where the loop is left before the update, and what nobody can see.
    pub(super) fn left_before(&self, own: &Guarded) -> (Vec<Reason>, Vec<String>) {
        let of = self.of;
        // Without its input, no law runs.
        let is_fed = own.adaptation.as_ref().is_some_and(|adaptation| adaptation.is_fed);
        let halves: BTreeSet<usize> =
            own.sites.iter().map(|site| site.half).filter(|half| !own.rare.contains(half)).collect();
        if is_fed && halves.len() < 2 {
            return (Vec::new(), Vec::new());
        }
        let covers = |site: &Site, exit: ExprId| {
            let block = of.parent(site.done());
            of.span(site.done()).end <= of.span(exit).start && of.ancestors(exit).any(|at| Some(at) == block)
        };
        let is_covered = |exit: &ExprId| {
            let has_run = |half: &usize| own.sites.iter().any(|site| site.half == *half && covers(site, *exit));
            let is_before = || own.sites.iter().all(|site| !of.may_follow(site.done(), *exit));
            halves.iter().all(has_run) || is_fed && is_before()
        };
        // What is left above the guard is left without it.
        let is_above = |exit: &ExprId| self.behind.is_some_and(|before| of.span(*exit).end <= before.end);
        let opaque = self.exits.unread.iter().filter(|id| {
            let text = of.written(**id);
            text.contains('?') || ["return", "break", "continue"].iter().any(|word| has_word(text, word))
        });
        // What nobody sees still has to come to its end.
        let failing = if is_fed { None } else { fails_anew(self.loops, own) };
        let outlives = outlives_future(of, own);
        let waits = self.exits.waits.iter().filter(|_| outlives || failing.is_some());
        let early: Vec<ExprId> = self
            .exits
            .left_at
            .iter()
            .chain(waits)
            .chain(opaque)
            .copied()
            .filter(|exit| !is_covered(exit) && !is_above(exit))
            .collect();
        if early.is_empty() {
            return (Vec::new(), Vec::new());
        }
        let line = |id: &ExprId| of.program.sources.line(of.span(*id));
        let what = if of.is_function { "function" } else { "loop" };
        let is_observed = is_observed(of, own);
        let is_seen = |exit: &ExprId| {
            let is_wait = self.exits.waits.contains(exit);
            if is_wait { outlives } else { is_observed && !is_dropped_at(of, own, *exit) }
        };
        let (early, unseen): (Vec<ExprId>, Vec<ExprId>) =
            early.into_iter().partition(|exit| failing.is_some() || is_seen(exit));
        if !early.is_empty() {
            let spelled = &own.spelled;
            let left = |exit: &ExprId| {
                let how = match self.exits.waits.contains(exit) {
                    true => "the future may be dropped here".to_owned(),
                    false => format!("the {what} may be left here"),
                };
                let then = match (is_fed, failing.filter(|_| !is_seen(exit))) {
                    (true, _) => {
                        format!("between the calls of the law of `{spelled}`; the guard runs all of them or none")
                    }
                    (false, None) => {
                        format!("before `{spelled}` is updated; the guard updates it on this way as well")
                    }
                    (false, Some(law)) => {
                        let law = &of.program.index.function(law).name;
                        format!(
                            "before `{spelled}` is updated; with the guard, `{law}` runs on this way as well, and may panic or not \
                             come to its end"
                        )
                    }
                };
                let later = read_later(of, own).filter(|_| is_seen(exit));
                let advice = match later.map(|span| of.program.sources.line(span)) {
                    Some(line) => format!(", or give line {line} what it reads of `{spelled}` in another variable"),
                    None => String::new(),
                };
                let text = format!("{how} {then}: leave it before it does anything with `{spelled}`{advice}");
                Reason { span: of.span(*exit), text }
            };
            return (early.iter().map(left).collect(), Vec::new());
        }
        let lines: BTreeSet<String> = unseen.iter().map(|id| line(id).to_string()).collect();
        let lines = lines.into_iter().collect::<Vec<_>>().join(", ");
        let once = if is_fed { "all or not at all" } else { "once more" };
        let note = format!(
            "the law of `{}` runs {once} where the {what} is left (line {lines}); nothing reads it after that",
            own.name
        );
        (Vec::new(), vec![note])
    }
}
