//! Bad input: what is wrong is told with its file, the rest is still checked, and nothing crashes.

use std::path::Path;

use crate::support::program::{Run, run};
use crate::support::workspace::{GUILTY, committed, temporary, temporary_package};

fn check_json(directory: &Path) -> Run {
    let run = run(directory, ["--workspace", "--message-format", "json"]);
    run.assert_no_panic();
    run
}

/// The finding of the good module is there in spite of the bad one, whose file is named.
#[track_caller]
fn check_rest_is_checked(directory: &Path, bad: &str) {
    let json = check_json(directory);
    json.assert_code(101);
    let findings = json.findings_in_spite_of_problems().expect("the output is whole");
    let found: Vec<_> = findings.iter().map(|f| (f.file.as_str(), f.line, f.rule.as_str())).collect();
    assert!(found.contains(&("src/good.rs", 7, "repeated_update")), "{found:?}\n{}", json.stderr);
    run(directory, [""; 0]).assert_no_panic().assert_code(101).assert_stderr(bad);
}

#[test]
fn unparsable_file() {
    check_rest_is_checked(&committed("unparsable_file"), "src/odd.rs");
}

#[test]
fn the_place_of_an_error_where_there_is_no_filter() {
    let package =
        temporary_package("unparsable_without_filter", &[("src/lib.rs", b"fn a() {}\n\nfn b() { let x = ; }\n")]);
    run(&package, ["--message-format", "short"]).assert_code(101).assert_stderr("src/lib.rs:3:18: error: expected");
}

#[test]
fn missing_module() {
    check_rest_is_checked(&committed("missing_module"), "lost");
}

#[test]
fn file_that_is_not_utf_8() {
    let files: [(&str, &[u8]); 3] = [
        ("src/lib.rs", b"mod good;\nmod odd;\n"),
        ("src/good.rs", GUILTY.as_bytes()),
        ("src/odd.rs", b"// caf\xe9\nfn f() {}\n"),
    ];
    check_rest_is_checked(&temporary_package("not_utf_8", &files), "src/odd.rs");
}

#[test]
fn nesting_beyond_the_depth_limit() {
    let deep = format!("pub fn f() -> u8 {{ {}1{} }}\n", "(".repeat(5_000), ")".repeat(5_000));
    let files: [(&str, &[u8]); 3] = [
        ("src/lib.rs", b"mod good;\nmod deep;\n"),
        ("src/good.rs", GUILTY.as_bytes()),
        ("src/deep.rs", deep.as_bytes()),
    ];
    check_rest_is_checked(&temporary_package("deep_nesting", &files), "src/deep.rs");
}

#[test]
fn modules_that_include_each_other() {
    let files: [(&str, &[u8]); 3] = [
        ("src/lib.rs", b"mod good;\nmod a;\n"),
        ("src/good.rs", GUILTY.as_bytes()),
        ("src/a.rs", b"#[path = \"a.rs\"]\nmod again;\npub fn f() {}\n"),
    ];
    check_rest_is_checked(&temporary_package("module_cycle", &files), "src/a.rs");
}

#[test]
fn broken_manifest() {
    let run = check_json(&committed("broken_manifest"));
    run.assert_code(101).assert_stderr("Cargo.toml");
}

#[test]
fn package_without_targets() {
    let run = check_json(&committed("no_targets"));
    run.assert_code(101).assert_stderr("Cargo.toml");
}

#[test]
fn empty_workspace() {
    let directory = committed("empty_workspace");
    check_json(&directory).assert_code(0).assert_stderr("nothing to check");
    assert_ne!(run(&directory, ["--workspace", "--no-loops", "fail"]).code, Some(0));
    run(&directory, ["--workspace", "--no-loops", "pass"]).assert_no_panic().assert_code(0);
}

#[test]
fn directory_without_a_manifest() {
    // A root of its own, for cargo looks for manifests in the directories above.
    let directory = std::env::temp_dir().join(format!("ceid-lint-no-manifest-{}", std::process::id()));
    std::fs::create_dir_all(&directory).expect("the temporary directory is writable");
    let run = run(&directory, [""; 0]);
    std::fs::remove_dir_all(&directory).expect("it was just made");
    run.assert_no_panic().assert_code(101).assert_stderr("Cargo.toml");
}

#[test]
fn file_that_does_not_exist() {
    run(&temporary("no_such_file"), ["no_such_file.rs"]).assert_no_panic().assert_stderr("no_such_file.rs");
}

#[test]
fn very_long_line() {
    let long = format!("pub const TEXT: &str = \"{}\";\n", "x".repeat(2_000_000));
    let source = format!("{}{GUILTY}", long.trim_end());
    let directory = temporary_package("long_line", &[("src/lib.rs", source.as_bytes())]);
    let run = check_json(&directory);
    let findings = run.assert_code(100).findings().expect("the package is readable");
    assert_eq!(findings.len(), 1);
    assert_eq!(findings[0].line, 7);
}

