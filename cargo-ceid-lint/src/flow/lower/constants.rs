//! Numbers, times and heads that the source fixes. What depends on anything that may change has no value.

use super::Builder;
use super::numbers::limit_of_type;
use super::subjects::external_head;
use crate::flow::{Head, Place, Program};
use crate::index::{BodyOwner, Def, FunctionId, Shape, TraitId, TraitName, Ty, TypeId, ValueId};
use crate::syntax::tree::{Body, ExprId, ExprKind, Literal, MacroKind, Path, StmtKind, TypeRef};
use crate::types::{Callee, TypedBody};

/// A number, or a time in seconds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Constant {
    Number(f64),
    Seconds(f64),
}

/// How deep names and operators are followed.
const MAX_DEPTH: u32 = 32;

/// How many expressions a constant may have that is looked into: a table has neither value nor head.
const MAX_LENGTH: usize = 64;

/// A body in which constants are looked for.
#[derive(Clone, Copy)]
pub(super) struct Constants<'a> {
    pub(super) program: &'a Program<'a>,
    pub(super) body: &'a Body,
    pub(super) typed: &'a TypedBody,
}

impl Constants<'_> {
    pub(super) fn value(self, id: ExprId) -> Option<Constant> {
        self.value_at(id, 0)
    }

    fn value_at(self, id: ExprId, depth: u32) -> Option<Constant> {
        if depth > MAX_DEPTH {
            return None;
        }
        let next = |id: ExprId| self.value_at(id, depth + 1);
        match &self.body.expr(id).kind {
            ExprKind::Literal(Literal::Int(Some(value), _)) => {
                Some(Constant::Number(f64::from(u32::try_from(*value).ok()?)))
            }
            ExprKind::Literal(literal) => literal.float().map(Constant::Number),
            ExprKind::Cast { value, .. } => next(*value),
            ExprKind::Block(block) if block.stmts.is_empty() => next(block.tail?),
            ExprKind::Binary { op, lhs, rhs } => operate(op, next(*lhs)?, next(*rhs)?),
            ExprKind::Path(_) => self.named(id, depth),
            ExprKind::Call { args, .. } => match self.typed.callees.get(&id) {
                Some(Callee::External(path)) => {
                    let args: Option<Vec<Constant>> = args.iter().map(|arg| next(*arg)).collect();
                    duration(path, &args?)
                }
                _ => None,
            },
            ExprKind::MethodCall { receiver, method, .. } => match (next(*receiver)?, method.as_str()) {
                (Constant::Seconds(seconds), "as_secs_f32" | "as_secs_f64") => Some(Constant::Number(seconds)),
                (Constant::Seconds(seconds), "as_millis") => Some(Constant::Number(seconds * 1e3)),
                (Constant::Seconds(seconds), "as_micros") => Some(Constant::Number(seconds * 1e6)),
                (Constant::Number(number), "recip") => Some(Constant::Number(1.0 / number)),
                (value, "into" | "clone") => Some(value),
                _ => None,
            },
            _ => None,
        }
    }

    /// The number that an expression is written as: a literal, one with a minus, or a constant that is declared so.
    pub(super) fn written_number(self, id: ExprId) -> Option<f64> {
        self.written_number_at(id, 0)
    }

    fn written_number_at(self, id: ExprId, depth: u32) -> Option<f64> {
        if depth > MAX_DEPTH {
            return None;
        }
        match &self.body.expr(id).kind {
            ExprKind::Literal(Literal::Int(Some(value), _)) => Some(f64::from(u32::try_from(*value).ok()?)),
            ExprKind::Literal(literal) => literal.float(),
            ExprKind::Negate(inner) => Some(-self.written_number_at(*inner, depth + 1)?),
            ExprKind::Path(_) => match self.typed.expr_def.get(&id)? {
                Def::Value(value) if !self.program.index.value(*value).item.is_static => {
                    let written = |own: Constants<'_>| own.written_number_at(own.body.root, depth + 1);
                    in_constant(self.program, *value, written)?
                }
                _ => None,
            },
            _ => None,
        }
    }

    /// The head of a constant expression: a literal, a variant, a constant.
    pub(super) fn head(self, id: ExprId) -> Option<Head> {
        self.head_at(id, 0)
    }

    fn head_at(self, id: ExprId, depth: u32) -> Option<Head> {
        match &self.body.expr(id).kind {
            ExprKind::Literal(literal) => Some(literal.spelling()),
            ExprKind::Macro(call) => call.kind.built().map(|answer| answer.to_string()),
            ExprKind::Negate(inner) => match &self.body.expr(*inner).kind {
                ExprKind::Literal(literal) => Some(format!("-{}", literal.spelling())),
                _ => Some(self.whole_number(id)?.to_string()),
            },
            ExprKind::Binary { .. } => Some(self.whole_number(id)?.to_string()),
            ExprKind::Reference { value, .. } => self.head_at(*value, depth),
            ExprKind::Path(path) => match self.typed.expr_def.get(&id)? {
                Def::Value(value) if self.program.index.value(*value).item.is_static => None,
                def => head_of(self.program, def, &path.text(), depth),
            },
            ExprKind::Struct { .. } => self.head_made(self.typed.expr_def.get(&id)?, depth),
            ExprKind::Call { .. } => match self.typed.callees.get(&id)? {
                Callee::Constructor(Some(def)) => self.head_made(def, depth),
                _ => None,
            },
            _ => None,
        }
    }

    /// Whether all values that have the head of a constant expression are equal: what a variant carries is no part of its head.
    pub(super) fn is_exact(self, id: ExprId) -> bool {
        self.is_exact_at(id, 0)
    }

    fn is_exact_at(self, id: ExprId, depth: u32) -> bool {
        match &self.body.expr(id).kind {
            ExprKind::Reference { value, .. } => self.is_exact_at(*value, depth),
            ExprKind::Path(_) => self.typed.expr_def.get(&id).is_none_or(|def| is_exact(self.program, def, depth)),
            ExprKind::Struct { .. } | ExprKind::Call { .. } => false,
            _ => true,
        }
    }

    /// The head of what a constructor makes, which only that of a variant tells.
    fn head_made(self, def: &Def, depth: u32) -> Option<Head> {
        matches!(def, Def::Variant(..) | Def::External(_)).then(|| head_of(self.program, def, "", depth))?
    }

    /// The value of a constant, or of a variable that keeps what it is declared with.
    fn named(self, id: ExprId, depth: u32) -> Option<Constant> {
        if self.typed.expr_local.contains_key(&id) {
            return self.value_at(self.initial(id)?, depth + 1);
        }
        let Some(Def::Value(value)) = self.typed.expr_def.get(&id) else { return None };
        let is_static = self.program.index.value(*value).item.is_static;
        let value_of = |own: Constants<'_>| own.value_at(own.body.root, depth + 1);
        (!is_static).then(|| in_constant(self.program, *value, value_of))??
    }

    /// What the variable that an expression names was declared with, if nothing else is assigned to it.
    pub(super) fn initial(self, id: ExprId) -> Option<ExprId> {
        let local = self.typed.expr_local.get(&id)?;
        let is_own = |expr: &ExprId| self.typed.expr_local.get(expr) == Some(local);
        let is_assigned = self.body.exprs.iter().any(|expr| {
            matches!(&expr.kind, ExprKind::Assign { place, .. } | ExprKind::AssignOp { place, .. } if is_own(place))
        });
        if is_assigned {
            return None;
        }
        self.body.stmts().find_map(|stmt| match &stmt.kind {
            StmtKind::Let { pat, init, .. } if self.typed.pat_local.get(pat) == Some(local) => *init,
            _ => None,
        })
    }
}

