//! Input that is meant to break parsers.

use super::*;

/// Parses, and gives the messages of the problems.
#[track_caller]
fn check(text: &str, expected: &[&str]) {
    let (_, problems) = parse(text);
    let messages: Vec<&str> = problems.iter().map(|problem| problem.message.as_str()).collect();
    assert_eq!(messages, expected);
}

/// Repeats `prefix` (and `suffix`) as often as the limits allow, and parses.
#[track_caller]
fn check_at_limit(before: &str, prefix: &str, middle: &str, suffix: &str, after: &str) {
    let build = |count: usize| format!("{before}{}{middle}{}{after}", prefix.repeat(count), suffix.repeat(count));
    let (mut low, mut high) = (0, 70_000);
    while low + 1 < high {
        let count = usize::midpoint(low, high);
        if check_depth(&build(count)).is_ok() { low = count } else { high = count }
    }
    assert!(low > 200, "{prefix} is refused at {low}");
    let start = std::time::Instant::now();
    let (_, problems) = parse(&build(low));
    if std::env::var_os("SHOW_LIMITS").is_some() {
        eprintln!("{low:6} of {prefix:24} {:5} ms {problems:?}", start.elapsed().as_millis());
    }
}

#[test]
fn the_longest_input_that_is_read_fits_the_stack() {
    let f = "fn f() { x = ";
    for (before, prefix, middle, suffix, after) in [
        (f, "!", "a", "", "; }"),
        (f, "- ", "a", "", "; }"),
        (f, "&", "a", "", "; }"),
        (f, "&mut ", "a", "", "; }"),
        (f, "&raw const ", "a", "", "; }"),
        (f, "*", "a", "", "; }"),
        (f, "|| ", "a", "", "; }"),
        (f, "|a, b| ", "a", "", "; }"),
        (f, "move || ", "a", "", "; }"),
        (f, "async move || ", "a", "", "; }"),
        (f, "return ", "a", "", "; }"),
        (f, "break ", "a", "", "; }"),
        (f, "yield ", "a", "", "; }"),
        (f, "become ", "a", "", "; }"),
        (f, "if ", "a", "{}", "; }"),
        (f, "match ", "a", "{}", "; }"),
        (f, "while ", "a", "{}", "; }"),
        (f, "for x in ", "a", "{}", "; }"),
        (f, "if let Some(x) = ", "a", "{}", "; }"),
        (f, "let x = ", "a", "", "; }"),
        (f, "a = ", "a", "", "; }"),
        (f, "a += ", "a", "", "; }"),
        (f, "a..", "a", "", "; }"),
        (f, "a + ", "a", "", "; }"),
        (f, "a || ", "a", "", "; }"),
        (f, "a < b && ", "a", "", "; }"),
        (f, "if a {} else ", "{}", "", "; }"),
        (f, "if let Some(x) = y {} else ", "{}", "", "; }"),
        (f, "", "a", ".b()", "; }"),
        (f, "", "a", ".b(c, d)?", "; }"),
        (f, "", "a", ".b", "; }"),
        (f, "", "a", "?", "; }"),
        (f, "", "a", ".await", "; }"),
        (f, "", "a", "[0]", "; }"),
        (f, "", "a", "()", "; }"),
        (f, "", "a", " as u8", "; }"),
        (f, "", "a", "!{}", "; }"),
        (f, "#[a] ", "a", "", "; }"),
        (f, "unsafe ", "{}", "", "; }"),
        (f, "'a: ", "{}", "", "; }"),
        ("fn f() { let ", "&", "a", "", " = b; }"),
        ("fn f() { let ", "x @ ", "a", "", " = b; }"),
        ("fn f() { let ", "box ", "a", "", " = b; }"),
        ("fn f() { match x { ", "a | ", "a", "", " => {} } }"),
        ("type A = ", "&", "A", "", ";"),
        ("type A = ", "*const ", "A", "", ";"),
        ("type A = ", "A<", "A", ">", ";"),
        ("type A = ", "A<u8, ", "A", ">", ";"),
        ("type A = ", "A<B = ", "A", ">", ";"),
        ("type A = ", "<A as ", "A", ">::B", ";"),
        ("type A = ", "fn() -> ", "A", "", ";"),
        ("type A = ", "impl Fn() -> ", "A", "", ";"),
        ("type A = ", "dyn Fn() -> ", "A", "", ";"),
        ("type A = ", "for<'a, 'b> fn() -> ", "A", "", ";"),
        ("type A = ", "A::", "A", "", ";"),
        ("use ", "a::", "b", "", ";"),
        ("fn f() { ", "a::<", "b", ">", "; }"),
        ("fn f() { ", "loop { ", "b", "}", "; }"),
        ("fn f() { ", "println!(", "b", ")", "; }"),
        ("fn f() { ", "vec![", "b", "]", "; }"),
        ("fn f() { ", "cfg_if! { if #[cfg(a)] { ", "b", "} }", "; }"),
        ("fn f() { ", "(", "b", ")", "; }"),
        ("", "mod a { ", "", "}", ""),
        ("fn f() { ", "fn f() { ", "", "}", "}"),
        ("#[cfg(", "not(", "a", ")", ")] fn f() {}"),
    ] {
        check_at_limit(before, prefix, middle, suffix, after);
    }
}

