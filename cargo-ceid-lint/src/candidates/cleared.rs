//! Which methods set the whole state of a law, and which a part of it: `self.z[lane] = 0.0` leaves the other lanes as they are.
//!
//! A partial reset that is taken for a full one makes proofs of what is none, so that whatever is not understood counts as partial.

use std::collections::{BTreeMap, BTreeSet};

use super::conduct::Reader;
use super::laws::{Finder, is_reset};
use super::uses::{owner_type, takes_state};
use super::words::{is_among, words};
use crate::index::{FunctionId, Shape, Ty};
use crate::syntax::tree::{ExprId, ExprKind, Literal, PatId, PatKind};
use crate::types::Callee;

/// How deep the resets of fields, and helpers, are followed.
const MOST_OWNERS: u32 = 4;

/// Methods of the standard library and of other containers after which nothing is left of what was there.
const CLEARING: &str =
    "fill fill_with clear take replace set store reset copy_from copy_from_slice clone_from clone_from_slice write";

/// Words in the names of fields that say where in a line something is put or taken.
const POSITIONS: &str = "at head tail idx index pos position cursor ptr pointer write read offset";

/// Methods that give a part of a collection.
const CHOOSING: &str = "\
    take skip step_by filter take_while skip_while nth first_mut last_mut get_mut split_at_mut split_first_mut split_last_mut \
    front_mut back_mut find position chunks_mut";

/// What a method sets.
#[derive(Default)]
struct Cleared {
    /// Whether it sets `*self`.
    all: bool,
    fields: BTreeSet<String>,
    /// Of fields of which it sets parts, the names or numbers of these.
    parts: BTreeMap<String, BTreeSet<String>>,
}

/// A field that is written, or what of it.
struct Target {
    field: String,
    /// The part of it that is meant; `None` for all of it.
    part: Option<String>,
}

impl Finder<'_> {
    /// The methods that set the state of the law, and those that set a part of it.
    pub(super) fn resets(&self, methods: &[FunctionId], laws: &[FunctionId]) -> (Vec<String>, Vec<String>) {
        let index = self.program.index;
        let (mut full, mut partial) = (BTreeSet::new(), BTreeSet::new());
        for id in methods {
            let def = index.function(*id);
            if !is_reset(&def.name) || !takes_state(def) {
                continue;
            }
            match self.clears(*id, laws, 0) {
                Some(true) => full.insert(def.name.clone()),
                Some(false) => partial.insert(def.name.clone()),
                None => false,
            };
        }
        // Of several methods of one name one may be meant that sets a part.
        full.retain(|name| !partial.contains(name));
        (full.into_iter().collect(), partial.into_iter().collect())
    }

    /// Whether a method sets all of the state of these laws, or a part of it; `None` if it leaves it alone.
    pub(super) fn clears(&self, id: FunctionId, laws: &[FunctionId], depth: u32) -> Option<bool> {
        let conduct = self.conduct(id);
        let state: BTreeSet<&String> = laws.iter().flat_map(|law| self.conduct(*law).carried()).collect();
        let cleared = self.cleared(id, laws, depth);
        // Where a line of samples begins matters to nobody once all of them are the same.
        let is_place_in_line = |field: &String| {
            laws.iter().any(|law| self.conduct(*law).positions.contains(field))
                && words(field).iter().any(|word| is_among(POSITIONS, word))
                && !cleared.fields.is_empty()
        };
        if cleared.all || state.iter().all(|field| cleared.fields.contains(*field) || is_place_in_line(field)) {
            return Some(true);
        }
        (conduct.writes_all || state.iter().any(|field| conduct.written.contains(*field))).then_some(false)
    }

    /// What a method sets whenever it is called.
    fn cleared(&self, id: FunctionId, laws: &[FunctionId], depth: u32) -> Cleared {
        let mut cleared = Cleared::default();
        let Some(reader) = Reader::of(self.program, id).filter(|_| depth < MOST_OWNERS) else { return cleared };
        let sure = Sure::of(&reader);
        if sure.may_leave {
            return cleared;
        }
        let ids = (0u32..).map(ExprId).take(reader.body.exprs.len());
        for at in ids.filter(|at| !sure.is_asked(*at)) {
            match &reader.body.expr(at).kind {
                ExprKind::Assign { place, value } => {
                    for place in reader.body.assigned_places(*place) {
                        cleared.all |=
                            matches!(&reader.body.expr(place).kind, ExprKind::Deref(of) if reader.is_self(*of));
                        let target = sure.target(place).filter(|target| {
                            // What is computed from the value before is no reset.
                            !reader.body.within(*value).any(|id| reader.field(id).as_ref() == Some(&target.field))
                        });
                        cleared.extend(target);
                    }
                }
                ExprKind::Call { callee, args } if is_taking(&reader, *callee) => {
                    cleared.extend(args.first().and_then(|place| sure.target(*place)));
                }
                ExprKind::MethodCall { receiver, method, .. } => {
                    let targets = match reader.typed.callees.get(&at) {
                        Some(Callee::Resolved(resolved)) => resolved.targets.as_slice(),
                        _ => &[],
                    };
                    if reader.is_self(*receiver) {
                        if let [helper] = targets {
                            let of_helper = self.cleared(*helper, laws, depth + 1);
                            cleared.all |= of_helper.all;
                            cleared.fields.extend(of_helper.fields);
                        }
                        continue;
                    }
                    let Some(target) = sure.target(*receiver) else { continue };
                    let of_field = laws.iter().flat_map(|law| &self.conduct(*law).calls);
                    let inner: Vec<FunctionId> = of_field
                        .filter(|call| call.field == target.field)
                        .flat_map(|call| call.targets.iter().copied())
                        .collect();
                    let is_cleared = match targets {
                        [] => is_among(CLEARING, method) || is_reset(method),
                        targets => targets.iter().all(|reset| {
                            let is_known = !inner.is_empty() || is_reset(method);
                            is_known && self.clears(*reset, &inner, depth + 1) == Some(true)
                        }),
                    };
                    cleared.extend(Some(target).filter(|_| is_cleared));
                }
                _ => {}
            }
        }
        self.join(id, &mut cleared);
        cleared
    }

    /// Takes a field as set all of whose parts are.
    fn join(&self, id: FunctionId, cleared: &mut Cleared) {
        let index = self.program.index;
        let Some(own) = owner_type(index, id) else { return };
        let own = Ty::Adt(own, vec![Ty::Unknown; index.type_def(own).generics.params.len()]);
        for (field, parts) in std::mem::take(&mut cleared.parts) {
            let is_whole = match index.field_ty(&own, None, &field).as_ref().map(Ty::peel) {
                Some(Ty::Adt(ty, _)) => match &index.type_def(*ty).shape {
                    Shape::Struct(fields) => fields.fields.iter().all(|field| parts.contains(&field.name)),
                    Shape::Enum(_) => false,
                },
                Some(Ty::Array(_, length)) => {
                    length.value.is_some_and(|length| (0..length).all(|number| parts.contains(&number.to_string())))
                }
                Some(Ty::Tuple(all)) => (0..all.len()).all(|number| parts.contains(&number.to_string())),
                _ => false,
            };
            if is_whole {
                cleared.fields.insert(field);
            }
        }
    }
}

