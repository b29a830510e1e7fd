//! What runs without being called by its name: the impls of operators, formats, conversions, iterators and `Deref`.

use std::collections::{BTreeMap, BTreeSet};

use super::shared::shared_part;
use crate::flow::Program;
use crate::index::{
    Def, FunctionId, ImplDef, ImplId, Index, ModuleId, Owner, TraitName, TraitRef, Ty, TypeId, primitive,
};
use crate::syntax::tree::{Body, ExprId, ExprKind, GenericArg};
use crate::types::{Callee, TypedBody};

/// The modules of the standard library whose traits its functions and macros call.
const CALLED: [&str; 13] =
    ["borrow", "clone", "cmp", "convert", "default", "error", "fmt", "future", "hash", "io", "iter", "ops", "str"];

/// The traits that macros run: those of formats, where the text goes, and what assertions compare.
const SHOWN: [&str; 12] = [
    "Debug",
    "Display",
    "LowerHex",
    "UpperHex",
    "LowerExp",
    "UpperExp",
    "Binary",
    "Octal",
    "Pointer",
    "Write",
    "PartialEq",
    "PartialOrd",
];

/// The traits whose impls an expression may run.
enum Traits {
    Named(Vec<String>),
    /// All that code of other crates may call.
    Any,
}

/// The impls of the analysed code of traits of the standard library, by the names of the traits.
pub(super) type Impls = BTreeMap<String, Vec<ImplId>>;

/// The impls that may run without being called.
pub(super) fn impls_of_std(index: &Index) -> Impls {
    let mut found = Impls::default();
    for (id, def) in (0u32..).map(ImplId).zip(&index.impls) {
        let name = match (&def.implements, &def.trait_path) {
            // A trait of the prelude may have no path.
            (Some(TraitName::External(path)), _) if is_called(path) || !path.contains("::") => path.rsplit("::").next(),
            (None, Some(path)) => Some(path.last()),
            _ => None,
        };
        // A destructor runs where a value is dropped, and nowhere else; what ceid-core has only calculates.
        let is_of_core = || index.crate_of(def.module).package_name.replace('-', "_") == "ceid_core";
        if let Some(name) = name.filter(|name| *name != "Drop" && !is_of_core()) {
            found.entry(name.to_owned()).or_default().push(id);
        }
    }
    found
}

/// Whether code of the standard library calls the methods of a trait.
fn is_called(path: &str) -> bool {
    let mut parts = path.split("::");
    parts.next() == Some("std") && parts.next().is_some_and(|module| CALLED.contains(&module))
}

/// The functions of the analysed code that a function may run without calling them: all that an operand may mean whose type is not
/// known.
pub(super) fn implicit(program: &Program<'_>, all: &Impls, function: FunctionId) -> Vec<FunctionId> {
    let index = program.index;
    let (Some(body), Some(typed)) = (&index.function(function).function.body, program.typed(function)) else {
        return Vec::new();
    };
    let mut found: Vec<FunctionId> = typed.items.values().flat_map(|item| &item.targets).copied().collect();
    found.extend(
        (0u32..).map(ExprId).take(body.exprs.len()).flat_map(|id| run_at(index, all, (function, body, typed), id)),
    );
    found.sort_unstable();
    found.dedup();
    found
}

/// The functions of the analysed code that one expression may run without calling them.
pub(super) fn implicit_at(program: &Program<'_>, all: &Impls, function: FunctionId, id: ExprId) -> Vec<FunctionId> {
    let index = program.index;
    let (Some(body), Some(typed)) = (&index.function(function).function.body, program.typed(function)) else {
        return Vec::new();
    };
    let mut found = run_at(index, all, (function, body, typed), id);
    found.extend(typed.items.get(&id).into_iter().flat_map(|item| &item.targets));
    found
}

fn run_at(
    index: &Index,
    all: &Impls,
    (function, body, typed): (FunctionId, &Body, &TypedBody),
    id: ExprId,
) -> Vec<FunctionId> {
    let module = index.function(function).module;
    let mut found: Vec<FunctionId> = Vec::new();
    if let Ty::FunctionItem(named) = typed.ty(id) {
        found.push(*named);
    }
    if let Some((traits, operands)) = run_by(body, typed, id) {
        // A literal has a type of the language, and a path to something of another crate one of that crate.
        let is_foreign = |operand: &ExprId| {
            matches!(body.expr(*operand).kind, ExprKind::Literal(_))
                || matches!(typed.expr_def.get(operand), Some(Def::External(_)))
        };
        let operands = operands.iter().filter(|operand| !is_foreign(operand));
        let mut types: Vec<Ty> = operands.map(|operand| typed.ty(*operand).clone()).collect();
        if matches!(body.expr(id).kind, ExprKind::Try(_)) {
            types.push(index.lower(&index.function(function).function.output, &index.scope_of(function)));
        }
        found.extend(impls(index, all, (&traits, module), &Reached::of(index, &types, true)));
    }
    if let Some(base) = dereferenced(body, id) {
        let traits = Traits::Named(vec!["Deref".to_owned(), "DerefMut".to_owned()]);
        let reached = Reached::of(index, std::slice::from_ref(typed.ty(base)), false);
        found.extend(impls(index, all, (&traits, module), &reached));
    }
    found
}

