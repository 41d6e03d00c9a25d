//! The wires of the rows, and ways through them: stress and temperature imposed, strain imposed, stress on a wire in air.

use sinew_physics::formulas::STANDARD_GRAVITY_M_S2;
use sinew_physics::{
    Detwinning, Drive, DriveKind, Effects, EnergyBalance, Geometry, Initial, Inputs, Kinetics, Load, Material, Wire,
    WireModel,
};

use crate::found::Tried;

/// 1 MPa, in Pa.
pub(crate) const MPA: f64 = 1e6;

/// Length of a step, s: shorter than the longest piece of the simulation, so that its sums are ours.
pub(crate) const STEP_S: f64 = 1e-3;

/// Heat as it is, by no circuit.
pub(crate) const BY_POWER: Drive =
    Drive { kind: DriveKind::Power, supply_v: 0.0, shunt_ohm: 0.0, switch_ohm: 0.0, lead_ohm: 0.0 };

/// The wire of tables 6 and 9: 0.125 mm × 160 mm, the nomenclature's alloy, 200 g hanging from it, well damped, in 25 °C.
pub(crate) fn hanging() -> WireModel {
    WireModel {
        geometry: Geometry { diameter_m: 0.125e-3, length_m: 0.16 },
        material: Material::default(),
        taps: None,
        drive: BY_POWER,
        load: Load::SpringMassDamper {
            mass_kg: 0.2,
            damping_n_s_per_m: 40.0,
            spring_n_per_m: 0.0,
            preload_n: 0.2 * STANDARD_GRAVITY_M_S2,
        },
        initial: Initial::default(),
        ambient_c: 25.0,
        effects: Effects::default(),
    }
}

/// Table 10's rig: 0.1 mm × 233 mm on 0.13 kg, 18 N/m and 0.915 N s/m, preloaded to 150 MPa.
pub(crate) fn table_10() -> WireModel {
    WireModel {
        geometry: Geometry { diameter_m: 0.1e-3, length_m: 0.233 },
        load: Load::SpringMassDamper { mass_kg: 0.13, damping_n_s_per_m: 0.915, spring_n_per_m: 18.0, preload_n: 1.2 },
        ..hanging()
    }
}

/// The same wire with stress and temperature imposed, as in a furnace in a tensile machine; so much of it martensite at first,
/// as far as its curves allow.
pub(crate) fn in_a_furnace(material: Material, martensite: f64) -> WireModel {
    WireModel {
        material,
        drive: Drive { kind: DriveKind::Temperature, ..BY_POWER },
        load: Load::ImposedForce,
        initial: Initial { temperature_c: None, martensite },
        ..hanging()
    }
}

/// The alloy with twinned martensite as a part of its own, detwinned between table 3's stress and Brinson's, 100 and 170 MPa.
pub(crate) fn twinned() -> Material {
    Material { detwinning: Some(Detwinning { start_pa: 100.0 * MPA, finish_pa: 170.0 * MPA }), ..Material::default() }
}

/// The alloy with one of the kinetics.
pub(crate) fn by(kinetics: Kinetics) -> Material {
    Material { kinetics, ..Material::default() }
}

/// What a way through a wire looked like.
#[derive(Debug, Clone, Default)]
pub(crate) struct Way {
    /// s.
    pub time_s: Vec<f64>,
    /// °C.
    pub temperature_c: Vec<f64>,
    /// MPa.
    pub stress_mpa: Vec<f64>,
    /// 1.
    pub strain: Vec<f64>,
    /// 1.
    pub martensite: Vec<f64>,
}

impl Way {
    /// Temperature of the last point, °C.
    pub fn ends_at_c(&self) -> f64 {
        self.temperature_c.last().copied().unwrap_or(f64::NAN)
    }

    /// ∮ σ d`of`, in Pa: the area under the way, by the trapezoidal rule.
    pub fn work_pa(&self, of: &[f64]) -> f64 {
        let pieces = self.stress_mpa.windows(2).zip(of.windows(2));
        pieces.map(|(s, e)| 0.5 * (s[0] + s[1]) * MPA * (e[1] - e[0])).sum()
    }

