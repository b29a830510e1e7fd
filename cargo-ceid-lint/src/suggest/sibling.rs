//! A missed sibling put in the place of the filter that is updated twice: a line that was pasted and not changed in full.

use std::collections::BTreeSet;
use std::ops::Range;

use super::free::is_free;
use super::site::{Site, bytes};
use crate::count::Pair;
use crate::diagnostic::{Applicability, Suggestion};
use crate::index::{Shape, Ty, TypeId};
use crate::syntax::tree::{Expr, ExprId, ExprKind, Field, PatId, PatKind, StmtKind};
use crate::types::LocalId;

type Edits = Vec<(Range<usize>, String)>;

/// An update of the filter that is written as the filter is named.
struct Call<'a> {
    receiver: ExprId,
    args: &'a [ExprId],
}

/// Where a name is declared among its siblings, and what has to change there.
struct Declared {
    order: usize,
    edits: Edits,
    /// The types of numbers that a generic variable is declared with: `f32` in `Lag::<f32>::new()`.
    numbers: BTreeSet<String>,
}

/// The receivers changed to the siblings that the cycle misses.
///
/// With one update for each of them, they are given out as they are declared; with more updates than that, only one sibling is put
/// in, where the arguments speak of it.
pub(super) fn suggestion(site: &Site<'_>, pair: &Pair, missed: &[String]) -> Option<Suggestion> {
    let calls = calls(site, pair);
    let receiver = calls.first()?.receiver;
    let mut names: Vec<(&str, Declared)> = vec![(&pair.name, declared(site, receiver, &pair.name)?)];
    for name in missed {
        names.push((name, declared(site, receiver, name)?));
    }
    names.sort_by_key(|(_, declared)| declared.order);
    let all: Vec<&str> = names.iter().map(|(name, _)| *name).collect();
    let is_alike = names.iter().all(|(_, own)| own.numbers == names[0].1.numbers);
    if calls.len() != all.len() || !is_alike {
        return None;
    }
    let given = given_out(site, &calls, &all)?;
    let mut edits: Edits =
        names.iter().filter(|(name, _)| *name != pair.name).flat_map(|(_, own)| own.edits.clone()).collect();
    let changed = calls.iter().zip(&given).filter(|(_, name)| **name != pair.name);
    edits.extend(changed.map(|(call, name)| (bytes(site.body.expr(call.receiver).span), (*name).to_owned())));
    let missed: Vec<String> = missed.iter().map(|name| format!("`{name}`")).collect();
    // What is written is told behind the message, if it is one word; that of another line is named with it.
    let here = bytes(site.place);
    let message = match edits.as_slice() {
        [(changed, _)] if here.contains(&changed.start) => "update the sibling that is missed here".to_owned(),
        _ => format!("update {} where `{}` is written once too often", missed.join(" and "), pair.name),
    };
    Some(site.suggestion(message, edits, Applicability::MaybeIncorrect))
}

/// The updates of the filter in the order of the text, if each is written as the filter is named.
fn calls<'a>(site: &Site<'a>, pair: &Pair) -> Vec<Call<'a>> {
    let is_update = |expr: &&Expr| pair.through.is_empty() && pair.updates.contains(&expr.span);
    let of_law = |expr: &'a Expr| match &expr.kind {
        ExprKind::MethodCall { receiver, args, .. } if site.spelled(*receiver) == pair.name => {
            Some(Call { receiver: *receiver, args })
        }
        _ => None,
    };
    let mut calls: Vec<Call<'a>> = site.body.exprs.iter().filter(is_update).filter_map(of_law).collect();
    calls.sort_by_key(|call| site.body.expr(call.receiver).span.start);
    calls.dedup_by_key(|call| site.body.expr(call.receiver).span);
    let is_whole = calls.len() == pair.updates.len();
    let is_written = |call: &Call<'_>| {
        let start = site.body.expr(call.receiver).span.start as usize;
        !site.is_in_macro(start)
    };
    if is_whole && calls.iter().all(is_written) { calls } else { Vec::new() }
}

