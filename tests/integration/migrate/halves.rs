//! Laws of several halves that take inputs: what is refused, which the cases of `fixtures/migrate/workspaces` cannot show.

use super::{binary, migrate, package};
use crate::support::workspace;

/// A filter whose law has two halves, and a loop over a log.
fn robot(body: &str) -> String {
    format!(
        "\
struct Ekf {{ along: f64 }}

impl Ekf {{
    fn predict(&mut self, speed: f64) {{ self.along += speed; }}
    fn correct(&mut self, along: f64) {{ self.along += 0.5 * (along - self.along); }}
}}

fn run(ekf: &mut Ekf, log: &[(f64, f64)]) {{
    for (speed, along) in log {{
{body}
    }}
}}

fn main() {{
    let mut ekf = Ekf {{ along: 0.0 }};
    run(&mut ekf, &[(1.0, 1.0)]);
    println!(\"{{}}\", ekf.along);
}}
"
    )
}

/// Migrates the loop, and looks for a part of what is said and of what is written.
#[track_caller]
fn check(name: &str, body: &str, said: &str, written: Option<&str>) {
    let text = robot(body);
    let directory = package(name, &[("robot".to_owned(), text.clone())]);
    let config = b"[[filter]]\ntype = \"robot::Ekf\"\nlaw = [[\"predict\"], [\"correct\"]]\n";
    workspace::write(&directory, "ceid-lint.toml", config);
    migrate(&directory, &["--all"]).assert_code(0).assert_stderr(said);
    let after = binary(&directory, "robot");
    match written {
        Some(written) => assert!(after.contains(written), "{after}"),
        None => assert_eq!(after, text),
    }
}

#[test]
fn halves_that_follow_each_other_are_fed_together() {
    let body = "        ekf.predict(*speed);\n        ekf.correct(*along);";
    check("migrate_halves_together", body, "migrated 1 of 1 loop", Some("ekf.feed((*speed, *along));"));
    let body = "        ekf.predict(*speed);\n        println!(\"{along}\");\n        ekf.correct(*along);";
    check("migrate_halves_apart", body, "migrated 1 of 1 loop", Some("let ekf_speed = *speed;"));
    let body = "        ekf.predict(-1.0);\n        println!(\"{along}\");\n        ekf.correct(*along);";
    check("migrate_halves_constant", body, "migrated 1 of 1 loop", Some("ekf.feed((-1.0, *along));"));
}

#[test]
fn a_half_that_reads_what_the_other_one_left_is_refused() {
    let body = "        ekf.predict(*speed);\n        ekf.correct(*along - ekf.along);";
    check("migrate_halves_read", body, "line 11: `ekf` is used here after its update", None);
}

#[test]
fn a_loop_that_is_left_between_the_halves_is_refused() {
    let body = "        ekf.predict(*speed);\n        if speed > along {\n            break;\n        }\n        ekf.correct(*along);";
    check("migrate_halves_left", body, "line 12: the loop may be left here between the calls", None);
}

#[test]
fn halves_in_two_branches_are_refused() {
    let body = "        if speed > along {\n            ekf.predict(*speed);\n        } else {\n            ekf.predict(0.0);\n        }\n        \
                ekf.correct(*along);";
    check("migrate_halves_branches", body, "a half of the law of `ekf` is called in several places", None);
    let body = "        {\n            ekf.predict(*speed);\n            println!(\"{along}\");\n        }\n        ekf.correct(*along);";
    check("migrate_halves_nested", body, "take inputs, and not one behind the other", None);
}

#[test]
fn a_half_that_a_loop_leaves_out_is_refused() {
    let text = "\
struct Ekf { along: f64, wide: f64 }

impl Ekf {
    fn turn(&mut self) { self.along += 1.0; }
    fn settle(&mut self) { self.wide *= 0.5; }
}

fn turned(ekf: &mut Ekf) {
    for _ in 0..3 {
        println!(\"{}\", ekf.wide);
        ekf.turn();
    }
}

fn main() {
    let mut ekf = Ekf { along: 0.0, wide: 1.0 };
    for _ in 0..3 {
        println!(\"{}\", ekf.along);
        ekf.turn();
        ekf.settle();
    }
    let _ = turned;
}
";
    let directory = package("migrate_halves_missed", &[("robot".to_owned(), text.to_owned())]);
    let config = b"[[filter]]\ntype = \"robot::Ekf\"\nlaw = [[\"turn\"], [\"settle\"]]\n";
    workspace::write(&directory, "ceid-lint.toml", config);
    let said = migrate(&directory, &["--all", "--unsafe-fixes"]);
    said.assert_code(0)
        .assert_stderr("`settle` is a half of the law of `ekf`, and the loop does not tell where it would run");
    let (turned, _) = text.split_once("fn main").expect("it has one");
    assert!(binary(&directory, "robot").contains(turned.split_once("fn turned").expect("it is there").1));
}
