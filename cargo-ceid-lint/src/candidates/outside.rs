//! Filters that are no types of the analysed code: types of crates whose sources are not read, and functions with a state.

use std::collections::{BTreeMap, BTreeSet};

use super::conduct::conduct_on;
use super::halves::groups;
use super::judge::{LEAST_WEIGHT, is_outside_law};
use super::laws::{Draft, Finder, Found};
use super::measured::is_measured;
use super::uses::{is_test, loops};
use super::words::{is_among, law_strength, type_strength, words};
use super::{Reason, Subject, Uses};
use crate::config::{InstancePlace, Receiver, TimeBase};
use crate::flow::{is_time_name, takes_step};
use crate::index::{Namespace, Owner, Ty};
use crate::source::{FileId, Span};
use crate::syntax::tree::{Body, ExprId, ExprKind, TypeRef};
use crate::types::TypedBody;

impl Finder<'_> {
    /// Functions that carry a number from call to call behind a `&mut` parameter.
    pub(super) fn find_functions(&mut self) {
        let index = self.program.index;
        let laws = self.laws();
        let mut seen = BTreeSet::new();
        for id in index.function_ids() {
            let def = index.function(id);
            let (Owner::Module, Some(body), Some(typed)) = (def.owner, &def.function.body, self.program.typed(id))
            else {
                continue;
            };
            let uses = self.calls.uses(id);
            let strength = law_strength(&def.name);
            let is_named = type_strength(&def.name) == 2;
            if is_test(index, def)
                || !self.is_in_scope(def.module)
                || uses.in_cycles == 0
                || strength < 0
                || !(is_named || strength == 2)
                || def.function.params.len() < 2
                || def.function.is_async
                || laws.contains_key(&id)
            {
                continue;
            }
            let scope = index.scope_of(id);
            let params: Vec<Ty> = def.function.params.iter().map(|param| index.lower(param, &scope)).collect();
            let states = (0u32..).zip(&def.function.params).zip(&params).filter(|((_, written), ty)| {
                let TypeRef::Reference { mutable: true, .. } = written else { return false };
                !matches!(ty.peel(), Ty::Slice(_)) && is_state(index, ty.peel())
            });
            let mut best: Option<(i32, Found)> = None;
            let name_of = |at: usize| {
                let pat = body.params.get(at)?;
                let local = typed.pat_local.get(pat)?;
                Some(typed.local(*local).name.as_str())
            };
            for ((position, _), ty) in states {
                let Some(local) = body.params.get(position as usize).and_then(|pat| typed.pat_local.get(pat)) else {
                    continue;
                };
                let conduct = conduct_on(self.program, id, local.0);
                let carries = (conduct.writes_all && conduct.reads_all) || conduct.carried().next().is_some();
                let others = params.iter().enumerate().filter(|(at, _)| *at != position as usize);
                let is_fed = others.clone().any(|(_, ty)| is_measured(index, ty, 0));
                if !carries || conduct.sums == 0 || !is_fed {
                    continue;
                }
                let name = typed.local(*local).name.clone();
                let remembers = conduct.carried().any(|field| is_old(field));
                let strength = self.says_state(Some(&name), ty) + i32::from(remembers);
                // What is only read is the state of nothing, and what is written beside it is the data.
                let is_data = others.clone().any(|(at, other)| {
                    let is_read =
                        !matches!(def.function.params.get(at), Some(TypeRef::Reference { mutable: true, .. }));
                    is_read && self.says_state(name_of(at), other) > strength
                });
                if is_data {
                    continue;
                }
                let mut reasons = vec![Reason::Carries(def.name.clone(), vec![name])];
                let is_timed = takes_step(index, id);
                if is_timed {
                    reasons.push(Reason::Timed(def.name.clone()));
                }
                let found = Found {
                    name: def.name.clone(),
                    place: def.function.keyword,
                    path: self.path_to(def.module, &def.name, def.function.keyword, Namespace::Value),
                    draft: Draft {
                        subject: Subject::Function,
                        law: groups(std::slice::from_ref(&def.name), &[]),
                        instance: InstancePlace::Argument(position),
                        receiver: Receiver::Exclusive,
                        resets: Vec::new(),
                        partial_resets: Vec::new(),
                        key: None,
                        time_base: if is_timed { TimeBase::Passed } else { TimeBase::Fixed },
                        reasons,
                        uses,
                        weight: LEAST_WEIGHT + 2 * i32::from(is_named) + i32::from(is_timed),
                        is_plain: false,
                    },
                    laws: vec![id],
                };
                if best.as_ref().is_none_or(|(known, _)| strength > *known) {
                    best = Some((strength, found));
                }
            }
            if let Some((_, found)) = best
                && seen.insert(def.function.keyword)
            {
                self.found.push(found);
            }
        }
    }

    /// How much the name and the type of a parameter say that it is a state, and not what is computed with it.
    fn says_state(&self, name: Option<&str>, ty: &Ty) -> i32 {
        let of_type = match ty.peel() {
            Ty::Adt(id, _) => self.program.index.type_def(*id).name.as_str(),
            Ty::External(path, _) => path.rsplit("::").next().unwrap_or(path),
            _ => "",
        };
        let is_said = |name: &str| words(name).iter().any(|word| is_among(STATES, word));
        2 * i32::from(is_said(of_type) || name.is_some_and(is_said) || type_strength(of_type) == 2)
    }

    /// Types of unread crates with the name of a filter, and the methods called on them that have the name of a law.
    pub(super) fn find_outside(&mut self) {
        let index = self.program.index;
        let mut found: BTreeMap<String, Seen> = BTreeMap::new();
        for id in index.function_ids() {
            let def = index.function(id);
            let (Some(body), Some(typed)) = (&def.function.body, self.program.typed(id)) else { continue };
            if is_test(index, def) || !self.is_in_scope(def.module) {
                continue;
            }
            let loops = loops(body);
            for expr in &body.exprs {
                let ExprKind::MethodCall { receiver, method, args, .. } = &expr.kind else { continue };
                let ty = typed.ty(*receiver).peel();
                let Ty::External(path, _) = ty else { continue };
                // By `use somewhere::*`, nobody can say where.
                let has_place = !path.starts_with('?');
                if !has_place || !is_outside_law(ty, "update") || index.law_spec(ty).is_some() {
                    continue;
                }
                let seen = found.entry(path.clone()).or_default();
                // What is given a function is set up with it.
                let takes_function = args.iter().any(|arg| is_function(body, typed, *arg));
                if is_outside_law(ty, method) && !takes_function {
                    seen.is_timed |= args.iter().any(|arg| is_step(body, typed, *arg));
                    let called = seen.methods.entry(method.clone()).or_default();
                    called.is_fed |= !args.is_empty();
                    called.uses.calls += 1;
                    called.uses.in_cycles += usize::from(loops.iter().any(|own| own.contains(expr.span)));
                } else if matches!(method.as_str(), "reset" | "clear" | "restart") {
                    seen.resets.insert(method.clone());
                } else if method.starts_with("reset_") {
                    seen.partial_resets.insert(method.clone());
                }
            }
        }
        for (path, Seen { mut methods, resets, partial_resets, is_timed }) in found {
            // `svf.update()` beside `svf.process(sample)` computes anew what follows from the settings.
            let is_fed = methods.values().any(|called| called.is_fed);
            methods.retain(|name, called| called.is_fed || !is_fed || !name.starts_with("update"));
            if methods.is_empty() {
                continue;
            }
            let uses = methods.values().fold(Uses::default(), |uses, called| uses.and(called.uses));
            let methods: Vec<String> = methods.into_keys().collect();
            let name = path.rsplit("::").next().unwrap_or(&path).to_owned();
            let is_law = methods.iter().any(|method| law_strength(method) == 2);
            self.found.push(Found {
                path: Some(path),
                // Nothing of it was read, so that it has no place.
                place: Span::new(FileId(0), 0, 0),
                draft: Draft {
                    subject: Subject::Type,
                    law: groups(&methods, &[]),
                    instance: InstancePlace::Receiver,
                    receiver: Receiver::Exclusive,
                    resets: resets.into_iter().collect(),
                    partial_resets: partial_resets.into_iter().collect(),
                    key: None,
                    time_base: if is_timed { TimeBase::Passed } else { TimeBase::Fixed },
                    reasons: vec![Reason::Unread(name.clone(), methods)],
                    uses,
                    weight: LEAST_WEIGHT + i32::from(is_law) + i32::from(uses.in_cycles > 0),
                    is_plain: false,
                },
                name,
                laws: Vec::new(),
            });
        }
    }
}

