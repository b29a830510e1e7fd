//! What may stand behind a value that is only called, as a callback in a queue: the closures of the analysed code, and the functions
//! that it names without calling them.

use rustc_hash::{FxHashMap, FxHashSet};

use crate::index::{BodyOwner, FunctionId, Index, Ty, ValueId};
use crate::source::SourceMap;
use crate::syntax::tree::{Body, ExprId, ExprKind, OpaqueMacro, PatKind};
use crate::types::{Callee, TypedBody, param_types};

/// Of how many closures a call may run one.
const MAX_CALLABLES: usize = 8;

/// The closures and named functions of the analysed code.
#[derive(Debug, Default)]
pub struct Callables {
    known: Vec<Callable>,
    /// Those that functions are called with, by the function and the number of the parameter; `None` where something else is given.
    given: FxHashMap<(FunctionId, usize), Option<Vec<Place>>>,
    /// The functions that stand in a table or a struct of what is no test, from which the code calls them: `const OPS: [fn(&mut Cpu); 256]`.
    listed: FxHashSet<FunctionId>,
    /// Whether something that was not read may have made another one.
    has_unread: bool,
}

/// Where a closure or a named function stands.
type Place = (FunctionId, ExprId);

/// A closure or a named function, where it stands.
#[derive(Debug)]
struct Callable {
    owner: BodyOwner,
    expr: ExprId,
    params: Vec<Ty>,
    /// Whether what it does with what it is lent is known: the types are, or no name is given to it.
    is_told: bool,
}

impl Callables {
    /// Collects them from all bodies.
    #[must_use]
    pub fn of(index: &Index, bodies: &[Option<TypedBody>], sources: &SourceMap) -> Self {
        let hides = |call: &OpaqueMacro| sources.snippet(call.tokens).contains('|');
        let names: FxHashSet<&str> = index.function_ids().map(|id| index.function(id).name.as_str()).collect();
        let mut found = Self {
            has_unread: index.opaque_items.iter().any(|(_, call)| hides(call)),
            given: parameters(index).map(|parameter| (parameter, Some(Vec::new()))).collect(),
            ..Self::default()
        };
        for function in index.function_ids() {
            let typed = bodies.get(function.0 as usize).and_then(Option::as_ref);
            if let (Some(body), Some(typed)) = (&index.function(function).function.body, typed) {
                found.collect(index, &names, BodyOwner::Function(function), body, typed);
                found.has_unread |= opaque(body).any(hides);
            }
        }
        for (number, value) in (0u32..).zip(&index.values) {
            let Some(body) = &value.item.value else { continue };
            found.has_unread |= opaque(body).any(hides);
            let owner = BodyOwner::Value(ValueId(number));
            if body.exprs.iter().any(|expr| matches!(expr.kind, ExprKind::Closure(_) | ExprKind::Path(_)))
                && let Some(typed) = crate::types::infer(index, owner)
            {
                found.collect(index, &names, owner, body, &typed);
            }
        }
        found
    }

    fn collect(&mut self, index: &Index, names: &FxHashSet<&str>, owner: BodyOwner, body: &Body, typed: &TypedBody) {
        let called: FxHashSet<ExprId> = body.exprs.iter().filter_map(|expr| callee(&expr.kind)).collect();
        self.collect_given(owner, body, typed, &called);
        let consumed = consumed(body, typed, names);
        if !matches!(owner, BodyOwner::Function(function) if index.function(function).is_test) {
            let listed = listed(body).filter_map(|path| typed.items.get(&path));
            self.listed.extend(listed.flat_map(|item| &item.targets));
        }
        for (number, expr) in (0u32..).zip(&body.exprs) {
            let id = ExprId(number);
            let (params, is_told) = match &expr.kind {
                _ if consumed.contains(&id) => continue,
                ExprKind::Closure(code) => {
                    let found = typed.closure_params.get(&id).map_or(&[][..], Vec::as_slice);
                    let ty_of = |number: usize| found.get(number).cloned().unwrap_or(Ty::Unknown);
                    let params: Vec<Ty> = (0..code.params.len()).map(ty_of).collect();
                    let names_it = |pat| !matches!(body.pat(pat).kind, PatKind::Wild);
                    let mut given = code.params.iter().zip(&params);
                    let is_told = given.all(|((pat, _), ty)| !is_open(ty) || !names_it(*pat));
                    (params, is_told)
                }
                ExprKind::Path(_) if !called.contains(&id) => {
                    let target = typed.items.get(&id).and_then(|item| item.targets.first());
                    let Some(target) = target else { continue };
                    let params = param_types(index, index.function(*target), &index.scope_of(*target));
                    let is_told = !params.iter().any(is_open);
                    (params, is_told)
                }
                _ => continue,
            };
            self.known.push(Callable { owner, expr: id, params, is_told });
        }
    }