impl Builder<'_> {
    /// The number that an associated constant is, if it is the same one whatever the type: `C::ROUNDS`, `<Fast as Config>::ROUNDS`.
    pub(super) fn agreed_number(&self, path: &Path) -> Option<u64> {
        let index = self.program.index;
        let scope = index.scope_of(self.frames[self.frame].function);
        let (name, owner) = path.segments.split_last()?;
        let (of_trait, owner) = match &path.self_ty {
            Some(ty) => (owner.last(), index.lower(ty, &scope)),
            None if owner.is_empty() => return None,
            None => {
                let owner = Path { segments: owner.to_vec(), ..Path::default() };
                (None, index.lower(&TypeRef::Path(owner), &scope))
            }
        };
        let is_asked = |id: TraitId| of_trait.is_none_or(|segment| index.trait_def(id).name == segment.name);
        let numbers: Option<Vec<u64>> = match &owner {
            Ty::Param(param) => index.constants_behind(&param.bounds, &name.name, is_asked),
            Ty::Opaque(bounds) => index.constants_behind(bounds, &name.name, is_asked),
            _ => {
                let impls = index.impls_of(&owner).into_iter().map(|id| index.impl_def(id));
                let of_it = impls.filter(|def| match &def.implements {
                    Some(TraitName::Local(id)) => is_asked(*id),
                    _ => of_trait.is_none(),
                });
                of_it.filter_map(|def| def.consts.get(&name.name)).map(|id| index.const_number(*id)).collect()
            }
        };
        let numbers = numbers?;
        let first = *numbers.first()?;
        numbers.iter().all(|number| *number == first).then_some(first)
    }
}

