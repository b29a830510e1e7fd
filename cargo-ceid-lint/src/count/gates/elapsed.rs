//! Times that are told by what is done with them, whatever they are called.

use super::Gates;
use super::sources::counts_shared;
use super::time::{is_clock, names_timer};
use crate::count::fed::named;
use crate::flow::{CallSite, ChangeKind, NodeId, Place, Test};
use crate::index::Ty;

/// What takes one number from another.
const DIFFERENCES: &[&str] =
    &["wrapping_sub", "saturating_sub", "checked_sub", "unwrap", "unwrap_or", "unwrap_or_default"];

/// Words in the names of functions that tell the time, where what they give is used as one: `get_tick`, `uptime_ms`, `read_timer`.
const CLOCK_WORDS: &[&str] = &[
    "clock",
    "cyccnt",
    "cycles",
    "jiffies",
    "micros",
    "millis",
    "mono",
    "monotonic",
    "ms",
    "msecs",
    "mtime",
    "nanos",
    "ns",
    "rtc",
    "seconds",
    "secs",
    "systick",
    "tick",
    "ticks",
    "time",
    "timer",
    "timestamp",
    "uptime",
    "us",
    "usecs",
];

/// Methods by which a timer tells how far it has counted.
const COUNTS: &[&str] = &["cnt", "count", "counter", "get_count", "get_counter", "read_count"];

/// Whether a function tells the time, by a word of its name: `k_uptime_get`, `xTaskGetTickCount`.
fn has_clock_word(name: &str) -> bool {
    let mut word = String::new();
    let mut is_after_small = false;
    for sign in name.chars().chain(['_']) {
        if sign == '_' || sign.is_uppercase() && is_after_small {
            if CLOCK_WORDS.contains(&word.as_str()) {
                return true;
            }
            word.clear();
        }
        is_after_small = sign.is_lowercase();
        word.extend(sign.to_lowercase().filter(|sign| *sign != '_'));
    }
    false
}

impl Gates<'_, '_> {
    /// `if t >= self.next { self.next = t + PERIOD; … }`: a number that the function is given and feeds to no filter, compared with one
    /// that nothing else puts off.
    pub(super) fn put_off(&self, test: &Test) -> Option<Place> {
        let [Some(left), Some(right)] = &test.about.compared else { return None };
        let graph = self.search.graph;
        let is_next = |next: &Place, moment: &Place| {
            let puts_off = |id: NodeId| {
                graph.changes.get(&id).is_some_and(|change| {
                    let places = named(&change.computed.places);
                    let is_period = |place: &&Place| *place != moment && self.is_left_alone(place);
                    // The period may be a number: `t + 20`.
                    let has_period = places.iter().any(is_period) || graph.copied(id).is_none();
                    let adds = |name: &String| name.ends_with("_add") || name == "Some";
                    matches!(change.kind, ChangeKind::Other | ChangeKind::Fills)
                        && places.contains(&moment)
                        && places.iter().all(|place| *place == moment || is_period(place))
                        && has_period
                        && change.computed.calls.iter().all(adds)
                })
            };
            let mut given = self.assigning(next).peekable();
            let is_moment = self.is_number(next) || self.is_optional_number(next);
            let goes_on = |id: NodeId| puts_off(id) || self.adds_period(id, next);
            is_moment && self.outlives(next) && given.peek().is_some() && given.all(goes_on)
        };
        // `self.next.is_some_and(|next| t < next)`
        let kept = |place: &Place| if self.outlives(place) { place.clone() } else { self.taken_from(place) };
        let put_off = |moment: &Place, next: &Place| {
            let next = kept(next);
            let is_moment = self.is_given_number(moment) || self.is_read_of_clock(moment);
            (is_moment && is_next(&next, moment)).then_some(next)
        };
        [(left, right), (right, left)].into_iter().find_map(|(moment, next)| put_off(moment, next))
    }

    /// Whether a node adds the same to a time whenever its period is over and the filter is updated: `self.last += PERIOD;`
    fn adds_period(&self, id: NodeId, place: &Place) -> bool {
        let leads = |from: NodeId, to: NodeId| self.reached_from(from, |_, _| true)[to.0 as usize];
        let is_beside = |update: &NodeId| leads(id, *update) || leads(*update, id);
        self.search.updating().iter().any(is_beside)
            && self.search.graph.changes.get(&id).is_some_and(|change| {
                let is_period = |from: &&Place| *from == place || self.is_left_alone(from);
                matches!(change.kind, ChangeKind::CountsUp | ChangeKind::Accumulates)
                    && named(&change.computed.places).iter().all(is_period)
                    && change.computed.calls.iter().all(|name| name.ends_with("_add"))
            })
    }

    fn is_optional_number(&self, place: &Place) -> bool {
        match self.ty(place) {
            Some(Ty::External(path, args)) => path.ends_with("::Option") && args.first() == Some(&Ty::Int),
            _ => false,
        }
    }

