//! From a typed body to its control-flow graph. Decides nothing about filters: it only says what happens where.

mod about;
mod adapted;
mod bits;
mod borrowed;
mod bound;
mod builtins;
mod by_number;
mod callbacks;
mod calls;
mod carried;
mod chained;
mod changes;
mod closures;
mod compared;
mod conditions;
mod constants;
mod converted;
mod copies;
mod counted;
mod debug_only;
mod derefs;
mod destructors;
mod ends;
mod exchanges;
mod exits;
mod expr;
mod external;
mod flags;
mod futures;
mod given_away;
mod guards;
mod halves;
mod handed_back;
mod heads;
mod held;
mod intervals;
mod items;
mod iterators;
mod known;
mod last;
mod laws;
mod lazy;
mod lent_names;
mod limits;
mod locks;
mod loops;
mod macros;
mod made;
mod numbers;
mod operators;
mod optional;
mod orders;
mod panics;
mod parts;
mod passed_over;
mod patterns;
mod payloads;
mod places;
mod pointed;
mod pools;
mod presence;
mod pure;
mod put_back;
mod questions;
mod raw_pointers;
mod reading;
mod reads;
pub(super) mod received;
mod renewed;
mod resets;
mod results;
mod same_states;
mod sampled;
mod sources;
mod spelling;
mod stored;
mod strides;
mod subjects;
mod switches;
mod tallies;
mod threads;
mod ticks;
mod told;
mod unrolled;
mod unrun;
mod unseen;
mod values;
mod waits;
mod widths;
pub(super) mod written;

use std::cell::OnceCell;
use std::rc::Rc;

use closures::ClosureRef;
pub use flags::{is_flag, is_shared_number, reads_shared_number};
pub(crate) use laws::MAX_DISPATCHED;
use rustc_hash::{FxHashMap, FxHashSet};
pub use told::{Told, deciding, has_one_answer, told};
pub use written::{is_state_field, stands_in, stands_in_for_states, works_out_of_settings};

use super::{Assignment, Cause, ControlFlowGraph, Effect, GuardId, Head, LoopId, Node, NodeId, Place, Program, Var};
use crate::index::{FunctionId, Ty};
use crate::source::Span;
use crate::syntax::tree::{Body, ExprId, ExprKind, PatId};
use crate::types::{LocalId, TypedBody};

/// How many nodes a graph may have; more is said to be too large.
const MAX_NODES: usize = 200_000;

/// How deep functions and closures are inlined.
const MAX_INLINE: u32 = 8;

/// The control flow of a function; `None` for a signature.
#[must_use]
pub fn lower_function(program: &Program<'_>, id: FunctionId) -> Option<ControlFlowGraph> {
    let body = program.index.function(id).function.body.as_ref()?;
    let typed = program.typed(id)?;
    let mut builder = Builder::new(program, id, body, typed);
    builder.lower_root(body);
    Some(builder.finish())
}

/// The code that is lowered: a body with its types, and the variables that stand for its locals.
struct Frame<'a> {
    function: FunctionId,
    body: &'a Body,
    typed: &'a TypedBody,
    vars: FxHashMap<LocalId, Var>,
    /// The parameters that stand for places of the caller, where a function is read in the place of its call.
    stand_ins: FxHashMap<LocalId, Place>,
    /// The parameters that are given a constant with bits in it there.
    masks: FxHashMap<LocalId, u32>,
    /// The other names of places with filters in them, and whether each is a reference.
    owners: FxHashMap<LocalId, (Place, bool)>,
    /// The locals that are assigned or borrowed mutably somewhere.
    mutated: FxHashSet<LocalId>,
    /// What is given to calls as it is, or taken apart by a pattern.
    passed: FxHashSet<ExprId>,
    /// The locals that are given a value in several places.
    given_anew: FxHashSet<LocalId>,
    /// The locals that are declared as whole numbers, as far as it was asked.
    ints: OnceCell<FxHashMap<LocalId, String>>,
    /// What is followed by nothing but the end of an iteration.
    last: FxHashMap<ExprId, Vec<ExprId>>,
    /// Whether a closure is written in it.
    has_closures: bool,
}

impl<'a> Frame<'a> {
    fn new(function: FunctionId, body: &'a Body, typed: &'a TypedBody) -> Self {
        Self {
            function,
            body,
            typed,
            vars: FxHashMap::default(),
            stand_ins: FxHashMap::default(),
            masks: FxHashMap::default(),
            owners: FxHashMap::default(),
            mutated: borrowed::mutated_locals(body, typed),
            passed: borrowed::passed(body, typed),
            given_anew: closures::given_anew(body, typed),
            ints: OnceCell::new(),
            last: last::last_of_iterations(body),
            has_closures: body.exprs.iter().any(|expr| matches!(expr.kind, ExprKind::Closure(_))),
        }
    }
}

