//! Expressions: their types from what they are made of and from what is expected of them.

use super::builtin;
use super::infer::Infer;
use crate::index::{Def, Shape, Ty};
use crate::syntax::tree::{Block, ExprId, ExprKind, Literal, MacroExpr, MacroKind, PatKind, Path, StmtKind, TypeRef};

impl Infer<'_> {
    /// Walks an expression and answers its type.
    pub(super) fn expr(&mut self, id: ExprId, expected: Option<&Ty>) -> Ty {
        let found = self.expr_ty(id, expected);
        let ty = expected.and_then(|expected| self.lent_as(id, &found, expected)).unwrap_or(found);
        self.typed.expr_ty[id.0 as usize] = ty.clone();
        ty
    }

    fn expr_ty(&mut self, id: ExprId, expected: Option<&Ty>) -> Ty {
        let body = self.body;
        match &body.expr(id).kind {
            ExprKind::Path(path) => self.path_expr(id, path),
            ExprKind::Literal(literal) => literal_ty(literal),
            ExprKind::Block(block) => self.in_block(id, |this| this.block(block, expected)),
            ExprKind::If { condition, then, otherwise } => self.in_scope(|this| {
                this.expr(*condition, Some(&Ty::Bool));
                let then_ty = this.expr(*then, expected);
                match otherwise {
                    Some(otherwise) => {
                        let other = this.expr(*otherwise, expected);
                        this.either(&then_ty, &other)
                    }
                    None => Ty::unit(),
                }
            }),
            ExprKind::Let { pat, value } => {
                let ty = self.expr(*value, None);
                self.pat(*pat, &ty, None);
                Ty::Bool
            }
            ExprKind::Match { scrutinee, arms } => {
                let ty = self.expr(*scrutinee, None);
                let mut result = Ty::Never;
                for arm in arms {
                    let found = self.in_scope(|this| {
                        this.arm_pat(arm.pat, &ty);
                        if let Some(guard) = arm.guard {
                            this.expr(guard, Some(&Ty::Bool));
                        }
                        this.expr(arm.body, expected)
                    });
                    result = self.either(&result, &found);
                }
                result
            }
            ExprKind::Loop { label, body, .. } => {
                let result = self.variables.fresh();
                self.break_tys.push((label.clone(), result.clone()));
                self.expr(*body, None);
                self.break_tys.pop();
                result
            }
            ExprKind::While { label, condition, body, .. } => {
                self.break_tys.push((label.clone(), Ty::unit()));
                self.in_scope(|this| {
                    this.expr(*condition, Some(&Ty::Bool));
                    this.expr(*body, None);
                });
                self.break_tys.pop();
                Ty::unit()
            }
            ExprKind::For { label, pat, iterable, body, .. } => {
                let ty = self.expr(*iterable, None);
                let item = self.item_ty(&ty);
                self.break_tys.push((label.clone(), Ty::unit()));
                self.in_scope(|this| {
                    this.pat(*pat, &item, None);
                    this.expr(*body, None);
                });
                self.break_tys.pop();
                Ty::unit()
            }
            ExprKind::Break { label, value } => {
                if let Some(value) = value {
                    let found = self.expr(*value, None);
                    let target = self.break_tys.iter().rev().find(|(name, _)| label.is_none() || name == label);
                    if let Some((_, ty)) = target {
                        let ty = ty.clone();
                        self.variables.unify(&ty, &found);
                    }
                }
                Ty::Never
            }
            ExprKind::Continue { .. } => Ty::Never,
            ExprKind::Return(value) => {
                if let Some(value) = value {
                    let output = self.output.clone();
                    let found = self.expr(*value, Some(&output));
                    self.variables.unify(&output, &found);
                }
                Ty::Never
            }
            ExprKind::Call { callee, args } => self.call(id, *callee, args, expected),
            ExprKind::MethodCall { receiver, method, turbofish, args, .. } => {
                let found = self.method_call(id, *receiver, method, turbofish, args);
                // What an iterator is put together to, only its surroundings tell.
                let is_told = found == Ty::Unknown
                    && matches!(method.as_str(), "collect" | "sum" | "product" | "unzip" | "partition");
                let told = match turbofish.first() {
                    Some(ty) if is_told => self.annotation(ty),
                    None if is_told => expected.cloned().unwrap_or(found),
                    _ => found,
                };
                if is_told {
                    if let Some(expected) = expected {
                        self.variables.unify(&told, expected);
                    }
                    let of = self.typed.ty(*receiver).clone();
                    let item = self.item_ty(&of);
                    self.consume_into(method, &told, &item);
                }
                told
            }
            ExprKind::Field { base, name } => {
                let base = self.expr(*base, None);
                self.field(&base, name)
            }
            ExprKind::Index { base, index } => {
                let base = self.expr(*base, None);
                let index_ty = self.expr(*index, None);
                self.index_ty(id, &base, &index_ty)
            }
            ExprKind::Reference { mutable, raw, value } => {
                let inner_expected = match expected.map(|ty| self.variables.shallow(ty)) {
                    Some(Ty::Ref(_, inner)) => Some(*inner),
                    _ => None,
                };
                let inner = self.expr(*value, inner_expected.as_ref());
                if *raw { Ty::Pointer(Box::new(inner)) } else { Ty::Ref(*mutable, Box::new(inner)) }
            }
            ExprKind::Deref(inner) => {
                let ty = self.expr(*inner, None);
                self.deref(&ty)
            }
            ExprKind::Not(inner) | ExprKind::Negate(inner) => self.expr(*inner, expected),
            ExprKind::Binary { op, lhs, rhs } => self.binary(op, *lhs, *rhs),
            ExprKind::Assign { place, value } => {
                let place_ty = self.expr(*place, None);
                let found = self.expr(*value, Some(&place_ty));
                self.variables.unify(&place_ty, &found);
                Ty::unit()
            }
            ExprKind::AssignOp { place, value, .. } => {
                self.expr(*place, None);
                self.expr(*value, None);
                Ty::unit()
            }
            ExprKind::Range { start, end, .. } => {
                let mut item = Ty::Int;
                for bound in [start, end].into_iter().flatten() {
                    item = self.expr(*bound, None);
                }
                Ty::std("std::ops::Range", vec![item])
            }
            ExprKind::Closure(closure) => {
                let params = self.called_with(expected);
                self.closure(id, closure, &params)
            }
            ExprKind::Struct { path, fields, rest } => self.struct_expr(id, path, fields, *rest, expected),
            ExprKind::Tuple(parts) => {
                let wanted = match expected.map(|ty| self.variables.shallow(ty)) {
                    Some(Ty::Tuple(wanted)) => wanted,
                    _ => Vec::new(),
                };
                Ty::Tuple(parts.iter().enumerate().map(|(at, part)| self.expr(*part, wanted.get(at))).collect())
            }
            ExprKind::Array { elements, is_vec } => {
                let mut item = self.variables.fresh();
                for element in elements {
                    let found = self.expr(*element, Some(&item.clone()));
                    item = self.either(&item, &found);
                }
                sequence_ty(item, *is_vec, Some(elements.len() as u64), elements.len().to_string())
            }
            ExprKind::Repeat { value, len, is_vec } => {
                let item = self.expr(*value, None);
                self.expr(*len, Some(&Ty::Int));
                let value = self.const_of(*len);
                sequence_ty(item, *is_vec, value, String::new())
            }
            ExprKind::Cast { value, ty } => {
                let to = self.index.lower(ty, &self.scope);
                // `Box::new(|rig| rig.step()) as Box<dyn FnMut(&mut Rig)>`
                let wanted = to.called_as().is_some().then_some(&to);
                self.expr(*value, wanted);
                to
            }
            ExprKind::Try(inner) => {
                // `let bank: Vec<_> = ….collect::<Result<_, _>>()?;`
                let is_collected =
                    matches!(&body.expr(*inner).kind, ExprKind::MethodCall { method, .. } if method == "collect");
                let wanted = expected.filter(|_| is_collected).cloned();
                let failure = self.variables.fresh();
                let wanted = wanted.map(|wanted| Ty::std("std::result::Result", vec![wanted, failure]));
                let ty = self.expr(*inner, wanted.as_ref());
                self.payload(&ty)
            }
            ExprKind::Await(inner) => {
                let ty = self.expr(*inner, expected);
                self.awaited_ty(*inner, &ty)
            }
            ExprKind::Macro(macro_expr) => self.macro_expr(macro_expr),
            ExprKind::Opaque(_) | ExprKind::Unknown { .. } => Ty::Unknown,
        }
    }

    /// The type of two branches that meet.
    fn either(&mut self, left: &Ty, right: &Ty) -> Ty {
        match (self.variables.shallow(left), self.variables.shallow(right)) {
            (Ty::Never, other) | (other, Ty::Never) => other,
            (Ty::Unknown, other) => other,
            // One function or closure or another: what is called is not known by the type.
            (left @ (Ty::FunctionItem(_) | Ty::Closure(_)), right @ (Ty::FunctionItem(_) | Ty::Closure(_)))
                if left != right =>
            {
                Ty::Function(Vec::new(), Box::new(Ty::Unknown))
            }
            (left, right) => {
                self.variables.unify(&left, &right);
                left
            }
        }
    }

    pub(super) fn block(&mut self, block: &Block, expected: Option<&Ty>) -> Ty {
        let mut diverges = false;
        for stmt in &block.stmts {
            match &stmt.kind {
                StmtKind::Let { pat, ty, init, otherwise } => {
                    self.let_stmt(*pat, ty.as_ref(), *init);
                    if let Some(otherwise) = otherwise {
                        self.expr(*otherwise, None);
                    }
                }
                StmtKind::Expr { expr, .. } => diverges |= self.expr(*expr, None) == Ty::Never,
            }
        }
        match block.tail {
            Some(tail) => self.expr(tail, expected),
            None if diverges => Ty::Never,
            None => Ty::unit(),
        }
    }

    fn let_stmt(&mut self, pat: crate::syntax::tree::PatId, ty: Option<&TypeRef>, init: Option<ExprId>) {
        let declared = match ty {
            Some(ty) => self.annotation(ty),
            None => self.variables.fresh(),
        };
        if let Some(init) = init {
            let found = self.expr(init, Some(&declared));
            self.variables.unify(&declared, &found);
        }
        // A pattern that was bound in the first pass keeps its variables.
        let declared = if ty.is_none() && matches!(self.body.pat(pat).kind, PatKind::Bind { .. }) {
            declared
        } else {
            self.variables.shallow(&declared)
        };
        self.pat(pat, &declared, None);
    }

    /// A written type whose missing parts are to be inferred.
    pub(super) fn annotation(&mut self, ty: &TypeRef) -> Ty {
        let lowered = self.index.lower(ty, &self.scope);
        self.open(&lowered)
    }

    /// The type with variables in place of what is unknown.
    pub(super) fn open(&mut self, ty: &Ty) -> Ty {
        match ty {
            Ty::Unknown => self.variables.fresh(),
            Ty::Adt(id, args) => Ty::Adt(*id, args.iter().map(|arg| self.open(arg)).collect()),
            Ty::External(path, args) => Ty::External(path.clone(), args.iter().map(|arg| self.open(arg)).collect()),
            Ty::Ref(mutable, inner) => Ty::Ref(*mutable, Box::new(self.open(inner))),
            Ty::Tuple(parts) => Ty::Tuple(parts.iter().map(|part| self.open(part)).collect()),
            Ty::Array(inner, length) => Ty::Array(Box::new(self.open(inner)), length.clone()),
            Ty::Slice(inner) => Ty::Slice(Box::new(self.open(inner))),
            other => other.clone(),
        }
    }

    fn struct_expr(
        &mut self,
        id: ExprId,
        path: &Path,
        fields: &[(String, ExprId)],
        rest: Option<ExprId>,
        expected: Option<&Ty>,
    ) -> Ty {
        let def = self.path_def(path);
        let (own, variant) = match &def {
            Some(Def::Variant(id, at)) => (Some(*id), Some(*at)),
            Some(Def::Type(id)) => (Some(*id), None),
            Some(Def::Alias(_)) => {
                let lowered = self.index.lower(&TypeRef::Path(path.clone()), &self.scope);
                match lowered {
                    Ty::Adt(id, _) => (Some(id), None),
                    _ => (None, None),
                }
            }
            _ => (None, None),
        };
        if let Some(def) = def {
            self.typed.expr_def.insert(id, def);
        }
        let ty = match own {
            Some(own) => {
                let params = self.index.type_def(own).generics.params.len();
                let args = (0..params).map(|_| self.variables.fresh()).collect();
                Ty::Adt(own, args)
            }
            None => Ty::Unknown,
        };
        if path.segments.last().is_some_and(|last| !last.args.is_empty()) {
            // `Axis::<Fast> { … }`
            let written = self.index.lower(&TypeRef::Path(path.clone()), &self.scope);
            self.variables.unify(&ty, &written);
        }
        if let Some(expected) = expected {
            self.variables.unify(&ty, expected);
        }
        for (name, value) in fields {
            let field = self.index.field_ty(&ty, variant, name);
            let found = self.expr(*value, field.as_ref());
            if let Some(field) = field {
                self.variables.unify(&field, &found);
            }
        }
        if let Some(rest) = rest {
            self.expr(rest, Some(&ty));
        }
        ty
    }

    /// The type of a field, behind references and pointers.
    pub(super) fn field(&mut self, base: &Ty, name: &str) -> Ty {
        let mut ty = self.variables.shallow(base);
        for _ in 0..8 {
            match &ty {
                Ty::Ref(_, inner) | Ty::Pointer(inner) => ty = self.variables.shallow(&inner.clone()),
                Ty::Tuple(parts) => {
                    return name.parse::<usize>().ok().and_then(|at| parts.get(at)).cloned().unwrap_or(Ty::Unknown);
                }
                Ty::Adt(..) => {
                    if let Some(field) = self.index.field_ty(&ty, None, name) {
                        return field;
                    }
                    match self.user_deref(&ty) {
                        Some((target, _)) => ty = target,
                        None => return Ty::Unknown,
                    }
                }
                Ty::External(path, args)
                    if builtin::is_pointer(path.rsplit("::").next().unwrap_or("")) && !args.is_empty() =>
                {
                    ty = self.variables.shallow(&args[0].clone());
                }
                _ => return Ty::Unknown,
            }
        }
        Ty::Unknown
    }

    fn deref(&mut self, ty: &Ty) -> Ty {
        match self.variables.shallow(ty) {
            Ty::Ref(_, inner) | Ty::Pointer(inner) => self.variables.shallow(&inner),
            Ty::External(path, args)
                if builtin::is_pointer(path.rsplit("::").next().unwrap_or("")) && !args.is_empty() =>
            {
                // `**guard` is written for a lock's guard, `*guard` gives the content; both are the content here.
                self.variables.shallow(args[0].peel())
            }
            other => match self.user_deref(&other) {
                Some((target, _)) => target,
                None => other,
            },
        }
    }

    fn payload(&self, ty: &Ty) -> Ty {
        match self.variables.shallow(ty) {
            // What makes a filter may have given a `Result` of it.
            filter @ Ty::External(..) if self.index.law_spec(&filter).is_some() => filter,
            Ty::External(_, args) if !args.is_empty() => self.variables.shallow(&args[0]),
            open if self.variables.origin(&open).is_some() => open,
            _ => Ty::Unknown,
        }
    }

    fn binary(&mut self, op: &str, lhs: ExprId, rhs: ExprId) -> Ty {
        let left = self.expr(lhs, None);
        let right = self.expr(rhs, None);
        match op {
            "&&" | "||" | "==" | "!=" | "<" | "<=" | ">" | ">=" => Ty::Bool,
            _ => {
                let left = self.variables.shallow(&left).peel().clone();
                if matches!(left, Ty::Int | Ty::Float | Ty::Var(_)) { left } else { self.arithmetic(&left, &right) }
            }
        }
    }

    fn arithmetic(&self, left: &Ty, right: &Ty) -> Ty {
        match (left, self.variables.shallow(right)) {
            (Ty::Unknown, right @ (Ty::Int | Ty::Float)) => right,
            _ => Ty::Unknown,
        }
    }

    /// The type of the items that a `for` loop takes from a value.
    pub(super) fn item_ty(&self, ty: &Ty) -> Ty {
        let ty = self.shallow_deep(ty);
        match builtin::item_of(&ty, false) {
            Some(item) => self.variables.shallow(&item),
            None if self.index.own_into_iter(&ty).is_some() => self.index.project(&ty, "Item"),
            None => Ty::Unknown,
        }
    }

    /// The type with variables replaced as far as the outer two levels need it.
    pub(super) fn shallow_deep(&self, ty: &Ty) -> Ty {
        match self.variables.shallow(ty) {
            Ty::Ref(mutable, inner) => Ty::Ref(mutable, Box::new(self.shallow_deep(&inner))),
            Ty::External(path, args) => {
                Ty::External(path, args.iter().map(|arg| self.variables.shallow(arg)).collect())
            }
            Ty::Tuple(parts) => Ty::Tuple(parts.iter().map(|part| self.shallow_deep(part)).collect()),
            other => other,
        }
    }

    fn const_of(&self, id: ExprId) -> Option<u64> {
        match &self.body.expr(id).kind {
            ExprKind::Literal(Literal::Int(value, _)) => *value,
            ExprKind::Path(path) => {
                let names: Vec<String> = path.segments.iter().map(|segment| segment.name.clone()).collect();
                self.index.const_value(&self.scope, &names)
            }
            _ => None,
        }
    }

    /// The target of a `Deref` impl of the analysed code, and the function that leads there.
    pub(super) fn user_deref(&self, ty: &Ty) -> Option<(Ty, crate::index::FunctionId)> {
        let mut found = None;
        let mut target = None;
        for id in self.index.impls_of(ty) {
            let def = self.index.impl_def(id);
            let Some(name) = &def.implements else { continue };
            match self.index.trait_text(name).as_str() {
                "DerefMut" => found = def.methods.get("deref_mut").copied(),
                "Deref" => {
                    if found.is_none() {
                        found = def.methods.get("deref").copied();
                    }
                    let scope = self.owner_scope(def.module, crate::index::Owner::Impl(id));
                    target = def
                        .types
                        .get("Target")
                        .map(|written| self.index.lower(written, &scope).substitute(&self.index.impl_args(id, ty)));
                }
                _ => {}
            }
        }
        Some((target?, found?))
    }

    fn macro_expr(&mut self, macro_expr: &MacroExpr) -> Ty {
        match &macro_expr.kind {
            MacroKind::All(operands) => {
                let mut last = Ty::Unknown;
                for operand in operands {
                    last = self.expr(*operand, None);
                }
                let name = macro_expr.path.rsplit("::").next().unwrap_or("");
                match name {
                    "format" => Ty::std("std::string::String", Vec::new()),
                    "dbg" | "block" | "pin" | "unwrap" | "expect" => last,
                    _ => Ty::Unknown,
                }
            }
            MacroKind::Diverges(operands) | MacroKind::ReturnsErr(operands) => {
                for operand in operands {
                    self.expr(*operand, None);
                }
                Ty::Never
            }
            MacroKind::DebugBuild | MacroKind::Build(_) => Ty::Bool,
            MacroKind::DebugOnly(operands, message) => {
                for operand in operands.iter().chain(message) {
                    self.expr(*operand, None);
                }
                Ty::unit()
            }
            MacroKind::Logging(operands) => {
                for operand in operands {
                    self.expr(*operand, None);
                }
                Ty::unit()
            }
            MacroKind::Assert(condition, message) | MacroKind::Ensure(condition, message) => {
                self.expr(*condition, Some(&Ty::Bool));
                for operand in message {
                    self.expr(*operand, None);
                }
                Ty::unit()
            }
            MacroKind::AssertCompare(left, right, message) => {
                for operand in [left, right].into_iter().chain(message) {
                    self.expr(*operand, None);
                }
                Ty::unit()
            }
            MacroKind::Join { operands, .. } => {
                Ty::Tuple(operands.iter().map(|operand| self.expr(*operand, None)).collect())
            }
            MacroKind::Select(arms) => {
                let mut result = Ty::Never;
                for arm in arms {
                    let found = self.in_scope(|this| {
                        let value = arm.future.map_or(Ty::Unknown, |future| this.expr(future, None));
                        if let Some(pat) = arm.pat {
                            this.pat(pat, &value, None);
                        }
                        if let Some(condition) = arm.condition {
                            this.expr(condition, Some(&Ty::Bool));
                        }
                        this.expr(arm.body, None)
                    });
                    result = self.either(&result, &found);
                }
                result
            }
            MacroKind::Ceid { token, filters, names } => {
                if let Some(token) = token {
                    self.expr(*token, None);
                }
                for (_, place) in filters {
                    self.expr(*place, None);
                }
                // What is fed under its new name is fed to the filter.
                for (name, place) in names {
                    let ty = self.variables.shallow(self.typed.expr_ty[place.0 as usize].peel());
                    // What ceid-core wraps is another type under its name, and the guard's own update is enough to know of it.
                    let each = self.variables.shallow(ty.element().unwrap_or(&ty));
                    if self.is_adapted(&each) || !self.is_of_core(&each) {
                        self.pat(*name, &Ty::Ref(true, Box::new(ty)), None);
                    }
                }
                Ty::unit()
            }
            MacroKind::EachCycle { names, control, body } => {
                let control_ty = self.expr(*control, None);
                let set = match self.variables.shallow(control_ty.peel()) {
                    Ty::Adt(_, args) | Ty::External(_, args) => args.first().cloned().unwrap_or(Ty::Unknown),
                    _ => Ty::Unknown,
                };
                self.in_scope(|this| {
                    for (number, name) in names.iter().enumerate() {
                        let ty = if number == 0 { Ty::Ref(true, Box::new(set.clone())) } else { Ty::Unknown };
                        this.pat(*name, &ty, None);
                    }
                    this.expr(*body, None);
                });
                Ty::unit()
            }
        }
    }

    /// The number of fields of a tuple struct or variant.
    pub(super) fn field_count(&self, def: &Def) -> usize {
        match def {
            Def::Variant(id, at) => match &self.index.type_def(*id).shape {
                Shape::Enum(variants) => variants[*at].fields.fields.len(),
                Shape::Struct(_) => 0,
            },
            Def::Type(id) => match &self.index.type_def(*id).shape {
                Shape::Struct(fields) => fields.fields.len(),
                Shape::Enum(_) => 0,
            },
            _ => 0,
        }
    }
}

fn literal_ty(literal: &Literal) -> Ty {
    match literal {
        Literal::Int(_, suffix) if suffix.starts_with('f') => Ty::Float,
        Literal::Int(..) => Ty::Int,
        Literal::Float(_) => Ty::Float,
        Literal::Bool(_) => Ty::Bool,
        Literal::Str(_) => Ty::Ref(false, Box::new(Ty::Str)),
        Literal::Char(_) => Ty::Char,
        Literal::Bytes(_) => Ty::Unknown,
    }
}

fn sequence_ty(item: Ty, is_vec: bool, value: Option<u64>, text: String) -> Ty {
    if is_vec {
        Ty::std("std::vec::Vec", vec![item])
    } else {
        Ty::Array(Box::new(item), crate::index::Length { value, text })
    }
}
