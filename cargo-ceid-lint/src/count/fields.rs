//! Fields that lead to filters, wherever a value of their types lives: whether some other code updates the filter at a place, as far
//! as the fields on the way there tell.

use std::collections::{BTreeMap, BTreeSet};

use super::analyse::{FunctionFacts, filters_at};
use super::callgraph::recursive;
use super::cycles::Instance;
use super::functions::{FunctionKind, called_while_made};
use super::instances::{inner, is_lent, place_ty};
use super::summary::Summaries;
use crate::flow::{Base, CallSite, ControlFlowGraph, Effect, IndexKey, NodeId, Place, Program, Projection};
use crate::index::{FunctionId, Index, Ty, TypeId, ValueId};

/// A field of a type, or a field of a field.
pub(super) type FieldKey = (TypeId, Vec<String>);

/// A half of a law, and the function and the variable of it that the place was reached by.
type Reached = (usize, FunctionId, Base);

/// Places by their fields, each with halves of laws.
#[derive(Debug, Default)]
pub(super) struct Fields {
    /// By all fields that are known of them.
    whole: BTreeMap<FieldKey, BTreeSet<Reached>>,
    /// By the last ones, of each type on the way.
    inner: BTreeMap<FieldKey, BTreeSet<Reached>>,
    /// The elements of fields, with the functions that name them.
    elements: BTreeMap<FieldKey, BTreeSet<(FunctionId, IndexKey)>>,
}

impl Fields {
    /// Adds a place, with a half of its law.
    pub(super) fn add(&mut self, index: &Index, graph: &ControlFlowGraph, place: &Place, law: usize) {
        let keys = keys(index, graph, place);
        if let (Some(field), Some(element)) = (keys.last(), place.steps.last().and_then(Projection::key)) {
            self.elements.entry(field.clone()).or_default().insert((graph.function, element.clone()));
        }
        let mut keys = keys.into_iter();
        let reached = (law, graph.function, place.base);
        if let Some(whole) = keys.next() {
            self.whole.entry(whole).or_default().insert(reached);
        }
        for inner in keys {
            self.inner.entry(inner).or_default().insert(reached);
        }
    }

    /// The halves that were added for what may be the same place: one knows of no other field on the way than the other one does.
    pub(super) fn laws(&self, index: &Index, graph: &ControlFlowGraph, place: &Place) -> BTreeSet<usize> {
        // What a function gets by another parameter is another value.
        let is_param = |base: &Base| matches!(base, Base::Var(var) if graph.var(*var).param.is_some());
        let is_another =
            |(_, function, base): &&Reached| *function == graph.function && *base != place.base && is_param(base);
        let reached = self.reached(index, graph, place);
        reached.into_iter().filter(|reached| !is_another(reached)).map(|(law, ..)| *law).collect()
    }

    /// Whether another function was added for what may be the same place, and a half of its law.
    pub(super) fn has_elsewhere(&self, index: &Index, graph: &ControlFlowGraph, place: &Place, law: usize) -> bool {
        let reached = self.reached(index, graph, place);
        reached.into_iter().any(|(own, function, _)| *own == law && *function != graph.function)
    }

    /// What was added for what may be the same place.
    fn reached(&self, index: &Index, graph: &ControlFlowGraph, place: &Place) -> Vec<&Reached> {
        let keys = keys(index, graph, place);
        let whole = keys.iter().filter_map(|key| self.whole.get(key));
        let inner = keys.first().and_then(|key| self.inner.get(key));
        whole.chain(inner).flatten().collect()
    }

    /// Whether a field of a type was added, wherever values of the type were.
    pub(super) fn has(&self, field: &FieldKey) -> bool {
        self.whole.contains_key(field) || self.inner.contains_key(field)
    }

    /// Whether another function was added with what may be the element of a field that a place is: that element, all of them, or
    /// one of which only running code knows which it is.
    pub(super) fn is_selected_elsewhere(&self, index: &Index, graph: &ControlFlowGraph, place: &Place) -> bool {
        let key = place.steps.last().and_then(Projection::key);
        let is_certain =
            |own: &IndexKey| matches!(own, IndexKey::Number(_) | IndexKey::Named(_) | IndexKey::Literal(_));
        let all = field_key(index, graph, place).and_then(|field| self.elements.get(&field));
        all.into_iter()
            .flatten()
            .any(|(function, own)| *function != graph.function && (Some(own) == key || !is_certain(own)))
    }
}

