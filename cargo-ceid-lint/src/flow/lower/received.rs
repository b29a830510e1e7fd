//! Functions that do little more than receive a message for their caller: `fn next(events: &Receiver<Event>) -> Event`.

use super::constants::Constants;
use crate::flow::Program;
use crate::index::{Def, FunctionId, Shape, Ty};
use crate::syntax::tree::{Body, ExprId, ExprKind, PatId, StmtKind};
use crate::types::{Callee, LocalId, TypedBody};

/// Names of methods that receive a message or an event.
const RECEIVING: &[&str] = &[
    "recv",
    "receive",
    "try_recv",
    "try_receive",
    "recv_timeout",
    "pop",
    "pop_front",
    "dequeue",
    "select",
    "select3",
    "select4",
    "try_next",
    "try_iter",
    "drain",
];

/// Whether a method receives a message or an event, as far as its name tells.
#[must_use]
pub fn is_receiving(name: &str) -> bool {
    let is_event = |noun: &str| matches!(noun, "event" | "evt" | "ev" | "message" | "msg");
    let asks = |verb: &str| matches!(verb, "next" | "wait" | "poll" | "read" | "get" | "pop");
    RECEIVING.contains(&name)
        || name.trim_start_matches("try_").split_once('_').is_some_and(|(verb, noun)| asks(verb) && is_event(noun))
}

/// Whether a method says that it receives, and what or how: `recv_into_buffer`, `receive_frame`.
#[must_use]
pub fn is_receiving_something(name: &str) -> bool {
    let name = name.trim_start_matches("try_");
    ["recv_", "receive_"].iter().any(|verb| name.starts_with(verb))
}

/// Whether a method waits for something to come, as far as its name tells: what it gives may be an event, or a time that is up.
#[must_use]
pub fn is_waiting(name: &str) -> bool {
    matches!(name, "wait" | "listen") || name.starts_with("wait_for_")
}

/// Whether a method says that it asks how something is, which is no event that it waits for: `mode.lock().await`,
/// `status.flight_mode().await`, but not `next_state().await`.
#[must_use]
pub fn asks_state(name: &str) -> bool {
    let mut words = name.split('_').filter(|word| !word.is_empty());
    let is_waiting =
        words.next().is_some_and(|first| matches!(first, "next" | "wait" | "on" | "take" | "pop" | "poll"));
    let is_state = name.rsplit('_').next().is_some_and(|last| matches!(last, "mode" | "state" | "status" | "phase"));
    name == "lock" || is_state && !is_waiting
}

/// How many functions that call each other are looked into, and how large they may be.
const MAX_DEPTH: u32 = 3;
const MAX_EXPRESSIONS: usize = 60;

/// How many values are followed in a function.
const MAX_VALUES: u32 = 32;

/// The method with which the function that a call runs receives what it gives back. A function that was given and gives one of
/// several messages stands for such a method, and so does the `next` of a trait of the analysed code.
pub(super) fn received_by<'a>(own: Constants<'a>, call: ExprId) -> Option<&'a str> {
    let gives_message = || is_message(*own.program, own.typed.ty(call));
    let has_no_body = |target: &FunctionId| own.program.index.function(*target).function.body.is_none();
    match own.typed.callees.get(&call)? {
        _ if polls_messages(own, call) => Some("poll_event"),
        Callee::Parameter(_) if gives_message() => Some("recv"),
        Callee::Resolved(resolved) if resolved.targets.iter().all(has_no_body) => {
            let is_next = matches!(&own.body.expr(call).kind, ExprKind::MethodCall { method, .. } if method == "next");
            (is_next && gives_message()).then_some("recv")
        }
        callee => called(*own.program, callee, 0),
    }
}

/// `while let Some(event) = poll() { match event { … } }`
fn polls_messages(own: Constants<'_>, call: ExprId) -> bool {
    let name = match &own.body.expr(call).kind {
        ExprKind::MethodCall { method, args, .. } if args.is_empty() => method,
        ExprKind::Call { callee, args } if args.is_empty() => match &own.body.expr(*callee).kind {
            ExprKind::Path(path) => path.last(),
            _ => return false,
        },
        _ => return false,
    };
    let content = match own.typed.ty(call) {
        Ty::External(_, args) => args.first(),
        _ => None,
    };
    name == "poll" && content.is_some_and(|content| is_message(*own.program, content))
}

