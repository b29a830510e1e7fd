//! Light type inference: what each expression of a body is, which local a name means, which body a call runs.
//!
//! It knows what constructors, annotations, fields and signatures say, and the wrappers of the standard library; what it
//! cannot know is `Unknown`, never a guess.

mod adapted;
mod awaited;
mod builtin;
mod calls;
mod closure_params;
mod coercions;
mod collected;
mod expr;
mod guards;
mod indexed;
mod infer;
mod inherent;
mod methods;
mod named;
mod paths;
mod pattern;
mod primitive;
mod probing;
mod tested;
mod unify;
mod unread;

use std::collections::BTreeMap;

use rustc_hash::FxHashMap;

use crate::index::{BodyOwner, Def, FunctionId, Index, MethodOwner, Ty};
use crate::source::Span;
use crate::syntax::tree::{ExprId, PatId};

pub use adapted::ADAPTED;
pub use awaited::{Awaited, awaited, future_behind};
pub use builtin::{is_lock, is_pointer, is_transparent, opens_cell};
pub use calls::names_constructor;
pub use indexed::Indexed;
pub use infer::param_types;

/// A variable of a body.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct LocalId(pub u32);

/// A variable: a parameter, or a name bound by a pattern.
#[derive(Clone, Debug)]
pub struct Local {
    /// Its name.
    pub name: String,
    /// Its type.
    pub ty: Ty,
    /// Where it is bound.
    pub span: Span,
    /// Whether it is bound by `ref` or `ref mut`.
    pub by_ref: bool,
}

/// What is called.
#[derive(Clone, Debug)]
pub enum Callee {
    /// A function or method of the analysed code, or the law of a filter.
    Resolved(Resolved),
    /// `Some(x)`, `Wrapper(x)`, `Enum::Variant(x)`
    Constructor(Option<Def>),
    /// A closure of the same body.
    Closure(ExprId),
    /// A value of a type that can only be called: `f` with `F: FnMut()`.
    Parameter(LocalId),
    /// A method of the standard library on a known type.
    Builtin,
    /// A function outside the analysed code.
    External(String),
    /// Nothing is known.
    Unknown,
}

/// A call whose target is known.
#[derive(Clone, Debug)]
pub struct Resolved {
    /// The bodies that may run: one, or all impls of a trait's method.
    pub targets: Vec<FunctionId>,
    /// Where it was found.
    pub owner: Option<MethodOwner>,
    /// The half of the law that it runs, if the receiver is a filter.
    pub law: Option<usize>,
    /// The type of `self`, behind references and pointers.
    pub self_ty: Ty,
    /// Whether the first argument of the call is `self`.
    pub has_receiver: bool,
    /// The `Deref` impls that lead from the receiver to `self`, in order.
    pub derefs: Vec<FunctionId>,
}

/// What the inference found out about a body.
#[derive(Debug, Default)]
pub struct TypedBody {
    /// The variables.
    pub locals: Vec<Local>,
    /// The type of each expression.
    pub expr_ty: Vec<Ty>,
    /// The variable that a path means.
    pub expr_local: FxHashMap<ExprId, LocalId>,
    /// What another path means.
    pub expr_def: FxHashMap<ExprId, Def>,
    /// The variable that a pattern binds.
    pub pat_local: FxHashMap<PatId, LocalId>,
    /// The variant, type or constant that a pattern names.
    pub pat_def: FxHashMap<PatId, Def>,
    /// The lengths of the arrays that slice patterns take apart, where they are known.
    pub pat_length: FxHashMap<PatId, u64>,
    /// What each call runs.
    pub callees: BTreeMap<ExprId, Callee>,
    /// The `Deref` impls through which a reference becomes the one that is asked for: `fn gyro(&mut self) -> &mut Lag { &mut self.gyro }`.
    pub coerced: FxHashMap<ExprId, Vec<FunctionId>>,
    /// What each closure is given, also where its patterns bind no name.
    pub closure_params: FxHashMap<ExprId, Vec<Ty>>,
    /// What `[]` runs where the analysed code says what it means.
    pub indexed: FxHashMap<ExprId, Indexed>,
    /// What a path to a function runs where it is called: `Filter::update` in `for_each(Filter::update)`.
    pub items: FxHashMap<ExprId, Resolved>,
}

impl TypedBody {
    /// The type of an expression.
    #[must_use]
    pub fn ty(&self, id: ExprId) -> &Ty {
        self.expr_ty.get(id.0 as usize).unwrap_or(&Ty::Unknown)
    }

    /// The variable with that id.
    #[must_use]
    pub fn local(&self, id: LocalId) -> &Local {
        &self.locals[id.0 as usize]
    }
}

/// The type of what a `for` loop takes from a value in each round.
#[must_use]
pub fn item_of(ty: &Ty) -> Option<Ty> {
    builtin::item_of(ty, false)
}

/// Infers the types of a function's, constant's or static's body; `None` if it has none.
#[must_use]
pub fn infer(index: &Index, owner: BodyOwner) -> Option<TypedBody> {
    infer::run(index, owner)
}
