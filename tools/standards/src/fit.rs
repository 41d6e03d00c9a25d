//! Straight lines and local polynomials by least squares.

use nalgebra::{DMatrix, DVector};

/// y = at + slope (x − about).
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Line {
    pub about: f64,
    pub at: f64,
    pub slope: f64,
}

impl Line {
    /// Through points; none where there are fewer than two places.
    pub(crate) fn through(points: impl Iterator<Item = (f64, f64)> + Clone) -> Option<Line> {
        let count = points.clone().count() as f64;
        let about = points.clone().map(|(x, _)| x).sum::<f64>() / count;
        let at = points.clone().map(|(_, y)| y).sum::<f64>() / count;
        let (xx, xy) = points.fold((0.0, 0.0), |(xx, xy), (x, y)| {
            let dx = x - about;
            (xx + dx * dx, xy + dx * (y - at))
        });
        (count >= 2.0 && xx > 0.0).then(|| Line { about, at, slope: xy / xx })
    }

    pub(crate) fn y(&self, x: f64) -> f64 {
        self.at + self.slope * (x - self.about)
    }

    /// Where it meets another; none where they are parallel.
    pub(crate) fn meets(&self, other: &Line) -> Option<f64> {
        let x = self.about + (other.y(self.about) - self.at) / (self.slope - other.slope);
        x.is_finite().then_some(x)
    }
}

/// The tangent at `x` of a cubic through the points within `half` of it, by least squares: an inflection in there does not make it flatter, as
/// it does a straight line. Where fewer are so near it is the nearest ones. `points` are in order of x. None where there are too few at all.
pub(crate) fn tangent(points: &[(f64, f64)], x: f64, half: f64) -> Option<Line> {
    const TERMS: usize = 4;
    const LEAST: usize = TERMS + 3;
    let mut from = points.partition_point(|(at, _)| *at < x - half);
    let mut to = points.partition_point(|(at, _)| *at <= x + half);
    while to - from < LEAST {
        let below = from.checked_sub(1).map(|i| x - points[i].0);
        match (below, points.get(to).map(|(at, _)| at - x)) {
            (Some(below), Some(above)) if above < below => to += 1,
            (Some(_), _) => from -= 1,
            (None, Some(_)) => to += 1,
            (None, None) => return None,
        }
    }
    let near = &points[from..to];
    let half = near.iter().map(|(at, _)| (at - x).abs()).fold(0.0, f64::max);
    let powers = DMatrix::from_fn(near.len(), TERMS, |row, power| ((near[row].0 - x) / half).powi(power as i32));
    let values = DVector::from_iterator(near.len(), near.iter().map(|(_, y)| *y));
    let found = powers.svd(true, true).solve(&values, 1e-12).ok()?;
    Some(Line { about: x, at: found[0], slope: found[1] / half })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_tangent_of_a_cubic_is_its_own() {
        let cubic = |x: f64| 1.0 + 2.0 * x - 0.5 * x * x + 0.25 * x * x * x;
        let points: Vec<(f64, f64)> = (0..200).map(|i| 0.02 * f64::from(i)).map(|x| (x, cubic(x))).collect();
        let line = tangent(&points, 1.3, 0.4).expect("points enough");
        assert!((line.y(1.3) - cubic(1.3)).abs() < 1e-9 && (line.slope - (2.0 - 1.3 + 0.75 * 1.69)).abs() < 1e-9);
        let nearest = tangent(&points, 1.3, 0.0).expect("the nearest ones");
        assert!((nearest.y(1.3) - cubic(1.3)).abs() < 1e-9);
        assert!(tangent(&points[..6], 1.3, 9.0).is_none());
    }

    #[test]
    fn lines_meet_where_they_do() {
        let line = |at: f64, slope: f64| {
            Line::through([0.0, 1.0, 3.0].map(|x| (x, at + slope * x)).into_iter()).expect("three places")
        };
        let meets = line(1.0, 2.0).meets(&line(4.0, -1.0)).expect("not parallel");
        assert!((meets - 1.0).abs() < 1e-12);
        assert_eq!(line(1.0, 2.0).meets(&line(2.0, 2.0)), None);
    }
}
