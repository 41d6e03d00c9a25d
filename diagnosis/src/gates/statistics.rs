//! Robust figures of measured columns, whose samples may be missing.

/// The value below which a share of the finite values lies; NaN of none.
pub(super) fn quantile(values: impl IntoIterator<Item = f64>, share: f64) -> f64 {
    let mut values: Vec<f64> = values.into_iter().filter(|v| v.is_finite()).collect();
    if values.is_empty() {
        return f64::NAN;
    }
    let place = ((values.len() - 1) as f64 * share).round() as usize;
    *values.select_nth_unstable_by(place, f64::total_cmp).1
}

/// The middle one of the finite values; NaN of none.
pub(super) fn median(values: impl IntoIterator<Item = f64>) -> f64 {
    quantile(values, 0.5)
}

/// From the least of the finite values to the largest; 0 of none.
pub(super) fn span(values: &[f64]) -> f64 {
    let finite = || values.iter().copied().filter(|v| v.is_finite());
    (finite().fold(f64::NEG_INFINITY, f64::max) - finite().fold(f64::INFINITY, f64::min)).max(0.0)
}

/// How far a column moves, outliers apart: from its 1st to its 99th percentile.
pub(super) fn stroke(values: &[f64]) -> f64 {
    let finite = || values.iter().copied();
    let found = quantile(finite(), 0.99) - quantile(finite(), 0.01);
    if found.is_finite() { found } else { 0.0 }
}

/// A straight line through points. NaN where either coordinate stands still.
pub(super) struct Line {
    pub(super) slope: f64,
    /// Share of the variance it explains.
    pub(super) explained: f64,
}

/// The line through points by least squares.
pub(super) fn line(x: &[f64], y: &[f64]) -> Line {
    let both = || x.iter().zip(y).filter(|(x, y)| x.is_finite() && y.is_finite()).map(|(x, y)| (*x, *y));
    let count = both().count() as f64;
    let (sum_x, sum_y) = both().fold((0.0, 0.0), |(a, b), (x, y)| (a + x, b + y));
    let (mean_x, mean_y) = (sum_x / count, sum_y / count);
    let (mut xx, mut xy, mut yy) = (0.0, 0.0, 0.0);
    for (x, y) in both() {
        let (dx, dy) = (x - mean_x, y - mean_y);
        xx += dx * dx;
        xy += dx * dy;
        yy += dy * dy;
    }
    Line { slope: xy / xx, explained: xy * xy / (xx * yy) }
}
