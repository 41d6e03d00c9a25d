//! Levenberg's and Marquardt's way to the least sum of squares, by numerical derivatives: few parameters, cheap residuals.

use nalgebra::{DMatrix, DVector};

/// A number that is searched.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Unknown {
    pub start: f64,
    /// What is a small change of it.
    pub step: f64,
    pub low: f64,
    pub high: f64,
}

/// Where the sum of squares is least.
#[derive(Debug, Clone)]
pub(crate) struct Least {
    pub at: Vec<f64>,
    /// What is left there.
    pub left: DVector<f64>,
}

const MOST_STEPS: usize = 60;
/// A step that gains a smaller share of what is left is the last.
const NEGLIGIBLE: f64 = 1e-7;
const MOST_DAMPED: usize = 12;

/// The least sum of squares of `residuals`, which fail where there is no model.
///
/// # Errors
/// Where they fail at the start, or beside the way.
pub(crate) fn least<E>(
    unknowns: &[Unknown],
    residuals: impl Fn(&[f64]) -> Result<DVector<f64>, E>,
) -> Result<Least, E> {
    let mut at: Vec<f64> = unknowns.iter().map(|u| u.start.clamp(u.low, u.high)).collect();
    let mut left = residuals(&at)?;
    let slopes_at = |at: &[f64], left: &DVector<f64>| -> Result<DMatrix<f64>, E> {
        let mut slopes = DMatrix::zeros(left.len(), at.len());
        for (i, unknown) in unknowns.iter().enumerate() {
            let step = if at[i] + unknown.step <= unknown.high { unknown.step } else { -unknown.step };
            let mut moved = at.to_vec();
            moved[i] += step;
            slopes.set_column(i, &((residuals(&moved)? - left) / step));
        }
        Ok(slopes)
    };
    let mut slopes = slopes_at(&at, &left)?;
    let mut damping = 1e-3;
    for _ in 0..MOST_STEPS {
        let square = slopes.tr_mul(&slopes);
        let along = slopes.tr_mul(&left);
        let mut gained = 0.0;
        for _ in 0..MOST_DAMPED {
            let mut damped = square.clone();
            for i in 0..at.len() {
                damped[(i, i)] += damping * square[(i, i)] + f64::MIN_POSITIVE;
            }
            let step = damped.cholesky().map(|factor| factor.solve(&-&along));
            let moved: Option<Vec<f64>> = step.map(|step| {
                at.iter().zip(step.iter()).zip(unknowns).map(|((z, s), u)| (z + s).clamp(u.low, u.high)).collect()
            });
            if let Some(moved) = moved
                && let Ok(there) = residuals(&moved)
                && there.norm_squared() < left.norm_squared()
            {
                gained = 1.0 - there.norm_squared() / left.norm_squared();
                (at, left) = (moved, there);
                damping = (damping * 0.1).max(1e-12);
                break;
            }
            damping *= 10.0;
        }
        if gained == 0.0 {
            break;
        }
        slopes = slopes_at(&at, &left)?;
        if gained < NEGLIGIBLE {
            break;
        }
    }
    Ok(Least { at, left })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_decay_is_found_and_a_bound_is_kept() {
        let x: Vec<f64> = (0..50).map(|i| 0.1 * f64::from(i)).collect();
        let left = |p: &[f64]| -> Result<DVector<f64>, ()> {
            Ok(DVector::from_iterator(x.len(), x.iter().map(|x| p[0] * (-p[1] * x).exp() - 3.0 * (-0.7 * x).exp())))
        };
        let of = |start, high| Unknown { start, step: 1e-5, low: 0.0, high };
        let found = least(&[of(1.0, 9.0), of(0.1, 9.0)], left).unwrap();
        assert!((found.at[0] - 3.0).abs() < 1e-6 && (found.at[1] - 0.7).abs() < 1e-6, "{found:?}");
        assert_eq!(least(&[of(1.0, 9.0), of(0.1, 0.5)], left).unwrap().at[1], 0.5);
    }
}
