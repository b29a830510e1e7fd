//! The language server, as an editor meets it: over the streams of the built program.

mod actions;
mod client;
mod diagnostics;
mod edits;
mod rust_analyzer;
mod session;
mod unsaved;
mod workspace;

use std::path::{Path, PathBuf};

use serde_json::{Value, json};

use crate::support::workspace::{GUILTY, temporary_package};

/// A package whose library has one finding, and that library.
fn guilty(name: &str) -> (PathBuf, PathBuf) {
    let directory = temporary_package(name, &[("src/lib.rs", GUILTY.as_bytes())]);
    let file = directory.join("src/lib.rs");
    (directory, file)
}

/// `GUILTY` without what it is guilty of.
fn innocent() -> String {
    GUILTY.replacen("        kf.update();\n", "", 1)
}

/// The rules that are named by findings.
fn codes(findings: &[Value]) -> Vec<&str> {
    findings.iter().map(|finding| finding["code"].as_str().unwrap_or("none")).collect()
}

/// The places of findings: line and columns.
fn places(findings: &Value) -> Vec<[u64; 3]> {
    let number = |value: &Value| value.as_u64().expect("it is a number");
    let place = |range: &Value| {
        [number(&range["start"]["line"]), number(&range["start"]["character"]), number(&range["end"]["character"])]
    };
    findings.as_array().expect("it is a list").iter().map(|finding| place(&finding["range"])).collect()
}

fn of_document(path: &Path) -> Value {
    json!({ "textDocument": { "uri": client::uri(path) } })
}
