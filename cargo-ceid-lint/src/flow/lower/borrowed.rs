//! What a body borrows by `&mut`, and what it does with it.

use std::cell::OnceCell;

use rustc_hash::FxHashSet;

use super::{Builder, Value};
use crate::flow::{Assignment, Effect, IndexKey, NodeId, Resized};
use crate::index::{FunctionId, Ty};
use crate::syntax::tree::{Body, ExprId, ExprKind, PatId, PatKind, Receiver, StmtKind};
use crate::types::{Callee, LocalId, TypedBody};

/// The locals of a body that are assigned or borrowed mutably somewhere.
pub(super) fn mutated_locals(body: &Body, typed: &TypedBody) -> FxHashSet<LocalId> {
    let targets = body.exprs.iter().flat_map(|expr| match &expr.kind {
        ExprKind::Assign { place, .. } | ExprKind::AssignOp { place, .. } => body.assigned_places(*place),
        ExprKind::Reference { mutable: true, value, .. } => vec![*value],
        _ => Vec::new(),
    });
    targets.filter_map(|target| typed.expr_local.get(&target).copied()).collect()
}

/// What is given to calls as it is, or taken apart by a pattern or by its fields: what happens to it there is known.
pub(super) fn passed(body: &Body, typed: &TypedBody) -> FxHashSet<ExprId> {
    let mut found = FxHashSet::default();
    let whole = OnceCell::new();
    let is_apart = |local: &LocalId| !whole.get_or_init(|| named_as_a_whole(body, typed)).contains(local);
    for (id, expr) in (0u32..).map(ExprId).zip(&body.exprs) {
        match &expr.kind {
            ExprKind::Call { args, .. } | ExprKind::MethodCall { args, .. } if is_followed(typed.callees.get(&id)) => {
                found.extend(args.iter().copied());
            }
            ExprKind::Match { scrutinee, .. } => found.extend([*scrutinee]),
            ExprKind::Let { value, .. } => found.extend([*value]),
            ExprKind::Block(block) => {
                found.extend(block.stmts.iter().filter_map(|stmt| match stmt.kind {
                    StmtKind::Let { pat, init, .. } => {
                        init.filter(|init| is_taken_apart(body, typed, pat, *init, &is_apart))
                    }
                    _ => None,
                }));
            }
            _ => {}
        }
    }
    found
}

/// Whether what a call does with the references that it gets is known: what only keeps them for later leaves it to others to write by
/// them, as a constructor, `iter::once(&mut flag)` and `Pin::new(&mut flag)` do.
fn is_followed(callee: Option<&Callee>) -> bool {
    match callee {
        Some(Callee::Constructor(_) | Callee::Builtin) => false,
        Some(Callee::External(path)) => !path.starts_with("std::") || path.starts_with("std::mem::"),
        _ => true,
    }
}

/// Whether what is lent to a pattern has a name only for parts of it: `let config = &mut self.config; config.gain = gain;`
fn is_taken_apart(
    body: &Body,
    typed: &TypedBody,
    pat: PatId,
    init: ExprId,
    is_apart: &impl Fn(&LocalId) -> bool,
) -> bool {
    if !matches!(body.expr(init).kind, ExprKind::Reference { mutable: true, .. }) {
        return false;
    }
    match &body.pat(pat).kind {
        PatKind::Struct(..) | PatKind::Tuple(_) | PatKind::TupleStruct(..) => true,
        PatKind::Bind { sub: None, .. } => typed.pat_local.get(&pat).is_some_and(is_apart),
        _ => false,
    }
}

/// The locals that are named somewhere for more than a field of them.
fn named_as_a_whole(body: &Body, typed: &TypedBody) -> FxHashSet<LocalId> {
    let owner = |kind: &ExprKind| if let ExprKind::Field { base, .. } = kind { Some(*base) } else { None };
    let owners: FxHashSet<ExprId> = body.exprs.iter().filter_map(|expr| owner(&expr.kind)).collect();
    typed.expr_local.iter().filter(|(id, _)| !owners.contains(id)).map(|(_, local)| *local).collect()
}

