//! Between continuous and discrete time (appendix A, "Deterministic/Stochastic State-Space Models"; C. F. Van Loan,
//! *Computing integrals involving the matrix exponential*, 1978).

use crate::error::{Error, check, check_pair, check_positive, check_symmetric};
use nalgebra::DMatrix;

/// What ẋ = A x + B u does in `dt_s` seconds with u held (zero-order hold): x⁺ = A_d x + B_d u.
///
/// Both come of one exponential, exp([A B; 0 0] Δt) = [A_d B_d; 0 I], which needs no inverse of A.
///
/// # Errors
/// Shapes that do not fit, numbers that are not finite, a step that is not positive, a system that outgrows f64.
pub fn discretise(a: &DMatrix<f64>, b: &DMatrix<f64>, dt_s: f64) -> Result<(DMatrix<f64>, DMatrix<f64>), Error> {
    check_pair(a, b)?;
    check_positive("dt_s", dt_s)?;
    let (n, inputs) = b.shape();
    let mut both = DMatrix::zeros(n + inputs, n + inputs);
    both.view_mut((0, 0), (n, n)).copy_from(a);
    both.view_mut((0, n), (n, inputs)).copy_from(b);
    let both = exponential(&(both * dt_s))?;
    Ok((both.view((0, 0), (n, n)).into_owned(), both.view((0, n), (n, inputs)).into_owned()))
}

/// Covariance that white noise of spectral density `q` on ẋ (B_w Q_c B_wᵀ) adds up to in `dt_s` seconds:
/// Q_d = ∫₀^Δt exp(Aτ) Q exp(Aᵀτ) dτ.
///
/// Van Loan's exponential of [−A Q; 0 Aᵀ] over a part of the step short enough that exp(−A τ) does not outgrow the
/// rest, then doubled: Q(2τ) = Q(τ) + exp(Aτ) Q(τ) exp(Aᵀτ).
///
/// # Errors
/// As for [`discretise`], and a `q` that is not symmetric.
pub fn discretise_noise(a: &DMatrix<f64>, q: &DMatrix<f64>, dt_s: f64) -> Result<DMatrix<f64>, Error> {
    check("a", a, (a.nrows(), a.nrows()))?;
    check_symmetric("q", q, a.nrows())?;
    check_positive("dt_s", dt_s)?;
    let n = a.nrows();
    let doublings = (a.norm() * dt_s).log2().ceil().clamp(0.0, 1000.0);
    let part = dt_s / doublings.exp2();
    let mut hamiltonian = DMatrix::zeros(2 * n, 2 * n);
    hamiltonian.view_mut((0, 0), (n, n)).copy_from(&-a);
    hamiltonian.view_mut((0, n), (n, n)).copy_from(q);
    hamiltonian.view_mut((n, n), (n, n)).copy_from(&a.transpose());
    let c = exponential(&(hamiltonian * part))?;
    let mut transition = c.view((n, n), (n, n)).transpose();
    let mut noise = &transition * c.view((0, n), (n, n));
    for _ in 0..doublings as usize {
        noise += &transition * &noise * transition.transpose();
        transition = &transition * &transition;
    }
    let noise = symmetric(&noise);
    if noise.iter().all(|value| value.is_finite()) { Ok(noise) } else { Err(Error::NotFinite { what: "q_d" }) }
}

/// Covariance of one sample of a measurement with noise of spectral density `r`, averaged over the step:
/// R_d = R_c/Δt.
///
/// # Errors
/// An `r` that is not square, symmetric and finite, a step that is not positive.
pub fn discretise_measurement_noise(r: &DMatrix<f64>, dt_s: f64) -> Result<DMatrix<f64>, Error> {
    check_symmetric("r", r, r.nrows())?;
    check_positive("dt_s", dt_s)?;
    Ok(r / dt_s)
}

/// The continuous-time system that a zero-order hold of `dt_s` turns into (`ad`, `bd`): the way back from
/// [`discretise`], by the principal logarithm. Oscillations faster than half the sampling rate come back as their slow
/// alias.
///
/// # Errors
/// As for [`discretise`]; [`Error::NoLogarithm`] if A_d is singular or has a negative eigenvalue.
pub fn continuous(ad: &DMatrix<f64>, bd: &DMatrix<f64>, dt_s: f64) -> Result<(DMatrix<f64>, DMatrix<f64>), Error> {
    check_pair(ad, bd)?;
    check_positive("dt_s", dt_s)?;
    let (n, inputs) = bd.shape();
    let mut both = DMatrix::identity(n + inputs, n + inputs);
    both.view_mut((0, 0), (n, n)).copy_from(ad);
    both.view_mut((0, n), (n, inputs)).copy_from(bd);
    let both = logarithm(&both)? / dt_s;
    Ok((both.view((0, 0), (n, n)).into_owned(), both.view((0, n), (n, inputs)).into_owned()))
}

