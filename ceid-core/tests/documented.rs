//! The documentation of each public function says whether it allocates and whether it blocks, and on what its time depends
//! if it is not constant. The examples of the README are as short as they are said to be.

use std::fs;
use std::path::{Path, PathBuf};

/// A public function, or a function of a public trait.
struct Function {
    place: String,
    /// In lower case, with attributes.
    documentation: String,
    body: String,
}

#[test]
fn each_public_function_says_whether_it_allocates_and_blocks() {
    expect_of_each("whether it allocates and blocks", |function| {
        function.documentation.contains("alloc") && function.documentation.contains("block")
    });
}

#[test]
fn one_that_blocks_says_for_how_long() {
    expect_of_each("for how long it blocks", |function| {
        let says = |sentence: &str| {
            ["until", "as long", "how long", "whole run", "as a ", "as `"].map(|it| sentence.contains(it))
        };
        let negations = ["not", "nor", "neither", "never"];
        function
            .documentation
            .split(['.', ';'])
            .filter(|sentence| sentence.split(' ').any(|word| word.trim_matches(',') == "blocks"))
            .filter(|sentence| !sentence.split(' ').any(|word| negations.contains(&word)))
            .all(|sentence| says(sentence).contains(&true))
    });
}

#[test]
fn one_with_a_loop_says_what_its_time_depends_on() {
    expect_of_each("on what its time depends", |function| {
        let loops = ["for ", "while ", "loop {"]
            .iter()
            .any(|start| function.body.lines().any(|line| line.trim_start().starts_with(start)));
        !(loops || function.body.contains(".iter()")) || function.documentation.contains("time")
    });
}

/// A correct loop from an empty crate: what the README promises first.
#[test]
fn the_first_example_has_at_most_fifteen_lines() {
    let example = example("## A correct 1 kHz loop");
    assert!(example.len() <= 15, "it has {} lines", example.len());
    assert!(example.iter().any(|line| line.contains("@ 1000 Hz { speed: LowPass; current: LowPass }")));
}

#[track_caller]
fn expect_of_each(what: &str, is_said: impl Fn(&Function) -> bool) {
    let functions = functions();
    assert!(functions.len() > 100, "only {} functions were found", functions.len());
    let silent: Vec<_> = functions.iter().filter(|it| !is_said(it)).map(|it| it.place.as_str()).collect();
    assert!(silent.is_empty(), "say {what}:\n{}", silent.join("\n"));
}

fn functions() -> Vec<Function> {
    let mut functions = Vec::new();
    for file in sources() {
        let text = fs::read_to_string(&file).expect("a source file can be read");
        let lines: Vec<_> = text.lines().take_while(|line| !line.starts_with("#[cfg(test)]")).collect();
        let mut above = String::new();
        let mut in_a_public_trait = false;
        for (at, line) in lines.iter().enumerate() {
            let code = line.trim_start();
            if code.starts_with("///") || code.starts_with("#[") || code.starts_with("//") {
                above += &code.trim_start_matches('/').to_lowercase();
                above.push(' ');
                continue;
            }
            let is_hidden = above.contains("doc(hidden)");
            match line.split(' ').next() {
                Some("pub") => in_a_public_trait = code.starts_with("pub trait ") && !is_hidden,
                Some("}") => in_a_public_trait = false,
                _ => {}
            }
            let is_public = code.starts_with("pub fn ")
                || code.starts_with("pub const fn ")
                || in_a_public_trait && code.starts_with("fn ");
            if is_public && !is_hidden {
                let end = format!("{}}}", &line[..line.len() - code.len()]);
                let body = lines.iter().skip(at).take_while(|line| **line != end);
                let body =
                    if code.ends_with(';') { String::new() } else { body.copied().collect::<Vec<_>>().join("\n") };
                let place = format!("{}:{}: {code}", file.display(), at + 1);
                functions.push(Function { place, documentation: above.clone(), body });
            }
            above.clear();
        }
    }
    functions
}

fn sources() -> Vec<PathBuf> {
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    ["cycle", "exchange", "filter", "thread"]
        .iter()
        .flat_map(|folder| fs::read_dir(source.join(folder)).expect("the sources are there"))
        .map(|entry| entry.expect("it can be read").path())
        .chain(["rate.rs", "transaction.rs"].map(|file| source.join(file)))
        .collect()
}

/// The lines that a reader sees of the first example below a heading.
fn example(heading: &str) -> Vec<String> {
    let readme = Path::new(env!("CARGO_MANIFEST_DIR")).join("README.md");
    let readme = fs::read_to_string(readme).expect("the crate has a README");
    let section = readme.split(heading).nth(1).expect("it has that section");
    let code = section.split("```rust\n").nth(1).and_then(|rest| rest.split("```").next()).expect("it has an example");
    code.lines().filter(|line| !line.is_empty() && !line.starts_with('#')).map(str::to_owned).collect()
}