/// What a type shares with others that may stand for a parameter whose operators or conversions a function runs.
pub(super) fn shared_by_parameters(program: &Program<'_>, all: &Impls, function: FunctionId) -> Option<String> {
    let index = program.index;
    let body = index.function(function).function.body.as_ref()?;
    let typed = program.typed(function)?;
    let module = index.function(function).module;
    let linked = |id: &&ImplId| are_linked(index, module, index.impl_def(**id).module);
    (0u32..).map(ExprId).take(body.exprs.len()).find_map(|id| {
        let (traits, operands) = run_by(body, typed, id)?;
        operands.iter().map(|operand| typed.ty(*operand).peel()).find_map(|ty| {
            // What is copied shares nothing.
            let (Ty::Param(_) | Ty::Opaque(_)) = ty else { return None };
            let bounds = if index.is_copy(ty) { return None } else { bounds_of(ty) };
            let names = match &traits {
                Traits::Named(names) => names.clone(),
                Traits::Any => bounds.iter().filter_map(named_by_bound).flatten().collect(),
            };
            let impls = names.iter().filter_map(|name| all.get(name)).flatten().filter(linked);
            let is_local = |bound: &&TraitRef| matches!(bound.name, TraitName::Local(_));
            impls.copied().find_map(|id| {
                let def = index.impl_def(id);
                let scope = index.scope(def.module, Owner::Module, Some(&def.generics));
                let args = def.trait_path.iter().flat_map(|path| &path.segments).flat_map(|segment| &segment.args);
                let args =
                    args.filter_map(
                        |arg| if let GenericArg::Type(ty) = arg { Some(index.lower(ty, &scope)) } else { None },
                    );
                let own =
                    bounds.iter().filter(is_local).all(|bound| index.may_have(id, bound)).then(|| def.self_ty.clone());
                own.into_iter().chain(args).find_map(|ty| shared_part(index, &ty))
            })
        })
    })
}

fn bounds_of(ty: &Ty) -> &[TraitRef] {
    match ty {
        Ty::Param(param) => &param.bounds,
        Ty::Opaque(bounds) => bounds,
        _ => &[],
    }
}

/// The names of the impls by which a type has a bound.
fn named_by_bound(bound: &TraitRef) -> Option<Vec<String>> {
    let TraitName::External(path) = &bound.name else { return None };
    let name = path.rsplit("::").next().unwrap_or(path);
    let turned = name.strip_suffix("Into").map(|of| format!("{of}From"));
    Some([name.to_owned()].into_iter().chain(turned).collect())
}

/// The traits that an expression runs by itself, and the operands that say of which types.
fn run_by(body: &Body, typed: &TypedBody, id: ExprId) -> Option<(Traits, Vec<ExprId>)> {
    let named = |names: &[&str]| Traits::Named(names.iter().map(|name| (*name).to_owned()).collect());
    Some(match &body.expr(id).kind {
        ExprKind::Binary { op: "==" | "!=", lhs, rhs } => (named(&["PartialEq"]), vec![*lhs, *rhs]),
        ExprKind::Binary { op: "<" | "<=" | ">" | ">=", lhs, rhs } => (named(&["PartialOrd", "Ord"]), vec![*lhs, *rhs]),
        ExprKind::Binary { op, lhs, rhs } => (named(&[arithmetic(op)?]), vec![*lhs, *rhs]),
        ExprKind::AssignOp { op, place, value } => {
            (Traits::Named(vec![format!("{}Assign", arithmetic(op)?)]), vec![*place, *value])
        }
        ExprKind::Negate(inner) => (named(&["Neg"]), vec![*inner]),
        ExprKind::Not(inner) => (named(&["Not"]), vec![*inner]),
        ExprKind::Index { base, index } => (named(&["Index", "IndexMut"]), vec![*base, *index]),
        ExprKind::For { iterable, .. } => (named(&["IntoIterator", "Iterator"]), vec![*iterable]),
        ExprKind::Try(inner) => (named(&["From", "Into"]), vec![*inner]),
        ExprKind::Await(inner) => (named(&["Future", "IntoFuture"]), vec![*inner]),
        ExprKind::Repeat { value, is_vec: true, .. } => (named(&["Clone"]), vec![*value]),
        ExprKind::Macro(_) => (named(&SHOWN), body.children(id)),
        ExprKind::Call { callee, args } => match typed.callees.get(&id) {
            Some(Callee::External(_) | Callee::Builtin | Callee::Unknown) => {
                // `u32::from` makes a number.
                let is_number = matches!(&body.expr(*callee).kind, ExprKind::Path(path)
                    if matches!(path.segments.as_slice(), [owner, _] if primitive(&owner.name).is_some()));
                (Traits::Any, args.iter().copied().chain((!is_number).then_some(id)).collect())
            }
            _ => return None,
        },
        ExprKind::MethodCall { receiver, method, args, .. } => match typed.callees.get(&id) {
            Some(Callee::Resolved(resolved)) if !resolved.targets.is_empty() => return None,
            _ if is_of_numbers(method) => return None,
            // What others give back is made of what they are given.
            _ => {
                let chooses = matches!(method.as_str(), "into" | "try_into" | "parse" | "collect" | "sum" | "product");
                (Traits::Any, args.iter().copied().chain([*receiver]).chain(chooses.then_some(id)).collect())
            }
        },
        _ => return None,
    })
}

