//! The JSON schema of the configuration file allows what the parser accepts, and refuses what it refuses.

use std::path::Path;
use std::sync::atomic::{AtomicU32, Ordering};

use cargo_ceid_lint::config::{self, CycleEntry, FilterEntry, GuardEntry, PRESETS};
use cargo_ceid_lint::rules;
use cargo_ceid_lint::source::DiskSource;
use serde_json::Value;

use crate::support::{root, workspace};

fn schema() -> Value {
    let path = root().join("cargo-ceid-lint/ceid-lint.schema.json");
    let text = std::fs::read_to_string(path).expect("the schema is shipped");
    serde_json::from_str(&text).expect("it is JSON")
}

/// Whether a value is valid, as far as the keywords go that the schema uses. Patterns are left to editors.
fn is_valid(root: &Value, schema: &Value, value: &Value) -> bool {
    let is = |key: &str, holds: &dyn Fn(&Value) -> bool| schema.get(key).is_none_or(holds);
    let count = |of: &Value| of.as_u64().unwrap_or(u64::MAX);
    let keys = value.as_object().map_or(0, serde_json::Map::len) as u64;
    is("$ref", &|path| {
        let name = path.as_str().and_then(|path| path.strip_prefix("#/definitions/")).expect("a definition");
        is_valid(root, &root["definitions"][name], value)
    }) && is("type", &|name| match name.as_str() {
        Some("object") => value.is_object(),
        Some("array") => value.is_array(),
        Some("string") => value.is_string(),
        Some("integer") => value.is_i64(),
        _ => false,
    }) && is("enum", &|words| words.as_array().is_some_and(|words| words.contains(value)))
        && is("minimum", &|least| value.as_i64() >= least.as_i64())
        && is("minItems", &|least| value.as_array().is_none_or(|items| items.len() as u64 >= count(least)))
        && is("minProperties", &|least| keys >= count(least))
        && is("maxProperties", &|most| keys <= count(most))
        && is("required", &|names| {
            names.as_array().into_iter().flatten().all(|name| value.get(name.as_str().unwrap_or_default()).is_some())
        })
        && is("not", &|other| !is_valid(root, other, value))
        && is("oneOf", &|list| {
            list.as_array().into_iter().flatten().filter(|other| is_valid(root, other, value)).count() == 1
        })
        && is("items", &|each| value.as_array().into_iter().flatten().all(|item| is_valid(root, each, item)))
        && is("propertyNames", &|names| {
            value.as_object().into_iter().flatten().all(|(key, _)| is_valid(root, names, &Value::from(key.as_str())))
        })
        && value.as_object().into_iter().flatten().all(|(key, own)| {
            match schema.get("properties").and_then(|properties| properties.get(key)) {
                Some(property) => is_valid(root, property, own),
                None => match schema.get("additionalProperties") {
                    Some(Value::Bool(false)) => false,
                    Some(other) => is_valid(root, other, own),
                    None => true,
                },
            }
        })
}

fn is_read(text: &str) -> Result<(), String> {
    // Tests run at the same time, each in directories of its own.
    static NEXT: AtomicU32 = AtomicU32::new(0);
    let directory = workspace::temporary(&format!("schema_{}", NEXT.fetch_add(1, Ordering::Relaxed)));
    workspace::write(&directory, "ceid-lint.toml", text.as_bytes());
    let config =
        config::load([directory.as_path()], [] as [&Path; 0], &DiskSource).map_err(|error| error.to_string())?;
    rules::validate(&config).map_err(|error| error.to_string())
}

fn as_json(text: &str) -> Value {
    let table: toml::Table = toml::from_str(text).expect("it is TOML");
    serde_json::to_value(table).expect("TOML fits into JSON")
}

/// Whether the schema allows a file.
pub(crate) fn is_valid_file(text: &str) -> bool {
    let schema = schema();
    is_valid(&schema, &schema, &as_json(text))
}

/// Asserts that parser and schema agree.
#[track_caller]
fn check(text: &str, is_right: bool) {
    let schema = schema();
    let read = is_read(text);
    assert_eq!(read.is_ok(), is_right, "the parser says {read:?} of\n{text}");
    assert_eq!(is_valid(&schema, &schema, &as_json(text)), is_right, "the schema does not agree about\n{text}");
}

#[test]
fn keys_are_those_of_the_parser() {
    let schema = schema();
    let keys = |of: &Value| {
        let mut keys: Vec<String> = of["properties"].as_object().expect("an object").keys().cloned().collect();
        keys.sort();
        keys
    };
    let sorted = |keys: &[&str]| {
        let mut keys: Vec<String> = keys.iter().map(|key| (*key).to_owned()).collect();
        keys.sort();
        keys
    };
    assert_eq!(keys(&schema), sorted(config::KEYS));
    assert_eq!(keys(&schema["definitions"]["filter"]), sorted(FilterEntry::KEYS));
    assert_eq!(keys(&schema["definitions"]["cycle"]), sorted(CycleEntry::KEYS));
    assert_eq!(keys(&schema["definitions"]["guard"]), sorted(GuardEntry::KEYS));
}

#[test]
fn rules_are_those_of_the_program() {
    let schema = schema();
    let names = schema["properties"]["lints"]["propertyNames"]["enum"].as_array().expect("a list");
    let names: Vec<&str> = names.iter().filter_map(Value::as_str).collect();
    for name in &names {
        assert_eq!(rules::unknown_name(name), None);
    }
    let all = rules::RULES.iter().map(|rule| rule.name).chain(rules::GROUPS.iter().map(|group| group.name()));
    for name in all {
        assert!(names.contains(&name) && names.contains(&format!("ceid::{name}").as_str()), "`{name}` is missing");
    }
}

