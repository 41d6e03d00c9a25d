//! A wire in its load behind a noisy converter, under a controller: what the tests and the step example share.
//!
//! One cycle is a PWM period: sample the on-phase just past, estimate, decide; the duty decided takes effect one
//! period later, as behind the driver's backend.
#![allow(dead_code)]

use sinew_control::{
    Algorithm, Controller, Demand, Estimate, EstimatorKind, Observation, Settings, StateEstimator, StrokeRange,
};
use sinew_physics::{Drive, DriveKind, Geometry, Initial, Inputs, Load, Material, Taps, Wire, WireModel};
use sinew_sensing::{MotionObserver, ObserverConfig};

/// The wire of the figure: 0.125 mm × 160 mm under 0.2 kg with B = 40 N s/m, 6 V.
pub fn figure_wire() -> WireModel {
    WireModel {
        geometry: Geometry { diameter_m: 0.125e-3, length_m: 0.16 },
        material: Material::default(),
        taps: Some(Taps { l0_m: 0.0, ls_m: 0.15 }),
        drive: Drive { kind: DriveKind::Pwm, supply_v: 6.0, shunt_ohm: 0.1, switch_ohm: 0.02, lead_ohm: 0.0 },
        load: Load::SpringMassDamper {
            mass_kg: 0.2,
            damping_n_s_per_m: 40.0,
            spring_n_per_m: 0.0,
            preload_n: 0.2 * 9.80665,
        },
        initial: Initial::default(),
        ambient_c: 25.0,
        effects: sinew_physics::Effects::default(),
    }
}

/// The figure's steps of 40 % of the stroke, and two of 10 %: stroke and time watched.
pub const STEPS: [(f64, f64); 6] = [(0.4, 3.0), (0.8, 3.0), (0.4, 3.0), (0.0, 6.0), (0.3, 3.0), (0.2, 3.0)];

/// The figure's wire other than its model says.
pub fn misjudged(model: &WireModel) -> Vec<(&'static str, WireModel)> {
    let change = |f: fn(&mut WireModel)| {
        let mut plant = model.clone();
        f(&mut plant);
        plant
    };
    vec![
        ("convection 20 % less", change(|m| m.material.convection_w_per_m2_k *= 0.8)),
        ("convection 20 % more", change(|m| m.material.convection_w_per_m2_k *= 1.2)),
        ("latent heat 25 % less", change(|m| m.material.latent_heat_j_per_kg *= 0.75)),
        ("latent heat 25 % more", change(|m| m.material.latent_heat_j_per_kg *= 1.25)),
        (
            "A and M 5 K up",
            change(|m| {
                m.material.austenite_temperature_c += 5.0;
                m.material.martensite_temperature_c += 5.0;
            }),
        ),
        ("transformation strain 10 % less", change(|m| m.material.transformation_strain *= 0.9)),
    ]
}

/// Other wires, and the power to heat them with: thin, thick, weakly supplied, lightly damped, on a spring.
pub fn other_wires() -> Vec<(&'static str, WireModel, f64)> {
    let wire =
        |diameter_mm: f64, length_mm: f64, supply_v: f64, mass_kg: f64, damping: f64, spring: f64, preload: f64| {
            let mut m = figure_wire();
            m.geometry = Geometry { diameter_m: diameter_mm * 1e-3, length_m: length_mm * 1e-3 };
            m.taps = Some(Taps { l0_m: 0.0, ls_m: 0.9375e-3 * length_mm });
            m.drive.supply_v = supply_v;
            m.load = Load::SpringMassDamper {
                mass_kg,
                damping_n_s_per_m: damping,
                spring_n_per_m: spring,
                preload_n: preload,
            };
            m
        };
    vec![
        ("thin 0.05 mm × 100 mm, 0.03 kg", wire(0.05, 100.0, 9.0, 0.03, 6.0, 0.0, 0.3), 100.0),
        ("thick 0.5 mm × 300 mm, 3 kg", wire(0.5, 300.0, 5.0, 3.0, 600.0, 0.0, 29.4), 100.0),
        ("weak supply, 1 W", wire(0.125, 160.0, 6.0, 0.2, 40.0, 0.0, 1.96133), 1.0),
        ("lightly damped 0.2 kg, B = 5 N s/m", wire(0.125, 160.0, 6.0, 0.2, 5.0, 0.0, 1.96133), 3.0),
        ("hexapod coxa, spring", wire(0.125, 160.0, 6.5, 0.08, 30.0, 150.0, 2.4), 3.5),
    ]
}

