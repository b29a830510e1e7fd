//! Calls that read what they are given and do nothing else: they give the same as long as that is the same.

mod fields;

use super::constants::Constants;
use crate::flow::Program;
use crate::index::{Def, FunctionId, Owner, Ty};
use crate::syntax::tree::{Body, ExprId, ExprKind, Path, Receiver, StmtKind, TypeRef};
use crate::types::Callee;

/// How deep functions are followed.
const MAX_DEPTH: u32 = 3;

/// Methods that only read, whatever they are called on.
const READING: &[&str] = &[
    "is_some",
    "is_none",
    "is_ok",
    "is_err",
    "is_empty",
    "len",
    "abs",
    "is_nan",
    "is_finite",
    "as_ref",
    "is_positive",
    "is_negative",
    "min",
    "max",
    "is_multiple_of",
    "as_deref",
    "signum",
    "get",
    "clone",
    "to_owned",
    "is_sign_negative",
    "is_sign_positive",
    "rem_euclid",
    "contains",
    "contains_key",
    "is_infinite",
    "cmp",
    "partial_cmp",
    "total_cmp",
    "starts_with",
    "ends_with",
    "first_mut",
    "last_mut",
    "split_first_mut",
    "split_last_mut",
];

/// Methods of options and results that give another one, which is there where they are.
const CHOOSING: &[&str] = &[
    "map", "and", "and_then", "or", "or_else", "xor", "filter", "flatten", "copied", "cloned", "ok", "err", "ok_or",
    "zip",
];

/// Methods that only read where they are called on a value of the standard library.
const READING_VALUES: &[&str] = &[
    // Options and results.
    "unwrap",
    "expect",
    "unwrap_or",
    "unwrap_or_default",
    "unwrap_or_else",
    "map_or",
    "map_or_else",
    "is_some_and",
    "is_none_or",
    "is_ok_and",
    "is_err_and",
    // Collections.
    "first",
    "last",
    "front",
    "back",
    "as_slice",
    "to_vec",
    "split_at",
    "split_first",
    "split_last",
    "binary_search",
    "is_sorted",
    "keys",
    "values",
    "iter",
    "into_iter",
    "first_key_value",
    "last_key_value",
    "windows",
    "chunks",
    "chunks_exact",
    // Texts.
    "as_str",
    "as_bytes",
    "bytes",
    "chars",
    "char_indices",
    "lines",
    "trim",
    "trim_start",
    "trim_end",
    "split",
    "split_whitespace",
    "split_once",
    "strip_prefix",
    "strip_suffix",
    "rfind",
    "eq_ignore_ascii_case",
    "is_ascii",
    "to_lowercase",
    "to_uppercase",
    "to_string",
    "parse",
    "splitn",
    "rsplit",
    "matches",
    "is_char_boundary",
    // How two values stand to each other.
    "is_lt",
    "is_le",
    "is_gt",
    "is_ge",
    "is_eq",
    "is_ne",
    "reverse",
    "then_with",
];

/// Methods of iterators, which change one that has a name.
const ITERATING: &[&str] = &[
    "all",
    "any",
    "count",
    "sum",
    "product",
    "min_by",
    "max_by",
    "min_by_key",
    "max_by_key",
    "fold",
    "reduce",
    "position",
    "find",
    "find_map",
    "filter_map",
    "flat_map",
    "map_while",
    "take",
    "skip",
    "step_by",
    "take_while",
    "skip_while",
    "enumerate",
    "rev",
    "chain",
    "nth",
    "collect",
    "eq",
    "ne",
];

/// The functions of the standard library that compute a number from numbers, by what stands before their names.
const COMPUTING: &[&str] = &[
    "f32", "f64", "u8", "u16", "u32", "u64", "u128", "usize", "i8", "i16", "i32", "i64", "i128", "isize", "bool",
    "char", "cmp",
];

/// Types that are nothing but a number, or a few: whatever they are asked, they stay the same.
const NUMBERS: &[&str] = &[
    "Duration",
    "Instant",
    "SystemTime",
    "Wrapping",
    "Saturating",
    "IpAddr",
    "Ipv4Addr",
    "Ipv6Addr",
    "SocketAddr",
    "ErrorKind",
];