impl Constants<'_> {
    /// Whether an expression is `cfg!(debug_assertions)`, or a name for it.
    pub(super) fn asks_for_debug_build(self, id: ExprId, depth: u32) -> bool {
        match &self.body.expr(id).kind {
            ExprKind::Macro(call) => matches!(call.kind, MacroKind::DebugBuild),
            ExprKind::Path(_) if depth < MAX_DEPTH => match (self.initial(id), self.typed.expr_def.get(&id)) {
                (Some(initial), _) => self.asks_for_debug_build(initial, depth + 1),
                (None, Some(Def::Value(value))) if !self.program.index.value(*value).item.is_static => {
                    in_constant(self.program, *value, |own| own.asks_for_debug_build(own.body.root, depth + 1))
                        .unwrap_or(false)
                }
                _ => false,
            },
            _ => false,
        }
    }
}

/// How many expressions a body may have to be looked through for the declaration of each truth value that it asks for.
const MAX_SEARCHED: usize = 10_000;

impl Constants<'_> {
    /// Whether an expression asks nothing but the build and its constants, by whatever name: `cfg!(feature = "notch")`,
    /// `!IS_BARE && has_notch()`. What it gives cannot change while the program runs.
    pub(super) fn asks_build(self, id: ExprId) -> bool {
        self.asks_build_at(id, 0)
    }

    fn asks_build_at(self, id: ExprId, depth: u32) -> bool {
        if depth > MAX_DEPTH {
            return false;
        }
        let next = |id: ExprId| self.asks_build_at(id, depth + 1);
        match &self.body.expr(id).kind {
            ExprKind::Macro(call) => matches!(call.kind, MacroKind::Build(_)),
            ExprKind::Not(inner) => next(*inner),
            ExprKind::Binary { lhs, rhs, .. } => {
                let is_literal = |side: ExprId| matches!(self.body.expr(side).kind, ExprKind::Literal(_));
                match (is_literal(*lhs), is_literal(*rhs)) {
                    (true, true) => false,
                    (true, false) => next(*rhs),
                    (false, true) => next(*lhs),
                    (false, false) => next(*lhs) && next(*rhs),
                }
            }
            ExprKind::Block(block) if block.stmts.is_empty() => block.tail.is_some_and(next),
            // What a variable is declared with is looked for in all of the body.
            ExprKind::Path(_) if self.typed.expr_local.contains_key(&id) => {
                let is_short = self.body.exprs.len() <= MAX_SEARCHED;
                is_short && *self.typed.ty(id) == Ty::Bool && self.initial(id).is_some_and(next)
            }
            ExprKind::Path(_) => match self.typed.expr_def.get(&id) {
                Some(Def::Value(value)) => !self.program.index.value(*value).item.is_static,
                _ => false,
            },
            // What gives a number or a text may stand in for a device.
            ExprKind::Call { args, .. } | ExprKind::MethodCall { args, .. } => {
                let is_question = args.is_empty() && *self.typed.ty(id) == Ty::Bool;
                match self.typed.callees.get(&id).filter(|_| is_question) {
                    Some(Callee::Resolved(resolved)) => match resolved.targets.as_slice() {
                        [target] => self.gives_build(*target, depth),
                        _ => false,
                    },
                    _ => false,
                }
            }
            _ => false,
        }
    }

    /// Whether a function that is given nothing gives back what the build tells, and nothing else.
    fn gives_build(self, function: FunctionId, depth: u32) -> bool {
        let body = self.program.index.function(function).function.body.as_ref();
        match (body.filter(|body| body.exprs.len() <= MAX_LENGTH), self.program.typed(function)) {
            (Some(body), Some(typed)) => {
                Constants { program: self.program, body, typed }.asks_build_at(body.root, depth + 1)
            }
            _ => false,
        }
    }
}

