//! Which fields of its receiver a method reads that does nothing else: what it tells stays the same as long as these do, whatever
//! becomes of the other fields.

use std::collections::BTreeSet;

use crate::flow::lower::Builder;
use crate::flow::lower::subjects::Pure;
use crate::flow::{Place, Program};
use crate::index::{FunctionId, Shape, Ty};
use crate::syntax::tree::{ExprId, ExprKind};
use crate::types::{Callee, TypedBody};

/// How deep methods are followed.
const MAX_DEPTH: u32 = 3;

/// How many fields are told apart.
const MAX_FIELDS: usize = 8;

impl Builder<'_> {
    /// What a method reads of its receiver, which is a place.
    pub(in crate::flow::lower) fn read_by_method(&self, call: ExprId, receiver: &Pure) -> Option<Vec<Place>> {
        let Some(Callee::Resolved(resolved)) = self.typed().callees.get(&call) else { return None };
        let ([target], Some(owner)) = (resolved.targets.as_slice(), &receiver.whole) else { return None };
        let fields = fields_read(self.program, *target, 0).filter(|fields| !fields.is_empty())?;
        Some(fields.iter().map(|names| names.iter().fold(owner.clone(), |place, name| place.field(name))).collect())
    }
}

/// The fields that a method reads; `None` if it may read more.
fn fields_read(program: &Program<'_>, id: FunctionId, depth: u32) -> Option<BTreeSet<Vec<String>>> {
    let body = program.index.function(id).function.body.as_ref().filter(|_| depth < MAX_DEPTH)?;
    let typed = program.typed(id)?;
    let owner = typed.pat_local.get(body.params.first()?)?;
    let is_owner = |id: ExprId| typed.expr_local.get(&id) == Some(owner);
    let path = |id: ExprId| -> Option<Vec<String>> {
        let mut names = Vec::new();
        let mut at = id;
        while let ExprKind::Field { base, name } = &body.expr(at).kind {
            // What lies behind a pointer of the analysed code has another place.
            if !has_field(program, typed, *base, name) {
                names.clear();
            } else {
                names.push(name.clone());
            }
            at = *base;
        }
        names.reverse();
        is_owner(at).then_some(names)
    };
    let mut found = BTreeSet::new();
    let mut told: BTreeSet<ExprId> = BTreeSet::new();
    let ids = || (0..body.exprs.len()).map(|number| ExprId(u32::try_from(number).unwrap_or(u32::MAX)));
    for id in ids() {
        match &body.expr(id).kind {
            ExprKind::MethodCall { receiver, .. } => {
                let Some(Callee::Resolved(resolved)) = typed.callees.get(&id) else { continue };
                let ([target], Some(names)) = (resolved.targets.as_slice(), path(*receiver)) else { continue };
                let Some(fields) = fields_read(program, *target, depth + 1) else { continue };
                found.extend(fields.into_iter().map(|inner| [names.clone(), inner].concat()));
                told.insert(*receiver);
            }
            ExprKind::Field { base, .. } => {
                told.insert(*base);
            }
            _ => {}
        }
    }
    let open = ids().filter(|id| !told.contains(id));
    for names in open.filter_map(path) {
        found.insert(names);
    }
    // It is read as a whole.
    let is_whole = found.iter().any(Vec::is_empty);
    (!is_whole && found.len() <= MAX_FIELDS).then_some(found)
}

fn has_field(program: &Program<'_>, typed: &TypedBody, base: ExprId, name: &str) -> bool {
    match typed.ty(base).peel() {
        Ty::Adt(id, _) => match &program.index.type_def(*id).shape {
            Shape::Struct(fields) => fields.fields.iter().any(|field| field.name == name),
            Shape::Enum(_) => false,
        },
        _ => false,
    }
}