/// Methods that only numbers have.
const OF_NUMBERS: &str = "\
    abs sqrt cbrt powi powf exp exp2 ln log log2 log10 sin cos tan asin acos atan atan2 sin_cos sinh cosh tanh hypot \
    floor ceil round trunc fract signum copysign recip mul_add rem_euclid div_euclid to_radians to_degrees to_bits len";

/// Whether a method is one of numbers alone, so that it runs nothing even where the type of its receiver is not known.
fn is_of_numbers(method: &str) -> bool {
    let prefixes = ["wrapping_", "saturating_", "checked_", "overflowing_", "is_", "leading_", "trailing_", "count_"];
    prefixes.iter().any(|prefix| method.starts_with(prefix)) || OF_NUMBERS.split_whitespace().any(|own| own == method)
}

/// What an expression reaches through a `Deref` impl, if there is one.
fn dereferenced(body: &Body, id: ExprId) -> Option<ExprId> {
    match &body.expr(id).kind {
        ExprKind::Field { base, .. } | ExprKind::Index { base, .. } => Some(*base),
        ExprKind::MethodCall { receiver, .. } => Some(*receiver),
        ExprKind::Deref(inner) | ExprKind::Reference { value: inner, .. } => Some(*inner),
        _ => None,
    }
}

/// The trait of an operator on two operands.
fn arithmetic(op: &str) -> Option<&'static str> {
    Some(match op {
        "+" => "Add",
        "-" => "Sub",
        "*" => "Mul",
        "/" => "Div",
        "%" => "Rem",
        "&" => "BitAnd",
        "|" => "BitOr",
        "^" => "BitXor",
        "<<" => "Shl",
        ">>" => "Shr",
        _ => return None,
    })
}

/// The types of the analysed code that values of some types lead to.
#[derive(Default)]
struct Reached {
    types: BTreeSet<TypeId>,
    /// Whether one of them is not known, and may be any.
    is_open: bool,
}

impl Reached {
    /// What is derived runs the impls of the fields.
    fn of(index: &Index, types: &[Ty], with_fields: bool) -> Self {
        let mut reached = Self::default();
        let mut open: Vec<(Ty, bool)> = types.iter().map(|ty| (ty.clone(), false)).collect();
        while let Some((ty, is_field)) = open.pop() {
            ty.has_part(&mut |part| {
                match part {
                    Ty::Adt(id, _) if reached.types.insert(*id) && with_fields => {
                        open.extend(index.field_types(part).into_iter().map(|field| (field, true)));
                    }
                    // What the parameter of a type stands for is among its arguments.
                    Ty::Param(_) if is_field => {}
                    Ty::Unknown | Ty::Var(_) | Ty::Param(_) | Ty::Opaque(_) => reached.is_open = true,
                    _ => {}
                }
                false
            });
        }
        reached
    }

    fn has(&self, ty: &Ty) -> bool {
        ty.has_part(&mut |part| matches!(part, Ty::Adt(id, _) if self.types.contains(id)))
    }
}

/// Whether one of two crates may know a type of the other.
fn are_linked(index: &Index, one: ModuleId, other: ModuleId) -> bool {
    let (one, other) = (index.crate_of(one), index.crate_of(other));
    one.root == other.root || one.externs.contains_key(&other.name) || other.externs.contains_key(&one.name)
}

/// The methods of all impls of such traits that are written for one of the types, or with one of them as an argument.
fn impls(index: &Index, all: &Impls, (traits, from): (&Traits, ModuleId), reached: &Reached) -> Vec<FunctionId> {
    if reached.types.is_empty() && !reached.is_open {
        return Vec::new();
    }
    let is_concerned = |def: &ImplDef| {
        let scope = index.scope(def.module, Owner::Module, Some(&def.generics));
        let args = def.trait_path.iter().flat_map(|path| &path.segments).flat_map(|segment| &segment.args);
        let is_it = |arg: &GenericArg| matches!(arg, GenericArg::Type(ty) if reached.has(&index.lower(ty, &scope)));
        reached.is_open && are_linked(index, from, def.module)
            || reached.has(&def.self_ty)
            || args.into_iter().any(is_it)
    };
    let of_traits: Vec<ImplId> = match traits {
        Traits::Named(names) => names.iter().filter_map(|name| all.get(name)).flatten().copied().collect(),
        Traits::Any => all.values().flatten().copied().collect(),
    };
    let concerned = of_traits.into_iter().map(|id| index.impl_def(id)).filter(|def| is_concerned(def));
    concerned.flat_map(|def| def.methods.values().copied()).collect()
}
