//! Optimal gains: the linear-quadratic regulator and its dual, the linear-quadratic estimator (appendix A,
//! "State-Feedback Controller" and "State Estimator"), and the Riccati equations they come from.

use crate::convert::symmetric;
use crate::error::{Error, check, check_pair, check_symmetric};
use crate::{balance, spectrum};
use nalgebra::{DMatrix, DVector};

/// Iterations of either equation; both converge quadratically, in about ten.
const MOST_ITERATIONS: usize = 100;

/// The stabilising X of AᵀX + XA − XBR⁻¹BᵀX + Q = 0.
///
/// The stable subspace of the Hamiltonian [A −G; −Q −Aᵀ] by the matrix sign function (Roberts, 1980; Newton's iteration
/// with Byers' scaling by the determinant), in balanced units.
///
/// # Errors
/// Shapes that do not fit, numbers that are not finite, weights that are not symmetric, a Q with a negative eigenvalue,
/// an R without inverse; [`Error::NotStabilisable`] if no stabilising solution exists.
pub fn care(a: &DMatrix<f64>, b: &DMatrix<f64>, q: &DMatrix<f64>, r: &DMatrix<f64>) -> Result<DMatrix<f64>, Error> {
    let g = checked_weights(a, b, q, r)?;
    let n = a.nrows();
    if n == 0 {
        return Ok(DMatrix::zeros(0, 0));
    }
    let plain = block(a, &-&g, &-q, &-a.transpose());
    // units that balance the Hamiltonian and keep it one: d for the states, 1/d for their duals
    let both = balance::scales(&plain);
    let d = DVector::from_fn(n, |i, _| (both[i] / both[n + i]).sqrt());
    let all = DVector::from_fn(2 * n, |i, _| if i < n { d[i] } else { 1.0 / d[i - n] });
    let mut z = balance::balanced(&plain, &all);
    let size = z.norm();
    if !size.is_finite() || size == 0.0 {
        return Err(Error::NotStabilisable);
    }
    z /= size;

    let mut before = f64::INFINITY;
    let mut converged = false;
    for _ in 0..MOST_ITERATIONS {
        let inverse = z.clone().try_inverse().ok_or(Error::NotStabilisable)?;
        let determinant = z.determinant().abs();
        // far from the end scaling saves iterations, near it it would cost the quadratic convergence
        let scale = if before > 1e-2 { determinant.powf(-0.5 / n as f64) } else { 1.0 };
        let scale = if scale.is_normal() { scale } else { 1.0 };
        let next = (&z * scale + inverse / scale) * 0.5;
        let change = (&next - &z).norm() / next.norm();
        z = next;
        if change.is_nan() {
            return Err(Error::NotStabilisable);
        }
        if change < 1e-9 && (change >= before || change < 1e-15) {
            converged = true;
            break;
        }
        before = change;
    }
    if !converged {
        return Err(Error::NotStabilisable);
    }

    // sign(H) [I; X] = −[I; X]
    let identity = DMatrix::<f64>::identity(n, n);
    let left = stack(&z.view((0, n), (n, n)).into_owned(), &(z.view((n, n), (n, n)) + &identity));
    let right = -stack(&(z.view((0, 0), (n, n)) + &identity), &z.view((n, 0), (n, n)).into_owned());
    let x = left.svd(true, true).solve(&right, 1e-14).map_err(|_| Error::NotStabilisable)?;
    let x = refined(x, &balance::balanced(&plain, &all));
    let x = DMatrix::from_fn(n, n, |i, j| x[(i, j)] / (d[i] * d[j]));
    if spectrum::abscissa(&(a - &g * &x))? < 0.0 { Ok(x) } else { Err(Error::NotStabilisable) }
}