/// exp(M) by scaling and squaring with Padé approximants (Higham, 2005).
///
/// # Errors
/// A matrix that is not square or not finite, a result that is not.
pub fn exponential(m: &DMatrix<f64>) -> Result<DMatrix<f64>, Error> {
    check("m", m, (m.nrows(), m.nrows()))?;
    if m.is_empty() {
        return Ok(m.clone());
    }
    // beyond this norm the result overflows or is 0 to working precision either way
    if m.norm() > 1e12 {
        return Err(Error::NotFinite { what: "the matrix exponential" });
    }
    let result = m.exp();
    if result.iter().all(|value| value.is_finite()) {
        Ok(result)
    } else {
        Err(Error::NotFinite { what: "the matrix exponential" })
    }
}

/// Nodes and weights of Gauss and Legendre's rule on −1..1 (positive half), 8 points.
const GAUSS: [(f64, f64); 4] = [
    (0.183_434_642_495_649_8, 0.362_683_783_378_362),
    (0.525_532_409_916_329, 0.313_706_645_877_887_3),
    (0.796_666_477_413_626_7, 0.222_381_034_453_374_48),
    (0.960_289_856_497_536_3, 0.101_228_536_290_376_26),
];

/// The principal logarithm of a real matrix, by inverse scaling and squaring: square roots (Denman and Beavers, 1976)
/// until it is near I, there the Padé approximant, which is Gauss' rule on ∫₀¹ X (I + tX)⁻¹ dt (Dieci and others,
/// 1996).
///
/// # Errors
/// [`Error::NoLogarithm`] for a singular matrix or a negative eigenvalue; a matrix that is not square or not finite.
pub fn logarithm(m: &DMatrix<f64>) -> Result<DMatrix<f64>, Error> {
    check("m", m, (m.nrows(), m.nrows()))?;
    let n = m.nrows();
    let identity = DMatrix::<f64>::identity(n, n);
    for value in crate::eigenvalues(m)? {
        if value.norm() == 0.0 || (value.re < 0.0 && value.im.abs() <= 1e-12 * value.re.abs()) {
            return Err(Error::NoLogarithm);
        }
    }
    let mut root = m.clone();
    let mut factor = 1.0;
    // 8 points are exact to working precision for ‖X‖ up to about ¼
    while (&root - &identity).norm() > 0.25 {
        if factor > 1e15 {
            return Err(Error::NoConvergence { what: "the matrix logarithm" });
        }
        root = square_root(&root)?;
        factor *= 2.0;
    }
    let x = &root - &identity;
    let mut sum = DMatrix::zeros(n, n);
    for (node, weight) in GAUSS {
        for t in [0.5 - 0.5 * node, 0.5 + 0.5 * node] {
            let inverse = (&identity + &x * t).try_inverse().ok_or(Error::NoLogarithm)?;
            sum += &x * inverse * (0.5 * weight);
        }
    }
    Ok(sum * factor)
}

/// The principal square root, by Denman and Beavers' iteration: Y → M^½, Z → M^−½.
fn square_root(m: &DMatrix<f64>) -> Result<DMatrix<f64>, Error> {
    let (mut y, mut z) = (m.clone(), DMatrix::identity(m.nrows(), m.nrows()));
    let mut before = f64::INFINITY;
    for _ in 0..100 {
        let inverse_y = y.clone().try_inverse().ok_or(Error::NoLogarithm)?;
        let inverse_z = z.clone().try_inverse().ok_or(Error::NoLogarithm)?;
        let next = (&y + inverse_z) * 0.5;
        z = (z + inverse_y) * 0.5;
        let change = (&next - &y).norm() / next.norm();
        y = next;
        // quadratic down to rounding, where it stops shrinking
        if change < 1e-9 && (change >= before || change < f64::EPSILON) {
            return Ok(y);
        }
        before = change;
    }
    Err(Error::NoConvergence { what: "the matrix square root" })
}