/// What an expression evaluates to, as far as filters go.
#[derive(Clone, Debug, Default)]
struct Value {
    /// The place whose instances it carries.
    place: Option<Place>,
    /// Whether it is the place itself, not a reference to it.
    is_owned: bool,
    /// How it leaves its place, where its type does not tell: `slot.take()`, `Box::new(copied)`.
    leaves_by: Option<crate::flow::Transfer>,
    /// Its head, if it is constant.
    head: Option<Head>,
    /// A variable with the same head.
    same_as: Option<Var>,
    /// The closure it is, or the function by its name.
    closure: Option<ClosureRef>,
    /// What it runs over, if it is an iterator that nothing has consumed yet.
    iterator: Option<Rc<sources::Source>>,
}

struct Builder<'a> {
    program: &'a Program<'a>,
    graph: ControlFlowGraph,
    frames: Vec<Frame<'a>>,
    frame: usize,
    depth: u32,
    scopes: Vec<exits::Scope>,
    loops: Vec<LoopId>,
    /// The node to which the next one is linked; `None` where nothing leads any more.
    at: Option<NodeId>,
    closures: FxHashMap<Var, ClosureRef>,
    /// Which variables hold iterators.
    iterators: FxHashMap<Var, Rc<sources::Source>>,
    /// Whole numbers that variables are known to have at this point of the text.
    numbers: FxHashMap<Var, u64>,
    /// Variants that variables are known to be at this point of the text.
    names: FxHashMap<Var, Head>,
    /// The numbers that variables were declared with, even if they change.
    initials: FxHashMap<Var, u64>,
    /// Other names of parameters and counters, where neither ever changes: `let channel = index;`.
    copies: FxHashMap<Var, Var>,
    /// Variables that hold a state which a law gave back.
    advanced: FxHashSet<Var>,
    /// The locals that a `move` closure has copies of, and the copies.
    captures: FxHashMap<(usize, ExprId), Vec<(LocalId, Var)>>,
    /// Calls whose futures are not awaited yet, by the frames and expressions of the calls.
    deferred: FxHashMap<(usize, ExprId), futures::Deferred>,
    /// What a value may be that is one function or closure or another one, by the frame and expression that chooses.
    choices: FxHashMap<(usize, ExprId), Vec<ClosureRef>>,
    /// The closures that have come from the branches so far, by the variable in which they meet.
    arrived: FxHashMap<Var, Vec<Option<ClosureRef>>>,
    /// The closures that are put somewhere, and what may call them from there.
    stored: stored::Stored,
    /// Patterns of several alternatives whose names are bound where each of them is asked for.
    bound_by_asking: FxHashSet<(usize, PatId)>,
    guards_of: FxHashMap<Var, GuardId>,
    /// The variables that say whether a guard is alive.
    alive: FxHashMap<GuardId, Var>,
    /// The guards that are made and not bound yet.
    made: Vec<made::Made>,
    /// The scopes in which the variables that hold guards were declared.
    guard_scopes: FxHashMap<Var, usize>,
    /// The guards that something else than the end of their scope may have ended.
    ended: FxHashSet<GuardId>,
    /// How the laws of adapted filters run, by the variables that the filters were given to first.
    adapted: FxHashMap<Var, adapted::Adaptation>,
    /// The adapted filters that a guard holds and runs in every cycle.
    adapted_by: FxHashMap<GuardId, Vec<(Place, Option<crate::flow::Rounds>, adapted::Adaptation)>>,
    /// The names of adapted filters that a guard holds and that are fed.
    admitted: FxHashSet<Var>,
    subjects: FxHashMap<String, super::SubjectId>,
    /// The states that lie in what literals have made.
    state_parts: FxHashMap<Var, Vec<parts::StatePart>>,
    /// The parameters of closures that are asked whether they are pure.
    inner: FxHashSet<LocalId>,
    /// What patterns took out of values that conditions can ask for.
    held: Vec<held::Held>,
    /// The comparisons of a value with a number, by their subjects.
    bounds: std::collections::BTreeMap<super::SubjectId, intervals::Bound>,
    /// Which numbers values can be by their types, by what tells them apart.
    ends: FxHashMap<String, intervals::Ends>,
    orders: std::collections::BTreeMap<super::SubjectId, orders::Order>,
    inlining: Vec<FunctionId>,
    /// Parameters of functions read where they are called that are a constant there: `self.enter(Mode::Run)`.
    known: FxHashMap<Var, Head>,
    handed_back: Option<handed_back::HandedBack>,
    /// The variables that the value of the expression at hand goes into.
    targets: Vec<Var>,
    /// The expression whose value they get.
    target_value: Option<(usize, ExprId)>,
    /// Whether something leads to each node.
    reached: Vec<bool>,
    /// The condition as the source spells it where its body is read: `self.is_armed()`.
    spoken: Option<(Span, String)>,
    /// Whether the code at hand runs elsewhere or later.
    is_detached: bool,
    /// The loop around what lets the code at hand run elsewhere or later.
    detached_in: Option<LoopId>,
    /// The scopes of threads around the code at hand: how many loops stand around each.
    thread_scopes: Vec<usize>,
}

