//! Which cycles there are, which filters each of them updates or owes an update, and what is decided for each pair.

use std::collections::{BTreeMap, BTreeSet};
use std::rc::Rc;

use super::aliases::Aliases;
use super::counts::Count;
use super::decide::{self, Decision};
use super::instances::{self, leaves, place_ty, settle_elements};
use super::search::{Region, Search};
use super::slice::ControlDependence;
use super::summary::{Summaries, place_of};
use super::verdict::{Cycle, Pair, Verdict};
use crate::flow::{
    Base, ControlFlowGraph, CycleKind, Directive, Effect, LoopId, NodeId, Place, Program, Projection, Rounds, Var,
};
use crate::index::{FunctionId, Index, Owner, Ty, TypeId};
use crate::source::Span;
use crate::syntax::tree::Receiver;

/// What the analysis found out about a workspace.
#[derive(Debug, Default)]
pub struct Analysis {
    /// The cycles with their pairs.
    pub cycles: Vec<Cycle>,
    /// Filters that no cycle has to do with and that nothing updates.
    pub unregistered: Vec<Unregistered>,
    /// Guards that do not do what they are there for.
    pub guards: Vec<GuardDefect>,
}

/// A filter that is built and then neither registered, updated, moved nor returned.
#[derive(Clone, Debug)]
pub struct Unregistered {
    /// Index into the project's packages.
    pub package: usize,
    /// Index into the package's targets.
    pub target: usize,
    /// The name of the variable.
    pub name: String,
    /// The name of its type.
    pub filter_type: String,
    /// Where it is built.
    pub span: Span,
    /// The function.
    pub function: String,
    /// The cycle that is there beside it, if there is one.
    pub cycle: Option<Span>,
}

/// What is wrong with a guard.
#[derive(Clone, Debug)]
pub struct GuardDefect {
    /// Index into the project's packages.
    pub package: usize,
    /// Index into the package's targets.
    pub target: usize,
    /// The rule: `guard_outside_cycle`, `guard_dropped_early`, `forgotten_guard`.
    pub rule: &'static str,
    /// Where the guard is made.
    pub made: Span,
    /// Where it goes wrong.
    pub span: Span,
    /// What goes wrong there.
    pub what: String,
    /// What it guards, as far as it is known.
    pub names: Vec<String>,
    /// The function.
    pub function: String,
    /// The head of the cycle it belongs to.
    pub cycle: Option<Span>,
}

/// A function with what is known of it.
pub(super) struct FunctionFacts<'a> {
    pub(super) graph: &'a ControlFlowGraph,
    pub(super) aliases: Aliases,
    dependence: Rc<ControlDependence>,
    /// The cycles of each instance that the function updates.
    updated: Vec<Instance>,
    kind: FunctionKind,
}

/// An instance that a function updates, with its cycles.
struct Instance {
    place: Place,
    /// The loops that are its cycles.
    loops: BTreeSet<LoopId>,
    /// Whether the function itself is one.
    function: bool,
    /// Loops that are cycles of their own inside its cycles.
    sample_loops: BTreeSet<LoopId>,
}

/// What one call of a function is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum FunctionKind {
    /// One control cycle.
    Cycle,
    /// Perhaps one control cycle: only what is certainly wrong is said.
    Presumed,
    /// A part of whatever calls it.
    Helper,
    /// Nothing that is looked at: a test.
    Outside,
}

/// A field of a type, wherever a value of the type lives.
type FieldKey = (TypeId, String);

/// Decides every pair of cycle and filter.
#[must_use]
pub fn analyse(program: &Program<'_>, graphs: &[Option<ControlFlowGraph>]) -> Analysis {
    let summaries = Summaries::compute(program, graphs);
    let called = called_functions(program.index, graphs);
    let in_cycle = reached_from_cycles(program, graphs, &called);
    let mut facts = Vec::new();
    for graph in graphs.iter().flatten() {
        let kind = function_kind(program, graph, &called);
        facts.push(function_facts(program, graph, &summaries, kind, &in_cycle));
    }
    let fields = updated_fields(program.index, &facts, &in_cycle);
    let anywhere = touched_fields(program.index, &facts);
    let mut analysis = Analysis::default();
    for function in &facts {
        if function.kind == FunctionKind::Outside {
            continue;
        }
        let context = Context { program, summaries: &summaries, fields: &fields, anywhere: &anywhere };
        context.function(function, &in_cycle, &mut analysis);
    }
    analysis.cycles.sort_by_key(|cycle| (cycle.head, cycle.package, cycle.target));
    analysis
}

/// The functions that analysed code outside tests calls.
fn called_functions(index: &Index, graphs: &[Option<ControlFlowGraph>]) -> BTreeSet<FunctionId> {
    graphs
        .iter()
        .flatten()
        .filter(|graph| !is_outside(index, graph.function))
        .flat_map(|graph| {
            let own = graph.function;
            super::callgraph::callees(graph)
                .into_iter()
                .map(|callee| FunctionId(u32::try_from(callee).unwrap_or(u32::MAX)))
                .filter(move |callee| *callee != own)
        })
        .collect()
}

