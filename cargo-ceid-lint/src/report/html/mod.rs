//! The proof report as one page that needs nothing else: no script, no font, no picture, no network.

mod files;

use std::fmt::{self, Display, Write};

use super::count;
use super::progress::{Shares, Standing, Trend, blockers, shares};
use crate::pipeline::Report;
use crate::project::Project;
use crate::rules;
use crate::source::Span;

const STYLE: &str = include_str!("style.css");

/// How many places a row of a list names.
const MOST_PLACES: usize = 5;

/// The page.
#[must_use]
pub fn page(project: &Project, report: &Report, trend: Option<&Trend>) -> String {
    let (all, packages) = shares(project, report);
    let name = name(project);
    let mut page = Page { text: String::new(), report };
    page.add(format_args!(
        "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <meta name=\"color-scheme\" content=\"light dark\">\n<title>Control cycles of {}</title>\n\
         <style>\n{STYLE}</style>\n</head>\n<body>\n",
        Escaped(&name)
    ));
    page.header(&name, all);
    page.text += "<main>\n";
    page.standing(all, trend);
    if let Some(trend) = trend {
        page.trend(trend);
    }
    page.blockers();
    if !packages.is_empty() {
        page.by_package(all, &packages);
    }
    page.files(project, all.cycles.total);
    page.unread();
    page.text += "</main>\n";
    page.footer();
    page.text += "</body>\n</html>\n";
    page.text
}

/// What the code is called: the package if there is one, else the directory.
fn name(project: &Project) -> String {
    let mut reported = project.packages.iter().filter(|package| package.is_reported);
    match (reported.next(), reported.next()) {
        (Some(only), None) => only.name.clone(),
        _ => project
            .root
            .file_name()
            .map_or_else(|| "the workspace".to_owned(), |name| name.to_string_lossy().into_owned()),
    }
}

/// The page as far as it is written.
struct Page<'a> {
    text: String,
    report: &'a Report,
}

