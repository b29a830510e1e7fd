//! `value[key]` where the analysed code says what that means: an `index` to read, an `index_mut` to write.

use rustc_hash::FxHashMap;

use super::infer::Infer;
use super::{Callee, builtin};
use crate::index::{FunctionId, ImplId, MethodOwner, Owner, Ty};
use crate::syntax::tree::{ExprId, ExprKind, MacroKind, PatId, PatKind, Receiver};

/// How many pointers and `Deref` impls are gone through.
const MAX_DEREFS: usize = 8;

/// What `[]` runs.
#[derive(Clone, Debug, Default)]
pub struct Indexed {
    /// The `Deref` impls that lead to what is indexed, in order.
    pub derefs: Vec<FunctionId>,
    /// What may run; nothing if what is indexed is an array, a slice or a collection.
    pub targets: Vec<FunctionId>,
    /// Whether what it gives may be written.
    pub is_exclusive: bool,
}

/// The two methods that `[]` may mean.
#[derive(Clone, Debug, Default)]
pub(super) struct Indexers {
    shared: Vec<FunctionId>,
    exclusive: Vec<FunctionId>,
}

/// What is done with what `[]` gives.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Use {
    Read,
    Written,
    /// What a call does is not known.
    Either,
}

impl Infer<'_> {
    /// The type of `base[index]`.
    pub(super) fn index_ty(&mut self, id: ExprId, base: &Ty, index: &Ty) -> Ty {
        let index = self.shallow_deep(index);
        let is_range = index.external_name() == Some("Range");
        let mut ty = self.variables.shallow(base);
        let mut derefs = Vec::new();
        for _ in 0..MAX_DEREFS {
            match &ty {
                Ty::Ref(_, inner) => ty = self.variables.shallow(&inner.clone()),
                Ty::Array(inner, _) | Ty::Slice(inner) => {
                    let found = if is_range { Ty::Slice(inner.clone()) } else { (**inner).clone() };
                    self.note_indexed(id, derefs, Indexers::default());
                    return found;
                }
                Ty::External(path, args) => {
                    let name = path.rsplit("::").next().unwrap_or("");
                    if builtin::is_pointer(name) && !args.is_empty() {
                        ty = self.variables.shallow(&args[0].clone());
                        continue;
                    }
                    let at = usize::from(name.ends_with("Map"));
                    let item = args.get(at).cloned().unwrap_or(Ty::Unknown);
                    self.note_indexed(id, derefs, Indexers::default());
                    return if is_range { Ty::Slice(Box::new(item)) } else { item };
                }
                Ty::Adt(..) => {
                    if let Some((output, own)) = self.indexers(&ty, &index) {
                        self.note_indexed(id, derefs, own);
                        return output;
                    }
                    let Some((target, through)) = self.user_deref(&ty) else { return Ty::Unknown };
                    derefs.push(through);
                    ty = target;
                }
                _ => return Ty::Unknown,
            }
        }
        Ty::Unknown
    }

    fn note_indexed(&mut self, id: ExprId, derefs: Vec<FunctionId>, own: Indexers) {
        if !derefs.is_empty() || !own.shared.is_empty() {
            self.indexers.insert(id, own);
            self.typed.indexed.insert(id, Indexed { derefs, ..Indexed::default() });
        }
    }

    /// The impls of a type that take such an index, with what they give; `None` if it has none.
    fn indexers(&self, ty: &Ty, index: &Ty) -> Option<(Ty, Indexers)> {
        let mut own = Indexers::default();
        let mut output = None;
        for id in self.index.impls_of(ty) {
            let def = self.index.impl_def(id);
            let Some(name) = &def.implements else { continue };
            let name = self.index.trait_text(name);
            let method = match name.as_str() {
                "Index" => "index",
                "IndexMut" => "index_mut",
                _ => continue,
            };
            let Some(function) = def.methods.get(method).copied().filter(|of| self.takes_index(*of, index)) else {
                continue;
            };
            if name == "Index" {
                own.shared.push(function);
                output = output.or_else(|| self.impl_output(id, ty));
            } else {
                own.exclusive.push(function);
            }
        }
        Some((output?, own))
    }

    fn impl_output(&self, id: ImplId, ty: &Ty) -> Option<Ty> {
        let def = self.index.impl_def(id);
        let scope = self.owner_scope(def.module, Owner::Impl(id));
        let written = def.types.get("Output")?;
        Some(self.index.lower(written, &scope).substitute(&self.index.impl_args(id, ty)))
    }

    fn takes_index(&self, function: FunctionId, index: &Ty) -> bool {
        let param = self.index.function(function).function.params.first();
        param.is_some_and(|param| self.index.lower(param, &self.index.scope_of(function)).admits(index))
    }

    /// Decides which of the two each `[]` runs, by what is done with what it gives.
    pub(super) fn settle_indexed(&mut self) {
        if self.indexers.is_empty() {
            return;
        }
        let mut uses: FxHashMap<ExprId, Use> = FxHashMap::default();
        for id in (0u32..).map(ExprId).take(self.body.exprs.len()) {
            for (place, how) in self.uses_of(id) {
                self.note_uses(place, how, &mut uses);
            }
        }
        for (id, own) in std::mem::take(&mut self.indexers) {
            let how = uses.get(&id).copied().unwrap_or(Use::Read);
            let Some(indexed) = self.typed.indexed.get_mut(&id) else { continue };
            indexed.is_exclusive = how != Use::Read;
            indexed.targets = match how {
                Use::Read => own.shared,
                _ if own.exclusive.is_empty() => own.shared,
                Use::Written => own.exclusive,
                Use::Either => [own.exclusive, own.shared].concat(),
            };
        }
    }

    /// What is written through a place is written through each `[]` on the way to it.
    fn note_uses(&self, place: ExprId, how: Use, uses: &mut FxHashMap<ExprId, Use>) {
        let mut at = place;
        loop {
            match &self.body.expr(at).kind {
                ExprKind::Index { base, .. } => {
                    let known = uses.entry(at).or_insert(how);
                    if *known != how {
                        *known = Use::Either;
                    }
                    at = *base;
                }
                ExprKind::Field { base, .. } => at = *base,
                ExprKind::Deref(inner) if !matches!(self.typed.ty(*inner), Ty::Ref(false, _) | Ty::Pointer(_)) => {
                    at = *inner;
                }
                _ => return,
            }
        }
    }

    /// The places that an expression writes or lends to be written, or may.
    fn uses_of(&self, id: ExprId) -> Vec<(ExprId, Use)> {
        let body = self.body;
        match &body.expr(id).kind {
            ExprKind::Assign { place, .. } => {
                body.assigned_places(*place).into_iter().map(|place| (place, Use::Written)).collect()
            }
            ExprKind::AssignOp { place, .. } => vec![(*place, Use::Written)],
            ExprKind::Reference { mutable: true, value, .. } => vec![(*value, Use::Written)],
            ExprKind::MethodCall { receiver, method, .. } => vec![(*receiver, self.use_by(id, *receiver, method))],
            // `queue[0](x)`, which may be an `FnMut`.
            ExprKind::Call { callee, .. } => vec![(*callee, Use::Either)],
            ExprKind::Match { scrutinee, arms } => {
                arms.iter().map(|arm| (*scrutinee, self.use_by_pattern(*scrutinee, arm.pat))).collect()
            }
            ExprKind::Let { pat, value } => vec![(*value, self.use_by_pattern(*value, *pat))],
            ExprKind::Block(block) => {
                let of_let = |pat: PatId, init: ExprId| (init, self.use_by_pattern(init, pat));
                let lets = block.stmts.iter().filter_map(|stmt| match &stmt.kind {
                    crate::syntax::tree::StmtKind::Let { pat, init, .. } => Some(of_let(*pat, (*init)?)),
                    crate::syntax::tree::StmtKind::Expr { .. } => None,
                });
                lets.collect()
            }
            // `write!(out[0], "…")`
            ExprKind::Macro(call) if call.path.contains("write") => match &call.kind {
                MacroKind::All(operands) => operands.first().map(|first| (*first, Use::Either)).into_iter().collect(),
                _ => Vec::new(),
            },
            _ => Vec::new(),
        }
    }

    fn use_by(&self, id: ExprId, receiver: ExprId, method: &str) -> Use {
        let ty = self.typed.ty(receiver);
        match self.typed.callees.get(&id) {
            Some(Callee::Resolved(resolved)) => {
                let receivers = resolved.targets.iter().map(|target| &self.index.function(*target).function.receiver);
                let uses = receivers.map(|receiver| match receiver {
                    Some(Receiver::Exclusive) => Use::Written,
                    Some(Receiver::Shared) => Use::Read,
                    // What is passed on is lent again.
                    Some(Receiver::Value) if !matches!(ty, Ty::Ref(true, _)) => Use::Read,
                    _ => Use::Either,
                });
                let declared = resolved.owner.as_ref().and_then(MethodOwner::function);
                let of_declared = declared.map(|function| self.index.function(function).function.receiver.clone());
                match uses.reduce(|all, how| if all == how { all } else { Use::Either }) {
                    Some(how) => how,
                    None if of_declared == Some(Some(Receiver::Shared)) => Use::Read,
                    None if of_declared == Some(Some(Receiver::Exclusive)) => Use::Written,
                    None => Use::Either,
                }
            }
            // What has its own lock is written through a shared reference.
            _ if ty.external_name().is_some_and(|name| name.ends_with("Cell") || name.starts_with("Atomic")) => {
                Use::Read
            }
            _ if matches!(ty, Ty::Int | Ty::Float | Ty::Bool | Ty::Char | Ty::Str | Ty::Ref(false, _)) => Use::Read,
            _ if matches!(
                method,
                "clone" | "len" | "is_empty" | "iter" | "get" | "contains" | "to_owned" | "lock" | "read"
            ) =>
            {
                Use::Read
            }
            _ if method.starts_with("is_") || method.starts_with("as_") && !method.ends_with("_mut") => Use::Read,
            _ if method.ends_with("_mut") => Use::Written,
            _ => Use::Either,
        }
    }

    fn use_by_pattern(&self, value: ExprId, pat: PatId) -> Use {
        // What a mutable reference leads to is lent again.
        let is_lent_again = matches!(self.typed.ty(value), Ty::Ref(true, _));
        if is_lent_again || self.binds_exclusively(pat) { Use::Either } else { Use::Read }
    }

    /// Whether a name of a pattern is bound by `ref mut`.
    fn binds_exclusively(&self, pat: PatId) -> bool {
        match &self.body.pat(pat).kind {
            PatKind::Bind { by_ref, mutable, sub, .. } => {
                *by_ref && *mutable || sub.is_some_and(|sub| self.binds_exclusively(sub))
            }
            PatKind::Tuple(pats) | PatKind::TupleStruct(_, pats) | PatKind::Or(pats) | PatKind::Slice(pats) => {
                pats.iter().any(|pat| self.binds_exclusively(*pat))
            }
            PatKind::Struct(_, fields) => fields.iter().any(|(_, pat)| self.binds_exclusively(*pat)),
            PatKind::Reference(pat) => self.binds_exclusively(*pat),
            _ => false,
        }
    }
}
