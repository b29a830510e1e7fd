//! A thread whose stack is large enough for the longest expression that is read. Never decides what is too long: see
//! [`depth`](super::depth).

/// The stack of the thread in bytes: in a debug build, the longest input that is read takes less than half of it. Pages that
/// are not touched cost nothing but addresses.
const STACK_BYTES: usize = if cfg!(target_pointer_width = "64") { 512 * 1024 * 1024 } else { 256 * 1024 * 1024 };

/// Runs `work` on a thread with a stack for deeply nested code, and waits for it.
///
/// The parser and everything that walks expressions by recursion belongs in here.
///
/// # Panics
/// If `work` panics, or if the system refuses a thread.
pub fn with_large_stack<T: Send>(work: impl FnOnce() -> T + Send) -> T {
    std::thread::scope(|scope| {
        let thread = std::thread::Builder::new()
            .name("deep".to_owned())
            .stack_size(STACK_BYTES)
            .spawn_scoped(scope, work)
            .expect("a thread with a large stack can be started");
        match thread.join() {
            Ok(value) => value,
            Err(panic) => std::panic::resume_unwind(panic),
        }
    })
}
