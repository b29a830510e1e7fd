//! The two lines that a migrated loop gets: its clock above it, and the guard at its head.

use super::Reason;
use super::body::LoopBody;
use super::core_items::CoreItems;
use super::elements::statements;
use super::exits::Exits;
use super::holding::is_value;
use super::loops::Loops;
use super::mentions::{Guarded, is_about, is_about_owner, is_glance};
use super::observed::{is_dropped_at, is_observed, outlives_future};
use super::owned::is_owned;
use super::panics::fails_anew;
use super::present::Present;
use super::said::Comments;
use super::text::{
    Style, above, begins_line, conditions_above, has_word, indentation, line_stop, with_attributes, without_comments,
};
use crate::index::{Owner, TraitName};
use crate::source::Span;
use crate::syntax::tree::{Block, ExprId, ExprKind, MacroKind, Stmt, StmtKind};
use crate::syntax::{Lexer, TokenKind};

/// The rate that stands in the rewritten code where the loop does not tell its own.
const UNKNOWN_RATE: u64 = 1000;

/// The names that a clock may get.
const CLOCKS: [&str; 4] = ["clock", "cycle_clock", "guard_clock", "ceid_clock"];

/// The edits that write the two lines, or that extend the guard that is there.
pub(super) fn lines(
    of: &LoopBody<'_>,
    guarded: &[Guarded],
    behind: Option<Span>,
    present: Option<&Present>,
    comments: &Comments,
    rate: &CycleRate,
) -> Result<Vec<(Span, String)>, Reason> {
    let refuse = |text: &str| Reason { span: of.span(of.whole), text: text.to_owned() };
    let text = of.text;
    let open = of.span(of.block).start as usize + 1;
    let start = if of.is_function { Some(open) } else { statement_start(of) };
    let start = start.ok_or_else(|| refuse("the loop is not a statement of a block: put it into one, `{ … }`"))?;
    let core = CoreItems::of(of.program, of.function);
    let body = without_comments(of.program.sources.snippet(of.span(of.body.root)));
    let is_local = |name: &str| of.typed.locals.iter().any(|local| local.name == name);
    let is_taken = |name: &str| has_word(&body, name) || is_local(name) || is_value(of, name);
    let clock = CLOCKS.into_iter().find(|name| !is_taken(name)).or_else(|| present.map(|_| ""));
    let clock = clock.ok_or_else(|| refuse("every name for a clock means something else here"))?;
    let Style { end, .. } = of.style;
    // What the loop is compiled under, so is what only the loop uses.
    let conditions = if of.is_function { Vec::new() } else { conditions_above(text, start) };
    let start = if conditions.is_empty() { start } else { with_attributes(text, start) };
    let begins = begins_line(text, start);
    let own_line = own_line(of, behind);
    let indent = match &own_line {
        Some((indent, _)) if of.is_function => indent.as_str(),
        _ if begins && !of.is_function => indentation(text, start),
        _ => "",
    };
    let mut declared = match present {
        Some(_) => Vec::new(),
        None => {
            vec![format!("{indent}let mut {clock} = {}::new();", rate.clock(&core))]
        }
    };
    declared.extend(statements(of, guarded).into_iter().map(|statement| format!("{indent}{statement}")));
    let is_inline = if of.is_function { own_line.is_none() } else { !begins };
    let lent = guarded.iter().filter_map(|own| own.adaptation.as_ref());
    for own in lent {
        declared.extend(own.cells.iter().map(|cell| format!("{indent}{cell}")));
        declared.push(match is_inline {
            true => own.law.in_one_line(&own.name),
            false => own.law.statement(&own.name, indent, of.style),
        });
    }
    let condition: String = match is_inline {
        true => conditions.iter().map(|condition| format!("{condition} ")).collect(),
        false => conditions.iter().map(|condition| format!("{indent}{condition}{end}")).collect(),
    };
    declared.iter_mut().for_each(|line| line.insert_str(0, &condition));
    let lines: String = declared.iter().map(|line| format!("{line}{end}")).collect();
    if let Some(present) = present {
        let extended = present.with(of, &guarded.iter().map(entry).collect::<Vec<_>>());
        let start = if of.is_function { present.stmt.start as usize } else { start };
        let is_inline = !begins_line(text, start);
        let above = if is_inline { start } else { above(text, start) };
        let lines = if is_inline { format!("{} ", declared.join(" ")) } else { lines };
        let is_needed = !declared.is_empty();
        return Ok(is_needed.then(|| (insertion(of, above), lines)).into_iter().chain([extended]).collect());
    }
    let guard = list(of, guarded, (&core.name("ceid"), clock), own_line.as_ref(), comments);
    let (at, guard) = match own_line {
        Some((indent, at)) => {
            let said: String = comments.above(None).map(|line| format!("{indent}{line}{end}")).collect();
            (at, format!("{said}{indent}{guard}{end}"))
        }
        None => (behind.map_or(open, |before| before.end as usize), format!(" {guard}")),
    };
    if of.is_function {
        let head = if is_inline { format!(" {}{guard}", declared.join(" ")) } else { format!("{lines}{guard}") };
        return Ok(vec![(insertion(of, at), head)]);
    }
    let clock_edit = if begins {
        (insertion(of, above(text, start)), lines)
    } else {
        (insertion(of, start), format!("{} ", declared.join(" ")))
    };
    Ok(vec![clock_edit, (insertion(of, at), guard)])
}

