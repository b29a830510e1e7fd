//! The proof report: every cycle and filter with its verdict, for people and as JSON.

use serde::Serialize;

use super::progress::{Blocker, PackageShares, Shares, Standing, Trend, blockers, shares};
use super::{Paint, Style, Summary, tables};
use crate::count::{Cycle, Gate, Pair, Verdict};
use crate::diagnostic::Problem;
use crate::pipeline::Report;
use crate::project::Project;
use crate::source::{SourceMap, Span};

#[derive(Serialize)]
struct Proof<'a> {
    schema: u32,
    cycles: Vec<CycleRow<'a>>,
    unread: Vec<Unread<'a>>,
    summary: Shares,
    packages: Vec<PackageRow<'a>>,
    blockers: Vec<BlockerRow<'a>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    trend: Option<TrendRow<'a>>,
}

#[derive(Serialize)]
struct PackageRow<'a> {
    name: &'a str,
    #[serde(flatten)]
    shares: Shares,
    files: Vec<FileRow<'a>>,
}

#[derive(Serialize)]
struct FileRow<'a> {
    file: &'a str,
    #[serde(flatten)]
    shares: Shares,
}

#[derive(Serialize)]
struct BlockerRow<'a> {
    rule: Option<String>,
    cause: Option<String>,
    names: Vec<String>,
    filters: usize,
    cycles: usize,
    places: Vec<Place<'a>>,
}

#[derive(Serialize)]
struct Place<'a> {
    file: &'a str,
    line: u32,
}

#[derive(Serialize)]
struct TrendRow<'a> {
    before: Shares,
    better: usize,
    worse: Vec<WorseRow<'a>>,
}

#[derive(Serialize)]
struct WorseRow<'a> {
    #[serde(flatten)]
    place: Place<'a>,
    function: &'a str,
    filter: &'a str,
    before: Option<&'static str>,
    now: &'static str,
}

#[derive(Serialize)]
struct CycleRow<'a> {
    package: &'a str,
    file: &'a str,
    line: u32,
    column: u32,
    kind: &'static str,
    function: &'a str,
    filters: Vec<PairRow<'a>>,
}

#[derive(Serialize)]
struct PairRow<'a> {
    name: &'a str,
    #[serde(rename = "type")]
    filter_type: &'a str,
    law: &'a str,
    verdict: &'static str,
    counts: &'a [u8],
    gate: Option<&'static str>,
    rules: Vec<String>,
    cause: Option<&'a str>,
    suppressed: Option<&'a str>,
    known: bool,
}

#[derive(Serialize)]
struct Unread<'a> {
    file: &'a str,
    line: u32,
    cause: &'a str,
    help: Option<&'a str>,
}

/// The report as one JSON object.
#[must_use]
pub fn json(project: &Project, report: &Report, trend: Option<&Trend>) -> String {
    let sources = &report.sources;
    let (summary, packages) = shares(project, report);
    let proof = Proof {
        schema: 1,
        cycles: report.cycles.iter().map(|cycle| cycle_row(project, &report.sources, cycle)).collect(),
        unread: report.problems.iter().chain(&report.unread).map(|problem| unread(&report.sources, problem)).collect(),
        summary,
        packages: packages.into_iter().map(package_row).collect(),
        blockers: blockers(report).into_iter().map(|blocker| blocker_row(sources, blocker)).collect(),
        trend: trend.map(|trend| trend_row(sources, trend)),
    };
    let mut text = serde_json::to_string_pretty(&proof).expect("strings and numbers are valid JSON");
    text.push('\n');
    text
}

fn package_row(package: PackageShares<'_>) -> PackageRow<'_> {
    let files = package.files.into_iter().map(|(file, shares)| FileRow { file, shares }).collect();
    PackageRow { name: package.name, shares: package.shares, files }
}

fn blocker_row(sources: &SourceMap, blocker: Blocker) -> BlockerRow<'_> {
    let (rule, cause) = if blocker.is_rule { (Some(blocker.what), None) } else { (None, Some(blocker.what)) };
    BlockerRow {
        rule,
        cause,
        names: blocker.names.into_iter().collect(),
        filters: blocker.filters,
        cycles: blocker.cycles,
        places: blocker.places.into_iter().map(|place| place_row(sources, place)).collect(),
    }
}

fn trend_row<'a>(sources: &'a SourceMap, trend: &'a Trend) -> TrendRow<'a> {
    let worse = trend.worse.iter().map(|it| WorseRow {
        place: place_row(sources, it.place),
        function: &it.function,
        filter: &it.filter,
        before: it.before.map(Standing::name),
        now: it.now.name(),
    });
    TrendRow { before: trend.before, better: trend.better, worse: worse.collect() }
}

fn place_row(sources: &SourceMap, place: Span) -> Place<'_> {
    Place { file: &sources.file(place.file).name, line: sources.line(place) }
}

fn cycle_row<'a>(project: &'a Project, sources: &'a SourceMap, cycle: &'a Cycle) -> CycleRow<'a> {
    let place = sources.position(cycle.head);
    CycleRow {
        package: package_name(project, cycle),
        file: &sources.file(cycle.head.file).name,
        line: place.line,
        column: place.column,
        kind: cycle.kind.name(),
        function: &cycle.function,
        filters: cycle.filters.iter().map(pair_row).collect(),
    }
}

fn package_name<'a>(project: &'a Project, cycle: &Cycle) -> &'a str {
    project.packages.get(cycle.package).map_or("", |package| &package.name)
}

fn pair_row(pair: &Pair) -> PairRow<'_> {
    PairRow {
        name: &pair.name,
        filter_type: &pair.filter_type,
        law: &pair.law,
        verdict: pair.verdict.name(),
        counts: &pair.counts,
        gate: pair.gate.map(Gate::name),
        rules: pair.rules.iter().map(|rule| format!("ceid::{rule}")).collect(),
        cause: pair.cause.as_deref(),
        suppressed: pair.suppressed.as_deref(),
        known: pair.known,
    }
}

