//! A mass that hangs on the wire, simulated by the cross-head, and the law that moves it.
//!
//! The thesis gives the cross-head a mass and a proportional-integral controller on the load: of e = W − F, what the mass
//! is pulled by, its integral over the mass is the velocity the mass would have, and a share of e itself, 1/b, moves
//! with it. On a wire of stiffness k the error obeys ë + (k/b) ė + (k/M) e = 0, so the proportional part is what damps.
//! A force that is measured late undamps by as much as the delay turns the oscillation.

use sinew_control::{Algorithm, Controller, Demand, Estimate, EstimatorKind, Observation, Settings, StateEstimator};
use sinew_physics::formulas::STANDARD_GRAVITY_M_S2;
use sinew_physics::{DriveKind, Load, WireModel};

use crate::machine::{Reading, delay_s};

/// The acceleration is smoothed over so many periods.
const ACCELERATION_PERIODS: f64 = 3.0;
/// Standard deviation of a length that is counted in steps, m.
const LENGTH_SIGMA_M: f64 = 1e-6;

/// A load that hangs on the wire.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Plant {
    /// Mass M, kg.
    pub mass_kg: f64,
    /// Its weight and whatever else pulls steadily, W, N.
    pub load_n: f64,
    /// 1/b of the proportional part, m/(N s).
    pub mobility_m_per_n_s: f64,
}

/// A disturbance of the load.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Disturbance {
    /// When it begins, s after the plant is let go.
    pub start_s: f64,
    /// When it ends, s.
    pub end_s: f64,
    /// Pull, N, positive making the wire longer.
    pub pull_n: f64,
}

/// What moves the mass.
#[derive(Debug, Clone, PartialEq)]
pub struct Loop {
    /// The law.
    pub settings: Settings,
    /// What estimates the wire's state for it.
    pub estimator: EstimatorKind,
    /// Power at duty 1, W.
    pub full_power_w: f64,
}

/// Mass and law at work.
#[derive(Debug, Clone)]
pub(crate) struct Hanging {
    plant: Plant,
    disturbances: Vec<Disturbance>,
    law: Algorithm,
    estimator: StateEstimator,
    full_power_w: f64,
    length_m: f64,
    /// ∫e/M dt, m/s.
    integral_m_s: f64,
    since_s: f64,
    last: Option<Moved>,
    acceleration_m_s2: f64,
    duty: f64,
    nominal_ohm: f64,
}

/// Where the wire's end was and how fast it went, at a reading.
#[derive(Debug, Clone, Copy)]
struct Moved {
    position_m: f64,
    velocity_m_s: f64,
}

/// What the plant commands of the machine.
pub(crate) struct Commanded {
    pub(crate) speed_m_s: f64,
    pub(crate) duty: f64,
    pub(crate) power_w: f64,
    pub(crate) disturbance_n: f64,
}

/// The wire as a law controls it: with the hanging mass as its load, heated by pulses of the full power.
pub fn controlled(model: &WireModel, plant: &Plant, full_power_w: f64) -> WireModel {
    let mut controlled = model.clone();
    let damping = if plant.mobility_m_per_n_s > 0.0 { 1.0 / plant.mobility_m_per_n_s } else { 0.0 };
    controlled.load = Load::SpringMassDamper {
        mass_kg: plant.mass_kg,
        damping_n_s_per_m: damping,
        spring_n_per_m: 0.0,
        preload_n: plant.load_n,
    };
    let ohm = model.geometry.resistance_ohm(model.material.mean_resistivity());
    controlled.drive = sinew_physics::Drive {
        kind: DriveKind::Pwm,
        supply_v: (full_power_w.max(0.0) * ohm).sqrt(),
        shunt_ohm: 0.0,
        switch_ohm: 0.0,
        lead_ohm: 0.0,
    };
    controlled
}

