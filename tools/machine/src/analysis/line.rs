//! Straight lines through points.

use super::finding::Estimate;

/// y = offset + slope x, with the standard error of both at the points' middle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Line {
    pub(super) slope: Estimate,
    /// y at `middle`.
    pub(super) height: Estimate,
    pub(super) middle: f64,
}

impl Line {
    /// Least squares; `None` for fewer than four points or points on one spot.
    pub(super) fn through(points: &[(f64, f64)]) -> Option<Line> {
        let n = points.len() as f64;
        if points.len() < 4 {
            return None;
        }
        let middle = points.iter().map(|p| p.0).sum::<f64>() / n;
        let height = points.iter().map(|p| p.1).sum::<f64>() / n;
        let sxx = points.iter().map(|p| (p.0 - middle).powi(2)).sum::<f64>();
        let sxy = points.iter().map(|p| (p.0 - middle) * (p.1 - height)).sum::<f64>();
        if sxx.is_nan() || sxx <= 0.0 {
            return None;
        }
        let slope = sxy / sxx;
        let left: f64 = points.iter().map(|p| (p.1 - height - slope * (p.0 - middle)).powi(2)).sum();
        let variance = left / (n - 2.0);
        Some(Line {
            slope: Estimate { value: slope, sigma: (variance / sxx).sqrt() },
            height: Estimate { value: height, sigma: (variance / n).sqrt() },
            middle,
        })
    }

    pub(super) fn at(&self, x: f64) -> f64 {
        self.height.value + self.slope.value * (x - self.middle)
    }

    /// Where two lines meet: y, and its uncertainty from those of the heights and slopes.
    pub(super) fn meets(&self, other: &Line) -> Option<Estimate> {
        let by = self.slope.value - other.slope.value;
        let x = self.middle + (other.at(self.middle) - self.height.value) / by;
        if !x.is_finite() {
            return None;
        }
        let value = self.at(x);
        // each line's own error at x, carried to the crossing by the other's slope
        let error = |line: &Line| line.height.sigma.hypot(line.slope.sigma * (x - line.middle));
        let sigma = (error(self) * other.slope.value / by).hypot(error(other) * self.slope.value / by);
        Some(Estimate { value, sigma })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_meet_where_they_do() {
        let line = |offset: f64, slope: f64| {
            let points: Vec<(f64, f64)> = (0..20).map(|i| (f64::from(i), offset + slope * f64::from(i))).collect();
            Line::through(&points).unwrap()
        };
        let met = line(1.0, 2.0).meets(&line(4.0, -1.0)).unwrap();
        assert!((met.value - 3.0).abs() < 1e-12 && met.sigma < 1e-9, "{met:?}");
        assert_eq!(line(0.0, 1.0).meets(&line(1.0, 1.0)), None);
        assert_eq!(Line::through(&[(0.0, 0.0); 9]), None);
    }
}