fn is_outside(index: &Index, id: FunctionId) -> bool {
    let def = index.function(id);
    def.is_test || index.crate_of(def.module).is_test
}

/// The functions that run inside some cycle: called from a loop, or from a function that is a cycle, at any depth.
fn reached_from_cycles(
    program: &Program<'_>,
    graphs: &[Option<ControlFlowGraph>],
    called: &BTreeSet<FunctionId>,
) -> BTreeSet<FunctionId> {
    let mut reached: BTreeSet<FunctionId> = BTreeSet::new();
    let mut open = Vec::new();
    for graph in graphs.iter().flatten() {
        let whole = matches!(function_kind(program, graph, called), FunctionKind::Cycle | FunctionKind::Presumed);
        for node in &graph.nodes {
            if let Effect::Call(site) = &node.effect
                && (whole || node.in_loop.is_some())
            {
                open.extend(site.targets.iter().copied());
            }
        }
    }
    while let Some(id) = open.pop() {
        if reached.insert(id)
            && let Some(graph) = &graphs[id.0 as usize]
        {
            open.extend(
                super::callgraph::callees(graph)
                    .into_iter()
                    .map(|callee| FunctionId(u32::try_from(callee).unwrap_or(u32::MAX))),
            );
        }
    }
    reached
}

/// What one call of a function is.
fn function_kind(program: &Program<'_>, graph: &ControlFlowGraph, called: &BTreeSet<FunctionId>) -> FunctionKind {
    let index = program.index;
    let id = graph.function;
    if is_outside(index, id) {
        return FunctionKind::Outside;
    }
    match Directive::at(program.sources, index.function(id).function.keyword) {
        Some(Directive::Cycle) => return FunctionKind::Cycle,
        Some(Directive::NotACycle) => return FunctionKind::Helper,
        None => {}
    }
    if is_cycle_function(index, id) {
        return FunctionKind::Cycle;
    }
    // A function with a loop that never ends is not called once per cycle.
    let is_endless = graph.loops.iter().any(|info| info.rounds == Rounds::Unbounded && !info.is_foreign);
    if called.contains(&id) || is_constructor(index, id) || index.function(id).name == "main" || is_endless {
        return FunctionKind::Helper;
    }
    FunctionKind::Presumed
}

/// Attributes of functions that a framework calls once per cycle.
const CYCLE_ATTRIBUTES: &[&str] = &["interrupt", "exception", "handler"];

/// Methods of traits that a framework calls once per cycle.
const CYCLE_METHODS: &[(&str, &str)] =
    &[("RealtimeFunctionality", "cycle"), ("CuTask", "process"), ("Future", "poll"), ("Iterator", "next")];

/// Whether a framework calls the function once per cycle, or it is the law of a filter that is made of filters.
fn is_cycle_function(index: &Index, id: FunctionId) -> bool {
    let def = index.function(id);
    let by_attribute = def.attributes.iter().any(|attribute| {
        let last = attribute.path.rsplit("::").next().unwrap_or("");
        // An `async` task runs a loop of its own.
        CYCLE_ATTRIBUTES.contains(&last) || (last == "task" && !def.function.is_async)
    });
    if by_attribute {
        return true;
    }
    let Owner::Impl(impl_id) = def.owner else { return false };
    let of_impl = index.impl_def(impl_id);
    if let Some(name) = &of_impl.implements {
        let trait_text = index.trait_text(name);
        if CYCLE_METHODS.iter().any(|(of, method)| *of == trait_text && *method == def.name) {
            return true;
        }
    }
    let is_law = index.filter_spec(&of_impl.self_ty).is_some_and(|spec| {
        let by_trait = of_impl.implements.as_ref().is_none_or(|name| index.is_filter_trait(name));
        by_trait && spec.law.iter().any(|group| group.methods.contains(&def.name))
    });
    is_law
}

fn is_constructor(index: &Index, id: FunctionId) -> bool {
    let def = index.function(id);
    def.function.receiver.is_none()
        && (matches!(def.name.as_str(), "new" | "default" | "init" | "build" | "create")
            || ["new_", "with_", "from_", "init_"].iter().any(|prefix| def.name.starts_with(prefix)))
}

