//! Which cycles there are, which filters each of them updates or owes an update, and what is decided for each pair.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Mutex;

use super::aliases::Aliases;
use super::analysis::{Analysis, Presumed};
use super::answering::Answering;
use super::cycles::Instance;
use super::decide::{self, Decision};
use super::dispatched;
use super::effort::Effort;
use super::fields::{Fields, touched_fields, touched_statics, updated_fields};
use super::function_facts::function_facts;
use super::functions::{FunctionKind, called_functions, function_kind, is_law, reached_from_cycles};
use super::generic_cycles;
use super::handles::{self, Handles, Joined};
use super::instances::{leaves, place_ty};
use super::lent::Lent;
use super::recursive::is_told_by_outer;
use super::remarks::{Steps, Waiting};
use super::search::{Region, Search};
use super::slice::ControlDependence;
use super::summary::Summaries;
use super::verdict::{Cycle, Pair, Verdict};
use super::{missed, samples, unknown_references};
use crate::config::Multiplicity;
use crate::flow::{Caller, Cause, ControlFlowGraph, CycleKind, Effect, LoopId, NodeId, Place, Program};
use crate::index::{FunctionId, Index, Ty, ValueId};
use crate::source::Span;

/// A function with what is known of it.
pub(super) struct FunctionFacts<'a> {
    pub(super) graph: &'a ControlFlowGraph,
    pub(super) aliases: Aliases,
    pub(super) dependence: ControlDependence,
    pub(super) handles: Handles,
    /// The cycles of each instance that the function updates.
    pub(super) updated: Vec<Instance>,
    pub(super) kind: FunctionKind,
    /// Whether some cycle runs it.
    pub(super) is_in_cycle: bool,
    /// The text of its body.
    pub(super) body: Span,
}

/// Decides every pair of cycle and filter.
#[must_use]
pub fn analyse(program: &Program<'_>, graphs: &mut [Option<ControlFlowGraph>]) -> Analysis {
    super::conditions::hand_up(graphs);
    super::handed_in::hand_up(program.index, graphs);
    dispatched::mark(program.index, graphs);
    let graphs = &*graphs;
    let few = analyse_with(program, graphs, Answering::of(program, graphs));
    few.unwrap_or_else(|| analyse_with(program, graphs, Answering::default()).unwrap_or_default())
}

/// The same, where it is told of which functions the answers matter; nothing if these turn out to be too few.
fn analyse_with(program: &Program<'_>, graphs: &[Option<ControlFlowGraph>], answering: Answering) -> Option<Analysis> {
    let summaries = Summaries::compute(program, graphs, answering);
    let called = called_functions(program.index, graphs);
    let in_cycle = reached_from_cycles(program, graphs, &summaries, &called);
    // What is written is judged once, and the loops of its instances for the types that are known.
    let is_written = |graph: &&ControlFlowGraph| program.index.origin(graph.function) == graph.function;
    let (written, copies): (Vec<&ControlFlowGraph>, Vec<_>) = graphs.iter().flatten().partition(is_written);
    let copies = copies.into_iter().filter(|graph| generic_cycles::has_cycles(graph));
    let judged: Vec<&ControlFlowGraph> = written.into_iter().chain(copies).collect();
    let facts = program.cores.deeply(judged.len(), |at| {
        let kind = function_kind(program, judged[at], &summaries, &called);
        function_facts(program, judged[at], &summaries, kind, &in_cycle)
    });
    let fields = updated_fields(program, &facts, &in_cycle, graphs);
    let anywhere = touched_fields(program.index, &facts);
    let statics = touched_statics(&summaries, &facts);
    let lent = Lent::of(program.index, &summaries, &facts);
    let joined = Joined::of(program.index, &facts);
    let waiting = super::remarks::waiting(program, graphs);
    let steps = Steps::of(program, graphs);
    let facts: Vec<Mutex<FunctionFacts<'_>>> = facts.into_iter().map(Mutex::new).collect();
    let parts = program.cores.deeply(facts.len(), |at| {
        let mut analysis = Analysis::default();
        // Each is taken once.
        let Ok(function) = facts[at].lock() else { return analysis };
        if function.kind != FunctionKind::Outside {
            let context = Context {
                program,
                summaries: &summaries,
                fields: &fields,
                anywhere: &anywhere,
                statics: &statics,
                lent: &lent,
                joined: &joined,
                waiting: &waiting,
                steps: &steps,
                effort: Effort::default(),
            };
            context.function(&function, &mut analysis);
        }
        analysis
    });
    if summaries.answering.is_too_few() {
        return None;
    }
    let mut analysis = Analysis::default();
    let mut of_instances: BTreeMap<FunctionId, Vec<Cycle>> = BTreeMap::new();
    for (graph, part) in judged.iter().zip(parts) {
        if is_written(graph) {
            analysis.add(part);
        } else {
            let cycles = of_instances.entry(program.index.origin(graph.function)).or_default();
            generic_cycles::merge(cycles, part.cycles, false);
        }
    }
    generic_cycles::merge_all(program.index, graphs, &mut analysis.cycles, of_instances);
    analysis.cycles.sort_by_key(|cycle| (cycle.head, cycle.package, cycle.target));
    Some(analysis)
}

