//! From the cycles of an analysis to a plan for each loop that updates filters by hand.

use std::path::Path;

use super::adapt::is_not_mutable;
use super::ambiguous::{ambiguous, calls_that_go};
use super::body::LoopBody;
use super::called::called;
use super::captures::captures;
use super::conditional::unread;
use super::each::is_vec;
use super::effects::Effects;
use super::exits::{Exits, ends_before, exits, is_exact};
use super::gone::Gone;
use super::head::CycleRate;
use super::holding::guarded;
use super::iteration::{Inner, inner_loop};
use super::law::delegation;
use super::leftover::{idle_muts, leftovers};
use super::loops::Loops;
use super::lost::lost_comment;
use super::mentions::{Guarded, Mention, given_to_macro, mentions};
use super::not_shipped::not_shipped;
use super::owned::is_owned;
use super::partly::{is_left, partly, why_left};
use super::present::Present;
use super::sites::{Site, owed, place_of, sites};
use super::tails::{outlives_owner, semicolon, without_name};
use super::text::join_insertions;
use super::twice::used_twice;
use super::whole::{of_a_closure, plan_of_a_law, whole_function, whole_loop};
use super::worded::{Worded, worded};
use super::{Plan, Reason, Rewrite, core_items, head};
use crate::count::{Cycle, CycleKind, Pair, Verdict};
use crate::flow::Program;
use crate::index::{FunctionId, Ty};
use crate::project::Manners;
use crate::source::Span;
use crate::syntax::tree::{ExprId, ExprKind, PatId, PatKind};

/// A plan for each cycle that updates filters by hand; none where nothing is to be done. `manners` says what is asked of the code in a
/// file.
#[must_use]
pub fn plans<'c>(
    program: &Program<'_>,
    cycles: impl Iterator<Item = &'c Cycle>,
    edition: impl Fn(&Cycle) -> String,
    manners: &dyn Fn(&Path) -> Manners,
) -> Vec<Plan> {
    let mut cycles = cycles.peekable();
    if cycles.peek().is_none() {
        return Vec::new();
    }
    let loops = Loops::of(program, manners);
    cycles.filter_map(|cycle| plan(&loops, cycle, &edition)).collect()
}

fn plan(loops: &Loops<'_>, cycle: &Cycle, edition_of: &dyn Fn(&Cycle) -> String) -> Option<Plan> {
    let edition = &*edition_of(cycle);
    // A law for guards that hands on to the law that was there is where a migration ends.
    let hands_on = loops.at(cycle.head).is_some_and(|(law, ..)| loops.program.index.is_run_by_guards(law));
    let is_own = |pair: &Pair| hands_on && pair.name == "self";
    let of = LoopBody::find(loops, cycle.head);
    let is_sampled_here = |pair: &Pair| pair.verdict == Verdict::PerSample && is_in_its_loop(of.as_ref(), pair);
    let ends_before = |pair: &Pair| of.as_ref().is_some_and(|of| ends_before(of, pair));
    let is_by_hand = |pair: &&Pair| (!is_left(pair) || is_sampled_here(pair) || ends_before(pair)) && !is_own(pair);
    let by_hand: Vec<&Pair> = cycle.filters.iter().filter(is_by_hand).collect();
    if by_hand.is_empty() {
        return of.filter(|_| !hands_on).and_then(|of| plan_of_a_law(&of, cycle));
    }
    let within = called(loops, cycle, &by_hand);
    let outcome = match cycle.kind {
        _ if let Some(function) = &within => in_function(loops, function, &edition_of(function)),
        CycleKind::Closure => Err(vec![Reason { span: cycle.head, text: of_a_closure(loops.program, cycle) }]),
        CycleKind::Function | CycleKind::Loop | CycleKind::While | CycleKind::For => {
            rewrite(loops, cycle, &by_hand, edition)
        }
    };
    let mut filters: Vec<String> = by_hand.iter().map(|pair| pair.name.clone()).collect();
    // A law of several halves has a pair for each.
    filters.dedup();
    if outcome.is_ok() {
        // The law of a filter that is made of others runs theirs.
        let all = filters.clone();
        let is_part =
            |name: &str, of: &String| name.strip_prefix(of.as_str()).is_some_and(|rest| rest.starts_with('.'));
        filters.retain(|name| !all.iter().any(|other| is_part(name, other)));
    }
    let whole = loops.at(cycle.head).and_then(|(function, whole, _)| {
        let body = loops.program.index.function(function).function.body.as_ref()?;
        Some(body.expr(whole).span.to(cycle.head))
    });
    let whole = whole.unwrap_or(cycle.head);
    let partly = match outcome.as_ref() {
        Ok(rewrite) if rewrite.changes.is_empty() => None,
        _ if within.is_some() => None,
        _ => partly(cycle, &by_hand, |pairs| rewrite(loops, cycle, pairs, edition)),
    };
    let is_able = outcome.is_ok() || partly.is_some();
    let is_helper = is_able && cycle.is_presumed && by_hand.iter().all(|pair| is_lent(loops, cycle, pair));
    let is_missed = |pair: &&&Pair| pair.verdict == Verdict::Missed && pair.updates.is_empty();
    let missed = by_hand.iter().filter(is_missed).map(|pair| pair.name.clone()).collect();
    Some(Plan {
        head: cycle.head,
        whole,
        function: cycle.function.clone(),
        is_helper,
        filters,
        missed,
        outcome,
        partly,
    })
}

