//! Bugs of the tool: a panic becomes a message that asks to report it.

use std::io::Write;
use std::panic::{self, AssertUnwindSafe, PanicHookInfo};
use std::sync::{Mutex, PoisonError};

use super::ExitStatus;

/// What the first panic said, and where; those that follow from it say nothing new.
static FIRST: Mutex<Option<String>> = Mutex::new(None);

/// Runs `body`; a panic in it is told as a bug, and ends the run as incomplete.
pub(super) fn caught(body: impl FnOnce() -> ExitStatus) -> ExitStatus {
    panic::set_hook(Box::new(remember));
    let result = panic::catch_unwind(AssertUnwindSafe(body));
    let _ = panic::take_hook();
    result.unwrap_or_else(|_| {
        let what = FIRST.lock().unwrap_or_else(PoisonError::into_inner).take();
        let what = what.unwrap_or_else(|| "no message".to_owned());
        let version = env!("CARGO_PKG_VERSION");
        let _ = writeln!(
            std::io::stderr().lock(),
            "error: this is a bug in cargo-ceid-lint {version}, and not in the checked code: {what}\n\
             help: please report it, with the smallest source that shows it"
        );
        ExitStatus::Incomplete
    })
}

fn remember(info: &PanicHookInfo<'_>) {
    let payload = info.payload();
    let text = payload.downcast_ref::<&str>().copied().or_else(|| payload.downcast_ref::<String>().map(String::as_str));
    let place = info.location().map_or_else(String::new, |place| format!(" ({}:{})", place.file(), place.line()));
    let mut first = FIRST.lock().unwrap_or_else(PoisonError::into_inner);
    first.get_or_insert_with(|| format!("{}{place}", text.unwrap_or("no message")));
}
