//! Macros read as code.

use super::{check_code as check, check_items, parse_ok, show};

#[test]
fn formatting_runs_its_operands() {
    check(
        "println!(\"{a} {}\", kf.update(x)); write!(w, \"{}\", n = b)?;",
        "println!all(\"{a} {}\", kf.update(x), a);write!all(w, \"{}\", b)?;",
    );
    check("std::format!(\"\"); dbg!(a, b);", "std::format!all(\"\");dbg!all(a, b);");
    check("concat!(a, b); line!();", "concat!all();line!all();");
}

#[test]
fn assertions() {
    check(
        "assert!(a, \"{}\", b); assert_eq!(a, b, \"c\"); debug_assert!(a); debug_assert_ne!(a, b);",
        "assert!assert(a; \"{}\", b);assert_eq!compare(a, b; \"c\");debug_assert!debug(a);debug_assert_ne!debug(a, b);",
    );
    check(
        "panic!(\"{}\", a); todo!(); unreachable!()",
        "panic!diverges(\"{}\", a);todo!diverges();unreachable!diverges()",
    );
    check(
        "defmt::assert!(a); defmt::unwrap!(a, \"b\"); unwrap!(c)",
        "defmt::assert!assert(a);defmt::unwrap!all(\"b\", a);unwrap!all(c)",
    );
    check(
        "bail!(\"a\"); ensure!(a == b, \"c\"); anyhow::bail!(d)",
        "bail!err(\"a\");ensure!ensure((a==b); \"c\");anyhow::bail!err(d)",
    );
}

#[test]
fn names_in_format_strings() {
    check(
        "println!(\"{a} {b:?} {:c$} {e}\", d, e = f); format!(r#\"{a}\"#);",
        "println!all(\"{a} {b:?} {:c$} {e}\", d, f, a, b, c);format!all(\"{a}\", a);",
    );
    check(
        "write!(a, \"{{b}} {c}\"); panic!(\"{a:>b$}\")",
        "write!all(a, \"{{b}} {c}\", c);panic!diverges(\"{a:>b$}\", a, b)",
    );
    check(
        "assert!(a, \"{b}\"); debug_assert_eq!(a, b, \"{c}\");",
        "assert!assert(a; \"{b}\", b);debug_assert_eq!debug(a, b; \"{c}\", c);",
    );
    check("info!(target: \"t\", \"{a}\"); dbg!(\"{a}\");", "info!log(\"t\", \"{a}\", a);dbg!all(\"{a}\");");
}

#[test]
fn logging_in_all_its_spellings() {
    check(
        "info!(\"{}\", a); log::warn!(target: \"t\", \"{}\", b);",
        "info!log(\"{}\", a);log::warn!log(\"t\", \"{}\", b);",
    );
    check(
        "tracing::debug!(a, ?b, %c.d, e = f, g.h = ?i, \"j\" = k, \"text {}\", l);",
        "tracing::debug!log(a, b, c.d, f, i, k, \"text {}\", l);",
    );
    check("info!(a = 1, b:? = c, d:err = e; \"text\");", "info!log(1, c, e, \"text\");");
    check(
        "event!(Level::INFO, a == b); span!(parent: &p, Level::INFO, \"s\", x);",
        "event!log(Level::INFO, (a==b));span!log(&p, Level::INFO, \"s\", x);",
    );
    check("info!({ a = b }, \"text\"); error!(name: \"n\", c);", "info!log(b, \"text\");error!log(\"n\", c);");
    check("info!({ NAME } = a, { b = c, { NAME } = ?d }, \"text\");", "info!log(a, c, d, \"text\");");
    check("info!(a::b, c);", "info!log(a::b, c);");
}

#[test]
fn select_arms() {
    check(
        "tokio::select! { biased; x = a.next(), if b => c(x), Some(y) = d => { e } _ = g => h, else => i }",
        "tokio::select!select(x=a.next() if b=>c(x), Some(y)=d=>{e}, _=g=>h, =>i)",
    );
    check("select! { () = a => b, complete => break, default => {} }", "select!select(()=a=>b, =>break , =>{})");
    check(
        "select! { recv(r) -> m => kf, send(s, v) -> _ => { e } default(t) => d }",
        "select!select(m=r.recv()=>kf, _=s.send(v)=>{e}, t=>d)",
    );
    check("select! { take(r) -> m => kf }", "select!opaque(take r m kf)");
    check("join!(a, b); tokio::try_join!(biased; c, d)?;", "join!join(a, b);tokio::try_join!try_join(c, d)?;");
}

