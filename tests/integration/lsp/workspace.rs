//! Folders, files that come and go, manifests and settings.

use std::fs;

use serde_json::{Value, json};

use super::client::{Client, plain, uri};
use super::{codes, guilty, innocent, places};
use crate::support::workspace::{GUILTY, temporary, temporary_package, write};

#[test]
fn deleted_file_takes_its_findings_with_it() {
    let folder = temporary_package("lsp_deleted", &[("src/lib.rs", b"mod a;\n"), ("src/a.rs", GUILTY.as_bytes())]);
    let (lib, file) = (folder.join("src/lib.rs"), folder.join("src/a.rs"));
    let mut client = Client::in_folder(&folder, &plain());
    assert_eq!(places(&client.published(&file)["diagnostics"]), [[6, 8, 19]]);
    fs::remove_file(&file).expect("it is there");
    client.watched(&file, 3);
    assert_eq!(client.published(&file)["diagnostics"], json!([]));
    // The declaration is left behind.
    assert_eq!(client.published(&lib)["diagnostics"][0]["severity"], 1);
    write(&folder, "src/lib.rs", b"");
    client.watched(&lib, 2);
    assert_eq!(client.published(&lib)["diagnostics"], json!([]));
}

#[test]
fn new_target_is_found() {
    let (folder, _) = guilty("lsp_new_target");
    let mut client = Client::in_folder(&folder, &plain());
    let program = folder.join("src/bin/more.rs");
    write(&folder, "src/bin/more.rs", format!("{GUILTY}\nfn main() {{}}\n").as_bytes());
    client.watched(&program, 1);
    assert_eq!(codes(&client.pull(&program)), ["ceid::repeated_update"]);
}

#[test]
fn configuration_is_read_again() {
    let (folder, file) = guilty("lsp_configuration");
    let config = folder.join("ceid-lint.toml");
    let mut client = Client::in_folder(&folder, &plain());
    assert_eq!(client.published(&file)["diagnostics"][0]["severity"], 1);

    write(&folder, "ceid-lint.toml", b"[lints]\nrepeated_update = \"warn\"\n");
    client.watched(&config, 1);
    assert_eq!(client.published(&file)["diagnostics"][0]["severity"], 2);
    // A mistake is shown where it is made, and corrected.
    write(&folder, "ceid-lint.toml", b"[lints]\nrepeated_updat = \"warn\"\n");
    client.watched(&config, 2);
    let told = client.published(&config);
    assert_eq!(places(&told["diagnostics"]), [[1, 0, 14]]);
    let message = told["diagnostics"][0]["message"].as_str().expect("it is a text");
    assert!(message.contains("`repeated_updat`") && message.contains("repeated_update"), "{message}");

    fs::remove_file(&config).expect("it is there");
    client.watched(&config, 3);
    assert_eq!(client.published(&config)["diagnostics"], json!([]));
    assert_eq!(codes(&client.pull(&file)), ["ceid::repeated_update"]);
}

#[test]
fn configuration_above_the_folder_is_seen_with_the_next_key() {
    let manifest = "[package]\nname = \"member\"\nversion = \"0.0.0\"\nedition = \"2024\"\n";
    let root = temporary("lsp_member");
    write(&root, "Cargo.toml", b"[workspace]\nmembers = [\"member\"]\nresolver = \"3\"\n");
    write(&root, "member/Cargo.toml", manifest.as_bytes());
    write(&root, "member/src/lib.rs", GUILTY.as_bytes());
    let (folder, file) = (root.join("member"), root.join("member/src/lib.rs"));
    // It tells of files that change below the folder, and of no others.
    let watching = json!({ "textDocument": { "publishDiagnostics": { "versionSupport": true } },
        "workspace": { "didChangeWatchedFiles": { "dynamicRegistration": true } } });
    let mut client = Client::in_folder(&folder, &watching);
    client.open(&file, GUILTY);
    assert_eq!(client.published_of(&file, 1)[0]["severity"], 1);
    write(&root, "ceid-lint.toml", b"[lints]\nrepeated_update = \"warn\"\n");
    client.replace(&file, 2, &format!("{GUILTY}\n"));
    assert_eq!(client.published_of(&file, 2)[0]["severity"], 2);
}

