//! How late cycles began, counted in buckets that exist before the first cycle.

/// A histogram of durations in nanoseconds, with `BUCKETS` buckets of one width.
///
/// Bucket `i` counts the durations from `i` widths up to `i + 1` widths; longer ones are counted together. Counts stop
/// at 2^32 - 1 instead of wrapping (49 days at 1 kHz).
///
/// ```
/// use ceid_core::thread::Histogram;
///
/// let mut late = Histogram::<100>::with_width_ns(1_000);
/// for ns in [300, 1_200, 1_700, 250_000] {
///     late.record(ns);
/// }
/// assert_eq!(late.quantile_ns(0.5), Some(2_000));
/// assert_eq!((late.count(), late.beyond(), late.max_ns()), (4, 1, 250_000));
/// ```
///
/// No method allocates, blocks or panics.
#[derive(Debug, Clone)]
pub struct Histogram<const BUCKETS: usize> {
    width_ns: u64,
    buckets: [u32; BUCKETS],
    beyond: u32,
    min_ns: u64,
    max_ns: u64,
}

impl<const BUCKETS: usize> Histogram<BUCKETS> {
    /// An empty histogram; a width of 0 is taken as 1. Does not allocate, block or panic.
    #[must_use]
    pub const fn with_width_ns(width_ns: u64) -> Self {
        let width_ns = if width_ns == 0 { 1 } else { width_ns };
        Self { width_ns, buckets: [0; BUCKETS], beyond: 0, min_ns: u64::MAX, max_ns: 0 }
    }

    /// Counts one duration. Does not allocate, block or panic; one division.
    #[inline]
    pub fn record(&mut self, ns: u64) {
        self.min_ns = self.min_ns.min(ns);
        self.max_ns = self.max_ns.max(ns);
        // Without buckets there is nothing to divide for.
        let bucket = if BUCKETS == 0 { None } else { usize::try_from(ns / self.width_ns).ok() };
        let bucket = bucket.and_then(|bucket| self.buckets.get_mut(bucket));
        let count = bucket.unwrap_or(&mut self.beyond);
        *count = count.saturating_add(1);
    }

    /// The counts, from the shortest durations on. Does not allocate, block or panic.
    #[must_use]
    pub const fn buckets(&self) -> &[u32; BUCKETS] {
        &self.buckets
    }

    /// The number of durations beyond the last bucket. Does not allocate, block or panic.
    #[must_use]
    pub const fn beyond(&self) -> u32 {
        self.beyond
    }

    /// The width of a bucket. Does not allocate, block or panic.
    #[must_use]
    pub const fn width_ns(&self) -> u64 {
        self.width_ns
    }

    /// The number of durations. Does not allocate, block or panic; takes time for each bucket.
    #[must_use]
    pub fn count(&self) -> u64 {
        self.buckets.iter().copied().map(u64::from).sum::<u64>() + u64::from(self.beyond)
    }

    /// The shortest duration, exactly, or 0 if there is none. Does not allocate, block or panic.
    #[must_use]
    pub fn min_ns(&self) -> u64 {
        self.min_ns.min(self.max_ns)
    }

    /// The longest duration, exactly, or 0 if there is none. Does not allocate, block or panic.
    #[must_use]
    pub const fn max_ns(&self) -> u64 {
        self.max_ns
    }

    /// A duration that the share `quantile` of all durations does not exceed: the upper end of its bucket, or the
    /// longest duration if that is shorter or the bucket is the one beyond. `None` if there are no durations.
    ///
    /// Does not allocate, block or panic: a quantile outside 0 to 1 is taken as the nearer of the two. Takes time for each
    /// bucket.
    #[must_use]
    pub fn quantile_ns(&self, quantile: f64) -> Option<u64> {
        let count = self.count();
        if count == 0 {
            return None;
        }
        // Rounded up without `f64::ceil`, which `core` lacks in the oldest supported version.
        let wanted = quantile.clamp(0.0, 1.0) * count as f64;
        let mut rank = wanted as u64;
        if (rank as f64) < wanted || rank == 0 {
            rank += 1;
        }
        let mut seen = 0;
        for (bucket, bucket_count) in (1..).zip(self.buckets.iter()) {
            seen += u64::from(*bucket_count);
            if seen >= rank {
                return Some(self.max_ns.min(self.width_ns.saturating_mul(bucket)));
            }
        }
        Some(self.max_ns)
    }

    /// Forgets everything but the width. Does not allocate, block or panic.
    pub const fn clear(&mut self) {
        *self = Self::with_width_ns(self.width_ns);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_empty_histogram_has_no_quantiles() {
        let empty = Histogram::<4>::with_width_ns(10);
        assert_eq!((empty.quantile_ns(0.5), empty.min_ns(), empty.max_ns(), empty.count()), (None, 0, 0, 0));
    }

    #[test]
    fn quantiles_are_upper_ends_of_buckets() {
        let mut histogram = Histogram::<4>::with_width_ns(10);
        [0, 9, 10, 25, 39, 40, 1_000].into_iter().for_each(|ns| histogram.record(ns));
        assert_eq!(histogram.buckets(), &[2, 1, 1, 1]);
        assert_eq!((histogram.beyond(), histogram.min_ns(), histogram.max_ns()), (2, 0, 1_000));
        let quantiles = [-1.0, 0.0, 0.28, 0.3, 0.5, 0.71, 0.9, 1.0, 7.0].map(|q| histogram.quantile_ns(q));
        assert_eq!(quantiles, [10, 10, 10, 20, 30, 40, 1_000, 1_000, 1_000].map(Some));
        histogram.clear();
        assert_eq!(histogram.count(), 0);
    }

    #[test]
    fn strange_input_is_counted_all_the_same() {
        let mut none = Histogram::<0>::with_width_ns(0);
        none.record(u64::MAX);
        assert_eq!((none.count(), none.quantile_ns(f64::NAN), none.width_ns()), (1, Some(u64::MAX), 1));
    }
}
