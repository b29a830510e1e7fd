//! What is told of a file: unasked and asked for, where it is, and when it is taken back.

use serde_json::{Value, json};

use super::client::{Client, plain, uri};
use super::{codes, guilty, innocent, of_document, places};
use crate::support::program::run;
use crate::support::workspace::{GUILTY, committed, temporary_package, write};

#[test]
fn findings_follow_the_text() {
    let (folder, file) = guilty("lsp_follow");
    let mut client = Client::in_folder(&folder, &plain());
    // The folder is checked, whatever is open.
    let told = client.published(&file);
    assert!(told.get("version").is_none(), "{told}");
    assert_eq!(places(&told["diagnostics"]), [[6, 8, 19]]);

    client.open(&file, GUILTY);
    assert_eq!(places(&client.published_of(&file, 1)), [[6, 8, 19]]);
    client.replace(&file, 2, &innocent());
    assert_eq!(client.published_of(&file, 2), json!([]));
    client.replace(&file, 3, &format!("\n{GUILTY}"));
    assert_eq!(places(&client.published_of(&file, 3)), [[7, 8, 19]]);
    // What was not saved is gone.
    client.close(&file);
    assert_eq!(places(&client.published(&file)["diagnostics"]), [[6, 8, 19]]);
    // What is on the disk is another text.
    write(&folder, "src/lib.rs", innocent().as_bytes());
    client.watched(&file, 2);
    assert_eq!(client.published(&file)["diagnostics"], json!([]));
}

#[test]
fn finding_has_all_that_editors_show() {
    let (folder, file) = guilty("lsp_fields");
    let mut client = Client::in_folder(&folder, &plain());
    let told = client.published(&file);
    let finding = &told["diagnostics"][0];
    assert_eq!(
        [&finding["severity"], &finding["code"], &finding["source"]],
        [&json!(1), &json!("ceid::repeated_update"), &json!("ceid-lint")]
    );
    let message = finding["message"].as_str().expect("it is a text");
    assert!(message.starts_with("`kf` is updated more than once in one cycle\nnote: "), "{message}");
    assert_eq!(
        finding["data"],
        json!({ "rule": "repeated_update", "verdict": "repeated", "counts": [2], "filters": ["kf"], "type": "Kalman" })
    );
    let related = finding["relatedInformation"].as_array().expect("it is a list");
    let steps: Vec<(u64, &str)> = related
        .iter()
        .map(|step| {
            let line = step["location"]["range"]["start"]["line"].as_u64().expect("it is a number");
            assert_eq!(step["location"]["uri"], uri(&file));
            (line, step["message"].as_str().expect("it is a text"))
        })
        .collect();
    assert!(steps.windows(2).all(|pair| pair[0].0 <= pair[1].0), "{steps:?}");
    assert!(steps.iter().any(|(line, text)| *line == 5 && text.starts_with("step ")), "{steps:?}");
}

#[test]
fn client_without_further_places_reads_the_steps() {
    let (folder, file) = guilty("lsp_steps");
    let mut client = Client::in_folder(&folder, &json!({}));
    let told = client.published(&file);
    let message = told["diagnostics"][0]["message"].as_str().expect("it is a text");
    assert!(message.contains("\nstep ") && message.contains("(lib.rs:6)"), "{message}");
    assert!(told["diagnostics"][0].get("relatedInformation").is_none());
}

#[test]
fn asked_and_unasked_are_alike() {
    let (folder, file) = guilty("lsp_pull");
    let mut client = Client::in_folder(&folder, &plain());
    let told = client.published(&file);
    client.open(&file, GUILTY);
    assert_eq!(json!(client.pull(&file)), told["diagnostics"]);

    let report = client.request("textDocument/diagnostic", &of_document(&file));
    let mut params = of_document(&file);
    params["previousResultId"] = report["resultId"].clone();
    let again = client.request("textDocument/diagnostic", &params);
    assert_eq!(again, json!({ "kind": "unchanged", "resultId": report["resultId"] }));
    // The answer is about the text that was sent before the question.
    client.replace(&file, 2, &innocent());
    let now = client.request("textDocument/diagnostic", &params);
    assert_eq!((&now["kind"], &now["items"]), (&json!("full"), &json!([])));
}

