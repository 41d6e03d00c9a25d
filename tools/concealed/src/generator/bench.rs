//! Benches: what a laboratory believes of its wire, circuit, load and sensors, and what may differ from that in truth.

use std::collections::BTreeMap;
use std::fmt::Write;

use rand::RngExt;
use rand::rngs::SmallRng;
use rand_distr::StandardNormal;

use super::truth::{Material, Taps, Truth};

/// Standard gravity, m/s².
const GRAVITY: f64 = 9.80665;

/// A sensor's column.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Sensor {
    /// On-phase current.
    Current,
    /// First tap.
    V1,
    /// Second tap.
    V2,
    /// Moving end.
    V3,
    /// Tension.
    Force,
    /// Elongation.
    Position,
}

impl Sensor {
    /// Its column's name.
    pub fn column(self) -> &'static str {
        match self {
            Sensor::Current => "current_a",
            Sensor::V1 => "v1_v",
            Sensor::V2 => "v2_v",
            Sensor::V3 => "v3_v",
            Sensor::Force => "force_n",
            Sensor::Position => "position_m",
        }
    }
}

/// How far truth may be from the rig file, 1 σ.
#[derive(Debug, Clone, Copy)]
pub enum Prior {
    /// A share of the value.
    Share(f64),
    /// In the key's unit.
    Absolute(f64),
}

/// The parameters that are not known exactly, and how well they are.
pub const PRIORS: [(&str, Prior); 28] = [
    ("convection_w_per_m2_k", Prior::Share(0.2)),
    ("heating_steepness_per_k", Prior::Share(0.25)),
    ("cooling_steepness_per_k", Prior::Share(0.25)),
    ("austenite_resistivity_uohm_cm", Prior::Share(0.1)),
    ("martensite_resistivity_uohm_cm", Prior::Share(0.1)),
    ("austenite_resistivity_slope_uohm_cm_per_k", Prior::Share(0.3)),
    ("martensite_resistivity_slope_uohm_cm_per_k", Prior::Share(0.3)),
    ("transformation_strain", Prior::Share(0.15)),
    ("austenite_modulus_gpa", Prior::Share(0.15)),
    ("martensite_modulus_gpa", Prior::Share(0.15)),
    ("latent_heat_j_per_kg", Prior::Share(0.25)),
    ("specific_heat_j_per_kg_k", Prior::Share(0.05)),
    ("stress_shift_k_per_mpa", Prior::Share(0.2)),
    ("damping_n_s_per_m", Prior::Share(0.3)),
    ("austenite_temperature_c", Prior::Absolute(5.0)),
    ("martensite_temperature_c", Prior::Absolute(5.0)),
    ("ambient_c", Prior::Absolute(2.0)),
    // what a workshop's tools and a sensor's data sheet leave
    ("diameter_mm", Prior::Share(0.01)),
    ("length_mm", Prior::Share(0.005)),
    ("l0_mm", Prior::Share(0.007)),
    ("ls_mm", Prior::Share(0.007)),
    ("supply_v", Prior::Share(0.004)),
    ("shunt_ohm", Prior::Share(0.02)),
    ("mass_kg", Prior::Share(0.015)),
    ("spring_n_per_m", Prior::Share(0.03)),
    ("preload_n", Prior::Share(0.015)),
    ("sensing.gain.force", Prior::Share(0.01)),
    ("sensing.gain.position", Prior::Share(0.01)),
];

/// Farthest a true parameter is drawn from the rig file's, in σ.
const FARTHEST_SIGMA: f64 = 2.0;

impl Prior {
    /// 1 σ around a value.
    pub fn sigma(self, value: f64) -> f64 {
        match self {
            Prior::Share(share) => share * value.abs(),
            Prior::Absolute(sigma) => sigma,
        }
    }
}

/// Whether a bench is of the kind that development saw.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kin {
    /// Wires of 0.1–0.38 mm and 100–400 mm under 90–190 MPa.
    Alike,
    /// Thinner and thicker, shorter and longer wires under less and more stress.
    Unlike,
}

/// Which sensors a bench has.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Set {
    /// Taps, force and position.
    All,
    /// Position and resistance.
    PositionResistance,
    /// Position and force.
    PositionForce,
    /// Resistance only.
    Resistance,
    /// Position only.
    Position,
}

