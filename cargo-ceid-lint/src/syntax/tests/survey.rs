//! What is said of a crate of which no item is kept is what is said of it otherwise.

use super::*;
use crate::source::DiskSource;

type Survey = (BTreeSet<String>, BTreeSet<PathBuf>, BTreeSet<FileId>, Vec<Attribute>, Vec<Problem>);

type Look = fn(&Path, &str, &CfgValues, &Neighbours, &mut FileSet, &mut Vec<Problem>) -> RootModule;

fn looked_at(root: &Path, files: &mut FileSet, look: Look) -> Survey {
    let mut problems = Vec::new();
    let RootModule { attributes, removed, left_out, files, .. } =
        look(root, "2021", &values(), &Neighbours::default(), files, &mut problems);
    (removed, left_out, files, attributes, problems)
}

#[track_caller]
fn check(texts: &[(&str, &str)]) {
    let sets = || {
        let mut source = MemorySource::default();
        texts.iter().for_each(|(path, text)| source.insert(Path::new(path), Arc::from(*text)));
        FileSet::new(SourceMap::default(), Arc::new(source))
    };
    let root = Path::new(texts[0].0);
    let whole = looked_at(root, &mut sets(), parse_root);
    assert_eq!(looked_at(root, &mut sets(), survey_root), whole, "{texts:?}");
    // Otherwise the case shows nothing.
    assert!(!whole.0.is_empty() || !whole.1.is_empty() || whole.2.len() > 1 || !whole.4.is_empty(), "{texts:?}");
}

#[track_caller]
fn check_one(text: &str) {
    check(&[("src/lib.rs", text), ("src/x.rs", "fn x() { oh no }"), ("src/y.rs", "#[cfg(windows)] fn y() {}")]);
}

#[test]
fn files_are_followed_wherever_they_are_named() {
    for text in [
        "mod x;",
        "mod a { #[path = \"../x.rs\"] mod b; }",
        "fn f() { #[path = \"x.rs\"] mod b; }",
        "fn f() { mod gone; }",
        "impl A { fn f() { if a { let b = || { #[path = \"x.rs\"] mod b; }; } } }",
        "trait A { fn f() { match a { _ => { include!(\"x.rs\"); } } } }",
        "include!(\"x.rs\");",
        "fn f() { include!(\"gone.rs\") }",
        "const A: u8 = include!(\"x.rs\");",
        "static A: u8 = std::include!(concat!(env!(\"OUT_DIR\"), \"/x.rs\"));",
        "fn f() { println!(\"{}\", r#include!(\"x.rs\")); }",
        "fn f() { vec![{ #[path = \"x.rs\"] mod b; 1 }]; }",
        "thread_local! { static A: u8 = { #[path = \"x.rs\"] mod b; 1 }; }",
        "fn f(a: A) { match a { A if { #[path = \"x.rs\"] mod b; true } => {} } }",
        "unknown! { mod x; }",
        "cfg_if! { if #[cfg(windows)] { mod x; } else { mod y; } }",
    ] {
        check_one(text);
    }
}

#[test]
fn macros_of_the_crate_are_followed() {
    for text in [
        "macro_rules! m { ($($i:item)*) => { $($i)* } } m! { mod x; }",
        "macro_rules! m { () => { mod x; } } m! {}",
        "macro_rules! m { () => { mod x; } } macro_rules! n { () => { m! {} } } n! {}",
        "macro_rules! m { () => { mod x; } } macro_rules! n { ($m:ident) => { $m! {} } } n! { m }",
        "macro_rules! m { () => { o! {} } } macro_rules! n { () => { m! {} } } macro_rules! o { () => { mod x; } } n! {}",
        "macro_rules! m { ($n:ident) => { $n! { mod x; } } } macro_rules! n { ($i:item) => { $i } } fn f() { m!(n) } m! { n }",
        "macro_rules! m { ($p:literal) => { include!($p) } } fn f() { m!(\"x.rs\") }",
        "fn f() { macro_rules! m { () => { #[path = \"x.rs\"] mod x; } } g(m!()); }",
        "macro_rules! m { () => { #[cfg(windows)] fn gone() {} } } impl A { m! {} }",
        "#[macro_use] mod y { macro_rules! m { () => { mod x; } } } m! {}",
        "#[macro_use] mod y { macro_rules! m { () => { fn g() { include!(\"x.rs\") } } } } m! {} trait A { m! {} }",
        "macro_rules! info { () => { include!(\"x.rs\") } } fn f() { info!() }",
    ] {
        check_one(text);
    }
}

#[test]
fn what_cfg_removes_is_noted() {
    for text in [
        "#[cfg(windows)] fn a() {}",
        "fn f() { #[cfg(windows)] fn a() {} }",
        "impl A { #[cfg(test)] fn a() {} fn b() { { #[cfg(test)] struct C; } } }",
        "trait A { #[cfg_attr(unix, cfg(windows))] fn a(); }",
        "extern \"C\" { fn f(); } #[r#cfg(windows)] use a::b;",
        "impl !A for B { fn a() {} }",
        "cfg_if! { if #[cfg(windows)] { fn a() {} } }",
        "cfg_if! { if #[cfg(unix)] { fn a() { fn b() {} } } else { fn c() {} } }",
        "fn f() { cfg_if! { if #[cfg(other)] { fn a() {} } else { fn c() {} } } #[cfg(windows)] fn d() {} }",
        "macro_rules! m { ($($t:tt)*) => { $($t)* } } m! { #[cfg(windows)] fn a() {} }",
        "fn f() { assert!({ #[cfg(windows)] fn a() {} true }); }",
    ] {
        check_one(text);
    }
}

#[test]
fn all_code_around_is_told_the_same_of() {
    let mut open = vec![Path::new(env!("CARGO_MANIFEST_DIR")).join("../fixtures")];
    let own = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut roots = vec![own.join("src/lib.rs"), own.join("../tests/integration/main.rs")];
    while let Some(directory) = open.pop() {
        for entry in std::fs::read_dir(&directory).into_iter().flatten().flatten() {
            let path = entry.path();
            if path.is_dir() {
                open.push(path);
            } else if path.extension().is_some_and(|end| end == "rs") {
                roots.push(path);
            }
        }
    }
    assert!(roots.len() > 100);
    for root in roots {
        let set = || FileSet::new(SourceMap::default(), Arc::new(DiskSource));
        let whole = looked_at(&root, &mut set(), parse_root);
        assert_eq!(looked_at(&root, &mut set(), survey_root), whole, "{}", root.display());
    }
}
