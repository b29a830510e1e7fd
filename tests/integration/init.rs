//! `cargo ceid-lint init`: what is found in five workspaces, and that the file is right as it is and with every `#` removed.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use crate::schema::is_valid_file;
use crate::support::program::{Run, run};
use crate::support::workspace;

/// A copy of a committed workspace, for a file is written into it.
fn copy(name: &str, test: &str) -> PathBuf {
    let to = workspace::temporary(&format!("{name}_{test}"));
    copy_into(&workspace::committed(name), &to, "");
    to
}

fn copy_into(from: &Path, to: &Path, below: &str) {
    for entry in std::fs::read_dir(from.join(below)).expect("the workspace is readable") {
        let entry = entry.expect("the workspace is readable");
        let path = format!("{below}{}", entry.file_name().to_string_lossy());
        if entry.path().is_dir() {
            copy_into(from, to, &format!("{path}/"));
        } else {
            workspace::write(to, &path, &std::fs::read(entry.path()).expect("the file is readable"));
        }
    }
}

fn read(directory: &Path) -> String {
    std::fs::read_to_string(directory.join("ceid-lint.toml")).expect("the file was written")
}

/// The file as it is when the user has removed every `#` that stands before an entry.
fn uncommented(text: &str) -> String {
    let mut all = String::new();
    for line in text.lines() {
        let is_entry = line.strip_prefix('#').is_some_and(|rest| !rest.is_empty() && !rest.starts_with(' '));
        writeln!(all, "{}", if is_entry { &line[1..] } else { line }).expect("a String");
    }
    all
}

/// Asserts that the check takes a file, which means that every path in it names something.
#[track_caller]
fn assert_taken(directory: &Path, text: &str) -> Run {
    assert!(is_valid_file(text), "the schema does not allow\n{text}");
    workspace::write(directory, "ceid-lint.toml", text.as_bytes());
    let run = run(directory, ["--workspace"]);
    assert!(run.code != Some(101), "{text}\n{}", run.stderr);
    run
}

/// The file that is written, shown; it and all that is turned on by hand or by `--accept` are taken by the check.
#[track_caller]
fn check(name: &str) -> String {
    let directory = copy(name, "written");
    run(&directory, ["init"]).assert_code(0);
    let text = read(&directory);
    assert_taken(&directory, &text);
    assert_taken(&directory, &uncommented(&text));
    let accepted = run(&directory, ["init", "--stdout", "--accept"]);
    assert_taken(&directory, &accepted.assert_code(0).stdout);
    let entries = |text: &str| text.lines().filter(|line| line.starts_with("[[")).count();
    let uncalled = text.matches("; no call of it was read.").count();
    assert_eq!(
        entries(&accepted.stdout) + uncalled,
        entries(&uncommented(&text)),
        "`--accept` turns on what is called"
    );
    let again = run(&directory, ["init", "--stdout"]);
    assert_eq!(again.stdout, text, "the same code gives the same file");
    text
}

#[test]
fn filters_written_by_hand() {
    insta::assert_snapshot!(check("init_robot"));
}

#[test]
fn filters_and_what_has_their_look() {
    insta::assert_snapshot!(check("init_lookalikes"));
}

#[test]
fn a_program_without_filters() {
    insta::assert_snapshot!(check("init_nothing"));
}

#[test]
fn crates_with_a_preset_and_crates_without() {
    insta::assert_snapshot!(check("init_presets"));
}

#[test]
fn names_that_clash() {
    insta::assert_snapshot!(check("init_clash"));
}

#[test]
fn the_first_check_finds_what_is_wrong() {
    let directory = copy("init_robot", "first_check");
    run(&directory, [""; 0]).assert_code(0).assert_stderr("nothing to check");
    run(&directory, ["init"]).assert_code(0).assert_stderr("wrote `ceid-lint.toml`");
    run(&directory, [""; 0]).assert_code(100).assert_stderr("`pid` is updated more than once in one cycle");
}

/// A workspace with a package at its root, and another one below it that has the loops.
#[test]
fn a_first_check_that_leaves_packages_out_says_so() {
    let directory = workspace::temporary("first_check_of_a_root");
    workspace::write(&directory, "Cargo.toml", b"[package]\nname = \"ground\"\n[workspace]\nmembers = [\"robot\"]\n");
    workspace::write(&directory, "src/lib.rs", b"pub struct Station;\n");
    workspace::copy_all(&workspace::committed("init_robot"), &directory.join("robot"));
    let manifest = std::fs::read_to_string(directory.join("robot/Cargo.toml")).expect("it was copied");
    workspace::write(&directory, "robot/Cargo.toml", manifest.replace("[workspace]", "").as_bytes());
    run(&directory, ["init"]).assert_code(0);
    run(&directory, [""; 0])
        .assert_code(0)
        .assert_stderr("note: left out: 1 other package of this workspace; `--workspace` checks all");
    for chosen in [&["--workspace"][..], &["-p", "ground"]] {
        let said = run(&directory, chosen.iter().copied());
        assert!(!said.stderr.contains("left out"), "{}", said.stderr);
    }
    let written = run(&directory, ["init", "--force"]);
    written.assert_code(0).assert_stderr("then run `cargo ceid-lint --workspace`");
    assert!(read(&directory).contains("`cargo ceid-lint --workspace` checks"), "{}", read(&directory));
}

