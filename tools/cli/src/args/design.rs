//! `sinew design`: a wire from requirements.

use std::path::PathBuf;

use clap::Args;

/// `sinew design`.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  sinew design --force 2N --stroke 6mm
  sinew design --force 2N --stroke 6mm --cycle 2s --supply 6V -o finger.toml
  sinew design --force 500mN --stroke 20mm --span 150mm      no room for a straight wire: with a lever
  sinew design --torque 30mNm --angle 60deg --span 200mm     a joint: with the radius of its pulley
  sinew design --force 2N --stroke 6mm --diameter 0.15mm --json

Sizes every diameter that is sold by the thesis' rules (chapter 2, Table 3: 170 MPa of pull of which 100 MPa
stretch the wire again, 4 % of stroke, conservative for 100 000 cycles), takes the one that needs the fewest
wires, and simulates that one. -o writes it as a rig file that `sinew run`, `tune` and `simulate` take.")]
pub struct Design {
    /// Force on the load, beyond what stretches the wire again: 2N, 500mN.
    #[arg(long = "force", value_parser = force, required_unless_present = "torque_n_m", conflicts_with = "torque_n_m", requires = "stroke_m", allow_negative_numbers = true, value_name = "FORCE")]
    pub force_n: Option<f64>,
    /// How far it moves: 6mm, 2cm.
    #[arg(long = "stroke", value_parser = length, requires = "force_n", allow_negative_numbers = true, value_name = "LENGTH")]
    pub stroke_m: Option<f64>,
    /// Torque on a joint: 30mNm, 0.1Nm.
    #[arg(long = "torque", value_parser = torque, requires_all = ["angle_rad", "span_m"], allow_negative_numbers = true, value_name = "TORQUE")]
    pub torque_n_m: Option<f64>,
    /// How far the joint turns: 60deg, 1rad.
    #[arg(long = "angle", value_parser = angle, requires = "torque_n_m", allow_negative_numbers = true, value_name = "ANGLE")]
    pub angle_rad: Option<f64>,
    /// Room for the wire's length; a longer one gets a lever instead.
    #[arg(long = "span", value_parser = length, allow_negative_numbers = true, value_name = "LENGTH")]
    pub span_m: Option<f64>,
    /// Longest time there and back: 2s.
    #[arg(long = "cycle", value_parser = super::seconds, allow_negative_numbers = true, value_name = "SECONDS")]
    pub cycle_s: Option<f64>,
    /// The supply there is: 6V. Without it, 1.5 times what a wire bears for good.
    #[arg(long = "supply", value_parser = voltage, allow_negative_numbers = true, value_name = "VOLTAGE")]
    pub supply_v: Option<f64>,
    /// How many wires side by side. Without it, as many as it takes.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1000))]
    pub wires: Option<u32>,
    /// This diameter, whether it is sold or not: 0.15mm.
    #[arg(long = "diameter", value_parser = diameter, allow_negative_numbers = true, value_name = "LENGTH")]
    pub diameter_m: Option<f64>,
    /// Where to write one such wire as a rig file; `-` is stdout.
    #[arg(short, long, value_name = "RIG.toml")]
    pub output: Option<PathBuf>,
    /// The answer as JSON on stdout.
    #[arg(long, conflicts_with = "output")]
    pub json: bool,
}

fn force(text: &str) -> Result<f64, String> {
    quantity(text, "force", &[("N", 1.0), ("mN", 1e-3)], 1e-4..=1e4, "2N")
}

fn length(text: &str) -> Result<f64, String> {
    quantity(text, "length", &[("mm", 1e-3), ("cm", 1e-2), ("m", 1.0)], 1e-4..=10.0, "6mm")
}

fn diameter(text: &str) -> Result<f64, String> {
    quantity(text, "diameter", &[("mm", 1e-3), ("um", 1e-6), ("µm", 1e-6)], 1e-5..=2e-3, "0.15mm")
}

fn torque(text: &str) -> Result<f64, String> {
    quantity(text, "torque", &[("Nm", 1.0), ("mNm", 1e-3)], 1e-6..=1e3, "30mNm")
}

fn angle(text: &str) -> Result<f64, String> {
    quantity(text, "angle", &[("deg", 1f64.to_radians()), ("rad", 1.0)], 1e-3..=50.0, "60deg")
}

fn voltage(text: &str) -> Result<f64, String> {
    quantity(text, "voltage", &[("V", 1.0), ("mV", 1e-3)], 0.1..=400.0, "6V")
}

/// A number with one of these units, in SI and within what can be meant.
fn quantity(
    text: &str,
    name: &str,
    units: &[(&str, f64)],
    range: std::ops::RangeInclusive<f64>,
    example: &str,
) -> Result<f64, String> {
    let text = text.trim();
    let digits = text.trim_end_matches(|c: char| c.is_alphabetic()).trim_end();
    let unit = text[digits.len()..].trim_start();
    let known = || units.iter().map(|(unit, _)| *unit).collect::<Vec<_>>().join(", ");
    let Ok(number) = digits.parse::<f64>() else {
        return Err(format!("not a number with a unit; give the {name} as in {example}"));
    };
    let Some((_, factor)) = units.iter().find(|(known, _)| *known == unit) else {
        return Err(format!("a {name} is given in {}, as in {example}", known()));
    };
    let value = number * factor;
    match range.contains(&value) {
        true => Ok(value),
        false => Err(format!(
            "no wire is made for a {name} of {text}: {} to {} {}",
            range.start() / factor,
            range.end() / factor,
            unit
        )),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantities_carry_their_units() {
        for (found, expected) in [
            (force("2N"), 2.0),
            (force("500 mN"), 0.5),
            (length("6mm"), 6e-3),
            (length("2e-2m"), 0.02),
            (diameter("150um"), 150e-6),
            (torque("30mNm"), 0.03),
            (angle("180deg"), std::f64::consts::PI),
            (voltage("6V"), 6.0),
        ] {
            assert!((found.clone().unwrap() - expected).abs() < 1e-12, "{found:?} where {expected} is right");
        }
        for bad in ["2", "N", "", "-2N", "nanN", "infN", "2kg", "1e9N", "2,5N"] {
            assert!(force(bad).is_err(), "{bad}");
        }
    }
}
