//! Curves that are read: their scales, the side of a loop that a reading is on, and polynomials fitted to them.

use super::simulated::least_squares;
use sinew_state_space::{DMatrix, DVector};

/// A reading has turned when it has come back by that share of its range.
const TURNED: f64 = 0.05;

/// On which side of its loop a reading is, in half ranges.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Side {
    pub falling: bool,
    /// The farthest since it last turned, in half ranges.
    farthest: f64,
}

impl Side {
    /// Of a wire that is cold and heated next.
    pub const COLD: Side = Side { falling: true, farthest: 1.0 };

    #[inline]
    pub fn follow(&mut self, reading: f64) {
        let ahead = if self.falling { self.farthest - reading } else { reading - self.farthest };
        if ahead >= 0.0 {
            self.farthest = reading;
        } else if ahead < -TURNED {
            *self = Side { falling: !self.falling, farthest: reading };
        }
    }

    #[inline]
    pub fn sign(&self) -> f64 {
        if self.falling { 1.0 } else { -1.0 }
    }
}

/// The middle and half the range of what a gauge takes or gives.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Scale {
    pub middle: f64,
    pub half: f64,
}

impl Scale {
    /// `None` of what does not vary.
    pub fn of(values: impl Iterator<Item = f64> + Clone) -> Option<Scale> {
        let (least, most) = (values.clone().fold(f64::INFINITY, f64::min), values.fold(f64::NEG_INFINITY, f64::max));
        let half = 0.5 * (most - least);
        (half > 1e-9).then_some(Scale { middle: 0.5 * (most + least), half })
    }

    #[inline]
    pub fn down(&self, value: f64) -> f64 {
        (value - self.middle) / self.half
    }

    #[inline]
    pub fn up(&self, share: f64) -> f64 {
        self.middle + self.half * share
    }
}

/// A polynomial of `N` terms, the constant first.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Polynomial<const N: usize>([f64; N]);

impl<const N: usize> Polynomial<N> {
    /// That of least squares through points; `None` where there is none.
    pub fn fitted(points: impl Iterator<Item = (f64, f64)>) -> Option<Polynomial<N>> {
        let points: Vec<(f64, f64)> = points.collect();
        let rows = DMatrix::from_fn(points.len(), N, |i, j| points[i].0.powi(j as i32));
        let wanted = DVector::from_fn(points.len(), |i, _| points[i].1);
        let found = least_squares(rows, &wanted)?;
        found.iter().all(|term| term.is_finite()).then(|| Polynomial(std::array::from_fn(|k| found[k])))
    }

    #[inline]
    pub fn at(&self, x: f64) -> f64 {
        self.0.iter().rev().fold(0.0, |sum, term| sum * x + term)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A reading has turned when it has come back by more than its noise.
    #[test]
    fn a_side_is_left_behind_the_noise() {
        let mut side = Side::COLD;
        for reading in [0.9, 0.5, 0.53, 0.5, 0.2, 0.24] {
            side.follow(reading);
            assert!(side.falling);
        }
        side.follow(0.26);
        assert_eq!(side, Side { falling: false, farthest: 0.26 });
        side.follow(0.22);
        assert!(!side.falling);
        side.follow(0.2);
        assert!(side.falling);
    }

    /// Points of a polynomial give it back; too few points, or none that are numbers, give none.
    #[test]
    fn a_polynomial_is_found_again() {
        let points = || (0..40).map(|k| 0.1 * f64::from(k) - 2.0).map(|x| (x, 0.3 - x + 0.25 * x * x * x));
        let found = Polynomial::<4>::fitted(points()).unwrap();
        assert!(points().all(|(x, y)| (found.at(x) - y).abs() < 1e-12), "{found:?}");
        assert_eq!(Polynomial::<4>::fitted(points().map(|(x, _)| (x, f64::NAN))), None);
    }
}