fn function_facts<'a>(
    program: &Program<'a>,
    graph: &'a ControlFlowGraph,
    summaries: &Summaries,
    kind: FunctionKind,
    in_cycle: &BTreeSet<FunctionId>,
) -> FunctionFacts<'a> {
    let aliases = Aliases::of(graph, summaries);
    let dependence = Rc::new(ControlDependence::of(graph));
    let mut places: BTreeSet<Place> = BTreeSet::new();
    for node in &graph.nodes {
        match &node.effect {
            Effect::Update(update) => places.extend(aliases.roots(&update.place)),
            Effect::Call(site) => {
                for target in &site.targets {
                    let Some(summary) = summaries.get(*target) else { continue };
                    for (given, outcomes) in &summary.outcomes {
                        let updates =
                            outcomes.iter().any(|outcome| outcome.count != Count::Zero || outcome.unknown.is_some());
                        if updates && let Some(place) = place_of(given, site) {
                            places.extend(aliases.roots(&place));
                        }
                    }
                }
            }
            Effect::Unknown { places: unknown, .. } => {
                for root in unknown.iter().flat_map(|place| aliases.roots(place)) {
                    let Some(ty) = place_ty(program.index, graph, &root) else { continue };
                    places.extend(leaves(program.index, &ty).iter().map(|leaf| root.join(&leaf.steps)));
                }
            }
            _ => {}
        }
    }
    places.retain(|place| is_instance(program.index, graph, place));
    let places = settle_elements(program.index, graph, &places);
    let mut updated = Vec::new();
    for place in places {
        let search = Search::with_dependence(program, graph, &aliases, summaries, &place, 0, Rc::clone(&dependence));
        let instance = choose_cycles(graph, &aliases, summaries, &search, kind, in_cycle);
        updated.push(Instance { place: place.clone(), ..instance });
    }
    FunctionFacts { graph, aliases, dependence, updated, kind }
}

/// Whether a place can be judged as an instance of a filter.
fn is_instance(index: &Index, graph: &ControlFlowGraph, place: &Place) -> bool {
    let Some(ty) = place_ty(index, graph, place) else { return false };
    if index.filter_spec(&ty).is_none() {
        return false;
    }
    // What a map holds is never judged.
    let mut at = Place { base: place.base, steps: Vec::new() };
    for step in &place.steps {
        if matches!(step, Projection::Index(_))
            && place_ty(index, graph, &at)
                .is_some_and(|ty| ty.external_name().is_some_and(|name| name.ends_with("Map")))
        {
            return false;
        }
        at = at.join(std::slice::from_ref(step));
    }
    match place.base {
        Base::Static(_) => true,
        Base::Var(var) => {
            let info = graph.var(var);
            // A value in between that has no name in the source is no instance that a user could be told about.
            !info.name.is_empty() || info.param.is_some()
        }
    }
}

/// The cycles of an instance among the loops around its updates.
fn choose_cycles(
    graph: &ControlFlowGraph,
    aliases: &Aliases,
    summaries: &Summaries,
    search: &Search<'_>,
    kind: FunctionKind,
    in_cycle: &BTreeSet<FunctionId>,
) -> Instance {
    let declared = search.instance.base_var().and_then(|var| graph.var(var).in_loop);
    let is_helper = in_cycle.contains(&graph.function);
    let mut chosen: Vec<(NodeId, Option<LoopId>)> = Vec::new();
    let mut sample_loops = BTreeSet::new();
    let mut nodes = search.updating();
    if nodes.is_empty() {
        nodes = search.unknown();
    }
    for node in nodes {
        let mut around: Vec<LoopId> = Vec::new();
        for id in graph.loops_around(node) {
            // A loop in whose body the instance is made is no cycle of it, nor is one around that.
            if Some(id) == declared {
                break;
            }
            around.push(id);
        }
        around.retain(|id| !search.binds(*id) && graph.loop_info(*id).directive != Some(Directive::NotACycle));
        chosen
            .push((node, choose(graph, aliases, summaries, search, node, &around, kind, is_helper, &mut sample_loops)));
    }
    let loops: BTreeSet<LoopId> = chosen.iter().filter_map(|(_, id)| *id).collect();
    // Where updates sit at two depths, the cycle is the innermost loop that holds them all.
    let outer: BTreeSet<LoopId> = loops
        .iter()
        .filter(|id| {
            !loops.iter().any(|other| {
                other != *id
                    && graph.is_within(Some(**id), *other)
                    && chosen
                        .iter()
                        .any(|(node, own)| *own == Some(*other) && !graph.is_within(graph.node(*node).in_loop, **id))
            })
        })
        .copied()
        .collect();
    let made_here = declared.is_some() || search.instance.base_var().is_some_and(|var| graph.var(var).param.is_none());
    let outside = chosen.iter().any(|(_, id)| id.is_none());
    let function = outside && !made_here && matches!(kind, FunctionKind::Cycle | FunctionKind::Presumed);
    Instance { place: search.instance.clone(), loops: outer, function, sample_loops }
}

