//! Each committed workspace gives the findings of its `expected.txt`, and no others.

use std::path::Path;

use crate::support::program::{Run, run};
use crate::support::{root, workspace};

/// `file:line rule` of each finding, sorted, files relative to the workspace.
fn lines(run: &Run, directory: &Path) -> Vec<String> {
    let prefix = format!("{}/", directory.display()).replace('\\', "/");
    let findings = run.findings().unwrap_or_else(|error| panic!("{error}"));
    let mut lines: Vec<String> = findings
        .iter()
        .map(|finding| {
            let file = finding.file.strip_prefix(&prefix).unwrap_or(&finding.file);
            format!("{file}:{} {}", finding.line, finding.rule)
        })
        .collect();
    lines.sort();
    lines
}

#[track_caller]
fn check(name: &str) {
    check_with(name, "expected.txt", &[]);
}

#[track_caller]
fn check_with(name: &str, expected: &str, flags: &[&str]) {
    let directory = workspace::committed(name);
    let expected = std::fs::read_to_string(directory.join(expected)).expect("the workspace says what it expects");
    let run = run(&directory, ["--workspace", "--message-format", "json"].iter().chain(flags));
    assert_eq!(lines(&run, &directory), expected.lines().collect::<Vec<_>>());
}

#[test]
fn legacy_robot_of_figure_3() {
    check("figure3_legacy");
}

#[test]
fn guarded_robot_of_figure_3() {
    check("figure3_guarded");
}

#[test]
fn guards_of_ceid_core_read_as_a_dependency() {
    check("guards_of_a_dependency");
}

#[test]
fn legacy_drone_without_its_baseline() {
    check("legacy_drone");
}

#[test]
fn finding_in_a_library_beside_the_workspace_is_shown_at_the_call() {
    check("library_beside/winch");
}

#[test]
fn finding_across_two_crates() {
    check("two_crates");
}

#[test]
fn macros_that_other_crates_give() {
    check_with("macros_between_crates", "expected.txt", &["--all-targets", "-W", "unproved_update"]);
}

#[test]
fn modules_by_path_and_by_feature() {
    check("path_modules");
    check_with("path_modules", "expected.turbo.txt", &["--features", "turbo"]);
}

#[test]
fn fallbacks_of_attempts_that_fail() {
    check("configured_attempts");
}

#[test]
fn alternatives_halves_attempts_and_resets() {
    check("configured_laws");
}

#[test]
fn laws_named_as_methods_of_wrappers_and_what_else_an_entry_may_say() {
    check_with("configured_wrappers", "expected.txt", &["-W", "unproved_update"]);
}

#[test]
fn instances_in_arguments_results_and_channels() {
    check("configured_instances");
}

#[test]
fn methods_that_give_their_filter_back() {
    check_with("configured_chains", "expected.txt", &["-W", "unproved_update"]);
}

#[test]
fn states_that_helpers_and_exchanges_give_back() {
    check_with("configured_helpers", "expected.txt", &["-W", "unproved_update"]);
}

#[test]
fn laws_by_traits_that_make_no_filters() {
    check_with("configured_dispatch", "expected.txt", &["-W", "unproved_update"]);
    let directory = workspace::committed("configured_dispatch");
    let report = run(&directory, ["report", "--message-format", "json"]);
    let report: serde_json::Value = serde_json::from_str(&report.stdout).expect("the report is JSON");
    let cycles = report["cycles"].as_array().expect("the report lists cycles");
    assert!(cycles.iter().all(|cycle| cycle["function"] != "no_filter"), "{report:#}");
    // What is behind a trait object is known by the law of its types.
    let boxed = cycles.iter().find(|cycle| cycle["function"] == "once_in_a_box").expect("it is a cycle");
    assert_eq!((&boxed["filters"][0]["law"], &boxed["filters"][0]["verdict"]), (&"advance".into(), &"once".into()));
}

/// The one entry of a report for a filter of a function.
fn verdict(report: &serde_json::Value, function: &str, filter: &str) -> String {
    let cycles = report["cycles"].as_array().expect("the report lists cycles");
    let own = cycles.iter().find(|cycle| cycle["function"] == function).expect("it is a cycle");
    let filters = own["filters"].as_array().expect("a cycle lists filters");
    let entry = filters.iter().find(|entry| entry["name"] == filter).expect("it is a filter of the cycle");
    entry["verdict"].as_str().expect("an entry has a verdict").to_owned()
}

