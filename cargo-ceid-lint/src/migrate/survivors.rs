//! Who goes on where code has panicked, as a text tells.

use super::text::{has_word, without_comments};

/// Whether panics are caught.
pub(super) fn catches(text: &str) -> bool {
    has_word(text, "catch_unwind") && has_word(&without_comments(text), "catch_unwind")
}

/// Whether a test is one of a panic.
pub(super) fn expects(text: &str) -> bool {
    has_word(text, "should_panic")
}

/// Whether others go on where a thread has panicked: they take what it has locked, or do not pass its panic on where they wait for it.
pub(super) fn outlives_threads(text: &str) -> bool {
    let words = ["PoisonError", "is_poisoned", "clear_poison", "parking_lot"];
    let opens_poisoned = || has_word(text, "lock") && has_word(text, "into_inner");
    let passes_on = |rest: &str| [".unwrap()", ".expect("].iter().any(|begin| rest.trim_start().starts_with(begin));
    // Whatever takes nothing and is called so joins a thread; paths and texts are joined with something.
    let mut waits = text.match_indices(".join()").map(|(at, wait)| &text[at + wait.len()..]);
    words.iter().any(|word| has_word(text, word))
        || opens_poisoned()
        || text.contains("tokio::sync")
        || waits.any(|rest| !passes_on(rest))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_comment_says_catches_nothing() {
        assert!(catches("let ended = std::panic::catch_unwind(run);"));
        assert!(!catches("// There is no `catch_unwind` here.\nfn main() {}"));
    }

    #[test]
    fn a_thread_is_outlived_where_its_panic_is_not_passed_on() {
        assert!(outlives_threads("let failed = worker.join().is_err();"));
        assert!(outlives_threads("let _ = worker.join();"));
        assert!(outlives_threads("kf.lock().unwrap_or_else(|poisoned| poisoned.into_inner())"));
        assert!(!outlives_threads("worker.join().unwrap(); other.join()\n    .expect(\"it ends\"); path.join(\"a\");"));
    }
}
