//! Patterns: what they ask, and what their names then mean.

use std::rc::Rc;

use std::sync::Arc;

use super::numbers::limit_of_type;
use super::parts::given_to;
use super::subjects::{Pure, pure_place};
use super::{Builder, Value};
use crate::flow::{About, Assignment, Effect, Head, IndexKey, Mark, NodeId, Place, Section, Test, Transfer, Var};
use crate::index::{Def, Shape, Ty};
use crate::source::Span;
use crate::syntax::tree::{Arm, ExprId, ExprKind, PatId, PatKind};
use crate::types::LocalId;

/// What is matched: its value, and what tells it from other values.
#[derive(Clone, Debug)]
struct Matched {
    value: Value,
    pure: Option<Pure>,
    total: Option<Rc<[Head]>>,
    about: About,
    text: String,
    span: Option<Span>,
    /// The expression, if it is one of the source.
    expr: Option<ExprId>,
    ty: Ty,
}

impl Builder<'_> {
    pub(super) fn match_expr(&mut self, id: ExprId, scrutinee: ExprId, arms: &[Arm]) -> Value {
        let span = self.span(id);
        if let Some((holds, fails)) = self.as_condition(scrutinee, arms) {
            return self.if_expr(id, scrutinee, holds, Some(fails));
        }
        let (matched, emptied) = self.matched(scrutinee);
        if self.at.is_none() {
            return Value::default();
        }
        let join = super::values::Join { chooses: Some(id), ..self.new_join(self.ty(id).clone(), span) };
        let is_answer = matched.about.names.iter().any(|name| super::received::asks_state(name));
        let is_awaited = matched.about.is_awaited && !is_answer && self.is_choice(self.ty(scrutinee));
        let is_select = is_event_source(&matched.about) || is_awaited;
        for (number, arm) in arms.iter().enumerate() {
            let next = self.add_node(Effect::Nothing, span);
            if let Some(cfg) = &arm.cfg {
                let (present, absent) = self.branch_on_cfg(cfg, self.body().pat(arm.pat).span);
                self.link(absent, next);
                self.resume(present);
            }
            let mut own = matched.clone();
            own.about.is_event |= is_select;
            self.derive_pattern(arm.pat, scrutinee);
            self.note_handed(arm.pat);
            own.span = Some(self.body().pat(arm.pat).span);
            own.text = format!("{} is {}", matched.text, self.pattern_text(arm.pat));
            self.open_block();
            let bound_from = self.graph.nodes.len();
            self.test_pattern(arm.pat, &own, next);
            self.leave_by_arm(arm.pat, scrutinee, &own.value, span);
            if matches!(self.body().pat(arm.pat).kind, PatKind::Bind { .. }) {
                self.note_copy(scrutinee);
            }
            if let Some(guard) = arm.guard {
                let moved = self.moved_since(bound_from);
                let first = self.graph.nodes.len();
                let failed = self.add_node(Effect::Nothing, span);
                self.condition(guard, if moved.is_empty() { next } else { failed });
                self.move_back(moved, failed, next, span);
                for node in &mut self.graph.nodes[first..] {
                    if let Effect::Branch(test) = &mut node.effect {
                        test.about.is_guard = true;
                    }
                }
            }
            if self.at.is_some() {
                self.emit(Effect::Mark(Mark::Arm), self.body().pat(arm.pat).span);
                if let Some(option) = emptied.clone() {
                    self.emptied(option, self.span(scrutinee));
                    self.note_pointed(self.ty(scrutinee));
                }
            }
            let value = self.expr(arm.body);
            self.note_written_field(arm.body, &mut super::changes::WrittenFields::new(), self.span(arm.body));
            let moved = self.moved_guard(&value);
            self.close_block_without(moved, self.span(arm.body));
            self.end_branch_of(&join, &value, Some(arm.body), self.span(arm.body));
            self.resume_if_reached(next);
            if number + 1 == arms.len() && self.at.is_some() {
                // A match has an arm for every value.
                self.emit(Effect::End, span);
                self.at = None;
            }
        }
        self.close_join(&join)
    }

    /// What a `match` does where a condition holds, and where it does not: `match !armed { true => …, false => … }`.
    fn as_condition(&self, scrutinee: ExprId, arms: &[Arm]) -> Option<(ExprId, ExprId)> {
        let is_asked = match &self.body().expr(scrutinee).kind {
            ExprKind::Not(_) | ExprKind::Binary { op: "==" | "!=" | "<" | "<=" | ">" | ">=", .. } => true,
            ExprKind::MethodCall { method, .. } => {
                matches!(method.as_str(), "is_some" | "is_none" | "is_ok" | "is_err" | "is_empty")
            }
            _ => false,
        };
        let [first, second] = arms else { return None };
        let is_plain = |arm: &Arm| arm.guard.is_none() && arm.cfg.is_none();
        if !is_asked || *self.ty(scrutinee) != Ty::Bool || !is_plain(first) || !is_plain(second) {
            return None;
        }
        let asked = |arm: &Arm| match &self.body().pat(arm.pat).kind {
            PatKind::Literal(text) if text == "true" => Some(true),
            PatKind::Literal(text) if text == "false" => Some(false),
            _ => None,
        };
        let is_rest = asked(second).is_some() || matches!(self.body().pat(second.pat).kind, PatKind::Wild);
        match asked(first).filter(|_| is_rest)? {
            true => Some((first.body, second.body)),
            false => Some((second.body, first.body)),
        }
    }

    /// What may hold filters and was moved into names since a node was added.
    fn moved_since(&self, first: usize) -> Vec<Assignment> {
        let may_hold =
            |place: &Place| place.base_var().is_some_and(|var| self.may_hold_filter(&self.graph.var(var).ty));
        let moved = self.graph.nodes[first..].iter().filter_map(|node| match &node.effect {
            Effect::Set(set) if set.transfer == Transfer::Move && set.from.is_some() && may_hold(&set.place) => {
                Some(Assignment::clone(set))
            }
            _ => None,
        });
        moved.collect()
    }

    /// Where the guard of an arm fails, what its pattern would have taken is still in its place.
    fn move_back(&mut self, moved: Vec<Assignment>, failed: NodeId, next: NodeId, span: Span) {
        if moved.is_empty() {
            return;
        }
        let holds = self.at.take();
        self.resume_if_reached(failed);
        for set in moved.into_iter().rev() {
            if let Some(place) = set.from.filter(|_| self.at.is_some()) {
                let back = Assignment { from: Some(set.place), ..given_to(place, None) };
                self.emit(Effect::Set(Box::new(back)), span);
            }
        }
        self.jump(next);
        self.at = holds;
    }

    /// Whether a type is an enum that says what happened, unlike an option or result.
    fn is_choice(&self, ty: &Ty) -> bool {
        matches!(ty.peel(), Ty::Adt(id, _)
            if matches!(self.program.index.type_def(*id).shape, Shape::Enum(_)))
    }

    fn pattern_text(&self, pat: PatId) -> String {
        shorten(self.program.sources.snippet(self.body().pat(pat).span))
    }

    /// Evaluates what is matched; with the option that it is taken out of, in which there is nothing behind the choice of an arm.
    fn matched(&mut self, scrutinee: ExprId) -> (Matched, Option<Place>) {
        let taken = self.taken_from(scrutinee).filter(|_| !self.may_hold_filter(self.ty(scrutinee)));
        // A number that was made of a truth value is as that is.
        let pure = match self.truth_of(scrutinee) {
            Some(_) => None,
            None => taken.as_ref().map(|(_, pure)| pure.clone()).or_else(|| self.pure_option(scrutinee)),
        };
        let mut about = self.about(scrutinee);
        self.note_ends(scrutinee);
        let mut value = if taken.is_some() { self.asked_value(scrutinee) } else { self.expr(scrutinee) };
        let emptied = value.place.clone().filter(|_| taken.is_some());
        // Each of several conditions is asked by itself.
        let is_joined = matches!(self.body().expr(scrutinee).kind, ExprKind::Binary { op: "&&" | "||", .. });
        let pure = match value.same_as.filter(|_| is_joined) {
            Some(var) => {
                about = About { reads: vec![Place::var(var)], ..About::default() };
                Some(self.pure_var(var))
            }
            None => pure,
        };
        let text = self.text(scrutinee);
        let total = self.all_heads(scrutinee).map(Rc::from);
        let pure = pure.or_else(|| value.same_as.map(|var| self.pure_var(var)));
        let pure = match pure {
            None if self.at.is_some() => {
                // The arms ask about one value, although nothing is known of it.
                let span = self.span(scrutinee);
                let var = self.temporary(self.ty(scrutinee).clone(), span);
                self.set(var, &value, span);
                // What a tuple carries has moved there with it, and so has what is taken out of its place.
                let is_moved = matches!(self.body().expr(scrutinee).kind, ExprKind::Tuple(_))
                    || value.leaves_by == Some(Transfer::Move);
                if is_moved && value.place.is_some() && self.may_hold_filter(self.ty(scrutinee)) {
                    value.place = Some(Place::var(var));
                }
                Some(self.pure_var(var))
            }
            pure => pure,
        };
        let asked = pure.as_ref().and_then(|pure| pure.whole.as_ref()).and_then(Place::base_var);
        if let Some(unnamed) = asked.filter(|var| self.graph.var(*var).name.is_empty()) {
            self.derive(&[unnamed], scrutinee);
        }
        let ty = self.ty(scrutinee).clone();
        (Matched { value, pure, total, about, text, span: None, expr: Some(scrutinee), ty }, emptied)
    }

    /// `let PAT = value` in a condition: goes on where it matches, leads to `no` where it does not.
    pub(super) fn match_pattern(&mut self, pat: PatId, expr: ExprId, value: &Value, span: Span, no: NodeId) {
        if self.at.is_none() {
            return;
        }
        self.derive_pattern(pat, expr);
        let taken = self.taken_from(expr);
        let pure = taken.as_ref().map(|(_, pure)| pure.clone()).or_else(|| self.pure_option(expr));
        let pure = pure.or_else(|| value.same_as.map(|var| self.pure_var(var)));
        let mut about = self.about(expr);
        self.note_ends(expr);
        // A number is there, whichever it is: `matches!(level, 3..=9)` compares.
        about.is_presence = !matches!(self.ty(expr), Ty::Bool | Ty::Int | Ty::Float | Ty::Char);
        // `if let Ok(Event::Tick) = events.recv()` chooses as an arm does.
        about.is_event |= is_event_source(&about) && self.asks_what_came(pat);
        let total = self.all_heads(expr).map(Rc::from);
        let text = format!("let {} = {}", self.pattern_text(pat), self.text(expr));
        self.leave_by_condition(pat, expr, value, span);
        let (value, ty) = (value.clone(), self.ty(expr).clone());
        let matched = Matched { value, pure, total, about, text, span: Some(span), expr: Some(expr), ty };
        self.test_pattern(pat, &matched, no);
        if let Some(emptied) = matched.value.place.filter(|_| taken.is_some() && self.at.is_some()) {
            self.emptied(emptied, span);
            self.note_pointed(self.ty(expr));
        }
    }

    /// Whether a pattern asks which value there is, not only whether there is one.
    fn asks_what_came(&self, pat: PatId) -> bool {
        match &self.body().pat(pat).kind {
            PatKind::TupleStruct(_, inner) => match inner.as_slice() {
                [inner] => match &self.body().pat(*inner).kind {
                    PatKind::Wild | PatKind::Rest => false,
                    PatKind::Bind { sub: None, .. } => self.typed().pat_def.contains_key(inner),
                    PatKind::Tuple(parts) => !parts.is_empty(),
                    _ => true,
                },
                _ => false,
            },
            PatKind::Or(pats) => pats.iter().any(|pat| self.asks_what_came(*pat)),
            _ => false,
        }
    }

    /// The value that a pattern of a condition is held against: what is taken out of an option is still there while it is asked for.
    pub(super) fn asked_value(&mut self, expr: ExprId) -> Value {
        match self.taken_from(expr) {
            Some((receiver, _)) => {
                let value = self.expr(receiver);
                Value { is_owned: true, leaves_by: Some(Transfer::Move), head: None, same_as: None, ..value }
            }
            None => self.expr(expr),
        }
    }

    /// The option that something is taken out of, if it is one that conditions can ask for: `self.spare.take()`.
    fn taken_from(&mut self, expr: ExprId) -> Option<(ExprId, Pure)> {
        let option = self.option_taken(expr)?;
        let pure = self.pure(option).filter(|pure| pure.whole.is_some())?;
        Some((option, pure))
    }

    /// Notes that what a pattern binds comes from elsewhere.
    pub(super) fn note_handed(&mut self, pat: PatId) {
        let bound = self.vars_of(pat);
        self.graph.handed.extend(bound);
    }

    /// Asks whether a value matches; binds the names where it does.
    fn test_pattern(&mut self, pat: PatId, matched: &Matched, no: NodeId) {
        if self.at.is_none() {
            return;
        }
        let binds = self.vars_of(pat);
        let mut matched = matched.clone();
        matched.about.binds = binds;
        // Where the clock has ended there is no cycle: in a function that runs one, nothing is owed on that way.
        if self.loops.is_empty() && matched.expr.is_some_and(|expr| self.asks_for_cycle(expr)) {
            let span = self.body().pat(pat).span;
            if self.pattern_text(pat) == "None" {
                self.ask(pat, &matched, no);
                self.emit(Effect::Diverge, span);
                self.at = None;
                return;
            }
            let has_ended = self.add_node(Effect::Diverge, span);
            self.ask(pat, &matched, has_ended);
        } else {
            self.ask(pat, &matched, no);
        }
        self.bind_pattern(pat, &matched.value);
        let is_noted = matched.expr.is_some_and(|expr| self.note_held_parts(pat, expr));
        if let Some(pure) = matched.pure.as_ref().filter(|_| !is_noted) {
            self.note_held(pat, pure);
        }
    }

    fn ask(&mut self, pat: PatId, matched: &Matched, no: NodeId) {
        let body = self.body();
        let span = matched.span.unwrap_or(body.pat(pat).span);
        match &body.pat(pat).kind {
            PatKind::Wild | PatKind::Rest => {}
            PatKind::Bind { sub, .. } => {
                if let Some(def) = self.typed().pat_def.get(&pat).cloned() {
                    let head = self.def_head(&def, &self.pattern_text(pat));
                    self.ask_heads(&[head], self.is_exact(pat), matched, span, no);
                } else if let Some(sub) = sub {
                    self.ask(*sub, matched, no);
                }
            }
            PatKind::Reference(inner) => self.ask(*inner, matched, no),
            PatKind::Path(path) => {
                let head = match self.typed().pat_def.get(&pat).cloned() {
                    Some(def) => self.def_head(&def, &path.text()),
                    None => named_head(&path.text()),
                };
                self.ask_heads(&[head], self.is_exact(pat), matched, span, no);
            }
            PatKind::TupleStruct(_, pats) => {
                let inner: Vec<(String, PatId)> =
                    pats.iter().enumerate().map(|(at, pat)| (at.to_string(), *pat)).collect();
                self.ask_variant(pat, &inner, matched, span, no);
            }
            PatKind::Struct(_, fields) => self.ask_variant(pat, fields, matched, span, no),
            PatKind::Tuple(pats) => {
                for (number, inner) in pats.iter().enumerate() {
                    let part = self.tuple_part(matched, number, *inner);
                    self.ask(*inner, &part, no);
                }
            }
            PatKind::Or(pats) => {
                self.bound_by_asking.insert((self.frame, pat));
                self.ask_any(pats, matched, span, no);
            }
            PatKind::Literal(text) => self.ask_heads(std::slice::from_ref(text), true, matched, span, no),
            PatKind::Slice(pats) => {
                self.ask_slice(pats, matched, span, no);
            }
            PatKind::Range { start, end, inclusive } => match &matched.pure {
                Some(pure) => {
                    let range = ([*start, *end], *inclusive);
                    self.ask_range(range, pure, matched.expr, &matched.about, (span, &matched.text), no);
                }
                None => self.ask_opaque(matched, span, no),
            },
            PatKind::Unknown => self.ask_opaque(matched, span, no),
        }
    }

    /// A slice pattern asks for the number of elements, and for the elements.
    fn ask_slice(&mut self, pats: &[PatId], matched: &Matched, span: Span, no: NodeId) {
        let body = self.body();
        let is_plain = pats.iter().all(|pat| body.is_rest(*pat) || self.is_irrefutable(*pat));
        let has_rest = pats.iter().any(|pat| body.is_rest(*pat));
        // Elements that are written out tell what it is: `[0xA5, value, ..]`.
        if pats.iter().any(|pat| matches!(body.pat(*pat).kind, PatKind::Literal(_))) {
            let about = About { asks_elements: true, ..matched.about.clone() };
            return self.ask_opaque_about(matched, about, span, no);
        }
        // The compiler takes no pattern of another length for an array.
        if is_plain && matched.expr.is_some_and(|expr| matches!(self.ty(expr).peel(), Ty::Array(..))) {
            return;
        }
        let pure = matched.pure.as_ref().filter(|_| is_plain && self.at.is_some());
        let (head, is_turned) = match pats.len() - usize::from(has_rest) {
            0 if has_rest && is_plain => return,
            1 if has_rest => ("0".to_owned(), true),
            count if !has_rest => (count.to_string(), false),
            _ => return self.ask_opaque(matched, span, no),
        };
        let Some(pure) = pure else { return self.ask_opaque(matched, span, no) };
        let length = Pure { key: format!("{}.len()", pure.key), reads: pure.reads.clone(), ..Pure::default() };
        let id = self.subject(length, None);
        let about = About { is_turned, ..matched.about.clone() };
        let (holds, fails) = self.branch_on_subject(id, &[head], true, span, matched.text.clone(), about);
        let (yes, failed) = if is_turned { (fails, holds) } else { (holds, fails) };
        self.link(failed, no);
        self.resume(yes);
    }

    fn ask_opaque(&mut self, matched: &Matched, span: Span, no: NodeId) {
        self.ask_opaque_about(matched, matched.about.clone(), span, no);
    }

    fn ask_opaque_about(&mut self, matched: &Matched, about: About, span: Span, no: NodeId) {
        if self.at.is_none() {
            return;
        }
        let (yes, failed) = self.opaque_branch(span, matched.text.clone(), about);
        self.link(failed, no);
        self.resume(yes);
    }

    fn ask_heads(&mut self, heads: &[Head], exact: bool, matched: &Matched, span: Span, no: NodeId) {
        if self.at.is_none() {
            return;
        }
        // What is surely there is asked for nothing: `if let Some(filter) = filters.first_mut()` behind `filters.push(…)`.
        let is_call = |expr: ExprId| matches!(self.body().expr(expr).kind, ExprKind::MethodCall { .. });
        let is_there = matched.value.head.as_deref() == Some("+") && matched.value.same_as.is_none();
        if is_there && heads == ["+"] && matched.expr.is_some_and(is_call) {
            return;
        }
        // A truth value is there, whichever it is.
        let is_truth = heads.iter().all(|head| head == "true" || head == "false");
        let is_presence = matched.about.is_presence || heads.iter().any(|head| head == "+" || head == "-");
        let about = About {
            is_presence: is_presence && !is_truth,
            is_constant: matched.about.is_constant || self.is_named_constant(matched),
            heads: heads.to_vec(),
            ..matched.about.clone()
        };
        let (yes, failed) = match &matched.pure {
            Some(pure) => {
                let total = matched.total.as_deref().unwrap_or_default();
                let known = self.subjects.get(&pure.key).copied();
                let id = known
                    .unwrap_or_else(|| self.subject(pure.clone(), matched.total.as_ref().map(|total| total.to_vec())));
                // An enum may have more variants than are told apart, and a match an arm for each of them.
                for head in total {
                    if self.head_bit(id, head).is_none() {
                        break;
                    }
                }
                self.branch_on_subject(id, heads, exact, span, matched.text.clone(), about)
            }
            None => self.branch(Test {
                subject: None,
                holds: u32::MAX,
                fails: u32::MAX,
                span,
                text: matched.text.clone(),
                about,
            }),
        };
        self.link(failed, no);
        self.resume(yes);
    }

    /// Whether a name is matched that stands for the same value as long as the program runs: `match MODE { … }`.
    fn is_named_constant(&self, matched: &Matched) -> bool {
        let is_path = matched.expr.is_some_and(|expr| matches!(self.body().expr(expr).kind, ExprKind::Path(_)));
        is_path && matched.pure.as_ref().is_some_and(|pure| pure.reads.is_empty())
    }

    fn ask_variant(&mut self, pat: PatId, inner: &[(String, PatId)], matched: &Matched, span: Span, no: NodeId) {
        let def = self.typed().pat_def.get(&pat).cloned();
        let is_struct =
            matches!(&def, Some(Def::Type(id)) if matches!(self.program.index.type_def(*id).shape, Shape::Struct(_)));
        let is_single = matches!(&def, Some(Def::Variant(id, _))
            if matches!(&self.program.index.type_def(*id).shape, Shape::Enum(variants) if variants.len() == 1));
        if !is_struct && !is_single {
            let head = match &def {
                Some(def) => self.def_head(def, ""),
                None => self.path_text(pat),
            };
            // What it holds is asked by itself.
            self.ask_heads(&[head], true, matched, span, no);
        }
        let is_transparent = matches!(&def, Some(Def::External(_)));
        for (name, pat) in inner {
            if !self.is_irrefutable(*pat) {
                let part = self.part(matched, name, is_transparent);
                self.ask(*pat, &part, no);
            }
        }
    }

    fn path_text(&self, pat: PatId) -> String {
        match &self.body().pat(pat).kind {
            PatKind::TupleStruct(path, _) | PatKind::Struct(path, _) | PatKind::Path(path) => match path.last() {
                "Some" | "Ok" => "+".to_owned(),
                "None" | "Err" => "-".to_owned(),
                _ => path.text(),
            },
            _ => String::new(),
        }
    }

    /// A part of what is matched.
    fn part(&mut self, matched: &Matched, name: &str, is_transparent: bool) -> Matched {
        let place =
            matched.value.place.as_ref().map(|place| if is_transparent { place.clone() } else { place.field(name) });
        let Value { is_owned, leaves_by, .. } = matched.value;
        let value = Value { place, is_owned, leaves_by, ..Value::default() };
        let step = if is_transparent { format!("{name}!") } else { name.to_owned() };
        let ty = self.part_ty(&matched.ty, name).filter(|_| !is_transparent);
        let whole = matched.pure.as_ref().and_then(|pure| pure.whole.as_ref());
        // A part that has a place is asked for as its field is: `match t { (true, _) => … }` asks what `if t.0` does.
        let (pure, total) = match (whole, &ty) {
            (Some(whole), Some(ty)) if !self.may_hold_filter(ty) => {
                (Some(pure_place(whole.field(name))), self.total_heads(ty).map(Rc::from))
            }
            _ => (matched.pure.as_ref().map(|pure| pure.part(&step)), None),
        };
        Matched { value, pure, total, ty: ty.unwrap_or(Ty::Unknown), ..matched.clone() }
    }

    /// The type of an element of a tuple, or of a field of a struct.
    fn part_ty(&self, ty: &Ty, name: &str) -> Option<Ty> {
        match ty.peel() {
            Ty::Tuple(parts) => name.parse().ok().and_then(|number: usize| parts.get(number)).cloned(),
            ty => self.program.index.field_ty(ty, None, name),
        }
    }

    /// An element of a tuple that is matched: where the tuple is written out, it is asked about by itself.
    fn tuple_part(&mut self, matched: &Matched, number: usize, pat: PatId) -> Matched {
        let mut part = self.part(matched, &number.to_string(), false);
        part.expr = None;
        let body = self.body();
        if let Some(expr) = matched.expr
            && let ExprKind::Tuple(parts) = &body.expr(expr).kind
            && let Some(own) = parts.get(number).copied()
        {
            let binds = self.vars_of(pat);
            self.derive(&binds, own);
            let answer = part.value.place.as_ref().filter(|_| self.is_plain_option(self.ty(own)));
            let answer = answer.and_then(|place| self.answer_in(place)).map(|var| self.pure_var(var));
            part.pure = self.pure_option(own).or(answer).or(part.pure);
            part.total = self.total_heads(self.ty(own)).map(Rc::from);
            // An answer that was kept is there whatever it is.
            part.about = match self.ty(own) {
                Ty::Bool if self.typed().expr_local.contains_key(&own) => About { binds, ..self.about(own) },
                _ => self.about_presence(own, binds),
            };
            part.expr = Some(own);
        }
        part
    }

    /// `a | b`: one question if only heads are asked for, one after the other otherwise.
    fn ask_any(&mut self, pats: &[PatId], matched: &Matched, span: Span, no: NodeId) {
        let heads: Vec<Option<Head>> = pats.iter().map(|pat| self.plain_head(*pat)).collect();
        if let Some(heads) = heads.into_iter().collect::<Option<Vec<Head>>>() {
            let exact = pats.iter().all(|pat| self.is_exact(*pat));
            return self.ask_heads(&heads, exact, matched, span, no);
        }
        let matches = self.add_node(Effect::Nothing, span);
        for (number, pat) in pats.iter().enumerate() {
            let last = number + 1 == pats.len();
            let next = if last { no } else { self.add_node(Effect::Nothing, span) };
            self.ask(*pat, matched, next);
            self.bind_pattern(*pat, &matched.value);
            self.jump(matches);
            if !last {
                self.resume_if_reached(next);
            }
        }
        self.resume_if_reached(matches);
    }

    /// The head that a pattern asks for, if it asks for nothing else and binds no parts.
    fn plain_head(&self, pat: PatId) -> Option<Head> {
        match &self.body().pat(pat).kind {
            PatKind::Literal(text) => Some(text.clone()),
            PatKind::Path(path) => match self.typed().pat_def.get(&pat) {
                Some(def) => Some(self.def_head(def, &path.text())),
                None => Some(named_head(&path.text())),
            },
            PatKind::Bind { .. } => {
                self.typed().pat_def.get(&pat).map(|def| self.def_head(def, &self.pattern_text(pat)))
            }
            PatKind::TupleStruct(_, pats)
                if pats.iter().all(|pat| matches!(self.body().pat(*pat).kind, PatKind::Wild | PatKind::Rest)) =>
            {
                self.typed().pat_def.get(&pat).map(|def| self.def_head(def, ""))
            }
            PatKind::Struct(_, fields) if fields.is_empty() => {
                self.typed().pat_def.get(&pat).map(|def| self.def_head(def, ""))
            }
            PatKind::Reference(inner) => self.plain_head(*inner),
            _ => None,
        }
    }

    /// Whether all values that have the head which a pattern asks for match it.
    fn is_exact(&self, pat: PatId) -> bool {
        match &self.body().pat(pat).kind {
            PatKind::Reference(inner) => self.is_exact(*inner),
            _ => self.typed().pat_def.get(&pat).is_none_or(|def| super::constants::is_exact(self.program, def, 0)),
        }
    }

    fn def_head(&self, def: &Def, text: &str) -> Head {
        super::constants::head_of(self.program, def, text, 0).unwrap_or_else(|| text.to_owned())
    }

    pub(super) fn is_irrefutable(&self, pat: PatId) -> bool {
        match &self.body().pat(pat).kind {
            PatKind::Wild | PatKind::Rest => true,
            PatKind::Bind { sub, .. } => {
                !self.typed().pat_def.contains_key(&pat) && sub.is_none_or(|sub| self.is_irrefutable(sub))
            }
            PatKind::Reference(inner) => self.is_irrefutable(*inner),
            PatKind::Tuple(pats) => pats.iter().all(|pat| self.is_irrefutable(*pat)),
            PatKind::Struct(_, fields) => {
                self.is_struct_pat(pat) && fields.iter().all(|(_, pat)| self.is_irrefutable(*pat))
            }
            PatKind::TupleStruct(_, pats) => {
                self.is_struct_pat(pat) && pats.iter().all(|pat| self.is_irrefutable(*pat))
            }
            PatKind::Path(_)
            | PatKind::Or(_)
            | PatKind::Slice(_)
            | PatKind::Literal(_)
            | PatKind::Range { .. }
            | PatKind::Unknown => false,
        }
    }

    fn is_struct_pat(&self, pat: PatId) -> bool {
        matches!(self.typed().pat_def.get(&pat),
            Some(Def::Type(id)) if matches!(self.program.index.type_def(*id).shape, Shape::Struct(_)))
    }

    /// The variables that a pattern binds.
    pub(super) fn vars_of(&mut self, pat: PatId) -> Vec<Var> {
        self.locals_of(pat).into_iter().map(|local| self.var_of(local)).collect()
    }

    /// The locals that a pattern binds.
    pub(super) fn locals_of(&self, pat: PatId) -> Vec<LocalId> {
        let mut found = Vec::new();
        let mut open = vec![pat];
        while let Some(pat) = open.pop() {
            if let Some(local) = self.typed().pat_local.get(&pat) {
                found.push(*local);
            }
            match &self.body().pat(pat).kind {
                PatKind::Bind { sub, .. } => open.extend(*sub),
                PatKind::Tuple(pats) | PatKind::TupleStruct(_, pats) | PatKind::Or(pats) | PatKind::Slice(pats) => {
                    open.extend(pats.iter().rev());
                }
                PatKind::Struct(_, fields) => open.extend(fields.iter().rev().map(|(_, pat)| *pat)),
                PatKind::Reference(inner) => open.push(*inner),
                _ => {}
            }
        }
        found
    }

    /// Binds the names of a pattern to the parts of a value.
    pub(super) fn bind_pattern(&mut self, pat: PatId, value: &Value) {
        if self.at.is_none() {
            return;
        }
        let body = self.body();
        let span = body.pat(pat).span;
        match &body.pat(pat).kind {
            PatKind::Bind { by_ref, sub, .. } => {
                if let Some(local) = self.typed().pat_local.get(&pat).copied() {
                    let var = self.redeclare(local);
                    let by_reference = *by_ref || self.typed().local(local).by_ref;
                    let is_reference = matches!(self.typed().local(local).ty, Ty::Ref(..));
                    // Nothing writes what is lent for reading, as long as it is.
                    let is_read = matches!(self.typed().local(local).ty, Ty::Ref(false, _));
                    let value = Value { is_owned: value.is_owned && !by_reference && !is_reference, ..value.clone() };
                    self.set(var, &value, span);
                    if !by_reference || is_read {
                        self.note_copied_part(var, &value);
                    }
                    self.bind_guard(var, &value, span);
                }
                if let Some(sub) = sub {
                    self.bind_pattern(*sub, value);
                }
            }
            // What is taken from behind a reference is a copy.
            PatKind::Reference(inner) => {
                let ty = self.bound_ty(*inner);
                let copy = self.program.index.copies_filter(&ty).then(|| self.copy_used(value, ty, span));
                self.bind_pattern(*inner, copy.as_ref().unwrap_or(value));
            }
            PatKind::Tuple(pats) => {
                let rest = pats.iter().position(|pat| matches!(body.pat(*pat).kind, PatKind::Rest));
                for (number, inner) in pats.iter().enumerate() {
                    if rest.is_none_or(|rest| number < rest) {
                        self.bind_part(*inner, value, &number.to_string());
                    }
                }
            }
            PatKind::TupleStruct(_, pats) => match self.typed().pat_def.get(&pat).cloned() {
                Some(Def::Variant(ty, at)) => {
                    let variant = super::constants::variant_head(self.program, ty, at);
                    for (number, inner) in pats.iter().enumerate() {
                        let part = part_of(value, &[&variant, &number.to_string()]);
                        self.bind_pattern(*inner, &part);
                    }
                }
                Some(Def::Type(_)) => {
                    for (number, inner) in pats.iter().enumerate() {
                        self.bind_part(*inner, value, &number.to_string());
                    }
                }
                _ => {
                    // `Some(x)`, `Ok(x)`: the payload is the same instance.
                    for inner in pats {
                        self.bind_pattern(*inner, &Value { same_as: None, head: None, ..value.clone() });
                    }
                }
            },
            PatKind::Struct(_, fields) => {
                let variant = match self.typed().pat_def.get(&pat).cloned() {
                    Some(Def::Variant(ty, at)) => Some(super::constants::variant_head(self.program, ty, at)),
                    _ => None,
                };
                for (name, inner) in fields {
                    let part = match &variant {
                        Some(variant) => part_of(value, &[variant, name]),
                        None => part_of(value, &[name]),
                    };
                    self.bind_pattern(*inner, &part);
                }
            }
            PatKind::Slice(pats) => self.bind_slice(pat, pats, value),
            PatKind::Or(pats) => {
                let is_bound = self.bound_by_asking.remove(&(self.frame, pat));
                if let Some(first) = pats.first().filter(|_| !is_bound) {
                    self.bind_pattern(*first, value);
                }
            }
            PatKind::Wild
            | PatKind::Rest
            | PatKind::Path(_)
            | PatKind::Literal(_)
            | PatKind::Range { .. }
            | PatKind::Unknown => {}
        }
    }

    /// Binds the elements of a slice pattern; which ones stand behind `..` depends on the length.
    fn bind_slice(&mut self, pat: PatId, pats: &[PatId], value: &Value) {
        let body = self.body();
        let length = self.typed().pat_length.get(&pat).copied();
        let rest = pats.iter().position(|pat| body.is_rest(*pat));
        for (number, inner) in pats.iter().enumerate() {
            let from = number as u64;
            let text = "..";
            let key = match rest {
                Some(rest) if number == rest && number + 1 == pats.len() => {
                    IndexKey::Slice(Section::known(from, None, text))
                }
                Some(rest) if number >= rest => {
                    let behind = (pats.len() - number) as u64;
                    match length.and_then(|length| length.checked_sub(behind)) {
                        Some(at) if number > rest => IndexKey::Number(at),
                        Some(at) => IndexKey::Slice(Section::known(from, Some(at + 1), text)),
                        None if number > rest => IndexKey::Data(Arc::from(text)),
                        None => IndexKey::Slice(Section::unknown(text)),
                    }
                }
                _ => IndexKey::Number(from),
            };
            let place = value.place.as_ref().map(|place| place.element(key));
            self.bind_pattern(*inner, &Value { place, is_owned: value.is_owned, ..Value::default() });
        }
    }

    /// The type of the name that a pattern is.
    fn bound_ty(&self, pat: PatId) -> Ty {
        let local = self.typed().pat_local.get(&pat);
        local.map_or(Ty::Unknown, |local| self.typed().local(*local).ty.clone())
    }

    fn bind_part(&mut self, pat: PatId, value: &Value, name: &str) {
        self.bind_pattern(pat, &part_of(value, &[name]));
    }

    /// The variable of a local at the point where it is declared.
    fn redeclare(&mut self, local: LocalId) -> Var {
        let known = self.frames[self.frame].vars.contains_key(&local);
        let var = self.var_of(local);
        if !known {
            return var;
        }
        let in_loop = self.loops.last().copied();
        let declared = self.at.unwrap_or(NodeId(0));
        let info = &mut self.graph.vars[var.0 as usize];
        if info.param.is_none() {
            info.in_loop = in_loop;
            info.declared = declared;
        }
        var
    }
}

