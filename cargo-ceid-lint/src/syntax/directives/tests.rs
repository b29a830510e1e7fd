//! What is read as a directive and what is not, text by text.

use std::path::Path;

use super::*;

/// What a text says, one line a directive, with the text that it stands at.
fn read(text: &str) -> Vec<String> {
    let mut sources = SourceMap::default();
    sources.add(Path::new("a.rs"), text.into());
    let from = |at: u32| text[at as usize..].split([' ', '\n', ';', '(']).next().unwrap_or("").to_owned();
    let shown = |directive: &Directive| {
        let said = match &directive.kind {
            DirectiveKind::Cycle(said) => format!("{said:?}"),
            DirectiveKind::Suppression(said) => {
                let names: Vec<&str> = said
                    .rules
                    .iter()
                    .map(|(name, span)| {
                        assert_eq!(sources.snippet(*span), name);
                        name.as_str()
                    })
                    .collect();
                let word = if said.is_expected { "expect" } else { "allow" };
                let reason = said.reason.as_ref().map(|reason| format!(" because {reason}")).unwrap_or_default();
                format!("{word} {}{reason}", names.join("+"))
            }
            DirectiveKind::NearMiss(said) => match &said.correction {
                Some((span, right)) => {
                    let mut fixed = sources.snippet(directive.span).to_owned();
                    let at = (span.start - directive.span.start) as usize..(span.end - directive.span.start) as usize;
                    fixed.replace_range(at, right);
                    format!("miss {fixed}{}", if said.is_certain { "" } else { " ?" })
                }
                None => "miss".to_owned(),
            },
        };
        let place = match directive.site {
            Site::Above(Some(next)) => format!("above {}", from(next)),
            Site::Above(None) => "above nothing".to_owned(),
            Site::Behind { first, .. } => format!("behind {}", from(first)),
            Site::Inside(open) => format!("inside {}", open.map_or(0, |open| open)),
        };
        format!("{said}, {place}")
    };
    Directives::read(&sources).iter().map(shown).collect()
}

#[track_caller]
fn check(text: &str, expected: &[&str]) {
    assert_eq!(read(text), expected, "{text}");
}

/// A comment above a loop says this.
#[track_caller]
fn says(comment: &str, expected: &str) {
    check(&format!("{comment}\nloop {{}}"), &[&format!("{expected}, above loop")]);
}

#[track_caller]
fn is_prose(comment: &str) {
    check(&format!("{comment}\nloop {{}}"), &[]);
}

#[test]
fn suppressions_name_rules_and_a_reason() {
    says("// ceid: allow(a_b)", "allow a_b");
    says("//ceid:allow( a_b , ceid::c_d , )", "allow a_b+ceid::c_d");
    says(
        r#"// ceid: expect(a_b, reason = "5 Hz, \"raw\" (GPS) // here")"#,
        r#"expect a_b because 5 Hz, "raw" (GPS) // here"#,
    );
    says("// ceid: allow", "allow ");
    says("// ceid: allow()", "allow ");
    says("// ceid: allow(reason = \"so\")", "allow  because so");
}

#[test]
fn cycles_are_declared() {
    says("// ceid: cycle", "Cycle");
    says("// ceid: not-a-cycle", "NotACycle");
    says("// ceid: every( 1_000 )", "Every(1000)");
}

#[test]
fn another_comment_may_follow() {
    says("// ceid: allow(a_b) // the GPS is slow", "allow a_b");
    says("// ceid: cycle //~ rule", "Cycle");
}

#[test]
fn prose_says_nothing() {
    for comment in [
        "// The paper calls this ceid: the destructor does the work.",
        "// ceid: the destructor does the work",
        "// ceid: allow the GPS to be slow",
        "// ceid: allow (or not) the skip",
        "// ceid: allow(a_b) is how one would write it",
        "// ceid: allow(a_b) hides what follows because it names the rule",
        "// ceid: allow(...) comments are read by the linter",
        "// ceid: expect(a_b) would warn here",
        "// ceid: cycle of the main loop",
        "// ceid: every 10 cycles the GPS has a fix",
        "// ceid: every(10) cycles the GPS has a fix",
        "// ceid: update() runs in the destructor",
        "// ceid:",
        "// ceid",
        "// ceid cycle",
        "// see `ceid: allow(a_b)`",
        "// ceid: note(a_b)",
        "// acid: allow(a_b)",
        "// // ceid: allow(a_b)",
        "//// ceid: allow(a_b)",
        "/* prose about ceid: allow(a_b) */",
        "/*\n * ceid: allow(a_b)\n */",
    ] {
        is_prose(comment);
    }
}

