//! The dependency on `ceid-core`: what to write into a manifest, and where, so that the rest of it stays as it is.

use toml::{Table, Value};

use super::text::Style;

const NAME: &str = "ceid-core";

/// The oldest Rust that `ceid-core` builds with, as its manifest says.
const RUST_VERSION: (u32, u32) = (1, 85);

/// What a package needs of `ceid-core`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Wanted {
    /// The directory of its sources, as the manifest names it; without it, the version of this program is asked for.
    pub path: Option<String>,
    /// Whether the package can do without the standard library.
    pub is_no_std: bool,
    /// Whether filters lie in a `Vec`.
    pub needs_alloc: bool,
}

/// Where in the text of a manifest something has to be inserted so that the package depends on `ceid-core`, and what; nothing if it
/// does already. `workspace` is the text of the manifest of its workspace.
///
/// # Errors
/// Why that cannot be done.
pub fn dependency(text: &str, workspace: Option<&str>, wanted: &Wanted) -> Result<Option<(usize, String)>, String> {
    let table: Table = text.parse().map_err(|_| "the manifest cannot be parsed".to_owned())?;
    let workspace: Option<Table> = workspace.and_then(|text| text.parse().ok());
    is_built_with(&table, workspace.as_ref().unwrap_or(&table))?;
    let shared = workspace.as_ref().unwrap_or(&table).get("workspace").and_then(|root| root.get("dependencies"));
    if let Some((_, found)) = section(&table, "dependencies").and_then(|section| find(section, shared)) {
        return suits(found, shared, wanted).map(|()| None);
    }
    let of_targets = table.get("target").and_then(Value::as_table).into_iter().flat_map(Table::values);
    if of_targets
        .filter_map(Value::as_table)
        .filter_map(|of| section(of, "dependencies"))
        .any(|of| find(of, shared).is_some())
    {
        return Err("`ceid-core` is a dependency for some targets only: make it one of the whole package".to_owned());
    }
    let line = match tests_entry(&table, shared) {
        Some((NAME, value)) => format!("{NAME} = {}", as_tests_have_it(value, wanted)),
        Some((name, _)) => {
            return Err(format!("`{NAME}` is a dependency of the tests only, as `{name}`: make it one of the package"));
        }
        None => line(text, shared.and_then(Value::as_table), wanted)?,
    };
    let is_there = |(at, inserted): &(usize, String)| {
        let mut changed = text.to_owned();
        changed.insert_str(*at, inserted);
        let parsed: Option<Table> = changed.parse().ok();
        parsed.as_ref().and_then(|table| find(section(table, "dependencies")?, shared)).is_some()
    };
    // A text in several lines may have one that looks like the header.
    let mut places = insertions(text, &table, &line).into_iter();
    places.find(is_there).map(Some).ok_or_else(|| is_unusual(&line))
}

/// Whether the Rust that the package promises to build with is enough.
fn is_built_with(table: &Table, workspace: &Table) -> Result<(), String> {
    let own = table.get("package").and_then(|package| package.get("rust-version"));
    let of_workspace = || workspace.get("workspace")?.get("package")?.get("rust-version");
    let Some(said) = own.and_then(|own| own.as_str().or_else(|| of_workspace()?.as_str())) else { return Ok(()) };
    let mut numbers = said.split('.').map_while(|number| number.parse().ok());
    match (numbers.next(), numbers.next().unwrap_or(0)) {
        (Some(major), minor) if (major, minor) < RUST_VERSION => Err(format!(
            "the package builds with Rust {said} (`rust-version`), and `{NAME}` needs {}.{}: raise it, and migrate again",
            RUST_VERSION.0, RUST_VERSION.1
        )),
        _ => Ok(()),
    }
}

/// Where no line can be added: what a person has to.
fn is_unusual(line: &str) -> String {
    format!(
        "the dependencies are not written in lines of a section `[dependencies]`: add `{line}` to them, and migrate again"
    )
}

/// Whether the text is the manifest of `ceid-core` itself.
#[must_use]
pub fn is_ceid_core(text: &str) -> bool {
    let table: Option<Table> = text.parse().ok();
    let name = |table: &Table| Some(table.get("package")?.get("name")?.as_str()? == NAME);
    table.as_ref().and_then(name) == Some(true)
}

fn section<'t>(table: &'t Table, name: &str) -> Option<&'t Table> {
    table.get(name).and_then(Value::as_table)
}

/// The entry for `ceid-core`, under whatever name, and that name.
fn find<'t>(section: &'t Table, shared: Option<&Value>) -> Option<(&'t str, &'t Value)> {
    let is_it = |(key, value): &(&String, &Value)| {
        let value = in_workspace(key, value, shared).unwrap_or(value);
        value.get("package").and_then(Value::as_str).unwrap_or(key) == NAME
    };
    section.iter().find(is_it).map(|(key, value)| (key.as_str(), value))
}