#[test]
fn a_file_that_is_there_stays() {
    let directory = copy("init_robot", "kept");
    workspace::write(&directory, "ceid-lint.toml", b"presets = \"none\"\n");
    run(&directory, ["init"]).assert_code(101).assert_stderr("already there").assert_stderr("--force");
    run(&directory, ["init", "--accept"]).assert_code(101);
    assert!(run(&directory, ["init", "--stdout"]).assert_code(0).stdout.contains("[[filter]]"));
    assert_eq!(read(&directory), "presets = \"none\"\n");
    run(&directory, ["init", "--force"]).assert_code(0);
    assert!(read(&directory).contains("[[filter]]"));
}

#[test]
fn names_turn_candidates_on() {
    let directory = copy("init_robot", "named");
    let on = |names: &[&str]| {
        let run = run(&directory, ["init", "--stdout", "--accept"].iter().chain(names));
        let stdout = run.assert_code(0).stdout.clone();
        stdout.lines().filter(|line| line.starts_with("type =") || line.starts_with("function =")).count()
    };
    let certain = run(&directory, ["init", "--stdout"]).stdout.matches("\ntype =").count();
    assert_eq!(on(&["Heading"]), certain + 1);
    assert_eq!(on(&["control::Heading", "estimate::smooth"]), certain + 2);
    assert_eq!(on(&["Heading,smooth"]), certain + 2);
    run(&directory, ["init", "--stdout", "--accept", "Heeding"])
        .assert_code(2)
        .assert_stderr("nothing called `Heeding` was found; did you mean `Heading`?");
}

#[test]
fn a_workspace_that_is_broken_gets_its_file_as_well() {
    let directory = workspace::temporary("init_broken");
    let manifest = "[package]\nname = \"broken\"\nversion = \"0.0.0\"\nedition = \"2024\"\n\n[dependencies]\n\
                    gone = { path = \"../gone\" }\n";
    let code = "mod lost;\npub struct Pid { i: f32 }\nimpl Pid {\n    pub fn update(&mut self, e: f32) -> f32 { self.i += e; self.i }\n}\n\
                pub fn run(mut pid: Pid) { loop { pid.update(1.0); } }\n";
    workspace::write(&directory, "Cargo.toml", manifest.as_bytes());
    workspace::write(&directory, "src/lib.rs", code.as_bytes());
    let run = run(&directory, ["init"]);
    run.assert_code(101).assert_stderr("could not be read");
    assert!(read(&directory).contains("\ntype = \"crate::Pid\"\n"), "{}", read(&directory));
}

#[test]
fn packages_side_by_side_get_a_file_each() {
    let directory = workspace::temporary("init_side_by_side");
    let code = b"pub struct Ramp { at: f32 }\nimpl Ramp {\n    pub fn step(&mut self, to: f32) -> f32 { self.at += 0.1 * (to - self.at); self.at }\n}\n";
    for name in ["left", "right"] {
        let manifest = format!("[package]\nname = \"{name}\"\nversion = \"0.0.0\"\nedition = \"2024\"\n");
        workspace::write(&directory, &format!("{name}/Cargo.toml"), manifest.as_bytes());
        workspace::write(&directory, &format!("{name}/src/lib.rs"), code);
    }
    run(&directory, ["init", "."]).assert_code(0);
    for name in ["left", "right"] {
        assert!(read(&directory.join(name)).contains("#type = \"crate::Ramp\""), "{name}");
    }
}

/// The file for one package with this code.
pub(crate) fn written_for(name: &str, code: &str) -> String {
    let directory = workspace::temporary_package(name, &[("src/lib.rs", code.as_bytes())]);
    run(&directory, ["init", "--stdout"]).assert_code(0).stdout.clone()
}

/// A filter with two halves, both called in each round of a loop.
fn halves(name: &str, round: &str) -> String {
    format!(
        "pub struct {name} {{ x: f64, p: f64, q: f64 }}\nimpl {name} {{\n\
         pub fn predict(&mut self, dt: f64) {{ self.x += dt * self.p; self.p += self.q * dt; }}\n\
         pub fn correct(&mut self, z: f64) {{ let k = self.p / (self.p + 1.0); self.x += k * (z - self.x); self.p *= 1.0 - k; }}\n\
         }}\npub fn run(mut kf: {name}) {{ loop {{ {round} }} }}\n"
    )
}