/// Duty at which the cold wire takes this power.
pub fn duty_for_power(model: &WireModel, power_w: f64) -> f64 {
    let wire = Wire::new(model).unwrap();
    let r = wire.resistance_ohm();
    let d = &model.drive;
    let current = d.supply_v / (r + d.shunt_ohm + d.switch_ohm + d.lead_ohm);
    (power_w / (current * current * r)).min(1.0)
}

/// Converter noise.
#[derive(Debug, Clone, Copy)]
pub struct Noise {
    pub voltage_v: f64,
    pub current_a: f64,
    pub bits: u32,
}

/// The figure's converter: 16 bits over ±10 V and ±1 A, 1.5 mV and 0.4 mA rms.
pub const CONVERTER: Noise = Noise { voltage_v: 1.5e-3, current_a: 0.4e-3, bits: 16 };

/// Standard normal numbers, the same on every machine: SplitMix64 and Box–Muller.
#[derive(Debug, Clone)]
pub struct Gauss(u64);

impl Gauss {
    pub fn new(seed: u64) -> Gauss {
        Gauss(seed)
    }

    pub fn uniform(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }

    pub fn sample(&mut self) -> f64 {
        let radius = (-2.0 * (1.0 - self.uniform()).ln()).sqrt();
        radius * (std::f64::consts::TAU * self.uniform()).cos()
    }
}

/// What a step did.
#[derive(Debug, Clone, Copy, Default)]
pub struct Step {
    pub from: f64,
    pub to: f64,
    /// Last moment outside ±0.5 % of the stroke, s after the step.
    pub settle_s: f64,
    /// Farthest beyond the reference, share of the stroke.
    pub overshoot: f64,
    /// First moment the wire could be within the band with the power at its limit (0 or maximum), s.
    pub fastest_s: f64,
    /// Mean and rms error of the last quarter, shares of the stroke.
    pub bias: f64,
    pub rms: f64,
}

impl Step {
    /// The figure's time: 1.2 s heating, 1.2 × free cooling.
    pub fn limit_s(&self) -> f64 {
        if self.to > self.from { 1.2 } else { 1.2 * self.fastest_s }
    }

    /// The figure: settled in time, overshoot below 1 %.
    pub fn meets_figure(&self) -> bool {
        self.settle_s <= self.limit_s() && self.overshoot < 0.01
    }
}

pub struct Bench {
    pub model: WireModel,
    pub wire: Wire,
    pub range: StrokeRange,
    pub rate_hz: f64,
    pub estimator: StateEstimator,
    pub controller: Algorithm,
    pub estimate: Estimate,
    /// What the estimator was given last.
    pub observation: Observation,
    observer: MotionObserver,
    maximum_duty: f64,
    noise: Noise,
    rng: Gauss,
    duty: f64,
    pending: f64,
    /// What the wire really has; the model is what estimator and controller believe.
    pub ambient_c: f64,
    pub external_n: f64,
    draught: f64,
    pub worst_temperature_error: f64,
}

impl Bench {
    pub fn new(
        model: &WireModel,
        believed: &WireModel,
        settings: &Settings,
        rate_hz: f64,
        noise: Noise,
        seed: u64,
    ) -> Bench {
        Bench::with_estimator(model, believed, settings, rate_hz, noise, seed, EstimatorKind::Enthalpy)
    }

    pub fn with_estimator(
        model: &WireModel,
        believed: &WireModel,
        settings: &Settings,
        rate_hz: f64,
        noise: Noise,
        seed: u64,
        estimator: EstimatorKind,
    ) -> Bench {
        let wire = Wire::new(model).unwrap();
        let observer = MotionObserver::new(rate_hz, ObserverConfig::default()).unwrap();
        Bench {
            model: model.clone(),
            range: StrokeRange::of(model).unwrap(),
            wire,
            rate_hz,
            estimator: StateEstimator::new(believed, estimator),
            controller: Algorithm::new(believed, settings),
            estimate: Estimate::UNKNOWN,
            observation: Observation::nothing(0.0, 0.0),
            observer,
            maximum_duty: settings.maximum_duty,
            noise,
            rng: Gauss::new(seed),
            duty: 0.0,
            pending: settings.minimum_duty,
            ambient_c: model.ambient_c,
            external_n: 0.0,
            draught: 1.0,
            worst_temperature_error: 0.0,
        }
    }

    fn inputs(&self, drive: f64) -> Inputs {
        Inputs {
            drive,
            supply_v: self.model.drive.supply_v,
            // as much colder as makes the same loss
            ambient_c: self.ambient_c - (self.draught - 1.0) * (self.wire.temperature_c() - self.ambient_c),
            external_n: self.external_n,
            imposed: 0.0,
        }
    }

