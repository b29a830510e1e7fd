//! The crate's own macros, expanded.

use super::{check_items, parse_ok, show, values};
use crate::source::SourceMap;
use crate::syntax::{parse_source, tree};

/// Compares the block of a function that holds `code` behind a macro `m` with these rules.
#[track_caller]
fn check(rules: &str, code: &str, expected: &str) {
    let text = format!("macro_rules! m {{ {rules} }} fn f() {{ {code} }}");
    let items = parse_ok(&text);
    let body = show::body_of_f(&items);
    let shown = show::Show { body }.expr(body.root);
    // A rule's own variables are marked, and numbered by their call.
    let mut parts = shown.split('\u{2b9}');
    let first = parts.next().unwrap_or_default().to_owned();
    let unnumbered = parts
        .fold(first, |all, part| format!("{all}'{}", part.trim_start_matches(|digit: char| digit.is_ascii_digit())));
    assert_eq!(unnumbered, format!("{{{expected}}}"), "{text}");
}

#[test]
fn fragments_of_one_token() {
    check("($a:ident) => { $a.up() }", "m!(kf)", "kf.up()");
    check("($a:ident) => { $a.up() }", "m!(self)", "self.up()");
    check("($a:ident) => { a } ; ($a:tt) => { b }", "m!(_)", "b");
    check("($a:tt) => { x $a }", "m!((y))", "x(y)");
    check("($a:tt $b:tt) => { p $a q }", "m!(== c)", "(p==q)");
    check("($a:lifetime) => { $a: loop { break $a } }", "m!('x)", "'x:loop {break 'x:}");
    check("($a:block) => { loop $a }", "m!({ a() })", "loop {a()}");
}

#[test]
fn fragments_of_literals() {
    check("($a:literal) => { f($a) }", "m!(1)", "f(1)");
    check("($a:literal) => { f($a) }", "m!(-1.5)", "f(-1.5)");
    check("($a:literal) => { f($a) }", "m!(true)", "f(true)");
    check("($a:literal) => { a }; ($a:expr) => { b }", "m!(x)", "b");
}

#[test]
fn an_expression_stays_one() {
    check("($a:expr) => { $a * 2 }", "m!(x + y)", "((x+y)*2)");
    check("($a:expr) => { $a.up() }", "m!(&mut x)", "&mut x.up()");
    check("($($a:expr),*) => { f($($a),*) }", "m!(a + 1, g(b, c), |x| x)", "f((a+1), g(b, c), |x:_| x)");
    check("($a:expr => $b:expr) => { $b + $a }", "m!(x.y => z)", "(z+x.y)");
}

#[test]
fn types_and_paths() {
    check("($a:ty) => { $a::new() }", "m!(A)", "A::new()");
    check("($a:ty) => { $a::new() }", "m!(A<B>)", "<A<B>>::new()");
    check("($a:ty) => { let x: $a; }", "m!(&mut [A; 3]);", "{let x':&mut [A;3];};");
    check("($a:path) => { $a(1) }", "m!(b::c)", "b::c(1)");
}

#[test]
fn patterns() {
    check("($a:pat => $b:expr) => { match x { $a => $b, _ => d } }", "m!(A | B => c)", "match x {A|B=>c, _=>d}");
    check("($($a:pat_param)|+) => { f($(stringify!($a)),+) }", "m!(A | B)", "f(stringify!all(), stringify!all())");
}

#[test]
fn statements_attributes_and_items() {
    check("($a:stmt) => { $a; }", "m!(let x = y); x", "let x=y;x");
    check("($a:stmt) => { $a; b() }", "m!(a())", "{a();b()}");
    check_items(
        "macro_rules! m { ($(#[$a:meta])* $v:vis $n:ident) => { $(#[$a])* $v struct $n; } } \
         m!(#[x] #[y(a = 1)] pub A); m!(B);",
        "macro_rules m false, @x @y(a=1) pub struct A {}, struct B {}",
    );
    check_items(
        "macro_rules! m { ($($i:item)*) => { $($i)* } } m! { struct A; struct B; }",
        "macro_rules m false, struct A {}, struct B {}",
    );
}

