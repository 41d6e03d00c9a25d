//! A smooth monotone deformation of an outer curve's argument: the shape that no closed form has.
//!
//! An outer curve is g(z), z = k (ϑ − centre), falling from 1 to 0. Deformed it is g(w(z)) with w(0) = 0 and
//! dw/dz = exp(s(z)), so w rises wherever s leads and g(w(z)) stays monotone without any bound on the coefficients. s is
//! linear between nodes at z = ±2 and ±4 (where the logistic curve has 88 and 12, 98 and 2 % martensite), constant
//! beyond them and 0 at z = 0: centre and steepness keep their meaning there, and are not told a second time.

/// Where the log-slopes are given, besides the 0 at z = 0.
const NODES: [f64; 4] = [-4.0, -2.0, 2.0, 4.0];

/// Largest log-slope a warp follows; the catalogue's ranges are well inside.
const LIMIT: f64 = 20.0;

/// ln(dw/dz) at z = −4, −2, 2 and 4, dimensionless. All 0 is the curve as it was.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Warp {
    /// Where all but 2 % is martensite.
    pub cold_tail: f64,
    /// Where an eighth has become austenite.
    pub cold_shoulder: f64,
    /// Where an eighth is martensite.
    pub hot_shoulder: f64,
    /// Where 2 % is martensite.
    pub hot_tail: f64,
}

/// A warped argument and how fast it moves with the argument.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Warped {
    pub(crate) z: f64,
    pub(crate) slope: f64,
}

impl Warp {
    /// Whether it leaves the curve as it was.
    pub fn is_null(&self) -> bool {
        *self == Warp::default()
    }

    /// w(z) and dw/dz.
    pub(crate) fn at(&self, z: f64) -> Warped {
        // both sides run outwards from 0: the cold one is the hot one mirrored
        let (shoulder, tail) =
            if z < 0.0 { (self.cold_shoulder, self.cold_tail) } else { (self.hot_shoulder, self.hot_tail) };
        let (shoulder, tail) = (shoulder.clamp(-LIMIT, LIMIT), tail.clamp(-LIMIT, LIMIT));
        let out = z.abs();
        let (near, far) = (NODES[2], NODES[3]);
        let (length, log_slope) = if out <= near {
            let s = shoulder * out / near;
            (rise(0.0, s, out), s)
        } else {
            let to_near = rise(0.0, shoulder, near);
            if out <= far {
                let s = shoulder + (tail - shoulder) * (out - near) / (far - near);
                (to_near + rise(shoulder, s, out - near), s)
            } else {
                (to_near + rise(shoulder, tail, far - near) + tail.exp() * (out - far), tail)
            }
        };
        Warped { z: length.copysign(z), slope: log_slope.exp() }
    }
}

/// ∫ exp(s) over `length` while s runs in a straight line from `from` to `to`.
fn rise(from: f64, to: f64, length: f64) -> f64 {
    let d = to - from;
    // (e^d − 1)/d, by its series where the quotient has no digits
    let mean = if d.abs() > 1e-5 { d.exp_m1() / d } else { 1.0 + d * (0.5 + d / 6.0) };
    length * from.exp() * mean
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn no_deformation_is_the_argument() {
        for i in -200..=200 {
            let z = 0.1 * f64::from(i);
            let warped = Warp::default().at(z);
            assert!((warped.z - z).abs() < 1e-13 && warped.slope == 1.0, "{z}: {warped:?}");
        }
    }

    proptest! {
        #[test]
        fn it_rises_is_continuous_and_its_slope_is_the_derivative(
            s in prop::array::uniform4(-2.0f64..2.0),
            z in -12.0f64..12.0,
        ) {
            let warp = Warp { cold_tail: s[0], cold_shoulder: s[1], hot_shoulder: s[2], hot_tail: s[3] };
            let d = 1e-5;
            let (below, above) = (warp.at(z - d), warp.at(z + d));
            prop_assert!(above.z > below.z);
            let measured = (above.z - below.z) / (2.0 * d);
            prop_assert!((measured / warp.at(z).slope - 1.0).abs() < 1e-4, "{measured} {:?}", warp.at(z));
            prop_assert!(warp.at(0.0).z == 0.0 && warp.at(0.0).slope == 1.0);
            for (node, log_slope) in NODES.into_iter().zip(s) {
                prop_assert!((warp.at(node).slope.ln() - log_slope).abs() < 1e-12);
            }
        }
    }
}
