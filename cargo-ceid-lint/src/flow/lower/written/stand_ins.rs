//! Methods that do what the law of their filter does under another name: `process_single`, of which `process_block` is made.

use std::collections::BTreeSet;

use super::{Method, written_fields};
use crate::flow::Program;
use crate::index::{Def, FilterSpec, FunctionId, MethodOwner, Ty};
use crate::syntax::tree::{ExprId, ExprKind, Receiver};

/// The halves of the law of a filter type that a method of it may stand in for, each with the law's name: the law runs it, or it is
/// called alike (`process_chunk` or `ramp_and_process` beside `process_waveform`) or the state has several fields, and it goes on from
/// the state and writes all of it that the law writes.
/// Feeding and clearing is not enough.
pub fn stands_in(program: &Program<'_>, method: FunctionId, ty: &Ty) -> Vec<(usize, String)> {
    let index = program.index;
    let Some(spec) = index.receiver_spec(ty) else { return Vec::new() };
    let def = index.function(method);
    let is_reset = is_reset(spec, &def.name);
    if def.function.receiver != Some(Receiver::Exclusive) || is_reset || index.law_run_by(ty, method).is_some() {
        return Vec::new();
    }
    let Some(body) = Method::new(program, method, &[], 0).filter(Method::goes_on) else { return Vec::new() };
    let Some(written) = body.written() else { return Vec::new() };
    let does = |name: &&String| {
        let owners = index.methods(ty, name);
        let mut laws = owners.iter().filter_map(MethodOwner::function).peekable();
        laws.peek().is_some()
            && laws.all(|law| {
                let runs_it = || Method::new(program, law, &[], 0).is_some_and(|law| law.runs(method));
                let state = written_fields(program, law);
                let is_alike = || def.name.split('_').any(|word| word == first_word(name)) || runs_it();
                // What goes on with all of several fields does so whatever it is called: `insert` beside `process`.
                state.is_some_and(|state| {
                    !state.is_empty() && state.is_subset(&written) && (state.len() > 1 || is_alike())
                })
            })
    };
    let halves = spec.law.iter().enumerate();
    halves.filter_map(|(half, group)| Some((half, group.methods.iter().find(does)?.clone()))).collect()
}

/// The same for a function that is lent states of laws that are functions themselves: by the number of the parameter, whatever the
/// function is called.
pub fn stands_in_for_states(program: &Program<'_>, function: FunctionId) -> Vec<(usize, usize, String)> {
    let index = program.index;
    let def = index.function(function);
    let scope = index.scope_of(function);
    let skip = usize::from(def.function.receiver.is_some());
    let mut found = Vec::new();
    for (number, ty) in (skip..).zip(&def.function.params) {
        let Ty::Ref(true, ty) = index.lower(ty, &scope) else { continue };
        let laws = index.laws_of_state(&ty);
        let is_own = |(law, ..): &(FunctionId, usize, usize)| *law == index.origin(function);
        if laws.is_empty()
            || laws.iter().any(is_own)
            || index.reset_by(&Def::Function(index.origin(function))).is_some()
            || index.state_spec(&ty).is_some_and(|spec| is_reset(spec, &def.name))
        {
            continue;
        }
        let Some(written) =
            on_parameter(program, function, number, 0).filter(Method::goes_on).and_then(|it| it.written())
        else {
            continue;
        };
        for (law, at, half) in laws {
            let state = on_parameter(program, law, at, 0).and_then(|law| law.written());
            if state.is_some_and(|state| !state.is_empty() && state.is_subset(&written)) {
                found.push((number, half, index.function(law).name.clone()));
            }
        }
    }
    found
}

/// What a function does with a parameter that has a name.
pub(super) fn on_parameter<'p, 'a>(
    program: &'p Program<'a>,
    id: FunctionId,
    number: usize,
    depth: u32,
) -> Option<Method<'p, 'a>> {
    let pat = program.index.function(id).function.body.as_ref()?.params.get(number)?;
    let local = program.typed(id)?.pat_local.get(pat)?;
    Method::of(program, id, &[], depth, *local)
}

fn is_reset(spec: &FilterSpec, name: &str) -> bool {
    spec.resets.iter().chain(&spec.partial_resets).any(|own| own == name)
}

fn first_word(name: &str) -> &str {
    name.split('_').next().unwrap_or(name)
}

/// What empties a field of the standard library, or only lends it.
const CLEARING: &[&str] = &["clear", "fill", "truncate", "reset", "iter_mut"];

impl Method<'_, '_> {
    fn runs(&self, other: FunctionId) -> bool {
        let mut calls = (0u32..).map(ExprId).take(self.body.exprs.len());
        calls.any(|id| self.targets(id).is_some_and(|targets| targets.contains(&other)))
    }

    /// Whether what it writes goes on from what `self` was before: it reads a field that it writes, or something in one goes on.
    fn goes_on(&self) -> bool {
        let Some(written) = self.written() else { return false };
        // What is only assigned to, cleared or called on is not read.
        let mut places = BTreeSet::new();
        let mut is_called_on = false;
        for id in (0u32..).map(ExprId).take(self.body.exprs.len()) {
            match &self.body.expr(id).kind {
                ExprKind::Assign { place, .. } => {
                    places.insert(*place);
                }
                ExprKind::AssignOp { place, .. } => is_called_on |= self.field(*place).is_some(),
                ExprKind::MethodCall { receiver, method, .. } => {
                    let is_own = self.is_self(*receiver) || self.field(*receiver).is_some();
                    if is_own && self.writes(id, *receiver) {
                        places.insert(*receiver);
                        is_called_on |= match self.targets(id) {
                            Some(targets) => targets.iter().any(|target| {
                                Self::new(self.program, *target, &[], self.depth + 1).is_some_and(|it| it.goes_on())
                            }),
                            None => !CLEARING.contains(&method.as_str()),
                        };
                    }
                }
                _ => {}
            }
        }
        // The parts of such a place are none of their own.
        let inside = |id: ExprId| match &self.body.expr(id).kind {
            ExprKind::Field { base, .. } | ExprKind::Index { base, .. } => Some(*base),
            ExprKind::Deref(inner) | ExprKind::Reference { value: inner, .. } => Some(*inner),
            _ => None,
        };
        let mut open: Vec<ExprId> = places.iter().copied().collect();
        while let Some(id) = open.pop() {
            open.extend(inside(id).filter(|part| places.insert(*part)));
        }
        let reads = |id: ExprId| !places.contains(&id) && self.field(id).is_some_and(|name| written.contains(name));
        is_called_on || (0u32..).map(ExprId).take(self.body.exprs.len()).any(reads)
    }
}
