//! What conditions are about: pure expressions in one spelling, so that branches on the same value are told to be so.

use super::Builder;
use crate::flow::test::MAX_HEADS;
use crate::flow::{About, Effect, Head, NodeId, Place, Subject, SubjectId, Test, Var};
use crate::index::{Def, Shape, Ty};
use crate::source::Span;
use crate::syntax::tree::{CfgKey, ExprId, ExprKind, Path, StmtKind, TypeRef};
use crate::types::Callee;

/// A pure expression: its spelling with variables by number, and the places it reads.
#[derive(Clone, Debug, Default)]
pub(super) struct Pure {
    pub(super) key: String,
    pub(super) reads: Vec<Place>,
    pub(super) whole: Option<Place>,
}

/// The field that a getter gives a value of.
pub(super) struct FieldGiven {
    /// The steps to it, from `self` on.
    pub(super) names: Vec<String>,
    /// Whether it is cloned there.
    pub(super) is_cloned: bool,
}

impl Builder<'_> {
    /// The subject with that key; made when it is new.
    pub(super) fn subject(&mut self, pure: Pure, total: Option<Vec<Head>>) -> SubjectId {
        if let Some(id) = self.subjects.get(&pure.key) {
            return *id;
        }
        let id = SubjectId(u32::try_from(self.graph.subjects.len()).expect("fewer than 2^32 subjects"));
        let heads = Vec::new();
        let subject = Subject { key: pure.key.clone(), reads: pure.reads, whole: pure.whole, heads, total };
        self.graph.subjects.push(subject);
        self.subjects.insert(pure.key, id);
        id
    }

    /// A subject that has all heads of an expression's type.
    pub(super) fn state_subject(&mut self, pure: Pure, like: ExprId) {
        let total = self.total_heads(self.ty(like));
        let id = self.subject(pure, total.clone());
        for head in total.iter().flatten() {
            self.head_bit(id, head);
        }
    }

    /// The bit of a head of a subject; heads beyond the limit share one.
    pub(super) fn head_bit(&mut self, id: SubjectId, head: &str) -> Option<u32> {
        let subject = &mut self.graph.subjects[id.0 as usize];
        if let Some(at) = subject.heads.iter().position(|known| known == head) {
            return Some(1 << at);
        }
        if subject.heads.len() >= MAX_HEADS {
            return None;
        }
        subject.heads.push(head.to_owned());
        Some(1 << (subject.heads.len() - 1))
    }

    /// Adds a branch; answers the nodes behind 'it holds' and 'it does not'.
    pub(super) fn branch(&mut self, mut test: Test) -> (NodeId, NodeId) {
        if let Some((span, text)) = &self.spoken {
            test.span = *span;
            test.text.clone_from(text);
        }
        let span = test.span;
        let branch = self.emit(Effect::Branch(test), span);
        let yes = self.add_node(Effect::Nothing, span);
        let no = self.add_node(Effect::Nothing, span);
        self.link(branch, yes);
        self.link(branch, no);
        self.at = None;
        (yes, no)
    }

    /// A branch whose answer is not correlated with anything.
    pub(super) fn opaque_branch(&mut self, span: Span, text: String, about: About) -> (NodeId, NodeId) {
        self.branch(Test { subject: None, holds: u32::MAX, fails: u32::MAX, span, text, about })
    }

    /// A branch that asks whether the subject has one of these heads. `exact` if nothing else is asked.
    pub(super) fn branch_on_subject(
        &mut self,
        id: SubjectId,
        heads: &[Head],
        exact: bool,
        span: Span,
        text: String,
        mut about: About,
    ) -> (NodeId, NodeId) {
        about.heads = heads.to_vec();
        let mut holds = 0;
        for head in heads {
            match self.head_bit(id, head) {
                Some(bit) => holds |= bit,
                None => return self.opaque_branch(span, text, about),
            }
        }
        let fails = if exact { !holds } else { u32::MAX };
        self.branch(Test { subject: Some(id), holds, fails, span, text, about })
    }

    /// A branch on whether a counter has one of these numbers.
    pub(super) fn branch_on_number(
        &mut self,
        counter: Var,
        numbers: &[Head],
        span: Span,
        text: String,
        about: About,
    ) -> (NodeId, NodeId) {
        let pure = self.pure_var(counter);
        let id = self.subject(pure, None);
        let bits: Option<Vec<u32>> = numbers.iter().map(|number| self.head_bit(id, number)).collect();
        match bits {
            Some(bits) => {
                let holds = bits.into_iter().fold(0, |all, bit| all | bit);
                self.branch(Test { subject: Some(id), holds, fails: !holds, span, text, about })
            }
            None => self.opaque_branch(span, text, about),
        }
    }

    /// A branch on the head of a value: `+` against `-` for options and results.
    pub(super) fn branch_on_head(
        &mut self,
        value: &super::Value,
        head: &str,
        other: &str,
        span: Span,
        text: String,
        about: About,
    ) -> (NodeId, NodeId) {
        match value.same_as {
            Some(var) => {
                let pure = self.pure_var(var);
                let total = Some(vec![head.to_owned(), other.to_owned()]);
                let id = self.subject(pure, total);
                self.head_bit(id, other);
                self.branch_on_subject(id, &[head.to_owned()], true, span, text, about)
            }
            None => self.opaque_branch(span, text, about),
        }
    }

    pub(super) fn pure_var(&self, var: Var) -> Pure {
        pure_place(Place::var(var))
    }

    pub(super) fn branch_on_cfg(&mut self, key: &CfgKey, span: Span) -> (NodeId, NodeId) {
        if key.is_debug_only() {
            return self.debug_branch(span, format!("#[cfg({})]", key.key));
        }
        let pure = Pure { key: format!("#[cfg({})]", key.key), ..Pure::default() };
        let id = self.subject(pure, Some(vec!["true".to_owned(), "false".to_owned()]));
        self.head_bit(id, "true");
        self.head_bit(id, "false");
        let head = if key.negated { "false" } else { "true" };
        let about = About { is_constant: true, is_turned: key.negated, ..About::default() };
        self.branch_on_subject(id, &[head.to_owned()], true, span, format!("#[cfg({})]", key.key), about)
    }

    /// The expression in one spelling, if it is pure: it reads places, and gives the same as long as they are not written.
    pub(super) fn pure(&mut self, id: ExprId) -> Option<Pure> {
        let body = self.body();
        match &body.expr(id).kind {
            ExprKind::Path(path) => self.pure_path(id, path),
            ExprKind::Literal(literal) => Some(Pure { key: literal.spelling(), ..Pure::default() }),
            ExprKind::Field { .. } | ExprKind::Index { .. } => {
                let Some(place) = self.static_place(id) else { return self.entry_of_constant(id) };
                let mut found = pure_place(place);
                // Another number is another element.
                let mut at = id;
                while let ExprKind::Field { base, .. } | ExprKind::Index { base, .. } = &body.expr(at).kind {
                    if let ExprKind::Index { index, .. } = &body.expr(at).kind {
                        found.reads.extend(self.pure(*index)?.reads);
                    }
                    at = *base;
                }
                Some(found)
            }
            ExprKind::Deref(inner) | ExprKind::Reference { value: inner, raw: false, .. } => self.pure(*inner),
            ExprKind::Cast { value, .. } if self.keeps_value(id) => self.pure(*value),
            // Another value, which is the same as long as that one is.
            ExprKind::Cast { value, ty } => {
                let from = self.pure(*value)?;
                Some(Pure { key: format!("({} as {ty:?})", from.key), reads: from.reads, whole: None })
            }
            ExprKind::Not(inner) => self.pure_unary("!", *inner),
            ExprKind::Negate(inner) => self.pure_unary("-", *inner),
            ExprKind::Binary { op, lhs, rhs } => {
                let left = self.pure(*lhs)?;
                let right = self.pure(*rhs)?;
                let mut reads = left.reads;
                reads.extend(right.reads);
                Some(Pure { key: format!("({} {op} {})", left.key, right.key), reads, whole: None })
            }
            // Lending what may be there asks about the same.
            ExprKind::MethodCall { receiver, method, .. }
                if lends_payload(method) && self.is_optional(*receiver)
                    || matches!(method.as_str(), "as_mut_slice" | "as_slice") =>
            {
                self.pure(*receiver)
            }
            ExprKind::MethodCall { receiver, method, args, .. } => {
                if let Some(place) = self.state_behind(id) {
                    return Some(pure_place(place));
                }
                if !self.is_pure_method(id, method) {
                    return None;
                }
                let base = self.pure(*receiver)?;
                let mut key = format!("{}.{method}(", base.key);
                let mut reads = base.reads;
                for arg in args {
                    let arg = self.pure(*arg)?;
                    key.push_str(&arg.key);
                    key.push(',');
                    reads.extend(arg.reads);
                }
                key.push(')');
                Some(Pure { key, reads, whole: None })
            }
            // What is made of pure parts is another value only where they are.
            ExprKind::Call { callee, args }
                if matches!(self.typed().callees.get(&id), Some(Callee::Constructor(_))) =>
            {
                let ExprKind::Path(path) = &body.expr(*callee).kind else { return None };
                let mut made = Pure { key: format!("{}(", path.last()), ..Pure::default() };
                for arg in args {
                    let arg = self.pure(*arg)?;
                    made.key.push_str(&arg.key);
                    made.key.push(',');
                    made.reads.extend(arg.reads);
                }
                made.key.push(')');
                Some(made)
            }
            _ => None,
        }
    }

    /// The place of the state that a getter gives: `self.mode()`.
    pub(super) fn state_behind(&mut self, id: ExprId) -> Option<Place> {
        let body = self.body();
        let ExprKind::MethodCall { receiver, args, .. } = &body.expr(id).kind else { return None };
        if !args.is_empty() || !self.is_state(self.ty(id)) || matches!(self.ty(id), Ty::Ref(..)) {
            return None;
        }
        let names = self.field_given(id)?.names;
        let place = self.static_place(*receiver)?;
        Some(names.iter().fold(place, |place, name| place.field(name)))
    }

    /// The field that a getter gives, if it does nothing else: `fn mode(&self) -> Mode { self.state.mode }`.
    pub(super) fn field_given(&self, id: ExprId) -> Option<FieldGiven> {
        let target = self.only_target(id)?;
        let getter = self.program.index.function(target).function.body.as_ref()?;
        let typed = self.program.typed(target)?;
        let [param] = getter.params.as_slice() else { return None };
        let owner = typed.pat_local.get(param)?;
        let mut at = getter.root;
        let mut names: Vec<String> = Vec::new();
        let mut is_cloned = false;
        loop {
            match &getter.expr(at).kind {
                ExprKind::Block(block) if block.stmts.is_empty() => at = block.tail?,
                ExprKind::MethodCall { receiver, method, args, .. } if method == "clone" && args.is_empty() => {
                    is_cloned = true;
                    at = *receiver;
                }
                ExprKind::Field { base, name } => {
                    names.push(name.clone());
                    at = *base;
                }
                ExprKind::Path(_) if typed.expr_local.get(&at) == Some(owner) && !names.is_empty() => break,
                _ => return None,
            }
        }
        names.reverse();
        Some(FieldGiven { names, is_cloned })
    }

    /// Whether a cast gives the value that it gets: `true as u8` is no `true`, and `300 as u8` no 300.
    pub(super) fn keeps_value(&self, id: ExprId) -> bool {
        let ExprKind::Cast { value, ty } = &self.body().expr(id).kind else { return true };
        let is_number = matches!(self.ty(id).peel(), Ty::Int | Ty::Float);
        match self.ty(*value).peel() {
            Ty::Bool | Ty::Char | Ty::Float => false,
            // No number of another type is too big for one of these.
            Ty::Int => {
                let is_wide = |name: &str| matches!(name, "u64" | "i64" | "u128" | "i128" | "usize" | "isize");
                matches!(ty, TypeRef::Path(path) if is_wide(path.last()))
            }
            _ => !is_number,
        }
    }

    fn pure_unary(&mut self, op: &str, inner: ExprId) -> Option<Pure> {
        let inner = self.pure(inner)?;
        Some(Pure { key: format!("{op}{}", inner.key), reads: inner.reads, whole: None })
    }

    fn pure_path(&mut self, id: ExprId, path: &Path) -> Option<Pure> {
        if let Some(place) = self.stand_in(id) {
            return Some(pure_place(place));
        }
        if let Some(local) = self.typed().expr_local.get(&id).copied() {
            let var = self.var_of(local);
            return Some(self.pure_var(var));
        }
        match self.typed().expr_def.get(&id) {
            Some(Def::Value(value)) => {
                let item = &self.program.index.value(*value).item;
                // A static may be changed by someone else, unless it holds nothing but a value.
                let is_fixed = !item.is_static || (!item.is_mutable && self.is_plain_value(self.ty(id)));
                is_fixed.then(|| Pure { key: path.text(), ..Pure::default() })
            }
            Some(Def::Variant(..) | Def::External(_) | Def::Type(_)) => {
                Some(Pure { key: path.text(), ..Pure::default() })
            }
            None if path.ident().is_some_and(|name| self.is_const_parameter(name)) => {
                Some(Pure { key: path.text(), ..Pure::default() })
            }
            // `P::HAS_INERTIA`, whatever `P` is.
            None if path.segments.len() > 1 && is_constant_name(path.last()) => {
                Some(Pure { key: path.text(), ..Pure::default() })
            }
            _ => None,
        }
    }

    fn is_plain_value(&self, ty: &Ty) -> bool {
        matches!(ty, Ty::Bool | Ty::Int | Ty::Float | Ty::Char | Ty::Str)
    }

    /// Whether a name is a constant parameter of the function at hand, or of its impl.
    fn is_const_parameter(&self, name: &str) -> bool {
        let index = self.program.index;
        let def = index.function(self.frames[self.frame].function);
        let of_impl = match def.owner {
            crate::index::Owner::Impl(id) => index.impl_def(id).generics.params.as_slice(),
            _ => &[],
        };
        def.function.generics.params.iter().chain(of_impl).any(|param| param.is_const && param.name == name)
    }

    /// Methods that read a value and nothing else.
    fn is_pure_method(&self, id: ExprId, method: &str) -> bool {
        let known = matches!(
            method,
            "is_some"
                | "is_none"
                | "is_ok"
                | "is_err"
                | "is_empty"
                | "len"
                | "abs"
                | "is_nan"
                | "is_finite"
                | "as_ref"
                | "is_positive"
                | "is_negative"
                | "min"
                | "max"
                | "is_multiple_of"
                | "as_deref"
                | "signum"
                | "get"
                | "clone"
                | "to_owned"
                | "is_sign_negative"
                | "is_sign_positive"
                | "rem_euclid"
                | "contains"
                | "contains_key"
                | "is_infinite"
                | "first_mut"
                | "last_mut"
                | "split_first_mut"
                | "split_last_mut"
        );
        match self.typed().callees.get(&id) {
            Some(Callee::Builtin) => known,
            Some(Callee::Resolved(resolved)) => match resolved.targets.as_slice() {
                [target] => self.is_pure_function(*target, 0),
                _ => false,
            },
            _ => known && method != "get",
        }
    }

    /// Whether a function takes `&self` and only reads fields: all that its body is made of is pure.
    pub(super) fn is_pure_function(&self, id: crate::index::FunctionId, depth: u32) -> bool {
        let def = self.program.index.function(id);
        use crate::syntax::tree::Receiver;
        if depth > 3 || !matches!(def.function.receiver, Some(Receiver::Shared | Receiver::Value)) {
            return false;
        }
        let (Some(body), Some(typed)) = (&def.function.body, self.program.typed(id)) else { return false };
        body.exprs.iter().enumerate().all(|(number, expr)| match &expr.kind {
            ExprKind::Path(_)
            | ExprKind::Literal(_)
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
            | ExprKind::Reference { mutable: false, .. } => true,
            ExprKind::Block(block) => {
                block.stmts.iter().all(|stmt| matches!(stmt.kind, StmtKind::Let { .. } | StmtKind::Expr { .. }))
            }
            ExprKind::MethodCall { method, .. } => {
                let id = ExprId(u32::try_from(number).unwrap_or(u32::MAX));
                match typed.callees.get(&id) {
                    Some(Callee::Resolved(resolved)) => match resolved.targets.as_slice() {
                        [target] => self.is_pure_function(*target, depth + 1),
                        _ => false,
                    },
                    Some(Callee::Builtin) => {
                        matches!(
                            method.as_str(),
                            "is_some" | "is_none" | "is_ok" | "is_err" | "abs" | "is_empty" | "len"
                        )
                    }
                    _ => false,
                }
            }
            _ => false,
        })
    }

    /// The head of a constant expression: a literal, a variant, a constant.
    pub(super) fn constant_head(&self, id: ExprId) -> Option<Head> {
        self.constants().head(id)
    }

    /// All heads that a value of the type can have.
    pub(super) fn total_heads(&self, ty: &Ty) -> Option<Vec<Head>> {
        match ty.peel() {
            Ty::Bool => Some(vec!["true".to_owned(), "false".to_owned()]),
            Ty::Adt(id, _) => match &self.program.index.type_def(*id).shape {
                Shape::Enum(variants) => Some(variants.iter().map(|variant| variant.name.clone()).collect()),
                Shape::Struct(_) => None,
            },
            Ty::External(path, _)
                if path.ends_with("::Option") || path.ends_with("::Result") || path.ends_with("::LockResult") =>
            {
                Some(vec!["+".to_owned(), "-".to_owned()])
            }
            _ => None,
        }
    }
}

