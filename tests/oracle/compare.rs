//! Holds what the linter says against what happened.

use std::fmt;

use crate::program::Program;
use crate::run::{Outcome, Pair, Seen};

/// How a pair disagrees, the worst first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Kind {
    /// A verdict that promises once, and a run that did something else.
    BrokenPromise,
    /// `repeated`, and no run updates twice.
    FalseRepeated,
    /// `missed`, and no run misses, or one updates.
    FalseMissed,
    /// `skipped`, and no run skips.
    FalseSkipped,
    /// Other counts than those observed.
    Counts,
    /// A filter that is updated in a loop, and that no cycle lists.
    Absent,
    /// A cycle or a name that the program does not have.
    Stray,
    /// Not proved.
    Unproved,
}

/// One disagreement.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Disagreement {
    /// What kind it is.
    pub(crate) kind: Kind,
    /// The verdict, which a smaller program must keep.
    pub(crate) verdict: String,
    /// Both sides for people.
    pub(crate) text: String,
}

impl Disagreement {
    /// Whether it is the same defect of the linter, as far as that can be told.
    pub(crate) fn is_like(&self, other: &Self) -> bool {
        self.kind == other.kind && self.verdict == other.verdict
    }
}

/// Figures of a run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Figures {
    /// Programs that compiled.
    pub(crate) programs: usize,
    /// Those with too many paths to take them all.
    pub(crate) sampled: usize,
    /// Pairs of a cycle and an instance.
    pub(crate) pairs: usize,
    /// Pairs by verdict: those that promise once, `repeated`, `missed`.
    pub(crate) promises: usize,
    /// `repeated` pairs.
    pub(crate) repeated: usize,
    /// `missed` pairs.
    pub(crate) missed: usize,
    /// `gated` pairs.
    pub(crate) gated: usize,
    /// Pairs by disagreement.
    pub(crate) broken_promises: usize,
    /// `repeated` that no run shows.
    pub(crate) false_repeated: usize,
    /// `missed` that no run shows.
    pub(crate) false_missed: usize,
    /// `skipped` that no run shows.
    pub(crate) false_skipped: usize,
    /// Pairs that are not `unproved` and whose counts could be compared.
    pub(crate) comparable: usize,
    /// Those with the same counts.
    pub(crate) equal: usize,
    /// `unproved` pairs.
    pub(crate) unproved: usize,
    /// Updated filters that no cycle lists.
    pub(crate) absent: usize,
    /// Pairs of something that the program does not have.
    pub(crate) stray: usize,
}

impl fmt::Display for Figures {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let share = |part: usize, whole: usize| 100.0 * part as f64 / whole.max(1) as f64;
        let Self { programs, sampled, pairs, promises, repeated, missed, gated, .. } = self;
        writeln!(f, "programs            {programs} ({sampled} with too many paths to take all)")?;
        writeln!(
            f,
            "pairs               {pairs}: {promises} once, {repeated} repeated, {missed} missed, {gated} gated"
        )?;
        writeln!(f, "contradicted once   {}", self.broken_promises)?;
        writeln!(f, "false repeated      {}", self.false_repeated)?;
        writeln!(f, "false missed        {}", self.false_missed)?;
        writeln!(f, "false skipped       {}", self.false_skipped)?;
        let equal = share(self.equal, self.comparable);
        writeln!(f, "equal counts        {equal:.2} % ({} of {})", self.equal, self.comparable)?;
        writeln!(f, "unproved            {:.2} % ({})", share(self.unproved, self.pairs), self.unproved)?;
        write!(f, "absent, stray       {}, {}", self.absent, self.stray)
    }
}

impl Figures {
    /// One line for long runs.
    pub(crate) fn short(&self) -> String {
        let Self { programs, broken_promises, false_repeated, false_missed, equal, comparable, unproved, .. } = self;
        format!(
            "{programs} programs: {broken_promises} once contradicted, {false_repeated} repeated and {false_missed} missed \
             not shown, {equal} of {comparable} equal, {unproved} unproved"
        )
    }

    /// Whether the linter keeps its promises: nothing contradicted, 99 % equal, at most 3 % unproved.
    pub(crate) fn are_good(&self) -> bool {
        let wrong = self.broken_promises + self.false_repeated + self.false_missed + self.absent;
        wrong == 0 && self.equal * 100 >= self.comparable * 99 && self.unproved * 100 <= self.pairs * 3
    }
}

