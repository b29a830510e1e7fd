//! Whole repositories as they are found: nothing stops the run, and what was not seen is said once, with its cause.

use std::path::{Path, PathBuf};

use serde_json::Value;

use crate::support::program::{Run, run};
use crate::support::workspace::{GUILTY, temporary, write};

fn package(name: &str, rest: &str) -> String {
    format!("[package]\nname = \"{name}\"\nversion = \"0.1.0\"\nedition = \"2024\"\n{rest}")
}

/// A package of its own workspace.
fn alone(rest: &str) -> String {
    package("demo", &format!("{rest}[workspace]\n"))
}

fn repository(name: &str, files: &[(&str, &str)]) -> PathBuf {
    let directory = temporary(name);
    for (path, text) in files {
        write(&directory, path, text.as_bytes());
    }
    directory
}

/// What the proof report lists as unread: `file:line cause`.
fn unread(directory: &Path, args: &[&str]) -> Vec<String> {
    let run = run(directory, ["report", "--message-format", "json"].iter().chain(args));
    let report: Value = serde_json::from_str(&run.stdout).unwrap_or_else(|error| panic!("{error}\n{}", run.stderr));
    let rows = report["unread"].as_array().expect("the report lists what is unread");
    let text = |row: &Value, key: &str| row[key].as_str().expect("every row says so").to_owned();
    rows.iter()
        .map(|row| {
            assert!(!text(row, "help").is_empty(), "{row}");
            format!("{}:{} {}", text(row, "file"), row["line"], text(row, "cause"))
        })
        .collect()
}

/// How a run must end, and what must be said about what was not seen: its place, and a part of the cause.
#[track_caller]
fn check(directory: &Path, args: &[&str], code: i32, guilty: &[&str], expected: &[(&str, &str)]) -> Run {
    let json = run(directory, ["--message-format", "json"].iter().chain(args));
    json.assert_no_panic().assert_code(code);
    let findings = json.findings_in_spite_of_problems().expect("the output is whole");
    let mut files: Vec<&str> =
        findings.iter().filter(|it| it.rule == "repeated_update").map(|it| it.file.as_str()).collect();
    files.sort_unstable();
    assert_eq!(files, guilty, "{}", json.stderr);

    let unread = unread(directory, args);
    assert_eq!(unread.len(), expected.len(), "{unread:#?}");
    let human = run(directory, args);
    human.assert_no_panic().assert_code(code);
    for ((place, cause), row) in expected.iter().zip(&unread) {
        assert!(row.starts_with(place) && row.contains(cause), "`{place} {cause}` is not in {row}");
        let file = place.split(':').next().expect("a place begins with a file");
        assert!(human.stderr.contains(file) && human.stderr.contains(cause), "{}", human.stderr);
        if let Some((_, end)) = human.stderr.split_once("left unread") {
            let head = &human.stderr[..human.stderr.len() - end.len()];
            assert!(!head.contains(cause) || !end.contains(cause), "said twice:\n{}", human.stderr);
        }
    }
    human
}

#[test]
fn packages_side_by_side_without_a_root() {
    let files = [
        ("arm/Cargo.toml", &*package("arm", "")),
        ("arm/src/lib.rs", GUILTY),
        ("base/Cargo.toml", &package("base", "")),
        ("base/src/main.rs", &format!("{GUILTY}fn main() {{}}\n")),
        ("broken/Cargo.toml", "[package\n"),
        ("broken/src/lib.rs", GUILTY),
        ("scripts/tune.rs", GUILTY),
    ];
    // The target directory of these tests lies below a workspace that knows nothing of them.
    let directory = repository("side_by_side", &files);
    let guilty = ["arm/src/lib.rs", "base/src/main.rs", "scripts/tune.rs"];
    check(&directory, &["."], 101, &guilty, &[("broken/Cargo.toml", "unclosed table")]);
}

#[test]
fn package_beside_a_broken_one_keeps_its_directory() {
    let files = [
        ("arm/Cargo.toml", &*package("arm", "")),
        ("arm/src/lib.rs", GUILTY),
        ("broken/Cargo.toml", "[package\n"),
        ("broken/src/lib.rs", GUILTY),
    ];
    let directory = repository("beside_a_broken_one", &files);
    check(&directory, &["."], 101, &["arm/src/lib.rs"], &[("broken/Cargo.toml", "unclosed table")]);
}

