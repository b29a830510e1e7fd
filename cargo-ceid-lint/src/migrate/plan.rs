//! From the cycles of an analysis to a plan for each loop that updates filters by hand.

use std::collections::{BTreeMap, BTreeSet};

use super::body::LoopBody;
use super::exits::{Exits, exits};
use super::law::{ceid_core_name, delegation};
use super::mentions::{Guarded, Mention, held, mentions};
use super::sites::{Part, Place, Site, place_of, sites};
use super::text::{above, begins_line, has_word, indentation, indentation_step, line_end, line_stop, removal, words};
use super::{Plan, Reason, Rewrite, observed, purity};
use crate::count::{Cycle, CycleKind, Pair, Verdict};
use crate::flow::Program;
use crate::index::Ty;
use crate::source::Span;
use crate::syntax::enclosures;
use crate::syntax::tree::{ExprId, ExprKind, MacroKind};

/// The rate that stands in the rewritten code where the loop does not tell its own.
const UNKNOWN_RATE: u64 = 1000;

/// A plan for each cycle that updates filters by hand; none where nothing is to be done.
#[must_use]
pub fn plans(program: &Program<'_>, cycles: &[Cycle], edition: impl Fn(&Cycle) -> String) -> Vec<Plan> {
    cycles.iter().filter_map(|cycle| plan(program, cycle, &edition(cycle))).collect()
}

fn plan(program: &Program<'_>, cycle: &Cycle, edition: &str) -> Option<Plan> {
    let by_hand: Vec<&Pair> = cycle.filters.iter().filter(|pair| !is_left(pair)).collect();
    if by_hand.is_empty() {
        return None;
    }
    let outcome = match cycle.kind {
        CycleKind::Function | CycleKind::Closure => Err(vec![Reason {
            span: cycle.head,
            text: "the cycle is called by other code: give its owner a `Cyclic` with the filters, and begin with `cycle()`"
                .to_owned(),
        }]),
        CycleKind::Loop | CycleKind::While | CycleKind::For => rewrite(program, cycle, &by_hand, edition),
    };
    let filters = by_hand.iter().map(|pair| pair.name.clone()).collect();
    Some(Plan { head: cycle.head, function: cycle.function.clone(), filters, outcome })
}

/// Whether a guard has the filter already, or could not have it.
fn is_left(pair: &Pair) -> bool {
    matches!(pair.verdict, Verdict::Guarded | Verdict::Gated | Verdict::OnceOrReset | Verdict::PerSample)
}

fn rewrite(program: &Program<'_>, cycle: &Cycle, by_hand: &[&Pair], edition: &str) -> Result<Rewrite, Vec<Reason>> {
    let at_head = |text: String| vec![Reason { span: cycle.head, text }];
    let Some(of) = LoopBody::find(program, cycle.head) else {
        return Err(at_head("the loop is not written where it runs".to_owned()));
    };
    whole_loop(&of, edition).map_err(at_head)?;
    let mut reasons = Vec::new();
    let mut changes = Vec::new();
    let mut found = Vec::new();
    for pair in by_hand {
        match sites(&of, pair) {
            Ok(sites) => found.push((*pair, sites)),
            Err(reason) => reasons.push(reason),
        }
        match pair.verdict {
            Verdict::Once => {}
            Verdict::Repeated | Verdict::Skipped => changes.push(Reason {
                span: pair.primary.unwrap_or(cycle.head),
                text: format!("`{}` is {} today; the guard updates it exactly once", pair.name, pair.verdict.name()),
            }),
            other => reasons.push(Reason {
                span: pair.primary.unwrap_or(cycle.head),
                text: format!("`{}` is {}, and no statement says where it should be updated", pair.name, other.name()),
            }),
        }
    }
    if !reasons.is_empty() {
        return Err(reasons);
    }
    let guarded = guarded(&of, found)?;
    let rewriter = Rewriter { of: &of, exits: exits(&of), guarded: &guarded };
    rewriter.rewrite(cycle, changes)
}

