//! Code behind the limit of a graph: it is not followed, and whatever it names may be updated in it.

use std::collections::BTreeSet;

use super::Builder;
use crate::flow::{Cause, Effect, Place};
use crate::index::Def;
use crate::syntax::tree::{ExprId, ExprKind};

impl Builder<'_> {
    /// Says that nothing is known of what happens to the filters that an expression names.
    pub(super) fn pass_over(&mut self, id: ExprId, cause: Cause) {
        let mut places: BTreeSet<Place> = BTreeSet::new();
        for inner in self.body().within(id) {
            match &self.body().expr(inner).kind {
                ExprKind::Path(_) => places.extend(self.named_places(inner)),
                ExprKind::Opaque(call) => places.extend(self.mentioned_places(&call.mentions)),
                ExprKind::Unknown { mentions, .. } => places.extend(self.mentioned_places(mentions)),
                _ => {}
            }
        }
        places.retain(|place| place.base_var().is_none_or(|var| self.may_hold_filter(&self.graph.var(var).ty)));
        if !places.is_empty() {
            self.emit(Effect::Unknown { places: places.into_iter().collect(), cause }, self.span(id));
        }
    }

    /// What a path names: a variable, with what it has captured if it holds a closure, or a static.
    fn named_places(&self, id: ExprId) -> Vec<Place> {
        if let Some(place) = self.stand_in(id) {
            return vec![place];
        }
        if let Some(Def::Value(value)) = self.typed().expr_def.get(&id) {
            let is_static = self.program.index.value(*value).item.is_static;
            return is_static.then(|| Place::of_static(*value)).into_iter().collect();
        }
        let local = self.typed().expr_local.get(&id);
        let Some(var) = local.and_then(|local| self.frames[self.frame].vars.get(local)) else { return Vec::new() };
        let captured = self.closures.get(var).map(|closure| self.captured_vars(*closure)).unwrap_or_default();
        captured.into_iter().chain([*var]).map(Place::var).collect()
    }
}