/// Whether a filter of a function is lent to it by a parameter other than `self`.
fn is_lent(loops: &Loops<'_>, cycle: &Cycle, pair: &Pair) -> bool {
    let base = pair.name.split(['.', '[', '(']).next().unwrap_or_default();
    let Some((function, ..)) = loops.at(cycle.head) else { return false };
    let Some(body) = &loops.program.index.function(function).function.body else { return false };
    let is_named = |pat: &PatId| matches!(&body.pat(*pat).kind, PatKind::Bind { name, .. } if name == base);
    base != "self" && body.params.iter().any(is_named)
}

/// The rewriting of a function that a loop calls in each iteration.
fn in_function(loops: &Loops<'_>, cycle: &Cycle, edition: &str) -> Result<Rewrite, Vec<Reason>> {
    let filters: Vec<&Pair> = cycle.filters.iter().collect();
    let mut rewrite = rewrite(loops, cycle, &filters, edition)?;
    rewrite.notes.insert(0, format!("the guard stands in `{}`, which the loop calls", cycle.function));
    Ok(rewrite)
}

/// Whether the loop of the samples is the cycle itself: each of its iterations updates the filter.
fn is_in_its_loop(of: Option<&LoopBody<'_>>, pair: &Pair) -> bool {
    let Some(of) = of.filter(|of| !of.is_function && pair.counts == [1]) else { return false };
    let is_repeated = |at: ExprId| of.kind(at).may_repeat();
    let is_alone = pair.updates.iter().all(|update| {
        let call = of.inside.iter().find(|id| of.span(**id) == *update);
        call.is_some_and(|call| !of.ancestors_inside(*call).any(is_repeated))
    });
    // An inner loop that goes over the filters updates each of them once.
    let is_of_each = || sites(of, pair).is_ok_and(|sites| sites.iter().all(|site| site.inner.is_some()));
    is_alone || !pair.updates.is_empty() && is_of_each()
}

