//! What conditions are about: what they read and call, for telling gates.

use super::Builder;
use super::received::received_by;
use crate::flow::{About, AskedLength, LengthBound, Place, Var};
use crate::index::{Def, Ty};
use crate::syntax::tree::{Body, ExprId, ExprKind, Literal, PatKind, Path, StmtKind, TypeRef};
use crate::types::{Callee, LocalId};

/// The operators that compare, with what they are where the sides change places.
const COMPARISONS: &[(&str, &str)] = &[("<", ">"), ("<=", ">="), (">", "<"), (">=", "<="), ("==", "=="), ("!=", "!=")];

impl Builder<'_> {
    /// What a condition reads and calls, for telling gates.
    pub(super) fn about(&mut self, id: ExprId) -> About {
        let (constant, constant_of) = (self.written_out(id), self.constant_of_param(id));
        let length = self.asked_length(id).map(Box::new);
        let is_constant = self.constants().asks_build(id);
        let mut about = About { constant, constant_of, length, is_constant, ..About::default() };
        self.collect_about(id, &mut about, 0);
        about
    }

    /// The length of a collection that a condition compares: `self.window.len() < 8`, `queue.is_empty()`.
    fn asked_length(&mut self, id: ExprId) -> Option<AskedLength> {
        let body = self.body();
        match &body.expr(id).kind {
            ExprKind::Binary { op, lhs, rhs } => {
                let (op, turned) = COMPARISONS.iter().find(|(known, _)| known == op)?;
                let (of, op, other) = match (self.measured(*lhs), self.measured(*rhs)) {
                    (Some(of), None) => (of, *op, *rhs),
                    (None, Some(of)) => (of, *turned, *lhs),
                    _ => return None,
                };
                let bound = match (self.number(other), self.static_place(other), &body.expr(other).kind) {
                    (Some(number), ..) => LengthBound::Number(number),
                    (None, Some(place), _) => LengthBound::Held(place),
                    (None, None, ExprKind::Path(path)) => LengthBound::Constant(path.text()),
                    _ => return None,
                };
                Some(AskedLength { of, op, bound })
            }
            ExprKind::MethodCall { receiver, method, .. } if method == "is_empty" && !self.is_own_call(id) => {
                let of = self.static_place(*receiver)?;
                Some(AskedLength { of, op: "==", bound: LengthBound::Number(0) })
            }
            _ => None,
        }
    }

    /// The collection whose length an expression is.
    fn measured(&mut self, id: ExprId) -> Option<Place> {
        match &self.body().expr(id).kind {
            ExprKind::Cast { value, .. } => self.measured(*value),
            ExprKind::MethodCall { receiver, method, args, .. } if method == "len" && args.is_empty() => {
                if self.is_own_call(id) { None } else { self.static_place(*receiver) }
            }
            _ => None,
        }
    }

    /// Whether a call runs a function of the analysed code.
    fn is_own_call(&self, id: ExprId) -> bool {
        matches!(self.typed().callees.get(&id), Some(Callee::Resolved(resolved)) if !resolved.targets.is_empty())
    }

    /// The truth value of a constant whose value is a literal.
    fn written_out(&self, id: ExprId) -> Option<bool> {
        let Some(Def::Value(value)) = self.typed().expr_def.get(&id) else { return None };
        self.program.index.const_truth(*value)
    }

    /// The parameter, and the name of its associated constant, that an expression names: `C::TWICE`, `<C as Config>::TWICE`.
    fn constant_of_param(&self, id: ExprId) -> Option<Box<(Ty, String)>> {
        let ExprKind::Path(path) = &self.body().expr(id).kind else { return None };
        let (name, owner) = path.segments.split_last()?;
        let owner = match &path.self_ty {
            Some(ty) => Clone::clone(&**ty),
            None if owner.is_empty() => return None,
            None => TypeRef::Path(Path { segments: owner.to_vec(), ..Path::default() }),
        };
        let scope = self.program.index.scope_of(self.frames[self.frame].function);
        let owner = self.program.index.lower(&owner, &scope);
        matches!(owner, Ty::Param(_)).then(|| Box::new((owner, name.name.clone())))
    }

    /// Whether an expression is the name of a constant, or asks the build.
    pub(super) fn is_setting(&self, id: ExprId) -> bool {
        let is_constant =
            |def: &Def| matches!(def, Def::Value(value) if !self.program.index.value(*value).item.is_static);
        self.typed().expr_def.get(&id).is_some_and(is_constant) || self.constants().asks_build(id)
    }

    pub(super) fn about_presence(&mut self, id: ExprId, binds: Vec<Var>) -> About {
        let mut about = self.about(id);
        about.is_presence = true;
        about.binds = binds;
        about
    }

    fn collect_about(&mut self, id: ExprId, about: &mut About, depth: u32) {
        if depth > 64 {
            return;
        }
        if let Some(place) = self.static_place(id) {
            about.reads.push(place);
            self.collect_declared(id, about);
            return;
        }
        if let Some(state) = self.told_variant(id) {
            return self.collect_about(state, about, depth + 1);
        }
        about.names.extend(received_by(self.constants(), id).map(str::to_owned));
        let body = self.body();
        match &body.expr(id).kind {
            ExprKind::MethodCall { receiver, method, args, .. } => {
                about.names.push(method.clone());
                let given: Vec<ExprId> = std::iter::once(*receiver).chain(args.iter().copied()).collect();
                self.collect_remainder(id, &given, about);
                if matches!(method.as_str(), "is_multiple_of" | "rem_euclid") {
                    about.is_remainder = true;
                    about.ratio = args.first().and_then(|arg| self.number(*arg));
                }
                self.collect_about(*receiver, about, depth + 1);
                self.collect_arguments(args, about, depth);
            }
            ExprKind::Call { callee, args } => {
                if let ExprKind::Path(path) = &body.expr(*callee).kind {
                    about.names.push(path.last().to_owned());
                }
                self.collect_remainder(id, args, about);
                self.collect_arguments(args, about, depth);
            }
            ExprKind::Binary { op, lhs, rhs } => {
                about.is_combined = true;
                if matches!(*op, "<" | "<=" | ">" | ">=") {
                    about.is_comparison = true;
                    about.compared = [self.static_place(*lhs), self.static_place(*rhs)];
                }
                let is_remainder = |side: ExprId| matches!(body.expr(side).kind, ExprKind::Binary { op: "%", .. });
                if matches!(*op, "==" | "!=") && is_remainder(*lhs) != is_remainder(*rhs) {
                    about.remainder_is = self.static_place(if is_remainder(*lhs) { *rhs } else { *lhs });
                }
                match *op {
                    "%" => {
                        about.is_remainder = true;
                        about.ratio = self.number(*rhs);
                    }
                    "&" => {
                        about.is_masked = true;
                        about.ratio = self.number(*rhs).and_then(|mask| mask.checked_add(1));
                    }
                    // The first number with which it is so, or is so no more.
                    ">" | "<=" => about.numbers.extend(self.number(*rhs).map(|number| number.saturating_add(1))),
                    _ => about.numbers.extend(self.number(*rhs)),
                }
                self.collect_about(*lhs, about, depth + 1);
                self.collect_about(*rhs, about, depth + 1);
            }
            ExprKind::Path(path) if !self.typed().expr_local.contains_key(&id) => {
                about.names.push(path.last().to_owned());
            }
            // A part of what a call gave: `imu.status().is_ready`.
            ExprKind::Field { base, name } => {
                let is_number = name.bytes().all(|byte| byte.is_ascii_digit());
                about.names.extend((!is_number).then(|| name.clone()));
                self.collect_about(*base, about, depth + 1);
            }
            // An entry of a constant table: `WEIGHTS[channel]`.
            ExprKind::Index { base, index } => {
                self.collect_about(*base, about, depth + 1);
                self.collect_about(*index, about, depth + 1);
            }
            ExprKind::Not(inner)
            | ExprKind::Negate(inner)
            | ExprKind::Deref(inner)
            | ExprKind::Try(inner)
            | ExprKind::Cast { value: inner, .. }
            | ExprKind::Reference { value: inner, .. } => self.collect_about(*inner, about, depth + 1),
            ExprKind::Await(inner) => {
                about.is_awaited = true;
                self.collect_about(*inner, about, depth + 1);
            }
            ExprKind::Closure(code) => self.collect_about(code.body, about, depth + 1),
            ExprKind::Block(block) => {
                if let Some(tail) = block.tail {
                    self.collect_about(tail, about, depth + 1);
                }
            }
            ExprKind::Tuple(parts) => {
                for part in parts {
                    self.collect_about(*part, about, depth + 1);
                }
            }
            _ => {}
        }
    }

    fn collect_arguments(&mut self, args: &[ExprId], about: &mut About, depth: u32) {
        for arg in args {
            if let ExprKind::Reference { mutable: true, value, .. } = &self.body().expr(*arg).kind {
                about.lent.extend(self.static_place(*value));
            }
            self.collect_about(*arg, about, depth + 1);
        }
    }

    /// What the function compares that a truth value was declared with: `let due = every(ticks, 10); if due { … }`.
    fn collect_declared(&mut self, id: ExprId, about: &mut About) {
        if *self.ty(id) != Ty::Bool {
            return;
        }
        let Some(init) = self.constants().initial(id) else { return };
        let body = self.body();
        match &body.expr(init).kind {
            ExprKind::Call { args, .. } => self.collect_remainder(init, args, about),
            ExprKind::MethodCall { receiver, args, .. } => {
                let given: Vec<ExprId> = std::iter::once(*receiver).chain(args.iter().copied()).collect();
                self.collect_remainder(init, &given, about);
            }
            _ => {}
        }
    }

    /// What a function that only compares a remainder divides: `fn every(&self, ratio: u32) -> bool { self.ticks % ratio == 0 }`.
    fn collect_remainder(&mut self, id: ExprId, given: &[ExprId], about: &mut About) {
        let Some(target) = self.only_target(id) else { return };
        let Some(body) = &self.program.index.function(target).function.body else { return };
        let Some(typed) = self.program.typed(target) else { return };
        let Some((dividend, divisor)) = compared_remainder(body) else { return };
        let given_for = |local: &LocalId| {
            let number = body.params.iter().position(|pat| typed.pat_local.get(pat) == Some(local))?;
            given.get(number).copied()
        };
        about.is_remainder = true;
        about.ratio = match (&body.expr(divisor).kind, typed.expr_local.get(&divisor).and_then(given_for)) {
            (_, Some(argument)) => self.number(argument),
            (ExprKind::Literal(Literal::Int(number, _)), None) => *number,
            _ => None,
        };
        let mut at = dividend;
        let mut names: Vec<&str> = Vec::new();
        loop {
            match &body.expr(at).kind {
                ExprKind::Field { base, name } => {
                    names.push(name);
                    at = *base;
                }
                ExprKind::Deref(inner) => at = *inner,
                _ => break,
            }
        }
        let owner = typed.expr_local.get(&at).and_then(given_for).and_then(|argument| self.static_place(argument));
        about.reads.extend(owner.map(|owner| names.iter().rev().fold(owner, |place, name| place.field(name))));
    }
}

