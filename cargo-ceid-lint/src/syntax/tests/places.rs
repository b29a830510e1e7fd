//! Places: bytes of the file, whatever stands in it.

use super::*;

/// Each of `expected` is the text of an expression of `f`, in the order in which they are lowered.
#[track_caller]
fn check(text: &str, expected: &[&str]) {
    let mut map = SourceMap::default();
    let (items, problems) = parse_source("src/main.rs", text, &values(), &mut map);
    assert_eq!(problems, []);
    assert_eq!(show::places(show::body_of_f(&items), &map), expected);
}

#[test]
fn chains_and_parentheses() {
    check(
        "fn f() { (a + b).c(d)[0] = -(e); }",
        &[
            "a",
            "b",
            "a + b",
            "d",
            "(a + b).c(d)",
            "0",
            "(a + b).c(d)[0]",
            "e",
            "-(e)",
            "(a + b).c(d)[0] = -(e)",
            "{ (a + b).c(d)[0] = -(e); }",
        ],
    );
}

#[test]
fn characters_of_several_bytes() {
    check(
        "// é𝛼\nfn f() { 'é'; /* 漢 */ kf.update(\"ü\"); }",
        &["'é'", "kf", "\"ü\"", "kf.update(\"ü\")", "{ 'é'; /* 漢 */ kf.update(\"ü\"); }"],
    );
}

#[test]
fn carriage_returns() {
    check(
        "// a\r\n/// b\r\nfn f() {\r\n  \"c\r\n\";\r\n  kf.up()\r\n}\r\n",
        &["\"c\r\n\"", "kf", "kf.up()", "{\r\n  \"c\r\n\";\r\n  kf.up()\r\n}"],
    );
}

#[test]
fn byte_order_mark_and_shebang() {
    check("\u{feff}fn f() { a }", &["a", "{ a }"]);
    check("#!/usr/bin/env run\nfn f() { a }", &["a", "{ a }"]);
    check("\u{feff}#!/usr/bin/é\r\nfn f() { a }", &["a", "{ a }"]);
    check("#! /* c */ [allow(x)]\nfn f() { a }", &["a", "{ a }"]);
}

#[test]
fn operands_of_macros() {
    check(
        "fn f() { println!(\"{}\", kf.up(x)); }",
        &["\"{}\"", "kf", "x", "kf.up(x)", "println!(\"{}\", kf.up(x))", "{ println!(\"{}\", kf.up(x)); }"],
    );
    check(
        "fn f() { cfg_if! { if #[cfg(unix)] { kf.up(); } } }",
        &["kf", "kf.up()", "{ cfg_if! { if #[cfg(unix)] { kf.up(); } } }"],
    );
}

#[test]
fn keywords_names_and_bars() {
    let text = "pub async unsafe fn f(&self) -> A<B> { 'a: while x { } |a| b.step(c) }";
    let mut map = SourceMap::default();
    let (items, _) = parse_source("src/main.rs", text, &values(), &mut map);
    let tree::ItemKind::Function(function) = &items[0].kind else { panic!("a function") };
    assert_eq!(show::text(&map, items[0].span), text);
    assert_eq!(show::text(&map, items[0].name_span), "f");
    assert_eq!(show::text(&map, function.keyword), "fn");
    assert_eq!(show::text(&map, function.head), "async unsafe fn f(&self) -> A<B>");
    for expr in &show::body_of_f(&items).exprs {
        match &expr.kind {
            tree::ExprKind::While { keyword, .. } => {
                assert_eq!(show::text(&map, *keyword), "while");
                assert_eq!(show::text(&map, expr.span), "while x { }");
            }
            tree::ExprKind::MethodCall { method_span, .. } => assert_eq!(show::text(&map, *method_span), "step"),
            tree::ExprKind::Closure(closure) => assert_eq!(show::text(&map, closure.bar), "|"),
            _ => {}
        }
    }
}

#[test]
fn items_without_their_attributes() {
    let text = "#[a] pub struct A; /// d\n impl B for C {} static D: E = F; m! { g } mod h { } #[x] use i;";
    let mut map = SourceMap::default();
    let (items, _) = parse_source("src/main.rs", text, &values(), &mut map);
    let places: Vec<&str> = items.iter().map(|item| show::text(&map, item.span)).collect();
    assert_eq!(places, ["pub struct A;", "impl B for C {}", "static D: E = F;", "m! { g }", "mod h { }", "use i;"]);
    let attributes: Vec<&str> =
        items.iter().flat_map(|item| &item.attributes).map(|a| show::text(&map, a.span)).collect();
    assert_eq!(attributes, ["#[a]", "#[x]"]);
}

#[test]
fn tokens_of_opaque_macros_and_rules() {
    let text = "macro_rules! m { () => {} } n!(a b);";
    let mut map = SourceMap::default();
    let (items, _) = parse_source("src/main.rs", text, &values(), &mut map);
    let tree::ItemKind::MacroRules { rules, .. } = &items[0].kind else { panic!("rules") };
    assert_eq!(show::text(&map, *rules), " () => {} ");
    let tree::ItemKind::MacroCall(mac) = &items[1].kind else { panic!("a call") };
    assert_eq!((show::text(&map, mac.tokens), show::text(&map, mac.span)), ("a b", "n!(a b)"));
}
