//! Items.

use super::check_items as check;

#[test]
fn functions() {
    check(
        "pub(crate) const unsafe extern \"C\" fn g<'a, T: A + ?Sized, const N: usize>(a: &'a mut T, (b, c): [u8; N]) -> ! where T: B { }",
        "pub fn g<T:A, const N> where T:B(&mut T, [u8;`N`])->! {}",
    );
    check("async fn g() -> impl Fn(A) -> B + 'static {}", "async fn g()->impl Fn<(A), Output=B> {}");
}

#[test]
fn receivers() {
    check(
        "impl A { fn a(self) {} fn b(&self) {} fn c(&mut self, x: u8) {} fn d(self: &mut Self) {} fn e(mut self: Box<Self>) {} }",
        "impl A {fn a(self )->() {}, fn b(&self )->() {}, fn c(&mut self u8)->() {}, fn d(&mut self )->() {}, \
         fn e(self:Box<Self> )->() {}}",
    );
}

#[test]
fn types_with_fields() {
    check(
        "struct A; struct B(pub u8, C<3>); struct D<T = u8> { e: T }",
        "struct A {}, struct B {0:u8, 1:C<3>}, struct D<T=u8> {e:T}",
    );
    check("enum A { B, C(u8), D { e: F } = 3 }", "enum A {B(), C(0:u8), D(e:F)}");
    check("union A { b: u8 }", "struct A {b:u8}");
}

#[test]
fn types() {
    check(
        "type A<T> = (dyn B<C = D> + Send, fn(u8) -> u8, *const T, [T], m!(), _);",
        "type A<T>=(dyn B<C=D>, Send, fn(u8)->u8, *T, [T], ??, _)",
    );
    check("type A = <T as B>::C; type D = E<F: G>;", "type A=<T as B>::C, type D=E<F:G>");
    check("type A = [u8; { N + 1 }];", "type A=[u8;`{N+1}`]");
}

#[test]
fn traits_and_impls() {
    check(
        "pub trait A<T>: B + 'static { type C: D = E; const F: u8 = 1; fn g(&self); m!(kf); }",
        "pub trait A<T>:B {type C:D=E, const F:u8=1, fn g(&self )->(), m!(kf)}",
    );
    check("unsafe impl<T> a::B<T> for C<T> { type D = u8; }", "impl<T> a::B<T> for C<T> {type D:=u8}");
    check("impl !Send for A {}", "");
}

#[test]
fn values() {
    check("const A: u8 = 1 + B; pub static mut C: D = E::new();", "const A:u8=(1+B), pub static C:D=E::new()");
}

#[test]
fn uses() {
    check(
        "pub use a::{self, b::c as d, e::*, f::{self as g}, _h as _}; use ::x::y; use r#type::z;",
        "pub use a as a, a::b::c as d, a::e as *, a::f as g, a::_h as _, use ::x::y as y, use type::z as z",
    );
    check("extern crate alloc as a; extern crate b;", "extern crate alloc as Some(\"a\"), extern crate b as None");
}

#[test]
fn foreign_items_are_signatures() {
    check("extern \"C\" { fn g(a: u8); static B: u8; type C; }", "fn g(u8)->(), static B:u8, struct C {}");
}

#[test]
fn macros_that_are_not_known_keep_their_names() {
    check("m! { kf \"{pf}\" }", "m!(kf pf)");
    check("#[macro_export] macro_rules! m { () => {} }", "@macro_export macro_rules m true");
    check("macro m() { kf }", "!(m kf)");
}

#[test]
fn attributes_are_kept_but_for_docs() {
    check(
        "/// A.\n#[test] #[rtic::task(binds = TIM2)] #[a = \"b\"] fn g() {}",
        "@test @rtic::task(binds = TIM2) @a= \"b\" fn g()->() {}",
    );
    check("mod a { #![allow(x)] }", "@allow(x) mod a {}");
}

#[test]
fn derived_derefs_are_the_impls_that_they_write() {
    check(
        "#[derive(Clone, Deref)] struct A<T: C>(B<T>);",
        "@derive(Clone, Deref) struct A<T:C> {0:B<T>}, \
         impl<T:C> ::core::ops::Deref for A<T> {type Target:=B<T>, fn deref(&self )->&Self::Target {&self.0}}",
    );
    check(
        "#[derive(Deref, DerefMut)] struct A { b: B, #[deref] c: C }",
        "@derive(Deref, DerefMut) struct A {b:B, c:C}, \
         impl ::core::ops::Deref for A {type Target:=C, fn deref(&self )->&Self::Target {&self.c}}, \
         impl ::core::ops::DerefMut for A {fn deref_mut(&mut self )->&mut Self::Target {&mut self.c}}",
    );
    for unknown in ["struct A(B, C);", "#[deref(forward)] struct A(B);", "struct A(#[deref(ignore)] B);"] {
        let item = format!("#[derive(Deref)] {unknown}");
        assert_eq!(super::parse_ok(&item).len(), 1, "{unknown}");
    }
}
