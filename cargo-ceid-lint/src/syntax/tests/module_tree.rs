//! Modules in several files.

use std::path::Path;

use super::*;
use crate::source::{FileSet, MemorySource};

/// Parses the `src/lib.rs` among `texts`; gives the items and the messages.
fn load(texts: &[(&str, &str)]) -> (String, Vec<String>, FileSet) {
    let mut source = MemorySource::default();
    for (path, text) in texts {
        source.insert(Path::new(path), Arc::from(*text));
    }
    let mut files = FileSet::new(SourceMap::default(), Arc::new(source));
    let mut problems = Vec::new();
    let root = texts.iter().map(|(path, _)| *path).find(|path| path.ends_with("src/lib.rs")).unwrap_or("src/lib.rs");
    let items = parse_crate(Path::new(root), "2021", &values(), &mut files, &mut problems);
    let messages = problems.iter().map(|p| {
        let line = p.span.map(|span| format!(":{}", files.map().line(span))).unwrap_or_default();
        format!("{}{line}: {}; {}", p.file, p.message, p.help.as_deref().unwrap_or(""))
    });
    (show::items(&items), messages.collect(), files)
}

#[track_caller]
fn check(texts: &[(&str, &str)], expected: &str) {
    let (items, messages, _) = load(texts);
    assert_eq!(messages, [] as [String; 0]);
    assert_eq!(items, expected);
}

#[track_caller]
fn check_problem(texts: &[(&str, &str)], expected: &[&str]) {
    assert_eq!(load(texts).1, expected);
}

#[test]
fn modules_lie_beside_the_root_and_below_others() {
    check(
        &[
            ("src/lib.rs", "mod a; mod b;"),
            ("src/a.rs", "mod c;"),
            ("src/a/c.rs", "mod d;"),
            ("src/a/c/d.rs", "struct D;"),
            ("src/b/mod.rs", "mod e;"),
            ("src/b/e.rs", "struct E;"),
        ],
        "mod a {mod c {mod d {struct D {}}}}, mod b {mod e {struct E {}}}",
    );
}

#[test]
fn inline_modules_are_directories() {
    check(
        &[
            ("src/lib.rs", "mod a { mod b; } mod c;"),
            ("src/a/b.rs", "struct B;"),
            ("src/c.rs", "mod d { mod r#try; }"),
            ("src/c/d/try.rs", "struct T;"),
        ],
        "mod a {mod b {struct B {}}}, mod c {mod d {mod try {struct T {}}}}",
    );
}

#[test]
fn path_attributes_are_relative_as_rustc_has_them() {
    check(
        &[
            (
                "src/lib.rs",
                "#[path = \"x/y.rs\"] mod a; mod b; #[path = \"dir\"] mod c { mod d; #[path = \"f.rs\"] mod e; }",
            ),
            ("src/x/y.rs", "mod z;"),
            ("src/x/z.rs", "struct Z;"),
            ("src/b.rs", "#[path = \"p.rs\"] mod p; mod q { #[path = \"r.rs\"] mod r; }"),
            ("src/p.rs", "struct P;"),
            ("src/b/q/r.rs", "struct R;"),
            ("src/dir/d.rs", "struct D;"),
            ("src/dir/f.rs", "struct F;"),
        ],
        "@path= \"x/y.rs\" mod a {mod z {struct Z {}}}, mod b {@path= \"p.rs\" mod p {struct P {}}, mod q \
         {@path= \"r.rs\" mod r {struct R {}}}}, @path= \"dir\" mod c {mod d {struct D {}}, @path= \"f.rs\" mod e {struct F {}}}",
    );
}

#[test]
fn path_attributes_under_cfg_attr() {
    check(
        &[
            ("src/lib.rs", "#[cfg_attr(windows, path = \"w.rs\")] #[cfg_attr(unix, path = \"u.rs\")] mod a;"),
            ("src/u.rs", "struct U;"),
        ],
        "@path= \"u.rs\" mod a {struct U {}}",
    );
    check(
        &[
            ("src/lib.rs", "#[cfg_attr(x, path = \"x.rs\")] #[cfg_attr(y, path = \"y.rs\")] mod a;"),
            ("src/y.rs", "struct Y;"),
        ],
        "mod a {struct Y {}}",
    );
}

