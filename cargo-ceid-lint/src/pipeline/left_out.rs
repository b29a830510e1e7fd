//! What the targets define that a run leaves out, because they were not selected: an entry that names it does not name nothing.

use std::path::{Path, PathBuf};

use crate::source::ReadSource;

/// How many modules are looked at below a root.
const MAX_FILES: usize = 200;

/// Whether a file of these targets defines something with the last name of a path. The files are not parsed: an entry is accepted
/// rather than refused.
pub(super) fn define(roots: &[&Path], path: &str, source: &dyn ReadSource) -> bool {
    let name = path.rsplit("::").next().unwrap_or_default();
    let mut open: Vec<PathBuf> = roots.iter().map(|root| root.to_path_buf()).collect();
    let mut at = 0;
    while let Some(file) = open.get(at).cloned() {
        at += 1;
        let Ok(text) = source.read(&file) else { continue };
        let words = text.split(|it: char| !(it.is_alphanumeric() || it == '_')).filter(|word| !word.is_empty());
        let mut before = "";
        for word in words {
            if matches!(before, "struct" | "enum" | "trait" | "type" | "fn") && word == name {
                return true;
            }
            if before == "mod" && open.len() < MAX_FILES {
                open.extend(files_of_module(&file, word, source));
            }
            before = word;
        }
    }
    false
}

/// The file of a module, as the one that declares it names it.
fn files_of_module(declaring: &Path, name: &str, source: &dyn ReadSource) -> Vec<PathBuf> {
    let beside = declaring.with_file_name("");
    let below = declaring.with_extension("");
    let places = [&beside, &below]
        .into_iter()
        .flat_map(|directory| [directory.join(format!("{name}.rs")), directory.join(name).join("mod.rs")]);
    places.filter(|path| path != declaring && source.exists(path)).collect()
}