/// The entry of the workspace that an entry stands for.
fn in_workspace<'t>(key: &str, value: &Value, shared: Option<&'t Value>) -> Option<&'t Value> {
    let is_shared = value.get("workspace").and_then(Value::as_bool) == Some(true);
    is_shared.then(|| shared?.get(key)).flatten()
}

/// The entry by which only tests, examples and build scripts have `ceid-core`, with its name. Cargo takes no package from two places.
fn tests_entry<'t>(table: &'t Table, shared: Option<&Value>) -> Option<(&'t str, &'t Value)> {
    let sections = ["dev-dependencies", "build-dependencies"].into_iter().filter_map(|name| section(table, name));
    sections.filter_map(|section| find(section, shared)).next()
}

/// The same entry with the features that the package itself needs.
fn as_tests_have_it(value: &Value, wanted: &Wanted) -> Value {
    let of_workspace = value.get("workspace").is_some();
    if !wanted.is_no_std || of_workspace {
        return value.clone();
    }
    let mut entry = match value {
        Value::Table(entry) => entry.clone(),
        version => Table::from_iter([("version".to_owned(), version.clone())]),
    };
    entry.insert("default-features".to_owned(), Value::Boolean(false));
    let features = entry.remove("features").and_then(|features| features.as_array().cloned()).unwrap_or_default();
    let mut features: Vec<Value> = features.into_iter().filter(|feature| feature.as_str() != Some("std")).collect();
    if wanted.needs_alloc && !features.iter().any(|feature| feature.as_str() == Some("alloc")) {
        features.push(Value::String("alloc".to_owned()));
    }
    if !features.is_empty() {
        entry.insert("features".to_owned(), Value::Array(features));
    }
    Value::Table(entry)
}

/// Whether the dependency that is there is enough.
fn suits(found: &Value, shared: Option<&Value>, wanted: &Wanted) -> Result<(), String> {
    if found.get("optional").and_then(Value::as_bool) == Some(true) {
        return Err("`ceid-core` is an optional dependency: delete its `optional = true`".to_owned());
    }
    let of_workspace = in_workspace(NAME, found, shared);
    let without_defaults = |value: &Value| value.get("default-features").and_then(Value::as_bool) == Some(false);
    let has_alloc = |value: &Value| {
        let features = value.get("features").and_then(Value::as_array).into_iter().flatten();
        features.filter_map(Value::as_str).any(|feature| matches!(feature, "alloc" | "std"))
    };
    let all = [Some(found), of_workspace];
    let entries = || all.iter().flatten();
    if wanted.needs_alloc && entries().any(|value| without_defaults(value)) && !entries().any(|value| has_alloc(value))
    {
        return Err("`ceid-core` is a dependency without its feature `alloc`, which filters in a `Vec` need".to_owned());
    }
    Ok(())
}

/// The entry to write.
fn line(text: &str, shared: Option<&Table>, wanted: &Wanted) -> Result<String, String> {
    if let Some(value) = shared.and_then(|shared| shared.get(NAME)) {
        suits(value, None, wanted)?;
        let is_inline = text.contains("{ workspace = true") || text.contains("{workspace = true");
        return Ok(if is_inline {
            format!("{NAME} = {{ workspace = true }}")
        } else {
            format!("{NAME}.workspace = true")
        });
    }
    let is_renamed = |(_, value): &(&String, &Value)| value.get("package").and_then(Value::as_str) == Some(NAME);
    if let Some((name, _)) = shared.and_then(|shared| shared.iter().find(is_renamed)) {
        return Err(format!(
            "the workspace calls `{NAME}` `{name}`: let the package depend on it, with `{name}.workspace = true`"
        ));
    }
    let version = env!("CARGO_PKG_VERSION");
    let features = match (wanted.is_no_std, wanted.needs_alloc) {
        (false, _) => "",
        (true, false) => ", default-features = false",
        (true, true) => ", default-features = false, features = [\"alloc\"]",
    };
    Ok(match &wanted.path {
        Some(path) => format!("{NAME} = {{ path = {}{features} }}", Value::String(path.clone())),
        None if features.is_empty() => format!("{NAME} = \"{version}\""),
        None => format!("{NAME} = {{ version = \"{version}\"{features} }}"),
    })
}

