//! What the second generator conceals: effects of the catalogue in its own words, and eight mechanisms that were never
//! used while the diagnosis was developed. They are in no catalogue and not in the first generator.

use std::collections::BTreeMap;

use rand::RngExt;
use rand::rngs::SmallRng;

use super::super::generator::bench::{Bench, Sensor, tidy};
use super::super::generator::magnitudes::{Kind, faint, kind, with};
use super::super::generator::truth::Effects;
use super::super::generator::world::Concealed;
use super::world::World;

/// What of the catalogue is concealed.
pub const CATALOGUE: [Kind; 22] = [
    kind("thermal.latent_heat", 1.3),
    kind("thermal.draught", 4.0),
    faint("thermal.radiation", 1.2),
    kind("thermal.sheath", 3.0),
    kind("thermal.ambient_drift", 3.0),
    faint("thermal.elastic_work", 1.5),
    kind("kinetic.stress_shift", 1.2),
    kind("kinetic.lag", 5.0),
    kind("kinetic.training_drift", 4.0),
    with("electrical.resistivity_temperature", 1.5, Sensor::V3),
    with("electrical.lead_resistance", 6.0, Sensor::V3),
    with("electrical.resistivity_stress", 4.0, Sensor::V3),
    with("electrical.r_phase", 2.0, Sensor::V3),
    kind("mechanical.phase_modulus", 1.0),
    kind("mechanical.friction", 3.0),
    kind("mechanical.capstan", 4.0),
    kind("mechanical.ratcheting", 10.0),
    with("mechanical.frame_compliance", 5.0, Sensor::Position),
    kind("mechanical.stress_dependent_strain", 2.5),
    with("sensing.contact_resistance", 6.0, Sensor::V3),
    with("sensing.probe_deflection", 10.0, Sensor::V2),
    with("sensing.delay", 10.0, Sensor::Position),
];

/// A mechanism never used in development.
#[derive(Debug, Clone, Copy)]
pub struct Novel {
    /// In words.
    pub name: &'static str,
    /// What it adds.
    pub equation: &'static str,
    /// Equations it may be found in.
    pub equations: &'static [&'static str],
    /// Largest size, in natural units.
    pub most: f64,
}

/// The eight.
pub const NOVEL: [Novel; 8] = [
    Novel {
        name: "creep of the crimp",
        equation: "x → x + s, ṡ = c (F/F_0)/(t + t_c), t_c from 1 to 4 s",
        equations: &["mechanical", "sensing"],
        most: 20.0,
    },
    Novel {
        name: "moisture film on the wire",
        equation: "heat − h A_s (Q/Q_0)(T − T∞) while T > T∞, Q̇ the same, until Q = 0",
        equations: &["thermal"],
        most: 20.0,
    },
    Novel {
        name: "enclosure that warms",
        equation: "T∞ → T_b, C_b Ṫ_b = loss − G_b (T_b − T∞), C_b/G_b from 5 to 15 s",
        equations: &["thermal"],
        most: 6.0,
    },
    Novel {
        name: "joint that heats",
        equation: "V_3 = I (R + R_j), R_j = r p, τ ṗ = D I² max(R_j, r) − p, τ from 0.5 to 3 s",
        equations: &["electrical", "sensing"],
        most: 10.0,
    },
    Novel {
        name: "pickup of the PWM's edges",
        equation: "V_3 → V_3 + κ V_s/D",
        equations: &["sensing", "electrical"],
        most: 30.0,
    },
    Novel {
        name: "R-phase that keeps strain back on cooling",
        equation: "ε_L ξ → ε_L ξ (1 − 4 p ξ (1 − ξ) z), z 1 while martensite forms and 0 while it goes, moved over 0.02 of ξ",
        equations: &["mechanical", "kinetic"],
        most: 6.0,
    },
    Novel {
        name: "tendon that flows",
        equation: "x → x + y, τ ẏ = C_t F − y, τ from 0.5 to 4 s",
        equations: &["mechanical"],
        most: 20.0,
    },
    Novel {
        name: "detents of the pulley",
        equation: "M ẍ + … = … − F_d sin(2π x/p), p from 0.12 to 0.3 of the stroke",
        equations: &["mechanical"],
        most: 8.0,
    },
];

/// An effect of some size on one bench: what was drawn once stays while the size is sought.
#[derive(Debug, Clone)]
pub struct Drawn {
    id: String,
    u: [f64; 3],
    sign: f64,
}

/// One unit of things on a bench.
struct Units {
    ohm: f64,
    force: f64,
    stroke: f64,
    loss: f64,
    capacity: f64,
    supply: f64,
    seconds: f64,
}

