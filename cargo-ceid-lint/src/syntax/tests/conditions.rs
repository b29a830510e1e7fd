//! `cfg` on everything it can stand on.

use super::{check_code, check_items};

#[test]
fn items_that_are_not_there_vanish() {
    check_items("#[cfg(test)] mod tests; #[cfg(windows)] fn a() {} #[cfg(unix)] fn b() {}", "fn b()->() {}");
    check_items("#[cfg(all(unix, test))] fn a() {} #[cfg(unix)] #[cfg(test)] fn b() {}", "");
    check_items("impl A { #[cfg(test)] fn a() {} #[cfg(x)] fn b() {} }", "impl A {#x fn b()->() {}}");
}

#[test]
fn uncertain_items_carry_keys_that_exclude_each_other() {
    check_items("#[cfg(x)] fn a() {} #[cfg(not(x))] fn a() {}", "#x fn a()->() {}, #!x fn a()->() {}");
    check_items("#[cfg(y)] #[cfg(x)] use a::b;", "#all(x, y) use a::b as b");
}

#[test]
fn parts_that_are_not_there_vanish() {
    check_items("struct A { #[cfg(test)] b: u8, c: u8 }", "struct A {c:u8}");
    check_items("struct A(#[cfg(test)] u8, u16);", "struct A {0:u16}");
    check_items("enum A { #[cfg(test)] B, C }", "enum A {C()}");
    check_items("fn a(#[cfg(test)] b: u8, c: u16) {}", "fn a(u16)->() {}");
}

#[test]
fn statements() {
    check_code("#[cfg(test)] a(); #[cfg(unix)] b(); #[cfg(x)] c();", "b();#x c();");
    check_code("#[cfg(test)] let a = 1; #[cfg(x)] let b = 2;", "#x let b=2;");
    check_code("#[cfg(x)] { a } #[cfg(not(x))] { b }", "#x {a} #!x {b} ");
    check_code("#[cfg(unix)] { a } #[cfg(windows)] { b }", "{a}");
    check_code("#[cfg(test)] a.b = c; #[cfg(x)] a += b; #[cfg(test)] m!(d);", "#x a+=b;");
    check_code("#[cfg(test)] fn g() {} #[cfg(x)] println!(\"a\");", "#x println!all(\"a\");");
}

#[test]
fn arms_fields_and_arguments() {
    check_code("match a { #[cfg(test)] 1 => b, #[cfg(x)] 2 => c, _ => d }", "match a {#x 2=>c, _=>d}");
    check_code("A { #[cfg(test)] b: c, #[cfg(x)] d: e }", "A{d:{#x e }}");
    check_code("a(#[cfg(test)] b, c); [#[cfg(test)] b + 1, c]", "a(c);[c]");
    check_code("let A { #[cfg(test)] b, c } = d;", "let A{c:c}=d;");
}

#[test]
fn cfg_attr_is_unfolded() {
    check_items("#[cfg_attr(unix, test, a(b))] fn a() {}", "@test @a(b) fn a()->() {}");
    check_items("#[cfg_attr(windows, test)] fn a() {}", "fn a()->() {}");
    check_items("#[cfg_attr(unix, cfg(test))] fn a() {} #[cfg_attr(test, cfg(test))] fn b() {}", "fn b()->() {}");
    check_items("#[cfg_attr(x, cfg(test))] fn a() {}", "#!x fn a()->() {}");
}

#[test]
fn inner_attributes_of_a_file_decide_over_all_of_it() {
    check_items("#![cfg(test)] mod missing; fn a() {}", "");
}

#[test]
fn cfg_if_keeps_the_certain_branch() {
    check_items("cfg_if! { if #[cfg(unix)] { fn a() {} } else { fn b() {} } }", "fn a()->() {}");
    check_items(
        "cfg_if::cfg_if! { if #[cfg(test)] { fn a() {} } else if #[cfg(windows)] { fn b() {} } else { fn c() {} } }",
        "fn c()->() {}",
    );
    check_code("cfg_if! { if #[cfg(unix)] { let a = 1; b(a) } else { c() } }", "let a=1;b(a)");
    check_code("cfg_if! { if #[cfg(unix)] { a(); } } b()", "a();b()");
}

#[test]
fn cfg_if_keeps_uncertain_branches_apart() {
    check_items("cfg_if! { if #[cfg(x)] { fn a() {} } else { fn b() {} } }", "#x fn a()->() {}, #!x fn b()->() {}");
    check_code(
        "cfg_if! { if #[cfg(x)] { a } else if #[cfg(y)] { #[cfg(z)] b } else { c } }",
        "#x a #all(not(x), y, z) b #all(not(x), not(y)) c ",
    );
    check_code("let a = cfg_if! { if #[cfg(x)] { 1 } else { 2 } };", "let a={#x 1 #!x 2 };");
}

#[test]
fn the_cfg_macro_is_a_truth_value_if_it_is_certain() {
    check_code("if cfg!(unix) { a }", "if cfg!build(true) {a}");
    check_code("cfg!(any(test, windows))", "cfg!build(false)");
    check_code("cfg!(x)", "cfg!build(x)");
}
