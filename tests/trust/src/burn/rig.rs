//! The rig of a history: one of fifteen kinds of wire, and what the driver believes of it.

use rand::rngs::Xoshiro256PlusPlus;
use rand::{RngExt, SeedableRng};
use sinew_rig::{BackendKind, Rig};

use crate::failure::Failure;
use crate::kind::between;

/// Share by which beliefs are off, at most.
const OFF: f64 = 0.3;

/// The kinds of wire: diameter in mm, supply as a multiple of what drives the current its rule allows for ever.
const WIRES: [(f64, f64); 15] = [
    (0.025, 1.3),
    (0.025, 3.0),
    (0.05, 1.3),
    (0.05, 2.0),
    (0.05, 4.0),
    (0.1, 1.3),
    (0.1, 2.0),
    (0.125, 1.5),
    (0.125, 3.0),
    (0.15, 2.0),
    (0.2, 2.0),
    (0.2, 4.0),
    (0.3, 2.0),
    (0.375, 2.0),
    (0.5, 2.0),
];
/// The default's sensing pulse.
const SENSING_DUTY: f64 = 0.02;
/// A stage with a quick watchdog, and one as slow as the guard of Linux's outputs.
const KEEPS_MS: [u32; 2] = [20, 100];
const RATES_HZ: [f64; 6] = [50.0, 100.0, 250.0, 500.0, 1000.0, 5000.0];
// (the default three times out of six)
const ESTIMATORS: [&str; 6] = ["fused", "fused", "fused", "enthalpy", "luenberger", "luenberger_scheduled"];
const ALGORITHMS: [&str; 5] =
    ["time_optimal", "sliding_mode", "pid", "input_output_linearised", "velocity_servo_scheduled"];

/// How a wire is measured.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Taps {
    Separate,
    Shared,
    None,
}

/// What the temperature of a wire is known by, besides the power.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Witnesses {
    /// Length by taps and resistance, both weighed by the estimator.
    LengthAndResistance,
    /// Length alone: an estimator that is blind to resistance.
    Length,
    /// Resistance alone, which is taken for the length: no taps.
    Resistance,
}

/// The rig of a history, drawn from its seed.
#[derive(Clone)]
pub struct Plan {
    diameter_mm: f64,
    supply_share: f64,
    /// Its rate, Hz.
    pub rate_hz: f64,
    taps: Taps,
    estimator: &'static str,
    /// Whether the rig file is true.
    pub is_true: bool,
    algorithm: &'static str,
    /// Whether an emergency stop is fitted.
    has_stop: bool,
    /// How long its stage keeps its duty in silence, ms; at least four periods.
    keeps_ms: u32,
    /// Whether a line switches the supply.
    has_enable: bool,
    /// Duty of its sensing pulse.
    sensing_duty: f64,
    /// Whether it is in a sleeve.
    in_sleeve: bool,
    /// Whether its heat capacity is nearly as much less than is believed as it may be, where beliefs are off.
    is_quick: bool,
    rng: Xoshiro256PlusPlus,
}

/// The rigs of a history.
pub struct Rigs {
    /// The one the driver gets.
    pub believed: Rig,
    /// Another one of the same wire that it gets now and then.
    pub other: Rig,
    /// The one it drives.
    pub truth: Rig,
    /// Whether the rig file is true.
    pub is_true: bool,
    /// What the driver can know the temperature by.
    pub witnesses: Witnesses,
}

