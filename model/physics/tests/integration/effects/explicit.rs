//! What the contract says of every effect, one setting of each, and its term against an explicit integration of the
//! contract's equations in steps of 40 µs, for a wire on its outer curves under an imposed tension: another way to every
//! term that acts there. It reads the catalogue's numbers, not the simulator's.

use sinew_physics::effects::effect;
use sinew_physics::*;

use super::common::{duty, hanging, set_all};

/// An id, its switches with their nulls, its shapes.
pub type Row = (&'static str, &'static [(&'static str, f64)], &'static [&'static str]);

/// The contract: ids, their switches with nulls, their shapes. What is not physics of the wire alone (the other channel
/// of a neighbour, the sensor of a delay) is not a number.
pub const CONTRACT: &[Row] = &[
    ("thermal.latent_heat", &[("latent_heat_j_per_kg", 0.0)], &[]),
    ("kinetic.stress_shift", &[("stress_shift_k_per_mpa", 0.0)], &[]),
    ("kinetic.minor_loop", &[("outer_loop_weight", 0.0)], &[]),
    // null where it equals the austenite modulus, 75 GPa by default
    ("mechanical.phase_modulus", &[("martensite_modulus_gpa", 75.0)], &[]),
    ("mechanical.thermal_expansion", &[("thermoelastic_mpa_per_k", 0.0)], &[]),
    (
        "electrical.resistivity_temperature",
        &[("austenite_resistivity_slope_uohm_cm_per_k", 0.0), ("martensite_resistivity_slope_uohm_cm_per_k", 0.0)],
        &[],
    ),
    ("thermal.draught", &[("gain", 0.0)], &["start_s", "end_s"]),
    ("thermal.natural_convection", &[("exponent", 0.0)], &[]),
    ("thermal.radiation", &[("emissivity", 0.0)], &[]),
    ("thermal.end_conduction", &[("conductivity_w_per_m_k", 0.0)], &[]),
    ("thermal.sheath", &[("heat_capacity_j_per_k", 0.0)], &["inner_w_per_k", "outer_w_per_k"]),
    ("thermal.ambient_drift", &[("rate_k_per_s", 0.0)], &[]),
    ("thermal.neighbour", &[("conductance_w_per_k", 0.0)], &[]),
    ("thermal.elastic_work", &[("share", 0.0)], &[]),
    ("electrical.supply_sag", &[("source_ohm", 0.0)], &[]),
    ("electrical.lead_resistance", &[("lead_ohm", 0.0)], &[]),
    ("electrical.resistivity_stress", &[("austenite_per_gpa", 0.0), ("martensite_per_gpa", 0.0)], &[]),
    ("electrical.poisson_area", &[("ratio", 0.0)], &[]),
    ("electrical.r_phase", &[("peak_uohm_cm", 0.0)], &["temperature_c", "width_k"]),
    ("kinetic.asymmetry", &[("heating_skew", 1.0), ("cooling_skew", 1.0)], &[]),
    (
        "kinetic.curves",
        &[
            ("heating_cold_tail", 0.0),
            ("heating_cold_shoulder", 0.0),
            ("heating_cold_knee", 0.0),
            ("heating_hot_knee", 0.0),
            ("heating_hot_shoulder", 0.0),
            ("heating_hot_tail", 0.0),
            ("cooling_cold_tail", 0.0),
            ("cooling_cold_shoulder", 0.0),
            ("cooling_cold_knee", 0.0),
            ("cooling_hot_knee", 0.0),
            ("cooling_hot_shoulder", 0.0),
            ("cooling_hot_tail", 0.0),
            ("hysteron_share", 0.0),
        ],
        &["hysteron_spread_k"],
    ),
    ("kinetic.unequal_slopes", &[("cooling_extra_k_per_mpa", 0.0)], &[]),
    ("kinetic.distributed", &[("spread_k", 0.0)], &[]),
    ("kinetic.lag", &[("seconds", 0.0)], &[]),
    ("kinetic.training_drift", &[("kelvin_per_cycle", 0.0)], &["settles_after_cycles"]),
    ("mechanical.friction", &[("coulomb_n", 0.0)], &[]),
    ("mechanical.capstan", &[("mu_theta", 0.0)], &[]),
    ("mechanical.ratcheting", &[("strain_per_cycle", 0.0)], &["settles_after_cycles"]),
    ("mechanical.frame_compliance", &[("compliance_m_per_n", 0.0)], &[]),
    ("mechanical.stress_dependent_strain", &[("stress_scale_mpa", 0.0)], &[]),
    ("mechanical.two_way", &[("strain", 0.0)], &[]),
    ("mechanical.phase_expansion", &[("austenite_extra_per_k", 0.0), ("martensite_extra_per_k", 0.0)], &[]),
    ("sensing.contact_resistance", &[("ohm", 0.0)], &[]),
    ("sensing.probe_deflection", &[("m_per_n", 0.0)], &[]),
    (
        "sensing.offset",
        &[("v1_v", 0.0), ("v2_v", 0.0), ("v3_v", 0.0), ("current_a", 0.0), ("force_n", 0.0), ("position_m", 0.0)],
        &[],
    ),
    ("sensing.gain", &[("v3", 1.0), ("current", 1.0), ("force", 1.0), ("position", 1.0)], &[]),
    ("sensing.delay", &[("seconds", 0.0)], &[]),
];

/// One setting of each mechanism of the catalogue and of other curves, of a size that rigs show.
pub fn settings() -> Vec<(&'static str, Vec<(&'static str, f64)>)> {
    vec![
        ("thermal.draught", vec![("gain", 0.4), ("start_s", 1.5), ("end_s", 3.5)]),
        ("thermal.natural_convection", vec![("exponent", 0.17)]),
        ("thermal.radiation", vec![("emissivity", 0.8)]),
        ("thermal.end_conduction", vec![("conductivity_w_per_m_k", 18.0)]),
        ("thermal.sheath", vec![("heat_capacity_j_per_k", 0.01), ("inner_w_per_k", 0.02), ("outer_w_per_k", 0.01)]),
        ("thermal.ambient_drift", vec![("rate_k_per_s", 0.8)]),
        ("thermal.neighbour", vec![("conductance_w_per_k", 2e-3)]),
        ("thermal.elastic_work", vec![("share", 2.0)]),
        ("electrical.supply_sag", vec![("source_ohm", 0.5)]),
        ("electrical.lead_resistance", vec![("lead_ohm", 0.4)]),
        ("electrical.resistivity_stress", vec![("austenite_per_gpa", 0.4), ("martensite_per_gpa", 0.2)]),
        ("electrical.poisson_area", vec![("ratio", 0.33)]),
        ("electrical.r_phase", vec![("peak_uohm_cm", 9.0), ("temperature_c", 60.0), ("width_k", 12.0)]),
        ("kinetic.asymmetry", vec![("heating_skew", 2.0), ("cooling_skew", 0.6)]),
        ("kinetic.curves", vec![("hysteron_share", 1.0), ("hysteron_spread_k", 4.0)]),
        ("kinetic.unequal_slopes", vec![("cooling_extra_k_per_mpa", -0.04)]),
        ("kinetic.distributed", vec![("spread_k", 5.0)]),
        ("kinetic.lag", vec![("seconds", 0.2)]),
        ("kinetic.training_drift", vec![("kelvin_per_cycle", 0.8), ("settles_after_cycles", 3.0)]),
        ("mechanical.friction", vec![("coulomb_n", 0.15)]),
        ("mechanical.capstan", vec![("mu_theta", 0.1)]),
        ("mechanical.ratcheting", vec![("strain_per_cycle", 3e-4)]),
        ("mechanical.frame_compliance", vec![("compliance_m_per_n", 3e-4)]),
        ("mechanical.stress_dependent_strain", vec![("stress_scale_mpa", 90.0)]),
        ("mechanical.two_way", vec![("strain", 0.006)]),
        ("mechanical.phase_expansion", vec![("austenite_extra_per_k", 4e-6), ("martensite_extra_per_k", -1.3e-5)]),
        ("sensing.contact_resistance", vec![("ohm", 0.3)]),
        ("sensing.probe_deflection", vec![("m_per_n", 5e-4)]),
        (
            "sensing.offset",
            vec![
                ("v1_v", 0.02),
                ("v2_v", 0.02),
                ("v3_v", 0.02),
                ("current_a", 0.01),
                ("force_n", 0.05),
                ("position_m", 1e-4),
            ],
        ),
        ("sensing.gain", vec![("v3", 1.02), ("current", 0.98), ("force", 1.03), ("position", 0.99)]),
        ("sensing.delay", vec![("seconds", 0.06)]),
    ]
}

/// Step of the integration, s, and after how many of them a row is kept.
const STEP_S: f64 = 4e-5;
const KEPT: usize = 1250;

/// What cycles of a rate each come to that dies away over so many of them; 0 = it does not.
fn settling(rate: f64, over: f64, cycles: f64) -> f64 {
    if over == 0.0 { rate * cycles } else { rate * over * (1.0 - (-cycles / over).exp()) }
}

/// The state of the explicit integration.
struct Explicit {
    temperature: f64,
    /// Per grain: ξ_eq.
    grains: Vec<f64>,
    martensite: f64,
    sleeve: f64,
    travel: f64,
    resistance: f64,
    strain: f64,
}

/// What a comparison looks at: T, ξ, x and R, V_3 and I.
fn seen(o: &Outputs) -> [f64; 6] {
    [o.temperature_c, o.martensite, o.position_m, o.resistance_ohm, o.v3_v, o.current_a]
}

/// Tension over time, N.
fn tension(t: f64) -> f64 {
    2.0 + 0.8 * (1.3 * t).sin()
}

/// Quantiles of the normal distribution, as many as grains: by bisection on its integral.
fn normal_quantiles(n: usize) -> Vec<f64> {
    let step = 1e-3;
    let mut integral = 0.0;
    let mut found = Vec::new();
    let mut z = -8.0;
    while found.len() < n {
        let middle: f64 = z + 0.5 * step;
        integral += step * (-0.5 * middle * middle).exp() / (2.0 * std::f64::consts::PI).sqrt();
        z += step;
        while found.len() < n && integral > (found.len() as f64 + 0.5) / n as f64 {
            found.push(z);
        }
    }
    // so few lack the tails: the spread is given, not the tails
    let deviation = (found.iter().map(|z| z * z).sum::<f64>() / n as f64).sqrt();
    found.iter().map(|z| z / deviation).collect()
}

/// Half-widths of 600 hysterons, in standard deviations, as many at each of the five that stand for a normal distribution as its
/// weight says: the roots of He₅ = x⁵ − 10x³ + 15x, with 5!/(5 He₄)².
fn hysterons() -> Vec<f64> {
    let outer = (5.0 + 10f64.sqrt()).sqrt();
    let inner = (5.0 - 10f64.sqrt()).sqrt();
    let weight = |x: f64| 120.0 / (5.0 * (x.powi(4) - 6.0 * x * x + 3.0)).powi(2);
    let roots = [-outer, -inner, 0.0, inner, outer];
    roots.iter().flat_map(|x| std::iter::repeat_n(*x, (600.0 * weight(*x)).round() as usize)).collect()
}

/// The catalogue's numbers of one model, in the rig file's units, by what the equations below call them.
struct Numbers {
    skew_heating: f64,
    skew_cooling: f64,
    extra_k_per_mpa: f64,
    lag_s: f64,
    drift_k: f64,
    drift_settles: f64,
    scale_mpa: f64,
    two_way: f64,
    elastic_work: f64,
    austenite_extra_per_k: f64,
    martensite_extra_per_k: f64,
    ratchet: f64,
    ratchet_settles: f64,
    frame_m_per_n: f64,
    austenite_per_gpa: f64,
    martensite_per_gpa: f64,
    poisson: f64,
    bump_uohm_cm: f64,
    bump_c: f64,
    bump_width_k: f64,
    contact_ohm: f64,
    draught_gain: f64,
    draught_start_s: f64,
    draught_end_s: f64,
    sheath_j_per_k: f64,
    sheath_inner_w_per_k: f64,
    sheath_outer_w_per_k: f64,
    exponent: f64,
    emissivity: f64,
    warming_k_per_s: f64,
    between_w_per_k: f64,
}

impl Numbers {
    fn of(get: &dyn Fn(&str, &str) -> f64) -> Numbers {
        Numbers {
            skew_heating: get("kinetic.asymmetry", "heating_skew"),
            skew_cooling: get("kinetic.asymmetry", "cooling_skew"),
            extra_k_per_mpa: get("kinetic.unequal_slopes", "cooling_extra_k_per_mpa"),
            lag_s: get("kinetic.lag", "seconds"),
            drift_k: get("kinetic.training_drift", "kelvin_per_cycle"),
            drift_settles: get("kinetic.training_drift", "settles_after_cycles"),
            scale_mpa: get("mechanical.stress_dependent_strain", "stress_scale_mpa"),
            two_way: get("mechanical.two_way", "strain"),
            elastic_work: get("thermal.elastic_work", "share"),
            austenite_extra_per_k: get("mechanical.phase_expansion", "austenite_extra_per_k"),
            martensite_extra_per_k: get("mechanical.phase_expansion", "martensite_extra_per_k"),
            ratchet: get("mechanical.ratcheting", "strain_per_cycle"),
            ratchet_settles: get("mechanical.ratcheting", "settles_after_cycles"),
            frame_m_per_n: get("mechanical.frame_compliance", "compliance_m_per_n"),
            austenite_per_gpa: get("electrical.resistivity_stress", "austenite_per_gpa"),
            martensite_per_gpa: get("electrical.resistivity_stress", "martensite_per_gpa"),
            poisson: get("electrical.poisson_area", "ratio"),
            bump_uohm_cm: get("electrical.r_phase", "peak_uohm_cm"),
            bump_c: get("electrical.r_phase", "temperature_c"),
            bump_width_k: get("electrical.r_phase", "width_k"),
            contact_ohm: get("sensing.contact_resistance", "ohm"),
            draught_gain: get("thermal.draught", "gain"),
            draught_start_s: get("thermal.draught", "start_s"),
            draught_end_s: get("thermal.draught", "end_s"),
            sheath_j_per_k: get("thermal.sheath", "heat_capacity_j_per_k"),
            sheath_inner_w_per_k: get("thermal.sheath", "inner_w_per_k"),
            sheath_outer_w_per_k: get("thermal.sheath", "outer_w_per_k"),
            exponent: get("thermal.natural_convection", "exponent"),
            emissivity: get("thermal.radiation", "emissivity"),
            warming_k_per_s: get("thermal.ambient_drift", "rate_k_per_s"),
            between_w_per_k: get("thermal.neighbour", "conductance_w_per_k"),
        }
    }
}

/// The contract's equations with the numbers of one model.
struct Equations<'a> {
    model: &'a WireModel,
    /// Where each grain transforms besides the mean, and how much wider its loop is to either side, K.
    offsets: Vec<(f64, f64)>,
    /// Heat capacity m c_p, J/K.
    capacity: f64,
    /// In series with the wire, Ω.
    circuit: f64,
    numbers: Numbers,
    neighbour_c: f64,
}

impl<'a> Equations<'a> {
    fn new(model: &'a WireModel, neighbour_c: f64) -> Equations<'a> {
        let (m, g) = (&model.material, &model.geometry);
        let get = |id: &str, key: &str| -> f64 {
            let row = effect(id).unwrap();
            row.parameters.iter().find(|p| p.key == key).unwrap().get(model)
        };
        let numbers = Numbers::of(&get);
        let spread = get("kinetic.distributed", "spread_k");
        Equations {
            model,
            offsets: match (spread > 0.0, get("kinetic.curves", "hysteron_share") > 0.0) {
                (true, _) => normal_quantiles(41).iter().map(|z| (z * spread, 0.0)).collect(),
                (_, true) => {
                    let wider = get("kinetic.curves", "hysteron_spread_k");
                    hysterons().iter().map(|z| (0.0, z * wider)).collect()
                }
                _ => vec![(0.0, 0.0)],
            },
            capacity: m.density_kg_per_m3 * g.volume_m3() * m.specific_heat_j_per_kg_k,
            circuit: model.drive.shunt_ohm
                + model.drive.switch_ohm
                + get("electrical.supply_sag", "source_ohm")
                + get("electrical.lead_resistance", "lead_ohm")
                + numbers.contact_ohm,
            numbers,
            neighbour_c,
        }
    }

    /// ξ_eq held between the curves: the outer loop alone (w = 1).
    fn clipped(&self, xi: f64, (offset, wider): (f64, f64), theta: f64, stress: f64) -> f64 {
        let m = &self.model.material;
        let curve = |k: f64, centre: f64, skew: f64| {
            (1.0 + skew * (k * (theta - offset - centre)).min(300.0).exp()).powf(-1.0 / skew)
        };
        let extra = self.numbers.extra_k_per_mpa * 1e-6;
        let (heating_c, cooling_c) = (m.austenite_temperature_c + wider, m.martensite_temperature_c - wider);
        let upper = curve(m.heating_steepness_per_k, heating_c, self.numbers.skew_heating);
        let lower = curve(m.cooling_steepness_per_k, cooling_c + extra * stress, self.numbers.skew_cooling);
        xi.max(lower).min(upper)
    }

    /// Shape strain of full martensite under a stress, but for the two-way strain.
    fn oriented(&self, stress: f64) -> f64 {
        let scale = self.numbers.scale_mpa * 1e6;
        self.model.material.transformation_strain * if scale > 0.0 { 1.0 - (-stress / scale).exp() } else { 1.0 }
    }

    /// Strain and resistance of a state.
    fn measure(&self, s: &mut Explicit, stress: f64) {
        let (m, g) = (&self.model.material, &self.model.geometry);
        let xi = s.martensite;
        let compliance = (1.0 - xi) / m.austenite_modulus_pa + xi / m.martensite_modulus_pa;
        let warm = s.temperature - m.reference_temperature_c;
        let two_way = self.numbers.two_way;
        s.strain = compliance * (stress + m.thermoelastic_pa_per_k * warm)
            + (self.oriented(stress) + two_way) * xi
            + ((1.0 - xi) * self.numbers.austenite_extra_per_k + xi * self.numbers.martensite_extra_per_k) * warm
            + settling(self.numbers.ratchet, self.numbers.ratchet_settles, 0.5 * s.travel);
        let austenite = (m.austenite_resistivity_ohm_m + m.austenite_resistivity_slope_ohm_m_per_k * warm)
            * (1.0 + self.numbers.austenite_per_gpa * 1e-9 * stress);
        let martensite = (m.martensite_resistivity_ohm_m + m.martensite_resistivity_slope_ohm_m_per_k * warm)
            * (1.0 + self.numbers.martensite_per_gpa * 1e-9 * stress);
        let z = (s.temperature - self.numbers.bump_c) / self.numbers.bump_width_k;
        let resistivity =
            (1.0 - xi) * austenite + xi * martensite + self.numbers.bump_uohm_cm * 1e-8 * (-0.5 * z * z).exp() * xi;
        let narrow = 1.0 - self.numbers.poisson * stress * compliance;
        s.resistance = resistivity * g.length_m * (1.0 + s.strain) / (g.area_m2() * narrow * narrow);
    }

    /// At rest, cold, under the first tension.
    fn start(&self) -> Explicit {
        let (m, start) = (&self.model.material, self.stress(0.0));
        let theta = self.model.ambient_c - m.stress_shift_k_per_pa * start;
        let grains: Vec<f64> = self.offsets.iter().map(|offset| self.clipped(1.0, *offset, theta, start)).collect();
        let mut s = Explicit {
            temperature: self.model.ambient_c,
            martensite: mean(&grains),
            grains,
            sleeve: self.model.ambient_c,
            travel: 0.0,
            resistance: 0.0,
            strain: 0.0,
        };
        self.measure(&mut s, start);
        s
    }

    fn stress(&self, t: f64) -> f64 {
        tension(t) / self.model.geometry.area_m2()
    }

    /// Heat that leaves at the time `t`, W; the sleeve takes its share over a step.
    fn loss(&self, s: &mut Explicit, t: f64) -> f64 {
        let surface = self.model.geometry.surface_m2();
        let ambient = self.model.ambient_c + self.numbers.warming_k_per_s * t;
        let above = s.temperature - ambient;
        // from 10 % to 90 % in 0.15 s, as a ramp
        let edge = |since: f64| (0.5 + since / 0.1875).clamp(0.0, 1.0);
        let window = 1.0
            + self.numbers.draught_gain
                * (edge(t - self.numbers.draught_start_s) - edge(t - self.numbers.draught_end_s));
        let capacity = self.numbers.sheath_j_per_k;
        let mut loss = if capacity > 0.0 {
            let inner = self.numbers.sheath_inner_w_per_k * (s.temperature - s.sleeve);
            s.sleeve += STEP_S / capacity * (inner - self.numbers.sheath_outer_w_per_k * (s.sleeve - ambient));
            inner
        } else {
            let exponent = self.numbers.exponent;
            self.model.material.convection_w_per_m2_k * surface * window * (above.abs() / 60.0).powf(exponent) * above
        };
        let kelvin = |c: f64| (c + 273.15).powi(4);
        let emissivity = self.numbers.emissivity;
        loss += emissivity * 5.670374419e-8 * surface * (kelvin(s.temperature) - kelvin(ambient));
        loss + self.numbers.between_w_per_k * (s.temperature - self.neighbour_c)
    }

    /// ξ at a temperature at the end of the step that begins in `s`; the grains go along.
    fn phase(&self, s: &Explicit, temperature: f64, stress: f64, grains: &mut [f64]) -> f64 {
        let shift = settling(self.numbers.drift_k, self.numbers.drift_settles, 0.5 * s.travel);
        let lag = self.numbers.lag_s;
        for (i, offset) in self.offsets.iter().enumerate() {
            let theta = temperature - self.model.material.stress_shift_k_per_pa * stress - shift;
            grains[i] = self.clipped(s.grains[i], *offset, theta, stress);
        }
        let equilibrium = mean(grains);
        if lag > 0.0 { s.martensite + STEP_S / lag * (equilibrium - s.martensite) } else { equilibrium }
    }

    /// One step from the time `t`.
    fn step(&self, s: &mut Explicit, t: f64) {
        let (m, g) = (&self.model.material, &self.model.geometry);
        let stress = self.stress(t + STEP_S);
        let current = self.current(s);
        let power = duty(t + 0.5 * STEP_S) * current * current * s.resistance;
        let loss = self.loss(s, t);
        // T and ξ together: m c_p ΔT = heat + (m ΔH + V ε σ) Δξ, by Newton on T with the slope taken numerically
        let mass = m.density_kg_per_m3 * g.volume_m3();
        let two_way = self.numbers.two_way;
        let softer = 1.0 / m.martensite_modulus_pa - 1.0 / m.austenite_modulus_pa;
        let elastic = self.numbers.elastic_work * 0.5 * stress * softer;
        let released =
            mass * m.latent_heat_j_per_kg + g.volume_m3() * stress * (self.oriented(stress) + two_way + elastic);
        let heated = s.temperature + STEP_S * (power - loss) / self.capacity;
        let mut grains = s.grains.clone();
        let mut temperature = s.temperature;
        for _ in 0..6 {
            let at = |t: f64, grains: &mut [f64]| {
                t - heated - released / self.capacity * (self.phase(s, t, stress, grains) - s.martensite)
            };
            let error = at(temperature, &mut grains);
            let slope = (at(temperature + 1e-6, &mut grains) - error) / 1e-6;
            temperature -= error / slope.max(1.0);
            if error.abs() < 1e-10 {
                break;
            }
        }
        let martensite = self.phase(s, temperature, stress, &mut grains);
        s.travel += (martensite - s.martensite).abs();
        (s.temperature, s.martensite, s.grains) = (temperature, martensite, grains);
        self.measure(s, stress);
    }

    fn current(&self, s: &Explicit) -> f64 {
        self.model.drive.supply_v / (s.resistance + self.circuit)
    }

    /// What the simulator's outputs are compared with, at the time `t`.
    fn row(&self, s: &Explicit, t: f64) -> [f64; 6] {
        let g = &self.model.geometry;
        let frame = self.numbers.frame_m_per_n;
        let current = self.current(s);
        let position = g.length_m * s.strain + frame * g.area_m2() * self.stress(t);
        [
            s.temperature,
            s.martensite,
            position,
            s.resistance,
            current * (s.resistance + self.numbers.contact_ohm),
            current,
        ]
    }
}

fn mean(grains: &[f64]) -> f64 {
    grains.iter().sum::<f64>() / grains.len() as f64
}

fn explicitly(model: &WireModel, seconds: f64, neighbour_c: f64) -> Vec<[f64; 6]> {
    let equations = Equations::new(model, neighbour_c);
    let mut s = equations.start();
    let mut rows = Vec::new();
    for k in 0..(seconds / STEP_S).round() as usize {
        let t = k as f64 * STEP_S;
        equations.step(&mut s, t);
        if (k + 1) % KEPT == 0 {
            rows.push(equations.row(&s, t + STEP_S));
        }
    }
    rows
}

fn simulated(model: &WireModel, seconds: f64, neighbour_c: f64) -> Vec<[f64; 6]> {
    let dt = 1e-3;
    let at = |t: f64| Inputs { drive: duty(t - 0.5 * dt), imposed: tension(t), ..model.rest_inputs() };
    let mut wire = Wire::with_inputs(model, &at(0.0)).expect("a valid model");
    wire.set_neighbour_c(neighbour_c);
    (1..=(seconds / dt).round() as usize)
        .filter_map(|k| {
            wire.step(&at(k as f64 * dt), dt);
            (k % 50 == 0).then(|| seen(&wire.outputs()))
        })
        .collect()
}

/// What each term changes, by the simulator and by the explicit integration of the equations.
#[test]
fn terms_agree_with_an_explicit_integration_of_their_equations() {
    let mut model = WireModel { load: Load::ImposedForce, ..hanging() };
    model.material.outer_loop_weight = 1.0;
    let (plain, expected_plain) = (simulated(&model, 4.5, 60.0), explicitly(&model, 4.5, 60.0));
    let mut wrong = Vec::new();
    for (id, values) in settings() {
        let elsewhere = ["thermal.end_conduction", "mechanical.friction", "mechanical.capstan"];
        if elsewhere.contains(&id) || (id.starts_with("sensing.") && id != "sensing.contact_resistance") {
            continue;
        }
        let on = set_all(&model, id, &values);
        let (got, expected) = (simulated(&on, 4.5, 60.0), explicitly(&on, 4.5, 60.0));
        for i in 0..6 {
            let mut size = 0.0f64;
            let mut error = 0.0f64;
            for k in 0..got.len() {
                let (got, expected) = (got[k][i] - plain[k][i], expected[k][i] - expected_plain[k][i]);
                size = size.max(expected.abs());
                error = error.max((got - expected).abs());
            }
            let range = [100.0, 1.0, 7e-3, 2.0, 6.0, 1.0][i];
            if error > 0.02 * size + 1e-4 * range {
                wrong.push(format!("{id} column {i}: off by {error} of {size}"));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}
