//! The table of rules, for people and for programs.

use serde::Serialize;

use super::{Paint, Style};
use crate::rules::{GROUPS, RULES};

/// The table for people: rules by name, then the groups.
#[must_use]
pub fn human(style: Style) -> String {
    let name_width = RULES.iter().map(|rule| rule.id().len()).max().unwrap_or(0);
    let group_width = GROUPS.iter().map(|group| group.name().len()).max().unwrap_or(0);
    let mut text = String::new();
    for rule in RULES {
        let name = style.paint(Paint::Bold, &format!("{:name_width$}", rule.id()));
        let (level, group) = (rule.default_level.name(), rule.group.name());
        text += &format!("{name}  {level:5}  {group:group_width$}  {}\n", rule.summary);
    }
    text += "\n";
    for group in GROUPS {
        let name = style.paint(Paint::Bold, &format!("{:name_width$}", format!("ceid::{}", group.name())));
        text += &format!("{name}  {:5}  {:group_width$}  {}\n", group.default_level().name(), "", group.summary());
    }
    text += &format!(
        "{}  {:5}  {:group_width$}  every rule\n",
        style.paint(Paint::Bold, &format!("{:name_width$}", "ceid::all")),
        "",
        ""
    );
    text
}

#[derive(Serialize)]
struct Row {
    name: String,
    group: String,
    default_level: &'static str,
    summary: &'static str,
    explanation: &'static str,
}

/// The table as a JSON list.
#[must_use]
pub fn json() -> String {
    let rows: Vec<Row> = RULES
        .iter()
        .map(|rule| Row {
            name: rule.id(),
            group: format!("ceid::{}", rule.group.name()),
            default_level: rule.default_level.name(),
            summary: rule.summary,
            explanation: rule.explanation,
        })
        .collect();
    let mut text = serde_json::to_string_pretty(&rows).expect("strings are valid JSON");
    text.push('\n');
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_rule_is_in_both_tables() {
        let list: Vec<serde_json::Value> = serde_json::from_str(&json()).unwrap();
        assert_eq!(list.len(), RULES.len());
        for rule in RULES {
            assert!(human(Style::default()).contains(&rule.id()));
        }
    }
}
