//! Generic functions for the types that they are called with: an instance of a function is a copy of its graph in which a method of
//! a type parameter is that of the type. What is called with no certain type stays one for all types.

use rustc_hash::FxHashMap;

use crate::flow::{CallSite, ControlFlowGraph, Effect, Place, Program, Var};
use crate::index::{FunctionId, Index, Owner, Ty};
use crate::source::Span;

/// How many instances of one function there may be: a recursion can ask for another type with each call.
pub(super) const MAX_INSTANCES: usize = 64;

/// What the parameters of a generic function stand for, by their names.
type Types = Vec<(String, Ty)>;

/// The instances that there are.
#[derive(Default)]
struct Instances {
    /// What they are instances of, in the order of their numbers.
    origins: Vec<FunctionId>,
    known: FxHashMap<(FunctionId, Types), FunctionId>,
}

/// Adds the instances that are called to the graphs. Answers which functions they are instances of.
#[must_use]
pub fn monomorphise(program: &Program<'_>, graphs: &mut Vec<Option<ControlFlowGraph>>) -> Vec<FunctionId> {
    let index = program.index;
    let asks = that_ask(graphs);
    let mut instances = Instances::default();
    let mut at = 0;
    // What an instance calls may be one as well.
    while at < graphs.len() && asks.contains(&true) {
        for node in 0..graphs[at].as_ref().map_or(0, |graph| graph.nodes.len()) {
            let Some(site) = graphs[at].as_ref().and_then(|graph| call(graph, node)) else { continue };
            if !site.types.iter().any(|ty| index.holds_filter(ty)) {
                continue;
            }
            let wanted: Vec<Option<Types>> = site
                .targets
                .iter()
                .map(|target| types_at(index, *target, graphs.get(target.0 as usize)?.as_ref()?, site))
                .collect();
            let mut targets = site.targets.clone();
            for (target, types) in targets.iter_mut().zip(wanted) {
                if let Some(types) = types.filter(|_| asks.get(target.0 as usize) == Some(&true)) {
                    *target = instances.of(index, graphs, *target, types).unwrap_or(*target);
                }
            }
            if let Some(Effect::Call(site)) = graphs[at].as_mut().map(|graph| &mut graph.nodes[node].effect) {
                site.targets = targets;
            }
        }
        at += 1;
    }
    instances.origins
}

impl Instances {
    /// The function that one is an instance of, or itself.
    fn origin(&self, id: FunctionId, graphs: usize) -> FunctionId {
        let functions = graphs - self.origins.len();
        (id.0 as usize).checked_sub(functions).map_or(id, |instance| self.origins[instance])
    }

    /// The instance of a function for these types; `None` if there are too many.
    fn of(
        &mut self,
        index: &Index,
        graphs: &mut Vec<Option<ControlFlowGraph>>,
        origin: FunctionId,
        types: Types,
    ) -> Option<FunctionId> {
        let key = (origin, types);
        if let Some(known) = self.known.get(&key) {
            return Some(*known);
        }
        if self.origins.iter().filter(|other| **other == origin).count() >= MAX_INSTANCES {
            return None;
        }
        let id = FunctionId(u32::try_from(graphs.len()).ok()?);
        let mut written = graphs[origin.0 as usize].clone()?;
        // Its calls may have been told their instances already: those of its own types.
        for node in &mut written.nodes {
            if let Effect::Call(site) = &mut node.effect {
                site.targets.iter_mut().for_each(|target| *target = self.origin(*target, graphs.len()));
            }
        }
        graphs.push(Some(instance(index, written, id, &key.1)));
        self.origins.push(origin);
        self.known.insert(key, id);
        Some(id)
    }
}

fn call(graph: &ControlFlowGraph, node: usize) -> Option<&CallSite> {
    match &graph.nodes[node].effect {
        Effect::Call(site) if !site.types.is_empty() => Some(site),
        _ => None,
    }
}