/// The name for each call: that which its arguments speak of, and what is left in the order of the declarations.
fn given_out<'n>(site: &Site<'_>, calls: &[Call<'_>], names: &[&'n str]) -> Option<Vec<&'n str>> {
    let mut given: Vec<Option<&str>> = Vec::new();
    for call in calls {
        let spoken: Vec<&str> = names.iter().filter(|name| is_spoken_of(site, call, name, names)).copied().collect();
        given.push(match spoken.as_slice() {
            [one] => Some(*one),
            _ => None,
        });
    }
    let mut left = names.iter().filter(|name| !given.contains(&Some(**name)));
    let mut all = Vec::new();
    for name in &given {
        all.push(match name {
            Some(name) => *name,
            None => *left.next()?,
        });
    }
    // Two calls that speak of the same one are no pasted line.
    let is_each_once = names.iter().all(|name| all.iter().filter(|given| *given == name).count() == 1);
    is_each_once.then_some(all)
}

/// Whether the arguments hold a word of a name that no other of the names has: `left` for `left_in` beside `right_in`.
fn is_spoken_of(site: &Site<'_>, call: &Call<'_>, name: &str, names: &[&str]) -> bool {
    let others: Vec<&str> = names.iter().filter(|other| **other != name).flat_map(|other| parts(other)).collect();
    let own: Vec<&str> = parts(name).filter(|part| part.len() > 1 && !others.contains(part)).collect();
    let said = call.args.iter().map(|arg| site.snippet(site.body.expr(*arg).span));
    said.flat_map(parts).any(|part| own.contains(&part))
}

/// The words that names are made of.
fn parts(text: &str) -> impl Iterator<Item = &str> {
    text.split(|letter: char| !letter.is_alphanumeric()).filter(|part| !part.is_empty())
}

/// Where a filter is declared that can stand in the place of the receiver.
fn declared(site: &Site<'_>, receiver: ExprId, name: &str) -> Option<Declared> {
    match &site.body.expr(receiver).kind {
        ExprKind::Path(_) => local(site, receiver, name),
        ExprKind::Field { base, name: own } => {
            let field = name.strip_prefix(&site.spelled(*base))?.strip_prefix('.')?;
            let owner = site.typed.ty(*base).peel();
            let ty = site.program.index.field_ty(owner, None, field)?;
            let Ty::Adt(id, _) = owner else { return None };
            let Shape::Struct(fields) = &site.program.index.type_def(*id).shape else { return None };
            let order = fields.fields.iter().position(|own| own.name == field)?;
            if !is_usable(site, *id, &fields.fields, order) {
                return None;
            }
            // As types of the analysis, those of `f32` and `f64` are one.
            let is_alike = fields.fields.iter().any(|of| of.name == *own && of.ty == fields.fields[order].ty);
            let is_it = is_alike && ty == *site.typed.ty(receiver) && !is_shared(&ty);
            is_it.then_some(Declared { order, edits: Vec::new(), numbers: BTreeSet::new() })
        }
        ExprKind::Index { base, .. } => {
            let index = name.strip_prefix(&site.spelled(*base))?.strip_prefix('[')?.strip_suffix(']')?;
            let is_array = matches!(site.typed.ty(*base).peel(), Ty::Array(..));
            let order = index.parse().ok().filter(|_| is_array)?;
            Some(Declared { order, edits: Vec::new(), numbers: BTreeSet::new() })
        }
        _ => None,
    }
}

