//! Eigenvalues.

use crate::balance;
use crate::error::{Error, check};
use nalgebra::{Complex, DMatrix, Schur};

/// QR sweeps a Schur decomposition may take.
const MOST_SWEEPS: usize = 10_000;

/// Eigenvalues of a square matrix, in no particular order: the poles of ẋ = A x.
///
/// # Errors
/// A matrix that is not square or not finite; no convergence.
pub fn eigenvalues(a: &DMatrix<f64>) -> Result<Vec<Complex<f64>>, Error> {
    check("a", a, (a.nrows(), a.nrows()))?;
    if a.is_empty() {
        return Ok(Vec::new());
    }
    let balanced = balance::balanced(a, &balance::scales(a));
    let scale = balanced.amax();
    if scale == 0.0 {
        return Ok(vec![Complex::new(0.0, 0.0); a.nrows()]);
    }
    let schur = Schur::try_new(balanced / scale, f64::EPSILON, MOST_SWEEPS)
        .ok_or(Error::NoConvergence { what: "the schur decomposition" })?;
    Ok(schur.complex_eigenvalues().iter().map(|value| value * scale).collect())
}

/// The largest real part: below 0 a continuous-time system is stable.
pub(crate) fn abscissa(a: &DMatrix<f64>) -> Result<f64, Error> {
    Ok(eigenvalues(a)?.iter().map(|value| value.re).fold(f64::NEG_INFINITY, f64::max))
}

/// The largest magnitude: below 1 a discrete-time system is stable.
pub(crate) fn radius(a: &DMatrix<f64>) -> Result<f64, Error> {
    Ok(eigenvalues(a)?.iter().map(|value| value.norm()).fold(0.0, f64::max))
}