/// What is called on a type of an unread crate.
#[derive(Default)]
struct Seen {
    methods: BTreeMap<String, Called>,
    resets: BTreeSet<String>,
    partial_resets: BTreeSet<String>,
    is_timed: bool,
}

/// How a method is called.
#[derive(Default)]
struct Called {
    uses: Uses,
    /// Whether it is given anything.
    is_fed: bool,
}

/// Whether an argument is a closure, or a function by its name.
fn is_function(body: &Body, typed: &TypedBody, arg: ExprId) -> bool {
    matches!(body.expr(arg).kind, ExprKind::Closure(_)) || matches!(typed.ty(arg), Ty::FunctionItem(_))
}

/// Whether an argument has the name of a time step: `dt`, `self.dt`, `elapsed as f64`.
fn is_step(body: &Body, typed: &TypedBody, arg: ExprId) -> bool {
    match &body.expr(arg).kind {
        ExprKind::Cast { value, .. } | ExprKind::Reference { value, .. } => is_step(body, typed, *value),
        ExprKind::MethodCall { receiver, args, .. } if args.is_empty() => is_step(body, typed, *receiver),
        ExprKind::Field { name, .. } => is_time_name(name),
        _ => typed.expr_local.get(&arg).is_some_and(|local| is_time_name(&typed.local(*local).name)),
    }
}

/// Words in the names of states, and of their types.
const STATES: &str = "state states history memory filter";

/// Whether a field of that name holds what was there before.
fn is_old(field: &str) -> bool {
    words(field).iter().any(|word| matches!(word.as_str(), "prev" | "previous" | "last" | "old"))
}

/// Whether a state can be of the type: a number, or something of the analysed code.
fn is_state(index: &crate::index::Index, ty: &Ty) -> bool {
    matches!(ty, Ty::Adt(..)) || is_measured(index, ty, 0)
}
