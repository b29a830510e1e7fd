//! Suppressed findings stay in the machine form, are counted for people, and decide nothing; the fixes that go with them.

use std::collections::HashSet;

use serde_json::Value;

use crate::support::program::{Run, run};
use crate::support::workspace::{GUILTY, temporary_package};

/// The guilty module with a directive above its loop.
fn above_the_loop(directive: &str) -> String {
    GUILTY.replace("    loop {", &format!("    {directive}\n    loop {{"))
}

#[track_caller]
fn check(name: &str, source: &str, args: &[&str]) -> Run {
    let directory = temporary_package(name, &[("src/lib.rs", source.as_bytes())]);
    run(&directory, args)
}

/// The messages of a run with `--message-format json`.
fn messages(run: &Run) -> Vec<Value> {
    let lines = run.stdout.lines().map(|line| serde_json::from_str::<Value>(line).expect("each line is JSON"));
    lines.filter(|line| line["reason"] == "compiler-message").map(|mut line| line["message"].take()).collect()
}

#[test]
fn suppressed_finding_decides_nothing_and_is_counted() {
    let source = above_the_loop("// ceid: allow(repeated_update, reason = \"two half steps\")");
    let run = check("suppressed", &source, &[]);
    run.assert_code(0).assert_stderr("; 1 finding suppressed\n");
    assert_eq!(run.stderr.lines().count(), 1, "{}", run.stderr);
    let run = check("suppressed", &source, &["--message-format", "short"]);
    assert_eq!(run.assert_code(0).stderr.lines().count(), 1, "{}", run.stderr);
}

#[test]
fn suppressed_finding_is_marked_with_its_reason() {
    let source = above_the_loop("// ceid: allow(repeated_update, reason = \"two half steps\")");
    let run = check("suppressed_json", &source, &["--message-format", "json"]);
    let found = messages(run.assert_code(0));
    assert_eq!(found.len(), 1);
    assert_eq!(found[0]["ceid"]["suppressed"], "two half steps");
    assert_eq!(found[0]["ceid"]["rule"], "ceid::repeated_update");
    assert!(run.findings().expect("it is JSON").is_empty());
    let without = source.replace(", reason = \"two half steps\"", "");
    let run = check("suppressed_json", &without, &["--message-format", "json"]);
    assert_eq!(messages(run.assert_code(0))[0]["ceid"]["suppressed"], "");
}

#[test]
fn proof_report_gives_the_reason() {
    let source = above_the_loop("// ceid: allow(repeated_update, reason = \"two half steps\")");
    let run = check("suppressed_report", &source, &["report", "--message-format", "json"]);
    let report: Value = serde_json::from_str(&run.assert_code(0).stdout).expect("it is JSON");
    let pair = &report["cycles"][0]["filters"][0];
    assert_eq!((&pair["verdict"], &pair["suppressed"]), (&"repeated".into(), &"two half steps".into()));
}

#[test]
fn forbidden_finding_cannot_be_suppressed() {
    let source = above_the_loop("// ceid: allow(repeated_update, reason = \"two half steps\")");
    let run = check("suppressed_forbidden", &source, &["-F", "repeated_update", "--message-format", "json"]);
    let found = run.assert_code(100).findings().expect("it is JSON");
    let rules: Vec<&str> = found.iter().map(|finding| finding.rule.as_str()).collect();
    assert_eq!(rules, ["repeated_update"]);
    check("suppressed_forbidden", &source, &["-F", "correctness"]).assert_code(100);
    check("suppressed_forbidden", &source, &["-D", "repeated_update"]).assert_code(0);
}

#[test]
fn hygiene_can_be_denied_and_is_not_needed_where_a_rule_is_off() {
    let source = above_the_loop("// ceid: allow(skipped_update)").replacen("        kf.update();\n", "", 1);
    check("suppressed_unused", &source, &[]).assert_code(0).assert_stderr("unused_suppression");
    check("suppressed_unused", &source, &["-D", "hygiene"]).assert_code(100);
    let used = above_the_loop("// ceid: allow(repeated_update)");
    let run = check("suppressed_off", &used, &["-A", "repeated_update"]);
    assert!(!run.assert_code(0).stderr.contains("unused_suppression"), "{}", run.stderr);
}

