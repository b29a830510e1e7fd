//! Patterns: what their names are bound to, with the binding modes of `match`.

use super::infer::Infer;
use crate::index::{Def, Namespace, Ty};
use crate::syntax::tree::{PatId, PatKind, Path};

impl Infer<'_> {
    /// Binds the names of a pattern that is matched against a value of the type. `mode` is set behind a reference.
    pub(super) fn pat(&mut self, id: PatId, ty: &Ty, mode: Option<bool>) {
        let body = self.body;
        let ty = self.variables.shallow(ty);
        let kind = &body.pat(id).kind;
        // A pattern that takes the value apart looks through references.
        if let Ty::Ref(mutable, inner) = &ty
            && matches!(
                kind,
                PatKind::Tuple(_)
                    | PatKind::TupleStruct(..)
                    | PatKind::Struct(..)
                    | PatKind::Slice(_)
                    | PatKind::Or(_)
                    | PatKind::Path(_)
            )
        {
            let mode = mode.map_or(*mutable, |outer| outer && *mutable);
            return self.pat(id, &inner.clone(), Some(mode));
        }
        match kind {
            PatKind::Bind { name, by_ref, mutable, sub } => {
                if sub.is_none() && !by_ref && !mutable && self.is_constant(id, name) {
                    return;
                }
                let bound = match mode {
                    Some(mutable) if !by_ref => Ty::Ref(mutable, Box::new(ty.clone())),
                    _ if *by_ref => Ty::Ref(*mutable, Box::new(ty.clone())),
                    _ => ty.clone(),
                };
                self.bind(id, name, &bound, *by_ref || mode.is_some());
                if let Some(sub) = sub {
                    self.pat(*sub, &ty, mode);
                }
            }
            PatKind::Tuple(pats) => {
                let parts = match &ty {
                    Ty::Tuple(parts) => parts.clone(),
                    _ => Vec::new(),
                };
                self.sequence(pats, &parts, mode);
            }
            PatKind::TupleStruct(path, pats) => {
                let def = self.pattern_def(id, path);
                let parts = self.tuple_fields(def.as_ref(), &ty, pats.len());
                self.sequence(pats, &parts, mode);
            }
            PatKind::Struct(path, fields) => {
                let def = self.pattern_def(id, path);
                for (name, pat) in fields {
                    let field = self.field_of(def.as_ref(), &ty, name);
                    self.pat(*pat, &field, mode);
                }
            }
            PatKind::Path(path) => {
                self.pattern_def(id, path);
            }
            PatKind::Reference(inner) => {
                let target = match &ty {
                    Ty::Ref(_, inner) => (**inner).clone(),
                    _ => ty.clone(),
                };
                self.pat(*inner, &target, None);
            }
            PatKind::Or(pats) => {
                for pat in pats {
                    self.pat(*pat, &ty, mode);
                }
                self.share_names(pats);
            }
            PatKind::Slice(pats) => {
                if let Ty::Array(_, length) = &ty {
                    self.typed.pat_length.extend(length.value.map(|length| (id, length)));
                }
                let item = match &ty {
                    Ty::Array(inner, _) | Ty::Slice(inner) => (**inner).clone(),
                    _ => Ty::Unknown,
                };
                for pat in pats {
                    let ty = if self.body.is_rest(*pat) { Ty::Slice(Box::new(item.clone())) } else { item.clone() };
                    self.pat(*pat, &ty, mode);
                }
            }
            PatKind::Range { start, end, .. } => {
                for end in start.iter().chain(end) {
                    self.expr(*end, Some(&ty));
                }
            }
            PatKind::Wild | PatKind::Rest | PatKind::Literal(_) | PatKind::Unknown => {}
        }
    }

    /// The names of an or-pattern are the same variables in each alternative.
    fn share_names(&mut self, pats: &[PatId]) {
        let mut first: Vec<(String, super::LocalId)> = Vec::new();
        for pat in pats {
            for (bound, name) in bound_names(self.body, *pat) {
                let Some(local) = self.typed.pat_local.get(&bound).copied() else { continue };
                match first.iter().find(|(known, _)| *known == name) {
                    None => first.push((name, local)),
                    Some((_, shared)) => {
                        self.typed.pat_local.insert(bound, *shared);
                        if let Some(scope) = self.names.last_mut() {
                            scope.insert(name, *shared);
                        }
                    }
                }
            }
        }
    }

    /// The pattern of an arm, which may be one of several constants.
    pub(super) fn arm_pat(&mut self, id: PatId, ty: &Ty) {
        let outer = std::mem::replace(&mut self.in_arm, true);
        self.pat(id, ty, None);
        self.in_arm = outer;
    }

    fn sequence(&mut self, pats: &[PatId], parts: &[Ty], mode: Option<bool>) {
        let rest = pats.iter().position(|pat| matches!(self.body.pat(*pat).kind, PatKind::Rest));
        for (number, pat) in pats.iter().enumerate() {
            let at = match rest {
                Some(rest) if number > rest => (parts.len() + number).checked_sub(pats.len()),
                _ => Some(number),
            };
            let part = at.and_then(|at| parts.get(at)).cloned().unwrap_or(Ty::Unknown);
            self.pat(*pat, &part, mode);
        }
    }

    /// Whether a lone name in a pattern is a constant or unit variant.
    fn is_constant(&mut self, id: PatId, name: &str) -> bool {
        match self.index.resolve(self.module(), &[name.to_owned()], Namespace::Value) {
            Some(def @ (Def::Value(_) | Def::Variant(..))) => {
                self.typed.pat_def.insert(id, def);
                true
            }
            // What an unread crate has is a constant by its name alone. Only an arm asks for one: registers are named like that too.
            Some(Def::External(path))
                if path.ends_with("::None") || (self.in_arm && name.starts_with(char::is_uppercase)) =>
            {
                self.typed.pat_def.insert(id, Def::External(path));
                true
            }
            None if self.in_arm && is_screaming(name) => {
                self.typed.pat_def.insert(id, Def::External(name.to_owned()));
                true
            }
            Some(def @ Def::Type(_)) => {
                let is_unit = matches!(&def, Def::Type(ty) if matches!(&self.index.type_def(*ty).shape,
                    crate::index::Shape::Struct(fields) if fields.fields.is_empty()));
                if is_unit {
                    self.typed.pat_def.insert(id, def);
                }
                is_unit
            }
            _ => false,
        }
    }

    fn pattern_def(&mut self, id: PatId, path: &Path) -> Option<Def> {
        let def = self.path_def(path)?;
        self.typed.pat_def.insert(id, def.clone());
        Some(def)
    }

    /// What a path names where `Self` may be its first segment.
    pub(super) fn path_def(&self, path: &Path) -> Option<Def> {
        let mut names: Vec<String> = path.segments.iter().map(|segment| segment.name.clone()).collect();
        if names.first().is_some_and(|first| first == "Self") {
            let Some(Ty::Adt(id, _)) = &self.scope.self_ty else { return None };
            return match names.as_slice() {
                [_] => Some(Def::Type(*id)),
                [_, variant] => match &self.index.type_def(*id).shape {
                    crate::index::Shape::Enum(variants) => {
                        variants.iter().position(|candidate| candidate.name == *variant).map(|at| Def::Variant(*id, at))
                    }
                    crate::index::Shape::Struct(_) => None,
                },
                _ => None,
            };
        }
        if path.global {
            names.insert(0, String::new());
        }
        self.index
            .resolve(self.module(), &names, Namespace::Value)
            .or_else(|| self.index.resolve(self.module(), &names, Namespace::Type))
    }

    fn tuple_fields(&self, def: Option<&Def>, ty: &Ty, count: usize) -> Vec<Ty> {
        if let Some(Def::External(path)) = def {
            let inner = match ty {
                // What makes a filter may have given a `Result` of it.
                Ty::External(..) if self.index.law_spec(ty).is_some() && !path.ends_with("::Err") => ty.clone(),
                // What was locked is there, too, where the one before panicked.
                Ty::External(own, _) if own.ends_with("::LockResult") && path.ends_with("::Err") => ty.clone(),
                Ty::External(_, args) => {
                    let at = usize::from(path.ends_with("::Err"));
                    args.get(at).cloned().unwrap_or(Ty::Unknown)
                }
                _ => Ty::Unknown,
            };
            return vec![inner];
        }
        let wanted = match def {
            Some(Def::Variant(id, _)) => match &self.index.type_def(*id).shape {
                crate::index::Shape::Enum(variants) => {
                    let Some(Def::Variant(_, at)) = def else { return Vec::new() };
                    variants[*at].fields.fields.len()
                }
                crate::index::Shape::Struct(fields) => fields.fields.len(),
            },
            Some(Def::Type(id)) => match &self.index.type_def(*id).shape {
                crate::index::Shape::Struct(fields) => fields.fields.len(),
                crate::index::Shape::Enum(_) => count,
            },
            _ => count,
        };
        (0..wanted).map(|at| self.field_of(def, ty, &at.to_string())).collect()
    }

    fn field_of(&self, def: Option<&Def>, ty: &Ty, name: &str) -> Ty {
        let (own, variant) = match def {
            Some(Def::Variant(id, at)) => (Some(*id), Some(*at)),
            Some(Def::Type(id)) => (Some(*id), None),
            _ => (None, None),
        };
        let subject = match (ty, own) {
            (Ty::Adt(id, _), Some(own)) if *id == own => ty.clone(),
            (_, Some(own)) => {
                let params = self.index.type_def(own).generics.params.len();
                Ty::Adt(own, vec![Ty::Unknown; params])
            }
            _ => ty.clone(),
        };
        self.index.field_ty(&subject, variant, name).unwrap_or(Ty::Unknown)
    }
}