/// What a laboratory believes.
#[derive(Debug, Clone, PartialEq)]
pub struct Bench {
    /// The wire as in the rig file.
    pub believed: Truth,
    /// Whether there are taps.
    pub taps: bool,
    /// Sensors with their true noise, RMS.
    pub sensors: BTreeMap<Sensor, f64>,
    /// Noise of the measured supply, where it is recorded.
    pub supply_noise: Option<f64>,
    /// Samples a second.
    pub rate_hz: f64,
    /// Length of a recording, s.
    pub seconds: f64,
}

fn between(rng: &mut SmallRng, low: f64, high: f64) -> f64 {
    rng.random_range(low..=high)
}

/// `value` to so many significant digits, as a person would write it into a file.
pub fn tidy(value: f64, digits: i32) -> f64 {
    if value == 0.0 || !value.is_finite() {
        return value;
    }
    let scale = 10f64.powi(digits - 1 - value.abs().log10().floor() as i32);
    // divided rather than multiplied by the inverse: the shortest decimal comes out
    (value * scale).round() / scale
}

/// A material at random.
fn random_material(rng: &mut SmallRng) -> Material {
    let modulus = between(rng, 60.0, 85.0);
    let a = between(rng, 82.0, 100.0);
    Material {
        e_a: tidy(modulus, 3) * 1e9,
        e_m: tidy(between(rng, 24.0, 36.0), 3) * 1e9,
        eps_l: tidy(between(rng, 0.03, 0.05), 3),
        theta: 0.55e6,
        t0: 20.0,
        a: tidy(a, 3),
        m: tidy(a - between(rng, 18.0, 32.0), 3),
        shift: tidy(between(rng, 0.1, 0.14), 3) * 1e-6,
        k_a: tidy(between(rng, 0.2, 0.45), 3),
        k_m: tidy(between(rng, 0.2, 0.45), 3),
        w: tidy(between(rng, 0.6, 0.9), 2),
        density: 6450.0,
        c_p: tidy(between(rng, 780.0, 880.0), 3),
        latent: tidy(between(rng, 18e3, 28e3), 3),
        h: tidy(between(rng, 90.0, 150.0), 3),
        rho_a: tidy(between(rng, 78.0, 92.0), 3) * 1e-8,
        rho_m: tidy(between(rng, 68.0, 80.0), 3) * 1e-8,
        slope_a: 0.05e-8,
        slope_m: 0.15e-8,
    }
}

/// What hangs on a wire.
struct Load {
    /// Stress it is made for on the hot wire, Pa.
    stress: f64,
    /// N/m.
    spring: f64,
    /// N.
    preload: f64,
    /// kg.
    mass: f64,
    /// N s/m.
    damping: f64,
}

/// A load at random for a wire of this material, cross-section and length.
fn random_load(rng: &mut SmallRng, kin: Kin, material: &Material, area: f64, length: f64) -> Load {
    let stroke = material.eps_l * length;
    // hanging mass, stiff spring or soft bias spring, by the stress they put on hot and cold wire
    let stress = match kin {
        Kin::Alike => between(rng, 90e6, 190e6),
        Kin::Unlike if rng.random_bool(0.5) => between(rng, 45e6, 80e6),
        Kin::Unlike => between(rng, 210e6, 280e6),
    };
    let by = if kin == Kin::Alike { 1.0 } else { stress / 140e6 };
    let (spring, preload, mass) = match rng.random_range(0..3) {
        0 => (0.0, stress * area, stress * area / GRAVITY),
        kind => {
            let rise = if kind == 1 { by * between(rng, 90e6, 160e6) } else { by * between(rng, 20e6, 50e6) };
            let spring = rise * area / stroke;
            // the cold wire is about a tenth longer than its shape strain makes it
            let cold = by * between(rng, 70e6, 110e6);
            (spring, cold * area + spring * 1.1 * stroke, 0.7 * stress * area / GRAVITY)
        }
    };
    let mass = tidy(mass, 2);
    let preload = if spring == 0.0 { tidy(mass * GRAVITY, 6) } else { tidy(preload, 3) };
    let stiffness = material.e_a * area / length;
    let damping = tidy(2.0 * between(rng, 0.35, 0.6) * (stiffness * mass).sqrt(), 2);
    Load { stress, spring, preload, mass, damping }
}

