//! What the tests share: the parser of case files, and the only code that runs the program.

// Each test program uses its own part of this module.
#![allow(dead_code, clippy::allow_attributes)]

pub(crate) mod batch;
pub(crate) mod case;
pub(crate) mod program;
pub(crate) mod workspace;

/// Every rule that the program knows, by its name without prefix.
pub(crate) const RULES: [&str; RULE_COUNT] = {
    let mut names = [""; RULE_COUNT];
    let mut at = 0;
    while at < RULE_COUNT {
        names[at] = cargo_ceid_lint::rules::RULES[at].name;
        at += 1;
    }
    names
};

const RULE_COUNT: usize = cargo_ceid_lint::rules::RULES.len();

/// The root of the repository.
pub(crate) fn root() -> std::path::PathBuf {
    let root = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    root.canonicalize().expect("the crate lies in the repository")
}
