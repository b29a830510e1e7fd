//! Control flow: each function as a graph of the effects that matter for filters. Knows no verdicts.

mod asked;
mod call;
mod cause;
mod cells;
mod change;
mod cycle;
mod duplicated;
mod guard;
mod latches;
mod lower;
mod mark;
mod place;
mod program;
mod section;
mod sizes;
mod steps;
mod strides;
mod switched;
mod test;
mod unrun;
mod waits;

use std::collections::BTreeSet;

use crate::index::{FunctionId, Index, Ty};
use crate::source::Span;

pub(crate) use call::DESTRUCTOR;
pub use call::{Argument, CallSite};
pub use cause::Cause;
pub use cells::Cells;
pub use change::{Change, ChangeKind, Tally};
pub use cycle::{Caller, CycleKind, Limit, LoopInfo, Rounds};
pub use duplicated::Duplicated;
pub use guard::GuardInfo;
pub use latches::Flag;
pub(crate) use lower::MAX_DISPATCHED;
pub use lower::received::{asks_state, is_receiving, is_receiving_something, is_waiting};
pub use lower::{
    Told, deciding, has_one_answer, is_flag, is_shared_number, is_state_field, lower_function, reads_shared_number,
    stands_in, stands_in_for_states, told, works_out_of_settings,
};
pub use mark::{Mark, in_words};
pub use place::{Base, IndexKey, Place, Projection, Relation, Steps};
pub use program::{Inferred, MAX_VARIANTS, Program, VariantNumbers, small_number};
pub use section::Section;
pub use sizes::{AskedLength, LengthBound, Resized};
use steps::parameter_names;
pub use steps::{Step, StepUnit, is_time_name, step_unit, takes_moment, takes_step};
pub use strides::{SampleRead, SampleWrite};
pub use test::{About, AskedNumber, Head, OTHER_HEADS, PAST, Subject, SubjectId, Test};
pub use unrun::{Unrun, UnrunKind};
pub use waits::{Wait, WaitKind};

/// A node of a [`ControlFlowGraph`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct NodeId(pub u32);

/// A variable of a graph: a parameter, a name of the source, or a value in between.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Var(pub u32);

/// A loop of a graph.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct LoopId(pub u32);

/// A guard of a graph.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct GuardId(pub u32);

