//! The configuration: what names nothing is refused at its place, and what stands in several places is put together.

use std::path::PathBuf;
use std::sync::atomic::{AtomicU32, Ordering};

use crate::support::program::{Run, run};
use crate::support::workspace;

const CODE: &str = "\
pub mod control {
    pub struct Pid;
    impl Pid {
        pub fn calc(&mut self, value: f32) -> f32 { value }
        pub fn reset(&mut self) {}
    }
    pub trait Estimator { fn step(&mut self); }
    pub fn fir(line: &mut [f32], value: f32) -> f32 { value }
    #[cfg(feature = \"extra\")]
    pub mod extra { pub struct Lag; }
    #[cfg(feature = \"extra\")]
    impl Pid { pub fn calc_with(&mut self, value: f32, seconds: f32) -> f32 { value } }
}
pub struct Tick;
impl Tick { pub fn over(pid: &mut control::Pid) -> Self { Self } }
pub struct Gain(f32);
impl Gain { pub fn next(&self, before: f32, value: f32) -> f32 { before + self.0 * (value - before) } }
pub fn idle() {}
pub struct Robot { pub pid: control::Pid }
impl Robot { pub fn tick(&mut self) {} }
";

const MANIFEST: &str = "\
[workspace]

[package]
name = \"rover-control\"
version = \"0.0.0\"
edition = \"2024\"

[features]
extra = []

[dependencies]
pid = \"4\"
lite = { package = \"pid-lite\", version = \"1\" }
";

fn package(code: &str, configuration: &str) -> PathBuf {
    // Tests run at the same time, each in directories of its own.
    static NEXT: AtomicU32 = AtomicU32::new(0);
    let directory = workspace::temporary(&format!("configuration_{}", NEXT.fetch_add(1, Ordering::Relaxed)));
    workspace::write(&directory, "Cargo.toml", MANIFEST.as_bytes());
    workspace::write(&directory, "src/lib.rs", code.as_bytes());
    workspace::write(&directory, "ceid-lint.toml", configuration.as_bytes());
    directory
}

fn checked(configuration: &str) -> Run {
    run(&package(CODE, configuration), [""; 0])
}

/// The message, the place in the file, and the help.
#[track_caller]
fn check_refused(configuration: &str, message: &str, place: &str, help: &str) {
    let run = checked(configuration);
    run.assert_code(101).assert_stderr(message).assert_stderr(&format!("ceid-lint.toml:{place}")).assert_stderr(help);
}

#[track_caller]
fn check_accepted(configuration: &str) {
    let run = checked(configuration);
    assert!(!run.stderr.contains("error"), "{configuration}\n{}", run.stderr);
    run.assert_code(0);
}

#[test]
fn a_type_that_is_not_there_has_the_nearest_right_spelling() {
    let entry = |path: &str| format!("[[filter]]\ntype = \"{path}\"\nlaw = \"calc\"\n");
    let near = "did you mean `crate::control::Pid`?";
    check_refused(&entry("crate::control::Pidd"), "`crate::control::Pidd` names nothing", "2:8", near);
    check_refused(&entry("crate::controll::Pid"), "`crate::controll::Pid` names nothing", "2:8", near);
    check_refused(&entry("crate::Pid"), "`crate::Pid` names nothing", "2:8", near);
    check_refused(
        &entry("rover_control::control::Pi"),
        "`rover_control::control::Pi` names nothing",
        "2:8",
        "did you mean `rover_control::control::Pid`?",
    );
    check_refused(&entry("pd::Pid"), "`pd::Pid` names nothing", "2:8", "did you mean `pid::Pid`?");
    check_refused(&entry("ahrs::Madgwick"), "`ahrs::Madgwick` names nothing", "2:8", "neither a member");
}

#[test]
fn a_method_that_is_not_there_has_the_nearest_right_spelling() {
    let entry = |rest: &str| format!("[[filter]]\ntype = \"crate::control::Pid\"\n{rest}\n");
    let message = "`crate::control::Pid` has no method";
    check_refused(&entry("law = \"clac\""), message, "3:7", "did you mean `calc`?");
    check_refused(&entry("law = [[\"calc\", \"calk\"]]"), message, "3:17", "did you mean `calc`?");
    check_refused(&entry("law = \"calc\"\nreset = \"rest\""), message, "4:9", "did you mean `reset`?");
    check_refused(&entry("law = \"advance\""), message, "3:7", "it has `calc`, `reset`");
}

#[test]
fn a_macro_that_cannot_be_read_gives_methods_to_what_it_names() {
    let entry = "[[filter]]\ntype = \"crate::control::Pid\"\nlaw = \"clac\"\n";
    let with = |item: &str| run(&package(&format!("{CODE}\n{item}\n"), entry), [""; 0]);
    for item in ["lite::flags! { struct Mode: u8 { const ARMED = 1; } }", "lite::laws!(Robot);"] {
        with(item).assert_code(101).assert_stderr("`crate::control::Pid` has no method `clac`");
    }
    for item in [
        "lite::laws!(control::Pid);",
        "use control::Pid as Regulator; lite::laws!(Regulator);",
        "impl control::Pid { lite::laws!(clac); }",
        "lite::all_laws!();",
    ] {
        with(item).assert_code(0);
    }
}

#[test]
fn what_a_function_of_an_unread_type_gives_is_a_filter_where_it_is_used_as_one() {
    let code = "\
pub fn run(read: fn() -> f32, write: fn(f32)) {
    let mut low = pid::Pid::lowpass(1.0);
    loop {
        let bound = pid::Pid::limit(read(), 1.0);
        write(low.calc(read(), bound));
    }
}
";
    let run = run(&package(code, "[[filter]]\ntype = \"pid::Pid\"\nlaw = \"calc\"\n"), [""; 0]);
    run.assert_code(0);
    let said = format!("{}{}", run.stdout, run.stderr);
    assert!(said.contains("1 proved") && !said.contains("unregistered_filter"), "{said}");
}