/// X with the digits back that the subspace cost it: Newton's steps on the equation itself (Kleinman, 1968), for as
/// long as they shrink what is left of it. `hamiltonian` is [A −G; −Q −Aᵀ].
fn refined(x: DMatrix<f64>, hamiltonian: &DMatrix<f64>) -> DMatrix<f64> {
    let n = x.nrows();
    let part = |i: usize, j: usize| hamiltonian.view((i * n, j * n), (n, n)).into_owned();
    let (a, g, q) = (part(0, 0), -part(0, 1), -part(1, 0));
    let left_over = |x: &DMatrix<f64>| symmetric(&(a.transpose() * x + x * &a - x * &g * x + &q));
    let mut x = symmetric(&x);
    let mut rest = left_over(&x);
    for _ in 0..3 {
        // (A − GX)ᵀ D + D (A − GX) = −rest, one equation an entry
        let closed = (&a - &g * &x).transpose();
        let identity = DMatrix::<f64>::identity(n, n);
        let equations = identity.kronecker(&closed) + closed.kronecker(&identity);
        let Some(step) = equations.lu().solve(&DVector::from_column_slice((-&rest).as_slice())) else { break };
        let next = symmetric(&(&x + DMatrix::from_column_slice(n, n, step.as_slice())));
        let next_rest = left_over(&next);
        if next_rest.norm() >= rest.norm() || !next_rest.norm().is_finite() {
            break;
        }
        (x, rest) = (next, next_rest);
    }
    x
}

/// The stabilising X of X = AᵀXA − AᵀXB (R + BᵀXB)⁻¹ BᵀXA + Q.
///
/// By structure-preserving doubling (Anderson, 1978; Chu, Fan, Lin and Wang, 2004): the k-th iterate is the cost over
/// 2ᵏ steps. Needs no inverse of A.
///
/// # Errors
/// As for [`care`]; moreover every mode that is not stable has to show in Q.
pub fn dare(a: &DMatrix<f64>, b: &DMatrix<f64>, q: &DMatrix<f64>, r: &DMatrix<f64>) -> Result<DMatrix<f64>, Error> {
    let g = checked_weights(a, b, q, r)?;
    let n = a.nrows();
    let identity = DMatrix::<f64>::identity(n, n);
    let both = balance::scales(&block(a, &g, q, &a.transpose()));
    let d = DVector::from_fn(n, |i, _| (both[i] / both[n + i]).sqrt());
    let mut transition = balance::balanced(a, &d);
    let mut reach = DMatrix::from_fn(n, n, |i, j| g[(i, j)] / (d[i] * d[j]));
    let mut cost = DMatrix::from_fn(n, n, |i, j| q[(i, j)] * d[i] * d[j]);
    let mut converged = n == 0;
    for _ in 0..MOST_ITERATIONS {
        if converged {
            break;
        }
        let inverse = (&identity + &reach * &cost).try_inverse().ok_or(Error::NotStabilisable)?;
        let onward = &inverse * &transition;
        let added = symmetric(&(transition.transpose() * &cost * &onward));
        reach += symmetric(&(&transition * &inverse * &reach * transition.transpose()));
        transition = &transition * onward;
        cost += &added;
        if cost.iter().chain(reach.iter()).any(|value| !value.is_finite()) {
            return Err(Error::NotStabilisable);
        }
        converged = added.norm() <= f64::EPSILON * cost.norm();
    }
    if !converged {
        return Err(Error::NotStabilisable);
    }
    let x = DMatrix::from_fn(n, n, |i, j| cost[(i, j)] / (d[i] * d[j]));
    let k = discrete_gain(a, b, r, &x)?;
    if spectrum::radius(&(a - b * k))? < 1.0 { Ok(x) } else { Err(Error::NotStabilisable) }
}

/// The K of u = −K x that minimises ∫ xᵀQx + uᵀRu dt: K = R⁻¹BᵀX with X of [`care`].
///
/// # Errors
/// As for [`care`].
pub fn lqr(a: &DMatrix<f64>, b: &DMatrix<f64>, q: &DMatrix<f64>, r: &DMatrix<f64>) -> Result<DMatrix<f64>, Error> {
    let x = care(a, b, q, r)?;
    Ok(inverse_of_weight(r)? * b.transpose() * x)
}

