//! Iterators over options: only what is there gets a round.

use super::sources::{Item, Source, Stage};
use super::subjects::lends_payload;
use super::{Builder, ClosureRef, Value};
use crate::flow::{About, LoopId, Place, Rounds};
use crate::index::Ty;
use crate::source::Span;
use crate::syntax::tree::{ExprId, ExprKind, PatKind};

impl Builder<'_> {
    /// Whether an adaptor passes on what is there of options that may hold filters: `flatten()`, `filter_map(Option::as_mut)`.
    pub(super) fn gives_present(&self, receiver: ExprId, method: &str, args: &[ExprId]) -> bool {
        let takes_payload = match (method, args) {
            ("flatten", []) => true,
            ("filter_map" | "flat_map", [closure]) => self.gives_payload(*closure),
            _ => false,
        };
        let gives_options = matches!(self.ty(receiver), Ty::External(_, items)
            if items.first().is_some_and(|item| item.peel().external_name() == Some("Option")));
        takes_payload && gives_options && self.may_hold_filter(self.ty(receiver))
    }

    /// What such an adaptor runs over.
    pub(super) fn present(&mut self, receiver: ExprId) -> Source {
        let source = self.source(receiver);
        if source.stages.is_empty() && self.is_all_present(receiver) {
            return source;
        }
        if !source.item.is_lent() || source.stages.iter().any(|stage| matches!(stage, Stage::Filter(_))) {
            return Source { rounds: Rounds::Bounded, ..source };
        }
        let staged = Source { stages: Vec::new(), ..source.clone() };
        Source { item: Item::Present(Box::new(source.staged())), ..staged }
    }

    /// Whether an iterator runs over an array that is written out with something in every element: `[Some(&mut l), Some(&mut r)]`.
    fn is_all_present(&self, id: ExprId) -> bool {
        let body = self.body();
        match &body.expr(id).kind {
            ExprKind::MethodCall { receiver, method, args, .. } => {
                args.is_empty() && matches!(method.as_str(), "into_iter" | "iter_mut") && self.is_all_present(*receiver)
            }
            ExprKind::Array { elements, .. } => elements.iter().all(|element| match &body.expr(*element).kind {
                ExprKind::Call { callee, .. } => {
                    matches!(&body.expr(*callee).kind, ExprKind::Path(path) if path.text() == "Some")
                }
                _ => false,
            }),
            _ => false,
        }
    }

    /// Whether a closure gives back the option that it gets: `Option::as_mut`, `|slot| slot.as_mut()`.
    fn gives_payload(&self, closure: ExprId) -> bool {
        let body = self.body();
        match &body.expr(closure).kind {
            ExprKind::Path(path) => lends_payload(path.last()),
            ExprKind::Closure(code) => {
                let [(pat, _)] = code.params.as_slice() else { return false };
                let PatKind::Bind { name, .. } = &body.pat(*pat).kind else { return false };
                let is_param = |id: ExprId| matches!(&body.expr(id).kind, ExprKind::Path(path) if path.text() == *name);
                match &body.expr(code.body).kind {
                    ExprKind::MethodCall { receiver, method, args, .. } => {
                        args.is_empty() && lends_payload(method) && is_param(*receiver)
                    }
                    _ => is_param(code.body),
                }
            }
            _ => false,
        }
    }

    /// Whether a closure makes something of an item, or says that it is none, and asks for nothing but the item:
    /// `lines.filter_map(|line| line.parse::<f32>().ok())`.
    pub(super) fn makes_of_item(&self, closure: ClosureRef) -> bool {
        let frame = &self.frames[closure.frame];
        let ExprKind::Closure(code) = &frame.body.expr(closure.expr).kind else { return false };
        let span = frame.body.expr(code.body).span;
        let inside = frame.body.exprs.iter().filter(|expr| span.contains(expr.span));
        // What is called without the item answers for something else.
        let asks_elsewhere = |kind: &ExprKind| match kind {
            ExprKind::Call { args, .. } => args.is_empty(),
            ExprKind::Path(path) => path.text().chars().all(|letter| letter.is_ascii_uppercase() || letter == '_'),
            _ => false,
        };
        frame.typed.ty(code.body).external_name() == Some("Option")
            && self.mentions(closure).next().is_none()
            && !inside.into_iter().any(|expr| asks_elsewhere(&expr.kind))
    }

    /// Goes on with a round where its item is there, and with the next round where it is not.
    pub(super) fn skip_absent(&mut self, id: LoopId, value: &Value, span: Span) {
        let Some(var) = value.place.as_ref().and_then(Place::base_var) else { return };
        let about = About::presence_of(var);
        let (present, absent) = self.opaque_branch(span, "let Some(_) = item".to_owned(), about);
        self.resume(absent);
        let head = self.graph.loops[id.0 as usize].head;
        self.jump(head);
        self.resume(present);
    }
}