#[test]
fn modules_whose_file_no_cfg_attr_chooses_are_left_unread() {
    check_problem(
        &[("src/lib.rs", "#[cfg_attr(windows, path = \"w.rs\")] mod a;")],
        &["src/lib.rs:1: no `cfg_attr` that holds chooses the file of module `a`; check it with a feature that does"],
    );
}

#[test]
fn missing_modules_name_both_files() {
    check_problem(
        &[("src/lib.rs", "\nmod a { mod b; }")],
        &[
            "src/lib.rs:2: file not found for module `b`; create `src/a/b.rs` or `src/a/b/mod.rs`, or remove the declaration",
        ],
    );
    check_problem(
        &[("src/lib.rs", "#[path = \"x.rs\"] mod a;")],
        &["src/lib.rs:1: file not found for module `a`: `src/x.rs`; create `src/x.rs`, or remove the declaration"],
    );
    check_problem(&[], &["src/lib.rs: no such file; the file is skipped; create it, or remove what names it"]);
    check_problem(
        &[("src/lib.rs", "fn f() { mod a; }")],
        &[
            "src/lib.rs:1: module `a` is declared in a block without a `#[path]`; move the declaration out of the block, or give it a `#[path = \"…\"]`",
        ],
    );
}

#[test]
fn two_files_of_one_module_are_told() {
    check_problem(
        &[("src/lib.rs", "mod a;"), ("src/a.rs", ""), ("src/a/mod.rs", "")],
        &["src/lib.rs:1: module `a` has two files: `src/a.rs` and `src/a/mod.rs`; remove one of the two files"],
    );
}

#[test]
fn circles_end() {
    check_problem(
        &[("src/lib.rs", "mod a;"), ("src/a.rs", "#[path = \"lib.rs\"] mod b;")],
        &["src/a.rs:1: circular modules: `src/lib.rs` -> `src/a.rs` -> `src/lib.rs`; the inner declaration is skipped"],
    );
    check_problem(
        &[("src/lib.rs", "include!(\"lib.rs\");")],
        &["src/lib.rs:1: circular modules: `src/lib.rs` -> `src/lib.rs`; the inner declaration is skipped"],
    );
}

#[test]
fn modules_that_double_end() {
    let mut texts = vec![("src/lib.rs".to_owned(), "#[path = \"0.rs\"] mod a;".to_owned())];
    for step in 0..40 {
        let next = step + 1;
        texts
            .push((format!("src/{step}.rs"), format!("#[path = \"{next}.rs\"] mod a; #[path = \"{next}.rs\"] mod b;")));
    }
    let texts: Vec<(&str, &str)> = texts.iter().map(|(path, text)| (path.as_str(), text.as_str())).collect();
    let messages = load(&texts).1;
    assert!(messages.iter().any(|message| message.contains("too many modules")), "{} messages", messages.len());
}

#[test]
fn broken_files_do_not_stop_the_rest() {
    let (items, messages, _) = load(&[
        ("src/lib.rs", "mod a; mod b; struct C;"),
        ("src/a.rs", "fn f() {\n  let x = ;\n}"),
        ("src/b.rs", "struct B;"),
    ]);
    assert_eq!(items, "mod a {}, mod b {struct B {}}, struct C {}");
    assert_eq!(messages, ["src/a.rs:2: expected an expression; the file is skipped; check it with `cargo check`"]);
}

#[test]
fn a_file_loaded_twice_is_read_once() {
    let (items, _, files) = load(&[("src/lib.rs", "mod a; #[path = \"a.rs\"] mod b;"), ("src/a.rs", "struct A;")]);
    assert_eq!(items, "mod a {struct A {}}, @path= \"a.rs\" mod b {struct A {}}");
    assert_eq!(files.map().files().count(), 2);
}

