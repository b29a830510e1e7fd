//! The halves of a law, and the methods that run both.

use std::collections::BTreeSet;

use super::judge::Judged;
use super::laws::Finder;
use super::words::{Half, half, is_other_verb};
use crate::config::Multiplicity;
use crate::flow::takes_step;
use crate::index::FunctionId;

impl Finder<'_> {
    /// The methods of a law that predict and correct, by their names: `step` beside `predict` and `update`.
    pub(super) fn whole_steps(&self, laws: &[FunctionId]) -> Vec<String> {
        let name = |id: &FunctionId| &self.program.index.function(*id).name;
        let of = |wanted: Half| laws.iter().copied().filter(move |id| half(name(id)) == Some(wanted));
        let corrected: BTreeSet<FunctionId> = of(Half::Correct).flat_map(|id| self.run_by(id)).collect();
        let predicted: BTreeSet<FunctionId> =
            of(Half::Predict).flat_map(|id| self.run_by(id)).filter(|id| !corrected.contains(id)).collect();
        let is_told_step = |id: FunctionId| takes_step(self.program.index, id);
        let is_timed = of(Half::Predict).any(is_told_step) && !of(Half::Correct).any(is_told_step);
        let predicts = |id: FunctionId| {
            (is_timed && is_told_step(id)) || self.run_by(id).iter().any(|run| predicted.contains(run))
        };
        laws.iter().filter(|id| half(name(id)).is_none() && predicts(**id)).map(|id| name(id).clone()).collect()
    }

    /// The groups of laws that advance parts of the state which have nothing to do with each other, where code calls them one beside the
    /// other: each is owed an update of its own. `pid.position(…); pid.attitude(…);` `None` if all are one group.
    pub(super) fn independent(&self, laws: &[&Judged]) -> Option<Vec<(Vec<String>, Multiplicity)>> {
        let mut groups: Vec<Vec<&Judged>> = Vec::new();
        for law in laws {
            let state = |judged: &Judged| judged.carried.iter().chain(&judged.runs).cloned().collect::<BTreeSet<_>>();
            let own = state(law);
            let is_bound = |group: &Vec<&Judged>| {
                group.iter().any(|other| {
                    let theirs = state(other);
                    let is_apart = !own.is_empty() && !theirs.is_empty() && own.is_disjoint(&theirs);
                    !is_apart || !self.together.are_beside(law.id, other.id)
                })
            };
            let (bound, mut apart): (Vec<_>, Vec<_>) = groups.into_iter().partition(is_bound);
            apart.push(bound.into_iter().flatten().chain([*law]).collect());
            groups = apart;
        }
        let names = |group: Vec<&Judged>| {
            let names: BTreeSet<String> = group.into_iter().map(|law| law.name.clone()).collect();
            (names.into_iter().collect(), Multiplicity::Once)
        };
        (groups.len() > 1).then(|| groups.into_iter().map(names).collect())
    }

    /// A method and those of its type that it runs and that change the state, directly or not.
    fn run_by(&self, id: FunctionId) -> BTreeSet<FunctionId> {
        let mut found = BTreeSet::from([id]);
        let mut open = vec![id];
        while let Some(at) = open.pop() {
            let changes = |helper: &&FunctionId| {
                let conduct = self.conduct(**helper);
                conduct.writes_all || !conduct.written.is_empty()
            };
            for helper in self.conduct(at).helpers.iter().filter(changes) {
                if found.insert(*helper) {
                    open.push(*helper);
                }
            }
        }
        found
    }
}

/// The groups of a law: `predict` and what corrects it are halves, of which a whole step runs both; other methods are alternatives.
pub(super) fn groups(names: &[String], whole: &[String]) -> Vec<(Vec<String>, Multiplicity)> {
    let is_whole = |name: &&String| whole.contains(name);
    let is_predict = |name: &&String| half(name) == Some(Half::Predict);
    let predicts: Vec<String> = names.iter().filter(|name| is_predict(name) || is_whole(name)).cloned().collect();
    let others: Vec<String> = names.iter().filter(|name| !is_predict(name) && !is_other_verb(name)).cloned().collect();
    if !names.iter().any(|name| is_predict(&name)) || others.is_empty() {
        return vec![(names.to_vec(), Multiplicity::Once)];
    }
    if others.iter().all(|name| whole.contains(name)) {
        return vec![(predicts, Multiplicity::Once)];
    }
    vec![(predicts, Multiplicity::Once), (others, Multiplicity::Any)]
}
