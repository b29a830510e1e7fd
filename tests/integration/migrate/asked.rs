//! What is asked for on the command line, and how the run ends.

use super::{binary, migrate, package, read};
use crate::fix::{commit, git, repository};
use crate::support::program::run;

/// A filter, a loop on line 8 that can be migrated, and one on line 12 that cannot.
const TWO_LOOPS: &str = "\
trait SampledFilter { fn update(&mut self); }
struct Ramp(f64);
impl SampledFilter for Ramp { fn update(&mut self) { self.0 += 0.1; } }

fn main() {
    let mut first = Ramp(0.0);
    let mut second = Ramp(0.0);
    for _ in 0..3 {
        println!(\"{}\", first.0);
        first.update();
    }
    for _ in 0..3 {
        second.update();
        println!(\"{}\", second.0);
    }
}
";

fn two_loops(name: &str) -> std::path::PathBuf {
    package(name, &[("robot".to_owned(), TWO_LOOPS.to_owned())])
}

#[test]
fn without_a_place_it_only_tells() {
    let directory = two_loops("migrate_tells");
    let said = migrate(&directory, &[]);
    said.assert_code(0).assert_stderr("src/bin/robot.rs:8: `first` in `main` can be migrated");
    said.assert_stderr("src/bin/robot.rs:12: `second` in `main`: not migrated");
    assert_eq!(binary(&directory, "robot"), TWO_LOOPS);
}

#[test]
fn a_place_is_one_loop() {
    let directory = two_loops("migrate_one_loop");
    for place in ["src/bin/robot.rs:12", "src/bin/robot.rs:14:9"] {
        migrate(&directory, &[place]).assert_code(100).assert_stderr("line 14: `second` is used here after its update");
        assert_eq!(binary(&directory, "robot"), TWO_LOOPS);
    }
    migrate(&directory, &["src/bin/robot.rs:8"]).assert_code(0).assert_stderr("migrated 1 of 1 loop");
    let text = binary(&directory, "robot");
    assert!(text.contains("begin_cycle() => first);") && text.contains("second.update();"), "{text}");
    let head = 1 + text.lines().position(|line| line.contains("for _ in")).expect("the loop is there");
    migrate(&directory, &[&format!("src/bin/robot.rs:{head}")]).assert_code(0).assert_stderr("nothing to migrate");
    assert_eq!(binary(&directory, "robot"), text);
}

#[test]
fn those_that_can_go_without_the_others_go() {
    let run = |used: &str| {
        let before = TWO_LOOPS.replace("first.update();", "first.update();\n        second.update();");
        let before = before.replace("    }\n    for _ in 0..3 {\n        second.update();\n", "");
        let before = before.replace("println!(\"{}\", second.0)", used);
        let directory = package("migrate_in_part", &[("robot".to_owned(), before)]);
        (migrate(&directory, &["--all"]), binary(&directory, "robot"))
    };
    let (said, text) = run("println!(\"{}\", second.0)");
    said.assert_stderr("migrated src/bin/robot.rs:8: `first` in `main`");
    said.assert_stderr("\n  `second` stays by hand (`--unsafe-fixes` migrates all");
    said.assert_stderr("`second` is used here after its update");
    assert!(text.contains("begin_cycle() => first);") && text.contains("second.update();"), "{text}");
    // Neither can go.
    let (said, _) = run("println!(\"{} {}\", first.0, second.0)");
    said.assert_stderr("migrated 0 of 1 loop");
}

#[test]
fn each_that_stays_has_its_reason() {
    let before = TWO_LOOPS
        .replace(
            "let mut second = Ramp(0.0);",
            "let mut second = [Ramp(0.0), Ramp(1.0)];\n    let mut third = Ramp(0.0);",
        )
        .replace(
            "first.update();",
            "first.update();\n        second[std::env::args().count() % 2].update();\n        third.update();\n        \
             println!(\"{}\", third.0);",
        )
        .replace("    }\n    for _ in 0..3 {\n        second.update();\n        println!(\"{}\", second.0);\n", "");
    let directory = package("migrate_in_part_with_reasons", &[("robot".to_owned(), before)]);
    let said = migrate(&directory, &["--all"]);
    said.assert_stderr(
        "`second[*]`, `third` stay by hand:\n    line 9: nobody can tell how often `second[*]` is updated",
    );
    said.assert_stderr("\n    line 14: `third` is used here after its update");
}

#[test]
fn a_channel_is_no_filter_of_its_own() {
    let text = "\
struct Bank([f64; 2]);

impl Bank {
    fn run(&mut self, channel: usize) { self.0[channel] *= 0.5; }
}

fn main() {
    let mut bank = Bank([1.0, 2.0]);
    for _ in 0..3 {
        bank.run(0);
        bank.run(1);
    }
    println!(\"{}\", bank.0[0] + bank.0[1]);
}
";
    let directory = package("migrate_channels", &[("robot".to_owned(), text.to_owned())]);
    let config = b"[[filter]]\ntype = \"robot::Bank\"\nlaw = \"run\"\nkey = 0\n";
    crate::support::workspace::write(&directory, "ceid-lint.toml", config);
    migrate(&directory, &["--all"]).assert_code(0).assert_stderr("line 11: `bank(1)` is one channel of a filter");
    assert_eq!(binary(&directory, "robot"), text);
    // What is wrong with the configuration has its place, and what to write.
    let config = b"[[filter]]\ntype = \"robot::Bank\"\nlaw = [\"run\"]\n";
    crate::support::workspace::write(&directory, "ceid-lint.toml", config);
    let said = migrate(&directory, &["--all"]);
    said.assert_code(101)
        .assert_stderr("ceid-lint.toml:3:")
        .assert_stderr("help: write `[[")
        .assert_stderr("nothing was migrated");
}

#[test]
fn a_law_that_chooses_a_part_is_told_as_a_law() {
    let text = "\
trait SampledFilter {
    fn update(&mut self);
}

struct Ramp(f64);

impl SampledFilter for Ramp {
    fn update(&mut self) { self.0 += 0.5; }
}

enum Either {
    Fast(Ramp),
    Slow(Ramp),
}

impl SampledFilter for Either {
    fn update(&mut self) {
        match self {
            Either::Fast(ramp) => ramp.update(),
            Either::Slow(ramp) => ramp.update(),
        }
    }
}

fn main() {
    let mut ramps = [Either::Fast(Ramp(0.0)), Either::Slow(Ramp(0.0))];
    for _ in 0..3 {
        ramps[0].update();
        ramps[1].update();
    }
}
";
    let directory = package("migrate_law_of_choices", &[("robot".to_owned(), text.to_owned())]);
    migrate(&directory, &["--all"]).assert_stderr("`update` is the law of a filter itself: implement ceid-core's");
}

#[test]
fn what_can_go_brings_the_dependency_where_the_others_cannot() {
    let before = TWO_LOOPS
        .replace("let mut second = Ramp(0.0);", "let mut second = [Ramp(0.0), Ramp(1.0)];")
        .replace("first.update();", "first.update();\n        second[std::env::args().count() % 2].update();")
        .replace("    }\n    for _ in 0..3 {\n        second.update();\n        println!(\"{}\", second.0);\n", "");
    let directory = package("migrate_in_part_with_dependency", &[("robot".to_owned(), before)]);
    let manifest = read(&directory.join("Cargo.toml"));
    let (without, _) = manifest.split_once("\n[dependencies]").expect("the package depends on ceid-core");
    crate::support::workspace::write(&directory, "Cargo.toml", without.as_bytes());
    let core = crate::support::root().join("ceid-core");
    let said = migrate(&directory, &["--all", "--ceid-core-path", &core.to_string_lossy()]);
    said.assert_code(0).assert_stderr("migrated src/bin/robot.rs:8: `first` in `main`");
    said.assert_stderr("`second[*]` stays by hand:");
    assert!(read(&directory.join("Cargo.toml")).contains("[dependencies]\nceid-core = { path ="));
}

#[test]
fn a_place_is_one_loop_of_two_with_the_same_filter() {
    let text = TWO_LOOPS.replace("second", "first").replace("    let mut first = Ramp(0.0);\n", "");
    let text = text.replace("fn main() {\n", "fn main() {\n    let mut first = Ramp(0.0);\n");
    let text = text.replace(
        "        first.update();\n        println!(\"{}\", first.0);\n",
        "        println!(\"{}\", first.0);\n        first.update();\n",
    );
    for (name, line) in [("migrate_first_of_two", 7), ("migrate_second_of_two", 11)] {
        let directory = package(name, &[("robot".to_owned(), text.clone())]);
        migrate(&directory, &[&format!("src/bin/robot.rs:{line}")])
            .assert_code(0)
            .assert_stderr("migrated 1 of 1 loop");
        let after = binary(&directory, "robot");
        let guard = after.find("ceid!").expect("there is a guard");
        let by_hand = after.find("first.update();").expect("one loop is left");
        assert_eq!(after.matches("first.update();").count(), 1, "{after}");
        assert_eq!(guard < by_hand, line == 7, "{after}");
    }
}

#[test]
fn a_place_that_is_no_loop_is_wrong() {
    let directory = two_loops("migrate_no_loop");
    migrate(&directory, &["src/bin/robot.rs:2"]).assert_code(2).assert_stderr("no control cycle at line 2");
    migrate(&directory, &["src/bin/robot.rs"]).assert_code(2).assert_stderr("is not FILE:LINE");
    migrate(&directory, &["src/bin/no.rs:2"]).assert_code(2).assert_stderr("there is no file `src/bin/no.rs`");
    migrate(&directory, &["--all", "src/bin/robot.rs:8"]).assert_code(2).assert_stderr("leave out the places");
}

/// Only `--all` and places write; where to look is another question, and has the flags that it has everywhere.
#[test]
fn flags_for_the_scope_write_nothing() {
    let directory = two_loops("migrate_scope");
    for scope in [&["--workspace"][..], &["-p", "migrate_scope"], &["--workspace", "--bins"], &[]] {
        let said = migrate(&directory, scope);
        said.assert_code(0).assert_stderr("`--all` all that can be");
        assert_eq!(binary(&directory, "robot"), TWO_LOOPS, "{scope:?}");
    }
    migrate(&directory, &["--workspace", "--diff"]).assert_code(0);
    assert_eq!(binary(&directory, "robot"), TWO_LOOPS);
    migrate(&directory, &["--workspace", "--all", "--diff"])
        .assert_code(100)
        .assert_stderr("would migrate 1 of 2 loops");
    migrate(&directory, &["--workspace", "--exclude", "migrate_scope", "--all"]).assert_code(0);
    assert_eq!(binary(&directory, "robot"), TWO_LOOPS);
    migrate(&directory, &["--workspace", "src/bin/robot.rs:8"]).assert_code(0).assert_stderr("migrated 1 of 1 loop");
}

#[test]
fn what_stays_is_told_by_what_is_done_with_it() {
    let text = "\
trait SampledFilter { fn update(&mut self); }
#[derive(Clone, Copy, PartialEq)]
struct Temp { raw: i32, value: i32 }
impl SampledFilter for Temp { fn update(&mut self) { self.value += (self.raw - self.value) / 2; } }
fn watch(raw: &[i32]) -> usize {
    let (mut temp, mut met) = (Temp { raw: 0, value: 0 }, 0);
    let limit = Temp { raw: 3, value: 2 };
    for raw in raw {
        temp.raw = *raw;
        met += usize::from(temp == limit);
        temp.update();
    }
    met
}
fn shared(temp: &std::sync::RwLock<Temp>, raw: &[i32]) {
    for raw in raw {
        if let Ok(mut temp) = temp.write() {
            temp.raw = *raw;
            temp.update();
        }
    }
}
// ceid: cycle
fn first(temp: &mut Temp, raw: i32) -> i32 {
    temp.raw = raw;
    let before = temp.value;
    temp.update();
    before
}
fn main() {
    shared(&std::sync::RwLock::new(Temp { raw: 0, value: 0 }), &[1]);
    println!(\"{} {}\", watch(&[4, 4, 3]), first(&mut Temp { raw: 0, value: 0 }, 1));
}
";
    let directory = package("migrate_stays", &[("robot".to_owned(), text.to_owned())]);
    let said = migrate(&directory, &["--all"]);
    said.assert_stderr(
        "`limit` stays as it is:\n    line 7: nothing updates `limit` in the cycle: if a guard should, write `mut limit` here",
    );
    said.assert_stderr("with `let mut filter = temp.write().unwrap();` as its first statement");
    said.assert_stderr("the name `before` goes with the update, and its value stands at the end (line 26)");
    super::compiled::cargo(&directory, &["check", "--quiet"]);
}

#[test]
fn a_diff_writes_nothing() {
    let directory = two_loops("migrate_diff");
    let said = migrate(&directory, &["--all", "--diff"]);
    said.assert_code(100).assert_stderr("would migrate 1 of 2 loops");
    assert!(said.stdout.contains("-        first.update();\n"), "{}", said.stdout);
    assert_eq!(binary(&directory, "robot"), TWO_LOOPS);
    migrate(&directory, &["src/bin/robot.rs:8"]).assert_code(0);
    migrate(&directory, &["--all", "--diff"]).assert_code(0);
}

#[test]
fn a_dirty_tree_is_left_alone() {
    let manifest = b"[workspace]\n\n[package]\nname = \"dirty\"\nversion = \"0.0.0\"\nedition = \"2024\"\n";
    let directory = repository("migrate_dirty", &[("src/main.rs", TWO_LOOPS.as_bytes()), ("Cargo.toml", manifest)]);
    let changed = format!("{TWO_LOOPS}\n// changed\n");
    crate::support::workspace::write(&directory, "src/main.rs", changed.as_bytes());
    let said = run(&directory, ["migrate", "--all"]);
    said.assert_code(101).assert_stderr("src/main.rs (dirty)").assert_stderr("cargo ceid-lint migrate");
    assert_eq!(read(&directory.join("src/main.rs")), changed);
    commit(&directory);
    run(&directory, ["migrate", "--all"]).assert_code(0);
    assert_eq!(git(&directory, &["status", "--porcelain"]), " M Cargo.toml\n M src/main.rs\n");
    let version = format!("ceid-core = \"{}\"\n", env!("CARGO_PKG_VERSION"));
    assert!(read(&directory.join("Cargo.toml")).ends_with(&format!("\n\n[dependencies]\n{version}")));
}

/// A filter that every other cycle leaves out, and nothing else.
const GATED: &str = "\
trait SampledFilter { fn update(&mut self); }
struct Ramp(f64);
impl SampledFilter for Ramp { fn update(&mut self) { self.0 += 0.1; } }

fn main() {
    let mut slow = Ramp(0.0);
    for step in 0..9 {
        if step % 2 == 0 {
            slow.update();
        }
    }
    println!(\"{}\", slow.0);
}
";

#[test]
fn a_named_loop_that_skips_on_purpose_says_so() {
    let directory = package("migrate_gated", &[("robot".to_owned(), GATED.to_owned())]);
    let said = migrate(&directory, &["src/bin/robot.rs:7"]);
    said.assert_code(100).assert_stderr("src/bin/robot.rs:7: `main`: not migrated");
    said.assert_stderr("`slow` runs at a slower rate").assert_stderr("`Divider`");
    // So does the list of what could be done.
    migrate(&directory, &[]).assert_code(0).assert_stderr("`slow` runs at a slower rate");
    let all = migrate(&directory, &["--all"]);
    all.assert_code(0).assert_stderr("nothing to migrate").assert_stderr("`slow` runs at a slower rate");
    assert_eq!(binary(&directory, "robot"), GATED);
}

#[test]
fn a_loop_that_resets_is_named_and_counted() {
    let resetting = "    let mut third = Ramp(0.0);\n    for step in 0..9 {\n        if step == 4 {\n            third = Ramp(0.0);\n            \
                     continue;\n        }\n        third.update();\n    }\n}\n";
    let text = format!("{}{resetting}", TWO_LOOPS.strip_suffix("}\n").expect("it ends so"));
    let directory = package("migrate_resetting", &[("robot".to_owned(), text)]);
    let said = migrate(&directory, &["--all"]);
    said.assert_code(0).assert_stderr("migrated 1 of 3 loops");
    said.assert_stderr("src/bin/robot.rs:17: `main`: not migrated")
        .assert_stderr("`third` is reset instead of updated");
}

#[test]
fn a_panic_is_told() {
    let text = TWO_LOOPS.replace("println!(\"{}\", first.0);", "assert!(first.0 < 9.0);");
    let directory = package("migrate_panic", &[("robot".to_owned(), text)]);
    migrate(&directory, &["src/bin/robot.rs:8"])
        .assert_code(0)
        .assert_stderr("the law of `first` runs as well where the iteration panics (line 9)");
}

#[test]
fn the_other_text_of_a_panic_is_told() {
    let text = "\
trait SampledFilter { fn update(&mut self); }
struct Ramp(f64);
impl SampledFilter for Ramp { fn update(&mut self) { self.0 += 0.1; } }
struct Lift { ramp: Ramp }
impl Lift {
    fn run(&mut self) {
        for _ in 0..3 {
            ASSERTION;
            self.ramp.update();
        }
    }
}
fn main() {
    Lift { ramp: Ramp(0.0) }.run();
}
";
    let told = |name: &str, assertion: &str| {
        let text = text.replace("ASSERTION", assertion);
        migrate(&package(name, &[("robot".to_owned(), text)]), &["--all"]).assert_code(0).stderr.clone()
    };
    let words = "`assert!` panics, it tells of `ramp` instead of `self.ramp` (line 8)";
    let said = told("migrate_assertion", "assert!(self.ramp.0 < 9.0)");
    assert!(said.contains(words) && said.contains("migrated 1 of 1 loop"), "{said}");
    let said = told("migrate_assertion_text", "assert!(self.ramp.0 < 9.0, \"too high\")");
    assert!(!said.contains("instead of") && said.contains("migrated 1 of 1 loop"), "{said}");
}

#[test]
fn a_dependency_keeps_the_name_that_the_manifest_gives_it() {
    let directory = two_loops("migrate_renamed");
    let manifest = read(&directory.join("Cargo.toml"));
    let renamed = manifest.replace("ceid-core = { path", "guard = { package = \"ceid-core\", path");
    crate::support::workspace::write(&directory, "Cargo.toml", renamed.as_bytes());
    migrate(&directory, &["--all"]).assert_code(0).assert_stderr("migrated 1 of 2 loops");
    let text = binary(&directory, "robot");
    assert!(text.contains("guard::ceid!(clock.begin_cycle() => first);") && !text.contains("ceid_core"), "{text}");
    assert_eq!(read(&directory.join("Cargo.toml")), renamed);
}

#[test]
fn a_manifest_may_deny_names_without_a_use() {
    let case = read(&super::cases().join("refused/leaves_a_name_without_a_use.rs"));
    let text = case.replace("#![deny(unused_variables)]\n", "");
    for (name, lints) in [("denied", "unused = { level = \"deny\", priority = -1 }"), ("told", "unused = \"warn\"")] {
        let directory = package(&format!("migrate_names_{name}"), &[("robot".to_owned(), text.clone())]);
        let manifest = format!("{}\n[lints.rust]\n{lints}\n", read(&directory.join("Cargo.toml")));
        crate::support::workspace::write(&directory, "Cargo.toml", manifest.as_bytes());
        let said = migrate(&directory, &["--all"]);
        match name {
            "denied" => said
                .assert_code(0)
                .assert_stderr("nothing but the updates uses `count`, and the crate denies what has no use"),
            _ => said.assert_code(0).assert_stderr("`count` has no use any more"),
        };
        assert_eq!(binary(&directory, "robot") == text, name == "denied");
    }
}

#[test]
fn what_a_killed_run_left_is_no_change() {
    let manifest = b"[workspace]\n\n[package]\nname = \"killed\"\nversion = \"0.0.0\"\nedition = \"2024\"\n";
    let directory = repository("migrate_killed", &[("src/main.rs", TWO_LOOPS.as_bytes()), ("Cargo.toml", manifest)]);
    // The first process of every system is there, and is another program.
    crate::support::workspace::write(&directory, "src/.ceid-lint-1-2.tmp", b"new");
    run(&directory, ["migrate", "--all"]).assert_code(0).assert_stderr("migrated 1 of 2 loops");
    assert!(!directory.join("src/.ceid-lint-1-2.tmp").exists());
}

#[test]
fn a_function_is_no_law_of_a_type() {
    let text = "\
struct State(f64);
fn low_pass(state: &mut State) { state.0 *= 0.5; }

fn main() {
    let mut state = State(8.0);
    for _ in 0..3 {
        low_pass(&mut state);
    }
    println!(\"{}\", state.0);
}
";
    let directory = package("migrate_function", &[("robot".to_owned(), text.to_owned())]);
    let config = b"[[filter]]\nfunction = \"robot::low_pass\"\ninstance = \"arg(0)\"\n";
    crate::support::workspace::write(&directory, "ceid-lint.toml", config);
    migrate(&directory, &["--all"]).assert_code(0).assert_stderr("the law of `state` is a function");
}

#[test]
fn a_form_of_rustfmt_is_kept() {
    let text = "\
trait SampledFilter {
    fn update(&mut self);
}

struct Ramp {
    height: f64,
}

impl SampledFilter for Ramp {
    fn update(&mut self) {
        self.height += 0.1;
    }
}

struct Robot {
    left_shoulder: Ramp,
}

impl Robot {
    fn run(&mut self) -> Vec<f64> {
        let mut heights = Vec::new();
        for step in 0..3 {
            let scale = if step > 1 { 2.0 } else { 1.0 };
            let sum =
                0.5 * self.left_shoulder.height - scale * self.left_shoulder.height;
            heights.push(sum);
            self.left_shoulder.update();
        }
        heights
    }
}

fn main() {
    let left_shoulder = Ramp { height: 0.0 };
    println!(\"{:?}\", Robot { left_shoulder }.run());
}
";
    // A narrow width is the form of this crate.
    let of_crate = b"max_width = 84\n";
    let directory = package("migrate_form", &[("robot".to_owned(), text.to_owned())]);
    crate::support::workspace::write(&directory, "rustfmt.toml", of_crate);
    migrate(&directory, &["--all"]).assert_code(0).assert_stderr("migrated 1 of 1 loop");
    let after = binary(&directory, "robot");
    let line = "            let sum = 0.5 * left_shoulder.height - scale * left_shoulder.height;\n";
    assert!(after.contains(line), "{after}");
    // What had another form keeps that.
    let other = text.replace("let scale = ", "let scale =  ");
    let directory = package("migrate_other_form", &[("robot".to_owned(), other)]);
    crate::support::workspace::write(&directory, "rustfmt.toml", of_crate);
    migrate(&directory, &["--all"]).assert_code(0).assert_stderr("migrated 1 of 1 loop");
    let after = binary(&directory, "robot");
    assert!(after.contains("let scale =  if") && after.contains("let sum =\n"), "{after}");
}

#[test]
fn a_second_loop_finds_another_name() {
    let text = "\
trait SampledFilter { fn update(&mut self, height: f64); }
struct Ramp(f64);
impl SampledFilter for Ramp { fn update(&mut self, height: f64) { self.0 += height; } }

fn main() {
    let mut ramp = Ramp(0.0);
    for height in [1.0, 2.0] {
        ramp.update(height);
    }
    for height in [3.0, 4.0] {
        ramp.update(height);
    }
    println!(\"{}\", ramp.0);
}
";
    let directory = package("migrate_second_loop", &[("robot".to_owned(), text.to_owned())]);
    migrate(&directory, &["src/bin/robot.rs:10"]).assert_code(0).assert_stderr("migrated 1 of 1 loop");
    migrate(&directory, &["src/bin/robot.rs:7"]).assert_code(0).assert_stderr("migrated 1 of 1 loop");
    let after = binary(&directory, "robot");
    assert!(after.contains("=> ramp = fed_ramp_2);") && after.contains("=> ramp = fed_ramp);"), "{after}");
}

#[test]
fn the_path_of_another_package_is_wrong() {
    let directory = two_loops("migrate_wrong_core");
    for (path, why) in
        [(".", "the package in `.` is not `ceid-core`"), ("src", "is not a directory with a `Cargo.toml`")]
    {
        migrate(&directory, &["--all", "--ceid-core-path", path]).assert_code(2).assert_stderr(why);
    }
    assert_eq!(binary(&directory, "robot"), TWO_LOOPS);
}

#[test]
fn a_law_of_the_configuration_is_run_by_guards_and_no_cycle() {
    let text = TWO_LOOPS.replace("trait SampledFilter { fn update(&mut self); }\n", "");
    let text = text.replace("impl SampledFilter for Ramp { fn update", "impl Ramp { fn rise").replace("update", "rise");
    let directory = package("migrate_configured", &[("robot".to_owned(), text)]);
    let config = b"[[filter]]\ntype = \"robot::Ramp\"\nlaw = \"rise\"\n";
    crate::support::workspace::write(&directory, "ceid-lint.toml", config);
    let cycles = |text: &str| text.lines().filter(|line| line.starts_with("src/bin/robot.rs:")).count();
    let before = run(&directory, ["report"]);
    migrate(&directory, &["--all"]).assert_code(0).assert_stderr("migrated 1 of 2 loops");
    let after = run(&directory, ["report"]);
    assert_eq!((cycles(&before.stdout), cycles(&after.stdout)), (2, 2), "{}", after.stdout);
}

/// A loop whose second update is a mistake that is allowed.
const ALLOWED: &str = "\
trait SampledFilter { fn update(&mut self); }
struct Ramp(f64);
impl SampledFilter for Ramp { fn update(&mut self) { self.0 += 0.1; } }

fn main() {
    let mut ramp = Ramp(0.0);
    // ceid: allow(repeated_update, reason = \"a known mistake\")
    for _ in 0..3 {
        println!(\"{}\", ramp.0);
        ramp.update();
        ramp.update();
    }
}
";

#[test]
fn a_suppression_goes_with_what_it_hides() {
    let directory = package("migrate_suppressed", &[("robot".to_owned(), ALLOWED.to_owned())]);
    let said = migrate(&directory, &["--all", "--unsafe-fixes"]);
    said.assert_code(0).assert_stderr("migrated 1 of 1 loop");
    said.assert_stderr("src/bin/robot.rs: a suppression was removed that hides nothing any more");
    let text = binary(&directory, "robot");
    assert!(text.contains("begin_cycle() => ramp);") && !text.contains("allow(repeated_update"), "{text}");
}

#[test]
fn a_dependency_that_is_not_always_there_is_told_at_once() {
    for (name, before, after) in [
        ("migrate_optional", "\" }", "\", optional = true }"),
        ("migrate_for_targets", "[dependencies]", "[target.'cfg(windows)'.dependencies]"),
    ] {
        let directory = two_loops(name);
        let manifest = read(&directory.join("Cargo.toml")).replace(before, after);
        crate::support::workspace::write(&directory, "Cargo.toml", manifest.as_bytes());
        let said = migrate(&directory, &[]);
        said.assert_code(0).assert_stderr("src/bin/robot.rs:8: `first` in `main`: not migrated");
        assert!(!said.stderr.contains("can be migrated"), "{}", said.stderr);
    }
}

/// A loop whose law is imported for it and for code that other systems compile.
const CONDITIONAL: &str = "\
mod law { pub trait SampledFilter { fn update(&mut self); } }
#[path = \"../ramp.rs\"]
mod ramp;
use law::SampledFilter;
use ramp::Ramp;

#[cfg(target_os = \"none\")]
pub fn once(ramp: &mut Ramp) {
    ramp.update();
}

#[cfg(windows)]
pub fn twice(ramp: &mut Ramp) {
    ramp.update();
    ramp.update();
}

fn main() {
    let mut ramp = Ramp(0.0);
    for _ in 0..3 {
        println!(\"{}\", ramp.0);
        ramp.update();
    }
}
";

#[test]
fn an_import_for_conditional_code_is_told() {
    let directory = package("migrate_conditional_import", &[("robot".to_owned(), CONDITIONAL.to_owned())]);
    let ramp = "pub struct Ramp(pub f64);\nimpl crate::law::SampledFilter for Ramp { fn update(&mut self) { self.0 += 0.1; } }\n";
    crate::support::workspace::write(&directory, "src/ramp.rs", ramp.as_bytes());
    let said = migrate(&directory, &["--all"]);
    said.assert_code(0).assert_stderr("migrated 1 of 1 loop");
    said.assert_stderr(
        "src/bin/robot.rs:4: `SampledFilter` is imported, and perhaps only code under `#[cfg(…)]` needs it",
    );
}

#[test]
fn a_glob_of_tests_is_no_import_for_the_law() {
    let tests = "\n#[cfg(test)]\nmod tests {\n    use super::*;\n\n    #[test]\n    fn starts_at_zero() {\n        assert_eq!(Ramp(0.0).0, 0.0);\n    }\n}\n";
    let directory = package("migrate_glob_of_tests", &[("robot".to_owned(), format!("{TWO_LOOPS}{tests}"))]);
    let said = migrate(&directory, &["--all"]);
    said.assert_code(0).assert_stderr("migrated 1 of 2 loops");
    assert!(!said.stderr.contains("is imported"), "{}", said.stderr);
}

/// A loop whose type is given its law by the loop above it.
const ONE_BEHIND_THE_OTHER: &str = "\
trait SampledFilter { fn update(&mut self); }
struct Ramp { input: f64, output: f64 }
impl SampledFilter for Ramp { fn update(&mut self) { self.output = self.input; } }
impl Ramp { fn update(&mut self) { self.output = self.input + 1.0; } }

fn alone(ramp: &mut Ramp) {
    for step in 0..3 {
        ramp.input = f64::from(step);
        ramp.update();
    }
}

fn beside(ramp: &mut Ramp, other: &mut Ramp) {
    for step in 0..3 {
        ramp.input = f64::from(step);
        other.input = f64::from(step);
        ramp.update();
        SampledFilter::update(other);
    }
}

fn main() {
    let (mut ramp, mut other) = (Ramp { input: 0.0, output: 0.0 }, Ramp { input: 0.0, output: 0.0 });
    alone(&mut ramp);
    beside(&mut ramp, &mut other);
    println!(\"{} {}\", ramp.output, other.output);
}
";

#[test]
fn what_is_told_of_a_loop_is_what_was_done_to_it() {
    let directory = package("migrate_told", &[("robot".to_owned(), ONE_BEHIND_THE_OTHER.to_owned())]);
    let said = migrate(&directory, &["--all"]);
    said.assert_code(0);
    let text = binary(&directory, "robot");
    let guards = text.matches("ceid!(").count();
    said.assert_stderr(&format!("migrated {guards} of 2 loops"));
    assert_eq!(said.stderr.contains("`beside`: not migrated"), guards < 2, "{}\n{text}", said.stderr);
}

#[test]
fn a_law_that_takes_its_filter_shared_needs_a_variable_that_can_be_lent() {
    let text = "\
struct Pid(std::cell::Cell<f64>);
impl Pid { fn compute(&self, error: f64) -> f64 { self.0.set(self.0.get() + error); self.0.get() } }
fn main() {
    let pid = Pid(std::cell::Cell::new(0.0));
    for error in [1.0, 2.0] {
        pid.compute(error);
    }
    println!(\"{}\", pid.0.get());
}
";
    let check = |name: &str, text: String, said: &str| {
        let directory = package(name, &[("robot".to_owned(), text)]);
        let config = b"[[filter]]\ntype = \"robot::Pid\"\nlaw = \"compute\"\nreceiver = \"shared\"\n";
        crate::support::workspace::write(&directory, "ceid-lint.toml", config);
        migrate(&directory, &["--all"]).assert_code(0).assert_stderr(said);
        super::compiled::cargo(&directory, &["check", "--quiet"]);
    };
    check("migrate_shared", text.to_owned(), "line 4: `pid` is lent to the guard mutably, and is not declared so");
    check(
        "migrate_shared_mut",
        text.replace("let pid", "#[allow(unused_mut)]\n    let mut pid"),
        "migrated 1 of 1 loop",
    );
    let owned = "impl Own { fn run(&self) { for error in [1.0, 2.0] { self.pid.compute(error); } } }\n";
    let main = "struct Own { pid: Pid }\nfn main() { Own { pid: Pid(std::cell::Cell::new(0.0)) }.run(); }\n";
    let text = format!("{}{owned}{main}", &text[..text.find("fn main").unwrap_or_default()]);
    check("migrate_shared_owner", text, "`self` is a shared reference, and a guard changes what it holds");
}

#[test]
fn helpers_that_nothing_calls_are_migrated_by_name_only() {
    let code = "\
pub trait SampledFilter { fn update(&mut self); }
pub struct Ramp { at: f64, seen: f64 }
impl SampledFilter for Ramp { fn update(&mut self) { self.at += 0.1 * (self.seen - self.at); } }
pub struct Rig { ramp: Ramp }

pub fn lent(ramp: &mut Ramp, seen: f64) {
    ramp.seen = seen;
    ramp.update();
}

impl Rig {
    pub fn tick(&mut self, seen: f64) {
        self.ramp.seen = seen;
        self.ramp.update();
    }
}

// ceid: cycle
pub fn told(ramp: &mut Ramp, seen: f64) {
    ramp.seen = seen;
    ramp.update();
}
fn main() {}
";
    let directory = package("migrate_helpers", &[("rig".to_owned(), code.to_owned())]);
    let said = migrate(&directory, &["--all"]);
    said.assert_stderr(
        "src/bin/rig.rs:6: `ramp` in `lent`: not migrated\n  nothing says that it is called once per cycle",
    );
    let text = binary(&directory, "rig");
    let lent = &text[text.find("pub fn lent").expect("it is there")..text.find("impl Rig").expect("it is there")];
    assert!(lent.contains("ramp.update();"), "{text}");
    assert_eq!(text.matches(".begin_cycle()").count(), 2, "{text}");
    let line = 1 + text.lines().position(|line| line.starts_with("pub fn lent")).expect("it is there");
    migrate(&directory, &[&format!("src/bin/rig.rs:{line}")]).assert_code(0).assert_stderr("migrated 1 of 1 loop");
}
