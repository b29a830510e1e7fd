//! Nothing is lost: a dirty tree is refused, and each file is the old one or the new one, whatever happens.

use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Duration;

use super::{SUPPRESSED, commit, fix, git, read, repository, unsuppressed};
use crate::support::program::{program, run};
use crate::support::workspace::{temporary, temporary_package, write};

#[test]
fn a_fix_removes_what_it_says_and_nothing_else() {
    let directory = repository("fix_plain", &[("src/lib.rs", SUPPRESSED.as_bytes())]);
    let done = fix(&directory, &[]);
    done.assert_code(0).assert_stderr("fixed src/lib.rs (1 fix)\n  line 5: remove the suppression");
    assert_eq!(read(&directory, "src/lib.rs"), unsuppressed());
    // The tree is as dirty as the fix made it, and no file was left beside the sources.
    assert_eq!(git(&directory, &["status", "--porcelain"]), " M src/lib.rs\n");
}

#[test]
fn check_can_fix_as_well() {
    let directory = repository("fix_flag", &[("src/lib.rs", SUPPRESSED.as_bytes())]);
    run(&directory, ["--fix"]).assert_code(0);
    assert_eq!(read(&directory, "src/lib.rs"), unsuppressed());
}

#[test]
fn uncommitted_changes_are_refused_in_the_words_of_cargo() {
    let directory = repository("fix_dirty", &[("src/lib.rs", SUPPRESSED.as_bytes()), ("src/ü b.rs", b"")]);
    write(&directory, "src/ü b.rs", b"// changed\n");
    write(&directory, "notes.txt", b"");
    let refused = fix(&directory, &[]);
    refused
        .assert_code(101)
        .assert_stderr("error: the working directory of this package has uncommitted changes, and ");
    refused.assert_stderr("pass `--allow-dirty`, or commit the changes to these files:\n\n  * src/ü b.rs (dirty)\n  * notes.txt (dirty)\n");
    git(&directory, &["add", "--all"]);
    fix(&directory, &[]).assert_code(101).assert_stderr("  * notes.txt (staged)\n  * src/ü b.rs (staged)\n");
    assert_eq!(read(&directory, "src/lib.rs"), SUPPRESSED);

    write(&directory, "notes.txt", b"once more");
    fix(&directory, &["--allow-staged"]).assert_code(101).assert_stderr("  * notes.txt (dirty)\n");
    git(&directory, &["add", "--all"]);
    fix(&directory, &["--allow-staged"]).assert_code(0);
    assert_eq!(read(&directory, "src/lib.rs"), unsuppressed());

    write(&directory, "src/lib.rs", SUPPRESSED.as_bytes());
    write(&directory, "notes.txt", b"and more");
    fix(&directory, &["--allow-dirty"]).assert_code(0);
    assert_eq!(read(&directory, "src/lib.rs"), unsuppressed());
}

#[test]
fn what_no_repository_keeps_is_refused() {
    let kept = repository("fix_no_vcs", &[("src/lib.rs", b"")]);
    // A directory that the repository around it ignores is kept by none.
    let package = "target/inner";
    write(&kept, &format!("{package}/Cargo.toml"), b"[workspace]\n[package]\nname = \"inner\"\nedition = \"2024\"\n");
    write(&kept, &format!("{package}/src/lib.rs"), SUPPRESSED.as_bytes());
    let directory = kept.join(package);
    let refused = fix(&directory, &["--allow-dirty"]);
    refused.assert_code(101).assert_stderr("no VCS found for this package and `cargo ceid-lint fix` can potentially");
    assert_eq!(read(&directory, "src/lib.rs"), SUPPRESSED);
    fix(&directory, &["--allow-no-vcs"]).assert_code(0);
    assert_eq!(read(&directory, "src/lib.rs"), unsuppressed());
}

#[test]
fn the_repository_of_a_member_is_asked_as_well() {
    let manifest = b"[workspace]\nmembers = [\"inner\"]\n[package]\nname = \"outer\"\nedition = \"2024\"\n";
    let directory = repository("fix_nested", &[("src/lib.rs", b"")]);
    write(&directory, "Cargo.toml", manifest);
    write(&directory, ".gitignore", b"/inner\n/target\nCargo.lock\n");
    commit(&directory);
    write(&directory, "inner/Cargo.toml", b"[package]\nname = \"inner\"\nedition = \"2024\"\n");
    write(&directory, "inner/src/lib.rs", SUPPRESSED.as_bytes());
    let inner = directory.join("inner");
    git(&inner, &["init", "--quiet"]);
    commit(&inner);
    write(&inner, "notes.txt", b"");
    fix(&directory, &["--workspace"]).assert_code(101).assert_stderr("  * notes.txt (dirty)\n");
    assert_eq!(read(&inner, "src/lib.rs"), SUPPRESSED);
    commit(&inner);
    fix(&directory, &["--workspace"]).assert_code(0);
    assert_eq!(read(&inner, "src/lib.rs"), unsuppressed());
}

