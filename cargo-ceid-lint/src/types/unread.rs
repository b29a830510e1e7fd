//! What code of a filter gives that is not read: the filter where a name follows a convention, and otherwise what it is used as.

use super::calls::names_constructor;
use super::infer::Infer;
use super::{Callee, Resolved};
use crate::config::OnErr;
use crate::index::{FunctionId, Ty};
use crate::syntax::tree::{ExprId, TypeRef};

/// Where a value comes from that has no type yet: it becomes the filter where the law is called on it.
#[derive(Clone, Debug)]
pub(super) struct Origin {
    /// The filter whose code gave it.
    pub(super) filter: Ty,
    /// Whether it is a builder of that filter.
    is_builder: bool,
}

impl Infer<'_> {
    /// `Filter::name(…)` or `FilterBuilder::name(…)`, of which the body is not read.
    pub(super) fn made_by_unread(&mut self, ty: &Ty, name: &str) -> Option<Ty> {
        let built = match ty {
            Ty::External(path, _) => self.index.built_by(path),
            _ => None,
        };
        let is_filter = self.index.law_spec(ty).is_some();
        if !is_filter && built.is_none() {
            return None;
        }
        if name.strip_prefix("try_").is_some_and(names_constructor) {
            return Some(Ty::std("std::result::Result", vec![ty.clone(), Ty::Unknown]));
        }
        let is_builder = name == "builder";
        if names_constructor(name) && !is_builder {
            return Some(ty.clone());
        }
        let filter = built.unwrap_or_else(|| ty.clone());
        Some(self.variables.fresh_of(Origin { filter, is_builder }))
    }

    /// `Filter::NAME`, of which the type is not read.
    pub(super) fn constant_of_unread(&mut self, owner: &Ty, name: &str) -> Option<Ty> {
        let is_constant = !name.contains(char::is_lowercase) && self.index.law_spec(owner).is_some();
        is_constant.then(|| self.given_by(owner))
    }

    /// What unread code of a filter gives and no convention tells.
    fn given_by(&mut self, filter: &Ty) -> Ty {
        self.variables.fresh_of(Origin { filter: filter.clone(), is_builder: false })
    }

    /// Whether a method of that name runs the law of a type.
    pub(super) fn is_law(&self, ty: &Ty, method: &str) -> bool {
        self.index.law_spec(ty).is_some_and(|spec| spec.group(method).is_some())
    }

    /// A method of a filter whose sources are not read: its entry says which ones are the law.
    pub(super) fn external_filter_method(
        &mut self,
        id: ExprId,
        ty: &Ty,
        law: Option<usize>,
        args: &[ExprId],
        derefs: Vec<FunctionId>,
    ) -> Ty {
        for arg in args {
            self.expr(*arg, None);
        }
        let resolved =
            Resolved { targets: Vec::new(), owner: None, law, self_ty: ty.clone(), has_receiver: true, derefs };
        self.typed.callees.insert(id, Callee::Resolved(resolved));
        let given = self.given_by(ty);
        match (law.is_some(), self.index.law_spec(ty).map(|spec| spec.on_err)) {
            (true, Some(OnErr::Untouched)) => Ty::std("std::result::Result", vec![given, Ty::Unknown]),
            _ => given,
        }
    }

    /// A method of a builder outside the analysed code. One that is given something sets it and gives the builder back; what one
    /// gives that is given nothing may be a builder of something else.
    pub(super) fn builder_method(&mut self, id: ExprId, path: &str, method: &str, args: &[ExprId]) -> Option<Ty> {
        let made = self.index.made_by(&format!("{path}::{method}"));
        let filter = self.index.built_by(path)?;
        for arg in args {
            self.expr(*arg, None);
        }
        self.typed.callees.insert(id, Callee::External(format!("{path}::{method}")));
        Some(match made {
            Some(made) => made,
            None if args.is_empty() => self.given_by(&filter),
            None => Ty::External(path.to_owned(), Vec::new()),
        })
    }

    /// A method, not the law, of what unread code of a filter gave.
    pub(super) fn method_of_unread(
        &mut self,
        id: ExprId,
        (ty, origin): (&Ty, &Origin),
        method: &str,
        turbofish: &[TypeRef],
        args: &[ExprId],
    ) -> Ty {
        let given = self.unresolved_method(id, ty, method, turbofish, args);
        if matches!(method, "unwrap" | "expect" | "unwrap_or_else") {
            self.typed.callees.insert(id, Callee::Builtin);
            return ty.clone();
        }
        match method {
            _ if given != Ty::Unknown => given,
            "build" | "try_build" if origin.is_builder => origin.filter.clone(),
            _ if origin.is_builder && !args.is_empty() => ty.clone(),
            _ => self.given_by(&origin.filter),
        }
    }
}
