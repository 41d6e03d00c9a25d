//! What other wires of a rig do to one: the heat of the wire beside it, and the supply that sags under all of them.

use crate::model::WireModel;
use crate::signals::Inputs;
use crate::step::Wire;

/// What other wires do to a wire during a step, through its own effects: with none of these it is alone.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Surroundings {
    /// Temperature of the wire beside it, for `thermal.neighbour`, in °C; `None` where nobody says: ambient.
    pub neighbour_c: Option<f64>,
    /// What others draw through the source resistance of `electrical.supply_sag` on the mean over this wire's on-phase,
    /// in A: a sum of [`drawn_meanwhile_a`].
    pub others_a: f64,
}

impl Surroundings {
    /// Inputs of a wire of this model among the others: what they draw lowers its supply.
    pub fn acting_on(&self, model: &WireModel, inputs: Inputs) -> Inputs {
        let sag_v = model.effects.electrical.supply_sag.source_ohm * self.others_a;
        Inputs { supply_v: inputs.supply_v - sag_v, ..inputs }
    }

    /// Lets a wire know how warm the one beside it is.
    pub fn warm(&self, wire: &mut Wire) {
        if let Some(neighbour_c) = self.neighbour_c {
            wire.set_neighbour_c(neighbour_c);
        }
    }
}

/// What another wire that draws `current_a` in its on-phase draws on the mean over this wire's on-phase, in A. Both are
/// at the end of one PWM period: the shorter on-phase lies within the longer. 0 for a wire that has none itself.
pub fn drawn_meanwhile_a(own_duty: f64, duty: f64, current_a: f64) -> f64 {
    if own_duty > 0.0 { current_a * (duty / own_duty).clamp(0.0, 1.0) } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_shorter_on_phase_lies_within_the_longer() {
        assert_eq!(drawn_meanwhile_a(0.2, 0.5, 0.3), 0.3, "on all the while");
        assert!((drawn_meanwhile_a(0.5, 0.2, 0.3) - 0.12).abs() < 1e-12, "on for two fifths of it");
        assert_eq!(drawn_meanwhile_a(0.0, 0.5, 0.3), 0.0, "no on-phase to sag in");
        assert_eq!(drawn_meanwhile_a(0.5, 0.0, 0.3), 0.0, "nothing drawn");
    }
}
