//! Decimates a curve while it is read: whatever its length, to a few thousand points that look the same.
//!
//! Samples are grouped in stretches. Of each the first and last are kept and the extremes in x and y, so
//! that no spike is lost and a loop keeps its width. When there are too many stretches, neighbours are merged: memory
//! does not grow with the recording.
//!
//! A sensor slower than the recording leaves missing samples between its own. Those do not break the curve; a stretch
//! without samples much longer than is usual for it does.

/// A sample and its number.
#[derive(Debug, Clone, Copy)]
struct Point {
    number: u64,
    x: f64,
    y: f64,
}

/// The samples of a stretch that are kept.
#[derive(Debug, Clone, Copy)]
struct Stretch {
    first: Point,
    last: Point,
    left: Point,
    right: Point,
    low: Point,
    high: Point,
    /// The curve is broken before its first.
    broken: bool,
}

impl Stretch {
    fn of(point: Point, broken: bool) -> Stretch {
        Stretch { first: point, last: point, left: point, right: point, low: point, high: point, broken }
    }

    fn take(&mut self, other: &Stretch) {
        self.last = other.last;
        let further = |mine: &mut Point, of: Point, is_further: fn(&Point, &Point) -> bool| {
            if is_further(&of, mine) {
                *mine = of;
            }
        };
        further(&mut self.left, other.left, |a, b| a.x < b.x);
        further(&mut self.right, other.right, |a, b| a.x > b.x);
        further(&mut self.low, other.low, |a, b| a.y < b.y);
        further(&mut self.high, other.high, |a, b| a.y > b.y);
    }
}

/// A curve that is being made thin.
#[derive(Debug)]
pub struct Thin {
    stretches: Vec<Stretch>,
    most: usize,
    /// Samples of a stretch, and those in the last one so far.
    each: u64,
    filled: u64,
    number: u64,
    broken: bool,
    /// Samples missing since the last one, and how many usually are.
    missing: f64,
    usual: f64,
}

/// How many samples are taken to be missing between two at first, and how many times what is usual makes a gap.
const USUAL: f64 = 12.0;
const GAP: f64 = 10.0;

impl Thin {
    /// Of at most `most` stretches, each of up to six points.
    pub fn new(most: usize) -> Thin {
        let most = most.max(8);
        Thin { stretches: Vec::new(), most, each: 1, filled: 0, number: 0, broken: true, missing: 0.0, usual: USUAL }
    }

    /// The next sample; what is not a number is missing.
    pub fn push(&mut self, x: f64, y: f64) {
        if !(x.is_finite() && y.is_finite()) {
            self.missing += 1.0;
            return;
        }
        // a gap narrower than a stretch is narrower than can be drawn
        let wide = self.each <= 64 || self.missing >= self.each as f64;
        if self.missing > 0.0 {
            self.broken |= self.missing > GAP * self.usual;
            // one long gap does not make long gaps usual
            self.usual += (self.missing.min(2.0 * GAP * self.usual) - self.usual) / 8.0;
            self.missing = 0.0;
        }
        let point = Point { number: self.number, x, y };
        self.number += 1;
        let new = Stretch::of(point, self.broken);
        match self.stretches.last_mut() {
            Some(last) if self.filled < self.each && !(self.broken && wide) => {
                last.take(&new);
                self.filled += 1;
            }
            _ => {
                if self.stretches.len() == self.most {
                    self.join();
                }
                self.stretches.push(new);
                self.filled = 1;
            }
        }
        self.broken = false;
    }

    /// Breaks the curve before the next sample.
    pub fn gap(&mut self) {
        self.broken = true;
    }

    /// Joins every two neighbours, but not across a gap: unless there are so many that nothing would be gained.
    fn join(&mut self) {
        let gaps = self.stretches.iter().filter(|stretch| stretch.broken).count();
        let keep = gaps <= self.most / 4;
        let mut joined: Vec<Stretch> = Vec::with_capacity(self.most);
        let mut open = false;
        for stretch in &self.stretches {
            match joined.last_mut() {
                Some(last) if open && !(keep && stretch.broken) => {
                    last.take(stretch);
                    open = false;
                }
                _ => {
                    joined.push(*stretch);
                    open = true;
                }
            }
        }
        self.stretches = joined;
        self.each *= 2;
    }