#[test]
fn a_number_in_the_name_of_a_type_hides_nothing() {
    for name in ["Kalman", "Kalman1D", "Kalman2", "EKF9"] {
        let file = written_for("init_numbers", &halves(name, "kf.predict(0.01); kf.correct(1.0);"));
        assert!(file.contains("law = [[\"predict\"], [\"correct\"]]"), "{name}\n{file}");
        assert!(file.contains(&format!("\ntype = \"crate::{name}\"\n")), "{name}\n{file}");
    }
    // A half that no cycle calls leaves a doubt.
    let file = written_for("init_one_half", &halves("Kalman", "kf.predict(0.01);"));
    assert!(file.contains("#type = \"crate::Kalman\""), "{file}");
}

#[test]
fn halves_are_told_by_nouns_as_well() {
    let code = halves("Kalman", "kf.predict(0.01); kf.correct(1.0);");
    let code = code.replace("predict", "prediction").replace("correct", "correction");
    let file = written_for("init_nouns", &code);
    assert!(file.contains("law = [[\"prediction\"], [\"correction\"]]\nmultiplicity = [\"once\", \"any\"]"), "{file}");
}

#[test]
fn a_whole_step_runs_both_halves() {
    let inline = "pub fn estimate(&mut self, z: f64, dt: f64) {\n\
        self.x += dt * self.p; self.p += self.q * dt; self.x += self.p * (z - self.x); self.p *= 0.5; }";
    let calling = "pub fn estimate(&mut self, z: f64, dt: f64) {\n\
        if z > 0.0 { self.predict(dt); self.correct(z); } }";
    for (number, whole) in [inline, calling].into_iter().enumerate() {
        let code = halves("Kalman", "kf.estimate(1.0, 0.01); kf.predict(0.01); kf.correct(1.0);");
        let code = code.replace("}\npub fn run", &format!("{whole}\n}}\npub fn run"));
        let file = written_for(&format!("init_whole_{number}"), &code);
        let law = "[[\"estimate\", \"predict\"], [\"correct\", \"estimate\"]]";
        assert!(file.contains(law), "{code}\n{file}");
    }
}

#[test]
fn what_is_given_a_function_is_set_up_with_it() {
    let directory = workspace::temporary("init_given_a_function");
    let manifest =
        "[package]\nname = \"given\"\nversion = \"0.0.0\"\nedition = \"2024\"\n\n[dependencies]\nservo-parts = \"1\"\n";
    workspace::write(&directory, "Cargo.toml", manifest.as_bytes());
    let written = |call: &str| {
        let code = format!(
            "use servo_parts::PidController;\nfn mix(a: f32, b: f32) -> f32 {{ a + b }}\n\
             pub fn run(mut pid: PidController) {{ {call}; loop {{ pid.compute(1.0, 2.0); }} }}\n"
        );
        workspace::write(&directory, "src/lib.rs", code.as_bytes());
        run(&directory, ["init", "--stdout"]).stdout.clone()
    };
    for call in ["pid.compute_fn(mix)", "pid.compute_by(|a, b| a * b)"] {
        let file = written(call);
        assert!(file.contains("law = \"compute\"\n"), "{call}\n{file}");
    }
    let file = written("pid.compute_at(1.0)");
    assert!(file.contains("[\"compute\", \"compute_at\"]"), "{file}");
}

#[test]
fn a_reset_is_as_full_as_those_it_hands_on_to() {
    let code = |inner: &str| {
        format!(
            "pub struct Smooth {{ y: f32, sum: f32, alpha: f32 }}\nimpl Smooth {{\n\
             pub fn update(&mut self, x: f32) -> f32 {{ self.y += self.alpha * (x - self.y); self.sum += x; self.y }}\n\
             pub fn reset(&mut self) {{ {inner} }} }}\n\
             pub struct RatePid {{ low: Smooth, kp: f32 }}\nimpl RatePid {{\n\
             pub fn update(&mut self, x: f32) -> f32 {{ self.kp * self.low.update(x) }}\n\
             pub fn reset(&mut self) {{ self.low.reset(); }} }}\n\
             pub fn run(mut pid: RatePid) {{ loop {{ pid.update(1.0); }} }}\n"
        )
    };
    let full = written_for("init_full_reset", &code("self.y = 0.0; self.sum = 0.0;"));
    assert_eq!(full.matches("reset = [\"reset\"]").count(), 2, "{full}");
    assert!(!full.contains("partial_reset"), "{full}");
    let partial = written_for("init_partial_reset", &code("self.sum = 0.0;"));
    assert_eq!(partial.matches("partial_reset = [\"reset\"]").count(), 2, "{partial}");
}