    /// Whether a function stands in a table or a struct, from which it is called.
    #[must_use]
    pub fn is_listed(&self, function: FunctionId) -> bool {
        self.listed.contains(&function)
    }

    /// Notes what functions are called with; one that is named without being called may get anything.
    fn collect_given(&mut self, owner: BodyOwner, body: &Body, typed: &TypedBody, called: &FxHashSet<ExprId>) {
        for (id, callee) in &typed.callees {
            let Callee::Resolved(resolved) = callee else { continue };
            let (receiver, args) = match &body.expr(*id).kind {
                ExprKind::Call { args, .. } => (None, args),
                ExprKind::MethodCall { receiver, args, .. } => (Some(receiver), args),
                _ => continue,
            };
            for (number, arg) in receiver.into_iter().chain(args).enumerate() {
                // `&mut |rig| rig.step()`
                let arg = match &body.expr(*arg).kind {
                    ExprKind::Reference { value, .. } => value,
                    _ => arg,
                };
                let is_told = matches!(body.expr(*arg).kind, ExprKind::Closure(_)) || typed.items.contains_key(arg);
                for target in &resolved.targets {
                    let Some(given) = self.given.get_mut(&(*target, number)) else { continue };
                    match (owner, given.as_mut().filter(|_| is_told)) {
                        (BodyOwner::Function(function), Some(places)) => places.push((function, *arg)),
                        _ => *given = None,
                    }
                }
            }
        }
        let named = typed.items.iter().filter(|(id, _)| !called.contains(*id)).flat_map(|(_, item)| &item.targets);
        let named: Vec<FunctionId> = named.copied().collect();
        self.given
            .iter_mut()
            .filter(|((function, _), _)| named.contains(function))
            .for_each(|(_, given)| *given = None);
    }

    /// Where all stand that a function is called with for one of its parameters; `None` if there are none, or too many, or others.
    #[must_use]
    pub fn given_to(&self, function: FunctionId, parameter: usize) -> Option<Vec<Place>> {
        let given = self.given.get(&(function, parameter))?.as_ref()?;
        let is_told = |place: &Place| {
            let mut known = self.known.iter();
            known.any(|own| own.owner == BodyOwner::Function(place.0) && own.expr == place.1 && own.is_told)
        };
        let is_known = !self.has_unread && given.iter().all(is_told);
        (is_known && (1..=MAX_CALLABLES).contains(&given.len())).then(|| given.clone())
    }

    /// Where all stand that may be behind a value which is called with these types; `None` if there are none, or too many, or if there
    /// may be others.
    #[must_use]
    pub fn behind(&self, params: &[Ty]) -> Option<Vec<Place>> {
        if self.has_unread {
            return None;
        }
        let may_be = |own: &&Callable| {
            own.params.len() == params.len() && own.params.iter().zip(params).all(|(own, asked)| may_agree(own, asked))
        };
        let found = self.known.iter().filter(may_be).map(|own| match own.owner {
            BodyOwner::Function(function) if own.is_told => Some((function, own.expr)),
            _ => None,
        });
        let found: Vec<_> = found.collect::<Option<_>>()?;
        (1..=MAX_CALLABLES).contains(&found.len()).then_some(found)
    }
}

/// The elements of arrays and tuples and the fields of structs, without what only changes their type.
fn listed(body: &Body) -> impl Iterator<Item = ExprId> {
    let parts = body.exprs.iter().flat_map(|expr| match &expr.kind {
        ExprKind::Array { elements, .. } => elements.clone(),
        ExprKind::Struct { fields, .. } => fields.iter().map(|(_, value)| *value).collect(),
        ExprKind::Tuple(parts) => parts.clone(),
        _ => Vec::new(),
    });
    parts.map(|part| match &body.expr(part).kind {
        ExprKind::Cast { value, .. } | ExprKind::Reference { value, .. } => *value,
        _ => part,
    })
}

/// The macros of a body that were not read.
fn opaque(body: &Body) -> impl Iterator<Item = &OpaqueMacro> {
    body.exprs.iter().filter_map(|expr| match &expr.kind {
        ExprKind::Opaque(call) => Some(&**call),
        _ => None,
    })
}