/// The filters that are or lie at a place.
pub(super) fn filters_at(index: &Index, graph: &ControlFlowGraph, aliases: &Aliases, place: &Place) -> Vec<Place> {
    let roots = aliases.roots(place).into_iter();
    let of_root = |root: Place| {
        let ty = place_ty(index, graph, &root);
        let found = ty.map(|ty| leaves(index, &ty)).unwrap_or_default().into_iter();
        found.map(|leaf| root.join(&leaf.steps)).collect::<Vec<_>>()
    };
    roots.flat_map(of_root).collect()
}

/// The filter whose law a function is: that the law runs another form of itself is a part of the one update.
pub(super) fn own_filter(index: &Index, graph: &ControlFlowGraph) -> Option<Place> {
    let number = if is_law(index, graph.function) { Some(0) } else { index.state_parameter(graph.function) };
    graph.params.get(number?).copied().map(Place::var)
}

/// Whether updates that are seen run in a cycle, and not in a closure of it that something unseen calls.
fn is_run(search: &Search<'_>, id: CycleId) -> bool {
    let graph = search.graph;
    search.updating().into_iter().any(|at| match id {
        CycleId::Loop(id) => graph.loops_around(at).any(|around| around == id),
        CycleId::Function => !graph.loops_around(at).any(|around| graph.loop_info(around).is_unseen()),
    })
}

/// Whether a place is a variable of a function that was inlined here, where it is judged.
fn is_of_another(facts: &FunctionFacts<'_>, place: &Place) -> bool {
    place.base_var().is_some_and(|var| {
        let info = facts.graph.var(var);
        info.param.is_none() && !facts.body.contains(info.span)
    })
}

/// Whether only a debug build has the variable in which a filter lives.
pub(super) fn is_debug_only(graph: &ControlFlowGraph, place: &Place) -> bool {
    place.base_var().is_some_and(|var| {
        let info = graph.var(var);
        info.param.is_none() && graph.node(info.declared).debug_only.is_some()
    })
}

pub(super) struct Context<'a> {
    pub(super) program: &'a Program<'a>,
    pub(super) summaries: &'a Summaries,
    /// Fields that some cycle updates, with the halves of the law.
    pub(super) fields: &'a Fields,
    /// Fields that are handed to something unseen.
    pub(super) anywhere: &'a Fields,
    /// Statics with filters that some code updates, or lends to where it may be updated.
    pub(super) statics: &'a BTreeSet<ValueId>,
    /// What functions are lent that others update.
    pub(super) lent: &'a Lent,
    /// Parts of types that may lead to one filter.
    pub(super) joined: &'a Joined,
    /// Functions that make their callers wait.
    pub(super) waiting: &'a Waiting,
    /// The constant steps with which filters are made.
    pub(super) steps: &'a Steps,
    /// How much was looked at in the function at hand.
    pub(super) effort: Effort,
}

/// A cycle of a function.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum CycleId {
    Loop(LoopId),
    Function,
}

