//! How a session begins and ends, and what is said to messages that are none.

use serde_json::{Value, json};

use super::client::{Client, frame, plain, uri};
use super::{codes, guilty, of_document};

const PARSE_ERROR: i64 = -32700;
const INVALID_REQUEST: i64 = -32600;
const METHOD_NOT_FOUND: i64 = -32601;
const INVALID_PARAMS: i64 = -32602;
const NOT_INITIALIZED: i64 = -32002;
const CANCELLED: i64 = -32800;

#[test]
fn session_ends_as_it_should() {
    let (folder, file) = guilty("lsp_ends");
    let mut client = Client::in_folder(&folder, &plain());
    client.published(&file);
    assert_eq!(client.leave(), Some(0));
}

#[test]
fn client_that_hangs_up_is_noticed() {
    assert_eq!(Client::start().hang_up(), Some(1));
    let (folder, _) = guilty("lsp_hang_up");
    assert_eq!(Client::in_folder(&folder, &plain()).hang_up(), Some(1));
    let mut client = Client::in_folder(&folder, &plain());
    client.notify("exit", &Value::Null);
    assert_eq!(client.exit_code(), Some(1));
}

#[test]
fn order_of_the_protocol_is_held() {
    let (folder, file) = guilty("lsp_order");
    let mut client = Client::start();
    assert_eq!(client.refused("textDocument/hover", &Value::Null), NOT_INITIALIZED);
    client.notify("textDocument/didSave", &of_document(&file));
    let params = json!({ "capabilities": {}, "rootUri": uri(&folder) });
    let result = client.request("initialize", &params);
    assert_eq!(result["capabilities"]["positionEncoding"], "utf-16");
    assert_eq!(result["serverInfo"]["name"], "ceid-lint");
    assert_eq!(client.refused("initialize", &params), INVALID_REQUEST);
    client.request("shutdown", &Value::Null);
    assert_eq!(client.refused("shutdown", &Value::Null), INVALID_REQUEST);
    assert_eq!(client.refused("textDocument/diagnostic", &of_document(&file)), INVALID_REQUEST);
    client.notify("exit", &Value::Null);
    assert_eq!(client.exit_code(), Some(0));
}

#[test]
fn nothing_is_sent_before_the_client_has_introduced_itself() {
    let (folder, _) = guilty("lsp_introduction");
    let mut client = Client::start();
    client.request("initialize", &json!({ "capabilities": {}, "rootUri": uri(&folder) }));
    std::thread::sleep(std::time::Duration::from_millis(300));
    assert_eq!(client.refused("nothing", &Value::Null), METHOD_NOT_FOUND);
    assert_eq!(client.left_over("textDocument/publishDiagnostics"), 0);
}

