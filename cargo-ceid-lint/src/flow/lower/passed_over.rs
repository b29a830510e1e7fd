//! Code that is not followed, because it stands behind the limit of a graph or cannot be read: whatever it names may be updated in it.

use std::collections::BTreeSet;

use super::Builder;
use crate::flow::{Cause, Effect, Place, Var};
use crate::index::{Def, Ty};
use crate::source::Span;
use crate::syntax::tree::{ExprId, ExprKind};
use crate::types::is_lock;

impl Builder<'_> {
    /// Says that nothing is known of what happens to the filters that an expression names.
    pub(super) fn pass_over(&mut self, id: ExprId, cause: Cause) {
        let mut places: BTreeSet<Place> = BTreeSet::new();
        for inner in self.body().within(id) {
            match &self.body().expr(inner).kind {
                ExprKind::Path(_) => places.extend(self.named_places(inner)),
                ExprKind::Opaque(call) => places.extend(self.mentioned_places(&call.mentions, &call.fields)),
                ExprKind::Unknown { mentions, .. } => places.extend(self.mentioned_places(mentions, &[])),
                _ => {}
            }
        }
        places.retain(|place| place.base_var().is_none_or(|var| self.may_hold_filter(&self.graph.var(var).ty)));
        if !places.is_empty() {
            self.emit(Effect::Unknown { places: places.into_iter().collect(), cause }, self.span(id));
        }
    }

    /// Says that nothing is known of what happens to what these identifiers name.
    pub(super) fn unknown_mentions(&mut self, mentions: &[String], fields: &[Vec<String>], cause: Cause, span: Span) {
        let places = self.mentioned_places(mentions, fields);
        if !places.is_empty() && self.at.is_some() {
            self.emit(Effect::Unknown { places, cause }, span);
        }
    }

    /// The variables in scope with these names, or the fields of them that are named. Through a shared reference no filter is updated.
    pub(super) fn mentioned_places(&mut self, mentions: &[String], fields: &[Vec<String>]) -> Vec<Place> {
        let index = self.program.index;
        let mut places = Vec::new();
        let mut vars: Vec<Var> = self.frames[self.frame].vars.values().copied().collect();
        vars.sort_unstable();
        for var in vars {
            let info = self.graph.var(var);
            let is_shared = matches!(info.ty, Ty::Ref(false, _)) && index.shares_no_filter(&info.ty, is_lock);
            if is_shared || !mentions.contains(&info.name) {
                continue;
            }
            let mut named = fields.iter().filter(|path| path[0] == info.name).peekable();
            if named.peek().is_none() {
                places.push(Place::var(var));
            }
            places.extend(named.map(|path| {
                let (mut place, mut ty) = (Place::var(var), info.ty.peel().clone());
                for name in &path[1..] {
                    let Some(field) = index.field_ty(&ty, None, name) else { break };
                    (place, ty) = (place.field(name), field);
                }
                place
            }));
        }
        places.sort();
        places.dedup();
        places
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