/// The cycle of one update among the loops around it, innermost first.
#[expect(
    clippy::too_many_arguments,
    reason = "the choice depends on all of it, and a struct would be made for one call"
)]
fn choose(
    graph: &ControlFlowGraph,
    aliases: &Aliases,
    summaries: &Summaries,
    search: &Search<'_>,
    node: NodeId,
    around: &[LoopId],
    kind: FunctionKind,
    is_helper: bool,
    sample_loops: &mut BTreeSet<LoopId>,
) -> Option<LoopId> {
    let declared = |id: &&LoopId| graph.loop_info(**id).directive == Some(Directive::Cycle);
    if let Some(id) = around.iter().find(declared) {
        return Some(*id);
    }
    let unbounded = around.iter().position(|id| graph.loop_info(*id).rounds == Rounds::Unbounded);
    // A loop over samples that are fed to the instance is its cycle, inside whatever else is one.
    let inner = &around[..unbounded.unwrap_or(around.len())];
    for id in inner {
        if feeds(graph, aliases, summaries, search, node, *id) {
            let is_nested = around.iter().any(|other| other != id && graph.is_within(Some(*id), *other));
            if is_nested || is_helper || kind == FunctionKind::Cycle {
                sample_loops.insert(*id);
            }
            return Some(*id);
        }
    }
    if let Some(at) = unbounded {
        return Some(around[at]);
    }
    if kind == FunctionKind::Cycle {
        // In a function that is a cycle, an inner loop multiplies.
        return None;
    }
    let first = around.first().copied()?;
    if is_helper {
        // In a helper a loop of a known number of rounds multiplies; another one is a cycle of its own.
        let own = around.iter().find(|id| !matches!(graph.loop_info(**id).rounds, Rounds::Constant(_))).copied();
        if let Some(own) = own {
            sample_loops.insert(own);
        }
        return own;
    }
    Some(first)
}

/// Whether what a loop binds is fed to the instance at an update in it, or its result is combined with that.
fn feeds(
    graph: &ControlFlowGraph,
    aliases: &Aliases,
    summaries: &Summaries,
    search: &Search<'_>,
    node: NodeId,
    id: LoopId,
) -> bool {
    let info = graph.loop_info(id);
    if info.rounds == Rounds::Unbounded || info.bound.is_empty() {
        return false;
    }
    // A counter is no sample, but what it indexes is one.
    let mut bound = info.bound.clone();
    if let Some((counter, _)) = info.counter {
        bound.retain(|var| *var != counter && !aliases.is_derived(counter, &[*var]));
        let data = info.indexes.iter().filter(|collection| {
            !aliases
                .roots(collection)
                .iter()
                .any(|root| root.base == search.instance.base && root.overlaps(search.instance))
        });
        bound.extend(data.filter_map(Place::base_var));
    }
    let is_fed = |fed: &[Var], into: &[Var]| {
        fed.iter().any(|var| aliases.is_derived(*var, &bound))
            || bound.iter().any(|var| aliases.is_derived(*var, into) && !into.is_empty())
    };
    let at_update = match &graph.node(node).effect {
        Effect::Update(update) => is_fed(&update.fed, &update.into),
        Effect::Call(site) => is_fed(&site.fed, &site.into),
        _ => false,
    };
    at_update
        || graph.node_ids().any(|other| {
            graph.is_within(graph.node(other).in_loop, id)
                && match &graph.node(other).effect {
                    Effect::Call(site) => {
                        is_fed(&site.fed, &[])
                            && site.args.first().and_then(|arg| arg.place.as_ref()).is_some_and(|place| {
                                aliases.roots(place).iter().any(|root| root.overlaps(search.instance))
                            })
                            && site.targets.iter().any(|target| summaries.get(*target).is_some())
                    }
                    Effect::Write(write) => {
                        let into: Vec<Var> = write.place.base_var().into_iter().collect();
                        aliases.roots(&write.place).iter().any(|root| {
                            root.overlaps(search.instance) && root.steps.len() > search.instance.steps.len()
                        }) && into.iter().any(|var| aliases.is_derived(*var, &bound))
                    }
                    _ => false,
                }
        })
}