fn unread<'a>(sources: &SourceMap, problem: &'a Problem) -> Unread<'a> {
    Unread {
        file: &problem.file,
        line: problem.span.map_or(1, |span| sources.line(span)),
        cause: &problem.message,
        help: problem.help.as_deref(),
    }
}

/// The report for people: a line for each cycle, an aligned line for each filter, and the summary.
#[must_use]
pub fn human(project: &Project, report: &Report, trend: Option<&Trend>, style: Style) -> String {
    let pairs = || report.cycles.iter().flat_map(|cycle| &cycle.filters);
    let width = |length: &dyn Fn(&Pair) -> usize| pairs().map(length).max().unwrap_or(0);
    let widths = Widths {
        name: width(&|pair| pair.name.chars().count()),
        filter_type: width(&|pair| pair.filter_type.chars().count()),
        law: width(&|pair| pair.law.chars().count()),
        verdict: width(&|pair| pair.verdict.name().len()),
        counts: width(&|pair| counts(pair).len()),
    };
    let mut text = String::new();
    for cycle in &report.cycles {
        let place = report.sources.position(cycle.head);
        let file = &report.sources.file(cycle.head.file).name;
        let head = format!("{file}:{}:{}", place.line, place.column);
        let (package, kind) = (package_name(project, cycle), cycle.kind.name());
        let place = match cycle.kind {
            crate::count::CycleKind::Function => format!("function `{}`", cycle.function),
            _ => format!("{kind} in `{}`", cycle.function),
        };
        text += &format!("{} {place} ({package})\n", style.paint(Paint::Bold, &head));
        for pair in &cycle.filters {
            text += &format!("  {}\n", line(pair, &widths, style).trim_end());
        }
    }
    for problem in report.problems.iter().chain(&report.unread) {
        let (paint, line) = if problem.is_error {
            (Paint::Red, super::short::problem(&report.sources, problem))
        } else {
            (Paint::Yellow, super::unread::line(&report.sources, problem))
        };
        text += &format!("{} {}\n", style.paint(paint, "unread:"), line.trim_end());
    }
    text += &tables::tables(project, report, trend, style);
    text + &Summary::of(report).line() + "\n"
}

struct Widths {
    name: usize,
    filter_type: usize,
    law: usize,
    verdict: usize,
    counts: usize,
}

fn line(pair: &Pair, widths: &Widths, style: Style) -> String {
    let paint = match pair.verdict {
        Verdict::Unproved => Paint::Yellow,
        _ if pair.is_proved() => Paint::Green,
        _ => Paint::Red,
    };
    let verdict = style.paint(paint, &format!("{:width$}", pair.verdict.name(), width = widths.verdict));
    format!(
        "{:name$}  {:filter_type$}  {:law$}  {verdict}  {:counts$}  {}",
        pair.name,
        pair.filter_type,
        pair.law,
        counts(pair),
        remarks(pair).join("; "),
        name = widths.name,
        filter_type = widths.filter_type,
        law = widths.law,
        counts = widths.counts,
    )
}

/// What is to be said of a pair beyond its verdict: the gate, the cause, the rules, and what hides them.
#[must_use]
pub fn remarks(pair: &Pair) -> Vec<String> {
    let mut remarks = Vec::new();
    remarks.extend(pair.gate.map(|gate| {
        let article = if gate == Gate::Event { "an" } else { "a" };
        format!("by {article} {} gate", gate.name())
    }));
    remarks.extend(pair.cause.clone());
    remarks.extend(pair.rules.iter().map(|rule| format!("ceid::{rule}")));
    remarks.extend(
        pair.suppressed
            .as_ref()
            .map(|reason| if reason.is_empty() { "suppressed".to_owned() } else { format!("suppressed: {reason}") }),
    );
    remarks.extend(pair.known.then(|| "known".to_owned()));
    remarks
}

/// `0 or many`
#[must_use]
pub fn counts(pair: &Pair) -> String {
    let words: Vec<&str> = pair
        .counts
        .iter()
        .map(|count| match count {
            0 => "0",
            1 => "1",
            _ => "many",
        })
        .collect();
    words.join(" or ")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::sample;

    #[test]
    fn the_json_form_is_the_documented_one() {
        let (project, report) = sample::report();
        let text = json(&project, &report, None);
        let value: serde_json::Value = serde_json::from_str(&text).unwrap();
        let filters: usize =
            value["cycles"].as_array().unwrap().iter().map(|cycle| cycle["filters"].as_array().unwrap().len()).sum();
        assert_eq!(filters, report.cycles.iter().map(|cycle| cycle.filters.len()).sum::<usize>());
        assert_eq!(value["unread"].as_array().unwrap().len(), report.problems.len());
        let first: String = text.lines().take(24).map(|line| format!("{line}\n")).collect();
        insta::assert_snapshot!(first);
    }

    #[test]
    fn an_empty_report_is_valid() {
        let text = json(&Project::default(), &Report::default(), None);
        let none = serde_json::json!({ "total": 0, "proved": 0, "guarded": 0, "violated": 0, "unproved": 0 });
        assert_eq!(
            serde_json::from_str::<serde_json::Value>(&text).unwrap(),
            serde_json::json!({
                "schema": 1, "cycles": [], "unread": [], "summary": { "cycles": none, "filters": none },
                "packages": [], "blockers": [],
            })
        );
    }

    #[test]
    fn people_get_aligned_lines() {
        let (project, report) = sample::report();
        insta::assert_snapshot!(human(&project, &report, None, Style::default()));
    }
}
