//! Sizes: what one unit of each effect is on a given bench, and how much of it a rig may show.

use std::collections::BTreeMap;

use rand::RngExt;
use rand::rngs::SmallRng;

use super::bench::{Bench, Sensor};
use super::truth::{Effects, EndStop, Truth, Wave};
use super::world::{Concealed, World};

/// An effect of the catalogue, as this generator puts it in.
#[derive(Debug, Clone, Copy)]
pub struct Kind {
    /// Its id.
    pub id: &'static str,
    /// Largest size, in units of the natural one.
    pub most: f64,
    /// A sensor without which it means nothing.
    pub needs: Option<Sensor>,
    /// Whether it may be a member of a pair: it must be able to show.
    pub shows: bool,
}

/// One that shows in every sensor.
pub const fn kind(id: &'static str, most: f64) -> Kind {
    Kind { id, most, needs: None, shows: true }
}

/// One that may not show beside another.
pub const fn faint(id: &'static str, most: f64) -> Kind {
    Kind { id, most, needs: None, shows: false }
}

/// One that means nothing without a sensor.
pub const fn with(id: &'static str, most: f64, needs: Sensor) -> Kind {
    Kind { id, most, needs: Some(needs), shows: true }
}

/// The catalogue but for `thermal.neighbour`: a recording of one channel does not have the other wire's temperature,
/// and to a neighbour of constant temperature the loss is convection by another name.
pub const CATALOGUE: [Kind; 33] = [
    kind("thermal.latent_heat", 1.3),
    kind("kinetic.stress_shift", 1.2),
    kind("kinetic.minor_loop", 1.1),
    kind("mechanical.phase_modulus", 1.0),
    faint("mechanical.thermal_expansion", 1.5),
    with("electrical.resistivity_temperature", 1.5, Sensor::V3),
    kind("thermal.draught", 4.0),
    kind("thermal.natural_convection", 2.5),
    faint("thermal.radiation", 1.2),
    kind("thermal.end_conduction", 1.4),
    kind("thermal.sheath", 3.0),
    kind("thermal.ambient_drift", 3.0),
    with("electrical.supply_sag", 6.0, Sensor::V3),
    with("electrical.lead_resistance", 6.0, Sensor::V3),
    with("electrical.resistivity_stress", 4.0, Sensor::V3),
    Kind { id: "electrical.poisson_area", most: 1.5, needs: Some(Sensor::V3), shows: false },
    with("electrical.r_phase", 2.0, Sensor::V3),
    kind("kinetic.asymmetry", 2.5),
    kind("kinetic.unequal_slopes", 3.0),
    kind("kinetic.distributed", 3.0),
    kind("kinetic.lag", 5.0),
    kind("kinetic.training_drift", 4.0),
    kind("mechanical.friction", 3.0),
    kind("mechanical.capstan", 4.0),
    kind("mechanical.ratcheting", 10.0),
    with("mechanical.frame_compliance", 5.0, Sensor::Position),
    kind("mechanical.stress_dependent_strain", 2.5),
    faint("mechanical.two_way", 3.0),
    with("sensing.contact_resistance", 6.0, Sensor::V3),
    with("sensing.probe_deflection", 10.0, Sensor::V2),
    with("sensing.offset", 20.0, Sensor::V3),
    with("sensing.gain", 5.0, Sensor::V3),
    with("sensing.delay", 10.0, Sensor::Position),
];