#[test]
fn module_in_a_file_of_its_own_is_suppressed_where_it_is_declared() {
    let check = |root: &str, module: &str, code: i32| {
        let inner = GUILTY.replace("pub trait", "\npub trait");
        let files = [("src/lib.rs", root), ("src/a/mod.rs", module), ("src/a/b.rs", &inner), ("src/c.rs", &inner)];
        let files = files.map(|(path, text)| (path, text.as_bytes()));
        let directory = temporary_package("suppressed_modules", &files);
        let run = run(&directory, [""; 0]);
        run.assert_code(code);
        assert!(!run.stderr.contains("unused"), "{}", run.stderr);
    };
    check("// ceid: allow(repeated_update)\npub mod a;\n", "pub mod b;\n", 0);
    check("pub mod a;\n", "// ceid: allow(repeated_update)\npub mod b;\n", 0);
    check("// ceid: allow(repeated_update)\npub mod a;\npub mod c;\n", "pub mod b;\n", 100);
    check("#![cfg_attr(any(), ceid::allow(repeated_update))]\npub mod a;\npub mod c;\n", "pub mod b;\n", 0);
    check("pub mod a;\n", "#![cfg_attr(any(), ceid::allow(repeated_update))]\npub mod b;\n", 0);
}

#[test]
fn project_without_a_filter_has_its_directives_checked() {
    check("suppressed_nothing", "// ceid: alow(skipped_update)\nfn f() {}\n", &[])
        .assert_stderr("unknown directive `alow`");
}

/// Applies what can be applied without a look, and checks the result.
#[track_caller]
fn fixes(name: &str, before: &str, after: &str) {
    fixes_if(None, name, before, after);
}

/// The same, or all that is offered for a rule.
#[track_caller]
fn fixes_if(rule: Option<&str>, name: &str, before: &str, after: &str) {
    let run = check(name, before, &["--message-format", "json"]);
    let filter = if rule.is_some() { rustfix::Filter::Everything } else { rustfix::Filter::MachineApplicableOnly };
    let all: Vec<String> = messages(&run).iter().map(|message| format!("{message}\n")).collect();
    let bare: String = all.into_iter().filter(|message| rule.is_none_or(|rule| message.contains(rule))).collect();
    let suggestions = rustfix::get_suggestions_from_json(&bare, &HashSet::new(), filter).expect("they are well formed");
    assert_eq!(rustfix::apply_suggestions(before, &suggestions).expect("they do not overlap"), after);
    let run = check(name, after, &["--message-format", "json"]);
    let left = run.findings().expect("it is JSON");
    assert!(
        left.iter().all(|finding| !finding.rule.ends_with("suppression") && finding.rule != "unknown_rule"),
        "{left:?}"
    );
}

#[test]
fn unused_suppression_is_removed() {
    fixes("fix_unused", &above_the_loop("// ceid: allow(skipped_update, reason = \"so\")"), GUILTY);
    fixes("fix_attribute", &above_the_loop("#[cfg_attr(any(), ceid::expect(skipped_update))]"), GUILTY);
    let behind = GUILTY.replace("    loop {", "    loop { // ceid: allow(missed_update)");
    fixes("fix_behind", &behind, GUILTY);
    fixes(
        "fix_three",
        &above_the_loop(
            "// ceid: allow(missed_update, repeated_update, gated_update, skipped_update, reason = \"so\")",
        ),
        &above_the_loop("// ceid: allow(repeated_update, reason = \"so\")"),
    );
}

#[test]
fn near_miss_is_corrected() {
    let right = above_the_loop("// ceid: allow(repeated_update, reason = \"two half steps\")");
    for wrong in [
        "// ceid: alow(repeated_update, reason = \"two half steps\")",
        "// CEID: allow(repeated_update, reason = \"two half steps\")",
        "// ceid: allow(repeated_update) -- two half steps",
    ] {
        let wrong = above_the_loop(wrong);
        fixes_if(Some("unknown_rule"), "fix_near_miss", &wrong, &right);
        // What hides a finding from then on is not for certain.
        let run = check("fix_near_miss", &wrong, &["--message-format", "json"]);
        let bare: String = messages(&run).iter().map(|message| format!("{message}\n")).collect();
        let certain = rustfix::Filter::MachineApplicableOnly;
        let certain =
            rustfix::get_suggestions_from_json(&bare, &HashSet::new(), certain).expect("they are well formed");
        assert!(certain.is_empty(), "{certain:?}");
    }
}