#[test]
fn every_property_is_described() {
    fn walk(value: &Value, path: &str) {
        for (name, property) in value.get("properties").and_then(Value::as_object).into_iter().flatten() {
            let is_table = property.get("items").is_some_and(|items| items.get("$ref").is_some());
            let is_level = path.ends_with("lints");
            assert!(is_level || is_table || property.get("description").is_some(), "{path}/{name} says nothing");
        }
    }
    let schema = schema();
    walk(&schema, "");
    for name in ["filter", "cycle", "guard"] {
        walk(&schema["definitions"][name], name);
    }
}

#[test]
fn what_the_parser_accepts_is_allowed() {
    for text in [
        "",
        "presets = \"none\"\nexclude = \"vendor/**\"\n",
        "presets = [\"ahrs\", \"pid\"]\nexclude = [\"vendor/**\"]\n",
        "[lints]\n\"ceid::warnings\" = \"deny\"\n",
        "[lints]\nskipped_update = \"deny\"\ntime_domain = { level = \"warn\", priority = -1 }\n\"ceid::all\" = \"allow\"\n",
        "[[filter]]\ntype = \"crate::Pid\"\nlaw = \"calc\"\n",
        "[[filter]]\ntype = [\"a::Low\", \"a::High\"]\nlaw = [[\"run\", \"run_block\"], [\"tune\"]]\n\
         multiplicity = [\"once\", \"at-most-once\"]\ninstance = \"arg(1)\"\nkey = [0, 1]\nreceiver = \"shared\"\nreset = \"clear\"\n\
         partial_reset = [\"clear_sum\"]\non_err = \"untouched\"\ntime_base = \"inside\"\nkind = \"event\"\nmade_by = \"a::low\"\n",
        "[[filter]]\ntrait = \"crate::Estimator\"\nlaw = [[\"step\"]]\nmultiplicity = \"any\"\nkey = 0\ninstance = \"returned\"\n",
        "[[filter]]\nfunction = \"crate::dsp::fir\"\n",
        "[[cycle]]\nfunction = \"crate::tasks::step\"\n[[cycle]]\nmethod = \"cu29::CuTask::process\"\n[[cycle]]\nattribute = \"rtic::task\"\n",
        "[[guard]]\ntype = \"crate::CycleGuard\"\n[[guard]]\ntype = \"crate::Other\"\nregister = \"over\"\n",
    ] {
        check(text, true);
    }
}

#[test]
fn what_the_parser_refuses_is_not_allowed() {
    for text in [
        "preset = \"auto\"\n",
        "presets = \"some\"\n",
        "exclude = 3\n",
        "[lints]\nskipped = \"deny\"\n",
        "[lints]\nskipped_update = \"fatal\"\n",
        "[lints]\nskipped_update = { priority = 1 }\n",
        "[filter]\ntype = \"A\"\nlaw = \"a\"\n",
        "[[filter]]\ntype = \"A\"\n",
        "[[filter]]\nlaw = \"a\"\n",
        "[[filter]]\ntype = \"A\"\ntrait = \"B\"\nlaw = \"a\"\n",
        "[[filter]]\ntype = []\nlaw = \"a\"\n",
        "[[filter]]\ntype = \"A\"\nlaw = []\n",
        "[[filter]]\ntype = \"A\"\nlaw = [[]]\n",
        "[[filter]]\ntype = \"A\"\nlaw = [\"a\", \"b\"]\n",
        "[[filter]]\nfunction = \"a::b\"\nlaw = \"b\"\n",
        "[[filter]]\ntype = \"A\"\nlaw = \"a\"\nmultiplicity = \"twice\"\n",
        "[[filter]]\ntype = \"A\"\nlaw = \"a\"\nkey = -1\n",
        "[[filter]]\ntype = \"A\"\nlaw = \"a\"\nreceiver = \"mut\"\n",
        "[[filter]]\ntype = \"A\"\nlaw = \"a\"\nreset = 1\n",
        "[[filter]]\ntype = \"A\"\nlaw = \"a\"\non_err = \"lost\"\n",
        "[[filter]]\ntype = \"A\"\nlaw = \"a\"\ntime_base = \"wall\"\n",
        "[[filter]]\ntype = \"A\"\nlaw = \"a\"\nkind = \"pull\"\n",
        "[[filter]]\ntype = \"A\"\nlaw = \"a\"\ntimebase = \"fixed\"\n",
        "[[filter]]\ntype = \"A\"\nlaw = \"a\"\nfunction = \"a::b\"\n",
        "[[filter]]\ntype = \"A\"\nlaw = \"a\"\nmultiplicity = []\n",
        "[[cycle]]\n",
        "[[cycle]]\nfunction = \"a\"\nmethod = \"b::c\"\n",
        "[[cycle]]\nname = \"a\"\n",
        "[[guard]]\nregister = \"new\"\n",
        "[[guard]]\ntype = \"A\"\nregister = 1\n",
    ] {
        check(text, false);
    }
}

#[test]
fn every_preset_is_allowed() {
    let schema = schema();
    for (name, text) in PRESETS {
        let mut value = as_json(text);
        value.as_object_mut().expect("a table").remove("versions");
        assert!(is_valid(&schema, &schema, &value), "{name}");
    }
}
