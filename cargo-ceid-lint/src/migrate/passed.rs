//! A law that is passed on by its path to what calls it for each filter: `filters.iter_mut().for_each(Lag::update)`.

use super::body::LoopBody;
use super::sites::{Part, Site, place_of, statement};
use super::unfit::unfit;
use crate::count::Pair;
use crate::index::Ty;
use crate::source::Span;
use crate::syntax::tree::{ExprId, ExprKind, Receiver};
use crate::types::Resolved;

/// The statement that passes the law of a pair on, where that is what updates it; `None` if it is more than that.
pub(super) fn passed_on(of: &LoopBody<'_>, pair: &Pair, span: Span) -> Option<Site> {
    let of_path = |id: &ExprId| match of.kind(*id) {
        ExprKind::MethodCall { receiver, method, args, .. } if method == "for_each" => match args.as_slice() {
            [path] if of.span(*id) == span || of.span(*path) == span => Some((*id, *receiver, *path)),
            _ => None,
        },
        _ => None,
    };
    let (call, iterator, path) = of.inside.iter().find_map(of_path)?;
    let ExprKind::Path(path) = of.kind(path) else { return None };
    let ExprKind::MethodCall { receiver: collection, method, args, .. } = of.kind(iterator) else { return None };
    if method != "iter_mut" || !args.is_empty() || path.last() != pair.law {
        return None;
    }
    let place = place_of(of, *collection)?;
    let filter = match of.typed.ty(*collection).peel() {
        Ty::Array(element, _) | Ty::Slice(element) => (**element).clone(),
        Ty::External(path, args) if path == "std::vec::Vec" => args.first()?.clone(),
        _ => return None,
    };
    let index = of.program.index;
    let laws = index.methods(&filter, &pair.law);
    let ([law], Ty::Adt(..)) = (laws.as_slice(), &filter) else { return None };
    let law = law.function()?;
    let function = &index.function(law).function;
    let callee = Resolved {
        targets: vec![law],
        owner: None,
        law: Some(pair.half),
        self_ty: filter.clone(),
        has_receiver: true,
        derefs: Vec::new(),
    };
    let is_plain = function.receiver == Some(Receiver::Exclusive) && function.params.is_empty();
    let is_run_once = of.ancestors_inside(call).all(|at| {
        let is_choice = matches!(of.kind(at), ExprKind::If { .. } | ExprKind::Match { .. });
        is_choice || matches!(of.kind(at), ExprKind::Block(_))
    });
    if !is_plain || !is_run_once || unfit(of, call, &callee, &pair.name).is_some() {
        return None;
    }
    let stmt = statement(of, call, &pair.name).ok()?;
    Some(Site {
        place,
        part: Part::All,
        at: *collection,
        filter,
        law: Some(law),
        targets: vec![law],
        method: pair.law.clone(),
        half: pair.half,
        call,
        receiver: *collection,
        inputs: Vec::new(),
        inner: Some(call),
        gone: call,
        stmt: Some(stmt),
        emptied: None,
        tail: String::new(),
        outer: call,
        is_used: false,
    })
}
