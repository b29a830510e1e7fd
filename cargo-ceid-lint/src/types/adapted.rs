//! Filters whose laws have another form: ceid-core's `Adapted` has one form here, whether its sources are read or not.

use super::Callee;
use super::infer::Infer;
use crate::index::Ty;
use crate::syntax::tree::{ExprId, ExprKind};

/// The type of ceid-core that lends a filter and has a closure as its law.
pub const ADAPTED: &str = "ceid_core::Adapted";

impl Infer<'_> {
    /// Whether a type is ceid-core's `Adapted`.
    pub(super) fn is_adapted(&self, ty: &Ty) -> bool {
        match ty {
            Ty::External(path, _) => path == ADAPTED,
            Ty::Adt(id, _) => {
                let def = self.index.type_def(*id);
                def.name == "Adapted" && self.index.crate_of(def.module).name == "ceid_core"
            }
            _ => false,
        }
    }

    /// Whether a type is one of ceid-core's.
    pub(super) fn is_of_core(&self, ty: &Ty) -> bool {
        match ty {
            Ty::External(path, _) => path.starts_with("ceid_core::"),
            Ty::Adt(id, _) => self.index.crate_of(self.index.type_def(*id).module).name == "ceid_core",
            _ => false,
        }
    }

    /// `Adapted::new(&mut filter, law)`: the filter, what the law is fed with, and what it gives back.
    pub(super) fn adapted(&mut self, id: ExprId, function: &str, args: &[ExprId]) -> Ty {
        let body = self.body;
        let filter = args.first().map_or(Ty::Unknown, |filter| self.expr(*filter, None));
        let input = self.variables.fresh();
        for law in args.iter().skip(1) {
            match &body.expr(*law).kind {
                ExprKind::Closure(closure) => {
                    let ty = self.closure(*law, closure, &[filter.clone(), input.clone()]);
                    self.typed.expr_ty[law.0 as usize] = ty;
                }
                _ => drop(self.expr(*law, None)),
            }
        }
        let output = self.closure_output(args.get(1).copied());
        self.typed.callees.insert(id, Callee::External(format!("{ADAPTED}::{function}")));
        Ty::External(ADAPTED.to_owned(), vec![filter, input, output])
    }
}