    /// `if t - self.since >= PERIOD { self.since = t; … }`: the number that was kept when the gate opened the last time, less than what
    /// the function is given and feeds to no filter, than what an interrupt counts, or than what something called a clock tells.
    pub(super) fn begun_again(&self, test: &Test) -> Option<Place> {
        let about = &test.about;
        if !about.is_comparison || about.is_masked || about.is_remainder || about.is_presence {
            return None;
        }
        let sources = self.behind(test);
        let tells = |name: &String| has_clock_word(name) || self.counts_of_timer(name, &sources.places);
        let reckons = |name: &String| DIFFERENCES.contains(&name.as_str()) || counts_shared(name) || tells(name);
        if !sources.calls.iter().all(|name| reckons(name) || !name.contains(char::is_lowercase)) {
            return None;
        }
        let is_moment = |place: &Place| {
            self.is_given_number(place) || self.is_counted_by_others(place) || self.is_read_of_clock(place)
        };
        let is_from_moment = |id: NodeId| match self.search.graph.copied(id) {
            Some(from) => sources.places.contains(&from) && is_moment(&from),
            // It is read anew: `self.since = get_tick();`
            None => self.search.graph.changes.get(&id).is_some_and(|change| {
                let calls = &change.computed.calls;
                !calls.is_empty() && calls.iter().all(|name| tells(name) && sources.calls.contains(name))
            }),
        };
        // Which of them is larger says nothing of what lies between them.
        let is_difference = |kept: &Place| {
            let mut sides = about.compared.iter().flatten();
            !about.compared.contains(&Some(kept.clone())) || !sides.any(is_moment)
        };
        let has_moment = |kept: &Place| sources.places.iter().any(|place| !place.overlaps(kept) && is_moment(place));
        let is_kept = |place: &&Place| {
            let mut given = self.assigning(place).peekable();
            let begins = |id: NodeId| is_from_moment(id) || has_moment(place) && self.adds_period(id, place);
            self.is_number(place)
                && self.outlives(place)
                && given.peek().is_some()
                && is_difference(place)
                && given.all(begins)
        };
        sources.places.iter().find(is_kept).cloned()
    }

    /// A number that the function is given and feeds to no filter.
    fn is_given_number(&self, place: &Place) -> bool {
        let var = place.base_var().filter(|_| place.steps.is_empty() && self.is_number(place));
        var.is_some_and(|var| self.search.graph.var(var).param.is_some() && !self.feeds_any(&[var]))
    }

    /// A number that is read from what is shared, and fed to no filter: `let t = TICKS.load(Ordering::Relaxed);`
    fn is_counted_by_others(&self, place: &Place) -> bool {
        let Some(var) = place.base_var().filter(|_| place.steps.is_empty() && self.is_number(place)) else {
            return false;
        };
        let Some(computed) = self.search.graph.computed.get(&var) else { return false };
        let is_shared = |from: &Place| from.base_var().is_none();
        computed.places.iter().any(is_shared)
            && computed.calls.iter().all(|name| counts_shared(name))
            && !self.outlives(place)
            && !self.feeds_any(&[var])
    }

    /// A number that something called a clock tells, and that is fed to no filter: `let t = uptime_ms();`
    fn is_read_of_clock(&self, place: &Place) -> bool {
        let Some(var) = place.base_var().filter(|_| place.steps.is_empty() && self.is_number(place)) else {
            return false;
        };
        let Some(computed) = self.search.graph.computed.get(&var) else { return false };
        let tells = |name: &String| has_clock_word(name) || self.counts_of_timer(name, &computed.places);
        !computed.calls.is_empty()
            && computed.calls.iter().all(tells)
            && !self.outlives(place)
            && !self.feeds_any(&[var])
    }

    /// Whether a call asks a timer, which one of these places is by its name, how far it has counted: `self.tim2.cnt()`.
    fn counts_of_timer<'p>(&self, name: &str, places: impl IntoIterator<Item = &'p Place>) -> bool {
        COUNTS.contains(&name) && places.into_iter().any(|place| names_timer(&self.last_name(place)))
    }

    /// Whether a call answers what has gone since a time that it keeps at a place: `let gone = now - self.at; self.at = now; gone`.
    pub(super) fn is_told_since(&self, site: &CallSite, id: NodeId, place: &Place) -> bool {
        let Some(owner) = site.args.first().and_then(|arg| arg.place.as_ref()) else { return false };
        let Some((_, told)) = self.all_told().iter().find(|(node, _)| *node == id) else { return false };
        let is_given_time = || site.args[1..].iter().any(|arg| self.tells(&self.assignments().behind(&arg.from)));
        self.is_number(place)
            && !told.scales
            && told.fields.iter().any(|name| owner.field(name) == *place)
            && (told.calls.iter().any(|name| is_clock(name)) || is_given_time())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn clocks_are_told_by_the_words_of_their_names() {
        for name in [
            "uptime_ms",
            "HAL_GetTick",
            "xTaskGetTickCount",
            "k_uptime_get",
            "mach_absolute_time",
            "usecs",
            "ticks64_ms",
        ] {
            assert!(has_clock_word(name), "{name}");
        }
        for name in ["encoder_counts", "sometimes", "stick", "position", "us32", "params", "bonus"] {
            assert!(!has_clock_word(name), "{name}");
        }
    }
}