/// The field that holds a place, and the type it is a field of.
pub(super) fn field_key(index: &Index, graph: &ControlFlowGraph, place: &Place) -> Option<FieldKey> {
    keys(index, graph, place).pop()
}

/// The fields that lead to a place: from each type on the way, the outermost first.
fn keys(index: &Index, graph: &ControlFlowGraph, place: &Place) -> Vec<FieldKey> {
    let mut keys = Vec::new();
    let mut fields = Vec::new();
    for (at, step) in place.steps.iter().enumerate().rev() {
        let Projection::Field(name) = step else {
            // An element is the collection's, and what lies in an element is a value of the element's type, unless that is a tuple. An
            // array has its elements for good.
            let collection = place.up_to(at);
            if keys.is_empty() || matches!(place_ty(index, graph, &collection), Some(Ty::Array(..))) {
                continue;
            }
            break;
        };
        let owner = place.up_to(at);
        let owner = place_ty(index, graph, &owner);
        // A part of a tuple is one of whatever has the tuple.
        if matches!(owner, Some(Ty::Tuple(_))) {
            fields.insert(0, name.to_string());
            continue;
        }
        let Some(owner @ Ty::Adt(id, _)) = owner else { break };
        // What lies behind a reference belongs to something else.
        if !fields.is_empty() && matches!(index.field_ty(&owner, None, name), Some(Ty::Ref(..))) {
            break;
        }
        fields.insert(0, name.to_string());
        let declaring = index.declares_fields(id);
        keys.insert(0, (declaring, fields.clone()));
        // A task's resources are those of all tasks.
        if declaring != id {
            break;
        }
    }
    keys
}