#[test]
fn targets_outside_of_the_directory_of_their_package() {
    let manifest = alone("[lib]\npath = \"../code/lib.rs\"\n[[bin]]\nname = \"tool\"\npath = \"src/../../tool.rs\"\n");
    let files = [("demo/Cargo.toml", manifest.as_str()), ("code/lib.rs", GUILTY), ("tool.rs", GUILTY)];
    let directory = repository("targets_outside", &files);
    let [library, tool] = ["code/lib.rs", "tool.rs"].map(|file| directory.join(file).to_string_lossy().into_owned());
    check(&directory.join("demo"), &[], 100, &[&library, &tool], &[]);
}

#[test]
fn git_dependency_that_is_not_there() {
    let manifest = alone("[dependencies]\nbus = { git = \"https://git.invalid/bus\" }\n");
    let files = [("Cargo.toml", &*manifest), ("src/lib.rs", GUILTY)];
    let expected = [("Cargo.toml", "the git dependency `bus`")];
    check(&repository("git_unlocked", &files), &[], 100, &["src/lib.rs"], &expected);
    let files = [files[0], files[1], ("Cargo.lock", "version = 4\n")];
    check(&repository("git_locked", &files), &[], 100, &["src/lib.rs"], &expected);
}

#[test]
fn path_dependency_that_is_not_there() {
    let files = [
        ("Cargo.toml", "[workspace]\nmembers = [\"arm\", \"base\"]\nresolver = \"3\"\n"),
        ("arm/Cargo.toml", &*package("arm", "[dependencies]\nbus = { path = \"../bus\" }\n")),
        ("arm/src/lib.rs", GUILTY),
        ("base/Cargo.toml", &package("base", "")),
        ("base/src/lib.rs", GUILTY),
    ];
    let guilty = ["arm/src/lib.rs", "base/src/lib.rs"];
    check(&repository("path_lost", &files), &[], 100, &guilty, &[("arm/Cargo.toml", "there is no package `bus`")]);
}

#[test]
fn members_that_are_missing_or_broken() {
    let files = [
        ("Cargo.toml", "[workspace]\nmembers = [\"arm\", \"gone\", \"odd\"]\nresolver = \"3\"\n"),
        ("arm/Cargo.toml", &*package("arm", "")),
        ("arm/src/lib.rs", GUILTY),
        ("odd/Cargo.toml", "[package]\nname = \n"),
        ("odd/src/lib.rs", GUILTY),
    ];
    let expected = [("gone/Cargo.toml", "cannot read manifest"), ("odd/Cargo.toml", "Cargo.toml:2:")];
    check(&repository("members_lost", &files), &[], 101, &["arm/src/lib.rs"], &expected);
}

#[test]
fn toolchain_files_that_name_nothing() {
    for (number, text) in
        ["[toolchain]\npath = \"/no/such/toolchain\"\n", "[toolchain]\nchannel = \"esp\"\n", "[[["].iter().enumerate()
    {
        let files = [("Cargo.toml", &*alone("")), ("src/lib.rs", GUILTY), ("rust-toolchain.toml", text)];
        check(&repository(&format!("toolchain_{number}"), &files), &[], 100, &["src/lib.rs"], &[]);
    }
}

#[test]
fn configuration_of_cargo_that_is_broken() {
    let files = [("Cargo.toml", &*alone("")), ("src/lib.rs", GUILTY), (".cargo/config.toml", "[[[")];
    let expected = [("Cargo.toml", "could not load Cargo configuration")];
    check(&repository("cargo_config", &files), &[], 101, &["src/lib.rs"], &expected);
}

#[test]
fn code_of_edition_2015() {
    let old = "#[macro_use] extern crate core as kern;\nmod good;\nuse good::Kalman;\n\
               trait Node { fn feed(&mut self, u8, &mut Kalman) -> Result<(), ()>; }\n\
               fn dyn(async: u8, node: &mut Node, other: Box<Node + Send>) -> Result<u8, ()> {\n\
                   let try = try!(node.feed(async, &mut Kalman));\n    match async { 0...9 => Ok(1), _ => Ok(0) }\n}\n";
    let manifest = "[workspace]\n[package]\nname = \"demo\"\nversion = \"0.1.0\"\n";
    // A `use` begins at the crate root, in whatever module it stands.
    let user = "use good::{Kalman, SampledFilter};\n\
                pub fn run() { let mut kf = Kalman; loop { kf.update(); ::good::SampledFilter::update(&mut kf); } }\n";
    let old = &*format!("{old}mod user;\n");
    let files = [("Cargo.toml", manifest), ("src/lib.rs", old), ("src/good.rs", GUILTY), ("src/user.rs", user)];
    check(&repository("edition_2015", &files), &[], 100, &["src/good.rs", "src/user.rs"], &[]);
}