#[test]
fn client_that_asks_is_told_of_the_configuration() {
    let (folder, file) = guilty("lsp_pulled_configuration");
    write(&folder, "ceid-lint.toml", b"lint = 1\n");
    let mut client = Client::in_folder(&folder, &json!({ "textDocument": { "diagnostic": {} } }));
    assert_eq!(places(&client.published(&folder.join("ceid-lint.toml"))["diagnostics"]).len(), 1);
    assert_eq!(client.pull(&file), Vec::<Value>::new());
}

#[test]
fn wrong_manifest_is_told_and_corrected() {
    let (folder, file) = guilty("lsp_manifest");
    let manifest = folder.join("Cargo.toml");
    let right = fs::read(&manifest).expect("it is there");
    let mut client = Client::in_folder(&folder, &plain());
    client.published(&file);
    write(&folder, "Cargo.toml", b"[package\n");
    client.watched(&manifest, 2);
    assert_eq!(client.published(&manifest)["diagnostics"][0]["severity"], 1);
    write(&folder, "Cargo.toml", &right);
    // A client that cannot watch files tells when something is saved.
    client.notify("textDocument/didSave", &super::of_document(&manifest));
    assert_eq!(client.published(&manifest)["diagnostics"], json!([]));
    assert_eq!(codes(&client.pull(&file)), ["ceid::repeated_update"]);
}

#[test]
fn folders_come_and_go() {
    let (first, first_file) = guilty("lsp_first_folder");
    let (second, second_file) = guilty("lsp_second_folder");
    let mut client = Client::with_options(&[&first], &plain(), &Value::Null);
    client.published(&first_file);
    let folder = |path| json!([{ "uri": uri(path), "name": "folder" }]);
    let change = |added: Value, removed: Value| json!({ "event": { "added": added, "removed": removed } });
    client.notify("workspace/didChangeWorkspaceFolders", &change(folder(&second), json!([])));
    assert_eq!(places(&client.published(&second_file)["diagnostics"]), [[6, 8, 19]]);
    client.notify("workspace/didChangeWorkspaceFolders", &change(json!([]), folder(&first)));
    assert_eq!(client.published(&first_file)["diagnostics"], json!([]));
    assert_eq!(codes(&client.pull(&second_file)), ["ceid::repeated_update"]);
}

#[test]
fn file_outside_any_package_is_checked_alone() {
    let folder = temporary("lsp_alone");
    let file = folder.join("alone é.rs");
    write(&folder, "alone é.rs", GUILTY.as_bytes());
    let mut client = Client::with_options(&[], &plain(), &Value::Null);
    client.open(&file, GUILTY);
    assert_eq!(places(&client.published_of(&file, 1)), [[6, 8, 19]]);
    client.replace(&file, 2, &innocent());
    assert_eq!(client.published_of(&file, 2), json!([]));
    client.replace(&file, 3, GUILTY);
    assert_eq!(places(&client.published_of(&file, 3)), [[6, 8, 19]]);
    client.close(&file);
    assert_eq!(client.published(&file)["diagnostics"], json!([]));
}

#[test]
fn file_of_a_package_outside_the_folders_is_checked_with_it() {
    let (folder, _) = guilty("lsp_inside");
    let other = temporary_package(
        "lsp_outside",
        &[("src/lib.rs", b"pub mod kalman;\npub mod run;\n"), ("src/run.rs", b""), ("src/kalman.rs", b"")],
    );
    let kalman = "pub trait SampledFilter { fn update(&mut self); }\npub struct Kalman;\n\
        impl SampledFilter for Kalman { fn update(&mut self) {} }\n";
    write(&other, "src/kalman.rs", kalman.as_bytes());
    let file = other.join("src/run.rs");
    let mut client = Client::in_folder(&folder, &plain());
    let text = "use crate::kalman::*;\npub fn run(mut kf: Kalman) {\n    loop {\n        kf.update();\n        kf.update();\n    }\n}\n";
    client.open(&file, text);
    assert_eq!(places(&client.published_of(&file, 1)), [[4, 8, 19]]);
}

