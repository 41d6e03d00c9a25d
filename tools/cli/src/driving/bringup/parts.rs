//! The values of the parts around a wire: what `sinew bringup --parts` and `sinew design --board` print.

use std::fmt::Write as _;

use sinew_control::StrokeRange;
use sinew_physics::{Wire, WireModel};
use sinew_rig::Rig;

/// Resistors one has at hand, E12.
const E12: [f64; 12] = [1.0, 1.2, 1.5, 1.8, 2.2, 2.7, 3.3, 3.9, 4.7, 5.6, 6.8, 8.2];
/// Volts of a shunt at full current that a converter reads well, and what a shunt may take of the supply.
const SHUNT_V: f64 = 0.25;
const SHUNT_SHARE: f64 = 0.1;
/// A resistor is chosen for so many times the power it has to bear.
const COOL: f64 = 2.0;

/// For every channel of a rig.
///
/// # Errors
/// Why the physics does not accept a wire.
pub fn parts(rig: &Rig) -> Result<String, sinew_physics::Error> {
    let mut text = String::new();
    for (place, channel) in rig.channels.iter().enumerate() {
        let model = &rig.nominal_model(place);
        let drive = &model.drive;
        let (cold_ohm, stroke) = (Wire::new(model)?.resistance_ohm(), StrokeRange::of(model)?);
        let least_ohm = model.geometry.resistance_ohm(model.material.least_resistivity());
        let full_a = drive.supply_v / (least_ohm + model.outside_ohm());
        let dummy = dummy_ohm(cold_ohm);
        let dummy_w = dummy_w(model, dummy);
        // writing to a String cannot fail
        let _ = writeln!(
            text,
            "{}: {:.3} mm, {:.1} mm when cold, {cold_ohm:.2} Ω cold, at {} V up to {full_a:.3} A",
            channel.name,
            model.geometry.diameter_m * 1e3,
            stroke.cold_m * 1e3,
            drive.supply_v
        );
        let shunt = near(SHUNT_V.min(SHUNT_SHARE * drive.supply_v) / full_a);
        let is_given = drive.shunt_ohm > 0.0;
        let ohm = if is_given { drive.shunt_ohm } else { shunt };
        let (drop_v, watts) = (full_a * ohm, COOL * full_a * full_a * ohm);
        let whose = if is_given { "as in the rig file".into() } else { format!("E12; shunt_ohm = {ohm}") };
        let _ = writeln!(
            text,
            "  shunt                 {ohm} Ω, 1 %, {watts:.2} W or more: {drop_v:.3} V at full current ({whose})"
        );
        if is_given && (drop_v < 0.5 * SHUNT_V || drop_v > 2.0 * SHUNT_SHARE * drive.supply_v) {
            let _ = writeln!(
                text,
                "                        about {shunt} Ω would be better: 0.25 V, a tenth of the supply at the most"
            );
        }
        let _ = writeln!(text, "  resistor for bring-up {dummy} Ω, {dummy_w:.0} W or more, should a stage stick");
        let range_v = channel.adc.voltage_range_v;
        let _ = match range_v > drive.supply_v {
            true => writeln!(text, "  voltage inputs        {range_v} V of range: no divider"),
            false => writeln!(
                text,
                "  voltage inputs        {range_v} V of range: too little for the supply, a divider is needed"
            ),
        };
        let _ = writeln!(
            text,
            "  fuse                  slow, the next above {:.2} A, which it bears for good; {full_a:.2} A in pulses",
            channel.limits.continuous_current_a
        );
    }
    Ok(text)
}

/// Power, W, that a resistor in a wire's place has to bear for good should its stage stick, and stay cool.
pub fn dummy_w(model: &WireModel, ohm: f64) -> f64 {
    COOL * (model.drive.supply_v / (ohm + model.outside_ohm())).powi(2) * ohm
}

/// The resistor that stands for a wire of so many Ω: what one has that is nearest to it.
pub fn dummy_ohm(wire_ohm: f64) -> f64 {
    near(wire_ohm)
}

/// The value of E12 that is nearest.
fn near(value: f64) -> f64 {
    let decade = 10f64.powf(value.log10().floor());
    let all = [0.1, 1.0, 10.0].into_iter().flat_map(|tens| E12.map(|one| one * tens * decade));
    let nearest = all.min_by(|a, b| (a / value).ln().abs().total_cmp(&(b / value).ln().abs()));
    nearest.map_or(value, |one| (one * 1e6).round() / 1e6)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_resistor_is_one_of_e12_near_the_wire() {
        for (wire_ohm, ohm) in [(11.3, 12.0), (10.4, 10.0), (9.2, 10.0), (0.97, 1.0), (57.0, 56.0), (95.0, 100.0)] {
            assert_eq!(dummy_ohm(wire_ohm), ohm, "{wire_ohm}");
            assert!((0.75..1.35).contains(&(dummy_ohm(wire_ohm) / wire_ohm)), "the supervisor takes it for the wire");
        }
    }
}
