//! Tests of this floor as a whole.

mod code;
mod conditions;
mod items;
mod known_macros;
mod module_tree;
mod own_macros;
mod places;
mod robustness;
mod show;
mod survey;

use super::*;

/// `unix` and the feature `std` hold; `windows`, `test` and other features do not; the rest is uncertain.
fn values() -> CfgValues {
    CfgValues {
        flags: ["unix".to_owned()].into(),
        values: [("feature".to_owned(), ["std".to_owned()].into())].into(),
        closed: ["unix", "windows", "test", "feature"].map(str::to_owned).into(),
    }
}

fn parse(text: &str) -> (Vec<Item>, Vec<Problem>) {
    parse_source("src/main.rs", text, &values(), &mut SourceMap::default())
}

/// The items of a text without problems.
#[track_caller]
fn parse_ok(text: &str) -> Vec<Item> {
    let (items, problems) = parse(text);
    assert_eq!(problems, [], "{text}");
    items
}

/// Compares the block of a function that holds `code`.
#[track_caller]
fn check_code(code: &str, expected: &str) {
    let items = parse_ok(&format!("fn f() {{ {code} }}"));
    let body = show::body_of_f(&items);
    assert_eq!(show::Show { body }.expr(body.root), format!("{{{expected}}}"));
}

#[track_caller]
fn check_items(code: &str, expected: &str) {
    assert_eq!(show::items(&parse_ok(code)), expected);
}
