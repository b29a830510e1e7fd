//! Code as no person writes it: one shape repeated very often. Whatever the size, the run ends in an orderly way, and the verdict
//! is that of the same shape in small, or `unproved` where a limit is reached.

use std::fmt::Write as _;
use std::time::Instant;

use crate::support::program::{Run, report_file, run};
use crate::support::workspace::{temporary, temporary_package, write};

const HEAD: &str = "\
pub trait SampledFilter { fn update(&mut self, x: f64) -> f64; }
pub struct Kalman(f64);
impl SampledFilter for Kalman { fn update(&mut self, x: f64) -> f64 { self.0 += x; self.0 } }
pub trait Bus { fn read(&mut self) -> f64; fn is_busy(&mut self) -> bool; fn state(&mut self) -> u32; }
";

/// A shape, and how every filter in it is judged.
struct Shape {
    name: &'static str,
    verdict: &'static str,
    source: fn(usize) -> String,
}

/// A text for each number.
fn each(count: usize, text: impl Fn(usize) -> String) -> String {
    (0..count).map(text).collect()
}

/// A function with one filter and one loop.
fn cycle(body: &str) -> String {
    format!("pub fn run(bus: &mut dyn Bus) {{ let mut kf = Kalman(0.0); loop {{\n{body} }} }}\n")
}

fn nested(opening: &str, count: usize) -> String {
    cycle(&format!("{}kf.update(bus.read());{}", opening.repeat(count), "}".repeat(count)))
}

/// A function with so many filters and one loop.
fn filters(count: usize, body: &str) -> String {
    let made = each(count, |n| format!("let mut kf{n} = Kalman(0.0);\n"));
    format!("pub fn run(bus: &mut dyn Bus) {{\n{made}loop {{ let x = bus.read();\n{body} }} }}\n")
}

fn update_each(count: usize) -> String {
    each(count, |n| format!("kf{n}.update(x);\n"))
}