/// The head of a constructor outside the analysed code.
pub(super) fn external_head(path: &str) -> Head {
    match path.rsplit("::").next().unwrap_or(path) {
        // `Ready` ends a future as `None` ends an iterator.
        "Some" | "Ok" | "Pending" => "+".to_owned(),
        "None" | "Err" | "Ready" => "-".to_owned(),
        name => name.to_owned(),
    }
}

/// Whether a name is written as constants are.
fn is_constant_name(name: &str) -> bool {
    name.chars().all(|letter| letter.is_ascii_uppercase() || letter.is_ascii_digit() || letter == '_')
}

/// The value of a place.
pub(super) fn pure_place(place: Place) -> Pure {
    Pure { key: place_key(&place), reads: vec![place.clone()], whole: Some(place) }
}

/// The spelling of a place that tells subjects apart.
pub(super) fn place_key(place: &Place) -> String {
    if place.steps.is_empty()
        && let Some(var) = place.base_var()
    {
        return format!("v{}", var.0);
    }
    place.spell(&|var| format!("v{}", var.0), &|id| format!("s{}", id.0))
}

/// Whether a method of an option lends what is in it.
pub(super) fn lends_payload(method: &str) -> bool {
    matches!(method, "as_mut" | "as_ref" | "as_deref_mut" | "as_deref")
}
