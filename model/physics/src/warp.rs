//! A smooth monotone deformation of an outer curve's argument: the shape that no closed form has.
//!
//! An outer curve is g(z), z = k (ϑ − centre), falling from 1 to 0. Deformed it is g(w(z)) with w(0) = 0 and
//! dw/dz = exp(s(z)), so w rises wherever s leads and g(w(z)) stays monotone without any bound on the coefficients. s is
//! linear between nodes at z = ±1, ±2 and ±4 (where the logistic curve has 73 and 27, 88 and 12, 98 and 2 % martensite),
//! constant beyond them and 0 at z = 0: centre and steepness keep their meaning there, and are not told a second time.

/// Where the log-slopes are given, to either side of the 0 at z = 0.
const NODES: [f64; 3] = [1.0, 2.0, 4.0];

/// Largest log-slope a warp follows; the catalogue's ranges are well inside.
const LIMIT: f64 = 20.0;

/// ln(dw/dz), dimensionless. All 0 is the curve as it was.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Warp {
    /// z < 0, where there is more martensite.
    pub cold: Side,
    /// z > 0, where there is more austenite.
    pub hot: Side,
}

/// ln(dw/dz) on one side of the centre.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Side {
    /// At |z| = 1, where a quarter is left to transform, or has transformed.
    pub knee: f64,
    /// At |z| = 2: an eighth.
    pub shoulder: f64,
    /// At |z| = 4: 2 %.
    pub tail: f64,
}

/// A warp made ready to be followed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Warped {
    cold: Run,
    hot: Run,
}

/// One side of it, outwards: ln(dw/dz), dw/dz and w at 0 and at every node.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Run {
    log_slope: [f64; 4],
    slope: [f64; 4],
    w: [f64; 4],
}

/// A warped argument and how fast it moves with the argument.
#[derive(Debug, Clone, Copy)]
pub(crate) struct At {
    pub(crate) z: f64,
    pub(crate) slope: f64,
}

impl Warp {
    /// Ready to be followed; `None` where it leaves the curve as it was.
    pub(crate) fn ready(&self) -> Option<Warped> {
        (*self != Warp::default()).then(|| Warped { cold: self.cold.run(), hot: self.hot.run() })
    }
}

impl Side {
    fn run(&self) -> Run {
        let log_slope = [0.0, self.knee, self.shoulder, self.tail].map(|s| s.clamp(-LIMIT, LIMIT));
        let slope = log_slope.map(f64::exp);
        let mut run = Run { log_slope, slope, w: [0.0; 4] };
        let mut before = 0.0;
        for (i, node) in NODES.into_iter().enumerate() {
            let d = log_slope[i + 1] - log_slope[i];
            run.w[i + 1] = run.w[i] + slope[i] * mean_growth(d, d.exp()) * (node - before);
            before = node;
        }
        run
    }
}

impl Run {
    fn at(&self, out: f64) -> At {
        let [knee, shoulder, tail] = NODES;
        let (i, from, length) = match out {
            _ if out >= tail => return At { z: self.w[3] + self.slope[3] * (out - tail), slope: self.slope[3] },
            _ if out >= shoulder => (2, shoulder, tail - shoulder),
            _ if out >= knee => (1, knee, shoulder - knee),
            _ => (0, 0.0, knee),
        };
        let along = out - from;
        let d = (self.log_slope[i + 1] - self.log_slope[i]) * along / length;
        let grown = d.exp();
        At { z: self.w[i] + self.slope[i] * mean_growth(d, grown) * along, slope: self.slope[i] * grown }
    }
}

impl Warped {
    /// w(z) and dw/dz.
    pub(crate) fn at(&self, z: f64) -> At {
        // both sides run outwards from 0: the cold one is the hot one mirrored
        let at = if z < 0.0 { self.cold.at(-z) } else { self.hot.at(z) };
        At { z: at.z.copysign(z), ..at }
    }
}

/// (e^d − 1)/d, by its series where the quotient has few digits; `grown` is e^d.
fn mean_growth(d: f64, grown: f64) -> f64 {
    if d.abs() > 1e-3 { (grown - 1.0) / d } else { 1.0 + d * (0.5 + d * (1.0 / 6.0 + d / 24.0)) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn no_deformation_is_the_argument() {
        assert_eq!(Warp::default().ready(), None);
        let warped = Warped { cold: Side::default().run(), hot: Side::default().run() };
        for i in -200..=200 {
            let z = 0.1 * f64::from(i);
            let at = warped.at(z);
            assert!((at.z - z).abs() < 1e-13 && at.slope == 1.0, "{z}: {at:?}");
        }
    }

    proptest! {
        #[test]
        fn it_rises_is_continuous_and_its_slope_is_the_derivative(
            s in prop::array::uniform6(-2.0f64..2.0),
            z in -12.0f64..12.0,
        ) {
            let cold = Side { knee: s[0], shoulder: s[1], tail: s[2] };
            let hot = Side { knee: s[3], shoulder: s[4], tail: s[5] };
            let warp = Warp { cold, hot }.ready().expect("a warp");
            let d = 1e-5;
            let (below, above) = (warp.at(z - d), warp.at(z + d));
            prop_assert!(above.z > below.z);
            let measured = (above.z - below.z) / (2.0 * d);
            prop_assert!((measured / warp.at(z).slope - 1.0).abs() < 1e-4, "{measured} {:?}", warp.at(z));
            prop_assert!(warp.at(0.0).z == 0.0 && warp.at(0.0).slope == 1.0);
            for (k, node) in NODES.into_iter().enumerate() {
                prop_assert!((warp.at(-node).slope.ln() - s[k]).abs() < 1e-12);
                prop_assert!((warp.at(node).slope.ln() - s[3 + k]).abs() < 1e-12);
            }
        }
    }
}
