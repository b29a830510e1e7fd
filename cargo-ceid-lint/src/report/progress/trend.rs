//! What has become better and what worse since a previous report.

use std::collections::BTreeMap;

use serde::Deserialize;

use super::{Shares, Standing};
use crate::pipeline::Report;
use crate::project::Project;
use crate::source::Span;

/// A report of before, as it was written in JSON.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Previous {
    shares: Shares,
    /// How each filter stood: those of one name in one function in their order.
    standings: BTreeMap<Name, Vec<Standing>>,
}

/// By what a filter is known again: package, file, function and its own name.
type Name = (String, String, String, String);

#[derive(Deserialize)]
struct Document {
    schema: u32,
    cycles: Vec<CycleRow>,
}

#[derive(Deserialize)]
struct CycleRow {
    package: String,
    file: String,
    function: String,
    filters: Vec<PairRow>,
}

#[derive(Deserialize)]
struct PairRow {
    name: String,
    verdict: String,
    #[serde(default)]
    rules: Vec<String>,
}

/// What has changed.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Trend {
    /// The shares of before.
    pub before: Shares,
    /// How many filters stand better.
    pub better: usize,
    /// Those that stand worse, or are new and not proved.
    pub worse: Vec<Worse>,
}

/// A filter that stands worse.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Worse {
    /// The head of its cycle.
    pub place: Span,
    /// The function of the cycle.
    pub function: String,
    /// The filter.
    pub filter: String,
    /// How it stood; `None` if it was not there.
    pub before: Option<Standing>,
    /// How it stands.
    pub now: Standing,
}

impl Previous {
    /// Reads the JSON form of a report.
    ///
    /// # Errors
    /// Why it is none.
    pub fn read(text: &str) -> Result<Self, String> {
        let document: Document = serde_json::from_str(text).map_err(|error| format!("it is no report: {error}"))?;
        if document.schema != 1 {
            return Err(format!("its form is {}, and only 1 is known", document.schema));
        }
        let mut previous = Self::default();
        for cycle in document.cycles {
            let standings: Option<Vec<Standing>> = cycle.filters.iter().map(standing).collect();
            let Some(standings) = standings else {
                return Err(format!("it has a verdict that is not known, in `{}` of `{}`", cycle.function, cycle.file));
            };
            standings.iter().for_each(|standing| previous.shares.filters.add(*standing));
            if let Some(worst) = standings.iter().min() {
                previous.shares.cycles.add(*worst);
            }
            for (pair, standing) in cycle.filters.into_iter().zip(standings) {
                let name = (cycle.package.clone(), cycle.file.clone(), cycle.function.clone(), pair.name);
                previous.standings.entry(name).or_default().push(standing);
            }
        }
        Ok(previous)
    }

    /// What the report has changed.
    #[must_use]
    pub fn trend(&self, project: &Project, report: &Report) -> Trend {
        let mut trend = Trend { before: self.shares, ..Trend::default() };
        let mut seen: BTreeMap<Name, usize> = BTreeMap::new();
        for cycle in &report.cycles {
            let package = project.packages.get(cycle.package).map_or("", |package| &package.name);
            let file = &report.sources.file(cycle.head.file).name;
            for pair in &cycle.filters {
                let name: Name = (package.to_owned(), file.clone(), cycle.function.clone(), pair.name.clone());
                let number = seen.entry(name.clone()).or_default();
                let before = self.standings.get(&name).and_then(|list| list.get(*number)).copied();
                *number += 1;
                let now = Standing::of_pair(pair);
                trend.better += usize::from(before.is_some_and(|before| before < now));
                if before.map_or(now < Standing::Proved, |before| now < before) {
                    let (function, filter) = (cycle.function.clone(), pair.name.clone());
                    trend.worse.push(Worse { place: cycle.head, function, filter, before, now });
                }
            }
        }
        trend
    }
}

fn standing(pair: &PairRow) -> Option<Standing> {
    use crate::count::Verdict;
    let all = [
        Verdict::Once,
        Verdict::Guarded,
        Verdict::OnceOrReset,
        Verdict::PerSample,
        Verdict::Gated,
        Verdict::Missed,
        Verdict::Repeated,
        Verdict::Skipped,
        Verdict::Unproved,
    ];
    let verdict = all.into_iter().find(|known| known.name() == pair.verdict)?;
    let rules = pair.rules.iter().map(|rule| rule.trim_start_matches("ceid::"));
    Some(Standing::of(verdict, rules))
}

#[cfg(test)]
mod tests {
    use super::super::shares;
    use super::*;
    use crate::report::{proof, sample};

    #[test]
    fn a_report_has_not_changed_since_itself() {
        let (project, report) = sample::report();
        let previous = Previous::read(&proof::json(&project, &report, None)).unwrap();
        let trend = previous.trend(&project, &report);
        assert_eq!((trend.better, trend.worse.len()), (0, 0));
        assert_eq!(trend.before, shares(&project, &report).0);
    }

    #[test]
    fn better_and_worse_are_told_apart() {
        let (project, report) = sample::report();
        let text = proof::json(&project, &report, None);
        let worse = Previous::read(&text.replace("\"repeated\"", "\"once\"")).unwrap().trend(&project, &report);
        assert_eq!((worse.better, worse.worse.len()), (0, 1));
        assert_eq!((worse.worse[0].before, worse.worse[0].now), (Some(Standing::Proved), Standing::Violated));
        let better = Previous::read(&text.replace("\"once\"", "\"missed\"")).unwrap().trend(&project, &report);
        assert_eq!((better.better, better.worse.len()), (1, 0));
        let new = Previous::read("{\"schema\": 1, \"cycles\": []}").unwrap().trend(&project, &report);
        assert_eq!((new.better, new.worse.len()), (0, 3));
    }

    #[test]
    fn what_is_no_report_is_told() {
        assert!(Previous::read("[]").unwrap_err().contains("no report"));
        assert_eq!(
            Previous::read("{\"schema\": 2, \"cycles\": []}").unwrap_err(),
            "its form is 2, and only 1 is known"
        );
        let odd = "{\"schema\": 1, \"cycles\": [{\"package\": \"a\", \"file\": \"a.rs\", \"function\": \"f\", \
                   \"filters\": [{\"name\": \"kf\", \"verdict\": \"fine\"}]}]}";
        assert!(Previous::read(odd).unwrap_err().contains("`f` of `a.rs`"));
    }
}