/// Whether a call does nothing but read what it is given.
pub(super) fn only_reads(own: Constants<'_>, id: ExprId, depth: u32) -> bool {
    let callee = own.typed.callees.get(&id);
    match &own.body.expr(id).kind {
        ExprKind::MethodCall { args, .. } | ExprKind::Call { args, .. } if args.iter().any(|arg| lends(own, *arg)) => {
            false
        }
        ExprKind::MethodCall { receiver, method, args, .. } => match callee {
            Some(Callee::Resolved(resolved)) => match resolved.targets.as_slice() {
                [target] => is_pure_function(own.program, *target, depth),
                _ => false,
            },
            // What a cell holds is changed only where it is borrowed to be written.
            _ if method == "borrow" => args.is_empty() && super::flags::is_borrowed_from(own.typed.ty(*receiver)),
            _ if READING.contains(&method.as_str()) => {
                matches!(callee, Some(Callee::Builtin))
                    || method != "get"
                    || own.typed.ty(*receiver).peel().external_name().is_some_and(is_number_type)
                    || !args.is_empty() && is_value(own, *receiver)
            }
            _ => reads_value(own, *receiver, method),
        },
        ExprKind::Call { callee: named, .. } => match callee {
            Some(Callee::Resolved(resolved)) if resolved.law.is_none() => match resolved.targets.as_slice() {
                // What reads nothing stands in for something that is not written yet.
                [target] => {
                    let reads = own.program.typed(*target).is_some_and(|typed| !typed.expr_local.is_empty());
                    reads && is_pure_function(own.program, *target, depth)
                }
                _ => false,
            },
            Some(Callee::External(path)) => {
                let mut parts = path.rsplit("::");
                let (name, owner) = (parts.next().unwrap_or_default(), parts.next().unwrap_or_default());
                COMPUTING.contains(&owner) || is_number_type(owner) && makes_number(name)
            }
            Some(Callee::Unknown) => matches!(&own.body.expr(*named).kind, ExprKind::Path(path) if computes(path)),
            _ => false,
        },
        _ => false,
    }
}

/// Whether a path is a function that computes a number from numbers: `f32::max`.
pub(super) fn computes(path: &Path) -> bool {
    matches!(path.segments.as_slice(), [owner, _] if COMPUTING.contains(&owner.name.as_str()))
}

/// Whether a call gives an option that is there where the one is that it is called on, or where a number has not come to its end:
/// what follows it asks for that one.
pub(super) fn chooses(own: Constants<'_>, id: ExprId) -> bool {
    match &own.body.expr(id).kind {
        ExprKind::MethodCall { receiver, method, .. } => {
            CHOOSING.contains(&method.as_str()) && is_optional(own.typed.ty(*receiver))
                || method.starts_with("checked_")
        }
        _ => false,
    }
}

/// Whether an argument may be written through.
fn lends(own: Constants<'_>, arg: ExprId) -> bool {
    matches!(own.body.expr(arg).kind, ExprKind::Reference { mutable: true, .. })
        || matches!(own.typed.ty(arg), Ty::Ref(true, _))
}

/// Whether a type of that name is nothing but numbers.
fn is_number_type(name: &str) -> bool {
    // `fugit::MicrosDurationU32`
    let plain = name.trim_end_matches(|letter: char| letter.is_ascii_digit()).trim_end_matches('U');
    NUMBERS.contains(&name)
        || name.starts_with("NonZero")
        || plain.len() < name.len() && ["Duration", "Instant"].iter().any(|own| plain.ends_with(own))
}

/// Whether a function of a type of numbers makes a value of what it is given: `Duration::from_millis(5)`.
fn makes_number(name: &str) -> bool {
    name == "new" || name.starts_with("from_") || matches!(name, "from" | "default" | "try_from")
}

fn reads_value(own: Constants<'_>, receiver: ExprId, method: &str) -> bool {
    let reads = READING_VALUES.contains(&method) || CHOOSING.contains(&method);
    let is_known = reads || ITERATING.contains(&method);
    match own.typed.ty(receiver).peel() {
        // Whatever a number is asked, it stays the same.
        Ty::Int | Ty::Float | Ty::Bool | Ty::Char => !matches!(method, "then" | "then_some"),
        _ if is_value(own, receiver) => reads,
        // The clock is asked as well how much time has passed since.
        ty if ty.external_name().is_some_and(is_number_type) => {
            let asks_clock = ["elapsed", "now", "past", "recent", "expired"].iter().any(|word| method.contains(word));
            !asks_clock && !method.ends_with("_mut")
        }
        // An iterator that was just made is used up by nothing else.
        _ => match &own.body.expr(receiver).kind {
            ExprKind::Range { .. } => is_known,
            ExprKind::MethodCall { .. } => {
                let is_plain = matches!(own.typed.ty(receiver), Ty::Unknown | Ty::External(..));
                is_known && is_plain && !matches!(own.typed.callees.get(&receiver), Some(Callee::Resolved(_)))
            }
            _ => false,
        },
    }
}

