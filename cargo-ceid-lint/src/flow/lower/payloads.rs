//! Conditions on what options and results hold: `read().is_ok_and(|z| z > 0.0)`.

use super::patterns::is_event_source;
use super::{Builder, ClosureRef, Value};
use crate::flow::{Effect, NodeId};
use crate::syntax::tree::{ExprId, ExprKind};

/// What a method asks of an option or result and of what that holds.
struct Question {
    /// Whether what is asked about is what an `Err` holds.
    of_err: bool,
    /// The answer where there is nothing to ask about.
    default: bool,
    /// The closure or function that is asked.
    asked: ExprId,
}

impl Builder<'_> {
    fn payload_question(&self, method: &str, args: &[ExprId]) -> Option<Question> {
        let question = |of_err, default, asked| Some(Question { of_err, default, asked });
        match (method, args) {
            ("is_some_and" | "is_ok_and", [asked]) => question(false, false, *asked),
            ("is_err_and", [asked]) => question(true, false, *asked),
            ("is_none_or", [asked]) => question(false, true, *asked),
            ("map_or", [default, asked]) => match self.constant_head(*default).as_deref() {
                Some("true") => question(false, true, *asked),
                Some("false") => question(false, false, *asked),
                _ => None,
            },
            _ => None,
        }
    }

    /// Whether an expression as a value is such a question: `let is_lost = nav.ingest(z).is_err_and(|fault| fault.is_short())`.
    pub(super) fn is_payload_question(&self, receiver: ExprId, method: &str, args: &[ExprId]) -> bool {
        method.starts_with("is_")
            && self.payload_question(method, args).is_some_and(|question| self.can_ask(receiver, &question))
    }

    fn can_ask(&self, receiver: ExprId, question: &Question) -> bool {
        let body = self.body();
        let is_read_here = match &body.expr(question.asked).kind {
            ExprKind::Closure(code) => !code.is_async && !super::optional::leaves(body, code.body),
            // Whatever the function answers, an attempt that it is asked about has failed.
            ExprKind::Path(_) => question.of_err,
            _ => false,
        };
        is_read_here && self.is_optional(receiver) && self.depth < super::MAX_INLINE
    }

    /// `x.is_some_and(|x| …)` and its kin: what the closure asks is asked here. Answers whether it is one.
    pub(super) fn payload_condition(
        &mut self,
        id: ExprId,
        receiver: ExprId,
        method: &str,
        args: &[ExprId],
        no: NodeId,
    ) -> bool {
        let question = self.payload_question(method, args).filter(|question| self.can_ask(receiver, question));
        let Some(Question { of_err, default, asked: code }) = question else { return false };
        let asked = self.pure_option(receiver);
        let value = self.expr(receiver);
        if self.at.is_none() {
            return true;
        }
        let (span, body) = (self.span(id), self.body());
        let written = match &body.expr(code).kind {
            ExprKind::Closure(written) => Some(written),
            _ => None,
        };
        let closure = match written {
            Some(_) => Some(ClosureRef { frame: self.frame, expr: code }),
            None => self.expr(code).closure,
        };
        let first = self.graph.nodes.len();
        let (there, absent) = match closure {
            Some(closure) => {
                self.derive_payload(closure, receiver);
                self.branch_on_payload(receiver, closure, &value, span)
            }
            None => {
                let about = self.about_presence(receiver, Vec::new());
                self.branch_on_head(&value, "+", "-", span, self.presence_text(receiver), about)
            }
        };
        // `events.recv().is_ok_and(|event| event == Event::Tick)` chooses as an arm does.
        for node in &mut self.graph.nodes[first..] {
            if let Effect::Branch(test) = &mut node.effect {
                test.about.is_event |= is_event_source(&test.about);
            }
        }
        let (present, absent) = if of_err { (absent, there) } else { (there, absent) };
        let holds = self.add_node(Effect::Nothing, span);
        self.link(absent, if default { holds } else { no });
        self.resume(present);
        // What an `Err` holds is not what the place of the result holds.
        let payload = if of_err { Value::default() } else { Value { head: None, same_as: None, ..value } };
        match (written, closure) {
            (Some(written), _) => {
                self.depth += 1;
                if let Some((pat, _)) = written.params.first() {
                    self.bind_pattern(*pat, &payload);
                    if let Some(asked) = asked.filter(|_| !of_err) {
                        self.note_held(*pat, &asked.part("0!"));
                    }
                }
                self.condition(written.body, no);
                self.depth -= 1;
            }
            (None, closure) => {
                let truth = closure.map(|closure| self.inline_closure(closure, &[payload], span)).unwrap_or_default();
                if self.at.is_some() {
                    let about = self.about(code);
                    let (yes, failed) = self.branch_on_head(&truth, "true", "false", span, self.text(code), about);
                    self.link(failed, no);
                    self.resume(yes);
                }
            }
        }
        self.jump(holds);
        self.resume_if_reached(holds);
        true
    }
}