impl Builder<'_> {
    /// A `&mut` to what holds no filter comes about: who has it may write by it, until the place is used under its own name again.
    pub(super) fn note_lent(&mut self, id: ExprId) {
        if self.at.is_some()
            && !self.may_hold_filter(self.ty(id))
            && let Some(place) = self.static_place(id)
        {
            self.written_unseen(place, self.span(id));
        }
    }

    /// What a trait of another crate provides may run what a type implements of that trait: `tones.nth(2)`, `log.write_all(b"x")`.
    pub(super) fn note_provided(&mut self, receiver: ExprId, method: &str) {
        if !only_reads(method) && self.program.index.implements_what_is_not_read(self.ty(receiver).peel()) {
            self.note_lent(receiver);
        }
    }

    /// A `&mut` that has a name goes into a value that is made: `Switch(flag)`, where `flag` is a parameter.
    pub(super) fn note_lent_on(&mut self, expr: ExprId) {
        let is_named = !matches!(self.body().expr(expr).kind, ExprKind::Reference { .. });
        if is_named && matches!(self.ty(expr), Ty::Ref(true, _)) {
            self.note_lent(expr);
        }
    }

    /// What a call gives may hold the references that it got, and write by them later: `let mut switch = Switch::new(&mut flag);`.
    pub(super) fn note_lent_for_longer(&mut self, id: ExprId, targets: &[FunctionId], exprs: &[ExprId]) {
        let index = self.program.index;
        if !index.holds_writer(self.ty(id)) {
            return;
        }
        // What a reference leads to that a method gives is followed, as is the one that is lent.
        let lends = matches!(self.ty(id), Ty::Ref(..));
        let is_exclusive =
            targets.iter().any(|target| index.function(*target).function.receiver == Some(Receiver::Exclusive));
        for expr in exprs {
            match self.body().expr(*expr).kind {
                ExprKind::Reference { mutable: true, value, .. } => self.note_lent(value),
                _ if self.is_receiver(id, *expr) && is_exclusive && !lends => self.note_lent(*expr),
                _ if !self.is_receiver(id, *expr) => self.note_lent_on(*expr),
                _ => {}
            }
        }
    }

    /// The same for what a method of the standard library lends, or writes itself: `flags.iter_mut()`, `flags.reverse()`.
    pub(super) fn note_lent_by(&mut self, receiver: ExprId, method: &str) {
        if method.ends_with("_mut") {
            let first = self.graph.nodes.len();
            self.note_lent(receiver);
            self.note_resized(first, receiver, method, &[]);
            return;
        }
        let is_in_place = matches!(method, "reverse" | "fill" | "swap" | "rotate_left" | "rotate_right" | "sort")
            || method.starts_with("sort_");
        let is_shared = super::flags::is_flag(self.ty(receiver)) || super::flags::is_shared_number(self.ty(receiver));
        if is_in_place
            && self.at.is_some()
            && !is_shared
            && !self.program.index.holds_filter(self.ty(receiver))
            && let Some(place) = self.static_place(receiver)
        {
            // Which elements change is not known; what they belong to is still the same.
            self.written_unseen(place.element(IndexKey::Data(method.into())), self.span(receiver));
        }
    }

    /// Notes what a method does to the length of a collection, of which it is known since a node that the method writes it.
    pub(super) fn note_resized(&mut self, first: usize, receiver: ExprId, method: &str, args: &[ExprId]) {
        // What a map holds by then is not known.
        let Some(at) = self.at.filter(|_| !super::sources::is_map(self.ty(receiver).peel())) else { return };
        let Some(collection) = self.static_place(receiver) else { return };
        let writes =
            |id: NodeId| matches!(&self.graph.node(id).effect, Effect::Write(write) if write.place == collection);
        let mut writing: Vec<NodeId> = (u32::try_from(first).unwrap_or(u32::MAX)..at.0).map(NodeId).collect();
        writing.retain(|id| writes(*id));
        if !writes(at) {
            return;
        }
        let resized = match (method, args) {
            ("drain", [range]) => self.drained_length(*range),
            ("truncate", [number]) => self.number(*number).map(Resized::HeldAt),
            ("insert", [_, _]) => Some(Resized::Grows),
            _ => Resized::by(method),
        };
        let Some(resized) = resized else { return };
        self.graph.resized.insert(at, resized);
        self.graph.resized.extend(writing.into_iter().map(|id| (id, Resized::Kept)));
    }

    /// A collection of filters that gets another length is written, and none of the filters in it.
    pub(super) fn note_filters_resized(&mut self, id: ExprId, receiver: ExprId, method: &str) {
        let ty = self.ty(receiver).peel();
        let is_resized = changes_receiver(method) && Resized::by(method) != Some(Resized::Kept);
        if self.at.is_none()
            || !is_resized
            || matches!(self.typed().callees.get(&id), Some(Callee::Resolved(_)))
            || !ty.external_name().is_some_and(|name| GROWING.iter().any(|end| name.ends_with(end)))
            || !self.may_hold_filter(ty)
        {
            return;
        }
        if let Some(place) = self.static_place(receiver) {
            let write = Assignment { rebinds: false, ..super::parts::given_to(place.length(), None) };
            self.emit(Effect::Write(Box::new(write)), self.span(id));
        }
    }

    /// What taking a range out of a collection does to its length: `frame.drain(..4)`.
    fn drained_length(&mut self, range: ExprId) -> Option<Resized> {
        let ExprKind::Range { start, end, inclusive } = self.body().expr(range).kind else { return None };
        let first = start.map_or(Some(0), |start| self.number(start))?;
        match end {
            None => Some(if first == 0 { Resized::Emptied } else { Resized::HeldAt(first) }),
            Some(end) => Some(Resized::Shrinks((self.number(end)? + u64::from(inclusive)).saturating_sub(first))),
        }
    }

    /// What becomes of the elements that a method takes out of a collection is no business of the collection's.
    pub(super) fn note_taken_out(&mut self, method: &str, collection: &Value) {
        let takes = method.starts_with("pop")
            || matches!(method, "remove" | "remove_entry" | "swap_remove" | "dequeue" | "drain");
        if let Some(place) = collection.place.as_ref().filter(|_| takes) {
            self.graph.taken_out.insert(place.element(IndexKey::Each));
        }
    }
}