/// The pairs of each loop of a function with one statement before its loop, under an entry for a type that is not read.
#[track_caller]
fn check_unread(before: &str, cycle: &str, expected: &[&str]) {
    let code = format!("pub fn run(mut pid: pid::Pid, read: fn() -> f32) {{\n{before}\nloop {{ {cycle} }}\n}}\n");
    let entry = "[[filter]]\ntype = \"pid::Pid\"\nlaw = \"calc\"\nreset = \"clear\"\n";
    let run = run(&package(&code, entry), ["report", "--message-format", "json"]);
    let pairs = run.pairs().unwrap_or_else(|error| panic!("{error}"));
    let found: Vec<String> = pairs.iter().map(|pair| format!("{} {}", pair.name, pair.verdict)).collect();
    assert_eq!(found, expected, "{before} {cycle}");
}

#[test]
fn what_a_constructor_of_an_unread_type_gives_is_a_filter() {
    let one = "pid.calc(read());";
    for made in ["new()", "default()", "with_gain(2.0)", "from_gain(2.0)", "try_new(2.0).unwrap()"] {
        check_unread(&format!("let mut other = pid::Pid::{made};"), one, &["other missed", "pid once"]);
    }
    check_unread("let mut other = pid::Pid::builder().gain(1.0).build();", one, &["other missed", "pid once"]);
}

#[test]
fn what_else_an_unread_type_gives_is_a_filter_where_its_law_is_called() {
    let one = "pid.calc(read());";
    for made in ["order()", "suggested_gain(0.5)", "tuning()?", "builder().observers().build()", "builder()"] {
        check_unread(&format!("let other = pid::Pid::{made};"), one, &["pid once"]);
        check_unread(&format!("let other = pid::Pid::{made};"), "pid.calc(other);", &["pid once"]);
    }
    let twice = "pid.calc(read()); other.calc(read()); other.calc(read());";
    for made in ["lowpass(0.5)", "lowpass(0.5).unwrap()", "builder().defaults().build()"] {
        check_unread(&format!("let mut other = pid::Pid::{made};"), twice, &["other repeated", "pid once"]);
    }
    let builder = "let mut builder = pid::Pid::builder(); builder.gain(1.0); let mut other = builder.build();";
    check_unread(builder, "pid.calc(read()); other.calc(read());", &["other once", "pid once"]);
}

#[test]
fn a_setter_of_an_unread_type_gives_its_filter_back() {
    check_unread("", "pid.gain(1.0).calc(read());", &["pid once"]);
    check_unread("", "pid.gain(1.0).calc(read()); pid.calc(read());", &["pid repeated"]);
    check_unread("", "pid.clear().calc(read()); pid.calc(read());", &["pid repeated"]);
    check_unread("", "let set = pid.gain(1.0); set.calc(read()); set.calc(read());", &["pid repeated"]);
    // What is given nothing may give another one that has a method of that name.
    check_unread("", "pid.inner().calc(read()); pid.calc(read());", &["pid unproved"]);
    check_unread("", "pid.calc(read()).calc(1.0);", &["pid unproved"]);
    check_unread("", "if pid.calc(read()).abs() > 1.0 { pid.gain(1.0); }", &["pid once"]);
}

#[test]
fn what_a_field_of_an_unread_type_holds_is_read_and_leaves_the_filter_where_it_is() {
    let before = "let mut other = pid::Pid::new(1.0);";
    check_unread(before, "pid.calc(pid::Number::from_num(other.last));", &["other missed", "pid once"]);
    let both = "pid.calc(pid::Number::from_num(other.last)); other.calc(read());";
    check_unread(before, both, &["other once", "pid once"]);
    // What is lent may be updated.
    check_unread(before, "pid.calc(pid::Number::of(&mut other));", &["other unproved", "pid once"]);
}