/// The sensors of a set with noise at random, on a wire that bears `stress` hot.
fn random_sensors(rng: &mut SmallRng, set: Set, wire: &Truth, stress: f64) -> BTreeMap<Sensor, f64> {
    let stroke = wire.material.eps_l * wire.length;
    let mut noisy = |of: f64| tidy(of * between(rng, -0.7f64, 0.9).exp(), 2);
    let current = wire.supply / (wire.cold_ohm() + wire.series());
    let mut all = vec![
        (Sensor::Current, noisy(7e-4 * current)),
        (Sensor::V1, noisy(2.5e-4 * wire.supply)),
        (Sensor::V2, noisy(2.5e-4 * wire.supply)),
        (Sensor::V3, noisy(2.5e-4 * wire.supply)),
        (Sensor::Force, noisy(1.5e-3 * stress * wire.area())),
        (Sensor::Position, noisy(2.5e-3 * stroke)),
    ];
    all.retain(|(sensor, _)| match set {
        Set::All => *sensor != Sensor::V1 || wire.taps.first > 0.0,
        Set::PositionResistance => matches!(sensor, Sensor::Current | Sensor::V3 | Sensor::Position),
        Set::PositionForce => matches!(sensor, Sensor::Force | Sensor::Position),
        Set::Resistance => matches!(sensor, Sensor::Current | Sensor::V3),
        Set::Position => *sensor == Sensor::Position,
    });
    all.into_iter().collect()
}

impl Bench {
    /// A bench at random of such kin. `set` overrides which sensors there are; `long` makes 90 s at 200 Hz.
    pub fn random(rng: &mut SmallRng, kin: Kin, set: Option<Set>, long: bool) -> Bench {
        let (diameter, length) = match kin {
            Kin::Alike => {
                let diameter = [0.1e-3, 0.125e-3, 0.15e-3, 0.2e-3, 0.25e-3, 0.31e-3, 0.38e-3][rng.random_range(0..7)];
                (diameter, between(rng, 0.1, 0.4))
            }
            Kin::Unlike => {
                let diameter = [0.05e-3, 0.076e-3, 0.45e-3][rng.random_range(0..3)];
                let short = rng.random_bool(0.5);
                (diameter, if short { between(rng, 0.05, 0.08) } else { between(rng, 0.6, 1.1) })
            }
        };
        let length = tidy(length, 3);
        let material = random_material(rng);
        let area = std::f64::consts::FRAC_PI_4 * diameter * diameter;
        let Load { stress, spring, preload, mass, damping } = random_load(rng, kin, &material, area, length);
        // taps: from the fixed end, or a little away from it
        let l0 = if rng.random_bool(0.75) { 0.0 } else { tidy(0.03 * length, 2) };
        let mut believed = Truth {
            diameter,
            length,
            taps: Taps { first: l0, apart: tidy(0.93 * length - l0, 3) },
            supply: 0.0,
            shunt: 0.1,
            mass,
            damping,
            spring: tidy(spring, 3),
            preload,
            ambient: tidy(between(rng, 19.0, 27.0), 3),
            material,
            beyond: Default::default(),
        };
        // a supply that transforms the wire in about so many seconds at four fifths of its power
        let transforms_in = between(rng, 0.5, 2.0);
        let rise = believed.hot() - believed.ambient;
        let energy = believed.wire_mass() * (material.c_p * rise + material.latent);
        let power = (energy / transforms_in + 0.7 * believed.loss_w_per_k() * rise) / 0.8;
        let ohm = believed.cold_ohm();
        believed.supply = tidy((power / ohm).sqrt() * (ohm + believed.series()), 2);

        let set = set.unwrap_or_else(|| match rng.random_range(0..20) {
            0..10 => Set::All,
            10..15 => Set::PositionResistance,
            15..17 => Set::PositionForce,
            17..19 => Set::Resistance,
            _ => Set::Position,
        });
        let taps = set == Set::All;
        let sensors = random_sensors(rng, set, &believed, stress);
        let supply_noise = if rng.random_bool(0.5) { Some(tidy(5e-4 * believed.supply, 2)) } else { None };
        // thick wires are slow: they get a dozen of their time constants at least, within the minute
        let tau = believed.wire_mass() * material.c_p / believed.loss_w_per_k();
        let seconds: f64 = [30.0, 40.0, 50.0, 60.0][rng.random_range(0..4)];
        let (rate_hz, seconds) =
            if long { (200.0, 90.0) } else { (100.0, seconds.max((1.2 * tau).ceil() * 10.0).min(60.0)) };
        Bench { believed, taps, sensors, supply_noise, rate_hz, seconds }
    }