#[test]
fn windows_line_ends_and_byte_order_mark() {
    let source = format!("\u{feff}{}", GUILTY.replace('\n', "\r\n"));
    let directory = temporary_package("windows_text", &[("src/lib.rs", source.as_bytes())]);
    let findings = check_json(&directory).assert_code(100).findings().expect("the package is readable");
    assert_eq!(findings.iter().map(|finding| finding.line).collect::<Vec<_>>(), [7]);
}

#[test]
fn empty_file() {
    let directory = temporary_package("empty_file", &[("src/lib.rs", b"")]);
    check_json(&directory).assert_code(0);
}

/// So many conditions that the graph of their function is given up before what follows them.
fn conditions() -> String {
    (0..33_000).map(|number| format!("    if v > {number}.0 {{ s += {number}.0; }}\n")).collect()
}

const PID: &str = "pub struct Pid { i: f32 }\nimpl Pid { pub fn step(&mut self, e: f32) { self.i += e; } }\n";
const PID_ENTRY: &[u8] = b"[[filter]]\ntype = \"crate::Pid\"\nlaw = \"step\"\n";

#[test]
fn what_a_function_that_is_too_large_may_update_is_unproved() {
    let big = format!("fn big(pid: &mut Pid, v: f32) {{\n    let mut s = 0.0;\n{}    pid.step(s);\n}}\n", conditions());
    let code = format!("{PID}pub fn run(mut pid: Pid, v: f32) {{ loop {{ big(&mut pid, v); }} }}\n{big}");
    let files: [(&str, &[u8]); 2] = [("src/lib.rs", code.as_bytes()), ("ceid-lint.toml", PID_ENTRY)];
    let package = temporary_package("too_large_callee", &files);
    let report = run(&package, ["report"]);
    report.assert_no_panic().assert_code(0);
    for told in
        ["pid  Pid  step  unproved", "the function has more than 200000 steps", "`big` is not followed to its end"]
    {
        assert!(report.stdout.contains(told), "{}", report.stdout);
    }
}

#[test]
fn a_cycle_behind_the_limit_of_a_function_is_told_of() {
    let rest = "    let mut pid = Pid { i: 0.0 };\n    loop { if s < 0.0 { continue; } pid.step(s); }\n}\n";
    let code = format!("{PID}pub fn run(v: f32) {{\n    let mut s = 0.0;\n{}{rest}", conditions());
    let files: [(&str, &[u8]); 2] = [("src/lib.rs", code.as_bytes()), ("ceid-lint.toml", PID_ENTRY)];
    let run = run(&temporary_package("too_large_rest", &files), [""; 0]);
    run.assert_no_panic().assert_code(0).assert_stderr("`run` is not followed to its end");
}

#[test]
fn items_of_a_macro_that_are_too_many_are_told_of() {
    let make = "macro_rules! make { ($($x:tt)*) => { pub fn run(mut pid: Pid) { loop { $( if $x > 1.0 { continue; } )* \
                pid.step(1.0); } } } }\n";
    let code = format!("{PID}{make}make!({});\n", "0.5 ".repeat(10_000));
    let files: [(&str, &[u8]); 2] = [("src/lib.rs", code.as_bytes()), ("ceid-lint.toml", PID_ENTRY)];
    let run = run(&temporary_package("too_many_items", &files), [""; 0]);
    run.assert_no_panic().assert_code(0).assert_stderr("the items that `make!` stands for are not read");
}

#[test]
fn a_crate_for_another_target_is_told_of() {
    let code = format!("#![cfg(target_os = \"none\")]\n{PID}");
    let files: [(&str, &[u8]); 2] = [("src/lib.rs", code.as_bytes()), ("ceid-lint.toml", PID_ENTRY)];
    let run = run(&temporary_package("crate_for_another_target", &files), [""; 0]);
    run.assert_no_panic().assert_code(0).assert_stderr("src/lib.rs: the crate is not there under this `cfg`");
}

#[test]
fn a_merge_conflict_is_called_by_its_name() {
    let files: [(&str, &[u8]); 3] = [
        ("src/lib.rs", b"mod good;\nmod odd;\n"),
        ("src/good.rs", GUILTY.as_bytes()),
        ("src/odd.rs", b"fn a() {}\n<<<<<<< HEAD\nfn b() {}\n=======\nfn c() {}\n>>>>>>> other\n"),
    ];
    let package = temporary_package("merge_conflict", &files);
    check_rest_is_checked(&package, "src/odd.rs");
    run(&package, ["--message-format", "short"])
        .assert_stderr("src/odd.rs:2:1: error: a merge conflict is not resolved");
}
