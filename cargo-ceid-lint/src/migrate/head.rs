//! The two lines that a migrated loop gets: its clock above it, and the guard at its head.

use super::Reason;
use super::body::LoopBody;
use super::elements::statements;
use super::exits::Exits;
use super::law::ceid_core_name;
use super::mentions::{Guarded, is_about};
use super::observed::{is_observed, outlives_future};
use super::text::{Style, above, begins_line, has_word, indentation, line_stop};
use crate::index::Def;
use crate::source::Span;
use crate::syntax::tree::{Body, ExprId, ExprKind, Literal, Stmt};

/// The rate that stands in the rewritten code where the loop does not tell its own.
pub(super) const UNKNOWN_RATE: u64 = 1000;

/// The names that a clock may get.
const CLOCKS: [&str; 4] = ["clock", "cycle_clock", "guard_clock", "ceid_clock"];

/// The edits that write the two lines.
pub(super) fn lines(
    of: &LoopBody<'_>,
    guarded: &[Guarded],
    behind: Option<Span>,
) -> Result<Vec<(Span, String)>, Reason> {
    let refuse = |text: &str| Reason { span: of.span(of.whole), text: text.to_owned() };
    let text = of.text;
    let open = of.span(of.block).start as usize + 1;
    let start = if of.is_function { Some(open) } else { statement_start(of) };
    let start = start.ok_or_else(|| refuse("the loop is not a statement of a block: put it into one, `{ … }`"))?;
    let core = ceid_core_name(of.program.index, of.function);
    let body = of.program.sources.snippet(of.span(of.body.root));
    let is_taken = |name: &str| has_word(body, name) || of.typed.locals.iter().any(|local| local.name == name);
    let clock = CLOCKS.into_iter().find(|name| !is_taken(name));
    let clock = clock.ok_or_else(|| refuse("every name for a clock means something else here"))?;
    let rate = rate(of).unwrap_or(UNKNOWN_RATE);
    let Style { end, step, width } = of.style;
    let begins = begins_line(text, start);
    let stop = line_stop(text, open);
    let inner = body_indentation(of, stop);
    let rest = text[open..stop].trim();
    let is_open = rest.is_empty() || rest.starts_with("//");
    let indent = match of.is_function {
        true if is_open => inner.as_str(),
        false if begins => indentation(text, start),
        _ => "",
    };
    let mut declared = vec![format!("{indent}let mut {clock} = {core}::Free::<{core}::Hz<{rate}>>::new();")];
    declared.extend(statements(of, guarded).into_iter().map(|statement| format!("{indent}{statement}")));
    let is_inline = if of.is_function { !is_open } else { !begins };
    let lent = guarded.iter().filter_map(|own| own.adaptation.as_ref());
    for own in lent {
        declared.extend(own.cells.iter().map(|cell| format!("{indent}{cell}")));
        declared.push(match is_inline {
            true => own.law.in_one_line(&own.name),
            false => own.law.statement(&own.name, indent, of.style),
        });
    }
    let clock_edit = if begins {
        let lines: String = declared.iter().map(|line| format!("{line}{end}")).collect();
        (insertion(of, above(text, start)), lines)
    } else {
        (insertion(of, start), format!("{} ", declared.join(" ")))
    };
    let list: Vec<String> = guarded.iter().map(entry).collect();
    let guard = format!("{core}::ceid!({clock}.begin_cycle() => {});", list.join(", "));
    let is_in_a_line_of_its_own = behind.is_none() && is_open;
    let guard = match is_in_a_line_of_its_own && inner.len() + guard.len() > width {
        true => {
            let list = list.join(&format!(",{end}{inner}{step}{step}"));
            let token = format!("{inner}{step}{clock}.begin_cycle() =>{end}{inner}{step}{step}{list}");
            format!("{core}::ceid!({end}{token}{end}{inner});")
        }
        false => guard,
    };
    let guard_edit = if let Some(before) = behind {
        let after = before.end as usize;
        let stop = line_stop(text, after);
        let rest = text[after..stop].trim();
        if text[..stop].ends_with('\n') && (rest.is_empty() || rest.starts_with("//")) {
            (insertion(of, stop), format!("{}{guard}{end}", indentation(text, before.start as usize)))
        } else {
            (insertion(of, after), format!(" {guard}"))
        }
    } else if is_open {
        (insertion(of, stop), format!("{inner}{guard}{end}"))
    } else {
        (insertion(of, open), format!(" {guard}"))
    };
    if of.is_function {
        let lines: String = declared.iter().map(|line| format!("{line}{end}")).collect();
        let head = if is_open {
            format!("{lines}{}", guard_edit.1)
        } else {
            format!(" {}{}", declared.join(" "), guard_edit.1)
        };
        return Ok(vec![(guard_edit.0, head)]);
    }
    Ok(vec![clock_edit, guard_edit])
}

