//! Where a wire runs on its way to the load (thesis, chapters 5, 6 and 12): straight, to and fro over pulleys, or through a tube that may
//! be bent. Friction is paid twice: the wire has to pull more than it gives to the load, and the load has to pull more than what
//! stretches the far end of the wire again.

use sinew_physics::Material;

use crate::rules::{Allowed, WireRules};

/// Friction of a wire in a tube of PTFE, if nothing else is said (0.04 to 0.1).
pub const TUBE_FRICTION: f64 = 0.05;
/// Share of the tension that a small pulley and its bearing leave.
const BEARING: f64 = 0.97;
/// A tube's bore over the wire's diameter.
pub const TUBE_BORE: f64 = 2.0;
/// Its outer diameter over the wire's.
pub const TUBE_OUTER: f64 = 8.0;
/// Conductivity of its wall (PTFE) and of the air in its gap, W/(m K).
const TUBE_W_PER_M_K: f64 = 0.25;
const AIR_W_PER_M_K: f64 = 0.027;

/// The way of a wire from its fixed end to its load.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Route {
    /// None but the room there is.
    Straight,
    /// So many times through the room, around a pulley at each end of it.
    Pulleys(u32),
    /// Through a tube, which takes the wire out of the way: a Bowden cable.
    Tube {
        /// By how much it is bent in all, rad.
        bent_rad: f64,
        /// Friction of the wire in it.
        friction: f64,
    },
}

impl Route {
    /// What is left at one end of a wire that slides of the tension at its other end, 0..1 (capstan, e^{−µθ}).
    pub fn kept(&self) -> f64 {
        match *self {
            Route::Straight => 1.0,
            Route::Pulleys(passes) => BEARING.powi(passes.saturating_sub(1) as i32),
            Route::Tube { bent_rad, friction } => (-friction * bent_rad).exp(),
        }
    }

    /// Pull on the load of a wire beyond what stretches all of it again, N; negative where friction leaves none: what the wire bears
    /// (eq. 2) less what is lost as it contracts, less its preload (eq. 3) and what is lost as it is stretched.
    pub fn useful_n(&self, wire: &WireRules) -> f64 {
        wire.max_force_n() * self.kept() - self.preload_n(wire)
    }

    /// What the load has to pull with to stretch all of the wire again, N.
    pub fn preload_n(&self, wire: &WireRules) -> f64 {
        wire.preload_n() / self.kept()
    }

    /// How many times the room is as long as the wire in it; `None`: the room is not where the wire is.
    pub fn passes(&self) -> Option<f64> {
        match *self {
            Route::Straight => Some(1.0),
            Route::Pulleys(passes) => Some(f64::from(passes)),
            Route::Tube { .. } => None,
        }
    }

    /// The most passes, or the most that a tube is bent, rad, with which there is something left to pull with.
    pub fn limit(&self, allowed: Allowed) -> f64 {
        // what is kept, squared, is what the preload is of the pull
        let wire = WireRules { allowed, ..WireRules::of(1e-3, 1.0) };
        let least = 0.5 * (wire.max_force_n() / wire.preload_n()).ln();
        match *self {
            Route::Straight => f64::INFINITY,
            Route::Pulleys(_) => 1.0 + (least / -BEARING.ln()).floor(),
            Route::Tube { friction, .. } => least / friction,
        }
    }

    /// How many times a bare wire's loss goes to the air: that of a tube has more surface, behind the air in its gap and its wall. It holds
    /// for moving on and on, when the tube has warmed up.
    pub fn cooling_gain(&self, diameter_m: f64) -> f64 {
        let Route::Tube { .. } = self else { return 1.0 };
        let convection = Material::default().convection_w_per_m2_k;
        let tau = std::f64::consts::TAU;
        // resistances of a metre, K m/W
        let bare = 2.0 / (convection * tau * diameter_m);
        let gap = TUBE_BORE.ln() / (tau * AIR_W_PER_M_K);
        let wall = (TUBE_OUTER / TUBE_BORE).ln() / (tau * TUBE_W_PER_M_K);
        bare / (gap + wall + bare / TUBE_OUTER)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const WIRE: WireRules = WireRules::of(0.125e-3, 0.1);

    /// The whole surface would gain as many times as the tube is thicker; and a thick wire has the surface already.
    #[test]
    fn a_tube_gains_less_than_its_surface() {
        let tube = Route::Tube { bent_rad: 1.0, friction: TUBE_FRICTION };
        let gain = tube.cooling_gain(0.125e-3);
        assert!(gain > 1.5 && gain < TUBE_OUTER, "{gain}");
        assert!(tube.cooling_gain(0.5e-3) < gain);
        assert_eq!(Route::Pulleys(4).cooling_gain(0.125e-3), 1.0);
    }

    /// At the limit of bending nothing is left, short of it something; and of the passes the last one that moves is said.
    #[test]
    fn beyond_its_limit_nothing_moves() {
        let tube = |bent_rad| Route::Tube { bent_rad, friction: 0.08 };
        let limit = tube(1.0).limit(Allowed::TABLE);
        assert!(tube(0.999 * limit).useful_n(&WIRE) > 0.0 && tube(1.001 * limit).useful_n(&WIRE) < 0.0, "{limit}");
        let passes = Route::Pulleys(2).limit(Allowed::TABLE) as u32;
        assert!(Route::Pulleys(passes).useful_n(&WIRE) > 0.0, "{passes}");
        assert!(Route::Pulleys(passes + 1).useful_n(&WIRE) < 0.0, "{passes}");
        assert_eq!(Route::Straight.useful_n(&WIRE), WIRE.useful_force_n());
    }
}