#[test]
fn client_that_asks_is_not_told_twice() {
    let (folder, file) = guilty("lsp_pulls");
    write(&folder, "src/other.rs", GUILTY.as_bytes());
    let text = format!("mod other;\n{GUILTY}");
    let capabilities = json!({ "textDocument": { "diagnostic": {} },
        "workspace": { "diagnostics": { "refreshSupport": true } } });
    let mut client = Client::in_folder(&folder, &capabilities);
    client.open(&file, &text);
    assert_eq!(codes(&client.pull(&file)), ["ceid::repeated_update"]);

    let report = client.request("workspace/diagnostic", &json!({ "previousResultIds": [] }));
    super::client::check_type::<lsp_types::WorkspaceDiagnosticReport>(&report);
    let items = report["items"].as_array().expect("it is a list");
    assert_eq!(items.len(), 2, "{report}");
    let previous: Vec<Value> =
        items.iter().map(|item| json!({ "uri": item["uri"], "value": item["resultId"] })).collect();
    assert_eq!(client.standing(), 0);

    // Another file has changed: the client has to ask again.
    let other = folder.join("src/other.rs");
    write(&folder, "src/other.rs", innocent().as_bytes());
    client.watched(&other, 2);
    client.told("workspace/diagnostic/refresh", |_| true);
    let report = client.request("workspace/diagnostic", &json!({ "previousResultIds": previous }));
    let kinds: Vec<(&Value, usize)> = report["items"]
        .as_array()
        .expect("it is a list")
        .iter()
        .map(|item| (&item["kind"], item["items"].as_array().map_or(0, Vec::len)))
        .collect();
    assert!(kinds.contains(&(&json!("full"), 0)) && kinds.contains(&(&json!("unchanged"), 0)), "{report}");
}

#[track_caller]
fn check_encoding(name: &str, offered: &Value, expected: &str, columns: [u64; 2]) {
    let text = GUILTY.replacen("        kf.update();\n        kf", "        kf.update(); /* é𝛼 */ kf", 1);
    let folder = temporary_package(name, &[("src/lib.rs", text.as_bytes())]);
    let file = folder.join("src/lib.rs");
    let mut client = Client::start();
    let params = json!({ "rootUri": uri(&folder), "capabilities": { "general": { "positionEncodings": offered } } });
    let result = client.request("initialize", &params);
    assert_eq!(result["capabilities"]["positionEncoding"], expected);
    client.notify("initialized", &json!({}));
    assert_eq!(places(&client.published(&file)["diagnostics"]), [[5, columns[0], columns[1]]]);
    // Changes are counted alike: the second update goes.
    client.open(&file, &text);
    let change = json!([{ "range": { "start": { "line": 5, "character": columns[0] },
        "end": { "line": 5, "character": columns[1] } }, "text": "()" }]);
    client.change(&file, 2, &change);
    assert_eq!(client.published_of(&file, 2), json!([]));
}

#[test]
fn columns_are_counted_as_agreed() {
    check_encoding("lsp_utf16", &json!(["utf-16"]), "utf-16", [31, 42]);
    check_encoding("lsp_utf8", &json!(["utf-8", "utf-16"]), "utf-8", [34, 45]);
    check_encoding("lsp_utf32", &json!(["utf-32", "utf-16"]), "utf-32", [30, 41]);
}

#[test]
fn server_finds_what_the_command_line_finds() {
    for name in ["figure3_legacy", "two_crates", "path_modules"] {
        let folder = committed(name);
        let findings = run(&folder, ["--workspace", "--message-format", "json"]).findings().expect("it can be read");
        let mut expected: Vec<(String, usize, String)> = findings
            .into_iter()
            .map(|finding| (uri(&folder.join(finding.file)), finding.line, format!("ceid::{}", finding.rule)))
            .collect();
        let mut client = Client::in_folder(&folder, &plain());
        let report = client.request("workspace/diagnostic", &json!({ "previousResultIds": [] }));
        let mut found = Vec::new();
        for item in report["items"].as_array().expect("it is a list") {
            for finding in item["items"].as_array().expect("it is a list") {
                let line = finding["range"]["start"]["line"].as_u64().expect("it is a number") as usize + 1;
                let text = |value: &Value| value.as_str().unwrap_or_default().to_owned();
                found.push((text(&item["uri"]), line, text(&finding["code"])));
            }
        }
        expected.sort();
        found.sort();
        assert_eq!(found, expected, "{name}");
        assert!(!found.is_empty(), "{name}");
    }
}

