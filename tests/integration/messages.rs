//! The look of the human form, for one case of each kind of message.

use cargo_ceid_lint::diagnostic::Level;
use cargo_ceid_lint::rules;

use crate::support::program::run;
use crate::support::root;

#[track_caller]
fn check(rule: &str, case: &str) {
    let directory = root().join("fixtures/rules").join(rule);
    let file = format!("{case}.rs");
    let is_allowed = rules::find(rule).is_some_and(|rule| rule.default_level == Level::Allow);
    let switched_on: &[&str] = if is_allowed { &["-W", rule] } else { &[] };
    let run = run(&directory, switched_on.iter().copied().chain([file.as_str()]));
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
fn repeated_beside_others_of_the_same_static() {
    check("repeated_update", "fields_behind_one_lock");
}

#[test]
fn repeated_by_two_calls_of_a_closure() {
    check("repeated_update", "closure_that_runs_twice");
}

#[test]
fn repeated_in_the_next_round_of_an_inner_loop() {
    check("repeated_update", "inner_while_that_counts");
}

#[test]
fn repeated_by_two_guards() {
    check("repeated_update", "two_live_guards");
}

#[test]
fn repeated_behind_a_gate() {
    check("repeated_update", "twice_when_a_sample_is_there");
}

#[test]
fn repeated_where_a_failure_panics() {
    check("repeated_update", "behind_what_must_not_fail");
}

#[test]
fn repeated_around_what_is_not_shipped() {
    check("repeated_update", "asserted_between_two_updates");
}

#[test]
fn missed() {
    check("missed_update", "field_of_the_same_self");
}

#[test]
fn missed_where_a_copy_is_updated() {
    check("missed_update", "copy_under_another_name");
}

#[test]
fn skipped() {
    check("skipped_update", "continue_while_the_bus_is_busy");
}

#[test]
fn skipped_where_a_helper_returns() {
    check("skipped_update", "condition_of_a_helper_that_the_caller_sets");
}

#[test]
fn two_skipped_by_one_statement() {
    check("skipped_update", "two_filters_by_one_continue");
}

#[test]
fn repeated_in_the_argument_of_a_macro() {
    check("repeated_update", "argument_that_a_macro_writes_twice");
}

#[test]
fn missed_where_nothing_consumes_the_iterator() {
    check("missed_update", "iterator_that_nothing_consumes");
}

#[test]
fn missed_where_nothing_awaits_the_future() {
    check("missed_update", "future_that_nothing_awaits");
}

#[test]
fn missed_where_nothing_calls_the_closure() {
    check("missed_update", "closure_that_is_never_called");
}

#[test]
fn missed_where_a_helper_takes_a_copy() {
    check("missed_update", "value_of_a_copy_in_a_helper");
}

#[test]
fn skipped_where_any_ends() {
    check("skipped_update", "any_ends_at_the_first_hit");
}

#[test]
fn skipped_where_a_reset_is_partial() {
    check("skipped_update", "entered_with_half_a_reset");
}

#[test]
fn skipped_where_another_filter_is_reset() {
    check("skipped_update", "states_are_entered_by_one_method_that_resets_another");
}

#[test]
fn skipped_while_its_clock_goes_on() {
    check("skipped_update", "clock_moves_on_without_a_sample");
}

#[test]
fn skipped_at_another_rate_than_claimed() {
    check("skipped_update", "claimed_rate_is_another");
}

#[test]
fn repeated_by_two_that_change_places() {
    check("repeated_update", "swapped_between_two_updates");
}

#[test]
fn guard_dropped() {
    check("guard_dropped_early", "bound_to_an_underscore");
}

#[test]
fn debug_only() {
    check("debug_only_update", "in_a_helper_of_the_loop");
}

#[test]
fn debug_only_beside_another_update() {
    check("debug_only_update", "once_more_in_an_assertion");
}

#[test]
fn two_events() {
    check("multi_event_update", "two_messages_of_one_queue");
}

#[test]
fn skipped_by_one_of_several_closures() {
    check("skipped_update", "one_of_two_closures_by_a_reference");
}

#[test]
fn unguarded() {
    check("unguarded_update", "once_in_a_loop");
}

#[test]
fn time_in_a_cycle() {
    check("time_in_cycle", "reads_a_file_in_a_helper");
}

#[test]
fn another_rate() {
    check("rate_mismatch", "made_in_the_constructor_of_its_owner");
}

#[test]
fn repeated_with_a_sibling_that_nobody_owes() {
    check("repeated_update", "pasted_in_a_presumed_cycle");
}

#[test]
fn unused_suppression() {
    check("unused_suppression", "one_of_two_rules");
}

#[test]
fn misspelt_suppression() {
    check("unknown_rule", "misspelt_rule");
}

#[test]
fn reason_outside_the_brackets() {
    check("unknown_rule", "reason_outside_the_brackets");
}

#[test]
fn blanket_suppression() {
    check("blanket_suppression", "bare_allow");
}
