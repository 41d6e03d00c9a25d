//! `sinew design`: a wire from requirements.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use sinew_design::Allowed;

use crate::args::numbers::{diameter, length, quantity, seconds};

/// `sinew design`.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  sinew design --force 2N --stroke 6mm
  sinew design --force 2N --stroke 6mm --cycle 2s --supply 6V -o finger.toml
  sinew design --force 500mN --stroke 20mm --span 150mm      no room for a straight wire: a lever
  sinew design --force 2N --stroke 6mm --method energy       method A: the least wire, and a lever
  sinew design --torque 30mNm --angle 60deg --span 200mm     a joint, with the radius of its pulley
  sinew design --torque 30mNm --angle 60deg --joint lever --span 80mm
  sinew design --force 1N --stroke 20mm --span 60mm --pulleys 9
  sinew design --force 1N --stroke 20mm --tube 120deg        through a Bowden tube
  sinew design --force 20N --stroke 6mm --wires 6 --in-series 3 --supply 12V
  sinew design --force 5N --stroke 6mm --supply 7.4V --internal 0.1ohm --capacity 850mAh
  sinew design --force 5N --stroke 6mm --supply 12V --most-current 3A
  sinew design --force 2N --stroke 6mm --current 600mA --supply 12V
  sinew design --force 2N --stroke 6mm --diameter 0.15mm --json
  sinew design --force 2N --stroke 6mm --life 1e6            to last a million cycles
  sinew design --force 2N --stroke 6mm --plot compromise.svg
  sinew design --force 800mN --stroke 4mm --mechanisms       what levers, springs, tubes make of it

