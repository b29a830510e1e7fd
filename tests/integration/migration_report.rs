//! The proof report as a measure of how far a code base has come: shares, what stands in the way, the trend, and the page.

use std::fs;
use std::path::Path;

use serde_json::Value;

use crate::support::program::run;
use crate::support::workspace::{committed, copy, write};

fn json(directory: &Path, args: &[&str]) -> Value {
    let run = run(directory, [&["report", "--message-format", "json"], args].concat());
    serde_json::from_str(&run.assert_code(0).stdout).unwrap_or_else(|error| panic!("{error}:\n{}", run.stdout))
}

#[test]
fn shares_are_told_of_all_of_each_package_and_of_each_file() {
    let report = json(&committed("legacy_drone"), &[]);
    assert_eq!(report["schema"], 1);
    assert_eq!(report["summary"]["cycles"]["total"], 8);
    assert_eq!(report["summary"]["cycles"]["violated"], 7);
    assert_eq!(report["summary"]["filters"]["proved"], 1);
    let names: Vec<&Value> = report["packages"].as_array().expect("a list").iter().map(|it| &it["name"]).collect();
    assert_eq!(names, ["flight", "ground"]);
    assert_eq!(report["packages"][0]["files"][0]["file"], "flight/src/control.rs");
    assert_eq!(report["packages"][0]["files"][0]["cycles"]["total"], 7);
    let first = &report["blockers"][0];
    assert_eq!((&first["rule"], &first["filters"]), (&Value::from("ceid::repeated_update"), &Value::from(7)));
    assert!(report.get("trend").is_none());
}

#[test]
fn guarded_cycles_are_counted_by_themselves() {
    let report = json(&committed("figure3_guarded"), &[]);
    assert_eq!(report["summary"]["cycles"]["guarded"], report["summary"]["cycles"]["total"]);
}

#[test]
fn a_trend_is_told_against_a_report_of_before() {
    let directory = copy("legacy_drone", "report_trend");
    let before = run(&directory, ["report", "--message-format", "json", "--output", "before.json"]);
    assert_eq!(before.assert_code(0).stdout, "");
    let main = fs::read_to_string(directory.join("ground/src/main.rs")).expect("it is there");
    write(&directory, "ground/src/main.rs", main.replacen("        signal.update();\n", "", 1).as_bytes());
    let control = fs::read_to_string(directory.join("flight/src/control.rs")).expect("it is there");
    let once = "run_short(&mut self) {\n        loop {\n            self.height.update();\n";
    let twice = format!("{once}            self.height.update();\n");
    write(&directory, "flight/src/control.rs", control.replacen(once, &twice, 1).as_bytes());
    let trend = &json(&directory, &["--compare-with", "before.json"])["trend"];
    assert_eq!((&trend["better"], &trend["before"]["cycles"]["violated"]), (&Value::from(1), &Value::from(7)));
    assert_eq!(trend["worse"].as_array().map(Vec::len), Some(1));
    assert_eq!((&trend["worse"][0]["before"], &trend["worse"][0]["now"]), (&"proved".into(), &"violated".into()));
    let human = run(&directory, ["report", "--compare-with", "before.json"]).stdout;
    assert!(human.contains("since the previous report") && human.contains("1 filter better, 1 worse"), "{human}");
    for (name, text) in [("none.json", None), ("odd.json", Some("[]"))] {
        if let Some(text) = text {
            write(&directory, name, text.as_bytes());
        }
        let run = run(&directory, ["report", "--compare-with", name]);
        run.assert_code(101).assert_stderr(&format!("cannot compare with the report `{name}`"));
    }
}

#[test]
fn the_page_is_one_file_that_needs_nothing() {
    let directory = copy("legacy_drone", "report_page");
    let run_both = run(&directory, ["report", "--output", "html=out/report.html"]);
    assert!(run_both.assert_code(0).stdout.contains("checked 8 cycles"));
    let page = fs::read_to_string(directory.join("out/report.html")).expect("it was written");
    assert_eq!(run(&directory, ["report", "--message-format", "html"]).assert_code(0).stdout, page);
    assert!(page.starts_with("<!doctype html>") && page.contains("<code>Hover::run</code>"));
    for outside in ["<script", "http://", "https://", "<link", "src=", &directory.display().to_string()] {
        assert!(!page.contains(outside), "{outside}");
    }
    run(&directory, ["report", "--output", "htm=x"]).assert_code(2).assert_stderr("did you mean `html`?");
    run(&directory, ["report", "--output", "html=Cargo.toml/x"]).assert_code(101).assert_stderr("cannot write");
}
