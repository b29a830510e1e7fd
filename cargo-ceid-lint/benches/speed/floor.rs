//! The least that a linter can cost: every file parsed once and its tree dropped, and every file searched for a word.

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};

use super::corpus::files_below;

/// Parses every file on all cores, the largest first.
pub(crate) fn parse(directory: &Path) {
    let mut files = files_below(directory);
    files.sort_by_key(|file| std::cmp::Reverse(file.metadata().map_or(0, |metadata| metadata.len())));
    let parsed = for_each(&files, |file| {
        let is_parsed = std::fs::read_to_string(file).is_ok_and(|text| syn::parse_file(&text).is_ok());
        proc_macro2::extra::invalidate_current_thread_spans();
        is_parsed
    });
    println!("{parsed} of {} files parsed", files.len());
}

/// Reads every file on all cores and parses those that call a method of the name `update`.
pub(crate) fn gate(directory: &Path) {
    let files = files_below(directory);
    let parsed = for_each(&files, |file| {
        let Ok(text) = std::fs::read_to_string(file) else { return false };
        let is_named = text.contains(".update(") || text.contains("::update");
        let is_parsed = is_named && syn::parse_file(&text).is_ok();
        if is_named {
            proc_macro2::extra::invalidate_current_thread_spans();
        }
        is_parsed
    });
    println!("{parsed} of {} files parsed", files.len());
}

fn for_each(files: &[PathBuf], work: impl Fn(&Path) -> bool + Sync) -> usize {
    let (next, done) = (AtomicUsize::new(0), AtomicUsize::new(0));
    std::thread::scope(|scope| {
        for _ in 0..super::cores() {
            let worker = || {
                while let Some(file) = files.get(next.fetch_add(1, Ordering::Relaxed)) {
                    done.fetch_add(usize::from(work(file)), Ordering::Relaxed);
                }
            };
            std::thread::Builder::new()
                .stack_size(64 << 20)
                .spawn_scoped(scope, worker)
                .expect("a thread can be started");
        }
    });
    done.into_inner()
}