impl Page<'_> {
    fn add(&mut self, text: fmt::Arguments<'_>) {
        // Writing to a string cannot fail.
        let _ = self.text.write_fmt(text);
    }

    fn header(&mut self, name: &str, all: Shares) {
        let good = all.cycles.proved + all.cycles.guarded;
        self.add(format_args!("<header>\n<h1>Control cycles of <code>{}</code></h1>\n", Escaped(name)));
        match all.cycles.percent(good) {
            Some(percent) => self.add(format_args!(
                "<p class=\"lead\">{good} of {} proved ({percent}&nbsp;%): each filter is updated exactly once per cycle. \
                 Of these, {} by guards, so that it stays so.</p>\n",
                count(all.cycles.total, "control cycle"),
                all.cycles.guarded
            )),
            None => self.text += "<p class=\"lead\">There is no control cycle that has to do with a filter.</p>\n",
        }
        self.text += "</header>\n";
    }

    /// The shares of all, beside those of before.
    fn standing(&mut self, all: Shares, trend: Option<&Trend>) {
        self.text += "<section>\n<h2>Where it stands</h2>\n";
        if all.cycles.total > 0 {
            self.text += "<div class=\"bar\" aria-hidden=\"true\">";
            for standing in Standing::ALL {
                let number = all.cycles.number(standing);
                if number > 0 {
                    self.add(format_args!("<i class=\"{}\" style=\"flex:{number}\"></i>", standing.name()));
                }
            }
            self.text += "</div>\n";
        }
        self.text += "<table>\n<caption>A cycle stands as the worst of its filters.</caption>\n<thead><tr>\
                      <th scope=\"col\">Standing</th><th scope=\"col\" class=\"n\">Cycles</th>\
                      <th scope=\"col\" class=\"n\">Share</th><th scope=\"col\" class=\"n\">Filters</th>";
        if trend.is_some() {
            self.text +=
                "<th scope=\"col\" class=\"n\">Cycles before</th><th scope=\"col\" class=\"n\">Filters before</th>";
        }
        self.text += "</tr></thead>\n<tbody>\n";
        for standing in Standing::ALL {
            let (cycles, filters) = (all.cycles.number(standing), all.filters.number(standing));
            let percent = all.cycles.percent(cycles).unwrap_or(0);
            self.add(format_args!(
                "<tr><th scope=\"row\">{}</th><td class=\"n\" data-label=\"Cycles\">{cycles}</td>\
                 <td class=\"n\" data-label=\"Share\">{percent}&nbsp;%</td>\
                 <td class=\"n\" data-label=\"Filters\">{filters}</td>",
                Badge(standing)
            ));
            if let Some(Trend { before, .. }) = trend {
                self.add(format_args!(
                    "<td class=\"n\" data-label=\"Before\">{}{}</td><td class=\"n\" data-label=\"Filters before\">{}{}</td>",
                    before.cycles.number(standing),
                    Change(before.cycles.number(standing), cycles),
                    before.filters.number(standing),
                    Change(before.filters.number(standing), filters),
                ));
            }
            self.text += "</tr>\n";
        }
        self.text += "</tbody>\n</table>\n";
        let known = self.report.cycles.iter().flat_map(|cycle| &cycle.filters).filter(|pair| pair.known).count();
        if known > 0 {
            let are = if known == 1 { "is" } else { "are" };
            self.add(format_args!(
                "<p class=\"soft\">{} {are} known: the baseline holds what is found on them.</p>\n",
                count(known, "filter")
            ));
        }
        self.text += "</section>\n";
    }

    fn trend(&mut self, trend: &Trend) {
        self.text += "<section>\n<h2>Since the previous report</h2>\n";
        self.add(format_args!("<p>{} better, {} worse.</p>\n", count(trend.better, "filter"), trend.worse.len()));
        if !trend.worse.is_empty() {
            self.text += "<table>\n<caption>Filters that stand worse, or are new and not proved.</caption>\n<thead><tr>\
                          <th scope=\"col\">Filter</th><th scope=\"col\">Function</th><th scope=\"col\">Place</th>\
                          <th scope=\"col\">Before</th><th scope=\"col\">Now</th></tr></thead>\n<tbody>\n";
        }
        for it in &trend.worse {
            let place = self.place(it.place);
            let before = it.before.map_or_else(|| "new".to_owned(), |before| Badge(before).to_string());
            self.add(format_args!(
                "<tr><th scope=\"row\"><code>{}</code></th><td data-label=\"Function\"><code>{}</code></td>\
                 <td data-label=\"Place\"><code>{place}</code></td><td data-label=\"Before\">{before}</td>\
                 <td data-label=\"Now\">{}</td></tr>\n",
                Escaped(&it.filter),
                Escaped(&it.function),
                Badge(it.now)
            ));
        }
        if !trend.worse.is_empty() {
            self.text += "</tbody>\n</table>\n";
        }
        self.text += "</section>\n";
    }

    fn blockers(&mut self) {
        let blockers = blockers(self.report);
        if blockers.is_empty() {
            return;
        }
        self.text += "<section>\n<h2>What stands in the way</h2>\n<table>\n\
                      <caption>Why the other filters are not proved, the most frequent reason first.</caption>\n<thead><tr>\
                      <th scope=\"col\">Reason</th><th scope=\"col\" class=\"n\">Filters</th>\
                      <th scope=\"col\" class=\"n\">Cycles</th><th scope=\"col\">Where</th></tr></thead>\n<tbody>\n";
        for blocker in &blockers {
            let rule = blocker.is_rule.then(|| rules::find(&blocker.what)).flatten();
            let reason = match rule {
                Some(rule) => format!("<code>{}</code>: {}", Escaped(&blocker.what), Escaped(rule.summary)),
                None => format!("cannot be decided: {}", Escaped(&blocker.what)),
            };
            let names: Vec<String> =
                blocker.names.iter().take(MOST_PLACES).map(|name| format!("<code>{}</code>", Escaped(name))).collect();
            let names = listed(&names, blocker.names.len());
            let names = if names.is_empty() { names } else { format!("<br><span class=\"soft\">{names}</span>") };
            let places: Vec<String> = blocker.places.iter().take(MOST_PLACES).map(|place| self.place(*place)).collect();
            let places: Vec<String> = places.iter().map(|place| format!("<code>{place}</code>")).collect();
            self.add(format_args!(
                "<tr><th scope=\"row\">{reason}{names}</th><td class=\"n\" data-label=\"Filters\">{}</td>\
                 <td class=\"n\" data-label=\"Cycles\">{}</td><td data-label=\"Where\"><span>{}</span></td></tr>\n",
                blocker.filters,
                blocker.cycles,
                listed(&places, blocker.places.len())
            ));
        }
        self.text += "</tbody>\n</table>\n<p class=\"soft\"><code>cargo ceid-lint explain</code> tells of each rule what is wrong \
                      and what to write instead.</p>\n</section>\n";
    }

    fn unread(&mut self) {
        let unread: Vec<_> = self.report.problems.iter().chain(&self.report.unread).collect();
        if unread.is_empty() {
            return;
        }
        self.text += "<section>\n<h2>What was not read</h2>\n<ul>\n";
        for problem in unread {
            let line = problem.span.map_or(String::new(), |span| format!(":{}", self.report.sources.line(span)));
            let help = problem.help.as_ref().map_or(String::new(), |help| format!("; {help}"));
            self.add(format_args!(
                "<li><code>{}{line}</code>: {}{}</li>\n",
                Escaped(&problem.file),
                Escaped(&problem.message),
                Escaped(&help)
            ));
        }
        self.text += "</ul>\n</section>\n";
    }

    fn footer(&mut self) {
        self.text += "<footer>\n<h2>Words</h2>\n<dl>\n";
        for (standing, meaning) in [
            (
                Standing::Guarded,
                "exactly one update on every path, and a guard of ceid-core makes it: it cannot be skipped",
            ),
            (Standing::Proved, "exactly one update on every path, or once whenever a gate opens or a sample comes"),
            (
                Standing::Unproved,
                "something that could matter cannot be seen; the cause is named, and nothing is guessed",
            ),
            (Standing::Violated, "a path misses the update, or makes it twice"),
        ] {
            self.add(format_args!("<dt>{}</dt><dd>{meaning}</dd>\n", Badge(standing)));
        }
        self.add(format_args!("</dl>\n<p>Made by cargo ceid-lint {}.</p>\n</footer>\n", env!("CARGO_PKG_VERSION")));
    }

    /// `src/main.rs:3`, escaped.
    fn place(&self, place: Span) -> String {
        let file = &self.report.sources.file(place.file).name;
        format!("{}:{}", Escaped(file), self.report.sources.line(place))
    }
}