/// The control flow of one function.
#[derive(Clone, Debug, Default)]
pub struct ControlFlowGraph {
    /// The function.
    pub function: FunctionId,
    /// The nodes; the first one is the entry.
    pub nodes: Vec<Node>,
    /// The variables.
    pub vars: Vec<VarInfo>,
    /// The parameters in order, `self` first.
    pub params: Vec<Var>,
    /// The loops; an outer one stands before those inside it.
    pub loops: Vec<LoopInfo>,
    /// Loops whose rounds are written out one behind another: the keyword and the body of each.
    pub written_out: Vec<(Span, Span)>,
    /// Variables that such a loop binds to what is written there.
    pub written_rows: BTreeSet<Var>,
    /// Calls in the arguments of macros that write them more than once, with the names of the macros.
    pub written_again: Vec<(Span, String)>,
    /// Closures and futures that nothing runs.
    pub unrun: Vec<Unrun>,
    /// What branches ask about.
    pub subjects: Vec<Subject>,
    /// The guards.
    pub guards: Vec<GuardInfo>,
    /// Which variables were computed from which: the first from the second.
    pub derived: Vec<(Var, Var)>,
    /// What variables were computed from: the places read, and the functions and methods called.
    pub computed: std::collections::BTreeMap<Var, Computed>,
    /// Where the expression stands that variables were last computed from: what has the same came together.
    pub read_at: std::collections::BTreeMap<Var, Span>,
    /// The variables that hold what was taken out of something in the same iteration: `let packet = radio.wait();`
    pub received: BTreeSet<Var>,
    /// The variables that hold a remainder, and whether it is the low bits of a number: `let slot = n % 10;`
    pub remainders: std::collections::BTreeMap<Var, bool>,
    /// The variables that hold a constant for good: `let is_on = P::IS_ON;`
    pub constants: BTreeSet<Var>,
    /// The variables that a closure or an arm was handed: nothing is built there.
    pub handed: BTreeSet<Var>,
    /// The variables that are declared with what was taken out of something, or copied from it: it was built elsewhere.
    pub taken: BTreeSet<Var>,
    /// The places whose values assignments copy, by their nodes.
    pub copies: std::collections::BTreeMap<NodeId, Place>,
    /// What assignments do, by their nodes.
    pub changes: std::collections::BTreeMap<NodeId, Change>,
    /// Calls that wait, read a clock or block.
    pub waits: Vec<Wait>,
    /// The constant steps with which filters are made: the variable that holds the new filter, and its step.
    pub steps: std::collections::BTreeMap<Var, Step>,
    /// Handles whose clones share one value (`Rc`, `Arc`), given to something unseen that may keep them.
    pub kept: Vec<(Place, Cause)>,
    /// Handles that are duplicated.
    pub duplicated: Duplicated,
    /// The nodes at which what refers to filters refers to others from then on: `slot = Some(&mut lag)`.
    pub pointed: BTreeSet<NodeId>,
    /// Places with filters to which references were made.
    pub lent_away: BTreeSet<Place>,
    /// What is known of cells.
    pub cells: Cells,
    /// Filters, and owners of filters, that are cloned somewhere.
    pub cloned: Vec<Place>,
    /// The elements of collections that are lent to the closures of an iterator, whether or not it is consumed.
    pub lent: Vec<Place>,
    /// The values that something unseen gets for good, to do with them what their types offer, by the nodes where it does.
    pub given_away: BTreeSet<(NodeId, Place)>,
    /// The variables whose values a `move` closure takes along.
    pub moved_along: BTreeSet<Var>,
    /// Elements of collections that a method takes out: `queue.pop()`.
    pub taken_out: BTreeSet<Place>,
    /// The nodes of code that runs elsewhere or later, outside every loop of its own, with the forks at which it begins.
    pub elsewhere: std::collections::BTreeMap<NodeId, NodeId>,
    /// Elements of blocks that are written at a multiple of a number.
    pub sample_writes: Vec<SampleWrite>,
    /// Those that are read so.
    pub sample_reads: Vec<SampleRead>,
    /// What statements leave of which nothing keeps the value.
    pub dropped: Vec<Span>,
    /// Collections that a method puts values into, with what these are computed from.
    pub filled: Vec<(NodeId, Place, Computed)>,
    /// What is computed for a call, or for whoever calls a closure, with where it stands: `out.push(x * gain)`.
    pub mixed: Vec<(NodeId, Span, Computed)>,
    /// Collections that a method takes everything out of.
    pub emptied: Vec<(NodeId, Place)>,
    /// What methods do to the lengths of the collections that they write.
    pub resized: std::collections::BTreeMap<NodeId, Resized>,
    /// Functions that are called without a call among the nodes: their bodies were read there, or run where a future is awaited.
    pub read_here: BTreeSet<FunctionId>,
    /// Set if the function was too large or too deep to be followed to its end.
    pub truncated: Option<Cause>,
    /// Whether a law runs here that gives back the next state.
    pub gives_next: bool,
}

/// What a value was computed from.
#[derive(Clone, Debug, Default)]
pub struct Computed {
    /// The places read.
    pub places: Vec<Place>,
    /// The functions and methods called.
    pub calls: Vec<String>,
}

/// A point of the control flow.
#[derive(Clone, Debug)]
pub struct Node {
    /// What happens.
    pub effect: Effect,
    /// Where.
    pub span: Span,
    /// Where it goes on. A branch has two: the test holds, it does not. A loop's head has two: another round, no more.
    pub next: Vec<NodeId>,
    /// The innermost loop it lies in.
    pub in_loop: Option<LoopId>,
    /// The branch behind which it lies, if only a debug build or a log level leads there: what is shipped does not have it.
    pub debug_only: Option<NodeId>,
}

