//! The documented file is read, and every mistake in one has its place.

use super::*;
use crate::config::{CycleTarget, FilterTarget, InstancePlace, Multiplicity, TimeBase, Word};

fn read(text: &str) -> Result<Section, ConfigError> {
    read_file(Path::new("/ws/ceid-lint.toml"), text, Scope::Workspace("/ws".into()))
}

fn texts(law: &[Vec<Word>]) -> Vec<Vec<&str>> {
    law.iter().map(|group| group.iter().map(|word| word.text.as_str()).collect()).collect()
}

#[track_caller]
fn check_error(text: &str, message: &str, help: &str) {
    let error = read(text).unwrap_err();
    assert_eq!(error.to_string(), message);
    assert_eq!(error.help.unwrap_or_default(), help);
}

#[test]
fn the_documented_file_is_read() {
    let section = read(
        r#"
presets = ["ahrs", "pid"]
exclude = ["vendor/**"]

[lints]
skipped_update = "deny"
"ceid::time_domain" = { level = "warn", priority = -1 }

[[filter]]
type = "crate::control::Pid"
law = [["calc", "calc_with_dt"], ["correct"]]
multiplicity = ["once", "at-most-once"]
instance = "arg(1)"
key = [0, 1]
receiver = "shared"
reset = ["reset"]
partial_reset = "reset_integral"
on_err = "untouched"
time_base = "inside"
kind = "event"

[[cycle]]
method = "cu29::CuTask::process"

[[guard]]
type = "crate::CycleGuard"
register = "with"
"#,
    )
    .unwrap();
    assert_eq!(section.lints[0].level, Level::Deny);
    assert_eq!((section.lints[1].name.as_str(), section.lints[1].priority), ("time_domain", -1));
    let filter = &section.filters[0];
    assert_eq!(texts(&filter.law), [vec!["calc", "calc_with_dt"], vec!["correct"]]);
    assert_eq!(filter.multiplicity, [Multiplicity::Once, Multiplicity::AtMostOnce]);
    assert_eq!((filter.instance, filter.key.as_slice()), (InstancePlace::Argument(1), [0, 1].as_slice()));
    assert_eq!((filter.time_base, filter.target.path().place.line), (TimeBase::Inside, 10));
    let CycleTarget::Method(method) = &section.cycles[0].target else { panic!("it names a method") };
    assert_eq!(method.text, "cu29::CuTask::process");
    assert_eq!(section.guards[0].register.text, "with");
}

#[test]
fn a_short_law_is_one_group_of_one() {
    let section = read("[[filter]]\ntrait = \"crate::Estimator\"\nlaw = \"step\"\n").unwrap();
    assert_eq!(texts(&section.filters[0].law), [["step"]]);
    assert_eq!(section.filters[0].multiplicity, [Multiplicity::Once]);
}

#[test]
fn a_function_is_its_own_law() {
    let section = read("[[filter]]\nfunction = \"crate::dsp::fir\"\n").unwrap();
    let FilterTarget::Function(function) = &section.filters[0].target else { panic!("it names a function") };
    assert_eq!(function.text, "crate::dsp::fir");
    assert_eq!(texts(&section.filters[0].law), [["fir"]]);
    assert_eq!(section.filters[0].instance, InstancePlace::Argument(0));
}

#[test]
fn several_types_with_one_law_are_as_many_entries() {
    let section = read("[[filter]]\ntype = [\"dsp::Low\", \"dsp::High\"]\nlaw = \"run\"\n").unwrap();
    let paths: Vec<&str> = section.filters.iter().map(|entry| entry.target.path().text.as_str()).collect();
    assert_eq!(paths, ["dsp::Low", "dsp::High"]);
    check_error(
        "[[filter]]\ntype = []\nlaw = \"run\"\n",
        "`/ws/ceid-lint.toml:2:8`: the entry names nothing",
        "name at least one type",
    );
}

