//! What a run did not see although it is there: adds it to the report, and finds files that were named and that no target reads.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use crate::config::Config;
use crate::diagnostic::Problem;
use crate::pipeline::Report;
use crate::project::{self, Project, Seen};

/// The files that were named on the command line and belong to no target: they are checked on their own.
pub(super) fn files_of_no_target(project: &Project, report: &Report) -> Vec<PathBuf> {
    let as_read = files_read(report);
    let read: BTreeSet<PathBuf> = as_read.iter().filter_map(|file| std::fs::canonicalize(file).ok()).collect();
    let is_read = |file: &PathBuf| {
        as_read.contains(file.as_path()) || std::fs::canonicalize(file).is_ok_and(|file| read.contains(&file))
    };
    let is_left_out = |file: &PathBuf| file.ancestors().any(|above| report.left_out.contains(above));
    // A file that was never saved is none on the disk.
    let named = project.only.iter().filter(|path| path.extension().is_some_and(|it| it == "rs") && !path.is_dir());
    named.filter(|file| !is_read(file) && !is_left_out(file)).cloned().collect()
}

/// Adds what lies beside what was read.
pub(super) fn add_unread(project: &Project, config: &Config, report: &mut Report) {
    let broken: Vec<PathBuf> = report.problems.iter().map(|problem| project.root.join(&problem.file)).collect();
    let read = files_read(report);
    let seen = Seen {
        read: &read,
        unparsed: &report.unparsed,
        left_out: &report.left_out,
        beside: &report.beside,
        broken: &broken,
    };
    let mut unread: Vec<Problem> = Vec::new();
    for problem in project::strays(project, &seen) {
        let path = PathBuf::from(&problem.file);
        if project.is_wanted(&path) && !config.is_excluded(&path) {
            unread.push(problem);
        }
    }
    for file in project.only.iter().filter(|path| path.is_file() && report.left_out.contains(*path)) {
        unread.push(Problem {
            file: file.to_string_lossy().into_owned(),
            span: None,
            message: "is no part of this build: `cfg` leaves its module out".to_owned(),
            help: Some("choose its features with `--features`, or its target with `--target`".to_owned()),
            is_error: false,
        });
    }
    for mut problem in unread {
        problem.file = report.sources.display_name(problem.file.as_ref());
        report.unread.push(problem);
    }
}

fn files_read(report: &Report) -> BTreeSet<&Path> {
    report.sources.files().map(|(_, file)| file.path.as_path()).collect()
}
