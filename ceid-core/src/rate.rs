//! Rates as types: how often a control cycle is released. Nothing here reads a clock.

#![forbid(unsafe_code)]

use core::fmt::Debug;

const NS_PER_S: u64 = 1_000_000_000;

/// The nominal rate of a control cycle, known at compile time.
///
/// The step `dt` of every update law comes from here, through [`Tick::dt`](crate::Tick::dt), so a filter and its loop
/// cannot disagree about time.
///
/// [`Hz`] is enough for most programs. Implement the trait for a type of your own when two loops of equal rate must not
/// share filters by accident; then give `HZ` only, and leave the provided items as they are.
pub trait Rate: Copy + Debug + Send + Sync + 'static {
    /// Releases per second, at least 1.
    const HZ: u32;

    /// Time from one release to the next, in seconds.
    ///
    /// A rate of 0 Hz is a compile error here.
    const DT: f64 = {
        assert!(Self::HZ > 0, "a rate of 0 Hz has no period: use a rate of at least 1 Hz");
        1.0 / Self::HZ as f64
    };

    /// Time from one release to the next, in seconds, for targets without fast `f64`.
    const DT_F32: f32 = Self::DT as f32;

    /// When release `n` is due, in nanoseconds after release 0, rounded down.
    ///
    /// Exact for every `n`: the error of a truncated period does not add up (at 30 Hz it would be 1 ms after 28 hours).
    /// Saturates after 584 years. Does not allocate, does not block.
    #[must_use]
    #[inline]
    fn release_ns(n: u64) -> u64 {
        let hz = u64::from(Self::HZ);
        if NS_PER_S % hz == 0 {
            return n.saturating_mul(NS_PER_S / hz);
        }
        // Whole seconds and the rest apart: both products fit in 64 bits, where `n * 10^9` would not.
        (n / hz).saturating_mul(NS_PER_S).saturating_add((n % hz) * NS_PER_S / hz)
    }

    /// How many releases are due by `ns` nanoseconds after release 0: release 0 and one due at `ns` are among them.
    ///
    /// The exact inverse of [`release_ns`](Rate::release_ns): release `n` is due by `ns` if and only if
    /// `n < released_by(ns)`. Saturates. Does not allocate, does not block.
    #[must_use]
    #[inline]
    fn released_by(ns: u64) -> u64 {
        let hz = u64::from(Self::HZ);
        // Rounded up, because release times are rounded down.
        let in_last_second = ((ns % NS_PER_S + 1) * hz).div_ceil(NS_PER_S);
        (ns / NS_PER_S).saturating_mul(hz).saturating_add(in_last_second)
    }
}

/// A rate of `N` releases per second.
///
/// `Hz<0>` can be named but not used: every use of its rate is a compile error, shown by `cargo build` (in
/// [`filters!`](crate::filters), by `cargo check` as well).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub struct Hz<const N: u32>;

impl<const N: u32> Rate for Hz<N> {
    const HZ: u32 = {
        assert!(N > 0, "a rate of 0 Hz has no period: use a rate of at least 1 Hz");
        N
    };
}