impl<'a> Builder<'a> {
    fn new(program: &'a Program<'a>, function: FunctionId, body: &'a Body, typed: &'a TypedBody) -> Self {
        let graph = ControlFlowGraph { function, ..ControlFlowGraph::default() };
        Self {
            program,
            graph,
            frames: vec![Frame::new(function, body, typed)],
            frame: 0,
            depth: 0,
            scopes: Vec::new(),
            loops: Vec::new(),
            at: None,
            closures: FxHashMap::default(),
            iterators: FxHashMap::default(),
            numbers: FxHashMap::default(),
            names: FxHashMap::default(),
            initials: FxHashMap::default(),
            copies: FxHashMap::default(),
            advanced: FxHashSet::default(),
            captures: FxHashMap::default(),
            deferred: FxHashMap::default(),
            choices: FxHashMap::default(),
            arrived: FxHashMap::default(),
            stored: stored::Stored::default(),
            bound_by_asking: FxHashSet::default(),
            guards_of: FxHashMap::default(),
            alive: FxHashMap::default(),
            made: Vec::new(),
            guard_scopes: FxHashMap::default(),
            ended: FxHashSet::default(),
            adapted: FxHashMap::default(),
            adapted_by: FxHashMap::default(),
            admitted: FxHashSet::default(),
            subjects: FxHashMap::default(),
            state_parts: FxHashMap::default(),
            inner: FxHashSet::default(),
            held: Vec::new(),
            bounds: std::collections::BTreeMap::new(),
            ends: FxHashMap::default(),
            orders: std::collections::BTreeMap::new(),
            inlining: vec![function],
            known: FxHashMap::default(),
            handed_back: None,
            targets: Vec::new(),
            target_value: None,
            reached: Vec::new(),
            spoken: None,
            is_detached: false,
            detached_in: None,
            thread_scopes: Vec::new(),
        }
    }

    fn lower_root(&mut self, body: &'a Body) {
        let function = self.graph.function;
        let span = self.program.index.function(function).function.head;
        self.emit(Effect::Nothing, span);
        for (number, pat) in body.params.iter().enumerate() {
            let ty = self.param_ty(*pat);
            let name = self.param_name(*pat);
            let var = self.new_var(name, ty, self.body().pat(*pat).span);
            self.graph.vars[var.0 as usize].param = Some(number);
            self.graph.params.push(var);
            if let Some(local) = self.typed().pat_local.get(pat) {
                self.frames[0].vars.insert(*local, var);
            } else {
                let value = Value { place: Some(Place::var(var)), ..Value::default() };
                self.bind_pattern(*pat, &value);
            }
        }
        self.open_block();
        self.bind_parameters(function, span);
        let value = self.expr(body.root);
        let returned = self.moved_guard(&value);
        self.close_block_without(returned, span);
        self.leave_function(value, self.span_end(span, body.root));
    }

    fn span_end(&self, _head: Span, root: ExprId) -> Span {
        let span = self.body().expr(root).span;
        Span::new(span.file, span.end.saturating_sub(1), span.end)
    }

    fn finish(mut self) -> ControlFlowGraph {
        self.graph.duplicated = super::Duplicated::of(self.program.index, self.body(), self.typed());
        self.note_written_again();
        self.settle_unrun();
        self.settle_stored();
        self.settle_known();
        self.settle_copies();
        self.settle_held();
        self.settle_tallies();
        self.settle_bounds();
        self.settle_orders();
        self.copy_subjects();
        self.mark_debug_only();
        self.find_rounds();
        self.graph
    }