/// The fields of types that some cycle updates.
fn updated_fields(index: &Index, facts: &[FunctionFacts<'_>], in_cycle: &BTreeSet<FunctionId>) -> BTreeSet<FieldKey> {
    let mut found = BTreeSet::new();
    for function in facts {
        let whole = in_cycle.contains(&function.graph.function);
        for instance in &function.updated {
            if whole || instance.function || !instance.loops.is_empty() {
                found.extend(field_key(index, function.graph, &instance.place));
            }
        }
    }
    found
}

/// The fields of types that some code updates or hands to something unseen.
fn touched_fields(index: &Index, facts: &[FunctionFacts<'_>]) -> BTreeSet<FieldKey> {
    let mut found = BTreeSet::new();
    for function in facts.iter().filter(|function| function.kind != FunctionKind::Outside) {
        for node in &function.graph.nodes {
            let places: &[Place] = match &node.effect {
                Effect::Unknown { places, .. } => places,
                _ => &[],
            };
            for place in places {
                for root in function.aliases.roots(place) {
                    for leaf in place_ty(index, function.graph, &root).map(|ty| leaves(index, &ty)).unwrap_or_default()
                    {
                        found.extend(field_key(index, function.graph, &root.join(&leaf.steps)));
                    }
                }
            }
        }
    }
    found
}

/// The field that holds an instance, and the type it is a field of.
fn field_key(index: &Index, graph: &ControlFlowGraph, place: &Place) -> Option<FieldKey> {
    let at = place.steps.iter().rposition(|step| matches!(step, Projection::Field(_)))?;
    let Projection::Field(name) = &place.steps[at] else { return None };
    let owner = Place { base: place.base, steps: place.steps[..at].to_vec() };
    match place_ty(index, graph, &owner)? {
        Ty::Adt(id, _) => Some((id, name.to_string())),
        _ => None,
    }
}

struct Context<'a> {
    program: &'a Program<'a>,
    summaries: &'a Summaries,
    /// Fields that some cycle updates.
    fields: &'a BTreeSet<FieldKey>,
    /// Fields that are handed to something unseen.
    anywhere: &'a BTreeSet<FieldKey>,
}

/// A cycle of a function.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum CycleId {
    Loop(LoopId),
    Function,
}

