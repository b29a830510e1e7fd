//! Flags that are raised once and never taken back: `static READY: AtomicBool`, or such a field.

use super::Program;
use crate::index::{Def, FunctionId, Ty, TypeId, ValueId};
use crate::syntax::tree::{Body, ExprId, ExprKind, Literal, PatKind};

/// A flag that is changed through a shared reference.
#[derive(Clone, Copy, Debug)]
pub enum Flag<'a> {
    /// A static.
    Static(ValueId),
    /// A field of a type of the analysed code.
    Field(TypeId, &'a str),
}

impl Program<'_> {
    /// Whether all that the analysed code does with a flag is to load it and to raise it.
    #[must_use]
    pub fn is_only_raised(&self, flag: Flag<'_>) -> bool {
        let name = self.flag_name(flag);
        // Which names other statics and constants mean is not looked at.
        let of_values = self.index.values.iter().filter_map(|value| value.item.value.as_ref());
        if of_values.into_iter().any(|body| body.exprs.iter().any(|expr| mentions(&expr.kind, name))) {
            return false;
        }
        let mut is_raised = false;
        self.index.function_ids().all(|id| {
            let Some(body) = &self.index.function(id).function.body else { return true };
            match self.uses_in(id, body, flag) {
                Some(raises) => {
                    is_raised |= raises;
                    true
                }
                None => false,
            }
        }) && is_raised
    }

    fn flag_name<'n>(&'n self, flag: Flag<'n>) -> &'n str {
        match flag {
            Flag::Static(id) => &self.index.value(id).name,
            Flag::Field(_, name) => name,
        }
    }

    /// Whether a function raises a flag; `None` if it does anything else with it than that and loading it.
    fn uses_in(&self, id: FunctionId, body: &Body, flag: Flag<'_>) -> Option<bool> {
        let name = self.flag_name(flag);
        let typed = self.typed(id);
        let is_flag = |id: ExprId| {
            let kind = &body.expr(id).kind;
            match (flag, kind) {
                (Flag::Static(flag), _) => match typed.and_then(|typed| typed.expr_def.get(&id)) {
                    Some(def) => *def == Def::Value(flag),
                    None => mentions(kind, name) && typed.is_none_or(|typed| !typed.expr_local.contains_key(&id)),
                },
                // What has no known type may be the owner.
                (Flag::Field(owner, _), ExprKind::Field { base, name: field, .. }) => {
                    let ty = typed.map_or(&Ty::Unknown, |typed| typed.ty(*base).peel());
                    field == name && !matches!(ty, Ty::Adt(id, _) if *id != owner)
                }
                (Flag::Field(..), ExprKind::Opaque(_) | ExprKind::Unknown { .. }) => mentions(kind, name),
                (Flag::Field(..), _) => false,
            }
        };
        let is_bound = |pat: &PatKind| match pat {
            PatKind::Struct(_, fields) => fields.iter().any(|(field, _)| field == name),
            _ => false,
        };
        if matches!(flag, Flag::Field(..)) && body.pats.iter().any(|pat| is_bound(&pat.kind)) {
            return None;
        }
        let is_true = |id: &ExprId| matches!(body.expr(*id).kind, ExprKind::Literal(Literal::Bool(true)));
        let (mut loads, mut raises) = (0, 0);
        for expr in &body.exprs {
            match &expr.kind {
                ExprKind::MethodCall { receiver, method, args, .. } if is_flag(*receiver) => match method.as_str() {
                    "load" => loads += 1,
                    "store" | "swap" | "fetch_or" if args.first().is_some_and(is_true) => raises += 1,
                    _ => return None,
                },
                _ => {}
            }
        }
        let used = (0u32..).map(ExprId).take(body.exprs.len()).filter(|id| is_flag(*id)).count();
        (used == loads + raises).then_some(raises > 0)
    }
}

/// Whether an expression is a path that ends with a name, or something unread in which it occurs.
fn mentions(kind: &ExprKind, name: &str) -> bool {
    match kind {
        ExprKind::Path(path) => path.last() == name,
        ExprKind::Opaque(call) => call.mentions.iter().any(|own| own == name),
        ExprKind::Unknown { mentions, .. } => mentions.iter().any(|own| own == name),
        _ => false,
    }
}