#[test]
fn a_file_beside_a_member_is_told_to_be_unread() {
    let directory = package(CODE, "");
    workspace::write(&directory, "Cargo.toml", b"[workspace]\nmembers = [\"arm\"]\nresolver = \"3\"\n");
    workspace::write(&directory, "arm/Cargo.toml", b"[package]\nname = \"arm\"\nedition = \"2024\"\n");
    workspace::write(&directory, "arm/src/lib.rs", b"");
    let said = "`arm/ceid-lint.toml` is not read";
    assert!(!run(&directory, [""; 0]).stderr.contains(said));
    workspace::write(&directory, "arm/ceid-lint.toml", b"presets = \"none\"\n");
    run(&directory, [""; 0]).assert_stderr(said).assert_stderr("`arm/Cargo.toml`");
}

#[test]
fn an_argument_that_no_call_of_the_law_has_is_refused() {
    let entry = |rest: &str| format!("[[filter]]\ntype = \"crate::control::Pid\"\nlaw = \"calc\"\n{rest}\n");
    let only_one = "`calc` has only argument 0";
    check_refused(&entry("instance = \"arg(1)\""), "`calc` has no `arg(1)`", "4:12", only_one);
    check_refused(&entry("key = 3"), "`calc` has no argument 3", "4:7", only_one);
    check_refused(&entry("key = [0, 3]"), "`calc` has no argument 3", "4:11", only_one);
    check_refused(&entry("instance = \"returned\""), "`calc` does not return a state", "4:12", "`receiver`");
    check_refused(
        "[[filter]]\ntype = \"crate::control::Pid\"\nlaw = \"reset\"\ninstance = \"returned\"\n",
        "`reset` does not return a state",
        "4:12",
        "",
    );
    check_refused(
        "[[filter]]\ntrait = \"crate::control::Estimator\"\nlaw = \"step\"\ninstance = \"arg(0)\"\n",
        "`step` has no `arg(0)`",
        "4:12",
        "takes no argument",
    );
    check_refused("[[filter]]\nfunction = \"crate::idle\"\n", "`idle` has no `arg(0)`", "2:12", "takes no argument");
    let plain = "`arg(0)` of `calc` is a plain `f32`, which keeps no state";
    check_refused(&entry("instance = \"arg(0)\""), plain, "4:12", "taken as `&mut`");
    check_refused(
        "[[filter]]\ntype = \"crate::Tick\"\nlaw = \"over\"\n",
        "`over` takes no `self` that could be the state",
        "2:8",
        "`arg(0)` for the first argument",
    );
    check_accepted("[[filter]]\ntype = \"crate::Tick\"\nlaw = \"over\"\ninstance = \"arg(0)\"\n");
    check_accepted(&entry("key = 0"));
    check_accepted("[[filter]]\nfunction = \"crate::control::fir\"\ninstance = \"arg(0)\"\n");
    let never = "`calc` gives no `Result`, so that it cannot fail";
    check_refused(&entry("on_err = \"untouched\""), never, "4:10", "take `on_err` out");
    // What a build leaves out may have other arguments.
    check_accepted("[[filter]]\ntype = \"crate::control::Pid\"\nlaw = \"calc_with\"\ninstance = \"arg(3)\"\n");
    // A number that is given back may be the state of a law that keeps none in `self`.
    check_accepted("[[filter]]\ntype = \"crate::Gain\"\nlaw = \"next\"\ninstance = \"returned\"\n");
}

#[test]
fn patterns_of_files_are_read_as_paths() {
    check_refused("exclude = [\"src/[gen/**\"]\n", "`src/[gen/**` has a `[` that nothing closes", "1:12", "`[[]`");
    let each = "write a pattern for each: \"src/gen/**\", \"src/old/**\"";
    check_refused("exclude = [\"src/{gen,old}/**\"]\n", "has a choice in braces", "1:12", each);
    let guilty = format!("{CODE}\n{}", workspace::GUILTY);
    for pattern in ["./src/**", "src/**", "src/[k-m]ib.rs"] {
        let found = run(&package(&guilty, &format!("exclude = [\"{pattern}\"]\n")), [""; 0]);
        assert!(!found.assert_code(0).stderr.contains("repeated_update"), "{pattern}");
    }
}

#[test]
fn a_thing_of_another_kind_is_told() {
    check_refused(
        "[[filter]]\ntype = \"crate::control::Estimator\"\nlaw = \"step\"\n",
        "`crate::control::Estimator` is a trait, not a type",
        "2:8",
        "write `trait = \"crate::control::Estimator\"`",
    );
    check_refused(
        "[[filter]]\ntype = \"crate::control::fir\"\nlaw = \"fir\"\n",
        "`crate::control::fir` is a function, not a type",
        "2:8",
        "write `function = \"crate::control::fir\"`",
    );
    check_refused(
        "[[filter]]\ntype = \"crate::Gain\"\nlaw = \"over\"\ninstance = \"arg(0)\"\n",
        "`crate::Gain` has no method `over`",
        "3:7",
        "`crate::Tick` has it: an entry names the type of which the law is a method",
    );
    check_refused(
        "[[filter]]\nfunction = \"crate::control::Pid::calc\"\n",
        "`crate::control::Pid::calc` is a method",
        "2:12",
        "write `type = \"crate::control::Pid\"` and `law = \"calc\"`",
    );
    check_refused(
        "[[cycle]]\nfunction = \"crate::control::Estimator::step\"\n",
        "is a trait",
        "2:12",
        "write `method = \"crate::control::Estimator::step\"`",
    );
}

