//! Derivatives by the complex step: f′(x) = Im f(x + iε)/ε (appendix A, "Linearization of Nonlinear State Equations";
//! Squire and Trapp, 1998). No difference is taken, so ε can be so small that the result is exact to rounding.
//!
//! The function has to be written for complex numbers (generic over [`nalgebra::ComplexField`] serves both) and
//! analytic at x: no absolute value, comparison or conjugate of what depends on x.

use nalgebra::{Complex, DMatrix, DVector};

/// The step: its square vanishes beside any number that matters.
const STEP: f64 = 1e-100;

/// f′(x).
pub fn derivative(f: impl Fn(Complex<f64>) -> Complex<f64>, x: f64) -> f64 {
    f(Complex::new(x, STEP)).im / STEP
}

/// The Jacobian ∂f_i/∂x_j at x: F of ẋ = f(x, u), G if x is the input, H of y = h(x).
pub fn jacobian(f: impl Fn(&DVector<Complex<f64>>) -> DVector<Complex<f64>>, x: &DVector<f64>) -> DMatrix<f64> {
    let mut point = x.map(|value| Complex::new(value, 0.0));
    let columns: Vec<DVector<f64>> = (0..x.len())
        .map(|j| {
            point[j].im = STEP;
            let column = f(&point).map(|value| value.im / STEP);
            point[j].im = 0.0;
            column
        })
        .collect();
    if columns.is_empty() {
        return DMatrix::zeros(f(&point).len(), 0);
    }
    DMatrix::from_columns(&columns)
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::ComplexField;
    use proptest::prelude::*;

    /// One text for both number types.
    fn logistic<T: ComplexField<RealField = f64>>(x: T) -> T {
        T::one() / (T::one() + (x * T::from_real(0.31)).exp())
    }

    proptest! {
        #[test]
        fn exact_where_differences_are_not(x in -60.0f64..60.0) {
            let (e, g) = ((0.31 * x).exp(), logistic(x));
            let exact = -0.31 * e * g * g;
            prop_assert!((derivative(logistic, x) - exact).abs() <= 1e-13 * exact.abs());
        }
    }

    #[test]
    fn a_jacobian() {
        let f = |x: &DVector<Complex<f64>>| {
            DVector::from_vec(vec![x[0] * x[1], x[1].sin(), x[0].exp() / x[1], Complex::new(4.0, 0.0)])
        };
        let (x, y) = (0.7f64, 1.3f64);
        let exact = DMatrix::from_row_slice(4, 2, &[y, x, 0.0, y.cos(), x.exp() / y, -x.exp() / (y * y), 0.0, 0.0]);
        assert!((jacobian(f, &DVector::from_vec(vec![x, y])) - exact).norm() < 1e-14);
        assert_eq!(jacobian(f, &DVector::from_vec(vec![x, y])).shape(), (4, 2));
    }
}