#[test]
fn repetitions() {
    let each = "($($a:ident),+ $(,)?) => { [$($a),+] }";
    check(each, "m!(a)", "[a]");
    check(each, "m!(a, b,)", "[a, b]");
    check(each, "m!()", "m!opaque()");
    check("($($a:ident)*) => { [$($a,)*] }", "m!()", "[]");
    check("($a:ident $(= $b:expr)?) => { f($a $(, $b)?) }", "m!(a); m!(a = b);", "f(a);f(a, b);");
    check("($($a:ident)=>*) => { ($($a)-*) }", "m!(a => b => c)", "((a-b)-c)");
    check("($x:ident: $($a:ident)*) => { [$($x.$a),*] }", "m!(x: a b)", "[x.a, x.b]");
    check("($($a:ident)*; $($b:ident)*) => { [$($a.$b),*] }", "m!(a b; c)", "m!opaque(a b c)");
}

#[test]
fn repetitions_in_repetitions() {
    check(
        "($($a:ident: [$($b:expr),*]);*) => { f($(($a, [$($a.g($b)),*])),*) }",
        "m!(a: [1, 2]; b: [])",
        "f((a, [a.g(1), a.g(2)]), (b, []))",
    );
}

#[test]
fn tokens_and_operators() {
    let rules = "($a:ident = $b:ident) => { f($a) }; ($a:ident == $b:ident) => { g($a) }; (x $a:ident) => { h($a) }";
    check(rules, "m!(a = b); m!(a == b); m!(x a); m!(y a);", "f(a);g(a);h(a);m!opaque(y a);");
    check("([$a:expr]) => { f($a) }; (($a:expr)) => { g($a) }", "m!((1)); m!([1]); m!({1});", "g(1);f(1);m!opaque();");
    check("() => { $crate::a::b() }", "m!()", "crate::a::b()");
}

#[test]
fn token_munchers() {
    let rules = "(@go [$($done:expr),*]) => { f($($done),*) }; \
                 (@go [$($done:expr),*] $a:ident $($rest:tt)*) => { m!(@go [$($done,)* $a.up()] $($rest)*) }; \
                 ($($all:tt)*) => { m!(@go [] $($all)*) }";
    check(&rules.replace("[$($done,)* $a", "[$($done),* $a"), "m!(a)", "f(a.up())");
    check("() => {}; ($a:ident $($rest:tt)*) => { $a.up(); m!($($rest)*); }", "m!(a b);", "a.up();b.up();{};");
}

#[test]
fn what_goes_on_for_ever_stays_opaque() {
    check("() => { !m!() }", "m!()", &format!("{}m!opaque()", "!".repeat(32)));
    let text = "macro_rules! m { ($($a:tt)*) => { f(m!($($a)* $($a)*), m!($($a)*)) } } fn f() { m!(x) }";
    let items = parse_ok(text);
    assert!(show::body_of_f(&items).exprs.len() < 100_000);
}

#[test]
fn wrong_rules_and_code_stay_opaque() {
    check("($a:what) => { $a }", "m!(x)", "m!opaque(x)");
    check("($a:ident $a:ident) => { $a }", "m!(x y)", "m!opaque(x y)");
    check("($a:ident) => { $a $a }", "m!(x)", "m!opaque(x)");
}

#[test]
fn variables_of_a_macro_stay_in_it() {
    check("($a:expr) => { let x = $a; x.up() }", "m!(y); x", "{let x'=y;x'.up()};x");
    check("($a:expr) => { let x = 1; $a.up(x) }", "m!(x)", "{let x'=1;x.up(x')}");
    check("($a:expr) => { for x in r { $a.x(x) } }", "m!(x)", "for x' in r {x.x(x')}");
    check("($a:expr) => { let x = $a; S { x, y: x } }", "m!(x)", "{let x=x;S{x:x, y:x}}");
    check("($a:ident) => { let $a = new(); }", "m!(x); x", "let x=new();x");
    check("($a:ident) => { let x = 1; $a.up(x); }", "let y = m!(y);", "let y={let x'=1;y.up(x');};");
}

#[test]
fn macros_in_macros() {
    check("($a:ident) => { println!(\"{}\", $a.up()) }", "m!(kf)", "println!all(\"{}\", kf.up())");
    check(
        "($a:ident) => { macro_rules! n { ($b:ident) => { $b.$a() } } }",
        "m!(up); n!(kf); { n!(pf) }",
        "item n;kf.up();{pf.up()}",
    );
}

