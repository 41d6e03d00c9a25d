//! A histogram of durations that the real-time loop can fill: fixed bins, constant memory, the same few instructions for
//! every value.
//!
//! The bins are log-linear, as in HdrHistogram: below 64 ns each nanosecond has its own, above that every octave is cut
//! into 32, so a quantile is at most 3.2 % too large. Durations of 2³⁰ ns (1.07 s) and more are counted as overflow; the
//! largest is kept exactly whatever its size.

use iceoryx2::prelude::ZeroCopySend;
use zerocopy::{FromBytes, Immutable, IntoBytes};

/// Bits of a value that choose the bin inside its octave.
const SUB_BITS: u32 = 5;
/// Durations from here on are overflow, ns (a power of two).
const OVERFLOW_NS: u64 = 1 << 30;
/// Bins that hold durations; one more holds the overflow.
const BINS: usize = ((30 - SUB_BITS as usize) << SUB_BITS) + (1 << SUB_BITS);

/// Counts of durations in ns, in fixed log-linear bins.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ZeroCopySend, IntoBytes, FromBytes, Immutable)]
#[repr(C)]
pub struct Histogram {
    count: u64,
    sum_ns: u64,
    max_ns: u64,
    bins: [u64; BINS + 1],
}

impl Histogram {
    /// Without any value.
    pub const fn new() -> Histogram {
        Histogram { count: 0, sum_ns: 0, max_ns: 0, bins: [0; BINS + 1] }
    }

    /// Counts one duration, ns. No branch depends on the value.
    #[inline]
    pub fn record(&mut self, ns: u64) {
        self.bins[bin_of(ns)] += 1;
        self.count += 1;
        self.sum_ns = self.sum_ns.wrapping_add(ns);
        self.max_ns = self.max_ns.max(ns);
    }

    /// How many durations were counted.
    pub fn count(&self) -> u64 {
        self.count
    }

    /// The largest duration, ns, exactly; 0 without any.
    pub fn max(&self) -> u64 {
        self.max_ns
    }

    /// How many durations were 2³⁰ ns or longer.
    pub fn overflow(&self) -> u64 {
        self.bins[BINS]
    }

    /// All durations together, ns.
    pub fn sum(&self) -> u64 {
        self.sum_ns
    }

    /// The mean duration, ns; NaN without any.
    pub fn mean(&self) -> f64 {
        self.sum_ns as f64 / self.count as f64
    }

    /// The duration, ns, that a share `q` (0..1) of all does not exceed: the upper end of its bin, never more than
    /// [`Histogram::max`]; at most 3.2 % above the true one. 0 without any value; `q` outside 0..1 (or NaN) is taken as the nearer end.
    pub fn quantile(&self, q: f64) -> u64 {
        let rank = ((q.clamp(0.0, 1.0) * self.count as f64).ceil() as u64).clamp(1, self.count.max(1));
        let mut seen = 0;
        for (bin, &n) in self.bins[..BINS].iter().enumerate() {
            // Counts out of somebody else's memory may be anything.
            seen = n.saturating_add(seen);
            if seen >= rank {
                return last_of(bin).min(self.max_ns);
            }
        }
        self.max_ns
    }

    /// Adds the counts of another histogram.
    pub fn merge(&mut self, other: &Histogram) {
        self.count = self.count.saturating_add(other.count);
        self.sum_ns = self.sum_ns.wrapping_add(other.sum_ns);
        self.max_ns = self.max_ns.max(other.max_ns);
        for (mine, theirs) in self.bins.iter_mut().zip(&other.bins) {
            *mine = mine.saturating_add(*theirs);
        }
    }

    /// Forgets everything.
    pub fn clear(&mut self) {
        *self = Histogram::new();
    }

    /// The bins that are not empty, as (first ns, last ns, count), in rising order; overflow apart.
    pub fn filled(&self) -> impl Iterator<Item = (u64, u64, u64)> + '_ {
        let first = |bin: usize| if bin == 0 { 0 } else { last_of(bin - 1) + 1 };
        self.bins[..BINS]
            .iter()
            .enumerate()
            .filter(|(_, n)| **n > 0)
            .map(move |(bin, n)| (first(bin), last_of(bin), *n))
    }
}

impl Default for Histogram {
    fn default() -> Self {
        Histogram::new()
    }
}

/// Bin of a duration; the last one is for everything too long.
#[inline]
fn bin_of(ns: u64) -> usize {
    let ns = ns.min(OVERFLOW_NS);
    let octave = 63 - (ns | (1 << SUB_BITS)).leading_zeros();
    let shift = octave - SUB_BITS;
    // 2³⁰ itself falls into the first bin after the last regular one: the overflow.
    ((shift << SUB_BITS) as usize) + (ns >> shift) as usize
}

/// Longest duration of a bin, ns.
fn last_of(bin: usize) -> u64 {
    let shift = (bin >> SUB_BITS).saturating_sub(1);
    let mantissa = (bin - (shift << SUB_BITS)) as u64;
    ((mantissa + 1) << shift) - 1
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn the_bins_are_without_gap_or_overlap_to_the_end_of_the_range() {
        let mut first = 0;
        for bin in 0..BINS {
            let last = last_of(bin);
            assert_eq!((bin_of(first), bin_of(last)), (bin, bin), "{first}..={last}");
            assert!((last - first) as f64 <= first as f64 / 32.0 + 1e-9 || first < 64, "{first}..={last}");
            first = last + 1;
        }
        assert_eq!(first, OVERFLOW_NS);
        assert_eq!(bin_of(OVERFLOW_NS), BINS);
        assert_eq!(bin_of(u64::MAX), BINS);
    }

    #[test]
    fn an_empty_histogram_answers_with_nothing() {
        let h = Histogram::new();
        assert_eq!((h.count(), h.max(), h.overflow(), h.quantile(0.5)), (0, 0, 0, 0));
        assert!(h.mean().is_nan());
    }

    #[test]
    fn overflow_is_counted_and_the_largest_kept() {
        let mut h = Histogram::new();
        h.record(5);
        h.record(OVERFLOW_NS - 1);
        h.record(OVERFLOW_NS);
        h.record(7_000_000_000);
        assert_eq!((h.count(), h.overflow(), h.max()), (4, 2, 7_000_000_000));
        assert_eq!(h.quantile(0.25), 5);
        assert_eq!(h.quantile(1.0), 7_000_000_000);
        assert_eq!(h.filled().map(|(_, _, n)| n).sum::<u64>(), 2);
    }

    proptest! {
        #[test]
        fn quantiles_are_those_of_the_sorted_values_within_a_bin(
            mut values in prop::collection::vec(0u64..2_000_000_000, 1..400), q in 0.0f64..=1.0
        ) {
            let mut h = Histogram::new();
            let mut halves = [Histogram::new(), Histogram::new()];
            for (i, &v) in values.iter().enumerate() {
                h.record(v);
                halves[i % 2].record(v);
            }
            let [mut merged, other] = halves;
            merged.merge(&other);
            prop_assert_eq!(h, merged);
            values.sort_unstable();
            let rank = ((q * values.len() as f64).ceil() as usize).clamp(1, values.len());
            let truth = values[rank - 1];
            let got = h.quantile(q);
            prop_assert!(got >= truth && (truth >= OVERFLOW_NS || got as f64 <= truth as f64 * (1.0 + 1.0 / 32.0)), "{} {}", got, truth);
            prop_assert_eq!(h.max(), *values.last().unwrap());
        }
    }
}
