//! The look of the human form, for one case of each kind of message.

use crate::support::program::run;
use crate::support::root;

#[track_caller]
fn check(rule: &str, case: &str) {
    let directory = root().join("fixtures/rules").join(rule);
    let run = run(&directory, [format!("{case}.rs")]);
    let mut settings = insta::Settings::clone_current();
    settings.set_snapshot_path("../snapshots");
    settings.set_prepend_module_to_snapshot(false);
    settings.set_omit_expression(true);
    // The time that a run took.
    settings.add_filter(r"\d+(\.\d+)? ?(ms|s)\b", "[TIME]");
    settings.bind(|| insta::assert_snapshot!(format!("{rule}__{case}"), run.stderr));
}

#[test]
fn repeated() {
    check("repeated_update", "twice_in_a_loop");
}

#[test]
fn repeated_with_the_missed_siblings() {
    check("repeated_update", "same_axis_pasted_three_times");
}

#[test]
fn missed() {
    check("missed_update", "field_of_the_same_self");
}

#[test]
fn skipped() {
    check("skipped_update", "continue_while_the_bus_is_busy");
}

#[test]
fn two_skipped_by_one_statement() {
    check("skipped_update", "two_filters_by_one_continue");
}

#[test]
fn guard_dropped() {
    check("guard_dropped_early", "bound_to_an_underscore");
}