#[test]
fn cycles_and_guards_that_are_not_there_are_refused() {
    check_refused(
        "[[cycle]]\nfunction = \"crate::Robot::tik\"\n",
        "`crate::Robot` has no method `tik`",
        "2:12",
        "`tick`",
    );
    check_refused("[[cycle]]\nmethod = \"crate::control::Estimator::stp\"\n", "has no method `stp`", "2:10", "`step`");
    let other = "[[cycle]]\nmethod = \"crate::control::Estimatr::step\"\n";
    check_refused(other, "names nothing", "2:10", "did you mean `crate::control::Estimator::step`?");
    check_refused("[[cycle]]\nattribute = \"rtic::task\"\n", "no function has the attribute `rtic::task`", "2:13", "");
    check_refused("[[guard]]\ntype = \"crate::Tock\"\n", "`crate::Tock` names nothing", "2:8", "`crate::Tick`");
    check_refused("[[guard]]\ntype = \"crate::Tick\"\n", "`crate::Tick` has no method `new`", "2:8", "it has `over`");
}

#[test]
fn resets_and_makers_that_are_not_there_are_refused() {
    let code = "pub mod dsp {\n    pub struct Iir { pub taps: [f32; 2] }\n    impl Iir { pub fn clear(&mut self) { self.taps = [0.0; 2]; } }\n    \
                pub fn iir(state: &mut Iir, input: f32) -> f32 { state.taps[0] += input; state.taps[0] }\n    \
                pub fn iir_init(state: &mut Iir) { state.taps = [0.0; 2]; }\n    pub fn warm(state: &Iir) -> f32 { state.taps[1] }\n}\n\
                pub fn run(mut state: dsp::Iir, is_cut: fn() -> bool) {\n    loop { if is_cut() { dsp::iir_init(&mut state); } else { dsp::iir(&mut state, 0.1); } }\n}\n";
    let with = |rest: &str| {
        run(&package(code, &format!("[[filter]]\nfunction = \"crate::dsp::iir\"\n{rest}\n")), ["-D", "skipped_update"])
    };
    let refused = |rest: &str, message: &str, help: &str| {
        with(rest).assert_code(101).assert_stderr(message).assert_stderr("ceid-lint.toml:3:").assert_stderr(help);
    };
    refused("reset = [\"cleer\"]", "`Iir` has no method `cleer`", "did you mean `clear`?");
    refused("partial_reset = \"iir_init\"", "`iir_init` is a function", "write its path: `crate::dsp::iir_init`");
    refused("reset = \"crate::dsp::iir_innit\"", "names nothing", "did you mean `crate::dsp::iir_init`?");
    refused("reset = \"crate::dsp::warm\"", "`crate::dsp::warm` is lent no `Iir`", "takes the state as `&mut`");
    refused("reset = \"crate::dsp::iir\"", "`crate::dsp::iir` is the law", "a law goes on with the state");
    refused("made_by = \"nope::iir\"", "`nope::iir` names nothing", "neither a member");
    refused("made_by = \"crate::dsp::iir_innit\"", "names nothing", "did you mean `crate::dsp::iir_init`?");
    with("reset = [\"clear\", \"crate::dsp::iir_init\"]").assert_code(0);
    // One that sets a part is none.
    with("partial_reset = \"crate::dsp::iir_init\"").assert_code(100).assert_stderr("skipped_update");
    check_refused(
        "[[cycle]]\nfunction = \"crate::Gain\"\n",
        "`crate::Gain` is a type, not a function",
        "2:12",
        "as in `crate::Gain::next`",
    );
}

#[test]
fn all_that_is_wrong_is_told_at_once() {
    let run = checked(
        "[[filter]]\ntype = \"crate::Pid\"\nlaw = \"calc\"\n[[filter]]\ntype = \"crate::control::Pid\"\nlaw = \"clac\"\n[[cycle]]\nfunction = \"crate::idel\"\n",
    );
    run.assert_code(101).assert_stderr("`crate::Pid` names nothing").assert_stderr("has no method `clac`");
    run.assert_stderr("`crate::idel` names nothing").assert_stderr("ceid-lint.toml:8:12");
    let run = checked("[lints]\nskipped_update = \"dney\"\n[[filter]]\ntype = \"crate::control::Pid\"\nlaw = 3\n");
    run.assert_code(101).assert_stderr("ceid-lint.toml:2:18").assert_stderr("ceid-lint.toml:5:7");
    check_refused(
        "[lints]\nskipped_update = \"deny\"\n\"ceid::skipped_update\" = \"allow\"\n",
        "`skipped_update` has a level already",
        "3:1",
        "write it once",
    );
}