/// The parameter whose associated constant a branch asks for.
fn constant_of(effect: &Effect) -> Option<&(Ty, String)> {
    if let Effect::Branch(test) = effect { test.about.constant_of.as_deref() } else { None }
}

/// The functions in which, at any depth, the type of a parameter decides which body runs, or whether something does.
fn that_ask(graphs: &[Option<ControlFlowGraph>]) -> Vec<bool> {
    let mut asks = vec![false; graphs.len()];
    loop {
        let before = asks.iter().filter(|asks| **asks).count();
        for (number, graph) in graphs.iter().enumerate().filter_map(|(number, graph)| Some((number, graph.as_ref()?))) {
            let decides = |site: &CallSite| {
                let is_passed_on = || site.targets.iter().any(|target| asks[target.0 as usize]);
                let is_bounded = |ty: &Ty| ty.is_open() || matches!(ty.peel(), Ty::Opaque(_));
                site.types.iter().any(is_bounded) && (site.targets.len() > 1 || is_passed_on())
            };
            asks[number] |= graph.nodes.iter().any(|node| constant_of(&node.effect).is_some())
                || (0..graph.nodes.len()).filter_map(|node| call(graph, node)).any(decides);
        }
        if asks.iter().filter(|asks| **asks).count() == before {
            return asks;
        }
    }
}

/// What the parameters of a function stand for at a call of it; `None` if that is not known, or it has none.
fn types_at(index: &Index, id: FunctionId, graph: &ControlFlowGraph, site: &CallSite) -> Option<Types> {
    let def = index.function(id);
    let mut types = Types::new();
    let mut first = 0;
    if def.function.receiver.is_some() {
        let receiver = site.types.first()?;
        match def.owner {
            Owner::Impl(of) => types.extend(index.impl_args(of, receiver)),
            Owner::Trait(_) => types.push(("Self".to_owned(), receiver.clone())),
            Owner::Module => {}
        }
        first = 1;
    }
    for (number, (param, ty)) in graph.params.iter().zip(&site.types).enumerate().skip(first) {
        types.extend(graph.var(*param).ty.bindings(ty));
        if has_hidden_type(graph, *param) && matches!(ty.peel(), Ty::Adt(..)) {
            types.push((hidden(number), ty.peel().clone()));
        }
    }
    types.sort_by(|left, right| left.0.cmp(&right.0));
    types.dedup();
    let is_told = |pair: &[(String, Ty)]| pair[0].0 != pair[1].0;
    let is_certain = !types.is_empty() && types.windows(2).all(is_told) && types.iter().all(|(_, ty)| decides(ty));
    is_certain.then_some(types)
}

/// Whether a type tells which of several bodies runs: that of `Pair<T>` is the same whatever `T` is.
fn decides(ty: &Ty) -> bool {
    matches!(ty.peel(), Ty::Adt(..) | Ty::External(..)) || !ty.is_open()
}

/// Whether a parameter is `&mut impl Trait` or `&mut dyn Trait`, and stays what it is given.
fn has_hidden_type(graph: &ControlFlowGraph, param: Var) -> bool {
    let is_whole = |place: &Place| *place == Place::var(param);
    let is_given_anew = |effect: &Effect| match effect {
        Effect::Set(set) | Effect::Write(set) => set.rebinds && is_whole(&set.place),
        _ => false,
    };
    matches!(graph.var(param).ty.peel(), Ty::Opaque(_)) && !graph.nodes.iter().any(|node| is_given_anew(&node.effect))
}

/// The name of a type that has none: that of a parameter by its number.
fn hidden(number: usize) -> String {
    number.to_string()
}