/// How the names of collections end that get longer and shorter.
const GROWING: &[&str] = &["Vec", "Deque", "Map", "Set", "List", "Heap"];

/// Whether a method of that name only reads what it is called on, as those of the standard library do.
pub(super) fn only_reads(method: &str) -> bool {
    matches!(
        method,
        "clone"
            | "to_string"
            | "fmt"
            | "eq"
            | "ne"
            | "cmp"
            | "partial_cmp"
            | "hash"
            | "as_ref"
            | "borrow"
            | "to_owned"
            | "len"
            | "is_empty"
            | "into"
            | "try_into"
            | "serialize"
            | "type_id"
            | "lt"
            | "le"
            | "gt"
            | "ge"
    )
}

/// Whether a method of the standard library changes what it is called on, whatever the type.
pub(super) fn changes_receiver(method: &str) -> bool {
    method.ends_with("_assign")
        || matches!(
            method,
            "append"
                | "clear"
                | "clone_from"
                | "clone_from_slice"
                | "copy_from_slice"
                | "dedup"
                | "dedup_by"
                | "dedup_by_key"
                | "dequeue"
                | "drain"
                | "enqueue"
                | "entry"
                | "extend"
                | "extend_from_slice"
                | "fill"
                | "fill_with"
                | "get_or_insert"
                | "get_or_insert_with"
                | "insert"
                | "make_ascii_lowercase"
                | "make_ascii_uppercase"
                | "pop"
                | "pop_back"
                | "pop_first"
                | "pop_front"
                | "pop_last"
                | "push"
                | "push_back"
                | "push_front"
                | "push_str"
                | "remove"
                | "remove_entry"
                | "replace"
                | "resize"
                | "resize_with"
                | "retain"
                | "reverse"
                | "rotate_left"
                | "rotate_right"
                | "shift_remove"
                | "sort"
                | "sort_by"
                | "sort_by_key"
                | "sort_unstable"
                | "sort_unstable_by"
                | "split_off"
                | "swap"
                | "swap_remove"
                | "take"
                | "take_if"
                | "truncate"
        )
}
