//! The migration guide, done as it says on a copy of its robot.

use std::fmt::Write as _;
use std::fs;
use std::path::Path;
use std::process::{Command, Output, Stdio};

use super::read;
use crate::support::program::program;
use crate::support::{root, workspace};

/// A block of the guide: the word behind its fence, and its text.
struct Block<'t> {
    kind: &'t str,
    text: &'t str,
}

fn blocks(guide: &str) -> Vec<Block<'_>> {
    let mut parts = guide.split("\n```");
    let mut blocks = Vec::new();
    parts.next();
    while let (Some(block), Some(_)) = (parts.next(), parts.next()) {
        let (kind, text) = block.split_once('\n').expect("a block has lines");
        blocks.push(Block { kind, text });
    }
    blocks
}

/// Runs a command of the guide, and answers what it prints.
fn printed(directory: &Path, line: &str) -> String {
    let words: Vec<&str> = line.split_whitespace().collect();
    let core = root().join("ceid-core").to_string_lossy().into_owned();
    let words: Vec<&str> = words.into_iter().map(|word| if word == "../ceid-core" { &core } else { word }).collect();
    let mut command = match words.as_slice() {
        ["cargo", "ceid-lint", rest @ ..] => {
            let mut command = Command::new(program());
            command.args(rest);
            command
        }
        ["cargo", rest @ ..] => {
            let mut command = Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
            let target = Path::new(env!("CARGO_TARGET_TMPDIR")).join("migrate_target");
            command.args(rest).arg("--offline").env("CARGO_TARGET_DIR", target);
            command
        }
        ["git", rest @ ..] => {
            let mut command = Command::new("git");
            command.args(["-c", "user.name=Ada", "-c", "user.email=ada@example.org"]).args(rest);
            command
        }
        _ => panic!("`{line}` is no command of the guide"),
    };
    let command = command.current_dir(directory).env("NO_COLOR", "1").env_remove("RUSTFLAGS").stdin(Stdio::null());
    let Output { stdout, stderr, .. } = command.output().expect("it starts");
    let text = String::from_utf8_lossy(&stdout).into_owned() + &String::from_utf8_lossy(&stderr);
    // What differs from machine to machine, and what only says which files are compared.
    let lines = text.lines().filter(|line| !line.starts_with("index ") && !line.starts_with("diff --git "));
    lines.fold(String::new(), |text, line| text + line + "\n")
}

/// Changes files as a patch says.
#[track_caller]
fn apply(directory: &Path, patch: &str) {
    let path = directory.with_extension("patch");
    fs::write(&path, patch).expect("the directory is writable");
    let output = Command::new("git").arg("apply").arg(&path).current_dir(directory).output().expect("git is there");
    assert!(output.status.success(), "{}\n{patch}", String::from_utf8_lossy(&output.stderr));
}

#[test]
fn guide_does_what_it_says() {
    let path = root().join("cargo-ceid-lint/docs/migration.md");
    let mut guide = read(&path);
    let directory = workspace::temporary("migrate_guide");
    super::cases::copy(&workspace::committed("legacy_robot"), &directory, "");
    // The lines are as long as rustfmt has them by itself, not as in this workspace.
    fs::write(directory.join("rustfmt.toml"), "").expect("the directory is writable");
    let text = guide.clone();
    let mut blocks = blocks(&text).into_iter().peekable();
    let mut wrong = String::new();
    while let Some(block) = blocks.next() {
        match block.kind {
            "console" => {
                let commands = block.text.lines().map(|line| line.strip_prefix("$ ").expect("each line is a command"));
                let found = commands.fold(String::new(), |_, line| printed(&directory, line));
                let expected = blocks
                    .next_if(|next| next.kind == "text" || next.kind == "diff" && block.text.contains("git diff"));
                let shown = expected.map_or("", |expected| expected.text);
                if found.trim_end() != shown {
                    write!(wrong, "{}\nprints\n{found}\nand not\n{shown}\n", block.text).expect("a String");
                    guide = guide.replacen(&format!("\n{shown}\n```"), &format!("\n{}\n```", found.trim_end()), 1);
                }
            }
            "diff" => apply(&directory, &format!("{}\n", block.text)),
            other => panic!("a block of `{other}` means nothing here"),
        }
    }
    if std::env::var_os("CEID_MIGRATE_BLESS").is_some() {
        fs::write(path, guide).expect("the guide is writable");
        return;
    }
    assert!(wrong.is_empty(), "{wrong}");
}

#[test]
fn page_of_the_rule_shows_what_is_written() {
    let page = read(&root().join("cargo-ceid-lint/src/rules/unguarded_update.md"));
    let blocks = blocks(&page);
    let [before, after] = blocks.as_slice() else { panic!("the page has two programs") };
    let directory = super::package("migrate_page", &[("robot".to_owned(), format!("{}\n", before.text))]);
    super::migrate(&directory, &["--all"]).assert_code(0);
    assert_eq!(super::binary(&directory, "robot"), format!("{}\n", after.text));
}