/// Why the loop as a whole cannot be rewritten.
fn whole_loop(of: &LoopBody<'_>, edition: &str) -> Result<(), String> {
    let span = of.span(of.block);
    let code = of.program.sources.snippet(span);
    if edition == "2015" {
        return Err("the crate has edition 2015, in which `ceid_core` has to be declared first".to_owned());
    }
    if !of.program.sources.snippet(span).starts_with('{') || enclosures(of.text, span.start as usize).iter().any(|around| around.is_macro) {
        return Err("the loop is written in a macro".to_owned());
    }
    if code.contains("cfg(") || code.contains("cfg!(") || code.contains("cfg_attr(") {
        return Err("a part of the loop is conditionally compiled, and is not read in full".to_owned());
    }
    let has_guard = |id: &ExprId| match of.kind(*id) {
        ExprKind::Macro(call) => matches!(call.kind, MacroKind::Ceid { .. } | MacroKind::EachCycle { .. }),
        _ => false,
    };
    if of.inside.iter().any(has_guard) {
        return Err("a guard is there already: add the filter to its list, and delete the call of its law".to_owned());
    }
    Ok(())
}

/// The places that the guard is to hold, in the order in which their laws run today.
fn guarded(of: &LoopBody<'_>, found: Vec<(&Pair, Vec<Site>)>) -> Result<Vec<Guarded>, Vec<Reason>> {
    let mut reasons = Vec::new();
    let mut by_place: BTreeMap<Place, Vec<Site>> = BTreeMap::new();
    for (pair, sites) in found {
        if sites.iter().any(|site| site.place != sites[0].place) {
            let text = format!("`{}` is updated under several names", pair.name);
            reasons.push(Reason { span: of.span(sites[0].call), text });
        }
        for site in sites {
            by_place.entry(site.place.clone()).or_default().push(site);
        }
    }
    let mut guarded: Vec<Guarded> = Vec::new();
    for (place, mut sites) in by_place {
        sites.sort_by_key(|site| of.span(site.call));
        let at = sites[0].at;
        let ty = of.typed.ty(at).clone();
        let spelled = spelled(of, &place);
        if let Err(text) = holds(of, &place, &ty, &sites, &spelled) {
            reasons.push(Reason { span: of.span(sites[0].call), text });
        }
        guarded.push(Guarded { place, spelled, name: String::new(), ty, sites });
    }
    let overlap = guarded.iter().any(|one| {
        let is_above = |other: &Guarded| {
            one.place != other.place
                && one.place.local == other.place.local
                && other.place.fields.starts_with(&one.place.fields)
        };
        guarded.iter().any(is_above)
    });
    if overlap {
        reasons.push(Reason { span: of.span(of.whole), text: "one filter of this loop holds another one".to_owned() });
    }
    guarded.sort_by_key(|place| of.span(place.sites[0].call));
    let mut taken = BTreeSet::new();
    for at in 0..guarded.len() {
        match free_name(of, &guarded[at].place, &taken) {
            Some(name) => {
                taken.insert(name.clone());
                guarded[at].name = name;
            }
            None => reasons.push(Reason {
                span: of.span(guarded[at].sites[0].call),
                text: format!("every short name for `{}` means something else in this loop", guarded[at].spelled),
            }),
        }
    }
    if guarded.len() > 16 {
        let text = "the loop has more than 16 filters: declare them with `filters!`".to_owned();
        reasons.push(Reason { span: of.span(of.whole), text });
    }
    if reasons.is_empty() { Ok(guarded) } else { Err(reasons) }
}

fn spelled(of: &LoopBody<'_>, place: &Place) -> String {
    let base = std::iter::once(of.typed.local(place.local).name.as_str());
    base.chain(place.fields.iter().map(String::as_str)).collect::<Vec<_>>().join(".")
}

