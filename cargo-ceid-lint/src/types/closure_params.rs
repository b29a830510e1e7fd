//! What closures are given: those that are passed to methods of the standard library, and those that are kept as values of a type
//! that can only be called.

use super::builtin::{arg, family, is_cell, reference};
use super::infer::Infer;
use crate::index::Ty;
use crate::syntax::tree::{Closure, ExprId, ExprKind};

/// What the first parameter of a closure is that is passed to a method of a known type.
pub(super) fn closure_params(receiver: &Ty, method: &str, args: &[Ty]) -> Vec<Ty> {
    let Ty::External(path, params) = receiver else {
        return match receiver {
            Ty::Array(inner, _) | Ty::Slice(inner) => vec![(**inner).clone()],
            Ty::Tuple(parts) if method == "lock" => {
                parts.iter().flat_map(|part| closure_params(part.peel(), method, args)).collect()
            }
            _ => Vec::new(),
        };
    };
    let name = family(path.rsplit("::").next().unwrap_or(""));
    let inner = arg(params, 0);
    if path.starts_with("ceid_core::") {
        return if method == "run" { vec![reference(inner)] } else { Vec::new() };
    }
    if is_cell(name) {
        return vec![reference(inner)];
    }
    match (name, method) {
        ("LocalKey", "with") => vec![Ty::Ref(false, Box::new(inner))],
        ("LocalKey", "with_borrow" | "with_borrow_mut") => closure_params(&inner, method, args),
        ("Iterator" | "Range", "fold" | "rfold" | "try_fold" | "scan" | "for_each_init" | "for_each_with") => {
            vec![args.first().cloned().unwrap_or(Ty::Unknown), inner]
        }
        (
            "Iterator" | "Range",
            "filter" | "inspect" | "take_while" | "skip_while" | "find" | "max_by_key" | "min_by_key" | "partition",
        ) => {
            vec![Ty::Ref(false, Box::new(inner))]
        }
        ("Iterator" | "Range", _) => vec![inner],
        ("Option", "filter") => vec![Ty::Ref(false, Box::new(inner))],
        (
            "Option" | "Poll",
            "map" | "and_then" | "map_or" | "map_or_else" | "is_some_and" | "is_none_or" | "inspect",
        ) => {
            vec![inner]
        }
        ("Result" | "LockResult", "map" | "and_then" | "map_or" | "is_ok_and" | "inspect") => vec![inner],
        ("Result", "map_err" | "or_else" | "unwrap_or_else" | "inspect_err" | "is_err_and") => vec![arg(params, 1)],
        ("Vec" | "VecDeque", "retain" | "retain_mut" | "sort_by_key" | "drain_filter") => vec![reference(inner)],
        ("HashMap" | "BTreeMap", "retain") => vec![reference(inner), reference(arg(params, 1))],
        _ => Vec::new(),
    }
}

/// What a collection or an option holds, if that can only be called.
pub(super) fn held_callback(receiver: &Ty) -> Option<&Ty> {
    match receiver.peel() {
        Ty::External(_, params) => params.last().filter(|held| held.called_as().is_some()),
        _ => None,
    }
}

impl Infer<'_> {
    /// Walks a closure; `given` are the types that its caller passes.
    pub(super) fn closure(&mut self, id: ExprId, closure: &Closure, given: &[Ty]) -> Ty {
        let known = self.typed.closure_params.get(&id).cloned().unwrap_or_default();
        let mut params = Vec::new();
        for (number, (_, written)) in closure.params.iter().enumerate() {
            let ty = known.get(number).cloned().unwrap_or_else(|| self.annotation(written));
            if let Some(given) = given.get(number) {
                self.variables.unify(&ty, given);
            }
            params.push(ty);
        }
        self.typed.closure_params.insert(id, params.clone());
        let result = match self.closure_outputs.get(&id) {
            Some(ty) => ty.clone(),
            None => self.variables.fresh(),
        };
        self.closure_outputs.insert(id, result.clone());
        let outer = std::mem::replace(&mut self.output, result.clone());
        let breaks = std::mem::take(&mut self.break_tys);
        let found = self.in_scope(|this| {
            for ((pat, _), ty) in closure.params.iter().zip(&params) {
                let ty = this.variables.shallow(ty);
                this.pat(*pat, &ty, None);
            }
            this.expr(closure.body, Some(&result))
        });
        self.output = outer;
        self.break_tys = breaks;
        self.variables.unify(&result, &found);
        Ty::Closure(id.0)
    }

    /// What a closure is given that is to be a value of this type: `fn(&mut Rig)`, `Box<dyn FnMut(&mut Rig)>`.
    pub(super) fn called_with(&self, expected: Option<&Ty>) -> Vec<Ty> {
        let Some(expected) = expected.map(|ty| self.shallow_deep(ty)) else { return Vec::new() };
        match expected.called_as() {
            Some((params, _)) => params,
            None => match expected {
                Ty::Function(params, _) => params,
                _ => Vec::new(),
            },
        }
    }

    /// An argument of a function of the standard library that puts it into what it makes: of a closure is known what it is given,
    /// where it is known what the result is called with, as in `Slot { run: Box::new(|rig| rig.step()) }`.
    pub(super) fn wrapped(&mut self, id: ExprId, expected: Option<&Ty>) -> Ty {
        let is_closure = matches!(self.body.expr(id).kind, ExprKind::Closure(_));
        self.expr(id, expected.filter(|_| is_closure))
    }
}