#[test]
fn calls_by_a_trait_of_several_types_are_read() {
    let code = "pub trait Shape { fn shape(&mut self, x: f32) -> f32; }\n\
         pub struct LowPass { alpha: f32, y: f32 }\n\
         impl LowPass { fn shape(&mut self, x: f32) -> f32 { self.y += self.alpha * (x - self.y); self.y } }\n\
         impl Shape for LowPass { fn shape(&mut self, x: f32) -> f32 { self.y += self.alpha * (x - self.y); self.y } }\n\
         pub struct Through;\nimpl Shape for Through { fn shape(&mut self, x: f32) -> f32 { x } }\n\
         pub struct Gate;\nimpl Shape for Gate { fn shape(&mut self, x: f32) -> f32 { -x } }\n\
         pub fn run(shape: &mut dyn Shape) { loop { shape.shape(1.0); } }\n";
    let file = written_for("init_by_trait", code);
    assert!(file.contains("through a trait") && !file.contains("no call of it was read"), "{file}");
}

#[test]
fn calls_on_a_type_are_calls_of_its_trait() {
    let code = "pub trait Estimator { fn advance(&mut self, z: f64) -> f64; }\n\
                pub struct Ema { alpha: f64, y: f64 }\n\
                impl Estimator for Ema { fn advance(&mut self, z: f64) -> f64 { self.y += self.alpha * (z - self.y); self.y } }\n\
                pub fn run(mut ema: Ema) { loop { ema.advance(1.0); } }\n";
    let file = written_for("init_trait_calls", code);
    assert!(!file.contains("no call of it was read") && file.contains("in a cycle"), "{file}");
}

#[test]
fn filters_take_samples_by_the_names_of_containers() {
    let average = |method: &str| {
        format!(
            "pub struct MovingAverage {{ buf: [f32; 8], sum: f32, idx: usize }}\nimpl MovingAverage {{\n\
             pub fn {method}(&mut self, x: f32) -> f32 {{\n\
             self.sum += x - self.buf[self.idx]; self.buf[self.idx] = x; self.idx = (self.idx + 1) % 8; self.sum / 8.0 }}\n}}\n\
             pub fn run(mut average: MovingAverage) {{ loop {{ average.{method}(1.0); }} }}\n"
        )
    };
    for method in ["push", "add"] {
        let file = written_for("init_taken_in", &average(method));
        assert!(file.contains("#type = \"crate::MovingAverage\""), "{method}\n{file}");
    }
    let counts = |add: &str, output: &str| {
        format!(
            "pub struct MovingAverage {{ buf: [u16; 8], sum: u32, idx: usize }}\nimpl MovingAverage {{\n\
             pub fn push(&mut self, x: u16) -> {output} {{\n\
             {add}; self.buf[self.idx] = x; self.idx = (self.idx + 1) & 7; {output}::default() }}\n}}\n\
             pub struct Median {{ window: [u16; 5], used: usize }}\nimpl Median {{\n\
             pub fn insert(&mut self, x: u16) -> u16 {{\n\
             self.window[self.used % 5] = x; self.used += 1; let mut all = self.window; all.sort(); all[2] }}\n}}\n\
             pub fn run(mut average: MovingAverage, mut median: Median) {{ loop {{ average.push(median.insert(1)); }} }}\n"
        )
    };
    for add in ["self.sum += u32::from(x)", "self.sum = self.sum + u32::from(x) - u32::from(self.buf[self.idx])"] {
        for output in ["u16", "bool"] {
            let file = written_for("init_taken_counts", &counts(add, output));
            for name in ["MovingAverage", "Median"] {
                assert!(file.contains(&format!("#type = \"crate::{name}\"")), "{name} {add} {output}\n{file}");
            }
        }
    }
    let members = "pub struct BloomFilter { bits: [u64; 8], used: u64 }\n\
         impl BloomFilter { pub fn insert(&mut self, key: u64) { self.bits[key as usize % 8] |= 1 << (key & 63); self.used += 1; } }\n\
         pub struct IdFilter { ids: [u32; 8], used: usize }\n\
         impl IdFilter { pub fn add(&mut self, id: u32) -> bool { self.ids[self.used] = id; self.used += 1; true } }\n\
         pub fn run(mut keys: BloomFilter, mut ids: IdFilter) { loop { keys.insert(1); ids.add(2); } }\n";
    let file = written_for("init_members", members);
    assert!(!file.contains("BloomFilter") && !file.contains("IdFilter"), "{file}");
    let containers = "pub struct FilterBank { gains: [f32; 8], used: usize }\n\
         impl FilterBank { pub fn push(&mut self, gain: f32) { self.gains[self.used] = gain; self.used += 1; } }\n\
         pub struct Total { sum: f32 }\nimpl Total { pub fn add(&mut self, x: f32) -> f32 { self.sum += 0.5 * x; self.sum } }\n\
         pub fn run(mut bank: FilterBank, mut total: Total) { loop { bank.push(1.0); total.add(1.0); } }\n";
    let file = written_for("init_containers", containers);
    assert!(!file.contains("FilterBank") && !file.contains("Total"), "{file}");
}