/// Whether a type is an enum of which some variants carry something, and which no struct keeps as its state.
fn is_message(program: Program<'_>, ty: &Ty) -> bool {
    let Ty::Adt(id, _) = ty else { return false };
    let Shape::Enum(variants) = &program.index.type_def(*id).shape else { return false };
    variants.len() > 1
        && variants.iter().any(|variant| !variant.fields.fields.is_empty())
        && !program.index.is_kept(*id)
}

fn called<'a>(program: Program<'a>, callee: &Callee, depth: u32) -> Option<&'a str> {
    let Callee::Resolved(resolved) = callee else { return None };
    let mut targets = resolved.targets.iter().map(|target| Function::of(program, *target, depth)?.received());
    let first = targets.next()??;
    targets.all(|other| other.is_some()).then_some(first)
}

struct Function<'a> {
    program: Program<'a>,
    body: &'a Body,
    typed: &'a TypedBody,
    depth: u32,
}

impl<'a> Function<'a> {
    fn of(program: Program<'a>, id: FunctionId, depth: u32) -> Option<Self> {
        let body = program.index.function(id).function.body.as_ref()?;
        let is_small = depth < MAX_DEPTH && body.exprs.len() <= MAX_EXPRESSIONS;
        Some(Self { program, body, typed: program.typed(id)?, depth }).filter(|_| is_small)
    }

    /// The method that receives what the function gives back on one way at least: there may be nothing more to receive.
    fn received(&self) -> Option<&'a str> {
        let returned = self.body.exprs.iter().filter_map(|expr| match expr.kind {
            ExprKind::Return(value) => value,
            _ => None,
        });
        let mut left = MAX_VALUES;
        std::iter::once(self.body.root).chain(returned).find_map(|value| self.source(value, &mut left))
    }

    /// The method that receives a value.
    fn source(&self, id: ExprId, left: &mut u32) -> Option<&'a str> {
        *left = left.checked_sub(1)?;
        match &self.body.expr(id).kind {
            ExprKind::MethodCall { receiver, method, .. } => match self.typed.callees.get(&id) {
                Some(callee @ Callee::Resolved(resolved)) if !resolved.targets.is_empty() => {
                    called(self.program, callee, self.depth + 1)
                }
                _ if is_receiving(method) => Some(method),
                _ if is_unwrapping(method) => self.source(*receiver, left),
                _ => None,
            },
            ExprKind::Call { args, .. } => match (self.typed.callees.get(&id)?, args.as_slice()) {
                // `Some(event)`
                (Callee::Constructor(Some(Def::External(_))), [value]) => self.source(*value, left),
                (callee, _) => called(self.program, callee, self.depth + 1),
            },
            ExprKind::Try(inner) | ExprKind::Await(inner) => self.source(*inner, left),
            ExprKind::Block(block) => self.source(block.tail?, left),
            ExprKind::If { then, otherwise, .. } => {
                self.source(*then, left).or_else(|| self.source((*otherwise)?, left))
            }
            ExprKind::Match { arms, .. } => arms.iter().find_map(|arm| self.source(arm.body, left)),
            ExprKind::Path(_) => self.bound_to(*self.typed.expr_local.get(&id)?, left),
            _ => None,
        }
    }

    /// The method that receives what a pattern binds a name to.
    fn bound_to(&self, local: LocalId, left: &mut u32) -> Option<&'a str> {
        let at = self.typed.pat_local.iter().filter(|(_, bound)| **bound == local).map(|(pat, _)| *pat).min()?;
        let binds = |pat: PatId| self.body.pat(pat).span.contains(self.body.pat(at).span);
        let value = self.body.exprs.iter().find_map(|expr| match &expr.kind {
            ExprKind::Let { pat, value } if binds(*pat) => Some(*value),
            ExprKind::Match { scrutinee, arms } if arms.iter().any(|arm| binds(arm.pat)) => Some(*scrutinee),
            ExprKind::Block(block) => block.stmts.iter().find_map(|stmt| match stmt.kind {
                StmtKind::Let { pat, init, .. } if binds(pat) => init,
                _ => None,
            }),
            _ => None,
        });
        self.source(value?, left)
    }
}

/// Methods that give what is there, or something else in its place.
fn is_unwrapping(method: &str) -> bool {
    method.starts_with("unwrap") || matches!(method, "expect" | "ok" | "cloned" | "copied" | "ok_or" | "map_err")
}
