//! From verdicts to findings: what is said, where, and what is left out because another finding says it. Decides no verdict.

use std::collections::BTreeSet;

use super::known::{Hidden, Known, calls_of};
use super::missed::missing;
use super::repeated::{can_be_sibling, is_updated_with, pasted_from, repeated, trades_with};
use super::skipped::skipped;
use super::{Rule, find};
use crate::count::{Analysis, Cycle, CycleKind, Gate, GuardDefect, Pair, Unregistered, Verdict, is_guard_rule};
use crate::diagnostic::{Diagnostic, Facts, Label, Level, Witness, WitnessStep};
use crate::source::Span;

/// The findings of an analysis, at the level `allow`; the caller sets the levels.
#[must_use]
pub fn findings(analysis: &Analysis, known: &Known<'_>) -> Vec<Diagnostic> {
    let mut found = Vec::new();
    let told = told_by_functions(analysis, known);
    for cycle in &analysis.cycles {
        of_cycle(cycle, known, &told, &mut found);
    }
    let mut others: Vec<Diagnostic> = analysis.unregistered.iter().filter_map(unregistered).collect();
    others.extend(analysis.guards.iter().filter_map(guard));
    others.extend(analysis.remarks.iter().filter_map(super::remarks::finding));
    for finding in &mut others {
        let cycle = finding.facts.cycle.filter(|_| finding.rule != "unregistered_filter");
        let places: Vec<Span> = [finding.primary.span].into_iter().chain(cycle).collect();
        finding.suppressed = known.hides(finding.rule, finding.package, &places, &[]).map(|hidden| hidden.reason);
    }
    found.extend(others);
    found
}