/// The first of a list, and how many more there are.
fn listed(first: &[String], all: usize) -> String {
    let more = all - first.len();
    let rest = if more > 0 { format!(" and {more} more") } else { String::new() };
    first.join(", ") + &rest
}

/// A standing, by its word and a sign: never by colour alone.
#[derive(Clone, Copy)]
struct Badge(Standing);

impl Display for Badge {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let sign = match self.0 {
            Standing::Guarded => "◆",
            Standing::Proved => "✓",
            Standing::Unproved => "?",
            Standing::Violated => "✗",
        };
        let name = self.0.name();
        write!(f, "<b class=\"{name}\"><span aria-hidden=\"true\">{sign}</span> {name}</b>")
    }
}

/// By how much a number has changed.
struct Change(usize, usize);

impl Display for Change {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self(before, now) = *self;
        match now.cmp(&before) {
            std::cmp::Ordering::Greater => write!(f, " (+{})", now - before),
            std::cmp::Ordering::Less => write!(f, " (−{})", before - now),
            std::cmp::Ordering::Equal => f.write_str(" (=)"),
        }
    }
}

/// A text in which nothing is read as markup.
struct Escaped<T>(T);

impl<T: AsRef<str>> Display for Escaped<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for letter in self.0.as_ref().chars() {
            match letter {
                '&' => f.write_str("&amp;")?,
                '<' => f.write_str("&lt;")?,
                '>' => f.write_str("&gt;")?,
                '"' => f.write_str("&quot;")?,
                '\'' => f.write_str("&#39;")?,
                letter if letter.is_control() && !letter.is_whitespace() => f.write_char('\u{fffd}')?,
                letter => f.write_char(letter)?,
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests;