#[test]
fn a_diff_writes_nothing_and_can_be_applied() {
    let directory = repository("fix_diff", &[("src/lib.rs", SUPPRESSED.as_bytes())]);
    write(&directory, "notes.txt", b"dirty, and that is fine");
    let shown = fix(&directory, &["--diff"]);
    shown.assert_code(100).assert_stderr("would make 1 fix");
    assert_eq!(read(&directory, "src/lib.rs"), SUPPRESSED);
    write(&directory, "target/fix.diff", shown.stdout.as_bytes());
    git(&directory, &["apply", "target/fix.diff"]);
    assert_eq!(read(&directory, "src/lib.rs"), unsuppressed());
    let shown = run(&directory, ["--diff"]);
    assert_eq!(shown.assert_code(0).stdout, "");
}

#[test]
fn programs_are_told_what_was_fixed() {
    let directory = repository("fix_json", &[("src/lib.rs", SUPPRESSED.as_bytes())]);
    for (args, code, outcome) in
        [(&["--diff", "--message-format=json"][..], 100, "would_fix"), (&["--message-format=json"], 0, "fixed")]
    {
        let done = fix(&directory, args);
        let first: serde_json::Value =
            serde_json::from_str(done.assert_code(code).stdout.lines().next().expect("a line")).expect("it is JSON");
        assert_eq!((&first["reason"], &first["outcome"]), (&"ceid-fix".into(), &outcome.into()));
        assert_eq!((&first["code"], &first["line"]), (&"ceid::unused_suppression".into(), &5.into()));
        for message in cargo_metadata::Message::parse_stream(done.stdout.as_bytes()) {
            message.expect("readers of cargo's messages go on");
        }
    }
}

#[test]
fn whatever_the_text_looks_like_the_rest_stays() {
    let windows = SUPPRESSED.replace('\n', "\r\n");
    let tabs = SUPPRESSED.replace("    ", "\t");
    for (name, text) in [
        ("windows", windows.clone()),
        ("mark", format!("\u{feff}{windows}")),
        ("tabs", tabs),
        ("end", SUPPRESSED.trim_end().to_owned()),
        ("wide", SUPPRESSED.replace("every cycle", "é𝛼 every cycle").replace("kf", "kalmän")),
    ] {
        let directory = repository(&format!("fix_text_{name}"), &[("src/lib.rs", text.as_bytes())]);
        fix(&directory, &[]).assert_code(0);
        let expected: String = text.split_inclusive('\n').filter(|line| !line.contains("ceid:")).collect();
        assert_eq!(read(&directory, "src/lib.rs"), expected, "{name}");
    }
}

#[cfg(unix)]
#[test]
fn a_read_only_file_is_named_and_the_others_are_fixed() {
    use std::os::unix::fs::PermissionsExt;
    let lib = format!("mod other;\n{SUPPRESSED}");
    let directory =
        repository("fix_read_only", &[("src/lib.rs", lib.as_bytes()), ("src/other.rs", SUPPRESSED.as_bytes())]);
    let file = directory.join("src/lib.rs");
    fs::set_permissions(&file, fs::Permissions::from_mode(0o444)).expect("it is ours");
    let done = fix(&directory, &[]);
    done.assert_code(101).assert_stderr("src/lib.rs:6: not fixed (ceid::unused_suppression): cannot write");
    done.assert_stderr("it is read-only").assert_stderr("fixed src/other.rs (1 fix)");
    assert_eq!((read(&directory, "src/lib.rs"), read(&directory, "src/other.rs")), (lib, unsuppressed()));
}

#[cfg(unix)]
#[test]
fn a_symbolic_link_is_written_through_inside_the_workspace_only() {
    use std::os::unix::fs::symlink;
    let outside = temporary("fix_link_outside");
    write(&outside, "far.rs", SUPPRESSED.as_bytes());
    let directory =
        repository("fix_link", &[("src/lib.rs", b"mod near;\nmod far;\n"), ("shared/near.rs", SUPPRESSED.as_bytes())]);
    symlink("../shared/near.rs", directory.join("src/near.rs")).expect("links can be made");
    symlink(outside.join("far.rs"), directory.join("src/far.rs")).expect("links can be made");
    commit(&directory);
    fix(&directory, &[]).assert_code(101).assert_stderr("it lies outside the workspace");
    assert!(directory.join("src/near.rs").is_symlink());
    assert_eq!(read(&directory, "shared/near.rs"), unsuppressed());
    assert_eq!(read(&outside, "far.rs"), SUPPRESSED);
}