/// Whether a method asks a text, a number or a collection what is in it, and leaves it alone.
pub(super) fn asks(own: Constants<'_>, receiver: ExprId, method: &str) -> bool {
    let is_text = || {
        let ty = own.typed.ty(receiver).peel();
        *ty == Ty::Str || ty.external_name() == Some("String")
    };
    match method {
        "contains" | "contains_key" | "starts_with" | "ends_with" => is_value(own, receiver),
        _ if own.typed.ty(receiver).peel().external_name().is_some_and(is_number_type) => !method.ends_with("_mut"),
        _ => READING_VALUES.contains(&method) && is_text(),
    }
}

/// Whether an expression is a text, an option or a collection, which changes only where it is written.
fn is_value(own: Constants<'_>, id: ExprId) -> bool {
    let ty = own.typed.ty(id).peel();
    matches!(ty, Ty::Str | Ty::Slice(_) | Ty::Array(..))
        || is_optional(ty)
        || matches!(
            ty.external_name(),
            Some(
                "String"
                    | "Vec"
                    | "VecDeque"
                    | "HashMap"
                    | "HashSet"
                    | "BTreeMap"
                    | "BTreeSet"
                    | "ArrayVec"
                    | "SmallVec"
                    | "Ordering"
            )
        )
}

fn is_optional(ty: &Ty) -> bool {
    matches!(ty.peel().external_name(), Some("Option" | "Result"))
}

/// Whether a function only reads what it is given: all that its body is made of does.
pub(super) fn is_pure_function(program: &Program<'_>, id: FunctionId, depth: u32) -> bool {
    let def = program.index.function(id);
    // What is lent by `&mut` and left alone is asked: `fn is_due(&mut self) -> bool`. A method of a filter or of a trait may stand for
    // more, and so may one that has nothing to tell.
    let is_asked = || {
        let own = match def.owner {
            Owner::Impl(of) => Some(program.index.impl_def(of)).filter(|of| of.trait_path.is_none()),
            _ => None,
        };
        let reads = |body: &Body| body.exprs.iter().any(|expr| matches!(expr.kind, ExprKind::Field { .. }));
        matches!(&def.function.output, TypeRef::Path(path) if path.last() == "bool")
            && own.is_some_and(|own| program.index.filter_spec(&own.self_ty).is_none())
            && def.function.body.as_ref().is_some_and(reads)
    };
    if depth > MAX_DEPTH || def.function.receiver == Some(Receiver::Exclusive) && !is_asked() {
        return false;
    }
    let (Some(body), Some(typed)) = (&def.function.body, program.typed(id)) else { return false };
    let is_static = |id: ExprId| match typed.expr_def.get(&id) {
        Some(Def::Value(value)) => program.index.value(*value).item.is_static,
        _ => false,
    };
    let own = Constants { program, body, typed };
    let at = |number: usize| ExprId(u32::try_from(number).unwrap_or(u32::MAX));
    body.exprs.iter().enumerate().all(|(number, expr)| match &expr.kind {
        ExprKind::Path(_) => !is_static(at(number)),
        ExprKind::Literal(_)
        | ExprKind::Field { .. }
        | ExprKind::Binary { .. }
        | ExprKind::Not(_)
        | ExprKind::Negate(_)
        | ExprKind::Deref(_)
        | ExprKind::Cast { .. }
        | ExprKind::Let { .. }
        | ExprKind::Match { .. }
        | ExprKind::If { .. }
        | ExprKind::Return(_)
        | ExprKind::Range { .. }
        | ExprKind::Tuple(_)
        | ExprKind::Struct { .. }
        | ExprKind::Closure(_)
        | ExprKind::Reference { mutable: false, .. } => true,
        ExprKind::Index { .. } => {
            let own = typed.indexed.get(&at(number)).map_or(&[][..], |own| &own.targets);
            own.iter().all(|target| is_pure_function(program, *target, depth + 1))
        }
        ExprKind::Block(block) => {
            block.stmts.iter().all(|stmt| matches!(stmt.kind, StmtKind::Let { .. } | StmtKind::Expr { .. }))
        }
        ExprKind::MethodCall { method, args, .. } => {
            // A cell is changed through a shared reference.
            let opens_cell = matches!(method.as_str(), "get" | "borrow") && args.is_empty();
            !opens_cell && !method.ends_with("_mut") && only_reads(own, at(number), depth + 1)
        }
        ExprKind::Call { .. } => only_reads(own, at(number), depth + 1),
        _ => false,
    })
}