#[test]
fn output_of_a_build_script_that_is_absent() {
    let root = "mod good;\ninclude!(concat!(env!(\"OUT_DIR\"), \"/bindings.rs\"));\n\
                pub fn table() -> [u8; 2] { include!(concat!(env!(\"OUT_DIR\"), \"/table.rs\")) }\n";
    let files =
        [("Cargo.toml", &*alone("")), ("build.rs", "fn main() {}\n"), ("src/lib.rs", root), ("src/good.rs", GUILTY)];
    let expected = [("src/lib.rs:2", "`bindings.rs` is written by a build script"), ("src/lib.rs:3", "`table.rs`")];
    check(&repository("out_dir", &files), &[], 100, &["src/good.rs"], &expected);
}

#[test]
fn included_files() {
    let files = [
        ("Cargo.toml", &*alone("")),
        ("src/lib.rs", "include!(\"parts/good.rs\");\ninclude!(\"parts/gone.rs\");\n"),
        ("src/parts/good.rs", GUILTY),
    ];
    let expected = [("src/lib.rs:2", "file not found for `include!`: `src/parts/gone.rs`")];
    check(&repository("included", &files), &[], 101, &["src/parts/good.rs"], &expected);
}

#[test]
fn files_and_packages_outside_any_target() {
    let root = "mod good;\n#[cfg(windows)]\nmod windows;\n#[cfg(feature = \"x\")]\n#[path = \"other.rs\"]\nmod x;\n";
    let files = [
        ("Cargo.toml", &*alone("")),
        ("build.rs", "fn main() {}\n"),
        ("src/lib.rs", root),
        ("src/good.rs", GUILTY),
        ("src/windows/mod.rs", "mod deeper;\n"),
        ("src/windows/deeper.rs", GUILTY),
        ("src/other.rs", GUILTY),
        ("src/orphan.rs", GUILTY),
        ("tests/it.rs", "mod common;\n"),
        ("tests/common/mod.rs", ""),
        ("firmware/Cargo.toml", &package("firmware", "[workspace]\n")),
        ("firmware/src/main.rs", "fn main() {}\n"),
        ("vendor/bus/Cargo.toml", &package("bus", "")),
        ("vendor/bus/.cargo-checksum.json", "{}"),
        ("vendor/bus/src/lib.rs", GUILTY),
    ];
    let directory = repository("outside", &files);
    let expected = [("firmware/Cargo.toml", "belongs to no package"), ("src/orphan.rs", "belongs to no target")];
    let human = check(&directory, &[], 100, &["src/good.rs"], &expected);
    human.assert_stderr("cargo ceid-lint firmware");
    // A file that is named is checked, whether a target reads it or not.
    check(&directory, &["src/orphan.rs"], 100, &["src/orphan.rs"], &[]);
    check(&directory, &["src/other.rs"], 0, &[], &[("src/other.rs", "`cfg` leaves its module out")]);
}

#[test]
fn a_dependency_beside_the_workspace_is_named_if_it_has_cycles() {
    // Without a `[workspace]` there is one of this package only.
    let dependencies = "[dependencies]\ncore = { path = \"parts/core\" }\ntools = { path = \"parts/tools\" }\n";
    let root = package("demo", dependencies);
    let files = [
        ("Cargo.toml", &*root),
        ("src/lib.rs", "mod good;\n"),
        ("src/good.rs", GUILTY),
        ("parts/core/Cargo.toml", &package("core", "")),
        ("parts/core/src/lib.rs", GUILTY),
        ("parts/tools/Cargo.toml", &package("tools", "")),
        ("parts/tools/src/lib.rs", "pub fn two() -> u8 { 2 }\n"),
    ];
    let expected = [("parts/core/Cargo.toml", "belongs to no package that is checked")];
    let human = check(&repository("beside", &files), &[], 100, &["src/good.rs"], &expected);
    human.assert_stderr("cargo ceid-lint parts/core");
}