impl Units {
    fn of(bench: &Bench) -> Units {
        let b = &bench.believed;
        Units {
            ohm: b.cold_ohm(),
            force: b.area() * 0.5 * (b.stress_hot() + 1e8),
            stroke: b.material.eps_l * b.length,
            loss: b.loss_w_per_k(),
            capacity: b.wire_mass() * b.material.c_p,
            supply: b.supply,
            seconds: bench.seconds,
        }
    }
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

    /// Parameters at `size` natural units, in the catalogue's keys and units; empty for what no catalogue has.
    pub fn parameters(&self, bench: &Bench, world: &World, size: f64) -> BTreeMap<String, f64> {
        let n = Units::of(bench);
        let between = |i: usize, low: f64, high: f64| low + (high - low) * self.u[i];
        let signed = self.sign * size;
        let list: Vec<(&str, f64)> = match self.id.as_str() {
            "thermal.latent_heat" => vec![("latent_heat_j_per_kg", size * between(0, 20e3, 26e3))],
            "thermal.draught" => {
                let start = n.seconds * between(0, 0.12, 0.55);
                vec![("gain", 0.35 * size), ("start_s", start), ("end_s", start + n.seconds * between(1, 0.15, 0.35))]
            }
            "thermal.radiation" => vec![("emissivity", 0.8 * size)],
            "thermal.sheath" => vec![
                ("heat_capacity_j_per_k", size * n.capacity),
                ("inner_w_per_k", n.loss * between(1, 3.0, 8.0)),
                ("outer_w_per_k", n.loss * between(0, 1.0, 1.5)),
            ],
            "thermal.ambient_drift" => vec![("rate_k_per_s", signed * 4.0 / n.seconds)],
            "thermal.elastic_work" => vec![("share", size)],
            "kinetic.stress_shift" => vec![("stress_shift_k_per_mpa", size * between(0, 0.1, 0.13))],
            "kinetic.lag" => vec![("seconds", 0.15 * size)],
            "kinetic.training_drift" => vec![("kelvin_per_cycle", 0.4 * signed)],
            "electrical.resistivity_temperature" => vec![
                ("austenite_resistivity_slope_uohm_cm_per_k", size * 0.05),
                ("martensite_resistivity_slope_uohm_cm_per_k", size * 0.15),
            ],
            "electrical.lead_resistance" => vec![("lead_ohm", 0.03 * size * n.ohm)],
            "electrical.resistivity_stress" => {
                vec![("austenite_per_gpa", 0.2 * signed), ("martensite_per_gpa", signed * between(0, 0.1, 0.4))]
            }
            "electrical.r_phase" => vec![
                ("peak_uohm_cm", 6.0 * size),
                ("temperature_c", bench.believed.material.m - between(0, 2.0, 18.0)),
                ("width_k", between(1, 5.0, 12.0)),
            ],
            "mechanical.phase_modulus" => {
                let e_a = world.plain.get("austenite_modulus_gpa");
                vec![("martensite_modulus_gpa", e_a + size * (between(0, 25.0, 35.0) - e_a))]
            }
            "mechanical.friction" => vec![("coulomb_n", 0.05 * size * n.force)],
            "mechanical.capstan" => vec![("mu_theta", 0.05 * size)],
            "mechanical.ratcheting" => vec![("strain_per_cycle", 1e-4 * size)],
            "mechanical.frame_compliance" => vec![("compliance_m_per_n", 0.02 * size * n.stroke / n.force)],
            "mechanical.stress_dependent_strain" => vec![("stress_scale_mpa", 50.0 * size)],
            "sensing.contact_resistance" => vec![("ohm", 0.03 * size * n.ohm)],
            "sensing.probe_deflection" => vec![("m_per_n", 2e-4 * size / n.force)],
            "sensing.delay" => vec![("seconds", 0.03 * size)],
            _ => Vec::new(),
        };
        list.into_iter().map(|(key, value)| (key.to_string(), tidy(value, 4))).collect()
    }

    /// Which of the parameters make the size.
    pub fn sizes(&self, bench: &Bench, world: &World) -> Vec<String> {
        let shape = ["start_s", "end_s", "inner_w_per_k", "outer_w_per_k", "temperature_c", "width_k"];
        let keys = self.parameters(bench, world, 1.0).into_keys();
        keys.filter(|key| !shape.contains(&key.as_str())).collect()
    }

    /// The rig file's keys of a coefficient at its null.
    pub fn null(&self, bench: &Bench) -> Vec<(&'static str, f64)> {
        match self.id.as_str() {
            "thermal.latent_heat" => vec![("latent_heat_j_per_kg", 0.0)],
            "kinetic.stress_shift" => vec![("stress_shift_k_per_mpa", 0.0)],
            "mechanical.phase_modulus" => {
                vec![("martensite_modulus_gpa", bench.believed.get("austenite_modulus_gpa"))]
            }
            "electrical.resistivity_temperature" => vec![
                ("austenite_resistivity_slope_uohm_cm_per_k", 0.0),
                ("martensite_resistivity_slope_uohm_cm_per_k", 0.0),
            ],
            _ => Vec::new(),
        }
    }

