//! What is written to a terminal and to nothing else. The program `script`, which most Linux systems have, makes the terminal.

#![cfg(target_os = "linux")]

use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

use crate::support::program::program;
use crate::support::workspace::{GUILTY, temporary_package};

const LINK: &str = "\x1b]8;;";
const BAR: &str = "Checking\x1b[0m [";
const ERASURE: &str = "\x1b[K";

/// What decides about colours, links and bars, and is set here by nobody but the test.
const SETTINGS: &[&str] = &[
    "CI",
    "CARGO_TERM_COLOR",
    "CARGO_TERM_HYPERLINKS",
    "CARGO_TERM_PROGRESS_WHEN",
    "CARGO_TERM_PROGRESS_WIDTH",
    "CARGO_TERM_QUIET",
    "CLICOLOR",
    "CLICOLOR_FORCE",
    "COLORTERM",
    "DOMTERM",
    "FORCE_HYPERLINK",
    "KONSOLE_VERSION",
    "NO_COLOR",
    "TERM_PROGRAM",
    "TF_BUILD",
    "VTE_VERSION",
    "WT_SESSION",
];

/// Variables of the environment.
type Settings<'a> = &'a [(&'a str, &'a str)];

fn run(mut command: Command, folder: &Path, settings: Settings<'_>) -> String {
    for name in SETTINGS {
        command.env_remove(name);
    }
    command.env("TERM", "xterm-256color").envs(settings.iter().copied()).current_dir(folder).stdin(Stdio::null());
    let Output { stdout, stderr, .. } = command.output().expect("the program was built and starts");
    String::from_utf8_lossy(&stdout).into_owned() + &String::from_utf8_lossy(&stderr)
}

/// What a terminal of 72 columns is sent; nothing where no terminal can be made.
fn on_terminal(folder: &Path, args: &str, settings: Settings<'_>) -> Option<String> {
    let is_there = Command::new("script").arg("--version").stdout(Stdio::null()).status().is_ok();
    if !is_there {
        return None;
    }
    let line = format!("stty rows 24 cols 72 -opost; exec '{}' {args}", program().display());
    let mut command = Command::new("script");
    command.args(["-q", "-c", &line, "/dev/null"]);
    Some(run(command, folder, settings))
}

fn in_pipe(folder: &Path, args: &str, settings: Settings<'_>) -> String {
    let mut command = Command::new(program());
    command.args(args.split_whitespace());
    run(command, folder, settings)
}

#[test]
fn name_of_a_file_is_a_link_where_cargo_writes_links() {
    let folder = temporary_package("terminal é links", &[("src/lib.rs", GUILTY.as_bytes())]);
    let Some(plain) = on_terminal(&folder, "", &[]) else { return };
    assert!(plain.contains("src/lib.rs:7:9") && !plain.contains(LINK), "{plain:?}");

    let url = format!("{}/src/lib.rs", folder.display()).replace(' ', "%20").replace('é', "%C3%A9");
    let expected = format!("{LINK}file://{url}\x1b\\src/lib.rs{LINK}\x1b\\:7:9");
    let config: &[&str] = &["--config term.hyperlinks=true", "-q --config term.hyperlinks=true"];
    for args in config {
        let shown = on_terminal(&folder, args, &[("CARGO_TERM_HYPERLINKS", "false")]).expect("as before");
        assert!(shown.contains(&expected), "{shown:?}");
    }
    let with: &[Settings<'_>] = &[
        &[("CARGO_TERM_HYPERLINKS", "true")],
        &[("TERM_PROGRAM", "WezTerm")],
        &[("VTE_VERSION", "6800")],
        &[("KONSOLE_VERSION", "230802")],
        &[("TERM", "xterm-kitty")],
        &[("FORCE_HYPERLINK", "1")],
    ];
    for settings in with {
        let shown = on_terminal(&folder, "", settings).expect("as before");
        assert!(shown.contains(&expected), "{settings:?}: {shown:?}");
    }
    let without: &[Settings<'_>] = &[
        &[("CARGO_TERM_HYPERLINKS", "false"), ("TERM_PROGRAM", "WezTerm")],
        &[("TERM_PROGRAM", "iTerm.app")],
        &[("VTE_VERSION", "4600")],
        &[("CARGO_TERM_HYPERLINKS", "true"), ("NO_COLOR", "1")],
        &[("CARGO_TERM_HYPERLINKS", "true"), ("TERM", "dumb")],
        &[("FORCE_HYPERLINK", "0"), ("TERM_PROGRAM", "WezTerm")],
    ];
    for settings in without {
        let shown = on_terminal(&folder, "", settings).expect("as before");
        assert!(!shown.contains(LINK) && shown.contains("src/lib.rs:7:9"), "{settings:?}: {shown:?}");
    }
    let settings = [("CARGO_TERM_HYPERLINKS", "true"), ("FORCE_HYPERLINK", "1"), ("CARGO_TERM_COLOR", "always")];
    for args in ["", "--message-format json-diagnostic-rendered-ansi", "--message-format short"] {
        let printed = in_pipe(&folder, args, &settings);
        assert!(!printed.contains(LINK) && printed.contains("src/lib.rs"), "{printed:?}");
    }
}

