//! One slow sweep of a hanging wire: its heating, its taps, its faults, and its voltages.

use serde::Serialize;
use sinew_physics::formulas::{STANDARD_GRAVITY_M_S2, logit};
use sinew_physics::{
    Drive, DriveKind, Effects, Geometry, Initial, Inputs, Load, Material, Outputs, Taps, Wire, WireModel,
};

/// Time between samples, s.
pub(super) const PERIOD_S: f64 = 1e-3;

/// Ends of the sweep, A.
pub(super) const LEAST_A: f64 = 0.040;
const MOST_A: f64 = 0.250;

/// Its upper end where the wire starts twinned: 250 mA leave some of it martensite under 300 gf.
const HOT_ONCE_A: f64 = 0.300;

/// Supply of the pulses, and what lies between it and the wire, Ω.
pub(super) const SUPPLY_V: f64 = 6.0;

const SERIES_OHM: f64 = 0.12;

/// The room of the experiment, °C.
const AMBIENT_C: f64 = 25.0;

/// When the second tap is off the wire, shares of the sweep: while the wire shortens, and while it lengthens.
const LOST: [(f64, f64); 2] = [(0.30, 0.36), (0.64, 0.70)];

/// A bad crimp, Ω.
const CONTACT_OHM: f64 = 0.1;

/// Where the taps are.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Place {
    /// Table 7: l_0 = 91 mm, l_s = 55 mm.
    Thesis,
    /// l_0 = 0, l_s = 150 mm, as the thesis recommends (eq. 43).
    Long,
}

impl Place {
    pub(super) const ALL: [Place; 2] = [Place::Thesis, Place::Long];

    /// What the rig file says of it.
    pub(super) fn taps(self) -> Taps {
        match self {
            Place::Thesis => Taps { l0_m: 0.091, ls_m: 0.055 },
            Place::Long => Taps { l0_m: 0.0, ls_m: 0.150 },
        }
    }
}

/// What heats the wire.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Heating {
    /// The thesis' current, 40 to 250 mA.
    Current,
    /// Pulses of 6 V with the same mean power, sampled while they last.
    Pulses,
}

impl Heating {
    pub(super) const ALL: [Heating; 2] = [Heating::Current, Heating::Pulses];
}

/// What is not as the estimators believe.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Condition {
    /// Nothing.
    Clean,
    /// The second tap is off the wire for two times 6 % of the sweep.
    ProbeLoss,
    /// 0.1 Ω in the crimp at the moving end, inside V_3.
    ContactResistance,
    /// The cold wire is martensite, but twinned: as short as the hot one, until it has been hot once.
    TwinnedStart,
}

impl Condition {
    pub(super) const ALL: [Condition; 4] =
        [Condition::Clean, Condition::ProbeLoss, Condition::ContactResistance, Condition::TwinnedStart];
}

/// The wire of table 6 under a hanging load, as the estimators believe it.
pub fn believed(taps: Taps, load_gf: f64) -> WireModel {
    let default = Material::default();
    let hysteresis_k = default.austenite_temperature_c - default.martensite_temperature_c;
    let austenite_temperature_c = 90.0 - logit(0.01) / default.heating_steepness_per_k;
    let mass_kg = load_gf * 1e-3;
    WireModel {
        geometry: Geometry { diameter_m: 0.125e-3, length_m: 0.160 },
        material: Material {
            austenite_temperature_c,
            martensite_temperature_c: austenite_temperature_c - hysteresis_k,
            transformation_strain: 8.1 / 160.0,
            ..default
        },
        taps: Some(taps),
        drive: Drive {
            kind: DriveKind::Pwm,
            supply_v: SUPPLY_V,
            shunt_ohm: 0.1,
            switch_ohm: SERIES_OHM - 0.1,
            lead_ohm: 0.0,
        },
        load: Load::SpringMassDamper {
            mass_kg,
            damping_n_s_per_m: 40.0,
            spring_n_per_m: 0.0,
            preload_n: mass_kg * STANDARD_GRAVITY_M_S2,
        },
        initial: Initial::default(),
        ambient_c: AMBIENT_C,
        effects: Effects::default(),
    }
}

/// One sweep of one wire: what its pins see and how long it is, at every sample.
pub(super) struct Sweep {
    /// As the estimators believe it.
    pub(super) model: WireModel,
    pub(super) points: Vec<Point>,
}

/// One sample's truth.
#[derive(Clone, Copy)]
pub(super) struct Point {
    pub(super) outputs: Outputs,
    pub(super) duty: f64,
    pub(super) length_m: f64,
    /// The second tap is off the wire.
    pub(super) lost: bool,
}

impl Sweep {
    /// The physics alone: no converter yet.
    pub(super) fn new(taps: Place, heating: Heating, condition: Condition, load_gf: f64, sweep_s: f64) -> Sweep {
        let believed = believed(taps.taps(), load_gf);
        let mut model = believed.clone();
        if heating == Heating::Current {
            model.drive.kind = DriveKind::Current;
        }
        if condition == Condition::ContactResistance {
            model.effects.sensing.contact_resistance.ohm = CONTACT_OHM;
        }
        let make = |model: &WireModel| Wire::new(model).unwrap_or_else(|error| panic!("the bench's own wire: {error}"));
        let mut twinned = condition == Condition::TwinnedStart;
        let mut wire = if twinned {
            // The same martensite, which needs no strain to be there.
            let mut first = model.clone();
            first.material.transformation_strain = 0.0;
            make(&first)
        } else {
            make(&model)
        };
        let rest = model.rest_inputs();
        let (low_a, high_a) = (LEAST_A, if twinned { HOT_ONCE_A } else { MOST_A });
        let current_at = |share: f64| low_a + (high_a - low_a) * (1.0 - (2.0 * share - 1.0).abs());
        // The wire rests at the foot of the sweep before anything is recorded.
        let samples = (sweep_s / PERIOD_S) as usize;
        let settle = (10.0 / PERIOD_S) as usize;
        let mut points = Vec::with_capacity(samples);
        for i in 0..settle + samples {
            let share = i.saturating_sub(settle) as f64 / samples as f64;
            let current = current_at(share);
            let duty = match heating {
                Heating::Current => 1.0,
                Heating::Pulses => {
                    let series = SERIES_OHM + model.effects.sensing.contact_resistance.ohm;
                    (current * (wire.resistance_ohm() + series) / SUPPLY_V).powi(2)
                }
            };
            let drive = if heating == Heating::Current { current } else { duty };
            wire.step(&Inputs { drive, ..rest }, PERIOD_S);
            if twinned && share >= 0.5 {
                // Hot once: what forms from here on is oriented by the load.
                twinned = false;
                let initial = Initial { temperature_c: Some(wire.temperature_c()), martensite: wire.martensite() };
                wire = make(&WireModel { initial, ..model.clone() });
                wire.step(&Inputs { drive, ..rest }, PERIOD_S);
            }
            if i >= settle {
                let lost = condition == Condition::ProbeLoss && LOST.iter().any(|(a, b)| (*a..*b).contains(&share));
                let length_m = model.geometry.length_m + wire.position_m();
                points.push(Point { outputs: wire.outputs(), duty, length_m, lost });
            }
        }
        Sweep { model: believed, points }
    }

    pub(super) fn stroke_m(&self) -> f64 {
        let lengths = self.points.iter().map(|p| p.length_m);
        let (low, high) = lengths.fold((f64::INFINITY, 0.0f64), |(low, high), l| (low.min(l), high.max(l)));
        high - low
    }
}