#[test]
fn a_file_of_two_targets_is_fixed_once() {
    let directory = repository(
        "fix_twice",
        &[
            ("src/lib.rs", b"#[path = \"shared.rs\"] pub mod one;\n#[path = \"shared.rs\"] pub mod two;\n"),
            ("src/main.rs", b"mod shared;\nfn main() {}\n"),
            ("src/shared.rs", SUPPRESSED.as_bytes()),
        ],
    );
    fix(&directory, &[]).assert_code(0).assert_stderr("fixed src/shared.rs (1 fix)");
    assert_eq!(read(&directory, "src/shared.rs"), unsuppressed());
}

#[test]
fn nothing_is_fixed_beside_what_cannot_be_parsed() {
    let lib = format!("mod broken;\n{SUPPRESSED}");
    let directory = repository("fix_broken", &[("src/lib.rs", lib.as_bytes()), ("src/broken.rs", b"fn (\n")]);
    fix(&directory, &[]).assert_code(101).assert_stderr("nothing was fixed");
    assert_eq!(read(&directory, "src/lib.rs"), lib);
}

#[test]
fn a_fix_that_brings_something_new_is_taken_back_alone() {
    let bad = "\
use super::{Kalman, SampledFilter};
pub fn host(mut kf: Kalman, mut plugin: impl FnMut(&mut Kalman)) {
    loop {
        kf.update();
        plugin(&mut kf);
        kf.update();
    }
}
";
    let good = "\
use super::{Kalman, SampledFilter};
pub fn run(mut kf: Kalman) {
    loop {
        kf.update();
        kf.update();
    }
}
";
    let lib = SUPPRESSED.lines().take(3).map(|line| format!("{line}\n")).collect::<String>() + "mod bad;\nmod good;\n";
    let directory = repository(
        "fix_taken_back",
        &[("src/lib.rs", lib.as_bytes()), ("src/bad.rs", bad.as_bytes()), ("src/good.rs", good.as_bytes())],
    );
    let untouched = fix(&directory, &[]);
    untouched.assert_code(100).assert_stderr("2 fixes may not be what was meant; `--unsafe-fixes` makes them");
    let done = fix(&directory, &["--unsafe-fixes"]);
    done.assert_code(100).assert_stderr("fixed src/good.rs (1 fix)\n  line 5: remove this update");
    done.assert_stderr("src/bad.rs:6: not fixed (ceid::repeated_update): `kf` in `host` would be unproved");
    assert_eq!(read(&directory, "src/bad.rs"), bad);
    assert_eq!(read(&directory, "src/good.rs"), good.replacen("        kf.update();\n", "", 1));
}

#[test]
fn what_is_not_fixed_is_told_with_its_line_on_the_disk() {
    let own = "\
use super::{Kalman, SampledFilter};
pub fn run(mut kf: Kalman) {
    loop {
        kf.update();
        kf.update();
    }
}
pub fn host(mut kf: Kalman, mut plugin: impl FnMut(&mut Kalman)) {
    loop {
        kf.update();
        plugin(&mut kf);
        kf.update();
    }
}
";
    let lib = SUPPRESSED.lines().take(3).map(|line| format!("{line}\n")).collect::<String>() + "mod own;\n";
    let directory =
        repository("fix_lines_of_a_diff", &[("src/lib.rs", lib.as_bytes()), ("src/own.rs", own.as_bytes())]);
    let shown = fix(&directory, &["--unsafe-fixes", "--diff"]);
    shown.assert_code(100).assert_stderr("src/own.rs:12: not fixed (ceid::repeated_update): ");
    let done = fix(&directory, &["--unsafe-fixes"]);
    done.assert_code(100).assert_stderr("src/own.rs:11: not fixed (ceid::repeated_update): ");
}

#[test]
fn flags_that_do_not_go_together_are_wrong_usage() {
    let directory = temporary_package("fix_usage", &[("src/lib.rs", b"")]);
    for args in [
        &["--unsafe-fixes"][..],
        &["--allow-dirty"],
        &["fix", "--with", "check"],
        &["fix", "--stdin-filename", "src/lib.rs"],
        &["fix", "--diff", "--message-format", "sarif"],
    ] {
        run(&directory, args).assert_code(2);
    }
}