impl Cleared {
    fn extend(&mut self, target: Option<Target>) {
        match target {
            Some(Target { field, part: None }) => {
                self.fields.insert(field);
            }
            Some(Target { field, part: Some(part) }) => {
                self.parts.entry(field).or_default().insert(part);
            }
            None => {}
        }
    }
}

/// What of a body runs whenever it is called.
struct Sure<'a> {
    reader: &'a Reader<'a>,
    /// Code that runs only if something says so.
    asked: BTreeSet<ExprId>,
    /// Whether something may end the call before its end.
    may_leave: bool,
    /// The numbers that loops over all elements count.
    counted: BTreeSet<u32>,
}

impl<'a> Sure<'a> {
    fn of(reader: &'a Reader<'a>) -> Self {
        let (body, typed) = (reader.body, reader.typed);
        let mut given: BTreeSet<u32> = BTreeSet::new();
        for pat in &body.params {
            locals(reader, *pat, &mut given);
        }
        given.retain(|local| typed.locals.get(*local as usize).is_some_and(|local| local.name != "self"));
        let mentions = |id: ExprId| {
            body.within(id).any(|id| typed.expr_local.get(&id).is_some_and(|local| given.contains(&local.0)))
        };
        // `if let Some(inner) = &mut self.inner` asks whether there is anything to reset.
        let is_own = |id: ExprId| !mentions(id) && (reader.is_self(id) || reader.field(id).is_some());
        let is_there = |id: ExprId| matches!(&body.expr(id).kind, ExprKind::Let { value, .. } if is_own(*value));
        let is_nothing = |id: ExprId| match &body.expr(id).kind {
            ExprKind::Block(block) => block.stmts.is_empty() && block.tail.is_none(),
            ExprKind::Tuple(parts) => parts.is_empty(),
            _ => false,
        };
        let is_none = |pat: PatId| match &body.pat(pat).kind {
            PatKind::Bind { name, .. } => name == "None",
            PatKind::Path(path) => path.text().ends_with("::None"),
            _ => false,
        };
        let mut sure = Self { reader, asked: BTreeSet::new(), may_leave: false, counted: BTreeSet::new() };
        for expr in &body.exprs {
            match &expr.kind {
                ExprKind::If { condition, then, otherwise } => {
                    if !is_there(*condition) {
                        sure.asked.extend(body.within(*then));
                    }
                    sure.asked.extend(otherwise.iter().flat_map(|id| body.within(*id)));
                }
                ExprKind::Match { scrutinee, arms } => {
                    let are_all = arms.iter().all(|arm| !is_nothing(arm.body) || is_none(arm.pat));
                    if !is_own(*scrutinee) || !are_all {
                        sure.asked.extend(arms.iter().flat_map(|arm| body.within(arm.body)));
                    }
                }
                ExprKind::While { body: round, .. } => sure.asked.extend(body.within(*round)),
                ExprKind::For { pat, iterable, body: round, .. } => {
                    if mentions(*iterable) {
                        sure.asked.extend(body.within(*round));
                    } else if sure.is_from_start(*iterable) {
                        locals(reader, *pat, &mut sure.counted);
                    }
                }
                _ => {}
            }
        }
        let leaves = |kind: &ExprKind| matches!(kind, ExprKind::Return(_) | ExprKind::Try(_));
        sure.may_leave = body.exprs.iter().any(|expr| leaves(&expr.kind));
        sure
    }