/// The K of u = −K x that minimises Σ xᵀQx + uᵀRu: K = (R + BᵀXB)⁻¹BᵀXA with X of [`dare`].
///
/// # Errors
/// As for [`dare`].
pub fn dlqr(a: &DMatrix<f64>, b: &DMatrix<f64>, q: &DMatrix<f64>, r: &DMatrix<f64>) -> Result<DMatrix<f64>, Error> {
    discrete_gain(a, b, r, &dare(a, b, q, r)?)
}

/// The L of the observer x̂' = A x̂ + B u + L (y − C x̂) whose error is least under white noise of spectral density `q`
/// on ẋ and `r` on y: the stationary Kalman filter.
///
/// # Errors
/// As for [`care`], of the dual system.
pub fn lqe(a: &DMatrix<f64>, c: &DMatrix<f64>, q: &DMatrix<f64>, r: &DMatrix<f64>) -> Result<DMatrix<f64>, Error> {
    check("a", a, (a.nrows(), a.nrows()))?;
    check("c", c, (c.nrows(), a.nrows()))?;
    Ok(lqr(&a.transpose(), &c.transpose(), q, r)?.transpose())
}

/// The L of the correction x̂ₖ|ₖ = x̂ₖ|ₖ₋₁ + L (y − C x̂ₖ|ₖ₋₁) whose error is least under white noise of covariance `q`
/// per step on x and `r` on y: L = P Cᵀ (C P Cᵀ + R)⁻¹, P the stationary covariance of the prediction.
///
/// # Errors
/// As for [`dare`], of the dual system.
pub fn dlqe(a: &DMatrix<f64>, c: &DMatrix<f64>, q: &DMatrix<f64>, r: &DMatrix<f64>) -> Result<DMatrix<f64>, Error> {
    check("a", a, (a.nrows(), a.nrows()))?;
    check("c", c, (c.nrows(), a.nrows()))?;
    let p = dare(&a.transpose(), &c.transpose(), q, r)?;
    let innovation = inverse_of_weight(&(c * &p * c.transpose() + r))?;
    Ok(p * c.transpose() * innovation)
}

/// (R + BᵀXB)⁻¹BᵀXA.
fn discrete_gain(
    a: &DMatrix<f64>,
    b: &DMatrix<f64>,
    r: &DMatrix<f64>,
    x: &DMatrix<f64>,
) -> Result<DMatrix<f64>, Error> {
    Ok(inverse_of_weight(&symmetric(&(r + b.transpose() * x * b)))? * b.transpose() * x * a)
}

/// G = B R⁻¹ Bᵀ of weights that are what they should be.
fn checked_weights(
    a: &DMatrix<f64>,
    b: &DMatrix<f64>,
    q: &DMatrix<f64>,
    r: &DMatrix<f64>,
) -> Result<DMatrix<f64>, Error> {
    check_pair(a, b)?;
    check_symmetric("q", q, a.nrows())?;
    check_symmetric("r", r, b.ncols())?;
    // by signs of the scaled matrix: eigenvalues of Q itself would judge one unit against another
    let d = DVector::from_fn(q.nrows(), |i, _| if q[(i, i)] > 0.0 { q[(i, i)].sqrt() } else { 1.0 });
    let unit = DMatrix::from_fn(q.nrows(), q.ncols(), |i, j| q[(i, j)] / (d[i] * d[j]));
    if unit.symmetric_eigenvalues().iter().any(|&value| value < -1e-10) {
        return Err(Error::NotPositiveDefinite { matrix: "q" });
    }
    Ok(symmetric(&(b * inverse_of_weight(r)? * b.transpose())))
}

fn inverse_of_weight(r: &DMatrix<f64>) -> Result<DMatrix<f64>, Error> {
    Ok(r.clone().cholesky().ok_or(Error::NotPositiveDefinite { matrix: "r" })?.inverse())
}

fn block(
    top_left: &DMatrix<f64>,
    top_right: &DMatrix<f64>,
    low_left: &DMatrix<f64>,
    low_right: &DMatrix<f64>,
) -> DMatrix<f64> {
    let n = top_left.nrows();
    let mut all = DMatrix::zeros(2 * n, 2 * n);
    all.view_mut((0, 0), (n, n)).copy_from(top_left);
    all.view_mut((0, n), (n, n)).copy_from(top_right);
    all.view_mut((n, 0), (n, n)).copy_from(low_left);
    all.view_mut((n, n), (n, n)).copy_from(low_right);
    all
}

