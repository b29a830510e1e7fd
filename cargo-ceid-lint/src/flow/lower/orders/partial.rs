//! What the types of compared values say of their comparisons: whether two of them always stand to each other in some order, and what an
//! equality of the analysed code tells.

use std::collections::BTreeSet;

use crate::flow::Program;
use crate::flow::lower::Builder;
use crate::index::{FunctionId, Owner, Shape, TraitName, Ty, TypeId};
use crate::syntax::tree::{Body, ExprId, ExprKind, Literal, PatId, PatKind, TypeRef};
use crate::types::TypedBody;

/// Types of the standard library whose values are compared as what they hold is.
const COMPARED_BY_CONTENT: &[&str] = &[
    "Option",
    "Result",
    "Box",
    "Rc",
    "Arc",
    "Vec",
    "VecDeque",
    "LinkedList",
    "BTreeMap",
    "Reverse",
    "Wrapping",
    "Saturating",
    "Cow",
    "Cell",
    "RefCell",
    "Pin",
    "Poll",
    "ControlFlow",
    "Bound",
];

impl Builder<'_> {
    /// Whether two values of a type may stand to each other in no order, as NaN does to all numbers. Of types that are not read nothing
    /// else is known but that they are compared.
    pub(in crate::flow::lower) fn may_be_unordered(&self, ty: &Ty) -> bool {
        let is_bound_here = matches!(ty.peel(), Ty::Opaque(_)) && self.bounds_parts_by_order();
        !is_bound_here && may_be_unordered(self.program, ty, &mut BTreeSet::new())
    }

    /// Whether a float is compared of which the code tells that it is a number: how many seconds a length of time has.
    pub(in crate::flow::lower) fn are_numbers(&self, sides: [ExprId; 2]) -> bool {
        let is_span = |id: ExprId| match &self.body().expr(id).kind {
            ExprKind::MethodCall { receiver, method, .. } => {
                let is_of_time = self.ty(*receiver).peel().external_name() == Some("Duration");
                is_of_time && method.starts_with("as_") && *self.ty(id) == Ty::Unknown
            }
            _ => false,
        };
        let is_known = |id: ExprId| is_span(id) || self.constants().asked_number(id).is_some();
        sides.into_iter().any(is_span) && sides.into_iter().all(is_known)
    }

    /// Whether the function at hand, or its impl, asks that an associated type has an order: `where D::Reading: Ord`.
    fn bounds_parts_by_order(&self) -> bool {
        let index = self.program.index;
        let def = index.function(self.frames[self.frame].function);
        let of_impl = match def.owner {
            Owner::Impl(id) => Some(&index.impl_def(id).generics),
            _ => None,
        };
        let generics = of_impl.into_iter().chain([&def.function.generics]);
        generics.flat_map(|generics| &generics.predicates).any(|(subject, bounds)| {
            let is_part = matches!(subject, TypeRef::Path(path) if path.ident().is_none());
            is_part && bounds.iter().any(|bound| bound.last() == "Ord")
        })
    }

    /// Whether a comparison runs a method of the analysed code that only the contract binds to the other comparisons: an `ne` that
    /// is written out need not be the opposite of `eq`.
    pub(in crate::flow::lower) fn has_own_operator(&self, ty: &Ty, op: &str) -> bool {
        let methods: &[&str] = match op {
            "==" | "!=" => &["ne"],
            _ => &["lt", "le", "gt", "ge"],
        };
        self.has_own_method(ty, methods)
    }

    fn has_own_method(&self, ty: &Ty, methods: &[&str]) -> bool {
        match ty {
            Ty::Ref(_, inner) | Ty::Array(inner, _) | Ty::Slice(inner) => self.has_own_method(inner, methods),
            Ty::Tuple(parts) => parts.iter().any(|part| self.has_own_method(part, methods)),
            Ty::Adt(..) => ["PartialEq", "PartialOrd"]
                .iter()
                .any(|of| methods.iter().any(|method| own_methods(self.program, ty, of, method).next().is_some())),
            _ => false,
        }
    }

    /// Whether values are equal exactly where they are the same variant, or the same constant: not where the analysed code says
    /// what `==` means, unless it says just that.
    pub(in crate::flow::lower) fn tells_variants_apart(&self, ty: &Ty) -> bool {
        let ty = ty.peel();
        own_methods(self.program, ty, "PartialEq", "eq").all(|method| self.compares_all(ty, method))
    }

    /// Whether an `eq` compares all that there is to a value.
    fn compares_all(&self, ty: &Ty, method: FunctionId) -> bool {
        let Some((body, _)) = read(self.program, method) else { return false };
        let [own, other] = body.params.as_slice() else { return false };
        let PatKind::Bind { name: other, .. } = &body.pat(*other).kind else { return false };
        let PatKind::Bind { name: own, .. } = &body.pat(*own).kind else { return false };
        let Ty::Adt(id, _) = ty else { return false };
        let root = tail_of(body, body.root);
        match &self.program.index.type_def(*id).shape {
            Shape::Struct(fields) => {
                let mut compared = Vec::new();
                self.add_mirrored(body, root, [own, other], &mut compared);
                fields.fields.iter().all(|field| compared.contains(&format!("self.{}", field.name)))
            }
            Shape::Enum(variants) => {
                let mut compared = Vec::new();
                self.add_mirrored(body, root, [own, other], &mut compared);
                let is_variant = |text: &String| text.contains("discriminant(") || text.contains(" as ");
                let units = variants.iter().filter(|variant| variant.fields.fields.is_empty());
                matches!(compared.as_slice(), [text] if is_variant(text)) || {
                    let mut listed = BTreeSet::new();
                    lists_pairs(body, root, &mut listed) && units.clone().all(|unit| listed.contains(&unit.name))
                }
            }
        }
    }

    /// Adds what is compared on both sides alike: `self.x == other.x && self.y == other.y`.
    fn add_mirrored(&self, body: &Body, id: ExprId, names: [&str; 2], compared: &mut Vec<String>) {
        let ExprKind::Binary { op, lhs, rhs } = &body.expr(id).kind else { return };
        match *op {
            "&&" => {
                self.add_mirrored(body, *lhs, names, compared);
                self.add_mirrored(body, *rhs, names, compared);
            }
            "==" => {
                let [left, right] = [*lhs, *rhs].map(|side| self.program.sources.snippet(body.expr(side).span));
                let [left, right] = [renamed(left, names[0]), renamed(right, names[1])];
                if left == right {
                    compared.push(left);
                }
            }
            _ => {}
        }
    }
}

