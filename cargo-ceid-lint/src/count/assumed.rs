//! What a way through a function takes for granted of conditions that its caller knows, as long as nothing in the function has changed
//! them: `if self.armed { … }` in a helper. A caller that knows better leaves the way out.

use std::collections::{BTreeMap, BTreeSet};

use super::given::{Given, argument};
use super::outcome::Outcome;
use crate::flow::{CallSite, Head, OTHER_HEADS, Subject};

/// The heads with which a way is taken, by the place that has them.
pub(super) type Assumed = BTreeMap<Given, Heads>;

/// Heads of a subject of the function.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Heads {
    /// What the bits stand for.
    known: Vec<Head>,
    /// The heads that the value may have.
    mask: u32,
    /// All heads that there are.
    all: u32,
    /// Whether nothing on the way writes what has them.
    pub(super) is_kept: bool,
}

impl Heads {
    /// What is known of a subject; `None` if that is nothing.
    pub(super) fn of(subject: &Subject, mask: u32, is_kept: bool) -> Option<Self> {
        Self { known: subject.heads.clone(), mask, all: subject.anything(), is_kept }.told(is_kept)
    }

    /// The same where that nothing writes it is told or not; `None` if they tell nothing.
    fn told(self, is_kept: bool) -> Option<Self> {
        (is_kept || self.mask != self.all).then_some(Self { is_kept, ..self })
    }

    /// Whether whatever has them has those others.
    fn is_within(&self, others: &Self) -> bool {
        self.mask & !others.mask == 0 && (self.is_kept || !others.is_kept)
    }

    /// Whether an argument with a constant head takes this way.
    pub(super) fn allows(&self, head: &Head) -> bool {
        let bit = self.known.iter().position(|known| known == head).map_or(OTHER_HEADS, |at| 1 << at);
        self.mask & bit != 0
    }

    /// The same, as a subject of the caller has it.
    pub(super) fn as_of(&self, subject: &Subject) -> u32 {
        subject.translate(self.mask, &self.known)
    }
}

/// Whether the constants among the arguments of a call leave a way open: `slow(false)` takes none for which the argument is true.
pub(super) fn is_open_to(assumed: &Assumed, site: &CallSite) -> bool {
    let head = |given: &Given| argument(given, site).and_then(|argument| argument.head.as_ref());
    assumed.iter().all(|(given, heads)| head(given).is_none_or(|head| heads.allows(head)))
}

/// How many ways are looked at before what they assume is forgotten, and how many are told to callers.
const MAX_WAYS: usize = 64;
const MAX_TOLD: usize = 12;

/// Takes ways together that differ only in what they give back, or only in what they assume of one place.
pub(super) fn merged(ways: &BTreeSet<Outcome>) -> Vec<Outcome> {
    let without_kept = |way: &Outcome| {
        let heads = |(given, heads): (&Given, &Heads)| Some((given.clone(), heads.clone().told(false)?));
        Outcome { assumed: way.assumed.iter().filter_map(heads).collect(), ..way.clone() }
    };
    let without_left = |way: &Outcome| Outcome { left: Assumed::new(), ..way.clone() };
    let without_left: BTreeSet<Outcome> = ways.iter().map(without_left).collect();
    let states: BTreeSet<Outcome> = without_left.iter().map(without_questions).collect();
    let fewer: BTreeSet<Outcome> = states.iter().map(without_kept).collect();
    for ways in [ways, &without_left, &states, &fewer] {
        if ways.len() <= MAX_WAYS {
            let told = united(ways.clone());
            if told.len() <= MAX_TOLD || told.iter().all(|way| way.assumed.is_empty()) {
                return told;
            }
        }
    }
    united(fewer.into_iter().map(|way| Outcome { assumed: Assumed::new(), ..way }).collect())
}

/// The same where only states are assumed.
fn without_questions(way: &Outcome) -> Outcome {
    let mut way = way.clone();
    way.assumed.retain(|given, _| !given.is_question());
    way
}

fn united(ways: BTreeSet<Outcome>) -> Vec<Outcome> {
    let mut told: Vec<Outcome> = Vec::new();
    for mut way in ways {
        // What two ways are together may go with a third one.
        while let Some((at, both)) = told.iter().enumerate().find_map(|(at, other)| Some((at, unite(other, &way)?))) {
            told.remove(at);
            way = both;
        }
        told.push(way);
    }
    told.sort();
    told
}

fn unite(one: &Outcome, two: &Outcome) -> Option<Outcome> {
    let bare = |way: &Outcome| Outcome { returned: 0, assumed: Assumed::new(), left: Assumed::new(), ..way.clone() };
    if bare(one) != bare(two) {
        return None;
    }
    if one.assumed == two.assumed && one.left == two.left {
        return Some(Outcome { returned: one.returned | two.returned, ..one.clone() });
    }
    let allows = |one: &Assumed, two: &Assumed| {
        one.iter().all(|(given, heads)| two.get(given).is_some_and(|own| own.is_within(heads)))
    };
    let is_wider = |one: &Outcome, two: &Outcome| {
        one.returned | two.returned == one.returned
            && allows(&one.assumed, &two.assumed)
            && allows(&one.left, &two.left)
    };
    if is_wider(one, two) {
        return Some(one.clone());
    }
    if is_wider(two, one) {
        return Some(two.clone());
    }
    if one.returned != two.returned || one.left != two.left || !one.assumed.keys().eq(two.assumed.keys()) {
        return None;
    }
    let mut different = one.assumed.iter().filter(|(given, heads)| two.assumed.get(*given) != Some(*heads));
    let (Some((given, heads)), None) = (different.next(), different.next()) else { return None };
    let other = &two.assumed[given];
    let joined = Heads { mask: heads.mask | other.mask, ..heads.clone() }.told(heads.is_kept && other.is_kept);
    let mut both = one.clone();
    both.assumed.remove(given);
    both.assumed.extend(joined.map(|joined| (given.clone(), joined)));
    Some(both)
}