/// What is outside the catalogue: name, the equations it may be found in, largest size.
pub const OUTSIDE: [(&str, &[&str], f64); 13] = [
    ("end stop of the load", &["mechanical"], 10.0),
    ("spring that hardens with the cube", &["mechanical"], 8.0),
    ("leakage beside the wire", &["electrical"], 6.0),
    ("contact that loosens with falling tension", &["electrical", "sensing"], 8.0),
    ("loss that depends on position", &["thermal"], 4.0),
    ("backlash of the encoder", &["sensing", "mechanical"], 30.0),
    ("drag with the square of speed", &["mechanical"], 60.0),
    ("the wire's own plume", &["thermal"], 4.0),
    ("periodic error of the encoder", &["sensing", "mechanical"], 20.0),
    ("supply that drops with duty", &["electrical"], 10.0),
    ("shape strain that fatigues", &["mechanical", "kinetic"], 12.0),
    ("ambient that swings", &["thermal"], 5.0),
    ("cosine kinetics", &["kinetic"], 1.0),
];

impl World for Truth {
    const LEVEL_STEP_S: f64 = 4e-4;

    fn coefficients(&self) -> &Truth {
        self
    }

    fn coefficients_mut(&mut self) -> &mut Truth {
        self
    }

    fn perfect(&self, bench: &Bench, duty: &[f64], step_s: f64) -> Vec<Vec<f64>> {
        super::signals::perfect(bench, self, duty, step_s)
    }
}

impl Concealed<Truth> for Drawn {
    fn put_into(&self, bench: &Bench, truth: &mut Truth, size: f64) {
        self.put(bench, truth, size, &mut Effects::new());
    }

    fn most(&self) -> f64 {
        let known = CATALOGUE.iter().find(|k| k.id == self.id).map(|k| k.most);
        known.or_else(|| OUTSIDE.iter().find(|(name, _, _)| *name == self.id).map(|(_, _, most)| *most)).unwrap_or(1.0)
    }

    fn is_fixed(&self) -> bool {
        self.id == "cosine kinetics"
    }
}

/// An effect of some size on one bench: what was drawn once stays while the size is sought.
#[derive(Debug, Clone)]
pub struct Drawn {
    id: String,
    u: [f64; 4],
    sign: f64,
}

impl Drawn {
    /// Draws what is random about an effect.
    pub fn new(rng: &mut SmallRng, id: &str) -> Drawn {
        let u = std::array::from_fn(|_| rng.random_range(0.0..1.0));
        Drawn { id: id.to_string(), u, sign: if rng.random_bool(0.5) { 1.0 } else { -1.0 } }
    }

    /// Its id or name.
    pub fn id(&self) -> &str {
        &self.id
    }

    /// The rig file's keys of a coefficient effect at its null, as the laboratory believes it.
    pub fn null(&self, believed: &Truth) -> Vec<(&'static str, f64)> {
        match self.id.as_str() {
            "thermal.latent_heat" => vec![("latent_heat_j_per_kg", 0.0)],
            "kinetic.stress_shift" => vec![("stress_shift_k_per_mpa", 0.0)],
            "kinetic.minor_loop" => vec![("outer_loop_weight", 0.0)],
            "mechanical.phase_modulus" => vec![("martensite_modulus_gpa", believed.get("austenite_modulus_gpa"))],
            "mechanical.thermal_expansion" => vec![("thermoelastic_mpa_per_k", 0.0)],
            "electrical.resistivity_temperature" => vec![
                ("austenite_resistivity_slope_uohm_cm_per_k", 0.0),
                ("martensite_resistivity_slope_uohm_cm_per_k", 0.0),
            ],
            _ => Vec::new(),
        }
    }

