//! What conditions are about: pure expressions in one spelling, so that branches on the same value are told to be so.

use super::Builder;
pub(super) use crate::flow::asked::place_key;
use crate::flow::test::MAX_HEADS;
use crate::flow::{About, Effect, Head, NodeId, Place, Subject, SubjectId, Test, Var};
use crate::index::{Shape, Ty};
use crate::source::Span;
use crate::syntax::tree::{BuildFlag, CfgKey, ExprId, ExprKind};

/// A pure expression: its spelling with variables by number, and the places it reads.
#[derive(Clone, Debug, Default)]
pub(super) struct Pure {
    pub(super) key: String,
    pub(super) reads: Vec<Place>,
    pub(super) whole: Option<Place>,
    /// The cell that it asks whether it is filled, if others may do that at any time, and once: `CALIBRATION.get()`.
    pub(super) filled: Option<Place>,
}

impl Pure {
    /// What is found in a cell that is filled once: in a static, it is the same from then on.
    pub(super) fn found_there(mut self) -> Self {
        if let Some(cell) = self.filled.take().filter(|cell| cell.base_var().is_none()) {
            self.reads.retain(|read| *read != cell);
        }
        self
    }

    /// A part of it, which changes with it.
    pub(super) fn part(&self, step: &str) -> Self {
        Self { key: format!("{}.{step}", self.key), reads: self.reads.clone(), ..Self::default() }
    }
}

impl Builder<'_> {
    /// The subject with that key; made when it is new.
    pub(super) fn subject(&mut self, pure: Pure, total: Option<Vec<Head>>) -> SubjectId {
        if let Some(id) = self.subjects.get(&pure.key) {
            return *id;
        }
        let id = SubjectId(u32::try_from(self.graph.subjects.len()).expect("fewer than 2^32 subjects"));
        let heads = Vec::new();
        let subject = Subject {
            key: pure.key.clone(),
            reads: pure.reads,
            whole: pure.whole,
            question: None,
            is_of_callers: false,
            heads,
            total,
        };
        self.graph.subjects.push(subject);
        self.graph.cells.filled.extend(pure.filled.map(|place| (id, place)));
        self.subjects.insert(pure.key, id);
        id
    }

    /// A subject that has all heads of an expression's type.
    pub(super) fn state_subject(&mut self, pure: Pure, like: ExprId) {
        self.subject_of_type(pure, &self.ty(like).clone());
    }

    /// Whether something is in an option of a reference may be asked where that goes, and is known by its place.
    pub(super) fn may_be_asked(&mut self, place: &Place, goes_to: Var) {
        let ty = self.graph.var(goes_to).ty.clone();
        if self.is_option_of_references(&ty) {
            for place in [place.clone(), Place::var(goes_to)] {
                self.subject_of_type(pure_place(place), &ty);
            }
        }
    }

    fn subject_of_type(&mut self, pure: Pure, ty: &Ty) {
        let total = self.total_heads(ty);
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
        (self.may_be_filled_behind(branch, yes, true), self.may_be_filled_behind(branch, no, false))
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

    /// A branch on what `cfg!` asks. What the build does not have is there, but no way leads to it.
    pub(super) fn branch_on_build(&mut self, flag: &BuildFlag, span: Span, text: String) -> (NodeId, NodeId) {
        let answer = match flag {
            BuildFlag::Known(answer) => *answer,
            BuildFlag::Unknown(key) => return self.branch_on_cfg(key, span),
        };
        let told = self.temporary(Ty::Bool, span);
        self.set(told, &super::Value { head: Some(answer.to_string()), ..super::Value::default() }, span);
        let id = self.subject(self.pure_var(told), Some(vec!["true".to_owned(), "false".to_owned()]));
        self.head_bit(id, "true");
        self.head_bit(id, "false");
        let about = About { is_constant: true, built: Some(answer), ..About::default() };
        self.branch_on_subject(id, &["true".to_owned()], true, span, text, about)
    }

    /// The head of a constant expression: a literal, a variant, a constant.
    pub(super) fn constant_head(&self, id: ExprId) -> Option<Head> {
        self.constants().head(id)
    }

    /// All heads that the value of an expression can have: what remains of a number that is never below zero is one of a few.
    pub(super) fn all_heads(&mut self, id: ExprId) -> Option<Vec<Head>> {
        match self.remainders(id) {
            Some(ratio) => Some((0..ratio).map(|left| left.to_string()).collect()),
            None => self.total_heads(self.ty(id)),
        }
    }

    /// How many values `n % 4` can have, if none of them is below zero.
    fn remainders(&mut self, id: ExprId) -> Option<u64> {
        let ExprKind::Binary { op: "%", lhs, rhs } = self.body().expr(id).kind else { return None };
        let ratio = self.number(rhs).filter(|_| self.is_unsigned(lhs))?;
        (1..=MAX_HEADS as u64).contains(&ratio).then_some(ratio)
    }

    /// All heads that a value of the type can have.
    pub(super) fn total_heads(&self, ty: &Ty) -> Option<Vec<Head>> {
        match ty.peel() {
            Ty::Bool => Some(vec!["true".to_owned(), "false".to_owned()]),
            Ty::Adt(id, _) => match &self.program.index.type_def(*id).shape {
                Shape::Enum(variants) => Some(variants.iter().map(|variant| variant.name.clone()).collect()),
                Shape::Struct(_) => None,
            },
            Ty::External(path, _) if WITH_TWO_HEADS.iter().any(|name| path.ends_with(name)) => {
                Some(vec!["+".to_owned(), "-".to_owned()])
            }
            _ => None,
        }
    }
}

/// The types of the standard library whose values are one of two: see [`external_head`].
const WITH_TWO_HEADS: [&str; 5] = ["::Option", "::Result", "::LockResult", "::Poll", "::ControlFlow"];

/// The head of a constructor outside the analysed code.
pub(super) fn external_head(path: &str) -> Head {
    match path.rsplit("::").next().unwrap_or(path) {
        // `Ready` ends a future as `None` ends an iterator.
        "Some" | "Ok" | "Pending" | "Continue" => "+".to_owned(),
        "None" | "Err" | "Ready" | "Break" => "-".to_owned(),
        name => name.to_owned(),
    }
}

/// The value of a place.
pub(super) fn pure_place(place: Place) -> Pure {
    Pure { key: place_key(&place), reads: vec![place.clone()], whole: Some(place), filled: None }
}

/// Whether a method of an option lends what is in it.
pub(super) fn lends_payload(method: &str) -> bool {
    matches!(method, "as_mut" | "as_ref" | "as_deref_mut" | "as_deref")
}
