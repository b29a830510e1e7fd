//! Workspaces of real code: the sources in cargo's registry under manifests without dependencies, which are parsed and never
//! built.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use cargo_ceid_lint::source::stable_hash;

/// The only place with something to find.
const FIXTURE: &str = "pub trait SampledFilter { fn update(&mut self, x: f64) -> f64; fn predict(&self) -> f64; }
pub struct Kf(f64);
impl SampledFilter for Kf {
    fn update(&mut self, x: f64) -> f64 { self.0 += x; self.0 }
    fn predict(&self) -> f64 { self.0 }
}
pub fn twice_and_never() {
    let (mut kf, mut pf) = (Kf(0.0), Kf(0.0));
    loop { kf.update(1.0); kf.update(2.0); let _ = pf.predict(); }
}
pub fn once() { let mut kf = Kf(0.0); loop { kf.update(1.0); } }
";

/// Names of crates that machines write.
const GENERATED: [&str; 8] = ["windows", "web-sys", "winapi", "libc", "linux-raw", "chrono-tz", "-pac", "-sys"];

pub(crate) struct Corpus {
    pub(crate) root: PathBuf,
    pub(crate) lines: usize,
    pub(crate) bytes: usize,
    pub(crate) files: usize,
    pub(crate) packages: usize,
}

/// A workspace with about so many lines, or with all that there are.
pub(crate) fn build(root: &Path, wanted: usize) -> Corpus {
    let mut lines = 0;
    let mut chosen = Vec::new();
    for (name, directory) in crates() {
        if lines >= wanted {
            break;
        }
        let own: usize = texts(&directory).iter().map(|(_, text)| text.lines().count()).sum();
        // A few large crates would be all of a small corpus.
        if (1_500..=wanted / 4).contains(&own) && own <= 70_000 && directory.join("src/lib.rs").is_file() {
            lines += own;
            chosen.push((name, directory));
        }
    }
    write_workspace(root, &chosen, |name, _| manifest(name))
}

/// Writes these crates as members of a workspace, with the one that has something to find.
pub(crate) fn write_workspace(
    root: &Path,
    crates: &[(String, PathBuf)],
    manifest_of: impl Fn(&str, &Path) -> String,
) -> Corpus {
    // The lock file stays, so that what was resolved once is not asked for again.
    for member in below(root).iter().filter(|path| path.is_dir()) {
        let _ = fs::remove_dir_all(member);
    }
    let mut corpus = Corpus { root: root.to_owned(), lines: 0, bytes: 0, files: 0, packages: crates.len() + 1 };
    for (name, directory) in crates {
        for (file, text) in texts(directory) {
            write(&root.join(name).join(file.strip_prefix(directory).expect("it lies below")), &text);
            corpus.lines += text.lines().count();
            corpus.bytes += text.len();
            corpus.files += 1;
        }
        write(&root.join(name).join("Cargo.toml"), &manifest_of(name, directory));
    }
    write(&root.join("ceid-fixture/Cargo.toml"), &manifest("ceid-fixture"));
    write(&root.join("ceid-fixture/src/lib.rs"), FIXTURE);
    let members: Vec<&str> = crates.iter().map(|(name, _)| name.as_str()).chain(["ceid-fixture"]).collect();
    write(&root.join("Cargo.toml"), &format!("[workspace]\nresolver = \"2\"\nmembers = {members:?}\n"));
    corpus
}

fn texts(directory: &Path) -> Vec<(PathBuf, String)> {
    let files = files_below(directory).into_iter();
    files.filter_map(|file| Some((file.clone(), fs::read_to_string(file).ok()?))).collect()
}

fn manifest(name: &str) -> String {
    let targets = ["bins", "examples", "tests", "benches"].map(|kind| format!("auto{kind} = false\n")).concat();
    format!(
        "[package]\nname = \"{name}\"\nversion = \"0.0.0\"\nedition = \"2021\"\nbuild = false\n{targets}[lib]\npath = \"src/lib.rs\"\n"
    )
}

/// The newest version of each crate in the registry but those of filters, in an order that only their names decide.
pub(crate) fn crates() -> Vec<(String, PathBuf)> {
    let home = std::env::var_os("CARGO_HOME").map(PathBuf::from);
    let home = home.or_else(|| Some(std::env::home_dir()?.join(".cargo"))).expect("there is a home directory");
    let presets = Path::new(env!("CARGO_MANIFEST_DIR")).join("presets");
    let mut newest: BTreeMap<String, (Vec<u64>, PathBuf)> = BTreeMap::new();
    for directory in below(&home.join("registry/src")).iter().flat_map(|registry| below(registry)) {
        let full = directory.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let cut = full.match_indices('-').find(|(at, _)| full[at + 1..].starts_with(|c: char| c.is_ascii_digit()));
        let Some((name, version)) = cut.map(|(at, _)| (&full[..at], &full[at + 1..])) else { continue };
        let version: Vec<u64> = version.split(['.', '-', '+']).map_while(|part| part.parse().ok()).collect();
        let is_of_filters = presets.join(name).with_extension("toml").is_file() || name.contains("ceid");
        if GENERATED.iter().any(|part| name.contains(part)) || is_of_filters || version.len() < 3 {
            continue;
        }
        if newest.get(name).is_none_or(|(known, _)| *known < version) {
            newest.insert(name.to_owned(), (version, directory));
        }
    }
    let mut crates: Vec<(String, PathBuf)> = newest.into_iter().map(|(name, (_, path))| (name, path)).collect();
    crates.sort_by_key(|(name, _)| stable_hash(name.as_bytes()));
    crates
}

pub(crate) fn files_below(directory: &Path) -> Vec<PathBuf> {
    let mut files = Vec::new();
    for path in below(directory) {
        if path.is_dir() && !path.ends_with("target") {
            files.extend(files_below(&path));
        } else if path.extension().is_some_and(|end| end == "rs") {
            files.push(path);
        }
    }
    files
}

fn below(directory: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(directory).into_iter().flatten().flatten();
    let mut paths: Vec<PathBuf> = entries.map(|entry| entry.path()).collect();
    paths.sort();
    paths
}

fn write(path: &Path, text: &str) {
    fs::create_dir_all(path.parent().expect("a file lies in a directory")).expect("the target directory is writable");
    fs::write(path, text).expect("the target directory is writable");
}
