//! Questions to an object with several sensors: whether what is asked for is what is read from it.

use super::Gates;
use super::sources::is_arithmetic;
use crate::flow::{Effect, Node, Place};
use crate::index::Ty;

/// Words in the names of methods that say nothing of what is read or asked for.
const NO_PARTS: &[&str] = &[
    "is",
    "has",
    "have",
    "can",
    "new",
    "ready",
    "available",
    "avail",
    "pending",
    "fresh",
    "valid",
    "updated",
    "drdy",
    "data",
    "dataready",
    "sample",
    "samples",
    "value",
    "reading",
    "measurement",
    "read",
    "get",
    "take",
    "next",
    "poll",
    "fetch",
    "measure",
    "raw",
    "unwrap",
    "expect",
    "ok",
    "or",
    "default",
    "await",
    "into",
    "from",
    "as",
    "status",
    "state",
    "done",
    "conversion",
    "stale",
    "to",
    "len",
    "is_empty",
    "block",
    "wait",
    "last",
    "latest",
    "copied",
    "cloned",
    "clone",
    "all",
    "both",
    "frame",
    "sensors",
    "packet",
    "burst",
    "motion",
    "pop",
    "recv",
    "try",
    "the",
];

impl Gates<'_, '_> {
    /// Whether what is asked for is another thing of the same object than what is fed: `if bus.has_baro() { f.update(bus.gyro()) }`,
    /// where there is a `bus.baro()` as well.
    pub(super) fn asks_other_part(&self, names: &[String], reads: &[Place]) -> bool {
        let (index, graph) = (self.search.program.index, self.search.graph);
        let [name] = names else { return false };
        let words = |name: &str| -> Vec<String> {
            let own = name.split('_').filter(|word| !NO_PARTS.contains(word) && word.len() > 1);
            own.map(str::to_owned).collect()
        };
        let asked = words(name);
        // What is read from the object: all of it has to be called by the name of a part, and none by that which is asked for.
        let is_of = |place: &Place, call: &str| match self.ty(place) {
            None | Some(Ty::External(..) | Ty::Unknown) => true,
            Some(ty) => !index.methods(ty.peel(), call).is_empty(),
        };
        let is_own = |call: &&String| !is_arithmetic(call) && reads.iter().any(|place| is_of(place, call));
        let fed: Vec<Vec<String>> = self.fed().calls.iter().filter(is_own).map(|call| words(call)).collect();
        let is_other_part = |own: &Vec<String>| !own.is_empty() && !own.iter().any(|word| asked.contains(word));
        let is_other = |call: &str| call != name && words(call) == asked;
        if asked.is_empty() || fed.is_empty() || !fed.iter().all(is_other_part) {
            return false;
        }
        let part = asked.join("_");
        let candidates = [part.clone(), format!("read_{part}"), format!("get_{part}"), format!("take_{part}")];
        let has_part = |place: &Place| {
            let ty = self.ty(place);
            let mut others = candidates.iter().filter(|other| *other != name);
            ty.is_some_and(|ty| others.any(|other| !index.methods(ty.peel(), other).is_empty()))
        };
        let is_called = |node: &Node| match &node.effect {
            Effect::Call(site) => site.targets.iter().any(|target| is_other(&index.function(*target).name)),
            Effect::Branch(other) => other.about.names.iter().any(|call| is_other(call)),
            _ => false,
        };
        let is_computed = || graph.computed.values().flat_map(|made| &made.calls).any(|call| is_other(call));
        reads.iter().any(has_part) || graph.nodes.iter().any(is_called) || is_computed()
    }
}