#[test]
fn a_regulator_is_proposed_in_whatever_language() {
    let code = |run: &str| {
        format!(
            "pub struct Regler {{ kp: f64, ki: f64, summe: f64, y1: f64 }}\nimpl Regler {{\n\
             pub fn berechne(&mut self, soll: f64, ist: f64) -> f64 {{ let e = soll - ist; self.summe += e; self.y1 = e; self.kp * e + self.ki * self.summe }}\n}}\n\
             pub fn run(mut regler: Regler) {{ {run} }}\n"
        )
    };
    let file = written_for("init_regler", &code("loop { regler.berechne(1.0, 2.0); }"));
    assert!(file.contains("#type = \"crate::Regler\""), "{file}");
    assert!(file.contains("tuned by") && !file.contains("`y1`"), "what the law writes is no gain\n{file}");
    let file = written_for("init_einmal", &code("regler.berechne(1.0, 2.0);"));
    assert!(!file.contains("Regler"), "it runs once\n{file}");
}

#[test]
fn laws_in_disguise_are_told_from_settings() {
    let code = "pub struct Pll { phase: f32, gain: f32 }\nimpl Pll {\n\
         pub fn handle(&mut self, carrier: f32, x: f32) { let e = carrier * x; self.phase += self.gain * e; } }\n\
         pub struct Pid { kp: f32, ki: f32, sum: f32 }\nimpl Pid {\n\
         pub fn set_input(&mut self, x: f32) -> f32 { self.sum += self.ki * x; self.kp * x + self.sum } }\n\
         pub struct Ramp { value: f32, rate: f32 }\nimpl Ramp {\n\
         pub fn set_rate(&mut self, rate: f32) { self.rate *= rate; } }\n\
         pub fn run(mut pll: Pll, mut pid: Pid, mut ramp: Ramp) { loop { pll.handle(1.0, 2.0); pid.set_input(1.0); ramp.set_rate(2.0); } }\n";
    let file = written_for("init_disguise", code);
    assert!(file.contains("law = \"handle\"") && file.contains("law = \"set_input\""), "{file}");
    assert!(!file.contains("set_rate"), "{file}");
}

#[test]
fn filters_that_give_back_the_next_state_are_proposed() {
    let code = "#[derive(Clone)] pub struct State { x: f32, p: f32 }\n\
         pub struct KalmanFilter { q: f32 }\nimpl KalmanFilter {\n\
         pub fn predict(&self, state: &State) -> State { State { x: state.x, p: state.p + self.q } }\n\
         pub fn update(&self, state: &State, z: f32) -> State { State { x: state.x + 0.5 * (z - state.x), p: state.p } }\n\
         pub fn distance(&self, state: &State, z: f32) -> f32 { state.x - z } }\n\
         pub fn run(kf: &KalmanFilter, mut state: State) { loop { state = kf.predict(&state); state = kf.update(&state, 1.0); } }\n";
    let directory = workspace::temporary_package("init_functional", &[("src/lib.rs", code.as_bytes())]);
    let file = run(&directory, ["init", "--stdout"]).assert_code(0).stdout.clone();
    assert!(file.contains("instance = \"returned\"") && file.contains("[\"predict\"], [\"update\"]"), "{file}");
    let taken = assert_taken(&directory, &uncommented(&file));
    assert!(taken.stderr.contains("2 filters: 2 proved"), "{taken:?}");
}

#[test]
fn what_a_glob_brings_from_an_unread_crate_has_no_path() {
    let code = "use signal_parts::*;\npub fn run(mut biquad: Biquad) { loop { biquad.process(1.0); } }\n";
    assert!(!written_for("init_glob", code).contains('?'));
}

#[test]
fn time_steps_have_many_names() {
    for (name, is_time) in [
        ("iteration_length", true),
        ("t_interval_seconds", true),
        ("timestamp_now_us", true),
        ("measurement_time", true),
        ("current_time", true),
        ("attack_time", false),
    ] {
        let code = format!(
            "pub struct LowPass {{ y: f32, alpha: f32 }}\nimpl LowPass {{\n\
             pub fn update(&mut self, x: f32, {name}: f32) -> f32 {{ self.y += self.alpha * {name} * (x - self.y); self.y }} }}\n\
             pub fn run(mut low: LowPass) {{ loop {{ low.update(1.0, 2.0); }} }}\n"
        );
        let file = written_for("init_time", &code);
        assert_eq!(file.contains("time_base = \"passed\""), is_time, "{name}\n{file}");
    }
}

