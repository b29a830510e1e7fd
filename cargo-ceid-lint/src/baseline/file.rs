//! The form of the file: one line a count, sorted, so that changes of it are read and merged line by line.

use std::collections::BTreeMap;
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

/// The counts as a file, in the place of an old one whose comments stay, but for those on what it no longer counts.
#[must_use]
pub fn text(counts: &Counts, old: &str) -> String {
    let quoted = |text: &str| toml::Value::String(text.to_owned()).to_string();
    let Comments { head, above, behind, end } = comments(old).unwrap_or_default();
    let mut text = format!("{}version = {VERSION}\nknown = [\n", head.as_deref().unwrap_or(HEAD));
    for (key, count) in counts {
        text += above.get(key).map_or("", String::as_str);
        text += &format!("    {{ file = {}", quoted(&key.file));
        for (name, value) in [("function", key.function.as_str()), ("rule", key.rule), ("filter", &key.filter)] {
            if !value.is_empty() {
                text += &format!(", {name} = {}", quoted(value));
            }
        }
        text += &format!(", count = {count} }},{}\n", behind.get(key).map_or("", String::as_str));
    }
    text = text + &end + "]\n";
    if old.contains("\r\n") { text.replace('\n', "\r\n") } else { text }
}

/// What was written beside the entries of a file.
#[derive(Default)]
struct Comments {
    /// What the file begins with.
    head: Option<String>,
    /// The lines above entries.
    above: BTreeMap<Key, String>,
    /// What follows entries in their lines.
    behind: BTreeMap<Key, String>,
    /// The lines below all entries.
    end: String,
}

/// `None` if the file cannot be read.
fn comments(text: &str) -> Option<Comments> {
    let text = &text.replace("\r\n", "\n");
    let entries = read_entries(File { path: Path::new(""), text }).ok()?;
    let is_comment = |line: &&str| line.trim_start().starts_with('#');
    let head: String =
        text.split_inclusive('\n').take_while(|line| is_comment(line) || line.trim().is_empty()).collect();
    let mut at = head.len();
    let mut comments = Comments { head: Some(head).filter(|head| !head.is_empty()), ..Comments::default() };
    for (key, place, _) in entries {
        let above = text.get(at..place.range.start)?.split_inclusive('\n').skip(1).filter(is_comment).collect();
        let rest = &text[place.range.end..];
        let line = rest.split('\n').next().unwrap_or(rest);
        if let Some(comment) = line.find('#').map(|start| &line[start..]).filter(|_| !line.contains('{')) {
            comments.behind.insert(key.clone(), format!(" {}", comment.trim_end()));
        }
        comments.above.insert(key, above);
        at = place.range.end;
    }
    comments.end = text.get(at..)?.split_inclusive('\n').skip(1).filter(is_comment).collect();
    Some(comments)
}

/// The counts of a file.
///
/// # Errors
/// The first thing that is wrong in it, with its place.
pub fn read(path: &Path, text: &str) -> Result<Counts, ConfigError> {
    let file = File { path, text };
    counts_of(file).map_err(|error| ConfigError { text: Some(Arc::from(text)), ..error })
}

fn counts_of(file: File<'_>) -> Result<Counts, ConfigError> {
    let mut counts = Counts::new();
    for (key, place, count) in read_entries(file)? {
        if counts.insert(key, count).is_some() {
            let error = ConfigError::at(place, "this is counted a second time");
            return Err(error.help("keep the larger of the two counts"));
        }
    }
    Ok(counts)
}

/// What is counted, in the order of the file.
fn read_entries(file: File<'_>) -> Result<Vec<(Key, Place, u32)>, ConfigError> {
    let table = DeTable::parse(file.text).map_err(|error| file.syntax_error(&error))?;
    let table = Table { file, table: table.get_ref(), range: 0..0 };
    table.only(&["version", "known"])?;
    let version = table.required("version", &VERSION.to_string())?;
    if version.integer()? != VERSION {
        return Err(version
            .error(format!("this baseline is of version {}, and only version {VERSION} is known", version.integer()?))
            .help("use the `cargo ceid-lint` that wrote it, or a newer one"));
    }
    let entries = table.required("known", "[]")?.list()?;
    entries.into_iter().map(|entry| read_entry(&entry.table("a table")?)).collect()
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
        insta::assert_snapshot!(text(&counts(), ""));
        assert_eq!(read(Path::new("b.toml"), &text(&counts(), "")), Ok(counts()));
        assert_eq!(read(Path::new("b.toml"), &text(&Counts::new(), "")), Ok(Counts::new()));
    }

    #[test]
    fn comments_stay_with_what_they_are_about() {
        let own = text(&counts(), "").replace(HEAD, "# Ours.\n").replace("    { file", "    # A note.\n    { file");
        let own = own.replace("count = 2 },", "count = 2 }, # ROBOT-17").replace("]\n", "    # The end.\n]\n");
        assert_eq!(text(&counts(), &own), own);
        let on_windows = own.replace('\n', "\r\n");
        assert_eq!(text(&counts(), &on_windows), on_windows);
        // An entry goes with its comments.
        let left: Counts = counts().into_iter().filter(|(_, count)| *count == 1).collect();
        let lines: Vec<&str> = own.lines().collect();
        let gone = lines.iter().position(|line| line.ends_with("ROBOT-17")).expect("it was added");
        let expected = [&lines[..gone - 1], &lines[gone + 1..]].concat().join("\n") + "\n";
        assert_eq!(text(&left, &own), expected);
        // What is no baseline has no comments.
        assert_eq!(text(&counts(), "# Mine.\nversion = "), text(&counts(), ""));
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