#[test]
fn a_path_without_its_crate_has_one_in_its_correction() {
    check_refused(
        "[[filter]]\ntype = \"Pid\"\nlaw = \"calc\"\n",
        "`Pid` names nothing",
        "2:8",
        "`crate::control::Pid`",
    );
}

#[test]
fn what_a_target_defines_that_was_not_selected_is_no_mistake() {
    let toy = "struct Toy(f32);\nimpl Toy { fn calc(&mut self) { self.0 += 1.0; } }\nfn main() { let mut toy = Toy(0.0); loop { toy.calc(); toy.calc(); } }\n";
    let check = |path: &str, flags: &[&str], code: i32| {
        let directory = package(CODE, &format!("[[filter]]\ntype = \"crate::{path}\"\nlaw = \"calc\"\n"));
        workspace::write(&directory, "examples/toy.rs", toy.as_bytes());
        run(&directory, flags).assert_code(code);
    };
    check("Toy", &[], 100);
    check("Toy", &["--lib"], 0);
    check("Toi", &["--lib"], 101);
    check("control::Pidd", &["--lib"], 101);
}

#[test]
fn an_entry_holds_for_the_type_of_its_path_that_has_the_law() {
    let other = "struct Gain(f32);\nfn main() { println!(\"{}\", Gain(1.0).0); }\n";
    let directory = package(CODE, "[[filter]]\ntype = \"crate::Gain\"\nlaw = \"next\"\ninstance = \"returned\"\n");
    workspace::write(&directory, "examples/other.rs", other.as_bytes());
    run(&directory, [""; 0]).assert_code(0);
    let directory = package(CODE, "[[filter]]\ntype = \"crate::Gain\"\nlaw = \"nxet\"\n");
    workspace::write(&directory, "examples/other.rs", other.as_bytes());
    run(&directory, [""; 0]).assert_code(101).assert_stderr("has no method `nxet`");
}

#[test]
fn a_reset_of_a_trait_may_be_a_method_of_its_types() {
    let code = "pub trait Estimator { fn step(&mut self); }\npub struct Tilt(f32);\nimpl Tilt { pub fn clear(&mut self) { self.0 = 0.0; } }\n\
                impl Estimator for Tilt { fn step(&mut self) { self.0 += 1.0; } }\npub struct Lag;\nimpl Lag { pub fn rewind(&mut self) {} }\n";
    let entry =
        |reset: &str| format!("[[filter]]\ntrait = \"crate::Estimator\"\nlaw = \"step\"\nreset = \"{reset}\"\n");
    run(&package(code, &entry("clear")), [""; 0]).assert_code(0);
    run(&package(code, &entry("rewind")), [""; 0]).assert_code(101).assert_stderr("has no method `rewind`");
}

#[test]
fn a_preset_that_is_not_there_is_refused() {
    check_refused("presets = [\"pid\", \"ahr\"]\n", "there is no preset `ahr`", "1:19", "did you mean `ahrs`?");
}

#[test]
fn a_law_of_a_preset_has_its_spelling_from_there() {
    let entry = |rest: &str| format!("[[filter]]\ntype = \"pid::Pid\"\n{rest}\n");
    let message = "`pid::Pid` has no method";
    check_refused(&entry("law = \"next_control_outputt\""), message, "3:7", "did you mean `next_control_output`?");
    let reset = "law = \"next_control_output\"\npartial_reset = [\"reset_intgral_term\"]";
    check_refused(&entry(reset), message, "4:18", "did you mean `reset_integral_term`?");
    // Another version may have other methods.
    check_accepted(&entry("law = [[\"next_control_output\", \"next_control_output_with\", \"advance\"]]"));
}

#[test]
fn the_standard_library_has_no_filters() {
    let message = "is of the standard library, which has no filters";
    check_refused("[[filter]]\ntrait = \"std::iter::Iterator\"\nlaw = \"next\"\n", message, "2:9", "name the type");
    check_refused("[[filter]]\nfunction = \"core::mem::swap\"\n", message, "2:12", "name the type");
}

#[test]
fn what_names_something_is_accepted() {
    for path in ["crate::control::Pid", "rover_control::control::Pid"] {
        check_accepted(&format!("[[filter]]\ntype = \"{path}\"\nlaw = \"calc\"\nreset = \"reset\"\n"));
    }
    check_accepted("[[filter]]\nfunction = \"crate::control::fir\"\n");
    check_accepted("[[cycle]]\nfunction = \"crate::Robot::tick\"\n");
    check_accepted("[[guard]]\ntype = \"crate::Tick\"\nregister = \"over\"\n");
    check_accepted("[[guard]]\ntype = \"crate::Tick\"\nregister = \"idle\"\n");
}