/// The function with these types.
fn instance(index: &Index, mut graph: ControlFlowGraph, id: FunctionId, types: &Types) -> ControlFlowGraph {
    let function = &index.function(graph.function).function;
    let body = function.body.as_ref().map_or(function.head, |body| body.expr(body.root).span);
    // What was inlined has parameters of its own, which may have the same names.
    let is_own = |span: Span| body.contains(span);
    graph.function = id;
    let given = |number: usize| types.iter().find(|(name, _)| *name == hidden(number)).map(|(_, ty)| ty);
    for var in graph.vars.iter_mut().filter(|var| var.param.is_some() || is_own(var.span)) {
        var.ty = match var.param.and_then(given) {
            Some(ty) => ty.clone(),
            None => var.ty.substitute(types),
        };
    }
    let params = graph.params.clone();
    for node in graph.nodes.iter_mut().filter(|node| is_own(node.span)) {
        if let Some((of, name)) = constant_of(&node.effect) {
            let truth = index.truth_of(&of.substitute(types), name);
            if let Effect::Branch(test) = &mut node.effect {
                test.about.constant = truth;
            }
        }
        let Effect::Call(site) = &mut node.effect else { continue };
        let was_bounded = matches!(site.types.first(), Some(Ty::Param(_) | Ty::Opaque(_)));
        for (ty, arg) in site.types.iter_mut().zip(&site.args) {
            let param = arg.place.as_ref().and_then(|place| params.iter().position(|var| *place == Place::var(*var)));
            *ty = param.and_then(given).cloned().unwrap_or_else(|| ty.substitute(types));
        }
        if was_bounded {
            narrow(index, site);
        }
    }
    graph
}

/// Leaves of the bodies that a call may run those of the type at hand.
fn narrow(index: &Index, site: &mut CallSite) {
    let (Some(ty), Some(first)) = (site.types.first(), site.targets.first()) else { return };
    let methods = index.methods(ty, &index.function(*first).name);
    let is_of_type = |target: &FunctionId| {
        let fits = match index.function(*target).owner {
            Owner::Impl(of) => index.impl_def(of).self_ty.admits(ty),
            _ => true,
        };
        fits && methods.iter().any(|method| method.function() == Some(*target))
    };
    let own: Vec<FunctionId> = site.targets.iter().copied().filter(is_of_type).collect();
    if !own.is_empty() {
        site.is_dispatched &= site.law_of.is_some() && own.len() > 1;
        site.targets = own;
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::index::{ParamTy, TypeId};

    fn parameter() -> Ty {
        Ty::Param(Arc::new(ParamTy { name: "T".to_owned(), bounds: Vec::new() }))
    }

    #[test]
    fn a_type_decides_whatever_its_own_parameters_are() {
        for known in [
            Ty::Adt(TypeId(0), vec![parameter()]),
            Ty::Ref(true, Box::new(Ty::Adt(TypeId(0), vec![parameter()]))),
            Ty::std("std::boxed::Box", vec![parameter()]),
            Ty::Float,
        ] {
            assert!(decides(&known), "{known:?}");
        }
        for open in [parameter(), Ty::Ref(true, Box::new(parameter())), Ty::Tuple(vec![parameter(), Ty::Float])] {
            assert!(!decides(&open), "{open:?}");
        }
    }

    #[test]
    fn an_instance_is_made_once_and_only_so_many() {
        let mut instances = Instances { origins: vec![FunctionId(1), FunctionId(0)], known: FxHashMap::default() };
        // Two functions are written, and two are instances of them.
        let origins: Vec<FunctionId> = (0..4).map(|id| instances.origin(FunctionId(id), 4)).collect();
        assert_eq!(origins, [FunctionId(0), FunctionId(1), FunctionId(1), FunctionId(0)]);
        let types = vec![("T".to_owned(), Ty::Float)];
        instances.known.insert((FunctionId(0), types.clone()), FunctionId(3));
        let index = Index::default();
        let mut graphs = Vec::new();
        assert_eq!(instances.of(&index, &mut graphs, FunctionId(0), types), Some(FunctionId(3)));
        instances.origins = vec![FunctionId(0); MAX_INSTANCES];
        let others = vec![("T".to_owned(), Ty::Int)];
        assert_eq!(instances.of(&index, &mut graphs, FunctionId(0), others), None);
        assert!(graphs.is_empty(), "what is refused is not added");
    }
}