/// So many loops, one of them with a finding.
fn loops(count: usize) -> PathBuf {
    let mut text = GUILTY.to_owned();
    for number in 0..count {
        let _ = writeln!(
            text,
            "pub fn f{number}(mut kf: Kalman, x: u32) {{ loop {{ if x > {number} {{ kf.update(); }} else if x == 1 {{ \
             kf.update(); }} else {{ let y = x + 1; kf.update(); g(y); }} }} }}"
        );
    }
    temporary_package("terminal_bar", &[("src/lib.rs", text.as_bytes())])
}

#[test]
fn bar_is_shown_on_a_terminal_and_gone_before_anything_else() {
    // How much code is enough for a run that is worth a bar depends on the machine and on the build.
    let mut found = None;
    for count in [250, 1_000, 4_000, 16_000, 64_000] {
        let folder = loops(count);
        let Some(shown) = on_terminal(&folder, "", &[]) else { return };
        found = Some((folder, shown));
        if found.as_ref().is_some_and(|(_, shown)| shown.matches(BAR).count() > 1) {
            break;
        }
    }
    let (folder, shown) = found.expect("one was tried");
    let last = shown.rfind(BAR).unwrap_or_else(|| panic!("no bar: {shown:?}"));
    assert!(shown.trim_start_matches("\x1b[1;36m").starts_with("    Checking"), "{shown:?}");
    let rest = &shown[last..];
    let erased = rest.find(ERASURE).expect("it is erased");
    let (bar, rest) = rest.split_at(erased);
    assert!(bar.ends_with("%\r") && bar.len() < 72 + BAR.len(), "{bar:?}");
    assert!(rest[ERASURE.len()..].contains("ceid::repeated_update") && !bar.contains("ceid::"), "{shown:?}");

    let expected: &[(&str, Settings<'_>, bool)] = &[
        ("--message-format json", &[("CARGO_TERM_PROGRESS_WIDTH", "50")], true),
        ("", &[("CARGO_TERM_PROGRESS_WHEN", "always"), ("CARGO_TERM_PROGRESS_WIDTH", "60"), ("CI", "1")], true),
        ("-q", &[], false),
        ("", &[("CI", "1")], false),
        ("", &[("TERM", "dumb")], false),
        ("", &[("CARGO_TERM_PROGRESS_WHEN", "never")], false),
        ("--config term.progress.when=\\\"never\\\"", &[], false),
    ];
    for (args, settings, is_expected) in expected {
        let shown = on_terminal(&folder, args, settings).expect("as before");
        assert_eq!(shown.contains("Checking"), *is_expected, "{args} {settings:?}: {shown:?}");
        assert!(shown.contains("repeated_update"), "{shown:?}");
    }
    assert!(!in_pipe(&folder, "", &[("CARGO_TERM_COLOR", "always")]).contains("Checking"));
}

#[test]
fn short_run_shows_no_bar() {
    let folder = temporary_package("terminal_short", &[("src/lib.rs", b"")]);
    let Some(shown) = on_terminal(&folder, "", &[]) else { return };
    assert!(!shown.contains("    Checking"), "{shown:?}");
}

#[test]
fn while_cargo_is_asked_that_is_shown() {
    use std::os::unix::fs::PermissionsExt as _;

    let folder = temporary_package("terminal_cargo", &[("src/lib.rs", b"")]);
    let cargo = std::env::var("CARGO").unwrap_or_else(|_| "cargo".to_owned());
    let slow = folder.join("slow-cargo");
    std::fs::write(&slow, format!("#!/bin/sh\nsleep 1\nexec '{cargo}' \"$@\"\n")).expect("it can be written");
    std::fs::set_permissions(&slow, std::fs::Permissions::from_mode(0o755)).expect("it was written");
    let slow = slow.to_str().expect("the folder has a plain name");
    let Some(shown) = on_terminal(&folder, "", &[("CARGO", slow)]) else { return };
    let (asking, rest) = shown.split_once(ERASURE).unwrap_or_else(|| panic!("nothing is shown: {shown:?}"));
    assert_eq!(asking, "\x1b[1;36m   Resolving\x1b[0m the dependencies with cargo\r");
    assert!(rest.contains("nothing to check") && !rest.contains("Resolving"), "{shown:?}");
    let quiet = on_terminal(&folder, "-q", &[("CARGO", slow)]).expect("as before");
    assert!(!quiet.contains("Resolving"), "{quiet:?}");
}
