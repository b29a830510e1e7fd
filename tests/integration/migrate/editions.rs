//! What depends on the edition of the crate.

use std::path::{Path, PathBuf};

use super::{binary, migrate, package, read};
use crate::support::workspace;

fn with_edition(directory: &Path, edition: &str) {
    let manifest = read(&directory.join("Cargo.toml")).replace("2024", edition);
    workspace::write(directory, "Cargo.toml", manifest.as_bytes());
}

const CLOSURES: &str = "\
trait SampledFilter { fn update(&mut self); }
struct Lowpass { raw: i64, value: i64 }
impl SampledFilter for Lowpass { fn update(&mut self) { self.value += self.raw; } }
struct Scale { lowpass: Lowpass, limits: Vec<i64>, tare: i64 }

impl Scale {
    fn weigh(&mut self, raw: &[i64]) {
        for value in raw {
            self.lowpass.raw = raw.iter().filter(|raw| self.limits.contains(raw)).count() as i64 - value;
            self.lowpass.update();
        }
    }

    fn tared(&mut self, raw: &[i64]) {
        for value in raw {
            let tare = &self.tare;
            self.lowpass.raw = raw.iter().map(|raw| raw - tare).sum::<i64>() - value;
            self.lowpass.update();
        }
    }
}

fn main() {
    let lowpass = Lowpass { raw: 0, value: 0 };
    let mut scale = Scale { lowpass, limits: vec![2], tare: 1 };
    scale.weigh(&[1, 2]);
    scale.tared(&[1, 2]);
    println!(\"{}\", scale.lowpass.value);
}
";

fn scale(name: &str, edition: &str) -> PathBuf {
    let directory = package(name, &[("scale".to_owned(), CLOSURES.to_owned())]);
    with_edition(&directory, edition);
    directory
}

#[test]
fn a_closure_that_takes_all_of_self_is_refused() {
    let directory = scale("migrate_edition_2018", "2018");
    let said = migrate(&directory, &["--all"]);
    said.assert_code(0).assert_stderr("migrated 1 of 2 loops");
    said.assert_stderr(
        "line 9: before edition 2021 a closure takes all of `self`, of which the guard holds `self.lowpass`",
    );
    said.assert_stderr("as in `let limits = &self.limits;`");
    super::compiled::cargo(&directory, &["check", "--quiet"]);
    assert!(binary(&directory, "scale").contains("let tare = &self.tare;"));
}

#[test]
fn a_closure_takes_one_field_in_later_editions() {
    let directory = scale("migrate_edition_2021", "2021");
    migrate(&directory, &["--all"]).assert_code(0).assert_stderr("migrated 2 of 2 loops");
    super::compiled::cargo(&directory, &["check", "--quiet"]);
}

#[test]
fn the_first_edition_says_how_to_leave_it() {
    let directory = scale("migrate_edition_2015", "2015");
    migrate(&directory, &["--all"]).assert_code(0).assert_stderr("run `cargo fix --edition`");
    assert_eq!(binary(&directory, "scale"), CLOSURES);
}

const TAILS: &str = "\
use std::cell::RefCell;
trait SampledFilter { fn update(&mut self); }
struct Recorder { value: f64, log: RefCell<Vec<f64>> }
impl SampledFilter for Recorder { fn update(&mut self) { self.value += 1.0; } }

fn main() {
    let mut recorder = Recorder { value: 0.0, log: RefCell::default() };
    for step in 0..3 {
        recorder.log.borrow_mut().push(f64::from(step));
        recorder.update();
        if let Some(last) = recorder.log.borrow().last() {
            println!(\"{last}\");
        }
    }
    for _ in 0..3 {
        recorder.update();
        let known = recorder.log.borrow().len();
        println!(\"{known}\");
    }
    for _ in 0..3 {
        recorder.update();
        for known in recorder.log.borrow().iter() {
            println!(\"{known}\");
        }
    }
    for _ in 0..3 {
        recorder.update();
        while let Some(known) = recorder.log.borrow_mut().pop() {
            println!(\"{known}\");
        }
    }
}
";

#[test]
fn what_is_borrowed_at_the_end_of_a_block_outlives_a_guard_before_edition_2024() {
    for (name, edition, migrated) in [("migrate_tail_2021", "2021", 3), ("migrate_tail_2024", "2024", 4)] {
        let directory = package(name, &[("recorder".to_owned(), TAILS.to_owned())]);
        with_edition(&directory, edition);
        let said = migrate(&directory, &["--all", "--unsafe-fixes"]);
        said.assert_code(0).assert_stderr(&format!("migrated {migrated} of 4 loops"));
        if edition == "2021" {
            said.assert_stderr("line 11: before edition 2024, what is borrowed of `recorder` at the end of a block");
        }
        super::compiled::cargo(&directory, &["check", "--quiet"]);
    }
}

const VARIABLES: &str = "\
use std::cell::RefCell;
trait SampledFilter { fn update(&mut self); }
struct Level(i64);
impl SampledFilter for Level { fn update(&mut self) { self.0 += 1; } }

fn of_the_iteration(level: &mut Level, readings: &[i64]) {
    for reading in readings {
        let seen = RefCell::new(vec![*reading]);
        if let Some(first) = seen.borrow().first() {
            println!(\"{first}\");
        }
        level.update();
    }
}

fn above_the_loop(level: &mut Level, readings: &[i64]) {
    let seen = RefCell::new(readings.to_vec());
    for _ in readings {
        if let Some(first) = seen.borrow().first() {
            println!(\"{first}\");
        }
        level.update();
    }
}

fn main() {
    let mut level = Level(0);
    of_the_iteration(&mut level, &[1, 2]);
    above_the_loop(&mut level, &[1, 2]);
    println!(\"{}\", level.0);
}
";

#[test]
fn what_an_update_stood_behind_gives_back_what_it_borrows_where_it_did() {
    for (edition, written) in [("2018", 2), ("2021", 2), ("2024", 0)] {
        let name = format!("migrate_variables_{edition}");
        let directory = package(&name, &[("level".to_owned(), VARIABLES.to_owned())]);
        with_edition(&directory, edition);
        let said = migrate(&directory, &["--all"]);
        said.assert_code(0).assert_stderr("migrated 2 of 2 loops");
        let text = binary(&directory, "level");
        assert_eq!(text.matches("        };\n    }\n").count(), written, "{text}");
        super::compiled::cargo(&directory, &["check", "--quiet"]);
    }
}
