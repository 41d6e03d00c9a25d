//! Balancing: units of the states that make the entries of A comparable (Osborne, 1960; Parlett and Reinsch, 1969).
//!
//! States of a wire differ by ten orders of magnitude (metres, pascals, kelvins); what is computed in balanced units
//! does not depend on the units that came in.

use nalgebra::{DMatrix, DVector};

/// More sweeps than any small matrix needs.
const MOST_SWEEPS: usize = 100;

/// Scales d, powers of 2, that make rows and columns of D⁻¹ A D equally large (1-norms without the diagonal).
pub(crate) fn scales(a: &DMatrix<f64>) -> DVector<f64> {
    let n = a.nrows();
    let mut d = DVector::from_element(n, 1.0);
    for _ in 0..MOST_SWEEPS {
        let mut changed = false;
        for i in 0..n {
            let others = || (0..n).filter(|&j| j != i);
            let row: f64 = others().map(|j| (a[(i, j)] * d[j] / d[i]).abs()).sum();
            let column: f64 = others().map(|j| (a[(j, i)] * d[i] / d[j]).abs()).sum();
            if row <= 0.0 || column <= 0.0 || !(row / column).is_finite() {
                continue;
            }
            let factor = (0.5 * (row / column).log2()).round().clamp(-1000.0, 1000.0).exp2();
            if row / factor + column * factor < 0.95 * (row + column) && (d[i] * factor).is_normal() {
                d[i] *= factor;
                changed = true;
            }
        }
        if !changed {
            break;
        }
    }
    d
}

/// D⁻¹ A D.
pub(crate) fn balanced(a: &DMatrix<f64>, d: &DVector<f64>) -> DMatrix<f64> {
    DMatrix::from_fn(a.nrows(), a.ncols(), |i, j| a[(i, j)] * d[j] / d[i])
}

/// D⁻¹ B.
pub(crate) fn rows_over(b: &DMatrix<f64>, d: &DVector<f64>) -> DMatrix<f64> {
    DMatrix::from_fn(b.nrows(), b.ncols(), |i, j| b[(i, j)] / d[i])
}

/// Scales of the states and of the inputs of ẋ = A x + B u: least squares of the logarithms of all entries that are not
/// 0 (Curtis and Reid, 1972). Unlike [`scales`] it needs no loops: what an input drives may drive nothing in turn.
/// The diagonal of A has no say: no unit changes it.
pub(crate) fn scales_of_pair(a: &DMatrix<f64>, b: &DMatrix<f64>) -> (DVector<f64>, DVector<f64>) {
    let (n, inputs) = b.shape();
    // log₂ of: states, inputs, the common rate
    let unknowns = n + inputs + 1;
    let mut normal = DMatrix::<f64>::zeros(unknowns, unknowns);
    let mut right = DVector::<f64>::zeros(unknowns);
    for i in 0..n {
        for j in 0..n + inputs {
            let entry = if j < n { a[(i, j)] } else { b[(i, j - n)] };
            if i == j || entry == 0.0 {
                continue;
            }
            // log|entry| + s_j − s_i = rate
            for (row, sign) in [(j, 1.0), (i, -1.0), (unknowns - 1, -1.0)] {
                for (column, other) in [(j, 1.0), (i, -1.0), (unknowns - 1, -1.0)] {
                    normal[(row, column)] += sign * other;
                }
                right[row] -= sign * entry.abs().log2();
            }
        }
    }
    // units that no entry ties down: the least solution
    let eigen = normal.symmetric_eigen();
    let weights = eigen.eigenvectors.transpose() * right;
    let inverse =
        DVector::from_fn(
            unknowns,
            |i, _| {
                if eigen.eigenvalues[i] > 1e-9 { weights[i] / eigen.eigenvalues[i] } else { 0.0 }
            },
        );
    let scales = (eigen.eigenvectors * inverse).map(|log| log.round().clamp(-500.0, 500.0).exp2());
    (scales.rows(0, n).into_owned(), scales.rows(n, inputs).into_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_and_columns_become_equal() {
        let a = DMatrix::from_row_slice(2, 2, &[1.0, 1e8, 1e-8, 2.0]);
        let b = balanced(&a, &scales(&a));
        assert!(b[(0, 1)] / b[(1, 0)] < 4.0 && b[(1, 0)] / b[(0, 1)] < 4.0, "{b}");
        assert_eq!((b[(0, 0)], b[(1, 1)]), (1.0, 2.0));
    }

    /// A chain from the input through two states in wild units.
    #[test]
    fn a_chain_becomes_even() {
        let a = DMatrix::from_row_slice(2, 2, &[0.0, 1e9, 0.0, -3.0]);
        let b = DMatrix::from_row_slice(2, 1, &[0.0, 1e-5]);
        let (d, u) = scales_of_pair(&a, &b);
        let ratio = balanced(&a, &d)[(0, 1)] / (rows_over(&b, &d)[1] * u[0]);
        assert!((0.2..5.0).contains(&ratio), "{ratio}");
    }
}