/// Where the entry may go.
fn insertions(text: &str, table: &Table, line: &str) -> Vec<(usize, String)> {
    let end = Style::of(text).end;
    let lines: Vec<(usize, &str)> = text
        .split_inclusive('\n')
        .scan(0, |at, line| {
            let start = *at;
            *at += line.len();
            Some((start, line))
        })
        .collect();
    let is_header = |line: &str, name: &str| {
        line.trim()
            .strip_prefix('[')
            .and_then(|rest| rest.split_once(']'))
            .is_some_and(|(found, _)| found.trim() == name)
    };
    let headers = (0..lines.len()).filter(|at| is_header(lines[*at].1, "dependencies"));
    let mut found: Vec<_> = headers.map(|header| in_section(text, &lines, header, line)).collect();
    if let Some((at, _)) = lines.iter().find(|(_, line)| line.trim_start().starts_with("[dependencies.")) {
        found.push((*at, format!("[dependencies]{end}{line}{end}{end}")));
    } else if !table.contains_key("dependencies") {
        let gap = if text.is_empty() || text.ends_with('\n') { String::new() } else { end.to_owned() };
        found.push((text.len(), format!("{gap}{end}[dependencies]{end}{line}{end}")));
    }
    found
}

/// Where the entry goes behind the header of its section: among sorted entries to its place, else behind the last one.
fn in_section(text: &str, lines: &[(usize, &str)], header: usize, line: &str) -> (usize, String) {
    let end = Style::of(text).end;
    let section: Vec<(usize, &str)> =
        lines[header + 1..].iter().take_while(|(_, line)| !line.starts_with('[')).copied().collect();
    let key = |line: &str| {
        let is_key = line.starts_with(|first: char| first.is_alphanumeric() || matches!(first, '_' | '"' | '\''));
        let key = line.split(['=', '.']).next().unwrap_or_default().trim().trim_matches(['"', '\'']);
        is_key.then(|| key.to_owned())
    };
    let keys: Vec<(usize, String)> =
        section.iter().enumerate().filter_map(|(at, (_, line))| Some((at, key(line)?))).collect();
    let is_sorted = keys.windows(2).all(|pair| pair[0].1 <= pair[1].1);
    let next = keys.iter().find(|(_, key)| is_sorted && key.as_str() > NAME).map(|(at, _)| *at);
    let mut at = next
        .unwrap_or_else(|| section.iter().rposition(|(_, line)| !line.trim().is_empty()).map_or(0, |last| last + 1));
    while next.is_some() && at > 0 && section[at - 1].1.trim_start().starts_with('#') {
        at -= 1;
    }
    let place = section.get(at).map_or_else(
        || section.last().or(lines.get(header)).map_or(text.len(), |(start, line)| start + line.len()),
        |(start, _)| *start,
    );
    let is_open = !text[..place].is_empty() && !text[..place].ends_with('\n');
    (place, if is_open { format!("{end}{line}{end}") } else { format!("{line}{end}") })
}

#[cfg(test)]
mod tests {
    use super::*;

    const PLAIN: Wanted = Wanted { path: None, is_no_std: false, needs_alloc: false };

    #[track_caller]
    fn check(text: &str, workspace: Option<&str>, wanted: &Wanted, expected: &str) {
        let version = env!("CARGO_PKG_VERSION");
        let expected = expected.replace("VERSION", version);
        let mut changed = text.to_owned();
        if let Some((at, line)) = dependency(text, workspace, wanted).expect("it can be added") {
            changed.insert_str(at, &line);
        }
        assert_eq!(changed, expected);
    }

    #[test]
    fn it_is_added_where_a_person_would_write_it() {
        let core = "ceid-core = \"VERSION\"";
        check(
            "[dependencies]\na = \"1\"\nlog = \"1\"\n",
            None,
            &PLAIN,
            &format!("[dependencies]\na = \"1\"\n{core}\nlog = \"1\"\n"),
        );
        check(
            "[dependencies]\nlog = \"1\" # x\na = \"1\"\n\n[profile.dev]\n",
            None,
            &PLAIN,
            &format!("[dependencies]\nlog = \"1\" # x\na = \"1\"\n{core}\n\n[profile.dev]\n"),
        );
        check(
            "[dependencies]\n# for x\nx = \"1\"",
            None,
            &PLAIN,
            &format!("[dependencies]\n{core}\n# for x\nx = \"1\""),
        );
        check("[dependencies]\na = \"1\"", None, &PLAIN, &format!("[dependencies]\na = \"1\"\n{core}\n"));
        check(
            "[dependencies]\r\n\r\n[features]\r\n",
            None,
            &PLAIN,
            &format!("[dependencies]\r\n{core}\r\n\r\n[features]\r\n"),
        );
        check(
            "[package]\nname = \"a\"\n",
            None,
            &PLAIN,
            &format!("[package]\nname = \"a\"\n\n[dependencies]\n{core}\n"),
        );
        check(
            "[dependencies.a]\nversion = \"1\"\n",
            None,
            &PLAIN,
            &format!("[dependencies]\n{core}\n\n[dependencies.a]\nversion = \"1\"\n"),
        );
    }

