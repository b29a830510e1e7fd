//! What can be asked at a place: what is known of it, what can be done about it, and what is proved.

use std::path::Path;

use serde_json::{Value, json};

use super::client::{Client, applied, check_type, plain, uri};
use super::{codes, guilty, innocent};
use crate::support::root;
use crate::support::workspace::{GUILTY, temporary, write};

/// An open file with this text, outside any package.
fn opened(name: &str, text: &str) -> (Client, std::path::PathBuf) {
    let folder = temporary(name);
    write(&folder, "case.rs", text.as_bytes());
    let file = folder.join("case.rs");
    let mut client = Client::with_options(&[], &plain(), &Value::Null);
    client.open(&file, text);
    (client, file)
}

/// The only action with such a title.
#[track_caller]
fn titled<'a>(actions: &'a [Value], title: &str) -> &'a Value {
    let mut found = actions.iter().filter(|action| action["title"].as_str().is_some_and(|text| text.contains(title)));
    let (Some(action), None) = (found.next(), found.next()) else { panic!("not one `{title}`: {actions:#?}") };
    action
}

/// Does what an action says with the only file that it is about.
#[track_caller]
fn done(text: &str, action: &Value, file: &Path) -> String {
    let changes = action["edit"]["changes"].as_object().expect("it changes something");
    assert_eq!(changes.keys().collect::<Vec<_>>(), [&uri(file)]);
    applied(text, &changes[&uri(file)])
}

#[test]
fn suppression_is_written_above_the_finding() {
    for text in [GUILTY.to_owned(), GUILTY.replace('\n', "\r\n"), GUILTY.replace("        ", "\t\t")] {
        let (mut client, file) = opened("lsp_suppress", &text);
        let found = client.pull(&file);
        let actions = client.actions(&file, &found[0]["range"], &found);
        let action = titled(&actions, "suppress `ceid::repeated_update`");
        assert_eq!((&action["kind"], &action["diagnostics"]), (&json!("quickfix"), &json!(found)));
        let after = done(&text, action, &file);
        let line = after.lines().nth(6).expect("it is longer than before");
        assert!(line.trim_start().starts_with("// ceid: allow(repeated_update, reason = \""), "{after}");
        let indentation = |line: &str| line.len() - line.trim_start().len();
        assert_eq!(indentation(line), indentation(after.lines().nth(7).expect("the finding follows")));
        assert_eq!(after.matches('\r').count(), if text.contains('\r') { after.lines().count() } else { 0 });
        client.replace(&file, 2, &after);
        assert_eq!(client.pull(&file), Vec::<Value>::new());
    }
}

#[test]
fn suppression_of_a_crowded_line_stands_above_the_cycle() {
    let text = GUILTY.replacen("        kf.update();\n        kf.update();", "        kf.update(); kf.update();", 1);
    let (mut client, file) = opened("lsp_crowded", &text);
    let found = client.pull(&file);
    let after = done(&text, titled(&client.actions(&file, &found[0]["range"], &[]), "suppress"), &file);
    assert!(after.lines().nth(4).is_some_and(|line| line.starts_with("    // ceid: allow(")), "{after}");
    client.replace(&file, 2, &after);
    assert_eq!(client.pull(&file), Vec::<Value>::new());
}

#[test]
fn suppression_stands_where_it_hides_the_finding() {
    // The end of a block is no code, and what is also found elsewhere is found there next.
    for name in ["guard_dropped_early/inner_block_ends_too_soon", "skipped_update/restart_overrides_the_state"] {
        let path = root().join("fixtures/rules").join(name).with_extension("rs");
        let text = std::fs::read_to_string(path).expect("it is there");
        let (mut client, file) = opened("lsp_hides", &text);
        let found = client.pull(&file);
        let after = done(&text, titled(&client.actions(&file, &found[0]["range"], &[]), "suppress"), &file);
        client.replace(&file, 2, &after);
        assert_eq!(client.pull(&file), Vec::<Value>::new(), "{after}");
    }
}

#[test]
fn suggestions_are_done() {
    let text = format!("// ceid: allow(skipped_update, reason = \"old\")\n{}", innocent());
    let (mut client, file) = opened("lsp_suggestion", &text);
    let found = client.pull(&file);
    assert_eq!(codes(&found), ["ceid::unused_suppression"]);
    let actions = client.actions(&file, &found[0]["range"], &found);
    let action = titled(&actions, "remove the suppression");
    assert_eq!(action["isPreferred"], true);
    let after = done(&text, action, &file);
    assert_eq!(after, innocent());
    client.replace(&file, 2, &after);
    assert_eq!(client.pull(&file), Vec::<Value>::new());
}

#[test]
fn actions_are_offered_on_the_lines_of_the_finding_and_of_its_cycle() {
    let (mut client, file) = opened("lsp_lines", GUILTY);
    let range =
        |line: u32| json!({ "start": { "line": line, "character": 0 }, "end": { "line": line, "character": 0 } });
    let lines: Vec<u32> = (0..9).filter(|line| !client.actions(&file, &range(*line), &[]).is_empty()).collect();
    assert_eq!(lines, [4, 6]);
    let params = json!({ "textDocument": { "uri": uri(&file) }, "range": range(6),
        "context": { "diagnostics": [], "only": ["source.organizeImports"] } });
    assert_eq!(client.request("textDocument/codeAction", &params), json!([]));
}

