//! The exit code: 0 nothing at `deny`, 100 findings at `deny`, 101 something could not be read, 2 wrong usage.

use crate::support::program::{program, run, run_command};
use crate::support::workspace::{GUILTY, committed, temporary_package};

const SKIPPING: &str = "\
trait SampledFilter { fn update(&mut self); }
struct Kalman;
impl SampledFilter for Kalman { fn update(&mut self) {} }
pub fn run(mut busy: impl FnMut() -> bool) {
    let mut kf = Kalman;
    loop {
        if busy() {
            continue;
        }
        kf.update();
    }
}
";

#[track_caller]
fn check(name: &str, source: &str, args: &[&str], code: i32) {
    let directory = temporary_package(name, &[("src/lib.rs", source.as_bytes())]);
    run(&directory, args).assert_no_panic().assert_code(code);
}

#[test]
#[cfg(target_os = "linux")]
fn result_that_cannot_be_written_is_101() {
    use std::process::Command;

    let directory = temporary_package("exit_cut_off", &[("src/lib.rs", SKIPPING.as_bytes())]);
    for args in [&["--message-format", "sarif"][..], &["report"], &["rules"]] {
        // The shell gives the program a device without any room.
        let command = format!("'{}' ceid-lint {} > /dev/full", program().display(), args.join(" "));
        let run = run_command(Command::new("sh").args(["-c", &command]).current_dir(&directory));
        run.assert_no_panic().assert_code(101).assert_stderr("cannot write to stdout");
    }
}

#[test]
fn clean_run_is_0() {
    let clean = GUILTY.replacen("        kf.update();\n", "", 1);
    check("exit_clean", &clean, &[], 0);
}

#[test]
fn denied_finding_is_100() {
    check("exit_denied", GUILTY, &[], 100);
}

#[test]
fn warning_is_0() {
    check("exit_warning", SKIPPING, &[], 0);
}

#[test]
fn warning_is_100_where_warnings_are_denied() {
    check("exit_warning_denied", SKIPPING, &["-D", "warnings"], 100);
    check("exit_skip_denied", SKIPPING, &["-D", "ceid::skipped_update"], 100);
}

#[test]
fn allowed_finding_is_0() {
    check("exit_allowed", GUILTY, &["-A", "repeated_update"], 0);
}

#[test]
fn later_level_wins() {
    check("exit_later", GUILTY, &["-A", "repeated_update", "-D", "repeated_update"], 100);
}

#[test]
fn report_has_no_findings_of_its_own() {
    check("exit_report", GUILTY, &["report"], 0);
}

#[test]
fn unreadable_file_wins_over_findings() {
    let directory = committed("unparsable_file");
    run(&directory, [""; 0]).assert_no_panic().assert_code(101);
}

#[test]
fn wrong_usage_is_2() {
    check("exit_usage", GUILTY, &["--no-such-flag"], 2);
    check("exit_command", GUILTY, &["explain"], 2);
}