/// The head of what a path names of which nothing else is known.
fn named_head(path: &str) -> Head {
    limit_of_type(path).map_or_else(|| path.to_owned(), |number| number.to_string())
}

fn part_of(value: &Value, names: &[&str]) -> Value {
    let place = value.place.as_ref().map(|place| names.iter().fold(place.clone(), |place, name| place.field(name)));
    Value { place, is_owned: value.is_owned, leaves_by: value.leaves_by, ..Value::default() }
}

/// Whether a match chooses between events: on the result of an awaited `select`, or of a receiver.
pub(super) fn is_event_source(about: &About) -> bool {
    about.names.iter().any(|name| {
        matches!(
            name.as_str(),
            "select"
                | "select3"
                | "select4"
                | "select_array"
                | "recv"
                | "receive"
                | "next_event"
                | "wait_event"
                | "poll_event"
                | "try_recv"
                | "recv_timeout"
                | "next_message"
        )
    })
}

/// A piece of source text on one line, cut where it gets long.
pub(super) fn shorten(text: &str) -> String {
    const MAX: usize = 48;
    let line: String = text.split_whitespace().collect::<Vec<_>>().join(" ");
    if line.chars().count() <= MAX {
        return line;
    }
    let cut: String = line.chars().take(MAX - 1).collect();
    format!("{cut}…")
}
