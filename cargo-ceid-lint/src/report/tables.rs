//! The tables of the proof report for people: the share of cycles that are proved, what stands in the way, and the trend.

use std::fmt::Write;

use super::progress::{Share, Standing, Trend, blockers, shares};
use super::{Paint, Style, count};
use crate::pipeline::Report;
use crate::project::Project;

/// How many rows a list has at most: the JSON form and the page have all.
const MOST_ROWS: usize = 10;

/// All tables that have something to tell.
pub(super) fn tables(project: &Project, report: &Report, trend: Option<&Trend>, style: Style) -> String {
    let mut text = String::new();
    let (all, packages) = shares(project, report);
    if all.cycles.total == 0 && trend.is_none() {
        return text;
    }
    let mut rows: Vec<(String, Share)> = Vec::new();
    for package in &packages {
        rows.push((package.name.to_owned(), package.shares.cycles));
        rows.extend(package.files.iter().map(|(file, shares)| (format!("  {file}"), shares.cycles)));
    }
    if packages.len() > 1 {
        rows.push(("in all".to_owned(), all.cycles));
    }
    rows.retain(|(_, share)| share.total > 0);
    text += &table(&rows, style);
    text += &in_the_way(report, style);
    if let Some(trend) = trend {
        text += &changes(report, trend, all.cycles, style);
    }
    text
}

fn table(rows: &[(String, Share)], style: Style) -> String {
    let name = rows.iter().map(|(name, _)| name.chars().count()).max().unwrap_or(0).max("cycles of".len());
    let mut head = format!("{:name$}  {:>6}", "cycles of", "all");
    for standing in Standing::ALL {
        let _ = write!(head, "  {:>12}", standing.name());
    }
    let mut text = format!("{}\n", style.paint(Paint::Bold, &head));
    for (title, share) in rows {
        let _ = write!(text, "{title:name$}  {:>6}", share.total);
        for standing in Standing::ALL {
            let number = share.number(standing);
            let percent = share.percent(number).unwrap_or(0);
            let _ = write!(text, "  {:>12}", format!("{number} ({percent} %)"));
        }
        text.push('\n');
    }
    text
}

fn in_the_way(report: &Report, style: Style) -> String {
    let blockers = blockers(report);
    if blockers.is_empty() {
        return String::new();
    }
    let mut text = format!("{}\n", style.paint(Paint::Bold, "in the way of the rest"));
    for blocker in blockers.iter().take(MOST_ROWS) {
        let names: Vec<String> = blocker.names.iter().take(3).map(|name| format!("`{name}`")).collect();
        let more = blocker.names.len().saturating_sub(names.len());
        let more = if more > 0 { format!(" and {more} more") } else { String::new() };
        let names = if names.is_empty() { String::new() } else { format!(": {}{more}", names.join(", ")) };
        let place = blocker.places.first().map_or(String::new(), |place| {
            format!("; first {}:{}", report.sources.file(place.file).name, report.sources.line(*place))
        });
        let (filters, cycles) = (count(blocker.filters, "filter"), count(blocker.cycles, "cycle"));
        let _ = writeln!(text, "  {filters} in {cycles}: {}{names}{place}", blocker.what);
    }
    text + &more(blockers.len())
}

fn changes(report: &Report, trend: &Trend, now: Share, style: Style) -> String {
    let before = trend.before.cycles;
    let mut text = format!("{}\n", style.paint(Paint::Bold, "since the previous report"));
    let parts = Standing::ALL.map(|it| format!("{} {} -> {}", it.name(), before.number(it), now.number(it)));
    let _ = writeln!(text, "  cycles: {} -> {}; {}", before.total, now.total, parts.join(", "));
    let (better, worse) = (count(trend.better, "filter"), trend.worse.len());
    let _ = writeln!(text, "  {better} better, {worse} worse");
    for it in trend.worse.iter().take(MOST_ROWS) {
        let (file, line) = (&report.sources.file(it.place.file).name, report.sources.line(it.place));
        let before = it.before.map_or("new", Standing::name);
        let _ = writeln!(text, "  {file}:{line} `{}` in `{}`: {before} -> {}", it.filter, it.function, it.now.name());
    }
    text + &more(worse)
}

fn more(all: usize) -> String {
    match all.checked_sub(MOST_ROWS) {
        None | Some(0) => String::new(),
        Some(more) => format!("  … and {more} more, which `--message-format json` lists\n"),
    }
}
