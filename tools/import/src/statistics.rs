//! Figures of columns of numbers with missing samples.

/// Samples that are there, in order.
fn sorted(values: &[f64]) -> Vec<f64> {
    let mut there: Vec<f64> = values.iter().copied().filter(|v| v.is_finite()).collect();
    there.sort_by(f64::total_cmp);
    there
}

/// Quantiles of the samples that are there; NaN where there is none.
pub(crate) fn quantiles<const N: usize>(values: &[f64], shares: [f64; N]) -> [f64; N] {
    let sorted = sorted(values);
    shares.map(|share| match sorted.len() {
        0 => f64::NAN,
        n => sorted[((n - 1) as f64 * share).round() as usize],
    })
}

/// Least and largest sample; NaN where there is none.
pub(crate) fn range(values: &[f64]) -> (f64, f64) {
    let there = || values.iter().copied().filter(|v| v.is_finite());
    let (low, high) = (there().fold(f64::INFINITY, f64::min), there().fold(f64::NEG_INFINITY, f64::max));
    if low > high { (f64::NAN, f64::NAN) } else { (low, high) }
}

/// How two columns go together (Pearson's r); 0 where one of them does not move.
pub(crate) fn correlation(a: &[f64], b: &[f64]) -> f64 {
    let both = || a.iter().zip(b).filter(|(a, b)| a.is_finite() && b.is_finite());
    let count = both().count() as f64;
    if count < 3.0 {
        return 0.0;
    }
    let (mean_a, mean_b) = (both().map(|(a, _)| a).sum::<f64>() / count, both().map(|(_, b)| b).sum::<f64>() / count);
    let (mut aa, mut ab, mut bb) = (0.0, 0.0, 0.0);
    for (a, b) in both() {
        aa += (a - mean_a).powi(2);
        bb += (b - mean_b).powi(2);
        ab += (a - mean_a) * (b - mean_b);
    }
    if aa * bb > 0.0 { ab / (aa * bb).sqrt() } else { 0.0 }
}

/// A column behind a delay of the first order with this time constant.
pub(crate) fn delayed(time_s: &[f64], values: &[f64], constant_s: f64) -> Vec<f64> {
    let mut state = values.first().copied().filter(|v| v.is_finite()).unwrap_or(0.0);
    let mut out = Vec::with_capacity(values.len());
    for (row, value) in values.iter().enumerate() {
        let step = if row == 0 { 0.0 } else { time_s[row] - time_s[row - 1] };
        if step > 0.0 && value.is_finite() {
            state += (value - state) * (1.0 - (-step / constant_s).exp());
        }
        out.push(state);
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn figures_pass_over_what_is_missing() {
        let values = [f64::NAN, 3.0, 1.0, 2.0];
        assert_eq!(range(&values), (1.0, 3.0));
        assert_eq!(quantiles(&values, [0.0, 0.5, 1.0]), [1.0, 2.0, 3.0]);
        assert!((correlation(&values, &[9.0, -3.0, -1.0, -2.0]) + 1.0).abs() < 1e-12);
        assert_eq!(correlation(&[1.0; 4], &[1.0, 2.0, 3.0, 4.0]), 0.0);
        let late = delayed(&[0.0, 1.0, 2.0], &[0.0, 1.0, 1.0], 1.0);
        assert!((late[2] - (1.0 - (-2.0f64).exp())).abs() < 1e-12);
        assert!(range(&[f64::NAN]).0.is_nan());
    }
}