#[test]
fn text_that_cannot_be_read_is_told() {
    let (folder, file) = guilty("lsp_syntax");
    let mut client = Client::in_folder(&folder, &plain());
    client.open(&file, "pub fn run( {\n");
    let found = client.pull(&file);
    assert_eq!(codes(&found), ["none"]);
    assert_eq!(found[0]["severity"], 1);
    client.replace(&file, 2, GUILTY);
    assert_eq!(codes(&client.pull(&file)), ["ceid::repeated_update"]);
}

#[test]
fn helper_in_another_file_decides() {
    let lib = format!(
        "mod helper;\n{}",
        GUILTY.replacen(
            "        kf.update();\n        kf.update();",
            "        kf.update();\n        helper::also(&mut kf);",
            1
        )
    );
    let files = [("src/lib.rs", lib.as_bytes()), ("src/helper.rs", b"".as_slice())];
    let folder = temporary_package("lsp_helper", &files);
    let (file, helper) = (folder.join("src/lib.rs"), folder.join("src/helper.rs"));
    let mut client = Client::in_folder(&folder, &plain());
    client.open(&file, &lib);
    let text = |body: &str| format!("pub fn also(kf: &mut crate::Kalman) {{ use crate::SampledFilter; {body} }}\n");
    client.open(&helper, &text(""));
    client.published_of(&helper, 1);
    client.replace(&helper, 2, &text("kf.update()"));
    // The finding is in the file that was not edited, and a step of its path in the other.
    let uri_of_file = uri(&file);
    let is_it = |params: &Value| params["uri"] == uri_of_file && params["diagnostics"][0].is_object();
    let told = client.told("textDocument/publishDiagnostics", is_it);
    assert_eq!(codes(told["diagnostics"].as_array().expect("it is a list")), ["ceid::repeated_update"]);
    client.replace(&helper, 3, &text(""));
    assert_eq!(client.published(&file)["diagnostics"], json!([]));
}

#[test]
fn client_that_asks_for_open_files_only_is_told_of_the_others() {
    let files: &[(&str, &[u8])] = &[("src/lib.rs", b"mod a;\n"), ("src/a.rs", GUILTY.as_bytes())];
    let folder = temporary_package("lsp_open_files_only", files);
    let file = folder.join("src/a.rs");
    let mut client = Client::in_folder(&folder, &json!({ "textDocument": { "diagnostic": {} } }));
    assert_eq!(places(&client.published(&file)["diagnostics"]), [[6, 8, 19]]);
    client.open(&file, GUILTY);
    assert_eq!(client.published(&file)["diagnostics"], json!([]), "it is shown twice");
    assert_eq!(codes(&client.pull(&file)), ["ceid::repeated_update"]);
    client.replace(&file, 2, &GUILTY.replacen("loop", "loop  ", 1));
    assert_eq!(codes(&client.pull(&file)), ["ceid::repeated_update"]);
    // It goes on showing what it has asked for.
    client.close(&file);
    assert_eq!(codes(&client.pull(&file)), ["ceid::repeated_update"]);
    assert_eq!(client.left_over("textDocument/publishDiagnostics"), 0);
}

#[test]
fn what_was_told_is_taken_back_when_the_client_asks_for_all_files() {
    let (folder, file) = guilty("lsp_all_files_later");
    let mut client = Client::in_folder(&folder, &json!({ "textDocument": { "diagnostic": {} } }));
    assert_eq!(places(&client.published(&file)["diagnostics"]), [[6, 8, 19]]);
    let report = client.request("workspace/diagnostic", &json!({ "previousResultIds": [] }));
    assert_eq!(report["items"].as_array().map(Vec::len), Some(1), "{report}");
    assert_eq!(client.published(&file)["diagnostics"], json!([]), "it is shown twice");
}

#[test]
fn client_that_asks_for_all_files_is_told_of_none() {
    let (folder, file) = guilty("lsp_all_files");
    let mut client = Client::in_folder(&folder, &json!({ "textDocument": { "diagnostic": {} } }));
    let report = client.request("workspace/diagnostic", &json!({ "previousResultIds": [] }));
    assert_eq!(report["items"].as_array().map(Vec::len), Some(1), "{report}");
    client.open(&file, GUILTY);
    assert_eq!(codes(&client.pull(&file)), ["ceid::repeated_update"]);
    assert_eq!(client.standing(), 0);
}