/// What a function divides, and by what, if it does nothing but compare the remainder, which may have a name.
fn compared_remainder(body: &Body) -> Option<(ExprId, ExprId)> {
    let mut at = body.root;
    let mut named: Option<(&str, ExprId)> = None;
    while let ExprKind::Block(block) = &body.expr(at).kind {
        named = match block.stmts.as_slice() {
            [] => named,
            [only] if named.is_none() => Some(declared(body, &only.kind)?),
            _ => return None,
        };
        at = block.tail?;
    }
    let value_of = |id: ExprId| match (&body.expr(id).kind, named) {
        (ExprKind::Path(path), Some((name, init))) if path.ident() == Some(name) => init,
        _ => id,
    };
    match &body.expr(at).kind {
        ExprKind::Binary { op: "==" | "!=" | "<" | "<=" | ">" | ">=", lhs, .. } => {
            match &body.expr(value_of(*lhs)).kind {
                ExprKind::Binary { op: "%", lhs, rhs } => Some((*lhs, *rhs)),
                _ => None,
            }
        }
        ExprKind::MethodCall { receiver, method, args, .. } if method == "is_multiple_of" => {
            Some((*receiver, *args.first()?))
        }
        _ => None,
    }
}

/// The name that a statement declares, and its value.
fn declared<'b>(body: &'b Body, kind: &StmtKind) -> Option<(&'b str, ExprId)> {
    match kind {
        StmtKind::Let { pat, init: Some(init), .. } => match &body.pat(*pat).kind {
            PatKind::Bind { name, mutable: false, .. } => Some((name, *init)),
            _ => None,
        },
        _ => None,
    }
}
