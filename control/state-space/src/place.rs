//! Gains that put the poles where they are wanted (appendix A, "State-Feedback Controller" and "State Estimator").

use crate::balance;
use crate::error::{Error, check, check_pair};
use nalgebra::{Complex, DMatrix, RowDVector};

/// An entry below the diagonal that is smaller than this share of the matrix ends the chain from the input.
const BROKEN_CHAIN: f64 = 1e-13;

/// The row K with which A − B K has the given poles; for one input (B with one column) it is unique.
///
/// Ackermann's formula, K = eₙᵀ 𝒞⁻¹ p(A), in coordinates in which it is well behaved: even units, time scaled to the
/// fastest rate, and a rotation after which the input enters the first state alone and each state drives the next
/// (Hessenberg form). There eₙᵀ 𝒞⁻¹ is one number, and p is applied factor by factor.
///
/// # Errors
/// Shapes that do not fit, numbers that are not finite, a number of poles other than of states, a complex pole without
/// its conjugate; [`Error::NotControllable`] if the input does not reach every state.
pub fn place(a: &DMatrix<f64>, b: &DMatrix<f64>, poles: &[Complex<f64>]) -> Result<DMatrix<f64>, Error> {
    check_pair(a, b)?;
    let n = a.nrows();
    check("b", b, (n, 1))?;
    if poles.len() != n {
        return Err(Error::PoleCount { expected: n, found: poles.len() });
    }
    let factors = real_factors(poles)?;
    if n == 0 {
        return Ok(DMatrix::zeros(1, 0));
    }

    let (d, _) = balance::scales_of_pair(a, b);
    let (mut h, input) = (balance::balanced(a, &d), balance::rows_over(b, &d));
    let rate = poles.iter().map(|pole| pole.norm()).fold(h.amax(), f64::max);
    let strength = input.norm();
    if rate == 0.0 {
        // one state at rest, and a pole wished at 0: it is there
        return if n == 1 && strength > 0.0 { Ok(DMatrix::zeros(1, 1)) } else { Err(Error::NotControllable) };
    }
    if strength == 0.0 {
        return Err(Error::NotControllable);
    }
    h /= rate;

    let mut turn = reflection(&(&input / strength));
    h = &turn * h * turn.transpose();
    let sign = (&turn * &input)[0] / strength;
    if n > 1 {
        let (q, form) = h.hessenberg().unpack();
        turn = q.transpose() * turn;
        h = form;
    }
    let mut chain = sign;
    for i in 1..n {
        if h[(i, i - 1)].abs() < BROKEN_CHAIN {
            return Err(Error::NotControllable);
        }
        chain *= h[(i, i - 1)];
    }

    // eₙᵀ p(H)
    let mut row = RowDVector::zeros(n);
    row[n - 1] = 1.0;
    for factor in factors {
        row = match factor {
            Factor::Linear(pole) => &row * &h - &row * (pole / rate),
            Factor::Quadratic { twice_real, square } => {
                let once = &row * &h;
                &once * &h - once * (twice_real / rate) + row * (square / (rate * rate))
            }
        };
    }
    let row = row * turn * (rate / (chain * strength));
    let gain = DMatrix::from_fn(1, n, |_, j| row[j] / d[j]);
    if gain.iter().all(|value| value.is_finite()) { Ok(gain) } else { Err(Error::NotControllable) }
}

/// The column L with which A − L C has the given poles, for one output (C with one row): [`place`] for (Aᵀ, Cᵀ).
///
/// # Errors
/// As for [`place`].
pub fn place_observer(a: &DMatrix<f64>, c: &DMatrix<f64>, poles: &[Complex<f64>]) -> Result<DMatrix<f64>, Error> {
    check("a", a, (a.nrows(), a.nrows()))?;
    check("c", c, (1, a.nrows()))?;
    Ok(place(&a.transpose(), &c.transpose(), poles)?.transpose())
}

/// The symmetric orthogonal matrix that turns a unit vector onto the first axis, in either direction (Householder).
fn reflection(unit: &DMatrix<f64>) -> DMatrix<f64> {
    let n = unit.nrows();
    let mut v = unit.clone();
    v[0] += if v[0] >= 0.0 { 1.0 } else { -1.0 };
    let size = v.norm_squared();
    DMatrix::identity(n, n) - &v * v.transpose() * (2.0 / size)
}

/// A factor of a real polynomial.
enum Factor {
    /// s − p.
    Linear(f64),
    /// s² − 2 Re(p) s + |p|².
    Quadratic { twice_real: f64, square: f64 },
}