/// The indentation and the place of the line that the guard gets, if it gets one of its own.
pub(super) fn own_line(of: &LoopBody<'_>, behind: Option<Span>) -> Option<(String, usize)> {
    let text = of.text;
    let after = behind.map_or(of.span(of.block).start as usize + 1, |before| before.end as usize);
    let stop = line_stop(text, after);
    let rest = text[after..stop].trim();
    if !(rest.is_empty() || rest.starts_with("//")) {
        return None;
    }
    match behind {
        Some(before) => {
            text[..stop].ends_with('\n').then(|| (indentation(text, before.start as usize).to_owned(), stop))
        }
        None => Some((body_indentation(of, stop), stop)),
    }
}

/// The guard with its list, which gets lines of its own where one with that indentation would be too long, or where something is
/// said of one of several filters.
fn list(
    of: &LoopBody<'_>,
    guarded: &[Guarded],
    (ceid, clock): (&str, &str),
    own_line: Option<&(String, usize)>,
    comments: &Comments,
) -> String {
    let Style { end, step, width } = of.style;
    let list: Vec<String> = guarded.iter().map(entry).collect();
    let guard = format!("{ceid}!({clock}.begin_cycle() => {});", list.join(", "));
    let is_wide = |indent: &&str| indent.len() + guard.len() > width || guarded.len() > 1 && comments.tell_apart();
    let said = |name: &str| comments.behind(name).map(|comment| format!(" {comment}")).unwrap_or_default();
    let indent = own_line.map(|(indent, _)| indent.as_str());
    match indent.filter(is_wide) {
        Some(indent) => {
            let line = |(at, (entry, own)): (usize, (&String, &Guarded))| {
                let comma = if at + 1 < list.len() { "," } else { "" };
                let above = comments.above(Some(&own.name));
                let above: String = above.map(|line| format!("{end}{indent}{step}{step}{line}")).collect();
                format!("{above}{end}{indent}{step}{step}{entry}{comma}{}", said(&own.name))
            };
            let lines: String = list.iter().zip(guarded).enumerate().map(line).collect();
            let token = format!("{indent}{step}{clock}.begin_cycle() =>{lines}");
            format!("{ceid}!({end}{token}{end}{indent});")
        }
        None => {
            let behind = guarded.iter().filter_map(|own| comments.behind(&own.name));
            // A comment below one at the end of a line would go on with that.
            let is_followed = |at: usize| of.text[at..].trim_start_matches([' ', '\t']).starts_with("/");
            match own_line.filter(|(_, at)| is_followed(*at)) {
                Some((indent, _)) => behind.map(|line| format!("{line}{end}{indent}")).collect::<String>() + &guard,
                None => behind.fold(guard, |guard, comment| guard + " " + comment),
            }
        }
    }
}