impl Hanging {
    pub(crate) fn new(model: &WireModel, plant: Plant, disturbances: Vec<Disturbance>, by: &Loop) -> Hanging {
        let controlled = controlled(model, &plant, by.full_power_w);
        let nominal_ohm = controlled.drive.supply_v.powi(2) / by.full_power_w.max(1e-12);
        Hanging {
            plant,
            disturbances,
            law: Algorithm::new(&controlled, &by.settings),
            estimator: StateEstimator::new(&controlled, by.estimator),
            full_power_w: by.full_power_w,
            length_m: model.geometry.length_m,
            integral_m_s: 0.0,
            since_s: 0.0,
            last: None,
            acceleration_m_s2: 0.0,
            duty: 0.0,
            nominal_ohm,
        }
    }

    /// One period: where the mass goes, and what the law does to bring it to `reference_m` (elongation).
    pub(crate) fn period(&mut self, reading: &Reading, reference_m: f64, dt_s: f64, least_a: f64) -> Commanded {
        let now = self.since_s;
        let disturbance_n =
            self.disturbances.iter().filter(|d| d.start_s <= now && now < d.end_s).map(|d| d.pull_n).sum::<f64>();
        let pull_n = self.plant.load_n + disturbance_n - reading.force_n;
        self.integral_m_s += pull_n / self.plant.mass_kg * dt_s;
        let speed_m_s = self.integral_m_s + self.plant.mobility_m_per_n_s * pull_n;
        let (velocity, before) = match self.last {
            Some(last) => ((reading.position_m - last.position_m) / dt_s, last.velocity_m_s),
            None => (0.0, 0.0),
        };
        self.acceleration_m_s2 += ((velocity - before) / dt_s - self.acceleration_m_s2) / ACCELERATION_PERIODS;
        self.last = Some(Moved { position_m: reading.position_m, velocity_m_s: velocity });
        let length_m = self.length_m + reading.position_m;
        let ohm = reading.resistance_ohm(least_a);
        let estimate: Estimate = self.estimator.update(&Observation {
            power_w: reading.power_w(),
            duty: self.duty,
            length_m,
            length_sigma_m: LENGTH_SIGMA_M,
            resistance_ohm: ohm,
            resistance_sigma_ohm: f64::NAN,
            tension_n: reading.force_n,
            dt_s,
        });
        self.duty = self.law.duty(&Demand {
            reference_m: self.length_m + reference_m,
            length_m,
            velocity_m_s: velocity,
            acceleration_m_s2: self.acceleration_m_s2,
            resistance_ohm: if ohm.is_finite() { ohm } else { self.nominal_ohm },
            dt_s,
            estimate,
        });
        self.since_s += dt_s;
        Commanded { speed_m_s, duty: self.duty, power_w: self.duty * self.full_power_w, disturbance_n }
    }

    /// The mass is held: it has no speed when it is let go.
    pub(crate) fn hold(&mut self) {
        self.integral_m_s = 0.0;
    }
}

/// A hanging mass that this machine can play on a wire of this stiffness, damped to `damping`. Without a `mass_kg` of its
/// own it is what the load weighs, or, where the wire is so stiff that the machine's delays would not let that be played,
/// as much more as it takes.
pub fn playable(
    model: &WireModel,
    load_n: f64,
    damping: f64,
    mass_kg: Option<f64>,
    spec: &sinew_rig::Machine,
) -> Plant {
    let stiffness = model.stiffest_n_per_m();
    let delay_s = delay_s(spec);
    let fastest = FASTEST_TURN / delay_s;
    let least_kg = (load_n / STANDARD_GRAVITY_M_S2).max(stiffness / (fastest * fastest)).max(1e-6);
    let mass_kg = mass_kg.unwrap_or(least_kg);
    let natural = (stiffness / mass_kg).sqrt();
    // what the delay undamps is put back: ω T/2
    let zeta = damping + 0.5 * natural * delay_s;
    Plant { mass_kg, load_n, mobility_m_per_n_s: 2.0 * zeta * natural / stiffness }
}

/// Why a mass is played as more than its load weighs.
pub const DAMPING_NOTE: &str = "on a wire this stiff a lighter one would swing faster than the machine can follow";
/// Radians the plant's oscillation may turn within the delay of the force.
const FASTEST_TURN: f64 = 0.35;
