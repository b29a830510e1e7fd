//! Macros that tell how what they are given is written: where `assert!(self.lp.y < 2.0)` fails, its text is in the panic.

use super::Reason;
use super::body::LoopBody;
use super::loops::Loops;
use super::mentions::{Guarded, Mention};
use crate::syntax::tree::{ExprKind, MacroExpr, MacroKind};

/// What such a macro tells in other words then.
pub(super) struct Worded {
    pub(super) reason: Reason,
    /// Whether somebody may look at it.
    pub(super) is_change: bool,
}

/// What is told in other words where a place is written in another way.
pub(super) fn worded(loops: &Loops<'_>, of: &LoopBody<'_>, own: &Guarded, mention: &Mention) -> Option<Worded> {
    if own.name == own.spelled || mention.edit.is_none() && mention.elements.is_empty() {
        return None;
    }
    let around = of.ancestors_inside(mention.at).find_map(|at| match of.kind(at) {
        ExprKind::Macro(call) => Some((at, call, teller(call)?)),
        _ => None,
    });
    let (at, call, teller) = around?;
    let (when, is_change) = match teller {
        Teller::Panic => ("panics", of.are_panics_caught || loops.are_panics_expected(of.function)),
        Teller::Error => ("fails", true),
        Teller::Print => ("prints", false),
    };
    let text = format!("where `{}!` {when}, it tells of `{}` instead of `{}`", name(call), own.name, own.spelled);
    Some(Worded { reason: Reason { span: of.span(at), text }, is_change })
}

/// Where a macro tells what it was given.
#[derive(Clone, Copy, Debug)]
enum Teller {
    Panic,
    Error,
    Print,
}

fn teller(call: &MacroExpr) -> Option<Teller> {
    match &call.kind {
        // A message stands in the place of the text.
        MacroKind::Assert(_, message) => message.is_empty().then_some(Teller::Panic),
        MacroKind::DebugOnly(_, message) => {
            (message.is_empty() && name(call) == "debug_assert").then_some(Teller::Panic)
        }
        MacroKind::Ensure(_, message) => message.is_empty().then_some(Teller::Error),
        MacroKind::All(_) => matches!(name(call), "dbg" | "rdbg" | "hdbg" | "udbg").then_some(Teller::Print),
        _ => None,
    }
}

fn name(call: &MacroExpr) -> &str {
    call.path.rsplit("::").next().unwrap_or(&call.path).trim()
}
