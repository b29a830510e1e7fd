//! The command line: both ways to call it, and the flags that editors send.

use std::path::Path;
use std::process::Command;

use crate::support::program::{program, run, run_command};
use crate::support::workspace::{GUILTY, committed, temporary_package};

#[test]
fn cargo_subcommand_and_program_are_alike() {
    let directory = committed("figure3_legacy");
    let args = ["--message-format", "json"];
    let direct = run_command(Command::new(program()).args(args).current_dir(&directory));

    let bin = program().parent().expect("it lies in a directory").to_path_buf();
    let path = std::env::var_os("PATH").unwrap_or_default();
    let paths = std::iter::once(bin).chain(std::env::split_paths(&path));
    let path = std::env::join_paths(paths).expect("no path holds a separator");
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let by_cargo =
        run_command(Command::new(cargo).arg("ceid-lint").args(args).current_dir(&directory).env("PATH", path));

    direct.assert_code(100);
    by_cargo.assert_code(100);
    assert_eq!(by_cargo.stdout, direct.stdout);
    assert_eq!(run(&directory, args).stdout, direct.stdout);
}

#[test]
fn flags_of_rust_analyzer_are_understood() {
    let directory = committed("figure3_legacy");
    let manifest = directory.join("Cargo.toml").display().to_string();
    let flags = ["--workspace", "--message-format=json", "--manifest-path", &manifest, "--keep-going", "--all-targets"];
    let run = run(Path::new(env!("CARGO_TARGET_TMPDIR")), flags);
    run.assert_code(100);

    let mut rules = Vec::new();
    for message in cargo_metadata::Message::parse_stream(run.stdout.as_bytes()) {
        match message.expect("every line is a message") {
            cargo_metadata::Message::CompilerMessage(message) => {
                rules.extend(message.message.code.map(|code| code.code));
            }
            cargo_metadata::Message::TextLine(line) => panic!("`{line}` is no message of cargo"),
            _ => {}
        }
    }
    rules.sort();
    assert_eq!(rules, ["ceid::missed_update", "ceid::repeated_update"]);
}

#[test]
fn machine_output_is_on_stdout_and_human_output_on_stderr() {
    let directory = temporary_package("cli_streams", &[("src/lib.rs", GUILTY.as_bytes())]);
    let human = run(&directory, [""; 0]);
    assert_eq!(human.stdout, "");
    human.assert_stderr("repeated_update").assert_stderr("src/lib.rs:7");
    let json = run(&directory, ["--message-format", "json"]);
    assert!(!json.stderr.contains("src/lib.rs:7"), "{}", json.stderr);
}

#[test]
fn path_argument_restricts_what_is_reported() {
    let module = format!("mod a;\n{GUILTY}");
    let directory =
        temporary_package("cli_path", &[("src/lib.rs", module.as_bytes()), ("src/a.rs", GUILTY.as_bytes())]);
    let all = run(&directory, ["--message-format", "json"]).findings().expect("the package is readable");
    assert_eq!(all.len(), 2);
    let one = run(&directory, ["--message-format", "json", "src/a.rs"]).findings().expect("the package is readable");
    assert_eq!(one.iter().map(|finding| finding.file.as_str()).collect::<Vec<_>>(), ["src/a.rs"]);
}

#[test]
fn output_is_the_same_each_time() {
    let directory = committed("two_crates");
    let first = run(&directory, ["--workspace", "--message-format", "json"]);
    let second = run(&directory, ["--workspace", "--message-format", "json"]);
    assert_eq!(first.stdout, second.stdout);
}

#[test]
fn package_can_be_chosen() {
    let directory = committed("two_crates");
    let run = run(&directory, ["-p", "estimators", "--message-format", "json"]);
    assert_eq!(run.findings().expect("the package is readable"), []);
}

#[test]
fn shells_and_man_learn_every_flag() {
    let directory = committed("figure3_legacy");
    for shell in ["bash", "elvish", "fish", "powershell", "zsh"] {
        let script = run(&directory, ["completions", shell]);
        let text = &script.assert_code(0).stdout;
        assert!(text.contains("message-format") && text.contains("partition"), "{shell}: {text}");
    }
    let page = run(&directory, ["man"]);
    assert!(page.assert_code(0).stdout.contains("\\-\\-partition"), "{}", page.stdout);
    run(&directory, ["completions", "tcsh"]).assert_code(2);
}

