//! The real rust-analyzer, which runs this program whenever a file is saved. `editors/rust-analyzer-check.sh` finds or builds one.

use std::env;
use std::ffi::OsString;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use serde_json::{Value, json};

use super::client::{Client, applied, plain, uri};
use crate::support::program::program;
use crate::support::root;
use crate::support::workspace::{temporary, write};

const FIXED_BY_HAND: &str = "second_update_goes_with_its_comment";
const FIXED_AT_ONCE: &str = "guard_is_named";

/// rust-analyzer over a workspace of its own, and the file that is looked at.
struct Editor {
    client: Client,
    folder: PathBuf,
    version: i64,
}

impl Editor {
    /// A workspace of a guilty package and an innocent one, with these settings.
    fn with(name: &str, settings: &Value) -> Self {
        let folder = temporary(name);
        write(&folder, "Cargo.toml", b"[workspace]\nmembers = [\"control\", \"plant\"]\nresolver = \"3\"\n");
        let core = root().join("ceid-core");
        let manifest = |package: &str| {
            let head = format!("[package]\nname = \"{package}\"\nversion = \"0.0.0\"\nedition = \"2024\"\n");
            format!("{head}\n[dependencies]\nceid-core = {{ path = {core:?} }}\n")
        };
        for package in ["control", "plant"] {
            write(&folder, &format!("{package}/Cargo.toml"), manifest(package).as_bytes());
        }
        let library = format!("#![allow(dead_code)]\nmod {FIXED_BY_HAND};\nmod {FIXED_AT_ONCE};\n");
        write(&folder, "control/src/lib.rs", library.as_bytes());
        for module in [FIXED_BY_HAND, FIXED_AT_ONCE] {
            write(&folder, &format!("control/src/{module}.rs"), fixture(module, "rs").as_bytes());
        }
        write(&folder, "plant/src/lib.rs", b"pub fn force(throttle: f64) -> f64 { 2.0 * throttle }\n");
        let mut capabilities = plain();
        capabilities["window"] = json!({ "workDoneProgress": true });
        let params = json!({ "processId": null, "rootUri": uri(&folder), "capabilities": capabilities,
            "workspaceFolders": [{ "uri": uri(&folder), "name": "folder" }], "initializationOptions": settings });
        let client = Client::of_other(server().current_dir(&folder), &params);
        Self { client, folder, version: 1 }
    }

    fn file(&self, module: &str) -> PathBuf {
        self.folder.join(format!("control/src/{module}.rs"))
    }

    /// Opens a module, and answers its file.
    fn open(&mut self, module: &str) -> PathBuf {
        let file = self.file(module);
        self.client.open(&file, &fixture(module, "rs"));
        file
    }

    /// Puts a text into the editor and on the disk.
    fn save(&mut self, file: &Path, text: &str) {
        self.version += 1;
        self.client.replace(file, self.version, text);
        fs::write(file, text).expect("the directory is writable");
        self.client.save(file);
    }

    /// What is found in a file, hints left out, when the rules of it are these.
    #[track_caller]
    fn found(&mut self, file: &Path, rules: &[&str]) -> Vec<Value> {
        let shown = self.client.shown(file, |shown| names(&findings(shown)) == rules);
        let found = findings(&shown);
        if rules.is_empty() {
            let left: Vec<&Value> = shown.iter().filter(|it| it["source"] == "ceid").collect();
            assert!(left.is_empty(), "hints are left of what is gone: {left:#?}");
        }
        found
    }

    /// The only quick fix at a place.
    #[track_caller]
    fn fix_at(&mut self, file: &Path, line: u64, character: u64) -> Value {
        let position = json!({ "line": line, "character": character });
        let range = json!({ "start": position, "end": position });
        let actions = self.client.actions(file, &range, &[]);
        let found: Vec<&Value> = actions.iter().filter(|action| action["kind"] == "quickfix").collect();
        let [action] = found.as_slice() else { panic!("not one fix in line {line}: {actions:#?}") };
        (*action).clone()
    }
}

fn server() -> Command {
    let name = env::var_os("RUST_ANALYZER");
    let name = name.expect("RUST_ANALYZER names the program; `editors/rust-analyzer-check.sh` finds or builds one");
    let mut command = Command::new(name);
    // cargo looks for its subcommands there.
    let own = program().parent().map(Path::to_owned).into_iter();
    let others = env::var_os("PATH").unwrap_or_default();
    let paths: OsString = env::join_paths(own.chain(env::split_paths(&others))).expect("they were joined before");
    command.env("PATH", paths);
    for name in ["CARGO_TARGET_DIR", "RUSTFLAGS", "CARGO_BUILD_TARGET"] {
        command.env_remove(name);
    }
    command
}

fn fixture(name: &str, extension: &str) -> String {
    let path = root().join("fixtures/fixes").join(name).with_extension(extension);
    fs::read_to_string(path).expect("it is there")
}

fn findings(shown: &[Value]) -> Vec<Value> {
    shown.iter().filter(|it| it["severity"].as_u64().is_some_and(|severity| severity < 3)).cloned().collect()
}

fn names(findings: &[Value]) -> Vec<String> {
    let text = |value: &Value| value.as_str().unwrap_or("none").to_owned();
    let mut names: Vec<String> =
        findings.iter().map(|it| format!("{}::{}", text(&it["source"]), text(&it["code"]))).collect();
    names.sort();
    names
}

