//! The shares by package and file, and below them every cycle with its filters, closed as long as nobody opens them.

use std::collections::BTreeMap;

use super::{Badge, Escaped, Page};
use crate::count::{Cycle, CycleKind, Pair};
use crate::project::Project;
use crate::report::count;
use crate::report::progress::{PackageShares, Share, Shares, Standing};
use crate::report::proof::{counts, remarks};

/// Up to how many cycles are shown without being asked for.
const MOST_OPEN: usize = 20;

impl Page<'_> {
    pub(super) fn by_package(&mut self, all: Shares, packages: &[PackageShares<'_>]) {
        self.text += "<section>\n<h2>By crate and file</h2>\n<table>\n<caption>Cycles by how they stand.</caption>\n<thead><tr>\
                      <th scope=\"col\">Crate, file</th><th scope=\"col\" class=\"n\">All</th>";
        for standing in Standing::ALL {
            self.add(format_args!("<th scope=\"col\" class=\"n\">{}</th>", standing.name()));
        }
        self.text += "</tr></thead>\n";
        for package in packages.iter().filter(|package| package.shares.cycles.total > 0) {
            self.text += "<tbody>\n";
            self.row(&format!("<strong>{}</strong>", Escaped(package.name)), package.shares.cycles);
            for (file, shares) in package.files.iter().filter(|(_, shares)| shares.cycles.total > 0) {
                self.row(&format!("<code>{}</code>", Escaped(file)), shares.cycles);
            }
            self.text += "</tbody>\n";
        }
        if packages.len() > 1 {
            self.text += "<tbody>\n";
            self.row("<strong>in all</strong>", all.cycles);
            self.text += "</tbody>\n";
        }
        self.text += "</table>\n</section>\n";
    }

    fn row(&mut self, title: &str, share: Share) {
        self.add(format_args!(
            "<tr><th scope=\"row\">{title}</th><td class=\"n\" data-label=\"all\">{}</td>",
            share.total
        ));
        for standing in Standing::ALL {
            let (name, number) = (standing.name(), share.number(standing));
            let percent = share.percent(number).unwrap_or(0);
            self.add(format_args!("<td class=\"n\" data-label=\"{name}\">{number} ({percent}&nbsp;%)</td>"));
        }
        self.text += "</tr>\n";
    }

    /// Every cycle, by package and file.
    pub(super) fn files(&mut self, project: &Project, total: usize) {
        let mut by_file: BTreeMap<(&str, &str), Vec<&Cycle>> = BTreeMap::new();
        let report = self.report;
        for cycle in report.cycles.iter().filter(|cycle| !cycle.filters.is_empty()) {
            let package = project.packages.get(cycle.package).map_or("", |package| &package.name);
            by_file.entry((package, &report.sources.file(cycle.head.file).name)).or_default().push(cycle);
        }
        if by_file.is_empty() {
            return;
        }
        self.text += "<section>\n<h2>Every cycle</h2>\n";
        let mut last = None;
        let open = if total <= MOST_OPEN { " open" } else { "" };
        for ((package, file), cycles) in by_file {
            if last != Some(package) {
                self.add(format_args!("<h3>{}</h3>\n", Escaped(package)));
                last = Some(package);
            }
            let mut share = Share::default();
            cycles.iter().filter_map(|cycle| Standing::of_cycle(cycle)).for_each(|standing| share.add(standing));
            let parts = Standing::ALL.into_iter().filter(|standing| share.number(*standing) > 0);
            let parts: Vec<String> = parts.map(|it| format!("{} {}", share.number(it), it.name())).collect();
            self.add(format_args!(
                "<details{open}>\n<summary><code>{}</code><span class=\"soft\">{}: {}</span></summary>\n<div><table>\n\
                 <caption>Filters of each cycle.</caption>\n<thead><tr><th scope=\"col\">Filter</th>\
                 <th scope=\"col\">Type</th><th scope=\"col\">Standing</th><th scope=\"col\">Updates</th>\
                 <th scope=\"col\">Why</th></tr></thead>\n",
                Escaped(file),
                count(cycles.len(), "cycle"),
                parts.join(", ")
            ));
            cycles.into_iter().for_each(|cycle| self.cycle(cycle));
            self.text += "</table></div>\n</details>\n";
        }
        self.text += "</section>\n";
    }

    fn cycle(&mut self, cycle: &Cycle) {
        let line = self.report.sources.line(cycle.head);
        let what = match cycle.kind {
            CycleKind::Function => "function".to_owned(),
            kind => format!("{} in", kind.name()),
        };
        self.add(format_args!(
            "<tbody class=\"cycle\"><tr><th scope=\"rowgroup\" colspan=\"5\">line {line}: {what} <code>{}</code></th></tr>\n",
            Escaped(&cycle.function)
        ));
        cycle.filters.iter().for_each(|pair| self.pair(pair));
        self.text += "</tbody>\n";
    }

    fn pair(&mut self, pair: &Pair) {
        self.add(format_args!(
            "<tr><td><code>{}</code></td><td data-label=\"Type\"><code>{}</code></td><td data-label=\"Standing\">{}</td>\
             <td data-label=\"Updates\">{}</td>",
            Escaped(&pair.name),
            Escaped(&pair.filter_type),
            Badge(Standing::of_pair(pair)),
            Escaped(counts(pair)),
        ));
        let remarks = remarks(pair);
        // A cell that has nothing to say needs no label.
        let label = if remarks.is_empty() { "" } else { " data-label=\"Why\"" };
        self.add(format_args!("<td{label}><span>{}</span></td></tr>\n", Escaped(remarks.join("; "))));
    }
}
