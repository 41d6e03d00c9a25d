//! The robust servo: a controller that holds a constant reference without error, whatever constant disturbance there is
//! (appendix A, "Robust Servo Control").

use crate::error::{Error, check, check_pair};
use nalgebra::DMatrix;

/// The system of z = (e, ẋ), e = r − y, driven by u̇: ż = [0 −C; 0 A] z + [0; B] u̇.
///
/// Feedback u̇ = −K z drives e to 0; integrated once it reads u = −K (∫e dt, x), so that only the output is integrated
/// and the rest of the state is fed back as it is. The pair is controllable exactly if (A, B) is and (A, B, C) has no
/// zero at s = 0.
///
/// # Errors
/// Shapes that do not fit, numbers that are not finite.
pub fn augment(a: &DMatrix<f64>, b: &DMatrix<f64>, c: &DMatrix<f64>) -> Result<(DMatrix<f64>, DMatrix<f64>), Error> {
    check_pair(a, b)?;
    check("c", c, (c.nrows(), a.nrows()))?;
    let (n, errors, inputs) = (a.nrows(), c.nrows(), b.ncols());
    let mut servo_a = DMatrix::zeros(errors + n, errors + n);
    servo_a.view_mut((0, errors), (errors, n)).copy_from(&-c);
    servo_a.view_mut((errors, errors), (n, n)).copy_from(a);
    let mut servo_b = DMatrix::zeros(errors + n, inputs);
    servo_b.view_mut((errors, 0), (n, inputs)).copy_from(b);
    Ok((servo_a, servo_b))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::place::place;
    use crate::rank::controllable;
    use nalgebra::Complex;

    fn plant() -> (DMatrix<f64>, DMatrix<f64>, DMatrix<f64>) {
        (
            DMatrix::from_row_slice(2, 2, &[0.0, 1.0, -2.0, -0.3]),
            DMatrix::from_row_slice(2, 1, &[0.0, 1.5]),
            DMatrix::from_row_slice(1, 2, &[1.0, 0.0]),
        )
    }

    /// The loop closed on a plant 30 % other than believed, with a constant disturbance: no error stays.
    #[test]
    fn no_error_stays() {
        let (a, b, c) = plant();
        let (servo_a, servo_b) = augment(&a, &b, &c).unwrap();
        assert!(controllable(&servo_a, &servo_b).unwrap());
        let poles = [Complex::new(-2.0, 1.0), Complex::new(-2.0, -1.0), Complex::new(-3.0, 0.0)];
        let k = place(&servo_a, &servo_b, &poles).unwrap();
        let (true_a, true_b) = (&a * 1.3, &b * 0.7);
        let disturbance = DMatrix::from_row_slice(2, 1, &[0.0, 4.0]);
        let (mut x, mut integral, dt, reference) = (DMatrix::<f64>::zeros(2, 1), 0.0, 1e-3, 5.0);
        for _ in 0..30_000 {
            let u = -(k[0] * integral + k[1] * x[0] + k[2] * x[1]);
            integral += (reference - (&c * &x)[0]) * dt;
            x += (&true_a * &x + &true_b * u + &disturbance) * dt;
        }
        assert!(((&c * &x)[0] - reference).abs() < 1e-6, "{x}");
    }

    /// A plant that blocks constants cannot be made to hold one.
    #[test]
    fn a_zero_at_the_origin_is_not_controllable() {
        let (a, b, _) = plant();
        let rate = DMatrix::from_row_slice(1, 2, &[0.0, 1.0]);
        let (servo_a, servo_b) = augment(&a, &b, &rate).unwrap();
        assert!(!controllable(&servo_a, &servo_b).unwrap());
    }
}