#[test]
fn a_law_that_lends_its_filter_is_no_builder() {
    let code = "pub trait Regulator { fn update(&mut self, z: f32, now_us: i64) -> &mut Self; fn reset(&mut self); }\n\
         pub struct Pi { kp: f32, sum: f32 }\n\
         impl Pi { pub fn with_gain(&mut self, kp: f32) -> &mut Self { self.kp = kp; self } }\n\
         impl Regulator for Pi { fn update(&mut self, z: f32, now_us: i64) -> &mut Self { self.sum += self.kp * z; self }\n\
         fn reset(&mut self) { self.sum = 0.0; } }\n\
         pub fn run(mut pi: Pi) { loop { pi.update(1.0, 2); } }\n";
    let file = written_for("init_lent", code);
    assert!(file.contains("trait = \"crate::Regulator\"\n#law = \"update\"\n#reset = [\"reset\"]"), "{file}");
    assert!(file.contains("time_base = \"passed\"") && !file.contains("with_gain"), "{file}");
}

#[test]
fn filters_made_of_filters_are_proposed_and_boards_with_filters_are_not() {
    let code = "pub struct Delay { line: Vec<f32>, head: usize }\nimpl Delay {\n\
         pub fn process(&mut self, x: f32) -> f32 {\n\
         let y = self.line[self.head]; self.line[self.head] = x; self.head = (self.head + 1) % self.line.len(); y } }\n\
         pub struct Diffuse { early: Delay, late: Vec<Delay> }\nimpl Diffuse {\n\
         pub fn process(&mut self, x: f32) -> f32 { let mut y = self.early.process(x); for d in &mut self.late { y += d.process(x); } y } }\n\
         pub struct Session { echo: Delay, log: Vec<f32> }\nimpl Session {\n\
         pub fn process(&mut self, x: f32) -> f32 { self.echo.process(x) } }\n\
         pub struct Mirror { shown: [f32; 4], at: usize }\nimpl Mirror {\n\
         pub fn process(&mut self, x: f32) { self.shown[0] = x; self.at = self.shown.len(); } }\n\
         pub fn run(mut space: Diffuse, mut session: Session, mut mirror: Mirror) {\n\
         loop { space.process(1.0); session.process(1.0); mirror.process(1.0); } }\n";
    let file = written_for("init_composites", code);
    assert!(file.contains("type = \"crate::Delay\"") && file.contains("type = \"crate::Diffuse\""), "{file}");
    assert!(!file.contains("Session") && !file.contains("Mirror"), "{file}");
}

#[test]
fn what_retunes_the_parts_is_not_the_law() {
    let code = "pub struct Biquad { rate: f32, b0: f32, y: f32 }\nimpl Biquad {\n\
         pub fn update(&mut self, rate: f32) { if self.rate != rate { self.rate = rate; self.b0 = 0.5 * rate; } }\n\
         pub fn process(&mut self, x: f32) -> f32 { self.y += self.b0 * (x - self.y); self.y } }\n\
         pub struct BiquadBank { at: usize, parts: [Biquad; 2] }\nimpl BiquadBank {\n\
         pub fn update(&mut self, rate: f32) { for part in self.parts.iter_mut() { part.update(rate); } }\n\
         pub fn process_sample(&mut self, x: f32) -> f32 { self.parts[self.at].process(x) } }\n\
         pub fn run(mut bank: BiquadBank, xs: &[f32]) { loop { bank.update(3.0); bank.process_sample(1.0); } }\n";
    let file = written_for("init_retuned", code);
    assert!(file.contains("type = \"crate::BiquadBank\"\n#law = \"process_sample\""), "{file}");
}

#[test]
fn calls_tell_of_the_time_base_and_the_resets_of_an_unread_filter() {
    let code = "pub fn run(mut pid: drives::SpeedPid, mut low: drives::LowPass, dt: f32) {\n\
         loop { pid.reset_integral(); pid.update(1.0, dt as f64); pid.reset(); low.update(1.0); } }\n";
    let directory = workspace::temporary_package("init_unread", &[("src/lib.rs", code.as_bytes())]);
    let manifest =
        "[package]\nname = \"init_unread\"\nedition = \"2021\"\n[dependencies]\ndrives = \"1\"\n[workspace]\n";
    workspace::write(&directory, "Cargo.toml", manifest.as_bytes());
    let file = run(&directory, ["init", "--stdout", "--offline"]).stdout;
    let entry = "type = \"drives::SpeedPid\"\n#law = \"update\"\n#reset = [\"reset\"]\n#partial_reset = [\"reset_integral\"]\n\
         #time_base = \"passed\"\n";
    assert!(file.contains(entry) && file.matches("time_base").count() == 1, "{file}");
}