/// The real factors of the polynomial with these roots.
fn real_factors(poles: &[Complex<f64>]) -> Result<Vec<Factor>, Error> {
    if poles.iter().any(|pole| !pole.re.is_finite() || !pole.im.is_finite()) {
        return Err(Error::NotFinite { what: "a pole" });
    }
    let mut left = poles.to_vec();
    let mut factors = Vec::new();
    while let Some(pole) = left.pop() {
        if pole.im == 0.0 {
            factors.push(Factor::Linear(pole.re));
            continue;
        }
        let partner = left.iter().position(|other| (other - pole.conj()).norm() <= 1e-9 * pole.norm());
        left.swap_remove(partner.ok_or(Error::PolesNotConjugate)?);
        factors.push(Factor::Quadratic { twice_real: 2.0 * pole.re, square: pole.norm_sqr() });
    }
    Ok(factors)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::spectrum::eigenvalues;
    use proptest::prelude::*;

    fn matrix(n: usize, m: usize) -> impl Strategy<Value = DMatrix<f64>> {
        proptest::collection::vec(-1.0f64..1.0, n * m).prop_map(move |v| DMatrix::from_vec(n, m, v))
    }

    /// Largest distance of a wanted pole to the nearest that is there, over the largest rate.
    fn miss(found: &[Complex<f64>], wanted: &[Complex<f64>]) -> f64 {
        let rate = wanted.iter().map(|p| p.norm()).fold(0.0, f64::max);
        let nearest = |w: &Complex<f64>| found.iter().map(|p| (p - w).norm()).fold(f64::INFINITY, f64::min);
        wanted.iter().map(nearest).fold(0.0, f64::max) / rate
    }

    fn wanted() -> Vec<Complex<f64>> {
        vec![Complex::new(-1.0, 2.0), Complex::new(-1.0, -2.0), Complex::new(-3.0, 0.0), Complex::new(-0.5, 0.0)]
    }

    proptest! {
        #[test]
        fn poles_are_the_eigenvalues(a in matrix(4, 4), b in matrix(4, 1)) {
            let found = place(&a, &b, &wanted());
            prop_assume!(found.is_ok());
            let k = found.unwrap();
            // a gain of 10⁴ carries 10⁻¹² · 10⁴ into the poles
            prop_assume!(k.norm() < 1e4);
            let found = eigenvalues(&(&a - &b * k)).unwrap();
            prop_assert!(miss(&found, &wanted()) < 1e-6, "{:?}", found);
        }

        #[test]
        fn observers_are_dual(a in matrix(4, 4), c in matrix(1, 4)) {
            let found = place_observer(&a, &c, &wanted());
            prop_assume!(found.is_ok());
            let l = found.unwrap();
            prop_assume!(l.norm() < 1e4);
            let found = eigenvalues(&(&a - &l * c)).unwrap();
            prop_assert!(miss(&found, &wanted()) < 1e-6, "{:?}", found);
        }

        /// Other units of the states give the same closed loop.
        #[test]
        fn units_do_not_matter(a in matrix(3, 3), b in matrix(3, 1), e in proptest::collection::vec(-30i32..30, 3)) {
            let poles = &wanted()[..3];
            let found = place(&a, &b, poles);
            prop_assume!(found.is_ok());
            let k = found.unwrap();
            prop_assume!(k.norm() < 1e4);
            let d = |i: usize| f64::from(e[i]).exp2();
            let scaled_a = DMatrix::from_fn(3, 3, |i, j| a[(i, j)] * d(j) / d(i));
            let scaled_b = DMatrix::from_fn(3, 1, |i, _| b[i] / d(i));
            let scaled = place(&scaled_a, &scaled_b, poles).unwrap();
            for j in 0..3 {
                prop_assert!((scaled[j] / d(j) - k[j]).abs() < 1e-8 * k.norm() + 1e-12, "{scaled} {k}");
            }
        }
    }

    /// The double integrator: K = [ω², 2ζω].
    #[test]
    fn a_double_integrator_in_closed_form() {
        let a = DMatrix::from_row_slice(2, 2, &[0.0, 1.0, 0.0, 0.0]);
        let b = DMatrix::from_row_slice(2, 1, &[0.0, 1.0]);
        let k = place(&a, &b, &[Complex::new(-3.0, 4.0), Complex::new(-3.0, -4.0)]).unwrap();
        assert!((k - DMatrix::from_row_slice(1, 2, &[25.0, 6.0])).norm() < 1e-13);
    }

    /// Repeated poles are where plain `place` routines give up; with one input they are as good as others.
    #[test]
    fn repeated_poles() {
        let a = DMatrix::from_row_slice(3, 3, &[0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0]);
        let b = DMatrix::from_row_slice(3, 1, &[0.0, 0.0, 1.0]);
        let k = place(&a, &b, &[Complex::new(-2.0, 0.0); 3]).unwrap();
        assert!((k - DMatrix::from_row_slice(1, 3, &[8.0, 12.0, 6.0])).norm() < 1e-12);
    }

    #[test]
    fn what_cannot_be_placed_is_an_error() {
        let a = DMatrix::from_row_slice(2, 2, &[-1.0, 0.0, 0.0, -2.0]);
        let b = DMatrix::from_row_slice(2, 1, &[1.0, 0.0]);
        let real = |re: f64| Complex::new(re, 0.0);
        assert_eq!(place(&a, &b, &[real(-3.0), real(-4.0)]), Err(Error::NotControllable));
        assert_eq!(place(&a, &(&b * 0.0), &[real(-3.0), real(-4.0)]), Err(Error::NotControllable));
        let b = DMatrix::from_row_slice(2, 1, &[1.0, 1.0]);
        assert_eq!(place(&a, &b, &[real(-3.0)]), Err(Error::PoleCount { expected: 2, found: 1 }));
        assert_eq!(place(&a, &b, &[Complex::new(-3.0, 1.0), real(-3.0)]), Err(Error::PolesNotConjugate));
        assert_eq!(place(&a, &b, &[real(f64::NAN), real(-3.0)]), Err(Error::NotFinite { what: "a pole" }));
        let two_inputs = DMatrix::<f64>::identity(2, 2);
        assert!(matches!(place(&a, &two_inputs, &[real(-3.0), real(-4.0)]), Err(Error::Shape { matrix: "b", .. })));
    }
}
