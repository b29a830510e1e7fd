//! `cargo ceid-lint explain RULE`.

use super::args::{ExplainArgs, Talk};
use super::{Console, ExitStatus};
use crate::rules::{ALL, GROUPS, RULES, Rule, find, unknown_name};

/// Prints the long text of a rule, or the rules of a group.
///
/// # Errors
/// That there is no such rule, with the nearest one.
pub(super) fn run(args: &ExplainArgs) -> Result<ExitStatus, String> {
    let console = Console::new(&Talk::default());
    if let Some(rule) = find(&args.rule) {
        console.print(&rule.page());
        return Ok(ExitStatus::Clean);
    }
    let name = args.rule.strip_prefix("ceid::").unwrap_or(&args.rule);
    let list = |rules: &mut dyn Iterator<Item = &Rule>| -> String {
        let lines: Vec<String> = rules.map(|rule| format!("- `{}`: {}\n", rule.id(), rule.summary)).collect();
        if lines.is_empty() { "It has no rules yet.\n".to_owned() } else { lines.concat() }
    };
    if let Some(group) = GROUPS.iter().find(|group| group.name() == name) {
        let rules = list(&mut RULES.iter().filter(|rule| rule.group == *group));
        let (level, summary) = (group.default_level().name(), group.summary());
        console.print(&format!(
            "# `ceid::{name}`\n\nWhat its rules find is {summary}. Default level: `{level}`.\n\n{rules}"
        ));
        return Ok(ExitStatus::Clean);
    }
    if name == ALL {
        console.print(&format!("# `ceid::all`\n\nAll rules.\n\n{}", list(&mut RULES.iter())));
        return Ok(ExitStatus::Clean);
    }
    Err(unknown_name(name).unwrap_or_else(|| format!("`{name}` is no rule; it names the rules that are at `warn`")))
}