/// The statement behind which the guard stands: the one that locks its filter, or the last of the first ones by which the loop is
/// left before anything is done with a filter.
pub(super) fn behind(of: &LoopBody<'_>, guarded: &[Guarded], exits: &Exits) -> Option<Span> {
    if let Some(lock) = guarded.iter().find_map(|own| own.locked) {
        return Some(lock);
    }
    if of.is_function || guarded.iter().any(Guarded::is_lent_above) || !guarded.iter().any(|own| is_observed(of, own)) {
        return None;
    }
    let ExprKind::Block(block) = of.kind(of.block) else { return None };
    let is_theirs = |id: &ExprId| {
        matches!(of.kind(*id), ExprKind::Opaque(_) | ExprKind::Unknown { .. })
            || guarded.iter().any(|own| is_about(of, &own.place, *id))
    };
    let holds = |stmt: &Stmt, id: &ExprId| stmt.span.contains(of.span(*id));
    let is_apart = |stmt: &&Stmt| stmt.cfg.is_none() && !of.inside.iter().filter(|id| holds(stmt, id)).any(is_theirs);
    let waits = exits.waits.iter().filter(|_| guarded.iter().any(|own| outlives_future(of, own)));
    let ends: Vec<ExprId> = exits.left_at.iter().chain(waits).copied().collect();
    let leaves = |stmt: &&Stmt| ends.iter().any(|end| holds(stmt, end));
    block.stmts.iter().take_while(is_apart).filter(leaves).last().map(|stmt| stmt.span)
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

/// How often a second the loop runs, if a sleep of constant length in it tells.
pub(super) fn rate(of: &LoopBody<'_>) -> Option<u64> {
    of.inside.iter().find_map(|id| {
        let ExprKind::Call { callee, args } = of.kind(*id) else { return None };
        let (ExprKind::Path(path), [length]) = (of.kind(*callee), args.as_slice()) else { return None };
        if path.last() != "sleep" {
            return None;
        }
        match of.typed.expr_def.get(length) {
            Some(Def::Value(id)) => {
                let value = of.program.index.value(*id).item.value.as_ref()?;
                per_second(value, value.root)
            }
            _ => per_second(of.body, *length),
        }
    })
}

/// How often a second something happens that takes a time, if that is a whole number.
fn per_second(body: &Body, length: ExprId) -> Option<u64> {
    let ExprKind::Call { callee, args } = &body.expr(length).kind else { return None };
    let (ExprKind::Path(unit), [number]) = (&body.expr(*callee).kind, args.as_slice()) else { return None };
    let ExprKind::Literal(Literal::Int(Some(number), _)) = &body.expr(*number).kind else { return None };
    let per_second = match unit.last() {
        "from_millis" => 1_000,
        "from_micros" => 1_000_000,
        _ => return None,
    };
    (*number > 0 && per_second % number == 0).then(|| per_second / number)
}