#[test]
fn generated_file_of_50_000_lines() {
    let lines: String = (0..25_000)
        .map(|at| format!("pub const R{at}: u32 = {at};\npub fn get_{at}(r: &[u32]) -> u32 {{ r[{at}] & R{at} }}\n"))
        .collect();
    let files = [
        ("Cargo.toml", &*alone("")),
        ("src/lib.rs", "mod good;\nmod registers;\n"),
        ("src/good.rs", GUILTY),
        ("src/registers.rs", &lines),
    ];
    check(&repository("generated", &files), &[], 100, &["src/good.rs"], &[]);
}

#[test]
fn modules_by_path_that_lead_in_circles() {
    let files = [
        ("Cargo.toml", &*alone("")),
        ("src/lib.rs", "mod good;\nmod a;\n#[path = \"lib.rs\"]\nmod me;\n"),
        ("src/good.rs", GUILTY),
        ("src/a.rs", "#[path = \"b.rs\"]\nmod b;\n"),
        ("src/b.rs", "#[path = \"a.rs\"]\nmod a;\n"),
    ];
    let expected = [
        ("src/b.rs:2", "circular modules: `src/a.rs` -> `src/b.rs`"),
        ("src/lib.rs:4", "circular modules: `src/lib.rs`"),
    ];
    check(&repository("circles", &files), &[], 101, &["src/good.rs"], &expected);
}

#[test]
fn a_module_whose_file_differs_in_case() {
    let files = [
        ("Cargo.toml", &*alone("")),
        ("src/lib.rs", "mod good;\nmod Filter;\n"),
        ("src/good.rs", GUILTY),
        ("src/filter.rs", ""),
    ];
    let directory = repository("case", &files);
    if !directory.join("SRC").exists() {
        let expected = [("src/lib.rs:2", "file not found for module `Filter`")];
        check(&directory, &[], 101, &["src/good.rs"], &expected).assert_stderr("`src/filter.rs` differs in case");
    }
}

#[test]
fn places_without_code() {
    let empty = temporary("nothing_here");
    run(&empty, ["."]).assert_no_panic().assert_code(101).assert_stderr("holds no package and no `.rs` file");
    let files = [("Cargo.toml", "[workspace]\nmembers = [\"crates/*\"]\n")];
    let directory = repository("glob_of_nothing", &files);
    run(&directory, [""; 0]).assert_no_panic().assert_code(101).assert_stderr("Cargo.toml");
    let directory = repository("manifest_directory", &[("Cargo.toml/x", ""), ("src/lib.rs", GUILTY)]);
    check(&directory, &["."], 100, &["lib.rs"], &[]);
}

#[cfg(unix)]
mod unix {
    use std::os::unix::fs::{PermissionsExt, symlink};
    use std::process::Command;

    use super::*;

    #[test]
    fn directory_whose_name_is_no_utf8() {
        use std::ffi::OsStr;
        use std::os::unix::ffi::OsStrExt;

        // What a file system does not take there it has not.
        let outer = repository("no_utf8", &[]);
        let directory = outer.join(OsStr::from_bytes(b"arm\xff"));
        if std::fs::create_dir_all(directory.join("src")).is_err() {
            return;
        }
        std::fs::write(directory.join("Cargo.toml"), alone("")).expect("it can be written");
        std::fs::write(directory.join("src/lib.rs"), GUILTY).expect("it can be written");
        let whole = run(&directory, [""; 0]);
        whole.assert_no_panic().assert_code(101).assert_stderr("is not valid UTF-8");
        let file = run(&directory, ["src/lib.rs", "--message-format", "short"]);
        file.assert_no_panic();
    }

    #[test]
    fn links_in_circles_and_pipes() {
        let files = [
            ("Cargo.toml", &*alone("")),
            ("src/lib.rs", "mod good;\nmod circle;\nmod pipe;\nmod folder;\n"),
            ("src/good.rs", GUILTY),
            ("src/folder.rs/x", ""),
        ];
        let directory = repository("links", &files);
        symlink("circle.rs", directory.join("src/circle.rs")).expect("links can be made");
        symlink("..", directory.join("src/up")).expect("links can be made");
        let made = Command::new("mkfifo").arg(directory.join("src/pipe.rs")).status();
        assert!(made.is_ok_and(|status| status.success()), "pipes can be made");
        let expected = [
            ("src/circle.rs", "symbolic links"),
            ("src/pipe.rs", "not a regular file"),
            ("src/lib.rs:4", "file not found for module `folder`: `src/folder.rs` is a directory"),
        ];
        check(&directory, &[], 101, &["src/good.rs"], &expected);
    }

