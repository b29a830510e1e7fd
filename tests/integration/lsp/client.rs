//! A client of the language server: starts the program, talks to it as an editor does, and reads all that comes back with the
//! types that other servers are written with.

use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::io::{BufRead, BufReader, Write};
use std::path::Path;
use std::process::{Child, ChildStdin, Command, Stdio};
use std::sync::mpsc::{self, Receiver, RecvTimeoutError};
use std::time::{Duration, Instant};

use serde::Serialize;
use serde::de::DeserializeOwned;
use serde_json::{Value, json};

use crate::support::program::program;

/// Long enough for the busiest machine.
const PATIENCE: Duration = Duration::from_secs(120);

/// Longer than any server waits before it begins with something.
const QUIET: Duration = Duration::from_secs(3);

/// A session with the server.
pub(super) struct Client {
    child: Child,
    input: Option<ChildStdin>,
    messages: Receiver<Value>,
    /// Notifications and requests of the server that nobody has waited for.
    heard: VecDeque<Value>,
    last_id: u64,
    /// Whether the server is the program under test, so that what it sends is looked at closely.
    is_ours: bool,
    /// What was published last of each file, by its address.
    shown: BTreeMap<String, Value>,
    /// What the server says that it is at.
    running: BTreeSet<String>,
    /// What is answered when the server asks for its section of the configuration.
    pub(super) section: Value,
}

/// What a client of no special ability says of itself.
pub(super) fn plain() -> Value {
    json!({ "textDocument": { "publishDiagnostics": { "relatedInformation": true }, "codeAction": {
        "codeActionLiteralSupport": { "codeActionKind": { "valueSet": ["quickfix"] } } } } })
}

impl Client {
    /// Starts the server and says nothing.
    pub(super) fn start() -> Self {
        Self::of(Command::new(program()).args(["ceid-lint", "lsp", "--stdio"]), true)
    }

    /// Starts a server of somebody else, and introduces itself.
    pub(super) fn of_other(command: &mut Command, params: &Value) -> Self {
        let mut client = Self::of(command, false);
        client.request("initialize", params);
        client.notify("initialized", &json!({}));
        client
    }

