//! Parts of `self`, down to the fields of its fields and the elements of its arrays.

use std::collections::BTreeSet;

use super::Method;
use crate::flow::Program;
use crate::index::{FunctionId, Shape, Ty};
use crate::syntax::tree::{ExprId, ExprKind, PatId, PatKind};
use crate::types::LocalId;

/// A part by the names that lead to it; an element of an array by its number in brackets.
pub(super) type Part = Vec<String>;

/// How deep types are taken apart, and the longest array of which each element is looked at.
const MOST_PARTS: usize = 6;
const LONGEST_ARRAY: u64 = 16;

/// The parts of `self` that a function may write; `None` if it writes all of it, or hands it to something else.
pub(super) fn written_parts(program: &Program<'_>, id: FunctionId) -> Option<BTreeSet<Part>> {
    Method::new(program, id, &[], 0)?.writes_parts()
}

/// Whether some parts are all of one part of a type: it is one of them or lies in one, or each of its own parts does.
pub(super) fn covers(program: &Program<'_>, parts: &BTreeSet<Part>, part: &[String], ty: &Ty) -> bool {
    (1..=part.len()).any(|length| {
        let (part, _) = part.split_at(length);
        is_in(parts, part) || is_made_of(program, parts, part, type_of(program, ty, part).as_ref())
    })
}

/// Whether a part is one of some parts, or lies in one. What is done with each element is done with that of any number.
fn is_in(parts: &BTreeSet<Part>, part: &[String]) -> bool {
    let is_number = |name: &&String| name.starts_with('[');
    let of_each: Vec<&String> = part.iter().filter(|name| !is_number(name)).collect();
    parts.iter().any(|own| {
        part.starts_with(own) || own.len() <= of_each.len() && own.iter().zip(&of_each).all(|(own, name)| own == *name)
    })
}

fn is_made_of(program: &Program<'_>, parts: &BTreeSet<Part>, part: &[String], ty: Option<&Ty>) -> bool {
    let is_below = parts.iter().any(|own| own.starts_with(part));
    let Some(ty) = ty.map(Ty::peel).filter(|_| is_below && part.len() < MOST_PARTS) else { return false };
    let has = |name: String, ty: Option<&Ty>| {
        let part: Part = part.iter().cloned().chain([name]).collect();
        is_in(parts, &part) || is_made_of(program, parts, &part, ty)
    };
    match ty {
        Ty::Tuple(types) => types.iter().enumerate().all(|(number, ty)| has(number.to_string(), Some(ty))),
        Ty::Array(element, length) => {
            let length = length.value.filter(|length| *length <= LONGEST_ARRAY);
            length.is_some_and(|length| (0..length).all(|number| has(format!("[{number}]"), Some(element))))
        }
        Ty::Adt(id, _) => match &program.index.type_def(*id).shape {
            Shape::Struct(fields) => fields
                .fields
                .iter()
                .all(|field| has(field.name.clone(), program.index.field_ty(ty, None, &field.name).as_ref())),
            Shape::Enum(_) => false,
        },
        _ => false,
    }
}

/// The type of a part.
fn type_of(program: &Program<'_>, ty: &Ty, part: &[String]) -> Option<Ty> {
    let Some((first, rest)) = part.split_first() else { return Some(ty.clone()) };
    let inner = match ty.peel() {
        // What is done with each element needs no number.
        Ty::Array(element, _) | Ty::Slice(element) => {
            return type_of(program, element, if first.starts_with('[') { rest } else { part });
        }
        Ty::Tuple(types) => types.get(first.parse::<usize>().ok()?)?.clone(),
        ty => program.index.field_ty(ty, None, first)?,
    };
    type_of(program, &inner, rest)
}

impl Method<'_, '_> {
    /// The part that a place is or lies in, and whether it is all of that.
    pub(super) fn part(&self, expr: ExprId) -> Option<(Part, bool)> {
        if self.is_self(expr) {
            return Some((Part::new(), true));
        }
        match &self.body.expr(expr).kind {
            ExprKind::Field { base, name } => {
                let (mut part, is_whole) = self.part(*base)?;
                part.extend(is_whole.then(|| name.clone()));
                Some((part, is_whole))
            }
            // What the type's own `[]` means may be another element.
            ExprKind::Index { base, .. } if self.typed.indexed.contains_key(&expr) => {
                Some((self.part(*base)?.0, false))
            }
            ExprKind::Index { base, index } => {
                let (mut part, is_whole) = self.part(*base)?;
                let number = self.head(*index).filter(|head| head.parse::<u64>().is_ok());
                part.extend(number.iter().filter(|_| is_whole).map(|number| format!("[{number}]")));
                Some((part, is_whole && (number.is_some() || self.is_each(*base, *index))))
            }
            ExprKind::Deref(inner) | ExprKind::Reference { value: inner, .. } => self.part(*inner),
            ExprKind::MethodCall { receiver, method, .. } => {
                let (part, is_whole) = self.part(*receiver)?;
                Some((
                    part,
                    is_whole && matches!(method.as_str(), "as_mut_slice" | "deref_mut" | "get_mut" | "borrow_mut"),
                ))
            }
            _ => {
                let local = self.typed.expr_local.get(&expr)?;
                let field = || Some(vec![self.fields.get(local)?.clone()]);
                Some((self.parts.get(local).cloned().or_else(field)?, true))
            }
        }
    }