/// What happens at a node.
#[derive(Clone, Debug)]
pub enum Effect {
    /// Nothing.
    Nothing,
    /// The law of a filter, or a half of it, runs.
    Update(Update),
    /// A law runs that leaves the state that it is given as it was, and gives back the next one.
    Advance(Box<Advance>),
    /// A method of the filter's entry resets it, or it is written as a whole.
    Reset {
        /// The filter.
        place: Place,
        /// Whether the whole state is reset.
        full: bool,
    },
    /// A filter is read or fed.
    Use {
        /// The filter, or a part of it.
        place: Place,
    },
    /// A function of the analysed code runs.
    Call(Box<CallSite>),
    /// A variable gets a value.
    Set(Box<Assignment>),
    /// A place that is no variable, or what a reference points to, gets a value.
    Write(Box<Assignment>),
    /// What happens to these places cannot be known.
    Unknown {
        /// The places.
        places: Vec<Place>,
        /// Why.
        cause: Cause,
    },
    /// Two ways.
    Branch(Test),
    /// Another round or no more.
    LoopHead(LoopId),
    /// The loop is entered.
    LoopEnter(LoopId),
    /// A guard takes effect.
    GuardStart(GuardId),
    /// A guard is dropped: what it holds is updated.
    GuardEnd(GuardId),
    /// Code that runs elsewhere or later begins at the second successor.
    Fork,
    /// Something is awaited: other tasks may run before it goes on.
    Suspend,
    /// The function is left; the heads that its value may have.
    Return(Returned),
    /// The program ends or panics: nothing follows.
    Diverge,
    /// The end of code that runs elsewhere, or a point that is never reached.
    End,
    /// Nothing, but a step that a reader of a path wants to see.
    Mark(Mark),
}

/// A law that runs.
#[derive(Clone, Debug)]
pub struct Update {
    /// The filter.
    pub place: Place,
    /// Which half of the law.
    pub law: usize,
    /// The method.
    pub method: String,
    /// Who runs it.
    pub run_by: RunBy,
    /// Whether the type of the place tells that it is a filter; a law may also have its state in an argument of any type.
    pub is_typed: bool,
    /// The state that takes the place of the one before, if the laws that gave it have run already.
    pub given: Option<Place>,
    /// The variable that holds the result, if the law leaves the filter as it is when that is an `Err`.
    pub attempt: Option<Var>,
    /// The variables that its arguments read.
    pub fed: Vec<Var>,
    /// The variables that its result goes into.
    pub into: Vec<Var>,
    /// What its arguments read and call.
    pub from: Computed,
}

/// A law that gives back the next state. The filter is updated where that takes the place of the one before.
#[derive(Clone, Debug)]
pub struct Advance {
    /// The state before.
    pub before: Place,
    /// The state after.
    pub after: Place,
    /// Which half of the law.
    pub law: usize,
    /// The method.
    pub method: String,
    /// The variable that holds the result, if that may be an `Err` instead.
    pub attempt: Option<Var>,
    /// Whether the statement drops what the law gives back.
    pub is_dropped: bool,
}

/// Who runs an update.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RunBy {
    /// The code, where it is written.
    Code,
    /// A guard, at the end of the cycle.
    Guard,
    /// A guard, at the end of a cycle in which it was fed, once however often it was.
    GuardIfFed,
}

impl RunBy {
    /// Whether a guard runs it.
    #[must_use]
    pub fn is_guard(self) -> bool {
        self != Self::Code
    }
}

/// A value given to a place.
#[derive(Clone, Debug)]
pub struct Assignment {
    /// The place.
    pub place: Place,
    /// The place whose instances the value carries.
    pub from: Option<Place>,
    /// How they get there.
    pub transfer: Transfer,
    /// Whether the place is a reference that now points elsewhere, so that what it pointed to stays as it is.
    pub rebinds: bool,
    /// The value, if it is constant.
    pub head: Option<Head>,
    /// A variable with the same value.
    pub same_as: Option<Var>,
}