    /// Parameters of a catalogue effect at `size` natural units, in the rig file's units, and which of them make its
    /// size.
    pub fn parameters(&self, bench: &Bench, truth: &Truth, size: f64) -> (BTreeMap<String, f64>, Vec<&'static str>) {
        let between = |i: usize, low: f64, high: f64| low + (high - low) * self.u[i];
        let m = &bench.believed.material;
        let wire = &bench.believed;
        let ohm = wire.cold_ohm();
        let force = wire.area() * 0.5 * (wire.stress_hot() + 1e8);
        let stroke = m.eps_l * wire.length;
        let sign = self.sign;
        let signed = sign * size;
        let list: Vec<(&'static str, f64)> = match self.id.as_str() {
            "thermal.latent_heat" => vec![("latent_heat_j_per_kg", size * between(0, 20e3, 26e3))],
            "kinetic.stress_shift" => vec![("stress_shift_k_per_mpa", size * between(0, 0.1, 0.13))],
            "kinetic.minor_loop" => vec![("outer_loop_weight", size * between(0, 0.7, 0.85))],
            "mechanical.phase_modulus" => {
                let e_a = truth.get("austenite_modulus_gpa");
                vec![("martensite_modulus_gpa", e_a + size * (between(0, 25.0, 35.0) - e_a))]
            }
            "mechanical.thermal_expansion" => vec![("thermoelastic_mpa_per_k", size * 0.55)],
            "electrical.resistivity_temperature" => vec![
                ("austenite_resistivity_slope_uohm_cm_per_k", size * 0.05),
                ("martensite_resistivity_slope_uohm_cm_per_k", size * 0.15),
            ],
            "thermal.draught" => {
                let start = bench.seconds * between(0, 0.12, 0.55);
                let gain = if sign < 0.0 && self.u[2] < 0.4 { -0.2 * size.min(3.5) } else { 0.35 * size };
                vec![("gain", gain), ("start_s", start), ("end_s", start + bench.seconds * between(1, 0.15, 0.35))]
            }
            "thermal.natural_convection" => vec![("exponent", size / 6.0)],
            "thermal.radiation" => vec![("emissivity", 0.8 * size)],
            "thermal.end_conduction" => vec![("conductivity_w_per_m_k", 18.0 * size)],
            "thermal.sheath" => {
                let loss = wire.loss_w_per_k();
                let outer = loss * between(0, 1.0, 1.5);
                vec![
                    ("heat_capacity_j_per_k", size * wire.wire_mass() * m.c_p),
                    ("inner_w_per_k", loss * between(1, 3.0, 8.0)),
                    ("outer_w_per_k", outer),
                ]
            }
            "thermal.ambient_drift" => vec![("rate_k_per_s", signed * 4.0 / bench.seconds)],
            "electrical.supply_sag" => vec![("source_ohm", 0.03 * size * ohm)],
            "electrical.lead_resistance" => vec![("lead_ohm", 0.03 * size * ohm)],
            "electrical.resistivity_stress" => {
                vec![("austenite_per_gpa", signed * 0.2), ("martensite_per_gpa", signed * between(0, 0.1, 0.4))]
            }
            "electrical.poisson_area" => vec![("ratio", 0.33 * size)],
            "electrical.r_phase" => vec![
                ("peak_uohm_cm", 6.0 * size),
                ("temperature_c", m.m - between(0, 2.0, 18.0)),
                ("width_k", between(1, 5.0, 12.0)),
            ],
            "kinetic.asymmetry" => {
                let skew = (0.6 * signed).exp();
                match (self.u[0] * 3.0) as usize {
                    0 => vec![("heating_skew", skew), ("cooling_skew", 1.0)],
                    1 => vec![("heating_skew", 1.0), ("cooling_skew", skew)],
                    _ => vec![("heating_skew", skew), ("cooling_skew", (0.6 * size * between(1, -1.0, 1.0)).exp())],
                }
            }
            "kinetic.unequal_slopes" => vec![("cooling_extra_k_per_mpa", 0.02 * signed)],
            "kinetic.distributed" => vec![("spread_k", 4.0 * size)],
            "kinetic.lag" => vec![("seconds", 0.15 * size)],
            "kinetic.training_drift" => vec![("kelvin_per_cycle", 0.4 * signed)],
            "mechanical.friction" => vec![("coulomb_n", 0.05 * size * force)],
            "mechanical.capstan" => vec![("mu_theta", 0.05 * size)],
            "mechanical.ratcheting" => vec![("strain_per_cycle", 1e-4 * size)],
            "mechanical.frame_compliance" => vec![("compliance_m_per_n", 0.02 * size * stroke / force)],
            "mechanical.stress_dependent_strain" => vec![("stress_scale_mpa", 50.0 * size)],
            "mechanical.two_way" => vec![("strain", 0.1 * size * m.eps_l)],
            "sensing.contact_resistance" => vec![("ohm", 0.03 * size * ohm)],
            "sensing.probe_deflection" => vec![("m_per_n", 1e-4 * size * 2.0 / force)],
            "sensing.offset" => {
                let current = wire.supply / ohm;
                if self.u[0] < 0.5 || !bench.sensors.contains_key(&Sensor::V2) {
                    if self.u[1] < 0.5 {
                        vec![("v3_v", signed * 2e-3 * wire.supply)]
                    } else {
                        vec![("current_a", signed * 2e-3 * current)]
                    }
                } else {
                    vec![("v2_v", signed * 2e-3 * wire.supply)]
                }
            }
            "sensing.gain" => {
                let key = if self.u[0] < 0.5 { "v3" } else { "current" };
                vec![(key, 1.0 + 0.01 * signed)]
            }
            "sensing.delay" => vec![("seconds", 0.03 * size)],
            _ => Vec::new(),
        };
        let shape = ["start_s", "end_s", "inner_w_per_k", "outer_w_per_k", "temperature_c", "width_k"];
        let sizes = list.iter().map(|(key, _)| *key).filter(|key| !shape.contains(key)).collect();
        (list.into_iter().map(|(key, value)| (key.to_string(), super::bench::tidy(value, 4))).collect(), sizes)
    }

