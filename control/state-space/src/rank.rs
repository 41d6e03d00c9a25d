//! Whether the input reaches every state and the output shows every state (appendix A, "Controllability" and
//! "Observability").
//!
//! The rank of [B AB … Aⁿ⁻¹B] is the definition, but a poor computation: its columns run into the direction of the
//! fastest mode. [`controllable`] asks mode by mode instead (Popov, Belevitch and Hautus): (A, B) is controllable
//! exactly if [λI − A, B] has full rank at every eigenvalue λ of A. All is done in units that make the entries
//! comparable and with rows of equal size, so that metres or millimetres do not decide.

use crate::balance;
use crate::error::{Error, check, check_pair};
use crate::spectrum::eigenvalues;
use nalgebra::{Complex, DMatrix, SVD};

/// A singular value below this share of the rows' size counts as 0: far above rounding (10⁻¹⁵, and its square root
/// where eigenvalues coincide), far below any coupling of use.
pub const TOLERANCE: f64 = 1e-7;

/// The controllability matrix [B AB … Aⁿ⁻¹B].
///
/// # Errors
/// Shapes that do not fit, numbers that are not finite.
pub fn controllability(a: &DMatrix<f64>, b: &DMatrix<f64>) -> Result<DMatrix<f64>, Error> {
    check_pair(a, b)?;
    let (n, inputs) = b.shape();
    let mut all = DMatrix::zeros(n, n * inputs);
    let mut block = b.clone();
    for k in 0..n {
        all.view_mut((0, k * inputs), (n, inputs)).copy_from(&block);
        block = a * block;
    }
    Ok(all)
}

/// The observability matrix [C; CA; …; CAⁿ⁻¹].
///
/// # Errors
/// Shapes that do not fit, numbers that are not finite.
pub fn observability(a: &DMatrix<f64>, c: &DMatrix<f64>) -> Result<DMatrix<f64>, Error> {
    check_dual(a, c)?;
    Ok(controllability(&a.transpose(), &c.transpose())?.transpose())
}

/// Rank of a matrix: singular values above `tolerance` times the largest.
///
/// # Errors
/// Numbers that are not finite.
pub fn rank(m: &DMatrix<f64>, tolerance: f64) -> Result<usize, Error> {
    check("m", m, m.shape())?;
    let values = singular_values(m.map(|value| Complex::new(value, 0.0)))?;
    let largest = values.iter().copied().fold(0.0, f64::max);
    Ok(values.iter().filter(|&&value| value > tolerance * largest).count())
}

/// Rank of the controllability matrix, in even units and with A scaled to the size of 1 (neither changes the rank):
/// how many independent directions the input reaches.
///
/// # Errors
/// Shapes that do not fit, numbers that are not finite.
pub fn controllability_rank(a: &DMatrix<f64>, b: &DMatrix<f64>) -> Result<usize, Error> {
    check_pair(a, b)?;
    let (a, b) = in_even_units(a, b);
    let scale = |m: DMatrix<f64>| if m.norm() > 0.0 { &m / m.norm() } else { m };
    rank(&controllability(&scale(a), &scale(b))?, TOLERANCE)
}

/// Rank of the observability matrix, the dual of [`controllability_rank`].
///
/// # Errors
/// Shapes that do not fit, numbers that are not finite.
pub fn observability_rank(a: &DMatrix<f64>, c: &DMatrix<f64>) -> Result<usize, Error> {
    check_dual(a, c)?;
    controllability_rank(&a.transpose(), &c.transpose())
}

/// Whether the inputs reach every state, by the test of Popov, Belevitch and Hautus with [`TOLERANCE`].
///
/// # Errors
/// Shapes that do not fit, numbers that are not finite, eigenvalues that do not converge.
pub fn controllable(a: &DMatrix<f64>, b: &DMatrix<f64>) -> Result<bool, Error> {
    Ok(uncontrollable_modes(a, b, TOLERANCE)?.is_empty())
}

/// Whether the outputs show every state, the dual of [`controllable`].
///
/// # Errors
/// Shapes that do not fit, numbers that are not finite, eigenvalues that do not converge.
pub fn observable(a: &DMatrix<f64>, c: &DMatrix<f64>) -> Result<bool, Error> {
    Ok(unobservable_modes(a, c, TOLERANCE)?.is_empty())
}

/// The eigenvalues at which [λI − A, B] loses rank: modes that no input moves. `tolerance` is the smallest singular
/// value that counts, with every row scaled to the size of 1.
///
/// # Errors
/// Shapes that do not fit, numbers that are not finite, eigenvalues that do not converge.
pub fn uncontrollable_modes(a: &DMatrix<f64>, b: &DMatrix<f64>, tolerance: f64) -> Result<Vec<Complex<f64>>, Error> {
    check_pair(a, b)?;
    let (a, b) = in_even_units(a, b);
    let (n, inputs) = b.shape();
    let mut lost = Vec::new();
    for mode in eigenvalues(&a)? {
        let pencil = DMatrix::from_fn(n, n + inputs, |i, j| {
            // rows are measured before the difference is taken, lest rounding of a row that vanishes be blown up
            let size = (0..n).map(|j| a[(i, j)].abs()).sum::<f64>() + b.row(i).lp_norm(1) + mode.norm();
            let entry = if j >= n {
                Complex::new(b[(i, j - n)], 0.0)
            } else if i == j {
                mode - a[(i, i)]
            } else {
                Complex::new(-a[(i, j)], 0.0)
            };
            if size > 0.0 { entry / size } else { entry }
        });
        let smallest = singular_values(pencil)?.into_iter().fold(f64::INFINITY, f64::min);
        if smallest <= tolerance {
            lost.push(mode);
        }
    }
    Ok(lost)
}