Sizes every diameter that is sold by the thesis' rules (chapter 2, Table 3: 170 MPa of pull of which
100 MPa stretch the wire again, 4 % of stroke, conservative for 100 000 cycles), predicts what each
will do, and takes the one that needs the fewest wires of those whose prediction meets the demand and
that the driver's supervisor would not hold back. That one is simulated as well. -o writes one such
wire as a rig file that `sinew run`, `tune` and `simulate` take. Where no wire meets the demand, the
nearest demands that can be met are named.")]
pub struct Design {
    /// Force on the load, beyond what stretches the wire again: 2N, 500mN.
    #[arg(long = "force", value_parser = force, required_unless_present = "torque_n_m", conflicts_with = "torque_n_m", requires = "stroke_m", allow_negative_numbers = true, value_name = "FORCE")]
    pub force_n: Option<f64>,
    /// How far it moves: 6mm, 2cm.
    #[arg(long = "stroke", value_parser = length, requires = "force_n", allow_negative_numbers = true, value_name = "LENGTH")]
    pub stroke_m: Option<f64>,
    /// Torque on a joint: 30mNm, 0.1Nm.
    #[arg(long = "torque", value_parser = torque, requires = "angle_rad", allow_negative_numbers = true, value_name = "TORQUE")]
    pub torque_n_m: Option<f64>,
    /// How far the joint turns: 60deg, 1rad.
    #[arg(long = "angle", value_parser = angle, requires = "torque_n_m", allow_negative_numbers = true, value_name = "ANGLE")]
    pub angle_rad: Option<f64>,
    /// How a joint's wire is fixed. Without it, a pulley where that bends the wire no more than it bears, else a lever.
    #[arg(long, requires = "torque_n_m", value_name = "KIND")]
    pub joint: Option<Joint>,
    /// The thesis' method: A by energy, with a lever for the rest; B by force and stroke, with none. Without it, by stroke
    /// where --span has room for that, else by energy.
    #[arg(long, value_name = "METHOD")]
    pub method: Option<Method>,
    /// Room for the wire's length; a longer one gets a lever instead. A joint without it gets the shortest wire that
    /// does the work.
    #[arg(long = "span", value_parser = length, allow_negative_numbers = true, value_name = "LENGTH")]
    pub span_m: Option<f64>,
    /// Leads each wire so many times through --span, around pulleys.
    #[arg(long, value_name = "PASSES", value_parser = clap::value_parser!(u32).range(2..=100), requires = "span_m", conflicts_with = "tube_rad")]
    pub pulleys: Option<u32>,
    /// Leads each wire through a tube that is bent by so much in all, a Bowden cable: 90deg. It needs no room, loses
    /// force by friction and cools faster.
    #[arg(long = "tube", value_parser = bend, allow_negative_numbers = true, value_name = "ANGLE")]
    pub tube_rad: Option<f64>,
    /// Friction of the wire in the tube. Without it, 0.05, as of PTFE.
    #[arg(long, value_name = "MU", value_parser = friction, requires = "tube_rad", allow_negative_numbers = true)]
    pub friction: Option<f64>,
    /// Longest time there and back, as predicted: 2s.
    #[arg(long = "cycle", value_parser = seconds, allow_negative_numbers = true, value_name = "SECONDS")]
    pub cycle_s: Option<f64>,
    /// The supply there is: 6V. Without it, 1.5 times what a wire bears for good, at most 60 V.
    #[arg(long = "supply", value_parser = voltage, allow_negative_numbers = true, value_name = "VOLTAGE")]
    pub supply_v: Option<f64>,
    /// A current source of so much, in place of a voltage; --supply is then the most voltage it has: 600mA.
    #[arg(long = "current", value_parser = current, conflicts_with_all = ["internal_ohm"], allow_negative_numbers = true, value_name = "CURRENT")]
    pub current_a: Option<f64>,
    /// The most current that supply or battery give: 3A.
    #[arg(long = "most-current", value_parser = current, allow_negative_numbers = true, value_name = "CURRENT")]
    pub most_current_a: Option<f64>,
    /// Resistance inside supply or battery, and of its leads: 0.1ohm.
    #[arg(long = "internal", value_parser = resistance, requires = "supply_v", allow_negative_numbers = true, value_name = "RESISTANCE")]
    pub internal_ohm: Option<f64>,
    /// What a battery holds: 850mAh. Says how long it lasts.
    #[arg(long = "capacity", value_parser = capacity, allow_negative_numbers = true, value_name = "CHARGE")]
    pub capacity_c: Option<f64>,
    /// How many wires side by side. Without it, as many as it takes.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1000))]
    pub wires: Option<u32>,
    /// How many of them the current runs through one after the other: a zig-zag. Without it, what suits --supply.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1000))]
    pub in_series: Option<u32>,
    /// Air, °C.
    #[arg(long = "ambient", value_name = "CELSIUS", value_parser = air, default_value = "25", allow_negative_numbers = true)]
    pub ambient_c: f64,
    /// How many cycles nearly every such wire is to last: 1e6. Less stress and strain are taken for it, by the law of docs/life.md. Without
    /// it, the rules' 100 000.
    #[arg(long = "life", value_name = "CYCLES", value_parser = life, allow_negative_numbers = true)]
    pub life_cycles: Option<f64>,
    /// This diameter, whether it is sold or not: 0.15mm.
    #[arg(long = "diameter", value_parser = diameter, allow_negative_numbers = true, value_name = "LENGTH")]
    pub diameter_m: Option<f64>,
    /// The values of the parts around the chosen wire on a board: shunt, fuse, the resistor that stands for it in a bring-up.
    #[arg(long, conflicts_with = "json")]
    pub board: bool,
    /// What the mechanisms of the thesis' chapter 5 make of the chosen wire (fig. 51): strain, force, speed, cost, parts.
    #[arg(long)]
    pub mechanisms: bool,
    /// Where to write force against bandwidth over the diameter (fig. 69) as a picture.
    #[arg(long, value_name = "FILE.svg")]
    pub plot: Option<PathBuf>,
    /// Where to write one such wire as a rig file; `-` is stdout.
    #[arg(short, long, value_name = "RIG.toml")]
    pub output: Option<PathBuf>,
    /// The answer as JSON on stdout.
    #[arg(long, conflicts_with = "output")]
    pub json: bool,
}