/// Whether a name is written as constants are, and no lone letter of a formula.
fn is_screaming(name: &str) -> bool {
    name.len() > 1
        && name.starts_with(|letter: char| letter.is_ascii_uppercase())
        && name.chars().all(|letter| letter.is_ascii_uppercase() || letter.is_ascii_digit() || letter == '_')
}

/// The names that a pattern binds, with their patterns.
fn bound_names(body: &crate::syntax::tree::Body, id: PatId) -> Vec<(PatId, String)> {
    let mut found = Vec::new();
    let mut open = vec![id];
    while let Some(id) = open.pop() {
        match &body.pat(id).kind {
            PatKind::Bind { name, sub, .. } => {
                found.push((id, name.clone()));
                open.extend(*sub);
            }
            PatKind::Tuple(pats) | PatKind::TupleStruct(_, pats) | PatKind::Or(pats) | PatKind::Slice(pats) => {
                open.extend(pats.iter().rev());
            }
            PatKind::Struct(_, fields) => open.extend(fields.iter().rev().map(|(_, pat)| *pat)),
            PatKind::Reference(inner) => open.push(*inner),
            PatKind::Wild
            | PatKind::Rest
            | PatKind::Path(_)
            | PatKind::Literal(_)
            | PatKind::Range { .. }
            | PatKind::Unknown => {}
        }
    }
    found
}