    /// The truth: every uncertain parameter drawn from its prior around what is believed.
    pub fn scattered(&self, rng: &mut SmallRng) -> Truth {
        let mut truth = self.believed.clone();
        for (key, prior) in PRIORS {
            let value = self.believed.get(key);
            let z = loop {
                let z: f64 = rng.sample(StandardNormal);
                if z.abs() <= FARTHEST_SIGMA {
                    break z;
                }
            };
            truth.set(key, value + z * prior.sigma(value));
        }
        truth.material.m = truth.material.m.min(truth.material.a - 8.0);
        truth
    }

    /// The rig file.
    pub fn rig_toml(&self, name: &str) -> String {
        let b = &self.believed;
        let mut text = String::new();
        let mut line = |l: String| {
            text.push_str(&l);
            text.push('\n');
        };
        line(format!("# {name}: what is believed of this rig\n[rig]\nname = \"{name}\""));
        line(format!("rate_hz = {:?}\nambient_c = {:?}\n", self.rate_hz, b.ambient));
        line("[[channel]]\nname = \"wire\"\n\n[channel.wire]".into());
        line(format!("diameter_mm = {}\nlength_mm = {}\n", tidy(b.diameter * 1e3, 6), tidy(b.length * 1e3, 6)));
        if self.taps {
            let (l0, ls) = (tidy(b.taps.first * 1e3, 6), tidy(b.taps.apart * 1e3, 6));
            line(format!("[channel.taps]\nl0_mm = {l0}\nls_mm = {ls}\n"));
        }
        line(format!("[channel.drive]\nsupply_v = {}\nshunt_ohm = 0.1\nswitch_ohm = 0.02\n", b.supply));
        line(format!("[channel.load]\nmass_kg = {}\ndamping_n_s_per_m = {}", b.mass, b.damping));
        line(format!("spring_n_per_m = {}\npreload_n = {}\n", b.spring, b.preload));
        line("[channel.material]".into());
        let mut rest = String::new();
        for key in MATERIAL_KEYS {
            let _ = writeln!(rest, "{key} = {}", tidy(b.get(key), 8));
        }
        text + &rest
    }
}

/// The keys of the rig file's `[channel.material]`.
const MATERIAL_KEYS: [&str; 19] = [
    "austenite_modulus_gpa",
    "martensite_modulus_gpa",
    "transformation_strain",
    "thermoelastic_mpa_per_k",
    "reference_temperature_c",
    "austenite_temperature_c",
    "martensite_temperature_c",
    "stress_shift_k_per_mpa",
    "heating_steepness_per_k",
    "cooling_steepness_per_k",
    "outer_loop_weight",
    "density_kg_per_m3",
    "specific_heat_j_per_kg_k",
    "latent_heat_j_per_kg",
    "convection_w_per_m2_k",
    "austenite_resistivity_uohm_cm",
    "martensite_resistivity_uohm_cm",
    "austenite_resistivity_slope_uohm_cm_per_k",
    "martensite_resistivity_slope_uohm_cm_per_k",
];

impl Truth {
    /// A temperature at which the wire is wholly austenite in its load, °C.
    pub fn hot(&self) -> f64 {
        self.material.a + self.material.shift * self.stress_hot() + 8.0 / self.material.k_a.max(0.15)
    }

    /// Stress of the wire when it is short, Pa.
    pub fn stress_hot(&self) -> f64 {
        self.preload / self.area()
    }

    /// h A_s, W/K.
    pub fn loss_w_per_k(&self) -> f64 {
        self.material.h * self.surface()
    }

    /// Resistance of the cold wire, Ω.
    pub fn cold_ohm(&self) -> f64 {
        self.material.rho_m * self.length * (1.0 + self.material.eps_l) / self.area()
    }
}
