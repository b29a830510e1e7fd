//! States in cells, which are changed through shared references: `self.mode.get()`, `*self.mode.borrow()`.

use super::super::{Builder, Value};
use super::is_flag;
use crate::flow::{Cause, Effect, Place, Var};
use crate::index::{Def, Shape, Ty};
use crate::source::Span;
use crate::syntax::tree::{ExprId, ExprKind};

/// Whether a type is a reference or handle to a cell, or a cell.
pub(in crate::flow::lower) fn leads_to_cell(ty: &Ty) -> bool {
    match ty.peel() {
        ty @ Ty::External(_, args) => match ty.external_name() {
            Some("Cell" | "RefCell") => true,
            Some("Rc" | "Arc" | "Box" | "Option" | "Pin") => args.first().is_some_and(leads_to_cell),
            _ => false,
        },
        _ => false,
    }
}

/// Whether a type is a cell of which a reference to what it holds is borrowed, or a handle to one.
pub(in crate::flow::lower) fn is_borrowed_from(ty: &Ty) -> bool {
    match ty.peel() {
        ty @ Ty::External(_, args) => match ty.external_name() {
            Some("RefCell") => true,
            Some("Rc" | "Arc" | "Box") => args.first().is_some_and(is_borrowed_from),
            _ => false,
        },
        _ => false,
    }
}

