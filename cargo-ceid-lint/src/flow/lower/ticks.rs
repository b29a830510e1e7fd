//! `tick.then(&mut self.first).each(&mut self.rest).done()`: ceid-core's own way to run the laws of a composite's parts.

use super::laws::Law;
use super::sources::Source;
use super::{Builder, Value};
use crate::flow::CycleKind;
use crate::index::{FunctionId, MethodOwner, Ty};
use crate::syntax::tree::ExprId;
use crate::types::item_of;

impl Builder<'_> {
    /// A method of the permit to run a law; `None` if it runs none, or not in every cycle.
    pub(super) fn tick_call(&mut self, id: ExprId, receiver: ExprId, method: &str, args: &[ExprId]) -> Option<Value> {
        match (method, args) {
            ("then", [part]) => {
                self.expr(receiver);
                let value = self.expr(*part);
                self.part_runs(id, *part, value, self.ty(*part).peel());
            }
            ("each", [parts]) => {
                self.expr(receiver);
                let source: Source = self.source(*parts);
                let item = item_of(self.ty(*parts)).unwrap_or(Ty::Unknown);
                let keyword = self.span(*parts);
                self.run_loop(CycleKind::For, keyword, None, source, |this, value, _| {
                    this.part_runs(id, *parts, value, item.peel());
                });
            }
            ("done", []) => {
                self.expr(receiver);
            }
            _ => return None,
        }
        Some(Value::default())
    }

    /// The law of a part runs.
    fn part_runs(&mut self, id: ExprId, part: ExprId, value: Value, ty: &Ty) {
        if self.at.is_none() {
            return;
        }
        let index = self.program.index;
        let owner = index.methods(ty, "update").into_iter().next();
        let targets: Vec<FunctionId> = match &owner {
            Some(MethodOwner::Inherent(id) | MethodOwner::Implemented(_, id)) => vec![*id],
            Some(MethodOwner::Declared(of, _)) => index.implementations(of, "update"),
            None => Vec::new(),
        };
        let spec = index.law_spec(ty).unwrap_or(index.trait_spec());
        let law = Law { spec, group: 0, targets: &targets, has_receiver: true };
        self.law_call(id, law, &[part], &[value]);
    }
}