#[test]
fn findings_name_the_half_of_a_law() {
    let code = |body: &str| {
        format!(
            "pub struct Kf(f32);\nimpl Kf {{ pub fn predict(&mut self) {{ self.0 *= 0.9; }} pub fn correct(&mut self, z: f32) {{ self.0 += z; }} }}\n\
             pub fn run(mut kf: Kf, read: fn() -> f32) {{ loop {{ {body} }} }}\n"
        )
    };
    let configuration = "[[filter]]\ntype = \"crate::Kf\"\nlaw = [[\"predict\"], [\"correct\"]]\n";
    for (body, told) in [
        ("kf.correct(read());", "`kf` is never updated by `predict` in this cycle"),
        ("kf.predict(); if read() > 1.0 { continue; } kf.correct(1.0);", "`kf` is not updated by `correct` on a path"),
        ("kf.predict(); kf.correct(1.0); kf.correct(2.0);", "`kf` is updated by `correct` more than once"),
    ] {
        let told_by = run(&package(&code(body), configuration), [""; 0]);
        told_by.assert_stderr(told);
        assert!(!told_by.stderr.contains("by `predict` more"), "{}", told_by.stderr);
    }
}

#[test]
fn an_unread_wrapper_is_told_by_the_law_of_what_it_has() {
    let code = "pub struct Lag(f32);\nimpl Lag { pub fn relax(&mut self) { self.0 *= 0.5; } }\nfn go_on(lag: &mut Lag) { lag.relax(); }\n\
                pub fn run(mut kept: pid::Kept<Lag>) { loop { go_on(&mut kept); go_on(&mut kept); } }\n";
    let directory = package(code, "[[filter]]\ntype = \"crate::Lag\"\nlaw = \"relax\"\n");
    let report = run(&directory, ["report", "--message-format", "json"]);
    assert!(
        report.stdout.contains("\"law\": \"relax\"") || report.stdout.contains("\"law\":\"relax\""),
        "{}",
        report.stdout
    );
}

#[test]
fn a_raw_name_is_the_name() {
    let code = "pub mod r#type { pub struct Pid(f32); impl Pid { pub fn r#try(&mut self) { self.0 += 1.0; } } }
        pub fn run(mut pid: r#type::Pid) { loop { pid.r#try(); pid.r#try(); } }";
    for (path, law) in [("crate::r#type::Pid", "r#try"), ("crate::type::Pid", "try")] {
        let configuration = format!("[[filter]]\ntype = \"{path}\"\nlaw = \"{law}\"\n");
        run(&package(code, &configuration), [""; 0]).assert_code(100).assert_stderr("`pid` is updated more than once");
    }
}

#[test]
fn a_path_into_a_dependency_is_accepted_by_either_of_its_names() {
    for path in ["pid::Pid", "lite::Controller", "pid_lite::Controller"] {
        check_accepted(&format!("[[filter]]\ntype = \"{path}\"\nlaw = \"whatever\"\n"));
    }
}

#[test]
fn what_this_build_leaves_out_is_no_mistake() {
    check_accepted("[[filter]]\ntype = \"crate::control::extra::Lag\"\nlaw = \"run\"\n");
    check_accepted("[[filter]]\ntype = \"crate::control::Pid\"\nlaw = [[\"calc\", \"calc_with\"]]\n");
}

#[test]
fn what_was_not_read_is_no_mistake() {
    let code = format!("{CODE}\nmod missing;\n");
    let entry = "[[filter]]\ntype = \"crate::missing::Pid\"\nlaw = \"calc\"\n";
    let run = run(&package(&code, entry), [""; 0]);
    assert!(!run.stderr.contains("names nothing"), "{}", run.stderr);
}

const LOOP: &str = "\
pub fn control(mut pid: pid::Pid<f32>, mut read: impl FnMut() -> f32) {
    loop {
        pid.next_control_output(read());
        pid.next_control_output(read());
    }
}
";

/// How often `repeated_update` is found in the loop above.
#[track_caller]
fn check_repeated(configuration: &str, expected: usize) {
    let directory = package(LOOP, configuration);
    let run = run(&directory, ["--message-format", "json"]);
    let findings = run.findings().unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(
        findings.iter().filter(|finding| finding.rule == "repeated_update").count(),
        expected,
        "{configuration}"
    );
}

#[test]
fn presets_are_active_for_the_crates_of_the_manifest() {
    check_repeated("", 1);
    check_repeated("presets = \"auto\"\n", 1);
    check_repeated("presets = [\"pid\"]\n", 1);
    check_repeated("presets = [\"ahrs\"]\n", 0);
    check_repeated("presets = \"none\"\n", 0);
}

#[test]
fn an_entry_overrides_a_preset() {
    check_repeated("[[filter]]\ntype = \"pid::Pid\"\nlaw = \"another\"\n", 0);
    check_repeated("[[filter]]\ntype = \"pid::Pid\"\nlaw = \"next_control_output\"\nkind = \"event\"\n", 0);
    check_repeated("[[filter]]\ntype = \"pid::Pid\"\nlaw = \"next_control_output\"\nmultiplicity = \"any\"\n", 0);
}

#[test]
fn a_configuration_that_is_no_file_is_an_error() {
    let directory = package(CODE, "");
    let path = directory.join("ceid-lint.toml");
    std::fs::remove_file(&path).expect("it was written");
    std::fs::create_dir(&path).expect("the name is free");
    let told = run(&directory, [""; 0]);
    told.assert_code(101).assert_stderr("ceid-lint.toml`: it is not a file").assert_stderr("or remove it");
}

