//! A leg of three joints: an upright axis at the hip (coxa), a level one beside it (femur), a level one at the knee (tibia).
//!
//! With a, b and φ the angles of coxa (ahead), femur (up) and tibia (from the horizontal, outwards), and r how far the foot is outside of the hip:
//!
//! ```text
//! r = l_c + l_f cos b + l_t cos φ        foot = hip + (r sin a, ± r cos a, l_f sin b + l_t sin φ)
//! ```
//!
//! A force on the foot turns each joint by τ = (∂foot/∂q) · F.

use std::f64::consts::FRAC_PI_2;

use sinew_rig::Demonstrator;

use crate::space::{Vector, dot, sum};

/// Legs of a hexapod, front left, front right, middle left, middle right, rear left, rear right.
pub(crate) const LEGS: usize = 6;
/// Joints of a leg.
pub(crate) const JOINTS: usize = 3;

/// One leg.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Leg {
    hip_m: Vector,
    /// 1 at the left, −1 at the right.
    side: f64,
    lengths_m: [f64; JOINTS],
    /// Of femur and tibia with their joints where their angle is zero.
    level_rad: [f64; 2],
}

/// Where its parts end, m, in the body's own directions from its middle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Parts {
    pub hip: Vector,
    /// Where the femur begins.
    pub coxa: Vector,
    pub knee: Vector,
    pub foot: Vector,
}

impl Leg {
    /// The legs of a rig file.
    pub fn all(declared: &Demonstrator) -> [Leg; LEGS] {
        std::array::from_fn(|leg| {
            let (row, side) = ((leg / 2) as f64, if leg.is_multiple_of(2) { 1.0 } else { -1.0 });
            Leg {
                hip_m: [(1.0 - row) * declared.leg_spacing_m, side * 0.5 * declared.hip_width_m, 0.0],
                side,
                lengths_m: [declared.coxa_m, declared.femur_m, declared.tibia_m],
                level_rad: [declared.femur_rad, declared.tibia_rad - FRAC_PI_2],
            }
        })
    }

    /// Angles of femur and tibia from the horizontal, rad.
    fn raised(&self, [_, femur, tibia]: [f64; JOINTS]) -> [f64; 2] {
        [self.level_rad[0] + femur, self.level_rad[1] + femur + tibia]
    }

    /// Where a point is that is so far outside of the hip and above it, m.
    fn place(&self, coxa_rad: f64, out_m: f64, up_m: f64) -> Vector {
        sum(self.hip_m, [out_m * coxa_rad.sin(), self.side * out_m * coxa_rad.cos(), up_m])
    }

    /// Where it is with its joints at these angles, rad.
    pub fn parts(&self, angles_rad: [f64; JOINTS]) -> Parts {
        let [coxa, femur, tibia] = self.lengths_m;
        let [b, phi] = self.raised(angles_rad);
        let knee = [coxa + femur * b.cos(), femur * b.sin()];
        let place = |[out, up]: [f64; 2]| self.place(angles_rad[0], out, up);
        Parts {
            hip: self.hip_m,
            coxa: place([coxa, 0.0]),
            knee: place(knee),
            foot: place([knee[0] + tibia * phi.cos(), knee[1] + tibia * phi.sin()]),
        }
    }

    /// How far its foot is from the hip's upright axis, and from the femur's, m.
    pub fn reach_m(&self, angles_rad: [f64; JOINTS]) -> [f64; 2] {
        let [b, phi] = self.raised(angles_rad);
        let beside = self.lengths_m[1] * b.cos() + self.lengths_m[2] * phi.cos();
        [self.lengths_m[0] + beside, beside]
    }

    /// How a force on its foot, N, in the body's own directions, turns its joints, N m.
    pub fn torques_n_m(&self, angles_rad: [f64; JOINTS], force_n: Vector) -> [f64; JOINTS] {
        let [b, phi] = self.raised(angles_rad);
        let [coxa, femur, tibia] = self.lengths_m;
        let tibia = [tibia * phi.cos(), tibia * phi.sin()];
        let beside = [femur * b.cos() + tibia[0], femur * b.sin() + tibia[1]];
        let (sin, cos) = angles_rad[0].sin_cos();
        let out_m = coxa + beside[0];
        // a rod that turns up goes inwards by as much as it is high, and up by as much as it reaches out
        let turning = |[out, up]: [f64; 2]| dot([-up * sin, -self.side * up * cos, out], force_n);
        [dot([out_m * cos, -self.side * out_m * sin, 0.0], force_n), turning(beside), turning(tibia)]
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::declared;
    use super::*;
    use crate::space::difference;

    #[test]
    fn straight_out_its_foot_is_where_one_reckons_it() {
        let legs = Leg::all(&declared());
        let [b, c] = [20.0_f64.to_radians(), 10.0_f64.to_radians()];
        let out = 0.012 + 0.03 * b.cos() + 0.05 * c.sin();
        let up = 0.03 * b.sin() - 0.05 * c.cos();
        for (leg, hip) in legs.iter().zip([[0.06, 0.025], [0.06, -0.025], [0.0, 0.025_f64]]) {
            let Parts { foot, .. } = leg.parts([0.0; JOINTS]);
            let exact = [hip[0], hip[1] + hip[1].signum() * out, up];
            assert!((0..3).all(|axis| (foot[axis] - exact[axis]).abs() < 1e-12), "{foot:?} {exact:?}");
        }
        assert!(
            legs[1].parts([0.2, 0.0, 0.0]).foot[0] > 0.06,
            "a shorter coxa's wire brings a leg forward, at the right"
        );
        assert!(legs[0].parts([0.2, 0.0, 0.0]).foot[0] > 0.06, "and at the left");
        assert!(legs[0].parts([0.0, 0.2, 0.0]).foot[2] > up, "a shorter femur's lifts it");
    }

    #[test]
    fn what_a_force_does_at_the_joints_is_the_work_it_does_at_the_foot() {
        let force = [0.1, -0.2, 0.4];
        let angles = [0.2, -0.1, 0.15];
        for leg in Leg::all(&declared()) {
            let torques = leg.torques_n_m(angles, force);
            for joint in 0..JOINTS {
                let moved = |by: f64| {
                    let mut angles = angles;
                    angles[joint] += by;
                    leg.parts(angles).foot
                };
                let work = dot(force, difference(moved(1e-6), moved(-1e-6))) / 2e-6;
                assert!((work - torques[joint]).abs() < 1e-9, "joint {joint}: {work} {}", torques[joint]);
            }
        }
    }
}