    fn put_novel(&self, bench: &Bench, world: &mut World, size: f64) {
        let n = Units::of(bench);
        let between = |low: f64, high: f64| low + (high - low) * self.u[0];
        let h = &mut world.hidden;
        match self.id.as_str() {
            "creep of the crimp" => h.creep = [2e-3 * size * n.stroke, between(1.0, 4.0)],
            "moisture film on the wire" => h.moisture = 0.5 * size * n.capacity * 60.0,
            "enclosure that warms" => {
                let out = n.loss * 20.0 / size;
                h.enclosure = [out * between(5.0, 15.0), out];
            }
            "joint that heats" => {
                let current = n.supply / n.ohm;
                h.hot_joint = [0.03 * size * n.ohm / (0.1 * current * current * n.ohm), between(0.5, 3.0)];
            }
            "pickup of the PWM's edges" => h.pickup = 2e-5 * size,
            "R-phase that keeps strain back on cooling" => h.plateau = 0.02 * size,
            "tendon that flows" => h.tendon = [0.01 * size * n.stroke / n.force, between(0.5, 4.0)],
            "detents of the pulley" => h.detents = [0.03 * size * n.force, n.stroke * between(0.12, 0.3)],
            _ => {}
        }
    }

    /// Puts the effect into a world; a catalogue effect also into `effects`.
    pub fn put(&self, bench: &Bench, world: &mut World, size: f64, effects: &mut Effects) {
        let parameters = self.parameters(bench, world, size);
        if parameters.is_empty() {
            return self.put_novel(bench, world, size);
        }
        let get = |key: &str| parameters.get(key).copied().unwrap_or(0.0);
        let h = &mut world.hidden;
        match self.id.as_str() {
            "thermal.draught" => h.wind = [get("gain"), get("start_s"), get("end_s")],
            "thermal.radiation" => h.emissivity = get("emissivity"),
            "thermal.sheath" => {
                h.sleeve = [get("heat_capacity_j_per_k"), get("inner_w_per_k"), get("outer_w_per_k")];
            }
            "thermal.ambient_drift" => h.ambient_rate = get("rate_k_per_s"),
            "thermal.elastic_work" => h.elastic_work = get("share"),
            "kinetic.lag" => h.lag = get("seconds"),
            "kinetic.training_drift" => h.training = get("kelvin_per_cycle"),
            "electrical.lead_resistance" => h.lead = get("lead_ohm"),
            "electrical.resistivity_stress" => {
                h.piezo = ["austenite_per_gpa", "martensite_per_gpa"].map(|key| 1e-9 * get(key));
            }
            "electrical.r_phase" => h.r_phase = [1e-8 * get("peak_uohm_cm"), get("temperature_c"), get("width_k")],
            "mechanical.friction" => h.friction = get("coulomb_n"),
            "mechanical.capstan" => h.capstan = get("mu_theta"),
            "mechanical.ratcheting" => h.ratcheting = get("strain_per_cycle"),
            "mechanical.frame_compliance" => h.frame = get("compliance_m_per_n"),
            "mechanical.stress_dependent_strain" => h.orienting = 1e6 * get("stress_scale_mpa"),
            "sensing.contact_resistance" => h.joint = get("ohm"),
            "sensing.probe_deflection" => h.probe = get("m_per_n"),
            "sensing.delay" => h.delay = get("seconds"),
            _ => parameters.iter().for_each(|(key, value)| world.plain.set(key, *value)),
        }
        effects.insert(self.id.clone(), parameters);
    }
}

impl Concealed<World> for Drawn {
    fn put_into(&self, bench: &Bench, world: &mut World, size: f64) {
        self.put(bench, world, size, &mut Effects::new());
    }

    fn most(&self) -> f64 {
        let known = CATALOGUE.iter().find(|k| k.id == self.id).map(|k| k.most);
        known.or_else(|| NOVEL.iter().find(|n| n.name == self.id).map(|n| n.most)).unwrap_or(1.0)
    }

    fn is_fixed(&self) -> bool {
        false
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::generator::magnitudes::OUTSIDE;

    /// None of the eight is an effect of the project's catalogue or a mechanism of the first generator.
    #[test]
    fn what_is_never_used_in_development_is_nowhere_else() {
        for novel in &NOVEL {
            assert!(!OUTSIDE.iter().any(|(name, _, _)| *name == novel.name), "{}", novel.name);
            assert!(sinew_physics::effects::effect(novel.name).is_none(), "{}", novel.name);
        }
        for kind in &CATALOGUE {
            assert!(sinew_physics::effects::effect(kind.id).is_some(), "{}", kind.id);
        }
    }
}
