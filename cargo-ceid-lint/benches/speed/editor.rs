//! What one edit costs the language server: a line is put into an open file and taken out again, and the findings move with it.

use std::io::{BufRead, BufReader, Read, Write};
use std::path::Path;
use std::process::{ChildStdout, Command, Stdio};
use std::time::Instant;

use serde_json::{Value, json};

/// How long the server waits for the next key before it checks, in seconds.
const PAUSE: f64 = 0.050;

/// What a session of edits cost.
pub(crate) struct Session {
    /// From an edit to its findings, in seconds, without the pause.
    pub(crate) latencies: Vec<f64>,
    /// Processor seconds for each edit on average.
    pub(crate) cpu: f64,
    /// How many MiB more there are in memory at the end than after a tenth of the edits.
    pub(crate) growth: f64,
}

/// Edits a file so often; nothing where the kernel does not tell what a process costs.
pub(crate) fn session(linter: &str, root: &Path, edits: usize) -> Option<Session> {
    let file = root.join("ceid-fixture/src/lib.rs");
    let text = std::fs::read_to_string(&file).ok()?;
    let mut server = Command::new(linter)
        .args(["lsp", "--stdio"])
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::null())
        .spawn()
        .ok()?;
    let mut input = server.stdin.take()?;
    let mut output = BufReader::new(server.stdout.take()?);
    let uri = format!("file://{}", file.display());
    let folder = format!("file://{}", root.display());
    let mut send = |message: &Value| {
        let text = message.to_string();
        write!(input, "Content-Length: {}\r\n\r\n{text}", text.len()).and_then(|()| input.flush()).ok()
    };
    // As most editors do, it tells of changes on the disk.
    let watching = json!({ "didChangeWatchedFiles": { "dynamicRegistration": true } });
    let capabilities = json!({ "textDocument": { "publishDiagnostics": {} }, "workspace": watching });
    let folders = json!([{ "uri": folder, "name": "corpus" }]);
    let introduction =
        json!({ "processId": null, "rootUri": null, "workspaceFolders": folders, "capabilities": capabilities });
    send(&json!({ "jsonrpc": "2.0", "id": 1, "method": "initialize", "params": introduction }))?;
    send(&json!({ "jsonrpc": "2.0", "method": "initialized", "params": {} }))?;
    let document = json!({ "uri": uri, "languageId": "rust", "version": 0, "text": text });
    send(&json!({ "jsonrpc": "2.0", "method": "textDocument/didOpen", "params": { "textDocument": document } }))?;
    wait_for(&mut output, &uri, 0)?;
    let (mut latencies, mut early) = (Vec::new(), 0.0);
    let before = cpu_of(server.id())?;
    for version in 1..=edits {
        let text = if version % 2 == 1 { format!("\n{text}") } else { text.clone() };
        let change =
            json!({ "textDocument": { "uri": uri, "version": version }, "contentChanges": [{ "text": text }] });
        let start = Instant::now();
        send(&json!({ "jsonrpc": "2.0", "method": "textDocument/didChange", "params": change }))?;
        wait_for(&mut output, &uri, version)?;
        latencies.push((start.elapsed().as_secs_f64() - PAUSE).max(0.0));
        if version == edits.div_ceil(10) {
            early = memory_of(server.id())?;
        }
    }
    let cpu = (cpu_of(server.id())? - before) / edits as f64;
    let growth = memory_of(server.id())? - early;
    // It ends when nobody is left to talk to.
    drop(input);
    let _ = server.wait();
    Some(Session { latencies, cpu, growth })
}

/// Reads until there are findings for this version of the file.
fn wait_for(output: &mut BufReader<ChildStdout>, uri: &str, version: usize) -> Option<()> {
    loop {
        let mut length = 0;
        loop {
            let mut line = String::new();
            if output.read_line(&mut line).ok()? == 0 {
                return None;
            }
            match line.trim().strip_prefix("Content-Length: ") {
                Some(number) => length = number.parse().ok()?,
                None if line.trim().is_empty() => break,
                None => {}
            }
        }
        let mut body = vec![0; length];
        output.read_exact(&mut body).ok()?;
        let message: Value = serde_json::from_slice(&body).ok()?;
        let params = &message["params"];
        let is_it = message["method"] == "textDocument/publishDiagnostics" && params["uri"] == uri;
        if is_it && params["version"].as_u64().is_none_or(|told| told >= version as u64) {
            return Some(());
        }
    }
}

/// The seconds that all threads of a process have run, in the kernel's steps of a hundredth.
fn cpu_of(process: u32) -> Option<f64> {
    let text = std::fs::read_to_string(format!("/proc/{process}/stat")).ok()?;
    let fields: Vec<&str> = text.rsplit_once(')')?.1.split_whitespace().collect();
    let ticks = |at: usize| fields.get(at)?.parse::<f64>().ok();
    Some((ticks(11)? + ticks(12)?) / 100.0)
}

/// MiB in memory now.
fn memory_of(process: u32) -> Option<f64> {
    super::runs::memory(process, "VmRSS:")
}