    /// Puts the effect into a truth; for a catalogue effect also into `effects`.
    pub fn put(&self, bench: &Bench, truth: &mut Truth, size: f64, effects: &mut Effects) {
        let (parameters, _) = self.parameters(bench, truth, size);
        if parameters.is_empty() {
            self.put_outside(bench, truth, size);
        } else if truth.put(&self.id, &parameters) {
            effects.insert(self.id.clone(), parameters);
        }
    }

    fn put_outside(&self, bench: &Bench, truth: &mut Truth, size: f64) {
        let wire = &bench.believed;
        let stroke = wire.material.eps_l * wire.length;
        let force = wire.area() * 0.5 * (wire.stress_hot() + 1e8);
        let ohm = wire.cold_ohm();
        let stiffness = wire.material.e_a * wire.area() / wire.length;
        let o = &mut truth.beyond.outside;
        match self.id.as_str() {
            "end stop of the load" => {
                o.end_stop = EndStop { at: stroke * (0.03 + 0.05 * size), stiffness: 0.5 * stiffness };
            }
            "spring that hardens with the cube" => o.cubic = 0.05 * size * force / stroke.powi(3),
            "leakage beside the wire" => o.leakage = 0.05 * size / ohm,
            "contact that loosens with falling tension" => o.loose_contact = 0.03 * size * ohm * force.sqrt(),
            "loss that depends on position" => o.moved_loss = 0.25 * size,
            "backlash of the encoder" => o.backlash = 2e-3 * size * stroke,
            "drag with the square of speed" => o.drag = 0.05 * size * force / (4.0 * stroke * stroke),
            "the wire's own plume" => o.plume = 0.2 * size,
            "periodic error of the encoder" => {
                o.encoder = Wave { amplitude: 4e-3 * size * stroke, period: (0.1 + 0.2 * self.u[0]) * stroke };
            }
            "supply that drops with duty" => o.duty_drop = 0.02 * size,
            "shape strain that fatigues" => o.fatigue = 3e-3 * size,
            "ambient that swings" => o.ambient_swing = Wave { amplitude: size, period: 12.0 + 15.0 * self.u[0] },
            "cosine kinetics" => truth.beyond.cosine = true,
            _ => {}
        }
    }
}