    fn is_asked(&self, id: ExprId) -> bool {
        self.asked.contains(&id)
    }

    /// Whether a loop counts from nought on up to a length or a constant.
    fn is_from_start(&self, iterable: ExprId) -> bool {
        let body = self.reader.body;
        let ExprKind::Range { start: Some(start), end: Some(end), .. } = &body.expr(iterable).kind else {
            return false;
        };
        matches!(&body.expr(*start).kind, ExprKind::Literal(Literal::Int(Some(0), _)))
            && match &body.expr(*end).kind {
                ExprKind::MethodCall { method, .. } => method == "len",
                ExprKind::Path(_) => !self.reader.typed.expr_local.contains_key(end),
                _ => false,
            }
    }

    /// The field that is written as a whole where a place is, or the part of it; `None` where that cannot be told.
    fn target(&self, place: ExprId) -> Option<Target> {
        let (reader, body) = (self.reader, self.reader.body);
        let mut part = None;
        let mut at = place;
        loop {
            if let Some(local) = reader.typed.expr_local.get(&at)
                && let Some(field) = reader.aliases.get(&local.0)
            {
                let is_all = |value: &Option<ExprId>| value.is_none_or(|value| self.is_all_of(value));
                let is_whole = reader.alias_of.get(&local.0).is_some_and(is_all);
                return is_whole.then(|| Target { field: field.clone(), part });
            }
            match &body.expr(at).kind {
                ExprKind::Field { base, name } if reader.is_self(*base) => {
                    return Some(Target { field: name.clone(), part });
                }
                // Of parts of parts nothing is told.
                ExprKind::Field { .. } if part.is_some() => return None,
                ExprKind::Field { base, name } => (part, at) = (Some(name.clone()), *base),
                ExprKind::Index { base, index } => {
                    match &body.expr(*index).kind {
                        ExprKind::Range { start: None, end: None, .. } => {}
                        ExprKind::Literal(Literal::Int(Some(number), _)) if part.is_none() => {
                            part = Some(number.to_string());
                        }
                        _ if reader
                            .typed
                            .expr_local
                            .get(index)
                            .is_some_and(|local| self.counted.contains(&local.0)) => {}
                        _ => return None,
                    }
                    at = *base;
                }
                ExprKind::Deref(inner) | ExprKind::Reference { value: inner, .. } => at = *inner,
                ExprKind::MethodCall { receiver, method, .. } if !is_among(CHOOSING, method) => at = *receiver,
                _ => return None,
            }
        }
    }

    /// Whether what a variable stands for is a field as a whole, or each of its elements in turn.
    fn is_all_of(&self, value: ExprId) -> bool {
        self.target(value).is_some_and(|target| target.part.is_none())
    }
}

/// Whether a function is `mem::take` or `mem::replace`.
fn is_taking(reader: &Reader<'_>, callee: ExprId) -> bool {
    matches!(&reader.body.expr(callee).kind, ExprKind::Path(path) if {
        let text = path.text();
        matches!(text.rsplit("::").next(), Some("take" | "replace")) && text.contains("mem")
    })
}

/// The variables that a pattern binds.
fn locals(reader: &Reader<'_>, pat: PatId, found: &mut BTreeSet<u32>) {
    found.extend(reader.typed.pat_local.get(&pat).map(|local| local.0));
    match &reader.body.pat(pat).kind {
        PatKind::Bind { sub: Some(inner), .. } | PatKind::Reference(inner) => locals(reader, *inner, found),
        PatKind::Tuple(parts) | PatKind::TupleStruct(_, parts) | PatKind::Or(parts) | PatKind::Slice(parts) => {
            parts.iter().for_each(|part| locals(reader, *part, found));
        }
        PatKind::Struct(_, parts) => parts.iter().for_each(|(_, part)| locals(reader, *part, found)),
        _ => {}
    }
}