#[test]
fn included_items_stand_where_they_are_included() {
    let (items, messages, _) = load(&[
        ("src/lib.rs", "mod a { include!(\"x/items.rs\"); } include!(\"missing.rs\");\ninclude!(concat!(\"a\"));"),
        ("src/x/items.rs", "struct A; mod m;"),
        ("src/x/m.rs", ""),
    ]);
    assert_eq!(items, "mod a {struct A {}, mod m {}}, include!(), include!(concat)");
    assert_eq!(
        messages,
        [
            "src/lib.rs:1: file not found for `include!`: `src/missing.rs`; create `src/missing.rs`, or remove the `include!`",
            "src/lib.rs:2: `a` is not read: its code is included in a body, or its path is computed; use `mod` instead",
        ]
    );
}

#[test]
fn the_path_of_an_included_file_is_put_together() {
    let (items, messages, _) = load(&[
        ("/p/Cargo.toml", ""),
        (
            "/p/src/lib.rs",
            "include!(concat!(env!(\"CARGO_MANIFEST_DIR\"), \"/gen/a\", 1, \".rs\"));\ninclude!(concat!(\"b\", \".rs\"));",
        ),
        ("/p/gen/a1.rs", "struct A;"),
        (
            "/p/src/b.rs",
            "struct B; include!(concat!(env!(\"OUT_DIR\"), \"/c.rs\"));\ninclude!(concat!(NAME, \".rs\"));",
        ),
    ]);
    assert_eq!(items, "struct A {}, struct B {}, include!(concat env), include!(concat NAME)");
    assert_eq!(
        messages,
        [
            "/p/src/b.rs:1: `c.rs` is written by a build script, and none is run; a law or a cycle in it has to be checked where it is generated from",
            "/p/src/b.rs:2: `.rs` is not read: its code is included in a body, or its path is computed; use `mod` instead",
        ]
    );
}

#[test]
fn a_file_that_is_included_in_a_body_is_an_expression() {
    let (_, messages, _) = load(&[
        ("src/lib.rs", "fn f() { include!(\"body.rs\"); let t = include!(\"table.rs\"); }"),
        ("src/body.rs", "{ let x = 1; x + 1 }"),
        ("src/table.rs", "[1, 2]"),
    ]);
    let unread = |file: &str| {
        format!(
            "src/lib.rs:1: `{file}` is not read: its code is included in a body, or its path is computed; use `mod` instead"
        )
    };
    assert_eq!(messages, [unread("body.rs"), unread("table.rs")]);
}

#[test]
fn inner_cfg_of_a_file_is_its_modules() {
    check(
        &[
            ("src/lib.rs", "mod a; mod b;"),
            ("src/a.rs", "#![cfg(test)] mod missing;"),
            ("src/b.rs", "#![cfg(x)] #![allow(y)] struct B;"),
        ],
        "#x @allow(y) mod b {struct B {}}",
    );
}

#[test]
fn macros_of_earlier_files_hide_known_ones() {
    check(
        &[("src/lib.rs", "#[macro_use] mod a; fn f() { info!(kf) }"), ("src/a.rs", "macro_rules! info { () => {} }")],
        "@macro_use mod a {macro_rules info false}, fn f()->() {info!opaque(kf)}",
    );
}

#[test]
fn paths_of_the_2015_edition_begin_at_the_root() {
    let mut source = MemorySource::default();
    source.insert(Path::new("lib.rs"), Arc::from("use a::b; use self::c; use {d, e};"));
    let mut files = FileSet::new(SourceMap::default(), Arc::new(source));
    let items = parse_crate(Path::new("lib.rs"), "2015", &values(), &mut files, &mut Vec::new());
    assert_eq!(show::items(&items), "use ::a::b as b, use self::c as c, use ::d as d, ::e as e");
}

#[test]
fn closure_traits_are_types_up_to_the_2018_edition() {
    let text = "type Action = Fn(&u8) + Send; fn f(x: Box<Fn()>) {}";
    for (edition, problems) in [("2015", 0), ("2018", 0), ("2021", 1)] {
        let mut source = MemorySource::default();
        source.insert(Path::new("lib.rs"), Arc::from(text));
        let mut files = FileSet::new(SourceMap::default(), Arc::new(source));
        let mut found = Vec::new();
        parse_crate(Path::new("lib.rs"), edition, &values(), &mut files, &mut found);
        assert_eq!(found.len(), problems, "{edition}: {found:?}");
    }
}
