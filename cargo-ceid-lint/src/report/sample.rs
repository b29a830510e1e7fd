//! A report with one of everything, for the tests of the formats.

use std::path::Path;

use serde_json::json;

use crate::count::{Cycle, CycleKind, Gate, Pair, Verdict};
use crate::diagnostic::{Applicability, Diagnostic, Facts, Label, Level, Problem, Suggestion, Witness, WitnessStep};
use crate::pipeline::Report;
use crate::project::{CfgValues, Package, Project, Target, TargetKind};
use crate::source::{FileId, SourceMap, Span};

const MAIN: &str = "\
fn main() {
    let mut kf = KalmanF::new();
    loop {
        kf.update();
        let é = kf.x; if é > 1.0 { kf.update(); }
        pf.update();
    }
}
";

/// The place of the `nth` occurrence of `needle`.
fn place(sources: &SourceMap, file: FileId, needle: &str, nth: usize) -> Span {
    let (start, _) = sources.file(file).text.match_indices(needle).nth(nth).unwrap();
    Span::new(file, u32::try_from(start).unwrap(), u32::try_from(start + needle.len()).unwrap())
}

fn step(span: Span, message: &str) -> WitnessStep {
    WitnessStep { span, message: message.to_owned() }
}

/// A project of two packages, the second of which is clean, and what was found in it.
pub(super) fn report() -> (Project, Report) {
    let mut sources = SourceMap::new("/ws".into());
    let main = sources.add(Path::new("/ws/demo/src/main.rs"), MAIN.into());
    let odd = sources.add(Path::new("/ws/demo/src/odd.rs"), "fn f() {\n    let x = 1\n}\n".into());
    let (head, first, second) = (
        place(&sources, main, "loop", 0),
        place(&sources, main, "kf.update()", 0),
        place(&sources, main, "kf.update()", 1),
    );
    let steps = vec![
        step(head, "the cycle begins here"),
        step(first, "first update"),
        step(place(&sources, main, "é > 1.0", 0), "taken when `é > 1.0`"),
        step(second, "second update"),
    ];
    let repeated = Diagnostic {
        rule: "repeated_update",
        level: Level::Deny,
        level_source: "by default".to_owned(),
        message: "`kf` is updated twice in one cycle".to_owned(),
        primary: Label { span: second, message: "second update of `kf`".to_owned() },
        witness: Witness { steps },
        notes: vec!["each update advances the filter by one sample".to_owned()],
        helps: vec![
            "register `kf` with a guard, or say why with `// ceid: allow(repeated_update, reason = \"…\")`".to_owned(),
        ],
        suggestions: vec![Suggestion {
            message: "remove the second update".to_owned(),
            edits: vec![(place(&sources, main, "kf.update(); ", 0), "kf.hold(); ".to_owned())],
            applicability: Applicability::MaybeIncorrect,
        }],
        facts: Facts {
            verdict: "repeated".to_owned(),
            counts: vec![1, 2],
            filters: vec!["kf".to_owned()],
            filter_type: "KalmanF".to_owned(),
            cycle: Some(head),
            cause: None,
            function: "main".to_owned(),
        },
        suppressed: None,
        known: false,
        package: 0,
        target: 0,
    };
    let mut skipped = repeated.clone();
    skipped.rule = "skipped_update";
    skipped.level = Level::Warn;
    skipped.primary = Label { span: place(&sources, main, "pf.update()", 0), message: String::new() };
    skipped.message = "`pf` is not updated on some paths".to_owned();
    skipped.suggestions.clear();
    let mut known = skipped.clone();
    known.suppressed = Some("GPS comes at 5 Hz".to_owned());
    let problems = vec![
        Problem {
            file: "demo/src/odd.rs".to_owned(),
            span: Some(place(&sources, odd, "}", 0)),
            message: "expected `;`".to_owned(),
            help: None,
            is_error: true,
        },
        Problem {
            file: "demo/src/lost.rs".to_owned(),
            span: None,
            message: "cannot read the file".to_owned(),
            help: Some("make it, or take `mod lost;` out".to_owned()),
            is_error: true,
        },
    ];
    let report = Report {
        diagnostics: vec![repeated, skipped, known],
        cycles: cycles(head, &sources),
        problems,
        filter_types: 2,
        presumed: 0,
        sources,
        ..Report::default()
    };
    (project(), report)
}

fn cycles(head: Span, sources: &SourceMap) -> Vec<Cycle> {
    let pair = |name: &str, verdict: Verdict, counts: &[u8]| Pair {
        name: name.to_owned(),
        filter_type: "KalmanF".to_owned(),
        law: "update".to_owned(),
        half: 0,
        verdict,
        counts: counts.to_vec(),
        gate: None,
        rules: Vec::new(),
        left_out: Vec::new(),
        skips: false,
        cause: None,
        witness: Vec::new(),
        through: Vec::new(),
        primary: None,
        others: Vec::new(),
        updates: Vec::new(),
        suppressed: None,
        known: false,
    };
    let mut repeated = pair("kf", Verdict::Repeated, &[1, 2]);
    repeated.rules = vec!["repeated_update"];
    let mut gated = pair("self.axes.roll", Verdict::Gated, &[1]);
    gated.gate = Some(Gate::Rate);
    gated.rules = vec!["gated_update"];
    let mut unproved = pair("map", Verdict::Unproved, &[0, 1]);
    unproved.cause = Some("the call of `hook` cannot be followed".to_owned());
    let mut skipped = pair("pf", Verdict::Skipped, &[0, 1]);
    skipped.rules = vec!["skipped_update"];
    skipped.suppressed = Some("GPS comes at 5 Hz".to_owned());
    let function = Span::new(head.file, 0, 2);
    assert_eq!(sources.snippet(function), "fn");
    vec![
        Cycle {
            package: 0,
            target: 0,
            head,
            kind: CycleKind::Loop,
            is_presumed: false,
            function: "main".to_owned(),
            period: None,
            filters: vec![repeated, pair("yaw", Verdict::Once, &[1]), gated],
        },
        Cycle {
            package: 0,
            target: 0,
            head: function,
            kind: CycleKind::Function,
            is_presumed: false,
            function: "main".to_owned(),
            period: None,
            filters: vec![unproved, skipped],
        },
    ]
}

fn project() -> Project {
    let package = |name: &str, kind: TargetKind, file: &str| Package {
        name: name.to_owned(),
        id: format!("path+file:///ws/{name}#0.1.0"),
        version: "0.1.0".to_owned(),
        manifest_path: format!("/ws/{name}/Cargo.toml").into(),
        workspace_root: "/ws".into(),
        is_reported: true,
        is_unresolved: false,
        dependencies: Vec::new(),
        targets: vec![Target {
            name: name.to_owned(),
            crate_name: name.to_owned(),
            kind,
            src_path: format!("/ws/{name}/src/{file}").into(),
            edition: "2024".to_owned(),
            is_reported: true,
            cfg_test: false,
            cargo: json!({
                "kind": [kind.name()], "crate_types": [kind.name()], "name": name, "src_path": format!("/ws/{name}/src/{file}"),
                "edition": "2024", "doc": true, "doctest": false, "test": true,
            }),
        }],
        cfg: CfgValues::default(),
        roots_left_out: Vec::new(),
        is_member: true,
        is_default: true,
        is_partly_read: false,
        metadata: None,
    };
    Project {
        root: "/ws".into(),
        target_directory: "/ws/target".into(),
        packages: vec![package("demo", TargetKind::Bin, "main.rs"), package("clean", TargetKind::Lib, "lib.rs")],
        ..Project::default()
    }
}
