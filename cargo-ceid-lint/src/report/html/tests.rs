//! What holds for every page: it is whole, it needs nothing else, and nothing in the code is read as markup.

use super::*;
use crate::report::progress::Previous;
use crate::report::{proof, sample};

/// The names of the tags in the order of the page, closing ones with `/`; panics where a quote or a tag is left open.
fn tags(page: &str) -> Vec<&str> {
    let body = page.split_once("</style>").map_or(page, |(_, body)| body);
    let tags = body.split('<').skip(1).map(|rest| rest.split_once('>').expect("a tag ends").0);
    tags.map(|tag| tag.split([' ', '\n']).next().unwrap_or_default()).collect()
}

#[track_caller]
fn assert_well_formed(page: &str) {
    let mut open: Vec<&str> = Vec::new();
    for tag in tags(page) {
        match tag.strip_prefix('/') {
            // The two that were opened before the style.
            Some("head" | "html") => {}
            Some(closed) => assert_eq!(open.pop(), Some(closed), "{open:?}"),
            None if matches!(tag, "br" | "meta") => {}
            None => open.push(tag),
        }
    }
    assert_eq!(open, [""; 0]);
}

#[test]
fn the_page_is_whole_and_needs_nothing() {
    let (project, report) = sample::report();
    let previous = Previous::read(&proof::json(&project, &report, None).replace("\"repeated\"", "\"once\"")).unwrap();
    let trend = previous.trend(&project, &report);
    let page = page(&project, &report, Some(&trend));
    assert_well_formed(&page);
    for outside in ["http:", "https:", "<script", "<link", "<img", "url(", "@import", "src="] {
        assert!(!page.contains(outside), "{outside}");
    }
    assert!(page.contains("name=\"viewport\"") && page.contains("prefers-color-scheme: dark"));
    assert_eq!(page.matches("<h1>").count(), 1);
    assert_eq!(page.matches("<table>").count(), page.matches("<caption>").count());
    assert_eq!(page.matches("<th ").count(), page.matches("<th scope=").count());
    let (_, body) = page.split_once("<body>").unwrap();
    insta::assert_snapshot!(body);
}

#[test]
fn an_empty_report_is_a_page() {
    let page = page(&Project::default(), &Report::default(), None);
    assert_well_formed(&page);
    assert!(page.contains("There is no control cycle"));
}

#[test]
fn nothing_in_the_code_is_read_as_markup() {
    let (project, mut report) = sample::report();
    let evil = "<script>alert('1')</script>&\u{1}\"".to_owned();
    for cycle in &mut report.cycles {
        cycle.function.clone_from(&evil);
        for pair in &mut cycle.filters {
            (pair.name, pair.filter_type, pair.cause) = (evil.clone(), evil.clone(), Some(evil.clone()));
        }
    }
    report.problems[0].message.clone_from(&evil);
    let page = page(&project, &report, None);
    assert_well_formed(&page);
    assert!(!page.contains("<script") && !page.contains('\u{1}'));
    assert!(page.contains("&lt;script&gt;alert(&#39;1&#39;)&lt;/script&gt;&amp;\u{fffd}&quot;"));
}

#[test]
fn many_cycles_are_closed_until_somebody_opens_them() {
    let (project, mut report) = sample::report();
    assert!(page(&project, &report, None).contains("<details open>"));
    let cycle = report.cycles[0].clone();
    report.cycles = vec![cycle; 10_000];
    let page = page(&project, &report, None);
    assert!(!page.contains("<details open>") && page.contains("10000 cycles: 10000 violated"));
    assert!(page.len() < 16 << 20, "{}", page.len());
}