/// A spelling in which a variable is called `self`.
fn renamed(text: &str, name: &str) -> String {
    let is_letter = |letter: char| letter.is_alphanumeric() || letter == '_';
    let mut words = String::new();
    let mut rest = text;
    while let Some(start) = rest.find(is_letter) {
        let end = rest[start..].find(|letter| !is_letter(letter)).map_or(rest.len(), |length| start + length);
        words.push_str(&rest[..start]);
        words.push_str(if rest[start..end] == *name { "self" } else { &rest[start..end] });
        rest = &rest[end..];
    }
    words + rest
}

/// What a block gives, or the expression itself.
fn tail_of(body: &Body, id: ExprId) -> ExprId {
    match &body.expr(id).kind {
        ExprKind::Block(block) if block.stmts.is_empty() => block.tail.map_or(id, |tail| tail_of(body, tail)),
        _ => id,
    }
}

/// Whether a match on a pair is true for two of the same variant only: `matches!((self, other), (A, A) | (B, B))`.
fn lists_pairs(body: &Body, id: ExprId, listed: &mut BTreeSet<String>) -> bool {
    match &body.expr(id).kind {
        ExprKind::Let { pat, .. } => is_pair(body, *pat, listed),
        ExprKind::Match { arms, .. } => arms.iter().all(|arm| {
            let is_false = matches!(body.expr(tail_of(body, arm.body)).kind, ExprKind::Literal(Literal::Bool(false)));
            is_false || arm.guard.is_none() && is_pair(body, arm.pat, listed)
        }),
        _ => false,
    }
}

