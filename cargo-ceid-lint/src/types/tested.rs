//! Variables whose values come from code that is not read, and that are asked for what options and results are asked for.

use std::collections::BTreeMap;

use super::LocalId;
use super::infer::Infer;
use crate::index::{Def, Ty};
use crate::syntax::tree::{ExprId, ExprKind, PatId, PatKind};

/// What a variable is by the questions to it.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Asked {
    Option,
    Result,
}

impl Asked {
    fn of_variant(name: &str) -> Option<Self> {
        match name {
            "Some" | "None" => Some(Self::Option),
            "Ok" | "Err" => Some(Self::Result),
            _ => None,
        }
    }

    fn of_method(name: &str) -> Option<Self> {
        match name {
            "is_some" | "is_none" | "is_some_and" | "is_none_or" => Some(Self::Option),
            "is_ok" | "is_err" | "is_ok_and" | "is_err_and" => Some(Self::Result),
            _ => None,
        }
    }

    fn ty(self) -> Ty {
        match self {
            Self::Option => Ty::std("std::option::Option", vec![Ty::Unknown]),
            Self::Result => Ty::std("std::result::Result", vec![Ty::Unknown, Ty::Unknown]),
        }
    }
}

impl Infer<'_> {
    /// Gives variables of an unknown type the one that all questions to them tell: `let z = imu.gyro(); if let Ok(v) = z { … }`.
    pub(super) fn type_tested(&mut self) {
        let mut found: BTreeMap<LocalId, Option<Asked>> = BTreeMap::new();
        for (at, expr) in (0u32..).map(ExprId).zip(&self.body.exprs) {
            let (asked, told) = match &expr.kind {
                ExprKind::Let { pat, value } => (*value, self.asked_by(*pat)),
                ExprKind::Match { scrutinee, arms } => (*scrutinee, arms.iter().find_map(|arm| self.asked_by(arm.pat))),
                ExprKind::MethodCall { receiver, method, .. } => (*receiver, Asked::of_method(method)),
                _ => continue,
            };
            let Some(told) = told else { continue };
            let Some(local) = self.untyped_local(asked).filter(|_| asked != at) else { continue };
            let known = found.entry(local).or_insert(Some(told));
            *known = known.filter(|known| *known == told);
        }
        for (local, asked) in found {
            let Some(asked) = asked else { continue };
            for (at, expr) in (0u32..).map(ExprId).zip(&self.body.exprs) {
                if self.untyped_local(at) == Some(local) {
                    self.typed.expr_ty[at.0 as usize] = match &expr.kind {
                        ExprKind::Reference { mutable, .. } => Ty::Ref(*mutable, Box::new(asked.ty())),
                        _ => asked.ty(),
                    };
                }
            }
            self.typed.locals[local.0 as usize].ty = asked.ty();
        }
    }

    /// What a pattern of the standard library asks for.
    fn asked_by(&self, pat: PatId) -> Option<Asked> {
        match &self.body.pat(pat).kind {
            PatKind::TupleStruct(path, _) | PatKind::Path(path)
                if matches!(self.typed.pat_def.get(&pat), Some(Def::External(_))) =>
            {
                Asked::of_variant(path.last())
            }
            PatKind::Reference(inner) => self.asked_by(*inner),
            PatKind::Or(pats) => pats.iter().find_map(|pat| self.asked_by(*pat)),
            _ => None,
        }
    }

    /// The variable of an unknown type that an expression names, or lends.
    fn untyped_local(&self, id: ExprId) -> Option<LocalId> {
        match &self.body.expr(id).kind {
            ExprKind::Reference { value, .. } => self.untyped_local(*value),
            ExprKind::MethodCall { receiver, method, .. } if matches!(method.as_str(), "as_ref" | "as_mut") => {
                self.untyped_local(*receiver)
            }
            ExprKind::Path(_) => {
                let local = self.typed.expr_local.get(&id).copied()?;
                (self.typed.local(local).ty == Ty::Unknown).then_some(local)
            }
            _ => None,
        }
    }
}