    /// The largest change of the martensite fraction between two points.
    pub fn largest_jump(&self) -> f64 {
        self.martensite.windows(2).map(|pair| (pair[1] - pair[0]).abs()).fold(0.0, f64::max)
    }
}

/// The largest of some numbers.
pub(crate) fn largest(values: &[f64]) -> f64 {
    values.iter().copied().fold(f64::NEG_INFINITY, f64::max)
}

/// The least of some numbers.
pub(crate) fn least(values: &[f64]) -> f64 {
    values.iter().copied().fold(f64::INFINITY, f64::min)
}

/// The number of the points nearest to `x`, which need not be in order.
pub(crate) fn at(xs: &[f64], ys: &[f64], x: f64) -> f64 {
    let near = xs.iter().zip(ys).min_by(|(a, _), (b, _)| (*a - x).abs().total_cmp(&(*b - x).abs()));
    near.map_or(f64::NAN, |(_, y)| *y)
}

/// Takes a wire along corners, each step as `inputs` makes it of the way between two of them.
fn follow<const N: usize>(
    model: &WireModel,
    corners: &[[f64; N]],
    steps: usize,
    inputs: impl Fn(&WireModel, &[f64; N]) -> Inputs,
) -> Tried<(Way, EnergyBalance)> {
    let first = corners.first().ok_or("a way without corners")?;
    let mut wire = Wire::with_inputs(model, &inputs(model, first))?;
    let mut way = Way::default();
    let mut see = |wire: &Wire, time_s: f64| {
        way.time_s.push(time_s);
        way.temperature_c.push(wire.temperature_c());
        way.stress_mpa.push(wire.stress_pa() / MPA);
        way.strain.push(wire.position_m() / model.geometry.length_m);
        way.martensite.push(wire.martensite());
    };
    see(&wire, 0.0);
    let mut step = 0u32;
    for leg in corners.windows(2) {
        for k in 1..=steps {
            let share = k as f64 / steps as f64;
            let here = std::array::from_fn(|i| leg[0][i] + share * (leg[1][i] - leg[0][i]));
            wire.step(&inputs(model, &here), STEP_S);
            step += 1;
            see(&wire, f64::from(step) * STEP_S);
        }
    }
    Ok((way, wire.energy()))
}

/// Along corners of temperature (°C) and stress (MPa), both imposed, with so many steps from one to the next.
pub(crate) fn imposed(model: &WireModel, corners: &[[f64; 2]], steps: usize) -> Tried<Way> {
    let inputs = |model: &WireModel, [temperature_c, mpa]: &[f64; 2]| Inputs {
        drive: *temperature_c,
        imposed: mpa * MPA * model.geometry.area_m2(),
        ..model.rest_inputs()
    };
    Ok(follow(model, corners, steps, inputs)?.0)
}

/// An austenite wire in air of `ambient_c` under corners of stress (MPa), unheated, with its energy.
pub(crate) fn stretched(
    material: Material,
    ambient_c: f64,
    corners_mpa: &[f64],
    leg_s: f64,
) -> Tried<(Way, EnergyBalance, WireModel)> {
    let model = WireModel {
        material,
        load: Load::ImposedForce,
        initial: Initial { temperature_c: Some(ambient_c), martensite: 0.0 },
        ambient_c,
        ..hanging()
    };
    let corners: Vec<[f64; 1]> = corners_mpa.iter().map(|mpa| [*mpa]).collect();
    let inputs = |model: &WireModel, [mpa]: &[f64; 1]| Inputs {
        drive: 0.0,
        ambient_c,
        imposed: mpa * MPA * model.geometry.area_m2(),
        ..model.rest_inputs()
    };
    let (way, energy) = follow(&model, &corners, (leg_s / STEP_S).round() as usize, inputs)?;
    Ok((way, energy, model))
}
