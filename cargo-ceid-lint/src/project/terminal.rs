//! The table `term` of cargo's configuration: how cargo's users want programs to talk to them.

use std::env;
use std::path::Path;

use super::cargo_config::{tables, tables_of_options};

/// What the user wants of the terminal; nothing where nothing is said.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Terminal {
    /// `always`, `never` or `auto`.
    pub color: Option<String>,
    /// Whether only what matters is said.
    pub quiet: Option<bool>,
    /// Whether all is said.
    pub verbose: Option<bool>,
    /// Whether links are written.
    pub hyperlinks: Option<bool>,
    /// When a progress bar is shown.
    pub progress: ProgressWhen,
    /// How wide the progress bar is.
    pub progress_width: Option<usize>,
}

/// When a progress bar is shown.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ProgressWhen {
    /// On a terminal where it does no harm.
    #[default]
    Auto,
    /// Even where there is no terminal.
    Always,
    /// Never.
    Never,
}

/// Reads `--config KEY=VALUE`, the environment, and the files that cargo reads in `directory`, in this order. What is wrong in
/// them is passed over, as cargo does.
#[must_use]
pub fn terminal(directory: &Path, options: &[String]) -> Terminal {
    read(&tables_of_options(options), |name| env::var(name).ok(), &tables(directory, &[]))
}

fn read(options: &[toml::Table], variable: impl Fn(&str) -> Option<String>, files: &[toml::Table]) -> Terminal {
    let text = |path: &[&str]| -> Option<String> {
        let name = format!("CARGO_TERM_{}", path.join("_").to_uppercase());
        let of_tables = |tables: &[toml::Table]| tables.iter().find_map(|table| value(table, path));
        of_tables(options).or_else(|| variable(&name).filter(|text| !text.is_empty())).or_else(|| of_tables(files))
    };
    let progress_width = text(&["progress", "width"]).and_then(|text| text.parse().ok());
    let progress = match text(&["progress", "when"]).as_deref() {
        Some("never") => ProgressWhen::Never,
        // cargo wants a width beside it.
        Some("always") if progress_width.is_some() => ProgressWhen::Always,
        _ => ProgressWhen::Auto,
    };
    let flag = |name: &str| match text(&[name]).as_deref() {
        Some("true" | "1") => Some(true),
        Some("false" | "0") => Some(false),
        _ => None,
    };
    Terminal {
        color: text(&["color"]),
        quiet: flag("quiet"),
        verbose: flag("verbose"),
        hyperlinks: flag("hyperlinks"),
        progress,
        progress_width,
    }
}

/// A value of the table `term`, as it would stand in the environment.
fn value(table: &toml::Table, path: &[&str]) -> Option<String> {
    let (last, tables) = path.split_last()?;
    let mut table = table.get("term")?.as_table()?;
    for name in tables {
        table = table.get(*name)?.as_table()?;
    }
    match table.get(*last)? {
        toml::Value::String(text) => Some(text.clone()),
        toml::Value::Boolean(value) => Some(value.to_string()),
        toml::Value::Integer(number) => Some(number.to_string()),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(options: &[&str], environment: &[(&str, &str)], files: &[&str]) -> Terminal {
        let parsed = |texts: &[&str]| -> Vec<toml::Table> { texts.iter().map(|text| text.parse().unwrap()).collect() };
        let variable =
            |name: &str| environment.iter().find(|(key, _)| *key == name).map(|(_, value)| (*value).to_owned());
        read(&parsed(options), variable, &parsed(files))
    }

    #[test]
    fn arguments_come_before_the_environment_and_files_last() {
        let file = "term.color = \"never\"\nterm.hyperlinks = true\nterm.progress = { when = \"never\", width = 40 }";
        let far = "term.hyperlinks = false\nterm.quiet = true";
        let read = of(&[], &[], &[file, far]);
        assert_eq!((read.color.as_deref(), read.hyperlinks, read.quiet), (Some("never"), Some(true), Some(true)));
        assert_eq!((read.progress, read.progress_width), (ProgressWhen::Never, Some(40)));

        let environment = [("CARGO_TERM_COLOR", "always"), ("CARGO_TERM_PROGRESS_WHEN", "always")];
        let read = of(&["term.progress.width = 70"], &environment, &[file]);
        assert_eq!(
            (read.color.as_deref(), read.progress, read.progress_width),
            (Some("always"), ProgressWhen::Always, Some(70))
        );
        let read = of(&["term.color = \"auto\""], &environment, &[]);
        assert_eq!((read.color.as_deref(), read.progress), (Some("auto"), ProgressWhen::Auto));
    }

    #[test]
    fn what_is_wrong_is_passed_over() {
        let read =
            of(&[], &[("CARGO_TERM_HYPERLINKS", "perhaps"), ("CARGO_TERM_PROGRESS_WIDTH", "wide")], &["term = 1"]);
        assert_eq!(read, Terminal::default());
    }
}