impl Builder<'_> {
    /// Notes that others may have a reference to what lies in a variable.
    pub(in crate::flow::lower) fn note_lent_cell(&mut self, id: ExprId, value: &Value) {
        let var = value.place.as_ref().and_then(Place::base_var);
        self.graph.cells.lent.extend(var.filter(|_| self.holds_cell(self.ty(id), 0)));
    }

    /// Notes that a closure or future which runs beside others has a reference to what it names.
    pub(in crate::flow::lower) fn share_cells(&mut self, beside: &Value) {
        let named = beside.closure.map(|closure| self.captured_vars(closure)).unwrap_or_default();
        let cells = named.into_iter().filter(|var| self.holds_cell(&self.graph.var(*var).ty, 0));
        let cells: Vec<Var> = cells.collect();
        self.graph.cells.lent.extend(cells);
    }

    /// Notes that a variable gets a handle to a cell that is made for it.
    pub(in crate::flow::lower) fn note_own_cell(&mut self, bound: &[Var], init: ExprId) {
        if let ([var], ExprKind::Call { callee, .. }) = (bound, &self.body().expr(init).kind)
            && let ExprKind::Path(path) = &self.body().expr(*callee).kind
            && matches!(path.last(), "new" | "default" | "from" | "new_cyclic")
            && leads_to_cell(self.ty(init))
        {
            self.graph.cells.own.insert(*var);
        }
    }

    /// Whether there is a cell in a value of a type, or in what that leads to.
    fn holds_cell(&self, ty: &Ty, depth: u32) -> bool {
        const MAX_DEPTH: u32 = 4;
        let index = self.program.index;
        let go = |ty: &Ty| depth < MAX_DEPTH && self.holds_cell(ty, depth + 1);
        match ty {
            _ if leads_to_cell(ty) => true,
            Ty::Ref(_, inner) | Ty::Array(inner, _) | Ty::Slice(inner) => go(inner),
            Ty::Tuple(parts) | Ty::External(_, parts) => parts.iter().any(go),
            Ty::Adt(id, _) => match &index.type_def(*id).shape {
                Shape::Struct(fields) => {
                    let mut fields = fields.fields.iter().filter_map(|field| index.field_ty(ty, None, &field.name));
                    fields.any(|field| go(&field))
                }
                _ => false,
            },
            _ => false,
        }
    }

    /// Notes that something unseen runs that may write cells: what is called by its value, or gets something with a cell.
    pub(in crate::flow::lower) fn may_write_cells(&mut self, call: ExprId, text: &str, args: &[ExprId], span: Span) {
        let is_called_by_value = match &self.body().expr(call).kind {
            ExprKind::Call { callee, .. } => {
                let is_path = matches!(self.body().expr(*callee).kind, ExprKind::Path(_));
                let is_value = !is_path || self.typed().expr_local.contains_key(callee);
                is_value && !matches!(self.ty(*callee), Ty::Function(..) | Ty::FunctionItem(_))
            }
            _ => false,
        };
        if self.at.is_some() && (is_called_by_value || args.iter().any(|arg| self.holds_cell(self.ty(*arg), 0))) {
            self.emit(Effect::Unknown { places: Vec::new(), cause: Cause::Call(text.to_owned()) }, span);
        }
    }

    /// Whether an expression is a cell in a static that interrupts and other threads see as well: what it holds may be another value
    /// whenever it is read. One of `thread_local!` is reached through a key.
    pub(in crate::flow::lower) fn is_cell_of_static(&self, id: ExprId) -> bool {
        let mut at = id;
        while let ExprKind::Field { base, .. } | ExprKind::Index { base, .. } | ExprKind::Deref(base) =
            &self.body().expr(at).kind
        {
            at = *base;
        }
        match self.typed().expr_def.get(&at) {
            Some(Def::Value(value)) => {
                let item = &self.program.index.value(*value).item;
                item.is_static && !item.is_of_thread() && leads_to_cell(self.ty(id))
            }
            _ => false,
        }
    }

    /// The place of the state that an expression reads out of a cell as it is.
    pub(in crate::flow::lower) fn state_in_cell(&mut self, id: ExprId) -> Option<Place> {
        let body = self.body();
        match &body.expr(id).kind {
            ExprKind::MethodCall { receiver, method, args, .. } if self.is_state(self.ty(id)) => {
                let reads = match (method.as_str(), args.len()) {
                    _ if self.is_cell_of_static(*receiver) => false,
                    ("get", 0) => self.is_cell(*receiver),
                    ("load", 1) => is_flag(self.ty(*receiver)) && self.is_exclusive(*receiver),
                    _ => false,
                };
                let place = if reads { self.static_place(*receiver) } else { None };
                self.graph.cells.read.extend(place.clone());
                place
            }
            ExprKind::Deref(inner) if self.is_state(self.ty(id)) || *self.ty(id) == Ty::Int => {
                self.borrowed_cell(*inner)
            }
            _ => None,
        }
    }

    /// The place of the cell of which an expression borrows what it holds, to read it.
    pub(in crate::flow::lower) fn borrowed_cell(&mut self, id: ExprId) -> Option<Place> {
        let ExprKind::MethodCall { receiver, method, args, .. } = &self.body().expr(id).kind else { return None };
        let borrows = method == "borrow"
            && args.is_empty()
            && is_borrowed_from(self.ty(*receiver))
            && !self.is_cell_of_static(*receiver)
            && !self.may_hold_filter(self.ty(*receiver));
        let place = if borrows { self.static_place(*receiver) } else { None };
        self.graph.cells.read.extend(place.clone());
        place
    }

    /// Whether nothing else can change what a place holds while this code has it: no static, and nothing behind a shared handle.
    pub(in crate::flow::lower) fn is_exclusive(&self, id: ExprId) -> bool {
        let ty = self.ty(id);
        let is_shared = matches!(ty, Ty::Ref(false, _)) || self.program.index.is_handle(ty);
        !is_shared
            && match &self.body().expr(id).kind {
                ExprKind::Path(_) => self.typed().expr_local.contains_key(&id),
                ExprKind::Field { base, .. } | ExprKind::Index { base, .. } | ExprKind::Deref(base) => {
                    self.is_exclusive(*base)
                }
                _ => false,
            }
    }

    /// A variable with the state that a cell held before something else is put there.
    pub(in crate::flow::lower) fn taken_from_cell(&mut self, place: &Place, ty: Ty, span: Span) -> Var {
        let taken = self.temporary(ty, span);
        let old = Value { place: Some(place.clone()), ..Value::default() };
        self.set(taken, &old, span);
        self.note_taken(taken, &old);
        taken
    }

    /// Notes that the last node gives a cell the state that a value is.
    pub(in crate::flow::lower) fn note_put_in_cell(&mut self, given: &Value, expr: ExprId) {
        if !self.is_state(self.ty(expr)) {
            return;
        }
        if let Some(at) = self.at
            && let Effect::Write(write) = &mut self.graph.nodes[at.0 as usize].effect
        {
            write.same_as = given.same_as;
        }
        self.note_copy(expr);
    }
}