/// Looks into what a constant is declared with, if it is known and no table.
pub(super) fn in_constant<T>(program: &Program<'_>, id: ValueId, look: impl FnOnce(Constants<'_>) -> T) -> Option<T> {
    let body = program.index.value(id).item.value.as_ref().filter(|body| body.exprs.len() <= MAX_LENGTH)?;
    let typed = crate::types::infer(program.index, BodyOwner::Value(id))?;
    Some(look(Constants { program, body, typed: &typed }))
}

/// The variant of an enum that a constant is another name of.
pub(super) fn variant_of(program: &Program<'_>, id: ValueId, depth: u32) -> Option<(TypeId, usize)> {
    let named = |own: Constants<'_>| match own.typed.expr_def.get(&own.body.root)? {
        Def::Variant(ty, at) => Some((*ty, *at)),
        Def::Value(value) if depth < MAX_DEPTH => variant_of(program, *value, depth + 1),
        _ => None,
    };
    in_constant(program, id, named)?
}

/// What a static or constant is another name of, itself if of nothing: `static SAME: &Mutex<Pt1> = &LPF;`
pub(super) fn referred(program: &Program<'_>, id: ValueId) -> ValueId {
    let item = &program.index.value(id).item;
    let is_reference = |body: &Body| matches!(body.expr(body.root).kind, ExprKind::Reference { .. });
    if !item.value.as_ref().is_some_and(is_reference) {
        return id;
    }
    let named = |own: Constants<'_>| match &own.body.expr(own.body.root).kind {
        ExprKind::Reference { value, .. } => own.typed.expr_def.get(value).cloned(),
        _ => None,
    };
    match in_constant(program, id, named).flatten() {
        Some(Def::Value(named)) if program.index.value(named).item.is_static => named,
        _ => id,
    }
}

impl Builder<'_> {
    /// The static that a call lends, or locks and lends, if the function does nothing else: `fn depth() -> &'static Mutex<Pt1> { &DEPTH }`.
    pub(super) fn static_lent(&self, call: ExprId) -> Option<Place> {
        let target = self.only_target(call)?;
        let body = self.program.index.function(target).function.body.as_ref().filter(|body| body.params.is_empty())?;
        let typed = self.program.typed(target)?;
        let mut at = body.root;
        loop {
            at = match &body.expr(at).kind {
                ExprKind::Block(block) if block.stmts.is_empty() => block.tail?,
                ExprKind::Reference { value: inner, .. } | ExprKind::Deref(inner) => *inner,
                ExprKind::MethodCall { receiver, method, args, .. }
                    if matches!(
                        (method.as_str(), args.len()),
                        ("get" | "get_mut" | "unwrap" | "lock" | "write" | "borrow_mut", 0)
                            | ("get_or_init" | "expect" | "unwrap_or_else", 1)
                    ) =>
                {
                    *receiver
                }
                _ => break,
            };
        }
        let Some(Def::Value(value)) = typed.expr_def.get(&at) else { return None };
        let named = referred(self.program, *value);
        let ty = self.ty(call);
        let is_guard = || ty.external_name().is_some_and(|name| name.ends_with("Guard") || name == "RefMut");
        let is_lent = (matches!(ty, Ty::Ref(..)) || is_guard()) && self.may_hold_filter(ty);
        (is_lent && self.program.index.value(named).item.is_static).then(|| Place::of_static(named))
    }
}