#[test]
fn findings_of_cargo_are_passed_on() {
    let text = format!("{GUILTY}\nfn unused() {{}}\n");
    let directory = temporary_package("cli_with", &[("src/lib.rs", text.as_bytes())]);
    let run = run(&directory, ["--with", "check", "--message-format=json", "--offline"]);
    run.assert_code(100);
    let lines: Vec<serde_json::Value> =
        run.stdout.lines().map(|line| serde_json::from_str(line).expect("it is JSON")).collect();
    let codes: Vec<&str> = lines.iter().filter_map(|line| line["message"]["code"]["code"].as_str()).collect();
    assert_eq!(codes, ["dead_code", "ceid::repeated_update"]);
    let ends = lines.iter().filter(|line| line["reason"] == "build-finished").collect::<Vec<_>>();
    assert_eq!((ends.len(), &ends[0]["success"]), (1, &serde_json::json!(false)));
    assert_eq!(lines.last(), ends.last().copied());
    // What cargo has said of the package is not taken back behind it.
    let artifacts = lines.iter().filter(|line| line["reason"] == "compiler-artifact").count();
    assert_eq!(artifacts, 1, "{}", run.stdout);
}

#[test]
fn code_that_does_not_compile_decides_the_exit_code() {
    let text = format!("{GUILTY}\npub fn wrong() -> u8 {{ true }}\n");
    let directory = temporary_package("cli_with_error", &[("src/lib.rs", text.as_bytes())]);
    let run = run(&directory, ["--with", "check", "--message-format", "short", "--offline"]);
    run.assert_code(101).assert_stderr("E0308").assert_stderr("ceid::repeated_update");
}

#[test]
fn unsaved_text_comes_from_stdin() {
    let module = format!("mod a;\n{GUILTY}");
    let directory = temporary_package("cli_stdin", &[("src/lib.rs", module.as_bytes()), ("src/a.rs", b"")]);
    let check = |file: &str, text: &[u8]| {
        let input = directory.join("unsaved");
        std::fs::write(&input, text).expect("the directory is writable");
        let mut command = Command::new(program());
        command.args(["--message-format", "json", "--stdin-filename", file]).current_dir(&directory);
        run_command(command.stdin(std::fs::File::open(&input).expect("it was written")))
    };
    let found = check("src/a.rs", GUILTY.as_bytes()).findings().expect("it can be read");
    assert_eq!(
        found.iter().map(|finding| (finding.file.as_str(), finding.line)).collect::<Vec<_>>(),
        [("src/a.rs", 7)]
    );
    assert_eq!(check("src/lib.rs", b"mod a;\n").findings().expect("it can be read"), []);
    check("src/lib.rs", b"\xff").assert_code(101).assert_stderr("src/lib.rs");
}

#[test]
fn timings_tell_where_the_time_goes() {
    let directory = committed("figure3_legacy");
    let plain = run(&directory, ["--message-format", "json"]);
    for flag in ["--timings", "--timings=html"] {
        let timed = run(&directory, [flag, "--message-format", "json"]);
        timed.assert_code(100);
        assert_eq!(timed.stdout, plain.stdout);
        let parts: Vec<&str> = timed
            .stderr
            .lines()
            .filter(|line| line.ends_with(" ms"))
            .filter_map(|line| line.split(' ').next())
            .collect();
        assert_eq!(
            parts,
            ["project", "gate", "parse", "index", "types", "flow", "count", "findings", "total"],
            "{}",
            timed.stderr
        );
    }
}

#[test]
fn text_of_a_file_that_was_never_saved_is_checked_on_its_own() {
    let directory = temporary_package("cli_new_file", &[("src/lib.rs", b"")]);
    let input = directory.join("unsaved");
    std::fs::write(&input, GUILTY).expect("the directory is writable");
    for (file, shown) in [("src/new.rs", "src/new.rs"), ("../beside_cli_new_file.rs", "beside_cli_new_file.rs")] {
        let mut command = Command::new(program());
        command.args(["--message-format", "json", "--stdin-filename", file]).current_dir(&directory);
        let run = run_command(command.stdin(std::fs::File::open(&input).expect("it was written")));
        let found = run.assert_code(100).findings().expect("it can be read");
        assert_eq!(found.len(), 1, "{file}");
        assert!(found[0].file.ends_with(shown), "{}", found[0].file);
    }
}