fn rewrite(loops: &Loops<'_>, cycle: &Cycle, by_hand: &[&Pair], edition: &str) -> Result<Rewrite, Vec<Reason>> {
    let at_head = |text: String| vec![Reason { span: cycle.head, text }];
    let Some(of) = LoopBody::find(loops, cycle.head) else {
        return Err(at_head("the cycle is not written where it runs".to_owned()));
    };
    if of.is_function {
        whole_function(&of).map_err(at_head)?;
    }
    whole_loop(&of, &loops.outline(of.file()), edition).map_err(at_head)?;
    let present = Present::of(&of).map_err(at_head)?;
    let what = if of.is_function { "function" } else { "loop" };
    let mut reasons = Vec::new();
    let mut changes = Vec::new();
    let mut found = Vec::new();
    for pair in by_hand {
        let span = pair.primary.unwrap_or(cycle.head);
        let verdict = pair.verdict.name();
        match pair.verdict {
            Verdict::Unproved => {
                let cause = pair.cause.clone().unwrap_or_default();
                let text = format!("nobody can tell how often `{}` is updated: {cause}", pair.name);
                reasons.push(Reason { span, text });
                continue;
            }
            _ if is_exact(&of, pair) => {}
            _ => {
                let text = format!("`{}` is {verdict} today; the guard updates it exactly once", pair.name);
                changes.push(Reason { span, text });
            }
        }
        let is_half =
            |pair: &Pair| cycle.filters.iter().any(|other| other.name == pair.name && other.half != pair.half);
        match sites(&of, pair) {
            Ok(sites) if sites.is_empty() && is_half(pair) => {
                let text = format!(
                    "`{}` is a half of the law of `{}`, and the {what} does not tell where it would run: call it there, and migrate then",
                    pair.law, pair.name
                );
                reasons.push(Reason { span, text });
            }
            Ok(sites) => {
                match sites.first().map(|site| (site.place.clone(), site.at, site.law)).or_else(|| owed(&of, pair)) {
                    Some(place) => found.push((*pair, place, sites)),
                    None => {
                        let text = format!(
                            "`{}` is {verdict}, and the {what} does not tell what a guard would hold: update it where its law belongs, \
                             and migrate then",
                            pair.name
                        );
                        reasons.push(Reason { span, text });
                    }
                }
            }
            Err(reason) => reasons.push(reason),
        }
    }
    if !reasons.is_empty() {
        return Err(reasons);
    }
    let guarded = guarded(loops, &of, found)?;
    if let Some(span) = unread(&of, by_hand, &guarded) {
        let text = "what is compiled under this condition may have to do with the filters, and is not read in full: migrate the \
                    loop by hand";
        return Err(vec![Reason { span, text: text.to_owned() }]);
    }
    if edition == "2018"
        && let reasons = captures(&of, &guarded)
        && !reasons.is_empty()
    {
        return Err(reasons);
    }
    if let Some(reason) = outlives_owner(&of, &guarded, edition) {
        return Err(vec![reason]);
    }
    if let Some(reason) = not_shipped(&of, cycle, &guarded) {
        return Err(vec![reason]);
    }
    let exits = exits(&of);
    let is_exact = by_hand.iter().all(|pair| is_exact(&of, pair));
    let behind = match &present {
        Some(present) => present
            .admits(&of, &guarded, &exits, is_exact)
            .map(|()| Some(present.stmt))
            .map_err(|reason| vec![reason])?,
        None => head::behind(loops, &of, &guarded, &exits, is_exact),
    };
    let rewriter = Rewriter { loops, of: &of, exits, guarded: &guarded, behind, present, edition };
    rewriter.rewrite(cycle, changes)
}

struct Rewriter<'a> {
    loops: &'a Loops<'a>,
    of: &'a LoopBody<'a>,
    exits: Exits,
    guarded: &'a [Guarded],
    /// The statement behind which the guard stands, if that is not the head of the loop.
    behind: Option<Span>,
    /// The guard that the loop has already.
    present: Option<Present>,
    edition: &'a str,
}