#[test]
fn of_a_block_and_its_samples_the_law_is_that_of_a_sample() {
    let code = |param: &str| {
        format!(
            "pub struct LowPass {{ b: f32, y: f32 }}\nimpl LowPass {{\n\
             fn filter(&mut self, x: f32) -> f32 {{ self.y += self.b * (x - self.y); self.y }}\n\
             pub fn process(&mut self, xs: {param}) -> f32 {{ for x in xs {{ self.filter(*x); }} self.y * self.b }} }}\n\
             pub fn run(mut low: LowPass, xs: {param}) {{ loop {{ low.process(xs); }} }}\n"
        )
    };
    let file = written_for("init_block", &code("&[f32]"));
    assert!(file.contains("law = \"filter\""), "{file}");
    // A vector is one measurement.
    let file = written_for("init_vector", &code("&[f32; 3]"));
    assert!(file.contains("law = \"process\""), "{file}");
}

#[test]
fn a_type_of_two_traits_gets_an_entry_of_its_own() {
    let code = "pub struct Dist { mean: f32, cov: f32 }\n\
         pub trait KalmanFilter { fn predict(&mut self, a: f32); fn update(&mut self, z: f32); }\n\
         pub trait PoseFilter { fn predict(&mut self, f: f32); fn observe(&mut self, z: f32); }\n\
         impl KalmanFilter for Dist {\n\
         fn predict(&mut self, a: f32) { self.mean = a * self.mean; self.cov = a * self.cov * a + 0.1; }\n\
         fn update(&mut self, z: f32) { let k = self.cov / (self.cov + 1.0); self.mean += k * (z - self.mean); } }\n\
         impl PoseFilter for Dist {\n\
         fn predict(&mut self, f: f32) { self.mean += f; self.cov += 0.1; }\n\
         fn observe(&mut self, z: f32) { self.mean += 0.5 * (z - self.mean); } }\n\
         pub fn run(mut d: Dist) { loop { KalmanFilter::predict(&mut d, 1.0); d.observe(0.1); } }\n";
    let directory = workspace::temporary_package("init_two_traits", &[("src/lib.rs", code.as_bytes())]);
    let accepted = run(&directory, ["init", "--stdout", "--accept"]).stdout;
    assert!(
        accepted.contains("type = \"crate::Dist\"\nlaw = [[\"predict\"], [\"observe\", \"update\"]]"),
        "{accepted}"
    );
    assert_taken(&directory, &accepted);
    assert_taken(&directory, &uncommented(&accepted));
}

#[test]
fn what_nothing_calls_is_turned_on_by_name_only() {
    let code = "pub struct Pid { i: f32, kp: f32 }\n\
         impl Pid { pub fn update(&mut self, e: f32) -> f32 { self.i += e; self.kp * self.i } }\n";
    let directory = workspace::temporary_package("init_uncalled", &[("src/lib.rs", code.as_bytes())]);
    let is_on = |run: Run| run.stdout.contains("\n[[filter]]\n");
    assert!(!is_on(run(&directory, ["init", "--stdout", "--accept"])));
    assert!(is_on(run(&directory, ["init", "--stdout", "--accept", "Pid"])));
}

#[test]
fn what_always_runs_the_law_is_no_other_form_of_it() {
    let code = |body: &str| {
        format!(
            "pub struct Kalman {{ x: f64, rate: f64 }}\nimpl Kalman {{\n\
             pub fn update_imu(&mut self, dt: f64) {{ self.x += dt * self.rate; }}\n\
             pub fn update(&mut self, m: f64, dt: f64) {{ {body} }} }}\n\
             pub fn run(mut kf: Kalman, s: f64) {{ loop {{ if s > 0.0 {{ kf.update(s, 0.1); }} else {{ kf.update_imu(0.1); }} }} }}\n"
        )
    };
    let file = written_for("init_around", &code("self.update_imu(dt); self.rate += m; self.x += m;"));
    assert!(file.contains("law = \"update_imu\""), "{file}");
    let file =
        written_for("init_beside", &code("if m > 1.0 { self.x += m * self.rate; return; } self.update_imu(dt);"));
    assert!(file.contains("law = [[\"update\", \"update_imu\"]]"), "{file}");
}