#[test]
fn unsaved_module_is_read() {
    let (folder, file) = guilty("lsp_unsaved_module");
    let module = folder.join("src/fresh.rs");
    let mut client = Client::in_folder(&folder, &plain());
    client.open(&file, "mod fresh;\n");
    client.open(&module, GUILTY);
    assert_eq!(client.pull(&file), Vec::<Value>::new());
    assert_eq!(codes(&client.pull(&module)), ["ceid::repeated_update"]);
}

#[test]
fn files_are_watched_and_settings_asked_for() {
    let (folder, file) = guilty("lsp_registration");
    let capabilities = json!({ "workspace": { "didChangeWatchedFiles": { "dynamicRegistration": true },
        "didChangeConfiguration": { "dynamicRegistration": true }, "configuration": true } });
    let mut client = Client::in_folder(&folder, &capabilities);
    let told = client.told("client/registerCapability", |_| true);
    let methods: Vec<&Value> =
        told["registrations"].as_array().expect("it is a list").iter().map(|it| &it["method"]).collect();
    assert_eq!(methods, ["workspace/didChangeWatchedFiles", "workspace/didChangeConfiguration"]);
    client.told("workspace/configuration", |_| true);
    client.notify("workspace/didChangeConfiguration", &json!({ "settings": null }));
    client.told("workspace/configuration", |_| true);
    assert_eq!(codes(&client.pull(&file)), ["ceid::repeated_update"]);
}

#[test]
fn settings_of_the_editor_hold() {
    let manifest = b"[workspace]\n\n[package]\nname = \"lsp_settings\"\nversion = \"0.0.0\"\nedition = \"2024\"\n\n\
        [features]\nfast = []\n";
    let text =
        GUILTY.replacen("        kf.update();\n", "        #[cfg(feature = \"fast\")]\n        kf.update();\n", 1);
    let folder = temporary("lsp_settings");
    write(&folder, "Cargo.toml", manifest);
    write(&folder, "src/lib.rs", text.as_bytes());
    let file = folder.join("src/lib.rs");
    let mut client = Client::with_options(&[&folder], &plain(), &Value::Null);
    assert_eq!(client.pull(&file), Vec::<Value>::new());
    let settings = json!({ "settings": { "ceid-lint": { "features": ["fast"] } } });
    client.notify("workspace/didChangeConfiguration", &settings);
    assert_eq!(codes(&client.pull(&file)), ["ceid::repeated_update"]);
}

#[test]
fn options_of_the_beginning_hold_where_the_configuration_says_nothing() {
    let (folder, file) = guilty("lsp_says_nothing");
    let range = json!({ "start": { "line": 0, "character": 0 }, "end": { "line": 99, "character": 0 } });
    let params = json!({ "textDocument": { "uri": uri(&file) }, "range": range });
    let capabilities = json!({ "workspace": { "configuration": true, "inlayHint": { "refreshSupport": true } } });
    let mut client = Client::with_options(&[&folder], &capabilities, &json!({ "inlayHints": true }));
    client.told("workspace/configuration", |_| true);
    client.open(&file, &innocent());
    let mut hints = |section: Value| {
        client.section = section;
        client.notify("workspace/didChangeConfiguration", &json!({ "settings": null }));
        client.told("workspace/configuration", |_| true);
        let hints = client.request("textDocument/inlayHint", &params);
        hints.as_array().expect("it is a list").len()
    };
    // lsp-mode says `{}` of a section that it does not have.
    assert_eq!(hints(json!({})), 1);
    assert_eq!(hints(json!({ "inlayHints": false })), 0);
    assert_eq!(hints(Value::Null), 1);
    assert_eq!(hints(json!({ "inlayHints": false, "trace": { "server": "verbose" } })), 0);
}

#[test]
fn hints_go_when_they_are_switched_off() {
    let (folder, file) = guilty("lsp_hints_off");
    let capabilities = json!({ "workspace": { "inlayHint": { "refreshSupport": true } } });
    let mut client = Client::in_folder(&folder, &capabilities);
    client.open(&file, &innocent());
    for is_on in [true, false] {
        let settings = json!({ "settings": { "ceid-lint": { "inlayHints": is_on } } });
        client.notify("workspace/didChangeConfiguration", &settings);
        client.told("workspace/inlayHint/refresh", |_| true);
    }
}
