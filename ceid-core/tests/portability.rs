//! The table of platforms in the documentation says of each target what `portability/check.sh` does there, and keeps what
//! the paper's Table 1 says.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::process::Command;

#[test]
fn the_documentation_says_what_the_script_does() {
    let script = root().join("portability/check.sh");
    let Ok(output) = Command::new("bash").arg(script).arg("--list").output() else {
        // The script is for Linux; elsewhere there may be nothing that reads it.
        return;
    };
    let list = String::from_utf8(output.stdout).expect("it lists names");
    let done: BTreeMap<_, _> = list.lines().filter_map(|line| line.split_once(' ')).collect();
    assert!(!done.is_empty(), "the script lists no target");
    let table = table();
    let documented: BTreeMap<_, _> =
        table.iter().filter(|row| row[4] != "cargo test").map(|row| (row[4].as_str(), row[3].as_str())).collect();
    assert_eq!(documented, done);
}

/// Table 1 of the paper: the row "Porting".
#[test]
fn the_table_has_the_platforms_of_the_paper() {
    let table = table();
    for (platform, porting) in [
        ("Linux PC", "yes (g++ 4.7.3)"),
        ("Mac", "yes (g++ 4.8.2, clang 9.0)"),
        ("Raspberry Pi", "yes (g++ 6.3.0)"),
        ("Arduino", "no: N/A (g++ 5.4.0)"),
    ] {
        let row = table.iter().find(|row| row[0].starts_with(platform) && row[2] == porting);
        assert!(row.is_some(), "{platform}: {porting}");
    }
}

/// The rows of the table, without its head.
fn table() -> Vec<Vec<String>> {
    let readme = fs::read_to_string(root().join("README.md")).expect("the crate has a README");
    let section = readme.split("## Portability").nth(1).expect("it has that section");
    let rows: Vec<_> = section
        .lines()
        .skip_while(|line| !line.starts_with("| ---"))
        .skip(1)
        .take_while(|line| line.starts_with('|'))
        .map(|line| line.trim_matches('|').split('|').map(|cell| cell.trim().replace('`', "")).collect::<Vec<_>>())
        .collect();
    assert!(rows.iter().all(|row| row.len() == 5), "each row has five cells");
    rows
}

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}