#[test]
fn a_law_is_one_update_whatever_filters_hold_each_other() {
    check("configured_nested");
    let report = run(&workspace::committed("configured_nested"), ["report", "--message-format", "json"]);
    let report: serde_json::Value = serde_json::from_str(&report.stdout).expect("the report is JSON");
    assert_eq!(verdict(&report, "Track::each_once", "self.effects[*]"), "once");
    assert_eq!(verdict(&report, "one", "echo"), "once");
    // What lies in them is not followed to its end.
    assert_eq!(verdict(&report, "Track::each_once", "self.effects[*].left.first"), "unproved");
}

#[test]
fn laws_by_a_trait_of_many_types() {
    check_with("configured_many", "expected.txt", &["-W", "unproved_update"]);
}

#[test]
fn channels_by_literal_keys() {
    check_with("configured_keys", "expected.txt", &["-W", "unproved_update"]);
}

#[test]
fn states_that_laws_give_back() {
    check_with("configured_estimates", "expected.txt", &["-W", "unproved_update", "-W", "gated_update"]);
}

#[test]
fn states_in_arguments() {
    check("configured_states");
}

#[test]
fn functions_that_change_one_state() {
    check("configured_functions");
}

#[test]
fn numbers_that_functions_move_on() {
    check("configured_numbers");
}

#[test]
fn names_that_clash_and_names_for_the_same() {
    check("configured_names");
}

#[test]
fn cycles_that_the_configuration_names() {
    check("configured_cycles");
}

#[test]
fn guards_that_the_configuration_names() {
    check("configured_guards");
}

#[test]
fn guards_that_no_plain_let_binds() {
    check_with("configured_guard_forms", "expected.txt", &["-W", "unproved_update", "-W", "gated_update"]);
}

#[test]
fn rules_of_guards_stand_at_the_pairs_they_hold() {
    let directory = workspace::committed("configured_guard_forms");
    let report = run(&directory, ["report", "--message-format", "json"]);
    let report: serde_json::Value = serde_json::from_str(&report.stdout).expect("the report is JSON");
    let cycles = report["cycles"].as_array().into_iter().flatten();
    let pairs = cycles.flat_map(|cycle| {
        let filters = cycle["filters"].as_array().into_iter().flatten();
        filters.map(move |filter| {
            let text = |value: &serde_json::Value| value.as_str().unwrap_or_default().to_owned();
            let rules: Vec<String> = filter["rules"].as_array().into_iter().flatten().map(text).collect();
            format!("{}: {} {}", text(&cycle["function"]), text(&filter["verdict"]), rules.join(" "))
        })
    });
    let told: Vec<String> = pairs.collect();
    for expected in [
        "made_in_either_branch: guarded ",
        "never_bound_but_used: guarded ceid::guard_dropped_early",
        "dropped_in_the_middle: guarded ceid::guard_dropped_early",
        "forgotten: missed ceid::forgotten_guard ceid::missed_update",
        "before_the_loop: missed ceid::guard_outside_cycle ceid::missed_update",
        "over_a_loop_that_ends: missed ceid::guard_outside_cycle ceid::missed_update",
    ] {
        assert!(told.iter().any(|line| line == expected), "{expected} in {told:#?}");
    }
    // A function around the loop is no cycle that its guard is right for.
    let of_function = told.iter().filter(|line| line.starts_with("over_a_loop_that_ends"));
    assert_eq!(of_function.count(), 1, "{told:#?}");
}

#[test]
fn entries_for_members_of_a_workspace() {
    check("configured_members");
}

#[test]
fn handlers_and_tasks_of_firmware() {
    check("interrupts");
}

#[test]
fn macros_maps_and_iterators_of_other_crates() {
    check("other_crates");
}

#[test]
fn methods_of_a_trait_of_another_crate() {
    check("foreign_traits");
}

#[test]
fn every_workspace_that_expects_something_is_tested() {
    let tests = include_str!("workspaces.rs");
    for entry in std::fs::read_dir(root().join("fixtures/workspaces")).expect("the workspaces are committed") {
        let directory = entry.expect("the directory is readable").path();
        let name = directory.file_name().expect("it has a name").to_string_lossy().into_owned();
        if directory.join("expected.txt").exists() {
            let is_tested = ["check", "check_with"].iter().any(|call| tests.contains(&format!("{call}(\"{name}\"")));
            assert!(is_tested, "`{name}` has no test");
        }
    }
}