    #[test]
    fn a_text_that_looks_like_a_section_is_none() {
        let text = "[package]\ndescription = \"\"\"\n[dependencies]\n\"\"\"\n";
        let core = "ceid-core = \"VERSION\"";
        check(text, None, &PLAIN, &format!("{text}\n[dependencies]\n{core}\n"));
        let text = format!("{text}[dependencies] # none\n");
        check(&text, None, &PLAIN, &format!("{text}{core}\n"));
    }

    #[test]
    fn what_is_there_is_left() {
        for text in [
            "[dependencies]\nceid-core = \"0.1\"\n",
            "[dependencies]\nguard = { package = \"ceid-core\", version = \"0.1\" }\n",
            "[dependencies.ceid-core]\npath = \"../core\"\n",
        ] {
            check(text, None, &PLAIN, text);
        }
    }

    #[test]
    fn a_workspace_says_which_one() {
        let root = "[workspace.dependencies]\nceid-core = { path = \"core\" }\n";
        check("[dependencies]\n", Some(root), &PLAIN, "[dependencies]\nceid-core.workspace = true\n");
        check(
            "[dependencies]\nlog = { workspace = true }\n",
            Some(root),
            &PLAIN,
            "[dependencies]\nceid-core = { workspace = true }\nlog = { workspace = true }\n",
        );
    }

    #[test]
    fn what_the_tests_have_comes_from_the_same_place() {
        let dev = "[dev-dependencies]\nceid-core = { path = \"../core\" }\n";
        check(dev, None, &PLAIN, &format!("{dev}\n[dependencies]\nceid-core = {{ path = \"../core\" }}\n"));
        let bare = Wanted { is_no_std: true, ..PLAIN };
        let line = "ceid-core = { default-features = false, version = \"0.1.2\" }";
        let dev = "[build-dependencies]\nceid-core = \"0.1.2\"\n";
        check(dev, None, &bare, &format!("{dev}\n[dependencies]\n{line}\n"));
    }

    #[test]
    fn its_source_and_features_are_those_that_are_wanted() {
        let wanted = Wanted { path: Some("../core".to_owned()), is_no_std: true, needs_alloc: true };
        let line = "ceid-core = { path = \"../core\", default-features = false, features = [\"alloc\"] }\n";
        check("[dependencies]\n", None, &wanted, &format!("[dependencies]\n{line}"));
    }

    #[test]
    fn rust_that_is_promised_has_to_be_enough() {
        let core = include_str!("../../../ceid-core/Cargo.toml").parse::<Table>().expect("it is TOML");
        let needs = core["package"]["rust-version"].as_str().expect("it is said");
        assert_eq!(needs, format!("{}.{}", RUST_VERSION.0, RUST_VERSION.1));
        let of = |text: &str, workspace: Option<&str>| dependency(text, workspace, &PLAIN).is_ok();
        for (said, is_enough) in [("1.70", false), ("1.84.1", false), ("1", false), ("1.85", true), ("1.90.0", true)] {
            let package = format!("[package]\nname = \"a\"\nrust-version = \"{said}\"\n");
            assert_eq!(of(&package, None), is_enough, "{said}");
            let inherits = "[package]\nname = \"a\"\nrust-version.workspace = true\n";
            let workspace = format!("[workspace.package]\nrust-version = \"{said}\"\n");
            assert_eq!(of(inherits, Some(&workspace)), is_enough, "{said}");
        }
    }

    #[test]
    fn what_would_not_be_enough_is_refused() {
        let alloc = Wanted { needs_alloc: true, ..PLAIN };
        for (text, wanted) in [
            ("[dependencies]\nceid-core = { version = \"0.1\", optional = true }\n", &PLAIN),
            ("[dependencies]\nceid-core = { version = \"0.1\", default-features = false }\n", &alloc),
            ("[target.'cfg(unix)'.dependencies]\nceid-core = \"0.1\"\n", &PLAIN),
            ("dependencies = {}\n", &PLAIN),
            ("[dev-dependencies]\nguard = { package = \"ceid-core\", version = \"0.1\" }\n", &PLAIN),
            ("[workspace.dependencies]\nguard = { package = \"ceid-core\", version = \"0.1\" }\n", &PLAIN),
        ] {
            assert!(dependency(text, None, wanted).is_err(), "{text}");
        }
    }
}