/// The statement behind which the guard stands: the one that locks its filter, or the last of the first ones by which the loop is
/// left before more is done with a filter than to feed it or to look at it, or the last one that uses what the filter is a part of. `is_exact` says that each
/// filter is updated exactly once today: only then no path goes on from what stands above the guard to the next iteration.
pub(super) fn behind(
    loops: &Loops<'_>,
    of: &LoopBody<'_>,
    guarded: &[Guarded],
    exits: &Exits,
    is_exact: bool,
) -> Option<Span> {
    if let Some(lock) = guarded.iter().find_map(|own| own.locked) {
        return Some(lock);
    }
    let ExprKind::Block(block) = of.kind(of.block) else { return None };
    if of.is_function && !is_exact {
        return last_item(of, block);
    }
    let sites = || guarded.iter().flat_map(|own| &own.sites);
    let is_theirs = |id: &ExprId| {
        matches!(of.kind(*id), ExprKind::Opaque(_) | ExprKind::Unknown { .. })
            || guarded.iter().any(|own| {
                // What is lent above the loop is not even there to be looked at.
                let is_there = is_exact && !own.is_lent_above();
                is_about(of, &own.place, *id) && !(is_there && is_glance(of, *id))
            })
            || sites().any(|site| site.call == *id)
    };
    let within = |stmt: &Stmt| of.inside.iter().filter(|id| stmt.span.contains(of.span(**id))).collect::<Vec<_>>();
    let is_apart = |stmt: &&Stmt| stmt.cfg.is_none() && !within(stmt).into_iter().any(is_theirs);
    let is_seen_at = |exit: &ExprId| {
        // Without its input, no law runs.
        let is_fed = |own: &Guarded| own.adaptation.as_ref().is_some_and(|adaptation| adaptation.is_fed);
        let is_seen = |own: &Guarded| {
            let fails = || fails_anew(loops, own).is_some();
            !is_fed(own) && (is_observed(of, own) && !is_dropped_at(of, own, *exit) || fails())
        };
        guarded.iter().any(is_seen)
    };
    // The arms of a `select!` are events of their own, and by the one that leaves the loop nothing is updated today.
    let is_arm = |exit: &ExprId| {
        let is_select =
            |id: ExprId| matches!(of.kind(id), ExprKind::Macro(call) if matches!(call.kind, MacroKind::Select(_)));
        exits.left_at.contains(exit) && of.ancestors_inside(*exit).any(is_select)
    };
    let waits = exits.waits.iter().filter(|_| guarded.iter().any(|own| outlives_future(of, own)));
    let ends: Vec<ExprId> =
        exits.left_at.iter().chain(waits).copied().filter(|exit| is_seen_at(exit) || is_arm(exit)).collect();
    let uses_owner = |id: &ExprId| guarded.iter().any(|own| is_about_owner(of, &own.place, *id));
    let comes_first = |stmt: &&Stmt| within(stmt).into_iter().any(|id| ends.contains(id) || uses_owner(id));
    let early = block.stmts.iter().take_while(is_apart).filter(comes_first).last();
    let late = if is_exact { behind_owner(of, guarded, block) } else { None };
    let Some(last) = early.into_iter().chain(late).max_by_key(|stmt| stmt.span.end) else {
        return last_item(of, block);
    };
    let last = last.span;
    // Behind everything, it would be no better than a call.
    let is_gone = |stmt: &Stmt| {
        sites().filter_map(|site| site.stmt.as_ref()).any(|gone| gone.contains(&(stmt.span.start as usize)))
    };
    let stays = |stmt: &Stmt| stmt.span.start >= last.end && !is_gone(stmt);
    (block.tail.is_some() || block.stmts.iter().any(stays)).then_some(last)
}