#[test]
fn a_configuration_that_is_no_text_says_what_to_do() {
    let directory = package(CODE, "");
    for (bytes, why) in [(&b"\x00\xfe\x80"[..], "not valid UTF-8 (byte 1)"), (b"\xff\xfe[\x00", "it is UTF-16")] {
        std::fs::write(directory.join("ceid-lint.toml"), bytes).expect("it was written before");
        let told = run(&directory, [""; 0]);
        told.assert_code(101)
            .assert_stderr("error: cannot read `")
            .assert_stderr(why)
            .assert_stderr("save it as UTF-8");
    }
}

#[test]
fn two_entries_for_a_filter_say_the_same() {
    let entry = |law: &str| format!("[[filter]]\ntype = \"pid::Pid\"\nlaw = \"{law}\"\n");
    check_repeated(&(entry("next_control_output") + &entry("next_control_output")), 1);
    let directory = package(LOOP, &(entry("next_control_output") + &entry("step")));
    run(&directory, [""; 0])
        .assert_code(101)
        .assert_stderr("the filter `pid::Pid` has an entry in line 2 as well, which says something else")
        .assert_stderr("ceid-lint.toml:5:8")
        .assert_stderr("write one entry");
}

#[test]
fn what_a_package_says_of_a_filter_stands_over_its_workspace() {
    let entry = |law: &str| format!("[[filter]]\ntype = \"pid::Pid\"\nlaw = \"{law}\"\n");
    let directory = package(LOOP, &entry("step"));
    run(&directory, [""; 0]).assert_code(100).assert_stderr("never updated");
    let manifest = std::fs::read_to_string(directory.join("Cargo.toml")).expect("it was written");
    let own = entry("next_control_output").replace("[[filter]]", "[[package.metadata.ceid-lint.filter]]");
    std::fs::write(directory.join("Cargo.toml"), format!("{manifest}\n{own}")).expect("it can be written");
    run(&directory, [""; 0]).assert_code(100).assert_stderr("more than once");
}

/// Three packages, of which one says what it has to of the crates of the others.
#[track_caller]
fn check_one_view(own: &str, code: &str, expected: &[&str]) {
    let directory = package(CODE, "[[filter]]\ntype = \"regulators::Pi\"\nlaw = \"step\"\n");
    let manifest = |name: &str, more: &str| {
        format!(
            "[package]\nname = \"{name}\"\nversion = \"0.0.0\"\nedition = \"2024\"\n\n\
             [dependencies]\npid = \"4\"\n{more}"
        )
    };
    let regulators = "regulators = { path = \"../regulators\" }\n";
    let members = "[workspace]\nresolver = \"3\"\nmembers = [\"line\", \"oven\", \"regulators\"]\n";
    workspace::write(&directory, "Cargo.toml", members.as_bytes());
    workspace::write(&directory, "regulators/Cargo.toml", manifest("regulators", "").as_bytes());
    let filter = "pub struct Pi(pub f32);\nimpl Pi {\n    pub fn step(&mut self, error: f32) { self.0 += error; }\n    \
                  pub fn step_for(&mut self, error: f32, dt: f32) { self.0 += error * dt; }\n}\n";
    workspace::write(&directory, "regulators/src/lib.rs", filter.as_bytes());
    for (name, more) in [("line", String::new()), ("oven", format!("\n[package.metadata.ceid-lint]\n{own}"))] {
        workspace::write(
            &directory,
            &format!("{name}/Cargo.toml"),
            manifest(name, &(regulators.to_owned() + &more)).as_bytes(),
        );
        workspace::write(&directory, &format!("{name}/src/lib.rs"), code.as_bytes());
    }
    let run = run(&directory, ["--workspace", "--message-format", "json"]);
    let findings = run.findings().unwrap_or_else(|error| panic!("{error}"));
    let found: Vec<&str> =
        findings.iter().map(|finding| finding.file.split(['/', '\\']).next().unwrap_or_default()).collect();
    assert_eq!(found, expected, "{}", run.stderr);
}

#[test]
fn what_a_package_says_of_other_crates_holds_for_it_alone() {
    let own = "[[package.metadata.ceid-lint.filter]]\ntype = \"regulators::Pi\"\nlaw = [[\"step\", \"step_for\"]]\n";
    let by_two = "pub fn run(mut pi: regulators::Pi) {\n    loop {\n        pi.step(1.0);\n        pi.step_for(1.0, 0.1);\n    }\n}\n";
    check_one_view("", by_two, &[]);
    check_one_view(own, by_two, &["oven"]);
    let by_preset = "pub fn run(mut pid: pid::Pid<f32>) {\n    loop {\n        pid.next_control_output(1.0);\n        \
                     pid.next_control_output(2.0);\n    }\n}\n";
    check_one_view("", by_preset, &["line", "oven"]);
    check_one_view("presets = \"none\"\n", by_preset, &["line"]);
}