/// Compares one program, and adds to the figures.
pub(crate) fn compare(program: &Program, outcome: &Outcome, figures: &mut Figures) -> Vec<Disagreement> {
    figures.programs += 1;
    figures.sampled += usize::from(!outcome.is_complete);
    let mut all = Vec::new();
    let mut listed = Vec::new();
    for (cycle, pair) in &outcome.pairs {
        figures.pairs += usize::from(cycle.is_some_and(|cycle| outcome.is_reached(cycle)));
        let filters = program.filters(&pair.name);
        let disagreement = match cycle {
            // A loop that no input reaches says nothing, nor does a helper on its own.
            Some(cycle) if !outcome.is_reached(*cycle) => None,
            None => None,
            Some(cycle) if !filters.is_empty() => {
                listed.extend(&filters);
                let seen =
                    filters.iter().map(|&filter| outcome.seen[*cycle][filter]).fold(Seen::default(), |all, one| Seen {
                        completing: all.completing | one.completing,
                        exiting: all.exiting | one.exiting,
                    });
                judge(pair, seen, outcome.is_complete, figures).map(|kind| (kind, shown(seen)))
            }
            _ => {
                figures.stray += 1;
                Some((Kind::Stray, String::new()))
            }
        };
        all.extend(disagreement.map(|(kind, observed)| Disagreement {
            kind,
            verdict: pair.verdict.clone(),
            text: format!("{}{observed}", described(pair)),
        }));
    }
    for filter in 0..outcome.seen[0].len() {
        let is_updated = outcome.seen.iter().any(|filters| filters[filter].completing & 6 != 0);
        if is_updated && !listed.contains(&filter) {
            figures.absent += 1;
            let name = program.names.iter().find(|(_, own)| *own == filter).map_or("?", |(name, _)| name.as_str());
            let text = format!("`{name}` is updated, and no cycle lists it");
            all.push(Disagreement { kind: Kind::Absent, verdict: String::new(), text });
        }
    }
    all
}

fn judge(pair: &Pair, mut seen: Seen, is_complete: bool, figures: &mut Figures) -> Option<Kind> {
    if pair.is_at_hand && !pair.counts.contains(&0) {
        // The elements that are not at hand stand still.
        seen.completing &= !1;
    }
    let both = seen.completing | seen.exiting;
    match pair.verdict.as_str() {
        "once" | "guarded" => {
            figures.promises += 1;
            if seen.completing & !2 != 0 || seen.exiting & 4 != 0 {
                figures.broken_promises += 1;
                return Some(Kind::BrokenPromise);
            }
        }
        "once_or_reset" => {
            figures.promises += 1;
            if seen.completing & !(2 | 8) != 0 || seen.exiting & 4 != 0 {
                figures.broken_promises += 1;
                return Some(Kind::BrokenPromise);
            }
        }
        "repeated" => {
            figures.repeated += 1;
            if both & 4 == 0 && is_complete {
                figures.false_repeated += 1;
                return Some(Kind::FalseRepeated);
            }
        }
        "missed" => {
            figures.missed += 1;
            if both & 6 != 0 || (seen.completing & 9 == 0 && is_complete) {
                figures.false_missed += 1;
                return Some(Kind::FalseMissed);
            }
        }
        "skipped" if seen.completing & 1 == 0 && is_complete => {
            figures.false_skipped += 1;
            return Some(Kind::FalseSkipped);
        }
        "gated" => figures.gated += 1,
        "unproved" => {
            figures.unproved += 1;
            return Some(Kind::Unproved);
        }
        _ => {}
    }
    let counts = pair.counts.iter().map(|&count| 1 << count.min(2)).fold(0, |all, bit: u8| all | bit);
    let observed = (seen.completing & 7) | (seen.completing >> 3);
    if !is_complete && observed & !counts == 0 {
        return None;
    }
    figures.comparable += 1;
    figures.equal += usize::from(counts == observed);
    (counts != observed).then_some(Kind::Counts)
}

fn described(pair: &Pair) -> String {
    let Pair { line, kind, name, verdict, gate, counts, cause, .. } = pair;
    let gate = gate.as_ref().map_or_else(String::new, |gate| format!(" by {gate}"));
    let cause = cause.as_ref().map_or_else(String::new, |cause| format!(" because {cause}"));
    format!("line {line}, {kind} {name}: {verdict} {counts:?}{gate}{cause}")
}

fn shown(seen: Seen) -> String {
    let words = |bits: u8| {
        let names = [(1, "0"), (8, "0 with reset"), (2, "1"), (4, "many")];
        let names: Vec<&str> = names.iter().filter(|(bit, _)| bits & bit != 0).map(|&(_, name)| name).collect();
        names.join(", ")
    };
    format!("; observed {{{}}} completing, {{{}}} exiting", words(seen.completing), words(seen.exiting))
}
