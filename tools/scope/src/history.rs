//! The recent history of every quantity of every channel, decimated to a screen's resolution: a ring of bins.
//!
//! Up to 1 kHz a bin is a row, and every sample is shown. A faster source's bins are 1 ms with the least and the largest
//! value of each, so that no spike is lost and a page's work does not grow with the rate.

use std::ops::Range;

/// Most bins a second.
pub const FINEST_HZ: f64 = 1000.0;
/// Bytes all bins together may take.
const BUDGET_BYTES: usize = 80 << 20;

/// What distinguishes one source's bins from another's.
#[derive(Debug, Clone, PartialEq)]
pub struct Shape {
    /// Number of channels.
    pub channels: usize,
    /// Number of quantities of a channel.
    pub quantities: usize,
    /// Rows a second, Hz.
    pub rate_hz: f64,
    /// For how long at most the bins reach back, s.
    pub longest_s: f64,
}

impl Shape {
    /// Values of a bin for one series: itself, or the least and the largest.
    pub fn values(&self) -> usize {
        if self.rate_hz > 1.01 * FINEST_HZ { 2 } else { 1 }
    }

    /// Values of all series of a bin.
    fn stride(&self) -> usize {
        self.channels * self.quantities * self.values()
    }

    /// Bins that are kept.
    pub fn capacity(&self) -> usize {
        let bytes = self.stride().max(1) * size_of::<f32>() + size_of::<f64>();
        let longest = self.longest_s * self.rate_hz.clamp(1.0, FINEST_HZ);
        (BUDGET_BYTES / bytes).min(longest as usize).max(64)
    }

    /// How far back that is, s.
    pub fn span_s(&self) -> f64 {
        self.capacity() as f64 / self.rate_hz.clamp(1.0, FINEST_HZ)
    }
}

/// One channel's quantity.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Series {
    /// Number of the channel.
    pub channel: usize,
    /// Number of the quantity.
    pub quantity: usize,
}

/// The ring.
#[derive(Debug)]
pub struct History {
    shape: Shape,
    /// Time of each bin, s.
    time: Vec<f64>,
    /// Bin after bin: `[series][value]`.
    values: Vec<f32>,
    /// Number of the next bin, counted from 0.
    next: u64,
    /// The bin that is being filled, and when it ends, s.
    open: Vec<f32>,
    open_until: f64,
    open_at: f64,
    empty: bool,
}

impl History {
    /// Without any bins yet.
    pub fn new(shape: Shape) -> History {
        let (capacity, stride) = (shape.capacity(), shape.stride());
        History {
            time: vec![0.0; capacity],
            values: vec![f32::NAN; capacity * stride],
            next: 0,
            open: vec![f32::NAN; stride],
            open_until: f64::NEG_INFINITY,
            open_at: 0.0,
            empty: true,
            shape,
        }
    }

    /// What it was made for.
    pub fn shape(&self) -> &Shape {
        &self.shape
    }

    /// Number of the bin that comes next.
    pub fn next(&self) -> u64 {
        self.next
    }

    /// Number of the oldest bin that is still there.
    pub fn first(&self) -> u64 {
        self.next.saturating_sub(self.time.len() as u64)
    }

    /// Takes a row in: channel by channel all its quantities, NaN for what is not known. What is missing at the end is not
    /// known either; what is beyond the shape is not looked at.
    pub fn push(&mut self, time_s: f64, values: impl IntoIterator<Item = f32>) {
        if self.shape.values() == 1 {
            self.open.fill(f32::NAN);
            for (of, value) in self.open.iter_mut().zip(values) {
                *of = value;
            }
            self.keep(time_s);
            return;
        }
        if time_s >= self.open_until {
            self.close();
            self.open_at = time_s;
            // on a grid, so that bins are of one width however the rows fall
            self.open_until = ((time_s * FINEST_HZ).floor() + 1.0) / FINEST_HZ;
        }
        self.empty = false;
        for (pair, value) in self.open.as_chunks_mut::<2>().0.iter_mut().zip(values) {
            // f32::min and max pass over what is not a number
            pair[0] = pair[0].min(value);
            pair[1] = pair[1].max(value);
        }
    }

    /// Marks that something is missing before what comes next: nothing is drawn across it.
    pub fn gap(&mut self, time_s: f64) {
        self.close();
        self.open.fill(f32::NAN);
        self.keep(time_s);
    }

    /// Files the bin that is being filled.
    fn close(&mut self) {
        if !self.empty {
            self.keep(self.open_at);
            self.open.fill(f32::NAN);
            self.empty = true;
        }
    }

    fn keep(&mut self, time_s: f64) {
        let (at, stride) = ((self.next % self.time.len() as u64) as usize, self.open.len());
        self.time[at] = time_s;
        self.values[at * stride..][..stride].copy_from_slice(&self.open);
        self.next += 1;
    }