impl Plan {
    /// From a seed; another one each time it is drawn again.
    pub fn of(seed: u64, again: u64) -> Plan {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed ^ (again << 40));
        let mut more = Xoshiro256PlusPlus::seed_from_u64(!seed ^ (again << 40));
        let mut yet_more = Xoshiro256PlusPlus::seed_from_u64(seed.rotate_left(32) ^ (again << 40));
        let (diameter_mm, supply_share) = WIRES[rng.random_range(0..WIRES.len())];
        let rate_hz = RATES_HZ[rng.random_range(0..RATES_HZ.len())];
        let taps = [Taps::Separate, Taps::Shared, Taps::Separate, Taps::None][rng.random_range(0..4)];
        let estimator = ESTIMATORS[rng.random_range(0..ESTIMATORS.len())];
        Plan {
            diameter_mm,
            supply_share,
            rate_hz,
            // Something is promised where there are both witnesses, so that every second rig without gets them.
            taps: if taps == Taps::None && yet_more.random() { Taps::Separate } else { taps },
            estimator: if yet_more.random() { ESTIMATORS[0] } else { estimator },
            is_true: seed.is_multiple_of(2),
            // (the default every second time)
            algorithm: if more.random::<bool>() {
                ALGORITHMS[0]
            } else {
                ALGORITHMS[more.random_range(0..ALGORITHMS.len())]
            },
            has_stop: more.random_range(0..4) == 0,
            keeps_ms: KEEPS_MS[more.random_range(0..KEEPS_MS.len())],
            has_enable: yet_more.random(),
            sensing_duty: if yet_more.random_range(0..4) == 0 {
                between(&mut yet_more, 0.05, 0.45)
            } else {
                SENSING_DUTY
            },
            in_sleeve: false,
            is_quick: false,
            rng,
        }
    }

    /// The same with a line that switches the supply, and where it is needed with an emergency stop.
    pub fn with_switch(self, needs_stop: bool) -> Plan {
        Plan { has_enable: true, has_stop: self.has_stop || needs_stop, ..self }
    }

    /// The same without what shortens a silence: with no line that switches the supply, the slow stage, and the default's sensing pulse.
    pub fn bare(self) -> Plan {
        Plan { has_enable: false, keeps_ms: KEEPS_MS[1], sensing_duty: SENSING_DUTY, ..self }
    }

    /// The same with a wire that, where beliefs are off, heats quicker than is believed.
    pub fn quick(self, is_quick: bool) -> Plan {
        Plan { is_quick, ..self }
    }

    /// The same in a sleeve that the rig file states, or in none.
    pub fn in_sleeve(self, in_sleeve: bool) -> Plan {
        Plan { in_sleeve, ..self }
    }

    /// What it is, for people.
    pub fn words(&self) -> String {
        let Plan { diameter_mm, supply_share, rate_hz, taps, estimator, algorithm, keeps_ms, sensing_duty, .. } = self;
        let stop = if self.has_stop { ", an emergency stop" } else { "" };
        let enable = if self.has_enable { "" } else { ", no enable line" };
        format!(
            "{diameter_mm} mm, {supply_share} times the rule's current, {rate_hz} Hz, {taps:?} taps, {estimator}, {algorithm}, pulses of {sensing_duty:.2}, a stage that keeps its duty for {keeps_ms} ms{stop}{enable}"
        )
    }

    /// What the driver can know its temperature by.
    fn witnesses(&self) -> Witnesses {
        match (self.taps, self.estimator) {
            (Taps::None, _) => Witnesses::Resistance,
            (_, "fused") => Witnesses::LengthAndResistance,
            _ => Witnesses::Length,
        }
    }

    fn text(&self, supply_v: f64, algorithm: &str, estimator: &str) -> String {
        let (area, taps) = (self.diameter_mm * self.diameter_mm, self.taps);
        format!(
            "[rig]\nname = \"burn\"\nrate_hz = {:?}\n\n{}{}[[channel]]\nname = \"wire\"\n\
             wire = {{ diameter_mm = {:?}, length_mm = 160.0 }}\n{}\
             drive = {{ supply_v = {supply_v:?}, shunt_ohm = {:?}, switch_ohm = 0.02 }}\n\
             load = {{ mass_kg = {:?}, damping_n_s_per_m = {:?}, spring_n_per_m = {:?}, preload_n = {:?} }}\n\
             control = {{ algorithm = \"{}\", estimator = \"{}\", sensing_duty = {:?}{} }}\n{}",
            self.rate_hz,
            if self.has_enable { "[backend.enable]\nsignal = \"pulses\"\n\n" } else { "" },
            if self.has_stop { "[backend.estop]\nfitted = true\n\n" } else { "" },
            self.diameter_mm,
            if taps == Taps::None { "" } else { "taps = { l0_mm = 0.0, ls_mm = 150.0 }\n" },
            0.004 / area,
            5.0 * area,
            2000.0 * area,
            10_000.0 * area,
            150.0 * area,
            algorithm,
            estimator,
            self.sensing_duty,
            if taps == Taps::None { ", sensing = \"resistance\"" } else { "" },
            if taps == Taps::Shared { "adc = { circuit = \"shared\" }\n" } else { "" },
        ) + &self.sleeve()
    }

    /// A sleeve of about twice the wire's heat capacity (0.68 J/K mm⁻² for this length), which conducts 2.5 times as well as still air does
    /// about a wire of 0.125 mm inside, and 1.3 times as well outside.
    fn sleeve(&self) -> String {
        if !self.in_sleeve {
            return String::new();
        }
        let (capacity, inner, outer) =
            (1.5 * self.diameter_mm * self.diameter_mm, 0.15 * self.diameter_mm, 0.08 * self.diameter_mm);
        format!(
            "\n[channel.effects.\"thermal.sheath\"]\nheat_capacity_j_per_k = {capacity:?}\ninner_w_per_k = {inner:?}\nouter_w_per_k = {outer:?}\n"
        )
    }

    /// Its rigs.
    ///
    /// # Errors
    /// A rig file that is refused.
    pub fn rigs(mut self) -> Result<Rigs, Failure> {
        let parse = |text: &str| {
            Rig::parse(text, "burn.toml").map_err(|e| Failure::Unexpected(format!("the rig is refused: {e}\n{text}")))
        };
        // What supply drives the current that the rule allows, through the wire when it is hot.
        let first = parse(&self.text(10.0, self.algorithm, self.estimator))?;
        let (model, limits) = (&first.channels[0].model, &first.channels[0].limits);
        let m = &model.material;
        let hot_ohm =
            m.austenite_resistivity(m.austenite_temperature_c) * model.geometry.length_m / model.geometry.area_m2();
        let supply_v = self.supply_share * limits.continuous_current_a * (hot_ohm + model.drive.series_ohm());
        let supply_v = (supply_v * 100.0).round() / 100.0;
        let believed = parse(&self.text(supply_v, self.algorithm, self.estimator))?;
        let other_law = if self.algorithm == "pid" { ALGORITHMS[0] } else { "pid" };
        let other_estimator = if self.estimator == "fused" { "fused" } else { "enthalpy" };
        let other = parse(&self.text(supply_v, other_law, other_estimator))?;
        let mut truth = believed.clone();
        // What stands before these wires keeps their duty for as long as this guard would.
        (truth.backend.kind, truth.backend.linux.guard_ms) = (BackendKind::Linux, self.keeps_ms);
        truth.simulation.seed = self.rng.random::<u32>().into();
        if !self.is_true {
            let material = &mut truth.channels[0].model.material;
            let rng = &mut self.rng;
            for value in [
                &mut material.specific_heat_j_per_kg_k,
                &mut material.latent_heat_j_per_kg,
                &mut material.convection_w_per_m2_k,
            ] {
                *value *= between(rng, 1.0 - OFF, 1.0 + OFF);
            }
            if self.is_quick {
                material.specific_heat_j_per_kg_k = believed.channels[0].model.material.specific_heat_j_per_kg_k
                    * between(rng, 1.0 - OFF, 1.0 - 0.8 * OFF);
            }
        }
        Ok(Rigs { believed, other, truth, is_true: self.is_true, witnesses: self.witnesses() })
    }
}
