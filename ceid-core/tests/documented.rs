//! The documentation of each public function says whether it allocates and whether it blocks.

use std::fs;
use std::path::{Path, PathBuf};

#[test]
fn each_public_function_says_whether_it_allocates_and_blocks() {
    let mut silent = Vec::new();
    for file in sources() {
        let text = fs::read_to_string(&file).expect("a source file can be read");
        let mut above = String::new();
        for (line, code) in text.lines().map(str::trim_start).enumerate() {
            if code.starts_with("///") || code.starts_with("#[") || code.starts_with("//") {
                above += &code.to_lowercase();
                continue;
            }
            let is_public = code.starts_with("pub fn ") || code.starts_with("pub const fn ");
            if is_public && !above.contains("doc(hidden)") && !(above.contains("alloc") && above.contains("block")) {
                silent.push(format!("{}:{}: {code}", file.display(), line + 1));
            }
            above.clear();
        }
    }
    assert!(silent.is_empty(), "say it for\n{}", silent.join("\n"));
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
