//! An arm of two links in a plane, with a camera at its tip that looks along the second.
//!
//! It weighs next to nothing, or nothing pulls it down (chapter 12's is made for a satellite): each wire turns its joint against the joint's own
//! spring, inertia and friction, and the links do not drive each other.

use sinew_rig::Demonstrator;

/// Links and where their joints stand at level strokes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Links {
    lengths_m: [f64; 2],
    level_rad: [f64; 2],
}

/// Where an arm ends.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Tip {
    /// The elbow, from the shoulder, m.
    pub elbow_m: [f64; 2],
    /// The camera, from the shoulder, m.
    pub at_m: [f64; 2],
    /// Where it looks, rad.
    pub looks_rad: f64,
}

impl Links {
    pub fn of(declared: &Demonstrator) -> Links {
        Links {
            lengths_m: [declared.upper_link_m, declared.lower_link_m],
            level_rad: [declared.shoulder_rad, declared.elbow_rad],
        }
    }

    /// How far it reaches, m.
    pub fn reach_m(&self) -> f64 {
        self.lengths_m[0] + self.lengths_m[1]
    }

    /// Where it ends with its joints turned by these angles from level, rad.
    pub fn tip(&self, angles_rad: [f64; 2]) -> Tip {
        let upper = self.level_rad[0] + angles_rad[0];
        let looks_rad = upper + self.level_rad[1] + angles_rad[1];
        let elbow_m = [self.lengths_m[0] * upper.cos(), self.lengths_m[0] * upper.sin()];
        let at_m = [elbow_m[0] + self.lengths_m[1] * looks_rad.cos(), elbow_m[1] + self.lengths_m[1] * looks_rad.sin()];
        Tip { elbow_m, at_m, looks_rad }
    }
}

impl Tip {
    /// From the camera to a place, m: to its right, and ahead.
    pub fn sees(&self, place_m: [f64; 2]) -> [f64; 2] {
        let [x, y] = [place_m[0] - self.at_m[0], place_m[1] - self.at_m[1]];
        let (sin, cos) = self.looks_rad.sin_cos();
        [x * sin - y * cos, x * cos + y * sin]
    }

    /// From the camera to a place, m.
    pub fn distance_m(&self, place_m: [f64; 2]) -> f64 {
        (place_m[0] - self.at_m[0]).hypot(place_m[1] - self.at_m[1])
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::FRAC_PI_2;

    use super::*;

    const LINKS: Links = Links { lengths_m: [0.15, 0.1], level_rad: [FRAC_PI_2, -FRAC_PI_2] };

    #[test]
    fn bent_at_a_right_angle_it_is_where_one_sees_it() {
        let tip = LINKS.tip([0.0, 0.0]);
        let near = |a: [f64; 2], b: [f64; 2]| (a[0] - b[0]).hypot(a[1] - b[1]) < 1e-12;
        assert!(near(tip.elbow_m, [0.0, 0.15]) && near(tip.at_m, [0.1, 0.15]), "{tip:?}");
        // it looks to the right: what is above it is at its left
        assert!(near(tip.sees([0.1, 0.17]), [-0.02, 0.0]) && near(tip.sees([0.14, 0.15]), [0.0, 0.04]));
        assert!((LINKS.tip([-FRAC_PI_2, FRAC_PI_2]).at_m[0] - LINKS.reach_m()).abs() < 1e-12, "stretched");
    }

    #[test]
    fn turning_the_camera_turns_what_it_sees_and_not_how_far_it_is() {
        let place = [0.2, 0.05];
        for step in 0..20 {
            let tip = LINKS.tip([0.05 * f64::from(step), -0.08 * f64::from(step)]);
            let [right, ahead] = tip.sees(place);
            assert!((right.hypot(ahead) - tip.distance_m(place)).abs() < 1e-12);
        }
    }
}
