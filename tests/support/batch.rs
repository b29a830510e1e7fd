//! Several cases in one run: it takes longer to start the program than to check a case.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::{Arc, LazyLock, Mutex, OnceLock};

use super::case::Case;
use super::program::{Finding, Pair, check_files, report_files};

/// How many cases one run gets.
const CASES: usize = 16;

/// What the program says of one case.
#[derive(Clone, Debug, Default)]
pub(crate) struct Judged {
    pub(crate) findings: Vec<Finding>,
    /// Only of cases that expect some.
    pub(crate) pairs: Vec<Pair>,
}

/// By the name of the file.
type Batch = BTreeMap<String, Result<Judged, String>>;

/// The batches so far, by the first file of each. Whoever comes first runs it, and the others wait for the answer.
static BATCHES: LazyLock<Mutex<BTreeMap<PathBuf, Arc<OnceLock<Batch>>>>> = LazyLock::new(Mutex::default);

/// What the program says of a case, when it is given the cases beside it as well.
///
/// # Errors
///
/// A run that did not come to its end, with what it printed.
pub(crate) fn judged(path: &Path) -> Result<Judged, String> {
    let directory = path.parent().ok_or("a file lies in a directory")?;
    let entries = directory.read_dir().map_err(|error| error.to_string())?;
    let mut files: Vec<PathBuf> = entries.filter_map(|entry| Some(entry.ok()?.path())).collect();
    files.retain(|file| file.extension().is_some_and(|extension| extension == "rs"));
    files.sort();
    let mut batches = files.chunks(CASES);
    let files = batches.find(|files| files.iter().any(|file| file == path)).ok_or("the case is gone")?;
    let batch = {
        let mut batches = BATCHES.lock().map_err(|error| error.to_string())?;
        Arc::clone(batches.entry(files[0].clone()).or_default())
    };
    let batch = batch.get_or_init(|| match judge(directory, files) {
        Ok(judged) => judged.into_iter().map(|(name, judged)| (name, Ok(judged))).collect(),
        // Which of them it was is told by a run of each.
        Err(_) => files.iter().map(|file| (name(file), judge_alone(directory, file))).collect(),
    });
    batch.get(&name(path)).cloned().unwrap_or_else(|| Err("the case is gone".to_owned()))
}

fn judge_alone(directory: &Path, file: &Path) -> Result<Judged, String> {
    let mut judged = judge(directory, &[file.to_owned()])?;
    Ok(judged.remove(&name(file)).unwrap_or_default())
}

fn judge(directory: &Path, files: &[PathBuf]) -> Result<BTreeMap<String, Judged>, String> {
    let mut judged: BTreeMap<String, Judged> = BTreeMap::new();
    let mut checked: BTreeMap<Vec<String>, Vec<&Path>> = BTreeMap::new();
    let mut reported: Vec<&Path> = Vec::new();
    for file in files {
        judged.insert(name(file), Judged::default());
        // A case that cannot be read says so when its turn comes.
        let case = std::fs::read_to_string(file).ok().and_then(|text| Case::parse(&text).ok()).unwrap_or_default();
        reported.extend((!case.reports.is_empty()).then_some(file.as_path()));
        checked.entry(case.warned).or_default().push(file);
    }
    for (warned, files) in checked {
        for finding in check_files(directory, &files, &warned).findings()? {
            judged.entry(finding.file.clone()).or_default().findings.push(finding);
        }
    }
    if !reported.is_empty() {
        for pair in report_files(directory, &reported).pairs()? {
            judged.entry(pair.file.clone()).or_default().pairs.push(pair);
        }
    }
    Ok(judged)
}

fn name(file: &Path) -> String {
    file.file_name().unwrap_or_default().to_string_lossy().into_owned()
}