impl Assignment {
    /// Whether it only tells the head of a part of what was just made.
    #[must_use]
    pub fn is_of_part(&self) -> bool {
        self.from.is_none() && self.rebinds && !self.place.steps.is_empty()
    }
}

/// How the instances that a value carries get to another place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Transfer {
    /// The place refers to them.
    Borrow,
    /// They live there from now on.
    Move,
    /// The place gets other instances with the same state: the type is `Copy`.
    Copy,
    /// The same, and the copy is put back where it came from: the instances go along with it.
    RoundTrip,
}

/// What a function gives back.
#[derive(Clone, Debug, Default)]
pub struct Returned {
    /// The place whose instances the value carries.
    pub place: Option<Place>,
    /// The value's head, if it is constant.
    pub head: Option<Head>,
    /// A variable with the same value.
    pub same_as: Option<Var>,
}

/// A variable.
#[derive(Clone, Debug)]
pub struct VarInfo {
    /// Its name in the source; empty for a value in between.
    pub name: String,
    /// Its type.
    pub ty: Ty,
    /// Where it is declared.
    pub span: Span,
    /// The loop in whose body it is declared.
    pub in_loop: Option<LoopId>,
    /// The node at which it is declared.
    pub declared: NodeId,
    /// The parameter it is, if it is one.
    pub param: Option<usize>,
}

impl ControlFlowGraph {
    /// Whether what the function leaves in a parameter can be in the caller's place afterwards: it is lent exclusively, or is all that the
    /// function gives back (`state = step(state)`).
    #[must_use]
    pub fn leaves_behind(&self, var: Var) -> bool {
        let info = self.var(var);
        let whole = Some(Place::var(var));
        let given = |node: &Node| match &node.effect {
            Effect::Return(value) => Some(value.place == whole),
            _ => None,
        };
        let is_given_back = || self.nodes.iter().filter_map(given).reduce(|all, is_it| all && is_it) == Some(true);
        matches!(info.ty, Ty::Ref(true, _)) || info.param.is_some() && matches!(info.ty, Ty::Adt(..)) && is_given_back()
    }

    /// The node with that id.
    #[must_use]
    pub fn node(&self, id: NodeId) -> &Node {
        &self.nodes[id.0 as usize]
    }

    /// The variable with that id.
    #[must_use]
    pub fn var(&self, id: Var) -> &VarInfo {
        &self.vars[id.0 as usize]
    }

    /// The loop with that id.
    #[must_use]
    pub fn loop_info(&self, id: LoopId) -> &LoopInfo {
        &self.loops[id.0 as usize]
    }

    /// Whether a loop is another one or lies in it.
    #[must_use]
    pub fn is_within(&self, inner: Option<LoopId>, outer: LoopId) -> bool {
        let mut at = inner;
        while let Some(id) = at {
            if id == outer {
                return true;
            }
            at = self.loop_info(id).parent;
        }
        false
    }

    /// The loops around a node, innermost first.
    pub fn loops_around(&self, node: NodeId) -> impl Iterator<Item = LoopId> + '_ {
        std::iter::successors(self.node(node).in_loop, |id| self.loop_info(*id).parent)
    }

    /// The forks at which the code of a node begins that runs elsewhere, outside every loop of its own, innermost first.
    pub fn forks_before(&self, node: NodeId) -> impl Iterator<Item = NodeId> + '_ {
        std::iter::successors(self.elsewhere.get(&node).copied(), |fork| self.elsewhere.get(fork).copied())
    }

    /// The nodes with their ids.
    pub fn node_ids(&self) -> impl Iterator<Item = NodeId> + use<> {
        (0..u32::try_from(self.nodes.len()).unwrap_or(u32::MAX)).map(NodeId)
    }

    /// The name of a place as the source spells it.
    #[must_use]
    pub fn place_name(&self, index: &Index, place: &Place) -> String {
        place.spell(&|var| self.var(var).name.clone(), &|value| index.value(value).name.clone())
    }
}
