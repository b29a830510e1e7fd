//! Loops that update their filters in a function which they call once per iteration: the guard goes into that function.

use super::body::LoopBody;
use super::loops::Loops;
use crate::count::{Cycle, CycleKind, Pair, Verdict};
use crate::source::Span;
use crate::syntax::tree::{ExprId, ExprKind};
use crate::types::{Callee, Resolved};

/// The function through whose one call a loop updates all of these filters, as a cycle of its own with what it updates. It does the
/// same for all who call it, whether a guard updates them there or not.
pub(super) fn called(loops: &Loops<'_>, cycle: &Cycle, by_hand: &[&Pair]) -> Option<Cycle> {
    let of = LoopBody::find(loops, cycle.head).filter(|of| !of.is_function)?;
    let call = the_call(by_hand)?;
    let callee = of.inside.iter().filter(|id| of.span(**id) == call).find_map(|id| resolved(&of, *id))?;
    let [function] = callee.targets.as_slice() else { return None };
    let index = loops.program.index;
    let def = index.function(*function);
    let krate = index.crate_of(def.module);
    let is_ours = krate.is_reported && !loops.is_left_alone(def.function.keyword.file);
    if callee.law.is_some() || *function == of.function || !is_ours {
        return None;
    }
    let body = LoopBody::find(loops, def.function.keyword).filter(|body| body.is_function)?;
    let mut filters: Vec<Pair> = Vec::new();
    for id in body.inside.iter().copied() {
        let Some(half) = resolved(&body, id).and_then(|callee| callee.law) else { continue };
        let receiver = match body.kind(id) {
            ExprKind::MethodCall { receiver, .. } => *receiver,
            ExprKind::Call { args, .. } => *args.first()?,
            _ => continue,
        };
        let name = body.written(receiver).trim_start_matches("&mut ").to_owned();
        match filters.iter_mut().find(|pair| pair.name == name && pair.half == half) {
            Some(pair) => pair.updates.push(body.span(id)),
            None => filters.push(Pair { name, half, updates: vec![body.span(id)], ..(*by_hand.first()?).clone() }),
        }
    }
    let updates = filters.iter().flat_map(|pair| &pair.updates).count();
    // What does nothing but update would be a guard and nothing else, and what another function updates is not among them.
    (filters.len() == by_hand.len() && statements(&body) > updates).then(|| Cycle {
        package: krate.package,
        target: krate.target,
        head: def.function.keyword,
        kind: CycleKind::Function,
        is_presumed: false,
        function: index.function_name(*function),
        period: cycle.period,
        filters,
    })
}

/// The one call by which all of them are updated exactly once.
fn the_call(by_hand: &[&Pair]) -> Option<Span> {
    let first = by_hand.first()?.updates.first().copied()?;
    let is_it = |pair: &&Pair| pair.verdict == Verdict::Once && pair.updates == [first];
    by_hand.iter().all(is_it).then_some(first)
}

fn resolved<'b>(of: &LoopBody<'b>, id: ExprId) -> Option<&'b Resolved> {
    match of.typed.callees.get(&id) {
        Some(Callee::Resolved(resolved)) => Some(resolved),
        _ => None,
    }
}

fn statements(of: &LoopBody<'_>) -> usize {
    match of.kind(of.block) {
        ExprKind::Block(block) => block.stmts.len() + usize::from(block.tail.is_some()),
        _ => 0,
    }
}