    fn of(command: &mut Command, is_ours: bool) -> Self {
        let mut child = command
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::inherit())
            .spawn()
            .expect("the program was built and starts");
        let output = BufReader::new(child.stdout.take().expect("it is piped"));
        let (sender, messages) = mpsc::channel();
        std::thread::spawn(move || {
            let mut output = output;
            while let Some(message) = read(&mut output) {
                if sender.send(message).is_err() {
                    return;
                }
            }
        });
        let input = child.stdin.take();
        let (heard, shown, running) = (VecDeque::new(), BTreeMap::new(), BTreeSet::new());
        Self { child, input, messages, heard, last_id: 0, is_ours, shown, running, section: Value::Null }
    }

    /// Starts the server for a folder.
    pub(super) fn in_folder(folder: &Path, capabilities: &Value) -> Self {
        Self::with_options(&[folder], capabilities, &Value::Null)
    }

    /// Starts the server for folders, with settings.
    pub(super) fn with_options(folders: &[&Path], capabilities: &Value, options: &Value) -> Self {
        let mut client = Self::start();
        let folders: Vec<Value> = folders.iter().map(|path| json!({ "uri": uri(path), "name": "folder" })).collect();
        let params = json!({ "processId": null, "rootUri": null, "workspaceFolders": folders,
            "capabilities": capabilities, "initializationOptions": options });
        let result = client.request("initialize", &params);
        check_type::<lsp_types::InitializeResult>(&result);
        client.notify("initialized", &json!({}));
        client
    }

    pub(super) fn process(&self) -> u32 {
        self.child.id()
    }

    pub(super) fn send_bytes(&mut self, bytes: &[u8]) {
        let input = self.input.as_mut().expect("it is open");
        input.write_all(bytes).and_then(|()| input.flush()).expect("the server reads");
    }

    pub(super) fn send(&mut self, message: &Value) {
        self.send_bytes(frame(message).as_bytes());
    }

    pub(super) fn notify(&mut self, method: &str, params: &Value) {
        self.send(&json!({ "jsonrpc": "2.0", "method": method, "params": params }));
    }

    /// Sends a request without waiting for its answer.
    pub(super) fn ask(&mut self, method: &str, params: &Value) -> u64 {
        self.last_id += 1;
        self.send(&json!({ "jsonrpc": "2.0", "id": self.last_id, "method": method, "params": params }));
        self.last_id
    }

    /// The result of a request.
    #[track_caller]
    pub(super) fn request(&mut self, method: &str, params: &Value) -> Value {
        let id = self.ask(method, params);
        let response = self.response(&json!(id));
        assert!(response.get("error").is_none(), "{method}: {response}");
        response["result"].clone()
    }

    /// The code of the error that a request ends in.
    #[track_caller]
    pub(super) fn refused(&mut self, method: &str, params: &Value) -> i64 {
        let id = self.ask(method, params);
        let response = self.response(&json!(id));
        response["error"]["code"].as_i64().unwrap_or_else(|| panic!("{method} is not refused: {response}"))
    }

    /// The answer to the request of that id.
    #[track_caller]
    pub(super) fn response(&mut self, id: &Value) -> Value {
        self.wait(|message| message.get("method").is_none() && message["id"] == *id)
    }

    /// The parameters of the next message of a method for which that holds.
    #[track_caller]
    pub(super) fn told(&mut self, method: &str, holds: impl Fn(&Value) -> bool) -> Value {
        let message = self.wait(|message| message["method"] == method && holds(&message["params"]));
        message["params"].clone()
    }

    /// The findings that are told of a file next.
    #[track_caller]
    pub(super) fn published(&mut self, path: &Path) -> Value {
        let uri = uri(path);
        self.told("textDocument/publishDiagnostics", |params| params["uri"] == uri)
    }

    /// The findings that are told of a version of a file.
    #[track_caller]
    pub(super) fn published_of(&mut self, path: &Path, version: i64) -> Value {
        let uri = uri(path);
        let is_it = |params: &Value| params["uri"] == uri && params["version"] == version;
        self.told("textDocument/publishDiagnostics", is_it)["diagnostics"].clone()
    }

    /// Messages of a method that came and that nobody has waited for.
    pub(super) fn left_over(&self, method: &str) -> usize {
        self.heard.iter().filter(|message| message["method"] == method).count()
    }

    /// How many findings stand as they were told unasked.
    pub(super) fn standing(&self) -> usize {
        self.shown.values().filter_map(Value::as_array).map(Vec::len).sum()
    }

    #[track_caller]
    fn wait(&mut self, is_it: impl Fn(&Value) -> bool) -> Value {
        if let Some(at) = self.heard.iter().position(&is_it) {
            return self.heard.remove(at).expect("it is there");
        }
        let until = Instant::now() + PATIENCE;
        loop {
            let rest = until.saturating_duration_since(Instant::now());
            let message = self.messages.recv_timeout(rest);
            let message = message.unwrap_or_else(|error| panic!("nothing comes ({error}); came: {:#?}", self.heard));
            self.look_at(&message);
            if is_it(&message) {
                return message;
            }
            self.heard.push_back(message);
        }
    }

    /// Reads what has a type, and answers what wants an answer.
    fn look_at(&mut self, message: &Value) {
        assert_eq!(message["jsonrpc"], "2.0", "{message}");
        let Some(method) = message["method"].as_str() else { return };
        let params = &message["params"];
        self.remember(method, params);
        match method {
            _ if !self.is_ours => {}
            "textDocument/publishDiagnostics" => check_type::<lsp_types::PublishDiagnosticsParams>(params),
            "window/logMessage" => check_type::<lsp_types::LogMessageParams>(params),
            "window/showMessage" => check_type::<lsp_types::ShowMessageParams>(params),
            "window/showDocument" => check_type::<lsp_types::ShowDocumentParams>(params),
            "client/registerCapability" => check_type::<lsp_types::RegistrationParams>(params),
            "workspace/configuration" => check_type::<lsp_types::ConfigurationParams>(params),
            "window/workDoneProgress/create" => check_type::<lsp_types::WorkDoneProgressCreateParams>(params),
            "$/progress" => check_type::<lsp_types::ProgressParams>(params),
            "workspace/diagnostic/refresh" | "workspace/inlayHint/refresh" => {
                assert!(message.get("params").is_none(), "{message}");
            }
            other => panic!("no client knows `{other}`"),
        }
        if let Some(id) = message.get("id") {
            let result = match method {
                "workspace/configuration" => json!([self.section]),
                "window/showDocument" => json!({ "success": true }),
                _ => Value::Null,
            };
            self.send(&json!({ "jsonrpc": "2.0", "id": id, "result": result }));
        }
    }

    fn remember(&mut self, method: &str, params: &Value) {
        match (method, params["value"]["kind"].as_str()) {
            ("textDocument/publishDiagnostics", _) => {
                let uri = params["uri"].as_str().expect("it is an address").to_owned();
                self.shown.insert(uri, params["diagnostics"].clone());
            }
            ("$/progress", Some("begin")) => {
                self.running.insert(params["token"].to_string());
            }
            ("$/progress", Some("end")) => {
                self.running.remove(&params["token"].to_string());
            }
            _ => {}
        }
    }

    /// What is shown of a file as soon as that holds for it, and the server has come to rest.
    #[track_caller]
    pub(super) fn shown(&mut self, path: &Path, holds: impl Fn(&[Value]) -> bool) -> Vec<Value> {
        let uri = uri(path);
        let until = Instant::now() + PATIENCE;
        loop {
            match self.messages.recv_timeout(QUIET) {
                Ok(message) => self.look_at(&message),
                Err(RecvTimeoutError::Timeout) if self.running.is_empty() => {
                    let shown = self.shown.get(&uri).and_then(Value::as_array).cloned().unwrap_or_default();
                    if holds(&shown) {
                        return shown;
                    }
                    assert!(Instant::now() < until, "not what was to be shown: {shown:#?}");
                }
                Err(RecvTimeoutError::Timeout) => assert!(Instant::now() < until, "no end of {:?}", self.running),
                Err(RecvTimeoutError::Disconnected) => panic!("the server is gone"),
            }
        }
    }

    pub(super) fn save(&mut self, path: &Path) {
        self.notify("textDocument/didSave", &json!({ "textDocument": { "uri": uri(path) } }));
    }

    pub(super) fn open(&mut self, path: &Path, text: &str) {
        let document = json!({ "uri": uri(path), "languageId": "rust", "version": 1, "text": text });
        self.notify("textDocument/didOpen", &json!({ "textDocument": document }));
    }

    /// Replaces the whole text.
    pub(super) fn replace(&mut self, path: &Path, version: i64, text: &str) {
        self.change(path, version, &json!([{ "text": text }]));
    }

    pub(super) fn change(&mut self, path: &Path, version: i64, changes: &Value) {
        let document = json!({ "uri": uri(path), "version": version });
        self.notify("textDocument/didChange", &json!({ "textDocument": document, "contentChanges": changes }));
    }

    pub(super) fn close(&mut self, path: &Path) {
        self.notify("textDocument/didClose", &json!({ "textDocument": { "uri": uri(path) } }));
    }

    /// Tells that a file was created (1), changed (2) or deleted (3).
    pub(super) fn watched(&mut self, path: &Path, kind: u32) {
        let changes = json!([{ "uri": uri(path), "type": kind }]);
        self.notify("workspace/didChangeWatchedFiles", &json!({ "changes": changes }));
    }

    /// What is found in a file, asked for.
    #[track_caller]
    pub(super) fn pull(&mut self, path: &Path) -> Vec<Value> {
        let report = self.request("textDocument/diagnostic", &json!({ "textDocument": { "uri": uri(path) } }));
        check_type::<lsp_types::DocumentDiagnosticReport>(&report);
        assert_eq!(report["kind"], "full");
        report["items"].as_array().expect("it is a list").clone()
    }

    /// The actions for a range.
    #[track_caller]
    pub(super) fn actions(&mut self, path: &Path, range: &Value, known: &[Value]) -> Vec<Value> {
        let params =
            json!({ "textDocument": { "uri": uri(path) }, "range": range, "context": { "diagnostics": known } });
        let actions = self.request("textDocument/codeAction", &params);
        check_type::<lsp_types::CodeActionResponse>(&actions);
        actions.as_array().expect("it is a list").clone()
    }

    #[track_caller]
    pub(super) fn hover(&mut self, path: &Path, line: u32, character: u32) -> Value {
        let position = json!({ "line": line, "character": character });
        let hover =
            self.request("textDocument/hover", &json!({ "textDocument": { "uri": uri(path) }, "position": position }));
        check_type::<Option<lsp_types::Hover>>(&hover);
        hover
    }

    /// Leaves as the protocol asks, and answers the exit code.
    #[track_caller]
    pub(super) fn leave(mut self) -> Option<i32> {
        assert_eq!(self.request("shutdown", &Value::Null), Value::Null);
        self.notify("exit", &Value::Null);
        self.exit_code()
    }

    /// Hangs up, and answers the exit code.
    pub(super) fn hang_up(mut self) -> Option<i32> {
        drop(self.input.take());
        self.exit_code()
    }

    pub(super) fn exit_code(&mut self) -> Option<i32> {
        self.child.wait().expect("it was started").code()
    }
}