#[test]
fn changes_carry_the_version_where_the_client_takes_it() {
    let (folder, file) = guilty("lsp_versions");
    let mut capabilities = plain();
    capabilities["workspace"] = json!({ "workspaceEdit": { "documentChanges": true } });
    let mut client = Client::in_folder(&folder, &capabilities);
    client.open(&file, GUILTY);
    client.replace(&file, 5, GUILTY);
    let found = client.pull(&file);
    let actions = client.actions(&file, &found[0]["range"], &[]);
    let change = &titled(&actions, "suppress")["edit"]["documentChanges"][0];
    assert_eq!(change["textDocument"], json!({ "uri": uri(&file), "version": 5 }));
}

#[test]
fn rule_is_explained() {
    let (folder, file) = guilty("lsp_explain");
    let mut client = Client::in_folder(&folder, &json!({ "window": { "showDocument": { "support": true } } }));
    let found = client.pull(&file);
    // A client that takes commands only gets one.
    let actions = client.actions(&file, &found[0]["range"], &[]);
    let [command] = actions.as_slice() else { panic!("not one command: {actions:?}") };
    assert_eq!(command["command"], "ceid-lint.explain");
    let params = json!({ "command": command["command"], "arguments": command["arguments"] });
    let text = client.request("workspace/executeCommand", &params);
    assert!(text.as_str().is_some_and(|text| text.contains("repeated_update")), "{text}");
    let shown = client.told("window/showDocument", |_| true);
    let page = shown["uri"].as_str().and_then(|uri| uri.strip_prefix("file://")).expect("it is a file").to_owned();
    assert_eq!(std::fs::read_to_string(&page).ok().as_deref(), text.as_str());
    assert_eq!(client.refused("workspace/executeCommand", &json!({ "command": "format" })), -32602);
    let wrong = json!({ "command": "ceid-lint.explain", "arguments": ["repeated_updat"] });
    assert_eq!(client.refused("workspace/executeCommand", &wrong), -32602);
    client.leave();
    assert!(!Path::new(&page).exists());
}

#[test]
fn rule_is_explained_where_no_file_can_be_shown() {
    let (mut client, _) = opened("lsp_explain_message", GUILTY);
    client.request(
        "workspace/executeCommand",
        &json!({ "command": "ceid-lint.explain", "arguments": ["ceid::missed_update"] }),
    );
    let told = client.told("window/showMessage", |_| true);
    assert!(told["message"].as_str().is_some_and(|text| text.contains("missed_update")), "{told}");
}

#[test]
fn hover_tells_the_verdict_and_the_rule() {
    let text = GUILTY.replacen(
        "pub fn run",
        "// ceid: allow(missed_update)\npub fn other(mut pf: Kalman) { loop { pf.update() } }\npub fn run",
        1,
    );
    let (mut client, file) = opened("lsp_hover", &text);
    let mut value = |line, character| {
        let hover = client.hover(&file, line, character);
        hover["contents"]["value"].as_str().unwrap_or_default().to_owned()
    };
    let finding = value(8, 12);
    assert!(finding.starts_with("**`ceid::repeated_update`**: `kf` is updated more than once"), "{finding}");
    assert!(finding.contains("# `ceid::repeated_update`"), "{finding}");
    let cycle = value(6, 5);
    assert!(cycle.contains("`kf` (`Kalman`): **repeated**, many updates"), "{cycle}");
    let proved = value(4, 33);
    assert!(proved.contains("`pf` (`Kalman`): **once**, updated exactly once on every path"), "{proved}");
    assert!(!proved.contains("unguarded_update"), "what is allowed is no news: {proved}");
    let update = value(4, 42);
    assert!(update.contains("**once**") && update.contains("`loop` of `other`"), "{update}");
    let comment = value(3, 20);
    assert!(comment.contains("# `ceid::missed_update`"), "{comment}");
    assert_eq!(value(0, 3), "");
    assert_eq!(client.hover(&file, 9999, 9999), Value::Null);
    assert_eq!(client.hover(Path::new("/nowhere/else.rs"), 0, 0), Value::Null);
}

#[test]
fn hints_tell_what_is_proved() {
    let (folder, file) = guilty("lsp_hints");
    let range = json!({ "start": { "line": 0, "character": 0 }, "end": { "line": 99, "character": 0 } });
    let params = json!({ "textDocument": { "uri": uri(&file) }, "range": range });
    let mut client = Client::in_folder(&folder, &plain());
    client.open(&file, &innocent());
    assert_eq!(client.request("textDocument/inlayHint", &params), json!([]));

    let mut capabilities = plain();
    capabilities["workspace"] = json!({ "inlayHint": { "refreshSupport": true } });
    let mut client = Client::with_options(&[&folder], &capabilities, &json!({ "inlayHints": true }));
    client.open(&file, &innocent());
    let hints = client.request("textDocument/inlayHint", &params);
    check_type::<Vec<lsp_types::InlayHint>>(&hints);
    let expected = json!([{ "position": { "line": 4, "character": 10 }, "label": "proved: kf once per cycle",
        "paddingLeft": true }]);
    assert_eq!(hints, expected);
    client.replace(&file, 2, GUILTY);
    assert_eq!(client.request("textDocument/inlayHint", &params), json!([]));
    client.told("workspace/inlayHint/refresh", |_| true);
}