/// The places at which findings about cycle functions are shown, by rule. What goes wrong in the law of a composite is told
/// there, and not again by each cycle that calls it.
type Told = BTreeSet<(&'static str, Span)>;

fn told_by_functions(analysis: &Analysis, known: &Known<'_>) -> Told {
    let functions = analysis.cycles.iter().filter(|cycle| cycle.kind == CycleKind::Function);
    let told = functions.flat_map(|cycle| {
        let own = cycle.filters.iter().filter(|pair| pair.through.is_empty());
        own.filter_map(move |pair| {
            let rule = pair.verdict.rule().filter(|rule| pair.rules.contains(rule))?;
            hidden(cycle, pair, rule, known).is_none().then_some((rule, pair.primary?))
        })
    });
    told.collect()
}

/// What hides the finding of a rule about a pair: what is said of the place, of the cycle, or of an update.
fn hidden(cycle: &Cycle, pair: &Pair, rule: &'static str, known: &Known<'_>) -> Option<Hidden> {
    let places: Vec<Span> = pair.primary.into_iter().chain([cycle.head]).collect();
    known.hides(rule, cycle.package, &places, calls_of(pair, rule))
}

fn with_hidden<'p>(
    cycle: &Cycle,
    pairs: Vec<&'p Pair>,
    rule: &'static str,
    (known, told): (&Known<'_>, &Told),
) -> Vec<(&'p Pair, Option<Hidden>)> {
    let is_told =
        |pair: &Pair| !pair.through.is_empty() && pair.primary.is_some_and(|place| told.contains(&(rule, place)));
    let pairs = pairs.into_iter().map(|pair| (pair, hidden(cycle, pair, rule, known)));
    pairs.filter(|(pair, hidden)| hidden.is_some() || !is_told(pair)).collect()
}

/// One finding for each pair that a rule fires on; siblings that go wrong together share one.
fn of_cycle(cycle: &Cycle, known: &Known<'_>, told: &Told, found: &mut Vec<Diagnostic>) {
    let hiding = (known, told);
    let missed: Vec<&Pair> = of_verdict(cycle, Verdict::Missed);
    let mut add = |finding: Option<Diagnostic>, hidden: Option<Hidden>| {
        let suppressed = hidden.map(|hidden| hidden.reason);
        found.extend(finding.map(|finding| Diagnostic { suppressed, ..finding }));
    };
    let repeats = with_hidden(cycle, of_verdict(cycle, Verdict::Repeated), "repeated_update", hiding);
    // What is missed is told by itself where the repetition that it was pasted from is not told.
    let shown: Vec<&Pair> = repeats.iter().filter(|(_, hidden)| hidden.is_none()).map(|(pair, _)| *pair).collect();
    let mut missed = with_hidden(cycle, missed, "missed_update", hiding);
    let is_sibling = |pair: &Pair, (other, other_hidden): &(&Pair, Option<Hidden>)| {
        other_hidden.is_none()
            && can_be_sibling(pair, &other.name)
            && pasted_from(other, &shown).is_some_and(|from| from.name == pair.name)
    };
    // What stands in the place of a sibling is told with it.
    let is_alone = |pair: &Pair| {
        pair.left_out.iter().all(|sibling| !can_be_sibling(pair, sibling))
            && !missed.iter().any(|other| is_sibling(pair, other))
    };
    // Filters that change places between two updates go wrong together, and so do those that one call updates.
    let go_together = |one: &Pair, other: &Pair| {
        trades_with(one, other)
            || is_updated_with(one, other) && takes_one_path(one, other) && is_alone(one) && is_alone(other)
    };
    let groups = grouped(repeats, go_together);
    for (group, hidden) in groups {
        let [pair, partners @ ..] = group.as_slice() else { continue };
        let (siblings, others): (Vec<_>, Vec<_>) = missed.into_iter().partition(|other| is_sibling(pair, other));
        missed = others;
        let siblings: Vec<&Pair> = siblings.into_iter().map(|(pair, _)| pair).collect();
        add(repeated(cycle, pair, &siblings, partners), hidden);
    }
    for (group, hidden) in grouped(missed, |_, _| true) {
        add(missing(cycle, &group), hidden);
    }
    let by_statement =
        |one: &Pair, other: &Pair| one.primary == other.primary && one.primary.is_some() && takes_one_path(one, other);
    for (group, hidden) in
        grouped(with_hidden(cycle, of_verdict(cycle, Verdict::Skipped), "skipped_update", hiding), by_statement)
    {
        add(skipped(cycle, &group), hidden);
    }
    for (pair, hidden) in with_hidden(cycle, of_verdict(cycle, Verdict::Unproved), "unproved_update", hiding) {
        add(unproved(cycle, pair), hidden);
    }
    for (pair, hidden) in with_hidden(cycle, of_verdict(cycle, Verdict::Gated), "gated_update", hiding) {
        add(gated(cycle, pair), hidden);
    }
    for pair in cycle.filters.iter().filter(|pair| pair.rules.contains(&"unguarded_update")) {
        add(unguarded(cycle, pair), hidden(cycle, pair, "unguarded_update", known));
    }
}

/// Whether the paths of two pairs can be one: no condition holds on the one and not on the other.
fn takes_one_path(one: &Pair, other: &Pair) -> bool {
    let is_against = |step: &WitnessStep| {
        let at = |own: &&WitnessStep| own.span == step.span;
        other.witness.iter().any(|own| at(&own))
            && other.witness.iter().filter(at).all(|own| own.message != step.message)
    };
    !one.witness.iter().any(is_against)
}

/// The pairs of a verdict that no other finding tells: what only a debug build updates has one of its own, and so has a guard
/// that is not there for the cycle.
fn of_verdict(cycle: &Cycle, verdict: Verdict) -> Vec<&Pair> {
    let tells = |rule: &&'static str| *rule == "debug_only_update" || is_guard_rule(rule);
    let is_told = |pair: &&Pair| {
        let has_own = pair.rules.iter().any(tells) || verdict.rule().is_some_and(|rule| !pair.rules.contains(&rule));
        matches!(verdict, Verdict::Missed | Verdict::Skipped) && has_own
    };
    // What goes wrong with a filter goes wrong with the filters that it is made of.
    let is_of_another = |pair: &&Pair| {
        cycle.filters.iter().any(|other| {
            let rest = pair.name.strip_prefix(&other.name);
            other.verdict == verdict
                && other.primary == pair.primary
                && rest.is_some_and(|rest| rest.starts_with(['.', '[']))
        })
    };
    let pairs = cycle.filters.iter().filter(|pair| pair.verdict == verdict);
    pairs.filter(|pair| !is_told(pair) && !is_of_another(pair)).collect()
}

/// Pairs that go into one finding: those that belong together and that the same suppression hides, or none.
fn grouped(
    pairs: Vec<(&Pair, Option<Hidden>)>,
    belong: impl Fn(&Pair, &Pair) -> bool,
) -> Vec<(Vec<&Pair>, Option<Hidden>)> {
    let mut groups: Vec<(Vec<&Pair>, Option<Hidden>)> = Vec::new();
    for (pair, hidden) in pairs {
        match groups.iter_mut().find(|(group, other)| belong(group[0], pair) && *other == hidden) {
            Some((group, _)) => group.push(pair),
            None => groups.push((vec![pair], hidden)),
        }
    }
    groups
}

pub(super) const GUARD_HELP: &str =
    "let a guard update it: `ceid_core::ceid!(cycle => …)` at the head of the cycle, and no update by hand";

/// Which half of a law goes wrong, where the cycle has to do with another half of it as well.
pub(super) fn by_half(cycle: &Cycle, pairs: &[&Pair]) -> String {
    let law = &pairs[0].law;
    let is_half = |pair: &&Pair| {
        let is_other = |other: &Pair| other.name == pair.name && other.half != pair.half;
        pair.law == *law && cycle.filters.iter().any(is_other)
    };
    if pairs.iter().all(is_half) { format!(" by `{law}`") } else { String::new() }
}

fn unproved(cycle: &Cycle, pair: &Pair) -> Option<Diagnostic> {
    let rule = find("unproved_update")?;
    let cause = pair.cause.clone().unwrap_or_default();
    let message = format!("it cannot be proved how often `{}` is updated in one cycle: {cause}", pair.name);
    let mut finding = start(rule, cycle, &[pair], message, cycle.head, "in this cycle");
    finding.helps.push("make the update visible in the cycle, or let a guard run it".to_owned());
    Some(finding)
}

fn gated(cycle: &Cycle, pair: &Pair) -> Option<Diagnostic> {
    let rule = find("gated_update")?;
    let kind = pair.gate.map_or("config", Gate::name);
    let article = if kind.starts_with('e') { "an" } else { "a" };
    let message = format!("`{}` is updated only when {article} {kind} gate opens", pair.name);
    let mut finding = start(rule, cycle, &[pair], message, cycle.head, "in this cycle");
    finding.notes.push("whenever the gate opens it is updated exactly once".to_owned());
    Some(finding)
}

fn unguarded(cycle: &Cycle, pair: &Pair) -> Option<Diagnostic> {
    let rule = find("unguarded_update")?;
    let message = format!("`{}` is updated exactly once in this cycle, by attention and not by a guard", pair.name);
    let mut finding = start(rule, cycle, &[pair], message, cycle.head, "in this cycle");
    finding.notes.push("the next `continue`, `?` or pasted line can change that; a guard cannot be skipped".to_owned());
    finding.helps.push(GUARD_HELP.to_owned());
    Some(finding)
}

fn unregistered(filter: &Unregistered) -> Option<Diagnostic> {
    let rule = find("unregistered_filter")?;
    let message = format!("the filter `{}` is built, and nothing ever updates it", filter.name);
    let mut finding = empty(rule, filter.package, filter.target);
    finding.message = message;
    finding.primary = Label { span: filter.span, message: "built here".to_owned() };
    finding.notes.push("it is neither updated, nor registered with a guard, nor moved, nor returned".to_owned());
    finding.helps.push(format!("update `{}` once in every cycle, hand it to what does, or remove it", filter.name));
    finding.helps.push(suppression(rule));
    finding.facts = Facts {
        verdict: Verdict::Missed.name().to_owned(),
        counts: vec![0],
        filters: vec![filter.name.clone()],
        filter_type: filter.filter_type.clone(),
        cycle: filter.cycle,
        cause: None,
        function: filter.function.clone(),
    };
    Some(finding)
}

fn guard(defect: &GuardDefect) -> Option<Diagnostic> {
    let rule = find(defect.rule)?;
    let what = if defect.names.is_empty() { "the filters it holds".to_owned() } else { quoted(&defect.names) };
    let mut finding = empty(rule, defect.package, defect.target);
    let made = WitnessStep { span: defect.made, message: "the guard is made here".to_owned() };
    let (message, label, note, help) = match defect.rule {
        "guard_outside_cycle" => (
            format!("this guard is made before the loop, so it updates {what} once at the end, not once per cycle"),
            "made here, alive for the whole loop".to_owned(),
            "a guard updates when it is dropped; what is dropped behind the loop updates once in all".to_owned(),
            "make the guard at the head of the loop's body".to_owned(),
        ),
        "guard_dropped_early" => (
            format!("this guard ends before the cycle does: {}", defect.what),
            "it ends here".to_owned(),
            format!(
                "{what} {} updated when the guard ends, with what was fed so far and not with what follows",
                if defect.names.len() == 1 { "is" } else { "are" }
            ),
            "make the guard at the head of the cycle, in no block inside of it: `ceid_core::ceid!(…);`, or `let guard = …;`".to_owned(),
        ),
        _ => (
            format!("this guard is never dropped: {} keeps its destructor from running", defect.what),
            "its destructor never runs".to_owned(),
            format!("{what} would be updated by the destructor, so nothing updates it"),
            "let the guard go out of scope at the end of the cycle".to_owned(),
        ),
    };
    finding.message = message;
    finding.primary = Label { span: defect.span, message: label };
    if defect.made != defect.span {
        finding.witness.steps.push(made);
    }
    if let Some(cycle) = defect.cycle {
        finding.witness.steps.push(WitnessStep { span: cycle, message: "the cycle".to_owned() });
    }
    finding.notes.push(note);
    finding.helps.push(help);
    finding.helps.push(suppression(rule));
    finding.facts = Facts {
        filters: defect.names.clone(),
        cycle: defect.cycle,
        function: defect.function.clone(),
        ..Facts::default()
    };
    Some(finding)
}

pub(super) fn empty(rule: &'static Rule, package: usize, target: usize) -> Diagnostic {
    Diagnostic {
        rule: rule.name,
        level: Level::Allow,
        level_source: String::new(),
        message: String::new(),
        primary: Label { span: Span::new(crate::source::FileId(0), 0, 0), message: String::new() },
        witness: Witness::default(),
        notes: Vec::new(),
        helps: Vec::new(),
        suggestions: Vec::new(),
        facts: Facts::default(),
        suppressed: None,
        known: false,
        package,
        target,
    }
}

pub(super) fn start(
    rule: &'static Rule,
    cycle: &Cycle,
    pairs: &[&Pair],
    message: String,
    span: Span,
    label: &str,
) -> Diagnostic {
    let first = pairs[0];
    Diagnostic {
        message,
        primary: Label { span, message: label.to_owned() },
        witness: Witness { steps: first.witness.clone() },
        facts: Facts {
            verdict: first.verdict.name().to_owned(),
            counts: first.counts.clone(),
            filters: pairs.iter().map(|pair| pair.name.clone()).collect(),
            filter_type: first.filter_type.clone(),
            cycle: Some(cycle.head),
            cause: first.cause.clone(),
            function: cycle.function.clone(),
        },
        ..empty(rule, cycle.package, cycle.target)
    }
}

/// The names of a group: of a large one the first, for a message that can be read.
pub(super) fn names(pairs: &[&Pair]) -> String {
    let (told, rest) = told(pairs);
    match rest.len() {
        0 => quoted(&told),
        more => {
            format!("{} and {more} more", told.iter().map(|name| format!("`{name}`")).collect::<Vec<_>>().join(", "))
        }
    }
}

/// What a message does not name of a large group.
pub(super) fn others(pairs: &[&Pair]) -> Option<String> {
    let (_, rest) = told(pairs);
    (!rest.is_empty()).then(|| format!("the others are {}", quoted(&rest)))
}

fn told(pairs: &[&Pair]) -> (Vec<String>, Vec<String>) {
    const MOST_NAMES: usize = 8;
    const FIRST_NAMES: usize = 5;
    let mut names: Vec<String> = pairs.iter().map(|pair| pair.name.clone()).collect();
    let rest = if names.len() > MOST_NAMES { names.split_off(FIRST_NAMES) } else { Vec::new() };
    (names, rest)
}

/// `a`, `b` and `c`
pub(super) fn quoted(names: &[String]) -> String {
    let quoted: Vec<String> = names.iter().map(|name| format!("`{name}`")).collect();
    match quoted.as_slice() {
        [] => String::new(),
        [one] => one.clone(),
        [all @ .., last] => format!("{} and {last}", all.join(", ")),
    }
}

/// The other way out: to say that it is meant so, and why.
pub(super) fn suppression(rule: &Rule) -> String {
    format!("if it is meant so, say why on the line above: `// ceid: allow({}, reason = \"…\")`", rule.name)
}