/// Whether a pattern is two of the same variant, or one of several such pairs.
fn is_pair(body: &Body, pat: PatId, listed: &mut BTreeSet<String>) -> bool {
    let variant = |pat: PatId| {
        let mut at = pat;
        while let PatKind::Reference(inner) = &body.pat(at).kind {
            at = *inner;
        }
        match &body.pat(at).kind {
            PatKind::Path(path) | PatKind::TupleStruct(path, _) | PatKind::Struct(path, _) => {
                Some(path.last().to_owned())
            }
            PatKind::Bind { name, sub: None, .. } if name.starts_with(char::is_uppercase) => Some(name.clone()),
            _ => None,
        }
    };
    match &body.pat(pat).kind {
        PatKind::Or(pairs) => pairs.iter().all(|pair| is_pair(body, *pair, listed)),
        PatKind::Tuple(parts) => match parts.as_slice() {
            [left, right] => match (variant(*left), variant(*right)) {
                (Some(left), Some(right)) if left == right => {
                    listed.insert(left);
                    true
                }
                _ => false,
            },
            _ => false,
        },
        _ => false,
    }
}

/// The methods of that name that the analysed code gives a type for a trait of comparison.
fn own_methods<'p>(
    program: &'p Program<'_>,
    ty: &Ty,
    of_trait: &'p str,
    method: &'p str,
) -> impl Iterator<Item = FunctionId> + 'p {
    let impls = if matches!(ty, Ty::Adt(..)) { program.index.impls_of(ty) } else { Vec::new() };
    impls.into_iter().filter_map(move |id| {
        let def = program.index.impl_def(id);
        let is_it = matches!(&def.implements, Some(TraitName::External(path)) if path.strip_prefix("std::cmp::") == Some(of_trait));
        def.methods.get(method).copied().filter(|_| is_it)
    })
}

fn read<'p>(program: &'p Program<'_>, id: FunctionId) -> Option<(&'p Body, &'p TypedBody)> {
    Some((program.index.function(id).function.body.as_ref()?, program.typed(id)?))
}

fn may_be_unordered(program: &Program<'_>, ty: &Ty, seen: &mut BTreeSet<TypeId>) -> bool {
    let index = program.index;
    match ty {
        Ty::Float => true,
        Ty::Ref(_, inner) | Ty::Array(inner, _) | Ty::Slice(inner) => may_be_unordered(program, inner, seen),
        Ty::Tuple(parts) => parts.iter().any(|part| may_be_unordered(program, part, seen)),
        Ty::Param(param) => index.may_lack_order(&param.bounds),
        Ty::Opaque(bounds) => index.may_lack_order(bounds),
        Ty::External(path, args) => {
            let is_of_std = path.starts_with("std::");
            let holds = ty.external_name().is_some_and(|name| COMPARED_BY_CONTENT.contains(&name));
            // `uom::si::f32::Time`
            let is_float = || path.split("::").any(|part| matches!(part, "f32" | "f64"));
            if is_of_std { holds && args.iter().any(|arg| may_be_unordered(program, arg, seen)) } else { is_float() }
        }
        Ty::Adt(id, _) => {
            let has = |name: &str| index.implements(ty, &TraitName::External(format!("std::cmp::{name}")));
            if has("Ord") || !has("PartialOrd") {
                return false;
            }
            let mut own = own_methods(program, ty, "PartialOrd", "partial_cmp").peekable();
            if own.peek().is_some() {
                return own.any(|method| !orders_all(program, method, seen));
            }
            seen.insert(*id) && index.fields_of(ty).iter().any(|field| may_be_unordered(program, field, seen))
        }
        _ => false,
    }
}

/// Whether a `partial_cmp` gives an order for any two values.
fn orders_all(program: &Program<'_>, method: FunctionId, seen: &mut BTreeSet<TypeId>) -> bool {
    let Some((body, typed)) = read(program, method) else { return false };
    match &body.expr(tail_of(body, body.root)).kind {
        ExprKind::Call { callee, .. } => {
            matches!(&body.expr(*callee).kind, ExprKind::Path(path) if path.last() == "Some")
        }
        ExprKind::MethodCall { receiver, method, .. } if method == "partial_cmp" => {
            let compared = typed.ty(*receiver);
            *compared != Ty::Unknown && !may_be_unordered(program, compared, seen)
        }
        _ => false,
    }
}