    /// Nothing has come.
    pub fn is_empty(&self) -> bool {
        self.stretches.is_empty()
    }

    /// The curve: `(x, y)` in order, NaN where it is broken.
    pub fn points(&self) -> (Vec<f64>, Vec<f64>) {
        let (mut xs, mut ys) = (Vec::new(), Vec::new());
        for stretch in &self.stretches {
            if stretch.broken && !xs.is_empty() {
                xs.push(f64::NAN);
                ys.push(f64::NAN);
            }
            let mut kept = [stretch.first, stretch.left, stretch.right, stretch.low, stretch.high, stretch.last];
            kept.sort_by_key(|point| point.number);
            let mut before = None;
            for point in kept {
                if before != Some(point.number) {
                    xs.push(point.x);
                    ys.push(point.y);
                    before = Some(point.number);
                }
            }
        }
        (xs, ys)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spikes_ends_and_gaps_survive_any_length() {
        let mut thin = Thin::new(500);
        for i in 0..1_000_000u32 {
            let y = if i == 654_321 { 1e3 } else { f64::from(i % 7) };
            if (400_000..410_000).contains(&i) {
                thin.push(f64::from(i), f64::NAN);
                continue;
            }
            thin.push(f64::from(i), y);
        }
        let (x, y) = thin.points();
        assert!(x.len() <= 6 * 500 && x.len() == y.len(), "{}", x.len());
        assert!(y.contains(&1e3) && y.iter().any(|y| y.is_nan()));
        assert_eq!((x[0], *x.last().unwrap()), (0.0, 999_999.0));
        let numbers: Vec<f64> = x.iter().copied().filter(|x| !x.is_nan()).collect();
        assert!(numbers.is_sorted_by(|a, b| a < b));
        assert_eq!(y.iter().copied().filter(|y| !y.is_nan()).fold(f64::NEG_INFINITY, f64::max), 1e3);
    }

    #[test]
    fn a_short_curve_is_kept_whole() {
        let mut thin = Thin::new(100);
        thin.push(f64::NAN, 1.0);
        for i in 0..50 {
            thin.push(f64::from(i % 10), f64::from(i));
        }
        thin.gap();
        thin.push(3.0, 4.0);
        let (x, y) = thin.points();
        assert_eq!(x.len(), 52);
        assert!(x[50].is_nan() && (x[51], y[51]) == (3.0, 4.0));
        assert!(Thin::new(0).is_empty() && Thin::new(0).points().0.is_empty());
    }

    #[test]
    fn a_slow_sensor_is_no_row_of_gaps() {
        let mut thin = Thin::new(1000);
        for i in 0..100_000u32 {
            let silent = (50_000..60_000).contains(&i);
            thin.push(f64::from(i), if i % 400 == 0 && !silent { 1.0 } else { f64::NAN });
        }
        let (x, _) = thin.points();
        let gaps: Vec<usize> = (0..x.len()).filter(|i| x[*i].is_nan()).collect();
        assert!(gaps.len() <= 3, "at most two until it is known how slow it is, and where it was silent: {gaps:?}");
        assert!(gaps.iter().any(|i| x[i - 1] < 50_000.0 && x[i + 1] >= 60_000.0), "{gaps:?}");
    }

    #[test]
    fn a_loop_keeps_its_extent_both_ways() {
        let mut thin = Thin::new(64);
        for i in 0..100_000 {
            let angle = f64::from(i) * 1e-3;
            thin.push(angle.cos(), angle.sin());
        }
        let (x, y) = thin.points();
        for of in [&x, &y] {
            assert!(of.iter().copied().fold(f64::INFINITY, f64::min) < -0.9999);
            assert!(of.iter().copied().fold(f64::NEG_INFINITY, f64::max) > 0.9999);
        }
    }
}
