//! The default bandwidth λ of the sliding surface, from what the wire can do.

use crate::wire_map::WireMap;
use sinew_physics::WireModel;

/// Share of the least limit that the default λ uses.
pub const MARGIN: f64 = 0.75;

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

pub(crate) fn limits(m: &WireMap, max_power: f64) -> Lambda {
    let stress = m.stress(0.5 * m.length * m.strain, 0.0);
    let shift = stress * m.shift;
    let per_latent = m.latent + m.area * m.length * stress * m.strain;
    // Speed per watt at the worst slope of the transformation, ξ = 1/2 (eq. 69 without the load's dynamics).
    let speed = |width: f64, power: f64| {
        let slope = 0.25 / width;
        let stroke_per_k = m.length * (m.strain + (m.compliance_m - m.compliance_a) * stress) * slope;
        power.max(0.0) * stroke_per_k / (m.heat_capacity + per_latent * slope)
    };
    let hot = m.heating_centre + shift;
    let cold = m.cooling_centre + shift;
    let heating = speed(m.heating_width, max_power - m.loss * (hot - m.ambient));
    let cooling = speed(m.cooling_width, m.loss * (cold - m.ambient));
    let stroke = (m.length * (m.strain + (m.compliance_m - m.compliance_a) * stress)).max(1e-9);
    // Fastest point of a critically damped step over the whole stroke: λ S/e.
    let e = std::f64::consts::E;
    let stiffness = m.spring + m.area / (m.compliance_m * m.length);
    let mechanical = if m.load_known && m.mass > 0.0 {
        let half = 0.5 * m.damping / m.mass;
        let square = half * half - stiffness / m.mass;
        let slowest = if square > 0.0 { stiffness / m.mass / (half + square.sqrt()) } else { half.max(1e-3) };
        slowest / 3.0
    } else {
        1e3
    };
    let (heating, cooling) = (e * heating / stroke, e * cooling / stroke);
    // a supply too weak to transform the wire still gets a λ it can be run with
    let floor = 0.1 * m.loss / m.heat_capacity;
    let value = (MARGIN * heating.min(mechanical)).clamp(floor.clamp(1e-3, 1.0), 1e3);
    Lambda { value, heating_limit: heating, cooling_limit: cooling, mechanical_limit: mechanical }
}