/// Killed at any moment, the program leaves each file old or new, in full.
#[test]
fn a_kill_leaves_each_file_whole() {
    let names: Vec<String> = (0..16).map(|number| format!("m{number}")).collect();
    let lib: String = names.iter().map(|name| format!("pub mod {name};\n")).collect();
    let paths: Vec<String> = names.iter().map(|name| format!("src/{name}.rs")).collect();
    let mut files: Vec<(&str, &[u8])> = paths.iter().map(|path| (path.as_str(), SUPPRESSED.as_bytes())).collect();
    files.push(("src/lib.rs", lib.as_bytes()));
    let directory = repository("fix_kill", &files);
    let is_staged = || {
        let mut entries = fs::read_dir(directory.join("src")).expect("it is there");
        entries.any(|entry| entry.is_ok_and(|entry| entry.file_name().to_string_lossy().starts_with(".ceid-lint-")))
    };
    let mut partial: u32 = 0;
    for number in 0..8 {
        git(&directory, &["checkout", "--quiet", "."]);
        git(&directory, &["clean", "--quiet", "--force"]);
        let mut child = Command::new(program())
            .args(["fix", "--quiet"])
            .current_dir(&directory)
            .stderr(Stdio::null())
            .spawn()
            .expect("the program was built and starts");
        // Half of the runs are killed while the files are staged, the others once the first of them is replaced.
        let is_reached = || if number % 2 == 0 { is_staged() } else { read(&directory, &paths[0]) != SUPPRESSED };
        while !is_reached() && child.try_wait().expect("it is ours").is_none() {
            // Waiting must not take the core on which the program runs.
            std::thread::sleep(Duration::from_micros(50));
        }
        std::thread::sleep(Duration::from_micros(number * 100));
        child.kill().expect("it is ours");
        child.wait().expect("it is ours");
        let new = paths.iter().filter(|path| {
            let text = read(&directory, path);
            assert!(text == SUPPRESSED || text == unsuppressed(), "{path} in run {number}: {text}");
            text != SUPPRESSED
        });
        partial += u32::from((1..paths.len()).contains(&new.count()));
    }
    println!("killed between two files: {partial}");
}

/// What killed runs left is no change that has to be committed, and the next run removes it. Only some systems tell at once that a
/// process is gone.
#[cfg(target_os = "linux")]
#[test]
fn what_a_killed_run_left_is_removed_by_the_next() {
    let directory = repository("fix_left", &[("src/lib.rs", SUPPRESSED.as_bytes())]);
    for name in [".ceid-lint-4294967295-0.tmp", "src/.ceid-lint-4294967295-1.tmp"] {
        write(&directory, name, SUPPRESSED.as_bytes());
    }
    fix(&directory, &["--diff"]).assert_code(100);
    assert_eq!(
        git(&directory, &["status", "--porcelain"]).lines().count(),
        2,
        "a run that writes nothing removed something"
    );
    fix(&directory, &[]).assert_code(0);
    assert_eq!(git(&directory, &["status", "--porcelain"]), " M src/lib.rs\n");
    commit(&directory);
    write(&directory, "src/.ceid-lint-4294967295-1.tmp", b"");
    run(&directory, ["migrate", "--all"]).assert_code(0);
    assert!(!directory.join("src/.ceid-lint-4294967295-1.tmp").exists());
}

/// A run that was ended when it had written some files of a change is told of, and brought to its end by the next one that writes.
#[cfg(target_os = "linux")]
#[test]
fn what_a_killed_run_wrote_in_part_is_completed() {
    let directory = repository("fix_half", &[("src/lib.rs", b"pub mod a;\n"), ("src/a.rs", b"// old\n")]);
    let hash = |text: &[u8]| format!("{:016x}", cargo_ceid_lint::source::stable_hash(text));
    let (old, new) = (hash(b"// old\n"), hash(b"// new\n"));
    let note = format!(
        "# a comment\n{}\t{}\tsrc/.ceid-lint-4294967295-0.tmp\tsrc/lib.rs\n\
         {old}\t{new}\tsrc/.ceid-lint-4294967295-1.tmp\tsrc/a.rs\n",
        hash(b"pub mod b;\n"),
        hash(b"pub mod a;\n")
    );
    let half = |staged: &[u8]| {
        write(&directory, ".ceid-lint-4294967295-2.note", note.as_bytes());
        write(&directory, "src/.ceid-lint-4294967295-1.tmp", staged);
    };
    half(b"// new\n");
    run(&directory, ["check"]).assert_code(0).assert_stderr(
        "a run was ended when it had written `src/lib.rs`, and not `src/a.rs`, which belong together; `cargo ceid-lint fix` brings",
    );
    run(&directory, ["baseline"]).assert_code(0);
    for writing in [["fix", "--workspace"], ["migrate", "--all"]] {
        half(b"// new\n");
        write(&directory, "src/a.rs", b"// old\n");
        run(&directory, writing).assert_code(101).assert_stderr("that is done now");
        assert_eq!(read(&directory, "src/a.rs"), "// new\n");
        assert!(!directory.join(".ceid-lint-4294967295-2.note").exists());
        assert!(!directory.join("src/.ceid-lint-4294967295-1.tmp").exists());
    }
    // What was to be written is not there in full.
    half(b"// n");
    write(&directory, "src/a.rs", b"// old\n");
    fix(&directory, &[]).assert_code(101).assert_stderr("take the changes of `src/lib.rs` back");
    assert_eq!(read(&directory, "src/a.rs"), "// old\n");
    assert!(!directory.join(".ceid-lint-4294967295-2.note").exists());
    assert!(!directory.join("src/.ceid-lint-4294967295-1.tmp").exists());
}

