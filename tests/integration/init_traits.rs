//! One entry for a trait, or one for each of its types.

use std::fmt::Write as _;

use crate::init::written_for;

/// A library of blocks behind one trait, of which so many remember something.
fn library(filters: usize, gains: usize) -> String {
    let mut code = "pub trait Block { fn process(&mut self, x: f32) -> f32; }\n".to_owned();
    for number in 0..filters {
        write!(
            code,
            "pub struct Low{number} {{ y: f32 }}\nimpl Block for Low{number} {{\n\
             fn process(&mut self, x: f32) -> f32 {{ self.y += 0.{number}1 * (x - self.y); self.y }} }}\n\
             pub fn run{number}(mut low: Low{number}) {{ loop {{ low.process({number}.0); }} }}\n"
        )
        .expect("a String");
    }
    for number in 0..gains {
        write!(
            code,
            "pub struct Gain{number} {{ by: f32 }}\nimpl Block for Gain{number} {{\n\
             fn process(&mut self, x: f32) -> f32 {{ self.by * x }} }}\n"
        )
        .expect("a String");
    }
    code
}

#[test]
fn many_filters_of_one_trait_get_one_entry() {
    let file = written_for("init_library", &library(9, 14));
    assert!(file.contains("trait = \"crate::Block\"\n#law = \"process\""), "{file}");
    assert!(!file.contains("type = \"crate::Low"), "{file}");
}

#[test]
fn a_few_filters_among_many_others_get_an_entry_each() {
    let file = written_for("init_few", &library(3, 9));
    assert!(!file.contains("trait = \"crate::Block\""), "{file}");
    assert_eq!(file.matches("type = \"crate::Low").count(), 3, "{file}");
}

#[test]
fn an_entry_for_a_type_says_what_its_trait_does_as_well() {
    let code = "pub trait Filter { fn process(&mut self, x: f32) -> f32; }\n\
                pub struct Lag { y: f32, rise: f32 }\n\
                impl Lag { pub fn process_initial(&mut self, x: f32, gain: f32) -> f32 { self.y += gain * self.rise * (x - self.y); self.y } }\n\
                impl Filter for Lag { fn process(&mut self, x: f32) -> f32 { self.y += self.rise * (x - self.y); self.y } }\n\
                pub struct Rms { s: f32, alpha: f32 }\n\
                impl Filter for Rms { fn process(&mut self, x: f32) -> f32 { self.s += self.alpha * (x * x - self.s); self.s } }\n\
                pub fn run(mut lag: Lag, mut rms: Rms) { loop { let x = rms.process(1.0); lag.process(x); } }\n";
    let file = written_for("init_type_and_trait", code);
    assert!(file.contains("trait = \"crate::Filter\""), "{file}");
    assert!(file.contains("[\"process\", \"process_initial\"]") || !file.contains("crate::Lag"), "{file}");
    assert!(!file.contains("law = \"process_initial\""), "{file}");
}

#[test]
fn halves_have_other_names_as_well() {
    let code = "pub struct PhaseKalman { x: f64, p: f64, q: f64 }\nimpl PhaseKalman {\n\
                pub fn advance_time(&mut self, dt: f64) { self.x += dt * self.p; self.p += self.q * dt; }\n\
                pub fn measurement(&mut self, z: f64) { let k = self.p / (self.p + 1.0); self.x += k * (z - self.x); self.p *= 1.0 - k; }\n\
                }\npub fn run(mut kf: PhaseKalman) { loop { kf.advance_time(0.01); kf.measurement(1.0); } }\n";
    let file = written_for("init_advance_and_measure", code);
    assert!(file.contains("law = [[\"advance_time\"], [\"measurement\"]]\n"), "{file}");
}
