//! Work on all cores, and on stacks that are large enough for the longest expression that is read. Knows nothing of the work.

use std::cell::Cell;
use std::cmp::Reverse;
use std::ops::Range;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread::{Builder, JoinHandle, Scope, ScopedJoinHandle};

/// The stack of a deep thread in bytes: in a debug build, the longest input that is read takes less than half of it. Pages that
/// are not touched cost nothing but addresses.
const STACK_BYTES: usize = if cfg!(target_pointer_width = "64") { 512 * 1024 * 1024 } else { 256 * 1024 * 1024 };

/// From how many bytes on a piece of work is large: the trees of such a text take so much memory that two of them at once would
/// decide how much the program takes.
const LARGE: u64 = 1024 * 1024;

/// As many pieces of deep work as are worth threads of their own.
const MANY: usize = 256;

thread_local! {
    /// Whether the thread has a large stack.
    static IS_DEEP: Cell<bool> = const { Cell::new(false) };
}

/// Runs `work` with a stack for deeply nested code, and waits for it: on a thread of its own, if the caller's stack is small.
///
/// The parser and everything that walks expressions by recursion belongs in here.
///
/// # Panics
/// If `work` panics, or if the system refuses a thread.
pub fn with_large_stack<T: Send>(work: impl FnOnce() -> T + Send) -> T {
    if IS_DEEP.get() {
        return work();
    }
    std::thread::scope(|scope| result_of(start(scope, Kind::Deep, work)))
}

/// Starts a thread that stays, with a stack for deeply nested code.
///
/// # Panics
/// If the system refuses a thread.
pub fn stay_with_large_stack(work: impl FnOnce() + Send + 'static) -> JoinHandle<()> {
    builder(Kind::Deep).spawn(|| deep(work)).expect("a thread can be started")
}

/// The results of `work` for each number below `count`, in their order, made on all cores.
pub fn in_parallel<T: Send>(count: usize, work: impl Fn(usize) -> T + Sync) -> Vec<T> {
    on_threads(Cores::all().0, Kind::Plain, 0, count, work)
}

/// The same for pieces of work whose sizes in bytes are known: the largest are begun first, so that none is left for one core at
/// the end, and those of more than a megabyte one after the other, as long as the other cores have something else to do. Each core
/// has a large stack.
pub fn biggest_first<T: Send>(sizes: &[u64], work: impl Fn(usize) -> T + Sync) -> Vec<T> {
    let mut order: Vec<usize> = (0..sizes.len()).collect();
    order.sort_by_key(|at| Reverse(sizes[*at]));
    let large = sizes.iter().filter(|size| **size >= LARGE).count();
    let numbered = |at: usize| (order[at], work(order[at]));
    let mut results = on_threads(Cores::all().0, Kind::Deep, large, order.len(), numbered);
    results.sort_by_key(|(number, _)| *number);
    results.into_iter().map(|(_, result)| result).collect()
}

/// How many cores deep work may take.
#[derive(Clone, Copy, Debug)]
pub struct Cores(usize);

impl Cores {
    /// The one that is at work.
    pub const OWN: Self = Self(1);

    /// All that the process may use.
    #[must_use]
    pub fn all() -> Self {
        // The system reads several files to tell it.
        static ALL: OnceLock<usize> = OnceLock::new();
        Self(*ALL.get_or_init(|| std::thread::available_parallelism().map_or(1, usize::from)))
    }

    /// The results of `work` for each number below `count`, in their order, made with large stacks; the caller has one.
    ///
    /// # Panics
    /// If `work` panics, or if the system refuses a thread.
    pub fn deeply<T: Send>(self, count: usize, work: impl Fn(usize) -> T + Sync) -> Vec<T> {
        let cores = if count < MANY { 1 } else { self.0 };
        on_threads(cores, Kind::Deep, 0, count, work)
    }
}

/// Numbers that threads take one by one.
struct Queue {
    next: AtomicUsize,
    end: usize,
}

impl Queue {
    fn of(numbers: Range<usize>) -> Self {
        Self { next: AtomicUsize::new(numbers.start), end: numbers.end }
    }

    fn take(&self) -> Option<usize> {
        Some(self.next.fetch_add(1, Ordering::Relaxed)).filter(|number| *number < self.end)
    }
}

/// The first thread begins with the numbers below `large`, the others begin with those above.
fn on_threads<T: Send>(
    threads: usize,
    kind: Kind,
    large: usize,
    count: usize,
    work: impl Fn(usize) -> T + Sync,
) -> Vec<T> {
    let threads = threads.min(count);
    if threads <= 1 {
        return (0..count).map(work).collect();
    }
    let queues = [Queue::of(0..large), Queue::of(large..count)];
    let take = |own: usize| {
        let next = || queues[own].take().or_else(|| queues[1 - own].take());
        std::iter::from_fn(next).map(|number| (number, work(number))).collect::<Vec<_>>()
    };
    let take = &take;
    let mut results: Vec<(usize, T)> = std::thread::scope(|scope| {
        let workers: Vec<_> = (0..threads).map(|worker| start(scope, kind, move || take(worker.min(1)))).collect();
        workers.into_iter().flat_map(result_of).collect()
    });
    results.sort_unstable_by_key(|(number, _)| *number);
    results.into_iter().map(|(_, result)| result).collect()
}

/// Which stack a thread has.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Kind {
    Plain,
    Deep,
}

fn start<'s, T: Send + 's>(
    scope: &'s Scope<'s, '_>,
    kind: Kind,
    work: impl FnOnce() -> T + Send + 's,
) -> ScopedJoinHandle<'s, T> {
    let work = move || if kind == Kind::Deep { deep(work) } else { work() };
    builder(kind).spawn_scoped(scope, work).expect("a thread can be started")
}

fn builder(kind: Kind) -> Builder {
    match kind {
        Kind::Plain => Builder::new(),
        Kind::Deep => Builder::new().name("deep".to_owned()).stack_size(STACK_BYTES),
    }
}

fn deep<T>(work: impl FnOnce() -> T) -> T {
    IS_DEEP.set(true);
    work()
}

fn result_of<T>(thread: ScopedJoinHandle<'_, T>) -> T {
    thread.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn results_are_in_order() {
        let squares: Vec<usize> = (0..1000).map(|number| number * number).collect();
        assert_eq!(in_parallel(1000, |number| number * number), squares);
        assert_eq!(Cores(3).deeply(1000, |number| number * number), squares);
        assert_eq!(Cores::OWN.deeply(1000, |number| number * number), squares);
        assert_eq!(biggest_first(&[1, 3, 2], |at| at), [0, 1, 2]);
        assert_eq!(biggest_first(&[LARGE, 3, LARGE + 1, 0, LARGE], |at| at), [0, 1, 2, 3, 4]);
    }

    #[test]
    fn a_panic_reaches_the_caller() {
        let caught = std::panic::catch_unwind(|| Cores(2).deeply(MANY, |number| assert_ne!(number, 7)));
        assert!(caught.is_err());
    }
}