#[test]
fn a_step_in_a_parameter_is_handed_on() {
    let code = |step: &str| {
        format!(
            "pub struct Kalman {{ x: f32 }}\n\
             impl Kalman {{ pub fn predict(&mut self, rate: f32, dt: f32) -> f32 {{ self.x += dt * rate; self.x }} }}\n\
             pub struct Input {{ pub rate: f32, pub iteration_time: f32 }}\n\
             pub struct AngleController {{ roll: Kalman, own: Input }}\nimpl AngleController {{\n\
             pub fn next_output(&mut self, input: Input) -> f32 {{ self.roll.predict(input.rate, {step}) }} }}\n\
             pub fn run(mut c: AngleController, f: fn() -> Input) {{ loop {{ c.next_output(f()); }} }}\n"
        )
    };
    for (step, is_handed) in [("input.iteration_time", true), ("self.own.iteration_time", false)] {
        let file = uncommented(&written_for("init_step", &code(step)));
        assert_eq!(file.contains("law = \"next_output\"\ntime_base = \"passed\""), is_handed, "{file}");
    }
}

#[test]
fn what_does_the_same_to_the_state_is_the_same_law() {
    let code = "pub struct DelayLine { line: Vec<f32>, at: usize }\nimpl DelayLine {\n\
         pub fn process(&mut self, x: f32) -> f32 { let y = self.line[self.at]; self.line[self.at] = x; self.at = (self.at + 1) % self.line.len(); y }\n\
         pub fn tap(&self) -> f32 { self.line[self.at] }\n\
         pub fn insert(&mut self, x: f32) { self.line[self.at] = x; self.at = (self.at + 1) % self.line.len(); }\n\
         pub fn seek(&mut self, by: f32) { self.line[self.at] = 0.0; self.at += by as usize; }\n\
         pub fn flush(&mut self) { let n = self.at; self.line[n] = 0.0; self.at = n * 0; }\n}\n\
         pub fn run(mut first: DelayLine, mut second: DelayLine) {\n\
         loop { let x = first.process(1.0); let y = second.tap() + x; second.insert(y); second.seek(1.0); second.flush(); } }\n";
    let text = written_for("same_effect", code);
    assert!(text.contains("law = [[\"process\", \"insert\"]]"), "{text}");
    // What runs on the same one beside the law is a part of the step.
    let beside = code.replace("second.insert(y)", "first.insert(y)");
    let text = written_for("same_effect_beside", &beside);
    assert!(text.contains("law = \"process\""), "{text}");
}

#[test]
fn laws_of_separate_states_that_run_side_by_side_are_halves() {
    let code = |attitude: &str, round: &str| {
        format!(
            "pub struct Pid {{ height_sum: f64, tilt_sum: f64 }}\nimpl Pid {{\n\
             pub fn compute_height(&mut self, error: f64, dt: f64) -> f64 {{ self.height_sum += error * dt; self.height_sum }}\n\
             pub fn compute_tilt(&mut self, error: f64, dt: f64) -> f64 {{ self.{attitude} += error * dt; self.{attitude} }}\n\
             }}\npub fn run(mut pid: Pid, mut other: Pid) {{ loop {{ {round} }} }}\n"
        )
    };
    let beside = "let u = pid.compute_height(1.0, 0.01); pid.compute_tilt(u, 0.01);";
    let text = uncommented(&written_for("init_separate", &code("tilt_sum", beside)));
    assert!(text.contains("law = [[\"compute_height\"], [\"compute_tilt\"]]"), "{text}");
    // One state that both advance is advanced twice.
    let text = uncommented(&written_for("init_one_state", &code("height_sum", beside)));
    assert!(text.contains("law = [[\"compute_height\", \"compute_tilt\"]]"), "{text}");
    // Each on a value of its own, they may be two forms of one law.
    let apart = "pid.compute_height(1.0, 0.01); other.compute_tilt(1.0, 0.01);";
    let text = uncommented(&written_for("init_apart", &code("tilt_sum", apart)));
    assert!(text.contains("law = [[\"compute_height\", \"compute_tilt\"]]"), "{text}");
}

/// Where all targets need features that are off there is nothing to look at, and that is what is said.
#[test]
fn targets_that_need_features_are_named_as_the_reason() {
    let directory = workspace::temporary("init_required_features");
    let manifest = "[package]\nname = \"rig\"\nversion = \"0.1.0\"\nedition = \"2021\"\nautobins = false\n\n[features]\nboard = []\n\n\
                    [[bin]]\nname = \"rig\"\npath = \"src/main.rs\"\nrequired-features = [\"board\"]\n";
    workspace::write(&directory, "Cargo.toml", manifest.as_bytes());
    workspace::write(&directory, "src/main.rs", b"fn main() {}\n");
    let refused = run(&directory, ["init"]);
    refused.assert_code(101);
    for said in
        ["all of its targets need features that are off; `--all-features` turns them on", "no target is selected"]
    {
        assert!(refused.stderr.contains(said), "{}", refused.stderr);
    }
    run(&directory, ["init", "--all-features"]).assert_code(0);
}