    /// Whether an index goes through all numbers that a collection has.
    fn is_each(&self, base: ExprId, index: ExprId) -> bool {
        let end = match &self.body.expr(index).kind {
            ExprKind::Range { start: None, end: None, .. } => return true,
            _ => self.typed.expr_local.get(&index).and_then(|local| self.counters.get(local)),
        };
        let Some(end) = end else { return false };
        let (Some(end), Ty::Array(_, length)) = (end, self.typed.ty(base).peel()) else { return true };
        let number = self.head(*end).and_then(|head| head.parse::<u64>().ok());
        number.is_none_or(|number| length.value.is_none_or(|length| number >= length))
    }

    /// What a loop goes through, if that is each element of a part: the part.
    pub(super) fn each_of(&self, iterable: ExprId) -> Option<Part> {
        match &self.body.expr(iterable).kind {
            ExprKind::MethodCall { receiver, method, args, .. } if args.is_empty() => match method.as_str() {
                "iter_mut" => self.part(*receiver).filter(|(_, is_whole)| *is_whole).map(|(part, _)| part),
                "rev" | "enumerate" | "flatten" => self.each_of(*receiver),
                "values_mut" => self.part(*receiver).map(|(part, _)| part),
                _ => None,
            },
            ExprKind::Reference { mutable: true, .. } | ExprKind::Path(_) => {
                self.part(iterable).filter(|(_, is_whole)| *is_whole).map(|(part, _)| part)
            }
            _ => None,
        }
    }

    /// The variable that a pattern gives an element: `z`, `(_, z)`.
    pub(super) fn element(&self, pat: PatId) -> Option<LocalId> {
        match &self.body.pat(pat).kind {
            PatKind::Bind { .. } => self.typed.pat_local.get(&pat).copied(),
            PatKind::Tuple(parts) => self.element(*parts.last()?),
            _ => None,
        }
    }

    /// The number up to which a loop counts from zero; `Some(None)` if that is as many as something has, or is not known.
    pub(super) fn counted_to(&self, iterable: ExprId) -> Option<Option<ExprId>> {
        let ExprKind::Range { start, end: Some(end), inclusive: false } = self.body.expr(iterable).kind else {
            return None;
        };
        let is_from_zero = start.is_none_or(|start| self.head(start).as_deref() == Some("0"));
        is_from_zero.then_some(())?;
        self.all_up_to(end)
    }

    /// The same for an end that is written: half of a length is not all.
    pub(super) fn all_up_to(&self, end: ExprId) -> Option<Option<ExprId>> {
        match &self.body.expr(end).kind {
            ExprKind::Binary { .. } => None,
            ExprKind::MethodCall { method, .. } => (method == "len").then_some(None),
            _ => Some(Some(end)),
        }
    }

    fn writes_parts(&self) -> Option<BTreeSet<Part>> {
        let mut found = BTreeSet::new();
        let part = |place: ExprId| self.part(place).map(|(part, _)| part).filter(|part| !part.is_empty());
        for id in (0u32..).map(ExprId).take(self.body.exprs.len()) {
            match &self.body.expr(id).kind {
                ExprKind::Assign { place, .. } | ExprKind::AssignOp { place, .. } => {
                    if self.is_self(*place) {
                        return None;
                    }
                    let places = self.body.assigned_places(*place);
                    found.extend(places.iter().filter_map(|place| part(*place)));
                }
                ExprKind::Reference { mutable: true, value, .. } => found.extend(part(*value)),
                ExprKind::MethodCall { receiver, .. } if self.is_self(*receiver) => {
                    for target in self.targets(id).unwrap_or_default() {
                        found.extend(Self::new(self.program, *target, &[], self.depth + 1)?.writes_parts()?);
                    }
                }
                ExprKind::MethodCall { receiver, .. } if self.writes(id, *receiver) => {
                    let Some(own) = part(*receiver) else { continue };
                    let of_target = |target: &FunctionId| {
                        Self::new(self.program, *target, &[], self.depth + 1).and_then(|method| method.writes_parts())
                    };
                    let inner = self.targets(id).filter(|targets| !targets.is_empty());
                    let inner: Option<Vec<_>> = inner.and_then(|targets| targets.iter().map(of_target).collect());
                    match inner {
                        Some(inner) => found.extend(
                            inner.into_iter().flatten().map(|part| own.iter().cloned().chain(part).collect::<Part>()),
                        ),
                        None => found.extend([own]),
                    }
                }
                _ => {}
            }
        }
        Some(found)
    }
}