impl Context<'_> {
    fn function(&self, facts: &FunctionFacts<'_>, in_cycle: &BTreeSet<FunctionId>, analysis: &mut Analysis) {
        let graph = facts.graph;
        let index = self.program.index;
        let mut pairs: BTreeMap<CycleId, Vec<Pair>> = BTreeMap::new();
        for instance in &facts.updated {
            for id in &instance.loops {
                if graph.loop_info(*id).is_foreign {
                    continue;
                }
                if let Some(pair) = self.decide(facts, instance, CycleId::Loop(*id), in_cycle) {
                    pairs.entry(CycleId::Loop(*id)).or_default().push(pair);
                }
            }
            if instance.function
                && let Some(pair) = self.decide(facts, instance, CycleId::Function, in_cycle)
            {
                pairs.entry(CycleId::Function).or_default().push(pair);
            }
        }
        self.owed_elements(facts, &mut pairs);
        self.owed(facts, &mut pairs, analysis);
        super::guards::defects(self.program, facts, analysis);
        let def = index.function(graph.function);
        let info = index.crate_of(def.module);
        for (id, mut filters) in pairs {
            filters.sort_by(|left, right| left.name.cmp(&right.name));
            let (head, kind) = match id {
                CycleId::Loop(id) => (graph.loop_info(id).keyword, graph.loop_info(id).kind),
                CycleId::Function => (def.function.keyword, CycleKind::Function),
            };
            analysis.cycles.push(Cycle {
                package: info.package,
                target: info.target,
                head,
                kind,
                function: index.function_name(graph.function),
                filters,
            });
        }
    }

    fn decide(
        &self,
        facts: &FunctionFacts<'_>,
        instance: &Instance,
        id: CycleId,
        in_cycle: &BTreeSet<FunctionId>,
    ) -> Option<Pair> {
        let graph = facts.graph;
        let mut search = Search::with_dependence(
            self.program,
            graph,
            &facts.aliases,
            self.summaries,
            &instance.place,
            0,
            Rc::clone(&facts.dependence),
        );
        search.sample_loops.clone_from(&instance.sample_loops);
        let region = match id {
            CycleId::Loop(id) => Region::Loop(id),
            CycleId::Function => Region::Function,
        };
        let presumed = id == CycleId::Function && facts.kind == FunctionKind::Presumed;
        let decision = decide::decide(&search, region, id == CycleId::Function && facts.kind == FunctionKind::Cycle);
        let is_sample_loop = matches!(id, CycleId::Loop(id) if instance.sample_loops.contains(&id));
        let _ = in_cycle;
        let decision = match decision.verdict {
            Verdict::Once if is_sample_loop => Decision { verdict: Verdict::PerSample, ..decision },
            Verdict::Once | Verdict::Guarded | Verdict::Repeated => decision,
            _ if presumed => return None,
            _ => decision,
        };
        Some(self.pair(facts, &instance.place, decision))
    }

    fn pair(&self, facts: &FunctionFacts<'_>, place: &Place, decision: Decision) -> Pair {
        let index = self.program.index;
        let ty = place_ty(index, facts.graph, place).unwrap_or(Ty::Unknown);
        let law = decision.law.clone().unwrap_or_else(|| "update".to_owned());
        Pair {
            name: facts.graph.place_name(index, place),
            filter_type: index.type_name(&ty),
            law,
            verdict: decision.verdict,
            counts: decision.counts,
            gate: decision.gate,
            rules: decision.verdict.rule().into_iter().collect(),
            cause: decision.cause.map(|cause| cause.to_string()),
            witness: decision.witness,
            primary: decision.primary,
            suppressed: None,
        }
    }

    /// Filters in scope that no cycle updates.
    fn owed(&self, facts: &FunctionFacts<'_>, pairs: &mut BTreeMap<CycleId, Vec<Pair>>, analysis: &mut Analysis) {
        let graph = facts.graph;
        let index = self.program.index;
        for (number, info) in (0u32..).zip(&graph.vars) {
            let var = Var(number);
            if info.name.is_empty() || !facts.aliases.roots(&Place::var(var)).contains(&Place::var(var)) {
                continue;
            }
            // What a reference points to is owed nothing here, unless a caller lends it.
            if matches!(info.ty, Ty::Ref(false, _)) || (matches!(info.ty, Ty::Ref(..)) && info.param.is_none()) {
                continue;
            }
            let of_self = info.param.is_some();
            // The law of a filter is not owed to the filter by its own methods, but to its parts.
            let is_own = of_self && info.name == "self" && index.filter_spec(&instances::inner(&info.ty)).is_some();
            let all = if is_own { instances::parts(index, &info.ty) } else { leaves(index, &info.ty) };
            for leaf in all {
                let place = Place::var(var).join(&leaf.steps);
                if facts.updated.iter().any(|instance| instance.place.overlaps(&place)) {
                    self.owed_after_all(facts, &place, pairs);
                    continue;
                }
                self.owed_instance(facts, var, &place, &leaf, pairs, analysis);
            }
        }
    }

    /// Elements of an array that no cycle updates while it updates others.
    fn owed_elements(&self, facts: &FunctionFacts<'_>, pairs: &mut BTreeMap<CycleId, Vec<Pair>>) {
        let in_collection = |place: &Place, other: &Place| {
            place.base == other.base
                && place.steps.len() == other.steps.len()
                && place.steps.iter().zip(&other.steps).all(|(left, right)| {
                    left == right || matches!((left, right), (Projection::Index(_), Projection::Index(_)))
                })
        };
        for instance in facts.updated.iter().filter(|instance| instance.loops.is_empty() && !instance.function) {
            let sibling = facts.updated.iter().find(|other| {
                (!other.loops.is_empty() || (other.function && facts.kind == FunctionKind::Cycle))
                    && in_collection(&instance.place, &other.place)
            });
            let Some(sibling) = sibling else { continue };
            match sibling.loops.first() {
                Some(id) => self.push_missed(facts, &instance.place, CycleId::Loop(*id), pairs),
                None => self.push_missed(facts, &instance.place, CycleId::Function, pairs),
            }
        }
    }

    /// An instance that is updated, but in no cycle, is owed an update by the cycle that uses it.
    fn owed_after_all(&self, facts: &FunctionFacts<'_>, place: &Place, pairs: &mut BTreeMap<CycleId, Vec<Pair>>) {
        let graph = facts.graph;
        let is_in_cycle = facts
            .updated
            .iter()
            .any(|instance| instance.place.overlaps(place) && (!instance.loops.is_empty() || instance.function));
        let elsewhere = field_key(self.program.index, graph, place).is_some_and(|key| self.fields.contains(&key));
        if is_in_cycle || elsewhere {
            return;
        }
        if let Some(id) = self.using_loop(facts, place) {
            self.push_missed(facts, place, CycleId::Loop(id), pairs);
        }
    }

    fn owed_instance(
        &self,
        facts: &FunctionFacts<'_>,
        var: Var,
        place: &Place,
        leaf: &instances::Leaf,
        pairs: &mut BTreeMap<CycleId, Vec<Pair>>,
        analysis: &mut Analysis,
    ) {
        let graph = facts.graph;
        let index = self.program.index;
        let info = graph.var(var);
        // What lies in a parameter or static may be updated elsewhere; what lies in a local is updated here or handed on.
        let is_local = info.param.is_none();
        let key = field_key(index, graph, place);
        if !is_local && key.as_ref().is_some_and(|key| self.fields.contains(key) || self.anywhere.contains(key)) {
            return;
        }
        let uses = self.uses(facts, place);
        if uses.leaves || leaf.is_uncertain {
            return;
        }
        // A cycle that updates a sibling owes this one an update, too.
        let scope = |id: CycleId| match id {
            CycleId::Loop(id) => {
                info.in_loop.is_none_or(|declared| declared != id && graph.is_within(Some(id), declared))
                    && (info.param.is_none() || leaf.steps.is_empty() || !leaf.steps.is_empty())
                    && self.is_declared_before(graph, var, id)
            }
            CycleId::Function => info.param.is_some() && facts.kind == FunctionKind::Cycle,
        };
        let is_param_itself = info.param.is_some() && leaf.steps.is_empty();
        let sibling = pairs
            .iter()
            .filter(|(id, filters)| {
                scope(**id)
                    && filters.iter().any(|pair| pair.verdict != Verdict::Missed)
                    && (!is_param_itself
                        || matches!(id, CycleId::Loop(id) if graph.loop_info(*id).rounds == Rounds::Unbounded))
                    && self.is_sibling(facts, place, **id)
            })
            .map(|(id, _)| *id)
            .next();
        if let Some(id) = sibling {
            self.push_missed(facts, place, id, pairs);
            return;
        }
        if let Some(id) = self.using_loop(facts, place).filter(|id| scope(CycleId::Loop(*id))) {
            self.push_missed(facts, place, CycleId::Loop(id), pairs);
            return;
        }
        if info.param.is_some() || !self.is_built_here(graph, var) {
            return;
        }
        // Its scope holds a loop that never ends.
        let endless = (0u32..).map(LoopId).zip(&graph.loops).find(|(id, own)| {
            own.rounds == Rounds::Unbounded
                && !own.is_foreign
                && own.directive != Some(Directive::NotACycle)
                && scope(CycleId::Loop(*id))
        });
        let is_local_filter = leaf.steps.is_empty();
        match endless {
            Some((id, _)) if !uses.written => self.push_missed(facts, place, CycleId::Loop(id), pairs),
            Some((id, _)) if is_local_filter => {
                self.push_unregistered(facts, var, place, Some(graph.loop_info(id).keyword), analysis);
            }
            None if is_local_filter => self.push_unregistered(facts, var, place, None, analysis),
            _ => {}
        }
    }

    /// Whether a cycle updates something in the same scope: a local of the function, or a field of the same value.
    fn is_sibling(&self, facts: &FunctionFacts<'_>, place: &Place, id: CycleId) -> bool {
        let graph = facts.graph;
        let is_local = |place: &Place| {
            place.base_var().is_some_and(|var| graph.var(var).param.is_none() || place.steps.is_empty())
        };
        facts.updated.iter().any(|instance| {
            let belongs = match id {
                CycleId::Loop(id) => instance.loops.contains(&id),
                CycleId::Function => instance.function,
            };
            belongs
                && ((instance.place.base == place.base && instance.place != *place)
                    || (is_local(&instance.place) && is_local(place)))
        })
    }

    fn is_declared_before(&self, graph: &ControlFlowGraph, var: Var, id: LoopId) -> bool {
        let info = graph.var(var);
        info.param.is_some() || info.declared < graph.loop_info(id).head
    }

    /// Whether a variable gets a value of its own in this function, not one that a closure or pattern was handed.
    fn is_built_here(&self, graph: &ControlFlowGraph, var: Var) -> bool {
        !matches!(graph.var(var).ty, Ty::Ref(..))
    }

    fn push_missed(
        &self,
        facts: &FunctionFacts<'_>,
        place: &Place,
        id: CycleId,
        pairs: &mut BTreeMap<CycleId, Vec<Pair>>,
    ) {
        let graph = facts.graph;
        let (head, function) = match id {
            CycleId::Loop(id) => {
                if graph.loop_info(id).is_foreign {
                    return;
                }
                (graph.loop_info(id).keyword, false)
            }
            CycleId::Function => (self.program.index.function(graph.function).function.keyword, true),
        };
        let place = match (place.stands_for_each(), function) {
            _ if pairs.get(&id).is_some_and(|filters| {
                let name = graph.place_name(self.program.index, place);
                filters.iter().any(|pair| pair.name == name)
            }) =>
            {
                return;
            }
            _ => place,
        };
        let decision = self.decide_unseen(facts, place, id, head);
        if let Some(decision) = decision {
            let pair = self.pair(facts, place, decision);
            pairs.entry(id).or_default().push(pair);
        }
    }

    /// A pair that nothing updates: missed, unless something unseen could.
    fn decide_unseen(&self, facts: &FunctionFacts<'_>, place: &Place, id: CycleId, head: Span) -> Option<Decision> {
        let search = Search::with_dependence(
            self.program,
            facts.graph,
            &facts.aliases,
            self.summaries,
            place,
            0,
            Rc::clone(&facts.dependence),
        );
        let region = match id {
            CycleId::Loop(id) => Region::Loop(id),
            CycleId::Function => Region::Function,
        };
        Some(decide::decide_missed(&search, region, head))
    }

    /// The loop that uses an instance and therefore owes it an update.
    fn using_loop(&self, facts: &FunctionFacts<'_>, place: &Place) -> Option<LoopId> {
        let graph = facts.graph;
        for id in graph.node_ids() {
            if !self.node_uses(facts, id, place) {
                continue;
            }
            let around = graph.loops_around(id).find(|id| {
                let info = graph.loop_info(*id);
                info.rounds == Rounds::Unbounded && !info.is_foreign && info.directive != Some(Directive::NotACycle)
            });
            if around.is_some() {
                return around;
            }
        }
        None
    }

    fn node_uses(&self, facts: &FunctionFacts<'_>, id: NodeId, place: &Place) -> bool {
        let touches =
            |other: &Place| {
                facts.aliases.roots(other).iter().any(|root| {
                    root.base == place.base && root.steps.len() >= place.steps.len() && root.overlaps(place)
                })
            };
        match &facts.graph.node(id).effect {
            Effect::Use { place } => touches(place),
            Effect::Call(site) => {
                site.args.iter().filter_map(|arg| arg.place.as_ref()).any(&touches)
                    || site.targets.iter().any(|target| {
                        self.summaries.get(*target).is_some_and(|summary| {
                            summary
                                .uses
                                .iter()
                                .chain(&summary.writes)
                                .any(|given| place_of(given, site).is_some_and(|place| touches(&place)))
                        })
                    })
            }
            Effect::Write(write) => touches(&write.place) && write.place != *place,
            _ => false,
        }
    }

    /// What the function does with an instance that it never updates.
    fn uses(&self, facts: &FunctionFacts<'_>, place: &Place) -> Uses {
        let mut uses = Uses::default();
        let holds = |other: &Place| facts.aliases.roots(other).iter().any(|root| root.overlaps(place));
        for node in &facts.graph.nodes {
            match &node.effect {
                Effect::Unknown { places, .. } => uses.leaves |= places.iter().any(&holds),
                Effect::Reset { place, .. } => uses.written |= holds(place),
                Effect::Write(write) => {
                    uses.written |= holds(&write.place);
                    uses.leaves |= write.from.as_ref().is_some_and(&holds) && write.by_move;
                }
                Effect::Set(set) => {
                    uses.leaves |= set.by_move
                        && set.from.as_ref().is_some_and(|from| {
                            facts.aliases.roots(from).iter().any(|root| {
                                root.base == place.base && root.steps.len() <= place.steps.len() && root.overlaps(place)
                            })
                        })
                        && set.place.base != place.base
                        && self.is_real_move(facts, &set.place);
                }
                Effect::Return(value) => uses.leaves |= value.place.as_ref().is_some_and(&holds),
                Effect::Use { place } => uses.read |= holds(place),
                Effect::Call(site) => {
                    for (number, arg) in site.args.iter().enumerate() {
                        let Some(own) = &arg.place else { continue };
                        if !holds(own) {
                            continue;
                        }
                        if self.takes_by_value(site, number) {
                            uses.leaves = true;
                        } else if arg.is_shared || self.reads_only(site, number) {
                            uses.read = true;
                        } else {
                            uses.fed = true;
                        }
                    }
                }
                _ => {}
            }
        }
        uses
    }

    /// Whether a variable that something is moved into has a name, or is a part of a new value.
    fn is_real_move(&self, facts: &FunctionFacts<'_>, place: &Place) -> bool {
        place.base_var().is_none_or(|var| !facts.graph.var(var).name.is_empty() || !place.steps.is_empty())
    }

    /// Whether every target of a call takes an argument by value.
    fn takes_by_value(&self, site: &crate::flow::CallSite, number: usize) -> bool {
        site.targets.iter().any(|target| {
            let function = &self.program.index.function(*target).function;
            match (&function.receiver, number) {
                (Some(Receiver::Value), 0) => true,
                (Some(_), 0) => false,
                (receiver, number) => {
                    let at = number - usize::from(receiver.is_some());
                    function
                        .params
                        .get(at)
                        .is_some_and(|ty| !matches!(ty, crate::syntax::tree::TypeRef::Reference { .. }))
                }
            }
        })
    }

    fn reads_only(&self, site: &crate::flow::CallSite, number: usize) -> bool {
        number == 0
            && site
                .targets
                .iter()
                .all(|target| self.program.index.function(*target).function.receiver == Some(Receiver::Shared))
    }

    fn push_unregistered(
        &self,
        facts: &FunctionFacts<'_>,
        var: Var,
        place: &Place,
        cycle: Option<Span>,
        analysis: &mut Analysis,
    ) {
        let index = self.program.index;
        let graph = facts.graph;
        let def = index.function(graph.function);
        let info = index.crate_of(def.module);
        let ty = place_ty(index, graph, place).unwrap_or(Ty::Unknown);
        analysis.unregistered.push(Unregistered {
            package: info.package,
            target: info.target,
            name: graph.place_name(index, place),
            filter_type: index.type_name(&ty),
            span: graph.var(var).span,
            function: index.function_name(graph.function),
            cycle,
        });
    }
}

/// What a function does with an instance.
#[derive(Clone, Copy, Debug, Default)]
struct Uses {
    /// It is moved, returned or handed to something unseen.
    leaves: bool,
    /// It is reset, or its state is written.
    written: bool,
    /// It is handed to a method that may change it.
    fed: bool,
    /// It is read.
    read: bool,
}
