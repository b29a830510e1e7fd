//! The form of the file: one line a count, sorted, so that changes of it are read and merged line by line.

use std::path::Path;
use std::sync::Arc;

use toml::de::DeTable;

use super::{Counts, Key};
use crate::config::reader::{File, Table, Value};
use crate::config::{ConfigError, Place};
use crate::rules::{self, RULES};

/// The file beside the workspace manifest.
pub const FILE_NAME: &str = "ceid-baseline.toml";

const VERSION: i64 = 1;

const HEAD: &str = "\
# Findings of `cargo ceid-lint` that were there before: their number by file, function, rule and filter.
# They are told in one line, and fail nothing; whatever is not in this list does.
# `cargo ceid-lint baseline --prune` takes out what is fixed, `--accept-new` adds what is new.
";

/// The counts as a file.
#[must_use]
pub fn text(counts: &Counts) -> String {
    let quoted = |text: &str| toml::Value::String(text.to_owned()).to_string();
    let mut text = format!("{HEAD}version = {VERSION}\nknown = [\n");
    for (key, count) in counts {
        text += &format!("    {{ file = {}", quoted(&key.file));
        for (name, value) in [("function", key.function.as_str()), ("rule", key.rule), ("filter", &key.filter)] {
            if !value.is_empty() {
                text += &format!(", {name} = {}", quoted(value));
            }
        }
        text += &format!(", count = {count} }},\n");
    }
    text + "]\n"
}

/// The counts of a file.
///
/// # Errors
/// The first thing that is wrong in it, with its place.
pub fn read(path: &Path, text: &str) -> Result<Counts, ConfigError> {
    let file = File { path, text };
    read_table(file).map_err(|error| ConfigError { text: Some(Arc::from(text)), ..error })
}

fn read_table(file: File<'_>) -> Result<Counts, ConfigError> {
    let table = DeTable::parse(file.text).map_err(|error| file.syntax_error(&error))?;
    let table = Table { file, table: table.get_ref(), range: 0..0 };
    table.only(&["version", "known"])?;
    let version = table.required("version", &VERSION.to_string())?;
    if version.integer()? != VERSION {
        return Err(version
            .error(format!("this baseline is of version {}, and only version {VERSION} is known", version.integer()?))
            .help("use the `cargo ceid-lint` that wrote it, or a newer one"));
    }
    let mut counts = Counts::new();
    for entry in table.required("known", "[]")?.list()? {
        let (key, place, count) = read_entry(&entry.table("a table")?)?;
        if counts.insert(key, count).is_some() {
            return Err(
                ConfigError::at(place, "this is counted a second time").help("keep the larger of the two counts")
            );
        }
    }
    Ok(counts)
}

fn read_entry(entry: &Table<'_>) -> Result<(Key, Place, u32), ConfigError> {
    entry.only(&["file", "function", "rule", "filter", "count"])?;
    let optional = |name: &str| entry.get(name).map_or(Ok(""), Value::string).map(str::to_owned);
    let rule = entry.required("rule", "\"missed_update\"")?;
    let name = rule.string()?;
    let Some(known) = rules::find(name) else {
        let names: Vec<&str> = RULES.iter().map(|rule| rule.name).collect();
        return Err(rule.error(format!("unknown rule `{name}`")).did_you_mean(name, &names));
    };
    let count = entry.required("count", "1")?;
    let number = u32::try_from(count.integer()?).ok().filter(|number| *number > 0);
    let number = number.ok_or_else(|| count.error("expected how many findings are known, which is 1 or more"))?;
    let key = Key {
        file: entry.required("file", "\"src/main.rs\"")?.string()?.replace('\\', "/"),
        function: optional("function")?,
        rule: known.name,
        filter: optional("filter")?,
    };
    Ok((key, entry.place(), number))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn counts() -> Counts {
        let key = |file: &str, function: &str, filter: &str| Key {
            file: file.to_owned(),
            function: function.to_owned(),
            rule: "missed_update",
            filter: filter.to_owned(),
        };
        [
            (key("src/ü \"b\".rs", "<Robot as Control>::run", "self.pf"), 2),
            (key("src/a.rs", "", ""), 1),
            (key("src/a.rs", "run", "pids['x']"), 1),
        ]
        .into()
    }

    #[test]
    fn what_is_written_is_read() {
        insta::assert_snapshot!(text(&counts()));
        assert_eq!(read(Path::new("b.toml"), &text(&counts())), Ok(counts()));
        assert_eq!(read(Path::new("b.toml"), &text(&Counts::new())), Ok(Counts::new()));
    }

    #[track_caller]
    fn check(text: &str, message: &str, help: &str) {
        let error = read(Path::new("b.toml"), text).unwrap_err();
        assert!(error.to_string().contains(message), "{error}");
        assert!(error.help.as_deref().unwrap_or_default().contains(help), "{:?}", error.help);
    }

    #[test]
    fn what_is_wrong_is_told_with_its_place() {
        let entry = |text: &str| format!("version = 1\nknown = [\n    {{ {text} }},\n]\n");
        check("", "`version` is missing", "add `version = 1`");
        check("version = 2\nknown = []", "`b.toml:1:11`: this baseline is of version 2", "a newer one");
        check("version = 1\nknwon = []", "`b.toml:2:1`: unknown key `knwon`", "`known`");
        check("version = 1\n<<<<<<< ours\n", "`b.toml:2:", "");
        check(&entry("file = 'a', rule = 'mised_update', count = 1"), "`b.toml:3:26`: unknown rule", "`missed_update`");
        check(&entry("file = 'a', rule = 'missed_update', cont = 1"), "unknown key `cont`", "`count`");
        check(&entry("file = 'a', rule = 'missed_update', count = 0"), "1 or more", "");
        check(&entry("file = 'a', rule = 'missed_update', count = 1, filter = 3"), "expected a string", "");
        check(&entry("rule = 'missed_update', count = 1"), "`file` is missing", "add `file");
        let twice = "file = 'a', rule = 'missed_update', count = 1 }, { file = 'a', rule = 'missed_update', count = 2";
        check(&entry(twice), "a second time", "the larger");
    }
}