/// A manifest with a dependency on ceid-core, whose sources are read then.
fn manifest_with_core() -> String {
    let core = Path::new(env!("CARGO_MANIFEST_DIR")).join("../ceid-core").canonicalize().expect("it is there");
    format!(
        "[package]\nname = \"hall\"\nversion = \"0.1.0\"\nedition = \"2021\"\n\n[dependencies]\nceid-core = {{ path = {core:?} }}\n"
    )
}

#[test]
fn a_guard_of_a_driver_is_named_where_ceid_core_is_read() {
    let lib = "\
use ceid_core::prelude::*;
pub struct Lag;
impl<R: Rate> SampledFilter<R> for Lag {
    fn update(&mut self, _: Tick<'_, R>) {}
}
filters! { pub struct Filters @ 100 Hz { pub speed: Lag } }
pub fn run(mut pull: impl FnMut() -> bool) {
    let mut control = Cyclic::new(Filters::register(Lag), Free::<Hz<100>>::new());
    while pull() {
        let _ = control.cycle();
        pull();
    }
}
";
    let manifest = manifest_with_core();
    let files = [("Cargo.toml", manifest.as_bytes()), ("src/lib.rs", lib.as_bytes())];
    let directory = repository("fix_driver", &files);
    fix(&directory, &[]).assert_code(0).assert_stderr("give the guard a name");
    assert_eq!(read(&directory, "src/lib.rs"), lib.replace("let _ =", "let _guard ="));
}

#[test]
fn a_guard_takes_imports_along_that_nothing_needs_any_more() {
    let manifest = manifest_with_core();
    let filter = "\
pub trait SampledFilter {
    fn update(&mut self);
}
#[derive(Default)]
pub struct Hall {
    pub level: f32,
    pub mean: f32,
}
impl SampledFilter for Hall {
    fn update(&mut self) {
        self.mean += 0.5 * (self.level - self.mean);
    }
}
";
    let lib = "\
#![deny(warnings)]
pub mod filter;
use filter::{Hall, SampledFilter};

pub fn watch(levels: &[f32]) -> f32 {
    let mut hall = Hall::default();
    for level in levels {
        if *level < 0.0 {
            continue;
        }
        hall.level = *level;
        hall.update();
    }
    hall.mean
}
";
    let files =
        [("Cargo.toml", manifest.as_bytes()), ("src/lib.rs", lib.as_bytes()), ("src/filter.rs", filter.as_bytes())];
    let directory = repository("fix_idle_import", &files);
    fix(&directory, &["--unsafe-fixes"]).assert_code(0).assert_stderr("let a guard update `hall`");
    let fixed = read(&directory, "src/lib.rs");
    assert!(fixed.contains("\nuse filter::Hall;\n") && fixed.contains("=> hall);"), "{fixed}");
}

#[test]
fn fixes_of_several_rounds_are_told_in_the_lines_that_were_there() {
    let text = SUPPRESSED.lines().take(3).map(|line| format!("{line}\n")).collect::<String>()
        + "pub fn run(mut kf: Kalman) {\n    loop {\n        kf.update();\n        kf.update();\n        kf.update();\n    }\n}\n";
    let directory = repository("fix_in_rounds", &[("src/lib.rs", text.as_bytes())]);
    let done = fix(&directory, &["--unsafe-fixes"]);
    done.assert_code(0).assert_stderr("fixed src/lib.rs (2 fixes)\n  line 7: remove this update");
    done.assert_stderr("\n  line 8: remove this update");
}
