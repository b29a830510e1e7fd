//! Why filters are left as they are, of which no plan tells it.

use crate::count::{Cycle, Gate, Pair, Verdict};
use crate::pipeline::Report;

/// Why a guard does not get a filter that the cycle updates by hand, and what to do.
pub(super) fn left(report: &Report, cycle: &Cycle, pair: &Pair) -> Option<String> {
    let name = &pair.name;
    // A guard has it already, which runs its law where the cycle ends.
    if pair.updates.iter().any(|update| report.sources.snippet(*update) == "}") {
        return None;
    }
    if let Some(lock) = locked(report, cycle, pair) {
        return Some(format!(
            "`{name}` is updated where it can be locked, and a guard updates what it holds in each cycle: lock it for the whole \
             iteration, with `let mut filter = {lock}.unwrap();` as its first statement, and migrate the loop then"
        ));
    }
    let what = match (pair.verdict, pair.gate) {
        (Verdict::Gated, Some(Gate::Rate)) => {
            "runs at a slower rate, and a guard updates it in each cycle: give it a `Divider` of ceid-core and its owner a `SampledFilter` \
             with `tick.every`, or leave it as it is"
        }
        (Verdict::Gated, Some(Gate::Config)) if name.ends_with("[*]") => {
            "is updated in part, as a setting says, and a guard updates all that it holds in each cycle: keep those that are updated \
             in a collection of their own, or leave it as it is"
        }
        (Verdict::Gated, Some(Gate::Config)) => {
            "is updated or not, as a setting says, and a guard updates what it holds in each cycle: choose the loop by the setting, or \
             give the guard an `Option`, which is a filter where its content is one"
        }
        (Verdict::Gated, _) => {
            "is left out in some iterations on purpose, and a guard updates it in each: make those iterations no cycles, with a loop \
             that begins one only when it is due, or leave it as it is"
        }
        (Verdict::OnceOrReset, _) => {
            "is reset instead of updated in some iterations, and a guard updates it in each: put the reset into its law, or leave it \
             as it is"
        }
        (Verdict::PerSample, _) => {
            "is updated for each sample of an inner loop, and a guard updates it once per cycle: migrate the inner loop, or leave it \
             as it is"
        }
        _ => return None,
    };
    Some(format!("`{name}` {what}"))
}

/// The call that locks a filter, where only its success decides that it is updated: `if let Ok(mut kf) = shared.lock()`.
fn locked(report: &Report, cycle: &Cycle, pair: &Pair) -> Option<String> {
    let update = pair
        .updates
        .first()
        .filter(|at| (pair.verdict, pair.gate) == (Verdict::Gated, Some(Gate::Config)) && at.file == cycle.head.file)?;
    let code = report.sources.file(cycle.head.file).text.get(cycle.head.end as usize..update.start as usize)?;
    let code: String = code.split_whitespace().collect();
    let calls = ["lock", "write"].map(|method| format!("{}.{method}()", pair.name));
    calls.into_iter().find(|call| code.contains(&format!("={call}")))
}