/// The text after a quick fix, which is about that file only.
#[track_caller]
fn fixed(text: &str, action: &Value, file: &Path) -> String {
    let changes = action["edit"]["changes"].as_object().expect("it changes something");
    assert_eq!(changes.keys().collect::<Vec<_>>(), [&uri(file)]);
    applied(text, &changes[&uri(file)])
}

fn number_of_line(text: &str, part: &str) -> u64 {
    text.lines().position(|line| line.contains(part)).expect("there is such a line") as u64
}

#[test]
#[ignore = "needs rust-analyzer"]
fn findings_come_with_their_path_and_go_with_their_fix() {
    let mut editor = Editor::with("ra_fix", &json!({ "check": { "command": "ceid-lint" } }));
    let file = editor.open(FIXED_BY_HAND);
    let found = editor.found(&file, &["ceid::repeated_update"]);
    let text = fixture(FIXED_BY_HAND, "rs");
    let (head, place) = (number_of_line(&text, "    loop {"), number_of_line(&text, "kf.update(z); // and once more"));
    assert_eq!(found[0]["range"]["start"], json!({ "line": place, "character": 8 }));
    assert_eq!(found[0]["severity"], 1);
    let steps = found[0]["relatedInformation"].as_array().expect("there is a path");
    let lines: Vec<u64> = steps.iter().filter_map(|step| step["location"]["range"]["start"]["line"].as_u64()).collect();
    for (number, step) in (1..).zip(&steps[..3]) {
        let message = step["message"].as_str().expect("it is a text");
        assert!(message.starts_with(&format!("step {number}: ")), "{steps:#?}");
    }
    assert_eq!(lines[..3], [head, number_of_line(&text, "// once"), place]);

    // The same fix is offered at the finding and at the head of the cycle, and nowhere else.
    let fix = editor.fix_at(&file, place, 12);
    assert_eq!(fix["isPreferred"], false);
    assert_eq!(editor.fix_at(&file, head, 6), fix);
    let after = fixed(&text, &fix, &file);
    assert_eq!(after, fixture(FIXED_BY_HAND, "fixed"));
    editor.save(&file, &after);
    editor.found(&file, &[]);

    // What is typed anew is found as soon as it is saved, and the other file was never touched.
    editor.save(&file, &text);
    editor.found(&file, &["ceid::repeated_update"]);
    let other = editor.file(FIXED_AT_ONCE);
    editor.found(&other, &["ceid::guard_dropped_early"]);
}

#[test]
#[ignore = "needs rust-analyzer"]
fn fix_that_is_sure_is_preferred() {
    // One package is checked when one of its files is saved, and none before.
    let settings = json!({ "check": { "command": "ceid-lint", "workspace": false } });
    let mut editor = Editor::with("ra_preferred", &settings);
    let file = editor.open(FIXED_AT_ONCE);
    let text = fixture(FIXED_AT_ONCE, "rs");
    // What is saved before the workspace is loaded is checked by nobody.
    editor.client.shown(&file, |_| true);
    editor.save(&file, &text);
    let found = editor.found(&file, &["ceid::guard_dropped_early"]);
    let place = found[0]["range"]["start"]["line"].as_u64().expect("it has a line");
    let fix = editor.fix_at(&file, place, found[0]["range"]["start"]["character"].as_u64().expect("and a column"));
    assert_eq!(fix["isPreferred"], true);
    assert_eq!(editor.fix_at(&file, number_of_line(&text, "    loop {"), 6), fix);
    let after = fixed(&text, &fix, &file);
    assert_eq!(after, fixture(FIXED_AT_ONCE, "fixed"));
    editor.save(&file, &after);
    editor.found(&file, &[]);
    let other = editor.file(FIXED_BY_HAND);
    editor.found(&other, &["ceid::repeated_update"]);
}

#[test]
#[ignore = "needs rust-analyzer"]
fn findings_of_clippy_and_the_compiler_are_shown_beside() {
    let settings = json!({ "check": { "command": "ceid-lint", "extraArgs": ["--with", "clippy"] } });
    let mut editor = Editor::with("ra_clippy", &settings);
    let file = editor.open(FIXED_BY_HAND);
    editor.found(&file, &["ceid::repeated_update"]);
    let unused = "pub fn ready(a: bool) -> bool { let b = 1; if a == true { a } else { !a } }\n";
    let text = fixture(FIXED_BY_HAND, "rs");
    editor.save(&file, &format!("{text}{unused}"));
    editor.found(&file, &["ceid::repeated_update", "clippy::bool_comparison", "rustc::unused_variables"]);
    editor.save(&file, &format!("{}{unused}", fixture(FIXED_BY_HAND, "fixed")));
    editor.found(&file, &["clippy::bool_comparison", "rustc::unused_variables"]);
    editor.save(&file, &text);
    editor.found(&file, &["ceid::repeated_update"]);
    // What does not compile is still looked at.
    editor.save(&file, &format!("{text}pub fn wrong() -> bool {{ 1 }}\n"));
    let shown = editor.client.shown(&file, |shown| names(&findings(shown)).iter().any(|name| name == "rustc::E0308"));
    assert!(names(&findings(&shown)).iter().any(|name| name == "ceid::repeated_update"), "{shown:#?}");
}