#[test]
fn wrong_messages_are_answered_and_forgotten() {
    let (folder, file) = guilty("lsp_garbage");
    let mut client = Client::in_folder(&folder, &plain());
    client.published(&file);

    client.send_bytes(b"Content-Length: 9\r\n\r\nnot json!");
    assert_eq!(client.response(&Value::Null)["error"]["code"], PARSE_ERROR);
    client.send_bytes(b"Content-Length: 4\r\n\r\n\xff\xfe\xfd\xfc");
    assert_eq!(client.response(&Value::Null)["error"]["code"], PARSE_ERROR);
    client.send_bytes(b"hello\r\n\r\nContent-Length: many\r\n\r\n");
    assert_eq!(client.response(&Value::Null)["error"]["code"], PARSE_ERROR);
    for message in [json!([]), json!(7), json!({ "jsonrpc": "2.0" }), json!({ "id": 1.5, "method": "a" })] {
        client.send(&message);
        assert_eq!(client.response(&Value::Null)["error"]["code"], INVALID_REQUEST, "{message}");
    }
    client.send(&json!({ "jsonrpc": "2.0", "id": "a", "method": 5 }));
    assert_eq!(client.response(&json!("a"))["error"]["code"], INVALID_REQUEST);
    // Nobody asked for these answers.
    client.send(&json!({ "jsonrpc": "2.0", "id": 99, "result": {} }));
    client.send(&json!({ "jsonrpc": "2.0", "id": null, "error": { "code": 1, "message": "?" } }));

    assert_eq!(client.refused("textDocument/rename", &Value::Null), METHOD_NOT_FOUND);
    assert_eq!(client.refused("$/unknown", &Value::Null), METHOD_NOT_FOUND);
    for method in
        ["textDocument/hover", "textDocument/diagnostic", "textDocument/codeAction", "workspace/executeCommand"]
    {
        for params in [Value::Null, json!([1]), json!({ "textDocument": "?" })] {
            assert_eq!(client.refused(method, &params), INVALID_PARAMS, "{method} {params}");
        }
    }
    for method in
        ["textDocument/didOpen", "textDocument/didChange", "workspace/didChangeWatchedFiles", "$/cancelRequest"]
    {
        client.notify(method, &json!({ "wrong": true }));
        let told = client.told("window/logMessage", |_| true);
        assert!(told["message"].as_str().is_some_and(|text| text.contains(method)), "{told}");
    }
    client.notify(
        "textDocument/didChange",
        &json!({ "textDocument": { "uri": "file:///no.rs", "version": 1 },
        "contentChanges": [] }),
    );
    client.told("window/logMessage", |params| params["message"].as_str().is_some_and(|text| text.contains("not open")));
    client.notify("unknown/thing", &json!({}));

    assert_eq!(codes(&client.pull(&file)), ["ceid::repeated_update"]);
    assert_eq!(client.leave(), Some(0));
}

#[test]
fn request_that_waits_can_be_cancelled() {
    let (folder, file) = guilty("lsp_cancel");
    let mut client = Client::start();
    client.request("initialize", &json!({ "capabilities": {}, "rootUri": uri(&folder) }));
    // What waits for the first check is still there when the next message is read.
    let frames = [
        json!({ "jsonrpc": "2.0", "method": "initialized", "params": {} }),
        json!({ "jsonrpc": "2.0", "id": "first", "method": "textDocument/diagnostic", "params": of_document(&file) }),
        json!({ "jsonrpc": "2.0", "method": "$/cancelRequest", "params": { "id": "first" } }),
    ];
    client.send_bytes(frames.iter().map(frame).collect::<String>().as_bytes());
    assert_eq!(client.response(&json!("first"))["error"]["code"], CANCELLED);
    client.notify("$/cancelRequest", &json!({ "id": 12345 }));
    assert_eq!(codes(&client.pull(&file)), ["ceid::repeated_update"]);
}

#[test]
fn shutdown_leaves_no_request_without_an_answer() {
    let (folder, file) = guilty("lsp_shutdown");
    let mut client = Client::in_folder(&folder, &plain());
    let id = client.ask("textDocument/diagnostic", &of_document(&file));
    client.request("shutdown", &Value::Null);
    let answer = client.response(&json!(id));
    assert!(answer.get("result").is_some() || answer["error"]["code"] == CANCELLED, "{answer}");
}

#[test]
fn first_check_shows_its_progress() {
    let (folder, _) = guilty("lsp_progress");
    let mut client = Client::in_folder(&folder, &json!({ "window": { "workDoneProgress": true } }));
    let begin = client.told("$/progress", |params| params["value"]["kind"] == "begin");
    let end = client.told("$/progress", |params| params["value"]["kind"] == "end");
    assert_eq!(begin["token"], end["token"]);
}

#[test]
fn wrong_settings_are_shown_and_the_defaults_hold() {
    let (folder, file) = guilty("lsp_wrong_settings");
    let mut client = Client::with_options(&[&folder], &plain(), &json!({ "inlayHint": true }));
    let told = client.told("window/showMessage", |_| true);
    assert!(told["message"].as_str().is_some_and(|text| text.contains("`inlayHint`")), "{told}");
    assert_eq!(codes(&client.pull(&file)), ["ceid::repeated_update"]);
}
