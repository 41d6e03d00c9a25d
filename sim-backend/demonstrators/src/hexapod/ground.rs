//! Feet on the ground: springs with a damper, up and along, that hold by friction and slip beyond it.

use crate::space::Vector;

/// What feet stand on, and how they give.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Ground {
    /// Of a foot with its leg, N/m.
    pub stiffness_n_per_m: f64,
    /// Its damper, N s/m.
    pub damping_n_s_per_m: f64,
    pub friction: f64,
}

/// A foot, and where it holds.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Foot {
    /// How high the ground is beneath it, m, once it has come near.
    ground_m: Option<f64>,
    /// Where along the ground its spring is not stretched, m, while it stands.
    held_m: Option<[f64; 2]>,
}

impl Foot {
    /// Whether it stands.
    pub fn stands(&self) -> bool {
        self.held_m.is_some()
    }

    /// The ground's force on it, N, with it at a place and a speed, m and m/s, on a foothold of this height, m, if it has none yet.
    pub fn push_n(
        &mut self,
        ground: &Ground,
        foothold_m: impl FnOnce() -> f64,
        at_m: Vector,
        speed_m_s: Vector,
    ) -> Vector {
        let depth_m = *self.ground_m.get_or_insert_with(foothold_m) - at_m[2];
        if depth_m <= 0.0 {
            self.held_m = None;
            return [0.0; 3];
        }
        let held_m = self.held_m.get_or_insert([at_m[0], at_m[1]]);
        // the ground only pushes, even where the damper would have it pull
        let up_n = (ground.stiffness_n_per_m * depth_m - ground.damping_n_s_per_m * speed_m_s[2]).max(0.0);
        let along_n = [0, 1].map(|axis| {
            -ground.stiffness_n_per_m * (at_m[axis] - held_m[axis]) - ground.damping_n_s_per_m * speed_m_s[axis]
        });
        let (most_n, needed_n) = (ground.friction * up_n, along_n[0].hypot(along_n[1]));
        if needed_n <= most_n {
            return [along_n[0], along_n[1], up_n];
        }
        // it slips: as far as its spring, and no more, is stretched by what friction holds
        let along_n = along_n.map(|force| force * most_n / needed_n);
        *held_m = [0, 1].map(|axis| at_m[axis] + along_n[axis] / ground.stiffness_n_per_m);
        [along_n[0], along_n[1], up_n]
    }

    /// What its springs hold, J, with it at a place, m.
    #[cfg(test)]
    pub fn energy_j(&self, ground: &Ground, at_m: Vector) -> f64 {
        let depth_m = (self.ground_m.unwrap_or(0.0) - at_m[2]).max(0.0);
        let stretched = |held: [f64; 2]| (at_m[0] - held[0]).powi(2) + (at_m[1] - held[1]).powi(2);
        0.5 * ground.stiffness_n_per_m * (depth_m * depth_m + self.held_m.map_or(0.0, stretched))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const GROUND: Ground = Ground { stiffness_n_per_m: 500.0, damping_n_s_per_m: 0.0, friction: 0.5 };

    #[test]
    fn it_holds_within_the_cone_and_slips_on_its_edge() {
        let mut foot = Foot::default();
        // 1 mm deep: 0.5 N, of which friction holds 0.25 N, 0.5 mm of its spring
        assert_eq!(foot.push_n(&GROUND, || 0.0, [0.0, 0.0, -1e-3], [0.0; 3]), [0.0, 0.0, 0.5]);
        let [back, _, up] = foot.push_n(&GROUND, || 0.0, [0.4e-3, 0.0, -1e-3], [0.0; 3]);
        assert!((back + 0.2).abs() < 1e-12 && up == 0.5, "{back}");
        let [back, ..] = foot.push_n(&GROUND, || 0.0, [3e-3, 0.0, -1e-3], [0.0; 3]);
        assert!((back + 0.25).abs() < 1e-12, "{back}");
        // and it stays where it has slipped to: half a millimetre back its spring is slack
        let [back, ..] = foot.push_n(&GROUND, || 0.0, [2.5e-3, 0.0, -1e-3], [0.0; 3]);
        assert!(back.abs() < 1e-12, "{back}");
    }

    #[test]
    fn above_the_ground_nothing_pushes_and_it_takes_hold_anew() {
        let mut foot = Foot::default();
        foot.push_n(&GROUND, || 0.0, [0.0, 0.0, -1e-3], [0.0; 3]);
        assert!(foot.stands());
        assert_eq!(foot.push_n(&GROUND, || 0.0, [0.0, 0.0, 1e-3], [0.0; 3]), [0.0; 3]);
        assert!(!foot.stands());
        assert_eq!(foot.push_n(&GROUND, || 0.0, [0.01, 0.0, -1e-3], [0.0; 3]), [0.0, 0.0, 0.5]);
    }
}
