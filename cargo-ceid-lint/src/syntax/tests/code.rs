//! Expressions, patterns, statements.

use super::check_code as check;

#[test]
fn places_and_calls() {
    check("self.kf.update(x)?;", "self.kf.update(x)?;");
    check("a[0].b.1(c).d::<E, 3>()", "a[0].b.1(c).d::<E, ??>()");
    check("<T as A<u8>>::b::<c>()", "<T as A<u8>>::b<c>()");
    check("<T>::b(); ::a::b", "<T>::b();::a::b");
    check("f(x).await.r#type", "f(x).await.type");
}

#[test]
fn operators() {
    check("a + b * -c", "(a+(b*-c))");
    check("(a + b) * !*c", "((a+b)*!*c)");
    check("a = b; a += 1; a <<= 2;", "a=b;a+=1;a<<=2;");
    check("(a, _) = b;", "(a, _)=b;");
    check("&mut a; &raw mut a; &raw const a; &a", "&mut a;&raw mut a;&raw a;&a");
    check("a as f32 as u8; a..b; ..=b; ..; a..", "((a as f32) as u8);a..b;..=b;..;a..");
}

#[test]
fn literals() {
    check(
        "(1, 0x10u8, 1f32, 1.5, true, 'a', b'b', \"c\\n\", b\"d\", c\"e\")",
        "(1, 16u8, 1f32, 1.5, true, 'a', 98u8, \"c\\n\", [100], c\"e\")",
    );
    check("99999999999999999999", "big");
}

#[test]
fn values_made_of_parts() {
    check("A { b, c: d, ..e }", "A{b:b, c:d..e}");
    check("A::<B> { 0: c }", "A<B>{0:c}");
    check("[a, b]; [a; 3]; (a,); ()", "[a, b];[a;3];(a);()");
}

#[test]
fn branches() {
    check(
        "if a { b } else if let Some(c) = d && e { f } else { g }",
        "if a {b} else if ((let Some(c)=d)&&e) {f} else {g}",
    );
    check("match a { 0 | -1 if b => c, 1..=9 => {} _ => return }", "match a {0|-1 if b=>c, 1..=9=>{}, _=>return}");
    check("let Some(a) = b else { return 1; };", "let Some(a)=b else {return 1;};");
}

#[test]
fn loops_and_jumps() {
    check("'a: loop { break 'a 3; }", "'a:loop {break 'a:3;}");
    check("while let Some(x) = it.next() { continue; }", "while (let Some(x)=it.next()) {continue ;}");
    check("'b: for (i, x) in xs { continue 'b }", "'b:for (i, x) in xs {continue 'b:}");
}

#[test]
fn blocks() {
    check("unsafe { a }; async move { b }; const { c }; 'd: { e }", "unsafe{a};async{b};{c};'d:{e}");
    check("; ;; a", "a");
    check("fn g() {} use a::b; c", "item g;item ;c");
}

#[test]
fn closures() {
    check("|a, mut b: &A| -> C { d }", "|a:_, mut b:&A|->C {d}");
    check("async move || a.await", "async move || a.await");
}

#[test]
fn patterns() {
    check("let ref mut a @ b = c;", "let ref mut a@b=c;");
    check("let A { b, c: d, ref e, .. } = f;", "let A{b:b, c:d, e:ref e}=f;");
    check("let (a, .., b): (A, B) = c;", "let (a, .., b):(A, B)=c;");
    check("let [a, rest @ ..] = &b;", "let [a, rest@..]=&b;");
    check("match a { &A::B => b, &mut c => d, box e => f, g!() => h }", "match a {&path A::B=>b, &c=>d, &e=>f, ??=>h}");
    check(
        "match a { 0xFFu8 => b, 'a'..='z' => c, A..=B::C => d, .. => e }",
        "match a {255=>b, 'a'..='z'=>c, A..=B::C=>d, ..=>e}",
    );
}

#[test]
fn what_is_not_read_keeps_its_names() {
    check("yield kf.update(x)", "unknown `yield`(kf update x)");
    check("become g(kf)", "unknown syntax that is not read(g kf)");
}
