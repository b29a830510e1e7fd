//! Expressions that read places and do nothing else, in one spelling: they give the same as long as the places are not written.

use super::Builder;
use super::reading::{chooses, computes, only_reads};
use super::subjects::{Pure, lends_payload, place_key, pure_place};
use crate::flow::Place;
use crate::flow::asked::OF_FUNCTION;
use crate::index::{Def, FunctionId, Ty};
use crate::syntax::tree::{Closure, ExprId, ExprKind, Path, TypeRef};
use crate::types::{Callee, LocalId};

/// The field that a getter gives a value of.
pub(super) struct FieldGiven {
    /// The steps to it, from `self` on.
    pub(super) names: Vec<String>,
    /// Whether it is cloned there.
    pub(super) is_cloned: bool,
}

impl Builder<'_> {
    /// The expression in one spelling, if it is pure: it reads places, and gives the same as long as they are not written.
    pub(super) fn pure(&mut self, id: ExprId) -> Option<Pure> {
        let body = self.body();
        match &body.expr(id).kind {
            ExprKind::Path(path) => self.pure_path(id, path),
            ExprKind::Literal(literal) => Some(Pure { key: literal.spelling(), ..Pure::default() }),
            ExprKind::Field { base, name } if self.names_inner(id) => {
                let base = self.pure(*base)?;
                Some(Pure { key: format!("{}.{name}", base.key), reads: base.reads, ..Pure::default() })
            }
            ExprKind::Field { .. } | ExprKind::Index { .. } if let Some(found) = self.pure_setting(id) => Some(found),
            ExprKind::Field { .. } | ExprKind::Index { .. } => {
                let place = if self.names_inner(id) { None } else { self.static_place(id) };
                let Some(place) = place else { return self.pure_entry(id).or_else(|| self.pure_borrowed(id)) };
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
            ExprKind::Deref(inner) if let Some(place) = self.state_in_cell(id) => {
                if self.names_inner(*inner) {
                    None
                } else {
                    Some(pure_place(place))
                }
            }
            ExprKind::Deref(inner) | ExprKind::Reference { value: inner, raw: false, .. } => self.pure(*inner),
            ExprKind::Cast { value, .. } if self.keeps_value(id) => self.pure(*value),
            // Another value, which is the same as long as that one is.
            ExprKind::Cast { value, ty } => {
                let from = self.pure(*value)?;
                Some(Pure { key: format!("({} as {ty:?})", from.key), reads: from.reads, ..Pure::default() })
            }
            ExprKind::Range { start, end, inclusive } => {
                let mut range = Pure { key: if *inclusive { "..=" } else { ".." }.to_owned(), ..Pure::default() };
                for (number, bound) in [start, end].into_iter().enumerate() {
                    let Some(bound) = bound else { continue };
                    let bound = self.pure(*bound)?;
                    range.key.insert_str(if number == 0 { 0 } else { range.key.len() }, &bound.key);
                    range.reads.extend(bound.reads);
                }
                Some(range)
            }
            ExprKind::Not(inner) => self.pure_unary("!", *inner),
            ExprKind::Negate(inner) => self.pure_unary("-", *inner),
            ExprKind::Binary { op, lhs, rhs } => {
                let left = self.pure(*lhs)?;
                let right = self.pure(*rhs)?;
                let mut reads = left.reads;
                reads.extend(right.reads);
                Some(Pure { key: format!("({} {op} {})", left.key, right.key), reads, ..Pure::default() })
            }
            // Lending what may be there asks about the same.
            ExprKind::MethodCall { receiver, method, .. }
                if lends_payload(method) && self.is_optional(*receiver)
                    || matches!(method.as_str(), "as_mut_slice" | "as_slice") =>
            {
                self.pure(*receiver)
            }
            // What is made once is the same from then on.
            ExprKind::MethodCall { receiver, method, .. }
                if matches!(method.as_str(), "get" | "get_or_init")
                    && self.is_made_once(*receiver, &["OnceLock", "OnceCell"]) =>
            {
                let place = self.static_place(*receiver)?;
                let filled = (method == "get" && self.may_be_filled(*receiver)).then(|| place.clone());
                let is_read = filled.is_some() || place.base_var().is_some();
                let key = format!("{}.{method}()", place_key(&place));
                Some(Pure { key, reads: is_read.then_some(place).into_iter().collect(), filled, whole: None })
            }
            ExprKind::MethodCall { receiver, method, args, .. }
                if args.is_empty()
                    && matches!(method.as_str(), "get" | "borrow")
                    && self.is_cell_of_static(*receiver) =>
            {
                None
            }
            ExprKind::MethodCall { receiver, method, turbofish, args, .. } => {
                if !self.names_inner(*receiver)
                    && let Some(place) = self.state_behind(id).or_else(|| self.state_in_cell(id))
                {
                    return Some(pure_place(place));
                }
                if !only_reads(self.constants(), id, 0) {
                    return None;
                }
                let base = self.pure(*receiver)?;
                let base = if matches!(method.as_str(), "unwrap" | "expect") { base.found_there() } else { base };
                let of = if turbofish.is_empty() { String::new() } else { format!("{turbofish:?}") };
                let reads = self.read_by_method(id, &base).unwrap_or(base.reads);
                self.pure_parts(format!("{}.{method}{of}(", base.key), reads, args)
            }
            // What is made of pure parts is another value only where they are.
            ExprKind::Call { callee, args }
                if matches!(self.typed().callees.get(&id), Some(Callee::Constructor(_))) =>
            {
                let ExprKind::Path(path) = &body.expr(*callee).kind else { return None };
                self.pure_parts(format!("{}(", path.last()), Vec::new(), args)
            }
            ExprKind::Call { callee, args } if only_reads(self.constants(), id, 0) => {
                let called = match self.typed().callees.get(&id)? {
                    Callee::Resolved(resolved) => format!("{:?}", resolved.targets),
                    Callee::External(path) => path.clone(),
                    _ => self.text(*callee),
                };
                self.pure_parts(format!("{called}("), Vec::new(), args)
            }
            ExprKind::Tuple(parts) | ExprKind::Array { elements: parts, is_vec: false } => {
                self.pure_parts("(".to_owned(), Vec::new(), parts)
            }
            ExprKind::Closure(code) if !code.is_async && !super::optional::leaves(body, code.body) => {
                self.pure_closure(code)
            }
            // What a closure gives may stand in a block.
            ExprKind::Block(block) if block.stmts.is_empty() && block.label.is_none() => self.pure(block.tail?),
            _ => None,
        }
    }

    /// The value that is asked whether it is there, or is taken apart: what is chosen from another option is asked for that one.
    pub(super) fn pure_option(&mut self, id: ExprId) -> Option<Pure> {
        if chooses(self.constants(), id) { None } else { self.pure(id) }
    }

    /// What is pure if its parts are.
    fn pure_parts(&mut self, mut key: String, mut reads: Vec<Place>, parts: &[ExprId]) -> Option<Pure> {
        for part in parts {
            let part = self.pure(*part)?;
            key.push_str(&part.key);
            key.push(',');
            reads.extend(part.reads);
        }
        key.push(')');
        Some(Pure { key, reads, ..Pure::default() })
    }

    /// A closure that only reads: two that are written alike give the same where what they name is the same.
    fn pure_closure(&mut self, code: &Closure) -> Option<Pure> {
        let body = self.body();
        let mut key = "|".to_owned();
        let params = code.params.iter().map(|(pat, _)| *pat);
        for pat in params.clone() {
            key.push_str(self.program.sources.snippet(body.pat(pat).span));
            key.push(',');
        }
        let locals: Vec<LocalId> = params.flat_map(|pat| self.locals_of(pat)).collect();
        self.inner.extend(&locals);
        let given = self.pure(code.body);
        self.inner.retain(|local| !locals.contains(local));
        let given = given?;
        Some(Pure { key: format!("{key}| {}", given.key), reads: given.reads, ..Pure::default() })
    }

    /// Whether an expression is a parameter of a closure that is asked whether it is pure, or a part of one.
    fn names_inner(&self, id: ExprId) -> bool {
        match &self.body().expr(id).kind {
            ExprKind::Field { base, .. } | ExprKind::Index { base, .. } => self.names_inner(*base),
            ExprKind::Deref(inner) | ExprKind::Reference { value: inner, .. } => self.names_inner(*inner),
            _ => self.typed().expr_local.get(&id).is_some_and(|local| self.inner.contains(local)),
        }
    }

    /// An entry of a table or a part of a slice: `WEIGHTS[i]`, `frame[1..]`.
    fn pure_entry(&mut self, id: ExprId) -> Option<Pure> {
        let ExprKind::Index { base, index } = self.body().expr(id).kind else { return None };
        if let Some(own) = self.typed().indexed.get(&id)
            && !own.targets.iter().all(|target| super::reading::is_pure_function(self.program, *target, 0))
        {
            return None;
        }
        let (table, at) = (self.pure(base)?, self.pure(index)?);
        let key = format!("{}[{}]", table.key, at.key);
        Some(Pure { key, reads: [table.reads, at.reads].concat(), ..Pure::default() })
    }

    /// A part of a constant, or of a static that nobody changes: `CONFIG.heater.is_on`, `TABLE[1].gain`.
    fn pure_setting(&mut self, id: ExprId) -> Option<Pure> {
        let body = self.body();
        match &body.expr(id).kind {
            ExprKind::Field { base, name } => {
                let base = self.pure_setting(*base)?;
                Some(Pure { key: format!("{}.{name}", base.key), ..base })
            }
            ExprKind::Index { base, index } if !self.typed().indexed.contains_key(&id) => {
                let base = self.pure_setting(*base)?;
                let index = self.pure(*index)?;
                let key = format!("{}[{}]", base.key, index.key);
                Some(Pure { key, reads: [base.reads, index.reads].concat(), ..Pure::default() })
            }
            ExprKind::Path(path) if matches!(self.typed().expr_def.get(&id), Some(Def::Value(_))) => {
                self.pure_path(id, path)
            }
            // What was set once: `CONFIG.get().unwrap().is_on`.
            ExprKind::MethodCall { receiver, method, .. } if matches!(method.as_str(), "unwrap" | "expect") => {
                self.pure_setting(*receiver)
            }
            ExprKind::MethodCall { receiver, method, .. }
                if matches!(method.as_str(), "get" | "get_or_init")
                    && self.is_made_once(*receiver, &["OnceLock", "OnceCell"]) =>
            {
                Some(self.pure(id)?.found_there())
            }
            // `config().is_on`
            ExprKind::Call { args, .. } if args.is_empty() => {
                let target = self.only_target(id).filter(|target| self.hands_out_setting(*target))?;
                Some(Pure { key: format!("{target:?}()"), ..Pure::default() })
            }
            _ => None,
        }
    }

    /// The name of a table that is a constant, or a static that nobody changes.
    pub(super) fn constant_table(&mut self, id: ExprId) -> Option<String> {
        let ExprKind::Path(path) = &self.body().expr(id).kind else { return None };
        let is_value = matches!(self.typed().expr_def.get(&id), Some(Def::Value(_)));
        let pure = self.pure_path(id, path).filter(|pure| is_value && pure.reads.is_empty());
        pure.map(|_| path.last().to_owned())
    }

    /// Whether a function does nothing but lend a static that nobody changes, or what was put into one once:
    /// `fn config() -> &'static Config { CONFIG.get_or_init(Config::read) }`.
    fn hands_out_setting(&self, target: FunctionId) -> bool {
        let Some(body) = &self.program.index.function(target).function.body else { return false };
        let Some(typed) = self.program.typed(target) else { return false };
        let is_once = |id: ExprId| self.holds_plain_value(typed.ty(id), &["OnceLock", "OnceCell", "LazyLock", "Lazy"]);
        let mut at = body.root;
        loop {
            at = match &body.expr(at).kind {
                ExprKind::Block(block) if block.stmts.is_empty() => match block.tail {
                    Some(tail) => tail,
                    None => return false,
                },
                ExprKind::Reference { value, mutable: false, .. } | ExprKind::Deref(value) => *value,
                ExprKind::MethodCall { receiver, method, .. } if matches!(method.as_str(), "unwrap" | "expect") => {
                    *receiver
                }
                ExprKind::MethodCall { receiver, method, .. }
                    if matches!(method.as_str(), "get" | "get_or_init") && is_once(*receiver) =>
                {
                    *receiver
                }
                ExprKind::Path(_) => break,
                _ => return false,
            };
        }
        let Some(Def::Value(value)) = typed.expr_def.get(&at) else { return false };
        let is_changed = self.program.index.value(*value).item.is_mutable;
        !is_changed && (is_once(at) || self.program.index.is_plain(typed.ty(at)))
    }

    /// A field of what a cell holds: `self.state.borrow().mode`.
    fn pure_borrowed(&mut self, id: ExprId) -> Option<Pure> {
        let ExprKind::Field { base, name } = &self.body().expr(id).kind else { return None };
        if let Some(place) = self.borrowed_cell(*base) {
            return Some(pure_place(place.field(name)));
        }
        let is_borrowed = match &self.body().expr(*base).kind {
            ExprKind::MethodCall { method, .. } => method == "borrow",
            // `legs[Leg::Left].is_down`
            ExprKind::Index { .. } => self.typed().indexed.contains_key(base),
            _ => false,
        };
        Some(self.pure(*base).filter(|_| is_borrowed)?.part(name))
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
        Some(Pure { key: format!("{op}{}", inner.key), reads: inner.reads, ..Pure::default() })
    }

    fn pure_path(&mut self, id: ExprId, path: &Path) -> Option<Pure> {
        if let Some(place) = self.stand_in(id) {
            return Some(pure_place(place));
        }
        if let Some(local) = self.typed().expr_local.get(&id).copied() {
            if self.inner.contains(&local) {
                return Some(Pure { key: format!("'{}", path.text()), ..Pure::default() });
            }
            let var = self.var_of(local);
            return Some(self.pure_var(self.number_behind(var)));
        }
        match self.typed().expr_def.get(&id) {
            Some(Def::Value(value)) => {
                let item = &self.program.index.value(*value).item;
                // A static may be changed by someone else, unless it holds nothing but a value.
                let is_value = self.program.index.is_plain(self.ty(id)) || self.is_made_once(id, &["LazyLock", "Lazy"]);
                let is_fixed = !item.is_static || (!item.is_mutable && is_value);
                // Another one may have the same name elsewhere.
                is_fixed.then(|| Pure { key: format!("{}@{}", path.text(), value.0), ..Pure::default() })
            }
            Some(Def::Variant(..) | Def::External(_) | Def::Type(_)) => {
                Some(Pure { key: path.text(), ..Pure::default() })
            }
            None if path.segments.len() > 1 && computes(path) => Some(Pure { key: path.text(), ..Pure::default() }),
            // `P::HAS_INERTIA`, whatever `P` is.
            None if path.segments.len() > 1 && is_constant_name(path.last())
                || path.ident().is_some_and(|name| self.is_const_parameter(name)) =>
            {
                Some(Pure { key: format!("{OF_FUNCTION}{}", path.text()), ..Pure::default() })
            }
            _ => None,
        }
    }

    /// Whether something is of a type whose plain value is made at the first use.
    fn is_made_once(&self, id: ExprId, names: &[&str]) -> bool {
        self.holds_plain_value(self.ty(id), names)
    }

    /// Whether a type is one of these, and holds a plain value.
    fn holds_plain_value(&self, ty: &Ty, names: &[&str]) -> bool {
        match ty.peel() {
            Ty::External(_, args) => {
                ty.peel().external_name().is_some_and(|name| names.contains(&name))
                    && args.first().is_some_and(|value| self.program.index.is_plain(value))
            }
            _ => false,
        }
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
}

/// Whether a name is written as constants are.
fn is_constant_name(name: &str) -> bool {
    name.chars().all(|letter| letter.is_ascii_uppercase() || letter.is_ascii_digit() || letter == '_')
}
