//! The last step: from a revision to the disk, and back if the disk does not hold what was promised.

use super::{Disk, Revision, news, put_back, write};
use crate::pipeline::Report;

/// Writes what the revision changes, and checks what then lies on the disk. `before` is the report that the revision began with.
///
/// # Errors
/// Why nothing is changed, or what had to be left behind.
pub fn commit(
    revision: &Revision,
    before: &Report,
    disk: &mut dyn Disk,
    check: impl FnOnce() -> Report,
) -> Result<(), String> {
    if revision.changes.is_empty() {
        return Ok(());
    }
    write(&revision.changes, disk).map_err(|error| error.to_string())?;
    let news = news(before, &check());
    let Some(new) = news.first().map(|new| &new.words) else { return Ok(()) };
    match put_back(&revision.changes, disk) {
        Ok(()) => Err(format!("the files were put back as they were: {new}")),
        Err(error) => Err(format!("{new}; the files should be put back, but {error}")),
    }
}