    fn convert(&mut self, value: f64, sigma: f64, range: f64) -> f64 {
        let noisy = value + sigma * self.rng.sample();
        let lsb = 2.0 * range / f64::from(1u32 << self.noise.bits);
        (noisy / lsb).round() * lsb
    }

    /// One period; returns the true length at its end.
    pub fn cycle(&mut self, reference_m: f64) -> f64 {
        let dt = 1.0 / self.rate_hz;
        self.duty = self.pending;
        self.wire.step(&self.inputs(self.duty), dt);
        let out = self.wire.outputs();
        let (sv, si) = (self.noise.voltage_v, self.noise.current_a);
        let v2 = self.convert(out.v2_v, sv, 10.0);
        let v3 = self.convert(out.v3_v, sv, 10.0);
        let current = self.convert(out.current_a, si, 1.25 * self.model.drive.supply_v / out.resistance_ohm);
        let taps = self.model.taps.unwrap();
        let length = (taps.l0_m + taps.ls_m) * v3 / v2;
        let motion = self.observer.update(Some(length), dt);
        self.observation = Observation {
            power_w: self.duty * current * v3,
            duty: self.duty,
            length_m: length,
            length_sigma_m: length * sv * (1.0 / (v2 * v2) + 1.0 / (v3 * v3)).sqrt(),
            resistance_ohm: v3 / current,
            resistance_sigma_ohm: v3 / current * (sv / v3).hypot(si / current),
            tension_n: f64::NAN,
            dt_s: dt,
        };
        self.estimate = self.estimator.update(&self.observation);
        let error = (self.estimate.temperature_c - self.wire.temperature_c()).abs();
        self.worst_temperature_error = self.worst_temperature_error.max(error);
        self.pending = self.controller.duty(&Demand {
            reference_m,
            length_m: motion.length_m,
            velocity_m_s: motion.velocity_m_s,
            acceleration_m_s2: motion.acceleration_m_s2,
            resistance_ohm: v3 / current,
            dt_s: dt,
            estimate: self.estimate,
        });
        self.model.geometry.length_m + self.wire.position_m()
    }

    /// From now on the air takes so many times the heat.
    pub fn draught(&mut self, factor: f64) {
        self.draught = factor;
    }

    /// Power off but for the sensing pulse.
    pub fn idle(&mut self, seconds: f64) {
        for _ in 0..(seconds * self.rate_hz) as usize {
            self.cycle(self.range.cold_m + self.range.stroke_m());
        }
    }

    pub fn length_m(&self) -> f64 {
        self.model.geometry.length_m + self.wire.position_m()
    }

    pub fn duty(&self) -> f64 {
        self.duty
    }

    /// Time the wire takes from here into the band with a constant duty, s.
    pub fn fastest(&self, target: f64, band: f64, duty: f64) -> f64 {
        let mut wire = self.wire.clone();
        let inputs = self.inputs(duty);
        let dt = 1e-4;
        let mut t = 0.0;
        while t < 60.0 {
            wire.step(&inputs, dt);
            t += dt;
            if (self.model.geometry.length_m + wire.position_m() - target).abs() <= band {
                break;
            }
        }
        t
    }

    /// A step to a stroke (0..1), watched for `seconds`.
    pub fn step_to(&mut self, stroke: f64, seconds: f64, mut watch: impl FnMut(&Bench, f64, f64)) -> Step {
        let target = self.range.length_m(stroke);
        let span = self.range.stroke_m();
        let start = self.length_m();
        let heating = target < start;
        let duty = if heating { self.maximum_duty } else { 0.0 };
        let mut step = Step {
            from: self.range.stroke(start),
            to: stroke,
            fastest_s: self.fastest(target, 0.005 * span, duty),
            ..Step::default()
        };
        let cycles = (seconds * self.rate_hz) as usize;
        let (mut sum, mut squares, mut n) = (0.0, 0.0, 0.0);
        for k in 0..cycles {
            let length = self.cycle(target);
            let t = (k + 1) as f64 / self.rate_hz;
            let error = (length - target) / span;
            if error.abs() > 0.005 {
                step.settle_s = t;
            }
            step.overshoot = step.overshoot.max(if heating { -error } else { error });
            if k >= cycles * 3 / 4 {
                (sum, squares, n) = (sum + error, squares + error * error, n + 1.0);
            }
            watch(self, t, error);
        }
        step.bias = sum / n;
        step.rms = (squares / n).sqrt();
        step
    }
}