/// The end of the last of the items that a block begins with: they come before its statements.
fn last_item(of: &LoopBody<'_>, block: &Block) -> Option<Span> {
    let open = of.span(of.block).start as usize + 1;
    let first = block.stmts.first().map(|stmt| stmt.span).or_else(|| block.tail.map(|tail| of.span(tail)))?;
    let items = of.text.get(open..first.start as usize)?;
    let mut depth = 0_i32;
    let mut end = None;
    for token in Lexer::new(items) {
        match (token.kind, &items[token.start..token.end]) {
            (TokenKind::Open, _) => depth += 1,
            (TokenKind::Close, sign) => {
                depth -= 1;
                end = if depth == 0 && sign == "}" { Some(open + token.end) } else { end };
            }
            (_, ";") if depth == 0 => end = Some(open + token.end),
            _ => {}
        }
    }
    // What is not compiled may be more than an item.
    let end = end.filter(|_| !has_word(&without_comments(items), "cfg"))?;
    Some(Span { end: insertion(of, end).start, ..insertion(of, end - 1) })
}

/// The last of the statements above all updates that uses what a filter is a part of, if what feeds a filter up to there keeps no part
/// of it.
fn behind_owner<'b>(of: &LoopBody<'_>, guarded: &[Guarded], block: &'b Block) -> Option<&'b Stmt> {
    let index = of.program.index;
    let scope = index.scope_of(of.function);
    let uses = |stmt: &Stmt, what: &dyn Fn(&Guarded, ExprId) -> bool| {
        let ids = || of.inside.iter().filter(|id| stmt.span.contains(of.span(**id)));
        guarded.iter().any(|own| ids().any(|id| what(own, *id)))
    };
    let is_update = |own: &Guarded, id: ExprId| own.sites.iter().any(|site| site.call == id);
    let is_unread = |_: &Guarded, id: ExprId| matches!(of.kind(id), ExprKind::Opaque(_) | ExprKind::Unknown { .. });
    let is_above = |stmt: &&Stmt| stmt.cfg.is_none() && !uses(stmt, &is_update) && !uses(stmt, &is_unread);
    let above: Vec<&Stmt> = block.stmts.iter().take_while(is_above).collect();
    let last = above.iter().rposition(|stmt| uses(stmt, &|own, id| is_about_owner(of, &own.place, id)))?;
    let keeps = |stmt: &&Stmt| {
        let StmtKind::Let { pat, .. } = &stmt.kind else { return false };
        let around = of.body.pat(*pat).span;
        let mut bound = of.typed.locals.iter().filter(|local| around.contains(local.span));
        bound.any(|local| !is_owned(index, &scope, &local.ty)) && uses(stmt, &|own, id| is_about(of, &own.place, id))
    };
    let is_free = !guarded.iter().any(Guarded::is_lent_above) && !above[..=last].iter().any(keeps);
    is_free.then(|| above[last])
}

/// Where the statement begins that the loop is or lies in.
fn statement_start(of: &LoopBody<'_>) -> Option<usize> {
    let mut at = of.whole;
    loop {
        let parent = of.parent(at)?;
        match of.kind(parent) {
            ExprKind::Block(block) => {
                let span = of.span(at);
                let stmt = block.stmts.iter().map(|stmt| stmt.span).find(|stmt| stmt.contains(span));
                return Some(with_label(of.text, stmt.unwrap_or(span).start as usize));
            }
            ExprKind::Closure(_) | ExprKind::Macro(_) => return None,
            _ => at = parent,
        }
    }
}

fn insertion(of: &LoopBody<'_>, at: usize) -> Span {
    let at = u32::try_from(at).unwrap_or(u32::MAX);
    Span::new(of.file(), at, at)
}