/// Whether a guard can hold what lies at a place, and whether that is what the loop updates.
fn holds(of: &LoopBody<'_>, place: &Place, ty: &Ty, sites: &[Site], spelled: &str) -> Result<(), String> {
    let local = of.typed.local(place.local);
    if local.span.start > of.span(of.whole).start {
        return Err(format!("`{spelled}` is made anew in each iteration, so that no instance lives outside of the loop"));
    }
    if local.by_ref {
        return Err(format!("`{spelled}` is bound by `ref`"));
    }
    if place.fields.is_empty() && local.name == "self" {
        return Err("the filter is `self`: guard it where the loop is called, or make it a field".to_owned());
    }
    let is_own = sites.iter().all(|site| held(ty).is_some_and(|held| *held == site.filter));
    let known = sites.iter().all(|site| matches!(site.filter, Ty::Adt(..)));
    if !known {
        return Err(match &sites[0].filter {
            Ty::External(path, _) => format!(
                "the type of `{spelled}`, `{path}`, belongs to another crate: wrap it in a type of your own that implements `SampledFilter`"
            ),
            _ => format!("only the trait of `{spelled}` is known, and not its type"),
        });
    }
    if !is_own {
        return Err(format!("`{spelled}` holds its filter in a way that a guard cannot reach through"));
    }
    // The fields on the way have to be plain ones, so that each is borrowed by itself.
    let mut at = sites[0].at;
    while let ExprKind::Field { base, .. } = of.kind(at) {
        let owner = of.typed.ty(*base);
        let owner = match owner {
            Ty::Ref(true, inner) => inner,
            other => other,
        };
        if !matches!(owner, Ty::Adt(..)) {
            return Err(format!("`{}` does not lend its fields one by one", of.written(*base)));
        }
        at = *base;
    }
    let is_collection = held(ty).is_some_and(|inner| !matches!(ty, Ty::Adt(..)) && !is_ref_to(ty, inner));
    let elements: Vec<u64> =
        sites.iter().filter_map(|site| if let Part::Element(at) = site.part { Some(at) } else { None }).collect();
    let all = sites.iter().filter(|site| site.part == Part::All).count();
    let whole = sites.iter().filter(|site| site.part == Part::Whole).count();
    let length = match ty {
        Ty::Array(_, length) => length.value,
        Ty::Ref(_, inner) => match &**inner {
            Ty::Array(_, length) => length.value,
            _ => None,
        },
        _ => None,
    };
    let distinct: BTreeSet<u64> = elements.iter().copied().collect();
    let is_covered = match (elements.len(), all, whole) {
        (0, 1.., 0) => is_collection,
        (_, 0, 0) => is_collection && length == Some(distinct.len() as u64),
        (0, 0, _) => !is_collection,
        _ => false,
    };
    if is_covered { Ok(()) } else { Err(format!("not every element of `{spelled}` is updated here, and a guard updates all")) }
}

fn is_ref_to(ty: &Ty, inner: &Ty) -> bool {
    match ty {
        Ty::Ref(_, own) => **own == *inner,
        Ty::External(path, _) => path == "std::boxed::Box",
        _ => false,
    }
}

/// A name for a place that means nothing else in the loop.
fn free_name(of: &LoopBody<'_>, place: &Place, taken: &BTreeSet<String>) -> Option<String> {
    let local = &of.typed.local(place.local).name;
    if place.fields.is_empty() {
        return (!taken.contains(local)).then(|| local.clone());
    }
    let all: Vec<&str> = std::iter::once(local.as_str()).chain(place.fields.iter().map(String::as_str)).collect();
    let code = of.program.sources.snippet(of.span(of.block));
    let is_name = |name: &str| name.starts_with(|first: char| first.is_alphabetic() || first == '_');
    let is_free = |name: &str| {
        is_name(name)
            && !taken.contains(name)
            && !of.typed.locals.iter().any(|local| local.name == name)
            && words(code, name).all(|at| code[..at].trim_end().ends_with('.'))
    };
    (1..=all.len()).rev().map(|from| all[from - 1..].join("_")).map(|name| name.replace("self_", "own_")).find(|name| is_free(name))
}