/// How a joint's wire is fixed to it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Joint {
    /// Wound around a pulley
    Pulley,
    /// Fixed to a lever
    Lever,
}

/// The thesis' methods.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Method {
    /// By energy and speed (A)
    #[value(alias = "a", alias = "A")]
    Energy,
    /// By force and stroke (B)
    #[value(alias = "b", alias = "B")]
    Stroke,
}

fn force(text: &str) -> Result<f64, String> {
    quantity(text, "force", &[("N", 1.0), ("mN", 1e-3)], 1e-4..=1e4, "2N")
}

fn torque(text: &str) -> Result<f64, String> {
    quantity(text, "torque", &[("Nm", 1.0), ("mNm", 1e-3)], 1e-6..=1e3, "30mNm")
}

fn angle(text: &str) -> Result<f64, String> {
    quantity(text, "angle", &[("deg", 1f64.to_radians()), ("rad", 1.0)], 1e-3..=50.0, "60deg")
}

fn bend(text: &str) -> Result<f64, String> {
    quantity(text, "bend", &[("deg", 1f64.to_radians()), ("rad", 1.0)], 0.0..=50.0, "90deg")
}

fn friction(text: &str) -> Result<f64, String> {
    match text.trim().parse::<f64>() {
        Ok(friction) if (0.001..=1.0).contains(&friction) => Ok(friction),
        _ => Err("friction is a number from 0.001 to 1, as in 0.05".into()),
    }
}

fn voltage(text: &str) -> Result<f64, String> {
    quantity(text, "voltage", &[("V", 1.0), ("mV", 1e-3)], 0.1..=400.0, "6V")
}

fn current(text: &str) -> Result<f64, String> {
    quantity(text, "current", &[("A", 1.0), ("mA", 1e-3)], 1e-3..=1e3, "600mA")
}

fn resistance(text: &str) -> Result<f64, String> {
    quantity(text, "resistance", &[("ohm", 1.0), ("mohm", 1e-3), ("Ω", 1.0), ("mΩ", 1e-3)], 0.0..=1e3, "0.1ohm")
}

fn capacity(text: &str) -> Result<f64, String> {
    quantity(text, "charge", &[("Ah", 3600.0), ("mAh", 3.6)], 1e-2..=1e7, "850mAh")
}

/// Cycles that a wire can be designed for.
fn life(text: &str) -> Result<f64, String> {
    let most = Allowed::most_cycles();
    match text.trim().parse::<f64>() {
        Ok(cycles) if cycles >= 1.0 && cycles <= most => Ok(cycles),
        Ok(cycles) if cycles > most => Err(format!(
            "not every wire lasts that, however little it is strained: at most {most:.1e} cycles can be asked for"
        )),
        _ => Err("a life is a number of cycles, as in 1e6".into()),
    }
}

/// Air a wire can cool down in, °C.
fn air(text: &str) -> Result<f64, String> {
    match text.trim().trim_end_matches("°C").trim_end_matches('C').trim().parse::<f64>() {
        Ok(celsius) if (-60.0..=150.0).contains(&celsius) => Ok(celsius),
        Ok(_) => Err("no wire works in that air: -60 to 150 °C".into()),
        Err(_) => Err("give the air's temperature in °C, as in 25".into()),
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
            (current("600mA"), 0.6),
            (resistance("0.1ohm"), 0.1),
            (capacity("850mAh"), 3060.0),
            (life("1e6"), 1e6),
            (air("-5"), -5.0),
            (air("40C"), 40.0),
        ] {
            assert!((found.clone().unwrap() - expected).abs() < 1e-12, "{found:?} where {expected} is right");
        }
        for bad in ["2", "N", "", "-2N", "nanN", "infN", "2kg", "1e9N", "2,5N"] {
            assert!(force(bad).is_err(), "{bad}");
        }
        for bad in ["", "nan", "inf", "400"] {
            assert!(air(bad).is_err(), "{bad}");
        }
        for bad in ["", "nan", "inf", "0", "-1e6", "1e9"] {
            assert!(life(bad).is_err(), "{bad}");
        }
    }
}