    /// The bins from `from` on, of these series, as a page takes them: all times (f64), then for each series all its
    /// values (f32), the least of every bin before the largest; little endian. As many as fit into `room` bytes, and at
    /// least one where there is one; returns the numbers of those.
    pub fn write(&self, from: u64, series: &[Series], room: usize, out: &mut Vec<u8>) -> Range<u64> {
        let start = from.max(self.first()).min(self.next);
        let bin = size_of::<f64>() + series.len() * self.shape.values() * size_of::<f32>();
        let bins = start..self.next.min(start + (room / bin).max(1) as u64);
        let ring = self.time.len() as u64;
        let (each, stride) = (self.shape.values(), self.open.len());
        out.reserve((bins.end - bins.start) as usize * bin);
        for bin in bins.clone() {
            out.extend_from_slice(&self.time[(bin % ring) as usize].to_le_bytes());
        }
        for series in series {
            for value in 0..each {
                let place = (series.channel * self.shape.quantities + series.quantity) * each + value;
                for bin in bins.clone() {
                    let at = (bin % ring) as usize * stride + place;
                    out.extend_from_slice(&self.values.get(at).copied().unwrap_or(f32::NAN).to_le_bytes());
                }
            }
        }
        bins
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LENGTH: Series = Series { channel: 1, quantity: 0 };

    fn shape(channels: usize, rate_hz: f64) -> Shape {
        Shape { channels, quantities: 3, rate_hz, longest_s: 60.0 }
    }

    /// Two channels of three quantities, of which one is known.
    fn row(length: f64) -> [f32; 4] {
        [f32::NAN, f32::NAN, f32::NAN, length as f32]
    }

    fn read(history: &History, from: u64) -> (Vec<f64>, Vec<f32>) {
        let mut bytes = Vec::new();
        let bins = history.write(from, &[LENGTH], usize::MAX, &mut bytes);
        let (times, values) = bytes.split_at(8 * (bins.end - bins.start) as usize);
        let f64s = times.as_chunks().0.iter().map(|b| f64::from_le_bytes(*b)).collect();
        (f64s, values.as_chunks().0.iter().map(|b| f32::from_le_bytes(*b)).collect())
    }

    #[test]
    fn a_slow_source_keeps_every_row_and_forgets_the_oldest() {
        let mut history = History::new(shape(2, 1000.0));
        let capacity = history.shape().capacity() as u64;
        assert_eq!(capacity, 60_000);
        for i in 0..capacity + 10 {
            history.push(i as f64 * 1e-3, row(i as f64));
        }
        assert_eq!((history.first(), history.next()), (10, capacity + 10));
        assert_eq!(read(&history, capacity + 7).1, [7.0, 8.0, 9.0].map(|i| capacity as f32 + i));
        assert_eq!(read(&history, 0).0.len(), capacity as usize, "what has gone is not sent");
        assert_eq!(read(&history, 0).0[0], 0.010);
        assert_eq!(read(&history, u64::MAX).0.len(), 0);
    }

    #[test]
    fn a_long_history_is_written_in_pieces() {
        let mut history = History::new(shape(2, 1000.0));
        for i in 0..1000 {
            history.push(f64::from(i), row(f64::from(i)));
        }
        let (mut next, mut pieces) = (0, Vec::new());
        while next < history.next() {
            let mut bytes = Vec::new();
            let bins = history.write(next, &[LENGTH], 5000, &mut bytes);
            assert!(bins.start == next && bytes.len() <= 5000, "{bins:?}, {} bytes", bytes.len());
            pieces.push(bins.end - bins.start);
            next = bins.end;
        }
        assert_eq!(pieces, [416, 416, 168], "of 12 bytes a bin");
        assert_eq!(history.write(7, &[LENGTH], 0, &mut Vec::new()), 7..8, "too long, and sent");
        assert_eq!(history.write(u64::MAX, &[LENGTH], 5000, &mut Vec::new()), 1000..1000);
    }

    #[test]
    fn a_fast_source_keeps_the_least_and_the_largest_of_each_millisecond() {
        let mut history = History::new(shape(2, 5000.0));
        for i in 0..20 {
            let spike = if i == 7 { 100.0 } else { f64::from(i) };
            history.push(1.0 + 1e-9 + f64::from(i) * 2e-4, row(spike));
        }
        history.gap(1.1);
        let (times, values) = read(&history, 0);
        assert_eq!(times.len(), 5);
        assert_eq!(values[..4], [0.0, 5.0, 10.0, 15.0]);
        assert_eq!(values[5..9], [4.0, 100.0, 14.0, 19.0]);
        assert!(values[4].is_nan() && values[9].is_nan(), "the gap");
        assert_eq!(times[4], 1.1);
    }

    #[test]
    fn the_largest_rig_keeps_within_the_budget() {
        let largest = Shape { quantities: 30, ..shape(64, 5000.0) };
        assert!(largest.capacity() * largest.stride() * 4 <= BUDGET_BYTES);
        assert!(largest.span_s() > 4.0, "{}", largest.span_s());
        let odd = shape(0, 0.0);
        History::new(odd).push(0.0, []);
    }
}