struct Rewriter<'a> {
    of: &'a LoopBody<'a>,
    exits: Exits,
    guarded: &'a [Guarded],
}

impl Rewriter<'_> {
    fn rewrite(&self, cycle: &Cycle, mut changes: Vec<Reason>) -> Result<Rewrite, Vec<Reason>> {
        let of = self.of;
        let program = of.program;
        let mut reasons = self.unread();
        let mut edits = Vec::new();
        let mut packages = BTreeSet::from([program.index.crate_of(of.def().module).package]);
        let mut notes = Vec::new();
        for (at, own) in self.guarded.iter().enumerate() {
            match mentions(of, self.guarded, at) {
                Ok(found) => {
                    edits.extend(found.iter().filter_map(|mention| mention.edit.clone()));
                    changes.extend(self.used_after(own, &found));
                    if let Some(reason) = found.iter().find_map(|mention| self.carried_out(own, mention)) {
                        reasons.push(reason);
                    }
                }
                Err(reason) => reasons.push(reason),
            }
            let (observed, unobserved) = self.left_before(own);
            changes.extend(observed);
            notes.extend(unobserved);
            changes.extend(own.sites.iter().filter_map(|site| self.effect_of(own, site)));
            for site in &own.sites {
                match delegation(program, &site.filter, site.law) {
                    Ok(None) => {}
                    Ok(Some(new)) => {
                        packages.insert(program.index.crate_of(program.index.function(site.law).module).package);
                        edits.push((new.span, new.text));
                    }
                    Err(text) => reasons.push(Reason { span: of.span(site.call), text }),
                }
                let gone = removal(of.text, site.stmt.clone());
                edits.push((self.span(gone.start, gone.end), String::new()));
            }
        }
        match self.head() {
            Ok(head) => edits.extend(head),
            Err(reason) => reasons.push(reason),
        }
        if !reasons.is_empty() {
            reasons.sort_by_key(|reason| reason.span);
            reasons.dedup();
            return Err(reasons);
        }
        changes.sort_by_key(|reason| reason.span);
        changes.dedup();
        edits.sort();
        edits.dedup();
        let order: Vec<String> = self.guarded.iter().map(|own| format!("`{}`", own.name)).collect();
        notes.insert(0, match order.as_slice() {
            [one] => format!("the law of {one} runs at the end of the cycle"),
            all => format!("the laws run at the end of the cycle, in this order: {}", all.join(", ")),
        });
        if self.rate().is_none() {
            notes.push(format!("`Hz<{UNKNOWN_RATE}>` stands for a rate that the loop does not tell; no law reads it"));
        }
        for pair in cycle.filters.iter().filter(|pair| is_left(pair) && pair.verdict != Verdict::Guarded) {
            notes.push(format!("`{}` stays as it is: it is {}", pair.name, pair.verdict.name()));
        }
        let needs_alloc = self.guarded.iter().any(|own| matches!(&own.ty, Ty::External(..)));
        Ok(Rewrite { edits, packages, needs_alloc, changes, notes })
    }

    fn span(&self, start: usize, end: usize) -> Span {
        let to_u32 = |at: usize| u32::try_from(at).unwrap_or(u32::MAX);
        Span::new(self.of.file(), to_u32(start), to_u32(end))
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
                if of.may_follow(site.gone, mention.at) || is_among && !is_header && !is_same_element {
                    found.push(self.stale(own, mention.at));
                }
            }
            // The elements have names of their own in the inner loop.
            if let (Some(inner), false) = (site.inner, Some(site.gone) == site.inner)
                && let ExprKind::MethodCall { receiver, .. } = of.kind(site.call)
                && let Some(place) = place_of(of, *receiver)
            {
                let names = of.names(place.local).filter(|at| of.ancestors_inside(*at).any(|at| at == inner));
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
        let ExprKind::For { iterable, .. } = self.of.kind(inner) else { return false };
        std::iter::once(at).chain(self.of.ancestors_inside(at)).any(|around| around == *iterable)
    }

    /// Whether a place is indexed by the same variable as the updated element.
    fn is_element_of(&self, at: ExprId, site: &Site, inner: ExprId) -> bool {
        let index_of = |id: ExprId| match self.of.kind(id) {
            ExprKind::Index { index, .. } => self.of.typed.expr_local.get(index).copied(),
            _ => None,
        };
        let ExprKind::MethodCall { receiver, .. } = self.of.kind(site.call) else { return false };
        let own = self.of.parent(at).and_then(index_of);
        own.is_some() && own == index_of(*receiver) && self.of.ancestors_inside(at).any(|around| around == inner)
    }

    /// A value that leaves the loop and may be a part of what the guard holds.
    fn carried_out(&self, own: &Guarded, mention: &Mention) -> Option<Reason> {
        let of = self.of;
        let value = of.ancestors_inside(mention.at).find_map(|at| match of.kind(at) {
            ExprKind::Break { value, .. } | ExprKind::Return(value) => *value,
            _ => None,
        })?;
        let is_plain = matches!(
            of.typed.ty(value),
            Ty::Int | Ty::Float | Ty::Bool | Ty::Char | Ty::Tuple(_) | Ty::Adt(..) | Ty::External(..) | Ty::Array(..)
        );
        let text = format!("what leaves the loop here may borrow from `{}`", own.spelled);
        (!is_plain).then(|| Reason { span: of.span(value), text })
    }

    /// The ways out of the loop that come before the update: what changes on them, and what nobody can see.
    fn left_before(&self, own: &Guarded) -> (Vec<Reason>, Vec<String>) {
        let of = self.of;
        let is_covered = |exit: &ExprId| {
            own.sites.iter().any(|site| {
                let block = of.parent(site.gone);
                of.span(site.gone).end <= of.span(*exit).start && of.ancestors(*exit).any(|at| Some(at) == block)
            })
        };
        let opaque = self.exits.unread.iter().filter(|id| {
            let text = of.written(**id);
            text.contains('?') || ["return", "break", "continue"].iter().any(|word| has_word(text, word))
        });
        let early: Vec<ExprId> =
            self.exits.left_at.iter().chain(opaque).copied().filter(|exit| !is_covered(exit)).collect();
        if early.is_empty() {
            return (Vec::new(), Vec::new());
        }
        let line = |id: &ExprId| of.program.sources.line(of.span(*id));
        if observed::is_observed(of, own) {
            let text = format!(
                "the loop may be left here before `{}` is updated; the guard updates it on this way as well",
                own.spelled
            );
            return (early.iter().map(|id| Reason { span: of.span(*id), text: text.clone() }).collect(), Vec::new());
        }
        let lines: BTreeSet<String> = early.iter().map(|id| line(id).to_string()).collect();
        let lines = lines.into_iter().collect::<Vec<_>>().join(", ");
        let note = format!(
            "the law of `{}` runs once more where the loop is left (line {lines}); nothing reads it after that",
            own.name
        );
        (Vec::new(), vec![note])
    }

    /// What else changes when the law runs at another time.
    fn effect_of(&self, own: &Guarded, site: &Site) -> Option<Reason> {
        let program = self.of.program;
        let law = &program.index.function(site.law).name;
        let text = if let Some(effect) = purity::side_effect(program, site.law) {
            format!("`{law}` of `{}` {effect}, which then happens at the end of the cycle", own.spelled)
        } else {
            let part = purity::shared_part(program.index, &site.filter)?;
            format!("`{}` holds {part}, so that its law may meet what the rest of the iteration does there", own.spelled)
        };
        Some(Reason { span: self.of.span(site.call), text })
    }

    /// The clock above the loop, and the guard at its head.
    fn head(&self) -> Result<[(Span, String); 2], Reason> {
        let of = self.of;
        let refuse = |text: &str| Reason { span: of.span(of.whole), text: text.to_owned() };
        let mut at = of.whole;
        let start = loop {
            let parent = of.parent(at).ok_or_else(|| refuse("the loop is not a statement of a block"))?;
            match of.kind(parent) {
                ExprKind::Block(block) => {
                    let span = of.span(at);
                    let stmt = block.stmts.iter().map(|stmt| stmt.span).find(|stmt| stmt.contains(span));
                    break stmt.unwrap_or(span).start as usize;
                }
                ExprKind::Closure(_) | ExprKind::Macro(_) => {
                    return Err(refuse("the loop is not a statement of a block"));
                }
                _ => at = parent,
            }
        };
        let text = of.text;
        let start = behind_label(text, start);
        let core = ceid_core_name(of.program.index, of.function);
        let body = of.program.sources.snippet(of.span(of.body.root));
        let clock = ["clock", "cycle_clock", "guard_clock", "ceid_clock"]
            .into_iter()
            .find(|name| !has_word(body, name) && !of.body.params.iter().any(|pat| self.binds(*pat, name)))
            .ok_or_else(|| refuse("every name for a clock means something else here"))?;
        let rate = self.rate().unwrap_or(UNKNOWN_RATE);
        let declared = format!("let mut {clock} = {core}::Free::<{core}::Hz<{rate}>>::new();");
        let end = line_end(text);
        let clock_edit = if begins_line(text, start) {
            let at = above(text, start);
            (self.span(at, at), format!("{}{declared}{end}", indentation(text, start)))
        } else {
            (self.span(start, start), format!("{declared} "))
        };
        let list: Vec<String> = self.guarded.iter().map(Guarded::entry).collect();
        let guard = format!("{core}::ceid!({clock}.begin_cycle() => {});", list.join(", "));
        let open = of.span(of.block).start as usize + 1;
        let stop = line_stop(text, open);
        let rest = text[open..stop].trim();
        let guard_edit = if rest.is_empty() || rest.starts_with("//") {
            let indent = format!("{}{}", indentation(text, open), indentation_step(text));
            (self.span(stop, stop), format!("{indent}{guard}{end}"))
        } else {
            (self.span(open, open), format!(" {guard}"))
        };
        Ok([clock_edit, guard_edit])
    }

    fn binds(&self, pat: crate::syntax::tree::PatId, name: &str) -> bool {
        let local = self.of.typed.pat_local.get(&pat);
        local.is_some_and(|local| self.of.typed.local(*local).name == name)
    }

    /// How often a second the loop runs, if a sleep of constant length in it tells.
    fn rate(&self) -> Option<u64> {
        let of = self.of;
        of.inside.iter().find_map(|id| {
            let ExprKind::Call { callee, args } = of.kind(*id) else { return None };
            let (ExprKind::Path(path), [length]) = (of.kind(*callee), args.as_slice()) else { return None };
            let ExprKind::Call { callee: unit, args: number } = of.kind(*length) else { return None };
            let (ExprKind::Path(unit), [number]) = (of.kind(*unit), number.as_slice()) else { return None };
            let ExprKind::Literal(crate::syntax::tree::Literal::Int(Some(number), _)) = of.kind(*number) else {
                return None;
            };
            let per_second = match unit.last() {
                "from_millis" => 1_000,
                "from_micros" => 1_000_000,
                _ => return None,
            };
            let is_whole = *number > 0 && per_second % number == 0;
            (path.last() == "sleep" && is_whole).then(|| per_second / number)
        })
    }
}

impl Guarded {
    /// The filter in the list of the guard.
    fn entry(&self) -> String {
        if self.place.fields.is_empty() { self.name.clone() } else { format!("{} = {}", self.name, self.spelled) }
    }
}

/// Where a loop begins whose label stands before `start`.
fn behind_label(text: &str, start: usize) -> usize {
    let before = text[..start].trim_end();
    let Some(label) = before.strip_suffix(':').map(str::trim_end) else { return start };
    let name = label.trim_end_matches(|c: char| c.is_alphanumeric() || c == '_');
    if name.len() < label.len() && name.ends_with('\'') { name.len() - 1 } else { start }
}
