//! What changes between two calls of a function inside a cycle. A field that no sample of a block changes is no setting where the cycle that
//! brings the blocks gives it another value: `loop { if let Ok(on) = switch.try_recv() { self.is_on = on; } self.process(&adc.read()); }`.

use std::collections::BTreeSet;

use rustc_hash::FxHashMap;

use super::callgraph::callees;
use super::functions::is_run_as_cycle;
use super::instances::place_ty;
use crate::flow::{Argument, ControlFlowGraph, Effect, LoopId, NodeId, Place, Program, Projection, Rounds};
use crate::index::{FunctionId, Index, Ty, TypeId};

/// The field of a type.
type Field = (TypeId, String);

/// The cycles that call functions with loops over samples, and the fields that are written there.
#[derive(Debug, Default)]
pub(super) struct Between {
    cycles: Vec<Cycle>,
    /// The cycles in which a function runs.
    around: FxHashMap<FunctionId, Vec<usize>>,
    /// The functions that write a field of what they are given.
    writers: FxHashMap<Field, Vec<FunctionId>>,
}

#[derive(Debug)]
struct Cycle {
    /// The function that it is, or lies in.
    function: FunctionId,
    /// What it writes itself.
    written: BTreeSet<Field>,
    /// All functions that it calls, in order.
    called: Vec<FunctionId>,
    /// The functions with loops that it calls itself, each with the number of an argument that is another value in each iteration.
    anew: BTreeSet<(FunctionId, usize)>,
}

impl Between {
    pub(super) fn of(program: &Program<'_>, graphs: &[Option<ControlFlowGraph>]) -> Self {
        let index = program.index;
        let mut found = Self::default();
        let has_rounds = |graph: &&ControlFlowGraph| graph.loops.iter().any(|info| info.rounds != Rounds::Unbounded);
        let with_rounds = graphs.iter().flatten().filter(has_rounds).map(|graph| index.origin(graph.function));
        let with_rounds: BTreeSet<FunctionId> = with_rounds.collect();
        for graph in graphs.iter().flatten() {
            for field in
                graph.node_ids().filter_map(|id| field_written(index, graph, id, &|place| is_lent(graph, place)))
            {
                found.writers.entry(field).or_default().push(graph.function);
            }
        }
        let is_looked_at = |graph: &&ControlFlowGraph| {
            let def = index.function(graph.function);
            !def.is_test && !index.crate_of(def.module).is_test
        };
        for graph in graphs.iter().flatten().filter(is_looked_at) {
            let is_cycle = |id: &LoopId| graph.loop_info(*id).may_be_cycle();
            let loops = (0u32..).take(graph.loops.len()).map(LoopId).filter(is_cycle).map(Some);
            for region in loops.chain(is_run_as_cycle(program, graph.function).then_some(None)) {
                found.add(index, graphs, graph, region, &with_rounds);
            }
        }
        found
    }

    fn add(
        &mut self,
        index: &Index,
        graphs: &[Option<ControlFlowGraph>],
        graph: &ControlFlowGraph,
        region: Option<LoopId>,
        with_rounds: &BTreeSet<FunctionId>,
    ) {
        let is_inside = |id: &NodeId| region.is_none_or(|own| graph.is_within(graph.node(*id).in_loop, own));
        let called = |id: NodeId| match &graph.node(id).effect {
            Effect::Call(site) => site.targets.clone(),
            _ => Vec::new(),
        };
        let mut open: Vec<FunctionId> = graph.node_ids().filter(is_inside).flat_map(called).collect();
        let mut reached: BTreeSet<FunctionId> = BTreeSet::new();
        while let Some(id) = open.pop() {
            if reached.insert(id)
                && let Some(callee) = &graphs[id.0 as usize]
            {
                let further = callees(callee).into_iter();
                open.extend(further.map(|callee| FunctionId(u32::try_from(callee).unwrap_or(u32::MAX))));
            }
        }
        let inside = reached.iter().map(|id| index.origin(*id)).filter(|id| with_rounds.contains(id));
        let inside: BTreeSet<FunctionId> = inside.collect();
        if inside.is_empty() {
            return;
        }
        // What is made in the iteration is made anew.
        let lasts = |place: &Place| match (place.base_var(), region) {
            (Some(var), Some(own)) => !graph.is_within(graph.var(var).in_loop, own) || is_lent(graph, place),
            _ => is_lent(graph, place),
        };
        let nodes = graph.node_ids().filter(is_inside);
        let written = nodes.filter_map(|id| field_written(index, graph, id, &lasts)).collect();
        for id in inside {
            self.around.entry(id).or_default().push(self.cycles.len());
        }
        let calls_rounds = |id: &NodeId| called(*id).iter().any(|target| with_rounds.contains(&index.origin(*target)));
        let nodes = graph.node_ids().filter(is_inside).filter(calls_rounds);
        let anew = nodes.flat_map(|id| given_anew(graph, id, region));
        let anew = anew.map(|(function, number)| (index.origin(function), number)).collect();
        self.cycles.push(Cycle { function: graph.function, written, called: reached.into_iter().collect(), anew });
    }