impl Rewriter<'_> {
    fn rewrite(&self, cycle: &Cycle, mut changes: Vec<Reason>) -> Result<Rewrite, Vec<Reason>> {
        let of = self.of;
        let program = of.program;
        let mut reasons = self.unread();
        let mut edits = Vec::new();
        let mut targets = self.loops.targets_with(of.file());
        let mut notes = Vec::new();
        let mut laws: Vec<(Ty, FunctionId)> = Vec::new();
        let effects = Effects { loops: self.loops, of, exits: &self.exits, guarded: self.guarded, behind: self.behind };
        for (at, own) in self.guarded.iter().enumerate() {
            match mentions(of, self.guarded, at, self.behind) {
                Ok(found) => {
                    reasons.extend(found.iter().find_map(|mention| given_to_macro(self.loops, of, own, mention)));
                    for Worded { reason, is_change } in
                        found.iter().filter_map(|mention| worded(self.loops, of, own, mention))
                    {
                        if is_change {
                            changes.push(reason);
                        } else {
                            notes.push(format!("{} (line {})", reason.text, program.sources.line(reason.span)));
                        }
                    }
                    edits
                        .extend(found.iter().flat_map(|mention| mention.edit.iter().chain(&mention.elements).cloned()));
                    changes.extend(self.used_after(own, &found));
                    reasons.extend(found.iter().find_map(|mention| self.carried_out(own, mention)));
                    reasons.extend(used_twice(of, own, &found));
                }
                Err(reason) => reasons.push(reason),
            }
            let (observed, unobserved) = effects.left_before(own);
            changes.extend(observed);
            notes.extend(unobserved);
            changes.extend(self.left_out(own));
            changes.extend(effects.effect_of(own));
            let (changed, noted) = effects.panics_of(own);
            changes.extend(changed);
            notes.extend(noted);
            reasons.extend(is_not_mutable(of, own));
            if let Some(adaptation) = &own.adaptation {
                edits.extend(adaptation.edits.iter().cloned());
                changes.extend(adaptation.changes.iter().cloned());
                notes.push(adaptation.note.clone());
                continue;
            }
            let Some(law) = own.law else { continue };
            if let filter @ Ty::Adt(..) = &own.filter {
                if laws.iter().any(|(other, with)| other.may_be(filter) && *with != law) {
                    let text =
                        format!("`{}` is updated by another law than a filter of its type before it", own.spelled);
                    reasons.push(Reason { span: of.span(own.at), text });
                }
                laws.push((filter.clone(), law));
            }
            match delegation(self.loops, &own.filter, law) {
                Ok(None) => {}
                Ok(Some(new)) => {
                    reasons.extend(ambiguous(self.loops, of, &calls_that_go(self.guarded), law));
                    targets.extend(self.loops.targets_with(new.span.file));
                    edits.push((new.span, new.text));
                }
                Err(text) => reasons.push(Reason { span: of.span(own.at), text }),
            }
        }
        let has_own_line = self.present.is_none() && head::own_line(of, self.behind).is_some();
        let gone = Gone::of(of, self.guarded, has_own_line);
        gone.take_away(&mut edits);
        edits.extend(semicolon(of, self.guarded, self.edition));
        if let Some((head, rest)) = without_name(of, self.guarded, self.edition) {
            let (name, line) = (program.sources.snippet(head), program.sources.line(head));
            let name = name.trim_start_matches("let").trim_end().trim_end_matches('=').trim();
            notes
                .push(format!("the name `{name}` goes with the update, and its value stands at the end (line {line})"));
            edits.retain(|(span, _)| !rest.contains(*span));
            edits.extend([(head, String::new()), (rest, String::new())]);
        }
        match idle_muts(of, self.guarded) {
            Ok(found) => edits.extend(found.into_iter().map(|span| (span, String::new()))),
            Err(reason) => reasons.push(reason),
        }
        for left in leftovers(self.loops, of, self.guarded) {
            if let Some(renamed) = left.edit() {
                notes.push(format!("`{0}` has no use any more, and is called `_{0}`", left.name));
                edits.push(renamed);
            } else if self.loops.are_unused_names_denied(of.file()) {
                reasons.push(left.refusal());
            } else {
                notes.push(format!("`{}` has no use any more", left.name));
            }
        }
        let rate = CycleRate::of(of, cycle.period);
        match head::lines(of, self.guarded, self.behind, self.present.as_ref(), gone.comments(), &rate) {
            Ok(head) => edits.extend(head),
            Err(reason) => reasons.push(reason),
        }
        edits.sort();
        edits.dedup();
        if reasons.is_empty() {
            reasons.extend(lost_comment(of, &edits));
        }
        if !reasons.is_empty() {
            reasons.sort_by_key(|reason| reason.span);
            reasons.dedup();
            return Err(reasons);
        }
        changes.sort_by_key(|reason| reason.span);
        changes.dedup();
        join_insertions(&mut edits);
        let order: Vec<String> = self.guarded.iter().map(|own| format!("`{}`", own.name)).collect();
        let others = if self.present.is_some() { ", before those that the guard has already" } else { "" };
        notes.insert(
            0,
            match order.as_slice() {
                [one] => format!("the law of {one} runs at the end of the cycle{others}"),
                all => format!("the laws run at the end of the cycle, in this order{others}: {}", all.join(", ")),
            },
        );
        notes.extend(rate.note.filter(|_| self.present.is_none()));
        let is_guarded = |pair: &Pair| {
            let is_its_site = |own: &Guarded| own.sites.iter().any(|site| pair.updates.contains(&of.span(site.call)));
            pair.verdict == Verdict::Guarded || self.guarded.iter().any(is_its_site)
        };
        for pair in cycle.filters.iter().filter(|pair| is_left(pair) && !is_guarded(pair)) {
            let has_halves = cycle.filters.iter().any(|other| other.name == pair.name && other.half != pair.half);
            let half = if has_halves { format!("`{}` of ", pair.law) } else { String::new() };
            notes.push(format!("{half}`{}` stays as it is: {}", pair.name, why_left(pair.verdict)));
        }
        let is_lent_in_vec = |own: &Guarded| {
            let each = own.adaptation.as_ref().and_then(|adaptation| adaptation.law.each.as_ref());
            each.is_some_and(|each| each.is_vec)
        };
        let needs_alloc = self.guarded.iter().any(|own| is_vec(&own.ty) || is_lent_in_vec(own));
        let written = laws.iter().map(|(_, law)| *law);
        let is_dependency =
            written.chain([of.function]).all(|function| core_items::has_ceid_core(program.index, function));
        Ok(Rewrite { edits, laws, targets, is_dependency, needs_alloc, changes, notes })
    }

    /// Code that nobody has read and that names something that the guard holds.
    fn unread(&self) -> Vec<Reason> {
        let mut reasons = Vec::new();
        for id in &self.exits.unread {
            let (mentioned, what) = match self.of.kind(*id) {
                ExprKind::Opaque(call) => (&call.mentions, format!("the macro `{}!`", call.path)),
                ExprKind::Unknown { what, mentions } => (mentions, what.clone()),
                _ => continue,
            };
            let name = |own: &Guarded| self.of.typed.local(own.place.local).name.clone();
            if let Some(own) = self.guarded.iter().find(|own| mentioned.contains(&name(own))) {
                let text = format!("{what} may do anything with `{}`", own.spelled);
                reasons.push(Reason { span: self.of.span(*id), text });
            }
        }
        reasons
    }

    /// Where the state of a filter is used behind its update in the same iteration.
    fn used_after(&self, own: &Guarded, mentions: &[Mention]) -> Vec<Reason> {
        let of = self.of;
        let mut found = Vec::new();
        for site in &own.sites {
            for mention in mentions {
                let is_header = site.inner.is_some_and(|inner| self.is_iterable_of(mention.at, inner));
                let is_same_element = site.inner.is_some_and(|inner| self.is_element_of(mention.at, site, inner));
                let is_among = site.inner.is_some_and(|inner| of.ancestors_inside(mention.at).any(|at| at == inner));
                if of.may_follow(site.done(), mention.at) || is_among && !is_header && !is_same_element {
                    found.push(self.stale(own, mention.at));
                }
            }
            // The elements have names of their own in the inner loop.
            if let (Some(inner), false) = (site.inner, Some(site.gone) == site.inner)
                && let Some(place) = place_of(of, site.receiver)
            {
                let is_gone = |at: &ExprId| own.sites.iter().any(|site| site.gone == *at);
                let names = of.names(place.local).filter(|at| !is_gone(at));
                let names = names.filter(|at| of.ancestors_inside(*at).any(|at| at == inner));
                found.extend(names.filter(|at| of.may_follow(site.gone, *at)).map(|at| self.stale(own, at)));
            }
        }
        found
    }

    fn stale(&self, own: &Guarded, at: ExprId) -> Reason {
        let text = format!(
            "`{}` is used here after its update in the same iteration; with the guard, its law runs only after that",
            own.spelled
        );
        Reason { span: self.of.span(at), text }
    }

    fn is_iterable_of(&self, at: ExprId, inner: ExprId) -> bool {
        let Some(Inner { iterable, .. }) = inner_loop(self.of, inner) else { return false };
        std::iter::once(at).chain(self.of.ancestors_inside(at)).any(|around| around == iterable)
    }

    /// Whether a place is indexed by the same variable as the updated element.
    fn is_element_of(&self, at: ExprId, site: &Site, inner: ExprId) -> bool {
        let index_of = |id: ExprId| match self.of.kind(id) {
            ExprKind::Index { index, .. } => self.of.typed.expr_local.get(index).copied(),
            _ => None,
        };
        let own = self.of.parent(at).and_then(index_of);
        own.is_some() && own == index_of(site.receiver) && self.of.ancestors_inside(at).any(|around| around == inner)
    }

    /// A value that leaves the loop and may be a part of what the guard holds.
    fn carried_out(&self, own: &Guarded, mention: &Mention) -> Option<Reason> {
        let of = self.of;
        let tail = match of.kind(of.block) {
            ExprKind::Block(block) if of.is_function => block.tail,
            _ => None,
        };
        let leaves = |at: ExprId| match of.kind(at) {
            ExprKind::Break { value, .. } | ExprKind::Return(value) => *value,
            _ => (Some(at) == tail).then_some(at),
        };
        let value = std::iter::once(mention.at).chain(of.ancestors_inside(mention.at)).find_map(leaves)?;
        let index = of.program.index;
        let text = format!(
            "what leaves the loop here may borrow from `{}`, which the guard has up to there: let it be a copy, or look it up behind \
             the loop",
            own.spelled
        );
        (!is_owned(index, &index.scope_of(of.function), of.typed.ty(value)))
            .then(|| Reason { span: of.span(value), text })
    }

    /// What the law allows to leave out, and a guard would not.
    fn left_out(&self, own: &Guarded) -> Option<Reason> {
        let is_kept = |site: &&Site| site.inputs.is_empty() && own.rare.contains(&site.half) && own.deviates.is_none();
        let site = own.sites.iter().find(is_kept)?;
        let text = format!(
            "some iterations leave out `{}` of `{}`; with the guard, it runs in each",
            site.method, own.spelled
        );
        Some(Reason { span: self.of.span(site.call), text })
    }
}