#[test]
fn a_loop_is_handed_to_a_guard() {
    let core = root().join("ceid-core");
    let text = GUILTY.replacen("        kf.update();\n        kf.update();", "        kf.update();", 1);
    let manifest = format!(
        "[workspace]\n\n[package]\nname = \"guarded\"\nversion = \"0.0.0\"\nedition = \"2024\"\n\n[dependencies]\n\
         ceid-core = {{ path = {core:?} }}\n"
    );
    let directory = temporary("lsp_migrate");
    write(&directory, "src/lib.rs", text.as_bytes());
    write(&directory, "Cargo.toml", manifest.as_bytes());
    let file = directory.join("src/lib.rs");
    let mut client = Client::in_folder(&directory, &plain());
    client.open(&file, &text);
    assert_eq!(client.pull(&file), Vec::<Value>::new());
    let at = |line: u32| json!({ "start": { "line": line, "character": 4 }, "end": { "line": line, "character": 4 } });
    assert_eq!(client.actions(&file, &at(1), &[]), Vec::<Value>::new());
    let actions = client.actions(&file, &at(4), &[]);
    let action = titled(&actions, "let a guard update `kf`");
    assert_eq!(action["kind"], "refactor.rewrite");
    let after = done(&text, action, &file);
    assert!(after.contains("        ceid_core::ceid!(clock.begin_cycle() => kf);\n    }\n"), "{after}");
    client.replace(&file, 2, &after);
    assert_eq!(client.actions(&file, &at(9), &[]), Vec::<Value>::new());
}

#[test]
fn a_loop_is_handed_to_a_guard_in_a_package_that_knows_none_yet() {
    let text = GUILTY.replacen("        kf.update();\n        kf.update();", "        kf.update();", 1);
    let manifest = "[workspace]\n\n[package]\nname = \"unguarded\"\nversion = \"0.0.0\"\nedition = \"2024\"\n";
    let directory = temporary("lsp_migrate_dependency");
    write(&directory, "src/lib.rs", text.as_bytes());
    write(&directory, "Cargo.toml", manifest.as_bytes());
    let file = directory.join("src/lib.rs");
    let mut client = Client::in_folder(&directory, &plain());
    client.open(&file, &text);
    assert_eq!(client.pull(&file), Vec::<Value>::new());
    let at = json!({ "start": { "line": 4, "character": 4 }, "end": { "line": 4, "character": 4 } });
    let actions = client.actions(&file, &at, &[]);
    let action = titled(&actions, "let a guard update `kf`, with `ceid-core` as a dependency");
    let changed = |text: &str, file: &Path| applied(text, &action["edit"]["changes"][&uri(file)]);
    assert!(changed(&text, &file).contains("        ceid_core::ceid!(clock.begin_cycle() => kf);\n    }\n"));
    let after = changed(manifest, &directory.join("Cargo.toml"));
    assert_eq!(after, format!("{manifest}\n[dependencies]\nceid-core = \"0.1.0\"\n"));
}

#[test]
fn those_filters_of_a_loop_go_that_can() {
    let core = root().join("ceid-core");
    let text = "\
pub trait SampledFilter { fn update(&mut self); }
pub struct Lag(pub f64);
impl SampledFilter for Lag { fn update(&mut self) { self.0 *= 0.5; } }
pub fn run(one: &mut Lag, other: &mut Lag) {
    for _ in 0..9 {
        one.update();
        other.update();
        println!(\"{}\", other.0);
    }
}
";
    let manifest = format!(
        "[workspace]\n\n[package]\nname = \"guarded\"\nversion = \"0.0.0\"\nedition = \"2024\"\n\n[dependencies]\n\
         ceid-core = {{ path = {core:?} }}\n"
    );
    let directory = temporary("lsp_migrate_partly");
    write(&directory, "src/lib.rs", text.as_bytes());
    write(&directory, "Cargo.toml", manifest.as_bytes());
    let file = directory.join("src/lib.rs");
    let mut client = Client::in_folder(&directory, &plain());
    client.open(&file, text);
    assert_eq!(client.pull(&file), Vec::<Value>::new());
    let at = json!({ "start": { "line": 4, "character": 4 }, "end": { "line": 4, "character": 4 } });
    let actions = client.actions(&file, &at, &[]);
    let all = "let a guard update `one`, `other`, which changes what the program does";
    assert_eq!(titled(&actions, all)["kind"], "refactor.rewrite");
    let action = titled(&actions, "let a guard update `one`; `other` stays by hand");
    assert_eq!(actions[0]["title"], action["title"], "what changes nothing comes first");
    let after = done(text, action, &file);
    assert!(after.contains("begin_cycle() => one);\n        other.update();\n"), "{after}");
}