/// Half of M + Mᵀ.
pub(crate) fn symmetric(m: &DMatrix<f64>) -> DMatrix<f64> {
    (m + m.transpose()) * 0.5
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn matrix(n: usize, m: usize, most: f64) -> impl Strategy<Value = DMatrix<f64>> {
        proptest::collection::vec(-most..most, n * m).prop_map(move |v| DMatrix::from_vec(n, m, v))
    }

    /// exp by nothing but Taylor's series over a short step, and its composition.
    fn by_taylor(a: &DMatrix<f64>, t: f64) -> DMatrix<f64> {
        let x = a * (t / 1024.0);
        let mut term = DMatrix::identity(a.nrows(), a.nrows());
        let mut sum = term.clone();
        for k in 1..20 {
            term = &term * &x / k as f64;
            sum += &term;
        }
        for _ in 0..10 {
            sum = &sum * &sum;
        }
        sum
    }

    /// Simpson's rule over a function of time.
    fn simpson(f: impl Fn(f64) -> DMatrix<f64>, end: f64, pieces: usize) -> DMatrix<f64> {
        let h = end / pieces as f64;
        let mut sum = f(0.0) + f(end);
        for k in 1..pieces {
            sum += f(k as f64 * h) * if k % 2 == 1 { 4.0 } else { 2.0 };
        }
        sum * (h / 3.0)
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(40))]

        #[test]
        fn van_loan_is_the_integral(
            a in matrix(3, 3, 2.0), b in matrix(3, 2, 2.0), w in matrix(3, 3, 1.0), dt in 0.01f64..1.0,
        ) {
            let q = &w * w.transpose();
            let (ad, bd) = discretise(&a, &b, dt).unwrap();
            let qd = discretise_noise(&a, &q, dt).unwrap();
            let tight = |x: &DMatrix<f64>, y: &DMatrix<f64>| (x - y).norm() <= 1e-7 * (1.0 + y.norm());
            prop_assert!(tight(&ad, &by_taylor(&a, dt)));
            prop_assert!(tight(&bd, &simpson(|t| by_taylor(&a, t) * &b, dt, 200)));
            let spread = |t: f64| { let e = by_taylor(&a, t); &e * &q * e.transpose() };
            prop_assert!(tight(&qd, &simpson(spread, dt, 200)));
        }

        #[test]
        fn there_and_back(a in matrix(3, 3, 2.0), b in matrix(3, 1, 2.0), dt in 0.01f64..0.4) {
            // eigenvalues below 2·3 · 0.4 < π: no alias
            let (ad, bd) = discretise(&a, &b, dt).unwrap();
            let (ac, bc) = continuous(&ad, &bd, dt).unwrap();
            prop_assert!((&ac - &a).norm() < 1e-8 * (1.0 + a.norm()), "{ac} {a}");
            prop_assert!((&bc - &b).norm() < 1e-8 * (1.0 + b.norm()));
        }
    }

    /// A pole of 10⁶/s over a second: the plain exponential of −A would be e^1000000.
    #[test]
    fn fast_poles_do_not_overflow() {
        let a = DMatrix::from_diagonal_element(1, 1, -1e6);
        let q = DMatrix::from_element(1, 1, 2e6);
        let noise = discretise_noise(&a, &q, 1.0).unwrap();
        assert!((noise[(0, 0)] - 1.0).abs() < 1e-9, "{noise}");
    }

    #[test]
    fn a_double_integrator_in_closed_form() {
        let a = DMatrix::from_row_slice(2, 2, &[0.0, 1.0, 0.0, 0.0]);
        let b = DMatrix::from_row_slice(2, 1, &[0.0, 1.0]);
        let q = DMatrix::from_row_slice(2, 2, &[0.0, 0.0, 0.0, 3.0]);
        let t = 0.2;
        let (ad, bd) = discretise(&a, &b, t).unwrap();
        assert!((ad - DMatrix::from_row_slice(2, 2, &[1.0, t, 0.0, 1.0])).norm() < 1e-15);
        assert!((bd - DMatrix::from_row_slice(2, 1, &[t * t / 2.0, t])).norm() < 1e-15);
        let exact = DMatrix::from_row_slice(2, 2, &[t * t * t / 3.0, t * t / 2.0, t * t / 2.0, t]) * 3.0;
        assert!((discretise_noise(&a, &q, t).unwrap() - exact).norm() < 1e-15);
    }

    #[test]
    fn bad_input_is_an_error() {
        let a = DMatrix::<f64>::identity(2, 2);
        let b = DMatrix::<f64>::zeros(2, 1);
        assert!(matches!(discretise(&a, &DMatrix::zeros(3, 1), 0.1), Err(Error::Shape { matrix: "b", .. })));
        assert!(matches!(discretise(&DMatrix::zeros(2, 3), &b, 0.1), Err(Error::Shape { matrix: "a", .. })));
        assert!(matches!(discretise(&a, &b, 0.0), Err(Error::NotPositive { .. })));
        assert!(matches!(discretise(&a, &b, f64::NAN), Err(Error::NotFinite { .. })));
        assert!(matches!(discretise(&(&a * f64::NAN), &b, 0.1), Err(Error::NotFinite { .. })));
        assert!(matches!(discretise(&(&a * 1e4), &b, 1.0), Err(Error::NotFinite { .. })));
        assert_eq!(continuous(&(-a), &b, 0.1), Err(Error::NoLogarithm));
        assert_eq!(logarithm(&DMatrix::zeros(2, 2)), Err(Error::NoLogarithm));
        let lopsided = DMatrix::from_row_slice(2, 2, &[1.0, 1.0, 0.0, 1.0]);
        assert_eq!(discretise_noise(&lopsided, &lopsided, 0.1), Err(Error::NotSymmetric { matrix: "q" }));
    }
}