fn stack(top: &DMatrix<f64>, low: &DMatrix<f64>) -> DMatrix<f64> {
    let mut all = DMatrix::zeros(top.nrows() + low.nrows(), top.ncols());
    all.rows_mut(0, top.nrows()).copy_from(top);
    all.rows_mut(top.nrows(), low.nrows()).copy_from(low);
    all
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn matrix(n: usize, m: usize) -> impl Strategy<Value = DMatrix<f64>> {
        proptest::collection::vec(-1.0f64..1.0, n * m).prop_map(move |v| DMatrix::from_vec(n, m, v))
    }

    /// A weight well inside the positive ones.
    fn weight(n: usize) -> impl Strategy<Value = DMatrix<f64>> {
        matrix(n, n).prop_map(move |w| &w * w.transpose() + DMatrix::identity(n, n) * 0.1)
    }

    proptest! {
        #[test]
        fn care_is_solved_and_stable(a in matrix(4, 4), b in matrix(4, 2), q in weight(4), r in weight(2)) {
            // random systems are controllable; how nearly not, the size of X says
            let found = care(&a, &b, &q, &r);
            prop_assume!(found.is_ok());
            let x = found.unwrap();
            prop_assume!(x.norm() < 1e4);
            let g = &b * r.clone().try_inverse().unwrap() * b.transpose();
            let residual = a.transpose() * &x + &x * &a - &x * &g * &x + &q;
            prop_assert!(residual.norm() < 1e-9 * (1.0 + x.norm().powi(2)), "{residual}");
            prop_assert!(spectrum::abscissa(&(&a - &b * lqr(&a, &b, &q, &r).unwrap())).unwrap() < 0.0);
            prop_assert!(x.symmetric_eigenvalues().iter().all(|&v| v > 0.0));
        }

        #[test]
        fn dare_is_solved_and_stable(a in matrix(4, 4), b in matrix(4, 2), q in weight(4), r in weight(2)) {
            let found = dare(&a, &b, &q, &r);
            prop_assume!(found.is_ok());
            let x = found.unwrap();
            prop_assume!(x.norm() < 1e4);
            let k = dlqr(&a, &b, &q, &r).unwrap();
            let residual = a.transpose() * &x * &a - a.transpose() * &x * &b * &k + &q - &x;
            prop_assert!(residual.norm() < 1e-10 * (1.0 + x.norm().powi(2)), "{residual}");
            prop_assert!(spectrum::radius(&(&a - &b * k)).unwrap() < 1.0);
        }

        /// No other gain near the optimal one costs less: the cost of a gain from x₀, summed step by step.
        #[test]
        fn dlqr_is_a_minimum(a in matrix(2, 2), b in matrix(2, 1), dk in matrix(1, 2)) {
            let (q, r) = (DMatrix::identity(2, 2), DMatrix::identity(1, 1));
            let found = dlqr(&a, &b, &q, &r);
            prop_assume!(found.is_ok());
            let k = found.unwrap();
            prop_assume!(k.norm() < 10.0 && dk.norm() > 0.05);
            let cost = |k: &DMatrix<f64>| {
                let (mut x, mut sum) = (DMatrix::from_row_slice(2, 1, &[1.0, -0.7]), 0.0);
                for _ in 0..2000 {
                    let u = -k * &x;
                    sum += x.norm_squared() + u.norm_squared();
                    x = &a * &x + &b * u;
                }
                sum
            };
            let best = cost(&k);
            let other = cost(&(&k + dk * 0.1));
            prop_assert!(best <= other * (1.0 + 1e-12) || other.is_nan(), "{best} {other}");
        }

        /// A sampled system, sampled ever finer, has the continuous-time gain.
        #[test]
        fn both_times_agree(a in matrix(3, 3), b in matrix(3, 1)) {
            let (q, r) = (DMatrix::identity(3, 3), DMatrix::identity(1, 1));
            let found = lqr(&a, &b, &q, &r);
            prop_assume!(found.is_ok());
            let k = found.unwrap();
            prop_assume!(k.norm() < 20.0);
            let dt = 1e-6;
            let (ad, bd) = crate::convert::discretise(&a, &b, dt).unwrap();
            let sampled = dlqr(&ad, &bd, &(q * dt), &(r * dt)).unwrap();
            prop_assert!((&sampled - &k).norm() < 1e-3 * (1.0 + k.norm()), "{sampled} {k}");
        }
    }

    /// ẋ = a x + b u: x = (a + √(a² + b² q/r)) r/b².
    #[test]
    fn one_state_in_closed_form() {
        let one = |value: f64| DMatrix::from_element(1, 1, value);
        let (a, b, q, r) = (0.7f64, 2.0f64, 3.0f64, 0.5f64);
        let exact = (a + (a * a + b * b * q / r).sqrt()) * r / (b * b);
        let x = care(&one(a), &one(b), &one(q), &one(r)).unwrap();
        assert!((x[(0, 0)] - exact).abs() < 1e-13);
        assert!((lqr(&one(a), &one(b), &one(q), &one(r)).unwrap()[(0, 0)] - b * exact / r).abs() < 1e-13);
        // an unstable mode that costs nothing is mirrored
        let x = care(&one(a), &one(b), &one(0.0), &one(r)).unwrap();
        assert!((x[(0, 0)] - 2.0 * a * r / (b * b)).abs() < 1e-13);
    }

    /// The filter of a random walk: P² = q P + q r.
    #[test]
    fn the_filter_of_a_random_walk() {
        let one = |value: f64| DMatrix::from_element(1, 1, value);
        let (q, r) = (0.2f64, 1.5f64);
        let p = 0.5 * (q + (q * q + 4.0 * q * r).sqrt());
        let l = dlqe(&one(1.0), &one(1.0), &one(q), &one(r)).unwrap();
        assert!((l[(0, 0)] - p / (p + r)).abs() < 1e-13);
        let l = lqe(&one(0.0), &one(1.0), &one(q), &one(r)).unwrap();
        assert!((l[(0, 0)] - (q / r).sqrt()).abs() < 1e-13);
    }

    #[test]
    fn what_has_no_optimum_is_an_error() {
        let a = DMatrix::from_row_slice(2, 2, &[1.0, 0.0, 0.0, -2.0]);
        let b = DMatrix::from_row_slice(2, 1, &[0.0, 1.0]);
        let (q, r) = (DMatrix::identity(2, 2), DMatrix::identity(1, 1));
        assert_eq!(care(&a, &b, &q, &r), Err(Error::NotStabilisable));
        assert_eq!(dare(&(&a * 1.1), &b, &q, &r), Err(Error::NotStabilisable));
        assert_eq!(lqr(&a, &b, &q, &(-&r)), Err(Error::NotPositiveDefinite { matrix: "r" }));
        assert_eq!(lqr(&a, &b, &-&q, &r), Err(Error::NotPositiveDefinite { matrix: "q" }));
        let lopsided = DMatrix::from_row_slice(2, 2, &[1.0, 1.0, 0.0, 1.0]);
        assert_eq!(lqr(&a, &b, &lopsided, &r), Err(Error::NotSymmetric { matrix: "q" }));
        // an integrator that costs nothing has its optimum on the limit
        let a = DMatrix::from_row_slice(2, 2, &[0.0, 0.0, 0.0, -2.0]);
        let b = DMatrix::from_row_slice(2, 1, &[1.0, 1.0]);
        let q = DMatrix::from_row_slice(2, 2, &[0.0, 0.0, 0.0, 1.0]);
        assert_eq!(care(&a, &b, &q, &r), Err(Error::NotStabilisable));
        let a = DMatrix::from_row_slice(2, 2, &[1.0, 0.0, 0.0, 0.5]);
        assert_eq!(dare(&a, &b, &q, &r), Err(Error::NotStabilisable));
    }
}
