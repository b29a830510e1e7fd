//! Choices that do nothing any more once the updates are gone: `if ready { kf.update() } else { kf.update() }`.
//! What their conditions do beside choosing stays, and so do their comments.

use std::collections::BTreeSet;
use std::ops::Range;

use super::body::LoopBody;
use super::mentions::Guarded;
use super::narrowed::narrowed;
use super::purity::acts_when_dropped;
use super::text::{with_attributes, without_comments, words};
use crate::index::Ty;
use crate::syntax::tree::{Block, BlockKind, ExprId, ExprKind, Literal, PatKind, Stmt, StmtKind};
use crate::types::{Callee, LocalId};

/// A part of the text that goes, and what stands there instead.
#[derive(Clone, Debug)]
pub(super) struct Cut {
    pub(super) range: Range<usize>,
    pub(super) instead: String,
    /// Whether it is a whole statement, whose line goes with it.
    pub(super) is_statement: bool,
}

impl Cut {
    pub(super) fn text(range: Range<usize>, instead: &str) -> Self {
        Self { range, instead: instead.to_owned(), is_statement: false }
    }

    fn statement(range: Range<usize>) -> Self {
        Self { range, instead: String::new(), is_statement: true }
    }

    /// Whether an edit of these bytes would change what goes.
    pub(super) fn swallows(&self, range: &Range<usize>) -> bool {
        self.range.start <= range.start && range.end <= self.range.end && self.range != *range
    }
}

/// What goes of the choices that the updates leave without anything to do.
pub(super) fn cuts(of: &LoopBody<'_>, guarded: &[Guarded]) -> Vec<Cut> {
    let sites = guarded.iter().flat_map(|own| &own.sites).filter(|site| site.stmt.is_some());
    let held = guarded.iter().map(|own| own.place.local).collect();
    let hollow = Hollow { of, gone: sites.map(|site| site.gone).collect(), held };
    let choices: Vec<ExprId> = of.inside.iter().copied().filter(|id| hollow.is_choice(*id)).collect();
    let mut cuts = Vec::new();
    let mut conditions = Vec::new();
    let is_inner = |id: ExprId| of.ancestors_inside(id).any(|around| choices.contains(&around));
    for choice in choices.iter().copied().filter(|id| !is_inner(*id)) {
        let Some(range) = hollow.statement(choice) else { continue };
        match hollow.left(choice) {
            Left::Nothing => {
                conditions.push(range.clone());
                cuts.push(Cut::statement(range));
            }
            Left::First(condition) => {
                let kept = of.span(condition);
                let parts = [(range.start..kept.start as usize, "let _ = "), (kept.end as usize..range.end, ";")];
                conditions.extend(parts.iter().map(|(part, _)| part.clone()));
                cuts.extend(parts.map(|(part, instead)| Cut::text(part, instead)));
            }
            Left::All => {}
        }
    }
    let around: Vec<Range<usize>> = cuts.iter().map(|cut| cut.range.clone()).collect();
    let is_cut = |id: ExprId| around.iter().any(|range| range.contains(&(of.span(id).start as usize)));
    for id in of.inside.iter().copied().filter(|id| !is_cut(*id)) {
        cuts.extend(hollow.turned(id));
        let does_nothing = |arm: ExprId| hollow.gone.contains(&arm) || hollow.is_nothing(arm);
        if hollow.had_update(id) {
            cuts.extend(narrowed(of, id, &does_nothing));
        }
    }
    hollow.unused(&conditions, &mut cuts);
    cuts
}

/// What is left of a choice.
enum Left {
    Nothing,
    /// Its first condition, which does something.
    First(ExprId),
    All,
}

struct Hollow<'a> {
    of: &'a LoopBody<'a>,
    /// What goes without them.
    gone: BTreeSet<ExprId>,
    /// The variables that the guard holds.
    held: BTreeSet<LocalId>,
}