    fn body(&self) -> &'a Body {
        self.frames[self.frame].body
    }

    fn typed(&self) -> &'a TypedBody {
        self.frames[self.frame].typed
    }

    fn ty(&self, id: ExprId) -> &'a Ty {
        self.typed().ty(id)
    }

    fn span(&self, id: ExprId) -> Span {
        self.body().expr(id).span
    }

    /// Adds a node that nothing leads to yet.
    fn add_node(&mut self, effect: Effect, span: Span) -> NodeId {
        let id = NodeId(u32::try_from(self.graph.nodes.len()).expect("fewer than 2^32 nodes"));
        let in_loop = self.loops.last().copied();
        self.graph.nodes.push(Node { effect, span, next: Vec::new(), in_loop, debug_only: None });
        self.reached.push(false);
        id
    }

    /// Adds a node behind the current one and goes on from it. Nothing is added where nothing leads.
    fn emit(&mut self, effect: Effect, span: Span) -> NodeId {
        if self.graph.nodes.is_empty() {
            let id = self.add_node(effect, span);
            self.at = Some(id);
            return id;
        }
        if self.graph.nodes.len() >= MAX_NODES && self.graph.truncated.is_none() {
            let limit = format!("the function has more than {MAX_NODES} steps");
            self.graph.truncated = Some(Cause::Limit(limit));
        }
        let id = self.add_node(effect, span);
        if let Some(at) = self.at {
            self.link(at, id);
            self.at = Some(id);
        }
        id
    }

    fn link(&mut self, from: NodeId, to: NodeId) {
        self.graph.nodes[from.0 as usize].next.push(to);
        self.reached[to.0 as usize] = true;
    }

    /// Leads the current point to a node, and nothing behind it.
    fn jump(&mut self, to: NodeId) {
        if let Some(at) = self.at.take() {
            self.link(at, to);
        }
    }

    /// Goes on from a node that was added before.
    fn resume(&mut self, node: NodeId) {
        self.at = Some(node);
    }

    fn new_var(&mut self, name: String, ty: Ty, span: Span) -> Var {
        let id = Var(u32::try_from(self.graph.vars.len()).expect("fewer than 2^32 variables"));
        let in_loop = self.loops.last().copied();
        let declared = self.at.unwrap_or(NodeId(0));
        self.graph.vars.push(super::VarInfo { name, ty, span, in_loop, declared, param: None });
        id
    }

    /// Whether the local that a variable stands for changes somewhere.
    fn is_mutated(&self, var: Var) -> bool {
        let frame = &self.frames[self.frame];
        frame.vars.iter().any(|(local, own)| *own == var && frame.mutated.contains(local))
    }

    /// A variable for a value in between.
    fn temporary(&mut self, ty: Ty, span: Span) -> Var {
        self.new_var(String::new(), ty, span)
    }

    /// The variable of a local of the current frame.
    fn var_of(&mut self, local: LocalId) -> Var {
        if let Some(var) = self.frames[self.frame].vars.get(&local) {
            return *var;
        }
        let info = self.typed().local(local);
        let var = self.new_var(info.name.clone(), info.ty.clone(), info.span);
        self.frames[self.frame].vars.insert(local, var);
        var
    }

    /// Gives a variable a value.
    fn set(&mut self, var: Var, value: &Value, span: Span) {
        self.hold_closure(var, value, span);
        match &value.iterator {
            Some(source) => self.iterators.insert(var, Rc::clone(source)),
            None => self.iterators.remove(&var),
        };
        self.note_copy_of_number(var, value);
        self.note_name(var, value);
        self.numbers.remove(&var);
        if let Some(number) = value.head.as_deref().and_then(|head| head.parse().ok()) {
            self.initials.entry(var).or_insert(number);
            if !self.is_mutated(var) {
                self.numbers.insert(var, number);
            }
        }
        let given = value.place.as_ref().and_then(Place::base_var);
        if let Some(guard) = given.and_then(|var| self.guards_of.get(&var)).copied() {
            self.guards_of.insert(var, guard);
        }
        if let Some(from) = given.or(value.same_as) {
            self.graph.derived.push((var, from));
            if self.advanced.contains(&from) {
                self.advanced.insert(var);
            }
        }
        let assignment = Assignment {
            place: Place::var(var),
            from: value.place.clone(),
            transfer: self.transfer(value, &self.graph.var(var).ty),
            rebinds: true,
            head: value.head.clone(),
            same_as: value.same_as,
        };
        self.emit(Effect::Set(Box::new(assignment)), span);
    }
}
