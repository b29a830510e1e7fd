//! Many changes: the server's text stays that of the editor, and its memory does not grow.

use std::path::Path;
use std::time::{Duration, Instant};

use serde_json::{Value, json};

use super::client::{Client, plain};
use super::{codes, guilty};
use crate::support::workspace::{GUILTY, copy};

/// Numbers that are the same in each run.
struct Numbers(u64);

impl Numbers {
    fn below(&mut self, limit: usize) -> usize {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 33) as usize % limit
    }
}

const PIECES: &[&str] = &[
    "",
    "\n",
    "\r\n",
    "é",
    "𝛼",
    "kf.update();",
    "{",
    "}",
    "loop {",
    "if ready() { continue; }",
    "\"",
    "// ceid: allow(",
    "'a'",
    "mod x;",
    "#[cfg(any())]",
    "/*",
    "*/",
    "(",
    "match 1 { _ => {} }",
    "🦀",
];

/// Where a byte is, in lines and UTF-16 units.
fn position(text: &str, at: usize) -> Value {
    let before = &text[..at];
    let line = before.matches('\n').count();
    let start = before.rfind('\n').map_or(0, |end| end + 1);
    json!({ "line": line, "character": before[start..].encode_utf16().count() })
}

/// Makes one change somewhere, and answers it in the protocol's form.
fn random_change(text: &mut String, numbers: &mut Numbers) -> Value {
    // A lone carriage return would be a line of its own.
    let is_place = |at: &usize| text.is_char_boundary(*at) && !text[..*at].ends_with('\r');
    let places: Vec<usize> = (0..=text.len()).filter(is_place).collect();
    let start = numbers.below(places.len());
    let end = (start + numbers.below(8)).min(places.len() - 1);
    let (start, end) = (places[start], places[end]);
    let piece = PIECES[numbers.below(PIECES.len())];
    let range = json!({ "start": position(text, start), "end": position(text, end) });
    text.replace_range(start..end, piece);
    json!({ "range": range, "text": piece })
}

/// What a server finds that sees only the last text.
fn found_at_once(folder: &Path, file: &Path, text: &str) -> Vec<Value> {
    let mut client = Client::in_folder(folder, &plain());
    client.open(file, text);
    client.pull(file)
}

#[test]
fn random_changes_leave_the_right_text() {
    let (folder, file) = guilty("lsp_random");
    let mut numbers = Numbers(7);
    let mut client = Client::in_folder(&folder, &plain());
    let mut text = GUILTY.to_owned();
    client.open(&file, &text);
    let mut version = 1;
    for _ in 0..20 {
        for _ in 0..10 {
            version += 1;
            let count = 1 + numbers.below(3);
            let changes: Vec<Value> = (0..count).map(|_| random_change(&mut text, &mut numbers)).collect();
            client.change(&file, version, &json!(changes));
            if numbers.below(4) == 0 {
                client.hover(&file, numbers.below(12) as u32, numbers.below(20) as u32);
            }
        }
        assert_eq!(client.pull(&file), found_at_once(&folder, &file, &text), "{text}");
        // A text that is broken for good would say little.
        GUILTY.clone_into(&mut text);
        version += 1;
        client.replace(&file, version, &text);
    }
    assert_eq!(codes(&client.pull(&file)), ["ceid::repeated_update"]);
    assert_eq!(client.leave(), Some(0));
}

#[test]
fn newest_text_wins() {
    let (folder, file) = guilty("lsp_newest");
    let mut client = Client::in_folder(&folder, &plain());
    client.open(&file, "");
    for version in 2..100 {
        let text = if version == 99 { format!("\n\n{GUILTY}") } else { "\n".repeat(version as usize) };
        client.replace(&file, version, &text);
    }
    assert_eq!(super::places(&client.published_of(&file, 99)), [[8, 8, 19]]);
    // Not every state in between was worth a check.
    assert!(client.left_over("textDocument/publishDiagnostics") < 50);
}

/// The memory of a process that is in use, in KiB.
#[cfg(target_os = "linux")]
fn resident(process: u32) -> u64 {
    let status = std::fs::read_to_string(format!("/proc/{process}/status")).expect("it runs");
    let line = status.lines().find(|line| line.starts_with("VmRSS:")).expect("the system tells");
    line.split_whitespace().nth(1).and_then(|number| number.parse().ok()).expect("it is a number")
}

#[cfg(target_os = "linux")]
#[test]
fn memory_does_not_grow_with_edits() {
    let (folder, file) = guilty("lsp_memory");
    let mut client = Client::in_folder(&folder, &plain());
    let text = format!("{GUILTY}{}", "pub fn more(mut kf: Kalman) { loop { kf.update(); } }\n".repeat(3));
    client.open(&file, &text);
    let mut early = 0;
    for version in 2..=1_000 {
        let line = format!("pub fn f{version}() {{}}\n");
        client.replace(&file, version, &format!("{text}{line}"));
        assert_eq!(client.pull(&file).len(), 1);
        if version == 200 {
            early = resident(client.process());
        }
    }
    let late = resident(client.process());
    assert!(late * 2 <= early * 3, "{early} KiB after 200 edits, {late} KiB after 1,000");
}

/// A day of work: `cargo test --release -p cargo-ceid-lint --test integration -- --ignored --nocapture ten_thousand`
#[cfg(target_os = "linux")]
#[test]
#[ignore = "makes 10,000 edits, and asks after each what is found; EDITS says another number"]
fn ten_thousand_edits_cost_neither_memory_nor_patience() {
    let edits = std::env::var("EDITS").ok().and_then(|edits| edits.parse().ok()).unwrap_or(10_000);
    let folder = copy("legacy_robot", "lsp_day");
    let file = folder.join("src/rover.rs");
    let start = std::fs::read_to_string(&file).expect("it is there");
    let mut client = Client::in_folder(&folder, &plain());
    client.open(&file, &start);
    let at_first = client.pull(&file);
    let mut numbers = Numbers(11);
    let mut text = start.clone();
    let mut times = Vec::new();
    let mut early = 0;
    for edit in 0..edits {
        let version = edit + 2;
        // Broken text is the easy case: it is put right again from time to time.
        if edit % 20 == 19 {
            text.clone_from(&start);
            client.replace(&file, version, &text);
        } else {
            let change = random_change(&mut text, &mut numbers);
            client.change(&file, version, &json!([change]));
        }
        let asked = Instant::now();
        client.pull(&file);
        times.push(asked.elapsed());
        if edit + 1 == edits / 10 {
            early = resident(client.process());
        }
    }
    client.replace(&file, edits + 2, &start);
    assert_eq!(client.pull(&file), at_first);
    let late = resident(client.process());
    times.sort_unstable();
    let share = |percent: usize| -> Duration { times[(times.len() - 1) * percent / 100] };
    println!(
        "{edits} edits: {early} KiB after a tenth of them, {late} KiB after all; from an edit to the answer: \
         median {:.1?}, 99 of 100 within {:.1?}, the longest {:.1?}",
        share(50),
        share(99),
        share(100)
    );
    assert!(late * 4 <= early * 5, "{early} KiB after a tenth of the edits, {late} KiB after all");
    assert_eq!(client.leave(), Some(0));
}