/// How the lines of the body are indented: as its first statement is, or one step deeper than its head.
fn body_indentation(of: &LoopBody<'_>, stop: usize) -> String {
    let text = of.text;
    let open = of.span(of.block).start as usize;
    let first = match of.kind(of.block) {
        ExprKind::Block(block) => block.stmts.first().map(|stmt| stmt.span.start as usize),
        _ => None,
    };
    match first.filter(|first| *first >= stop && begins_line(text, *first)) {
        Some(first) => indentation(text, first).to_owned(),
        None => format!("{}{}", indentation(text, open), of.style.step),
    }
}

/// A filter in the list of the guard.
fn entry(own: &Guarded) -> String {
    match &own.adaptation {
        Some(adaptation) => format!("{} = {}", own.name, adaptation.name),
        None if let Some(stars) = own.stars() => format!("{} = {stars}{}", own.name, own.spelled),
        None if own.locked.is_some() => format!("{} = *{}", own.name, own.name),
        None if own.name == own.spelled || own.place.element.is_some() => own.name.clone(),
        None => format!("{} = {}", own.name, own.spelled),
    }
}

/// Where a loop begins whose label stands before `start`.
fn with_label(text: &str, start: usize) -> usize {
    let Some(label) = text[..start].trim_end().strip_suffix(':').map(str::trim_end) else { return start };
    let before = label.trim_end_matches(|c: char| c.is_alphanumeric() || c == '_');
    if before.len() < label.len() && before.ends_with('\'') { before.len() - 1 } else { start }
}

/// How often a second a loop runs, as the rewritten code says it, and what a person should know of that.
#[derive(Clone, Debug)]
pub(super) struct CycleRate {
    number: u64,
    /// Whether the cycle is that of a functionality, which says its rate itself.
    is_own: bool,
    pub(super) note: Option<String>,
}

impl CycleRate {
    /// Of a cycle whose rounds take so many seconds.
    pub(super) fn of(of: &LoopBody<'_>, period: Option<f64>) -> Self {
        if is_of_functionality(of) {
            return Self { number: UNKNOWN_RATE, is_own: true, note: None };
        }
        let most = f64::from(u32::MAX);
        let Some(exact) = period.map(f64::recip).filter(|rate| (0.5..=most).contains(rate)) else {
            let note = format!(
                "`Hz<{UNKNOWN_RATE}>` stands for the rate of the loop, which was not found: write it there; no law reads it"
            );
            return Self { number: UNKNOWN_RATE, is_own: false, note: Some(note) };
        };
        let whole = exact.round();
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "it is between 1 and the largest `u32`"
        )]
        let number = whole as u64;
        let is_exact = (exact - whole).abs() < 1e-6 * exact;
        let note = (!is_exact).then(|| {
            // To the nanosecond, as it is written.
            let seconds = (exact.recip() * 1e9).round() / 1e9;
            format!("`Hz<{number}>` is the next whole rate: the loop waits {seconds} s in each round; no law reads it")
        });
        Self { number, is_own: false, note }
    }

    /// The type of the clock.
    fn clock(&self, core: &CoreItems<'_>) -> String {
        if self.is_own {
            return format!("{}::<Self>", core.name("ClockOf"));
        }
        format!("{}::<{}<{}>>", core.name("Free"), core.name("Hz"), self.number)
    }
}

/// Whether a cycle is that of ceid-core's `RealtimeFunctionality`.
fn is_of_functionality(of: &LoopBody<'_>) -> bool {
    let (index, def) = (of.program.index, of.def());
    let Owner::Impl(own) = def.owner else { return false };
    let is_it = match &index.impl_def(own).implements {
        Some(TraitName::External(path)) => path == "ceid_core::RealtimeFunctionality",
        Some(TraitName::Local(id)) => {
            let found = index.trait_def(*id);
            found.name == "RealtimeFunctionality" && index.crate_of(found.module).name == "ceid_core"
        }
        None => false,
    };
    is_it && of.is_function && def.name == "cycle"
}
