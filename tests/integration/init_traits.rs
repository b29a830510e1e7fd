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