    /// A function that a cycle around the calls of another one runs, or is, and that writes a place which that is given, or what it is a
    /// part of.
    pub(super) fn writer(&self, index: &Index, graph: &ControlFlowGraph, place: &Place) -> Option<FunctionId> {
        let own = index.origin(graph.function);
        let around = self.around.get(&own)?;
        let param = place.base_var().filter(|_| place.steps.is_empty()).and_then(|var| graph.var(var).param);
        if let Some(number) = param {
            let mut cycles = around.iter().map(|cycle| &self.cycles[*cycle]);
            return cycles.find(|cycle| cycle.anew.contains(&(own, number))).map(|cycle| cycle.function);
        }
        let parts = (1..=place.steps.len()).map(|count| place.up_to(count));
        let fields: Vec<Field> = parts.filter_map(|part| field_of(index, graph, &part)).collect();
        fields.iter().find_map(|field| {
            let writers = self.writers.get(field).map_or(&[][..], Vec::as_slice);
            around.iter().find_map(|number| {
                let cycle = &self.cycles[*number];
                let is_called = |function: &&FunctionId| cycle.called.binary_search(function).is_ok();
                let by_itself = cycle.written.contains(field).then_some(cycle.function);
                by_itself.or_else(|| writers.iter().find(is_called).copied())
            })
        })
    }
}

/// The arguments of a call that are other values in each iteration: what the iteration asks something for, what it assigns, and what a
/// function is called with that is the cycle.
fn given_anew(graph: &ControlFlowGraph, at: NodeId, region: Option<LoopId>) -> Vec<(FunctionId, usize)> {
    let Effect::Call(site) = &graph.node(at).effect else { return Vec::new() };
    let is_inside = |id: &NodeId| region.is_none_or(|own| graph.is_within(graph.node(*id).in_loop, own));
    let asks = |calls: &[String]| calls.iter().any(|name| name != "clone");
    let is_assigned = |place: &Place| {
        graph.node_ids().filter(is_inside).any(
            |id| matches!(&graph.node(id).effect, Effect::Write(write) | Effect::Set(write) if write.place == *place),
        )
    };
    let is_anew = |place: &Place| {
        let Some(var) = place.base_var().filter(|_| place.steps.is_empty()) else { return false };
        let info = graph.var(var);
        let lasts = region.is_some_and(|own| !graph.is_within(info.in_loop, own));
        let is_given = || info.param.is_some() && info.name != "self" && !matches!(info.ty, Ty::Ref(..));
        let is_asked_for = || graph.computed.get(&var).is_some_and(|computed| asks(&computed.calls));
        if lasts { is_assigned(place) } else { is_given() || is_asked_for() }
    };
    let is_of_iteration = |arg: &Argument| {
        let is_constant = arg.head.is_some() || arg.is_setting;
        !is_constant && (asks(&arg.from.calls) || arg.value_of.iter().chain(&arg.from.places).any(is_anew))
    };
    let numbers = site.args.iter().enumerate().filter(|(_, arg)| is_of_iteration(arg)).map(|(number, _)| number);
    numbers.flat_map(|number| site.targets.iter().map(move |target| (*target, number))).collect()
}

/// Whether a place is the caller's, or lies behind a reference.
fn is_lent(graph: &ControlFlowGraph, place: &Place) -> bool {
    place.base_var().is_none_or(|var| {
        let info = graph.var(var);
        info.param.is_some() || matches!(info.ty, Ty::Ref(..))
    })
}

fn field_written(index: &Index, graph: &ControlFlowGraph, id: NodeId, lasts: &dyn Fn(&Place) -> bool) -> Option<Field> {
    let Effect::Write(write) = &graph.node(id).effect else { return None };
    field_of(index, graph, &write.place).filter(|_| !write.rebinds && lasts(&write.place))
}

fn field_of(index: &Index, graph: &ControlFlowGraph, place: &Place) -> Option<Field> {
    let Some((Projection::Field(name), owner)) = place.steps.split_last() else { return None };
    let owner = place_ty(index, graph, &Place { base: place.base, steps: owner.into() })?;
    match owner.peel() {
        Ty::Adt(id, _) => Some((*id, name.to_string())),
        _ => None,
    }
}