/// The eigenvalues at which [λI − A; C] loses rank: modes that no output shows; see [`uncontrollable_modes`].
///
/// # Errors
/// Shapes that do not fit, numbers that are not finite, eigenvalues that do not converge.
pub fn unobservable_modes(a: &DMatrix<f64>, c: &DMatrix<f64>, tolerance: f64) -> Result<Vec<Complex<f64>>, Error> {
    check_dual(a, c)?;
    uncontrollable_modes(&a.transpose(), &c.transpose(), tolerance)
}

/// The same system in units of states and inputs that make its entries comparable.
fn in_even_units(a: &DMatrix<f64>, b: &DMatrix<f64>) -> (DMatrix<f64>, DMatrix<f64>) {
    let (d, u) = balance::scales_of_pair(a, b);
    let b = balance::rows_over(b, &d);
    (balance::balanced(a, &d), DMatrix::from_fn(b.nrows(), b.ncols(), |i, j| b[(i, j)] * u[j]))
}

fn check_dual(a: &DMatrix<f64>, c: &DMatrix<f64>) -> Result<(), Error> {
    check("a", a, (a.nrows(), a.nrows()))?;
    check("c", c, (c.nrows(), a.nrows()))
}

/// Singular values, as many as the smaller side is long.
fn singular_values(m: DMatrix<Complex<f64>>) -> Result<Vec<f64>, Error> {
    if m.is_empty() {
        return Ok(Vec::new());
    }
    let svd = SVD::try_new(m, false, false, f64::EPSILON, 10_000);
    Ok(svd.ok_or(Error::NoConvergence { what: "the singular values" })?.singular_values.iter().copied().collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn matrix(n: usize, m: usize) -> impl Strategy<Value = DMatrix<f64>> {
        proptest::collection::vec(-1.0f64..1.0, n * m).prop_map(move |v| DMatrix::from_vec(n, m, v))
    }

    /// A system with a part that the input does not reach, hidden by a change of coordinates.
    fn with_hidden_part(a: &DMatrix<f64>, t: &DMatrix<f64>) -> Option<(DMatrix<f64>, DMatrix<f64>)> {
        let n = a.nrows();
        let mut plain = a.clone();
        for j in 0..n - 1 {
            plain[(n - 1, j)] = 0.0;
        }
        let mut b = DMatrix::from_element(n, 1, 1.0);
        b[n - 1] = 0.0;
        let inverse = t.clone().try_inverse()?;
        (inverse.norm() * t.norm() < 100.0).then(|| (t * plain * inverse, t * b))
    }

    proptest! {
        #[test]
        fn a_hidden_part_is_found(a in matrix(4, 4), t in matrix(4, 4)) {
            let found = with_hidden_part(&a, &t);
            prop_assume!(found.is_some());
            let (a, b) = found.unwrap();
            prop_assert!(!controllable(&a, &b).unwrap());
            prop_assert!(!observable(&a.transpose(), &b.transpose()).unwrap());
            prop_assert!(controllability_rank(&a, &b).unwrap() < 4);
        }

        /// Units of time, states and input do not change the answer.
        #[test]
        fn units_do_not_matter(e in proptest::collection::vec(-20i32..20, 3), time in -10i32..10, input in -20i32..20) {
            let a = DMatrix::from_row_slice(3, 3, &[0.0, 1.0, 0.0, -4.0, -0.3, 2.0, 0.0, 0.0, -0.7]);
            let b = DMatrix::from_row_slice(3, 1, &[0.0, 0.0, 1.0]);
            let d = |i: usize| f64::from(e[i]).exp2();
            let a = DMatrix::from_fn(3, 3, |i, j| a[(i, j)] * d(j) / d(i) * f64::from(time).exp2());
            let b = DMatrix::from_fn(3, 1, |i, _| b[i] / d(i) * f64::from(input).exp2());
            prop_assert!(controllable(&a, &b).unwrap());
            prop_assert_eq!(controllability_rank(&a, &b).unwrap(), 3);
        }
    }

    #[test]
    fn an_independent_mode_is_named() {
        let a = DMatrix::from_row_slice(2, 2, &[-1.0, 0.0, 0.0, -2.0]);
        let b = DMatrix::from_row_slice(2, 1, &[1.0, 0.0]);
        let lost = uncontrollable_modes(&a, &b, TOLERANCE).unwrap();
        assert_eq!(lost.len(), 1);
        assert!((lost[0].re + 2.0).abs() < 1e-12 && lost[0].im.abs() < 1e-12);
        assert_eq!(controllability_rank(&a, &b).unwrap(), 1);
        assert!(controllable(&a, &DMatrix::from_row_slice(2, 1, &[1.0, 1e-3])).unwrap());
    }

    #[test]
    fn the_matrices_are_as_defined() {
        let a = DMatrix::from_row_slice(2, 2, &[1.0, 2.0, 3.0, 4.0]);
        let b = DMatrix::from_row_slice(2, 1, &[5.0, 6.0]);
        assert_eq!(controllability(&a, &b).unwrap(), DMatrix::from_row_slice(2, 2, &[5.0, 17.0, 6.0, 39.0]));
        assert_eq!(observability(&a, &b.transpose()).unwrap(), DMatrix::from_row_slice(2, 2, &[5.0, 6.0, 23.0, 34.0]));
        assert!(matches!(observability(&a, &b), Err(Error::Shape { matrix: "c", .. })));
    }
}