const SHAPES: &[Shape] = &[
    Shape { name: "blocks", verdict: "once", source: |n| nested("{", n.min(400)) },
    Shape { name: "conditions", verdict: "skipped", source: |n| nested("if bus.is_busy() {", n.min(400)) },
    Shape { name: "loops in loops", verdict: "once", source: |n| nested("while bus.is_busy() {", n.min(400)) },
    Shape {
        name: "counting loops in loops",
        verdict: "repeated",
        source: |n| nested("for k in 0..bus.state() {", n.min(400)),
    },
    Shape {
        name: "ways out",
        verdict: "skipped",
        source: |n| cycle(&(each(n, |n| format!("if bus.read() > {n}.0 {{ continue; }}\n")) + "kf.update(1.0);")),
    },
    Shape {
        name: "branches beside the update",
        verdict: "once",
        source: |n| {
            let branches = each(n, |n| format!("if bus.read() > {n}.0 {{ x += 1.0; }}\n"));
            cycle(&format!("let mut x = 0.0;\n{branches}kf.update(x);"))
        },
    },
    Shape {
        name: "updates in branches",
        verdict: "repeated",
        source: |n| cycle(&each(n.max(2), |n| format!("if bus.read() > {n}.0 {{ kf.update(1.0); }}\n"))),
    },
    Shape {
        name: "arms",
        verdict: "once",
        source: |n| {
            let arms = each(n, |n| format!("{n} => {{ kf.update({n}.0); }}\n"));
            cycle(&format!("match bus.state() {{\n{arms}_ => {{ kf.update(0.0); }} }}"))
        },
    },
    Shape {
        name: "variants",
        verdict: "once",
        source: |n| {
            let variants = each(n, |n| format!("V{n}, "));
            let arms = each(n, |n| format!("State::V{n} => {{ kf.update({n}.0); }}\n"));
            format!(
                "pub enum State {{ {variants} }}\npub trait Source {{ fn next(&mut self) -> State; }}\n\
                 pub fn run(source: &mut dyn Source) {{ let mut kf = Kalman(0.0); loop {{ match source.next() {{\n{arms} }} }} }}\n"
            )
        },
    },
    Shape {
        name: "else if",
        verdict: "once",
        source: |n| {
            let links = each(n, |n| format!("if x > {n}.0 {{ kf.update({n}.0); }} else "));
            cycle(&format!("let x = bus.read();\n{links}{{ kf.update(x); }}"))
        },
    },
    Shape {
        name: "loops one after the other",
        verdict: "once",
        source: |n| {
            let loops = each(n, |n| format!("while bus.is_busy() {{ kf.update({n}.0); }}\n"));
            format!("pub fn run(bus: &mut dyn Bus) {{ let mut kf = Kalman(0.0);\n{loops}}}\n")
        },
    },
    Shape {
        name: "functions",
        verdict: "once",
        source: |n| {
            each(n, |n| {
                format!("pub fn run{n}(bus: &mut dyn Bus, kf: &mut Kalman) {{ loop {{ kf.update(bus.read()); }} }}\n")
            })
        },
    },
    Shape {
        name: "functions with findings",
        verdict: "repeated",
        source: |n| {
            let function = |n: usize| {
                format!(
                    "pub fn run{n}(kf: &mut Kalman) {{ loop {{\n// ceid: allow(skipped_update)\nkf.update(1.0);\nkf.update(2.0); }} }}\n"
                )
            };
            each(n, function)
        },
    },
    Shape { name: "filters", verdict: "once", source: |n| filters(n, &update_each(n)) },
    Shape { name: "filters twice", verdict: "repeated", source: |n| filters(n, &update_each(n).repeat(2)) },
    Shape {
        name: "filters that are skipped",
        verdict: "skipped",
        source: |n| filters(n, &format!("if bus.is_busy() {{ continue; }}\n{}", update_each(n))),
    },
    Shape {
        name: "elements",
        verdict: "once",
        source: |n| {
            let updates = each(n, |n| format!("all[{n}].update(1.0);\n"));
            format!("pub fn run(all: &mut [Kalman; {n}]) {{ loop {{\n{updates}}} }}\n")
        },
    },
    Shape {
        name: "names",
        verdict: "once",
        source: |n| cycle(&format!("let one = &mut kf;\n{}one.update(1.0);", "let one = &mut *one;\n".repeat(n))),
    },
    Shape {
        name: "helpers",
        verdict: "once",
        source: |n| {
            let helpers = each(n, |n| format!("fn step{n}(kf: &mut Kalman) {{ step{}(kf); }}\n", n + 1));
            format!("{helpers}fn step{n}(kf: &mut Kalman) {{ kf.update(1.0); }}\n{}", cycle("step0(&mut kf);"))
        },
    },
    Shape {
        name: "a ring of helpers",
        verdict: "once",
        source: |n| {
            let helper = |at: usize| {
                let next = (at + 1) % n;
                format!(
                    "fn step{at}(kf: &mut Kalman, x: f64) {{ if x > {at}.0 {{ kf.update(x); }} else {{ step{next}(kf, x); }} }}\n"
                )
            };
            each(n, helper) + &cycle("step0(&mut kf, bus.read());")
        },
    },
    Shape {
        name: "visitors of each other",
        verdict: "unproved",
        source: |n| {
            let kinds = |at: usize| (0..6).map(move |part| (part, (at * 7 + part * 13 + 1) % n));
            let visitor = |at: usize| {
                let parts: String =
                    kinds(at).map(|(part, kind)| format!("pub part{part}: Vec<Node{kind}>, ")).collect();
                let visits =
                    kinds(at).map(|(part, kind)| format!("for it in &mut node.part{part} {{ visit{kind}(it); }}"));
                let visits: String = visits.collect();
                format!(
                    "pub struct Node{at} {{ {parts}pub kf: Kalman }}\n\
                     pub fn visit{at}(node: &mut Node{at}) {{ node.kf.update(1.0); {visits} }}\n"
                )
            };
            each(n, visitor) + "pub fn run(root: &mut Node0) { loop { visit0(root); } }\n"
        },
    },
    Shape {
        name: "comments",
        verdict: "skipped",
        source: |n| {
            let function = |n: usize| {
                format!(
                    "pub fn run{n}(bus: &mut dyn Bus, kf: &mut Kalman) {{\n// ceid: allow(skipped_update)\nloop {{ if bus.is_busy() {{ continue; }} kf.update(1.0); }} }}\n"
                )
            };
            each(n, function)
        },
    },
    Shape {
        name: "methods",
        verdict: "once",
        source: |n| cycle(&format!("kf.update(bus.read(){});", ".abs()".repeat(n))),
    },
    Shape {
        name: "sums",
        verdict: "once",
        source: |n| cycle(&format!("kf.update(bus.read(){});", " + 1.0".repeat(n))),
    },
    Shape {
        name: "macros",
        verdict: "repeated",
        source: |n| {
            let definition = "macro_rules! step { ($kf:expr) => { $kf.update(1.0) }; }\n";
            definition.to_owned() + &cycle(&"step!(kf);\n".repeat(n.max(2)))
        },
    },
];

