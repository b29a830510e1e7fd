//! Checks of the very sample that is then fed: whether it is a number at all, and whether it came whole.

use super::Gates;
use super::sample::has_word;
use crate::flow::{Place, Test};

/// Methods that ask whether a measured value is one.
const IS_NUMBER: &[&str] = &["is_finite", "is_nan", "is_infinite"];

/// Words in the names of what comes with a sample and tells whether it came whole.
const CHECKS: &[&str] = &["crc", "crc8", "crc16", "crc32", "checksum", "chksum", "cksum", "parity"];

impl Gates<'_, '_> {
    /// `if let Ok(z) = baro.read() && z.is_finite() { … }`, `if packet.crc == 0 { f.update(packet.z) }`: a sample that is none is
    /// not there.
    pub(super) fn rejects_sample(&self, test: &Test) -> bool {
        let about = &test.about;
        if about.is_presence || about.is_masked || about.is_remainder || about.reads.is_empty() {
            return false;
        }
        let asks_number = !about.names.is_empty() && about.names.iter().all(|name| IS_NUMBER.contains(&name.as_str()));
        asks_number && self.asks_only_sample(test) || self.asks_checksum(test)
    }

    fn asks_checksum(&self, test: &Test) -> bool {
        let about = &test.about;
        let is_check = |name: &String| CHECKS.iter().any(|word| has_word(name, word));
        let is_constant = |name: &String| !name.chars().any(char::is_lowercase);
        (about.names.iter().any(is_check) || about.reads.iter().any(|place| is_check(&self.last_name(place))))
            && about.names.iter().all(|name| is_check(name) || is_constant(name))
            && about.reads.iter().all(|place| self.comes_with_sample(place))
    }

    /// Whether a value of the iteration came together with what is fed: as a part of the same packet, or by the same pattern.
    fn comes_with_sample(&self, place: &Place) -> bool {
        let graph = self.search.graph;
        let Some(var) = place.base_var().filter(|_| !self.outlives(place)) else { return false };
        let made_by = graph.computed.get(&var).filter(|computed| !computed.calls.is_empty());
        let Some(made_by) = made_by else { return false };
        self.fed().places.iter().any(|fed| {
            fed.base_var().is_some_and(|other| {
                let is_same = || {
                    graph
                        .computed
                        .get(&other)
                        .is_some_and(|own| own.calls == made_by.calls && own.places == made_by.places)
                };
                other == var || graph.read_at.get(&var) == graph.read_at.get(&other) && is_same()
            })
        })
    }
}