#[test]
fn values_and_patterns() {
    check("vec![]; vec![a, b]; vec![a; 3];", "vec[];vec[a, b];vec[a;3];");
    check("if matches!(a, Some(b) | None if b > 1) { c }", "if ((let Some(b)|None=a)&&(b>1)) {c}");
    check("matches!(a, B)", "(let B=a)");
    check("nb::block!(a.read())?; r#try!(b); pin!(c);", "nb::block!all(a.read())?;b?;pin!all(c);");
    check("core::ptr::addr_of_mut!(A.b); addr_of!(c);", "&raw mut A.b;&raw c;");
    check("assert_matches!(a, Some(_) if b, \"c\");", "assert_matches!assert(((let Some(_)=a)&&b); \"c\");");
    check("core::arch::asm!(\"nop\", in(reg) kf)", "unknown inline assembly(reg kf)");
}

#[test]
fn vectors_and_matrices_of_other_crates() {
    check("nalgebra::vector![a, b]; nalgebra::matrix![a, b; c, d,]", "vec[a, b];vec[a, c, b, d]");
    check("nalgebra::stack![a, 0; 0, b]; nalgebra::point![]", "vec[a, 0, 0, b];vec[]");
    check(
        "ndarray::array![[a, b], [c, d]]; smallvec![a, b]; smallvec::smallvec![a; 3]",
        "vec[a, b, c, d];vec[a, b];vec[a;3]",
    );
    // Others have macros of these names as well.
    check("array![a, b]; nalgebra::vector![a b]", "array!opaque(a b);nalgebra::vector!opaque(a b)");
    let imports = "extern crate nalgebra as na; use ndarray as nd; use nalgebra::{base::Vector2, vector};";
    let items = parse_ok(&format!("{imports} fn f() {{ vector![a]; na::point![b]; nd::array![c]; array![d] }}"));
    let body = show::body_of_f(&items);
    assert_eq!(show::Show { body }.expr(body.root), "{vec[a];vec[b];vec[c];array!opaque(d)}");
}

#[test]
fn statics_declared_by_macros() {
    check_items(
        "thread_local! { static A: RefCell<u8> = const { b() }; pub static C: D = e }",
        "static A:std::thread::LocalKey<RefCell<u8>>={b()}, pub static C:std::thread::LocalKey<D>=e",
    );
    check_items("lazy_static! { /// Doc.\n pub static ref A: Mutex<Kf> = b(); }", "pub static A:Mutex<Kf>=b()");
    check("thread_local!(static A: u8 = 1); b", "item A;b");
}

#[test]
fn guards() {
    check("ceid!(cycle => kf, p = self.pf, &mut x.y,);", "ceid!ceid(cycle: kf=kf, p=self.pf, &mut x.y=&mut x.y);");
    check("ceid_core::ceid!(c.cycle() => kf);", "ceid_core::ceid!ceid(c.cycle(): kf=kf);");
    check("each_cycle!(f in control => { f.a(); })", "each_cycle!each(f in control: {f.a();})");
    check(
        "each_cycle! { f, cycle in &mut control => { break; } }",
        "each_cycle!each(f, cycle in &mut control: {break ;})",
    );
    check("each_cycle!(f)", "each_cycle!opaque(f)");
}

#[test]
fn filter_sets_are_structs() {
    check_items(
        "filters! { /// Set.\n #[derive(Debug)] pub struct Set @ 1000 Hz { pub kf: KalmanF; #[doc = \"\"] pf: ParticleF<3>, map: Map, every 10 } \
         struct Other<T: A> @ RATE Hz { every: T, x: X, every N; y: Y; } }",
        "@derive(Debug) @ceid_core::filters pub struct Set {kf:KalmanF, pf:ParticleF<3>, map:Map}, \
         @ceid_core::filters struct Other<T:A> {every:T, x:X, y:Y}",
    );
    check_items("filters! { a => b }", "filters!(a b)");
    check("ceid_core::filters! { struct S @ 10 Hz { a: A } } s()", "item S;s()");
}

#[test]
fn the_crates_own_macros_are_not_the_known_ones() {
    let items = parse_ok(
        "macro_rules! info { () => {} } fn f() { info!(kf); log::info!(kf); crate::info!(kf); my::warn!(kf) }",
    );
    let body = show::body_of_f(&items);
    assert_eq!(
        show::Show { body }.expr(body.root),
        "{info!opaque(kf);log::info!log(kf);crate::info!opaque(kf);my::warn!opaque(kf)}"
    );
}

#[test]
fn other_shapes_are_opaque() {
    check(
        "println!(a b); vec![a b]; matches!(a); assert!()",
        "println!opaque(a b);vec!opaque(a b);matches!opaque(a);assert!opaque()",
    );
    check("my! { kf } other!(pf);", "my!opaque(kf) other!opaque(pf);");
}