/// The parameters of functions that can only be called.
fn parameters(index: &Index) -> impl Iterator<Item = (FunctionId, usize)> {
    index.function_ids().flat_map(|id| {
        let params = param_types(index, index.function(id), &index.scope_of(id));
        let is_called = |ty: &Ty| ty.called_as().is_some() || matches!(ty, Ty::Function(..));
        let callable = params.into_iter().enumerate().filter(|(_, ty)| is_called(ty));
        callable.map(move |(number, _)| (id, number)).collect::<Vec<_>>()
    })
}

/// What a call names as its function.
fn callee(kind: &ExprKind) -> Option<ExprId> {
    match kind {
        ExprKind::Call { callee, .. } => Some(*callee),
        _ => None,
    }
}

/// The closures and functions that the standard library gets for as long as a call of its own lasts: `items.iter().map(|item| …)`.
/// What the receiver is need not be known where no function of the analysed code has the name.
fn consumed(body: &Body, typed: &TypedBody, names: &FxHashSet<&str>) -> FxHashSet<ExprId> {
    let calls = (0u32..).zip(&body.exprs).filter_map(|(number, expr)| match &expr.kind {
        ExprKind::MethodCall { method, args, .. } if runs_at_once(method) => Some((ExprId(number), method, args)),
        _ => None,
    });
    let of_library = calls.filter(|(id, method, _)| match typed.callees.get(id) {
        Some(Callee::Builtin) => true,
        Some(Callee::Resolved(_)) => false,
        _ => !names.contains(method.as_str()),
    });
    of_library.flat_map(|(_, _, args)| args.iter().copied()).collect()
}

/// Methods of options, results and iterators that call what they get and keep it no longer than what they give back lives.
fn runs_at_once(method: &str) -> bool {
    matches!(
        method,
        "map"
            | "map_err"
            | "map_or"
            | "map_or_else"
            | "and_then"
            | "or_else"
            | "unwrap_or_else"
            | "ok_or_else"
            | "filter"
            | "filter_map"
            | "flat_map"
            | "for_each"
            | "fold"
            | "any"
            | "all"
            | "find"
            | "find_map"
            | "position"
            | "rposition"
            | "max_by"
            | "min_by"
            | "max_by_key"
            | "min_by_key"
            | "sort_by"
            | "sort_by_key"
            | "sort_unstable_by"
            | "sort_unstable_by_key"
            | "retain"
            | "retain_mut"
            | "take_while"
            | "map_while"
            | "inspect"
            | "inspect_err"
            | "scan"
            | "reduce"
            | "rfold"
            | "rfind"
            | "try_fold"
            | "try_for_each"
            | "skip_while"
            | "chunk_by"
            | "binary_search_by"
            | "binary_search_by_key"
            | "partition_point"
            | "sort_by_cached_key"
            | "select_nth_unstable_by"
            | "select_nth_unstable_by_key"
            | "dedup_by"
            | "dedup_by_key"
            | "extract_if"
            | "take_if"
            | "and_modify"
            | "then"
            | "trim_matches"
            | "trim_start_matches"
            | "trim_end_matches"
            | "partition"
            | "is_some_and"
            | "is_ok_and"
            | "is_err_and"
            | "is_none_or"
            | "or_insert_with"
            | "get_or_insert_with"
            | "fill_with"
            | "resize_with"
    )
}

/// Whether a type may be several.
fn is_open(ty: &Ty) -> bool {
    matches!(ty.peel(), Ty::Unknown | Ty::Var(_) | Ty::Param(_) | Ty::Opaque(_))
}

/// Whether two types may be the same one, as far as they are known.
fn may_agree(own: &Ty, asked: &Ty) -> bool {
    match (own, asked) {
        _ if is_open(own) || is_open(asked) => true,
        (Ty::Ref(left, own), Ty::Ref(right, asked)) => left == right && may_agree(own, asked),
        (Ty::Adt(left, _), Ty::Adt(right, _)) => left == right,
        (Ty::External(left, _), Ty::External(right, _)) => left == right,
        (Ty::Tuple(left), Ty::Tuple(right)) => {
            left.len() == right.len() && left.iter().zip(right).all(|(own, asked)| may_agree(own, asked))
        }
        // A pattern takes the reference away that the type has: `|&index|`.
        (own, Ty::Ref(_, asked)) if !matches!(own, Ty::Ref(..)) => may_agree(own, asked),
        _ => std::mem::discriminant(own) == std::mem::discriminant(asked),
    }
}