#[test]
fn deep_brackets_are_a_problem_with_a_place() {
    let text = format!("fn f() {{\n{}{}\n}}", "(".repeat(5000), ")".repeat(5000));
    let mut map = SourceMap::default();
    let (items, problems) = parse_source("src/main.rs", &text, &values(), &mut map);
    assert!(items.is_empty());
    let [problem] = problems.as_slice() else { panic!("one problem: {problems:?}") };
    assert_eq!(problem.message, "nested too deeply (5001 levels, limit 500)");
    assert_eq!(problem.span.map(|span| map.line(span)), Some(2));
}

#[test]
fn chains_of_ten_thousand_links_are_read() {
    check(&format!("fn f() {{ a{} }}", ".b(c)".repeat(10_000)), &[]);
    check(&format!("fn f() {{ a{} }}", " + b".repeat(10_000)), &[]);
}

#[test]
fn endless_prefixes_are_a_problem() {
    for prefix in ["!", "- ", "&", "*", "|| ", "if a {} else ", "a = "] {
        check(
            &format!("fn f() {{ x = {}a; }}", prefix.repeat(100_000)),
            &["expression too long (more than 60000 links in a row)"],
        );
    }
}

#[test]
fn text_that_is_not_code() {
    check("", &[]);
    check("\u{feff}", &[]);
    check("#!", &[]);
    check("#!/bin/sh", &[]);
    check("\0", &["unbalanced bracket or invalid token"]);
    check("fn f() {", &["unbalanced bracket or invalid token"]);
    check("fn f(", &["unbalanced bracket or invalid token"]);
    check("fn", &["unexpected end of input, expected identifier"]);
}

/// Every text that differs from a correct one in a byte is read or refused, without a panic.
#[test]
fn damaged_text_is_read_or_refused() {
    let text = "#[cfg(x)]\nfn f(&mut self, (a, b): A<3>) -> R {\n 'a: for x in 0..=9u8 { if let Some(k) = self.kf.up(x)? { break 'a; } }\n \
                println!(\"{a} {}\", k.up(1.5e3)); match é { b'\\'' | \"s\" => {}, r#\"r\"# => |x: &u8| -> u8 { *x }, _ if y => vec![1; 2] }\n \
                tokio::select! { v = a => b, else => c }; cfg_if! { if #[cfg(u)] { x() } else { y() } } ceid!(t => a, b = c); }\n\
                filters! { pub struct S @ 10 Hz { kf: K; m: M, every 3 } }\nmod m { use a::{self, b::*}; }\n";
    let chars: Vec<char> = text.chars().collect();
    for at in 0..chars.len() {
        for with in ["", "(", "}", "\"", "'", "#", "/*", "r#", "!", "0", "=", "é"] {
            let damaged: String =
                chars[..at].iter().copied().chain(with.chars()).chain(chars[at + 1..].iter().copied()).collect();
            let _ = parse(&damaged);
        }
    }
}

/// Files of the disk that are no text, endless, or their own ancestors.
#[test]
#[cfg(unix)]
fn odd_files_are_problems() -> std::io::Result<()> {
    use std::os::unix::fs::symlink;
    let root = std::env::temp_dir().join(format!("ceid-lint-odd-files-{}", std::process::id()));
    std::fs::create_dir_all(root.join("a"))?;
    let modules = "mod a; mod b; #[path = \"/dev/zero\"] mod c; mod d; #[path = \"a\"] mod e; mod f; mod g; struct S;";
    std::fs::write(root.join("lib.rs"), modules)?;
    std::fs::write(root.join("a/mod.rs"), "mod a;")?;
    std::fs::write(root.join("b.rs"), b"fn f() { \xff }")?;
    std::fs::write(root.join("g.rs"), "fn f() { \0 }")?;
    let links = [(".", "a/a"), ("d.rs", "d.rs"), ("nowhere.rs", "f.rs")];
    for (target, link) in links {
        let _ = std::fs::remove_file(root.join(link));
        symlink(target, root.join(link))?;
    }
    let mut files = FileSet::new(SourceMap::new(root.clone()), Arc::new(crate::source::DiskSource));
    let mut problems = Vec::new();
    let items = parse_crate(&root.join("lib.rs"), "2024", &values(), &mut files, &mut problems);
    std::fs::remove_dir_all(&root)?;
    let shown: Vec<String> = problems.iter().map(|problem| format!("{}: {}", problem.file, problem.message)).collect();
    assert_eq!(items.last().map(|item| item.name.as_str()), Some("S"));
    assert_eq!(
        shown,
        [
            "a/mod.rs: circular modules: `a/mod.rs` -> `a/mod.rs`",
            "b.rs: not valid UTF-8 (byte 9)",
            "/dev/zero: not a regular file",
            "d.rs: Too many levels of symbolic links (os error 40)",
            "a: it is a directory",
            "lib.rs: file not found for module `f`: `f.rs`",
            "g.rs: unbalanced bracket or invalid token",
        ]
    );
    Ok(())
}
