//! Calls of other crates that have to do with time, known by their paths.

use crate::support::program::run;
use crate::support::workspace::temporary_package;

const MANIFEST: &[u8] = b"[workspace]

[package]
name = \"clocks\"
version = \"0.1.0\"
edition = \"2021\"

[dependencies]
chrono = \"0.4\"
embassy-sync = \"0.6\"
embassy-time = \"0.3\"
embedded-hal = \"1\"
tokio = \"1\"
";

const FILTER: &str = "trait SampledFilter { fn update(&mut self); }
struct Smooth { mean: f32 }
impl Smooth {
    fn new(sample_period: embassy_time::Duration) -> Self { Smooth { mean: 0.0 } }
    fn rated(sample_rate: f32) -> Self { Smooth { mean: 0.0 } }
    fn with_dt(self, dt: f32) -> Self { self }
    fn tuned(self, gain: f32) -> Self { self }
}
impl SampledFilter for Smooth { fn update(&mut self) { self.mean += 1.0; } }
";

/// Checks a body with both rules switched on; `expected` is the rule and the text of each finding's line.
#[track_caller]
fn check(name: &str, code: &str, expected: &[(&str, &str)]) {
    let text = format!("{FILTER}{code}\nfn main() {{}}\n");
    let directory = temporary_package(
        &format!("time_domain_{name}"),
        &[("Cargo.toml", MANIFEST), ("src/main.rs", text.as_bytes())],
    );
    let args = ["-W", "time_in_cycle", "-W", "rate_mismatch", "--offline", "--message-format", "json"];
    let findings = run(&directory, args).findings().expect("the run succeeds");
    let lines: Vec<&str> = text.lines().collect();
    let found: Vec<(&str, &str)> =
        findings.iter().map(|finding| (finding.rule.as_str(), lines[finding.line - 1].trim())).collect();
    assert_eq!(found, expected);
}

#[test]
fn embassy() {
    check(
        "embassy",
        "use embassy_sync::mutex::Mutex;
use embassy_time::{Duration, Instant, Ticker};
async fn run(shared: &'static Mutex<Raw, f32>) {
    let mut smooth = Smooth::new(Duration::from_millis(5));
    let mut ticker = Ticker::every(Duration::from_millis(10));
    loop {
        smooth.update();
        *shared.lock().await = smooth.mean;
        let now = Instant::now();
        ticker.next().await;
    }
}",
        &[
            ("rate_mismatch", "let mut smooth = Smooth::new(Duration::from_millis(5));"),
            ("time_in_cycle", "*shared.lock().await = smooth.mean;"),
            ("time_in_cycle", "let now = Instant::now();"),
        ],
    );
}

#[test]
fn tokio() {
    check(
        "tokio",
        "use tokio::time;
async fn ticks() {
    let mut smooth = Smooth::rated(50.0).tuned(2.0);
    let mut interval = time::interval(time::Duration::from_millis(10));
    loop {
        interval.tick().await;
        smooth.update();
    }
}
async fn sleeps() {
    let mut smooth = Smooth::rated(100.0);
    loop {
        smooth.update();
        time::sleep(time::Duration::from_millis(10)).await;
    }
}",
        &[
            ("rate_mismatch", "let mut smooth = Smooth::rated(50.0).tuned(2.0);"),
            ("time_in_cycle", "time::sleep(time::Duration::from_millis(10)).await;"),
        ],
    );
}

#[test]
fn delays_behind_a_trait() {
    check(
        "delays",
        "use embedded_hal::delay::DelayNs;
fn run(delay: &mut impl DelayNs) {
    let mut smooth = Smooth::rated(500.0).with_dt(0.02);
    loop {
        smooth.update();
        delay.delay_ms(20);
        println!(\"{}\", chrono::Utc::now());
    }
}",
        &[("time_in_cycle", "delay.delay_ms(20);"), ("time_in_cycle", "println!(\"{}\", chrono::Utc::now());")],
    );
}