impl Drop for Client {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// A message as it goes over the stream.
pub(super) fn frame(message: &Value) -> String {
    let body = message.to_string();
    format!("Content-Length: {}\r\n\r\n{body}", body.len())
}

/// The address of a file.
pub(super) fn uri(path: &Path) -> String {
    let path = path.to_str().expect("test paths are UTF-8");
    let byte = |byte: u8| match byte {
        b'/' | b'-' | b'_' | b'.' | b'~' => char::from(byte).to_string(),
        byte if byte.is_ascii_alphanumeric() => char::from(byte).to_string(),
        byte => format!("%{byte:02X}"),
    };
    format!("file://{}", path.bytes().map(byte).collect::<String>())
}

/// A text after changes, whose columns are counted in UTF-16.
pub(super) fn applied(text: &str, edits: &Value) -> String {
    let mut edits: Vec<(usize, usize, &str)> = edits
        .as_array()
        .expect("it is a list")
        .iter()
        .map(|edit| {
            let at = |end: &str| byte(text, &edit["range"][end]);
            (at("start"), at("end"), edit["newText"].as_str().expect("it is a text"))
        })
        .collect();
    edits.sort_unstable();
    let mut text = text.to_owned();
    for (start, end, new) in edits.into_iter().rev() {
        text.replace_range(start..end, new);
    }
    text
}

/// The byte of a position whose column is counted in UTF-16.
pub(super) fn byte(text: &str, position: &Value) -> usize {
    let number = |name: &str| position[name].as_u64().expect("it is a number") as usize;
    let start: usize = text.split_inclusive('\n').take(number("line")).map(str::len).sum();
    let mut units = number("character");
    let mut at = start;
    for letter in text[start..].chars() {
        if units == 0 {
            break;
        }
        units = units.checked_sub(letter.len_utf16()).expect("it lies between two characters");
        at += letter.len_utf8();
    }
    at
}

/// Asserts that a message is of a type, and has nothing that the type does not know.
#[track_caller]
pub(super) fn check_type<T: DeserializeOwned + Serialize>(value: &Value) {
    let read: T = serde_json::from_value(value.clone()).unwrap_or_else(|error| panic!("{error}: {value}"));
    let written = serde_json::to_value(read).expect("it was read");
    assert_eq!(without_nulls(&written), without_nulls(value));
}

fn without_nulls(value: &Value) -> Value {
    match value {
        Value::Object(fields) => {
            let fields = fields.iter().filter(|(_, value)| !value.is_null());
            Value::Object(fields.map(|(name, value)| (name.clone(), without_nulls(value))).collect())
        }
        Value::Array(values) => Value::Array(values.iter().map(without_nulls).collect()),
        other => other.clone(),
    }
}

fn read(output: &mut impl BufRead) -> Option<Value> {
    let mut length = 0;
    loop {
        let mut line = String::new();
        if output.read_line(&mut line).ok()? == 0 {
            return None;
        }
        match line.trim_end().split_once(": ") {
            Some(("Content-Length", value)) => length = value.parse().expect("the length is a number"),
            Some(_) => {}
            None => break,
        }
    }
    let mut body = vec![0; length];
    output.read_exact(&mut body).ok()?;
    Some(serde_json::from_slice(&body).expect("the server sends JSON"))
}