impl Context<'_> {
    fn function(&self, facts: &FunctionFacts<'_>, analysis: &mut Analysis) {
        let graph = facts.graph;
        let index = self.program.index;
        let mut pairs: BTreeMap<CycleId, Vec<Pair>> = BTreeMap::new();
        for instance in &facts.updated {
            let search = self.search(facts, instance);
            let is_own = |id: &&LoopId| {
                let info = graph.loop_info(**id);
                info.cycle_head().is_some() && !(info.is_foreign && is_of_another(facts, &instance.place))
            };
            let loops = instance.loops.iter().filter(is_own).map(|id| CycleId::Loop(*id));
            let decide = |id: CycleId| {
                let pair = self.decide(facts, instance, &search, id)?;
                (!is_told_by_outer(index, facts, instance, &pair)).then_some((id, pair))
            };
            let decided = loops.chain(instance.function.then_some(CycleId::Function)).filter_map(decide).collect();
            let is_elsewhere = || self.fields.has_elsewhere(index, graph, &instance.place, instance.law);
            for (id, pair) in missed::without_those_of_others(&instance.place, decided, is_elsewhere) {
                pairs.entry(id).or_default().push(pair);
            }
        }
        handles::settle(self, facts, &mut pairs);
        self.owed_elements(facts, &mut pairs);
        self.owed_halves(facts, &mut pairs);
        self.owed(facts, &mut pairs, analysis);
        unknown_references::settle(self, facts, &mut pairs);
        super::guards::add(self, facts, &mut pairs, analysis);
        super::remarks::add(self, facts, &mut pairs, analysis);
        super::parts::leave_to_whole(&mut pairs);
        let def = index.function(graph.function);
        let info = index.crate_of(def.module);
        let is_silent = facts.kind == FunctionKind::Presumed && !pairs.contains_key(&CycleId::Function);
        if is_silent && facts.updated.iter().any(|instance| instance.function) {
            analysis.presumed.push(Presumed { package: info.package, target: info.target, head: def.function.keyword });
        }
        for (id, mut filters) in pairs {
            filters.sort_by(|left, right| (&left.name, &left.law).cmp(&(&right.name, &right.law)));
            let head = match id {
                CycleId::Loop(id) => graph.loop_info(id).cycle_head(),
                CycleId::Function => Some((def.function.keyword, CycleKind::Function)),
            };
            let Some((head, kind)) = head else { continue };
            let cycle = Cycle {
                package: info.package,
                target: info.target,
                head,
                kind,
                is_presumed: id == CycleId::Function && facts.kind == FunctionKind::Presumed,
                function: index.function_name(graph.function),
                period: super::remarks::period(facts, id),
                filters,
            };
            // A closure that is called in several places is one cycle.
            match kind {
                CycleKind::Closure => generic_cycles::merge(&mut analysis.cycles, vec![cycle], false),
                _ => analysis.cycles.push(cycle),
            }
        }
    }

    /// The search for the updates of an instance.
    pub(super) fn search<'s>(&'s self, facts: &'s FunctionFacts<'_>, instance: &'s Instance) -> Search<'s> {
        let dependence = &facts.dependence;
        let (place, law) = (&instance.place, instance.law);
        let mut search =
            Search::with_dependence(self.program, facts.graph, &facts.aliases, self.summaries, place, law, dependence);
        search.sample_loops.clone_from(&instance.sample_loops);
        search
    }

    fn decide(&self, facts: &FunctionFacts<'_>, instance: &Instance, search: &Search<'_>, id: CycleId) -> Option<Pair> {
        let graph = facts.graph;
        let region = match id {
            CycleId::Loop(id) => Region::Loop(id),
            CycleId::Function => Region::Function,
        };
        let presumed = match id {
            CycleId::Loop(id) => graph.loop_info(id).is_unseen(),
            CycleId::Function => facts.kind == FunctionKind::Presumed,
        };
        let by_framework = id == CycleId::Function && facts.kind == FunctionKind::Cycle;
        let decision = if let Some(cause) = self.limit(facts) {
            Decision::unproved(cause)
        } else if search.updating().is_empty() && search.unknown().is_empty() {
            // Only a debug build updates it.
            let head = match id {
                CycleId::Loop(id) => graph.loop_info(id).keyword,
                CycleId::Function => self.program.index.function(graph.function).function.keyword,
            };
            missed::decide_missed(search, region, head)
        } else {
            self.decide_behind(facts, instance, search, |search| decide::decide(search, region, by_framework))
        };
        self.effort.add(graph.nodes.len() / 8 + search.take_states());
        // How often a round of the code around the calls of a kept closure updates it, this closure alone does not tell.
        let is_kept = matches!(id, CycleId::Loop(id) if graph.loop_info(id).caller == Caller::Keeper);
        let is_sample_loop = matches!(id, CycleId::Loop(id) if instance.sample_loops.contains(&id));
        let decision = self.by_multiplicity(facts, search, decision);
        let decision = match decision.verdict {
            // A function that never comes to its end is called once at most.
            _ if presumed && decision.counts.is_empty() && decision.verdict != Verdict::Repeated => return None,
            Verdict::Once | Verdict::Guarded if is_kept => return None,
            Verdict::Once if is_sample_loop => samples::of_loop(search, region, decision),
            Verdict::Once | Verdict::Guarded | Verdict::Repeated => decision,
            // What only may be a cycle owes nothing.
            Verdict::Missed if presumed => return None,
            _ if presumed && (is_kept || !is_run(search, id)) => return None,
            Verdict::Skipped if presumed => {
                let caller = match id {
                    CycleId::Loop(_) => "what calls the closure is not read".to_owned(),
                    CycleId::Function => {
                        format!("nothing that is read calls `{}`", self.program.index.function_name(graph.function))
                    }
                };
                let cause = Cause::Limit(format!("{caller}, and whether one call is one cycle is not known"));
                Decision { counts: decision.counts, law: decision.law, ..Decision::unproved(cause) }
            }
            Verdict::Missed => missed::with_dropped(search, decision),
            _ => decision,
        };
        let is_here = |at: &NodeId| match id {
            CycleId::Loop(id) => graph.loops_around(*at).any(|around| around == id),
            CycleId::Function => true,
        };
        let updates = search.updating().into_iter().filter(is_here).map(|at| graph.node(at).span).collect();
        Some(Pair { updates, ..self.pair(facts, &instance.place, instance.law, decision) })
    }

    /// A half that need not run is never skipped, and one that may run as often as one likes is never wrong.
    fn by_multiplicity(&self, facts: &FunctionFacts<'_>, search: &Search<'_>, decision: Decision) -> Decision {
        let may_skip = match self.multiplicity(facts, search.instance, search.law) {
            Multiplicity::Once => return decision,
            Multiplicity::AtMostOnce => matches!(decision.verdict, Verdict::Skipped | Verdict::Gated | Verdict::Missed),
            Multiplicity::Any => !matches!(decision.verdict, Verdict::Unproved | Verdict::Guarded),
        };
        if !may_skip {
            return Decision { skips: false, ..decision };
        }
        let is_by_guard = |at: NodeId| match &search.graph.node(at).effect {
            Effect::Update(update) => update.run_by.is_guard(),
            Effect::GuardEnd(_) => true,
            _ => false,
        };
        let mut updating = search.updating().into_iter().peekable();
        let is_guarded = updating.peek().is_some() && updating.all(is_by_guard);
        let verdict = if is_guarded { Verdict::Guarded } else { Verdict::Once };
        Decision { verdict, gate: None, witness: Vec::new(), primary: None, ..decision }
    }

    /// How often a half of the law of the filter at a place may run in a cycle.
    pub(super) fn multiplicity(&self, facts: &FunctionFacts<'_>, place: &Place, law: usize) -> Multiplicity {
        let index = self.program.index;
        let by_type = place_ty(index, facts.graph, place).and_then(|ty| {
            let spec = index.filter_spec(&ty).or_else(|| index.returned_spec(&ty))?;
            Some(spec.law.get(law)?.multiplicity)
        });
        by_type.unwrap_or(Multiplicity::Once)
    }

    pub(super) fn pair(&self, facts: &FunctionFacts<'_>, place: &Place, law: usize, decision: Decision) -> Pair {
        let index = self.program.index;
        let decision = decision.unless_own_affair(index, facts.graph.function);
        let ty = place_ty(index, facts.graph, place).unwrap_or(Ty::Unknown);
        let of_half = || {
            let behind = super::behind::types_behind(index, facts.graph, place);
            // A wrapper that is not read is told by the law of what it has.
            let content = match &ty {
                Ty::External(_, args) => args.as_slice(),
                _ => &[],
            };
            let mut types = [&ty].into_iter().chain(&behind).chain(content.iter().map(Ty::peel));
            let spec = types.find_map(|ty| index.filter_spec(ty).or_else(|| index.returned_spec(ty)));
            spec.unwrap_or(index.trait_spec()).name_of(law, decision.law.as_deref()).unwrap_or_default()
        };
        Pair {
            name: facts.graph.place_name(index, place),
            filter_type: index.type_name(&ty),
            law: of_half(),
            half: law,
            verdict: decision.verdict,
            counts: decision.counts,
            gate: decision.gate,
            rules: decision.verdict.rule().into_iter().collect(),
            left_out: Vec::new(),
            cause: decision.cause.map(|cause| cause.to_string()),
            witness: decision.witness,
            primary: decision.primary,
            through: decision.through.into_iter().collect(),
            others: decision.others,
            skips: decision.skips,
            updates: Vec::new(),
            suppressed: None,
            known: false,
        }
    }
}