/// Whether all values that have the head of what a path names are equal.
pub(super) fn is_exact(program: &Program<'_>, def: &Def, depth: u32) -> bool {
    let Def::Value(value) = def else { return true };
    let is_exact = |own: Constants<'_>| {
        let root = own.body.root;
        // A struct has no head but the name of its constant.
        let is_named = || matches!(own.body.expr(root).kind, ExprKind::Struct { .. }) && own.head(root).is_none();
        depth < MAX_DEPTH && (is_named() || own.is_exact_at(root, depth + 1))
    };
    in_constant(program, *value, is_exact).unwrap_or(true)
}

/// The head of what a path names, which is spelled so.
pub(super) fn head_of(program: &Program<'_>, def: &Def, path: &str, depth: u32) -> Option<Head> {
    if let (Def::External(_), Some(number)) = (def, limit_of_type(path)) {
        return Some(number.to_string());
    }
    match def {
        Def::Variant(ty, at) => Some(variant_head(program, *ty, *at)),
        Def::External(path) => Some(external_head(path)),
        Def::Value(value) => {
            // What a constant is decides whether it is the same as another one, under whatever name.
            let written = |own: Constants<'_>| {
                let root = own.body.root;
                if depth >= MAX_DEPTH {
                    return None;
                }
                own.head_at(root, depth + 1).or_else(|| match own.value_at(root, depth + 1)? {
                    Constant::Number(number) if *own.typed.ty(root) == Ty::Int && number.fract() == 0.0 => {
                        Some(format!("{number:.0}"))
                    }
                    _ => None,
                })
            };
            let written = in_constant(program, *value, written).flatten();
            Some(written.unwrap_or_else(|| format!("{} {value:?}", program.index.value(*value).name)))
        }
        Def::Type(_) => Some(path.to_owned()),
        _ => None,
    }
}

/// The head of a variant of a type of the analysed code.
pub(super) fn variant_head(program: &Program<'_>, ty: TypeId, at: usize) -> Head {
    match &program.index.type_def(ty).shape {
        Shape::Enum(variants) => variants[at].name.clone(),
        Shape::Struct(_) => String::new(),
    }
}

fn operate(op: &str, left: Constant, right: Constant) -> Option<Constant> {
    use Constant::{Number, Seconds};
    Some(match (op, left, right) {
        ("+", Number(a), Number(b)) => Number(a + b),
        ("-", Number(a), Number(b)) => Number(a - b),
        ("*", Number(a), Number(b)) => Number(a * b),
        ("/", Number(a), Number(b)) if b != 0.0 => Number(a / b),
        ("<<", Number(a), Number(b)) => Number(f64::from(whole(a)?.checked_shl(whole(b)?)?)),
        ("|", Number(a), Number(b)) => Number(f64::from(whole(a)? | whole(b)?)),
        ("+", Seconds(a), Seconds(b)) => Seconds(a + b),
        ("-", Seconds(a), Seconds(b)) => Seconds(a - b),
        ("*", Seconds(a), Number(b)) | ("*", Number(b), Seconds(a)) => Seconds(a * b),
        ("/", Seconds(a), Number(b)) if b != 0.0 => Seconds(a / b),
        _ => return None,
    })
}

/// A number that is a whole one and not large.
pub(super) fn whole(number: f64) -> Option<u32> {
    number.to_string().parse().ok()
}

/// What a function of a `Duration` gives.
fn duration(path: &str, args: &[Constant]) -> Option<Constant> {
    let (owner, name) = path.rsplit_once("::")?;
    if owner.rsplit("::").next() != Some("Duration") {
        return None;
    }
    let seconds = match (name, args) {
        ("from_secs" | "from_secs_f32" | "from_secs_f64", [Constant::Number(value)]) => *value,
        ("from_millis", [Constant::Number(value)]) => value * 1e-3,
        ("from_micros", [Constant::Number(value)]) => value * 1e-6,
        ("from_nanos", [Constant::Number(value)]) => value * 1e-9,
        ("from_hz", [Constant::Number(value)]) if *value > 0.0 => 1.0 / value,
        ("new", [Constant::Number(seconds), Constant::Number(nanos)]) => seconds + nanos * 1e-9,
        _ => return None,
    };
    Some(Constant::Seconds(seconds))
}
