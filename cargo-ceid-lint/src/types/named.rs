//! Functions that are called or passed on by a path that says more than their names: the types written in it, and whose they are.

use super::Callee;
use super::builtin;
use super::infer::Infer;
use super::paths::Value;
use crate::index::{Def, FunctionId, MethodOwner, Ty};
use crate::syntax::tree::{ExprId, ExprKind, GenericArg, Path, TypeRef};

impl Infer<'_> {
    /// A call of a function that is known, with the types that its path writes.
    pub(super) fn call_function(
        &mut self,
        id: ExprId,
        function: FunctionId,
        args: &[ExprId],
        written: Vec<Ty>,
        expected: Option<&Ty>,
    ) -> Ty {
        let resolved = self.function_item(function);
        let output = self.instantiate(function, None, args, resolved.has_receiver, (written, expected));
        self.typed.callees.insert(id, Callee::Resolved(resolved));
        output
    }

    /// The types that a path writes for the parameters of a function, in their order: `make::<Lag>()`. None where one is left out.
    pub(super) fn written_types(&mut self, function: FunctionId, path: &Path) -> Vec<Ty> {
        let written = path.segments.last().map(|segment| segment.args.as_slice()).unwrap_or_default();
        let params = &self.index.function(function).function.generics.params;
        if written.len() != params.len() {
            return Vec::new();
        }
        let types = params.iter().zip(written).filter(|(param, _)| !param.is_const).map(|(_, written)| match written {
            GenericArg::Type(ty) => self.annotation(ty),
            _ => self.variables.fresh(),
        });
        types.collect()
    }

    /// The same of a method: `registry.get::<Lag>()`.
    pub(super) fn turbofish_types(&mut self, function: FunctionId, turbofish: &[TypeRef]) -> Vec<Ty> {
        let params = &self.index.function(function).function.generics.params;
        if turbofish.len() != params.len() || params.iter().any(|param| param.is_const) {
            return Vec::new();
        }
        turbofish.iter().map(|ty| self.annotation(ty)).collect()
    }

    /// What a function gives whose crate is not read and whose path says what it reads: `serde_json::from_str::<Lag>(text)?`.
    pub(super) fn read_as_written(&mut self, made: Ty, path: &Path) -> Ty {
        if let (Ty::Unknown, [owner, name]) = (&made, path.segments.as_slice())
            && is_converting(&name.name)
        {
            let owner = self.index.lower(&TypeRef::Path(Path::plain(&[&owner.name])), &self.scope);
            if matches!(owner, Ty::Int | Ty::Float | Ty::Char | Ty::Bool) {
                return Ty::std("std::result::Result", vec![owner, Ty::Unknown]);
            }
        }
        let Some(segment) = path.segments.last().filter(|segment| segment.name.starts_with("from_")) else {
            return made;
        };
        match segment.args.as_slice() {
            [GenericArg::Type(ty)] if made == Ty::Unknown => {
                let read = self.annotation(ty);
                Ty::std("std::result::Result", vec![read, Ty::Unknown])
            }
            _ => made,
        }
    }

    /// What a function gives that is passed on by its path: `map(Lag::new)`, and those of which there is no body,
    /// `resize_with(4, Lag::default)`, `map(Rc::clone)`, `map(Mutex::new)`. `found` is its type, and `given` what it is given.
    pub(super) fn output_of_named(&mut self, function: ExprId, found: &Ty, given: Option<&Ty>) -> Option<Ty> {
        if let Ty::FunctionItem(id) = found {
            return Some(self.index.lower(&self.index.function(*id).function.output, &self.index.scope_of(*id)));
        }
        let body = self.body;
        let ExprKind::Path(path) = &body.expr(function).kind else { return None };
        match self.value_path(path) {
            Value::ExternalAssoc(owner, name) => match (name.as_str(), owner) {
                ("default", owner) => Some(owner),
                ("clone", _) => given.map(|given| given.peel().clone()),
                ("new", Ty::External(path, _)) if builtin::is_transparent(path.rsplit("::").next().unwrap_or("")) => {
                    given.map(|given| Ty::External(path, vec![given.clone()]))
                }
                _ => None,
            },
            Value::Assoc(..) if path.segments.len() > 1 && path.last() == "clone" => {
                given.map(|given| given.peel().clone())
            }
            // `map(Lag)`, `map(Slot::Filled)`, `map(Some)`
            Value::Def(Def::Type(of) | Def::Variant(of, _)) => Some(self.fresh_adt(of)),
            Value::Def(Def::External(path)) if path.ends_with("::Some") => {
                given.map(|given| Ty::std("std::option::Option", vec![given.clone()]))
            }
            _ => None,
        }
    }

    /// A constructor's `Self` is what is expected of its result.
    pub(super) fn unify_constructed(&mut self, owner: &MethodOwner, ty: &Ty, expected: &Ty) {
        let Some(function) = owner.function() else { return };
        if matches!(&self.index.function(function).function.output, TypeRef::Path(path) if path.ident() == Some("Self"))
        {
            self.variables.unify(ty, expected);
        }
    }
}

/// Whether a function of a type of the standard library gives a value of the type, or nothing: `NonZeroU8::new(count)`.
pub(super) fn may_be_none(path: &str, name: &str) -> bool {
    path.starts_with("std::num::NonZero") && name == "new"
}

/// Whether a function of a type of the standard library gives a value of the type, or an error.
pub(super) fn may_fail(path: &str, name: &str) -> bool {
    match path {
        "std::fs::File" => matches!(name, "open" | "create" | "create_new"),
        "std::net::TcpStream" | "std::os::unix::net::UnixStream" => matches!(name, "connect" | "connect_timeout"),
        "std::net::UdpSocket" | "std::net::TcpListener" | "std::os::unix::net::UnixDatagram" => name == "bind",
        _ => path.rsplit("::").next().is_some_and(|owner| owner.starts_with(char::is_uppercase)) && is_converting(name),
    }
}

/// Whether a function that makes a value of its type gives a `Result`: `u8::try_from(reading)`.
fn is_converting(name: &str) -> bool {
    matches!(name, "try_from" | "from_str" | "from_str_radix")
}
