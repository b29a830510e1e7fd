//! What a call gives a reference to: it stays where it is, and another call of the same gives a reference to it again.

use crate::flow::lower::Builder;
use crate::flow::{Base, CallSite, Effect, Place, Projection};
use crate::index::{FunctionId, Ty};
use crate::syntax::tree::{ExprId, ExprKind};
use crate::types::Callee;

impl Builder<'_> {
    /// Whether a reference leads to a place, so that what is read there stays there.
    pub(in crate::flow::lower) fn is_lent(&self, place: &Place) -> bool {
        let Some(var) = place.base_var() else { return false };
        let mut ty = self.graph.var(var).ty.clone();
        let mut steps = place.steps.iter();
        loop {
            if wraps_reference(&ty) {
                return true;
            }
            let inner = match steps.next() {
                Some(Projection::Field(name)) => match &ty {
                    Ty::Tuple(parts) => name.parse::<usize>().ok().and_then(|number| parts.get(number).cloned()),
                    owner => self.program.index.field_ty(owner, None, name),
                },
                Some(_) => ty.element().cloned(),
                None => None,
            };
            let Some(inner) = inner else { return false };
            ty = inner;
        }
    }

    /// The field behind the reference that a getter gives, if it does nothing else: `*rig.speed_mut()` is `rig.speed`.
    pub(in crate::flow::lower) fn field_lent(&mut self, call: ExprId) -> Option<Place> {
        let Some(Callee::Resolved(resolved)) = self.typed().callees.get(&call) else { return None };
        if resolved.law.is_some() || !resolved.derefs.is_empty() || !matches!(self.ty(call), Ty::Ref(..)) {
            return None;
        }
        let targets = resolved.targets.clone();
        let owner = match &self.body().expr(call).kind {
            ExprKind::MethodCall { receiver, .. } => *receiver,
            ExprKind::Call { args, .. } => *args.first()?,
            _ => return None,
        };
        self.field_lent_by(&targets, owner)
    }

    /// The field of a place to which a function gives a reference, whatever else it is given.
    pub(super) fn field_lent_by(&mut self, targets: &[FunctionId], owner: ExprId) -> Option<Place> {
        let [target] = targets else { return None };
        let names = self.field_named_by(*target)?;
        let owner = self.static_place(owner).filter(|_| self.at.is_some())?;
        Some(names.iter().rev().fold(owner, |place, name| place.field(name)))
    }

    /// The names of the field of its first parameter that is all that a function refers to, the last one first.
    fn field_named_by(&self, function: FunctionId) -> Option<Vec<String>> {
        let getter = self.program.index.function(function).function.body.as_ref()?;
        let typed = self.program.typed(function)?;
        let owner = typed.pat_local.get(getter.params.first()?)?;
        let (mut at, mut names, mut is_lent) = (getter.root, Vec::new(), false);
        loop {
            match &getter.expr(at).kind {
                ExprKind::Block(block) if block.stmts.is_empty() && !is_lent => at = block.tail?,
                ExprKind::Reference { value, raw: false, .. } if !is_lent => {
                    is_lent = true;
                    at = *value;
                }
                ExprKind::Field { base, name } if is_lent && matches!(typed.ty(*base).peel(), Ty::Adt(..)) => {
                    names.push(name.clone());
                    at = *base;
                }
                ExprKind::Path(_) if typed.expr_local.get(&at) == Some(owner) && !names.is_empty() => {
                    return Some(names);
                }
                _ => return None,
            }
        }
    }

    /// Whether two places are the same of what two calls of the same give a reference to:
    /// `let mut f = *s.low_pass(); f.update(x); *s.low_pass() = f;`
    pub(in crate::flow::lower) fn is_lent_again(&self, place: &Place, origin: &Place) -> bool {
        place.steps == origin.steps && self.lent_again(origin).contains(&place.base)
    }

    /// What else stands for what a call gave a reference to: what other calls of the same function with the same arguments gave.
    pub(in crate::flow::lower) fn lent_again(&self, origin: &Place) -> Vec<Base> {
        let calls = || {
            self.graph.nodes.iter().filter_map(|node| match &node.effect {
                Effect::Call(site) => Some(&**site),
                _ => None,
            })
        };
        let Some(var) = origin.base_var().filter(|_| self.is_lent(origin)) else { return Vec::new() };
        let Some(own) = calls().find(|site| site.result == var) else { return Vec::new() };
        calls()
            .filter(|site| site.result != var && is_alike(site, own))
            .map(|site| Place::var(site.result).base)
            .collect()
    }
}

/// Whether a type is a reference, or one that may be missing: what is in a wrapper has the place of that.
fn wraps_reference(ty: &Ty) -> bool {
    match ty {
        Ty::Ref(..) => true,
        Ty::External(_, args) if matches!(ty.external_name(), Some("Option" | "Result" | "Poll" | "Box")) => {
            args.first().is_some_and(wraps_reference)
        }
        _ => false,
    }
}

/// Whether two calls ask the same functions for the same.
fn is_alike(one: &CallSite, other: &CallSite) -> bool {
    let mut args = one.args.iter().zip(&other.args);
    // `bank[0]` is read by `index` and written by `index_mut`.
    one.args.len() == other.args.len()
        && !one.targets.is_empty()
        && (one.targets == other.targets || one.text == other.text)
        && args.all(|(one, other)| {
            let is_known = one.place.is_some() || one.index.is_some() || one.head.is_some();
            is_known && one.place == other.place && one.index == other.index && one.head == other.head
        })
}