#[test]
fn scopes() {
    check(
        "() => { a }",
        "m!(); macro_rules! m { () => { b } } m!(); { macro_rules! m { () => { c } } m!(); } m!()",
        "item m;a;b;{item m;c;} b",
    );
    check_items(
        "mod a { macro_rules! m { () => { struct A; } } } m!(); #[macro_use] mod b { macro_rules! n { () => { struct B; } } } \
         n!(); crate::n!(); mod c { n!(); }",
        "mod a {macro_rules m false}, struct A {}, @macro_use mod b {macro_rules n false}, struct B {}, struct B {}, \
         mod c {struct B {}}",
    );
    // It is not certain which of the two is there.
    check_items(
        "#[cfg(a)] macro_rules! m { () => { struct A; } } #[cfg(not(a))] macro_rules! m { () => { struct B; } } m!();",
        "#a macro_rules m false, #!a macro_rules m false, m!()",
    );
}

#[test]
fn items_of_impls_and_traits() {
    check_items(
        "macro_rules! m { ($($n:ident),*) => { $(fn $n(&self) {})* } } impl A { m!(a, b); } trait T { m!(c); }",
        "macro_rules m false, impl A {fn a(&self )->() {}, fn b(&self )->() {}}, trait T: {fn c(&self )->() {}}",
    );
}

#[test]
fn computed_indices_of_a_macro_stay_opaque() {
    check("($i:expr) => { a[$i].up() }", "m!(i + 1)", "a[(i+1)].up()");
    check("($i:expr) => { a[$i + 1].up() }", "m!(i)", "m!opaque(i)");
    check("($i:expr, $j:expr) => { a[$i + $j].up() }", "m!(i, j)", "m!opaque(i j)");
    check("($i:expr) => { let k = $i + 1; a[k].up() }", "m!(i)", "{let k'=(i+1);a[k'].up()}");
}

/// Arguments keep their places, and what the macro adds stands where it is called.
#[test]
fn places() {
    let text = "macro_rules! m { ($a:expr) => { $a.up() } } fn f() { m!(self.kf) }";
    let mut map = SourceMap::default();
    let (items, _) = parse_source("src/main.rs", text, &values(), &mut map);
    let body: &tree::Body = show::body_of_f(&items);
    let shown: Vec<&str> = body.exprs.iter().map(|expr| map.snippet(expr.span)).collect();
    assert_eq!(shown, ["self", "self.kf", "m!(self.kf)", "{ m!(self.kf) }"]);
}

#[test]
fn duplicates_in_short_form() {
    check_items(
        "#[duplicate_item(own wide; [A] [u8]; [B] [u16];)] struct own { x: wide }",
        "struct A {x:u8}, struct B {x:u16}",
    );
    check_items("#[duplicate::duplicate_item(own; [A]; [B])] #[x] struct own;", "@x struct A {}, @x struct B {}");
    check_items("duplicate! { [own; [A]; [B]] struct own; }", "struct A {}, struct B {}");
}

#[test]
fn duplicates_in_long_form() {
    check_items(
        "#[duplicate_item([own [A] wide [u8]] [wide [u16] own [B]])] struct own { x: wide }",
        "struct A {x:u8}, struct B {x:u16}",
    );
}

#[test]
fn duplicates_with_parameters_and_for_all() {
    check_items(
        "duplicate! { [own by(T); [A] [&T]; [B] [&mut T]] struct own { x: by([u8]) } }",
        "struct A {x:&u8}, struct B {x:&mut u8}",
    );
    check_items(
        "#[duplicate_item(wide [u8]; own; [A]; [B])] struct own { x: wide }",
        "struct A {x:u8}, struct B {x:u8}",
    );
    check_items("#[substitute_item(wide [u8];)] struct A { x: wide }", "struct A {x:u8}");
}

#[test]
fn duplicates_that_are_not_understood_stay_as_they_are() {
    check_items("#[duplicate_item(own; [A] [B])] struct own;", "@duplicate_item(own; [A] [B]) struct own {}");
    check_items(
        "macro_rules! duplicate { ($($x:tt)*) => { struct C; } } duplicate! { [a; [b]] struct a; }",
        "macro_rules duplicate false, struct C {}",
    );
}

#[test]
fn duplicated_modules_have_names_of_their_own() {
    check_items(
        "#[duplicate_item(own; [FastLag]; [Lead])] mod kind { struct own; }",
        "mod kind_fast_lag {struct FastLag {}}, mod kind_lead {struct Lead {}}",
    );
}