/// Whether a field is there in all builds, and the function sees it.
fn is_usable(site: &Site<'_>, owner: TypeId, fields: &[Field], order: usize) -> bool {
    let own = fields[order].span;
    let begin = match order.checked_sub(1) {
        Some(before) => fields[before].span.end,
        None => site.program.index.type_def(owner).span.end,
    };
    let text = &site.program.sources.file(own.file).text;
    // The type of the field before it, its own attributes, and whether it is public.
    let Some(above) = text.get(begin as usize..own.start as usize) else { return false };
    let is_public = || above.rsplit([',', '{']).next().is_some_and(|own| own.trim_start().starts_with("pub"));
    !above.contains("cfg") && (site.module == site.program.index.type_def(owner).module || is_public())
}

fn is_shared(ty: &Ty) -> bool {
    matches!(ty, Ty::Ref(false, _))
}

/// A variable that can be updated at the site, perhaps with a `mut` where it is declared.
fn local(site: &Site<'_>, receiver: ExprId, name: &str) -> Option<Declared> {
    let named = site.typed.pat_local.iter().filter(|(_, local)| site.typed.local(**local).name == name);
    let declared: Vec<(PatId, LocalId)> = named.map(|(pat, local)| (*pat, *local)).collect();
    // Of two variables with one name, the one that is meant would have to be found.
    let [(pat, local)] = declared.as_slice() else { return None };
    let ty = &site.typed.local(*local).ty;
    let is_it = site.typed.expr_local.get(&receiver) == Some(local);
    if !is_it && !is_free(site, receiver, *local) {
        return None;
    }
    if ty.peel() != site.typed.ty(receiver).peel() || is_shared(ty) || !is_visible(site, *pat) {
        return None;
    }
    let own = site.body.pat(*pat);
    let PatKind::Bind { by_ref: false, mutable, sub: None, .. } = own.kind else { return None };
    let start = own.span.start as usize;
    let is_written = site.snippet(own.span).split_whitespace().next_back() == Some(name);
    let needs_mut = !mutable && !matches!(ty, Ty::Ref(..));
    let edits = if needs_mut { vec![(start..start, "mut ".to_owned())] } else { Vec::new() };
    let lets = site
        .body
        .exprs
        .iter()
        .filter_map(|expr| if let ExprKind::Block(block) = &expr.kind { Some(block) } else { None });
    let mut lets = lets.flat_map(|block| &block.stmts);
    let declaration = lets.find(|stmt| matches!(stmt.kind, StmtKind::Let { pat: whole, .. } if whole == *pat));
    let numbers = declaration.map_or_else(BTreeSet::new, |stmt| numbers(ty, site.snippet(stmt.span)));
    is_written.then_some(Declared { order: start, edits, numbers })
}

/// The types of numbers that are named where something of a generic type is declared.
fn numbers(ty: &Ty, declaration: &str) -> BTreeSet<String> {
    let is_generic = matches!(ty.peel(), Ty::Adt(_, args) if !args.is_empty());
    let is_number = |word: &&str| {
        let width = word.strip_prefix(['f', 'i', 'u']);
        width.is_some_and(|width| {
            width == "size" || !width.is_empty() && width.chars().all(|digit| digit.is_ascii_digit())
        })
    };
    let words = declaration.split(|letter: char| !(letter.is_alphanumeric() || letter == '_'));
    words.filter(is_number).filter(|_| is_generic).map(str::to_owned).collect()
}

/// Whether a pattern binds its names for the site: it is a parameter, or a `let` before it in a block around it.
fn is_visible(site: &Site<'_>, pat: PatId) -> bool {
    let place = site.place;
    let holds = |outer: PatId| outer == pat || site.body.pat(outer).span.contains(site.body.pat(pat).span);
    let is_let_before = site.body.exprs.iter().filter(|expr| expr.span.contains(place)).any(|expr| match &expr.kind {
        ExprKind::Block(block) => block
            .stmts
            .iter()
            .any(|stmt| matches!(stmt.kind, StmtKind::Let { pat, .. } if holds(pat)) && stmt.span.end <= place.start),
        _ => false,
    });
    is_let_before || site.body.params.iter().any(|param| holds(*param))
}
