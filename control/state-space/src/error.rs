//! Why a question about a linear system has no answer.

use nalgebra::DMatrix;
use std::fmt;

/// Why a question about a linear system has no answer.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Error {
    /// A matrix does not fit the others.
    Shape {
        /// Its name.
        matrix: &'static str,
        /// Rows and columns it should have.
        expected: (usize, usize),
        /// Rows and columns it has.
        found: (usize, usize),
    },
    /// A matrix or a number is infinite or not a number.
    NotFinite {
        /// Its name.
        what: &'static str,
    },
    /// A time step or a rate that should be positive is not.
    NotPositive {
        /// Its name.
        what: &'static str,
        /// Its value.
        found: f64,
    },
    /// A weight or covariance is not symmetric.
    NotSymmetric {
        /// Its name.
        matrix: &'static str,
    },
    /// A weight or covariance has a negative eigenvalue, or one of 0 where its inverse is needed.
    NotPositiveDefinite {
        /// Its name.
        matrix: &'static str,
    },
    /// As many poles are needed as there are states.
    PoleCount {
        /// States.
        expected: usize,
        /// Poles given.
        found: usize,
    },
    /// A complex pole came without its conjugate.
    PolesNotConjugate,
    /// Some modes are not reached by the input (for an observer: are not seen by the output).
    NotControllable,
    /// No gain makes the loop stable, or an eigenvalue of the optimal loop lies on the stability limit.
    NotStabilisable,
    /// A matrix has no real logarithm: it is singular or has a negative eigenvalue.
    NoLogarithm,
    /// An iteration did not come to its end.
    NoConvergence {
        /// Which.
        what: &'static str,
    },
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Error::Shape { matrix, expected, found } => {
                write!(f, "{matrix} is {}×{}, expected {}×{}", found.0, found.1, expected.0, expected.1)
            }
            Error::NotFinite { what } => write!(f, "{what} is infinite or not a number"),
            Error::NotPositive { what, found } => write!(f, "{what} is {found}, expected more than 0"),
            Error::NotSymmetric { matrix } => write!(f, "{matrix} is not symmetric"),
            Error::NotPositiveDefinite { matrix } => write!(f, "{matrix} is not positive definite"),
            Error::PoleCount { expected, found } => write!(f, "{found} poles for {expected} states"),
            Error::PolesNotConjugate => write!(f, "a complex pole came without its conjugate"),
            Error::NotControllable => write!(f, "some modes are out of reach of the input or unseen by the output"),
            Error::NotStabilisable => write!(f, "no gain makes the loop stable, or its optimum is on the limit"),
            Error::NoLogarithm => write!(f, "the matrix is singular or has a negative eigenvalue: no real logarithm"),
            Error::NoConvergence { what } => write!(f, "{what} did not converge"),
        }
    }
}

impl std::error::Error for Error {}

/// Whether a matrix has this shape and only finite numbers.
pub(crate) fn check(matrix: &'static str, m: &DMatrix<f64>, expected: (usize, usize)) -> Result<(), Error> {
    if m.shape() != expected {
        return Err(Error::Shape { matrix, expected, found: m.shape() });
    }
    if m.iter().any(|value| !value.is_finite()) {
        return Err(Error::NotFinite { what: matrix });
    }
    Ok(())
}

/// Whether A is square, B has as many rows, and both are finite.
pub(crate) fn check_pair(a: &DMatrix<f64>, b: &DMatrix<f64>) -> Result<(), Error> {
    check("a", a, (a.nrows(), a.nrows()))?;
    check("b", b, (a.nrows(), b.ncols()))
}

/// Whether a number is finite and positive.
pub(crate) fn check_positive(what: &'static str, found: f64) -> Result<(), Error> {
    if !found.is_finite() {
        return Err(Error::NotFinite { what });
    }
    if found <= 0.0 {
        return Err(Error::NotPositive { what, found });
    }
    Ok(())
}

/// Whether a weight is finite, n × n and symmetric.
pub(crate) fn check_symmetric(matrix: &'static str, m: &DMatrix<f64>, n: usize) -> Result<(), Error> {
    check(matrix, m, (n, n))?;
    let asymmetry = (m - m.transpose()).amax();
    if asymmetry > 1e-10 * m.amax() {
        return Err(Error::NotSymmetric { matrix });
    }
    Ok(())
}
