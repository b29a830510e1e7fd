//! Which filters a cycle owes an update although no path of it updates them.

use std::collections::{BTreeMap, BTreeSet};

use super::analyse::{Context, CycleId, FunctionFacts};
use super::analysis::{Analysis, Unregistered};
use super::decide::Decision;
use super::fields::Fields;
use super::functions::FunctionKind;
use super::given::place_of;
use super::instances::{self, leaves, place_ty};
use super::other_handles::is_only_handle;
use super::search::{Region, Search};
use super::unreached::is_in_unreached_loop;
use super::verdict::{Pair, Verdict};
use super::witness::OF_COPY;
use super::{finished, missed, taken_out, uses};
use crate::config::Multiplicity;
use crate::diagnostic::WitnessStep;
use crate::flow::{ControlFlowGraph, Effect, LoopId, NodeId, Place, Rounds, Transfer, Var};
use crate::index::{Ty, ValueId};
use crate::source::Span;
use crate::syntax::CycleDirective;
use crate::syntax::tree::{Expr, ExprKind};

impl Context<'_> {
    /// Filters in scope that no cycle updates.
    pub(super) fn owed(
        &self,
        facts: &FunctionFacts<'_>,
        pairs: &mut BTreeMap<CycleId, Vec<Pair>>,
        analysis: &mut Analysis,
    ) {
        let graph = facts.graph;
        let index = self.program.index;
        for (number, info) in (0u32..).zip(&graph.vars) {
            let var = Var(number);
            if info.name.is_empty()
                || !index.holds_filter(&info.ty)
                || !facts.aliases.shared_roots(&Place::var(var)).contains(&Place::var(var))
            {
                continue;
            }
            // What a function that is read here keeps for itself is its own affair.
            let is_foreign = info.param.is_none() && !facts.body.contains(info.span);
            if is_foreign || super::analyse::is_debug_only(graph, &Place::var(var)) {
                continue;
            }
            // What a reference points to is owed nothing here, unless a caller lends it.
            if matches!(info.ty, Ty::Ref(..)) && info.param.is_none() {
                continue;
            }
            let is_shared = matches!(info.ty, Ty::Ref(false, _));
            let of_self = info.param.is_some();
            // The law of a filter is not owed to the filter by its own methods, but to its parts.
            let is_self = of_self && info.name == "self" && index.filter_spec(&instances::inner(&info.ty)).is_some();
            let is_own = is_self || super::analyse::own_filter(index, graph) == Some(Place::var(var));
            let all = if is_own {
                instances::parts(index, &info.ty)
            } else {
                instances::leaves_and_payloads(index, &info.ty)
            };
            for leaf in all.into_iter().filter(|leaf| !is_shared || leaf.is_in_cell) {
                let place = Place::var(var).join(&leaf.steps);
                // What was moved there and is known by its old name is judged under that.
                if !facts.aliases.shared_roots(&place).contains(&place) {
                    continue;
                }
                if facts.updated.iter().any(|instance| instance.place.overlaps(&place)) {
                    self.owed_after_all(facts, &place, pairs);
                    continue;
                }
                self.owed_instance(facts, Some(var), &place, &leaf, pairs, analysis);
            }
        }
        self.owed_statics(facts, pairs, analysis);
    }

    /// The other filters of a static of which this function updates one, and those of the statics that it uses and nothing updates.
    fn owed_statics(
        &self,
        facts: &FunctionFacts<'_>,
        pairs: &mut BTreeMap<CycleId, Vec<Pair>>,
        analysis: &mut Analysis,
    ) {
        let updated: BTreeSet<ValueId> =
            facts.updated.iter().filter_map(|instance| instance.place.base.value()).collect();
        let used = self.used_statics(facts).into_iter().filter(|id| !self.statics.contains(id));
        for id in updated.iter().copied().chain(used).collect::<BTreeSet<_>>() {
            let (index, whole, value) = (self.program.index, Place::of_static(id), self.program.index.value(id));
            let may_change = |leaf: &instances::Leaf| leaf.is_in_cell || value.item.is_mutable;
            let ty = match updated.contains(&id) {
                true => place_ty(index, facts.graph, &whole).unwrap_or(Ty::Unknown),
                false => index.lower(&value.item.ty, &index.scope(value.module, value.owner, None)),
            };
            let all = leaves(index, &ty).into_iter();
            for leaf in all.filter(|leaf| updated.contains(&id) || may_change(leaf)) {
                let place = whole.join(&leaf.steps);
                if !facts.updated.iter().any(|instance| instance.place.overlaps(&place)) {
                    self.owed_instance(facts, None, &place, &leaf, pairs, analysis);
                }
            }
        }
    }

    /// The statics that a function names, itself or in what it calls.
    fn used_statics(&self, facts: &FunctionFacts<'_>) -> BTreeSet<ValueId> {
        let mut found = BTreeSet::new();
        for node in &facts.graph.nodes {
            let places: Vec<Place> = match &node.effect {
                Effect::Use { place } => vec![place.clone()],
                Effect::Call(site) => {
                    let used = self.summaries.places(site, |callee| &callee.uses);
                    site.args.iter().filter_map(|arg| arg.place.clone()).chain(used).collect()
                }
                _ => continue,
            };
            for place in &places {
                found.extend(facts.aliases.shared_roots(place).iter().filter_map(|root| root.base.value()));
            }
        }
        found
    }

    /// Elements of an array that no cycle updates while it updates others.
    pub(super) fn owed_elements(&self, facts: &FunctionFacts<'_>, pairs: &mut BTreeMap<CycleId, Vec<Pair>>) {
        let in_collection = |place: &Place, other: &Place| {
            place.base == other.base
                && place.steps.len() == other.steps.len()
                && place
                    .steps
                    .iter()
                    .zip(other.steps.iter())
                    .all(|(left, right)| left == right || (left.key().is_some() && right.key().is_some()))
        };
        for instance in facts.updated.iter().filter(|instance| instance.loops.is_empty() && !instance.function) {
            let sibling = facts.updated.iter().find(|other| {
                (!other.loops.is_empty() || (other.function && facts.kind == FunctionKind::Cycle))
                    && other.law == instance.law
                    && other.place != instance.place
                    && in_collection(&instance.place, &other.place)
            });
            let is_owed = self.multiplicity(facts, &instance.place, instance.law) == Multiplicity::Once;
            let is_others =
                || self.is_spare(facts, &instance.place) || self.is_driven_elsewhere(facts, &instance.place);
            let Some(sibling) = sibling.filter(|_| is_owed && !is_others()) else { continue };
            match sibling.loops.first() {
                Some(id) => self.push_missed(facts, &instance.place, instance.law, CycleId::Loop(*id), pairs),
                None => self.push_missed(facts, &instance.place, instance.law, CycleId::Function, pairs),
            }
        }
    }

    /// Halves of a law that no cycle runs while this one runs another half.
    pub(super) fn owed_halves(&self, facts: &FunctionFacts<'_>, pairs: &mut BTreeMap<CycleId, Vec<Pair>>) {
        for instance in facts.updated.iter().filter(|instance| !instance.is_updated) {
            let laws = self.fields.laws(self.program.index, facts.graph, &instance.place);
            let elsewhere = laws.contains(&instance.law);
            let is_here = !instance.loops.is_empty() || instance.function;
            if elsewhere || is_here || self.multiplicity(facts, &instance.place, instance.law) != Multiplicity::Once {
                continue;
            }
            let other = facts.updated.iter().find(|other| {
                other.place == instance.place
                    && other.is_updated
                    && (!other.loops.is_empty() || (other.function && facts.kind == FunctionKind::Cycle))
            });
            let Some(other) = other else { continue };
            let id = other.loops.first().map_or(CycleId::Function, |id| CycleId::Loop(*id));
            let is_lent = facts.kind == FunctionKind::Helper
                && instance
                    .place
                    .base_var()
                    .map(|var| facts.graph.var(var))
                    .is_some_and(|info| info.param.is_some() && !matches!(info.ty, Ty::Adt(..)));
            // Whoever calls a helper may run the other half, but where that lies in a field it would have been found.
            let is_unbounded = |id: &LoopId| facts.graph.loop_info(*id).rounds == Rounds::Unbounded;
            let is_known = !instance.place.steps.is_empty()
                && other.loops.first().is_some_and(is_unbounded)
                && self.anywhere.laws(self.program.index, facts.graph, &instance.place).is_empty();
            if is_lent && !is_known {
                continue;
            }
            self.push_missed(facts, &instance.place, instance.law, id, pairs);
        }
    }

    fn owed_instance(
        &self,
        facts: &FunctionFacts<'_>,
        var: Option<Var>,
        place: &Place,
        leaf: &instances::Leaf,
        pairs: &mut BTreeMap<CycleId, Vec<Pair>>,
        analysis: &mut Analysis,
    ) {
        let (graph, index) = (facts.graph, self.program.index);
        let info = var.map(|var| graph.var(var));
        let is_param = info.is_none_or(|info| info.param.is_some());
        // What lies in a static or behind a reference may be updated elsewhere; what lies in a local or in what the function was
        // given is updated here or handed on.
        let is_local = !is_param || instances::is_in_given(index, graph, place);
        let is_touched = |fields: &Fields| !fields.laws(index, graph, place).is_empty();
        if !is_local && (is_touched(self.fields) || is_touched(self.anywhere) || self.lent.has(index, graph, place)) {
            return;
        }
        if (is_touched(self.fields) || is_touched(self.anywhere)) && self.is_of_settings(facts, place) {
            return;
        }
        let uses = self.uses(facts, place);
        // Whatever is fed or copied is there.
        let is_copied = || uses.copied || self.is_updated_in_a_copy(facts, place);
        let is_there = || (uses.fed || is_copied()) && !instances::is_in_map(index, graph, place);
        // What only a handle of this function's own leads to is there, and nobody else updates it.
        let is_only = var.is_some_and(|var| leaf.steps.is_empty() && is_only_handle(index, facts, var));
        let is_absent =
            || leaf.is_uncertain && !is_only && !is_there() && !self.is_beside_updated(facts, place, leaf.is_shared);
        let is_given = || graph.given_away.iter().any(|(_, given)| given == place);
        let is_read_only = (uses.read || uses.looked_into || is_given()) && !uses.fed && !uses.written;
        // A clone that is only read, or put back, shows what the other one was.
        let is_snapshot = uses.is_snapshot || is_read_only && var.is_some_and(|var| uses::is_clone(graph, var));
        if is_snapshot
            || uses.leaves
            || is_absent()
            || self.comes_back(facts, place)
            || self.is_run_for_good(facts, place)
            || self.is_left_to_law(facts, place)
            || finished::is_moved_on(facts, self.summaries, place)
        {
            return;
        }
        // A cycle that updates a sibling owes this one an update, too.
        let scope = |id: CycleId| match id {
            CycleId::Loop(id) => {
                let declared = info.and_then(|info| info.in_loop);
                declared.is_none_or(|declared| declared != id && graph.is_within(Some(id), declared))
                    && var.is_none_or(|var| self.is_declared_before(graph, var, id))
            }
            CycleId::Function => is_param && facts.kind == FunctionKind::Cycle,
        };
        let is_param_itself = is_param && leaf.steps.is_empty();
        // Of what is copied the copies may be what is in use.
        let owes = |(id, filters): &(&CycleId, &Vec<Pair>)| {
            !uses.copied
                && scope(**id)
                && filters.iter().any(|pair| pair.verdict != Verdict::Missed)
                && (!is_param_itself
                    || matches!(id, CycleId::Loop(id) if graph.loop_info(*id).rounds == Rounds::Unbounded))
                && !self.is_only_filled_in(facts, place, leaf, **id)
                && self.is_sibling(facts, place, **id)
        };
        let siblings: Vec<CycleId> = pairs.iter().filter(owes).map(|(id, _)| *id).collect();
        // Another handle to what it lies in may be the one by which some code updates it.
        let has_another = leaf.is_shared && (is_touched(self.fields) || is_touched(self.anywhere)) && !is_only;
        let using = self.using_loop(facts, place).filter(|id| !has_another && scope(CycleId::Loop(*id)));
        if let Some(id) = self.owing(facts, place, &siblings, using) {
            self.push_missed(facts, place, 0, id, pairs);
            return;
        }
        let is_read_by_round =
            || graph.node_ids().any(|id| graph.node(id).in_loop.is_none() && self.node_uses(facts, id, place));
        if scope(CycleId::Function)
            && !is_param_itself
            && !leaf.is_uncertain
            && !instances::is_lent(index, graph, place)
            && is_read_by_round()
        {
            self.push_missed(facts, place, 0, CycleId::Function, pairs);
            return;
        }
        let is_built = |var: &Var| self.is_built_here(graph, *var);
        let Some(var) = var.filter(|var| !is_param && is_built(var) && !uses.copied && !has_another) else { return };
        // Its scope holds a loop that never ends.
        let endless = (0u32..).map(LoopId).zip(&graph.loops).find(|(id, own)| {
            own.is_endless() && own.directive != Some(CycleDirective::NotACycle) && scope(CycleId::Loop(*id))
        });
        let is_local_filter = leaf.steps.is_empty();
        match endless {
            Some((id, _)) if !uses.written => self.push_missed(facts, place, 0, CycleId::Loop(id), pairs),
            Some((id, _)) if is_local_filter => {
                self.push_unregistered(facts, var, place, Some(graph.loop_info(id).keyword), analysis);
            }
            None if is_local_filter && !self.is_tool(facts, place) => {
                self.push_unregistered(facts, var, place, None, analysis);
            }
            _ => {}
        }
    }

    /// Whether something is updated that lies in the same element of a collection, or in the same value of an option or variant:
    /// where there is one, there is the other. Another handle to the value may update the rest.
    pub(super) fn is_beside_updated(&self, facts: &FunctionFacts<'_>, place: &Place, is_shared: bool) -> bool {
        (0..place.steps.len()).any(|at| {
            let (steps, rest) = place.steps.split_at(at);
            let whole = Place { base: place.base, steps: steps.into() };
            let is_element = whole.steps.last().is_some_and(|step| step.key().is_some());
            // Of a collection no two elements are told apart.
            let is_in_same = |other: &Place| match (other.steps.get(..at), is_element) {
                (Some(others), true) => others[..at - 1] == steps[..at - 1] && others[at - 1].key().is_some(),
                (Some(others), false) => !is_shared && others == steps,
                (None, _) => false,
            };
            instances::is_always_in(self.program.index, facts.graph, &whole, rest)
                && facts.updated.iter().any(|instance| {
                    let other = &instance.place;
                    other.base == place.base && is_in_same(other) && other.steps[at..] != *rest
                })
        })
    }

    pub(super) fn is_declared_before(&self, graph: &ControlFlowGraph, var: Var, id: LoopId) -> bool {
        let (info, own) = (graph.var(var), graph.loop_info(id));
        // Where a loop ends may be a node from before its head.
        let is_behind = info.span.file == own.keyword.file && info.span.start > own.keyword.start;
        info.param.is_some()
            || info.declared < own.head && !is_behind && self.is_in_block_of(graph, info.span, own.keyword)
    }

    /// Whether the block in which a variable is declared holds a loop of the same function, as far as they stand there as they are.
    fn is_in_block_of(&self, graph: &ControlFlowGraph, declared: Span, keyword: Span) -> bool {
        let Some(body) = &self.program.index.function(graph.function).function.body else { return true };
        let is_block = |expr: &&Expr| matches!(expr.kind, ExprKind::Block(_)) && expr.span.contains(declared);
        let block = body.exprs.iter().filter(is_block).min_by_key(|expr| expr.span.end - expr.span.start);
        !body.expr(body.root).span.contains(keyword) || block.is_none_or(|block| block.span.contains(keyword))
    }

    /// Whether a variable gets a value of its own in this function, not one that a closure or pattern was handed, nor a copy
    /// of another variable's.
    pub(super) fn is_built_here(&self, graph: &ControlFlowGraph, var: Var) -> bool {
        let is_copy = |node: &crate::flow::Node| {
            matches!(&node.effect, Effect::Set(set)
                if set.place == Place::var(var) && set.transfer == Transfer::Copy && is_named(graph, set.from.as_ref()))
                || matches!(&node.effect, Effect::Call(site)
                    if site.into.contains(&var) && site.args.iter().any(|arg| arg.is_copy))
        };
        let is_item = graph.loops.iter().any(|info| info.bound.contains(&var));
        !matches!(graph.var(var).ty, Ty::Ref(..))
            && !is_item
            && !graph.handed.contains(&var)
            && !graph.nodes.iter().any(is_copy)
    }

    pub(super) fn push_missed(
        &self,
        facts: &FunctionFacts<'_>,
        place: &Place,
        law: usize,
        id: CycleId,
        pairs: &mut BTreeMap<CycleId, Vec<Pair>>,
    ) {
        let graph = facts.graph;
        let head = match id {
            CycleId::Loop(id) => {
                let info = graph.loop_info(id);
                match info.cycle_head() {
                    Some((head, _)) if !info.is_unseen() => head,
                    _ => return,
                }
            }
            CycleId::Function => self.program.index.function(graph.function).function.keyword,
        };
        let mut decision = self.decide_unseen(facts, place, law, id, head);
        if decision.verdict == Verdict::Missed {
            if self.keeps_nothing(facts, place, law) || taken_out::by_callees(self, facts, place) {
                return;
            }
            let of_copy = |span| WitnessStep { span, message: OF_COPY.to_owned() };
            decision.witness.extend(self.lost_update(facts, place).map(of_copy));
        }
        let pair = self.pair(facts, place, law, decision);
        // Another variable of the same name may have an entry, too.
        let is_updated = facts.updated.iter().any(|instance| instance.place == *place && instance.law == law);
        let filters = pairs.entry(id).or_default();
        let is_known = |other: &Pair| other.name == pair.name && other.half == law;
        if !filters.iter().any(|other| is_known(other) && (is_updated || other.verdict == Verdict::Missed)) {
            filters.push(pair);
        }
    }

    /// A pair that nothing updates: missed, unless something unseen could.
    fn decide_unseen(&self, facts: &FunctionFacts<'_>, place: &Place, law: usize, id: CycleId, head: Span) -> Decision {
        let search = Search::with_dependence(
            self.program,
            facts.graph,
            &facts.aliases,
            self.summaries,
            place,
            law,
            &facts.dependence,
        );
        let region = match id {
            CycleId::Loop(id) => Region::Loop(id),
            CycleId::Function => Region::Function,
        };
        let decision = match self.limit(facts) {
            Some(cause) => Decision { primary: Some(head), ..Decision::unproved(cause) },
            None => missed::decide_missed(&search, region, head),
        };
        self.effort.add(facts.graph.nodes.len() / 8 + search.take_states());
        super::other_handles::in_doubt(self, facts, place, decision)
    }

    /// The loop that uses an instance and therefore owes it an update.
    pub(super) fn using_loop(&self, facts: &FunctionFacts<'_>, place: &Place) -> Option<LoopId> {
        let graph = facts.graph;
        // A filter that is made inside the iteration is owed nothing by it.
        let made_in = place.base_var().and_then(|var| graph.var(var).in_loop);
        let made_within = |id: LoopId| graph.is_within(made_in, id);
        for id in graph.node_ids() {
            if !self.node_uses(facts, id, place) {
                continue;
            }
            let around = graph.loops_around(id).find(|id| {
                let info = graph.loop_info(*id);
                info.rounds == Rounds::Unbounded
                    && !made_within(*id)
                    && !info.is_foreign
                    && info.directive != Some(CycleDirective::NotACycle)
            });
            if around.is_some() {
                return around;
            }
        }
        None
    }

    pub(super) fn node_uses(&self, facts: &FunctionFacts<'_>, id: NodeId, place: &Place) -> bool {
        let touches =
            |other: &Place| {
                facts.aliases.shared_roots(other).iter().any(|root| {
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
            // What goes on with its state is another instance; with the whole of a collection, each of its elements.
            Effect::Set(set) => {
                let copies = |from: &Place| facts.aliases.shared_roots(from).iter().any(|root| root.overlaps(place));
                set.transfer == Transfer::Copy && set.from.as_ref().is_some_and(copies)
            }
            _ => false,
        }
    }

    fn push_unregistered(
        &self,
        facts: &FunctionFacts<'_>,
        var: Var,
        place: &Place,
        cycle: Option<Span>,
        analysis: &mut Analysis,
    ) {
        // What may have a name that is not known may be updated by it, and what was taken out of something was built there.
        if self.limit(facts).is_some()
            || facts.graph.taken.contains(&var)
            || is_in_unreached_loop(self.program, facts.graph, var)
        {
            return;
        }
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

/// Whether a place has a name in the source, and is no value in between.
pub(super) fn is_named(graph: &ControlFlowGraph, place: Option<&Place>) -> bool {
    place.is_some_and(|place| place.base_var().is_none_or(|var| !graph.var(var).name.is_empty()))
}