/// The proof report of a shape in a size.
fn report(shape: &Shape, size: usize) -> Run {
    let directory = temporary(&format!("stress_{}_{size}", shape.name.replace(' ', "_")));
    write(&directory, "shape.rs", (HEAD.to_owned() + &(shape.source)(size)).as_bytes());
    report_file(&directory.join("shape.rs"))
}

#[test]
fn shapes_have_the_verdict_of_their_kind() {
    let mut wrong = String::new();
    for shape in SHAPES {
        for size in [3, 40] {
            let run = report(shape, size);
            run.assert_no_panic();
            let pairs = run.pairs().expect("the report is JSON");
            if pairs.is_empty() || pairs.iter().any(|pair| pair.verdict != shape.verdict) {
                let found: Vec<_> = pairs.iter().map(|pair| pair.verdict.as_str()).collect();
                writeln!(wrong, "{} of {size}: {found:?}, and not {}", shape.name, shape.verdict)
                    .expect("it is a text");
            }
        }
    }
    assert!(wrong.is_empty(), "{wrong}");
}

#[test]
fn what_is_not_followed_any_more_is_unproved() {
    let names = SHAPES.iter().find(|shape| shape.name == "names").expect("it is in the list");
    let pairs = report(names, 1_200).assert_no_panic().pairs().expect("the report is JSON");
    assert_eq!(pairs.iter().map(|pair| pair.verdict.as_str()).collect::<Vec<_>>(), ["unproved"]);
}

#[test]
fn code_beyond_the_parser_is_told() {
    let source = HEAD.to_owned() + &nested("{", 5_000);
    let directory = temporary_package("stress_parser", &[("src/lib.rs", source.as_bytes())]);
    run(&directory, [""; 0]).assert_no_panic().assert_code(101).assert_stderr("src/lib.rs");
}

/// `STRESS_SIZE=4000 cargo test --release -p cargo-ceid-lint --test integration -- --ignored --nocapture stress::`
#[test]
#[ignore = "runs every shape in the size that STRESS_SIZE says, and in half of it"]
fn shapes_of_any_size_end() {
    let size = std::env::var("STRESS_SIZE").ok().and_then(|size| size.parse().ok()).unwrap_or(2_000);
    for shape in SHAPES {
        let mut seconds = Vec::new();
        for size in [size / 2, size] {
            let start = Instant::now();
            let run = report(shape, size);
            seconds.push(start.elapsed().as_secs_f64());
            run.assert_no_panic();
            let pairs = run.pairs().expect("the report is JSON");
            let is_right = |verdict: &str| verdict == shape.verdict || verdict == "unproved";
            assert!(pairs.iter().all(|pair| is_right(&pair.verdict)), "{} of {size}: {pairs:?}", shape.name);
            assert!(!pairs.is_empty() || run.code == Some(101), "{} of {size} has no filter any more", shape.name);
        }
        println!("{:28} {size:6} {:8.2} s, {:4.1} times the half", shape.name, seconds[1], seconds[1] / seconds[0]);
    }
}