#[test]
fn a_mistyped_subcommand_has_the_nearest_right_spelling() {
    let directory = committed("figure3_legacy");
    let help = "did you mean the subcommand `check`?";
    run(&directory, ["chekc"]).assert_code(101).assert_stderr("`chekc` does not exist").assert_stderr(help);
    let path = run(&directory, ["src/nope.rs"]);
    path.assert_code(101).assert_stderr("path `src/nope.rs` does not exist").assert_stderr("it was looked for in");
    assert!(!path.stderr.contains("subcommand"), "{}", path.stderr);
}

#[test]
fn a_subcommand_may_follow_flags() {
    let directory = committed("figure3_legacy");
    for args in [
        &["--offline", "report"][..],
        &["-q", "report"],
        &["--manifest-path", "Cargo.toml", "report", "--color", "never"],
    ] {
        let told = run(&directory, args.iter().copied());
        told.assert_code(0);
        assert!(told.stdout.contains("cycles of"), "{}", told.stdout);
    }
    let known = format!("{}/cli_known.toml", env!("CARGO_TARGET_TMPDIR"));
    run(&directory, ["--color", "never", "baseline", "--baseline", &known]).assert_code(0);
    run(&directory, ["--fix", "rules"]).assert_code(2).assert_stderr("unexpected argument '--fix'");
    run(&directory, ["help", "report"]).assert_code(0);
}

#[test]
fn a_wrong_flag_is_told_and_not_the_manifest() {
    let directory = committed("figure3_legacy");
    let config = run(&directory, ["--config", "nope"]);
    config.assert_code(101).assert_stderr("cargo does not take `--config`").assert_stderr("`nope`");
    assert!(!config.stderr.contains("correct the manifest"), "{}", config.stderr);
    run(&directory, ["--profile", "a/b"]).assert_code(2).assert_stderr("invalid character `/`");
    run(&directory, ["--release", "--profile", "dev"]).assert_code(2).assert_stderr("cannot be used with");
    run(&directory, ["--manifest-path", "src"])
        .assert_code(101)
        .assert_stderr("manifest path `src` is a directory")
        .assert_stderr("did you mean `src/Cargo.toml`?");
}

#[test]
fn a_profile_is_one_of_cargo_or_defined_by_the_workspace_or_the_configuration() {
    let manifest =
        b"[workspace]\n[package]\nname = \"rover\"\nedition = \"2024\"\n[profile.dist]\ninherits = \"release\"\n";
    let configuration = b"[profile.flight]\ninherits = \"release\"\n";
    let files: &[(&str, &[u8])] = &[
        ("Cargo.toml", manifest),
        ("src/lib.rs", b""),
        (".cargo/config.toml", configuration),
        ("bench.toml", b"profile.rig.inherits = \"release\""),
    ];
    let directory = temporary_package("cli_profiles", files);
    for known in ["dev", "release", "test", "bench", "dist", "flight"] {
        run(&directory, ["--profile", known]).assert_code(0);
    }
    run(&directory, ["--profile", "rig", "--config", "bench.toml"]).assert_code(0);
    run(&directory, ["--profile", "rig", "--config", "profile.rig.inherits = \"dev\""]).assert_code(0);
    let told = run(&directory, ["--profile", "fligth"]);
    told.assert_code(101).assert_stderr("profile `fligth` is not defined");
    told.assert_stderr("a profile with a similar name exists: `flight`");
}

#[test]
fn a_feature_is_looked_for_in_the_packages_that_are_selected() {
    let directory = committed("two_crates");
    let told = run(&directory, ["-p", "estimators", "-F", "nope"]);
    told.assert_code(101).assert_stderr("the package `estimators` does not contain the feature `nope`");
}

#[test]
fn two_machine_forms_do_not_share_stdout() {
    let directory = committed("figure3_legacy");
    let both = run(&directory, ["--output", "json=-", "--message-format", "sarif"]);
    both.assert_code(2).assert_stderr("cannot print two forms on stdout at once");
    assert_eq!(both.stdout, "");
    run(&directory, ["--output", "json=-", "--output", "sarif=-"]).assert_code(2);
    run(&directory, ["--output", "json=-"]).assert_code(100);
}
