//! Arrays whose elements are given to a closure one by one and come back: `filters.map(|mut f| { f.update(x); f })`.

use super::super::sources::{Item, Source, Stage};
use super::super::{Builder, Value};
use super::is_row;
use crate::flow::Transfer;
use crate::index::Ty;
use crate::syntax::tree::{ExprId, ExprKind};

impl Builder<'_> {
    /// What `map` makes of an array whose closure gives back the element that it gets: the same elements.
    pub(super) fn mapped_array(&self, source: &Source, closure: ExprId) -> Option<Value> {
        let Item::Element(place) = &source.item else { return None };
        let is_whole = source.stages.is_empty() && self.gives_back_element(closure);
        is_whole.then(|| Value {
            place: Some(place.clone()),
            is_owned: true,
            leaves_by: Some(Transfer::Move),
            ..Value::default()
        })
    }

    /// `filters.into_iter().map(|mut f| { f.update(x); f }).collect()`: the same elements in another collection.
    pub(super) fn rebuilt(&self, receiver: ExprId, source: &Source) -> Option<Value> {
        let Item::Element(place) = &source.item else { return None };
        let gives_back = |stage: &Stage| match stage {
            Stage::Map(closure) => closure.frame == self.frame && self.gives_back_element(closure.expr),
            _ => false,
        };
        let is_whole = source.in_order && !source.passes() && !source.is_advanced && !source.is_choice;
        let all = is_whole && source.stages.iter().all(gives_back) && self.takes_all(receiver);
        all.then(|| Value {
            place: Some(place.clone()),
            is_owned: true,
            leaves_by: Some(Transfer::Move),
            ..Value::default()
        })
    }

    /// Whether an iterator begins with a collection that it takes apart: `filters.into_iter()`.
    fn takes_all(&self, id: ExprId) -> bool {
        let ExprKind::MethodCall { receiver, method, args, .. } = &self.body().expr(id).kind else { return false };
        match method.as_str() {
            "map" => self.takes_all(*receiver),
            "into_iter" => args.is_empty() && !matches!(self.ty(*receiver), Ty::Ref(..)) && is_row(self.ty(*receiver)),
            _ => false,
        }
    }

    /// Whether a closure gives back what it gets, and puts nothing else in its place.
    fn gives_back_element(&self, closure: ExprId) -> bool {
        let (body, typed) = (self.body(), self.typed());
        let ExprKind::Closure(code) = &body.expr(closure).kind else { return false };
        let [(pat, _)] = code.params.as_slice() else { return false };
        let Some(own) = typed.pat_local.get(pat) else { return false };
        let is_own = |id: &ExprId| typed.expr_local.get(id) == Some(own);
        let mut answer = code.body;
        while let ExprKind::Block(block) = &body.expr(answer).kind {
            let Some(tail) = block.tail else { return false };
            answer = tail;
        }
        let mut open = vec![code.body];
        while let Some(id) = open.pop() {
            match &body.expr(id).kind {
                ExprKind::Return(_) => return false,
                ExprKind::Assign { place, .. } if is_own(place) => return false,
                _ => open.extend(body.children(id)),
            }
        }
        is_own(&answer)
    }
}
