//! Arrays whose elements are given to a closure one by one and come back: `filters.map(|mut f| { f.update(x); f })`.

use super::super::sources::{Item, Source};
use super::super::{Builder, Value};
use crate::flow::Transfer;
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