#[test]
fn an_unknown_key_has_its_place_and_the_nearest_spelling() {
    check_error("\npresetz = \"auto\"\n", "`/ws/ceid-lint.toml:2:1`: unknown key `presetz`", "did you mean `presets`?");
    check_error(
        "[[filter]]\ntype = \"A\"\nlaw = \"u\"\ntimebase = \"fixed\"\n",
        "`/ws/ceid-lint.toml:4:1`: unknown key `timebase`",
        "did you mean `time_base`?",
    );
}

#[test]
fn an_unknown_value_lists_what_there_is() {
    check_error(
        "[lints]\nmissed_update = \"fatal\"\n",
        "`/ws/ceid-lint.toml:2:17`: unknown value `fatal`",
        "known are `allow`, `warn`, `deny`, `forbid`",
    );
    check_error(
        "[lints]\nmissed_update = \"wran\"\n",
        "`/ws/ceid-lint.toml:2:17`: unknown value `wran`",
        "did you mean `warn`?",
    );
}

#[test]
fn a_wrong_type_says_both() {
    check_error(
        "exclude = 3",
        "`/ws/ceid-lint.toml:1:11`: expected a string or a list of strings, found an integer",
        "",
    );
    check_error(
        "lints = \"deny\"",
        "`/ws/ceid-lint.toml:1:9`: expected a table of rules and levels, found a string",
        "",
    );
}

#[test]
fn a_single_bracket_is_explained() {
    check_error(
        "[filter]\ntype = \"A\"\n",
        "`/ws/ceid-lint.toml:1:1`: `filter` is a list of tables",
        "write `[[filter]]`",
    );
}

#[test]
fn an_entry_names_one_thing() {
    check_error(
        "[[cycle]]\n",
        "`/ws/ceid-lint.toml:1:1`: the entry names nothing: one of `function`, `method`, `attribute` is missing",
        "",
    );
    check_error(
        "[[cycle]]\nfunction = \"a\"\nmethod = \"b::c\"\n",
        "`/ws/ceid-lint.toml:3:10`: `method` and `function` exclude each other",
        "make two entries of it",
    );
}

#[test]
fn a_method_resets_all_of_the_state_or_a_part_of_it() {
    check_error(
        "[[filter]]\ntype = \"A\"\nlaw = \"run\"\nreset = [\"clear\", \"zero\"]\npartial_reset = \"zero\"\n",
        "`/ws/ceid-lint.toml:5:17`: `zero` is under `reset` and under `partial_reset`",
        "leave it where it belongs: a `reset` sets the whole state",
    );
}

#[test]
fn what_is_no_path_is_refused() {
    check_error(
        "[[guard]]\ntype = \"Guard<T>\"\n",
        "`/ws/ceid-lint.toml:2:8`: `Guard<T>` is not a path",
        "write it as in `use`, without generics: `crate::control::Pid`",
    );
}

#[test]
fn groups_and_multiplicities_agree() {
    check_error(
        "[[filter]]\ntype = \"A\"\nlaw = [[\"p\"], [\"c\"]]\nmultiplicity = [\"once\"]\n",
        "`/ws/ceid-lint.toml:4:16`: `law` has 2 groups, `multiplicity` has 1",
        "give one multiplicity for each group of the law",
    );
}

#[test]
fn byte_that_nobody_sees_is_named() {
    for text in ["[[filter]]\n\0", "[[filter]]\ntype = \"a\0b\"\n"] {
        let error = read(text).unwrap_err();
        assert!(error.message.contains("NUL byte"), "{}", error.message);
        assert_eq!(error.place.unwrap().line, 2);
    }
}

#[test]
fn broken_toml_has_its_place() {
    let error = read("[lints\n").unwrap_err();
    assert_eq!(error.place.unwrap().line, 1);
}

#[test]
fn excluded_directories_hold_their_files() {
    let mut config = Config::default();
    config.sections.push(read("exclude = [\"vendor\", \"src/*.gen.rs\"]").unwrap());
    assert!(config.is_excluded(Path::new("/ws/vendor/a/src/lib.rs")));
    assert!(config.is_excluded(Path::new("/ws/src/a.gen.rs")));
    assert!(!config.is_excluded(Path::new("/ws/src/a.rs")));
    assert!(!config.is_excluded(Path::new("/elsewhere/vendor/a.rs")));
}