const AUDIO_CRATE: &str = "\
pub mod audionode {
    pub trait AudioNode {
        fn tick(&mut self, input: f32) -> f32;
        fn process(&mut self, size: usize);
        fn get_mono(&mut self) -> f32;
        fn get_stereo(&mut self) -> (f32, f32);
        fn filter_mono(&mut self, input: f32) -> f32;
        fn filter_stereo(&mut self, left: f32, right: f32) -> (f32, f32);
        fn reset(&mut self);
    }
}
use audionode::AudioNode;
pub struct Oversampler<X> { pub x: X }
impl<X: AudioNode> AudioNode for Oversampler<X> {
    fn tick(&mut self, input: f32) -> f32 {
        self.x.tick(input) + self.x.tick(input)
    }
    fn process(&mut self, size: usize) { self.x.process(size); }
    fn get_mono(&mut self) -> f32 { self.x.get_mono() }
    fn get_stereo(&mut self) -> (f32, f32) { self.x.get_stereo() }
    fn filter_mono(&mut self, input: f32) -> f32 { self.x.filter_mono(input) }
    fn filter_stereo(&mut self, left: f32, right: f32) -> (f32, f32) { self.x.filter_stereo(left, right) }
    fn reset(&mut self) { self.x.reset(); }
}
pub fn render(node: &mut impl AudioNode, block: &mut [f32]) {
    loop {
        for sample in block.iter_mut() {
            *sample = node.tick(*sample);
        }
        node.tick(0.0);
        node.tick(0.0);
    }
}
";

#[test]
fn a_preset_does_not_judge_the_laws_of_its_own_crate() {
    let found = |configuration: &str| -> Vec<String> {
        let directory = package(AUDIO_CRATE, configuration);
        workspace::write(&directory, "Cargo.toml", MANIFEST.replace("rover-control", "fundsp").as_bytes());
        let report = run(&directory, ["report", "--message-format", "json"]);
        let report: serde_json::Value = serde_json::from_str(&report.stdout).expect("the report is JSON");
        let cycles = report["cycles"].as_array().into_iter().flatten();
        let pairs = cycles.flat_map(|cycle| {
            let function = cycle["function"].as_str().unwrap_or_default();
            let filters = cycle["filters"].as_array().into_iter().flatten();
            filters.map(move |filter| format!("{function}: {}", filter["verdict"].as_str().unwrap_or_default()))
        });
        pairs.collect()
    };
    let told = found("");
    assert!(told.contains(&"Oversampler::tick: unproved".to_owned()), "{told:?}");
    assert!(told.contains(&"Oversampler::filter_mono: once".to_owned()), "{told:?}");
    assert!(told.contains(&"render: repeated".to_owned()), "a loop is judged in each crate: {told:?}");
    let directory = package(AUDIO_CRATE, "");
    workspace::write(&directory, "Cargo.toml", MANIFEST.replace("rover-control", "fundsp").as_bytes());
    let way_out = "a `[[filter]]` of its own with `trait = \"crate::audionode::AudioNode\"` has it judged";
    assert!(run(&directory, ["report", "-v"]).stdout.contains(way_out));
    let methods = "[\"tick\", \"process\", \"get_mono\", \"get_stereo\", \"filter_mono\", \"filter_stereo\"]";
    let own = found(&format!("[[filter]]\ntrait = \"fundsp::audionode::AudioNode\"\nlaw = [{methods}]\n"));
    assert!(own.contains(&"Oversampler::tick: repeated".to_owned()), "what the user says is no preset: {own:?}");
}

#[test]
fn a_type_with_two_traits_that_are_laws_needs_an_entry_of_its_own() {
    let code = "\
pub trait Predict { fn predict(&mut self); }
pub trait Correct { fn correct(&mut self, z: f32); }
pub struct Kalman(f32);
impl Predict for Kalman { fn predict(&mut self) { self.0 *= 0.9; } }
impl Correct for Kalman { fn correct(&mut self, z: f32) { self.0 += 0.1 * z; } }
pub fn run(mut kalman: Kalman) {
    loop {
        kalman.predict();
        kalman.predict();
        kalman.correct(1.0);
    }
}
";
    let by_trait = |name: &str| format!("[[filter]]\ntrait = \"crate::{name}\"\nlaw = \"{}\"\n", name.to_lowercase());
    let by_traits = by_trait("Predict") + &by_trait("Correct");
    run(&package(code, &by_traits), [""; 0])
        .assert_code(101)
        .assert_stderr("`Kalman` implements `crate::Predict` and the trait of the entry in line 5 as well")
        .assert_stderr("ceid-lint.toml:2:9")
        .assert_stderr("`law = [[\"predict\"], [\"correct\"]]`");
    let own = "[[filter]]\ntype = \"crate::Kalman\"\nlaw = [[\"predict\"], [\"correct\"]]\n";
    for configuration in [format!("{own}{by_traits}"), format!("{by_traits}{own}")] {
        run(&package(code, &configuration), [""; 0]).assert_code(100).assert_stderr("more than once");
    }
}