/// The fields of types that some cycle updates, with the halves of the law.
pub(super) fn updated_fields(
    program: &Program<'_>,
    facts: &[FunctionFacts<'_>],
    in_cycle: &BTreeSet<FunctionId>,
    graphs: &[Option<ControlFlowGraph>],
) -> Fields {
    let index = program.index;
    let mut found = Fields::default();
    let (recursive, while_made) = (recursive(graphs), called_while_made(index, graphs));
    let sites = call_sites(index, facts);
    for function in facts {
        let whole = in_cycle.contains(&function.graph.function);
        for instance in function.updated.iter().filter(|instance| !is_given_away(index, function, instance)) {
            // Whose it is that a helper updates, its callers tell, unless a recursion leads deeper than places are followed.
            let is_callers = || {
                !recursive.contains(&function.graph.function) && is_named_by_callers(index, function, instance, &sites)
            };
            let is_helped = || whole && instance.is_updated && !is_callers();
            // What is handed to a framework by its name, as the systems of a schedule are, may be called in each cycle of that.
            let id = function.graph.function;
            let is_listed = || program.callables.is_listed(index.origin(id));
            let is_users = instance.is_updated && (while_made.contains(&id) || is_listed());
            if instance.function || !instance.loops.is_empty() || is_users || is_helped() {
                found.add(index, function.graph, &instance.place, instance.law);
            }
        }
    }
    found
}

/// The calls of each function, with the functions that they stand in.
type CallSites<'a, 'b> = BTreeMap<FunctionId, Vec<(&'a FunctionFacts<'b>, &'a CallSite)>>;

fn call_sites<'a, 'b>(index: &Index, facts: &'a [FunctionFacts<'b>]) -> CallSites<'a, 'b> {
    let mut found = CallSites::new();
    for function in facts.iter().filter(|function| function.kind != FunctionKind::Outside) {
        for node in &function.graph.nodes {
            let Effect::Call(site) = &node.effect else { continue };
            for target in &site.targets {
                found.entry(index.origin(*target)).or_default().push((function, &**site));
            }
        }
    }
    found
}

/// Whether each call of a function names what it gives for the instance, so that the update is listed there as one of that.
fn is_named_by_callers(
    index: &Index,
    function: &FunctionFacts<'_>,
    instance: &Instance,
    sites: &CallSites<'_, '_>,
) -> bool {
    let info = instance.place.base_var().map(|var| function.graph.var(var));
    let Some(number) = info.and_then(|info| info.param) else { return false };
    let Some(sites) = sites.get(&index.origin(function.graph.function)) else { return false };
    sites.iter().all(|(caller, site)| {
        let given = site.args.get(number).and_then(|arg| arg.place.as_ref()).filter(|_| !site.is_dispatched);
        let is_named = |root: &Place| {
            let info = root.base_var().map(|var| caller.graph.var(var));
            let ty = place_ty(index, caller.graph, root).map(|ty| inner(&ty));
            info.is_none_or(|info| !info.name.is_empty() || info.param.is_some())
                && matches!(ty, Some(Ty::Adt(..) | Ty::Tuple(_) | Ty::Array(..)))
        };
        given.is_some_and(|place| caller.aliases.roots(place).iter().all(is_named))
    })
}

/// The fields of types that some code updates or hands to something unseen. What gets an owner for good runs the methods of its type,
/// which are read, and comes to a filter in it only where one of them lends that.
pub(super) fn touched_fields(index: &Index, facts: &[FunctionFacts<'_>]) -> Fields {
    let mut found = Fields::default();
    let mut lent = Fields::default();
    let functions = || facts.iter().filter(|function| function.kind != FunctionKind::Outside);
    for function in functions() {
        let returned = function.graph.nodes.iter().filter_map(|node| match &node.effect {
            Effect::Return(value) => value.place.as_ref(),
            _ => None,
        });
        let is_lent = |place: &Place| place.base_var().is_none_or(|var| function.graph.var(var).param.is_some());
        let returned = returned.flat_map(|place| filters_at(index, function.graph, &function.aliases, place));
        for place in returned.filter(is_lent) {
            lent.add(index, function.graph, &place, 0);
        }
    }
    for function in functions() {
        let graph = function.graph;
        let unknown = graph.node_ids().flat_map(|id| match &graph.node(id).effect {
            Effect::Unknown { places, .. } => {
                places.iter().map(|place| (place, is_owner_given_away(index, graph, id, place))).collect()
            }
            _ => Vec::new(),
        });
        for (place, is_owned) in unknown.chain(graph.cloned.iter().map(|place| (place, false))) {
            for filter in filters_at(index, graph, &function.aliases, place) {
                let is_own = is_owned && !is_lent(index, graph, &filter) && lent.laws(index, graph, &filter).is_empty();
                if !is_own {
                    found.add(index, graph, &filter, 0);
                }
            }
        }
    }
    found
}

/// The statics with a filter that some code updates, or lends to where it may be updated by another name.
pub(super) fn touched_statics(summaries: &Summaries, facts: &[FunctionFacts<'_>]) -> BTreeSet<ValueId> {
    let mut found = BTreeSet::new();
    for function in facts.iter().filter(|function| function.kind != FunctionKind::Outside) {
        let mut add = |place: &Place| {
            found.extend(function.aliases.shared_roots(place).iter().filter_map(|root| root.base.value()));
        };
        function.updated.iter().for_each(|instance| add(&instance.place));
        for node in &function.graph.nodes {
            match &node.effect {
                Effect::Unknown { places, .. } => places.iter().for_each(&mut add),
                Effect::Return(value) => value.place.iter().for_each(&mut add),
                Effect::Write(set) | Effect::Set(set) if !set.place.steps.is_empty() => {
                    set.from.iter().for_each(&mut add);
                }
                Effect::Call(site) => {
                    let callees = || site.targets.iter().filter_map(|target| summaries.get(*target));
                    let is_kept = |number: usize| callees().any(|callee| callee.keeps.contains(&number));
                    let kept = site.args.iter().enumerate().filter(|(number, _)| is_kept(*number));
                    kept.filter_map(|(_, arg)| arg.place.as_ref()).for_each(&mut add);
                }
                _ => {}
            }
        }
    }
    found
}

/// Whether an instance is only known to be in what something unseen gets for good.
fn is_given_away(index: &Index, function: &FunctionFacts<'_>, instance: &Instance) -> bool {
    let graph = function.graph;
    let holds = |place: &Place| function.aliases.shared_roots(place).iter().any(|root| root.overlaps(&instance.place));
    let unknown = graph.node_ids().flat_map(|id| match &graph.node(id).effect {
        Effect::Unknown { places, .. } => places.iter().map(|place| (id, place)).collect(),
        _ => Vec::new(),
    });
    let mut unknown = unknown.filter(|(_, place)| holds(place)).peekable();
    instance.is_unseen
        && unknown.peek().is_some()
        && unknown.all(|(id, place)| is_owner_given_away(index, graph, id, place))
}

/// Whether something unseen gets a value for good at a node, of a type of the analysed code that is no filter itself.
fn is_owner_given_away(index: &Index, graph: &ControlFlowGraph, id: NodeId, place: &Place) -> bool {
    let ty = || place_ty(index, graph, place).map(|ty| inner(&ty));
    graph.given_away.contains(&(id, place.clone()))
        && ty().is_some_and(|ty| matches!(ty, Ty::Adt(..)) && index.filter_spec(&ty).is_none())
}
