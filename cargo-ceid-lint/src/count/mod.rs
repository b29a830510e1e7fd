//! The analysis this tool exists for: how often each cycle updates each filter. Reads graphs, never syntax.

mod aliases;
mod analyse;
mod answers;
mod assumed;
mod behind;
mod callgraph;
mod conditions;
mod counts;
mod cycles;
mod debug_only;
mod decide;
mod effort;
mod fields;
mod functions;
mod gates;
mod given;
mod guards;
mod handed;
mod instances;
mod owed;
mod remarks;
mod returned;
mod search;
mod shown;
mod skips;
mod slice;
mod summary;
mod uses;
mod verdict;
mod witness;

pub use analyse::{Analysis, GuardDefect, Unregistered, analyse};
pub use counts::Count;
pub use functions::is_cycle_function;
pub use remarks::{Fact, Remark};
pub use verdict::{Cycle, CycleKind, Evidence, Gate, Pair, Verdict, is_guard_rule};