#[test]
fn documentation_and_strings_say_nothing() {
    for text in [
        "/// ceid: allow(a_b)\nfn f() {}",
        "//! ceid: allow(a_b)\nfn f() {}",
        "/** ceid: allow(a_b) */\nfn f() {}",
        "const A: &str = \"\n// ceid: allow(a_b)\n\";",
        "const A: &str = r#\"\"\n// ceid: allow(a_b)\n\"#;",
        "#[doc = \"// ceid: allow(a_b)\"]\nfn f() {}",
    ] {
        check(text, &[]);
    }
    check("fn f<'a>() { g('\"'); // ceid: allow(a_b)\n}", &["allow a_b, behind fn"]);
}

#[test]
fn near_misses_are_corrected() {
    says("// ceid: alow(a_b)", "miss // ceid: allow(a_b) ?");
    says("// ceid: Allow(a_b)", "miss // ceid: allow(a_b) ?");
    says("// ceid: ignore(a_b)", "miss // ceid: allow(a_b) ?");
    says("// ceid: allow a_b", "miss // ceid: allow(a_b) ?");
    says("// ceid: allow[a_b, c_d]", "miss // ceid: allow(a_b, c_d) ?");
    says("// ceid: allow(a_b) -- the \"GPS\"", r#"miss // ceid: allow(a_b, reason = "the \"GPS\"") ?"#);
    says("// ceid: allow(a_b) because of tests", "miss // ceid: allow(a_b, reason = \"because of tests\") ?");
    says("// ceid: expect(a_b) GPS is slow", "miss // ceid: expect(a_b, reason = \"GPS is slow\") ?");
    says("// ceid: allow(a_b) the pump is off", "miss // ceid: allow(a_b, reason = \"the pump is off\") ?");
    says("// ceid allow(a_b)", "miss // ceid: allow(a_b) ?");
    says("// CEID: allow(a_b)", "miss // ceid: allow(a_b) ?");
    says("// ceid:: allow(a_b)", "miss // ceid: allow(a_b) ?");
    says("// cied: cycle", "miss // ceid: cycle");
    says("// ceid: not a cycle.", "miss // ceid: not-a-cycle ?");
    says("// ceid: cylce", "miss // ceid: cycle");
    says("// ceid: every 10", "miss // ceid: every(10)");
    says("// ceid: evry(10)", "miss // ceid: every(10)");
}

#[test]
fn near_misses_that_cannot_be_corrected_are_told() {
    for comment in [
        "// ceid: allow(a_b",
        "// ceid: allow(a_b reason = \"x\")",
        "// ceid: allow(a_b, because = \"x\")",
        "// ceid: allow(a_b, \"x\")",
        "// ceid: allow(a_b, reason = GPS)",
        "// ceid: alow",
        "// ceid: alow(a_b",
        "// ceid: deny(a_b)",
        "// ceid: every(ten)",
        "/* ceid: allow(a_b) */",
    ] {
        says(comment, "miss");
    }
}

#[test]
fn comments_attributes_and_lines_may_stand_between() {
    check("// ceid: allow(a_b)\n// Why.\n\n#[inline] // here\n/// Doc.\npub fn f() {}", &["allow a_b, above pub"]);
    check("fn f() {\n    g();\n    // ceid: allow(a_b)\n}", &["allow a_b, above nothing"]);
    check("// ceid: allow(a_b)", &["allow a_b, above nothing"]);
}

#[test]
fn trailing_comments_stand_behind_their_line() {
    check("a;\nb(\"\n\"); c; // ceid: allow(a_b)\nd;", &["allow a_b, behind b"]);
    check("#[inline] // ceid: allow(a_b)\nfn f() {}", &["allow a_b, above fn"]);
}

#[test]
fn attributes_are_read_as_comments_are() {
    check("#[cfg_attr(any(), ceid::allow(a_b, reason = \"x\"))]\nloop {}", &["allow a_b because x, above loop"]);
    check(
        "#[cfg_attr( any ( ) ,\n    ceid::allow(a_b),\n    ceid::expect(c_d),\n)]\nfn f() {}",
        &["allow a_b, above fn", "expect c_d, above fn"],
    );
    check("fn f() {\n#![cfg_attr(any(), ceid::allow(a_b))]\n}", &["allow a_b, inside 7"]);
    check("#[cfg_attr(any(), ceid::alow(a_b))]\nfn f() {}", &["miss ceid::allow(a_b) ?, above fn"]);
    check(
        "#[cfg_attr(any(), expect(ceid::a_b, ceid::c_d, reason = \"x\"))]\nfn f() {}",
        &["miss ceid::expect(a_b, c_d, reason = \"x\") ?, above fn"],
    );
    check("#[cfg_attr(any(), allow(dead_code))]\nfn f() {}", &[]);
    check("#[cfg_attr(any(), allow(dead_code, ceid::a_b))]\nfn f() {}", &["miss, above fn"]);
    check("#[cfg_attr(all(), ceid::allow(a_b))]\nfn f() {}", &[]);
    check("#[cfg_attr(any(), clippy::allow(a_b))]\nfn f() {}", &[]);
}

#[test]
fn what_is_removed_leaves_no_trace() {
    let removed = |text: &str| {
        let mut sources = SourceMap::default();
        sources.add(Path::new("a.rs"), text.into());
        let directives = Directives::read(&sources);
        let span = directives.iter().next().unwrap().removal;
        format!("{}{}", &text[..span.start as usize], &text[span.end as usize..])
    };
    assert_eq!(removed("a;\n    // ceid: allow(a_b)\n    b;\n"), "a;\n    b;\n");
    assert_eq!(removed("a;\r\n    // ceid: allow(a_b)\r\n    b;\r\n"), "a;\r\n    b;\r\n");
    assert_eq!(removed("a; // ceid: allow(a_b)\n"), "a;\n");
    assert_eq!(removed("a; /* b */ // ceid: allow(a_b)\n"), "a; /* b */\n");
    assert_eq!(removed("a; // ceid: allow(a_b) \r\n"), "a;\r\n");
    assert_eq!(removed("// ceid: allow(a_b) // more\nb;"), "// more\nb;");
    assert_eq!(removed("a;\n  #[cfg_attr(any(), ceid::allow(a_b))]\n  b;"), "a;\n  b;");
    assert_eq!(removed("#[cfg_attr(any(), ceid::allow(a_b))] b;"), "b;");
    assert_eq!(removed("  #[cfg_attr(any(), ceid::allow(a_b))] // old\n  b;"), "  // old\n  b;");
    assert_eq!(removed("#[cfg_attr(any(), ceid::allow(a_b), x)]\nb;"), "#[cfg_attr(any(), x)]\nb;");
    assert_eq!(removed("#[cfg_attr(any(), x, ceid::allow(a_b))]\nb;"), "#[cfg_attr(any(), x)]\nb;");
}

#[test]
fn unfinished_text_ends() {
    for text in [
        "// ceid: allow(",
        "// ceid: allow(a_b, reason = \"",
        "// ceid: allow(a_b, reason = \"\\",
        "// ceid: every(",
        "/* ceid: cycle",
        "#[cfg_attr(any(), ceid::allow(",
        "#[cfg_attr(any(), ceid::)]",
        "#[cfg_attr(any(),)] // ceid",
        "#",
        "#!",
        "}} // ceid: cycle",
        "// ceid: é(é)",
        "// ceid: allow(é, \u{301})",
        "// ceid: allow(a_b)é",
        "//\u{feff}ceid: cycle",
        "/*/ ceid",
        "// ceid: every(é",
    ] {
        read(text);
    }
}