    #[test]
    fn directory_of_loose_files_with_a_pipe() {
        let directory = repository("loose_pipe", &[("a.rs", GUILTY), ("b.rs/c.rs", "")]);
        let made = Command::new("mkfifo").arg(directory.join("pipe.rs")).status();
        assert!(made.is_ok_and(|status| status.success()), "pipes can be made");
        check(&directory, &["."], 100, &["a.rs"], &[]);
    }

    #[test]
    fn file_without_permission() {
        let files = [
            ("Cargo.toml", &*alone("")),
            ("src/lib.rs", "mod good;\nmod shut;\n"),
            ("src/good.rs", GUILTY),
            ("src/shut.rs", ""),
        ];
        let directory = repository("permission", &files);
        let shut = directory.join("src/shut.rs");
        std::fs::set_permissions(&shut, std::fs::Permissions::from_mode(0o0)).expect("it is ours");
        // Who may read everything sees no difference.
        if std::fs::read(&shut).is_err() {
            check(&directory, &[], 101, &["src/good.rs"], &[("src/shut.rs", "denied")])
                .assert_stderr("make it readable");
        }
    }
}

#[test]
fn code_that_is_included_in_a_body_may_use_what_is_in_scope() {
    let lib = "trait SampledFilter { fn update(&mut self); }\npub struct Lag(f64);\n\
               impl SampledFilter for Lag { fn update(&mut self) { self.0 *= 0.5; } }\n\
               pub fn run(lag: &mut Lag) { loop { lag.update(); include!(\"%\"); } }\n";
    for (name, body, verdict) in [
        ("again", Some("{ lag.update(); }"), "unproved"),
        ("beside", Some("{ let flag = 1 + 2; }"), "once"),
        ("absent", None, "unproved"),
    ] {
        let mut files = vec![("Cargo.toml", alone("")), ("src/lib.rs", lib.replace('%', "body.rs"))];
        files.extend(body.map(|body| ("src/body.rs", body.to_owned())));
        let files: Vec<(&str, &str)> = files.iter().map(|(path, text)| (*path, text.as_str())).collect();
        let directory = repository(&format!("included_in_a_body_{name}"), &files);
        check(&directory, &[], 0, &[], &[("src/lib.rs:4", "`body.rs` is not read: its code is included in a body")]);
        let report = run(&directory, ["report", "--message-format", "json"]).stdout;
        assert!(report.contains(&format!("\"verdict\": \"{verdict}\"")), "{name}: {report}");
    }
}

/// `%` stands for what the file begins with.
const TWO_LOCKS: &str = "%
pub trait SampledFilter { fn update(&mut self); }
pub struct Rpm(f32);
impl SampledFilter for Rpm { fn update(&mut self) { self.0 *= 0.5; } }
pub struct Shared<M> { pub rpm: M }
pub fn engine<M: Mutex<T = Rpm>>(mut shared: Shared<M>) {
    loop {
        shared.rpm.lock(|rpm| rpm.update());
        shared.rpm.lock(|rpm| rpm.update());
    }
}
";

#[test]
fn imports_tell_what_a_file_without_a_manifest_depends_on() {
    for (name, begin, guilty) in [("imported", "use rtic::Mutex;", &["a.rs"][..]), ("unknown", "", &[])] {
        let text = TWO_LOCKS.replace('%', begin);
        let directory = repository(&format!("without_a_manifest_{name}"), &[("a.rs", &text)]);
        check(&directory, &["a.rs"], if guilty.is_empty() { 0 } else { 100 }, guilty, &[]);
    }
}

#[test]
fn texts_of_other_encodings() {
    let utf_16: Vec<u8> = "\u{feff}fn f() {}".encode_utf16().flat_map(u16::to_le_bytes).collect();
    for (name, bytes, cause) in [
        ("utf_16", utf_16.as_slice(), "UTF-16"),
        ("latin_1", b"// caf\xe9\n", "not valid UTF-8 (byte 6)"),
        ("nul", b"fn f() {\0}\n", "invalid token"),
    ] {
        let directory = repository(
            name,
            &[("Cargo.toml", &alone("")), ("src/lib.rs", "mod good;\nmod odd;\n"), ("src/good.rs", GUILTY)],
        );
        write(&directory, "src/odd.rs", bytes);
        check(&directory, &[], 101, &["src/good.rs"], &[("src/odd.rs", cause)]);
    }
}