impl Hollow<'_> {
    /// Whether an expression is a choice that chooses between nothing and nothing, because an update went.
    fn is_choice(&self, id: ExprId) -> bool {
        let had_update = || self.had_update(id);
        match self.of.kind(id) {
            ExprKind::If { then, otherwise, .. } => {
                had_update()
                    && self.is_nothing(*then)
                    && otherwise
                        .is_none_or(|otherwise| self.is_nothing(otherwise) || self.is_choice_or_empty(otherwise))
            }
            ExprKind::Match { arms, .. } => {
                let does_nothing = |id: ExprId| self.gone.contains(&id) || self.is_nothing(id);
                had_update() && arms.iter().all(|arm| arm.cfg.is_none() && does_nothing(arm.body))
            }
            // A block of its own that held nothing but updates.
            ExprKind::Block(Block { label: None, kind: BlockKind::Plain, .. }) => {
                self.of.statement(id).is_some() && had_update() && self.is_nothing(id) && self.nested(id).is_empty()
            }
            _ => false,
        }
    }

    /// Whether an update that goes lies in an expression.
    fn had_update(&self, id: ExprId) -> bool {
        self.gone.iter().any(|gone| self.of.ancestors_inside(*gone).any(|around| around == id))
    }

    /// Whether an `else if` does nothing, whether or not it had an update.
    fn is_choice_or_empty(&self, id: ExprId) -> bool {
        match self.of.kind(id) {
            ExprKind::If { then, otherwise, .. } => {
                self.is_nothing(*then)
                    && otherwise
                        .is_none_or(|otherwise| self.is_nothing(otherwise) || self.is_choice_or_empty(otherwise))
            }
            _ => false,
        }
    }

    /// Whether a branch does nothing once the updates are gone.
    fn is_nothing(&self, branch: ExprId) -> bool {
        let ExprKind::Block(block) = self.of.kind(branch) else { return false };
        let written = self.of.written(branch);
        written.starts_with('{')
            && without_comments(written) == written
            && block.items.is_empty()
            && block.stmts.iter().all(|stmt| self.goes(stmt))
            && block.tail.is_none_or(|tail| self.is_gone(tail))
    }

    fn goes(&self, stmt: &Stmt) -> bool {
        let is_discarded = |init: ExprId| self.of.statement(init).is_some() && self.gone.contains(&init);
        stmt.cfg.is_none()
            && match stmt.kind {
                StmtKind::Expr { expr, .. } => self.is_gone(expr),
                StmtKind::Let { init: Some(init), otherwise: None, .. } => is_discarded(init),
                StmtKind::Let { .. } => false,
            }
    }

    fn is_gone(&self, id: ExprId) -> bool {
        self.gone.contains(&id) || self.is_choice(id) && self.effects(id).is_empty()
    }

    /// The text of the statement that a choice is.
    fn statement(&self, choice: ExprId) -> Option<Range<usize>> {
        let of = self.of;
        let (block, stmt) = of.statement(choice)?;
        // The block around a lone choice would be left without anything to do as well, and be no statement of its own.
        let range = match stmt {
            Some(Stmt { cfg: Some(_), .. } | Stmt { kind: StmtKind::Let { .. }, .. }) => return None,
            Some(stmt) => stmt.span.start as usize..stmt.span.end as usize,
            None if block.tail == Some(choice) => of.span(choice).start as usize..of.span(choice).end as usize,
            None => return None,
        };
        let written = of.text.get(range.clone())?;
        let is_whole = ["if", "match", "{"].iter().any(|begin| written.starts_with(begin));
        let has_attributes = with_attributes(of.text, range.start) != range.start;
        (is_whole && !has_attributes && without_comments(written) == written).then_some(range)
    }

    fn left(&self, choice: ExprId) -> Left {
        let of = self.of;
        let conditions = self.conditions(choice);
        if self.effects(choice).is_empty() && self.are_named_elsewhere(choice, &conditions) {
            return Left::Nothing;
        }
        let [condition, others @ ..] = conditions.as_slice() else { return Left::All };
        if !others.iter().all(|id| self.only_asks(*id)) || !self.are_named_elsewhere(choice, others) {
            return Left::All;
        }
        let value = match of.kind(*condition) {
            ExprKind::Let { value, .. } => *value,
            _ => *condition,
        };
        let is_plain = !of.body.within(value).any(|id| matches!(of.kind(id), ExprKind::Let { .. }));
        let span = of.span(value);
        let before = of.text.get(of.span(choice).start as usize..span.start as usize);
        // In brackets, or behind a pattern with some.
        let is_bare = before.is_some_and(|before| before == "if " || before == "match " || before.ends_with("= "));
        if is_plain && is_bare { Left::First(value) } else { Left::All }
    }

    /// What a choice asks, in the order in which it does.
    fn conditions(&self, choice: ExprId) -> Vec<ExprId> {
        match self.of.kind(choice) {
            ExprKind::If { condition, then, otherwise } => {
                let mut found = vec![*condition];
                found.extend(self.nested(*then));
                found.extend(otherwise.iter().flat_map(|otherwise| self.conditions(*otherwise)));
                found
            }
            ExprKind::Match { scrutinee, arms } => {
                let of_arms = arms.iter().flat_map(|arm| arm.guard.into_iter().chain(self.nested(arm.body)));
                std::iter::once(*scrutinee).chain(of_arms).collect()
            }
            _ => self.nested(choice),
        }
    }

    /// What the choices in a branch ask.
    fn nested(&self, branch: ExprId) -> Vec<ExprId> {
        let ExprKind::Block(Block { stmts, tail, .. }) = self.of.kind(branch) else { return Vec::new() };
        let exprs = stmts.iter().filter_map(|stmt| match stmt.kind {
            StmtKind::Expr { expr, .. } => Some(expr),
            StmtKind::Let { .. } => None,
        });
        let choices = exprs.chain(*tail).filter(|id| !self.gone.contains(id));
        choices.flat_map(|id| self.conditions(id)).collect()
    }

    /// The conditions of a choice that do something, or may panic.
    fn effects(&self, choice: ExprId) -> Vec<ExprId> {
        self.conditions(choice).into_iter().filter(|id| !self.only_asks(*id)).collect()
    }

    /// Whether nothing but the value of an expression is lost with it.
    fn only_asks(&self, id: ExprId) -> bool {
        let of = self.of;
        let asks = |id: ExprId| self.only_asks(id);
        match of.kind(id) {
            ExprKind::Path(_) => !matches!(of.typed.callees.get(&id), Some(Callee::Resolved(_))),
            ExprKind::Literal(_) => true,
            ExprKind::Deref(value) => asks(*value) && matches!(of.typed.ty(*value), Ty::Ref(..)),
            ExprKind::Field { base, .. } => asks(*base) && !matches!(of.typed.ty(*base).peel(), Ty::External(..)),
            ExprKind::Reference { value, .. } | ExprKind::Not(value) => asks(*value) && is_plain(of.typed.ty(*value)),
            ExprKind::Let { value, .. } => {
                asks(*value) && !acts_when_dropped(of.program.index, of.typed.ty(*value).peel())
            }
            ExprKind::Binary { op, lhs, rhs } => {
                let are_plain = is_plain(of.typed.ty(*lhs)) && is_plain(of.typed.ty(*rhs));
                let is_total = match *op {
                    "&&" | "||" | "==" | "!=" | "<" | "<=" | ">" | ">=" | "&" | "|" | "^" => true,
                    "%" | "/" => matches!(of.kind(*rhs), ExprKind::Literal(Literal::Int(Some(1..), _))),
                    "+" | "-" | "*" => *of.typed.ty(*lhs) == Ty::Float,
                    _ => false,
                };
                let is_logic = matches!(*op, "&&" | "||");
                asks(*lhs) && asks(*rhs) && is_total && (is_logic || are_plain)
            }
            ExprKind::MethodCall { receiver, method, args, .. } => {
                let asked = ["is_some", "is_none", "is_ok", "is_err", "is_empty", "is_nan", "is_finite", "len", "abs"];
                let is_known = matches!(of.typed.callees.get(&id), Some(Callee::Builtin | Callee::External(_)));
                asks(*receiver) && args.is_empty() && is_known && asked.contains(&method.as_str())
            }
            _ => false,
        }
    }

    /// Whether nothing would be without a use if the choice went, beside variables of the iteration.
    fn are_named_elsewhere(&self, choice: ExprId, conditions: &[ExprId]) -> bool {
        let of = self.of;
        let span = of.span(choice);
        let is_outside = |id: &ExprId| !span.contains(of.span(*id));
        let all = conditions.iter().flat_map(|condition| of.body.within(*condition));
        let count = |name: &str, is_it: &dyn Fn(&str) -> bool| -> usize {
            let in_file = |text: &str| words(text, name).filter(|at| is_it(&text[..*at])).count();
            let all: usize = of.program.sources.files().map(|(_, file)| in_file(&file.text)).sum();
            all.saturating_sub(of.text.get(span.start as usize..span.end as usize).map_or(0, in_file))
        };
        all.filter(|id| matches!(of.kind(*id), ExprKind::Path(_) | ExprKind::Field { .. })).all(|id| {
            match (of.typed.expr_local.get(&id), of.kind(id)) {
                (Some(local), _) => {
                    let is_used = of.typed.expr_local.iter().any(|(at, other)| other == local && is_outside(at));
                    is_used || self.held.contains(local) || self.declared(*local).is_some()
                }
                (None, ExprKind::Field { name, .. }) => {
                    name.starts_with(|sign: char| sign.is_ascii_digit())
                        || count(name, &|before| before.ends_with('.')) > 0
                }
                (None, ExprKind::Path(path)) => count(path.last(), &|_| true) > 1,
                _ => true,
            }
        })
    }

    /// The statement of the iteration that declares a variable, with its value.
    fn declared(&self, local: LocalId) -> Option<(&Stmt, ExprId)> {
        let of = self.of;
        let blocks = of.inside.iter().filter_map(|id| match of.kind(*id) {
            ExprKind::Block(block) => Some(block),
            _ => None,
        });
        blocks.flat_map(|block| &block.stmts).find_map(|stmt| match &stmt.kind {
            StmtKind::Let { pat, init: Some(init), otherwise: None, .. } => {
                let is_plain =
                    matches!(of.body.pat(*pat).kind, PatKind::Bind { by_ref: false, mutable: false, sub: None, .. });
                let is_it = is_plain && of.typed.pat_local.get(pat) == Some(&local) && stmt.cfg.is_none();
                is_it.then_some((stmt, *init))
            }
            _ => None,
        })
    }

    /// Takes the variables away that only what goes has used, or their names.
    fn unused(&self, conditions: &[Range<usize>], cuts: &mut Vec<Cut>) {
        let of = self.of;
        let mut gone: Vec<Range<usize>> = conditions.to_vec();
        let mut at = 0;
        while let Some(range) = gone.get(at).cloned() {
            at += 1;
            let is_in = |id: ExprId, range: &Range<usize>| range.contains(&(of.span(id).start as usize));
            let named = of.inside.iter().filter(|id| is_in(**id, &range));
            let locals: BTreeSet<LocalId> = named.filter_map(|id| of.typed.expr_local.get(id)).copied().collect();
            for local in locals {
                let own = of.typed.local(local);
                let mut uses = of.typed.expr_local.iter().filter(|(_, other)| **other == local).map(|(id, _)| *id);
                let is_mentioned = |id: &ExprId| match of.kind(*id) {
                    ExprKind::Opaque(call) => call.mentions.contains(&own.name),
                    ExprKind::Unknown { mentions, .. } => mentions.contains(&own.name),
                    _ => false,
                };
                let is_used =
                    uses.any(|id| !gone.iter().any(|range| is_in(id, range))) || of.inside.iter().any(is_mentioned);
                let Some((stmt, init)) = self.declared(local).filter(|_| !is_used && !own.name.starts_with('_')) else {
                    continue;
                };
                let whole = stmt.span.start as usize..stmt.span.end as usize;
                let name = own.span.start as usize..own.span.end as usize;
                if self.only_asks(init) && self.are_named_elsewhere(init, &[init]) {
                    gone.push(whole.clone());
                    cuts.push(Cut::statement(with_attributes(of.text, whole.start)..whole.end));
                } else if is_plain(&own.ty) {
                    cuts.push(Cut::text(name, "_"));
                } else {
                    cuts.push(Cut::text(name.start..name.start, "_"));
                }
            }
        }
    }

    /// The `if` of an empty branch and an `else`, turned round where that reads as well.
    fn turned(&self, id: ExprId) -> Vec<Cut> {
        let of = self.of;
        let ExprKind::If { condition, then, otherwise: Some(otherwise) } = of.kind(id) else { return Vec::new() };
        if !matches!(of.kind(*otherwise), ExprKind::Block(_)) || !self.is_nothing(*then) || self.is_nothing(*otherwise)
        {
            return Vec::new();
        }
        let (asked, then, rest) = (of.span(*condition), of.span(*then), of.span(*otherwise));
        let between = of.text.get(then.end as usize..rest.start as usize).map(str::trim);
        let gap = of.text.get(asked.end as usize..then.start as usize).map(str::trim);
        let is_bare = of.text.get(of.span(id).start as usize..asked.start as usize) == Some("if ");
        if between != Some("else") || gap != Some("") || !is_bare {
            return Vec::new();
        }
        let not = |at: u32| Cut::text(at as usize..at as usize, "!");
        let turned = match of.kind(*condition) {
            ExprKind::Not(value) => Cut::text(asked.start as usize..of.span(*value).start as usize, ""),
            ExprKind::Path(_) | ExprKind::Field { .. } | ExprKind::Call { .. } | ExprKind::MethodCall { .. } => {
                not(asked.start)
            }
            ExprKind::Binary { op, lhs, rhs } => {
                let are_whole = *of.typed.ty(*lhs) == Ty::Int && *of.typed.ty(*rhs) == Ty::Int;
                let opposite = match *op {
                    "==" => "!=",
                    "!=" => "==",
                    "<" if are_whole => ">=",
                    ">=" if are_whole => "<",
                    ">" if are_whole => "<=",
                    "<=" if are_whole => ">",
                    _ => return Vec::new(),
                };
                let written = of.span(*lhs).end as usize..of.span(*rhs).start as usize;
                let operator = of.text.get(written.clone()).filter(|text| text.trim() == *op);
                let Some(operator) = operator else { return Vec::new() };
                Cut::text(written, &operator.replace(op, opposite))
            }
            _ => return Vec::new(),
        };
        vec![turned, Cut::text(asked.end as usize..rest.start as usize, " ")]
    }
}

/// Whether the operators of a type only calculate.
fn is_plain(ty: &Ty) -> bool {
    matches!(ty.peel(), Ty::Int | Ty::Float | Ty::Bool | Ty::Char)
}
