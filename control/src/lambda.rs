//! The default bandwidth λ of the sliding surface, from what the wire can do.

use crate::wire_map::WireMap;
use sinew_physics::WireModel;
use sinew_physics::formulas::cooling_time_s;

/// Share of the least limit that the default λ uses.
pub const MARGIN: f64 = 0.75;

/// More λ than any wire can use, 1/s.
const MOST: f64 = 1e3;

/// λ and the limits it comes from, all in 1/s.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lambda {
    /// The default: [`MARGIN`] of the least of the heating and the mechanical limit.
    pub value: f64,
    /// Above it, maximum power cannot keep the wire on the surface while it shortens.
    pub heating_limit: f64,
    /// Above it, the air cannot keep the wire on the surface while it lengthens: it cools freely until it is near.
    pub cooling_limit: f64,
    /// Above it, load and wire are too slow to follow.
    pub mechanical_limit: f64,
}

/// λ for a wire heated with at most `max_power_w`.
pub fn default_lambda(model: &WireModel, max_power_w: f64) -> Lambda {
    limits(&WireMap::new(model), max_power_w)
}

/// How fast a wire can move at the worst slope of its transformation, and how far.
pub(crate) struct Speeds {
    /// Shortening under full power, m/s.
    pub heating: f64,
    /// Lengthening in the air, m/s.
    pub cooling: f64,
    /// Between all martensite and all austenite at rest, m.
    pub stroke: f64,
}

/// Eq. 69 without the load's dynamics at ξ = 1/2, where latent heat is most in the way: the phase slope there is k/4, and
/// v = L ε dξ/dT (P − h A_s (T − T_∞)) / (m c_p + H dξ/dT).
pub(crate) fn speeds(m: &WireMap, max_power: f64) -> Speeds {
    let stress = m.stress(0.5 * m.length * m.strain, 0.0);
    let shift = stress * m.shift;
    let stroke = (m.length * (m.strain + (m.compliance_m - m.compliance_a) * stress)).max(1e-9);
    let speed = |width: f64, power: f64| {
        let slope = 0.25 / width;
        power.max(0.0) * stroke * slope / (m.heat_capacity + m.release(stress) * slope)
    };
    Speeds {
        heating: speed(m.heating_width, max_power - m.loss * (m.heating_centre + shift - m.ambient)),
        cooling: speed(m.cooling_width, m.loss * (m.cooling_centre + shift - m.ambient)),
        stroke,
    }
}

/// A third of the bandwidth of load and wire at its softest, 1/s.
pub(crate) fn mechanical_limit(m: &WireMap) -> f64 {
    if !(m.load_known && m.mass > 0.0) {
        return MOST;
    }
    let stiffness = m.spring + m.stiffness(1.0);
    let half = 0.5 * m.damping / m.mass;
    let square = half * half - stiffness / m.mass;
    let slowest = if square > 0.0 {
        stiffness / m.mass / (half + square.sqrt())
    } else {
        // an undamped load still follows its wire, at its natural frequency
        (stiffness / m.mass).sqrt()
    };
    slowest / 3.0
}

pub(crate) fn limits(m: &WireMap, max_power: f64) -> Lambda {
    let speeds = speeds(m, max_power);
    let e = std::f64::consts::E;
    let mechanical = mechanical_limit(m);
    let (heating, cooling) = (e * speeds.heating / speeds.stroke, e * speeds.cooling / speeds.stroke);
    // a supply too weak to transform the wire still gets a λ it can be run with
    let floor = (0.1 / cooling_time_s(m.heat_capacity, m.loss)).clamp(1e-3, 1.0);
    let value = (MARGIN * heating.min(mechanical)).clamp(floor, MOST);
    Lambda { value, heating_limit: heating, cooling_limit: cooling, mechanical_limit: mechanical }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{hanging, wire};
    use sinew_physics::Geometry;

    fn model(diameter_mm: f64, mass_kg: f64, damping: f64) -> WireModel {
        WireModel {
            geometry: Geometry { diameter_m: diameter_mm * 1e-3, length_m: 0.16 },
            load: hanging(mass_kg, damping, 0.0, mass_kg * 9.80665),
            ..wire()
        }
    }

    /// The thesis runs its wire of this size with λ = 10 on 3 W, and finds 1 W too little for it.
    #[test]
    fn agrees_with_the_thesis() {
        let at = |power| default_lambda(&model(0.125, 0.2, 40.0), power);
        assert!((8.0..13.0).contains(&at(3.0).value), "{:?}", at(3.0));
        assert!(at(1.0).heating_limit < 10.0, "{:?}", at(1.0));
        assert!(at(3.0).cooling_limit < at(3.0).heating_limit);
    }

    #[test]
    fn less_power_and_thicker_wires_are_slower() {
        let value = |d: f64, p| default_lambda(&model(d, 0.2, 40.0), p).value;
        assert!(value(0.125, 1.5) < value(0.125, 3.0));
        let cooling = |d: f64| default_lambda(&model(d, 0.2, 40.0), 3.0).cooling_limit;
        assert!(cooling(0.5) < 0.5 * cooling(0.125));
    }

    #[test]
    fn a_slow_load_bounds_it() {
        let lambda = default_lambda(&model(0.125, 20.0, 10.0), 30.0);
        assert!(lambda.mechanical_limit < lambda.heating_limit);
        assert!((lambda.value - MARGIN * lambda.mechanical_limit).abs() < 1e-9, "{lambda:?}");
    }

    #[test]
    fn is_positive_for_any_wire() {
        for diameter in [0.01, 0.1, 1.0, 8.0] {
            for power in [0.0, 1e-3, 1.0, 1e4, f64::NAN] {
                let value = default_lambda(&model(diameter, 0.2, 0.0), power).value;
                assert!(value > 0.0 && value.is_finite(), "{diameter} mm, {power} W: {value}");
            }
        }
    }
}
